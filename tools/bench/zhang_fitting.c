/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The second of the paper's two wishes for the future: material parameters by optimisation.
 * Curves are made by the network with known parameters, then softsim-fit's own search is given the
 * curves and wrong parameters: with a toe, without one, and held.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit.h"
#include "zhang.h"

enum { POINTS = 14, MOST = 3 };
static const double press_s = 0.5, deep_m = 0.03, hold_s = 0.6;
static const char plate[] = "softsim: 1\n"
                            "object:\n"
                            "  grid: {plane: {rows: 15, columns: 15, width_m: 0.14, height_m: "
                            "0.14}}\n"
                            "  fixed:\n"
                            "    - {box_m: [[-1, -1, -1], [-0.0699, 1, 1]]}\n"
                            "    - {box_m: [[0.0699, -1, -1], [1, 1, 1]]}\n"
                            "    - {box_m: [[-1, -1, -1], [1, -0.0699, 1]]}\n"
                            "    - {box_m: [[-1, 0.0699, -1], [1, 1, 1]]}\n"
                            "model:\n"
                            "  name: cnn-chainmail\n"
                            "  link_stiffness_n_per_m: 100\n"
                            "  alpha: 0.02\n"
                            "  capacitance_s: 0.01\n"
                            "simulation: {rate_hz: 200}\n"
                            "publish: {mesh_rate_hz: 0}\n";

/* Parameters in the order of the scene: truth of a curve. */
static const char *const path[MOST] = {"model.link_stiffness_n_per_m", "model.alpha",
                                       "model.capacitance_s"};

/* A curve of the network with the parameters `truth`. */
static softsim_status make_curve(const char *scene, const double truth[MOST], bool is_time,
                                 ss_curve *curve, ss_press *press, softsim_error *error)
{
    char set[MOST][96];
    const char *sets[MOST];
    for (int k = 0; k < MOST; ++k) {
        snprintf(set[k], sizeof set[k], "%s=%.17g", path[k], truth[k]);
        sets[k] = set[k];
    }
    const ss_press_scene made = {scene, sets, MOST};
    ss_press_run run;
    *curve = (ss_curve){.path = is_time ? "held" : "pressed", .is_time = is_time, .count = POINTS};
    curve->at = calloc(POINTS, sizeof *curve->at);
    curve->force = calloc(POINTS, sizeof *curve->force);
    if (curve->at == NULL || curve->force == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
        return SOFTSIM_ERROR_MEMORY;
    }
    double sum = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        curve->at[k] = is_time ? hold_s * k / (POINTS - 1) : deep_m * (k + 1) / POINTS;
    }
    softsim_status status = ss_press_plan(&made, NULL, deep_m, press_s, press, error);
    if (status == SOFTSIM_OK) {
        status = ss_press_measure(press, &made, curve, curve->force, &run, error);
    }
    for (int k = 0; k < POINTS; ++k) {
        sum += curve->force[k] * curve->force[k] / POINTS;
    }
    curve->rms = sqrt(sum);
    return status;
}

/* Fits the first `count` parameters to the curves of `truth`, pressed and, with three, held too. */
static softsim_status fit_to(const char *scene, const double truth[MOST], int count, ss_fit *fit,
                             softsim_error *error)
{
    *fit = (ss_fit){.scene = {scene, NULL, 0}, .max_evaluations = 200};
    fit->curve_count = count > 2 ? 2 : 1;
    softsim_status status = SOFTSIM_OK;
    for (int c = 0; c < fit->curve_count && status == SOFTSIM_OK; ++c) {
        status = make_curve(scene, truth, c == 1, &fit->curve[c], &fit->press[c], error);
    }
    if (status == SOFTSIM_OK) {
        fit->parameter_count =
            ss_fit_choose(scene, NULL, 0, path, count, count > 2, fit->parameter, error);
        status = fit->parameter_count == count ? ss_fit_run(fit, error) : SOFTSIM_ERROR_SCENE;
    }
    return status;
}

static void tell(void *sink, const char *text)
{
    ss_page_text(sink, "%s", text);
}

softsim_status ss_zhang_fitting(ss_paper *paper, softsim_error *error)
{
    static ss_fit fit; /* large */
    static const double with_toe[MOST] = {40.0, 0.05, 0.01}, no_toe[MOST] = {40.0, 1e-6, 0.01};
    static const double slow[MOST] = {40.0, 0.05, 0.03};
    char scene[sizeof paper->temporary + 16];
    ss_output output;
    snprintf(scene, sizeof scene, "%s/plate.yaml", paper->temporary);
    softsim_status status = ss_output_open(&output, scene, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs(plate, output.file);
    status = ss_output_commit(&output, error);
    ss_page_text(&paper->page,
                 "The paper's second wish: material parameters found by optimisation. softsim-fit "
                 "is given curves that the network itself makes on a plate of 15 x 15 nodes "
                 "(k 40 N/m, alpha 0.05) and starts from k 100 N/m and alpha 0.02.");
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, with_toe, 2, &fit, error);
    }
    if (status == SOFTSIM_OK) {
        ss_claim_near(paper, "Conclusion", 40.0, fit.value[0], 0.02,
                      "from force against depth: link stiffness k, N/m");
        ss_claim_near(paper, "Conclusion", 0.05, fit.value[1], 0.02,
                      "from force against depth: alpha, told by the toe");
    }
    ss_fit_fini(&fit);
    ss_paper_progress(paper, 0.3);
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, no_toe, 2, &fit, error);
    }
    if (status == SOFTSIM_OK) {
        ss_claim_near(paper, "Conclusion", 40.0, fit.value[0], 0.02,
                      "from a curve without a toe: k, N/m");
        ss_claim_add(
            paper, "Conclusion", fit.solve.spread[1] > log(2.0) ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
            "told that it cannot be found", fit.solve.spread[1] > log(2.0) ? "told" : "not told",
            "from a curve without a toe: alpha");
        ss_fit_tell(&fit, tell, &paper->page);
    }
    ss_fit_fini(&fit);
    ss_paper_progress(paper, 0.6);
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, slow, MOST, &fit, error);
    }
    if (status == SOFTSIM_OK) {
        ss_claim_near(paper, "Conclusion", 0.03, fit.value[2], 0.05,
                      "from the same and a relaxation: capacitance C, s");
    }
    ss_fit_fini(&fit);
    return status;
}
