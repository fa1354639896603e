/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The hot loops of the particle layer, compiled once per SIMD path and chosen at start.
 *
 * A pass knows which particles are near (their place is needed: they are integrated or neighbours
 * of one that is) and which are points (integrated). In: displacements and velocities of the body's
 * nodes. Out: forces on them. Between `strain` and `push` the law of the tetrahedra
 * (common/fem_kernels.h) turns the gradients of the points into stresses: each is an element on
 * three unit edges, so that its nodes' displacements are the columns of H. layer_kernels.c derives
 * the loops. Memory is borrowed; no kernel allocates. Thread: any, RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "models/layer.h"

/* The near particles side by side, as rows of a layer have them: the points first. */
typedef struct ss_layer_near {
    int32_t count, point_count;
    int32_t *node_of;   /* node when it moves by itself, -1 when tied */
    ss_real *offset;    /* quads: a tied one is there beside its tie, m */
    int32_t *tie_first; /* count + 1 */
    int32_t *tie_node;
    ss_real *tie;
    int32_t *pair_first; /* point_count + 1 */
    int32_t *neighbour;  /* by their places here */
    ss_real *pair, *pair_scale, *moment;
} ss_layer_near;

typedef struct ss_layer_pass {
    const ss_layer_near *near;
    const ss_real *u, *v;       /* of the body's nodes; v may be NULL: velocities are left 0 */
    ss_real *force;             /* of the body's nodes, added to */
    ss_real *state;             /* by near particle, pairs: u, v */
    ss_real *particle_force;    /* by near particle, quads */
    const ss_real *coefficient; /* 2 a point: kappa of the residual (N/m), of the cohesion (N m) */
    ss_real *gradient;     /* pairs: 0 nothing; 1 + 3 k + c column c of H and Hdot of point k */
    ss_real *spread;       /* pairs, by point: sum w u^2, w v^2 by axis */
    const ss_real *stress; /* pairs, by point, first quad: -V P, column c */
} ss_layer_pass;

/* Cells that sleeping particles are counted by: gradients that are fixed rows over nodes. */
typedef struct ss_layer_cells {
    int32_t count;
    int32_t *first; /* count + 1 */
    int32_t *node;
    ss_real *row;      /* quads: H = sum u row^T, 1/m */
    ss_real *gradient; /* as a pass has them, of its cells */
    ss_real *stress;
} ss_layer_cells;

typedef struct ss_layer_kernels {
    const char *name;
    /* gradient of every cell; `v` may be NULL. */
    void (*strain_cells)(const ss_layer_cells *cells, const ss_real *u, const ss_real *v);
    /* force += stress of every cell. */
    void (*push_cells)(const ss_layer_cells *cells, ss_real *force);
    /* state of the near particles from the nodes; clears their forces. */
    void (*place)(const ss_layer_pass *pass);
    /* gradient of every point. */
    void (*strain)(const ss_layer_pass *pass);
    /* particle_force += stress, residual and, where asked for, cohesion forces of every point;
     * returns the energy of the cohesion where wanted, J. */
    double (*push)(const ss_layer_pass *pass, bool is_cohesive, bool wants_energy);
    /* force += what the near particles' forces are on the nodes. */
    void (*give)(const ss_layer_pass *pass);
} ss_layer_kernels;

/* The best path that this processor runs. */
const ss_layer_kernels *ss_layer_kernels_get(void);
/* All paths built in, best first, for tests; NULL beyond the last. */
const ss_layer_kernels *ss_layer_kernels_path(int32_t index);
