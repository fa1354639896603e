/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy with its network in its own time, under tools and loads, held and free; what of it is
 * refused, and what it tells. The network itself: test_cnn_relax.c.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/note_fixture.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/thread.h"
#include "touch_fixture.h"

/* ---- tools ---- */

#define PLATE_RADIUS 0.006

static void setup_relaxing(setup *s, double steps_a_substep)
{
    setup_init(s, "cnn-energy", make_plate(16, 0.08));
    hold_rim(s, 16);
    give_skin(s);
    give(s, "pretension_j", 0.1);
    if (steps_a_substep > 0.0) {
        give(s, "solver", 1.0);
        give(s, "relaxation_steps", steps_a_substep);
    }
    add_sphere(s, 0, PLATE_RADIUS);
    s->plan.contact_stiffness = 2e7;
}

static int32_t states_in_use(const setup *s)
{
    int32_t count = 0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        count += s->model->relax->slot_of[i] >= 0;
    }
    return count;
}

TEST(cells_spread_while_touched_and_start_anew_after)
{
    SKIP_WHERE_REPEATED();
    setup settled, s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}}, same[SOFTSIM_MAX_PROBES] = {{0}};
    setup_relaxing(&settled, 0.0);
    setup_relaxing(&s, 1.0);
    create(&settled);
    create(&s);
    double quick = 0.0;
    for (int n = 1; n <= 1600; ++n) {
        const double down = fmin(1.0, n / 60.0);
        go(tool, 0.0005, 0.0007, PLATE_RADIUS + 0.001 - 0.005 * down);
        go(same, 0.0005, 0.0007, PLATE_RADIUS + 0.001 - 0.005 * down);
        step_tools(&s, 1e-3, tool);
        step_tools(&settled, 1e-3, same);
        quick = n == 60 ? s.model->tools.tool[0].force[2] / settled.model->tools.tool[0].force[2]
                        : quick;
    }
    assert_true(quick > 0.9 && quick < 0.98); /* a quick press meets a network not yet settled */
    assert_int_equal(states_in_use(&s), s.model->tool[0].count);
    assert_near(s.model->tools.tool[0].force[2] / settled.model->tools.tool[0].force[2], 1.0,
                BY_TYPE(1e-4, 1e-5));
    const double pressed = info_of(&s).elastic;
    assert_near(energy_gain(&s) / pressed, 0.0, 5e-3);
    for (int n = 1; n <= 300; ++n) { /* slides on: new cells join from 0 as others are let go */
        go(tool, 0.0005 + 5e-5 * n, 0.0007, PLATE_RADIUS - 0.004);
        step_tools(&s, 1e-3, tool);
        assert_true(states_in_use(&s) <= s.model->tool[0].count + 2);
    }
    assert_near(energy_gain(&s) / pressed, 0.0, 5e-3);
    for (int n = 1; n <= 400; ++n) {
        go(tool, 0.0155, 0.0007, fmin(0.03, PLATE_RADIUS - 0.004 + 1e-4 * n));
        step_tools(&s, 1e-3, tool);
    }
    assert_int_equal(states_in_use(&s), 0);
    assert_near(energy_gain(&s) / pressed, 0.0, 5e-3);
    assert_true(largest_displacement(&s) < 1e-6);
    assert_int_equal(info_of(&s).fault_bits, 0);
    go(tool, 0.0155, 0.0007, PLATE_RADIUS - 0.001); /* a new touch starts from 0 */
    step_tools(&s, 1e-3, tool);
    const int32_t cell = s.model->tool[0].node[0];
    const double own = ss_cnn_relax_potential(s.model->relax, s.model->relax->slot_of[cell], cell);
    assert_true(own > 0.0 && own < 0.9 * s.model->network->own[cell]);
    setup_fini(&settled);
    setup_fini(&s);
}

static uint64_t hash_after_press(setup *s)
{
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    for (int n = 1; n <= 150; ++n) {
        go(tool, 0.0005 + 3e-5 * n, 0.0007, PLATE_RADIUS + 0.001 - 3e-5 * n);
        step_tools(s, 1e-3, tool);
    }
    return hash_of(s);
}

TEST(equal_runs_give_equal_bits_also_after_a_reset)
{
    uint64_t hash[4];
    for (int k = 0; k < 3; ++k) {
        setup s;
        setup_relaxing(&s, k == 2 ? 4.0 : 3.0);
        s.plan.threads = k + 1;
        create(&s);
        const int64_t bytes = ss_memory_in_use();
        hash[k] = hash_after_press(&s);
        if (k == 1) {
            s.class->reset(s.model);
            s.time = 0.0;
            hash[3] = hash_after_press(&s);
        }
        assert_true(ss_memory_in_use() == bytes);
        setup_fini(&s);
    }
    assert_true(hash[0] == hash[1] && hash[0] == hash[3]);
    assert_true(hash[0] != hash[2]);
}

/* ---- everything at once ---- */

enum { FREE = 1, RELAXED = 2, ONE_CELL = 4, SATURATED = 8 };

/* A body under two tools and two loads that come and go. */
static void setup_crowd(setup *s, int kind, int32_t *pushed)
{
    setup_init(s, "cnn-energy", make_ellipsoid(5, 0.05, 0.04, 0.03));
    pushed[0] = pushed[1] = 0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        const double *x = s->mesh->position[i];
        s->fixed[i] = (kind & FREE) == 0 && x[2] < -0.02 ? 7 : 0;
        pushed[0] = x[0] > s->mesh->position[pushed[0]][0] ? i : pushed[0];
        pushed[1] = x[0] < s->mesh->position[pushed[1]][0] ? i : pushed[1];
    }
    give_skin(s);
    if ((kind & RELAXED) != 0) {
        give(s, "solver", 1.0);
        give(s, "relaxation_steps", 5.0);
    }
    give(s, "source", (kind & ONE_CELL) != 0 ? 1.0 : 0.0);
    if ((kind & SATURATED) != 0) {
        give(s, "saturation", 2e-6);
    }
    for (int k = 0; k < 2; ++k) {
        add_sphere(s, k, 0.01);
        push(s, &pushed[k], k == 0 ? 0.4 : -0.4, 0.0, 0.02);
        s->load[k].ramp = 0.05;
        s->load[k].to = 0.3;
    }
    s->plan.contact_stiffness = 5e6;
}

static void momentum_of(const setup *s, double out[3])
{
    const ss_real *v = s->class->velocity(s->model);
    ss_set3(out, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            out[k] += s->model->material.mass[i] * (double)v[4 * (ptrdiff_t)i + k];
        }
    }
}

TEST(two_tools_and_loads_keep_the_energy_balance_whatever_is_chosen)
{
    SKIP_WHERE_REPEATED();
    for (int kind = 0; kind < 16; ++kind) {
        setup s;
        int32_t pushed[2];
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        double largest = 0.0, worst = 0.0;
        int saturated = 0, touched = 0;
        setup_crowd(&s, kind, pushed);
        create(&s);
        assert_true(((kind & SATURATED) != 0) == (s.model->saturation != NULL));
        assert_true(((kind & RELAXED) != 0) == (s.model->relax != NULL));
        for (int n = 1; n <= 450; ++n) { /* squeezes from above and below, slides, lets go */
            const double way = 0.5 - 0.5 * cos(SS_PI * fmin(1.0, n / 100.0)) -
                               (0.5 - 0.5 * cos(SS_PI * fmax(0.0, fmin(1.0, (n - 200) / 100.0))));
            const double along = 0.004 * sin(SS_PI * n / 150.0);
            go(&tool[0], along, 0.001, 0.054 - 0.018 * way);
            go(&tool[1], (kind & FREE) != 0 ? -along : 0.012,
               (kind & FREE) != 0 ? 0.0 : 0.02 + along,
               (kind & FREE) != 0 ? -0.054 + 0.018 * way : 0.05 - 0.019 * way);
            step_tools(&s, 1e-3, tool);
            largest = fmax(largest, info_of(&s).elastic);
            worst = fmax(worst, fabs(energy_gain(&s)));
            saturated += s.model->source[0].stretch < 0.99 * s.model->source[0].eps;
            touched += s.model->tool[0].source.is_on && s.model->tool[1].source.is_on;
        }
        assert_true(touched > 80);
        assert_true(((kind & SATURATED) != 0) == (saturated > 50));
        assert_int_equal(info_of(&s).fault_bits, 0);
        assert_true(worst < 2e-3 * largest);
        assert_int_equal(s.model->tool[0].count + s.model->tool[1].count, 0);
        for (int n = 0; n < 800; ++n) {
            step_tools(&s, 1e-3, tool);
        }
        if ((kind & FREE) == 0) {
            assert_true(largest_displacement(&s) < 1e-6);
        } else { /* it has its shape again, wherever it is */
            for (int32_t i = 0; i < s.mesh->node_count; ++i) {
                for (int k = 0; k < 3; ++k) {
                    assert_near((double)s.model->d[4 * (ptrdiff_t)i + k], 0.0, 1e-6);
                }
            }
        }
        setup_fini(&s);
    }
}

TEST(free_bodies_move_by_what_pushes_them)
{
    for (int kind = FREE; kind < 16; kind += 2) {
        setup s;
        int32_t pushed[2];
        setup_crowd(&s, kind, pushed);
        give(&s, "damping_n_s_per_m3", 0.0);
        s.load[1].force[0] = 0.1; /* they do not cancel */
        create(&s);
        steps(&s, 200, 1e-3);
        double p[3];
        momentum_of(&s, p);
        assert_near(p[0], (0.4 + 0.1) * 0.175, 1e-5); /* p = F t, less half of the ramp */
        assert_near(p[1], 0.0, 1e-6);
        assert_near(p[2], (0.02 + 0.02) * 0.175, 1e-6);
        setup_fini(&s);
    }
}

/* ---- the interface ---- */

TEST(steps_without_relaxation_and_cells_without_area_are_refused)
{
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 1.0);
    give(&s, "relaxation_steps", 5.0);
    push(&s, &top, 0.0, -0.1, 0.0);
    expect_refusal(&s, SOFTSIM_ERROR_SCENE, "relaxation_steps goes with solver: relaxation");
    static const double bad[3] = {0.0, 1e6, (double)NAN};
    for (int k = 0; k < 3; ++k) {
        setup_cylinder(&s, 1.0);
        give(&s, "solver", 1.0);
        give(&s, "relaxation_steps", bad[k]);
        push(&s, &top, 0.0, -0.1, 0.0);
        expect_refusal(&s, SOFTSIM_ERROR_SCENE, "relaxation_steps must be 1 to 10000");
    }

    draft d;
    draft_init(&d, 5, 4);
    draft_node(&d, 0.0, 0.0, 0.0);
    draft_node(&d, 1.0, 0.0, 0.0);
    draft_node(&d, 0.0, 1.0, 0.0);
    draft_node(&d, 0.5, 0.0, 0.0); /* on the edge, its triangle is flat */
    draft_triangle(&d, 0, 1, 2);
    draft_triangle(&d, 0, 3, 1);
    setup_init(&s, "cnn-energy", draft_finish(&d));
    s.fixed[1] = 7;
    give(&s, "modulus_j", 5.0);
    per_node(&s, 1.0, 1.0, 1.0);
    give(&s, "solver", 1.0);
    int32_t corner = 2;
    push(&s, &corner, 0.0, 0.0, 0.1);
    expect_refusal(&s, SOFTSIM_ERROR_MESH, "(first 3)");
}

TEST(too_many_states_are_refused_before_they_are_solved)
{
    setup s;
    setup_init(&s, "cnn-energy", make_plate(70, 0.2));
    give_skin(&s);
    give(&s, "solver", 1.0);
    add_sphere(&s, 0, PLATE_RADIUS);
    expect_refusal(&s, SOFTSIM_ERROR_UNSUPPORTED, "5041 cells");
}

TEST(cost_and_explanation_count_the_networks_steps)
{
    double cost[4];
    for (int k = 0; k < 4; ++k) {
        setup s;
        setup_relaxing(&s, k == 0 ? 0.0 : k == 1 ? 10.0 : k == 2 ? 20.0 : 30.0);
        create(&s);
        cost[k] = s.class->step_cost_us(&s.plan);
        const struct {
            ss_note_kind kind;
            const char *where;
            bool is_relaxing;
        } rows[] = {{SS_NOTE_LEFT_OUT, "the network's own time", false},
                    {SS_NOTE_USED, "network in its own time", true},
                    {SS_NOTE_LEFT_OUT, "settled influence functions", true}};
        for (int i = 0; i < 3; ++i) {
            assert_int_equal(note_count(s.class, s.model, rows[i].kind, rows[i].where, ""),
                             rows[i].is_relaxing == (k > 0));
        }
        setup_fini(&s);
    }
    assert_true(cost[1] > 1.5 * cost[0]);
    assert_near(cost[3] - cost[2], cost[2] - cost[1], 1e-9);
    assert_true(cost[2] - cost[1] > 0.5 * cost[0]);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
