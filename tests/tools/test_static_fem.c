/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench/static_fem: homogeneous states in closed form on a mesh with a crooked inside; what
 * another program's linear tetrahedra reach on the reference problems, to the digits given there;
 * reactions balance the loads; bodies that nothing holds and laws that are none are refused.
 */
#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/static_fem.h"
#include "common/number_fixture.h"
#include "rt/each.h"
#include "rt/vec.h"

#define REFERENCE SOURCE_DIR "/tests/reference/"

typedef double vector[3];

/* ---- a body under test ---- */

typedef struct body {
    ss_mesh *mesh;
    uint8_t *held;
    vector *prescribed, *u, *reaction;
    ss_static_problem problem;
    ss_static_report report;
    softsim_error error;
} body;

static void body_init(body *b, const char *mesh, ss_tissue_kind kind, double young, double poisson)
{
    char path[512];
    memset(b, 0, sizeof *b);
    snprintf(path, sizeof path, REFERENCE "%s", mesh);
    if (ss_mesh_load(path, 1.0, NULL, &b->mesh, &b->error) != SOFTSIM_OK) {
        fail_msg("%s", b->error.text);
    }
    const size_t n = (size_t)b->mesh->node_count;
    b->held = calloc(n, 1);
    b->prescribed = calloc(n, sizeof *b->prescribed);
    b->u = calloc(n, sizeof *b->u);
    b->reaction = calloc(n, sizeof *b->reaction);
    b->problem = (ss_static_problem){.mesh = b->mesh,
                                     .law = {.kind = kind},
                                     .held = b->held,
                                     .prescribed = (const vector *)b->prescribed};
    ss_tissue_lame(young, poisson, &b->problem.law.lambda, &b->problem.law.mu);
}

static void body_fini(body *b)
{
    ss_mesh_destroy(&b->mesh);
    SS_EACH(free, b->held, b->prescribed, b->u, b->reaction);
}

static const ss_mesh_group *group_of(const body *b, const char *name)
{
    for (int32_t k = 0; k < b->mesh->group_count; ++k) {
        if (strcmp(b->mesh->group[k].name, name) == 0) {
            return &b->mesh->group[k];
        }
    }
    fail_msg("no group %s", name);
    return NULL;
}

static const ss_mesh_group *hold_group(body *b, const char *name, uint8_t axes)
{
    const ss_mesh_group *group = group_of(b, name);
    for (int32_t k = 0; k < group->node_count; ++k) {
        b->held[group->node[k]] |= axes;
    }
    return group;
}

static void solve(body *b)
{
    if (ss_static_solve(&b->problem, b->u, b->reaction, &b->report, &b->error) != SOFTSIM_OK) {
        fail_msg("%s", b->error.text);
    }
}

static double sum_of(const body *b, const vector *x, const char *name, int axis)
{
    const ss_mesh_group *group = group_of(b, name);
    double sum = 0.0;
    for (int32_t k = 0; k < group->node_count; ++k) {
        sum += x[group->node[k]][axis];
    }
    return sum;
}

/* ---- closed forms ---- */

/* The cube on rollers, stretched along x: force and lateral stretch, at every node the same. */
static void stretch(body *b, double lambda, double lateral, double force)
{
    const ss_mesh_group *end = group_of(b, "x1");
    for (int32_t k = 0; k < end->node_count; ++k) {
        b->prescribed[end->node[k]][0] = lambda - 1.0;
    }
    solve(b);
    assert_near(sum_of(b, (const vector *)b->reaction, "x1", 0), force, 1e-6 * 1e4);
    for (int32_t i = 0; i < b->mesh->node_count; ++i) {
        const double *x = b->mesh->position[i];
        assert_near(b->u[i][0], (lambda - 1.0) * x[0], 1e-7);
        assert_near(b->u[i][1], (lateral - 1.0) * x[1], 1e-7);
        assert_near(b->u[i][2], (lateral - 1.0) * x[2], 1e-7);
    }
}

static void test_rows(const char *mesh, const char *poisson, int every)
{
    char path[512], line[256];
    snprintf(path, sizeof path, REFERENCE "a_uniaxial/stretch_E10000_nu%s.csv", poisson);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    body b = {0};
    for (int row = 0; fgets(line, sizeof line, file); ++row) {
        char material[8];
        double lambda, lateral, force;
        assert_int_equal(sscanf(line, "%7[a-z],%lf,%lf,%lf", material, &lambda, &lateral, &force),
                         4);
        if (row % every != 0 || lambda == 1.0) {
            continue;
        }
        body_init(&b, mesh, strcmp(material, "nh") == 0 ? SS_TISSUE_NEO_HOOKEAN : SS_TISSUE_STVK,
                  1e4, atof(poisson));
        hold_group(&b, "x0", 1);
        hold_group(&b, "x1", 1);
        hold_group(&b, "y0", 2);
        hold_group(&b, "z0", 4);
        stretch(&b, lambda, lateral, force);
        body_fini(&b);
    }
    fclose(file);
}

TEST(stretches_as_the_closed_form)
{
    test_rows("a_uniaxial/mesh_8.msh", "0.3", 1);
    test_rows("a_uniaxial/mesh_8.msh", "0.45", 2);
    test_rows("a_uniaxial/mesh_8.msh", "0.49", 2);
}

TEST(passes_the_patch_test)
{
    test_rows("a_uniaxial/mesh_125.msh", "0.45", 16);
}

/* ---- an independent program ---- */

/* Errors in per cent against columns ux_LEVEL of a reference: L2 by node weight, and the largest.
 */
static void compare(const body *b, const char *csv, const char *level, double *out_l2,
                    double *out_max)
{
    char path[512], line[4096], wanted[32];
    snprintf(path, sizeof path, REFERENCE "%s", csv);
    snprintf(wanted, sizeof wanted, "ux_%s", level);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    int column = 0, found = -1;
    for (char *save = NULL, *name = strtok_r(line, ",\n", &save); name;
         name = strtok_r(NULL, ",\n", &save), ++column) {
        found = strcmp(name, wanted) == 0 ? column : found;
    }
    assert_true(found > 0);
    double difference = 0.0, whole = 0.0, worst = 0.0, largest = 0.0;
    while (fgets(line, sizeof line, file)) {
        double value[32];
        int count = 0;
        for (char *save = NULL, *text = strtok_r(line, ",\n", &save); text && count < 32;
             text = strtok_r(NULL, ",\n", &save)) {
            value[count++] = atof(text);
        }
        double e[3];
        ss_sub3(e, b->u[(int32_t)value[0] - 1], value + found);
        difference += value[4] * ss_dot3(e, e);
        whole += value[4] * ss_dot3(value + found, value + found);
        worst = fmax(worst, ss_norm3(e));
        largest = fmax(largest, ss_norm3(value + found));
    }
    fclose(file);
    *out_l2 = 100.0 * sqrt(difference / whole);
    *out_max = 100.0 * worst / largest;
}

static void slab_at(ss_tissue_kind kind, double depth, const char *csv, const char *level,
                    double l2, double largest, double force)
{
    body b;
    body_init(&b, "c_slab/mesh_300.msh", kind, 1e4, 0.45);
    hold_group(&b, "fixed", 7);
    const ss_mesh_group *patch = hold_group(&b, "patch", 7);
    for (int32_t k = 0; k < patch->node_count; ++k) {
        const double *x = b.mesh->position[patch->node[k]];
        b.prescribed[patch->node[k]][2] =
            -depth * (1.0 - (x[0] * x[0] + x[1] * x[1]) / (2.0 * 0.02 * 0.02));
    }
    solve(&b);
    double l2_here, max_here;
    compare(&b, csv, level, &l2_here, &max_here);
    assert_near(l2_here, l2, 0.002);
    assert_near(max_here, largest, 0.002);
    assert_near(-sum_of(&b, (const vector *)b.reaction, "patch", 2), force, 1e-4 * force);
    assert_near(sum_of(&b, (const vector *)b.reaction, "fixed", 2), force, 1e-4 * force);
    body_fini(&b);
}

TEST(indents_the_slab_as_the_floor_says)
{
    slab_at(SS_TISSUE_LINEAR, 0.001, "c_slab/reference_u_linear_300.csv", "1mm", 14.706, 12.451,
            0.67366);
    slab_at(SS_TISSUE_STVK, 0.005, "c_slab/reference_u_stvk_300.csv", "5mm", 20.490, 14.603,
            2.8208);
    slab_at(SS_TISSUE_NEO_HOOKEAN, 0.015, "c_slab/reference_u_nh_300.csv", "15mm", 18.066, 14.171,
            11.352);
}

TEST(bends_the_beam_as_the_floor_says)
{
    static const struct {
        ss_tissue_kind kind;
        double g, tip;
    } row[] = {{SS_TISSUE_LINEAR, 1.0, -0.046414},
               {SS_TISSUE_STVK, 1.0, -0.041515},
               {SS_TISSUE_NEO_HOOKEAN, 1.0, -0.041325}};
    for (size_t k = 0; k < sizeof row / sizeof *row; ++k) {
        body b;
        body_init(&b, "b_cantilever/mesh_99.msh", row[k].kind, 5e4, 0.3);
        hold_group(&b, "fixed", 7);
        b.problem.density = 1000.0;
        b.problem.gravity[2] = -9.81 * row[k].g;
        solve(&b);
        int32_t tip = -1;
        for (int32_t i = 0; i < b.mesh->node_count; ++i) {
            const double away[3] = {b.mesh->position[i][0] - 0.1, b.mesh->position[i][1],
                                    b.mesh->position[i][2]};
            tip = ss_norm3(away) < 1e-9 ? i : tip;
        }
        assert_true(tip >= 0);
        assert_near(b.u[tip][2], row[k].tip, 1.1e-6);
        assert_near(sum_of(&b, (const vector *)b.reaction, "fixed", 2),
                    1000.0 * 0.1 * 0.02 * 0.02 * 9.81 * row[k].g, 1e-8);
        assert_near(sum_of(&b, (const vector *)b.reaction, "fixed", 0), 0.0, 1e-8);
        body_fini(&b);
    }
}

/* The surface triangles whose nodes are all in a group. */
static int32_t find_pressed(const body *b, const char *name, int32_t (*out)[3])
{
    const ss_mesh_group *group = group_of(b, name);
    uint8_t *is_in = calloc((size_t)b->mesh->node_count, 1);
    int32_t count = 0;
    for (int32_t k = 0; k < group->node_count; ++k) {
        is_in[group->node[k]] = 1;
    }
    for (int32_t t = 0; t < b->mesh->triangle_count; ++t) {
        const int32_t *c = b->mesh->triangle[t];
        if (is_in[c[0]] && is_in[c[1]] && is_in[c[2]]) {
            memcpy(out[count++], c, sizeof out[0]);
        }
    }
    free(is_in);
    return count;
}

TEST(inflates_the_ventricle_as_the_floor_says)
{
    body b;
    body_init(&b, "e_ventricle/mesh_400.msh", SS_TISSUE_NEO_HOOKEAN, 3e4, 0.45);
    hold_group(&b, "base", 7);
    int32_t(*pressed)[3] = calloc((size_t)b.mesh->triangle_count, sizeof *pressed);
    b.problem.pressed_count = find_pressed(&b, "endo", pressed);
    b.problem.pressed = (const int32_t(*)[3])pressed;
    assert_true(b.problem.pressed_count > 50);
    b.problem.pressure = 2000.0;
    solve(&b);
    double l2, largest;
    compare(&b, "e_ventricle/reference_u_nh_400.csv", "2000Pa", &l2, &largest);
    assert_near(l2, 36.933, 0.01);
    assert_near(largest, 41.210, 0.01);
    free(pressed);
    body_fini(&b);
}

/* ---- the rest ---- */

TEST(follows_the_stiffness_of_each_element)
{
    body soft, hard;
    body_init(&soft, "a_uniaxial/mesh_125.msh", SS_TISSUE_LINEAR, 1e4, 0.3);
    body_init(&hard, "a_uniaxial/mesh_125.msh", SS_TISSUE_LINEAR, 1e4, 0.3);
    body *const both[] = {&soft, &hard};
    double *stiffness = calloc((size_t)soft.mesh->tetrahedron_count, sizeof *stiffness);
    for (int32_t t = 0; t < soft.mesh->tetrahedron_count; ++t) {
        stiffness[t] = 2.5;
    }
    hard.problem.stiffness = stiffness;
    for (int k = 0; k < 2; ++k) {
        hold_group(both[k], "z0", 7);
        both[k]->problem.density = 1000.0;
        both[k]->problem.gravity[0] = 9.81;
        solve(both[k]);
    }
    for (int32_t i = 0; i < soft.mesh->node_count; ++i) {
        assert_near(2.5 * hard.u[i][0], soft.u[i][0], 1e-8);
    }
    free(stiffness);
    body_fini(&soft);
    body_fini(&hard);
}

TEST(goes_on_from_an_equilibrium)
{
    body b;
    vector *further = calloc(8, sizeof *further);
    body_init(&b, "a_uniaxial/mesh_8.msh", SS_TISSUE_NEO_HOOKEAN, 1e4, 0.45);
    hold_group(&b, "x0", 7);
    hold_group(&b, "x1", 7);
    for (int way = 0; way < 2; ++way) {
        for (int k = way; k < 2; ++k) {
            const ss_mesh_group *end = group_of(&b, "x1");
            for (int32_t i = 0; i < end->node_count; ++i) {
                b.prescribed[end->node[i]][0] = k == 0 ? -0.1 : -0.2;
                b.prescribed[end->node[i]][1] = k == 0 ? 0.1 : 0.2;
            }
            solve(&b);
        }
        if (way == 0) {
            memcpy(further, b.u, 8 * sizeof *further);
            memset(b.u, 0, 8 * sizeof *b.u);
        }
    }
    for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 3; ++k) {
            assert_near(b.u[i][k], further[i][k], 1e-9);
        }
    }
    free(further);
    body_fini(&b);
}

TEST(linear_call_is_the_linear_law)
{
    body b;
    body_init(&b, "a_uniaxial/mesh_125.msh", SS_TISSUE_LINEAR, 2e3, 0.4);
    hold_group(&b, "x0", 7);
    const ss_mesh_group *end = hold_group(&b, "x1", 7);
    for (int32_t i = 0; i < end->node_count; ++i) {
        b.prescribed[end->node[i]][2] = 0.01;
    }
    solve(&b);
    const double force = sum_of(&b, (const vector *)b.reaction, "x1", 2);
    assert_true(force > 0.0);
    assert_int_equal(ss_static_linear(b.mesh, 2e3, 0.4, b.held, (const vector *)b.prescribed, b.u,
                                      b.reaction, &b.error),
                     SOFTSIM_OK);
    assert_near(sum_of(&b, (const vector *)b.reaction, "x1", 2), force, 1e-9 * force);
    body_fini(&b);
}

TEST(refuses_what_has_no_answer)
{
    body b;
    body_init(&b, "a_uniaxial/mesh_8.msh", SS_TISSUE_LINEAR, 1e4, 0.3);
    assert_int_equal(ss_static_solve(&b.problem, b.u, NULL, NULL, &b.error), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(b.error.text, "not held"));
    hold_group(&b, "x0", 7);
    b.problem.law.mu = -1.0;
    assert_int_equal(ss_static_solve(&b.problem, b.u, NULL, NULL, NULL), SOFTSIM_ERROR_ARGUMENT);
    b.problem.law.mu = 4e3;
    b.problem.law.kind = SS_TISSUE_STVK; /* crushed by its own weight a thousand times over */
    b.problem.density = 1e6;
    b.problem.gravity[0] = -9.81;
    assert_int_equal(ss_static_solve(&b.problem, b.u, NULL, NULL, &b.error), SOFTSIM_ERROR_SYSTEM);
    assert_non_null(strstr(b.error.text, "no equilibrium"));
    body_fini(&b);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
