/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench felt: what reaches the hand at a given rate of the simulation. The same path of the
 * tool (path.h) is played to the same scene at several rates and delays of the bus (play.h), in
 * lockstep, and each millisecond's force compared with the same scene's at 1000 Hz without delay;
 * that one with 10,000 Hz, where the haptic loop too is ten times as fast. A press is held on for
 * 3 s beside it: the model's own static solution.
 *
 * A run is one scene and one path, with all its rates: they share the references.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/bench.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/felt/hands.h"
#include "bench/felt/play.h"
#include "bench/felt/scenes.h"
#include "bench/felt/slide.h"
#include "process.h"
#include "rt/args.h"
#include "rt/hash.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "world/world.h"

enum { MAX_RATES = 16, MAX_DELAYS = 8 };
static const double reference_hz = 1000.0, finest_hz = 1e4;
static const double run_timeout_s = 1800.0;
/* Just noticeable, and still usable: shares of the mean force; J. */
static const double good_p99 = 0.07, fair_p99 = 0.2, good_held = 0.02, good_static = 0.03,
                    good_net_j = -1e-3, fair_net_j = -1e-2;
static const char head[] = "scene,model,rate_hz,path,delay_ms,p50,p99,max,impulse_error,peak_error,"
                           "held_error,static_error,net_energy_j,verdict";

typedef struct report {
    const char *out;
    ss_arg_list scene_list, set;
    const char *rates, *delays;
    bool is_quick, is_hands, is_slide;
    int64_t jobs;
    ss_felt_scenes scenes;
    double rate_hz[MAX_RATES];
    int32_t rate_count;
    int32_t delay_ms[MAX_DELAYS];
    int32_t delay_count;
} report;

/* The rate that is run: a step is a whole number of haptic periods. */
static double run_hz(double rate_hz)
{
    return reference_hz / round(reference_hz / rate_hz);
}

/* ---- one run ---- */

typedef struct job {
    const report *r;
    const char *scene;
    char name[SS_FELT_NAME_SIZE];
    const char *model;
    ss_felt_path path;
    ss_felt_place place;
    ss_felt_trace reference;
    double static_n;                /* NAN but for a press */
    ss_felt_trace shown[MAX_RATES]; /* without delay, for the picture */
    FILE *out;
} job;

static softsim_status play(const job *j, double rate_hz, int32_t delay_ms, bool is_held,
                           ss_felt_trace *out, softsim_error *error)
{
    const ss_felt_run run = {.rate_hz = rate_hz,
                             .delay_ms = delay_ms,
                             .is_held = is_held,
                             .set = j->r->set.value,
                             .set_count = j->r->set.count};
    return ss_felt_play(j->scene, &j->place, j->path, &run, out, error);
}

static const char *judge(const ss_felt_errors *e, double static_error, double net_j)
{
    const bool is_held = isnan(e->held) || fabs(e->held) <= good_held;
    const bool is_static = isnan(static_error) || fabs(static_error) <= good_static;
    return isnan(e->p99)                                                       ? "no touch"
           : e->p99 <= good_p99 && is_held && is_static && net_j >= good_net_j ? "good"
           : e->p99 <= fair_p99 && net_j >= fair_net_j                         ? "fair"
                                                                               : "bad";
}

static void put_number(FILE *file, double value)
{
    if (isfinite(value)) {
        fprintf(file, "%.6g,", value);
    } else {
        fputc(',', file);
    }
}

/* `error`: why there is no trace; NULL with one. */
static bool write_row(job *j, double rate_hz, int32_t delay_ms, const ss_felt_trace *trace,
                      const ss_felt_trace *truth, const softsim_error *error)
{
    ss_felt_errors e = {(double)NAN, (double)NAN, (double)NAN,
                        (double)NAN, (double)NAN, (double)NAN};
    char verdict[256];
    double static_error = NAN, net_j = NAN;
    if (trace) {
        if (!ss_felt_compare(trace, truth, &e)) {
            return false;
        }
        static_error = trace->held_n / j->static_n - 1.0;
        net_j = trace->net_j;
        const bool is_told = trace->verdict >= SOFTSIM_VERDICT_DEGRADED;
        snprintf(verdict, sizeof verdict, "%s%s%s%s%s", judge(&e, static_error, net_j),
                 is_told ? "; server " : "", is_told ? softsim_verdict_name(trace->verdict) : "",
                 is_told ? ": " : "", is_told ? trace->reason : "");
    } else {
        ss_plain_reason("refused: ", error->text, verdict, sizeof verdict);
    }
    ss_csv_text(j->out, j->name);
    fprintf(j->out, ",%s,%.6g,%s,%d,", j->model, rate_hz, ss_felt_path_name(j->path), delay_ms);
    const double value[] = {e.p50,  e.p99,  e.largest,    e.impulse,
                            e.peak, e.held, static_error, net_j};
    for (size_t k = 0; k < sizeof value / sizeof *value; ++k) {
        put_number(j->out, value[k]);
    }
    ss_csv_text(j->out, verdict);
    fputc('\n', j->out);
    return true;
}

/* The forces of all rates, for the picture: felt-SCENE-PATH.csv. */
static softsim_status write_forces(const job *j, softsim_error *error)
{
    ss_output csv;
    char name[256], columns[512];
    int used = snprintf(columns, sizeof columns, "time_s,force_1000_n");
    for (int32_t i = 0; i < j->r->rate_count; ++i) {
        used += snprintf(columns + used, sizeof columns - (size_t)used, ",force_%g_n",
                         j->r->rate_hz[i]);
    }
    snprintf(name, sizeof name, "felt-%s-%s", j->name, ss_felt_path_name(j->path));
    const softsim_status status = ss_report_csv_open(&csv, j->r->out, name, columns, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < j->reference.count; ++k) {
        fprintf(csv.file, "%.6g,%.6g", 1e-3 * k, ss_norm3(j->reference.force[k]));
        for (int32_t i = 0; i < j->r->rate_count; ++i) {
            if (k < j->shown[i].count) {
                fprintf(csv.file, ",%.6g", ss_norm3(j->shown[i].force[k]));
            } else {
                fputs(",nan", csv.file);
            }
        }
        fputc('\n', csv.file);
    }
    return ss_output_commit(&csv, error);
}

static softsim_status run_rates(job *j, softsim_error *error)
{
    const report *r = j->r;
    bool is_good = true;
    for (int32_t i = 0; i < r->rate_count && is_good; ++i) {
        for (int32_t d = 0; d < r->delay_count && is_good; ++d) {
            ss_felt_trace trace;
            softsim_error refused = {.status = SOFTSIM_OK};
            const bool is_played =
                play(j, r->rate_hz[i], r->delay_ms[d], false, &trace, &refused) == SOFTSIM_OK;
            is_good = write_row(j, r->rate_hz[i], r->delay_ms[d], is_played ? &trace : NULL,
                                &j->reference, &refused);
            if (is_played && r->delay_ms[d] == 0) {
                j->shown[i] = trace;
            } else if (is_played) {
                ss_felt_trace_fini(&trace);
            }
        }
    }
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
        return SOFTSIM_ERROR_MEMORY;
    }
    return write_forces(j, error);
}

/* The reference's own error, against ten times its rates. */
static softsim_status run_finest(job *j, softsim_error *error)
{
    ss_felt_trace finest;
    softsim_error refused = {.status = SOFTSIM_OK};
    if (play(j, finest_hz, 0, false, &finest, &refused) != SOFTSIM_OK) {
        return SOFTSIM_OK; /* there is no such run */
    }
    const bool is_good = write_row(j, reference_hz, 0, &j->reference, &finest, NULL);
    ss_felt_trace_fini(&finest);
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
    }
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

static softsim_status run_references(job *j, softsim_error *error)
{
    softsim_status status = play(j, reference_hz, 0, false, &j->reference, error);
    j->static_n = NAN;
    if (status == SOFTSIM_OK && j->path == SS_FELT_PRESS) {
        ss_felt_trace held;
        status = play(j, reference_hz, 0, true, &held, error);
        j->static_n = status == SOFTSIM_OK ? held.held_n : NAN;
        if (status == SOFTSIM_OK) {
            ss_felt_trace_fini(&held);
        }
    }
    return status;
}

static softsim_status run_one(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const report *r = context;
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    job j = {.r = r,
             .scene = r->scenes.path[index / SS_FELT_PATHS],
             .path = (ss_felt_path)(index % SS_FELT_PATHS),
             .out = out};
    ss_felt_name(j.scene, j.name);
    softsim_status status = ss_scene_load(j.scene, r->set.value, r->set.count, models, model_count,
                                          NULL, &scene, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    j.model = models[scene->model_index].name;
    if (!ss_felt_find_place(scene, &j.place)) {
        ss_scene_destroy(&scene);
        if (r->scenes.is_bundled) {
            return SOFTSIM_OK;
        }
        status = SOFTSIM_ERROR_SCENE;
        softsim_error_add(error, status, "%s: has no tool, or no surface to press", j.scene);
        return status;
    }
    ss_scene_destroy(&scene);
    status = run_references(&j, error);
    status = status == SOFTSIM_OK ? run_rates(&j, error) : status;
    status = status == SOFTSIM_OK && !r->is_quick ? run_finest(&j, error) : status;
    for (int32_t i = 0; i < r->rate_count; ++i) {
        ss_felt_trace_fini(&j.shown[i]);
    }
    ss_felt_trace_fini(&j.reference);
    return status;
}

/* All that a run depends on. */
static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const report *r = context;
    uint64_t hash = SS_HASH_START;
    hash = ss_hash_bytes(hash, r->rates, strlen(r->rates));
    hash = ss_hash_bytes(hash, r->delays, strlen(r->delays));
    for (int32_t i = 0; i < r->set.count; ++i) {
        hash = ss_hash_bytes(hash, r->set.value[i], strlen(r->set.value[i]));
    }
    snprintf(out, SS_SWEEP_NAME_SIZE, "%.180s,%s,%d,%016llx", r->scenes.path[index / SS_FELT_PATHS],
             ss_felt_path_name((ss_felt_path)(index % SS_FELT_PATHS)), r->is_quick,
             (unsigned long long)hash);
}

/* ---- files ---- */

static softsim_status write_csv(const report *r, const ss_sweep_result *result,
                                softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_report_csv_open(&csv, r->out, "felt", head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < result->count; ++i) {
        if (!result->run[i].is_lost) {
            fputs(result->run[i].text, csv.file);
        }
    }
    return ss_output_commit(&csv, error);
}

static bool has_rows(const ss_sweep_run *run)
{
    return !run->is_lost && run->text[0] != '\0';
}

static softsim_status plot_scene(const report *r, const ss_sweep_result *result, int32_t scene,
                                 ss_page *page, softsim_error *error)
{
    ss_output script;
    char name[SS_FELT_NAME_SIZE], picture[160];
    int32_t panels = 0;
    ss_felt_name(r->scenes.path[scene], name);
    for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
        panels += has_rows(&result->run[scene * SS_FELT_PATHS + p]);
    }
    if (panels == 0) {
        return SOFTSIM_OK;
    }
    snprintf(picture, sizeof picture, "felt-%s", name);
    const softsim_status status =
        ss_plot_open_sized(&script, r->out, picture, 900, 60 + 230 * panels, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset multiplot layout %d,1\nset grid\n"
            "set ylabel 'force, N'\nset key outside right top\n",
            panels);
    for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
        if (!has_rows(&result->run[scene * SS_FELT_PATHS + p])) {
            continue;
        }
        const char *path = ss_felt_path_name((ss_felt_path)p);
        fprintf(script.file,
                "set title '%s'\nset xlabel 'time, s'\nplot 'felt-%s-%s.csv' skip 1 using 1:2 "
                "with lines lw 3 lc rgb '#bbbbbb' title '1000 Hz'",
                path, name, path);
        for (int32_t i = 0; i < r->rate_count; ++i) {
            fprintf(script.file, ", '' skip 1 using 1:%d with lines lc %d title '%.3g Hz'", i + 3,
                    i + 1, run_hz(r->rate_hz[i]));
        }
        fputc('\n', script.file);
    }
    fputs("unset multiplot\n", script.file);
    return ss_page_plot(page, &script, picture,
                        "The force on the hand while the simulation runs at each rate; grey: at "
                        "1000 Hz.",
                        error);
}

/* The rows of one run as a table's. */
static void add_rows(ss_page *page, const char *text)
{
    while (*text != '\0') {
        const size_t length = strcspn(text, "\n");
        char line[1024], *at = line;
        ss_row cells = {.count = 0};
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        for (int column = 0; at != NULL && column < 14; ++column) {
            char *cell = column == 13 ? at : strsep(&at, ",");
            char *end = NULL;
            const double value = strtod(cell, &end);
            const bool is_share = column >= 5 && column <= 11 && end != cell;
            if (is_share) {
                ss_row_add(&cells, "%.1f", 100.0 * value);
            } else if (column == 12 && end != cell) {
                ss_row_add(&cells, "%.2f", 1e3 * value);
            } else if (column > 1) {
                const int from = cell[0] == '"'; /* without the advice */
                const size_t words = strcspn(cell + from, ":");
                const char *more = strchr(cell, ':');
                const size_t end_of_reason = more ? strcspn(more + 1, ":\"") + 1 : 0;
                ss_row_add(&cells, "%.*s", (int)(words + end_of_reason), cell + from);
            }
        }
        ss_page_table_row(page, cells.count, cells.cell);
        text += length + (text[length] == '\n');
    }
}

static softsim_status write_page(const report *r, const ss_sweep_result *result,
                                 softsim_error *error)
{
    static const char *const columns[] = {"rate, Hz", "path",   "delay, ms", "p50",
                                          "p99",      "max",    "impulse",   "peak",
                                          "held",     "static", "net, mJ",   "verdict"};
    ss_page page;
    softsim_status status =
        ss_page_open(&page, r->out, "felt", "softsim: what a hand feels", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(
        &page, "The same path of a tool, played to the same scene while its simulation runs at "
               "each rate, in lockstep and without a clock; the force on the hand a thousand times "
               "a second, compared with that of the simulation at 1000 Hz without delay. p50, p99, "
               "max: the difference over the milliseconds of contact, in %% of the mean force "
               "there; a difference of 7 %% is just noticeable. Impulse and peak: of the force's "
               "size over the whole path. Held: a press of 6 mm (or 15 %% of the body's least "
               "extent), the last 100 ms of 0.4 s. Static: the same against the same press held "
               "for 3 s. Net: the least energy that a contact took from the hand; negative, the "
               "hand was driven. Rows of 1000 Hz without delay are compared with 10,000 Hz. Good: "
               "p99 up to 7 %%, held within 2 %%, static within 3 %%, net from -1 mJ. Fair: 20 %% "
               "and -10 mJ. The device's path is given: how a hand gives way is not in here.");
    for (int32_t s = 0; s < r->scenes.count && status == SOFTSIM_OK; ++s) {
        char name[SS_FELT_NAME_SIZE];
        if (r->scenes.is_bundled && !result->run[s * SS_FELT_PATHS].is_lost &&
            !has_rows(&result->run[s * SS_FELT_PATHS])) {
            continue; /* without a tool */
        }
        ss_felt_name(r->scenes.path[s], name);
        ss_page_heading(&page, name);
        ss_page_table_begin(&page, (int32_t)(sizeof columns / sizeof *columns), columns);
        for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
            const ss_sweep_run *run = &result->run[s * SS_FELT_PATHS + p];
            if (!run->is_lost) {
                add_rows(&page, run->text);
            }
        }
        ss_page_table_end(&page);
        for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
            const ss_sweep_run *run = &result->run[s * SS_FELT_PATHS + p];
            if (run->is_lost) {
                ss_page_text(&page, "%s: not run: %s", ss_felt_path_name((ss_felt_path)p),
                             run->text);
            }
        }
        status = plot_scene(r, result, s, &page, error);
    }
    ss_page_link(&page, "felt.csv");
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

static void print_rows(const report *r, const ss_sweep_result *result)
{
    puts(head);
    for (int32_t i = 0; i < result->count; ++i) {
        if (result->run[i].is_lost) {
            char name[SS_FELT_NAME_SIZE];
            ss_felt_name(r->scenes.path[i / SS_FELT_PATHS], name);
            printf("%s, %s: not run: %s\n", name,
                   ss_felt_path_name((ss_felt_path)(i % SS_FELT_PATHS)), result->run[i].text);
        } else {
            fputs(result->run[i].text, stdout);
        }
    }
    printf("%s/felt.html\n", r->out);
}

/* ---- options ---- */

int32_t ss_felt_numbers(const char *text, double low, double high, int32_t most, double *out)
{
    int32_t count = 0;
    while (count < most) {
        char *end = NULL;
        out[count] = strtod(text, &end);
        if (end == text || !(out[count] >= low && out[count] <= high)) {
            return -1;
        }
        ++count;
        if (*end == '\0') {
            return count;
        }
        if (*end != ',') {
            return -1;
        }
        text = end + 1;
    }
    return -1;
}

static ss_args_result parse_options(int argc, char **argv, report *r, softsim_error *error)
{
    *r = (report){.out = "felt-report", .delays = "0", .jobs = 1};
    const ss_arg rows[] = {
        {"--scene", SS_ARG_LIST, &r->scene_list, 0, 0, "SCENE.yaml",
         "a scene with a tool; may be given again (all bundled scenes)"},
        {"--rates", SS_ARG_STRING, &r->rates, 0, 0, "N,N",
         "of the simulation, Hz, 10 to 1000 (30,60,120,300,500; quick: 60,300)"},
        {"--delays-ms", SS_ARG_STRING, &r->delays, 0, 0, "N,N",
         "of the bus, one way, whole ms, 0 to 20 (0)"},
        {"--set", SS_ARG_LIST, &r->set, 0, 0, "PATH=VALUE",
         "overrides one value of the scenes; may be given again"},
        {"--quick", SS_ARG_FLAG, &r->is_quick, 0, 0, NULL,
         "two rates, and not the run at 10,000 Hz"},
        {"--jobs", SS_ARG_INTEGER, &r->jobs, 1, SS_SWEEP_MAX_JOBS, "N", "runs at a time (1)"},
        {"--out", SS_ARG_STRING, &r->out, 0, 0, "DIR", "for the report (felt-report)"},
        {"--hands", SS_ARG_FLAG, &r->is_hands, 0, 0, NULL,
         "simulated hands in closed loop in place of given paths; more: --hands --help"},
        {"--slide", SS_ARG_FLAG, &r->is_slide, 0, 0, NULL,
         "slides over the surface in place of all paths; more: --slide --help"},
    };
    const ss_args_result result = ss_args_parse(
        argc, argv, "[options]",
        "Measures what a hand feels when the simulation is slower than the haptic loop: press, "
        "poke, tap and slide at several rates and delays, against the same scene at 1000 Hz.\n"
        "felt.csv: p50, p99, max: difference of the force in contact over its mean; impulse_error, "
        "peak_error, held_error, static_error: shares, signed; net_energy_j: least balance of a "
        "contact, negative where the hand was driven. rate_hz is as asked for; the simulation runs "
        "at "
        "the nearest whole number of haptic periods a step, 60 at 58.8 Hz.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    r->rates = r->rates ? r->rates : r->is_quick ? "60,300" : "30,60,120,300,500";
    double delay[MAX_DELAYS];
    r->rate_count = ss_felt_numbers(r->rates, 10.0, reference_hz, MAX_RATES, r->rate_hz);
    r->delay_count = ss_felt_numbers(r->delays, 0.0, 20.0, MAX_DELAYS, delay);
    if (r->rate_count < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--rates: '%s' is not up to %d numbers from 10 to 1000 with commas "
                          "between them",
                          r->rates, MAX_RATES);
    }
    for (int32_t i = 0; i < r->delay_count; ++i) {
        r->delay_ms[i] = (int32_t)delay[i];
        r->delay_count = r->delay_ms[i] == delay[i] ? r->delay_count : -1;
    }
    if (r->delay_count < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--delays-ms: '%s' is not up to %d whole numbers from 0 to 20 with "
                          "commas between them",
                          r->delays, MAX_DELAYS);
    }
    ss_felt_list_scenes(&r->scene_list, &r->scenes, error);
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

static softsim_status sweep_and_report(report *r, int32_t *out_lost, softsim_error *error)
{
    const ss_sweep sweep = {.folder = r->out,
                            .name = "felt",
                            .count = r->scenes.count * SS_FELT_PATHS,
                            .jobs = (int32_t)r->jobs,
                            .timeout_s = run_timeout_s,
                            .context = r,
                            .label = label,
                            .run = run_one};
    ss_sweep_result result;
    softsim_status status = ss_sweep_execute(&sweep, &result, error);
    if (status == SOFTSIM_OK && result.is_complete) {
        status = write_csv(r, &result, error);
        status = status == SOFTSIM_OK ? write_page(r, &result, error) : status;
        if (status == SOFTSIM_OK) {
            print_rows(r, &result);
            ss_sweep_forget(&sweep, &result);
        }
    }
    *out_lost = result.lost;
    ss_sweep_result_fini(&result);
    return status;
}

static int run_report(int argc, char **argv)
{
    for (int k = 1; k < argc; ++k) {
        if (strcmp(argv[k], "--hands") == 0) {
            return ss_felt_hands(argc, argv);
        }
        if (strcmp(argv[k], "--slide") == 0) {
            return ss_felt_slide(argc, argv);
        }
    }
    report *r = calloc(1, sizeof *r);
    softsim_error error = {.status = SOFTSIM_OK};
    int exit_code = EXIT_FAILURE;
    int32_t lost = 0;
    if (r == NULL) {
        fputs("softsim-bench felt: out of memory\n", stderr);
        return exit_code;
    }
    const ss_args_result parsed = parse_options(argc, argv, r, &error);
    if (ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        softsim_status status = ss_report_begin(r->out, NULL, &error);
        status = status == SOFTSIM_OK ? sweep_and_report(r, &lost, &error) : status;
        exit_code = ss_args_finish(argv[0], status, &error);
        exit_code = exit_code == 0 && lost > 0 ? EXIT_FAILURE : exit_code;
    }
    free(r);
    return exit_code;
}

const ss_report_class ss_report_felt = {.name = "felt",
                                        .about =
                                            "what a hand feels at a given rate of the simulation",
                                        .run = run_report};
