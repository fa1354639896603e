/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A body of two layers: tetrahedra inside, and around them the surface of what is to be filled
 * otherwise (the particle layer of `hybrid`). Three ways to it:
 *
 * From two surfaces. A face of the core is covered when the ray along its normal meets the outer
 * surface before it meets the core again; the wall of a cavity looks at itself, a cut base into the
 * open. The body's surface is then the outer one and the core's faces that are not covered. An
 * outer surface with a rim (a ventricle is cut at its base) is joined to the rim that the core's
 * open faces leave, by a strip of triangles: from a pair of nodes (a, b) it steps along the rim
 * whose next node makes the shorter new edge, until both rims are used up. The outer rim is walked
 * against its own direction and the core's along it, so that the strip winds like both.
 *
 * Grown outward. Every node of a surface that is no cavity moves by the thickness along its normal.
 *
 * Grown inward. The tetrahedra none of whose nodes lies deeper than the thickness are taken out;
 * their surface stays. Nodes that were only theirs keep their numbers and ride on the layer.
 *
 * In every case the result is closed where the tetrahedra and the outer surface leave no gap, and
 * "inside the surface and in no tetrahedron" is the layer.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

typedef struct builder {
    const ss_mesh *core, *outer;
    uint8_t *covered; /* by triangle of the core */
    int32_t node_count;
    double (*position)[3];
    int32_t triangle_count;
    int32_t (*triangle)[3];
    int32_t tetrahedron_count;
    int32_t (*tetrahedron)[4];
} builder;

static bool builder_init(builder *b, int32_t node_count, int32_t triangle_count)
{
    b->position = ss_memory_get((size_t)node_count, sizeof *b->position);
    b->triangle = ss_memory_get((size_t)triangle_count, sizeof *b->triangle);
    b->tetrahedron = ss_memory_get((size_t)b->core->tetrahedron_count, sizeof *b->tetrahedron);
    if (b->position == NULL || b->triangle == NULL || b->tetrahedron == NULL) {
        return false;
    }
    memcpy(b->position, b->core->position, (size_t)b->core->node_count * sizeof *b->core->position);
    memcpy(b->tetrahedron, b->core->tetrahedron,
           (size_t)b->core->tetrahedron_count * sizeof *b->core->tetrahedron);
    b->tetrahedron_count = b->core->tetrahedron_count;
    b->node_count = node_count;
    return true;
}

static void builder_fini(builder *b)
{
    SS_EACH(ss_memory_free, b->covered, b->position, b->triangle, b->tetrahedron);
}

static void add_triangle(builder *b, int32_t i, int32_t j, int32_t k)
{
    int32_t *triangle = b->triangle[b->triangle_count++];
    triangle[0] = i;
    triangle[1] = j;
    triangle[2] = k;
}

static bool copy_groups(const ss_mesh *from, ss_mesh *to)
{
    to->group = ss_memory_get((size_t)from->group_count, sizeof *to->group);
    for (int32_t g = 0; to->group != NULL && g < from->group_count; ++g) {
        const size_t count = (size_t)from->group[g].node_count;
        to->group[g] = from->group[g];
        to->group[g].node = ss_memory_get(count, sizeof *to->group[g].node);
        if (to->group[g].node == NULL) {
            return false;
        }
        memcpy(to->group[g].node, from->group[g].node, count * sizeof *to->group[g].node);
        ++to->group_count;
    }
    return to->group != NULL;
}

static softsim_status refuse(softsim_error *error, const char *text)
{
    softsim_error_append(error, SOFTSIM_ERROR_MESH, text);
    return SOFTSIM_ERROR_MESH;
}

static softsim_status lack_memory(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a layer around a core");
    return SOFTSIM_ERROR_MEMORY;
}

/* The mesh of what was built, with the core's groups. */
static softsim_status finish(builder *b, ss_mesh **out, softsim_error *error)
{
    softsim_status status =
        ss_mesh_create(b->node_count, (const double(*)[3])b->position, b->triangle_count,
                       (const int32_t(*)[3])b->triangle, b->tetrahedron_count,
                       (const int32_t(*)[4])b->tetrahedron, out, error);
    if (status == SOFTSIM_OK && !(*out)->is_closed) {
        status = refuse(error, "the outer surface and the core's open faces do not close around "
                               "the layer; softsim-mesh check names their holes");
    }
    if (status == SOFTSIM_OK && !copy_groups(b->core, *out)) {
        status = lack_memory(error);
    }
    if (status != SOFTSIM_OK) {
        ss_mesh_destroy(out);
    }
    return status;
}

/* ---- from two surfaces ---- */

/* How far along the unit `direction` from `origin` the triangle is met; INFINITY: not (Moller and
 * Trumbore 1997). */
static double meet(const ss_mesh *mesh, int32_t t, const double origin[3],
                   const double direction[3])
{
    const int32_t *node = mesh->triangle[t];
    double e1[3], e2[3], p[3], s[3], q[3];
    ss_sub3(e1, mesh->position[node[1]], mesh->position[node[0]]);
    ss_sub3(e2, mesh->position[node[2]], mesh->position[node[0]]);
    ss_sub3(s, origin, mesh->position[node[0]]);
    ss_cross3(p, direction, e2);
    const double determinant = ss_dot3(e1, p);
    const double u = ss_dot3(s, p) / determinant;
    ss_cross3(q, s, e1);
    const double v = ss_dot3(direction, q) / determinant;
    const double along = ss_dot3(e2, q) / determinant;
    const bool is_met = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && along > 0.0; /* false for NaN */
    return is_met ? along : INFINITY;
}

static bool is_covered(const builder *b, int32_t face)
{
    const int32_t *node = b->core->triangle[face];
    double centre[3] = {0};
    double normal[3];
    for (int k = 0; k < 3; ++k) {
        ss_madd3(centre, centre, 1.0 / 3.0, b->core->position[node[k]]);
    }
    ss_normal3(normal, b->core->position[node[0]], b->core->position[node[1]],
               b->core->position[node[2]]);
    ss_normalize3(normal);
    double reach = INFINITY;
    for (int32_t t = 0; t < b->outer->triangle_count; ++t) {
        reach = fmin(reach, meet(b->outer, t, centre, normal));
    }
    for (int32_t t = 0; t < b->core->triangle_count && reach < INFINITY; ++t) {
        if (t != face && meet(b->core, t, centre, normal) < reach) {
            return false;
        }
    }
    return reach < INFINITY;
}

/* Of a surface's triangles that are not left out, the edges without a neighbour: the node that
 * follows along the rim for each, -1 inside. False when a node begins two of them or memory is
 * short; `out_is_simple` tells which. */
static bool find_rims(const ss_mesh *mesh, const uint8_t *left_out, int32_t *next,
                      bool *out_is_simple)
{
    ss_mesh_tuples edges = {0};
    *out_is_simple = true;
    memset(next, 0xff, (size_t)mesh->node_count * sizeof *next);
    if (!ss_mesh_list_triangle_edges(mesh, &edges)) {
        return false;
    }
    for (int64_t i = 0; i < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        int32_t here = -1;
        int32_t faces = 0;
        for (; i < end; ++i) {
            const int32_t id = edges.tuple[i].id;
            if (left_out == NULL || !left_out[id / 3]) {
                here = id;
                ++faces;
            }
        }
        if (faces == 1) {
            const int32_t *node = mesh->triangle[here / 3];
            const int32_t from = node[here % 3];
            *out_is_simple = *out_is_simple && next[from] < 0;
            next[from] = node[(here + 1) % 3];
        }
    }
    ss_mesh_tuples_fini(&edges);
    return *out_is_simple;
}

/* The next rim not yet taken: its nodes in order, as `next` leads; returns their number and takes
 * them out of `next`. */
static int32_t take_rim(int32_t *next, int32_t node_count, int32_t *out)
{
    int32_t count = 0;
    int32_t start = 0;
    while (start < node_count && next[start] < 0) {
        ++start;
    }
    for (int32_t node = start; node < node_count && next[node] >= 0;) {
        const int32_t after = next[node];
        out[count++] = node;
        next[node] = -1;
        node = after;
    }
    return count;
}

static double distance(const builder *b, int32_t i, int32_t j)
{
    double d[3];
    ss_sub3(d, b->position[i], b->position[j]);
    return ss_norm3(d);
}

/* The strip between an outer rim, walked backwards, and a rim of the core. */
static void join_rims(builder *b, const int32_t *outer, int32_t outer_count, const int32_t *core,
                      int32_t core_count)
{
    int32_t first = 0;
    const int32_t start = outer[outer_count - 1];
    for (int32_t j = 1; j < core_count; ++j) {
        first = distance(b, start, core[j]) < distance(b, start, core[first]) ? j : first;
    }
    int32_t i = 0;
    int32_t j = 0;
    while (i < outer_count || j < core_count) {
        const int32_t a = outer[outer_count - 1 - i % outer_count];
        const int32_t a_next = outer[outer_count - 1 - (i + 1) % outer_count];
        const int32_t c = core[(first + j) % core_count];
        const int32_t c_next = core[(first + j + 1) % core_count];
        if (j == core_count ||
            (i < outer_count && distance(b, a_next, c) <= distance(b, a, c_next))) {
            add_triangle(b, a, a_next, c);
            ++i;
        } else {
            add_triangle(b, c_next, c, a);
            ++j;
        }
    }
}

/* Every outer rim with the nearest rim of the core, rim by rim. */
static softsim_status join_all(builder *b, int32_t *outer_next, int32_t *core_next,
                               softsim_error *error)
{
    const int32_t core_nodes = b->core->node_count;
    int32_t *outer = ss_memory_get((size_t)b->outer->node_count, sizeof *outer);
    int32_t *core = ss_memory_get((size_t)core_nodes, sizeof *core);
    softsim_status status = outer != NULL && core != NULL ? SOFTSIM_OK : lack_memory(error);
    while (status == SOFTSIM_OK) {
        const int32_t outer_count = take_rim(outer_next, b->outer->node_count, outer);
        const int32_t core_count = take_rim(core_next, core_nodes, core);
        if (outer_count == 0 && core_count == 0) {
            break;
        }
        if (outer_count == 0 || core_count == 0) {
            status = refuse(error, "the outer surface and what it leaves open of the core have "
                                   "different numbers of rims; close the outer surface around the "
                                   "core, or cut both at the same place");
            break;
        }
        for (int32_t i = 0; i < outer_count; ++i) {
            outer[i] += core_nodes;
        }
        join_rims(b, outer, outer_count, core, core_count);
    }
    ss_memory_free(outer);
    ss_memory_free(core);
    return status;
}

static softsim_status cover(builder *b, softsim_error *error)
{
    const ss_mesh *core = b->core;
    const ss_mesh *outer = b->outer;
    const size_t most = 2 * ((size_t)core->triangle_count + (size_t)outer->triangle_count);
    b->covered = ss_memory_get((size_t)core->triangle_count, 1);
    int32_t *outer_next = ss_memory_get((size_t)outer->node_count, sizeof *outer_next);
    int32_t *core_next = ss_memory_get((size_t)core->node_count, sizeof *core_next);
    softsim_status status = SOFTSIM_OK;
    if (b->covered == NULL || outer_next == NULL || core_next == NULL ||
        !builder_init(b, core->node_count + outer->node_count, (int32_t)most)) {
        status = lack_memory(error);
    }
    int32_t covered = 0;
    for (int32_t t = 0; status == SOFTSIM_OK && t < core->triangle_count; ++t) {
        b->covered[t] = is_covered(b, t);
        covered += b->covered[t];
        if (!b->covered[t]) {
            add_triangle(b, core->triangle[t][0], core->triangle[t][1], core->triangle[t][2]);
        }
    }
    if (status == SOFTSIM_OK && covered == 0) {
        status = refuse(error, "the outer surface covers no face of the core; it must lie around "
                               "it, in the same units and place");
    }
    if (status == SOFTSIM_OK) {
        memcpy(b->position + core->node_count, outer->position,
               (size_t)outer->node_count * sizeof *outer->position);
        for (int32_t t = 0; t < outer->triangle_count; ++t) {
            add_triangle(b, core->node_count + outer->triangle[t][0],
                         core->node_count + outer->triangle[t][1],
                         core->node_count + outer->triangle[t][2]);
        }
        bool is_outer_simple = true;
        bool is_core_simple = true;
        const bool is_found = find_rims(outer, NULL, outer_next, &is_outer_simple) &&
                              find_rims(core, b->covered, core_next, &is_core_simple);
        status = is_found ? join_all(b, outer_next, core_next, error)
                 : !is_outer_simple || !is_core_simple
                     ? refuse(error, "a rim of the outer surface, or of what it leaves open of the "
                                     "core, touches itself; cut both along one smooth curve")
                     : lack_memory(error);
    }
    ss_memory_free(outer_next);
    ss_memory_free(core_next);
    return status;
}

softsim_status ss_mesh_add_skin(const ss_mesh *core, const ss_mesh *outer, ss_mesh **out_mesh,
                                softsim_error *error)
{
    *out_mesh = NULL;
    builder b = {.core = core, .outer = outer};
    softsim_status status = cover(&b, error);
    if (status == SOFTSIM_OK) {
        status = finish(&b, out_mesh, error);
    }
    builder_fini(&b);
    return status;
}

/* ---- grown ---- */

static void area_vector(const double (*x)[3], const int32_t *node, double out[3])
{
    ss_normal3(out, x[node[0]], x[node[1]], x[node[2]]);
}

/* Marks the triangles of cavities in `covered`; false when out of memory. */
static bool find_cavities(builder *b)
{
    const ss_mesh *core = b->core;
    int32_t *part_of = ss_memory_get((size_t)core->node_count, sizeof *part_of);
    const int32_t parts = part_of != NULL ? ss_mesh_find_parts(core, false, part_of) : 0;
    double *volume = ss_memory_get((size_t)parts, sizeof *volume);
    b->covered = ss_memory_get((size_t)core->triangle_count, 1);
    const bool is_good = part_of != NULL && volume != NULL && b->covered != NULL;
    for (int32_t t = 0; is_good && t < core->triangle_count; ++t) {
        const int32_t *node = core->triangle[t];
        double area[3];
        area_vector((const double(*)[3])core->position, node, area);
        volume[part_of[node[0]]] += ss_dot3(area, core->position[node[0]]) / 6.0;
    }
    for (int32_t t = 0; is_good && t < core->triangle_count; ++t) {
        b->covered[t] = volume[part_of[core->triangle[t][0]]] < 0.0;
    }
    ss_memory_free(part_of);
    ss_memory_free(volume);
    return is_good;
}

static softsim_status grow_outward(builder *b, double thickness, softsim_error *error)
{
    const ss_mesh *core = b->core;
    const int32_t nodes = core->node_count;
    double(*normal)[3] = ss_memory_get((size_t)nodes, sizeof *normal);
    int32_t *skin = ss_memory_get((size_t)nodes, sizeof *skin); /* its number above a node, or 0 */
    softsim_status status = SOFTSIM_OK;
    if (normal == NULL || skin == NULL || !find_cavities(b) ||
        !builder_init(b, 2 * nodes, core->triangle_count)) {
        status = lack_memory(error);
    } else {
        ss_mesh_node_area_vectors(core, normal);
        b->node_count = nodes;
    }
    for (int32_t t = 0; status == SOFTSIM_OK && t < core->triangle_count; ++t) {
        int32_t node[3];
        for (int k = 0; k < 3; ++k) {
            node[k] = core->triangle[t][k];
            if (b->covered[t]) {
                continue;
            }
            if (skin[node[k]] == 0) {
                skin[node[k]] = b->node_count++;
                ss_normalize3(normal[node[k]]);
                ss_madd3(b->position[skin[node[k]]], core->position[node[k]], thickness,
                         normal[node[k]]);
            }
            node[k] = skin[node[k]];
        }
        add_triangle(b, node[0], node[1], node[2]);
        double before[3], after[3];
        area_vector((const double(*)[3])core->position, core->triangle[t], before);
        area_vector((const double(*)[3])b->position, node, after);
        if (!(ss_dot3(before, after) > 0.1 * ss_dot3(before, before))) {
            status = refuse(error, "layer.thickness_m is more than the hollows of the surface let "
                                   "it grow; give a thinner layer, or an outer surface");
        }
    }
    ss_memory_free(normal);
    ss_memory_free(skin);
    return status;
}

/* Square of the distance from x to a triangle (Ericson 2004, section 5.1.5). */
static double triangle_distance2(const double x[3], const double a[3], const double b[3],
                                 const double c[3])
{
    double ab[3], ac[3], ax[3];
    ss_sub3(ab, b, a);
    ss_sub3(ac, c, a);
    ss_sub3(ax, x, a);
    const double aa = ss_dot3(ab, ab);
    const double bb = ss_dot3(ab, ac);
    const double cc = ss_dot3(ac, ac);
    const double p = ss_dot3(ab, ax);
    const double q = ss_dot3(ac, ax);
    const double determinant = aa * cc - bb * bb;
    double s = (cc * p - bb * q) / determinant;
    double t = (aa * q - bb * p) / determinant;
    double nearest[3];
    if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) {
        ss_madd3(nearest, a, s, ab);
        ss_madd3(nearest, nearest, t, ac);
        ss_sub3(nearest, x, nearest);
        return ss_dot3(nearest, nearest);
    }
    double best = INFINITY;
    const double *corner[4] = {a, b, c, a};
    for (int k = 0; k < 3; ++k) {
        double edge[3], to[3];
        ss_sub3(edge, corner[k + 1], corner[k]);
        ss_sub3(to, x, corner[k]);
        s = fmin(1.0, fmax(0.0, ss_dot3(to, edge) / ss_dot3(edge, edge)));
        ss_madd3(to, to, -s, edge);
        best = fmin(best, ss_dot3(to, to));
    }
    return best;
}

static bool is_deeper(const ss_mesh *mesh, const double x[3], double depth)
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        if (triangle_distance2(x, mesh->position[node[0]], mesh->position[node[1]],
                               mesh->position[node[2]]) <= depth * depth) {
            return false;
        }
    }
    return true;
}

static softsim_status grow_inward(builder *b, double thickness, softsim_error *error)
{
    const ss_mesh *core = b->core;
    uint8_t *deep = ss_memory_get((size_t)core->node_count, 1);
    if (deep == NULL || !builder_init(b, core->node_count, core->triangle_count)) {
        ss_memory_free(deep);
        return lack_memory(error);
    }
    for (int32_t i = 0; i < core->node_count; ++i) {
        deep[i] = is_deeper(core, core->position[i], thickness);
    }
    memcpy(b->triangle, core->triangle, (size_t)core->triangle_count * sizeof *core->triangle);
    b->triangle_count = core->triangle_count;
    b->tetrahedron_count = 0;
    for (int32_t e = 0; e < core->tetrahedron_count; ++e) {
        const int32_t *node = core->tetrahedron[e];
        if (deep[node[0]] || deep[node[1]] || deep[node[2]] || deep[node[3]]) {
            memcpy(b->tetrahedron[b->tetrahedron_count++], node, sizeof *core->tetrahedron);
        }
    }
    ss_memory_free(deep);
    if (b->tetrahedron_count == 0) {
        return refuse(error, "no node lies deeper than layer.thickness_m, so that no core is left; "
                             "give a thinner layer, or a mesh with more nodes inside");
    }
    if (b->tetrahedron_count == core->tetrahedron_count) {
        return refuse(error, "every tetrahedron reaches deeper than layer.thickness_m, so that the "
                             "layer has no room; give a thicker one, or a finer mesh");
    }
    return SOFTSIM_OK;
}

softsim_status ss_mesh_grow_skin(const ss_mesh *volume, double thickness, ss_mesh **out_mesh,
                                 softsim_error *error)
{
    *out_mesh = NULL;
    builder b = {.core = volume};
    softsim_status status =
        thickness > 0.0 ? grow_outward(&b, thickness, error) : grow_inward(&b, -thickness, error);
    if (status == SOFTSIM_OK) {
        status = finish(&b, out_mesh, error);
    }
    builder_fini(&b);
    return status;
}
