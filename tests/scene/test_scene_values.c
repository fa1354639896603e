/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Values of a scene: overridden, printed and loaded again, set while it runs. */
#include "common/test.h"
#include "scene_fixture.h"

/* ---- overrides ---- */

TEST(overrides_reach_every_scalar)
{
    static const char *const overrides[] = {
        "haptic.max_force_n=6",
        "haptic.coupling.damping_n_s_per_m=0.5",
        "model.rho=0.25",
        "model.solver=relaxation",
        "simulation.rate_hz=500",
        "publish.mesh_rate_hz=30",
        "contact.tools.0.shape.sphere.radius_mm=6",
        "contact.tools[0].probe=2",
        "loads.0.force_n.2=-4",
        "loads.0.nodes=[5, 6]",
        "gravity_m_s2=[0, -1, 0]",
        "object.fixed.0.box_m.1.2=1",
        "object.transform.scale=3",
    };
    ss_scene *s = load_good(small, overrides, sizeof overrides / sizeof *overrides);
    assert_near(s->max_force_n, 6, 0);
    assert_near(s->coupling_damping_n_s_per_m, 0.5, 0);
    assert_near(s->param[RHO].number, 0.25, 0);
    assert_null(s->param[RHO].per_node);
    assert_near(s->param[SOLVER].number, 1, 0);
    assert_near(s->simulation_rate_hz, 500, 0);
    assert_near(s->mesh_rate_hz, 30, 0);
    assert_near(s->tool[2].shape.radius, 6e-3, 1e-18);
    assert_false(s->tool[0].is_used);
    assert_near(s->load[0].force[2], -4, 0);
    assert_int_equal(s->load[0].node_count, 2);
    assert_near(s->gravity[1], -1, 0);
    assert_int_equal(s->fixed[7], 7);
    assert_near(s->mesh->position[7][0], 0.06, 1e-15);
    ss_scene_destroy(&s);
    /* The last one counts. */
    s = load_good(small, (const char *const[]){"haptic.max_force_n=6", "haptic.max_force_n=5"}, 2);
    assert_near(s->max_force_n, 5, 0);
    ss_scene_destroy(&s);
}

TEST(a_bad_override_names_the_option)
{
    static const struct {
        const char *option;
        const char *word;
    } row[] = {
        {"haptic.max_force_n", "PATH=VALUE"},
        {"=3", "PATH=VALUE"},
        {"haptic.max_force_n=", "PATH=VALUE"},
        {"haptic..max_force_n=3", "not a path"},
        {"haptic.max_force_n.=3", "not a path"},
        {"haptic.max_force=3", "did you mean 'max_force_n'?"},
        {"haptic.max_force_n=much", "not a number"},
        {"haptic.max_force_n=-1", "out of range"},
        {"haptic.max_force_n.x=1", "is a value"},
        {"contact.tools.1.probe=1", "has no entry '1'; it has 1"},
        {"contact.tools.0.shape.cone.radius_mm=1", "length_mm is missing"},
        {"model.name=none", "not built in"},
        {"gravity_m_s2=[0, 0", "YAML"},
        {"colour=red", "unknown key 'colour'"},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char start[120];
        assert_null(load_with(small, &row[i].option, 1));
        snprintf(start, sizeof start, "--set %s: error: ", row[i].option);
        if (strstr(error.text, start) == NULL || strstr(error.text, row[i].word) == NULL) {
            fail_msg("%s: no '%s' in:\n%s", row[i].option, row[i].word, error.text);
        }
    }
}

/* ---- printing ---- */

static void collect(void *sink, const char *text)
{
    char *all = sink;
    assert_null(strchr(text, '\n'));
    strcat(all, text);
    strcat(all, "\n");
}

static void assert_same_scene(const ss_scene *a, const ss_scene *b)
{
    const int32_t n = a->mesh->node_count;
    assert_int_equal(b->mesh->node_count, n);
    assert_memory_equal(a->mesh->position, b->mesh->position, (size_t)n * sizeof(double[3]));
    assert_memory_equal(a->fixed, b->fixed, (size_t)n);
    for (int i = 0; i < model[a->model_index].row_count; i++) {
        const ss_param_value *p = &a->param[i];
        const ss_param_value *q = &b->param[i];
        assert_memory_equal(&p->number, &q->number, sizeof p->number);
        assert_int_equal(p->per_node != NULL, q->per_node != NULL);
        if (p->per_node != NULL) {
            assert_memory_equal(p->per_node, q->per_node, (size_t)n * sizeof(double));
        }
        assert_memory_equal(p->direction, q->direction, sizeof p->direction);
        assert_int_equal(p->per_element != NULL, q->per_element != NULL);
        if (p->per_element != NULL) {
            assert_memory_equal(p->per_element, q->per_element,
                                (size_t)ss_mesh_element_count(a->mesh) * sizeof(double[3]));
        }
    }
    assert_memory_equal(a->tool, b->tool, sizeof a->tool);
    assert_int_equal(a->load_count, b->load_count);
    for (int i = 0; i < a->load_count; i++) {
        assert_memory_equal(a->load[i].force, b->load[i].force, sizeof a->load[i].force);
        assert_memory_equal(&a->load[i].to, &b->load[i].to, sizeof(double));
        assert_int_equal(a->load[i].node_count, b->load[i].node_count);
    }
    assert_int_equal(a->prescribed_count, b->prescribed_count);
    /* All plain values stand together from working_force_n to max_bytes_per_s. */
    const size_t first = offsetof(ss_scene, working_force_n);
    const size_t last = offsetof(ss_scene, repairs);
    assert_memory_equal((const char *)a + first, (const char *)b + first, last - first);
}

TEST(what_is_printed_loads_again)
{
    static char text[65536];
    static char again[65536];
    write_directions("grain_12.csv", 12);
    char grain[4096];
    snprintf(grain, sizeof grain, "%s",
             replace_line(8, "  modulus_j: 5\n  grain: {file: grain_12.csv}"));
    const char *const scene_text[] = {
        full,
        small,
        grain,
        replace_line(10, "  stiffness_n_per_m3: 123456789.125\n"
                         "  friction: [{where: {group: top}, value: 0.5}, {value: 0.1}]"),
        "softsim: 1\nobject: {grid: {plane: {rows: 3, columns: 4, width_m: 0.3, height_m: 2}}}\n"
        "model: {name: jelly, modulus_j: 1, grain: [1, -2.5, 0]}\n",
        GRID("  grid: {file: points.csv, rows: 3, columns: 2, closed: rows}\n  units: mm\n")};
    for (size_t i = 0; i < sizeof scene_text / sizeof *scene_text; i++) {
        ss_scene *a =
            load_good(scene_text[i], (const char *const[]){"haptic.max_slew_n_per_s=10.1"}, 1);
        text[0] = '\0';
        ss_scene_print(a, &model[0], collect, text);
        /* From another folder: file names are absolute. */
        ss_scene *b = NULL;
        error = (softsim_error){0};
        ss_scene_load_text("/elsewhere/s.yaml", text, strlen(text), NULL, 0, model, MODEL_COUNT,
                           NULL, &b, &error);
        if (b == NULL) {
            fail_msg("refused:\n%s\n%s", text, error.text);
        }
        assert_same_scene(a, b);
        again[0] = '\0';
        ss_scene_print(b, &model[0], collect, again);
        assert_string_equal(text, again);
        ss_scene_destroy(&a);
        ss_scene_destroy(&b);
    }
}

TEST(each_printed_value_has_its_meaning_beside_it)
{
    static char text[65536];
    ss_scene *s = load_good(small, NULL, 0);
    text[0] = '\0';
    ss_scene_print(s, &model[0], collect, text);
    assert_non_null(strstr(text, "  max_force_n: 3 "));
    assert_non_null(strstr(text, "a number from 0.01 to 100 (N); default 8; live\n"));
    assert_non_null(strstr(text, "  # saturation: "));
    assert_non_null(strstr(text, "absent unless given; restart\n"));
    assert_non_null(strstr(text, "  damping_n_s_per_m3: 1725 "));
    assert_non_null(strstr(text, "default 1725; live\n"));
    assert_non_null(strstr(text, "  rate_hz: auto "));
    ss_scene_destroy(&s);
}

TEST(every_key_of_a_list_is_printed_with_an_example)
{
    static char text[65536];
    static const char *const shown[] = {"  # grid: {cylinder: ",
                                        "  # outer: ",
                                        "  # transform: {scale: ",
                                        "    # - {box_m: [[",
                                        "    # - {plane: {",
                                        "    # - {group: bottom, axes: z}",
                                        "    # - {nodes: [0, 1",
                                        "loads:",
                                        "  # - {nodes: [80], force_n: [",
                                        "prescribed:",
                                        "displacement_m: [",
                                        "displacement_file: u.csv}",
                                        "    # - {probe: 2, shape: {box: ",
                                        "the first that matches counts"};
    ss_scene *s = load_good(small, NULL, 0);
    text[0] = '\0';
    ss_scene_print(s, &model[0], collect, text);
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
        if (strstr(text, shown[i]) == NULL) {
            fail_msg("no '%s' in:\n%s", shown[i], text);
        }
    }
    ss_scene_destroy(&s);
}

/* ---- live keys ---- */

TEST(live_keys_are_parsed_and_the_rest_refused)
{
    static const struct {
        const char *assignment;
        ss_scene_live_key key;
        double value;
    } good[] = {
        {"haptic.max_force_n=3", SS_LIVE_MAX_FORCE, 3},
        {"haptic.max_slew_n_per_s=1e3", SS_LIVE_MAX_SLEW, 1000},
        {"haptic.coupling.stiffness_n_per_m=700", SS_LIVE_COUPLING_STIFFNESS, 700},
        {"haptic.coupling.damping_n_s_per_m=0", SS_LIVE_COUPLING_DAMPING, 0},
        {"haptic.between_steps=linear", SS_LIVE_BETWEEN_STEPS, SS_SCENE_LINEAR},
        {"haptic.max_jump_m=0.5", SS_LIVE_MAX_JUMP, 0.5},
        {"publish.mesh_rate_hz=0", SS_LIVE_MESH_RATE, 0},
        {"publish.max_bytes_per_s=20000", SS_LIVE_MAX_BYTES, 20000},
        {"model.damping_n_s_per_m3=12", SS_LIVE_MODEL_ROW, 12},
    };
    ss_scene_live_key key;
    int32_t row;
    double value;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_int_equal(
            ss_scene_parse_live(good[i].assignment, &model[0], &key, &row, &value, &error),
            SOFTSIM_OK);
        assert_int_equal(key, good[i].key);
        assert_near(value, good[i].value, 0);
        assert_int_equal(row, key == SS_LIVE_MODEL_ROW ? DAMPING : -1);
    }
    static const struct {
        const char *assignment;
        const char *word;
    } refused[] = {
        {"haptic.rate_hz=500", "restart"},
        {"model.modulus_j=1", "restart"},
        {"model.name=block", "restart"},
        {"contact.tools.0.probe=1", "restart"},
        {"haptic=1", "restart"},
        {"haptic.max_force_n=0", "out of range"},
        {"haptic.max_force_n=1e-300", "out of range"},
        {"haptic.max_slew_n_per_s=1e-9", "out of range"},
        {"haptic.coupling.stiffness_n_per_m=1e-9", "out of range"},
        {"haptic.max_force_n=nan", "not finite"},
        {"haptic.max_force_n=", "has no value"},
        {"haptic.max_force_n.x=1", "no key 'x'"},
        {"haptic.max_forc=1", "no key"},
        {"model.magic=1", "no key 'magic'"},
        {"haptic.between_steps=guess", "one of"},
        {"nothing", "PATH=VALUE"},
        {"=", "PATH=VALUE"},
        {"", "PATH=VALUE"},
        {".=1", "no key"},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        error = (softsim_error){0};
        assert_int_equal(
            ss_scene_parse_live(refused[i].assignment, &model[0], &key, &row, &value, &error),
            SOFTSIM_ERROR_ARGUMENT);
        if (strstr(error.text, refused[i].word) == NULL) {
            fail_msg("%s: %s", refused[i].assignment, error.text);
        }
    }
}

int main(void)
{
    return run_all_tests(make_files, remove_folder);
}
