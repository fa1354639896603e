/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/block_matrix.h"
/*
 * Conjugate gradients with a symmetric Gauss-Seidel sweep of 3x3 blocks before each product,
 *
 *   z = (D + U)^-1 D (D + L)^-1 r      A = L + D + U,
 *
 * on the principal part of A that belongs to free axes: held axes are 0 in every vector, and their
 * rows of D those of the identity. The sweep cannot break down while the diagonal blocks are
 * positive, needs no memory but their inverses, and more than halves the products that the diagonal
 * alone needs. Rejected: a factor (AMD and L D L'), whose fill in three dimensions grows as
 * n^(4/3) and its work as n^2; conjugate gradients also serve where the tangent of a large
 * deformation is not positive, with the descent direction found so far.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

typedef double vector[3];

/* ---- pattern ---- */

/* Neighbours of every node with repetitions, then sorted and made unique in place. */
static softsim_status find_pattern(ss_block_matrix *matrix, int32_t tetrahedron_count,
                                   const int32_t (*tetrahedron)[4])
{
    const int32_t n = matrix->node_count;
    int64_t *start = ss_memory_get((size_t)n + 2, sizeof *start);
    int32_t *list = ss_memory_get((size_t)n + 12 * (size_t)tetrahedron_count, sizeof *list);
    if (!start || !list) {
        ss_memory_free(start);
        ss_memory_free(list);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t t = 0; t < tetrahedron_count; ++t) {
        for (int k = 0; k < 4; ++k) {
            start[tetrahedron[t][k] + 2] += 3;
        }
    }
    for (int32_t i = 0; i < n; ++i) {
        start[i + 2] += start[i + 1] + 1;
        list[start[i + 1]++] = i;
    }
    for (int32_t t = 0; t < tetrahedron_count; ++t) {
        for (int k = 0; k < 4; ++k) {
            for (int m = 1; m < 4; ++m) {
                list[start[tetrahedron[t][k] + 1]++] = tetrahedron[t][(k + m) % 4];
            }
        }
    }
    int32_t count = 0;
    for (int32_t i = 0; i < n; ++i) {
        matrix->first[i] = count;
        qsort(list + start[i], (size_t)(start[i + 1] - start[i]), sizeof *list, ss_compare_ints);
        for (int64_t k = start[i]; k < start[i + 1]; ++k) {
            if (k == start[i] || list[k] != list[k - 1]) {
                matrix->diagonal[i] = list[k] == i ? count : matrix->diagonal[i];
                matrix->column[count++] = list[k];
            }
        }
    }
    matrix->first[n] = count;
    ss_memory_free(start);
    ss_memory_free(list);
    return SOFTSIM_OK;
}

softsim_status ss_block_matrix_create(int32_t node_count, int32_t tetrahedron_count,
                                      const int32_t (*tetrahedron)[4], ss_block_matrix **out_matrix)
{
    const size_t n = (size_t)node_count;
    ss_block_matrix *matrix = ss_memory_get(1, sizeof *matrix);
    *out_matrix = NULL;
    if (!matrix) {
        return SOFTSIM_ERROR_MEMORY;
    }
    matrix->node_count = node_count;
    matrix->first = ss_memory_get(n + 1, sizeof *matrix->first);
    matrix->column = ss_memory_get(n + 12 * (size_t)tetrahedron_count, sizeof *matrix->column);
    matrix->diagonal = ss_memory_get(n, sizeof *matrix->diagonal);
    matrix->inverse = ss_memory_get(n, sizeof *matrix->inverse);
    matrix->work = ss_memory_get(5 * n, sizeof *matrix->work);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (matrix->first && matrix->column && matrix->diagonal && matrix->inverse && matrix->work) {
        status = find_pattern(matrix, tetrahedron_count, tetrahedron);
    }
    if (status == SOFTSIM_OK) {
        matrix->block = ss_memory_get((size_t)matrix->first[n], sizeof *matrix->block);
        status = matrix->block ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    }
    if (status != SOFTSIM_OK) {
        ss_block_matrix_destroy(&matrix);
    }
    *out_matrix = matrix;
    return status;
}

void ss_block_matrix_destroy(ss_block_matrix **matrix)
{
    ss_block_matrix *gone = *matrix;
    if (gone) {
        SS_EACH(ss_memory_free, gone->first, gone->column, gone->diagonal, gone->block,
                gone->inverse, gone->work, gone);
        *matrix = NULL;
    }
}

void ss_block_matrix_clear(ss_block_matrix *matrix)
{
    memset(matrix->block, 0, (size_t)matrix->first[matrix->node_count] * sizeof *matrix->block);
}

int32_t ss_block_matrix_find(const ss_block_matrix *matrix, int32_t row, int32_t column)
{
    int32_t low = matrix->first[row], high = matrix->first[row + 1] - 1;
    while (low <= high) {
        const int32_t middle = low + (high - low) / 2;
        if (matrix->column[middle] == column) {
            return middle;
        }
        if (matrix->column[middle] < column) {
            low = middle + 1;
        } else {
            high = middle - 1;
        }
    }
    return -1;
}

/* ---- products ---- */

static void add_block(const double block[9], const double x[3], double s, double y[3])
{
    for (int k = 0; k < 3; ++k) {
        y[k] += s * (block[3 * k] * x[0] + block[3 * k + 1] * x[1] + block[3 * k + 2] * x[2]);
    }
}

/* y += s times the entries [first, end) of a row. */
static void add_entries(const ss_block_matrix *matrix, int32_t first, int32_t end, const vector *x,
                        double s, double y[3])
{
    for (int32_t e = first; e < end; ++e) {
        add_block(matrix->block[e], x[matrix->column[e]], s, y);
    }
}

void ss_block_matrix_multiply(const ss_block_matrix *matrix, const double (*x)[3], double (*y)[3])
{
    for (int32_t i = 0; i < matrix->node_count; ++i) {
        double sum[3] = {0.0, 0.0, 0.0};
        add_entries(matrix, matrix->first[i], matrix->first[i + 1], x, 1.0, sum);
        ss_copy3(y[i], sum);
    }
}

/* ---- solution ---- */

static bool is_held(uint8_t bits, int axis)
{
    return ((bits >> axis) & 1) != 0;
}

static void hold(uint8_t bits, double x[3])
{
    for (int k = 0; k < 3; ++k) {
        x[k] = is_held(bits, k) ? 0.0 : x[k];
    }
}

void ss_block_matrix_prepare(ss_block_matrix *matrix, const uint8_t *held)
{
    for (int32_t i = 0; i < matrix->node_count; ++i) {
        double a[9];
        memcpy(a, matrix->block[matrix->diagonal[i]], sizeof a);
        for (int k = 0; k < 3; ++k) {
            for (int m = 0; m < 3; ++m) {
                if (is_held(held[i], k) || is_held(held[i], m)) {
                    a[3 * k + m] = k == m ? 1.0 : 0.0;
                }
            }
        }
        double *out = matrix->inverse[i];
        for (int k = 0; k < 3; ++k) { /* rows of the adjugate are cross products of columns */
            const int p = (k + 1) % 3, q = (k + 2) % 3;
            for (int m = 0; m < 3; ++m) {
                const int r = (m + 1) % 3, s = (m + 2) % 3;
                out[3 * k + m] = a[3 * r + p] * a[3 * s + q] - a[3 * r + q] * a[3 * s + p];
            }
        }
        const double determinant = a[0] * out[0] + a[1] * out[3] + a[2] * out[6];
        for (int k = 0; k < 9; ++k) {
            /* a node without elements has no stiffness and stays where it is */
            out[k] = determinant != 0.0 ? out[k] / determinant : 0.0;
        }
    }
}

/* z = (D + U)^-1 D (D + L)^-1 r */
static void sweep(const ss_block_matrix *matrix, const uint8_t *held, const vector *r, vector *z)
{
    for (int32_t i = 0; i < matrix->node_count; ++i) {
        double sum[3], out[3] = {0.0, 0.0, 0.0};
        ss_copy3(sum, r[i]);
        add_entries(matrix, matrix->first[i], matrix->diagonal[i], (const vector *)z, -1.0, sum);
        hold(held[i], sum);
        add_block(matrix->inverse[i], sum, 1.0, out);
        ss_copy3(z[i], out);
    }
    for (int32_t i = matrix->node_count - 1; i >= 0; --i) {
        double sum[3] = {0.0, 0.0, 0.0};
        add_entries(matrix, matrix->diagonal[i] + 1, matrix->first[i + 1], (const vector *)z, 1.0,
                    sum);
        hold(held[i], sum);
        add_block(matrix->inverse[i], sum, -1.0, z[i]);
    }
}

static double dot(int32_t count, const vector *x, const vector *y)
{
    double sum = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        sum += ss_dot3(x[i], y[i]);
    }
    return sum;
}

double ss_block_matrix_solve(ss_block_matrix *matrix, const uint8_t *held, const double (*b)[3],
                             double tolerance, int32_t max_iterations, double (*x)[3],
                             bool *out_is_positive)
{
    const int32_t n = matrix->node_count;
    vector *r = matrix->work, *z = r + n, *p = z + n, *q = p + n;
    for (int32_t i = 0; i < n; ++i) {
        ss_copy3(r[i], b[i]);
        hold(held[i], r[i]);
        ss_set3(x[i], 0.0, 0.0, 0.0);
    }
    const double whole = sqrt(dot(n, (const vector *)r, (const vector *)r));
    double left = whole, rho = 0.0;
    bool is_positive = true;
    for (int32_t k = 0; k < max_iterations && left > tolerance * whole; ++k) {
        sweep(matrix, held, (const vector *)r, z);
        const double next = dot(n, (const vector *)r, (const vector *)z);
        for (int32_t i = 0; i < n; ++i) {
            ss_madd3(p[i], z[i], k > 0 ? next / rho : 0.0, p[i]);
        }
        rho = next;
        ss_block_matrix_multiply(matrix, (const vector *)p, q);
        for (int32_t i = 0; i < n; ++i) {
            hold(held[i], q[i]);
        }
        const double curvature = dot(n, (const vector *)p, (const vector *)q);
        if (!(curvature > 0.0)) {
            is_positive = false;
            for (int32_t i = 0; i < n && k == 0; ++i) {
                ss_copy3(x[i], p[i]);
            }
            break;
        }
        const double step = rho / curvature;
        for (int32_t i = 0; i < n; ++i) {
            ss_madd3(x[i], x[i], step, p[i]);
            ss_madd3(r[i], r[i], -step, q[i]);
        }
        left = sqrt(dot(n, (const vector *)r, (const vector *)r));
    }
    if (out_is_positive) {
        *out_is_positive = is_positive;
    }
    return whole > 0.0 ? left / whole : 0.0;
}
