/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The cellular neural network on triangles, on a rectangular grid or in tetrahedra: who is
 * connected to whom and how strongly, and what the network's equilibrium looks like for a source
 * on any one cell.
 *
 * In: a mesh, what its cells conduct, which cells are held at zero. Out: templates c_ij, the
 * cells' sizes S_i (areas) or V_i (volumes), and for a source on cell i the column
 * kap_i = q_i / Qhat_i of normalised flux densities on the edges. Memory belongs to the network.
 * Set-up is by any one thread; reading columns is for one simulation thread at a time, since the
 * compact form keeps a cache.
 * The cells' own time is in relax.h.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "models/cnn/kernels.h"
#include "rt/arena.h"
#include "rt/factor.h"
#include "softsim/types.h"

/* Up to this many columns are kept as they are used (edges x columns scalars); beyond it as
 * potentials (nodes x columns), from which a column is rebuilt when its cell is touched. */
enum { SS_CNN_WHOLE_INFLUENCE = 2000 };
/* Bytes that compact columns may take; a tool on a larger mesh is refused. */
#define SS_CNN_INFLUENCE_BYTES (INT64_C(256) << 20)
/* Nodes from which a body is divided into blocks, so that parts of it can be left out of a step. */
enum { SS_CNN_LARGE_BODY = 4096 };
/* Columns rebuilt and kept in the compact form; more touched cells go in batches of this size. */
enum { SS_CNN_CACHE_SLOTS = 512 };

/* Multiplications that a factor may take, some twenty seconds: a surface of a million cells, a
 * volume of sixty thousand. Beyond, and beyond what the library counts, there is none. */
#define SS_CNN_MAX_WORK 4e10

/* What carries the cells: the triangles of a surface, its quads (a rectangular grid), or the
 * tetrahedra of a volume, whose inner nodes are cells too. */
typedef enum ss_cnn_element { SS_CNN_TRIANGLE, SS_CNN_QUAD, SS_CNN_TETRAHEDRON } ss_cnn_element;

/* What the cells conduct; borrowed while a network is created. */
typedef struct ss_cnn_fabric {
    const ss_mesh *mesh;
    ss_cnn_element element;
    const double *rho;              /* > 0 a node; anisotropic: along the material direction */
    const double *rho_across;       /* > 0 a node, across it; NULL: isotropic */
    const double *direction;        /* of all elements; NULL: as the next says */
    const double (*per_element)[3]; /* of each; NULL with `direction` NULL: a grid's own u */
    double max_work;                /* of a factor; 0: SS_CNN_MAX_WORK */
} ss_cnn_fabric;

/* What one element adds to the templates of its sides and to the sizes of its cells: sums over
 * elements are all there is, so that what an element leaves behind can be summed again. */
typedef struct ss_cnn_share {
    int corners, sides;
    int32_t node[4];   /* of the corners */
    int8_t side[6][2]; /* corners */
    double weight[6];  /* to w_ij of each side: none on surfaces, m in volumes */
    double along[6];   /* cos^2 of the side's angle to the material direction; 1: isotropic */
    double size[4];    /* to S_i or V_i of each corner: m^2 or m^3 */
} ss_cnn_share;

/* L D L' of the templates over the cells that are neither held nor pinned; or, where the factor
 * would be too full, the matrix itself, whose equilibria iterate.c finds. */
typedef struct ss_cnn_factor {
    int n;        /* unknowns */
    int *unknown; /* node to position in the permuted system; -1 held, pinned or loose */
    ss_factor ldl;
    bool is_given_up; /* there is no L, but the next, by columns, the diagonal first */
    ss_arena matrix;  /* its memory */
    int *entry_column, *entry_row;
    double *entry;
    int32_t *component;  /* of a node; -1 loose */
    uint8_t *is_drained; /* a component: no held cell, hence a uniform sink */
    double *component_size;
    double *rho;
} ss_cnn_factor;

typedef struct ss_cnn_network {
    ss_arena arena;
    int32_t node_count, component_count, cell_count; /* cells: nodes that have an element */
    double mean_edge;                                /* m */
    double largest_rho;                              /* of the edges: harmonic means */
    double *size;                                    /* S_i, m^2; in volumes V_i, m^3 */
    double *surface_area; /* of a node's triangles, a third, m^2; on surfaces `size` itself */
    double *edge_rho;     /* rho_ij of the flux densities; in volumes times w_ij, m */
    double *edge_square;  /* L0_ij^2, m^2 */
    double *edge_weight;  /* c_ij: none on surfaces, m in volumes */
    ss_cnn_edges edges;
    ss_cnn_rows rows;   /* cells that may move */
    ss_cnn_rows held;   /* cells held at zero, for reactions */
    uint8_t *is_source; /* cells that can carry a source */
    /* of the solved columns, by node; 0 where not solved */
    double *qhat; /* m^2; in volumes m^3 */
    double *own;  /* ghat_i at cell i, 1 / (rho's unit) m^2 */
    double median_qhat;
    /* columns, by node number through influence_of (-1: none) */
    int32_t influence_count;
    int32_t *influence_of;
    bool is_compact;
    ss_real *kap;        /* whole: influence_count x edges.padded_count, 1/m^2 */
    ss_real *ghat;       /* compact: influence_count x node_count */
    ss_real *edge_scale; /* compact: rho_ij / L0_ij^2 */
    int32_t slot_count, slot_next;
    int32_t *slot_of, *slot_node; /* node to slot or -1 and back */
    int64_t *slot_used, slot_clock;
    ss_cnn_factor *factor;
} ss_cnn_network;

/* Templates and factor. `held`: cells at zero (non-zero bytes). Adds a line per fault to `error`.
 * Thread: set-up only. */
softsim_status ss_cnn_network_create(const ss_cnn_fabric *fabric, const uint8_t *held,
                                     ss_cnn_network **out_network, softsim_error *error);
void ss_cnn_network_destroy(ss_cnn_network **network);

/* Solves the column of every cell that can carry a source on `threads` threads; the result does
 * not depend on their number. Without `is_kept` only qhat, own and median_qhat are left of them.
 * Thread: set-up only. */
softsim_status ss_cnn_network_solve_all(ss_cnn_network *network, bool is_kept, int32_t threads,
                                        softsim_error *error);
/* kap = sum_k weight[k] kap_node[k] on the edges, in double; fills qhat and own of these cells.
 * Thread: set-up only. */
softsim_status ss_cnn_network_superpose(ss_cnn_network *network, int32_t count, const int32_t *node,
                                        const double *weight, double *out_kap);

/* Potentials sum_k scale[k] ghat_node[k] of every node, in double. Thread: set-up only. */
softsim_status ss_cnn_network_potential(const ss_cnn_network *network, int32_t count,
                                        const int32_t *node, const double *scale,
                                        double *out_potential);

/* The same for source[i] (times a unit source) on every cell i at once; where a part is drained its
 * least potential is 0. Thread: one that may allocate; columns may be read meanwhile. */
softsim_status ss_cnn_network_spread(const ss_cnn_network *network, const float *source,
                                     float *out_potential);

/* The slowest time constant of v' = -(rho/S) W v, with C = 1: 1 / (the least eigenvalue), over all
 * parts; of a drained part the least that is not 0. Thread: set-up only. */
softsim_status ss_cnn_network_time_constant(const ss_cnn_network *network, double *out_time);

/* Readies the columns of at most SS_CNN_CACHE_SLOTS cells and returns them in `out_column`, valid
 * until the next call; a cell without a column gets NULL. RT-safe. */
void ss_cnn_network_influence(ss_cnn_network *network, int32_t count, const int32_t *node,
                              const ss_real **out_column);
/* iterate.c: x := A^-1 x without a factor; ERROR_MESH when it does not converge. */
softsim_status ss_cnn_iterate(const ss_cnn_factor *factor, double (*x)[SS_CNN_SOLVE_WIDTH]);
int64_t ss_cnn_network_bytes(const ss_cnn_network *network);
/* Bytes of the columns that solve_all would make. */
int64_t ss_cnn_network_influence_bytes(const ss_cnn_network *network);

/* ---- parts of ss_cnn_network_create; set-up only ---- */

/* templates.c: how many elements there are and what one of them adds; sizes S_i or V_i of all
 * nodes, -1 where a node has no element; edges with c_ij, rho_ij and their rest vectors; are all
 * edges long enough? */
int32_t ss_cnn_element_count(const ss_cnn_fabric *fabric);
void ss_cnn_element_share(const ss_cnn_fabric *fabric, int32_t element, ss_cnn_share *out_share);
void ss_cnn_cell_sizes(const ss_cnn_fabric *fabric, double *out_size);
softsim_status ss_cnn_network_build_edges(ss_cnn_network *network, const ss_cnn_fabric *fabric);
bool ss_cnn_network_edges_are_usable(const ss_cnn_network *network, const ss_mesh *mesh,
                                     softsim_error *error);
/* rows.c: rows of the cells with held[i] == wanted, block by block in groups of equal degree,
 * in node order within. */
softsim_status ss_cnn_network_build_rows(ss_cnn_network *network, const uint8_t *held, bool wanted,
                                         ss_cnn_rows *rows);
