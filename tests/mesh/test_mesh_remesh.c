/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Remeshing: what comes out lies on what was given, is even, and keeps what it must. */
#include "common/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/mesh_fixture.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

/* An ellipsoid of rings and slices: slivers at its poles, and where it is drawn out. */
static ss_mesh *make_ellipsoid(int rings, int slices, const double half[3])
{
    const int32_t nodes = rings * slices + 2;
    double(*x)[3] = malloc((size_t)nodes * sizeof *x);
    int32_t(*t)[3] = malloc(2 * (size_t)(rings * slices) * sizeof *t);
    int32_t count = 0;
    for (int i = 0; i < rings * slices; ++i) {
        const int ring = i / slices;
        const double v = SS_PI * (ring + 1) / (rings + 1), u = 2.0 * SS_PI * (i % slices) / slices;
        ss_set3(x[i], half[0] * sin(v) * cos(u), half[1] * sin(v) * sin(u), -half[2] * cos(v));
    }
    ss_set3(x[nodes - 2], 0.0, 0.0, -half[2]);
    ss_set3(x[nodes - 1], 0.0, 0.0, half[2]);
    for (int i = 0; i < rings * slices; ++i) {
        const int ring = i / slices;
        const int32_t j = ring * slices + (i + 1) % slices;
        const int32_t pole = ring == 0 ? nodes - 2 : nodes - 1;
        if (ring == 0 || ring == rings - 1) {
            const int32_t cap[3] = {ring == 0 ? j : i, ring == 0 ? i : j, pole};
            memcpy(t[count++], cap, sizeof cap);
        }
        if (ring < rings - 1) {
            const int32_t two[2][3] = {{i, j, j + slices}, {i, j + slices, i + slices}};
            memcpy(t[count], two, sizeof two);
            count += 2;
        }
    }
    ss_mesh *mesh = make_mesh(nodes, (const double(*)[3])x, count, (const int32_t(*)[3])t, 0, NULL);
    free(x);
    free(t);
    return mesh;
}

static ss_mesh *make_box(const double size[3])
{
    static const int32_t t[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                     {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                     {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    double x[8][3];
    for (int i = 0; i < 8; ++i) {
        ss_set3(x[i], (i & 1) * size[0], (i >> 1 & 1) * size[1], (i >> 2) * size[2]);
    }
    return make_mesh(8, (const double(*)[3])x, 12, t, 0, NULL);
}

static ss_mesh *remesh(const ss_mesh *mesh, double edge, ss_mesh_remeshing *done)
{
    ss_mesh *even = NULL;
    softsim_error error = {0};
    if (ss_mesh_remesh(mesh, edge, 40.0, &even, done, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return even;
}

/* A scene takes it, and it does not cross itself. */
static void expect_sound(const ss_mesh *mesh, bool is_closed, ss_mesh_report *out)
{
    softsim_error error = {0};
    ss_mesh_fault crossing;
    bool is_complete = false;
    assert_int_equal(ss_mesh_check(mesh, out), SOFTSIM_OK);
    if (ss_mesh_accept(mesh, "remeshed", &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(mesh->is_closed, is_closed);
    assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete));
    assert_int_equal(crossing.count, 0);
}

TEST(slivers_go_and_edges_are_even)
{
    const double half[3] = {1.0, 0.6, 0.4};
    const int64_t before = ss_memory_in_use();
    ss_mesh *mesh = make_ellipsoid(60, 40, half);
    ss_mesh_report given, r;
    ss_mesh_quality quality;
    ss_mesh_measure_quality(mesh, &quality);
    assert_true(quality.sliver.count > 100);
    expect_sound(mesh, true, &given);
    const double edges[] = {0.05, 0.1, 0.2};
    for (int32_t i = 0; i < COUNT(edges); ++i) {
        ss_mesh_remeshing done;
        ss_mesh *even = remesh(mesh, edges[i], &done);
        expect_sound(even, true, &r);
        ss_mesh_measure_quality(even, &quality);
        assert_int_equal(quality.sliver.count, 0);
        assert_true(r.angle_min > 20.0);
        assert_near(r.edge_mean, edges[i], 0.15 * edges[i]);
        assert_true(r.edge_max < 1.5 * edges[i] && r.edge_min > 0.4 * edges[i]);
        /* A triangle of edges up to e lies in a circle of radius e / sqrt 3 and so at most e^2 / 6
         * R below a surface of curvature 1 / R; here the sharpest has R = 0.4^2. */
        assert_true(done.distance < r.edge_max * r.edge_max / (6.0 * 0.16));
        assert_near(r.volume, given.volume, 0.5 * edges[i] * given.volume);
        ss_mesh_destroy(&even);
    }
    ss_mesh_destroy(&mesh);
    assert_int_equal(ss_memory_in_use(), before);
}

/* As programs write spheres and cones: the poles have as many triangles as there are slices. */
TEST(fans_of_many_triangles_go)
{
    const double half[3] = {1.0, 1.0, 1.0};
    static const int slices[] = {60, 500, 3000};
    for (int32_t i = 0; i < COUNT(slices); ++i) {
        ss_mesh *mesh = make_ellipsoid(12, slices[i], half);
        ss_mesh_remeshing done;
        ss_mesh *even = remesh(mesh, 0.15, &done);
        ss_mesh_report r;
        ss_mesh_quality quality;
        expect_sound(even, true, &r);
        ss_mesh_measure_quality(even, &quality);
        assert_int_equal(quality.sliver.count, 0);
        assert_true(r.edge_min > 0.4 * 0.15);
        ss_mesh_destroy(&even);
        ss_mesh_destroy(&mesh);
    }
}

/* Faces around a point go at random, the less likely the farther off: a hole with a ragged border.
 */
static ss_mesh *tear(const ss_mesh *mesh, const double at[3], double radius, uint64_t *random)
{
    int32_t(*t)[3] = malloc((size_t)mesh->triangle_count * sizeof *t);
    int32_t count = 0;
    for (int32_t i = 0; i < mesh->triangle_count; ++i) {
        double d[3];
        ss_sub3(d, mesh->position[mesh->triangle[i][0]], at);
        if (ss_norm3(d) > radius * (0.6 + 0.4 * ss_random_unit(random))) {
            memcpy(t[count++], mesh->triangle[i], sizeof *t);
        }
    }
    ss_mesh *torn = make_mesh(mesh->node_count, (const double(*)[3])mesh->position, count,
                              (const int32_t(*)[3])t, 0, NULL);
    free(t);
    return torn;
}

TEST(most_slivers_that_filled_holes_leave_go)
{
    const double half[3] = {1.0, 0.6, 0.4};
    ss_mesh *mesh = make_ellipsoid(40, 40, half);
    uint64_t random = 20;
    int64_t slivers = 0, left = 0;
    for (int i = 0; i < 12; ++i) {
        const double turn = 0.5 * i, at[3] = {cos(turn), 0.6 * sin(turn), 0.0};
        ss_mesh *torn = tear(mesh, at, 0.15 + 0.01 * i, &random), *whole = NULL;
        ss_mesh_repairs repairs;
        ss_mesh_remeshing done;
        ss_mesh_report r;
        ss_mesh_quality quality;
        assert_int_equal(ss_mesh_repair(torn, &whole, &repairs, NULL), SOFTSIM_OK);
        ss_mesh_measure_quality(whole, &quality);
        slivers += quality.sliver.count;
        ss_mesh *even = remesh(whole, 0.05, &done);
        expect_sound(even, whole->is_closed, &r);
        ss_mesh_measure_quality(even, &quality);
        left += quality.sliver.count;
        ss_mesh_destroy(&torn);
        ss_mesh_destroy(&whole);
        ss_mesh_destroy(&even);
    }
    /* A ridge longer than a few edges stays, and with it a sliver here and there. */
    if (!(slivers > 1000 && left < slivers / 40)) {
        fail_msg("%lld slivers before, %lld after", (long long)slivers, (long long)left);
    }
    ss_mesh_destroy(&mesh);
}

TEST(sharp_edges_and_corners_stay)
{
    const double size[3] = {1.0, 0.7, 0.3};
    ss_mesh *mesh = make_box(size);
    ss_mesh_remeshing done;
    ss_mesh_report r;
    ss_mesh *even = remesh(mesh, 0.1, &done);
    expect_sound(even, true, &r);
    assert_near(r.volume, 0.21, 1e-12);
    assert_near(r.area, 2.42, 1e-12);
    assert_true(done.distance < 1e-12);
    assert_nodes_near(even, mesh, 0.0);
    assert_true(even->triangle_count > 300 && r.angle_min > 15.0);
    ss_mesh_destroy(&even);
    ss_mesh_destroy(&mesh);
}

TEST(thin_plates_do_not_come_to_cross_themselves)
{
    const double half[3] = {1.0, 1.0, 0.02};
    ss_mesh *mesh = make_ellipsoid(24, 24, half);
    for (double edge = 0.08; edge < 0.5; edge *= 2.0) {
        ss_mesh_remeshing done;
        ss_mesh_report r;
        ss_mesh *even = remesh(mesh, edge, &done);
        expect_sound(even, true, &r);
        ss_mesh_destroy(&even);
    }
    ss_mesh_destroy(&mesh);
}

TEST(borders_and_groups_stay)
{
    ss_mesh *mesh = NULL;
    ss_mesh_remeshing done;
    ss_mesh_report r;
    assert_int_equal(ss_mesh_create_plane(11, 21, 1.0, 0.5, &mesh, NULL), SOFTSIM_OK);
    mesh->group = ss_memory_get(1, sizeof *mesh->group);
    mesh->group_count = 1;
    strcpy(mesh->group[0].name, "left");
    mesh->group[0].node = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t));
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (mesh->position[i][0] < -0.499) {
            mesh->group[0].node[mesh->group[0].node_count++] = i;
        }
    }
    ss_mesh *even = remesh(mesh, 0.03, &done);
    expect_sound(even, false, &r);
    assert_near(r.area, 0.5, 1e-12);
    int32_t left = 0;
    for (int32_t i = 0; i < even->node_count; ++i) {
        left += even->position[i][0] < -0.499;
    }
    assert_true(left > 10);
    assert_int_equal(even->group[0].node_count, left);
    ss_mesh_destroy(&even);
    ss_mesh_destroy(&mesh);
}

TEST(what_cannot_be_remeshed_is_told)
{
    const double size[3] = {1.0, 1.0, 1.0};
    const double x[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.2, 0.2, 0.2}};
    const int32_t tetrahedron[1][4] = {{0, 1, 2, 3}};
    const int32_t three[3][3] = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
    ss_mesh *mesh[3] = {make_mesh(5, x, 0, NULL, 1, tetrahedron),
                        make_mesh(5, x, 3, three, 0, NULL), make_box(size)};
    static const char *const says[] = {"it has tetrahedra", "mend it first", "4 million"};
    for (int i = 0; i < 3; ++i) {
        ss_mesh *even = NULL;
        ss_mesh_remeshing done;
        softsim_error error = {0};
        const softsim_status status =
            ss_mesh_remesh(mesh[i], i == 2 ? 1e-5 : 0.5, 40.0, &even, &done, &error);
        assert_int_equal(status, SOFTSIM_ERROR_MESH);
        assert_null(even);
        if (strstr(error.text, says[i]) == NULL) {
            fail_msg("%d: %s", i, error.text);
        }
        ss_mesh_destroy(&mesh[i]);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
