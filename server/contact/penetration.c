/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Overlap of two placed shapes: the one file that sees libccd.
 *
 * Minkowski portal refinement, which neither allocates nor (with capped iterations) runs on. Its
 * tolerances are absolute, so both shapes are scaled to a size of about 1 about the middle of
 * their origins: millimetres in metres made it miss one overlap in a hundred. Its depth is not the
 * least one and can be off by a third; its direction n, and the line between the centres, are
 * each given their exact depth max_a n.a - min_b n.b by two supports, and the lesser is taken.
 * A negative depth along either is a separating axis: no overlap.
 */
#include <ccd/ccd.h>
#include <float.h>
#include <math.h>

#include "contact/shape.h"
#include "rt/vec.h"

typedef struct placed {
    const ss_shape *shape;
    double orientation[4];
    double position[3]; /* scaled */
    double scale;       /* 1/m */
} placed;

static void world_support(const placed *object, const double direction[3], double out[3])
{
    double local_direction[3], local[3];
    ss_rotate_back(local_direction, object->orientation, direction);
    ss_shape_support(object->shape, local_direction, local);
    ss_rotate(out, object->orientation, local);
    ss_scale3(out, out, object->scale);
    ss_add3(out, out, object->position);
}

static void world_centre(const placed *object, double out[3])
{
    double local[3] = {0.0, 0.0, 0.0};
    if (object->shape->kind == SS_SHAPE_CONVEX) {
        ss_convex_centre(object->shape->convex, local);
    }
    ss_rotate(out, object->orientation, local);
    ss_scale3(out, out, object->scale);
    ss_add3(out, out, object->position);
}

static void ccd_support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    world_support(object, direction->v, out->v);
}

static void ccd_centre(const void *object, ccd_vec3_t *out)
{
    world_centre(object, out->v);
}

/* How far b must move along the unit vector n to leave a. */
static double depth_along(const placed *a, const placed *b, const double n[3])
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double far_a[3], far_b[3];
    world_support(a, n, far_a);
    world_support(b, back, far_b);
    return ss_dot3(far_a, n) - ss_dot3(far_b, n);
}

static void place(const ss_shape *shape, const ss_tool_pose *pose, const double middle[3],
                  double scale, placed *out)
{
    out->shape = shape;
    out->scale = scale;
    for (int k = 0; k < 4; ++k) {
        out->orientation[k] = pose->orientation[k];
    }
    ss_sub3(out->position, pose->position, middle);
    ss_scale3(out->position, out->position, scale);
}

static bool is_usable(const ss_tool_pose *pose)
{
    return ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4);
}

bool ss_shape_penetration(const ss_shape *a, const ss_tool_pose *pose_a, const ss_shape *b,
                          const ss_tool_pose *pose_b, double *out_depth, double out_direction[3],
                          int64_t *inout_failures)
{
    const double radius_a = ss_shape_bounding_radius(a);
    const double radius_b = ss_shape_bounding_radius(b);
    double apart[3];
    ss_sub3(apart, pose_b->position, pose_a->position);
    *out_depth = 0.0;
    ss_set3(out_direction, 0.0, 0.0, 1.0);
    if (!is_usable(pose_a) || !is_usable(pose_b) || ss_norm3(apart) > radius_a + radius_b) {
        return false;
    }
    const double scale = 1.0 / fmax(radius_a, radius_b);
    double middle[3];
    placed object[2];
    ss_madd3(middle, pose_a->position, 0.5, apart);
    place(a, pose_a, middle, scale, &object[0]);
    place(b, pose_b, middle, scale, &object[1]);

    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd_support;
    ccd.support2 = ccd_support;
    ccd.center1 = ccd_centre;
    ccd.center2 = ccd_centre;
    ccd.max_iterations = 100;
    ccd.mpr_tolerance = 1e-6;
    ccd_real_t rough_depth;
    ccd_vec3_t direction;
    ccd_vec3_t position;
    if (ccdMPRPenetration(&object[0], &object[1], &ccd, &rough_depth, &direction, &position) != 0) {
        return false;
    }

    /* Grazing contacts come without a direction; the centre line then stands in. */
    double candidate[2][3], centre[2][3];
    world_centre(&object[0], centre[0]);
    world_centre(&object[1], centre[1]);
    ss_copy3(candidate[0], direction.v);
    ss_sub3(candidate[1], centre[1], centre[0]);
    double least = DBL_MAX;
    for (int k = 0; k < 2; ++k) {
        if (ss_is_finite(candidate[k], 3) && ss_normalize3(candidate[k]) > 1e-12) {
            const double depth = depth_along(&object[0], &object[1], candidate[k]);
            if (depth < least) {
                least = depth;
                ss_copy3(out_direction, candidate[k]);
            }
        }
    }
    if (least == DBL_MAX) {
        if (inout_failures != NULL) {
            ++*inout_failures;
        }
        return false;
    }
    *out_depth = fmax(least, 0.0) / scale;
    return least > 0.0;
}
