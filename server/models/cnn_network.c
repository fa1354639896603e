/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_network.h"
/*
 * The discrete Poisson equation that a cellular neural network settles to (Zhong, Shirinzadeh,
 * Alici, Smith 2006, equations 17, 18 and 32), with rest geometry throughout:
 *
 *   w_ij = (|m j'| + |m k'|) / L0_ij        m midpoint of edge ij, j' k' centroids of its triangles
 *   sum_j w_ij (g_i - g_j) = S_i chi_i / rho_i     S_i a third of the star's area, g = 0 when held
 *   q_ij = rho_ij |g_i - g_j| / L0_ij^2            rho_ij the harmonic mean of rho_i and rho_j
 *
 * rho_ij is harmonic because the literal rho_i breaks Newton's third law and the arithmetic mean
 * drags the first node of a nearly rigid region along. Cotangent weights are not these templates.
 * A component without a held cell drains through a uniform sink, rhs_i -= S_i sum(rhs)/sum(S),
 * and its least potential is zero; one of its cells is pinned to solve and shifted afterwards.
 *
 * The matrix is factored once (approximate minimum degree, then L D L'); cnn_columns.c solves with
 * it. Rejected: conjugate gradients or relaxation of the cells at each step, which cost ten to a
 * thousand times a back-solve, and whose small residual still leaves the field 9 to 41 % wrong at
 * 1e-3.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"

#include <amd.h>
#include <ldl.h>

/* ---- edges -------------------------------------------------------------------------------- */

typedef struct half_edge {
    int32_t i, j, triangle;
} half_edge;

static int compare_half_edges(const void *a, const void *b)
{
    const half_edge *x = a, *y = b;
    if (x->i != y->i) {
        return x->i < y->i ? -1 : 1;
    }
    if (x->j != y->j) {
        return x->j < y->j ? -1 : 1;
    }
    return x->triangle < y->triangle ? -1 : x->triangle > y->triangle;
}

static double distance(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Half-edges of all triangles with i < j, sorted, so that both sides of an edge are neighbours. */
static half_edge *sorted_half_edges(const ss_mesh *mesh)
{
    half_edge *half = ss_memory_get((size_t)mesh->triangle_count * 3, sizeof *half);
    if (!half) {
        return NULL;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            const int32_t i = mesh->triangle[t][k], j = mesh->triangle[t][(k + 1) % 3];
            half[3 * t + k] = (half_edge){i < j ? i : j, i < j ? j : i, t};
        }
    }
    qsort(half, (size_t)mesh->triangle_count * 3, sizeof *half, compare_half_edges);
    return half;
}

static bool allocate_edges(ss_cnn_network *network, int32_t count)
{
    ss_cnn_edges *edges = &network->edges;
    const int32_t padded = (count + 7) / 8 * 8;
    const size_t size = (size_t)padded;
    edges->count = count;
    edges->padded_count = padded;
    edges->from = ss_memory_get(size, sizeof *edges->from);
    edges->to = ss_memory_get(size, sizeof *edges->to);
    edges->x = ss_memory_get(size, sizeof *edges->x);
    edges->y = ss_memory_get(size, sizeof *edges->y);
    edges->z = ss_memory_get(size, sizeof *edges->z);
    network->edge_weight = ss_memory_get(size, sizeof *network->edge_weight);
    network->edge_rho = ss_memory_get(size, sizeof *network->edge_rho);
    network->edge_square = ss_memory_get(size, sizeof *network->edge_square);
    return edges->from && edges->to && edges->x && edges->y && edges->z && network->edge_weight &&
           network->edge_rho && network->edge_square;
}

/* Templates w_ij, rest vectors and rho_ij of every edge. */
static softsim_status build_edges(ss_cnn_network *network, const ss_mesh *mesh, const double *rho)
{
    half_edge *half = sorted_half_edges(mesh);
    if (!half) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const int64_t half_count = 3 * (int64_t)mesh->triangle_count;
    int32_t count = 0;
    for (int64_t h = 0; h < half_count; ++h) {
        count += h == 0 || half[h].i != half[h - 1].i || half[h].j != half[h - 1].j;
    }
    if (!allocate_edges(network, count)) {
        ss_memory_free(half);
        return SOFTSIM_ERROR_MEMORY;
    }
    double sum = 0.0;
    int32_t e = -1;
    for (int64_t h = 0; h < half_count; ++h) {
        const int32_t i = half[h].i, j = half[h].j;
        const double *a = mesh->position[i], *b = mesh->position[j];
        if (h == 0 || i != half[h - 1].i || j != half[h - 1].j) {
            ++e;
            network->edges.from[e] = 4 * i;
            network->edges.to[e] = 4 * j;
            network->edges.x[e] = (ss_real)(b[0] - a[0]);
            network->edges.y[e] = (ss_real)(b[1] - a[1]);
            network->edges.z[e] = (ss_real)(b[2] - a[2]);
            const double length = distance(a, b);
            network->edge_square[e] = length * length;
            network->edge_rho[e] = 2.0 * rho[i] * rho[j] / (rho[i] + rho[j]);
            sum += length;
        }
        const int32_t *corner = mesh->triangle[half[h].triangle];
        double centroid[3], midpoint[3];
        for (int k = 0; k < 3; ++k) {
            centroid[k] = (mesh->position[corner[0]][k] + mesh->position[corner[1]][k] +
                           mesh->position[corner[2]][k]) /
                          3.0;
            midpoint[k] = 0.5 * (a[k] + b[k]);
        }
        network->edge_weight[e] += distance(centroid, midpoint) / sqrt(network->edge_square[e]);
    }
    network->mean_edge = count > 0 ? sum / count : 0.0;
    ss_memory_free(half);
    return SOFTSIM_OK;
}

/* An edge far shorter than the rest makes a template that no step can follow. */
static bool edges_are_usable(const ss_cnn_network *network, softsim_error *error)
{
    int32_t bad = 0, first = 0;
    for (int32_t e = 0; e < network->edges.count; ++e) {
        if (!(sqrt(network->edge_square[e]) >= 1e-3 * network->mean_edge)) {
            first = bad++ == 0 ? e : first;
        }
    }
    if (bad > 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_MESH,
            "cnn-energy: %d edges are shorter than a thousandth of the mean edge, the "
            "first between nodes %d and %d: weld these nodes",
            bad, network->edges.from[first] / 4, network->edges.to[first] / 4);
    }
    return bad == 0;
}

static void build_areas(ss_cnn_network *network, const ss_mesh *mesh)
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        const double *a = mesh->position[c[0]];
        double u[3], v[3];
        for (int k = 0; k < 3; ++k) {
            u[k] = mesh->position[c[1]][k] - a[k];
            v[k] = mesh->position[c[2]][k] - a[k];
        }
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                             u[0] * v[1] - u[1] * v[0]};
        const double area = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; ++k) {
            network->area[c[k]] += area / 3.0;
        }
    }
}

/* ---- rows --------------------------------------------------------------------------------- */

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
static softsim_status build_rows(ss_cnn_network *network, const uint8_t *held, bool wanted,
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

/* ---- factor ------------------------------------------------------------------------------- */

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
    int32_t *parent = ss_memory_get((size_t)n, sizeof *parent);
    factor->component = ss_memory_get((size_t)n, sizeof *factor->component);
    factor->unknown = ss_memory_get((size_t)n, sizeof *factor->unknown);
    factor->is_drained = ss_memory_get((size_t)n, sizeof *factor->is_drained);
    factor->component_area = ss_memory_get((size_t)n, sizeof *factor->component_area);
    if (!parent || !factor->component || !factor->unknown || !factor->is_drained ||
        !factor->component_area) {
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
        ++network->triangle_nodes;
        const int32_t r = root(parent, i); /* the least node of its component, met first */
        if (r == i) {
            factor->component[i] = network->component_count++;
            factor->is_drained[factor->component[i]] = 1;
        } else {
            factor->component[i] = factor->component[r];
        }
        factor->component_area[factor->component[i]] += network->area[i];
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
static softsim_status build_matrix(const ss_cnn_network *network, int **out_column, int **out_row,
                                   double **out_value)
{
    const ss_cnn_factor *factor = network->factor;
    const ss_cnn_edges *edges = &network->edges;
    const size_t n = (size_t)factor->n, entries = n + 2 * (size_t)edges->count;
    int *column = ss_memory_get(n + 1, sizeof *column), *row = ss_memory_get(entries, sizeof *row);
    int *cursor = ss_memory_get(n, sizeof *cursor);
    double *value = ss_memory_get(entries, sizeof *value);
    *out_column = column;
    *out_row = row;
    *out_value = value;
    if (!column || !row || !value || !cursor) {
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

/* L D L' of the permuted matrix; unknown[] then numbers nodes in permuted order. */
static softsim_status factorise(ss_cnn_network *network, softsim_error *error)
{
    ss_cnn_factor *factor = network->factor;
    const size_t n = (size_t)factor->n;
    int *column = NULL, *row = NULL, *work = ss_memory_get(6 * n + 1, sizeof *work);
    double *value = NULL, *scratch = ss_memory_get(n, sizeof *scratch);
    softsim_status status = build_matrix(network, &column, &row, &value);
    factor->column = ss_memory_get(n + 1, sizeof *factor->column);
    factor->diagonal = ss_memory_get(n, sizeof *factor->diagonal);
    if (status != SOFTSIM_OK || !work || !scratch || !factor->column || !factor->diagonal) {
        status = SOFTSIM_ERROR_MEMORY;
        goto done;
    }
    int *order = work, *inverse = work + n, *parent = work + 2 * n, *counts = work + 3 * n;
    int *flag = work + 4 * n, *pattern = work + 5 * n;
    if (factor->n > 0 && amd_order(factor->n, column, row, order, NULL, NULL) < 0) {
        status = SOFTSIM_ERROR_MEMORY;
        goto done;
    }
    ldl_symbolic(factor->n, column, row, factor->column, parent, counts, flag, order, inverse);
    factor->row = ss_memory_get((size_t)factor->column[n], sizeof *factor->row);
    factor->lower = ss_memory_get((size_t)factor->column[n], sizeof *factor->lower);
    if (!factor->row || !factor->lower) {
        status = SOFTSIM_ERROR_MEMORY;
        goto done;
    }
    const int done_count =
        ldl_numeric(factor->n, column, row, value, factor->column, parent, counts, factor->row,
                    factor->lower, factor->diagonal, scratch, pattern, flag, order, inverse);
    if (done_count != factor->n) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "cnn-energy: the network has a cell without connection (degenerate "
                          "triangles): repair the mesh");
        status = SOFTSIM_ERROR_MESH;
        goto done;
    }
    for (int32_t i = 0; i < network->node_count; ++i) {
        factor->unknown[i] = factor->unknown[i] < 0 ? -1 : inverse[factor->unknown[i]];
    }
done:
    ss_memory_free(column);
    ss_memory_free(row);
    ss_memory_free(value);
    ss_memory_free(work);
    ss_memory_free(scratch);
    return status;
}

/* ---- life --------------------------------------------------------------------------------- */

softsim_status ss_cnn_network_create(const ss_mesh *mesh, const uint8_t *held, const double *rho,
                                     ss_cnn_network **out_network, softsim_error *error)
{
    const size_t n = (size_t)mesh->node_count;
    ss_cnn_network *network = ss_memory_get(1, sizeof *network);
    *out_network = NULL;
    if (!network) {
        return SOFTSIM_ERROR_MEMORY;
    }
    double *rho_copy = ss_memory_get(n, sizeof *rho_copy);
    network->node_count = mesh->node_count;
    network->factor = ss_memory_get(1, sizeof *network->factor);
    network->area = ss_memory_get(n, sizeof *network->area);
    network->qhat = ss_memory_get(n, sizeof *network->qhat);
    network->own = ss_memory_get(n, sizeof *network->own);
    network->is_source = ss_memory_get(n, sizeof *network->is_source);
    network->column_of = ss_memory_get(n, sizeof *network->column_of);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (!rho_copy || !network->factor || !network->area || !network->qhat || !network->own ||
        !network->is_source || !network->column_of) {
        ss_memory_free(rho_copy);
        goto fail;
    }
    memcpy(rho_copy, rho, n * sizeof *rho);
    network->factor->rho = rho_copy;
    build_areas(network, mesh);
    status = build_edges(network, mesh, rho);
    if (status == SOFTSIM_OK && !edges_are_usable(network, error)) {
        status = SOFTSIM_ERROR_MESH;
    }
    status = status == SOFTSIM_OK ? build_rows(network, held, false, &network->rows) : status;
    status = status == SOFTSIM_OK ? build_rows(network, held, true, &network->held) : status;
    status = status == SOFTSIM_OK ? find_components(network, held) : status;
    status = status == SOFTSIM_OK ? factorise(network, error) : status;
    if (status != SOFTSIM_OK) {
        goto fail;
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        network->column_of[i] = -1;
        network->is_source[i] = !held[i] && network->area[i] > 0.0;
    }
    *out_network = network;
    return SOFTSIM_OK;
fail:
    ss_cnn_network_destroy(&network);
    return status;
}

static void free_rows(ss_cnn_rows *rows)
{
    ss_memory_free(rows->group);
    ss_memory_free(rows->node);
    ss_memory_free(rows->neighbour);
    ss_memory_free(rows->edge);
    ss_memory_free(rows->arm);
}

static void free_factor(ss_cnn_factor *factor)
{
    if (!factor) {
        return;
    }
    ss_memory_free(factor->unknown);
    ss_memory_free(factor->column);
    ss_memory_free(factor->row);
    ss_memory_free(factor->lower);
    ss_memory_free(factor->diagonal);
    ss_memory_free(factor->component);
    ss_memory_free(factor->is_drained);
    ss_memory_free(factor->component_area);
    ss_memory_free(factor->rho);
    ss_memory_free(factor);
}

void ss_cnn_network_destroy(ss_cnn_network **network)
{
    ss_cnn_network *gone = *network;
    if (!gone) {
        return;
    }
    void *const owned[] = {gone->area,       gone->edge_rho,  gone->edge_square, gone->edge_weight,
                           gone->edges.from, gone->edges.to,  gone->edges.x,     gone->edges.y,
                           gone->edges.z,    gone->is_source, gone->qhat,        gone->own,
                           gone->column_of,  gone->kap,       gone->ghat,        gone->edge_scale,
                           gone->slot_of,    gone->slot_node, gone->slot_used};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k) {
        ss_memory_free(owned[k]);
    }
    free_rows(&gone->rows);
    free_rows(&gone->held);
    free_factor(gone->factor);
    ss_memory_free(gone);
    *network = NULL;
}

int64_t ss_cnn_network_bytes(const ss_cnn_network *network)
{
    const int64_t entry = (int64_t)(2 * sizeof(int32_t) + 4 * sizeof(ss_real));
    const int64_t edge = (int64_t)(2 * sizeof(int32_t) + 3 * sizeof(ss_real) + 3 * sizeof(double));
    return entry * (network->rows.entry_count + network->held.entry_count) +
           edge * network->edges.padded_count +
           (int64_t)(sizeof(int) + sizeof(double)) * network->factor->column[network->factor->n];
}
