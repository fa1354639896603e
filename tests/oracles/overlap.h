/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Do two placed shapes overlap? By libccd's Minkowski portal refinement, from their supports alone:
 * an independent judge of signed distances. The tolerances of libccd are absolute, so both shapes
 * are scaled to a size of about 1 about the middle of their origins; millimetres in metres make it
 * miss one overlap in a hundred. Its depth is not the least one, by up to a third, and is not
 * asked.
 */
#include <ccd/ccd.h>
#include <math.h>
#include <stdbool.h>

#include "contact/shape.h"
#include "rt/vec.h"

typedef struct placed_shape {
    const ss_shape *shape;
    const ss_tool_pose *pose;
    double middle[3];
    double scale; /* 1/m */
} placed_shape;

static inline void placed_point(const placed_shape *object, const double local[3], double out[3])
{
    ss_rotate(out, object->pose->orientation, local);
    ss_add3(out, out, object->pose->position);
    ss_sub3(out, out, object->middle);
    ss_scale3(out, out, object->scale);
}

static inline void placed_support(const void *what, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const placed_shape *object = what;
    double local_direction[3], local[3];
    ss_rotate_back(local_direction, object->pose->orientation, direction->v);
    ss_shape_support(object->shape, local_direction, local);
    placed_point(object, local, out->v);
}

static inline void placed_centre(const void *what, ccd_vec3_t *out)
{
    const placed_shape *object = what;
    double local[3] = {0.0, 0.0, 0.0};
    if (object->shape->kind == SS_SHAPE_CONVEX) {
        ss_convex_centre(object->shape->convex, local);
    }
    placed_point(object, local, out->v);
}

static inline bool do_shapes_overlap(const ss_shape *a, const ss_tool_pose *pose_a,
                                     const ss_shape *b, const ss_tool_pose *pose_b)
{
    placed_shape first = {.shape = a, .pose = pose_a}, second = {.shape = b, .pose = pose_b};
    double apart[3];
    ss_sub3(apart, pose_b->position, pose_a->position);
    ss_madd3(first.middle, pose_a->position, 0.5, apart);
    ss_copy3(second.middle, first.middle);
    first.scale = 1.0 / fmax(ss_shape_bounding_radius(a), ss_shape_bounding_radius(b));
    second.scale = first.scale;
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = placed_support;
    ccd.center1 = ccd.center2 = placed_centre;
    ccd.max_iterations = 100;
    ccd.mpr_tolerance = 1e-6;
    return ccdMPRIntersect(&first, &second, &ccd) != 0;
}
