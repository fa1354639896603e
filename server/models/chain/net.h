/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The chain links of a mesh, each counted once, and as the kernels want them.
 *
 * In: a mesh. Links are the edges of its tetrahedra, else the sides of its quads, else the edges of
 * its triangles. Out: pairs of nodes in order, then groups of SS_CHAIN_LANES links that are worked
 * on at once. Within a group no node appears twice where that can be had from the next
 * SS_CHAIN_WINDOW links: two additions to the same node in a row wait for one another (57 us a step
 * of the liver instead of 49); a wider window wakes more groups beside a moving node.
 * Thread: set-up only (create, destroy); a finished net is read-only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "rt/arena.h"
#include "rt/real.h"
#include "softsim/types.h"

enum { SS_CHAIN_LANES = 8, SS_CHAIN_WINDOW = 32 };

/* Links a -> b side by side, arrays of structures of arrays: 256 bytes in single precision. Lanes
 * that are no link join a node that does not exist (node_count) with itself and are always slack.
 */
typedef struct ss_chain_group {
    int32_t a[SS_CHAIN_LANES], b[SS_CHAIN_LANES];                    /* node times 4 */
    ss_real x[SS_CHAIN_LANES], y[SS_CHAIN_LANES], z[SS_CHAIN_LANES]; /* rest vector, m */
    ss_real rest[SS_CHAIN_LANES];                                    /* its length l0, m */
    ss_real slack[SS_CHAIN_LANES];                                   /* alpha l0, m */
    ss_real half[SS_CHAIN_LANES];                                    /* w / 2 */
} ss_chain_group;

typedef struct ss_chain_net {
    int32_t node_count;
    int32_t link_count;
    int32_t (*link)[2]; /* a < b, by a, then b */
    int32_t duplicates; /* edges that an element shares with one before it */
    int32_t degenerate; /* links of no length, left out */
    double mean_length, least_length, largest_length; /* m, at rest */
    int32_t group_count;
    ss_chain_group *group; /* alpha 0, w 1 until they are set */
    int32_t *position;     /* of a link: group x SS_CHAIN_LANES + lane */
    /* Links of node i: positions at[first[i]] to at[first[i + 1] - 1]. */
    int32_t *first, *at;
} ss_chain_net;

/* SOFTSIM_ERROR_MESH (said in `error` under the model's `name`) when there is no link at all. */
softsim_status ss_chain_net_create(const ss_mesh *mesh, const char *name, ss_arena *arena,
                                   ss_chain_net **out_net, softsim_error *error);
int64_t ss_chain_net_bytes(const ss_chain_net *net);

/* The other end of the link at `position` of `node`, and one of its values. */
static inline int32_t ss_chain_other(const ss_chain_net *net, int32_t position, int32_t node)
{
    const ss_chain_group *group = &net->group[position / SS_CHAIN_LANES];
    const int lane = position % SS_CHAIN_LANES;
    return (group->a[lane] == 4 * node ? group->b[lane] : group->a[lane]) / 4;
}
