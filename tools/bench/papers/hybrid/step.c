/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Table 1: the paper's models at the paper's steps; its bound on the step; its frame rates.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/papers/hybrid/hybrid.h"
#include "bench/papers/hybrid/reference.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

/* Frames a second that the paper reports, and its numbers of active particles: so many are awake
 * under the pressed-in ball, and max_active leaves room for those that it has passed. */
#define PAPER_HYBRID_RATE 330.0
#define PAPER_FEM_RATE    29.0
static const int32_t paper_active[] = {50, 200, 600};
enum { ACTIVE_COUNT = sizeof paper_active / sizeof *paper_active };

static ss_mesh *mesh_of(const ss_paper *paper, int row, softsim_error *error)
{
    return row == SS_HEART_ED0   ? ss_heart_ellipsoids(paper, 900, error)
           : row == SS_HEART_HM1 ? ss_heart_layered(paper, error)
                                 : ss_heart_ventricle(paper, error);
}

static const char *model_of(int row)
{
    return row == SS_HEART_HM1 ? "hybrid" : "fem";
}

static const char *group_of(int row)
{
    return row == SS_HEART_ED0 ? "inner" : "base";
}

/* Where the ball first touches, and which way it pushes: ED0 at its pole, the ventricles from the
 * side a little below the middle. */
static void touch_of(int row, double out_point[3], double out_inward[3])
{
    if (row == SS_HEART_ED0) {
        ss_set3(out_point, 1.0, 0.0, 0.0);
    } else {
        ss_set3(out_point, 0.65 * sqrt(1.0 - 0.04 / 1.44), 0.0, -0.2);
    }
    ss_set3(out_inward, -1.0, 0.0, 0.0);
}

static void ball_at(int row, double depth, double out[3])
{
    double point[3], inward[3];
    touch_of(row, point, inward);
    ss_madd3(out, point, depth - 0.2, inward);
}

/* ---- eq. 14 ---- */

/* The least distance of joined nodes. */
static double shortest_edge(const ss_mesh *mesh)
{
    double least = (double)INFINITY;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < a; ++b) {
                double d[3];
                ss_sub3(d, mesh->position[mesh->tetrahedron[e][a]],
                        mesh->position[mesh->tetrahedron[e][b]]);
                least = fmin(least, ss_norm3(d));
            }
        }
    }
    return least;
}

/* Readings of (14), h root(rho/M): whose distances h is the least of, and M. */
enum { READINGS = 4 };
static const struct bound_reading {
    const char *name;
    bool has_particles, is_right; /* h with the layer's particles; M is lambda + 2 mu */
} bound_readings[READINGS] = {{"2 lambda + mu as printed, h of the tetrahedra", false, false},
                              {"lambda + 2 mu, h of the tetrahedra", false, true},
                              {"2 lambda + mu, h with the particles", true, false},
                              {"lambda + 2 mu, h with the particles", true, true}};
static const double bound_spacing = 0.027; /* HM1's 28,000 particles, as the paper's */

/* Every node off by up to a fifth of an edge, as in a mesh from data. */
static void disturb(ss_mesh *mesh)
{
    double(*x)[3] = mesh->position;
    uint64_t seed = 5;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            x[i][a] += 0.06 * (ss_random_unit(&seed) - 0.5);
        }
    }
}

/* One body: all readings beside the largest stable step, by the program and, where the body is
 * tetrahedra alone, by the report's reference finite elements. */
typedef struct bounds {
    const char *name;
    int32_t nodes, tetrahedra;
    double reading[READINGS], stable, reference_stable;
} bounds;

static softsim_status compare_bound(ss_paper *paper, int which, bounds *out, softsim_error *error)
{
    ss_heart_body body;
    ss_heart_reference reference;
    const bool is_disturbed = which == SS_HEART_ROWS;
    const int of = is_disturbed ? SS_HEART_ED0 : which;
    const ss_heart_row *row = &ss_heart_table[of];
    ss_mesh *mesh = mesh_of(paper, of, error);
    if (mesh == NULL) {
        return error->status;
    }
    if (is_disturbed) {
        disturb(mesh);
    }
    *out = (bounds){.name = is_disturbed ? "ED0, nodes disturbed" : row->name,
                    .nodes = mesh->node_count,
                    .tetrahedra = mesh->tetrahedron_count,
                    .reference_stable = (double)NAN};
    for (int r = 0; r < READINGS; ++r) {
        const bool is_layered = bound_readings[r].has_particles && of == SS_HEART_HM1;
        const double h = fmin(shortest_edge(mesh), is_layered ? bound_spacing : (double)INFINITY);
        out->reading[r] = h / sqrt(bound_readings[r].is_right ? row->lambda + 2.0 * row->mu
                                                              : 2.0 * row->lambda + row->mu);
    }
    ss_model_info info;
    /* Plain tetrahedra, as the bound is meant: no cure. */
    ss_heart_init(&body, mesh, model_of(of), row, group_of(of));
    ss_heart_set(&body, "locking_cure", 1.0);
    ss_heart_set(&body, "viscosity_phi_pa_s", 0.0);
    ss_heart_set(&body, "viscosity_psi_pa_s", 0.0);
    ss_heart_set(&body, "layer.spacing_m", bound_spacing);
    softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        body.model_class->info(body.model, &info);
        out->stable = info.stable_step;
        if (of != SS_HEART_HM1 &&
            (!ss_heart_reference_init(&reference, body.mesh, row->lambda, row->mu, group_of(of)) ||
             !ss_heart_reference_stable_step(&reference, &out->reference_stable))) {
            status = ss_memory_fault(error);
        }
        if (of != SS_HEART_HM1) {
            ss_heart_reference_fini(&reference);
        }
    }
    ss_heart_end(&body);
    return status;
}

/* dt* by the reference elements; of HM1, whose layer they do not have, by the program. */
static double largest_step(const bounds *of)
{
    return isfinite(of->reference_stable) ? of->reference_stable : of->stable;
}

static void put_bounds(FILE *file, const void *context, int32_t b)
{
    const bounds *at = (const bounds *)context + b;
    fprintf(file, "\"%s\",%d,%d,%.5g,%.5g", at->name, at->nodes, at->tetrahedra, at->stable,
            at->reference_stable);
    for (int r = 0; r < READINGS; ++r) {
        fprintf(file, ",%.5g", at->reading[r]);
    }
    fputc('\n', file);
}

static softsim_status show_bounds(ss_paper *paper, const bounds *all, softsim_error *error)
{
    static const char *const head[] = {"body",
                                       "nodes / tetrahedra",
                                       "called stable, s",
                                       "dt* of reference elements, s",
                                       "2 lambda + mu, h of tetrahedra",
                                       "lambda + 2 mu",
                                       "2 lambda + mu, h with particles",
                                       "lambda + 2 mu"};
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int b = 0; b <= SS_HEART_ROWS; ++b) {
        ss_row row = {.count = 0};
        ss_row_add(&row, "%s", all[b].name);
        ss_row_add(&row, "%d / %d", all[b].nodes, all[b].tetrahedra);
        ss_row_add_number(&row, all[b].stable);
        ss_row_add_number(&row, all[b].reference_stable);
        for (int r = 0; r < READINGS; ++r) {
            ss_row_add(&row, "%.4g%s", all[b].reading[r],
                       all[b].reading[r] > largest_step(&all[b]) ? ", unsafe" : "");
        }
        ss_page_table_row(&paper->page, row.count, row.cell);
    }
    ss_page_table_end(&paper->page);
    return ss_paper_csv_write(
        paper, "bounds",
        "body,nodes,tetrahedra,stable_s,reference_stable_s,printed_s,right_modulus_s,"
        "printed_particles_s,right_modulus_particles_s",
        SS_HEART_ROWS + 1, put_bounds, all, error);
}

static softsim_status write_bounds(ss_paper *paper, softsim_error *error)
{
    bounds all[SS_HEART_ROWS + 1];
    char measured[320] = "", part[96];
    bool has_good = false;
    softsim_status status = SOFTSIM_OK;
    ss_page_text(&paper->page,
                 "dt* = 2/omega of the stiffest motion, by power iteration. What the program calls "
                 "stable is dt*, but no more than twice a guaranteed bound, since its steps are "
                 "half of it. Eq. 14: h root(rho/M), "
                 "with M = 2 lambda + mu as printed or lambda + 2 mu, the modulus of the fastest "
                 "wave, and h the least distance of neighbours, of the tetrahedra's nodes or with "
                 "HM1's particles too (spacing %g).",
                 bound_spacing);
    for (int which = 0; which <= SS_HEART_ROWS && status == SOFTSIM_OK; ++which) {
        status = compare_bound(paper, which, &all[which], error);
    }
    if (status == SOFTSIM_OK) {
        status = show_bounds(paper, all, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int b = 0; b <= SS_HEART_ROWS; ++b) {
        if (isfinite(all[b].reference_stable)) {
            ss_claim_at_most(
                paper, "eq. 14", SS_FROM_CODE, all[b].reference_stable, all[b].stable,
                "%s: the step that the program calls stable, at most dt* by the reference "
                "elements, s",
                all[b].name);
            ss_claim_near(paper, "eq. 14", SS_FROM_CODE, all[b].reference_stable, all[b].stable,
                          0.02, "%s: the same within 2 %%, s", all[b].name);
            ss_claim_search(paper, "the program's power iteration agrees with dt* but for its "
                                   "margin of 0.5 %%; where twice its guaranteed bound is less, "
                                   "that is what it calls stable: a choice for safety");
        }
    }
    for (int r = 0; r < READINGS; ++r) {
        double worst = 0.0;
        int at = 0;
        for (int b = 0; b <= SS_HEART_ROWS; ++b) {
            if (all[b].reading[r] / largest_step(&all[b]) > worst) {
                worst = all[b].reading[r] / largest_step(&all[b]);
                at = b;
            }
        }
        has_good = has_good || worst <= 1.0;
        snprintf(part, sizeof part, "%s%s: %.2f dt* on %s", r > 0 ? "; " : "",
                 bound_readings[r].name, worst, all[at].name);
        strncat(measured, part, sizeof measured - strlen(measured) - 1);
    }
    ss_claim_add(paper, "eq. 14", SS_FROM_PAPER, has_good ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "steps below it are stable", measured,
                 "the Courant condition: at most dt* on every body");
    ss_claim_search(paper,
                    "four readings (M printed or of the fastest wave; h of the tetrahedra or "
                    "with HM1's particles, which makes HM1 safe) on ED0, HM1, HM2 and ED0 "
                    "disturbed: a length is no eigenvalue");
    return SOFTSIM_OK;
}

/* ---- Table 1 ---- */

/* The largest displacement of a node; NaN where one is not finite. */
static double largest(const ss_heart_body *body)
{
    const ss_real *u = body->model_class->displacement(body->model);
    double most = 0.0;
    for (int32_t i = 0; i < body->mesh->node_count; ++i) {
        const double at[3] = {(double)u[4 * (ptrdiff_t)i], (double)u[4 * (ptrdiff_t)i + 1],
                              (double)u[4 * (ptrdiff_t)i + 2]};
        const double size = ss_norm3(at);
        most = isfinite(size) && isfinite(most) ? fmax(most, size) : (double)NAN;
    }
    return most;
}

static softsim_status run_row(ss_paper *paper, int which, bool is_rk4, softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[which];
    ss_heart_body body;
    double to[3], force[3];
    ss_mesh *mesh = mesh_of(paper, which, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, model_of(which), row, group_of(which));
    ss_heart_set(&body, "integrator", is_rk4 ? 1.0 : 0.0);
    ss_heart_set_layer(&body, 0.027, 0.15, 200.0);
    softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        ball_at(which, -0.01, to);
        (void)ss_heart_move(&body, to, 1);
        ball_at(which, 0.1, to);
        (void)ss_heart_move(&body, to, 200); /* faster, it would outrun HM2's shear waves */
        (void)ss_heart_move(&body, to, paper->is_quick ? 50 : 200);
        ss_heart_force(&body, force);
        ss_model_info info;
        body.model_class->info(body.model, &info);
        const double stopped = info.elastic + info.kinetic;
        (void)ss_heart_move(&body, to, paper->is_quick ? 50 : 200);
        body.model_class->info(body.model, &info);
        const double held = info.elastic + info.kinetic;
        ss_claim_at_most(paper, "Table 1", SS_FROM_PAPER, 1.02,
                         force[0] > 0.0 ? held / stopped : (double)NAN,
                         "%s at its step of %g (%d sub-step%s of the program), %s, a ball pressed "
                         "in by 0.1: stable: energy after %d steps of holding it over that before",
                         row->name, row->step, info.substeps, info.substeps == 1 ? "" : "s",
                         is_rk4 ? "Runge-Kutta" : "symplectic Euler", paper->is_quick ? 50 : 200);
        ss_heart_idle(&body, paper->is_quick ? 50 : 200);
        ss_claim_at_most(paper, "Table 1", SS_FROM_PAPER, 0.15, largest(&body),
                         "%s, %s: finite and bounded: largest displacement when the ball has gone "
                         "again, of a press of 0.1",
                         row->name, is_rk4 ? "Runge-Kutta" : "symplectic Euler");
    }
    ss_heart_end(&body);
    return status;
}

/* The same by the report's reference elements; NaN when out of memory. */
static double reference_damping(const ss_mesh *mesh, const ss_heart_row *row, int32_t pole,
                                const ss_load *pull, double left_s)
{
    ss_heart_reference reference;
    if (!ss_heart_reference_init(&reference, mesh, row->lambda, row->mu, "inner")) {
        return (double)NAN;
    }
    reference.phi = reference.psi = row->viscosity;
    const int32_t pulled = (int32_t)(2.1 / row->step);
    for (int32_t k = 0; k < pulled; ++k) {
        const double time = k * row->step;
        reference.pushed = time < pull->to ? pole : -1;
        ss_scale3(reference.push, pull->force, fmin(1.0, time / pull->ramp));
        ss_heart_reference_run(&reference, 1, row->step);
    }
    reference.pushed = -1;
    const double first = reference.elastic + reference.kinetic;
    ss_heart_reference_run(&reference, (int32_t)(left_s / row->step), row->step);
    const double last = reference.elastic + reference.kinetic;
    ss_heart_reference_fini(&reference);
    return last / first;
}

/* Energy left after 82 time units under the paper's damping alone, of what a let-go pull left. */
static softsim_status run_damping(ss_paper *paper, softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[SS_HEART_ED0];
    const double left_s = paper->is_quick ? 20.0 : 82.0;
    ss_heart_body body;
    int32_t pole = 0;
    ss_mesh *mesh = mesh_of(paper, SS_HEART_ED0, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, "fem", row, "inner");
    ss_heart_set(&body, "mass_damping_per_s", 0.0);
    ss_heart_set(&body, "locking_cure", 1.0); /* as the reference elements */
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        pole = mesh->position[i][0] > mesh->position[pole][0] ? i : pole;
    }
    const ss_load pull = {
        .node = &pole, .node_count = 1, .force = {0.05, 0.0, 0.0}, .to = 2.0, .ramp = 1.0};
    body.plan.load = &pull;
    body.plan.load_count = 1;
    const softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        ss_model_info first;
        ss_model_info last;
        ss_heart_idle(&body, (int32_t)(2.1 / row->step));
        body.model_class->info(body.model, &first);
        ss_heart_idle(&body, (int32_t)(left_s / row->step));
        body.model_class->info(body.model, &last);
        const double share = (last.kinetic + last.elastic) / (first.kinetic + first.elastic);
        const double reference = reference_damping(body.mesh, row, pole, &pull, left_s);
        ss_claim_near(paper, "Table 1", SS_FROM_CODE, reference, share, 0.1,
                      "ED0 pulled at its pole and let go, the paper's viscosities alone: share of "
                      "the energy left after %g time units",
                      left_s);
        ss_page_text(&paper->page,
                     "The paper: phi and psi control how fast the material loses kinetic energy. "
                     "Table 1's are small: with them alone %.0f %% of the energy of a pull is left "
                     "after %g time units; a body under a hand needs mass damping.",
                     100.0 * share, left_s);
    }
    ss_heart_end(&body);
    return status;
}

softsim_status ss_heart_steps(ss_paper *paper, softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    for (int which = 0; which < SS_HEART_ROWS; ++which) {
        for (int rk4 = 0; rk4 < 2 && status == SOFTSIM_OK; ++rk4) {
            status = run_row(paper, which, rk4 == 1, error);
            ss_paper_progress(paper, (2.0 * which + rk4 + 1.0) / 8.0);
        }
    }
    if (status == SOFTSIM_OK) {
        status = run_damping(paper, error);
    }
    return status == SOFTSIM_OK ? write_bounds(paper, error) : status;
}

/* ---- frames a second ---- */

static softsim_status time_row(ss_paper *paper, ss_output *csv, int which, int32_t active,
                               softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[which];
    ss_heart_body body;
    double to[3];
    ss_mesh *mesh = mesh_of(paper, which, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, model_of(which), row, group_of(which));
    ss_heart_set(&body, "layer.spacing_m", 0.027);
    ss_heart_set(&body, "layer.activate_m", 0.3);
    if (body.model_class->layer != NULL) {
        ss_heart_set(&body, "layer.max_active", ceil(active / body.model_class->layer->full));
    }
    const softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        const double rate = which == SS_HEART_HM1 ? PAPER_HYBRID_RATE : PAPER_FEM_RATE;
        ball_at(which, -0.01, to);
        (void)ss_heart_move(&body, to, 1);
        ball_at(which, 0.05, to);
        const double moving = ss_heart_move(&body, to, 60);
        ss_model_info info;
        const double still = ss_heart_move(&body, to, 60);
        body.model_class->info(body.model, &info);
        ss_row cells = {0};
        ss_row_add(&cells, "%s", row->name);
        ss_row_add(&cells, "%d", which == SS_HEART_HM1 ? ss_heart_awake(&body) : 0);
        ss_row_add_number(&cells, moving);
        ss_row_add_number(&cells, still);
        ss_row_add(&cells, "%d", info.substeps);
        ss_row_add_number(&cells, moving / info.substeps);
        ss_row_add_number(&cells, still / info.substeps);
        ss_row_add_number(&cells, 1e6 / moving);
        ss_row_add_number(&cells, rate);
        ss_page_table_row(&paper->page, cells.count, cells.cell);
        fprintf(csv->file, "%s,%d,%.5g,%.5g,%d,%.5g,%.5g\n", row->name, ss_heart_awake(&body),
                moving, still, info.substeps, moving / info.substeps, still / info.substeps);
        ss_claim_at_least(paper, which == SS_HEART_HM1 ? "Section 6" : "Fig. 3", SS_FROM_PAPER,
                          rate, 1e6 / moving,
                          "%s: frames of %g time units a second, one core, the tool moving%s",
                          row->name, row->step,
                          which == SS_HEART_HM1 ? active == 50    ? ", 50 particles active"
                                                  : active == 200 ? ", 200 active"
                                                                  : ", 600 active"
                                                : "");
    }
    ss_heart_end(&body);
    return status;
}

softsim_status ss_heart_rates(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"model",      "awake",           "frame, tool moving, us",
                                       "tool still", "sub-steps",       "of one, moving, us",
                                       "still, us",  "frames a second", "the paper's, Pentium 4"};
    ss_output csv;
    softsim_status status = ss_paper_csv_open(
        paper, &csv, "rates",
        "model,awake,frame_moving_us,frame_still_us,substeps,substep_moving_us,substep_still_us",
        error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "A frame is a step of Table 1 with a ball of 0.2 pressed in, activation, contact "
                 "and what the hand needs included; it takes as many sub-steps as half of the "
                 "law's stable step and nine tenths of the contact's ask for.");
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int k = 0; k < ACTIVE_COUNT && status == SOFTSIM_OK; ++k) {
        status = time_row(paper, &csv, SS_HEART_HM1, paper_active[k], error);
        ss_paper_progress(paper, (k + 1.0) / (ACTIVE_COUNT + 1.0));
    }
    if (status == SOFTSIM_OK) {
        status = time_row(paper, &csv, SS_HEART_HM2, 0, error);
    }
    ss_page_table_end(&paper->page);
    if (status != SOFTSIM_OK) {
        ss_output_abandon(&csv);
        return status;
    }
    return ss_paper_csv_close(paper, &csv, "rates", error);
}
