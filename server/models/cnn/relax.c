/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/relax.h"
/*
 * The continuous-time network of Zhong, Shirinzadeh, Alici, Smith 2006, equations (1) and (2):
 *
 *   C v' = -v / R_x + sum_j A_ij y_j + I,     y = v where |v| <= K, else +-K
 *
 * with C = 1, B = 0 and the templates of equation (20) for any grid,
 *
 *   A_ij = rho_i w_ij / S_i,   A_ii = 1 / R_x - sum_j A_ij,   v = 0 at held cells.
 *
 * While |v| <= K the centre's 1 / R_x cancels -v / R_x, and the network follows
 *
 *   v_i' = I_i - (rho_i / S_i) sum_j w_ij (v_i - v_j)
 *
 * whatever R_x is; it rests at the discrete Poisson equation. It is linear in I, so that one state
 * ghat(t) a cell, for a unit source from 0, gives I_eff ghat(t) for a source of I_eff. Saturation
 * keeps that within K: I_eff <= K / ghat of the settled network (source.c, saturate.c), and
 * ghat(t) stays below the settled one (see below), hence |v| <= K at every time and the clip has
 * nothing left to cut. A source on a part of the body without a held cell drains uniformly, as in
 * influence.c; the mean of v over that part, by S / rho, stays 0.
 *
 * Columns keep the settled network's normalisation, kap_e = rho_e |ghat_i - ghat_j| / (L0_e^2 Qhat)
 * with the settled Qhat: a network at 0 has no tension, and one that spreads takes it up from the
 * contact outwards. Rejected: the present Qhat, which gives a cell just touched all of the tension
 * in its own edges, and is 0/0 at the start; driving the states by the present I, whose flux
 * would remember old strains, so that the force were the gradient of nothing.
 *
 * Time is the network's own, by explicit Euler. With a = max_i sum_j A_ij over the free cells every
 * eigenvalue of the templates lies in 0 .. 2 a (Gershgorin), and the step is 0.9 / a: below the
 * limit 2 / lambda_max, and each new potential is then a mean of old ones with weights >= 0 plus
 * the source, so that in a part with a held cell potentials only rise, to the settled ones and
 * never beyond. Rejected: larger steps, which converge no faster (the slowest mode rules) and let
 * neighbours alternate.
 *
 * A cell has a state while a tool touches it or its load acts. It is let go when that ends, at
 * weight 0, and starts from 0 the next time: nothing jumps, and memory is bounded by the cells that
 * may be in use. Potentials are in double: a step adds as little as 1e-5 of them.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"

enum { WIDTH = SS_CNN_RELAX_WIDTH };
/* Of 1 / max_i sum_j A_ij. */
#define STEP_SHARE 0.9

/* ---- set-up ---- */

/* A_ij = rho_i w_ij / S_i into `share`, by rows of the free cells. */
static softsim_status build_templates(ss_cnn_relax *relax, const uint8_t *held)
{
    const ss_cnn_network *network = relax->network;
    const ss_cnn_edges *edges = &network->edges;
    const size_t n = (size_t)network->node_count, entries = 2 * (size_t)edges->count;
    int32_t *cursor = ss_memory_get(n, sizeof *cursor);
    SS_ARENA_TAKE(&relax->arena, SS_ROOM(n + 1, relax->row), SS_ROOM(entries, relax->neighbour),
                  SS_ROOM(entries, relax->share), SS_ROOM(n, relax->stay),
                  SS_ROOM((size_t)edges->count, relax->edge_scale));
    if (!cursor || ss_arena_status(&relax->arena) != SOFTSIM_OK) {
        ss_memory_free(cursor);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        const int32_t i = edges->from[e] / 4, j = edges->to[e] / 4;
        relax->row[i + 1] += !held[i];
        relax->row[j + 1] += !held[j];
        relax->edge_scale[e] = network->edge_rho[e] / network->edge_square[e];
    }
    for (size_t i = 0; i < n; ++i) {
        relax->row[i + 1] += relax->row[i];
        cursor[i] = relax->row[i];
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        const int32_t end[2] = {edges->from[e] / 4, edges->to[e] / 4};
        for (int side = 0; side < 2; ++side) {
            const int32_t i = end[side];
            if (!held[i]) {
                const int32_t at = cursor[i]++;
                relax->neighbour[at] = end[1 - side];
                relax->share[at] =
                    network->factor->rho[i] * network->edge_weight[e] / network->size[i];
            }
        }
    }
    ss_memory_free(cursor);
    return SOFTSIM_OK;
}

/* The step, and the templates times it. */
static void set_step(ss_cnn_relax *relax)
{
    const int32_t n = relax->network->node_count;
    double fastest = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t i = 0; i < n; ++i) {
            double sum = 0.0;
            for (int32_t p = relax->row[i]; p < relax->row[i + 1]; ++p) {
                relax->share[p] *= pass == 0 ? 1.0 : relax->step;
                sum += relax->share[p];
            }
            fastest = pass == 0 ? fmax(fastest, sum) : fastest;
            relax->stay[i] = 1.0 - sum;
        }
        relax->step = fastest > 0.0 ? STEP_SHARE / fastest : 0.0;
    }
}

static softsim_status check_areas(const ss_cnn_network *network, const ss_mesh *mesh,
                                  const uint8_t *held, softsim_error *error)
{
    int32_t flat = 0, first = 0;
    for (int32_t i = 0; i < network->node_count; ++i) {
        if (!held[i] && network->factor->component[i] >= 0 && !(network->size[i] > 0.0)) {
            first = flat++ == 0 ? i : first;
        }
    }
    if (flat > 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_MESH,
            "cnn-energy: solver: relaxation needs an area at every cell, and %d nodes "
            "(first %d) have only triangles without area: repair the mesh, or take "
            "solver: equilibrium",
            flat, ss_mesh_file_node(mesh, first));
    }
    return flat > 0 ? SOFTSIM_ERROR_MESH : SOFTSIM_OK;
}

static softsim_status allocate_states(ss_cnn_relax *relax, softsim_error *error)
{
    const ss_cnn_network *network = relax->network;
    relax->block_count = (relax->cell_count + WIDTH - 1) / WIDTH;
    const size_t n = (size_t)network->node_count, slots = (size_t)relax->block_count * WIDTH;
    const size_t padded = (size_t)network->edges.padded_count;
    const size_t blocks = (size_t)relax->block_count + 1;
    relax->bytes = (int64_t)(blocks * n * sizeof **relax->block + slots * padded * sizeof(ss_real));
    if (relax->bytes > SS_CNN_INFLUENCE_BYTES) {
        softsim_error_add(error, SOFTSIM_ERROR_UNSUPPORTED,
                          "cnn-energy: solver: relaxation needs the states of %d cells, %lld MB, "
                          "and %lld MB is the limit: use a coarser surface, fewer loaded nodes, or "
                          "solver: equilibrium",
                          relax->cell_count, (long long)(relax->bytes >> 20),
                          (long long)(SS_CNN_INFLUENCE_BYTES >> 20));
        return SOFTSIM_ERROR_UNSUPPORTED;
    }
    SS_ARENA_TAKE(&relax->arena, SS_ROOM(n, relax->slot_of), SS_ROOM(slots, relax->cell),
                  SS_ROOM(slots, relax->seen), SS_ROOM(slots * padded, relax->kap),
                  SS_ROOM(blocks, relax->block));
    for (size_t b = 0; relax->block && b < blocks; ++b) {
        relax->block[b] = ss_arena_get(&relax->arena, n, sizeof **relax->block);
    }
    return ss_arena_status(&relax->arena);
}

softsim_status ss_cnn_relax_create(const ss_cnn_network *network, const ss_mesh *mesh,
                                   const uint8_t *held, const uint8_t *is_cell, int32_t steps,
                                   ss_cnn_relax **out_relax, softsim_error *error)
{
    ss_cnn_relax *relax = ss_memory_get(1, sizeof *relax);
    *out_relax = NULL;
    if (!relax) {
        return SOFTSIM_ERROR_MEMORY;
    }
    relax->network = network;
    relax->steps = steps;
    for (int32_t i = 0; i < network->node_count; ++i) {
        relax->cell_count += is_cell[i] != 0;
    }
    softsim_status status = check_areas(network, mesh, held, error);
    status = status == SOFTSIM_OK ? allocate_states(relax, error) : status;
    status = status == SOFTSIM_OK ? build_templates(relax, held) : status;
    status = status == SOFTSIM_OK ? ss_cnn_network_time_constant(network, &relax->time_constant)
                                  : status;
    if (status != SOFTSIM_OK) {
        ss_cnn_relax_destroy(&relax);
        return status;
    }
    set_step(relax);
    ss_cnn_relax_reset(relax);
    *out_relax = relax;
    return SOFTSIM_OK;
}

void ss_cnn_relax_destroy(ss_cnn_relax **relax)
{
    if (*relax) {
        ss_arena_free(&(*relax)->arena);
        ss_memory_free(*relax);
        *relax = NULL;
    }
}

void ss_cnn_relax_reset(ss_cnn_relax *relax)
{
    for (int32_t i = 0; i < relax->network->node_count; ++i) {
        relax->slot_of[i] = -1;
    }
    for (int32_t s = 0; s < relax->block_count * WIDTH; ++s) {
        relax->cell[s] = -1;
    }
}

/* ---- cells in use ---- */

void ss_cnn_relax_look(ss_cnn_relax *relax)
{
    ++relax->look;
}

/* The first free slot, with the network at 0. There is one for every cell that may be in use. */
static int32_t take_slot(ss_cnn_relax *relax, int32_t node)
{
    int32_t slot = 0;
    while (relax->cell[slot] >= 0) {
        ++slot;
    }
    double(*state)[WIDTH] = relax->block[slot / WIDTH];
    for (int32_t i = 0; i < relax->network->node_count; ++i) {
        state[i][slot % WIDTH] = 0.0;
    }
    const size_t padded = (size_t)relax->network->edges.padded_count;
    memset(relax->kap + (size_t)slot * padded, 0, padded * sizeof *relax->kap);
    relax->cell[slot] = node;
    relax->slot_of[node] = slot;
    return slot;
}

void ss_cnn_relax_influence(ss_cnn_relax *relax, int32_t count, const int32_t *node,
                            const ss_real **out_column)
{
    for (int32_t k = 0; k < count; ++k) {
        const int32_t known = relax->slot_of[node[k]];
        const int32_t slot = known >= 0 ? known : take_slot(relax, node[k]);
        relax->seen[slot] = relax->look;
        out_column[k] = relax->kap + (size_t)slot * (size_t)relax->network->edges.padded_count;
    }
}

/* ---- time ---- */

/* out := (1 + step A) state, for WIDTH states side by side. */
static void spread(const ss_cnn_relax *relax, const double (*restrict state)[WIDTH],
                   double (*restrict out)[WIDTH])
{
    for (int32_t i = 0; i < relax->network->node_count; ++i) {
        double sum[WIDTH];
        for (int k = 0; k < WIDTH; ++k) {
            sum[k] = relax->stay[i] * state[i][k];
        }
        for (int32_t p = relax->row[i]; p < relax->row[i + 1]; ++p) {
            const double *from = state[relax->neighbour[p]];
            for (int k = 0; k < WIDTH; ++k) {
                sum[k] += relax->share[p] * from[k];
            }
        }
        for (int k = 0; k < WIDTH; ++k) {
            out[i][k] = sum[k];
        }
    }
}

/* state += step I: the unit source, and the uniform sink of a part without a held cell. */
static void feed(const ss_cnn_relax *relax, int32_t cell, int32_t lane, double (*state)[WIDTH])
{
    const ss_cnn_factor *factor = relax->network->factor;
    const int32_t part = factor->component[cell];
    state[cell][lane] += relax->step;
    if (!factor->is_drained[part]) {
        return;
    }
    const double drain = relax->step * relax->network->size[cell] /
                         (factor->rho[cell] * factor->component_size[part]);
    for (int32_t i = 0; i < relax->network->node_count; ++i) {
        if (factor->component[i] == part) {
            state[i][lane] -= drain * factor->rho[i];
        }
    }
}

static void advance_block(ss_cnn_relax *relax, int32_t b)
{
    double(**block)[WIDTH] = relax->block;
    for (int32_t s = 0; s < relax->steps; ++s) {
        spread(relax, (const double(*)[WIDTH])block[b], block[relax->block_count]);
        double(*done)[WIDTH] = block[relax->block_count];
        block[relax->block_count] = block[b];
        block[b] = done;
        for (int32_t k = 0; k < WIDTH; ++k) {
            if (relax->cell[b * WIDTH + k] >= 0) {
                feed(relax, relax->cell[b * WIDTH + k], k, done);
            }
        }
    }
}

/* kap_e = rho_e |ghat_i - ghat_j| / (L0_e^2 Qhat), with the settled Qhat; 0 in free slots. */
static void build_influence(ss_cnn_relax *relax, int32_t b)
{
    const ss_cnn_edges *edges = &relax->network->edges;
    const double(*state)[WIDTH] = (const double(*)[WIDTH])relax->block[b];
    const size_t padded = (size_t)edges->padded_count;
    ss_real *out = relax->kap + (size_t)b * WIDTH * padded;
    double scale[WIDTH] = {0.0};
    for (int32_t k = 0; k < WIDTH; ++k) {
        const int32_t cell = relax->cell[b * WIDTH + k];
        scale[k] = cell >= 0 ? 1.0 / relax->network->qhat[cell] : 0.0;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        const double *from = state[edges->from[e] / 4], *to = state[edges->to[e] / 4];
        const double weight = relax->edge_scale[e];
        double kap[WIDTH];
        for (int k = 0; k < WIDTH; ++k) {
            kap[k] = weight * scale[k] * fabs(from[k] - to[k]);
        }
        for (int k = 0; k < WIDTH; ++k) {
            out[(size_t)k * padded + (size_t)e] = (ss_real)kap[k];
        }
    }
}

bool ss_cnn_relax_advance(ss_cnn_relax *relax)
{
    bool is_any = false;
    for (int32_t s = 0; s < relax->block_count * WIDTH; ++s) {
        if (relax->cell[s] >= 0 && relax->seen[s] != relax->look) {
            relax->slot_of[relax->cell[s]] = -1;
            relax->cell[s] = -1;
        }
    }
    for (int32_t b = 0; b < relax->block_count; ++b) {
        bool is_used = false;
        for (int32_t s = b * WIDTH; s < (b + 1) * WIDTH; ++s) {
            is_used = is_used || relax->cell[s] >= 0;
        }
        if (is_used) {
            advance_block(relax, b);
            build_influence(relax, b);
        }
        is_any = is_any || is_used;
    }
    return is_any;
}

/* ---- reading ---- */

double ss_cnn_relax_potential(const ss_cnn_relax *relax, int32_t slot, int32_t node)
{
    return relax->block[slot / WIDTH][node][slot % WIDTH];
}

double ss_cnn_relax_steps_to(const ss_cnn_relax *relax, double share)
{
    return relax->step > 0.0 ? ceil(-log(share) * relax->time_constant / relax->step) : 0.0;
}
