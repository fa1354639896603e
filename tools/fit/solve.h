/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Least squares without derivatives, and what the data say about the answer.
 *
 * In: residuals r(x) of a slow, slightly rough function of a few logarithms of parameters. Out: the
 * minimum of |r|^2 within bounds, the curvature there, and the directions in which |r| does not
 * tell. Knows nothing of scenes. solve.c has the method. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

enum { SS_SOLVE_MAX = 8 }; /* unknowns */

/* Writes `m` residuals at x; `is_rough` asks for the compressed ones (solve.c). False where there
 * are none. */
typedef bool (*ss_solve_residual)(void *context, const double *x, bool is_rough,
                                  double *out_residual);

typedef struct ss_solve {
    int32_t n, m;
    ss_solve_residual residual;
    void *context;
    double start[SS_SOLVE_MAX], lower[SS_SOLVE_MAX], upper[SS_SOLVE_MAX];
    double floor; /* of |r|: no data are better than this */
    int32_t max_evaluations;

    double x[SS_SOLVE_MAX]; /* the answer */
    double misfit;          /* |r| there */
    int32_t evaluations;
    bool has_settled; /* else the evaluations were used up */
    /* Eigenvectors v of J^T J, and how far along each (in logarithms) the answer may move until the
     * misfit is 2 % larger, or the floor is reached: max(misfit / 5, floor) / |J v|. */
    double direction[SS_SOLVE_MAX][SS_SOLVE_MAX];
    double slack[SS_SOLVE_MAX];
    bool is_flat[SS_SOLVE_MAX];                   /* direction k: a factor of two does not show */
    double spread[SS_SOLVE_MAX];                  /* of each unknown, from all directions */
    double low[SS_SOLVE_MAX], high[SS_SOLVE_MAX]; /* of an unknown that is a flat direction by
                                                     itself: as far as the misfit stays */
    int8_t at_bound[SS_SOLVE_MAX];                /* -1 lower, 1 upper */
} ss_solve;

/* False when the start has no residuals, or memory is out. */
bool ss_solve_run(ss_solve *solve);
/* Is direction k one unknown alone? Its index, else -1. */
int32_t ss_solve_alone(const ss_solve *solve, int32_t k);
