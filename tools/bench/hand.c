/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "hand.h"

#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* The rotation vector from `a` to `b`, the shorter way round, in the world: of b a*. */
static void turn_between(const double a[4], const double b[4], double out[3])
{
    const double w = b[0] * a[0] + b[1] * a[1] + b[2] * a[2] + b[3] * a[3];
    double v[3], cross[3];
    ss_cross3(cross, b + 1, a + 1);
    for (int k = 0; k < 3; ++k) {
        v[k] = a[0] * b[k + 1] - b[0] * a[k + 1] - cross[k];
    }
    const double sine = ss_norm3(v);
    const double angle = 2.0 * atan2(sine, fabs(w));
    ss_scale3(out, v, sine > 0.0 ? (w < 0.0 ? -angle : angle) / sine : 0.0);
}

void ss_hand_feel(ss_hand *hand, const softsim_pose *pose, const softsim_force *answer)
{
    double way[3] = {0.0}, turn[3] = {0.0};
    if (hand->has_pose) {
        ss_sub3(way, pose->position, hand->position);
        turn_between(hand->orientation, pose->orientation, turn);
    } else {
        memset(hand->force, 0, sizeof hand->force);
        memset(hand->torque, 0, sizeof hand->torque);
    }
    for (int d = 0; d < SS_HAND_DELAYS; ++d) {
        const bool is_touched = ss_norm3(hand->force[d]) + ss_norm3(hand->torque[d]) > 0.0;
        const double given = ss_dot3(hand->force[d], way) + ss_dot3(hand->torque[d], turn);
        hand->energy[d] = is_touched ? hand->energy[d] + given : 0.0;
        hand->handed_out_j = fmax(hand->handed_out_j, hand->energy[d]);
    }
    memmove(hand->force[1], hand->force[0], sizeof hand->force[0]);
    memmove(hand->torque[1], hand->torque[0], sizeof hand->torque[0]);
    ss_copy3(hand->force[0], answer->force);
    ss_copy3(hand->torque[0], answer->torque);
    ss_copy3(hand->position, pose->position);
    memcpy(hand->orientation, pose->orientation, sizeof hand->orientation);
    hand->has_pose = true;
    hand->peak_force_n = fmax(hand->peak_force_n, ss_norm3(answer->force));
    hand->deepest_m = fmax(hand->deepest_m, answer->depth);
}
