/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * Forces, tangent and the stable step of the body.
 *
 * The step is that of common/fem_stability.c: omega^2, the largest eigenvalue of M^-1 K, by power
 * iteration with the exact tangent at the present state, the quotient's residual added, and at rest
 * never above the largest omega_e^2 of an element (mass.c). Quadratic elements take a larger share
 * of it, SS_QUADRATIC_STEP_SHARE: the iteration therefore steps more often, and whenever strains
 * have changed.
 */
#include <math.h>
#include <string.h>

#include "models/common/dispatch.h"
#include "rt/hash.h"

SS_KERNEL_PATHS(ss_quadratic_kernels)

/* Outer steps between power steps for an unchanged body. */
enum { POWER_STEP_INTERVAL = 8, MAX_POWER_STEPS = 400 };
#define RESIDUAL 0.003
/* What is added for the part that the residual does not know, of omega^2. */
#define MARGIN 0.01
/* A change of the largest strain |2E| that is worth a power step. */
#define STRAIN_CHANGE 0.05
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
                              .wants_energy = out->is_wanted};
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
    for (int32_t i = 0; i < own->blocks.node_count; ++i) {
        diagonal[i] += own->diagonal[i];
    }
}

/* ---- power iteration ---- */

static ptrdiff_t value_count(const ss_quadratic *own)
{
    return 4 * (ptrdiff_t)own->blocks.node_count;
}

/* mode := M^-1 K mode at own->u, normed to x.Mx = 1; returns omega^2 from above, and the residual
 * over it. Units in which nothing over- or underflows: y = (M^-1 K / bound) mode. */
static double power_step(ss_quadratic *own, double *out_residual)
{
    ss_quadratic_stability *s = &own->stability;
    const ptrdiff_t count = value_count(own);
    double quotient = 0.0, square = 0.0;
    memset(s->product, 0, (size_t)count * sizeof *s->product);
    ss_quadratic_tangent(own, s->mode, s->product);
    for (ptrdiff_t k = 0; k < count; ++k) {
        const double force = (double)s->product[k];
        const double y = force * (double)s->mobility[k] / s->bound;
        quotient += (double)s->mode[k] * force;
        square += y * force;
        s->product[k] = (ss_real)y;
    }
    square *= s->bound;
    *out_residual = quotient > 0.0 ? sqrt(fmax(square - quotient * quotient, 0.0)) / quotient : 1.0;
    if (!(square > 0.0) || !isfinite(square)) {
        memcpy(s->mode, s->rest_mode, (size_t)count * sizeof *s->mode);
        *out_residual = 1.0;
        return s->rest_rate2;
    }
    const double norm = s->bound / sqrt(square);
    for (ptrdiff_t k = 0; k < count; ++k) {
        s->mode[k] = (ss_real)((double)s->product[k] * norm);
    }
    return fmax(quotient, 0.0) * (1.0 + fmax(*out_residual, MARGIN));
}

/* At rest, from a random start. */
static void iterate_at_rest(ss_quadratic *own)
{
    ss_quadratic_stability *s = &own->stability;
    const ptrdiff_t count = value_count(own);
    uint64_t seed = 1;
    double square = 0.0, residual = 1.0;
    for (ptrdiff_t k = 0; k < count; ++k) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        const double random = (double)(seed >> 11) / 9007199254740992.0 * 2.0 - 1.0;
        const double mobility = (double)s->mobility[k];
        s->mode[k] = mobility > 0.0 ? (ss_real)random : 0;
        square += mobility > 0.0 ? random * random / mobility : 0.0;
    }
    s->rest_rate2 = s->bound;
    if (!(square > 0.0) || !(s->bound > 0.0)) {
        return; /* nothing moves */
    }
    for (ptrdiff_t k = 0; k < count; ++k) {
        s->mode[k] = (ss_real)((double)s->mode[k] / sqrt(square));
    }
    double rate2 = s->bound;
    for (int k = 0; k < MAX_POWER_STEPS && residual > RESIDUAL; ++k) {
        rate2 = power_step(own, &residual);
    }
    s->rest_rate2 = fmin(rate2, s->bound);
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
                                   const ss_fem_material *material,
                                   const ss_quadratic_masses *masses, ss_arena *arena,
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
    const bool is_good = ss_quadratic_blocks_create(raised, material, arena, &out->blocks);
    *s = (ss_quadratic_stability){
        .bound = masses->bound,
        .mobility = ss_arena_get(arena, n, sizeof(ss_real)),
        .mode = ss_arena_get(arena, n, sizeof(ss_real)),
        .product = ss_arena_get(arena, n, sizeof(ss_real)),
        .rest_mode = ss_arena_get(arena, n, sizeof(ss_real)),
        .ratio = ss_arena_get(arena, (size_t)out->blocks.count * SS_FEM_LANES, sizeof(ss_real)),
        .worst = -1};
    ss_real *rest = ss_arena_get(arena, n, sizeof *rest);
    if (!is_good || ss_arena_status(arena) != SOFTSIM_OK) {
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
    iterate_at_rest(out);
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

/* Which elements are squeezed or inverted. */
static void look_at_volumes(ss_quadratic *own)
{
    ss_quadratic_stability *s = &own->stability;
    const ss_quadratic_pass pass = {.blocks = &own->blocks, .kind = own->kind, .u = own->u};
    const ss_real floor_ratio =
        (ss_real)(own->kind == SS_TISSUE_NEO_HOOKEAN ? SS_FEM_HELD_FLOOR : SS_TISSUE_GUARD);
    ss_real least = floor_ratio;
    own->kernels->ratio(&pass, s->ratio);
    s->squeezed = s->inverted = 0;
    for (ptrdiff_t k = 0; k < (ptrdiff_t)own->blocks.count * SS_FEM_LANES; ++k) {
        s->squeezed += s->ratio[k] < floor_ratio;
        s->inverted += s->ratio[k] <= 0;
        if (s->ratio[k] < least) {
            least = s->ratio[k];
            s->worst = own->blocks.element[k];
        }
    }
}

double ss_quadratic_stable_step(void *owner, const ss_body *body)
{
    ss_quadratic *own = owner;
    ss_quadratic_stability *s = &own->stability;
    const double strain = s->strain;
    (void)body;
    s->strain = 0.0;
    s->worst = -1;
    if (strain > INVERSION_STRAIN || s->inverted > 0) {
        look_at_volumes(own);
    } else {
        s->squeezed = 0;
    }
    if (own->kind == SS_TISSUE_LINEAR || !(s->bound > 0.0)) {
        return ss_quadratic_rest_step(own);
    }
    ++s->age;
    if (s->age >= POWER_STEP_INTERVAL || fabs(strain - s->strain_at_power_step) > STRAIN_CHANGE) {
        double residual;
        s->rate2 = fmax(power_step(own, &residual), s->rest_rate2);
        s->age = 0;
        s->strain_at_power_step = strain;
    }
    return step_limit(own, s->rate2);
}

void ss_quadratic_judge(const ss_quadratic *own, ss_body *body)
{
    const ss_quadratic_stability *s = &own->stability;
    if (s->inverted > 0) {
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, 0,
                      own->kind == SS_TISSUE_STVK
                          ? "elements are turned inside out, and stvk may keep them so: "
                            "stvk-guarded turns them back"
                          : "elements are turned inside out");
    } else if (s->squeezed > 0 && own->kind == SS_TISSUE_STVK_GUARDED) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "elements are squeezed below 0.65 of their volume: the guard pushes back");
    } else if (s->squeezed > 0 && own->kind == SS_TISSUE_NEO_HOOKEAN) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "elements are squeezed below 0.3 of their volume: the law goes on as a "
                      "straight line");
    }
    ss_body_set_worst_element(body, s->worst);
}

void ss_quadratic_reset(void *owner)
{
    ss_quadratic *own = owner;
    ss_quadratic_stability *s = &own->stability;
    memcpy(s->mode, s->rest_mode, (size_t)value_count(own) * sizeof *s->mode);
    s->rate2 = s->rest_rate2;
    s->strain_at_power_step = s->strain = 0.0;
    s->age = 0;
    s->squeezed = s->inverted = 0;
    s->worst = -1;
}

uint64_t ss_quadratic_hash(const void *owner, uint64_t seed)
{
    const ss_quadratic *own = owner;
    return ss_hash_bytes(seed, own->stability.mode, (size_t)value_count(own) * sizeof(ss_real));
}
