/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The liver under a probe (Fig. 6): the network, with and without its coarse level, and traditional
 * ChainMail, plain and tuned, each beside the same tetrahedra as a linear elastic body (nu 0.3) at
 * rest, which none of them shares anything with. The patch goes in at once; shapes are taken after
 * 10, 31, 84, 212 and 6000 steps; ChainMail follows the hand, 0.4 mm a step, and is at rest when
 * the patch is. The paper's network needs 300,000 steps for that, since what moves it spreads a
 * link at a time. A ChainMail has no time of its own, so models are compared after equal numbers of
 * steps, after equal CPU time, and both at rest.
 *
 * Error: sqrt(sum V |u - u_fem|^2 / sum V |u_fem|^2) over nodes, V a quarter of the volume around.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/static_fem.h"
#include "bench/papers/zhang2018/zhang2018.h"
#include "process.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

enum {
    MARKS = 6,
    LOOKS = 96,
    LATE = 3,
    LONG = 4,
    REST = 5,
    TIMED = 41,
    BATCHES = 61,
    BATCH = 10,
    MAIL_STEPS = 30,
    WARM_STEPS = 1500
};
static const int32_t mark[MARKS] = {10, 31, 84, 212, 6000, 300000};
static const double youngs_modulus = 1e4, poisson_ratio = 0.3;

/* C is 1 s and a step what the network calls stable: its figures count its own steps, the first,
 * in which the patch goes in, as one: the network divides it, a quarter of a link each. */
#define NETWORK "cnn-chainmail"
#define COMMON  "link_stiffness_n_per_m=100", "capacitance_s=1"

typedef double (*field)[3];

/* One row of the table. */
typedef struct shape_run {
    const char *name, *title, *model, *param[SS_ZHANG_MAX_PARAM];
    int32_t way;  /* steps in which the patch goes in */
    int32_t last; /* mark that it is run to */
    bool is_drawn, is_there;
    double error[MARKS], roughness, rise, us; /* -; mm; of the peak energy; a step */
    int32_t inverted[MARKS];
    double step_s;      /* s of the network */
    int32_t substeps;   /* of the first step, in which the patch goes in */
    int32_t look_count; /* on the way: steps, CPU time since the start, and the error then */
    int32_t look_step[LOOKS];
    double look_us[LOOKS], look_error[LOOKS];
} shape_run;

/* The body as the finite elements have it. */
static softsim_status solve_fem(const ss_zhang_solid *liver, double depth, field u,
                                softsim_error *error)
{
    const size_t n = (size_t)liver->mesh->node_count;
    uint8_t *held = malloc(n);
    field prescribed = calloc(n, sizeof *prescribed);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (held != NULL && prescribed != NULL) {
        memcpy(held, liver->fixed, n);
        for (int32_t k = 0; k < liver->pushed_count; ++k) {
            held[liver->pushed[k]] = 7;
            ss_scale3(prescribed[liver->pushed[k]], liver->direction, depth);
        }
        status = ss_static_linear(liver->mesh, youngs_modulus, poisson_ratio, held,
                                  (const double(*)[3])prescribed, u, NULL, error);
    } else {
        status = ss_memory_fault(error);
    }
    free(held);
    free(prescribed);
    return status;
}

/* What the body looks like at a mark. */
static void take_mark(const ss_zhang_solid *liver, const ss_zhang_run *run, const field fem, int m,
                      shape_run *row, field u)
{
    ss_zhang_read(run, u);
    row->error[m] = ss_zhang_distance(liver->mesh->node_count, (const double(*)[3])u,
                                      (const double(*)[3])fem, liver->volume);
    row->inverted[m] = ss_zhang_inverted(liver->mesh, (const double(*)[3])u);
}

/* Now and then on the way, more often at first. */
static void look(const ss_zhang_solid *liver, const ss_zhang_run *run, const field fem,
                 int32_t step, double us, shape_run *row, field scratch)
{
    if (row->look_count < LOOKS) {
        ss_zhang_read(run, scratch);
        row->look_step[row->look_count] = step;
        row->look_us[row->look_count] = us;
        row->look_error[row->look_count++] =
            ss_zhang_distance(liver->mesh->node_count, (const double(*)[3])scratch,
                              (const double(*)[3])fem, liver->volume);
    }
}

/* The error when so much CPU time has gone: the last look before. */
static double error_at(const shape_run *row, double us)
{
    double error = row->look_error[0];
    for (int32_t k = 0; k < row->look_count && row->look_us[k] <= us; ++k) {
        error = row->look_error[k];
    }
    return error;
}

/* Pushes, marks and times a model. u: 212 steps from the start; `scratch`: the last mark, when that
 * is a later one. */
static softsim_status run_shape(const ss_zhang_solid *liver, double depth, const field fem,
                                shape_run *row, field u, field scratch, ss_paper *paper,
                                softsim_error *error)
{
    ss_zhang_run run;
    ss_zhang_setup setup = ss_zhang_solid_setup(liver, row->model, depth);
    memcpy(setup.param, row->param, sizeof setup.param);
    setup.step_s = strcmp(row->model, NETWORK) == 0 ? 0.0 : 1e-3;
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    if (status != SOFTSIM_OK || run.model == NULL) {
        ss_paper_miss(paper, run.reason, "the liver by %s", row->title);
        ss_zhang_end(&run);
        return status;
    }
    double us[TIMED], peak = 0.0, spent_us = 0.0;
    int32_t timed = 0, next_look = 1;
    const int32_t last = mark[row->last];
    row->error[LONG] = row->error[REST] = (double)NAN;
    row->step_s = run.step_s;
    for (int32_t k = 1, m = 0; k <= last && status == SOFTSIM_OK; ++k) {
        const int64_t before = ss_clock_thread_cpu_ns();
        ss_zhang_step(&run, depth * fmin(1.0, (double)k / row->way));
        const double step_us = 1e-3 * (double)(ss_clock_thread_cpu_ns() - before);
        spent_us += step_us;
        row->substeps = k == 1 ? run.substeps : row->substeps;
        if (k > mark[LATE] - TIMED && k <= mark[LATE]) {
            us[timed++] = step_us;
        }
        peak = fmax(peak, ss_zhang_energy(&run));
        if (k == next_look) {
            look(liver, &run, fem, k, spent_us, row, scratch);
            next_look = k + 1 + k / 6;
        }
        if (k == mark[m]) {
            take_mark(liver, &run, fem, m, row, m <= LATE ? u : scratch);
            m += m + 1 < MARKS;
        }
        if (ss_process_is_stopped()) {
            status = SOFTSIM_ERROR_SYSTEM;
            softsim_error_add(error, status, "stopped before the end; nothing is reported");
        }
    }
    qsort(us, (size_t)timed, sizeof *us, ss_compare_doubles);
    row->us = us[timed / 2];
    row->roughness = 1e3 * ss_zhang_roughness(liver->mesh, liver->fixed, (const double(*)[3])u);
    row->rise = run.peak_energy_rise / fmax(peak, 1e-300);
    row->is_there = status == SOFTSIM_OK;
    ss_zhang_end(&run);
    return status;
}

/* Of errors, then of the rest; the last mark where a row has it. */
static void show_tables(ss_paper *paper, const shape_run *row, int32_t count)
{
    static const char *const errors[] = {
        "error against finite elements after steps", "10", "31", "84", "212", "6000", "300,000"};
    static const char *const others[] = {"tetrahedra inverted after steps",
                                         "10",
                                         "212",
                                         "300,000",
                                         "roughness after 212, mm",
                                         "CPU time a step, us"};
    ss_page_table_begin(&paper->page, MARKS + 1, errors);
    for (int32_t r = 0; r < count; ++r) {
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", row[r].title);
        for (int m = 0; m < MARKS; ++m) {
            ss_row_add_number(&cells, row[r].error[m]);
        }
        if (row[r].is_there) {
            ss_page_table_row(&paper->page, cells.count, cells.cell);
        }
    }
    ss_page_table_end(&paper->page);
    ss_page_table_begin(&paper->page, (int32_t)(sizeof others / sizeof *others), others);
    for (int32_t r = 0; r < count; ++r) {
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", row[r].title);
        ss_row_add(&cells, "%d", row[r].inverted[0]);
        ss_row_add(&cells, "%d", row[r].inverted[LATE]);
        ss_row_add_number(&cells, row[r].last == REST ? row[r].inverted[REST] : (double)NAN);
        ss_row_add(&cells, "%.3f", row[r].roughness);
        ss_row_add(&cells, "%.1f", row[r].us);
        if (row[r].is_there) {
            ss_page_table_row(&paper->page, cells.count, cells.cell);
        }
    }
    ss_page_table_end(&paper->page);
    for (int32_t r = 0; r < count; ++r) {
        if (row[r].is_there && row[r].last == REST) {
            const int32_t k = row[r].look_count - 1;
            ss_page_text(&paper->page,
                         "What is called at rest: %s, after %d steps; its error has fallen by %.2g "
                         "since step %d and goes on falling.",
                         row[r].title, mark[REST], row[r].look_error[k] - row[r].error[REST],
                         row[r].look_step[k]);
        }
    }
}

static softsim_status write_csv(ss_paper *paper, const char *name, const shape_run *row,
                                int32_t count, softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_paper_csv_open(
        paper, &csv, name, "model,step,error_l2,inverted,roughness_mm,us_per_step", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t r = 0; r < count; ++r) {
        for (int m = 0; m <= row[r].last && row[r].is_there; ++m) {
            fprintf(csv.file, "%s,%d,%.6g,%d,%.6g,%.4g\n", row[r].name, mark[m], row[r].error[m],
                    row[r].inverted[m], row[r].roughness, row[r].us);
        }
    }
    return ss_paper_csv_close(paper, &csv, name, error);
}

/* CPU time of ChainMail's whole poke. */
static double mail_us(const shape_run *row)
{
    return row->us * MAIL_STEPS;
}

/* ---- the two pokes ---- */

static const struct poke {
    const char *name, *title;
    double depth, alpha; /* m; - */
} deep_poke = {"12mm", "12 mm, alpha 0.02", 0.012, 0.02},
  shallow_poke = {"4mm", "4 mm, alpha 0", 0.004, 0.0};

enum { COARSE, FINE, UNGUARDED, MAIL_BOX, MAIL_RADIAL, MAIL_TUNED, RUN_COUNT };

#define COARSE_TITLE    "ours: the network with a coarse level of 64 cells and the tet guard"
#define FINE_TITLE      "the paper's network: no coarse level, no guard"
#define UNGUARDED_TITLE "ours without the tet guard"
static const shape_run deep_runs[RUN_COUNT] = {
    [COARSE] = {"network",
                COARSE_TITLE,
                NETWORK,
                {COMMON, "tet_guard=1", "coarse_cells=64", "alpha=0.02"},
                .way = 1,
                .last = LONG,
                .is_drawn = true},
    [FINE] = {"network-fine",
              FINE_TITLE,
              NETWORK,
              {COMMON, "tet_guard=0", "coarse_cells=0", "alpha=0.02"},
              .way = 1,
              .last = REST,
              .is_drawn = true},
    [UNGUARDED] = {"network-unguarded",
                   UNGUARDED_TITLE,
                   NETWORK,
                   {COMMON, "tet_guard=0", "coarse_cells=64", "alpha=0.02"},
                   .way = 1,
                   .last = LONG},
    [MAIL_BOX] = {"chainmail-box",
                  "ChainMail, box, alpha 0.02",
                  "chainmail",
                  {"alpha=0.02", "beta=0.5", "band=box"},
                  .way = MAIL_STEPS,
                  .last = LATE,
                  .is_drawn = true},
    [MAIL_RADIAL] = {"chainmail-radial",
                     "ChainMail, radial, alpha 0.02",
                     "chainmail",
                     {"alpha=0.02", "band=radial"},
                     .way = MAIL_STEPS,
                     .last = LATE},
    [MAIL_TUNED] = {"chainmail-tuned",
                    "ChainMail, box, alpha 0.15, 20 relaxations",
                    "chainmail",
                    {"alpha=0.15", "beta=0.5", "band=box", "relaxation_iterations=20"},
                    .way = MAIL_STEPS,
                    .last = LATE,
                    .is_drawn = true},
};
static const shape_run shallow_runs[UNGUARDED + 1] = {
    [COARSE] = {"network",
                COARSE_TITLE,
                NETWORK,
                {COMMON, "tet_guard=1", "coarse_cells=64", "alpha=0"},
                .way = 1,
                .last = LONG},
    [FINE] = {"network-fine",
              FINE_TITLE,
              NETWORK,
              {COMMON, "tet_guard=0", "coarse_cells=0", "alpha=0"},
              .way = 1,
              .last = LONG},
    [UNGUARDED] = {"network-unguarded",
                   UNGUARDED_TITLE,
                   NETWORK,
                   {COMMON, "tet_guard=0", "coarse_cells=64", "alpha=0"},
                   .way = 1,
                   .last = LONG},
};

/* The paper's network of this poke by the report's reference program, its first step divided as the
 * model's: its error against the finite elements after 212 steps, and how far the model's shape is
 * from it. What is allowed is for single precision: that step undivided makes 4e-4 and 1.2e-3. */
static softsim_status claim_reference(ss_paper *paper, const ss_zhang_solid *liver, const field fem,
                                      const struct poke *what, const shape_run *row, const field u,
                                      double *out_error, softsim_error *error)
{
    ss_zhang_reference reference;
    const size_t n = (size_t)liver->mesh->node_count;
    field reference_u = calloc(n, sizeof *reference_u);
    softsim_status status = reference_u != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK) {
        status = ss_zhang_solid_reference(liver, what->alpha, SS_REFERENCE_KEEP, &reference, error);
    } else {
        status = ss_memory_fault(error);
    }
    if (status == SOFTSIM_OK) {
        ss_zhang_reference_at_once(&reference, what->depth, row->step_s, row->substeps);
        for (int32_t k = 1; k < mark[LATE]; ++k) {
            ss_zhang_reference_step(&reference, what->depth, row->step_s);
        }
        for (size_t i = 0; i < n; ++i) {
            ss_sub3(reference_u[i], reference.at[i], reference.rest[i]);
        }
        ss_zhang_reference_fini(&reference);
        *out_error = ss_zhang_distance((int32_t)n, (const double(*)[3])reference_u,
                                       (const double(*)[3])fem, liver->volume);
        ss_claim_at_most(paper, "Fig. 6", SS_FROM_CODE, 1e-4,
                         ss_zhang_distance((int32_t)n, (const double(*)[3])u,
                                           (const double(*)[3])reference_u, liver->volume),
                         "liver, %s: the paper's network after 212 steps: distance of the shape "
                         "from the reference network's, over its size",
                         what->title);
    }
    free(reference_u);
    return status;
}

/* `reference_error`: of the paper's network by the reference program after 212 steps. */
static void claim_shape(ss_paper *paper, const shape_run *row, double reference_error,
                        const char *poke_name)
{
    const shape_run *c = &row[COARSE];
    ss_claim_at_most(paper, "Conclusion", SS_FROM_CODE, reference_error, c->error[0],
                     "liver, %s: ours: error against finite elements after 10 steps, at most that "
                     "of the paper's network after 212 (reference network)",
                     poke_name);
    ss_claim_at_most(
        paper, "Fig. 6", SS_FROM_CLOSED_FORM, 0.0,
        c->inverted[0] + c->inverted[1] + c->inverted[LATE],
        "liver, %s: tetrahedra inverted after 10, 31 and 212 steps, with the tet guard", poke_name);
    ss_claim_at_most(paper, "eq. 4", SS_FROM_CLOSED_FORM, 1e-6, fmax(c->rise, row[FINE].rise),
                     "liver, %s: a gradient flow: the energy never rises while the contact is held "
                     "(ours and the paper's network): largest rise in a step, of the peak",
                     poke_name);
}

/* Error against steps and CPU time, of all models of the deep poke. */
static softsim_status draw_passing(ss_paper *paper, const shape_run *row, softsim_error *error)
{
    static const int drawn[] = {COARSE, FINE, MAIL_BOX, MAIL_RADIAL, MAIL_TUNED};
    static const char *const label[] = {"ours: with a coarse level", "the paper''s network",
                                        "ChainMail, box", "ChainMail, radial",
                                        "ChainMail, tuned and relaxed"};
    enum { DRAWN = sizeof drawn / sizeof *drawn };
    ss_output csv, script;
    softsim_status status =
        ss_paper_csv_open(paper, &csv, "fig6-time", "model,step,cpu_us,error_l2", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int d = 0; d < DRAWN; ++d) {
        const shape_run *at = &row[drawn[d]];
        for (int32_t k = 0; k < at->look_count; ++k) {
            fprintf(csv.file, "%s,%d,%.6g,%.6g\n", at->name, at->look_step[k], at->look_us[k],
                    at->look_error[k]);
        }
    }
    status = ss_paper_csv_close(paper, &csv, "fig6-time", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open_sized(&script, paper->folder, "fig6-time", 1000, 480, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("set datafile separator ','\nset grid\nset logscale x\nset yrange [0:1.1]\n"
          "set tmargin 6\nset multiplot layout 1,2\nset ylabel 'error against finite elements'\n",
          script.file);
    for (int side = 0; side < 2; ++side) {
        fprintf(script.file, "set xlabel '%s'\nset key %s\nplot ",
                side == 0 ? "steps" : "CPU time, ms",
                side == 0 ? "off" : "at screen 0.5, screen 0.99 center top horizontal maxcols 3");
        for (int d = 0; d < DRAWN; ++d) {
            fprintf(script.file,
                    "%s'fig6-time.csv' skip 1 using (strcol(1) eq '%s' ? %s : NaN):4 with "
                    "lines lw 2 dt %d title '%s'",
                    d > 0 ? ", " : "", row[drawn[d]].name, side == 0 ? "$2" : "1e-3*$3",
                    d < 2 ? 1 : 2, label[d]);
        }
        fputc('\n', script.file);
    }
    fputs("unset multiplot\n", script.file);
    return ss_page_plot(
        &paper->page, &script, "fig6-time",
        "Fig. 6, 12 mm: error against finite elements after equal steps and after "
        "equal CPU time. ChainMail follows the hand for 30 steps and is then at rest.",
        error);
}

/* The search of a claim that the network is the better one: when it becomes that. `mail`: that
 * ChainMail's error and the CPU time of its poke. */
static void tell_passing(ss_paper *paper, const shape_run *fine, double mail_error,
                         double mail_poke_us)
{
    int32_t k = 0;
    while (k < fine->look_count && fine->look_error[k] > mail_error) {
        ++k;
    }
    if (k < fine->look_count) {
        ss_claim_search(paper,
                        "all steps up to %d: the paper's network of alpha 0.02 is the better one "
                        "from step %d on, %.3g ms of CPU time; this ChainMail's whole poke takes "
                        "%.3g ms",
                        mark[fine->last], fine->look_step[k], 1e-3 * fine->look_us[k],
                        1e-3 * mail_poke_us);
    } else {
        ss_claim_search(paper, "all steps up to %d: it never passes this ChainMail",
                        mark[fine->last]);
    }
}

/* The paper's network of this alpha against ChainMail after equal steps and after equal CPU time.
 */
static void claim_better(ss_paper *paper, const shape_run *row)
{
    static const char *const head[] = {"model", "error after 212 steps",
                                       "CPU time of the poke by ChainMail, us",
                                       "the paper's network after as much", "ours after as much"};
    const shape_run *fine = &row[FINE], *box = &row[MAIL_BOX];
    ss_page_text(
        &paper->page,
        "After equal numbers of steps, and after the CPU time that each ChainMail took for "
        "the whole poke of %d steps, when the paper's network is far from rest, since what moves "
        "it spreads a link a step:",
        MAIL_STEPS);
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int r = MAIL_BOX; r < RUN_COUNT; ++r) {
        const double us = mail_us(&row[r]);
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", row[r].title);
        ss_row_add_number(&cells, row[r].error[LATE]);
        ss_row_add_number(&cells, us);
        ss_row_add_number(&cells, error_at(fine, us));
        ss_row_add_number(&cells, error_at(&row[COARSE], us));
        ss_page_table_row(&paper->page, cells.count, cells.cell);
    }
    ss_page_table_end(&paper->page);
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, box->error[LATE], fine->error[LATE],
                     "a better shape than traditional ChainMail's of the same alpha, after equal "
                     "numbers of steps, %d: error of the paper's network against finite elements",
                     mark[LATE]);
    tell_passing(paper, fine, box->error[LATE], mail_us(box));
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, box->error[LATE], error_at(fine, mail_us(box)),
                     "the same after equal CPU time, that of ChainMail's whole poke");
    tell_passing(paper, fine, box->error[LATE], mail_us(box));
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, box->inverted[LATE], fine->inverted[LATE],
                     "it turns no more tetrahedra inside out than ChainMail, after equal numbers "
                     "of steps, %d",
                     mark[LATE]);
    ss_claim_search(paper,
                    "no guard, as in the paper: %d after 10 steps, %d after 31, %d after 84, %d "
                    "after 212, %d after %d; ChainMail %d; with this program's tet guard none",
                    fine->inverted[0], fine->inverted[1], fine->inverted[2], fine->inverted[LATE],
                    fine->inverted[fine->last], mark[fine->last], box->inverted[LATE]);
    if (fine->last == REST) {
        ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, box->error[LATE], fine->error[REST],
                         "a better shape, both at rest: error of the paper's network after %d "
                         "steps",
                         mark[REST]);
        ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, box->inverted[LATE], fine->inverted[REST],
                         "it turns no more tetrahedra inside out than ChainMail, both at rest");
    }
}

/* ---- against any ChainMail ---- */

enum { MAILS = 6, NETS = 4 };
static const double mail_alpha[MAILS] = {0.02, 0.05, 0.1, 0.15, 0.2, 0.3};
static const double net_alpha[NETS] = {0.0, 0.02, 0.05, 0.1};

/* Every network of the paper's kind against every ChainMail with 20 relaxations: after equal
 * steps, after equal CPU time, and at rest, where `fine` is. */
static softsim_status search_better(ss_zhang *zhang, const ss_zhang_solid *liver, const field fem,
                                    const struct poke *what, const shape_run *fine, double ours,
                                    field u, field scratch, softsim_error *error)
{
    const double depth = what->depth;
    ss_paper *paper = zhang->paper;
    char alpha[32];
    shape_run best = {.error = {[LATE] = (double)INFINITY}};
    double best_alpha = 0.0, steps = (double)INFINITY, time = (double)INFINITY;
    double steps_alpha = 0.0, time_alpha = 0.0;
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < MAILS && status == SOFTSIM_OK; ++k) {
        shape_run row = {.title = "ChainMail",
                         .model = "chainmail",
                         .param = {alpha, "beta=0.5", "band=box", "relaxation_iterations=20"},
                         .way = MAIL_STEPS,
                         .last = LATE};
        snprintf(alpha, sizeof alpha, "alpha=%g", mail_alpha[k]);
        status = run_shape(liver, depth, fem, &row, u, scratch, paper, error);
        if (row.error[LATE] < best.error[LATE]) {
            best = row;
            best_alpha = mail_alpha[k];
        }
    }
    for (int k = 0; k < NETS && status == SOFTSIM_OK; ++k) {
        shape_run row = {.title = "the paper's network",
                         .model = NETWORK,
                         .param = {COMMON, "tet_guard=0", "coarse_cells=0", alpha},
                         .way = 1,
                         .last = LONG};
        snprintf(alpha, sizeof alpha, "alpha=%g", net_alpha[k]);
        status = run_shape(liver, depth, fem, &row, u, scratch, paper, error);
        if (row.error[LATE] < steps) {
            steps = row.error[LATE];
            steps_alpha = net_alpha[k];
        }
        if (error_at(&row, mail_us(&best)) < time) {
            time = error_at(&row, mail_us(&best));
            time_alpha = net_alpha[k];
        }
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    static const char *const search =
        "networks with alpha 0 to 0.1, this the best (alpha %g); ChainMail as a box with alpha "
        "0.02 to 0.3 and 20 relaxations, the best with %g, %.0f us a step; the coarse level, which "
        "is ours and not the paper's, has %.2f after 212 steps";
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, best.error[LATE], steps,
                     "a better shape than the best ChainMail's of any alpha, relaxed: error of the "
                     "best network of the paper's after equal numbers of steps, %d",
                     mark[LATE]);
    ss_claim_search(paper, search, steps_alpha, best_alpha, best.us, ours);
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, best.error[LATE], time,
                     "the same after equal CPU time, that of ChainMail's whole poke");
    ss_claim_search(paper, search, time_alpha, best_alpha, best.us, ours);
    ss_claim_at_most(paper, "Fig. 6", SS_FROM_PAPER, best.error[LATE], fine->error[REST],
                     "the same, both at rest: the network of alpha %g after %d steps", what->alpha,
                     mark[REST]);
    tell_passing(paper, fine, best.error[LATE], mail_us(&best));
    return SOFTSIM_OK;
}

/* ---- cost and benefit of the coarse level ---- */

/* Batches of steps of both in turn; the least of each, since what else a machine does to its caches
 * only adds. */
static softsim_status show_cost(ss_paper *paper, const ss_zhang_solid *liver, double depth,
                                softsim_error *error)
{
    ss_zhang_run run[2];
    ss_zhang_setup setup[2];
    double least[2] = {(double)INFINITY, (double)INFINITY};
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < 2; ++k) {
        setup[k] = ss_zhang_solid_setup(liver, NETWORK, depth);
        memcpy(setup[k].param, shallow_runs[k == 0 ? UNGUARDED : FINE].param,
               sizeof setup[k].param);
        const softsim_status begun = ss_zhang_begin(&setup[k], &run[k], error);
        status = status == SOFTSIM_OK ? begun : status;
        if (status == SOFTSIM_OK && run[k].model) {
            ss_zhang_step(&run[k], depth);
            status = ss_zhang_hold(&run[k], WARM_STEPS * run[k].step_s, error);
        }
    }
    for (int i = 0; i < BATCHES && status == SOFTSIM_OK && run[0].model && run[1].model; ++i) {
        for (int k = 0; k < 2; ++k) {
            const int64_t before = ss_clock_thread_cpu_ns();
            for (int step = 0; step < BATCH; ++step) {
                ss_zhang_step(&run[k], depth);
            }
            least[k] = fmin(least[k], (double)(ss_clock_thread_cpu_ns() - before));
        }
    }
    if (status == SOFTSIM_OK && run[0].model && run[1].model) {
        ss_page_text(&paper->page,
                     "A step with the coarse level takes %.2f times one without (CPU time, least "
                     "of batches in turn; alpha 0, every link at work). Where many links are slack "
                     "a fine step costs less and the ratio is larger.",
                     least[0] / least[1]);
    }
    for (int k = 0; k < 2; ++k) {
        ss_zhang_end(&run[k]);
    }
    return status;
}

enum { PLACES = 3 };
static const struct {
    const char *name;
    double at[2]; /* m */
} places[PLACES] = {
    {"free lobe, middle", {0.03, 0.0}},
    {"over the middle", {-0.012, 0.0}},
    {"beside the support", {-0.06, 0.0}},
};

/* The shallow poke at other places: how far off the network is depends on where. */
static softsim_status go_about(ss_zhang *zhang, ss_zhang_solid *liver, softsim_error *error)
{
    static const char *const head[] = {"place", "model", "error after 10 steps", "31", "84", "212"};
    const double up[3] = {0.0, 0.0, 1.0}, depth = 0.004;
    const size_t n = (size_t)liver->mesh->node_count;
    field fem = calloc(n, sizeof *fem), u = calloc(n, sizeof *u), scratch = calloc(n, sizeof *u);
    softsim_status status =
        fem != NULL && u != NULL && scratch != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    double worst = 0.0;
    ss_page_text(
        &zhang->paper->page,
        "Where the body is poked matters: near the support finite elements hardly move the "
        "rest, while the free end swings. The poke of 4 mm elsewhere:");
    ss_page_table_begin(&zhang->paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int p = 0; p < PLACES && status == SOFTSIM_OK; ++p) {
        const double from[3] = {places[p].at[0], places[p].at[1], 0.0};
        status = ss_zhang_solid_patch(liver, from, up, liver->pushed_count, error);
        if (status == SOFTSIM_OK) {
            status = solve_fem(liver, depth, fem, error);
        }
        shape_run row[2] = {shallow_runs[COARSE], shallow_runs[FINE]};
        row[0].last = row[1].last = LATE;
        for (int r = 0; r < 2 && status == SOFTSIM_OK; ++r) {
            status = run_shape(liver, depth, fem, &row[r], u, scratch, zhang->paper, error);
            ss_row cells = {.count = 0};
            ss_row_add(&cells, "%s", places[p].name);
            ss_row_add(&cells, "%s", row[r].title);
            for (int m = 0; m <= LATE; ++m) {
                ss_row_add_number(&cells, row[r].error[m]);
            }
            ss_page_table_row(&zhang->paper->page, cells.count, cells.cell);
        }
        worst = fmax(worst, row[COARSE].error[0] / row[FINE].error[LATE]);
        ss_paper_progress(zhang->paper, 0.6 + 0.1 * (p + 1));
    }
    ss_page_table_end(&zhang->paper->page);
    if (status == SOFTSIM_OK) {
        ss_claim_at_most(zhang->paper, "Conclusion", SS_FROM_PAPER, 1.0, worst,
                         "many elements in a cell are an enhancement: at these places, error after "
                         "10 steps with the coarse level over that after 212 without: largest");
    }
    SS_EACH(free, fem, u, scratch);
    return status;
}

/* All rows of one poke: table, CSV, pictures. `unit`: the finite elements' field for a depth of 1
 * m, which is proportional to it. */
static softsim_status poke(ss_zhang *zhang, const ss_zhang_solid *liver, const field unit,
                           const struct poke *what, shape_run *row, int32_t count,
                           softsim_error *error)
{
    const double depth = what->depth;
    const char *name = what->name;
    double reference_error = (double)NAN;
    char file[64], caption[200];
    const size_t n = (size_t)liver->mesh->node_count;
    field fem = calloc(n, sizeof *fem), u = calloc(n, sizeof *u), scratch = calloc(n, sizeof *u);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (fem == NULL || u == NULL || scratch == NULL) {
        status = ss_memory_fault(error);
    } else {
        status = SOFTSIM_OK;
    }
    for (size_t i = 0; i < n && status == SOFTSIM_OK; ++i) {
        ss_scale3(fem[i], unit[i], depth);
    }
    for (int32_t r = 0; r < count && status == SOFTSIM_OK; ++r) {
        status = run_shape(liver, depth, fem, &row[r], u, scratch, zhang->paper, error);
        if (status == SOFTSIM_OK && row[r].is_there && row[r].is_drawn) {
            snprintf(file, sizeof file, "fig6-%s-%s", name, row[r].name);
            snprintf(caption, sizeof caption, "Fig. 6, %.0f mm, after 212 steps: %s.", 1e3 * depth,
                     row[r].title);
            status = ss_zhang_solid_draw(zhang->paper, liver, (const double(*)[3])u, file, caption,
                                         error);
        }
        if (status == SOFTSIM_OK && row[r].is_there && row[r].last == REST) {
            snprintf(file, sizeof file, "fig6-%s-%s-rest", name, row[r].name);
            snprintf(caption, sizeof caption, "Fig. 6, %.0f mm, at rest (after %d steps): %s.",
                     1e3 * depth, mark[REST], row[r].title);
            status = ss_zhang_solid_draw(zhang->paper, liver, (const double(*)[3])scratch, file,
                                         caption, error);
        }
        if (status == SOFTSIM_OK && r == FINE && row[r].is_there) {
            status = claim_reference(zhang->paper, liver, fem, what, &row[r], u, &reference_error,
                                     error);
        }
    }
    if (status == SOFTSIM_OK) {
        snprintf(file, sizeof file, "fig6-%s-fem", name);
        snprintf(caption, sizeof caption,
                 "The same by linear finite elements, at rest: what errors are counted from.");
        status =
            ss_zhang_solid_draw(zhang->paper, liver, (const double(*)[3])fem, file, caption, error);
    }
    if (status == SOFTSIM_OK) {
        show_tables(zhang->paper, row, count);
        snprintf(file, sizeof file, "fig6-%s", name);
        status = write_csv(zhang->paper, file, row, count, error);
    }
    if (status == SOFTSIM_OK && row[FINE].is_there) {
        claim_shape(zhang->paper, row, reference_error, what->title);
    }
    if (status == SOFTSIM_OK && count > MAIL_BOX && row[MAIL_BOX].is_there) {
        claim_better(zhang->paper, row);
        status = draw_passing(zhang->paper, row, error);
    }
    if (status == SOFTSIM_OK && count > MAIL_BOX && !zhang->paper->is_quick) {
        status = search_better(zhang, liver, fem, what, &row[FINE], row[COARSE].error[LATE], u,
                               scratch, error);
    }
    SS_EACH(free, fem, u, scratch);
    return status;
}

softsim_status ss_zhang_liver(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    shape_run deep[RUN_COUNT], shallow[UNGUARDED + 1];
    ss_zhang_solid liver;
    memcpy(deep, deep_runs, sizeof deep);
    memcpy(shallow, shallow_runs, sizeof shallow);
    for (int r = 0; r < UNGUARDED + 1 && paper->is_quick; ++r) {
        deep[r].last = r == FINE ? LONG : LATE;
        shallow[r].last = LATE;
    }
    softsim_status status = ss_zhang_liver_make(paper, &liver, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    field unit = calloc((size_t)liver.mesh->node_count, sizeof *unit);
    ss_page_text(
        &paper->page,
        "The paper: a liver of 5762 points and 20255 tetrahedra deforms better by the "
        "network than by ChainMail. Here: a generated liver of %d points and %d "
        "tetrahedra, held at its bare area, a patch of %d nodes on the upper side of its "
        "free lobe moved in at once (in one step, which the network divides, a quarter of a "
        "link each), and linear finite elements of the same mesh (nu %g) as the measure. The "
        "coarse level (many elements in a cell, the paper's future work) and the guard of "
        "tetrahedra are this program's, not the paper's; rows that have them say so. 12 mm, "
        "alpha 0.02:",
        liver.mesh->node_count, liver.mesh->tetrahedron_count, liver.pushed_count, poisson_ratio);
    if (unit == NULL) {
        status = ss_memory_fault(error);
    } else {
        status = solve_fem(&liver, 1.0, unit, error);
    }
    if (status == SOFTSIM_OK) {
        status = poke(zhang, &liver, unit, &deep_poke, deep, RUN_COUNT, error);
    }
    ss_paper_progress(paper, 0.4);
    if (status == SOFTSIM_OK) {
        ss_page_text(&paper->page, "4 mm, alpha 0:");
        status = poke(zhang, &liver, unit, &shallow_poke, shallow, UNGUARDED + 1, error);
    }
    if (status == SOFTSIM_OK) {
        status = show_cost(paper, &liver, shallow_poke.depth, error);
    }
    if (status == SOFTSIM_OK && !paper->is_quick) {
        status = go_about(zhang, &liver, error);
    }
    free(unit);
    ss_zhang_solid_fini(&liver);
    return status;
}
