/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Equilibrium of a body of linear tetrahedra, in double: what models are compared with.
 *
 * In: mesh, law, held axes with their displacements, forces, gravity, follower pressure. Out:
 * displacements and reactions. A linear-tetrahedron model at rest must agree with it to its own
 * solver's tolerance; how far linear tetrahedra are from the truth is another matter (the floors of
 * tests/reference). Independent of the models: nothing is shared with their kernels but the laws.
 * Thread: one at a time, tools and tests only.
 */
#include <stdint.h>

#include "mesh/mesh.h"
#include "models/tissue_law.h"
#include "softsim/types.h"

typedef struct ss_static_problem {
    const ss_mesh *mesh;
    ss_tissue_law law;             /* its viscosity plays no part */
    const double *stiffness;       /* factor on the law, one a tetrahedron; NULL: 1 */
    const uint8_t *held;           /* node_count: bit 0 x, 1 y, 2 z */
    const double (*prescribed)[3]; /* m, of held axes; NULL: 0 */
    const double (*force)[3];      /* N, dead; NULL: none */
    double density;                /* kg/m^3, mass lumped by quarters */
    double gravity[3];             /* m/s^2 */
    int32_t pressed_count;         /* triangles under pressure, wound as the surface is */
    const int32_t (*pressed)[3];
    double pressure; /* Pa, into the body, on the deformed triangles */
} ss_static_problem;

typedef struct ss_static_report {
    double residual; /* |forces out of balance| / |internal forces| */
    double energy;   /* J, elastic */
    int32_t increments, iterations;
} ss_static_report;

/* Increases everything prescribed from nothing (or, where inout_u is not zero, from the equilibrium
 * of the same kind that it holds, in which the held axes may be elsewhere) to the problem's values.
 * inout_u: node_count; out_reaction (may be NULL): force of the support on the body on held axes,
 * else 0. SOFTSIM_ERROR_MESH: flat elements, or a body that is not held; SOFTSIM_ERROR_ARGUMENT:
 * bad law; SOFTSIM_ERROR_SYSTEM: no equilibrium was found. */
softsim_status ss_static_solve(const ss_static_problem *problem, double (*inout_u)[3],
                               double (*out_reaction)[3], ss_static_report *out_report,
                               softsim_error *error);

/* Small strain under prescribed displacements alone: E in Pa. */
softsim_status ss_static_linear(const ss_mesh *mesh, double youngs_modulus, double poisson_ratio,
                                const uint8_t *held, const double (*prescribed)[3],
                                double (*out_u)[3], double (*out_reaction)[3],
                                softsim_error *error);
