/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_network.h"
/*
 * The templates: who is connected to whom and how strongly (Zhong, Shirinzadeh, Alici, Smith 2006,
 * equations 17, 18 and 32), with rest geometry throughout:
 *
 *   w_ij = (|m j'| + |m k'|) / L0_ij        m midpoint of edge ij, j' k' centroids of its triangles
 *   S_i  a third of the star's area
 *   rho_ij the harmonic mean of rho_i and rho_j
 *
 * rho_ij is harmonic because the literal rho_i breaks Newton's third law and the arithmetic mean
 * drags the first node of a nearly rigid region along. Cotangent weights are not these templates.
 */
#include <math.h>
#include <stdlib.h>

#include "rt/memory.h"

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
softsim_status ss_cnn_network_build_edges(ss_cnn_network *network, const ss_mesh *mesh,
                                          const double *rho)
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
bool ss_cnn_network_edges_are_usable(const ss_cnn_network *network, softsim_error *error)
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

void ss_cnn_network_build_areas(ss_cnn_network *network, const ss_mesh *mesh)
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
