/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A haptic tick after the other against hand-made tissue: shared by the tests of haptic/. cmocka
 * comes first. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "haptic/haptic.h"
#include "haptic/internal.h"
#include "rt/random.h"
#include "rt/vec.h"

#define T 1e-3

static inline void check_near(double value, double expected, double tolerance, int line)
{
    if (!(fabs(value - expected) <= tolerance)) {
        print_error("line %d: %.17g is not %.17g +- %g\n", line, value, expected, tolerance);
        fail();
    }
}
#define assert_near(value, expected, tolerance) check_near(value, expected, tolerance, __LINE__)

/* ---- a rig: one tick after the other against a hand-made tissue ---- */

typedef struct rig {
    ss_haptic *haptic;
    int64_t tick;
    softsim_pose pose;
    ss_simulation_result result;
    bool has_result, is_new;
    bool is_paused, is_reset, is_stopping, has_pose;
    uint32_t epoch, restart_count;
    int ahead; /* resets that the result has seen and the haptic loop has not */
    ss_haptic_output out;
} rig;

static inline ss_haptic_config default_config(void)
{
    return (ss_haptic_config){.period = T,
                              .between_steps = SS_BETWEEN_LOCAL,
                              .max_force = 8.0,
                              .max_slew = 2000.0,
                              .stiffness = 1e5,
                              .damping = 0.0,
                              .is_lockstep = true};
}

static inline void rig_start(rig *r, const ss_haptic_config *config)
{
    *r = (rig){.haptic = ss_haptic_create(config), .epoch = 1, .has_pose = true};
    assert_non_null(r->haptic);
    r->pose = (softsim_pose){.sender = 7,
                             .force_seq = -1,
                             /* lifts the limit, so that the coupling is stiff */
                             .flags = SOFTSIM_POSE_CORRECTS,
                             .orientation = {1, 0, 0, 0},
                             .velocity = {0, 0, 0},
                             .applied_force = {NAN, NAN, NAN}};
}

static inline void rig_begin(rig *r)
{
    const ss_haptic_config config = default_config();
    rig_start(r, &config);
}

static inline void rig_end(rig *r)
{
    ss_haptic_destroy(&r->haptic);
    assert_null(r->haptic);
}

static inline double rig_tick(rig *r, double z)
{
    ++r->tick;
    r->pose.position[2] = z;
    if (r->has_pose) {
        ++r->pose.seq;
        r->pose.utime_us = 1000 * r->tick;
    }
    r->restart_count += r->is_reset;
    r->result.restart_count = r->restart_count + (uint32_t)r->ahead;
    const ss_haptic_input input = {.tick = r->tick,
                                   .pose = &r->pose,
                                   .pose_count = r->has_pose ? 1 : 0,
                                   .sender_epoch = r->epoch,
                                   .result = r->has_result ? &r->result : NULL,
                                   .is_result_new = r->is_new,
                                   .is_paused = r->is_paused,
                                   .restart_count = r->restart_count,
                                   .is_stopping = r->is_stopping};
    ss_haptic_tick(r->haptic, &input, &r->out);
    r->is_new = false;
    r->is_reset = false;
    return r->out.force.force[2];
}

/* A result of flat tissue with its surface at z = 0, stepped to depth `depth`, of age `age` ticks
 * at the next tick. */
static inline void rig_result(rig *r, double k, double depth, int64_t age)
{
    r->result = (ss_simulation_result){.tick = r->tick + 1 - age,
                                       .step = r->result.step + 1,
                                       .period = T,
                                       .orientation = {1, 0, 0, 0},
                                       .proxy = {0, 0, -depth}};
    ss_contact_set *set = &r->result.set;
    set->count = 1;
    set->normal[2] = 1.0;
    set->contact[0].normal[2] = 1.0;
    set->contact[0].stiffness = k;
    set->contact[0].force = fmax(0.0, k * depth);
    set->contact[0].gap = fmax(0.0, -depth);
    set->force[2] = set->contact[0].force;
    set->depth = depth > 0.0 ? 0.0 : depth;
    r->has_result = true;
    r->is_new = true;
}

/* In contact at `depth` with the local contact model settled: from outside, one result a tick. */
static inline double rig_press(rig *r, double k, double depth)
{
    double f = 0.0;
    for (int i = 0; i <= 400; ++i) {
        const double z = 1e-3 - (1e-3 + depth) * fmin(1.0, i / 200.0);
        if (r->tick > 0) {
            rig_result(r, k, -z, 1);
        }
        f = rig_tick(r, z);
    }
    return f;
}

static inline double rig_begin_pressed(rig *r, double k, double depth)
{
    rig_begin(r);
    return rig_press(r, k, depth);
}

/* ---- random numbers ---- */

static uint64_t random_state;

static inline double uniform(double low, double high)
{
    return low + (high - low) * ss_random_unit(&random_state);
}
