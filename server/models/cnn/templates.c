/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/network.h"
/*
 * The templates: who is connected to whom and how strongly (Zhong, Shirinzadeh, Alici, Smith 2006,
 * equations 14 to 18, 20 and 32), with rest geometry throughout. All of them are sums of what each
 * element adds to its sides and corners; L is the length of the side ij.
 *
 *   triangle (17), (32)    w  |m c| / L                m midpoint of the side, c centroid
 *                          S  a third of the area
 *   quad (14), (20)        w  (t_i + t_j) / 2 / (2 L)  t_i, t_j the transverse sides at its ends
 *                          S  a quarter of the product of the two sides at the corner
 *   tetrahedron            w  |D| / L, |D| = |(P_k + P_l - P_i - P_j) x (P_l - P_k)| / 24
 *                          V  a quarter of the volume
 *
 * Equation 14 times S_i gives (dw_{j-1} + dw_j) / (2 du_i) on a tensor grid, which the quads at the
 * side sum up to. Where a grid is distorted the two ends see different transverse sides; the mean
 * of both keeps the matrix symmetric. A border has half cells. Quads have no diagonals. D is the
 * element's part of the dual face of an edge: the midpoint of the edge, the centroids of the two
 * faces at it, the centroid of the tetrahedron; these four lie in one plane. Lengths and areas are
 * taken as they are, not as seen along the edge, hence sum w L^2 >= 4 S and >= 6 V: irregular
 * elements conduct a little too well. Cotangent weights are not these templates.
 *
 * Anisotropy (15): rho differs along and across the material direction,
 *
 *   c_ij = sum w (cos^2 + r_ij sin^2),  r_ij = H(across_i, across_j) / H(along_i, along_j)
 *   a_ij = c_ij / w_ij,  rho_ij = a_ij H(along_i, along_j)
 *
 * with the angle between the side and the direction in each element (on triangles: the direction's
 * projection into the plane), so that a_ij is the mean over the elements at the edge by what each
 * adds. On a grid the sides along u have cos^2 = 1 and the others 0; where a direction is given u
 * is the pair of sides nearer to it. Where a direction stands upright on its triangle no direction
 * in the plane is special: cos^2 = 1/2 for all. H is the harmonic mean (18): the literal rho_i
 * breaks Newton's third law and the arithmetic mean drags the first node of a nearly rigid region
 * along. Along and across have one each, so that regions may differ in both. On equilateral
 * triangles, where edges of three directions carry both, a ratio r comes out as (1 + 3 r)/(3 + r).
 *
 * In volumes the flux density of an edge is taken through its dual face, q = w_ij rho_ij |dg| /
 * L^2: the force along an edge is a stress times an area. Qhat is then a volume, the modulus is in
 * Pa, and where all w are equal a cell stores E V_i eps^2 / 2. On surfaces the paper's equation 27
 * stands, q = rho_ij |dg| / L^2. Rejected for volumes, where it would leave the modulus in N/m: the
 * middle of a pressed block then follows by two thirds only.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/order.h"
#include "rt/vec.h"

/* Sine of the angle between a direction and the triangle's normal, below which the projection says
 * nothing. */
#define UPRIGHT 1e-6

/* ---- one element ---- */

typedef struct element_kind {
    int corners, sides;
    int8_t side[6][2];
} element_kind;

static const element_kind kinds[] = {
    [SS_CNN_TRIANGLE] = {3, 3, {{0, 1}, {1, 2}, {2, 0}}},
    [SS_CNN_QUAD] = {4, 4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}},
    [SS_CNN_TETRAHEDRON] = {4, 6, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}}};

int32_t ss_cnn_element_count(const ss_cnn_fabric *fabric)
{
    const ss_mesh *mesh = fabric->mesh;
    return fabric->element == SS_CNN_TRIANGLE ? mesh->triangle_count
           : fabric->element == SS_CNN_QUAD   ? mesh->quad_count
                                              : mesh->tetrahedron_count;
}

static const int32_t *element_nodes(const ss_cnn_fabric *fabric, int32_t element)
{
    const ss_mesh *mesh = fabric->mesh;
    return fabric->element == SS_CNN_TRIANGLE ? mesh->triangle[element]
           : fabric->element == SS_CNN_QUAD   ? mesh->quad[element]
                                              : mesh->tetrahedron[element];
}

static double distance(const double a[3], const double b[3])
{
    double d[3];
    ss_sub3(d, a, b);
    return ss_norm3(d);
}

static void share_triangle(const double *const p[4], ss_cnn_share *share)
{
    double u[3], v[3], n[3], centroid[3];
    for (int k = 0; k < 3; ++k) {
        centroid[k] = (p[0][k] + p[1][k] + p[2][k]) / 3.0;
    }
    for (int s = 0; s < 3; ++s) {
        const double *a = p[s], *b = p[(s + 1) % 3];
        const double midpoint[3] = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
        share->weight[s] = distance(centroid, midpoint) / distance(a, b);
    }
    ss_sub3(u, p[1], p[0]);
    ss_sub3(v, p[2], p[0]);
    ss_cross3(n, u, v);
    for (int c = 0; c < 3; ++c) {
        share->size[c] = 0.5 * ss_norm3(n) / 3.0;
    }
}

static void share_quad(const double *const p[4], ss_cnn_share *share)
{
    double length[4];
    for (int s = 0; s < 4; ++s) {
        length[s] = distance(p[s], p[(s + 1) % 4]);
    }
    for (int s = 0; s < 4; ++s) {
        const double before = length[(s + 3) % 4], after = length[(s + 1) % 4];
        share->weight[s] = 0.25 * (before + after) / length[s];
        share->size[s] = 0.25 * before * length[s];
    }
}

static void share_tetrahedron(const double *const p[4], ss_cnn_share *share)
{
    double a[3], b[3], c[3], n[3];
    for (int s = 0; s < 6; ++s) {
        const int8_t *end = share->side[s];
        const double *k = p[share->side[5 - s][0]], *l = p[share->side[5 - s][1]];
        ss_sub3(a, k, p[end[0]]);
        ss_sub3(b, l, p[end[1]]);
        ss_add3(a, a, b);
        ss_sub3(b, l, k);
        ss_cross3(n, a, b);
        share->weight[s] = ss_norm3(n) / 24.0 / distance(p[end[0]], p[end[1]]);
    }
    ss_sub3(a, p[1], p[0]);
    ss_sub3(b, p[2], p[0]);
    ss_sub3(c, p[3], p[0]);
    ss_cross3(n, a, b);
    for (int corner = 0; corner < 4; ++corner) {
        share->size[corner] = fabs(ss_dot3(n, c)) / 24.0;
    }
}

/* ---- the material direction ---- */

/* |cosine| of the direction against the mean of two sides that run the same way. */
static double nearness(const double d[3], const double *const p[4], int a, int b, int e, int f)
{
    double mean[3], other[3];
    ss_sub3(mean, p[b], p[a]);
    ss_sub3(other, p[f], p[e]);
    ss_add3(mean, mean, other);
    return ss_normalize3(mean) > 0.0 ? fabs(ss_dot3(d, mean)) : 0.0;
}

static void align_quad(const double *direction, const double *const p[4], ss_cnn_share *share)
{
    const bool is_turned =
        direction && nearness(direction, p, 1, 2, 0, 3) > nearness(direction, p, 0, 1, 3, 2);
    for (int s = 0; s < 4; ++s) {
        share->along[s] = (s % 2 == 1) == is_turned ? 1.0 : 0.0;
    }
}

/* Projects into the plane; false when nothing is left. */
static bool project(const double direction[3], const double *const p[4], double out[3])
{
    double n[3];
    ss_normal3(n, p[0], p[1], p[2]);
    ss_copy3(out, direction);
    if (ss_normalize3(n) > 0.0) {
        ss_madd3(out, direction, -ss_dot3(direction, n), n);
    }
    return ss_normalize3(out) > UPRIGHT;
}

static void align_simplex(const double direction[3], bool is_plane, const double *const p[4],
                          ss_cnn_share *share)
{
    double d[3];
    ss_copy3(d, direction);
    const bool has_direction = !is_plane || project(direction, p, d);
    for (int s = 0; s < share->sides; ++s) {
        double side[3];
        ss_sub3(side, p[share->side[s][1]], p[share->side[s][0]]);
        ss_normalize3(side);
        const double cosine = ss_dot3(d, side);
        share->along[s] = has_direction ? cosine * cosine : 0.5;
    }
}

static void align(const ss_cnn_fabric *fabric, int32_t element, const double *const p[4],
                  ss_cnn_share *share)
{
    const double *direction =
        fabric->per_element ? fabric->per_element[element] : fabric->direction;
    if (!fabric->rho_across) {
        for (int s = 0; s < share->sides; ++s) {
            share->along[s] = 1.0;
        }
    } else if (fabric->element == SS_CNN_QUAD) {
        align_quad(direction, p, share);
    } else {
        align_simplex(direction, fabric->element == SS_CNN_TRIANGLE, p, share);
    }
}

void ss_cnn_element_share(const ss_cnn_fabric *fabric, int32_t element, ss_cnn_share *out_share)
{
    const element_kind *kind = &kinds[fabric->element];
    const int32_t *node = element_nodes(fabric, element);
    const double *p[4] = {NULL};
    *out_share = (ss_cnn_share){.corners = kind->corners, .sides = kind->sides};
    memcpy(out_share->side, kind->side, sizeof kind->side);
    for (int c = 0; c < kind->corners; ++c) {
        out_share->node[c] = node[c];
        p[c] = fabric->mesh->position[node[c]];
    }
    if (fabric->element == SS_CNN_TRIANGLE) {
        share_triangle(p, out_share);
    } else if (fabric->element == SS_CNN_QUAD) {
        share_quad(p, out_share);
    } else {
        share_tetrahedron(p, out_share);
    }
    align(fabric, element, p, out_share);
}

void ss_cnn_cell_sizes(const ss_cnn_fabric *fabric, double *out_size)
{
    for (int32_t i = 0; i < fabric->mesh->node_count; ++i) {
        out_size[i] = -1.0;
    }
    for (int32_t e = 0; e < ss_cnn_element_count(fabric); ++e) {
        ss_cnn_share share;
        ss_cnn_element_share(fabric, e, &share);
        for (int c = 0; c < share.corners; ++c) {
            double *size = &out_size[share.node[c]];
            *size = fmax(*size, 0.0) + share.size[c];
        }
    }
}

/* ---- edges ---- */

/* A side of an element, its nodes ascending. */
typedef struct element_side {
    int32_t i, j, element;
    int32_t side;
} element_side;

static int compare_sides(const void *a, const void *b)
{
    const element_side *x = a, *y = b;
    const int by_ends = ss_order_then(ss_order_int(x->i, y->i), ss_order_int(x->j, y->j));
    return ss_order_then(by_ends, ss_order_int(x->element, y->element));
}

/* Sides of all elements, sorted, so that those of one edge are neighbours. */
static element_side *sorted_sides(const ss_cnn_fabric *fabric, int64_t count, ss_arena *scratch)
{
    const element_kind *kind = &kinds[fabric->element];
    element_side *side = ss_arena_get(scratch, (size_t)count, sizeof *side);
    for (int64_t h = 0; side && h < count; ++h) {
        const int32_t element = (int32_t)(h / kind->sides), s = (int32_t)(h % kind->sides);
        const int32_t *node = element_nodes(fabric, element);
        const int32_t i = node[kind->side[s][0]], j = node[kind->side[s][1]];
        side[h] = (element_side){i < j ? i : j, i < j ? j : i, element, s};
    }
    if (side) {
        qsort(side, (size_t)count, sizeof *side, compare_sides);
    }
    return side;
}

static softsim_status allocate_edges(ss_cnn_network *network, int32_t count)
{
    ss_cnn_edges *edges = &network->edges;
    ss_arena *arena = &network->arena;
    const int32_t padded = (count + 7) / 8 * 8;
    const size_t size = (size_t)padded;
    edges->count = count;
    edges->padded_count = padded;
    SS_ARENA_TAKE(arena, SS_ROOM(size, edges->from), SS_ROOM(size, edges->to),
                  SS_ROOM(size, edges->x), SS_ROOM(size, edges->y), SS_ROOM(size, edges->z),
                  SS_ROOM(size, network->edge_weight), SS_ROOM(size, network->edge_rho),
                  SS_ROOM(size, network->edge_square));
    return ss_arena_status(arena);
}

/* One edge for each run of equal sides; out_edge[element x sides + side] is its number. */
static softsim_status number_edges(ss_cnn_network *network, const ss_cnn_fabric *fabric,
                                   ss_arena *scratch, int32_t **out_edge)
{
    const int sides = kinds[fabric->element].sides;
    const int64_t count = (int64_t)sides * ss_cnn_element_count(fabric);
    element_side *side = sorted_sides(fabric, count, scratch);
    int32_t *edge_of = *out_edge = ss_arena_get(scratch, (size_t)count, sizeof *edge_of);
    int32_t edge_count = 0, e = -1;
    for (int64_t h = 0; side && h < count; ++h) {
        edge_count += h == 0 || side[h].i != side[h - 1].i || side[h].j != side[h - 1].j;
    }
    if (!side || !edge_of || allocate_edges(network, edge_count) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    double sum = 0.0;
    for (int64_t h = 0; h < count; ++h) {
        const int32_t i = side[h].i, j = side[h].j;
        if (h == 0 || i != side[h - 1].i || j != side[h - 1].j) {
            const double *a = fabric->mesh->position[i], *b = fabric->mesh->position[j];
            const double length = distance(a, b);
            ++e;
            network->edges.from[e] = 4 * i;
            network->edges.to[e] = 4 * j;
            network->edges.x[e] = (ss_real)(b[0] - a[0]);
            network->edges.y[e] = (ss_real)(b[1] - a[1]);
            network->edges.z[e] = (ss_real)(b[2] - a[2]);
            network->edge_square[e] = length * length;
            sum += length;
        }
        edge_of[(int64_t)sides * side[h].element + side[h].side] = e;
    }
    network->mean_edge = edge_count > 0 ? sum / edge_count : 0.0;
    return SOFTSIM_OK;
}

static double harmonic(const double *rho, int32_t i, int32_t j)
{
    return 2.0 * rho[i] * rho[j] / (rho[i] + rho[j]);
}

/* From sums over elements, w in edge_weight and w cos^2 in `along` (NULL: isotropic), to c_ij and
 * rho_ij. */
static void set_conduction(ss_cnn_network *network, const ss_cnn_fabric *fabric,
                           const double *along)
{
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        const double w = network->edge_weight[e], base = harmonic(fabric->rho, i, j);
        double rho = base;
        if (along && w > 0.0) {
            const double across = harmonic(fabric->rho_across, i, j);
            rho = (along[e] * base + (w - along[e]) * across) / w;
            network->edge_weight[e] = w * rho / base;
        }
        network->edge_rho[e] = fabric->element == SS_CNN_TETRAHEDRON ? w * rho : rho;
        network->largest_rho = fmax(network->largest_rho, rho);
    }
}

softsim_status ss_cnn_network_build_edges(ss_cnn_network *network, const ss_cnn_fabric *fabric)
{
    int32_t *edge = NULL;
    double *along = NULL;
    ss_arena scratch = {0};
    softsim_status status = number_edges(network, fabric, &scratch, &edge);
    if (status == SOFTSIM_OK && fabric->rho_across) {
        along = ss_arena_get(&scratch, (size_t)network->edges.count, sizeof *along);
        status = ss_arena_status(&scratch);
    }
    const int32_t *next = edge;
    for (int32_t k = 0; status == SOFTSIM_OK && k < ss_cnn_element_count(fabric); ++k) {
        ss_cnn_share share;
        ss_cnn_element_share(fabric, k, &share);
        for (int s = 0; s < share.sides; ++s, ++next) {
            network->edge_weight[*next] += share.weight[s];
            if (along) {
                along[*next] += share.weight[s] * share.along[s];
            }
        }
    }
    if (status == SOFTSIM_OK) {
        set_conduction(network, fabric, along);
    }
    ss_arena_free(&scratch);
    return status;
}

/* An edge far shorter than the rest makes a template that no step can follow. */
bool ss_cnn_network_edges_are_usable(const ss_cnn_network *network, const ss_mesh *mesh,
                                     softsim_error *error)
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
            bad, ss_mesh_file_node(mesh, network->edges.from[first] / 4),
            ss_mesh_file_node(mesh, network->edges.to[first] / 4));
    }
    return bad == 0;
}
