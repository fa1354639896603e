/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * In the place of convex.c and convex_cells.c where SOFTSIM_CONVEX is OFF: a scene with a convex
 * tool is refused, so that no shape has a convex mesh and the rest is never called.
 * Rejected: conditions in each file that knows the kinds of shapes.
 */
#include "contact/shape.h"

#include <math.h>

#include "rt/vec.h"

softsim_status ss_shape_init_convex(ss_shape *shape, const ss_mesh *mesh, softsim_error *error)
{
    (void)mesh;
    *shape = (ss_shape){.kind = SS_SHAPE_CONVEX};
    softsim_error_add(error, SOFTSIM_ERROR_MESH,
                      "the convex tool is not in this build (SOFTSIM_CONVEX=OFF): build with "
                      "-DSOFTSIM_CONVEX=ON, or use a sphere, capsule, box, cylinder or cone");
    return SOFTSIM_ERROR_MESH;
}

void ss_shape_fini(ss_shape *shape)
{
    (void)shape;
}

int32_t ss_shape_hull(const ss_shape *shape, int32_t most, float (*out_vertex)[3])
{
    (void)shape;
    (void)most;
    (void)out_vertex;
    return 0;
}

double ss_convex_distance(const ss_convex *convex, const double x[3], double limit,
                          double out_normal[3])
{
    (void)convex;
    (void)x;
    (void)limit;
    ss_set3(out_normal, 0.0, 0.0, 1.0);
    return INFINITY;
}

double ss_convex_bounding_radius(const ss_convex *convex)
{
    (void)convex;
    return 0.0;
}

double ss_convex_inradius(const ss_convex *convex)
{
    (void)convex;
    return 0.0;
}

void ss_convex_extent(const ss_convex *convex, double *out_z_low, double *out_z_high,
                      double *out_length)
{
    (void)convex;
    *out_z_low = *out_z_high = *out_length = 0.0;
}

void ss_convex_support(const ss_convex *convex, const double direction[3], double out[3])
{
    (void)convex;
    (void)direction;
    ss_set3(out, 0.0, 0.0, 0.0);
}

void ss_convex_centre(const ss_convex *convex, double out[3])
{
    (void)convex;
    ss_set3(out, 0.0, 0.0, 0.0);
}
