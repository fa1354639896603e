/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Loading and unloading (Fig. 5b), on the plane and in a block of tetrahedra. The paper
 * unloads "by restoring the chain links to their initial lengths" and says no more: alpha that
 * falls with the depth (ramp), at once (literal), or not at all (keep).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhang2018/zhang2018.h"
#include "rt/vec.h"

enum { RAMP, LITERAL, KEEP, RULE_COUNT, MAX_ROWS = 16384 };
static const char *const rule_name[RULE_COUNT] = {"ramp", "literal", "keep"};
static const double plane_depth = 5.0, plane_pace = 0.01, plane_step_s = 0.25; /* h, h/C, C */
static const double plateau_s = 1000.0;                                        /* C */
static const double block_share = 0.85, block_pace = 0.01; /* of the mean link; of it in C */
enum { BLOCK_POINTS = 1331, BLOCK_PATCH = 9 };

typedef struct loop {
    int32_t count, turn; /* rows; the last of loading */
    double depth[MAX_ROWS], force[MAX_ROWS];
} loop;

/* Work between two rows, J. */
static double work(const loop *l, int32_t from, int32_t to)
{
    double sum = 0.0;
    for (int32_t k = from + 1; k <= to; ++k) {
        sum += 0.5 * (l->force[k] + l->force[k - 1]) * (l->depth[k] - l->depth[k - 1]);
    }
    return sum;
}

/* The same way, in steps of h, by the report's reference network, which is used up. */
static void go_round_reference(ss_zhang_reference *reference, const loop *like, double h, loop *out)
{
    *out = (loop){.count = like->count, .turn = like->turn};
    for (int32_t k = 1; k < like->count; ++k) {
        ss_zhang_reference_step(reference, like->depth[k], h);
        out->depth[k] = like->depth[k];
        out->force[k] = reference->force;
    }
    ss_zhang_reference_fini(reference);
}

/* Area of the loop over the work of loading. */
static double lost(const loop *l)
{
    return work(l, 0, l->count - 1) / work(l, 0, l->turn);
}

static softsim_status go_round(const ss_zhang_setup *setup, double speed, loop *out,
                               double *out_step_s, char out_reason[256], softsim_error *error)
{
    ss_zhang_run run;
    const softsim_status status = ss_zhang_begin(setup, &run, error);
    snprintf(out_reason, 256, "%s", run.reason);
    *out = (loop){.count = 1};
    *out_step_s = run.step_s;
    if (status == SOFTSIM_OK && run.model != NULL) {
        const int32_t steps = (int32_t)ceil(setup->depth / (speed * run.step_s) - 1e-9);
        for (int32_t k = 1; k <= 2 * steps && out->count < MAX_ROWS; ++k) {
            const int32_t at = k <= steps ? k : 2 * steps - k;
            ss_zhang_step(&run, setup->depth * at / steps);
            out->turn = k == steps ? out->count : out->turn;
            out->depth[out->count] = run.depth;
            out->force[out->count++] = ss_zhang_force(&run);
        }
    }
    ss_zhang_end(&run);
    return status;
}

static softsim_status write_loops(ss_zhang *zhang, const loop *l, const char *name,
                                  const char *unit, double scale, const char *caption,
                                  softsim_error *error)
{
    ss_output csv, script;
    softsim_status status =
        ss_paper_csv_open(zhang->paper, &csv, name, "unloading,is_loading,depth_m,force_n", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int r = 0; r < RULE_COUNT; ++r) {
        const int32_t stride = 1 + l[r].count / 1000;
        for (int32_t k = 0; k < l[r].count;
             k += k == l[r].turn || l[r].turn - k > stride || k > l[r].turn ? stride : 1) {
            fprintf(csv.file, "%s,%d,%.6g,%.6g\n", rule_name[r], k <= l[r].turn, l[r].depth[k],
                    l[r].force[k]);
        }
    }
    status = ss_paper_csv_close(zhang->paper, &csv, name, error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, zhang->paper->folder, name, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset grid\nset key top left\n"
            "set xlabel 'displacement, %s'\nset ylabel 'force, N'\n"
            "plot '%s.csv' skip 1 using (strcol(1) eq 'ramp' && $2==1 ? $3*%g : NaN):4 with lines "
            "lw 2 lc rgb 'black' title 'loading'",
            unit, name, scale);
    static const char *const colour[RULE_COUNT] = {"#c02020", "#e09020", "#2060c0"};
    for (int r = 0; r < RULE_COUNT; ++r) {
        fprintf(script.file,
                ", '' skip 1 using (strcol(1) eq '%s' && $2==0 ? $3*%g : NaN):4 with lines lw 2 "
                "lc rgb '%s' title 'unloading, %s'",
                rule_name[r], scale, colour[r], rule_name[r]);
    }
    fputc('\n', script.file);
    return ss_page_plot(&zhang->paper->page, &script, name, caption, error);
}

static const ss_zhang_rule reference_rule[RULE_COUNT] = {SS_REFERENCE_RAMP, SS_REFERENCE_LITERAL,
                                                         SS_REFERENCE_KEEP};

/* One loop of each rule at a place: the reference network's number, and that it takes energy where
 * the rule is one that can be under a hand. */
static void claim_loop(ss_paper *paper, const char *where, int rule, const loop *l,
                       const loop *reference)
{
    ss_claim_near(paper, "Fig. 5b", SS_FROM_CODE, lost(reference), lost(l), 2e-3,
                  "%s, unloading %s: area of the loop over the work of loading", where,
                  rule_name[rule]);
    if (rule != LITERAL) {
        ss_claim_at_least(paper, "Fig. 5b", SS_FROM_PAPER, 0.05, lost(l),
                          "%s, unloading %s: two distinct paths, as tissue's, the loop taking "
                          "energy: the same",
                          where, rule_name[rule]);
    }
}

static softsim_status on_plane(ss_zhang *zhang, loop *l, softsim_error *error)
{
    static loop reference_loop; /* large */
    char reason[256] = "", rule[32];
    softsim_status status = SOFTSIM_OK;
    for (int r = 0; r < RULE_COUNT && status == SOFTSIM_OK && reason[0] == '\0'; ++r) {
        double step_s;
        ss_zhang_reference reference;
        snprintf(rule, sizeof rule, "unloading=%s", rule_name[r]);
        const char *const param[] = {"alpha=0.02", "link_stiffness_n_per_m=1", "capacitance_s=1",
                                     rule};
        ss_zhang_setup setup =
            ss_zhang_plane_setup(&zhang->plane, "cnn-chainmail", plane_depth, plane_step_s);
        memcpy(setup.param, param, sizeof param);
        status = go_round(&setup, plane_pace, &l[r], &step_s, reason, error);
        if (status == SOFTSIM_OK && reason[0] == '\0') {
            status =
                ss_zhang_plane_reference(&zhang->plane, reference_rule[r], NULL, &reference, error);
        }
        if (status == SOFTSIM_OK && reason[0] == '\0') {
            go_round_reference(&reference, &l[r], step_s, &reference_loop);
            claim_loop(zhang->paper, "plane at 0.01 h/C", r, &l[r], &reference_loop);
        }
    }
    if (status != SOFTSIM_OK || reason[0] != '\0') {
        return status;
    }
    return write_loops(
        zhang, l, "fig5b-plane", "h", 1.0,
        "Fig. 5b: the plane pushed 5 h and back at 0.01 h/C. Below zero a cell that is "
        "held is pulled; a tool would let go there.",
        error);
}

/* The block stands on its bottom and is pushed on the middle of its top. */
static softsim_status make_block(ss_zhang *zhang, ss_zhang_solid *block, softsim_error *error)
{
    const double up[3] = {0.0, 0.0, 1.0};
    const softsim_status status =
        ss_zhang_solid_make(zhang->paper, "block", BLOCK_POINTS, block, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    double low = (double)INFINITY, middle[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < block->mesh->node_count; ++i) {
        low = fmin(low, block->mesh->position[i][2]);
        ss_madd3(middle, middle, 1.0 / block->mesh->node_count, block->mesh->position[i]);
    }
    for (int32_t i = 0; i < block->mesh->node_count; ++i) {
        block->fixed[i] = block->mesh->position[i][2] < low + 1e-3 * block->mean_length ? 7 : 0;
    }
    return ss_zhang_solid_patch(block, middle, up, BLOCK_PATCH, error);
}

/* Deep in a volume every link finds slack to go round: what is held is let go of. */
static softsim_status claim_no_plateau(ss_zhang *zhang, const ss_zhang_solid *block,
                                       softsim_error *error)
{
    ss_zhang_run run;
    ss_zhang_reference reference;
    ss_zhang_setup setup =
        ss_zhang_solid_setup(block, "cnn-chainmail", block_share * block->mean_length);
    const char *const param[] = {"alpha=0.1",       "link_stiffness_n_per_m=100",
                                 "capacitance_s=1", "coarse_cells=0",
                                 "tet_guard=0",     NULL};
    memcpy(setup.param, param, sizeof param);
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    if (status == SOFTSIM_OK && run.model != NULL) {
        status = ss_zhang_go(&run, setup.depth, block->mean_length, error);
        const double peak = ss_zhang_force(&run);
        if (status == SOFTSIM_OK) {
            status = ss_zhang_hold(&run, plateau_s, error);
        }
        if (status == SOFTSIM_OK) {
            status = ss_zhang_solid_reference(block, 0.1, SS_REFERENCE_KEEP, &reference, error);
        }
        if (status == SOFTSIM_OK) {
            ss_zhang_reference_go(&reference, setup.depth, block->mean_length, run.step_s);
            const double reference_peak = reference.force;
            ss_zhang_reference_hold(&reference, plateau_s, run.step_s);
            /* How links that are squeezed turn aside is a matter of rounding: with places off by
             * 1e-7 of a link the reference network ends at a third of this. */
            ss_claim_at_most(
                zhang->paper, "Fig. 5c", SS_FROM_CODE, reference.force / reference_peak,
                ss_zhang_force(&run) / peak,
                "block, alpha 0.1, %.2g mean links deep: stress relaxes to nothing: "
                "force after %g C over the peak, at most the reference network's: a minimum "
                "above 0 needs more depth than the slack",
                block_share, plateau_s);
            ss_zhang_reference_fini(&reference);
        }
    }
    ss_zhang_end(&run);
    return status;
}

static ss_zhang_setup block_setup(const ss_zhang_solid *block, const char *rule)
{
    ss_zhang_setup setup =
        ss_zhang_solid_setup(block, "cnn-chainmail", block_share * block->mean_length);
    const char *const param[] = {"alpha=0.05",
                                 "link_stiffness_n_per_m=100",
                                 "capacitance_s=1",
                                 "coarse_cells=0",
                                 "tet_guard=0",
                                 rule,
                                 NULL};
    memcpy(setup.param, param, sizeof param);
    return setup;
}

/* The literal rule at other paces, by the reference network: where it takes energy and where it
 * gives. */
static softsim_status search_literal(ss_zhang *zhang, const ss_zhang_solid *block, double step_s,
                                     softsim_error *error)
{
    static const double paces[] = {1.0, 0.3, 0.1, 0.03, 0.01, 0.003};
    enum { PACES = sizeof paces / sizeof *paces };
    static loop way, reference_loop; /* large */
    const double depth = block_share * block->mean_length;
    double least = (double)INFINITY, most = -(double)INFINITY, slowest_good = (double)NAN;
    for (int k = 0; k < PACES; ++k) {
        ss_zhang_reference reference;
        const double step = step_s * paces[k] * block->mean_length;
        const int32_t steps = (int32_t)fmin(ceil(depth / step), MAX_ROWS / 2 - 1);
        const softsim_status status =
            ss_zhang_solid_reference(block, 0.05, SS_REFERENCE_LITERAL, &reference, error);
        if (status != SOFTSIM_OK) {
            return status;
        }
        way = (loop){.count = 2 * steps + 1, .turn = steps};
        for (int32_t i = 0; i < way.count; ++i) {
            way.depth[i] = depth * (i <= steps ? i : 2 * steps - i) / steps;
        }
        go_round_reference(&reference, &way, step_s, &reference_loop);
        least = fmin(least, lost(&reference_loop));
        most = fmax(most, lost(&reference_loop));
        slowest_good = lost(&reference_loop) > 0.0 ? paces[k] : slowest_good;
    }
    char measured[320];
    snprintf(measured, sizeof measured,
             "%.3g (slowest) to %.3g (fastest) of the work of loading; positive down to %g mean "
             "links a C: quickly the drag pays, slowly links that are restored at once pull harder "
             "on the way back than they resisted on the way in",
             least, most, slowest_good);
    ss_claim_add(zhang->paper, "Fig. 5b", SS_FROM_PAPER,
                 most > 0.0 ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "a loop that takes energy, as tissue's, at some pace", measured,
                 "block, links restored to their initial lengths at once (reference network)");
    ss_claim_search(zhang->paper, "paces of 0.003 to 1 mean link a C, alpha 0.05, this block");
    ss_page_text(&zhang->paper->page,
                 "Restored at once, the links give energy to a hand that goes slowly; alpha that "
                 "falls with the depth (ramp) takes it at every pace tried above, so that is the "
                 "default.");
    return SOFTSIM_OK;
}

static softsim_status in_block(ss_zhang *zhang, loop *l, softsim_error *error)
{
    static loop reference_loop; /* large */
    char reason[256] = "", rule[32], where[64];
    ss_zhang_solid block;
    double step_s = 0.0;
    softsim_status status = make_block(zhang, &block, error);
    for (int r = 0; r < RULE_COUNT && status == SOFTSIM_OK && reason[0] == '\0'; ++r) {
        ss_zhang_reference reference;
        snprintf(rule, sizeof rule, "unloading=%s", rule_name[r]);
        const ss_zhang_setup setup = block_setup(&block, rule);
        status = go_round(&setup, block_pace * block.mean_length, &l[r], &step_s, reason, error);
        if (status == SOFTSIM_OK && reason[0] == '\0') {
            status = ss_zhang_solid_reference(&block, 0.05, reference_rule[r], &reference, error);
        }
        if (status == SOFTSIM_OK && reason[0] == '\0') {
            go_round_reference(&reference, &l[r], step_s, &reference_loop);
            snprintf(where, sizeof where, "block of %d tetrahedra, slowly",
                     block.mesh->tetrahedron_count);
            claim_loop(zhang->paper, where, r, &l[r], &reference_loop);
        }
        ss_paper_progress(zhang->paper, 0.2 + 0.2 * (r + 1));
    }
    if (status == SOFTSIM_OK && reason[0] == '\0') {
        status = search_literal(zhang, &block, step_s, error);
    }
    if (status == SOFTSIM_OK && reason[0] == '\0') {
        status = write_loops(zhang, l, "fig5b-block", "mm", 1e3,
                             "Fig. 5b: a block of 100 mm, alpha 0.05, pushed on a patch of its top "
                             "and back, slowly.",
                             error);
    }
    if (status == SOFTSIM_OK && reason[0] == '\0') {
        status = claim_no_plateau(zhang, &block, error);
    }
    ss_zhang_solid_fini(&block);
    return status;
}

softsim_status ss_zhang_hysteresis(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    static loop l[RULE_COUNT]; /* large */
    ss_page_text(&paper->page,
                 "The paper: loading and unloading follow two distinct paths; for unloading the "
                 "links are restored to their initial lengths. How fast is not said. Readings: "
                 "alpha falls with the depth (ramp), to nothing at once (literal), or stays "
                 "(keep).");
    const softsim_status status = on_plane(zhang, l, error);
    return status == SOFTSIM_OK && zhang->has_network ? in_block(zhang, l, error) : status;
}
