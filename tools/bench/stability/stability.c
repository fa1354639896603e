/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stability.h"
/*
 * softsim-bench stability: what breaks a model, and whether the program says so. Every model that
 * is built in, over stiffness, step, Poisson's ratio, mass ratio, slivers, teleports, forces,
 * tangled and flattened starts, fast and abused probes and contradictory boundary conditions; each
 * run judged by the program and, from what it publishes alone, by audit.h. Exit 1 when they
 * disagree anywhere, or when what must be stable is not.
 */
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/core/report.h"
#include "case/scratch.h"
#include "models/model.h"
#include "process.h"
#include "rt/args.h"
#include "rt/memory.h"

enum { TEXT_SIZE = 4096 };
static const double run_timeout_s = 120.0;

typedef struct options {
    const char *out, *models;
    bool is_quick;
    int64_t jobs;
    char names[TEXT_SIZE];
    const char *only[SS_STABILITY_MAX_MODELS + 1]; /* NULL-ended */
} options;

/* Processors that this process may use, as jobs: under mpirun often one. */
static int64_t count_processors(void)
{
    cpu_set_t set;
    const int count = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return count < SS_SWEEP_MAX_JOBS ? count : SS_SWEEP_MAX_JOBS;
}

static void parse_models(options *o, softsim_error *error)
{
    int32_t count = 0;
    snprintf(o->names, sizeof o->names, "%s", o->models);
    for (char *at = o->names; at != NULL;) {
        const char *name = strsep(&at, ",");
        if (ss_model_find(name) == NULL || count == SS_STABILITY_MAX_MODELS) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--model: '%s' is no model of this program", name);
            return;
        }
        o->only[count++] = name;
    }
}

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.out = "stability-report", .jobs = count_processors()};
    const ss_arg rows[] = {
        SS_TEXT("--model", &o->models, "A,B", "these alone (all that are built in)"),
        SS_FLAG("--quick", &o->is_quick, "a quarter of the runs"),
        {"--jobs", SS_ARG_INTEGER, &o->jobs, 1, SS_SWEEP_MAX_JOBS, "N",
         "runs at a time (one a processor)"},
        SS_TEXT("--out", &o->out, "DIR", "for the report (stability-report)"),
    };
    const ss_args_result result = ss_args_parse(
        argc, argv, "[options]",
        "Tries to break every model, and checks that the program says so. A report that was "
        "stopped goes on when the same command is given again; mpirun shares the runs.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result == SS_ARGS_RUN && o->models != NULL) {
        parse_models(o, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

/* All runs, and the report by the rank that has them all. */
static softsim_status sweep_and_report(ss_stability *list, int32_t jobs, int32_t *out_failures,
                                       softsim_error *error)
{
    const ss_sweep sweep = {.folder = list->folder,
                            .name = "stability",
                            .count = list->count,
                            .jobs = jobs,
                            .timeout_s = run_timeout_s,
                            .context = list,
                            .label = ss_stability_label,
                            .run = ss_stability_run};
    ss_sweep_result result;
    ss_yardstick yardstick;
    softsim_status status = ss_sweep_execute(&sweep, &result, error);
    if (status == SOFTSIM_OK && result.is_complete) {
        ss_yardstick_measure(&yardstick);
        status = ss_stability_report(list, &result, &yardstick, error);
        if (status == SOFTSIM_OK) {
            *out_failures = ss_stability_print(list, &result);
            printf("%s/stability.html\n", list->folder);
            ss_sweep_forget(&sweep, &result);
        }
    }
    ss_sweep_result_fini(&result);
    return status;
}

static int run_report(int argc, char **argv)
{
    options o;
    ss_stability list = {.trial = NULL};
    softsim_error error = {.status = SOFTSIM_OK};
    char scratch[SS_SCRATCH_PATH] = "";
    int32_t failures = 0;
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    softsim_status status = ss_report_begin(o.out, scratch, &error);
    if (status == SOFTSIM_OK && !ss_stability_list(&list, o.only, o.is_quick)) {
        status = ss_memory_fault(&error);
    }
    if (status == SOFTSIM_OK) {
        list.folder = o.out;
        list.scratch = scratch;
        status = sweep_and_report(&list, (int32_t)o.jobs, &failures, &error);
    }
    ss_scratch_remove(scratch);
    ss_stability_list_fini(&list);
    exit_code = ss_args_finish(argv[0], status, &error);
    return failures == 0 ? exit_code : EXIT_FAILURE;
}

const ss_report_class ss_report_stability = {
    .name = "stability",
    .about = "what breaks a model, and whether the program says so",
    .run = run_report};
