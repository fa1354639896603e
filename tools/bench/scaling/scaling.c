/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench scaling: what a millisecond of the body of common/body.h costs at several sizes,
 * how far its field is from that of a direct solve in double (as common/body.h defines it), how
 * smooth the force of a sliding tool is, and whether energy adds up over press, slide and release.
 * Then what the block of block.h costs with every model, to a million nodes, and where a model
 * gives way. Beside it Table 1 of the paper on which cnn-energy is built (Zhong, Shirinzadeh,
 * Alici, Smith 2006; Pentium 4, 2.8 GHz), whose rates are given as the time of a step.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/accuracy/models.h"
#include "bench/bench.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/scaling/block.h"
#include "bench/scaling/body.h"
#include "bench/stability/stress_case.h"
#include "case/scratch.h"
#include "models/cnn/network.h"
#include "process.h"
#include "rt/args.h"

enum {
    MAX_SIZES = 32,
    LEAST_POINTS = 200,
    MOST_POINTS = 1000000,
    LARGEST_ELLIPSOID = 100000, /* larger ones take longer to make than to measure */
    MAX_BLOCKS = 1024,
    CASES = 5,
    WINDOW_POINTS = 4096 /* smaller bodies have no window */
};
static const char standard_points[] =
    "300,422,602,814,1058,1192,2000,4000,5000,8000,20000,50000,100000";
static const char block_points[] = "300,1000,3000,10000,30000,100000,300000,1000000";
static const char quick_block_points[] = "300,1000,5000,20000";
static const double block_timeout_s = 1800.0;
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
    int64_t jobs;
    int32_t size[MAX_SIZES], block[MAX_SIZES]; /* of the ellipsoids, of the blocks */
    int32_t size_count, block_count;
} options;

typedef struct row {
    int32_t points, nodes, active_nodes;
    double substeps;
    const char *name;  /* of the case */
    const char *model; /* and its material */
    double p50_us, p99_us, step_us, paper_ms, prototype_us, jump, mean_force, ledger;
    double create_s, memory_mb, peak_mb; /* of blocks */
    double direct_error;                 /* of the field against a direct solve: common/body.h */
    double apart; /* from the same poke with all nodes active, over the largest displacement */
    char solver[160];
    char verdict[384];
} row;

typedef struct report {
    const options *options;
    ss_yardstick yardstick;
    char folder[SS_SCRATCH_PATH]; /* of the blocks' meshes */
    ss_sweep sweep;               /* of the blocks */
    ss_sweep_result blocks;
    row row[CASES * MAX_SIZES + MAX_BLOCKS];
    int32_t row_count;
} report;

/* ---- options ---- */

static int compare_sizes(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a;
    const int32_t y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Numbers with commas, sorted; returns how many. */
static int32_t parse_points(const char *points, int32_t out_size[MAX_SIZES], softsim_error *error)
{
    const char *at = points;
    int32_t count = 0;
    do {
        char *end = NULL;
        const long value = strtol(at, &end, 10);
        if (end == at || (*end != ',' && *end != '\0') || value < LEAST_POINTS ||
            value > MOST_POINTS || count == MAX_SIZES) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--points: '%s' is not a list of at most %d numbers of %d to %d, "
                              "with commas",
                              points, MAX_SIZES, LEAST_POINTS, MOST_POINTS);
            return 0;
        }
        out_size[count++] = (int32_t)value;
        at = *end == ',' ? end + 1 : end;
    } while (*at != '\0');
    qsort(out_size, (size_t)count, sizeof *out_size, compare_sizes);
    return count;
}

static void choose_sizes(options *o, softsim_error *error)
{
    const char *ellipsoids = o->points != NULL ? o->points
                             : o->is_quick     ? quick_points
                                               : standard_points;
    o->size_count = parse_points(ellipsoids, o->size, error);
    while (o->size_count > 0 && o->size[o->size_count - 1] > LARGEST_ELLIPSOID) {
        --o->size_count;
    }
    if (o->points != NULL) {
        o->block_count = error->fault_count > 0 ? 0 : parse_points(o->points, o->block, error);
    } else {
        o->block_count =
            parse_points(o->is_quick ? quick_block_points : block_points, o->block, error);
    }
}

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.out = "scaling-report", .jobs = 1};
    const ss_arg rows[] = {
        {"--points", SS_ARG_STRING, &o->points, 0, 0, "N,N,...",
         "sizes (ellipsoids 300 to 100000, with those of the paper; blocks 300 to 1000000)"},
        {"--quick", SS_ARG_FLAG, &o->is_quick, 0, 0, NULL, "sizes up to 20000"},
        {"--jobs", SS_ARG_INTEGER, &o->jobs, 1, SS_SWEEP_MAX_JOBS, "N",
         "blocks at a time (1; more disturb one another's times)"},
        {"--out", SS_ARG_STRING, &o->out, 0, 0, "DIR", "for the report (scaling-report)"},
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "[options]",
                      "Measures step time, smoothness of a slide and the energy balance against "
                      "the number of nodes.",
                      rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result == SS_ARGS_RUN) {
        choose_sizes(o, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

/* ---- measuring ---- */

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
    row *to = &r->row[r->row_count++];
    *to = (row){.points = points,
                .nodes = run->nodes,
                .substeps = run->substeps,
                .name = name,
                .model = "cnn-energy",
                .create_s = NAN,
                .memory_mb = NAN,
                .peak_mb = NAN,
                .p50_us = ss_samples_quantile(&run->tick_us, 0.5),
                .p99_us = ss_samples_quantile(&run->tick_us, 0.99),
                .step_us = run->step_us,
                .paper_ms = paper_ms(points),
                .prototype_us = prototype_us(points),
                .active_nodes = run->active_nodes,
                .direct_error = run->direct_error,
                .apart = apart,
                .jump = run->jump,
                .mean_force = run->mean_force,
                .ledger = run->ledger};
    snprintf(to->verdict, sizeof to->verdict, "%s%s%s%s%s",
             run->is_refused ? "refused" : softsim_verdict_name(run->worst),
             run->reason[0] != '\0' ? ": " : "", run->reason,
             run->direct_reason[0] != '\0' ? "; no field error: " : "", run->direct_reason);
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
    ss_body_run slide = {0}, load = {0}, pull = {0};
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
    if (status == SOFTSIM_OK && !load.is_refused) {
        status = ss_body_pull(body, &pull, error);
        if (status == SOFTSIM_OK) {
            add_row(r, "pull", points, &pull, NAN);
        }
    }
    if (status == SOFTSIM_OK && !load.is_refused && points >= WINDOW_POINTS) {
        status = measure_pokes(r, body, error);
    }
    ss_body_run_fini(&slide);
    ss_body_run_fini(&load);
    ss_body_run_fini(&pull);
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

/* ---- blocks ---- */

/* Run `index`: subject by subject within a size, so that a mesh is made once. */
static int32_t block_subject(const void *context, int32_t index)
{
    (void)context;
    return index % ss_assay_subject_count();
}

static int32_t block_size(const void *context, int32_t index)
{
    const report *r = context;
    return r->options->block[index / ss_assay_subject_count()];
}

static void block_label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    snprintf(out, SS_SWEEP_NAME_SIZE, "%s,%d", ss_assay_subject_name(block_subject(context, index)),
             block_size(context, index));
}

static softsim_status block_run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const report *r = context;
    ss_block_run run;
    const softsim_status status = ss_block_measure(r->folder, block_subject(context, index),
                                                   block_size(context, index), &run, error);
    if (status == SOFTSIM_OK) {
        fprintf(out, "%d %d %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n%s\n%s\n", run.nodes,
                run.active_nodes, run.create_s, run.memory_mb, run.peak_mb, run.p50_us, run.p99_us,
                run.substeps, run.ledger, run.solver, run.verdict);
    }
    return status;
}

static void add_block(report *r, const ss_sweep_run *run, int32_t index)
{
    row *to = &r->row[r->row_count++];
    *to = (row){.points = block_size(r, index),
                .name = "block",
                .model = ss_assay_subject_name(block_subject(r, index)),
                .p50_us = NAN,
                .p99_us = NAN,
                .substeps = NAN,
                .create_s = NAN,
                .memory_mb = NAN,
                .peak_mb = NAN,
                .ledger = NAN,
                .step_us = NAN,
                .paper_ms = NAN,
                .prototype_us = NAN,
                .jump = NAN,
                .mean_force = NAN,
                .direct_error = NAN,
                .apart = NAN};
    int used = 0;
    if (!run->is_lost && sscanf(run->text, "%d %d %lf %lf %lf %lf %lf %lf %lf%n", &to->nodes,
                                &to->active_nodes, &to->create_s, &to->memory_mb, &to->peak_mb,
                                &to->p50_us, &to->p99_us, &to->substeps, &to->ledger, &used) == 9) {
        const char *solver = run->text + used + 1;
        const char *verdict = solver + strcspn(solver, "\n");
        verdict += *verdict == '\n';
        snprintf(to->solver, sizeof to->solver, "%.*s", (int)strcspn(solver, "\n"), solver);
        snprintf(to->verdict, sizeof to->verdict, "%.*s", (int)strcspn(verdict, "\n"), verdict);
    } else {
        snprintf(to->verdict, sizeof to->verdict, "lost: %.*s", (int)sizeof to->verdict - 8,
                 run->text);
    }
}

/* Every model at every size, each in a process of its own. */
static softsim_status measure_blocks(report *r, softsim_error *error)
{
    r->sweep = (ss_sweep){.folder = r->options->out,
                          .name = "scaling",
                          .count = r->options->block_count * ss_assay_subject_count(),
                          .jobs = (int32_t)r->options->jobs,
                          .timeout_s = block_timeout_s,
                          .context = r,
                          .label = block_label,
                          .run = block_run};
    const softsim_status status = ss_sweep_execute(&r->sweep, &r->blocks, error);
    for (int32_t i = 0; status == SOFTSIM_OK && r->blocks.is_complete && i < r->blocks.count; ++i) {
        add_block(r, &r->blocks.run[i], i);
    }
    return status;
}

/* ---- files ---- */

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
    ss_output output;
    const softsim_status status = ss_report_csv_open(
        &output, r->options->out, "scaling",
        "points,nodes,case,step_us_p50,step_us_p99,substeps,substep_us,paper_ms,jump_percent,"
        "ledger_fraction,active_nodes,field_error_direct,field_error_all_active,prototype_us,"
        "verdict,model,create_s,memory_mb,peak_mb,solver",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
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
        put_number(output.file, at->direct_error);
        put_number(output.file, at->apart);
        put_number(output.file, at->prototype_us);
        fputc(',', output.file);
        ss_csv_text(output.file, at->verdict);
        fprintf(output.file, ",%s", at->model);
        put_number(output.file, at->create_s);
        put_number(output.file, at->memory_mb);
        put_number(output.file, at->peak_mb);
        fputc(',', output.file);
        ss_csv_text(output.file, at->solver);
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

static void print_small(int width, int digits, double value)
{
    if (isnan(value)) {
        printf(" %*s", width, "");
    } else {
        printf(" %*.*e", width, digits, value);
    }
}

static bool is_block(const row *at)
{
    return strcmp(at->name, "block") == 0;
}

static bool has_solver(const row *at, int32_t subject, const char *solver)
{
    return is_block(at) && strcmp(at->model, ss_assay_subject_name(subject)) == 0 &&
           strncmp(at->solver, solver, strlen(solver)) == 0;
}

/* Where the factor of a subject gives way, as a sentence; false: it solves no linear equations. */
static bool tell_solver(const report *r, int32_t subject, char *out, size_t size)
{
    const row *factored = NULL, *iterated = NULL; /* the largest, and the smallest */
    for (const row *at = r->row; at < r->row + r->row_count; ++at) {
        factored = has_solver(at, subject, "a factor") ? at : factored;
        iterated = iterated == NULL && has_solver(at, subject, "conjugate") ? at : iterated;
    }
    const char *name = ss_assay_subject_name(subject);
    if (factored != NULL && iterated != NULL) {
        snprintf(out, size, "%s: factored up to %d nodes, from %d on %s.", name, factored->nodes,
                 iterated->nodes, iterated->solver);
    } else if (factored != NULL) {
        snprintf(out, size, "%s: factored at every size; at %d nodes %s.", name, factored->nodes,
                 factored->solver);
    } else if (iterated != NULL) {
        snprintf(out, size, "%s: %s.", name, iterated->solver);
    }
    return factored != NULL || iterated != NULL;
}

static void print_solvers(const report *r)
{
    char text[512];
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        if (tell_solver(r, s, text, sizeof text)) {
            printf("%s\n", text);
        }
    }
}

static void print_ellipsoids(const report *r)
{
    printf("%6s %8s %7s %10s %10s %9s %9s %9s %9s %7s %10s %10s %9s  %s\n", "points", "case",
           "active", "p50 us", "p99 us", "sub-steps", "us each", "prototype", "paper ms", "jump %",
           "ledger", "to direct", "to all", "verdict");
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        if (is_block(at)) {
            continue;
        }
        printf("%6d %8s %7d", at->points, at->name, at->active_nodes);
        print_cell(10, 1, at->p50_us);
        print_cell(10, 1, at->p99_us);
        print_cell(9, 2, at->substeps);
        print_cell(9, 1, at->p50_us / at->substeps);
        print_cell(9, 0, at->prototype_us);
        print_cell(9, 1, at->paper_ms);
        print_cell(7, 2, 100.0 * at->jump);
        print_small(10, 2, at->ledger);
        print_small(10, 1, at->direct_error);
        print_small(9, 1, at->apart);
        printf("  %s\n", at->verdict);
    }
    printf("\n");
}

static void print_rows(const report *r)
{
    if (r->options->size_count > 0) {
        print_ellipsoids(r);
    }
    printf("%-24s %8s %9s %10s %10s %10s %12s %9s  %s\n", "block", "nodes", "create s", "memory MB",
           "peak MB", "p50 us", "ns a node", "sub-steps", "verdict");
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        if (is_block(at)) {
            printf("%-24s %8d", at->model, at->nodes > 0 ? at->nodes : at->points);
            print_cell(9, 2, at->create_s);
            print_cell(10, 1, at->memory_mb);
            print_cell(10, 1, at->peak_mb);
            print_cell(10, 1, at->p50_us);
            print_cell(12, 1, 1e3 * at->p50_us / at->substeps / at->nodes);
            print_cell(9, 2, at->substeps);
            printf("  %s\n", at->verdict);
        }
    }
    print_solvers(r);
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
    fprintf(file, "set logscale xy\nset grid\nset key outside right\nset xrange [%d:%d]\n",
            r->options->size[0] * 2 / 3, r->options->size[r->options->size_count - 1] * 3 / 2);
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

/* A picture of one figure of the blocks against nodes, a line a model. */
static softsim_status plot_blocks(const report *r, bool is_memory, ss_page *page,
                                  softsim_error *error)
{
    ss_output script;
    const char *name = is_memory ? "scaling-memory" : "scaling-models";
    const softsim_status status = ss_plot_open(&script, r->options->out, name, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        fprintf(file, "$m%d << EOD\n", s);
        for (int32_t i = 0; i < r->row_count; ++i) {
            const row *at = &r->row[i];
            const double value = is_memory ? at->peak_mb : 1e-3 * at->p50_us;
            if (is_block(at) && strcmp(at->model, ss_assay_subject_name(s)) == 0 && at->nodes > 0 &&
                !isnan(value)) {
                fprintf(file, "%d %.6g\n", at->nodes, value);
            }
        }
        fputs("EOD\n", file);
    }
    fprintf(file,
            "set logscale xy\nset grid\nset key outside right\nset xlabel 'nodes'\n"
            "set ylabel '%s'\nplot ",
            is_memory ? "MB, largest, set-up included" : "ms of thread CPU for 1 ms of time");
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        const char *name_of_model = ss_assay_subject_model(s);
        const ss_model_class *model = ss_accuracy_model_find(name_of_model);
        const bool is_second = s > 0 && strcmp(name_of_model, ss_assay_subject_model(s - 1)) == 0;
        fprintf(file,
                "%s$m%d using 1:2 with linespoints pt 7 ps 0.6 lw 2 dt %d lc rgb '%s' title '%s'",
                s > 0 ? ", " : "", s, is_second ? 2 : 1,
                model != NULL ? model->hints->colour : "black", ss_assay_subject_name(s));
    }
    fputc('\n', file);
    return ss_page_plot(page, &script, name,
                        is_memory ? "Peak memory of the block." : "The block, every model.", error);
}

static void put_blocks(ss_page *page, const report *r)
{
    static const char *const head[] = {
        "model",        "nodes",   "create, CPU s", "memory, MB",
        "peak, MB",     "p50, us", "sub-steps",     "ns a node and sub-step",
        "active nodes", "ledger",  "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        ss_row cells = {.count = 0};
        if (!is_block(at)) {
            continue;
        }
        ss_row_add(&cells, "%s", at->model);
        ss_row_add(&cells, "%d", at->nodes > 0 ? at->nodes : at->points);
        ss_row_add_number(&cells, at->create_s);
        ss_row_add_number(&cells, at->memory_mb);
        ss_row_add_number(&cells, at->peak_mb);
        ss_row_add_number(&cells, at->p50_us);
        ss_row_add_number(&cells, at->substeps);
        ss_row_add_number(&cells, 1e3 * at->p50_us / at->substeps / at->nodes);
        ss_row_add(&cells, "%d", at->active_nodes);
        ss_row_add_number(&cells, at->ledger);
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static void put_table(ss_page *page, const report *r)
{
    static const char *const head[] = {"points",
                                       "case",
                                       "active nodes",
                                       "p50, us",
                                       "p99, us",
                                       "model step alone, us",
                                       "sub-steps",
                                       "us a sub-step",
                                       "prototype, us",
                                       "paper, ms",
                                       "jump, %",
                                       "mean force, N",
                                       "ledger",
                                       "field error against a direct solve",
                                       "field error against all nodes active",
                                       "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const row *at = &r->row[i];
        ss_row cells = {.count = 0};
        if (is_block(at)) {
            continue;
        }
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
        ss_row_add_number(&cells, at->direct_error);
        ss_row_add_number(&cells, at->apart);
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static softsim_status put_ellipsoids(ss_page *page, const report *r, softsim_error *error)
{
    ss_page_text(
        page,
        "An ellipsoid of 100 x 60 x 60 mm, held below, cnn-energy, one thread, steps "
        "of 1 ms (sub-steps inside where stability needs them). load: 0.2 N on one "
        "node, no tool, all nodes active. slide: a sphere of 5 mm pressed 6 mm deep, moved 30 "
        "mm at 50 mm/s, released. poke: the same ellipsoid, larger, so that its edges are 4 "
        "mm long at every size, pretension 0.05 J; 0.1 N on the nodes within 10 mm of the "
        "top; with all nodes active (poke all), and with the active window. pull: 0.5 N "
        "upwards on the body of poke, all nodes active.");
    const softsim_status status = plot_times(r, page, error);
    put_table(page, r);
    ss_page_text(page, "p50, p99: thread CPU time of whole ticks (model step, contact and haptic "
                       "tick) while loaded or sliding; beside it the median of the model's step "
                       "with its contact over the whole run. Jump: largest change between two "
                       "consecutive 1 kHz forces over the mean force while sliding at constant "
                       "speed. Ledger: (elastic + kinetic + dissipated - work) at the end over the "
                       "largest stored energy; the slide ends free and at rest, the load still "
                       "loaded. Prototype: a Runge-Kutta step of the first "
                       "program that tried this model, one core of another machine, all nodes.");
    ss_page_text(
        page,
        "Field error: the largest distance between the model's displacements and others, over "
        "the largest of these. Against a direct solve: the equilibrium of the same body under "
        "the same load, assembled anew from the mesh in double and solved with sparse factors "
        "of its own, potentials and shape, their residuals checked; of load, pull and poke at the "
        "end of the run, of slide when the sphere, pressed in, has stood still for half a "
        "second. There the direct solve is given the displacements of what the sphere touches "
        "and of the neighbours, and finds all others: it does not judge the contact itself. "
        "Nor does it judge how far a field in motion is from its equilibrium. Where the round "
        "surface is pressed in it shortens before it stretches, and the network answers by its "
        "pretension alone: pull is the row in which the modulus acts at every size. Against all "
        "nodes active: the field of poke against that of poke all, what the active window "
        "costs. A refused case has no field; where the direct solve fails, the verdict says why.");
    return status;
}

static softsim_status write_page(const report *r, softsim_error *error)
{
    ss_page page;
    char text[512];
    softsim_status status =
        ss_page_open(&page, r->options->out, "scaling", "softsim: scaling", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (r->options->size_count > 0) {
        status = put_ellipsoids(&page, r, error);
    }
    ss_page_heading(&page, "Every model");
    ss_page_text(
        &page,
        "A cube of 100 mm of 10 kPa in tetrahedra (its surface for a model that lives "
        "there), held below, one node of the top pushed (chainmail, which keeps its shape: "
        "moved by an edge in the course of the run); ticks of 1 ms, at most %d of "
        "them. A process each: peak memory is the whole of it, with reading the mesh and "
        "the factors; create is the CPU time of all that comes before the first tick. "
        "Where the sparse factor of cnn-energy would take more than %.0e multiplications, "
        "or have more entries than an int counts, conjugate gradients find the columns "
        "(below: where); tools, which need all columns, are refused by name long before. "
        "No field error stands beside these: a direct solve is made for the ellipsoids of "
        "cnn-energy alone, which end at %d points; softsim-bench accuracy compares the fields of "
        "all models with references.",
        200, SS_CNN_MAX_WORK, LARGEST_ELLIPSOID);
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        if (tell_solver(r, s, text, sizeof text)) {
            ss_page_text(&page, "%s", text);
        }
    }
    put_blocks(&page, r);
    if (status == SOFTSIM_OK) {
        status = plot_blocks(r, false, &page, error);
    }
    if (status == SOFTSIM_OK) {
        status = plot_blocks(r, true, &page, error);
    }
    ss_page_yardstick(&page, &r->yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

/* ---- the run ---- */

static int run_report(int argc, char **argv)
{
    static report r; /* large */
    options o;
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    r.options = &o;
    softsim_status status = ss_report_begin(o.out, r.folder, &error);
    if (status == SOFTSIM_OK) {
        status = measure_blocks(&r, &error);
    }
    ss_scratch_remove(r.folder);
    if (status == SOFTSIM_OK && !r.blocks.is_complete) { /* another rank writes the report */
        ss_sweep_result_fini(&r.blocks);
        return EXIT_SUCCESS;
    }
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
    if (status == SOFTSIM_OK) {
        ss_sweep_forget(&r.sweep, &r.blocks);
    }
    ss_sweep_result_fini(&r.blocks);
    if (status == SOFTSIM_OK) {
        printf("%s/scaling.html\n", o.out);
    }
    return ss_args_finish(argv[0], status, &error);
}

const ss_report_class ss_report_scaling = {
    .name = "scaling",
    .about = "step time, smoothness and energy against the number of nodes",
    .run = run_report};
