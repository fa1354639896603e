/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The least value of a function of a few variables within bounds, without derivatives: Nelder and
 * Mead 1965 (reflection 1, expansion 2, contraction and shrinkage 1/2), points beyond a bound moved
 * onto it. For a handful of variables and functions that cost a simulation each. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

enum { SS_SIMPLEX_MAX = 4 };

typedef struct ss_simplex {
    int32_t count; /* of variables, 1..SS_SIMPLEX_MAX */
    double low[SS_SIMPLEX_MAX], high[SS_SIMPLEX_MAX];
    double step;      /* first edges, in every variable */
    double tolerance; /* ends when the values at the corners differ by less, as a fraction */
    int32_t most;     /* values asked for */
    void *context;
    double (*value)(void *context, const double *x); /* INFINITY: not allowed there */
} ss_simplex;

/* From x to the best point found; returns the value there. */
double ss_simplex_minimise(const ss_simplex *simplex, double *x);
