/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * What a plan uses and leaves out, what it costs, and how stiff its contacts are.
 *
 * The cost of a step is counted work times a cost per unit measured once on the reference core
 * (Zen 5, float, AVX2), never a clock: rates chosen from it are the same on every machine.
 */
#include <math.h>

#include "rt/note.h"
#include "rt/vec.h"

/* Steps are stable up to dt omega = 2.6 whatever the damping; contact may use 0.3 of omega^2 of a
 * sub-step. A contact that is softer at a lower rate would be another scene, and the surface slips
 * past a tool at a few newtons: a step in contact is planned to take a sub-step each 0.2 ms, as far
 * as half of its time has room for them by the costs below. Rejected: five whatever the step, which
 * left a kidney at 60 Hz a 260th of the stiffness and a third of the force. At least five, since
 * contact costs little more than one; at most 0.6 of what simulation.max_substeps allows, since a
 * firm press takes half as many again. */
#define CONTACT_SHARE        0.3
#define CONTACT_SUBSTEP_S    2e-4
#define CONTACT_SUBSTEPS     5.0
#define CONTACT_BUDGET_SHARE 0.6
#define CONTACT_TIME_SHARE   0.5
#define RK4_RADIUS           2.6
/* rho beside rho under a tool, where the contact starts to soften. */
#define RHO_RATIO_WARNING 4.0

/* Microseconds a step, a node in it, an edge of each source, a tool and an edge under it: medians
 * of 422 to 1192 nodes, with one load, and with a sphere of R = 5 mm that slides and is asked for
 * its contacts. */
#define COST_STEP        0.5
#define COST_NODE        0.011
#define COST_SOURCE_EDGE 0.0025
#define COST_TOOL        12.0
#define COST_TOOL_EDGE   0.0234
/* Each further sub-step of a contact, against the first: weights, columns and contacts once a step;
 * five take 2.3 times one. */
#define COST_SUBSTEP 0.325

enum { MOST_BODIES = 8 }; /* with an enclosed volume: told one by one */

/* Edges of the network: half the sides of a closed surface; of a volume by Euler's formula. */
static double edge_count(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    const bool is_volume = plan->param[SS_CNN_DOMAIN].number != 0.0;
    return is_volume ? mesh->node_count + mesh->tetrahedron_count + 0.5 * mesh->triangle_count
           : mesh->quad_count > 0 ? 2.0 * mesh->quad_count
                                  : 1.5 * mesh->triangle_count;
}

/* With the network in its own time: a node of each cell in use, for a network step and for its
 * column; on plates of 400 and 1156 nodes, 26 to 111 cells under a tool, 1 to 100 steps. */
#define COST_NETWORK_STEP 0.00075
#define COST_COLUMN       0.0025

/* Cells under a tool of radius R pressed in by about R: twice those that one would reach that just
 * touches flat ground. */
static double touched_cells(const ss_model_plan *plan, const ss_shape *shape)
{
    const ss_mesh *mesh = plan->mesh;
    double area = 0.0;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double n[3];
        ss_normal3(n, mesh->position[c[0]], mesh->position[c[1]], mesh->position[c[2]]);
        area += 0.5 * ss_norm3(n);
    }
    const double share = area / mesh->node_count, edge = 1.1 * sqrt(share);
    const double radius = ss_shape_curvature_radius(shape);
    const double reach = plan->contact_reach > 0.0 ? plan->contact_reach : fmax(edge, 0.5 * radius);
    const double cells = 6.28318530717959 * reach * (2.0 * radius + reach) / share;
    return fmin(fmax(cells, 1.0), mesh->node_count);
}

/* A sub-step of the network in its own time. */
static double network_cost_us(const ss_model_plan *plan)
{
    const bool is_one_cell = plan->param[SS_CNN_SOURCE].number != 0.0;
    double cells = 0.0;
    for (int32_t k = 0; k < plan->load_count; ++k) {
        const double loaded = is_one_cell ? 1.0 : plan->load[k].node_count;
        cells += ss_load_pushes(&plan->load[k]) ? loaded : 0.0;
    }
    for (int32_t k = 0; k < plan->prescribed_count; ++k) {
        cells += is_one_cell ? 1.0 : plan->prescribed[k].node_count;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            cells += is_one_cell ? 1.0 : touched_cells(plan, &plan->tool[k].shape);
        }
    }
    const double lanes = SS_CNN_RELAX_WIDTH * ceil(cells / SS_CNN_RELAX_WIDTH);
    return lanes * plan->mesh->node_count *
           (COST_COLUMN + COST_NETWORK_STEP * plan->param[SS_CNN_RELAXATION_STEPS].number);
}

/* A step without its contacts, and what contacts add: a first sub-step, and each further one. */
static double free_cost_us(const ss_model_plan *plan, double *out_contact, double *out_substep)
{
    const double nodes = plan->mesh->node_count, edges = edge_count(plan);
    const int32_t tools = ss_plan_tool_count(plan);
    double sources = plan->prescribed_count;
    for (int32_t k = 0; k < plan->load_count; ++k) {
        sources += ss_load_pushes(&plan->load[k]);
    }
    const bool is_relaxed = plan->param[SS_CNN_SOLVER].number != 0.0;
    const double network = is_relaxed ? network_cost_us(plan) : 0.0;
    *out_contact = tools * (COST_TOOL + COST_TOOL_EDGE * edges);
    *out_substep = tools > 0 ? network + COST_SUBSTEP * *out_contact : 0.0;
    return network + COST_STEP + COST_NODE * nodes + COST_SOURCE_EDGE * edges * sources;
}

/* Sub-steps that a step in contact is planned to take. */
static double contact_substeps(const ss_model_plan *plan)
{
    double contact = 0.0, substep = 0.0;
    const double rest = free_cost_us(plan, &contact, &substep);
    const double room_us =
        CONTACT_TIME_SHARE * 1e6 * plan->step / ss_plan_yardstick(plan) - rest - contact;
    const double affordable = substep > 0.0 ? 1.0 + room_us / substep : (double)INFINITY;
    const double budget = plan->substep_budget > 0 ? plan->substep_budget : plan->max_substeps;
    const double most = CONTACT_BUDGET_SHARE * budget;
    return fmax(CONTACT_SUBSTEPS, fmin(fmin(plan->step / CONTACT_SUBSTEP_S, affordable), most));
}

double ss_cnn_contact_stiffness(const ss_model_plan *plan, double sigma, double radius)
{
    const double rate = RK4_RADIUS * contact_substeps(plan) / plan->step;
    return ss_plan_contact_stiffness(plan, CONTACT_SHARE * sigma * rate * rate, radius);
}

double ss_cnn_step_cost_us(const ss_model_plan *plan)
{
    double contact = 0.0, substep = 0.0;
    const double rest = free_cost_us(plan, &contact, &substep);
    return rest + contact + (contact_substeps(plan) - 1.0) * substep;
}

/* ---- lines ---- */

static double megabytes(double bytes)
{
    return bytes / 1048576.0;
}

static void explain_relaxation(const ss_cnn_relax *relax, const ss_notes *out)
{
    const double good = ss_cnn_relax_steps_to(relax, 1e-3);
    const double exact = ss_cnn_relax_steps_to(relax, 1e-6);
    ss_note_used(
        out, "network in its own time",
        "(C = 1) step %.4g, slowest time constant %.4g, %d steps a "
        "sub-step; a cell just touched is settled to 1e-3 after %.0f steps (%.0f sub-steps), to "
        "1e-6 after %.0f",
        relax->step, relax->time_constant, relax->steps, good, ceil(good / relax->steps), exact);
    ss_note_used(out, "network states", "at most %d cells, %.1f MB", relax->cell_count,
                 megabytes((double)relax->bytes));
}

static void explain_network(const ss_model *model, const ss_notes *out)
{
    const ss_cnn_network *network = model->network;
    static const char *const carrier[] = {[SS_CNN_TRIANGLE] = "triangles",
                                          [SS_CNN_QUAD] = "a rectangular grid",
                                          [SS_CNN_TETRAHEDRON] = "tetrahedra"};
    const bool is_volume = model->material.element == SS_CNN_TETRAHEDRON;
    int32_t held = 0, inner = 0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        held += model->held[i] && network->size[i] > 0.0;
        inner += !(network->surface_area[i] > 0.0);
    }
    ss_note_used(out, "network",
                 "%d cells on %s (%d held at zero), %d edges, mean edge %.4g m, %d part%s, %.2f MB",
                 network->cell_count, carrier[model->material.element], held, network->edges.count,
                 network->mean_edge, network->component_count,
                 network->component_count == 1 ? "" : "s",
                 megabytes((double)ss_cnn_network_bytes(network)));
    if (is_volume) {
        ss_note_used(out, "volume", "%d cells inside, which no tool or load touches", inner);
    } else if (inner > 0) {
        ss_note_left_out(out, "inner nodes", NULL,
                         "%d of the volume mesh, at rest: domain is surface", inner);
    }
    if (model->relax) {
        explain_relaxation(model->relax, out);
    } else {
        ss_note_left_out(out, "the network's own time", NULL, "solver is equilibrium");
    }
    if (model->relax) {
        ss_note_left_out(out, "settled influence functions", NULL, "solver is relaxation");
    } else if (network->influence_count > 0) {
        ss_note_used(out, "influence functions", "%d, %s, %.1f MB", network->influence_count,
                     network->is_compact ? "as potentials, rebuilt when a cell is touched"
                                         : "as flux densities",
                     megabytes((double)ss_cnn_network_influence_bytes(network)));
    }
    const ss_cnn_factor *factor = network->factor;
    if (factor->is_given_up) {
        ss_note_used(out, "solver",
                     "conjugate gradients; a factor would have %.3g entries and take %.2g "
                     "multiplications, above the limit",
                     factor->ldl.fill, factor->ldl.work);
    } else {
        ss_note_used(out, "solver", "a factor of %.3g entries, which took %.2g multiplications",
                     factor->ldl.fill, factor->ldl.work);
    }
    if (model->set) {
        ss_note_used(
            out, "active set",
            "%d blocks of %d nodes, %d active at rest, tolerance %g of the largest displacement",
            model->set->block_count, model->set->block_size, model->set->active_nodes,
            model->set->tolerance);
    } else {
        ss_note_left_out(out, "active set", NULL, "%s", model->no_set_reason);
    }
    ss_note_used(out, "kernels", "%s, %s", model->kernels->name,
                 sizeof(ss_real) == sizeof(float) ? "single precision" : "double precision");
}

static void explain_modulus(const ss_model *model, const ss_notes *out)
{
    const ss_cnn_material *m = &model->material;
    const bool is_volume = m->element == SS_CNN_TETRAHEDRON;
    const char *unit = is_volume ? "Pa" : "N/m";
    const double qhat = model->network->median_qhat;
    if (qhat > 0.0) {
        ss_note_used(out, "modulus", "%.6g J, which is %.6g %s on this mesh (median Qhat %.6g %s)",
                     m->is_modulus_energy ? m->modulus : m->modulus * qhat,
                     m->is_modulus_energy ? m->modulus / qhat : m->modulus, unit, qhat,
                     is_volume ? "m^3" : "m^2");
    } else {
        ss_note_used(out, "modulus", "%.6g %s", m->modulus, m->is_modulus_energy ? "J" : unit);
    }
}

static void explain_rho(const ss_model *model, const ss_notes *out)
{
    const ss_cnn_material *m = &model->material;
    double low = (double)INFINITY, high = 0.0;
    for (int32_t i = 0; m->rho_across && i < model->node_count; ++i) {
        if (model->network->size[i] > 0.0) {
            low = fmin(low, m->rho_across[i] / m->rho[i]);
            high = fmax(high, m->rho_across[i] / m->rho[i]);
        }
    }
    if (m->rho_across) {
        ss_note_used(out, "anisotropic",
                     "rho across the material direction is %.4g to %.4g times that along", low,
                     high);
    }
}

static void explain_material(const ss_model *model, const ss_notes *out)
{
    const ss_cnn_material *m = &model->material;
    explain_modulus(model, out);
    explain_rho(model, out);
    if (m->pretension > 0.0) {
        ss_note_used(out, "pretension", "%.6g J", m->pretension);
    }
    if (model->normal) {
        for (int32_t k = 0; k < model->enclosed_count && k < MOST_BODIES; ++k) {
            ss_note_used(out, "enclosed volume", "%.6g m^3, %.6g Pa", model->enclosed[k].volume,
                         m->bulk);
        }
        if (model->enclosed_count > MOST_BODIES) {
            ss_note_used(out, "enclosed volume", "and %d bodies more, with a volume each",
                         model->enclosed_count - MOST_BODIES);
        }
    } else {
        const bool may_be = model->is_held && model->plan.mesh->is_closed;
        ss_note_left_out(out, "enclosed volume", may_be ? "model.enclosed_bulk_pa=1e-30" : NULL,
                         "enclosed_bulk_pa is 0");
    }
    if (isfinite(m->saturation)) {
        ss_note_used(out, "saturation", "cells at %.6g%s", m->saturation,
                     model->saturation ? ", shared by the sources without a tool" : "");
    }
    if (model->is_one_cell) {
        ss_note_used(out, "source",
                     "the contact cell alone; under a tool it stays where the touch began");
    }
    if (model->is_held) {
        ss_note_left_out(out, "rigid fit of the rest shape", NULL, "the supports hold the body");
    } else {
        ss_note_used(out, "rest shape",
                     "follows the body's rigid motion (too few supports to hold it)");
    }
}

static void warn_rho(const ss_model *model, const ss_notes *out)
{
    const ss_cnn_network *network = model->network;
    int32_t soft = 0, first = -1;
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (network->is_source[i] &&
            network->largest_rho > RHO_RATIO_WARNING * ss_cnn_best_rho(&model->material, i)) {
            first = soft++ == 0 ? i : first;
        }
    }
    if (soft > 0) {
        ss_note_warning(out, "model.rho",
                        "rho of %d nodes (first %d) is more than %g times below the largest: "
                        "contact there is soft, and a load where it is ten times below is refused",
                        soft, ss_mesh_file_node(model->plan.mesh, first), RHO_RATIO_WARNING);
    }
}

static void explain_tools(const ss_model *model, const ss_notes *out)
{
    const ss_model_plan *plan = &model->plan;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        if (!tool->is_used) {
            continue;
        }
        ss_note_used(
            out, "contact.tools",
            "tool %d: contact %.4g N/m^3, source reach %.4g m, penetration %.3g m at %.3g N, "
            "%.4g N/m at rest",
            k, tool->stiffness, tool->delta, ss_tool_largest_depth(tool, plan), plan->max_force,
            tool->rest_felt);
        ss_tool_say_limits(tool, k, plan, model->network->mean_edge, out);
    }
    ss_tools_warn_rounded(&model->tools, plan, out);
    if (model->tools.surface) {
        ss_note_used(out, "contact", "%lld samples",
                     (long long)ss_surface_sample_count(model->tools.surface));
        ss_tools_say_friction(plan, out);
        ss_tools_say_grasp(plan, out);
    }
}

void ss_cnn_explain(const ss_model *model, const ss_notes *out)
{
    explain_network(model, out);
    explain_material(model, out);
    warn_rho(model, out);
    explain_tools(model, out);
    ss_note_used(out, "sources without a tool",
                 "%d; stable step at rest %.4g s, sub-steps of at most 0.7 of it",
                 model->source_count, model->bound);
    ss_plan_say_substeps(&model->plan, 0.7 * model->bound, out);
}
