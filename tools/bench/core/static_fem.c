/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/static_fem.h"
/*
 * Newton's method for f_int(u) = f_ext(u) on the free axes, u prescribed on the others:
 *
 *   f_int,a = sum over tetrahedra V P(H) grad N_a          H = sum_a u_a (grad N_a)^T
 *   K_ab    = sum V grad N_a . (dP/dH) . grad N_b
 *   f_ext   = force + m g - (p/6) sum over pressed triangles n,   n = (x1 - x0) x (x2 - x0)
 *
 * The pressure's tangent is (p/6) [c_b]x for every pair, c_b the edge opposite to b; its symmetric
 * part (p/12) [c_b - c_a]x is taken, which is all of it where the patch's rim is held.
 *
 * Everything prescribed grows with a factor from 0 to 1. An increment begins with the tangent's
 * prediction, in which held axes move all of their way; then full steps, halved while the residual
 * would grow or an element would turn over. An increment that does not come to an end is halved.
 * Rejected: moving the held axes alone first, which turns the elements beside them over.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/block_matrix.h"
#include "mesh/tetrahedron.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum {
    MAX_NEWTON = 30,   /* of an increment */
    MAX_HALVINGS = 12, /* of a step, and of the first increment */
    MAX_INCREMENTS = 400,
    MAX_PRODUCTS = 20000, /* of one linear solution */
    ALL_AXES = 7
};
#define TOLERANCE        1e-10 /* of the residual, relative to the internal forces */
#define LINEAR_TOLERANCE 1e-7  /* of a Newton step's linear solution */
#define USEFUL           1e-3  /* a linear solution worse than that is not used */

typedef double vector[3];

typedef struct element {
    double volume;
    double gradient[4][3];
} element;

typedef struct state {
    const ss_static_problem *problem;
    int32_t node_count;
    element *element;
    ss_block_matrix *matrix;
    vector *dead;     /* N: forces and weight, at factor 1 */
    vector *internal; /* N, at the last evaluation */
    vector *residual; /* external - internal, all axes */
    vector *trial, *step, *gap;
    double energy, factor;
} state;

/* ---- forces ---- */

/* H, row by row. */
static void gradient_of(const element *e, const int32_t node[4], const vector *u, double h[9])
{
    memset(h, 0, 9 * sizeof *h);
    for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) {
            ss_madd3(h + 3 * i, h + 3 * i, u[node[a]][i], e->gradient[a]);
        }
    }
}

static double stiffness_of(const ss_static_problem *problem, int32_t t)
{
    return problem->stiffness ? problem->stiffness[t] : 1.0;
}

static void add_pressure(const state *s, const vector *u)
{
    const ss_static_problem *problem = s->problem;
    for (int32_t t = 0; t < problem->pressed_count; ++t) {
        double x[3][3], n[3];
        for (int k = 0; k < 3; ++k) {
            const int32_t i = problem->pressed[t][k];
            ss_add3(x[k], problem->mesh->position[i], u[i]);
        }
        ss_normal3(n, x[0], x[1], x[2]);
        for (int k = 0; k < 3; ++k) {
            double *r = s->residual[problem->pressed[t][k]];
            ss_madd3(r, r, -s->factor * problem->pressure / 6.0, n);
        }
    }
}

/* Forces and energy at u; false where an element has turned over. */
static bool evaluate(state *s, const vector *u)
{
    const ss_static_problem *problem = s->problem;
    const ss_mesh *mesh = problem->mesh;
    bool is_upright = true;
    memset(s->internal, 0, (size_t)s->node_count * sizeof *s->internal);
    s->energy = 0.0;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const element *e = &s->element[t];
        const int32_t *node = mesh->tetrahedron[t];
        const double weight = e->volume * stiffness_of(problem, t);
        double h[9], p[9];
        gradient_of(e, node, u, h);
        is_upright = is_upright && ss_tissue_volume_change(h) > -1.0;
        ss_tissue_stress(&problem->law, h, p);
        s->energy += weight * ss_tissue_energy(&problem->law, h);
        for (int a = 0; a < 4; ++a) {
            for (int i = 0; i < 3; ++i) {
                s->internal[node[a]][i] += weight * ss_dot3(p + 3 * i, e->gradient[a]);
            }
        }
    }
    for (int32_t i = 0; i < s->node_count; ++i) {
        ss_scale3(s->residual[i], s->dead[i], s->factor);
        ss_sub3(s->residual[i], s->residual[i], s->internal[i]);
    }
    add_pressure(s, u);
    return is_upright || problem->law.kind == SS_TISSUE_LINEAR;
}

/* |r| on free axes. */
static double free_norm(const state *s)
{
    double sum = 0.0;
    for (int32_t i = 0; i < s->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            sum +=
                ((s->problem->held[i] >> k) & 1) != 0 ? 0.0 : s->residual[i][k] * s->residual[i][k];
        }
    }
    return sqrt(sum);
}

static double internal_norm(const state *s)
{
    double sum = 0.0;
    for (int32_t i = 0; i < s->node_count; ++i) {
        sum += ss_dot3(s->internal[i], s->internal[i]);
    }
    return sqrt(sum);
}

/* ---- tangent ---- */

/* c[3 k + l][3 i + j] = dP_ij / dH_kl */
static void tangent_of(const ss_tissue_law *law, const double h[9], double c[9][9])
{
    for (int n = 0; n < 9; ++n) {
        double dh[9] = {0.0};
        dh[n] = 1.0;
        ss_tissue_tangent(law, h, dh, c[n]);
    }
}

static void add_element(state *s, int32_t t, const vector *u)
{
    const element *e = &s->element[t];
    const int32_t *node = s->problem->mesh->tetrahedron[t];
    const double weight = e->volume * stiffness_of(s->problem, t);
    double h[9], c[9][9];
    gradient_of(e, node, u, h);
    tangent_of(&s->problem->law, h, c);
    for (int a = 0; a < 4; ++a) {
        double left[3][3][3]; /* sum_j grad N_a,j dP_ij / dH_kl */
        for (int i = 0; i < 3; ++i) {
            for (int n = 0; n < 9; ++n) {
                left[i][n / 3][n % 3] = ss_dot3(e->gradient[a], c[n] + 3 * i);
            }
        }
        for (int b = 0; b < 4; ++b) {
            double *block = s->matrix->block[ss_block_matrix_find(s->matrix, node[a], node[b])];
            for (int i = 0; i < 3; ++i) {
                for (int k = 0; k < 3; ++k) {
                    block[3 * i + k] += weight * ss_dot3(left[i][k], e->gradient[b]);
                }
            }
        }
    }
}

static void add_pressed(state *s, int32_t t, const vector *u)
{
    const ss_static_problem *problem = s->problem;
    const int32_t *node = problem->pressed[t];
    double x[3][3], opposite[3][3];
    for (int k = 0; k < 3; ++k) {
        ss_add3(x[k], problem->mesh->position[node[k]], u[node[k]]);
    }
    for (int k = 0; k < 3; ++k) {
        ss_sub3(opposite[k], x[(k + 2) % 3], x[(k + 1) % 3]);
    }
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            double c[3];
            if (a == b) {
                continue;
            }
            ss_sub3(c, opposite[b], opposite[a]);
            ss_scale3(c, c, s->factor * problem->pressure / 12.0);
            double *block = s->matrix->block[ss_block_matrix_find(s->matrix, node[a], node[b])];
            block[1] -= c[2];
            block[2] += c[1];
            block[3] += c[2];
            block[5] -= c[0];
            block[6] -= c[1];
            block[7] += c[0];
        }
    }
}

static void assemble(state *s, const vector *u)
{
    ss_block_matrix_clear(s->matrix);
    for (int32_t t = 0; t < s->problem->mesh->tetrahedron_count; ++t) {
        add_element(s, t, u);
    }
    for (int32_t t = 0; t < s->problem->pressed_count; ++t) {
        add_pressed(s, t, u);
    }
    ss_block_matrix_prepare(s->matrix, s->problem->held);
}

/* ---- Newton ---- */

static double prescribed(const ss_static_problem *problem, int32_t i, int k)
{
    return problem->prescribed ? problem->prescribed[i][k] : 0.0;
}

/* step := K^-1 (residual - K gap) + gap; false where the linear solution is of no use. */
static bool solve_step(state *s, const vector *u)
{
    const int32_t n = s->node_count;
    assemble(s, u);
    ss_block_matrix_multiply(s->matrix, (const vector *)s->gap, s->trial);
    for (int32_t i = 0; i < n; ++i) {
        ss_sub3(s->trial[i], s->residual[i], s->trial[i]);
    }
    const double left = ss_block_matrix_solve(s->matrix, s->problem->held, (const vector *)s->trial,
                                              LINEAR_TOLERANCE, MAX_PRODUCTS, s->step, NULL);
    for (int32_t i = 0; i < n; ++i) {
        ss_add3(s->step[i], s->step[i], s->gap[i]);
    }
    return left < USEFUL || s->problem->law.kind != SS_TISSUE_LINEAR;
}

/* Moves u to the equilibrium at s->factor, held axes on the way from `base` (their places at factor
 * 0) to the problem's; false and u at a loss where that does not come to an end. */
static bool increment(state *s, const vector *base, vector *u, int32_t *inout_iterations)
{
    const int32_t n = s->node_count;
    for (int32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double goal =
                base[i][k] + s->factor * (prescribed(s->problem, i, k) - base[i][k]);
            s->gap[i][k] = ((s->problem->held[i] >> k) & 1) != 0 ? goal - u[i][k] : 0.0;
        }
    }
    (void)evaluate(s, (const vector *)u);
    for (int k = 0; k < MAX_NEWTON; ++k) {
        const double before = free_norm(s);
        const bool is_first = k == 0;
        if (!is_first && before <= TOLERANCE * internal_norm(s)) {
            return true;
        }
        ++*inout_iterations;
        if (!solve_step(s, (const vector *)u)) {
            return false;
        }
        double share = 1.0;
        bool is_better = false;
        for (int m = 0; m < MAX_HALVINGS && !is_better; ++m, share *= 0.5) {
            for (int32_t i = 0; i < n; ++i) {
                ss_madd3(s->trial[i], u[i], share, s->step[i]);
            }
            const bool is_upright = evaluate(s, (const vector *)s->trial);
            const double after = free_norm(s);
            is_better = is_upright && isfinite(after) && (is_first || after < before);
            if (is_first && !is_better) {
                return false; /* the held axes must move all of their way */
            }
        }
        if (!is_better) { /* at the end of the arithmetic, or at a loss */
            (void)evaluate(s, (const vector *)u);
            return free_norm(s) <= 100.0 * TOLERANCE * internal_norm(s);
        }
        memcpy(u, s->trial, (size_t)n * sizeof *u);
        memset(s->gap, 0, (size_t)n * sizeof *s->gap);
    }
    return false;
}

static softsim_status climb(state *s, vector *u, vector *base, vector *good,
                            ss_static_report *report, softsim_error *error)
{
    const size_t bytes = (size_t)s->node_count * sizeof *u;
    double reached = 0.0, size = 1.0;
    memcpy(base, u, bytes);
    memcpy(good, u, bytes);
    while (reached < 1.0 && report->increments++ < MAX_INCREMENTS) {
        s->factor = fmin(1.0, reached + size);
        if (increment(s, (const vector *)base, u, &report->iterations)) {
            reached = s->factor;
            size *= 1.5;
            memcpy(good, u, bytes);
            continue;
        }
        memcpy(u, good, bytes);
        size *= 0.5;
        if (size < ldexp(1.0, -MAX_HALVINGS)) {
            break;
        }
    }
    if (reached < 1.0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                          "no equilibrium found beyond %.3g of the load: hold the body so that it "
                          "cannot move as a whole, load it less, or take a finer mesh",
                          reached);
        return SOFTSIM_ERROR_SYSTEM;
    }
    return SOFTSIM_OK;
}

/* ---- life ---- */

static softsim_status check(const ss_static_problem *problem, softsim_error *error)
{
    const ss_tissue_law *law = &problem->law;
    if (!(law->mu > 0.0) || !(3.0 * law->lambda + 2.0 * law->mu > 0.0) || !isfinite(law->mu) ||
        !isfinite(law->lambda)) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "a law with lambda %g Pa and mu %g Pa is not a law: take E > 0 and Poisson's "
            "ratio between -1 and 0.5",
            law->lambda, law->mu);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    int held = 0;
    for (int32_t i = 0; i < problem->mesh->node_count; ++i) {
        held |= problem->held[i];
    }
    if (held != ALL_AXES || problem->mesh->tetrahedron_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          problem->mesh->tetrahedron_count == 0
                              ? "a surface mesh has no tetrahedra: give a volume mesh"
                              : "the body is not held: hold nodes on all three axes");
        return SOFTSIM_ERROR_MESH;
    }
    return SOFTSIM_OK;
}

static softsim_status build(state *s, softsim_error *error)
{
    const ss_static_problem *problem = s->problem;
    const ss_mesh *mesh = problem->mesh;
    const size_t n = (size_t)mesh->node_count;
    s->element = ss_memory_get((size_t)mesh->tetrahedron_count, sizeof *s->element);
    s->dead = ss_memory_get(8 * n, sizeof *s->dead);
    if (!s->element || !s->dead) {
        return SOFTSIM_ERROR_MEMORY;
    }
    s->internal = s->dead + n;
    s->residual = s->dead + 2 * n;
    s->trial = s->dead + 3 * n;
    s->step = s->dead + 4 * n;
    s->gap = s->dead + 5 * n;
    for (int32_t i = 0; problem->force && i < mesh->node_count; ++i) {
        ss_copy3(s->dead[i], problem->force[i]);
    }
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const int32_t *c = mesh->tetrahedron[t];
        element *e = &s->element[t];
        e->volume =
            fabs(ss_tetrahedron_gradients(mesh->position[c[0]], mesh->position[c[1]],
                                          mesh->position[c[2]], mesh->position[c[3]], e->gradient));
        if (!ss_is_finite(e->gradient[0], 12)) {
            softsim_error_add(error, SOFTSIM_ERROR_MESH, "tetrahedron %d is flat: repair the mesh",
                              ss_mesh_file_element(mesh, t));
            return SOFTSIM_ERROR_MESH;
        }
        for (int a = 0; a < 4; ++a) {
            double *f = s->dead[c[a]];
            ss_madd3(f, f, 0.25 * problem->density * e->volume, problem->gravity);
        }
    }
    return ss_block_matrix_create(mesh->node_count, mesh->tetrahedron_count,
                                  (const int32_t(*)[4])mesh->tetrahedron, &s->matrix);
}

softsim_status ss_static_solve(const ss_static_problem *problem, double (*inout_u)[3],
                               double (*out_reaction)[3], ss_static_report *out_report,
                               softsim_error *error)
{
    state s = {.problem = problem, .node_count = problem->mesh->node_count, .factor = 1.0};
    ss_static_report report = {0};
    softsim_status status = check(problem, error);
    status = status == SOFTSIM_OK ? build(&s, error) : status;
    if (status == SOFTSIM_OK) {
        status = climb(&s, inout_u, s.dead + 6 * (ptrdiff_t)s.node_count,
                       s.dead + 7 * (ptrdiff_t)s.node_count, &report, error);
    }
    if (status == SOFTSIM_OK) {
        (void)evaluate(&s, (const vector *)inout_u);
        report.energy = s.energy;
        const double whole = internal_norm(&s);
        report.residual = whole > 0.0 ? free_norm(&s) / whole : 0.0;
        for (int32_t i = 0; out_reaction && i < s.node_count; ++i) {
            for (int k = 0; k < 3; ++k) {
                const bool is_held = ((problem->held[i] >> k) & 1) != 0;
                out_reaction[i][k] = is_held ? -s.residual[i][k] : 0.0;
            }
        }
    }
    if (out_report) {
        *out_report = report;
    }
    ss_memory_free(s.element);
    ss_memory_free(s.dead);
    ss_block_matrix_destroy(&s.matrix);
    return status;
}

softsim_status ss_static_linear(const ss_mesh *mesh, double youngs_modulus, double poisson_ratio,
                                const uint8_t *held, const double (*prescribed_u)[3],
                                double (*out_u)[3], double (*out_reaction)[3], softsim_error *error)
{
    ss_static_problem problem = {
        .mesh = mesh, .held = held, .prescribed = prescribed_u, .law = {.kind = SS_TISSUE_LINEAR}};
    ss_tissue_lame(youngs_modulus, poisson_ratio, &problem.law.lambda, &problem.law.mu);
    memset(out_u, 0, (size_t)mesh->node_count * sizeof *out_u);
    return ss_static_solve(&problem, out_u, out_reaction, NULL, error);
}
