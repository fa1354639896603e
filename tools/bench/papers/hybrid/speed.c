/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * How fast tetrahedra step, integration included: ns of an element and sub-step, and how many of
 * them one core simulates in real time. Shown, not claimed: times are this machine's.
 */
#include <stdio.h>

#include "bench/core/element_speed.h"
#include "bench/papers/hybrid/hybrid.h"

/* The body of 30 thousand is the size at which the two kinds reach real time. */
static const ss_element_speed_case cases[] = {
    {.model = "fem", .elements = 20000, .rounds = 15},
    {.model = "fem", .elements = 20000, .rounds = 15, .is_shuffled = true},
    {.model = "fem", .elements = 20000, .rounds = 15, .is_viscous = true},
    {.model = "fem", .elements = 20000, .rounds = 15, .is_viscous = true, .is_shuffled = true},
    {.model = "fem", .elements = 20000, .rounds = 15, .is_cured = true},
    {.model = "fem", .elements = 26000, .rounds = 15, .is_viscous = true},
    {.model = "fem", .elements = 32500, .rounds = 15},
    {.model = "fem", .elements = 100000, .rounds = 15},
    {.model = "fem", .elements = 100000, .rounds = 15, .is_shuffled = true},
    {.model = "fem", .elements = 100000, .rounds = 15, .is_viscous = true},
    {.model = "fem", .elements = 100000, .rounds = 15, .is_viscous = true, .is_shuffled = true},
};
enum { CASE_COUNT = sizeof cases / sizeof cases[0], QUICK_COUNT = 5 };

static void show(ss_paper *paper, const ss_element_speed_case *what, const ss_element_speed *speed)
{
    ss_row cells = {.count = 0};
    ss_row_add(&cells, "%d", speed->elements);
    ss_row_add(&cells, "%s", what->is_viscous ? "viscous" : "elastic");
    ss_row_add(&cells, "%s", what->is_cured ? "nodal pressure" : "none");
    ss_row_add(&cells, "%s", what->is_shuffled ? "shuffled" : "sorted");
    ss_row_add_number(&cells, speed->ns);
    ss_row_add_number(&cells, speed->realtime);
    ss_row_add_number(&cells, speed->realtime_half);
    ss_row_add_number(&cells, speed->realtime_most);
    ss_row_add_number(&cells, speed->flop_share);
    ss_row_add_number(&cells, speed->bandwidth_share);
    ss_page_table_row(&paper->page, cells.count, cells.cell);
}

softsim_status ss_heart_speed(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"tetrahedra",
                                       "stress",
                                       "cure for locking",
                                       "file",
                                       "ns an element and sub-step",
                                       "simulated s a s, at 0.5 dt*",
                                       "elements in real time",
                                       "the same at 0.9 dt*",
                                       "of the multiply-adds",
                                       "of the bandwidth"};
    ss_yardstick yardstick;
    ss_output csv;
    softsim_status status = ss_paper_csv_open(
        paper, &csv, "speed",
        "elements,is_viscous,is_cured,is_shuffled,ns,stable_step_s,realtime,realtime_elements_half,"
        "realtime_elements_most,flop_share,bandwidth_share",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_yardstick_measure(&yardstick);
    ss_page_text(&paper->page,
                 "fem on the ellipsoid of 50, 35 and 25 mm, E 3 kPa, Poisson's ratio 0.45, its "
                 "lowest fifth fixed, on one core; the viscous stress is the paper's damping.");
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    const int count = paper->is_quick ? QUICK_COUNT : CASE_COUNT;
    for (int k = 0; k < count && status == SOFTSIM_OK; ++k) {
        ss_element_speed speed;
        ss_paper_progress(paper, (double)k / count);
        status = ss_element_speed_measure(&cases[k], &yardstick, &speed, error);
        if (status == SOFTSIM_OK) {
            show(paper, &cases[k], &speed);
            fprintf(csv.file, "%d,%d,%d,%d,%.4g,%.4g,%.4g,%.6g,%.6g,%.3g,%.3g\n", speed.elements,
                    cases[k].is_viscous, cases[k].is_cured, cases[k].is_shuffled, speed.ns,
                    speed.stable_step_s, speed.realtime, speed.realtime_half, speed.realtime_most,
                    speed.flop_share, speed.bandwidth_share);
        }
    }
    ss_page_table_end(&paper->page);
    if (status != SOFTSIM_OK) {
        ss_output_abandon(&csv);
        return status;
    }
    return ss_paper_csv_close(paper, &csv, "speed", error);
}
