/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Convex meshes as tools.
 *
 * With m(x) the largest of the faces' plane values n_f . x - b_f: inside, d = m exactly; outside,
 * d is the distance t to the nearest triangle, sought among those whose plane faces x (only they
 * can hold the nearest point) and skipped where the plane value alone exceeds the best so far.
 * Planes are first pushed out to hold every vertex, by e at most (the mesh's lack of convexity,
 * refused above 1e-3 of its size); outside then d = max(m, t - e), which meets m at the faces and
 * keeps |grad d| <= 1. Cost: at most 256 planes a point inside; the triangles only outside.
 */
#include <float.h>
#include <math.h>

#include "contact/shape.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum {
    MAX_PLANES = 256,     /* after merging; bounds the cost of a point */
    MAX_TRIANGLES = 2048, /* the same, outside */
    MAX_VERTICES = 4096
};

struct ss_convex {
    int32_t vertex_count, triangle_count, plane_count;
    double (*vertex)[3];
    int32_t (*triangle)[3];
    int32_t *plane_of;  /* of a triangle */
    double (*plane)[4]; /* outward unit normal, offset */
    double bulge;       /* e, m */
    double centre[3];   /* mean of the vertices */
    double bounding_radius, inradius;
    double low[3], high[3];
};

/* ---- distance ---- */

/* Nearest point of triangle abc to x: of its inside, or of the nearest of its edges. */
static void nearest_on_segment(const double a[3], const double b[3], const double x[3],
                               double out[3])
{
    double edge[3], r[3];
    ss_sub3(edge, b, a);
    ss_sub3(r, x, a);
    const double square = ss_dot3(edge, edge);
    const double t = square > 0.0 ? ss_dot3(r, edge) / square : 0.0;
    ss_madd3(out, a, fmax(0.0, fmin(1.0, t)), edge);
}

/* Distance from x to triangle `t`. */
static double triangle_distance(const ss_convex *convex, int32_t t, const double x[3],
                                double out_nearest[3])
{
    const int32_t *v = convex->triangle[t];
    const double *normal = convex->plane[convex->plane_of[t]];
    double best = DBL_MAX;
    bool is_over = true;
    ss_copy3(out_nearest, x);
    for (int k = 0; k < 3; ++k) {
        const double *a = convex->vertex[v[k]];
        const double *b = convex->vertex[v[(k + 1) % 3]];
        double edge[3], r[3], inward[3];
        ss_sub3(edge, b, a);
        ss_sub3(r, x, a);
        ss_cross3(inward, normal, edge);
        is_over = is_over && ss_dot3(r, inward) >= 0.0;
    }
    if (is_over) {
        double r[3];
        ss_sub3(r, x, convex->vertex[v[0]]);
        const double above = ss_dot3(r, normal);
        ss_madd3(out_nearest, x, -above, normal);
        return fabs(above);
    }
    for (int k = 0; k < 3; ++k) {
        double point[3], r[3];
        nearest_on_segment(convex->vertex[v[k]], convex->vertex[v[(k + 1) % 3]], x, point);
        ss_sub3(r, x, point);
        const double d = ss_norm3(r);
        if (d < best) {
            best = d;
            ss_copy3(out_nearest, point);
        }
    }
    return best;
}

double ss_convex_distance(const ss_convex *convex, const double x[3], double out_normal[3])
{
    double value[MAX_PLANES];
    double most = -DBL_MAX;
    int32_t top = 0;
    for (int32_t f = 0; f < convex->plane_count; ++f) {
        value[f] = ss_dot3(convex->plane[f], x) - convex->plane[f][3];
        if (value[f] > most) {
            most = value[f];
            top = f;
        }
    }
    ss_copy3(out_normal, convex->plane[top]);
    if (most <= 0.0) {
        return most;
    }
    double best = DBL_MAX;
    double nearest[3] = {0.0, 0.0, 0.0};
    for (int32_t t = 0; t < convex->triangle_count; ++t) {
        const double above = value[convex->plane_of[t]];
        if (above > -convex->bulge && above < best) {
            double point[3];
            const double d = triangle_distance(convex, t, x, point);
            if (d < best) {
                best = d;
                ss_copy3(nearest, point);
            }
        }
    }
    if (best == DBL_MAX || best - convex->bulge <= most) {
        return most;
    }
    double away[3];
    ss_sub3(away, x, nearest);
    if (ss_norm3(away) > 1e-100) { /* else the plane's normal stands */
        ss_normalize3(away);
        ss_copy3(out_normal, away);
    }
    return best - convex->bulge;
}

double ss_convex_bounding_radius(const ss_convex *convex)
{
    return convex->bounding_radius;
}

double ss_convex_inradius(const ss_convex *convex)
{
    return convex->inradius;
}

void ss_convex_extent(const ss_convex *convex, double *out_z_low, double *out_z_high,
                      double *out_length)
{
    *out_z_low = convex->low[2];
    *out_z_high = convex->high[2];
    *out_length = 0.0;
    for (int k = 0; k < 3; ++k) {
        *out_length = fmax(*out_length, convex->high[k] - convex->low[k]);
    }
}

void ss_convex_support(const ss_convex *convex, const double direction[3], double out[3])
{
    int32_t best = 0;
    double most = -DBL_MAX;
    for (int32_t i = 0; i < convex->vertex_count; ++i) {
        const double along = ss_dot3(convex->vertex[i], direction);
        if (along > most) {
            most = along;
            best = i;
        }
    }
    ss_copy3(out, convex->vertex[best]);
}

void ss_convex_centre(const ss_convex *convex, double out[3])
{
    ss_copy3(out, convex->centre);
}

int32_t ss_shape_hull(const ss_shape *shape, int32_t most, float (*out_vertex)[3])
{
    if (shape->kind != SS_SHAPE_CONVEX) {
        return 0;
    }
    const int32_t all = shape->convex->vertex_count;
    const int32_t count = all < most ? all : most;
    for (int32_t i = 0; i < count; ++i) {
        const double *vertex = shape->convex->vertex[(int64_t)i * all / count];
        for (int d = 0; d < 3; ++d) {
            out_vertex[i][d] = (float)vertex[d];
        }
    }
    return count;
}

/* ---- create ---- */

static void convex_destroy(ss_convex *convex)
{
    if (convex != NULL) {
        SS_EACH(ss_memory_free, convex->vertex, convex->triangle, convex->plane_of, convex->plane,
                convex);
    }
}

/* Copies the surface's vertices (interior nodes of a volume mesh are left out). */
static bool copy_mesh(ss_convex *convex, const ss_mesh *mesh)
{
    int32_t *number = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t));
    convex->vertex = ss_memory_get(3 * (size_t)mesh->triangle_count, sizeof *convex->vertex);
    convex->triangle = ss_memory_get((size_t)mesh->triangle_count, sizeof *convex->triangle);
    convex->plane_of = ss_memory_get((size_t)mesh->triangle_count, sizeof(int32_t));
    convex->plane = ss_memory_get(MAX_PLANES, sizeof *convex->plane);
    const bool is_good = number != NULL && convex->vertex != NULL && convex->triangle != NULL &&
                         convex->plane_of != NULL && convex->plane != NULL;
    if (is_good) {
        for (int32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
            const int32_t node = mesh->triangle[i / 3][i % 3];
            if (number[node] == 0) {
                ss_copy3(convex->vertex[convex->vertex_count], mesh->position[node]);
                number[node] = ++convex->vertex_count;
            }
            convex->triangle[i / 3][i % 3] = number[node] - 1;
        }
        convex->triangle_count = mesh->triangle_count;
    }
    ss_memory_free(number);
    return is_good;
}

/* Bounds and six times the signed volume. */
static double measure(ss_convex *convex)
{
    double volume = 0.0;
    ss_set3(convex->low, DBL_MAX, DBL_MAX, DBL_MAX);
    ss_set3(convex->high, -DBL_MAX, -DBL_MAX, -DBL_MAX);
    for (int32_t i = 0; i < convex->vertex_count; ++i) {
        const double *x = convex->vertex[i];
        for (int k = 0; k < 3; ++k) {
            convex->low[k] = fmin(convex->low[k], x[k]);
            convex->high[k] = fmax(convex->high[k], x[k]);
        }
        ss_madd3(convex->centre, convex->centre, 1.0 / convex->vertex_count, x);
        convex->bounding_radius = fmax(convex->bounding_radius, ss_norm3(x));
    }
    for (int32_t t = 0; t < convex->triangle_count; ++t) {
        const int32_t *v = convex->triangle[t];
        double r[3][3], cross[3];
        for (int k = 0; k < 3; ++k) {
            ss_sub3(r[k], convex->vertex[v[k]], convex->centre);
        }
        ss_cross3(cross, r[1], r[2]);
        volume += ss_dot3(r[0], cross);
    }
    return volume;
}

/* The plane of triangle `t` among those known, or a new one; -1: too many. A triangle without
 * area takes the first plane: its edges belong to others. */
static int32_t find_plane(ss_convex *convex, int32_t t, double size, double winding)
{
    const int32_t *v = convex->triangle[t];
    double plane[4];
    ss_normal3(plane, convex->vertex[v[0]], convex->vertex[v[1]], convex->vertex[v[2]]);
    ss_scale3(plane, plane, winding);
    if (ss_normalize3(plane) <= 1e-12 * size * size) {
        return 0;
    }
    plane[3] = ss_dot3(plane, convex->vertex[v[0]]);
    for (int32_t f = 0; f < convex->plane_count; ++f) {
        double turn[3];
        ss_sub3(turn, plane, convex->plane[f]);
        if (ss_norm3(turn) < 1e-5 && fabs(plane[3] - convex->plane[f][3]) < 1e-5 * size) {
            return f;
        }
    }
    if (convex->plane_count == MAX_PLANES) {
        return -1;
    }
    for (int k = 0; k < 4; ++k) {
        convex->plane[convex->plane_count][k] = plane[k];
    }
    return convex->plane_count++;
}

/* Pushes the planes out to hold every vertex; `bulge` is the furthest one goes. */
static void push_planes(ss_convex *convex)
{
    convex->inradius = DBL_MAX;
    for (int32_t f = 0; f < convex->plane_count; ++f) {
        double support[3];
        double *plane = convex->plane[f];
        ss_convex_support(convex, plane, support);
        const double offset = ss_dot3(plane, support);
        convex->bulge = fmax(convex->bulge, offset - plane[3]);
        plane[3] = fmax(plane[3], offset);
        convex->inradius = fmin(convex->inradius, plane[3] - ss_dot3(plane, convex->centre));
    }
}

/* Why a mesh cannot be a convex tool; NULL when it can. */
static const char *build(ss_convex *convex, const ss_mesh *mesh)
{
    if (!mesh->is_closed) {
        return "is not closed";
    }
    if (!copy_mesh(convex, mesh)) {
        return "does not fit into memory";
    }
    if (convex->vertex_count > MAX_VERTICES) {
        return "has more than 4096 vertices: give its hull with fewer";
    }
    const double volume = measure(convex);
    double diagonal[3];
    ss_sub3(diagonal, convex->high, convex->low);
    const double size = ss_norm3(diagonal);
    if (!isfinite(size) || !(fabs(volume) > 1e-9 * size * size * size)) {
        return "encloses no volume";
    }
    for (int32_t t = 0; t < convex->triangle_count; ++t) {
        convex->plane_of[t] = find_plane(convex, t, size, copysign(1.0, volume));
        if (convex->plane_of[t] < 0) {
            return "has more than 256 faces: give its hull with fewer";
        }
        if (volume < 0.0) { /* inside out */
            const int32_t swap = convex->triangle[t][1];
            convex->triangle[t][1] = convex->triangle[t][2];
            convex->triangle[t][2] = swap;
        }
    }
    push_planes(convex);
    if (!(convex->bulge <= 1e-3 * size) || !(convex->inradius > 0.0)) {
        return "is not convex within 0.001 of its size: give its convex hull, or a shape";
    }
    return NULL;
}

softsim_status ss_shape_init_convex(ss_shape *shape, const ss_mesh *mesh, softsim_error *error)
{
    *shape = (ss_shape){.kind = SS_SHAPE_CONVEX};
    const char *fault = NULL;
    ss_convex *convex = NULL;
    if (mesh->triangle_count < 4 || mesh->triangle_count > MAX_TRIANGLES) {
        fault = "does not have 4 to 2048 triangles: give its hull with fewer";
    } else {
        convex = ss_memory_get(1, sizeof(ss_convex));
        fault = convex != NULL ? build(convex, mesh) : "does not fit into memory";
    }
    if (fault != NULL) {
        convex_destroy(convex);
        softsim_error_add(error, SOFTSIM_ERROR_MESH, "the convex tool's mesh %s", fault);
        return SOFTSIM_ERROR_MESH;
    }
    shape->convex = convex;
    return SOFTSIM_OK;
}

void ss_shape_fini(ss_shape *shape)
{
    if (shape != NULL) {
        convex_destroy(shape->convex);
        shape->convex = NULL;
    }
}
