/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/net.h"
/*
 * Links from elements: by lower node in lists, each sorted and freed of duplicates. Rejected: one
 * sort of all edges (18 million keys for half a million nodes).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

/* ---- links ---- */

/* Corners of an element's edges. */
static const int8_t tetrahedron_edge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
static const int8_t quad_edge[4][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
static const int8_t triangle_edge[3][2] = {{0, 1}, {1, 2}, {2, 0}};

/* What the links are made from. */
typedef struct source {
    const int32_t *corner; /* of all elements, one after the other */
    int32_t element_count, corners, edges;
    const int8_t (*edge)[2];
} source;

static source find_source(const ss_mesh *mesh)
{
    if (mesh->tetrahedron_count > 0) {
        return (source){&mesh->tetrahedron[0][0], mesh->tetrahedron_count, 4, 6, tetrahedron_edge};
    }
    if (mesh->quad_count > 0) {
        return (source){&mesh->quad[0][0], mesh->quad_count, 4, 4, quad_edge};
    }
    return (source){mesh->triangle_count > 0 ? &mesh->triangle[0][0] : NULL, mesh->triangle_count,
                    3, 3, triangle_edge};
}

/* Lower and higher node of edge k of an element. */
static void edge_of(const source *from, int32_t element, int k, int32_t *low, int32_t *high)
{
    const int32_t *corner = from->corner + (ptrdiff_t)element * from->corners;
    const int32_t p = corner[from->edge[k][0]], q = corner[from->edge[k][1]];
    *low = p < q ? p : q;
    *high = p < q ? q : p;
}

static double length_of(const ss_mesh *mesh, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, mesh->position[b], mesh->position[a]);
    return ss_norm3(d);
}

/* Sorts the higher ends of each lower node and keeps one of each. */
static void keep_distinct(ss_chain_net *net, const ss_mesh *mesh, const int64_t *first,
                          int32_t *higher)
{
    for (int32_t i = 0; i < net->node_count; ++i) {
        const int64_t count = first[i + 1] - first[i];
        int32_t *list = higher + first[i];
        qsort(list, (size_t)count, sizeof *list, ss_compare_ints);
        for (int64_t k = 0; k < count; ++k) {
            if (k > 0 && list[k] == list[k - 1]) {
                ++net->duplicates;
            } else if (list[k] == i || !(length_of(mesh, i, list[k]) > 0.0)) {
                ++net->degenerate;
            } else {
                net->link[net->link_count][0] = i;
                net->link[net->link_count++][1] = list[k];
            }
        }
    }
}

static softsim_status find_links(ss_chain_net *net, const ss_mesh *mesh, ss_arena *arena)
{
    const source from = find_source(mesh);
    const int64_t total = (int64_t)from.element_count * from.edges;
    int64_t *first = ss_memory_get((size_t)net->node_count + 2, sizeof *first);
    int32_t *higher = ss_memory_get((size_t)total, sizeof *higher);
    net->link = ss_arena_get(arena, (size_t)total, sizeof *net->link);
    const bool is_good = first && higher && net->link && total < INT32_MAX / SS_CHAIN_LANES;
    if (is_good) {
        int32_t low, high;
        for (int32_t e = 0; e < from.element_count; ++e) {
            for (int k = 0; k < from.edges; ++k) {
                edge_of(&from, e, k, &low, &high);
                ++first[low + 2];
            }
        }
        for (int32_t i = 0; i <= net->node_count; ++i) {
            first[i + 1] += first[i];
        }
        for (int32_t e = 0; e < from.element_count; ++e) {
            for (int k = 0; k < from.edges; ++k) {
                edge_of(&from, e, k, &low, &high);
                higher[first[low + 1]++] = high;
            }
        }
        keep_distinct(net, mesh, first, higher);
    }
    ss_memory_free(first);
    ss_memory_free(higher);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* ---- groups ---- */

static void put_link(ss_chain_net *net, const ss_mesh *mesh, int32_t link, int32_t position)
{
    ss_chain_group *group = &net->group[position / SS_CHAIN_LANES];
    const int lane = position % SS_CHAIN_LANES;
    const int32_t a = net->link[link][0], b = net->link[link][1];
    double d[3];
    ss_sub3(d, mesh->position[b], mesh->position[a]);
    const double length = ss_norm3(d);
    group->a[lane] = 4 * a;
    group->b[lane] = 4 * b;
    group->x[lane] = (ss_real)d[0];
    group->y[lane] = (ss_real)d[1];
    group->z[lane] = (ss_real)d[2];
    group->rest[lane] = (ss_real)length;
    group->half[lane] = (ss_real)0.5;
    net->position[link] = position;
    net->mean_length += length / net->link_count;
    net->least_length = fmin(net->least_length, length);
    net->largest_length = fmax(net->largest_length, length);
}

static void put_nothing(ss_chain_net *net, int32_t position)
{
    ss_chain_group *group = &net->group[position / SS_CHAIN_LANES];
    const int lane = position % SS_CHAIN_LANES;
    group->a[lane] = group->b[lane] = 4 * net->node_count;
    group->x[lane] = group->rest[lane] = 1;
}

/* The links that are not placed yet, in order: next[0] is the first one's number + 1. */
static void build_groups(ss_chain_net *net, const ss_mesh *mesh, int32_t *next, int32_t *stamp)
{
    for (int32_t e = 0; e <= net->link_count; ++e) {
        next[e] = e < net->link_count ? e + 1 : 0;
    }
    for (int32_t g = 0; g < net->group_count; ++g) {
        int lanes = 0;
        for (int pass = 0; pass < 2; ++pass) { /* links apart, then any */
            int32_t *from = &next[0];
            for (int seen = 0; *from != 0 && lanes < SS_CHAIN_LANES && seen < SS_CHAIN_WINDOW;
                 ++seen) {
                const int32_t link = *from - 1;
                const int32_t a = net->link[link][0], b = net->link[link][1];
                if (pass == 1 || (stamp[a] != g + 1 && stamp[b] != g + 1)) {
                    stamp[a] = stamp[b] = g + 1;
                    put_link(net, mesh, link, g * SS_CHAIN_LANES + lanes++);
                    *from = next[*from];
                } else {
                    from = &next[*from];
                }
            }
        }
        while (lanes < SS_CHAIN_LANES) {
            put_nothing(net, g * SS_CHAIN_LANES + lanes++);
        }
    }
}

static void index_nodes(ss_chain_net *net)
{
    for (int32_t e = 0; e < net->link_count; ++e) {
        ++net->first[net->link[e][0] + 2];
        ++net->first[net->link[e][1] + 2];
    }
    for (int32_t i = 0; i <= net->node_count; ++i) {
        net->first[i + 1] += net->first[i];
    }
    for (int32_t e = 0; e < net->link_count; ++e) {
        for (int side = 0; side < 2; ++side) {
            net->at[net->first[net->link[e][side] + 1]++] = net->position[e];
        }
    }
}

static softsim_status group_links(ss_chain_net *net, const ss_mesh *mesh, ss_arena *arena)
{
    const size_t links = (size_t)net->link_count, nodes = (size_t)net->node_count;
    net->group_count = (net->link_count + SS_CHAIN_LANES - 1) / SS_CHAIN_LANES;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)net->group_count, net->group),
                  SS_ROOM(links, net->position), SS_ROOM(nodes + 2, net->first),
                  SS_ROOM(2 * links, net->at));
    int32_t *next = ss_memory_get(links + 1, sizeof *next);
    int32_t *stamp = ss_memory_get(nodes, sizeof *stamp);
    const bool is_good = ss_arena_status(arena) == SOFTSIM_OK && next && stamp;
    if (is_good) {
        net->least_length = (double)INFINITY;
        build_groups(net, mesh, next, stamp);
        index_nodes(net);
    }
    ss_memory_free(next);
    ss_memory_free(stamp);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* ---- life ---- */

softsim_status ss_chain_net_create(const ss_mesh *mesh, const char *name, ss_arena *arena,
                                   ss_chain_net **out_net, softsim_error *error)
{
    ss_chain_net *net = ss_arena_get(arena, 1, sizeof *net);
    *out_net = net;
    if (!net) {
        return SOFTSIM_ERROR_MEMORY;
    }
    net->node_count = mesh->node_count;
    softsim_status status = find_links(net, mesh, arena);
    if (status == SOFTSIM_OK && net->link_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s: the mesh has no edge of any length",
                          name);
        status = SOFTSIM_ERROR_MESH;
    }
    return status == SOFTSIM_OK ? group_links(net, mesh, arena) : status;
}

int64_t ss_chain_net_bytes(const ss_chain_net *net)
{
    return (int64_t)net->group_count * (int64_t)sizeof *net->group +
           (int64_t)net->link_count * (int64_t)(sizeof *net->link + 3 * sizeof(int32_t));
}
