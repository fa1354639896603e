/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Bad scenes: what is said, and where. */
#include "common/test.h"
#include "scene_fixture.h"

typedef struct bad {
    int line;          /* of `small` that is replaced */
    const char *with;  /* by this */
    const char *place; /* line:column of the fault */
    const char *word;  /* of its message */
} bad;

static const bad bad_row[] = {
    {1, "softsim: 2", "1:10", "out of range"},
    {1, "", "2:1", "softsim is missing"},
    {1, "softsim: one", "1:10", "not a number"},
    {1, "softsim: 1\ncolour: red", "2:1", "unknown key 'colour'"},
    {1, "softsim: 1\nhapticc: {}", "2:1", "did you mean 'haptic'?"},
    {1, "softsim: 1\nsimulation:", "2:1", "has no value"},
    {1, "softsim: 1\ngravity_m_s2: [0, 0]", "2:15", "has 2 values"},
    {1, "softsim: 1\ngravity_m_s2: [0, 0, down]", "2:22", "not a number"},
    {1, "softsim: 1\nsimulation: {rate_hz: fast}", "2:23", "auto"},
    {1, "softsim: 1\nsimulation: {max_substeps: 1.5}", "2:28", "whole number"},
    {1, "softsim: 1\nsoftsim: 1", "2:1", "given twice, first in line 1"},
    {1, "softsim: &a 1", "1:13", "anchors"},
    {1, "softsim: !!int 1", "1:16", "tag"},
    {3, "  mesh: *a", "3:10", "aliases"},
    {3, "  mesh: none.obj", "3:9", "No such file"},
    {3, "  mesh: .", "3:9", "not a file"},
    {3, "  mesh: [cube.msh]", "3:9", "is a list"},
    {3, "", "2:1", "object needs one of: mesh, grid"},
    {3, "  mesh: cube.msh\n  grid: {plane: {rows: 2, columns: 2, width_m: 1, height_m: 1}}", "4:3",
     "object takes one of: mesh, grid"},
    {3, "  grid: {}", "3:3", "needs one of: cylinder, plane, file"},
    {3,
     "  grid: {file: p.csv, plane: {rows: 2, columns: 2, width_m: 1, height_m: 1}, rows: 2, "
     "columns: 2}",
     "3:23", "remove 'plane' or 'file'"},
    {3, "  grid: {plane: {rows: 1, columns: 2, width_m: 1, height_m: 1}}", "3:24", "from 2 to"},
    {3, "  grid: {plane: {rows: 2, columns: 2, width_m: 1}}", "3:10", "height_m is missing"},
    {3, "  grid: {plane: {rows: 2000, columns: 501, width_m: 1, height_m: 1}}", "3:18",
     "at most 1000000 nodes"},
    {3, "  grid: {cylinder: {rows: 2, columns: 2, radius_m: 1, length_m: 1}}", "3:39", "from 3 to"},
    {3, "  grid: {cylinder: {rows: 2, columns: 3, radius_m: 0, length_m: 1}}", "3:52", "above 0"},
    {3, "  grid: {cylinder: {rows: 2, around: 3, radius_m: 1, length_m: 1, columns: 3}}", "3:30",
     "unknown key 'around'"},
    {3, "  grid: {plane: {rows: 2, columns: 2, width_m: 1, height_m: 1}, closed: rows}", "3:65",
     "'closed' goes with 'file'"},
    {3, "  grid: {file: points.csv, columns: 3}", "3:3", "object.grid.rows is missing"},
    {3, "  grid: {file: points.csv, rows: 3, columns: 2, closed: all}", "3:57",
     "none rows columns"},
    {3, "  grid: {file: points.csv, rows: 3, columns: 2, closed: columns}", "3:28",
     "at least 3 of"},
    {3, "  grid: {file: lost.csv, rows: 3, columns: 2}", "3:16", "cannot open 'lost.csv'"},
    {4, "", "2:1", "object.units is missing"},
    {4, "  units: miles", "4:10", "one of mm cm m in um dm"},
    {4, "  units: mm\n  shell: {}", "5:3", "unknown key 'shell'"},
    {4, "  units: mm\n  surface: cube.msh", "5:12", "what curved edges follow"},
    {4, "  units: mm\n  transform: {scale: 0}", "5:22", "above 0"},
    {5, "  fixed: [{box_m: [[-1, -1, -1], [1, 1, -0.001]]}]", "5:12", "takes no node"},
    {5, "  fixed: [{box_m: [[1, -1, -1], [-1, 1, 0]]}]", "5:19", "wrong way round"},
    {5, "  fixed: [{box_m: [[0, 0, 0]]}]", "5:19", "two corners"},
    {5, "  fixed: [{axes: xy}]", "5:11", "needs one of: box_m"},
    {5, "  fixed: [{group: top, nodes: [1]}]", "5:24", "remove 'group' or 'nodes'"},
    {5, "  fixed: [{group: bottom}]", "5:19", "it has: top, rest"},
    {5, "  fixed: [{nodes: [8]}]", "5:20", "nodes 0 to 7"},
    {5, "  fixed: [{nodes: [1, 1]}]", "5:23", "twice"},
    {5, "  fixed: [{nodes: []}]", "5:19", "empty list"},
    {5, "  fixed: [{nodes: none.txt}]", "5:12", "the file names none"},
    {5, "  fixed: [{nodes: lost.txt}]", "5:19", "cannot open 'lost.txt'"},
    {5, "  fixed: [{nodes: [1], axes: xw}]", "5:30", "xyz"},
    {5, "  fixed: [{plane: {point_m: [0, 0, 0], normal: [0, 0, 0]}}]", "5:48", "no length"},
    {5, "  fixed: {nodes: [1]}", "5:10", "is a mapping; give a list"},
    {5, "  fixed: [7]", "5:11", "is a single value"},
    {2, "obiect:", "2:1", "did you mean 'object'?"},
    {7, "", "6:1", "model.name is missing; built in: jelly, block"},
    {7, "  name: jely", "7:9", "did you mean 'jelly'?"},
    {8, "", "6:1", "model.modulus_j is missing"},
    {8, "  modulus_j: 0", "8:14", "above 0"},
    {8, "  modulus_j: .nan", "8:14", "not finite"},
    {8, "  modulus_j: 1e999", "8:14", "not finite"},
    {8, "  modulus_j: 0x10", "8:14", "not a number"},
    {8, "  modulus_j: 5 N", "8:14", "not a number"},
    {8, "  modulus_j: '5'", "8:15", "in quotes"},
    {8, "  modulus: 5\n  modulus_j: 1", "8:3", "did you mean 'modulus_j'?"},
    {8, "  modulus_j: 5\n  per_area: yes", "9:13", "true or false"},
    {8, "  modulus_j: 5\n  solver: magic", "9:11", "equilibrium"},
    {8, "  modulus_j: 5\n  rho: {file: short.csv}", "9:15", "no value to 6 nodes"},
    {8, "  modulus_j: 5\n  rho: [{where: {group: top}, value: 2}]", "9:8", "{value: ...}"},
    {8, "  modulus_j: 5\n  rho: [{value: 2}, {where: {group: top}, value: 1}]", "9:9", "last"},
    {8, "  modulus_j: 5\n  rho: [{value: 20}]", "9:17", "out of range"},
    {8, "  modulus_j: 5\n  grain: [0, 0, 0]", "9:10", "has no length"},
    {8, "  modulus_j: 5\n  grain: [0, 1]", "9:10", "has 2 values"},
    {8, "  modulus_j: 5\n  grain: 3", "9:10", "is a single value; give [x, y, z] of any length"},
    {8, "  modulus_j: 5\n  grain: [0, .inf, 1]", "9:14", "not finite"},
    {8, "  modulus_j: 5\n  grain: {fil: a.csv}", "9:11", "did you mean 'file'?"},
    {8, "  modulus_j: 5\n  grain: {file: lost.csv}", "9:17", "cannot open 'lost.csv'"},
    {8, "  modulus_j: 5\n  grain: {file: grain_short.csv}", "9:17",
     "no value to 10 elements, the first is 1"},
    {10, "  tools: [{probe: 8, shape: {sphere: {radius_mm: 5}}}]", "10:19", "from 0 to 7"},
    {10, "  tools: [{probe: 1, shape: {sphere: {radius_m: 5}}}]", "10:39", "radius_mm"},
    {10, "  tools: [{probe: 1, shape: {ball: {}}}]", "10:30", "known here: sphere, capsule"},
    {10, "  tools: [{probe: 1, shape: {box: {size_mm: [1, 0, 1]}}}]", "10:49", "above 0"},
    {10, "  tools: [{probe: 1, shape: {cone: {radius_mm: 1}}}]", "10:30", "length_mm is missing"},
    {10, "  tools: [{probe: 1, shape: {convex: {file: no.obj}}}]", "10:45", "cannot open"},
    {10, "  tools: [{probe: 1, shape: {convex: {file: flat.off}}}]", "10:45",
     "4 to 2048 triangles"},
    {10,
     "  tools:\n    - {probe: 1, shape: {sphere: {radius_mm: 5}}}\n"
     "    - {probe: 1, shape: {sphere: {radius_mm: 5}}}",
     "12:15", "has a tool already"},
    {10, "  working_force_n: 1\n  stiffness_n_per_m3: 1e9", "11:3", "takes one of"},
    {10, "  grasp_max_force_n: -1", "10:22", "above 0"},
    {10, "  grasp_max_force_n: 0", "10:22", "above 0"},
    {10, "  grasp_max_force_n: .nan", "10:22", "not finite"},
    {10, "  grasp_max_force_n: .inf", "10:22", "not finite"},
    {10, "  grasp_max_force_n: hard", "10:22", "not a number"},
    {10, "  friction: -0.1", "10:13", "from 0 to 10"},
    {10, "  friction: 10.5", "10:13", "from 0 to 10"},
    {10, "  friction: .nan", "10:13", "not finite"},
    {10, "  friction: rough", "10:13", "not a number"},
    {10, "  friction: [{where: {group: left}, value: 1}, {value: 0}]", "10:30",
     "it has: top, rest"},
    {10, "  friction: [{where: {group: top}, value: 1}]", "10:13", "{value: ...}"},
    {10, "  friction: [{value: -1}]", "10:22", "from 0 to 10"},
    {12, "  max_force_n: 300", "12:16", "from 0.01 to 100 (N)"},
    {12, "  max_forc_n: 3", "12:3", "did you mean 'max_force_n'?"},
    {12, "  max_force_n: [3]", "12:16", "is a list"},
    {12, "  between_steps: guess", "12:18", "hold linear local"},
    {12, "  coupling: 800", "12:13", "is a single value"},
    {14, "  - {nodes: [7]}", "14:5", "needs one of: force_n, pressure_pa"},
    {14, "  - {nodes: [7], force_n: [0, 0, 1], from_s: 2, to_s: 1}", "14:55", "before it begins"},
    {14, "  - {nodes: [7], pressure_pa: 10}", "14:18", "acts on nothing"},
    {13, "prescribed: [{displacement_m: [0, 0, 1]}]\nloads:", "13:14", "needs nodes"},
    {13, "prescribed: [{nodes: [0], displacement_m: [0, 0, 1]}]\nloads:", "13:14", "fixed already"},
    {13,
     "prescribed: [{displacement_file: lift.csv, nodes: [4]}]\n"
     "loads:",
     "13:34", "not in the region"},
    {2, "object: [1, 2", "4:8", "YAML"},
    {2, "object:\n\tmesh: a", "3:1", "YAML"},
    {14, "--- \nsecond: 1", "14:1", "second document"},
    {14, "%YAML 1.2", "14:1", "directives"},
    {14, "# \xff", "14:3", "byte 0xff is no text"},
    {14, "# \x1b[31m", "14:3", "byte 0x1b is no text"},
};

TEST(names_every_fault_with_its_place)
{
    int wrong = 0;
    for (size_t i = 0; i < sizeof bad_row / sizeof *bad_row; i++) {
        const bad *row = &bad_row[i];
        char place[300];
        ss_scene *scene = load_with(replace_line(row->line, row->with), NULL, 0);
        assert_null(scene);
        snprintf(place, sizeof place, "%s/s.yaml:%s: error: ", folder, row->place);
        if (strstr(error.text, place) == NULL || strstr(error.text, row->word) == NULL ||
            error.fault_count != 1) {
            print_error("'%s': expected one fault at %s with '%s', got %d:\n%s\n", row->with,
                        row->place, row->word, (int)error.fault_count, error.text);
            wrong++;
        }
    }
    assert_int_equal(wrong, 0);
}

TEST(a_model_that_is_missing_or_needs_a_volume_is_named)
{
    assert_null(load_with("softsim: 1\nobject: {mesh: cube.msh, units: mm}\n", NULL, 0));
    assert_int_equal(error.fault_count, 1);
    assert_non_null(strstr(error.text, ":1:1: error: model is missing"));
    assert_null(load_with("softsim: 1\nobject: {mesh: cube.msh, units: mm}\nmodel: {name: block}\n",
                          NULL, 0));
    assert_int_equal(error.fault_count, 1);
    assert_non_null(strstr(error.text, ":2:16: error: block needs a volume"));
}

TEST(a_mesh_of_second_order_is_refused_by_models_without_such_elements)
{
    assert_null(load_with("softsim: 1\nobject: {mesh: ten.msh, units: mm}\nmodel: {name: block}\n",
                          NULL, 0));
    assert_int_equal(error.fault_count, 1);
    assert_non_null(strstr(error.text, ":2:16: error: block has no mid-edge nodes, and "
                                       "'ten.msh' is of second order; take fem-quadratic, or"));
    assert_non_null(strstr(error.text, "convert --order 1"));
    ss_scene *scene = load_with(
        "softsim: 1\nobject: {mesh: ten.msh, units: mm}\nmodel: {name: bubble}\n", NULL, 0);
    if (scene == NULL) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(scene->mesh->node_count, 10);
    ss_scene_destroy(&scene);
}

TEST(shows_the_line_and_a_caret)
{
    assert_null(load_with(replace_line(12, "  max_force_n: 300"), NULL, 0));
    assert_non_null(strstr(error.text, "\n  max_force_n: 300\n               ^~~"));
    /* Columns count characters, not bytes. */
    assert_null(load_with(replace_line(12, "  \xc3\xa4\xc3\xb6: 1"), NULL, 0));
    assert_non_null(strstr(error.text, "\n  \xc3\xa4\xc3\xb6: 1\n  ^~"));
}

TEST(faults_of_data_files_name_the_file_and_line)
{
    assert_null(load_with(replace_line(5, "  fixed: [{nodes: bad_nodes.txt}]"), NULL, 0));
    assert_int_equal(error.fault_count, 3);
    assert_non_null(strstr(error.text, "bad_nodes.txt:2: error: 'two' is not a node number"));
    assert_non_null(strstr(error.text, "bad_nodes.txt:3: error: there is no node 8"));
    assert_non_null(strstr(error.text, "bad_nodes.txt:4: error: node 1 is given twice"));
    assert_null(load_with(replace_line(8, "  modulus_j: 5\n  rho: {file: header.csv}"), NULL, 0));
    assert_non_null(strstr(error.text, "header.csv:1: error: the first line is 'element,value'"));
    assert_null(load_with(replace_line(8, "  modulus_j: 5\n  rho: {file: range.csv}"), NULL, 0));
    assert_non_null(strstr(error.text, "range.csv:3: error: the value is 11, out of range"));
    assert_non_null(strstr(error.text, "range.csv:4: error: the value is 'nan'"));
    write_text("links_bad.csv", "node,node,value\n2,2,1\n3,4\n5,6,11\n0,8,1\n");
    assert_null(
        load_with(replace_line(8, "  modulus_j: 5\n  rho: {file: links_bad.csv}"), NULL, 0));
    assert_int_equal(error.fault_count, 3); /* and no more of a file */
    assert_non_null(strstr(error.text, "links_bad.csv:2: error: node 2 is given twice"));
    assert_non_null(strstr(error.text, "links_bad.csv:3: error: not three cells"));
    assert_non_null(strstr(error.text, "links_bad.csv:4: error: the value is 11, out of range"));
    assert_null(
        load_with(replace_line(8, "  modulus_j: 5\n  grain: {file: grain_bad.csv}"), NULL, 0));
    assert_non_null(
        strstr(error.text, "grain_bad.csv:2: error: the direction of element 0 has no"));
    assert_non_null(
        strstr(error.text, "grain_bad.csv:3: error: there is no element 12; the mesh has"));
    assert_non_null(strstr(error.text, "grain_bad.csv:4: error: 'inf' is not a finite number"));
    assert_null(
        load_with(replace_line(8, "  modulus_j: 5\n  grain: {file: grain_twice.csv}"), NULL, 0));
    assert_non_null(strstr(error.text, "grain_twice.csv:2: error: '1.5' is not an element number"));
    assert_non_null(strstr(error.text, "grain_twice.csv:3: error: not four cells"));
    assert_non_null(strstr(error.text, "grain_twice.csv:5: error: element 3 is given twice"));
    assert_null(load_with(replace_line(8, "  modulus_j: 5\n  grain: {file: rho.csv}"), NULL, 0));
    assert_non_null(strstr(error.text, "rho.csv:1: error: the first line is 'node,value'"));
    static const says_row table[] = {
        {"points.csv, rows: 3, columns: 3", "points.csv:8: error: the file ends after 6 points"},
        {"points.csv, rows: 2, columns: 2", "points.csv:7: error: more points than the grid has"},
        {"points_bad.csv, rows: 2, columns: 2", "points_bad.csv:3: error: not a point"},
        {"points_bad.csv, rows: 2, columns: 2", "points_bad.csv:4: error: not a point"},
        {"points_bad.csv, rows: 2, columns: 2", "points_bad.csv:5: error: not a point"},
        {"rho.csv, rows: 2, columns: 4", "rho.csv:1: error: the first line is 'node,value'"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char line[120];
        snprintf(line, sizeof line, "  grid: {file: %s}", table[i].given);
        assert_null(load_with(replace_line(3, line), NULL, 0));
        if (strstr(error.text, table[i].says) == NULL) {
            fail_msg("no '%s' in:\n%s", table[i].says, error.text);
        }
    }
    assert_null(load_with("softsim: 1\nobject: {grid: {file: points.csv, rows: 3, columns: 2}}\n"
                          "model: {name: jelly, modulus_j: 1}\n",
                          NULL, 0));
    assert_int_equal(error.fault_count, 1);
    assert_non_null(strstr(error.text, ":2:17: error: object.units is missing"));
    /* A grid is no file: its faults are the scene's. */
    assert_null(load_with(
        replace_line(3, "  grid: {plane: {rows: 2, columns: 2, width_m: 1, height_m: 1e-5}}"), NULL,
        0));
    assert_non_null(strstr(error.text, ".yaml: object.grid: edges shorter than"));
    assert_null(load_with(
        replace_line(13, "prescribed: [{displacement_file: lift_bad.csv}]\nloads:"), NULL, 0));
    assert_non_null(strstr(error.text, "lift_bad.csv:2: error: not four cells"));
    assert_non_null(strstr(error.text, "lift_bad.csv:3: error: 'x' is not a displacement"));
}

TEST(reports_all_faults_in_one_go_and_in_order)
{
    assert_null(load_with("softsim: 1\n"
                          "object:\n"
                          "  mesh: cube.msh\n"
                          "  units: mm\n"
                          "  fixed: [{group: bottom}]\n"
                          "model: {name: jelly, modulus_j: -1, rho: {file: lost.csv}}\n"
                          "haptic: {max_force_n: 1000, between_steps: hold, max_slew: 1}\n"
                          "loads: [{nodes: [99], force_n: [0, 0, 1]}]\n"
                          "color: red\n",
                          (const char *const[]){"publish.mesh_rate_hz=-1"}, 1));
    static const char *const expected[] = {
        ":5:19: ", ":6:33: ", ":6:49: ", ":7:23: ",
        ":7:50: ", ":8:18: ", ":9:1: ",  "--set publish.mesh_rate_hz=-1: "};
    enum { COUNT = sizeof expected / sizeof *expected };
    assert_int_equal(error.fault_count, COUNT);
    const char *at = error.text;
    for (int i = 0; i < COUNT; i++) {
        const char *found = strstr(at, expected[i]);
        if (found == NULL) {
            fail_msg("no %s in its place:\n%s", expected[i], error.text);
        }
        at = found;
    }
}

TEST(counts_faults_beyond_what_can_be_shown)
{
    char text[16384] = "softsim: 1\nobject:\n";
    for (int i = 0; i < 200; i++) {
        char line[40];
        snprintf(line, sizeof line, "  unknown_key_%03d: 1\n", i);
        strcat(text, line);
    }
    assert_null(load_with(text, NULL, 0));
    assert_int_equal(error.fault_count, 200 + 2); /* units and model are missing too */
    assert_non_null(strstr(error.text, "more faults)"));
}

TEST(hostile_text_is_refused_and_cleaned)
{
    ss_scene *scene = NULL;
    static const char *const text[] = {
        "",
        "# nothing\n",
        "just words",
        "[1, 2]",
        "softsim: \"\\x1b[31mred\"\nobject: {}\nmodel: {}\n",
        "a: [[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]",
        "? [a]\n: b\n",
        "\xff\xfe\x01",
        "softsim: 1\nmodel: {name: jelly, \"modulus_j\\0\": 1}\n",
    };
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        assert_null(load_with(text[i], NULL, 0));
        assert_true(error.fault_count > 0);
        assert_null(strchr(error.text, '\x1b'));
    }
    assert_int_equal(
        ss_scene_load_text("s.yaml", "a\0b", 3, NULL, 0, model, MODEL_COUNT, NULL, &scene, &error),
        SOFTSIM_ERROR_FORMAT);
    const size_t size = 17u << 20;
    char *large = malloc(size);
    assert_non_null(large);
    memset(large, ' ', size);
    assert_int_equal(ss_scene_load_text("s.yaml", large, size, NULL, 0, model, MODEL_COUNT, NULL,
                                        &scene, &error),
                     SOFTSIM_ERROR_FORMAT);
    free(large);
    error = (softsim_error){0};
    assert_int_equal(
        ss_scene_load("/nowhere/s.yaml", NULL, 0, model, MODEL_COUNT, NULL, &scene, &error),
        SOFTSIM_ERROR_FILE);
    assert_non_null(strstr(error.text, "/nowhere/s.yaml: error: cannot open"));
    assert_int_equal(ss_scene_load("/tmp", NULL, 0, model, MODEL_COUNT, NULL, &scene, &error),
                     SOFTSIM_ERROR_FILE);
}

int main(void)
{
    return run_all_tests(make_files, remove_folder);
}
