/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * Masses on the nodes, and the step that they allow.
 *
 * Lumping of Hinton, Rock and Zienkiewicz (1976): the diagonal of the consistent mass matrix,
 * scaled so that the element keeps its mass: 1/36 of it on a corner, 4/27 on an edge. Row sums
 * would be negative on corners.
 *
 * However the mass of each node is dealt out to its elements, omega^2 of the body is at most the
 * largest omega_e^2 of an element with its part (Fried 1972). Dealt out as it came from them, a
 * small element among large ones has little, and the bound is 1.5 to 1.7 times omega^2 on the
 * meshes of the reference problems. So each node gives in proportion to omega_e^2 too, and it is
 * 1.27 to 1.33 times. Rejected: to do so again and again, which lowers the bound further, but then
 * mass is added to so many that omega^2 itself falls less (by 7 % on the slab of 300 nodes).
 *
 * Few elements then decide the bound: mass is added to those with omega_e^2 above T, as much as
 * brings them to T, and T is the least that costs no more than the share of the whole mass that is
 * allowed (mass scaling: Olovsson, Simonsson and Unosson 2005 is one of its forms). Inertia grows
 * by that share; the added mass has no weight, so that statics do not change.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/random.h"

/* Until an element's fastest motion is found from a random start, and from one nearby. */
enum { START_STEPS = 30, MORE_STEPS = 8, BISECTIONS = 60 };
enum { MODE = 3 * SS_QUADRATIC_NODES * SS_FEM_LANES };
#define CORNER_SHARE (1.0 / 36.0)
#define SIDE_SHARE   (4.0 / 27.0)

typedef struct dealing {
    const ss_quadratic_raised *raised;
    ss_quadratic_blocks *blocks;
    ss_quadratic_pass pass;
    double unit;                        /* 1/s^2, of `rate` */
    double (*part)[SS_QUADRATIC_NODES]; /* kg, of each element */
    double *node, *wish;                /* kg, of each node; what it was asked for */
    double *rate2, *whole;              /* 1/s^2, kg: of each element */
} dealing;

/* ---- rates of elements ---- */

static void set_light(dealing *d)
{
    for (ptrdiff_t k = 0; k < (ptrdiff_t)d->blocks->count * SS_FEM_LANES; ++k) {
        const int32_t e = d->blocks->element[k];
        ss_real *light = d->blocks->light + k / SS_FEM_LANES * SS_QUADRATIC_NODES * SS_FEM_LANES +
                         k % SS_FEM_LANES;
        for (int n = 0; e >= 0 && n < SS_QUADRATIC_NODES; ++n) {
            light[SS_FEM_LANES * n] = (ss_real)(1.0 / (d->part[e][n] * d->unit));
        }
    }
}

/* Power steps at rest; the largest omega_e^2. */
static double find_rates(dealing *d, int steps)
{
    double largest = 0.0;
    set_light(d);
    for (int k = 0; k < steps; ++k) {
        ss_quadratic_kernels_get()->rate(&d->pass);
    }
    for (ptrdiff_t k = 0; k < (ptrdiff_t)d->blocks->count * SS_FEM_LANES; ++k) {
        if (d->blocks->element[k] >= 0) {
            const double rate2 = d->unit * (double)d->pass.rate[k];
            d->rate2[d->blocks->element[k]] = rate2;
            largest = fmax(largest, rate2);
        }
    }
    return largest;
}

/* Every node's mass once more, in proportion to what an element had of it and its omega_e^2. */
static void deal_out(dealing *d)
{
    const int32_t count = d->raised->mesh.tetrahedron_count;
    memset(d->wish, 0, (size_t)d->raised->mesh.node_count * sizeof *d->wish);
    for (int32_t e = 0; e < count; ++e) {
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            d->part[e][n] *= d->rate2[e] / d->unit;
            d->wish[d->raised->node[e][n]] += d->part[e][n];
        }
    }
    for (int32_t e = 0; e < count; ++e) {
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            const int32_t i = d->raised->node[e][n];
            d->part[e][n] *= d->node[i] / d->wish[i];
        }
    }
}

/* ---- mass scaling ---- */

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

/* Brings all to the threshold that costs `most` of the mass. */
static void add_mass(dealing *d, double most, ss_quadratic_masses *out)
{
    const int32_t count = d->raised->mesh.tetrahedron_count;
    double total = 0.0;
    for (int32_t e = 0; e < count; ++e) {
        d->whole[e] = 0.0;
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            d->whole[e] += d->part[e][n];
        }
        total += d->whole[e];
    }
    const double threshold = choose_threshold(count, d->rate2, d->whole, most);
    out->added_share = added_mass(count, d->rate2, d->whole, threshold) / total;
    for (int32_t e = 0; e < count; ++e) {
        const double factor = fmax(1.0, d->rate2[e] / threshold);
        out->scaled_count += factor > 1.0;
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            const int32_t i = d->raised->node[e][n];
            out->added[i] += (factor - 1.0) * d->part[e][n];
            out->mass[i] += (factor - 1.0) * d->part[e][n];
            d->part[e][n] *= factor;
        }
    }
}

/* ---- all of it ---- */

static bool dealing_init(dealing *d, const ss_quadratic_raised *raised,
                         const ss_fem_material *material, ss_quadratic_blocks *blocks,
                         ss_arena *scratch, double *mass)
{
    const size_t elements = (size_t)raised->mesh.tetrahedron_count;
    const size_t nodes = (size_t)raised->mesh.node_count, values = (size_t)blocks->count;
    int32_t *block = ss_arena_get(scratch, values, sizeof *block);
    *d = (dealing){.raised = raised,
                   .blocks = blocks,
                   .pass = {.blocks = blocks,
                            .kind = material->kind,
                            .u = ss_arena_get(scratch, 4 * nodes, sizeof(ss_real)),
                            .block = block,
                            .block_count = blocks->count,
                            .mode = ss_arena_get(scratch, values * MODE, sizeof(ss_real)),
                            .rate = ss_arena_get(scratch, values * SS_FEM_LANES, sizeof(ss_real))},
                   .part = ss_arena_get(scratch, elements, sizeof *d->part),
                   .node = mass,
                   .wish = ss_arena_get(scratch, nodes, sizeof *d->wish),
                   .rate2 = ss_arena_get(scratch, elements, sizeof *d->rate2),
                   .whole = ss_arena_get(scratch, elements, sizeof *d->whole)};
    if (ss_arena_status(scratch) != SOFTSIM_OK) {
        return false;
    }
    uint64_t seed = 1;
    for (size_t k = 0; k < values * MODE; ++k) {
        d->pass.mode[k] = (ss_real)ss_random_start(&seed);
    }
    for (int32_t b = 0; b < blocks->count; ++b) {
        block[b] = b;
    }
    for (int32_t e = 0; e < raised->mesh.tetrahedron_count; ++e) {
        ss_quadratic_point point[SS_QUADRATIC_POINTS];
        double volume = 0.0;
        (void)ss_quadratic_points(&raised->mesh, raised->node[e], point);
        for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
            volume += point[q].volume;
        }
        for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
            d->part[e][n] = volume * material->density[e] * (n < 4 ? CORNER_SHARE : SIDE_SHARE);
            mass[raised->node[e][n]] += d->part[e][n];
        }
        /* Of the right size: what is in the units of the kernels then fits their numbers. */
        d->unit = fmax(d->unit, (material->lambda[e] + 2.0 * material->mu[e]) * cbrt(volume) /
                                    d->part[e][0]);
    }
    return true;
}

softsim_status ss_quadratic_masses_create(const ss_quadratic_raised *raised,
                                          const ss_fem_material *material, double most,
                                          ss_quadratic_blocks *blocks, ss_arena *arena,
                                          ss_quadratic_masses *out)
{
    dealing d;
    ss_arena scratch = {0};
    *out = (ss_quadratic_masses){
        .mass = ss_arena_get(arena, (size_t)raised->mesh.node_count, sizeof *out->mass),
        .added = ss_arena_get(arena, (size_t)raised->mesh.node_count, sizeof *out->added)};
    const bool is_good =
        out->mass && out->added && dealing_init(&d, raised, material, blocks, &scratch, out->mass);
    if (is_good) {
        (void)find_rates(&d, START_STEPS);
        deal_out(&d);
        out->plain_bound = find_rates(&d, MORE_STEPS);
        add_mass(&d, most, out);
        out->bound = find_rates(&d, MORE_STEPS);
        d.unit = out->bound;
        set_light(&d);
    }
    ss_arena_free(&scratch);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}
