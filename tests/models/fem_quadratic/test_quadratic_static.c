/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The settled body is the static solution of an independent program on the same elements. */
#include "common/test.h"

#include <stdio.h>

#include "common/effort.h"
#include "models/fem_quadratic/reference_fixture.h"
#include "models/tissue_law.h"
#include "oracles/quadratic_static.h"
#include "rt/vec.h"

/* The slab of the reference problems: glued below, a disk of 20 mm pushed in above. */
#define DISK   0.02
#define HEIGHT 0.05

static double slab_profile(const double x[3])
{
    const double square = (x[0] * x[0] + x[1] * x[1]) / (DISK * DISK);
    return x[2] > HEIGHT - 1e-9 && square < 1.0001 ? 1.0 - 0.5 * square : 0.0;
}

static bool is_slab_glued(const double x[3])
{
    return x[2] < 1e-9;
}

/* The ellipsoid: its skin below -20 mm glued, and 12 mm around its poke pushed as one. */
static bool is_skin(const double x[3])
{
    const double a = x[0] / 0.06, b = x[1] / 0.04, c = x[2] / 0.03;
    return a * a + b * b + c * c > 0.999;
}

static double ellipsoid_profile(const double x[3])
{
    const double a = x[0] - 0.025, c = x[2] - 0.02727;
    return is_skin(x) && a * a + x[1] * x[1] + c * c < 0.012 * 0.012 ? 1.0 : 0.0;
}

static bool is_ellipsoid_glued(const double x[3])
{
    return is_skin(x) && x[2] < -0.02 + 1e-9;
}

typedef struct problem {
    const char *file; /* in tests/reference */
    double (*profile)(const double x[3]);
    bool (*is_glued)(const double x[3]);
    double ratio, depth; /* m */
    int levels;          /* on the oracle's way there */
} problem;

/* Pushed in by `depth` within 0.2 s, then left to settle. */
static void settle(const problem *of, setup *s, double force[3])
{
    int32_t *node = calloc((size_t)s->mesh->node_count, sizeof *node), count = 0;
    double(*way)[3] = calloc((size_t)s->mesh->node_count, sizeof *way);
    give(s, "youngs_modulus_pa", 1e4);
    give(s, "poisson_ratio", of->ratio);
    give(s, "material", SS_TISSUE_NEO_HOOKEAN);
    give(s, "mass_damping_per_s", 80.0);
    give(s, "curved", 1.0);
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        const double share = of->profile(s->mesh->position[i]);
        s->fixed[i] = of->is_glued(s->mesh->position[i]) ? 7 : 0;
        if (share > 0.0) {
            node[count] = i;
            way[count++][2] = -of->depth * share;
        }
    }
    prescribe(s, count, node, way, 0.2);
    create(s);
    steps(s, 900, 1e-3);
    s->class->reaction(s->model, 0, force);
    free(node);
    free(way);
}

static void solve(const problem *of, oracle *o, const ss_mesh *mesh)
{
    double lambda;
    oracle_init(o, mesh->node_count, (const double(*)[3])mesh->position, mesh->tetrahedron_count,
                (const int32_t(*)[4])mesh->tetrahedron, mesh->triangle_count,
                (const int32_t(*)[3])mesh->triangle);
    ss_tissue_lame(1e4, of->ratio, &lambda, &o->mu);
    o->own = o->mu;
    o->shared = lambda + 2.0 / 3.0 * o->mu - o->own;
    for (int level = 1; level <= of->levels; ++level) {
        const double depth = of->depth * level / of->levels;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            const double share = of->profile(mesh->position[i]);
            for (int k = 0; k < 3; ++k) {
                if (share > 0.0 || of->is_glued(mesh->position[i])) {
                    o->held[3 * i + k] = true;
                    o->u[3 * i + k] = k == 2 ? -depth * share : 0.0;
                }
            }
        }
        oracle_hold_sides(o);
        for (int32_t i = o->corners; i < o->nodes; ++i) { /* a curved push is known there too */
            const double share = o->held[3 * i] ? of->profile(o->position[i]) : 0.0;
            o->u[3 * i + 2] = share > 0.0 ? -depth * share : o->u[3 * i + 2];
        }
        assert_true(oracle_balance(o));
    }
}

static double oracle_push(const oracle *o)
{
    double sum = 0.0;
    for (int32_t i = 0; i < o->nodes; ++i) {
        sum += o->held[3 * i] && o->u[3 * i + 2] < 0.0 ? o->force[3 * i + 2] : 0.0;
    }
    return sum;
}

static void compare(const problem *of)
{
    setup s;
    oracle o;
    double force[3], apart = 0.0, whole = 0.0;
    setup_init(&s, "fem-quadratic", load_reference(of->file));
    settle(of, &s, force);
    solve(of, &o, s.mesh);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double d = moved(&s, i, k) - o.u[3 * i + k];
            apart += d * d;
            whole += o.u[3 * i + k] * o.u[3 * i + k];
        }
    }
    const double push = oracle_push(&o);
    print_message("%s nu %g: field apart %.4f %%, force %.5g N against %.5g N\n", of->file,
                  of->ratio, 100.0 * sqrt(apart / whole), force[2], push);
    assert_true(sqrt(apart / whole) < 1e-3);
    assert_near(force[2], push, 1e-3 * fabs(push));
    oracle_fini(&o);
    setup_fini(&s);
}

TEST(settles_where_an_independent_newton_does)
{
    static const problem problems[] = {
        {"c_slab/mesh_300.msh", slab_profile, is_slab_glued, 0.45, 0.015, 4},
        {"c_slab/mesh_300.msh", slab_profile, is_slab_glued, 0.49, 0.003, 2},
        {"d_ellipsoid/mesh_300.msh", ellipsoid_profile, is_ellipsoid_glued, 0.45, 0.004, 2},
        {"c_slab/mesh_1k.msh", slab_profile, is_slab_glued, 0.45, 0.005, 2},
        {"d_ellipsoid/mesh_1k.msh", ellipsoid_profile, is_ellipsoid_glued, 0.45, 0.004, 2},
    };
    for (int k = 0; k < FULL_IN_LONG_RUN(5, FULL_IN_RELEASE(3, 1)); ++k) {
        compare(&problems[k]);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
