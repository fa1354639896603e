/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/block_fixture.h"
#include "mesh/mesh.h"
#include "rt/each.h"
#include "rt/vec.h"

/* n x n x n cubes of edge `size`/n about the origin as tetrahedra; with `hole`, without the middle
 * cube (n = 3). */
static ss_mesh *make_cube(int n, double size, bool hole)
{
    static const int cut[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                  {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    const int side = n + 1;
    const int32_t nodes = side * side * side;
    double(*x)[3] = calloc((size_t)nodes, sizeof *x);
    int32_t(*tetrahedron)[4] = calloc((size_t)(6 * n * n * n), sizeof *tetrahedron);
    int32_t count = 0;
    for (int32_t i = 0; i < nodes; ++i) {
        const int at[3] = {i % side, i / side % side, i / side / side};
        for (int k = 0; k < 3; ++k) {
            x[i][k] = size * ((double)at[k] / n - 0.5);
        }
    }
    for (int c = 0; c < n * n * n; ++c) {
        const int at[3] = {c % n, c / n % n, c / n / n};
        for (int t = 0; t < 6 && !(hole && at[0] == 1 && at[1] == 1 && at[2] == 1); ++t) {
            for (int a = 0; a < 4; ++a) {
                const int v = cut[t][a];
                tetrahedron[count][a] =
                    at[0] + (v & 1) + side * (at[1] + (v >> 1 & 1) + side * (at[2] + (v >> 2 & 1)));
            }
            ++count;
        }
    }
    return take_tetrahedra(nodes, x, count, tetrahedron);
}

/* The surface of a cube's tetrahedra, those of its top left out where `is_open`; its top at z. */
static ss_mesh *make_shell(int n, double size, double top, bool is_open)
{
    ss_mesh *cube = make_cube(n, size, false);
    int32_t(*triangle)[3] = calloc((size_t)cube->triangle_count, sizeof *triangle);
    int32_t count = 0;
    for (int32_t t = 0; t < cube->triangle_count; ++t) {
        double lowest = INFINITY;
        for (int k = 0; k < 3; ++k) {
            lowest = fmin(lowest, cube->position[cube->triangle[t][k]][2]);
        }
        if (!is_open || lowest < 0.49 * size) {
            memcpy(triangle[count++], cube->triangle[t], sizeof *triangle);
        }
    }
    /* Only the nodes that a triangle has. */
    int32_t *number = calloc((size_t)cube->node_count, sizeof *number);
    double(*x)[3] = calloc((size_t)cube->node_count, sizeof *x);
    int32_t nodes = 0;
    for (int32_t c = 0; c < 3 * count; ++c) {
        int32_t *node = &triangle[c / 3][c % 3];
        if (number[*node] == 0) {
            ss_copy3(x[nodes], cube->position[*node]);
            x[nodes][2] = x[nodes][2] > 0.49 * size ? top : x[nodes][2];
            number[*node] = ++nodes;
        }
        *node = number[*node] - 1;
    }
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(nodes, (const double(*)[3])x, count,
                                    (const int32_t(*)[3])triangle, 0, NULL, &mesh, NULL),
                     SOFTSIM_OK);
    SS_EACH(free, triangle, number, x);
    ss_mesh_destroy(&cube);
    return mesh;
}

static double volume_of(const ss_mesh *mesh)
{
    ss_mesh_report report;
    assert_int_equal(ss_mesh_check(mesh, &report), SOFTSIM_OK);
    assert_int_equal(report.inconsistent_winding.count, 0);
    assert_int_equal(report.non_manifold_edge.count, 0);
    assert_int_equal(report.zero_area.count, 0);
    return report.volume;
}

TEST(closed_surface_covers_the_whole_core)
{
    ss_mesh *core = make_cube(3, 1.0, true);
    ss_mesh *outer = make_shell(2, 2.0, 1.0, false);
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_add_skin(core, outer, &mesh, NULL), SOFTSIM_OK);
    assert_true(mesh->is_closed);
    assert_int_equal(mesh->node_count, core->node_count + outer->node_count);
    assert_int_equal(mesh->tetrahedron_count, core->tetrahedron_count);
    /* The cavity's twelve triangles stay, the core's outer ones do not. */
    assert_int_equal(mesh->triangle_count, outer->triangle_count + 12);
    assert_true(fabs(volume_of(mesh) - (8.0 - 1.0 / 27.0)) < 1e-12);
    ss_mesh_destroy(&mesh);
    ss_mesh_destroy(&outer);
    ss_mesh_destroy(&core);
}

TEST(open_surface_is_joined_at_its_rim)
{
    ss_mesh *core = make_cube(3, 1.0, false);
    ss_mesh *outer = make_shell(3, 2.0, 0.5, true);
    ss_mesh *mesh = NULL;
    softsim_error error = {.status = SOFTSIM_OK};
    if (ss_mesh_add_skin(core, outer, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_true(mesh->is_closed);
    /* A tub of 2 x 2 x 1.5; the core's top stays its own. */
    assert_true(fabs(volume_of(mesh) - 6.0) < 1e-12);
    ss_mesh_destroy(&mesh);
    ss_mesh_destroy(&outer);
    ss_mesh_destroy(&core);
}

static void expect_refusal(const ss_mesh *core, ss_mesh *outer, const char *word)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_mesh_add_skin(core, outer, &mesh, &error), SOFTSIM_ERROR_MESH);
    assert_null(mesh);
    if (strstr(error.text, word) == NULL) {
        fail_msg("no '%s' in: %s", word, error.text);
    }
    ss_mesh_destroy(&outer);
}

TEST(surfaces_that_do_not_fit_are_refused)
{
    ss_mesh *core = make_cube(3, 1.0, false);
    ss_mesh *far = make_shell(2, 0.1, 0.05, false);
    const double none[3] = {0, 0, 0};
    const double away[3] = {10, 10, 10};
    ss_mesh_transform(far, 1.0, none, away);
    expect_refusal(core, far, "covers no face");
    ss_mesh *beside = make_shell(2, 2.0, 1.0, false);
    const double aside[3] = {1.2, 0, 0};
    ss_mesh_transform(beside, 1.0, none, aside);
    expect_refusal(core, beside, "rim");
    ss_mesh_destroy(&core);
}

TEST(layers_grow_both_ways)
{
    ss_mesh *core = make_cube(6, 1.2, false);
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_grow_skin(core, -0.15, &mesh, NULL), SOFTSIM_OK);
    /* Inward: surface and nodes are those of before, a core of tetrahedra is left inside. */
    assert_int_equal(mesh->node_count, core->node_count);
    assert_int_equal(mesh->triangle_count, core->triangle_count);
    assert_true(mesh->tetrahedron_count > 0 && mesh->tetrahedron_count < core->tetrahedron_count);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        double deepest = 0.0;
        for (int a = 0; a < 4; ++a) {
            const double *x = mesh->position[mesh->tetrahedron[e][a]];
            deepest = fmax(deepest, 0.6 - fmax(fmax(fabs(x[0]), fabs(x[1])), fabs(x[2])));
        }
        assert_true(deepest > 0.15);
    }
    ss_mesh_destroy(&mesh);
    assert_int_equal(ss_mesh_grow_skin(core, 0.1, &mesh, NULL), SOFTSIM_OK);
    assert_int_equal(mesh->tetrahedron_count, core->tetrahedron_count);
    assert_int_equal(mesh->triangle_count, core->triangle_count);
    assert_true(mesh->is_closed);
    assert_true(volume_of(mesh) > 1.2 * 1.2 * 1.2 + 0.8 * 0.1 * 6 * 1.44);
    ss_mesh_destroy(&mesh);
    /* A cavity is no place to grow into. */
    ss_mesh *hollow = make_cube(3, 1.0, true);
    assert_int_equal(ss_mesh_grow_skin(hollow, 0.05, &mesh, NULL), SOFTSIM_OK);
    assert_int_equal(mesh->triangle_count, hollow->triangle_count);
    assert_true(volume_of(mesh) > volume_of(hollow) + 0.8 * 0.05 * 6);
    ss_mesh_destroy(&mesh);
    ss_mesh_destroy(&hollow);
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_mesh_grow_skin(core, -2.0, &mesh, &error), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(error.text, "layer.thickness_m"));
    assert_null(mesh);
    ss_mesh_destroy(&core);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
