/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* object.surface: the middles of sides follow a finer surface. */
#include "common/test.h"

#include "models/fem_quadratic/quadratic_fixture.h"
#include "models/fem_quadratic/reference_fixture.h"

/* The ellipsoid's semi-axes are 60, 40 and 30 mm. */
static const double axis[3] = {0.06, 0.04, 0.03};

/* Parts of a side of a facet. */
enum { PARTS = 6 };

typedef struct body {
    setup s;
    ss_mesh surface; /* loose facets with their corners on the ellipsoid */
    ss_arena arena;
    ss_quadratic_raised raised;
} body;

static double level_of(const double x[3])
{
    double square = 0.0;
    for (int i = 0; i < 3; ++i) {
        square += x[i] * x[i] / (axis[i] * axis[i]);
    }
    return sqrt(square);
}

/* The facet's point (j, k) / PARTS, out to the ellipsoid and `aside` along x. */
static void add_corner(ss_mesh *out, const ss_mesh *coarse, int32_t t, int j, int k, double aside)
{
    double *x = out->position[out->node_count];
    const int32_t *c = coarse->triangle[t];
    for (int i = 0; i < 3; ++i) {
        x[i] = ((PARTS - j - k) * coarse->position[c[0]][i] + j * coarse->position[c[1]][i] +
                k * coarse->position[c[2]][i]) /
               PARTS;
    }
    ss_scale3(x, x, 1.0 / level_of(x));
    x[0] += aside;
    const int32_t n = out->node_count++;
    out->triangle[n / 3][n % 3] = n;
    out->triangle_count = out->node_count / 3;
}

static void make_finer(const ss_mesh *coarse, double aside, ss_mesh *out)
{
    const size_t most = (size_t)coarse->triangle_count * PARTS * PARTS;
    *out = (ss_mesh){.position = calloc(3 * most, sizeof *out->position),
                     .triangle = calloc(most, sizeof *out->triangle)};
    for (int32_t t = 0; t < coarse->triangle_count; ++t) {
        for (int j = 0; j < PARTS; ++j) {
            for (int k = 0; j + k < PARTS; ++k) {
                add_corner(out, coarse, t, j, k, aside);
                add_corner(out, coarse, t, j + 1, k, aside);
                add_corner(out, coarse, t, j, k + 1, aside);
                for (int n = 0; n < 3 && j + k < PARTS - 1; ++n) {
                    add_corner(out, coarse, t, j + (n < 2), k + (n > 0), aside);
                }
            }
        }
    }
}

static softsim_status body_init(body *b, bool has_surface, double aside)
{
    memset(b, 0, sizeof *b);
    setup_init(&b->s, "fem-quadratic", load_reference("d_ellipsoid/mesh_300.msh"));
    if (has_surface) {
        make_finer(b->s.mesh, aside, &b->surface);
        b->s.plan.surface = &b->surface;
    }
    return ss_quadratic_raise(&b->s.plan, true, &b->arena, &b->raised, &b->s.error);
}

static void body_fini(body *b)
{
    ss_arena_free(&b->arena);
    free(b->surface.position);
    free(b->surface.triangle);
    setup_fini(&b->s);
}

/* The volume's error, and the least Jacobian of a Gauss point over its element's mean. */
static double volume_error(const body *b, double *out_least)
{
    double volume = 0.0;
    *out_least = (double)INFINITY;
    for (int32_t e = 0; e < b->raised.mesh.tetrahedron_count; ++e) {
        ss_quadratic_point point[SS_QUADRATIC_POINTS];
        double own = 0.0, least = (double)INFINITY;
        (void)ss_quadratic_points(&b->raised.mesh, b->raised.node[e], point);
        for (int q = 0; q < SS_QUADRATIC_POINTS; ++q) {
            own += point[q].volume;
            least = fmin(least, point[q].volume);
        }
        volume += own;
        *out_least = fmin(*out_least, 4.0 * least / own);
    }
    return fabs(volume / (4.0 / 3.0 * SS_PI * axis[0] * axis[1] * axis[2]) - 1.0);
}

TEST(a_body_that_follows_a_finer_surface_has_its_volume)
{
    body flat, own, finer;
    double least[3];
    memset(&flat, 0, sizeof flat);
    setup_init(&flat.s, "fem-quadratic", load_reference("d_ellipsoid/mesh_300.msh"));
    assert_int_equal(
        ss_quadratic_raise(&flat.s.plan, false, &flat.arena, &flat.raised, &flat.s.error),
        SOFTSIM_OK);
    assert_int_equal(body_init(&own, false, 0.0), SOFTSIM_OK);
    assert_int_equal(body_init(&finer, true, 0.0), SOFTSIM_OK);
    const double error[3] = {volume_error(&flat, &least[0]), volume_error(&own, &least[1]),
                             volume_error(&finer, &least[2])};
    print_message("volume off by %.2e straight, %.2e by normals, %.2e by a finer surface; %d and "
                  "%d sides curved, %d straightened\n",
                  error[0], error[1], error[2], own.raised.curved_edge_count,
                  finer.raised.curved_edge_count, finer.raised.straightened_edge_count);
    assert_true(error[0] > 0.03);
    assert_true(error[2] < 0.02 * error[0]);
    assert_true(least[2] >= 0.2);
    assert_int_equal(finer.raised.lost_edge_count, 0);
    /* Corners stay, and middles are as near to the ellipsoid as the finer facets are. */
    for (int32_t i = 0; i < finer.raised.given_count; ++i) {
        assert_memory_equal(finer.raised.mesh.position[i], flat.raised.mesh.position[i],
                            sizeof(double[3]));
    }
    for (int32_t t = 0; t < finer.raised.mesh.triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            const double *x = finer.raised.mesh.position[finer.raised.mesh.triangle[t][k]];
            assert_near(level_of(x), 1.0, 1e-3);
        }
    }
    body_fini(&flat);
    body_fini(&own);
    body_fini(&finer);
}

TEST(a_surface_in_another_place_is_refused)
{
    body b;
    assert_int_equal(body_init(&b, true, 0.03), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(b.s.error.text, "object.surface is not near"));
    assert_true(b.raised.lost_edge_count > 10);
    body_fini(&b);
}

TEST(a_surface_beside_straight_sides_is_refused)
{
    setup s;
    setup_init(&s, "fem-quadratic", load_reference("d_ellipsoid/mesh_300.msh"));
    give(&s, "youngs_modulus_pa", 1e4);
    give(&s, "poisson_ratio", 0.45);
    give(&s, "curved", 1.0);
    s.plan.surface = s.mesh;
    expect_refusal(&s, SOFTSIM_ERROR_SCENE, "object.surface is followed by curved edges");
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
