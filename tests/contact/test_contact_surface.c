/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The contact surface: subdivision rows, sample areas, what is refused. */
#include "common/test.h"

#include "common/effort.h"
#include "contact_fixture.h"

/* ---- subdivision rows ---- */

static void check_rows(void)
{
    for (int32_t k = 0; k < surface->patch_count; ++k) {
        const ss_patch *patch = &surface->patch[k];
        const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            double sum = 0.0;
            for (int32_t i = 0; i < patch->control_count; ++i) {
                assert_true(row[i * SS_GRID_ROW + p] >= 0);
                sum += (double)row[i * SS_GRID_ROW + p];
            }
            /* A sum of so many rounds by half an epsilon a term. */
            const double rounding = fmax(1e-15, 1.12e-16 * patch->control_count);
            assert_near(sum, 1.0, IS_DOUBLE ? rounding : 2e-7);
        }
    }
}

TEST(loop_rows_are_convex_combinations)
{
    make_sphere(3, 0.05);
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    check_rows();
    close_query();
    make_plane(7, 7, 0.01); /* with boundaries */
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    check_rows();
    close_query();
    make_sphere(0, 0.05); /* valence 4, all rings overlap */
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    check_rows();
    close_query();
}

/* Bow tie: two triangles that share a node only are a boundary corner each. By hand: twice 3/4 of
 * the corner and 1/8 of both ends, from a = b = 0 at v. */
TEST(each_fan_of_a_node_is_a_corner_of_its_own)
{
    begin_mesh();
    add_node(0.0, 0.0, 0.0);
    add_node(0.01, 0.0, 0.0);
    add_node(0.0, 0.01, 0.0);
    add_node(-0.01, 0.0, 0.0);
    add_node(0.0, -0.01, 0.0);
    add_triangle(0, 1, 2);
    add_triangle(0, 3, 4);
    open_query(&sphere_5mm, 1, 0.005, 1.0);
    check_rows();
    for (int32_t t = 0; t < 2; ++t) {
        const ss_wide zero = {0};
        ss_wide point[SS_GRID_ROW];
        const int32_t *corner = surface->control + surface->control_first[t];
        static const int at[3] = {0, 4, 14};
        ss_surface_points(surface, t, u, &zero, point);
        for (int k = 0; k < 3; ++k) {
            if (corner[k] == 0) {
                for (int c = 0; c < 3; ++c) {
                    const double along = c == 2 ? 0.0 : 0.15625 * 0.01;
                    const double x = (double)point[at[k]][c] + surface->centre[c];
                    assert_near(fabs(x), along, 1e-9);
                    assert_true(x * positions[corner[(k + 1) % 3]][c] >= 0.0);
                    assert_true(x * positions[corner[(k + 2) % 3]][c] >= 0.0);
                }
            }
        }
    }
    close_query();
}

/* Loop subdivision keeps linear fields where the mesh is regular: points stay on their triangle. */
TEST(regular_rows_reproduce_linear_fields)
{
    make_plane(9, 9, 0.01);
    for (int32_t i = 0; i < mesh.node_count; ++i) { /* a sheared, tilted plane */
        positions[i][2] = 0.3 * positions[i][0] - 0.7 * positions[i][1];
        positions[i][0] += 0.2 * positions[i][1];
    }
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    int32_t checked = 0;
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        const ss_wide zero = {0};
        ss_wide point[SS_GRID_ROW];
        const int32_t *corner = surface->control + surface->control_first[t];
        if (surface->patch[surface->patch_of[t]].control_count != 12) {
            continue;
        }
        checked++;
        ss_surface_points(surface, t, u, &zero, point);
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            for (int c = 0; c < 3; ++c) {
                double x = 0.0;
                for (int k = 0; k < 3; ++k) {
                    x += (double)surface->grid.bary[p][k] * positions[corner[k]][c];
                }
                assert_near((double)point[p][c] + surface->centre[c], x, IS_DOUBLE ? 1e-16 : 2e-8);
            }
        }
    }
    assert_true(checked > 40);
    close_query();
}

/* Neighbours compute a shared side from different rings: the surface must not crack. */
TEST(neighbouring_triangles_share_their_side)
{
    make_sphere(2, 0.05);
    open_query(&sphere_5mm, 1, 0.005, 1.0);
    seed_state = 7;
    shake_nodes(0.01);
    /* side k of a triangle runs over these points */
    static const int side[3][5] = {{0, 1, 2, 3, 4}, {4, 8, 11, 13, 14}, {14, 12, 9, 5, 0}};
    const ss_wide zero = {0};
    int32_t shared = 0;
    for (int32_t a = 0; a < surface->triangle_count; ++a) {
        ss_wide pa[SS_GRID_ROW];
        ss_surface_points(surface, a, u, &zero, pa);
        for (int32_t b = 0; b < a; ++b) {
            const int32_t *ca = surface->control + surface->control_first[a];
            const int32_t *cb = surface->control + surface->control_first[b];
            for (int k = 0; k < 9; ++k) {
                const int i = k / 3;
                const int j = k % 3;
                if (ca[i] != cb[(j + 1) % 3] || ca[(i + 1) % 3] != cb[j]) {
                    continue;
                }
                ss_wide pb[SS_GRID_ROW];
                ss_surface_points(surface, b, u, &zero, pb);
                for (int p = 0; p < 15; ++p) {
                    assert_near((double)pa[side[i][p / 3]][p % 3],
                                (double)pb[side[j][4 - p / 3]][p % 3], IS_DOUBLE ? 1e-16 : 2e-8);
                }
                shared++;
            }
        }
    }
    assert_int_equal(2 * shared, 3 * surface->triangle_count);
    close_query();
}

TEST(equal_topology_shares_one_matrix)
{
    make_sphere(3, 0.05);
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    assert_int_equal(surface->triangle_count, 512);
    assert_int_equal(surface->patch_count, 2); /* all regular, or one corner of valence 4 */
    close_query();
}

TEST(sample_areas_sum_to_the_surface)
{
    make_sphere(2, 0.05);
    open_query(&sphere_5mm, 3, 0.005, 1.0);
    double area = 0.0;
    double expected = 0.0;
    for (int32_t t = 0; t < mesh.triangle_count; ++t) {
        double a[3];
        double b[3];
        double c[3];
        ss_sub3(a, positions[triangles[t][1]], positions[triangles[t][0]]);
        ss_sub3(b, positions[triangles[t][2]], positions[triangles[t][0]]);
        ss_cross3(c, a, b);
        expected += 0.5 * ss_norm3(c);
        area += (double)surface->area[t];
    }
    assert_near(area, expected, 1e-7 * expected);
    assert_int_equal(ss_surface_sample_count(surface), 128 * 16 * 9);
    close_query();
}

/* ---- refusals ---- */

static void expect_refusal(double radius, int parts, softsim_status status, const char *text)
{
    softsim_error error = {0};
    ss_surface *none = NULL;
    assert_int_equal(ss_surface_create(&mesh, radius, parts, &none, &error), status);
    assert_null(none);
    if (strstr(error.text, text) == NULL) {
        fail_msg("'%s' is not in '%s'", text, error.text);
    }
}

/* A disc of triangles around one node. */
static void make_fan(int32_t sides)
{
    begin_mesh();
    add_node(0.0, 0.0, 0.0);
    for (int32_t k = 0; k < sides; ++k) {
        const double turn = 2.0 * SS_PI * k / sides;
        add_node(cos(turn), sin(turn), 0.0);
    }
    for (int32_t k = 0; k < sides; ++k) {
        add_triangle(0, 1 + k, 1 + (k + 1) % sides);
    }
}

TEST(a_node_of_128_triangles_is_sampled)
{
    make_fan(128);
    open_query(&sphere_5mm, 1, 1.0, 1.0);
    check_rows();
    close_query();
}

TEST(refuses_what_it_cannot_sample)
{
    make_plane(5, 5, 0.01);
    expect_refusal(0.0025, 0, SOFTSIM_ERROR_SCENE, "2.5 mm");
    expect_refusal(0.0025, 0, SOFTSIM_ERROR_SCENE, "mean edge 10 mm");
    expect_refusal(0.005, 1, SOFTSIM_ERROR_ARGUMENT, "more parts");
    expect_refusal(0.005, 5, SOFTSIM_ERROR_ARGUMENT, "parts");
    positions[7][1] = NAN;
    expect_refusal(0.01, 0, SOFTSIM_ERROR_MESH, "non-finite");
    make_plane(5, 5, 0.01);
    triangles[3][1] = 99;
    expect_refusal(0.01, 0, SOFTSIM_ERROR_MESH, "triangle 3");
    make_plane(5, 5, 0.01);
    add_triangle(triangles[0][0], triangles[0][1], 20);
    expect_refusal(0.01, 0, SOFTSIM_ERROR_MESH, "manifold");
    make_fan(129);
    expect_refusal(1.0, 0, SOFTSIM_ERROR_MESH, "node 0");
    begin_mesh();
    expect_refusal(1.0, 0, SOFTSIM_ERROR_MESH, "triangles");
}

/* What a plane's rows or a sphere's octahedron stands out by; *at is where. */
static double rounding_of(int parts, double at[3])
{
    ss_surface *rounded = NULL;
    assert_int_equal(ss_surface_create(&mesh, 0.05, parts, &rounded, NULL), SOFTSIM_OK);
    const double most = ss_surface_rounding(rounded, at);
    ss_surface_destroy(&rounded);
    return most;
}

/* The octahedron's corner, by Loop's rules: n beta(4) = 31/64, middles of edges at 3/8, so that
 * level 1 has it at 33/64 and level 2 at (33/64)^2 + 31/64 3/8 of its height. Of a plane nothing
 * stands out, however uneven its rows are, and of a pit nothing but its rim. */
TEST(corners_are_cut_off_by_what_the_rules_say)
{
    double at[3];
    make_sphere(0, 0.05);
    const double height = 33.0 / 64.0 * 33.0 / 64.0 + 31.0 / 64.0 * 3.0 / 8.0;
    assert_near(rounding_of(0, at), 0.05 * (1.0 - height), 1e-8);
    assert_near(ss_norm3(at), 0.05, 1e-8); /* a corner */
    assert_near(rounding_of(SS_SURFACE_CENTROIDS, at), 0.0, 1e-9);
    make_plane(7, 7, 0.01);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        mesh.position[i][0] *= 1.0 + 20.0 * mesh.position[i][0];
    }
    assert_near(rounding_of(2, at), 0.0, 1e-8);
    const int32_t middle = mesh.node_count / 2;
    mesh.position[middle][2] -= 0.01;
    const double pit = rounding_of(2, at);
    mesh.position[middle][2] += 0.02;
    assert_true(rounding_of(2, at) > 2.0 * pit);
    assert_near(at[2], mesh.position[middle][2], 1e-8);
}

TEST(picks_parts_by_radius_over_edge)
{
    static const double ratio[4] = {0.4, 0.6, 2.0, 3.1};
    static const int64_t samples[4] = {144, 64, 64, 16};
    make_plane(5, 5, 0.01);
    for (int k = 0; k < 4; ++k) {
        ss_surface *picked = NULL;
        assert_int_equal(ss_surface_create(&mesh, 0.01 * ratio[k], 0, &picked, NULL), SOFTSIM_OK);
        assert_int_equal(ss_surface_sample_count(picked), samples[k] * mesh.triangle_count);
        assert_near(ss_surface_mean_edge(picked), 0.01, 1e-12);
        ss_surface_destroy(&picked);
    }
}

/* ---- tools that appear ---- */

/* On a sphere of radius 20 mm, seen from random places inside and outside, and over its corners. */
TEST(a_tool_that_appears_is_found_inside_or_outside)
{
    make_sphere(3, 0.02);
    mesh.is_closed = true;
    ss_real *at_rest = ss_memory_get((size_t)mesh.node_count * 4, sizeof *at_rest);
    assert_non_null(at_rest);
    for (int i = 0; i < 2000; ++i) {
        double direction[3], point[3], normal[3];
        for (int k = 0; k < 3; ++k) {
            direction[k] = random_unit() - 0.5;
        }
        if (i < mesh.node_count) {
            ss_copy3(direction, mesh.position[i]); /* straight over a corner */
        }
        assert_true(ss_normalize3(direction) > 0.0);
        const double radius = 0.002 + 0.04 * random_unit();
        ss_tool_pose pose = pose_at(0.0, 0.0, 0.0);
        ss_scale3(pose.position, direction, radius);
        const double depth = ss_contact_locate(&mesh, at_rest, &sphere_5mm, &pose, point, normal);
        /* Facets lie up to 0.25 mm below the sphere. */
        assert_true(fabs(depth - (0.005 + 0.02 - radius)) < 4e-4);
        assert_true(ss_dot3(normal, direction) > 0.9);
    }
    ss_memory_free(at_rest);
}

TEST(behind_an_open_sheet_is_nowhere_near)
{
    make_plane(11, 11, 0.004);
    mesh.is_closed = false;
    ss_real *at_rest = ss_memory_get((size_t)mesh.node_count * 4, sizeof *at_rest);
    assert_non_null(at_rest);
    double point[3], normal[3];
    const ss_tool_pose above = pose_at(0.001, 0.0005, 0.004),
                       below = pose_at(0.001, 0.0005, -0.002),
                       behind = pose_at(0.001, 0.0005, -0.02);
    assert_true(
        fabs(ss_contact_locate(&mesh, at_rest, &sphere_5mm, &above, point, normal) - 0.001) < 1e-9);
    assert_true(
        fabs(ss_contact_locate(&mesh, at_rest, &sphere_5mm, &below, point, normal) - 0.007) < 1e-9);
    assert_true(isinf(ss_contact_locate(&mesh, at_rest, &sphere_5mm, &behind, point, normal)));
    ss_memory_free(at_rest);
}

static void turn_inside_out(void)
{
    for (int32_t t = 0; t < mesh.triangle_count; ++t) {
        const int32_t first = triangles[t][0];
        triangles[t][0] = triangles[t][1];
        triangles[t][1] = first;
    }
}

/* In the middle of a body and of a hollow, of 8 facets and of 512: many are as near as the nearest,
 * and their normals sum up to nothing. */
TEST(the_middle_of_a_cavity_is_outside)
{
    static const double wall[2] = {0.0115470054, 0.02}; /* m, from the middle */
    for (int k = 0; k < 4; ++k) {
        const bool is_hollow = k % 2 == 1;
        make_sphere(k / 2 == 0 ? 0 : 3, 0.02);
        if (is_hollow) {
            turn_inside_out();
        }
        const ss_tool_pose pose = pose_at(0.0, 0.0, 0.0);
        double point[3], normal[3];
        const double depth = ss_contact_locate(&mesh, NULL, &sphere_5mm, &pose, point, normal);
        assert_true(fabs(depth - 0.005 - (is_hollow ? -wall[k / 2] : wall[k / 2])) < 4e-4);
    }
}

/* As the steps of a simulation do it: call after call, none of them long. */
static bool leave(const ss_contact_tissue *tissue, const ss_shape *shape, const ss_tool_pose *pose,
                  const double inward[3], double way[3])
{
    ss_contact_exit search = {.is_begun = false};
    ss_contact_exit_result result = SS_EXIT_UNFINISHED;
    for (int call = 0; result == SS_EXIT_UNFINISHED; ++call) {
        const int32_t before = search.nearest.looks + search.back.looks;
        result = ss_contact_leave(tissue, shape, pose, 0.0005, inward, &search, way);
        const int32_t looks = search.nearest.looks + search.back.looks - before + (call == 0);
        assert_in_range(looks, 1, SS_EXIT_LOOKS);
    }
    return result == SS_EXIT_FOUND;
}

/* Out of a ball of 20 mm, found with the tool's middle `from` above its own: along `expected` to
 * where they are 25 mm apart. */
static void check_way_out(double from, const double inward[3], const double expected[3])
{
    const ss_contact_tissue tissue = {.mesh = &mesh};
    const ss_tool_pose pose = pose_at(0.0, 0.0, from);
    double way[3], end[3];
    assert_true(leave(&tissue, &sphere_5mm, &pose, inward, way));
    ss_add3(end, pose.position, way);
    assert_true(fabs(ss_norm3(end) - 0.025) < 4e-4);
    assert_true(ss_dot3(way, expected) > 0.99 * ss_norm3(way)); /* facets are tilted */
}

TEST(a_tool_leaves_the_way_it_came_or_the_nearest)
{
    static const double unknown[3] = {0.0, 0.0, 0.0}, x[3] = {1.0, 0.0, 0.0},
                        minus_x[3] = {-1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                        minus_z[3] = {0.0, 0.0, -1.0};
    make_sphere(3, 0.02);
    check_way_out(0.012, unknown, z);
    check_way_out(0.012, x, minus_x);
    check_way_out(0.003, z, minus_z);
    check_way_out(0.018, z, z); /* 43 mm, right through, or 7 */
    const ss_contact_tissue tissue = {.mesh = &mesh};
    const ss_tool_pose outside = pose_at(0.0, 0.0, 0.026);
    double way[3];
    assert_true(leave(&tissue, &sphere_5mm, &outside, z, way));
    assert_true(ss_norm3(way) <= 0.0);
}

/* Pressed down to a ball of 15 mm it may come back. */
TEST(dented_tissue_is_where_it_rests_too)
{
    static const double unknown[3] = {0.0, 0.0, 0.0};
    make_sphere(3, 0.02);
    ss_real *dent = ss_memory_get((size_t)mesh.node_count * 4, sizeof *dent);
    assert_non_null(dent);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            dent[4 * i + k] = (ss_real)(-0.25 * mesh.position[i][k]);
        }
    }
    for (int is_deformed = 0; is_deformed < 2; ++is_deformed) {
        const ss_contact_tissue tissue = {
            .mesh = &mesh, .u = dent, .is_deformed = is_deformed != 0};
        const ss_tool_pose pose = pose_at(0.0, 0.0, 0.021);
        double way[3];
        assert_true(leave(&tissue, &sphere_5mm, &pose, unknown, way));
        assert_true(fabs(ss_norm3(way) - (is_deformed ? 0.004 : 0.0)) < 4e-4);
    }
    ss_memory_free(dent);
}

/* A ball of 25 mm in a hollow of 20 mm. */
TEST(a_tool_may_have_no_way_out)
{
    static const double unknown[3] = {0.0, 0.0, 0.0};
    static const ss_shape large = {.kind = SS_SHAPE_SPHERE, .radius = 0.025};
    make_sphere(3, 0.02);
    turn_inside_out();
    const ss_contact_tissue tissue = {.mesh = &mesh};
    const ss_tool_pose pose = pose_at(0.001, 0.0, 0.0);
    double way[3];
    assert_false(leave(&tissue, &large, &pose, unknown, way));
    static const double inward[3] = {0.0, 0.6, 0.8};
    assert_false(leave(&tissue, &large, &pose, inward, way));
}

/* ---- inside ---- */

static double inside_depth_at(const ss_tool_pose *pose)
{
    ss_contact_set set;
    ss_surface_refit(surface, u);
    ss_contact_query_broad_phase(query, u, pose, pose);
    ss_contact_query_penalty(query, u, pose, force, tool_force, tool_torque);
    ss_contact_query_contacts(query, u, pose, 0.005, &set);
    return set.inside_depth;
}

/* In a sphere, moved and stretched since its boxes were first fitted; over its corners and edges
 * too, on which rays along an axis would run. */
TEST(a_tool_is_inside_when_its_middle_is_inside)
{
    make_sphere(3, 0.02);
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    for (int i = 0; i < 3000; ++i) {
        const double stretch = i < 1000 ? 1.0 : 1.3, shift = i < 2000 ? 0.0 : 0.015;
        for (int32_t k = 0; k < mesh.node_count; ++k) {
            u[4 * k + 2] = (ss_real)((stretch - 1.0) * positions[k][2] + shift);
        }
        double way[3];
        for (int k = 0; k < 3; ++k) {
            way[k] = random_unit() - 0.5;
        }
        if (i % 1000 < mesh.node_count) {
            ss_copy3(way, positions[i % 1000]);
        }
        ss_normalize3(way);
        const double radius = 0.04 * random_unit();
        ss_tool_pose pose = random_pose(0.0, 0.0, 0.0);
        ss_set3(pose.position, radius * way[0], radius * way[1], stretch * radius * way[2] + shift);
        const double depth = inside_depth_at(&pose);
        /* The smooth surface lies up to 0.7 mm below the sphere. */
        if (radius < 0.0193) {
            assert_true(depth > 0.005 + 0.0193 - radius - 1e-4);
            assert_true(depth < 0.005 + stretch * (0.02 - radius) + 5e-4);
        } else if (radius > 0.02) {
            assert_true(depth == 0.0);
        }
    }
    close_query();
}

TEST(no_tool_is_inside_an_open_sheet_or_from_outside)
{
    make_plane(11, 11, 0.004);
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    for (int k = -20; k <= 20; ++k) {
        const ss_tool_pose pose = pose_at(0.001, 0.0005, 0.001 * k);
        assert_true(inside_depth_at(&pose) == 0.0);
    }
    close_query();
    make_sphere(3, 0.02);
    for (int32_t t = 0; t < mesh.triangle_count; ++t) { /* inside out: a hollow */
        const int32_t swap = triangles[t][0];
        triangles[t][0] = triangles[t][1];
        triangles[t][1] = swap;
    }
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    for (int k = -30; k <= 30; ++k) {
        const ss_tool_pose pose = pose_at(0.001, 0.0005, 0.001 * k);
        assert_true(inside_depth_at(&pose) == 0.0);
    }
    close_query();
}

/* A ball that wanders in and out of a body that swings, slowly and in jumps, asked again and again;
 * and each time as if for the first time. */
TEST(what_is_remembered_of_the_inside_stays_right)
{
    make_sphere(3, 0.02);
    open_query(&sphere_5mm, 2, 0.005, 1.0);
    int inside = 0, changes = 0;
    bool was_inside = false;
    const int times = FULL_IN_RELEASE(6000, 1500), part = 6000 / times;
    for (int i = 0; i < 6000; i += part) {
        const double rate = i < 3000 ? 1.0 : 10.0;
        const double stretch = 0.2 * sin(0.003 * rate * i), shift = 0.003 * sin(0.002 * rate * i);
        for (int32_t k = 0; k < mesh.node_count; ++k) {
            u[4 * k] = (ss_real)(stretch * positions[k][0]);
            u[4 * k + 2] = (ss_real)shift;
        }
        const double jump = i % 97 == 0 ? 0.02 * random_unit() : 0.0;
        const double radius = 0.0195 + 0.004 * sin(0.0037 * rate * i) + jump,
                     turn = 0.001 * rate * i;
        const ss_tool_pose pose = pose_at(radius * cos(turn), 0.001, radius * sin(turn));
        const bool is_inside = inside_depth_at(&pose) > 0.0;
        query->outside.is_known = false;
        assert_int_equal(inside_depth_at(&pose) > 0.0, is_inside);
        inside += is_inside;
        changes += is_inside != was_inside;
        was_inside = is_inside;
    }
    print_message("inside %d times of %d, %d changes\n", inside, times, changes);
    assert_true(6 * inside > times && 6 * inside < 5 * times && changes > 40);
    close_query();
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
