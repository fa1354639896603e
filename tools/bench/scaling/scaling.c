/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench scaling: what a millisecond of the body of common/body.h costs at several sizes,
 * how far its field is from that of a direct solve in double (as common/body.h defines it), how
 * smooth the force of a sliding tool is, and whether energy adds up over press, slide and release.
 * Then what the block of block.h costs with every model, to a million nodes, and where a model
 * gives way; and what of the processor's arithmetic the elements of `fem` and `fem-quadratic` use.
 * Beside it Table 1 of the paper on which cnn-energy is built (Zhong, Shirinzadeh, Alici, Smith
 * 2006; Pentium 4, 2.8 GHz), whose rates are given as the time of a step.
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
#include "bench/scaling/scaling.h"
#include "bench/stability/stress_case.h"
#include "case/scratch.h"
#include "process.h"
#include "rt/args.h"
#include "rt/order.h"

enum { LEAST_POINTS = 200, MOST_POINTS = 1000000 };
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

/* ---- options ---- */

/* Numbers with commas, sorted; returns how many. */
static int32_t parse_points(const char *points, int32_t out_size[SS_SCALING_MAX_SIZES],
                            softsim_error *error)
{
    const char *at = points;
    int32_t count = 0;
    do {
        char *end = NULL;
        const long value = strtol(at, &end, 10);
        if (end == at || (*end != ',' && *end != '\0') || value < LEAST_POINTS ||
            value > MOST_POINTS || count == SS_SCALING_MAX_SIZES) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--points: '%s' is not a list of at most %d numbers of %d to %d, "
                              "with commas",
                              points, SS_SCALING_MAX_SIZES, LEAST_POINTS, MOST_POINTS);
            return 0;
        }
        out_size[count++] = (int32_t)value;
        at = *end == ',' ? end + 1 : end;
    } while (*at != '\0');
    qsort(out_size, (size_t)count, sizeof *out_size, ss_compare_ints);
    return count;
}

static void choose_sizes(ss_scaling_options *o, softsim_error *error)
{
    const char *ellipsoids = o->points != NULL ? o->points
                             : o->is_quick     ? quick_points
                                               : standard_points;
    o->size_count = parse_points(ellipsoids, o->size, error);
    while (o->size_count > 0 && o->size[o->size_count - 1] > SS_SCALING_LARGEST_ELLIPSOID) {
        --o->size_count;
    }
    if (o->points != NULL) {
        o->block_count = error->fault_count > 0 ? 0 : parse_points(o->points, o->block, error);
    } else {
        o->block_count =
            parse_points(o->is_quick ? quick_block_points : block_points, o->block, error);
    }
}

static ss_args_result parse_options(int argc, char **argv, ss_scaling_options *o,
                                    softsim_error *error)
{
    *o = (ss_scaling_options){.out = "scaling-report", .jobs = 1};
    const ss_arg rows[] = {
        SS_TEXT("--points", &o->points, "N,N,...",
                "sizes (ellipsoids 300 to 100000, with those of the paper; blocks 300 to 1000000)"),
        SS_FLAG("--quick", &o->is_quick, "sizes up to 20000"),
        {"--jobs", SS_ARG_INTEGER, &o->jobs, 1, SS_SWEEP_MAX_JOBS, "N",
         "blocks at a time (1; more disturb one another's times)"},
        SS_TEXT("--out", &o->out, "DIR", "for the report (scaling-report)"),
    };
    const ss_args_result result =
        SS_ARGS_OPTIONS(argc, argv, "[options]",
                        "Measures step time, smoothness of a slide and the energy balance against "
                        "the number of nodes.",
                        rows, error);
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

static void add_row(ss_scaling *r, const char *name, int32_t points, ss_body_run *run, double apart)
{
    ss_scaling_row *to = &r->row[r->row_count++];
    *to = (ss_scaling_row){.points = points,
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
                           .balance = run->balance};
    snprintf(to->verdict, sizeof to->verdict, "%s%s%s%s%s",
             run->is_refused ? "refused" : softsim_verdict_name(run->worst),
             run->reason[0] != '\0' ? ": " : "", run->reason,
             run->direct_reason[0] != '\0' ? "; no field error: " : "", run->direct_reason);
}

/* The local poke with all nodes active and with the active set, and how far apart they are. */
static softsim_status measure_pokes(ss_scaling *r, ss_body *body, softsim_error *error)
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
static softsim_status measure_size(ss_scaling *r, ss_body *body, int32_t points, bool *out_refused,
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
    if (status == SOFTSIM_OK && !load.is_refused && points >= SS_SCALING_ACTIVE_SET_POINTS) {
        status = measure_pokes(r, body, error);
    }
    ss_body_run_fini(&slide);
    ss_body_run_fini(&load);
    ss_body_run_fini(&pull);
    return status;
}

static softsim_status measure(ss_scaling *r, softsim_error *error)
{
    ss_body body;
    const ss_scaling_options *o = r->options;
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
    return index % ss_stress_case_subject_count();
}

static int32_t block_size(const void *context, int32_t index)
{
    const ss_scaling *r = context;
    return r->options->block[index / ss_stress_case_subject_count()];
}

static void block_label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    snprintf(out, SS_SWEEP_NAME_SIZE, "%s,%d",
             ss_stress_case_subject_name(block_subject(context, index)),
             block_size(context, index));
}

static softsim_status block_run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const ss_scaling *r = context;
    ss_block_run run;
    const softsim_status status = ss_block_measure(r->folder, block_subject(context, index),
                                                   block_size(context, index), &run, error);
    if (status == SOFTSIM_OK) {
        fprintf(out, "%d %d %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n%s\n%s\n", run.nodes,
                run.active_nodes, run.create_s, run.memory_mb, run.peak_mb, run.p50_us, run.p99_us,
                run.substeps, run.balance, run.solver, run.verdict);
    }
    return status;
}

static void add_block(ss_scaling *r, const ss_sweep_run *run, int32_t index)
{
    ss_scaling_row *to = &r->row[r->row_count++];
    *to = (ss_scaling_row){.points = block_size(r, index),
                           .name = "block",
                           .model = ss_stress_case_subject_name(block_subject(r, index))};
    to->p50_us = to->p99_us = to->substeps = to->create_s = to->memory_mb = to->peak_mb =
        to->balance = to->step_us = to->paper_ms = to->prototype_us = to->jump = to->mean_force =
            to->direct_error = to->apart = NAN;
    int used = 0;
    if (!run->is_lost &&
        sscanf(run->text, "%d %d %lf %lf %lf %lf %lf %lf %lf%n", &to->nodes, &to->active_nodes,
               &to->create_s, &to->memory_mb, &to->peak_mb, &to->p50_us, &to->p99_us, &to->substeps,
               &to->balance, &used) == 9) {
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
static softsim_status measure_blocks(ss_scaling *r, softsim_error *error)
{
    r->sweep = (ss_sweep){.folder = r->options->out,
                          .name = "scaling",
                          .count = r->options->block_count * ss_stress_case_subject_count(),
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

/* ---- the run ---- */

static int run_report(int argc, char **argv)
{
    static ss_scaling r; /* large */
    ss_scaling_options o;
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
        status = ss_scaling_measure_elements(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        status = measure(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        ss_scaling_print(&r);
        ss_scaling_print_elements(&r);
        status = ss_scaling_write_csv(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_scaling_write_elements(&r, &error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_scaling_write_page(&r, &error);
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
