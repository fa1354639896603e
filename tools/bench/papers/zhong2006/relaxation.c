/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Equations 1, 2, 19, 20: the network as a circuit that settles in its own time, beside the direct
 * solution of its equilibrium.
 *
 * With the template (20) the state of cell i follows, C = 1,
 *   v_i' = -v_i/R + y_i/R - (rho_i/S_i) sum_j c_ij (y_i - y_j) + I_i,   y = max(-K, min(K, v)).
 * While |v| < K the leak and the centre of the template cancel, so that the equilibrium (19) is the
 * Poisson equation, whatever R is; explicit Euler is stable up to 2/lambda_max, and lambda_max is
 * at most twice the largest centre, max_i (rho_i/S_i) sum_j c_ij (Gershgorin).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/clock.h"
#include "rt/memory.h"

typedef struct circuit {
    const ss_zhong_net *net;
    double *v, *slope;
    double leak;    /* 1/R */
    double bound;   /* K */
    double step;    /* of the network's time */
    double fastest; /* the largest centre: one over the shortest time constant of a cell */
} circuit;

static bool circuit_init(circuit *c, const ss_zhong_net *net, double leak, double bound)
{
    const size_t n = (size_t)net->node_count;
    *c = (circuit){.net = net, .leak = leak, .bound = bound};
    c->v = calloc(n, sizeof *c->v);
    c->slope = calloc(n, sizeof *c->slope);
    if (c->v == NULL || c->slope == NULL) {
        return false;
    }
    for (int32_t e = 0; e < net->edge_count; ++e) {
        for (int k = 0; k < 2; ++k) {
            const int32_t i = net->edge[e][k];
            c->slope[i] += net->conductance[e] * net->rho[i] / net->area[i];
        }
    }
    for (int32_t i = 0; i < net->node_count; ++i) {
        c->fastest = net->is_held[i] ? c->fastest : fmax(c->fastest, c->slope[i]);
    }
    c->step = 0.95 / (c->fastest + leak);
    return true;
}

static void circuit_fini(circuit *c)
{
    free(c->v);
    free(c->slope);
}

static double output(const circuit *c, int32_t i)
{
    return fmax(-c->bound, fmin(c->bound, c->v[i]));
}

/* One Euler step with the source at 1; returns |v'| over |I|, the residual of (19) before it. */
static double circuit_step(circuit *c)
{
    const ss_zhong_net *net = c->net;
    double residual = 0.0, source = 0.0;
    for (int32_t i = 0; i < net->node_count; ++i) {
        c->slope[i] = c->leak * (output(c, i) - c->v[i]) + (net->is_source[i] ? 1.0 : 0.0);
    }
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->edge[e][0], j = net->edge[e][1];
        const double flow = net->conductance[e] * (output(c, i) - output(c, j));
        c->slope[i] -= flow * net->rho[i] / net->area[i];
        c->slope[j] += flow * net->rho[j] / net->area[j];
    }
    for (int32_t i = 0; i < net->node_count; ++i) {
        if (!net->is_held[i]) {
            residual += c->slope[i] * c->slope[i];
            source += net->is_source[i] ? 1.0 : 0.0;
            c->v[i] += c->step * c->slope[i];
        }
    }
    return sqrt(residual / source);
}

/* |y - scale ghat| over |scale ghat|. */
static double field_error(const circuit *c, double scale)
{
    double difference = 0.0, whole = 0.0;
    for (int32_t i = 0; i < c->net->node_count; ++i) {
        const double right = scale * c->net->potential[i], d = output(c, i) - right;
        difference += d * d;
        whole += right * right;
    }
    return sqrt(difference / whole);
}

/* ---- the program's own relaxation ---- */

typedef struct watched {
    double early, late; /* m, at 10 s and in the end */
    double step_us;
} watched;

/* `bound`: K, 0 for none. */
static softsim_status watch(ss_zhong *zhong, const ss_tube *tube, int32_t steps, double bound,
                            watched *out, softsim_error *error)
{
    const ss_tube_setup setup = {.gamma = 1.0,
                                 .relaxation_steps = steps,
                                 .saturation = bound,
                                 .load = {{.point = SS_TUBE_CONTACT, .force = 0.25}},
                                 .load_count = 1,
                                 .step_s = 0.05};
    ss_trial trial;
    softsim_state state;
    *out = (watched){.early = (double)NAN, .late = (double)NAN};
    softsim_status status = ss_tube_begin(zhong->paper, tube, &setup, &trial, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (trial.world == NULL) {
        ss_paper_miss(zhong->paper, trial.reason, "the network relaxed in its own time%s (%s)",
                      bound > 0.0 ? ", saturated" : "", tube->name);
        return SOFTSIM_OK;
    }
    status = ss_trial_run(&trial, 200, error);
    out->early = ss_tube_depth(tube, &trial);
    softsim_read(trial.world, &state);
    out->step_us = state.step_us[0];
    if (status == SOFTSIM_OK) {
        status = ss_trial_run(&trial, 4800, error);
        out->late = ss_tube_depth(tube, &trial);
    }
    ss_trial_end(&trial);
    return status;
}

/* ---- settling ---- */

enum { MAX_STEPS = 200000 };

typedef struct settled {
    int32_t coarse_steps, fine_steps, percent_steps; /* residual 1e-3, 1e-6; field within 1 % */
    double coarse_error, fine_error;                 /* of the field then */
    double fine_us, solve_us;                        /* thread CPU: to 1e-6; direct, dense */
} settled;

static softsim_status settle(const ss_tube *tube, FILE *csv, circuit *c, ss_zhong_net *net,
                             settled *out, softsim_error *error)
{
    const int64_t start_ns = ss_clock_thread_cpu_ns();
    const bool is_solved = ss_zhong_net_solve(net);
    out->solve_us = 1e-3 * (double)(ss_clock_thread_cpu_ns() - start_ns);
    if (!is_solved || !circuit_init(c, net, 1.0, (double)INFINITY)) {
        return ss_memory_fault(error);
    }
    double residual = 1.0;
    int64_t spent_ns = 0;
    for (int32_t k = 1; k < MAX_STEPS && residual > 1e-6; ++k) {
        const int64_t before_ns = ss_clock_thread_cpu_ns();
        residual = circuit_step(c);
        spent_ns += ss_clock_thread_cpu_ns() - before_ns;
        const double wrong = field_error(c, 1.0);
        if (out->percent_steps == 0 && wrong < 0.01) {
            out->percent_steps = k;
        }
        if (out->coarse_steps == 0 && residual <= 1e-3) {
            out->coarse_steps = k;
            out->coarse_error = wrong;
        }
        if (k % 10 == 0) {
            fprintf(csv, "%s,%d,%.6g,%.6g,%.6g\n", tube->name, k, k * c->step, residual, wrong);
        }
        out->fine_steps = k;
        out->fine_error = wrong;
    }
    out->fine_us = 1e-3 * (double)spent_ns;
    return SOFTSIM_OK;
}

/* The bound K, half of what the contact's cell would reach; y must then be ghat K/ghat_contact,
 * whatever the leak. */
static softsim_status saturate(ss_zhong *zhong, const ss_tube *tube, ss_zhong_net *net,
                               softsim_error *error)
{
    static const double leaks[2] = {1.0, 0.01};
    const double bound = 0.5 * net->potential[SS_TUBE_CONTACT];
    for (int k = 0; k < 2; ++k) {
        circuit c;
        if (!circuit_init(&c, net, leaks[k], bound)) {
            circuit_fini(&c);
            return ss_memory_fault(error);
        }
        for (int32_t s = 0; s < 20000; ++s) {
            circuit_step(&c);
        }
        ss_claim_at_most(zhong->paper, "eq. 1", SS_FROM_CLOSED_FORM, 1e-6, field_error(&c, 0.5),
                         "%s: the contact's cell at its bound, R = %g: the outputs are the "
                         "unbounded field scaled down to K, whatever R (error, fraction; reference "
                         "network)",
                         tube->name, 1.0 / leaks[k]);
        circuit_fini(&c);
    }
    return SOFTSIM_OK;
}

static softsim_status settle_on(ss_zhong *zhong, const ss_tube *tube, FILE *csv,
                                softsim_error *error)
{
    circuit c = {.v = NULL};
    settled s = {.coarse_steps = 0};
    watched ours;
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    if (net == NULL) {
        return ss_memory_fault(error);
    }
    softsim_status status = settle(tube, csv, &c, net, &s, error);
    if (status == SOFTSIM_OK) {
        ss_claim_at_most(zhong->paper, "eq. 19", SS_FROM_PAPER, 1e-3, s.fine_error,
                         "%s: the network settles to the Poisson equation's solution (error of "
                         "the field at a residual of 1e-6 after %d steps, fraction)",
                         tube->name, s.fine_steps);
        status = watch(zhong, tube, 0, 0.0, &ours, error);
        ss_page_text(
            &zhong->paper->page,
            "%s: %d Euler steps and %.0f us of one core settle this network to a residual "
            "of 1e-6; at a residual of 1e-3, after %d, its field is still %.0f %% wrong. A dense "
            "direct solve takes %.0f us, once. As an analogue chip the "
            "same network, from (2), is within 1 %% of its field after %.0f times the "
            "shortest time constant of a cell: with cells of a microsecond in %.0f us. "
            "This program, with the network's equilibrium solved before, spends %.0f us on "
            "a whole step of the body.",
            tube->name, s.fine_steps, s.fine_us, s.coarse_steps, 100.0 * s.coarse_error, s.solve_us,
            s.percent_steps * c.step * c.fastest, s.percent_steps * c.step * c.fastest,
            ours.step_us);
    }
    if (status == SOFTSIM_OK) {
        status = saturate(zhong, tube, net, error);
    }
    circuit_fini(&c);
    ss_zhong_net_destroy(&net);
    return status;
}

static softsim_status plot_settling(ss_zhong *zhong, softsim_error *error)
{
    static const char *const names[2] = {"grid", "triangles"};
    ss_output script;
    const softsim_status status = ss_plot_open(&script, zhong->paper->folder, "relaxation", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset logscale y\nset grid\nset format y '10^{%%T}'\n"
            "set xlabel 'Euler steps of the network'\nset ylabel 'fraction'\n"
            "set key top right\nplot 1e-3 with lines dt 3 lc rgb 'grey50' title '10^{-3}'");
    for (int k = 0; k < 2; ++k) {
        if (zhong->tube[k].is_there) {
            fprintf(script.file,
                    ", 'relaxation.csv' skip 1 using 2:(stringcolumn(1) eq '%s' ? $4 : NaN) with "
                    "lines lw 2 dt 2 lc %d title '%s: residual of (19)', "
                    "'' skip 1 using 2:(stringcolumn(1) eq '%s' ? $5 : NaN) with lines lw 2 lc %d "
                    "title '%s: error of the field'",
                    names[k], k + 1, names[k], names[k], k + 1, names[k]);
        }
    }
    fputc('\n', script.file);
    return ss_page_plot(
        &zhong->paper->page, &script, "relaxation",
        "Settling of the network, (2), from zero: its residual is small long before "
        "its field is right.",
        error);
}

/* ---- relaxation beside equilibrium, in the program ---- */

static softsim_status relax_on(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    static const int32_t all_steps[] = {0, 1, 4, 16, 64}, quick_steps[] = {0, 4};
    static const char *const head[] = {"network", "depth at 10 s, m", "in the end, m",
                                       "model step, us"};
    const bool is_quick = zhong->paper->is_quick;
    const int32_t *steps = is_quick ? quick_steps : all_steps;
    const int32_t count = (int32_t)(is_quick ? sizeof quick_steps / sizeof *quick_steps
                                             : sizeof all_steps / sizeof *all_steps);
    watched all[sizeof all_steps / sizeof *all_steps];
    softsim_status status = SOFTSIM_OK;
    int32_t got = 0;
    for (; status == SOFTSIM_OK && got < count; ++got) {
        status = watch(zhong, tube, steps[got], 0.0, &all[got], error);
        if (isnan(all[got].late)) {
            break;
        }
    }
    if (status != SOFTSIM_OK || got < 2) {
        return status;
    }
    ss_page_text(&zhong->paper->page,
                 "The program with solver: relaxation, %s, 0.25 N: the network develops in its own "
                 "time, some Euler steps a step of the body, warm-started.",
                 tube->name);
    ss_page_table_begin(&zhong->paper->page, 4, head);
    for (int32_t k = 0; k < got; ++k) {
        ss_row row = {.count = 0};
        ss_row_add(&row, steps[k] == 0 ? "equilibrium" : "%d steps", steps[k]);
        ss_row_add(&row, "%.4f", all[k].early);
        ss_row_add(&row, "%.4f", all[k].late);
        ss_row_add_number(&row, all[k].step_us);
        ss_page_table_row(&zhong->paper->page, row.count, row.cell);
    }
    ss_page_table_end(&zhong->paper->page);
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    const double reference = net != NULL ? ss_tube_net_static(net, 0.25, NULL, NULL) : (double)NAN;
    ss_zhong_net_destroy(&net);
    for (int32_t k = 1; k < got; ++k) {
        ss_claim_near(zhong->paper, "eq. 19", SS_FROM_CODE, reference, all[k].late, 2e-3,
                      "%s: %d Euler steps of the network a step end in the deformation of the "
                      "Poisson equation's solution, m",
                      tube->name, steps[k]);
    }
    return status;
}

/* Both with a bound K of half the contact's potential under this load: the reference network with
 * its current held at what K leaves, K/ghat of the contact. */
static softsim_status saturated_on(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    static const double force_n = 0.25;
    watched still, relaxed;
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    double reference = (double)NAN, bound = 0.0;
    if (net != NULL) {
        reference = ss_tube_net_static(net, force_n, NULL, NULL);
        net->most_current = 0.5 * net->current;
        bound = net->most_current * net->potential[SS_TUBE_CONTACT];
    }
    const double soft = net != NULL ? ss_tube_net_static(net, force_n, NULL, NULL) : (double)NAN;
    ss_zhong_net_destroy(&net);
    if (!(bound > 0.0)) {
        return ss_memory_fault(error);
    }
    softsim_status status = watch(zhong, tube, 0, bound, &still, error);
    if (status == SOFTSIM_OK) {
        status = watch(zhong, tube, 16, bound, &relaxed, error);
    }
    if (status == SOFTSIM_OK && !isnan(still.late)) {
        ss_claim_near(zhong->paper, "eq. 1", SS_FROM_CODE, soft, still.late, 1e-3,
                      "%s: with the contact's output bounded the body gives way further than "
                      "without (%.4g m): depth at 0.25 N, m",
                      tube->name, reference);
    }
    if (status == SOFTSIM_OK && !isnan(relaxed.late)) {
        ss_claim_near(zhong->paper, "eq. 1", SS_FROM_CODE, soft, relaxed.late, 2e-3,
                      "%s: saturated, the network relaxed in its own time ends there too, m",
                      tube->name);
    }
    return status;
}

softsim_status ss_zhong_relaxation(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    ss_output csv;
    ss_page_text(&paper->page,
                 "The paper: the network is a circuit, (1), (2), that develops in time until its "
                 "activity does not change any more, (19); its bound K is a nonlinearity of the "
                 "cell; in hardware the collective activity of all cells is fast. Here: the model "
                 "solves for the equilibrium directly. The circuit itself is run beside it.");
    softsim_status status = ss_paper_csv_open(paper, &csv, "relaxation",
                                              "mesh,step,network_time,residual,field_error", error);
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        if (zhong->tube[k].is_there) {
            status = settle_on(zhong, &zhong->tube[k], csv.file, error);
        }
        ss_paper_progress(paper, 0.2 * (k + 1));
    }
    status = ss_paper_csv_end(paper, &csv, "relaxation", status, error);
    if (status == SOFTSIM_OK) {
        status = plot_settling(zhong, error);
    }
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        if (zhong->tube[k].is_there) {
            status = relax_on(zhong, &zhong->tube[k], error);
        }
        if (status == SOFTSIM_OK && zhong->tube[k].is_there) {
            status = saturated_on(zhong, &zhong->tube[k], error);
        }
    }
    return status;
}
