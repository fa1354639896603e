/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The second of the paper's two wishes for the future: material parameters by optimisation.
 * Curves are made by the report's reference network (reference.h, steps of a fiftieth of C) with
 * known parameters and 1 % of noise; softsim-fit's own search is given the curves and wrong
 * parameters: with a toe, without one, and held. How near it can come is known beforehand: with J
 * the change of a curve with the logarithm of a parameter, in shares of its rms, the standard error
 * of the logarithm is the noise times the root of the diagonal of (J^T J)^-1, by the reference
 * network too.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhang2018/zhang2018.h"
#include "bench/papers/zhong2006/net.h"
#include "fit.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

enum { POINTS = 14, MOST = 3 };
static const double press_s = 0.5, deep_m = 0.03, hold_s = 0.6;
static const char plate_scene[] =
    "softsim: 1\n"
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
    "simulation: {rate_hz: 1000, sleep: off}\n"
    "publish: {mesh_rate_hz: 0}\n";

/* Parameters in the order of the scene: truth of a curve. */
static const char *const path[MOST] = {"model.link_stiffness_n_per_m", "model.alpha",
                                       "model.capacitance_s"};

enum { SIDE = 15, NODES = SIDE * SIDE, CURVES = 2 };
static const double noise = 0.01, width_m = 0.14;

/* The plate as the reference network has it. */
typedef struct plate_body {
    ss_mesh *mesh;
    uint8_t fixed[NODES];
    int32_t patch[NODES];
    int32_t patch_count;
    double direction[3];
} plate_body;

/* The patch that softsim-fit presses, from the numbers of its scene. */
static softsim_status make_plate(const ss_press *press, plate_body *out, softsim_error *error)
{
    *out = (plate_body){.mesh = NULL};
    const softsim_status status =
        ss_mesh_create_plane(SIDE, SIDE, width_m, width_m, &out->mesh, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < NODES; ++i) {
        const double *x = out->mesh->position[i];
        out->fixed[i] = fmax(fabs(x[0]), fabs(x[1])) > 0.5 * width_m - 1e-4;
    }
    const char *at = strstr(press->patch, "nodes: [");
    at = at != NULL ? at + strlen("nodes: [") : "]";
    for (char *end; *at != ']' && out->patch_count < NODES; at = end + strspn(end, ", ")) {
        out->patch[out->patch_count++] = (int32_t)strtol(at, &end, 10);
    }
    ss_scale3(out->direction, press->normal, -1.0);
    return SOFTSIM_OK;
}

/* Forces of the reference network at the points of a curve. */
static bool reference_curve(const plate_body *plate, const double parameter[MOST], bool is_time,
                            double *force)
{
    ss_zhang_reference reference;
    ss_zhang_reference_plan plan =
        ss_zhang_reference_on(plate->mesh, plate->fixed, plate->patch, plate->patch_count);
    plan.stiffness = parameter[0];
    plan.alpha = parameter[1];
    plan.capacitance = parameter[2];
    ss_copy3(plan.direction, plate->direction);
    if (!ss_zhang_reference_init(&reference, &plan)) {
        return false;
    }
    const double h = 0.02 * 0.01; /* s: a fiftieth of the least C */
    const double speed = deep_m / press_s;
    if (is_time) {
        ss_zhang_reference_go(&reference, deep_m, speed, h);
    }
    for (int k = 0; k < POINTS; ++k) {
        if (is_time) {
            ss_zhang_reference_hold(&reference, k > 0 ? hold_s / (POINTS - 1) : 0.0, h);
        } else {
            ss_zhang_reference_go(&reference, deep_m * (k + 1) / POINTS, speed, h);
        }
        force[k] = reference.force;
    }
    ss_zhang_reference_fini(&reference);
    return true;
}

static double rms(const double *force)
{
    double sum = 0.0;
    for (int k = 0; k < POINTS; ++k) {
        sum += force[k] * force[k] / POINTS;
    }
    return sqrt(sum);
}

/* About normal, of standard deviation 1; the same at every run. */
static double draw_noise(uint64_t *state)
{
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) {
        sum += ss_random_unit(state);
    }
    return sum;
}

/* A curve with the parameters `truth` and noise. */
static softsim_status make_curve(const plate_body *plate, const double truth[MOST], bool is_time,
                                 uint64_t *state, ss_curve *curve, softsim_error *error)
{
    *curve = (ss_curve){.path = is_time ? "held" : "pressed", .is_time = is_time, .count = POINTS};
    curve->at = calloc(POINTS, sizeof *curve->at);
    curve->force = calloc(POINTS, sizeof *curve->force);
    if (curve->at == NULL || curve->force == NULL ||
        !reference_curve(plate, truth, is_time, curve->force)) {
        return ss_memory_fault(error);
    }
    const double scale = noise * rms(curve->force);
    for (int k = 0; k < POINTS; ++k) {
        curve->at[k] = is_time ? hold_s * k / (POINTS - 1) : deep_m * (k + 1) / POINTS;
        curve->force[k] += scale * draw_noise(state);
    }
    curve->rms = rms(curve->force);
    return SOFTSIM_OK;
}

/* Standard errors of the logarithms of the first `count` parameters. */
static bool find_errors(const plate_body *plate, const double truth[MOST], int count, int curves,
                        double out[MOST])
{
    static const double change = 1e-3;
    double base[CURVES][POINTS], moved[POINTS], slope[MOST][CURVES][POINTS], square[MOST * MOST];
    double inverse[MOST * MOST] = {0.0};
    for (int c = 0; c < curves; ++c) {
        if (!reference_curve(plate, truth, c == 1, base[c])) {
            return false;
        }
        for (int p = 0; p < count; ++p) {
            double parameter[MOST];
            memcpy(parameter, truth, sizeof parameter);
            parameter[p] *= 1.0 + change;
            if (!reference_curve(plate, parameter, c == 1, moved)) {
                return false;
            }
            for (int k = 0; k < POINTS; ++k) {
                slope[p][c][k] = (moved[k] - base[c][k]) / change / rms(base[c]);
            }
        }
    }
    for (int p = 0; p < count; ++p) {
        for (int q = 0; q < count; ++q) {
            double sum = p == q ? 1e-30 : 0.0;
            for (int c = 0; c < curves; ++c) {
                for (int k = 0; k < POINTS; ++k) {
                    sum += slope[p][c][k] * slope[q][c][k];
                }
            }
            square[p * count + q] = sum;
        }
        inverse[p * count + p] = 1.0;
    }
    if (!ss_zhong_cholesky(count, square, count, inverse)) {
        return false;
    }
    for (int p = 0; p < count; ++p) {
        out[p] = noise * sqrt(inverse[p * count + p]);
    }
    return true;
}

/* Fits the first `count` parameters to the curves of `truth`, pressed and, with three, held too. */
static softsim_status fit_to(const char *scene, const double truth[MOST], int count, ss_fit *fit,
                             double out_errors[MOST], softsim_error *error)
{
    const ss_press_scene made = {scene, NULL, 0};
    plate_body plate_of;
    uint64_t state = 1;
    *fit = (ss_fit){.scene = {scene, NULL, 0}, .max_evaluations = 200};
    fit->curve_count = count > 2 ? 2 : 1;
    softsim_status status = SOFTSIM_OK;
    for (int c = 0; c < fit->curve_count && status == SOFTSIM_OK; ++c) {
        status = ss_press_plan(&made, NULL, deep_m, press_s, &fit->press[c], error);
    }
    if (status == SOFTSIM_OK) {
        status = make_plate(&fit->press[0], &plate_of, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int c = 0; c < fit->curve_count && status == SOFTSIM_OK; ++c) {
        status = make_curve(&plate_of, truth, c == 1, &state, &fit->curve[c], error);
    }
    if (status == SOFTSIM_OK &&
        !find_errors(&plate_of, truth, count, fit->curve_count, out_errors)) {
        status = ss_memory_fault(error);
    }
    ss_mesh_destroy(&plate_of.mesh);
    if (status == SOFTSIM_OK) {
        fit->parameter_count =
            ss_fit_choose(scene, NULL, 0, path, count, count > 2, fit->parameter, error);
        status = fit->parameter_count == count ? ss_fit_run(fit, error) : SOFTSIM_ERROR_SCENE;
    }
    return status;
}

/* Within three standard errors of the truth. */
static void claim_found(ss_paper *paper, double truth, double found, double standard_error,
                        const char *what)
{
    ss_claim_near(paper, "Conclusion", SS_FROM_CODE, truth, found, 3.0 * standard_error,
                  "%s (within three standard errors)", what);
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
    fputs(plate_scene, output.file);
    status = ss_output_commit(&output, error);
    ss_page_text(&paper->page,
                 "The paper's second wish: material parameters found by optimisation. softsim-fit "
                 "is given curves that an independent program makes on a plate of 15 x 15 nodes "
                 "(k 40 N/m, alpha 0.05), with noise of 1 %% of their rms, and starts from k 100 "
                 "N/m and alpha 0.02. What the noise leaves open is computed from that program's "
                 "own sensitivities.");
    double errors[MOST];
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, with_toe, 2, &fit, errors, error);
    }
    if (status == SOFTSIM_OK) {
        claim_found(paper, 40.0, fit.value[0], errors[0],
                    "from force against depth with noise: link stiffness k, N/m");
        claim_found(paper, 0.05, fit.value[1], errors[1],
                    "from force against depth with noise: alpha, told by the toe");
    }
    ss_fit_fini(&fit);
    ss_paper_progress(paper, 0.3);
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, no_toe, 2, &fit, errors, error);
    }
    if (status == SOFTSIM_OK) {
        char expected[96];
        const bool is_open = errors[1] > log(2.0), is_told = fit.solve.spread[1] > log(2.0);
        snprintf(expected, sizeof expected, "%s",
                 is_open ? "told that it cannot be found" : "found");
        claim_found(paper, 40.0, fit.value[0], errors[0],
                    "from a noisy curve without a toe: k, N/m");
        ss_claim_add(paper, "Conclusion", SS_FROM_CODE,
                     is_told == is_open ? SS_CLAIM_PASS : SS_CLAIM_FAIL, expected,
                     is_told ? "told" : "not told", "from a noisy curve without a toe: alpha");
        ss_fit_tell(&fit, tell, &paper->page);
    }
    ss_fit_fini(&fit);
    ss_paper_progress(paper, 0.6);
    if (status == SOFTSIM_OK) {
        status = fit_to(scene, slow, MOST, &fit, errors, error);
    }
    if (status == SOFTSIM_OK) {
        claim_found(paper, 0.03, fit.value[2], errors[2],
                    "from the same and a relaxation, with noise: capacitance C, s");
    }
    ss_fit_fini(&fit);
    return status;
}
