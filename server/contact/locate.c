/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "contact/contact.h"

#include <math.h>

#include "contact/shape.h"
#include "rt/vec.h"

/*
 * Where a tool that appears stands to the tissue. The penalty of the samples cannot tell: a tool
 * put deep into a closed surface pushes the near wall outwards over itself. Here the nearest point
 * of the deformed surface to the tool's origin is found (every triangle, closest point by
 * Ericson's regions, Real-Time Collision Detection 5.1.5), the side by the sum of the normals of
 * the triangles that share that point, weighted by their angle there (Baerentzen and Aanaes 2005:
 * the sign is then right at edges and corners too).
 */

/* Nearest points whose distances differ by so little, relatively, are equally near, and one where
 * they are no further from each other either: the triangles share it. In the middle of a cavity or
 * a body there are others on other walls, and the sum of all their normals points nowhere. */
#define SHARED 1e-9
/* A way out ends where the tool is no deeper than this share of its size; looks on the way. */
#define TOUCHING 0.01
enum { LOOKS = 16 };

typedef struct nearest {
    double square; /* of the distance */
    double point[3];
    double normal[3]; /* angle-weighted sum */
} nearest;

void ss_contact_closest(const double p[3], const double a[3], const double b[3], const double c[3],
                        double out[3])
{
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    ss_sub3(ab, b, a);
    ss_sub3(ac, c, a);
    ss_sub3(ap, p, a);
    ss_sub3(bp, p, b);
    ss_sub3(cp, p, c);
    const double d1 = ss_dot3(ab, ap), d2 = ss_dot3(ac, ap);
    const double d3 = ss_dot3(ab, bp), d4 = ss_dot3(ac, bp);
    const double d5 = ss_dot3(ab, cp), d6 = ss_dot3(ac, cp);
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0.0 && d2 <= 0.0) {
        ss_copy3(out, a);
    } else if (d3 >= 0.0 && d4 <= d3) {
        ss_copy3(out, b);
    } else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        ss_madd3(out, a, d1 / (d1 - d3), ab);
    } else if (d6 >= 0.0 && d5 <= d6) {
        ss_copy3(out, c);
    } else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        ss_madd3(out, a, d2 / (d2 - d6), ac);
    } else if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        double bc[3];
        ss_sub3(bc, c, b);
        ss_madd3(out, b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), bc);
    } else {
        const double sum = va + vb + vc;
        ss_madd3(out, a, vb / sum, ab);
        ss_madd3(out, out, vc / sum, ac);
    }
}

/* Angle under which triangle abc is seen from its point q: 2 pi inside, pi on an edge. */
static double angle_at(const double q[3], const double *const corner[3])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double e[3], f[3], normal[3];
        ss_sub3(e, corner[k], q);
        ss_sub3(f, corner[(k + 1) % 3], q);
        ss_cross3(normal, e, f);
        const double cosine = ss_dot3(e, f);
        sum += cosine == 0.0 && ss_norm3(normal) == 0.0 ? 0.0 : atan2(ss_norm3(normal), cosine);
    }
    return sum;
}

static void visit(const double p[3], const double *const corner[3], nearest *best)
{
    double point[3], way[3], normal[3];
    ss_contact_closest(p, corner[0], corner[1], corner[2], point);
    ss_sub3(way, point, p);
    const double square = ss_dot3(way, way);
    if (!(square <= best->square * (1.0 + SHARED))) {
        return;
    }
    ss_normal3(normal, corner[0], corner[1], corner[2]);
    if (ss_normalize3(normal) == 0.0) {
        return;
    }
    double apart[3];
    ss_sub3(apart, point, best->point);
    if (square < best->square * (1.0 - SHARED)) {
        best->square = square;
        ss_copy3(best->point, point);
        ss_set3(best->normal, 0.0, 0.0, 0.0);
    } else if (ss_dot3(apart, apart) > SHARED * square) {
        return;
    }
    ss_madd3(best->normal, best->normal, angle_at(point, corner), normal);
}

double ss_contact_locate(const ss_mesh *mesh, const ss_real *u, const ss_shape *shape,
                         const ss_tool_pose *pose, double out_point[3], double out_normal[3])
{
    nearest best = {.square = INFINITY};
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double x[3][3];
        for (int k = 0; k < 3; ++k) {
            const int32_t i = mesh->triangle[t][k];
            for (int axis = 0; axis < 3; ++axis) {
                x[k][axis] = mesh->position[i][axis] + (u ? (double)u[4 * i + axis] : 0.0);
            }
        }
        const double *const corner[3] = {x[0], x[1], x[2]};
        visit(pose->position, corner, &best);
    }
    ss_copy3(out_point, best.point);
    ss_copy3(out_normal, best.normal);
    if (!isfinite(best.square) || ss_normalize3(out_normal) == 0.0) {
        ss_set3(out_normal, 0.0, 0.0, 1.0);
        return -INFINITY;
    }
    double way[3], inward_tool[3], inward[3], support[3];
    ss_sub3(way, pose->position, best.point);
    const double distance = sqrt(best.square);
    const bool is_behind = ss_dot3(way, out_normal) < 0.0;
    ss_scale3(inward, out_normal, -1.0);
    ss_rotate_back(inward_tool, pose->orientation, inward);
    ss_shape_support(shape, inward_tool, support);
    const double reach = ss_dot3(support, inward_tool);
    if (is_behind && !mesh->is_closed && distance > reach) {
        return -INFINITY;
    }
    return reach - (is_behind ? -distance : distance);
}

/* The deeper of the tool's two depths: in the tissue as it is, and as it rests. */
static double deepest(const ss_contact_tissue *tissue, const ss_shape *shape,
                      const ss_tool_pose *pose, double out_normal[3])
{
    double point[3], normal[3];
    double depth = ss_contact_locate(tissue->mesh, tissue->u, shape, pose, point, out_normal);
    if (tissue->is_deformed) {
        const double at_rest = ss_contact_locate(tissue->mesh, NULL, shape, pose, point, normal);
        if (at_rest > depth) {
            depth = at_rest;
            ss_copy3(out_normal, normal);
        }
    }
    return depth;
}

/* Goes out by its depth again and again: `outward`, or (NULL) by the nearest way, which turns as
 * other walls come near. A straight way ends where it first leaves the tissue, since no depth is
 * more than what is left of it. False: there are looks left on this way, but none in this call. */
static bool go_out(const ss_contact_tissue *tissue, const ss_shape *shape, const ss_tool_pose *from,
                   const double outward[3], ss_contact_path *path, int32_t *left)
{
    const double enough = TOUCHING * ss_shape_bounding_radius(shape);
    for (; !path->is_out && path->looks<LOOKS && * left> 0; --*left, ++path->looks) {
        ss_tool_pose pose = *from;
        double normal[3];
        ss_add3(pose.position, from->position, path->way);
        const double depth = deepest(tissue, shape, &pose, normal);
        path->is_out = depth <= enough;
        if (!path->is_out) {
            ss_madd3(path->way, path->way, depth, outward ? outward : normal);
        }
    }
    return path->is_out || path->looks == LOOKS;
}

ss_contact_exit_result ss_contact_leave(const ss_contact_tissue *tissue, const ss_shape *shape,
                                        const ss_tool_pose *pose, double spare,
                                        const double inward[3], ss_contact_exit *search,
                                        double out_way[3])
{
    int32_t left = SS_EXIT_LOOKS;
    double normal[3], back[3];
    ss_set3(out_way, 0.0, 0.0, 0.0);
    if (!search->is_begun) {
        *search = (ss_contact_exit){.is_begun = true, .from = *pose};
        --left;
        if (deepest(tissue, shape, pose, normal) <= spare) {
            return SS_EXIT_FOUND;
        }
    }
    ss_scale3(back, inward, -1.0);
    const bool is_known = ss_norm3(back) > 0.0;
    if (!go_out(tissue, shape, &search->from, NULL, &search->nearest, &left) ||
        (is_known && !go_out(tissue, shape, &search->from, back, &search->back, &left))) {
        return SS_EXIT_UNFINISHED;
    }
    const double most = 2.0 * (ss_norm3(search->nearest.way) + ss_shape_bounding_radius(shape));
    const bool is_back = is_known && search->back.is_out &&
                         (!search->nearest.is_out || ss_norm3(search->back.way) <= most);
    ss_copy3(out_way, is_back ? search->back.way : search->nearest.way);
    return is_back || search->nearest.is_out ? SS_EXIT_FOUND : SS_EXIT_NONE;
}
