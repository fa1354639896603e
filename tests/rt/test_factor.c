/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* rt/factor: what it solves, put back into the matrix, is what was asked for. */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "rt/factor.h"
#include "rt/random.h"

enum { SIDE = 9, N = SIDE * SIDE, ENTRIES = 5 * N };

typedef struct matrix {
    int column[N + 1], row[ENTRIES];
    double value[ENTRIES];
} matrix;

/* The five-point stencil on a square, its links from 1 to 2, its diagonal larger than they by
 * `extra`. */
static void build(matrix *m, double extra, uint64_t seed)
{
    static double dense[N][N];
    memset(dense, 0, sizeof dense);
    for (int i = 0; i < N; ++i) {
        dense[i][i] += extra;
        const int next[2] = {i % SIDE < SIDE - 1 ? i + 1 : -1, i + SIDE < N ? i + SIDE : -1};
        for (int k = 0; k < 2; ++k) {
            const double link = 1.0 + ss_random_unit(&seed);
            if (next[k] >= 0) {
                dense[i][i] += link;
                dense[next[k]][next[k]] += link;
                dense[i][next[k]] = dense[next[k]][i] = -link;
            }
        }
    }
    int count = 0;
    for (int k = 0; k < N; ++k) {
        m->column[k] = count;
        for (int i = 0; i < N; ++i) {
            if (dense[i][k] != 0.0) {
                m->row[count] = i;
                m->value[count++] = dense[i][k];
            }
        }
    }
    m->column[N] = count;
}

static void assert_solves(ss_factor *factor, const matrix *m, uint64_t seed)
{
    double b[N], x[N];
    for (int i = 0; i < N; ++i) {
        x[i] = b[i] = ss_random_signed(&seed);
    }
    ss_factor_solve(factor, x);
    for (int k = 0; k < N; ++k) {
        for (int e = m->column[k]; e < m->column[k + 1]; ++e) {
            b[m->row[e]] -= m->value[e] * x[k];
        }
    }
    for (int i = 0; i < N; ++i) {
        assert_true(fabs(b[i]) < 1e-12);
    }
}

TEST(a_factor_solves_and_is_filled_again)
{
    static matrix m;
    ss_factor factor;
    build(&m, 0.5, 1);
    assert_int_equal(ss_factor_init(&factor, N, m.column, m.row), SOFTSIM_OK);
    assert_true(factor.fill >= N && factor.fill < N * (N - 1) / 2.0);
    assert_true(factor.work >= factor.fill);
    assert_int_equal(ss_factor_reserve(&factor), SOFTSIM_OK);
    assert_int_equal(factor.column[N], (int)factor.fill);
    for (uint64_t seed = 1; seed < 4; ++seed) {
        build(&m, 0.5, seed);
        assert_true(ss_factor_fill(&factor, m.column, m.row, m.value));
        assert_solves(&factor, &m, seed);
    }
    for (int k = 0; k < N; ++k) {
        assert_int_equal(factor.inverse[factor.order[k]], k);
        assert_true(factor.diagonal[k] > 0.0);
    }
    ss_factor_trim(&factor);
    assert_non_null(factor.lower);
    ss_factor_fini(&factor);
    ss_factor_fini(&factor);
}

TEST(a_pivot_of_zero_is_told)
{
    int column[] = {0, 1, 2}, row[] = {0, 1};
    double value[] = {2.0, 0.0};
    ss_factor factor;
    assert_int_equal(ss_factor_init(&factor, 2, column, row), SOFTSIM_OK);
    assert_int_equal(ss_factor_reserve(&factor), SOFTSIM_OK);
    assert_false(ss_factor_fill(&factor, column, row, value));
    ss_factor_fini(&factor);
    assert_int_equal(ss_factor_init(&factor, 0, column, row), SOFTSIM_OK); /* nothing to solve */
    assert_true(factor.fill == 0.0);
    ss_factor_fini(&factor);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
