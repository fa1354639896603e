/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/network.h"
/*
 * The network as rows of a symmetric sparse product, for the kernels: of the cells that may move,
 * and of those held at zero.
 */
#include "rt/memory.h"

static int32_t *node_degrees(const ss_cnn_network *network)
{
    int32_t *degree = ss_memory_get((size_t)network->node_count, sizeof *degree);
    for (int32_t e = 0; degree && e < network->edges.count; ++e) {
        ++degree[network->edges.from[e] / 4];
        ++degree[network->edges.to[e] / 4];
    }
    return degree;
}

static softsim_status allocate_rows(ss_cnn_rows *rows, int32_t row_count, int32_t entry_count,
                                    int32_t group_count, ss_arena *arena)
{
    const size_t entries = (size_t)entry_count;
    rows->row_count = row_count;
    rows->entry_count = entry_count;
    rows->group_count = 0;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)group_count, rows->group),
                  SS_ROOM((size_t)rows->block_count + 1, rows->block_group),
                  SS_ROOM((size_t)row_count, rows->node), SS_ROOM(entries, rows->neighbour),
                  SS_ROOM(entries, rows->edge), SS_ROOM(entries * 4, rows->arm));
    return ss_arena_status(arena);
}

/* Blocks of consecutive nodes where the body is large enough for a part of it to be worth having.
 * 64 nodes: the rim of an active set costs half as much as with 256, and a branch that mispredicts
 * at each group of rows is still spread over ten and more. */
static void set_blocks(int32_t node_count, ss_cnn_rows *rows)
{
    rows->block_size = node_count;
    rows->block_count = 1;
    if (node_count >= SS_CNN_LARGE_BODY) {
        rows->block_size = 64;
        rows->block_count = (node_count + 63) / 64;
    }
}

/* The wanted nodes of `first` to `end`, in groups of equal degree; cursor[i] becomes the first
 * entry of node i. */
static void group_nodes(ss_cnn_rows *rows, int32_t first, int32_t end, const int32_t *degree,
                        int32_t max_degree, int32_t *cursor, int32_t *row, int32_t *entry)
{
    for (int32_t d = 1; d <= max_degree; ++d) {
        ss_cnn_group group = {.degree = d, .first_row = *row, .first_entry = *entry};
        for (int32_t i = first; i < end; ++i) {
            if (cursor[i] >= 0 && degree[i] == d) {
                rows->node[(*row)++] = 4 * i;
                cursor[i] = *entry;
                *entry += d;
            }
        }
        group.row_count = *row - group.first_row;
        if (group.row_count > 0) {
            rows->group[rows->group_count++] = group;
        }
    }
}

/* Rows of the cells with held[i] == wanted: block by block in groups of equal degree, in node order
 * within. */
softsim_status ss_cnn_network_build_rows(ss_cnn_network *network, const uint8_t *held, bool wanted,
                                         ss_cnn_rows *rows)
{
    const ss_cnn_edges *edges = &network->edges;
    int32_t *degree = node_degrees(network);
    int32_t *cursor = ss_memory_get((size_t)network->node_count, sizeof *cursor);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (!degree || !cursor) {
        goto done;
    }
    int32_t row_count = 0, entry_count = 0, max_degree = 0;
    for (int32_t i = 0; i < network->node_count; ++i) {
        const bool is_row = (held[i] != 0) == wanted && degree[i] > 0;
        cursor[i] = is_row ? 0 : -1;
        row_count += is_row;
        entry_count += is_row ? degree[i] : 0;
        max_degree = is_row && degree[i] > max_degree ? degree[i] : max_degree;
    }
    set_blocks(network->node_count, rows);
    /* No block has more groups than rows, or than degrees. */
    const int64_t most = (int64_t)max_degree * rows->block_count;
    status = allocate_rows(rows, row_count, entry_count,
                           most < row_count ? (int32_t)most : row_count, &network->arena);
    if (status != SOFTSIM_OK) {
        goto done;
    }
    int32_t row = 0, entry = 0;
    for (int32_t block = 0; block < rows->block_count; ++block) {
        const int32_t first = block * rows->block_size, end = first + rows->block_size;
        group_nodes(rows, first, end < network->node_count ? end : network->node_count, degree,
                    max_degree, cursor, &row, &entry);
        rows->block_group[block + 1] = rows->group_count;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        for (int side = 0; side < 2; ++side) {
            const int32_t i = (side == 0 ? edges->from[e] : edges->to[e]) / 4;
            if (cursor[i] < 0) {
                continue;
            }
            const int32_t at = cursor[i]++;
            const ss_real sign = side == 0 ? (ss_real)-1 : (ss_real)1;
            rows->neighbour[at] = side == 0 ? edges->to[e] : edges->from[e];
            rows->edge[at] = e;
            rows->arm[4 * at] = sign * edges->x[e];
            rows->arm[4 * at + 1] = sign * edges->y[e];
            rows->arm[4 * at + 2] = sign * edges->z[e];
            rows->arm[4 * at + 3] = 1;
        }
    }
done:
    ss_memory_free(degree);
    ss_memory_free(cursor);
    return status;
}
