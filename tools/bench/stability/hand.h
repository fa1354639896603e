/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a hand got from the forces that it was given, judged from the whole trajectory once it is
 * over: poses that were sent, forces that answered them, and the energy that the model says it
 * stored. None of it is the program's own observer or watch, nor made as they are.
 *
 * A contact goes from its first touch to its release, 20 ms without a force: what chatters is one
 * contact. The energy that the hand is given in it, E = sum F . dx + T . dtheta, is added up for
 * three devices: one that acts on an answer at once and holds it until the next (F of the
 * interval's beginning), one that acts an answer later, and one that goes evenly from answer to
 * answer (the trapezoid, which has nothing of the sampling in it). The worst counts.
 *
 *   handed_out_j  largest E since the first touch, of the two that hold: tissue at rest gives no
 *                 more than it got
 *   made_j        largest E of any part of a contact less what was stored where that part begins:
 *                 what the tissue swallowed before excuses nothing. No part begins before or while
 *                 a tool that was found inside is let in (flag 8): that stores what no hand gave
 *   driven_j      handed_out_j less what was stored then
 *
 * Stored is what the model says, within the lag of its answers, and what the coupling may hold,
 * F |proxy - pose|: a spring half of it, one at the force limit all. A model that keeps no account
 * of energy (chains) has only E.
 * Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

/* A pose that was accepted, and its answer. */
typedef struct ss_hand_sample {
    double position[3], orientation[4];
    double force[3], torque[3];
    double depth_m, slip_m; /* slip: from pose to proxy */
    double stored_j;        /* kinetic and elastic */
    bool is_let_in;         /* flag 8 */
    bool is_apart;          /* one before it was refused: told that the force does not follow */
} ss_hand_sample;

typedef struct ss_hand_plan {
    double period_s;
    int32_t lag; /* samples that the stored energy may be late or early */
    bool has_stored;
} ss_hand_plan;

typedef struct ss_hand_account {
    int32_t contacts;
    double handed_out_j, made_j, driven_j; /* the largest of a contact */
    double put_in_j;                       /* the same, by the hand */
    double peak_force_n, deepest_m;
} ss_hand_account;

void ss_hand_read(const softsim_pose *pose, const softsim_force *answer, ss_hand_sample *out);
void ss_hand_judge(const ss_hand_plan *plan, const ss_hand_sample *sample, int32_t count,
                   ss_hand_account *out);
