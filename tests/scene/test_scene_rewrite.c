/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Scenes rewritten: values change in their places, everything else stays as the user wrote it, the
 * result is the scene that the overrides make; what cannot be placed is refused.
 */
#include "common/test.h"
#include "scene_fixture.h"

#include <sys/stat.h>

static const char text[] =
    "# made by hand\n"
    "softsim: 1   # the format\n"
    "object:\n"
    "  mesh: cube.msh\n"
    "  units: mm\n"
    "model:\n"
    "  name: jelly # wobbles\n"
    "  modulus_j: 5.0 # J\n"
    "  rho: [{where: {box_m: [[0, 0, 0], [1, 1, 0.01]]}, value: 1}, {value: 2}]\n"
    "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]}\n";

/* The file as it would be written to `to`, with the assignments; NULL when refused. */
static char *rewrite(const char *source, const char *const *set, int count, const char *to)
{
    ss_scene *scene = NULL;
    const char *path = write_text("r.yaml", source);
    error = (softsim_error){0};
    ss_scene_load(path, set, count, model, MODEL_COUNT, NULL, &scene, &error);
    if (scene == NULL) {
        fail_msg("%s", error.text);
    }
    char *out = ss_scene_rewrite(scene, set, count, to, &error);
    assert_int_equal(out == NULL, error.fault_count > 0);
    ss_scene_destroy(&scene);
    return out;
}

TEST(a_number_changes_in_its_place)
{
    const char *set[] = {"model.modulus_j=12.5", "model.rho.1.value=0.25",
                         "contact.tools.0.shape.sphere.radius_mm=6"};
    char *out = rewrite(text, set, 3, folder);
    assert_non_null(out);
    char expected[sizeof text + 64];
    snprintf(expected, sizeof expected, "%s", text);
    const char *change[][2] = {{"5.0 # J", "12.5 # J  # was 5.0"},
                               {"{value: 2}]", "{value: 0.25}]  # value was 2"},
                               {"radius_mm: 5}}}]}", "radius_mm: 6}}}]}  # radius_mm was 5"}};
    for (int k = 0; k < 3; ++k) {
        char rest[sizeof expected];
        char *at = strstr(expected, change[k][0]);
        assert_non_null(at);
        snprintf(rest, sizeof rest, "%s", at + strlen(change[k][0]));
        snprintf(at, sizeof expected - (size_t)(at - expected), "%s%s", change[k][1], rest);
    }
    assert_string_equal(out, expected);
    free(out);
}

/* What stands beside a value may tell of the old one, which is then there too. */
TEST(a_value_that_changes_says_what_it_was)
{
    static const char source[] = "softsim: 1\n"
                                 "object: {mesh: 'cube.msh', units: mm,\n"
                                 "  fixed: [{box_m: [[0, 0, 0], [1, 1, 0.01]]}]} # below\n"
                                 "model:\n"
                                 "  name: jelly\n"
                                 "  # 5 J: a source\n"
                                 "  modulus_j: 5\r\n"
                                 "  rho:\n"
                                 "    - {where: {box_m: [[0, 0, 0], [1, 1, 0.01]]}, value: 1}\n"
                                 "    - value: 2 # here\n";
    const char *set[] = {"model.modulus_j=7", "model.modulus_j=8", "model.rho.0.value=1",
                         "model.rho.1.value=3", "object.mesh=cube.msh"};
    char *out = rewrite(source, set, 5, folder);
    assert_non_null(out);
    assert_non_null(strstr(out, "\n  # 5 J: a source\n  modulus_j: 8  # was 7\r\n"));
    assert_non_null(strstr(out, ", value: 1}\n    - value: 3 # here  # was 2\n"));
    assert_non_null(strstr(out, "{mesh: cube.msh, units: mm,  # mesh was 'cube.msh'\n"));
    assert_null(strstr(out, "below  #"));
    ss_scene *scene = load_with(out, NULL, 0);
    if (scene == NULL) {
        fail_msg("%s\n%s", error.text, out);
    }
    ss_scene_destroy(&scene);
    free(out);
    /* What an earlier rewrite told goes; what somebody wrote stays. */
    static const char marked[] = "softsim: 1\nobject: {units: mm, mesh: cube.msh}\nmodel:\n"
                                 "  name: jelly\n"
                                 "  modulus_j: 5  # was 4 J  # was told  # was 6  # rho was 1\n";
    out = rewrite(marked, set, 1, folder);
    assert_non_null(out);
    assert_non_null(strstr(out, "  modulus_j: 7  # was 4 J  # was told  # rho was 1  # was 5\n"));
    free(out);
    /* The end of its line is in the middle of another's text: nothing can stand there. */
    static const char open[] = "softsim: 1\nobject: {units: mm, mesh: \"cube.\\\n  msh\"}\n"
                               "model: {name: jelly, modulus_j: 1}\n";
    const char *units[] = {"object.units=cm"};
    out = rewrite(open, units, 1, folder);
    assert_non_null(out);
    assert_non_null(strstr(out, "{units: cm, mesh: \"cube.\\\n  msh\"}\n"));
    free(out);
}

TEST(what_is_not_there_is_added)
{
    const char *set[] = {"model.cells=9", "haptic.max_force_n=3",
                         "haptic.coupling.stiffness_n_per_m=300", "contact.working_force_n=1.5",
                         "simulation.rate_hz=500"};
    char with_empty[sizeof text + 16];
    snprintf(with_empty, sizeof with_empty, "%ssimulation:\n", text);
    char *out = rewrite(with_empty, set, 5, folder);
    if (out == NULL) {
        fail_msg("%s", error.text);
    }
    assert_non_null(strstr(out, "  name: jelly # wobbles\n  cells: 9\n  modulus_j: 5.0 # J\n"));
    assert_non_null(strstr(out, "{working_force_n: 1.5, tools: "));
    assert_non_null(strstr(out, "softsim: 1   # the format\nhaptic: {"));
    assert_non_null(strstr(out, "simulation: {rate_hz: 500}\n"));
    ss_scene *scene = load_with(out, NULL, 0);
    if (scene == NULL) {
        fail_msg("%s\n%s", error.text, out);
    }
    assert_near(scene->max_force_n, 3.0, 0.0);
    assert_near(scene->coupling_stiffness_n_per_m, 300.0, 0.0);
    assert_near(scene->working_force_n, 1.5, 0.0);
    assert_near(scene->simulation_rate_hz, 500.0, 0.0);
    assert_near(scene->param[CELLS].number, 9.0, 0.0);
    ss_scene_destroy(&scene);
    free(out);
}

TEST(a_key_goes_before_a_mapping_that_comes_first)
{
    const char *set[] = {"haptic.max_force_n=3"};
    char *out = rewrite(replace_line(12, "  coupling: {damping_n_s_per_m: 1}"), set, 1, folder);
    assert_non_null(out);
    assert_non_null(
        strstr(out, "haptic:\n  max_force_n: 3\n  coupling: {damping_n_s_per_m: 1}\nloads:\n"));
    free(out);
    out = rewrite(replace_line(12, "  coupling: {}"), set, 1, folder);
    assert_non_null(strstr(out, "haptic:\n  max_force_n: 3\n  coupling: {}\n"));
    free(out);
    const char *inner[] = {"haptic.coupling.damping_n_s_per_m=2.5"};
    out = rewrite(replace_line(12, "  coupling: {}"), inner, 1, folder);
    assert_non_null(strstr(out, "  coupling: {damping_n_s_per_m: 2.5}\n"));
    free(out);
}

TEST(files_are_found_from_another_folder)
{
    const char *other = in_folder("other");
    assert_int_equal(mkdir(other, 0777), 0);
    static const char with_files[] = "softsim: 1\n"
                                     "object: {mesh: cube.msh, units: mm,\n"
                                     "  fixed: [{nodes: seven.txt}]}\n"
                                     "model: {name: jelly, modulus_j: 1, rho: {file: rho.csv}}\n";
    char *out = rewrite(with_files, NULL, 0, other);
    assert_non_null(out);
    char path[600];
    snprintf(path, sizeof path, "%s/s.yaml", other);
    ss_scene *scene = NULL;
    error = (softsim_error){0};
    ss_scene_load_text(path, out, strlen(out), NULL, 0, model, MODEL_COUNT, NULL, &scene, &error);
    if (scene == NULL) {
        fail_msg("%s\n%s", error.text, out);
    }
    assert_int_equal(scene->fixed[7], 7);
    assert_near(scene->param[RHO].per_node[6], 7.0, 0.0);
    ss_scene_destroy(&scene);
    free(out);
    /* From the same folder, by another name of it, nothing changes. */
    snprintf(path, sizeof path, "%s/../other/../", other);
    out = rewrite(with_files, NULL, 0, path);
    assert_non_null(out);
    assert_string_equal(out, with_files);
    free(out);
    assert_int_equal(rmdir(other), 0);
}

/* A text as it may stand in a file, and the values with which it must be replaced whole. */
TEST(a_text_in_quotes_is_replaced_with_its_quotes)
{
    static const char *const written[] = {"cube.msh",         "\"cube.msh\"", "'cube.msh'",
                                          "\"\\x63ube.msh\"", "\"\"",         "''"};
    const char *set[][1] = {{"object.mesh=cube_m.msh"}, {"object.mesh=./b_#1.msh"}};
    static const char *const becomes[] = {"cube_m.msh", "\"./b_#1.msh\""};
    FILE *stream = open_file("b_#1.msh");
    print_cube(stream, 20);
    fclose(stream);
    for (size_t k = 0; k < sizeof written / sizeof *written; ++k) {
        for (int v = 0; v < 2; ++v) {
            char source[256], expected[256];
            static const char form[] = "object: {mesh: %s, units: mm}\nsoftsim: 1\n"
                                       "model: {name: jelly, modulus_j: 1}\n";
            snprintf(source, sizeof source, form, written[k]);
            snprintf(expected, sizeof expected, form, becomes[v]);
            if (strcmp(written[k], becomes[v]) != 0) {
                char *end = strchr(expected, '\n'), rest[256];
                snprintf(rest, sizeof rest, "%s", end);
                snprintf(end, sizeof expected - (size_t)(end - expected), "  # mesh was %s%s",
                         written[k], rest);
            }
            char *out = rewrite(source, set[v], 1, folder);
            assert_non_null(out);
            assert_string_equal(out, expected);
            free(out);
        }
    }
}

TEST(files_in_quotes_are_found_from_another_folder)
{
    static const char *const quote[] = {"", "\"", "'"};
    const char *other = in_folder("other");
    assert_int_equal(mkdir(other, 0777), 0);
    for (int k = 0; k < 3; ++k) {
        char source[256], expected[1600];
        static const char form[] = "softsim: 1\nobject:\n  mesh: %s%s%s # of a cube\n  units: mm\n"
                                   "model: {name: jelly, modulus_j: 1, rho: {file: %s%s%s}}\n";
        char mesh[600], table[600];
        snprintf(mesh, sizeof mesh, "%s/cube.msh", folder);
        snprintf(table, sizeof table, "%s/rho.csv", folder);
        snprintf(source, sizeof source, form, quote[k], "cube.msh", quote[k], quote[k], "rho.csv",
                 quote[k]);
        snprintf(expected, sizeof expected, form, "\"", mesh, "\"", "\"", table, "\"");
        char *out = rewrite(source, NULL, 0, other);
        assert_non_null(out);
        assert_string_equal(out, expected);
        free(out);
    }
    assert_int_equal(rmdir(other), 0);
}

TEST(lists_and_lost_folders_are_refused)
{
    const char *list[] = {"model.rho=3"};
    assert_null(rewrite(text, list, 1, folder));
    assert_non_null(strstr(error.text, "model.rho is a list or a mapping there"));
    assert_null(rewrite(text, NULL, 0, "/tmp/there/is/no/such/folder/"));
    assert_non_null(strstr(error.text, "is not there"));
}

TEST(numbers_are_found_by_path)
{
    const char *set[] = {"model.rho.0.value=0.5"};
    ss_scene *scene = load_with(text, set, 1);
    double value = 0.0;
    assert_true(ss_scene_find_number(scene, &model[0], "model.modulus_j", &value));
    assert_near(value, 5.0, 0.0);
    assert_true(ss_scene_find_number(scene, &model[0], "model.rho.0.value", &value));
    assert_near(value, 0.5, 0.0);
    assert_true(ss_scene_find_number(scene, &model[0], "model.damping_n_s_per_m3", &value));
    assert_near(value, 1725.0, 0.0);
    assert_false(ss_scene_find_number(scene, &model[0], "model.rho", &value));
    assert_false(ss_scene_find_number(scene, &model[0], "model.rho.2.value", &value));
    assert_false(ss_scene_find_number(scene, &model[0], "model.name", &value));
    assert_false(ss_scene_find_number(scene, &model[0], "model.saturation", &value));
    assert_false(ss_scene_find_number(scene, &model[0], "model..", &value));
    ss_scene_destroy(&scene);
}

static void gather(void *sink, const char *line)
{
    char *to = sink;
    snprintf(to + strlen(to), 1024 - strlen(to), "%s\n", line);
}

TEST(what_was_given_is_printed_alone)
{
    char out[1024] = "";
    const char *set[] = {"model.modulus_j=2", "model.rho={file: rho.csv}", "model.cells=3"};
    ss_scene *scene = load_with(text, set, 3);
    ss_scene_print_given(scene, "model", gather, out);
    char expected[512];
    snprintf(expected, sizeof expected,
             "  name: jelly\n  modulus_j: 2\n  rho: {file: \"%s/rho.csv\"}\n  cells: 3\n", folder);
    assert_string_equal(out, expected);
    ss_scene_destroy(&scene);
}

int main(void)
{
    return run_all_tests(make_files, remove_folder);
}
