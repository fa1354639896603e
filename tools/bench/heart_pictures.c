/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Figs. 3 and 4: the ventricles under a ball, and which part of the layer is awake.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "heart.h"
#include "heart_draw.h"
#include "models/hybrid.h"
#include "rt/vec.h"

static const uint32_t awake_colour = 0xd0605a, layer_colour = 0xd8b9a0, core_colour = 0x8fb3c9;

static void picture_fini(ss_heart_picture *p)
{
    free(p->u);
    free(p->face);
    free(p->colour);
    *p = (ss_heart_picture){0};
}

/* The surface as it is; skin that rides on particles in red, tied skin light, the core's own faces
 * blue. */
static bool take_picture(const ss_heart_body *body, bool is_hybrid, ss_heart_picture *out)
{
    const ss_mesh *mesh = body->mesh;
    const ss_real *u = body->model_class->displacement(body->model);
    const ss_hybrid *hybrid = is_hybrid ? (const ss_hybrid *)body->model : NULL;
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
            const int32_t s = hybrid != NULL ? hybrid->layer->skin_of[node] : -1;
            out->face[t][k] = node;
            is_skin = is_skin && s >= 0;
            is_riding = is_riding || (s >= 0 && hybrid->ride[s].theta > (ss_real)0.5);
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
    const ss_hybrid *hybrid = (const ss_hybrid *)body->model;
    const double *ball = body->tool[0].to.position;
    double middle[3] = {0.0, 0.0, 0.0};
    int32_t count = 0;
    for (int32_t p = 0; p < hybrid->layer->own_count; ++p) {
        if (hybrid->node_of[p] >= 0) {
            ss_add3(middle, middle, hybrid->layer->rest[p]);
            ++count;
        }
    }
    ss_scale3(middle, middle, 1.0 / fmax(count, 1.0));
    return count > 0 ? hypot(middle[1] - ball[1], middle[2] - ball[2]) : (double)INFINITY;
}

static softsim_status draw(ss_paper *paper, ss_heart_body *body, bool is_hybrid, bool is_pressed,
                           const char *name, const char *caption, softsim_error *error)
{
    ss_heart_picture p;
    if (!take_picture(body, is_hybrid, &p)) {
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
    ss_heart_set(&body, "layer.spacing_m", 0.027);
    ss_heart_set(&body, "layer.activate_m", 0.3);
    ss_heart_set(&body, "layer.max_active", 600.0);
    softsim_status status = ss_heart_start(&body, error);
    if (status == SOFTSIM_OK) {
        (void)ss_heart_move(&body, to, 10);
        if (is_hybrid) {
            status = draw(paper, &body, true, false, "fig4-rest",
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
        status = draw(paper, &body, is_hybrid, true, is_hybrid ? "fig4-pressed" : "fig3",
                      is_hybrid ? "Fig. 4: HM1 with a ball of 0.2 pressed in by 0.2, 600 of 28,000 "
                                  "particles awake (red)."
                                : "Fig. 3: HM2, the ventricle filled with tetrahedra, under the "
                                  "same ball pressed in by 0.06.",
                      error);
    }
    if (status == SOFTSIM_OK) {
        double force[3];
        char measured[240];
        ss_heart_force(&body, force);
        snprintf(measured, sizeof measured, "%s; %.3g N", body.reason, force[0]);
        bool is_good = body.worst < SOFTSIM_VERDICT_DEGRADED && force[0] > 0.0;
        if (is_hybrid) {
            const double aside = awake_aside(&body);
            const int32_t awake = ss_heart_awake(&body);
            snprintf(measured, sizeof measured,
                     "%s; %.3g N; %d awake, their middle %.2g from the ball's way", body.reason,
                     force[0], awake, aside);
            is_good = is_good && awake > 300 && aside < 0.5 * 0.2;
        }
        ss_claim_add(paper, is_hybrid ? "Fig. 4" : "Fig. 3",
                     is_good ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
                     "deforms under a tool, see the picture", measured, "the ventricle %s",
                     is_hybrid ? "HM1, hybrid" : "HM2, tetrahedra");
    }
    ss_heart_end(&body);
    return status;
}

softsim_status ss_heart_pictures(ss_paper *paper, softsim_error *error)
{
    const softsim_status status = press_and_draw(paper, false, error);
    ss_paper_progress(paper, 0.5);
    return status == SOFTSIM_OK ? press_and_draw(paper, true, error) : status;
}
