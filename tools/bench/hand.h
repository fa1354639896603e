/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a hand gets from the forces that it is given: energy, the largest force, the greatest depth.
 *
 * Judged from the poses that were sent and the forces that answered them alone, never from the
 * program's own observer. Energy handed to the hand in one contact: the largest that
 *
 *   E = sum F . (x_j+1 - x_j) + T . theta_j
 *
 * reaches since its first tick with a force, theta_j the turn from pose j to pose j + 1 the shorter
 * way round. F and T answer pose j (a device that acts at once) or pose j - 1 (one that acts on the
 * newest answer when it samples): the worse of the two counts. Tissue that was at rest cannot give
 * more than it got, so that above rounding E > 0 is energy from nowhere; what one contact left
 * behind another may get.
 * Thread: any.
 */
#include <stdbool.h>

#include "softsim/types.h"

enum { SS_HAND_DELAYS = 2 };

typedef struct ss_hand {
    bool has_pose;
    double position[3], orientation[4];
    double force[SS_HAND_DELAYS][3], torque[SS_HAND_DELAYS][3]; /* the last answers, newest first */
    double energy[SS_HAND_DELAYS];                              /* J, of the contact under way */
    double handed_out_j;                                        /* the largest in one contact */
    double peak_force_n, deepest_m;
} ss_hand;

/* The pose that was accepted, and its answer. Start from a zeroed ss_hand; without has_pose a
 * contact begins anew. */
void ss_hand_feel(ss_hand *hand, const softsim_pose *pose, const softsim_force *answer);
