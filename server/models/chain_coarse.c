/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain.h"
/*
 * A coarse level of cells above the fine ones: "map multiple chain elements to one single neural
 * cell", the paper's future work, read as a second layer.
 *
 *   dP/dt = 1/C (dP + Phi D Phi' dP),  D = lambda (Phi' L Phi)^-1
 *
 * Phi: hat weights (1 - r/(1.8 s))^2 of every chain element over the coarse cells around it, at
 * farthest points with mean spacing s; rows sum to 1, and are 0 for elements that are fixed, driven
 * or under a tool. L: the Laplacian of all links with weight w/2, an upper bound of the Hessian of
 * W whatever is slack; lambda its largest eigenvalue. The metric 1 + Phi D Phi' is constant and
 * positive: still a gradient flow of the same W with the same equilibria, stable for
 * h < 2 C/lambda_max((1 + Phi D Phi') L), by power iteration. What the fine network alone spreads
 * by diffusion, at a time that grows with the square of the distance, each coarse step spreads over
 * the body at once.
 *
 * Elements that come under a tool change Phi'LPhi by two outer products each, and its inverse is
 * made anew (0.1 ms for 64 cells); elements a tool has left stay out for a while, so that a slide
 * does not pay this at each step. Rejected: a third level (nothing gained), multigrid cycles (no
 * gradient flow of W), Nesterov's momentum (lands on wrong buckled branches).
 *
 * In the kernels Phi lies in blocks of 16 elements, dense over the cells that reach one of them.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* Radius of a hat over the spacing of the cells. */
#define HAT_RADIUS 1.8
/* Sub-steps that an element stays out after a tool has left it. */
enum { LINGER = 50 };
/* Power iterations, and what the result is raised by for not having converged. */
enum { POWER_ITERATIONS = 40 };
#define POWER_MARGIN 1.05
/* A cell's diagonal below this share of the largest has no element left that may move. */
#define DEAD_SHARE 1e-9

struct ss_chain_coarse {
    int32_t cells, row; /* row: padded */
    double spacing;     /* m */
    double lambda;      /* of L for the mean capacitance */
    /* Phi by element */
    int32_t *first, *cell;
    double *weight;
    ss_chain_hats hats;
    ss_real *mask;       /* 1 where an element takes part, quads */
    int32_t *out, *idle; /* elements under tools, and for how long they have not been */
    int32_t out_count;
    double *base, *matrix;           /* Phi'LPhi without tools, and now; cells x cells */
    double *factor, *solved;         /* scratch of the inverse */
    ss_real *base_inverse, *inverse; /* D, cells rows of `row` */
    ss_real *gathered, *moved;       /* 3 rows */
};

int32_t ss_chain_coarse_cells(const ss_chain_coarse *coarse)
{
    return coarse->cells;
}

int64_t ss_chain_coarse_bytes(const ss_chain_coarse *coarse)
{
    const int64_t entries = coarse->hats.first[coarse->hats.block_count];
    return entries * (int64_t)(SS_CHAIN_COARSE_BLOCK * sizeof(ss_real) + sizeof(int32_t)) +
           (int64_t)coarse->cells * coarse->cells * (int64_t)(4 * sizeof(double)) +
           2 * (int64_t)coarse->cells * coarse->row * (int64_t)sizeof(ss_real);
}

/* ---- hats --------------------------------------------------------------------------------- */

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

/* Weights of one element over all seeds; returns how many are not 0. */
static int32_t hat_row(const ss_mesh *mesh, int32_t node, int32_t count, const int32_t *seed,
                       double radius, int32_t *cell, double *weight)
{
    int32_t used = 0, nearest = 0;
    double sum = 0.0, least = (double)INFINITY;
    for (int32_t s = 0; s < count; ++s) {
        const double r = distance(mesh, node, seed[s]);
        nearest = r < least ? s : nearest;
        least = fmin(least, r);
        if (r < radius) {
            cell[used] = s;
            weight[used] = (1.0 - r / radius) * (1.0 - r / radius);
            sum += weight[used++];
        }
    }
    if (used == 0) { /* further from every seed than a hat is wide */
        cell[0] = nearest;
        weight[0] = 1.0;
        return 1;
    }
    for (int32_t k = 0; k < used; ++k) {
        weight[k] /= sum;
    }
    return used;
}

static softsim_status build_rows(ss_chain_coarse *coarse, const ss_mesh *mesh, const int32_t *seed)
{
    const size_t n = (size_t)mesh->node_count, cells = (size_t)coarse->cells;
    const double radius = HAT_RADIUS * coarse->spacing;
    int32_t *cell = ss_memory_get(cells, sizeof *cell);
    double *weight = ss_memory_get(cells, sizeof *weight);
    coarse->first = ss_memory_get(n + 1, sizeof *coarse->first);
    bool is_good = cell && weight && coarse->first;
    for (int32_t i = 0; is_good && i < mesh->node_count; ++i) {
        coarse->first[i + 1] =
            coarse->first[i] + hat_row(mesh, i, coarse->cells, seed, radius, cell, weight);
    }
    if (is_good) {
        const size_t entries = (size_t)coarse->first[n];
        coarse->cell = ss_memory_get(entries, sizeof *coarse->cell);
        coarse->weight = ss_memory_get(entries, sizeof *coarse->weight);
        is_good = coarse->cell && coarse->weight;
    }
    for (int32_t i = 0; is_good && i < mesh->node_count; ++i) {
        const int32_t count = hat_row(mesh, i, coarse->cells, seed, radius, cell, weight);
        memcpy(coarse->cell + coarse->first[i], cell, (size_t)count * sizeof *cell);
        memcpy(coarse->weight + coarse->first[i], weight, (size_t)count * sizeof *weight);
    }
    ss_memory_free(cell);
    ss_memory_free(weight);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* Marks the cells of a block in slot[] (0 none, else place + 1); returns how many. */
static int32_t block_cells(const ss_chain_coarse *coarse, int32_t node_count, int32_t block,
                           int32_t *slot)
{
    int32_t count = 0;
    const int32_t first = block * SS_CHAIN_COARSE_BLOCK;
    memset(slot, 0, (size_t)coarse->cells * sizeof *slot);
    for (int32_t i = first; i < first + SS_CHAIN_COARSE_BLOCK && i < node_count; ++i) {
        for (int32_t k = coarse->first[i]; k < coarse->first[i + 1]; ++k) {
            if (slot[coarse->cell[k]] == 0) {
                slot[coarse->cell[k]] = ++count;
            }
        }
    }
    return count;
}

static int32_t pad_up(int32_t count, int32_t to)
{
    return (count + to - 1) / to * to;
}

static void fill_block(ss_chain_coarse *coarse, int32_t node_count, int32_t block,
                       const int32_t *slot)
{
    ss_chain_hats *hats = &coarse->hats;
    const ptrdiff_t at = hats->first[block];
    for (int32_t c = 0; c < coarse->cells; ++c) {
        if (slot[c] > 0) {
            hats->cell[at + slot[c] - 1] = c;
        }
    }
    const int32_t first = block * SS_CHAIN_COARSE_BLOCK;
    for (int32_t i = first; i < first + SS_CHAIN_COARSE_BLOCK && i < node_count; ++i) {
        for (int32_t k = coarse->first[i]; k < coarse->first[i + 1]; ++k) {
            const int32_t place = slot[coarse->cell[k]] - 1;
            const ptrdiff_t chunk = at + place / SS_CHAIN_COARSE_PAD * SS_CHAIN_COARSE_PAD;
            hats->weight[chunk * SS_CHAIN_COARSE_BLOCK +
                         (ptrdiff_t)(i - first) * SS_CHAIN_COARSE_PAD +
                         place % SS_CHAIN_COARSE_PAD] = (ss_real)coarse->weight[k];
        }
    }
}

static softsim_status build_hats(ss_chain_coarse *coarse, int32_t node_count)
{
    ss_chain_hats *hats = &coarse->hats;
    hats->node_count = node_count;
    hats->cell_count = coarse->row;
    hats->block_count = pad_up(node_count, SS_CHAIN_COARSE_BLOCK) / SS_CHAIN_COARSE_BLOCK;
    hats->first = ss_memory_get((size_t)hats->block_count + 1, sizeof *hats->first);
    int32_t *slot = ss_memory_get((size_t)coarse->cells, sizeof *slot);
    bool is_good = hats->first && slot;
    for (int32_t b = 0; is_good && b < hats->block_count; ++b) {
        hats->first[b + 1] =
            hats->first[b] + pad_up(block_cells(coarse, node_count, b, slot), SS_CHAIN_COARSE_PAD);
    }
    if (is_good) {
        const size_t entries = (size_t)hats->first[hats->block_count];
        hats->cell = ss_memory_get(entries, sizeof *hats->cell);
        hats->weight = ss_memory_get(entries * SS_CHAIN_COARSE_BLOCK, sizeof *hats->weight);
        is_good = hats->cell && hats->weight;
    }
    for (int32_t b = 0; is_good && b < hats->block_count; ++b) {
        (void)block_cells(coarse, node_count, b, slot);
        fill_block(coarse, node_count, b, slot);
    }
    ss_memory_free(slot);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* ---- Phi'LPhi and its inverse ------------------------------------------------------------- */

/* matrix += factor (p q' + q p') over the rows of elements i and j, which may be the same. */
static void add_product(ss_chain_coarse *coarse, int32_t i, int32_t j, double factor)
{
    for (int32_t k = coarse->first[i]; k < coarse->first[i + 1]; ++k) {
        for (int32_t l = coarse->first[j]; l < coarse->first[j + 1]; ++l) {
            const double value = factor * coarse->weight[k] * coarse->weight[l];
            const ptrdiff_t a = coarse->cell[k], b = coarse->cell[l];
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
    add_product(coarse, node, node, sign * 0.25 * model->valence[node]);
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

/* ---- eigenvalues -------------------------------------------------------------------------- */

/* out = L x over the elements that move, L with weights w/2. */
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
        out[at] *= model->free[at];
    }
}

/* x += scale Phi D Phi' g */
static void spread(ss_model *model, const ss_real *g, double scale, ss_real *x)
{
    ss_chain_coarse *coarse = model->coarse;
    const size_t row = (size_t)coarse->row;
    model->kernels->gather(&coarse->hats, coarse->mask, g, coarse->gathered);
    memset(coarse->moved, 0, 3 * row * sizeof *coarse->moved);
    for (size_t k = 0; k < (size_t)coarse->cells; ++k) {
        const ss_real *column = coarse->inverse + k * row;
        for (size_t a = 0; a < 3; ++a) {
            const ss_real value = (ss_real)scale * coarse->gathered[a * row + k];
            ss_real *moved = coarse->moved + a * row;
            for (size_t j = 0; j < row; ++j) {
                moved[j] += column[j] * value;
            }
        }
    }
    model->kernels->spread(&coarse->hats, coarse->mask, coarse->moved, x);
}

/* The largest eigenvalue of C^-1 L, or with `is_both` of (C^-1 + Phi D Phi'/C) L, 1/s. */
static double largest_rate(ss_model *model, bool is_both, ss_real *x, ss_real *y)
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
                    (ss_real)(model->conductance[i] * (double)y[4 * (ptrdiff_t)i + k]);
            }
        }
        if (is_both) {
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
    if (x && y) {
        coarse->lambda = largest_rate(model, false, x, y) * model->capacitance;
        invert(coarse);
        memcpy(coarse->base_inverse, coarse->inverse,
               (size_t)coarse->cells * (size_t)coarse->row * sizeof *coarse->inverse);
        rate = largest_rate(model, true, x, y);
    }
    ss_memory_free(x);
    ss_memory_free(y);
    return rate;
}

/* ---- life --------------------------------------------------------------------------------- */

static softsim_status allocate(ss_model *model, ss_chain_coarse *coarse)
{
    const size_t cells = (size_t)coarse->cells, row = (size_t)coarse->row;
    const size_t n = (size_t)model->padded;
    coarse->mask = ss_memory_get(4 * n, sizeof *coarse->mask);
    coarse->out = ss_memory_get(n, sizeof *coarse->out);
    coarse->idle = ss_memory_get(n, sizeof *coarse->idle);
    coarse->base = ss_memory_get(cells * cells, sizeof *coarse->base);
    coarse->matrix = ss_memory_get(cells * cells, sizeof *coarse->matrix);
    coarse->factor = ss_memory_get(cells * cells, sizeof *coarse->factor);
    coarse->solved = ss_memory_get(cells * cells, sizeof *coarse->solved);
    coarse->inverse = ss_memory_get(cells * row, sizeof *coarse->inverse);
    coarse->base_inverse = ss_memory_get(cells * row, sizeof *coarse->base_inverse);
    coarse->gathered = ss_memory_get(3 * row, sizeof *coarse->gathered);
    coarse->moved = ss_memory_get(3 * row, sizeof *coarse->moved);
    return coarse->mask && coarse->out && coarse->idle && coarse->base && coarse->matrix &&
                   coarse->factor && coarse->solved && coarse->inverse && coarse->base_inverse &&
                   coarse->gathered && coarse->moved
               ? SOFTSIM_OK
               : SOFTSIM_ERROR_MEMORY;
}

softsim_status ss_chain_coarse_create(ss_model *model, int32_t cells)
{
    const ss_mesh *mesh = model->plan.mesh;
    ss_chain_coarse *coarse = ss_memory_get(1, sizeof *coarse);
    int32_t *seed = ss_memory_get((size_t)cells, sizeof *seed);
    double *nearest = ss_memory_get((size_t)mesh->node_count, sizeof *nearest);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    model->coarse = coarse;
    if (coarse && seed && nearest) {
        coarse->cells = cells;
        coarse->row = pad_up(cells, SS_CHAIN_COARSE_PAD);
        coarse->spacing = choose_seeds(mesh, cells, seed, nearest);
        status = build_rows(coarse, mesh, seed);
    }
    ss_memory_free(seed);
    ss_memory_free(nearest);
    status = status == SOFTSIM_OK ? build_hats(coarse, model->node_count) : status;
    status = status == SOFTSIM_OK ? allocate(model, coarse) : status;
    for (int32_t i = 0; status == SOFTSIM_OK && i < model->node_count; ++i) {
        if (!model->is_bound[i]) {
            add_element(model, i, 1.0);
            put_mask(coarse, i, 1);
        }
    }
    if (status == SOFTSIM_OK) {
        memcpy(coarse->base, coarse->matrix, (size_t)cells * (size_t)cells * sizeof *coarse->base);
    }
    return status;
}

void ss_chain_coarse_destroy(ss_chain_coarse **coarse)
{
    ss_chain_coarse *c = *coarse;
    if (!c) {
        return;
    }
    void *const owned[] = {c->first,       c->cell,   c->weight, c->hats.first, c->hats.cell,
                           c->hats.weight, c->mask,   c->out,    c->idle,       c->base,
                           c->matrix,      c->factor, c->solved, c->inverse,    c->base_inverse,
                           c->gathered,    c->moved};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k) {
        ss_memory_free(owned[k]);
    }
    ss_memory_free(c);
    *coarse = NULL;
}

/* No element is under a tool any more: back to what was computed at the start, to the last bit. */
static void restore(ss_chain_coarse *coarse)
{
    const size_t cells = (size_t)coarse->cells;
    memcpy(coarse->matrix, coarse->base, cells * cells * sizeof *coarse->base);
    memcpy(coarse->inverse, coarse->base_inverse,
           cells * (size_t)coarse->row * sizeof *coarse->inverse);
}

void ss_chain_coarse_reset(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    for (int32_t k = 0; k < coarse->out_count; ++k) {
        put_mask(coarse, coarse->out[k], 1);
    }
    coarse->out_count = 0;
    restore(coarse);
}

/* ---- a sub-step --------------------------------------------------------------------------- */

/* Elements under tools no longer take part, those that tools left long ago do again. */
static void follow_tools(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    bool is_changed = false;
    int32_t kept = 0;
    for (int32_t k = 0; k < coarse->out_count; ++k) {
        const int32_t node = coarse->out[k];
        const int32_t idle = model->is_touched[node] ? 0 : coarse->idle[k] + 1;
        if (idle > LINGER) {
            add_element(model, node, 1.0);
            put_mask(coarse, node, 1);
            is_changed = true;
        } else {
            coarse->out[kept] = node;
            coarse->idle[kept++] = idle;
        }
    }
    coarse->out_count = kept;
    for (int32_t k = 0; k < model->touched_count; ++k) {
        const int32_t node = model->touched[k];
        if (takes_part(coarse, node)) {
            put_mask(coarse, node, 0);
            add_element(model, node, -1.0);
            coarse->out[coarse->out_count] = node;
            coarse->idle[coarse->out_count++] = 0;
            is_changed = true;
        }
    }
    if (is_changed && coarse->out_count == 0) {
        restore(coarse);
    } else if (is_changed) {
        invert(coarse);
    }
}

void ss_chain_coarse_move(ss_model *model, double h)
{
    follow_tools(model);
    spread(model, model->pull, h / model->capacitance, model->u);
}
