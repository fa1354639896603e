/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Convex meshes as tools.
 *
 * With m(x) the largest of the faces' plane values n_f . x - b_f: inside, d = m exactly; outside,
 * d is the distance t to the nearest triangle. Planes are first pushed out to hold every vertex, by
 * e at most (the mesh's lack of convexity, refused above 1e-3 of its size); outside then
 * d = max(m, t - e), which meets m at the faces and keeps |grad d| <= 1. So where x is straight
 * above a triangle, h above its plane, t <= h <= m + e and d = m; such a plane's value is m - e at
 * least, since the foot is a point of the pushed hull, h away. Everywhere else t is the distance of
 * the nearest edge. Only the planes, triangles and edges that the cell of x lists are looked at
 * (convex_cells.c), and the last two only outside, where the caller wants to know more than that
 * x is further than m.
 */
#include <float.h>
#include <math.h>

#include "contact/convex_cells.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum {
    MAX_PLANES = 256,     /* after merging */
    MAX_TRIANGLES = 2048, /* a number of one is 16 bits in the cells' lists */
    MAX_VERTICES = 4096
};

/* ---- distance ---- */

/* Is x straight above or below triangle `t`? */
static bool is_over(const ss_convex *convex, int32_t t, const double x[3])
{
    const int32_t *v = convex->triangle[t];
    const double *normal = convex->plane[convex->plane_of[t]];
    for (int k = 0; k < 3; ++k) {
        const double *a = convex->vertex[v[k]];
        double edge[3], r[3], inward[3];
        ss_sub3(edge, convex->vertex[v[(k + 1) % 3]], a);
        ss_sub3(r, x, a);
        ss_cross3(inward, normal, edge);
        if (ss_dot3(r, inward) < 0.0) {
            return false;
        }
    }
    return true;
}

/* The highest of the planes `number`, NULL: of all. */
static double highest_plane(const ss_convex *convex, const uint16_t *number, int32_t count,
                            const double x[3], int32_t *out_plane)
{
    double most = -DBL_MAX;
    *out_plane = 0;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t f = number != NULL ? number[i] : i;
        const double value = ss_convex_plane_value(convex, f, x);
        if (value > most) {
            most = value;
            *out_plane = f;
        }
    }
    return most;
}

/* Is x straight above one of the triangles that can be the nearest? m is `most` there. */
static bool is_over_any(const ss_convex *convex, const uint16_t *number, int32_t count,
                        const double x[3], double most)
{
    for (int32_t i = 0; i < count; ++i) {
        const int32_t t = number != NULL ? number[i] : i;
        if (ss_convex_plane_value(convex, convex->plane_of[t], x) >= most - convex->bulge &&
            is_over(convex, t, x)) {
            return true;
        }
    }
    return false;
}

/* t of the edges `number`, NULL: of all, and the way from there. */
static double nearest_edge(const ss_convex *convex, const uint16_t *number, int32_t count,
                           const double x[3], double out_away[3])
{
    double best = DBL_MAX;
    for (int32_t i = 0; i < count; ++i) {
        double away[3];
        const double square =
            ss_convex_edge_square(convex, number != NULL ? number[i] : i, x, away);
        if (square < best) {
            best = square;
            ss_copy3(out_away, away);
        }
    }
    return sqrt(best);
}

/* The distance to the mesh's box. */
static double box_distance(const ss_convex *convex, const double x[3], double out_normal[3])
{
    for (int k = 0; k < 3; ++k) {
        out_normal[k] = x[k] - fmax(convex->low[k], fmin(convex->high[k], x[k]));
    }
    return ss_normalize3(out_normal);
}

double ss_convex_distance(const ss_convex *convex, const double x[3], double limit,
                          double out_normal[3])
{
    const ss_convex_cell *cell = ss_convex_find_cell(convex, x);
    if (cell == NULL) {
        const double away = box_distance(convex, x, out_normal);
        if (away >= limit) {
            return away;
        }
    }
    const uint16_t *plane = NULL, *triangle = NULL, *edge = NULL; /* beyond the cells: all */
    int32_t planes = convex->plane_count, triangles = convex->triangle_count;
    int32_t edges = convex->edge_count;
    if (cell != NULL) {
        plane = convex->list + cell->plane;
        triangle = convex->list + cell->triangle;
        edge = convex->list + cell->edge;
        planes = cell->triangle - cell->plane;
        triangles = cell->edge - cell->triangle;
        edges = cell->end - cell->edge;
    }
    int32_t top;
    const double most = highest_plane(convex, plane, planes, x, &top);
    ss_copy3(out_normal, convex->plane[top]);
    if (most <= 0.0 || most >= limit || is_over_any(convex, triangle, triangles, x, most)) {
        return most;
    }
    double away[3] = {0.0, 0.0, 0.0};
    const double nearest = nearest_edge(convex, edge, edges, x, away);
    if (nearest - convex->bulge <= most) {
        return most;
    }
    if (nearest > 1e-100) { /* else the plane's normal stands */
        ss_scale3(out_normal, away, 1.0 / nearest);
    }
    return nearest - convex->bulge;
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
                convex->edge, convex->cell, convex->list, convex);
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

static const char no_memory[] = "does not fit into memory";

/* Each edge once, as the first of its triangles has it. A closed surface has it both ways round,
 * each way once; one of doubled faces more often. Why not; NULL when it has. */
static const char *list_edges(ss_convex *convex)
{
    convex->edge = ss_memory_get(3 * (size_t)convex->triangle_count, sizeof *convex->edge);
    if (convex->edge == NULL) {
        return no_memory;
    }
    for (int32_t i = 0; i < 3 * convex->triangle_count; ++i) {
        const int32_t *v = convex->triangle[i / 3];
        const int32_t a = v[i % 3], b = v[(i + 1) % 3];
        bool is_known = false;
        for (int32_t e = 0; e < convex->edge_count && !is_known; ++e) {
            is_known = convex->edge[e][0] == b && convex->edge[e][1] == a;
            if (convex->edge[e][0] == a && convex->edge[e][1] == b) {
                return "has more than two faces at an edge, as where faces are there twice: "
                       "softsim-mesh convert --repair mends it";
            }
        }
        if (!is_known) {
            convex->edge[convex->edge_count][0] = a;
            convex->edge[convex->edge_count++][1] = b;
        }
    }
    return NULL;
}

/* Why a mesh cannot be a convex tool; NULL when it can. */
static const char *build(ss_convex *convex, const ss_mesh *mesh)
{
    if (!mesh->is_closed) {
        return "is not closed";
    }
    if (!copy_mesh(convex, mesh)) {
        return no_memory;
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
    const char *fault = list_edges(convex);
    return fault != NULL ? fault : ss_convex_divide(convex) ? NULL : no_memory;
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
        fault = convex != NULL ? build(convex, mesh) : no_memory;
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
