/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Friction of a tool on the contact surface: the return mapping of its samples. */
#include "common/test.h"
#include "contact_fixture.h"

#define MU    0.3
#define DEPTH 0.0003 /* m, of a sphere of 5 mm */

static double lost, stored; /* J, of the last place */

static void begin(double coefficient, const double *by_node)
{
    make_plane(40, 40, 0.002);
    open_query(&sphere_5mm, 0, 0.003, 1e8);
    assert_int_equal(ss_contact_query_add_friction(query, coefficient, by_node), SOFTSIM_OK);
    seed_state = 11;
}

/* The friction on the tool at a place, tried. */
static void try(const ss_tool_pose *pose, double out_friction[3])
{
    double torque[3] = {0.0, 0.0, 0.0};
    broad_phase(pose, pose);
    penalty(pose);
    ss_set3(out_friction, 0.0, 0.0, 0.0);
    const ss_friction_energy energy =
        ss_contact_query_friction(query, pose, 1.0, force, out_friction, torque);
    lost = energy.lost;
    stored = energy.stored;
}

static void go(const ss_tool_pose *pose, double out_friction[3])
{
    try(pose, out_friction);
    ss_contact_query_keep_friction(query);
}

static ss_tool_pose sphere_at(double x, double y, double depth)
{
    return pose_at(x, y, 0.005 - depth);
}

/* At DEPTH over the middle, where nothing has slid yet. */
static ss_tool_pose begin_pressed(double friction[3])
{
    begin(MU, NULL);
    const ss_tool_pose pose = sphere_at(0.0, 0.0, DEPTH);
    go(&pose, friction);
    return pose;
}

TEST(a_tool_sticks_and_then_slides_at_the_limit)
{
    double friction[3], last = 0.0;
    ss_tool_pose pose = begin_pressed(friction);
    assert_near(ss_norm3(friction), 0.0, 0.0);
    const double normal = tool_force[2];
    assert_true(normal > 0.0);
    for (int n = 1; n <= 300; ++n) {
        pose = sphere_at(1e-6 * n, 0.0, DEPTH);
        go(&pose, friction);
        assert_true(-friction[0] > last - 1e-3 * normal);
        assert_true(lost >= 0.0);
        last = -friction[0];
        if (n ==
            1) { /* all of it sticks: kc times the area in touch, 2 pi R d of a sheet, nearly */
            const double stiffness = 1e8 * 2.0 * SS_PI * 0.005 * DEPTH;
            assert_near(last / (stiffness * 1e-6), 1.0, 0.1);
            assert_near(lost, 0.0, 0.05 * stored);
        }
    }
    assert_near(last / normal, MU, 0.02 * MU);
    assert_near(fabs(friction[1]) / last, 0.0, 0.02);
    close_query();
}

/* The forces on the nodes and on the tool are one another's opposite. */
TEST(what_the_tool_feels_the_tissue_gets)
{
    double friction[3], sum[3] = {0.0, 0.0, 0.0};
    ss_tool_pose pose = begin_pressed(friction);
    pose = sphere_at(0.0001, -0.00005, DEPTH);
    go(&pose, friction);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            sum[k] += (double)force[4 * i + k];
        }
    }
    for (int k = 0; k < 3; ++k) {
        assert_near(sum[k], -(tool_force[k] + friction[k]), 1e-5 * ss_norm3(tool_force));
    }
    close_query();
}

/* Held below the limit while the depth shakes by a hundredth: the rim, which slides first, finds
 * its place; then nothing moves any more. */
TEST(what_sticks_does_not_creep)
{
    double friction[3], first[3];
    ss_tool_pose pose = begin_pressed(friction);
    pose = sphere_at(2e-5, 0.0, DEPTH);
    go(&pose, first);
    for (int n = 0; n <= 60000; ++n) {
        const bool is_still = n == 2000 || n == 60000;
        pose = sphere_at(2e-5, 0.0, DEPTH * (is_still ? 1.0 : 1.0 + 0.01 * random_unit()));
        go(&pose, friction);
        if (n == 2000) {
            assert_near(friction[0] / first[0], 1.0, 0.01);
            ss_copy3(first, friction);
        }
    }
    assert_near(friction[0] / first[0], 1.0, 1e-4);
    close_query();
}

/* W of the tool against friction, less what the springs hold: never below 0, whatever the way. */
TEST(random_walks_never_gain_energy)
{
    for (int turn = 0; turn < 2; ++turn) {
        double friction[3], before[3] = {0.0, 0.0, 0.0};
        double work = 0.0, losses = 0.0, largest = 0.0;
        double x = 0.0, y = 0.0, depth = DEPTH, vx = 0.0, vy = 0.0, vz = 0.0;
        begin(MU, NULL);
        ss_tool_pose last = sphere_at(0.0, 0.0, depth), pose = last;
        go(&last, before);
        for (int n = 0; n < 5000; ++n) {
            vx += 2e-6 * (random_unit() - 0.5) - 1e-4 * x;
            vy += 2e-6 * (random_unit() - 0.5) - 1e-4 * y;
            vz += 1e-6 * (random_unit() - 0.5) - 1e-3 * (depth - DEPTH);
            vx *= 0.99, vy *= 0.99, vz *= 0.99;
            x += vx, y += vy, depth += vz;
            pose = sphere_at(x, y, depth);
            if (turn == 1) {
                pose.orientation[0] = cos(10.0 * x);
                pose.orientation[3] = sin(10.0 * x);
            }
            double way[3];
            go(&pose, friction);
            ss_sub3(way, pose.position, last.position);
            work -= ss_dot3(friction, way);
            losses += lost;
            largest = fmax(largest, stored);
            assert_true(lost >= 0.0);
            if (turn == 0) { /* a turn works, too */
                assert_true(work - stored >= -1e-6 * largest);
            }
            last = pose;
        }
        assert_true(losses > 10.0 * largest);
        if (turn == 0) {
            assert_near(losses + stored, work, 0.05 * work);
        }
        close_query();
    }
}

TEST(a_place_that_is_only_tried_leaves_nothing)
{
    double friction[3], again[3];
    begin(MU, NULL);
    ss_tool_pose pose = sphere_at(0.0, 0.0, DEPTH), far = sphere_at(0.001, 0.0, 2.0 * DEPTH);
    go(&pose, friction);
    pose = sphere_at(2e-5, 0.0, DEPTH);
    go(&pose, friction);
    const uint64_t hash = ss_contact_query_hash_friction(query, 1);
    try(&far, again);
    assert_true(ss_contact_query_hash_friction(query, 1) == hash);
    try(&pose, again);
    ss_sub3(again, again, friction);
    assert_near(ss_norm3(again), 0.0, 1e-6 * ss_norm3(friction));
    ss_contact_query_forget_friction(query);
    go(&pose, again);
    assert_near(ss_norm3(again), 0.0, 0.0);
    close_query();
}

TEST(comes_off_without_a_force_and_loses_what_it_held)
{
    double friction[3];
    ss_tool_pose pose = begin_pressed(friction);
    pose = sphere_at(0.0005, 0.0, DEPTH);
    go(&pose, friction);
    const double held = stored;
    assert_true(held > 0.0);
    pose = sphere_at(0.0005, 0.0, -0.001);
    go(&pose, friction);
    assert_near(ss_norm3(friction), 0.0, 0.0);
    assert_near(stored, 0.0, 0.0);
    assert_near(lost, held, 1e-9 * held);
    close_query();
}

TEST(each_node_may_have_its_coefficient)
{
    static double by_node[MAX_NODES];
    double friction[3];
    make_plane(40, 40, 0.002);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        by_node[i] = positions[i][0] < 0.0 ? 0.1 : 0.5;
    }
    begin(0.0, by_node);
    for (int side = -1; side <= 1; side += 2) {
        double normal = 0.0;
        for (int n = 0; n <= 400; ++n) {
            const ss_tool_pose pose = sphere_at(0.015 * side, 2e-6 * n, DEPTH);
            go(&pose, friction);
            normal = tool_force[2];
        }
        assert_near(-friction[1] / normal, side < 0 ? 0.1 : 0.5, 0.01);
    }
    close_query();
}

/* What comes to touch in a press has no spring yet, wherever the press is tried: its tangent is
 * that of a contact without friction, however small or large the coefficient. */
TEST(the_tangent_holds_nothing_that_has_just_come_to_touch)
{
    double free_change[3], friction[3], change[3] = {0.0, 0.0, 0.0};
    const double way[3] = {1.0, 0.0, 0.0};
    make_plane(40, 40, 0.002);
    open_query(&sphere_5mm, 0, 0.003, 1e8);
    ss_tool_pose pose = sphere_at(0.0, 0.0, DEPTH);
    broad_phase(&pose, &pose);
    penalty(&pose);
    ss_set3(free_change, 0.0, 0.0, 0.0);
    ss_contact_query_tangent(query, NULL, way, NULL, free_change);
    close_query();
    pose = begin_pressed(friction);
    ss_contact_query_tangent(query, NULL, way, NULL, change);
    for (int k = 0; k < 3; ++k) {
        assert_near(change[k], free_change[k], 0.0);
    }
    close_query();
}

/* The tangent is the force's change while all of it sticks, and no more than that when it slides.
 */
TEST(the_tangent_holds_what_sticks)
{
    double friction[3], change[3];
    ss_tool_pose pose = begin_pressed(friction);
    go(&pose, friction);
    for (int slides = 0; slides < 2; ++slides) {
        ss_set3(change, 0.0, 0.0, 0.0);
        ss_contact_query_tangent(query, NULL, (double[3]){1.0, 0.0, 0.0}, NULL, change);
        const double stiffness = 1e8 * 2.0 * SS_PI * 0.005 * DEPTH;
        assert_true(slides ? -change[0] < 0.5 * stiffness && change[0] < 0.0
                           : fabs(-change[0] / stiffness - 1.0) < 0.1);
        pose = sphere_at(0.002, 0.0, DEPTH);
        go(&pose, friction);
        penalty(&pose);
        pose = sphere_at(0.0022, 0.0, DEPTH);
        go(&pose, friction);
    }
    close_query();
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
