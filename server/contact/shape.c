/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Signed distances of the tools' shapes, in closed form.
 *
 * Sphere and capsule: distance to a point or segment, less the radius. Box: with q = |x| - e,
 * d = |max(q, 0)| outside, max q inside. Cylinder and cone are turned figures: with r = |(x, y)|
 * the distance to a rectangle or triangle in the half-plane (r, z). All are exact, so 1-Lipschitz
 * and with a unit gradient wherever they have one. Where they have none (centre, axis, medial
 * faces) a fixed choice is made: +x off the axis, +z at a sphere's centre, the first of equal
 * faces.
 *
 * Depth of a point inside, for what presses on it: -d has a gradient that jumps across the medial
 * faces, and at a cone's axis; tissue that slides over an edge, or lies about an apex, was thrown
 * from one side to the other, up to a sixth of the force in a tick where a mesh is coarse. It is
 *   1/D^2 = sum_i 1/d_i^2,   grad D = sum_i (D/d_i)^3 grad d_i,
 * d_i the depths below the faces: 0 where they are, with the gradient of the face away from the
 * edges, |grad D| <= 1. A cylinder's side has R - r; a cone's, of radius h at that height,
 * n_r (h^2 - r^2)/(2 h), a rounded apex. Sphere and capsule keep -d, as do convex meshes (a sum
 * over all their faces). With powers of -4 for -2 tissue still snaps over a box's edge. Rejected:
 * rounded shapes (another surface, and a size to choose).
 *
 * Rejected: distances by libccd, which has no distance query and a depth that is not the
 * least.
 */
#include <math.h>

#include "contact/shape.h"
#include "rt/vec.h"

/* Squares of lengths below this underflow; directions so short are replaced by the fixed choice. */
static const double tiny = 1e-100;

/* Splits x into radius r and unit direction off the z axis. */
static double split_axis(const double x[3], double out_radial[3])
{
    const double r = hypot(x[0], x[1]);
    if (r > tiny) {
        ss_set3(out_radial, x[0] / r, x[1] / r, 0.0);
    } else {
        ss_set3(out_radial, 1.0, 0.0, 0.0);
    }
    return r;
}

/* The gradient of a turned figure: nr along the radial direction, nz along the axis. */
static void join_axis(const double radial[3], double nr, double nz, double out_normal[3])
{
    ss_set3(out_normal, nr * radial[0], nr * radial[1], nz);
}

static double capsule_distance(double radius, double half_length, const double x[3],
                               double out_normal[3])
{
    const double z = fmax(-half_length, fmin(half_length, x[2]));
    ss_set3(out_normal, x[0], x[1], x[2] - z);
    const double length = ss_norm3(out_normal);
    if (length > tiny) {
        ss_scale3(out_normal, out_normal, 1.0 / length);
    } else if (half_length > 0.0) {
        ss_set3(out_normal, 1.0, 0.0, 0.0);
    } else {
        ss_set3(out_normal, 0.0, 0.0, 1.0);
    }
    return length - radius;
}

static double box_distance(const double extent[3], const double x[3], double out_normal[3])
{
    double q[3], outside[3];
    int deepest = 0;
    for (int k = 0; k < 3; ++k) {
        q[k] = fabs(x[k]) - extent[k];
        outside[k] = copysign(fmax(q[k], 0.0), x[k]);
        deepest = q[k] > q[deepest] ? k : deepest;
    }
    if (q[deepest] <= tiny) {
        ss_set3(out_normal, 0.0, 0.0, 0.0);
        out_normal[deepest] = copysign(1.0, x[deepest]);
        return q[deepest];
    }
    ss_copy3(out_normal, outside);
    return ss_normalize3(out_normal);
}

static double cylinder_distance(double radius, double half_length, const double x[3],
                                double out_normal[3])
{
    double radial[3];
    const double qr = split_axis(x, radial) - radius;
    const double qz = fabs(x[2]) - half_length;
    const double up = copysign(1.0, x[2]);
    if (qr > tiny && qz > tiny) {
        const double d = hypot(qr, qz);
        join_axis(radial, qr / d, up * qz / d, out_normal);
        return d;
    }
    if (qr >= qz) {
        join_axis(radial, 1.0, 0.0, out_normal);
        return qr;
    }
    ss_set3(out_normal, 0.0, 0.0, up);
    return qz;
}

/* Half-plane figure: base from (0, -L) to (R, -L), side from (R, -L) to the apex (0, L). The side's
 * outward normal is (2L, R)/s, s = |(R, 2L)|. */
static double cone_distance(double radius, double half_length, const double x[3],
                            double out_normal[3])
{
    double radial[3];
    const double r = split_axis(x, radial);
    const double slant = hypot(radius, 2.0 * half_length);
    const double nr = 2.0 * half_length / slant;
    const double nz = radius / slant;
    const double side = (r - radius) * nr + (x[2] + half_length) * nz;
    const double base = -half_length - x[2];
    if (side <= 0.0 && base <= 0.0) {
        if (side >= base) {
            join_axis(radial, nr, nz, out_normal);
            return side;
        }
        ss_set3(out_normal, 0.0, 0.0, -1.0);
        return base;
    }
    /* Position along the side from the rim (0) to the apex (slant). */
    const double along = (radius - r) * nz + (x[2] + half_length) * nr;
    if (side > 0.0 && along >= 0.0 && along <= slant) {
        join_axis(radial, nr, nz, out_normal);
        return side;
    }
    if (base > 0.0 && r <= radius) {
        ss_set3(out_normal, 0.0, 0.0, -1.0);
        return base;
    }
    const double corner_r = along > slant ? 0.0 : radius;
    const double corner_z = along > slant ? half_length : -half_length;
    const double d = hypot(r - corner_r, x[2] - corner_z);
    if (d > tiny) {
        join_axis(radial, (r - corner_r) / d, (x[2] - corner_z) / d, out_normal);
    } else {
        join_axis(radial, nr, nz, out_normal);
    }
    return d;
}

double ss_shape_distance(const ss_shape *shape, const double x[3], double out_normal[3])
{
    return ss_shape_distance_below(shape, x, INFINITY, out_normal);
}

double ss_shape_distance_below(const ss_shape *shape, const double x[3], double limit,
                               double out_normal[3])
{
    /* Also false for NaN; squares further out would overflow. */
    if (!(fabs(x[0]) < 1e60 && fabs(x[1]) < 1e60 && fabs(x[2]) < 1e60)) {
        ss_set3(out_normal, 0.0, 0.0, 1.0);
        return INFINITY;
    }
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        return capsule_distance(shape->radius, 0.0, x, out_normal);
    case SS_SHAPE_CAPSULE:
        return capsule_distance(shape->radius, shape->half_length, x, out_normal);
    case SS_SHAPE_BOX:
        return box_distance(shape->half_extent, x, out_normal);
    case SS_SHAPE_CYLINDER:
        return cylinder_distance(shape->radius, shape->half_length, x, out_normal);
    case SS_SHAPE_CONE:
        return cone_distance(shape->radius, shape->half_length, x, out_normal);
    case SS_SHAPE_CONVEX:
        return ss_convex_distance(shape->convex, x, limit, out_normal);
    }
    ss_set3(out_normal, 0.0, 0.0, 1.0);
    return INFINITY;
}

/* One face's depth, and its gradient out of the tool. */
typedef struct face_depth {
    double depth, normal[3];
} face_depth;

/* D and -grad D of `count` faces, all of them above x. */
static double blend_faces(const face_depth *face, int count, double out_gradient[3])
{
    double least = face[0].depth, sum = 0.0;
    for (int i = 1; i < count; ++i) {
        least = fmin(least, face[i].depth);
    }
    ss_set3(out_gradient, 0.0, 0.0, 0.0);
    for (int i = 0; i < count; ++i) {
        const double q = least / face[i].depth;
        sum += q * q;
        ss_madd3(out_gradient, out_gradient, q * q * q, face[i].normal);
    }
    const double root = sqrt(sum);
    ss_scale3(out_gradient, out_gradient, 1.0 / (root * sum));
    return least / root;
}

static int box_faces(const double extent[3], const double x[3], face_depth out[6])
{
    for (int k = 0; k < 3; ++k) {
        for (int side = 0; side < 2; ++side) {
            const double sign = side == 0 ? 1.0 : -1.0;
            face_depth *face = &out[2 * k + side];
            face->depth = extent[k] - sign * x[k];
            ss_set3(face->normal, 0.0, 0.0, 0.0);
            face->normal[k] = sign;
        }
    }
    return 6;
}

static int cylinder_faces(double radius, double half_length, const double x[3], face_depth out[6])
{
    double radial[3];
    out[0].depth = radius - split_axis(x, radial);
    ss_copy3(out[0].normal, radial);
    for (int side = 0; side < 2; ++side) {
        const double sign = side == 0 ? 1.0 : -1.0;
        out[1 + side].depth = half_length - sign * x[2];
        ss_set3(out[1 + side].normal, 0.0, 0.0, sign);
    }
    return 3;
}

static int cone_faces(double radius, double half_length, const double x[3], face_depth out[6])
{
    double radial[3];
    const double slant = hypot(radius, 2.0 * half_length);
    const double nr = 2.0 * half_length / slant, nz = radius / slant;
    const double h = (half_length - x[2]) * radius / (2.0 * half_length);
    const double share = split_axis(x, radial) / h;
    out[0].depth = 0.5 * nr * h * (1.0 - share * share);
    join_axis(radial, nr * share, 0.5 * nz * (1.0 + share * share), out[0].normal);
    out[1].depth = half_length + x[2];
    ss_set3(out[1].normal, 0.0, 0.0, -1.0);
    return 2;
}

double ss_shape_depth(const ss_shape *shape, const double x[3], double out_gradient[3])
{
    face_depth face[6];
    int count = 0;
    switch (shape->kind) {
    case SS_SHAPE_BOX:
        count = box_faces(shape->half_extent, x, face);
        break;
    case SS_SHAPE_CYLINDER:
        count = cylinder_faces(shape->radius, shape->half_length, x, face);
        break;
    case SS_SHAPE_CONE:
        count = cone_faces(shape->radius, shape->half_length, x, face);
        break;
    case SS_SHAPE_SPHERE:
    case SS_SHAPE_CAPSULE:
    case SS_SHAPE_CONVEX:
        break;
    }
    for (int i = 0; i < count; ++i) {
        count = face[i].depth > 0.0 ? count : 0; /* on a face, but for rounding */
    }
    return count > 0 ? blend_faces(face, count, out_gradient)
                     : -ss_shape_distance(shape, x, out_gradient);
}

double ss_shape_bounding_radius(const ss_shape *shape)
{
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        return shape->radius;
    case SS_SHAPE_CAPSULE:
        return shape->radius + shape->half_length;
    case SS_SHAPE_BOX:
        return ss_norm3(shape->half_extent);
    case SS_SHAPE_CYLINDER:
    case SS_SHAPE_CONE:
        return hypot(shape->radius, shape->half_length);
    case SS_SHAPE_CONVEX:
        return ss_convex_bounding_radius(shape->convex);
    }
    return 0.0;
}

double ss_shape_curvature_radius(const ss_shape *shape)
{
    const bool is_round = shape->kind == SS_SHAPE_SPHERE || shape->kind == SS_SHAPE_CAPSULE ||
                          shape->kind == SS_SHAPE_CYLINDER;
    return is_round ? shape->radius : 0.0;
}

double ss_shape_inradius(const ss_shape *shape)
{
    const double *e = shape->half_extent;
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
    case SS_SHAPE_CAPSULE:
        return shape->radius;
    case SS_SHAPE_BOX:
        return fmin(e[0], fmin(e[1], e[2]));
    case SS_SHAPE_CYLINDER:
        return fmin(shape->radius, shape->half_length);
    case SS_SHAPE_CONE: /* incircle of the triangle with base 2 R and height 2 L */
        return 2.0 * shape->radius * shape->half_length /
               (shape->radius + hypot(shape->radius, 2.0 * shape->half_length));
    case SS_SHAPE_CONVEX:
        return ss_convex_inradius(shape->convex);
    }
    return 0.0;
}

void ss_shape_span(const ss_shape *shape, double *out_low, double *out_high)
{
    double high = 0.0;
    double length = 0.0;
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        break;
    case SS_SHAPE_CAPSULE:
    case SS_SHAPE_CYLINDER:
    case SS_SHAPE_CONE:
        high = shape->half_length;
        break;
    case SS_SHAPE_BOX:
        high = shape->half_extent[2];
        break;
    case SS_SHAPE_CONVEX:
        ss_convex_extent(shape->convex, out_low, out_high, &length);
        return;
    }
    *out_low = -high;
    *out_high = high;
}

double ss_shape_gyration(const ss_shape *shape)
{
    const double *e = shape->half_extent;
    double low = 0.0;
    double high = 0.0;
    double length = 0.0;
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        return 0.0;
    case SS_SHAPE_CAPSULE:
        length = 2.0 * (shape->half_length + shape->radius);
        break;
    case SS_SHAPE_BOX:
        length = 2.0 * fmax(e[0], fmax(e[1], e[2]));
        break;
    case SS_SHAPE_CYLINDER:
    case SS_SHAPE_CONE:
        length = 2.0 * fmax(shape->half_length, shape->radius);
        break;
    case SS_SHAPE_CONVEX:
        ss_convex_extent(shape->convex, &low, &high, &length);
        break;
    }
    return fmax(0.005, length / sqrt(12.0));
}

static double sign_of(double x)
{
    return x < 0.0 ? -1.0 : 1.0;
}

void ss_shape_support(const ss_shape *shape, const double direction[3], double out[3])
{
    double n[3];
    ss_copy3(n, direction);
    ss_normalize3(n);
    const double flat = hypot(n[0], n[1]);
    const double rim[2] = {flat > 0.0 ? n[0] / flat : 1.0, flat > 0.0 ? n[1] / flat : 0.0};
    const double up = sign_of(n[2]);
    const double *e = shape->half_extent;
    ss_set3(out, 0.0, 0.0, 0.0);
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        ss_scale3(out, n, shape->radius);
        break;
    case SS_SHAPE_CAPSULE:
        ss_scale3(out, n, shape->radius);
        out[2] += up * shape->half_length;
        break;
    case SS_SHAPE_BOX:
        ss_set3(out, sign_of(n[0]) * e[0], sign_of(n[1]) * e[1], up * e[2]);
        break;
    case SS_SHAPE_CYLINDER:
        ss_set3(out, shape->radius * rim[0], shape->radius * rim[1], up * shape->half_length);
        break;
    case SS_SHAPE_CONE:
        if (2.0 * shape->half_length * n[2] > shape->radius * flat) {
            ss_set3(out, 0.0, 0.0, shape->half_length);
        } else {
            ss_set3(out, shape->radius * rim[0], shape->radius * rim[1], -shape->half_length);
        }
        break;
    case SS_SHAPE_CONVEX:
        ss_convex_support(shape->convex, n, out);
        break;
    }
}

/* ---- poses ---- */

void ss_tool_pose_blend(const ss_tool_pose *from, const ss_tool_pose *to, double s,
                        ss_tool_pose *out)
{
    const double *a = from->orientation;
    const double *b = to->orientation;
    const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = dot < 0.0 ? -1.0 : 1.0;
    double length = 0.0;
    double q[4];
    for (int k = 0; k < 4; ++k) {
        q[k] = (1.0 - s) * a[k] + s * sign * b[k];
        length += q[k] * q[k];
    }
    for (int k = 0; k < 4; ++k) {
        out->orientation[k] = q[k] / sqrt(length);
    }
    for (int k = 0; k < 3; ++k) {
        out->position[k] = (1.0 - s) * from->position[k] + s * to->position[k];
    }
}

double ss_tool_motion_bound(const ss_shape *shape, const ss_tool_pose *from, const ss_tool_pose *to)
{
    const double *a = from->orientation;
    const double *b = to->orientation;
    const double dot = fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]);
    const double angle = shape->kind == SS_SHAPE_SPHERE ? 0.0 : 2.0 * acos(fmin(1.0, dot));
    double shift[3];
    ss_sub3(shift, to->position, from->position);
    return ss_norm3(shift) + angle * ss_shape_bounding_radius(shape);
}
