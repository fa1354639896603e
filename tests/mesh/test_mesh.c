/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Meshes in memory: surfaces of volumes, measures, the checks and the MSH reader. */
#include "mesh/mesh.h"

#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/mesh_fixture.h"

static const double no_turn[3] = {0.0, 0.0, 0.0};

/* ---- solids ---- */

/* Corner i of the unit cube has coordinates bit 0, bit 1, bit 2 of i. */
static const double cube_corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
/* Kuhn's six tetrahedra about the diagonal 0-7, all of positive volume. */
static const int32_t cube_tetrahedron[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                               {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

static ss_mesh *make_cube(void)
{
    return make_mesh(8, cube_corner, 0, NULL, 6, cube_tetrahedron);
}

/* The same cube as a surface: nodes and triangles in arrays that a test may spoil. */
typedef struct soup {
    double x[32][3];
    int32_t triangle[48][3];
    int32_t nodes, triangles;
} soup;

static void cube_soup(soup *s)
{
    ss_mesh *cube = make_cube();
    memset(s, 0, sizeof *s);
    memcpy(s->x, cube_corner, sizeof cube_corner);
    memcpy(s->triangle, cube->triangle, (size_t)cube->triangle_count * sizeof s->triangle[0]);
    s->nodes = 8;
    s->triangles = cube->triangle_count;
    ss_mesh_destroy(&cube);
}

/* Appends a copy, scaled about the cube's centre and moved; turned inside out on demand. */
static void add_cube(soup *s, double scale, const double move[3], bool is_turned)
{
    soup other;
    cube_soup(&other);
    for (int32_t i = 0; i < other.nodes; ++i) {
        for (int k = 0; k < 3; ++k) {
            s->x[s->nodes + i][k] = 0.5 + scale * (other.x[i][k] - 0.5) + move[k];
        }
    }
    for (int32_t t = 0; t < other.triangles; ++t) {
        for (int k = 0; k < 3; ++k) {
            s->triangle[s->triangles][is_turned ? 2 - k : k] = s->nodes + other.triangle[t][k];
        }
        ++s->triangles;
    }
    s->nodes += other.nodes;
}

static ss_mesh *make_soup(const soup *s)
{
    return make_mesh(s->nodes, s->x, s->triangles, s->triangle, 0, NULL);
}

TEST(surface_of_a_tetrahedron_points_outward_even_when_it_is_inverted)
{
    const double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int32_t both[2][1][4] = {{{0, 1, 2, 3}}, {{0, 2, 1, 3}}};
    for (int i = 0; i < 2; ++i) {
        ss_mesh *mesh = make_mesh(4, x, 0, NULL, 1, both[i]);
        ss_mesh_report report;
        assert_int_equal(ss_mesh_check(mesh, &report), SOFTSIM_OK);
        assert_int_equal(mesh->triangle_count, 4);
        assert_true(mesh->is_closed);
        assert_near(report.volume, 1.0 / 6.0, 1e-15);
        assert_int_equal(report.inverted_tetrahedron.count, i);
        assert_false(report.is_inside_out);
        ss_mesh_destroy(&mesh);
        assert_null(mesh);
    }
}

TEST(cube_of_six_tetrahedra_has_the_measures_of_a_cube)
{
    ss_mesh *mesh = make_cube();
    ss_mesh_report r;
    assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
    assert_int_equal(mesh->triangle_count, 12);
    assert_near(r.volume, 1.0, 1e-14);
    assert_near(r.area, 6.0, 1e-14);
    assert_near(r.edge_min, 1.0, 1e-15);
    assert_near(r.edge_max, sqrt(3.0), 1e-15); /* the inner diagonal counts */
    assert_near(r.edge_mean, (12.0 + 6.0 * sqrt(2.0) + sqrt(3.0)) / 19.0, 1e-14);
    assert_near(r.angle_min, 45.0, 1e-12);
    assert_int_equal(r.component_count, 1);
    assert_near(ss_mesh_diagonal(mesh), sqrt(3.0), 1e-15);
    softsim_error error = {0};
    assert_int_equal(ss_mesh_accept(mesh, "cube", &error), SOFTSIM_OK);
    assert_int_equal(error.fault_count, 0);
    ss_mesh_destroy(&mesh);
}

TEST(node_areas_sum_to_the_area_and_their_vectors_to_nothing)
{
    ss_mesh *mesh = make_cube();
    double area[8], vector[8][3];
    double sum = 0.0;
    double total[3] = {0.0, 0.0, 0.0};
    ss_mesh_node_areas(mesh, area);
    ss_mesh_node_area_vectors(mesh, vector);
    for (int i = 0; i < 8; ++i) {
        sum += area[i];
        ss_add3(total, total, vector[i]);
        /* Outward: away from the cube's centre. */
        double out[3];
        ss_set3(out, cube_corner[i][0] - 0.5, cube_corner[i][1] - 0.5, cube_corner[i][2] - 0.5);
        assert_true(ss_dot3(vector[i], out) > 0.0);
    }
    assert_near(sum, 6.0, 1e-14);
    assert_near(ss_norm3(total), 0.0, 1e-15);
    ss_mesh_destroy(&mesh);
}

TEST(transform_scales_then_turns_about_world_x_y_z_then_moves)
{
    const double x[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int32_t triangle[1][3] = {{0, 1, 2}};
    ss_mesh *mesh = make_mesh(3, x, 1, triangle, 0, NULL);
    const double turn[3] = {90.0, 90.0, 0.0};
    const double move[3] = {10.0, 20.0, 30.0};
    ss_mesh_transform(mesh, 2.0, turn, move);
    /* x -> x -> -z; y -> z -> x; z -> -y -> -y. */
    const double expected[3][3] = {{10, 20, 28}, {12, 20, 30}, {10, 18, 30}};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            assert_near(mesh->position[i][k], expected[i][k], 1e-14);
        }
    }
    ss_mesh_destroy(&mesh);
}

TEST(create_refuses_counts_that_make_no_mesh)
{
    const int32_t triangle[1][3] = {{0, 1, 2}};
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    assert_int_not_equal(ss_mesh_create(0, NULL, 1, triangle, 0, NULL, &mesh, &error), SOFTSIM_OK);
    assert_int_not_equal(ss_mesh_create(-3, NULL, 1, triangle, 0, NULL, &mesh, &error), SOFTSIM_OK);
    assert_int_not_equal(ss_mesh_create(8, cube_corner, 0, NULL, 0, NULL, &mesh, NULL), SOFTSIM_OK);
    assert_null(mesh);
    assert_int_equal(error.fault_count, 2);
}

/* ---- planted faults ---- */

static void plant_nothing(soup *s)
{
    (void)s;
}
static void plant_nan(soup *s)
{
    s->x[3][1] = NAN;
}
static void plant_bad_index(soup *s)
{
    s->triangle[5][2] = 8;
    s->triangle[7][0] = -1;
}
static void plant_flat(soup *s)
{
    /* A node in the middle of an edge, and the triangle of the three. */
    ss_set3(s->x[s->nodes], 0.5, 0.0, 0.0);
    memcpy(s->triangle[s->triangles++], (int32_t[3]){0, s->nodes, 1}, sizeof s->triangle[0]);
    ++s->nodes;
}
static void plant_repeated_node(soup *s)
{
    memcpy(s->triangle[s->triangles++], (int32_t[3]){2, 2, 3}, sizeof s->triangle[0]);
}
static void plant_duplicate(soup *s)
{
    const int32_t *t = s->triangle[4];
    memcpy(s->triangle[s->triangles++], (int32_t[3]){t[2], t[1], t[0]}, sizeof s->triangle[0]);
}
static void plant_loose(soup *s)
{
    ss_set3(s->x[s->nodes++], 3.0, 3.0, 3.0);
}
static void plant_coincident(soup *s)
{
    add_cube(s, 1.0, (double[3]){1.0 + 1e-9, 0.0, 0.0}, false);
}
static void plant_short_edge(soup *s)
{
    ss_set3(s->x[7], 1.0, 1.0, 5e-4);
}
static void plant_fin(soup *s)
{
    ss_set3(s->x[s->nodes], 2.0, 2.0, 0.5);
    memcpy(s->triangle[s->triangles++], (int32_t[3]){1, s->nodes, 3}, sizeof s->triangle[0]);
    ++s->nodes;
}
static void plant_hole(soup *s)
{
    --s->triangles;
}
static void plant_turned_triangle(soup *s)
{
    const int32_t first = s->triangle[2][0];
    s->triangle[2][0] = s->triangle[2][1];
    s->triangle[2][1] = first;
}
static void plant_inside_out(soup *s)
{
    for (int32_t t = 0; t < s->triangles; ++t) {
        const int32_t first = s->triangle[t][0];
        s->triangle[t][0] = s->triangle[t][1];
        s->triangle[t][1] = first;
    }
}
static void plant_point_contact(soup *s)
{
    /* A second cube that shares the corner 7 with the first. */
    add_cube(s, 1.0, (double[3]){1.0, 1.0, 1.0}, false);
    for (int32_t t = 12; t < 24; ++t) {
        for (int k = 0; k < 3; ++k) {
            s->triangle[t][k] =
                s->triangle[t][k] == 8 ? 7 : s->triangle[t][k] - (s->triangle[t][k] > 8);
        }
    }
    memmove(&s->x[8], &s->x[9], 7 * sizeof s->x[0]);
    --s->nodes;
}
static void plant_cavity(soup *s)
{
    add_cube(s, 0.5, (double[3]){0.0, 0.0, 0.0}, true);
}
static void plant_turned_neighbour(soup *s)
{
    add_cube(s, 0.5, (double[3]){3.0, 0.0, 0.0}, true);
}

#define FIELD(name) offsetof(ss_mesh_report, name)

static const struct {
    const char *name;
    void (*plant)(soup *s);
    bool has_field;
    size_t field;
    int64_t count;
    int32_t first;
    softsim_status status;
    const char *says; /* of ss_mesh_accept */
} faults[] = {
    {"nothing", plant_nothing, false, 0, 0, 0, SOFTSIM_OK, ""},
    {"nan", plant_nan, true, FIELD(non_finite), 1, 3, SOFTSIM_ERROR_MESH, "not finite: 1 (node 3)"},
    {"bad index", plant_bad_index, true, FIELD(bad_index), 2, 5, SOFTSIM_ERROR_MESH,
     "do not exist: 2 (element 5, 7)"},
    {"flat", plant_flat, true, FIELD(zero_area), 1, 12, SOFTSIM_ERROR_MESH, "flat triangles: 1"},
    {"repeated", plant_repeated_node, true, FIELD(zero_area), 1, 12, SOFTSIM_ERROR_MESH,
     "flat triangles: 1 (triangle 12)"},
    {"duplicate", plant_duplicate, true, FIELD(duplicate_triangle), 1, 12, SOFTSIM_ERROR_MESH,
     "duplicate triangles: 1 (triangle 12)"},
    {"loose", plant_loose, true, FIELD(loose_node), 1, 8, SOFTSIM_ERROR_MESH,
     "without an element: 1 (node 8)"},
    {"coincident", plant_coincident, true, FIELD(coincident_node), 4, 8, SOFTSIM_ERROR_MESH,
     "on top of others: 4"},
    {"short edge", plant_short_edge, true, FIELD(short_edge), 1, 3, SOFTSIM_ERROR_MESH,
     "shorter than 1/1000 of the mean: 1"},
    {"fin", plant_fin, true, FIELD(non_manifold_edge), 1, 1, SOFTSIM_ERROR_MESH,
     "more than two triangles: 1 (at node 1)"},
    {"hole", plant_hole, true, FIELD(open_edge), 3, -1, SOFTSIM_OK, ""},
    {"turned triangle", plant_turned_triangle, true, FIELD(inconsistent_winding), 3, -1,
     SOFTSIM_ERROR_MESH, "wound against each other: 3"},
    {"inside out", plant_inside_out, false, 0, 0, 0, SOFTSIM_ERROR_MESH, "inside out"},
    {"point contact", plant_point_contact, true, FIELD(non_manifold_node), 1, 7, SOFTSIM_ERROR_MESH,
     "in a point only: 1 (node 7)"},
    {"cavity", plant_cavity, false, 0, 0, 0, SOFTSIM_OK, ""},
    {"turned neighbour", plant_turned_neighbour, false, 0, 0, 0, SOFTSIM_ERROR_MESH, "inside out"},
};

TEST(each_planted_fault_is_found_counted_and_judged_at_any_scale)
{
    const double scales[] = {1.0, 1e-3, 1e3};
    for (int32_t i = 0; i < COUNT(faults); ++i) {
        for (int s = 0; s < 3; ++s) {
            soup planted;
            ss_mesh_report r;
            softsim_error error = {0};
            cube_soup(&planted);
            faults[i].plant(&planted);
            ss_mesh *mesh = make_soup(&planted);
            ss_mesh_transform(mesh, scales[s], no_turn, (double[3]){1.0 * scales[s], 0.0, 0.0});
            assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
            if (faults[i].has_field) {
                ss_mesh_fault found;
                memcpy(&found, (const char *)&r + faults[i].field, sizeof found);
                if (found.count != faults[i].count ||
                    (faults[i].first >= 0 && found.first[0] != faults[i].first)) {
                    fail_msg("%s at %g: %d found, the first %d", faults[i].name, scales[s],
                             (int)found.count, found.first[0]);
                }
            }
            if (ss_mesh_accept(mesh, "x.obj", &error) != faults[i].status ||
                strstr(error.text, faults[i].says) == NULL) {
                fail_msg("%s at %g: %s", faults[i].name, scales[s], error.text);
            }
            ss_mesh_destroy(&mesh);
        }
    }
}

TEST(faults_of_tetrahedra_are_found)
{
    /* Two on one face is fine, three are not; the second is there twice; the last is flat. */
    const double x[7][3] = {{0, 0, 0},  {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                            {0, 0, -1}, {1, 1, 2}, {1, 1, 0}};
    const int32_t e[5][4] = {{0, 1, 2, 3}, {0, 2, 1, 4}, {2, 0, 1, 4}, {0, 1, 2, 5}, {0, 1, 6, 2}};
    ss_mesh *mesh = make_mesh(7, x, 0, NULL, 5, e);
    ss_mesh_report r;
    assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
    assert_int_equal(r.crowded_face.count, 1);
    assert_int_equal(r.crowded_face.first[0], 0);
    assert_int_equal(r.duplicate_tetrahedron.count, 1);
    assert_int_equal(r.duplicate_tetrahedron.first[0], 2);
    assert_int_equal(r.inverted_tetrahedron.count, 1); /* 2 is also turned */
    assert_int_equal(r.inverted_tetrahedron.first[0], 2);
    assert_int_equal(r.flat_tetrahedron.count, 1);
    assert_int_equal(r.flat_tetrahedron.first[0], 4);
    ss_mesh_destroy(&mesh);
}

TEST(a_body_of_kilometres_or_nanometres_is_refused_for_its_units)
{
    const double scales[] = {1e-9, 1e6};
    for (int i = 0; i < 2; ++i) {
        ss_mesh *mesh = make_cube();
        softsim_error error = {0};
        ss_mesh_transform(mesh, scales[i], no_turn, no_turn);
        assert_int_equal(ss_mesh_accept(mesh, "x.msh", &error), SOFTSIM_ERROR_MESH);
        assert_non_null(strstr(error.text, "units"));
        ss_mesh_destroy(&mesh);
    }
}

TEST(checking_survives_positions_at_the_ends_of_double)
{
    const double extremes[] = {1e308, -1e308, 5e-324, 0.0, -0.0, 1e-300};
    for (int i = 0; i < COUNT(extremes); ++i) {
        soup s;
        cube_soup(&s);
        s.x[2][0] = extremes[i];
        s.x[6][2] = -extremes[i];
        ss_mesh *mesh = make_soup(&s);
        ss_mesh_report r;
        assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
        ss_mesh_destroy(&mesh);
    }
}

/* ---- winding ---- */

TEST(orient_turns_what_is_wrong_and_nothing_else)
{
    soup s;
    cube_soup(&s);
    plant_cavity(&s);
    add_cube(&s, 1.0, (double[3]){5.0, 0.0, 0.0}, true);
    ss_mesh *good = make_soup(&s);
    assert_int_equal(ss_mesh_orient(good), 12); /* the third cube; the cavity stays */
    ss_mesh_report r;
    (void)ss_mesh_check(good, &r);
    assert_int_equal(r.inconsistent_winding.count, 0);
    assert_false(r.is_inside_out);
    assert_near(r.volume, 1.0 - 0.125 + 1.0, 1e-12);
    assert_int_equal(ss_mesh_orient(good), 0);

    /* Any scrambling comes back to the same windings; the seed is fixed. */
    uint64_t random = 12345;
    for (int round = 0; round < 50; ++round) {
        soup scrambled;
        cube_soup(&scrambled);
        for (int32_t t = 0; t < scrambled.triangles; ++t) {
            if (ss_random_below(&random, 2) != 0) {
                const int32_t first = scrambled.triangle[t][0];
                scrambled.triangle[t][0] = scrambled.triangle[t][1];
                scrambled.triangle[t][1] = first;
            }
        }
        ss_mesh *mesh = make_soup(&scrambled);
        (void)ss_mesh_orient(mesh);
        (void)ss_mesh_check(mesh, &r);
        assert_int_equal(r.inconsistent_winding.count, 0);
        assert_near(r.volume, 1.0, 1e-12);
        ss_mesh_destroy(&mesh);
    }
    ss_mesh_destroy(&good);
}

TEST(an_open_sheet_keeps_the_sense_of_most_of_its_triangles)
{
    soup s;
    cube_soup(&s);
    plant_hole(&s);
    plant_turned_triangle(&s);
    ss_mesh *mesh = make_soup(&s);
    assert_int_equal(ss_mesh_orient(mesh), 1);
    ss_mesh_destroy(&mesh);
}

/* ---- MSH ---- */

/* Tags with gaps and out of order, Windows line ends, points and lines, groups, sections of no
 * interest, no newline at the end. */
static const char volume_text[] = "$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n"
                                  "$Comments\r\nanything $Nodes 5\r\n$EndComments\r\n"
                                  "$PhysicalNames\r\n3\r\n3 1 \"soft tissue\"\r\n2 2 \"skin\"\r\n"
                                  "0 9 \"pin\"\r\n$EndPhysicalNames\r\n"
                                  "$Nodes\r\n5\r\n"
                                  "70 0 0 0\r\n"
                                  "\r\n"
                                  "5 1 0 0\r\n"
                                  "9 0 1.0e0 0\r\n"
                                  "  1000000 0 0 1 \r\n"
                                  "6\t0.1 0.1 -1\r\n"
                                  "$EndNodes\r\n$Elements\r\n6\r\n"
                                  "1 15 2 9 1 6\r\n"
                                  "2 1 2 0 1 70 5\r\n"
                                  "3 2 2 2 7 70 5 9\r\n"
                                  "4 2 3 5 7 1 5 9 1000000\r\n"
                                  "17 4 2 1 1 70 5 9 1000000\r\n"
                                  "18 4 2 1 1 70 9 5 6\r\n"
                                  "$EndElements";

static const char surface_text[] =
    "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n"
    "$ELM\n4\n1 2 7 1 3 1 3 2\n2 2 7 1 3 1 2 4\n3 2 0 1 3 2 3 4\n4 2 0 1 3 3 1 4\n$ENDELM\n";

static softsim_status read_text(const char *text, size_t size, double unit, ss_mesh **out,
                                softsim_error *error)
{
    /* An exact copy on the heap, so that a sanitizer sees one byte too many being read. */
    char *copy = malloc(size > 0 ? size : 1);
    assert_non_null(copy);
    memcpy(copy, text, size);
    const softsim_status status = ss_mesh_read_msh(copy, size, "t.msh", unit, out, error);
    free(copy);
    return status;
}

TEST(msh_keeps_file_order_and_maps_tags_groups_and_units)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    if (read_text(volume_text, sizeof volume_text - 1, 0.001, &m, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(m->node_count, 5);
    assert_int_equal(m->tetrahedron_count, 2);
    assert_int_equal(m->triangle_count, 6); /* of the tetrahedra, not the file's two */
    assert_true(m->is_closed);
    assert_near(m->position[1][0], 0.001, 0.0);
    assert_near(m->position[4][2], -0.001, 0.0);
    const int32_t expected[2][4] = {{0, 1, 2, 3}, {0, 2, 1, 4}};
    assert_memory_equal(m->tetrahedron, expected, sizeof expected);
    assert_int_equal(m->group_count, 4);
    const struct {
        const char *name;
        int32_t count, node[5];
    } groups[] = {{"pin", 1, {4}},
                  {"skin", 3, {0, 1, 2}},
                  {"surface-5", 3, {1, 2, 3}},
                  {"soft tissue", 5, {0, 1, 2, 3, 4}}};
    for (int g = 0; g < 4; ++g) {
        assert_string_equal(m->group[g].name, groups[g].name);
        assert_int_equal(m->group[g].node_count, groups[g].count);
        assert_memory_equal(m->group[g].node, groups[g].node,
                            (size_t)groups[g].count * sizeof(int32_t));
    }
    ss_mesh_destroy(&m);
}

TEST(msh_version_1_and_surfaces_are_read)
{
    ss_mesh *m = NULL;
    ss_mesh_report r;
    softsim_error error = {0};
    assert_int_equal(read_text(surface_text, sizeof surface_text - 1, 1.0, &m, &error), SOFTSIM_OK);
    assert_int_equal(m->node_count, 4);
    assert_int_equal(m->triangle_count, 4);
    assert_int_equal(m->tetrahedron_count, 0);
    assert_int_equal(m->group_count, 1);
    assert_string_equal(m->group[0].name, "surface-7");
    assert_int_equal(m->group[0].node_count, 4);
    (void)ss_mesh_check(m, &r);
    assert_near(r.volume, 1.0 / 6.0, 1e-15);
    ss_mesh_destroy(&m);
}

TEST(groups_of_one_name_are_one_group)
{
    static const char text[] =
        "$MeshFormat\n2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"a\"\n2 2 \"a\"\n"
        "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n"
        "$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 2 1 2 4 3\n$EndElements\n";
    ss_mesh *m = NULL;
    assert_int_equal(read_text(text, sizeof text - 1, 1.0, &m, NULL), SOFTSIM_OK);
    assert_int_equal(m->group_count, 1);
    assert_int_equal(m->group[0].node_count, 4);
    ss_mesh_destroy(&m);
}

#define HEAD  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define NODES HEAD "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n"

static const says_row bad_texts[] = {
    {"", "no section of elements"},
    {"$", "has no end"},
    {"hello\n", "t.msh:1: a section"},
    {"$MeshFormat\n4 0 8\n$EndMeshFormat\n",
     "t.msh:2: Gmsh format 4 is not read: write the mesh as version 2.2"},
    {"$MeshFormat\n2.2 1 8\n$EndMeshFormat\n", "Gmsh format 2.2 binary is not read"},
    {"$Nodes\n1\n1 0 0 0\n$EndNodes\n", "$MeshFormat is missing"},
    {HEAD "$NOD\n1\n1 0 0 0\n$ENDNOD\n", "does not belong to a file of version 2"},
    {HEAD "$Nodes\n2000000000\n1 0 0 0\n$EndNodes\n", "t.msh:5: 2000000000 nodes announced"},
    {HEAD "$Nodes\n99999999999999999999\n", "t.msh:5: the number of nodes expected"},
    {HEAD "$Nodes\n-1\n$EndNodes\n", "the number of nodes expected"},
    {HEAD "$Nodes\n3\n1 0 0 0\n2 0 0 1\n$EndNodes\n$Elements\n", "t.msh:8: node 2:"},
    {HEAD "$Nodes\n1\n1 0 0 0\n2 0 0 1\n$EndNodes\n", "t.msh:7: $EndNodes expected here"},
    {HEAD "$Nodes\n1\n1 0 nan 0\n$EndNodes\n", "t.msh:6: node 0: its position is not finite"},
    {HEAD "$Nodes\n1\n1 0 1e999 0\n$EndNodes\n", "t.msh:6: node 0: its position is not finite"},
    {HEAD "$Nodes\n1\n1 0 0\n$EndNodes\n", "t.msh:6: node 0: its number"},
    {HEAD "$Nodes\n1\n1 0 0 0 0\n$EndNodes\n", "t.msh:6: node 0: its number"},
    {HEAD "$Nodes\n1\n0 0 0 0\n$EndNodes\n", "1 or more"},
    {HEAD "$Nodes\n1\n1 0 0x 0\n$EndNodes\n", "t.msh:6: node 0"},
    {HEAD "$Nodes\n2\n7 0 0 0\n7 1 0 0\n$EndNodes\n$Elements\n1\n1 15 0 7\n$EndElements\n",
     "t.msh:7: node number 7 is on line 6 already"},
    {NODES "$Elements\n1\n1 2 2 0 0 1 2 4\n$EndElements\n",
     "t.msh:12: element 0: there is no node number 4"},
    {NODES "$Elements\n1\n1 2 2 0 0 1 2 -3\n$EndElements\n", "there is no node number -3"},
    {NODES "$Elements\n1\n1 2 2 0 0 1 2\n$EndElements\n", "t.msh:12: element 0, a triangle"},
    {NODES "$Elements\n1\n1 2 2 0 0 1 2 3 3\n$EndElements\n", "t.msh:12: element 0, a triangle"},
    {NODES "$Elements\n1\n1 2 -5 1 2 3\n$EndElements\n", "t.msh:12: element 0, a triangle"},
    {NODES "$Elements\n1\n1 2 2000000000 1 2 3\n$EndElements\n", "t.msh:12: element 0, a triangle"},
    {NODES "$Elements\n1\n1 5 2 0 0 1 2 3 1 1 2 3 1\n$EndElements\n",
     "t.msh:12: a hexahedron that has no volume"},
    {NODES "$Elements\n1\n1 17 2 0 0 1 2 3 1 1 2 3 1\n$EndElements\n",
     "element 0 (line 12) is of type 17 (second-order hexahedron): write"},
    {NODES "$Elements\n1\n1 11 2 0 0 1 2 3 1\n$EndElements\n", "second-order tetrahedron"},
    {NODES "$Elements\n1\n1 1 2 0 0 1 2\n$EndElements\n",
     "t.msh: it holds 1 lines and no triangle, quad or cell"},
    {NODES "$Elements\n900000000\n1 1 2 0 0 1 2\n$EndElements\n", "900000000 elements announced"},
    {NODES "$Elements\n2\n1 2 2 0 0 1 2 3\n", "t.msh:12: the text ends at element 1 of 2"},
    {NODES "$Elements\n1\n1 2 2 0 0 1 2 3\n", "the text ends before $EndElements"},
    {NODES NODES, "a second section of nodes"},
    {HEAD "$Elements\n1\n1 2 2 0 0 1 2 3\n$EndElements\n", "before the nodes"},
    {NODES "$NodeData\n1\n", "t.msh:10: the section that starts here has no end"},
    {HEAD "$PhysicalNames\n1\n2 1 name\n$EndPhysicalNames\n", "in quotes"},
    {HEAD "$PhysicalNames\n1\n2 1 \"\n$EndPhysicalNames\n", "in quotes"},
    {HEAD "$PhysicalNames\n1\n2 1 \"0123456789012345678901234567890123456789012345678901234567890"
          "123\"\n$EndPhysicalNames\n",
     "at most 63 bytes"},
};

TEST(each_bad_msh_text_gives_one_clear_error)
{
    for (int32_t i = 0; i < COUNT(bad_texts); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        const softsim_status status =
            read_text(bad_texts[i].given, strlen(bad_texts[i].given), 1.0, &m, &error);
        if (status == SOFTSIM_OK || m != NULL || error.fault_count != 1 ||
            strstr(error.text, bad_texts[i].says) == NULL) {
            fail_msg("text %d: %d faults: %s", i, error.fault_count, error.text);
        }
    }
}

TEST(a_text_cut_anywhere_is_refused_and_nothing_leaks)
{
    const int64_t before = ss_memory_in_use();
    const struct {
        const char *text;
        size_t size, whole; /* from `whole` bytes on nothing is missing */
    } texts[] = {{volume_text, sizeof volume_text - 1, sizeof volume_text - 1},
                 {surface_text, sizeof surface_text - 1, sizeof surface_text - 2}};
    for (int i = 0; i < 2; ++i) {
        for (size_t size = 0; size <= texts[i].size; ++size) {
            ss_mesh *m = NULL;
            softsim_error error = {0};
            const softsim_status status = read_text(texts[i].text, size, 1.0, &m, &error);
            if ((status == SOFTSIM_OK) != (size >= texts[i].whole) ||
                (status != SOFTSIM_OK) != (error.fault_count > 0)) {
                fail_msg("text %d cut at %zu: %s", i, size, error.text);
            }
            ss_mesh_destroy(&m);
        }
    }
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(damaged_text_never_makes_a_mesh_with_bad_indices)
{
    static const char alphabet[] = "0123456789 -+.e$\n\r\t\"nN\0\377";
    uint64_t random = 2026;
    for (int round = 0; round < 20000; ++round) {
        char text[sizeof volume_text];
        memcpy(text, volume_text, sizeof text);
        for (int k = 0; k < 1 + round % 4; ++k) {
            const size_t at = ss_random_next(&random) % (sizeof text - 1);
            text[at] = alphabet[ss_random_next(&random) % (sizeof alphabet - 1)];
        }
        ss_mesh *m = NULL;
        softsim_error error = {0};
        if (read_text(text, sizeof text - 1, 1.0, &m, &error) == SOFTSIM_OK) {
            ss_mesh_report r;
            assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
            assert_int_equal(r.bad_index.count, 0);
            assert_int_equal(r.non_finite.count, 0);
        } else {
            assert_true(error.fault_count > 0);
        }
        ss_mesh_destroy(&m);
    }
}

TEST(many_faults_are_named_up_to_a_few)
{
    char text[4096];
    size_t used = (size_t)snprintf(text, sizeof text, "%s$Elements\n100\n", NODES);
    for (int i = 0; i < 100; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%d 2 2 0 0 1 2 77\n", i + 1);
    }
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(read_text(text, used, 1.0, &m, &error), SOFTSIM_ERROR_FORMAT);
    assert_int_equal(error.fault_count, 5);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
