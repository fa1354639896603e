/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * Forces, tangent and the stable step of the body.
 *
 * At rest omega^2, the largest eigenvalue of M^-1 K, by power iteration, the quotient's residual
 * added, and never above the largest omega_e^2 of an element (mass.c). The latter, which is a bound
 * in any state, is on the meshes of the reference problems 1.3 times the first.
 *
 * In motion omega_e^2 of each element, by a power iteration of its own thirty coordinates that
 * takes a step where the element's strain has changed and else in its turn; their largest, times
 * `slack`, stands for omega^2. At rest slack is the ratio of the two, so that nothing is lost
 * there; and SS_QUADRATIC_STEP_SHARE of the step never exceeds the one that the largest omega_e^2
 * itself allows, with whatever viscosity.
 * Rejected: to go on with the body's power iteration. A few elements that a tool squeezes have next
 * to nothing of the mode at rest, and it was 200 steps before it saw them: the ellipsoid of 24,748
 * elements pressed by 12 mm diverged there, held by the limit of speeds alone.
 */
#include <math.h>
#include <string.h>

#include "models/common/dispatch.h"
#include "models/common/fastest_mode.h"
#include "rt/hash.h"
#include "rt/random.h"

SS_KERNEL_PATHS_512(ss_quadratic_kernels)

/* Outer steps in which every element has its turn; power steps of the body and of an element at
 * rest. */
enum { TURNS = 16, MAX_POWER_STEPS = 400, ELEMENT_STEPS = 30 };
enum { MODE = 3 * SS_QUADRATIC_NODES * SS_FEM_LANES }; /* values of a block */
#define RESIDUAL 0.003
/* What is added for the part that the residual does not know, of omega^2. */
#define MARGIN 0.01
/* A change of an element's |2E|^2 that is worth a step: of it, and at least. */
#define STRAIN_CHANGE ((ss_real)0.1)
#define LEAST_CHANGE  ((ss_real)0.01)
/* From here on elements may be inverted: a side of length 0 has |2E| = 1. */
#define INVERSION_STRAIN 0.9

/* ---- forces ---- */

void ss_quadratic_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                        ss_body_energy *out)
{
    ss_quadratic *own = owner;
    ss_quadratic_pass pass = {.blocks = &own->blocks,
                              .kind = own->kind,
                              .u = u,
                              .v = v,
                              .out = force,
                              .wants_energy = out->is_wanted,
                              .strains = own->stability.strains};
    own->kernels->force(&pass);
    own->u = u;
    own->stability.strain = fmax(own->stability.strain, sqrt(pass.strain));
    out->elastic = pass.energy;
    out->power = pass.power;
}

void ss_quadratic_tangent(void *owner, const ss_real *x, ss_real *out)
{
    ss_quadratic *own = owner;
    ss_quadratic_pass pass = {
        .blocks = &own->blocks, .kind = own->kind, .u = own->u, .x = x, .out = out};
    own->kernels->tangent(&pass);
}

void ss_quadratic_diagonal(void *owner, double *diagonal)
{
    const ss_quadratic *own = owner;
    ss_fem_add_diagonal(own->blocks.node_count, own->diagonal, diagonal);
}

/* ---- power iteration ---- */

/* x := M^-1 K x at own->u, normed to x.Mx = 1; returns omega^2 from above, and the residual over
 * it. Units in which nothing over- or underflows: y = (M^-1 K / bound) x. */
static double power_step(ss_quadratic *own, ss_real *x, ss_real *y, double *out_residual)
{
    const ss_quadratic_stability *s = &own->stability;
    const ptrdiff_t count = 4 * (ptrdiff_t)own->blocks.node_count;
    double quotient = 0.0, square = 0.0;
    memset(y, 0, (size_t)count * sizeof *y);
    ss_quadratic_tangent(own, x, y);
    for (ptrdiff_t k = 0; k < count; ++k) {
        const double force = (double)y[k], way = force * (double)s->mobility[k] / s->bound;
        quotient += (double)x[k] * force;
        square += way * force;
        y[k] = (ss_real)way;
    }
    square *= s->bound;
    *out_residual = quotient > 0.0 ? sqrt(fmax(square - quotient * quotient, 0.0)) / quotient : 1.0;
    const double norm = square > 0.0 ? s->bound / sqrt(square) : 0.0;
    for (ptrdiff_t k = 0; k < count; ++k) {
        x[k] = (ss_real)((double)y[k] * norm);
    }
    return quotient * (1.0 + fmax(*out_residual, MARGIN));
}

/* Of the body at rest, from the fastest mode found from a random start. */
static bool iterate_at_rest(ss_quadratic *own, ss_real *x, ss_real *y)
{
    ss_quadratic_stability *s = &own->stability;
    const ptrdiff_t count = 4 * (ptrdiff_t)own->blocks.node_count;
    uint64_t seed = 1;
    double square = 0.0, residual = 1.0, rate2 = s->bound;
    for (ptrdiff_t k = 0; k < count; ++k) {
        const double random = ss_random_start(&seed), mobility = (double)s->mobility[k];
        x[k] = mobility > 0.0 ? (ss_real)random : 0;
        square += mobility > 0.0 ? random * random / mobility : 0.0;
    }
    s->rest_rate2 = s->bound;
    if (!(square > 0.0) || !(s->bound > 0.0)) {
        return true; /* nothing moves */
    }
    for (ptrdiff_t k = 0; k < count; ++k) {
        x[k] = (ss_real)((double)x[k] / sqrt(square));
    }
    if (ss_find_fastest_mode(own->blocks.node_count, s->mobility, ss_quadratic_tangent, own,
                             RESIDUAL, MAX_POWER_STEPS, x) != SOFTSIM_OK) {
        return false;
    }
    for (int k = 0; k < MAX_POWER_STEPS && residual > RESIDUAL; ++k) {
        rate2 = power_step(own, x, y, &residual);
    }
    s->rest_rate2 = fmin(rate2, s->bound);
    return true;
}

static void visit(ss_quadratic *own, int32_t count)
{
    ss_quadratic_stability *s = &own->stability;
    const ss_quadratic_pass pass = {.blocks = &own->blocks,
                                    .kind = own->kind,
                                    .u = own->u,
                                    .block = s->block,
                                    .block_count = count,
                                    .mode = s->mode,
                                    .rate = s->rate};
    own->kernels->rate(&pass);
}

/* Every element's fastest motion. */
static void iterate_elements_at_rest(ss_quadratic *own)
{
    ss_quadratic_stability *s = &own->stability;
    const ptrdiff_t count = (ptrdiff_t)own->blocks.count * MODE;
    uint64_t seed = 1;
    for (ptrdiff_t k = 0; k < count; ++k) {
        s->mode[k] = (ss_real)ss_random_start(&seed);
    }
    for (int32_t b = 0; b < own->blocks.count; ++b) {
        s->block[b] = b;
    }
    for (int k = 0; k < ELEMENT_STEPS; ++k) {
        visit(own, own->blocks.count);
    }
    memcpy(s->rest_mode, s->mode, (size_t)count * sizeof *s->mode);
}

/* ---- life ---- */

static void set_diagonal(ss_quadratic *own, const ss_quadratic_raised *raised,
                         const ss_fem_material *material)
{
    for (int32_t e = 0; e < raised->mesh.tetrahedron_count; ++e) {
        ss_quadratic_point point[SS_QUADRATIC_POINTS];
        (void)ss_quadratic_points(&raised->mesh, raised->node[e], point);
        for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
            double g[SS_QUADRATIC_NODES][3];
            ss_quadratic_shape(&point[q], q, g);
            for (int n = 0; n < SS_QUADRATIC_NODES; ++n) {
                own->diagonal[raised->node[e][n]] +=
                    point[q].volume * (material->lambda[e] + 4.0 * material->mu[e]) / 3.0 *
                    (g[n][0] * g[n][0] + g[n][1] * g[n][1] + g[n][2] * g[n][2]);
            }
        }
    }
}

softsim_status ss_quadratic_create(const ss_quadratic_raised *raised,
                                   const ss_fem_material *material, double most, ss_arena *arena,
                                   ss_quadratic *out)
{
    const int32_t nodes = raised->mesh.node_count;
    const size_t n = ((size_t)nodes + 7) / 8 * 8 * 4;
    *out = (ss_quadratic){.kernels = ss_quadratic_kernels_get(),
                          .kind = material->kind,
                          .integrator = material->integrator,
                          .viscous_time = material->viscous_time,
                          .mass_damping = material->mass_damping,
                          .diagonal = ss_arena_get(arena, (size_t)nodes, sizeof(double))};
    ss_quadratic_stability *s = &out->stability;
    const ss_quadratic_masses *masses = &out->masses;
    const bool is_good = ss_quadratic_blocks_create(raised, material, arena, &out->blocks) &&
                         ss_quadratic_masses_create(raised, material, most, &out->blocks, arena,
                                                    &out->masses) == SOFTSIM_OK;
    const size_t values = (size_t)out->blocks.count * SS_FEM_LANES;
    const size_t modes = (size_t)out->blocks.count * MODE;
    *s = (ss_quadratic_stability){
        .bound = masses->bound,
        .mobility = ss_arena_get(arena, n, sizeof(ss_real)),
        .mode = ss_arena_get(arena, modes, sizeof(ss_real)),
        .rest_mode = ss_arena_get(arena, modes, sizeof(ss_real)),
        .rate = ss_arena_get(arena, values, sizeof(ss_real)),
        .strains = ss_arena_get(arena, values, sizeof(ss_real)),
        .seen = ss_arena_get(arena, values, sizeof(ss_real)),
        .ratio = ss_arena_get(arena, values, sizeof(ss_real)),
        .block = ss_arena_get(arena, (size_t)out->blocks.count, sizeof *s->block),
        .worst = -1};
    ss_arena scratch = {0};
    ss_real *rest = ss_arena_get(arena, n, sizeof *rest);
    ss_real *x = ss_arena_get(&scratch, n, sizeof *x), *y = ss_arena_get(&scratch, n, sizeof *y);
    if (!is_good || !x || !y || ss_arena_status(arena) != SOFTSIM_OK) {
        ss_arena_free(&scratch);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < nodes; ++i) {
        for (int k = 0; k < 3; ++k) {
            const bool is_free = masses->mass[i] > 0.0 && (raised->plan.fixed[i] & (1 << k)) == 0;
            s->mobility[4 * (ptrdiff_t)i + k] = is_free ? (ss_real)(1.0 / masses->mass[i]) : 0;
        }
    }
    set_diagonal(out, raised, material);
    out->u = rest;
    if (!iterate_at_rest(out, x, y)) {
        ss_arena_free(&scratch);
        return SOFTSIM_ERROR_MEMORY;
    }
    iterate_elements_at_rest(out);
    ss_arena_free(&scratch);
    s->slack = s->bound > 0.0 ? s->rest_rate2 / s->bound : 1.0;
    s->rate2 = s->rest_rate2;
    return SOFTSIM_OK;
}

static double step_limit(const ss_quadratic *own, double rate2)
{
    return ss_body_step_limit(own->integrator, rate2, own->viscous_time, own->mass_damping);
}

double ss_quadratic_rest_step(const ss_quadratic *own)
{
    return step_limit(own, own->stability.rest_rate2);
}

/* ---- while running ---- */

/* Which elements are squeezed or inverted: of those that are strained enough to be. */
static void look_at_volumes(ss_quadratic *own)
{
    ss_quadratic_stability *s = &own->stability;
    const ss_real floor_ratio =
        (ss_real)(own->kind == SS_TISSUE_NEO_HOOKEAN ? SS_FEM_HELD_FLOOR : SS_TISSUE_GUARD);
    ss_real least = floor_ratio;
    int32_t count = 0;
    for (int32_t b = 0; b < own->blocks.count; ++b) {
        bool is_strained = false;
        for (int lane = 0; lane < SS_FEM_LANES; ++lane) {
            is_strained |= !(s->strains[(ptrdiff_t)b * SS_FEM_LANES + lane] <
                             (ss_real)(INVERSION_STRAIN * INVERSION_STRAIN));
        }
        s->block[count] = b;
        count += is_strained;
    }
    const ss_quadratic_pass pass = {.blocks = &own->blocks,
                                    .kind = own->kind,
                                    .u = own->u,
                                    .block = s->block,
                                    .block_count = count};
    own->kernels->ratio(&pass, s->ratio);
    s->squeezed = s->inverted = 0;
    for (int32_t i = 0; i < count; ++i) {
        for (ptrdiff_t k = (ptrdiff_t)s->block[i] * SS_FEM_LANES, end = k + SS_FEM_LANES; k < end;
             ++k) {
            s->squeezed += s->ratio[k] < floor_ratio;
            s->inverted += s->ratio[k] <= 0;
            if (s->ratio[k] < least) {
                least = s->ratio[k];
                s->worst = own->blocks.element[k];
            }
        }
    }
}

/* Blocks with an element whose strain has changed since the last look, and those whose turn it is.
 */
static int32_t list_due(ss_quadratic_stability *s, int32_t blocks)
{
    int32_t count = 0;
    s->turn = (s->turn + 1) % TURNS;
    for (int32_t b = 0; b < blocks; ++b) {
        const ss_real *now = s->strains + (ptrdiff_t)b * SS_FEM_LANES;
        ss_real *seen = s->seen + (ptrdiff_t)b * SS_FEM_LANES;
        int is_due = b % TURNS == s->turn;
        for (int lane = 0; lane < SS_FEM_LANES; ++lane) {
            const ss_real apart =
                now[lane] > seen[lane] ? now[lane] - seen[lane] : seen[lane] - now[lane];
            is_due |= apart > STRAIN_CHANGE * seen[lane] + LEAST_CHANGE;
        }
        if (is_due) {
            memcpy(seen, now, SS_FEM_LANES * sizeof *seen);
            s->block[count++] = b;
        }
    }
    return count;
}

double ss_quadratic_stable_step(void *owner, const ss_body *body)
{
    ss_quadratic *own = owner;
    ss_quadratic_stability *s = &own->stability;
    const double strain = s->strain;
    (void)body;
    s->strain = 0.0;
    s->worst = -1;
    s->squeezed = 0;
    if (strain > INVERSION_STRAIN || s->inverted > 0) {
        look_at_volumes(own);
    }
    if (own->kind == SS_TISSUE_LINEAR || !(s->bound > 0.0)) {
        return ss_quadratic_rest_step(own);
    }
    const int32_t count = list_due(s, own->blocks.count);
    if (count > 0) {
        ss_real largest = 0;
        visit(own, count);
        for (ptrdiff_t k = 0; k < (ptrdiff_t)own->blocks.count * SS_FEM_LANES; ++k) {
            largest = s->rate[k] > largest ? s->rate[k] : largest;
        }
        s->certain_rate2 = s->bound * (double)largest;
        s->rate2 = fmax(s->rest_rate2, s->slack * s->certain_rate2);
    }
    return fmin(step_limit(own, s->rate2),
                step_limit(own, s->certain_rate2) / SS_QUADRATIC_STEP_SHARE);
}

void ss_quadratic_judge(const ss_quadratic *own, ss_body *body)
{
    const ss_quadratic_stability *s = &own->stability;
    ss_fem_judge_elements(body, own->kind, s->inverted, s->squeezed, s->worst,
                          "elements are squeezed below 0.3 of their volume: the law goes on as a "
                          "straight line");
}

void ss_quadratic_reset(void *owner)
{
    ss_quadratic *own = owner;
    ss_quadratic_stability *s = &own->stability;
    const size_t values = (size_t)own->blocks.count * SS_FEM_LANES;
    memcpy(s->mode, s->rest_mode, (size_t)own->blocks.count * MODE * sizeof *s->mode);
    memset(s->rate, 0, values * sizeof *s->rate);
    memset(s->seen, 0, values * sizeof *s->seen);
    memset(s->strains, 0, values * sizeof *s->strains);
    s->rate2 = s->rest_rate2;
    s->certain_rate2 = 0.0;
    s->strain = 0.0;
    s->turn = 0;
    s->squeezed = s->inverted = 0;
    s->worst = -1;
}

uint64_t ss_quadratic_hash(const void *owner, uint64_t seed)
{
    const ss_quadratic *own = owner;
    return ss_hash_bytes(seed, own->stability.mode,
                         (size_t)own->blocks.count * MODE * sizeof(ss_real));
}
