/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Scenes: what a good one gives. */
#include "common/test.h"
#include "scene_fixture.h"

#include "rt/vec.h"

/* ---- good scenes ---- */

TEST(friction_is_a_number_or_a_value_a_node)
{
    ss_scene *s = load_good(full, NULL, 0);
    assert_near(s->friction.number, 0.0, 0.0);
    assert_null(s->friction.per_node);
    ss_scene_destroy(&s);
    s = load_good(full, (const char *const[]){"contact.friction=0.25"}, 1);
    assert_near(s->friction.number, 0.25, 0.0);
    assert_null(s->friction.per_node);
    ss_scene_destroy(&s);
    s = load_good(full,
                  (const char *const[]){
                      "contact.friction=[{where: {group: top}, value: 0.5}, {value: 0.125}]"},
                  1);
    static const double friction[8] = {0.125, 0.125, 0.125, 0.125, 0.5, 0.5, 0.5, 0.5};
    assert_memory_equal(s->friction.per_node, friction, sizeof friction);
    ss_scene_destroy(&s);
}

TEST(gives_every_value_of_a_scene)
{
    ss_scene *s = load_good(full, NULL, 0);
    assert_string_equal(s->model_name, "jelly");
    assert_int_equal(s->model_index, 0);
    assert_int_equal(s->mesh->node_count, 8);
    /* Node 1 at (20, 0, 0) mm: twice, turned about z, shifted. */
    assert_near(s->mesh->position[1][0], 0.1, 1e-15);
    assert_near(s->mesh->position[1][1], 0.04, 1e-15);
    static const uint8_t fixed[8] = {7, 7, 7, 7, 0, 0, 0, 5};
    assert_memory_equal(s->fixed, fixed, 8);

    assert_near(s->param[MODULUS].number, 5, 0);
    assert_true(s->param[MODULUS].is_given);
    assert_near(s->param[RHO].per_node[0], 0.5, 0);
    assert_near(s->param[RHO].per_node[7], 2, 0);
    assert_near(s->param[CELLS].number, 7, 0);
    assert_false(s->param[CELLS].is_given);
    assert_near(s->param[PER_AREA].number, 0, 0);
    assert_near(s->param[SOLVER].number, 1, 0);
    assert_true(isnan(s->param[SATURATION].number));
    assert_near(s->param[DAMPING].number, 1725, 0);

    assert_true(s->tool[0].is_used && !s->tool[1].is_used && s->tool[3].is_used);
    assert_int_equal(s->tool[0].shape.kind, SS_SHAPE_SPHERE);
    assert_near(s->tool[0].shape.radius, 5e-3, 1e-18);
    assert_int_equal(s->tool[3].shape.kind, SS_SHAPE_CAPSULE);
    assert_near(s->tool[3].shape.half_length, 15e-3, 1e-17);
    assert_int_equal(s->tool[4].shape.kind, SS_SHAPE_BOX);
    assert_near(s->tool[4].shape.half_extent[2], 3e-3, 1e-18);
    assert_int_equal(s->tool[5].shape.kind, SS_SHAPE_CYLINDER);
    assert_int_equal(s->tool[6].shape.kind, SS_SHAPE_CONE);
    assert_near(s->tool[6].shape.half_length, 5e-3, 1e-18);

    assert_near(s->working_force_n, 1.5, 0);
    assert_near(s->grasp_max_force_n, 2.5, 0);
    assert_near(s->contact_stiffness_n_per_m3, 0, 0);
    assert_near(s->simulation_rate_hz, 250, 0);
    assert_int_equal(s->max_substeps, 16);
    assert_near(s->gravity[2], -9.81, 0);
    assert_int_equal(s->between_steps, SS_SCENE_HOLD);
    assert_near(s->haptic_rate_hz, 2000, 0);
    assert_near(s->max_force_n, 4, 0);
    assert_near(s->max_slew_n_per_s, 900, 0);
    assert_near(s->max_jump_m, 0.1, 0);
    assert_near(s->coupling_stiffness_n_per_m, 500, 0);
    assert_near(s->coupling_damping_n_s_per_m, 1, 0);
    assert_near(s->mesh_rate_hz, 0, 0);
    assert_near(s->max_bytes_per_s, 1e6, 0);

    assert_int_equal(s->load_count, 2);
    assert_int_equal(s->load[0].node_count, 2);
    assert_int_equal(s->load[0].node[1], 5);
    assert_near(s->load[0].force[1], -0.8, 0);
    assert_near(s->load[0].from, 1, 0);
    assert_near(s->load[0].to, 10, 0);
    assert_near(s->load[0].ramp, 2, 0);
    assert_true(s->load[1].is_pressure);
    assert_near(s->load[1].pressure, 1000, 0);
    assert_true(isinf(s->load[1].to));
    assert_int_equal(s->load[1].node_count, 4);

    assert_int_equal(s->prescribed_count, 1);
    assert_false(s->prescribed[0].axis[0]);
    assert_true(s->prescribed[0].axis[2]);
    assert_near(s->prescribed[0].displacement[0][2], 0.001, 0);
    assert_near(s->prescribed[0].ramp, 0.5, 0);
    assert_string_equal(s->prescribed[0].name, "prescribed.0");
    ss_scene_destroy(&s);
    assert_null(s);
}

TEST(has_the_documented_defaults)
{
    ss_scene *s = load_good(replace_line(12, "  rate_hz: 1000"), NULL, 0);
    assert_near(s->max_force_n, 8, 0);
    assert_near(s->max_slew_n_per_s, 2000, 0);
    assert_near(s->coupling_stiffness_n_per_m, 800, 0);
    assert_near(s->coupling_damping_n_s_per_m, 2, 0);
    assert_near(s->max_jump_m, 0.05, 0);
    assert_int_equal(s->between_steps, SS_SCENE_LOCAL);
    assert_near(s->simulation_rate_hz, 0, 0);
    assert_int_equal(s->max_substeps, 64);
    assert_near(s->working_force_n, 2, 0);
    assert_true(isnan(s->grasp_max_force_n));
    assert_near(s->mesh_rate_hz, 60, 0);
    assert_near(s->max_bytes_per_s, 8e6, 0);
    assert_near(s->gravity[2], 0, 0);
    ss_scene_destroy(&s);
}

TEST(millimetres_and_metres_give_the_same_body)
{
    ss_scene *mm = load_good(small, NULL, 0);
    const char *const overrides[] = {"object.mesh=cube_m.msh", "object.units=m"};
    ss_scene *m = load_good(small, overrides, 2);
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) {
            assert_near(mm->mesh->position[i][k], m->mesh->position[i][k], 1e-17);
        }
    }
    assert_memory_equal(mm->fixed, m->fixed, 8);
    ss_scene_destroy(&mm);
    ss_scene_destroy(&m);
}

/* Regions with the border through nodes, in a body of awkward size. */
TEST(regions_take_the_nodes_on_their_border)
{
    static const struct {
        const char *region;
        int count;
    } row[] = {
        {"{box_m: [[0, 0, 0.006], [0.006, 0.006, 0.006]]}", 4},
        {"{sphere: {center_m: [0, 0, 0], radius_m: 0.006}}", 4},
        {"{plane: {point_m: [0, 0, 0.006], normal: [0, 0, -5]}}", 4},
        {"{plane: {point_m: [0.003, 0, 0], normal: [1, 0, 0]}}", 4},
        {"{group: top}", 4},
        {"{nodes: [3]}", 1},
        {"{nodes: seven.txt}", 1},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char line[160];
        snprintf(line, sizeof line, "  transform: {scale: 0.3}\n  fixed: [%s]", row[i].region);
        ss_scene *s = load_good(replace_line(5, line), NULL, 0);
        int count = 0;
        for (int k = 0; k < 8; k++) {
            count += s->fixed[k] == 7;
        }
        assert_int_equal(count, row[i].count);
        ss_scene_destroy(&s);
    }
}

TEST(the_first_matching_region_gives_the_value)
{
    ss_scene *s = load_good(replace_line(8, "  modulus_j: 5\n  rho:\n"
                                            "    - {where: {nodes: [7]}, value: 3}\n"
                                            "    - {where: {group: top}, value: 2}\n"
                                            "    - {value: 1}"),
                            NULL, 0);
    static const double rho[8] = {1, 1, 1, 1, 2, 2, 2, 3};
    assert_memory_equal(s->param[RHO].per_node, rho, sizeof rho);
    ss_scene_destroy(&s);
    s = load_good(replace_line(8, "  modulus_j: 5\n  rho: {file: rho.csv}"), NULL, 0);
    for (int k = 0; k < 8; k++) {
        assert_near(s->param[RHO].per_node[k], k + 1, 0);
    }
    ss_scene_destroy(&s);
}

TEST(values_by_link_are_read_and_renumbered)
{
    write_text("links.csv", "node,node,value\n0,1,0.5\n# a note\n7, 2, 0.25\n0,3,1\n");
    ss_scene *s = load_good(replace_line(8, "  modulus_j: 5\n  rho: {file: links.csv}"), NULL, 0);
    const ss_param_value *rho = &s->param[RHO];
    assert_null(rho->per_node);
    assert_int_equal(rho->link_count, 3);
    assert_int_equal(rho->per_link[1].node[0], 7);
    assert_int_equal(rho->per_link[1].node[1], 2);
    assert_near(rho->per_link[1].value, 0.25, 0);
    assert_true(ss_scene_renumber(s));
    const int32_t *node = s->param[RHO].per_link[1].node;
    assert_int_equal(ss_mesh_file_node(s->mesh, node[0]), 7);
    assert_int_equal(ss_mesh_file_node(s->mesh, node[1]), 2);
    ss_scene_destroy(&s);
}

TEST(an_empty_cell_leaves_its_axis_free)
{
    ss_scene *s =
        load_good(replace_line(13, "prescribed: [{displacement_file: lift.csv, group: top}]\n"
                                   "loads:"),
                  NULL, 0);
    assert_int_equal(s->prescribed_count, 2);
    const ss_scene_prescribed *partial = &s->prescribed[0]; /* bits in increasing order */
    const ss_scene_prescribed *whole = &s->prescribed[1];
    assert_int_equal(whole->node_count, 2);
    assert_true(whole->axis[0] && whole->axis[1] && whole->axis[2]);
    assert_near(whole->displacement[1][2], 0.002, 0);
    assert_int_equal(partial->node_count, 1);
    assert_int_equal(partial->node[0], 6);
    assert_true(!partial->axis[0] && !partial->axis[1] && partial->axis[2]);
    assert_near(partial->displacement[0][2], 0.003, 0);
    assert_int_equal(partial->entry, whole->entry);
    assert_string_equal(partial->name, "top");
    ss_scene_destroy(&s);
}

/* ---- repair ---- */

/* A tetrahedron's surface with a corner twice, one face twice, one face turned and a loose node. */
TEST(a_mesh_is_mended_where_the_scene_asks_for_it)
{
    write_text("broken.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 5 5 5\n2 0 0 0\n"
                             "3 1 0 0\n4 0 1 0\n5 0 0 1\n6 0 0 1\n$EndNodes\n$Elements\n5\n"
                             "1 2 0 2 4 3\n2 2 0 2 3 5\n3 2 0 2 3 6\n4 2 0 3 4 6\n5 2 0 2 4 5\n"
                             "$EndElements\n");
    static const char text[] = "softsim: 1\nobject:\n  mesh: broken.msh\n  units: m\n"
                               "  repair: true\nmodel: {name: jelly, modulus_j: 1}\n";
    assert_null(load_with(text, (const char *const[]){"object.repair=false"}, 1));
    assert_non_null(strstr(error.text, "broken.msh"));
    ss_scene *s = load_good(text, NULL, 0);
    assert_int_equal(s->mesh->node_count, 4);
    assert_int_equal(s->mesh->triangle_count, 4);
    assert_true(s->mesh->is_closed);
    assert_int_equal(s->repairs.welded_node.count, 1);
    assert_int_equal(s->repairs.twin_element.count, 1);
    assert_int_equal(s->repairs.loose_node.count, 1);
    assert_int_equal(s->repairs.turned_triangle.count, 1);
    ss_scene_destroy(&s);
}

/* ---- grids ---- */

TEST(a_grid_is_made_in_the_scene_itself)
{
    ss_scene *s =
        load_good(GRID("  grid: {cylinder: {rows: 15, columns: 24, radius_m: 1, length_m: 4}}\n"
                       "  fixed: [{plane: {point_m: [0, 0, -2], normal: [0, 0, 1]}}]\n"),
                  NULL, 0);
    assert_int_equal(s->mesh->node_count, 360);
    assert_int_equal(s->mesh->quad_count, 14 * 24);
    assert_int_equal(s->mesh->triangle_count, 2 * 14 * 24);
    for (int i = 0; i < 360; i++) {
        const double phi = 2 * SS_PI * (i % 24) / 24;
        assert_near(s->mesh->position[i][0], cos(phi), 1e-15);
        assert_near(s->mesh->position[i][1], sin(phi), 1e-15);
        assert_near(s->mesh->position[i][2], 4.0 / 14 * (i / 24) - 2, 1e-14);
        assert_int_equal(s->fixed[i], i < 24 ? 7 : 0);
    }
    ss_scene_destroy(&s);

    /* A transform acts on it; a unit beside it means nothing, and does no harm. */
    s = load_good(
        GRID("  grid: {plane: {rows: 3, columns: 4, width_m: 3, height_m: 2}}\n  units: mm\n"
             "  transform: {scale: 2, translate_m: [0, 0, 1]}\n"),
        NULL, 0);
    assert_int_equal(s->mesh->node_count, 12);
    assert_near(s->mesh->position[11][0], 3, 1e-15);
    assert_near(s->mesh->position[11][1], 2, 1e-15);
    assert_near(s->mesh->position[11][2], 1, 1e-15);
    ss_scene_destroy(&s);
}

TEST(a_grid_of_a_table_has_its_units_and_closes_where_told)
{
    FILE *stream = open_file("ring.csv");
    fprintf(stream, "x,y,z\n");
    for (int i = 0; i < 20; i++) {
        const double phi = 2 * SS_PI * (i % 5) / 5;
        fprintf(stream, "%.17g,%.17g,%d\n", 10 * cos(phi), 10 * sin(phi), 5 * (i / 5));
    }
    fclose(stream);
    static const struct {
        const char *closed;
        int32_t quads;
    } row[] = {{"", 12}, {", closed: none", 12}, {", closed: columns", 15}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char text[256];
        snprintf(text, sizeof text,
                 GRID("  units: mm\n  grid: {file: ring.csv, rows: 4, columns: 5%s}\n"),
                 row[i].closed);
        ss_scene *s = load_good(text, NULL, 0);
        assert_int_equal(s->mesh->quad_count, row[i].quads);
        assert_near(s->mesh->position[19][2], 0.015, 1e-17);
        assert_near(s->mesh->position[0][0], 0.01, 1e-17);
        ss_scene_destroy(&s);
    }
    ss_scene *s =
        load_good(replace_line(3, "  grid: {file: points.csv, rows: 3, columns: 2, closed: none}"),
                  (const char *const[]){"loads.0.nodes=[5]"}, 1);
    assert_near(s->mesh->position[5][1], 0.04, 1e-17);
    ss_scene_destroy(&s);
}

/* ---- directions ---- */

TEST(a_direction_is_normalised_whatever_its_length)
{
    static const struct {
        const char *text;
        double v[3];
    } row[] = {
        {"[0, 0, 1]", {0, 0, 1}},
        {"[3, 0, -4]", {0.6, 0, -0.8}},
        {"[1e-300, 0, 1e-300]", {0.70710678118654752, 0, 0.70710678118654752}},
        {"[-1.0e+308, 1.0e+308, 1.0e+308]",
         {-0.57735026918962576, 0.57735026918962576, 0.57735026918962576}},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char line[120];
        snprintf(line, sizeof line, "  modulus_j: 5\n  grain: %s", row[i].text);
        ss_scene *s = load_good(replace_line(8, line), NULL, 0);
        assert_true(s->param[GRAIN].is_given);
        assert_null(s->param[GRAIN].per_element);
        for (int k = 0; k < 3; k++) {
            assert_near(s->param[GRAIN].direction[k], row[i].v[k], 1e-15);
        }
        ss_scene_destroy(&s);
    }
    ss_scene *s = load_good(small, (const char *const[]){"model.grain=[0, 2, 0]"}, 1);
    assert_near(s->param[GRAIN].direction[1], 1, 0);
    ss_scene_destroy(&s);
    s = load_good(small, NULL, 0);
    assert_false(s->param[GRAIN].is_given);
    assert_near(s->param[GRAIN].direction[0], 0, 0);
    ss_scene_destroy(&s);
}

TEST(directions_by_file_are_of_quads_or_triangles_or_tetrahedra)
{
    write_directions("grain_12.csv", 12);
    write_directions("grain_6.csv", 6);
    write_directions("grain_1.csv", 1);
    write_text("tet.msh",
               "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n"
               "3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n");
    static const struct {
        const char *object;
        int count;
    } row[] = {
        {"mesh: cube.msh, units: mm", 12},
        {"grid: {plane: {rows: 3, columns: 4, width_m: 0.3, height_m: 2}}", 6},
        {"mesh: tet.msh, units: mm", 1},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char text[320];
        snprintf(text, sizeof text,
                 "softsim: 1\nobject: {%s}\n"
                 "model: {name: jelly, modulus_j: 1, grain: {file: grain_%d.csv}}\n",
                 row[i].object, row[i].count);
        ss_scene *s = load_good(text, NULL, 0);
        assert_int_equal(ss_mesh_element_count(s->mesh), row[i].count);
        assert_non_null(s->param[GRAIN].per_element);
        for (int e = 0; e < row[i].count; e++) {
            assert_near(s->param[GRAIN].per_element[e][0], e / sqrt(e * e + 4.0), 1e-15);
            assert_near(s->param[GRAIN].per_element[e][2], 2 / sqrt(e * e + 4.0), 1e-15);
        }
        ss_scene_destroy(&s);
    }
}

/* ---- the bundled scenes ---- */

/* The keys of the model that the bundled scenes use; their values are the model's own business. */
#define KEY(key, usual) SS_PARAM(FIELD, key, "see the model", SS_FROM(0, 1e9), .fallback = (usual))
static const ss_param_row energy_row[] = {
    KEY("modulus_j", NAN),
    KEY("modulus_n_per_m", NAN),
    KEY("pretension_j", 0),
    KEY("enclosed_bulk_pa", 0),
    KEY("rho", 1),
    SS_PARAM(BOOL, "per_area", "per area", SS_FROM(0, 1), .fallback = 1),
    KEY("area_density_kg_m2", NAN),
    KEY("damping_n_s_per_m3", NAN),
    KEY("rest_stiffness_n_per_m3", NAN),
    KEY("mass_kg", NAN),
    KEY("damping_n_s_per_m", NAN),
    KEY("rest_stiffness_n_per_m", NAN),
};
static const ss_scene_model energy = {
    .name = "cnn-energy", .row = energy_row, .row_count = sizeof energy_row / sizeof *energy_row};

static ss_scene *load_bundled(const char *name)
{
    char path[1024];
    ss_scene *scene = NULL;
    snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s", name);
    error = (softsim_error){0};
    ss_scene_load(path, NULL, 0, &energy, 1, BIN_DIR "/softsim-import", &scene, &error);
    if (scene == NULL) {
        fail_msg("%s", error.text);
    }
    return scene;
}

TEST(the_bundled_scenes_hold_what_they_should)
{
    if (access(BIN_DIR "/softsim-import", X_OK) != 0) {
        skip(); /* its meshes are read through that program */
    }
    ss_scene *s = load_bundled("kidney.yaml");
    int count = 0;
    for (int32_t i = 0; i < s->mesh->node_count; i++) {
        /* The hilum: the middle of the side towards -y. */
        const double *x = s->mesh->position[i];
        count += s->fixed[i] != 0;
        assert_true(s->fixed[i] == 0 || (x[1] < -0.014 && fabs(x[0]) < 0.016));
    }
    assert_in_range(count, s->mesh->node_count / 25, s->mesh->node_count / 12);
    assert_true(s->mesh->is_closed);
    assert_true(s->tool[0].is_used && s->tool[1].is_used && !s->tool[2].is_used);
    assert_near(s->tool[1].shape.radius, 0.006, 1e-17);
    ss_scene_destroy(&s);

    s = load_bundled("liver.yaml");
    count = 0;
    for (int32_t i = 0; i < s->mesh->node_count; i++) {
        count += s->fixed[i] != 0;
        assert_true(s->fixed[i] == 0 || s->mesh->position[i][1] > 0.03);
    }
    assert_in_range(count, s->mesh->node_count / 25, s->mesh->node_count / 12);
    assert_true(s->mesh->is_closed);
    ss_scene_destroy(&s);

    static const char *const cylinders[] = {"cylinder.yaml", "cylinder-grid.yaml"};
    for (int k = 0; k < 2; k++) {
        s = load_bundled(cylinders[k]);
        assert_int_equal(s->mesh->node_count, 360);
        assert_int_equal(s->mesh->quad_count, k == 1 ? 336 : 0);
        for (int32_t i = 0; i < 360; i++) {
            assert_int_equal(s->fixed[i], fabs(s->mesh->position[i][2]) > 1.99 ? 7 : 0);
        }
        assert_int_equal(s->load_count, 1);
        const double *top = s->mesh->position[s->load[0].node[0]];
        assert_near(top[0], 0, 1e-6);
        assert_near(top[1], 1, 1e-6);
        assert_near(top[2], 0, 1e-6);
        ss_scene_destroy(&s);
    }
}

/* ---- lists by region ---- */

/* The cube's upper four nodes are the group top; nodes 0 to 3 are the others. */
TEST(a_value_that_no_node_takes_is_noted_and_so_is_an_overlap)
{
    static const struct {
        const char *list;
        int count;
        bool is_unused;
        const char *where, *says;
    } cases[] = {
        {"[{where: {group: top}, value: 0.5}, {value: 0.1}]", 0, false, "", ""},
        {"[{where: {group: top}, value: 0.5}, {where: {nodes: [7, 6]}, value: 0.3}, {value: 0.1}]",
         1, true, "contact.friction.1", "earlier entries took all 2 that it names"},
        {"[{where: {group: top}, value: 0.5}, {where: {nodes: [0, 6, 7]}, value: 0.3}, {value: "
         "0.1}]",
         1, false, "contact.friction.1", "2 of its 3 nodes have the value of an earlier entry"},
        {"[{where: {group: top}, value: 0.5}, {where: {nodes: [0, 1, 2, 3]}, value: 0.3}, {value: "
         "0.1}]",
         1, true, "contact.friction.2", "earlier entries took all 8"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char override[256];
        snprintf(override, sizeof override, "contact.friction=%s", cases[i].list);
        ss_scene *s = load_good(small, (const char *const[]){override}, 1);
        assert_int_equal(s->doubt_count, cases[i].count);
        if (cases[i].count > 0) {
            assert_int_equal(s->doubt[0].is_unused, cases[i].is_unused);
            assert_string_equal(s->doubt[0].where, cases[i].where);
            assert_non_null(strstr(s->doubt[0].text, cases[i].says));
        }
        ss_scene_destroy(&s);
    }
}

int main(void)
{
    return run_all_tests(make_files, remove_folder);
}
