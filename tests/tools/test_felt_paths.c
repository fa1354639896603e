/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench felt: a body is pressed where it is free and against its normal, paths have the
 * speeds and depths that they are named for, forces are compared as said, and a rate compared with
 * itself differs in nothing.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "bench/felt/play.h"
#include "common/effort.h"
#include "common/folder_fixture.h"
#include "common/load_fixture.h"
#include "rt/vec.h"
#include "world/world.h"

/* A plane of 0.2 x 0.1 m in z = 0, its rim held; a capsule of 4 mm, 10 mm long. */
static ss_scene *load_plane(void)
{
    FILE *file = open_file("plane.yaml");
    fputs("softsim: 1\n"
          "object:\n"
          "  grid: {plane: {rows: 10, columns: 20, width_m: 0.2, height_m: 0.1}}\n"
          "  units: m\n"
          "  fixed: [{box_m: [[-1, -1, -1], [1, -0.049, 1]]}, {box_m: [[-1, 0.049, -1], [1, 1, "
          "1]]}]\n"
          "model: {name: cnn-energy, modulus_j: 5, area_density_kg_m2: 11.5,\n"
          "        damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 50000}\n"
          "contact:\n"
          "  tools: [{probe: 3, shape: {capsule: {radius_mm: 4, length_mm: 10}}}]\n",
          file);
    assert_int_equal(fclose(file), 0);
    return load(in_folder("plane.yaml"));
}

TEST(a_sheet_is_pressed_in_its_middle)
{
    ss_scene *scene = load_plane();
    ss_felt_place place;
    assert_true(ss_felt_find_place(scene, &place));
    assert_int_equal(place.probe, 3);
    const double *low = scene->mesh->position[0];
    const double *high = scene->mesh->position[scene->mesh->node_count - 1];
    for (int k = 0; k < 3; ++k) {
        assert_true(fabs(place.point[k] - 0.5 * (low[k] + high[k])) < 1e-9);
    }
    assert_true(fabs(fabs(place.normal[2]) - 1.0) < 1e-12);
    assert_true(fabs(place.reach_m - 0.009) < 1e-9);  /* half its core and a cap */
    assert_true(fabs(place.slide_m - 0.02) < 1e-12);  /* a quarter of 0.2 m would be more */
    assert_true(fabs(place.depth_m - 0.006) < 1e-12); /* 15 % of 0.1 m would be more */
    assert_true(fabs(fabs(place.along[0]) - 1.0) < 1e-12);
    /* The tool's z axis points into the tissue. */
    double z[3], axis[3] = {0.0, 0.0, 1.0};
    ss_rotate(z, place.orientation, axis);
    assert_true(fabs(ss_dot3(z, place.normal) + 1.0) < 1e-12);
    ss_scene_destroy(&scene);
}

TEST(bundled_bodies_are_pressed_from_outside)
{
    static const char *const name[] = {"kidney", "liver", "ventricle"};
    for (size_t k = 0; k < sizeof name / sizeof *name; ++k) {
        char path[4096];
        snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s.yaml", name[k]);
        ss_scene *scene = load(path);
        const ss_mesh *mesh = scene->mesh;
        ss_felt_place place;
        assert_true(ss_felt_find_place(scene, &place));
        assert_true(fabs(ss_norm3(place.normal) - 1.0) < 1e-12);
        assert_true(fabs(ss_dot3(place.normal, place.along)) < 1e-12);
        double nearest = INFINITY, nearest_fixed = INFINITY;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            double d[3];
            ss_sub3(d, mesh->position[i], place.point);
            nearest = fmin(nearest, ss_norm3(d));
            nearest_fixed = scene->fixed[i] ? fmin(nearest_fixed, ss_norm3(d)) : nearest_fixed;
        }
        assert_true(nearest < 0.006);
        assert_true(nearest_fixed > 0.01);
        ss_scene_destroy(&scene);
    }
}

/* Depth and way of a point of the path. */
static void depth_at(const ss_felt_place *place, ss_felt_path path, double t, double *out_s,
                     double *out_along)
{
    double x[3], d[3];
    ss_felt_path_at(place, path, false, t, x);
    ss_sub3(d, x, place->point);
    *out_s = place->reach_m - ss_dot3(d, place->normal);
    *out_along = ss_dot3(d, place->along);
}

TEST(paths_have_the_speeds_of_their_names)
{
    const ss_felt_place place = {.normal = {0.0, 0.0, 1.0},
                                 .along = {1.0, 0.0, 0.0},
                                 .reach_m = 0.004,
                                 .depth_m = 0.006,
                                 .slide_m = 0.02};
    static const double most_depth[] = {0.006, 0.006, 0.006, NAN, 0.003};
    const double dt = 1e-4;
    for (ss_felt_path p = SS_FELT_PRESS; p < SS_FELT_PATHS; ++p) {
        double hold_end = NAN, deepest = -1.0, fastest = 0.0, furthest = 0.0, inside = 0.0;
        double last_s = 0.0, last_t = 0.0, entering = 0.0;
        const double seconds = ss_felt_path_seconds(&place, p, &hold_end);
        depth_at(&place, p, 0.0, &last_s, &last_t);
        assert_true(last_s < -5e-4); /* free at first, and at the end */
        for (double t = dt; t <= seconds; t += dt) {
            double s = 0.0, along = 0.0;
            depth_at(&place, p, t, &s, &along);
            if (last_s < 0.0 && s >= 0.0) {
                entering = (s - last_s) / dt;
            }
            deepest = fmax(deepest, s);
            fastest = fmax(fastest, hypot(s - last_s, along - last_t) / dt);
            furthest = fmax(furthest, along);
            inside += s > 0.0 ? dt : 0.0;
            last_s = s;
            last_t = along;
        }
        assert_true(last_s < -5e-4);
        if (p == SS_FELT_TAP) {
            assert_true(fabs(inside - 4 * 0.05) < 2e-3);
            assert_true(fabs(entering - 0.3) < 3e-3);
            assert_true(fabs(deepest - 0.0039) < 1e-4);
        } else {
            assert_true(fabs(deepest - most_depth[p]) < 1e-6);
        }
        if (p == SS_FELT_POKE_1 || p == SS_FELT_POKE_3) {
            assert_true(fabs(fastest / (p == SS_FELT_POKE_1 ? 0.1 : 0.3) - 1.0) < 1e-3);
        }
        if (p == SS_FELT_PRESS) {
            double s = 0.0, along = 0.0;
            depth_at(&place, p, hold_end - 0.39, &s, &along);
            assert_true(fabs(s - 0.006) < 1e-12);
        }
        assert_true(fabs(furthest - (p == SS_FELT_SLIDE ? 0.02 : 0.0)) < 1e-5);
    }
}

static const ss_felt_question question = {.limit = 0.07, .settle_ms = 20};

TEST(a_force_that_is_a_tenth_more_is_a_tenth_off)
{
    enum { N = 1000 };
    static double reference_n[N][3], more_n[N][3];
    for (int k = 0; k < N; ++k) {
        reference_n[k][1] = k < N / 2 ? 0.0 : 2.0;
        more_n[k][1] = 1.1 * reference_n[k][1];
    }
    more_n[N - 1][0] = 1.0; /* one outlier, across */
    const ss_felt_trace reference = {.count = N, .force = reference_n, .held_n = 2.0};
    const ss_felt_trace more = {.count = N, .force = more_n, .held_n = 2.2};
    ss_felt_errors e;
    assert_true(ss_felt_compare(&more, &reference, &question, &e));
    assert_true(fabs(e.p50 - 0.1) < 1e-12 && fabs(e.p99 - 0.1) < 1e-12);
    assert_true(fabs(e.largest - hypot(0.2, 1.0) / 2.0) < 1e-12);
    assert_true(fabs(e.impulse - (0.1 + (hypot(2.2, 1.0) - 2.2) / (N / 2) / 2.0)) < 1e-12);
    assert_true(fabs(e.peak - (hypot(2.2, 1.0) / 2.0 - 1.0)) < 1e-12);
    assert_true(fabs(e.held - 0.1) < 1e-12);
    assert_true(ss_felt_compare(&reference, &reference, &question, &e));
    assert_true(e.largest == 0.0 && e.impulse == 0.0 && e.peak == 0.0);
    static double nothing_n[N][3];
    const ss_felt_trace nothing = {.count = N, .force = nothing_n, .held_n = NAN};
    assert_true(ss_felt_compare(&more, &nothing, &question, &e));
    assert_true(isnan(e.p50) && isnan(e.p99));
}

/* Two contacts of 1 mN, of 100 ms each, rising in 10 ms; felt 3 ms late, then 2 ms early, and a
 * half more in the last 10 ms of both. */
TEST(a_touch_is_told_late_or_early_and_where_it_differs)
{
    enum { N = 600 };
    static double reference_n[N][3], felt_n[N][3];
    for (int k = 0; k < N; ++k) {
        const int in = k >= 400 ? k - 400 : k - 100; /* since the contact began */
        const int late = k >= 398 ? -2 : 3;
        const bool is_in = in >= 0 && in < 100, is_felt = in >= late && in < 100;
        reference_n[k][0] = is_in ? 1e-3 * fmin(1.0, (in + 1) / 10.0) : 0.0;
        felt_n[k][0] = is_felt ? fmax(reference_n[k][0], 1e-4) * (in >= 90 ? 1.5 : 1.0) : 0.0;
    }
    const ss_felt_trace reference = {.count = N, .force = reference_n, .held_n = NAN};
    const ss_felt_trace felt = {.count = N, .force = felt_n, .held_n = NAN};
    ss_felt_errors e;
    assert_true(ss_felt_compare(&felt, &reference, &question, &e));
    assert_true(e.touch_ms == 3.0);
    assert_true(e.rise_ms == 8.0); /* 0.9 mN at the ninth */
    /* Over 7 %: the first three of the first contact (0.1 to 0.3 mN), ten of each at its end. */
    assert_true(fabs(e.at_touch - 3.0 / 23.0) < 1e-12);
    assert_true(fabs(e.at_leaving - 20.0 / 23.0) < 1e-12);
}

/* Exit status of softsim-bench felt with the arguments. */
static int run(const char *arguments)
{
    char command[8192];
    snprintf(command, sizeof command, BIN_DIR "/softsim-bench felt %s >%s 2>%s", arguments,
             in_folder("out"), in_folder("err"));
    const int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(a_rate_compared_with_itself_differs_in_nothing)
{
    SKIP_WHERE_REPEATED();
    char arguments[4096], line[1024];
    snprintf(line, sizeof line,
             BIN_DIR "/softsim-mesh generate block --size-mm 40,40,40 --points 300 --out %s >%s",
             in_folder("block.obj"), in_folder("out"));
    assert_int_equal(system(line), 0);
    write_text("block.yaml", "softsim: 1\n"
                             "object:\n  mesh: block.obj\n  units: mm\n"
                             "  fixed: [{box_m: [[-1, -1, -1], [1, 1, -0.0199]]}]\n"
                             "model: {name: cnn-energy, modulus_j: 5, area_density_kg_m2: 11.5,\n"
                             "  damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 5.0e+4}\n"
                             "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]\n");
    snprintf(arguments, sizeof arguments, "--scene %s", in_folder("block.yaml"));
    snprintf(arguments + strlen(arguments), sizeof arguments - strlen(arguments),
             " --rates 1000 --quick --out %s", in_folder("felt"));
    assert_int_equal(run(arguments), 0);
    snprintf(line, sizeof line, "%s/felt.csv", in_folder("felt"));
    FILE *file = fopen(line, "r");
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line, "scene,model,rate_hz,path,delay_ms,p50,p99,max,impulse_error,"
                              "peak_error,held_error,static_error,net_energy_j,verdict,p95,"
                              "hold_p99,touch_ms,penetration,short_of,cause\n");
    int rows = 0;
    while (fgets(line, sizeof line, file)) {
        const char *zero = strstr(line, ",0,0,0,0,0,0,"); /* delay, p50 .. peak */
        assert_non_null(zero);
        ++rows;
    }
    assert_int_equal(rows, SS_FELT_PATHS);
    fclose(file);
    snprintf(line, sizeof line, "rm -r '%s'", in_folder("felt"));
    assert_int_equal(system(line), 0);
}

/* What `path` of a bundled scene is at `rate_hz` against 1000 Hz. */
static ss_felt_errors compare_runs(const char *name, ss_felt_path path, double rate_hz,
                                   bool is_without_law)
{
    char file[4096];
    ss_felt_place place;
    ss_felt_trace at[2];
    ss_felt_errors e;
    softsim_error error = {.status = SOFTSIM_OK};
    snprintf(file, sizeof file, SOURCE_DIR "/server/scenes/%s.yaml", name);
    ss_scene *scene = load(file);
    assert_true(ss_felt_find_place(scene, &place));
    ss_scene_destroy(&scene);
    /* Where the contact surface lies deep within the mesh, from there. */
    const ss_felt_run touch = {.rate_hz = 1000.0, .import_program = BIN_DIR "/softsim-import"};
    const double depth_m = ss_felt_touch_depth(file, &place, &touch);
    if (depth_m > 0.25 * place.depth_m) {
        ss_madd3(place.point, place.point, -depth_m, place.normal);
    }
    for (int i = 0; i < 2; ++i) {
        const ss_felt_run run = {.rate_hz = i == 0 ? rate_hz : 1000.0,
                                 .is_without_law = i == 0 && is_without_law,
                                 .import_program = BIN_DIR "/softsim-import"};
        assert_int_equal(ss_felt_play(file, &place, path, &run, &at[i], &error), SOFTSIM_OK);
        assert_true(path != SS_FELT_PRESS || at[i].held_n > 0.1);
    }
    assert_true(ss_felt_compare(&at[0], &at[1], &question, &e));
    ss_felt_trace_fini(&at[0]);
    ss_felt_trace_fini(&at[1]);
    return e;
}

static ss_felt_errors compare_rates(const char *name, ss_felt_path path, double rate_hz)
{
    return compare_runs(name, path, rate_hz, false);
}

/* Contact stiffness is the scene's: 60 Hz gave a third of the force at 1000 Hz; so is the time in
 * which a chain's cells answer: it gave 7 % more. */
TEST(a_held_press_is_the_same_at_every_rate)
{
    static const struct {
        const char *name;
        double rate_hz, most;
    } cases[] = {{"kidney", 60.0, 0.01}, {"liver-chainmail", 30.0, 0.02}, {"kidney", 120.0, 0.01},
                 {"kidney", 30.0, 0.02}, {"liver-chainmail", 60.0, 0.01}, {"liver", 60.0, 0.01}};
    for (size_t k = 0; k < FULL_IN_LONG_RUN(sizeof cases / sizeof *cases, FULL_IN_RELEASE(2, 1));
         ++k) {
        const ss_felt_errors e = compare_rates(cases[k].name, SS_FELT_PRESS, cases[k].rate_hz);
        assert_true(fabs(e.held) <= cases[k].most);
    }
}

/* Between the results of a slow simulation the hand feels what a fast one would answer, within
 * what is just noticeable. */
TEST(a_motion_is_felt_alike_at_60_hz)
{
    SKIP_WHERE_REPEATED();
    static const struct {
        const char *name;
        ss_felt_path path;
        double most;
    } cases[] = {{"ed0-tissue", SS_FELT_POKE_1, 0.1}, {"kidney", SS_FELT_POKE_1, 0.1},
                 {"ventricle", SS_FELT_SLIDE, 0.07},  {"liver-chainmail", SS_FELT_PRESS, 0.07},
                 {"hm1-tissue", SS_FELT_SLIDE, 0.07}, {"liver-chainmail", SS_FELT_SLIDE, 0.25}};
    for (size_t k = 0; k < FULL_IN_LONG_RUN(sizeof cases / sizeof *cases, 4); ++k) {
        const ss_felt_errors e = compare_rates(cases[k].name, cases[k].path, 60.0);
        print_message("%s, %s: p99 %.3f\n", cases[k].name, ss_felt_path_name(cases[k].path), e.p99);
        assert_true(e.p99 <= cases[k].most);
    }
}

/* A tool of 0.2 m that goes some millimetres deep meets the contact where it is soft: the law of
 * what is near had it up to 15 times too stiff, and was further off than no law. */
TEST(a_shallow_touch_is_foretold_better_than_by_holding_the_last_force)
{
    SKIP_WHERE_REPEATED();
    static const char *const name[] = {"hm2", "ed0"};
    for (size_t k = 0; k < FULL_IN_LONG_RUN(2, 1); ++k) {
        const ss_felt_errors local = compare_runs(name[k], SS_FELT_POKE_1, 60.0, false);
        const ss_felt_errors hold = compare_runs(name[k], SS_FELT_POKE_1, 60.0, true);
        print_message("%s: p99 %.3f, held %.3f\n", name[k], local.p99, hold.p99);
        assert_true(local.p99 <= hold.p99);
    }
}

/* What real time plans is what softsim-run, lockstep and reports have. */
TEST(what_is_planned_does_not_depend_on_a_clock)
{
    static const char *const mode[] = {"", "--lockstep"};
    static char plan[2][16384];
    for (int i = 0; i < 2; ++i) {
        char command[8192];
        snprintf(command, sizeof command,
                 BIN_DIR "/softsimd --explain --json %s --set simulation.rate_hz=60 " SOURCE_DIR
                         "/server/scenes/kidney.yaml 2>%s",
                 mode[i], in_folder("err"));
        FILE *out = popen(command, "r");
        assert_non_null(out);
        const size_t size = fread(plan[i], 1, sizeof plan[i] - 1, out);
        assert_in_range(size, 1, sizeof plan[i] - 2);
        assert_int_equal(pclose(out), 0);
    }
    assert_string_equal(plan[0], plan[1]);
}

TEST(wrong_arguments_are_named)
{
    static const char *const wrong[] = {"--scene a/b.yaml --scene b.yaml",
                                        "--rates 5",
                                        "--rates 60,,90",
                                        "--rates x",
                                        "--rates 2000",
                                        "--delays-ms 1.5",
                                        "--delays-ms -1",
                                        "--delays-ms 21",
                                        "--jobs 0"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        char text[512] = "", option[64];
        assert_int_equal(run(wrong[k]), 2);
        FILE *file = fopen(in_folder("err"), "r");
        assert_non_null(file);
        assert_non_null(fgets(text, sizeof text, file));
        snprintf(option, sizeof option, "%.*s", (int)strcspn(wrong[k], " "), wrong[k]);
        assert_non_null(strstr(text, option));
        fclose(file);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
