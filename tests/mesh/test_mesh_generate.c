/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-mesh generate: bodies of tetrahedra, their measures, shapes and groups. */
#include "common/test.h"
#include <math.h>

#include "common/effort.h"
#include "common/tool_fixture.h"
#include "mesh/tetrahedron.h"
#include "rt/vec.h"

static ss_mesh *generate(const char *arguments, const char *name, double unit)
{
    char command[512];
    char out[2048];
    (void)snprintf(command, sizeof command, TOOL "generate %s --out %s", arguments, name);
    if (run(command, out, sizeof out) != 0) {
        fail_msg("%s: %s", arguments, out);
    }
    return load(in_folder(name), unit);
}

/* Nothing that softsim-mesh check would tell; returns the report. */
static ss_mesh_report expect_clean(const ss_mesh *m, double least_angle)
{
    ss_mesh_report r;
    ss_mesh_quality q;
    ss_mesh_fault fault;
    bool is_complete = false;
    softsim_error error = {0};
    if (ss_mesh_accept(m, "generated", &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
    ss_mesh_measure_quality(m, &q);
    assert_int_equal(q.sliver.count, 0);
    assert_true(m->is_closed);
    assert_true(ss_mesh_find_crossings(m, &fault, &is_complete));
    assert_int_equal(fault.count, 0);
    assert_true(is_complete);
    assert_int_equal(r.component_count, 1);
    if (m->tetrahedron_count > 0 &&
        !(q.dihedral_min >= least_angle && q.dihedral_max <= 180.0 - least_angle)) {
        fail_msg("%g to %g degrees", q.dihedral_min, q.dihedral_max);
    }
    return r;
}

static const ss_mesh_group *find_group(const ss_mesh *m, const char *name)
{
    for (int32_t g = 0; g < m->group_count; ++g) {
        if (strcmp(m->group[g].name, name) == 0) {
            return &m->group[g];
        }
    }
    fail_msg("no group %s", name);
    return NULL;
}

/* Of the part of an ellipsoid below z = base. */
static double cut_volume(double a, double b, double c, double base)
{
    return SS_PI * a * b * (base - base * base * base / (3.0 * c * c) + 2.0 * c / 3.0);
}

TEST(bodies_have_their_volume_and_good_tetrahedra_and_about_the_points_asked_for)
{
    const double ellipsoid = 4.0 / 3.0 * SS_PI;
    const struct {
        const char *arguments;
        int32_t points;
        double volume, error, angle;
    } cases[] = {
        {"block", 2197, 1e-3, 1e-9, 54.7},
        {"block --points 100 --size-mm 30,20,10", 100, 6e-6, 1e-9, 45.0},
        {"beam --points 5000", 5000, 0.2 * 0.04 * 0.04, 1e-9, 50.0},
        {"cylinder --radius-m 0.05 --length-m 0.2 --units mm", 3000, SS_PI * 0.05 * 0.05 * 0.2,
         0.01, 25.0},
        {"ellipsoid --points 1200", 1200, ellipsoid * 0.05 * 0.03 * 0.03, 0.02, 25.0},
        {"ellipsoid --points 300 --size-mm 90,60,80", 300, ellipsoid * 0.045 * 0.03 * 0.04, 0.05,
         25.0},
        {"ventricle", 4000,
         cut_volume(0.01, 0.01, 0.02, 0.005) - cut_volume(0.007, 0.007, 0.017, 0.005), 0.02, 20.0},
        {"ventricle --points 900 --size-mm 65,65,120 --inner-mm 42,42,100 --base-mm 20", 900,
         cut_volume(0.0325, 0.0325, 0.06, 0.02) - cut_volume(0.021, 0.021, 0.05, 0.02), 0.05, 15.0},
        {"ellipsoids", 4000, ellipsoid * (0.05 * 0.04 * 0.04 - 0.03 * 0.0225 * 0.0225), 0.02, 18.0},
        {"kidney --points 800", 800, 1.44e-4, 0.03, 25.0},
    };
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        if (cases[i].points > FULL_IN_RELEASE(INT32_MAX, 1000)) {
            continue;
        }
        char arguments[256];
        (void)snprintf(arguments, sizeof arguments, "%s --tetrahedra", cases[i].arguments);
        ss_mesh *m = generate(arguments, "body.msh", 1e-3);
        const ss_mesh_report r = expect_clean(m, cases[i].angle);
        if (fabs(r.volume / cases[i].volume - 1.0) > cases[i].error ||
            abs(m->node_count - cases[i].points) > cases[i].points / 10) {
            fail_msg("%s: %d nodes, volume %g for %g", arguments, m->node_count, r.volume,
                     cases[i].volume);
        }
        ss_mesh_destroy(&m);
    }
}

TEST(a_liver_of_tetrahedra_is_as_large_as_the_published_one)
{
    SKIP_WHERE_REPEATED();
    /* Of a quarter of the points outside of long runs: as many tetrahedra a node. */
    const int part = FULL_IN_LONG_RUN(1, 4);
    ss_mesh *m =
        generate(FULL_IN_LONG_RUN("liver --tetrahedra", "liver --tetrahedra --points 1440"),
                 "liver.msh", 1e-3);
    (void)expect_clean(m, 25.0);
    assert_near(m->node_count, 5762.0 / part, 60);
    assert_near(m->tetrahedron_count, 20255.0 / part, 2000.0 / part);
    const ss_mesh_group *fixed = find_group(m, "fixed");
    assert_in_range(fixed->node_count, 100 / part, 1000 / part);
    ss_mesh_destroy(&m);
}

static int compare_heights(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* An explicit step goes with the least height of all. */
TEST(the_lowest_tetrahedron_of_an_organ_is_not_much_lower_than_the_others)
{
    static const char *const organ[] = {"kidney", "liver", "ellipsoid"};
    for (int k = 0; k < COUNT(organ); ++k) {
        char arguments[64];
        (void)snprintf(arguments, sizeof arguments, "%s --tetrahedra --points 400", organ[k]);
        ss_mesh *m = generate(arguments, "body.msh", 1e-3);
        double *height = calloc((size_t)m->tetrahedron_count, sizeof *height);
        for (int32_t e = 0; e < m->tetrahedron_count; ++e) {
            const int32_t *n = m->tetrahedron[e];
            double gradient[4][3], largest = 0.0; /* the height over a face is 1/|grad lambda| */
            (void)ss_tetrahedron_gradients(m->position[n[0]], m->position[n[1]], m->position[n[2]],
                                           m->position[n[3]], gradient);
            for (int a = 0; a < 4; ++a) {
                largest = fmax(largest, ss_norm3(gradient[a]));
            }
            height[e] = 1.0 / largest;
        }
        qsort(height, (size_t)m->tetrahedron_count, sizeof *height, compare_heights);
        if (height[0] < 0.65 * height[m->tetrahedron_count / 2]) {
            fail_msg("%s: %g m of %g", organ[k], height[0], height[m->tetrahedron_count / 2]);
        }
        free(height);
        ss_mesh_destroy(&m);
    }
}

/* By the four Gauss points of each element, exact for straight ones. */
static double volume_of(const ss_mesh *m)
{
    double sum = 0.0;
    for (int32_t e = 0; e < m->tetrahedron_count; ++e) {
        int32_t node[SS_TETRAHEDRON_NODES];
        double unused[4][3];
        memcpy(node, m->tetrahedron[e], sizeof *m->tetrahedron);
        if (m->middle == NULL) {
            sum += ss_tetrahedron_gradients(m->position[node[0]], m->position[node[1]],
                                            m->position[node[2]], m->position[node[3]], unused);
            continue;
        }
        memcpy(node + 4, m->middle[e], sizeof *m->middle);
        for (int q = 0; q < SS_TETRAHEDRON_POINTS; ++q) {
            sum += ss_tetrahedron_point((const double(*)[3])m->position, node, q, unused);
        }
    }
    return sum;
}

TEST(of_second_order_they_have_the_true_shape)
{
    const struct {
        const char *arguments;
        double volume;
    } cases[] = {
        {"ellipsoid --points 300", 4.0 / 3.0 * SS_PI * 0.05 * 0.03 * 0.03},
        {"cylinder --points 400 --radius-m 0.05 --length-m 0.2 --units mm",
         SS_PI * 0.05 * 0.05 * 0.2},
        {"ventricle --points 500",
         cut_volume(0.01, 0.01, 0.02, 0.005) - cut_volume(0.007, 0.007, 0.017, 0.005)},
        {"ellipsoids --points 500",
         4.0 / 3.0 * SS_PI * (0.05 * 0.04 * 0.04 - 0.03 * 0.0225 * 0.0225)},
        {"block --points 100", 1e-3},
    };
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        char arguments[256];
        (void)snprintf(arguments, sizeof arguments, "%s --tetrahedra", cases[i].arguments);
        ss_mesh *first = generate(arguments, "first.vtk", 1e-3);
        (void)snprintf(arguments, sizeof arguments, "%s --tetrahedra --order 2",
                       cases[i].arguments);
        ss_mesh *second = generate(arguments, "second.vtk", 1e-3);
        softsim_error error = {0};
        if (ss_mesh_accept(second, "generated", &error) != SOFTSIM_OK) {
            fail_msg("%s", error.text);
        }
        assert_non_null(second->middle);
        assert_int_equal(second->tetrahedron_count, first->tetrahedron_count);
        assert_memory_equal(second->position, first->position,
                            (size_t)first->node_count * sizeof *first->position);
        const double off = fabs(volume_of(first) / cases[i].volume - 1.0);
        const double left = fabs(volume_of(second) / cases[i].volume - 1.0);
        print_message("%s: volume off by %.3g, of second order %.3g\n", cases[i].arguments, off,
                      left);
        assert_true(left < 0.1 * off + 1e-9);
        ss_mesh_destroy(&first);
        ss_mesh_destroy(&second);
    }
}

TEST(middles_of_an_ellipsoids_surface_lie_on_it)
{
    ss_mesh *m = generate("ellipsoid --points 300 --tetrahedra --order 2", "e.msh", 1e-3);
    static const double half[3] = {0.05, 0.03, 0.03};
    for (int32_t t = 3; t < m->triangle_count; t += 4) { /* quarters between middles */
        for (int k = 0; k < 3; ++k) {
            const double *x = m->position[m->triangle[t][k]];
            double sum = 0.0;
            for (int i = 0; i < 3; ++i) {
                sum += x[i] * x[i] / (half[i] * half[i]);
            }
            assert_near(sum, 1.0, 1e-12);
        }
    }
    ss_mesh_destroy(&m);
}

TEST(finer_meshes_are_nearer_to_the_volume)
{
    SKIP_WHERE_REPEATED();
    const char *const shapes[] = {"ellipsoid", "ventricle", "ellipsoids", "cylinder"};
    for (int32_t i = 0; i < COUNT(shapes); ++i) {
        double volume[3];
        for (int k = 0; k < 3; ++k) {
            char arguments[128];
            (void)snprintf(arguments, sizeof arguments, "%s --tetrahedra --points %d", shapes[i],
                           FULL_IN_LONG_RUN(250, 125) << 2 * k);
            ss_mesh *m = generate(arguments, "finer.msh", 1.0);
            ss_mesh_report r;
            assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
            volume[k] = r.volume;
            ss_mesh_destroy(&m);
        }
        /* Inscribed, and with an error that goes as the square of the edge. */
        assert_true(volume[0] < volume[1] && volume[1] < volume[2]);
        if (!(volume[2] - volume[1] < 0.6 * (volume[1] - volume[0]))) {
            fail_msg("%s: %g %g %g", shapes[i], volume[0], volume[1], volume[2]);
        }
    }
}

TEST(groups_are_where_they_say)
{
    ss_mesh *m = generate("ventricle --tetrahedra --points 1500", "v.msh", 1.0);
    const struct {
        const char *name;
        double half[3];
    } walls[] = {{"endo", {7, 7, 17}}, {"epi", {10, 10, 20}}};
    for (int i = 0; i < 2; ++i) {
        const ss_mesh_group *group = find_group(m, walls[i].name);
        assert_true(group->node_count > 100);
        for (int32_t k = 0; k < group->node_count; ++k) {
            const double *x = m->position[group->node[k]];
            const double *half = walls[i].half;
            const double f = x[0] * x[0] / (half[0] * half[0]) + x[1] * x[1] / (half[1] * half[1]) +
                             x[2] * x[2] / (half[2] * half[2]);
            assert_near(f, 1.0, 1e-9);
            assert_true(x[2] <= 5.0);
        }
    }
    const ss_mesh_group *base = find_group(m, "base");
    int32_t at_base = 0;
    for (int32_t i = 0; i < m->node_count; ++i) {
        at_base += m->position[i][2] == 5.0;
    }
    assert_int_equal(base->node_count, at_base);
    assert_true(at_base > 20);
    ss_mesh_destroy(&m);

    m = generate("beam --tetrahedra --points 400", "b.msh", 1.0);
    const ss_mesh_group *held = find_group(m, "fixed");
    for (int32_t k = 0; k < held->node_count; ++k) {
        assert_near(m->position[held->node[k]][0], -100.0, 1e-9);
    }
    assert_int_equal(held->node_count, find_group(m, "free")->node_count);
    ss_mesh_destroy(&m);
}

TEST(surfaces_of_bodies_keep_their_groups_and_have_no_inner_nodes)
{
    ss_mesh *m = generate("ventricle --points 1500", "s.msh", 1.0);
    (void)expect_clean(m, 0.0);
    assert_int_equal(m->tetrahedron_count, 0);
    assert_near(m->node_count, 1500, 150);
    assert_true(find_group(m, "base")->node_count > 20);
    ss_mesh_destroy(&m);

    m = generate("block --size-mm 100,50,20", "s.obj", 1e-3);
    const ss_mesh_report r = expect_clean(m, 0.0);
    assert_near(r.area, 2.0 * (0.1 * 0.05 + 0.05 * 0.02 + 0.02 * 0.1), 1e-9);
    assert_near(r.volume, 0.1 * 0.05 * 0.02, 1e-12);
    assert_near(m->node_count, 1200, 120);
    ss_mesh_destroy(&m);

    m = generate("kidney --points 400", "k.msh", 1e-3);
    assert_int_equal(m->node_count, 400);
    assert_true(find_group(m, "fixed")->node_count > 5);
    ss_mesh_destroy(&m);
}

/* Made without what is within: the very surface of the whole box, and room for a million nodes. */
TEST(the_surface_of_a_box_needs_no_inside)
{
    char out[2048];
    ss_mesh *whole = generate("block --tetrahedra --points 1331", "whole.msh", 1.0);
    ss_mesh *alone = generate("block --points 602", "alone.msh", 1.0);
    assert_int_equal(whole->node_count, 1331);
    assert_int_equal(alone->node_count, 602);
    assert_int_equal(alone->triangle_count, whole->triangle_count);
    for (int32_t t = 0; t < alone->triangle_count; ++t) {
        for (int v = 0; v < 3; ++v) {
            assert_memory_equal(alone->position[alone->triangle[t][v]],
                                whole->position[whole->triangle[t][v]], sizeof *alone->position);
        }
    }
    assert_int_equal(find_group(alone, "top")->node_count, find_group(whole, "top")->node_count);
    ss_mesh_destroy(&whole);
    ss_mesh_destroy(&alone);
    if (!FULL_IN_LONG_RUN(true, false)) {
        return;
    }
    run_tool("generate block --points 1000000 --out m.msh");
    assert_non_null(strstr(out, "998786 nodes"));
}

TEST(the_same_bytes_come_out_every_time)
{
    SKIP_WHERE_REPEATED();
    char out[2048];
    assert_int_equal(run(TOOL "generate kidney --tetrahedra --points 250 --out a.msh && " TOOL
                              "generate kidney --tetrahedra --points 250 --out b.msh && "
                              "cmp a.msh b.msh",
                         out, sizeof out),
                     0);
}

TEST(what_makes_no_body_is_refused)
{
    static const tool_row rows[] = {
        {"generate liver --tetrahedra --out x.obj", 2, "would hold no tetrahedra"},
        {"generate plane --tetrahedra", 2, "--tetrahedra means nothing for a plane"},
        {"generate cylinder --tetrahedra --rows 5", 2,
         "--rows means nothing for a cylinder of tetrahedra"},
        {"generate cylinder --points 500", 2, "--points means nothing for a cylinder"},
        {"generate block --inner-mm 1,1,1", 2, "--inner-mm means nothing for a block"},
        {"generate block --base-mm 1", 2, "--base-mm means nothing for a block"},
        {"generate ventricle --inner-mm 14,20,34", 2, "too close to --size-mm"},
        {"generate ventricle --base-mm 17", 2, "--base-mm: 17"},
        {"generate block --size-mm 1,2,x", 2, "--size-mm: '1,2,x'"},
        {"generate kidney --size-mm 1,2,3", 2, "--size-mm means nothing for a kidney"},
        {"generate kidney --tetrahedra --points 2000000", 2, "at most 300000"},
        {"generate kidney --points 2000000", 2, "at most 200000"},
        {"generate kidney --order 2", 2, "--order 2 means nothing for a surface"},
    };
    expect_answers(rows, COUNT(rows));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
