/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The network in its own time: what each cell in use has spread so far of a unit source on it.
 *
 * In: a network whose Qhat is known for a cell when it is used; which cells are in use. Out:
 * for each of these a column kap of flux densities, which starts at 0 and settles to the column of
 * influence.c. Memory belongs to the relaxation, all of it taken at creation. Thread: set-up by
 * any one thread, everything else by the simulation thread and RT-safe.
 * Not done: wider neighbourhoods than a cell's edges, the control template (B = 0).
 */
#include <stdbool.h>
#include <stdint.h>

#include "models/cnn/network.h"

/* States that advance side by side. */
enum { SS_CNN_RELAX_WIDTH = 8 };

typedef struct ss_cnn_relax {
    ss_arena arena;
    const ss_cnn_network *network;
    int32_t steps;        /* of the network, an advance */
    double step;          /* of its own time: C = 1, so in m^2 over the unit of rho */
    double time_constant; /* of its slowest mode */
    int64_t bytes;
    /* equation (20) times the step: v_i := stay_i v_i + sum_p share_p v_neighbour(p) */
    int32_t *row; /* node_count + 1: first entry of a node; none at held cells */
    int32_t *neighbour;
    double *share, *stay;
    double *edge_scale; /* rho_ij / L0_ij^2 */
    /* states: slots, of which WIDTH make a block */
    int32_t cell_count; /* that may be in use; one slot each at least */
    int32_t block_count;
    int32_t *slot_of; /* of a node, -1: not in use */
    int32_t *cell;    /* of a slot, -1: free */
    int64_t *seen;    /* of a slot: the last look that asked for it */
    int64_t look;
    double (**block)[SS_CNN_RELAX_WIDTH]; /* node_count rows each, and one to advance into */
    ss_real *kap;                         /* slot x edges.padded_count */
} ss_cnn_relax;

/* `held`: cells at zero, as the network has them; `is_cell`: those that may be in use; `steps` of
 * the network an advance. Adds a line per fault to `error`. Thread: set-up only. */
softsim_status ss_cnn_relax_create(const ss_cnn_network *network, const ss_mesh *mesh,
                                   const uint8_t *held, const uint8_t *is_cell, int32_t steps,
                                   ss_cnn_relax **out_relax, softsim_error *error);
void ss_cnn_relax_destroy(ss_cnn_relax **relax);
/* No cell is in use. */
void ss_cnn_relax_reset(ss_cnn_relax *relax);

/* A new look at which cells are in use: those asked for from here on. */
void ss_cnn_relax_look(ss_cnn_relax *relax);
/* Takes cells into use, from 0 where they were not, and returns their columns, valid until the
 * next reset; 0 everywhere before the first advance. */
void ss_cnn_relax_influence(ss_cnn_relax *relax, int32_t count, const int32_t *node,
                            const ss_real **out_column);
/* `steps` steps of every cell that the last look asked for; the others are let go. False when
 * there was none, and no column has changed. */
bool ss_cnn_relax_advance(ss_cnn_relax *relax);

/* Potential at `node` for a unit source on the cell of `slot`. */
double ss_cnn_relax_potential(const ss_cnn_relax *relax, int32_t slot, int32_t node);
/* Steps after which the slowest mode has fallen to `share` of its size. */
double ss_cnn_relax_steps_to(const ss_cnn_relax *relax, double share);
