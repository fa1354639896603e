/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The potential that cnn-energy shows: the network's own equation cell by cell, its limit K, and
 * the network in its own time, which comes to the same.
 */
#include "common/test.h"

#include "rt/memory.h"
#include "rt/thread.h"
#include "touch_fixture.h"

#define RADIUS     0.006
#define PRETENSION 0.1 /* J */

static void setup_touch(setup *s, ss_model_tool *tool, int32_t steps, double saturation, bool one)
{
    setup_init(s, "cnn-energy", make_plate(16, 0.08));
    hold_rim(s, 16);
    give_skin(s);
    give(s, "pretension_j", one ? 0.0 : PRETENSION);
    if (steps > 0) {
        give(s, "solver", 1.0);
        give(s, "relaxation_steps", steps);
    }
    if (saturation > 0.0) {
        give(s, "saturation", saturation);
    }
    give(s, "source", one ? 1.0 : 0.0);
    add_sphere(s, 0, RADIUS);
    s->plan.contact_stiffness = 2e7;
    create(s);
    for (int n = 0; n <= 160; ++n) {
        go(tool, 0.0005, 0.0007, RADIUS + 0.001 - 0.004 * fmin(1.0, n / 60.0));
        step_tools(s, 1e-3, tool);
    }
}

/* Of every node; freed by the caller. */
static float *potential_of(const setup *s)
{
    const size_t n = (size_t)s->mesh->node_count;
    float *source = ss_memory_get(n, sizeof *source), *out = ss_memory_get(n, sizeof *out);
    assert_non_null(s->class->potential);
    s->class->potential->tell(s->model, source);
    assert_true(s->class->potential->find(s->model, source, out));
    ss_memory_free(source);
    return out;
}

static float largest_of(const setup *s, const float *value, int32_t *out_node)
{
    *out_node = 0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        *out_node = value[i] > value[*out_node] ? i : *out_node;
    }
    return value[*out_node];
}

/* sum_j c_ij (v_i - v_j) is what flows out of a cell: nothing where nothing is touched, and in
 * all the strengths of the touched cells, which the held ones take up. */
TEST(what_flows_into_touched_cells_flows_out_at_held_ones)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_touch(&s, tool, 0, 0.0, false);
    const ss_cnn_network *network = s.model->network;
    const ss_cnn_tool *touching = &s.model->tool[0];
    float *v = potential_of(&s);
    double *flow = ss_memory_get((size_t)s.mesh->node_count, sizeof *flow);
    double wanted = 0.0, held = 0.0;
    int32_t top = 0;
    const double largest = (double)largest_of(&s, v, &top);
    assert_true(largest > 0.0);
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        const double q = network->edge_weight[e] * ((double)v[i] - (double)v[j]);
        flow[i] += q;
        flow[j] -= q;
    }
    for (int32_t k = 0; k < touching->count; ++k) {
        const int32_t i = touching->node[k];
        const double strength = touching->source.amplitude *
                                (touching->source.modulus * touching->source.stretch + PRETENSION) *
                                touching->weight[k] / touching->weight_sum / network->qhat[i] *
                                network->size[i];
        assert_near(flow[i], strength, 1e-5 * largest);
        wanted += strength;
        flow[i] = 0.0;
    }
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        if (s.fixed[i] != 0) {
            assert_true(v[i] == 0.0F);
            held -= flow[i];
        } else {
            assert_near(flow[i], 0.0, 1e-5 * largest);
        }
    }
    assert_near(held / wanted, 1.0, 1e-4);
    for (int32_t k = 0, is_touched = 0; k <= touching->count; ++k) {
        is_touched = is_touched || k == touching->count || touching->node[k] == top;
        assert_true(k < touching->count || is_touched);
    }
    ss_memory_free(flow);
    ss_memory_free(v);
    setup_fini(&s);
}

TEST(a_cell_at_its_limit_has_the_potential_k)
{
    double limit = 0.0;
    for (int is_limited = 0; is_limited < 2; ++is_limited) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        int32_t top = 0;
        setup_touch(&s, tool, 0, limit, true);
        float *v = potential_of(&s);
        const double largest = (double)largest_of(&s, v, &top);
        if (is_limited) {
            assert_near(largest / limit, 1.0, 1e-5);
            assert_int_equal(top, s.model->tool[0].cell.node);
        }
        limit = 0.5 * largest;
        ss_memory_free(v);
        setup_fini(&s);
    }
}

TEST(the_network_in_its_own_time_comes_to_the_same_potential)
{
    setup s, quick;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}}, same[SOFTSIM_MAX_PROBES] = {{0}};
    int32_t top = 0;
    setup_touch(&s, tool, 0, 0.0, false);
    setup_touch(&quick, same, 60, 0.0, false);
    float *v = potential_of(&s), *w = potential_of(&quick);
    const float largest = largest_of(&s, v, &top);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        assert_near((double)(w[i] / largest), (double)(v[i] / largest), 2e-3);
    }
    ss_memory_free(v);
    ss_memory_free(w);
    setup_fini(&s);
    setup_fini(&quick);
}

TEST(untouched_tissue_has_none)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    int32_t top = 0;
    setup_touch(&s, tool, 0, 0.0, false);
    s.class->reset(s.model);
    memset(tool, 0, sizeof tool);
    step_tools(&s, 1e-3, tool);
    float *v = potential_of(&s);
    assert_true(largest_of(&s, v, &top) == 0.0F);
    ss_memory_free(v);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
