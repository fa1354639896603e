/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The surface that is remeshed: its arrays, who borders on whom, and a copy to go back to. */
#include "mesh/remesher.h"

#include <string.h>

#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- arrays ---- */

bool ss_remesher_init(ss_remesher *r, int32_t node_count, int32_t triangle_count)
{
    const size_t nodes = (size_t)node_count, triangles = (size_t)triangle_count;
    r->node_count = r->node_room = node_count;
    r->triangle_count = r->triangle_room = triangle_count;
    r->x = ss_memory_get(nodes, sizeof *r->x);
    r->groups = ss_memory_get(nodes, sizeof *r->groups);
    r->is_locked = ss_memory_get(nodes, sizeof *r->is_locked);
    r->corner = ss_memory_get(nodes, sizeof *r->corner);
    r->triangle = ss_memory_get(triangles, sizeof *r->triangle);
    r->mate = ss_memory_get(triangles, 3 * sizeof *r->mate);
    r->is_feature = ss_memory_get(triangles, 3 * sizeof *r->is_feature);
    return r->x != NULL && r->groups != NULL && r->is_locked != NULL && r->corner != NULL &&
           r->triangle != NULL && r->mate != NULL && r->is_feature != NULL;
}

static void free_arrays(ss_remesher *r)
{
    SS_EACH(ss_memory_free, r->x, r->groups, r->is_locked, r->corner, r->triangle, r->mate,
            r->is_feature);
}

void ss_remesher_fini(ss_remesher *r)
{
    free_arrays(r);
    ss_tree_fini(&r->tree);
}

bool ss_remesher_copy(const ss_remesher *from, ss_remesher *to)
{
    const size_t nodes = (size_t)from->node_count, triangles = (size_t)from->triangle_count;
    free_arrays(to);
    if (!ss_remesher_init(to, from->node_count, from->triangle_count)) {
        return false;
    }
    memcpy(to->x, from->x, nodes * sizeof *to->x);
    memcpy(to->groups, from->groups, nodes * sizeof *to->groups);
    memcpy(to->is_locked, from->is_locked, nodes * sizeof *to->is_locked);
    memcpy(to->corner, from->corner, nodes * sizeof *to->corner);
    memcpy(to->triangle, from->triangle, triangles * sizeof *to->triangle);
    memcpy(to->mate, from->mate, triangles * 3 * sizeof *to->mate);
    memcpy(to->is_feature, from->is_feature, triangles * 3 * sizeof *to->is_feature);
    return true;
}

static bool grow(void *array, int32_t count, int32_t room, size_t size)
{
    void **at = array;
    void *larger = ss_memory_get((size_t)room, size);
    if (larger != NULL) {
        if (count > 0) {
            memcpy(larger, *at, (size_t)count * size);
        }
        ss_memory_free(*at);
        *at = larger;
    }
    return larger != NULL;
}

bool ss_remesher_make_room(ss_remesher *r)
{
    if (r->node_count + 1 > r->node_room) {
        const int32_t room = 2 * r->node_room + 64, n = r->node_count;
        if (!grow(&r->x, n, room, sizeof *r->x) || !grow(&r->groups, n, room, sizeof *r->groups) ||
            !grow(&r->is_locked, n, room, sizeof *r->is_locked) ||
            !grow(&r->corner, n, room, sizeof *r->corner)) {
            return false;
        }
        r->node_room = room;
    }
    if (r->triangle_count + 2 > r->triangle_room) {
        const int32_t room = 2 * r->triangle_room + 64, n = r->triangle_count;
        if (!grow(&r->triangle, n, room, sizeof *r->triangle) ||
            !grow(&r->mate, n, room, 3 * sizeof *r->mate) ||
            !grow(&r->is_feature, n, room, 3 * sizeof *r->is_feature)) {
            return false;
        }
        r->triangle_room = room;
    }
    return true;
}

/* ---- neighbours ---- */

void ss_remesher_join(ss_remesher *r, int32_t a, int32_t b)
{
    if (a >= 0) {
        r->mate[a] = b;
    }
    if (b >= 0) {
        r->mate[b] = a;
    }
}

double ss_remesher_length(const ss_remesher *r, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, r->x[a], r->x[b]);
    return ss_norm3(d);
}

bool ss_remesher_rebuild(ss_remesher *r)
{
    int32_t *number = ss_memory_get((size_t)r->node_count, sizeof *number);
    if (number == NULL) {
        return false;
    }
    int32_t kept = 0;
    for (int32_t t = 0; t < r->triangle_count; ++t) {
        if (r->triangle[t][0] >= 0) {
            memmove(r->triangle[kept], r->triangle[t], sizeof r->triangle[0]);
            memmove(r->is_feature + 3 * kept, r->is_feature + 3 * t, 3 * sizeof *r->is_feature);
            for (int k = 0; k < 3; ++k) {
                number[r->triangle[kept][k]] = 1;
            }
            ++kept;
        }
    }
    r->triangle_count = kept;
    int32_t nodes = 0;
    for (int32_t i = 0; i < r->node_count; ++i) {
        if (number[i] != 0) {
            ss_copy3(r->x[nodes], r->x[i]);
            r->groups[nodes] = r->groups[i];
            r->is_locked[nodes] = r->is_locked[i];
            number[i] = nodes++;
        }
    }
    r->node_count = nodes;
    for (int32_t id = 0; id < 3 * kept; ++id) {
        int32_t *node = &r->triangle[id / 3][id % 3];
        *node = number[*node];
        r->corner[*node] = id;
        r->mate[id] = -1;
    }
    ss_memory_free(number);
    const ss_mesh view = {
        .node_count = nodes, .position = r->x, .triangle_count = kept, .triangle = r->triangle};
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(&view, &edges)) {
        return false;
    }
    for (int64_t i = 0; i + 1 < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        if (end - i == 2) {
            ss_remesher_join(r, edges.tuple[i].id, edges.tuple[i + 1].id);
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}

static void note_feature(ss_ring *g, int32_t end)
{
    if (g->features < 2) {
        g->feature[g->features] = end;
    }
    ++g->features;
}

bool ss_remesher_gather(const ss_remesher *r, int32_t node, ss_ring *g)
{
    int32_t first = r->corner[node];
    bool is_whole = false;
    g->count = g->features = 0;
    g->is_open = false;
    for (int k = 0; k < SS_REMESH_MAX_RING && !is_whole; ++k) {
        if (r->mate[first] < 0) {
            g->is_open = is_whole = true;
        } else {
            first = ss_next_side(r->mate[first]);
            is_whole = first == r->corner[node];
        }
    }
    for (int32_t at = first; is_whole && g->count < SS_REMESH_MAX_RING;) {
        g->side[g->count++] = at;
        if (r->is_feature[at]) {
            note_feature(g, ss_end_of(r, at));
        }
        const int32_t before = ss_last_side(at);
        if (r->mate[before] < 0) {
            if (r->is_feature[before]) {
                note_feature(g, ss_start_of(r, before));
            }
            return true;
        }
        at = r->mate[before];
        if (at == first) {
            return true;
        }
    }
    return false;
}
