/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/network.h"
/*
 * Columns of the network: the flux densities that a source on one cell sets up,
 *
 *   Qhat = sum_e q_e L0_e^2,  kap_e = q_e / Qhat
 *
 * Eight are solved at a time, so that the factor is read once for all of them, and blocks of
 * eight go round the threads; every column is the same whoever solves it. While running they are
 * superposed as kap, never as potentials: |sum of g| cancels inside a tool's footprint and has
 * kinks in the weights. In the compact form a column is rebuilt from its potentials when its cell
 * is touched and kept until it is the one used longest ago; a rebuilt column has the same bits.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/order.h"
#include "rt/thread.h"

/* Columns solved in one pass over the factor. */
enum { WIDTH = SS_CNN_SOLVE_WIDTH };

/* ---- solving ---- */

/* x := A^-1 x for WIDTH right-hand sides side by side. */
static softsim_status solve_wide(const ss_cnn_factor *factor, double (*x)[WIDTH])
{
    if (factor->is_given_up) {
        return ss_cnn_iterate(factor, x);
    }
    const ss_factor *ldl = &factor->ldl;
    ss_cnn_kernels_get()->solve(ldl->n, ldl->column, ldl->row, ldl->lower, ldl->diagonal, x);
    return SOFTSIM_OK;
}

/* Adds a source of `scale` units on a cell to column k, and what drains it. */
static void add_source(const ss_cnn_network *network, int32_t cell, double scale, int32_t k,
                       double (*x)[WIDTH])
{
    const ss_cnn_factor *factor = network->factor;
    const int32_t c = factor->component[cell];
    const double source = scale * network->size[cell] / factor->rho[cell];
    if (factor->unknown[cell] >= 0) {
        x[factor->unknown[cell]][k] += source;
    }
    const double drain = source / factor->component_size[c];
    for (int32_t i = 0; factor->is_drained[c] && i < network->node_count; ++i) {
        if (factor->component[i] == c && factor->unknown[i] >= 0) {
            x[factor->unknown[i]][k] -= drain * network->size[i];
        }
    }
}

/* ghat for sources on up to WIDTH cells; out_ghat is node_count x WIDTH. */
static softsim_status solve_cells(const ss_cnn_network *network, int32_t count, const int32_t *node,
                                  double (*x)[WIDTH], double (*out_ghat)[WIDTH])
{
    const ss_cnn_factor *factor = network->factor;
    memset(x, 0, (size_t)factor->n * sizeof *x);
    for (int32_t k = 0; k < count; ++k) {
        add_source(network, node[k], 1.0, k, x);
    }
    const softsim_status status = solve_wide(factor, x);
    double least[WIDTH] = {0.0};
    for (int32_t i = 0; i < network->node_count; ++i) {
        for (int k = 0; k < WIDTH; ++k) {
            out_ghat[i][k] = factor->unknown[i] >= 0 ? x[factor->unknown[i]][k] : 0.0;
            least[k] = out_ghat[i][k] < least[k] ? out_ghat[i][k] : least[k];
        }
    }
    for (int32_t k = 0; k < count; ++k) {
        const int32_t c = factor->component[node[k]];
        for (int32_t i = 0; factor->is_drained[c] && i < network->node_count; ++i) {
            out_ghat[i][k] -= factor->component[i] == c ? least[k] : 0.0;
        }
    }
    return status;
}

typedef struct solve_job {
    ss_cnn_network *network;
    const int32_t *node; /* by column */
    int32_t first, stride;
    double (*x)[WIDTH], (*ghat)[WIDTH];
    softsim_status status; /* of the last block that did not work */
} solve_job;

/* Columns first, first + 1, ... of the cells `node`, from a solved block. */
static void store_influence(ss_cnn_network *network, int32_t count, const int32_t *node,
                            int32_t first, const double (*ghat)[WIDTH])
{
    ss_real *kap[WIDTH];
    double qhat[WIDTH];
    const bool is_whole = network->kap && !network->is_compact;
    for (int32_t k = 0; is_whole && k < count; ++k) {
        kap[k] = network->kap + (size_t)(first + k) * (size_t)network->edges.padded_count;
    }
    ss_cnn_kernels_get()->fluxes(&network->edges, network->edge_rho, network->edge_square, ghat,
                                 count, qhat, is_whole ? kap : NULL);
    for (int32_t k = 0; k < count; ++k) {
        network->qhat[node[k]] = qhat[k];
        network->own[node[k]] = ghat[node[k]][k];
    }
    for (int32_t k = 0; network->is_compact && k < count; ++k) {
        ss_real *out = network->ghat + (size_t)(first + k) * (size_t)network->node_count;
        for (int32_t i = 0; i < network->node_count; ++i) {
            out[i] = (ss_real)ghat[i][k];
        }
    }
}

static void *run_solve_job(void *argument)
{
    solve_job *job = argument;
    ss_cnn_network *network = job->network;
    for (int32_t first = job->first * WIDTH; first < network->influence_count;
         first += job->stride * WIDTH) {
        const int32_t left = network->influence_count - first;
        const int32_t count = left < WIDTH ? left : WIDTH;
        const softsim_status status =
            solve_cells(network, count, job->node + first, job->x, job->ghat);
        job->status = status == SOFTSIM_OK ? job->status : status;
        store_influence(network, count, job->node + first, first,
                        (const double(*)[WIDTH])job->ghat);
    }
    return NULL;
}

static softsim_status find_median_qhat(ss_cnn_network *network, const int32_t *node)
{
    double *sorted = ss_memory_get((size_t)network->influence_count, sizeof *sorted);
    if (!sorted) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t k = 0; k < network->influence_count; ++k) {
        sorted[k] = network->qhat[node[k]];
    }
    qsort(sorted, (size_t)network->influence_count, sizeof *sorted, ss_compare_doubles);
    network->median_qhat =
        network->influence_count > 0 ? sorted[network->influence_count / 2] : 0.0;
    ss_memory_free(sorted);
    return SOFTSIM_OK;
}

/* Is it better to keep potentials than flux densities? Volumes have many edges a source. */
static bool wants_compact(const ss_cnn_network *network, int64_t columns)
{
    return columns > SS_CNN_WHOLE_INFLUENCE ||
           columns * network->edges.padded_count * (int64_t)sizeof(ss_real) >
               SS_CNN_INFLUENCE_BYTES;
}

int64_t ss_cnn_network_influence_bytes(const ss_cnn_network *network)
{
    int64_t count = 0;
    for (int32_t i = 0; i < network->node_count; ++i) {
        count += network->is_source[i];
    }
    const int64_t length =
        wants_compact(network, count) ? network->node_count : network->edges.padded_count;
    return count * length * (int64_t)sizeof(ss_real);
}

/* Memory for the columns in whole or compact form, or none; *out_node lists their cells. */
static softsim_status allocate_influence(ss_cnn_network *network, bool is_kept, int32_t **out_node,
                                         softsim_error *error)
{
    const size_t n = (size_t)network->node_count, padded = (size_t)network->edges.padded_count;
    ss_arena *arena = &network->arena;
    int32_t *node = *out_node = ss_memory_get(n, sizeof *node);
    if (!node) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < network->node_count; ++i) {
        if (network->is_source[i]) {
            network->influence_of[i] = network->influence_count;
            node[network->influence_count++] = i;
        }
    }
    if (!is_kept) {
        return SOFTSIM_OK;
    }
    network->is_compact = wants_compact(network, network->influence_count);
    if (!network->is_compact) {
        network->kap =
            ss_arena_get(arena, (size_t)network->influence_count * padded, sizeof(ss_real));
        return ss_arena_status(arena);
    }
    const int64_t bytes = ss_cnn_network_influence_bytes(network);
    if (bytes > SS_CNN_INFLUENCE_BYTES) {
        softsim_error_add(
            error, SOFTSIM_ERROR_UNSUPPORTED,
            "cnn-energy: tools need the influence functions of %d cells, %lld MB, and %lld MB is "
            "the limit (about %d nodes): use a coarser surface (softsim-mesh remesh IN OUT "
            "--edge-mm N)",
            network->influence_count, (long long)(bytes >> 20),
            (long long)(SS_CNN_INFLUENCE_BYTES >> 20),
            (int)sqrt((double)SS_CNN_INFLUENCE_BYTES / (double)sizeof(ss_real)));
        return SOFTSIM_ERROR_UNSUPPORTED;
    }
    const int64_t kept = (int64_t)SS_CNN_CACHE_SLOTS * (int64_t)(padded * sizeof(ss_real));
    if (kept > SS_CNN_INFLUENCE_BYTES) {
        softsim_error_add(error, SOFTSIM_ERROR_UNSUPPORTED,
                          "cnn-energy: tools keep the flux densities of %d cells on %d edges, %lld "
                          "MB, and %lld MB is the limit: use a coarser mesh",
                          SS_CNN_CACHE_SLOTS, network->edges.count, (long long)(kept >> 20),
                          (long long)(SS_CNN_INFLUENCE_BYTES >> 20));
        return SOFTSIM_ERROR_UNSUPPORTED;
    }
    network->slot_count = SS_CNN_CACHE_SLOTS;
    const size_t slots = (size_t)network->slot_count;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)network->influence_count * n, network->ghat),
                  SS_ROOM(slots * padded, network->kap), SS_ROOM(padded, network->edge_scale),
                  SS_ROOM(n, network->slot_of), SS_ROOM(slots, network->slot_node),
                  SS_ROOM(slots, network->slot_used));
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t e = 0; e < network->edges.count; ++e) {
        network->edge_scale[e] = (ss_real)(network->edge_rho[e] / network->edge_square[e]);
    }
    for (int32_t i = 0; i < network->node_count; ++i) {
        network->slot_of[i] = -1;
    }
    for (int32_t s = 0; s < network->slot_count; ++s) {
        network->slot_node[s] = -1;
    }
    return SOFTSIM_OK;
}

softsim_status ss_cnn_network_solve_all(ss_cnn_network *network, bool is_kept, int32_t threads,
                                        softsim_error *error)
{
    enum { MAX_THREADS = 64 };
    const int32_t count = threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
    solve_job job[MAX_THREADS] = {0};
    ss_thread *thread[MAX_THREADS] = {0};
    int32_t *node = NULL;
    softsim_status status = allocate_influence(network, is_kept, &node, error);
    for (int32_t k = 0; status == SOFTSIM_OK && k < count; ++k) {
        job[k] = (solve_job){.network = network, .node = node, .first = k, .stride = count};
        job[k].x = ss_memory_get((size_t)network->factor->n, sizeof *job[k].x);
        job[k].ghat = ss_memory_get((size_t)network->node_count, sizeof *job[k].ghat);
        status = job[k].x && job[k].ghat ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    }
    /* Also one job gets a thread of its own: all run in the same floating-point mode. */
    for (int32_t k = 0; status == SOFTSIM_OK && k < count; ++k) {
        bool is_refused = false;
        status = ss_thread_start("columns", 0, SS_REALTIME_OFF, run_solve_job, &job[k], &thread[k],
                                 &is_refused);
    }
    for (int32_t k = 0; k < count; ++k) {
        ss_thread_join(&thread[k]);
        status = status == SOFTSIM_OK ? job[k].status : status;
        ss_memory_free(job[k].x);
        ss_memory_free(job[k].ghat);
    }
    if (status == SOFTSIM_OK) {
        status = find_median_qhat(network, node);
    }
    for (int32_t i = 0; !is_kept && i < network->node_count; ++i) {
        network->influence_of[i] = -1;
    }
    network->influence_count = is_kept ? network->influence_count : 0;
    ss_memory_free(node);
    return status;
}

softsim_status ss_cnn_network_superpose(ss_cnn_network *network, int32_t count, const int32_t *node,
                                        const double *weight, double *out_kap)
{
    ss_arena scratch = {0};
    double(*x)[WIDTH] = ss_arena_get(&scratch, (size_t)network->factor->n, sizeof *x);
    double(*ghat)[WIDTH] = ss_arena_get(&scratch, (size_t)network->node_count, sizeof *ghat);
    softsim_status status = ss_arena_status(&scratch);
    for (int32_t e = 0; e < network->edges.padded_count; ++e) {
        out_kap[e] = 0.0;
    }
    for (int32_t first = 0; status == SOFTSIM_OK && first < count; first += WIDTH) {
        const int32_t some = count - first < WIDTH ? count - first : WIDTH;
        status = solve_cells(network, some, node + first, x, ghat);
        double qhat[WIDTH];
        ss_cnn_kernels_get()->fluxes(&network->edges, network->edge_rho, network->edge_square,
                                     (const double(*)[WIDTH])ghat, some, qhat, NULL);
        for (int32_t k = 0; k < some; ++k) {
            const int32_t cell = node[first + k];
            network->qhat[cell] = qhat[k];
            network->own[cell] = ghat[cell][k];
            for (int32_t e = 0; e < network->edges.count; ++e) {
                const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
                out_kap[e] +=
                    weight[first + k] * (network->edge_rho[e] * fabs(ghat[i][k] - ghat[j][k]) /
                                         (network->edge_square[e] * qhat[k]));
            }
        }
    }
    ss_arena_free(&scratch);
    return status;
}

softsim_status ss_cnn_network_potential(const ss_cnn_network *network, int32_t count,
                                        const int32_t *node, const double *scale,
                                        double *out_potential)
{
    ss_arena scratch = {0};
    double(*x)[WIDTH] = ss_arena_get(&scratch, (size_t)network->factor->n, sizeof *x);
    double(*ghat)[WIDTH] = ss_arena_get(&scratch, (size_t)network->node_count, sizeof *ghat);
    softsim_status status = ss_arena_status(&scratch);
    memset(out_potential, 0, (size_t)network->node_count * sizeof *out_potential);
    for (int32_t first = 0; status == SOFTSIM_OK && first < count; first += WIDTH) {
        const int32_t some = count - first < WIDTH ? count - first : WIDTH;
        status = solve_cells(network, some, node + first, x, ghat);
        for (int32_t i = 0; i < network->node_count; ++i) {
            for (int32_t k = 0; k < some; ++k) {
                out_potential[i] += scale[first + k] * ghat[i][k];
            }
        }
    }
    ss_arena_free(&scratch);
    return status;
}

/* x := x minus its mean by S / rho over every drained part. */
static void take_out_means(const ss_cnn_network *network, double *sum, double *x)
{
    const ss_cnn_factor *factor = network->factor;
    memset(sum, 0, 2 * (size_t)network->component_count * sizeof *sum);
    for (int32_t i = 0; i < network->node_count; ++i) {
        const int32_t c = factor->component[i];
        if (c >= 0 && factor->is_drained[c]) {
            sum[2 * c] += network->size[i] / factor->rho[i] * x[i];
            sum[2 * c + 1] += network->size[i] / factor->rho[i];
        }
    }
    for (int32_t i = 0; i < network->node_count; ++i) {
        const int32_t c = factor->component[i];
        x[i] -= c >= 0 && factor->is_drained[c] ? sum[2 * c] / sum[2 * c + 1] : 0.0;
    }
}

softsim_status ss_cnn_network_time_constant(const ss_cnn_network *network, double *out_time)
{
    enum { ROUNDS = 100 };
    const ss_cnn_factor *factor = network->factor;
    ss_arena scratch = {0};
    double(*y)[WIDTH] = ss_arena_get(&scratch, (size_t)factor->n, sizeof *y);
    double *x = ss_arena_get(&scratch, (size_t)network->node_count, sizeof *x);
    double *sum = ss_arena_get(&scratch, 2 * (size_t)network->component_count, sizeof *sum);
    softsim_status status = ss_arena_status(&scratch);
    uint32_t random = 1;
    *out_time = 0.0;
    for (int32_t i = 0; status == SOFTSIM_OK && i < network->node_count; ++i) {
        random = random * 1664525u + 1013904223u;
        x[i] = factor->component[i] >= 0 &&
                       (factor->unknown[i] >= 0 || factor->is_drained[factor->component[i]])
                   ? 1.0 + (double)(random >> 8) / 16777216.0
                   : 0.0;
    }
    /* x := W^-1 (S / rho) x, whose largest eigenvalue is the time constant. */
    for (int round = 0; status == SOFTSIM_OK && factor->n > 0 && round < ROUNDS; ++round) {
        double before = 0.0, after = 0.0;
        take_out_means(network, sum, x);
        memset(y, 0, (size_t)factor->n * sizeof *y);
        for (int32_t i = 0; i < network->node_count; ++i) {
            before += network->size[i] / factor->rho[i] * x[i] * x[i];
        }
        if (!(before > 0.0)) {
            break;
        }
        for (int32_t i = 0; i < network->node_count; ++i) {
            x[i] /= sqrt(before);
            if (factor->unknown[i] >= 0) {
                y[factor->unknown[i]][0] = network->size[i] / factor->rho[i] * x[i];
            }
        }
        status = solve_wide(factor, y);
        for (int32_t i = 0; i < network->node_count; ++i) {
            const double next = factor->unknown[i] >= 0 ? y[factor->unknown[i]][0] : 0.0;
            after += network->size[i] / factor->rho[i] * x[i] * next;
            x[i] = next;
        }
        *out_time = after;
    }
    ss_arena_free(&scratch);
    return status;
}

/* ---- reading columns while running ---- */

/* The slot of `node`'s column: as it is, or rebuilt from ghat in the slot used longest ago. */
static int32_t ready_slot(ss_cnn_network *network, int32_t node)
{
    int32_t slot = network->slot_of[node];
    if (slot < 0) {
        slot = 0;
        for (int32_t s = 1; s < network->slot_count; ++s) {
            slot = network->slot_used[s] < network->slot_used[slot] ? s : slot;
        }
        if (network->slot_node[slot] >= 0) {
            network->slot_of[network->slot_node[slot]] = -1;
        }
        network->slot_node[slot] = node;
        network->slot_of[node] = slot;
        const ss_real *ghat =
            network->ghat + (size_t)network->influence_of[node] * (size_t)network->node_count;
        ss_real *out = network->kap + (size_t)slot * (size_t)network->edges.padded_count;
        const ss_real scale = (ss_real)(1.0 / network->qhat[node]);
        for (int32_t e = 0; e < network->edges.count; ++e) {
            const ss_real d = ghat[network->edges.from[e] / 4] - ghat[network->edges.to[e] / 4];
            out[e] = network->edge_scale[e] * scale * (d < 0 ? -d : d);
        }
    }
    network->slot_used[slot] = ++network->slot_clock;
    return slot;
}

void ss_cnn_network_influence(ss_cnn_network *network, int32_t count, const int32_t *node,
                              const ss_real **out_column)
{
    for (int32_t k = 0; k < count; ++k) {
        const int32_t column = network->influence_of[node[k]];
        const int32_t at =
            column >= 0 && network->is_compact ? ready_slot(network, node[k]) : column;
        out_column[k] =
            at < 0 ? NULL : network->kap + (size_t)at * (size_t)network->edges.padded_count;
    }
}

softsim_status ss_cnn_network_spread(const ss_cnn_network *network, const float *source,
                                     float *out_potential)
{
    const ss_cnn_factor *factor = network->factor;
    const int32_t n = network->node_count;
    ss_arena scratch = {0};
    double(*x)[WIDTH] = ss_arena_get(&scratch, (size_t)factor->n, sizeof *x);
    double *least = ss_arena_get(&scratch, (size_t)network->component_count + 1, sizeof *least);
    softsim_status status = ss_arena_status(&scratch);
    for (int32_t i = 0; status == SOFTSIM_OK && i < n; ++i) {
        if (source[i] > 0.0F && factor->component[i] >= 0) {
            add_source(network, i, (double)source[i], 0, x);
        }
    }
    status = status == SOFTSIM_OK ? solve_wide(factor, x) : status;
    for (int pass = 0; status == SOFTSIM_OK && pass < 2; ++pass) {
        for (int32_t i = 0; i < n; ++i) {
            const int32_t c = factor->component[i];
            const double value = factor->unknown[i] >= 0 ? x[factor->unknown[i]][0] : 0.0;
            const bool is_drained = c >= 0 && factor->is_drained[c];
            if (pass == 0 && is_drained) {
                least[c] = value < least[c] ? value : least[c];
            }
            out_potential[i] = (float)(value - (is_drained ? least[c] : 0.0));
        }
    }
    ss_arena_free(&scratch);
    return status;
}
