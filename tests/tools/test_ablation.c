/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench ablation and --force-include: what a plan leaves out is put back by its name and is
 * then no longer left out, results stay the same, a difference fails, and what cannot be put back
 * is refused in one line.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/ablation/pair.h"
#include "bench/bench.h"
#include "case/table.h"
#include "common/folder_fixture.h"
#include "process/process.h"
#include "softsim/softsim.h"

/* A sheet of 81 nodes, held along two sides. */
#define SCENE                                                                                      \
    "softsim: 1\n"                                                                                 \
    "object:\n"                                                                                    \
    "  grid: {plane: {rows: 9, columns: 9, width_m: 0.08, height_m: 0.08}}\n"                      \
    "  fixed: [{box_m: [[-1, -1, -1], [-0.04, 1, 1]]}, {box_m: [[0.04, -1, -1], [1, 1, 1]]}]\n"    \
    "model: {name: cnn-energy, modulus_j: 5, area_density_kg_m2: 11.5, damping_n_s_per_m3: "       \
    "1725,\n"                                                                                      \
    "        rest_stiffness_n_per_m3: 50000}\n"                                                    \
    "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n"

static int32_t plan(const char *scene, const ss_omission *with, ss_omission out[SS_MAX_OMISSIONS])
{
    const char *set[SS_OMISSION_VALUES];
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_config config = softsim_default_config();
    config.set = set;
    for (int32_t k = 0; with != NULL && k < with->value_count; ++k) {
        set[config.set_count++] = with->value[k];
    }
    softsim_world *world = softsim_create(scene, &config, &error);
    if (world == NULL) {
        fail_msg("%s: %s", with != NULL ? with->name : "as it is", error.text);
    }
    const int32_t count = ss_world_omissions(ss_world_of(world), out);
    softsim_destroy(&world);
    return count;
}

static bool is_left_out(const ss_omission *omission, int32_t count, const char *name)
{
    bool is_any = false;
    for (int32_t i = 0; i < count; ++i) {
        is_any = is_any || strcmp(omission[i].name, name) == 0;
    }
    return is_any;
}

TEST(what_is_put_back_is_no_longer_left_out)
{
    ss_omission omission[SS_MAX_OMISSIONS], rest[SS_MAX_OMISSIONS];
    int32_t put_back = 0;
    const char *scene = write_text("sheet.yaml", SCENE);
    const int32_t count = plan(scene, NULL, omission);
    for (int32_t i = 0; i < count; ++i) {
        if (omission[i].value_count > 0) {
            const int32_t left = plan(scene, &omission[i], rest);
            if (is_left_out(rest, left, omission[i].name)) {
                fail_msg("%s: left out with %s", omission[i].name, omission[i].value[0]);
            }
            ++put_back;
        }
    }
    assert_true(put_back >= 2);
}

TEST(names_in_a_plan_are_of_one_omission_each)
{
    ss_omission omission[SS_MAX_OMISSIONS];
    const int32_t count = plan(write_text("sheet.yaml", SCENE), NULL, omission);
    for (int32_t i = 0; i < count; ++i) {
        assert_false(is_left_out(omission, i, omission[i].name));
    }
}

TEST(results_agree_by_the_hash_or_by_a_thousandth)
{
    const ss_ablation_figures same = {.is_same_state = true, .force_apart = 1.0};
    const ss_ablation_figures near = {.force_apart = 1e-3, .field_apart = 1e-3};
    const ss_ablation_figures force = {.force_apart = 1.1e-3};
    const ss_ablation_figures field = {.field_apart = 1.1e-3};
    const ss_ablation_figures none = {.force_apart = (double)NAN};
    assert_true(ss_ablation_agrees(&same));
    assert_true(ss_ablation_agrees(&near));
    assert_false(ss_ablation_agrees(&force));
    assert_false(ss_ablation_agrees(&field));
    assert_false(ss_ablation_agrees(&none));
}

/* A value that changes what a press feels, as if it were how to put something back. */
TEST(a_pair_tells_results_that_differ)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_ablation_figures figures;
    const ss_omission stiffer = {
        .name = "stiffer", .value = {"model.modulus_j=6"}, .value_count = 1};
    const char *scene = write_text("sheet.yaml", SCENE);
    assert_int_equal(ss_ablation_measure(scene, &stiffer, &figures, &error), SOFTSIM_OK);
    assert_false(ss_ablation_agrees(&figures));
    assert_true(figures.force_apart > 0.0); /* it was touched */
}

/* What changes the rate alone is the same at the same rate. */
TEST(a_pair_is_stepped_at_one_rate)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_ablation_figures figures;
    const ss_omission slower = {
        .name = "slower", .value = {"simulation.rate_hz=500"}, .value_count = 1};
    const char *scene = write_text("sheet.yaml", SCENE);
    assert_int_equal(ss_ablation_measure(scene, &slower, &figures, &error), SOFTSIM_OK);
    assert_true(figures.rate_hz[0] == 1000.0 && figures.rate_hz[1] == 500.0);
    assert_true(figures.is_same_state);
}

TEST(a_pair_of_a_load_of_nothing_is_the_same)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_ablation_figures figures;
    const ss_omission load = {
        .name = "load", .value = {"loads=[{nodes: [40], force_n: [0, 0, 0]}]"}, .value_count = 1};
    const char *scene = write_text("sheet.yaml", SCENE);
    assert_int_equal(ss_ablation_measure(scene, &load, &figures, &error), SOFTSIM_OK);
    assert_true(figures.is_same_state);
}

TEST(the_report_of_a_scene_has_equal_results_with_what_was_asked_for)
{
    char out[128], scene[128];
    char *argv[] = {"softsim-bench ablation",
                    "--scene",
                    scene,
                    "--force-include",
                    "friction",
                    "--force-include",
                    "steps at rest",
                    "--out",
                    out,
                    NULL};
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    snprintf(scene, sizeof scene, "%s", write_text("sheet.yaml", SCENE));
    snprintf(out, sizeof out, "%s", in_folder("report"));
    const int kept = divert(stdout, "/dev/null");
    assert_int_equal(ss_report_ablation.run(9, argv), 0);
    restore(stdout, kept);
    if (ss_table_load(in_folder("report/ablation.csv"), &table, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(table.row_count, 2);
    const int32_t good = ss_table_find(&table, "is_good", &error);
    for (int32_t i = 0; i < table.row_count; ++i) {
        assert_string_equal(ss_table_cell(&table, i, good), "1");
    }
    ss_table_fini(&table);
}

TEST(the_report_refuses_a_name_that_cannot_be_put_back)
{
    char out[128], scene[128], text[2048];
    static const char *const name[] = {"convex narrow phase", "no such part"};
    snprintf(scene, sizeof scene, "%s", write_text("sheet.yaml", SCENE));
    snprintf(out, sizeof out, "%s", in_folder("none"));
    for (int k = 0; k < 2; ++k) {
        char *argv[] = {"softsim-bench ablation", "--scene", scene, "--force-include",
                        (char *)name[k],          "--out",   out,   NULL};
        const int kept = divert(stderr, in_folder("err.txt"));
        const int status = ss_report_ablation.run(7, argv);
        restore(stderr, kept);
        read_text("err.txt", text, sizeof text);
        assert_int_equal(status, 2);
        assert_non_null(strstr(text, name[k]));
        assert_non_null(strstr(text, "'friction', 'steps at rest'"));
        assert_ptr_equal(strchr(text, '\n'), text + strlen(text) - 1); /* one line */
    }
}

TEST(a_run_with_a_part_put_back_ends_in_the_same_state)
{
    static process p[2];
    const char *scene = write_text("sheet.yaml", SCENE "gravity_m_s2: [0, 0, -9.81]\n");
    const char *const argv[2][8] = {
        {"softsim-run", scene, "--duration", "0.05", "--hash"},
        {"softsim-run", scene, "--duration", "0.05", "--hash", "--force-include", "steps at rest"}};
    for (int k = 0; k < 2; ++k) {
        process_start(&p[k], argv[k], NULL);
        assert_int_equal(process_finish(&p[k]), 0);
    }
    assert_true(strlen(p[0].out) > 10);
    assert_string_equal(p[0].out, p[1].out);
}

TEST(a_run_refuses_a_part_that_is_not_left_out)
{
    process p;
    const char *const argv[] = {"softsim-run",
                                write_text("sheet.yaml", SCENE),
                                "--duration",
                                "0.05",
                                "--force-include",
                                "network",
                                NULL};
    process_start(&p, argv, NULL);
    assert_int_equal(process_finish(&p), 2);
    assert_non_null(strstr(p.err, "--force-include 'network'"));
    assert_non_null(strstr(p.err, "friction"));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
