/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The hot loops of xpbd, once per SIMD path: prediction, constraints of tetrahedra eight at a time,
 * velocities. kernels.c derives them.
 *
 * In: packs of eight tetrahedra of which no two share a node, the predicted way of nodes in a
 * sub-step as quads x y z 0. Out: the same quads, corrected. Memory: ss_xpbd_packs owns what it
 * points to. Thread: any, RT-safe; ss_xpbd_packs_create set-up only.
 */
#include "models/common/fem_kernels.h"

/* Pack b, lane l: values of one kind are eight in a row. Spare lanes are zeros at node 0. */
typedef struct ss_xpbd_packs {
    int32_t count;         /* of packs */
    int32_t element_count; /* of tetrahedra */
    int32_t *node;         /* [count][4 corners][8], node number x 4 */
    ss_real *shape;        /* [count][9][8]: grad N1, grad N2, grad N3, 1/m */
    ss_real *modulus;      /* [count][2][8]: V lambda, V mu, J */
    ss_real *light;        /* [count][4][8]: w of the corners, 1/kg, 0 where held on all axes */
    ss_real *spread; /* [count][6][8]: S = sum w grad N grad N^T, xx yy zz yz xz xy, 1/(kg m^2) */
    uint8_t *is_partial; /* a corner is held along some axes only */
} ss_xpbd_packs;

/* Element e has corners corner[e], at rest at position[.]; lambda and mu in Pa; mobility: quads,
 * 1/kg by axis. False when out of memory. */
bool ss_xpbd_packs_create(int32_t element_count, const int32_t (*corner)[4],
                          const double (*position)[3], const double *lambda, const double *mu,
                          const ss_real *mobility, ss_arena *arena, ss_xpbd_packs *out_packs);

typedef struct ss_xpbd_pass {
    const ss_xpbd_packs *packs;
    ss_tissue_kind kind; /* SS_TISSUE_NEO_HOOKEAN or SS_TISSUE_STABLE_NEO_HOOKEAN */
    double h;            /* s */
    const ss_real *u;    /* where held axes belong */
    const ss_real *mobility;
    ss_real *step; /* the predicted way from u, corrected; 0 along held axes */
    double least;  /* lowered to the least J met */
} ss_xpbd_pass;

typedef struct ss_xpbd_kernels {
    const char *name;
    /* step := h (keep v + h mobility force) along axes that may move, else 0. */
    void (*predict)(int32_t padded_count, double h, double keep, const ss_real *mobility,
                    const ss_real *force, const ss_real *v, ss_real *step);
    void (*constrain)(ss_xpbd_pass *pass);
    /* v := step/h and u += step along axes that may move. */
    void (*finish)(int32_t padded_count, double h, const ss_real *mobility, const ss_real *step,
                   ss_real *u, ss_real *v);
} ss_xpbd_kernels;

const ss_xpbd_kernels *ss_xpbd_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_xpbd_kernels *ss_xpbd_kernels_path(int32_t index);
