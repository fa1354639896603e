/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Table 1: the paper's models at the paper's steps; its bound on the step; its frame rates.
 */
#include <math.h>
#include <stdio.h>

#include "heart.h"
#include "models/hybrid.h"
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
    double point[3];
    double inward[3];
    touch_of(row, point, inward);
    ss_madd3(out, point, depth - 0.2, inward);
}

/* ---- eq. 14 --------------------------------------------------------------------------------- */

/* The printed bound: the least distance of joined nodes times root(rho/(2 lambda + mu)). */
static double printed_bound(const ss_mesh *mesh, const ss_heart_row *row)
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
    return least * sqrt(1.0 / (2.0 * row->lambda + row->mu));
}

/* Every node off by up to a fifth of an edge, as in a mesh from data. */
static void disturb(ss_mesh *mesh)
{
    double(*x)[3] = mesh->position;
    uint32_t seed = 5;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            seed = seed * 1664525u + 1013904223u;
            x[i][a] += 0.06 * ((double)(seed >> 8) / 16777216.0 - 0.5);
        }
    }
}

static softsim_status compare_bound(ss_paper *paper, ss_row *row, int which, softsim_error *error)
{
    ss_heart_body body;
    ss_mesh *mesh = mesh_of(paper, which == SS_HEART_ROWS ? SS_HEART_ED0 : which, error);
    if (mesh == NULL) {
        return error->status;
    }
    if (which == SS_HEART_ROWS) {
        disturb(mesh);
    }
    const int of = which == SS_HEART_ROWS ? SS_HEART_ED0 : which;
    const double printed = printed_bound(mesh, &ss_heart_table[of]);
    ss_model_info info;
    /* Plain tetrahedra, as the bound is meant: no cure. */
    ss_heart_init(&body, mesh, model_of(of), &ss_heart_table[of], group_of(of));
    ss_heart_set(&body, "locking_cure", 1.0);
    ss_heart_set(&body, "viscosity_phi_pa_s", 0.0);
    ss_heart_set(&body, "viscosity_psi_pa_s", 0.0);
    ss_heart_set(&body, "layer.spacing_m", 0.04);
    const softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        body.model_class->info(body.model, &info);
        ss_row_add(row, "%s",
                   which == SS_HEART_ROWS ? "ED0, nodes disturbed" : ss_heart_table[of].name);
        ss_row_add(row, "%d / %d", body.mesh->node_count, body.mesh->tetrahedron_count);
        ss_row_add_number(row, printed);
        ss_row_add_number(row, info.stable_step);
        ss_row_add(row, "%s", printed <= info.stable_step ? "yes" : "no");
    }
    ss_heart_end(&body);
    return status;
}

static softsim_status write_bounds(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"mesh", "nodes / tetrahedra", "eq. 14, s", "dt*, s",
                                       "eq. 14 safe?"};
    softsim_status status = SOFTSIM_OK;
    int unsafe = 0;
    ss_page_text(&paper->page,
                 "dt* = 2/omega of the stiffest motion, by power iteration; eq. 14 as printed, h "
                 "root(rho/(2 lambda + mu)) with h the least distance of neighbours (it should be "
                 "lambda + 2 mu). HM1 with its layer of spacing 0.04.");
    ss_page_table_begin(&paper->page, 5, head);
    for (int which = 0; which <= SS_HEART_ROWS && status == SOFTSIM_OK; ++which) {
        ss_row row = {0};
        status = compare_bound(paper, &row, which, error);
        if (status == SOFTSIM_OK) {
            ss_page_table_row(&paper->page, row.count, row.cell);
            unsafe += row.cell[4][0] == 'n';
        }
    }
    ss_page_table_end(&paper->page);
    if (status == SOFTSIM_OK) {
        char measured[96];
        snprintf(measured, sizeof measured,
                 "larger than dt* on %d of %d meshes: a length is no eigenvalue", unsafe,
                 SS_HEART_ROWS + 1);
        ss_claim_add(paper, "eq. 14", unsafe > 0 ? SS_CLAIM_DIFFERS : SS_CLAIM_PASS,
                     "steps below it are stable", measured, "the bound on the step as printed");
    }
    return status;
}

/* ---- Table 1 -------------------------------------------------------------------------------- */

static softsim_status run_row(ss_paper *paper, int which, bool is_rk4, softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[which];
    ss_heart_body body;
    double to[3];
    double force[3];
    ss_mesh *mesh = mesh_of(paper, which, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, model_of(which), row, group_of(which));
    ss_heart_set(&body, "integrator", is_rk4 ? 1.0 : 0.0);
    ss_heart_set(&body, "layer.spacing_m", 0.027);
    ss_heart_set(&body, "layer.activate_m", 0.15);
    ss_heart_set(&body, "layer.max_active", 200.0);
    softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        ball_at(which, -0.01, to);
        (void)ss_heart_move(&body, to, 1);
        ball_at(which, 0.1, to);
        (void)ss_heart_move(&body, to, 200); /* faster, it would outrun HM2's shear waves */
        (void)ss_heart_move(&body, to, paper->is_quick ? 50 : 200);
        ss_heart_force(&body, force);
        ss_heart_idle(&body, paper->is_quick ? 50 : 200);
        char measured[160];
        ss_model_info info;
        body.model_class->info(body.model, &info);
        snprintf(measured, sizeof measured, "%s; %d sub-steps, %.3g N at depth 0.1", body.reason,
                 info.substeps, force[0]);
        const bool is_good = body.worst < SOFTSIM_VERDICT_DEGRADED && info.fault_bits == 0 &&
                             isfinite(force[0]) && force[0] > 0.0;
        ss_claim_add(paper, "Table 1", is_good ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
                     "finite and stable under a ball pressed in by 0.1", measured,
                     "%s at its step of %g, %s", row->name, row->step,
                     is_rk4 ? "Runge-Kutta" : "symplectic Euler");
    }
    ss_heart_end(&body);
    return status;
}

/* Energy left after 82 time units under the paper's damping alone, of what a let-go pull left. */
static softsim_status run_damping(ss_paper *paper, softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[SS_HEART_ED0];
    ss_heart_body body;
    int32_t pole = 0;
    ss_mesh *mesh = mesh_of(paper, SS_HEART_ED0, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, "fem", row, "inner");
    ss_heart_set(&body, "mass_damping_per_s", 0.0);
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
        ss_heart_idle(&body, (int32_t)((paper->is_quick ? 20.0 : 82.0) / row->step));
        body.model_class->info(body.model, &last);
        const double share = (last.kinetic + last.elastic) / (first.kinetic + first.elastic);
        char measured[160];
        snprintf(measured, sizeof measured,
                 "%.0f %% of the energy is left after %d time units: add mass damping",
                 100.0 * share, paper->is_quick ? 20 : 82);
        ss_claim_add(paper, "Table 1",
                     share > 0.1 && share < 1.01 ? SS_CLAIM_DIFFERS : SS_CLAIM_FAIL,
                     "motion dies away (75 % was left of the prototype's, which was smoother)",
                     measured, "ED0 with the paper's viscosities alone");
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

/* ---- frames a second ------------------------------------------------------------------------ */

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
    ss_heart_set(&body, "layer.max_active", ceil(active / SS_HYBRID_FULL));
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
        ss_claim_at_least(paper, which == SS_HEART_HM1 ? "Section 6" : "Fig. 3", rate, 1e6 / moving,
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
