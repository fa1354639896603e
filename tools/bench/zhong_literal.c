/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Equations 3 to 9 as they are printed, and what the closure adds to them, on the cylinder of
 * triangles with zhong_motion.h: none of this is in the program. Each law is loaded with 0.5 N for
 * 50 s and left alone for 200 s; a soft tissue is back by then (ks/gamma is 1/20 s).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/vec.h"
#include "zhong.h"
#include "zhong_motion.h"

static const double step_s = 0.0125, load_s = 50.0, sample_s = 0.5, load_n = 0.5;

static const struct variant {
    const char *figure, *name, *label;
    ss_zhong_source source;
    double along, across; /* Young's moduli of C, Pa; of the closure E */
    bool is_length_current, has_rest;
    const char *reason; /* why it does not come back, or collapses */
} variants[] = {
    {"eq. 28", "closure", "the closure: I = E max(0, Q/Qhat), rest lengths, rest springs",
     SS_ZHONG_CLOSURE, SS_TUBE_MODULUS, 0.0, false, true, ""},
    {"eq. 28", "no-rest", "the closure without rest springs", SS_ZHONG_CLOSURE, SS_TUBE_MODULUS,
     0.0, false, false,
     "nothing in (28) remembers the rest: where the network is slack the body stays"},
    {"eq. 26", "current-length", "the closure with |PiPj| as it is now", SS_ZHONG_CLOSURE,
     SS_TUBE_MODULUS, 0.0, true, true,
     "the pull grows without bound as an edge shortens, so edges collapse"},
    {"eq. 4", "work", "I = F.U/A, |PiPj| at rest", SS_ZHONG_WORK, 0.0, 0.0, false, false,
     "no force, no current: after unloading nothing pulls back"},
    {"eq. 4", "work-current-length", "I = F.U/A, |PiPj| as it is now", SS_ZHONG_WORK, 0.0, 0.0,
     true, false, "no current after unloading; before it edges collapse"},
    {"eq. 9", "isotropic", "I = sigma:eps, linear strain, isotropic C of 60 Pa", SS_ZHONG_DENSITY,
     60.0, 60.0, false, false,
     "the dent's own strain keeps the current up, and the current keeps the dent"},
    {"eq. 9", "isotropic-rest", "I = sigma:eps, isotropic C of 60 Pa, with rest springs",
     SS_ZHONG_DENSITY, 60.0, 60.0, false, true,
     "bistable: rest is an equilibrium and so is a dent"},
    {"eq. 9", "isotropic-soft", "I = sigma:eps, isotropic C of 6 Pa, with rest springs",
     SS_ZHONG_DENSITY, 6.0, 6.0, false, true, "still dented, though a tenth as stiff"},
    {"eq. 9", "orthotropic", "I = sigma:eps, C of 60 Pa along the axis and 120 across",
     SS_ZHONG_DENSITY, 60.0, 120.0, false, false,
     "as in the isotropic case: C only scales the current"},
    {"eq. 9", "orthotropic-rest", "I = sigma:eps, C of 60 and 120 Pa, with rest springs",
     SS_ZHONG_DENSITY, 60.0, 120.0, false, true, "bistable as well"},
};
enum { VARIANT_COUNT = sizeof variants / sizeof variants[0] };

typedef struct outcome {
    double loaded, left; /* m: depth at the end of the load, and of the run */
    double shortest;     /* edge over its rest length, least of the run */
    double current;      /* in the end */
} outcome;

static softsim_status no_memory(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
    return SOFTSIM_ERROR_MEMORY;
}

/* Loads and leaves one law, with a row of the CSV a sample. */
static softsim_status load_and_leave(const ss_zhong_net *net, const ss_tube *tube,
                                     const struct variant *at, double left_s, FILE *csv,
                                     outcome *out, softsim_error *error)
{
    ss_zhong_motion motion;
    ss_zhong_law law = {.source = at->source,
                        .is_length_current = at->is_length_current,
                        .modulus = at->along,
                        .mass = 1.0,
                        .damping = 2.0,
                        .rest_stiffness = at->has_rest ? SS_TUBE_KS : 0.0};
    *out = (outcome){.shortest = 1.0};
    if (at->source == SS_ZHONG_DENSITY && !ss_zhong_hooke(at->along, at->across, law.tensor)) {
        return no_memory(error);
    }
    if (!ss_zhong_motion_init(&motion, net, &law, SS_TUBE_CONTACT, SS_TUBE_TRIANGLES,
                              (const int32_t(*)[3])tube->triangle)) {
        ss_zhong_motion_fini(&motion);
        return no_memory(error);
    }
    const int32_t samples = (int32_t)((load_s + left_s) / sample_s + 0.5);
    for (int32_t k = 1; k <= samples; ++k) {
        motion.force[1] = k * sample_s <= load_s + 1e-9 ? -load_n : 0.0;
        ss_zhong_motion_run(&motion, (int32_t)(sample_s / step_s + 0.5), step_s);
        const double depth = -motion.u[SS_TUBE_CONTACT][1];
        out->shortest = fmin(out->shortest, ss_zhong_motion_shortest(&motion));
        out->loaded = motion.force[1] < 0.0 ? depth : out->loaded;
        out->left = depth;
        fprintf(csv, "%s,%g,%.6g,%.6g\n", at->name, k * sample_s, depth, out->shortest);
    }
    out->current = ss_zhong_motion_current(&motion);
    ss_zhong_motion_fini(&motion);
    return SOFTSIM_OK;
}

static void variant_claims(ss_paper *paper, const struct variant *at, double left_s,
                           const outcome *out)
{
    static const double is_back = 0.01, is_collapsed = 0.05;
    char text[320];
    const double residual = fabs(out->left / out->loaded);
    const bool has_returned = residual <= is_back;
    snprintf(text, sizeof text, "%.3g %% of %.3g m left after %g s%s%s", 100.0 * residual,
             out->loaded, left_s, has_returned ? "" : ": ", has_returned ? "" : at->reason);
    ss_claim_add(paper, at->figure, has_returned ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "back after unloading", text, "%s: elastic, returns to rest (own network)",
                 at->label);
    if (at->is_length_current) {
        snprintf(text, sizeof text, "shortest edge %.2g of its length at rest: %s", out->shortest,
                 "a pull rho I/|PiPj| has no bound");
        ss_claim_add(
            paper, at->figure, out->shortest > is_collapsed ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
            "points keep apart", text, "%s: a shape of finite edges (own network)", at->label);
    }
}

/* ---- F.U/A on the hexagon ----------------------------------------------------------------- */

/* Static depth of the hexagon's centre over its edge under a force, with I = F.U/A. */
static double hexagon_share(double force, bool is_length_current)
{
    static const double edge_m = 0.3;
    double position[7][3] = {{0.0, 0.0, 0.0}};
    int32_t triangle[6][3];
    for (int k = 0; k < 6; ++k) {
        const double angle = k * 3.14159265358979323846 / 3.0;
        const int32_t corner[3] = {0, 1 + k, 1 + (k + 1) % 6};
        ss_set3(position[1 + k], edge_m * cos(angle), edge_m * sin(angle), 0.0);
        memcpy(triangle[k], corner, sizeof corner);
    }
    const ss_zhong_law law = {.source = SS_ZHONG_WORK,
                              .is_length_current = is_length_current,
                              .mass = 1.0,
                              .damping = 2.0};
    ss_zhong_motion motion = {.net = NULL};
    ss_zhong_net *net = ss_zhong_net_triangles(7, (const double(*)[3])position, 6,
                                               (const int32_t(*)[3])triangle, NULL, 0.0);
    double share = (double)NAN;
    for (int32_t i = 0; net != NULL && i < 7; ++i) {
        net->is_held[i] = i > 0;
        net->is_source[i] = i == 0;
    }
    if (net != NULL && ss_zhong_net_solve(net) &&
        ss_zhong_motion_init(&motion, net, &law, 0, 6, (const int32_t(*)[3])triangle)) {
        motion.force[2] = force;
        ss_zhong_motion_run(&motion, 40000, 0.005);
        share = motion.u[0][2] / edge_m;
    }
    ss_zhong_motion_fini(&motion);
    ss_zhong_net_destroy(&net);
    return share;
}

static void hexagon_claim(ss_paper *paper, bool is_length_current)
{
    char text[320];
    const double small = hexagon_share(0.1, is_length_current);
    const double large = hexagon_share(1.0, is_length_current);
    snprintf(text, sizeof text,
             "%.4f of its edge at 0.1 N, %.4f at 1 N: F stands on both sides of the balance and "
             "cancels",
             small, large);
    ss_claim_add(paper, "eq. 4", large > 1.05 * small ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "more force, more displacement", text,
                 "I = F.U/A on the hexagon, |PiPj| %s: the displacement depends on the force (own "
                 "network)",
                 is_length_current ? "as it is now" : "at rest");
}

/* ---- the section -------------------------------------------------------------------------- */

static softsim_status plot_variants(ss_zhong *zhong, softsim_error *error)
{
    static const int shown[] = {0, 1, 3, 5, 6, 9};
    ss_output script;
    const softsim_status status = ss_plot_open(&script, zhong->paper->folder, "literal", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("set datafile separator ','\nset grid\nset key below horizontal maxcols 1\nset bmargin "
          "12\nset terminal "
          "svg size 800,620 dynamic font 'sans,13' background rgb "
          "'white'\nset output 'literal.svg'\nset xlabel 'time, s'\nset ylabel 'displacement of "
          "the contact, m'\nset arrow from 50, graph 0 to 50, graph 1 nohead dt 3\nset label "
          "'unloaded' at 52, graph 0.95\nplot ",
          script.file);
    for (size_t k = 0; k < sizeof shown / sizeof *shown; ++k) {
        const struct variant *at = &variants[shown[k]];
        fprintf(script.file,
                "%s'literal.csv' skip 1 using 2:(stringcolumn(1) eq '%s' ? $3 : NaN) with lines lw "
                "%d lc %d title '%s'",
                k > 0 ? ", " : "", at->name, k == 0 ? 4 : 2, (int)k + 1, at->label);
    }
    fputc('\n', script.file);
    return ss_page_plot(&zhong->paper->page, &script, "literal",
                        "The paper's sources as printed, and what the closure adds: only the "
                        "closure comes back.",
                        error);
}

softsim_status ss_zhong_literal(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    const ss_tube *tube = &zhong->tube[1];
    const double left_s = paper->is_quick ? 100.0 : 200.0;
    ss_output csv;
    ss_page_text(&paper->page,
                 "The paper: the current of the contact's cell is the work of the force over area "
                 "(3), (4), or for a point contact the strain energy density (5) with the linear "
                 "strain (6) and Hooke's law (7) to (9), isotropic or not. It does not say what "
                 "acts after unloading, and has no term that remembers the rest. Here, by the "
                 "second implementation, not the program: each reading loaded with 0.5 N for 50 s, "
                 "then left alone.");
    hexagon_claim(paper, false);
    hexagon_claim(paper, true);
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    softsim_status status = net != NULL ? SOFTSIM_OK : no_memory(error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_open(paper, &csv, "literal", "law,time_s,u_m,shortest_edge", error);
    }
    if (status != SOFTSIM_OK) {
        ss_zhong_net_destroy(&net);
        return status;
    }
    for (int32_t k = 0; status == SOFTSIM_OK && k < VARIANT_COUNT; ++k) {
        outcome out;
        status = load_and_leave(net, tube, &variants[k], left_s, csv.file, &out, error);
        if (status == SOFTSIM_OK) {
            variant_claims(paper, &variants[k], left_s, &out);
        }
        ss_paper_progress(paper, (double)(k + 1) / VARIANT_COUNT);
    }
    ss_zhong_net_destroy(&net);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_close(paper, &csv, "literal", error);
    } else {
        ss_output_abandon(&csv);
    }
    return status == SOFTSIM_OK ? plot_variants(zhong, error) : status;
}
