/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench felt: what reaches the hand at a given rate of the simulation. The same path of the
 * tool (path.h) is played to the same scene at several rates and delays of the bus (play.h), in
 * lockstep, and each millisecond's force compared with the same scene's at 1000 Hz without delay;
 * that one with 10,000 Hz, where the haptic loop too is ten times as fast. A press is held on for
 * 3 s beside it: the model's own static solution. And with the same rate without the local contact
 * model, forces held from the last result: what the law between steps is worth.
 *
 * What a row has to reach is a goal (goals.h); one that falls short says which it misses and what
 * was measured of the cause: how far 1000 Hz is itself off, in which part of a contact the
 * difference is, how much of the force is the tissue's own motion, how deep the tool sinks in.
 *
 * A run is one scene and one path, with all its rates: they share the references.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/bench.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/felt/goals.h"
#include "bench/felt/hands.h"
#include "bench/felt/play.h"
#include "bench/felt/report.h"
#include "bench/felt/slide.h"
#include "process.h"
#include "rt/args.h"
#include "rt/csv.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "world/world.h"

enum { MAX_RATES = 16, MAX_DELAYS = 8 };
static const double finest_hz = 1e4;
/* Still usable, a share of the mean force; J. */
static const double fair_p99 = 0.2, good_net_j = -1e-3, fair_net_j = -1e-2;
/* A poke or tap is played so many times slower beside, its simulation at a rate so much lower: as
 * many steps on the way. */
static const double slowness = 10.0;
static const char head[] =
    "scene,model,rate_hz,path,delay_ms,p50,p99,max,impulse_error,peak_error,held_error,"
    "static_error,net_energy_j,verdict,p95,hold_p99,touch_ms,penetration,short_of,cause";
enum { HEAD_COLUMNS = 20, SHORT_OF_COLUMN = 18, CELL_SIZE = 256, ROW_SIZE = 2048 };

typedef struct report {
    ss_felt_report base; /* first, as ss_felt_report_run has it */
    const char *rates, *delays;
    bool is_quick, is_hands, is_slide;
    double rate_hz[MAX_RATES];
    int32_t rate_count;
    int32_t delay_ms[MAX_DELAYS];
    int32_t delay_count;
} report;

/* The rate that is run: a step is a whole number of haptic periods. */
static double run_hz(double rate_hz)
{
    return SS_FELT_REFERENCE_HZ / round(SS_FELT_REFERENCE_HZ / rate_hz);
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
    ss_felt_errors own;             /* of the reference, against ten times its rates; or NAN */
    double dynamic_share;           /* of a poke's or tap's force */
    double static_n;                /* NAN but for a press */
    ss_felt_trace shown[MAX_RATES]; /* without delay, for the picture */
    FILE *out;
} job;

static ss_felt_run run_at(const job *j, double rate_hz, int32_t delay_ms)
{
    return (ss_felt_run){.rate_hz = rate_hz,
                         .delay_ms = delay_ms,
                         .set = j->r->base.set.value,
                         .set_count = j->r->base.set.count};
}

static softsim_status play(const job *j, const ss_felt_run *run, ss_felt_trace *out,
                           softsim_error *error)
{
    return ss_felt_play(j->scene, &j->place, j->path, run, out, error);
}

/* Results know of a touch two steps after it. */
static bool compare(const ss_felt_trace *trace, const ss_felt_trace *truth, double rate_hz,
                    ss_felt_errors *out)
{
    const ss_felt_question question = {
        .limit = SS_FELT_GOOD_P99,
        .settle_ms = (int32_t)ceil(2.0 * SS_FELT_REFERENCE_HZ / run_hz(rate_hz))};
    return ss_felt_compare(trace, truth, &question, out);
}

static const char *judge(const ss_felt_errors *e, double static_error, double net_j)
{
    const bool is_held = isnan(e->held) || fabs(e->held) <= SS_FELT_GOOD_HELD;
    const bool is_static = isnan(static_error) || fabs(static_error) <= SS_FELT_GOOD_STATIC;
    return isnan(e->p99)                                                               ? "no touch"
           : e->p99 <= SS_FELT_GOOD_P99 && is_held && is_static && net_j >= good_net_j ? "good"
           : e->p99 <= fair_p99 && net_j >= fair_net_j                                 ? "fair"
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

static void add_text(char *text, size_t size, const char *format, ...)
{
    const size_t used = strlen(text);
    va_list list;
    va_start(list, format);
    if (used > 0 && used + 2 < size) {
        snprintf(text + used, size - used, "; ");
    }
    vsnprintf(text + strlen(text), size - strlen(text), format, list);
    va_end(list);
}

/* What was measured beside a row that falls short. */
static void write_cause(const job *j, const ss_felt_row *r, char *out, size_t size)
{
    const ss_felt_errors *e = &r->e;
    const double step_ms = SS_FELT_REFERENCE_HZ / run_hz(r->rate_hz);
    const double own = j->path == SS_FELT_POKE_3 ? j->own.p95 : j->own.p99;
    const double moving = j->reference.held_n / j->static_n - 1.0;
    out[0] = '\0';
    if (r->penetration > 0.1) {
        add_text(out, size, "the contact is soft beside the working force");
    }
    if (fabs(moving) > SS_FELT_GOOD_STATIC) {
        add_text(out, size, "at 1000 Hz the force is %.0f %% from rest after 0.4 s",
                 100.0 * moving);
    }
    if (own > 0.5 * SS_FELT_GOOD_P99) {
        add_text(out, size, "1000 Hz is itself off by %.0f %%", 100.0 * own);
    }
    if (j->dynamic_share > SS_FELT_GOOD_P99) {
        add_text(out, size,
                 "%.0f %% of the force is the tissue's own motion; it rises in %.0f ms, "
                 "a step is %.0f",
                 100.0 * j->dynamic_share, e->rise_ms, step_ms);
    }
    if (e->p99 > SS_FELT_GOOD_P99 && e->at_touch + e->at_leaving >= 0.0) {
        add_text(out, size,
                 "of what is over 7 %%: %.0f %% in the first two steps of a contact, "
                 "%.0f %% in the last two",
                 100.0 * e->at_touch, 100.0 * e->at_leaving);
    }
    if (fabs(e->touch_ms) > 1.0 && j->path == SS_FELT_TAP) {
        add_text(out, size, "a touch %.0f ms %s", fabs(e->touch_ms),
                 e->touch_ms > 0.0 ? "late" : "early");
    }
}

/* `trace` NULL: there is none, for the reason in `error`. */
static void write_row(const job *j, const ss_felt_row *r, const ss_felt_trace *trace,
                      const softsim_error *error)
{
    const ss_felt_errors *e = &r->e;
    char verdict[CELL_SIZE], cause[2 * CELL_SIZE] = "", missed[CELL_SIZE] = "";
    if (trace) {
        const bool is_told = trace->verdict >= SOFTSIM_VERDICT_DEGRADED;
        snprintf(verdict, sizeof verdict, "%s%s%s%s%s", judge(e, r->static_error, r->net_j),
                 is_told ? "; server " : "", is_told ? softsim_verdict_name(trace->verdict) : "",
                 is_told ? ": " : "", is_told ? trace->reason : "");
    } else {
        ss_plain_reason("refused: ", error->text, verdict, sizeof verdict);
    }
    for (int g = 0; g < SS_FELT_GOALS; ++g) {
        if (ss_felt_has_goal(&ss_felt_goals[g], j->path, r->rate_hz, r->delay_ms) &&
            ss_felt_goals[g].is_missed(r)) {
            add_text(missed, sizeof missed, "%s", ss_felt_goals[g].name);
        }
    }
    if (missed[0] != '\0') {
        write_cause(j, r, cause, sizeof cause);
    }
    ss_csv_text(j->out, j->name);
    fprintf(j->out, ",%s,%.6g,%s,%d,", j->model, r->rate_hz, ss_felt_path_name(j->path),
            r->delay_ms);
    const double value[] = {e->p50,  e->p99,  e->largest,      e->impulse,
                            e->peak, e->held, r->static_error, r->net_j};
    for (size_t k = 0; k < sizeof value / sizeof *value; ++k) {
        put_number(j->out, value[k]);
    }
    ss_csv_text(j->out, verdict);
    fputc(',', j->out);
    const double more[] = {e->p95, r->hold_p99, e->touch_ms, r->penetration};
    for (size_t k = 0; k < sizeof more / sizeof *more; ++k) {
        put_number(j->out, more[k]);
    }
    ss_csv_text(j->out, missed);
    fputc(',', j->out);
    ss_csv_text(j->out, cause);
    fputc('\n', j->out);
}

static ss_felt_row empty_row(double rate_hz, int32_t delay_ms)
{
    const double nan = NAN;
    return (ss_felt_row){.rate_hz = rate_hz,
                         .delay_ms = delay_ms,
                         .e = {nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan},
                         .static_error = nan,
                         .net_j = nan,
                         .hold_p99 = nan,
                         .penetration = nan};
}

/* What `trace` is against `truth`; false when out of memory. */
static bool measure(const job *j, const ss_felt_trace *trace, const ss_felt_trace *truth,
                    ss_felt_row *r)
{
    r->static_error = trace->held_n / j->static_n - 1.0;
    r->net_j = trace->net_j;
    return compare(trace, truth, r->rate_hz, &r->e);
}

/* The same run with forces held from the last result. */
static bool measure_hold(const job *j, ss_felt_row *r)
{
    softsim_error refused = {.status = SOFTSIM_OK};
    ss_felt_run run = run_at(j, r->rate_hz, r->delay_ms);
    ss_felt_trace trace;
    ss_felt_errors e;
    run.is_without_law = true;
    if (play(j, &run, &trace, &refused) != SOFTSIM_OK) {
        return true;
    }
    const bool is_good = compare(&trace, &j->reference, r->rate_hz, &e);
    r->hold_p99 = e.p99;
    ss_felt_trace_fini(&trace);
    return is_good;
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
    const softsim_status status = ss_report_csv_open(&csv, j->r->base.out, name, columns, error);
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

/* One row; its forces are kept for the picture where there is no delay. */
static bool run_rate(job *j, int32_t rate, int32_t delay_ms)
{
    softsim_error refused = {.status = SOFTSIM_OK};
    const double rate_hz = j->r->rate_hz[rate];
    const ss_felt_run run = run_at(j, rate_hz, delay_ms);
    ss_felt_row r = empty_row(rate_hz, delay_ms);
    ss_felt_trace trace;
    if (play(j, &run, &trace, &refused) != SOFTSIM_OK) {
        write_row(j, &r, NULL, &refused);
        return true;
    }
    bool is_good = measure(j, &trace, &j->reference, &r) && measure_hold(j, &r);
    if (j->path == SS_FELT_PRESS && delay_ms == 0) {
        r.penetration = ss_felt_penetration(j->scene, &j->place, &run);
    }
    if (is_good) {
        write_row(j, &r, &trace, NULL);
    }
    if (delay_ms == 0) {
        j->shown[rate] = trace;
    } else {
        ss_felt_trace_fini(&trace);
    }
    return is_good;
}

static softsim_status run_rates(job *j, softsim_error *error)
{
    const report *r = j->r;
    for (int32_t i = 0; i < r->rate_count; ++i) {
        for (int32_t d = 0; d < r->delay_count; ++d) {
            if (!run_rate(j, i, r->delay_ms[d])) {
                return ss_memory_fault(error);
            }
        }
    }
    return write_forces(j, error);
}

/* The reference's own error, against ten times its rates, and how much of its force is not that of
 * a slow hand. */
static softsim_status run_own(job *j, softsim_error *error)
{
    softsim_error refused = {.status = SOFTSIM_OK};
    const ss_felt_run finest = run_at(j, finest_hz, 0);
    ss_felt_run slow = run_at(j, SS_FELT_REFERENCE_HZ / slowness, 0);
    ss_felt_row r = empty_row(SS_FELT_REFERENCE_HZ, 0);
    ss_felt_trace trace;
    slow.slowness = slowness;
    if (play(j, &finest, &trace, &refused) == SOFTSIM_OK) {
        const bool is_good = measure(j, &j->reference, &trace, &r);
        ss_felt_trace_fini(&trace);
        if (!is_good) {
            return ss_memory_fault(error);
        }
        j->own = r.e;
    }
    if (j->path != SS_FELT_PRESS && j->path != SS_FELT_SLIDE &&
        play(j, &slow, &trace, &refused) == SOFTSIM_OK) {
        j->dynamic_share =
            ss_felt_dynamic_share(&trace, slowness, &j->place, j->path, &j->reference);
        ss_felt_trace_fini(&trace);
    }
    if (isfinite(j->own.p99)) {
        write_row(j, &r, &j->reference, NULL);
    }
    return SOFTSIM_OK;
}

static softsim_status run_references(job *j, softsim_error *error)
{
    ss_felt_run run = run_at(j, SS_FELT_REFERENCE_HZ, 0);
    softsim_status status = play(j, &run, &j->reference, error);
    run.is_held = true;
    if (status == SOFTSIM_OK && j->path == SS_FELT_PRESS) {
        ss_felt_trace held;
        status = play(j, &run, &held, error);
        j->static_n = status == SOFTSIM_OK ? held.held_n : NAN;
        if (status == SOFTSIM_OK) {
            ss_felt_trace_fini(&held);
        }
    }
    return status;
}

/* Paths begin at the contact surface where that lies deep within the mesh, as on a coarse mesh of
 * a body in metres: a press of 6 mm would not reach it. */
static void find_touch(job *j)
{
    const ss_felt_run run = run_at(j, SS_FELT_REFERENCE_HZ, 0);
    const double depth_m = ss_felt_touch_depth(j->scene, &j->place, &run);
    if (depth_m > 0.25 * j->place.depth_m) {
        ss_madd3(j->place.point, j->place.point, -depth_m, j->place.normal);
    }
}

static softsim_status run_one(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const report *r = context;
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    job j = {.r = r,
             .scene = r->base.scenes.path[index / SS_FELT_PATHS],
             .path = (ss_felt_path)(index % SS_FELT_PATHS),
             .own = empty_row(SS_FELT_REFERENCE_HZ, 0).e,
             .dynamic_share = NAN,
             .static_n = NAN,
             .out = out};
    ss_felt_name(j.scene, j.name);
    softsim_status status = ss_scene_load(j.scene, r->base.set.value, r->base.set.count, models,
                                          model_count, NULL, &scene, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    j.model = models[scene->model_index].name;
    if (!ss_felt_find_place(scene, &j.place)) {
        ss_scene_destroy(&scene);
        if (r->base.scenes.is_bundled) {
            return SOFTSIM_OK;
        }
        status = SOFTSIM_ERROR_SCENE;
        softsim_error_add(error, status, "%s: has no tool, or no surface to press", j.scene);
        return status;
    }
    ss_scene_destroy(&scene);
    find_touch(&j);
    status = run_references(&j, error);
    status = status == SOFTSIM_OK && !r->is_quick ? run_own(&j, error) : status;
    status = status == SOFTSIM_OK ? run_rates(&j, error) : status;
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
    for (int32_t i = 0; i < r->base.set.count; ++i) {
        hash = ss_hash_bytes(hash, r->base.set.value[i], strlen(r->base.set.value[i]));
    }
    snprintf(out, SS_SWEEP_NAME_SIZE, "%.180s,%s,%d,%016llx",
             r->base.scenes.path[index / SS_FELT_PATHS],
             ss_felt_path_name((ss_felt_path)(index % SS_FELT_PATHS)), r->is_quick,
             (unsigned long long)hash);
}

/* ---- files ---- */

static softsim_status plot_scene(const report *r, const ss_sweep_result *result, int32_t scene,
                                 ss_page *page, softsim_error *error)
{
    ss_output script;
    char name[SS_FELT_NAME_SIZE], picture[160];
    int32_t panels = 0;
    ss_felt_name(r->base.scenes.path[scene], name);
    for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
        panels += ss_felt_has_rows(&result->run[scene * SS_FELT_PATHS + p]);
    }
    if (panels == 0) {
        return SOFTSIM_OK;
    }
    snprintf(picture, sizeof picture, "felt-%s", name);
    const softsim_status status =
        ss_felt_plot_open(&r->base, &script, picture, panels, 230, "", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
        if (!ss_felt_has_rows(&result->run[scene * SS_FELT_PATHS + p])) {
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

/* The next line of `text` cut into cells, in `line`; NULL at its end. */
static const char *next_row(const char *text, char line[ROW_SIZE], char *cell[HEAD_COLUMNS])
{
    const size_t length = strcspn(text, "\n");
    if (*text == '\0') {
        return NULL;
    }
    snprintf(line, ROW_SIZE, "%.*s", (int)length, text);
    for (int32_t k = ss_csv_split(line, cell, HEAD_COLUMNS); k < HEAD_COLUMNS; ++k) {
        cell[k] = line + strlen(line);
    }
    return text + length + (text[length] == '\n');
}

/* A number of the CSV times `scale`, with `digits` after the point; empty where there is none. */
static void add_scaled(ss_row *cells, const char *cell, double scale, int digits)
{
    double value;
    if (ss_csv_number(cell, &value)) {
        ss_row_add(cells, "%.*f", digits, scale * value);
    } else {
        ss_row_add(cells, "%s", "");
    }
}

/* The rows of one run as a table's. */
static void add_rows(ss_page *page, const char *text)
{
    static const int shares[] = {5, 14, 6, 15, 8, 9, 10, 11};
    char line[ROW_SIZE], *cell[HEAD_COLUMNS];
    while ((text = next_row(text, line, cell)) != NULL) {
        ss_row cells = {.count = 0};
        for (int k = 2; k < 5; ++k) {
            ss_row_add(&cells, "%s", cell[k]);
        }
        for (size_t k = 0; k < sizeof shares / sizeof *shares; ++k) {
            add_scaled(&cells, cell[shares[k]], 100.0, 1);
        }
        ss_row_add(&cells, "%s", cell[16]);
        add_scaled(&cells, cell[17], 1.0, 2);
        add_scaled(&cells, cell[12], 1e3, 2);
        const int verdict = (int)strcspn(cell[13], ":"); /* without the advice */
        ss_row_add(&cells, "%.*s%s%s%s%s", verdict, cell[13], *cell[18] ? "; short of " : "",
                   cell[18], *cell[19] ? ": " : "", cell[19]);
        ss_page_table_row(page, cells.count, cells.cell);
    }
}

/* How many of the rows that have a goal reach it. */
static void count_goal(const ss_sweep_result *result, const ss_felt_goal *g, int32_t *out_rows,
                       int32_t *out_reached)
{
    *out_rows = *out_reached = 0;
    for (int32_t i = 0; i < result->count; ++i) {
        const char *text = result->run[i].is_lost ? "" : result->run[i].text;
        char line[ROW_SIZE], *cell[HEAD_COLUMNS];
        while ((text = next_row(text, line, cell)) != NULL) {
            double p99;
            const bool is_one = ss_csv_number(cell[6], &p99) &&
                                ss_felt_has_goal(g, (ss_felt_path)(i % SS_FELT_PATHS),
                                                 atof(cell[2]), atoi(cell[4]));
            bool is_missed = false;
            for (char *rest = cell[SHORT_OF_COLUMN], *name; (name = strsep(&rest, ";"));) {
                is_missed = is_missed || strcmp(name + strspn(name, " "), g->name) == 0;
            }
            *out_rows += is_one;
            *out_reached += is_one && !is_missed;
        }
    }
}

static softsim_status write_goals(const report *r, const ss_sweep_result *result, ss_page *page,
                                  softsim_error *error)
{
    static const char *const columns[] = {"goal", "name", "rows", "reached"};
    ss_output csv;
    const softsim_status status =
        ss_report_csv_open(&csv, r->base.out, "felt-goals", "goal,name,rows,reached", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_heading(page, "Goals");
    ss_page_table_begin(page, 4, columns);
    for (int g = 0; g < SS_FELT_GOALS; ++g) {
        int32_t rows, reached;
        ss_row cells = {.count = 0};
        count_goal(result, &ss_felt_goals[g], &rows, &reached);
        ss_row_add(&cells, "%s", ss_felt_goals[g].text);
        ss_row_add(&cells, "%s", ss_felt_goals[g].name);
        ss_row_add(&cells, "%d", rows);
        ss_row_add(&cells, "%d", reached);
        ss_page_table_row(page, cells.count, cells.cell);
        ss_csv_text(csv.file, ss_felt_goals[g].text);
        fprintf(csv.file, ",%s,%d,%d\n", ss_felt_goals[g].name, rows, reached);
    }
    ss_page_table_end(page);
    return ss_output_commit(&csv, error);
}

static softsim_status write_page(const ss_felt_report *base, const ss_sweep_result *result,
                                 ss_page *page, softsim_error *error)
{
    const report *r = (const report *)base;
    static const char *const columns[] = {
        "rate, Hz", "path", "delay, ms", "p50",       "p95",      "p99",     "hold: p99", "impulse",
        "peak",     "held", "static",    "touch, ms", "depth, R", "net, mJ", "verdict"};
    ss_page_text(
        page, "The same path of a tool, played to the same scene while its simulation runs at "
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
    ss_page_text(page,
                 "Hold: p99 of the same run without the local contact model, forces held from the "
                 "last result. Touch: of the reference's contacts, the one that is felt latest (or "
                 "earliest: negative). Depth: of the tool in the tissue, in its radii, pressed "
                 "with contact.working_force_n. A row that is short of a goal says of which, and "
                 "what was measured beside it: how far 1000 Hz is itself from 10,000 Hz; how much "
                 "of the force is not that of a hand ten times slower (p95), and in how many ms "
                 "it rises; where in a contact the difference is.");
    softsim_status status = write_goals(r, result, page, error);
    for (int32_t s = 0; s < r->base.scenes.count && status == SOFTSIM_OK; ++s) {
        char name[SS_FELT_NAME_SIZE];
        if (r->base.scenes.is_bundled && !result->run[s * SS_FELT_PATHS].is_lost &&
            !ss_felt_has_rows(&result->run[s * SS_FELT_PATHS])) {
            continue; /* without a tool */
        }
        ss_felt_name(r->base.scenes.path[s], name);
        ss_page_heading(page, name);
        ss_page_table_begin(page, (int32_t)(sizeof columns / sizeof *columns), columns);
        for (int32_t p = 0; p < SS_FELT_PATHS; ++p) {
            const ss_sweep_run *run = &result->run[s * SS_FELT_PATHS + p];
            if (!run->is_lost) {
                add_rows(page, run->text);
            }
        }
        ss_page_table_end(page);
        ss_felt_page_lost(base, page, &result->run[s * SS_FELT_PATHS]);
        status = plot_scene(r, result, s, page, error);
    }
    ss_page_link(page, "felt-goals.csv");
    return status;
}

static void print_goals(const ss_sweep_result *result)
{
    for (int g = 0; g < SS_FELT_GOALS; ++g) {
        int32_t rows, reached;
        count_goal(result, &ss_felt_goals[g], &rows, &reached);
        printf("%s: %d of %d\n", ss_felt_goals[g].text, reached, rows);
    }
}

/* ---- options ---- */

static ss_args_result parse_options(int argc, char **argv, ss_felt_report *base,
                                    softsim_error *error)
{
    report *r = (report *)base;
    r->delays = "0";
    const ss_arg rows[] = {
        SS_FELT_ROWS(base),
        SS_TEXT("--rates", &r->rates, "N,N",
                "of the simulation, Hz, 10 to 1000 (30,60,120,300,500; quick: 60,300)"),
        SS_TEXT("--delays-ms", &r->delays, "N,N", "of the bus, one way, whole ms, 0 to 20 (0)"),
        SS_FLAG("--quick", &r->is_quick, "two rates, and not the run at 10,000 Hz"),
        SS_FLAG("--hands", &r->is_hands,
                "simulated hands in closed loop in place of given paths; more: --hands --help"),
        SS_FLAG("--slide", &r->is_slide,
                "slides over the surface in place of all paths; more: --slide --help"),
    };
    const ss_args_result result = ss_args_parse(
        argc, argv, "[options]",
        "Measures what a hand feels when the simulation is slower than the haptic loop: press, "
        "poke, tap and slide at several rates and delays, against the same scene at 1000 Hz.\n"
        "felt.csv: p50, p99, max: difference of the force in contact over its mean; impulse_error, "
        "peak_error, held_error, static_error: shares, signed; net_energy_j: least balance of a "
        "contact, negative where the hand was driven; hold_p99: p99 with forces held from the last "
        "result; penetration: of the tool in the tissue, in its radii, at the working force; "
        "short_of: the goals that a row misses, with what was measured of the cause. rate_hz is as "
        "asked for; the simulation runs at the nearest whole number of haptic periods a step, 60 "
        "at "
        "58.8 Hz.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    r->rates = r->rates ? r->rates : r->is_quick ? "60,300" : "30,60,120,300,500";
    double delay[MAX_DELAYS];
    r->rate_count = ss_felt_numbers("--rates", false, r->rates, 10.0, SS_FELT_REFERENCE_HZ,
                                    MAX_RATES, r->rate_hz, error);
    r->delay_count =
        ss_felt_numbers("--delays-ms", true, r->delays, 0.0, 20.0, MAX_DELAYS, delay, error);
    for (int32_t i = 0; i < r->delay_count; ++i) {
        r->delay_ms[i] = (int32_t)delay[i];
    }
    return result;
}

static const char *path_name(int32_t path)
{
    return ss_felt_path_name((ss_felt_path)path);
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
    static const ss_felt_kind kind = {"felt",        "softsim: what a hand feels",
                                      head,          sizeof(report),
                                      SS_FELT_PATHS, path_name,
                                      parse_options, label,
                                      run_one,       write_page,
                                      print_goals};
    return ss_felt_report_run(argc, argv, &kind);
}

const ss_report_class ss_report_felt = {.name = "felt",
                                        .about =
                                            "what a hand feels at a given rate of the simulation",
                                        .run = run_report};
