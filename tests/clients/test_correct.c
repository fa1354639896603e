/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The force in effect at the device: corrected for the time it took, within limits, and damped
 * where its contact has given all. */
#include "common/test.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "common/number_fixture.h"
#include "correct.h"
#include "rt/vec.h"

static softsim_force make_force(int32_t pose_seq)
{
    return (softsim_force){.seq = 40 + pose_seq,
                           .pose_seq = pose_seq,
                           .flags = SOFTSIM_FORCE_CONTACT,
                           .force = {0.25, 0.0, 1.0},
                           .normal = {0.0, 0.0, 1.0},
                           .stiffness = 500.0};
}

TEST(correction_follows_the_normal)
{
    static ss_corrector c;
    const double at[3] = {0.01, 0.02, -0.002};
    double force[3];
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    ss_corrector_force(&c, 0, at, force);
    assert_true(force[0] == 0.0 && force[2] == 0.0 && ss_corrector_force_seq(&c, 0) == -1);
    ss_corrector_note_pose(&c, 1, 1000000, at);
    const softsim_force given = make_force(1);
    ss_corrector_take_force(&c, &given, 3000000);
    assert_int_equal(ss_corrector_force_seq(&c, 3000000), 41);
    const double deeper[3] = {0.013, 0.02, -0.003};
    ss_corrector_force(&c, 3000000, deeper, force);
    assert_near(force[0], 0.25, 0.0); /* tangential part as it was */
    assert_near(force[2], 1.5, 1e-12);
    const double out[3] = {0.01, 0.02, 0.0015};
    ss_corrector_force(&c, 3000000, out, force);
    assert_near(force[2], 0.0, 0.0); /* never pulls in, */
    assert_near(force[0], 0.0, 0.0); /* and nothing is left across */
    const double half[3] = {0.01, 0.02, -0.001};
    ss_corrector_force(&c, 3000000, half, force);
    assert_near(force[2], 0.5, 1e-12);
    assert_near(force[0], 0.125, 1e-12);
}

TEST(correction_is_bounded)
{
    static ss_corrector c;
    static const struct {
        const char *what;
        bool is_enabled;
        double stiffness, normal_z, force_z, moved;
        int32_t pose_seq;
        int64_t now_ns;
        double expected;
    } cases[] = {
        {"corrected", true, 500, 1, 1, -1e-3, 5, 10000000, 1.5},
        {"off", false, 500, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness 0", true, 0, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness negative", true, -500, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness beyond any coupling", true, 1e9, 1, 1, -1e-3, 5, 10000000, 21.0},
        {"moved 15.1 mm", true, 500, 1, 1, -15.1e-3, 5, 10000000, 1.0},
        {"moved 14.9 mm", true, 500, 1, 1, -14.9e-3, 5, 10000000, 8.45},
        {"pulling force", true, 500, 1, -1, -1e-3, 5, 10000000, -1.0},
        {"no unit normal", true, 500, 0.9, 1, -1e-3, 5, 10000000, 1.0},
        {"normal zero", true, 500, 0, 1, -1e-3, 5, 10000000, 1.0},
        {"pose 49 ms old", true, 500, 1, 1, -1e-3, 5, 49000000, 1.5},
        {"pose 51 ms old", true, 500, 1, 1, -1e-3, 5, 51000000, 1.0},
        {"pose unknown", true, 500, 1, 1, -1e-3, 6, 10000000, 1.0},
        {"pose negative", true, 500, 1, 1, -1e-3, -3, 10000000, 1.0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double at[3] = {0.0, 0.0, 0.0};
        const double now_at[3] = {0.0, 0.0, cases[i].moved};
        double out[3];
        softsim_force force = make_force(cases[i].pose_seq);
        force.stiffness = cases[i].stiffness;
        force.normal[2] = cases[i].normal_z;
        force.force[2] = cases[i].force_z;
        ss_corrector_init(&c, cases[i].is_enabled, ss_corrector_unlimited);
        ss_corrector_note_pose(&c, 5, 0, at);
        ss_corrector_take_force(&c, &force, cases[i].now_ns);
        ss_corrector_force(&c, cases[i].now_ns, now_at, out);
        if (!(fabs(out[2] - cases[i].expected) < 1e-9) || out[0] != 0.25) {
            fail_msg("%s: %.12g, not %g", cases[i].what, out[2], cases[i].expected);
        }
    }
}

/* 1 N, answered 3 mm ago; 500 N/m would make it 2.5 N. The limit holds, and that of an answer which
 * is above it; one that is not known yet leaves the answer's size. */
TEST(correction_stays_within_the_limit)
{
    static ss_corrector c;
    static const struct {
        double limit, given, expected;
    } cases[] = {{5.0, 1.0, 2.5}, {2.0, 1.0, 2.0}, {0.8, 1.0, 1.0}, {0.0, 1.0, 1.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double at[3] = {0.0, 0.0, 0.0}, deeper[3] = {0.0, 0.0, -3e-3};
        const ss_corrector_limits limits = {cases[i].limit, INFINITY};
        softsim_force force = make_force(1);
        double out[3];
        ss_set3(force.force, 0.0, 0.0, cases[i].given);
        ss_corrector_init(&c, true, limits);
        ss_corrector_note_pose(&c, 1, 0, at);
        ss_corrector_take_force(&c, &force, 1000000);
        ss_corrector_force(&c, 1000000, deeper, out);
        assert_near(ss_norm3(out), cases[i].expected, 1e-12);
    }
}

/* What a scene's report says, and what is no limit. */
TEST(limits_are_those_that_the_server_tells)
{
    static const struct {
        const char *force, *slew;
        double expected[2];
    } cases[] = {
        {"haptic.max_force_n=3 0.1 8 N", "haptic.max_slew_n_per_s=500 10 2000 N/s", {3.0, 500.0}},
        {"haptic.max_force_n=nan 0 1 N", "haptic.max_slew_n_per_s=1e-300 0 1 N/s", {0.0, 2000.0}},
        {"haptic.max_force_n=-1 0 1 N", "haptic.max_slew_n_per_s=inf 0 1 N/s", {0.0, 2000.0}},
        {"haptic.max_force_newton=3 0 1 N", "haptic.max_slew_n_per_s= 0 1", {0.0, 2000.0}},
    };
    static ss_bridge bridge;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const softsim_scene_report scene = {.parameter_count = 2,
                                            .parameter = {cases[i].force, cases[i].slew}};
        ss_bridge_take_scene(&bridge, &scene);
        assert_near(bridge.corrector.limits.force_n, cases[i].expected[0], 0.0);
        assert_near(bridge.corrector.limits.slew_n_per_s, cases[i].expected[1], 0.0);
    }
}

/* From 4 N to none and back, answers of one ms to the next: 2 N a ms, either way. */
TEST(the_force_moves_by_the_slew)
{
    static ss_corrector c;
    const ss_corrector_limits limits = {10.0, 2000.0};
    const double at[3] = {0.0, 0.0, 0.0}, expected[] = {4.0, 2.0, 0.0, 0.0, 2.0, 4.0, 4.0};
    ss_corrector_init(&c, true, limits);
    for (int32_t ms = 0; ms < 7; ++ms) {
        softsim_force force = make_force(1);
        double out[3];
        ss_set3(force.force, 0.0, 0.0, ms == 0 || ms > 3 ? 4.0 : 0.0);
        ss_corrector_take_force(&c, &force, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, out);
        assert_near(out[2], expected[ms], 1e-12);
    }
}

/* 10 kN that nobody felt, then 1 N: by the slew it would take five seconds. What moved meanwhile
 * was neither given nor taken. */
TEST(a_force_that_was_withheld_is_no_beginning)
{
    static ss_corrector c;
    const ss_corrector_limits limits = {0.0, 2000.0};
    ss_corrector_init(&c, true, limits);
    for (int32_t ms = 0; ms < 60; ++ms) {
        const double at[3] = {0.0, 0.0, -1e-4 * fmin(ms, 50.0)};
        softsim_force force = make_force(0);
        double out[3];
        ss_set3(force.force, 0.0, 0.0, ms < 50 ? 1e4 : 1.0);
        ss_corrector_take_force(&c, &force, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, out);
        if (ms < 51) {
            ss_corrector_withhold(&c, 1.0);
        } else {
            assert_near(out[2], 1.0, 1e-12);
        }
        assert_near(c.energy_j, 0.0, 0.0);
    }
}

/* Silent for 100 ms, and there again. */
TEST(force_comes_back_slowly_after_a_silence)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0};
    softsim_force force = make_force(1);
    double last = 1.0;
    ss_set3(force.force, 0.0, 0.0, 1.0);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int32_t ms = 0; ms < 400; ++ms) {
        double out[3];
        if (ms < 100 || ms >= 200) {
            ss_corrector_take_force(&c, &force, ms * 1000000LL);
        }
        ss_corrector_force(&c, ms * 1000000LL, at, out);
        assert_true(out[2] - last <= 1.0 / 50.0 + 1e-12);
        assert_true(ms < 180 || ms >= 200 || out[2] == 0.0);
        assert_true(ms < 250 || out[2] == 1.0);
        last = out[2];
    }
}

/* A grasp pulls, pushes and holds aside; its law has no side that it stops at. */
TEST(correction_of_a_grasp_is_signed_and_goes_all_ways)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0}, moved[3] = {1e-3, -2e-3, 4e-3};
    double out[3];
    softsim_force force = make_force(5);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    ss_corrector_note_pose(&c, 5, 0, at);
    force.flags |= SOFTSIM_FORCE_GRASPING;
    ss_corrector_take_force(&c, &force, 0);
    ss_corrector_force(&c, 0, moved, out);
    assert_near(out[0], 0.25 - 500 * 1e-3, 1e-12);
    assert_near(out[1], 500 * 2e-3, 1e-12);
    assert_near(out[2], 1.0 - 500 * 4e-3, 1e-12);
    force.force[2] = -3.0;
    force.normal[2] = 0.0; /* has none */
    ss_corrector_take_force(&c, &force, 0);
    ss_corrector_force(&c, 0, moved, out);
    assert_near(out[2], -3.0 - 500 * 4e-3, 1e-12);
}

/* Answered 18 um ago: what a grasp that was let go still pulls aside, with next to no normal force,
 * went with that. */
TEST(what_fades_across_the_normal_stays)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0}, moved[3] = {0.0, 0.0, 18e-6};
    const double left[3] = {1e-3, 0.0, 0.0};
    double out[3];
    softsim_force force = make_force(5);
    ss_set3(force.force, 1.5, 0.0, 1e-3);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    ss_corrector_note_pose(&c, 5, 0, at);
    ss_corrector_take_force(&c, &force, 0);
    ss_corrector_force(&c, 0, moved, out);
    assert_near(out[0], 1.5 - 1e-3, 1e-12);
    assert_near(out[2], 0.0, 1e-12);
    ss_corrector_force(&c, 0, left, out); /* as far as its own way gives it back */
    assert_near(out[0], 1.5 - 500 * 1e-3, 1e-12);
}

/* A hand that follows a grasp's pull, and lets go: from one tick to the next nothing. */
TEST(the_end_of_a_grasp_is_no_step)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0}, moved[3] = {-6e-3, 0.0, 0.0};
    double out[3];
    softsim_force force = make_force(5);
    ss_set3(force.force, -5.0, 0.0, 0.0);
    force.flags |= SOFTSIM_FORCE_GRASPING;
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    ss_corrector_note_pose(&c, 5, 0, at);
    for (int ms = 0; ms < 60; ++ms) {
        const double time = 1e-3 * (ms - 1);
        force.flags &= ms < 1 ? -1 : ~SOFTSIM_FORCE_GRASPING;
        force.stiffness = ms < 1 ? 500.0 : 0.0;
        ss_corrector_take_force(&c, &force, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, moved, out);
        assert_true(fabs(out[0] + 5.0 - 3.0 * (ms < 1 ? 1.0 : exp(-time / 0.02))) < 0.2);
    }
}

/* Who loses the probe lets go at once, and what was held before a silence is not felt after it. */
TEST(a_grasp_that_is_lost_leaves_nothing)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0};
    double out[3];
    for (int is_silent = 0; is_silent < 2; ++is_silent) {
        softsim_force force = make_force(5);
        ss_set3(force.force, 5.0, 0.0, 0.0);
        force.flags |= SOFTSIM_FORCE_GRASPING;
        ss_corrector_init(&c, true, ss_corrector_unlimited);
        ss_corrector_take_force(&c, &force, 0);
        for (int64_t ms = 0; ms < (is_silent ? 500 : 10); ++ms) {
            ss_corrector_force(&c, ms * 1000000, at, out);
        }
        ss_set3(force.force, 0.0, 0.0, 0.0);
        force.flags = is_silent ? 0 : SOFTSIM_FORCE_OTHER_SENDER;
        for (int64_t ms = 500; ms < 600; ++ms) {
            ss_corrector_take_force(&c, &force, ms * 1000000);
            ss_corrector_force(&c, ms * 1000000, at, out);
            assert_near(ss_norm3(out), 0.0, 1e-12);
        }
    }
}

TEST(force_fades_when_the_server_is_gone)
{
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0};
    double out[3];
    const softsim_force force = make_force(1);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    ss_corrector_take_force(&c, &force, 1000000000);
    double last = 1.0;
    for (int ms = 0; ms <= 100; ++ms) {
        ss_corrector_force(&c, 1000000000 + ms * 1000000LL, at, out);
        assert_near(out[2], ms <= 50 ? 1.0 : fmax(0.0, 1.0 - (ms - 50) / 20.0), 1e-12);
        assert_true(out[2] <= last);
        last = out[2];
    }
    assert_int_equal(ss_corrector_force_seq(&c, 1100000000), -1);
}

/* 2 N against a hand that goes `in_mm` in and `out_mm` out at 0.2 m/s: the energy that it is left
 * with, and whether it felt the whole force throughout. */
static double energy_of_a_stroke(int in_mm, int out_mm, bool *out_is_whole)
{
    static ss_corrector c;
    double force[3] = {0.0, 0.0, 0.0}, at[3] = {0.0, 0.0, 0.0}, energy = 0.0;
    softsim_force given = make_force(1);
    given.stiffness = 0.0;
    ss_set3(given.force, 0.0, 0.0, 2.0);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    *out_is_whole = true;
    const int in_ms = in_mm * 5, out_ms = out_mm * 5;
    for (int ms = 0; ms <= in_ms + out_ms; ++ms) {
        const double z = 0.2e-3 * (ms < in_ms ? -ms : ms - 2 * in_ms);
        energy -= force[2] * (z - at[2]);
        at[2] = z;
        ss_corrector_take_force(&c, &given, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, force);
        assert_true(force[0] == 0.0 && force[1] == 0.0 && force[2] >= 0.0 && force[2] <= 2.0);
        *out_is_whole = *out_is_whole && force[2] == 2.0;
    }
    return energy;
}

/* Let in to the force limit, where the server tells no stiffness, by a tool that goes in 2 mm and
 * out 20: what is given is counted from the end of the entry on. */
TEST(an_entry_that_ends_at_the_limit_gives_no_more_than_a_slip_of_5_mm)
{
    static ss_corrector c;
    double force[3] = {0.0, 0.0, 0.0}, at[3] = {0.0, 0.0, 0.0}, energy = 0.0;
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int ms = 0; ms <= 210; ++ms) {
        softsim_force given = make_force(1);
        given.stiffness = 0.0;
        given.flags |= ms < 100 ? SOFTSIM_FORCE_RAMPING : SOFTSIM_FORCE_LIMITED;
        ss_set3(given.force, 0.0, 0.0, fmin(2.0, ms / 50.0));
        const double z = 0.2e-3 * (ms < 110 ? -fmax(0.0, ms - 100) : ms - 120);
        energy -= force[2] * (z - at[2]);
        at[2] = z;
        ss_corrector_take_force(&c, &given, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, force);
    }
    /* 5 mm of slip at 2 N may have been stored in the entry. */
    assert_true(energy > -10e-3 - 1.5e-3);
}

/* What a contact has not taken it does not give: 40 mJ else. What it has, it does, but for the last
 * 2 mJ, which the next 5 ms would take. */
TEST(a_contact_gives_no_more_than_it_took)
{
    bool is_whole;
    assert_near(energy_of_a_stroke(10, 0, &is_whole), 20e-3, 1e-9);
    assert_true(is_whole);
    assert_near(energy_of_a_stroke(10, 8, &is_whole), 4e-3, 1e-9);
    assert_true(is_whole);
    assert_true(energy_of_a_stroke(10, 30, &is_whole) > -1e-3);
    assert_false(is_whole);
    assert_true(energy_of_a_stroke(0, 20, &is_whole) > -1.5e-3);
    assert_false(is_whole);
}

/* 3 N that hold on a hand which went 10 mm in, and leaves at .6 m/s, go over some periods. */
TEST(a_contact_that_has_given_all_fades)
{
    static ss_corrector c;
    double force[3] = {0.0, 0.0, 0.0}, at[3] = {0.0, 0.0, 0.0}, last = 3.0, largest = 0.0;
    softsim_force given = make_force(1);
    given.stiffness = 0.0;
    ss_set3(given.force, 0.0, 0.0, 3.0);
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int ms = 0; ms <= 100; ++ms) {
        at[2] = ms < 50 ? -0.2e-3 * ms : -10e-3 + 0.6e-3 * (ms - 50);
        ss_corrector_take_force(&c, &given, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, force);
        largest = fmax(largest, last - force[2]);
        last = force[2];
    }
    assert_true(last < 0.1);
    assert_true(largest < 0.8);
}

/* A tap leaves at 0.4 m/s with credit for two more ticks of its force, which falls by 0.1 N a ms:
 * what was taken off once does not come back whole as soon as the credit is enough for what is
 * left. */
TEST(what_is_taken_off_comes_back_slowly)
{
    static ss_corrector c;
    softsim_force given = make_force(1);
    double at[3] = {0.0, 0.0, 0.0}, force[3], last = INFINITY;
    bool is_taken = false;
    given.stiffness = 0.0;
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int ms = 0; ms < 26; ++ms) {
        const int out_ms = ms - 6;
        ss_set3(given.force, 0.0, 0.0, fmin(2.0, 2.0 - 0.1 * out_ms));
        at[2] += out_ms < 0 ? -0.2e-3 : 0.4e-3;
        ss_corrector_take_force(&c, &given, ms * 1000000LL);
        ss_corrector_force(&c, ms * 1000000LL, at, force);
        assert_true(force[2] - last < 0.1);
        is_taken = is_taken || (ms > 6 && force[2] < 0.5 * given.force[2]);
        last = force[2];
    }
    assert_true(is_taken);
}

/* The steepest change, N a ms, of a force of at most `limit` N that a server lets in. */
static double buzz_on_the_way_out(double limit)
{
    static ss_corrector c;
    softsim_force f = {.normal = {0, 0, 1}, .pose_seq = 1};
    double last = 0.0, worst = 0.0;
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int32_t k = 1; k <= 1000; ++k) {
        const int64_t now_ns = 1000000 * (int64_t)k;
        const double z = -6e-3 + 5e-3 * k / 1000.0, at[3] = {0.0, 0.0, 30e-6 * round(z / 30e-6)};
        const double share = fmin(1.0, k / 500.0);
        double out[3];
        ss_corrector_note_pose(&c, k, now_ns, at);
        f.pose_seq = k;
        f.force[2] = fmin(limit, -300.0 * z) * share;
        f.stiffness = k < 500 || -300.0 * z >= limit ? 0.0 : 300.0;
        f.flags = k < 500 ? SOFTSIM_FORCE_RAMPING : 0;
        ss_corrector_take_force(&c, &f, now_ns);
        ss_corrector_force(&c, now_ns, at, out);
        worst = fmax(worst, fabs(out[2] - last));
        last = out[2];
    }
    return worst;
}

/* After a gap a server lets a tool in that was found 6 mm deep, flagged, while the hand comes out
 * slowly, as a device of 30 um a count tells: what it is given had been pressed in for it, and its
 * force does not fall at each count, at a force limit neither. */
TEST(a_force_that_is_let_in_does_not_buzz_on_the_way_out)
{
    static const double limits[] = {8.0, 0.5};
    for (int k = 0; k < 2; ++k) {
        assert_true(buzz_on_the_way_out(limits[k]) < 0.02); /* a count is 9 mN */
    }
}

/* A hand and device of `mass` kg, held by 60 N/m, that shakes what it has grasped 8 times a second
 * for a second and is still then, behind a bus of 10 ms each way: the way that the force goes in
 * the last half second, N. The tissue has 350 N/m; positions come in counts of 30 um. */
static double force_way_at_rest(double mass)
{
    enum { BUS = 10, TICKS = 3000, SHAKEN = 1000, LATE = 2500 };
    static ss_corrector c;
    static double told[TICKS];
    double x = 0.0, v = 0.0, last = 0.0, way = 0.0;
    ss_corrector_init(&c, true, ss_corrector_unlimited);
    for (int n = 0; n < TICKS; ++n) {
        const double aim = n < SHAKEN ? 0.015 * cos(2.0 * SS_PI * 8e-3 * n) : 0.015;
        const int64_t now_ns = 1000000LL * n;
        told[n] = 30e-6 * round(x / 30e-6);
        const double at[3] = {0.0, 0.0, told[n]};
        ss_corrector_note_pose(&c, n + 1, now_ns, at);
        if (n >= 2 * BUS) {
            softsim_force f = {
                .normal = {0, 0, 1}, .pose_seq = n + 1 - 2 * BUS, .stiffness = 350.0};
            f.flags = SOFTSIM_FORCE_CONTACT | SOFTSIM_FORCE_GRASPING;
            f.force[2] = -350.0 * told[n - 2 * BUS];
            ss_corrector_take_force(&c, &f, now_ns);
        }
        double force[3];
        ss_corrector_force(&c, now_ns, at, force);
        way += n >= LATE ? fabs(force[2] - last) : 0.0;
        last = force[2];
        for (int k = 0; k < 10; ++k) {
            v += 1e-4 / mass * (60.0 * (aim - x) - 1.4 * sqrt(60.0 * mass) * v + force[2]);
            x += 1e-4 * v;
        }
    }
    print_message("%g kg: %.3f N\n", mass, way);
    return way;
}

/* What damps a debt is late by the filter of its velocity, and is not to swing a light hand. */
TEST(a_light_hand_that_comes_to_rest_in_debt_is_left_in_peace)
{
    assert_true(force_way_at_rest(0.06) < 2.0);
    assert_true(force_way_at_rest(0.1) < 2.0);
    assert_true(force_way_at_rest(0.3) < 2.0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
