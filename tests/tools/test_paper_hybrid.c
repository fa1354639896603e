/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench, the report on the hybrid model: its reference finite elements give the stresses that
 * can be worked out by hand, forces that are the slope of their energy, none for a rigid motion, a
 * stable step that is one, and a ball that is pushed as much as the tissue; of the section on the
 * pair curve no claim fails or differs.
 */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "bench/papers/hybrid/hybrid.h"
#include "bench/papers/hybrid/reference.h"
#include "common/folder_fixture.h"
#include "common/number_fixture.h"
#include "rt/vec.h"

static const double lambda = 5.5, mu = 2.5;
static ss_mesh *mesh;
static ss_heart_reference reference;

/* A cube of 1 in five tetrahedra about its middle one, with its surface. */
static int make_cube(void **state)
{
    static const double position[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                          {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    static const int32_t tetrahedron[5][4] = {
        {0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
    static const int32_t triangle[12][3] = {{0, 2, 1}, {3, 1, 2}, {4, 5, 7}, {4, 7, 6},
                                            {0, 1, 4}, {5, 4, 1}, {3, 2, 7}, {6, 7, 2},
                                            {0, 4, 2}, {6, 2, 4}, {3, 7, 1}, {5, 1, 7}};
    softsim_error error = {.status = SOFTSIM_OK};
    return ss_mesh_create(8, position, 12, triangle, 5, tetrahedron, &mesh, &error) == SOFTSIM_OK
               ? 0
               : -1;
}

static int free_cube(void **state)
{
    ss_mesh_destroy(&mesh);
    return 0;
}

static void start(void)
{
    assert_true(ss_heart_reference_init(&reference, mesh, lambda, mu, "none"));
    double whole = 0.0, surface = 0.0;
    for (int32_t e = 0; e < 5; ++e) {
        whole += reference.volume[e];
    }
    for (int32_t t = 0; t < 12; ++t) {
        surface += reference.area[t];
    }
    assert_near(whole, 1.0, 1e-15);
    assert_near(surface, 6.0, 1e-14);
}

/* Force of the elements as they are, nodes held. */
static double elastic_now(void)
{
    memset(reference.is_held, 1, 8);
    ss_heart_reference_run(&reference, 1, 1e-3);
    memset(reference.is_held, 0, 8);
    return reference.elastic;
}

/* P of a confined stretch by s, by hand: (lambda + 2 mu)/2 s (s^2 - 1). */
TEST(a_confined_stretch_is_as_by_hand)
{
    static const double stretch[3] = {0.8, 1.2, 1.5}, wanted[3] = {-1.512, 2.772, 9.84375};
    for (int k = 0; k < 3; ++k) {
        start();
        for (int32_t i = 0; i < 8; ++i) {
            reference.u[i][0] = (stretch[k] - 1.0) * mesh->position[i][0];
        }
        (void)elastic_now();
        double pull = 0.0;
        for (int32_t i = 0; i < 8; ++i) {
            pull -= mesh->position[i][0] > 0.5 ? reference.force[i][0] : 0.0;
        }
        assert_near(pull, wanted[k], 1e-12);
        ss_heart_reference_fini(&reference);
    }
}

TEST(a_rigid_motion_costs_nothing)
{
    start();
    reference.phi = reference.psi = 1.0;
    for (int32_t i = 0; i < 8; ++i) {
        const double *x = mesh->position[i];
        const double turned[3] = {0.6 * x[0] - 0.8 * x[1] + 3.0, 0.8 * x[0] + 0.6 * x[1],
                                  x[2] - 1.0};
        ss_sub3(reference.u[i], turned, x);
        ss_set3(reference.v[i], -2.0 * turned[1], 2.0 * turned[0], 0.5);
    }
    assert_near(elastic_now(), 0.0, 1e-12);
    for (int32_t i = 0; i < 8; ++i) {
        assert_near(ss_norm3(reference.force[i]), 0.0, 1e-12);
    }
    ss_heart_reference_fini(&reference);
}

/* Also where the guard of squeezed elements acts. */
TEST(forces_are_the_slope_of_the_energy)
{
    for (int guarded = 0; guarded < 2; ++guarded) {
        start();
        reference.is_guarded = guarded == 1;
        for (int32_t k = 0; k < 24; ++k) {
            reference.u[k / 3][k % 3] = 0.15 * random_unit() - (k % 3 == 0 && guarded ? 0.6 : 0.0) *
                                                                   mesh->position[k / 3][0];
        }
        (void)elastic_now();
        double force[8][3];
        memcpy(force, reference.force, sizeof force);
        for (int32_t k = 0; k < 24; ++k) {
            const double at = reference.u[k / 3][k % 3], step = 1e-6;
            reference.u[k / 3][k % 3] = at + step;
            const double above = elastic_now();
            reference.u[k / 3][k % 3] = at - step;
            const double below = elastic_now();
            reference.u[k / 3][k % 3] = at;
            assert_near(force[k / 3][k % 3], -(above - below) / (2.0 * step), 1e-6);
        }
        ss_heart_reference_fini(&reference);
    }
}

/* Below the step that it names a free body's small motion stays, above it does not. */
TEST(the_stable_step_is_one)
{
    for (int k = 0; k < 2; ++k) {
        double step;
        start();
        assert_true(ss_heart_reference_stable_step(&reference, &step));
        for (int32_t i = 0; i < 24; ++i) {
            reference.u[i / 3][i % 3] = 1e-9 * random_unit();
        }
        ss_heart_reference_run(&reference, 2000, (k == 0 ? 0.99 : 1.02) * step);
        double most = 0.0;
        for (int32_t i = 0; i < 8; ++i) {
            const double size = ss_norm3(reference.u[i]);
            most = isfinite(size) ? fmax(most, size) : (double)INFINITY;
        }
        assert_true(k == 0 ? most < 1e-6 : most > 1e-6);
        ss_heart_reference_fini(&reference);
    }
}

TEST(a_ball_is_pushed_as_much_as_the_tissue)
{
    start();
    reference.radius = 0.5;
    reference.stiffness = 100.0;
    ss_set3(reference.ball, 0.4, 0.45, 1.4); /* 0.1 into the top */
    (void)elastic_now();
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < 8; ++i) {
        ss_add3(sum, sum, reference.force[i]);
    }
    assert_true(reference.ball_force[2] > 0.0);
    for (int a = 0; a < 3; ++a) {
        assert_near(sum[a] + reference.ball_force[a], 0.0, 1e-14);
    }
    /* The pressure over a cap is k pi R p^2 at first; 32 samples on the face tell it roughly. */
    assert_near(reference.ball_force[2], 100.0 * 3.14159265 * 0.5 * 0.01, 0.5);
    ss_heart_reference_fini(&reference);
}

/* ---- a section of the report ---- */

TEST(the_pair_curve_is_the_printed_one)
{
    static ss_paper paper;
    softsim_error error = {.status = SOFTSIM_OK};
    paper.name = "hybrid";
    paper.folder = folder;
    assert_int_equal(make_folder(NULL), 0);
    assert_int_equal(ss_page_open(&paper.page, folder, "hybrid", "title", &error), SOFTSIM_OK);
    assert_int_equal(ss_heart_pair_curve(&paper, &error), SOFTSIM_OK);
    ss_page_abandon(&paper.page);
    assert_int_equal(paper.claim_count, 5);
    for (int32_t i = 0; i < paper.claim_count; ++i) {
        assert_string_equal(paper.claim[i].figure, "Fig. 2");
        assert_int_equal(paper.claim[i].result, SS_CLAIM_PASS); /* none is known to fail */
        assert_int_not_equal(paper.claim[i].source, SS_FROM_CODE);
    }
    assert_int_equal(remove_folder(NULL), 0);
}

int main(void)
{
    return run_all_tests(make_cube, free_cube);
}
