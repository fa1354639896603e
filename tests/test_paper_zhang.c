/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench, the report on Zhang et al. (2018): its measures of shapes give what can be worked
 * out by hand; its runs hold what they are told to hold, go back as they went, and name what the
 * program refuses; the plane's settled forces are those of the prototype.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "number_fixture.h"
#include "rt/vec.h"
#include "zhang.h"

static softsim_error error;

/* ---- measures ------------------------------------------------------------------------------- */

/* A tetrahedron with three unit edges from its first corner, and its mirror below. */
static ss_mesh *make_pair(void)
{
    static const double position[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -2}};
    static const int32_t tetrahedron[2][4] = {{0, 1, 2, 3}, {0, 2, 1, 4}};
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(5, position, 0, NULL, 2, tetrahedron, &mesh, &error),
                     SOFTSIM_OK);
    return mesh;
}

static void distances_are_relative_and_weighted(void **state)
{
    (void)state;
    const double u[2][3] = {{3, 0, 0}, {0, 4, 0}}, v[2][3] = {{3, 4, 0}, {0, 4, 3}};
    const double weight[2] = {1.0, 3.0};
    assert_near(ss_zhang_distance(2, u, v, NULL), sqrt(25.0 / 50.0), 1e-15);
    assert_near(ss_zhang_distance(2, u, v, weight), sqrt((16.0 + 27.0) / 100.0), 1e-15);
    assert_near(ss_zhang_distance(2, v, v, weight), 0.0, 0.0);
}

static void volumes_are_shared_and_inversions_counted(void **state)
{
    (void)state;
    ss_mesh *mesh = make_pair();
    double volume[5], u[5][3] = {{0.0}};
    ss_zhang_volumes(mesh, volume);
    assert_near(volume[3], 1.0 / 24.0, 1e-15);
    assert_near(volume[4], 2.0 / 24.0, 1e-15);
    assert_near(volume[0], 3.0 / 24.0, 1e-15);
    assert_int_equal(ss_zhang_inverted(mesh, (const double(*)[3])u), 0);
    u[3][2] = -1.5; /* through the base */
    assert_int_equal(ss_zhang_inverted(mesh, (const double(*)[3])u), 1);
    u[4][2] = 2.5;
    assert_int_equal(ss_zhang_inverted(mesh, (const double(*)[3])u), 2);
    ss_mesh_destroy(&mesh);
}

static void roughness_is_what_neighbours_do_not_do(void **state)
{
    (void)state;
    ss_mesh *mesh = make_pair();
    const uint8_t fixed[5] = {7, 7, 7, 0, 7};
    double u[5][3];
    for (int i = 0; i < 5; ++i) {
        ss_set3(u[i], 0.1, -0.2, 0.3); /* moved as one */
    }
    assert_near(ss_zhang_roughness(mesh, fixed, (const double(*)[3])u), 0.0, 1e-15);
    u[3][0] += 0.4; /* its element's mean is a quarter of that */
    assert_near(ss_zhang_roughness(mesh, fixed, (const double(*)[3])u), 0.3, 1e-15);
    ss_mesh_destroy(&mesh);
}

/* ---- runs ----------------------------------------------------------------------------------- */

static ss_zhang_plane plane;

static ss_zhang_setup network(void)
{
    return (ss_zhang_setup){
        .model = "cnn-chainmail",
        .param = {"alpha=0.02", "link_stiffness_n_per_m=1", "capacitance_s=1", "unloading=keep"},
        .mesh = plane.mesh,
        .fixed = plane.fixed,
        .pushed = plane.pushed,
        .pushed_count = 1,
        .direction = {0.0, 0.0, -1.0},
        .depth = 5.0,
        .step_s = 0.25};
}

static void refusals_are_told(void **state)
{
    (void)state;
    ss_zhang_run run;
    ss_zhang_setup setup = network();
    setup.model = "jelly";
    assert_int_equal(ss_zhang_begin(&setup, &run, &error), SOFTSIM_OK);
    assert_null(run.model);
    assert_non_null(strstr(run.reason, "jelly is not built into this program"));
    ss_zhang_end(&run);
    if (!ss_zhang_has("cnn-chainmail")) {
        skip();
    }
    setup = network();
    setup.param[3] = "wobble=2";
    assert_int_equal(ss_zhang_begin(&setup, &run, &error), SOFTSIM_OK);
    assert_null(run.model);
    assert_non_null(strstr(run.reason, "no parameter 'wobble'"));
    ss_zhang_end(&run);
    setup.param[3] = "unloading=never";
    assert_int_equal(ss_zhang_begin(&setup, &run, &error), SOFTSIM_OK);
    assert_null(run.model);
    ss_zhang_end(&run);
    ss_zhang_end(&run); /* twice does no harm */
}

static void the_patch_goes_in_and_comes_back(void **state)
{
    (void)state;
    static double u[SS_PLANE_NODES][3];
    ss_zhang_run run;
    const ss_zhang_setup setup = network();
    if (!ss_zhang_has("cnn-chainmail")) {
        skip();
    }
    assert_int_equal(ss_zhang_begin(&setup, &run, &error), SOFTSIM_OK);
    assert_non_null(run.model);
    assert_int_equal(ss_zhang_go(&run, 2.0, 0.3, &error), SOFTSIM_OK);
    ss_zhang_read(&run, u);
    assert_near(u[SS_PLANE_MIDDLE][2], -2.0, 1e-6);
    assert_true(u[SS_PLANE_MIDDLE + 1][2] < -0.5);
    assert_true(ss_zhang_force(&run) > 0.5);
    assert_true(ss_zhang_energy(&run) > 0.0);
    assert_int_equal(ss_zhang_go(&run, 0.5, 0.3, &error), SOFTSIM_OK);
    ss_zhang_read(&run, u);
    assert_near(u[SS_PLANE_MIDDLE][2], -0.5, 1e-6);
    for (int32_t i = 0; i < SS_PLANE_SIDE; ++i) { /* a rim */
        assert_near(u[i][2], 0.0, 0.0);
    }
    ss_zhang_end(&run);
}

static void settled_forces_are_those_of_the_prototype(void **state)
{
    (void)state;
    ss_zhang_run run;
    const ss_zhang_setup setup = network();
    if (!ss_zhang_has("cnn-chainmail")) {
        skip();
    }
    assert_int_equal(ss_zhang_begin(&setup, &run, &error), SOFTSIM_OK);
    assert_int_equal(ss_zhang_go(&run, 5.0, 1.0, &error), SOFTSIM_OK);
    assert_near(ss_zhang_force(&run), 9.4, 0.03 * 9.4);
    assert_int_equal(ss_zhang_hold(&run, 10.0, &error), SOFTSIM_OK);
    assert_near(ss_zhang_force(&run), 4.36, 0.03 * 4.36);
    assert_int_equal(ss_zhang_hold(&run, 990.0, &error), SOFTSIM_OK);
    assert_near(ss_zhang_force(&run), 0.579, 0.01 * 0.579);
    assert_true(run.peak_energy_rise < 1e-5);
    ss_zhang_end(&run);
}

static int make_plane(void **state)
{
    (void)state;
    return ss_zhang_plane_init(&plane, &error) == SOFTSIM_OK ? 0 : -1;
}

static int free_plane(void **state)
{
    (void)state;
    ss_zhang_plane_fini(&plane);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_relative_and_weighted),
        cmocka_unit_test(volumes_are_shared_and_inversions_counted),
        cmocka_unit_test(roughness_is_what_neighbours_do_not_do),
        cmocka_unit_test(refusals_are_told),
        cmocka_unit_test(the_patch_goes_in_and_comes_back),
        cmocka_unit_test(settled_forces_are_those_of_the_prototype),
    };
    return cmocka_run_group_tests(tests, make_plane, free_plane);
}
