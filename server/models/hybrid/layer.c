/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/layer.h"
/*
 * Rows of the particle layer, all by moving least squares on rest positions X:
 *
 *   weight     w(r) = (1 - (r/h)^2)^3, h = 1.95 (d_i + d_j)/2 for spacings d; neighbours to 0.8 h
 *   moment     A_i = sum_j w X_ij X_ij^T;  F_i = I + (sum_j u_ij (w X_ij)^T) A_i^-1
 *   tie        x_p = sum_i T_pi x_i over core nodes, sum T = 1, sum T X = X_p
 *   skin       x_s = sum_p S_sp x_p over particles, with the same sums
 *
 * Every row reproduces affine maps exactly, whatever the distances. With p = (1, X - X_p) and M =
 * sum w p p^T the weights of a row are w p . M^-1 e_1. Inside a tetrahedron the tie is barycentric.
 * The paper's eq. (7) as printed, a kernel integral that is neither normalised nor corrected, is
 * not even exact for a translation near a boundary; that is the reason for these rows.
 *
 * Volumes. A place of the lattice stands for d^3; the sum over the layer is scaled to the volume
 * that is really between core and surface, so that stiffness and mass do not depend on how the
 * lattice falls. Ghosts keep d^3, as far as their tetrahedron can give it: they take over at most
 * 95 % of it.
 */
#include <math.h>
#include <string.h>

#include "models/hybrid/point_grid.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Neighbours that a gradient needs, and places within the whole support that a particle needs. */
#define MIN_NEIGHBOURS 6
#define MIN_PLACES     10
/* Largest sum of a row's absolute weights: how far it may extrapolate. */
#define TIE_LIMIT   8.0
#define SKIN_LIMIT  3.0
#define GHOST_SHARE 0.95 /* of a tetrahedron's volume */
/* More take minutes to set up; a layer of a hundredth of them is what a hand feels in time. */
enum { MAX_PARTICLES = 1 << 20 };

/* ---- small systems ---- */

/* a := Cholesky factor of the symmetric n x n matrix (n <= 4); false where a pivot falls below
 * `least` times what it was. */
static bool factor(int n, double a[4][4], double least)
{
    for (int j = 0; j < n; ++j) {
        const double before = a[j][j];
        for (int k = 0; k < j; ++k) {
            a[j][j] -= a[j][k] * a[j][k];
        }
        if (!(a[j][j] > least * before) || !(before > 0.0)) {
            return false;
        }
        a[j][j] = sqrt(a[j][j]);
        for (int i = j + 1; i < n; ++i) {
            for (int k = 0; k < j; ++k) {
                a[i][j] -= a[i][k] * a[j][k];
            }
            a[i][j] /= a[j][j];
        }
    }
    return true;
}

bool ss_layer_fit_row(const double at[3], int32_t count, const double (*x)[3], const double *square,
                      double limit, double *out_weight)
{
    double m[4][4] = {{0}};
    double farthest = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        farthest = fmax(farthest, square[i]);
    }
    const double h2 = 1.2 * farthest;
    const double h = sqrt(h2);
    for (int32_t i = 0; i < count; ++i) {
        const double w = pow(1.0 - square[i] / h2, 3.0);
        const double p[4] = {1.0, (x[i][0] - at[0]) / h, (x[i][1] - at[1]) / h,
                             (x[i][2] - at[2]) / h};
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b <= a; ++b) {
                m[a][b] += w * p[a] * p[b];
            }
        }
    }
    double c[4] = {1.0, 0.0, 0.0, 0.0};
    if (!factor(4, m, 1e-3)) {
        return false;
    }
    ss_solve_cholesky(4, m[0], 4, c);
    double reach = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        const double w = pow(1.0 - square[i] / h2, 3.0);
        out_weight[i] =
            w *
            (c[0] +
             (c[1] * (x[i][0] - at[0]) + c[2] * (x[i][1] - at[1]) + c[3] * (x[i][2] - at[2])) / h);
        reach += fabs(out_weight[i]);
    }
    return reach < limit;
}

/* ---- the set-up's own state ---- */

typedef struct builder {
    const ss_layer_plan *plan;
    const ss_mesh *mesh;
    ss_layer *layer;
    ss_layer_sites sites;
    int32_t core_count;
    int32_t *core_node;    /* number in the mesh */
    double (*core_x)[3];   /* m */
    int32_t *around_first; /* by core node: the tetrahedra around it */
    int32_t *around;
    ss_point_grid core_grid, grid; /* of core nodes, of particles */
    ss_arena scratch;
} builder;

/* Core nodes, the tetrahedra around each, and the skin's nodes; false when out of memory. */
static bool sort_nodes(builder *b)
{
    const ss_mesh *mesh = b->mesh;
    ss_layer *layer = b->layer;
    const size_t nodes = (size_t)mesh->node_count;
    ss_arena *arena = &layer->arena, *scratch = &b->scratch;
    int32_t *core_of = ss_arena_get(scratch, nodes, sizeof *core_of);
    layer->skin_of = ss_arena_get(arena, nodes, sizeof *layer->skin_of);
    layer->skin_node = ss_arena_get(arena, nodes, sizeof *layer->skin_node);
    SS_ARENA_TAKE(scratch, SS_ROOM(nodes, b->core_node), SS_ROOM(nodes, b->core_x),
                  SS_ROOM(nodes + 2, b->around_first),
                  SS_ROOM(4 * (size_t)mesh->tetrahedron_count, b->around));
    const bool is_good =
        ss_arena_status(arena) == SOFTSIM_OK && ss_arena_status(scratch) == SOFTSIM_OK;
    for (int32_t c = 0; is_good && c < 4 * mesh->tetrahedron_count; ++c) {
        core_of[mesh->tetrahedron[c / 4][c % 4]] = 1;
    }
    for (int32_t i = 0; is_good && i < mesh->node_count; ++i) {
        layer->skin_of[i] = core_of[i] ? -1 : layer->skin_count;
        if (core_of[i]) {
            b->core_node[b->core_count] = i;
            ss_copy3(b->core_x[b->core_count], mesh->position[i]);
            core_of[i] = b->core_count++;
        } else {
            layer->skin_node[layer->skin_count++] = i;
        }
    }
    for (int32_t c = 0; is_good && c < 4 * mesh->tetrahedron_count; ++c) {
        ++b->around_first[core_of[mesh->tetrahedron[c / 4][c % 4]] + 2];
    }
    for (int32_t i = 0; is_good && i < b->core_count; ++i) {
        b->around_first[i + 2] += b->around_first[i + 1];
    }
    for (int32_t c = 0; is_good && c < 4 * mesh->tetrahedron_count; ++c) {
        b->around[b->around_first[core_of[mesh->tetrahedron[c / 4][c % 4]] + 1]++] = c / 4;
    }
    return is_good &&
           ss_point_grid_init(&b->core_grid, b->core_count, (const double(*)[3])b->core_x,
                              2.0 * b->plan->spacing, scratch);
}

/* ---- particles ---- */

static double reach_of(double d_i, double d_j)
{
    return SS_LAYER_SUPPORT * 0.5 * (d_i + d_j);
}

static bool reserve_particles(ss_layer *layer, int32_t most)
{
    const size_t n = (size_t)most;
    ss_arena *arena = &layer->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(n, layer->rest), SS_ROOM(n, layer->spacing),
                  SS_ROOM(n, layer->volume), SS_ROOM(n, layer->host),
                  SS_ROOM(n + 1, layer->pair_first), SS_ROOM(8 * n, layer->moment),
                  SS_ROOM(n + 1, layer->tie_first));
    return ss_arena_status(arena) == SOFTSIM_OK;
}

static void add_particle(ss_layer *layer, const ss_layer_site *site)
{
    const int32_t p = layer->count++;
    ss_copy3(layer->rest[p], site->x);
    layer->spacing[p] = site->spacing;
    layer->volume[p] = site->spacing * site->spacing * site->spacing;
    layer->host[p] = site->host;
}

/* The layer's own particles, then the places in tetrahedra within two neighbourhoods of one: those
 * next to the layer share its stiffness, and they need neighbours too. */
static bool take_sites(builder *b)
{
    ss_layer *layer = b->layer;
    const double far = 2.0 * reach_of(b->plan->spacing, b->plan->spacing);
    ss_point_grid own;
    for (int32_t s = 0; s < b->sites.count; ++s) {
        if (b->sites.site[s].host < 0) {
            add_particle(layer, &b->sites.site[s]);
        }
    }
    layer->own_count = layer->count;
    if (!ss_point_grid_init(&own, layer->own_count, (const double(*)[3])layer->rest, far,
                            &b->scratch)) {
        return false;
    }
    for (int32_t s = 0; s < b->sites.count; ++s) {
        const ss_layer_site *site = &b->sites.site[s];
        int32_t nearest;
        double square;
        if (site->host >= 0 &&
            ss_point_grid_nearest(&own, site->x, 1, far, &nearest, &square) == 1 &&
            sqrt(square) <= 2.0 * reach_of(site->spacing, layer->spacing[nearest])) {
            add_particle(layer, site);
        }
    }
    return true;
}

/* m; cells of this size hold few particles wherever they are, also beside far coarser ones. */
static double finest_reach(const ss_layer *layer)
{
    double finest = INFINITY;
    for (int32_t p = 0; p < layer->count; ++p) {
        finest = fmin(finest, layer->spacing[p]);
    }
    return reach_of(finest, finest);
}

/* Particles within `share` of the support of particle p, nearest first; how many. */
static int32_t find_neighbours(const builder *b, int32_t p, double share,
                               int32_t out[SS_LAYER_MAX_PAIRS], double square[SS_LAYER_MAX_PAIRS])
{
    const ss_layer *layer = b->layer;
    const double widest = reach_of(layer->spacing[p], b->plan->spacing);
    const int32_t found =
        ss_point_grid_nearest(&b->grid, layer->rest[p], SS_LAYER_MAX_PAIRS, widest, out, square);
    int32_t count = 0;
    for (int32_t k = 0; k < found; ++k) {
        const double reach = share * reach_of(layer->spacing[p], layer->spacing[out[k]]);
        if (out[k] != p && square[k] < reach * reach) {
            out[count] = out[k];
            square[count++] = square[k];
        }
    }
    return count;
}

static double weight(double square, double reach)
{
    const double s = 1.0 - square / (reach * reach);
    return s * s * s;
}

/* moment[8] of particle p; false where its neighbours do not span space. */
static bool fill_moment(const ss_layer *layer, int32_t p, int32_t count, const int32_t *neighbour,
                        const double *square, ss_real *moment)
{
    double a[4][4] = {{0}};
    double spread = 0.0;
    double sum = 0.0;
    for (int32_t k = 0; k < count; ++k) {
        const int32_t q = neighbour[k];
        const double w = weight(square[k], reach_of(layer->spacing[p], layer->spacing[q]));
        double x[3];
        ss_sub3(x, layer->rest[q], layer->rest[p]);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j <= i; ++j) {
                a[i][j] += w * x[i] * x[j];
            }
        }
        spread += w * square[k];
        sum += w;
    }
    memset(moment, 0, 8 * sizeof *moment);
    if (count < MIN_NEIGHBOURS || !factor(3, a, 0.05)) {
        return false;
    }
    static const int place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (int j = 0; j < 3; ++j) {
        double column[4] = {j == 0, j == 1, j == 2, 0};
        ss_solve_cholesky(3, a[0], 4, column);
        for (int i = 0; i < 3; ++i) {
            moment[place[i][j]] = (ss_real)column[i];
        }
    }
    moment[6] = (ss_real)(1.0 / spread);
    moment[7] = (ss_real)sum;
    return true;
}

/* Takes out own particles that have no good neighbourhood, as long as there are any; false when
 * out of memory. */
static bool drop_lonely(builder *b)
{
    ss_layer *layer = b->layer;
    int32_t neighbour[SS_LAYER_MAX_PAIRS];
    double square[SS_LAYER_MAX_PAIRS];
    for (bool is_done = false; !is_done;) {
        is_done = true;
        if (!ss_point_grid_init(&b->grid, layer->count, (const double(*)[3])layer->rest,
                                finest_reach(layer), &b->scratch)) {
            return false;
        }
        int32_t kept = 0;
        const int32_t own = layer->own_count;
        for (int32_t p = 0; p < own; ++p) {
            ss_real moment[8];
            const int32_t count = find_neighbours(b, p, 1.0, neighbour, square);
            /* Marked in the volume: the grid still points to the places of all. */
            if (count < MIN_PLACES || !fill_moment(layer, p, count, neighbour, square, moment)) {
                layer->volume[p] = 0.0;
                is_done = false;
            }
        }
        for (int32_t p = 0; p < layer->count && !is_done; ++p) {
            if (layer->volume[p] > 0.0) {
                ss_copy3(layer->rest[kept], layer->rest[p]);
                layer->spacing[kept] = layer->spacing[p];
                layer->volume[kept] = layer->volume[p];
                layer->host[kept++] = layer->host[p];
            } else {
                --layer->own_count;
                ++layer->dropped_count;
            }
        }
        layer->count = is_done ? layer->count : kept;
    }
    return true;
}

/* Of p's neighbours those that have p among theirs, as `first` and `all` list them; how many. Where
 * spacings differ by four or more, a list of the nearest ends before the pair does at one end. */
static int32_t keep_mutual(const int32_t *first, const int32_t *all, int32_t p, int32_t count,
                           int32_t *neighbour, double *square)
{
    int32_t kept = 0;
    for (int32_t k = 0; k < count; ++k) {
        const int32_t q = neighbour[k];
        int32_t at = first[q];
        while (at < first[q + 1] && all[at] != p) {
            ++at;
        }
        if (at < first[q + 1]) {
            neighbour[kept] = q;
            square[kept++] = square[k];
        }
    }
    return kept;
}

static void fill_pairs(ss_layer *layer, int32_t p, int32_t count, const int32_t *neighbour,
                       const double *square)
{
    for (int32_t k = 0; k < count; ++k) {
        const int64_t at = layer->pair_first[p] + k;
        const int32_t q = neighbour[k];
        const double w = weight(square[k], reach_of(layer->spacing[p], layer->spacing[q]));
        layer->neighbour[at] = q;
        for (int i = 0; i < 3; ++i) {
            layer->pair[4 * at + i] = (ss_real)(w * (layer->rest[q][i] - layer->rest[p][i]));
        }
        layer->pair[4 * at + 3] = (ss_real)w;
        layer->pair_scale[at] = (ss_real)(1.0 / (w * square[k]));
    }
    layer->pair_first[p + 1] = layer->pair_first[p] + count;
}

static bool join_neighbours(builder *b)
{
    ss_layer *layer = b->layer;
    int32_t neighbour[SS_LAYER_MAX_PAIRS];
    double square[SS_LAYER_MAX_PAIRS];
    ss_arena *arena = &layer->arena;
    int32_t *first = ss_arena_get(&b->scratch, (size_t)layer->count + 1, sizeof *first);
    for (int32_t p = 0; first != NULL && p < layer->count; ++p) {
        first[p + 1] = first[p] + find_neighbours(b, p, SS_LAYER_CUT, neighbour, square);
    }
    const size_t pairs = first != NULL ? (size_t)first[layer->count] : 0;
    int32_t *all = ss_arena_get(&b->scratch, pairs, sizeof *all);
    SS_ARENA_TAKE(arena, SS_ROOM(pairs, layer->neighbour), SS_ROOM(4 * pairs, layer->pair),
                  SS_ROOM(pairs, layer->pair_scale));
    const bool is_good =
        ss_arena_status(arena) == SOFTSIM_OK && ss_arena_status(&b->scratch) == SOFTSIM_OK;
    for (int32_t p = 0; is_good && p < layer->count; ++p) {
        const int32_t count = find_neighbours(b, p, SS_LAYER_CUT, neighbour, square);
        memcpy(all + first[p], neighbour, (size_t)count * sizeof *all);
    }
    for (int32_t p = 0; is_good && p < layer->count; ++p) {
        const int32_t found = find_neighbours(b, p, SS_LAYER_CUT, neighbour, square);
        const int32_t count = keep_mutual(first, all, p, found, neighbour, square);
        fill_moment(layer, p, count, neighbour, square, layer->moment + 8 * (int64_t)p);
        fill_pairs(layer, p, count, neighbour, square);
    }
    return is_good;
}

/* ---- ties ---- */

/* Barycentric coordinates in (or beyond) tetrahedron e; returns the least. */
static double barycentric(const ss_mesh *mesh, int32_t e, const double x[3], double out[4])
{
    const int32_t *node = mesh->tetrahedron[e];
    double d[4][3], row[3][3];
    for (int a = 0; a < 3; ++a) {
        ss_sub3(d[a], mesh->position[node[a + 1]], mesh->position[node[0]]);
    }
    ss_sub3(d[3], x, mesh->position[node[0]]);
    ss_cross3(row[0], d[1], d[2]);
    ss_cross3(row[1], d[2], d[0]);
    ss_cross3(row[2], d[0], d[1]);
    const double determinant = ss_dot3(d[0], row[0]);
    out[0] = 1.0;
    for (int a = 0; a < 3; ++a) {
        out[a + 1] = ss_dot3(row[a], d[3]) / determinant;
        out[0] -= out[a + 1];
    }
    return fmin(fmin(out[0], out[1]), fmin(out[2], out[3]));
}

/* The tetrahedron around one of the nearest nodes that extrapolates least to x. */
static int32_t choose_host(const builder *b, const double x[3], int32_t count, const int32_t *core)
{
    double best = -INFINITY;
    int32_t host = -1;
    for (int32_t k = 0; k < count && k < 4; ++k) {
        for (int32_t c = b->around_first[core[k]]; c < b->around_first[core[k] + 1]; ++c) {
            double share[4];
            const double least = barycentric(b->mesh, b->around[c], x, share);
            if (least > best) {
                best = least;
                host = b->around[c];
            }
        }
    }
    return host;
}

typedef struct tie_row {
    int32_t count;
    int32_t node[SS_LAYER_TIE]; /* of the mesh */
    double weight[SS_LAYER_TIE];
} tie_row;

static void tie_inside(const builder *b, int32_t host, const double x[3], tie_row *out)
{
    out->count = 4;
    memcpy(out->node, b->mesh->tetrahedron[host], 4 * sizeof *out->node);
    barycentric(b->mesh, host, x, out->weight);
}

/* The row of a place outside the core; returns its host. */
static int32_t tie_outside(const builder *b, const double at[3], tie_row *out)
{
    int32_t core[SS_LAYER_TIE];
    double square[SS_LAYER_TIE], x[SS_LAYER_TIE][3];
    out->count = ss_point_grid_nearest(&b->core_grid, at, SS_LAYER_TIE, INFINITY, core, square);
    for (int32_t k = 0; k < out->count; ++k) {
        ss_copy3(x[k], b->core_x[core[k]]);
        out->node[k] = b->core_node[core[k]];
    }
    const int32_t host = choose_host(b, at, out->count, core);
    if (!ss_layer_fit_row(at, out->count, (const double(*)[3])x, square, TIE_LIMIT, out->weight)) {
        tie_inside(b, host, at, out);
    }
    return host;
}

static void put_row(const tie_row *from, int32_t *first, int32_t *node, ss_real *weight)
{
    for (int32_t k = 0; k < from->count; ++k) {
        node[first[0] + k] = from->node[k];
        weight[first[0] + k] = (ss_real)from->weight[k];
    }
    first[1] = first[0] + from->count;
}

static bool tie_all(builder *b)
{
    ss_layer *layer = b->layer;
    const size_t ghosts = (size_t)(layer->count - layer->own_count);
    const size_t most = SS_LAYER_TIE * (size_t)layer->own_count + 4 * ghosts;
    const size_t most_skin = SS_LAYER_TIE * (size_t)layer->skin_count;
    ss_arena *arena = &layer->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(most, layer->tie_node), SS_ROOM(most, layer->tie),
                  SS_ROOM((size_t)layer->skin_count + 1, layer->skin_tie_first),
                  SS_ROOM(most_skin, layer->skin_tie_node), SS_ROOM(most_skin, layer->skin_tie));
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return false;
    }
    tie_row at;
    for (int32_t p = 0; p < layer->count; ++p) {
        if (p < layer->own_count) {
            layer->host[p] = tie_outside(b, layer->rest[p], &at);
        } else {
            tie_inside(b, layer->host[p], layer->rest[p], &at);
        }
        put_row(&at, layer->tie_first + p, layer->tie_node, layer->tie);
    }
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        tie_outside(b, b->mesh->position[layer->skin_node[s]], &at);
        double reach = 0.0;
        for (int32_t k = 0; k < at.count; ++k) {
            reach += fabs(at.weight[k]);
        }
        layer->far_count += reach > TIE_LIMIT;
        layer->farthest_tie = fmax(layer->farthest_tie, reach);
        put_row(&at, layer->skin_tie_first + s, layer->skin_tie_node, layer->skin_tie);
    }
    return true;
}

/* ---- skin ---- */

enum { SKIN_MOST = 4 * SS_LAYER_SKIN };

/* Row of a skin node: 16 particles, more where those would extrapolate too far. 0: none does. Too
 * few give contact a weak hold where the lattice ends in a small step. */
static int32_t fit_skin(const builder *b, int32_t node, int32_t out_particle[SKIN_MOST],
                        double out_weight[SKIN_MOST])
{
    double square[SKIN_MOST], x[SKIN_MOST][3];
    for (int32_t most = SS_LAYER_SKIN; most <= SKIN_MOST; most *= 2) {
        const int32_t count = ss_point_grid_nearest(&b->grid, b->mesh->position[node], most,
                                                    INFINITY, out_particle, square);
        for (int32_t k = 0; k < count; ++k) {
            ss_copy3(x[k], b->layer->rest[out_particle[k]]);
        }
        if (ss_layer_fit_row(b->mesh->position[node], count, (const double(*)[3])x, square,
                             most < SKIN_MOST ? SKIN_LIMIT : TIE_LIMIT, out_weight)) {
            return count;
        }
    }
    return 0;
}

static softsim_status fit_all_skin(builder *b, softsim_error *error)
{
    ss_layer *layer = b->layer;
    const size_t most = SKIN_MOST * (size_t)layer->skin_count;
    int32_t lost = 0;
    ss_arena *arena = &layer->arena;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)layer->skin_count + 1, layer->skin_first),
                  SS_ROOM(most, layer->skin_particle), SS_ROOM(most, layer->skin));
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        double row[SKIN_MOST];
        const int32_t first = layer->skin_first[s];
        const int32_t count = fit_skin(b, layer->skin_node[s], layer->skin_particle + first, row);
        for (int32_t k = 0; k < count; ++k) {
            layer->skin[first + k] = (ss_real)row[k];
        }
        layer->skin_first[s + 1] = first + count;
        lost += count == 0;
    }
    if (lost > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "layer.spacing_m: %d nodes of the outer surface are too far from every "
                          "particle; give a finer spacing",
                          lost);
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
}

/* ---- volumes ---- */

static double tetrahedron_volume(const ss_mesh *mesh, int32_t e)
{
    const int32_t *node = mesh->tetrahedron[e];
    double d[3][3], cross[3];
    for (int a = 0; a < 3; ++a) {
        ss_sub3(d[a], mesh->position[node[a + 1]], mesh->position[node[0]]);
    }
    ss_cross3(cross, d[1], d[2]);
    return fabs(ss_dot3(d[0], cross)) / 6.0;
}

static double enclosed_volume(const ss_mesh *mesh)
{
    double volume = 0.0;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double x[3][3], cross[3];
        for (int a = 0; a < 3; ++a) {
            ss_sub3(x[a], mesh->position[mesh->triangle[t][a]], mesh->position[0]);
        }
        ss_cross3(cross, x[1], x[2]);
        volume += ss_dot3(x[0], cross) / 6.0;
    }
    return volume;
}

static softsim_status share_volume(builder *b, softsim_error *error)
{
    ss_layer *layer = b->layer;
    const ss_mesh *mesh = b->mesh;
    double *room = ss_arena_get(&b->scratch, (size_t)mesh->tetrahedron_count, sizeof *room);
    double *taken = ss_arena_get(&b->scratch, (size_t)mesh->tetrahedron_count, sizeof *taken);
    double sum = 0.0;
    layer->layer_volume = enclosed_volume(mesh);
    for (int32_t e = 0; room != NULL && e < mesh->tetrahedron_count; ++e) {
        room[e] = tetrahedron_volume(mesh, e);
        layer->layer_volume -= room[e];
    }
    for (int32_t p = 0; p < layer->own_count; ++p) {
        sum += layer->volume[p];
    }
    softsim_status status = ss_arena_status(&b->scratch);
    const double scale = layer->layer_volume / sum;
    if (status == SOFTSIM_OK && !(scale > 0.5 && scale < 2.0)) {
        status = SOFTSIM_ERROR_SCENE;
        softsim_error_add(error, status,
                          "layer.spacing_m: %d particles of %g m do not fill a layer of %g m^3; "
                          "give a spacing of at most a third of the layer's thickness",
                          layer->own_count, b->plan->spacing, layer->layer_volume);
    }
    for (int32_t p = 0; p < layer->own_count; ++p) {
        layer->volume[p] *= scale;
    }
    for (int32_t p = layer->own_count; status == SOFTSIM_OK && p < layer->count; ++p) {
        taken[layer->host[p]] += layer->volume[p];
    }
    for (int32_t p = layer->own_count; status == SOFTSIM_OK && p < layer->count; ++p) {
        const int32_t e = layer->host[p];
        layer->volume[p] *= fmin(1.0, GHOST_SHARE * room[e] / taken[e]);
    }
    return status;
}

/* ---- the whole ---- */

static softsim_status build(builder *b, softsim_error *error)
{
    softsim_status status = ss_layer_list_sites(b->plan, &b->sites, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    int32_t own = 0;
    for (int32_t s = 0; s < b->sites.count; ++s) {
        own += b->sites.site[s].host < 0;
    }
    if (own > MAX_PARTICLES) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "layer.spacing_m: %g m fills the layer with %d particles, more than %d; "
                          "give a coarser spacing, or a thinner layer",
                          b->plan->spacing, own, MAX_PARTICLES);
        return SOFTSIM_ERROR_SCENE;
    }
    if (!sort_nodes(b) || !reserve_particles(b->layer, b->sites.count) || !take_sites(b) ||
        !drop_lonely(b)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    if (b->layer->own_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "layer.spacing_m: no particle finds a place between core and surface; "
                          "give a spacing of at most a third of the layer's thickness");
        return SOFTSIM_ERROR_SCENE;
    }
    if (!join_neighbours(b) || !tie_all(b)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    status = share_volume(b, error);
    return status == SOFTSIM_OK ? fit_all_skin(b, error) : status;
}

softsim_status ss_layer_create(const ss_layer_plan *plan, ss_layer **out_layer,
                               softsim_error *error)
{
    *out_layer = NULL;
    builder b = {.plan = plan, .mesh = plan->mesh, .layer = ss_memory_get(1, sizeof(ss_layer))};
    softsim_status status = b.layer != NULL ? build(&b, error) : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory for a layer of %d places", b.sites.count);
    }
    ss_memory_free(b.sites.site);
    ss_arena_free(&b.scratch);
    if (status != SOFTSIM_OK) {
        ss_layer_destroy(&b.layer);
    }
    *out_layer = b.layer;
    return status;
}

void ss_layer_destroy(ss_layer **layer_pointer)
{
    ss_layer *layer = layer_pointer != NULL ? *layer_pointer : NULL;
    if (layer == NULL) {
        return;
    }
    ss_arena_free(&layer->arena);
    ss_memory_free(layer);
    *layer_pointer = NULL;
}
