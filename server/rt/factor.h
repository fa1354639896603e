/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * L D L' of a symmetric sparse matrix, in the order of approximate minimum degree (AMD and LDL of
 * SuiteSparse). In: its pattern and numbers by columns, both halves. Out: the factor, which solves
 * right-hand sides. The pattern is ordered once and may be filled with other numbers again and
 * again; both are only read, though LDL does not say so. Memory belongs to the factor. Thread:
 * set-up only, one at a time.
 */
#include <stdbool.h>

#include "softsim/types.h"

typedef struct ss_factor {
    int n;
    int *order, *inverse; /* order[k] is eliminated k-th, and inverse[order[k]] is k */
    double fill, work;    /* entries of L, and multiplications that it takes */
    int *column, *row;    /* of L without its diagonal, in the order of elimination */
    double *lower, *diagonal;
    /* for filling alone */
    int *parent, *count, *flag, *pattern;
    double *scratch;
} ss_factor;

/* Orders the pattern: row[column[k]] to row[column[k + 1] - 1] are the rows of column k. `fill` and
 * `work` are known then. ss_factor_fini in any case. */
softsim_status ss_factor_init(ss_factor *factor, int n, int *column, int *row);
/* Memory for the entries of L, once; not where `fill` is above INT32_MAX. */
softsim_status ss_factor_reserve(ss_factor *factor);
/* The factor of these numbers, which stand as the rows do; false: a pivot is 0. */
bool ss_factor_fill(ss_factor *factor, int *column, int *row, double *value);
/* x := A^-1 x. */
void ss_factor_solve(ss_factor *factor, double *x);
/* Frees what only ss_factor_fill and ss_factor_solve need, for who solves with L by himself. */
void ss_factor_trim(ss_factor *factor);
void ss_factor_fini(ss_factor *factor);
