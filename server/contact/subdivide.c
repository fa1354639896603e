/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Rows of the level-2 Loop points of each triangle over its control nodes.
 *
 * Loop's rules (C. Loop, Smooth subdivision surfaces based on triangles, 1987), boundary rules of
 * Hoppe et al. 1994, level by level, on rows instead of positions:
 *   edge point      3/8 (a + b) + 1/8 (c + d);            boundary: 1/2 (a + b)
 *   vertex, valence n   (1 - n beta) v + beta sum ring,  beta = (5/8 - (3/8 + cos(2 pi/n)/4)^2)/n
 *   boundary vertex     3/4 v + 1/8 (its two boundary neighbours)
 * Where a body touches itself in a node or an edge, each fan of triangles that goes on through one
 * piece of the body (ss_mesh_pair_sides) is a corner of its own, over the nodes of that fan. All
 * coefficients are >= 0, each row sums to 1, and level 2 of a triangle depends on its corners'
 * one-rings alone.
 *
 *   2            Level-1 points: A_k of the corners, E_k,j on the edges from corner k to its j-th
 *   |\           ring node; M_k = E_k,p_k is the middle of side k -> k + 1, p_k the ring index of
 *   M2 M1        corner k + 1. Rings are counter-clockwise, so corner k + 2 is at p_k + 1, the node
 *   |  | \       across side k at p_k - 1 of corner k and p + 2 of corner k + 1.
 *   0-M0--1
 *
 * The corners are turned so that the largest valence triple comes first, and the controls listed
 * in ring order; triangles of equal topology then get equal matrices, which are stored once
 * (measured: a liver of 2996 triangles has 19, 16 kB instead of 2.3 MB of float). Rejected: rows of
 * every sample (64 x 12 instead of 15 x 12), and the limit surface, whose rows are not sparser
 * and whose extraordinary nodes need eigenvectors.
 */
#include <math.h>
#include <string.h>

#include "contact/surface.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- half-edges ---- */

static int32_t next_half(int32_t half)
{
    return half % 3 == 2 ? half - 2 : half + 1;
}

static int32_t prev_half(int32_t half)
{
    return half % 3 == 0 ? half + 2 : half - 1;
}

static int32_t origin_of(const ss_edges *edges, int32_t half)
{
    return edges->triangle[half / 3][half % 3];
}

static softsim_status check_valence(const ss_mesh *mesh, int32_t *valence, softsim_error *error)
{
    for (int32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        valence[mesh->triangle[i / 3][i % 3]]++;
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (valence[i] > SS_MAX_VALENCE) {
            softsim_error_add(error, SOFTSIM_ERROR_MESH,
                              "node %d has %d triangles around it, more than %d: softsim-mesh "
                              "remesh makes fewer of them",
                              ss_mesh_file_node(mesh, i), valence[i], SS_MAX_VALENCE);
            return SOFTSIM_ERROR_MESH;
        }
    }
    return SOFTSIM_OK;
}

static softsim_status link_twins(ss_edges *edges, const ss_mesh *mesh, softsim_error *error)
{
    int32_t unpaired = -1;
    if (!ss_mesh_pair_sides(mesh, edges->twin, &unpaired)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    if (unpaired >= 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "the triangles at the edge of nodes %d and %d are not wound in turn: "
                          "make the surface manifold and its winding consistent",
                          ss_mesh_file_node(mesh, origin_of(edges, unpaired)),
                          ss_mesh_file_node(mesh, origin_of(edges, next_half(unpaired))));
        return SOFTSIM_ERROR_MESH;
    }
    return SOFTSIM_OK;
}

/* Numbers the fans in the order of their first triangles. */
static void number_fans(ss_edges *edges)
{
    const int32_t half_count = 3 * edges->triangle_count;
    memset(edges->fan, -1, (size_t)half_count * sizeof *edges->fan);
    for (int32_t start = 0; start < half_count; ++start) {
        if (edges->fan[start] >= 0) {
            continue;
        }
        int32_t half = start;
        do {
            edges->fan[half] = edges->fan_count;
            half = edges->twin[prev_half(half)];
        } while (half >= 0 && half != start);
        int32_t back = half < 0 ? edges->twin[start] : -1;
        while (back >= 0) {
            edges->fan[next_half(back)] = edges->fan_count;
            back = edges->twin[next_half(back)];
        }
        ++edges->fan_count;
    }
}

softsim_status ss_edges_init(ss_edges *edges, const ss_mesh *mesh, softsim_error *error)
{
    *edges = (ss_edges){.triangle_count = mesh->triangle_count,
                        .triangle = (const int32_t(*)[3])mesh->triangle};
    edges->twin = ss_memory_get(3 * (size_t)mesh->triangle_count, sizeof(int32_t));
    edges->fan = ss_memory_get(3 * (size_t)mesh->triangle_count, sizeof(int32_t));
    int32_t *valence = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t));
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (edges->twin != NULL && edges->fan != NULL && valence != NULL) {
        status = check_valence(mesh, valence, error);
        if (status == SOFTSIM_OK) {
            status = link_twins(edges, mesh, error);
        }
    }
    ss_memory_free(valence);
    if (status == SOFTSIM_OK) {
        number_fans(edges);
    } else {
        ss_edges_fini(edges);
    }
    return status;
}

void ss_edges_fini(ss_edges *edges)
{
    ss_memory_free(edges->twin);
    ss_memory_free(edges->fan);
    edges->twin = NULL;
    edges->fan = NULL;
}

/* ---- one triangle ---- */

/* The nodes around a corner, counter-clockwise; from boundary to boundary where there is one. */
typedef struct ring {
    int32_t count;
    int32_t next; /* index of the triangle's next corner */
    bool is_boundary;
    int32_t local[SS_MAX_VALENCE + 1]; /* mesh nodes, then control indices */
} ring;

typedef struct builder {
    const ss_edges *edges;
    int32_t fan[3];
    int32_t control_count;
    int32_t control[SS_MAX_CONTROLS];
    ring ring[3];
    double corner[3][SS_MAX_CONTROLS];                   /* A_k */
    double edge[3][SS_MAX_VALENCE + 1][SS_MAX_CONTROLS]; /* E_k,j */
    double point[SS_GRID_POINTS][SS_MAX_CONTROLS];
} builder;

static int grid_index(int i, int j)
{
    return 5 * j - j * (j - 1) / 2 + i;
}

/* Walks the triangles around the origin of `start`. */
static void walk_ring(const ss_edges *edges, int32_t start, ring *out)
{
    int32_t back[SS_MAX_VALENCE + 1];
    int32_t back_count = 0;
    int32_t ahead[SS_MAX_VALENCE + 2];
    int32_t ahead_count = 0;
    int32_t triangles = 0;
    int32_t half = start;
    ahead[ahead_count++] = origin_of(edges, next_half(start));
    do {
        triangles++;
        ahead[ahead_count++] = origin_of(edges, prev_half(half));
        half = edges->twin[prev_half(half)];
    } while (half >= 0 && half != start && triangles < SS_MAX_VALENCE);
    out->is_boundary = half < 0;
    if (!out->is_boundary) {
        ahead_count--; /* the first again */
    } else {
        half = edges->twin[start];
        while (half >= 0 && triangles < SS_MAX_VALENCE) {
            triangles++;
            half = next_half(half);
            back[back_count++] = origin_of(edges, next_half(half));
            half = edges->twin[half];
        }
    }
    out->count = back_count + ahead_count;
    out->next = back_count;
    for (int32_t j = 0; j < back_count; ++j) {
        out->local[j] = back[back_count - 1 - j];
    }
    memcpy(out->local + back_count, ahead, (size_t)ahead_count * sizeof(int32_t));
}

static int32_t control_index(builder *b, int32_t node)
{
    for (int32_t i = 0; i < b->control_count; ++i) {
        if (b->control[i] == node) {
            return i;
        }
    }
    b->control[b->control_count] = node;
    return b->control_count++;
}

/* The first corner: the one from which the valence triple is largest; boundary counts first. */
static int first_corner(const ss_edges *edges, int32_t t)
{
    int32_t key[3];
    for (int k = 0; k < 3; ++k) {
        ring around;
        walk_ring(edges, 3 * t + k, &around);
        key[k] = around.count + (around.is_boundary ? 1000 + 100 * around.next : 0);
    }
    int best = 0;
    for (int k = 1; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) {
            const int32_t mine = key[(k + c) % 3];
            const int32_t other = key[(best + c) % 3];
            if (mine != other) {
                best = mine > other ? k : best;
                break;
            }
        }
    }
    return best;
}

static void collect_controls(builder *b, int32_t t)
{
    const int first = first_corner(b->edges, t);
    b->control_count = 0;
    for (int k = 0; k < 3; ++k) {
        control_index(b, b->edges->triangle[t][(first + k) % 3]);
        b->fan[k] = b->edges->fan[3 * t + (first + k) % 3];
    }
    for (int k = 0; k < 3; ++k) {
        ring *around = &b->ring[k];
        walk_ring(b->edges, 3 * t + (first + k) % 3, around);
        for (int32_t j = 0; j < around->count; ++j) {
            around->local[j] = control_index(b, around->local[j]);
        }
    }
}

static void add_row(const builder *b, double *out, double s, const double *row)
{
    for (int32_t i = 0; i < b->control_count; ++i) {
        out[i] += s * row[i];
    }
}

static void clear_row(const builder *b, double *out)
{
    memset(out, 0, (size_t)b->control_count * sizeof(double));
}

static double loop_beta(int32_t valence)
{
    const double turn = 2.0 * SS_PI / valence;
    const double inner = 0.375 + 0.25 * cos(turn);
    return valence == 6 ? 0.0625 : (0.625 - inner * inner) / valence;
}

/* Level 1: A_k and E_k,j as rows. */
static void level_one(builder *b)
{
    for (int k = 0; k < 3; ++k) {
        const ring *around = &b->ring[k];
        const int32_t n = around->count;
        double *corner = b->corner[k];
        clear_row(b, corner);
        if (around->is_boundary) {
            corner[k] = 0.75;
            corner[around->local[0]] += 0.125;
            corner[around->local[n - 1]] += 0.125;
        } else {
            const double beta = loop_beta(n);
            corner[k] = 1.0 - n * beta;
            for (int32_t j = 0; j < n; ++j) {
                corner[around->local[j]] += beta;
            }
        }
        for (int32_t j = 0; j < n; ++j) {
            double *edge = b->edge[k][j];
            clear_row(b, edge);
            const bool is_open = around->is_boundary && (j == 0 || j == n - 1);
            edge[k] += is_open ? 0.5 : 0.375;
            edge[around->local[j]] += is_open ? 0.5 : 0.375;
            if (!is_open) {
                edge[around->local[(j + n - 1) % n]] += 0.125;
                edge[around->local[(j + 1) % n]] += 0.125;
            }
        }
    }
}

/* Level 2, at a corner: the vertex rule once more. */
static void corner_point(builder *b, int k, double *out)
{
    const ring *around = &b->ring[k];
    const int32_t n = around->count;
    clear_row(b, out);
    if (around->is_boundary) {
        add_row(b, out, 0.75, b->corner[k]);
        add_row(b, out, 0.125, b->edge[k][0]);
        add_row(b, out, 0.125, b->edge[k][n - 1]);
    } else {
        const double beta = loop_beta(n);
        add_row(b, out, 1.0 - n * beta, b->corner[k]);
        for (int32_t j = 0; j < n; ++j) {
            add_row(b, out, beta, b->edge[k][j]);
        }
    }
}

/* 3/8 (a + b) + 1/8 (c + d), or their middle where the edge has one triangle. */
static void edge_point(const builder *b, const double *p, const double *q, const double *c,
                       const double *d, double *out)
{
    clear_row(b, out);
    add_row(b, out, d != NULL ? 0.375 : 0.5, p);
    add_row(b, out, d != NULL ? 0.375 : 0.5, q);
    if (d != NULL) {
        add_row(b, out, 0.125, c);
        add_row(b, out, 0.125, d);
    }
}

/* Level 2 on side k -> k + 1: the middle and the two quarter points. */
static void side_points(builder *b, int k, double *quarter, double *middle, double *three_quarter)
{
    const int l = (k + 1) % 3;
    const int m = (k + 2) % 3;
    const ring *rk = &b->ring[k];
    const ring *rl = &b->ring[l];
    const double *side = b->edge[k][rk->next];
    const double *to_k = b->edge[m][b->ring[m].next]; /* M of side m -> k */
    const double *to_m = b->edge[l][rl->next];        /* M of side l -> m */
    const bool is_open = rk->is_boundary && rk->next == 0;
    const double *across_k = is_open ? NULL : b->edge[k][(rk->next + rk->count - 1) % rk->count];
    const double *across_l = is_open ? NULL : b->edge[l][(rl->next + 2) % rl->count];
    edge_point(b, b->corner[k], side, to_k, across_k, quarter);
    edge_point(b, side, b->corner[l], to_m, across_l, three_quarter);
    clear_row(b, middle);
    if (is_open) {
        add_row(b, middle, 0.75, side);
        add_row(b, middle, 0.125, b->corner[k]);
        add_row(b, middle, 0.125, b->corner[l]);
    } else {
        const double *around[6] = {b->corner[k], b->corner[l], to_k, to_m, across_k, across_l};
        add_row(b, middle, 0.625, side);
        for (int j = 0; j < 6; ++j) {
            add_row(b, middle, 0.0625, around[j]);
        }
    }
}

static void level_two(builder *b)
{
    static const uint8_t corner_at[3][2] = {{0, 0}, {4, 0}, {0, 4}};
    static const uint8_t side_at[3][3][2] = {
        {{1, 0}, {2, 0}, {3, 0}}, {{3, 1}, {2, 2}, {1, 3}}, {{0, 3}, {0, 2}, {0, 1}}};
    static const uint8_t inner_at[3][2] = {{1, 1}, {2, 1}, {1, 2}};
    for (int k = 0; k < 3; ++k) {
        double *side[3];
        for (int s = 0; s < 3; ++s) {
            side[s] = b->point[grid_index(side_at[k][s][0], side_at[k][s][1])];
        }
        corner_point(b, k, b->point[grid_index(corner_at[k][0], corner_at[k][1])]);
        side_points(b, k, side[0], side[1], side[2]);
        const int m = (k + 2) % 3;
        const int l = (k + 1) % 3;
        edge_point(b, b->edge[k][b->ring[k].next], b->edge[m][b->ring[m].next], b->corner[k],
                   b->edge[l][b->ring[l].next],
                   b->point[grid_index(inner_at[k][0], inner_at[k][1])]);
    }
}

/* Without subdivision: the three corners are the only points. */
static void linear_points(builder *b, const ss_edges *edges, int32_t t)
{
    b->control_count = 3;
    for (int p = 0; p < SS_GRID_POINTS; ++p) {
        clear_row(b, b->point[p]);
    }
    for (int k = 0; k < 3; ++k) {
        b->control[k] = edges->triangle[t][k];
        b->fan[k] = edges->fan[3 * t + k];
        b->point[k][k] = 1.0;
    }
}

/* ---- all triangles ---- */

/* Grows `*data` to hold `need` elements, keeping `used`. */
static bool grow(void **data, int64_t used, int64_t need, int64_t *capacity, size_t size)
{
    if (need <= *capacity) {
        return true;
    }
    const int64_t wanted = 2 * need + 64;
    void *larger = ss_memory_get((size_t)wanted, size);
    if (larger == NULL) {
        return false;
    }
    if (*data != NULL) {
        memcpy(larger, *data, (size_t)used * size);
        ss_memory_free(*data);
    }
    *data = larger;
    *capacity = wanted;
    return true;
}

typedef struct shelf {
    int64_t control_used, control_capacity, row_used, row_capacity, patch_capacity;
    int32_t *slot; /* hash table of patch numbers, -1 empty */
    uint64_t mask;
} shelf;

static uint64_t hash_rows(const ss_real *row, int64_t count)
{
    uint64_t hash = SS_HASH_START;
    for (int64_t i = 0; i < count; ++i) {
        uint64_t bits = 0;
        memcpy(&bits, &row[i], sizeof row[i]);
        hash = ss_hash_word(hash, bits);
    }
    return hash;
}

/* The number of the patch with these rows: an equal one that is there already, or a new one.
 * -1: out of memory. The candidate's rows stand at row_used. */
static int32_t shelve_patch(ss_surface *surface, shelf *s, int32_t control_count)
{
    const ss_real *rows = surface->coefficient + s->row_used * SS_GRID_ROW;
    const int64_t count = (int64_t)control_count * SS_GRID_ROW;
    uint64_t at = hash_rows(rows, count) & s->mask;
    for (; s->slot[at] >= 0; at = (at + 1) & s->mask) {
        const ss_patch *patch = &surface->patch[s->slot[at]];
        const ss_real *other = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
        if (patch->control_count == control_count &&
            memcmp(other, rows, (size_t)count * sizeof(ss_real)) == 0) {
            return s->slot[at];
        }
    }
    if (!grow((void **)&surface->patch, surface->patch_count, surface->patch_count + 1,
              &s->patch_capacity, sizeof(ss_patch))) {
        return -1;
    }
    surface->patch[surface->patch_count] = (ss_patch){control_count, (int32_t)s->row_used};
    s->row_used += control_count;
    s->slot[at] = surface->patch_count;
    return surface->patch_count++;
}

static bool store_triangle(const builder *b, ss_surface *surface, shelf *s, int32_t t)
{
    if (!grow((void **)&surface->control, s->control_used, s->control_used + b->control_count,
              &s->control_capacity, sizeof(int32_t)) ||
        !grow((void **)&surface->coefficient, s->row_used * SS_GRID_ROW,
              (s->row_used + b->control_count) * SS_GRID_ROW, &s->row_capacity, sizeof(ss_real))) {
        return false;
    }
    memcpy(surface->control + s->control_used, b->control,
           (size_t)b->control_count * sizeof(int32_t));
    memcpy(surface->fan[t], b->fan, sizeof b->fan);
    s->control_used += b->control_count;
    surface->control_first[t + 1] = (int32_t)s->control_used;
    ss_real *row = surface->coefficient + s->row_used * SS_GRID_ROW;
    for (int32_t i = 0; i < b->control_count; ++i, row += SS_GRID_ROW) {
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            row[p] = (ss_real)b->point[p][i];
        }
        row[SS_GRID_POINTS] = 0;
    }
    surface->patch_of[t] = shelve_patch(surface, s, b->control_count);
    return surface->patch_of[t] >= 0;
}

softsim_status ss_subdivide(const ss_edges *edges, const int32_t *triangle, bool is_linear,
                            ss_surface *surface)
{
    shelf s = {.mask = 63};
    while (s.mask < 2 * (uint64_t)surface->triangle_count) {
        s.mask = 2 * s.mask + 1;
    }
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    builder *b = ss_memory_get(1, sizeof(builder));
    s.slot = ss_memory_get((size_t)s.mask + 1, sizeof(int32_t));
    if (b == NULL || s.slot == NULL) {
        goto done;
    }
    memset(s.slot, -1, ((size_t)s.mask + 1) * sizeof(int32_t));
    b->edges = edges;
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        if (is_linear) {
            linear_points(b, edges, triangle[t]);
        } else {
            collect_controls(b, triangle[t]);
            level_one(b);
            level_two(b);
        }
        if (!store_triangle(b, surface, &s, t)) {
            goto done;
        }
    }
    status = SOFTSIM_OK;
done:
    ss_memory_free(s.slot);
    ss_memory_free(b);
    return status;
}
