/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Surfaces of quads: directions, cutting, measures, faults, files. */
#include "mesh/mesh.h"

#include "rt/random.h"
#include "rt/vec.h"

#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/tool_fixture.h"

static const double none[3] = {0, 0, 0};

static ss_mesh *make(int32_t nodes, const double (*x)[3], int32_t quads, const int32_t (*quad)[4])
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_create_quads(nodes, x, quads, quad, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}

static ss_mesh *make_plane(int32_t rows, int32_t columns)
{
    ss_mesh *mesh = NULL;
    assert_int_equal(
        ss_mesh_create_plane(rows, columns, columns - 1, 2.0 * (rows - 1), &mesh, NULL),
        SOFTSIM_OK);
    return mesh;
}

static ss_mesh_report report_of(const ss_mesh *mesh)
{
    ss_mesh_report report;
    assert_int_equal(ss_mesh_check(mesh, &report), SOFTSIM_OK);
    return report;
}

/* The halves of each quad are its nodes, wound as it is, and share one diagonal. */
static void assert_halves(const ss_mesh *mesh)
{
    assert_int_equal(mesh->triangle_count, 2 * mesh->quad_count);
    for (int32_t q = 0; q < mesh->quad_count; ++q) {
        const int32_t *a = mesh->triangle[2 * q];
        const int32_t *b = mesh->triangle[2 * q + 1];
        int start = 0;
        while (mesh->quad[q][start] != a[0]) {
            ++start;
            assert_true(start < 4);
        }
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(a[k], mesh->quad[q][(start + k) % 4]);
            assert_int_equal(b[k], mesh->quad[q][(start + 2 + k) % 4]);
        }
        assert_true(a[0] < b[0]);
    }
}

/* Is the diagonal of quad q between nodes i and k? */
static bool is_cut_at(const ss_mesh *mesh, int32_t q, int32_t i, int32_t k)
{
    const int32_t *t = mesh->triangle[2 * q];
    return (t[0] == i && t[2] == k) || (t[0] == k && t[2] == i);
}

/* u of quad q: from corner 0 to corner 1. */
static void u_of(const ss_mesh *mesh, int32_t q, double out[3])
{
    ss_sub3(out, mesh->position[mesh->quad[q][1]], mesh->position[mesh->quad[q][0]]);
}

/* ---- grids ---- */

TEST(a_plane_is_numbered_directed_and_cut_as_promised)
{
    ss_mesh *m = make_plane(4, 5);
    assert_int_equal(m->node_count, 20);
    assert_int_equal(m->quad_count, 12);
    assert_false(m->is_closed);
    assert_halves(m);
    assert_near(m->position[1][0] - m->position[0][0], 1.0, 1e-15);
    assert_near(m->position[5][1] - m->position[0][1], 2.0, 1e-15);
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            const int q = 4 * r + c;
            const int32_t i = 5 * r + c;
            const int32_t expected[4] = {i + 1, i + 6, i + 5, i};
            assert_memory_equal(m->quad[q], expected, sizeof expected);
            assert_true((r + c) % 2 == 0 ? is_cut_at(m, q, i, i + 6)
                                         : is_cut_at(m, q, i + 1, i + 5));
            double u[3];
            u_of(m, q, u);
            assert_near(u[1], 2.0, 1e-15);
        }
    }
    const ss_mesh_report r = report_of(m);
    assert_near(r.area, 24.0, 1e-12);
    assert_near(r.edge_min, 1.0, 1e-12); /* sides, not diagonals */
    assert_near(r.edge_max, 2.0, 1e-12);
    assert_near(r.angle_min, 90.0, 1e-9);
    assert_int_equal(r.mixed_direction.count, 0);
    assert_int_equal(r.open_edge.count, 14);
    /* Whole, half and quarter cells, whichever way the diagonals run. */
    double area[20], vector[20][3];
    ss_mesh_node_areas(m, area);
    ss_mesh_node_area_vectors(m, vector);
    for (int i = 0; i < 20; ++i) {
        const bool is_end[2] = {i / 5 % 3 == 0, i % 5 % 4 == 0};
        const double cell = 2.0 * (is_end[0] ? 0.5 : 1.0) * (is_end[1] ? 0.5 : 1.0);
        assert_near(area[i], cell, 1e-14);
        assert_near(vector[i][2], cell, 1e-14);
    }
    ss_mesh_destroy(&m);
}

TEST(a_cylinder_faces_outward_with_u_along_its_axis)
{
    /* 24: diagonals mirror all round; 7: they cannot at one place, and nothing is refused. */
    const int32_t columns[] = {24, 7, 3};
    for (int k = 0; k < 3; ++k) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        assert_int_equal(ss_mesh_create_cylinder(15, columns[k], 1.0, 4.0, &m, &error), SOFTSIM_OK);
        assert_halves(m);
        assert_int_equal(m->quad_count, 14 * columns[k]);
        const ss_mesh_report r = report_of(m);
        assert_int_equal(r.mixed_direction.count, 0);
        assert_int_equal(r.open_edge.count, 2 * columns[k]);
        assert_int_equal(ss_mesh_accept(m, "cylinder", &error), SOFTSIM_OK);
        int32_t ends[15 * 24] = {0};
        for (int32_t q = 0; q < m->quad_count; ++q) {
            double u[3], across[3], normal[3];
            u_of(m, q, u);
            ss_sub3(across, m->position[m->quad[q][2]], m->position[m->quad[q][1]]);
            ss_cross3(normal, u, across);
            assert_near(u[2], 4.0 / 14.0, 1e-14);
            assert_near(u[0], 0.0, 1e-14);
            assert_true(ss_dot3(normal, m->position[m->quad[q][0]]) > 0.0);
            ++ends[m->triangle[2 * q][0]];
            ++ends[m->triangle[2 * q][2]];
        }
        for (int32_t i = columns[k]; i < 14 * columns[k] && columns[k] == 24; ++i) {
            assert_int_equal(ends[i], (i / 24 + i % 24) % 2 == 0 ? 4 : 0);
        }
        ss_mesh_destroy(&m);
    }
}

TEST(impossible_grids_are_refused)
{
    const struct {
        int32_t rows, columns;
        ss_mesh_closed closed;
    } bad[] = {{1, 5, SS_MESH_CLOSED_NONE},        {5, 1, SS_MESH_CLOSED_NONE},
               {2, 5, SS_MESH_CLOSED_ROWS},        {5, 2, SS_MESH_CLOSED_COLUMNS},
               {1001, 1000, SS_MESH_CLOSED_NONE},  {-4, -4, SS_MESH_CLOSED_NONE},
               {65536, 65537, SS_MESH_CLOSED_NONE}};
    for (int32_t i = 0; i < COUNT(bad); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        assert_int_equal(
            ss_mesh_create_grid(bad[i].rows, bad[i].columns, bad[i].closed, NULL, &m, &error),
            SOFTSIM_ERROR_ARGUMENT);
        assert_null(m);
        assert_int_equal(error.fault_count, 1);
        error = (softsim_error){0};
        assert_int_not_equal(
            ss_mesh_create_plane(bad[i].closed == SS_MESH_CLOSED_NONE ? bad[i].rows : 0,
                                 bad[i].columns, 1.0, 1.0, &m, &error),
            SOFTSIM_OK);
        assert_null(m);
    }
}

/* ---- directions ---- */

TEST(corners_written_in_any_turn_get_one_direction)
{
    ss_mesh *m = make_plane(9, 7);
    int32_t quad[48][4];
    uint64_t random = 1;
    for (int q = 0; q < 48; ++q) {
        const uint32_t turn = q == 0 ? 0 : ss_random_below(&random, 4);
        for (uint32_t k = 0; k < 4; ++k) {
            quad[q][k] = m->quad[q][(k + turn) % 4];
        }
    }
    ss_mesh *again = make(63, (const double(*)[3])m->position, 48, (const int32_t(*)[4])quad);
    assert_halves(again);
    assert_int_equal(report_of(again).mixed_direction.count, 0);
    for (int32_t q = 0; q < 48; ++q) {
        double u[3];
        u_of(again, q, u);
        assert_near(fabs(u[1]), 2.0, 1e-15);
    }
    assert_memory_equal(again->triangle, m->triangle, 96 * sizeof *m->triangle);
    /* The first quad's first side is u, whichever it is. */
    const int32_t first[4] = {quad[0][1], quad[0][2], quad[0][3], quad[0][0]};
    memcpy(quad[0], first, sizeof first);
    ss_mesh *across = make(63, (const double(*)[3])m->position, 48, (const int32_t(*)[4])quad);
    for (int32_t q = 0; q < 48; ++q) {
        double u[3];
        u_of(across, q, u);
        assert_near(fabs(u[0]), 1.0, 1e-15);
    }
    ss_mesh_destroy(&m);
    ss_mesh_destroy(&again);
    ss_mesh_destroy(&across);
}

/* Corner i of the unit cube has coordinates bit 0, bit 1, bit 2 of i. */
static const double cube_corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
static const int32_t cube_quad[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

TEST(a_cube_where_directions_cannot_agree_is_accepted_and_says_so)
{
    ss_mesh *m = make(8, cube_corner, 6, cube_quad);
    softsim_error error = {0};
    assert_halves(m);
    assert_true(m->is_closed);
    const ss_mesh_report r = report_of(m);
    /* At each corner three sides meet in pairs: at least one of them is mixed. Each side has two
     * corners, so that four are the least; a flood need not find these. */
    assert_true(r.mixed_direction.count >= 4 && r.mixed_direction.count < 12);
    assert_near(r.volume, 1.0, 1e-14);
    assert_near(r.area, 6.0, 1e-14);
    assert_int_equal(r.inconsistent_winding.count, 0);
    assert_int_equal(ss_mesh_accept(m, "cube", &error), SOFTSIM_OK);
    double area[8], vector[8][3];
    ss_mesh_node_areas(m, area);
    ss_mesh_node_area_vectors(m, vector);
    for (int i = 0; i < 8; ++i) {
        assert_near(area[i], 0.75, 1e-15);
        for (int k = 0; k < 3; ++k) {
            assert_near(vector[i][k], (i >> k & 1) != 0 ? 0.25 : -0.25, 1e-15);
        }
    }
    ss_mesh_destroy(&m);
}

/* ---- cutting ---- */

TEST(diagonals_stay_inside_and_off_flat_halves)
{
    /* A dart (reflex at node 1), and a triangle with a node in the middle of a side. */
    const double dart[4][3] = {{0, 0, 0}, {1, 0.2, 0}, {2, 0, 0}, {1, 2, 0}};
    const double split[4][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0.1, 1, 0}};
    const int32_t quad[1][4] = {{0, 1, 2, 3}};
    softsim_error error = {0};
    ss_mesh *m = make(4, dart, 1, quad);
    assert_true(is_cut_at(m, 0, 1, 3));
    assert_near(report_of(m).area, 0.5 * 2.0 * (2.0 - 0.2), 1e-15);
    assert_int_equal(ss_mesh_accept(m, "dart", &error), SOFTSIM_OK);
    ss_mesh_destroy(&m);
    m = make(4, split, 1, quad);
    assert_true(is_cut_at(m, 0, 1, 3));
    assert_int_equal(ss_mesh_accept(m, "split", &error), SOFTSIM_OK);
    ss_mesh_destroy(&m);
}

TEST(the_shorter_diagonal_cuts_where_no_grid_is)
{
    /* Three quads about node 0, a corner's fan: no structured part. */
    const double fan[7][3] = {{0, 0, 0},    {1, 0, 0},       {1, 1.5, 0},   {-0.5, 0.9, 0},
                              {-1.3, 0, 0}, {-0.5, -0.9, 0}, {0.8, -1.4, 0}};
    const int32_t quad[3][4] = {{0, 1, 2, 3}, {0, 3, 4, 5}, {0, 5, 6, 1}};
    ss_mesh *m = make(7, fan, 3, quad);
    assert_halves(m);
    for (int32_t q = 0; q < 3; ++q) {
        double d[2][3];
        ss_sub3(d[0], fan[quad[q][2]], fan[quad[q][0]]);
        ss_sub3(d[1], fan[quad[q][3]], fan[quad[q][1]]);
        const int s = ss_norm3(d[0]) < ss_norm3(d[1]) ? 0 : 1;
        assert_true(is_cut_at(m, q, quad[q][s], quad[q][s + 2]));
    }
    ss_mesh_destroy(&m);
    /* On a cube both are equal: that of the lowest node. */
    m = make(8, cube_corner, 6, cube_quad);
    for (int32_t q = 0; q < 6; ++q) {
        int32_t low = 8;
        for (int k = 0; k < 4; ++k) {
            low = m->quad[q][k] < low ? m->quad[q][k] : low;
        }
        assert_int_equal(m->triangle[2 * q][0], low);
    }
    ss_mesh_destroy(&m);
}

TEST(areas_of_a_warped_quad_do_not_depend_on_the_diagonal)
{
    const double x[4][3] = {{0, 0, 0}, {1, 0, 0.3}, {1.1, 1, 0}, {0, 0.9, 0.4}};
    const int32_t quads[2][1][4] = {{{0, 1, 2, 3}}, {{1, 2, 3, 0}}};
    double expected[4] = {0};
    double total = 0.0;
    for (int cut = 0; cut < 2; ++cut) {
        for (int half = 0; half < 2; ++half) {
            const int n[3] = {cut + 2 * half, cut + 2 * half + 1, (cut + 2 * half + 2) % 4};
            double u[3], v[3], a[3];
            ss_sub3(u, x[n[1] % 4], x[n[0]]);
            ss_sub3(v, x[n[2]], x[n[0]]);
            ss_cross3(a, u, v);
            for (int k = 0; k < 3; ++k) {
                expected[n[k] % 4] += 0.5 * 0.5 * ss_norm3(a) / 3.0;
            }
            total += 0.25 * ss_norm3(a);
        }
    }
    for (int i = 0; i < 2; ++i) {
        ss_mesh *m = make(4, x, 1, quads[i]);
        double area[4];
        ss_mesh_node_areas(m, area);
        for (int k = 0; k < 4; ++k) {
            assert_near(area[k], expected[k], 1e-15);
        }
        assert_near(report_of(m).area, total, 1e-15);
        ss_mesh_destroy(&m);
    }
}

/* ---- faults ---- */

TEST(faults_of_quads_are_named)
{
    const double far = 3.0;
    const double x[8][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                            {1, 1, 0}, {2, 1, 0}, {1, 2, 0}, {far, 0, 0}};
    const struct {
        int32_t count, quad[4][4];
        const char *says;
        size_t fault;
        int32_t number;
    } bad[] = {
        {2,
         {{0, 1, 4, 3}, {1, 2, 5, 99}},
         "nodes that do not exist: 1 (element 1)",
         offsetof(ss_mesh_report, bad_index),
         1},
        {2,
         {{0, 1, 4, 3}, {1, 2, 5, 5}},
         "flat or half flat: 1 (quad 1)",
         offsetof(ss_mesh_report, zero_area),
         1},
        {2,
         {{0, 1, 4, 3}, {0, 1, 2, 7}},
         "flat or half flat: 1 (quad 1)",
         offsetof(ss_mesh_report, zero_area),
         1},
        {3,
         {{0, 1, 4, 3}, {1, 2, 5, 4}, {4, 5, 2, 1}},
         "duplicate quads: 1 (quad 2)",
         offsetof(ss_mesh_report, duplicate_triangle),
         2},
        {2,
         {{0, 1, 4, 3}, {1, 4, 5, 2}},
         "two quads are wound against each other: 1 (at node 1)",
         offsetof(ss_mesh_report, inconsistent_winding),
         1},
        {3,
         {{0, 1, 4, 3}, {1, 2, 5, 4}, {1, 4, 6, 7}},
         "edges of more than two quads",
         offsetof(ss_mesh_report, non_manifold_edge),
         1},
    };
    for (int32_t i = 0; i < COUNT(bad); ++i) {
        ss_mesh *m = make(8, x, bad[i].count, bad[i].quad);
        softsim_error error = {0};
        const ss_mesh_report r = report_of(m);
        const ss_mesh_fault *fault =
            (const ss_mesh_fault *)(const void *)((const char *)&r + bad[i].fault);
        assert_int_equal(ss_mesh_accept(m, "bad", &error), SOFTSIM_ERROR_MESH);
        if (strstr(error.text, bad[i].says) == NULL) {
            fail_msg("%d: %s", i, error.text);
        }
        assert_int_equal(fault->count, 1);
        assert_int_equal(fault->first[0], bad[i].number);
        double area[8], vector[8][3];
        ss_mesh_node_areas(m, area);
        ss_mesh_node_area_vectors(m, vector);
        assert_true(ss_mesh_orient(m) >= 0);
        ss_mesh_destroy(&m);
    }
    ss_mesh *m = NULL;
    assert_int_not_equal(ss_mesh_create_quads(0, x, 1, cube_quad, &m, NULL), SOFTSIM_OK);
    assert_int_not_equal(ss_mesh_create_quads(8, x, 0, cube_quad, &m, NULL), SOFTSIM_OK);
}

TEST(turned_quads_are_turned_back_whole)
{
    for (int is_cube = 0; is_cube < 2; ++is_cube) {
        ss_mesh *m = is_cube ? make(8, cube_corner, 6, cube_quad) : make_plane(6, 6);
        int32_t quad[25][4];
        int32_t turned = 0;
        for (int32_t q = 0; q < m->quad_count; ++q) {
            const bool is_turned = is_cube || q % 3 == 1;
            for (int k = 0; k < 4; ++k) {
                quad[q][k] = m->quad[q][is_turned ? 3 - k : k];
            }
            turned += is_turned ? 2 : 0;
        }
        ss_mesh *spoilt = make(m->node_count, (const double(*)[3])m->position, m->quad_count,
                               (const int32_t(*)[4])quad);
        assert_int_equal(report_of(spoilt).inconsistent_winding.count > 0, !is_cube);
        assert_int_equal(report_of(spoilt).is_inside_out, is_cube);
        assert_int_equal(ss_mesh_orient(spoilt), turned);
        assert_halves(spoilt);
        const ss_mesh_report r = report_of(spoilt);
        assert_int_equal(r.inconsistent_winding.count, 0);
        assert_false(r.is_inside_out);
        assert_int_equal(r.mixed_direction.count, report_of(m).mixed_direction.count);
        assert_int_equal(ss_mesh_orient(spoilt), 0);
        if (!is_cube) {
            double u[3];
            for (int32_t q = 0; q < m->quad_count; ++q) {
                u_of(spoilt, q, u);
                assert_near(fabs(u[1]), 2.0, 1e-15);
                assert_true(is_cut_at(spoilt, q, m->triangle[2 * q][0], m->triangle[2 * q][2]));
            }
        }
        ss_mesh_destroy(&spoilt);
        ss_mesh_destroy(&m);
    }
}

/* ---- files ---- */

TEST(quads_come_back_from_disk_as_they_were)
{
    static const double turn[3] = {10, 20, 30};
    ss_mesh *m = NULL;
    assert_int_equal(ss_mesh_create_cylinder(5, 8, 1.0, 3.0, &m, NULL), SOFTSIM_OK);
    ss_mesh_transform(m, 0.7, turn, none);
    const char *const names[] = {in_folder("quads.obj"), in_folder("quads.msh")};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(i == 0 ? ss_mesh_write_obj(m, names[i], NULL)
                                : ss_mesh_write_msh(m, names[i], NULL),
                         SOFTSIM_OK);
        ss_mesh *again = load(names[i], 1.0);
        assert_int_equal(again->node_count, m->node_count);
        assert_int_equal(again->quad_count, m->quad_count);
        assert_int_equal(again->cut_face_count, 0);
        assert_memory_equal(again->quad, m->quad, (size_t)m->quad_count * sizeof *m->quad);
        assert_memory_equal(again->triangle, m->triangle,
                            (size_t)m->triangle_count * sizeof *m->triangle);
        for (int32_t n = 0; n < m->node_count; ++n) {
            for (int k = 0; k < 3; ++k) {
                assert_near(again->position[n][k], m->position[n][k], i == 0 ? 1e-8 : 0.0);
            }
        }
        ss_mesh_destroy(&again);
    }
    ss_mesh_destroy(&m);
}

#define NODES                                                                                      \
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0.5 2 0\nv 1.5 2 0\nv 9 9 9\n"

TEST(only_surfaces_of_quads_alone_keep_them)
{
    static const struct {
        const char *text;
        int32_t quads, triangles, cut;
    } files[] = {
        {NODES "f 1 2 5 4\nf 2 3 6 5\n", 2, 4, 0},
        {NODES "f 1 2 5 4\nf 2 3 6 5\nl 1 2\np 3\n", 2, 4, 0},
        {NODES "f 1 2 5 4\nf 2 3 6\nf 2 6 5\n", 0, 4, 1},
        {NODES "f 1 2 5 4\nf 2 3 6 5\nf 4 5 6 8 7\n", 0, 7, 3},
        {NODES "f 1 2 5\nf 1 5 4\n", 0, 2, 0},
    };
    for (int32_t i = 0; i < COUNT(files); ++i) {
        ss_mesh *m = load(write_text("mixed.obj", files[i].text), 1.0);
        assert_int_equal(m->quad_count, files[i].quads);
        assert_int_equal(m->triangle_count, files[i].triangles);
        assert_int_equal(m->cut_face_count, files[i].cut);
        if (files[i].quads > 0) {
            const int32_t expected[2][4] = {{0, 1, 4, 3}, {1, 2, 5, 4}};
            assert_memory_equal(m->quad[0], expected[0], sizeof expected[0]);
            assert_memory_equal(m->quad[1], expected[1], sizeof expected[1]);
            assert_int_equal(m->node_count, 6);
        }
        ss_mesh_destroy(&m);
    }
}

#define MSH                                                                                        \
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n11 0 0 0\n12 1 0 0\n13 2 0 0\n14 0 1 0\n"    \
    "15 1 1 0\n16 2 1 0\n$EndNodes\n$Elements\n"

TEST(msh_quads_carry_groups_and_mix_with_triangles)
{
    static const struct {
        const char *text;
        int32_t quads, triangles, cut, group;
    } files[] = {
        {MSH "3\n1 1 2 3 0 11 12\n2 3 2 7 0 11 12 15 14\n3 3 2 0 0 12 13 16 15\n$EndElements\n", 2,
         4, 0, 2},
        {MSH "3\n1 2 2 0 0 12 13 16\n2 3 2 7 0 11 12 15 14\n3 2 2 0 0 12 16 15\n$EndElements\n", 0,
         4, 1, 1},
    };
    for (int32_t i = 0; i < COUNT(files); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        if (ss_mesh_read_msh(files[i].text, strlen(files[i].text), "q", 1.0, &m, &error) !=
            SOFTSIM_OK) {
            fail_msg("%s", error.text);
        }
        assert_int_equal(m->quad_count, files[i].quads);
        assert_int_equal(m->triangle_count, files[i].triangles);
        assert_int_equal(m->cut_face_count, files[i].cut);
        assert_int_equal(m->group_count, files[i].group);
        const ss_mesh_group *group = &m->group[m->group_count - 1];
        const int32_t nodes[4] = {0, 1, 3, 4};
        assert_string_equal(group->name, "surface-7");
        assert_int_equal(group->node_count, 4);
        assert_memory_equal(group->node, nodes, sizeof nodes);
        if (files[i].cut > 0) {
            /* In the file's order, the quad's halves in its place. */
            assert_true(m->triangle[0][0] == 1 && m->triangle[3][1] == 5);
            assert_int_equal(ss_mesh_accept(m, "mixed", &error), SOFTSIM_OK);
        }
        ss_mesh_destroy(&m);
    }
    static const char bad[] = MSH "1\n1 3 2 0 0 11 12 15\n$EndElements\n";
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_read_msh(bad, sizeof bad - 1, "q", 1.0, &m, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "q:15: element 0, a quadrangle"));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
