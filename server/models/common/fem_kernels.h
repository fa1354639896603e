/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Forces of tetrahedra, eight at a time: the hot loops of every model made of them, compiled once
 * per SIMD path and chosen at start by the processor.
 *
 * In: blocks of eight elements and the displacements (velocities) of nodes as quads x y z 0. Out:
 * forces added to quads, energies. The laws are those of tissue_law.h, in ss_real; symbols as
 * there. Sums over the body are taken in double at the end of runs of 32 blocks.
 * Memory: blocks are of the arena that they were made with; a pass only borrows. No kernel
 * allocates or depends on the number of threads. Thread: any, RT-safe; ss_fem_blocks_create set-up
 * only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "models/tissue_law.h"
#include "rt/arena.h"
#include "rt/real.h"

/* J below which a body of quadratic elements lets neo-hookean go on as a straight line. */
#define SS_FEM_HELD_FLOOR 0.3

enum { SS_FEM_LANES = 8, SS_FEM_SHAPES = 9, SS_FEM_MODULI = 2 };

/* Block b, lane l: values of one kind are eight in a row. A last block that is not full has lanes
 * of zeros at node 0. */
typedef struct ss_fem_blocks {
    int32_t count;         /* of blocks */
    int32_t element_count; /* of elements */
    int32_t node_count;
    int32_t *node;      /* [count][4 corners][8], node number x 4 */
    ss_real *shape;     /* [count][9][8]: grad N1, grad N2, grad N3, 1/m */
    ss_real *modulus;   /* [count][2][8]: V lambda of the element's own, V mu, J */
    ss_real *viscosity; /* [count][2][8]: V phi, V psi, J s; NULL without viscosity */
    ss_real *kappa;     /* [count][8]: V (lambda + 2 mu), J; the guard's */
    ss_real *volume;    /* [count][8]: V where it counts for the pressure of nodes, else 0, m^3 */
    int32_t *element;   /* [count][8]: number in the mesh; -1 in spare lanes */
} ss_fem_blocks;

/* One entry an element. */
typedef struct ss_fem_moduli {
    const double *lambda_own;  /* Pa: the share of lambda that is not averaged at nodes */
    const double *lambda, *mu; /* Pa */
    const double *phi, *psi;   /* Pa s; NULL: no viscosity */
} ss_fem_moduli;

/* Those of element e times its volume, each into a lane; `viscosity` may be NULL. */
static inline void ss_fem_put_moduli(const ss_fem_moduli *of, int32_t e, double volume,
                                     ss_real *modulus, ss_real *kappa, ss_real *viscosity)
{
    modulus[0] = (ss_real)(volume * of->lambda_own[e]);
    modulus[SS_FEM_LANES] = (ss_real)(volume * of->mu[e]);
    *kappa = (ss_real)(volume * (of->lambda[e] + 2.0 * of->mu[e]));
    if (viscosity) {
        viscosity[0] = (ss_real)(volume * of->phi[e]);
        viscosity[SS_FEM_LANES] = (ss_real)(volume * of->psi[e]);
    }
}

/* Of nodes. */
static inline void ss_fem_add_diagonal(int32_t count, const double *from, double *diagonal)
{
    for (int32_t i = 0; i < count; ++i) {
        diagonal[i] += from[i];
    }
}

/* What the blocks are made of. */
typedef struct ss_fem_stuff {
    int32_t node_count;
    const ss_mesh *mesh; /* its tetrahedra */
    ss_fem_moduli moduli;
    const double *volume_share; /* of the rest volume that counts, 0..1; NULL: all of it */
} ss_fem_stuff;

/* Room for `element_count` elements and no elements yet: `element` is -1, all else 0. False when
 * out of memory. */
bool ss_fem_blocks_reserve(int32_t element_count, int32_t node_count, bool is_viscous,
                           ss_arena *arena, ss_fem_blocks *out_blocks);
/* False when out of memory. */
bool ss_fem_blocks_create(const ss_fem_stuff *stuff, ss_arena *arena, ss_fem_blocks *out_blocks);

/* One sweep over the blocks; fields that a kernel does not name are not looked at. */
typedef struct ss_fem_pass {
    const ss_fem_blocks *blocks;
    ss_tissue_kind kind;
    const ss_real *u;
    const ss_real *v;        /* NULL: no viscous stress */
    const ss_real *x;        /* direction of the tangent */
    const ss_real *pressure; /* p of a node in the first lane of its quad, Pa; NULL: none */
    const ss_real *change;   /* of p along x, in the same layout */
    ss_real *out;            /* quads, added to */
    bool wants_energy;
    double energy, power; /* J, W: added to */
    double strain;        /* largest |2E|^2 (Frobenius) of an element: raised to */
} ss_fem_pass;

typedef struct ss_fem_kernels {
    const char *name;
    /* out += -V P grad N; energy if wanted, power with v, strain. */
    void (*force)(ss_fem_pass *pass);
    /* out += K x, K the exact tangent at u (viscosity left out). */
    void (*tangent)(ss_fem_pass *pass);
    /* out's first lanes += V q around each node, q the dilatation that the law resists (tr E, J - 1
     * or tr e); with x its change along x. */
    void (*dilate)(ss_fem_pass *pass);
    /* For each element out_ratio = J, and of stvk and stvk-guarded how much omega^2 can have grown
     * since rest, at least 1: arrays [count][8]. */
    void (*growth)(const ss_fem_pass *pass, ss_real *out_growth, ss_real *out_ratio);
} ss_fem_kernels;

/* The best path that this processor runs. */
const ss_fem_kernels *ss_fem_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_fem_kernels *ss_fem_kernels_path(int32_t index);
