/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Energy, delay and stiffness limit as the observer has them, against closed forms. */
#include "common/test.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "haptic_fixture.h"

static ss_observer *make_observer(ss_haptic_config *out_config)
{
    *out_config = default_config();
    out_config->is_lockstep = false;
    ss_observer *observer = calloc(1, sizeof *observer);
    assert_non_null(observer);
    return observer;
}

/* A lossless spring answered n ticks late hands out K a^2 N sin(w T/2) sin(w (tau + T/2)) over N
 * ticks of a full period (the sum in closed form). */
TEST(observer_sees_the_gift_of_delay)
{
    ss_haptic_config config;
    ss_observer *observer = make_observer(&config);
    const double k = 500.0, a = 4e-3, w = 4.0 * SS_PI;
    enum { PERIOD = 500 };
    for (int has_seq = 0; has_seq < 2; ++has_seq) {
        memset(observer, 0, sizeof *observer);
        ss_observer_restart(observer, &config, false);
        const int delay = 5;
        double worst_of_two = 0.0;
        for (int n = 0; n < 2 * PERIOD + 5; ++n) {
            const double depth = a * (1.0 - cos(w * n * T));
            const softsim_pose pose = {.seq = n + 1,
                                       .utime_us = 1000 * n,
                                       .force_seq =
                                           has_seq ? (n >= delay ? n - delay + 1 : -1) : -1,
                                       .position = {0, 0, -depth},
                                       .applied_force = {NAN, NAN, NAN}};
            ss_observer_pose(observer, &config, &pose, n + 1);
            const ss_past_force force = {.seq = n + 1,
                                         .tick = n + 1,
                                         .pose_tick = n + 1,
                                         .pose_utime_us = 1000 * n,
                                         .force = {0, 0, k * depth}};
            ss_observer_force(observer, &force);
            ss_observer_tick(observer, &config, false, true, n + 1);
            worst_of_two = fmin(worst_of_two, observer->worst);
        }
        const double tau = delay * T;
        const double gift = k * a * a * PERIOD * sin(0.5 * w * T) * sin(w * (tau + 0.5 * T));
        assert_near(observer->worst, -gift, 2e-3 * gift);
        assert_near(observer->from_device - observer->to_device, -2.0 * gift, 4e-3 * gift);
        if (has_seq) {
            assert_near(observer->delay_p95, tau, 1e-9);
            assert_near(observer->delay_p50, tau, 1e-9);
        } else {
            assert_false(observer->is_known);
        }
    }
    free(observer);
}

/* A long tool that is twisted to and fro about its axis against a lossless spring answered n ticks
 * late: the same sum, of torque and angle. A device that tells its own force has told no torque. */
TEST(observer_sees_the_work_of_a_torque)
{
    ss_haptic_config config;
    ss_observer *observer = make_observer(&config);
    const double k = 0.05, a = 0.3, w = 4.0 * SS_PI; /* N m/rad, rad, rad/s */
    enum { PERIOD = 500, DELAY = 5 };
    for (int is_own = 0; is_own < 2; ++is_own) {
        memset(observer, 0, sizeof *observer);
        ss_observer_restart(observer, &config, false);
        for (int n = 0; n < PERIOD + DELAY; ++n) {
            const double angle = a * (1.0 - cos(w * n * T));
            softsim_pose pose = {.seq = n + 1,
                                 .utime_us = 1000 * n,
                                 .force_seq = n >= DELAY ? n - DELAY + 1 : -1,
                                 .orientation = {cos(0.5 * angle), 0, 0, sin(0.5 * angle)},
                                 .applied_force = {NAN, NAN, NAN}};
            if (is_own) {
                ss_set3(pose.applied_force, 0.0, 0.0, 1.0);
            }
            ss_observer_pose(observer, &config, &pose, n + 1);
            const ss_past_force force = {.seq = n + 1,
                                         .tick = n + 1,
                                         .pose_tick = n + 1,
                                         .pose_utime_us = 1000 * n,
                                         .force = {0, 0, 1.0}, /* on a hand that stays */
                                         .torque = {0, 0, -k * angle}};
            ss_observer_force(observer, &force);
        }
        const double tau = DELAY * T;
        const double gift =
            is_own ? 0.0 : k * a * a * PERIOD * sin(0.5 * w * T) * sin(w * (tau + 0.5 * T));
        const double balance = observer->from_device - observer->to_device;
        print_message("gift %g of %g J\n", -balance, gift);
        assert_near(balance, -gift, 0.01 * gift);
    }
    free(observer);
}

/* The same through the loop: a long tool lies with its end, 30 mm off, on tissue, and the hand
 * turns it into it about its middle, or out of it. */
TEST(a_turned_tool_takes_and_gives_work)
{
    const double k = 500.0, depth = 2e-3, arm = 0.03, step = 1e-4; /* rad a tick */
    for (int way = -1; way <= 1; way += 2) {
        rig r;
        ss_haptic_config config = default_config();
        config.tool_gyration = 0.01;
        rig_start(&r, &config);
        rig_press(&r, k, depth);
        double before = 0.0, force = 0.0;
        for (int n = 0; n < 40; ++n) {
            const double angle = way * step * (n < 10 ? 0 : n < 30 ? n - 9 : 20);
            rig_result(&r, k, depth, 1);
            r.result.set.contact[0].point[0] = arm;
            memcpy(r.result.orientation, r.pose.orientation, sizeof r.result.orientation);
            r.pose.force_seq = r.out.force.seq;
            r.pose.orientation[0] = cos(0.5 * angle);
            r.pose.orientation[2] = sin(0.5 * angle);
            force = rig_tick(&r, -depth);
            before = n == 9 ? r.out.contact_j : before;
        }
        const double work = way * arm * force * 20 * step;
        assert_near(r.out.contact_j - before, work, 0.02 * arm * force * 20 * step);
        rig_end(&r);
    }
}

TEST(applied_force_of_the_device_counts_first)
{
    const ss_haptic_config config = default_config();
    ss_observer *observer = calloc(1, sizeof *observer);
    assert_non_null(observer);
    ss_observer_restart(observer, &config, false);
    for (int n = 0; n < 11; ++n) {
        const softsim_pose pose = {.seq = n + 1,
                                   .force_seq = -1,
                                   .position = {0, 0, 1e-3 * n},
                                   .applied_force = {0, 0, 2}};
        ss_observer_pose(observer, &config, &pose, n + 1);
    }
    assert_near(observer->worst, -0.02, 1e-12);
    assert_near(observer->to_device, 0.02, 1e-12);
    free(observer);
}

TEST(limit_follows_the_rule_and_its_rate)
{
    ss_haptic_config config = default_config();
    config.stiffness = 800.0;
    config.damping = 2.0;
    assert_near(ss_observer_rule(&config, 3e-3, false), 571.4285714285714, 1e-9);
    assert_near(ss_observer_rule(&config, 5e-3, false), 363.6363636363636, 1e-9);
    assert_near(ss_observer_rule(&config, 11e-3, false), 173.9130434782609, 1e-9);
    assert_near(ss_observer_rule(&config, 1e-3, false), 800.0, 0.0);
    assert_near(ss_observer_rule(&config, 10e-3, true), 800.0, 1e-9);
    ss_observer *observer = calloc(1, sizeof *observer);
    assert_non_null(observer);
    ss_observer_restart(observer, &config, false);
    assert_near(observer->limit, 363.6363636363636, 1e-9);
    /* Up only out of contact, both ways at 20 % a second. */
    for (int n = 1; n <= 1000; ++n) {
        ss_observer_tick(observer, &config, true, true, n);
    }
    assert_near(observer->limit, 363.6363636363636, 1e-9);
    for (int n = 1; n <= 1000; ++n) {
        ss_observer_tick(observer, &config, true, false, n);
    }
    assert_near(observer->limit, 363.6363636363636 * exp(0.2), 0.02);
    for (int n = 1; n <= 500; ++n) {
        ss_observer_tick(observer, &config, false, true, n);
    }
    assert_near(observer->limit, 363.6363636363636 * exp(0.1), 0.02);
    free(observer);
}

/* The delay forgets what is older than a second, and hostile numbers do not enter. */
TEST(delay_is_of_the_last_second)
{
    ss_haptic_config config;
    ss_observer *observer = make_observer(&config);
    ss_observer_restart(observer, &config, false);
    for (int n = 1; n <= 6000; ++n) {
        const int delay = n < 3000 ? 2 : 9;
        softsim_pose pose = {.seq = n,
                             .utime_us = 1000 * n,
                             .force_seq = n > delay ? n - delay : -1,
                             .applied_force = {NAN, NAN, NAN}};
        if (n % 10 == 0) {
            pose.force_seq = n % 20 == 0 ? INT32_MAX : INT32_MIN;
        }
        ss_observer_pose(observer, &config, &pose, n);
        ss_observer_force(
            observer,
            &(ss_past_force){.seq = n, .tick = n, .pose_tick = n, .pose_utime_us = 1000 * n});
        ss_observer_tick(observer, &config, false, false, n);
        if (n == 2990) {
            assert_near(observer->delay_p95, 2e-3, 1e-9);
        }
        if (n == 3200) {
            assert_near(observer->delay_p95, 9e-3, 1e-9);
            assert_near(observer->delay_p50, 2e-3, 1e-9);
        }
        if (n == 4100) {
            assert_near(observer->delay_p50, 9e-3, 1e-9);
        }
    }
    free(observer);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
