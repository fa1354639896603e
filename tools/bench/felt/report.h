/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the reports of given paths share: a sweep over scenes, some runs each, whose rows of text
 * become a table, a page and lines. Thread: main. */
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/felt/scenes.h"

typedef struct ss_felt_report {
    const struct ss_felt_kind *kind;
    const char *out;
    ss_arg_list scene_list, set;
    int64_t jobs;
    ss_felt_scenes scenes;
} ss_felt_report;

typedef struct ss_felt_kind {
    const char *name;  /* of its files */
    const char *title; /* of its page */
    const char *head;  /* of its table */
    size_t size;       /* of what begins with an ss_felt_report */
    int32_t runs;      /* of a scene */
    const char *(*run_name)(int32_t run);
    /* Its own options beside SS_FELT_ROWS; all else is 0. */
    ss_args_result (*parse)(int argc, char **argv, ss_felt_report *report, softsim_error *error);
    void (*label)(const void *report, int32_t index, char out[SS_SWEEP_NAME_SIZE]);
    softsim_status (*run)(const void *report, int32_t index, FILE *out, softsim_error *error);
    softsim_status (*write_page)(const ss_felt_report *report, const ss_sweep_result *result,
                                 ss_page *page, softsim_error *error);
    void (*print_more)(const ss_sweep_result *result); /* or NULL */
} ss_felt_kind;

#define SS_FELT_ROWS(report)                                                                       \
    SS_LIST("--scene", &(report)->scene_list, "SCENE.yaml",                                        \
            "a scene with a tool; may be given again (all bundled scenes)"),                       \
        SS_LIST("--set", &(report)->set, "PATH=VALUE",                                             \
                "overrides one value of the scenes; may be given again"),                          \
        {"--jobs", SS_ARG_INTEGER,      &(report)->jobs, 1, SS_SWEEP_MAX_JOBS,                     \
         "N",      "runs at a time (1)"},                                                          \
        SS_TEXT("--out", &(report)->out, "DIR", "for the report (felt-report)")

/* Numbers with commas between them into out[most]; their count, or -1 and a fault. */
int32_t ss_felt_numbers(const char *option, bool is_whole, const char *text, double low,
                        double high, int32_t most, double *out, softsim_error *error);
/* As ss_report_class.run. */
int ss_felt_report_run(int argc, char **argv, const ss_felt_kind *kind);

bool ss_felt_has_rows(const ss_sweep_run *run);
/* Says of a scene's runs which were not done, and why. */
void ss_felt_page_lost(const ss_felt_report *report, ss_page *page, const ss_sweep_run *run);
/* A picture of panels of forces, one below the other; `more` is gnuplot's, of all of them. */
softsim_status ss_felt_plot_open(const ss_felt_report *report, ss_output *script,
                                 const char *picture, int32_t panels, int32_t panel_height,
                                 const char *more, softsim_error *error);
