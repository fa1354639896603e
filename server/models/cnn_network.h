/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The cellular neural network on a triangle surface: who is connected to whom and how strongly,
 * and what the network's equilibrium looks like for a source on any one cell.
 *
 * In: a mesh, which cells are held at zero, rho of every node. Out: templates w_ij, cell areas
 * S_i, and for a source on cell i the column kap_i = q_i / Qhat_i of normalised flux densities on
 * the edges. Memory belongs to the network. Set-up is by any one thread; reading columns is for
 * one simulation thread at a time, since the compact form keeps a cache.
 * Not done: rectangular grids, anisotropic rho, relaxation of the cells in time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "models/cnn_kernels.h"
#include "softsim/types.h"

/* Up to this many columns are kept as they are used (edges x columns scalars); beyond it as
 * potentials (nodes x columns), from which a column is rebuilt when its cell is touched. */
enum { SS_CNN_WHOLE_COLUMNS = 2000 };
/* Bytes that compact columns may take; a tool on a larger mesh is refused. */
#define SS_CNN_COLUMN_BYTES (INT64_C(256) << 20)
/* Nodes from which a body is divided into blocks, so that parts of it can be left out of a step. */
enum { SS_CNN_LARGE_BODY = 4096 };
/* Columns rebuilt and kept in the compact form; more touched cells go in batches of this size. */
enum { SS_CNN_CACHE_SLOTS = 512 };

/* L D L' of the templates over the cells that are neither held nor pinned. */
typedef struct ss_cnn_factor {
    int n;             /* unknowns */
    int *unknown;      /* node to position in the permuted system; -1 held, pinned or loose */
    int *column, *row; /* of L */
    double *lower, *diagonal;
    int32_t *component;  /* of a node; -1 loose */
    uint8_t *is_drained; /* a component: no held cell, hence a uniform sink */
    double *component_area;
    double *rho;
} ss_cnn_factor;

typedef struct ss_cnn_network {
    int32_t node_count, component_count, triangle_nodes; /* nodes that have a triangle */
    double mean_edge;                                    /* m */
    double *area;                                        /* S_i, m^2 */
    double *edge_rho;                                    /* rho_ij, harmonic mean */
    double *edge_square;                                 /* L0_ij^2, m^2 */
    double *edge_weight;                                 /* w_ij */
    ss_cnn_edges edges;
    ss_cnn_rows rows;   /* cells that may move */
    ss_cnn_rows held;   /* cells held at zero, for reactions */
    uint8_t *is_source; /* cells that can carry a source */
    /* of the solved columns, by node; 0 where not solved */
    double *qhat; /* m^2 */
    double *own;  /* ghat_i at cell i, 1 / (rho's unit) m^2 */
    double median_qhat;
    /* columns, by node number through column_of (-1: none) */
    int32_t column_count;
    int32_t *column_of;
    bool is_compact;
    ss_real *kap;        /* whole: column_count x edges.padded_count, 1/m^2 */
    ss_real *ghat;       /* compact: column_count x node_count */
    ss_real *edge_scale; /* compact: rho_ij / L0_ij^2 */
    int32_t slot_count, slot_next;
    int32_t *slot_of, *slot_node; /* node to slot or -1 and back */
    int64_t *slot_used, slot_clock;
    ss_cnn_factor *factor;
} ss_cnn_network;

/* Templates and factor. `held`: cells at zero (non-zero bytes); `rho` > 0 a node. Adds a line per
 * fault to `error`. Thread: set-up only. */
softsim_status ss_cnn_network_create(const ss_mesh *mesh, const uint8_t *held, const double *rho,
                                     ss_cnn_network **out_network, softsim_error *error);
void ss_cnn_network_destroy(ss_cnn_network **network);

/* Solves the column of every cell that can carry a source on `threads` threads; the result does
 * not depend on their number. Thread: set-up only. */
softsim_status ss_cnn_network_solve_all(ss_cnn_network *network, int32_t threads,
                                        softsim_error *error);
/* kap = sum_k weight[k] kap_node[k] on the edges, in double; fills qhat and own of these cells.
 * Thread: set-up only. */
softsim_status ss_cnn_network_superpose(ss_cnn_network *network, int32_t count, const int32_t *node,
                                        const double *weight, double *out_kap);

/* Readies the columns of at most SS_CNN_CACHE_SLOTS cells and returns them in `out_column`, valid
 * until the next call; a cell without a column gets NULL. RT-safe. */
void ss_cnn_network_columns(ss_cnn_network *network, int32_t count, const int32_t *node,
                            const ss_real **out_column);
int64_t ss_cnn_network_bytes(const ss_cnn_network *network);
/* Bytes of the columns that solve_all would make. */
int64_t ss_cnn_network_column_bytes(const ss_cnn_network *network);

/* ---- parts of ss_cnn_network_create; set-up only ------------------------------------------ */

/* cnn_templates.c: edges with w_ij, rho_ij and their rest vectors; S_i; are all edges long enough?
 */
softsim_status ss_cnn_network_build_edges(ss_cnn_network *network, const ss_mesh *mesh,
                                          const double *rho);
void ss_cnn_network_build_areas(ss_cnn_network *network, const ss_mesh *mesh);
bool ss_cnn_network_edges_are_usable(const ss_cnn_network *network, softsim_error *error);
/* cnn_rows.c: rows of the cells with held[i] == wanted, block by block in groups of equal degree,
 * in node order within. */
softsim_status ss_cnn_network_build_rows(ss_cnn_network *network, const uint8_t *held, bool wanted,
                                         ss_cnn_rows *rows);
void ss_cnn_rows_fini(ss_cnn_rows *rows);
