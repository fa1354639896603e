/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/grasp.h"
/* Grasps, rotations and what contacts share. */
#include <math.h>
#include <string.h>

#include "rt/hash.h"
#include "rt/vec.h"

/* Time in which a released grasp fades out, s. */
#define GRASP_FADE_TIME 0.02

/* ---- grasp ---- */

void ss_grasp_init(ss_grasp *grasp, int32_t capacity, double max_force, ss_arena *arena)
{
    grasp->max_force = max_force;
    const size_t n = (size_t)capacity;
    SS_ARENA_TAKE(arena, SS_ROOM(n, grasp->node), SS_ROOM(n, grasp->stiffness),
                  SS_ROOM(n, grasp->offset));
}

bool ss_grasp_follow_button(ss_grasp *grasp, bool is_down, const double force[3])
{
    const bool is_overdrawn = grasp->max_force > 0.0 && grasp->is_pressed && grasp->count > 0 &&
                              ss_norm3(force) > grasp->max_force;
    grasp->is_torn = is_down && (grasp->is_torn || is_overdrawn);
    return is_down && !grasp->is_torn;
}

void ss_grasp_take(ss_grasp *grasp, int32_t count, const int32_t *node, const double *weight,
                   double stiffness, const double (*rest)[3], const ss_real *u,
                   const ss_tool_pose *pose)
{
    grasp->fade = 1.0;
    grasp->count = count;
    for (int32_t i = 0; i < count; ++i) {
        double x[3];
        for (int k = 0; k < 3; ++k) {
            x[k] = rest[node[i]][k] + (double)u[4 * (ptrdiff_t)node[i] + k] - pose->position[k];
        }
        grasp->node[i] = node[i];
        grasp->stiffness[i] = stiffness * weight[i];
        ss_rotate_back(grasp->offset[i], pose->orientation, x);
    }
    grasp->unfaded_energy = 0.0;
}

void ss_grasp_stretch(ss_grasp *grasp, const ss_real *force, const ss_tool_pose *pose)
{
    for (int32_t i = 0; i < grasp->count; ++i) {
        const ss_real *f = force + 4 * (ptrdiff_t)grasp->node[i];
        double stretch[3], turned[3];
        for (int k = 0; k < 3; ++k) {
            stretch[k] = (double)f[k] / grasp->stiffness[i];
        }
        ss_rotate_back(turned, pose->orientation, stretch);
        ss_add3(grasp->offset[i], grasp->offset[i], turned);
    }
}

void ss_grasp_add_forces(ss_grasp *grasp, const double (*rest)[3], const ss_real *u,
                         const ss_tool_pose *pose, ss_real *force, double tool_force[3],
                         double tool_torque[3])
{
    grasp->unfaded_energy = 0.0;
    for (int32_t i = 0; i < grasp->count; ++i) {
        const ptrdiff_t at = 4 * (ptrdiff_t)grasp->node[i];
        double arm[3], x[3], f[3], moment[3];
        ss_rotate(arm, pose->orientation, grasp->offset[i]);
        for (int k = 0; k < 3; ++k) {
            x[k] = rest[grasp->node[i]][k] + (double)u[at + k] - pose->position[k];
            const double stretch = x[k] - arm[k];
            f[k] = grasp->fade * grasp->stiffness[i] * stretch; /* on the tool */
            force[at + k] -= (ss_real)f[k];
            grasp->unfaded_energy += 0.5 * grasp->stiffness[i] * stretch * stretch;
        }
        ss_cross3(moment, arm, f);
        ss_add3(tool_force, tool_force, f);
        ss_add3(tool_torque, tool_torque, moment);
    }
}

void ss_grasp_fade(ss_grasp *grasp, double h)
{
    grasp->fade_before = grasp->fade;
    if (!grasp->is_pressed && grasp->count > 0) {
        grasp->fade = fmax(0.0, grasp->fade - h / GRASP_FADE_TIME);
    }
}

double ss_grasp_accept_fade(ss_grasp *grasp)
{
    if (grasp->count == 0) {
        return 0.0;
    }
    const double lost = (grasp->fade_before - grasp->fade) * grasp->unfaded_energy;
    grasp->count = grasp->fade > 0.0 ? grasp->count : 0;
    return lost;
}

uint64_t ss_grasp_hash(const ss_grasp *grasp, uint64_t seed)
{
    const size_t count = (size_t)grasp->count;
    uint64_t hash = ss_hash_bytes(seed, &grasp->count, sizeof grasp->count);
    if (grasp->is_torn) {
        hash = ss_hash_bytes(hash, &grasp->is_torn, sizeof grasp->is_torn);
    }
    if (count > 0) {
        hash = ss_hash_bytes(hash, &grasp->fade, sizeof grasp->fade);
        hash = ss_hash_bytes(hash, grasp->node, count * sizeof *grasp->node);
        hash = ss_hash_bytes(hash, grasp->stiffness, count * sizeof *grasp->stiffness);
        hash = ss_hash_bytes(hash, grasp->offset, count * sizeof *grasp->offset);
    }
    return hash;
}

/* ---- tools ---- */

void ss_tool_rotation(const ss_tool_pose *from, const ss_tool_pose *to, double out_rotation[3])
{
    const double *a = from->orientation, *b = to->orientation;
    /* Rotation vector of b a*, the short way. */
    const double w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double x[3] = {a[0] * b[1] - b[0] * a[1] - b[2] * a[3] + b[3] * a[2],
                         a[0] * b[2] - b[0] * a[2] - b[3] * a[1] + b[1] * a[3],
                         a[0] * b[3] - b[0] * a[3] - b[1] * a[2] + b[2] * a[1]};
    const double sine = ss_norm3(x);
    const double angle = 2.0 * atan2(sine, fabs(w)) * (w < 0.0 ? -1.0 : 1.0);
    ss_scale3(out_rotation, x, sine > 0.0 ? angle / sine : 0.0);
}

void ss_contact_set_direction(const ss_contact_set *set, double out[3])
{
    ss_copy3(out, set->contact[0].normal);
    if (set->count > 1) {
        double along[3];
        ss_copy3(along, set->force);
        if (ss_normalize3(along) > 0.0 && ss_dot3(along, out) > 0.0) {
            ss_copy3(out, along);
        }
    }
}

void ss_contact_set_share(ss_contact_set *set, double stiffness, double viscosity)
{
    double along = 0.0, sum = 0.0, normal[3];
    ss_contact_set_direction(set, normal);
    for (int32_t k = 0; k < set->count; ++k) {
        along += set->contact[k].force * ss_dot3(set->contact[k].normal, normal);
        sum += set->contact[k].force;
    }
    const double whole = ss_dot3(set->force, normal);
    const double factor = along > 0.0 ? whole / along : 0.0;
    for (int32_t k = 0; k < set->count; ++k) {
        ss_contact *contact = &set->contact[k];
        const double share = sum > 0.0 ? contact->force / sum : 1.0 / set->count;
        contact->force = along > 0.0 ? contact->force * factor : whole * share;
        if (!set->is_held) {
            contact->force = fmax(0.0, contact->force);
        }
        contact->stiffness = share * stiffness;
        contact->tangential = share * stiffness;
        contact->viscosity = share * viscosity;
    }
    ss_add3(set->force, set->force, set->friction);
}
