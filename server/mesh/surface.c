/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The surface of a volume: the faces that exactly one tetrahedron has, in the file's order.
 *
 * The numbers of all faces (4 e + corner) are put into buckets by their lowest node, in one
 * counting pass; the faces of a bucket, some twenty on a real mesh, are then sorted by their other
 * two nodes and the single ones marked. That takes five bytes a face beside the mesh. Sorting
 * tuples of all faces at once, as the checks do, takes forty: more than the mesh itself.
 */
#include "mesh/second_order.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

typedef struct face {
    int32_t middle, highest; /* nodes */
    int32_t id;
} face;

typedef struct extractor {
    const ss_mesh *mesh;
    int32_t *start;   /* of each node's bucket, and the end of the last */
    int32_t *id;      /* of faces, by buckets */
    face *bucket;     /* room for the largest */
    bool *is_surface; /* by face */
} extractor;

static void extractor_fini(extractor *x)
{
    SS_EACH(ss_memory_free, x->start, x->id, x->bucket, x->is_surface);
}

static void get_face(const ss_mesh *mesh, int32_t id, int32_t out[3])
{
    const int32_t *node = mesh->tetrahedron[id / 4];
    const int8_t *corner = ss_mesh_tetrahedron_face[id % 4];
    for (int k = 0; k < 3; ++k) {
        out[k] = node[corner[k]];
    }
}

static int32_t lowest_node(const ss_mesh *mesh, int32_t id)
{
    int32_t node[3];
    get_face(mesh, id, node);
    const int32_t low = node[0] < node[1] ? node[0] : node[1];
    return low < node[2] ? low : node[2];
}

static bool fill_buckets(extractor *x)
{
    const ss_mesh *mesh = x->mesh;
    const size_t faces = 4 * (size_t)mesh->tetrahedron_count;
    x->start = ss_memory_get((size_t)mesh->node_count + 2, sizeof *x->start);
    x->id = ss_memory_get(faces, sizeof *x->id);
    x->is_surface = ss_memory_get(faces, sizeof *x->is_surface);
    if (x->start == NULL || x->id == NULL || x->is_surface == NULL) {
        return false;
    }
    /* Counts two places on; sums one place on; filling moves each start to its place. */
    int32_t largest = 0;
    for (int32_t id = 0; id < (int32_t)faces; ++id) {
        if (ss_mesh_has_good_nodes(mesh, mesh->tetrahedron[id / 4], 4)) {
            const int32_t count = ++x->start[lowest_node(mesh, id) + 2];
            largest = count > largest ? count : largest;
        }
    }
    for (int32_t n = 0; n < mesh->node_count; ++n) {
        x->start[n + 2] += x->start[n + 1];
    }
    for (int32_t id = 0; id < (int32_t)faces; ++id) {
        if (ss_mesh_has_good_nodes(mesh, mesh->tetrahedron[id / 4], 4)) {
            x->id[x->start[lowest_node(mesh, id) + 1]++] = id;
        }
    }
    x->bucket = ss_memory_get((size_t)largest, sizeof *x->bucket);
    return x->bucket != NULL;
}

static int compare_faces(const void *left, const void *right)
{
    const face *a = left, *b = right;
    return ss_order_then(ss_order_int(a->middle, b->middle), ss_order_int(a->highest, b->highest));
}

enum { MAX_INSERTION = 48 }; /* larger buckets go to qsort */

static void sort_bucket(face *bucket, int32_t count)
{
    if (count > MAX_INSERTION) {
        qsort(bucket, (size_t)count, sizeof *bucket, compare_faces);
        return;
    }
    for (int32_t i = 1; i < count; ++i) {
        const face moved = bucket[i];
        int32_t k = i;
        for (; k > 0 && compare_faces(&bucket[k - 1], &moved) > 0; --k) {
            bucket[k] = bucket[k - 1];
        }
        bucket[k] = moved;
    }
}

/* Marks the single faces of a node's bucket; returns their number. */
static int32_t mark_bucket(extractor *x, int32_t node)
{
    const int32_t count = x->start[node + 1] - x->start[node];
    for (int32_t i = 0; i < count; ++i) {
        int32_t corner[3];
        face *f = &x->bucket[i];
        f->id = x->id[x->start[node] + i];
        get_face(x->mesh, f->id, corner);
        const int32_t a = corner[0] == node ? corner[1] : corner[0];
        const int32_t b = corner[2] == node ? corner[1] : corner[2];
        f->middle = a < b ? a : b;
        f->highest = a < b ? b : a;
    }
    sort_bucket(x->bucket, count);
    int32_t single = 0;
    for (int32_t i = 0; i < count; ++i) {
        const bool as_before = i > 0 && compare_faces(&x->bucket[i - 1], &x->bucket[i]) == 0;
        const bool as_after = i + 1 < count && compare_faces(&x->bucket[i], &x->bucket[i + 1]) == 0;
        if (!as_before && !as_after) {
            x->is_surface[x->bucket[i].id] = true;
            ++single;
        }
    }
    return single;
}

static double six_volumes(const ss_mesh *mesh, const int32_t *node)
{
    return ss_six_volumes3(mesh->position[node[0]], mesh->position[node[1]],
                           mesh->position[node[2]], mesh->position[node[3]]);
}

/* The face of corners `node` of tetrahedron e in its four quarters. */
static void put_quarters(const ss_mesh *mesh, int32_t e, const int32_t node[3], int32_t (*out)[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k][0] = node[k];
        out[3][k] = mesh->middle[e][ss_mesh_find_edge(mesh, e, node[k], node[(k + 1) % 3])];
    }
    for (int k = 0; k < 3; ++k) {
        out[k][1] = out[3][k];
        out[k][2] = out[3][(k + 2) % 3];
    }
}

bool ss_mesh_extract_surface(ss_mesh *mesh)
{
    extractor x = {.mesh = mesh};
    if (!fill_buckets(&x)) {
        extractor_fini(&x);
        return false;
    }
    int32_t count = 0;
    for (int32_t n = 0; n < mesh->node_count; ++n) {
        count += mark_bucket(&x, n);
    }
    const int32_t parts = mesh->middle != NULL ? 4 : 1;
    mesh->triangle = ss_memory_get((size_t)parts * (size_t)count, sizeof *mesh->triangle);
    for (int32_t id = 0; mesh->triangle != NULL && id < 4 * mesh->tetrahedron_count; ++id) {
        if (x.is_surface[id]) {
            /* An inverted tetrahedron still has its outside outside. */
            int32_t node[3];
            get_face(mesh, id, node);
            const bool is_inverted = six_volumes(mesh, mesh->tetrahedron[id / 4]) < 0.0;
            const int32_t corner[3] = {node[0], node[is_inverted ? 2 : 1],
                                       node[is_inverted ? 1 : 2]};
            int32_t(*triangle)[3] = mesh->triangle + mesh->triangle_count;
            if (mesh->middle != NULL) {
                put_quarters(mesh, id / 4, corner, triangle);
            } else {
                memcpy(*triangle, corner, sizeof corner);
            }
            mesh->triangle_count += parts;
        }
    }
    extractor_fini(&x);
    return mesh->triangle != NULL;
}
