/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Worlds in real time, a tick at a time, and a press on the bundled kidney. cmocka comes first. */
#include <math.h>
#include <string.h>

#include "common/kidney.h"
#include "common/pose_fixture.h"
#include "world/world.h"
#include "world_fixture.h"

/* Of a 5 mm sphere over (5, 3) mm: where it is 5 mm deep, and above the surface. */
static const double pressed_z = 0.0175, free_z = 0.035;
static const double deep_z = 0.005;
static const double limit_n = 8.0, body_m = 0.11, tool_m = 0.006; /* kidney.yaml, kidney.obj */

static inline ss_world *make_scene(const char *scene, const char *const *set, int32_t set_count)
{
    softsim_config config = softsim_default_config();
    config.has_budget = true; /* as in real time */
    config.set = set;
    config.set_count = set_count;
    return ss_world_of(make_world_with(scene, config));
}

static inline ss_world *make_kidney(const char *const *set, int32_t set_count)
{
    const char *all[KIDNEY_SETS];
    const int32_t count = kidney_sets(set, set_count, all);
    return make_scene(KIDNEY, all, count);
}

static inline void destroy(ss_world *world)
{
    softsim_world *outer = (softsim_world *)world;
    softsim_destroy(&outer);
}

static inline softsim_force tick_of(ss_world *world, int64_t sender, int32_t seq, double x,
                                    double y, double z)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    softsim_pose pose = {.sender = sender, .seq = seq, .position = {x, y, z}, PLAIN_POSE};
    softsim_tick((softsim_world *)world, &pose, &channel, 1, force);
    ss_world_settle(world);
    return force[0];
}

static inline softsim_force tick(ss_world *world, int32_t seq, double x, double y, double z)
{
    return tick_of(world, 1, seq, x, y, z);
}

/* Down to the press in 0.1 s. */
static inline double height(int32_t k)
{
    return fmax(pressed_z, free_z - k * (free_z - pressed_z) / 100.0);
}
