/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * What a plan costs: counted work times a cost per unit measured once on the reference core (Zen 5,
 * float, AVX2), never a clock.
 */
#include <math.h>

/* Microseconds a step, a link and a node in a sub-step, the coarse level and a node in it, a
 * tetrahedron looked at, a tool in a sub-step and in a step. */
#define COST_STEP        0.5
#define COST_LINK        0.0017
#define COST_NODE        0.0008
#define COST_COARSE      2.0
#define COST_COARSE_NODE 0.0025
#define COST_TETRAHEDRON 0.0012
#define COST_TOUCH       10.0
#define COST_TOOL        25.0
/* s: a step that is not known yet, and what sub-steps are chosen for; of the time that they
 * simulate, how much they may take; the most in a usual step. */
#define USUAL_STEP    1e-3
#define SUBSTEP_SHARE 0.25
#define MOST_SUBSTEPS 8.0
/* Valences of the busiest neighbours of a link over twice the mean valence, on organs. */
#define VALENCE_RATIO 2.2

/* Links of the mesh: of a volume by Euler's formula, else half the sides of a closed surface. */
static double link_count(const ss_mesh *mesh)
{
    return mesh->tetrahedron_count > 0
               ? mesh->node_count + mesh->tetrahedron_count + 0.5 * mesh->triangle_count
           : mesh->quad_count > 0 ? 2.0 * mesh->quad_count
                                  : 1.5 * mesh->triangle_count;
}

static bool has_coarse(const ss_model_plan *plan)
{
    const ss_param_value *coarse = &plan->param[SS_CHAIN_COARSE_CELLS];
    return coarse->is_given ? coarse->number > 0.0 : plan->mesh->tetrahedron_count > 0;
}

static double substep_cost_us(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    return COST_LINK * link_count(mesh) + COST_NODE * mesh->node_count +
           (has_coarse(plan) ? COST_COARSE + COST_COARSE_NODE * mesh->node_count : 0.0) +
           COST_TOUCH * ss_plan_tool_count(plan);
}

double ss_chain_planned_substep(const ss_model_plan *plan)
{
    const double budget = plan->substep_budget > 0 ? plan->substep_budget : plan->max_substeps;
    const double cost = ss_plan_yardstick(plan) * substep_cost_us(plan) / SUBSTEP_SHARE;
    const double count = fmin(floor(1e6 * USUAL_STEP / cost), MOST_SUBSTEPS);
    const double wanted = count >= 1.0 ? USUAL_STEP / count : 1e-6 * cost;
    return fmax(wanted, plan->step / budget);
}

double ss_chain_step_cost_us(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    const ss_param_value *capacitance = &plan->param[SS_CHAIN_CAPACITANCE_S];
    const double step = plan->step > 0.0 ? plan->step : USUAL_STEP;
    double substeps = ceil(step / ss_chain_planned_substep(plan) - 1e-9);
    if (capacitance->is_given && !capacitance->per_node) {
        const double valence = 2.0 * link_count(mesh) / mesh->node_count;
        substeps = ceil(step * VALENCE_RATIO * 2.0 * valence / capacitance->number / 3.6);
    }
    return COST_STEP + substeps * substep_cost_us(plan) + COST_TOOL * ss_plan_tool_count(plan) +
           COST_TETRAHEDRON * mesh->tetrahedron_count;
}
