/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench scaling: what a millisecond of the body of body.h costs at several sizes, how
 * smooth the force of a sliding tool is, and whether energy adds up over press, slide and release.
 * Beside it Table 1 of the paper on which cnn-energy is built (Zhong, Shirinzadeh, Alici, Smith
 * 2006; Pentium 4, 2.8 GHz), whose rates are given as the time of a step.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench.h"
#include "body.h"
#include "process.h"
#include "report.h"
#include "rt/args.h"

enum {
    EXIT_BAD_INPUT = 2,
    PATH_SIZE = 4096,
    MAX_SIZES = 32,
    LEAST_POINTS = 200,
    MOST_POINTS = 200000,
    CASES = 4,
    WINDOW_POINTS = 4096 /* smaller bodies have no window */
};
static const char standard_points[] =
    "300,422,602,814,1058,1192,2000,4000,5000,8000,20000,50000,100000";
static const char quick_points[] = "300,422,602,814,1058,1192,5000,20000";

/* Points and rate of the paper's Table 1. */
static const struct {
    int32_t points;
    double rate_hz;
} paper[] = {{422, 285.7}, {602, 142.8}, {814, 83.3}, {1058, 45.5}, {1192, 25.6}};

/* A whole Runge-Kutta step of the prototype of this model, us, at the lower end. */
static const struct {
    int32_t points;
    double step_us;
} prototype[] = {{422, 22.0},  {602, 30.0},   {814, 42.0},     {1058, 55.0},
                 {1192, 62.0}, {5000, 185.0}, {20000, 1060.0}, {100000, 7600.0}};

typedef struct options {
    const char *out, *points;
    bool is_quick;
    int32_t size[MAX_SIZES];
    int32_t size_count;
} options;

typedef struct row {
    int32_t points, nodes, active_nodes;
    double substeps;
    const char *name; /* of the case */
    double p50_us, p99_us, step_us, paper_ms, prototype_us, jump, mean_force, ledger;
    double apart; /* from the same poke with all nodes active, over the largest displacement */
    char verdict[192];
} row;

typedef struct report {
    const options *options;
    ss_yardstick yardstick;
    row row[CASES * MAX_SIZES];
    int32_t row_count;
} report;

/* ---- options
 * ------------------------------------------------------------------------------------------ */

static void parse_points(options *o, softsim_error *error)
{
    const char *at = o->points;
    do {
        char *end = NULL;
        const long value = strtol(at, &end, 10);
        if (end == at || (*end != ',' && *end != '\0') || value < LEAST_POINTS ||
            value > MOST_POINTS || o->size_count == MAX_SIZES) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--points: '%s' is not a list of at most %d numbers of %d to %d, "
                              "with commas",
                              o->points, MAX_SIZES, LEAST_POINTS, MOST_POINTS);
            return;
        }
        o->size[o->size_count++] = (int32_t)value;
        at = *end == ',' ? end + 1 : end;
    } while (*at != '\0');
}

static int compare(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a;
    const int32_t y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.out = "scaling-report"};
    const ss_arg rows[] = {
        {"--points", SS_ARG_STRING, &o->points, 0, 0, "N,N,...",
         "sizes (300 to 100000, with those of the paper)"},
        {"--quick", SS_ARG_FLAG, &o->is_quick, 0, 0, NULL, "sizes up to 20000"},
        {"--out", SS_ARG_STRING, &o->out, 0, 0, "DIR", "for the report (scaling-report)"},
    };
    int32_t count = 0;
    const char *positional = NULL;
    const ss_args_result result = ss_args_parse(
        argc, argv, "[options]",
        "Measures step time, smoothness of a slide and the energy balance against "
        "the number of nodes.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), &positional, 0, 0, &count, error);
    if (result == SS_ARGS_RUN) {
        o->points = o->points != NULL ? o->points : o->is_quick ? quick_points : standard_points;
        parse_points(o, error);
        qsort(o->size, (size_t)o->size_count, sizeof *o->size, compare);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

/* ---- measuring
 * ---------------------------------------------------------------------------------------- */

static double paper_ms(int32_t points)
{
    for (size_t i = 0; i < sizeof paper / sizeof *paper; ++i) {
        if (paper[i].points == points) {
            return 1e3 / paper[i].rate_hz;
        }
    }
    return NAN;
}

static double prototype_us(int32_t points)
{
    for (size_t i = 0; i < sizeof prototype / sizeof *prototype; ++i) {
        if (prototype[i].points == points) {
            return prototype[i].step_us;
        }
    }
    return NAN;
}

static void add_row(report *r, const char *name, int32_t points, ss_body_run *run, double apart)
{
    static const char *const verdicts[] = {"good", "guarded", "degraded", "fault"};
    row *to = &r->row[r->row_count++];
    *to = (row){.points = points,
                .nodes = run->nodes,
                .substeps = run->substeps,
                .name = name,
                .p50_us = ss_samples_quantile(&run->tick_us, 0.5),
                .p99_us = ss_samples_quantile(&run->tick_us, 0.99),
                .step_us = run->step_us,
                .paper_ms = paper_ms(points),
                .prototype_us = prototype_us(points),
                .active_nodes = run->active_nodes,
                .apart = apart,
                .jump = run->jump,
                .mean_force = run->mean_force,
                .ledger = run->ledger};
    snprintf(to->verdict, sizeof to->verdict, "%s%s%s",
             run->is_refused ? "refused" : verdicts[run->worst & 3],
             run->reason[0] != '\0' ? ": " : "", run->reason);
}

/* The local poke with all nodes active and with the window, and how far apart they are. */
static softsim_status measure_pokes(report *r, ss_body *body, softsim_error *error)
{
    ss_body_run whole = {0}, part = {0};
    softsim_status status = ss_body_poke(body, true, &whole, error);
    if (status == SOFTSIM_OK) {
        add_row(r, "poke all", body->points, &whole, NAN);
        status = ss_body_poke(body, false, &part, error);
    }
    if (status == SOFTSIM_OK) {
        add_row(r, "poke", body->points, &part, ss_body_apart(&part, &whole));
    }
    ss_body_run_fini(&whole);
    ss_body_run_fini(&part);
    return status;
}

/* All cases at one size; *out_refused where none of them can be run. */
static softsim_status measure_size(report *r, ss_body *body, int32_t points, bool *out_refused,
                                   softsim_error *error)
{
    ss_body_run slide = {0}, load = {0};
    softsim_status status = ss_body_make(body, points, error);
    if (status == SOFTSIM_OK) {
        status = ss_body_slide(body, &slide, error);
    }
    if (status == SOFTSIM_OK) {
        add_row(r, "slide", points, &slide, NAN);
        status = ss_body_load(body, &load, error);
    }
    if (status == SOFTSIM_OK) {
        add_row(r, "load", points, &load, NAN);
        *out_refused = slide.is_refused && load.is_refused;
    }
    if (status == SOFTSIM_OK && !load.is_refused && points >= WINDOW_POINTS) {
        status = measure_pokes(r, body, error);
    }
    ss_body_run_fini(&slide);
    ss_body_run_fini(&load);
    return status;
}

static softsim_status measure(report *r, softsim_error *error)
{
    ss_body body;
    const options *o = r->options;
    const bool is_shown = isatty(STDERR_FILENO) == 1;
    softsim_status status = ss_body_open(&body, error);
    bool is_refused = false;
    for (int32_t i = 0; status == SOFTSIM_OK && i < o->size_count && !is_refused; ++i) {
        if (is_shown) {
            fprintf(stderr, "\r%d of %d: %d points ", i + 1, o->size_count, o->size[i]);
        }
        status = measure_size(r, &body, o->size[i], &is_refused, error);
    }
    if (is_shown) {
        fprintf(stderr, "\r%40s\r", "");
    }
    ss_body_close(&body);
    return status;
}

/* ---- files
 * --------------------------------------------------------------------------------------------- */

static void put_number(FILE *file, double value)
{
    if (isnan(value)) {
        fputc(',', file);
    } else {
        fprintf(file, ",%.6g", value);
    }
}

static softsim_status write_csv(const report *r, softsim_error *error)
{
    char path[PATH_SIZE];
    ss_output output;
    snprintf(path, sizeof path, "%s/scaling.csv", r->options->out);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("points,nodes,case,step_us_p50,step_us_p99,substeps,substep_us,paper_ms,jump_percent,"
          "ledger_fraction,active_nodes,field_error,prototype_us,verdict\n",
          output.file);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        fprintf(output.file, "%d,%d,%s", at->points, at->nodes, at->name);
        put_number(output.file, at->p50_us);
        put_number(output.file, at->p99_us);
        put_number(output.file, at->substeps);
        put_number(output.file, at->p50_us / at->substeps);
        put_number(output.file, at->paper_ms);
        put_number(output.file, 100.0 * at->jump);
        put_number(output.file, at->ledger);
        fprintf(output.file, ",%d", at->active_nodes);
        put_number(output.file, at->apart);
        put_number(output.file, at->prototype_us);
        fputc(',', output.file);
        ss_csv_text(output.file, at->verdict);
        fputc('\n', output.file);
    }
    return ss_output_commit(&output, error);
}

static void print_cell(int width, int digits, double value)
{
    if (isnan(value)) {
        printf(" %*s", width, "");
    } else {
        printf(" %*.*f", width, digits, value);
    }
}

static void print_rows(const report *r)
{
    printf("%6s %8s %7s %10s %10s %9s %9s %9s %9s %7s %10s %9s  %s\n", "points", "case", "active",
           "p50 us", "p99 us", "sub-steps", "us each", "prototype", "paper ms", "jump %", "ledger",
           "apart", "verdict");
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        printf("%6d %8s %7d %10.1f %10.1f %9.2f %9.1f", at->points, at->name, at->active_nodes,
               at->p50_us, at->p99_us, at->substeps, at->p50_us / at->substeps);
        print_cell(9, 0, at->prototype_us);
        print_cell(9, 1, at->paper_ms);
        print_cell(7, 2, 100.0 * at->jump);
        printf(" %10.2e", at->ledger);
        if (isnan(at->apart)) {
            printf(" %9s", "");
        } else {
            printf(" %9.1e", at->apart);
        }
        printf("  %s\n", at->verdict);
    }
}

/* A data block of one case, or of the paper with NULL. */
static void put_block(FILE *file, const char *block, const report *r, const char *name)
{
    fprintf(file, "$%s << EOD\n", block);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        if (name == NULL && strcmp(at->name, "load") == 0 && !isnan(at->paper_ms)) {
            fprintf(file, "%d %.6g\n", at->points, at->paper_ms);
        } else if (name != NULL && strcmp(at->name, name) == 0 && !isnan(at->p50_us)) {
            fprintf(file, "%d %.6g %.6g\n", at->nodes, 1e-3 * at->p50_us, 1e-3 * at->p99_us);
        }
    }
    fputs("EOD\n", file);
}

static softsim_status plot_times(const report *r, ss_page *page, softsim_error *error)
{
    ss_output script;
    const softsim_status status = ss_plot_open(&script, r->options->out, "scaling", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    put_block(file, "load", r, "load");
    put_block(file, "slide", r, "slide");
    put_block(file, "paper", r, NULL);
    put_block(file, "all", r, "poke all");
    put_block(file, "poke", r, "poke");
    fprintf(file, "set logscale xy\nset grid\nset key bottom right\nset xrange [%d:%d]\n",
            r->row[0].points * 2 / 3, r->row[r->row_count - 1].points * 3 / 2);
    fputs("set xlabel 'nodes'\nset ylabel 'ms of thread CPU for 1 ms of time'\n"
          "plot 1 with lines dt 3 lc rgb 'grey50' title 'real time', "
          "$paper using 1:2 with points pt 6 lw 2 lc rgb 'black' title 'paper, Table 1', "
          "$load using 1:2 with linespoints pt 7 lw 2 lc 1 title 'one loaded node', "
          "$slide using 1:2 with linespoints pt 5 lw 2 lc 2 title 'sliding sphere', "
          "$slide using 1:3 with lines dt 2 lc 2 title 'sliding sphere, p99', "
          "$all using 1:2 with linespoints pt 4 lw 2 lc 3 title 'local poke, all nodes', "
          "$poke using 1:2 with linespoints pt 9 lw 2 lc 4 title 'local poke, window'\n",
          file);
    return ss_page_plot(page, &script, "scaling",
                        "Median step time against size. The paper's step is one of its own, on a "
                        "processor of 2005.",
                        error);
}

static void put_table(ss_page *page, const report *r)
{
    static const char *const head[] = {"points",    "case",          "active nodes",
                                       "p50, us",   "p99, us",       "model step alone, us",
                                       "sub-steps", "us a sub-step", "prototype, us",
                                       "paper, ms", "jump, %",       "mean force, N",
                                       "ledger",    "apart",         "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%d", at->points);
        ss_row_add(&cells, "%s", at->name);
        ss_row_add(&cells, "%d", at->active_nodes);
        ss_row_add_number(&cells, at->p50_us);
        ss_row_add_number(&cells, at->p99_us);
        ss_row_add_number(&cells, at->step_us);
        ss_row_add_number(&cells, at->substeps);
        ss_row_add_number(&cells, at->p50_us / at->substeps);
        ss_row_add_number(&cells, at->prototype_us);
        ss_row_add_number(&cells, at->paper_ms);
        ss_row_add_number(&cells, 100.0 * at->jump);
        ss_row_add_number(&cells, at->mean_force);
        ss_row_add_number(&cells, at->ledger);
        ss_row_add_number(&cells, at->apart);
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static softsim_status write_page(const report *r, softsim_error *error)
{
    ss_page page;
    softsim_status status =
        ss_page_open(&page, r->options->out, "scaling", "softsim: scaling", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(
        &page,
        "An ellipsoid of 100 x 60 x 60 mm, held below, cnn-energy, one thread, steps "
        "of 1 ms (sub-steps inside where stability needs them). load: 0.2 N on one "
        "node, no tool, all nodes active. slide: a sphere of 5 mm pressed 6 mm deep, moved 30 "
        "mm at 50 mm/s, released. poke: the same ellipsoid, larger, so that its edges are 4 "
        "mm long at every size, pretension 0.05 J; 0.1 N on the nodes within 10 mm of the "
        "top; with all nodes active (poke all), and with the active window.");
    status = plot_times(r, &page, error);
    put_table(&page, r);
    ss_page_text(&page,
                 "p50, p99: thread CPU time of whole ticks (model step, contact and haptic "
                 "tick) while loaded or sliding; beside it the median of the model's step "
                 "with its contact over the whole run. Jump: largest change between two "
                 "consecutive 1 kHz forces over the mean force while sliding at constant "
                 "speed. Ledger: (elastic + kinetic + dissipated - work) at the end over the "
                 "largest stored energy; the slide ends free and at rest, the load still "
                 "loaded. Apart: largest distance between the fields of poke and poke all at the "
                 "end over the largest displacement. Prototype: a Runge-Kutta step of the first "
                 "program that tried this model, one core of another machine, all nodes.");
    ss_page_yardstick(&page, &r->yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

/* ---- the run
 * --------------------------------------------------------------------------------------------- */

int ss_bench_scaling(int argc, char **argv)
{
    static report r; /* large */
    options o;
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    if (parsed == SS_ARGS_DONE) {
        return EXIT_SUCCESS;
    }
    if (parsed == SS_ARGS_BAD) {
        ss_args_print_error(argv[0], &error);
        return EXIT_BAD_INPUT;
    }
    ss_process_catch_stop();
    r.options = &o;
    softsim_status status = ss_report_make_folder(o.out, &error);
    if (status == SOFTSIM_OK) {
        ss_yardstick_measure(&r.yardstick);
        status = measure(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        print_rows(&r);
        status = write_csv(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        status = write_page(&r, &error);
    }
    if (status != SOFTSIM_OK) {
        ss_args_print_error(argv[0], &error);
        return EXIT_FAILURE;
    }
    printf("%s/scaling.html\n", o.out);
    return EXIT_SUCCESS;
}
