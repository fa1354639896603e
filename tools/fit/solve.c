/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Two stages. From a start that may be off by a factor of a hundred, plain least squares has
 * plateaus: with a body far too soft every force is nearly 0 and r does not change. The first stage
 * therefore minimises the compressed residuals, r' = asinh(F/s) - asinh(D/s) of force F and datum D
 * with s a hundredth of the largest force, which grow with the logarithm of the error; by subplex
 * (NLopt's LN_SBPLX, Rowan 1990), which needs no derivative and takes one unknown as well as eight.
 * The second stage is Gauss-Newton on r itself, damped (Levenberg 1944), with one-sided differences
 * of 1 %: a handful of evaluations where a simplex needs a hundred. Differences of 3 %, on both
 * sides, then give the Jacobian J of the answer: coarse beside rounding and roughness, fine beside
 * a factor of two.
 *
 * What the data tell. Along an eigenvector v of J^T J the residual changes by |J v| for each factor
 * of e, at right angles to what is left of it. v is flat if a factor of two
 * along it raises the misfit by under 2 % (a change of a fifth of it), or changes it by less than a
 * floor, since no data are perfect: the data do not tell it. The answer is then moved back along v
 * to where it started, if the misfit allows; a parameter that nothing is known of keeps the user's
 * value. Rejected: standard errors s^2 (J^T J)^-1, which take the misfit for independent noise and
 * so promise more the more points a smooth curve has.
 */
#include "solve.h"
#include "rt/each.h"
#include "rt/vec.h"

#include <math.h>
#include <nlopt.h>
#include <stdlib.h>
#include <string.h>

enum { GAUSS_STEPS = 25, DAMPING_TRIES = 6, JACOBI_SWEEPS = 30, PROBES = 6, ROUGH_TRIES = 20 };
static const double ROUGH_STEP = 0.7;  /* first step of the search */
static const double ROUGH_END = 0.03;  /* its last */
static const double ROUGH_GOOD = 4e-4; /* |r'|^2 that is near enough */
static const double GAUSS_DIFFERENCE = 0.01, FINAL_DIFFERENCE = 0.03;
static const double GAUSS_REACH = 1.0;          /* of a step, each unknown */
static const double GAUSS_END = 1e-4;           /* of a step */
static const double MISFIT_END = 1e-5;          /* of |r|: a step that gains less is the last */
static const double FLAT = 0.69314718055994531; /* a factor of two */
static const double FAILED = 1e6;               /* |r|^2 where there is no residual */
static const double ALONE = 0.95;               /* of a unit vector in one unknown */
static const double ROOM = 0.2;                 /* of the misfit, at right angles to it: 2 % more */

typedef struct work {
    ss_solve *solve;
    double *residual, *other;
    double *jacobian; /* m by n */
} work;

static double evaluate(work *w, const double *x, bool is_rough, double *out)
{
    ss_solve *s = w->solve;
    ++s->evaluations;
    if (!s->residual(s->context, x, is_rough, out)) {
        return FAILED;
    }
    double sum = 0.0;
    for (int32_t k = 0; k < s->m; ++k) {
        sum += out[k] * out[k];
    }
    return isfinite(sum) ? fmin(sum, FAILED) : FAILED;
}

/* ---- search ---- */

static double rough_misfit(unsigned n, const double *x, double *gradient, void *context)
{
    (void)n;
    (void)gradient; /* never asked for */
    work *w = context;
    return evaluate(w, x, true, w->other);
}

static bool search(work *w)
{
    ss_solve *s = w->solve;
    nlopt_opt search = nlopt_create(NLOPT_LN_SBPLX, (unsigned)s->n);
    double best = FAILED;
    if (!search) {
        return false;
    }
    nlopt_set_lower_bounds(search, s->lower);
    nlopt_set_upper_bounds(search, s->upper);
    nlopt_set_min_objective(search, rough_misfit, w);
    nlopt_set_initial_step1(search, ROUGH_STEP);
    nlopt_set_xtol_abs1(search, ROUGH_END);
    nlopt_set_stopval(search, ROUGH_GOOD);
    const int32_t most = ROUGH_TRIES * (s->n + 1);
    nlopt_set_maxeval(search, most < s->max_evaluations / 2 ? most : s->max_evaluations / 2);
    const nlopt_result result = nlopt_optimize(search, s->x, &best);
    nlopt_destroy(search);
    return result > 0 || result == NLOPT_ROUNDOFF_LIMITED;
}

/* ---- Gauss-Newton ---- */

/* Columns of J by differences of h: one-sided away from the nearer bound, or two-sided within the
 * bounds. A column without a residual is 0. */
static void differentiate(work *w, double h, bool is_central)
{
    ss_solve *s = w->solve;
    double x[SS_SOLVE_MAX];
    for (int32_t j = 0; j < s->n; ++j) {
        const bool is_up = s->x[j] + h <= s->upper[j], is_down = s->x[j] - h >= s->lower[j];
        const double *from = w->residual;
        double sign = is_up ? 1.0 : -1.0, width = h;
        memcpy(x, s->x, sizeof x);
        x[j] += sign * h;
        bool is_good = evaluate(w, x, false, w->other) < FAILED;
        double *column = w->jacobian + (ptrdiff_t)j * s->m;
        for (int32_t k = 0; k < s->m; ++k) {
            column[k] = is_good ? sign * (w->other[k] - from[k]) / width : 0.0;
        }
        if (!is_central || !is_up || !is_down) {
            continue;
        }
        x[j] = s->x[j] - h;
        if (evaluate(w, x, false, w->other) < FAILED) {
            for (int32_t k = 0; k < s->m; ++k) {
                const double other = (from[k] - w->other[k]) / width;
                column[k] = is_good ? 0.5 * (column[k] + other) : other;
            }
        }
    }
}

/* Eigenvalues and rows of eigenvectors of a symmetric matrix, by Jacobi's rotations. */
static void diagonalise(int32_t n, double a[SS_SOLVE_MAX][SS_SOLVE_MAX], double *out_value,
                        double out_vector[SS_SOLVE_MAX][SS_SOLVE_MAX])
{
    for (int32_t i = 0; i < n; ++i) {
        for (int32_t j = 0; j < n; ++j) {
            out_vector[i][j] = i == j ? 1.0 : 0.0;
        }
    }
    for (int sweep = 0; sweep < JACOBI_SWEEPS; ++sweep) {
        for (int32_t p = 0; p < n; ++p) {
            for (int32_t q = p + 1; q < n; ++q) {
                if (!(fabs(a[p][q]) > 0.0)) {
                    continue;
                }
                const double theta = 0.5 * atan2(2.0 * a[p][q], a[q][q] - a[p][p]);
                const double c = cos(theta), t = sin(theta);
                for (int32_t k = 0; k < n; ++k) {
                    ss_rotate_pair(&a[k][p], &a[k][q], c, t);
                }
                for (int32_t k = 0; k < n; ++k) {
                    ss_rotate_pair(&a[p][k], &a[q][k], c, t);
                    ss_rotate_pair(&out_vector[p][k], &out_vector[q][k], c, t);
                }
            }
        }
    }
    for (int32_t i = 0; i < n; ++i) {
        out_value[i] = fmax(a[i][i], 0.0);
    }
}

/* J^T J and J^T r; unknowns that are held by `is_held` have neither. */
static void normal_equations(const work *w, const bool *is_held,
                             double a[SS_SOLVE_MAX][SS_SOLVE_MAX], double *g)
{
    const ss_solve *s = w->solve;
    for (int32_t i = 0; i < s->n; ++i) {
        const double *ji = w->jacobian + (ptrdiff_t)i * s->m;
        g[i] = 0.0;
        for (int32_t k = 0; k < s->m && !is_held[i]; ++k) {
            g[i] += ji[k] * w->residual[k];
        }
        for (int32_t j = 0; j < s->n; ++j) {
            const double *jj = w->jacobian + (ptrdiff_t)j * s->m;
            a[i][j] = 0.0;
            for (int32_t k = 0; k < s->m && !is_held[i] && !is_held[j]; ++k) {
                a[i][j] += ji[k] * jj[k];
            }
        }
    }
}

/* One damped step from J and r; false when none makes |r| less. */
static bool step_down(work *w, double *inout_cost, double *inout_damping, double *out_length)
{
    ss_solve *s = w->solve;
    double a[SS_SOLVE_MAX][SS_SOLVE_MAX], vector[SS_SOLVE_MAX][SS_SOLVE_MAX];
    double g[SS_SOLVE_MAX], value[SS_SOLVE_MAX], x[SS_SOLVE_MAX], largest = 0.0;
    bool is_held[SS_SOLVE_MAX] = {false};
    normal_equations(w, is_held, a, g);
    for (int32_t i = 0; i < s->n; ++i) {
        is_held[i] =
            (s->x[i] <= s->lower[i] && g[i] > 0.0) || (s->x[i] >= s->upper[i] && g[i] < 0.0);
    }
    normal_equations(w, is_held, a, g);
    diagonalise(s->n, a, value, vector);
    for (int32_t k = 0; k < s->n; ++k) {
        largest = fmax(largest, value[k]);
    }
    for (int tries = 0; tries < DAMPING_TRIES && largest > 0.0; ++tries) {
        *out_length = 0.0;
        for (int32_t i = 0; i < s->n; ++i) {
            double step = 0.0;
            for (int32_t k = 0; k < s->n; ++k) {
                double along = 0.0;
                for (int32_t j = 0; j < s->n; ++j) {
                    along += vector[k][j] * g[j];
                }
                step -= vector[k][i] * along / (value[k] + *inout_damping * largest);
            }
            step = fmax(-GAUSS_REACH, fmin(GAUSS_REACH, step));
            x[i] = fmax(s->lower[i], fmin(s->upper[i], s->x[i] + step));
            *out_length = fmax(*out_length, fabs(x[i] - s->x[i]));
        }
        if (*out_length < GAUSS_END) {
            return false;
        }
        const double cost = evaluate(w, x, false, w->other);
        if (cost < *inout_cost) {
            memcpy(s->x, x, sizeof x);
            memcpy(w->residual, w->other, (size_t)s->m * sizeof *w->residual);
            *inout_cost = cost;
            *inout_damping = fmax(0.1 * *inout_damping, 1e-9);
            return true;
        }
        *inout_damping *= 10.0;
    }
    return false;
}

/* True when it has come to rest, false when the evaluations are used up. */
static bool descend(work *w, double *inout_cost)
{
    ss_solve *s = w->solve;
    double damping = 1e-4;
    for (int k = 0; k < GAUSS_STEPS; ++k) {
        const double before = *inout_cost;
        double length = 0.0;
        if (s->evaluations + s->n + DAMPING_TRIES > s->max_evaluations) {
            return false;
        }
        differentiate(w, GAUSS_DIFFERENCE, false);
        if (!step_down(w, inout_cost, &damping, &length) || length < GAUSS_END ||
            sqrt(before) - sqrt(*inout_cost) < MISFIT_END) {
            return true;
        }
    }
    return false;
}

/* ---- identifiability ---- */

static void judge_directions(work *w)
{
    ss_solve *s = w->solve;
    double a[SS_SOLVE_MAX][SS_SOLVE_MAX], g[SS_SOLVE_MAX], value[SS_SOLVE_MAX];
    const bool is_held[SS_SOLVE_MAX] = {false};
    normal_equations(w, is_held, a, g);
    diagonalise(s->n, a, value, s->direction);
    const double noise = fmax(ROOM * s->misfit, s->floor);
    memset(s->spread, 0, sizeof s->spread);
    for (int32_t k = 0; k < s->n; ++k) {
        s->slack[k] = noise / fmax(sqrt(value[k]), 1e-300);
        s->is_flat[k] = s->slack[k] > FLAT;
        for (int32_t i = 0; i < s->n; ++i) {
            s->spread[i] = hypot(s->spread[i], s->direction[k][i] * s->slack[k]);
        }
    }
}

/* A misfit up to this is as good as the best. */
static double as_good(const ss_solve *s)
{
    return hypot(s->misfit, fmax(ROOM * s->misfit, s->floor));
}

/* Back along the flat directions to the start, where the misfit stays. */
static void return_flat(work *w, double *inout_cost)
{
    ss_solve *s = w->solve;
    double x[SS_SOLVE_MAX];
    bool is_moved = false;
    memcpy(x, s->x, sizeof x);
    for (int32_t k = 0; k < s->n; ++k) {
        double along = 0.0;
        for (int32_t i = 0; i < s->n && s->is_flat[k]; ++i) {
            along += s->direction[k][i] * (s->start[i] - s->x[i]);
        }
        for (int32_t i = 0; i < s->n; ++i) {
            x[i] += along * s->direction[k][i];
        }
        is_moved |= fabs(along) > GAUSS_END;
    }
    for (int32_t i = 0; i < s->n; ++i) {
        x[i] = fmax(s->lower[i], fmin(s->upper[i], x[i]));
    }
    if (!is_moved) {
        return;
    }
    const double cost = evaluate(w, x, false, w->other);
    if (sqrt(cost) <= as_good(s)) {
        memcpy(s->x, x, sizeof x);
        memcpy(w->residual, w->other, (size_t)s->m * sizeof *w->residual);
        *inout_cost = cost;
        s->misfit = sqrt(cost);
    }
}

int32_t ss_solve_alone(const ss_solve *s, int32_t k)
{
    for (int32_t i = 0; i < s->n; ++i) {
        if (fabs(s->direction[k][i]) > ALONE) {
            return i;
        }
    }
    return -1;
}

/* How far unknown i alone may go either way, by factors of two. */
static void find_range(work *w, int32_t i)
{
    ss_solve *s = w->solve;
    const double bar = as_good(s);
    s->low[i] = s->high[i] = s->x[i];
    for (int sign = -1; sign <= 1; sign += 2) {
        double *end = sign < 0 ? &s->low[i] : &s->high[i];
        double x[SS_SOLVE_MAX];
        memcpy(x, s->x, sizeof x);
        for (int k = 0; k < PROBES; ++k) {
            x[i] = fmax(s->lower[i], fmin(s->upper[i], s->x[i] + sign * FLAT * (1 << k)));
            if (!(sqrt(evaluate(w, x, false, w->other)) <= bar)) {
                break;
            }
            *end = x[i];
            if (x[i] <= s->lower[i] || x[i] >= s->upper[i]) {
                break;
            }
        }
    }
}

bool ss_solve_run(ss_solve *s)
{
    work w = {.solve = s};
    w.residual = calloc((size_t)s->m, sizeof *w.residual);
    w.other = calloc((size_t)s->m, sizeof *w.other);
    w.jacobian = calloc((size_t)s->m * (size_t)s->n, sizeof *w.jacobian);
    bool is_good = w.residual && w.other && w.jacobian;
    memcpy(s->x, s->start, sizeof s->x);
    double cost = FAILED;
    if (is_good) {
        is_good = evaluate(&w, s->x, false, w.residual) < FAILED && search(&w) &&
                  (cost = evaluate(&w, s->x, false, w.residual)) < FAILED;
    }
    if (is_good) {
        s->has_settled = descend(&w, &cost);
        s->misfit = sqrt(cost);
        differentiate(&w, FINAL_DIFFERENCE, true);
        judge_directions(&w);
        return_flat(&w, &cost);
        for (int32_t k = 0; k < s->n; ++k) {
            const int32_t alone = s->is_flat[k] ? ss_solve_alone(s, k) : -1;
            if (alone >= 0) {
                find_range(&w, alone);
            }
            s->at_bound[k] = s->x[k] <= s->lower[k] + GAUSS_END   ? -1
                             : s->x[k] >= s->upper[k] - GAUSS_END ? 1
                                                                  : 0;
        }
    }
    SS_EACH(free, w.residual, w.other, w.jacobian);
    return is_good;
}
