/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhong2006/net.h"
/*
 * Y. Zhong, B. Shirinzadeh, G. Alici, J. Smith: "Haptic deformation modelling through cellular
 * neural network", I. J. of Simulation 7 (8), 2006. Numbers in brackets are its equations.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "rt/vec.h"

/* ---- memory ---- */

static ss_zhong_net *make(int32_t node_count, int32_t edge_capacity, const double (*position)[3])
{
    ss_zhong_net *net = calloc(1, sizeof *net);
    if (net == NULL) {
        return NULL;
    }
    const size_t n = (size_t)node_count, edges = (size_t)edge_capacity;
    net->node_count = node_count;
    SS_ARENA_TAKE(&net->arena, SS_ROOM(n, net->rest), SS_ROOM(edges, net->edge),
                  SS_ROOM(edges, net->conductance), SS_ROOM(edges, net->length),
                  SS_ROOM(edges, net->ratio), SS_ROOM(edges, net->flux), SS_ROOM(n, net->area),
                  SS_ROOM(n, net->rho), SS_ROOM(n, net->is_held), SS_ROOM(n, net->is_source),
                  SS_ROOM(n, net->potential), SS_ROOM(n, net->unknown));
    if (ss_arena_status(&net->arena) != SOFTSIM_OK) {
        ss_zhong_net_destroy(&net);
        return NULL;
    }
    memcpy(net->rest, position, n * sizeof *net->rest);
    for (size_t i = 0; i < n; ++i) {
        net->rho[i] = 1.0;
    }
    return net;
}

void ss_zhong_net_destroy(ss_zhong_net **net)
{
    if (*net == NULL) {
        return;
    }
    ss_arena_free(&(*net)->arena);
    free(*net);
    *net = NULL;
}

/* ---- templates ---- */

static double distance(const ss_zhong_net *net, int32_t i, int32_t j)
{
    double d[3];
    ss_sub3(d, net->rest[j], net->rest[i]);
    return ss_norm3(d);
}

/* The edge between two nodes, made when it is new. */
static int32_t edge_between(ss_zhong_net *net, int32_t a, int32_t b)
{
    const int32_t i = a < b ? a : b, j = a < b ? b : a;
    for (int32_t e = 0; e < net->edge_count; ++e) {
        if (net->edge[e][0] == i && net->edge[e][1] == j) {
            return e;
        }
    }
    const int32_t e = net->edge_count++;
    net->edge[e][0] = i;
    net->edge[e][1] = j;
    net->length[e] = distance(net, i, j);
    net->ratio[e] = 1.0;
    return e;
}

/* (14): at a point with spacings du', du along u and dw', dw along w the conductance to the next
 * point along u is 2 / (du (du' + du)); times S = (du' + du)(dw' + dw)/4 it is
 * (dw' + dw) / (2 du), the same from both sides. At an open end the point has half a cell. */
ss_zhong_net *ss_zhong_net_tube(int32_t rows, int32_t columns, const double (*position)[3],
                                double across)
{
    ss_zhong_net *net = make(rows * columns, 2 * rows * columns, position);
    if (net == NULL) {
        return NULL;
    }
    for (int32_t i = 0; i < rows; ++i) {
        for (int32_t j = 0; j < columns; ++j) {
            const int32_t at = i * columns + j;
            const int32_t right = i * columns + (j + 1) % columns;
            const int32_t left = i * columns + (j + columns - 1) % columns;
            const double dw = distance(net, at, right), dw_before = distance(net, left, at);
            const double du = i + 1 < rows ? distance(net, at, at + columns) : 0.0;
            const double du_before = i > 0 ? distance(net, at - columns, at) : 0.0;
            net->area[at] = 0.25 * (du + du_before) * (dw + dw_before);
            const int32_t around = edge_between(net, at, right);
            net->ratio[around] = across;
            net->conductance[around] = across * 0.5 * (du_before + du) / dw;
            if (i + 1 < rows) {
                net->conductance[edge_between(net, at, at + columns)] = 0.5 * (dw_before + dw) / du;
            }
        }
    }
    return net;
}

/* (17), (32): w_ij = (|m j'| + |m k'|) / |PiPj|, m the middle of the edge, j' and k' the centroids
 * of its triangles; S a third of the star's. Along an edge at the angle theta from the axis rho is
 * that along times cos^2 plus that across times sin^2. */
ss_zhong_net *ss_zhong_net_triangles(int32_t node_count, const double (*position)[3],
                                     int32_t triangle_count, const int32_t (*triangle)[3],
                                     const double axis[3], double across)
{
    ss_zhong_net *net = make(node_count, 3 * triangle_count, position);
    for (int32_t t = 0; net != NULL && t < triangle_count; ++t) {
        const double *p[3];
        double centroid[3] = {0.0, 0.0, 0.0}, n[3];
        for (int k = 0; k < 3; ++k) {
            p[k] = net->rest[triangle[t][k]];
            ss_madd3(centroid, centroid, 1.0 / 3.0, p[k]);
        }
        ss_normal3(n, p[0], p[1], p[2]);
        for (int k = 0; k < 3; ++k) {
            double middle[3], half[3];
            const int32_t e = edge_between(net, triangle[t][k], triangle[t][(k + 1) % 3]);
            ss_add3(middle, p[k], p[(k + 1) % 3]);
            ss_scale3(middle, middle, 0.5);
            ss_sub3(half, centroid, middle);
            if (axis != NULL) {
                double along[3];
                ss_sub3(along, p[(k + 1) % 3], p[k]);
                const double c = ss_dot3(along, axis) / net->length[e];
                net->ratio[e] = c * c + across * (1.0 - c * c);
            }
            net->conductance[e] += net->ratio[e] * ss_norm3(half) / net->length[e];
            net->area[triangle[t][k]] += ss_norm3(n) / 6.0;
        }
    }
    return net;
}

ss_zhong_net *ss_zhong_net_hexagon(double edge_m, int32_t out_triangle[6][3])
{
    double position[7][3] = {{0.0, 0.0, 0.0}};
    for (int k = 0; k < 6; ++k) {
        const double angle = k * SS_PI / 3.0;
        const int32_t corner[3] = {0, 1 + k, 1 + (k + 1) % 6};
        ss_set3(position[1 + k], edge_m * cos(angle), edge_m * sin(angle), 0.0);
        memcpy(out_triangle[k], corner, sizeof corner);
    }
    ss_zhong_net *net = ss_zhong_net_triangles(7, (const double(*)[3])position, 6,
                                               (const int32_t(*)[3])out_triangle, NULL, 0.0);
    for (int32_t i = 0; net != NULL && i < 7; ++i) {
        net->is_held[i] = i > 0;
        net->is_source[i] = i == 0;
    }
    return net;
}

/* Within a tetrahedron the cells of i and j meet on the plane figure of the edge's middle m, the
 * centroids f, f' of the two faces on the edge and the tetrahedron's own c: half |c - m| x |f' - f|
 * of the vectors. */
ss_zhong_net *ss_zhong_net_tetrahedra(int32_t node_count, const double (*position)[3],
                                      int32_t tetrahedron_count, const int32_t (*tetrahedron)[4])
{
    ss_zhong_net *net = make(node_count, 6 * tetrahedron_count, position);
    if (net != NULL) {
        net->is_volume = true;
    }
    for (int32_t t = 0; net != NULL && t < tetrahedron_count; ++t) {
        const int32_t *corner = tetrahedron[t];
        double centroid[3] = {0.0, 0.0, 0.0}, u[3], v[3], w[3], n[3];
        for (int k = 0; k < 4; ++k) {
            ss_madd3(centroid, centroid, 0.25, net->rest[corner[k]]);
        }
        ss_sub3(u, net->rest[corner[1]], net->rest[corner[0]]);
        ss_sub3(v, net->rest[corner[2]], net->rest[corner[0]]);
        ss_sub3(w, net->rest[corner[3]], net->rest[corner[0]]);
        ss_cross3(n, u, v);
        for (int k = 0; k < 4; ++k) {
            net->area[corner[k]] += fabs(ss_dot3(n, w)) / 24.0;
        }
        for (int a = 0; a < 4; ++a) {
            for (int b = a + 1; b < 4; ++b) {
                const int other = a == 0 ? (b == 1 ? 2 : 1) : 0; /* f' - f = (last - other)/3 */
                double middle[3], apart[3];
                const int32_t e = edge_between(net, corner[a], corner[b]);
                ss_add3(middle, net->rest[corner[a]], net->rest[corner[b]]);
                ss_madd3(middle, centroid, -0.5, middle);
                ss_sub3(apart, net->rest[corner[6 - a - b - other]], net->rest[corner[other]]);
                ss_cross3(n, middle, apart);
                net->conductance[e] += ss_norm3(n) / 6.0 / net->length[e];
            }
        }
    }
    return net;
}

/* ---- the potential ---- */

bool ss_zhong_cholesky(int32_t n, double *a, int32_t columns, double *b)
{
    const size_t stride = (size_t)n;
    for (size_t i = 0; i < stride; ++i) {
        for (size_t j = 0; j <= i; ++j) {
            double sum = a[i * stride + j];
            for (size_t k = 0; k < j; ++k) {
                sum -= a[i * stride + k] * a[j * stride + k];
            }
            if (i == j && !(sum > 0.0)) {
                return false;
            }
            a[i * stride + j] = i == j ? sqrt(sum) : sum / a[j * stride + j];
        }
    }
    for (int32_t c = 0; c < columns; ++c) {
        double *x = b + (size_t)c * stride;
        for (size_t i = 0; i < stride; ++i) {
            for (size_t k = 0; k < i; ++k) {
                x[i] -= a[i * stride + k] * x[k];
            }
            x[i] /= a[i * stride + i];
        }
        for (size_t i = stride; i-- > 0;) {
            for (size_t k = i + 1; k < stride; ++k) {
                x[i] -= a[k * stride + i] * x[k];
            }
            x[i] /= a[i * stride + i];
        }
    }
    return true;
}

/* Adds scale times the Laplacian with weights `w` of the free nodes to the matrix. */
static void add_laplacian(const ss_zhong_net *net, double scale, const double *w, double *matrix)
{
    const size_t n = (size_t)net->unknown_count;
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->unknown[net->edge[e][0]], j = net->unknown[net->edge[e][1]];
        const double value = scale * w[e];
        if (i >= 0) {
            matrix[(size_t)i * n + (size_t)i] += value;
        }
        if (j >= 0) {
            matrix[(size_t)j * n + (size_t)j] += value;
        }
        if (i >= 0 && j >= 0) {
            matrix[(size_t)(i > j ? i : j) * n + (size_t)(i > j ? j : i)] -= value;
        }
    }
}

double ss_zhong_net_rho(const ss_zhong_net *net, int32_t edge)
{
    const double a = net->rho[net->edge[edge][0]], b = net->rho[net->edge[edge][1]];
    return net->ratio[edge] * 2.0 * a * b / (a + b);
}

bool ss_zhong_net_solve(ss_zhong_net *net)
{
    net->unknown_count = 0;
    for (int32_t i = 0; i < net->node_count; ++i) {
        net->unknown[i] = net->is_held[i] ? -1 : net->unknown_count++;
        net->potential[i] = 0.0;
    }
    const size_t n = (size_t)net->unknown_count;
    double *matrix = calloc(n * n, sizeof *matrix), *x = calloc(n, sizeof *x);
    bool is_good = matrix != NULL && x != NULL;
    if (is_good) {
        add_laplacian(net, 1.0, net->conductance, matrix);
        for (int32_t i = 0; i < net->node_count; ++i) {
            if (net->unknown[i] >= 0 && net->is_source[i]) {
                x[net->unknown[i]] = net->area[i] / net->rho[i];
            }
        }
        is_good = ss_zhong_cholesky(net->unknown_count, matrix, 1, x);
    }
    for (int32_t i = 0; is_good && i < net->node_count; ++i) {
        net->potential[i] = net->unknown[i] >= 0 ? x[net->unknown[i]] : 0.0;
    }
    net->flux_strain = 0.0;
    for (int32_t e = 0; is_good && e < net->edge_count; ++e) {
        const double drop = fabs(net->potential[net->edge[e][0]] - net->potential[net->edge[e][1]]);
        const double square = net->length[e] * net->length[e];
        net->flux[e] = ss_zhong_net_rho(net, e) * drop / square;
        net->flux[e] *= net->is_volume ? net->conductance[e] : 1.0;
        net->flux_strain += net->flux[e] * square;
    }
    free(matrix);
    free(x);
    return is_good;
}

/* ---- forces and shapes ---- */

void ss_zhong_net_pull(const ss_zhong_net *net, const double (*x)[3], double (*out)[3])
{
    memset(out, 0, (size_t)net->node_count * sizeof *out);
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->edge[e][0], j = net->edge[e][1];
        double d[3];
        ss_sub3(d, x[i], x[j]);
        ss_madd3(out[i], out[i], net->flux[e], d);
        ss_madd3(out[j], out[j], -net->flux[e], d);
    }
}

double ss_zhong_net_strain(const ss_zhong_net *net, const double (*u)[3])
{
    double sum = 0.0;
    for (int32_t e = 0; e < net->edge_count; ++e) {
        double d[3], l[3];
        ss_sub3(d, u[net->edge[e][1]], u[net->edge[e][0]]);
        ss_sub3(l, net->rest[net->edge[e][1]], net->rest[net->edge[e][0]]);
        sum += net->flux[e] * (ss_dot3(l, d) + 0.5 * ss_dot3(d, d));
    }
    return sum;
}

/* (I L_q + ks) u = F - I L_q P0 on the free nodes. */
static bool shape_at(const ss_zhong_net *net, double current, const double *stiffness,
                     const double (*force)[3], const double (*pull)[3], double *matrix, double *b,
                     double (*out_u)[3])
{
    const size_t n = (size_t)net->unknown_count;
    memset(matrix, 0, n * n * sizeof *matrix);
    add_laplacian(net, current, net->flux, matrix);
    for (int32_t i = 0; i < net->node_count; ++i) {
        const int32_t at = net->unknown[i];
        if (at >= 0) {
            matrix[(size_t)at * n + (size_t)at] += stiffness[i];
            for (size_t k = 0; k < 3; ++k) {
                b[k * n + (size_t)at] = force[i][k] - current * pull[i][k];
            }
        }
    }
    if (!ss_zhong_cholesky(net->unknown_count, matrix, 3, b)) {
        return false;
    }
    for (int32_t i = 0; i < net->node_count; ++i) {
        for (size_t k = 0; k < 3; ++k) {
            out_u[i][k] = net->unknown[i] >= 0 ? b[k * n + (size_t)net->unknown[i]] : 0.0;
        }
    }
    return true;
}

double ss_zhong_net_static(ss_zhong_net *net, double modulus, const double *stiffness,
                           const double (*force)[3], double (*out_u)[3])
{
    enum { HALVINGS = 40 };
    const size_t n = (size_t)net->unknown_count;
    double *matrix = calloc(n * n, sizeof *matrix), *b = calloc(3 * n, sizeof *b);
    double(*pull)[3] = calloc((size_t)net->node_count, sizeof *pull);
    double low = 0.0, high = 0.0, current = 0.0;
    bool is_good = matrix != NULL && b != NULL && pull != NULL;
    if (is_good) {
        ss_zhong_net_pull(net, (const double(*)[3])net->rest, pull);
    }
    for (int k = 0; is_good && k < HALVINGS; ++k) {
        is_good =
            shape_at(net, current, stiffness, force, (const double(*)[3])pull, matrix, b, out_u);
        const double strain = ss_zhong_net_strain(net, (const double(*)[3])out_u);
        double wanted = modulus * fmax(0.0, strain / net->flux_strain);
        wanted = net->most_current > 0.0 ? fmin(wanted, net->most_current) : wanted;
        if (k == 0) { /* softest: no current at all */
            high = wanted;
        } else if (wanted > current) {
            low = current;
        } else {
            high = current;
        }
        current = 0.5 * (low + high);
    }
    SS_EACH(free, matrix, b, pull);
    net->current = is_good ? current : (double)NAN;
    return net->current;
}

bool ss_zhong_net_shape(const ss_zhong_net *net, double current, const double *stiffness,
                        const double (*force)[3], double (*out_u)[3])
{
    const size_t n = (size_t)net->unknown_count;
    double *matrix = calloc(n * n, sizeof *matrix), *b = calloc(3 * n, sizeof *b);
    double(*pull)[3] = calloc((size_t)net->node_count, sizeof *pull);
    bool is_good = matrix != NULL && b != NULL && pull != NULL;
    if (is_good) {
        ss_zhong_net_pull(net, (const double(*)[3])net->rest, pull);
        is_good =
            shape_at(net, current, stiffness, force, (const double(*)[3])pull, matrix, b, out_u);
    }
    SS_EACH(free, matrix, b, pull);
    return is_good;
}
