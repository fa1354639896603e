/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/coarse.h"
/*
 * A coarse level of cells above the fine ones: "map multiple chain elements to one single neural
 * cell", the paper's future work, read as a second layer.
 *
 *   dP/dt = 1/C (dP + Phi D Phi' dP),  D = lambda (Phi' L Phi)^-1
 *
 * Phi, of hats.c: hat weights (1 - r/(1.8 s))^2 of every chain element over the coarse cells around
 * it, at farthest points with mean spacing s; rows sum to 1, and are 0 for elements that are fixed,
 * prescribed, under a tool or saturated (D is made for links, and far too large for what draws a
 * cell back by itself). L: the Laplacian of all links with weight w/2, an upper bound of the
 * Hessian of W whatever is slack, and the leak (dP has it too: with the leak on the fine cells
 * alone the equilibrium under a load would be another); lambda its largest eigenvalue. The metric 1
 * + Phi D Phi' is constant and positive: still a gradient flow of the same W with the same
 * equilibria, stable for h < 2 C/lambda_max((1 + Phi D Phi') L), by power iteration. What the fine
 * network alone spreads by diffusion, at a time that grows with the square of the distance, each
 * coarse step spreads over the body at once.
 *
 * Aggregated cells (`cells: N`) are the same hats used instead of the fine cells: away from tools
 * P = P0 + Phi x and C m_j dx_j/dt = (Phi' dP)_j, m_j the elements of cell j: the drag of the
 * full model, and a descent of the same W. |Phi m^-1 Phi'| <= 1 keeps it stable wherever the fine
 * cells are; its own, longer step follows from power iteration. Elements near tools and prescribed
 * cells are cells of their own as well, stepped at their own pace while the far field rests (each
 * in turn is a descent), and stay so for a while after.
 *
 * Elements that come under a tool change Phi'LPhi by two outer products each; its inverse is
 * recomputed (0.1 ms for 64 cells) at most once an outer step, and elements that a tool has left
 * stay out for a while, so that a slide does not pay it each time. Rejected: a third level (nothing
 * gained), multigrid cycles (no gradient flow of W), Nesterov's momentum (lands on wrong buckled
 * branches).
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

/* Sub-steps that an element stays out after a tool has left it. */
enum { LINGER = 50 };
/* Outer steps that an element stays a cell of its own; links around what pushes that do. */
enum { OWN_LINGER = 300, OWN_LINKS = 3 };
/* Of the aggregated cells' rate: elements under tools sharpen Phi. */
#define AGGREGATE_MARGIN 1.3
/* Power iterations, and what the result is raised by for not having converged. */
enum { POWER_ITERATIONS = 60 };
#define POWER_MARGIN 1.03
/* A cell's diagonal below this share of the largest has no element left that may move. */
#define DEAD_SHARE 1e-9

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
        x[at] = model->free[at] * (ss_real)(0.5 * ss_random_start(&random));
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
    SS_ARENA_TAKE(arena, SS_ROOM(4 * n, coarse->mask), SS_ROOM(n, coarse->out),
                  SS_ROOM(n, coarse->idle), SS_ROOM(4 * row, coarse->gathered),
                  SS_ROOM(4 * row, coarse->moved));
    if (coarse->is_aggregated) {
        SS_ARENA_TAKE(arena, SS_ROOM(row, coarse->inverse), SS_ROOM(n, coarse->own),
                      SS_ROOM(n, coarse->queue), SS_ROOM(cells, coarse->solved));
    } else {
        SS_ARENA_TAKE(
            arena, SS_ROOM(cells * cells, coarse->base), SS_ROOM(cells * cells, coarse->matrix),
            SS_ROOM(cells * cells, coarse->factor), SS_ROOM(cells * cells, coarse->solved),
            SS_ROOM(row * row, coarse->inverse), SS_ROOM(row * row, coarse->base_inverse));
    }
    return ss_arena_status(arena);
}

/* Fixed and prescribed elements take no part; the others make Phi'LPhi, or m. */
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
    model->coarse = coarse;
    if (!coarse) {
        return SOFTSIM_ERROR_MEMORY;
    }
    coarse->is_aggregated = is_aggregated;
    coarse->cells = cells;
    coarse->row = (cells + 3) / 4 * 4;
    softsim_status status = ss_chain_hats_create(coarse, mesh, model->diagonal, &model->arena);
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
static void own_prescribed(ss_model *model)
{
    ss_chain_coarse *coarse = model->coarse;
    const ss_chain_net *net = model->net;
    int32_t first = 0, count = 0;
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        const ss_prescribed *set = model->prescribed[s].set.plan;
        for (int32_t i = 0; model->prescribed[s].is_moving && i < set->node_count; ++i) {
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
    own_prescribed(model); /* first: it knows by the count what it has seen */
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
