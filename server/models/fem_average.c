/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem.h"
/*
 * The cure for locking: dilatation is resisted by nodes, not by elements.
 *
 * A linear tetrahedron has one dilatation q (tr E, or J - 1 in the laws of J) and near Poisson's
 * ratio 0.5 every element asks for q = 0: more conditions than a mesh has freedoms, so a bent body
 * is far too stiff. After Bonet, Burton, "A simple average nodal pressure tetrahedral element for
 * incompressible and nearly incompressible dynamic explicit applications" (1998): with V_a the sum
 * of the volumes V_e around node a,
 *
 *   q_a = sum V_e q_e / V_a,   W = sum_a (V_a / 4) lambda_a q_a^2 / 2,   p_a = lambda_a q_a,
 *
 * and the derivative of W puts on every element the mean of its four nodes' pressures in place of
 * its own lambda q. It is one potential, so energy is kept and the tangent is symmetric. Averaging
 * all of lambda lets modes appear in which dilatation alternates between elements, so each element
 * keeps lambda_own = min(lambda, mu) to itself (Puso, Solberg 2006 stabilise alike). With lambda_a
 * the harmonic mean of its elements' the sum is never stiffer than the elements themselves (Cauchy
 * and Schwarz), which keeps the bound of fem_step.c.
 * Costs a second sweep. Rejected: F-bar over patches (not symmetric or not one potential), the
 * pressure of the step before (a delayed force feeds stiff modes).
 */
#include <string.h>

#include "models/tetrahedron.h"
#include "rt/memory.h"

bool ss_fem_average_create(ss_fem_average *average, const ss_fem_setup *setup, int32_t padded)
{
    const ss_fem_material *material = setup->material;
    const size_t n = (size_t)padded;
    double *volume = ss_memory_get(n, sizeof *volume),
           *softness = ss_memory_get(n, sizeof *softness);
    *average = (ss_fem_average){.modulus = ss_memory_get(n, sizeof *average->modulus),
                                .pressure = ss_memory_get(n * 4, sizeof *average->pressure),
                                .change = ss_memory_get(n * 4, sizeof *average->change)};
    const bool is_good =
        volume && softness && average->modulus && average->pressure && average->change;
    for (int32_t e = 0; is_good && e < setup->mesh->tetrahedron_count; ++e) {
        const int32_t *c = setup->mesh->tetrahedron[e];
        const double(*x)[3] = (const double(*)[3])setup->mesh->position;
        const double shared = material->lambda[e] - material->lambda_own[e];
        double gradient[4][3];
        double share = ss_tetrahedron_gradients(x[c[0]], x[c[1]], x[c[2]], x[c[3]], gradient);
        share *= setup->volume_share ? setup->volume_share[e] : 1.0;
        for (int a = 0; a < 4 && shared > 0.0; ++a) {
            volume[c[a]] += share;
            softness[c[a]] += share / shared;
        }
    }
    for (int32_t i = 0; is_good && i < padded; ++i) {
        average->modulus[i] = volume[i] > 0.0 ? (ss_real)(1.0 / softness[i]) : 0;
    }
    ss_memory_free(volume);
    ss_memory_free(softness);
    return is_good;
}

void ss_fem_average_fini(ss_fem_average *average)
{
    ss_memory_free(average->modulus);
    ss_memory_free(average->pressure);
    ss_memory_free(average->change);
    *average = (ss_fem_average){0};
}

/* p_a = lambda_a / V_a times the sum of V_e q_e; returns sum_a p_a times that sum. */
static double scale(const ss_fem *fem, ss_real *field)
{
    double sum = 0.0;
    for (int32_t i = 0; i < fem->blocks.node_count; ++i) {
        ss_real *p = field + 4 * (ptrdiff_t)i;
        const double dilated = (double)*p;
        *p *= fem->average.modulus[i];
        sum += (double)*p * dilated;
    }
    return sum;
}

double ss_fem_average_update(ss_fem *fem, const ss_real *u)
{
    ss_fem_average *average = &fem->average;
    memset(average->pressure, 0, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    ss_fem_pass pass = {
        .blocks = &fem->blocks, .kind = fem->kind, .u = u, .out = average->pressure};
    fem->kernels->dilate(&pass);
    return 0.125 * scale(fem, average->pressure);
}

void ss_fem_average_change(ss_fem *fem, const ss_real *x)
{
    ss_fem_average *average = &fem->average;
    memset(average->change, 0, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    ss_fem_pass pass = {
        .blocks = &fem->blocks, .kind = fem->kind, .u = fem->u, .x = x, .out = average->change};
    fem->kernels->dilate(&pass);
    (void)scale(fem, average->change);
}
