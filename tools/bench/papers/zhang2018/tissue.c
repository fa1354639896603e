/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Heterogeneous tissue, which the paper's introduction asks of a model: the plane with one half
 * eight times as stiff as the other, pushed at its middle, beside the report's reference network.
 */
#include <math.h>
#include <string.h>

#include "bench/core/surface_picture.h"
#include "bench/papers/zhang2018/zhang2018.h"
#include "rt/vec.h"

static const double soft_k = 1.0, stiff_k = 8.0, depth_m = 5.0, pace = 0.25,
                    hold_s = 20.0; /* h, C */

typedef double plane_field[SS_PLANE_NODES][3];

static softsim_status run_model(ss_zhang *zhang, double *stiffness, double *out_step_s,
                                double *out_force, plane_field out_u, char out_reason[256],
                                softsim_error *error)
{
    ss_zhang_run run;
    const double short_s = 0.125; /* below what the stiff half allows */
    ss_zhang_setup setup = ss_zhang_plane_setup(&zhang->plane, "cnn-chainmail", depth_m, short_s);
    setup.param[0] = "alpha=0.02";
    setup.param[1] = "capacitance_s=1";
    setup.stiffness_of = stiffness;
    softsim_status status = ss_zhang_begin(&setup, &run, error);
    snprintf(out_reason, 256, "%s", run.reason);
    *out_step_s = run.step_s;
    if (status == SOFTSIM_OK && run.model != NULL) {
        status = ss_zhang_go(&run, depth_m, pace, error);
        if (status == SOFTSIM_OK) {
            status = ss_zhang_hold(&run, hold_s, error);
        }
        *out_force = ss_zhang_force(&run);
        ss_zhang_read(&run, out_u);
    }
    ss_zhang_end(&run);
    return status;
}

static softsim_status draw(ss_zhang *zhang, const plane_field u, softsim_error *error)
{
    static const ss_surface_picture_view view = {{-0.35, -1.0, 0.55}, {0.0, 0.0, 1.0}, ""};
    static uint32_t colour[(SS_PLANE_SIDE - 1) * (SS_PLANE_SIDE - 1)];
    const ss_mesh *mesh = zhang->plane.mesh;
    for (int32_t q = 0; q < mesh->quad_count; ++q) {
        const double *a = mesh->position[mesh->quad[q][0]], *b = mesh->position[mesh->quad[q][2]];
        colour[q] = a[0] + b[0] < 0.0 ? 0xd8b9a0 : 0x8fb3c9;
    }
    const ss_surface_picture shape = {.node_count = mesh->node_count,
                                      .face_count = mesh->quad_count,
                                      .rest = (const double(*)[3])mesh->position,
                                      .u = u,
                                      .face = (const int32_t(*)[4])mesh->quad,
                                      .colour = colour,
                                      .pushed = SS_PLANE_MIDDLE,
                                      .push = {0.0, 0.0, -1.0}};
    return ss_surface_picture_draw(
        zhang->paper, "tissue",
        "Two tissues: the right half (blue) eight times as stiff, pushed 5 h.", &shape, &view, 1,
        error);
}

softsim_status ss_zhang_tissue(ss_paper *paper, softsim_error *error)
{
    ss_zhang *zhang = paper->shared;
    static plane_field u, reference_u;
    double stiffness[SS_PLANE_NODES], step_s, force = 0.0;
    char reason[256];
    ss_zhang_reference reference;
    ss_page_text(&paper->page,
                 "The paper's introduction counts heterogeneous tissue among what a model must "
                 "take. Here: k 1 N/m in the left half of the plane, 8 in the right, the middle "
                 "line with the right one; pushed 5 h at %g h/C and held for %g C.",
                 pace, hold_s);
    for (int32_t i = 0; i < SS_PLANE_NODES; ++i) {
        stiffness[i] = zhang->plane.mesh->position[i][0] < -1e-9 ? soft_k : stiff_k;
    }
    softsim_status status = run_model(zhang, stiffness, &step_s, &force, u, reason, error);
    if (status == SOFTSIM_OK && reason[0] != '\0') {
        ss_paper_miss(paper, reason, "two tissues");
        return SOFTSIM_OK;
    }
    if (status == SOFTSIM_OK) {
        status = ss_zhang_plane_reference(&zhang->plane, SS_REFERENCE_KEEP, stiffness, &reference,
                                          error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_zhang_reference_go(&reference, depth_m, pace, step_s);
    ss_zhang_reference_hold(&reference, hold_s, step_s);
    for (int32_t i = 0; i < SS_PLANE_NODES; ++i) {
        ss_sub3(reference_u[i], reference.at[i], reference.rest[i]);
    }
    ss_claim_near(paper, "section 1", SS_FROM_CODE, reference.force, force, 1e-4,
                  "two tissues: force at the contact, N");
    ss_zhang_reference_fini(&reference);
    const double apart = ss_zhang_distance(SS_PLANE_NODES, (const double(*)[3])u,
                                           (const double(*)[3])reference_u, NULL);
    ss_claim_at_most(
        paper, "section 1", SS_FROM_CODE, 1e-4, apart,
        "two tissues: distance of the shape from the reference network's, over its size");
    const double left = -u[SS_PLANE_MIDDLE - 4][2], right = -u[SS_PLANE_MIDDLE + 4][2];
    ss_claim_at_least(paper, "section 1", SS_FROM_PAPER, 0.05, fabs(left - right) / depth_m,
                      "two tissues: the halves deform differently: difference 4 h left and right "
                      "of the contact, over the depth");
    return draw(zhang, (const double(*)[3])u, error);
}
