/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The whole of softsim-bench accuracy, as the run fills it and the page shows it. Thread: main. */
#include <stdbool.h>
#include <stdint.h>

#include "bench/accuracy/accuracy.h"
#include "bench/accuracy/scene.h"
#include "rt/args.h"

typedef struct ss_accuracy_options {
    ss_arg_list cases, compare, set;
    const char *scene, *model, *mesh, *out;
    double budget_us;
    int64_t jobs;
    bool is_quick;
} ss_accuracy_options;

typedef struct ss_accuracy {
    ss_accuracy_options o;
    ss_accuracy_plan plan, dynamic; /* share their cases */
    ss_accuracy_rows rows;
    char *dynamics; /* lines of dynamics.csv */
    ss_yardstick yardstick;
    char found[SS_ACCURACY_MAX_CASES][SS_CASE_PATH]; /* folders of the standard cases */
    int32_t found_count;
    ss_accuracy_worth worth; /* of a scene's reference */
} ss_accuracy;

/* ---- page.c ---- */

softsim_status ss_accuracy_write_dynamics(ss_accuracy *r, softsim_error *error);
softsim_status ss_accuracy_write_page(ss_accuracy *r, softsim_error *error);
