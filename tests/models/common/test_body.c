/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The body that Newtonian models share, under a law with closed forms: motion, energy balance,
 * loads, supports, guards. Tools on it are test_body_contact.c's.
 */
#include "common/test.h"

#include "body_fixture.h"
#include "models/common/plan.h"

/* ---- motion ---- */

TEST(what_falls_freely_falls_exactly)
{
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

TEST(an_oscillator_has_the_frequency_of_its_method)
{
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

TEST(the_stable_step_is_the_edge_of_stability)
{
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

TEST(a_step_that_is_too_long_does_not_go_unseen)
{
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

TEST(the_energy_balance_of_ten_thousand_steps_closes)
{
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

TEST(damping_takes_what_is_booked)
{
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

/* ---- loads and supports ---- */

TEST(supports_answer_what_loads_push)
{
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
    prescribe(&b.s, 3, held, way, 0.1);
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

TEST(prescribed_nodes_go_at_constant_velocity_and_pay)
{
    int32_t held[1] = {10};
    double way[1][3] = {{5e-3, NAN, NAN}};
    bench b;
    bench_init(&b);
    prescribe(&b.s, 1, held, way, 0.05);
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

TEST(pressure_pushes_along_the_surface)
{
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
 * once: that is its work, and no spurious energy. */
TEST(a_rising_load_gains_nothing)
{
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

TEST(mass_that_moves_takes_its_weight_along)
{
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

/* ---- guards ---- */

TEST(a_blow_is_slowed_down_and_said)
{
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

TEST(what_is_not_finite_is_put_back_until_reset)
{
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

TEST(too_small_a_budget_is_slower_than_time_and_said)
{
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

TEST(a_flight_out_of_the_world_is_cut_off)
{
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

TEST(energy_from_nowhere_is_taken_out_and_said)
{
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

/* At its fastest it is pushed on as above for `count` steps of 1 ms, each of which gives it 3 % of
 * its energy, 2 c dt / m; the worst that is told. */
static softsim_verdict pushed_on(int count)
{
    bench b;
    softsim_verdict worst = SOFTSIM_VERDICT_GOOD;
    bench_init(&b);
    bench_make(&b);
    shift(&b, 5e-3);
    run(&b, 28, 1e-3, NULL);
    for (int k = 0; k < 100; ++k) {
        b.law.damping = k < count ? -0.05 : 0.0;
        run(&b, 1, 1e-3, NULL);
        worst = told(&b).verdict > worst ? told(&b).verdict : worst;
    }
    bench_fini(&b);
    return worst;
}

TEST(a_little_energy_from_nowhere_is_guarded)
{
    assert_int_equal(pushed_on(1), SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(pushed_on(2), SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(pushed_on(100), SOFTSIM_VERDICT_DEGRADED);
}

TEST(faults_of_a_plan_are_named)
{
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

/* Two tetrahedra that share nothing: the first held, of the second `k` nodes. */
TEST(a_body_is_held_when_every_part_of_it_is)
{
    static const double x[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                   {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}};
    static const int32_t element[2][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}};
    const double size[8] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(8, x, 0, NULL, 2, element, &mesh, NULL), SOFTSIM_OK);
    for (int k = 0; k <= 4; ++k) {
        uint8_t fixed[8] = {7, 7, 7, 7, 0, 0, 0, 0};
        memset(fixed + 4, 7, (size_t)k);
        const ss_model_plan plan = {.mesh = mesh, .fixed = fixed, .step = 1e-3, .max_substeps = 1};
        bool is_held = false;
        assert_int_equal(ss_plan_check(&plan, "test", size, "", &is_held, NULL), SOFTSIM_OK);
        assert_int_equal(is_held, k >= 3);
    }
    ss_mesh_destroy(&mesh);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
