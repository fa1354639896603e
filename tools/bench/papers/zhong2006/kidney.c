/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Figures 12 and 13 and Table 1: the bundled kidney under a probe that pushes, pulls and drags, by
 * the daemon's own haptic tick at 1 kHz without its network; and what a step costs at the paper's
 * sizes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/surface_picture.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "bench/scaling/body.h"
#include "process.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- Figs. 12, 13: the probe ---- */

static const double tool_radius = 0.005;
static const double touch_z = 0.0273; /* m: the tool just touches the upper face over (0, 6 mm) */
static const double free_m = 0.003;   /* height at the start */
enum { KIDNEY_TICKS = 9000, KIDNEY_POINTS = 1200, PHASES = 3 };

/* Where the tool goes: height over touching, and sideways, from what it had to these, during. */
static const struct move {
    double begin_s, end_s, height, along;
} moves[] = {
    {0.3, 0.9, -0.010, 0.0},   /* push */
    {1.3, 1.8, 0.003, 0.0},    /* away */
    {2.2, 2.5, -0.003, 0.0},   /* touch, grasp */
    {2.7, 3.3, 0.008, 0.0},    /* pull */
    {4.2, 4.6, -0.003, 0.0},   /* touch, grasp */
    {4.8, 5.4, -0.003, 0.010}, /* drag */
    {5.8, 6.3, 0.008, 0.010},  /* away */
};
static const double grasps[2][2] = {{2.6, 3.7}, {4.7, 5.8}};

static const struct phase {
    const char *name, *title;
    double look_s;
} phases[PHASES] = {{"fig13-push", "pushed 10 mm deep", 1.25},
                    {"fig13-pull", "grasped and pulled 8 mm out", 3.65},
                    {"fig13-drag", "grasped and dragged 10 mm sideways", 5.75}};

typedef struct session {
    ss_trial_body body;
    ss_trial trial;
    double (*shape[PHASES])[3]; /* displacements at look_s */
    double tool[PHASES][3], force[PHASES][3];
    bool is_grasping[PHASES];
    double largest_j, peak_n;
    int64_t answered;
    softsim_verdict worst;
    softsim_state state; /* in the end */
} session;

static double smooth(double s)
{
    const double t = s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
    return t * t * t * (10.0 - t * (15.0 - 6.0 * t));
}

static void place_tool(double time_s, double out[3])
{
    double height = free_m, along = 0.0;
    for (size_t k = 0; k < sizeof moves / sizeof *moves; ++k) {
        const double share =
            smooth((time_s - moves[k].begin_s) / (moves[k].end_s - moves[k].begin_s));
        height += share * (moves[k].height - height);
        along += share * (moves[k].along - along);
    }
    ss_set3(out, along, 0.006, touch_z + height);
}

static void make_pose(int32_t k, softsim_pose *out)
{
    const double time_s = 1e-3 * k;
    *out = (softsim_pose){.utime_us = (int64_t)k * 1000, .sender = 1, .seq = k, .force_seq = -1};
    place_tool(time_s, out->position);
    out->orientation[0] = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        out->velocity[axis] = out->applied_force[axis] = (double)NAN;
    }
    for (int g = 0; g < 2; ++g) {
        if (time_s >= grasps[g][0] && time_s < grasps[g][1]) {
            out->buttons = SOFTSIM_BUTTON_GRASP;
        }
    }
}

static softsim_status look(session *s, int phase, const softsim_pose *pose,
                           const softsim_force *force, softsim_error *error)
{
    s->shape[phase] = calloc((size_t)s->trial.node_count, sizeof *s->shape[phase]);
    if (s->shape[phase] == NULL) {
        return ss_memory_fault(error);
    }
    softsim_read_nodes(s->trial.world, NULL, s->shape[phase], NULL);
    ss_copy3(s->tool[phase], pose->position);
    ss_copy3(s->force[phase], force->force);
    s->is_grasping[phase] = (force->flags & SOFTSIM_FORCE_GRASPING) != 0;
    return SOFTSIM_OK;
}

static softsim_status play(session *s, ss_paper *paper, FILE *csv, softsim_error *error)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    softsim_status status = SOFTSIM_OK;
    for (int32_t k = 1; status == SOFTSIM_OK && k <= KIDNEY_TICKS; ++k) {
        softsim_pose pose;
        make_pose(k, &pose);
        const softsim_refusal refusal = softsim_tick(s->trial.world, &pose, &channel, 1, force);
        s->answered += refusal == SOFTSIM_ACCEPTED && force[0].pose_seq == k ? 1 : 0;
        s->peak_n = fmax(s->peak_n, ss_norm3(force[0].force));
        for (int p = 0; status == SOFTSIM_OK && p < PHASES; ++p) {
            if (k == (int32_t)(1e3 * phases[p].look_s + 0.5)) {
                status = look(s, p, &pose, &force[0], error);
            }
        }
        if (k % 10 == 0) {
            softsim_read(s->trial.world, &s->state);
            s->largest_j = fmax(s->largest_j, s->state.elastic_j + s->state.kinetic_j);
            s->worst = s->state.verdict > s->worst ? s->state.verdict : s->worst;
            fprintf(csv, "%g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d\n", 1e-3 * k, pose.position[0],
                    pose.position[2] - touch_z, force[0].force[0], force[0].force[1],
                    force[0].force[2], force[0].depth, s->state.elastic_j, pose.buttons);
        }
        if (k % 500 == 0) {
            ss_paper_progress(paper, 0.9 * k / KIDNEY_TICKS);
        }
        if (ss_process_is_stopped()) {
            softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                              "stopped before the end; nothing is reported");
            return SOFTSIM_ERROR_SYSTEM;
        }
    }
    softsim_read(s->trial.world, &s->state);
    softsim_read_nodes(s->trial.world, s->trial.position, s->trial.u, s->trial.v);
    return status;
}

/* The largest component of a displacement along `direction`. */
static double reach(const session *s, int phase, const double direction[3])
{
    double most = 0.0;
    for (int32_t i = 0; i < s->trial.node_count; ++i) {
        most = fmax(most, ss_dot3(s->shape[phase][i], direction));
    }
    return most;
}

static void kidney_claims(ss_paper *paper, const session *s)
{
    static const double down[3] = {0, 0, -1}, up[3] = {0, 0, 1}, along[3] = {1, 0, 0};
    const softsim_state *end = &s->state;
    ss_claim_at_least(paper, "Fig. 12", SS_FROM_PAPER, KIDNEY_TICKS, (double)s->answered,
                      "force feedback: every pose is answered by a force, at 1000 Hz (of %d)",
                      KIDNEY_TICKS);
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 0.3, s->force[0][2],
                      "(a) pushing 10 mm deep: the force on the hand points out of the tissue, N");
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 4.5, 1e3 * reach(s, 0, down),
                      "(a) and the surface gives way by more than 10 %% of the kidney's least "
                      "extent of 45 mm, mm");
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 0.1,
                      s->is_grasping[1] ? -s->force[1][2] : 0.0,
                      "(b) pulling 8 mm out: the force draws the hand back to the tissue, N");
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 2.0, 1e3 * reach(s, 1, up),
                      "(b) and the surface follows outwards, mm");
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 0.1,
                      s->is_grasping[2] ? -s->force[2][0] : 0.0,
                      "(c) dragging 10 mm sideways: the force holds the hand back, N");
    ss_claim_at_least(paper, "Fig. 13", SS_FROM_PAPER, 2.0, 1e3 * reach(s, 2, along),
                      "(c) and the surface follows sideways, mm");
    double left = 0.0;
    for (int32_t i = 0; i < s->trial.node_count; ++i) {
        left = fmax(left, ss_norm3(s->trial.u[i]));
    }
    ss_claim_at_most(paper, "Fig. 13", SS_FROM_CLOSED_FORM, 0.01, 1e3 * left,
                     "let go, the kidney is back in shape (largest displacement, mm)");
    ss_claim_at_most(paper, "Fig. 13", SS_FROM_CLOSED_FORM, 5e-3,
                     fabs(end->elastic_j + end->kinetic_j + end->dissipated_j - end->work_j) /
                         s->largest_j,
                     "the hand's work is all accounted for (elastic + kinetic + dissipated - work "
                     "over the largest stored energy, fraction)");
    ss_page_text(&paper->page, "The server's own verdict throughout: %s; %.2f N at most.",
                 softsim_verdict_name(s->worst), s->peak_n);
}

static softsim_status draw_phase(ss_paper *paper, const session *s, int phase, softsim_error *error)
{
    static const ss_surface_picture_view views[2] = {
        {{0.25, -1.0, 0.55}, {0.0, 0.0, 1.0}, "from the front"},
        {{0.85, 0.6, 0.7}, {0.0, 0.0, 1.0}, "from behind and one end"}};
    const struct phase *at = &phases[phase];
    char caption[256];
    int32_t(*face)[4] =
        ss_surface_faces(s->body.triangle_count, (const int32_t(*)[3])s->body.triangle);
    if (face == NULL) {
        return ss_memory_fault(error);
    }
    ss_surface_picture shape = {.node_count = s->body.node_count,
                                .face_count = s->body.triangle_count,
                                .rest = (const double(*)[3])s->body.rest,
                                .u = (const double(*)[3])s->shape[phase],
                                .face = (const int32_t(*)[4])face,
                                .pushed = -1,
                                .ball_radius = tool_radius};
    ss_copy3(shape.ball, s->tool[phase]);
    snprintf(caption, sizeof caption,
             "Fig. 13, %s: force on the hand (%.2f, %.2f, %.2f) N. Blue: the probe's tip, drawn "
             "over the tissue; dashed: the outline at rest.",
             at->title, s->force[phase][0], s->force[phase][1], s->force[phase][2]);
    const softsim_status status =
        ss_surface_picture_draw(paper, at->name, caption, &shape, views, 2, error);
    free(face);
    return status;
}

static softsim_status plot_forces(ss_paper *paper, softsim_error *error)
{
    ss_output script;
    const softsim_status status = ss_plot_open(&script, paper->folder, "fig13-force", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    fputs("set datafile separator ','\nset grid\nset key top right\nset xlabel 'time, s'\n"
          "set ylabel 'force on the hand, N'\nset y2label 'height of the tool over touching, mm'\n"
          "set ytics nomirror\nset y2tics\nset y2range [-14:14]\n"
          "set label 'push' at 0.9, graph 0.06 center\nset label 'pull' at 3.2, graph 0.06 "
          "center\nset label 'drag' at 5.3, graph 0.06 center\n",
          file);
    for (int g = 0; g < 2; ++g) {
        fprintf(file,
                "set object rectangle from %g, graph 0 to %g, graph 1 behind fs solid 0.12 "
                "noborder fc rgb '#5070d0'\n",
                grasps[g][0], grasps[g][1]);
    }
    fputs("plot 'fig13-force.csv' skip 1 using 1:4 with lines lw 2 lc rgb '#c02020' title "
          "'sideways', '' skip 1 using 1:5 with lines lw 1 lc rgb '#808080' title 'across', "
          "'' skip 1 using 1:6 with lines lw 2 lc rgb '#203080' title 'out of the tissue', "
          "'' skip 1 using 1:(1000*$3) axes x1y2 with lines dt 2 lc rgb 'grey50' title 'tool'\n",
          file);
    return ss_page_plot(&paper->page, &script, "fig13-force",
                        "Figs. 12, 13: the force on the hand while the probe pushes, pulls and "
                        "drags; dashed its height, in the blue stripes it grasps.",
                        error);
}

static const char kidney_model[] = "  name: cnn-energy\n"
                                   "  modulus_j: 5\n"
                                   "  pretension_j: 1\n"
                                   "  enclosed_bulk_pa: 3000\n"
                                   "  rho: 1\n"
                                   "  area_density_kg_m2: 11.5\n"
                                   "  damping_n_s_per_m3: 1725\n"
                                   "  rest_stiffness_n_per_m3: 5.0e+4\n";
static const char kidney_rest[] =
    "contact:\n"
    "  tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]\n"
    "  working_force_n: 2\n"
    "haptic: {between_steps: local, rate_hz: 1000, max_force_n: 8, coupling: "
    "{stiffness_n_per_m: 800, damping_n_s_per_m: 2}}\n";

static softsim_status run_session(ss_paper *paper, session *s, softsim_error *error)
{
    ss_output csv;
    const ss_trial_plan plan = {.body = &s->body,
                                .fixed = "[{sphere: {center_m: [0, -0.017, 0], radius_m: 0.015}}]",
                                .model = kidney_model,
                                .rest = kidney_rest};
    softsim_status status = ss_trial_begin(paper, &plan, &s->trial, error);
    if (status != SOFTSIM_OK || s->trial.world == NULL) {
        ss_paper_miss(paper, s->trial.reason, "Figs. 12, 13: the kidney");
        return status;
    }
    status = ss_paper_csv_open(paper, &csv, "fig13-force",
                               "time_s,tool_x_m,tool_height_m,fx_n,fy_n,fz_n,depth_m,elastic_j,"
                               "grasp",
                               error);
    if (status == SOFTSIM_OK) {
        status = play(s, paper, csv.file, error);
        if (status != SOFTSIM_OK) {
            ss_output_abandon(&csv);
            return status;
        }
        status = ss_paper_csv_close(paper, &csv, "fig13-force", error);
    }
    if (status == SOFTSIM_OK) {
        kidney_claims(paper, s);
        status = plot_forces(paper, error);
    }
    for (int p = 0; status == SOFTSIM_OK && p < PHASES; ++p) {
        status = draw_phase(paper, s, p, error);
    }
    return status;
}

softsim_status ss_zhong_kidney(ss_paper *paper, softsim_error *error)
{
    session s = {.body = {.node_count = 0}};
    char reason[256];
    ss_page_text(&paper->page,
                 "The paper: a haptic device moves a virtual probe; a human kidney is pushed, "
                 "pulled and dragged with force feedback. Here: the bundled kidney of %d points, "
                 "110 x 59 x 45 mm, held at its hilum, under a ball of 5 mm: 1000 poses a second "
                 "through the daemon's own checks, contact and haptic tick (in place of the "
                 "PHANToM a recorded path; with a device attached the same code runs). In the blue "
                 "stripes the probe grasps.",
                 KIDNEY_POINTS);
    softsim_status status =
        ss_trial_generate(paper, "kidney.obj", "kidney", KIDNEY_POINTS, NULL, error);
    if (status == SOFTSIM_OK) {
        status = ss_trial_look(paper, "  mesh: kidney.obj\n  units: mm\n", &s.body, reason, error);
    }
    if (status == SOFTSIM_OK && s.body.node_count == 0) {
        ss_paper_miss(paper, reason, "Figs. 12, 13: the kidney");
    } else if (status == SOFTSIM_OK) {
        status = run_session(paper, &s, error);
    }
    ss_trial_end(&s.trial);
    ss_trial_body_fini(&s.body);
    for (int p = 0; p < PHASES; ++p) {
        free(s.shape[p]);
    }
    return status;
}

/* ---- Table 1 ---- */

static const struct rate {
    int32_t points;
    double paper_hz;
} rates[] = {{422, 285.7}, {602, 142.8}, {814, 83.3}, {1058, 45.5}, {1192, 25.6}};
enum { RATE_COUNT = sizeof rates / sizeof rates[0] };

static softsim_status measure_rates(ss_paper *paper, double out_hz[RATE_COUNT],
                                    softsim_error *error)
{
    ss_body body;
    softsim_status status = ss_body_open(&body, error);
    for (int k = 0; status == SOFTSIM_OK && k < RATE_COUNT; ++k) {
        ss_body_run run = {.nodes = 0};
        status = ss_body_make(&body, rates[k].points, error);
        if (status == SOFTSIM_OK) {
            status = ss_body_load(&body, &run, error);
        }
        if (status == SOFTSIM_OK && run.is_refused) {
            ss_paper_miss(paper, run.reason, "Table 1, %d points", rates[k].points);
        }
        out_hz[k] = run.is_refused ? (double)NAN : 1e6 / ss_samples_quantile(&run.tick_us, 0.5);
        ss_body_run_fini(&run);
        ss_paper_progress(paper, (double)(k + 1) / RATE_COUNT);
    }
    ss_body_close(&body);
    return status;
}

softsim_status ss_zhong_rates(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"points", "paper, Hz", "here, Hz", "ratio"};
    double hz[RATE_COUNT];
    ss_output csv;
    ss_page_text(&paper->page,
                 "The paper: a refresh rate for each number of points on a Pentium 4 of 2.8 GHz, "
                 "drawing included; at least 25 Hz for up to about 1200 points; the force at 1000 "
                 "Hz comes from extrapolation. Here: thread time of a whole tick of 1 ms (model, "
                 "contact, haptic) on one core, an ellipsoid with one loaded point, as a rate: "
                 "nothing is extrapolated and nothing is drawn.");
    softsim_status status = measure_rates(paper, hz, error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_open(paper, &csv, "table1", "points,paper_hz,here_hz", error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_table_begin(&paper->page, 4, head);
    for (int k = 0; k < RATE_COUNT; ++k) {
        ss_row row = {.count = 0};
        fprintf(csv.file, "%d,%g,%.6g\n", rates[k].points, rates[k].paper_hz, hz[k]);
        ss_row_add(&row, "%d", rates[k].points);
        ss_row_add(&row, "%g", rates[k].paper_hz);
        ss_row_add_number(&row, hz[k]);
        ss_row_add_number(&row, hz[k] / rates[k].paper_hz);
        ss_page_table_row(&paper->page, row.count, row.cell);
        if (!isnan(hz[k])) {
            ss_claim_at_least(paper, "Table 1", SS_FROM_PAPER, rates[k].paper_hz, hz[k],
                              "%d points: at least the paper's rate, Hz", rates[k].points);
            ss_claim_at_least(paper, "Table 1", SS_FROM_PAPER, 1000.0, hz[k],
                              "%d points: haptic rate without extrapolation, Hz", rates[k].points);
        }
    }
    ss_page_table_end(&paper->page);
    if (!isnan(hz[0]) && !isnan(hz[RATE_COUNT - 1])) {
        ss_claim_at_least(paper, "Table 1", SS_FROM_PAPER, 1.0, hz[0] / hz[RATE_COUNT - 1],
                          "the time grows with the number of points (422 points over 1192, rates)");
    }
    return ss_paper_csv_close(paper, &csv, "table1", error);
}
