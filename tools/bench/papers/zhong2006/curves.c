/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Figures 4 to 6: creep, hysteresis, load and deformation of the cylinder's contact. The paper
 * prints curves without numbers, so what it says is their shape; the numbers expected here are
 * those of the report's reference network (net.h, motion.h) on the same protocol.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhong2006/motion.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/memory.h"

enum { MAX_CURVES = 8 };

/* Says what is done, and does it on each tube that is there. */
static softsim_status on_tubes(ss_paper *paper, const char *about,
                               softsim_status (*run)(ss_zhong *zhong, const ss_tube *tube,
                                                     softsim_error *error),
                               softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    softsim_status status = SOFTSIM_OK;
    ss_page_text(&paper->page, "%s", about);
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        if (zhong->tube[k].is_there) {
            status = run(zhong, &zhong->tube[k], error);
        }
    }
    return status;
}

/* Curves over a common abscissa: column 0, and a column a damping. */
typedef struct table {
    int32_t rows, curves;
    double *value; /* rows x (1 + curves) */
} table;

static softsim_status table_init(table *t, int32_t rows, int32_t curves, softsim_error *error)
{
    *t = (table){.rows = rows, .curves = curves};
    t->value = calloc((size_t)rows * (size_t)(1 + curves), sizeof *t->value);
    if (t->value == NULL) {
        return ss_memory_fault(error);
    }
    return SOFTSIM_OK;
}

static double *cell(const table *t, int32_t row, int32_t column)
{
    return &t->value[row * (1 + t->curves) + column];
}

static softsim_status write_table(ss_zhong *zhong, const table *t, const char *name,
                                  const char *head, softsim_error *error)
{
    ss_output csv;
    const softsim_status status = ss_paper_csv_open(zhong->paper, &csv, name, head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < t->rows; ++k) {
        for (int32_t c = 0; c <= t->curves; ++c) {
            fprintf(csv.file, c == 0 ? "%.8g" : ",%.8g", *cell(t, k, c));
        }
        fputc('\n', csv.file);
    }
    return ss_paper_csv_close(zhong->paper, &csv, name, error);
}

/* One picture of every curve of a table that has been written as `name`.csv. */
static softsim_status plot_table(ss_zhong *zhong, const char *name, const char *labels,
                                 int32_t curves, const double *gamma, const char *caption,
                                 softsim_error *error)
{
    ss_output script;
    const softsim_status status = ss_plot_open(&script, zhong->paper->folder, name, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset grid\nset key bottom right\n%s\n"
            "set palette defined (0 '#10305a', 0.5 '#2a8f8f', 1 '#e0a030')\nunset colorbox\nplot ",
            labels);
    for (int32_t c = 0; c < curves; ++c) {
        fprintf(script.file,
                "%s'%s.csv' skip 1 using 1:%d with lines lw 2 lc palette frac %.3f "
                "title 'damping %g'",
                c > 0 ? ", " : "", name, c + 2, curves > 1 ? (double)c / (curves - 1) : 0.0,
                gamma[c]);
    }
    fputc('\n', script.file);
    return ss_page_plot(&zhong->paper->page, &script, name, caption, error);
}

/* Is every curve below the one before it, in rows from..to? Returns the least gap. */
static double least_gap(const table *t, int32_t from, int32_t to)
{
    double least = (double)INFINITY;
    for (int32_t k = from; k <= to; ++k) {
        for (int32_t c = 1; c < t->curves; ++c) {
            least = fmin(least, *cell(t, k, c) - *cell(t, k, c + 1));
        }
    }
    return least;
}

/* Fills column `c` with the contact's depth after every `every` steps; row 0 is rest. */
static softsim_status record(ss_zhong *zhong, const ss_tube *tube, const ss_tube_setup *setup,
                             table *t, int32_t c, int32_t every, softsim_error *error)
{
    ss_trial trial;
    softsim_status status = ss_tube_begin(zhong->paper, tube, setup, &trial, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (trial.world == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "the cylinder is refused: %s", trial.reason);
        return SOFTSIM_ERROR_SCENE;
    }
    for (int32_t k = 1; status == SOFTSIM_OK && k < t->rows; ++k) {
        status = ss_trial_run(&trial, every, error);
        *cell(t, k, 0) = k * every * setup->step_s;
        *cell(t, k, c) = ss_tube_depth(tube, &trial);
    }
    ss_trial_end(&trial);
    return status;
}

/* The same by the report's reference network. `force` at a time. */
static softsim_status record_reference(const ss_tube *tube, double gamma,
                                       double (*force)(double time), table *t, int32_t c,
                                       int32_t every, double step_s, softsim_error *error)
{
    const ss_zhong_law law = {.source = SS_ZHONG_CLOSURE,
                              .modulus = SS_TUBE_MODULUS,
                              .mass = 1.0,
                              .damping = gamma,
                              .rest_stiffness = SS_TUBE_KS};
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    ss_zhong_motion motion;
    if (net == NULL || !ss_zhong_motion_init(&motion, net, &law, SS_TUBE_CONTACT, SS_TUBE_TRIANGLES,
                                             (const int32_t(*)[3])tube->triangle)) {
        ss_zhong_net_destroy(&net);
        return ss_memory_fault(error);
    }
    for (int32_t k = 1; k < t->rows; ++k) {
        for (int32_t s = 0; s < every; ++s) {
            motion.force[1] = -force(motion.time + 0.5 * step_s);
            ss_zhong_motion_run(&motion, 1, step_s);
        }
        *cell(t, k, 0) = k * every * step_s;
        *cell(t, k, c) = -motion.u[SS_TUBE_CONTACT][1];
    }
    ss_zhong_motion_fini(&motion);
    ss_zhong_net_destroy(&net);
    return SOFTSIM_OK;
}

/* ---- Fig. 4: creep ---- */

static const double creep_gamma[MAX_CURVES] = {3, 4, 5, 6, 7, 8, 9, 10};
static const double creep_step_s = 0.1;
enum { CREEP_ROWS = 801, CREEP_EVERY = 5 }; /* 400 s */

static double creep_force(double time)
{
    (void)time;
    return 0.25;
}

/* When a column reaches 90 % of what it has at the end of the record, between samples. */
static double time_of_90(const table *t, int32_t c)
{
    const double wanted = 0.9 * *cell(t, t->rows - 1, c);
    int32_t k = 1;
    while (*cell(t, k, c) < wanted) {
        ++k;
    }
    const double before = *cell(t, k - 1, c), after = *cell(t, k, c);
    const double share = (wanted - before) / (after - before);
    return *cell(t, k - 1, 0) + share * (*cell(t, k, 0) - *cell(t, k - 1, 0));
}

/* The same of the reference network, and its displacement in the end. */
static softsim_status reference_creep(const ss_tube *tube, double gamma, double *out_t90_s,
                                      double *out_last, softsim_error *error)
{
    table reference;
    softsim_status status = table_init(&reference, CREEP_ROWS, 1, error);
    if (status == SOFTSIM_OK) {
        status = record_reference(tube, gamma, creep_force, &reference, 1, CREEP_EVERY,
                                  creep_step_s, error);
        *out_t90_s = status == SOFTSIM_OK ? time_of_90(&reference, 1) : (double)NAN;
        *out_last = *cell(&reference, CREEP_ROWS - 1, 1);
    }
    free(reference.value);
    return status;
}

static softsim_status creep_claims(ss_zhong *zhong, const ss_tube *tube, const table *t,
                                   softsim_error *error)
{
    ss_paper *paper = zhong->paper;
    double overshoot = 0.0, t90_s[2] = {0.0, 0.0}, last[2] = {0.0, 0.0};
    for (int32_t c = 1; c <= t->curves; ++c) {
        for (int32_t k = 1; k < t->rows; ++k) {
            const double end = *cell(t, t->rows - 1, c);
            overshoot = fmax(overshoot, (*cell(t, k, c) - end) / end);
        }
    }
    ss_claim_at_most(paper, "Fig. 4", SS_FROM_PAPER, 1e-4, overshoot,
                     "%s: builds up asymptotically towards a maximum, no overshoot (beyond the "
                     "last value, fraction)",
                     tube->name);
    ss_claim_at_least(paper, "Fig. 4", SS_FROM_PAPER, 1e-5, least_gap(t, 2, 200),
                      "%s: the eight curves in strict order of damping from 1 to 100 s (least "
                      "distance between neighbours, m)",
                      tube->name);
    softsim_status status = SOFTSIM_OK;
    for (int32_t k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        const double gamma = creep_gamma[k == 0 ? 0 : t->curves - 1];
        status = reference_creep(tube, gamma, &t90_s[k], &last[k], error);
    }
    for (int32_t k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        const int32_t c = k == 0 ? 1 : t->curves;
        ss_claim_near(paper, "Fig. 4", SS_FROM_CODE, last[k], *cell(t, t->rows - 1, c),
                      SS_CODE_TOLERANCE,
                      "%s: displacement after 400 s under a constant 0.25 N, damping %g, m",
                      tube->name, creep_gamma[c - 1]);
        ss_claim_near(paper, "Fig. 4", SS_FROM_CODE, t90_s[k], time_of_90(t, c), SS_CODE_TOLERANCE,
                      "%s: time to 90 %% of it, damping %g, s", tube->name, creep_gamma[c - 1]);
    }
    return status;
}

static softsim_status creep_on(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    table t;
    char name[32], caption[160];
    softsim_status status = table_init(&t, CREEP_ROWS, MAX_CURVES, error);
    for (int32_t c = 1; status == SOFTSIM_OK && c <= MAX_CURVES; ++c) {
        const ss_tube_setup setup = {.gamma = creep_gamma[c - 1],
                                     .load = {{.point = SS_TUBE_CONTACT, .force = 0.25}},
                                     .load_count = 1,
                                     .step_s = creep_step_s};
        status = record(zhong, tube, &setup, &t, c, CREEP_EVERY, error);
        ss_paper_progress(zhong->paper, (tube->is_grid ? 0.0 : 0.5) + 0.05 * c);
    }
    snprintf(name, sizeof name, "fig4-%s", tube->name);
    snprintf(caption, sizeof caption,
             "Fig. 4, %s: displacement of the contact under a constant 0.25 N, damping 3 (top) to "
             "10 (bottom).",
             tube->name);
    if (status == SOFTSIM_OK) {
        status = creep_claims(zhong, tube, &t, error);
    }
    if (status == SOFTSIM_OK) {
        status =
            write_table(zhong, &t, name, "time_s,u3_m,u4_m,u5_m,u6_m,u7_m,u8_m,u9_m,u10_m", error);
    }
    if (status == SOFTSIM_OK) {
        status = plot_table(zhong, name,
                            "set xlabel 'time, s'\nset ylabel 'displacement, m'\n"
                            "set xrange [0:250]",
                            MAX_CURVES, creep_gamma, caption, error);
    }
    free(t.value);
    return status;
}

softsim_status ss_zhong_creep(ss_paper *paper, softsim_error *error)
{
    return on_tubes(paper,
                    "The paper: under a constant force the displacement of the contact builds up "
                    "towards a maximum, as living tissue creeps; eight materials differ in their "
                    "damping, 3 to 10, the most damped lowest. Here: 0.25 N on the cylinder's top "
                    "point for 400 s.",
                    creep_on, error);
}

/* ---- Fig. 5: hysteresis ---- */

static const double loop_gamma[2] = {2, 9};
static const double loop_step_s = 0.05, loop_s = 40.0, loop_n = 0.5;
enum { LOOP_ROWS = 1601, LOOP_HALF = 800, LOOP_QUARTER = 400 };

static double loop_force(double time)
{
    return time < loop_s ? loop_n * time / loop_s : fmax(0.0, loop_n * (2.0 - time / loop_s));
}

/* Loading and unloading are two ramps, the second taking the first back. */
static void loop_setup(double gamma, ss_tube_setup *setup)
{
    *setup = (ss_tube_setup){
        .gamma = gamma,
        .load = {{.point = SS_TUBE_CONTACT, .force = loop_n, .ramp = loop_s},
                 {.point = SS_TUBE_CONTACT, .force = -loop_n, .from = loop_s, .ramp = loop_s}},
        .load_count = 2,
        .step_s = loop_step_s};
}

static double loop_area(const table *t, int32_t c)
{
    double area = 0.0;
    for (int32_t k = 1; k < t->rows; ++k) {
        const double force = 0.5 * (loop_force(*cell(t, k, 0)) + loop_force(*cell(t, k - 1, 0)));
        area += force * (*cell(t, k, c) - *cell(t, k - 1, c));
    }
    return area;
}

/* Area, U at a quarter of the way up and down, by the reference network. */
static softsim_status reference_loop(const ss_tube *tube, double gamma, double out[3],
                                     softsim_error *error)
{
    table reference;
    softsim_status status = table_init(&reference, LOOP_ROWS, 1, error);
    if (status == SOFTSIM_OK) {
        status = record_reference(tube, gamma, loop_force, &reference, 1, 1, loop_step_s, error);
    }
    if (status == SOFTSIM_OK) {
        out[0] = loop_area(&reference, 1);
        out[1] = *cell(&reference, LOOP_QUARTER, 1);
        out[2] = *cell(&reference, LOOP_HALF + LOOP_QUARTER, 1);
    }
    free(reference.value);
    return status;
}

static softsim_status loop_claims(ss_zhong *zhong, const ss_tube *tube, const table *t,
                                  softsim_error *error)
{
    ss_paper *paper = zhong->paper;
    for (int which = 0; which < 2; ++which) {
        double reference[3];
        const double gamma = loop_gamma[which];
        const double up = *cell(t, LOOP_QUARTER, 1 + which);
        const double down = *cell(t, LOOP_HALF + LOOP_QUARTER, 1 + which);
        const softsim_status status = reference_loop(tube, gamma, reference, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
        ss_claim_at_least(paper, "Fig. 5", SS_FROM_PAPER, 0.05, down / up - 1.0,
                          "%s: two distinct paths, damping %g: unloading above loading at 0.25 N "
                          "by, fraction",
                          tube->name, gamma);
        ss_claim_near(paper, "Fig. 5", SS_FROM_CODE, reference[0], loop_area(t, 1 + which),
                      SS_CODE_TOLERANCE, "%s: area of the loop, damping %g, J", tube->name, gamma);
        ss_claim_near(paper, "Fig. 5", SS_FROM_CODE, reference[1], up, SS_CODE_TOLERANCE,
                      "%s: displacement at 0.25 N while loading, damping %g, m", tube->name, gamma);
        ss_claim_near(paper, "Fig. 5", SS_FROM_CODE, reference[2], down, SS_CODE_TOLERANCE,
                      "%s: the same while unloading, damping %g, m", tube->name, gamma);
    }
    return SOFTSIM_OK;
}

/* The network is cubic in a small dent, so the last part of the return is a damped spring's:
 * m x'' + gamma x' + ks x = 0, overdamped. */
static double slow_rate(double gamma)
{
    return 0.5 * (gamma - sqrt(gamma * gamma - 4.0 * SS_TUBE_KS));
}

static softsim_status loop_returns(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    ss_trial trial;
    ss_tube_setup setup;
    const double begin_s = 380.0, end_s = 480.0;
    double depth[2];
    loop_setup(loop_gamma[0], &setup);
    softsim_status status = ss_tube_begin(zhong->paper, tube, &setup, &trial, error);
    if (status != SOFTSIM_OK || trial.world == NULL) {
        return status;
    }
    status = ss_trial_run(&trial, (int32_t)(begin_s / loop_step_s), error);
    depth[0] = ss_tube_depth(tube, &trial);
    if (status == SOFTSIM_OK) {
        status = ss_trial_run(&trial, (int32_t)((end_s - begin_s) / loop_step_s), error);
    }
    depth[1] = ss_tube_depth(tube, &trial);
    ss_trial_end(&trial);
    ss_claim_near(zhong->paper, "Fig. 5", SS_FROM_CLOSED_FORM, slow_rate(loop_gamma[0]),
                  log(depth[0] / depth[1]) / (end_s - begin_s), 1e-2,
                  "%s: returns to rest, damping 2: rate of the decay from 300 to 400 s after the "
                  "load has gone, 1/s",
                  tube->name);
    return status;
}

static softsim_status plot_loop(ss_zhong *zhong, const ss_tube *tube, const char *name,
                                softsim_error *error)
{
    ss_output script;
    char caption[192];
    const softsim_status status = ss_plot_open(&script, zhong->paper->folder, name, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset grid\nset key bottom right\n"
            "set xlabel 'force, N'\nset ylabel 'displacement, m'\nset xrange [0:0.52]\nplot ");
    for (int which = 0; which < 2; ++which) {
        fprintf(script.file,
                "%s'%s.csv' skip 1 every ::0::%d using 2:%d with lines lw 2 lc rgb 'black' dt %d "
                "title 'loading, damping %g', '' skip 1 every ::%d using 2:%d with lines lw 2 "
                "lc rgb '#c02020' dt %d title 'unloading, damping %g'",
                which > 0 ? ", " : "", name, LOOP_HALF, 3 + which, which + 1, loop_gamma[which],
                LOOP_HALF, 3 + which, which + 1, loop_gamma[which]);
    }
    fputc('\n', script.file);
    snprintf(caption, sizeof caption,
             "Fig. 5, %s: force 0 to 0.5 N and back to 0 in 40 s each; black loading, red "
             "unloading.",
             tube->name);
    return ss_page_plot(&zhong->paper->page, &script, name, caption, error);
}

static softsim_status write_loop(ss_zhong *zhong, const table *t, const char *name,
                                 softsim_error *error)
{
    ss_output csv;
    const softsim_status status =
        ss_paper_csv_open(zhong->paper, &csv, name, "time_s,force_n,u2_m,u9_m", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < t->rows; ++k) {
        fprintf(csv.file, "%.8g,%.8g,%.8g,%.8g\n", *cell(t, k, 0), loop_force(*cell(t, k, 0)),
                *cell(t, k, 1), *cell(t, k, 2));
    }
    return ss_paper_csv_close(zhong->paper, &csv, name, error);
}

static softsim_status loop_on(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    table t;
    char name[32];
    softsim_status status = table_init(&t, LOOP_ROWS, 2, error);
    for (int which = 0; status == SOFTSIM_OK && which < 2; ++which) {
        ss_tube_setup setup;
        loop_setup(loop_gamma[which], &setup);
        status = record(zhong, tube, &setup, &t, 1 + which, 1, error);
        ss_paper_progress(zhong->paper, (tube->is_grid ? 0.0 : 0.5) + 0.2 * (which + 1));
    }
    snprintf(name, sizeof name, "fig5-%s", tube->name);
    if (status == SOFTSIM_OK) {
        status = loop_claims(zhong, tube, &t, error);
    }
    if (status == SOFTSIM_OK) {
        status = loop_returns(zhong, tube, error);
    }
    if (status == SOFTSIM_OK) {
        status = write_loop(zhong, &t, name, error);
    }
    if (status == SOFTSIM_OK) {
        status = plot_loop(zhong, tube, name, error);
    }
    free(t.value);
    return status;
}

softsim_status ss_zhong_hysteresis(ss_paper *paper, softsim_error *error)
{
    return on_tubes(
        paper,
        "The paper: the force rises at a constant rate and falls again; loading and "
        "unloading follow two distinct paths, as in living tissue. Here: up to 0.5 N and "
        "back, 40 s each way, damping 2 and 9. The area between the paths is what damping "
        "has taken; afterwards the body must come back, since the closure has a memory of "
        "rest (the paper does not say what brings it back).",
        loop_on, error);
}

/* ---- Fig. 6: load and deformation ---- */

static const double ramp_gamma[MAX_CURVES] = {1, 2, 4, 5, 6, 7, 9, 10};
static const double ramp_step_s = 0.05, ramp_s = 10.0;
enum { RAMP_ROWS = 201 };
enum { STATIC_COUNT = 7 };
static const double static_force[STATIC_COUNT] = {0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0};

static double ramp_force(double time)
{
    return time / ramp_s;
}

/* Of a curve from (0, 0) to (1, U): how far it is from the straight line, over U. */
static double bend(const table *t, int32_t c)
{
    double most = 0.0;
    const double last = *cell(t, t->rows - 1, c);
    for (int32_t k = 0; k < t->rows; ++k) {
        most = fmax(most, fabs(*cell(t, k, c) - last * *cell(t, k, 0) / ramp_s) / last);
    }
    return most;
}

static softsim_status ramp_claims(ss_zhong *zhong, const ss_tube *tube, const table *t,
                                  softsim_error *error)
{
    ss_paper *paper = zhong->paper;
    table reference;
    double least_bend = 1.0;
    softsim_status status = table_init(&reference, RAMP_ROWS, 1, error);
    for (int32_t c = 1; status == SOFTSIM_OK && c <= MAX_CURVES; ++c) {
        status = record_reference(tube, ramp_gamma[c - 1], ramp_force, &reference, 1, 1,
                                  ramp_step_s, error);
        ss_claim_near(paper, "Fig. 6", SS_FROM_CODE, *cell(&reference, RAMP_ROWS - 1, 1),
                      *cell(t, RAMP_ROWS - 1, c), SS_CODE_TOLERANCE,
                      "%s: displacement at 1 N after a ramp of 10 s, damping %g, m", tube->name,
                      ramp_gamma[c - 1]);
        least_bend = fmin(least_bend, bend(t, c));
    }
    free(reference.value);
    ss_claim_at_least(paper, "Fig. 6", SS_FROM_PAPER, 0.05, least_bend,
                      "%s: displacement is not linear in the force (least departure of the eight "
                      "curves from a straight line, fraction)",
                      tube->name);
    ss_claim_at_least(
        paper, "Fig. 6", SS_FROM_PAPER, 1e-4, least_gap(t, RAMP_ROWS / 5, RAMP_ROWS - 1),
        "%s: in strict order of damping from 0.2 N on (least distance, m)", tube->name);
    return status;
}

static softsim_status static_claims(ss_zhong *zhong, const ss_tube *tube, const char *name,
                                    softsim_error *error)
{
    ss_output csv;
    double stiffness[STATIC_COUNT], reference_stiffness[STATIC_COUNT];
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    softsim_status status =
        ss_paper_csv_open(zhong->paper, &csv, name, "force_n,u_m,reference_network_m", error);
    for (int k = 0; status == SOFTSIM_OK && k < STATIC_COUNT; ++k) {
        double depth, width;
        const ss_tube_setup setup = {.load = {{.point = SS_TUBE_CONTACT, .force = static_force[k]}},
                                     .load_count = 1};
        status =
            ss_tube_static(zhong->paper, tube, &setup, "static curve", &depth, &width, NULL, error);
        const double reference =
            net != NULL ? ss_tube_net_static(net, static_force[k], NULL, NULL) : (double)NAN;
        fprintf(csv.file, "%g,%.8g,%.8g\n", static_force[k], depth, reference);
        ss_claim_near(zhong->paper, "Fig. 6", SS_FROM_CODE, reference, depth, SS_CODE_TOLERANCE,
                      "%s: static displacement at %g N, m", tube->name, static_force[k]);
        stiffness[k] = static_force[k] / depth;
        reference_stiffness[k] = static_force[k] / reference;
        ss_paper_progress(zhong->paper, (tube->is_grid ? 0.3 : 0.8) + 0.02 * k);
    }
    ss_zhong_net_destroy(&net);
    if (status == SOFTSIM_OK) {
        ss_claim_near(zhong->paper, "Fig. 6", SS_FROM_CODE,
                      reference_stiffness[STATIC_COUNT - 1] / reference_stiffness[0],
                      stiffness[STATIC_COUNT - 1] / stiffness[0], SS_CODE_TOLERANCE,
                      "%s: the body hardens: static force over displacement at %g N, over that at "
                      "%g N",
                      tube->name, static_force[STATIC_COUNT - 1], static_force[0]);
    }
    return ss_paper_csv_end(zhong->paper, &csv, name, status, error);
}

static softsim_status ramp_on(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    table t;
    char name[32], still[40], caption[160];
    softsim_status status = table_init(&t, RAMP_ROWS, MAX_CURVES, error);
    for (int32_t c = 1; status == SOFTSIM_OK && c <= MAX_CURVES; ++c) {
        const ss_tube_setup setup = {
            .gamma = ramp_gamma[c - 1],
            .load = {{.point = SS_TUBE_CONTACT, .force = 1.0, .ramp = ramp_s}},
            .load_count = 1,
            .step_s = ramp_step_s};
        status = record(zhong, tube, &setup, &t, c, 1, error);
        ss_paper_progress(zhong->paper, (tube->is_grid ? 0.0 : 0.5) + 0.03 * c);
    }
    snprintf(name, sizeof name, "fig6-%s", tube->name);
    snprintf(still, sizeof still, "fig6-static-%s", tube->name);
    snprintf(caption, sizeof caption,
             "Fig. 6, %s: force raised to 1 N in 10 s; damping 1 (right) to 10 (left).",
             tube->name);
    if (status == SOFTSIM_OK) {
        status = ramp_claims(zhong, tube, &t, error);
    }
    if (status == SOFTSIM_OK) {
        status = static_claims(zhong, tube, still, error);
    }
    if (status == SOFTSIM_OK) {
        status =
            write_table(zhong, &t, name, "time_s,u1_m,u2_m,u4_m,u5_m,u6_m,u7_m,u9_m,u10_m", error);
    }
    ss_output script;
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, zhong->paper->folder, name, error);
    }
    if (status == SOFTSIM_OK) {
        fprintf(script.file,
                "set datafile separator ','\nset grid\nset key bottom right\n"
                "set xlabel 'displacement, m'\nset ylabel 'force, N'\nset xrange [0:1.05]\n"
                "set palette defined (0 '#10305a', 0.5 '#2a8f8f', 1 '#e0a030')\n"
                "unset colorbox\nplot ");
        for (int32_t c = 0; c < MAX_CURVES; ++c) {
            fprintf(script.file,
                    "'%s.csv' skip 1 using %d:($1/10) with lines lw 2 lc palette frac %.3f title "
                    "'damping %g', ",
                    name, c + 2, c / 7.0, ramp_gamma[c]);
        }
        fprintf(script.file,
                "'%s.csv' skip 1 using 2:($1 <= 1 ? $1 : NaN) with linespoints dt 2 pt 7 ps 0.6 "
                "lc rgb 'grey40' title 'static'\n",
                still);
        status = ss_page_plot(&zhong->paper->page, &script, name, caption, error);
    }
    free(t.value);
    return status;
}

softsim_status ss_zhong_load_curves(ss_paper *paper, softsim_error *error)
{
    return on_tubes(
        paper,
        "The paper: the force is raised at a constant rate; the deformation varies "
        "nonlinearly with it, for eight dampings from 1 (right) to 10 (left). Here: up to "
        "1 N in 10 s, and beside it the static curve, which hardens. The hardening is "
        "geometric: the tension of an edge follows its Green strain, which is quadratic "
        "in the displacement, while the cells stay below their bound and the network is "
        "linear. The cell's own nonlinearity, its bound K, softens: see equation 1 "
        "below. The paper's sentence that the nonlinearity is the network's and not "
        "geometric holds for the second alone.",
        ramp_on, error);
}
