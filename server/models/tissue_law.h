/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Laws of tissue: stress, energy, dissipation and tangent at one point of an isotropic body.
 *
 * In: the displacement gradient H = F - I (not F: at rest nothing cancels) and its rate Hdot =
 * Fdot. Out: the first Piola-Kirchhoff stress P (Pa), so that a tetrahedron of rest volume V puts
 * f_a = -V P grad N_a on its node a. Matrices are nine in a row, H[3 i + j] = du_i / dX_j.
 * The equations stand in tissue_law.c. References judge by them too, so this is no model's own.
 * This is the exact reference in double, elastic and viscous;
 * the kernels of `fem` compute the same in ss_real for eight elements at once, and are tested
 * against every function here. Statics of the benchmark, which know no rates, are solved by the
 * elastic ones.
 * Thread: any, RT-safe.
 */

typedef enum ss_tissue_kind {
    SS_TISSUE_STVK_GUARDED,
    SS_TISSUE_STVK,
    SS_TISSUE_NEO_HOOKEAN,
    SS_TISSUE_STABLE_NEO_HOOKEAN,
    SS_TISSUE_LINEAR,
    SS_TISSUE_KIND_COUNT
} ss_tissue_kind;

/* The names that a scene gives them, in this order. */
#define SS_TISSUE_CHOICES "stvk-guarded|stvk|neo-hookean|stable-neo-hookean|linear"
/* One of them. */
const char *ss_tissue_name(ss_tissue_kind kind);

/* stvk-guarded pushes back below this ratio of volumes. */
#define SS_TISSUE_GUARD 0.65
/* neo-hookean goes on as a parabola in J below this: J^(-2/3) has no value at 0. */
#define SS_TISSUE_FLOOR 0.2

typedef struct ss_tissue_law {
    ss_tissue_kind kind;
    double lambda, mu; /* Pa, Lame's constants of small strain, for every kind */
    double phi, psi;   /* Pa s, viscosity of dilatation and of shear */
} ss_tissue_law;

/* E > 0 in Pa, -1 < nu < 0.5. */
void ss_tissue_lame(double youngs_modulus, double poisson_ratio, double *out_lambda,
                    double *out_mu);

/* Stored energy, J/m^3 of rest volume; 0 at rest. */
double ss_tissue_energy(const ss_tissue_law *law, const double h[9]);
/* Elastic stress dW/dF. */
void ss_tissue_stress(const ss_tissue_law *law, const double h[9], double out_p[9]);
/* Viscous stress; 0 with phi = psi = 0. */
void ss_tissue_viscous_stress(const ss_tissue_law *law, const double h[9], const double rate[9],
                              double out_p[9]);
/* Power that the viscous stress takes, W/m^3, never below 0 for phi, psi >= 0. */
double ss_tissue_dissipation(const ss_tissue_law *law, const double h[9], const double rate[9]);
/* out_dp = (d2W/dF dF) : dh, symmetric: a : C b = b : C a. */
void ss_tissue_tangent(const ss_tissue_law *law, const double h[9], const double dh[9],
                       double out_dp[9]);
/* J - 1 = det(I + H) - 1 without cancellation; below -1 the point is inverted. */
double ss_tissue_volume_change(const double h[9]);
