/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Signed distances of the tools' shapes, convex meshes. */
#include "common/test.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "contact/contact.h"
#include "contact/convex_cells.h"
#include "contact/shape.h"
#include "contact_fixture.h"
#include "oracles/overlap.h"
#include "rt/memory.h"
#include "rt/vec.h"

static void random_point(double out[3], double size)
{
    for (int k = 0; k < 3; ++k) {
        out[k] = size * (2.0 * random_unit() - 1.0);
    }
}

static ss_tool_pose random_pose_within(double size)
{
    double at[3];
    random_point(at, size);
    return random_pose(at[0], at[1], at[2]);
}

/* ---- a box and a prism as meshes ---- */

static void make_box(double x, double y, double z)
{
    static const int32_t face[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                        {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                        {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    mesh = (ss_mesh){.position = positions, .triangle = triangles, .is_closed = true};
    for (int k = 0; k < 8; ++k) {
        ss_set3(positions[mesh.node_count++], k & 1 ? x : -x, k & 2 ? y : -y, k & 4 ? z : -z);
    }
    for (int f = 0; f < 12; ++f) {
        add_triangle(face[f][0], face[f][1], face[f][2]);
    }
}

/* A prism of n sides about z: nearly a cylinder. */
static void make_prism(int32_t n, double radius, double half_length)
{
    mesh = (ss_mesh){.position = positions, .triangle = triangles, .is_closed = true};
    for (int32_t k = 0; k < 2 * n; ++k) {
        const double angle = 2.0 * SS_PI * (k % n) / n;
        ss_set3(positions[k], radius * cos(angle), radius * sin(angle),
                k < n ? -half_length : half_length);
    }
    mesh.node_count = 2 * n;
    for (int32_t k = 0; k < n; ++k) {
        const int32_t next = (k + 1) % n;
        add_triangle(k, next, k + n);
        add_triangle(next, next + n, k + n);
        if (k > 0 && k + 1 < n) {
            add_triangle(0, next, k);
            add_triangle(n, n + k, n + next);
        }
    }
}

/* ---- closed forms ---- */

static const ss_shape sphere = {.kind = SS_SHAPE_SPHERE, .radius = 2.0};
static const ss_shape capsule = {.kind = SS_SHAPE_CAPSULE, .radius = 1.0, .half_length = 2.0};
static const ss_shape box = {.kind = SS_SHAPE_BOX, .half_extent = {1.0, 2.0, 3.0}};
static const ss_shape cylinder = {.kind = SS_SHAPE_CYLINDER, .radius = 1.0, .half_length = 2.0};
static const ss_shape cone = {.kind = SS_SHAPE_CONE, .radius = 3.0, .half_length = 2.0};

TEST(distances_match_the_closed_forms)
{
    const struct {
        const ss_shape *shape;
        double x[3], distance, normal[3];
    } cases[] = {
        {&sphere, {0.0, 0.0, 5.0}, 3.0, {0.0, 0.0, 1.0}},
        {&sphere, {0.0, -1.0, 0.0}, -1.0, {0.0, -1.0, 0.0}},
        {&sphere, {0.0, 0.0, 0.0}, -2.0, {0.0, 0.0, 1.0}},
        {&capsule, {3.0, 0.0, 1.5}, 2.0, {1.0, 0.0, 0.0}},
        {&capsule, {0.0, 3.0, -6.0}, 4.0, {0.0, 0.6, -0.8}},
        {&capsule, {0.0, 0.0, 1.0}, -1.0, {1.0, 0.0, 0.0}},
        {&box, {0.5, 0.0, 0.0}, -0.5, {1.0, 0.0, 0.0}},
        {&box, {0.0, 0.0, 0.0}, -1.0, {1.0, 0.0, 0.0}},
        {&box, {0.0, -1.9, 0.0}, -0.1, {0.0, -1.0, 0.0}},
        {&box, {4.0, 6.0, 0.0}, 5.0, {0.6, 0.8, 0.0}},
        {&box, {1.0, 0.0, 0.0}, 0.0, {1.0, 0.0, 0.0}},
        {&box, {0.0, 2.0, -7.0}, 4.0, {0.0, 0.0, -1.0}},
        {&cylinder, {4.0, 0.0, 6.0}, 5.0, {0.6, 0.0, 0.8}},
        {&cylinder, {0.0, 0.9, 0.0}, -0.1, {0.0, 1.0, 0.0}},
        {&cylinder, {0.0, 0.0, -1.9}, -0.1, {0.0, 0.0, -1.0}},
        {&cylinder, {0.0, 0.0, 0.0}, -1.0, {1.0, 0.0, 0.0}},
        {&cylinder, {1.0, 0.0, 2.0}, 0.0, {1.0, 0.0, 0.0}},
        {&cone, {0.0, 0.0, 4.0}, 2.0, {0.0, 0.0, 1.0}},
        {&cone, {0.0, 0.0, -5.0}, 3.0, {0.0, 0.0, -1.0}},
        {&cone, {0.0, 7.0, -5.0}, 5.0, {0.0, 0.8, -0.6}},
        {&cone, {0.0, 0.0, -1.9}, -0.1, {0.0, 0.0, -1.0}},
        {&cone, {0.0, 1.5 + 0.8, 0.0 + 0.6}, 1.0, {0.0, 0.8, 0.6}},
        {&cone, {0.0, 0.0, 2.0}, 0.0, {0.8, 0.0, 0.6}},
        {&cone, {3.0, 0.0, -2.0}, 0.0, {0.8, 0.0, 0.6}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        double normal[3];
        assert_near(ss_shape_distance(cases[i].shape, cases[i].x, normal), cases[i].distance,
                    1e-12);
        for (int k = 0; k < 3; ++k) {
            assert_near(normal[k], cases[i].normal[k], 1e-12);
        }
    }
    assert_near(ss_shape_bounding_radius(&capsule), 3.0, 0.0);
    assert_near(ss_shape_bounding_radius(&cylinder), sqrt(5.0), 1e-15);
    assert_near(ss_shape_bounding_radius(&box), sqrt(14.0), 1e-15);
    assert_near(ss_shape_curvature_radius(&capsule), 1.0, 0.0);
    assert_near(ss_shape_curvature_radius(&box), 0.0, 0.0);
    assert_near(ss_shape_inradius(&cone), 1.5, 1e-15); /* 3-4-5 triangle twice */
    assert_near(ss_shape_gyration(&sphere), 0.0, 0.0);
    assert_near(ss_shape_gyration(&capsule), 6.0 / sqrt(12.0), 1e-15);
}

/* Does nothing but tell whether x is inside: independent of the distance code. */
static bool is_inside(const ss_shape *shape, const double x[3])
{
    const double r = hypot(x[0], x[1]);
    const double beyond = fmax(0.0, fabs(x[2]) - shape->half_length);
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        return ss_norm3(x) < shape->radius;
    case SS_SHAPE_CAPSULE:
        return hypot(r, beyond) < shape->radius;
    case SS_SHAPE_BOX:
        return fabs(x[0]) < shape->half_extent[0] && fabs(x[1]) < shape->half_extent[1] &&
               fabs(x[2]) < shape->half_extent[2];
    case SS_SHAPE_CYLINDER:
        return r < shape->radius && fabs(x[2]) < shape->half_length;
    case SS_SHAPE_CONE:
        return fabs(x[2]) < shape->half_length &&
               r < shape->radius * (shape->half_length - x[2]) / (2.0 * shape->half_length);
    case SS_SHAPE_CONVEX:
        break;
    }
    return false;
}

/* Sign by membership; the surface is met exactly after |d| along the gradient, never before in any
 * other direction; the gradient is a unit one and matches differences. */
TEST(distances_survive_random_points)
{
    const ss_shape *solids[] = {&sphere, &capsule, &box, &cylinder, &cone};
    seed_state = 21;
    for (int i = 0; i < 20000; ++i) {
        const ss_shape *shape = solids[i % 5];
        double x[3], normal[3], other[3];
        random_point(x, 5.0);
        const double d = ss_shape_distance(shape, x, normal);
        assert_true((d < 0.0) == is_inside(shape, x));
        assert_near(ss_norm3(normal), 1.0, 1e-12);
        double foot[3];
        ss_madd3(foot, x, -d, normal);
        assert_near(ss_shape_distance(shape, foot, other), 0.0, 1e-9);
        double way[3], short_of[3];
        random_point(way, 1.0);
        ss_normalize3(way);
        ss_madd3(short_of, x, 0.999 * fabs(d), way);
        assert_true(is_inside(shape, short_of) == (d < 0.0));
        /* 1-Lipschitz */
        const double near = ss_shape_distance(shape, short_of, other);
        assert_true(fabs(near - d) <= 0.999 * fabs(d) + 1e-12);
        double ahead[3], behind[3];
        ss_madd3(ahead, x, 1e-6, normal);
        ss_madd3(behind, x, -1e-6, normal);
        const double slope =
            (ss_shape_distance(shape, ahead, other) - ss_shape_distance(shape, behind, other)) /
            2e-6;
        assert_true(slope > 1.0 - 1e-6 || d < 0.0); /* inside, differences may cross a ridge */
    }
}

/* What presses on a point inside: no deeper than it is, 0 at the surface as that is there, and of a
 * gradient that turns with the point and by no jump, over edges and about a cone's apex. */
TEST(depths_are_smooth_where_distances_have_ridges)
{
    const ss_shape *solids[] = {&box, &cylinder, &cone};
    seed_state = 23;
    int met = 0;
    for (int i = 0; i < 60000; ++i) {
        const ss_shape *shape = solids[i % 3];
        double x[3], way[3], normal[3], gradient[3], other[3], aside[3], ahead[3], behind[3];
        random_point(x, 3.0);
        random_point(way, 1.0);
        ss_normalize3(way);
        const double d = ss_shape_distance(shape, x, normal);
        /* On a cylinder's axis, R deep, there is no direction. */
        if (d > -1e-6 || (shape == &cylinder && hypot(x[0], x[1]) < 0.1)) {
            continue;
        }
        ++met;
        const double depth = ss_shape_depth(shape, x, gradient);
        assert_true(depth > 0.25 * -d && depth <= -d * (1.0 + 1e-12));
        assert_true(ss_norm3(gradient) <= 1.0 + 1e-12);
        const double h = 1e-4 * depth;
        ss_madd3(ahead, x, h, way);
        ss_madd3(behind, x, -h, way);
        const double slope =
            (ss_shape_depth(shape, ahead, other) - ss_shape_depth(shape, behind, other)) /
            (2.0 * h);
        assert_near(slope, -ss_dot3(gradient, way), 1e-5);
        ss_madd3(aside, x, 1e-3 * depth, way);
        (void)ss_shape_depth(shape, aside, other);
        ss_sub3(other, other, gradient);
        assert_true(ss_norm3(other) < 0.01);
    }
    assert_true(met > 5000);
}

TEST(depths_begin_at_the_surface_as_distances_do)
{
    const ss_shape *solids[] = {&sphere, &capsule, &box, &cylinder, &cone};
    /* In the middle of a face, just inside; round tools keep the distance everywhere. */
    for (int k = 0; k < 5; ++k) {
        double x[3] = {0.1, 0.2, 0.3}, normal[3], gradient[3];
        for (int step = 0; step < 60 && ss_shape_distance(solids[k], x, normal) < -1e-4; ++step) {
            ss_madd3(x, x, 0.5 * -ss_shape_distance(solids[k], x, normal), normal);
        }
        const double d = ss_shape_distance(solids[k], x, normal);
        assert_near(ss_shape_depth(solids[k], x, gradient), -d, k < 2 ? 0.0 : 1e-3 * -d);
        ss_sub3(gradient, gradient, normal);
        assert_true(ss_norm3(gradient) <= (k < 2 ? 0.0 : 1e-3));
    }
}

TEST(distances_are_never_not_a_number)
{
    const ss_shape *solids[] = {&sphere, &capsule, &box, &cylinder, &cone};
    static const double odd[] = {0.0,    -0.0, 1.0,   -1.0,     2.0, 3.0,
                                 1e-320, 1e40, 1e300, INFINITY, NAN};
    enum { COUNT = sizeof odd / sizeof odd[0] };
    for (int i = 0; i < 5 * COUNT * COUNT * COUNT; ++i) {
        const double x[3] = {odd[i / 5 % COUNT], odd[i / 5 / COUNT % COUNT],
                             odd[i / 5 / COUNT / COUNT]};
        double normal[3];
        const double d = ss_shape_distance(solids[i % 5], x, normal);
        assert_true(d == d);
        assert_near(ss_norm3(normal), 1.0, 1e-9);
        if (!ss_is_finite(x, 3)) {
            assert_true(d > 1e300);
        }
    }
}

/* ---- convex meshes ---- */

TEST(a_box_mesh_is_a_box)
{
    ss_shape hull;
    make_box(1.0, 2.0, 3.0);
    const int64_t before = ss_memory_in_use();
    assert_int_equal(ss_shape_init_convex(&hull, &mesh, NULL), SOFTSIM_OK);
    seed_state = 22;
    for (int i = 0; i < 20000; ++i) {
        double x[3], normal[3], expected_normal[3];
        random_point(x, 5.0);
        const double expected = ss_shape_distance(&box, x, expected_normal);
        assert_near(ss_shape_distance(&hull, x, normal), expected, 1e-12);
        assert_near(ss_dot3(normal, expected_normal), 1.0, 1e-9);
    }
    assert_near(ss_shape_bounding_radius(&hull), sqrt(14.0), 1e-12);
    assert_near(ss_shape_inradius(&hull), 1.0, 1e-12);
    assert_near(ss_shape_gyration(&hull), 6.0 / sqrt(12.0), 1e-12);
    ss_shape_fini(&hull);
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(a_prism_with_many_sides_is_nearly_a_cylinder)
{
    ss_shape hull;
    make_prism(128, 1.0, 2.0);
    for (int32_t t = 0; t < mesh.triangle_count; ++t) { /* inside out is turned */
        const int32_t swap = triangles[t][0];
        triangles[t][0] = triangles[t][1];
        triangles[t][1] = swap;
    }
    assert_int_equal(ss_shape_init_convex(&hull, &mesh, NULL), SOFTSIM_OK);
    seed_state = 23;
    for (int i = 0; i < 5000; ++i) {
        double x[3], normal[3];
        random_point(x, 4.0);
        assert_near(ss_shape_distance(&hull, x, normal), ss_shape_distance(&cylinder, x, normal),
                    4e-4);
        assert_near(ss_norm3(normal), 1.0, 1e-12);
    }
    ss_shape_fini(&hull);
}

/* The hull of random points on an ellipsoid, none of which it holds inside: a triple is a face when
 * all others are on one side of it. */
static void make_random_hull(int32_t count, const double axes[3])
{
    begin_mesh();
    mesh.is_closed = true;
    for (int32_t i = 0; i < count; ++i) {
        double x[3];
        do {
            random_point(x, 1.0);
        } while (ss_norm3(x) > 1.0 || ss_norm3(x) < 0.1);
        ss_normalize3(x);
        add_node(0.3 + axes[0] * x[0], axes[1] * x[1], axes[2] * x[2]);
    }
    for (int32_t a = 0; a < count; ++a) {
        for (int32_t b = a + 1; b < count; ++b) {
            for (int32_t c = b + 1; c < count; ++c) {
                int32_t above = 0;
                for (int32_t d = 0; d < count; ++d) {
                    above += d != a && d != b && d != c &&
                             ss_six_volumes3(positions[a], positions[b], positions[c],
                                             positions[d]) > 0.0;
                }
                if (above == 0) {
                    add_triangle(a, b, c);
                } else if (above == count - 3) {
                    add_triangle(a, c, b);
                }
            }
        }
    }
}

static double distance_to_segment(const double a[3], const double b[3], const double x[3])
{
    double ab[3], ax[3];
    ss_sub3(ab, b, a);
    ss_sub3(ax, x, a);
    ss_madd3(ax, ax, -fmax(0.0, fmin(1.0, ss_dot3(ax, ab) / ss_dot3(ab, ab))), ab);
    return ss_norm3(ax);
}

/* The signed distance of x, by all faces: the highest plane inside; outside the nearest face that
 * x is straight above, or the nearest edge. */
static double distance_by_all_faces(const double x[3])
{
    double highest = -DBL_MAX, nearest = DBL_MAX;
    for (int32_t t = 0; t < mesh.triangle_count; ++t) {
        const double *corner[3];
        double n[3], ax[3];
        bool is_above = true;
        for (int k = 0; k < 3; ++k) {
            corner[k] = positions[triangles[t][k]];
        }
        ss_normal3(n, corner[0], corner[1], corner[2]);
        ss_normalize3(n);
        ss_sub3(ax, x, corner[0]);
        const double height = ss_dot3(n, ax);
        highest = fmax(highest, height);
        for (int k = 0; k < 3; ++k) {
            double side[3];
            ss_normal3(side, corner[k], corner[(k + 1) % 3], x);
            is_above = is_above && ss_dot3(side, n) >= 0.0;
            nearest = fmin(nearest, distance_to_segment(corner[k], corner[(k + 1) % 3], x));
        }
        nearest = is_above ? fmin(nearest, fabs(height)) : nearest;
    }
    return highest <= 0.0 ? highest : nearest;
}

TEST(a_hull_is_as_far_as_all_its_faces_say)
{
    static const double axes[][3] = {{1.0, 1.0, 1.0}, {1.0, 0.7, 0.05}, {0.1, 0.15, 2.0}};
    static const int32_t points[] = {4, 9, 40, 100};
    int32_t inside = 0;
    seed_state = 27;
    for (int k = 0; k < 12; ++k) {
        ss_shape hull;
        make_random_hull(points[k % 4], axes[k % 3]);
        assert_int_equal(mesh.triangle_count, 2 * points[k % 4] - 4);
        const int64_t before = ss_memory_in_use();
        assert_int_equal(ss_shape_init_convex(&hull, &mesh, NULL), SOFTSIM_OK);
        for (int i = 0; i < 6000; ++i) {
            double x[3], normal[3], ahead[3];
            random_point(x, 1.0);
            for (int d = 0; d < 3; ++d) { /* a third in its box, others about it and far */
                x[d] = (d == 0 ? 0.3 : 0.0) + axes[k % 3][d] * x[d] * (i % 3 == 0 ? 1.0 : 1.6) +
                       (i % 30 == 1 ? 3.0 * x[d] : 0.0);
            }
            const double expected = distance_by_all_faces(x);
            const double d = ss_shape_distance(&hull, x, normal);
            assert_near(d, expected, 1e-12);
            ss_madd3(ahead, x, -0.5 * fmax(d, 0.0), normal); /* half the way to the nearest point */
            assert_near(ss_shape_distance(&hull, ahead, normal), d - 0.5 * fmax(d, 0.0), 1e-12);
            /* With a limit: the distance where it is below it, else no more than the distance. */
            const double limit = 0.2 * random_unit();
            const double known = ss_shape_distance_below(&hull, x, limit, normal);
            if (expected < limit - 1e-12) {
                assert_near(known, expected, 1e-12);
            } else {
                assert_true(known >= limit - 1e-12 && known <= expected + 1e-12);
            }
            inside += expected < 0.0;
        }
        ss_shape_fini(&hull);
        assert_int_equal(ss_memory_in_use(), before);
    }
    assert_true(inside > 2000);
}

/* A tool of many faces asks few of them: those near the answer. */
TEST(a_hull_of_many_faces_asks_few)
{
    static const double axes[3] = {1.0, 1.0, 1.0};
    ss_shape hull;
    seed_state = 28;
    make_random_hull(114, axes);
    assert_int_equal(mesh.triangle_count, 224);
    assert_int_equal(ss_shape_init_convex(&hull, &mesh, NULL), SOFTSIM_OK);
    const int32_t point_count = 4000;
    double planes = 0.0, edges = 0.0;
    for (int32_t i = 0; i < point_count; ++i) { /* from half the radius to a fifth above the face */
        double x[3];
        random_point(x, 1.0);
        ss_normalize3(x);
        ss_scale3(x, x, 0.5 + 0.7 * random_unit());
        x[0] += 0.3;
        const ss_convex_cell *cell = ss_convex_find_cell(hull.convex, x);
        assert_non_null(cell);
        planes += (double)(cell->triangle - cell->plane) / point_count;
        edges += (double)(cell->end - cell->edge) / point_count;
    }
    print_message("of 224 faces a point asks %.1f planes, and outside %.1f edges\n", planes, edges);
    assert_true(planes < 10.0 && edges < 30.0);
    ss_shape_fini(&hull);
}

static void expect_refusal(const char *text)
{
    ss_shape hull;
    softsim_error error = {0};
    const int64_t before = ss_memory_in_use();
    assert_int_equal(ss_shape_init_convex(&hull, &mesh, &error), SOFTSIM_ERROR_MESH);
    if (strstr(error.text, text) == NULL) {
        fail_msg("'%s' is not in '%s'", text, error.text);
    }
    assert_int_equal(ss_memory_in_use(), before);
    ss_shape_fini(&hull);
}

TEST(refuses_meshes_that_are_not_convex)
{
    make_box(1.0, 1.0, 1.0);
    ss_set3(positions[7], 0.2, 0.2, 0.2); /* a dented corner */
    expect_refusal("not convex");
    make_box(1.0, 1.0, 1.0);
    mesh.is_closed = false;
    expect_refusal("not closed");
    make_box(1.0, 1.0, 0.0);
    expect_refusal("no volume");
    make_box(1.0, NAN, 1.0);
    expect_refusal("no volume");
    make_prism(255, 1.0, 1.0);
    expect_refusal("256 faces");
    make_box(1.0, 1.0, 1.0);
    mesh.triangle_count = 3;
    expect_refusal("4 to 2048");
    make_box(1.0, 1.0, 1.0);
    for (int f = 0; f < 12; ++f) { /* each there twice */
        add_triangle(triangles[f][1], triangles[f][2], triangles[f][0]);
    }
    expect_refusal("more than two faces at an edge");
    /* Slightly dented, within the tolerance: distance stays 1-Lipschitz and meets the planes. */
    make_box(1.0, 1.0, 1.0);
    positions[7][0] = 1.001;
    ss_shape hull;
    assert_int_equal(ss_shape_init_convex(&hull, &mesh, NULL), SOFTSIM_OK);
    double last = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const double x[3] = {0.99 + 1e-5 * i, 0.3, 0.9};
        double normal[3];
        const double d = ss_shape_distance(&hull, x, normal);
        assert_true(i == 0 || fabs(d - last) <= 1.001e-5);
        last = d;
    }
    ss_shape_fini(&hull);
}

/* ---- poses ---- */

TEST(blending_stays_within_the_motion_bound)
{
    seed_state = 24;
    for (int i = 0; i < 2000; ++i) {
        const ss_tool_pose from = random_pose_within(1.0);
        const ss_tool_pose to = random_pose_within(1.0);
        ss_tool_pose at;
        double x[3], a[3], b[3];
        random_point(x, 1.0);
        ss_normalize3(x);
        ss_scale3(x, x, ss_shape_bounding_radius(&capsule));
        const double s = random_unit();
        ss_tool_pose_blend(&from, &to, s, &at);
        ss_rotate(a, from.orientation, x);
        ss_rotate(b, at.orientation, x);
        ss_add3(a, a, from.position);
        ss_add3(b, b, at.position);
        ss_sub3(a, a, b);
        assert_true(ss_norm3(a) <= ss_tool_motion_bound(&capsule, &from, &to) + 1e-12);
        double length = 0.0;
        for (int k = 0; k < 4; ++k) {
            length += at.orientation[k] * at.orientation[k];
        }
        assert_near(length, 1.0, 1e-12);
        ss_tool_pose_blend(&from, &to, 1.0, &at);
        assert_near(ss_tool_motion_bound(&capsule, &to, &at), 0.0, 1e-6);
    }
}

/* ---- an independent judge ---- */

/* Spheres against every shape: the overlap is known from the distance of the centre. Millimetres.
 */
TEST(distances_and_supports_agree_with_libccd)
{
    const ss_shape ball = {.kind = SS_SHAPE_SPHERE, .radius = 0.002};
    ss_shape solids[] = {
        {.kind = SS_SHAPE_SPHERE, .radius = 0.003},
        {.kind = SS_SHAPE_CAPSULE, .radius = 0.002, .half_length = 0.004},
        {.kind = SS_SHAPE_BOX, .half_extent = {0.002, 0.003, 0.004}},
        {.kind = SS_SHAPE_CYLINDER, .radius = 0.002, .half_length = 0.004},
        {.kind = SS_SHAPE_CONE, .radius = 0.003, .half_length = 0.004},
        {.kind = SS_SHAPE_CONVEX},
    };
    make_box(0.002, 0.003, 0.004);
    assert_int_equal(ss_shape_init_convex(&solids[5], &mesh, NULL), SOFTSIM_OK);
    seed_state = 25;
    int overlaps = 0;
    for (int i = 0; i < 30000; ++i) {
        const ss_shape *shape = &solids[i % 6];
        const ss_tool_pose a = random_pose_within(0.005);
        const ss_tool_pose b = random_pose_within(0.005);
        double r[3], local[3], normal[3];
        ss_sub3(r, b.position, a.position);
        ss_rotate_back(local, a.orientation, r);
        const double gap = ss_shape_distance(shape, local, normal) - ball.radius;
        if (fabs(gap) > 2e-6) {
            assert_true(do_shapes_overlap(shape, &a, &ball, &b) == (gap < 0.0));
            overlaps += gap < 0.0;
        }
    }
    assert_true(overlaps > 5000);
    ss_shape_fini(&solids[5]);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
