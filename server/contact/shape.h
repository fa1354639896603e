/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Private to contact/: what shape.c needs of convex meshes (convex.c). All RT-safe. */
#include "contact/contact.h"

/* The signed distance of x where that is below `limit`; else a lower bound of it, not below. */
double ss_convex_distance(const ss_convex *convex, const double x[3], double limit,
                          double out_normal[3]);
/* The same of any shape, but for the others always the distance. */
double ss_shape_distance_below(const ss_shape *shape, const double x[3], double limit,
                               double out_normal[3]);
/* The smooth depth of a point inside, and its gradient downwards: out of the tool, at most 1. */
double ss_shape_depth(const ss_shape *shape, const double x[3], double out_gradient[3]);
double ss_convex_bounding_radius(const ss_convex *convex);
double ss_convex_inradius(const ss_convex *convex);
/* Extent along z about the origin, and the largest extent of the bounding box. */
void ss_convex_extent(const ss_convex *convex, double *out_z_low, double *out_z_high,
                      double *out_length);
void ss_convex_support(const ss_convex *convex, const double direction[3], double out[3]);
/* The point of any shape that lies furthest along `direction`, in the tool's frame. */
void ss_shape_support(const ss_shape *shape, const double direction[3], double out[3]);
void ss_convex_centre(const ss_convex *convex, double out[3]);

/* The shape's extent along its axis z: where its contacts are spread. */
void ss_shape_span(const ss_shape *shape, double *out_low, double *out_high);
