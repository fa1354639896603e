/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What a body is coloured by, against closed forms of a body that is strained evenly. */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/folder_fixture.h"
#include "world/field.h"
#include "world/world.h"

/* A cube of 10 mm in five tetrahedra, E 9 kPa, nu 0.25: lambda = mu = 3600 Pa, K = 6000 Pa. */
static const char cube[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n"
                           "1 0 0 0\n2 10 0 0\n3 10 10 0\n4 0 10 0\n"
                           "5 0 0 10\n6 10 0 10\n7 10 10 10\n8 0 10 10\n$EndNodes\n$Elements\n5\n"
                           "1 4 2 0 1 1 2 4 5\n2 4 2 0 1 2 3 4 7\n3 4 2 0 1 2 7 5 6\n"
                           "4 4 2 0 1 4 5 7 8\n5 4 2 0 1 2 4 5 7\n$EndElements\n";
static const double K = 6000.0, MU = 3600.0;
enum { MOST = 8 + 18 }; /* nodes: corners, and sides of a model that has nodes there */

static ss_world *create(const char *model)
{
    char text[512];
    snprintf(
        text, sizeof text,
        "softsim: 1\nobject: {mesh: cube.msh, units: mm, fixed: [{nodes: [0]}]}\nmodel: {%s}\n",
        model);
    write_text("cube.msh", cube);
    const ss_world_options options = {
        .scene_path = write_text("cube.yaml", text), .threads = 1, .is_lockstep = true};
    ss_world *world = NULL;
    softsim_error error = {.status = SOFTSIM_OK};
    if (ss_world_create(&options, &world, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return world;
}

/* Every node's value for u = H x, which must be the same one. */
static double even_value(ss_world *world, ss_scene_field kind, const double h[3][3])
{
    const ss_drawn *drawn = &world->drawn;
    float u[3 * MOST], value[MOST];
    assert_in_range(drawn->node_count, 8, MOST);
    for (int32_t i = 0; i < drawn->node_count; ++i) {
        for (int d = 0; d < 3; ++d) {
            u[3 * i + d] = 0.0F;
            for (int k = 0; k < 3; ++k) {
                u[3 * i + d] += (float)(h[d][k] * drawn->rest[i][k]);
            }
        }
    }
    ss_field *field = ss_field_create(world->scene, world->model_class, drawn);
    assert_non_null(field);
    ss_field_compute(field, kind, u, value);
    ss_field_destroy(&field);
    assert_null(field);
    for (int32_t i = 1; i < drawn->node_count; ++i) {
        assert_true(fabsf(value[i] - value[0]) <= 1e-4F * fabsf(value[0]) + 0.01F);
    }
    return (double)value[0];
}

static void expect_near(double value, double wanted, double share)
{
    if (!(fabs(value - wanted) <= share * fabs(wanted))) {
        fail_msg("%g is not %g", value, wanted);
    }
}

/* Squeezed by s on all sides: J = (1 - s)^3; neo-Hookean: W = K/2 (J - 1)^2, pressure -K (J - 1).
 */
TEST(squeezed_tissue_has_the_pressure_of_its_law)
{
    const double s = 0.05, j = pow(1.0 - s, 3);
    const double h[3][3] = {{-s, 0, 0}, {0, -s, 0}, {0, 0, -s}};
    ss_world *world =
        create("name: fem, material: neo-hookean, youngs_modulus_pa: 9000, poisson_ratio: 0.25");
    expect_near(even_value(world, SS_SCENE_FIELD_PRESSURE, h), -K * (j - 1.0), 1e-3);
    expect_near(even_value(world, SS_SCENE_FIELD_ENERGY, h), 0.5 * K * (j - 1.0) * (j - 1.0), 1e-3);
    ss_world_destroy(&world);
}

/* Sheared by g, St. Venant-Kirchhoff: E12 = g/2, E22 = g^2/2, W = mu E:E + lambda/2 tr(E)^2; the
 * same by Lame's constants, and of a model that has another law. */
TEST(sheared_tissue_has_the_energy_of_its_law)
{
    static const char *const models[] = {
        "name: fem, material: stvk, youngs_modulus_pa: 9000, poisson_ratio: 0.25",
        "name: fem, material: stvk, lame_lambda_pa: 3600, lame_mu_pa: 3600",
        "name: fem-quadratic, material: stvk, youngs_modulus_pa: 9000, poisson_ratio: 0.25",
        "name: corotational, youngs_modulus_pa: 9000, poisson_ratio: 0.25"};
    const double g = 0.2, h[3][3] = {{0, g, 0}, {0, 0, 0}, {0, 0, 0}};
    const double e12 = g / 2.0, e22 = g * g / 2.0;
    const double energy = MU * (2.0 * e12 * e12 + e22 * e22) + 0.5 * MU * e22 * e22;
    for (size_t i = 0; i < sizeof models / sizeof models[0]; ++i) {
        ss_world *world = create(models[i]);
        expect_near(even_value(world, SS_SCENE_FIELD_ENERGY, h), energy, 1e-3);
        ss_world_destroy(&world);
    }
}

TEST(a_body_that_only_turns_stores_nothing)
{
    const double c = cos(1.0) - 1.0, s = sin(1.0), h[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 0}};
    ss_world *world = create("name: fem, youngs_modulus_pa: 9000, poisson_ratio: 0.25");
    assert_true(fabs(even_value(world, SS_SCENE_FIELD_ENERGY, h)) < 1e-6 * MU);
    assert_true(fabs(even_value(world, SS_SCENE_FIELD_PRESSURE, h)) < 1e-5 * MU);
    ss_world_destroy(&world);
}

TEST(a_body_without_moduli_has_its_displacement_alone)
{
    const double h[3][3] = {{0}};
    char text[256];
    ss_command_record record;
    ss_world *world = create("name: chainmail");
    assert_true(
        ss_field_is_possible(world->scene, world->model_class, SS_SCENE_FIELD_DISPLACEMENT));
    assert_false(ss_field_is_possible(world->scene, world->model_class, SS_SCENE_FIELD_PRESSURE));
    assert_true(even_value(world, SS_SCENE_FIELD_DISPLACEMENT, h) == 0.0);
    assert_int_equal(
        ss_world_command(world, "set", "publish.field=energy", &record, text, sizeof text), 1);
    assert_non_null(strstr(text, "use none or displacement"));
    assert_int_equal(
        ss_world_command(world, "set", "publish.field=displacement", &record, text, sizeof text),
        0);
    ss_world_destroy(&world);
}

/* Of a model with cells the sim tells what acts, as long as it is asked for. */
TEST(a_model_with_a_potential_of_its_own_tells_it)
{
    char text[256];
    ss_command_record record;
    ss_world *world = create("name: cnn-energy, modulus_j: 5, area_density_kg_m2: 10, "
                             "damping_n_s_per_m3: 1000, rest_stiffness_n_per_m3: 1e4");
    assert_false(ss_field_is_possible(world->scene, world->model_class, SS_SCENE_FIELD_ENERGY));
    assert_int_equal(
        ss_world_command(world, "set", "publish.field=pressure", &record, text, sizeof text), 1);
    assert_non_null(strstr(text, "use none or displacement or potential"));
    assert_int_equal(
        ss_world_command(world, "set", "publish.field=potential", &record, text, sizeof text), 0);
    for (int asked = 0; asked < 2; ++asked) {
        bool is_new = false;
        atomic_store(&world->field, asked ? SS_SCENE_FIELD_POTENTIAL : SS_SCENE_FIELD_ENERGY);
        for (int32_t k = 0; k < world->snapshot_every; ++k) {
            ss_world_step_begin(world);
            ss_world_step_compute(world);
            ss_world_step_post(world);
        }
        const ss_surface_snapshot *snapshot = ss_mailbox_take(world->surface, &is_new);
        assert_true(is_new && snapshot->has_source == (asked == 1));
    }
    ss_world_destroy(&world);
}

TEST(a_scene_that_asks_for_what_is_not_there_is_refused)
{
    const ss_world_options options = {
        .scene_path = write_text("none.yaml",
                                 "softsim: 1\nobject: {mesh: cube.msh, units: mm, fixed: [{nodes: "
                                 "[0]}]}\nmodel: {name: chainmail}\npublish: {field: energy}\n"),
        .threads = 1,
        .is_lockstep = true};
    static const char *const set[] = {"publish.field=potential"};
    const ss_world_options other = {.scene_path = options.scene_path,
                                    .threads = 1,
                                    .is_lockstep = true,
                                    .set = set,
                                    .set_count = 1};
    ss_world *world = NULL;
    softsim_error error = {.status = SOFTSIM_OK};
    write_text("cube.msh", cube);
    assert_int_equal(ss_world_create(&options, &world, &error), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(error.text, "publish.field: chainmail has no tetrahedra with elastic"));
    assert_non_null(strstr(error.text, "use none or displacement"));
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(ss_world_create(&other, &world, &error), SOFTSIM_ERROR_SCENE);
    assert_non_null(strstr(error.text, "publish.field: chainmail has no potential of its own"));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
