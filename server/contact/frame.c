/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "contact/frame.h"

#include <string.h>

void ss_frame_set(ss_frame *frame, const ss_shape *shape, const double origin_shift[3],
                  const ss_tool_pose *pose)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    double axis[3];
    *frame = (ss_frame){.shape = shape};
    memcpy(frame->orientation, pose->orientation, sizeof frame->orientation);
    ss_rotate(axis, pose->orientation, z);
    for (int k = 0; k < 3; ++k) {
        frame->origin[k] = (ss_real)(pose->position[k] - origin_shift[k]);
        frame->axis[k] = (ss_real)axis[k];
    }
    frame->is_round = shape->kind == SS_SHAPE_SPHERE || shape->kind == SS_SHAPE_CAPSULE;
    frame->core = shape->kind == SS_SHAPE_CAPSULE ? (ss_real)shape->half_length : 0;
    frame->radius = (ss_real)shape->radius;
}

void ss_frame_core_normal(const ss_frame *frame, ss_real out[3])
{
    static const double centre[3] = {0.0, 0.0, 0.0};
    double normal[3], world[3];
    ss_shape_distance(frame->shape, centre, normal);
    ss_rotate(world, frame->orientation, normal);
    for (int k = 0; k < 3; ++k) {
        out[k] = (ss_real)world[k];
    }
}

/* The distance to a round tool's core, less its radius. */
static double round_distance(const ss_frame *frame, const double r[3], double out_normal[3])
{
    const double axis[3] = {(double)frame->axis[0], (double)frame->axis[1], (double)frame->axis[2]};
    const double core = (double)frame->core;
    const double along = ss_dot3(r, axis);
    const double t = along > core ? core : along < -core ? -core : along;
    double q[3];
    ss_madd3(q, r, -t, axis);
    const double length = ss_norm3(q);
    if (out_normal != NULL) {
        ss_real normal[3];
        const ss_wide from = {(ss_real)q[0], (ss_real)q[1], (ss_real)q[2], 0};
        ss_frame_normal(frame, &from, (ss_real)length, normal);
        ss_set3(out_normal, (double)normal[0], (double)normal[1], (double)normal[2]);
    }
    return length - (double)frame->radius;
}

double ss_frame_distance(const ss_frame *frame, const ss_real r[3], double out_normal[3])
{
    const double world[3] = {(double)r[0], (double)r[1], (double)r[2]};
    double local[3], normal[3];
    if (frame->is_round) {
        return round_distance(frame, world, out_normal);
    }
    ss_rotate_back(local, frame->orientation, world);
    const double d = ss_shape_distance(frame->shape, local, normal);
    if (out_normal != NULL) {
        ss_rotate(out_normal, frame->orientation, normal);
    }
    return d;
}

void ss_frame_depth(const ss_frame *frame, const ss_wide *r, ss_real *inout_depth,
                    ss_real inout_normal[3], ss_real *out_lean)
{
    const double world[3] = {(double)(*r)[0], (double)(*r)[1], (double)(*r)[2]};
    double local[3], gradient[3];
    *out_lean = 1;
    if (frame->is_round || frame->shape->kind == SS_SHAPE_CONVEX) {
        return;
    }
    ss_rotate_back(local, frame->orientation, world);
    *inout_depth = (ss_real)ss_shape_depth(frame->shape, local, gradient);
    ss_rotate(local, frame->orientation, gradient);
    const double size = ss_norm3(local);
    *out_lean = (ss_real)size;
    for (int k = 0; k < 3 && size > 0.0; ++k) {
        inout_normal[k] = (ss_real)(local[k] / size);
    }
}

double ss_frame_distance_bound(const ss_frame *frame, const ss_real r[3])
{
    const double world[3] = {(double)r[0], (double)r[1], (double)r[2]};
    double local[3], normal[3];
    ss_rotate_back(local, frame->orientation, world);
    return ss_shape_distance_below(frame->shape, local, 0.0, normal);
}
