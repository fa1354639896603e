/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Numbers by place: neighbours in space are near in memory, whatever order a file has.
 *
 * Nodes are sorted along a Hilbert curve through the box, elements by their lowest nodes; nodes
 * of a skin, that is of no tetrahedron, come after all others, so that nobody who works on the
 * volume reads past them. Measured by the nodes outside a block of 64 consecutive ones that are
 * joined to it (what a block's kernels read from elsewhere), on average over the blocks, beside the
 * order of the file, a Morton curve and reverse Cuthill-McKee:
 *
 *   mesh                                 file  Hilbert  Morton   RCM
 *   cylinder, 360 nodes, grid              41       32      32    50
 *   ellipsoid, 20,000 nodes, surface        -       52      53   139
 *   ellipsoid, 1177 nodes, tetrahedra     360      104     102   158
 *
 * RCM has the least bandwidth but its blocks are long strips; Morton is as good on average, with
 * worse worst blocks (135 for 95 on the ellipsoid), as its curve jumps. On a scattered surface of
 * 100,000 nodes a step of cnn-energy takes 27 ms for 43 in the file's order; at 20,000, which a
 * cache holds, the difference is within the noise.
 */
#include "mesh/mesh.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

#include <stdlib.h>
#include <string.h>

/* ---- the curve ---- */

/* Skilling 2004: Gray code by undoing the rotations and reflections from the top bit down, then
 * the bits interleaved. */
static uint64_t curve_place(const double x[3], const double low[3], double size)
{
    enum { ORDER = 21 };
    const double cells = (double)(1 << ORDER);
    uint32_t cell[3];
    for (int k = 0; k < 3; ++k) {
        cell[k] = (uint32_t)fmin(cells - 1.0, (x[k] - low[k]) / size * cells);
    }
    for (uint32_t bit = 1u << (ORDER - 1); bit > 1; bit >>= 1) {
        const uint32_t below = bit - 1;
        for (int k = 0; k < 3; ++k) {
            if ((cell[k] & bit) != 0) {
                cell[0] ^= below;
            } else {
                const uint32_t swap = (cell[0] ^ cell[k]) & below;
                cell[0] ^= swap;
                cell[k] ^= swap;
            }
        }
    }
    cell[1] ^= cell[0];
    cell[2] ^= cell[1];
    uint32_t reflect = 0;
    for (uint32_t bit = 1u << (ORDER - 1); bit > 1; bit >>= 1) {
        reflect ^= (cell[2] & bit) != 0 ? bit - 1 : 0;
    }
    uint64_t key = 0;
    for (int b = ORDER - 1; b >= 0; --b) {
        for (int k = 0; k < 3; ++k) {
            key = key << 1 | ((cell[k] ^ reflect) >> b & 1u);
        }
    }
    return key;
}

/* What is sorted: by key, then by the file's number. */
typedef struct place {
    uint64_t key[2];
    int32_t number;
} place;

static int compare_places(const void *left, const void *right)
{
    const place *a = left, *b = right;
    const int by_key =
        ss_order_then(ss_order_bits(a->key[0], b->key[0]), ss_order_bits(a->key[1], b->key[1]));
    return ss_order_then(by_key, ss_order_int(a->number, b->number));
}

bool ss_mesh_curve_order(int32_t count, const double (*x)[3], double size, int32_t *out_number)
{
    double low[3], high[3];
    place *order = ss_memory_get((size_t)count, sizeof *order);
    if (order == NULL) {
        return false;
    }
    ss_bounds3(count, x, low, high);
    for (int32_t i = 0; i < count; ++i) {
        order[i] = (place){.key = {curve_place(x[i], low, size)}, .number = i};
    }
    qsort(order, (size_t)count, sizeof *order, compare_places);
    for (int32_t i = 0; i < count; ++i) {
        out_number[i] = order[i].number;
    }
    ss_memory_free(order);
    return true;
}

static void place_nodes(const ss_mesh *mesh, place *out)
{
    double low[3], high[3];
    ss_bounds3(mesh->node_count, (const double(*)[3])mesh->position, low, high);
    const double size = fmax(high[0] - low[0], fmax(high[1] - low[1], high[2] - low[2]));
    const uint64_t apart = mesh->tetrahedron_count > 0 ? UINT64_C(1) << 63 : 0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        out[i] = (place){.number = i};
        out[i].key[0] = size > 0.0 ? curve_place(mesh->position[i], low, size) : 0;
        out[i].key[0] |= apart; /* above the curve's 63 bits */
    }
    for (int32_t c = 0; c < 4 * mesh->tetrahedron_count; ++c) {
        out[mesh->tetrahedron[c / 4][c % 4]].key[0] &= ~apart;
    }
    for (int64_t s = 0; mesh->middle != NULL && s < 6 * (int64_t)mesh->tetrahedron_count; ++s) {
        out[mesh->middle[s / 6][s % 6]].key[0] &= ~apart;
    }
    qsort(out, (size_t)mesh->node_count, sizeof *out, compare_places);
}

/* ---- elements ---- */

/* Gives elements of `size` nodes their new numbers and sorts them by their nodes, lowest first.
 * `order` has room for `count`: where each element was. */
static void sort_elements(int32_t *element, int32_t count, int size, const int32_t *new_number,
                          place *order, int32_t *scratch)
{
    for (int32_t e = 0; e < count; ++e) {
        int32_t low[2] = {INT32_MAX, INT32_MAX};
        uint64_t sum = 0;
        for (int k = 0; k < size; ++k) {
            int32_t *node = &element[(int64_t)size * e + k];
            *node = new_number[*node];
            sum += (uint64_t)*node;
            low[1] = *node < low[0] ? low[0] : *node < low[1] ? *node : low[1];
            low[0] = *node < low[0] ? *node : low[0];
        }
        order[e] = (place){.number = e};
        order[e].key[0] = (uint64_t)low[0] << 32 | (uint64_t)low[1];
        order[e].key[1] = sum;
    }
    qsort(order, (size_t)count, sizeof *order, compare_places);
    const size_t bytes = (size_t)size * sizeof *element;
    memcpy(scratch, element, (size_t)count * bytes);
    for (int32_t e = 0; e < count; ++e) {
        memcpy(element + (int64_t)size * e, scratch + (int64_t)size * order[e].number, bytes);
    }
}

/* The triangles of quads follow them. */
static void sort_halves(ss_mesh *mesh, const int32_t *new_number, const place *order,
                        int32_t *scratch)
{
    const size_t bytes = 2 * sizeof *mesh->triangle;
    memcpy(scratch, mesh->triangle, (size_t)mesh->triangle_count * sizeof *mesh->triangle);
    for (int32_t q = 0; q < mesh->quad_count; ++q) {
        int32_t *half = mesh->triangle[2 * (int64_t)q];
        memcpy(half, scratch + 6 * (int64_t)order[q].number, bytes);
        for (int k = 0; k < 6; ++k) {
            half[k] = new_number[half[k]];
        }
    }
}

/* Mid-edge nodes follow their tetrahedra. */
static void sort_middles(ss_mesh *mesh, const int32_t *new_number, const place *order,
                         int32_t *scratch)
{
    const size_t bytes = (size_t)mesh->tetrahedron_count * sizeof *mesh->middle;
    memcpy(scratch, mesh->middle, bytes);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        for (int s = 0; s < 6; ++s) {
            mesh->middle[e][s] = new_number[scratch[6 * (int64_t)order[e].number + s]];
        }
    }
}

static void renumber_groups(ss_mesh *mesh, const int32_t *new_number)
{
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        ss_mesh_group *group = &mesh->group[g];
        for (int32_t i = 0; i < group->node_count; ++i) {
            group->node[i] = new_number[group->node[i]];
        }
        qsort(group->node, (size_t)group->node_count, sizeof *group->node, ss_compare_ints);
    }
}

/* ---- all of it ---- */

/* Numbers of an order, or NULL in *out where each is its own. */
static bool keep_order(const place *order, int32_t count, int32_t **out)
{
    bool is_same = true;
    for (int32_t i = 0; i < count; ++i) {
        is_same = is_same && order[i].number == i;
    }
    *out = is_same ? NULL : ss_memory_get((size_t)count, sizeof **out);
    for (int32_t i = 0; i < count && *out != NULL; ++i) {
        (*out)[i] = order[i].number;
    }
    return is_same || *out != NULL;
}

/* Everything but the nodes' positions, once room is certain: from here nothing fails but the last
 * list. */
static bool renumber_elements(ss_mesh *mesh, const int32_t *new_number, place *order,
                              int32_t *scratch)
{
    if (mesh->tetrahedron_count > 0) {
        /* Quarters of a face stay together. */
        const int32_t parts = mesh->middle != NULL ? 4 : 1;
        sort_elements((int32_t *)mesh->triangle, mesh->triangle_count / parts, 3 * parts,
                      new_number, order, scratch);
        sort_elements((int32_t *)mesh->tetrahedron, mesh->tetrahedron_count, 4, new_number, order,
                      scratch);
        if (mesh->middle != NULL) {
            sort_middles(mesh, new_number, order, scratch);
        }
    } else if (mesh->quad_count > 0) {
        sort_elements((int32_t *)mesh->quad, mesh->quad_count, 4, new_number, order, scratch);
        sort_halves(mesh, new_number, order, scratch);
    } else {
        sort_elements((int32_t *)mesh->triangle, mesh->triangle_count, 3, new_number, order,
                      scratch);
    }
    renumber_groups(mesh, new_number);
    return keep_order(order, ss_mesh_element_count(mesh), &mesh->file_element);
}

bool ss_mesh_renumber(ss_mesh *mesh)
{
    const size_t nodes = (size_t)mesh->node_count;
    const size_t triangles = (size_t)mesh->triangle_count;
    const size_t tetrahedra = (size_t)mesh->tetrahedron_count;
    const size_t most = triangles > tetrahedra ? triangles : tetrahedra;
    place *node_order = ss_memory_get(nodes, sizeof *node_order);
    place *order = ss_memory_get(most, sizeof *order);
    int32_t *scratch = ss_memory_get(most, (mesh->middle != NULL ? 6 : 4) * sizeof *scratch);
    int32_t *new_number = ss_memory_get(nodes, sizeof *new_number);
    double(*position)[3] = ss_memory_get(nodes, sizeof *position);
    bool is_done = node_order && order && scratch && new_number && position;
    if (is_done) {
        place_nodes(mesh, node_order);
        is_done = keep_order(node_order, mesh->node_count, &mesh->file_node);
    }
    if (is_done) {
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            new_number[node_order[i].number] = i;
            ss_copy3(position[i], mesh->position[node_order[i].number]);
        }
        memcpy(mesh->position, position, nodes * sizeof *position);
        is_done = renumber_elements(mesh, new_number, order, scratch);
    }
    SS_EACH(ss_memory_free, node_order, order, scratch, new_number, position);
    return is_done;
}
