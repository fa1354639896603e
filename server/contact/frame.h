/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to contact/: distances of points of the tissue from a placed tool.
 *
 * Points come relative to the tool's origin, along the world's axes. Sphere and capsule ("round")
 * are computed in ss_real from the distance to their core, square first; the others in double, in
 * the tool's own frame, by ss_shape_distance. Wide values go by pointer: passed by value they
 * would need one calling convention for all processors.
 */
#include <math.h>

#include "contact/shape.h"
#include "contact/surface.h"
#include "rt/vec.h"

/* A tool pose in the surface's frame (world axes, origin at the surface's centre). */
typedef struct ss_frame {
    const ss_shape *shape;
    double orientation[4];
    ss_wide origin; /* m, the tool's, relative to the surface's centre */
    /* Sphere and capsule: distance to the segment of half-length `core` along `axis`. */
    bool is_round;
    ss_real axis[3], core, radius;
} ss_frame;

/* `origin_shift`: where the pose's coordinates have the surface's centre. */
void ss_frame_set(ss_frame *frame, const ss_shape *shape, const double origin_shift[3],
                  const ss_tool_pose *pose);
/* Signed distance of the point at `r`, and its gradient (may be NULL), in double. */
double ss_frame_distance(const ss_frame *frame, const ss_real r[3], double out_normal[3]);
/* A lower bound of the distance, exact inside: what a cull asks. */
double ss_frame_distance_bound(const ss_frame *frame, const ss_real r[3]);
/* The smooth depth of the point at `r` inside the tool, its direction out of the tool, unit, and
 * the size of its gradient. Of what has -d, distance and normal as they are, and 1. */
void ss_frame_depth(const ss_frame *frame, const ss_wide *r, ss_real *inout_depth,
                    ss_real inout_normal[3], ss_real *out_lean);
/* The gradient on a round tool's core, where there is none: a fixed choice. */
void ss_frame_core_normal(const ss_frame *frame, ss_real out[3]);

static inline ss_real ss_wide_square(const ss_wide *a)
{
    return (*a)[0] * (*a)[0] + (*a)[1] * (*a)[1] + (*a)[2] * (*a)[2];
}

static inline ss_real ss_real_root(ss_real x)
{
#ifdef SOFTSIM_DOUBLE
    return sqrt(x);
#else
    return sqrtf(x);
#endif
}

/* Vector from the nearest point of a round tool's core. */
static inline void ss_frame_from_core(const ss_frame *frame, const ss_wide *r, ss_wide *out)
{
    *out = *r;
    if (frame->core > 0) {
        const ss_real *a = frame->axis;
        ss_real t = (*r)[0] * a[0] + (*r)[1] * a[1] + (*r)[2] * a[2];
        t = t > frame->core ? frame->core : t < -frame->core ? -frame->core : t;
        *out -= (ss_wide){t * a[0], t * a[1], t * a[2], 0};
    }
}

/* Unit vector along `r` of length `length`; a fixed one on the core. */
static inline void ss_frame_normal(const ss_frame *frame, const ss_wide *r, ss_real length,
                                   ss_real out[3])
{
    if (length > (ss_real)1e-15) { /* shorter ones have squares that underflow */
        const ss_real scale = 1 / length;
        out[0] = scale * (*r)[0];
        out[1] = scale * (*r)[1];
        out[2] = scale * (*r)[2];
    } else {
        ss_frame_core_normal(frame, out);
    }
}

/* Is the point at `r` surely further from the tool than `distance`? False when not a number. */
static inline bool ss_frame_is_beyond(const ss_frame *frame, const ss_wide *r, ss_real distance)
{
    if (frame->is_round) {
        ss_wide q;
        ss_frame_from_core(frame, r, &q);
        const ss_real reach = frame->radius + distance;
        return ss_wide_square(&q) > reach * reach;
    }
    const ss_real at[3] = {(*r)[0], (*r)[1], (*r)[2]};
    return ss_frame_distance_bound(frame, at) > (double)distance;
}

/* The distance where it is less than `limit`, with its gradient; else false. */
static inline bool ss_frame_find(const ss_frame *frame, const ss_wide *r, ss_real limit,
                                 ss_real *out_d, ss_real out_normal[3])
{
    if (frame->is_round) {
        ss_wide q;
        ss_frame_from_core(frame, r, &q);
        const ss_real reach = frame->radius + limit;
        const ss_real square = ss_wide_square(&q);
        if (!(square < reach * reach)) {
            return false;
        }
        const ss_real length = ss_real_root(square);
        *out_d = length - frame->radius;
        ss_frame_normal(frame, &q, length, out_normal);
        return *out_d < limit;
    }
    const double world[3] = {(double)(*r)[0], (double)(*r)[1], (double)(*r)[2]};
    double local[3], normal[3];
    ss_rotate_back(local, frame->orientation, world);
    *out_d = (ss_real)ss_shape_distance_below(frame->shape, local, (double)limit, normal);
    if (!(*out_d < limit)) {
        return false;
    }
    ss_rotate(local, frame->orientation, normal);
    for (int k = 0; k < 3; ++k) {
        out_normal[k] = (ss_real)local[k];
    }
    return true;
}
