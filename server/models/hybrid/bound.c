/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * The stable step of core and layer together.
 *
 * omega^2, the largest eigenvalue of M^-1 K, by power iteration with the exact tangent, at rest:
 * all asleep, and with as many awake as may be around a few places of the skin, since the layer's
 * small particles, tied neighbours and the lighter nodes under an awake region each may have the
 * stiffest motion. The quotient x.Kx/x.Mx is below the eigenvalue; its residual is added. While
 * running, every POWER_STEP_INTERVAL steps, or when the largest strain |2E| has changed by what the
 * growth rule of common/fem_stability.c, 1 + 1.87 |2E|, makes a tenth of omega^2, one more step of
 * it at the present state. Half of the step that results is taken. (The paper's eq. (14) is no
 * bound: it is 1.3 to 2.1 times the stable step on three of four meshes.)
 */
#include <math.h>
#include <string.h>

#include "rt/random.h"
#include "rt/vec.h"

enum { POWER_STEP_INTERVAL = 32, MAX_POWER_STEPS = 100, PLACES = 4 };
#define RESIDUAL      0.02
#define STRAIN_CHANGE 0.05
#define STRAIN_GROWTH 1.8661

/* Random motion of everything that may move, x.Mx = 1. */
static void stir(ss_hybrid *hybrid)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    uint64_t seed = 1;
    double square = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes->count; ++k) {
        const double random = ss_random_start(&seed);
        const double mobility = (double)nodes->mobility[k];
        hybrid->mode[k] = mobility > 0.0 ? (ss_real)random : 0;
        square += mobility > 0.0 ? random * random / mobility : 0.0;
    }
    const double scale = square > 0.0 ? 1.0 / sqrt(square) : 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes->count; ++k) {
        hybrid->mode[k] = (ss_real)((double)hybrid->mode[k] * scale);
    }
}

/* mode := M^-1 K mode, normed; returns omega^2 with its residual, 0 when nothing moves. */
static double power_step(ss_hybrid *hybrid, double *out_residual)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    const ptrdiff_t count = 4 * (ptrdiff_t)nodes->count;
    double quotient = 0.0;
    double square = 0.0;
    double mass = 0.0;
    memset(hybrid->product, 0, (size_t)count * sizeof *hybrid->product);
    ss_hybrid_tangent(hybrid, hybrid->mode, hybrid->product);
    for (ptrdiff_t k = 0; k < count; ++k) {
        const double mobility = (double)nodes->mobility[k];
        const double x = mobility > 0.0 ? (double)hybrid->mode[k] : 0.0; /* nodes that left */
        const double y = (double)hybrid->product[k];
        quotient += x * y;
        square += y * y * mobility;
        mass += mobility > 0.0 ? x * x / mobility : 0.0;
    }
    *out_residual = 1.0;
    if (!(mass > 0.0) || !(square > 0.0) || !isfinite(square)) {
        stir(hybrid);
        return 0.0;
    }
    quotient /= mass;
    square /= mass;
    *out_residual = quotient > 0.0 ? sqrt(fmax(square / quotient / quotient - 1.0, 0.0)) : 1.0;
    const double scale = 1.0 / sqrt(square * mass);
    for (ptrdiff_t k = 0; k < count; ++k) {
        hybrid->mode[k] =
            (ss_real)((double)hybrid->product[k] * (double)nodes->mobility[k] * scale);
    }
    return fmax(quotient, 0.0) * (1.0 + *out_residual);
}

double ss_hybrid_converge_rate(ss_hybrid *hybrid)
{
    double residual = 1.0;
    double rate2 = 0.0;
    stir(hybrid);
    for (int k = 0; k < MAX_POWER_STEPS && residual > RESIDUAL; ++k) {
        rate2 = power_step(hybrid, &residual);
    }
    return rate2;
}

/* The skin node furthest from those tried before, in place k. */
static int32_t furthest(const ss_hybrid *hybrid, int32_t tried[PLACES], int32_t count)
{
    const ss_layer *layer = hybrid->layer;
    int32_t best = 0;
    double most = -1.0;
    for (int32_t s = 0; s < layer->skin_count && count > 0; ++s) {
        double least = (double)INFINITY;
        for (int32_t k = 0; k < count; ++k) {
            double d[3];
            ss_sub3(d, hybrid->mesh->position[layer->skin_node[s]],
                    hybrid->mesh->position[layer->skin_node[tried[k]]]);
            least = fmin(least, ss_dot3(d, d));
        }
        if (least > most) {
            most = least;
            best = s;
        }
    }
    return best;
}

void ss_hybrid_measure(ss_hybrid *hybrid)
{
    int32_t tried[PLACES];
    hybrid->u = ss_body_read_nodes(hybrid->body)->u;
    ss_hybrid_reset_layer(hybrid);
    hybrid->rest_rate2 = ss_hybrid_converge_rate(hybrid);
    for (int32_t k = 0; k < PLACES && !hybrid->is_all_awake && hybrid->layer->skin_count > 0; ++k) {
        tried[k] = furthest(hybrid, tried, k);
        ss_hybrid_wake_around(hybrid, tried[k]);
        hybrid->rest_rate2 = fmax(hybrid->rest_rate2, ss_hybrid_converge_rate(hybrid));
        ss_hybrid_reset_layer(hybrid);
    }
    ss_hybrid_forget(hybrid);
}

void ss_hybrid_forget(ss_hybrid *hybrid)
{
    hybrid->rate2 = hybrid->rest_rate2;
    hybrid->strain = hybrid->strain_at_power_step = 0.0;
    hybrid->age = 0;
    stir(hybrid);
}

double ss_hybrid_stable_step(void *owner, const ss_body *body)
{
    ss_hybrid *hybrid = owner;
    const double strain = hybrid->strain;
    (void)body;
    hybrid->strain = 0.0;
    ++hybrid->age;
    const double change = STRAIN_CHANGE * (1.0 + STRAIN_GROWTH * hybrid->strain_at_power_step);
    if (hybrid->age >= POWER_STEP_INTERVAL ||
        fabs(strain - hybrid->strain_at_power_step) > change) {
        double residual;
        const double rate2 = power_step(hybrid, &residual);
        const double certainty = fmax(0.0, 1.0 - residual); /* of a mode that still changes */
        hybrid->rate2 = fmax(certainty * rate2, hybrid->rest_rate2);
        hybrid->age = 0;
        hybrid->strain_at_power_step = strain;
    }
    return ss_body_step_limit(hybrid->material.integrator, hybrid->rate2,
                              hybrid->material.viscous_time, hybrid->material.mass_damping);
}
