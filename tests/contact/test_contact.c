/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A tool that touches the contact surface. Rows: test_contact_surface.c; shapes:
 * test_contact_shape.c. */
#include "common/test.h"
#include "contact_fixture.h"
#include "rt/each.h"

/* ---- forces are gradients ---- */

/* Turns the pose by a small vector (world), about the tool's origin. */
static ss_tool_pose turned(const ss_tool_pose *pose, int axis, double angle)
{
    ss_tool_pose out = *pose;
    double q[4] = {cos(0.5 * angle), 0.0, 0.0, 0.0};
    q[1 + axis] = sin(0.5 * angle);
    const double *p = pose->orientation;
    out.orientation[0] = q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3];
    out.orientation[1] = q[0] * p[1] + q[1] * p[0] + q[2] * p[3] - q[3] * p[2];
    out.orientation[2] = q[0] * p[2] - q[1] * p[3] + q[2] * p[0] + q[3] * p[1];
    out.orientation[3] = q[0] * p[3] + q[1] * p[2] - q[2] * p[1] + q[3] * p[0];
    return out;
}

static const double *test_mu; /* per mesh node */

/* Either potential: the penalty's, or sum mu_i w_i. */
static double potential(const ss_tool_pose *pose)
{
    if (test_mu == NULL) {
        return ss_contact_query_penalty(query, u, pose, NULL, (double[3]){0}, (double[3]){0});
    }
    const int32_t *node;
    const double *weight;
    double total;
    double sum = 0.0;
    const int32_t count = ss_contact_query_weigh(query, u, NULL, pose, &node, &weight, &total);
    for (int32_t i = 0; i < count; ++i) {
        sum += test_mu[node[i]] * weight[i];
    }
    return sum;
}

/* Compares force, tool_force and tool_torque with differences of the potential. */
static void check_gradient(const ss_tool_pose *pose, double step, double relative)
{
    double largest = 0.0;
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        for (int c = 0; c < 3; ++c) {
            largest = fmax(largest, fabs((double)force[4 * i + c]));
        }
    }
    assert_true(largest > 0.0);
    int checked = 0;
    for (int32_t i = 0; i < mesh.node_count && checked < 12; ++i) {
        if (force[4 * i] == 0 || (checked > 5 && random_unit() < 0.5)) {
            continue;
        }
        checked++;
        for (int c = 0; c < 3; ++c) {
            const ss_real keep = u[4 * i + c];
            u[4 * i + c] = (ss_real)((double)keep + step);
            const double above = potential(pose);
            const double top = (double)u[4 * i + c];
            u[4 * i + c] = (ss_real)((double)keep - step);
            const double below = potential(pose);
            const double width = top - (double)u[4 * i + c];
            u[4 * i + c] = keep;
            assert_near((double)force[4 * i + c], (below - above) / width, relative * largest);
        }
    }
    assert_true(checked >= 5);
    const double whole = ss_norm3(tool_force) + largest;
    for (int c = 0; c < 3; ++c) {
        ss_tool_pose up = *pose;
        ss_tool_pose down = *pose;
        up.position[c] += step;
        down.position[c] -= step;
        assert_near(tool_force[c], (potential(&down) - potential(&up)) / (2.0 * step),
                    relative * whole);
        up = turned(pose, c, step / 0.005);
        down = turned(pose, c, -step / 0.005);
        assert_near(tool_torque[c], (potential(&down) - potential(&up)) / (2.0 * step / 0.005),
                    0.01 * relative * whole);
    }
}

/* The potential's second derivative jumps where a sample touches: a difference over `step` is off
 * by about its area over the contact's, times step over depth. */
TEST(penalty_forces_are_minus_the_gradient)
{
    make_sphere(3, 0.04);
    test_mu = NULL;
    seed_state = 11;
    for (int k = 0; k < SHAPE_COUNT; ++k) {
        open_query(&shapes[k], 2, 0.005, 5e7);
        shake_nodes(0.001);
        const ss_tool_pose pose = random_pose(0.0235, 0.0235, 0.0235);
        broad_phase(&pose, &pose);
        assert_true(penalty(&pose) > 0.0);
        check_gradient(&pose, IS_DOUBLE ? 1e-9 : 1e-5, IS_DOUBLE ? 1e-5 : 0.03);
        close_query();
    }
}

TEST(weight_forces_are_minus_the_gradient)
{
    static double mu[MAX_NODES];
    make_sphere(3, 0.04);
    seed_state = 12;
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        mu[i] = random_unit() - 0.3;
    }
    for (int k = 0; k < SHAPE_COUNT; ++k) {
        open_query(&shapes[k], 1, 0.008, 1.0);
        shake_nodes(0.001);
        const ss_tool_pose pose = random_pose(0.024, 0.024, 0.024);
        broad_phase(&pose, &pose);
        const int32_t *node;
        const double *weight;
        double listed[MAX_NODES], total;
        double sum = 0.0;
        const int32_t count = ss_contact_query_weigh(query, u, NULL, &pose, &node, &weight, &total);
        for (int32_t i = 0; i < count; ++i) {
            assert_true(weight[i] > 0.0);
            assert_true(i == 0 || node[i] > node[i - 1]);
            sum += weight[i];
            listed[i] = mu[node[i]];
        }
        assert_near(sum, total, 1e-15);
        clear_forces();
        ss_contact_query_weight_forces(query, listed, force, tool_force, tool_torque);
        test_mu = mu;
        check_gradient(&pose, IS_DOUBLE ? 1e-9 : 1e-5, IS_DOUBLE ? 1e-5 : 0.02);
        test_mu = NULL;
        close_query();
    }
}

TEST(forces_of_tissue_and_tool_cancel)
{
    make_sphere(3, 0.04);
    seed_state = 13;
    open_query(&shapes[1], 2, 0.005, 5e7);
    const ss_tool_pose pose = random_pose(0.0235, 0.0235, 0.0235);
    broad_phase(&pose, &pose);
    penalty(&pose);
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        for (int c = 0; c < 3; ++c) {
            sum[c] += (double)force[4 * i + c];
        }
        assert_true(force[4 * i + 3] == 0);
    }
    for (int c = 0; c < 3; ++c) {
        assert_near(sum[c], -tool_force[c], (IS_DOUBLE ? 1e-13 : 1e-5) * ss_norm3(tool_force));
    }
    close_query();
}

/* ---- weights ---- */

/* W = sqrt(3)/2 h^2 phi(d): one linear sample in each triangle of a hexagon, rim fixed. */
TEST(hexagon_fan_has_the_weight_of_the_closed_form)
{
    static const double height[2] = {0.25, 0.17};
    static const double expected[2] = {0.0245357960952869, 0.0615903130631309};
    static const uint8_t is_source[7] = {1, 0, 0, 0, 0, 0, 0};
    const ss_shape ball = {.kind = SS_SHAPE_SPHERE, .radius = 0.25};
    const double h = 0.3;
    begin_mesh();
    add_node(0.0, 0.0, 0.0);
    for (int k = 0; k < 6; ++k) {
        add_node(h * cos(k * 1.0471975511965976), h * sin(k * 1.0471975511965976), 0.0);
    }
    for (int32_t k = 0; k < 6; ++k) {
        add_triangle(0, 1 + k, 1 + (k + 1) % 6);
    }
    open_query(&ball, SS_SURFACE_CENTROIDS, 0.2, 400.0);
    u[2] = (ss_real)-0.12;
    for (int k = 0; k < 2; ++k) {
        const int32_t *node;
        const double *weight;
        double total;
        const ss_tool_pose pose = pose_at(0.0, 0.0, height[k]);
        broad_phase(&pose, &pose);
        assert_int_equal(ss_contact_query_weigh(query, u, is_source, &pose, &node, &weight, &total),
                         1);
        assert_int_equal(node[0], 0);
        assert_near(total, expected[k], IS_DOUBLE ? 1e-15 : 1e-7);
    }
    /* And the penalty at X = 0.11: six samples with d = -0.0208712152522080. */
    const ss_tool_pose deep = pose_at(0.0, 0.0, 0.11);
    broad_phase(&deep, &deep);
    assert_near(penalty(&deep), 0.0203713525955681, IS_DOUBLE ? 1e-15 : 2e-7);
    assert_near(tool_force[2], 1.27794961556580, IS_DOUBLE ? 1e-13 : 1e-5);
    close_query();
}

/* ---- results without the broad phase ---- */

TEST(broad_phase_radius_does_not_change_a_bit)
{
    static ss_real kept[4 * MAX_NODES];
    static int32_t kept_node[MAX_NODES];
    static double kept_weight[MAX_NODES];
    make_sphere(3, 0.04);
    seed_state = 14;
    for (int k = 0; k < SHAPE_COUNT; ++k) {
        open_query(&shapes[k], 2, 0.006, 5e7);
        shake_nodes(0.001);
        const ss_tool_pose pose = random_pose(0.0235, 0.0235, 0.0235);
        const ss_tool_pose away = pose_at(-0.06, 0.05, 0.01);
        double first_force[3], energy[2];
        int32_t count[2], reach[2];
        for (int wide = 0; wide < 2; ++wide) {
            const int32_t *node;
            const double *weight;
            double total;
            reach[wide] = broad_phase(wide ? &away : &pose, &pose);
            count[wide] = ss_contact_query_weigh(query, u, NULL, &pose, &node, &weight, &total);
            energy[wide] = penalty(&pose);
            const size_t bytes = (size_t)count[wide];
            if (wide == 0) {
                memcpy(kept, force, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
                memcpy(first_force, tool_force, sizeof first_force);
                memcpy(kept_node, node, bytes * sizeof(int32_t));
                memcpy(kept_weight, weight, bytes * sizeof(double));
            } else {
                assert_memory_equal(kept_node, node, bytes * sizeof(int32_t));
                assert_memory_equal(kept_weight, weight, bytes * sizeof(double));
            }
        }
        assert_true(reach[1] > reach[0] + 10);
        assert_int_equal(count[0], count[1]);
        assert_memory_equal(kept, force, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
        assert_memory_equal(first_force, tool_force, sizeof first_force);
        assert_memory_equal(&energy[0], &energy[1], sizeof energy[0]);
        close_query();
    }
}

/* A sliding tool on moving tissue keeps its broad phase and the tree's boxes for some steps: the
 * same bits as when both are made again. */
TEST(kept_broad_phases_do_not_change_a_bit)
{
    static ss_real kept[4 * MAX_NODES];
    make_sphere(3, 0.04);
    for (int k = 0; k < SHAPE_COUNT; ++k) {
        open_query(&shapes[k], 2, 0.006, 5e7);
        const ss_contact_query_options options = {0.006, 5e7};
        ss_surface *other = NULL;
        ss_contact_query *fresh = NULL;
        assert_int_equal(ss_surface_create(&mesh, 0.0, 2, &other, NULL), SOFTSIM_OK);
        assert_int_equal(ss_contact_query_create(other, &shapes[k], &options, &fresh), SOFTSIM_OK);
        seed_state = 17;
        const ss_tool_pose start = random_pose(0.0, 0.0, 0.043);
        ss_tool_pose at = start;
        int kept_boxes = 0;
        int kept_broad_phases = 0;
        double pressed = 0.0;
        for (int step = 1; step <= 150; ++step) {
            const double way = 0.0001 * step;
            ss_tool_pose next = turned(&start, 0, 4.0 * way);
            next.position[0] += way;
            next.position[2] -= 0.4 * way;
            for (int32_t i = 0; i < mesh.node_count; ++i) {
                u[4 * i + i % 3] = (ss_real)(0.002 * sin(0.05 * step + i));
            }
            ss_surface_refit(surface, u);
            kept_boxes += surface->moved > 0.0;
            const double before = query->sweep.start[0];
            ss_contact_query_broad_phase(query, u, &at, &next);
            kept_broad_phases += query->sweep.start[0] == before;
            const double energy = penalty(&next);
            memcpy(kept, force, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
            pressed += energy;

            other->fit = 0;
            ss_surface_refit(other, u);
            ss_contact_query_broad_phase(fresh, u, &(ss_tool_pose){{NAN}, {0.0}},
                                         &next); /* forgets */
            ss_contact_query_broad_phase(fresh, u, &next, &next);
            clear_forces();
            const double again =
                ss_contact_query_penalty(fresh, u, &next, force, tool_force, tool_torque);
            assert_memory_equal(&energy, &again, sizeof energy);
            assert_memory_equal(kept, force, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
            at = next;
        }
        assert_true(kept_boxes > 100 && kept_boxes < 149);
        assert_true(kept_broad_phases > 75 && kept_broad_phases < 149);
        assert_true(pressed > 0.0);
        ss_contact_query_destroy(&fresh);
        ss_surface_destroy(&other);
        close_query();
    }
}

/* Touched, and as after a broad phase at that very pose. */
static void expect_as_afresh(const ss_tool_pose *pose)
{
    const double found = penalty(pose);
    assert_true(found > 0.0);
    broad_phase(pose, pose);
    const double afresh = penalty(pose);
    assert_memory_equal(&found, &afresh, sizeof found);
}

/* Nodes that move after the broad phase, up to delta, must not be culled. */
TEST(motion_after_the_broad_phase_is_seen)
{
    make_plane(40, 40, 0.002);
    open_query(&sphere_5mm, 1, 0.006, 5e7);
    const ss_tool_pose pose = pose_at(0.0, 0.0, 0.0105);
    broad_phase(&pose, &pose);
    assert_near(penalty(&pose), 0.0, 0.0);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        u[4 * i + 2] = (ss_real)0.006;
    }
    expect_as_afresh(&pose);
    close_query();
}

/* Beside a long path is not on it, even within half its length of its middle. */
TEST(a_broad_phase_is_not_kept_off_its_path)
{
    make_plane(40, 40, 0.002);
    open_query(&sphere_5mm, 1, 0.006, 5e7);
    const ss_tool_pose from = pose_at(-0.025, 0.0, 0.004);
    const ss_tool_pose to = pose_at(0.025, 0.0, 0.004);
    const ss_tool_pose beside = pose_at(0.0, 0.02, 0.004);
    broad_phase(&from, &to);
    assert_true(penalty(&from) > 0.0 && penalty(&to) > 0.0);
    assert_near(penalty(&beside), 0.0, 0.0);
    broad_phase(&beside, &beside);
    assert_true(penalty(&beside) > 0.0);
    close_query();
}

TEST(shifting_body_and_tool_together_changes_nothing)
{
    double first[3] = {0.0, 0.0, 0.0};
    for (int pass = 0; pass < 2; ++pass) {
        make_sphere(3, 0.04);
        ss_tool_pose pose = pose_at(0.025, 0.025, 0.025);
        if (pass == 1) {
            const double shift[3] = {0.5, -0.25, 0.125};
            for (int32_t i = 0; i < mesh.node_count; ++i) {
                ss_add3(positions[i], positions[i], shift);
            }
            ss_add3(pose.position, pose.position, shift);
        }
        open_query(&shapes[0], 2, 0.005, 5e7);
        broad_phase(&pose, &pose);
        penalty(&pose);
        if (pass == 0) {
            ss_copy3(first, tool_force);
        }
        for (int c = 0; c < 3; ++c) {
            assert_near(tool_force[c], first[c], (IS_DOUBLE ? 1e-10 : 1e-4) * ss_norm3(first));
        }
        close_query();
    }
}

TEST(a_fast_tool_finds_what_it_crosses)
{
    make_plane(20, 20, 0.005);
    open_query(&sphere_5mm, 2, 0.005, 5e7);
    const ss_tool_pose from = pose_at(0.01, 0.005, 0.025);
    const ss_tool_pose to = pose_at(-0.01, 0.0, -0.025);
    assert_true(ss_tool_motion_bound(&sphere_5mm, &from, &to) > 0.05);
    broad_phase(&from, &to);
    ss_tool_pose crossing;
    ss_tool_pose_blend(&from, &to, 0.48, &crossing);
    expect_as_afresh(&crossing);
    close_query();
}

/* ---- smoothness ---- */

/* A sphere of R = h slides over a rigid plane of triangles, 0.24 R deep: 210 samples touch. The
 * mean is the closed form kc int (R - |x|) dA over the cap, times the height over |x|. */
TEST(force_on_a_plane_does_not_ripple)
{
    enum { STEPS = 400 };
    const double r = 0.005;
    const double height = r - 0.0012;
    make_plane(16, 16, r);
    open_query(&sphere_5mm, 2, r, 5e7);
    double sum = 0.0;
    double squares = 0.0;
    double side = 0.0;
    double least = INFINITY;
    double most = 0.0;
    for (int k = 0; k < STEPS; ++k) {
        const ss_tool_pose pose = pose_at(2.7e-5 * k - 0.005, 1.1e-5 * k, height);
        broad_phase(&pose, &pose);
        penalty(&pose);
        sum += tool_force[2];
        squares += tool_force[2] * tool_force[2];
        side = fmax(side, hypot(tool_force[0], tool_force[1]));
        least = fmin(least, tool_force[2]);
        most = fmax(most, tool_force[2]);
    }
    const double mean = sum / STEPS;
    /* int 2 pi rho (R/s - 1) height d rho, s^2 = rho^2 + height^2 */
    const double exact = 5e7 * 3.14159265358979 * height * (r - height) * (r - height);
    assert_near(mean, exact, 1e-3 * exact);
    assert_true(sqrt(fmax(0.0, squares / STEPS - mean * mean)) < 1e-3 * mean);
    assert_true(most - least < 3e-3 * mean);
    assert_true(side < 2e-3 * mean);
    close_query();
}

/* ---- linearisation ---- */

/* A sphere in a flat sheet, its middle z above it: ring by ring, with s the distance from the
 * middle, 2 pi kc z int_z^R c(R - s) ds, and c ten times as steep beyond 0.3 R. */
TEST(a_flat_sheet_pushes_harder_until_a_sphere_is_nearly_through)
{
    const double radius = 0.005, kc = 1e7;
    double before = 0.0;
    make_plane(41, 41, 0.0004);
    open_query(&sphere_5mm, 2, 0.005, kc);
    for (int k = 1; k <= 19; ++k) {
        const double z = radius * (1.0 - 0.05 * k);
        const ss_tool_pose pose = pose_at(0.0001, 0.0002, z);
        const double soft = radius - z, hard = fmax(0.0, soft - 0.3 * radius);
        broad_phase(&pose, &pose);
        penalty(&pose);
        assert_near(tool_force[2] / (3.14159265 * kc * z * (soft * soft + 9.0 * hard * hard)), 1.0,
                    k < 3 ? 0.05 : 0.01);
        assert_true(tool_force[2] > before || k > 15);
        before = tool_force[2];
    }
    close_query();
}

/* A box's face over the whole plane, with no other one near, has one normal, so that the tangent is
 * exact. */
TEST(tangent_and_diagonal_match_differences)
{
    const ss_shape box = {.kind = SS_SHAPE_BOX, .half_extent = {20.0, 20.0, 2.0}};
    make_plane(14, 14, 0.005);
    open_query(&box, 2, 0.005, 5e7);
    seed_state = 15;
    ss_real *du = ss_memory_get((size_t)mesh.node_count, 4 * sizeof(ss_real));
    ss_real *dforce = ss_memory_get((size_t)mesh.node_count, 4 * sizeof(ss_real));
    double *diagonal = ss_memory_get((size_t)mesh.node_count, sizeof(double));
    static ss_real before[4 * MAX_NODES];
    const ss_tool_pose pose = pose_at(0.0003, 0.0001, 1.999);
    const double dx[3] = {0.0, 0.0, 2e-4};
    ss_tool_pose moved = pose;
    ss_add3(moved.position, moved.position, dx);
    broad_phase(&pose, &pose);
    penalty(&pose);
    memcpy(before, force, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
    const double tool_before = tool_force[2];
    double dtool[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        du[4 * i + 2] = (ss_real)(1e-4 * (random_unit() - 0.5));
    }
    ss_contact_query_tangent(query, du, dx, dforce, dtool);
    ss_contact_query_diagonal(query, diagonal);

    for (int32_t i = 0; i < 4 * mesh.node_count; ++i) {
        u[i] += du[i];
    }
    penalty(&moved);
    const double scale = fabs(tool_force[2] - tool_before);
    assert_true(scale > 0.01 * tool_before);
    /* With the far face at t the depth is D = d / sqrt(1 + (d / (t - d))^2), shape.c: of the force
     * k D dD/dd the slope is k (1 - 6 (d / t)^2) to second order, so it is not quite the
     * difference. */
    const double bend = 6.0 * pow(0.00105 / 4.0, 2.0);
    assert_near(dtool[2], tool_force[2] - tool_before, (IS_DOUBLE ? bend : 1e-3) * scale);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        assert_near((double)dforce[4 * i + 2], (double)(force[4 * i + 2] - before[4 * i + 2]),
                    (IS_DOUBLE ? bend : 1e-4) * scale);
    }
    /* diagonal_i = -d f_i for all nodes moving along n together. */
    memset(dforce, 0, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        u[4 * i + 2] = 0;
        du[4 * i + 2] = 1;
    }
    penalty(&pose);
    ss_contact_query_tangent(query, du, (double[3]){0.0, 0.0, 0.0}, dforce, dtool);
    double whole = 0.0;
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        whole += diagonal[i];
        assert_near(diagonal[i], -(double)dforce[4 * i + 2], 1e-5 * 5e7 * 2.5e-5);
    }
    assert_near(whole, 5e7 * 338.0 * 0.25 * sqrt(3.0) * 2.5e-5, 1e-6 * whole);
    SS_EACH(ss_memory_free, du, dforce, diagonal);
    close_query();
}

/* As a sphere goes in, samples begin to touch and, beyond 0.3 R, to be ten times as stiff: each is
 * 0.5 % of all and more, and none is a step. */
TEST(the_tangent_of_a_tool_going_in_has_no_steps)
{
    enum { STEPS = 10000 };
    double last = 0.0;
    make_plane(16, 16, 0.005);
    open_query(&sphere_5mm, 2, 0.005, 5e7);
    for (int k = 0; k < STEPS; ++k) {
        const ss_tool_pose pose = pose_at(0.0011, 0.0007, 0.004 - 1e-7 * k);
        double dtool[3] = {0.0, 0.0, 0.0};
        broad_phase(&pose, &pose);
        penalty(&pose);
        ss_contact_query_tangent(query, NULL, (double[3]){0.0, 0.0, 1.0}, NULL, dtool);
        assert_true(dtool[2] < 0.0 && (k == 0 || fabs(dtool[2] / last - 1.0) < 1e-3));
        last = dtool[2];
    }
    close_query();
}

/* ---- contacts ---- */

TEST(a_sphere_has_one_contact_through_its_centre)
{
    make_plane(16, 16, 0.005);
    open_query(&sphere_5mm, 2, 0.005, 5e7);
    const ss_tool_pose pose = pose_at(0.0011, 0.0007, 0.004);
    ss_contact_set set;
    broad_phase(&pose, &pose);
    penalty(&pose);
    ss_contact_query_contacts(query, u, &pose, 0.005, &set);
    assert_int_equal(set.count, 1);
    assert_near(set.depth, 0.001, 2e-5);
    assert_near(set.contact[0].normal[2], 1.0, 1e-5);
    assert_near(set.contact[0].force, ss_norm3(tool_force), 1e-5 * tool_force[2]);
    assert_near(set.contact[0].gap, 0.0, 0.0);
    assert_near(set.contact[0].point[0], 0.0011, 2e-5);
    assert_near(set.contact[0].point[2], 0.0, 5e-4); /* mean depth, 2/3 of the deepest */
    assert_near(ss_norm3(set.torque), 0.0, 1e-9);
    close_query();
}

TEST(a_long_tool_spreads_its_contacts)
{
    const ss_shape rod = {.kind = SS_SHAPE_CAPSULE, .radius = 0.005, .half_length = 0.012};
    make_plane(20, 20, 0.005);
    open_query(&rod, 2, 0.005, 5e7);
    ss_tool_pose pose = pose_at(0.001, 0.0, 0.004);
    pose.orientation[0] = sqrt(0.5); /* z to x */
    pose.orientation[2] = sqrt(0.5);
    pose = turned(&pose, 1, 0.02); /* a little tilted, so that there is a torque */
    ss_contact_set set;
    broad_phase(&pose, &pose);
    penalty(&pose);
    ss_contact_query_contacts(query, u, &pose, 0.005, &set);
    assert_int_equal(set.count, 4);
    double sum[3] = {0.0, 0.0, 0.0};
    double torque[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < set.count; ++k) {
        assert_near(ss_norm3(set.contact[k].normal), 1.0, 1e-9);
        double r[3], turn[3];
        ss_madd3(sum, sum, set.contact[k].force, set.contact[k].normal);
        ss_sub3(r, set.contact[k].point, pose.position);
        ss_cross3(turn, r, set.contact[k].normal);
        ss_madd3(torque, torque, set.contact[k].force, turn);
        assert_near(set.contact[k].point[2], 0.0, 1e-3);
    }
    assert_true(fabs(tool_torque[1]) > 1e-4 * tool_force[2]);
    for (int c = 0; c < 3; ++c) {
        assert_near(sum[c], tool_force[c], 1e-5 * tool_force[2]);
        assert_near(set.force[c], tool_force[c], 1e-5 * tool_force[2]);
        assert_near(set.torque[c], tool_torque[c], 1e-7 * tool_force[2]);
        assert_near(torque[c], tool_torque[c], 1e-6 * tool_force[2]);
    }
    close_query();
}

TEST(the_nearest_patch_is_told_before_touching)
{
    ss_contact_set set;
    make_sphere(4, 0.04);
    seed_state = 16;
    for (int k = 0; k < SHAPE_COUNT; ++k) {
        open_query(&shapes[k], 2, 0.005, 5e7);
        double way[3] = {random_unit() - 0.5, random_unit() - 0.5, random_unit() - 0.5};
        ss_normalize3(way);
        const double height = 0.042 + ss_shape_bounding_radius(&shapes[k]);
        const ss_tool_pose pose = random_pose(height * way[0], height * way[1], height * way[2]);
        broad_phase(&pose, &pose);
        penalty(&pose);
        ss_contact_query_contacts(query, u, &pose, 0.02, &set);
        assert_int_equal(set.count, 1);
        const ss_contact *contact = &set.contact[0];
        assert_near(contact->force, 0.0, 0.0);
        assert_near(set.depth, -contact->gap, 0.0);
        /* Brute force over all samples. */
        double least = INFINITY;
        for (int32_t t = 0; t < surface->triangle_count; ++t) {
            ss_wide point[SS_GRID_ROW];
            const ss_wide zero = {0};
            ss_surface_points(surface, t, u, &zero, point);
            for (int32_t i = 0; i < 64; ++i) {
                const uint8_t *p = surface->grid.facet[i / 4];
                const ss_real *c = surface->grid.part[i % 4];
                const ss_wide x = c[0] * point[p[0]] + c[1] * point[p[1]] + c[2] * point[p[2]];
                double r[3], local[3], normal[3];
                for (int a = 0; a < 3; ++a) {
                    r[a] = (double)x[a] + surface->centre[a] - pose.position[a];
                }
                ss_rotate_back(local, pose.orientation, r);
                least = fmin(least, ss_shape_distance(&shapes[k], local, normal));
            }
        }
        assert_near(contact->gap, least, 1e-7);
        double out[3];
        ss_copy3(out, contact->point);
        ss_normalize3(out);
        assert_true(ss_dot3(out, contact->normal) > 0.98);
        ss_contact_query_contacts(query, u, &pose, 0.9 * least, &set);
        assert_int_equal(set.count, 0);
        assert_near(set.depth, -0.9 * least, 1e-15);
        close_query();
    }
}

TEST(curvature_of_a_ball_is_minus_one_over_its_radius)
{
    ss_contact_set set;
    make_sphere(3, 0.04);
    open_query(&sphere_5mm, 2, 0.005, 5e7);
    const double way[3] = {0.48, 0.6, 0.64};
    const ss_tool_pose pose = pose_at(0.044 * way[0], 0.044 * way[1], 0.044 * way[2]);
    broad_phase(&pose, &pose);
    penalty(&pose);
    ss_contact_query_contacts(query, u, &pose, 0.01, &set);
    assert_int_equal(set.count, 1);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double expected = -25.0 * ((i == j ? 1.0 : 0.0) - way[i] * way[j]);
            assert_near(set.contact[0].curvature[i][j], expected, 2.0);
        }
    }
    close_query();
}

/* ---- hostile input ---- */

TEST(non_finite_input_touches_nothing)
{
    ss_contact_set set;
    make_sphere(3, 0.04);
    open_query(&shapes[2], 2, 0.005, 5e7);
    const ss_tool_pose good = pose_at(0.0, 0.0, 0.042);
    ss_tool_pose bad = good;
    bad.position[1] = NAN;
    assert_int_equal(broad_phase(&good, &bad), 0);
    assert_near(penalty(&bad), 0.0, 0.0);
    bad = good;
    bad.orientation[2] = INFINITY;
    assert_int_equal(broad_phase(&bad, &good), 0);
    ss_contact_query_contacts(query, u, &bad, 0.01, &set);
    assert_int_equal(set.count, 0);
    assert_true(broad_phase(&good, &good) > 0);
    assert_true(penalty(&good) > 0.0);
    assert_near(penalty(&bad), 0.0, 0.0);
    ss_contact_query_contacts(query, u, &good, NAN, &set);
    const int32_t *node;
    const double *weight;
    double total;
    for (int32_t i = 0; i < 4 * mesh.node_count; ++i) {
        u[i] = (ss_real)(i % 7 == 0 ? INFINITY : NAN);
    }
    assert_near(penalty(&good), 0.0, 0.0);
    assert_int_equal(ss_contact_query_weigh(query, u, NULL, &good, &node, &weight, &total), 0);
    broad_phase(&good, &good);
    ss_contact_query_contacts(query, u, &good, 0.01, &set);
    assert_int_equal(set.count, 0);
    ss_contact_query_options options = {0.0, 1.0};
    ss_contact_query *none = NULL;
    assert_int_equal(ss_contact_query_create(surface, &sphere_5mm, &options, &none),
                     SOFTSIM_ERROR_ARGUMENT);
    options = (ss_contact_query_options){NAN, 1.0};
    assert_int_equal(ss_contact_query_create(surface, &sphere_5mm, &options, &none),
                     SOFTSIM_ERROR_ARGUMENT);
    close_query();
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
