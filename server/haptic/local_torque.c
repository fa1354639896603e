/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The torque of a tool with extent, about its origin, and its turn since the last result. It moves
 * no proxy: the balance of local_contact.c is that of the force, which knows the turn.
 */
#include "haptic/internal.h"
#include "rt/vec.h"

#define TURN_REACH 0.5 /* rad, |theta| */

void ss_local_contact_turn(ss_local_contact *local, const double orientation[4])
{
    ss_set3(local->turn, 0.0, 0.0, 0.0);
    if (local->has_torque) {
        ss_turn_between(local->orientation, orientation, local->turn);
        (void)ss_clamp_norm3(local->turn, TURN_REACH);
    }
}

/* The model's own torque as of the result, and what the law has changed since: without the offsets,
 * which keep the proxy still and would let the torque come late, but no more than they leave of the
 * force. */
void ss_local_contact_torque(const ss_local_contact *local, double out[3])
{
    const ss_local_contact_grasp *grasp = &local->grasp;
    double own = 0.0, felt = ss_norm3(local->residual), laws[3] = {0.0, 0.0, 0.0}, arm[3],
           torque[3];
    ss_madd3(out, local->residual_torque, local->other.share, local->other.model_torque);
    if (grasp->is_held) {
        double since[3];
        ss_sub3(since, grasp->last_force, grasp->force);
        ss_sub3(arm, local->count > 0 ? local->contact[0].point : local->proxy, local->proxy);
        ss_cross3(torque, arm, since);
        ss_add3(out, out, grasp->torque);
        ss_add3(out, out, torque);
        return;
    }
    if (local->friction.is_used) {
        ss_friction_torque(local, out);
    }
    for (int32_t i = 0; i < local->count; ++i) {
        const ss_local_contact_point *c = &local->contact[i];
        const double force = fmax(0.0, c->last_force - c->offset);
        ss_sub3(arm, c->point, local->proxy);
        ss_cross3(torque, arm, c->direction);
        ss_madd3(laws, laws, force, torque);
        own += force;
        felt += c->last_force;
    }
    /* Sums of sizes: contacts that press against each other are felt little and may say much. */
    ss_madd3(out, out, felt < own ? felt / own : 1.0, laws);
}

void ss_local_contact_felt_torque(const ss_local_contact *local, double out[3])
{
    const ss_local_contact_released *released = &local->released;
    ss_local_contact_torque(local, out);
    ss_scale3(out, out, 1.0 - released->share);
    ss_madd3(out, out, released->share, released->torque);
}

void ss_local_contact_keep_torque(ss_local_contact *local, const double before[3])
{
    ss_set3(local->residual_torque, 0.0, 0.0, 0.0);
    if (local->has_torque) {
        double now[3];
        ss_local_contact_torque(local, now);
        ss_sub3(local->residual_torque, before, now);
    }
}
