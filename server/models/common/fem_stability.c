/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
/*
 * The stable step: computed, not guessed, and certified.
 *
 * Symplectic Euler is stable for h < dt* = 2/omega, omega^2 the largest eigenvalue of M^-1 K. With
 * a viscous stiffness of at most tau K (plan.h: ss_plan_viscosity) and velocities half a step
 * behind, h < (2/omega)(sqrt(1 + zeta^2) - zeta), zeta = tau omega/2. RK4 has |z| < 2.828 on the
 * imaginary axis and at least 2.615 anywhere left of it.
 *
 * omega is bounded in two ways:
 *
 *   power iteration   x := M^-1 K x at the present state. The quotient x.Kx / x.Mx is below
 *                     omega^2; within its residual lies an eigenvalue, the largest or one so near
 *                     that a hundredth more covers it. Their sum is what is reported.
 *                     At rest it starts from the mode that fastest_mode.c finds.
 *   assembled bound   omega^2 <= max_e omega_e^2 when the mass of each node is distributed over its
 *                     elements, here in proportion to V (lambda + 2 mu) |grad N|^2 (Fried 1972).
 *                     omega_e^2 is the largest eigenvalue of the 6 x 6 matrix V C^1/2 B M_e^-1 B^T
 *                     C^1/2, taken from above as tr(A^64)^(1/64). At rest 0.57 to 0.77 of dt*.
 *
 * Sub-steps take SS_FEM_STEP_SHARE of the reported step, which therefore also satisfies the
 * assembled bound. As the body stretches the bound grows at most as fem_kernels.c (growth) says,
 * which costs nothing to follow for the body as a whole (force sweeps report the largest strain)
 * and one sweep element by element, done only where the first would cost steps; every
 * POWER_STEP_INTERVAL steps, or where strains have changed, the power iteration takes one more step
 * from where it was. With the cure for locking the bound is that of the elements' own part plus
 * that of the nodes' (fem_average.c), exact at rest; where the elements of a node are stretched
 * unlike one another the power iteration alone sees it. The laws of J have no such rule of growth:
 * there, too, it is the power iteration, which steps more often.
 *
 * The paper's eq. (14) is no bound: as printed it is 1.02 times dt* on HM2 (softsim-bench paper
 * hybrid has it on four bodies, by four readings).
 * Rejected: the element's own eigenvalue with its own mass, safe but 0.04 of dt* with slivers.
 */
#include <math.h>
#include <string.h>

#include "mesh/tetrahedron.h"
#include "models/common/fastest_mode.h"
#include "rt/hash.h"
#include "rt/random.h"

/* Outer steps between power steps for an unchanged body, and for one whose law has no rule of
 * growth. */
enum { POWER_STEP_INTERVAL = 32, POWER_STEP_INTERVAL_NO_RULE = 4 };
/* Power iterations at rest, and the residual that ends them. */
enum { MAX_POWER_STEPS = 400 };
#define RESIDUAL 0.003
/* What is added for the part that the residual does not know, of omega^2. */
#define MARGIN 0.01
/* Of a power of a matrix whose trace was 1 before it was squared: next to one eigenvalue alone. */
#define LONE_TRACE (1.0 - 1e-8)
/* A change of the largest strain that is worth a power step. */
#define STRAIN_CHANGE 0.05
/* A bound that costs more than this of omega^2 is computed again element by element. */
#define ELEMENT_PASS_RATIO 1.1
/* Below this |2E| no element is squeezed to the guard's ratio of volumes: (1 - s/sqrt 3)^3 = J0^2.
 */
#define UNGUARDED_STRAIN 0.43
/* From here on elements may be inverted: a side of length 0 has |2E| = 1. */
#define INVERSION_STRAIN 0.9

/* ---- the assembled bound ---- */

/* Rows xx yy zz, then yz zx xy times sqrt 2, of the strain of a node that moves by e_i, with
 * gradient g. */
static void strain_column(const double g[3], int i, double out[6])
{
    memset(out, 0, 6 * sizeof *out);
    out[i] = g[i];
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        if (i == a) {
            out[3 + k] = sqrt(0.5) * g[b];
        } else if (i == b) {
            out[3 + k] = sqrt(0.5) * g[a];
        }
    }
}

/* tr(A^64)^(1/64): between the largest eigenvalue and 1.03 times it, for symmetric A >= 0. Powers
 * of A stay symmetric: half of each is computed. They end where one eigenvalue is left: further
 * ones would take next to nothing off. */
static double largest_eigenvalue(double a[6][6])
{
    double power = 1.0, log_scale = 0.0;
    for (int turn = 0;; ++turn) {
        const double trace = a[0][0] + a[1][1] + a[2][2] + a[3][3] + a[4][4] + a[5][5];
        if (!(trace > 0.0)) {
            return 0.0;
        }
        log_scale += log(trace) / power;
        if (turn == 6 || (turn > 0 && trace > LONE_TRACE)) {
            return exp(log_scale);
        }
        power *= 2.0;
        const double scale = 1.0 / trace;
        double b[6][6];
        for (int i = 0; i < 36; ++i) {
            b[i / 6][i % 6] = a[i / 6][i % 6] * scale;
        }
        for (int i = 0; i < 6; ++i) {
            for (int j = i; j < 6; ++j) {
                double sum = 0.0;
                for (int k = 0; k < 6; ++k) {
                    sum += b[i][k] * b[j][k];
                }
                a[i][j] = a[j][i] = sum;
            }
        }
    }
}

/* omega_e^2 with nodal masses m. C^1/2 = sqrt(2 mu) I + (sqrt(3 lambda + 2 mu) - sqrt(2 mu))/3
 * times the ones of the first three rows. */
static double element_rate2(double lambda, double mu, double volume, const double gradient[4][3],
                            const double mass[4])
{
    const double shear = sqrt(2.0 * mu), bulk = (sqrt(3.0 * lambda + 2.0 * mu) - shear) / 3.0;
    double a[6][6] = {{0.0}};
    for (int n = 0; n < 4; ++n) {
        for (int i = 0; i < 3; ++i) {
            double b[6], c[6];
            strain_column(gradient[n], i, b);
            for (int k = 0; k < 6; ++k) {
                c[k] = shear * b[k] + (k < 3 ? bulk * (b[0] + b[1] + b[2]) : 0.0);
            }
            const double scale = volume / mass[n];
            for (int k = 0; k < 6; ++k) {
                for (int j = 0; j <= k; ++j) {
                    a[k][j] += scale * c[k] * c[j];
                }
            }
        }
    }
    for (int k = 0; k < 36; ++k) {
        a[k / 6][k % 6] = k % 6 <= k / 6 ? a[k / 6][k % 6] : a[k % 6][k / 6];
    }
    return largest_eigenvalue(a);
}

static double element_geometry(const ss_fem_setup *setup, int32_t e, double gradient[4][3])
{
    const int32_t *c = setup->mesh->tetrahedron[e];
    const double(*x)[3] = (const double(*)[3])setup->mesh->position;
    const double volume = ss_tetrahedron_gradients(x[c[0]], x[c[1]], x[c[2]], x[c[3]], gradient);
    return volume * (setup->volume_share ? setup->volume_share[e] : 1.0);
}

/* The stiffness that decides an element's fraction of a node's mass. */
static double mass_weight(const ss_fem_setup *setup, int32_t e, double volume,
                          const double gradient[3])
{
    const ss_fem_material *material = setup->material;
    return volume * (material->lambda[e] + 2.0 * material->mu[e]) * ss_dot3(gradient, gradient);
}

/* bound of every element; the diagonal of K on the way. */
static bool set_bounds(ss_fem *fem, const ss_fem_setup *setup)
{
    ss_fem_stability *stability = &fem->stability;
    const ss_fem_material *material = setup->material;
    double max_rate2[2] = {0.0, 0.0};
    ss_arena scratch = {0};
    double *mass_weight_sum =
        ss_arena_get(&scratch, (size_t)setup->node_count, sizeof *mass_weight_sum);
    double *shared = ss_arena_get(&scratch, (size_t)setup->node_count, sizeof *shared);
    if (!mass_weight_sum || !shared ||
        (fem->average.modulus && !ss_fem_average_bound(&fem->average, setup, shared))) {
        ss_arena_free(&scratch);
        return false;
    }
    for (int32_t e = 0; e < setup->mesh->tetrahedron_count; ++e) {
        const int32_t *c = setup->mesh->tetrahedron[e];
        double gradient[4][3];
        const double volume = element_geometry(setup, e, gradient);
        for (int a = 0; a < 4; ++a) {
            mass_weight_sum[c[a]] += mass_weight(setup, e, volume, gradient[a]);
            fem->diagonal[c[a]] += volume * ss_dot3(gradient[a], gradient[a]) *
                                   (material->lambda[e] + 4.0 * material->mu[e]) / 3.0;
        }
    }
    for (ptrdiff_t k = 0; k < (ptrdiff_t)fem->blocks.count * SS_FEM_LANES; ++k) {
        const int32_t e = fem->blocks.element[k];
        if (e < 0) {
            continue;
        }
        const int32_t *c = setup->mesh->tetrahedron[e];
        double gradient[4][3], mass[4], averaged = 0.0;
        const double volume = element_geometry(setup, e, gradient);
        for (int a = 0; a < 4; ++a) {
            mass[a] = setup->mass[c[a]] * mass_weight(setup, e, volume, gradient[a]) /
                      mass_weight_sum[c[a]];
            averaged = fmax(averaged, shared[c[a]] / setup->mass[c[a]]);
        }
        const double whole = element_rate2(material->lambda[e], material->mu[e], volume,
                                           (const double(*)[3])gradient, mass);
        const double own = material->lambda_own[e] == material->lambda[e]
                               ? whole
                               : element_rate2(material->lambda_own[e], material->mu[e], volume,
                                               (const double(*)[3])gradient, mass);
        stability->bound[k] = (ss_real)whole;
        stability->growth[k] = (ss_real)(own + averaged);
        max_rate2[0] = fmax(max_rate2[0], whole);
        max_rate2[1] = fmax(max_rate2[1], own + averaged);
    }
    /* One of the two for all elements: they are two ways of distributing the same energy. */
    stability->rest_bound = max_rate2[0];
    if (fem->average.modulus && max_rate2[1] < max_rate2[0]) {
        stability->rest_bound = max_rate2[1];
        memcpy(stability->bound, stability->growth,
               (size_t)fem->blocks.count * SS_FEM_LANES * sizeof(ss_real));
    }
    ss_arena_free(&scratch);
    return true;
}

/* ---- power iteration ---- */

static double dot(const ss_fem *fem, const ss_real *x, const ss_real *y)
{
    double sum = 0.0;
    for (ptrdiff_t k = 0; k < (ptrdiff_t)fem->blocks.node_count * 4; ++k) {
        sum += (double)x[k] * (double)y[k];
    }
    return sum;
}

/* One step at fem->u: mode := M^-1 K mode, normed; returns omega^2 from above, and the residual
 * over it. `mode` has x.Mx = 1 before and after, in units in which nothing over- or underflows:
 * with b the bound at rest, y = (M^-1 K / b) mode. */
static double power_step(ss_fem *fem, double *out_residual)
{
    ss_fem_stability *s = &fem->stability;
    const ptrdiff_t count = (ptrdiff_t)fem->blocks.node_count * 4;
    memset(s->product, 0, (size_t)count * sizeof(ss_real));
    ss_fem_tangent(fem, s->mode, s->product);
    const double quotient = dot(fem, s->mode, s->product);
    double square = 0.0; /* of M^-1/2 K x */
    const double scale = 1.0 / s->rest_bound;
    for (ptrdiff_t k = 0; k < count; ++k) {
        const double y = (double)s->product[k] * (double)s->mobility[k] * scale;
        square += y * (double)s->product[k];
        s->product[k] = (ss_real)y;
    }
    square *= s->rest_bound;
    *out_residual = quotient > 0.0 ? sqrt(fmax(square - quotient * quotient, 0.0)) / quotient : 1.0;
    if (!(square > 0.0) || !isfinite(square)) {
        memcpy(s->mode, s->rest_mode, (size_t)count * sizeof(ss_real));
        *out_residual = 1.0;
        return s->rest_rate2;
    }
    const double norm = s->rest_bound / sqrt(square);
    for (ptrdiff_t k = 0; k < count; ++k) {
        s->mode[k] = (ss_real)((double)s->product[k] * norm);
    }
    return fmax(quotient, 0.0) * (1.0 + fmax(*out_residual, MARGIN));
}

/* Power iteration at rest, from the fastest mode found from a random start. */
static bool iterate_at_rest(ss_fem *fem)
{
    ss_fem_stability *s = &fem->stability;
    uint64_t seed = 1;
    double square = 0.0, residual = 1.0;
    for (ptrdiff_t k = 0; k < (ptrdiff_t)fem->blocks.node_count * 4; ++k) {
        const double random = ss_random_start(&seed);
        const double mobility = (double)s->mobility[k];
        s->mode[k] = mobility > 0.0 ? (ss_real)random : 0;
        square += mobility > 0.0 ? random * random / mobility : 0.0;
    }
    s->rest_rate2 = s->rest_bound;
    if (!(square > 0.0) || !(s->rest_bound > 0.0)) {
        return true; /* nothing moves */
    }
    for (ptrdiff_t k = 0; k < (ptrdiff_t)fem->blocks.node_count * 4; ++k) {
        s->mode[k] = (ss_real)((double)s->mode[k] / sqrt(square));
    }
    if (ss_find_fastest_mode(fem->blocks.node_count, s->mobility, ss_fem_tangent, fem, RESIDUAL,
                             MAX_POWER_STEPS, s->mode) != SOFTSIM_OK) {
        return false;
    }
    double rate2 = s->rest_bound;
    for (int k = 0; k < MAX_POWER_STEPS && residual > RESIDUAL; ++k) {
        rate2 = power_step(fem, &residual);
    }
    s->rest_rate2 = fmin(rate2, s->rest_bound);
    memcpy(s->rest_mode, s->mode, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    return true;
}

/* ---- life ---- */

bool ss_fem_stability_create(ss_fem *fem, const ss_fem_setup *setup, int32_t padded)
{
    ss_fem_stability *s = &fem->stability;
    const size_t n = (size_t)padded * 4, values = (size_t)fem->blocks.count * SS_FEM_LANES;
    ss_arena *arena = &fem->arena;
    *s = (ss_fem_stability){.bound = ss_arena_get(arena, values, sizeof *s->bound),
                            .growth = ss_arena_get(arena, values, sizeof *s->growth),
                            .ratio = ss_arena_get(arena, values, sizeof *s->ratio),
                            .mobility = ss_arena_get(arena, n, sizeof *s->mobility),
                            .mode = ss_arena_get(arena, n, sizeof *s->mode),
                            .product = ss_arena_get(arena, n, sizeof *s->product),
                            .rest_mode = ss_arena_get(arena, n, sizeof *s->rest_mode),
                            .worst = -1};
    if (ss_arena_status(arena) != SOFTSIM_OK || !set_bounds(fem, setup)) {
        return false;
    }
    for (int32_t i = 0; i < setup->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const bool is_free = setup->mass[i] > 0.0 && (setup->fixed[i] & (1 << k)) == 0;
            s->mobility[4 * (ptrdiff_t)i + k] = is_free ? (ss_real)(1.0 / setup->mass[i]) : 0;
        }
    }
    if (!iterate_at_rest(fem)) {
        return false;
    }
    s->rate2 = s->rest_rate2;
    return true;
}

double ss_fem_step_limit(const ss_fem *fem, double rate2)
{
    return ss_body_step_limit(fem->integrator, rate2, fem->viscous_time, fem->mass_damping);
}

double ss_fem_rest_step(const ss_fem *fem)
{
    return ss_fem_step_limit(fem, fem->stability.rest_rate2);
}

/* ---- while running ---- */

/* Every element: the bound, and which are squeezed or inverted. */
static double bound_by_element(ss_fem *fem)
{
    ss_fem_stability *s = &fem->stability;
    const ss_fem_pass pass = {.blocks = &fem->blocks,
                              .kind = fem->kind,
                              .u = fem->u,
                              .pressure = fem->average.modulus ? fem->average.pressure : NULL};
    fem->kernels->growth(&pass, s->growth, s->ratio);
    const ss_real floor_ratio =
        (ss_real)(fem->kind == SS_TISSUE_NEO_HOOKEAN ? SS_TISSUE_FLOOR : SS_TISSUE_GUARD);
    double largest = 0.0;
    ss_real least = 1;
    s->squeezed = s->inverted = 0;
    for (ptrdiff_t k = 0; k < (ptrdiff_t)fem->blocks.count * SS_FEM_LANES; ++k) {
        const double bound = (double)s->bound[k] * (double)s->growth[k];
        s->squeezed += s->ratio[k] < floor_ratio && fem->blocks.element[k] >= 0;
        s->inverted += s->ratio[k] <= 0 && fem->blocks.element[k] >= 0;
        if (s->ratio[k] < least && s->ratio[k] < floor_ratio) {
            least = s->ratio[k];
            s->worst = fem->blocks.element[k];
        } else if (bound > largest && least == 1) {
            s->worst = fem->blocks.element[k];
        }
        largest = bound > largest ? bound : largest;
    }
    return largest;
}

double ss_fem_stable_step(void *owner, const ss_body *body)
{
    ss_fem *fem = owner;
    ss_fem_stability *s = &fem->stability;
    const double strain = s->strain;
    (void)body;
    s->strain = 0.0;
    if (fem->kind == SS_TISSUE_LINEAR || !fem->u || !(s->rest_bound > 0.0)) {
        return ss_fem_rest_step(fem);
    }
    const bool has_rule = fem->kind == SS_TISSUE_STVK || fem->kind == SS_TISSUE_STVK_GUARDED;
    ++s->age;
    if (s->age >= (has_rule ? POWER_STEP_INTERVAL : POWER_STEP_INTERVAL_NO_RULE) ||
        fabs(strain - s->strain_at_power_step) > STRAIN_CHANGE) {
        double residual;
        s->rate2 = fmax(power_step(fem, &residual), s->rest_rate2);
        s->age = 0;
        s->strain_at_power_step = strain;
    }
    /* Sub-steps are that share of what is reported: share^2 of the bound is enough. */
    const double share2 = SS_FEM_STEP_SHARE * SS_FEM_STEP_SHARE;
    /* |F|^2 <= 1 + |D|, tr D <= sqrt 3 |D|, so s/(lambda + 2 mu) <= sqrt 3 / 2 |D| */
    double bound = s->rest_bound * (1.0 + 1.8661 * strain);
    const bool may_invert = strain > INVERSION_STRAIN || s->inverted > 0;
    if (may_invert || (has_rule && (bound > ELEMENT_PASS_RATIO / share2 * s->rate2 ||
                                    strain > UNGUARDED_STRAIN))) {
        const double by_element = bound_by_element(fem);
        bound = has_rule ? by_element : bound;
    } else {
        s->squeezed = 0;
    }
    const double rate2 = has_rule ? fmax(s->rate2, share2 * bound) : s->rate2;
    return ss_fem_step_limit(fem, rate2);
}

void ss_fem_judge_elements(ss_body *body, ss_tissue_kind kind, int32_t inverted, int32_t squeezed,
                           int32_t worst, const char *squeezed_text)
{
    if (inverted > 0) {
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, 0,
                      kind == SS_TISSUE_STVK
                          ? "elements are turned inside out, and stvk may keep them so: "
                            "stvk-guarded turns them back"
                          : "elements are turned inside out");
    } else if (squeezed > 0 && kind == SS_TISSUE_STVK_GUARDED) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "elements are squeezed below 0.65 of their volume: the guard pushes back");
    } else if (squeezed > 0 && kind == SS_TISSUE_NEO_HOOKEAN) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0, squeezed_text);
    }
    ss_body_set_worst_element(body, worst);
}

void ss_fem_judge(const ss_fem *fem, ss_body *body)
{
    const ss_fem_stability *s = &fem->stability;
    ss_fem_judge_elements(body, fem->kind, s->inverted, s->squeezed, s->worst,
                          "elements are squeezed below 0.2 of their volume: the law goes on as a "
                          "parabola");
}

void ss_fem_reset(void *owner)
{
    ss_fem *fem = owner;
    ss_fem_stability *s = &fem->stability;
    memcpy(s->mode, s->rest_mode, (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
    s->rate2 = s->rest_rate2;
    s->strain_at_power_step = s->strain = 0.0;
    s->age = 0;
    s->squeezed = s->inverted = 0;
}

uint64_t ss_fem_hash(const void *owner, uint64_t seed)
{
    const ss_fem *fem = owner;
    return ss_hash_bytes(seed, fem->stability.mode,
                         (size_t)fem->blocks.node_count * 4 * sizeof(ss_real));
}
