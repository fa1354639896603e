/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The state of a probe's haptic tick, shared by haptic.c, which steps it, and output.c, which tells
 * it. */
#include "haptic/internal.h"

struct ss_haptic {
    ss_haptic_config config;
    /* state: device */
    bool has_pose;
    softsim_pose pose;
    int64_t pose_tick;
    uint32_t epoch;
    /* It came back before its ramp was over: what it left is ramped down first. */
    bool is_returning;
    softsim_pose left_pose;
    bool has_stayed;          /* it came back to where it was, and is not placed yet */
    bool is_placed_as_before; /* and was placed there since */
    ss_motion motion;
    bool is_pressed;
    bool is_button_ignored; /* the button has been down since before the proxy was placed: it is
                             * pressed no more, until it comes up */
    int64_t press_tick;
    /* state: proxy and tissue */
    double p[3], pdot[3];
    ss_yield yield;
    ss_slip slip;
    ss_admission admission;
    ss_local_contact local;
    bool is_fault;
    int64_t result_tick;
    double model_force[3], surface_point[3], surface_normal[3], surface_depth, surface_proxy[3];
    double inside_depth; /* m, 0: the tissue holds the tool off, or is not near */
    /* state: output */
    int32_t bad_streak;
    int64_t bad_inputs;
    uint32_t grasp_edges, teleports, entries;
    uint32_t holders;              /* devices so far */
    uint32_t restart_count;        /* resets and resumes so far, */
    uint32_t placed_restart_count; /* and when the proxy was placed */
    double last_force[3];
    double shift[3];  /* m, from the hand to the pose used: what is not let in yet */
    double ramp_from; /* N, the force before a ramp */
    /* Of these, what they were without the damping of passivity.c: the contacts', whose torque is
     * felt. The damper acts on the hand's point and has none. */
    double last_undamped[3], undamped_ramp_from;
    uint64_t digest;
    ss_haptic_output output;
    ss_observer observer;
    ss_passivity passivity;
};

/* The pose that counts for the tissue: while a device that returned is ramped down, the one it
 * left. */
static inline const softsim_pose *ss_haptic_held_pose(const ss_haptic *haptic)
{
    return haptic->is_returning && haptic->admission.phase == SS_PHASE_RAMPING ? &haptic->left_pose
                                                                               : &haptic->pose;
}

/* dF/dx along the normal within a result: coupling and law in series. */
double ss_haptic_felt_stiffness(const ss_haptic *haptic, const double normal[3]);
/* What of the force the admission lets through; nothing of one that begins within a ramp. */
double ss_haptic_gain(const ss_haptic *haptic);
/* After 24 days at 1 kHz the numbers begin again. */
int32_t ss_haptic_next_seq(int32_t seq);
/* The message: `sent` is the force on the hand, `undamped` what it would be without what
 * passivity.c does and without ramp and slew. */
void ss_haptic_write_force(ss_haptic *haptic, const ss_haptic_input *input, const double sent[3],
                           const double undamped[3], int32_t flags);
/* Where the simulation's tool goes; `v` is the hand's velocity. */
void ss_haptic_write_target(ss_haptic *haptic, const ss_haptic_input *input, const double v[3]);
void ss_haptic_write_sums(ss_haptic *haptic);
