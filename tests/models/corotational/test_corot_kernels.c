/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * models/corot_kernels: the rotation is the nearest one, inside out too, the force the exact
 * gradient of the energy, the tangent symmetric and positive.
 */
#include "common/test.h"

#include <string.h>

#include "common/paths_fixture.h"
#include "models/corotational/kernels.h"
#include "rt/memory.h"
#include "rt/vec.h"

typedef double vector[3];

/* tr(R^T F) of the best rotation, by Horn's matrix and Jacobi's rotations: slow and sure. */
static double best_trace(const double f[3][3])
{
    double n[4][4] = {
        {f[0][0] + f[1][1] + f[2][2], f[2][1] - f[1][2], f[0][2] - f[2][0], f[1][0] - f[0][1]},
        {0, f[0][0] - f[1][1] - f[2][2], f[0][1] + f[1][0], f[2][0] + f[0][2]},
        {0, 0, f[1][1] - f[0][0] - f[2][2], f[1][2] + f[2][1]},
        {0, 0, 0, f[2][2] - f[0][0] - f[1][1]}};
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < i; ++j) {
            n[i][j] = n[j][i];
        }
    }
    for (int sweep = 0; sweep < 30; ++sweep) {
        for (int p = 0; p < 4; ++p) {
            for (int q = p + 1; q < 4; ++q) {
                if (n[p][q] == 0.0) {
                    continue;
                }
                const double angle = 0.5 * atan2(2.0 * n[p][q], n[q][q] - n[p][p]);
                const double c = cos(angle), d = sin(angle);
                for (int k = 0; k < 4; ++k) {
                    ss_rotate_pair(&n[k][p], &n[k][q], c, d);
                }
                for (int k = 0; k < 4; ++k) {
                    ss_rotate_pair(&n[p][k], &n[q][k], c, d);
                }
            }
        }
    }
    return fmax(fmax(n[0][0], n[1][1]), fmax(n[2][2], n[3][3]));
}

/* Eight tetrahedra with a corner at the origin and edges along the axes, each displaced by H x. */
typedef struct octet {
    ss_arena arena;
    ss_fem_blocks blocks;
    ss_real *u, *turned, *force;
} octet;

static void octet_init(octet *o, double lambda, double mu)
{
    *o = (octet){0};
    vector position[32];
    int32_t corner[8][4];
    double lambdas[8], mus[8];
    for (int t = 0; t < 8; ++t) {
        for (int a = 0; a < 4; ++a) {
            corner[t][a] = 4 * t + a;
            ss_set3(position[4 * t + a], a == 1, a == 2, a == 3);
        }
        lambdas[t] = lambda;
        mus[t] = mu;
    }
    const ss_mesh mesh = {
        .node_count = 32, .tetrahedron_count = 8, .position = position, .tetrahedron = corner};
    const ss_fem_stuff stuff = {
        .node_count = 32, .mesh = &mesh, .moduli = {lambdas, lambdas, mus, NULL, NULL}};
    assert_true(ss_fem_blocks_create(&stuff, &o->arena, &o->blocks));
    SS_ARENA_TAKE(&o->arena, SS_ROOM(128, o->u), SS_ROOM(72, o->turned), SS_ROOM(128, o->force));
}

static void octet_fini(octet *o)
{
    ss_arena_free(&o->arena);
}

/* Element t has F: its corner 1 + j goes to column j. */
static void deform(octet *o, int t, const double f[3][3])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            o->u[16 * t + 4 * (1 + j) + i] = (ss_real)(f[i][j] - (i == j ? 1.0 : 0.0));
        }
    }
}

static ss_corot_pass run(octet *o, const ss_corot_kernels *kernels)
{
    ss_corot_pass pass = {.blocks = &o->blocks, .u = o->u, .turned = o->turned, .force = o->force};
    memset(o->force, 0, 128 * sizeof *o->force);
    kernels->evaluate(&pass);
    return pass;
}

/* Small and large strain; inside out; anything; half turns; from 5 on such as have more than one
 * nearest rotation, or nearly so. */
static void random_deformation(int kind, double f[3][3])
{
    double q[4], size = 0.0;
    for (int k = 0; k < 4; ++k) {
        q[k] = random_unit();
        size += q[k] * q[k];
    }
    for (int k = 0; k < 4; ++k) {
        q[k] /= sqrt(size);
    }
    for (int j = 0; j < 3; ++j) {
        const double stretch = kind == 0   ? 1.0 + 1e-3 * random_unit()
                               : kind == 1 ? 1.0 + 0.5 * random_unit()
                               : kind == 2 ? (j == 2 ? -0.4 : 1.0 + 0.3 * random_unit())
                               : kind == 5 ? (j == 2   ? -0.7
                                              : j == 1 ? 0.7
                                                       : 1.2)
                               : kind == 6 ? (j == 2 ? -1.0 : 1.0)
                               : kind == 7 ? (j == 0 ? 0.5 : 0.0)
                                           : 2.0 * random_unit();
        double column[3] = {j == 0, j == 1, j == 2}, out[3];
        ss_rotate(out, q, column);
        for (int i = 0; i < 3; ++i) {
            const double shake = kind == 3 ? 1.0 : kind >= 5 ? 1e-5 : 0.0;
            f[i][j] = stretch * out[i] + shake * random_unit();
        }
    }
    if (kind == 4) { /* half a turn about an axis, stretched along it */
        const double half[3][3] = {{-1.0, 0.0, 0.0}, {0.0, -1.1, 0.1}, {0.0, 0.1, 0.9}};
        memcpy(f, half, sizeof half);
    }
}

/* With lambda = 0: W = mu V |F - R|^2 = mu V (|F|^2 + 3 - 2 tr(R^T F)), least at the best R. */
TEST(turns_by_the_nearest_rotation)
{
    octet o;
    octet_init(&o, 0.0, 6.0);
    const ss_corot_kernels *kernels;
    path_results results = {NULL, NULL};
    for (int path = 0; (kernels = ss_corot_kernels_path(path)) != NULL; ++path) {
        random_state = 7;
        for (int kind = 0; kind < 8; ++kind) {
            for (int repeat = 0; repeat < 40; ++repeat) {
                double expected = 0.0;
                int inverted = 0;
                for (int t = 0; t < 8; ++t) {
                    double f[3][3], square = 0.0;
                    random_deformation(kind, f);
                    for (int k = 0; k < 9; ++k) {
                        square += f[k / 3][k % 3] * f[k / 3][k % 3];
                    }
                    deform(&o, t, (const double(*)[3])f);
                    expected += square + 3.0 - 2.0 * best_trace((const double(*)[3])f);
                    double n[3];
                    ss_cross3(n, f[0], f[1]);
                    inverted += ss_dot3(n, f[2]) < 0.0;
                }
                const ss_corot_pass pass = run(&o, kernels);
                const double share = kind < 5 ? BY_TYPE(1e-4, 1e-10) : 1e-3;
                assert_near(pass.energy, expected, share * (expected + 1e-3));
                assert_true(kind > 6 || pass.inverted_count == inverted);
            }
        }
        path_results_take(&results, kernels->name, 32, o.force);
    }
    path_results_fini(&results);
    octet_fini(&o);
}

TEST(force_is_the_gradient_of_the_energy)
{
    octet o;
    octet_init(&o, 12.0, 6.0);
    const double h = BY_TYPE(1e-2, 1e-6);
    const ss_corot_kernels *kernels;
    for (int path = 0; (kernels = ss_corot_kernels_path(path)) != NULL; ++path) {
        random_state = 11;
        for (int kind = 0; kind < 3; ++kind) {
            for (int t = 0; t < 8; ++t) {
                double f[3][3];
                random_deformation(kind, f);
                deform(&o, t, (const double(*)[3])f);
            }
            for (int at = 0; at < 128; ++at) {
                if (at % 4 == 3) {
                    continue;
                }
                const ss_real before = o.u[at];
                o.u[at] = before + (ss_real)h;
                const double above = run(&o, kernels).energy;
                o.u[at] = before - (ss_real)h;
                const double below = run(&o, kernels).energy;
                o.u[at] = before;
                (void)run(&o, kernels);
                assert_near((double)o.force[at], (below - above) / (2.0 * h), BY_TYPE(5e-3, 1e-7));
            }
        }
    }
    octet_fini(&o);
}

TEST(tangent_is_symmetric_and_positive)
{
    octet o;
    octet_init(&o, 12.0, 6.0);
    ss_real *x = ss_memory_get(128, sizeof *x), *y = ss_memory_get(128, sizeof *y);
    const ss_corot_kernels *kernels = ss_corot_kernels_get();
    for (int kind = 0; kind < 5; ++kind) {
        for (int t = 0; t < 8; ++t) {
            double f[3][3];
            random_deformation(kind, f);
            deform(&o, t, (const double(*)[3])f);
        }
        (void)run(&o, kernels);
        for (int k = 0; k < 128; ++k) {
            x[k] = k % 4 < 3 ? (ss_real)random_unit() : 0;
            y[k] = k % 4 < 3 ? (ss_real)random_unit() : 0;
        }
        double both[2];
        for (int way = 0; way < 2; ++way) {
            memset(o.force, 0, 128 * sizeof *o.force);
            kernels->multiply(&o.blocks, o.turned, o.blocks.modulus, 1.0, way ? y : x, o.force);
            both[way] = kernels->dot(128, way ? x : y, o.force);
            assert_true(kernels->dot(128, way ? y : x, o.force) > 0.0);
        }
        assert_near(both[0], both[1], BY_TYPE(1e-4, 1e-12));
    }
    ss_memory_free(x);
    ss_memory_free(y);
    octet_fini(&o);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
