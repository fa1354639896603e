/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/network.h"
/*
 * The discrete Poisson equation that a cellular neural network settles to (Zhong, Shirinzadeh,
 * Alici, Smith 2006, equations 14 to 19):
 *
 *   sum_j c_ij (g_i - g_j) = S_i chi_i / rho_i     g = 0 when held
 *   q_ij = rho_ij |g_i - g_j| / L0_ij^2
 *
 * with the templates c_ij, S_i (in volumes V_i) and rho_ij of templates.c; rho_i is the one
 * along the material direction where there are two.
 * A component without a held cell drains through a uniform sink, rhs_i -= S_i sum(rhs)/sum(S),
 * and its least potential is zero; one of its cells is pinned to solve and shifted afterwards.
 *
 * The matrix is factored once (approximate minimum degree, then L D L'); influence.c solves with
 * it. Large volumes fill up; above SS_CNN_MAX_WORK there is no factor, and iterate.c solves.
 * Rejected: conjugate gradients or relaxation of the cells at each step, which cost ten to a
 * thousand times a back-solve, and whose small residual still leaves the field 9 to 41 % wrong at
 * 1e-3.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"

/* ---- factor ---- */

static int32_t root(int32_t *parent, int32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* Components of the edge graph; those without a held cell drain and have one cell pinned. */
static softsim_status find_components(ss_cnn_network *network, const uint8_t *held)
{
    ss_cnn_factor *factor = network->factor;
    const int32_t n = network->node_count;
    ss_arena *arena = &network->arena;
    int32_t *parent = ss_memory_get((size_t)n, sizeof *parent);
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)n, factor->component), SS_ROOM((size_t)n, factor->unknown),
                  SS_ROOM((size_t)n, factor->is_drained),
                  SS_ROOM((size_t)n, factor->component_size));
    if (!parent || ss_arena_status(arena) != SOFTSIM_OK) {
        ss_memory_free(parent);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < n; ++i) {
        parent[i] = i;
        factor->component[i] = -1;
        factor->unknown[i] = -1;
    }
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t a = root(parent, network->edges.from[e] / 4);
        const int32_t b = root(parent, network->edges.to[e] / 4);
        parent[a > b ? a : b] = a > b ? b : a;
    }
    for (int32_t e = 0; e < network->edges.count; ++e) { /* nodes with an edge have a component */
        factor->unknown[network->edges.from[e] / 4] = 0;
        factor->unknown[network->edges.to[e] / 4] = 0;
    }
    for (int32_t i = 0; i < n; ++i) {
        if (factor->unknown[i] < 0) {
            continue;
        }
        ++network->cell_count;
        const int32_t r = root(parent, i); /* the least node of its component, met first */
        if (r == i) {
            factor->component[i] = network->component_count++;
            factor->is_drained[factor->component[i]] = 1;
        } else {
            factor->component[i] = factor->component[r];
        }
        factor->component_size[factor->component[i]] += network->size[i];
        if (held[i]) {
            factor->is_drained[factor->component[i]] = 0;
        }
    }
    for (int32_t i = 0; i < n; ++i) {
        const bool is_loose = factor->component[i] < 0;
        const bool is_pinned =
            !is_loose && root(parent, i) == i && factor->is_drained[factor->component[i]];
        factor->unknown[i] = is_loose || is_pinned || held[i] ? -1 : factor->n++;
    }
    ss_memory_free(parent);
    return SOFTSIM_OK;
}

/* The matrix of the unknowns by columns, all of it (symmetric). */
static softsim_status build_matrix(const ss_cnn_network *network, ss_arena *matrix,
                                   int **out_column, int **out_row, double **out_value)
{
    const ss_cnn_factor *factor = network->factor;
    const ss_cnn_edges *edges = &network->edges;
    const size_t n = (size_t)factor->n, entries = n + 2 * (size_t)edges->count;
    int *column = ss_arena_get(matrix, n + 1, sizeof *column);
    int *row = ss_arena_get(matrix, entries, sizeof *row);
    int *cursor = ss_memory_get(n, sizeof *cursor);
    double *value = ss_arena_get(matrix, entries, sizeof *value);
    *out_column = column;
    *out_row = row;
    *out_value = value;
    if (!cursor || ss_arena_status(matrix) != SOFTSIM_OK) {
        ss_memory_free(cursor);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int k = 0; k < factor->n; ++k) {
        column[k + 1] = 1;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        const int i = factor->unknown[edges->from[e] / 4], j = factor->unknown[edges->to[e] / 4];
        if (i >= 0 && j >= 0) {
            ++column[i + 1];
            ++column[j + 1];
        }
    }
    for (int k = 0; k < factor->n; ++k) {
        column[k + 1] += column[k];
        row[column[k]] = k;
        cursor[k] = column[k] + 1;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        const int i = factor->unknown[edges->from[e] / 4], j = factor->unknown[edges->to[e] / 4];
        const double w = network->edge_weight[e];
        if (i >= 0) {
            value[column[i]] += w;
        }
        if (j >= 0) {
            value[column[j]] += w;
        }
        if (i >= 0 && j >= 0) {
            row[cursor[i]] = j;
            value[cursor[i]++] = -w;
            row[cursor[j]] = i;
            value[cursor[j]++] = -w;
        }
    }
    ss_memory_free(cursor);
    return SOFTSIM_OK;
}

static softsim_status refuse_loose_cell(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MESH,
                      "cnn-energy: the network has a cell without connection (degenerate "
                      "elements): repair the mesh");
    return SOFTSIM_ERROR_MESH;
}

/* Keeps the matrix in the factor's place. */
static softsim_status give_up(ss_cnn_factor *factor, ss_arena *matrix, int *column, int *row,
                              double *value, softsim_error *error)
{
    factor->matrix = *matrix;
    *matrix = (ss_arena){0};
    factor->is_given_up = true;
    factor->entry_column = column;
    factor->entry_row = row;
    factor->entry = value;
    for (int k = 0; k < factor->n; ++k) {
        if (!(value[column[k]] > 0.0)) {
            return refuse_loose_cell(error);
        }
    }
    return SOFTSIM_OK;
}

/* L D L' of the matrix; unknown[] then numbers nodes in the order of elimination. */
static softsim_status factorise(ss_cnn_network *network, double max_work, softsim_error *error)
{
    ss_cnn_factor *factor = network->factor;
    ss_factor *ldl = &factor->ldl;
    int *column = NULL, *row = NULL;
    double *value = NULL;
    ss_arena matrix = {0};
    softsim_status status = build_matrix(network, &matrix, &column, &row, &value);
    status = status == SOFTSIM_OK ? ss_factor_init(ldl, factor->n, column, row) : status;
    if (status != SOFTSIM_OK) {
        goto done;
    }
    if (ldl->fill > INT32_MAX || ldl->work > (max_work > 0.0 ? max_work : SS_CNN_MAX_WORK)) {
        status = give_up(factor, &matrix, column, row, value, error);
        goto done;
    }
    status = ss_factor_reserve(ldl);
    if (status != SOFTSIM_OK) {
        goto done;
    }
    if (!ss_factor_fill(ldl, column, row, value)) {
        status = refuse_loose_cell(error);
        goto done;
    }
    for (int32_t i = 0; i < network->node_count; ++i) {
        factor->unknown[i] = factor->unknown[i] < 0 ? -1 : ldl->inverse[factor->unknown[i]];
    }
done:
    ss_factor_trim(ldl);
    ss_arena_free(&matrix);
    return status;
}

/* ---- life ---- */

/* Sizes of the cells, and of a volume's surface the areas; on surfaces they are the same. */
static softsim_status build_sizes(ss_cnn_network *network, const ss_cnn_fabric *fabric)
{
    const size_t n = (size_t)network->node_count;
    network->size = ss_arena_get(&network->arena, n, sizeof *network->size);
    network->surface_area = fabric->element == SS_CNN_TETRAHEDRON
                                ? ss_arena_get(&network->arena, n, sizeof *network->surface_area)
                                : network->size;
    if (!network->size || !network->surface_area) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_cnn_cell_sizes(fabric, network->size);
    for (size_t i = 0; i < n; ++i) {
        network->size[i] = fmax(network->size[i], 0.0);
    }
    if (fabric->element == SS_CNN_TETRAHEDRON) {
        ss_mesh_node_areas(fabric->mesh, network->surface_area);
    }
    return SOFTSIM_OK;
}

/* The parts in the order in which they need one another. */
static softsim_status build(ss_cnn_network *network, const ss_cnn_fabric *fabric,
                            const uint8_t *held, softsim_error *error)
{
    softsim_status status = build_sizes(network, fabric);
    status = status == SOFTSIM_OK ? ss_cnn_network_build_edges(network, fabric) : status;
    if (status == SOFTSIM_OK && !ss_cnn_network_edges_are_usable(network, fabric->mesh, error)) {
        status = SOFTSIM_ERROR_MESH;
    }
    status = status == SOFTSIM_OK ? ss_cnn_network_build_rows(network, held, false, &network->rows)
                                  : status;
    status = status == SOFTSIM_OK ? ss_cnn_network_build_rows(network, held, true, &network->held)
                                  : status;
    status = status == SOFTSIM_OK ? find_components(network, held) : status;
    return status == SOFTSIM_OK ? factorise(network, fabric->max_work, error) : status;
}

softsim_status ss_cnn_network_create(const ss_cnn_fabric *fabric, const uint8_t *held,
                                     ss_cnn_network **out_network, softsim_error *error)
{
    const size_t n = (size_t)fabric->mesh->node_count;
    ss_cnn_network *network = ss_memory_get(1, sizeof *network);
    *out_network = NULL;
    if (!network) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_arena *arena = &network->arena;
    double *rho = ss_arena_get(arena, n, sizeof *rho);
    network->node_count = fabric->mesh->node_count;
    SS_ARENA_TAKE(arena, SS_ROOM(1, network->factor), SS_ROOM(n, network->qhat),
                  SS_ROOM(n, network->own), SS_ROOM(n, network->is_source),
                  SS_ROOM(n, network->influence_of));
    softsim_status status = ss_arena_status(arena);
    if (status != SOFTSIM_OK) {
        goto fail;
    }
    memcpy(rho, fabric->rho, n * sizeof *rho);
    network->factor->rho = rho;
    status = build(network, fabric, held, error);
    if (status != SOFTSIM_OK) {
        goto fail;
    }
    for (int32_t i = 0; i < network->node_count; ++i) { /* a volume is touched on its surface */
        network->influence_of[i] = -1;
        network->is_source[i] =
            !held[i] && network->size[i] > 0.0 && network->surface_area[i] > 0.0;
    }
    *out_network = network;
    return SOFTSIM_OK;
fail:
    ss_cnn_network_destroy(&network);
    return status;
}

void ss_cnn_network_destroy(ss_cnn_network **network)
{
    ss_cnn_network *gone = *network;
    if (gone && gone->factor) {
        ss_factor_fini(&gone->factor->ldl);
        ss_arena_free(&gone->factor->matrix);
    }
    if (gone) {
        ss_arena_free(&gone->arena);
        ss_memory_free(gone);
        *network = NULL;
    }
}

int64_t ss_cnn_network_bytes(const ss_cnn_network *network)
{
    const int64_t entry = (int64_t)(2 * sizeof(int32_t) + 4 * sizeof(ss_real));
    const int64_t edge = (int64_t)(2 * sizeof(int32_t) + 3 * sizeof(ss_real) + 3 * sizeof(double));
    const ss_cnn_factor *factor = network->factor;
    const int64_t entries =
        factor->is_given_up ? factor->entry_column[factor->n] : factor->ldl.column[factor->n];
    return entry * (network->rows.entry_count + network->held.entry_count) +
           edge * network->edges.padded_count + (int64_t)(sizeof(int) + sizeof(double)) * entries;
}
