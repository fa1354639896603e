/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The body that Newtonian models share, under a law with closed forms: every node is held at its
 * place by a spring and a damper of its own. What is checked is the body: motion, ledger, loads,
 * supports, tools, guards.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "models/body.h"
#include "models/model.h"
#include "rt/memory.h"

#include "element_fixture.h"

/* ---- a body ------------------------------------------------------------------------------- */

typedef struct anchors {
    ss_body *body;
    double stiffness, damping; /* N/m, N s/m, a node */
    double share;              /* of the law's stable step that it claims */
    bool is_broken;            /* forces that are not numbers */
    double own_mass_damping;
    ss_body_integrator integrator;
} anchors;

static void anchor_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                         ss_body_energy *out)
{
    const anchors *a = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(a->body);
    double square = 0.0, speed = 0.0;
    for (int32_t at = 0; at < 4 * nodes->count; ++at) {
        force[at] -= (ss_real)a->stiffness * u[at] + (ss_real)a->damping * v[at];
        square += (double)u[at] * (double)u[at];
        speed += (double)v[at] * (double)v[at];
    }
    if (a->is_broken) {
        force[1] = (ss_real)NAN;
    }
    out->elastic = 0.5 * a->stiffness * square;
    out->power = a->damping > 0.0 ? a->damping * speed : 0.0;
}

static void anchor_tangent(void *owner, const ss_real *x, ss_real *out)
{
    const anchors *a = owner;
    for (int32_t at = 0; at < 4 * ss_body_read_nodes(a->body)->count; ++at) {
        out[at] += (ss_real)a->stiffness * x[at];
    }
}

static void anchor_diagonal(void *owner, double *out)
{
    const anchors *a = owner;
    for (int32_t i = 0; i < ss_body_read_nodes(a->body)->count; ++i) {
        out[i] += a->stiffness;
    }
}

static double anchor_step(void *owner, const ss_body *body)
{
    const anchors *a = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(body);
    double rate2 = 0.0;
    for (int32_t i = 0; i < nodes->count; ++i) {
        rate2 = fmax(rate2, a->stiffness / nodes->mass[i]);
    }
    const double time = a->stiffness > 0.0 ? fmax(0.0, a->damping) / a->stiffness : 0.0;
    const double limit = ss_body_step_limit(a->integrator, rate2, time, a->own_mass_damping);
    return fmin(a->share * limit, 1e3);
}

typedef struct bench {
    setup s; /* mesh, fixed nodes, loads, tools; no model */
    anchors law;
    double mass_damping, share, density;
    bool is_even; /* every node has the same mass */
    ss_body *body;
    double time;
} bench;

static const ss_shape ball = {.kind = SS_SHAPE_SPHERE, .radius = 0.015};

/* A block of 60 mm and 64 nodes, free, without a tool; 1 N/m a node of 1 g. */
static void bench_init(bench *b)
{
    memset(b, 0, sizeof *b);
    ss_mesh *mesh = make_block(3, 0.06);
    b->s.mesh = mesh;
    b->s.fixed = calloc((size_t)mesh->node_count, 1);
    b->s.plan = (ss_model_plan){.mesh = mesh,
                                .fixed = b->s.fixed,
                                .load = b->s.load,
                                .prescribed = b->s.prescribed,
                                .working_force = 2.0,
                                .max_force = 8.0,
                                .step = 1e-3,
                                .max_substeps = 64,
                                .threads = 1};
    b->law = (anchors){.stiffness = 10.0, .share = 1.0};
    b->share = 0.5;
    b->density = 1000.0;
    b->is_even = true;
}

static softsim_status bench_create(bench *b)
{
    const size_t n = (size_t)b->s.mesh->node_count;
    double *density = calloc(n, sizeof *density), *mass = calloc(n, sizeof *mass);
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i) {
        density[i] = b->density;
    }
    ss_body_volume_masses(b->s.mesh, density, false, mass);
    for (size_t i = 0; i < n; ++i) {
        sum += mass[i];
    }
    assert_near(sum, b->density * 0.06 * 0.06 * 0.06, 1e-12 * b->density);
    for (size_t i = 0; b->is_even && i < n; ++i) {
        mass[i] = sum / (double)n;
    }
    b->law.own_mass_damping = b->mass_damping;
    const ss_body_plan plan = {.name = "anchors",
                               .plan = &b->s.plan,
                               .node_count = b->s.mesh->node_count,
                               .mass = mass,
                               .mass_damping = b->mass_damping,
                               .edge = ss_body_mean_edge(b->s.mesh),
                               .step_share = b->share,
                               .integrator = b->law.integrator,
                               .elastic = {.owner = &b->law,
                                           .force = anchor_force,
                                           .tangent = anchor_tangent,
                                           .diagonal = anchor_diagonal,
                                           .stable_step = anchor_step}};
    const softsim_status status = ss_body_create(&plan, &b->body, &b->s.error);
    free(density);
    free(mass);
    b->law.body = b->body;
    return status == SOFTSIM_OK ? ss_body_start(b->body) : status;
}

static void bench_make(bench *b)
{
    if (bench_create(b) != SOFTSIM_OK) {
        fail_msg("create: %s", b->s.error.text);
    }
}

static void bench_fini(bench *b)
{
    ss_body_destroy(&b->body);
    free(b->s.fixed);
    ss_mesh_destroy(&b->s.mesh);
}

static void run(bench *b, int count, double dt, const ss_model_tool *tool)
{
    for (int k = 0; k < count; ++k) {
        ss_body_step(b->body, b->time, dt, tool);
        b->time += dt;
    }
}

static ss_model_info told(const bench *b)
{
    ss_model_info info;
    ss_body_info(b->body, &info);
    return info;
}

static double balance(const bench *b)
{
    const ss_model_info info = told(b);
    return info.elastic + info.kinetic - info.work + info.dissipated;
}

/* Every node displaced by x along axis 0. */
static void shift(bench *b, double x)
{
    ss_body_nodes *nodes = ss_body_get_nodes(b->body);
    for (int32_t i = 0; i < nodes->count; ++i) {
        nodes->u[4 * i] = (ss_real)x;
    }
    ss_body_renew(b->body);
}

static double at(const bench *b, int32_t node, int axis)
{
    return (double)ss_body_read_nodes(b->body)->u[4 * node + axis];
}

static const ss_body_integrator methods[] = {SS_BODY_SYMPLECTIC_EULER, SS_BODY_RK4};

/* ---- motion ------------------------------------------------------------------------------- */

static void what_falls_freely_falls_exactly(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        bench b;
        bench_init(&b);
        b.law.stiffness = 0.0;
        b.law.integrator = methods[m];
        b.is_even = false;
        b.s.plan.gravity[2] = -9.81;
        bench_make(&b);
        run(&b, 200, 1e-3, NULL);
        const double fall = 0.5 * 9.81 * b.time * b.time;
        for (int32_t i = 0; i < b.s.mesh->node_count; ++i) {
            assert_near(at(&b, i, 2), -fall, BY_TYPE(2e-6, 1e-13));
            assert_near(at(&b, i, 0), 0.0, 0.0);
        }
        const ss_model_info info = told(&b);
        assert_near(info.work, 0.216 * 9.81 * fall, BY_TYPE(1e-5, 1e-12));
        assert_near(info.kinetic, 0.216 * 9.81 * fall, BY_TYPE(1e-5, 1e-12));
        assert_int_equal(info.verdict, SOFTSIM_VERDICT_GOOD);
        assert_int_equal(info.substeps, 1);
        bench_fini(&b);
    }
}

static void an_oscillator_has_the_frequency_of_its_method(void **state)
{
    (void)state;
    const double dt = 2e-3;
    for (int m = 0; m < 2; ++m) {
        bench b;
        bench_init(&b);
        b.law.integrator = methods[m];
        b.share = 1.0;
        bench_make(&b);
        shift(&b, 1e-3);
        const double mass = 0.216 / 64.0, omega = sqrt(10.0 / mass);
        /* Leapfrog: cos(w dt) = 1 - (omega dt)^2 / 2, from rest exactly a cosine. */
        const double w = m == 0 ? acos(1.0 - 0.5 * omega * dt * omega * dt) / dt : omega;
        double worst = 0.0;
        for (int k = 1; k <= 500; ++k) {
            run(&b, 1, dt, NULL);
            worst = fmax(worst, fabs(at(&b, 20, 0) - 1e-3 * cos(w * k * dt)));
        }
        assert_true(worst < (m == 0 ? BY_TYPE(2e-7, 1e-13) : 5e-6));
        bench_fini(&b);
    }
}

static void the_stable_step_is_the_edge_of_stability(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        for (int is_over = 0; is_over < 2; ++is_over) {
            bench b;
            bench_init(&b);
            b.law.integrator = methods[m];
            b.law.share = is_over ? 1.03 : 0.97;
            b.share = 1.0;
            bench_make(&b);
            const double dt = told(&b).stable_step;
            shift(&b, 1e-6);
            double largest = 0.0;
            for (int k = 0; k < 60; ++k) {
                run(&b, 1, dt, NULL);
                assert_int_equal(told(&b).substeps, 1);
                largest = fmax(largest, fabs(at(&b, 20, 0)));
            }
            assert_true(is_over ? largest > 1e-3 : largest < 1e-5);
            bench_fini(&b);
        }
    }
}

static void a_step_that_is_too_long_does_not_go_unseen(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        bench b;
        bench_init(&b);
        b.law.integrator = methods[m];
        b.law.share = m == 0 ? 1.005 : 1.05;
        b.share = 1.0;
        bench_make(&b);
        shift(&b, 1e-3);
        bool is_seen = false;
        for (int k = 0; k < 100; ++k) {
            run(&b, 1, told(&b).stable_step, NULL);
            is_seen = is_seen || (told(&b).verdict != SOFTSIM_VERDICT_GOOD);
            assert_true(k < 10 || is_seen);
            assert_true(isfinite((ss_real)at(&b, 20, 0)));
        }
        assert_true(is_seen);
        assert_true(fabs(at(&b, 20, 0)) < 0.2);
        bench_fini(&b);
    }
}

static void the_ledger_of_ten_thousand_steps_closes(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.share = 0.9;
    b.is_even = false;
    bench_make(&b);
    shift(&b, 2e-3);
    const double dt = 0.9 * told(&b).stable_step;
    run(&b, 1, dt, NULL);
    /* At 0.9 of the stable step the told kinetic energy swings; its mean over a beat does not. */
    double first = 0.0, last = 0.0;
    for (int k = 0; k < 10000; ++k) {
        run(&b, 1, dt, NULL);
        first += k < 1000 ? told(&b).elastic + told(&b).kinetic : 0.0;
        last += k >= 9000 ? told(&b).elastic + told(&b).kinetic : 0.0;
    }
    assert_near(last / first, 1.0, 1e-3);
    assert_int_equal(told(&b).fault_bits, 0);
    bench_fini(&b);
}

static void damping_takes_what_is_booked(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        for (int kind = 0; kind < 2; ++kind) { /* mass damping, viscosity */
            bench b;
            bench_init(&b);
            b.law.integrator = methods[m];
            const double mass = 0.216 / 64.0, omega = sqrt(10.0 / mass), rate = 8.0;
            b.mass_damping = kind == 0 ? rate : 0.0;
            b.law.damping = kind == 1 ? rate * mass : 0.0;
            bench_make(&b);
            shift(&b, 1e-3);
            const int steps = 200;
            run(&b, steps, 1e-3, NULL);
            const double t = 1e-3 * steps, wd = sqrt(omega * omega - 0.25 * rate * rate);
            const double x =
                1e-3 * exp(-0.5 * rate * t) * (cos(wd * t) + 0.5 * rate / wd * sin(wd * t));
            assert_near(at(&b, 20, 0), x, kind == 1 && m == 0 ? 2e-5 : 2e-6);
            const ss_model_info info = told(&b);
            assert_true(info.dissipated > 0.5 * info.work);
            assert_near(balance(&b), 0.0, 0.01 * info.work);
            assert_int_equal(info.fault_bits, 0);
            bench_fini(&b);
        }
    }
}

/* ---- loads and supports ------------------------------------------------------------------- */

static void supports_answer_what_loads_push(void **state)
{
    (void)state;
    int32_t pushed[2] = {21, 22}, held[3] = {0, 1, 5};
    double way[3][3] = {{1e-3, 0.0, NAN}, {1e-3, 0.0, NAN}, {1e-3, 0.0, NAN}};
    bench b;
    bench_init(&b);
    b.mass_damping = 60.0;
    b.s.plan.gravity[1] = -2.0;
    b.s.fixed[40] = 7;
    b.s.fixed[41] = 3;
    b.s.plan.load_count = 1;
    b.s.load[0] = (ss_load){
        .node = pushed, .node_count = 2, .force = {0.02, 0.0, -0.01}, .to = (double)INFINITY};
    b.s.plan.prescribed_count = 1;
    b.s.prescribed[0] = (ss_prescribed){.node = held,
                                        .node_count = 3,
                                        .displacement = way,
                                        .axis = {true, true, true},
                                        .ramp = 0.1};
    bench_make(&b);
    run(&b, 2000, 1e-3, NULL);
    const double weight = 2.0 * 0.216 / 64.0;
    assert_near(at(&b, 21, 0), 0.01 / 10.0, 1e-6);
    assert_near(at(&b, 21, 2), -0.005 / 10.0, 1e-6);
    assert_near(at(&b, 30, 1), -weight / 10.0, 1e-6);
    assert_near(at(&b, 41, 0), 0.0, 0.0);
    double force[3];
    ss_body_reaction(b.body, 0, force);
    assert_near(force[0], 3.0 * 10.0 * 1e-3, 1e-6);
    assert_near(force[1], 3.0 * weight, 1e-6);
    assert_near(force[2], 0.0, 0.0);
    ss_body_reaction(b.body, -1, force);
    assert_near(force[0], 0.0, 1e-7);
    assert_near(force[1], 2.0 * weight, 1e-6);
    assert_near(balance(&b), 0.0, 1e-3 * told(&b).work);
    ss_body_reaction(b.body, 1, force);
    assert_near(force[1], 0.0, 0.0);
    bench_fini(&b);
}

static void driven_nodes_go_at_constant_velocity_and_pay(void **state)
{
    (void)state;
    int32_t held[1] = {10};
    double way[1][3] = {{5e-3, NAN, NAN}};
    bench b;
    bench_init(&b);
    b.s.plan.prescribed_count = 1;
    b.s.prescribed[0] = (ss_prescribed){.node = held,
                                        .node_count = 1,
                                        .displacement = way,
                                        .axis = {true, true, true},
                                        .ramp = 0.05};
    bench_make(&b);
    const double mass = 0.216 / 64.0;
    run(&b, 20, 1e-3, NULL);
    assert_near(at(&b, 10, 0), 2e-3, 1e-8);
    assert_near((double)ss_body_read_nodes(b.body)->v[40], 0.1, 1e-6);
    assert_near(told(&b).work, 0.5 * 10.0 * 4e-6 + 0.5 * mass * 0.01, 1e-9);
    assert_near(balance(&b), 0.0, 1e-9);
    run(&b, 60, 1e-3, NULL);
    assert_near(at(&b, 10, 0), 5e-3, 1e-9);
    assert_near(told(&b).work, 0.5 * 10.0 * 25e-6, 1e-9);
    bench_fini(&b);
}

static void pressure_pushes_along_the_surface(void **state)
{
    (void)state;
    int32_t side[16];
    int32_t count = 0;
    bench b;
    bench_init(&b);
    for (int32_t i = 0; i < 64; ++i) {
        if (b.s.mesh->position[i][0] > 0.029) {
            side[count++] = i;
        }
    }
    b.mass_damping = 60.0;
    b.s.plan.load_count = 1;
    b.s.load[0] = (ss_load){.node = side,
                            .node_count = count,
                            .pressure = 5.0,
                            .is_pressure = true,
                            .to = (double)INFINITY,
                            .ramp = 0.05};
    bench_make(&b);
    run(&b, 1000, 1e-3, NULL);
    double sum[3] = {0.0};
    for (int32_t i = 0; i < 64; ++i) {
        for (int k = 0; k < 3; ++k) {
            sum[k] += 10.0 * at(&b, i, k);
        }
    }
    /* The patch has moved inward nearly flat: the force is pressure times its area still. */
    assert_near(sum[0], -5.0 * 0.06 * 0.06, 2e-4);
    assert_near(sum[1], 0.0, 2e-5);
    bench_fini(&b);
}

/* A load that rises step by step moves the told velocity, which is ahead of the stored one, at
 * once: that is its work, and no energy from nowhere. */
static void a_rising_load_gains_nothing(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        int32_t node[2] = {20, 21};
        bench b;
        bench_init(&b);
        b.law.integrator = methods[m];
        b.s.plan.working_force = 1e-6; /* no gain is too small to count */
        b.s.plan.load_count = 1;
        b.s.load[0] = (ss_load){.node = node,
                                .node_count = 2,
                                .force = {0.1, 0.0, 0.0},
                                .to = (double)INFINITY,
                                .ramp = 0.02};
        bench_make(&b);
        for (int k = 0; k < 40; ++k) {
            run(&b, 1, 1e-3, NULL);
            /* In the first v falls behind u, which costs a little. */
            assert_true(k == 0 || told(&b).verdict == SOFTSIM_VERDICT_GOOD);
        }
        assert_near(balance(&b), 0.0, 1e-3 * told(&b).work);
        bench_fini(&b);
    }
}

/* ---- tools -------------------------------------------------------------------------------- */

static void tool_at(ss_model_tool *tool, double from, double to, double x)
{
    *tool = (ss_model_tool){.is_present = true};
    ss_set3(tool->from.position, x, 0.0, from);
    ss_set3(tool->to.position, x, 0.0, to);
    tool->from.orientation[0] = tool->to.orientation[0] = 1.0;
}

static void bench_with_ball(bench *b)
{
    bench_init(b);
    b->law.stiffness = 40.0;
    b->mass_damping = 30.0;
    b->s.plan.tool[0] = (ss_tool_plan){.is_used = true, .shape = ball};
}

/* Presses the ball from above by `depth` in `steps` steps from where it just touches. */
static void press(bench *b, ss_model_tool tool[SOFTSIM_MAX_PROBES], double depth, int steps)
{
    const double top = 0.03 + ball.radius;
    for (int k = 0; k < steps; ++k) {
        tool_at(tool, top - depth * k / steps, top - depth * (k + 1) / steps, 0.0);
        run(b, 1, 1e-3, tool);
    }
}

static void hold(bench *b, ss_model_tool tool[SOFTSIM_MAX_PROBES], int steps)
{
    tool[0].from = tool[0].to;
    run(b, steps, 1e-3, tool);
}

static void a_tool_gets_back_what_it_gives(void **state)
{
    (void)state;
    for (int m = 0; m < 2; ++m) {
        bench b;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
        ss_contact_set set;
        bench_with_ball(&b);
        b.law.integrator = methods[m];
        bench_make(&b);
        press(&b, tool, 5e-3, 100);
        hold(&b, tool, 600);
        ss_body_contacts(b.body, 0, 0.01, &set);
        double sum[3] = {0.0};
        for (int32_t i = 0; i < 64; ++i) {
            for (int k = 0; k < 3; ++k) {
                sum[k] += 40.0 * at(&b, i, k);
            }
        }
        /* At rest the springs carry all of it. */
        assert_true(set.force[2] > 0.1);
        assert_near(set.force[2], -sum[2], 1e-4 * set.force[2]);
        assert_near(set.contact[0].force, set.force[2], 1e-5 * set.force[2]);
        const ss_model_info info = told(&b);
        assert_near(balance(&b), 0.0, 0.005 * info.work);
        assert_int_equal(info.fault_bits, 0);
        /* Let go: everything comes back, and what was given is gone into damping. */
        press(&b, tool, -5e-3, 50);
        memset(tool, 0, sizeof tool);
        run(&b, 800, 1e-3, tool);
        assert_near(told(&b).elastic + told(&b).kinetic, 0.0, 1e-9);
        assert_near(balance(&b), 0.0, 0.01 * told(&b).dissipated + 1e-9);
        bench_fini(&b);
    }
}

static void the_felt_stiffness_errs_high_but_little(void **state)
{
    (void)state;
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_contact_set set, more;
    bench_with_ball(&b);
    bench_make(&b);
    press(&b, tool, 4e-3, 100);
    for (int k = 0; k < 600; ++k) {
        hold(&b, tool, 1);
        ss_body_contacts(b.body, 0, 0.01, &set);
    }
    const double z = tool[0].to.position[2];
    tool_at(tool, z, z - 1e-5, 0.0);
    run(&b, 1, 1e-3, tool);
    hold(&b, tool, 600);
    ss_body_contacts(b.body, 0, 0.01, &more);
    const double slope = (more.force[2] - set.force[2]) / 1e-5;
    assert_true(set.contact[0].stiffness > 0.97 * slope);
    assert_true(set.contact[0].stiffness < 1.1 * slope);
    assert_true(set.contact[0].viscosity > 0.0);
    bench_fini(&b);
}

static void a_grasp_pulls_and_lets_go(void **state)
{
    (void)state;
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_contact_set set;
    bench_with_ball(&b);
    bench_make(&b);
    press(&b, tool, 4e-3, 100);
    tool[0].is_grasping = true;
    hold(&b, tool, 1);
    for (int k = 0; k < 100; ++k) {
        const double z = tool[0].to.position[2];
        tool_at(tool, z, z + 1e-4, 0.0);
        tool[0].is_grasping = true;
        run(&b, 1, 1e-3, tool);
    }
    hold(&b, tool, 300);
    ss_body_contacts(b.body, 0, 0.01, &set);
    assert_true(set.is_held);
    assert_true(set.force[2] < -0.05);
    const double before = balance(&b);
    tool[0].is_grasping = false;
    hold(&b, tool, 100);
    ss_body_contacts(b.body, 0, 0.01, &set);
    assert_false(set.is_held);
    assert_near(set.force[2], 0.0, 1e-6);
    assert_near(balance(&b), before, 0.02 * told(&b).work);
    bench_fini(&b);
}

static void a_fast_tool_is_swept_and_does_not_tunnel(void **state)
{
    (void)state;
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_contact_set set;
    bench_with_ball(&b);
    bench_make(&b);
    tool_at(tool, 0.08, 0.035, 0.0);
    run(&b, 1, 1e-3, tool);
    assert_true(told(&b).substeps >= 12);
    ss_body_contacts(b.body, 0, 0.01, &set);
    assert_true(set.force[2] > 0.0);
    bench_fini(&b);
}

/* ---- a surface that rides on the nodes ------------------------------------------------------- */

static void lay_half(void *owner, const ss_real *u, ss_real *skin_u)
{
    const anchors *a = owner;
    memcpy(skin_u, u, (size_t)ss_body_read_nodes(a->body)->count * 4 * sizeof *u);
}

static void carry_same(void *owner, int32_t count, const int32_t *node, const ss_real *skin_force,
                       ss_real *force)
{
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 4; ++k) {
            force[4 * node[i] + k] += skin_force[4 * node[i] + k];
        }
    }
}

static void carry_same_diagonal(void *owner, int32_t count, const int32_t *node, const double *skin,
                                double *diagonal)
{
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        diagonal[node[i]] += skin[node[i]];
    }
}

static double carry_same_rate2(void *owner, int32_t count, const int32_t *node, const double *skin,
                               const ss_real *mobility)
{
    double largest = 0.0;
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        largest = fmax(largest, skin[node[i]] * (double)mobility[4 * node[i]]);
    }
    return largest;
}

static void a_skin_of_the_nodes_themselves_changes_nothing(void **state)
{
    (void)state;
    ss_contact_set set[2];
    double stable[2];
    for (int kind = 0; kind < 2; ++kind) {
        bench b;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
        bench_with_ball(&b);
        b.s.plan.contact_stiffness = 2e6;
        const size_t n = (size_t)b.s.mesh->node_count;
        double *mass = calloc(n, sizeof *mass);
        for (size_t i = 0; i < n; ++i) {
            mass[i] = 0.216 / 64.0;
        }
        ss_body_plan plan = {.name = "anchors",
                             .plan = &b.s.plan,
                             .node_count = (int32_t)n,
                             .mass = mass,
                             .mass_damping = b.mass_damping,
                             .edge = ss_body_mean_edge(b.s.mesh),
                             .step_share = 0.5,
                             .elastic = {.owner = &b.law,
                                         .force = anchor_force,
                                         .tangent = anchor_tangent,
                                         .diagonal = anchor_diagonal,
                                         .stable_step = anchor_step}};
        if (kind == 1) {
            plan.skin = (ss_body_skin){.mesh = b.s.mesh,
                                       .sigma = 1.0,
                                       .lay = lay_half,
                                       .carry = carry_same,
                                       .carry_diagonal = carry_same_diagonal,
                                       .rate2 = carry_same_rate2};
        }
        assert_int_equal(ss_body_create(&plan, &b.body, &b.s.error), SOFTSIM_OK);
        free(mass);
        b.law.body = b.body;
        assert_int_equal(ss_body_start(b.body), SOFTSIM_OK);
        press(&b, tool, 4e-3, 50);
        tool[0].is_grasping = true;
        hold(&b, tool, 20);
        ss_body_contacts(b.body, 0, 0.01, &set[kind]);
        stable[kind] = told(&b).stable_step;
        bench_fini(&b);
    }
    assert_near(set[1].force[2], set[0].force[2], 1e-5 * set[0].force[2]);
    assert_near(set[1].contact[0].stiffness, set[0].contact[0].stiffness,
                1e-3 * set[0].contact[0].stiffness);
    assert_near(stable[1], stable[0], 1e-5 * stable[0]);
}

/* ---- guards ------------------------------------------------------------------------------- */

static void a_blow_is_slowed_down_and_said(void **state)
{
    (void)state;
    int32_t hit[1] = {21};
    const double blow[] = {1e2, 1e6, 1e12};
    for (size_t k = 0; k < sizeof blow / sizeof *blow; ++k) {
        for (int m = 0; m < 2; ++m) {
            bench b;
            bench_init(&b);
            b.law.integrator = methods[m];
            b.s.plan.load_count = 1;
            b.s.load[0] =
                (ss_load){.node = hit, .node_count = 1, .force = {blow[k], 0.0, 0.0}, .to = 2e-3};
            bench_make(&b);
            run(&b, 2, 1e-3, NULL);
            assert_int_equal(told(&b).verdict, SOFTSIM_VERDICT_GUARDED);
            assert_true(fabs(at(&b, 21, 0)) <
                        1.01 * told(&b).substeps * 2 * 0.2 * ss_body_mean_edge(b.s.mesh));
            run(&b, 200, 1e-3, NULL);
            assert_true(isfinite(told(&b).kinetic));
            bench_fini(&b);
        }
    }
}

static void what_is_not_finite_is_put_back_until_reset(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.mass_damping = 1.0;
    bench_make(&b);
    shift(&b, 1e-3);
    run(&b, 10, 1e-3, NULL);
    const double before = at(&b, 20, 0);
    b.law.is_broken = true;
    run(&b, 5, 1e-3, NULL);
    assert_int_equal(told(&b).verdict, SOFTSIM_VERDICT_FAULT);
    assert_int_equal(told(&b).fault_bits, SS_MODEL_FAULT_NOT_FINITE);
    assert_int_equal(told(&b).step < 13, true);
    assert_true(fabs(at(&b, 20, 0) - before) < 1e-3);
    assert_true(isfinite(told(&b).kinetic) && isfinite(told(&b).elastic));
    assert_true(isfinite(told(&b).work) && isfinite(told(&b).dissipated));
    for (int32_t i = 0; i < 64; ++i) {
        assert_true(isfinite((ss_real)at(&b, i, 0)) && isfinite((ss_real)at(&b, i, 1)));
    }
    b.law.is_broken = false;
    ss_body_reset(b.body);
    assert_int_equal(told(&b).verdict, SOFTSIM_VERDICT_GOOD);
    assert_int_equal(told(&b).fault_bits, 0);
    run(&b, 5, 1e-3, NULL);
    assert_int_equal(told(&b).step, 5);
    bench_fini(&b);
}

static void too_small_a_budget_is_slower_than_time_and_said(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.law.stiffness = 1e6; /* stable to 0.1 ms */
    b.s.plan.max_substeps = 4;
    bench_make(&b);
    shift(&b, 1e-4);
    run(&b, 1, 1e-3, NULL);
    assert_int_equal(told(&b).substeps, 4);
    assert_int_equal(told(&b).fault_bits, SS_MODEL_FAULT_BUDGET);
    assert_int_equal(told(&b).verdict, SOFTSIM_VERDICT_DEGRADED);
    run(&b, 1000, 1e-3, NULL);
    assert_true(fabs(at(&b, 20, 0)) < 2e-4);
    bench_fini(&b);
}

static void a_flight_out_of_the_world_is_cut_off(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.law.stiffness = 0.0;
    bench_make(&b);
    shift(&b, 20.0);
    run(&b, 1, 1e-3, NULL);
    assert_true(told(&b).fault_bits & SS_MODEL_FAULT_CLAMPED);
    assert_true(fabs(at(&b, 20, 0)) <= 100.0 * 0.104);
    bench_fini(&b);
}

static void energy_from_nowhere_is_taken_out_and_said(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.law.damping = -0.5; /* pushes on what moves, and books nothing */
    bench_make(&b);
    shift(&b, 5e-3);
    run(&b, 400, 1e-3, NULL);
    assert_true(told(&b).fault_bits & SS_MODEL_FAULT_ENERGY);
    assert_true(fabs(at(&b, 20, 0)) < 0.02);
    bench_fini(&b);
}

static void faults_of_a_plan_are_named(void **state)
{
    (void)state;
    int32_t fixed[1] = {3}, none[1] = {21};
    bench b;
    bench_init(&b);
    b.s.fixed[3] = 7;
    b.s.plan.load_count = 2;
    b.s.load[0] = (ss_load){.node = fixed, .node_count = 1, .force = {1.0}, .to = 1.0};
    b.s.load[1] = (ss_load){.node = none, .node_count = 1, .pressure = 1.0, .is_pressure = true};
    assert_int_equal(bench_create(&b), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(b.s.error.text, "anchors: load 0 pushes 1 fixed nodes (first 3)"));
    b.s.fixed[3] = 0;
    memset(&b.s.error, 0, sizeof b.s.error);
    assert_int_equal(bench_create(&b), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(b.s.error.text, "no triangle has all its nodes"));
    b.s.plan.load_count = 0;
    memset(&b.s.error, 0, sizeof b.s.error);
    b.density = 1e-60;
    assert_int_equal(bench_create(&b), BY_TYPE(SOFTSIM_ERROR_SCENE, SOFTSIM_OK));
#ifndef SOFTSIM_DOUBLE
    assert_non_null(strstr(b.s.error.text, "too small to divide by"));
    assert_null(b.body);
#endif
    bench_fini(&b);
}

/* ---- identity ----------------------------------------------------------------------------- */

static uint64_t whole_hash(bench *b)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(b->body);
    uint64_t hash = ss_body_hash(b->body, 0xcbf29ce484222325u);
    const unsigned char *byte = (const unsigned char *)nodes->u;
    for (size_t k = 0; k < (size_t)nodes->count * 4 * sizeof(ss_real); ++k) {
        hash = (hash ^ byte[k]) * 0x100000001b3u;
    }
    return hash;
}

static void the_same_run_gives_the_same_bits_also_after_a_reset(void **state)
{
    (void)state;
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    uint64_t hash[2];
    bench_with_ball(&b);
    b.s.plan.gravity[0] = 1.0;
    bench_make(&b);
    for (int k = 0; k < 2; ++k) {
        ss_contact_set set;
        b.time = 0.0;
        press(&b, tool, 6e-3, 60);
        ss_body_contacts(b.body, 0, 0.01, &set);
        tool[0].is_grasping = true;
        hold(&b, tool, 30);
        ss_body_contacts(b.body, 0, 0.01, &set);
        hash[k] = whole_hash(&b);
        ss_body_reset(b.body);
    }
    assert_true(hash[0] == hash[1]);
    bench_fini(&b);
}

static void mass_that_moves_takes_its_weight_along(void **state)
{
    (void)state;
    bench b;
    bench_init(&b);
    b.mass_damping = 60.0;
    b.s.plan.gravity[2] = -5.0;
    bench_make(&b);
    ss_body_set_mass(b.body, 20, 0.01);
    run(&b, 1500, 1e-3, NULL);
    assert_near(at(&b, 20, 2), -5.0 * 0.01 / 10.0, 2e-6);
    assert_near(at(&b, 21, 2), -5.0 * 0.216 / 64.0 / 10.0, 2e-6);
    bench_fini(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_falls_freely_falls_exactly),
        cmocka_unit_test(an_oscillator_has_the_frequency_of_its_method),
        cmocka_unit_test(the_stable_step_is_the_edge_of_stability),
        cmocka_unit_test(a_step_that_is_too_long_does_not_go_unseen),
        cmocka_unit_test(the_ledger_of_ten_thousand_steps_closes),
        cmocka_unit_test(damping_takes_what_is_booked),
        cmocka_unit_test(supports_answer_what_loads_push),
        cmocka_unit_test(driven_nodes_go_at_constant_velocity_and_pay),
        cmocka_unit_test(pressure_pushes_along_the_surface),
        cmocka_unit_test(a_rising_load_gains_nothing),
        cmocka_unit_test(a_tool_gets_back_what_it_gives),
        cmocka_unit_test(the_felt_stiffness_errs_high_but_little),
        cmocka_unit_test(a_grasp_pulls_and_lets_go),
        cmocka_unit_test(a_fast_tool_is_swept_and_does_not_tunnel),
        cmocka_unit_test(a_skin_of_the_nodes_themselves_changes_nothing),
        cmocka_unit_test(a_blow_is_slowed_down_and_said),
        cmocka_unit_test(what_is_not_finite_is_put_back_until_reset),
        cmocka_unit_test(too_small_a_budget_is_slower_than_time_and_said),
        cmocka_unit_test(a_flight_out_of_the_world_is_cut_off),
        cmocka_unit_test(energy_from_nowhere_is_taken_out_and_said),
        cmocka_unit_test(faults_of_a_plan_are_named),
        cmocka_unit_test(the_same_run_gives_the_same_bits_also_after_a_reset),
        cmocka_unit_test(mass_that_moves_takes_its_weight_along),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
