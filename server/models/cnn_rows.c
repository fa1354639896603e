/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_network.h"
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

static bool allocate_rows(ss_cnn_rows *rows, int32_t row_count, int32_t entry_count,
                          int32_t group_count)
{
    rows->row_count = row_count;
    rows->entry_count = entry_count;
    rows->group_count = 0;
    rows->group = ss_memory_get((size_t)group_count, sizeof *rows->group);
    rows->node = ss_memory_get((size_t)row_count, sizeof *rows->node);
    rows->neighbour = ss_memory_get((size_t)entry_count, sizeof *rows->neighbour);
    rows->edge = ss_memory_get((size_t)entry_count, sizeof *rows->edge);
    rows->arm = ss_memory_get((size_t)entry_count * 4, sizeof *rows->arm);
    return rows->group && rows->node && rows->neighbour && rows->edge && rows->arm;
}

/* Rows of the cells with held[i] == wanted, in groups of equal degree, in node order within. */
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
        cursor[i] = -1;
        if ((held[i] != 0) == wanted && degree[i] > 0) {
            ++row_count;
            entry_count += degree[i];
            max_degree = degree[i] > max_degree ? degree[i] : max_degree;
        }
    }
    if (!allocate_rows(rows, row_count, entry_count, max_degree + 1)) {
        goto done;
    }
    int32_t row = 0, entry = 0;
    for (int32_t d = 1; d <= max_degree; ++d) {
        ss_cnn_group group = {.degree = d, .first_row = row, .first_entry = entry};
        for (int32_t i = 0; i < network->node_count; ++i) {
            if ((held[i] != 0) == wanted && degree[i] == d) {
                rows->node[row++] = 4 * i;
                cursor[i] = entry;
                entry += d;
            }
        }
        group.row_count = row - group.first_row;
        if (group.row_count > 0) {
            rows->group[rows->group_count++] = group;
        }
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
    status = SOFTSIM_OK;
done:
    ss_memory_free(degree);
    ss_memory_free(cursor);
    return status;
}

void ss_cnn_rows_fini(ss_cnn_rows *rows)
{
    ss_memory_free(rows->group);
    ss_memory_free(rows->node);
    ss_memory_free(rows->neighbour);
    ss_memory_free(rows->edge);
    ss_memory_free(rows->arm);
}
