/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Which triangle a surface goes on with over each side, also where the body touches itself.
 *
 * A volume is what its tetrahedra are: parts of it may meet in a node alone, or in an edge, of
 * which the surface then has four triangles or more. There the surface goes on over the edge along
 * the same piece of the body. About the edge from a (the lower node) to b, ordered by angle, a
 * triangle that runs b -> a has the body behind it, one that runs a -> b before it:
 *
 *      d2  u1            u: runs a -> b, ends a piece of the body
 *     ..\ /              d: runs b -> a, starts one; pairs are d1 u1, d2 u2
 *     ...x.....  d1
 *        u2              each d goes on with the u that ends its piece
 *
 * Pieces do not overlap, so they are matched first come, first served, from an angle with no piece
 * around it; that also holds where two triangles lie at one angle but for rounding. With sides
 * paired, the triangles around a node fall into fans, each a corner of the surface of its own,
 * though all move with the one node.
 *
 * Rejected: nodes copied for each fan, which every model, group, load and message would have to map
 * back; pairing by a walk through the tetrahedra, which the skins of second-order and layered
 * bodies do not have.
 */
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <math.h>
#include <stdlib.h>

/* A triangle about an edge. */
typedef struct leaf {
    double angle;
    int32_t side; /* 3 t + corner */
    bool ends;    /* a piece of the body */
} leaf;

static int compare_leaves(const void *left, const void *right)
{
    const leaf *a = left, *b = right;
    const int by_angle = (a->angle > b->angle) - (a->angle < b->angle);
    return ss_order_then(by_angle, ss_order_int(a->side, b->side));
}

bool ss_mesh_is_even(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin, int64_t end)
{
    int64_t up = 0;
    for (int64_t i = begin; i < end; ++i) {
        up += ss_mesh_edge_is_ascending(mesh, edges->tuple[i].id);
    }
    return 2 * up == end - begin;
}

/* From `a` to the corner opposite a side. */
static void find_way(const ss_mesh *mesh, int32_t side, const double a[3], double out[3])
{
    ss_sub3(out, mesh->position[mesh->triangle[side / 3][(side + 2) % 3]], a);
}

/* Angles from the first triangle on. */
static void list_leaves(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin,
                        int64_t end, leaf *out)
{
    double axis[3], first[3], second[3], way[3];
    const double *a = mesh->position[edges->tuple[begin].node[0]];
    ss_sub3(axis, mesh->position[edges->tuple[begin].node[1]], a);
    ss_normalize3(axis);
    find_way(mesh, edges->tuple[begin].id, a, way);
    ss_madd3(first, way, -ss_dot3(way, axis), axis);
    ss_normalize3(first);
    ss_cross3(second, axis, first);
    for (int64_t i = begin; i < end; ++i) {
        const int32_t side = edges->tuple[i].id;
        find_way(mesh, side, a, way);
        out[i - begin] = (leaf){.angle = atan2(ss_dot3(way, second), ss_dot3(way, first)),
                                .side = side,
                                .ends = ss_mesh_edge_is_ascending(mesh, side)};
    }
}

/* As many end as start. `open` has room for `count`. */
static void match_leaves(const leaf *leaves, int32_t count, int32_t *open, int32_t *out_twin)
{
    int32_t depth = 0, least = 0, start = 0;
    for (int32_t i = 0; i < count; ++i) {
        depth += leaves[i].ends ? -1 : 1;
        if (depth < least) {
            least = depth;
            start = i + 1;
        }
    }
    int32_t first = 0, last = 0;
    for (int32_t i = 0; i < count; ++i) {
        const leaf *l = &leaves[(start + i) % count];
        if (l->ends) {
            out_twin[l->side] = open[first];
            out_twin[open[first++]] = l->side;
        } else {
            open[last++] = l->side;
        }
    }
}

static int32_t largest_run(const ss_mesh_tuples *edges)
{
    int64_t most = 0;
    for (int64_t i = 0; i < edges->count;) {
        const int64_t end = ss_mesh_run_end(edges, i);
        most = end - i > most ? end - i : most;
        i = end;
    }
    return (int32_t)most;
}

bool ss_mesh_pair_sides(const ss_mesh *mesh, int32_t *out_twin, int32_t *out_unpaired)
{
    ss_mesh_tuples edges = {0};
    leaf *leaves = NULL;
    int32_t *open = NULL;
    *out_unpaired = -1;
    bool is_done = ss_mesh_list_triangle_edges(mesh, &edges);
    if (is_done) {
        const size_t most = (size_t)largest_run(&edges);
        leaves = ss_memory_get(most, sizeof *leaves);
        open = ss_memory_get(most, sizeof *open);
        is_done = leaves != NULL && open != NULL;
    }
    for (int32_t side = 0; is_done && side < 3 * mesh->triangle_count; ++side) {
        out_twin[side] = -1;
    }
    for (int64_t i = 0; is_done && i < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        const ss_mesh_tuple *edge = &edges.tuple[i];
        const bool is_even = ss_mesh_is_even(mesh, &edges, i, end);
        if (is_even && end - i == 2) {
            out_twin[edge[0].id] = edge[1].id;
            out_twin[edge[1].id] = edge[0].id;
        } else if (is_even) {
            list_leaves(mesh, &edges, i, end, leaves);
            qsort(leaves, (size_t)(end - i), sizeof *leaves, compare_leaves);
            match_leaves(leaves, (int32_t)(end - i), open, out_twin);
        } else if (end - i > 1 && *out_unpaired < 0) {
            *out_unpaired = edge->id;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    SS_EACH(ss_memory_free, leaves, open);
    return is_done;
}
