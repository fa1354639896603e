/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What the hand is given behind a bus, in closed loop (tools/bench/felt/hand.h): some of the rows
 * of `softsim-bench felt --hands`, those that handed out most without damping and back-off, and
 * good contacts, in which neither may act.
 */
#include "common/test.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/felt/hand.h"
#include "common/effort.h"
#include "haptic_fixture.h"

typedef struct row {
    ss_sim_script script;
    ss_sim_body body;
    ss_sim_grip grip;
    double tissue, rate_hz, delay_ms;
    bool corrects;
    double outlier;
} row;

static void play(const row *r, ss_hand_outcome *out)
{
    static const char *const script[] = {"press", "poke", "tap", "slide"};
    const ss_hand_run run = {.body = r->body,
                             .grip = r->grip,
                             .script = r->script,
                             .seed = 1,
                             .bus = {.delay_ms = r->delay_ms, .outlier = r->outlier},
                             .is_correcting = r->corrects,
                             .seconds = 2.0,
                             .rate_hz = r->rate_hz,
                             .tissue_n_per_m = r->tissue,
                             .stiffness_n_per_m = 800.0,
                             .damping_n_s_per_m = 2.0};
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_hand_play(&run, out, &error), SOFTSIM_OK);
    print_message(
        "%s, device %d, grip %d, %g N/m at %g Hz, %g ms%s%s: net %.2f mJ, chatter %.4f mm, "
        "damped %lld, back-offs %lld, limit %.0f N/m\n",
        script[r->script], r->body, r->grip, r->tissue, r->rate_hz, r->delay_ms,
        r->corrects ? " corrected" : "", r->outlier > 0.0 ? " outliers" : "", 1e3 * out->net_j,
        1e3 * out->felt.chatter_m.value, (long long)out->damped_ticks, (long long)out->backoffs,
        out->least_limit_n_per_m);
}

TEST(a_late_bus_hands_out_little)
{
    static const row rows[] = {
        {SS_SCRIPT_POKE, SS_BODY_LIGHT, SS_GRIP_SOFT, 3000, 1000, 10, false, 0},
        {SS_SCRIPT_POKE, SS_BODY_LIGHT, SS_GRIP_SOFT, 300, 1000, 5, false, 0},
        {SS_SCRIPT_POKE, SS_BODY_LIGHT, SS_GRIP_SOFT, 3000, 1000, 10, true, 0},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_FIRM, 150, 60, 0, false, 0},
        {SS_SCRIPT_TAP, SS_BODY_MEDIUM, SS_GRIP_SOFT, 300, 1000, 5, false, 0},
        {SS_SCRIPT_TAP, SS_BODY_MEDIUM, SS_GRIP_SOFT, 150, 60, 10, false, 0},
        {SS_SCRIPT_PRESS, SS_BODY_LIGHT, SS_GRIP_SOFT, 3000, 1000, 10, true, 0},
        {SS_SCRIPT_TAP, SS_BODY_MEDIUM, SS_GRIP_SOFT, 150, 60, 10, true, 0},
        {SS_SCRIPT_TAP, SS_BODY_HEAVY, SS_GRIP_FIRM, 300, 60, 5, true, 0},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_SOFT, 150, 1000, 10, true, 0.05},
        {SS_SCRIPT_SLIDE, SS_BODY_MEDIUM, SS_GRIP_SOFT, 3000, 1000, 10, true, 0},
        {SS_SCRIPT_SLIDE, SS_BODY_MEDIUM, SS_GRIP_SOFT, 3000, 1000, 10, true, 0.05},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_MEDIUM, 50, 1000, 10, false, 0.05},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_SOFT, 3000, 60, 1, false, 0.05},
        {SS_SCRIPT_TAP, SS_BODY_HEAVY, SS_GRIP_MEDIUM, 50, 1000, 0, false, 0.05},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_SOFT, 50, 1000, 5, false, 0},
        {SS_SCRIPT_POKE, SS_BODY_MEDIUM, SS_GRIP_SOFT, 50, 60, 5, false, 0.05},
    };
    for (size_t k = 0; k < FULL_IN_RELEASE(sizeof rows / sizeof *rows, 2); ++k) {
        ss_hand_outcome out;
        play(&rows[k], &out);
        assert_true(out.is_passive);
        assert_true(out.felt.chatter_m.value < 0.05e-3);
    }
}

/* A bus of up to a millisecond, presses and 2 Hz pokes: neither damping nor back-off has anything
 * to do, whatever the hand and the tissue. */
TEST(good_contacts_are_left_alone)
{
    static const double tissue[3] = {50.0, 300.0, 3000.0};
    SKIP_WHERE_REPEATED();
    for (int n = 0; n < 3 * 3 * 3 * 2 * 2; ++n) {
        const row r = {n % 2 ? SS_SCRIPT_PRESS : SS_SCRIPT_POKE,
                       (ss_sim_body)(n / 2 % 3),
                       (ss_sim_grip)(n / 6 % 3),
                       tissue[n / 18 % 3],
                       1000.0,
                       n / 54,
                       n / 54 == 1,
                       0.0};
        ss_hand_outcome out;
        play(&r, &out);
        assert_true(out.damped_ticks == 0 && out.backoffs == 0);
        assert_true(out.is_passive);
        assert_true(out.felt.chatter_m.value < 0.05e-3);
    }
}

/* ---- the parts ---- */

static ss_observer *touching_observer(double energy, double delay)
{
    ss_observer *observer = calloc(1, sizeof *observer);
    assert_non_null(observer);
    const ss_haptic_config config = default_config();
    ss_observer_restart(observer, &config, false);
    observer->is_in_contact = observer->is_told = true;
    observer->contacts = 1;
    observer->energy = energy;
    observer->delay_p95 = delay;
    observer->limit = 400.0;
    return observer;
}

/* E below what is allowed: alpha v, at most alpha_max v and the debt in one tick, never a pull. */
TEST(damping_takes_the_debt_and_never_pulls)
{
    static const struct {
        const char *what;
        double energy, delay, speed, force, expected;
        bool is_grasping;
    } rows[] = {
        {"no debt", 1e-3, 0, 0.1, 1.0, 1.0, false},
        {"allowed", -0.3e-3, 0, 0.1, 1.0, 1.0, false},
        {"out, near", -5e-3, 1e-3, 0.05, 1.0, 0.5, false},
        {"in, near", -5e-3, 1e-3, -0.05, 1.0, 1.5, false},
        {"out, far", -5e-3, 10e-3, 0.05, 1.0, 0.75, false},
        {"no pull", -5e-3, 1e-3, 0.3, 1.0, 0.0, false},
        {"a grasp may", -5e-3, 1e-3, 0.3, 1.0, -2.0, true},
        {"debt of a tick", -0.4e-3 - 0.1e-4, 0, 0.1, 1.0, 0.9, false},
        {"without force", -5e-3, 0, -0.1, 0.0, 0.0, false},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        ss_observer *observer = touching_observer(rows[k].energy, rows[k].delay);
        ss_passivity passivity;
        ss_passivity_init(&passivity);
        const ss_passivity_tick now = {.period = T,
                                       .velocity = {0, 0, rows[k].speed},
                                       .corrects = true,
                                       .is_grasping = rows[k].is_grasping};
        double force[3] = {0.0, 0.0, 0.0};
        ss_passivity_damp(&passivity, observer, &now, force); /* before the touch */
        force[2] = rows[k].force;
        ss_passivity_damp(&passivity, observer, &now, force);
        if (fabs(force[2] - rows[k].expected) > 1e-9) {
            fail_msg("%s: %.9g, not %g", rows[k].what, force[2], rows[k].expected);
        }
        free(observer);
    }
    /* Not on a guess. */
    ss_observer *observer = touching_observer(-5e-3, 1e-3);
    ss_passivity passivity;
    ss_passivity_init(&passivity);
    const ss_passivity_tick now = {.period = T, .velocity = {0, 0, -0.1}};
    double force[3] = {0.0, 0.0, 1.0};
    observer->is_told = false;
    assert_false(ss_passivity_damp(&passivity, observer, &now, force));
    for (int n = 0; n < 100; ++n) {
        ss_passivity_step(&passivity, observer, T, true);
    }
    assert_true(force[2] == 1.0 && passivity.backoffs == 0);
    free(observer);
}

/* What is on its way counts: 10 forces of 2 N against a hand that leaves at 0.1 m/s are 2 mJ. */
TEST(what_is_on_its_way_counts)
{
    ss_observer *observer = touching_observer(1e-3, 10e-3);
    for (int n = 1; n <= 100; ++n) {
        ss_observer_force(observer, &(ss_past_force){.seq = n, .tick = n, .force = {0, 0, 2.0}});
    }
    ss_passivity_tick now = {.period = T, .velocity = {0, 0, 0.1}};
    assert_near(ss_observer_foresee(observer, &now), 1e-3 - 2e-3, 1e-12);
    /* A client that corrects takes 1000 N/m x 0.1 mm off in each: 2.0, 1.9, ... 1.1 N. */
    now.corrects = true;
    now.stiffness = 1000.0;
    assert_near(ss_observer_foresee(observer, &now), 1e-3 - 15.5e-4, 1e-12);
    /* A contact may begin with what is on its way. */
    observer->is_in_contact = false;
    assert_near(ss_observer_foresee(observer, &now), -15.5e-4, 1e-12);
    /* A device that tells what it had when it sent its pose: 3 are newer. */
    now.corrects = false;
    observer->force_seq = 97;
    assert_near(ss_observer_foresee(observer, &now), -4 * 0.2e-3, 1e-12);
    observer->force_seq = 100;
    assert_near(ss_observer_foresee(observer, &now), -0.2e-3, 1e-12);
    free(observer);
}

/* Behind a long loop, tau = 10 ms, K_max = 400 N/m: 0.3 F |v| tau + F^2/800 <= E + 0.2 mJ. */
TEST(a_late_force_is_no_more_than_was_paid_for)
{
    static const struct {
        const char *what;
        double energy, delay, speed, expected;
        bool is_grasping, corrects;
    } rows[] = {
        {"in, paid", 10e-3, 10e-3, -0.1, 2.0, false, false},
        {"at rest, paid", 4.8e-3, 10e-3, 0.0, 2.0, false, false},
        {"at rest", 0.6e-3, 10e-3, 0.0, 0.8, false, false},
        {"in", 2.96e-3 - 0.2e-3, 10e-3, -0.5, 1.05226, false, false},
        {"out", 2.96e-3 - 0.2e-3, 10e-3, 0.5, 1.05226, false, false},
        {"a debt", -1e-3, 10e-3, 0.1, 0.0, false, false},
        {"near", 0.6e-3, 3e-3, 0.1, 2.0, false, false},
        {"in a grasp", 0.6e-3, 10e-3, 0.1, 2.0, true, false},
        {"corrected", 0.6e-3, 10e-3, 0.1, 2.0, false, true},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        ss_observer *observer = touching_observer(rows[k].energy, rows[k].delay);
        ss_passivity passivity;
        ss_passivity_init(&passivity);
        observer->is_known = true;
        const ss_passivity_tick now = {.period = T,
                                       .velocity = {0, 0, rows[k].speed},
                                       .corrects = rows[k].corrects,
                                       .is_grasping = rows[k].is_grasping};
        double force[3] = {0.0, 0.0, 0.0};
        ss_passivity_damp(&passivity, observer, &now, force); /* before the touch */
        force[2] = 2.0;
        ss_passivity_damp(&passivity, observer, &now, force);
        if (fabs(force[2] - rows[k].expected) > 1e-3) {
            fail_msg("%s: %.9g, not %g", rows[k].what, force[2], rows[k].expected);
        }
        free(observer);
    }
}

/* What a message lets go while the hand comes out stays bounded; a hand at rest is lent the whole
 * force of what others do to the tissue. */
TEST(a_bound_stays_on_the_way_out_and_goes_at_rest)
{
    ss_observer *observer = touching_observer(0.6e-3, 10e-3);
    ss_passivity passivity;
    ss_passivity_init(&passivity);
    observer->is_known = true;
    ss_passivity_tick now = {.period = T, .velocity = {0, 0, 0.05}};
    double force[3] = {0.0, 0.0, 0.0};
    ss_passivity_damp(&passivity, observer, &now, force); /* before the touch */
    force[2] = 2.0;
    ss_passivity_damp(&passivity, observer, &now, force);
    const double bound = force[2];
    assert_true(bound > 0.1 && bound < 0.8);
    observer->energy = 10e-3;
    ss_set3(force, 0.0, 0.0, 2.0);
    ss_passivity_damp(&passivity, observer, &now, force);
    assert_near(force[2], bound, 1e-12);
    now.velocity[2] = -0.05;
    ss_set3(force, 0.0, 0.0, 2.0);
    ss_passivity_damp(&passivity, observer, &now, force);
    assert_near(force[2], 2.0, 0.0);
    observer->energy = -5e-3;
    now.velocity[2] = 0.0;
    double last = 0.0;
    for (int n = 0; n < 2000; ++n) {
        ss_set3(force, 0.0, 0.0, 2.0);
        ss_passivity_damp(&passivity, observer, &now, force);
        assert_true(force[2] >= last);
        last = force[2];
    }
    assert_true(last > 1.8);
    free(observer);
}

/* The measured delay crosses what is long, there and back: no force steps with it, in a hand at
 * rest that has paid for 0.8 of its 2 N, nor in one that goes out with a debt and is damped. */
TEST(a_force_does_not_step_with_the_delay)
{
    for (int is_out = 0; is_out <= 1; ++is_out) {
        ss_observer *observer = touching_observer(is_out ? -1e-3 : 0.6e-3, 3e-3);
        ss_passivity passivity;
        ss_passivity_init(&passivity);
        observer->is_known = true;
        const ss_passivity_tick now = {.period = T, .velocity = {0, 0, is_out ? 0.1 : 0.0}};
        double last = NAN, least = INFINITY;
        for (int n = 0; n < 2000; ++n) {
            observer->delay_p95 = n / 200 % 2 == 0 ? 3.0e-3 : 6.0e-3;
            double force[3] = {0.0, 0.0, 2.0};
            ss_passivity_damp(&passivity, observer, &now, force);
            if (n > 0 && fabs(force[2] - last) > 0.05) {
                fail_msg("tick %d: %.3f after %.3f N", n, force[2], last);
            }
            last = force[2];
            least = fmin(least, last);
        }
        assert_true(least < 1.5); /* it has acted */
        free(observer);
    }
}

/* A hand at rest in tissue, its device away for 0.1 s: when it is back it feels the reaction as
 * soon as the entry is over, behind every loop, also one whose delay goes to and fro; and nearly
 * all of it when it begins to go out, at 0.1 m/s. */
TEST(what_an_entry_pressed_in_is_felt_behind_any_loop)
{
    static const int lag[][2] = {{1, 1}, {6, 6}, {20, 20}, {2, 6}};
    enum { GONE = 800, BACK = 900, OUT = 3000, END = 3025 };
    const double k = 300.0, depth = 8e-3;
    for (size_t m = 0; m < sizeof lag / sizeof *lag; ++m) {
        rig r;
        ss_haptic_config config = default_config();
        config.stiffness = 800.0;
        config.damping = 2.0;
        rig_start(&r, &config);
        r.pose.flags = 0;
        double last = 0.0;
        for (int n = 0; n < END; ++n) {
            const double down = fmin(1.0, n / 200.0), up = fmax(0.0, (n - OUT) * 1e-4);
            const int ticks = lag[m][n / 700 % 2];
            r.has_pose = n < GONE || n >= BACK;
            r.pose.force_seq = r.out.force.seq >= ticks ? r.out.force.seq - ticks + 1 : -1;
            if (n > 0) {
                const double reach = -r.out.force.proxy[2];
                rig_result(&r, k, reach, 1);
            }
            const double f = rig_tick(&r, 1e-3 - (1e-3 + depth) * down + up);
            const double reaction = -k * fmin(0.0, r.out.force.proxy[2]);
            const double allowed = n < OUT ? 0.02 * reaction : 0.1 * reaction + k * 1e-4;
            const bool is_off = fabs(f - reaction) > allowed || fabs(f - last) > 0.1;
            if (n > BACK + 520 && is_off) {
                fail_msg("lag %d / %d, tick %d: %.3f N after %.3f, the tissue's is %.3f", lag[m][0],
                         lag[m][1], n, f, last, reaction);
            }
            last = f;
        }
        assert_int_equal(r.out.stiffness_backoffs, 0);
        rig_end(&r);
    }
}

/* -1 mJ: K_max x 0.8, once in 20 ms and not again for the same debt; floor 50; back by 10 %/s out
 * of contact. */
TEST(back_off_is_paced_and_comes_back)
{
    ss_observer *observer = touching_observer(-1.5e-3, 1e-3);
    ss_passivity passivity;
    ss_passivity_init(&passivity);
    for (int n = 1; n <= 100; ++n) {
        ss_passivity_step(&passivity, observer, T, true);
        assert_near(ss_passivity_limit(&passivity, observer), n < 20 ? 400.0 : 320.0, 1e-9);
    }
    assert_int_equal(passivity.backoffs, 1);
    for (int n = 0; n < 1000; ++n) {
        observer->energy -= 0.1e-3;
        ss_passivity_step(&passivity, observer, T, true);
    }
    assert_near(ss_passivity_limit(&passivity, observer), 50.0, 1e-9);
    assert_true(passivity.backoffs > 10 && passivity.backoffs <= 51);
    const int64_t backoffs = passivity.backoffs;
    ++observer->contacts; /* another contact owes nothing of it */
    observer->energy = -0.5e-3;
    for (int n = 0; n < 1000; ++n) {
        ss_passivity_step(&passivity, observer, T, false);
    }
    assert_int_equal(passivity.backoffs, backoffs);
    assert_near(ss_passivity_limit(&passivity, observer), 50.0 * exp(0.1), 0.01);
    for (int n = 0; n < 100000; ++n) {
        ss_passivity_step(&passivity, observer, T, false);
    }
    assert_near(ss_passivity_limit(&passivity, observer), 400.0, 1e-9);
    observer->limit = 30.0; /* the rule itself is below the floor */
    observer->energy = -1.0;
    for (int n = 0; n < 100; ++n) {
        ss_passivity_step(&passivity, observer, T, true);
    }
    assert_near(ss_passivity_limit(&passivity, observer), 30.0, 1e-9);
    free(observer);
}

/* A device that tells forces which drive it is backed off from; the next one feels the tissue. */
TEST(what_a_device_told_ends_with_it)
{
    rig r;
    const ss_haptic_config config = default_config();
    rig_start(&r, &config);
    for (int i = 0; i < 300; ++i) {
        r.pose.applied_force[0] = r.pose.applied_force[1] = 0.0;
        r.pose.applied_force[2] = -8.0;
        const double z = -5e-5 * i;
        rig_result(&r, 300.0, -z, 1);
        rig_tick(&r, z);
    }
    const int64_t backoffs = r.out.stiffness_backoffs;
    const double left = r.out.stiffness_limit;
    assert_true(backoffs > 2);
    ++r.pose.sender;
    ++r.epoch;
    r.pose.applied_force[2] = NAN;
    rig_result(&r, 300.0, -1e-3, 1);
    rig_tick(&r, 1e-3);
    assert_int_equal(r.out.stiffness_backoffs, backoffs);
    assert_true(r.out.stiffness_limit > 1.5 * left);
    rig_end(&r);
}

/* A hand that has been given too much is damped to no force at all, as fast as the slew allows: the
 * damper acts on its point, so the torque stays what the contact exerts. */
TEST(damping_leaves_the_torque_of_the_contact)
{
    const double k = 500.0, depth = 4e-3, arm = 0.03;
    rig r;
    ss_haptic_config config = default_config();
    config.max_slew = 100.0;
    config.tool_gyration = 0.01;
    rig_start(&r, &config);
    rig_press(&r, k, depth);
    double least = INFINITY, before = 0.0;
    for (int n = 0; n < 45; ++n) {
        rig_result(&r, k, depth, 1);
        r.result.set.contact[0].point[0] = arm;
        r.result.set.contact[0].point[2] = -depth;
        if (n >= 20) { /* it says that it was pushed while it went out, and that it goes on so */
            r.pose.position[0] = 1e-3 * (n - 20);
            r.pose.applied_force[0] = 2.0;
            r.pose.applied_force[1] = r.pose.applied_force[2] = 0.0;
            r.pose.velocity[2] = 0.4;
        }
        const double f = rig_tick(&r, -depth);
        least = fmin(least, f);
        before = n == 10 ? f : before;
        if (n >= 10) { /* less by what a softer coupling takes from the contact */
            assert_near(r.out.force.torque[1], -arm * before, 0.05 * arm * before);
        }
    }
    assert_true(least < 0.1 * k * depth);
    rig_end(&r);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
