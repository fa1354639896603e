/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The particle layer of `hybrid` at rest: particles on a cubic lattice between a core of tetrahedra
 * and the surface around both, and the fixed rows that join particles, nodes and skin.
 *
 * In: a mesh whose tetrahedra are the core and whose closed surface holds core and layer
 * (ss_mesh_add_skin, ss_mesh_grow_skin); a spacing. Out: positions, volumes, neighbours with the
 * moving-least-squares moments, ties of particles to nodes, rows of skin nodes over particles.
 * layer.c derives them. Positions are the mesh's, in double: only differences are ever used.
 * Memory belongs to the layer. Thread: create and destroy set-up only; then read-only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "rt/arena.h"
#include "rt/real.h"

/* Support of the weights in spacings, and the share of it within which particles are neighbours.
 * The second shell (root 2) is inside. The third (root 3) has a fortieth of the first one's weight,
 * 4 % of the moment and a third of the pairs: left out, forces change by about 1 % and a step
 * takes an eighth less. */
#define SS_LAYER_SUPPORT 1.95
#define SS_LAYER_CUT     0.8

enum {
    SS_LAYER_TIE = 16,       /* nodes of a particle's tie outside the core */
    SS_LAYER_SKIN = 16,      /* particles of a skin node's row */
    SS_LAYER_MAX_PAIRS = 192 /* neighbours of a particle; more are where spacings differ */
};

typedef struct ss_layer_plan {
    const ss_mesh *mesh;
    double spacing;           /* m; the coarsest where it varies */
    const double *spacing_of; /* m, by mesh node; NULL: the same everywhere */
} ss_layer_plan;

typedef struct ss_layer {
    ss_arena arena;
    int32_t count; /* of particles: the layer's own, then ghosts inside the core */
    int32_t own_count;
    double (*rest)[3];   /* m */
    double *spacing;     /* m */
    double *volume;      /* m^3; a tetrahedron's ghosts take at most 95 % of it */
    int32_t *host;       /* tetrahedron that the particle is in or that reaches out to it best */
    int32_t *pair_first; /* count + 1 */
    int32_t *neighbour;  /* of each pair, nearest first */
    ss_real *pair;       /* 4 a pair: w X (m), w, with X from the particle to the neighbour */
    ss_real *pair_scale; /* 1/(w |X|^2), 1/m^2 */
    ss_real *moment;     /* 8 a particle: inverse of A = sum w X X^T as xx xy xz yy yz zz (1/m^2),
                            1 / sum w |X|^2, sum w */
    int32_t *tie_first;  /* count + 1 */
    int32_t *tie_node;
    ss_real *tie;
    int32_t skin_count;  /* nodes of the mesh without a tetrahedron */
    int32_t *skin_node;  /* number in the mesh */
    int32_t *skin_of;    /* by mesh node: its place in skin_node, -1 a node of the core */
    int32_t *skin_first; /* skin_count + 1 */
    int32_t *skin_particle;
    ss_real *skin;
    int32_t *skin_tie_first; /* skin_count + 1: rows of skin nodes straight over core nodes */
    int32_t *skin_tie_node;
    ss_real *skin_tie;
    double layer_volume;   /* m^3, between core and surface */
    int32_t dropped_count; /* lattice places with too few neighbours to be particles */
    int32_t far_count;     /* skin nodes whose tie to the core extrapolates too far */
    double farthest_tie;   /* the largest sum of absolute weights of a skin node's tie */
} ss_layer;

softsim_status ss_layer_create(const ss_layer_plan *plan, ss_layer **out_layer,
                               softsim_error *error);
void ss_layer_destroy(ss_layer **layer);

/* The pair potential phi(s) = (s^-3 - 3 s^-1)/2, s = r/r0, least (-1) at s = 1, with the linear and
 * constant forces below and above: its value, and its slope in *out_slope. */
double ss_layer_pair_potential(double s, double *out_slope);
#define SS_LAYER_CORE 0.7                /* linear force below this s */
#define SS_LAYER_TAIL 1.4142135623730951 /* constant above: there cohesion is greatest */

/* ---- inside the layer's set-up ---- */

/* A place of the lattice. */
typedef struct ss_layer_site {
    double x[3], spacing;
    int32_t host; /* tetrahedron that holds it, -1 none: between core and surface */
} ss_layer_site;

typedef struct ss_layer_sites {
    ss_layer_site *site;
    int32_t count, capacity;
} ss_layer_sites;

/* All places inside the surface, coarsest spacing first and then by z, y, x; those in tetrahedra
 * deeper than the layer's neighbourhood included. To be freed by the caller. */
softsim_status ss_layer_list_sites(const ss_layer_plan *plan, ss_layer_sites *out_sites,
                                   softsim_error *error);

/* Linear-reproducing weights of the points at `x` (moving least squares): sum T = 1, sum T X = at.
 * False when the points do not span space or the weights' absolute values sum to `limit` or more.
 */
bool ss_layer_fit_row(const double at[3], int32_t count, const double (*x)[3], const double *square,
                      double limit, double *out_weight);
