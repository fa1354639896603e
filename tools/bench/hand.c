/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "hand.h"

#include <math.h>
#include <string.h>

#include "rt/vec.h"

void ss_hand_feel(ss_hand *hand, const softsim_pose *pose, const softsim_force *answer)
{
    double way[3] = {0.0}, turn[3] = {0.0};
    if (hand->has_pose) {
        ss_sub3(way, pose->position, hand->position);
        ss_turn_between(hand->orientation, pose->orientation, turn);
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
