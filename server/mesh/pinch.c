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
#include "mesh/leaves.h"
#include "rt/each.h"
#include "rt/memory.h"

/* As many end a piece of the body as start one. `open` has room for `count`. */
static void match_leaves(const ss_leaf *leaves, int32_t count, int32_t *open, int32_t *out_twin)
{
    int32_t depth = 0, least = 0, start = 0;
    for (int32_t i = 0; i < count; ++i) {
        depth += leaves[i].is_ascending ? -1 : 1;
        if (depth < least) {
            least = depth;
            start = i + 1;
        }
    }
    int32_t first = 0, last = 0;
    for (int32_t i = 0; i < count; ++i) {
        const ss_leaf *l = &leaves[(start + i) % count];
        if (l->is_ascending) {
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
    ss_leaf *leaves = NULL;
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
            ss_leaf_axis axis;
            ss_mesh_sort_leaves(mesh, &edges, i, (int32_t)(end - i), &axis, leaves);
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
