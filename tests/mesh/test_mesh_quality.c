/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Shapes of elements, holes, crossing surfaces, and what repair mends. */
#include "mesh/mesh.h"

#include "mesh/tree.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

#include "common/test.h"

#include <stdlib.h>
#include <string.h>

#include "common/mesh_fixture.h"

static const double degrees = 57.295779513082320877;

/* ---- shapes of elements ---- */

static const int32_t one[1][4] = {{0, 1, 2, 3}};

TEST(a_regular_tetrahedron_has_the_angle_acos_one_third)
{
    const double x[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}};
    ss_mesh *mesh = make_mesh(4, x, 0, NULL, 1, one);
    ss_mesh_quality q;
    ss_mesh_measure_quality(mesh, &q);
    assert_near(q.dihedral_min, degrees * acos(1.0 / 3.0), 1e-12);
    assert_near(q.dihedral_max, degrees * acos(1.0 / 3.0), 1e-12);
    assert_int_equal(q.histogram[7], 1);
    assert_int_equal(q.sliver.count, 0);
    ss_mesh_destroy(&mesh);
}

TEST(a_corner_of_a_cube_has_right_angles_and_acos_root_third)
{
    const double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    ss_mesh *mesh = make_mesh(4, x, 0, NULL, 1, one);
    ss_mesh_quality q;
    ss_mesh_measure_quality(mesh, &q);
    assert_near(q.dihedral_min, degrees * acos(sqrt(1.0 / 3.0)), 1e-12);
    assert_near(q.dihedral_max, 90.0, 1e-12);
    ss_mesh_destroy(&mesh);
}

TEST(slivers_are_told_by_angle_and_by_length_at_any_scale)
{
    /* Four points near a square: flat angles. A needle: its dihedral angles are those of its base.
     * A tetrahedron of height 1 on a base of 1: neither. */
    const struct {
        double x[4][3];
        int64_t slivers;
    } cases[] = {
        {{{0, 0, 0}, {1, 1, 0}, {1, 0, 0.05}, {0, 1, 0.05}}, 1},
        {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}, {0.5, 0.29, 25}}, 1},
        {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}, {0.5, 0.29, 12}}, 0},
        {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}, {0.5, 0.29, 1}}, 0},
        {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}, {0.5, 0.29, 0.02}}, 1},
    };
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        for (double scale = 1e-3; scale < 1e4; scale *= 1e3) {
            double x[4][3];
            for (int k = 0; k < 12; ++k) {
                x[k / 3][k % 3] = scale * cases[i].x[k / 3][k % 3];
            }
            ss_mesh *mesh = make_mesh(4, (const double(*)[3])x, 0, NULL, 1, one);
            ss_mesh_quality q;
            ss_mesh_measure_quality(mesh, &q);
            if (q.sliver.count != cases[i].slivers) {
                fail_msg("case %d at %g: %g to %g degrees", i, scale, q.dihedral_min,
                         q.dihedral_max);
            }
            ss_mesh_destroy(&mesh);
        }
    }
}

TEST(triangles_and_quads_are_told_by_their_least_angle)
{
    const double x[5][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 0.05, 0}, {0.5, 0.9, 0}, {0.5, -0.5, 0}};
    const int32_t triangle[3][3] = {{0, 1, 2}, {0, 4, 1}, {0, 1, 3}};
    ss_mesh *mesh = make_mesh(5, x, 3, triangle, 0, NULL);
    ss_mesh_quality q;
    ss_mesh_measure_quality(mesh, &q);
    assert_int_equal(q.sliver.count, 1);
    assert_int_equal(q.sliver.first[0], 0);
    assert_int_equal(q.histogram[0], 1); /* atan 0.1 = 5.7 */
    assert_int_equal(q.histogram[4], 1); /* 45 */
    assert_int_equal(q.histogram[5], 1); /* 58 */
    ss_mesh_destroy(&mesh);

    assert_int_equal(ss_mesh_create_plane(2, 2, 1.0, 1.0, &mesh, NULL), SOFTSIM_OK);
    ss_mesh_measure_quality(mesh, &q);
    assert_int_equal(q.histogram[8], 1); /* 90 */
    ss_mesh_destroy(&mesh);
}

/* ---- holes and crossings ---- */

/* Corner i of the unit cube has coordinates bit 0, bit 1, bit 2 of i. */
static const int32_t cube_triangle[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                             {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                             {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

typedef struct soup {
    double x[64][3];
    int32_t triangle[96][3];
    int32_t nodes, triangles;
} soup;

static void add_cube(soup *s, double size, double dx, double dy, double dz)
{
    for (int32_t i = 0; i < 8; ++i) {
        ss_set3(s->x[s->nodes + i], size * (i & 1) + dx, size * (i >> 1 & 1) + dy,
                size * (i >> 2) + dz);
    }
    for (int32_t t = 0; t < 12; ++t) {
        for (int k = 0; k < 3; ++k) {
            s->triangle[s->triangles][k] = s->nodes + cube_triangle[t][k];
        }
        ++s->triangles;
    }
    s->nodes += 8;
}

static ss_mesh *make_soup(const soup *s)
{
    return make_mesh(s->nodes, s->x, s->triangles, s->triangle, 0, NULL);
}

TEST(each_loop_of_open_edges_is_one_hole)
{
    soup s = {0};
    add_cube(&s, 1.0, 0.0, 0.0, 0.0);
    add_cube(&s, 1.0, 5.0, 0.0, 0.0);
    ss_mesh_fault hole;
    ss_mesh *mesh = make_soup(&s);
    assert_true(ss_mesh_find_holes(mesh, &hole));
    assert_int_equal(hole.count, 0);
    ss_mesh_destroy(&mesh);

    /* The second loses its last two triangles, one face; the first one triangle. */
    s.triangles = 22;
    memmove(&s.triangle[0], &s.triangle[1], 21 * sizeof s.triangle[0]);
    --s.triangles;
    mesh = make_soup(&s);
    assert_true(ss_mesh_find_holes(mesh, &hole));
    assert_int_equal(hole.count, 2);
    assert_int_equal(hole.first[0], 0);
    assert_int_equal(hole.first[1], 8 + 1);
    ss_mesh_destroy(&mesh);

    assert_int_equal(ss_mesh_create_cylinder(4, 9, 1.0, 2.0, &mesh, NULL), SOFTSIM_OK);
    assert_true(ss_mesh_find_holes(mesh, &hole));
    assert_int_equal(hole.count, 2);
    assert_int_equal(hole.first[1], 27);
    ss_mesh_destroy(&mesh);
}

TEST(crossings_are_found_and_touching_is_none)
{
    const struct {
        const char *name;
        double size, x, y, z;
        bool crosses;
    } cases[] = {
        {"apart", 1.0, 3.0, 0.0, 0.0, false},
        {"one inside the other", 0.5, 0.25, 0.25, 0.25, false},
        {"overlapping in general", 1.0, 0.513, 0.391, 0.277, true},
        {"overlapping along an axis", 1.0, 0.5, 0.0, 0.0, true},
        {"overlapping so that edges meet diagonals", 1.0, 0.5, 0.5, 0.5, true},
        {"overlapping by a hair", 1.0, 1.0 - 1e-9, 0.3, 0.4, true},
        {"a hair apart", 1.0, 1.0 + 1e-9, 0.3, 0.4, false},
        {"touching along an edge", 1.0, 1.0, 1.0, 0.0, false},
        {"touching at a corner", 1.0, 1.0, 1.0, 1.0, false},
        {"in the same place", 1.0, 0.0, 0.0, 0.0, true},
        {"a face within a face", 0.5, 1.0, 0.25, 0.25, true},
    };
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        for (double scale = 1e-3; scale < 1e4; scale *= 1e3) {
            soup s = {0};
            add_cube(&s, 1.0, 0.0, 0.0, 0.0);
            add_cube(&s, cases[i].size, cases[i].x, cases[i].y, cases[i].z);
            for (int32_t k = 0; k < 3 * s.nodes; ++k) {
                s.x[k / 3][k % 3] *= scale;
            }
            ss_mesh *mesh = make_soup(&s);
            ss_mesh_fault crossing;
            bool is_complete = false;
            assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete));
            assert_true(is_complete);
            if ((crossing.count > 0) != cases[i].crosses) {
                fail_msg("%s at %g: %d", cases[i].name, scale, (int)crossing.count);
            }
            ss_mesh_destroy(&mesh);
        }
    }
}

TEST(neighbours_cross_only_when_they_are_folded_or_pierced)
{
    const double x[8][3] = {{0, 0, 0},   {1, 0, 0},     {0.5, 1, 0},    {0.5, -1, 0},
                            {0.5, 2, 0}, {0.5, 0.5, 1}, {0.5, 0.6, -1}, {2, 1, 0}};
    const struct {
        int32_t triangle[2][3];
        int64_t count;
    } cases[] = {
        {{{0, 1, 2}, {1, 0, 3}}, 0}, /* flat neighbours */
        {{{0, 1, 2}, {1, 0, 4}}, 2}, /* folded onto each other */
        {{{0, 1, 2}, {1, 0, 5}}, 0}, /* at an angle */
        {{{0, 1, 2}, {0, 5, 6}}, 2}, /* share a node; the edge 5-6 goes through */
        {{{0, 1, 2}, {2, 7, 4}}, 0}, /* share a node in a plane */
        {{{0, 1, 2}, {0, 5, 4}}, 0}, /* share a node, pass by */
    };
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        ss_mesh *mesh = make_mesh(8, x, 2, cases[i].triangle, 0, NULL);
        ss_mesh_fault crossing;
        bool is_complete;
        assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete));
        if (crossing.count != cases[i].count) {
            fail_msg("case %d: %d", i, (int)crossing.count);
        }
        ss_mesh_destroy(&mesh);
    }
}

/* The slow obvious way: an edge of one and the plane of the other, in double, no tree. */
static bool pierces(const double p[3], const double q[3], const double t[3][3])
{
    double u[3], v[3], n[3], from[3], along[3];
    ss_sub3(u, t[1], t[0]);
    ss_sub3(v, t[2], t[0]);
    ss_cross3(n, u, v);
    ss_sub3(from, p, t[0]);
    ss_sub3(along, q, p);
    const double share = -ss_dot3(n, from) / ss_dot3(n, along);
    if (!(share > 0.0 && share < 1.0)) {
        return false;
    }
    double x[3];
    ss_madd3(x, p, share, along);
    for (int k = 0; k < 3; ++k) {
        double side[3], to[3], across[3];
        ss_sub3(side, t[(k + 1) % 3], t[k]);
        ss_sub3(to, x, t[k]);
        ss_cross3(across, side, to);
        if (ss_dot3(across, n) < 0.0) {
            return false;
        }
    }
    return true;
}

TEST(crossings_of_random_triangles_are_those_of_a_search_over_all_pairs)
{
    enum { TRIANGLES = 120 };
    uint64_t random = 20260;
    for (int round = 0; round < 20; ++round) {
        double x[3 * TRIANGLES][3];
        int32_t triangle[TRIANGLES][3];
        bool crosses[TRIANGLES] = {false};
        for (int32_t i = 0; i < 3 * TRIANGLES; ++i) {
            for (int k = 0; k < 3; ++k) {
                const double value = ss_random_unit(&random);
                x[i][k] = i % 3 == 0 ? 4.0 * value : x[i - i % 3][k] + value - 0.5;
            }
            triangle[i / 3][i % 3] = i;
        }
        for (int a = 0; a < TRIANGLES; ++a) {
            for (int b = 0; b < TRIANGLES; ++b) {
                for (int k = 0; k < 3 && a != b; ++k) {
                    if (pierces(x[3 * a + k], x[3 * a + (k + 1) % 3],
                                (const double(*)[3]) & x[3 * b])) {
                        crosses[a] = true;
                        crosses[b] = true;
                    }
                }
            }
        }
        int64_t expected = 0;
        int32_t first = -1;
        for (int a = TRIANGLES - 1; a >= 0; --a) {
            expected += crosses[a];
            first = crosses[a] ? a : first;
        }
        ss_mesh *mesh = make_mesh(3 * TRIANGLES, (const double(*)[3])x, TRIANGLES,
                                  (const int32_t(*)[3])triangle, 0, NULL);
        ss_mesh_fault crossing;
        bool is_complete;
        assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete));
        assert_int_equal(crossing.count, expected);
        assert_int_equal(crossing.first[0], first);
        ss_mesh_destroy(&mesh);
    }
}

/* A fan, or two on one rim, nodes of which lie anywhere, in a plane or not, and loose triangles. */
static ss_mesh *make_fans(uint64_t *random, int round)
{
    enum { RIM = 90, LOOSE = 30, NODES = 2 + RIM + 3 * LOOSE, TRIANGLES = 2 * RIM + LOOSE };
    const bool is_flat = round % 2 == 0;
    double x[NODES][3] = {{0.0, 0.0, is_flat ? 0.0 : 0.4}, {0.1, 0.05, is_flat ? 0.0 : -0.7}};
    int32_t triangle[TRIANGLES][3];
    for (int i = 0; i < RIM; ++i) {
        const bool is_moved = ss_random_unit(random) < 0.05 * (round % 3);
        const double off = is_moved ? ss_random_unit(random) - 0.5 : 0.0;
        const double turn = 2.0 * SS_PI * (i + 8.0 * off) / RIM;
        ss_set3(x[2 + i], cos(turn) * (1.0 + off), sin(turn) * (1.0 + off), is_flat ? 0.0 : off);
        const int32_t a = 2 + i, b = 2 + (i + 1) % RIM;
        /* Both have one hub in half of the rounds, and are folded onto each other. */
        const int32_t fan[2][3] = {{0, a, b}, {round % 4 < 2 ? 1 : 0, b, a}};
        memcpy(triangle[2 * i], fan, sizeof fan);
    }
    for (int i = 0; i < 3 * LOOSE; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = ss_random_unit(random) - 0.5;
            x[2 + RIM + i][k] = i % 3 == 0 ? 6.0 * value : x[2 + RIM + i - i % 3][k] + 0.3 * value;
        }
        triangle[2 * RIM + i / 3][i % 3] = 2 + RIM + i;
    }
    triangle[2 * RIM][0] = 0; /* at both hubs */
    triangle[2 * RIM][1] = 1;
    return make_mesh(NODES, (const double(*)[3])x, TRIANGLES, (const int32_t(*)[3])triangle, 0,
                     NULL);
}

TEST(crossings_around_nodes_of_many_triangles_are_those_of_all_pairs)
{
    uint64_t random = 606;
    int64_t total = 0, all = 0;
    for (int round = 0; round < 60; ++round) {
        ss_mesh *mesh = make_fans(&random, round);
        ss_mesh_fault crossing;
        bool is_complete;
        int64_t expected = 0;
        for (int32_t a = 0; a < mesh->triangle_count; ++a) {
            bool crosses = false;
            for (int32_t b = 0; b < mesh->triangle_count && !crosses; ++b) {
                crosses = a != b && ss_mesh_triangles_cross(mesh, a, b);
            }
            expected += crosses;
        }
        assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete) && is_complete);
        if (crossing.count != expected) {
            fail_msg("round %d: %d, not %d", round, (int)crossing.count, (int)expected);
        }
        total += expected;
        all += mesh->triangle_count;
        ss_mesh_destroy(&mesh);
    }
    print_message("%d of %d triangles cross\n", (int)total, (int)all);
    assert_true(total > all / 10 && total < all - all / 10);
}

/* Under the address sanitizer: they are counted around no node. */
TEST(triangles_of_nodes_that_are_not_there_cross_nothing)
{
    uint64_t random = 7;
    ss_mesh *mesh = make_fans(&random, 0);
    ss_mesh_fault before, after;
    bool is_complete;
    assert_true(ss_mesh_find_crossings(mesh, &before, &is_complete));
    mesh->triangle[0][1] = mesh->node_count + 1000;
    mesh->triangle[1][2] = -1000;
    assert_true(ss_mesh_find_crossings(mesh, &after, &is_complete));
    assert_true(is_complete && after.count > 0 && after.count <= before.count);
    ss_mesh_destroy(&mesh);
}

/* Every pair around a node is more than may be looked at, and of two fans on one rim too. */
TEST(wide_fans_are_looked_at_to_the_end)
{
    enum { MOST = 40000 };
    static double x[MOST + 2][3];
    static int32_t triangle[MOST][3];
    for (int fans = 1; fans <= 2; ++fans) {
        const int32_t rim = MOST / fans;
        for (int32_t i = 0; i < rim; ++i) {
            const double turn = 2.0 * SS_PI * i / rim;
            const int32_t next = (i + 1) % rim;
            const int32_t pair[2][3] = {{rim, i, next}, {rim + 1, next, i}};
            ss_set3(x[i], cos(turn), sin(turn), 0.0);
            memcpy(triangle[fans * i], pair, (size_t)fans * sizeof *pair);
        }
        ss_set3(x[rim], 0.0, 0.0, 0.3);
        ss_set3(x[rim + 1], 0.0, 0.0, -0.3);
        ss_mesh *mesh = make_mesh(rim + fans, (const double(*)[3])x, MOST,
                                  (const int32_t(*)[3])triangle, 0, NULL);
        ss_mesh_fault crossing;
        bool is_complete;
        assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete));
        assert_true(is_complete && crossing.count == 0);
        ss_mesh_destroy(&mesh);
    }
}

/* The cap and the wall of a cylinder turned out of the axes, whose flat parts are flat but for
 * rounding. */
TEST(what_is_flat_but_for_rounding_crosses_nothing)
{
    enum { SIDES = 500, NODES = 2 * SIDES + 1, TRIANGLES = 3 * SIDES };
    double x[NODES][3];
    int32_t triangle[TRIANGLES][3];
    for (int32_t i = 0; i < NODES; ++i) {
        const double turn = 2.0 * SS_PI * i / SIDES, c = cos(0.5), s = sin(0.5);
        const double radius = i < 2 * SIDES ? 1.0 : 0.0, height = i < SIDES ? -1.0 : 1.0;
        const double y = c * radius * sin(turn) - s * height;
        ss_set3(x[i], c * radius * cos(turn) - s * y, s * radius * cos(turn) + c * y,
                s * radius * sin(turn) + c * height);
    }
    for (int32_t i = 0; i < SIDES; ++i) {
        const int32_t next = (i + 1) % SIDES;
        const int32_t three[3][3] = {{i, next, SIDES + next},
                                     {i, SIDES + next, SIDES + i},
                                     {2 * SIDES, SIDES + i, SIDES + next}};
        memcpy(triangle[3 * i], three, sizeof three);
    }
    ss_mesh *mesh =
        make_mesh(NODES, (const double(*)[3])x, TRIANGLES, (const int32_t(*)[3])triangle, 0, NULL);
    ss_mesh_fault crossing;
    bool is_complete;
    assert_true(ss_mesh_find_crossings(mesh, &crossing, &is_complete) && is_complete);
    assert_int_equal(crossing.count, 0);
    ss_mesh_destroy(&mesh);
}

/* ---- repair ---- */

static void expect_good_cube(ss_mesh *mesh)
{
    ss_mesh_report r;
    softsim_error error = {0};
    assert_int_equal(mesh->node_count, 8);
    assert_int_equal(mesh->triangle_count, 12);
    assert_true(mesh->is_closed);
    assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
    assert_near(r.volume, 1.0, 1e-6);
    if (ss_mesh_accept(mesh, "mended", &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
}

TEST(repair_welds_drops_and_turns_and_counts_each)
{
    soup s = {0};
    add_cube(&s, 1.0, 0.0, 0.0, 0.0);
    /* Corner 7 has a double for one triangle, 1e-8 off. */
    ss_set3(s.x[s.nodes], 1.0 + 1e-8, 1.0, 1.0);
    s.triangle[10][2] = s.nodes++;
    ss_set3(s.x[s.nodes++], 9.0, 9.0, 9.0); /* loose */
    /* Flat, double (turned), bad, and one of the cube's wound the wrong way. */
    memcpy(s.triangle[s.triangles++], (int32_t[3]){7, 8, 3}, sizeof s.triangle[0]);
    memcpy(s.triangle[s.triangles++], (int32_t[3]){3, 2, 0}, sizeof s.triangle[0]);
    memcpy(s.triangle[s.triangles++], (int32_t[3]){3, 2, 77}, sizeof s.triangle[0]);
    memcpy(s.triangle[2], (int32_t[3]){5, 4, 7}, sizeof s.triangle[0]);
    const int64_t before = ss_memory_in_use();
    ss_mesh *mesh = make_soup(&s);
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_repair(mesh, &mended, &done, &error), SOFTSIM_OK);
    assert_int_equal(done.welded_node.count, 1);
    assert_int_equal(done.flat_element.count, 1);
    assert_int_equal(done.twin_element.count, 1);
    assert_int_equal(done.bad_element.count, 1);
    assert_int_equal(done.loose_node.count, 1);
    assert_int_equal(done.turned_triangle.count, 1);
    expect_good_cube(mended);
    ss_mesh *again = NULL;
    assert_int_equal(ss_mesh_repair(mended, &again, &done, &error), SOFTSIM_OK);
    const ss_mesh_repairs nothing = {0};
    assert_memory_equal(&done, &nothing, sizeof done);
    assert_memory_equal(again->triangle, mended->triangle, 12 * sizeof *again->triangle);
    ss_mesh_destroy(&again);
    ss_mesh_destroy(&mended);
    ss_mesh_destroy(&mesh);
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(repair_turns_tetrahedra_and_takes_groups_along)
{
    const double x[10][3] = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                             {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0, 0, 0}};
    /* Kuhn's six about 1-8; the second and fifth inverted, the last with the double of node 1. */
    const int32_t e[6][4] = {{1, 2, 4, 8}, {1, 3, 4, 8}, {1, 3, 7, 8},
                             {1, 7, 5, 8}, {1, 6, 5, 8}, {9, 6, 2, 8}};
    ss_mesh *mesh = make_mesh(10, x, 0, NULL, 6, e);
    mesh->group = ss_memory_get(1, sizeof *mesh->group);
    mesh->group_count = 1;
    strcpy(mesh->group[0].name, "held");
    mesh->group[0].node = ss_memory_get(4, sizeof(int32_t));
    mesh->group[0].node_count = 4;
    memcpy(mesh->group[0].node, (int32_t[4]){0, 9, 1, 8}, 4 * sizeof(int32_t));
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    assert_int_equal(ss_mesh_repair(mesh, &mended, &done, NULL), SOFTSIM_OK);
    assert_int_equal(done.turned_tetrahedron.count, 2);
    assert_int_equal(done.welded_node.count, 1);
    assert_int_equal(done.loose_node.count, 1);
    assert_int_equal(mended->tetrahedron_count, 6);
    expect_good_cube(mended);
    assert_int_equal(mended->group_count, 1);
    assert_string_equal(mended->group[0].name, "held");
    assert_int_equal(mended->group[0].node_count, 2);
    assert_int_equal(mended->group[0].node[0], 0);
    assert_int_equal(mended->group[0].node[1], 7);
    ss_mesh_destroy(&mended);
    ss_mesh_destroy(&mesh);
}

TEST(repair_keeps_quads_and_fails_where_nothing_is_left)
{
    const double x[5][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 5, 5}};
    const int32_t quad[2][4] = {{0, 1, 2, 3}, {0, 1, 2, 3}};
    ss_mesh *mesh = NULL;
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    assert_int_equal(ss_mesh_create_quads(5, x, 2, quad, &mesh, NULL), SOFTSIM_OK);
    assert_int_equal(ss_mesh_repair(mesh, &mended, &done, NULL), SOFTSIM_OK);
    assert_int_equal(mended->quad_count, 1);
    assert_int_equal(mended->node_count, 4);
    assert_int_equal(done.twin_element.count, 1);
    ss_mesh_destroy(&mended);
    ss_mesh_destroy(&mesh);

    const int32_t flat[1][3] = {{0, 1, 0}};
    softsim_error error = {0};
    mesh = make_mesh(5, x, 1, flat, 0, NULL);
    assert_int_not_equal(ss_mesh_repair(mesh, &mended, &done, &error), SOFTSIM_OK);
    assert_int_equal(error.fault_count, 1);
    assert_null(mended);
    ss_mesh_destroy(&mesh);
}

/* A cone on a slot, whose two rails have 150 nodes each, with a ball beside the slot and, perhaps,
 * a small tetrahedron through it at one end. The boxes of all that fills the slot hold the ball. */
static ss_mesh *make_slot(int32_t rings, bool is_pierced)
{
    enum { RAIL = 150, LOOP = 2 * RAIL, SIDES = 120, RINGS = 100 };
    static double x[LOOP + 1 + 2 + SIDES * RINGS + 4][3];
    static int32_t triangle[LOOP + 2 * SIDES * RINGS + 4][3];
    int32_t nodes = LOOP + 1, triangles = 0;
    for (int32_t i = 0; i < LOOP; ++i) {
        const double along = 0.0028 * (i < RAIL ? i : LOOP - 1 - i), across = i < RAIL ? 0.0 : 1.0;
        ss_set3(x[i], across + along, across - along, across);
        const int32_t side[3] = {LOOP, i, (i + 1) % LOOP};
        memcpy(triangle[triangles++], side, sizeof side);
    }
    ss_set3(x[LOOP], 0.7 - 8.0, 0.3 - 8.0, 0.5 + 16.0);
    const int32_t ball = nodes;
    ss_set3(x[nodes++], 0.83, 0.41, 0.255 + 0.15);
    ss_set3(x[nodes++], 0.83, 0.41, 0.255 - 0.15);
    for (int32_t i = 0; i < rings * SIDES; ++i) {
        const double down = SS_PI * (i / SIDES + 1) / (rings + 1), turn = 2.0 * SS_PI * i / SIDES;
        ss_set3(x[nodes++], 0.83 + 0.15 * sin(down) * cos(turn),
                0.41 + 0.15 * sin(down) * sin(turn), 0.255 + 0.15 * cos(down));
        const int32_t at = ball + 2 + i, next = i % SIDES < SIDES - 1 ? at + 1 : at + 1 - SIDES;
        const bool is_last = i / SIDES == rings - 1;
        const int32_t two[2][3] = {{at, is_last ? ball + 1 : at + SIDES, next},
                                   {i < SIDES ? ball : next - SIDES, at, next}};
        memcpy(triangle[triangles], two, sizeof two);
        triangles += 2;
    }
    if (is_pierced) {
        static const double slot_end[3] = {0.89, 0.11, 0.5};
        static const double corner[4][3] = {
            {-0.01, -0.01, 0.02}, {0.03, 0.03, 0.0}, {0.0, 0.0, -0.04}, {0.02, 0.0, -0.02}};
        static const int32_t face[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
        for (int k = 0; k < 12; ++k) {
            x[nodes + k / 3][k % 3] = slot_end[k % 3] + corner[k / 3][k % 3];
            triangle[triangles + k / 3][k % 3] = nodes + face[k / 3][k % 3];
        }
        nodes += 4;
        triangles += 4;
    }
    return make_mesh(nodes, (const double(*)[3])x, triangles, (const int32_t(*)[3])triangle, 0,
                     NULL);
}

/* The ball of 24000 triangles takes more looks than there are. */
TEST(what_fills_a_hole_is_known_to_cross_nothing)
{
    const struct {
        int32_t rings;
        bool is_pierced;
        int64_t filled;
    } cases[] = {{10, false, 1}, {10, true, 0}, {100, true, 0}};
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        ss_mesh *mesh = make_slot(cases[i].rings, cases[i].is_pierced);
        ss_mesh *mended = NULL;
        ss_mesh_repairs done;
        assert_int_equal(ss_mesh_repair(mesh, &mended, &done, NULL), SOFTSIM_OK);
        if (done.filled_hole.count != cases[i].filled) {
            fail_msg("case %d: %d filled", i, (int)done.filled_hole.count);
        }
        ss_mesh_destroy(&mended);
        ss_mesh_destroy(&mesh);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
