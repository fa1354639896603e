/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Where a hand first meets a body: against spheres and boxes, whose answer is known. */
#include "common/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/touch.h"
#include "rt/vec.h"

enum { RINGS = 32, COLUMNS = 48, MOST_NODES = 2 * (RINGS * COLUMNS + 2), MOST = 2 * MOST_NODES };
static double position[MOST_NODES][3];
static int32_t triangle[MOST][3];
static uint8_t fixed[MOST_NODES];
static ss_touch_body body;

static void begin(void)
{
    memset(fixed, 0, sizeof fixed);
    body =
        (ss_touch_body){0, 0, (const double(*)[3])position, (const int32_t(*)[3])triangle, fixed};
}

static void add_triangle(int32_t a, int32_t b, int32_t c)
{
    const int32_t corner[3] = {a, b, c};
    memcpy(triangle[body.triangle_count++], corner, sizeof corner);
}

/* A globe: outward normals. */
static void add_globe(double radius, double x, double y, double z)
{
    const int32_t first = body.node_count;
    for (int r = 0; r <= RINGS; ++r) {
        for (int c = 0; c < (r % RINGS == 0 ? 1 : COLUMNS); ++c) {
            const double theta = SS_PI * r / RINGS, phi = 2.0 * SS_PI * c / COLUMNS;
            ss_set3(position[body.node_count++], x + radius * sin(theta) * cos(phi),
                    y + radius * sin(theta) * sin(phi), z + radius * cos(theta));
        }
    }
    const int32_t last = body.node_count - 1;
    for (int c = 0; c < COLUMNS; ++c) {
        const int32_t d = (c + 1) % COLUMNS;
        add_triangle(first, first + 1 + c, first + 1 + d);
        for (int r = 0; r < RINGS - 2; ++r) {
            const int32_t row = first + 1 + r * COLUMNS, next = row + COLUMNS;
            add_triangle(row + c, next + c, next + d);
            add_triangle(row + c, next + d, row + d);
        }
        add_triangle(last - COLUMNS + c, last, last - COLUMNS + d);
    }
}

static void add_box(const double low[3], const double high[3])
{
    static const int32_t face[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                        {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                        {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    const int32_t first = body.node_count;
    for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 3; ++k) {
            position[body.node_count][k] = (i >> k & 1) != 0 ? high[k] : low[k];
        }
        ++body.node_count;
    }
    for (int f = 0; f < 12; ++f) {
        add_triangle(first + face[f][0], first + face[f][1], first + face[f][2]);
    }
}

static const double sides[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                   {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

TEST(a_ball_touches_a_globe_where_the_radii_add_up)
{
    const ss_touch_end end = {0.008, 0.0, true};
    begin();
    add_globe(0.05, 0.1, -0.2, 0.3);
    for (int s = 0; s < 6; ++s) {
        ss_touch touch;
        double way[3];
        assert_true(ss_touch_find(&body, sides[s], &end, &touch));
        ss_set3(way, touch.origin[0] - 0.1, touch.origin[1] + 0.2, touch.origin[2] - 0.3);
        /* Its facets lie up to R (1 - cos(pi / 32)) inside it. */
        assert_true(ss_norm3(way) < 0.058 + 1e-6 && ss_norm3(way) > 0.058 - 0.05 * 0.005);
        assert_true(ss_dot3(way, sides[s]) > 0.99 * ss_norm3(way)); /* on its middle */
        assert_true(ss_dot3(touch.normal, sides[s]) > 0.98);
    }
}

TEST(every_end_comes_down_on_its_lowest_point)
{
    static const double extent[3] = {0.003, 0.004, 0.02};
    const ss_shape shape[] = {
        {.kind = SS_SHAPE_SPHERE, .radius = 0.006},
        {.kind = SS_SHAPE_CAPSULE, .radius = 0.006, .half_length = 0.01},
        {.kind = SS_SHAPE_CYLINDER, .radius = 0.006, .half_length = 0.01},
        {.kind = SS_SHAPE_CONE, .radius = 0.006, .half_length = 0.01},
        {.kind = SS_SHAPE_BOX, .half_extent = {extent[0], extent[1], extent[2]}}};
    static const double reach[] = {0.006, 0.016, 0.01, 0.01, 0.02};
    static const double low[3] = {-0.05, -0.05, -0.02}, high[3] = {0.05, 0.05, 0.02};
    begin();
    add_box(low, high);
    /* A node in the middle of its upper side: the corners are no level place to press. */
    ss_set3(position[body.node_count], 0.0, 0.0, 0.02);
    triangle[2][2] = triangle[3][2] = body.node_count;
    add_triangle(4, body.node_count, 6);
    add_triangle(6, body.node_count, 7);
    ++body.node_count;
    for (size_t i = 0; i < sizeof reach / sizeof *reach; ++i) {
        const ss_touch_end end = ss_touch_end_of(&shape[i]);
        ss_touch touch;
        assert_true(ss_touch_find(&body, sides[4], &end, &touch));
        assert_true(fabs(touch.origin[2] - 0.02 - reach[i]) < 1e-12);
        assert_true(fabs(touch.origin[0]) + fabs(touch.origin[1]) < 1e-12);
    }
}

/* What is held is no place to press, nor what is hidden behind something else. */
TEST(a_hand_comes_down_beside_what_is_held_or_hidden)
{
    const ss_touch_end end = {0.004, 0.0, true};
    ss_touch touch;
    begin();
    add_globe(0.05, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < body.node_count; ++i) {
        fixed[i] = position[i][2] > 0.04;
    }
    assert_true(ss_touch_find(&body, sides[4], &end, &touch));
    assert_true(touch.point[2] <= 0.04 && touch.origin[2] > 0.0);
    memset(fixed, 1, sizeof fixed);
    assert_false(ss_touch_find(&body, sides[4], &end, &touch));

    static const double low[3] = {-0.03, -0.03, 0.06}, high[3] = {0.03, 0.03, 0.061};
    memset(fixed, 0, sizeof fixed);
    const int32_t globe = body.node_count;
    add_box(low, high);
    memset(fixed + globe, 1, (size_t)(body.node_count - globe));
    assert_true(ss_touch_find(&body, sides[4], &end, &touch));
    assert_true(hypot(touch.origin[0], touch.origin[1]) > 0.03);
    assert_true(ss_touch_find(&body, sides[5], &end, &touch)); /* from below it is free */
    assert_true(hypot(touch.origin[0], touch.origin[1]) < 0.01);
}

TEST(distances_are_those_of_a_box)
{
    static const double low[3] = {-0.05, -0.05, -0.02}, high[3] = {0.05, 0.05, 0.02};
    static const double place[][3] = {{0.0, 0.01, 0.05}, {0.08, 0.0, 0.06}, {0.06, 0.07, 0.04}};
    static const double expected[] = {0.03, 0.05, 0.03};
    double on[3];
    begin();
    assert_true(isinf(ss_touch_distance(&body, place[0], on)));
    add_box(low, high);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
        assert_true(fabs(ss_touch_distance(&body, place[i], on) - expected[i]) < 1e-12);
    }
    assert_true(fabs(on[0] - 0.05) + fabs(on[1] - 0.05) + fabs(on[2] - 0.02) < 1e-12);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
