/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * With B = M^-1/2 K M^-1/2 and unit vectors z, the best of three directions each time: z, the
 * residual w = B z - (z.Bz) z, and p, the part of the last step that was new (LOBPCG, Knyazev 2001,
 * without a preconditioner). Its error falls as that of Lanczos' method does, with the square root
 * of the gap to the next eigenvalue, which on a large body is small: a chain of 400 nodes takes 37
 * products (test_fem_stability), the power iteration some 120. One product a step: those of z and p
 * are combined as the vectors are. Rejected: Lanczos' method itself, which keeps every vector.
 */
#include "models/common/fastest_mode.h"

#include <math.h>
#include <string.h>

#include "rt/arena.h"

typedef struct search {
    ptrdiff_t count;
    ss_real *root;         /* of the mobility */
    ss_real *vector[3][2]; /* z, w, p, each with its product by B */
    ss_real *motion;       /* M^-1/2 of what is multiplied */
    ss_stiffness_product *product;
    void *owner;
} search;

static double dot(const search *s, const ss_real *a, const ss_real *b)
{
    double sum = 0.0;
    for (ptrdiff_t k = 0; k < s->count; ++k) {
        sum += (double)a[k] * (double)b[k];
    }
    return sum;
}

/* a := x a + y b */
static void combine(const search *s, double x, ss_real *a, double y, const ss_real *b)
{
    for (ptrdiff_t k = 0; k < s->count; ++k) {
        a[k] = (ss_real)(x * (double)a[k] + y * (double)b[k]);
    }
}

/* The same of a direction and its product. */
static void combine_pair(const search *s, double x, int a, double y, int b)
{
    combine(s, x, s->vector[a][0], y, s->vector[b][0]);
    combine(s, x, s->vector[a][1], y, s->vector[b][1]);
}

static void multiply(const search *s, const ss_real *x, ss_real *out)
{
    for (ptrdiff_t k = 0; k < s->count; ++k) {
        s->motion[k] = s->root[k] * x[k];
    }
    memset(out, 0, (size_t)s->count * sizeof *out);
    s->product(s->owner, s->motion, out);
    for (ptrdiff_t k = 0; k < s->count; ++k) {
        out[k] *= s->root[k];
    }
}

/* Takes out of direction a its part along b, a unit vector. */
static void part_from(const search *s, int a, int b, bool has_product)
{
    const double share = -dot(s, s->vector[a][0], s->vector[b][0]);
    combine(s, 1.0, s->vector[a][0], share, s->vector[b][0]);
    if (has_product) {
        combine(s, 1.0, s->vector[a][1], share, s->vector[b][1]);
    }
}

/* The eigenvector of the largest eigenvalue of T, symmetric, by Jacobi's rotations. */
static void largest_of_three(double t[3][3], int n, double out[3])
{
    double q[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    for (int turn = 0; turn < 30; ++turn) {
        const int i = turn % 3 == 2 ? 1 : 0, j = turn % 3 == 0 ? 1 : 2;
        if (t[i][j] == 0.0 || j >= n) {
            continue;
        }
        const double angle = 0.5 * atan2(2.0 * t[i][j], t[i][i] - t[j][j]);
        const double c = cos(angle), d = sin(angle);
        for (int k = 0; k < 3; ++k) { /* T := T R, Q := Q R */
            const double ti = t[k][i], qi = q[k][i];
            t[k][i] = c * ti + d * t[k][j];
            t[k][j] = c * t[k][j] - d * ti;
            q[k][i] = c * qi + d * q[k][j];
            q[k][j] = c * q[k][j] - d * qi;
        }
        for (int k = 0; k < 3; ++k) { /* T := R' T */
            const double ti = t[i][k];
            t[i][k] = c * ti + d * t[j][k];
            t[j][k] = c * t[j][k] - d * ti;
        }
    }
    int top = 0;
    for (int k = 1; k < n; ++k) {
        top = t[k][k] > t[top][top] ? k : top;
    }
    for (int k = 0; k < 3; ++k) {
        out[k] = q[k][top];
    }
}

/* z becomes the best of the first n directions, p what is new in it; p stays a unit vector that
 * has nothing of z. False when nothing new is left. */
static bool take_best(const search *s, int n)
{
    double t[3][3] = {{0.0}}, c[3];
    for (int i = 0; i < n; ++i) {
        for (int j = i; j < n; ++j) {
            t[i][j] = t[j][i] = dot(s, s->vector[i][0], s->vector[j][1]);
        }
    }
    largest_of_three(t, n, c);
    combine_pair(s, n == 3 ? c[2] : 0.0, 2, c[1], 1); /* what is new */
    combine_pair(s, c[0], 0, 1.0, 2);
    const double length = sqrt(dot(s, s->vector[0][0], s->vector[0][0]));
    if (!(length > 0.0) || !isfinite(length)) {
        return false;
    }
    combine_pair(s, 1.0 / length, 0, 0.0, 1);
    part_from(s, 2, 0, true);
    const double left = sqrt(dot(s, s->vector[2][0], s->vector[2][0]));
    if (!(left > 1e-5)) {
        return false;
    }
    combine_pair(s, 1.0 / left, 2, 0.0, 1);
    return true;
}

static void improve(const search *s, double residual, int32_t most)
{
    ss_real *z = s->vector[0][0], *bz = s->vector[0][1], *w = s->vector[1][0];
    multiply(s, z, bz);
    for (int32_t k = 1; k < most; ++k) {
        const double quotient = dot(s, z, bz);
        memcpy(w, bz, (size_t)s->count * sizeof *w);
        combine(s, 1.0, w, -quotient, z);
        const double off = sqrt(dot(s, w, w));
        if (!(off > residual * quotient)) {
            return;
        }
        part_from(s, 1, 0, false);
        if (k > 1) {
            part_from(s, 1, 2, false);
        }
        const double length = sqrt(dot(s, w, w));
        if (!(length > 0.0)) {
            return;
        }
        combine(s, 1.0 / length, w, 0.0, z);
        multiply(s, w, s->vector[1][1]);
        if (!take_best(s, k > 1 ? 3 : 2)) {
            return;
        }
    }
}

softsim_status ss_find_fastest_mode(int32_t node_count, const ss_real *mobility,
                                    ss_stiffness_product *product, void *owner, double residual,
                                    int32_t most, ss_real *mode)
{
    search s = {.count = 4 * (ptrdiff_t)node_count, .product = product, .owner = owner};
    const size_t n = (size_t)s.count;
    ss_arena scratch = {0};
    s.root = ss_arena_get(&scratch, n, sizeof *s.root);
    s.motion = ss_arena_get(&scratch, n, sizeof *s.motion);
    for (int k = 0; k < 6; ++k) {
        s.vector[k / 2][k % 2] = ss_arena_get(&scratch, n, sizeof(ss_real));
    }
    const softsim_status status = ss_arena_status(&scratch);
    double square = 0.0;
    for (ptrdiff_t k = 0; status == SOFTSIM_OK && k < s.count; ++k) {
        const double root = sqrt((double)mobility[k]);
        s.root[k] = (ss_real)root;
        s.vector[0][0][k] = root > 0.0 ? (ss_real)((double)mode[k] / root) : 0;
        square += (double)s.vector[0][0][k] * (double)s.vector[0][0][k];
    }
    if (square > 0.0 && isfinite(square)) { /* the caller's: x.Mx = 1, but for rounding */
        improve(&s, residual, most);
        for (ptrdiff_t k = 0; k < s.count; ++k) {
            mode[k] = s.root[k] * s.vector[0][0][k];
        }
    }
    ss_arena_free(&scratch);
    return status;
}
