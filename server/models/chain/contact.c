/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * Tools on the chain: which cells a tool holds, where, and what it feels.
 *
 * The paper moves one contact point by the input displacement. A tool touches a surface: its
 * samples x_q = sum_i B_qi P_i inside the tool are to be put back on its skin. Cell i is asked to
 * move by f_i/D_i, with f_i = sum_q A_q kc B_qi c(d_q) n_q and D_i = sum_q A_q kc B_qi c'(d_q)
 * (contact/query.c has c), and is held there as firmly as D_i is beside its links. That is the mean
 * of its samples' depths where none is deeper than 0.3 r, r the tool's inradius; c is so much
 * harder beyond that one which is comes up to 0.27 r and all the way in the next sub-step:
 *
 *   u_i += tau_i (dP_i + f_i/(2 k) - u_i/R_rest),  1/tau_i = C_i/h + D_i/(2 k)
 *
 * For D_i >> 2 k C_i/h the cell goes where the tool puts it (a fixed-state cell), for D_i -> 0 it
 * is free: a cell enters and leaves a contact through D_i = 0, so neither position nor force jumps
 * as a tool slides, and nothing is held when the tool pulls away: f is unilateral. The step
 * stays a descent whatever kc is: the Hessian H of W + U/(2 k) has x'Hx <= x'(L/2 + D/(2 k)) x
 * (rows of B sum to 1, the tool is convex), below x'(2/tau) x wherever h is stable without contact.
 * Rejected: nodes set onto the tool's skin (a sphere of 10 mm sinks 3 mm between nodes 12 mm
 * apart, and ripples as much as it slides), an explicit penalty (kc would have to be so soft that
 * the tool sinks in).
 *
 * `source: position`: kc from the working force, as for every model, and at least twice the links'
 * own stiffness. `source: current`: kc = 2 k/a, a the mean area of a cell, so that a covered cell's
 * current f_i/(2 k) is the tool's depth there: the paper's "current source set to the input
 * displacement", a drive of force.
 */
#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- set-up ---- */

/* Of the nodes that lie on the surface, m^2; negative without memory. */
static double mean_area(const ss_mesh *mesh)
{
    double area = 0.0, count = 0.0;
    double *of = ss_memory_get((size_t)mesh->node_count, sizeof *of);
    if (!of) {
        return -1.0;
    }
    ss_mesh_node_areas(mesh, of);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        area += of[i];
        count += of[i] > 0.0;
    }
    ss_memory_free(of);
    return area / fmax(count, 1.0);
}

/* kc, N/m^3. */
static double contact_stiffness(const ss_model *model, double radius, double area)
{
    const ss_model_plan *plan = &model->plan;
    if (model->is_current) {
        return 2.0 * model->k / area;
    }
    if (plan->contact_stiffness > 0.0) {
        return plan->contact_stiffness;
    }
    double valence = 0.0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        valence += model->valence[i] / model->node_count;
    }
    /* A contact softer than the links would not hold its cells. There is no upper bound, as models
     * with an explicit penalty need it: this step is stable whatever kc is. */
    return fmax(ss_plan_working_stiffness(plan, radius), 2.0 * model->k * valence / area);
}

static softsim_status create_tool(ss_model *model, int index, double area)
{
    const ss_model_plan *plan = &model->plan;
    const ss_shape *shape = &plan->tool[index].shape;
    const double radius = ss_shape_curvature_radius(shape);
    ss_tool *tool = &model->tools.tool[index];
    tool->radius = radius > 0.0 ? radius : ss_shape_inradius(shape);
    tool->delta = ss_surface_mean_edge(model->tools.surface);
    tool->stiffness = contact_stiffness(model, tool->radius, area);
    double valence = 0.0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        valence += model->valence[i] / model->node_count;
    }
    ss_tool_set_rest_felt(tool, 1.0 / (model->k * valence)); /* the links of one cell */
    return ss_tools_open(&model->tools, plan, index, &model->arena);
}

static softsim_status allocate(ss_model *model)
{
    const size_t n = (size_t)model->padded;
    ss_arena *arena = &model->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(4 * n, model->contact), SS_ROOM(4 * n, model->push),
                  SS_ROOM(n, model->diagonal_of), SS_ROOM(n, model->firmness),
                  SS_ROOM(n, model->touched), SS_ROOM(n, model->is_touched),
                  SS_ROOM(n, model->hold), SS_ROOM(n, model->hold_weight));
    return ss_arena_status(arena);
}

softsim_status ss_chain_tools_create(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].base = &model->tools.tool[k];
    }
    if (ss_plan_tool_count(plan) == 0) {
        return SOFTSIM_OK;
    }
    softsim_status status = ss_tools_create(&model->tools, plan->mesh, plan, error);
    status = status == SOFTSIM_OK ? allocate(model) : status;
    status = status == SOFTSIM_OK ? ss_chain_felt_create(model) : status;
    const double area = status == SOFTSIM_OK ? mean_area(plan->mesh) : 0.0;
    status = area < 0.0 ? SOFTSIM_ERROR_MEMORY : status;
    for (int k = 0; status == SOFTSIM_OK && k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            status = create_tool(model, k, area);
        }
    }
    return status;
}

/* ---- places of tools ---- */

/* The surface at the displacements that a step begins or ends with, once for both. */
static void refit(ss_model *model)
{
    if (model->fitted_step != model->step) {
        ss_surface_refit(model->tools.surface, model->u);
        model->fitted_step = model->step;
    }
}

/* What was felt and pressed, and how deep; what was grasped is released already. */
static void clear_contact(ss_chain_tool *tool)
{
    tool->is_touching = tool->base->was_touching = false;
    tool->base->grasp.is_pressed = false;
    tool->base->penalty = tool->base->felt = 0.0;
    tool->drive = (ss_chain_drive){0};
    ss_set3(tool->base->force, 0.0, 0.0, 0.0);
    ss_set3(tool->base->torque, 0.0, 0.0, 0.0);
}

/* Forgets which cells the tools held at the last sub-step. */
static void forget_touched(ss_model *model)
{
    for (int32_t k = 0; k < model->touched_count; ++k) {
        model->is_touched[model->touched[k]] = 0;
    }
    model->touched_count = 0;
}

void ss_chain_tools_reset(ss_model *model)
{
    const size_t n = (size_t)model->padded; /* a fault leaves scratch as it was */
    forget_touched(model);
    model->fitted_step = -1;
    memset(model->contact, 0, 4 * n * sizeof *model->contact);
    memset(model->push, 0, 4 * n * sizeof *model->push);
    memset(model->diagonal_of, 0, n * sizeof *model->diagonal_of);
    memset(model->firmness, 0, n * sizeof *model->firmness);
    ss_tools_reset(&model->tools);
    ss_chain_felt_reset(model);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        clear_contact(&model->tool[k]);
    }
}

/* What a tool stores and feels as it stands; its broad phase is done. */
static void evaluate(ss_model *model, ss_tool *tool)
{
    ss_tools_press(&model->tools, tool, model->u, NULL, model->push);
    for (int32_t i = 0; i < tool->grasp.count; ++i) {
        memset(model->push + 4 * (ptrdiff_t)tool->grasp.node[i], 0, 4 * sizeof(ss_real));
    }
}

void ss_chain_tools_take(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    bool is_any = false;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_chain_tool *own = &model->tool[k];
        ss_tool *base = own->base;
        const double before = ss_tool_energy(base);
        const ss_tool_news news = ss_tool_take(base, tool ? &tool[k] : NULL);
        if (base->is_present && !is_any) {
            refit(model);
            is_any = true;
        }
        if (news == SS_TOOL_LOST || !base->is_present) {
            clear_contact(own);
        }
        if (base->is_present) {
            base->pose = base->from;
        }
        if (base->is_present && news != SS_TOOL_KEPT) {
            ss_contact_query_broad_phase(base->query, model->u, &base->pose, &base->pose);
            evaluate(model, base);
        }
        /* A jump's energy is the tool's work. */
        model->work += ss_tool_energy(base) - before;
        own->grasp_wish = base->is_present &&
                          ss_grasp_follow_button(&base->grasp, tool[k].is_grasping, base->force);
    }
}

int32_t ss_chain_tools_substeps(ss_model *model)
{
    double steps = 1.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        if (!tool->is_present) {
            continue;
        }
        const double way = ss_tool_motion_bound(tool->shape, &tool->from, &tool->to);
        const double most = 0.25 * fmin(tool->radius, model->net->mean_length);
        if (way > most &&
            ss_contact_query_broad_phase(tool->query, model->u, &tool->from, &tool->to) > 0) {
            steps = fmax(steps, ceil(way / most - 1e-9));
        }
    }
    if (steps > (double)model->plan.max_substeps) {
        ss_chain_tell(model, SOFTSIM_VERDICT_GUARDED,
                      "a tool moved further in a step than its sub-steps can follow");
    }
    return (int32_t)fmin(steps, (double)model->plan.max_substeps);
}

/* ---- a sub-step ---- */

/* Depth that a tool has pressed its cells in by: the weighted mean of what they moved. */
static double depth_of(const ss_model *model, const int32_t *node, int32_t count)
{
    double moved[3] = {0.0}, sum = 0.0;
    for (int32_t k = 0; k < count; ++k) {
        const double weight = model->firmness[node[k]];
        for (int a = 0; a < 3; ++a) {
            moved[a] += weight * (double)model->u[4 * (ptrdiff_t)node[k] + a];
        }
        sum += weight;
    }
    return sum > 0.0 ? ss_norm3(moved) / sum : 0.0;
}

/* The button's press takes hold of the cells that are touched. */
static void take_grasp(ss_model *model, ss_chain_tool *own, const int32_t *node, int32_t count)
{
    ss_tool *tool = own->base;
    if (own->grasp_wish && !tool->grasp.is_pressed) {
        int32_t held = 0;
        for (int32_t k = 0; k < count; ++k) {
            if (model->firmness[node[k]] > 0.0 && held < model->node_count) {
                model->hold[held] = node[k];
                model->hold_weight[held++] = model->firmness[node[k]] / tool->stiffness;
            }
        }
        ss_grasp_take(&tool->grasp, held, model->hold, model->hold_weight,
                      SS_GRASP_STIFFNESS_RATIO * tool->stiffness,
                      (const double(*)[3])model->plan.mesh->position, model->u, &tool->pose);
    }
    tool->grasp.is_pressed = own->grasp_wish;
}

static void list_touched(ss_model *model, const int32_t *node, int32_t count)
{
    for (int32_t k = 0; k < count; ++k) {
        if (model->diagonal_of[node[k]] > 0.0 && !model->is_touched[node[k]]) {
            model->is_touched[node[k]] = 1;
            model->touched[model->touched_count++] = node[k];
        }
    }
}

/* Moves the tool on to `path`; what it stores more with all cells where they are is its work. */
static void query(ss_model *model, ss_chain_tool *own, bool is_first, double path)
{
    ss_tool *tool = own->base;
    ss_tool_pose start;
    const int32_t *node;
    start = tool->pose;
    ss_tool_pose_blend(&tool->from, &tool->to, path, &tool->pose);
    ss_contact_query_broad_phase(tool->query, model->u, &start, &tool->pose);
    if (!is_first) { /* else known from the end of the last step */
        const ss_tool_pose next = tool->pose;
        tool->pose = start;
        evaluate(model, tool);
        tool->pose = next;
    }
    const double before = ss_tool_energy(tool);
    ss_tools_press(&model->tools, tool, model->u, model->contact, model->contact);
    ss_contact_query_diagonal(tool->query, model->firmness);
    const int32_t count = ss_contact_query_candidate_nodes(tool->query, &node);
    model->work += ss_tool_energy(tool) - before;
    own->is_touching = ss_tool_is_touching(tool);
    own->drive.depth = own->is_touching ? depth_of(model, node, count) : 0.0;
    take_grasp(model, own, node, count);
    for (int32_t k = 0; k < count; ++k) {
        model->diagonal_of[node[k]] += model->firmness[node[k]];
        model->firmness[node[k]] = 0.0;
    }
    for (int32_t k = 0; k < tool->grasp.count; ++k) {
        model->diagonal_of[tool->grasp.node[k]] += tool->grasp.fade * tool->grasp.stiffness[k];
    }
    list_touched(model, node, count);
    list_touched(model, tool->grasp.node, tool->grasp.count);
}

void ss_chain_tools_touch(ss_model *model, bool is_first, double path)
{
    if (!model->tools.surface) {
        return;
    }
    forget_touched(model);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (model->tools.tool[k].is_present) {
            query(model, &model->tool[k], is_first, path);
        }
    }
}

void ss_chain_tools_apply(ss_model *model, double h)
{
    const double scale = 1.0 / (2.0 * model->k);
    for (int32_t t = 0; t < model->touched_count; ++t) {
        const int32_t i = model->touched[t];
        const ptrdiff_t at = 4 * (ptrdiff_t)i;
        const double firm = h * model->conductance[i] * model->diagonal_of[i] * scale;
        for (int a = 0; a < 3; ++a) {
            const bool is_free = model->free[at + a] > 0;
            const double leak = model->leak * (double)model->u[at + a]; /* comes with the answer */
            const double pull =
                (double)model->pull[at + a] + scale * (double)model->contact[at + a];
            model->pull[at + a] = (ss_real)(is_free ? (pull - leak) / (1.0 + firm) + leak : pull);
            model->contact[at + a] = 0;
        }
        model->diagonal_of[i] = 0.0;
        ss_chain_set_add(&model->front.moving, i);
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &model->tools.tool[k];
        if (tool->is_present && tool->grasp.count > 0) {
            ss_grasp_fade(&tool->grasp, h);
            (void)ss_grasp_accept_fade(&tool->grasp); /* what it let go of is lost */
        }
    }
}

/* ---- felt contact ---- */

void ss_chain_tools_sample(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (model->tools.tool[k].is_present) {
            evaluate(model, &model->tools.tool[k]);
        }
    }
}

void ss_chain_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out)
{
    ss_tool *tool = ss_tools_find(&model->tools, probe, out);
    if (!tool) {
        return;
    }
    double along[3];
    refit(model);
    if (ss_tool_fill_contacts(tool, model->u, near, out, along)) {
        const double viscosity = ss_chain_feel(model, probe, along);
        ss_contact_set_share(out, tool->felt, viscosity);
    }
    tool->was_touching = ss_tool_is_touching(tool);
}
