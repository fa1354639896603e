/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The runs of the stability report and what came of them: runs.c lists and does them, page.c
 * writes them down, stability.c is the report. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/core/sweep.h"
#include "bench/core/yardstick.h"
#include "bench/stability/stress_case.h"
#include "softsim/types.h"

enum { SS_STABILITY_MAX_MODELS = 16 };

/* The list. */
typedef struct ss_stability {
    ss_stress_case *trial;
    int32_t count;
    const char *folder;  /* of the report */
    const char *scratch; /* where runs keep their files while they last */
} ss_stability;

/* What a run left, read back from its text. */
typedef struct ss_stability_row {
    bool is_lost, is_agreed;
    ss_stress_case_outcome outcome;
    softsim_verdict verdict;
    uint32_t found;
    int32_t inverted;
    char acted[160];
    const char *csv; /* its line */
} ss_stability_row;

/* The runs for the models of `only` (NULL-ended; empty: all). False: out of memory.
 * ss_stability_list_fini afterwards. */
bool ss_stability_list(ss_stability *list, const char *const *only, bool is_quick);
void ss_stability_list_fini(ss_stability *list);
/* As ss_sweep calls it. */
void ss_stability_label(const void *list, int32_t index, char out[SS_SWEEP_NAME_SIZE]);
softsim_status ss_stability_run(const void *list, int32_t index, FILE *out, softsim_error *error);
/* Reads what run `index` left. */
void ss_stability_read(const ss_sweep_result *result, int32_t index, ss_stability_row *out);

/* stability.csv, the maps and the page. */
softsim_status ss_stability_report(const ss_stability *list, const ss_sweep_result *result,
                                   const ss_yardstick *yardstick, softsim_error *error);
/* Counts, and every failure in a line; returns the number of failures. */
int32_t ss_stability_print(const ss_stability *list, const ss_sweep_result *result);
