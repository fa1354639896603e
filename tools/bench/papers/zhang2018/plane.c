/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The plane of 21 x 21 nodes: its shape beside traditional ChainMail's (Fig. 4), force against
 * displacement (Fig. 5a) and stress relaxation (Fig. 5c). The paper's figures have no numbers and
 * it gives no protocol; those used here are stated with each claim, and the numbers expected are
 * those of the report's reference network (reference.h) on the same protocol.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/surface_picture.h"
#include "bench/papers/zhang2018/zhang2018.h"
#include "rt/vec.h"

#define SLACK "alpha=0.02"
static const double depth_h = 5.0, pace = 0.25; /* h, h/C */
static const double step_c = 0.25; /* C: half the largest stable one, and a whole number to 5 h */
static const double settled_c = 20000.0; /* C: what is left then is below 1e-3 */
static const double threshold_h = 2.01;  /* R sqrt((1 + alpha)^2 - 1), R = 10 h */

static ss_zhang_setup network_setup(ss_zhang *zhang)
{
    ss_zhang_setup setup = ss_zhang_plane_setup(&zhang->plane, "cnn-chainmail", depth_h, step_c);
    const char *const param[] = {SLACK, "link_stiffness_n_per_m=1", "capacitance_s=1"};
    memcpy(setup.param, param, sizeof param);
    return setup;
}

/* ---- Fig. 4: shapes ---- */

enum { NETWORK, FAST, SETTLED, BOX, RADIAL, SHAPE_COUNT };
static const struct {
    const char *name, *title;
} shapes[SHAPE_COUNT] = {
    [NETWORK] = {"network", "the network, reached at 0.01 h/C"},
    [FAST] = {"network-fast", "the network, reached at 1 h/C, held for 20 C"},
    [SETTLED] = {"settled", "the network reached at 0.01 h/C, held for 20000 C"},
    [BOX] = {"chainmail", "traditional ChainMail, a box a link (beta 0.5)"},
    [RADIAL] = {"chainmail-radial", "ChainMail, a band along the link as in the network"},
};

typedef double plane_field[SS_PLANE_NODES][3];

/* Largest distance of the profile through the middle from the straight line between the rim and
 * the pushed node, over the depth. */
static double bend(const ss_zhang *zhang, const plane_field u)
{
    const int32_t first = SS_PLANE_SIDE / 2 * SS_PLANE_SIDE;
    double most = 0.0;
    for (int32_t k = 0; k < SS_PLANE_SIDE; ++k) {
        const double x = zhang->plane.mesh->position[first + k][0];
        const double chord = -depth_h * (1.0 - fabs(x) / (0.5 * (SS_PLANE_SIDE - 1)));
        most = fmax(most, fabs(u[first + k][2] - chord));
    }
    return most / depth_h;
}

static softsim_status run_chainmail(ss_zhang *zhang, const char *band, plane_field out_u,
                                    char out_reason[256], softsim_error *error)
{
    ss_zhang_run run;
    ss_zhang_setup setup = ss_zhang_plane_setup(&zhang->plane, "chainmail", depth_h, step_c);
    const char *const param[] = {SLACK, band, "beta=0.5"};
    memcpy(setup.param, param, sizeof param);
    setup.step_s = 1.0;
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    snprintf(out_reason, 256, "%s", run.reason);
    if (run.model != NULL && status == SOFTSIM_OK) {
        status = ss_zhang_go(&run, depth_h, pace, error);
        ss_zhang_read(&run, out_u);
    }
    ss_zhang_end(&run);
    return status;
}

/* The protocols of the network's shapes. */
static const struct protocol {
    double pace, hold_s; /* h/C, C */
} protocols[SETTLED + 1] = {[NETWORK] = {0.01, 0.0}, [FAST] = {1.0, 20.0}, [SETTLED] = {0.01, 2e4}};

/* u: of the model, and of the report's reference network. */
static softsim_status run_network(ss_zhang *zhang, int which, plane_field out_u,
                                  plane_field out_reference, char out_reason[256],
                                  softsim_error *error)
{
    const struct protocol *at = &protocols[which];
    ss_zhang_run run;
    ss_zhang_reference reference;
    const ss_zhang_setup setup = network_setup(zhang);
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    snprintf(out_reason, 256, "%s", run.reason);
    if (run.model != NULL && status == SOFTSIM_OK) {
        status = ss_zhang_go(&run, depth_h, at->pace, error);
        if (status == SOFTSIM_OK) {
            status = ss_zhang_hold(&run, at->hold_s, error);
        }
        ss_zhang_read(&run, out_u);
    }
    ss_zhang_end(&run);
    if (status == SOFTSIM_OK) {
        status =
            ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    }
    if (status == SOFTSIM_OK) {
        ss_zhang_reference_go(&reference, depth_h, at->pace, step_c);
        ss_zhang_reference_hold(&reference, at->hold_s, step_c);
        for (int32_t i = 0; i < SS_PLANE_NODES; ++i) {
            ss_sub3(out_reference[i], reference.at[i], reference.rest[i]);
        }
        ss_zhang_reference_fini(&reference);
    }
    return status;
}

static softsim_status write_profiles(ss_zhang *zhang, const plane_field *u, const bool *is_there,
                                     softsim_error *error)
{
    ss_output csv, script;
    softsim_status status =
        ss_paper_csv_open(zhang->paper, &csv, "fig4-profile",
                          "x_m,network_m,network_fast_m,settled_m,chainmail_m,radial_m", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const int32_t first = SS_PLANE_SIDE / 2 * SS_PLANE_SIDE;
    for (int32_t k = 0; k < SS_PLANE_SIDE; ++k) {
        fprintf(csv.file, "%.6g", zhang->plane.mesh->position[first + k][0]);
        for (int s = 0; s < SHAPE_COUNT; ++s) {
            if (is_there[s]) {
                fprintf(csv.file, ",%.6g", u[s][first + k][2]);
            } else {
                fputc(',', csv.file);
            }
        }
        fputc('\n', csv.file);
    }
    status = ss_paper_csv_close(zhang->paper, &csv, "fig4-profile", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open_sized(&script, zhang->paper->folder, "fig4-profile", 800, 560, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_plot_key_below(script.file, SHAPE_COUNT + 1);
    fprintf(script.file, "set datafile separator ','\nset grid\nset xlabel 'x, h'\n"
                         "set ylabel 'z, h'\nset yrange [-5.3:0.3]\nplot ");
    for (int s = 0; s < SHAPE_COUNT; ++s) {
        if (is_there[s]) {
            fprintf(script.file,
                    "'fig4-profile.csv' skip 1 using 1:%d with linespoints lw 2 pt %d title '%s', ",
                    s + 2, s + 4, shapes[s].title);
        }
    }
    fprintf(script.file, "-5*(1-abs(x)/10) with lines dt 3 lc rgb 'black' title 'straight'\n");
    return ss_page_plot(&zhang->paper->page, &script, "fig4-profile",
                        "Fig. 4: the line of nodes through the middle, 5 h deep.", error);
}

static softsim_status draw_plane(ss_zhang *zhang, double (*u)[3], int which, softsim_error *error)
{
    static const ss_surface_picture_view view = {{-0.35, -1.0, 0.55}, {0.0, 0.0, 1.0}, ""};
    char name[48], caption[160];
    const ss_mesh *mesh = zhang->plane.mesh;
    const ss_surface_picture shape = {.node_count = mesh->node_count,
                                      .face_count = mesh->quad_count,
                                      .rest = (const double(*)[3])mesh->position,
                                      .u = (const double(*)[3])u,
                                      .face = (const int32_t(*)[4])mesh->quad,
                                      .pushed = SS_PLANE_MIDDLE,
                                      .push = {0.0, 0.0, -1.0}};
    snprintf(name, sizeof name, "fig4-%s", shapes[which].name);
    snprintf(caption, sizeof caption, "Fig. 4: the plane pushed 5 h: %s.", shapes[which].title);
    return ss_surface_picture_draw(zhang->paper, name, caption, &shape, &view, 1, error);
}

static void claim_shapes(ss_zhang *zhang, const plane_field *u, const plane_field *reference,
                         const bool *is_there)
{
    ss_paper *paper = zhang->paper;
    for (int s = NETWORK; s <= SETTLED && is_there[s]; ++s) {
        ss_claim_near(paper, "Fig. 4", SS_FROM_CODE, bend(zhang, reference[s]), bend(zhang, u[s]),
                      SS_CODE_TOLERANCE,
                      "%s: the profile's largest distance from the straight line between the rim "
                      "and the contact, over the depth",
                      shapes[s].title);
        ss_claim_at_least(paper, "Fig. 4", SS_FROM_PAPER, 0.05, bend(zhang, u[s]),
                          "%s: the deformation is nonlinear: the same distance", shapes[s].title);
    }
    if (is_there[BOX]) {
        ss_claim_at_most(paper, "Fig. 4", SS_FROM_PAPER, 0.005, bend(zhang, u[BOX]),
                         "traditional ChainMail (a box a link): a linear deformation of pyramid "
                         "shape: the same distance");
    }
    if (is_there[RADIAL]) {
        double row[SS_PLANE_SIDE / 2 + 1][2], most = 0.0;
        const int32_t first = SS_PLANE_MIDDLE;
        ss_zhang_reference_row(SS_PLANE_SIDE / 2 + 1, 0.02, depth_h, (int32_t)(depth_h / pace),
                               row);
        for (int32_t k = 0; k <= SS_PLANE_SIDE / 2; ++k) {
            most = fmax(most, fabs(-row[k][1] - u[RADIAL][first + k][2]));
        }
        ss_claim_at_most(paper, "Fig. 4", SS_FROM_CODE, 1e-4, most,
                         "ChainMail with the network's own band, pushed by %g h a step: distance "
                         "of its profile from a single row's by an independent program, h",
                         pace);
        ss_page_text(&paper->page,
                     "With the network's own band along the link in place of a box, ChainMail too "
                     "leaves the straight line, by %.3f of the depth: part of the difference in "
                     "the figure is the band, not the dynamics.",
                     bend(zhang, u[RADIAL]));
    }
}

softsim_status ss_zhang_shapes(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    static plane_field u[SHAPE_COUNT], reference[SETTLED + 1];
    bool is_there[SHAPE_COUNT];
    softsim_status status = SOFTSIM_OK;
    ss_page_text(&paper->page,
                 "The paper: a plane of 21 x 21 nodes pushed at its middle bends smoothly by the "
                 "network and is a pyramid by ChainMail. It does not say how far, how fast, nor "
                 "when the picture was taken. Here: alpha 0.02, rim fixed, depth 5 h, at three "
                 "protocols, since what the network looks like depends on them: at a finite speed "
                 "the links' drag bends it; at rest only what exceeds the threshold of %.3g h "
                 "does.",
                 threshold_h);
    for (int s = 0; s < SHAPE_COUNT && status == SOFTSIM_OK; ++s) {
        char reason[256];
        status = s <= SETTLED ? run_network(zhang, s, u[s], reference[s], reason, error)
                              : run_chainmail(zhang, s == BOX ? "band=box" : "band=radial", u[s],
                                              reason, error);
        is_there[s] = reason[0] == '\0';
        if (!is_there[s]) {
            ss_paper_miss(paper, reason, "the plane's shape: %s", shapes[s].title);
        } else if (status == SOFTSIM_OK) {
            status = draw_plane(zhang, u[s], s, error);
        }
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    claim_shapes(zhang, (const plane_field *)u, (const plane_field *)reference, is_there);
    return write_profiles(zhang, (const plane_field *)u, is_there, error);
}

/* ---- Fig. 5a: force and displacement ---- */

enum { SPEED_COUNT = 3, STATIC_COUNT = 8, MAX_ROWS = 2048 };
static const double speeds[SPEED_COUNT] = {1.0, 0.25, 0.01}; /* h/C */
static const double static_depth[STATIC_COUNT] = {1.0, 1.9, 2.1, 2.5, 3.0, 3.5, 4.0, 5.0};

typedef struct force_curve {
    int32_t count;
    double depth[MAX_ROWS], force[MAX_ROWS];
} force_curve;

/* Slope of log F over log d by least squares, over the last three quarters of the depth: at first a
 * single link answers. */
static double exponent(const force_curve *c)
{
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (int32_t k = 0; k < c->count; ++k) {
        if (c->depth[k] >= 0.25 * depth_h && c->force[k] > 0.0) {
            const double x = log(c->depth[k]), y = log(c->force[k]);
            n += 1.0;
            sx += x;
            sy += y;
            sxx += x * x;
            sxy += x * y;
        }
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

static softsim_status press(ss_zhang *zhang, double speed, force_curve *out,
                            force_curve *out_reference, softsim_error *error)
{
    ss_zhang_run run;
    const ss_zhang_setup setup = network_setup(zhang);
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    out->count = 0;
    const int32_t steps =
        run.model != NULL ? (int32_t)ceil(depth_h / (speed * run.step_s) - 1e-9) : 0;
    for (int32_t k = 1; k <= steps && status == SOFTSIM_OK && out->count < MAX_ROWS; ++k) {
        ss_zhang_step(&run, fmin(k * speed * run.step_s, depth_h));
        out->depth[out->count] = run.depth;
        out->force[out->count++] = ss_zhang_force(&run);
    }
    ss_zhang_end(&run);
    ss_zhang_reference reference;
    if (status == SOFTSIM_OK) {
        status =
            ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    }
    if (status == SOFTSIM_OK) {
        out_reference->count = out->count;
        for (int32_t k = 0; k < out->count; ++k) {
            ss_zhang_reference_step(&reference, out->depth[k], step_c);
            out_reference->depth[k] = out->depth[k];
            out_reference->force[k] = reference.force;
        }
        ss_zhang_reference_fini(&reference);
    }
    return status;
}

/* The force at rest, by the reference network's other algorithm. */
static softsim_status settle_reference(ss_zhang *zhang, double depth, double *out_force,
                                       softsim_error *error)
{
    ss_zhang_reference reference;
    const softsim_status status =
        ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    *out_force = (double)NAN;
    if (status == SOFTSIM_OK) {
        ss_zhang_reference_go(&reference, depth, pace, step_c);
        *out_force = ss_zhang_reference_settle(&reference, 1e-9) ? reference.force : (double)NAN;
        ss_zhang_reference_fini(&reference);
    }
    return status;
}

/* The same way as press_slowly by the reference network. */
static softsim_status press_slowly_reference(ss_zhang *zhang, double out_force[STATIC_COUNT],
                                             softsim_error *error)
{
    ss_zhang_reference reference;
    const softsim_status status =
        ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    for (int k = 0; k < STATIC_COUNT && status == SOFTSIM_OK; ++k) {
        ss_zhang_reference_go(&reference, static_depth[k], pace, step_c);
        ss_zhang_reference_hold(&reference, settled_c, step_c);
        out_force[k] = reference.force;
    }
    if (status == SOFTSIM_OK) {
        ss_zhang_reference_fini(&reference);
    }
    return status;
}

static softsim_status press_slowly(ss_zhang *zhang, force_curve *out, softsim_error *error)
{
    ss_zhang_run run;
    const ss_zhang_setup setup = network_setup(zhang);
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    out->count = 0;
    for (int k = 0; k < STATIC_COUNT && run.model != NULL && status == SOFTSIM_OK; ++k) {
        status = ss_zhang_go(&run, static_depth[k], pace, error);
        if (status == SOFTSIM_OK) {
            status = ss_zhang_hold(&run, settled_c, error);
        }
        out->depth[out->count] = run.depth;
        out->force[out->count++] = ss_zhang_force(&run);
    }
    ss_zhang_end(&run);
    return status;
}

static softsim_status write_forces(ss_zhang *zhang, const force_curve *curve, softsim_error *error)
{
    static const char *const title[] = {"1 h/C", "0.25 h/C", "0.01 h/C", "settled"};
    ss_output csv, script;
    softsim_status status =
        ss_paper_csv_open(zhang->paper, &csv, "fig5a", "speed,depth_m,force_n", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int c = 0; c <= SPEED_COUNT; ++c) {
        for (int32_t k = 0; k < curve[c].count; ++k) {
            fprintf(csv.file, "%g,%.6g,%.6g\n", c < SPEED_COUNT ? speeds[c] : 0.0,
                    curve[c].depth[k], curve[c].force[k]);
        }
    }
    status = ss_paper_csv_close(zhang->paper, &csv, "fig5a", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, zhang->paper->folder, "fig5a", error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file, "set datafile separator ','\nset grid\nset key top left\n"
                         "set xlabel 'displacement, h'\nset ylabel 'force, N'\nplot ");
    for (int c = 0; c <= SPEED_COUNT; ++c) {
        fprintf(script.file,
                "%s'fig5a.csv' skip 1 using ($1==%g ? $2 : NaN):3 with %s lw 2 title '%s'",
                c > 0 ? ", " : "", c < SPEED_COUNT ? speeds[c] : 0.0,
                c < SPEED_COUNT ? "lines" : "linespoints", title[c]);
    }
    fputc('\n', script.file);
    return ss_page_plot(&zhang->paper->page, &script, "fig5a",
                        "Fig. 5a: force at the contact against its displacement, by speed.", error);
}

softsim_status ss_zhang_forces(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    static force_curve curve[SPEED_COUNT + 1], reference[SPEED_COUNT];
    ss_page_text(&paper->page,
                 "The paper: the force grows faster than the displacement. What it grows like "
                 "depends on the speed, since the network's resistance is partly drag: at 1 h/C it "
                 "is nearly proportional, slowly it is the geometry of slack links.");
    softsim_status status = SOFTSIM_OK;
    for (int c = 0; c < SPEED_COUNT && status == SOFTSIM_OK; ++c) {
        status = press(zhang, speeds[c], &curve[c], &reference[c], error);
        ss_paper_progress(paper, 0.2 * (c + 1));
    }
    if (status == SOFTSIM_OK) {
        status = press_slowly(zhang, &curve[SPEED_COUNT], error);
    }
    const force_curve *still = &curve[SPEED_COUNT];
    if (status != SOFTSIM_OK || still->count == 0) {
        return status;
    }
    for (int c = 0; c < SPEED_COUNT; ++c) {
        ss_claim_near(paper, "Fig. 5a", SS_FROM_CODE, exponent(&reference[c]), exponent(&curve[c]),
                      SS_CODE_TOLERANCE,
                      "force grows as displacement to the power, pushed at %g h/C", speeds[c]);
        ss_claim_at_least(paper, "Fig. 5a", SS_FROM_PAPER, 1.1, exponent(&curve[c]),
                          "a nonlinear relationship: the same power, at %g h/C", speeds[c]);
    }
    ss_claim_at_most(
        paper, "Fig. 5a", SS_FROM_CLOSED_FORM, 1e-3, still->force[1],
        "settled for %g C: no force up to R sqrt((1 + alpha)^2 - 1) = %.3g h: force at "
        "1.9 h, N",
        settled_c, threshold_h);
    double reference_still[STATIC_COUNT];
    status = press_slowly_reference(zhang, reference_still, error);
    for (int k = 4; k < STATIC_COUNT && status == SOFTSIM_OK; ++k) {
        double rest;
        ss_claim_near(paper, "Fig. 5a", SS_FROM_CODE, reference_still[k], still->force[k],
                      SS_CODE_TOLERANCE, "settled for %g C: force at %g h, N", settled_c,
                      static_depth[k]);
        status = settle_reference(zhang, static_depth[k], &rest, error);
        ss_page_text(&paper->page, "The equilibrium at %g h by the reference network: %.4g N.",
                     static_depth[k], rest);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    return write_forces(zhang, curve, error);
}

/* ---- Fig. 5c: relaxation ---- */

enum { MARK_COUNT = 4, RELAX_ROWS = 400 };
static const double mark_s[MARK_COUNT] = {10.0, 100.0, 1000.0, 20000.0};

typedef struct relaxation {
    double peak, slow_peak, mark[MARK_COUNT], largest_rise;
    double reference_peak, reference_slow_peak, reference_mark[MARK_COUNT];
    int32_t count;
    double time[RELAX_ROWS], force[RELAX_ROWS];
} relaxation;

/* Holds, sampling at equal steps of log time. */
static softsim_status relax(ss_zhang *zhang, relaxation *out, softsim_error *error)
{
    ss_zhang_run run;
    const ss_zhang_setup setup = network_setup(zhang);
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    *out = (relaxation){.count = 0};
    if (status == SOFTSIM_OK && run.model != NULL) {
        status = ss_zhang_go(&run, depth_h, 1.0, error);
        out->peak = ss_zhang_force(&run);
    }
    double last = out->peak, time = 0.0, next = 0.0;
    for (int m = 0; status == SOFTSIM_OK && run.model != NULL && m < MARK_COUNT;) {
        ss_zhang_step(&run, depth_h);
        time += run.step_s;
        const double force = ss_zhang_force(&run);
        out->largest_rise = fmax(out->largest_rise, force - last);
        last = force;
        if (time >= next && out->count < RELAX_ROWS) {
            out->time[out->count] = time;
            out->force[out->count++] = force;
            next = 1.04 * time;
        }
        if (time >= mark_s[m]) {
            out->mark[m++] = force;
        }
    }
    ss_zhang_end(&run);
    if (status == SOFTSIM_OK) {
        status = ss_zhang_begin(&setup, &run, error);
    }
    if (status == SOFTSIM_OK && run.model != NULL) {
        status = ss_zhang_go(&run, depth_h, pace, error);
        out->slow_peak = ss_zhang_force(&run);
    }
    ss_zhang_end(&run);
    return status;
}

static softsim_status relax_reference(ss_zhang *zhang, relaxation *out, softsim_error *error)
{
    ss_zhang_reference reference;
    softsim_status status =
        ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_zhang_reference_go(&reference, depth_h, 1.0, step_c);
    out->reference_peak = reference.force;
    for (int m = 0; m < MARK_COUNT; ++m) {
        ss_zhang_reference_hold(&reference, mark_s[m] - (m > 0 ? mark_s[m - 1] : 0.0), step_c);
        out->reference_mark[m] = reference.force;
    }
    ss_zhang_reference_fini(&reference);
    status = ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, NULL, &reference, error);
    if (status == SOFTSIM_OK) {
        ss_zhang_reference_go(&reference, depth_h, pace, step_c);
        out->reference_slow_peak = reference.force;
        ss_zhang_reference_fini(&reference);
    }
    return status;
}

static softsim_status write_relaxation(ss_zhang *zhang, const relaxation *r, double rest,
                                       softsim_error *error)
{
    ss_output csv, script;
    softsim_status status = ss_paper_csv_open(zhang->paper, &csv, "fig5c", "time_s,force_n", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t k = 0; k < r->count; ++k) {
        fprintf(csv.file, "%.6g,%.6g\n", r->time[k], r->force[k]);
    }
    status = ss_paper_csv_close(zhang->paper, &csv, "fig5c", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, zhang->paper->folder, "fig5c", error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset grid\nset key top right\n"
            "set logscale x\nset xlabel 'time held, C'\nset ylabel 'force, N'\n"
            "set yrange [0:*]\n"
            "plot 'fig5c.csv' skip 1 with lines lw 2 title 'force, 5 h deep', "
            "%.6g with lines dt 2 lc rgb 'black' title 'equilibrium'\n",
            rest);
    return ss_page_plot(&zhang->paper->page, &script, "fig5c",
                        "Fig. 5c: force while the contact is held 5 h deep.", error);
}

softsim_status ss_zhang_relaxation(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    static relaxation r;
    ss_page_text(&paper->page,
                 "The paper: under a constant displacement the force falls asymptotically towards "
                 "a minimum. Here: 5 h, reached at 1 h/C, then held.");
    softsim_status status = relax(zhang, &r, error);
    if (status == SOFTSIM_OK) {
        status = relax_reference(zhang, &r, error);
    }
    double rest = (double)NAN;
    if (status == SOFTSIM_OK) {
        status = settle_reference(zhang, depth_h, &rest, error);
    }
    if (status != SOFTSIM_OK || r.count == 0) {
        return status;
    }
    ss_claim_near(paper, "Fig. 5c", SS_FROM_CODE, r.reference_peak, r.peak, SS_CODE_TOLERANCE,
                  "force as 5 h is reached at 1 h/C, N");
    ss_claim_near(paper, "Fig. 5c", SS_FROM_CODE, r.reference_slow_peak, r.slow_peak,
                  SS_CODE_TOLERANCE, "force as 5 h is reached at 0.25 h/C, N");
    for (int m = 0; m < MARK_COUNT; ++m) {
        ss_claim_near(paper, "Fig. 5c", SS_FROM_CODE, r.reference_mark[m], r.mark[m],
                      SS_CODE_TOLERANCE, "force after %g C, N", mark_s[m]);
    }
    ss_claim_near(paper, "Fig. 5c", SS_FROM_CODE, rest, r.mark[MARK_COUNT - 1], 5e-3,
                  "the minimum that it falls to is the equilibrium's: force after %g C, N",
                  mark_s[MARK_COUNT - 1]);
    ss_claim_at_most(paper, "Fig. 5c", SS_FROM_PAPER, 1e-5, r.largest_rise / r.peak,
                     "the force decreases all the time: its largest rise in a step over the peak");
    return write_relaxation(zhang, &r, rest, error);
}
