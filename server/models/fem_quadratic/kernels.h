/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Forces of ten-node tetrahedra, several at a time: the hot loops of `fem-quadratic`, compiled once
 * per SIMD path and chosen at start by the processor.
 *
 * In: blocks of eight elements and the displacements (velocities) of nodes as quads x y z 0. Out:
 * forces added to quads, energies. The laws are those of tissue_law.h in ss_real, from
 * common/fem_element.h. Sums over the body are taken in double at the end of runs of blocks.
 * Memory: blocks are of the arena that they were made with; a pass only borrows. Thread: any,
 * RT-safe; ss_quadratic_blocks_create set-up only.
 */
#include "models/common/fem_kernels.h"

/* An element's nodes: corners 0 to 3, then the edges 01, 02, 03, 12, 13, 23. */
enum {
    SS_QUADRATIC_NODES = 10,
    SS_QUADRATIC_SIDES = 6,
    SS_QUADRATIC_POINTS = 4, /* Gauss points */
    SS_QUADRATIC_MODULI = 3
};

/* Block b, lane l: values of one kind are SS_FEM_LANES in a row. Straight elements come first, in
 * blocks of their own. A block that is not full has lanes of zeros at node 0. */
typedef struct ss_quadratic_blocks {
    int32_t count, straight_count; /* of blocks */
    int32_t element_count, node_count;
    int32_t *node;      /* [count][10][8], node number x 4 */
    ss_real *shape;     /* [straight][9][8]: grad lambda_1, grad lambda_2, grad lambda_3, 1/m */
    ss_real *curved;    /* [count - straight][4 points][9 + 1][8]: the same at the point, and its
                           share of the volume */
    ss_real *modulus;   /* [count][3][8]: V lambda_own, V mu, V (lambda - lambda_own), J */
    ss_real *viscosity; /* [count][2][8]: V phi, V psi, J s; NULL without viscosity */
    ss_real *kappa;     /* [count][8]: V (lambda + 2 mu), J; the guard's */
    ss_real *light;     /* [count][10][8]: 1 / (mass omega^2), s^2/kg: of a node's part, at rest */
    int32_t *element;   /* [count][8]: number in the mesh; -1 in spare lanes */
} ss_quadratic_blocks;

/* One sweep over the blocks; fields that a kernel does not name are not looked at. */
typedef struct ss_quadratic_pass {
    const ss_quadratic_blocks *blocks;
    ss_tissue_kind kind;
    const ss_real *u;
    const ss_real *v; /* NULL: no viscous stress */
    const ss_real *x; /* direction of the tangent */
    ss_real *out;     /* quads, added to */
    bool wants_energy;
    double energy, power; /* J, W: added to */
    double strain;        /* largest |2E|^2 (Frobenius) of a Gauss point: raised to */
    ss_real *strains;     /* [count][8]: the same of each element, set; NULL: not wanted */
    const int32_t *block; /* blocks that `rate` and `ratio` visit */
    int32_t block_count;
    ss_real *mode; /* [count][10][3][8]: a motion of each element's own nodes */
    ss_real *rate; /* [count][8] */
} ss_quadratic_pass;

typedef struct ss_quadratic_kernels {
    const char *name;
    /* out -= dW/du; energy if wanted, power with v, strain. */
    void (*force)(ss_quadratic_pass *pass);
    /* out += K x, K the exact tangent at u (viscosity left out). */
    void (*tangent)(ss_quadratic_pass *pass);
    /* A step of power iteration in each element by itself, with its own tangent at u and its own
     * part of the mass, 1/(36 light) on a corner and 4/(27 light) on an edge: mode := M^-1 K mode,
     * normed to mode.M mode = 1, and the eigenvalue that it stands for into `rate`, from above. */
    void (*rate)(const ss_quadratic_pass *pass);
    /* The least J of each element's Gauss points: [count][8]. */
    void (*ratio)(const ss_quadratic_pass *pass, ss_real *out_ratio);
} ss_quadratic_kernels;

/* The best path that this processor runs. */
const ss_quadratic_kernels *ss_quadratic_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_quadratic_kernels *ss_quadratic_kernels_path(int32_t index);
