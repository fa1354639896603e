/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/coarse.h"
/*
 * The hats of the coarse level, Phi: which elements a cell carries, and with which weights.
 *
 * Within blocks of up to 48 elements (neighbours on a space-filling curve) hats are replaced by
 * their best linear fits, which still sum to 1: the kernels then work with four moments a block and
 * cost 13 us instead of 35 on 5762 elements and 64 cells, and a poke's shape is no worse for it.
 * Phi of coarse.c is the fitted one throughout.
 */
#include <math.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* Radius of a hat over the spacing of the cells. */
#define HAT_RADIUS 1.8
/* A hat is cut off below. */
#define LEAST_WEIGHT 0.01
/* Of a block's extent over the spacing, squared: no slope is fitted across what is flatter. */
#define RIDGE 1e-4

static double distance(const ss_mesh *mesh, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, mesh->position[a], mesh->position[b]);
    return ss_norm3(d);
}

/* Elements as far apart as can be: each new one is the farthest from those before it. Returns the
 * mean distance of a seed to its nearest. */
static double choose_seeds(const ss_mesh *mesh, int32_t count, int32_t *seed, double *nearest)
{
    int32_t next = 0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        nearest[i] = (double)INFINITY;
    }
    for (int32_t s = 0; s < count; ++s) {
        seed[s] = next;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            nearest[i] = fmin(nearest[i], distance(mesh, i, seed[s]));
            next = nearest[i] > nearest[next] ? i : next;
        }
    }
    double sum = 0.0;
    for (int32_t s = 0; s < count; ++s) {
        double least = (double)INFINITY;
        for (int32_t t = 0; t < count; ++t) {
            least = t == s ? least : fmin(least, distance(mesh, seed[s], seed[t]));
        }
        sum += least / count;
    }
    return sum;
}

static int32_t pad_up(int32_t count, int32_t to)
{
    return (count + to - 1) / to * to;
}

/* Half the elements of a cell, so that a hat is nearly linear over a block. */
static int32_t block_size(int32_t node_count, int32_t cells)
{
    const int32_t size = node_count / (4 * cells) * 2;
    return size < 4 ? 4 : size < SS_CHAIN_MAX_BLOCK ? size : SS_CHAIN_MAX_BLOCK;
}

/* Elements into blocks along the curve; places about each block's middle. */
static softsim_status build_blocks(ss_chain_coarse *coarse, const ss_mesh *mesh, double diagonal,
                                   ss_arena *arena)
{
    const int32_t n = mesh->node_count;
    ss_chain_hats *hats = &coarse->hats;
    hats->cell_count = coarse->row;
    hats->block_count = pad_up(n, hats->block) / hats->block;
    const size_t padded = (size_t)hats->block_count * (size_t)hats->block;
    int32_t *order = ss_memory_get((size_t)n, sizeof *order);
    hats->node = ss_arena_get(arena, padded, sizeof *hats->node);
    hats->taking_part = ss_arena_get(arena, padded, sizeof *hats->taking_part);
    hats->nobody = 4 * n;
    SS_ARENA_TAKE(arena, SS_ROOM(3 * padded, hats->place),
                  SS_ROOM((size_t)hats->block_count + 1, hats->first),
                  SS_ROOM((size_t)n, coarse->slot));
    const bool is_good =
        order && ss_arena_status(arena) == SOFTSIM_OK &&
        ss_mesh_curve_order(n, (const double(*)[3])mesh->position, diagonal, order);
    for (int32_t s = 0; is_good && s < (int32_t)padded; ++s) {
        hats->node[s] = 4 * (s < n ? order[s] : n);
        hats->taking_part[s] = hats->nobody;
        if (s < n) {
            coarse->slot[order[s]] = s;
        }
    }
    ss_memory_free(order);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* Weights of one element over all seeds, summing to 1. */
static void weigh(const ss_mesh *mesh, int32_t node, int32_t count, const int32_t *seed,
                  double radius, double *out_weight)
{
    int32_t nearest = 0;
    double sum = 0.0, least = (double)INFINITY;
    for (int32_t s = 0; s < count; ++s) {
        const double r = distance(mesh, node, seed[s]);
        nearest = r < least ? s : nearest;
        least = fmin(least, r);
        const double w = r < radius ? (1.0 - r / radius) * (1.0 - r / radius) : 0.0;
        out_weight[s] = w > LEAST_WEIGHT ? w : 0.0;
        sum += out_weight[s];
    }
    out_weight[nearest] = sum > 0.0 ? out_weight[nearest] : 1.0; /* beyond every hat */
    for (int32_t s = 0; s < count && sum > 0.0; ++s) {
        out_weight[s] /= sum;
    }
}

/* A block while its hats are fitted: basis 1, x, y, z of its elements, and the inverse of the
 * normal equations. */
typedef struct fit {
    int32_t count;
    double basis[SS_CHAIN_MAX_BLOCK][4];
    double inverse[4][4];
} fit;

/* Gauss-Jordan; positive definite thanks to the ridge. */
static void invert4(double a[4][4], double out[4][4])
{
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 4; ++k) {
            out[i][k] = i == k;
        }
    }
    for (int p = 0; p < 4; ++p) {
        const double pivot = 1.0 / a[p][p];
        for (int k = 0; k < 4; ++k) {
            a[p][k] *= pivot;
            out[p][k] *= pivot;
        }
        for (int i = 0; i < 4; ++i) {
            const double factor = i == p ? 0.0 : a[i][p];
            for (int k = 0; k < 4; ++k) {
                a[i][k] -= factor * a[p][k];
                out[i][k] -= factor * out[p][k];
            }
        }
    }
}

/* In units of the spacing; blocks in a plane or line have no slope across it. */
static void begin_fit(ss_chain_coarse *coarse, const ss_mesh *mesh, int32_t block, fit *out)
{
    ss_chain_hats *hats = &coarse->hats;
    const ptrdiff_t at = (ptrdiff_t)block * hats->block;
    const ptrdiff_t left = mesh->node_count - at;
    double middle[3] = {0.0, 0.0, 0.0}, normal[4][4] = {{0.0}};
    out->count = (int32_t)(left < hats->block ? left : hats->block);
    for (int32_t i = 0; i < out->count; ++i) {
        ss_madd3(middle, middle, 1.0 / out->count, mesh->position[hats->node[at + i] / 4]);
    }
    for (int32_t i = 0; i < out->count; ++i) {
        out->basis[i][0] = 1.0;
        for (int k = 0; k < 3; ++k) {
            out->basis[i][k + 1] =
                (mesh->position[hats->node[at + i] / 4][k] - middle[k]) / coarse->spacing;
            hats->place[3 * (at + i) + k] = (ss_real)out->basis[i][k + 1];
        }
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < 4; ++b) {
                normal[a][b] += out->basis[i][a] * out->basis[i][b];
            }
        }
    }
    for (int k = 1; k < 4; ++k) {
        normal[k][k] += RIDGE * out->count;
    }
    invert4(normal, out->inverse);
}

/* Coefficients of the cell whose weights at the block's elements are `weight`. */
static void fit_cell(const fit *from, const double *weight, ss_real out[4])
{
    double moment[4] = {0.0};
    for (int32_t i = 0; i < from->count; ++i) {
        for (int a = 0; a < 4; ++a) {
            moment[a] += weight[i] * from->basis[i][a];
        }
    }
    for (int a = 0; a < 4; ++a) {
        double c = 0.0;
        for (int b = 0; b < 4; ++b) {
            c += from->inverse[a][b] * moment[b];
        }
        out[a] = (ss_real)c;
    }
}

/* Fits block after block; the first time only counts the entries. */
static void fit_blocks(ss_chain_coarse *coarse, const ss_mesh *mesh, const int32_t *seed,
                       double *weight, bool is_counting)
{
    ss_chain_hats *hats = &coarse->hats;
    const int32_t cells = coarse->cells;
    for (int32_t b = 0; b < hats->block_count; ++b) {
        fit now;
        int32_t entry = hats->first[b];
        begin_fit(coarse, mesh, b, &now);
        for (int32_t i = 0; i < now.count; ++i) {
            weigh(mesh, hats->node[b * hats->block + i] / 4, cells, seed,
                  HAT_RADIUS * coarse->spacing, weight + (ptrdiff_t)i * cells);
        }
        for (int32_t c = 0; c < cells; ++c) {
            double column[SS_CHAIN_MAX_BLOCK], sum = 0.0;
            for (int32_t i = 0; i < now.count; ++i) {
                column[i] = weight[(ptrdiff_t)i * cells + c];
                sum += column[i];
            }
            if (sum > 0.0) {
                if (!is_counting) {
                    hats->cell[entry] = 4 * c;
                    fit_cell(&now, column, hats->linear + 4 * (ptrdiff_t)entry);
                }
                ++entry;
            }
        }
        hats->first[b + 1] = entry;
    }
}

/* Phi of every element from the fits. */
static void tabulate(ss_chain_coarse *coarse)
{
    const ss_chain_hats *hats = &coarse->hats;
    double *weight = coarse->weight;
    for (int32_t b = 0; b < hats->block_count; ++b) {
        coarse->first[b] = weight - coarse->weight;
        for (int32_t i = 0; i < hats->block; ++i) {
            const ss_real *place = hats->place + 3 * ((ptrdiff_t)b * hats->block + i);
            for (int32_t e = hats->first[b]; e < hats->first[b + 1]; ++e) {
                const ss_real *c = hats->linear + 4 * (ptrdiff_t)e;
                *weight++ = (double)c[0] + (double)c[1] * (double)place[0] +
                            (double)c[2] * (double)place[1] + (double)c[3] * (double)place[2];
            }
        }
    }
}

static softsim_status build_hats(ss_chain_coarse *coarse, const ss_mesh *mesh, const int32_t *seed,
                                 ss_arena *arena)
{
    ss_chain_hats *hats = &coarse->hats;
    double *scratch = ss_memory_get((size_t)coarse->cells * SS_CHAIN_MAX_BLOCK, sizeof *scratch);
    if (!scratch) {
        return SOFTSIM_ERROR_MEMORY;
    }
    fit_blocks(coarse, mesh, seed, scratch, true);
    const size_t entries = (size_t)hats->first[hats->block_count];
    SS_ARENA_TAKE(arena, SS_ROOM(entries, hats->cell), SS_ROOM(4 * entries, hats->linear),
                  SS_ROOM(entries * (size_t)hats->block, coarse->weight),
                  SS_ROOM((size_t)hats->block_count, coarse->first));
    const bool is_good = ss_arena_status(arena) == SOFTSIM_OK;
    if (is_good) {
        fit_blocks(coarse, mesh, seed, scratch, false);
        tabulate(coarse);
    }
    ss_memory_free(scratch);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

softsim_status ss_chain_hats_create(ss_chain_coarse *coarse, const ss_mesh *mesh, double diagonal,
                                    ss_arena *arena)
{
    ss_arena scratch = {0};
    int32_t *seed = ss_arena_get(&scratch, (size_t)coarse->cells, sizeof *seed);
    double *nearest = ss_arena_get(&scratch, (size_t)mesh->node_count, sizeof *nearest);
    softsim_status status = ss_arena_status(&scratch);
    if (status == SOFTSIM_OK) {
        coarse->hats.block = block_size(mesh->node_count, coarse->cells);
        coarse->spacing = choose_seeds(mesh, coarse->cells, seed, nearest);
        status = build_blocks(coarse, mesh, diagonal, arena);
    }
    status = status == SOFTSIM_OK ? build_hats(coarse, mesh, seed, arena) : status;
    ss_arena_free(&scratch);
    return status;
}
