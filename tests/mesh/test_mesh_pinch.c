/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Volumes that touch themselves in a node or an edge: cubes of a grid, each six tetrahedra (Kuhn),
 * some of them left out. The surface goes on over a pinched edge along the same cube, found here by
 * which cube a triangle's tetrahedron belongs to.
 */
#include "common/test.h"

#include <stdlib.h>
#include <string.h>

#include "common/mesh_fixture.h"
#include "mesh/mesh.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MOST_CUBES = 8, SIDE = 3 };

/* Kuhn's six tetrahedra of the unit cube at each place; nodes by place, unused ones too. */
static ss_mesh *make_cubes(int count, const int (*at)[3])
{
    static const int8_t way[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    double x[SIDE * SIDE * SIDE][3];
    int32_t tetrahedron[6 * MOST_CUBES][4];
    int32_t number[SIDE * SIDE * SIDE];
    int32_t nodes = 0, used = 0;
    memset(number, 0xff, sizeof number);
    for (int c = 0; c < count; ++c) {
        for (int w = 0; w < 6; ++w) {
            int p[3] = {at[c][0], at[c][1], at[c][2]};
            for (int k = 0; k < 4; ++k) {
                int32_t *n = &number[(p[2] * SIDE + p[1]) * SIDE + p[0]];
                if (*n < 0) {
                    *n = nodes++;
                    for (int i = 0; i < 3; ++i) {
                        x[*n][i] = p[i];
                    }
                }
                /* Odd permutations would be inverted. */
                tetrahedron[used][w < 3 || k == 0 || k == 3 ? k : 3 - k] = *n;
                if (k < 3) {
                    ++p[way[w][k]];
                }
            }
            ++used;
        }
    }
    return make_mesh(nodes, (const double(*)[3])x, 0, NULL, used, (const int32_t(*)[4])tetrahedron);
}

/* The cube that triangle t belongs to: half a cube behind its middle. */
static void find_cube(const ss_mesh *m, int32_t t, int out[3])
{
    const int32_t *v = m->triangle[t];
    double middle[3] = {0.0, 0.0, 0.0}, normal[3];
    for (int k = 0; k < 3; ++k) {
        ss_madd3(middle, middle, 1.0 / 3.0, m->position[v[k]]);
    }
    ss_normal3(normal, m->position[v[0]], m->position[v[1]], m->position[v[2]]);
    ss_normalize3(normal);
    ss_madd3(middle, middle, -0.5, normal);
    for (int k = 0; k < 3; ++k) {
        out[k] = (int)middle[k];
    }
}

typedef struct body {
    const char *name;
    int count, at[MOST_CUBES][3];
    int64_t pinched_edges, pinched_nodes;
    bool apart; /* paired triangles at pinched edges are of one cube */
} body;

static const body bodies[] = {
    {"a cube", 1, {{0, 0, 0}}, 0, 0, true},
    {"two cubes with a face", 2, {{0, 0, 0}, {1, 0, 0}}, 0, 0, true},
    {"two cubes with a node", 2, {{0, 0, 0}, {1, 1, 1}}, 0, 1, true},
    {"two cubes with an edge", 2, {{0, 0, 0}, {1, 1, 0}}, 1, 2, true},
    {"three cubes, each two with a node", 3, {{0, 0, 0}, {1, 1, 0}, {0, 1, 1}}, 3, 4, true},
    {"four cubes, no two with a face", 4, {{0, 0, 0}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}}, 6, 7, true},
    {"a plate on two cubes with an edge: above it one fan has the edge twice",
     6,
     {{0, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 1}},
     1,
     1,
     false},
};

TEST(each_piece_of_a_pinched_body_is_paired_with_itself)
{
    for (int32_t i = 0; i < COUNT(bodies); ++i) {
        const body *b = &bodies[i];
        ss_mesh *m = make_cubes(b->count, b->at);
        ss_mesh_report r;
        softsim_error error = {0};
        assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
        if (r.pinched_edge.count != b->pinched_edges || r.pinched_node.count != b->pinched_nodes) {
            fail_msg("%s: %lld edges and %lld nodes", b->name, (long long)r.pinched_edge.count,
                     (long long)r.pinched_node.count);
        }
        assert_int_equal(r.non_manifold_edge.count + r.non_manifold_node.count, 0);
        assert_true(m->is_closed);
        assert_near(r.volume, b->count, 1e-12);
        assert_int_equal(ss_mesh_accept(m, b->name, &error), SOFTSIM_OK);

        int32_t twin[3 * 12 * MOST_CUBES];
        int32_t unpaired = 0;
        assert_true(ss_mesh_pair_sides(m, twin, &unpaired));
        assert_int_equal(unpaired, -1);
        for (int32_t s = 0; s < 3 * m->triangle_count; ++s) {
            const int32_t o = twin[s];
            assert_in_range(o, 0, 3 * m->triangle_count - 1);
            assert_int_equal(twin[o], s);
            const int32_t *a = m->triangle[s / 3], *c = m->triangle[o / 3];
            assert_int_equal(a[s % 3], c[(o % 3 + 1) % 3]);
            assert_int_equal(c[o % 3], a[(s % 3 + 1) % 3]);
            int here[3], there[3], apart = 0;
            find_cube(m, s / 3, here);
            find_cube(m, o / 3, there);
            for (int k = 0; k < 3; ++k) {
                apart += abs(here[k] - there[k]);
            }
            assert_true(apart <= 1 || !b->apart);
            assert_true(apart <= 2);
        }
        ss_mesh_destroy(&m);
        assert_int_equal(ss_memory_in_use(), 0);
    }
}

/* What changes a mesh keeps such a body usable. */
TEST(pinched_bodies_go_through_every_change)
{
    for (int32_t i = 0; i < COUNT(bodies); ++i) {
        ss_mesh *m = make_cubes(bodies[i].count, bodies[i].at), *raised = NULL, *mended = NULL;
        softsim_error error = {0};
        ss_mesh_repairs done;
        ss_mesh_report r;
        assert_int_equal(ss_mesh_raise(m, &raised, &error), SOFTSIM_OK);
        assert_int_equal(ss_mesh_accept(raised, "raised", &error), SOFTSIM_OK);
        assert_true(raised->is_closed);
        assert_int_equal(ss_mesh_check(raised, &r), SOFTSIM_OK);
        assert_int_equal(r.pinched_edge.count, 2 * bodies[i].pinched_edges);
        assert_int_equal(ss_mesh_repair(m, &mended, &done, &error), SOFTSIM_OK);
        assert_int_equal(
            done.turned_triangle.count + done.welded_node.count + done.flat_element.count, 0);
        assert_true(ss_mesh_renumber(m));
        assert_int_equal(ss_mesh_accept(m, "renumbered", &error), SOFTSIM_OK);
        assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
        assert_int_equal(r.pinched_edge.count, bodies[i].pinched_edges);
        ss_mesh_destroy(&m);
        ss_mesh_destroy(&raised);
        ss_mesh_destroy(&mended);
        assert_int_equal(ss_memory_in_use(), 0);
    }
}

/* A surface alone does not say which side the body is on: split by --repair, refused here. */
TEST(pinched_surfaces_are_still_refused)
{
    ss_mesh *volume = make_cubes(2, bodies[3].at);
    ss_mesh *m = make_mesh(volume->node_count, (const double(*)[3])volume->position,
                           volume->triangle_count, (const int32_t(*)[3])volume->triangle, 0, NULL);
    softsim_error error = {0};
    assert_int_equal(ss_mesh_accept(m, "surface", &error), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(error.text, "edges of more than two triangles: 1"));
    ss_mesh_destroy(&m);
    ss_mesh_destroy(&volume);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
