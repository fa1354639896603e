/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Force and shape under a ball: the hybrid and the program's finite elements beside the report's
 * reference elements (reference.h), a thin wall with more and fewer particles awake, and a slide
 * over particles that wake and sleep.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/hybrid/hybrid.h"
#include "bench/papers/hybrid/reference.h"
#include "models/layer.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { DEPTHS = 4, BINS = 12 };
static const double depths[DEPTHS] = {0.02, 0.05, 0.10, 0.15};
#define SETTLE 3.0 /* time units at rest before a force is read, damping 6 */

/* Contact as stiff for every body, so that depths compare: N/m^3. It sinks in by about 0.001. */
#define CONTACT 2000.0

/* ---- indentation ---- */

typedef struct press {
    char name[64];
    double force[DEPTHS];
    double dent[BINS]; /* mean inward displacement by distance from the axis at rest, at 0.1 */
    int32_t nodes, tetrahedra, particles, awake;
    double us; /* of a step at depth 0.1 */
} press;

/* Largest distance from the axis that the profile looks at. */
#define PROFILE_RADIUS 0.6

static void read_profile(const ss_mesh *mesh, const double (*u)[3], press *out)
{
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
            sum[b] -= u[i][0];
            ++count[b];
        }
    }
    for (int b = 0; b < BINS; ++b) {
        out->dent[b] = count[b] > 0 ? sum[b] / count[b] : (double)NAN;
    }
    free(is_surface);
}

/* The same of a model. */
static void read_model(const ss_heart_body *body, press *out)
{
    const ss_real *from = body->model_class->displacement(body->model);
    double(*u)[3] = calloc((size_t)body->mesh->node_count, sizeof *u);
    for (int32_t i = 0; u != NULL && i < body->mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            u[i][a] = (double)from[4 * (ptrdiff_t)i + a];
        }
    }
    if (u != NULL) {
        read_profile(body->mesh, (const double(*)[3])u, out);
    }
    free(u);
}

/* The report's reference elements pressed to a depth of 0.1 alone; force[2] and the dent. */
static softsim_status press_reference(const ss_paper *paper, int32_t nodes, press *out,
                                      softsim_error *error)
{
    enum { RAMP = 300, HOLD = 857 };
    const double dt = 0.0035, start[3] = {1.21, 0.0, 0.0}, to[3] = {1.1, 0.0, 0.0};
    const ss_heart_row *row = &ss_heart_table[SS_HEART_ED0];
    ss_heart_reference reference;
    ss_mesh *mesh = ss_heart_ellipsoids(paper, nodes, error);
    if (mesh == NULL) {
        return error->status;
    }
    *out = (press){.nodes = mesh->node_count, .tetrahedra = mesh->tetrahedron_count};
    snprintf(out->name, sizeof out->name, "reference elements, %.1fk tetrahedra",
             1e-3 * mesh->tetrahedron_count);
    if (!ss_heart_reference_init(&reference, mesh, row->lambda, row->mu, "inner")) {
        ss_mesh_destroy(&mesh);
        return ss_memory_fault(error);
    }
    reference.damping = 6.0;
    reference.is_guarded = true;
    reference.radius = 0.2;
    reference.stiffness = CONTACT;
    ss_copy3(reference.ball, start);
    ss_heart_reference_move(&reference, to, RAMP, dt);
    ss_heart_reference_run(&reference, HOLD, dt);
    out->force[2] = reference.ball_force[0];
    read_profile(mesh, (const double(*)[3])reference.u, out);
    ss_heart_reference_fini(&reference);
    ss_mesh_destroy(&mesh);
    return SOFTSIM_OK;
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
            read_model(body, out);
        }
    }
    out->nodes = body->mesh->node_count;
    out->tetrahedra = body->mesh->tetrahedron_count;
    return SOFTSIM_OK;
}

enum { FEM_COARSE, FEM_FINE, HYBRID, GRADED, HYBRID_COARSE, CASES };
static const struct {
    const char *name, *model;
    int32_t nodes;
    double spacing, near; /* near: within 0.4 of the pole; 0: the same everywhere */
} cases[CASES] = {
    [FEM_COARSE] = {"fem, 3.6k tetrahedra", "fem", 900, 0.0, 0.0},
    [FEM_FINE] = {"fem, 33.1k tetrahedra", "fem", 6600, 0.0, 0.0},
    [HYBRID] = {"hybrid, spacing 0.04", "hybrid", 0, 0.04, 0.0},
    [GRADED] = {"hybrid, spacing 0.04 at the pole, 0.08 elsewhere", "hybrid", 0, 0.08, 0.04},
    [HYBRID_COARSE] = {"hybrid, spacing 0.05", "hybrid", 0, 0.05, 0.0}};

/* Spacings of a graded layer; NULL when out of memory. */
static double *grade(const ss_mesh *mesh, double spacing, double near)
{
    static const double pole[3] = {1.0, 0.0, 0.0};
    double *of = malloc((size_t)mesh->node_count * sizeof *of);
    for (int32_t i = 0; of != NULL && i < mesh->node_count; ++i) {
        double d[3];
        ss_sub3(d, mesh->position[i], pole);
        of[i] = ss_norm3(d) < 0.4 ? near : spacing;
    }
    return of;
}

static softsim_status press_case(ss_paper *paper, int which, press *out, softsim_error *error)
{
    ss_heart_body body;
    double *graded = NULL;
    ss_mesh *mesh = cases[which].nodes > 0 ? ss_heart_ellipsoids(paper, cases[which].nodes, error)
                                           : ss_heart_layered_ellipsoids(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, cases[which].model, &ss_heart_table[SS_HEART_ED0], "inner");
    ss_heart_set_layer(&body, cases[which].spacing, 0.3, 600.0);
    if (cases[which].near > 0.0) {
        graded = grade(body.mesh, cases[which].spacing, cases[which].near);
        const ss_param_row *row = ss_model_find_row(body.model_class, "layer.spacing_m");
        body.param[row - body.model_class->row].per_node = graded;
    }
    snprintf(out->name, sizeof out->name, "%s", cases[which].name);
    const softsim_status status = press_pole(&body, out, error);
    if (status == SOFTSIM_OK && cases[which].nodes == 0) {
        out->particles = body.model_class->layer->at_rest(body.model)->own_count;
    }
    ss_heart_end(&body);
    free(graded);
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

/* Where two meshes lead: errors fall with the square of the elements' size. */
static double limit_of(const press *coarse, const press *fine)
{
    const double ratio = pow((double)fine->tetrahedra / coarse->tetrahedra, 2.0 / 3.0);
    return fine->force[2] + (fine->force[2] - coarse->force[2]) / (ratio - 1.0);
}

static void judge_indentation(ss_paper *paper, const press *all, const press *reference,
                              const char *search)
{
    const press *fem = &all[FEM_FINE], *hybrid = &all[HYBRID], *graded = &all[GRADED];
    bool is_monotone = true;
    for (int k = 1; k < DEPTHS; ++k) {
        is_monotone = is_monotone && hybrid->force[k] > hybrid->force[k - 1] &&
                      fem->force[k] > fem->force[k - 1];
    }
    ss_claim_add(paper, "Section 6", SS_FROM_CLOSED_FORM,
                 is_monotone ? SS_CLAIM_PASS : SS_CLAIM_FAIL, "strictly monotone",
                 is_monotone ? "so at every depth" : "not so", "force against depth, %s and %s",
                 fem->name, hybrid->name);
    ss_claim_near(paper, "Section 6", SS_FROM_CODE, reference[1].force[2], fem->force[2], 0.05,
                  "force at depth 0.1, %s beside %s, each with its own contact", fem->name,
                  reference[1].name);
    ss_claim_search(
        paper, "contact acts on the smooth surface in fem and on facets in the reference elements. "
               "Where meshes lead, the next row; without contact, Fig. 3; finer meshes were "
               "not tried");
    ss_claim_near(
        paper, "Section 6", SS_FROM_CODE, limit_of(&reference[0], &reference[1]),
        limit_of(&all[FEM_COARSE], fem), 0.1,
        "force at depth 0.1, fem beside reference elements, each extrapolated from its two "
        "meshes (contact acts on the smooth surface in fem, on facets in the reference)");
    ss_claim_near(paper, "Section 6", SS_FROM_CODE, reference[1].force[2], hybrid->force[2], 0.1,
                  "force at depth 0.1, %s beside %s", hybrid->name, reference[1].name);
    ss_claim_search(paper, "beside %s, whose contact is the same: %+.1f %%; %s", fem->name,
                    100.0 * (hybrid->force[2] / fem->force[2] - 1.0), search);
    ss_claim_at_most(paper, "Section 6", SS_FROM_CODE,
                     dent_difference(&reference[1], &reference[0]),
                     dent_difference(&reference[1], hybrid),
                     "shape of the dent at depth 0.1: difference of %s from %s over its size, at "
                     "most that of %s",
                     hybrid->name, reference[1].name, reference[0].name);
    ss_claim_search(paper, "%s", search);
    ss_claim_near(paper, "Conclusion", SS_FROM_CODE, reference[1].force[2], graded->force[2], 0.1,
                  "different sizes in the particle zone: force at depth 0.1, %s", graded->name);
    ss_claim_search(paper, "%s", search);
    ss_claim_at_most(paper, "Conclusion", SS_FROM_PAPER, 0.5,
                     (double)graded->particles / hybrid->particles,
                     "and more efficient: particles of the layer, over those of %s", hybrid->name);
}

/* What the hybrid's force and dent are at other parameters of the layer, which the paper does not
 * give. */
static softsim_status search_layer(ss_paper *paper, const press *reference, char out[512],
                                   softsim_error *error)
{
    static const struct {
        double spacing, cohesion, stabilisation;
    } tries[] = {{0.04, 0.0, 0.3}, {0.04, 0.0, 0.1}, {0.04, 0.05, 0.1}, {0.05, 0.0, 0.1}};
    softsim_status status = SOFTSIM_OK;
    snprintf(out, 512,
             "other parameters of the layer, of which the paper gives none (spacing, "
             "share of pair forces, stabilisation: force, difference of the dent): ");
    for (size_t k = 0; k < sizeof tries / sizeof *tries && status == SOFTSIM_OK; ++k) {
        static press tried;
        ss_heart_body body;
        char part[96];
        ss_mesh *mesh = ss_heart_layered_ellipsoids(paper, error);
        if (mesh == NULL) {
            return error->status;
        }
        ss_heart_init(&body, mesh, "hybrid", &ss_heart_table[SS_HEART_ED0], "inner");
        ss_heart_set(&body, "layer.spacing_m", tries[k].spacing);
        ss_heart_set(&body, "layer.lennard_jones_share", tries[k].cohesion);
        ss_heart_set(&body, "layer.stabilisation", tries[k].stabilisation);
        ss_heart_set(&body, "layer.activate_m", 0.3);
        ss_heart_set(&body, "layer.max_active", 600.0);
        status = press_pole(&body, &tried, error);
        ss_heart_end(&body);
        snprintf(part, sizeof part, "%s%g, %g, %g: %.3g N, %.3g", k > 0 ? "; " : "",
                 tries[k].spacing, tries[k].cohesion, tries[k].stabilisation, tried.force[2],
                 dent_difference(reference, &tried));
        strncat(out, part, 512 - strlen(out) - 1);
    }
    return status;
}

static softsim_status plot_indentation(ss_paper *paper, int count, const press *all,
                                       const press reference[2], softsim_error *error)
{
    ss_output csv;
    ss_output script;
    softsim_status status = ss_paper_csv_open(paper, &csv, "indentation",
                                              "depth,fem3k,fem33k,hybrid04,graded,hybrid05", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int k = 0; k < DEPTHS; ++k) {
        fprintf(csv.file, "%g", depths[k]);
        for (int i = 0; i < CASES; ++i) {
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
    fprintf(
        script.file,
        "$reference << EOD\n0.1,%.6g,%.6g\nEOD\nset datafile separator ','\nset key bottom right\n"
        "set xlabel 'depth, m'\nset ylabel 'force, N'\nset xrange [0:0.16]\nset yrange [0:*]\n"
        "plot ",
        reference[0].force[2], reference[1].force[2]);
    for (int i = 0; i < count; ++i) {
        fprintf(script.file,
                "%s'indentation.csv' skip 1 using 1:%d with linespoints lw 2 dt %d title '%s'",
                i > 0 ? ", " : "", i + 2, i < 2 ? 2 : 1, all[i].name);
    }
    for (int k = 0; k < 2; ++k) {
        fprintf(script.file,
                ", $reference using 1:%d with points pt %d ps 1.5 lc rgb 'black' title '%s'", k + 2,
                6 + k, reference[k].name);
    }
    fputc('\n', script.file);
    return ss_page_plot(&paper->page, &script, "indentation",
                        "Force on a ball of 0.2 m pressed into the pole of the ellipsoid 1, 0.8, "
                        "0.8 m, whose cavity 0.6, 0.45, 0.45 m is held; black: what is expected.",
                        error);
}

softsim_status ss_heart_indentation(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"model",     "nodes",     "tetrahedra", "particles",
                                       "awake",     "F at 0.02", "F at 0.05",  "F at 0.10",
                                       "F at 0.15", "us a step"};
    static press all[CASES], reference[2];
    const int count = paper->is_quick ? HYBRID_COARSE : CASES;
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; k < count && status == SOFTSIM_OK; ++k) {
        status = press_case(paper, k, &all[k], error);
        ss_paper_progress(paper, (k + 1.0) / count);
    }
    for (int k = 0; k < 2 && status == SOFTSIM_OK; ++k) {
        status = press_reference(paper, k == 0 ? 900 : 6600, &reference[k], error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "Where the nonlinearity comes from: Green strain, quadratic in the displacement, "
                 "with a linear law; and contact, which spreads as the ball sinks in. The %s, "
                 "which share no code with the program, press %.4g N at depth 0.1; the %s %.4g N.",
                 reference[1].name, reference[1].force[2], reference[0].name,
                 reference[0].force[2]);
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int k = 0; k < count; ++k) {
        ss_row row = {0};
        ss_row_add(&row, "%s", all[k].name);
        ss_row_add(&row, "%d", all[k].nodes);
        ss_row_add(&row, "%d", all[k].tetrahedra);
        ss_row_add(&row, "%d", all[k].particles);
        ss_row_add(&row, "%d", k < HYBRID ? 0 : all[k].awake);
        for (int d = 0; d < DEPTHS; ++d) {
            ss_row_add_number(&row, all[k].force[d]);
        }
        ss_row_add_number(&row, all[k].us);
        ss_page_table_row(&paper->page, row.count, row.cell);
    }
    ss_page_table_end(&paper->page);
    char search[512] = "none in a quick report";
    if (!paper->is_quick) {
        status = search_layer(paper, &reference[1], search, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    judge_indentation(paper, all, reference, search);
    return plot_indentation(paper, count, all, reference, error);
}

/* ---- a thin wall ---- */

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
    ss_heart_set_layer(body, spacing, active > 0 ? 0.3 : 1e6, active > 0 ? active : 1e6);
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

/* HM1's wall filled with tetrahedra, by the report's reference elements: the force at depth 0.1. */
static softsim_status press_filled_wall(const ss_paper *paper, double *out_force,
                                        softsim_error *error)
{
    enum { RAMP = 150, HOLD = 480 };
    const char *const argv[] = {"ventricle",  "--tetrahedra", "--size-mm", "1300,1300,2400",
                                "--inner-mm", "840,840,2000", "--base-mm", "500",
                                "--points",   "7000",         NULL};
    const double dt = 0.0035, to[3] = {WALL_X + 0.1, 0.0, -0.2};
    const ss_heart_row *row = &ss_heart_table[SS_HEART_HM1];
    ss_heart_reference reference;
    ss_mesh *mesh = ss_heart_generate(paper, argv, error);
    if (mesh == NULL) {
        return error->status;
    }
    const bool is_good = ss_heart_reference_init(&reference, mesh, row->lambda, row->mu, "base");
    if (is_good) {
        reference.damping = 6.0;
        reference.is_guarded = true;
        reference.radius = 0.2;
        reference.stiffness = CONTACT;
        ss_set3(reference.ball, WALL_X + 0.21, 0.0, -0.2);
        ss_heart_reference_move(&reference, to, RAMP, dt);
        ss_heart_reference_run(&reference, HOLD, dt);
        *out_force = reference.ball_force[0];
        ss_heart_reference_fini(&reference);
    } else {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
    }
    ss_mesh_destroy(&mesh);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

static softsim_status write_wall(ss_paper *paper, softsim_error *error)
{
    static const int32_t active[] = {50, 200, 450, 700, 0};
    static const char *const head[] = {"awake", "force, N", "beside all awake",
                                       "beside reference elements"};
    enum { COUNT = sizeof active / sizeof *active };
    double force[COUNT], reference = (double)NAN;
    int32_t awake[COUNT];
    const softsim_status pressed = press_filled_wall(paper, &reference, error);
    if (pressed != SOFTSIM_OK) {
        return pressed;
    }
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
    ss_page_text(
        &paper->page,
        "HM1's wall, 0.23 m thick of which 0.1 are the layer, under a ball of 0.2 m "
        "pressed in by 0.1. Particles that sleep move with the coarse cells they lie in. "
        "The wall filled with tetrahedra, by the report's reference elements, presses %.4g N.",
        reference);
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int k = 0; k < COUNT; ++k) {
        ss_row row = {0};
        ss_row_add(&row, "%d%s", awake[k], active[k] == 0 ? ", all" : "");
        ss_row_add_number(&row, force[k]);
        ss_row_add(&row, "%+.1f %%", 100.0 * (force[k] / force[COUNT - 1] - 1.0));
        ss_row_add(&row, "%+.1f %%", 100.0 * (force[k] / reference - 1.0));
        ss_page_table_row(&paper->page, row.count, row.cell);
    }
    ss_page_table_end(&paper->page);
    for (int k = 0; k < COUNT; ++k) {
        ss_claim_near(paper, "Section 6", SS_FROM_CODE, reference, force[k], 0.1,
                      "force on a thin wall, %d particles awake%s, beside reference elements",
                      awake[k], k + 1 == COUNT ? " (all)" : "");
    }
    return SOFTSIM_OK;
}

/* ---- a slide ---- */

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
        const double jumped = fabs(change - plain) / force[0][k];
        jump = isfinite(jumped) ? fmax(jump, jumped) : (double)INFINITY; /* no contact is no pass */
    }
    ss_claim_at_most(paper, "Section 6", SS_FROM_CLOSED_FORM, 0.02, jump,
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
