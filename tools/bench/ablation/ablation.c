/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench ablation: what each omission of the plan is worth. A scene is run twice, once as
 * it is meant, where the plan leaves something out, and once so that it is needed after all but
 * changes nothing, or next to nothing: time of a tick, bytes held, set-up, and how far apart the
 * results are. Both worlds are made in one process and take turns, so that a machine that drifts
 * drifts for both.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/scaling/block.h"
#include "case/samples.h"
#include "case/scratch.h"
#include "models/model.h"
#include "process.h"
#include "rt/args.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "softsim/softsim.h"

enum { PATH_SIZE = 4352, WARM_TICKS = 100, TURN_TICKS = 50 };
static const double size_m = 0.1, tick_s = 1e-3;
static const double tool_radius_m = 0.01, tool_depth_m = 0.003, tool_speed_m_s = 0.1;
static const double run_timeout_s = 600.0;

/* One omission. Lines of the scene are whole keys; `model_*` stand under `model`. */
typedef struct omission {
    const char *name, *model;
    bool is_surface;
    int32_t points;
    const char *common; /* under `model`: the material */
    const char *model_without, *model_with, *scene_without, *scene_with;
    enum { LOAD, TOOL, NOTHING } act;
} omission;

#define CNN_SURFACE                                                                                \
    "  modulus_j: 5\n  pretension_j: 0.5\n  enclosed_bulk_pa: 2000\n"                              \
    "  area_density_kg_m2: 11.5\n  damping_n_s_per_m3: 1725\n"                                     \
    "  rest_stiffness_n_per_m3: 5.0e+4\n"
#define CNN_VOLUME                                                                                 \
    "  domain: volume\n  modulus_j: 5\n  density_kg_m3: 1000\n  damping_n_s_per_m4: 1.5e+5\n"      \
    "  rest_stiffness_n_per_m4: 4.3e+6\n"
#define SOLID                                                                                      \
    "  youngs_modulus_pa: 1.0e+4\n  poisson_ratio: 0.4\n  density_kg_m3: 1000\n"                   \
    "  mass_damping_per_s: 60\n"
#define SPHERE    "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 10}}}]}\n"
#define CONVEX    "contact: {tools: [{probe: 0, shape: {convex: {file: ball.obj, units: mm}}}]}\n"
#define PUBLISHER "publish: {mesh_rate_hz: 60}\n"
#define SILENT    "publish: {mesh_rate_hz: 0}\n"

static const omission omissions[] = {
    {"mesh publisher", "cnn-energy", true, 5000, CNN_SURFACE, "", "", SILENT, PUBLISHER, LOAD},
    {"arrays of anisotropy", "cnn-energy", true, 5000, CNN_SURFACE, "  rho: 1\n",
     "  rho_direction: 1\n  rho_across: 1\n  material_direction: [0, 0, 1]\n", SILENT, SILENT,
     LOAD},
    {"saturation", "cnn-energy", true, 2000, CNN_SURFACE, "", "  saturation: 1.0e+12\n", SILENT,
     SILENT, LOAD},
    {"nodes that follow (window)", "cnn-energy", false, 20000, CNN_VOLUME, "",
     "  window_tolerance: 0\n", SILENT, SILENT, LOAD},
    {"columns, without a tool", "cnn-energy", true, 2000, CNN_SURFACE, "", "", SILENT,
     SILENT SPHERE, NOTHING},
    {"convex mesh, with a sphere", "cnn-energy", true, 2000, CNN_SURFACE, "", "", SILENT SPHERE,
     SILENT CONVEX, TOOL},
    {"the network's own time", "cnn-energy", true, 2000, CNN_SURFACE, "",
     "  solver: relaxation\n  relaxation_steps: 100\n", SILENT, SILENT, LOAD},
    {"saturation", "cnn-chainmail", false, 5000, "  link_stiffness_n_per_m: 200\n", "",
     "  saturation_sizes: 1.0e+6\n", SILENT, SILENT, LOAD},
    {"velocity pass", "fem", false, 5000, SOLID, "", "  viscosity_phi_pa_s: 1.0e-9\n", SILENT,
     SILENT, LOAD},
    {"mesh publisher", "fem", false, 5000, SOLID, "", "", SILENT, PUBLISHER, LOAD},
    {"particles at rest", "hybrid", false, 1000,
     SOLID "  layer: {spacing_m: 0.005, thickness_m: 0.005", "}\n",
     ", activate_m: 1.0e-9, deactivate_m: 2.0e-9, max_active: 100000}\n", SILENT, SILENT, LOAD},
};
enum { OMISSIONS = sizeof omissions / sizeof *omissions };

/* What was measured, [0] without and [1] with what the plan leaves out. */
typedef struct figures {
    double tick_us[2], create_ms[2], bytes[2];
    double apart; /* share of the largest displacement */
    char note[200];
} figures;

/* ---- a pair ---- */

typedef struct report {
    const char *out;
    char folder[SS_SCRATCH_PATH];
    int32_t index[OMISSIONS]; /* those whose model is built in */
    int32_t count;
} report;

/* A ball of triangles for the convex tool, mm: as many faces as a file of a user's. */
static bool write_ball(const char *path)
{
    enum { RINGS = 8, AROUND = 16 };
    FILE *file = fopen(path, "we");
    if (file == NULL) {
        return false;
    }
    const double radius = 1e3 * tool_radius_m;
    fprintf(file, "v 0 0 %.9g\nv 0 0 %.9g\n", radius, -radius);
    for (int i = 1; i < RINGS; ++i) {
        const double polar = M_PI * i / RINGS;
        for (int j = 0; j < AROUND; ++j) {
            const double turn = 2.0 * M_PI * j / AROUND;
            fprintf(file, "v %.9g %.9g %.9g\n", radius * sin(polar) * cos(turn),
                    radius * sin(polar) * sin(turn), radius * cos(polar));
        }
    }
    for (int j = 0; j < AROUND; ++j) {
        const int next = (j + 1) % AROUND, last = 3 + (RINGS - 2) * AROUND;
        fprintf(file, "f 1 %d %d\nf 2 %d %d\n", 3 + j, 3 + next, last + next, last + j);
        for (int i = 0; i < RINGS - 2; ++i) {
            const int a = 3 + i * AROUND;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a + j, a + AROUND + j, a + AROUND + next,
                    a + j, a + AROUND + next, a + next);
        }
    }
    return fclose(file) == 0;
}

static softsim_status write_scene(const omission *o, const char *mesh, int32_t node, bool is_with,
                                  const char *path, softsim_error *error)
{
    FILE *file = ss_block_scene(path, mesh, error);
    if (file == NULL) {
        return SOFTSIM_ERROR_FILE;
    }
    fprintf(file, "model:\n  name: %s\n%s%s", o->model, o->common,
            is_with ? o->model_with : o->model_without);
    fprintf(file, "simulation: {rate_hz: 1000, sleep: off}\n%s",
            is_with ? o->scene_with : o->scene_without);
    if (o->act == LOAD) {
        fprintf(file,
                "loads:\n  - {nodes: [%d], force_n: [0, 0, -0.01], from_s: 0, ramp_s: 0.02}\n",
                node);
    }
    if (fclose(file) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be written", path);
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

static softsim_world *create(const char *path, double *out_ms, double *out_bytes,
                             softsim_error *error)
{
    const softsim_config config = softsim_default_config();
    const int64_t before = ss_memory_in_use(), begin_ns = ss_clock_thread_cpu_ns();
    softsim_world *world = softsim_create(path, &config, error);
    *out_ms = 1e-6 * (double)(ss_clock_thread_cpu_ns() - begin_ns);
    *out_bytes = (double)(ss_memory_in_use() - before);
    return world;
}

/* Ticks k, k + 1, ... of one world; a tool comes down onto the top and stays. */
static void tick(softsim_world *world, const omission *o, int32_t first, int32_t count,
                 ss_samples *samples)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel[1] = {0};
    softsim_pose pose = {.sender = 1, .force_seq = -1, .orientation = {1.0, 0.0, 0.0, 0.0}};
    ss_set3(pose.velocity, (double)NAN, (double)NAN, (double)NAN);
    ss_set3(pose.applied_force, (double)NAN, (double)NAN, (double)NAN);
    for (int32_t k = first; k < first + count; ++k) {
        const double touch = 0.5 * size_m + tool_radius_m;
        const double height = touch + tool_depth_m - tool_speed_m_s * tick_s * k;
        ss_set3(pose.position, 0.0, 0.0, fmax(height, touch - tool_depth_m));
        pose.seq = k;
        pose.utime_us = (int64_t)k * 1000;
        const int64_t begin_ns = ss_clock_thread_cpu_ns();
        softsim_tick(world, &pose, channel, o->act == TOOL ? 1 : 0, force);
        ss_samples_add(samples, 1e-3 * (double)(ss_clock_thread_cpu_ns() - begin_ns));
    }
}

static softsim_status no_memory(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
    return SOFTSIM_ERROR_MEMORY;
}

/* The largest distance of the two bodies over the largest displacement; NaN without one. */
static softsim_status measure_distance(softsim_world *const world[2], double *out_apart,
                                       softsim_error *error)
{
    softsim_state state;
    softsim_read(world[0], &state);
    const size_t count = (size_t)state.node_count;
    double(*u)[3] = calloc(2 * count, sizeof *u);
    double apart = 0.0, largest = 0.0;
    if (u == NULL) {
        return no_memory(error);
    }
    softsim_read_nodes(world[0], NULL, u, NULL);
    softsim_read_nodes(world[1], NULL, u + count, NULL);
    for (size_t i = 0; i < count; ++i) {
        double way[3];
        ss_sub3(way, u[i], u[count + i]);
        apart = fmax(apart, ss_norm3(way));
        largest = fmax(largest, ss_norm3(u[i]));
    }
    free(u);
    *out_apart = largest > 0.0 ? apart / largest : (double)NAN;
    return SOFTSIM_OK;
}

/* Both worlds in turns; the first turn warms, the other four are measured. */
static softsim_status compare(const omission *o, softsim_world *const world[2], figures *out,
                              softsim_error *error)
{
    ss_samples samples[2] = {{.value = NULL}}, warm = {.value = NULL};
    softsim_status status = ss_samples_init(&samples[0], 4 * TURN_TICKS) &&
                                    ss_samples_init(&samples[1], 4 * TURN_TICKS) &&
                                    ss_samples_init(&warm, WARM_TICKS)
                                ? SOFTSIM_OK
                                : no_memory(error);
    for (int turn = 0; turn < 5 && status == SOFTSIM_OK; ++turn) {
        for (int w = 0; w < 2; ++w) {
            const int32_t first = turn == 0 ? 1 : 1 + WARM_TICKS + (turn - 1) * TURN_TICKS;
            tick(world[w], o, first, turn == 0 ? WARM_TICKS : TURN_TICKS,
                 turn == 0 ? &warm : &samples[w]);
        }
    }
    for (int w = 0; w < 2; ++w) {
        out->tick_us[w] = ss_samples_quantile(&samples[w], 0.5);
        ss_samples_fini(&samples[w]);
    }
    ss_samples_fini(&warm);
    return status == SOFTSIM_OK ? measure_distance(world, &out->apart, error) : status;
}

static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const report *r = context;
    const omission *o = &omissions[r->index[index]];
    snprintf(out, SS_SWEEP_NAME_SIZE, "%s,%s", o->name, o->model);
}

static softsim_status run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const report *r = context;
    const omission *o = &omissions[r->index[index]];
    figures f = {.apart = (double)NAN};
    softsim_world *world[2] = {NULL, NULL};
    char mesh[64], path[PATH_SIZE];
    softsim_status status = ss_block_mesh(r->folder, o->is_surface, o->points, mesh, error);
    snprintf(path, sizeof path, "%s/ball.obj", r->folder);
    if (status == SOFTSIM_OK && !write_ball(path)) {
        status = SOFTSIM_ERROR_FILE;
    }
    snprintf(path, sizeof path, "%s/%s", r->folder, mesh);
    const int32_t node = status == SOFTSIM_OK ? ss_block_top(path) : -1;
    snprintf(path, sizeof path, "%s/scene.yaml", r->folder);
    for (int w = 0; w < 2 && status == SOFTSIM_OK; ++w) {
        status = write_scene(o, mesh, node, w == 1, path, error);
        world[w] = status == SOFTSIM_OK ? create(path, &f.create_ms[w], &f.bytes[w], error) : NULL;
        status = status == SOFTSIM_OK && world[w] == NULL ? error->status : status;
    }
    status = status == SOFTSIM_OK ? compare(o, world, &f, error) : status;
    if (status == SOFTSIM_OK) {
        fprintf(out, "%.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", f.tick_us[0], f.tick_us[1], f.bytes[0],
                f.bytes[1], f.create_ms[0], f.create_ms[1], f.apart);
    }
    softsim_destroy(&world[0]);
    softsim_destroy(&world[1]);
    return status;
}

/* ---- files ---- */

static void read_figures(const ss_sweep_run *from, figures *out)
{
    *out = (figures){{NAN, NAN}, {NAN, NAN}, {NAN, NAN}, NAN, ""};
    if (from->is_lost || sscanf(from->text, "%lf %lf %lf %lf %lf %lf %lf", &out->tick_us[0],
                                &out->tick_us[1], &out->bytes[0], &out->bytes[1],
                                &out->create_ms[0], &out->create_ms[1], &out->apart) != 7) {
        const char *text = strstr(from->text, "scene.yaml"); /* without the folder */
        text = text != NULL ? text : from->text;
        snprintf(out->note, sizeof out->note, "%.*s", (int)sizeof out->note - 1, text);
    }
}

static softsim_status write_csv(const report *r, const ss_sweep_result *result,
                                softsim_error *error)
{
    ss_output output;
    const softsim_status status = ss_report_csv_open(
        &output, r->out, "ablation",
        "omission,model,points,tick_us_without,tick_us_with,bytes_without,bytes_with,"
        "create_ms_without,create_ms_with,field_difference,note",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < r->count; ++i) {
        const omission *o = &omissions[r->index[i]];
        figures f;
        read_figures(&result->run[i], &f);
        ss_csv_text(output.file, o->name); /* some have a comma */
        fprintf(output.file, ",%s,%d", o->model, o->points);
        const double value[] = {f.tick_us[0],   f.tick_us[1],   f.bytes[0], f.bytes[1],
                                f.create_ms[0], f.create_ms[1], f.apart};
        for (size_t k = 0; k < sizeof value / sizeof *value; ++k) {
            fprintf(output.file, isnan(value[k]) ? "," : ",%.9g", value[k]);
        }
        fputc(',', output.file);
        ss_csv_text(output.file, f.note);
        fputc('\n', output.file);
    }
    return ss_output_commit(&output, error);
}

static softsim_status plot_times(const report *r, const ss_sweep_result *result, ss_page *page,
                                 softsim_error *error)
{
    ss_output script;
    const softsim_status status =
        ss_plot_open_sized(&script, r->out, "ablation", 800, 160 + 34 * r->count, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    fputs("$pairs << EOD\n", file);
    for (int32_t i = 0; i < r->count; ++i) {
        const omission *o = &omissions[r->index[i]];
        figures f;
        read_figures(&result->run[i], &f);
        fprintf(file, "\"%s, %s\" %.6g %.6g\n", o->model, o->name, f.tick_us[1] / f.tick_us[0],
                f.bytes[1] / f.bytes[0]);
    }
    fprintf(file,
            "EOD\nset yrange [%g:-0.6]\nset xrange [0.5:*]\nset logscale x 2\nset grid x\n"
            "set xlabel 'with it, over without it'\nset key outside top center horizontal\n"
            "set style fill solid 1\n"
            "plot $pairs using (($2+1)/2):($0-0.17):(abs($2-1)/2):(0.15):ytic(1) with boxxyerror "
            "lc 1 title 'time of a tick', $pairs using (($3+1)/2):($0+0.17):(abs($3-1)/2):(0.15) "
            "with boxxyerror lc 2 title 'bytes held'\n",
            r->count - 0.4);
    return ss_page_plot(page, &script, "ablation",
                        "What a scene would pay for what its plan leaves out.", error);
}

static softsim_status write_page(const report *r, const ss_sweep_result *result,
                                 softsim_error *error)
{
    static const char *const head[] = {"omission", "model",         "points", "tick without, us",
                                       "with, us", "bytes without", "with",   "create without, ms",
                                       "with, ms", "apart",         "note"};
    ss_page page;
    ss_yardstick yardstick;
    softsim_status status = ss_page_open(&page, r->out, "ablation", "softsim: ablation", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&page,
                 "A cube of 100 mm, held below, one node of the top pushed (or a ball of 10 mm "
                 "pressed 3 mm deep), steps of 1 ms; once as the plan has it, once with what it "
                 "leaves out in use, but so that it changes nothing or next to nothing: equal "
                 "conductances in two directions, a saturation never reached, a viscosity of "
                 "1e-9 Pa s, all nodes stepped. Both take turns in one process; times are medians "
                 "of thread CPU time. Apart: the largest distance of the two bodies over the "
                 "largest displacement. The network's own time with 100 network steps is another "
                 "answer until the network has settled.");
    ss_page_table_begin(&page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->count; ++i) {
        const omission *o = &omissions[r->index[i]];
        ss_row cells = {.count = 0};
        figures f;
        read_figures(&result->run[i], &f);
        ss_row_add(&cells, "%s", o->name);
        ss_row_add(&cells, "%s", o->model);
        ss_row_add(&cells, "%d", o->points);
        const double value[] = {f.tick_us[0],   f.tick_us[1],   f.bytes[0], f.bytes[1],
                                f.create_ms[0], f.create_ms[1], f.apart};
        for (size_t k = 0; k < sizeof value / sizeof *value; ++k) {
            ss_row_add_number(&cells, value[k]);
        }
        ss_row_add(&cells, "%s", f.note);
        ss_page_table_row(&page, cells.count, cells.cell);
    }
    ss_page_table_end(&page);
    status = plot_times(r, result, &page, error);
    ss_yardstick_measure(&yardstick);
    ss_page_link(&page, "ablation.csv");
    ss_page_yardstick(&page, &yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

static void print_rows(const report *r, const ss_sweep_result *result)
{
    printf("%-28s %-14s %10s %10s %12s %12s %9s\n", "left out", "model", "us without", "us with",
           "B without", "B with", "apart");
    for (int32_t i = 0; i < r->count; ++i) {
        const omission *o = &omissions[r->index[i]];
        figures f;
        read_figures(&result->run[i], &f);
        if (f.note[0] != '\0') {
            printf("%-28s %-14s %s\n", o->name, o->model, f.note);
        } else {
            char apart[16] = "-"; /* nothing moves in either */
            if (!isnan(f.apart)) {
                (void)snprintf(apart, sizeof apart, "%.1e", f.apart);
            }
            printf("%-28s %-14s %10.1f %10.1f %12.0f %12.0f %9s\n", o->name, o->model, f.tick_us[0],
                   f.tick_us[1], f.bytes[0], f.bytes[1], apart);
        }
    }
}

/* ---- the report ---- */

static softsim_status write_all(void *context, const ss_sweep_result *result, softsim_error *error)
{
    const report *r = context;
    print_rows(r, result);
    softsim_status status = write_csv(r, result, error);
    status = status == SOFTSIM_OK ? write_page(r, result, error) : status;
    if (status == SOFTSIM_OK) {
        printf("%s/ablation.html\n", r->out);
    }
    return status;
}

static softsim_status measure(report *r, softsim_error *error)
{
    for (int32_t i = 0; i < OMISSIONS; ++i) {
        if (ss_model_find(omissions[i].model) != NULL) {
            r->index[r->count++] = i;
        }
    }
    const ss_sweep sweep = {.folder = r->out,
                            .name = "ablation",
                            .count = r->count,
                            .jobs = 1, /* times would disturb one another */
                            .timeout_s = run_timeout_s,
                            .context = r,
                            .label = label,
                            .run = run};
    int32_t lost = 0; /* a row says so */
    return ss_sweep_and_report(&sweep, write_all, r, &lost, error);
}

static int run_report(int argc, char **argv)
{
    report r = {.out = "ablation-report"};
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_arg rows[] = {
        SS_TEXT("--out", &r.out, "DIR", "for the report (ablation-report)"),
    };
    const ss_args_result parsed =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Measures what the plan leaves out, with and without it.", rows, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    softsim_status status = ss_report_begin(r.out, r.folder, &error);
    if (status == SOFTSIM_OK) {
        status = measure(&r, &error);
    }
    ss_scratch_remove(r.folder);
    return ss_args_finish(argv[0], status, &error);
}

const ss_report_class ss_report_ablation = {.name = "ablation",
                                            .about =
                                                "time and bytes of what a scene's plan leaves out",
                                            .run = run_report};
