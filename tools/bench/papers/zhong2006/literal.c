/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Equations 3, 4, 26 and 28 as they are printed, and what the closure adds to them, on the cylinder
 * of triangles with motion.h: none of this is in the program. Each reading is loaded with a
 * force for 50 s and left alone for 200 s; a soft tissue is back by then (ks/gamma is 1/20 s).
 * Readings: which source, whose lengths in (26), rest springs or none, and the force.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhong2006/motion.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/memory.h"
#include "rt/vec.h"

static const double step_s = 0.0125, load_s = 50.0, sample_s = 0.5;
static const double is_back = 0.01, is_apart = 0.05;

enum { FORCES = 4 };
static const double forces_n[FORCES] = {0.5, 0.1, 0.02, 0.004}; /* a quick report: the first two */

/* Readings of one sentence; a claim each. */
static const struct reading {
    const char *figure, *name, *label;
    ss_zhong_source source;
    bool is_length_current, has_rest;
} readings[] = {
    {"eq. 28", "closure", "the closure: I = E max(0, Q/Qhat), rest lengths, rest springs",
     SS_ZHONG_CLOSURE, false, true},
    {"eq. 28", "no-rest", "the closure without rest springs", SS_ZHONG_CLOSURE, false, false},
    {"eq. 4", "work-rest", "I = F.U/A, rest lengths, rest springs", SS_ZHONG_WORK, false, true},
    {"eq. 4", "work", "I = F.U/A, rest lengths, no rest springs", SS_ZHONG_WORK, false, false},
    {"eq. 26", "current-length", "the closure with |PiPj| as it is now, rest springs",
     SS_ZHONG_CLOSURE, true, true},
    {"eq. 26", "work-current-length", "I = F.U/A with |PiPj| as it is now, rest springs",
     SS_ZHONG_WORK, true, true},
};
enum { READING_COUNT = sizeof readings / sizeof readings[0] };

softsim_status ss_zhong_load_and_leave(const ss_zhong_net *net, const ss_tube *tube,
                                       const ss_zhong_law *law, const char *name, double force,
                                       double left_s, FILE *csv, ss_zhong_outcome *out,
                                       softsim_error *error)
{
    ss_zhong_motion motion;
    *out = (ss_zhong_outcome){.shortest = 1.0};
    if (!ss_zhong_motion_init(&motion, net, law, SS_TUBE_CONTACT, SS_TUBE_TRIANGLES,
                              (const int32_t(*)[3])tube->triangle)) {
        ss_zhong_motion_fini(&motion);
        return ss_memory_fault(error);
    }
    const int32_t samples = (int32_t)((load_s + left_s) / sample_s + 0.5);
    for (int32_t k = 1; k <= samples; ++k) {
        motion.force[1] = k * sample_s <= load_s + 1e-9 ? -force : 0.0;
        ss_zhong_motion_run(&motion, (int32_t)(sample_s / step_s + 0.5), step_s);
        const double depth = -motion.u[SS_TUBE_CONTACT][1];
        out->shortest = fmin(out->shortest, ss_zhong_motion_shortest(&motion));
        out->loaded = motion.force[1] < 0.0 ? depth : out->loaded;
        out->left = depth;
        fprintf(csv, "%s,%g,%g,%.6g,%.6g\n", name, force, k * sample_s, depth, out->shortest);
    }
    out->left = fabs(out->left / out->loaded);
    ss_zhong_motion_fini(&motion);
    return SOFTSIM_OK;
}

/* (28) as it is printed, whatever the source: what is left at best. */
typedef struct as_printed {
    double left;
    char text[320];
} as_printed;

static void add_printed(as_printed *printed, const struct reading *at, double left)
{
    char part[160];
    snprintf(part, sizeof part, "%s%s: %.3g %% left at best", printed->text[0] != '\0' ? "; " : "",
             at->label, 100.0 * left);
    strncat(printed->text, part, sizeof printed->text - strlen(printed->text) - 1);
    printed->left = fmin(printed->left, left);
}

static void claim_printed(ss_paper *paper, const as_printed *printed, double left_s)
{
    ss_claim_add(paper, "eq. 28", SS_FROM_PAPER,
                 printed->left <= is_back ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "back after unloading", printed->text,
                 "the equation of motion as printed, no rest springs: elastic, returns to its "
                 "natural state (reference network)");
    ss_claim_search(paper,
                    "both sources, at rest lengths, forces of 0.004 to 0.5 N (a quick "
                    "report: 0.1 and 0.5), %g s after unloading: nothing in (28) remembers "
                    "the rest, so where the network is slack the body stays; with rest "
                    "springs both return",
                    left_s);
}

/* All forces of one reading: the claim that it returns, and where lengths are those of now, the
 * claim that points keep apart. It passes where some force satisfies it and differs where none
 * does. */
static softsim_status try_reading(ss_paper *paper, const ss_zhong_net *net, const ss_tube *tube,
                                  const struct reading *at, double left_s, FILE *csv,
                                  as_printed *printed, softsim_error *error)
{
    const ss_zhong_law law = {.source = at->source,
                              .is_length_current = at->is_length_current,
                              .modulus = SS_TUBE_MODULUS,
                              .mass = 1.0,
                              .damping = 2.0,
                              .rest_stiffness = at->has_rest ? SS_TUBE_KS : 0.0};
    const int count = paper->is_quick ? 2 : FORCES;
    int back = 0;
    char text[288] = "", told[320], part[96];
    double best_left = (double)INFINITY, best_apart = 0.0;
    for (int k = 0; k < count; ++k) {
        ss_zhong_outcome out;
        const softsim_status status = ss_zhong_load_and_leave(
            net, tube, &law, at->name, forces_n[k], left_s, csv, &out, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
        best_left = fmin(best_left, out.left);
        back += out.left <= is_back;
        best_apart = fmax(best_apart, out.shortest);
        snprintf(part, sizeof part, "%s%g N: %.3g m, %.3g %% left, shortest edge %.2g",
                 k > 0 ? "; " : "", forces_n[k], out.loaded, 100.0 * out.left, out.shortest);
        strncat(text, part, sizeof text - strlen(text) - 1);
    }
    if (!at->has_rest) {
        add_printed(printed, at, best_left);
        return SOFTSIM_OK;
    }
    snprintf(told, sizeof told, "at %d of %d forces: %s", back, count, text);
    ss_claim_add(paper, at->figure, SS_FROM_PAPER, back > 0 ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "back after unloading, at some force", told,
                 "%s: elastic, returns to its natural state (reference network)", at->label);
    ss_claim_search(paper, "forces of %g to %g N, %g s after unloading", forces_n[count - 1],
                    forces_n[0], left_s);
    if (at->is_length_current) {
        ss_claim_add(paper, at->figure, SS_FROM_PAPER,
                     best_apart > is_apart ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS, "points keep apart",
                     text, "%s: a shape of finite edges at some force (reference network)",
                     at->label);
        ss_claim_search(paper,
                        "forces of %g to %g N: a pull rho I/|PiPj| has no bound as an edge "
                        "shortens",
                        forces_n[count - 1], forces_n[0]);
    }
    return SOFTSIM_OK;
}

/* ---- F.U/A on the hexagon ---- */

/* Static depth of the hexagon's centre over its edge under a force, with I = F.U/A. */
static double hexagon_share(double force, double ks, bool is_length_current)
{
    static const double edge_m = 0.3;
    int32_t triangle[6][3];
    const ss_zhong_law law = {.source = SS_ZHONG_WORK,
                              .is_length_current = is_length_current,
                              .mass = 1.0,
                              .damping = 2.0,
                              .rest_stiffness = ks};
    ss_zhong_motion motion = {.net = NULL};
    ss_zhong_net *net = ss_zhong_net_hexagon(edge_m, triangle);
    double share = (double)NAN;
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

/* Without rest springs F stands on both sides of the balance and cancels; with them the depth
 * follows the force, up to where the network alone balances it. */
static void hexagon_claim(ss_paper *paper, double ks, bool is_length_current)
{
    char text[320];
    const double free[2] = {hexagon_share(0.1, 0.0, is_length_current),
                            hexagon_share(1.0, 0.0, is_length_current)};
    const double held[2] = {hexagon_share(0.1, ks, is_length_current),
                            hexagon_share(1.0, ks, is_length_current)};
    snprintf(text, sizeof text,
             "with rest springs of %g N/m %.4f of its edge at 0.1 N, %.4f at 1 N; without %.4f and "
             "%.4f: F stands on both sides and cancels",
             ks, held[0], held[1], free[0], free[1]);
    ss_claim_add(
        paper, "eq. 4", SS_FROM_PAPER,
        fmax(held[1] / held[0], free[1] / free[0]) > 1.05 ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
        "more force, more displacement", text,
        "I = F.U/A on the hexagon, |PiPj| %s: the displacement depends on the force (reference "
        "network)",
        is_length_current ? "as it is now" : "at rest");
    ss_claim_search(paper, "with and without rest springs, 0.1 and 1 N");
}

/* At rest lengths z^2 (3/2) F/A + ks z = F, A = sqrt 3 h^2/2: with rest springs, by hand. */
static void hexagon_by_hand(ss_paper *paper, double ks)
{
    static const double edge_m = 0.3, force = 0.1;
    const double a = 1.5 * force / (0.5 * sqrt(3.0) * edge_m * edge_m);
    const double z = (sqrt(ks * ks + 4.0 * a * force) - ks) / (2.0 * a);
    ss_claim_near(
        paper, "eq. 4", SS_FROM_CLOSED_FORM, z / edge_m, hexagon_share(force, ks, false), 1e-3,
        "I = F.U/A on the hexagon with rest springs: depth at %g N over its edge (reference "
        "network)",
        force);
}

/* ---- the section ---- */

static softsim_status plot_readings(ss_zhong *zhong, softsim_error *error)
{
    ss_output script;
    const softsim_status status =
        ss_plot_open_sized(&script, zhong->paper->folder, "literal", 800, 560, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_plot_key_below(script.file, READING_COUNT);
    fputs("set datafile separator ','\nset grid\n"
          "set xlabel 'time, s'\nset ylabel 'displacement of the contact, m'\n"
          "set arrow from 50, graph 0 to 50, graph 1 nohead dt 3\nset label "
          "'unloaded' at 52, graph 0.95\nplot ",
          script.file);
    for (int k = 0; k < READING_COUNT; ++k) {
        fprintf(script.file,
                "%s'literal.csv' skip 1 using 3:(stringcolumn(1) eq '%s' && $2==%g ? $4 : NaN) "
                "with lines lw %d lc %d title '%s'",
                k > 0 ? ", " : "", readings[k].name, forces_n[0], k == 0 ? 4 : 2, k + 1,
                readings[k].label);
    }
    fputc('\n', script.file);
    return ss_page_plot(&zhong->paper->page, &script, "literal",
                        "The paper's equations as printed, and what the closure adds, under 0.5 N: "
                        "without rest springs nothing comes back; with |PiPj| as it is now points "
                        "fall together at this force.",
                        error);
}

softsim_status ss_zhong_literal(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    const ss_tube *tube = &zhong->tube[1];
    const double left_s = paper->is_quick ? 100.0 : 200.0, hexagon_ks = 0.3;
    as_printed printed = {.left = (double)INFINITY};
    ss_output csv;
    ss_page_text(
        &paper->page,
        "The paper: the current of the contact's cell is the work of the force over area "
        "(3), (4); the force between two points is rho |v_i - v_j|/|PiPj| (26); points "
        "move by (28), which has no term that remembers the rest. It does not say whether "
        "|PiPj| is the length at rest or now, nor what acts after unloading. Here, by the "
        "second implementation, not the program: each reading loaded for 50 s at several "
        "forces, then left alone. Told for each force: the displacement under it, the share of "
        "it that is left, and the shortest edge over its length at rest.");
    for (int k = 0; k < 2; ++k) {
        hexagon_claim(paper, hexagon_ks, k == 1);
    }
    hexagon_by_hand(paper, hexagon_ks);
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    softsim_status status = net != NULL ? SOFTSIM_OK : ss_memory_fault(error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_open(paper, &csv, "literal",
                                   "reading,force_n,time_s,u_m,shortest_edge", error);
    }
    if (status != SOFTSIM_OK) {
        ss_zhong_net_destroy(&net);
        return status;
    }
    for (int k = 0; status == SOFTSIM_OK && k < READING_COUNT; ++k) {
        status = try_reading(paper, net, tube, &readings[k], left_s, csv.file, &printed, error);
        ss_paper_progress(paper, (k + 1.0) / READING_COUNT);
    }
    ss_zhong_net_destroy(&net);
    if (status == SOFTSIM_OK) {
        claim_printed(paper, &printed, left_s);
        status = ss_paper_csv_close(paper, &csv, "literal", error);
    } else {
        ss_output_abandon(&csv);
    }
    return status == SOFTSIM_OK ? plot_readings(zhong, error) : status;
}
