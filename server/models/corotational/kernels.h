/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The hot loops of the corotational model, compiled once per SIMD path and chosen at start by the
 * processor. kernels.c derives them.
 *
 * In and out: blocks of eight tetrahedra (common/fem_kernels.h), arrays of nodes as quads x y z 0
 * on 64 bytes, padded to a multiple of 8 scalars with zeros. Moduli are laid out as those of the
 * blocks: Lame's constants, or viscosities, times the rest volume. No kernel allocates or depends
 * on the number of threads. Thread: any, RT-safe.
 */
#include <stdint.h>

#include "models/common/fem_kernels.h"
#include "rt/real.h"

/* One evaluation of all elements at displacements u. */
typedef struct ss_corot_pass {
    const ss_fem_blocks *blocks;
    const ss_real *u;
    ss_real *turned; /* [count][9][8]: R grad N1, R grad N2, R grad N3, written */
    ss_real *force;  /* quads, added to */
    double energy;   /* J, stored */
    int32_t inverted_count, first_inverted; /* elements inside out; the first's number, or -1 */
} ss_corot_pass;

typedef struct ss_corot_kernels {
    const char *name;
    void (*evaluate)(ss_corot_pass *pass);
    /* out += scale K x, elements turned as they are. */
    void (*multiply)(const ss_fem_blocks *blocks, const ss_real *turned, const ss_real *modulus,
                     double scale, const ss_real *x, ss_real *out);
    /* Over `count` scalars: */
    double (*dot)(int32_t count, const ss_real *x, const ss_real *y);
    /* out = s a x */
    void (*scale)(int32_t count, double s, const ss_real *a, const ss_real *x, ss_real *out);
    /* p = z + s p */
    void (*turn)(int32_t count, double s, const ss_real *z, ss_real *p);
    /* x += s p, r -= s q, z = inverse r; returns r.z */
    double (*descend)(int32_t count, double s, const ss_real *p, const ss_real *q,
                      const ss_real *inverse, ss_real *x, ss_real *r, ss_real *z);
} ss_corot_kernels;

/* The best path that this processor runs. */
const ss_corot_kernels *ss_corot_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_corot_kernels *ss_corot_kernels_path(int32_t index);
