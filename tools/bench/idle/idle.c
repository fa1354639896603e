/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench idle: what a server costs while nothing happens. softsimd is started on each scene
 * and measured three times: idle (no client has ever come), free (a probe circles in the air) and
 * resting (a probe has pressed the tissue and stands still). CPU is that of the server's threads,
 * from /proc/PID/task, in per cent of one core; a bare 1 kHz loop runs in this process at the same
 * time. The first seconds of each are left out: a body sleeps after a second at rest.
 */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/bench.h"
#include "bench/core/child.h"
#include "bench/core/report.h"
#include "bench/idle/idle_hand.h"
#include "case/scratch.h"
#include "process.h"
#include "rt/args.h"
#include "rt/clock.h"

enum {
    PATH_SIZE = 4096,
    MAX_SCENES = 64,
    PHASES = 3,
    THREADS = 5,
    NAME_SIZE = 64,
    NUMBERS = THREADS + 8
};
static const char *const phase_name[PHASES] = {"idle", "free", "resting"};
static const char *const thread_name[THREADS] = {"net", "simulation", "haptic", "publish", "main"};
static const double settle_s[PHASES] = {3.0, 3.0, 8.0};
static const double ready_timeout_s = 120.0, surface_timeout_s = 15.0, grace_s = 10.0;

typedef struct row {
    char scene[NAME_SIZE];
    int phase;
    double seconds, cpu, thread[THREADS], bare; /* per cent of one core */
    double bytes_per_s, rest_bytes_per_s;       /* on the wire; beyond rounds, poses and forces */
    double force;                               /* N */
    double chosen_hz, slowest_hz, yardstick;    /* the rate of the simulation */
    softsim_verdict verdict;                    /* the worst */
    int32_t active_nodes;
    const char *note;
} row;

typedef struct report {
    const char *out, *lcm_url;
    double seconds;
    ss_arg_list scenes;
    char folder[SS_SCRATCH_PATH];
    char path[MAX_SCENES][PATH_SIZE];
    int32_t scene_count, row_count;
    row rows[MAX_SCENES * PHASES];
} report;

/* ---- CPU of the server ---- */

typedef struct cpu_times {
    int64_t at_ns;
    double thread[THREADS]; /* s */
} cpu_times;

/* Threads by name; what has none of ours is main. */
static int thread_of(const char *folder)
{
    char path[PATH_SIZE + 64], name[NAME_SIZE] = "";
    snprintf(path, sizeof path, "%s/comm", folder);
    FILE *file = fopen(path, "re");
    if (file != NULL) {
        (void)!fscanf(file, "%63s", name);
        fclose(file);
    }
    int found = THREADS - 1;
    for (int t = 0; t < THREADS; ++t) {
        found = strcmp(name, thread_name[t]) == 0 ? t : found;
    }
    return found;
}

static cpu_times read_cpu(pid_t pid)
{
    cpu_times times = {.at_ns = ss_clock_now_ns()};
    char folder[64];
    snprintf(folder, sizeof folder, "/proc/%d/task", (int)pid);
    DIR *list = opendir(folder);
    for (struct dirent *entry; list != NULL && (entry = readdir(list)) != NULL;) {
        char task[PATH_SIZE], path[PATH_SIZE + 64];
        if (entry->d_name[0] == '.') {
            continue;
        }
        snprintf(task, sizeof task, "%s/%.32s", folder, entry->d_name);
        snprintf(path, sizeof path, "%s/schedstat", task); /* ns on a processor, ... */
        long long on_cpu_ns = 0;
        FILE *file = fopen(path, "re");
        if (file != NULL) {
            (void)!fscanf(file, "%lld", &on_cpu_ns);
            fclose(file);
        }
        times.thread[thread_of(task)] += 1e-9 * (double)on_cpu_ns;
    }
    if (list != NULL) {
        closedir(list);
    }
    return times;
}

/* ---- one scene ---- */

static void wait_s(double seconds)
{
    const int64_t end_ns = ss_clock_now_ns() + (int64_t)(1e9 * seconds);
    while (ss_clock_now_ns() < end_ns && !ss_process_is_stopped()) {
        ss_clock_sleep_until(ss_clock_now_ns() + 50000000);
    }
}

/* Measures a phase that has been prepared. */
static void measure(const report *r, const ss_child *server, ss_idle_hand *hand, row *out)
{
    const cpu_times before = read_cpu(server->pid);
    const ss_idle_counts first = ss_idle_hand_read(hand);
    wait_s(r->seconds);
    const cpu_times after = read_cpu(server->pid);
    const ss_idle_counts last = ss_idle_hand_read(hand);
    out->seconds = 1e-9 * (double)(after.at_ns - before.at_ns);
    for (int t = 0; t < THREADS; ++t) {
        out->thread[t] = 100.0 * (after.thread[t] - before.thread[t]) / out->seconds;
        out->cpu += out->thread[t];
    }
    out->bare = 1e-7 * (double)(last.bare_cpu_ns - first.bare_cpu_ns) / out->seconds;
    const int64_t bytes = last.bytes - first.bytes;
    out->bytes_per_s = (double)bytes / out->seconds;
    out->rest_bytes_per_s = (double)(bytes - (last.round_bytes - first.round_bytes)) / out->seconds;
    out->force = last.force;
    out->active_nodes = last.active_nodes;
    out->chosen_hz = last.chosen_hz;
    out->slowest_hz = last.slowest_hz;
    out->yardstick = last.yardstick;
    out->verdict = (softsim_verdict)last.worst_verdict;
}

static bool wait_for_surface(ss_idle_hand *hand)
{
    const int64_t end_ns = ss_clock_now_ns() + (int64_t)(1e9 * surface_timeout_s);
    while (!ss_idle_hand_read(hand).has_surface && ss_clock_now_ns() < end_ns &&
           !ss_process_is_stopped()) {
        wait_s(0.1);
    }
    return ss_idle_hand_read(hand).has_surface;
}

static void measure_phases(report *r, const char *name, const ss_child *server, ss_idle_hand *hand)
{
    static const ss_idle_way way[PHASES] = {SS_IDLE_NONE, SS_IDLE_AIR, SS_IDLE_PRESS};
    for (int phase = 0; phase < PHASES && !ss_process_is_stopped(); ++phase) {
        row *out = &r->rows[r->row_count++];
        *out = (row){.phase = phase, .note = ""};
        snprintf(out->scene, sizeof out->scene, "%.60s", name);
        if (phase > 0 && !wait_for_surface(hand)) {
            out->note = "no tool, or no surface to touch";
            continue;
        }
        ss_idle_hand_go(hand, way[phase]);
        const int64_t end_ns = ss_clock_now_ns() + 12000000000;
        while (phase == 2 && !ss_idle_hand_read(hand).is_still && ss_clock_now_ns() < end_ns &&
               !ss_process_is_stopped()) {
            wait_s(0.1);
        }
        if (phase == 2 && !ss_idle_hand_read(hand).is_still) {
            out->note = "nothing resists with 0.3 N there";
        }
        wait_s(settle_s[phase]);
        measure(r, server, hand, out);
        printf(
            "%-22s %-8s %6.2f %% (bare loop %.2f %%)  net %.2f simulation %.2f haptic %.2f publish "
            "%.2f main %.2f; %.0f B/s, %.0f beyond rounds; %.3g N, %d nodes active; %.4g Hz "
            "chosen, "
            "%.4g reached, cost ratio %.2f, %s %s\n",
            name, phase_name[phase], out->cpu, out->bare, out->thread[0], out->thread[1],
            out->thread[2], out->thread[3], out->thread[4], out->bytes_per_s, out->rest_bytes_per_s,
            out->force, out->active_nodes, out->chosen_hz, out->slowest_hz, out->yardstick,
            softsim_verdict_name(out->verdict), out->note);
        fflush(stdout);
    }
}

static softsim_status run_scene(report *r, int32_t index, softsim_error *error)
{
    char bin[PATH_SIZE], program[PATH_SIZE + 16], prefix[32], log[PATH_SIZE];
    const char *slash = strrchr(r->path[index], '/');
    const char *name = slash != NULL ? slash + 1 : r->path[index];
    if (!ss_child_own_folder(bin, sizeof bin)) {
        snprintf(bin, sizeof bin, ".");
    }
    snprintf(program, sizeof program, "%s/softsimd", bin);
    snprintf(prefix, sizeof prefix, "IDLE_%d_%d", (int)getpid(), index);
    snprintf(log, sizeof log, "%s/softsimd.log", r->folder);
    const char *argv[8] = {program, r->path[index], "--prefix", prefix};
    if (r->lcm_url != NULL) {
        argv[4] = "--lcm-url";
        argv[5] = r->lcm_url;
    }
    const ss_child_plan plan = {
        .name = "softsimd", .argv = argv, .err_path = log, .has_pipe = true};
    ss_child server;
    softsim_status status = ss_child_start(&server, &plan, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_idle_hand *hand = NULL;
    if (!ss_child_wait_text(&server, "softsimd: ready", ready_timeout_s)) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status, "%s: softsimd did not get ready", r->path[index]);
    } else {
        status = ss_idle_hand_start(r->lcm_url, prefix, &hand, error);
    }
    if (status == SOFTSIM_OK) {
        measure_phases(r, name, &server, hand);
    }
    ss_idle_hand_stop(&hand);
    (void)ss_child_stop(&server, grace_s);
    return status;
}

/* ---- choice of scenes ---- */

static int compare(const void *a, const void *b)
{
    return strcmp(a, b);
}

/* All bundled ones. */
static bool list_bundled(void *context, const char *folder)
{
    report *r = context;
    DIR *list = opendir(folder);
    for (struct dirent *entry; list != NULL && (entry = readdir(list)) != NULL;) {
        const char *dot = strrchr(entry->d_name, '.');
        if (dot != NULL && strcmp(dot, ".yaml") == 0 && r->scene_count < MAX_SCENES - 1) {
            snprintf(r->path[r->scene_count++], PATH_SIZE, "%.3800s/%.200s", folder, entry->d_name);
        }
    }
    if (list != NULL) {
        closedir(list);
    }
    qsort(r->path, (size_t)r->scene_count, sizeof r->path[0], compare);
    return r->scene_count > 0;
}

/* A block of about 20,000 tetrahedra for `fem`. */
static void add_block(report *r)
{
    char bin[PATH_SIZE], program[PATH_SIZE + 16], mesh[PATH_SIZE], path[PATH_SIZE];
    (void)ss_child_own_folder(bin, sizeof bin);
    snprintf(program, sizeof program, "%s/softsim-mesh", bin);
    snprintf(mesh, sizeof mesh, "%s/block.msh", r->folder);
    snprintf(path, sizeof path, "%s/fem-20k.yaml", r->folder);
    const char *const argv[] = {program,     "generate", "block",    "--tetrahedra",
                                "--size-mm", "80,80,40", "--points", "4000",
                                "--out",     mesh,       NULL};
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv};
    FILE *file = ss_child_run(&plan, ready_timeout_s) == 0 ? fopen(path, "we") : NULL;
    if (file != NULL) {
        fputs("softsim: 1\nobject: {mesh: block.msh, units: mm, fixed: [{group: bottom}]}\n"
              "model: {name: fem, youngs_modulus_pa: 10000, poisson_ratio: 0.45, density_kg_m3: "
              "1060, mass_damping_per_s: 30}\n"
              "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n",
              file);
        fclose(file);
        snprintf(r->path[r->scene_count++], PATH_SIZE, "%s", path);
    }
}

static void choose_scenes(report *r)
{
    static const char *const place[] = {"server/scenes", "share/softsim/scenes", NULL};
    for (int32_t i = 0; i < r->scenes.count && i < MAX_SCENES; ++i) {
        snprintf(r->path[r->scene_count++], PATH_SIZE, "%.4000s", r->scenes.value[i]);
    }
    if (r->scene_count == 0) {
        ss_child_look_above(place, list_bundled, r);
        add_block(r);
    }
}

/* ---- the report ---- */

static void list_numbers(const row *out, double number[NUMBERS])
{
    number[0] = out->cpu;
    number[1] = out->bare;
    memcpy(number + 2, out->thread, sizeof out->thread);
    number[THREADS + 2] = out->bytes_per_s;
    number[THREADS + 3] = out->rest_bytes_per_s;
    number[THREADS + 4] = out->force;
    number[THREADS + 5] = out->chosen_hz;
    number[THREADS + 6] = out->slowest_hz;
    number[THREADS + 7] = out->yardstick;
}

static softsim_status write_csv(const report *r, softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_report_csv_open(
        &csv, r->out, "idle",
        "scene,phase,seconds,cpu_percent,bare_percent,net_percent,simulation_percent,"
        "haptic_percent,publish_percent,main_percent,bytes_per_s,beyond_rounds_bytes_per_s,force_n,"
        "chosen_rate_hz,slowest_rate_hz,yardstick,active_nodes,verdict,note",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *out = &r->rows[i];
        double number[NUMBERS];
        list_numbers(out, number);
        fprintf(csv.file, "%s,%s,%.3g", out->scene, phase_name[out->phase], out->seconds);
        for (int k = 0; k < NUMBERS; ++k) {
            fprintf(csv.file, ",%.4g", number[k]);
        }
        fprintf(csv.file, ",%d,%s,", out->active_nodes, softsim_verdict_name(out->verdict));
        ss_csv_text(csv.file, out->note);
        fputc('\n', csv.file);
    }
    return ss_output_commit(&csv, error);
}

static softsim_status write_page(const report *r, softsim_error *error)
{
    static const char *const head[] = {
        "scene",     "phase",      "CPU %",      "bare %", "net",     "simulation",
        "haptic",    "publish",    "main",       "B/s",    "beyond",  "N",
        "chosen Hz", "slowest Hz", "cost ratio", "active", "verdict", "note"};
    ss_page page;
    ss_yardstick yardstick;
    softsim_status status = ss_page_open(&page, r->out, "idle", "softsim: idle", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(
        &page,
        "What a server costs while nothing happens, %.3g s each: idle (no client ever "
        "came), free (a probe circles in the air at 1 kHz), resting (it has pressed with "
        "0.3 N and stands still). Per cent of one core, whole and by thread, beside a bare "
        "1 kHz loop of the same time. Bytes: of messages on the wire; beyond: what is "
        "neither status, scene, topology, pose nor force. The rate that the server chose, the "
        "slowest of "
        "a second, and what a step took at start over what was counted.",
        r->seconds);
    ss_page_table_begin(&page, 18, head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *out = &r->rows[i];
        double number[NUMBERS];
        list_numbers(out, number);
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", out->scene);
        ss_row_add(&cells, "%s", phase_name[out->phase]);
        for (int k = 0; k < NUMBERS; ++k) {
            ss_row_add(&cells, "%.3g", number[k]);
        }
        ss_row_add(&cells, "%d", out->active_nodes);
        ss_row_add(&cells, "%s", softsim_verdict_name(out->verdict));
        ss_row_add(&cells, "%s", out->note);
        ss_page_table_row(&page, cells.count, cells.cell);
    }
    ss_page_table_end(&page);
    ss_page_link(&page, "idle.csv");
    ss_yardstick_measure(&yardstick);
    ss_page_yardstick(&page, &yardstick);
    status = ss_page_close(&page, error);
    ss_page_abandon(&page);
    return status;
}

static int run_report(int argc, char **argv)
{
    static report r = {.out = "idle-report", .seconds = 20.0};
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_arg rows[] = {
        SS_LIST("--scene", &r.scenes, "S.yaml",
                "to measure, again and again (all bundled ones, and fem on 20,000 tetrahedra)"),
        {"--seconds", SS_ARG_NUMBER, &r.seconds, 1, 3600, "S", "measured, each (20)"},
        SS_TEXT("--out", &r.out, "DIR", "for the report (idle-report)"),
        SS_ARG_LCM_URL(&r.lcm_url),
    };
    const ss_args_result parsed = SS_ARGS_OPTIONS(
        argc, argv, "[options]", "Measures a server while nothing happens.", rows, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    softsim_status status = ss_report_begin(r.out, r.folder, &error);
    if (status == SOFTSIM_OK) {
        choose_scenes(&r);
    }
    for (int32_t i = 0; status == SOFTSIM_OK && i < r.scene_count && !ss_process_is_stopped();
         ++i) {
        status = run_scene(&r, i, &error);
    }
    if (status == SOFTSIM_OK && ss_process_is_stopped()) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(&error, status, "stopped before the end; nothing is reported");
    }
    status = status == SOFTSIM_OK ? write_csv(&r, &error) : status;
    status = status == SOFTSIM_OK ? write_page(&r, &error) : status;
    if (status == SOFTSIM_OK) {
        printf("%s/idle.html\n", r.out);
    }
    ss_scratch_remove(r.folder);
    return ss_args_finish(argv[0], status, &error);
}

const ss_report_class ss_report_idle = {
    .name = "idle", .about = "CPU and bytes of a server while nothing happens", .run = run_report};
