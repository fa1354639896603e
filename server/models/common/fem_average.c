/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
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
 * keeps lambda_own = min(lambda, mu/2) to itself (Puso, Solberg 2006 stabilise in the same way).
 * With lambda_a the harmonic mean of its elements' the sum is never stiffer than the elements
 * themselves (Cauchy and Schwarz), so the elements' own bound holds for it. A nearer one: V_a q_a =
 * sum_b c_ab . u_b, c_ab = sum_e V_e grad N_b, and the stiffness of W is K_bb' = sum_a lambda_a/(4
 * V_a) c_ab c_ab'^T,
 *
 *   u.K u <= sum_b |u_b|^2 R_b,   R_b = sum_a lambda_a/(4 V_a) |c_ab| sum_b' |c_ab'|
 *
 * (Gershgorin), which knows that inside a body c_aa is 0.
 * Costs a second sweep. Rejected: F-bar over patches (not symmetric or not one potential), the
 * pressure of the step before (a delayed force feeds stiff modes).
 */
#include <string.h>

#include "mesh/tetrahedron.h"

bool ss_fem_average_create(ss_fem *fem, const ss_fem_setup *setup, int32_t padded)
{
    const ss_fem_material *material = setup->material;
    ss_fem_average *average = &fem->average;
    const size_t n = (size_t)padded;
    ss_arena scratch = {0};
    double *volume = ss_arena_get(&scratch, n, sizeof *volume);
    double *softness = ss_arena_get(&scratch, n, sizeof *softness);
    SS_ARENA_TAKE(&fem->arena, SS_ROOM(n, average->modulus), SS_ROOM(n * 4, average->pressure),
                  SS_ROOM(n * 4, average->change));
    const bool is_good =
        ss_arena_status(&scratch) == SOFTSIM_OK && ss_arena_status(&fem->arena) == SOFTSIM_OK;
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
    ss_arena_free(&scratch);
    return is_good;
}

/* ---- bound ---- */

/* The elements around each node: element[first[a]] to element[first[a + 1] - 1]. */
typedef struct fans {
    int32_t *first, *element;
} fans;

static bool make_fans(const ss_mesh *mesh, ss_arena *arena, fans *out)
{
    const size_t nodes = (size_t)mesh->node_count, tets = (size_t)mesh->tetrahedron_count;
    *out = (fans){.first = ss_arena_get(arena, nodes + 2, sizeof *out->first),
                  .element = ss_arena_get(arena, 4 * tets, sizeof *out->element)};
    if (!out->first || !out->element) {
        return false;
    }
    int32_t *next = out->first + 1; /* one ahead: filling moves each to its end */
    for (size_t e = 0; e < tets; ++e) {
        for (int a = 0; a < 4; ++a) {
            ++next[mesh->tetrahedron[e][a] + 1];
        }
    }
    for (size_t i = 0; i < nodes; ++i) {
        next[i + 1] += next[i];
    }
    for (size_t e = 0; e < tets; ++e) {
        for (int a = 0; a < 4; ++a) {
            out->element[next[mesh->tetrahedron[e][a]]++] = (int32_t)e;
        }
    }
    return true;
}

/* c_ab of node a into `c`, which is clear; the nodes b into `touched`. Returns their number. */
static int32_t patch(const ss_fem_setup *setup, const fans *fan, int32_t a, double (*c)[3],
                     int32_t *touched)
{
    const double(*x)[3] = (const double(*)[3])setup->mesh->position;
    int32_t count = 0;
    for (int32_t k = fan->first[a]; k < fan->first[a + 1]; ++k) {
        const int32_t e = fan->element[k], *corner = setup->mesh->tetrahedron[e];
        double gradient[4][3];
        double volume = ss_tetrahedron_gradients(x[corner[0]], x[corner[1]], x[corner[2]],
                                                 x[corner[3]], gradient);
        volume *= setup->volume_share ? setup->volume_share[e] : 1.0;
        if (!(setup->material->lambda[e] > setup->material->lambda_own[e])) {
            continue;
        }
        for (int b = 0; b < 4; ++b) {
            double *sum = c[corner[b]];
            bool is_new = true;
            for (int32_t m = 0; m < count && is_new; ++m) {
                is_new = touched[m] != corner[b];
            }
            if (is_new) {
                touched[count++] = corner[b];
            }
            ss_madd3(sum, sum, volume, gradient[b]);
        }
    }
    return count;
}

bool ss_fem_average_bound(const ss_fem_average *average, const ss_fem_setup *setup,
                          double *out_stiffness)
{
    const size_t n = (size_t)setup->mesh->node_count;
    fans fan;
    ss_arena scratch = {0};
    double(*c)[3] = ss_arena_get(&scratch, n, sizeof *c);
    int32_t *touched = ss_arena_get(&scratch, n, sizeof *touched);
    const bool is_good = make_fans(setup->mesh, &scratch, &fan) && c && touched;
    for (int32_t a = 0; is_good && a < setup->mesh->node_count; ++a) {
        const int32_t count = patch(setup, &fan, a, c, touched);
        double sum = 0.0;
        for (int32_t k = 0; k < count; ++k) {
            sum += ss_norm3(c[touched[k]]);
        }
        for (int32_t k = 0; k < count; ++k) {
            double *reach = c[touched[k]];
            out_stiffness[touched[k]] += 0.25 * (double)average->modulus[a] * ss_norm3(reach) * sum;
            ss_set3(reach, 0.0, 0.0, 0.0);
        }
    }
    ss_arena_free(&scratch);
    return is_good;
}

/* ---- pressures ---- */

/* p_a = lambda_a / V_a times the sum of V_e q_e. */
static void scale(const ss_fem *fem, ss_real *field)
{
    for (int32_t i = 0; i < fem->blocks.node_count; ++i) {
        field[4 * (ptrdiff_t)i] *= fem->average.modulus[i];
    }
}

/* W = sum_a V_a/8 p_a^2 / lambda_a */
static double energy(const ss_fem *fem)
{
    double sum = 0.0;
    for (int32_t i = 0; i < fem->blocks.node_count; ++i) {
        const double p = (double)fem->average.pressure[4 * (ptrdiff_t)i];
        sum += p != 0.0 ? p * p / (double)fem->average.modulus[i] : 0.0;
    }
    return 0.125 * sum;
}

double ss_fem_average_update(ss_fem *fem, const ss_real *u, bool wants_energy)
{
    ss_fem_average *average = &fem->average;
    memset(average->pressure, 0, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    ss_fem_pass pass = {
        .blocks = &fem->blocks, .kind = fem->kind, .u = u, .out = average->pressure};
    fem->kernels->dilate(&pass);
    scale(fem, average->pressure);
    return wants_energy ? energy(fem) : 0.0;
}

void ss_fem_average_change(ss_fem *fem, const ss_real *x)
{
    ss_fem_average *average = &fem->average;
    memset(average->change, 0, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    ss_fem_pass pass = {
        .blocks = &fem->blocks, .kind = fem->kind, .u = fem->u, .x = x, .out = average->change};
    fem->kernels->dilate(&pass);
    scale(fem, average->change);
}
