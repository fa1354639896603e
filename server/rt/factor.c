/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/factor.h"

#include <amd.h>
#include <ldl.h>

#include "rt/each.h"
#include "rt/memory.h"

softsim_status ss_factor_init(ss_factor *factor, int n, int *column, int *row)
{
    const size_t count = (size_t)n;
    int **const integers[] = {&factor->order, &factor->inverse, &factor->parent,
                              &factor->count, &factor->flag,    &factor->pattern};
    *factor = (ss_factor){.n = n};
    factor->column = ss_memory_get(count + 1, sizeof *factor->column);
    factor->diagonal = ss_memory_get(count, sizeof *factor->diagonal);
    factor->scratch = ss_memory_get(count, sizeof *factor->scratch);
    bool is_good = factor->column && factor->diagonal && factor->scratch;
    for (size_t k = 0; k < sizeof integers / sizeof *integers; ++k) {
        *integers[k] = ss_memory_get(count, sizeof **integers[k]);
        is_good = is_good && *integers[k] != NULL;
    }
    if (!is_good || (n > 0 && amd_order(n, column, row, factor->order, NULL, NULL) < 0)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ldl_symbolic(n, column, row, factor->column, factor->parent, factor->count, factor->flag,
                 factor->order, factor->inverse);
    for (int k = 0; k < n; ++k) {
        factor->fill += factor->count[k];
        factor->work += (double)factor->count[k] * factor->count[k];
    }
    return SOFTSIM_OK;
}

softsim_status ss_factor_reserve(ss_factor *factor)
{
    const size_t fill = (size_t)factor->column[factor->n];
    factor->row = ss_memory_get(fill, sizeof *factor->row);
    factor->lower = ss_memory_get(fill, sizeof *factor->lower);
    return factor->row && factor->lower ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

bool ss_factor_fill(ss_factor *factor, int *column, int *row, double *value)
{
    return ldl_numeric(factor->n, column, row, value, factor->column, factor->parent, factor->count,
                       factor->row, factor->lower, factor->diagonal, factor->scratch,
                       factor->pattern, factor->flag, factor->order, factor->inverse) == factor->n;
}

void ss_factor_solve(ss_factor *factor, double *x)
{
    ldl_perm(factor->n, factor->scratch, x, factor->order);
    ldl_lsolve(factor->n, factor->scratch, factor->column, factor->row, factor->lower);
    ldl_dsolve(factor->n, factor->scratch, factor->diagonal);
    ldl_ltsolve(factor->n, factor->scratch, factor->column, factor->row, factor->lower);
    ldl_permt(factor->n, x, factor->scratch, factor->order);
}

void ss_factor_trim(ss_factor *factor)
{
    SS_EACH(ss_memory_free, factor->order, factor->inverse, factor->parent, factor->count,
            factor->flag, factor->pattern, factor->scratch);
    factor->order = factor->inverse = factor->parent = factor->count = NULL;
    factor->flag = factor->pattern = NULL;
    factor->scratch = NULL;
}

void ss_factor_fini(ss_factor *factor)
{
    ss_factor_trim(factor);
    SS_EACH(ss_memory_free, factor->column, factor->row, factor->lower, factor->diagonal);
    *factor = (ss_factor){0};
}
