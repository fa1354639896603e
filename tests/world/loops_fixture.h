/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Commands to a world, and its two loops as with a clock between them. cmocka comes first. */
#include <stdio.h>

#include "world/world.h"

/* Who hears of a command first. */
typedef enum heard { LOCKSTEP, SIMULATION_FIRST, HAPTIC_FIRST, ORDERS } heard;
enum { LATE_TICKS = 3 }; /* of the results of a step that was under way then */

static inline void command(ss_world *world, const char *name)
{
    ss_command_record record;
    char text[256];
    assert_int_equal(ss_world_command(world, name, "", &record, text, sizeof text), 0);
}

/* `argument` as the command takes it: KEY=VALUE. */
static inline void set_live(ss_world *world, const char *argument)
{
    ss_command_record record;
    char text[256];
    if (ss_world_command(world, "set", argument, &record, text, sizeof text) != 0) {
        fail_msg("%s", text);
    }
}

static inline void set_limit(ss_world *world, double limit_n)
{
    char argument[64];
    (void)snprintf(argument, sizeof argument, "haptic.max_force_n=%.17g", limit_n);
    set_live(world, argument);
}

static inline void begin_step(ss_world *world)
{
    ss_world_step_begin(world);
    ss_world_step_compute(world);
    world->is_step_pending = true;
}

/* One tick of the two loops as with a clock between them, with a pose, a command or NULL.
 * Simulation first: it comes between the haptic tick and the step that follows at once. Haptic
 * first: while a step is under way, which takes LATE_TICKS more. */
static inline softsim_force turn(ss_world *world, heard way, const softsim_pose *pose,
                                 const char *name, int *inout_late)
{
    ss_force_record out = {.force = {.seq = -1}};
    if (pose != NULL) {
        const ss_pose_record in = {.pose = *pose, .sender_epoch = 1};
        ss_ring_push(world->probe[0].poses, &in);
    }
    const int64_t tick = ++world->tick;
    if (name && way == HAPTIC_FIRST) {
        if (!world->is_step_pending) {
            begin_step(world);
            *inout_late = LATE_TICKS;
        }
        command(world, name);
    }
    ss_world_haptic_tick(world, tick, 0, 0);
    while (ss_ring_pop(world->forces, &out)) {
    }
    if (name && way == SIMULATION_FIRST) {
        command(world, name);
    }
    if (*inout_late > 0) {
        --*inout_late;
        return out.force;
    }
    if (!world->is_step_pending && tick % world->step_ticks == 0) {
        begin_step(world);
    }
    if (world->is_step_pending) {
        ss_world_step_post(world);
        world->is_step_pending = false;
    }
    return out.force;
}
