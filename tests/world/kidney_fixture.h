/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Headless worlds of the kidney, and poses that press it from above. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/kidney.h"
#include "world_fixture.h"

static softsim_world *make_world(int32_t threads, const char *const *set, int32_t set_count)
{
    softsim_config config = softsim_default_config();
    const char *all[KIDNEY_SETS];
    config.threads = threads;
    config.set_count = kidney_sets(set, set_count, all);
    config.set = all;
    return make_world_with(KIDNEY, config);
}

static double smooth(double u)
{
    u = fmin(1.0, fmax(0.0, u));
    return u * u * u * (10.0 - u * (15.0 - 6.0 * u));
}

static softsim_pose pose_at(int32_t probe, int32_t seq, double x, double y, double z)
{
    softsim_pose pose = {.sender = 7, .seq = seq, .probe = probe, .force_seq = -1};
    pose.position[0] = x;
    pose.position[1] = y;
    pose.position[2] = z;
    pose.orientation[0] = 1.0;
    for (int i = 0; i < 3; ++i) {
        pose.velocity[i] = pose.applied_force[i] = (double)NAN;
    }
    return pose;
}

static double magnitude(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Height of a 5 mm sphere that just touches the upper face over (0, 6 mm). */
#define TOUCH 0.0273

static void press_and_release(softsim_world *world, int32_t ticks, double depth,
                              softsim_force *out_last, double *out_peak)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    *out_peak = 0.0;
    for (int32_t k = 0; k < ticks; ++k) {
        const double t = (double)k / ticks;
        const double down = smooth(4.0 * t) - smooth(4.0 * (t - 0.5));
        const softsim_pose pose =
            pose_at(0, k + 1, 0.0, 0.006, TOUCH + 0.003 - (depth + 0.003) * down);
        const int32_t channel = 0;
        softsim_tick(world, &pose, &channel, 1, force);
        *out_peak = fmax(*out_peak, magnitude(force[0].force));
        *out_last = force[0];
    }
}
