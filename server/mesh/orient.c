/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Winding. A flood over shared edges gives every triangle of a part the sense of its first one;
 * then closed parts that enclose a negative volume, and are no cavity, are turned whole, and with
 * each the closed parts within its box, so that cavities stay such and bodies too. An open
 * part keeps the sense that most of its triangles had. Edges of more than two triangles join
 * nothing: no sense is right there. A one-sided (Moebius) part keeps a seam, which ss_mesh_check
 * names. Quads are turned whole: their halves are neighbours across the diagonal, whatever else
 * has that edge.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"

#include <string.h>

typedef struct orienter {
    ss_mesh_tuples edges;
    int32_t (*neighbour)[3]; /* across the edge of corner c: half-edge 3 t + c, or -1 */
    int32_t *queue;
    int32_t *patch; /* flood patch of each triangle, -1: not reached */
    uint8_t *is_turned;
    int32_t *part;
    ss_mesh_part *parts;
    bool *is_inside_out, *is_taken;
} orienter;

static void orienter_fini(orienter *o)
{
    ss_mesh_tuples_fini(&o->edges);
    SS_EACH(ss_memory_free, o->neighbour, o->queue, o->patch, o->is_turned, o->part, o->parts,
            o->is_inside_out, o->is_taken);
}

static bool orienter_init(orienter *o, const ss_mesh *mesh)
{
    const size_t count = (size_t)mesh->triangle_count;
    *o = (orienter){0};
    o->neighbour = ss_memory_get(count, sizeof *o->neighbour);
    o->queue = ss_memory_get(count, sizeof *o->queue);
    o->patch = ss_memory_get(count, sizeof *o->patch);
    o->is_turned = ss_memory_get(count, sizeof *o->is_turned);
    o->part = ss_memory_get((size_t)mesh->node_count, sizeof *o->part);
    if (o->neighbour == NULL || o->queue == NULL || o->patch == NULL || o->is_turned == NULL ||
        o->part == NULL || !ss_mesh_list_triangle_edges(mesh, &o->edges)) {
        return false;
    }
    memset(o->neighbour, 0xff, count * sizeof *o->neighbour);
    memset(o->patch, 0xff, count * sizeof *o->patch);
    for (int64_t i = 0; i < o->edges.count;) {
        const int64_t end = ss_mesh_run_end(&o->edges, i);
        if (end - i == 2) {
            const int32_t a = o->edges.tuple[i].id;
            const int32_t b = o->edges.tuple[i + 1].id;
            o->neighbour[a / 3][a % 3] = b;
            o->neighbour[b / 3][b % 3] = a;
        }
        i = end;
    }
    for (int32_t t = 0; t + 1 < mesh->triangle_count && mesh->quad_count > 0; t += 2) {
        /* (p0, p1, p2) and (p2, p3, p0): the diagonal is the last edge of both. */
        o->neighbour[t][2] = 3 * (t + 1) + 2;
        o->neighbour[t + 1][2] = 3 * t + 2;
    }
    return true;
}

/* Floods from `seed`; the smaller of the two sides is turned. */
static void flood(orienter *o, const ss_mesh *mesh, int32_t seed)
{
    int32_t count = 1;
    int32_t turned = 0;
    o->queue[0] = seed;
    o->patch[seed] = seed;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t t = o->queue[i];
        turned += o->is_turned[t];
        for (int32_t c = 0; c < 3; ++c) {
            const int32_t other = o->neighbour[t][c];
            if (other < 0 || o->patch[other / 3] >= 0) {
                continue;
            }
            const bool is_against = ss_mesh_edge_is_ascending(mesh, 3 * t + c) ==
                                    ss_mesh_edge_is_ascending(mesh, other);
            o->is_turned[other / 3] = o->is_turned[t] != (uint8_t)is_against;
            o->patch[other / 3] = seed;
            o->queue[count++] = other / 3;
        }
    }
    for (int32_t i = 0; i < count && 2 * (int64_t)turned > count; ++i) {
        o->is_turned[o->queue[i]] = !o->is_turned[o->queue[i]];
    }
}

/* A quad is turned with its first half. */
static void turn(ss_mesh *mesh, int32_t t)
{
    if (mesh->quad_count > 0) {
        if (t % 2 == 0) {
            ss_mesh_turn_quad(mesh, t / 2);
        }
        return;
    }
    int32_t *node = mesh->triangle[t];
    const int32_t second = node[1];
    node[1] = node[2];
    node[2] = second;
}

/* Closed parts within one that is inside out are turned with it. */
static void take_along(orienter *o, int32_t count)
{
    for (int32_t p = 0; p < count && count <= SS_MESH_MAX_PARTS; ++p) {
        bool is_within = false;
        for (int32_t i = 0; i < count && !o->parts[p].is_open && !o->is_inside_out[p]; ++i) {
            is_within = is_within ||
                        (o->is_inside_out[i] && ss_mesh_part_is_within(&o->parts[p], &o->parts[i]));
        }
        o->is_taken[p] = is_within;
    }
    for (int32_t p = 0; p < count; ++p) {
        o->is_inside_out[p] = o->is_inside_out[p] || o->is_taken[p];
    }
}

/* Turns the closed parts that are inside out; updates is_turned. */
static bool turn_parts(orienter *o, ss_mesh *mesh)
{
    const int32_t count = ss_mesh_find_parts(mesh, false, o->part);
    if (count < 0) {
        return false;
    }
    o->parts = ss_memory_get((size_t)count, sizeof *o->parts);
    o->is_inside_out = ss_memory_get((size_t)count, sizeof *o->is_inside_out);
    o->is_taken = ss_memory_get((size_t)count, sizeof *o->is_taken);
    if (o->parts == NULL || o->is_inside_out == NULL || o->is_taken == NULL) {
        return false;
    }
    if (ss_mesh_measure_parts(mesh, o->part, count, &o->edges, o->parts, o->is_inside_out)) {
        take_along(o, count);
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            const int32_t *node = mesh->triangle[t];
            if (ss_mesh_has_good_nodes(mesh, node, 3) && o->is_inside_out[o->part[node[0]]]) {
                turn(mesh, t);
                o->is_turned[t] = !o->is_turned[t];
            }
        }
    }
    return true;
}

int32_t ss_mesh_orient(ss_mesh *mesh)
{
    orienter o;
    int32_t turned = -1;
    if (orienter_init(&o, mesh)) {
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            if (o.patch[t] < 0) {
                flood(&o, mesh, t);
            }
        }
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            if (o.is_turned[t]) {
                turn(mesh, t);
            }
        }
        if (turn_parts(&o, mesh)) {
            turned = 0;
            for (int32_t t = 0; t < mesh->triangle_count; ++t) {
                turned += o.is_turned[mesh->quad_count > 0 ? t - t % 2 : t];
            }
        }
    }
    orienter_fini(&o);
    return turned;
}
