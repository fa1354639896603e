/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The network of Zhang et al. (2018) once more, small and plain: double precision, one loop over
 * links, equations (5), (13) and (4) as printed, sharing no code with the model cnn-chainmail. The
 * report checks the model against it on the same protocol.
 *
 * In: nodes, elements whose edges are the links, fixed nodes, a patch that is moved along a
 * direction, alpha, k (of a node; a link has the mean of its ends'), C. Out: places, the force on
 * the patch. No coarse level, no saturation, no guard of tetrahedra. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

typedef enum ss_zhang_rule {
    SS_REFERENCE_KEEP,
    SS_REFERENCE_RAMP,
    SS_REFERENCE_LITERAL
} ss_zhang_rule;

typedef struct ss_zhang_reference {
    int32_t node_count, link_count;
    double (*rest)[3], (*at)[3]; /* m */
    double (*flow)[3];           /* dP of (12), m */
    int32_t (*link)[2];
    double *length;        /* m, at rest */
    double *weight;        /* k of a link over the mean k of nodes */
    uint8_t *is_held;      /* fixed nodes and the patch */
    const int32_t *pushed; /* the patch, borrowed */
    int32_t pushed_count;
    double direction[3];
    double alpha, stiffness, capacitance; /* -, N/m (the mean), s */
    double share;                         /* of alpha that acts */
    ss_zhang_rule rule;                   /* of unloading */
    double depth, deepest;                /* m */
    double stable_step;                   /* s: 4 C/max(s_a + s_b) */
    double force;                         /* N, along the push, as the patch has moved */
} ss_zhang_reference;

typedef struct ss_zhang_reference_plan {
    int32_t node_count, element_count, corners; /* 4: quads in a ring; -4: tetrahedra */
    const double (*rest)[3];
    const int32_t (*element)[4];
    const uint8_t *fixed; /* not 0: fixed */
    const int32_t *pushed;
    int32_t pushed_count;
    double direction[3];
    double alpha, stiffness, capacitance;
    const double *stiffness_of; /* N/m a node; NULL: `stiffness` everywhere */
    ss_zhang_rule rule;
} ss_zhang_reference_plan;

/* On a mesh of quads or of tetrahedra; what is not named here is 0. */
ss_zhang_reference_plan ss_zhang_reference_on(const ss_mesh *mesh, const uint8_t *fixed,
                                              const int32_t *pushed, int32_t pushed_count);
/* False when out of memory. */
bool ss_zhang_reference_init(ss_zhang_reference *reference, const ss_zhang_reference_plan *plan);
void ss_zhang_reference_fini(ss_zhang_reference *reference);
/* The patch goes to `depth`, the force is taken, then the other cells answer for h seconds by
 * Euler. */
void ss_zhang_reference_step(ss_zhang_reference *reference, double depth, double h);
/* To `depth` at a speed, and held, in steps of h. */
void ss_zhang_reference_go(ss_zhang_reference *reference, double depth, double speed, double h);
void ss_zhang_reference_hold(ss_zhang_reference *reference, double time, double h);
/* To `depth` in one step of h, in `parts` equal parts of way and time, as a model divides one. */
void ss_zhang_reference_at_once(ss_zhang_reference *reference, double depth, double h,
                                int32_t parts);
/* The equilibrium with the patch where it is, by another algorithm than time: Nesterov's
 * accelerated gradient of W with restarts, until no cell would move by more than `least` of a mean
 * link in a C. False when it does not settle. */
bool ss_zhang_reference_settle(ss_zhang_reference *reference, double least);

/* Traditional ChainMail along a straight row of links of length 1, its first node pushed to `depth`
 * across the row in `steps` equal steps, its last one fixed: each node in turn is brought into the
 * band [1 - alpha, 1 + alpha] along the link to the one before it. out_at: `count` pairs (along,
 * across). */
void ss_zhang_reference_row(int32_t count, double alpha, double depth, int32_t steps,
                            double (*out_at)[2]);
