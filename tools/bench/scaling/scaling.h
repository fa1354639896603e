/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the files of softsim-bench scaling share: sizes, rows, and how they are shown. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/core/element_speed.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/core/yardstick.h"
#include "case/scratch.h"

enum {
    SS_SCALING_MAX_SIZES = 32,
    SS_SCALING_LARGEST_ELLIPSOID = 100000, /* larger ones take longer to make than to measure */
    SS_SCALING_MAX_BLOCKS = 1024,
    SS_SCALING_CASES = 5,
    SS_SCALING_ELEMENT_CASES = 6,
    SS_SCALING_ACTIVE_SET_POINTS = 4096 /* smaller bodies have no active set */
};

typedef struct ss_scaling_options {
    const char *out, *points;
    bool is_quick;
    int64_t jobs;
    int32_t size[SS_SCALING_MAX_SIZES],
        block[SS_SCALING_MAX_SIZES]; /* of the ellipsoids, of the blocks */
    int32_t size_count, block_count;
} ss_scaling_options;

typedef struct ss_scaling_row {
    int32_t points, nodes, active_nodes;
    double substeps;
    const char *name;  /* of the case */
    const char *model; /* and its material */
    double p50_us, p99_us, step_us, paper_ms, prototype_us, jump, mean_force, balance;
    double create_s, memory_mb, peak_mb; /* of blocks */
    double direct_error;                 /* of the field against a direct solve: common/body.h */
    double apart; /* from the same poke with all nodes active, over the largest displacement */
    char solver[160];
    char verdict[384];
} ss_scaling_row;

typedef struct ss_scaling {
    const ss_scaling_options *options;
    ss_yardstick yardstick;
    char folder[SS_SCRATCH_PATH]; /* of the blocks' meshes */
    ss_sweep sweep;               /* of the blocks */
    ss_sweep_result blocks;
    ss_scaling_row row[SS_SCALING_CASES * SS_SCALING_MAX_SIZES + SS_SCALING_MAX_BLOCKS];
    int32_t row_count;
    ss_element_speed element[SS_SCALING_ELEMENT_CASES];
    const ss_element_speed_case *element_case[SS_SCALING_ELEMENT_CASES];
    int32_t element_count;
} ss_scaling;

/* ---- elements.c ---- */

/* What an element and sub-step take: bodies no larger than the largest block, of models that are
 * built in. */
softsim_status ss_scaling_measure_elements(ss_scaling *r, softsim_error *error);
void ss_scaling_print_elements(const ss_scaling *r);
void ss_scaling_put_elements(ss_page *page, const ss_scaling *r);
softsim_status ss_scaling_write_elements(const ss_scaling *r, softsim_error *error);

/* ---- page.c ---- */

softsim_status ss_scaling_write_csv(const ss_scaling *r, softsim_error *error);
void ss_scaling_print(const ss_scaling *r);
softsim_status ss_scaling_write_page(const ss_scaling *r, softsim_error *error);
