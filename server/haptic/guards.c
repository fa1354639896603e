/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What a tick refuses: poses and results that are not finite, and results that are not plausible.
 * The receive checks (net/gate.c) refuse such poses and the models such states (a model at fault
 * keeps its last good one) before they come here; this is the last check before a force is sent.
 */
#include "haptic/internal.h"
#include "rt/vec.h"

bool ss_haptic_is_pose_finite(const softsim_pose *pose)
{
    return ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4);
}

static bool is_result_finite(const ss_simulation_result *result)
{
    const ss_contact_set *set = &result->set;
    bool is_good = isfinite(result->period) && ss_is_finite(result->proxy, 3) &&
                   ss_is_finite(result->velocity, 3) && ss_is_finite(set->force, 3) &&
                   ss_is_finite(set->torque, 3) && ss_is_finite(set->friction, 3) &&
                   ss_is_finite(set->friction_torque, 3) && ss_is_finite(set->other_force, 3) &&
                   ss_is_finite(set->other_torque, 3) && isfinite(set->depth) &&
                   isfinite(set->step_stiffness) && isfinite(set->inside_depth) &&
                   ss_is_finite(set->point, 3) && ss_is_finite(result->outward, 3) &&
                   ss_is_finite(set->normal, 3);
    for (int32_t i = 0; is_good && i < set->count && i < SS_MAX_CONTACTS; ++i) {
        const ss_contact *c = &set->contact[i];
        const double scalar[7] = {c->force, c->stiffness, c->tangential, c->viscosity,
                                  c->swift, c->gap,       c->coefficient};
        is_good = ss_is_finite(c->point, 3) && ss_is_finite(c->normal, 3) &&
                  ss_is_finite(scalar, 7) && ss_is_finite(&c->curvature[0][0], 9);
    }
    return is_good;
}

bool ss_haptic_is_result_sound(const ss_simulation_result *result, int64_t tick)
{
    if (!is_result_finite(result) || result->set.count < 0 || result->set.count > SS_MAX_CONTACTS ||
        result->tick > tick || result->period <= 0.0) {
        return false;
    }
    for (int32_t i = 0; i < result->set.count; ++i) {
        if (fabs(ss_norm3(result->set.contact[i].normal) - 1.0) > 1e-3) {
            return false;
        }
    }
    return true;
}

bool ss_haptic_is_input_finite(const ss_haptic_input *input)
{
    for (int32_t i = 0; i < input->pose_count; ++i) {
        if (!ss_haptic_is_pose_finite(&input->pose[i])) {
            return false;
        }
    }
    /* The values of a faulted result are never used. */
    return !input->is_result_new || input->result == NULL || input->result->is_fault ||
           is_result_finite(input->result);
}
