/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * What a plan uses and leaves out, and what it costs: counted work times a cost per unit measured
 * once on the reference core (Zen 5, float, AVX2), never a clock.
 */
#include <math.h>

#include "rt/note.h"

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
/* Of a step for its sub-steps where they can be chosen; s, a step that is not known yet. */
#define SUBSTEP_SHARE 0.25
#define MOST_SUBSTEPS 8.0
#define USUAL_STEP    1e-3
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

double ss_chain_planned_substeps(const ss_model_plan *plan)
{
    const double step = plan->step > 0.0 ? plan->step : USUAL_STEP;
    const double budget = plan->substep_budget > 0 ? plan->substep_budget : plan->max_substeps;
    const double most = fmin(MOST_SUBSTEPS, budget);
    return fmax(1.0, fmin(floor(SUBSTEP_SHARE * step * 1e6 / substep_cost_us(plan)), most));
}

double ss_chain_step_cost_us(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    const ss_param_value *capacitance = &plan->param[SS_CHAIN_CAPACITANCE_S];
    double substeps = ss_chain_planned_substeps(plan);
    if (capacitance->is_given && !capacitance->per_node) {
        const double valence = 2.0 * link_count(mesh) / mesh->node_count;
        substeps = ceil(USUAL_STEP * VALENCE_RATIO * 2.0 * valence / capacitance->number / 3.6);
    }
    return COST_STEP + substeps * substep_cost_us(plan) + COST_TOOL * ss_plan_tool_count(plan) +
           COST_TETRAHEDRON * mesh->tetrahedron_count;
}

/* ---- lines ---- */

static void explain_net(const ss_model *model, const ss_notes *out)
{
    const ss_chain_net *net = model->net;
    const ss_mesh *mesh = model->plan.mesh;
    ss_note_used(out, "chain",
                 "%d elements (%d fixed), %d links of %s, each once (%d of elements shared), mean "
                 "%.4g m, %.2f MB",
                 model->node_count, model->fixed_count, net->link_count,
                 mesh->tetrahedron_count > 0 ? "tetrahedra"
                 : mesh->quad_count > 0      ? "a rectangular grid"
                                             : "triangles",
                 net->duplicates, net->mean_length, (double)ss_chain_net_bytes(net) / 1048576.0);
    ss_note_used(out, "kernels", "%s, %s", model->kernels->name,
                 sizeof(ss_real) == sizeof(float) ? "single precision" : "double precision");
    if (ss_chain_is_aggregated(model)) {
        ss_note_used(out, "cells",
                     "the elements are aggregated into %d away from tools, which step every %.4g s",
                     ss_chain_coarse_cells(model->coarse), ss_chain_aggregated_step(model));
    } else if (model->coarse) {
        ss_note_used(out, "coarse level", "%d cells, %.2f MB", ss_chain_coarse_cells(model->coarse),
                     (double)ss_chain_coarse_bytes(model->coarse) / 1048576.0);
    } else {
        ss_note_left_out(out, "coarse level", "none asked for, or too few elements for one");
    }
    if (model->coarse || isfinite(model->saturation)) {
        ss_note_left_out(out, "active set", "%s touches every element",
                         ss_chain_is_aggregated(model) ? "an aggregated cell"
                         : model->coarse               ? "the coarse level"
                                                       : "saturation");
    } else {
        ss_note_used(out, "active set", "links that are slack and still are not looked at");
    }
    if (model->guard) {
        ss_note_used(out, "tet guard", "%d tetrahedra are kept above a fifth of their volume",
                     mesh->tetrahedron_count);
    } else {
        ss_note_left_out(out, "tet guard", "no tetrahedra, or tet_guard is 0");
    }
}

static void explain_material(const ss_model *model, const ss_notes *out)
{
    static const char *const unloading[] = {"falls with the contact's depth (ramp)",
                                            "is 0 once one goes back (literal)", "stays (keep)"};
    ss_note_used(out, "links", "k %.4g N/m, alpha %s; unloading: alpha %s", model->k,
                 model->has_alpha ? "as given" : "0", unloading[model->unloading]);
    if (model->leak > 0.0) {
        ss_note_used(out, "leak", "back to the rest shape in about %.3g s",
                     model->capacitance / model->leak);
    } else {
        ss_note_left_out(out, "leak", "what is slack stays where it was pushed");
    }
    if (!(model->leak > 0.0) && model->plan.mesh->tetrahedron_count == 0) {
        ss_note_used(out, "held press",
                     "its force fades (a surface of links has nothing inside and bends freely); "
                     "leak_resistance: 10 keeps most of it, less keeps more");
    }
    if (isfinite(model->saturation)) {
        ss_note_used(out, "saturation", "%.4g m", model->saturation);
    } else {
        ss_note_left_out(out, "saturation of cells", "none given");
    }
    ss_note_used(out, "capacitance",
                 "%.4g s (%s); stable step %.4g s, %.0f sub-steps of a step of %.4g s",
                 model->capacitance, model->is_capacitance_given ? "given" : "chosen for the step",
                 ss_chain_stable_step(model),
                 ceil(model->plan.step / ss_chain_stable_step(model) - 1e-9), model->plan.step);
    ss_tools_warn_unheld(&model->tools, model->is_held, out);
}

void ss_chain_explain(const ss_model *model, const ss_notes *out)
{
    explain_net(model, out);
    explain_material(model, out);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        if (tool->is_used) {
            ss_note_used(out, "contact.tools",
                         "tool %d: %s, contact %.4g N/m^3, %.4g N/m at first touch", k,
                         model->is_current ? "a current source" : "holds the cells it touches",
                         tool->stiffness, tool->rest_felt);
        }
    }
    if (model->is_current && model->plan.contact_stiffness > 0.0) {
        ss_note_warning(out, "contact.stiffness_n_per_m3",
                        "not used: with source: current the contact stiffness follows from "
                        "link_stiffness_n_per_m and the area of a cell; give source: position, or "
                        "leave the key out");
    }
    if (!model->tools.surface) {
        ss_note_left_out(out, "contact", "no tool");
    }
}
