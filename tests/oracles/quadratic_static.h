/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Statics of straight ten-node tetrahedra by Newton's method, in double: an independent solution
 * for `fem-quadratic`. It shares no code with the model: its own sides, shape functions, stress and
 * assembly; stiffness by differences of an element's forces; conjugate gradients.
 *
 *   W = sum_q V_q (mu/2 (J^(-2/3) I1 - 3) + kappa mu/2 (J - 1)^2)
 *       + (K - kappa mu) / (2 V) (sum_q V_q (J_q - 1))^2          over four Gauss points
 *
 * cmocka comes first. Memory: malloc, freed by oracle_fini.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ORACLE_DOFS = 30 };

typedef struct oracle {
    int32_t corners, nodes, elements;
    double (*position)[3];
    int32_t (*node)[10]; /* corners, then the sides 01 02 03 12 13 23 */
    int32_t (*end)[2];   /* of side node `corners + k` */
    bool *is_on_surface; /* of side k */
    double (*gradient)[4][10][3], (*volume)[4];
    double mu, own, shared; /* Pa: kappa mu, and K less it */
    bool *held;             /* by freedom */
    double *u, *force;      /* force: dW/du */
    double (*stiffness)[ORACLE_DOFS][ORACLE_DOFS];
} oracle;

static const int oracle_side[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

static inline void oracle_fini(oracle *o)
{
    free(o->position);
    free(o->node);
    free(o->end);
    free(o->is_on_surface);
    free(o->gradient);
    free(o->volume);
    free(o->held);
    free(o->u);
    free(o->force);
    free(o->stiffness);
}

/* ---- mesh ---- */

typedef struct oracle_use {
    int32_t low, high, element, place;
} oracle_use;

static inline int oracle_order(const void *a, const void *b)
{
    const oracle_use *x = a, *y = b;
    return x->low != y->low ? (x->low < y->low ? -1 : 1)
                            : (x->high > y->high) - (x->high < y->high);
}

/* Sides by sorting; their order is another than the model's. */
static inline void oracle_raise(oracle *o, int32_t corners, const double (*position)[3],
                                int32_t elements, const int32_t (*tetrahedron)[4])
{
    const size_t uses = 6 * (size_t)elements;
    oracle_use *use = malloc(uses * sizeof *use);
    o->node = malloc((size_t)elements * sizeof *o->node);
    for (int32_t e = 0; e < elements; ++e) {
        memcpy(o->node[e], tetrahedron[e], sizeof tetrahedron[e]);
        for (int s = 0; s < 6; ++s) {
            const int32_t a = tetrahedron[e][oracle_side[s][0]];
            const int32_t b = tetrahedron[e][oracle_side[s][1]];
            use[6 * e + s] = (oracle_use){a < b ? a : b, a < b ? b : a, e, s};
        }
    }
    qsort(use, uses, sizeof *use, oracle_order);
    o->end = malloc(uses * sizeof *o->end);
    int32_t sides = 0;
    for (size_t k = 0; k < uses; ++k) {
        if (k == 0 || oracle_order(&use[k - 1], &use[k]) != 0) {
            o->end[sides][0] = use[k].low;
            o->end[sides++][1] = use[k].high;
        }
        o->node[use[k].element][4 + use[k].place] = corners + sides - 1;
    }
    free(use);
    o->corners = corners;
    o->nodes = corners + sides;
    o->elements = elements;
    o->position = malloc((size_t)o->nodes * sizeof *o->position);
    memcpy(o->position, position, (size_t)corners * sizeof *position);
    for (int32_t k = 0; k < sides; ++k) {
        for (int i = 0; i < 3; ++i) {
            o->position[corners + k][i] =
                0.5 * (position[o->end[k][0]][i] + position[o->end[k][1]][i]);
        }
    }
}

static inline void oracle_mark_surface(oracle *o, int32_t triangles, const int32_t (*triangle)[3])
{
    o->is_on_surface = calloc((size_t)(o->nodes - o->corners), sizeof(bool));
    for (int32_t t = 0; t < 3 * triangles; ++t) {
        const int32_t a = triangle[t / 3][t % 3], b = triangle[t / 3][(t + 1) % 3];
        const int32_t want[2] = {a < b ? a : b, a < b ? b : a};
        int32_t low = 0, high = o->nodes - o->corners - 1;
        while (low < high) {
            const int32_t middle = (low + high) / 2;
            const int32_t *at = o->end[middle];
            if (at[0] < want[0] || (at[0] == want[0] && at[1] < want[1])) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        o->is_on_surface[low] = true;
    }
}

static inline double oracle_invert(const double a[3][3], double out[3][3])
{
    double det = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[j][i] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
    }
    for (int i = 0; i < 3; ++i) {
        det += a[0][i] * out[i][0];
    }
    for (int k = 0; k < 9; ++k) {
        out[k / 3][k % 3] /= det;
    }
    return det;
}

static inline void oracle_measure(oracle *o)
{
    const double near = (5.0 + 3.0 * sqrt(5.0)) / 20.0, far = (5.0 - sqrt(5.0)) / 20.0;
    o->gradient = malloc((size_t)o->elements * sizeof *o->gradient);
    o->volume = malloc((size_t)o->elements * sizeof *o->volume);
    for (int32_t e = 0; e < o->elements; ++e) {
        for (int q = 0; q < 4; ++q) {
            double l[4], d[10][3], map[3][3] = {{0.0}}, inverse[3][3];
            for (int k = 0; k < 4; ++k) {
                l[k] = k == q ? near : far;
            }
            for (int s = 0; s < 3; ++s) { /* by l_1, l_2, l_3, with l_0 = 1 - their sum */
                for (int k = 0; k < 4; ++k) {
                    d[k][s] = (4.0 * l[k] - 1.0) * (k == 0 ? -1.0 : k == s + 1 ? 1.0 : 0.0);
                }
                for (int m = 0; m < 6; ++m) {
                    const int a = oracle_side[m][0], b = oracle_side[m][1];
                    d[4 + m][s] =
                        4.0 * (l[a] * (b == s + 1 ? 1.0 : 0.0) + l[b] * (a == 0       ? -1.0
                                                                         : a == s + 1 ? 1.0
                                                                                      : 0.0));
                }
            }
            for (int n = 0; n < 10; ++n) {
                for (int k = 0; k < 9; ++k) {
                    map[k / 3][k % 3] += o->position[o->node[e][n]][k / 3] * d[n][k % 3];
                }
            }
            o->volume[e][q] = oracle_invert((const double(*)[3])map, inverse) / 24.0;
            for (int n = 0; n < 10; ++n) {
                for (int j = 0; j < 3; ++j) {
                    o->gradient[e][q][n][j] =
                        d[n][0] * inverse[0][j] + d[n][1] * inverse[1][j] + d[n][2] * inverse[2][j];
                }
            }
        }
    }
}

static inline void oracle_init(oracle *o, int32_t corners, const double (*position)[3],
                               int32_t elements, const int32_t (*tetrahedron)[4], int32_t triangles,
                               const int32_t (*triangle)[3])
{
    memset(o, 0, sizeof *o);
    oracle_raise(o, corners, position, elements, tetrahedron);
    oracle_mark_surface(o, triangles, triangle);
    oracle_measure(o);
    const size_t freedoms = 3 * (size_t)o->nodes;
    o->held = calloc(freedoms, sizeof *o->held);
    o->u = calloc(freedoms, sizeof *o->u);
    o->force = calloc(freedoms, sizeof *o->force);
    o->stiffness = malloc((size_t)elements * sizeof *o->stiffness);
}

/* Holds sides of the surface between held corners, at the mean of their displacements. */
static inline void oracle_hold_sides(oracle *o)
{
    for (int32_t k = 0; k < o->nodes - o->corners; ++k) {
        const int32_t a = 3 * o->end[k][0], b = 3 * o->end[k][1], m = 3 * (o->corners + k);
        for (int i = 0; i < 3 && o->is_on_surface[k]; ++i) {
            if (o->held[a + i] && o->held[b + i]) {
                o->held[m + i] = true;
                o->u[m + i] = 0.5 * (o->u[a + i] + o->u[b + i]);
            }
        }
    }
}

/* ---- an element ---- */

/* dW/du at `u` of its ten nodes; false where a point is inside out. */
static inline bool oracle_element(const oracle *o, int32_t e, const double u[30], double out[30])
{
    double mean = 0.0, volume = 0.0, cofactor[4][3][3], stress[4][3][3];
    for (int q = 0; q < 4; ++q) {
        double f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, inverse[3][3], first = 0.0;
        for (int n = 0; n < 10; ++n) {
            for (int k = 0; k < 9; ++k) {
                f[k / 3][k % 3] += u[3 * n + k / 3] * o->gradient[e][q][n][k % 3];
            }
        }
        const double j = oracle_invert((const double(*)[3])f, inverse);
        if (!(j > 0.0)) {
            return false;
        }
        for (int k = 0; k < 9; ++k) {
            first += f[k / 3][k % 3] * f[k / 3][k % 3];
            cofactor[q][k / 3][k % 3] = j * inverse[k % 3][k / 3];
        }
        const double g = o->mu * pow(j, -2.0 / 3.0);
        for (int k = 0; k < 9; ++k) {
            stress[q][k / 3][k % 3] =
                g * f[k / 3][k % 3] +
                (o->own * (j - 1.0) - g * first / (3.0 * j)) * cofactor[q][k / 3][k % 3];
        }
        volume += o->volume[e][q];
        mean += o->volume[e][q] * (j - 1.0);
    }
    memset(out, 0, ORACLE_DOFS * sizeof *out);
    for (int q = 0; q < 4; ++q) {
        for (int n = 0; n < 10; ++n) {
            for (int k = 0; k < 9; ++k) {
                out[3 * n + k / 3] += o->volume[e][q] * o->gradient[e][q][n][k % 3] *
                                      (stress[q][k / 3][k % 3] +
                                       o->shared * mean / volume * cofactor[q][k / 3][k % 3]);
            }
        }
    }
    return true;
}

static inline void oracle_take(const oracle *o, int32_t e, const double *field, double out[30])
{
    for (int k = 0; k < ORACLE_DOFS; ++k) {
        out[k] = field[3 * (ptrdiff_t)o->node[e][k / 3] + k % 3];
    }
}

/* All of it; false where a point is inside out. */
static inline bool oracle_assemble(oracle *o, bool has_stiffness)
{
    memset(o->force, 0, 3 * (size_t)o->nodes * sizeof *o->force);
    for (int32_t e = 0; e < o->elements; ++e) {
        double u[ORACLE_DOFS], f[ORACLE_DOFS], low[ORACLE_DOFS], high[ORACLE_DOFS];
        oracle_take(o, e, o->u, u);
        if (!oracle_element(o, e, u, f)) {
            return false;
        }
        for (int k = 0; k < ORACLE_DOFS; ++k) {
            o->force[3 * (ptrdiff_t)o->node[e][k / 3] + k % 3] += f[k];
        }
        for (int k = 0; has_stiffness && k < ORACLE_DOFS; ++k) {
            const double h = 1e-6 * cbrt(o->volume[e][0]), at = u[k];
            u[k] = at - h;
            (void)oracle_element(o, e, u, low);
            u[k] = at + h;
            (void)oracle_element(o, e, u, high);
            u[k] = at;
            for (int i = 0; i < ORACLE_DOFS; ++i) {
                o->stiffness[e][i][k] = (high[i] - low[i]) / (2.0 * h);
            }
        }
    }
    return true;
}

/* ---- Newton ---- */

static inline void oracle_multiply(const oracle *o, const double *x, double *out)
{
    memset(out, 0, 3 * (size_t)o->nodes * sizeof *out);
    for (int32_t e = 0; e < o->elements; ++e) {
        double local[ORACLE_DOFS];
        oracle_take(o, e, x, local);
        for (int i = 0; i < ORACLE_DOFS; ++i) {
            double sum = 0.0;
            for (int k = 0; k < ORACLE_DOFS; ++k) {
                sum += o->stiffness[e][i][k] * local[k];
            }
            out[3 * (ptrdiff_t)o->node[e][i / 3] + i % 3] += sum;
        }
    }
    for (int32_t k = 0; k < 3 * o->nodes; ++k) {
        out[k] = o->held[k] ? 0.0 : out[k];
    }
}

static inline double oracle_dot(const oracle *o, const double *a, const double *b)
{
    double sum = 0.0;
    for (int32_t k = 0; k < 3 * o->nodes; ++k) {
        sum += o->held[k] ? 0.0 : a[k] * b[k];
    }
    return sum;
}

/* x: K x = -force, to `tolerance` of it. */
static inline void oracle_solve(const oracle *o, double tolerance, double *x)
{
    const size_t freedoms = 3 * (size_t)o->nodes;
    double *r = calloc(freedoms, sizeof *r), *z = calloc(freedoms, sizeof *z);
    double *p = calloc(freedoms, sizeof *p), *kp = calloc(freedoms, sizeof *kp);
    double *diagonal = calloc(freedoms, sizeof *diagonal);
    for (int32_t e = 0; e < o->elements; ++e) {
        for (int i = 0; i < ORACLE_DOFS; ++i) {
            diagonal[3 * (ptrdiff_t)o->node[e][i / 3] + i % 3] += o->stiffness[e][i][i];
        }
    }
    for (size_t k = 0; k < freedoms; ++k) {
        x[k] = 0.0;
        r[k] = o->held[k] ? 0.0 : -o->force[k];
        p[k] = z[k] = r[k] / diagonal[k];
    }
    const double start = oracle_dot(o, r, r);
    double rz = oracle_dot(o, r, z);
    for (int turn = 0; turn < 5000 && oracle_dot(o, r, r) > tolerance * tolerance * start; ++turn) {
        oracle_multiply(o, p, kp);
        const double alpha = rz / oracle_dot(o, p, kp);
        for (size_t k = 0; k < freedoms; ++k) {
            x[k] += alpha * p[k];
            r[k] -= alpha * kp[k];
            z[k] = r[k] / diagonal[k];
        }
        const double next = oracle_dot(o, r, z);
        for (size_t k = 0; k < freedoms; ++k) {
            p[k] = z[k] + next / rz * p[k];
        }
        rz = next;
    }
    free(r);
    free(z);
    free(p);
    free(kp);
    free(diagonal);
}

/* Balance at the held displacements that `u` has; false where it does not come about. */
static inline bool oracle_balance(oracle *o)
{
    const size_t freedoms = 3 * (size_t)o->nodes;
    double *step = calloc(freedoms, sizeof *step), *from = calloc(freedoms, sizeof *from);
    double first = 0.0, rest = 0.0;
    bool is_good = oracle_assemble(o, true);
    for (int turn = 0; is_good && turn < 30; ++turn) {
        rest = sqrt(oracle_dot(o, o->force, o->force));
        first = turn == 0 ? rest : first;
        if (rest <= 1e-9 * first) {
            break;
        }
        oracle_solve(o, 1e-3, step);
        memcpy(from, o->u, freedoms * sizeof *from);
        double share = 1.0;
        do { /* back where a point turns over or the residual grows much */
            for (size_t k = 0; k < freedoms; ++k) {
                o->u[k] = from[k] + share * step[k];
            }
            share *= 0.5;
            is_good =
                oracle_assemble(o, false) && sqrt(oracle_dot(o, o->force, o->force)) < 2.0 * rest;
        } while (!is_good && share > 1e-3);
        is_good = is_good && oracle_assemble(o, true);
    }
    free(step);
    free(from);
    return is_good && rest <= 1e-6 * first;
}
