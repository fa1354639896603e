/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench latency: how late the chain is, beside what the machine itself does in the same
 * run. A time never fails the report (a shared machine is late whenever it likes); a program that
 * fails, or counters that do not add up, do.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/bench.h"
#include "bench/core/child.h"
#include "bench/core/report.h"
#include "bench/latency/figures.h"
#include "bench/latency/judge.h"
#include "bench/latency/session.h"
#include "process.h"
#include "rt/args.h"
#include "rt/memory.h"
#include "softsim/log.h"

enum { PATH_SIZE = 4096, BINS_A_DECADE = 20, DECADES = 7, TAIL_POINTS = 240 };
static const double standard_s = 60.0;
static const double quick_s = 12.0; /* one window of lateness and what comes before it */

typedef struct options {
    const char *scene, *poses, *bridge, *out, *lcm_url, *log;
    double seconds, rate_hz;
    int64_t contacts;
    bool is_quick;
} options;

typedef struct report {
    const options *options;
    ss_session *session;
    ss_figures *figures;
    ss_yardstick yardstick;
} report;

/* ---- options ---- */

/* Options of one of the two uses do nothing in the other. */
static void check_log_options(const options *o, softsim_error *error)
{
    const struct {
        const char *name;
        bool is_given;
    } run[] = {{"--scene", o->scene != NULL},    {"--poses", o->poses != NULL},
               {"--bridge", o->bridge != NULL},  {"--seconds", o->seconds > 0.0},
               {"--quick", o->is_quick},         {"--out", o->out != NULL},
               {"--lcm-url", o->lcm_url != NULL}};
    for (size_t k = 0; k < sizeof run / sizeof *run && o->log != NULL; ++k) {
        if (run[k].is_given) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "%s: --log runs nothing and prints its verdicts; leave one out",
                              run[k].name);
        }
    }
    if (o->log == NULL && (o->rate_hz > 0.0 || o->contacts >= 0)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: only --log FILE.csv takes it; leave it out",
                          o->rate_hz > 0.0 ? "--rate" : "--contacts");
    }
}

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.rate_hz = 0.0, .contacts = -1};
    const ss_arg rows[] = {
        SS_TEXT("--scene", &o->scene, "SCENE.yaml",
                "with tools for probes 0 and 1 (the bundled kidney.yaml)"),
        SS_TEXT("--poses", &o->poses, "LOG",
                "played to probe 0, again and again (the bundled kidney-poke.lcmlog)"),
        SS_TEXT("--bridge", &o->bridge, "\"ARGS\"",
                "of the bridge on probe 1: --offset-m ... (the line ..._SECOND= of LOG's .sh)"),
        {"--seconds", SS_ARG_NUMBER, &o->seconds, 1.0, 36000.0, "S", "measured (60)"},
        SS_FLAG("--quick", &o->is_quick, "measures 12 s"),
        SS_TEXT("--out", &o->out, "DIR", "for the report (latency-report)"),
        SS_ARG_LCM_URL(&o->lcm_url),
        SS_TEXT("--log", &o->log, "FILE.csv",
                "runs nothing: judges how the session felt that softsim-bridge --csv recorded"),
        {"--rate", SS_ARG_NUMBER, &o->rate_hz, 1.0, 1e5, "HZ", "--log: ticks a second (1000)"},
        {"--contacts", SS_ARG_INTEGER, &o->contacts, 0, 1000, "N",
         "--log: contacts a second that the task itself makes (1)"},
    };
    const ss_args_result result =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Runs daemon, replay, bridge and monitor and measures pose to force, "
                        "lateness and missed\nperiods beside a bare timer loop and a bare LCM "
                        "echo in the same run.",
                        rows, error);
    if (result == SS_ARGS_RUN) {
        check_log_options(o, error);
    }
    o->out = o->out != NULL ? o->out : "latency-report";
    o->rate_hz = o->rate_hz > 0.0 ? o->rate_hz : 1000.0;
    o->contacts = o->contacts >= 0 ? o->contacts : 1;
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

typedef struct bundled {
    const char *name;
    char *path; /* PATH_SIZE bytes */
} bundled;

static bool take_bundled(void *context, const char *folder)
{
    const bundled *b = context;
    char path[2 * PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s", folder, b->name);
    return access(path, R_OK) == 0 && realpath(path, b->path) != NULL;
}

/* A file of the bundled scenes: of the source tree here or above the program, or as installed
 * beside it. `store` has PATH_SIZE bytes. */
static const char *find_bundled(const char *name, const char *option, char *store,
                                softsim_error *error)
{
    static const char *const place[] = {"server/scenes", "share/softsim/scenes", NULL};
    bundled b = {name, store};
    store[0] = '\0';
    ss_child_look_above(place, take_bundled, &b);
    if (store[0] == '\0') {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: no bundled %s here or above this program; give one", option, name);
    }
    return store;
}

/* The scene is softsimd's to read; a missing one is told before anything is measured. */
static void check_scene(const char *path, softsim_error *error)
{
    if (access(path, R_OK) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "--scene: %s: %s", path, strerror(errno));
    }
}

/* How often the poses are to be played to last `seconds`; 0 with faults added. */
static int64_t find_repeat(const char *path, double seconds, softsim_error *error)
{
    softsim_poses *poses = NULL;
    softsim_pose_event event;
    char note[256];
    int64_t count = 0;
    int64_t last_us = 0;
    if (softsim_poses_open(path, 1000.0, &poses, error) != SOFTSIM_OK) {
        return 0;
    }
    softsim_poses_result next;
    while ((next = softsim_poses_next(poses, &event, note, sizeof note)) != SOFTSIM_POSES_END) {
        if (next == SOFTSIM_POSES_POSE) {
            ++count;
            last_us = event.time_us;
        }
    }
    softsim_poses_close(&poses);
    if (count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: no probe poses", path);
        return 0;
    }
    return (int64_t)ceil(seconds / (1e-6 * (double)last_us + 1e-3));
}

/* The bridge's arguments: given, or those of the shell file beside the poses. */
static const char *find_bridge(const options *o, char *store, int32_t size, softsim_error *error)
{
    char path[PATH_SIZE];
    if (o->bridge != NULL) {
        return o->bridge;
    }
    const char *slash = strrchr(o->poses, '/');
    const char *dot = strrchr(o->poses, '.');
    const size_t stem =
        dot != NULL && (slash == NULL || dot > slash) ? (size_t)(dot - o->poses) : strlen(o->poses);
    snprintf(path, sizeof path, "%.*s.sh", (int)(stem < 4000 ? stem : 4000), o->poses);
    if (ss_session_read_bridge(path, store, size)) {
        return store;
    }
    softsim_error_add(
        error, SOFTSIM_ERROR_ARGUMENT,
        "--bridge is missing, and %s has no plain line ..._SECOND=\"...\"; give where "
        "the simulated hand stands, as --bridge \"--offset-m x,y,z --axes x,y,z\"",
        path);
    return NULL;
}

/* ---- figures ---- */

enum { QUANTITIES = 5 };
typedef struct quantity {
    const char *name, *text;
    ss_figure figure;
} quantity;

static void list_quantities(const ss_figures *f, quantity out[QUANTITIES])
{
    out[0] = (quantity){"haptic_lateness_us", "haptic loop, lateness", f->haptic};
    out[1] = (quantity){"bare_loop_lateness_us", "bare loop, lateness", f->bare_loop};
    out[2] = (quantity){"pose_to_force_us", "pose to force", f->pose_to_force};
    out[3] = (quantity){"bare_echo_us", "bare LCM echo, round trip", f->bare_echo};
    out[4] = (quantity){"step_cpu_us", "simulation step, thread CPU", f->step};
}

static void put_number(FILE *file, double value)
{
    if (isnan(value)) {
        fputc(',', file);
    } else {
        fprintf(file, ",%.6g", value);
    }
}

static void put_count(FILE *file, const char *name, int64_t count)
{
    fprintf(file, "%s,,,,,%lld\n", name, (long long)count);
}

static softsim_status write_csv(const report *r, softsim_error *error)
{
    ss_output output;
    quantity quantities[QUANTITIES];
    const ss_figures *f = r->figures;
    const softsim_status status = ss_report_csv_open(&output, r->options->out, "latency",
                                                     "quantity,p50,p99,p999,max,count", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = output.file;
    list_quantities(f, quantities);
    for (int i = 0; i < QUANTITIES; ++i) {
        const ss_figure *figure = &quantities[i].figure;
        fputs(quantities[i].name, file);
        put_number(file, figure->p50);
        put_number(file, figure->p99);
        put_number(file, figure->p999);
        put_number(file, figure->max);
        fprintf(file, ",%lld\n", (long long)figure->count);
    }
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (f->periods[p] > 0) {
            char name[48];
            snprintf(name, sizeof name, "probe_%d_periods", p);
            put_count(file, name, f->periods[p]);
            snprintf(name, sizeof name, "probe_%d_forces", p);
            put_count(file, name, f->forces[p]);
            snprintf(name, sizeof name, "probe_%d_missed", p);
            put_count(file, name, f->missed[p]);
        }
    }
    put_count(file, "bare_loop_periods", f->bare_periods);
    put_count(file, "bare_loop_missed", f->bare_missed);
    put_count(file, "bare_echo_lost", r->session->bare.echo_sent - f->bare_echo.count);
    put_count(file, "poses_received", f->received);
    put_count(file, "poses_superseded", f->superseded);
    put_count(file, "poses_refused", f->refused);
    put_count(file, "statuses", f->statuses);
    put_count(file, "statuses_lost", f->statuses_lost);
    put_count(file, "statuses_with_wrong_sums", f->wrong_sums);
    return ss_output_commit(&output, error);
}

/* ---- the terminal ---- */

static const char *fifo_note(const report *r)
{
    return r->session->bare.is_fifo
               ? "SCHED_FIFO"
               : "the ordinary scheduler (SCHED_FIFO is not allowed here: times are worse)";
}

static void print_figures(const report *r)
{
    quantity quantities[QUANTITIES];
    const ss_figures *f = r->figures;
    list_quantities(f, quantities);
    printf("%-30s %10s %10s %10s %10s %9s\n", "microseconds", "p50", "p99", "p99.9", "max",
           "count");
    for (int i = 0; i < QUANTITIES; ++i) {
        const ss_figure *figure = &quantities[i].figure;
        printf("%-30s %10.1f %10.1f ", quantities[i].text, figure->p50, figure->p99);
        if (isnan(figure->p999)) {
            printf("%10s ", "");
        } else {
            printf("%10.1f ", figure->p999);
        }
        printf("%10.1f %9lld\n", figure->max, (long long)figure->count);
    }
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (f->periods[p] > 0) {
            printf(
                "probe %d: %lld periods, %lld forces, %lld missed (%.3f %%); criterion missed <= "
                "2 x the bare loop's + 0.1 %%: %s\n",
                p, (long long)f->periods[p], (long long)f->forces[p], (long long)f->missed[p],
                100.0 * (double)f->missed[p] / (double)f->periods[p],
                ss_figures_is_missed_good(f->periods[p], f->missed[p], f->bare_periods,
                                          f->bare_missed)
                    ? "met"
                    : "not met");
        }
    }
    printf("bare loop: %lld periods, %lld missed (%.3f %%), under %s\n", (long long)f->bare_periods,
           (long long)f->bare_missed, 100.0 * (double)f->bare_missed / (double)f->bare_periods,
           fifo_note(r));
    printf("poses: %lld received, %lld superseded, %lld refused; forces + missed = periods in %lld "
           "of %lld statuses\n",
           (long long)f->received, (long long)f->superseded, (long long)f->refused,
           (long long)(f->statuses - f->wrong_sums), (long long)f->statuses);
    if (f->worst_verdict > 0) {
        printf("worst verdict %d: %s\n", f->worst_verdict, f->reason);
    }
}

/* ---- the page ---- */

/* A data block of `value share`: what share of the samples is at least as large. */
static void put_tail(FILE *file, const char *name, ss_samples *samples)
{
    fprintf(file, "$%s << EOD\n", name);
    for (int k = 0; k < TAIL_POINTS && samples->count > 0; ++k) {
        const double share = pow(10.0, -(double)k / (TAIL_POINTS / 6));
        const double one = 1.0 / (double)samples->count;
        const double at = ss_samples_quantile(samples, 1.0 - fmax(share, one) + one);
        fprintf(file, "%.6g %.6g\n", fmax(at, 0.1), fmax(share, one));
        if (share <= one) {
            break;
        }
    }
    fputs("EOD\n", file);
}

/* A data block of `centre percent` in logarithmic bins from 1 us. */
static void put_histogram(FILE *file, const char *name, const ss_samples *samples)
{
    int64_t count[DECADES * BINS_A_DECADE] = {0};
    for (int64_t i = 0; i < samples->count; ++i) {
        const double at = floor(BINS_A_DECADE * log10(fmax(samples->value[i], 1.0)));
        ++count[(int)fmin(at, DECADES * BINS_A_DECADE - 1)];
    }
    fprintf(file, "$%s << EOD\n", name);
    for (int k = 0; k < DECADES * BINS_A_DECADE && samples->count > 0; ++k) {
        fprintf(file, "%.6g %.6g\n", pow(10.0, (k + 0.5) / BINS_A_DECADE),
                100.0 * (double)count[k] / (double)samples->count);
    }
    fputs("EOD\n", file);
}

static softsim_status plot_lateness(const report *r, ss_page *page, ss_samples *bare_us,
                                    softsim_error *error)
{
    ss_output script;
    const ss_figure *haptic = &r->figures->haptic;
    const softsim_status status = ss_plot_open(&script, r->options->out, "lateness", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    put_tail(file, "bare", bare_us);
    fprintf(file, "$haptic << EOD\n%.6g 0.5\n%.6g 0.01\n%.6g 0.001\n%.6g %.6g\nEOD\n",
            fmax(haptic->p50, 0.1), fmax(haptic->p99, 0.1), fmax(haptic->p999, 0.1),
            fmax(haptic->max, 0.1), 1.0 / (double)(haptic->count > 0 ? haptic->count : 1));
    fputs("set logscale xy\nset grid\nset key bottom left\nset format y '10^{%L}'\n"
          "set xlabel 'lateness, us'\nset ylabel 'share of periods at least as late'\n"
          "set arrow from 1000, graph 0 to 1000, graph 1 nohead dt 3 lc rgb 'grey50'\n"
          "set label ' one period' at 1000, graph 0.95 tc rgb 'grey40'\n"
          "plot $bare with lines lw 2 title 'bare loop', "
          "$haptic with linespoints pt 7 lw 2 title 'haptic loop'\n",
          file);
    return ss_page_plot(page, &script, "lateness",
                        "Lateness at 1 kHz: how large a share of periods began at least that late. "
                        "Of the haptic loop p50, p99, p99.9 and the maximum are known.",
                        error);
}

static softsim_status plot_histograms(const report *r, ss_page *page, const ss_samples *bare_us,
                                      softsim_error *error)
{
    ss_output script;
    const softsim_status status = ss_plot_open(&script, r->options->out, "histograms", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    put_histogram(file, "bare", bare_us);
    put_histogram(file, "echo", r->session->bare.echo_us);
    put_histogram(file, "answer", &r->figures->answer_us);
    fputs("set logscale x\nset grid\nset xrange [1:1e5]\nset yrange [0:*]\n"
          "set xlabel 'us'\nset ylabel '% of samples, 20 bins a decade'\n"
          "plot $bare with histeps lw 2 title 'bare loop, lateness', "
          "$echo with histeps lw 2 title 'bare LCM echo, round trip', "
          "$answer with histeps lw 2 title 'pose to force'\n",
          file);
    return ss_page_plot(page, &script, "histograms",
                        "Lateness of the bare loop, round trips of the bare echo, and pose to "
                        "force. A pose waits for the next haptic period, up to 1 ms and all of a "
                        "run about equally long, since both clocks keep step; the echo waits for "
                        "nothing.",
                        error);
}

static void put_quantities(ss_page *page, const ss_figures *f)
{
    static const char *const head[] = {"microseconds", "p50", "p99", "p99.9", "max", "count"};
    quantity quantities[QUANTITIES];
    list_quantities(f, quantities);
    ss_page_table_begin(page, 6, head);
    for (int i = 0; i < QUANTITIES; ++i) {
        const ss_figure *figure = &quantities[i].figure;
        ss_row row = {.count = 0};
        ss_row_add(&row, "%s", quantities[i].text);
        ss_row_add_number(&row, figure->p50);
        ss_row_add_number(&row, figure->p99);
        ss_row_add_number(&row, figure->p999);
        ss_row_add_number(&row, figure->max);
        ss_row_add(&row, "%lld", (long long)figure->count);
        ss_page_table_row(page, row.count, row.cell);
    }
    ss_page_table_end(page);
}

static void put_periods(ss_page *page, const ss_figures *f)
{
    static const char *const head[] = {"",       "periods", "forces",
                                       "missed", "share",   "missed <= 2 x bare + 0.1 %"};
    ss_page_table_begin(page, 6, head);
    for (int p = 0; p <= SOFTSIM_MAX_PROBES; ++p) {
        ss_row row = {.count = 0};
        const bool is_bare = p == SOFTSIM_MAX_PROBES;
        const int64_t periods = is_bare ? f->bare_periods : f->periods[p];
        const int64_t missed = is_bare ? f->bare_missed : f->missed[p];
        if (periods == 0) {
            continue;
        }
        if (is_bare) {
            ss_row_add(&row, "bare loop");
        } else {
            ss_row_add(&row, "probe %d", p);
        }
        ss_row_add(&row, "%lld", (long long)periods);
        ss_row_add(&row, "%lld", (long long)(is_bare ? periods - missed : f->forces[p]));
        ss_row_add(&row, "%lld", (long long)missed);
        ss_row_add(&row, "%.3f%%", 100.0 * (double)missed / (double)periods);
        ss_row_add(&row, "%s",
                   is_bare ? ""
                   : ss_figures_is_missed_good(periods, missed, f->bare_periods, f->bare_missed)
                       ? "met"
                       : "not met");
        ss_page_table_row(page, row.count, row.cell);
    }
    ss_page_table_end(page);
}

static softsim_status put_pictures(const report *r, ss_page *page, softsim_error *error)
{
    ss_samples bare_us;
    const ss_bare_result *bare = &r->session->bare;
    if (!ss_samples_init(&bare_us, bare->tick_count + 1)) {
        return ss_memory_fault(error);
    }
    for (int64_t i = 0; i < bare->tick_count; ++i) {
        if (bare->tick[i].due_ns > r->figures->windows_begin_ns &&
            bare->tick[i].due_ns <= r->figures->windows_end_ns) {
            ss_samples_add(&bare_us, bare->tick[i].late_us);
        }
    }
    softsim_status status = plot_lateness(r, page, &bare_us, error);
    if (status == SOFTSIM_OK) {
        status = plot_histograms(r, page, &bare_us, error);
    }
    ss_samples_fini(&bare_us);
    return status;
}

static softsim_status write_page(const report *r, softsim_error *error)
{
    ss_page page;
    const ss_figures *f = r->figures;
    softsim_status status =
        ss_page_open(&page, r->options->out, "latency", "softsim: latency", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&page,
                 "%s with %s on probe 0 and a simulated hand on probe 1, a monitor beside them; "
                 "%.0f s measured. The bare loop and the bare echo ran in the same time, under %s.",
                 r->options->scene, r->options->poses, r->options->seconds, fifo_note(r));
    put_quantities(&page, f);
    ss_page_text(&page,
                 "Lateness: p50, p99 and p99.9 are medians over %d disjoint window%s of %d s, for "
                 "both loops; max is of all of them. The echo sends a pose's 148 bytes and gets a "
                 "force's 216. Step: the last 10 s.",
                 f->window_count, f->window_count == 1 ? "" : "s", SS_SESSION_WINDOW_S);
    ss_page_heading(&page, "Periods");
    put_periods(&page, f);
    ss_page_text(&page,
                 "A period is missed when its force was sent more than one period late, or never. "
                 "forces + missed = periods in %lld of %lld statuses. Poses: %lld received, %lld "
                 "superseded by newer ones, %lld refused. Worst verdict of the server: %d%s%s.",
                 (long long)(f->statuses - f->wrong_sums), (long long)f->statuses,
                 (long long)f->received, (long long)f->superseded, (long long)f->refused,
                 f->worst_verdict, f->worst_verdict > 0 ? ": " : "",
                 f->worst_verdict > 0 ? f->reason : "");
    status = put_pictures(r, &page, error);
    ss_page_yardstick(&page, &r->yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

/* ---- the run ---- */

static softsim_status run(options *o, const char *bridge, int64_t repeat, bool *out_is_good,
                          softsim_error *error)
{
    static ss_session session;
    static ss_figures figures;
    report r = {.options = o, .session = &session, .figures = &figures};
    const ss_session_options settings = {.scene = o->scene,
                                         .poses = o->poses,
                                         .lcm_url = o->lcm_url,
                                         .bridge = bridge,
                                         .folder = o->out,
                                         .repeat = repeat,
                                         .seconds = o->seconds};
    softsim_status status = ss_report_make_folder(o->out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_yardstick_measure(&r.yardstick);
    status = ss_session_run(&settings, &session, error);
    if (status == SOFTSIM_OK && !ss_figures_compute(&session, &figures)) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status, "fewer than two statuses of the server came in %.0f s",
                          o->seconds);
    }
    if (status == SOFTSIM_OK) {
        status = ss_figures_read_answers(&session, &figures, error);
    }
    if (status == SOFTSIM_OK) {
        print_figures(&r);
        status = write_csv(&r, error);
    }
    if (status == SOFTSIM_OK) {
        status = write_page(&r, error);
    }
    *out_is_good = figures.wrong_sums == 0;
    ss_figures_fini(&figures);
    ss_session_fini(&session);
    return status;
}

static int run_report(int argc, char **argv)
{
    options o;
    char store[PATH_SIZE], scene[PATH_SIZE], poses[PATH_SIZE];
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    if (parsed == SS_ARGS_DONE) {
        return EXIT_SUCCESS;
    }
    if (parsed == SS_ARGS_RUN && o.log != NULL) {
        return ss_judge_run(argv[0], o.log, o.rate_hz, (int32_t)o.contacts);
    }
    const char *bridge = NULL;
    int64_t repeat = 0;
    if (parsed == SS_ARGS_RUN) {
        o.seconds = o.seconds > 0.0 ? o.seconds : o.is_quick ? quick_s : standard_s;
        o.scene = o.scene != NULL ? o.scene : find_bundled("kidney.yaml", "--scene", scene, &error);
        o.poses = o.poses != NULL ? o.poses
                                  : find_bundled("kidney-poke.lcmlog", "--poses", poses, &error);
        if (o.scene[0] != '\0') {
            check_scene(o.scene, &error);
        }
        repeat = o.poses[0] != '\0' ? find_repeat(o.poses, o.seconds + 120.0, &error) : 0;
        /* What is beside a missing file needs no line of its own. */
        bridge = repeat > 0 ? find_bridge(&o, store, sizeof store, &error) : NULL;
    }
    if (error.fault_count > 0) {
        ss_args_print_error(argv[0], &error);
        return SS_EXIT_BAD_INPUT;
    }
    ss_process_catch_stop();
    bool is_good = false;
    const softsim_status status = run(&o, bridge, repeat, &is_good, &error);
    if (status == SOFTSIM_OK && !is_good) {
        softsim_error_add(&error, SOFTSIM_ERROR_SYSTEM,
                          "forces + missed is not periods in some statuses: the server miscounts");
    }
    if (error.fault_count > 0) {
        ss_args_print_error(argv[0], &error);
        return EXIT_FAILURE;
    }
    printf("%s/latency.html\n", o.out);
    return EXIT_SUCCESS;
}

const ss_report_class ss_report_latency = {
    .name = "latency",
    .about = "pose to force, lateness and missed periods of the whole chain",
    .run = run_report};
