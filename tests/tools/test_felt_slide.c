/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench felt --slide: ways keep their depth over plane and bent bodies, waves and steps
 * that are put into a force are found with their size, and the kidney is smooth and forgets.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "bench/felt/slide.h"
#include "common/effort.h"
#include "common/folder_fixture.h"
#include "common/load_fixture.h"
#include "rt/vec.h"
#include "world/world.h"

/* ---- ways ---- */

/* A grid that is held in boxes, with a ball of 8 mm. */
static ss_scene *load_grid(const char *grid, const char *fixed_m)
{
    FILE *file = open_file("grid.yaml");
    fprintf(file,
            "softsim: 1\n"
            "object: {grid: {%s}, units: m, fixed: [%s]}\n"
            "model: {name: cnn-energy, modulus_j: 5, area_density_kg_m2: 11.5,\n"
            "        damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 50000}\n"
            "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n",
            grid, fixed_m);
    assert_int_equal(fclose(file), 0);
    return load(in_folder("grid.yaml"));
}

TEST(a_way_over_a_plane_is_straight_and_level)
{
    ss_scene *scene = load_grid("plane: {rows: 20, columns: 40, width_m: 0.2, height_m: 0.1}",
                                "{box_m: [[-1, -1, -1], [1, -0.049, 1]]}, "
                                "{box_m: [[-1, 0.049, -1], [1, 1, 1]]}");
    ss_felt_place place;
    assert_true(ss_felt_find_place(scene, &place));
    for (int32_t direction = 0; direction < SS_WAY_DIRECTIONS; ++direction) {
        ss_way way;
        double chord[3], x[3], middle[3];
        assert_true(ss_way_find(scene, &place, direction, &way));
        ss_sub3(chord, way.point[SS_WAY_POINTS - 1], way.point[0]);
        assert_true(fabs(ss_norm3(chord) - way.length_m) < 1e-9);
        assert_true(fabs(way.length_m - 0.05) < 1e-9);
        const double cosine = fabs(ss_dot3(chord, place.along)) / way.length_m;
        assert_true(fabs(cosine - fabs(cos(direction * M_PI / 3.0))) < 1e-9);
        ss_way_at(&way, 0.5 * way.length_m, middle);
        ss_sub3(x, middle, place.point);
        /* A radius above the surface, half the place's depth in. */
        ss_madd3(x, x, -(place.reach_m - 0.5 * place.depth_m), place.normal);
        assert_true(ss_norm3(x) < 1e-9);
    }
    ss_scene_destroy(&scene);
}

/* The chords of a tube's triangles lie inside it by up to r (1 - cos(pi / 48)) = 0.21 mm. */
TEST(a_way_round_a_tube_is_round)
{
    ss_scene *scene = load_grid("cylinder: {rows: 31, columns: 48, radius_m: 0.1, length_m: 0.4}",
                                "{box_m: [[-1, -1, -1], [-0.05, 1, 1]]}");
    ss_felt_place place;
    assert_true(ss_felt_find_place(scene, &place));
    double low = INFINITY, high = -INFINITY;
    for (int32_t direction = 0; direction < SS_WAY_DIRECTIONS; ++direction) {
        ss_way way;
        assert_true(ss_way_find(scene, &place, direction, &way));
        assert_true(way.length_m > 0.045);
        for (int32_t k = 0; k < SS_WAY_POINTS; ++k) {
            const double r = hypot(way.point[k][0], way.point[k][1]);
            low = fmin(low, r);
            high = fmax(high, r);
        }
    }
    const double wanted = 0.1 + place.reach_m - 0.5 * place.depth_m;
    assert_true(high <= wanted + 1e-6);
    assert_true(low >= wanted - 0.22e-3);
    ss_scene_destroy(&scene);
}

/* ---- figures ---- */

enum { SAMPLES = 800 };
static const double length_m = 0.04, edge_m = 0.005;

/* A force of 2 N that grows by 0.3 N over the way, as a parabola, along z; `wave` N of x or z at
 * `wave_m`, and a step of `step_n` half-way. */
static void make_pass(double scale, double wave_n, double wave_m, int axis, double step_n,
                      bool is_back, double *way, double (*force)[3])
{
    for (int32_t k = 0; k < SAMPLES; ++k) {
        const int32_t at = is_back ? SAMPLES - 1 - k : k;
        const double share = at / (SAMPLES - 1.0);
        way[k] = share * length_m;
        ss_set3(force[k], 0.0, 0.0, scale * (1.85 + 0.9 * share * share));
        force[k][axis] += wave_n * sin(2.0 * M_PI * way[k] / wave_m);
        force[k][2] += share > 0.5 ? step_n : 0.0;
    }
}

static ss_way_figures judge(double wave_n, double wave_m, int axis, double step_n,
                            double back_scale)
{
    static double way[2][SAMPLES], force[2][SAMPLES][3];
    ss_way_figures figures;
    make_pass(1.0, wave_n, wave_m, axis, step_n, false, way[0], force[0]);
    make_pass(back_scale, wave_n, wave_m, axis, step_n, true, way[1], force[1]);
    const ss_way_pass forward = {SAMPLES, way[0], (const double(*)[3])force[0]};
    const ss_way_pass back = {SAMPLES, way[1], (const double(*)[3])force[1]};
    assert_true(ss_way_judge(&forward, &back, edge_m, &figures));
    return figures;
}

TEST(a_smooth_force_has_no_ripple)
{
    const ss_way_figures f = judge(0.0, 1.0, 2, 0.0, 1.0);
    assert_true(fabs(f.mean_n - 2.15) < 1e-3); /* 1.85 + 0.9 / 3 */
    assert_true(f.ripple < 1e-12 && f.tilt < 1e-12 && f.loop < 1e-12);
    /* The steepest change of the parabola: 1.8 N over the way. */
    assert_true(fabs(f.step - 1.8 / (SAMPLES - 1.0) / f.mean_n) < 1e-5);
    assert_true(f.jump < 1e-5);
}

TEST(a_wave_at_the_meshs_scale_is_found_with_its_amplitude)
{
    const ss_way_figures along = judge(0.0645, edge_m, 2, 0.0, 1.0);
    assert_true(fabs(along.ripple - 0.03) < 0.0015); /* 0.0645 / 2.15 */
    assert_true(along.tilt < 1e-12);
    const ss_way_figures across = judge(0.0645, edge_m, 0, 0.0, 1.0);
    assert_true(fabs(across.ripple - 0.03) < 0.0015);
    assert_true(across.tilt > 0.024 && across.tilt < 0.04); /* 0.0645 of 1.85 to 2.75 */
    /* A body's own shape is none. */
    const ss_way_figures slow = judge(0.0645, 2.0 * length_m, 2, 0.0, 1.0);
    assert_true(slow.ripple < 3e-4);
}

TEST(a_step_is_found_with_its_size)
{
    const ss_way_figures f = judge(0.0, 1.0, 2, 0.043, 1.0);
    const double share = 0.043 / f.mean_n;
    assert_true(fabs(f.jump - share * 10.0 / 11.0) < 1e-4); /* a tenth is its own mean change */
    assert_true(fabs(f.step - share) < 1.0e-3);
}

TEST(forward_and_back_are_told_apart)
{
    const ss_way_figures f = judge(0.0, 1.0, 2, 0.0, 1.05);
    /* 5 % of the largest force, 2.75 N, over the mean of both, 2.15 times 1.025. */
    assert_true(fabs(f.loop - 0.05 * 2.75 / (2.15 * 1.025)) < 1e-3);
}

/* ---- the kidney ---- */

TEST(the_kidney_is_smooth_and_forgets)
{
    SKIP_WHERE_REPEATED();
    static const char path[] = SOURCE_DIR "/server/scenes/kidney.yaml";
    const ss_felt_run run = {.rate_hz = 1000.0, .import_program = BIN_DIR "/softsim-import"};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_felt_place place;
    ss_scene *scene = load(path);
    assert_true(ss_felt_find_place(scene, &place));
    for (int32_t d = 0; d < (int32_t)FULL_IN_RELEASE(SS_WAY_DIRECTIONS, 1); ++d) {
        ss_way way;
        ss_slide_stops stops;
        assert_true(ss_way_find(scene, &place, d, &way));
        for (int i = 0; i < 2; ++i) {
            ss_slide_trace trace;
            ss_way_figures f;
            assert_int_equal(
                ss_slide_play(path, &place, &way, &run, i == 0 ? 0.05 : 0.2, &trace, &error),
                SOFTSIM_OK);
            assert_true(ss_way_judge(&trace.forward, &trace.back, way.edge_m, &f));
            print_message("jump %.4f, ripple %.4f\n", f.jump, f.ripple);
            assert_true(f.mean_n > 0.1 && f.jump <= 0.01 && f.ripple <= 0.01);
            ss_slide_trace_fini(&trace);
        }
        assert_int_equal(ss_slide_stop(path, &place, &way, &run, &stops, &error), SOFTSIM_OK);
        for (int32_t k = 0; k < SS_SLIDE_STOPS; ++k) {
            double apart[3];
            ss_sub3(apart, stops.forward[k], stops.back[k]);
            assert_true(ss_norm3(stops.forward[k]) > 0.1);
            assert_true(ss_norm3(apart) <= 0.02 * ss_norm3(stops.forward[k]));
        }
    }
    ss_scene_destroy(&scene);
}

TEST(wrong_speeds_are_named)
{
    static const char *const wrong[] = {"0", "50,", "x", "501"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        char command[8192], text[512] = "";
        snprintf(command, sizeof command, BIN_DIR "/softsim-bench felt --slide --speeds %s 2>%s",
                 wrong[k], in_folder("err"));
        const int status = system(command);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 2);
        FILE *file = fopen(in_folder("err"), "r");
        assert_non_null(file);
        assert_non_null(fgets(text, sizeof text, file));
        assert_non_null(strstr(text, "--speeds"));
        fclose(file);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
