/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * A coarse level of cells above the fine ones: "map multiple chain elements to one single neural
 * cell", the paper's future work, read as a second layer.
 *
 *   dP/dt = 1/C (dP + Phi D Phi' dP),  D = lambda (Phi' L Phi)^-1
 *
 * Phi: hat weights (1 - r/(1.8 s))^2 of every chain element over the coarse cells around it, at
 * farthest points with mean spacing s; rows sum to 1, and are 0 for elements that are fixed,
 * driven, under a tool or saturated (D is made for links, and far too large for what draws a cell
 * back by itself). L: the Laplacian of all links with weight w/2, an upper bound of the Hessian of
 * W whatever is slack, and the leak (dP has it too: with the leak on the fine cells alone the
 * equilibrium under a load would be another); lambda its largest eigenvalue. The metric 1 + Phi D
 * Phi' is constant and positive: still a gradient flow of the same W with the same equilibria,
 * stable for h < 2 C/lambda_max((1 + Phi D Phi') L), by power iteration. What the fine network
 * alone spreads by diffusion, at a time that grows with the square of the distance, each coarse
 * step spreads over the body at once.
 *
 * Aggregated cells (`cells: N`) are the same hats used instead of the fine cells: away from tools
 * P = P0 + Phi x and C m_j dx_j/dt = (Phi' dP)_j, m_j the elements of cell j: the drag of the
 * full model, and a descent of the same W. |Phi m^-1 Phi'| <= 1 keeps it stable wherever the fine
 * cells are; its own, longer step follows from power iteration. Elements near tools and driven
 * cells are cells of their own as well, stepped at their own pace while the far field rests (each
 * in turn is a descent), and stay so for a while after.
 *
 * Elements that come under a tool change Phi'LPhi by two outer products each; its inverse is made
 * anew (0.1 ms for 64 cells) at most once an outer step, and elements that a tool has left stay out
 * for a while, so that a slide does not pay it each time. Rejected: a third level (nothing gained),
 * multigrid cycles (no gradient flow of W), Nesterov's momentum (lands on wrong buckled branches).
 *
 * Within blocks of up to 48 elements (neighbours on a space-filling curve) hats are replaced by
 * their best linear fits, which still sum to 1: the kernels then work with four moments a block and
 * cost 13 us instead of 35 on 5762 elements and 64 cells, and a poke's shape is no worse for it.
 * Phi below is the fitted one throughout.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* Radius of a hat over the spacing of the cells. */
#define HAT_RADIUS 1.8
/* A hat is cut off below. */
#define LEAST_WEIGHT 0.01
/* Sub-steps that an element stays out after a tool has left it. */
enum { LINGER = 50 };
/* Outer steps that an element stays a cell of its own; links around what pushes that do. */
enum { OWN_LINGER = 300, OWN_LINKS = 3 };
/* Of the aggregated cells' rate: elements under tools sharpen Phi. */
#define AGGREGATE_MARGIN 1.3
/* Power iterations, and what the result is raised by for not having converged. */
enum { POWER_ITERATIONS = 60 };
#define POWER_MARGIN 1.03
/* Of a block's extent over the spacing, squared: no slope is fitted across what is flatter. */
#define RIDGE 1e-4
/* A cell's diagonal below this share of the largest has no element left that may move. */
#define DEAD_SHARE 1e-9

struct ss_chain_coarse {
    bool is_aggregated;
    double rate;    /* 1/s of the aggregated cells alone */
    int32_t *own;   /* of an element: steps that it is a cell of its own for; aggregated */
    int32_t *queue; /* those elements; scratch of finding them */
    int32_t own_count;
    int32_t cells, row; /* row: padded to a multiple of 4 */
    double spacing;     /* m */
    double lambda;      /* of L for the mean capacitance */
    ss_chain_hats hats;
    int32_t *slot;       /* of an element: block x hats.block + place in it */
    double *weight;      /* Phi: of an element (by slot), one for each entry of its block */
    int64_t *first;      /* of a block's weights */
    ss_real *mask;       /* 1 where an element takes part, quads */
    int32_t *out, *idle; /* elements left out, and for how long without need */
    int32_t out_count;
    bool is_stale;                   /* the inverse is of another matrix */
    double *base, *matrix;           /* Phi'LPhi without tools, and now; cells x cells */
    double *factor, *solved;         /* scratch of the inverse */
    ss_real *base_inverse, *inverse; /* D, rows of `row` */
    ss_real *gathered, *moved;       /* a quad a cell */
};

int32_t ss_chain_coarse_cells(const ss_chain_coarse *coarse)
{
    return coarse->cells;
}

const ss_chain_hats *ss_chain_coarse_hats(const ss_chain_coarse *coarse)
{
    return &coarse->hats;
}

int64_t ss_chain_coarse_bytes(const ss_chain_coarse *coarse)
{
    const ss_chain_hats *hats = &coarse->hats;
    const int64_t entries = hats->first[hats->block_count], cells = coarse->cells;
    const int64_t nodes = (int64_t)hats->block_count * hats->block;
    return entries * (int64_t)(4 * sizeof(ss_real) + sizeof(int32_t)) +
           entries * hats->block * (int64_t)sizeof(double) +
           nodes * (int64_t)(7 * sizeof(ss_real) + 2 * sizeof(int32_t)) +
           (coarse->is_aggregated
                ? cells * (int64_t)sizeof(ss_real)
                : cells * cells * (int64_t)(4 * sizeof(double)) +
                      2 * (int64_t)coarse->row * coarse->row * (int64_t)sizeof(ss_real));
}

/* ---- hats ---- */

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

typedef struct key {
    uint64_t place;
    int32_t node;
} key;

static int compare(const void *a, const void *b)
{
    const key *x = a, *y = b;
    return x->place != y->place ? (x->place > y->place) - (x->place < y->place)
                                : (x->node > y->node) - (x->node < y->node);
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
    key *order = ss_memory_get((size_t)n, sizeof *order);
    hats->node = ss_arena_get(arena, padded, sizeof *hats->node);
    hats->taking_part = ss_arena_get(arena, padded, sizeof *hats->taking_part);
    hats->nobody = 4 * n;
    hats->place = ss_arena_get(arena, 3 * padded, sizeof *hats->place);
    hats->first = ss_arena_get(arena, (size_t)hats->block_count + 1, sizeof *hats->first);
    coarse->slot = ss_arena_get(arena, (size_t)n, sizeof *coarse->slot);
    const bool is_good = order && ss_arena_status(arena) == SOFTSIM_OK;
    double low[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; is_good && i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            low[k] = i == 0 ? mesh->position[i][k] : fmin(low[k], mesh->position[i][k]);
        }
    }
    for (int32_t i = 0; is_good && i < n; ++i) {
        order[i] = (key){ss_mesh_curve_place(mesh->position[i], low, diagonal), i};
    }
    if (is_good) {
        qsort(order, (size_t)n, sizeof *order, compare);
    }
    for (int32_t s = 0; is_good && s < (int32_t)padded; ++s) {
        hats->node[s] = 4 * (s < n ? order[s].node : n);
        hats->taking_part[s] = hats->nobody;
        if (s < n) {
            coarse->slot[order[s].node] = s;
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
    hats->cell = ss_arena_get(arena, entries, sizeof *hats->cell);
    hats->linear = ss_arena_get(arena, 4 * entries, sizeof *hats->linear);
    coarse->weight = ss_arena_get(arena, entries * (size_t)hats->block, sizeof *coarse->weight);
    coarse->first = ss_arena_get(arena, (size_t)hats->block_count, sizeof *coarse->first);
    const bool is_good = ss_arena_status(arena) == SOFTSIM_OK;
    if (is_good) {
        fit_blocks(coarse, mesh, seed, scratch, false);
        tabulate(coarse);
    }
    ss_memory_free(scratch);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* ---- Phi'LPhi and its inverse ---- */

/* The row of Phi of an element: its weights and the cells (times 4) they are of. */
static const double *row_of(const ss_chain_coarse *coarse, int32_t node, const int32_t **out_cell,
                            int32_t *out_count)
{
    const int32_t slot = coarse->slot[node], block = slot / coarse->hats.block;
    const int32_t first = coarse->hats.first[block];
    *out_cell = coarse->hats.cell + first;
    *out_count = coarse->hats.first[block + 1] - first;
    return coarse->weight + coarse->first[block] +
           (ptrdiff_t)(slot % coarse->hats.block) * *out_count;
}

/* matrix += factor (p q' + q p') over the rows of elements i and j, which may be the same. */
static void add_product(ss_chain_coarse *coarse, int32_t i, int32_t j, double factor)
{
    const int32_t *cell[2];
    int32_t count[2];
    const double *p = row_of(coarse, i, &cell[0], &count[0]);
    const double *q = row_of(coarse, j, &cell[1], &count[1]);
    for (int32_t k = 0; k < count[0]; ++k) {
        for (int32_t l = 0; l < count[1]; ++l) {
            const double value = factor * p[k] * q[l];
            const ptrdiff_t a = cell[0][k] / 4, b = cell[1][l] / 4;
            coarse->matrix[a * coarse->cells + b] += value;
            coarse->matrix[b * coarse->cells + a] += value;
        }
    }
}

static bool takes_part(const ss_chain_coarse *coarse, int32_t node)
{
    return coarse->mask[4 * (ptrdiff_t)node] > 0;
}

/* The share of element i's own row in the sum over links of w/2 (phi_a - phi_b)(phi_a - phi_b)'
 * while all others stay: added when it comes to take part, taken when it no longer does. */
static void add_element(ss_model *model, int32_t node, double sign)
{
    ss_chain_coarse *coarse = model->coarse;
    const ss_chain_net *net = model->net;
    add_product(coarse, node, node, sign * (0.25 * model->valence[node] + 0.5 * model->leak));
    for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
        const int32_t other = ss_chain_other(net, net->at[p], node);
        const double half =
            (double)net->group[net->at[p] / SS_CHAIN_LANES].half[net->at[p] % SS_CHAIN_LANES];
        if (other != node && takes_part(coarse, other)) {
            add_product(coarse, node, other, -sign * half);
        }
    }
}

static void put_mask(ss_chain_coarse *coarse, int32_t node, ss_real value)
{
    for (int k = 0; k < 3; ++k) {
        coarse->mask[4 * (ptrdiff_t)node + k] = value;
    }
    coarse->hats.taking_part[coarse->slot[node]] = value > 0 ? 4 * node : coarse->hats.nobody;
}

/* D into coarse->inverse by Cholesky; cells without an element that may move get a row of 0. */
static void invert(ss_chain_coarse *coarse)
{
    const ptrdiff_t n = coarse->cells;
    double *l = coarse->factor, *x = coarse->solved, largest = 0.0;
    memcpy(l, coarse->matrix, (size_t)(n * n) * sizeof *l);
    for (ptrdiff_t j = 0; j < n; ++j) {
        largest = fmax(largest, l[j * n + j]);
    }
    for (ptrdiff_t j = 0; j < n; ++j) { /* rows of the upper factor, right-looking */
        const double pivot = l[j * n + j];
        const double root = pivot > DEAD_SHARE * largest ? 1.0 / sqrt(pivot) : 0.0;
        for (ptrdiff_t k = j; k < n; ++k) {
            l[j * n + k] *= root;
        }
        for (ptrdiff_t i = j + 1; i < n; ++i) {
            const double factor = l[j * n + i];
            for (ptrdiff_t k = i; k < n; ++k) {
                l[i * n + k] -= factor * l[j * n + k];
            }
        }
    }
    memset(x, 0, (size_t)(n * n) * sizeof *x);
    for (ptrdiff_t j = 0; j < n; ++j) { /* x = U^-T: rows of the lower inverse */
        const double pivot = l[j * n + j] > 0.0 ? 1.0 / l[j * n + j] : 0.0;
        x[j * n + j] += pivot > 0.0;
        for (ptrdiff_t k = 0; k <= j; ++k) {
            x[j * n + k] *= pivot;
        }
        for (ptrdiff_t i = j + 1; i < n; ++i) {
            const double factor = l[j * n + i];
            for (ptrdiff_t k = 0; k <= j; ++k) {
                x[i * n + k] -= factor * x[j * n + k];
            }
        }
    }
    memset(l, 0, (size_t)(n * n) * sizeof *l);
    for (ptrdiff_t m = 0; m < n; ++m) { /* x'x */
        for (ptrdiff_t i = 0; i <= m; ++i) {
            const double factor = x[m * n + i];
            for (ptrdiff_t k = 0; k <= m; ++k) {
                l[i * n + k] += factor * x[m * n + k];
            }
        }
    }
    for (ptrdiff_t i = 0; i < n; ++i) {
        for (ptrdiff_t k = 0; k < n; ++k) {
            coarse->inverse[i * coarse->row + k] = (ss_real)(coarse->lambda * l[i * n + k]);
        }
    }
}

/* ---- eigenvalues ---- */

/* out = L x over the elements that move, L with weights w/2 and the leak. */
static void apply_laplacian(const ss_model *model, const ss_real *x, ss_real *out)
{
    const ss_chain_net *net = model->net;
    memset(out, 0, 4 * (size_t)model->padded * sizeof *out);
    for (int32_t e = 0; e < net->link_count; ++e) {
        const int32_t position = net->position[e];
        const ss_chain_group *group = &net->group[position / SS_CHAIN_LANES];
        const int32_t a = group->a[position % SS_CHAIN_LANES];
        const int32_t b = group->b[position % SS_CHAIN_LANES];
        const ss_real half = group->half[position % SS_CHAIN_LANES];
        for (int k = 0; k < 3; ++k) {
            const ss_real g = half * (x[b + k] - x[a + k]);
            out[a + k] -= g;
            out[b + k] += g;
        }
    }
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        out[at] = model->free[at] * (out[at] + (ss_real)model->leak * x[at]);
    }
}

/* x += scale Phi D Phi' g */
static void spread(ss_model *model, const ss_real *g, double scale, ss_real *x)
{
    ss_chain_coarse *coarse = model->coarse;
    const ss_chain_kernels *kernels = model->kernels;
    kernels->gather(&coarse->hats, g, coarse->gathered);
    if (coarse->is_aggregated) {
        for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)coarse->cells; ++at) {
            coarse->moved[at] = coarse->inverse[at / 4] * coarse->gathered[at];
        }
    } else {
        kernels->apply(coarse->row, coarse->inverse, coarse->gathered, coarse->moved);
    }
    kernels->spread(&coarse->hats, coarse->mask, coarse->moved, (ss_real)scale, x);
}

/* The largest eigenvalue of M L, 1/s: M has the fine cells' C^-1, the coarse level's Phi D Phi'/C,
 * or both. */
static double largest_rate(ss_model *model, bool has_fine, bool has_coarse, ss_real *x, ss_real *y)
{
    double value = 0.0;
    uint64_t random = 1;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        x[at] = model->free[at] * (ss_real)((double)(random >> 11) / 9007199254740992.0 - 0.5);
    }
    for (int m = 0; m < POWER_ITERATIONS; ++m) {
        double square = 0.0;
        apply_laplacian(model, x, y);
        for (int32_t i = 0; i < model->node_count; ++i) {
            for (int k = 0; k < 4; ++k) {
                x[4 * (ptrdiff_t)i + k] =
                    has_fine ? (ss_real)(model->conductance[i] * (double)y[4 * (ptrdiff_t)i + k])
                             : 0;
            }
        }
        if (has_coarse) {
            spread(model, y, 1.0 / model->capacitance, x);
        }
        for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
            square += (double)x[at] * (double)x[at];
        }
        value = sqrt(square);
        for (ptrdiff_t at = 0; value > 0.0 && at < 4 * (ptrdiff_t)model->node_count; ++at) {
            x[at] = (ss_real)((double)x[at] / value);
        }
    }
    return POWER_MARGIN * value;
}

double ss_chain_coarse_rate(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    const size_t n = 4 * (size_t)model->padded;
    ss_real *x = ss_memory_get(n, sizeof *x), *y = ss_memory_get(n, sizeof *y);
    double rate = -1.0;
    if (x && y && coarse->is_aggregated) {
        rate = AGGREGATE_MARGIN * largest_rate(model, false, true, x, y);
        coarse->rate = rate;
    } else if (x && y) {
        coarse->lambda = largest_rate(model, true, false, x, y) * model->capacitance;
        invert(coarse);
        memcpy(coarse->base_inverse, coarse->inverse,
               (size_t)coarse->row * (size_t)coarse->row * sizeof *coarse->inverse);
        rate = largest_rate(model, true, true, x, y);
    }
    ss_memory_free(x);
    ss_memory_free(y);
    return rate;
}

/* ---- life ---- */

static softsim_status allocate(ss_model *model, ss_chain_coarse *coarse)
{
    const size_t cells = (size_t)coarse->cells, row = (size_t)coarse->row;
    const size_t n = (size_t)model->padded;
    ss_arena *arena = &model->arena;
    coarse->mask = ss_arena_get(arena, 4 * n, sizeof *coarse->mask);
    coarse->out = ss_arena_get(arena, n, sizeof *coarse->out);
    coarse->idle = ss_arena_get(arena, n, sizeof *coarse->idle);
    coarse->gathered = ss_arena_get(arena, 4 * row, sizeof *coarse->gathered);
    coarse->moved = ss_arena_get(arena, 4 * row, sizeof *coarse->moved);
    if (coarse->is_aggregated) {
        coarse->inverse = ss_arena_get(arena, row, sizeof *coarse->inverse);
        coarse->own = ss_arena_get(arena, n, sizeof *coarse->own);
        coarse->queue = ss_arena_get(arena, n, sizeof *coarse->queue);
        coarse->solved = ss_arena_get(arena, cells, sizeof *coarse->solved);
    } else {
        coarse->base = ss_arena_get(arena, cells * cells, sizeof *coarse->base);
        coarse->matrix = ss_arena_get(arena, cells * cells, sizeof *coarse->matrix);
        coarse->factor = ss_arena_get(arena, cells * cells, sizeof *coarse->factor);
        coarse->solved = ss_arena_get(arena, cells * cells, sizeof *coarse->solved);
        coarse->inverse = ss_arena_get(arena, row * row, sizeof *coarse->inverse);
        coarse->base_inverse = ss_arena_get(arena, row * row, sizeof *coarse->base_inverse);
    }
    return ss_arena_status(arena);
}

/* Fixed and driven elements take no part; the others make Phi'LPhi, or m. */
static void admit_elements(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    double *sum = coarse->is_aggregated ? coarse->solved : NULL;
    for (int32_t i = 0; i < model->node_count; ++i) {
        const int32_t *cell;
        int32_t count;
        const double *weight = row_of(coarse, i, &cell, &count);
        for (int32_t k = 0; sum && k < count; ++k) {
            sum[cell[k] / 4] += weight[k];
        }
        if (!model->is_bound[i]) {
            if (!sum) {
                add_element(model, i, 1.0);
            }
            put_mask(coarse, i, 1);
        }
    }
    for (int32_t c = 0; sum && c < coarse->cells; ++c) {
        coarse->inverse[c] = (ss_real)(1.0 / fmax(sum[c], 1.0));
    }
}

softsim_status ss_chain_coarse_create(ss_model *model, int32_t cells, bool is_aggregated)
{
    const ss_mesh *mesh = model->plan.mesh;
    ss_chain_coarse *coarse = ss_arena_get(&model->arena, 1, sizeof *coarse);
    int32_t *seed = ss_memory_get((size_t)cells, sizeof *seed);
    double *nearest = ss_memory_get((size_t)mesh->node_count, sizeof *nearest);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    model->coarse = coarse;
    if (coarse && seed && nearest) {
        coarse->is_aggregated = is_aggregated;
        coarse->cells = cells;
        coarse->row = pad_up(cells, 4);
        coarse->hats.block = block_size(mesh->node_count, cells);
        coarse->spacing = choose_seeds(mesh, cells, seed, nearest);
        status = build_blocks(coarse, mesh, model->diagonal, &model->arena);
        status = status == SOFTSIM_OK ? build_hats(coarse, mesh, seed, &model->arena) : status;
    }
    ss_memory_free(seed);
    ss_memory_free(nearest);
    status = status == SOFTSIM_OK ? allocate(model, coarse) : status;
    if (status == SOFTSIM_OK) {
        admit_elements(model);
    }
    if (status == SOFTSIM_OK && !is_aggregated) {
        memcpy(coarse->base, coarse->matrix, (size_t)cells * (size_t)cells * sizeof *coarse->base);
    }
    return status;
}

/* No element is left out any more: back to what was computed at the start, to the last bit. */
static void restore(ss_chain_coarse *coarse)
{
    if (coarse->is_aggregated) {
        return;
    }
    const size_t cells = (size_t)coarse->cells;
    memcpy(coarse->matrix, coarse->base, cells * cells * sizeof *coarse->base);
    memcpy(coarse->inverse, coarse->base_inverse,
           (size_t)coarse->row * (size_t)coarse->row * sizeof *coarse->inverse);
}

void ss_chain_coarse_reset(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    for (int32_t k = 0; k < coarse->out_count; ++k) {
        put_mask(coarse, coarse->out[k], 1);
    }
    coarse->out_count = 0;
    coarse->is_stale = false;
    if (coarse->is_aggregated) {
        memset(coarse->own, 0, (size_t)model->node_count * sizeof *coarse->own);
        memset(model->mobility, 0, 4 * (size_t)model->padded * sizeof *model->mobility);
    }
    restore(coarse);
}

/* ---- a sub-step ---- */

static void change_element(ss_model *model, int32_t node, double sign)
{
    if (!model->coarse->is_aggregated) {
        add_element(model, node, sign);
    }
}

/* From now on an element takes no part. */
static void leave_out(ss_model *model, int32_t node)
{
    ss_chain_coarse *coarse = model->coarse;
    put_mask(coarse, node, 0);
    change_element(model, node, -1.0);
    coarse->out[coarse->out_count] = node;
    coarse->idle[coarse->out_count++] = 0;
}

static bool is_saturated(const ss_model *model, int32_t node)
{
    const ss_real *u = model->u + 4 * (ptrdiff_t)node, *q = model->output + 4 * (ptrdiff_t)node;
    return q[0] != u[0] || q[1] != u[1] || q[2] != u[2];
}

/* Elements under tools or saturated no longer take part, those that have not been for long do
 * again. Aggregated cells need no such care of saturation: their metric is at most 1. */
static void follow_elements(ss_model *model, bool is_first)
{
    ss_chain_coarse *coarse = model->coarse;
    const bool has_saturated = model->is_saturated && !coarse->is_aggregated;
    bool is_changed = false;
    int32_t kept = 0;
    for (int32_t k = 0; k < coarse->out_count; ++k) {
        const int32_t node = coarse->out[k];
        const bool is_out = (model->is_touched && model->is_touched[node]) ||
                            (has_saturated && is_saturated(model, node));
        const int32_t idle = is_out ? 0 : coarse->idle[k] + 1;
        if (idle > LINGER) {
            change_element(model, node, 1.0);
            put_mask(coarse, node, 1);
            is_changed = true;
        } else {
            coarse->out[kept] = node;
            coarse->idle[kept++] = idle;
        }
    }
    coarse->out_count = kept;
    for (int32_t k = 0; k < model->touched_count; ++k) {
        if (takes_part(coarse, model->touched[k])) {
            leave_out(model, model->touched[k]);
            is_changed = true;
        }
    }
    for (int32_t i = 0; has_saturated && i < model->node_count; ++i) {
        if (takes_part(coarse, i) && is_saturated(model, i)) {
            leave_out(model, i);
            is_changed = true;
        }
    }
    coarse->is_stale = (coarse->is_stale || is_changed) && !coarse->is_aggregated;
    if (is_first && coarse->is_stale && coarse->out_count > 0) {
        invert(coarse);
        coarse->is_stale = false;
    } else if (coarse->is_stale && coarse->out_count == 0) {
        restore(coarse);
        coarse->is_stale = false;
    }
}

void ss_chain_coarse_move(ss_model *model, double h, bool is_first)
{
    follow_elements(model, is_first);
    spread(model, model->pull, h / model->capacitance, model->u);
}

/* ---- aggregated cells ---- */

bool ss_chain_is_aggregated(const ss_model *model)
{
    return model->coarse && model->coarse->is_aggregated;
}

void ss_chain_aggregated_slow(ss_model *model, double factor)
{
    model->coarse->rate /= factor;
}

double ss_chain_aggregated_step(const ss_model *model)
{
    return 0.9 * 2.0 / model->coarse->rate;
}

/* An element is a cell of its own from now on for a while. */
static void own(ss_model *model, int32_t node)
{
    ss_chain_coarse *coarse = model->coarse;
    if (coarse->own[node] == 0) {
        for (int k = 0; k < 3; ++k) {
            const ptrdiff_t at = 4 * (ptrdiff_t)node + k;
            model->mobility[at] = (ss_real)model->conductance[node] * model->free[at];
        }
    }
    coarse->own[node] = OWN_LINGER;
}

static void own_around(ss_model *model, const double middle[3], double radius)
{
    const ss_mesh *mesh = model->plan.mesh;
    for (int32_t i = 0; i < model->node_count; ++i) {
        double r[3];
        ss_sub3(r, mesh->position[i], middle);
        if (ss_dot3(r, r) < radius * radius) {
            own(model, i);
        }
    }
}

/* The elements of the sets that move, and those up to so many links away. */
static void own_driven(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    const ss_chain_net *net = model->net;
    int32_t first = 0, count = 0;
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        const ss_prescribed *set = model->driven[s].set.plan;
        for (int32_t i = 0; model->driven[s].is_moving && i < set->node_count; ++i) {
            if (coarse->own[set->node[i]] != OWN_LINGER) {
                own(model, set->node[i]);
                coarse->queue[count++] = set->node[i];
            }
        }
    }
    for (int ring = 0; ring < OWN_LINKS; ++ring) {
        for (const int32_t end = count; first < end; ++first) {
            const int32_t node = coarse->queue[first];
            for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
                const int32_t other = ss_chain_other(net, net->at[p], node);
                if (coarse->own[other] != OWN_LINGER) {
                    own(model, other);
                    coarse->queue[count++] = other;
                }
            }
        }
    }
}

void ss_chain_refine(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    const double reach = OWN_LINKS * model->net->mean_length;
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (coarse->own[i] > 0 && --coarse->own[i] == 0) {
            memset(model->mobility + 4 * (ptrdiff_t)i, 0, 4 * sizeof *model->mobility);
        }
    }
    own_driven(model); /* first: it knows by the count what it has seen */
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        if (tool->is_present) {
            own_around(model, tool->to.position, ss_shape_bounding_radius(tool->shape) + reach);
        }
    }
    coarse->own_count = 0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (coarse->own[i] > 0) {
            coarse->queue[coarse->own_count++] = i;
        }
    }
}

void ss_chain_wake_own(ss_model *model)
{
    for (int32_t k = 0; k < model->coarse->own_count; ++k) {
        ss_chain_wake(model, model->coarse->queue[k]);
    }
}
