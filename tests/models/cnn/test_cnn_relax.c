/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy with its network in its own time: the literal equations, how far the field is from
 * the settled one, saturation, energy, and bodies under tools and loads, held and free.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/effort.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/thread.h"
#include "touch_fixture.h"

/* ---- the literal network ---- */

/* Equations (1), (2) and (20) as they stand, one cell at a time: slow, and nothing to get wrong. */
typedef struct literal {
    const setup *s;
    double resistance, saturation;
    double *v, *y, *flow;
} literal;

static void literal_init(literal *net, const setup *s, double resistance, double saturation)
{
    const size_t n = (size_t)s->mesh->node_count;
    *net = (literal){.s = s, .resistance = resistance, .saturation = saturation};
    net->v = calloc(n, sizeof(double));
    net->y = calloc(n, sizeof(double));
    net->flow = calloc(n, sizeof(double));
}

static void literal_fini(literal *net)
{
    free(net->v);
    free(net->y);
    free(net->flow);
}

static double rho_at(const setup *s, int32_t i)
{
    return s->model->material.rho[i];
}

/* v += dt (-v/R + sum_j A_ij y_j + I), A_ii = 1/R - sum_j A_ij. */
static void literal_step(literal *net, const double *current, double dt)
{
    const ss_cnn_network *network = net->s->model->network;
    const int32_t n = net->s->mesh->node_count;
    for (int32_t i = 0; i < n; ++i) {
        net->y[i] = fmax(-net->saturation, fmin(net->saturation, net->v[i]));
        net->flow[i] = -net->v[i] / net->resistance + net->y[i] / net->resistance + current[i];
    }
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        const double w = network->edge_weight[e];
        net->flow[i] += rho_at(net->s, i) * w / network->size[i] * (net->y[j] - net->y[i]);
        net->flow[j] += rho_at(net->s, j) * w / network->size[j] * (net->y[i] - net->y[j]);
    }
    for (int32_t i = 0; i < n; ++i) {
        net->v[i] = net->s->fixed[i] == 7 ? 0.0 : net->v[i] + dt * net->flow[i];
    }
}

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

static void states_follow_the_literal_network_for_any_resistance(void **state)
{
    (void)state;
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
        ss_cnn_relax_columns(relax, 2, cell, column);
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

static void the_step_is_below_the_limit_of_the_fastest_mode(void **state)
{
    (void)state;
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

/* ---- how far the field is ---- */

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
        total += network->size[i] / rho_at(s, i);
        mean += network->size[i] / rho_at(s, i) * field[i];
    }
    for (int32_t i = 0; i < n; ++i) { /* a drained part keeps its mean at 0 */
        field[i] -= is_drained ? mean / total : 0.0;
        size += network->size[i] / rho_at(s, i) * field[i] * field[i];
    }
    ss_cnn_relax_look(relax);
    ss_cnn_relax_columns(relax, 1, &cell, &column);
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
            error += network->size[i] / rho_at(s, i) * (now - field[i]) * (now - field[i]);
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

static void the_error_of_the_field_falls_at_the_rate_that_is_told(void **state)
{
    (void)state;
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

static void settled_columns_are_those_of_the_direct_solve(void **state)
{
    (void)state;
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

static void a_saturated_network_settles_on_the_obstacle_for_any_resistance(void **state)
{
    (void)state;
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

static void outputs_stay_within_saturation_while_the_network_spreads(void **state)
{
    (void)state;
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

static void the_fan_comes_to_the_same_rest_by_its_own_time(void **state)
{
    (void)state;
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

static void bodies_come_to_the_same_rest_and_slower_networks_later(void **state)
{
    (void)state;
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
        assert_near(ledger(all[k]) / info_of(all[k]).elastic, 0.0, 1e-4);
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

static void the_networks_work_is_what_its_flux_brings_and_no_more(void **state)
{
    (void)state;
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 2.0);
    give(&s, "solver", 1.0);
    give(&s, "relaxation_steps", 2.0);
    push(&s, &top, 0.0, -0.5, 0.0);
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

static void a_release_gives_back_everything(void **state)
{
    (void)state;
    SKIP_WHERE_REPEATED();
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 2.0);
    give(&s, "solver", 1.0);
    give(&s, "relaxation_steps", 3.0);
    push(&s, &top, 0.0, -0.5, 0.0);
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

static void cells_spread_while_touched_and_start_anew_after(void **state)
{
    (void)state;
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
        quick = n == 60 ? s.model->tool[0].force[2] / settled.model->tool[0].force[2] : quick;
    }
    assert_true(quick > 0.9 && quick < 0.98); /* a quick press meets a network not yet settled */
    assert_int_equal(states_in_use(&s), s.model->tool[0].count);
    assert_near(s.model->tool[0].force[2] / settled.model->tool[0].force[2], 1.0,
                BY_TYPE(1e-4, 1e-5));
    const double pressed = info_of(&s).elastic;
    assert_near(ledger(&s) / pressed, 0.0, 5e-3);
    for (int n = 1; n <= 300; ++n) { /* slides on: new cells join from 0 as others are let go */
        go(tool, 0.0005 + 5e-5 * n, 0.0007, PLATE_RADIUS - 0.004);
        step_tools(&s, 1e-3, tool);
        assert_true(states_in_use(&s) <= s.model->tool[0].count + 2);
    }
    assert_near(ledger(&s) / pressed, 0.0, 5e-3);
    for (int n = 1; n <= 400; ++n) {
        go(tool, 0.0155, 0.0007, fmin(0.03, PLATE_RADIUS - 0.004 + 1e-4 * n));
        step_tools(&s, 1e-3, tool);
    }
    assert_int_equal(states_in_use(&s), 0);
    assert_near(ledger(&s) / pressed, 0.0, 5e-3);
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

static uint64_t hash_of(const setup *s)
{
    uint64_t hash = s->class->hash(s->model, SS_HASH_START);
    hash = ss_hash_bytes(hash, s->class->displacement(s->model),
                         (size_t)s->mesh->node_count * 4 * sizeof(ss_real));
    return hash;
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

static void equal_runs_give_equal_bits_also_after_a_reset(void **state)
{
    (void)state;
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

static void two_tools_and_loads_keep_the_ledger_whatever_is_chosen(void **state)
{
    (void)state;
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
            const double way = 0.5 - 0.5 * cos(PI * fmin(1.0, n / 100.0)) -
                               (0.5 - 0.5 * cos(PI * fmax(0.0, fmin(1.0, (n - 200) / 100.0))));
            const double along = 0.004 * sin(PI * n / 150.0);
            go(&tool[0], along, 0.001, 0.054 - 0.018 * way);
            go(&tool[1], (kind & FREE) != 0 ? -along : 0.012,
               (kind & FREE) != 0 ? 0.0 : 0.02 + along,
               (kind & FREE) != 0 ? -0.054 + 0.018 * way : 0.05 - 0.019 * way);
            step_tools(&s, 1e-3, tool);
            largest = fmax(largest, info_of(&s).elastic);
            worst = fmax(worst, fabs(ledger(&s)));
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

static void free_bodies_move_by_what_pushes_them(void **state)
{
    (void)state;
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

static void steps_without_relaxation_and_cells_without_area_are_refused(void **state)
{
    (void)state;
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 1.0);
    give(&s, "relaxation_steps", 5.0);
    push(&s, &top, 0.0, -0.1, 0.0);
    assert_int_equal(setup_create(&s), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(s.error.text, "relaxation_steps goes with solver: relaxation"));
    setup_fini(&s);
    static const double bad[3] = {0.0, 1e6, (double)NAN};
    for (int k = 0; k < 3; ++k) {
        setup_cylinder(&s, 1.0);
        give(&s, "solver", 1.0);
        give(&s, "relaxation_steps", bad[k]);
        push(&s, &top, 0.0, -0.1, 0.0);
        assert_int_equal(setup_create(&s), SOFTSIM_ERROR_SCENE);
        assert_non_null(strstr(s.error.text, "relaxation_steps must be 1 to 10000"));
        setup_fini(&s);
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
    assert_int_equal(setup_create(&s), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(s.error.text, "(first 3)"));
    setup_fini(&s);
}

static void too_many_states_are_refused_before_they_are_solved(void **state)
{
    (void)state;
    setup s;
    setup_init(&s, "cnn-energy", make_plate(70, 0.2));
    give_skin(&s);
    give(&s, "solver", 1.0);
    add_sphere(&s, 0, PLATE_RADIUS);
    assert_int_equal(setup_create(&s), SOFTSIM_ERROR_UNSUPPORTED);
    assert_non_null(strstr(s.error.text, "5041 cells"));
    setup_fini(&s);
}

static void join_lines(void *sink, const char *text)
{
    char *out = sink;
    strncat(out, text, 8000 - strlen(out));
    strncat(out, "\n", 8000 - strlen(out));
}

static void cost_and_explanation_count_the_networks_steps(void **state)
{
    (void)state;
    double cost[4];
    for (int k = 0; k < 4; ++k) {
        setup s;
        char text[8192] = "";
        setup_relaxing(&s, k == 0 ? 0.0 : k == 1 ? 10.0 : k == 2 ? 20.0 : 30.0);
        create(&s);
        cost[k] = s.class->step_cost_us(&s.plan);
        s.class->explain(s.model, join_lines, text);
        assert_true((strstr(text, "left out: the network's own time") != NULL) == (k == 0));
        assert_true((strstr(text, "slowest time constant") != NULL) == (k > 0));
        assert_true((strstr(text, "left out: settled columns") != NULL) == (k > 0));
        setup_fini(&s);
    }
    assert_true(cost[1] > 1.5 * cost[0]);
    assert_near(cost[3] - cost[2], cost[2] - cost[1], 1e-9);
    assert_true(cost[2] - cost[1] > 0.5 * cost[0]);
}

int main(void)
{
    ss_thread_flush_denormals();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(states_follow_the_literal_network_for_any_resistance),
        cmocka_unit_test(the_step_is_below_the_limit_of_the_fastest_mode),
        cmocka_unit_test(the_error_of_the_field_falls_at_the_rate_that_is_told),
        cmocka_unit_test(settled_columns_are_those_of_the_direct_solve),
        cmocka_unit_test(a_saturated_network_settles_on_the_obstacle_for_any_resistance),
        cmocka_unit_test(outputs_stay_within_saturation_while_the_network_spreads),
        cmocka_unit_test(the_fan_comes_to_the_same_rest_by_its_own_time),
        cmocka_unit_test(bodies_come_to_the_same_rest_and_slower_networks_later),
        cmocka_unit_test(the_networks_work_is_what_its_flux_brings_and_no_more),
        cmocka_unit_test(a_release_gives_back_everything),
        cmocka_unit_test(cells_spread_while_touched_and_start_anew_after),
        cmocka_unit_test(equal_runs_give_equal_bits_also_after_a_reset),
        cmocka_unit_test(two_tools_and_loads_keep_the_ledger_whatever_is_chosen),
        cmocka_unit_test(free_bodies_move_by_what_pushes_them),
        cmocka_unit_test(steps_without_relaxation_and_cells_without_area_are_refused),
        cmocka_unit_test(too_many_states_are_refused_before_they_are_solved),
        cmocka_unit_test(cost_and_explanation_count_the_networks_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
