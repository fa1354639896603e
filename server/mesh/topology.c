/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Shared edges and faces by sorting: a stable counting pass for each node of a tuple, from the
 * highest to the lowest, which leaves equal tuples in the order of their elements. Linear on any
 * input, the same result on every machine. A hash table was rejected: its order, and on hostile
 * input its time, depend on the hash.
 */
#include "mesh/topology.h"

#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

/* ---- tuples ---- */

static void sort_nodes(int32_t *node, int count)
{
    for (int i = 1; i < count; ++i) {
        const int32_t value = node[i];
        int k = i;
        for (; k > 0 && node[k - 1] > value; --k) {
            node[k] = node[k - 1];
        }
        node[k] = value;
    }
}

bool ss_mesh_is_place(const double x[3])
{
    /* false for what is no number */
    return fabs(x[0]) <= SS_MESH_FARTHEST && fabs(x[1]) <= SS_MESH_FARTHEST &&
           fabs(x[2]) <= SS_MESH_FARTHEST;
}

bool ss_mesh_has_good_nodes(const ss_mesh *mesh, const int32_t *node, int count)
{
    for (int i = 0; i < count; ++i) {
        if (node[i] < 0 || node[i] >= mesh->node_count) {
            return false;
        }
        for (int k = 0; k < i; ++k) {
            if (node[i] == node[k]) {
                return false;
            }
        }
    }
    return true;
}

static void push(ss_mesh_tuples *out, const int32_t *element, const int8_t *corner, int corners,
                 int32_t id)
{
    ss_mesh_tuple *tuple = &out->tuple[out->count];
    for (int k = 0; k < corners; ++k) {
        tuple->node[k] = element[corner[k]];
    }
    sort_nodes(tuple->node, corners);
    tuple->id = id;
    ++out->count;
}

/* Stable, by node `k`; start[n] is scratch of node_count + 1. */
static void sort_by_node(const ss_mesh_tuple *from, int64_t count, int k, int32_t node_count,
                         int64_t *start, ss_mesh_tuple *to)
{
    memset(start, 0, ((size_t)node_count + 1) * sizeof *start);
    for (int64_t i = 0; i < count; ++i) {
        ++start[from[i].node[k] + 1];
    }
    for (int32_t n = 0; n < node_count; ++n) {
        start[n + 1] += start[n];
    }
    for (int64_t i = 0; i < count; ++i) {
        to[start[from[i].node[k]]++] = from[i];
    }
}

static bool sort_tuples(ss_mesh_tuples *tuples, int corners, int32_t node_count)
{
    int64_t *start = ss_memory_get((size_t)node_count + 1, sizeof *start);
    ss_mesh_tuple *other = ss_memory_get((size_t)tuples->count, sizeof *other);
    const bool is_good = start != NULL && other != NULL;
    for (int k = corners - 1; is_good && k >= 0; --k) {
        sort_by_node(tuples->tuple, tuples->count, k, node_count, start, other);
        ss_mesh_tuple *sorted = other;
        other = tuples->tuple;
        tuples->tuple = sorted;
    }
    ss_memory_free(start);
    ss_memory_free(other);
    return is_good;
}

/* Lists `pieces` tuples of `corners` nodes for every good element of `size` nodes. */
static bool list(const ss_mesh *mesh, const int32_t *element, int32_t element_count, int size,
                 const int8_t (*piece)[4], int pieces, int corners, bool has_piece_ids,
                 ss_mesh_tuples *out)
{
    out->count = 0;
    out->tuple = ss_memory_get((size_t)element_count * (size_t)pieces, sizeof *out->tuple);
    if (out->tuple == NULL) {
        return false;
    }
    for (int32_t e = 0; e < element_count; ++e) {
        const int32_t *node = element + (int64_t)size * e;
        for (int p = 0; p < pieces && ss_mesh_has_good_nodes(mesh, node, size); ++p) {
            push(out, node, piece[p], corners, has_piece_ids ? e * pieces + p : e);
        }
    }
    if (!sort_tuples(out, corners, mesh->node_count)) {
        ss_mesh_tuples_fini(out);
        return false;
    }
    return true;
}

static const int8_t whole[1][4] = {{0, 1, 2, 3}};
static const int8_t triangle_edge[3][4] = {{0, 1}, {1, 2}, {2, 0}};
static const int8_t quad_edge[4][4] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
static const int8_t tetrahedron_edge[6][4] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
const int8_t ss_mesh_tetrahedron_face[4][4] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

bool ss_mesh_list_triangle_edges(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->triangle, mesh->triangle_count, 3, triangle_edge, 3, 2,
                true, out);
}

bool ss_mesh_list_triangles(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->triangle, mesh->triangle_count, 3, whole, 1, 3, false,
                out);
}

bool ss_mesh_list_quad_edges(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->quad, mesh->quad_count, 4, quad_edge, 4, 2, true, out);
}

bool ss_mesh_list_quads(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->quad, mesh->quad_count, 4, whole, 1, 4, false, out);
}

bool ss_mesh_list_tetrahedron_edges(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->tetrahedron, mesh->tetrahedron_count, 4,
                tetrahedron_edge, 6, 2, true, out);
}

bool ss_mesh_list_tetrahedron_faces(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->tetrahedron, mesh->tetrahedron_count, 4,
                ss_mesh_tetrahedron_face, 4, 3, true, out);
}

bool ss_mesh_list_tetrahedra(const ss_mesh *mesh, ss_mesh_tuples *out)
{
    return list(mesh, (const int32_t *)mesh->tetrahedron, mesh->tetrahedron_count, 4, whole, 1, 4,
                false, out);
}

void ss_mesh_tuples_fini(ss_mesh_tuples *tuples)
{
    ss_memory_free(tuples->tuple);
    *tuples = (ss_mesh_tuples){0};
}

int64_t ss_mesh_run_end(const ss_mesh_tuples *tuples, int64_t begin)
{
    int64_t end = begin + 1;
    while (end < tuples->count && memcmp(tuples->tuple[end].node, tuples->tuple[begin].node,
                                         sizeof tuples->tuple[end].node) == 0) {
        ++end;
    }
    return end;
}

bool ss_mesh_edge_is_ascending(const ss_mesh *mesh, int32_t id)
{
    const int32_t *node = mesh->triangle[id / 3];
    return node[id % 3] < node[(id % 3 + 1) % 3];
}

bool ss_mesh_is_even(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin, int64_t end)
{
    int64_t up = 0;
    for (int64_t i = begin; i < end; ++i) {
        up += ss_mesh_edge_is_ascending(mesh, edges->tuple[i].id);
    }
    return 2 * up == end - begin;
}

/* ---- parts ---- */

void ss_mesh_union_init(int32_t *parent, int32_t count)
{
    for (int32_t i = 0; i < count; ++i) {
        parent[i] = i;
    }
}

int32_t ss_mesh_union_find(int32_t *parent, int32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* The lower number becomes the root, so that roots do not depend on the order of joining. */
void ss_mesh_union_join(int32_t *parent, int32_t a, int32_t b)
{
    a = ss_mesh_union_find(parent, a);
    b = ss_mesh_union_find(parent, b);
    if (a < b) {
        parent[b] = a;
    } else {
        parent[a] = b;
    }
}

static void join_elements(const ss_mesh *mesh, const int32_t *element, int32_t count, int size,
                          int32_t *parent, bool *is_used)
{
    for (int32_t e = 0; e < count; ++e) {
        const int32_t *node = element + (int64_t)size * e;
        if (!ss_mesh_has_good_nodes(mesh, node, size)) {
            continue;
        }
        for (int k = 0; k < size; ++k) {
            is_used[node[k]] = true;
            ss_mesh_union_join(parent, node[0], node[k]);
        }
    }
}

static void join_middles(const ss_mesh *mesh, int32_t *parent, bool *is_used)
{
    for (int32_t e = 0; mesh->middle != NULL && e < mesh->tetrahedron_count; ++e) {
        const int32_t *corner = mesh->tetrahedron[e];
        for (int s = 0; s < 6 && ss_mesh_has_good_nodes(mesh, corner, 4); ++s) {
            if (ss_mesh_has_good_nodes(mesh, &mesh->middle[e][s], 1)) {
                is_used[mesh->middle[e][s]] = true;
                ss_mesh_union_join(parent, corner[0], mesh->middle[e][s]);
            }
        }
    }
}

int32_t ss_mesh_find_parts(const ss_mesh *mesh, bool by_tetrahedra, int32_t *out_part)
{
    const int32_t n = mesh->node_count;
    int32_t *parent = ss_memory_get((size_t)n, sizeof *parent);
    bool *is_used = ss_memory_get((size_t)n, sizeof *is_used);
    int32_t count = 0;
    if (parent == NULL || is_used == NULL) {
        count = -1;
    } else {
        ss_mesh_union_init(parent, n);
        join_elements(mesh, (const int32_t *)mesh->triangle, mesh->triangle_count, 3, parent,
                      is_used);
        if (by_tetrahedra) {
            join_elements(mesh, (const int32_t *)mesh->tetrahedron, mesh->tetrahedron_count, 4,
                          parent, is_used);
            join_middles(mesh, parent, is_used);
        }
        for (int32_t i = 0; i < n; ++i) {
            const int32_t root = ss_mesh_union_find(parent, i);
            out_part[i] = !is_used[i] ? -1 : root == i ? count++ : out_part[root];
        }
    }
    ss_memory_free(parent);
    ss_memory_free(is_used);
    return count;
}

bool ss_mesh_part_is_within(const ss_mesh_part *inner, const ss_mesh_part *outer)
{
    for (int k = 0; k < 3; ++k) {
        if (!(inner->box_min[k] > outer->box_min[k] && inner->box_max[k] < outer->box_max[k])) {
            return false;
        }
    }
    return true;
}

static bool is_inside_out(const ss_mesh_part *parts, int32_t count, int32_t index)
{
    if (parts[index].is_open || !(parts[index].volume < 0.0)) {
        return false;
    }
    for (int32_t i = 0; i < count && count <= SS_MESH_MAX_PARTS; ++i) {
        if (i != index && ss_mesh_part_is_within(&parts[index], &parts[i])) {
            return false;
        }
    }
    return true;
}

/* V = sum over triangles of a . (b x c) / 6, about the part's first node so that bodies far from
 * the origin lose no digits. */
static void add_triangle(ss_mesh_part *part, const double origin[3], const double *const x[3])
{
    part->volume += ss_six_volumes3(origin, x[0], x[1], x[2]) / 6.0;
    for (int corner = 0; corner < 3; ++corner) {
        for (int k = 0; k < 3; ++k) {
            part->box_min[k] = fmin(part->box_min[k], x[corner][k]);
            part->box_max[k] = fmax(part->box_max[k], x[corner][k]);
        }
    }
}

/* Does the surface go on over the edge: two triangles, or more that can be paired? */
static bool goes_on(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin, int64_t end)
{
    return end - begin == 2 || ss_mesh_is_even(mesh, edges, begin, end);
}

bool ss_mesh_measure_parts(const ss_mesh *mesh, const int32_t *part, int32_t part_count,
                           const ss_mesh_tuples *edges, ss_mesh_part *parts,
                           bool *out_is_inside_out)
{
    for (int32_t i = mesh->node_count - 1; i >= 0; --i) {
        if (part[i] >= 0) {
            ss_copy3(parts[part[i]].box_min, mesh->position[i]);
            ss_copy3(parts[part[i]].box_max, mesh->position[i]);
        }
    }
    /* box_min moves while triangles are added: the fixed origin is the mesh's first node. */
    const double *origin = mesh->node_count > 0 ? mesh->position[0] : NULL;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        if (ss_mesh_has_good_nodes(mesh, node, 3)) {
            const double *const x[3] = {mesh->position[node[0]], mesh->position[node[1]],
                                        mesh->position[node[2]]};
            add_triangle(&parts[part[node[0]]], origin, x);
        }
    }
    for (int64_t i = 0; i < edges->count;) {
        const int64_t end = ss_mesh_run_end(edges, i);
        if (!goes_on(mesh, edges, i, end)) {
            parts[part[edges->tuple[i].node[0]]].is_open = true;
        }
        i = end;
    }
    bool any = false;
    for (int32_t p = 0; p < part_count; ++p) {
        const bool is_bad = is_inside_out(parts, part_count, p);
        if (out_is_inside_out != NULL) {
            out_is_inside_out[p] = is_bad;
        }
        any = any || is_bad;
    }
    return any;
}

/* The smallest part of positive volume whose box a cavity's box lies in; -1: none. */
static int32_t find_shell(const ss_mesh_part *parts, int32_t count, int32_t cavity)
{
    int32_t best = -1;
    for (int32_t i = 0; i < count; ++i) {
        if (parts[i].volume > 0.0 && ss_mesh_part_is_within(&parts[cavity], &parts[i]) &&
            (best < 0 || parts[i].volume < parts[best].volume)) {
            best = i;
        }
    }
    return best;
}

/* Closes up the numbers of `count` parts after cavities have got those of their shells. */
static int32_t join_cavities(const ss_mesh_part *parts, int32_t count, int32_t *number)
{
    int32_t bodies = 0;
    for (int32_t p = 0; p < count; ++p) {
        const bool is_cavity = parts[p].volume < 0.0 && count <= SS_MESH_MAX_PARTS;
        const int32_t shell = is_cavity ? find_shell(parts, count, p) : -1;
        number[p] = shell >= 0 ? -1 - shell : bodies++;
    }
    for (int32_t p = 0; p < count; ++p) {
        number[p] = number[p] < 0 ? number[-1 - number[p]] : number[p];
    }
    return bodies;
}

int32_t ss_mesh_find_bodies(const ss_mesh *mesh, int32_t *out_body)
{
    const ss_mesh_tuples no_edges = {0};
    const int32_t count = ss_mesh_find_parts(mesh, true, out_body);
    if (count < 2) {
        return count;
    }
    ss_mesh_part *parts = ss_memory_get((size_t)count, sizeof *parts);
    int32_t *number = ss_memory_get((size_t)count, sizeof *number);
    int32_t bodies = -1;
    if (parts != NULL && number != NULL) {
        ss_mesh_measure_parts(mesh, out_body, count, &no_edges, parts, NULL);
        bodies = join_cavities(parts, count, number);
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            out_body[i] = out_body[i] < 0 ? -1 : number[out_body[i]];
        }
    }
    ss_memory_free(parts);
    ss_memory_free(number);
    return bodies;
}

bool ss_mesh_find_closed(ss_mesh *mesh)
{
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(mesh, &edges)) {
        return false;
    }
    mesh->is_closed = edges.count > 0;
    for (int64_t i = 0; i < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        mesh->is_closed = mesh->is_closed && goes_on(mesh, &edges, i, end);
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}
