/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Quads: one sense of u and w over a surface, and their cutting into triangles.
 *
 * Directions. Side c of a quad runs along u when c is even, along w when it is odd. The first quad
 * of a connected part keeps its corners as written; a flood over shared sides turns the others by
 * one corner where their common side would run along u in one and along w in the other. Nothing is
 * refused: where no choice fits everywhere (three quads at a cube's corner) the quad reached first
 * decides and the sides left over are counted by ss_mesh_check (mixed_direction). A field of frames
 * with singularities placed at will was rejected: a file's u would not stay what it says.
 *
 * Cutting. Along the diagonal
 *   1. that leaves no half flat or folded onto the other, when the other diagonal does;
 *   2. that joins even nodes, on a structured part: every inner node has four quads and every node
 *      of the rim at most three. The nodes' sides are then coloured even and odd in turn, from the
 *      part's first quad's lowest node. On a grid node (i, j) is even when i + j is, so that the
 *      diagonals of neighbouring quads mirror each other: one-way diagonals would make a grid
 *      stiffer along one slant. Where the colours do not close (a ring of an odd number) rule 3;
 *   3. that is shorter; of equal ones (to 1e-9) that of the quad's lowest node.
 * The halves of quad q are triangles 2q and 2q + 1, which start at the two ends of the diagonal,
 * first the one with the lower number in the file: (p0, p1, p2) and (p2, p3, p0).
 */
#include "mesh/topology.h"
#include "rt/arena.h"
#include "rt/vec.h"

#include <string.h>

/* Half the cross product of the two sides at each corner. */
static void corner_vectors(const ss_mesh *mesh, const int32_t *quad, double out_vector[4][3])
{
    for (int k = 0; k < 4; ++k) {
        ss_normal3(out_vector[k], mesh->position[quad[k]], mesh->position[quad[(k + 1) % 4]],
                   mesh->position[quad[(k + 3) % 4]]);
        ss_scale3(out_vector[k], out_vector[k], 0.5);
    }
}

/* ---- cutting ---- */

/* Relative: of areas, of lengths. */
static const double flat_half = 1e-6;
static const double equal_length = 1e-9;

/* Do halves a and b have areas and face the same way? */
static bool are_sound(const double a[3], const double b[3])
{
    const double sum = ss_norm3(a) + ss_norm3(b);
    return ss_dot3(a, b) > flat_half * sum * sum;
}

/* 0: from corner 0 to 2, 1: from corner 1 to 3. `preferred` (-1: none) is rule 2's. */
static int choose_diagonal(const ss_mesh *mesh, const int32_t *quad, int preferred)
{
    double corner[4][3];
    if (!ss_mesh_has_good_nodes(mesh, quad, 4)) {
        return 0;
    }
    corner_vectors(mesh, quad, corner);
    const bool is_sound[2] = {are_sound(corner[1], corner[3]), are_sound(corner[0], corner[2])};
    if (is_sound[0] != is_sound[1]) {
        return is_sound[0] ? 0 : 1;
    }
    if (preferred >= 0) {
        return preferred;
    }
    double length[2];
    for (int d = 0; d < 2; ++d) {
        double along[3];
        ss_sub3(along, mesh->position[quad[d + 2]], mesh->position[quad[d]]);
        length[d] = ss_norm3(along);
    }
    if (fabs(length[0] - length[1]) > equal_length * (length[0] + length[1])) {
        return length[0] < length[1] ? 0 : 1;
    }
    const int32_t low[2] = {quad[0] < quad[2] ? quad[0] : quad[2],
                            quad[1] < quad[3] ? quad[1] : quad[3]};
    return low[0] < low[1] ? 0 : 1;
}

void ss_mesh_share_quad(const ss_mesh *mesh, const int32_t *quad, double out_area[4],
                        double out_vector[4][3])
{
    double corner[4][3];
    corner_vectors(mesh, quad, corner);
    const bool is_sound[2] = {are_sound(corner[1], corner[3]), are_sound(corner[0], corner[2])};
    memset(out_area, 0, 4 * sizeof *out_area);
    memset(out_vector, 0, 4 * sizeof *out_vector);
    for (int d = 0; d < 2; ++d) {
        const double weight = is_sound[0] == is_sound[1] ? 0.5 : is_sound[d] ? 1.0 : 0.0;
        for (int half = d + 1; half < d + 4; half += 2) {
            const double area = ss_norm3(corner[half % 4]);
            for (int k = half + 3; k < half + 6; ++k) {
                out_area[k % 4] += weight / 3.0 * area;
                ss_madd3(out_vector[k % 4], out_vector[k % 4], weight / 3.0, corner[half % 4]);
            }
        }
    }
}

static void cut_along(const int32_t *quad, int diagonal, int32_t out_triangle[2][3])
{
    const int start = quad[diagonal] < quad[diagonal + 2] ? diagonal : diagonal + 2;
    for (int half = 0; half < 2; ++half) {
        for (int k = 0; k < 3; ++k) {
            out_triangle[half][k] = quad[(start + 2 * half + k) % 4];
        }
    }
}

void ss_mesh_cut_quad(const ss_mesh *mesh, const int32_t *quad, int32_t out_triangle[2][3])
{
    cut_along(quad, choose_diagonal(mesh, quad, -1), out_triangle);
}

void ss_mesh_turn_quad(ss_mesh *mesh, int32_t q)
{
    int32_t *quad = mesh->quad[q];
    const int diagonal =
        mesh->triangle[2 * (int64_t)q][0] == quad[0] || mesh->triangle[2 * (int64_t)q][0] == quad[2]
            ? 0
            : 1;
    const int32_t turned[4] = {quad[1], quad[0], quad[3], quad[2]};
    memcpy(quad, turned, sizeof turned);
    cut_along(quad, 1 - diagonal, &mesh->triangle[2 * (int64_t)q]);
}

/* ---- the flood ---- */

typedef struct arranger {
    ss_arena arena;
    ss_mesh *mesh;
    ss_mesh_tuples edges;
    int32_t (*neighbour)[4]; /* across side c: side 4 q + c of another quad, or -1 */
    int32_t *queue;
    bool *is_reached;
    bool *is_turned;    /* by one corner, so that side c becomes side c - 1 */
    bool *is_preferred; /* rule 2 holds on its part */
    int8_t *colour;     /* of nodes: 0 even, 1 odd, -1 not yet */
    int8_t *quads;      /* at a node, up to 5 */
    bool *is_rim;       /* of nodes */
} arranger;

static void arranger_fini(arranger *a)
{
    ss_mesh_tuples_fini(&a->edges);
    ss_arena_free(&a->arena);
}

static bool arranger_init(arranger *a, ss_mesh *mesh)
{
    const size_t quads = (size_t)mesh->quad_count;
    const size_t nodes = (size_t)mesh->node_count;
    *a = (arranger){.mesh = mesh};
    SS_ARENA_TAKE(&a->arena, SS_ROOM(quads, a->neighbour), SS_ROOM(quads, a->queue),
                  SS_ROOM(quads, a->is_reached), SS_ROOM(quads, a->is_turned),
                  SS_ROOM(quads, a->is_preferred), SS_ROOM(nodes, a->colour),
                  SS_ROOM(nodes, a->quads), SS_ROOM(nodes, a->is_rim));
    if (ss_arena_status(&a->arena) != SOFTSIM_OK || !ss_mesh_list_quad_edges(mesh, &a->edges)) {
        return false;
    }
    memset(a->neighbour, 0xff, quads * sizeof *a->neighbour);
    memset(a->colour, 0xff, nodes * sizeof *a->colour);
    for (int64_t i = 0; i < a->edges.count;) {
        const int64_t end = ss_mesh_run_end(&a->edges, i);
        const ss_mesh_tuple *edge = &a->edges.tuple[i];
        if (end - i == 2) {
            a->neighbour[edge[0].id / 4][edge[0].id % 4] = edge[1].id;
            a->neighbour[edge[1].id / 4][edge[1].id % 4] = edge[0].id;
        } else {
            a->is_rim[edge->node[0]] = true;
            a->is_rim[edge->node[1]] = true;
        }
        /* Each quad has two sides at each of its nodes: twice the number of quads, so far. */
        for (int64_t k = i; k < end; ++k) {
            for (int n = 0; n < 2; ++n) {
                int8_t *count = &a->quads[edge->node[n]];
                *count = (int8_t)(*count < 10 ? *count + 1 : 10);
            }
        }
        i = end;
    }
    for (size_t i = 0; i < nodes; ++i) {
        a->quads[i] = (int8_t)(a->quads[i] / 2);
    }
    return true;
}

/* Gives quad q's nodes alternating colours where they have none. */
static void colour_quad(arranger *a, int32_t q)
{
    const int32_t *quad = a->mesh->quad[q];
    int known = 0;
    while (known < 4 && a->colour[quad[known]] < 0) {
        ++known;
    }
    if (known == 4) {
        known = 0;
        for (int k = 1; k < 4; ++k) {
            known = quad[k] < quad[known] ? k : known;
        }
        a->colour[quad[known]] = 0;
    }
    for (int k = 0; k < 4; ++k) {
        int8_t *colour = &a->colour[quad[k]];
        *colour = *colour >= 0 ? *colour : (int8_t)((a->colour[quad[known]] + k - known) & 1);
    }
}

static bool is_regular(const arranger *a, int32_t q)
{
    bool is = true;
    for (int k = 0; k < 4; ++k) {
        const int32_t node = a->mesh->quad[q][k];
        is = is && (a->is_rim[node] ? a->quads[node] <= 3 : a->quads[node] == 4);
    }
    return is;
}

static void flood(arranger *a, int32_t seed)
{
    int32_t count = 1;
    bool is_structured = true;
    a->queue[0] = seed;
    a->is_reached[seed] = true;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t q = a->queue[i];
        colour_quad(a, q);
        is_structured = is_structured && is_regular(a, q);
        for (int32_t c = 0; c < 4; ++c) {
            const int32_t other = a->neighbour[q][c];
            if (other >= 0 && !a->is_reached[other / 4]) {
                a->is_reached[other / 4] = true;
                a->is_turned[other / 4] = a->is_turned[q] != (((c ^ other) & 1) != 0);
                a->queue[count++] = other / 4;
            }
        }
    }
    for (int32_t i = 0; i < count; ++i) {
        a->is_preferred[a->queue[i]] = is_structured;
    }
}

/* The diagonal of the even nodes, or -1 where the colours do not alternate round the quad. */
static int even_diagonal(const arranger *a, int32_t q)
{
    const int32_t *quad = a->mesh->quad[q];
    const int8_t first = a->colour[quad[0]];
    const int8_t second = a->colour[quad[1]];
    return first != second && a->colour[quad[2]] == first && a->colour[quad[3]] == second ? first
                                                                                          : -1;
}

bool ss_mesh_arrange_quads(ss_mesh *mesh)
{
    arranger a;
    const bool is_done = arranger_init(&a, mesh);
    for (int32_t q = 0; is_done && q < mesh->quad_count; ++q) {
        if (!a.is_reached[q] && ss_mesh_has_good_nodes(mesh, mesh->quad[q], 4)) {
            flood(&a, q);
        }
    }
    for (int32_t q = 0; is_done && q < mesh->quad_count; ++q) {
        int32_t *quad = mesh->quad[q];
        if (a.is_turned[q]) {
            const int32_t turned[4] = {quad[1], quad[2], quad[3], quad[0]};
            memcpy(quad, turned, sizeof turned);
        }
        const int preferred = a.is_preferred[q] ? even_diagonal(&a, q) : -1;
        cut_along(quad, choose_diagonal(mesh, quad, preferred), &mesh->triangle[2 * (int64_t)q]);
    }
    arranger_fini(&a);
    return is_done;
}
