/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Force and shape under a ball: the hybrid beside finite elements, a thin wall with more and fewer
 * particles awake, and a slide over particles that wake and sleep.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "heart.h"
#include "rt/vec.h"

enum { DEPTHS = 4, BINS = 12 };
static const double depths[DEPTHS] = {0.02, 0.05, 0.10, 0.15};
#define SETTLE 3.0 /* time units at rest before a force is read, damping 6 */

/* Contact as stiff for every body, so that depths compare: N/m^3. It sinks in by about 0.001. */
#define CONTACT 2000.0

/* ---- indentation ---------------------------------------------------------------------------- */

typedef struct press {
    char name[64];
    double force[DEPTHS];
    double dent[BINS]; /* mean inward displacement by distance from the axis at rest, at 0.1 */
    int32_t nodes, tetrahedra, awake;
    double us; /* of a step at depth 0.1 */
} press;

/* Largest distance from the axis that the profile looks at. */
#define PROFILE_RADIUS 0.6

static void read_profile(const ss_heart_body *body, press *out)
{
    const ss_real *u = body->model_class->displacement(body->model);
    const ss_mesh *mesh = body->mesh;
    double sum[BINS] = {0};
    int32_t count[BINS] = {0};
    uint8_t *is_surface = calloc((size_t)mesh->node_count, 1);
    for (int32_t c = 0; is_surface != NULL && c < 3 * mesh->triangle_count; ++c) {
        is_surface[mesh->triangle[c / 3][c % 3]] = 1;
    }
    for (int32_t i = 0; is_surface != NULL && i < mesh->node_count; ++i) {
        const double *x = mesh->position[i];
        const double r = hypot(x[1], x[2]);
        const double level = x[0] * x[0] + (r / 0.8) * (r / 0.8);
        const int b = (int)(r / PROFILE_RADIUS * BINS);
        if (is_surface[i] && b < BINS && x[0] > 0.0 && fabs(level - 1.0) < 0.02) {
            sum[b] -= (double)u[4 * (ptrdiff_t)i];
            ++count[b];
        }
    }
    for (int b = 0; b < BINS; ++b) {
        out->dent[b] = count[b] > 0 ? sum[b] / count[b] : (double)NAN;
    }
    free(is_surface);
}

static softsim_status press_pole(ss_heart_body *body, press *out, softsim_error *error)
{
    ss_heart_set(body, "mass_damping_per_s", 6.0);
    body->plan.contact_stiffness = CONTACT;
    const softsim_status status = ss_heart_start(body, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const int32_t steps = (int32_t)(SETTLE / body->step);
    double to[3] = {1.21, 0.0, 0.0};
    (void)ss_heart_move(body, to, 1);
    for (int k = 0; k < DEPTHS; ++k) {
        double force[3];
        to[0] = 1.2 - depths[k];
        (void)ss_heart_move(body, to, steps / 4);
        const double us = ss_heart_move(body, to, steps);
        ss_heart_force(body, force);
        out->force[k] = force[0];
        if (depths[k] == 0.10) {
            out->us = us;
            out->awake = ss_heart_awake(body);
            read_profile(body, out);
        }
    }
    out->nodes = body->mesh->node_count;
    out->tetrahedra = body->mesh->tetrahedron_count;
    return SOFTSIM_OK;
}

static softsim_status press_case(ss_paper *paper, int which, press *out, softsim_error *error)
{
    static const struct {
        const char *name, *model;
        int32_t nodes;
        double spacing;
    } cases[] = {{"fem, 3.6k tetrahedra", "fem", 900, 0.0},
                 {"fem, 31k tetrahedra", "fem", 6600, 0.0},
                 {"hybrid, spacing 0.04", "hybrid", 0, 0.04},
                 {"hybrid, spacing 0.05", "hybrid", 0, 0.05}};
    ss_heart_body body;
    ss_mesh *mesh = cases[which].nodes > 0 ? ss_heart_ellipsoids(paper, cases[which].nodes, error)
                                           : ss_heart_layered_ellipsoids(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, cases[which].model, &ss_heart_table[SS_HEART_ED0], "inner");
    ss_heart_set(&body, "layer.spacing_m", cases[which].spacing);
    ss_heart_set(&body, "layer.activate_m", 0.3);
    ss_heart_set(&body, "layer.max_active", 600.0);
    snprintf(out->name, sizeof out->name, "%s", cases[which].name);
    const softsim_status status = press_pole(&body, out, error);
    ss_heart_end(&body);
    return status;
}

/* Difference of two dents over the size of the first. */
static double dent_difference(const press *fem, const press *other)
{
    double difference = 0.0;
    double sum = 0.0;
    for (int b = 0; b < BINS; ++b) {
        if (isfinite(fem->dent[b]) && isfinite(other->dent[b])) {
            const double d = fem->dent[b] - other->dent[b];
            difference += d * d;
            sum += fem->dent[b] * fem->dent[b];
        }
    }
    return sqrt(difference / sum);
}

static void judge_indentation(ss_paper *paper, const press *coarse, const press *fem,
                              const press *hybrid)
{
    bool is_monotone = true;
    for (int k = 1; k < DEPTHS; ++k) {
        is_monotone = is_monotone && hybrid->force[k] > hybrid->force[k - 1] &&
                      fem->force[k] > fem->force[k - 1];
    }
    ss_claim_add(paper, "Section 6", is_monotone ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
                 "strictly monotone", is_monotone ? "so at every depth" : "not so",
                 "force against depth, %s and %s", fem->name, hybrid->name);
    ss_claim_near(paper, "Section 6", fem->force[2], hybrid->force[2], 0.1,
                  "force at depth 0.1, %s beside %s", hybrid->name, fem->name);
    ss_claim_at_most(paper, "Section 6", dent_difference(fem, coarse), dent_difference(fem, hybrid),
                     "shape of the dent at depth 0.1: difference of %s from %s over its size, at "
                     "most that of %s",
                     hybrid->name, fem->name, coarse->name);
}

static softsim_status plot_indentation(ss_paper *paper, int count, const press *all,
                                       softsim_error *error)
{
    ss_output csv;
    ss_output script;
    softsim_status status = ss_paper_csv_open(paper, &csv, "indentation",
                                              "depth,fem3k,fem31k,hybrid04,hybrid05", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int k = 0; k < DEPTHS; ++k) {
        fprintf(csv.file, "%g", depths[k]);
        for (int i = 0; i < 4; ++i) {
            fprintf(csv.file, ",%.6g", i < count ? all[i].force[k] : (double)NAN);
        }
        fputc('\n', csv.file);
    }
    status = ss_paper_csv_close(paper, &csv, "indentation", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, paper->folder, "indentation", error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file, "set datafile separator ','\nset key left top\nset xlabel 'depth'\n"
                         "set ylabel 'force, N'\nset xrange [0:0.16]\nset yrange [0:*]\nplot ");
    for (int i = 0; i < count; ++i) {
        fprintf(script.file,
                "%s'indentation.csv' skip 1 using 1:%d with linespoints lw 2 dt %d title '%s'",
                i > 0 ? ", " : "", i + 2, i < 2 ? 2 : 1, all[i].name);
    }
    fputc('\n', script.file);
    return ss_page_plot(&paper->page, &script, "indentation",
                        "Force on a ball of 0.2 at the pole of the ellipsoid 1, 0.8, 0.8 with "
                        "clamped cavity 0.6, 0.45, 0.45.",
                        error);
}

softsim_status ss_heart_indentation(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"model",     "nodes",     "tetrahedra",
                                       "awake",     "F at 0.02", "F at 0.05",
                                       "F at 0.10", "F at 0.15", "us a step"};
    static press all[4];
    const int count = paper->is_quick ? 3 : 4;
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < count && status == SOFTSIM_OK; ++k) {
        status = press_case(paper, k, &all[k], error);
        ss_paper_progress(paper, (k + 1.0) / count);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_table_begin(&paper->page, 9, head);
    for (int k = 0; k < count; ++k) {
        ss_row row = {0};
        ss_row_add(&row, "%s", all[k].name);
        ss_row_add(&row, "%d", all[k].nodes);
        ss_row_add(&row, "%d", all[k].tetrahedra);
        ss_row_add(&row, "%d", k < 2 ? 0 : all[k].awake);
        for (int d = 0; d < DEPTHS; ++d) {
            ss_row_add_number(&row, all[k].force[d]);
        }
        ss_row_add_number(&row, all[k].us);
        ss_page_table_row(&paper->page, row.count, row.cell);
    }
    ss_page_table_end(&paper->page);
    judge_indentation(paper, &all[0], &all[1], &all[2]);
    return plot_indentation(paper, count, all, error);
}

/* ---- a thin wall ---------------------------------------------------------------------------- */

#define WALL_X 0.64089 /* of the outer wall at z = -0.2 */

/* HM1 under a ball pressed in by `depth` at the side; active 0: all awake. */
static softsim_status press_wall(const ss_paper *paper, double spacing, int32_t active,
                                 double depth, ss_heart_body *body, softsim_error *error)
{
    double to[3] = {WALL_X + 0.21, 0.0, -0.2};
    ss_mesh *mesh = ss_heart_layered(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(body, mesh, "hybrid", &ss_heart_table[SS_HEART_HM1], "base");
    ss_heart_set(body, "mass_damping_per_s", 6.0);
    ss_heart_set(body, "layer.spacing_m", spacing);
    ss_heart_set(body, "layer.activate_m", active > 0 ? 0.3 : 1e6);
    ss_heart_set(body, "layer.max_active", active > 0 ? active : 1e6);
    body->plan.contact_stiffness = CONTACT;
    const softsim_status status = ss_heart_start(body, error);
    if (status == SOFTSIM_OK) {
        (void)ss_heart_move(body, to, 1);
        to[0] = WALL_X + 0.2 - depth;
        (void)ss_heart_move(body, to, 60);
        (void)ss_heart_move(body, to, 240);
    }
    return status;
}

static softsim_status write_wall(ss_paper *paper, softsim_error *error)
{
    static const int32_t active[] = {50, 200, 450, 700, 0};
    static const char *const head[] = {"awake", "force, N", "error"};
    enum { COUNT = sizeof active / sizeof *active };
    double force[COUNT];
    int32_t awake[COUNT];
    for (int k = 0; k < COUNT; ++k) {
        ss_heart_body body = {0};
        double f[3];
        const softsim_status status = press_wall(paper, 0.027, active[k], 0.1, &body, error);
        if (status == SOFTSIM_OK) {
            ss_heart_force(&body, f);
            force[k] = f[0];
            awake[k] = ss_heart_awake(&body);
        }
        ss_heart_end(&body);
        if (status != SOFTSIM_OK) {
            return status;
        }
        ss_paper_progress(paper, 0.7 * (k + 1.0) / COUNT);
    }
    ss_page_text(&paper->page,
                 "HM1's wall, 0.23 thick of which 0.1 are the layer, under a ball of 0.2 pressed "
                 "in by 0.1. What sleeps is counted by coarse cells; without them the prototype's "
                 "wall softened by 6 to 20 %%.");
    ss_page_table_begin(&paper->page, 3, head);
    for (int k = 0; k < COUNT; ++k) {
        ss_row row = {0};
        ss_row_add(&row, "%d%s", awake[k], active[k] == 0 ? ", all" : "");
        ss_row_add_number(&row, force[k]);
        ss_row_add(&row, "%+.1f %%", 100.0 * (force[k] / force[COUNT - 1] - 1.0));
        ss_page_table_row(&paper->page, row.count, row.cell);
    }
    ss_page_table_end(&paper->page);
    for (int k = 2; k + 1 < COUNT; ++k) {
        ss_claim_near(paper, "Section 6", force[COUNT - 1], force[k], 0.05,
                      "force on a thin wall, %d particles awake beside all of them", awake[k]);
    }
    return SOFTSIM_OK;
}

/* ---- a slide -------------------------------------------------------------------------------- */

/* Around the wall at depth 0.05, the force at every stop. */
enum { STOPS = 24, STEPS_A_STOP = 20 };
static softsim_status slide(const ss_paper *paper, int32_t active, double force_at[STOPS],
                            softsim_error *error)
{
    ss_heart_body body = {0};
    const softsim_status status = press_wall(paper, 0.04, active, 0.05, &body, error);
    for (int k = 0; k < STOPS && status == SOFTSIM_OK; ++k) {
        const double angle = 0.01 * (k + 1);
        const double to[3] = {(WALL_X + 0.15) * cos(angle), (WALL_X + 0.15) * sin(angle), -0.2};
        double force[3];
        (void)ss_heart_move(&body, to, STEPS_A_STOP);
        ss_heart_force(&body, force);
        force_at[k] = ss_norm3(force);
    }
    ss_heart_end(&body);
    return status;
}

/* The largest change of the force from one stop to the next that all awake do not have, over the
 * force; in a quick report, that the mean of the neighbours does not have. */
static softsim_status write_slide(ss_paper *paper, softsim_error *error)
{
    static double force[2][STOPS];
    softsim_status status = slide(paper, 200, force[0], error);
    if (status == SOFTSIM_OK && !paper->is_quick) {
        status = slide(paper, 0, force[1], error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    double jump = 0.0;
    for (int k = 1; k + 1 < STOPS; ++k) {
        const double change = force[0][k] - force[0][k - 1];
        const double plain = paper->is_quick ? 0.5 * (force[0][k + 1] - force[0][k - 1])
                                             : force[1][k] - force[1][k - 1];
        const double own = fabs(change - plain) / force[0][k];
        jump = isfinite(own) ? fmax(jump, own) : (double)INFINITY; /* no contact is no pass */
    }
    ss_claim_at_most(paper, "Section 6", 0.02, jump,
                     "a slide around HM1's wall over four spacings: largest change of the force "
                     "between two stops that %s, over the force",
                     paper->is_quick ? "its neighbours' mean does not have"
                                     : "all particles awake do not "
                                       "have");
    return SOFTSIM_OK;
}

softsim_status ss_heart_walls(ss_paper *paper, softsim_error *error)
{
    /* All 28,000 awake take a minute. */
    const softsim_status status = paper->is_quick ? SOFTSIM_OK : write_wall(paper, error);
    return status == SOFTSIM_OK ? write_slide(paper, error) : status;
}
