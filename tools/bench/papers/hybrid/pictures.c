/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Figs. 3 and 4: the ventricles under a ball, and which part of the layer is awake.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/hybrid/draw.h"
#include "bench/papers/hybrid/hybrid.h"
#include "bench/papers/hybrid/reference.h"
#include "models/layer.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

static const uint32_t awake_colour = 0xd0605a, layer_colour = 0xd8b9a0, core_colour = 0x8fb3c9;

static void picture_fini(ss_heart_picture *p)
{
    SS_EACH(free, p->u, p->face, p->colour);
    *p = (ss_heart_picture){0};
}

/* The surface as it is; skin that rides on particles in red, tied skin light, the core's own faces
 * blue. */
static bool take_picture(const ss_heart_body *body, ss_heart_picture *out)
{
    const ss_mesh *mesh = body->mesh;
    const ss_real *u = body->model_class->displacement(body->model);
    const ss_model_layer *way = body->model_class->layer;
    const ss_layer *layer = way != NULL ? way->at_rest(body->model) : NULL;
    *out = (ss_heart_picture){.node_count = mesh->node_count,
                              .face_count = mesh->triangle_count,
                              .rest = mesh->position,
                              .u = calloc((size_t)mesh->node_count, sizeof *out->u),
                              .face = calloc((size_t)mesh->triangle_count, sizeof *out->face),
                              .colour = calloc((size_t)mesh->triangle_count, sizeof *out->colour)};
    if (out->u == NULL || out->face == NULL || out->colour == NULL) {
        picture_fini(out);
        return false;
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            out->u[i][a] = (double)u[4 * (ptrdiff_t)i + a];
        }
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        bool is_skin = true;
        bool is_riding = false;
        for (int k = 0; k < 3; ++k) {
            const int32_t node = mesh->triangle[t][k];
            const int32_t s = layer != NULL ? layer->skin_of[node] : -1;
            out->face[t][k] = node;
            is_skin = is_skin && s >= 0;
            is_riding = is_riding || (s >= 0 && way->share(body->model, s) > 0.5);
        }
        out->face[t][3] = -1;
        out->colour[t] = is_riding ? awake_colour : is_skin ? layer_colour : core_colour;
    }
    return true;
}

/* How far the middle of what is awake lies, at rest, from the ball's way along x; INFINITY: nothing
 * is. */
static double awake_aside(const ss_heart_body *body)
{
    const ss_model_layer *way = body->model_class->layer;
    const ss_layer *layer = way->at_rest(body->model);
    const double *ball = body->tool[0].to.position;
    double middle[3] = {0.0, 0.0, 0.0};
    int32_t count = 0;
    for (int32_t p = 0; p < layer->own_count; ++p) {
        if (way->is_awake(body->model, p)) {
            ss_add3(middle, middle, layer->rest[p]);
            ++count;
        }
    }
    ss_scale3(middle, middle, 1.0 / fmax(count, 1.0));
    return count > 0 ? hypot(middle[1] - ball[1], middle[2] - ball[2]) : (double)INFINITY;
}

static double deepest(const ss_heart_body *body)
{
    const ss_real *u = body->model_class->displacement(body->model);
    double most = 0.0;
    for (int32_t i = 0; i < body->mesh->node_count; ++i) {
        most = fmax(most, -(double)u[4 * (ptrdiff_t)i]);
    }
    return most;
}

/* ---- HM2 led, beside the report's reference elements ---- */

enum { LEAD_STEPS = 400, HOLD_STEPS = 800 };
static const double lead_m = 0.06, lead_reach = 0.2;

/* What fem does in a step of Table 1. */
static void reference_lead(ss_heart_reference *reference, const ss_heart_row *row, int32_t count,
                           const int32_t *patch)
{
    reference->phi = reference->psi = row->viscosity;
    reference->damping = 2.0;
    for (int32_t k = 0; k < count; ++k) {
        reference->is_held[patch[k]] = 1;
    }
    for (int32_t s = 1; s <= LEAD_STEPS + HOLD_STEPS; ++s) {
        for (int32_t k = 0; k < count; ++k) {
            const double before = reference->u[patch[k]][0];
            reference->u[patch[k]][0] = -lead_m * fmin(1.0, (double)s / LEAD_STEPS);
            reference->v[patch[k]][0] = (reference->u[patch[k]][0] - before) / row->step;
        }
        ss_heart_reference_run(reference, 1, row->step);
    }
}

static void claim_lead(ss_paper *paper, const ss_heart_body *body,
                       const ss_heart_reference *reference, int32_t count, const int32_t *patch)
{
    const ss_real *u = body->model_class->displacement(body->model);
    double apart = 0.0, whole = 0.0, reference_force = 0.0, force[3];
    for (int32_t k = 0; k < count; ++k) {
        reference_force -= reference->force[patch[k]][0];
    }
    for (int32_t i = 0; i < body->mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            const double d = (double)u[4 * (ptrdiff_t)i + a] - reference->u[i][a];
            apart += reference->mass[i] * d * d;
            whole += reference->mass[i] * reference->u[i][a] * reference->u[i][a];
        }
    }
    body->model_class->reaction(body->model, 0, force);
    ss_claim_near(paper, "Fig. 3", SS_FROM_CODE, reference_force, force[0], 0.02,
                  "HM2: a patch of %d nodes led in by %g: force on it after %d steps, N", count,
                  lead_m, LEAD_STEPS + HOLD_STEPS);
    ss_claim_at_most(paper, "Fig. 3", SS_FROM_CODE, 0.02, sqrt(apart / whole),
                     "HM2: distance of the shape from the reference elements', over its size");
}

/* The patch of HM2's outer wall at the ball's place, led inwards in a ramp and held, by fem and by
 * the report's reference elements on the same mesh with the same steps. */
static softsim_status lead_patch(ss_paper *paper, softsim_error *error)
{
    const ss_heart_row *row = &ss_heart_table[SS_HEART_HM2];
    const double x = 0.65 * sqrt(1.0 - 0.04 / 1.44), at[3] = {x, 0.0, -0.2};
    const double ramp_s = LEAD_STEPS * row->step;
    ss_heart_body body;
    ss_heart_reference reference = {.mesh = NULL};
    ss_mesh *mesh = ss_heart_ventricle(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, "fem", row, "base");
    ss_heart_set(&body, "locking_cure", 1.0); /* as the reference elements */
    int32_t *patch = calloc((size_t)mesh->node_count, sizeof *patch), count = 0;
    double(*way)[3] = calloc((size_t)mesh->node_count, sizeof *way);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (patch != NULL && way != NULL &&
        ss_heart_reference_init(&reference, body.mesh, row->lambda, row->mu, "base")) {
        for (int32_t i = 0; i < body.mesh->node_count; ++i) {
            const double *rest = body.mesh->position[i];
            double d[3];
            ss_sub3(d, rest, at);
            /* On the outer wall: x^2 + y^2 over 0.65^2 plus z^2 over 1.2^2 is 1. */
            const double level =
                (rest[0] * rest[0] + rest[1] * rest[1]) / 0.4225 + rest[2] * rest[2] / 1.44;
            if (level > 0.98 && !reference.is_held[i] && ss_norm3(d) < lead_reach) {
                ss_set3(way[count], -lead_m, 0.0, 0.0);
                patch[count++] = i;
            }
        }
        const ss_prescribed led = {.node = patch,
                                   .node_count = count,
                                   .displacement = way,
                                   .axis = {true, true, true},
                                   .ramp = ramp_s};
        body.plan.prescribed = &led;
        body.plan.prescribed_count = 1;
        status = ss_heart_start(&body, error);
        if (status == SOFTSIM_OK) {
            ss_heart_idle(&body, LEAD_STEPS + HOLD_STEPS);
            reference_lead(&reference, row, count, patch);
            claim_lead(paper, &body, &reference, count, patch);
        }
    } else {
        status = ss_memory_fault(error);
    }
    ss_heart_reference_fini(&reference);
    ss_heart_end(&body);
    free(patch);
    free(way);
    return status;
}

static softsim_status draw(ss_paper *paper, ss_heart_body *body, bool is_pressed, const char *name,
                           const char *caption, softsim_error *error)
{
    ss_heart_picture p;
    if (!take_picture(body, &p)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a picture");
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_copy3(p.ball, body->tool[0].to.position);
    p.radius = is_pressed ? 0.2 : 0.0;
    const softsim_status status = ss_heart_draw(paper, name, caption, &p, error);
    picture_fini(&p);
    return status;
}

static softsim_status press_and_draw(ss_paper *paper, bool is_hybrid, softsim_error *error)
{
    ss_heart_body body;
    const double x = 0.65 * sqrt(1.0 - 0.04 / 1.44);
    double to[3] = {x + 0.21, 0.0, -0.2};
    ss_mesh *mesh = is_hybrid ? ss_heart_layered(paper, error) : ss_heart_ventricle(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    ss_heart_init(&body, mesh, is_hybrid ? "hybrid" : "fem",
                  &ss_heart_table[is_hybrid ? SS_HEART_HM1 : SS_HEART_HM2], "base");
    ss_heart_set(&body, "mass_damping_per_s", is_hybrid ? 6.0 : 2.0);
    ss_heart_set_layer(&body, 0.027, 0.3, 600.0);
    softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        (void)ss_heart_move(&body, to, 10);
        if (is_hybrid) {
            status = draw(paper, &body, false, "fig4-rest",
                          "Fig. 4: HM1 at rest. Blue: the core's own faces, endocardium and base; "
                          "light: the wall that rides on the sleeping layer; red: on particles "
                          "that the ball just before it has woken.",
                          error);
        }
        /* Plain tetrahedra of HM2's moduli turn over where a hybrid bends. */
        to[0] = x + 0.2 - (is_hybrid ? 0.2 : 0.06);
        (void)ss_heart_move(&body, to, 120);
        (void)ss_heart_move(&body, to, 120);
    }
    if (status == SOFTSIM_OK) {
        status = draw(paper, &body, true, is_hybrid ? "fig4-pressed" : "fig3",
                      is_hybrid ? "Fig. 4: HM1 with a ball of 0.2 pressed in by 0.2, 600 of 28,000 "
                                  "particles awake (red)."
                                : "Fig. 3: HM2, the ventricle filled with tetrahedra, under the "
                                  "same ball pressed in by 0.06.",
                      error);
    }
    if (status == SOFTSIM_OK && is_hybrid) {
        double force[3];
        ss_heart_force(&body, force);
        ss_claim_at_most(paper, "Fig. 4", SS_FROM_PAPER, 0.5 * 0.2, awake_aside(&body),
                         "HM1: the activated particles are those at the tool: their middle from "
                         "the ball's way (%d awake, %.3g N)",
                         ss_heart_awake(&body), force[0]);
        ss_claim_at_least(paper, "Fig. 4", SS_FROM_PAPER, 0.8 * 0.2, deepest(&body),
                          "HM1: the surface goes with the ball pressed in by 0.2: largest "
                          "displacement of a node");
    }
    ss_heart_end(&body);
    return status;
}

softsim_status ss_heart_pictures(ss_paper *paper, softsim_error *error)
{
    softsim_status status = lead_patch(paper, error);
    if (status == SOFTSIM_OK) {
        status = press_and_draw(paper, false, error);
    }
    ss_paper_progress(paper, 0.5);
    return status == SOFTSIM_OK ? press_and_draw(paper, true, error) : status;
}
