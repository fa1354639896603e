/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy with its network in its own time: the literal equations, how far the field is from
 * the settled one, saturation, energy. Tools on it, and what is refused: test_cnn_relax_touch.c.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/model_fixture.h"
#include "oracles/literal_network.h"
#include "rt/thread.h"

/* A body of uneven rho whose network goes `steps` of its own a sub-step. */
static void setup_relaxed(setup *s, double steps_a_substep)
{
    static double rho[2000];
    setup_cylinder(s, 1.0);
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        rho[i] = 0.05 * (1.0 + 0.5 * sin(3.0 * s->mesh->position[i][2] + i % 24));
    }
    give_field(s, "rho", rho);
    give(s, "solver", 1.0);
    give(s, "relaxation_steps", steps_a_substep);
}

/* A cylinder that relaxes by so many steps, pushed at one node. */
static void setup_pushed(setup *s, int32_t *node, double relaxation_steps)
{
    setup_cylinder(s, 2.0);
    give(s, "solver", 1.0);
    give(s, "relaxation_steps", relaxation_steps);
    push(s, node, 0.0, -0.5, 0.0);
}

TEST(states_follow_the_literal_network_for_any_resistance)
{
    for (int trial = 0; trial < 2; ++trial) {
        setup s;
        literal net;
        int32_t top = TOP, other = TOP + 50;
        const ss_real *column[2];
        setup_relaxed(&s, 1.0);
        push(&s, &top, 0.0, -0.1, 0.0);
        push(&s, &other, 0.0, -0.1, 0.0);
        create(&s);
        ss_cnn_relax *relax = s.model->relax;
        const int32_t cell[2] = {top, other};
        double *current = calloc((size_t)s.mesh->node_count, sizeof *current);
        current[other] = 1.0;
        literal_init(&net, &s, trial == 0 ? 0.8 : 40.0, (double)INFINITY);
        ss_cnn_relax_look(relax);
        ss_cnn_relax_influence(relax, 2, cell, column);
        for (int k = 0; k < 120; ++k) {
            ss_cnn_relax_advance(relax);
            literal_step(&net, current, relax->step);
        }
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            assert_near(ss_cnn_relax_potential(relax, relax->slot_of[other], i), net.v[i],
                        1e-12 * relax->step * 120);
        }
        free(current);
        literal_fini(&net);
        setup_fini(&s);
    }
}

TEST(the_step_is_below_the_limit_of_the_fastest_mode)
{
    setup s;
    literal net;
    int32_t top = TOP;
    setup_relaxed(&s, 1.0);
    push(&s, &top, 0.0, -0.1, 0.0);
    create(&s);
    const int32_t n = s.mesh->node_count;
    double *current = calloc((size_t)n, sizeof *current), rate = 0.0;
    literal_init(&net, &s, 1.0, (double)INFINITY);
    random_state = 2;
    for (int32_t i = 0; i < n; ++i) {
        net.v[i] = random_unit();
    }
    for (int round = 0; round < 300; ++round) { /* v := A v, over its size */
        double norm = 0.0;
        literal_step(&net, current, 0.0);
        for (int32_t i = 0; i < n; ++i) {
            net.v[i] = s.fixed[i] == 7 ? 0.0 : -net.flow[i];
            norm += net.v[i] * net.v[i];
        }
        rate = sqrt(norm);
        for (int32_t i = 0; i < n; ++i) {
            net.v[i] /= rate;
        }
    }
    assert_true(s.model->relax->step * rate < 2.0);
    assert_true(s.model->relax->step * rate > 1.0); /* and not far below */
    free(current);
    literal_fini(&net);
    setup_fini(&s);
}

/* ---- progress of the field ---- */

/* Steps until the field of `cell` is within 1e-3 and 1e-6 of the settled one, by S / rho; the
 * error must fall at every step. */
static void count_steps(setup *s, int32_t cell, int32_t out_steps[2], double *out_residual)
{
    const ss_cnn_network *network = s->model->network;
    ss_cnn_relax *relax = s->model->relax;
    const int32_t n = s->mesh->node_count;
    const bool is_drained = network->factor->is_drained[network->factor->component[cell]];
    double *field = calloc((size_t)n, sizeof *field), *v = calloc((size_t)n, sizeof *v);
    const double one = 1.0;
    const ss_real *column;
    double total = 0.0, mean = 0.0, size = 0.0, last = (double)INFINITY;
    assert_int_equal(ss_cnn_network_potential(network, 1, &cell, &one, field), SOFTSIM_OK);
    for (int32_t i = 0; i < n; ++i) {
        total += network->size[i] / literal_rho(s, i);
        mean += network->size[i] / literal_rho(s, i) * field[i];
    }
    for (int32_t i = 0; i < n; ++i) { /* a drained part keeps its mean at 0 */
        field[i] -= is_drained ? mean / total : 0.0;
        size += network->size[i] / literal_rho(s, i) * field[i] * field[i];
    }
    ss_cnn_relax_look(relax);
    ss_cnn_relax_influence(relax, 1, &cell, &column);
    out_steps[0] = out_steps[1] = 0;
    for (int32_t step = 1; out_steps[1] == 0 && step < 20000; ++step) {
        double error = 0.0;
        ss_cnn_relax_advance(relax);
        for (int32_t i = 0; i < n; ++i) {
            const double now = ss_cnn_relax_potential(relax, relax->slot_of[cell], i);
            assert_true(is_drained || (now >= v[i] && now <= field[i] * (1.0 + 1e-12) + 1e-15));
            if (i == cell && out_steps[0] == 0) { /* what (19) is off by at the source, over I */
                *out_residual = (now - v[i]) / relax->step;
            }
            v[i] = now;
            error += network->size[i] / literal_rho(s, i) * (now - field[i]) * (now - field[i]);
        }
        error = sqrt(error / size);
        assert_true(error < last);
        last = error;
        out_steps[0] = out_steps[0] == 0 && error < 1e-3 ? step : out_steps[0];
        out_steps[1] = error < 1e-6 ? step : 0;
    }
    free(field);
    free(v);
}

TEST(the_error_of_the_field_falls_at_the_rate_that_is_told)
{
    for (int kind = 0; kind < 3; ++kind) { /* held, held and uneven, free */
        setup s;
        int32_t top = kind == 2 ? TOP + 24 * 3 : TOP, count[2]; /* where slow modes take part */
        double residual;
        if (kind == 1) {
            setup_relaxed(&s, 1.0);
        } else {
            setup_cylinder(&s, 1.0);
            give(&s, "solver", 1.0);
            give(&s, "relaxation_steps", 1.0);
        }
        if (kind == 2) {
            memset(s.fixed, 0, (size_t)s.mesh->node_count);
        }
        push(&s, &top, 0.0, -0.1, 0.0);
        create(&s);
        const ss_cnn_relax *relax = s.model->relax;
        count_steps(&s, top, count, &residual);
        assert_near(count[0] / ss_cnn_relax_steps_to(relax, 1e-3), 1.0, 0.4);
        assert_near((count[1] - count[0]) /
                        (ss_cnn_relax_steps_to(relax, 1e-6) - ss_cnn_relax_steps_to(relax, 1e-3)),
                    1.0, 0.01);
        if (kind == 0) { /* the cylinder of 360 cells: 647 and 1312 steps */
            assert_near(count[0], 647, 2);
            assert_near(count[1], 1312, 3);
            assert_true(residual < 1e-4); /* far smaller than the field's error of 1e-3 */
        }
        setup_fini(&s);
    }
}

TEST(settled_columns_are_those_of_the_direct_solve)
{
    setup s;
    int32_t patch[3] = {TOP, TOP + 1, TOP + 24};
    setup_relaxed(&s, 100.0);
    push(&s, patch, 0.0, -0.1, 0.0);
    s.load[0].node_count = 3;
    create(&s);
    const ss_cnn_network *network = s.model->network;
    double *exact = calloc((size_t)network->edges.padded_count, sizeof *exact);
    const double third[3] = {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
    assert_int_equal(ss_cnn_network_superpose(s.model->network, 3, patch, third, exact),
                     SOFTSIM_OK);
    steps(&s, 60, 0.05);
    double largest = 0.0;
    for (int32_t e = 0; e < network->edges.count; ++e) {
        largest = fmax(largest, exact[e]);
    }
    for (int32_t e = 0; e < network->edges.count; ++e) {
        assert_near((double)s.model->source[0].kap_edge[e], exact[e],
                    BY_TYPE(1e-6, 1e-9) * largest);
    }
    free(exact);
    setup_fini(&s);
}

/* ---- saturation ---- */

TEST(a_saturated_network_settles_on_the_obstacle_for_any_resistance)
{
    SKIP_WHERE_REPEATED();
    for (int trial = 0; trial < 3; ++trial) {
        setup s;
        literal net;
        int32_t cell[3] = {TOP, TOP + 2, TOP + 24 * 2};
        const int32_t count = trial == 0 ? 1 : 3;
        const double limit = 1.0, given[3] = {20.0, 12.0, 1.0};
        setup_relaxed(&s, 1.0);
        push(&s, cell, 0.0, -0.1, 0.0);
        create(&s);
        const int32_t n = s.mesh->node_count;
        double *y = calloc((size_t)n, sizeof *y), *current = calloc((size_t)n, sizeof *current);
        for (int32_t k = 0; k < count; ++k) {
            current[cell[k]] = given[k];
        }
        assert_int_equal(ss_cnn_obstacle(s.model->network, count, cell, given, limit, y),
                         SOFTSIM_OK);
        literal_init(&net, &s, trial == 2 ? 4.0 : 0.9, limit);
        for (int k = 0; k < 6000; ++k) {
            literal_step(&net, current, 0.5 * s.model->relax->step);
        }
        assert_true(net.v[TOP] > 2.0 * limit); /* saturated: the state goes on, the output not */
        for (int32_t i = 0; i < n; ++i) {
            assert_near(net.y[i], y[i], 1e-9);
        }
        if (count == 1) { /* one cell: the body's rule, I_eff = min(I, K / ghat) */
            const double scale = fmin(given[0], limit / s.model->network->own[TOP]);
            ss_cnn_network_potential(s.model->network, 1, cell, &scale, current);
            for (int32_t i = 0; i < n; ++i) {
                assert_near(y[i], current[i], 1e-12);
            }
        }
        free(y);
        free(current);
        literal_fini(&net);
        setup_fini(&s);
    }
}

TEST(outputs_stay_within_saturation_while_the_network_spreads)
{
    setup s;
    int32_t top = TOP;
    const double limit = 0.25;
    setup_relaxed(&s, 5.0);
    give(&s, "saturation", limit);
    push(&s, &top, 0.0, -1.0, 0.0);
    create(&s);
    int limited = 0;
    for (int k = 0; k < 600; ++k) {
        steps(&s, 1, 0.05);
        const ss_cnn_source *source = &s.model->source[0];
        const double current = source->modulus / source->qhat * source->stretch;
        const double output = current * ss_cnn_relax_potential(s.model->relax, 0, top);
        assert_true(output <= limit * (1.0 + 1e-9));
        limited += source->eps > source->eps_limit;
    }
    assert_true(limited > 100);
    setup_fini(&s);
}

/* ---- bodies ---- */

TEST(the_fan_comes_to_the_same_rest_by_its_own_time)
{
    setup s;
    int32_t centre = 0;
    setup_fan(&s, 7.0, 1.0, 0.5, 0.3);
    give(&s, "solver", 1.0);
    give(&s, "relaxation_steps", 1.0);
    push(&s, &centre, 0.0, 0.0, 0.25);
    create(&s);
    steps(&s, 1, 0.01);
    /* One step of the network: ghat = step, of a settled h^2 / (4 rho) = 0.45: kap at 0.9. */
    assert_near(s.model->relax->step / 0.45, 0.9, 1e-12);
    assert_near((double)s.model->source[0].kap_edge[0], 0.9 * 0.25 / (1.5 * FAN_EDGE * FAN_EDGE),
                1e-6);
    steps(&s, 6000, 0.02);
    const double z = moved(&s, 0, 2);
    assert_near(0.3 * z + 0.75 * 7.0 * z * z * z / (FAN_EDGE * FAN_EDGE), 0.25,
                BY_TYPE(1e-6, 1e-9));
    setup_fini(&s);
}

TEST(bodies_come_to_the_same_rest_and_slower_networks_later)
{
    SKIP_WHERE_REPEATED();
    setup settled, relaxed, slow;
    int32_t top = TOP;
    setup *const all[3] = {&settled, &relaxed, &slow};
    double after[3];
    for (int k = 0; k < 3; ++k) {
        setup_cylinder(all[k], 3.0);
        if (k > 0) {
            give(all[k], "solver", 1.0);
            give(all[k], "relaxation_steps", k == 1 ? 4.0 : 1.0);
        }
        push(all[k], &top, 0.0, -0.5, 0.0);
        create(all[k]);
        steps(all[k], 45, 0.1);
        after[k] = -moved(all[k], TOP, 1);
    }
    assert_null(settled.model->relax);
    assert_true(after[1] > 1.0002 * after[0]); /* not yet as stiff: it gives way further */
    assert_true(after[2] > 1.002 * after[1]);
    for (int k = 0; k < 3; ++k) {
        steps(all[k], 6000, 0.1);
        assert_near(moved(all[k], TOP, 1) / moved(&settled, TOP, 1), 1.0, BY_TYPE(1e-4, 1e-6));
        assert_near(moved(all[k], TOP + 48, 1) / moved(&settled, TOP + 48, 1), 1.0,
                    BY_TYPE(1e-4, 1e-6));
        assert_near(energy_gain(all[k]) / info_of(all[k]).elastic, 0.0, 1e-4);
    }
    for (int k = 0; k < 3; ++k) {
        setup_fini(all[k]);
    }
}

/* psi of the only source from what its cell has spread, by the definition. */
static double spread_energy(const setup *s, const double *ghat, int32_t cell)
{
    const ss_cnn_network *network = s->model->network;
    double eps = 0.0;
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        double rest[3], now[3], moving[3];
        for (int k = 0; k < 3; ++k) {
            rest[k] = s->mesh->position[j][k] - s->mesh->position[i][k];
            moving[k] = moved(s, j, k) - moved(s, i, k);
        }
        ss_add3(now, rest, moving);
        const double square = ss_dot3(rest, rest);
        eps += 0.5 * network->edge_rho[e] * fabs(ghat[i] - ghat[j]) * (ss_dot3(now, now) - square) /
               (square * network->qhat[cell]);
    }
    const double modulus = 60.0 * network->qhat[cell];
    return 0.5 * modulus * fmax(eps, 0.0) * fmax(eps, 0.0);
}

TEST(the_networks_work_is_what_its_flux_brings_and_no_more)
{
    setup s;
    int32_t top = TOP;
    setup_pushed(&s, &top, 2.0);
    s.load[0].to = 40.0;
    create(&s);
    const int32_t n = s.mesh->node_count;
    double *ghat = calloc((size_t)n, sizeof *ghat), brought = 0.0, load = 0.0, at_rest = 0.0;
    double largest = 0.0;
    for (int k = 0; k < 1200; ++k) { /* pushed for 40 s, then let go */
        const double before = moved(&s, top, 1);
        steps(&s, 1, 0.1);
        assert_int_equal(info_of(&s).substeps, 1);
        load += k < 400 ? -0.5 * (moved(&s, top, 1) - before) : 0.0;
        const double old = spread_energy(&s, ghat, top);
        for (int32_t i = 0; i < n; ++i) {
            ghat[i] = ss_cnn_relax_potential(s.model->relax, 0, i);
        }
        const double step = spread_energy(&s, ghat, top) - old;
        brought += step;
        largest = fmax(largest, info_of(&s).elastic);
        const ss_model_info info = info_of(&s);
        /* What is stored was put in by the load and the network, less what damping took. */
        assert_true(info.elastic + info.kinetic <= load + brought + 1e-3 * largest);
        assert_near(info.work, load + brought, BY_TYPE(2e-4, 1e-9) * (1.0 + largest));
        at_rest = k > 1100 ? fmax(at_rest, fabs(step)) : 0.0;
    }
    assert_true(brought > 1e-3 * load);    /* it does bring some */
    assert_true(at_rest < 1e-6 * largest); /* a settled network brings nothing */
    free(ghat);
    setup_fini(&s);
}

TEST(a_release_gives_back_everything)
{
    SKIP_WHERE_REPEATED();
    setup s;
    int32_t top = TOP;
    setup_pushed(&s, &top, 3.0);
    s.load[0].to = 10.0; /* while the network still spreads */
    create(&s);
    steps(&s, 100, 0.1);
    assert_true(-moved(&s, top, 1) > 0.1);
    steps(&s, 6000, 0.1);
    const ss_model_info info = info_of(&s);
    assert_true(largest_displacement(&s) < 1e-6);
    assert_near(info.dissipated / info.work, 1.0, 1e-4);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
