/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/* What a step of the hybrid costs, and what it says of itself. */
#include <math.h>

#include "mesh/tetrahedron.h"
#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/note.h"
#include "rt/vec.h"

/* ---- cost ---- */

/* Microseconds a sub-step of an element, of a particle awake with its tied neighbours, and of an
 * outer step with its tool. */
#define COST_ELEMENT  0.008
#define COST_PARTICLE 0.25
#define COST_STEP     20.0

double ss_hybrid_step_cost_us(const ss_model_plan *plan)
{
    ss_arena arena = {0};
    ss_fem_material material;
    double cost = COST_STEP;
    if (ss_fem_material_create(plan, "hybrid", &arena, &material, NULL) == SOFTSIM_OK) {
        double rate = 0.0;
        const double spacing = plan->param[SS_HYBRID_SPACING].number;
        for (int32_t e = 0; e < plan->mesh->tetrahedron_count; ++e) {
            const int32_t *c = plan->mesh->tetrahedron[e];
            const double(*x)[3] = (const double(*)[3])plan->mesh->position;
            double gradient[4][3];
            double largest = isfinite(spacing) ? 1.0 / spacing : 0.0;
            (void)ss_tetrahedron_gradients(x[c[0]], x[c[1]], x[c[2]], x[c[3]], gradient);
            for (int a = 0; a < 4; ++a) {
                largest = fmax(largest, ss_norm3(gradient[a]));
            }
            rate = fmax(rate, largest * sqrt((material.lambda[e] + 2.0 * material.mu[e]) /
                                             material.density[e]));
        }
        cost += ss_fem_planned_sweeps(&material, ss_plan_cost_step(plan), 2.0 * rate,
                                      SS_HYBRID_STEP_SHARE) *
                (COST_ELEMENT * plan->mesh->tetrahedron_count +
                 COST_PARTICLE * plan->param[SS_HYBRID_MAX_ACTIVE].number);
    }
    ss_arena_free(&arena);
    return cost;
}

/* ---- words ---- */

enum { PRESSES = 64 }; /* places that are looked at, evenly over the skin */

/* The most particles that a ball of radius `radius`, pressed in by half of it, comes nearer to than
 * wake_reach. */
static int32_t most_near(const ss_hybrid *hybrid, const double (*area)[3], double radius)
{
    const ss_layer *layer = hybrid->layer;
    const double reach = radius + hybrid->wake_reach;
    int32_t most = 0;
    for (int32_t place = 0; place < PRESSES; ++place) {
        const int32_t i = layer->skin_node[(int64_t)place * layer->skin_count / PRESSES];
        double out[3], middle[3];
        int32_t count = 0;
        ss_copy3(out, area[i]);
        if (!(ss_normalize3(out) > 0.0)) {
            continue;
        }
        ss_madd3(middle, hybrid->mesh->position[i], 0.5 * radius, out);
        for (int32_t p = 0; p < layer->own_count; ++p) {
            double way[3];
            ss_sub3(way, layer->rest[p], middle);
            count += ss_dot3(way, way) < reach * reach;
        }
        most = count > most ? count : most;
    }
    return most;
}

/* Where max_active may leave particles near a tool asleep. */
static void explain_cap(const ss_hybrid *hybrid, const ss_notes *out)
{
    const double limit = ss_hybrid_most_wanted(hybrid);
    double(*area)[3] = ss_memory_get((size_t)hybrid->mesh->node_count, sizeof *area);
    if (area != NULL) {
        ss_mesh_node_area_vectors(hybrid->mesh, area);
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES && area != NULL; ++k) {
        if (!hybrid->shape[k].is_used) {
            continue;
        }
        const double radius = ss_shape_inradius(&hybrid->shape[k].shape);
        const int32_t near = most_near(hybrid, (const double(*)[3])area, radius);
        if (near > limit) {
            ss_note_warning(out, "model.layer.max_active",
                            "tool %d, pressed in by %.3g m, comes within layer.activate_m of up to "
                            "%d particles, and layer.max_active wakes %.0f: the others follow the "
                            "core; raise it, or wake from nearer",
                            k, 0.5 * radius, near, floor(limit));
        }
    }
    ss_memory_free(area);
}

void ss_hybrid_explain(const ss_model *model, const ss_notes *out)
{
    const ss_hybrid *hybrid = (const ss_hybrid *)model;
    const ss_layer *layer = hybrid->layer;
    ss_note_used(
        out, "layer",
        "%d particles in %d cells, %d ghosts in the core, spacing %.4g m%s, %d pairs, kernels %s",
        layer->own_count, hybrid->cells.count, layer->count - layer->own_count, layer->spacing[0],
        hybrid->least_spacing < layer->spacing[0] ? " and finer" : "",
        layer->pair_first[layer->count], hybrid->kernels->name);
    if (layer->dropped_count > 0) {
        ss_note_used(out, "layer", "%d places with too few neighbours were left empty",
                     layer->dropped_count);
    }
    if (hybrid->is_all_awake) {
        ss_note_used(out, "activation", "none, all particles are awake always");
    } else {
        ss_note_used(out, "activation",
                     "within %.4g m of a tool, until %.4g m, at most %d particles and %d with "
                     "their neighbours; the rest is counted with the core",
                     hybrid->wake_reach, hybrid->sleep_reach, hybrid->max_awake,
                     hybrid->max_points);
        explain_cap(hybrid, out);
    }
    ss_note_used(out, "skin", "%d nodes ride on the particles%s; stable step %.4g s at rest",
                 layer->skin_count,
                 hybrid->held_skin > 0 ? ", those that are fixed on the core below them" : "",
                 ss_body_step_limit(hybrid->material.integrator, hybrid->rest_rate2,
                                    hybrid->material.viscous_time, hybrid->material.mass_damping));
    if (layer->far_count > 0) {
        ss_note_warning(
            out, "model.layer",
            "%d of %d nodes of the surface are so far from the core's small elements that they "
            "repeat its motion up to %.0f-fold; make the core coarser or the layer thinner",
            layer->far_count, layer->skin_count, layer->farthest_tie);
    }
    if (hybrid->is_locking) {
        ss_note_warning(
            out, "model.poisson_ratio",
            "Poisson's ratio above 0.45, where plain tetrahedra are too stiff; the cure is for "
            "whole volumes, and the layer takes part of the core's: left out");
    }
    if (!(hybrid->cohesion > 0.0)) {
        ss_note_left_out(out, "cohesion", "model.layer.lennard_jones_share=1e-30",
                         "lennard_jones_share 0");
    }
    ss_body_explain(hybrid->body, out);
}
