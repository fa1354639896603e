/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The hot loops of cnn-energy, compiled once per SIMD path and chosen at start by the processor.
 *
 * In and out: plain arrays, 64-byte aligned, nodes as quads x y z 0. Arithmetic is ss_real in
 * lanes; sums over the body are taken in double at the end of blocks of 32 rows. No kernel
 * allocates, branches on data or depends on the number of threads. Symbols as in cnn_energy.c.
 * Thread: any, RT-safe.
 */
#include <stddef.h>
#include <stdint.h>

#include "rt/real.h"

/* The network as rows of a symmetric sparse product. Rows of free nodes only, grouped by degree,
 * because a branch that mispredicts at every third node costs as much as the row itself; and
 * grouped within blocks of consecutive nodes, so that a part of a large body is a few ranges of
 * groups. */
typedef struct ss_cnn_group {
    int32_t degree, row_count, first_row, first_entry;
} ss_cnn_group;

typedef struct ss_cnn_rows {
    int32_t group_count, row_count, entry_count;
    int32_t block_size, block_count; /* nodes of a block: 64, or all of a small body's */
    int32_t *block_group;            /* first group of a block; block_count + 1 */
    ss_cnn_group *group;
    int32_t *node;      /* row: node number x 4, an offset into quad arrays */
    int32_t *neighbour; /* entry: node number x 4 */
    int32_t *edge;      /* entry: number of the edge */
    ss_real *arm;       /* entry: P0_i - P0_j and 1, m */
} ss_cnn_rows;

/* Edges i < j at rest; count padded to a multiple of 8 with edges from node 0 to node 0. */
typedef struct ss_cnn_edges {
    int32_t count, padded_count;
    int32_t *from, *to; /* node number x 4 */
    ss_real *x, *y, *z; /* P0_j - P0_i, m */
} ss_cnn_edges;

/* Columns that are solved at a time, side by side. */
enum { SS_CNN_SOLVE_WIDTH = 8 };

/* Consecutive blocks: their nodes and groups of rows. */
typedef struct ss_cnn_span {
    int32_t node, node_end; /* even; the end may be one beyond the last node */
    int32_t group, group_end;
} ss_cnn_span;

/* What a kernel works on: the whole body, or its blocks that move. */
typedef struct ss_cnn_part {
    int32_t count;
    ss_cnn_span *span; /* in the order of nodes */
} ss_cnn_part;

/* Arrays of nodes are this long, since kernels take two nodes at a time; the spare one is 0. */
static inline size_t ss_cnn_padded(int32_t node_count)
{
    return ((size_t)node_count + 1) / 2 * 2;
}

typedef struct ss_cnn_totals {
    double kinetic; /* sum m v^2, J x 2 */
    double rest;    /* sum ks u^2 */
    double largest; /* an upper bound of the largest |u|^2, m^2 */
} ss_cnn_totals;

/* One RK4 stage: a = (force - c1 r + c2 b - p N - ks d - gamma v) / m, then u and v of the next
 * stage (stages 0 to 2) or of the step's end (stage 3). */
typedef struct ss_cnn_stage {
    const ss_cnn_part *part;
    int32_t index;
    double h;                              /* s */
    double c1, c2, pressure;               /* c1 = T + a T0, c2 = a T0 in N; pressure in Pa */
    const ss_real *force, *r, *b, *normal; /* quads; r NULL: no source; normal NULL: no pressure */
    const ss_real *rest_stiffness, *damping, *mass; /* a node, N/m, N s/m and kg */
    const ss_real *mobility;                        /* quad, 1/kg; 0 on fixed and prescribed axes */
    const ss_real *u0, *v0, *low0; /* at the step's start; low: rounding error of u */
    const ss_real *d;              /* of this stage: u, or P - P* of a free body */
    ss_real *us;                   /* u of the next stage; may be d */
    ss_real *vs[3];                /* v of stages 1 to 3 */
    ss_real *u, *v, *low;          /* at the step's end */
    ss_cnn_totals totals;          /* of u and v, by stage 3 */
    double volume;                 /* sum N.u of what was written (us, or u), m^3 */
} ss_cnn_stage;

/* What a block does that the far field does not do by itself; see active_set.c. */
typedef struct ss_cnn_unrest {
    double displacement, motion, drive; /* largest |u|^2, deviation^2 and |force/ks|^2, m^2 */
} ss_cnn_unrest;

typedef struct ss_cnn_kernels {
    const char *name;
    /* r = b + L u over the rows of `part` (b NULL: r = L u); out_ub = u.b, out_ur = u.r. */
    void (*product)(const ss_cnn_rows *rows, const ss_cnn_part *part, const ss_real *kap,
                    const ss_real *b, const ss_real *u, ss_real *r, double *out_ub, double *out_ur);
    /* From edges to rows: kap of every entry, b = L P0 and in its fourth lane the row sum. */
    void (*scatter)(const ss_cnn_rows *rows, const ss_cnn_part *part, const ss_real *kap_edge,
                    ss_real *kap, ss_real *b);
    /* strain = P0_e.u_e + |u_e|^2/2, stretch = |u_e|^2/2 (= (|P_e|^2 - L0^2)/2). */
    void (*strain)(const ss_cnn_edges *edges, const ss_real *u, ss_real *strain, ss_real *stretch);
    /* sum += weight[c] column[c] for `count` columns; eps[c] += column[c].strain, and the same for
     * eta. */
    void (*combine)(int32_t padded_count, int32_t count, const ss_real *const *column,
                    const double *weight, const ss_real *strain, const ss_real *stretch,
                    ss_real *sum, double *eps, double *eta);
    /* Returns the power lost to damping at this stage, W. */
    double (*stage)(ss_cnn_stage *stage);
    void (*total)(const ss_cnn_part *part, const ss_real *u, const ss_real *v,
                  const ss_real *rest_stiffness, const ss_real *mass, ss_cnn_totals *out);
    /* y += s x over quads. */
    void (*axpy)(const ss_cnn_part *part, double s, const ss_real *x, ss_real *y);
    /* x.y over quads. */
    double (*dot)(const ss_cnn_part *part, const ss_real *x, const ss_real *y);
    /* out = ks x + c y - out (y may be NULL); returns x.out. */
    double (*tangent)(const ss_cnn_part *part, const ss_real *rest_stiffness, const ss_real *x,
                      double c, const ss_real *y, ss_real *out);
    /* One update of conjugate gradients: y += s p, res -= s q, z = inverse res; returns res.z. */
    double (*descend)(const ss_cnn_part *part, double s, const ss_real *p, const ss_real *q,
                      const ss_real *inverse, ss_real *y, ss_real *res, ss_real *z);
    /* stiff += c times the fourth lane of b. */
    void (*add_rows)(const ss_cnn_part *part, double c, const ss_real *b, double *stiff);
    /* The largest a_i b_i, at least 0. */
    double (*largest)(const ss_cnn_part *part, const double *a, const double *b);
    /* sum |r|^2 / m */
    double (*weighted_square)(const ss_cnn_part *part, const ss_real *r, const ss_real *mobility);
    /* u = -mobility sum_m y[m] f[m], v the same with w: where `count` forces have led the nodes. */
    void (*follow)(const ss_cnn_part *part, int32_t count, const ss_real *const *f, const double *y,
                   const double *w, const ss_real *mobility, ss_real *u, ss_real *v);
    /* The same u for a list of nodes (numbers x 4). */
    void (*follow_nodes)(int32_t node_count, const int32_t *node, int32_t count,
                         const ss_real *const *f, const double *y, const ss_real *mobility,
                         ss_real *u);
    /* out += c (b - r), the force -c L u; its fourth lane += c times that of b. */
    void (*neglect)(const ss_cnn_part *part, double c, const ss_real *r, const ss_real *b,
                    ss_real *out);
    /* The unrest of the nodes node..node_end, with rate2 = ks/m of all of them: motion from
     * (u - far_u)^2 + (v - far_v)^2 / rate2, drive from `force` with stiffness in its fourth lane.
     */
    void (*watch)(int32_t node, int32_t node_end, double rate2, const ss_real *u, const ss_real *v,
                  const ss_real *far_u, const ss_real *far_v, const ss_real *force,
                  const ss_real *mobility, ss_cnn_unrest *out);
    /* Set-up, in double, the same bits on every path. x := A^-1 x by the factor's L (n columns,
     * without its diagonal) and D. */
    void (*solve)(int32_t n, const int *column, const int *row, const double *lower,
                  const double *diagonal, double (*x)[SS_CNN_SOLVE_WIDTH]);
    /* The first `count` columns of potentials: out_qhat = sum_e rho |ghat_i - ghat_j|, and, unless
     * `out` is NULL, out[k][e] = rho |ghat_i - ghat_j| / (square qhat). */
    void (*fluxes)(const ss_cnn_edges *edges, const double *rho, const double *square,
                   const double (*ghat)[SS_CNN_SOLVE_WIDTH], int32_t count, double *out_qhat,
                   ss_real *const *out);
} ss_cnn_kernels;

/* The best path that this processor runs. */
const ss_cnn_kernels *ss_cnn_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_cnn_kernels *ss_cnn_kernels_path(int32_t index);
