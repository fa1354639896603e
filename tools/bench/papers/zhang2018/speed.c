/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * How fast the network steps, on the liver and on blocks of elements of one size: a poke must cost
 * the same however large the body is, since only cells near it move.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/papers/zhang2018/chain_speed.h"
#include "bench/papers/zhang2018/zhang2018.h"

static void show(ss_paper *paper, const ss_chain_speed *row, int32_t count)
{
    static const char *const head[] = {"body",
                                       "nodes",
                                       "full step, us",
                                       "a poke's step, us",
                                       "cells it moves",
                                       "frame of eight, us",
                                       "slowest frame, us"};
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t r = 0; r < count; ++r) {
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", row[r].body);
        ss_row_add(&cells, "%d", row[r].nodes);
        ss_row_add_number(&cells, row[r].full_us > 0.0 ? row[r].full_us : (double)NAN);
        ss_row_add_number(&cells, row[r].poke_us);
        ss_row_add_number(&cells, row[r].visits);
        ss_row_add_number(&cells, row[r].frame_us);
        ss_row_add_number(&cells, row[r].frame_max_us);
        ss_page_table_row(&paper->page, cells.count, cells.cell);
    }
    ss_page_table_end(&paper->page);
}

static softsim_status write_csv(ss_paper *paper, const ss_chain_speed *row, int32_t count,
                                softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_paper_csv_open(
        paper, &csv, "speed", "body,nodes,elements,full_us,poke_us,visits,frame_us,frame_max_us",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t r = 0; r < count; ++r) {
        fprintf(csv.file, "%s,%d,%d,%.4g,%.4g,%.6g,%.4g,%.4g\n", row[r].body, row[r].nodes,
                row[r].elements, row[r].full_us, row[r].poke_us, row[r].visits, row[r].frame_us,
                row[r].frame_max_us);
    }
    return ss_paper_csv_close(paper, &csv, "speed", error);
}

/* Counts are claimed, times shown: they are this machine's. */
static void claim(ss_paper *paper, const ss_chain_speed *row, int32_t count)
{
    double least = (double)INFINITY, most = 0.0;
    for (int32_t r = 0; r < count; ++r) {
        if (strncmp(row[r].body, "block", 5) == 0) {
            least = fmin(least, row[r].visits);
            most = fmax(most, row[r].visits);
        }
    }
    ss_claim_at_most(paper, "section 1", SS_FROM_CLOSED_FORM, 1.05, most / least,
                     "a poke moves as many cells in large bodies as in small ones: most over least "
                     "of blocks of %d to %d nodes",
                     row[1].nodes, row[count - 1].nodes);
    ss_claim_at_most(paper, "section 1", SS_FROM_PAPER, 1000.0, row[0].frame_us,
                     "real time: a haptic frame of eight sub-steps on the liver, us of 1000");
}

softsim_status ss_zhang_speed(ss_paper *paper, softsim_error *error)
{
    ss_chain_speed row[SS_CHAIN_SPEED_ROWS];
    ss_zhang_solid liver;
    softsim_status status = ss_zhang_liver_make(paper, &liver, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "The paper: fast enough for real time, without figures. Here: thread CPU times of "
                 "one core, without the coarse level; a poke is the first 200 steps of one.");
    const int32_t count = ss_chain_speed_measure(liver.mesh, paper->is_quick, row, error);
    if (count < 2) {
        status = error->status != SOFTSIM_OK ? error->status : SOFTSIM_ERROR_SYSTEM;
    } else {
        show(paper, row, count);
        claim(paper, row, count);
        status = write_csv(paper, row, count, error);
    }
    ss_zhang_solid_fini(&liver);
    return status;
}
