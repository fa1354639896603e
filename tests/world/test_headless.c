/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The headless world on the bundled kidney: entry, two tools, the energy balance, the schedule. */
#include "common/effort.h"
#include "common/test.h"
#include "kidney_fixture.h"

TEST(an_organ_is_felt_and_comes_back)
{
    SKIP_WHERE_REPEATED();
    softsim_world *world = make_world(1, NULL, 0);
    softsim_force last;
    double peak;
    press_and_release(world, 2000, 0.010, &last, &peak);
    assert_true(peak >= 1.0 && peak <= 4.0); /* N at 10 mm */
    assert_true(magnitude(last.force) == 0.0);
    softsim_state s;
    softsim_read(world, &s);
    assert_true(s.elastic_j + s.kinetic_j < 1e-9);
    assert_true(fabs(s.work_j - s.dissipated_j) < 1e-5);
    softsim_destroy(&world);
}

/* Two spheres that meet, part and cross each other's dents: nothing comes from nowhere. */
TEST(two_tools_close_together_keep_the_energy_balance)
{
    SKIP_WHERE_REPEATED();
    softsim_world *world = make_world(1, NULL, 0);
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_state s;
    double largest = 0.0, worst = 0.0;
    for (int32_t k = 0; k < 1600; ++k) {
        const double t = 2.5e-3 * k;
        const double down = smooth(2.0 * t) - smooth(2.0 * (t - 3.0));
        const double lift = smooth(3.0 * (t - 1.2)) - smooth(3.0 * (t - 1.9));
        const softsim_pose pose[2] = {
            pose_at(0, k + 1, 0.012 * cos(3.0 * t), 0.006, TOUCH + 0.004 - 0.010 * down),
            pose_at(1, k + 1, -0.012 * cos(2.0 * t), 0.006,
                    TOUCH + 0.006 - 0.012 * down + 0.009 * lift)};
        const int32_t channel[2] = {0, 1};
        softsim_tick(world, pose, channel, 2, force);
        softsim_read(world, &s);
        assert_true(s.verdict <= SOFTSIM_VERDICT_GUARDED);
        largest = fmax(largest, s.elastic_j);
        worst = fmax(worst, s.elastic_j + s.kinetic_j + s.dissipated_j - s.work_j);
    }
    print_message("energy balance: gained at most %.3g of the largest stored energy\n",
                  worst / largest);
    assert_true(worst <= 5e-3 * largest);
    softsim_destroy(&world);
}

/* Beside the hilum, where the tissue's stiffness changes along the surface: in at one place, out
 * again at another, and back, 1.2 s a turn, both ways round. A hand is given no energy by it, be
 * the device silent about the forces it had or not. */
TEST(a_closed_path_beside_the_hilum_gives_no_energy)
{
    static const double touch[3] = {-0.0098092, -0.0133178, 0.0228269};
    static const double in[3] = {-0.0510048, 0.5174279, -0.8542054};
    static const double aside[3] = {0.0, 0.8553187, 0.5181022};
    /* m: depth and way aside at the corners, both ways round from the first. */
    static const double corner[4][2] = {{0.016, 0.0}, {0.016, 0.010}, {0.006, 0.010}, {0.006, 0.0}};
    enum { ENTRY = 500, SIDE = 300, TURNS = 3, END = ENTRY + TURNS * 4 * SIDE };
    SKIP_WHERE_REPEATED();
    for (int way = 0; way < 3; ++way) {
        softsim_world *world = make_world(1, NULL, 0);
        softsim_force force[SOFTSIM_MAX_PROBES];
        double last[3] = {0}, before[3] = {0}, given = 0.0, stored = 0.0, turn[TURNS] = {0};
        int32_t seq = -1;
        for (int32_t k = 0; k <= END; ++k) {
            const int32_t n = k < ENTRY ? 0 : (k - ENTRY) / SIDE;
            const int from = way == 1 ? (4 - n % 4) % 4 : n % 4;
            const int to = way == 1 ? (from + 3) % 4 : (from + 1) % 4;
            const double u = k < ENTRY ? 0.0 : smooth((double)(k - ENTRY - n * SIDE) / SIDE);
            double deep = corner[from][0] + u * (corner[to][0] - corner[from][0]);
            const double side = corner[from][1] + u * (corner[to][1] - corner[from][1]);
            deep = k < ENTRY ? -0.004 + 0.020 * smooth((double)k / ENTRY) : deep;
            double x[3];
            for (int a = 0; a < 3; ++a) {
                x[a] = touch[a] + deep * in[a] + side * aside[a];
            }
            softsim_pose pose = pose_at(0, k + 1, x[0], x[1], x[2]);
            pose.force_seq = way == 2 ? seq : -1;
            const int32_t channel = 0;
            softsim_tick(world, &pose, &channel, 1, force);
            seq = force[0].seq;
            for (int a = 0; k > 0 && a < 3; ++a) {
                const double work = 0.5 * (force[0].force[a] + before[a]) * (x[a] - last[a]);
                given += work;
                turn[n / 4 < TURNS ? n / 4 : TURNS - 1] += k > ENTRY ? work : 0.0;
            }
            stored = fmax(stored, -given);
            memcpy(last, x, sizeof last);
            memcpy(before, force[0].force, sizeof before);
        }
        print_message("way %d: the hand was given %.2f, %.2f, %.2f mJ a turn, stored %.1f\n", way,
                      1e3 * turn[0], 1e3 * turn[1], 1e3 * turn[2], 1e3 * stored);
        for (int n = 0; n < TURNS; ++n) {
            assert_true(turn[n] <= fmax(1e-3, 0.05 * stored));
        }
        softsim_destroy(&world);
    }
}

/* Found 10 mm inside, the tool is let in by fading: no force at first, then that of the place. */
TEST(a_tool_found_inside_is_let_in_over_half_a_second)
{
    SKIP_WHERE_REPEATED();
    softsim_world *world = make_world(1, NULL, 0);
    softsim_force force[SOFTSIM_MAX_PROBES];
    double early = 0.0, largest_step = 0.0, before = 0.0;
    for (int32_t k = 0; k < 800; ++k) {
        const softsim_pose pose = pose_at(0, k + 1, 0.0, 0.006, TOUCH - 0.010);
        const int32_t channel = 0;
        softsim_tick(world, &pose, &channel, 1, force);
        const double size = magnitude(force[0].force);
        early = k < 20 ? fmax(early, size) : early;
        largest_step = fmax(largest_step, fabs(size - before));
        before = size;
        if (k > 10 && k < 400) {
            assert_true(force[0].flags & SOFTSIM_FORCE_RAMPING);
        }
    }
    assert_true(early < 0.2);
    assert_true(largest_step < 0.05);
    assert_true(force[0].force[2] > 1.0 && before < 4.0);
    softsim_destroy(&world);
}

/* In lockstep a result is taken exactly one simulation period after its pose. */
TEST(results_come_one_period_late)
{
    static const char *const rate[] = {"simulation.rate_hz=100"};
    softsim_world *world = make_world(1, rate, 1);
    softsim_force force[SOFTSIM_MAX_PROBES];
    for (int32_t k = 0; k < 100; ++k) {
        const softsim_pose pose = pose_at(0, k + 1, 0.0, 0.006, TOUCH + 0.02);
        const int32_t channel = 0;
        softsim_tick(world, &pose, &channel, 1, force);
        if (k >= 20) {
            /* Steps begin at ticks 1, 11, 21, ...: the newest result's pose is 10 to 19 ticks old.
             */
            assert_int_equal(force[0].model_age_us, 1000 * (10 + k % 10));
        }
    }
    softsim_destroy(&world);
}

/* Its share of the energy is rounding there, whose gain once had sub-steps repeated: eleven a step,
 * longer than the step's own time. The bound asks for one to three. */
TEST(a_tool_that_stands_beside_the_body_repeats_no_substep)
{
    softsim_world *world = make_world(1, NULL, 0);
    int32_t seq = 0;
    for (double gap = 0.0028; gap > -0.0002; gap -= 0.0004) {
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_state now;
        for (int32_t k = 0; k < 50; ++k) {
            const softsim_pose pose = pose_at(0, ++seq, 0.0, 0.006, TOUCH + 0.001 + gap);
            const int32_t channel = 0;
            softsim_tick(world, &pose, &channel, 1, force);
        }
        softsim_read(world, &now);
        assert_true(magnitude(force[0].force) == 0.0);
        assert_true(now.substeps <= ceil(now.simulation_period_s / (0.69 * now.stable_step_s)));
    }
    softsim_destroy(&world);
}

/* The worst verdict is that of the steps, not of those that happened to be read. */
TEST(the_worst_verdict_needs_no_reading)
{
    SKIP_WHERE_REPEATED();
    static const char *const fine[] = {"object.mesh=" KIDNEY_MESH}; /* the coarse one is calm */
    softsim_world *watched = make_world(1, fine, 1);
    softsim_world *left_alone = make_world(2, fine, 1);
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_verdict worst = SOFTSIM_VERDICT_GOOD;
    char reason[128] = "";
    softsim_state s;
    softsim_read(watched, &s);
    assert_int_equal(s.worst_verdict, SOFTSIM_VERDICT_GOOD);
    assert_string_equal(s.worst_reason, "");
    for (int32_t k = 0; k < 3000 && (k < 300 || s.verdict != SOFTSIM_VERDICT_GOOD); ++k) {
        const softsim_pose pose =
            pose_at(0, k + 1, 0.0, 0.006, TOUCH + 0.003 - 0.030 * smooth(k / 20.0));
        const int32_t channel = 0;
        softsim_tick(left_alone, &pose, &channel, 1, force);
        softsim_tick(watched, &pose, &channel, 1, force);
        softsim_read(watched, &s);
        if (s.verdict > worst) {
            worst = s.verdict;
            snprintf(reason, sizeof reason, "%s", s.reason);
        }
    }
    assert_int_equal(s.verdict, SOFTSIM_VERDICT_GOOD); /* at the end */
    assert_true(worst > SOFTSIM_VERDICT_GOOD);         /* in between */
    assert_int_equal(s.worst_verdict, worst);
    assert_string_equal(s.worst_reason, reason);
    softsim_read(left_alone, &s);
    assert_int_equal(s.worst_verdict, worst);
    assert_string_equal(s.worst_reason, reason);
    softsim_destroy(&watched);
    softsim_destroy(&left_alone);
}

/* So light that a tick takes some dozens of sub-steps. Without a clock to meet it gets them. */
TEST(a_run_without_a_clock_has_no_budget)
{
    static const char *const set[3][3] = {
        {"model.area_density_kg_m2=1e-3", "model.damping_n_s_per_m3=10",
         "simulation.max_substeps=2"},
        {"model.area_density_kg_m2=1e-3", "model.damping_n_s_per_m3=10",
         "simulation.max_substeps=1000"},
        {"model.area_density_kg_m2=1e-3", "model.damping_n_s_per_m3=10",
         "simulation.max_substeps=2"},
    };
    const int32_t ticks = FULL_IN_LONG_RUN(150, FULL_IN_RELEASE(40, 10));
    const int32_t before = FULL_IN_LONG_RUN(0, 55); /* of them the tool is still above the tissue */
    uint64_t hash[3];
    softsim_state s[3];
    for (int run = 0; run < 3; ++run) {
        const char *all[KIDNEY_SETS];
        softsim_config config = softsim_default_config();
        config.set_count = kidney_sets(set[run], 3, all);
        config.set = all;
        config.has_budget = run == 2;
        softsim_world *world = make_world_with(KIDNEY, config);
        for (int32_t k = 0; k < ticks; ++k) {
            softsim_force force[SOFTSIM_MAX_PROBES];
            const softsim_pose pose =
                pose_at(0, k + 1, 0.0, 0.006, TOUCH + 0.001 - 0.004 * smooth((k + before) / 150.0));
            const int32_t channel = 0;
            softsim_tick(world, &pose, &channel, 1, force);
        }
        softsim_read(world, &s[run]);
        hash[run] = softsim_hash(world);
        print_message("%d sub-steps a tick, worst verdict %d (%s)\n", s[run].substeps,
                      (int)s[run].worst_verdict, s[run].worst_reason);
        softsim_destroy(&world);
    }
    assert_true(s[0].substeps > 2);
    assert_true(hash[0] == hash[1]);
    assert_true(s[0].worst_verdict <= SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(s[2].worst_verdict, SOFTSIM_VERDICT_DEGRADED);
    assert_non_null(strstr(s[2].worst_reason, "max_substeps"));
}

TEST(a_configuration_without_its_cookie_is_refused)
{
    const softsim_config config = {0};
    softsim_error error = {0};
    assert_null(softsim_create(KIDNEY, &config, &error));
    assert_int_equal(error.status, SOFTSIM_ERROR_ARGUMENT);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
