/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The table of models and the interface of each: parameters, refusals, explanations, reset, hash,
 * threads, and that the kernels of all SIMD paths agree.
 */
#include "common/test.h"

#include "common/element_fixture.h"
#include "common/note_fixture.h"
#include "rt/hash.h"
#include "rt/thread.h"

/* A small body with one load and one sphere. */
static void setup_whole(setup *s)
{
    static int32_t top;
    setup_init(s, "cnn-energy", make_ellipsoid(4, 0.05, 0.04, 0.03));
    top = 0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][2] < -0.024 ? 7 : 0;
        top = s->mesh->position[i][2] > s->mesh->position[top][2] ? i : top;
    }
    give_skin(s);
    give(s, "pretension_j", 0.1);
    add_sphere(s, 0, 0.01);
    push(s, &top, 0.05, 0.0, 0.0);
}

static void create_whole(setup *s)
{
    setup_whole(s);
    create(s);
}

static void drive(setup *s, int count)
{
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    for (int k = 0; k < count; ++k) {
        const double depth = 0.006 * fmin(1.0, k / 60.0);
        ss_tool_pose to = {.position = {0.02 - 3e-5 * k, 0.0, 0.038 - depth},
                           .orientation = {1.0, 0.0, 0.0, 0.0}};
        tool[0].from = k == 0 ? to : tool[0].to;
        tool[0].to = to;
        tool[0].is_grasping = k > 120 && k < 160;
        s->class->step(s->model, s->time, 1e-3, tool);
        ss_contact_set set;
        s->class->contacts(s->model, 0, 0.005, &set);
        s->time += 1e-3;
    }
}

static uint64_t hash_with_velocity(const setup *s)
{
    return ss_hash_bytes(hash_of(s), s->class->velocity(s->model),
                         (size_t)s->mesh->node_count * 4 * sizeof(ss_real));
}

/* ---- the table ---- */

TEST(models_are_found_by_name_and_only_built_ones)
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    assert_true(count >= 1);
    assert_null(table[count]);
    for (int32_t k = 0; k < count; ++k) {
        assert_ptr_equal(ss_model_find(table[k]->name), table[k]);
    }
    assert_null(ss_model_find("no-such-model"));
    assert_null(ss_model_find(""));
}

TEST(every_row_has_a_default_within_its_bounds_and_a_help)
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    for (int32_t m = 0; m < count; ++m) {
        assert_non_null(table[m]->help);
        for (int32_t k = 0; k < table[m]->row_count; ++k) {
            const ss_param_row *row = &table[m]->row[k];
            assert_non_null(row->name);
            assert_true(row->help && strlen(row->help) > 10);
            /* A choice may be of one word. */
            assert_true(row->kind == SS_PARAM_CHOICE ? row->range.min <= row->range.max
                                                     : row->range.min < row->range.max);
            if (!isnan(row->fallback)) {
                assert_true(row->fallback >= row->range.min && row->fallback <= row->range.max);
                assert_true(!row->range.exclusive_min || row->fallback > row->range.min);
            }
            for (int32_t other = 0; other < k; ++other) {
                assert_string_not_equal(row->name, table[m]->row[other].name);
            }
        }
    }
}

/* ---- refusals ---- */

typedef void (*spoil)(setup *s);

/* Spoils what is good. */
#define SPOIL(name, ...)                                                                           \
    static void name(setup *s)                                                                     \
    {                                                                                              \
        __VA_ARGS__;                                                                               \
    }

SPOIL(no_modulus, s->param[SS_CNN_MODULUS_J].is_given = false)
SPOIL(two_moduli, give(s, "modulus_n_per_m", 10.0))
SPOIL(mixed_kinds, give(s, "mass_kg", 1.0))
SPOIL(missing_mass, s->param[SS_CNN_AREA_DENSITY].is_given = false)
SPOIL(negative_damping, give(s, "damping_n_s_per_m3", -1.0))
SPOIL(not_a_number, give(s, "rest_stiffness_n_per_m3", (double)NAN))
SPOIL(free_with_pretension, memset(s->fixed, 0, (size_t)s->mesh->node_count))
SPOIL(held_in_a_line, memset(s->fixed, 0, (size_t)s->mesh->node_count);
      s->fixed[0] = s->fixed[1] = 7)
static void load_on_fixed(setup *s)
{
    static int32_t node;
    for (node = 0; s->fixed[node] != 7; ++node) {
    }
    s->load[0].node = &node;
}
static void load_outside(setup *s)
{
    static int32_t node = 100000;
    s->load[0].node = &node;
}
SPOIL(pressure_without_triangles, s->load[0].is_pressure = true; s->load[0].pressure = 1.0)
static void soft_contact(setup *s)
{
    static double rho[1000];
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        rho[i] = i == s->load[0].node[0] ? 0.01 : 1.0;
    }
    give_field(s, "rho", rho);
}
static void prescribed_and_fixed(setup *s)
{
    static int32_t node;
    static double way[1][3] = {{0.0, 0.0, 0.001}};
    for (node = 0; s->fixed[node] != 7; ++node) {
    }
    s->prescribed[0] = (ss_prescribed){
        .node = &node, .node_count = 1, .displacement = way, .axis = {false, false, true}};
    s->plan.prescribed_count = 1;
}

SPOIL(volume_on_a_surface, give(s, "domain", 1.0))
SPOIL(volume_rows_on_a_surface, give(s, "density_kg_m3", 1000.0))
SPOIL(volume_modulus_on_a_surface, give(s, "modulus_pa", 1000.0))
SPOIL(huge_modulus, give(s, "modulus_j", 1e10))
SPOIL(rho_thrice, give(s, "rho", 0.5); give(s, "rho_direction", 1.0); give(s, "rho_across", 1.0))
SPOIL(rho_across_alone, give(s, "rho_across", 1.0); give_direction(s, 1.0, 0.0, 0.0))
SPOIL(direction_alone, give_direction(s, 1.0, 0.0, 0.0))
SPOIL(no_direction, give(s, "rho_direction", 1.0); give(s, "rho_across", 2.0))
SPOIL(long_direction, no_direction(s); give_direction(s, 1.0, 1.0, 0.0))
static void bad_rho_across(setup *s)
{
    static double rho[1000];
    no_direction(s);
    give_direction(s, 1.0, 0.0, 0.0);
    for (int k = 0; k < 1000; ++k) {
        rho[k] = k == 17 ? 0.0 : 1.0;
    }
    give_field(s, "rho_across", rho);
}
static void bad_direction_of_one(setup *s)
{
    static double direction[1000][3];
    no_direction(s);
    for (int k = 0; k < 1000; ++k) {
        ss_set3(direction[k], 0.0, 0.0, k == 23 ? (double)NAN : 1.0);
    }
    s->param[row_of(s, "material_direction")] =
        (ss_param_value){.per_element = direction, .is_given = true};
}

typedef struct refusal {
    spoil how;
    const char *says;
} refusal;

/* Each of them spoils what `prepare` sets up, and is named. */
static void expect_refusals(void (*prepare)(setup *s), const refusal *row, size_t count)
{
    const int64_t before = ss_memory_in_use();
    for (size_t k = 0; k < count; ++k) {
        setup s;
        prepare(&s);
        row[k].how(&s);
        if (setup_create(&s) == SOFTSIM_OK || !strstr(s.error.text, row[k].says)) {
            fail_msg("case %d: \"%s\" does not say \"%s\"", (int)k, s.error.text, row[k].says);
        }
        assert_null(s.model);
        setup_fini(&s);
    }
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(what_cannot_be_is_refused_and_named)
{
    static const refusal row[] = {
        {no_modulus, "modulus_j or modulus_n_per_m"},
        {two_moduli, "not both"},
        {mixed_kinds, "mass_kg"},
        {missing_mass, "area_density_kg_m2 is missing"},
        {negative_damping, "damping_n_s_per_m3"},
        {not_a_number, "rest_stiffness_n_per_m3"},
        {free_with_pretension, "three fixed nodes"},
        {held_in_a_line, "three fixed nodes"},
        {load_on_fixed, "fixed nodes (first"},
        {load_outside, "100000"},
        {pressure_without_triangles, "no triangle"},
        {soft_contact, "rho at node"},
        {prescribed_and_fixed, "fixed or prescribed already"},
        {volume_on_a_surface, "needs a mesh of tetrahedra"},
        {volume_rows_on_a_surface, "density_kg_m3 does not go with domain: surface; give "
                                   "area_density_kg_m2"},
        {volume_modulus_on_a_surface, "modulus_pa does not go with domain: surface"},
        {huge_modulus, "modulus_j must be greater than 0 and at most"},
        {rho_thrice, "give rho, or rho_direction and rho_across, not both"},
        {rho_across_alone, "rho_direction is missing"},
        {direction_alone, "material_direction needs rho_direction"},
        {no_direction, "need material_direction"},
        {long_direction, "material_direction must have length 1"},
        {bad_rho_across, "rho_across must be greater than 0 and at most 1e+12 at every node; "
                         "1 nodes are not (first 17)"},
        {bad_direction_of_one, "at 1 elements it has not (first 23)"}};
    expect_refusals(setup_whole, row, sizeof row / sizeof *row);
}

/* A block of 6 x 6 x 6 cm as a volume with one load, held below. */
static void setup_volume(setup *s)
{
    static int32_t top = (1 * 4 + 2) * 4 + 3;
    setup_init(s, "cnn-energy", make_block(3, 0.06));
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][2] < -0.029 ? 7 : 0;
    }
    give(s, "domain", 1.0);
    give(s, "modulus_pa", 5e4);
    give(s, "density_kg_m3", 1000.0);
    give(s, "damping_n_s_per_m4", 3e5);
    give(s, "rest_stiffness_n_per_m4", 5e5);
    push(s, &top, 0.05, 0.0, 0.0);
}

SPOIL(surface_rows_in_a_volume, give(s, "rest_stiffness_n_per_m3", 1.0))
SPOIL(node_rows_in_a_volume, give(s, "per_area", 0.0))
SPOIL(surface_modulus_in_a_volume, s->param[SS_CNN_MODULUS_PA].is_given = false;
      give(s, "modulus_n_per_m", 5.0))
static void load_inside(setup *s)
{
    static int32_t node = (1 * 4 + 2) * 4 + 1;
    s->load[0].node = &node;
}
static void surface_of_a_volume(setup *s)
{
    give(s, "domain", 0.0);
    s->param[SS_CNN_MODULUS_PA].is_given = false;
    for (int row = SS_CNN_VOLUME_DENSITY; row <= SS_CNN_VOLUME_REST_STIFFNESS; ++row) {
        s->param[row].is_given = false;
    }
    give_skin(s);
}
SPOIL(load_below_the_surface, surface_of_a_volume(s); load_inside(s))
static void held_inside_alone(setup *s)
{
    surface_of_a_volume(s);
    give(s, "pretension_j", 0.1);
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        const double *p = s->mesh->position[i];
        const bool is_inside = fmax(fmax(fabs(p[0]), fabs(p[1])), fabs(p[2])) < 0.029;
        s->fixed[i] = is_inside ? 7 : 0;
    }
}
SPOIL(volume_without_direction, no_direction(s))

static void directions_of_tetrahedra_on_the_surface(setup *s)
{
    static double direction[1000][3];
    surface_of_a_volume(s);
    no_direction(s);
    s->param[row_of(s, "material_direction")] =
        (ss_param_value){.per_element = direction, .is_given = true};
}

TEST(what_cannot_be_in_a_volume_is_refused_and_named)
{
    static const refusal row[] = {
        {surface_rows_in_a_volume, "rest_stiffness_n_per_m3 does not go with domain: volume; "
                                   "give rest_stiffness_n_per_m4"},
        {node_rows_in_a_volume, "density_kg_m3 does not go with per_area: false; give mass_kg"},
        {surface_modulus_in_a_volume, "modulus_n_per_m does not go with domain: volume; give "
                                      "modulus_j or modulus_pa"},
        {load_inside, "acts on no node of the surface"},
        {load_below_the_surface, "inside the volume"},
        {held_inside_alone, "three fixed nodes"},
        {volume_without_direction, "need material_direction"},
        {directions_of_tetrahedra_on_the_surface, "is one a tetrahedron"}};
    expect_refusals(setup_volume, row, sizeof row / sizeof *row);
}

TEST(all_faults_are_named_in_one_go)
{
    setup s;
    setup_whole(&s);
    no_modulus(&s);
    negative_damping(&s);
    load_outside(&s);
    assert_true(setup_create(&s) != SOFTSIM_OK);
    assert_true(s.error.fault_count >= 3);
    /* And without anyone to tell. */
    ss_model *model = NULL;
    assert_true(ss_model_create(s.class, &s.plan, &model, NULL) != SOFTSIM_OK);
    assert_null(model);
    setup_fini(&s);
}

/* A number beyond the mesh has none in the file either. */
TEST(nodes_outside_a_renumbered_mesh_are_named_as_given)
{
    setup s;
    int32_t outside = 4000000;
    setup_init(&s, "cnn-energy", make_plate(6, 0.1));
    assert_true(ss_mesh_renumber(s.mesh));
    assert_non_null(s.mesh->file_node);
    s.fixed[0] = s.fixed[1] = s.fixed[2] = 7;
    push(&s, &outside, 0.0, 0.0, 1.0);
    assert_true(setup_create(&s) != SOFTSIM_OK);
    assert_non_null(strstr(s.error.text, "not in the mesh: 4000000"));
    setup_fini(&s);
}

TEST(short_edges_and_loose_nodes_are_refused)
{
    for (int kind = 0; kind < 2; ++kind) {
        setup s;
        draft d;
        draft_init(&d, 6, 3);
        draft_node(&d, 0.0, 0.0, 0.0);
        draft_node(&d, 1.0, 0.0, 0.0);
        draft_node(&d, 0.5, 1.0, 0.0);
        draft_node(&d, 1.0 + (kind == 0 ? 1e-5 : 0.5), 0.3, 0.0);
        if (kind == 0) {
            ss_set3(d.position[3], 1.0 + 1e-5, 0.0, 0.0);
            draft_triangle(&d, 1, 3, 2);
        }
        draft_triangle(&d, 0, 1, 2);
        setup_init(&s, "cnn-energy", draft_finish(&d));
        s.fixed[0] = s.fixed[1] = s.fixed[2] = 7;
        give_skin(&s);
        assert_int_equal(setup_create(&s), kind == 0 ? SOFTSIM_ERROR_MESH : SOFTSIM_ERROR_SCENE);
        assert_non_null(strstr(s.error.text, kind == 0 ? "between nodes 1 and 3" : "first 3"));
        setup_fini(&s);
    }
}

/* ---- the interface ---- */

static int notes(const setup *s, ss_note_kind kind, const char *where, const char *part)
{
    return note_count(s->class, s->model, kind, where, part);
}

TEST(the_explanation_names_what_is_used_and_left_out)
{
    setup s;
    setup_whole(&s);
    s.plan.max_force = 500.0; /* far beyond what the contact is made for */
    assert_int_equal(setup_create(&s), SOFTSIM_OK);
    assert_int_equal(notes(&s, SS_NOTE_LEFT_OUT, "enclosed volume", ""), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "pretension", "0.1 J"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "modulus", "median Qhat"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "kernels", s.model->kernels->name), 1);
    assert_int_equal(notes(&s, SS_NOTE_WARNING, "contact.tools", "tool 0"), 1);
    setup_fini(&s);
}

/* What it names is what limits the contact, so that doing it helps. */
TEST(a_soft_contact_is_told_with_what_limits_it)
{
    static const struct {
        double working_force, given;
        const char *remedy;
    } cases[] = {{1e-3, 0.0, "force: raise contact.working_force_n, or lower haptic.max_force_n"},
                 {1e9, 0.0, "force: raise simulation.rate_hz or simulation.max_substeps, or lower"},
                 {2.0, 1e3, "force: raise contact.stiffness_n_per_m3, or lower"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        setup s;
        setup_whole(&s);
        s.plan.max_force = 1e6;
        s.plan.working_force = cases[i].working_force;
        s.plan.contact_stiffness = cases[i].given;
        assert_int_equal(setup_create(&s), SOFTSIM_OK);
        assert_int_equal(notes(&s, SS_NOTE_WARNING, "contact.tools", cases[i].remedy), 1);
        setup_fini(&s);
    }
}

TEST(the_explanation_tells_what_carries_the_cells)
{
    setup s;
    create_whole(&s);
    assert_int_equal(notes(&s, SS_NOTE_USED, "network", "cells on triangles"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "anisotropic", ""), 0);
    assert_int_equal(notes(&s, SS_NOTE_LEFT_OUT, "inner nodes", ""), 0);
    setup_fini(&s);

    setup_volume(&s);
    give(&s, "rho_direction", 0.5);
    give(&s, "rho_across", 2.0);
    give_direction(&s, 0.0, 1.0, 0.0);
    assert_int_equal(setup_create(&s), SOFTSIM_OK);
    assert_int_equal(notes(&s, SS_NOTE_USED, "network", "cells on tetrahedra"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "volume", "8 cells inside"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "anisotropic", "is 4 to 4 times that along"), 1);
    assert_int_equal(notes(&s, SS_NOTE_USED, "modulus", "50000 Pa"), 1);
    setup_fini(&s);

    setup_volume(&s);
    surface_of_a_volume(&s);
    assert_int_equal(setup_create(&s), SOFTSIM_OK);
    assert_int_equal(notes(&s, SS_NOTE_LEFT_OUT, "inner nodes", "8 of the volume mesh"), 1);
    setup_fini(&s);

    setup_cylinder(&s, 1.0);
    free_mesh(s.mesh);
    s.plan.mesh = s.mesh = make_grid_cylinder(15, 24, 1.0, 4.0);
    assert_int_equal(setup_create(&s), SOFTSIM_OK);
    assert_int_equal(notes(&s, SS_NOTE_USED, "network",
                           "cells on a rectangular grid (48 held at zero), 696 edges"),
                     1);
    setup_fini(&s);
}

TEST(the_step_cost_grows_with_nodes_and_tools)
{
    setup s;
    setup_whole(&s);
    const double with_tool = s.class->step_cost_us(&s.plan);
    s.plan.tool[0].is_used = false;
    const double without = s.class->step_cost_us(&s.plan);
    assert_true(without > 0.0 && with_tool > without);
    setup_fini(&s);
    setup_volume(&s); /* the same nodes have more edges in a volume */
    const double volume = s.class->step_cost_us(&s.plan);
    give(&s, "domain", 0.0);
    assert_true(volume > s.class->step_cost_us(&s.plan));
    setup_fini(&s);
}

TEST(creating_and_destroying_leaves_no_memory_behind)
{
    const int64_t before = ss_memory_in_use();
    setup s;
    setup_whole(&s);
    give(&s, "enclosed_bulk_pa", 100.0);
    assert_int_equal(setup_create(&s), SOFTSIM_OK);
    assert_true(ss_memory_in_use() > before);
    setup_fini(&s);
    assert_int_equal(ss_memory_in_use(), before);
}

TEST(steps_do_not_allocate)
{
    setup s;
    create_whole(&s);
    const int64_t before = ss_memory_in_use();
    drive(&s, 50);
    assert_int_equal(ss_memory_in_use(), before);
    setup_fini(&s);
}

TEST(reset_brings_back_the_first_run_bit_for_bit)
{
    setup s;
    create_whole(&s);
    drive(&s, 200);
    const uint64_t first = hash_with_velocity(&s);
    assert_true(info_of(&s).elastic > 0.0);
    s.class->reset(s.model);
    s.time = 0.0;
    const ss_model_info info = info_of(&s);
    assert_true(info.step == 0 && info.elastic == 0.0 && info.kinetic == 0.0 && info.work == 0.0);
    assert_true(hash_with_velocity(&s) != first);
    drive(&s, 200);
    assert_true(hash_with_velocity(&s) == first);
    setup_fini(&s);
}

/* No source where nothing is put in: its stiffness would be felt. */
TEST(a_load_of_nothing_changes_nothing)
{
    uint64_t hash[2];
    double cost_us[2];
    for (int has_load = 0; has_load < 2; ++has_load) {
        setup s;
        setup_whole(&s);
        ss_set3(s.load[0].force, 0.0, 0.0, 0.0);
        s.plan.load_count = has_load;
        create(&s);
        cost_us[has_load] = s.class->step_cost_us(&s.plan);
        drive(&s, 200);
        assert_true(info_of(&s).elastic > 0.0);
        hash[has_load] = hash_with_velocity(&s);
        setup_fini(&s);
    }
    assert_true(hash[0] == hash[1]);
    assert_near(cost_us[0], cost_us[1], 0.0);
}

TEST(the_number_of_threads_does_not_matter)
{
    uint64_t hash[3];
    static const int32_t threads[3] = {1, 2, 5};
    for (int k = 0; k < 3; ++k) {
        setup s;
        setup_whole(&s);
        s.plan.threads = threads[k];
        assert_int_equal(setup_create(&s), SOFTSIM_OK);
        drive(&s, 150);
        hash[k] = hash_with_velocity(&s);
        setup_fini(&s);
    }
    assert_true(hash[0] == hash[1] && hash[1] == hash[2]);
}

TEST(live_values_change_the_body_and_the_energy_balance_knows)
{
    setup s;
    create_whole(&s);
    drive(&s, 100);
    const double before = s.model->tools.tool[0].force[2];
    s.class->set(s.model, SS_CNN_PRETENSION_J, 0.4);
    s.class->set(s.model, SS_CNN_MODULUS_J, -3.0); /* refused */
    s.class->set(s.model, SS_CNN_RHO, 7.0);        /* not live */
    s.class->set(s.model, SS_CNN_MODULUS_PA, 3.0); /* of volumes */
    assert_true(s.model->material.modulus == 5.0);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    tool[0].from = tool[0].to = s.model->tools.tool[0].pose;
    for (int k = 0; k < 200; ++k) {
        s.class->step(s.model, s.time, 1e-3, tool);
    }
    assert_true(s.model->tools.tool[0].force[2] > 1.3 * before);
    const ss_model_info info = info_of(&s);
    assert_true(fabs(info.elastic + info.kinetic - info.work + info.dissipated) <
                0.02 * info.elastic);
    setup_fini(&s);
}

/* ---- kernels ---- */

TEST(all_simd_paths_agree)
{
    setup s;
    create_whole(&s);
    drive(&s, 40);
    const ss_model *m = s.model;
    const ss_cnn_network *network = m->network;
    const ss_cnn_source *source = &m->tool[0].source;
    const size_t quads = (size_t)m->node_count * 4;
    const double tolerance = sizeof(ss_real) == sizeof(float) ? 2e-6 : 1e-14;
    ss_real *r[2] = {ss_memory_get(quads, sizeof(ss_real)), ss_memory_get(quads, sizeof(ss_real))};
    double ub[2] = {0.0, 0.0}, ur[2] = {0.0, 0.0}, scale = 0.0;
    int paths = 0;
    for (; paths < 2 && ss_cnn_kernels_path(paths); ++paths) {
        ss_cnn_kernels_path(paths)->product(&network->rows, &m->whole, source->kap, source->b, m->u,
                                            r[paths], &ub[paths], &ur[paths]);
    }
    for (size_t k = 0; k < quads; ++k) {
        scale = fmax(scale, fabs((double)r[0][k]));
    }
    for (size_t k = 0; paths == 2 && k < quads; ++k) {
        assert_true(fabs((double)r[0][k] - (double)r[1][k]) <= tolerance * scale);
    }
    if (paths == 2) {
        assert_true(fabs(ub[0] - ub[1]) <= 4.0 * tolerance * fabs(ub[0]));
        assert_true(fabs(ur[0] - ur[1]) <= 4.0 * tolerance * fabs(ur[0]));
    }
    /* And with the plainest sum there is. */
    double plain[3] = {0.0, 0.0, 0.0};
    const int32_t node = network->rows.node[0];
    int32_t degree = network->rows.group[0].degree;
    for (int32_t e = 0; e < degree; ++e) {
        const double kap = (double)source->kap_edge[network->rows.edge[e]];
        for (int k = 0; k < 3; ++k) {
            plain[k] += kap * ((double)network->rows.arm[4 * e + k] + (double)m->u[node + k] -
                               (double)m->u[network->rows.neighbour[e] + k]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        assert_true(fabs(plain[k] - (double)r[0][node + k]) <= tolerance * scale);
    }
    ss_memory_free(r[0]);
    ss_memory_free(r[1]);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
