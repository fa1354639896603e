/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Equilibrium of cnn-energy on a triangle surface by direct solves, in double: what the field of
 * the stepped model is compared with.
 *
 * In: points, triangles, one material for all, cells held at zero, the weights of one source, and
 * what pushes: forces, or nodes whose place is given. Out: displacements. Shares no code with the
 * model. For bodies of any size that a sparse factor can take (a surface of 100 000 points: some
 * seconds); papers/zhong2006/net.h has the paper's readings on small ones. Thread: any, tools and
 * tests only.
 */
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_static_cnn_problem {
    int32_t node_count, triangle_count;
    const double (*rest)[3];      /* m */
    const int32_t (*triangle)[3]; /* closed where bulk > 0 */
    double modulus, pretension;   /* J: E^ and T0 */
    double bulk;                  /* Pa: B, of the enclosed volume */
    double rest_stiffness;        /* N/m^3: ks = rest_stiffness S_i */
    const uint8_t *is_held;       /* cells at zero, nodes at rest; one at least */
    const uint8_t *is_given;      /* nodes that stay where inout_u has them; NULL: none */
    const double *weight;         /* w^_i of the source's cells, none of them held; sum 1 */
    const double (*force)[3];     /* N, dead; NULL: none */
} ss_static_cnn_problem;

/* The equilibrium near inout_u, where the search begins; there is only one. SOFTSIM_ERROR_MESH: a
 * part of the surface is not held; SOFTSIM_ERROR_SYSTEM: a solve left more than rounding, or no
 * equilibrium was found. */
softsim_status ss_static_cnn_solve(const ss_static_cnn_problem *problem, double (*inout_u)[3],
                                   softsim_error *error);
