/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A table of damaged meshes: what softsim-mesh check says of each, what convert --repair makes of
 * it, and what check says then. Each is made whole, damaged on purpose and written in a format that
 * such files come in, so that what should come out is known: the volume of the body, and how many
 * bodies there are.
 */
#include "common/test.h"

#include <math.h>

#include "common/tool_fixture.h"
#include "rt/random.h"
#include "wreck_fixture.h"

static const double origin[3] = {0.0, 0.0, 0.0};
static const double corner[3] = {1.0, 1.0, 1.0};

/* ---- bodies ---- */

static void ball(wreck *w)
{
    add_sphere(w, origin, 1.0, 3); /* 512 triangles of edges of about 0.2 */
}

static void cube(wreck *w)
{
    add_box(w, origin, corner, false);
}

static void two_balls(wreck *w, double x)
{
    const double other[3] = {x, 0.0, 0.0};
    ball(w);
    add_sphere(w, other, 1.0, 3);
}

/* The node of the second ball at the first's pole becomes that one. */
static void join_balls(wreck *w)
{
    two_balls(w, 2.0);
    join_points(w, find_point(w, 1, 0, 0, 258), find_point(w, 1, 0, 0, 0));
}

static void two_boxes(wreck *w, const double low[3], bool is_quads)
{
    double high[3];
    ss_add3(high, low, corner);
    add_box(w, origin, corner, is_quads);
    add_box(w, low, high, is_quads);
    for (int32_t i = 8; i < 16; ++i) {
        const int32_t same = find_point(w, w->x[i][0], w->x[i][1], w->x[i][2], 0);
        if (same >= 0 && same < 8) {
            join_points(w, i, same);
        }
    }
}

static void beside_edge(wreck *w)
{
    two_boxes(w, (double[3]){1, 1, 0}, false);
}

static void beside_face(wreck *w)
{
    two_boxes(w, (double[3]){1, 0, 0}, false);
}

static void beside_corner(wreck *w)
{
    two_boxes(w, (double[3]){1, 1, 1}, false);
}

static void quads_beside_edge(wreck *w)
{
    two_boxes(w, (double[3]){0, 1, 1}, true);
}

/* A band of quads, twisted by half a turn where it closes, of triangles. */
static void moebius(wreck *w)
{
    enum { STEPS = 40 };
    for (int i = 0; i < STEPS; ++i) {
        const double turn = 2.0 * SS_PI * i / STEPS, half = 0.5 * turn;
        for (int side = -1; side <= 1; ++side) {
            const double r = 2.0 + 0.3 * side * cos(half);
            add_point(w, r * cos(turn), r * sin(turn), 0.3 * side * sin(half));
        }
    }
    for (int i = 0; i < STEPS; ++i) {
        for (int k = 0; k < 2; ++k) {
            const bool is_last = i == STEPS - 1;
            const int32_t a = 3 * i + k, b = a + 1;
            const int32_t c = is_last ? 2 - k : a + 3, d = is_last ? 1 - k : b + 3;
            add_face(w, a, b, d, -1);
            add_face(w, a, d, c, -1);
        }
    }
}

static void tube(wreck *w)
{
    enum { RINGS = 9, AROUND = 16 };
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double turn = 2.0 * SS_PI * (i % AROUND) / AROUND;
        add_point(w, cos(turn), sin(turn), 0.4 * (i / AROUND)); /* NOLINT: rings */
    }
    for (int i = 0; i < (RINGS - 1) * AROUND; ++i) {
        const int32_t b = i / AROUND * AROUND + (i + 1) % AROUND;
        add_face(w, i, b, b + AROUND, -1);
        add_face(w, i, b + AROUND, i + AROUND, -1);
    }
}

static void sheet(wreck *w)
{
    for (int i = 0; i < 121; ++i) {
        add_point(w, 0.1 * (i % 11), 0.1 * (i / 11), 0.0); /* NOLINT: rows */
    }
    for (int i = 0; i < 110; ++i) {
        if (i % 11 < 10) {
            add_face(w, i, i + 1, i + 12, -1);
            add_face(w, i, i + 12, i + 11, -1);
        }
    }
}

/* Six tetrahedra to each of 27 cells. */
static void block(wreck *w)
{
    static const int32_t kuhn[6][4] = {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7},
                                       {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}};
    for (int i = 0; i < 64; ++i) {
        add_point(w, i % 4, i / 4 % 4, i / 16); /* NOLINT: a grid */
    }
    for (int i = 0; i < 27; ++i) {
        const int32_t at = i % 3 + 4 * (i / 3 % 3) + 16 * (i / 9);
        for (int e = 0; e < 6; ++e) {
            int32_t *node = w->tetrahedron[w->tetrahedra++];
            for (int k = 0; k < 4; ++k) {
                const int32_t c = kuhn[e][k];
                node[k] = at + (c & 1) + 4 * (c >> 1 & 1) + 16 * (c >> 2);
            }
        }
    }
}

/* ---- damages ---- */

static void hole(wreck *w)
{
    drop_face(w, 100);
}

/* All faces within `radius` of the pole. */
static void open_pole(wreck *w, double radius)
{
    for (int32_t f = w->faces - 1; f >= 0; --f) {
        double middle[3] = {-3.0, 0.0, 0.0};
        for (int k = 0; k < 3; ++k) {
            ss_add3(middle, middle, w->x[w->face[f][k]]);
        }
        if (ss_norm3(middle) < 3.0 * radius) {
            drop_face(w, f);
        }
    }
}

static void star_hole(wreck *w)
{
    open_pole(w, 0.15);
}

static void wide_hole(wreck *w)
{
    open_pole(w, 0.35);
}

static void half_open(wreck *w)
{
    open_pole(w, 1.0);
}

static void many_holes(wreck *w)
{
    for (int32_t f = 500; f > 0; f -= 50) {
        drop_face(w, f);
    }
}

static void side_missing(wreck *w)
{
    drop_face(w, 1);
    drop_face(w, 0);
}

static void flip(wreck *w)
{
    turn_face(w, 7);
}

static void flip_many(wreck *w)
{
    for (int32_t f = 0; f < w->faces; f += 3) {
        turn_face(w, f);
    }
}

static void flip_all(wreck *w)
{
    for (int32_t f = 0; f < w->faces; ++f) {
        turn_face(w, f);
    }
}

static void double_some(wreck *w)
{
    for (int32_t f = 0; f < 100; f += 9) {
        const int32_t *n = w->face[f];
        add_face(w, n[1], n[2], n[0], -1);
    }
}

static void double_all_turned(wreck *w)
{
    const int32_t count = w->faces;
    for (int32_t f = 0; f < count; ++f) {
        const int32_t *n = w->face[f];
        add_face(w, n[0], n[2], n[1], -1);
    }
}

/* A fan over the great circle x = 0, from a node of its own in the middle. */
static void wall(wreck *w)
{
    const int32_t count = w->faces, middle = add_point(w, 0.02, 0.01, 0.03);
    for (int32_t f = 0; f < count; ++f) {
        for (int k = 0; k < 3; ++k) {
            const int32_t a = w->face[f][k], b = w->face[f][(k + 1) % 3];
            const bool is_on_circle = fabs(w->x[a][0]) < 1e-9 && fabs(w->x[b][0]) < 1e-9;
            if (is_on_circle && w->x[w->face[f][(k + 2) % 3]][0] > 0.0) {
                add_face(w, a, b, middle, -1);
            }
        }
    }
}

static void flaps(wreck *w)
{
    for (int32_t f = 0; f < 200; f += 40) {
        const int32_t a = w->face[f][0], b = w->face[f][1];
        const double *x = w->x[a];
        const int32_t c = add_point(w, 1.4 * x[0], 1.4 * x[1], 1.4 * x[2]);
        add_face(w, a, b, c, -1);
    }
}

/* Faces divided at a middle of one side, their neighbours not. */
static void junction(wreck *w, int32_t from, int32_t step)
{
    const int32_t count = w->faces;
    for (int32_t f = from; f < count; f += step) {
        int32_t *n = w->face[f];
        double x[3];
        ss_add3(x, w->x[n[0]], w->x[n[1]]);
        const int32_t middle = add_point(w, 0.5 * x[0], 0.5 * x[1], 0.5 * x[2]);
        add_face(w, middle, n[1], n[2], -1);
        n[1] = middle;
    }
}

static void one_junction(wreck *w)
{
    junction(w, 50, 100000);
}

static void many_junctions(wreck *w)
{
    junction(w, 0, 25);
}

static void push_through(wreck *w)
{
    const int32_t pole = find_point(w, 1, 0, 0, 0);
    w->x[pole][0] = -1.5;
}

static void soup(wreck *w)
{
    uint64_t random = 5;
    scatter(w, 0.0, &random);
}

static void soup_rounded(wreck *w)
{
    uint64_t random = 6;
    scatter(w, 1e-6, &random);
}

static void soup_rough(wreck *w)
{
    uint64_t random = 7;
    scatter(w, 3e-5, &random);
}

static void node_twice(wreck *w)
{
    add_face(w, 3, 3, 9, -1);
    add_face(w, 5, 5, 5, -1);
}

/* The node in the middle of an edge, in a flat face of its own. */
static void cap(wreck *w)
{
    junction(w, 50, 100000);
    const int32_t *first = w->face[50], *second = w->face[w->faces - 1];
    add_face(w, first[0], second[1], first[1], -1);
}

static void needle(wreck *w)
{
    const int32_t a = w->face[20][0];
    const int32_t twin = add_point(w, w->x[a][0] + 1e-5, w->x[a][1], w->x[a][2]);
    const int32_t *n = w->face[20];
    const int32_t b = n[1];
    w->face[20][0] = twin;
    add_face(w, a, b, twin, -1);
}

static void near_nodes(wreck *w)
{
    for (int32_t f = 0; f < 200; f += 20) {
        const double *x = w->x[w->face[f][0]];
        w->face[f][0] = add_point(w, x[0] + 2e-5, x[1] - 1e-5, x[2]);
    }
}

static void loose(wreck *w)
{
    add_point(w, 7, 7, 7);
    add_point(w, 8, 7, 7);
}

static void pillow(wreck *w)
{
    const int32_t a = add_point(w, 3, 0, 0), b = add_point(w, 3.2, 0, 0);
    const int32_t c = add_point(w, 3, 0.2, 0), d = add_point(w, 3.2, 0.2, 0);
    add_face(w, a, b, d, -1);
    add_face(w, a, d, c, -1);
    add_face(w, a, c, b, -1);
    add_face(w, b, c, d, -1);
}

static void speck(wreck *w)
{
    const double middle[3] = {2.0, 0.0, 0.0};
    add_sphere(w, middle, 5e-4, 0);
}

static void scrap(wreck *w)
{
    const int32_t a = add_point(w, 3, 0, 0), b = add_point(w, 3.1, 0, 0);
    add_face(w, a, b, add_point(w, 3, 0.1, 0), -1);
}

static void second_turned(wreck *w)
{
    const double other[3] = {3.0, 0.0, 0.0};
    const int32_t count = w->faces;
    add_sphere(w, other, 1.0, 2);
    for (int32_t f = count; f < w->faces; ++f) {
        turn_face(w, f);
    }
}

/* A hollow body, all of it wound the wrong way round. */
static void hollow_turned(wreck *w)
{
    add_sphere(w, origin, 0.5, 2);
    for (int32_t f = 0; f < 512; ++f) {
        turn_face(w, f);
    }
}

static void ball_within(wreck *w)
{
    add_sphere(w, origin, 0.5, 2);
}

static void overlapping(wreck *w)
{
    const double other[3] = {1.1, 0.13, 0.07};
    add_sphere(w, other, 1.0, 3);
}

static void mixed_faces(wreck *w)
{
    const double low[3] = {3.0, 0.0, 0.0}, high[3] = {4.0, 1.0, 1.0};
    add_box(w, low, high, true);
}

static void everything(wreck *w)
{
    hole(w);
    flip_many(w);
    double_some(w);
    near_nodes(w);
    junction(w, 60, 77);
    node_twice(w);
    pillow(w);
    loose(w);
}

static void all_flat(wreck *w)
{
    for (int32_t i = 0; i < w->nodes; ++i) {
        ss_set3(w->x[i], 0.5, 0.25, 0.125);
    }
}

static void not_finite(wreck *w)
{
    w->x[3][1] = NAN;
}

static void bad_number(wreck *w)
{
    w->face[4][1] = 7777;
}

/* Of volumes. */
static void swap_order(wreck *w)
{
    for (int32_t e = 0; e < w->tetrahedra; e += 4) {
        const int32_t second = w->tetrahedron[e][1];
        w->tetrahedron[e][1] = w->tetrahedron[e][2];
        w->tetrahedron[e][2] = second;
    }
}

static void twice(wreck *w)
{
    for (int32_t e = 0; e < 5; ++e) {
        memcpy(w->tetrahedron[w->tetrahedra++], w->tetrahedron[20 * e], sizeof w->tetrahedron[0]);
    }
}

static void flat_element(wreck *w)
{
    const int32_t flat[4] = {0, 1, 4, 5};
    memcpy(w->tetrahedron[w->tetrahedra++], flat, sizeof flat);
}

static void through_neighbours(wreck *w)
{
    w->x[21][0] += 1.7; /* of the inner eight */
}

/* The same, each tetrahedron written with a positive volume, as many programs do. */
static void through_and_turned(wreck *w)
{
    through_neighbours(w);
    for (int32_t e = 0; e < w->tetrahedra; ++e) {
        int32_t *node = w->tetrahedron[e];
        const int32_t second = node[1];
        if (ss_six_volumes3(w->x[node[0]], w->x[node[1]], w->x[node[2]], w->x[node[3]]) < 0.0) {
            node[1] = node[2];
            node[2] = second;
        }
    }
}

static void crowded(wreck *w)
{
    int32_t *node = w->tetrahedron[w->tetrahedra++];
    memcpy(node, w->tetrahedron[80], sizeof w->tetrahedron[0]);
    node[3] = add_point(w, 1.2, 1.3, 1.4);
}

/* ---- the table ---- */

typedef enum outcome {
    MENDED, /* closed, and nothing crosses: a body to fill and press */
    TOLD,   /* a scene takes it, and what is left is said */
    REFUSED /* and why */
} outcome;

typedef struct wreck_row {
    const char *name; /* its ending is the format */
    void (*make)(wreck *w);
    void (*damage)(wreck *w);
    outcome outcome;
    int parts;
    double balls, cubes; /* the volume: so many balls, and unit cubes; 0: not known */
    const char *says;
} wreck_row;

static const wreck_row rows[] = {
    {"whole.obj", ball, NULL, MENDED, 1, 1, 0, "triangles"},
    {"hole.obj", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"hole.stl", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"hole.ply", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"hole.off", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"hole.msh", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"hole.vtk", ball, hole, MENDED, 1, 1, 0, "holes filled: 1 (at node"},
    {"star-hole.obj", ball, star_hole, MENDED, 1, 1, 0, "holes filled: 1"},
    {"wide-hole.msh", ball, wide_hole, MENDED, 1, 1, 0, "holes filled: 1"},
    {"half-open.obj", ball, half_open, TOLD, 1, 0, 0, "left as they are: holes: 1"},
    {"many-holes.stl", ball, many_holes, MENDED, 1, 1, 0, "holes filled: 10"},
    {"side-missing.obj", cube, side_missing, MENDED, 1, 0, 1, "holes filled: 1"},
    {"side-missing.stl", cube, side_missing, MENDED, 1, 0, 1, "holes filled: 1"},
    {"flip.obj", ball, flip, MENDED, 1, 1, 0, "triangles turned: 1 (face 7)"},
    {"flip.off", ball, flip, MENDED, 1, 1, 0, "triangles turned: 1 (face 7)"},
    {"flip.ply", ball, flip, MENDED, 1, 1, 0, "triangles turned: 1"},
    {"flip-many.obj", ball, flip_many, MENDED, 1, 1, 0, "triangles turned: 171"},
    {"flip-many.vtk", ball, flip_many, MENDED, 1, 1, 0, "triangles turned: 171"},
    {"flip-all.obj", ball, flip_all, MENDED, 1, 1, 0, "triangles turned: 512"},
    {"flip-all.stl", cube, flip_all, MENDED, 1, 0, 1, "triangles turned: 12"},
    {"double.obj", ball, double_some, MENDED, 1, 1, 0, "duplicate elements dropped: 12"},
    {"double.msh", ball, double_some, MENDED, 1, 1, 0, "duplicate elements dropped: 12"},
    {"two-sided.obj", ball, double_all_turned, MENDED, 1, 1, 0, "duplicate elements dropped: 512"},
    {"two-sided.ply", cube, double_all_turned, MENDED, 1, 0, 1, "duplicate elements dropped: 12"},
    {"pinched-node.obj", join_balls, NULL, MENDED, 2, 2, 0, "nodes parted where sheets"},
    {"pinched-node.stl", join_balls, NULL, MENDED, 2, 2, 0, "nodes parted where sheets"},
    {"pinched-node-turned.obj", join_balls, flip_all, MENDED, 2, 2, 0, "nodes parted"},
    {"pinched-corner.msh", beside_corner, NULL, MENDED, 2, 0, 2, "nodes parted where sheets"},
    {"pinched-edge.obj", beside_edge, NULL, MENDED, 2, 0, 2,
     "edges of more than two triangles parted into sheets: 1"},
    {"pinched-edge.stl", beside_edge, NULL, MENDED, 2, 0, 2, "edges of more than two triangles"},
    {"pinched-edge-turned.msh", beside_edge, flip_all, MENDED, 2, 0, 2, "edges of more than two"},
    {"pinched-edge-mixed.vtk", beside_edge, flip_many, MENDED, 2, 0, 2, "edges of more than two"},
    {"pinched-quads.obj", quads_beside_edge, NULL, MENDED, 2, 0, 2, "quads cut into triangles: 12"},
    {"shared-face.obj", beside_face, NULL, MENDED, 1, 0, 2, "inner walls and flaps dropped: 2"},
    {"shared-face.stl", beside_face, NULL, MENDED, 1, 0, 2, "inner walls and flaps dropped: 2"},
    {"wall.obj", ball, wall, MENDED, 1, 1, 0, "inner walls and flaps dropped: 32"},
    {"wall.stl", ball, wall, MENDED, 1, 1, 0, "inner walls and flaps dropped: 32"},
    {"wall.off", ball, wall, MENDED, 1, 1, 0, "inner walls and flaps dropped: 32"},
    {"wall.msh", ball, wall, MENDED, 1, 1, 0, "inner walls and flaps dropped: 32"},
    {"flaps.obj", ball, flaps, MENDED, 1, 1, 0, "inner walls and flaps dropped: 5"},
    {"flaps.ply", ball, flaps, MENDED, 1, 1, 0, "inner walls and flaps dropped: 5"},
    {"junction.obj", ball, one_junction, MENDED, 1, 1, 0,
     "triangles divided at nodes on their edges: 1"},
    {"junctions.stl", ball, many_junctions, MENDED, 1, 1, 0, "triangles divided at nodes"},
    {"junctions.msh", ball, many_junctions, MENDED, 1, 1, 0, "triangles divided at nodes"},
    {"pushed-through.obj", ball, push_through, TOLD, 1, 0, 0,
     "left as they are: triangles that cross others: "},
    {"overlapping.obj", ball, overlapping, TOLD, 2, 0, 0,
     "left as they are: triangles that cross others: "},
    {"soup.msh", ball, soup, MENDED, 1, 1, 0, "nodes welded to others: 1278"},
    {"soup.vtk", ball, soup, MENDED, 1, 1, 0, "nodes welded to others: 1278"},
    {"soup-rounded.stl", ball, soup_rounded, MENDED, 1, 1, 0, "nodes welded to others: 1278"},
    {"soup-rough.obj", ball, soup_rough, MENDED, 1, 1, 0, "nodes welded to others: 1278"},
    {"node-twice.msh", ball, node_twice, MENDED, 1, 1, 0, "flat elements dropped: 2"},
    {"node-twice.vtk", ball, node_twice, MENDED, 1, 1, 0, "flat elements dropped: 2"},
    {"cap.obj", ball, cap, MENDED, 1, 1, 0, "flat elements dropped: 1"},
    {"needle.obj", ball, needle, MENDED, 1, 1, 0, "nodes welded to others: 1"},
    {"near-nodes.obj", ball, near_nodes, MENDED, 1, 1, 0, "nodes welded to others: 10"},
    {"near-nodes.ply", ball, near_nodes, MENDED, 1, 1, 0, "nodes welded to others: 10"},
    {"loose.msh", ball, loose, MENDED, 1, 1, 0, "loose nodes dropped: 2 (node 258, 259)"},
    {"pillow.obj", ball, pillow, MENDED, 1, 1, 0,
     "parts dropped that enclose no volume or are too small"},
    {"speck.obj", ball, speck, MENDED, 1, 1, 0, "or are too small: 1"},
    {"scrap.stl", ball, scrap, MENDED, 1, 1, 0, "or are too small: 1"},
    {"second-turned.obj", ball, second_turned, MENDED, 2, 0, 0, "triangles turned: 128"},
    {"hollow-turned.obj", ball, hollow_turned, MENDED, 2, 0, 0, "triangles turned: 640"},
    {"ball-within.obj", ball, ball_within, MENDED, 2, 0, 0, "triangles"},
    {"mixed-faces.obj", ball, mixed_faces, MENDED, 2, 1, 1, "triangles"},
    {"mixed-faces.msh", ball, mixed_faces, MENDED, 2, 1, 1, "triangles"},
    {"mixed-faces.off", ball, mixed_faces, MENDED, 2, 1, 1, "triangles"},
    {"mixed-faces.ply", ball, mixed_faces, MENDED, 2, 1, 1, "triangles"},
    {"everything.obj", ball, everything, MENDED, 1, 1, 0, "holes filled: "},
    {"everything.msh", ball, everything, MENDED, 1, 1, 0, "holes filled: "},
    {"moebius.obj", moebius, NULL, TOLD, 1, 0, 0, "edges of one-sided surfaces cut: "},
    {"tube.obj", tube, NULL, TOLD, 1, 0, 0, "left as they are: holes: 2"},
    {"tube-flipped.stl", tube, flip_many, TOLD, 1, 0, 0, "left as they are: holes: 2"},
    {"sheet.obj", sheet, NULL, TOLD, 1, 0, 0, "left as they are: holes: 1"},
    {"sheet-double.msh", sheet, double_all_turned, TOLD, 1, 0, 0,
     "duplicate elements dropped: 200"},
    {"all-flat.msh", ball, all_flat, REFUSED, 0, 0, 0, "softsim-mesh: "},
    {"not-finite.obj", ball, not_finite, REFUSED, 0, 0, 0, "not-finite.obj:4: the position"},
    {"bad-number.obj", ball, bad_number, REFUSED, 0, 0, 0, "bad-number.obj"},
    {"bad-number.msh", ball, bad_number, REFUSED, 0, 0, 0, "bad-number.msh:"},
    {"block.msh", block, NULL, MENDED, 1, 0, 27, "162 tetrahedra"},
    {"swapped.msh", block, swap_order, MENDED, 1, 0, 27, "tetrahedra turned: 41"},
    {"twice.msh", block, twice, MENDED, 1, 0, 27, "duplicate elements dropped: 5"},
    {"flat.msh", block, flat_element, MENDED, 1, 0, 27, "flat elements dropped: 1"},
    {"loose-volume.msh", block, loose, MENDED, 1, 0, 27, "loose nodes dropped: 2"},
    {"through.msh", block, through_neighbours, REFUSED, 0, 0, 0,
     "overlap their neighbours (the first is "},
    {"through-turned.msh", block, through_and_turned, REFUSED, 0, 0, 0,
     "overlap their neighbours (the first is "},
    {"crowded.msh", block, crowded, REFUSED, 0, 0, 0, "overlap their neighbours"},
};

static void put_wreck(const wreck *w, const char *name)
{
    static const struct {
        const char *ending;
        void (*write)(const wreck *w, FILE *file);
    } formats[] = {{".obj", write_obj_text}, {".stl", write_stl_text}, {".ply", write_ply_text},
                   {".off", write_off_text}, {".msh", write_msh_text}, {".vtk", write_vtk_text}};
    FILE *file = open_file(name);
    for (int32_t i = 0; i < COUNT(formats); ++i) {
        if (strcmp(name + strlen(name) - 4, formats[i].ending) == 0) {
            /* Half of the STL in bytes. */
            const bool as_bytes = formats[i].write == write_stl_text && strlen(name) % 2 == 0;
            (as_bytes ? write_stl_bytes : formats[i].write)(w, file);
        }
    }
    assert_int_equal(fclose(file), 0);
}

/* "good", "usable" or "refused", as a scene takes it; and the first words of what is wrong. */
static const char *judge(const char *path, ss_mesh **out_mesh)
{
    softsim_error error = {0};
    if (ss_mesh_load(path, 1.0, importer, out_mesh, &error) != SOFTSIM_OK) {
        return "unreadable";
    }
    ss_mesh_fault crossing, holes;
    bool is_complete = false;
    assert_true(ss_mesh_find_crossings(*out_mesh, &crossing, &is_complete));
    assert_true(ss_mesh_find_holes(*out_mesh, &holes));
    return ss_mesh_accept(*out_mesh, "it", NULL) != SOFTSIM_OK ? "refused"
           : crossing.count > 0 || holes.count > 0             ? "usable"
                                                               : "good";
}

/* By the divergence theorem, of faces wound outwards. */
static double volume_of_ball(void)
{
    static wreck w;
    double volume = 0.0;
    memset(&w, 0, sizeof w);
    ball(&w);
    for (int32_t f = 0; f < w.faces; ++f) {
        const int32_t *n = w.face[f];
        volume += ss_six_volumes3(origin, w.x[n[0]], w.x[n[1]], w.x[n[2]]) / 6.0;
    }
    return volume;
}

/* What comes out is what was made: so many parts, of that volume; mended once is mended. */
static void check_mended(const wreck_row *row, const ss_mesh *mesh)
{
    ss_mesh *again = NULL;
    ss_mesh_report r;
    ss_mesh_repairs done;
    assert_int_equal(ss_mesh_check(mesh, &r), SOFTSIM_OK);
    if (r.component_count != row->parts) {
        fail_msg("%s: %d parts", row->name, r.component_count);
    }
    const double volume = row->balls * volume_of_ball() + row->cubes;
    if (volume > 0.0 && !(fabs(r.volume - volume) < 0.02 * volume)) {
        fail_msg("%s: a volume of %g, not %g", row->name, r.volume, volume);
    }
    assert_int_equal(ss_mesh_repair(mesh, &again, &done, NULL), SOFTSIM_OK);
    const ss_mesh_repairs nothing = {0};
    if (memcmp(&done, &nothing, sizeof done) != 0 ||
        again->triangle_count != mesh->triangle_count || again->node_count != mesh->node_count ||
        memcmp(again->triangle, mesh->triangle,
               (size_t)mesh->triangle_count * sizeof *mesh->triangle) != 0 ||
        memcmp(again->position, mesh->position,
               (size_t)mesh->node_count * sizeof *mesh->position) != 0) {
        fail_msg("%s: a second repair changes it", row->name);
    }
    ss_mesh_destroy(&again);
}

/* softsim-mesh check says what to do of one that a scene refuses, and of no other. */
static bool is_told_next(const wreck_row *row, const char *verdict)
{
    static char out[16384];
    char command[512];
    (void)snprintf(command, sizeof command, TOOL "check %s", row->name);
    (void)run(command, out, sizeof out);
    const char *next = strstr(out, "; next: ");
    const bool is_right = strcmp(verdict, "refused") != 0 ? next == NULL
                          : row->outcome == REFUSED
                              ? strstr(out, "no repair makes it usable; next: ") != NULL
                              : next != NULL && strstr(next, "scene mends it by itself") != NULL;
    if (!is_right) {
        print_error("%s is %s, and check says:\n%s", row->name, verdict, out);
    }
    return is_right;
}

static bool run_row(const wreck_row *row)
{
    static wreck w;
    static char out[16384];
    static const char *const outcomes[] = {"mended", "told", "refused"};
    memset(&w, 0, sizeof w);
    row->make(&w);
    if (row->damage != NULL) {
        row->damage(&w);
    }
    put_wreck(&w, row->name);
    ss_mesh *before = NULL, *after = NULL;
    const char *verdict = judge(in_folder(row->name), &before);
    char command[512];
    (void)snprintf(command, sizeof command,
                   "rm -f mended.msh; " TOOL "convert --repair %s mended.msh", row->name);
    const int status = run(command, out, sizeof out);
    const char *then = status == 0 ? judge(in_folder("mended.msh"), &after) : "-";
    print_message("%-24s %-10s -> %d %-8s %s\n", row->name, verdict, status, then,
                  outcomes[row->outcome]);
    const bool is_right = strstr(out, row->says) != NULL &&
                          (row->outcome == REFUSED ? status == 2
                           : row->outcome == TOLD  ? status == 0 && strcmp(then, "usable") == 0
                                                   : status == 0 && strcmp(then, "good") == 0);
    if (!is_right) {
        print_error("%s: '%s' is not in:\n%s", row->name, row->says, out);
    } else if (status == 0) {
        check_mended(row, after);
    }
    ss_mesh_destroy(&before);
    ss_mesh_destroy(&after);
    return is_told_next(row, verdict) && is_right;
}

TEST(each_wreck_is_mended_or_told)
{
    int wrong = 0;
    for (int32_t i = 0; i < COUNT(rows); ++i) {
        wrong += !run_row(&rows[i]);
    }
    print_message("%d wrecks, %d not as they should be\n", COUNT(rows), wrong);
    assert_int_equal(wrong, 0);
}

TEST(faulty_elements_are_written_to_be_looked_at)
{
    static wreck w;
    ball(&w);
    overlapping(&w);
    put_wreck(&w, "crossing.obj");
    run_tool("convert --repair crossing.obj out.obj --vtk faults.vtk");
    ss_mesh *faults = load(in_folder("faults.vtk"), 1.0);
    ss_mesh *whole = load(in_folder("crossing.obj"), 1.0);
    ss_mesh_fault crossing;
    bool is_complete = false;
    assert_true(ss_mesh_find_crossings(whole, &crossing, &is_complete));
    assert_int_equal(faults->triangle_count, crossing.count);
    ss_mesh_destroy(&whole);
    ss_mesh_destroy(&faults);
    static const tool_row answers[] = {
        {"convert crossing.obj out.obj --vtk f.vtk", 2, "it goes with --repair"},
        {"convert --repair crossing.obj out.obj --vtk out.obj", 2, "another file"},
        {"convert --repair crossing.obj out.obj --vtk no/such.vtk", 2, "cannot write it"},
    };
    expect_answers(answers, COUNT(answers));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
