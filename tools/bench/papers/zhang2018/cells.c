/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The first of the paper's two wishes for the future: many chain elements in one neural cell.
 * The liver with 1, 4, 16 and 64 elements a cell, each beside the network of one element a cell at
 * the same time after the same poke, which
 * the report's reference program computes.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/static_fem.h"
#include "bench/papers/zhang2018/zhang2018.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

enum { RATIO_COUNT = 4, WAY_STEPS = 5, TIMED = 41 };
static const int32_t ratio[RATIO_COUNT] = {1, 4, 16, 64};
static const double depth = 0.004, until_s = 20.0; /* m; C = 1 s */

typedef struct cells_run {
    int32_t cells, steps;
    double step_s, us, error, frame_us; /* frame: of one C */
    bool is_there;
} cells_run;

static softsim_status run_cells(ss_zhang *zhang, const ss_zhang_solid *liver, int32_t per_cell,
                                cells_run *out, double (*u)[3], softsim_error *error)
{
    ss_zhang_run run;
    char cells[32];
    double us[TIMED];
    *out = (cells_run){.cells = liver->mesh->node_count / per_cell};
    ss_zhang_setup setup = ss_zhang_solid_setup(liver, "cnn-chainmail", depth);
    const char *const param[] = {"alpha=0", "link_stiffness_n_per_m=100", "capacitance_s=1",
                                 per_cell > 1 ? cells : "coarse_cells=0", NULL};
    snprintf(cells, sizeof cells, "cells=%d", out->cells);
    memcpy(setup.param, param, sizeof param);
    const softsim_status status = ss_zhang_begin(&setup, &run, error);
    if (status != SOFTSIM_OK || run.model == NULL) {
        ss_paper_miss(zhang->paper, run.reason, "%d chain elements a cell", per_cell);
        ss_zhang_end(&run);
        return status;
    }
    out->step_s = run.step_s;
    out->steps = (int32_t)ceil(until_s / run.step_s);
    for (int32_t k = 1; k <= out->steps; ++k) {
        const int64_t before = ss_clock_thread_cpu_ns();
        ss_zhang_step(&run, depth * fmin(1.0, k * run.step_s));
        if (out->steps - k < TIMED) {
            us[out->steps - k] = 1e-3 * (double)(ss_clock_thread_cpu_ns() - before);
        }
    }
    const int32_t timed = out->steps < TIMED ? out->steps : TIMED;
    qsort(us, (size_t)timed, sizeof *us, ss_compare_doubles);
    out->us = us[timed / 2];
    out->frame_us = out->us / run.step_s;
    ss_zhang_read(&run, u);
    out->is_there = true;
    ss_zhang_end(&run);
    return SOFTSIM_OK;
}

/* The network of one element a cell by the report's reference program, and the finite elements'
 * shape. */
static softsim_status run_reference(const ss_zhang_solid *liver, double step_s, int32_t steps,
                                    double (*out_u)[3], double *out_error, softsim_error *error)
{
    ss_zhang_reference reference;
    const size_t n = (size_t)liver->mesh->node_count;
    double(*fem)[3] = calloc(n, sizeof *fem), (*prescribed)[3] = calloc(n, sizeof *prescribed);
    uint8_t *held = malloc(n);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (fem != NULL && prescribed != NULL && held != NULL) {
        memcpy(held, liver->fixed, n);
        for (int32_t k = 0; k < liver->pushed_count; ++k) {
            held[liver->pushed[k]] = 7;
            ss_scale3(prescribed[liver->pushed[k]], liver->direction, depth);
        }
        status = ss_static_linear(liver->mesh, 1e4, 0.3, held, (const double(*)[3])prescribed, fem,
                                  NULL, error);
    } else {
        status = ss_memory_fault(error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_zhang_solid_reference(liver, 0.0, SS_REFERENCE_KEEP, &reference, error);
    }
    if (status == SOFTSIM_OK) {
        for (int32_t k = 1; k <= steps; ++k) {
            ss_zhang_reference_step(&reference, depth * fmin(1.0, k * step_s), step_s);
        }
        for (size_t i = 0; i < n; ++i) {
            ss_sub3(out_u[i], reference.at[i], reference.rest[i]);
        }
        ss_zhang_reference_fini(&reference);
        *out_error = ss_zhang_distance((int32_t)n, (const double(*)[3])out_u,
                                       (const double(*)[3])fem, liver->volume);
    }
    SS_EACH(free, fem, prescribed, held);
    return status;
}

static void put_run(FILE *file, const void *context, int32_t r)
{
    const cells_run *run = (const cells_run *)context + r;
    if (run->is_there) {
        fprintf(file, "%d,%d,%.6g,%.4g,%.4g,%.6g\n", ratio[r], run->cells, run->step_s, run->us,
                run->frame_us, run->error);
    }
}

static softsim_status show(ss_paper *paper, const cells_run *run, softsim_error *error)
{
    static const char *const head[] = {"elements a cell",
                                       "cells",
                                       "step, C",
                                       "CPU time a step, us",
                                       "CPU time for one C, us",
                                       "distance from the reference network"};
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int r = 0; r < RATIO_COUNT; ++r) {
        ss_row cells = {.count = 0};
        if (!run[r].is_there) {
            continue;
        }
        ss_row_add(&cells, "%d", ratio[r]);
        ss_row_add(&cells, "%d", run[r].cells);
        ss_row_add(&cells, "%.3f", run[r].step_s);
        ss_row_add(&cells, "%.1f", run[r].us);
        ss_row_add(&cells, "%.0f", run[r].frame_us);
        ss_row_add(&cells, "%.3f", run[r].error);
        ss_page_table_row(&paper->page, cells.count, cells.cell);
    }
    ss_page_table_end(&paper->page);
    return ss_paper_csv_write(paper, "cells",
                              "elements_per_cell,cells,step_s,us_per_step,us_per_c,error_l2",
                              RATIO_COUNT, put_run, run, error);
}

softsim_status ss_zhang_cells(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    cells_run run[RATIO_COUNT];
    ss_zhang_solid liver;
    softsim_status status = ss_zhang_liver_make(paper, &liver, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "The paper's first wish: several chain elements in one neural cell. The cells "
                 "move the elements by smooth weights (still a gradient flow of the same energy); "
                 "near the contact every element keeps a cell of its own. The poke is 4 mm, alpha "
                 "0, the shapes those %g C later. The same cells as a second level above the fine "
                 "ones are what the liver above has as its coarse level.",
                 until_s);
    const size_t n = (size_t)liver.mesh->node_count;
    double(*full)[3] = calloc(n, sizeof *full), (*u)[3] = calloc(n, sizeof *u);
    if (full == NULL || u == NULL) {
        status = ss_memory_fault(error);
    }
    double reference_error = (double)NAN;
    for (int r = 0; r < RATIO_COUNT && status == SOFTSIM_OK; ++r) {
        status = run_cells(zhang, &liver, ratio[r], &run[r], u, error);
        if (r == 0 && status == SOFTSIM_OK) {
            status =
                run_reference(&liver, run[0].step_s, run[0].steps, full, &reference_error, error);
        }
        run[r].error = ss_zhang_distance(liver.mesh->node_count, (const double(*)[3])u,
                                         (const double(*)[3])full, liver.volume);
        ss_paper_progress(paper, 0.25 * (r + 1));
    }
    if (status == SOFTSIM_OK) {
        status = show(paper, run, error);
    }
    for (int r = 1; r < RATIO_COUNT && status == SOFTSIM_OK; ++r) {
        if (run[0].is_there && run[r].is_there) {
            ss_claim_at_most(
                paper, "Conclusion", SS_FROM_CODE, 0.25 * reference_error, run[r].error,
                "%d elements a cell: distance of the shape from the reference network's "
                "with one a cell, at most a quarter of what that itself is off finite "
                "elements",
                ratio[r]);
        }
    }
    if (status == SOFTSIM_OK && run[0].is_there) {
        ss_page_text(&paper->page,
                     "Fewer cells have fewer states, but not less work on one core: every link is "
                     "still looked at, and the cells at the contact keep the step of single "
                     "elements. What they are good for is the coarse level.");
    }
    free(full);
    free(u);
    ss_zhang_solid_fini(&liver);
    return status;
}
