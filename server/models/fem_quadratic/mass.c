/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * Masses on the nodes, and the step that they allow.
 *
 * Lumping of Hinton, Rock and Zienkiewicz (1976): the diagonal of the consistent mass matrix,
 * scaled so that the element keeps its mass: 1/36 of it on a corner, 4/27 on a side. Row sums would
 * be negative on corners.
 *
 * With the element's own part of the mass, omega^2 of the body is at most the largest omega_e^2 of
 * an element (Fried 1972). Few elements decide it: mass is added to those with omega_e^2 above T,
 * as much as brings them to T, and T is the least that costs no more than the share of the whole
 * mass that is allowed (mass scaling: Olovsson, Simonsson and Unosson 2005 is one of its forms).
 * Inertia grows by that share; the added mass has no weight, so that statics do not change.
 */
#include <math.h>

#include "rt/memory.h"

enum { FREEDOMS = 3 * SS_QUADRATIC_NODES, POWER_STEPS = 40, BISECTIONS = 60 };
#define CORNER_SHARE (1.0 / 36.0)
#define SIDE_SHARE   (4.0 / 27.0)

static double share_of(int node)
{
    return node < 4 ? CORNER_SHARE : SIDE_SHARE;
}

/* M^-1/2 K M^-1/2 of an element at rest; returns its mass. */
static double scaled_stiffness(const ss_quadratic_raised *raised, const ss_fem_material *material,
                               int32_t e, double k[FREEDOMS][FREEDOMS])
{
    ss_quadratic_point point[SS_QUADRATIC_POINTS];
    double g[SS_QUADRATIC_POINTS + 1][SS_QUADRATIC_NODES][3] = {{{0.0}}}; /* the last: the mean */
    double volume = 0.0, root[SS_QUADRATIC_NODES];
    const double lambda = material->lambda_own[e], mu = material->mu[e];
    (void)ss_quadratic_points(&raised->mesh, raised->node[e], point);
    for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
        volume += point[q].volume;
    }
    const double mass = volume * material->density[e];
    for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
        root[n] = 1.0 / sqrt(mass * share_of(n));
    }
    for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
        ss_quadratic_shape(&point[q], q, g[q]);
        for (int n = 0; n < FREEDOMS; ++n) {
            g[q][n / 3][n % 3] *= root[n / 3];
            g[SS_QUADRATIC_POINTS][n / 3][n % 3] += point[q].volume / volume * g[q][n / 3][n % 3];
        }
    }
    for (int a = 0; a < FREEDOMS; ++a) {
        const int na = a / 3, i = a % 3;
        for (int b = 0; b <= a; ++b) {
            const int nb = b / 3, j = b % 3;
            double sum = volume * (material->lambda[e] - lambda) * g[SS_QUADRATIC_POINTS][na][i] *
                         g[SS_QUADRATIC_POINTS][nb][j];
            for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
                const double *ga = g[q][na], *gb = g[q][nb];
                double part = lambda * ga[i] * gb[j] + mu * ga[j] * gb[i];
                part += i == j ? mu * (ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2]) : 0.0;
                sum += point[q].volume * part;
            }
            k[a][b] = k[b][a] = sum;
        }
    }
    return mass;
}

/* The largest eigenvalue, from above: |A x| / |x| with its residual. */
static double largest_eigenvalue(const double k[FREEDOMS][FREEDOMS])
{
    double x[FREEDOMS], y[FREEDOMS], value = 0.0;
    uint64_t seed = 1;
    for (int a = 0; a < FREEDOMS; ++a) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        x[a] = (double)(seed >> 11) / 9007199254740992.0 * 2.0 - 1.0;
    }
    for (int turn = 0; turn < POWER_STEPS; ++turn) {
        double square = 0.0, xx = 0.0, xy = 0.0;
        for (int a = 0; a < FREEDOMS; ++a) {
            double sum = 0.0;
            for (int b = 0; b < FREEDOMS; ++b) {
                sum += k[a][b] * x[b];
            }
            y[a] = sum;
            square += sum * sum;
            xx += x[a] * x[a];
            xy += x[a] * sum;
        }
        const double quotient = xy / xx;
        value = quotient + sqrt(fmax(0.0, square / xx - quotient * quotient));
        for (int a = 0; a < FREEDOMS; ++a) {
            x[a] = square > 0.0 ? y[a] / sqrt(square) : 0.0;
        }
    }
    return value;
}

/* What bringing every element down to `threshold` adds, kg. */
static double added_mass(int32_t count, const double *rate2, const double *mass, double threshold)
{
    double sum = 0.0;
    for (int32_t e = 0; e < count; ++e) {
        sum += rate2[e] > threshold ? mass[e] * (rate2[e] / threshold - 1.0) : 0.0;
    }
    return sum;
}

static double choose_threshold(int32_t count, const double *rate2, const double *mass, double most)
{
    double total = 0.0, high = 0.0;
    for (int32_t e = 0; e < count; ++e) {
        total += mass[e];
        high = fmax(high, rate2[e]);
    }
    double low = 0.0;
    for (int k = 0; most > 0.0 && k < BISECTIONS; ++k) {
        const double middle = 0.5 * (low + high);
        if (added_mass(count, rate2, mass, middle) <= most * total) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

softsim_status ss_quadratic_masses_create(const ss_quadratic_raised *raised,
                                          const ss_fem_material *material, double most,
                                          ss_arena *arena, ss_quadratic_masses *out)
{
    const int32_t count = raised->mesh.tetrahedron_count;
    double *rate2 = ss_memory_get((size_t)count, sizeof *rate2);
    double *mass = ss_memory_get((size_t)count, sizeof *mass);
    *out = (ss_quadratic_masses){
        .mass = ss_arena_get(arena, (size_t)raised->mesh.node_count, sizeof *out->mass),
        .added = ss_arena_get(arena, (size_t)raised->mesh.node_count, sizeof *out->added),
        .element = ss_arena_get(arena, (size_t)count, sizeof *out->element)};
    if (!rate2 || !mass || !out->mass || !out->added || !out->element) {
        ss_memory_free(rate2);
        ss_memory_free(mass);
        return SOFTSIM_ERROR_MEMORY;
    }
    double total = 0.0;
    for (int32_t e = 0; e < count; ++e) {
        double k[FREEDOMS][FREEDOMS];
        mass[e] = scaled_stiffness(raised, material, e, k);
        rate2[e] = largest_eigenvalue((const double(*)[FREEDOMS])k);
        out->plain_bound = fmax(out->plain_bound, rate2[e]);
        total += mass[e];
    }
    out->bound = choose_threshold(count, rate2, mass, most);
    out->added_share = added_mass(count, rate2, mass, out->bound) / total;
    for (int32_t e = 0; e < count; ++e) {
        const double factor = fmax(1.0, rate2[e] / out->bound);
        out->scaled_count += factor > 1.0;
        out->element[e] = factor * mass[e];
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            out->mass[raised->node[e][n]] += factor * mass[e] * share_of(n);
            out->added[raised->node[e][n]] += (factor - 1.0) * mass[e] * share_of(n);
        }
    }
    ss_memory_free(rate2);
    ss_memory_free(mass);
    return SOFTSIM_OK;
}
