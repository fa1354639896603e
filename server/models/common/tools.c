/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/tools.h"

#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/hash.h"
#include "rt/vec.h"

/* The depth that what is near is told for: of the tool's way in a step, for the law is used as far
 * before as behind the place that a step was predicted to, and of R at least. The contact a tenth
 * of R deep in place of it was up to 15 times too stiff for the first touches of a hand that goes a
 * fiftieth of R; with 0.015 of R at least, hands that hardly touch are better off without a law. */
#define TOUCH_WAY   0.5
#define LEAST_TOUCH 0.007

/* What presses a tool beside its samples counts up to so many times their force: where they hardly
 * touch they hold nothing. */
#define MOST_PRESSED 4.0

/* Corners that are cut off by more of the smallest tool's radius are told. */
#define TOLD_ROUNDING 0.5

/* ---- set-up ---- */

softsim_status ss_tools_create(ss_tools *tools, const ss_mesh *mesh, const ss_model_plan *plan,
                               softsim_error *error)
{
    tools->rest = (const double(*)[3])mesh->position;
    tools->node_count = mesh->node_count;
    return ss_plan_tool_count(plan) > 0
               ? ss_surface_create(mesh, ss_plan_smallest_tool(plan), plan->contact_parts,
                                   &tools->surface, error)
               : SOFTSIM_OK;
}

softsim_status ss_tools_open(ss_tools *tools, const ss_model_plan *plan, int index, ss_arena *arena)
{
    ss_tool *tool = &tools->tool[index];
    const ss_contact_query_options options = {.delta = tool->delta, .stiffness = tool->stiffness};
    tool->is_used = true;
    tool->shape = &plan->tool[index].shape;
    ss_grasp_init(&tool->grasp, tools->node_count, plan->grasp_max_force, arena);
    const softsim_status status =
        ss_contact_query_create(tools->surface, tool->shape, &options, &tool->query);
    tool->has_friction = plan->friction > 0.0 || plan->friction_by_node != NULL;
    if (status == SOFTSIM_OK && tool->has_friction &&
        ss_contact_query_add_friction(tool->query, plan->friction, plan->friction_by_node) !=
            SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    return status == SOFTSIM_OK ? ss_arena_status(arena) : status;
}

void ss_tools_fini(ss_tools *tools)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_contact_query_destroy(&tools->tool[k].query);
    }
    ss_surface_destroy(&tools->surface);
}

static void forget_friction(ss_tool *tool)
{
    ss_set3(tool->friction, 0.0, 0.0, 0.0);
    ss_set3(tool->friction_torque, 0.0, 0.0, 0.0);
    tool->rub = (ss_friction_energy){0.0, 0.0};
    if (tool->has_friction) {
        ss_contact_query_forget_friction(tool->query);
    }
}

void ss_tools_reset(ss_tools *tools)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &tools->tool[k];
        tool->is_present = tool->was_touching = false;
        tool->grasp.is_pressed = tool->grasp.is_torn = false;
        tool->grasp.count = 0;
        tool->grasp.unfaded_energy = 0.0;
        tool->felt = tool->penalty = 0.0;
        tool->compliance = tool->rest_compliance;
        ss_set3(tool->force, 0.0, 0.0, 0.0);
        ss_set3(tool->torque, 0.0, 0.0, 0.0);
        ss_set3(tool->along, 0.0, 0.0, 0.0);
        forget_friction(tool);
    }
}

/* Of the contact alone, a tenth of R deep: F = pi kc R p^2 at the depth p. */
static double working_stiffness(const ss_tool *tool)
{
    return 0.2 * SS_PI * tool->stiffness * tool->radius * tool->radius;
}

void ss_tool_set_rest_felt(ss_tool *tool, double compliance)
{
    tool->compliance = tool->rest_compliance = fmax(compliance, 0.0);
    tool->rest_felt = 1.0 / (1.0 / working_stiffness(tool) + tool->rest_compliance);
}

double ss_tool_largest_depth(const ss_tool *tool, const ss_model_plan *plan)
{
    return sqrt(plan->max_force / (SS_PI * tool->stiffness * tool->radius));
}

void ss_tool_say_limits(const ss_tool *tool, int index, const ss_model_plan *plan, double edge,
                        const ss_notes *out)
{
    const double depth = ss_tool_largest_depth(tool, plan);
    if (depth > 0.2 * tool->radius) {
        ss_note_warning(out, "contact.tools",
                        "tool %d would sink in by %.2g of its radius at the largest force: %s",
                        index, depth / tool->radius,
                        ss_plan_contact_remedy(plan, tool->stiffness, tool->radius));
    }
    if (tool->radius < 0.5 * edge) {
        ss_note_warning(out, "contact.tools.shape",
                        "tool %d is small beside the mesh (radius %.3g m, mean edge %.3g m): its "
                        "force will ripple; refine the mesh",
                        index, tool->radius, edge);
    }
}

void ss_tools_warn_rounded(const ss_tools *tools, const ss_model_plan *plan, const ss_notes *out)
{
    double at[3];
    const double rounding = tools->surface ? ss_surface_rounding(tools->surface, at) : 0.0;
    const double radius = ss_plan_smallest_tool(plan);
    if (rounding > TOLD_ROUNDING * radius) {
        ss_note_warning(out, "object.mesh",
                        "what is felt is a smooth surface through the mesh, which cuts its corners "
                        "off by up to %.3g mm (at %.4f, %.4f, %.4f m): a tool of %.3g mm radius "
                        "goes in so far there before it is felt; edges are to be shorter there, "
                        "about %.2g of what they are (softsim-mesh remesh; of a volume: its "
                        "surface, and fill that again)",
                        1e3 * rounding, at[0], at[1], at[2], 1e3 * radius,
                        TOLD_ROUNDING * radius / rounding);
    }
}

void ss_tools_warn_unheld(const ss_tools *tools, bool is_held, const ss_notes *out)
{
    if (!is_held && tools->surface) {
        ss_note_warning(out, "object.fixed",
                        "the supports do not hold the body, or not every part of it: a tool pushes "
                        "away what is not held; hold more of it with object.fixed");
    }
}

void ss_tools_say_friction(const ss_model_plan *plan, const ss_notes *out)
{
    if (plan->friction_by_node) {
        ss_note_used(out, "contact.friction", "by node, a spring along the surface each sample");
    } else if (plan->friction > 0.0) {
        ss_note_used(out, "contact.friction", "%.3g, a spring along the surface each sample",
                     plan->friction);
    } else {
        ss_note_left_out(out, "friction", "contact.friction=1e-30", "contact.friction is 0");
    }
}

void ss_tools_say_grasp(const ss_model_plan *plan, const ss_notes *out)
{
    if (plan->grasp_max_force > 0.0) {
        ss_note_used(out, "contact.grasp_max_force_n",
                     "%.3g N, a grasp with a larger reaction is torn", plan->grasp_max_force);
    }
}

/* ---- on the way ---- */

ss_tool_news ss_tool_take(ss_tool *tool, const ss_model_tool *input)
{
    const bool was_present = tool->is_present;
    tool->is_present = tool->is_used && input && input->is_present;
    if (!tool->is_present) {
        tool->grasp.count = 0;
        tool->grasp.is_pressed = tool->grasp.is_torn = false;
        forget_friction(tool);
        return was_present ? SS_TOOL_LOST : SS_TOOL_KEPT;
    }
    tool->from = input->from;
    tool->to = input->to;
    ss_tool_rotation(&tool->from, &tool->to, tool->rotation);
    if (was_present && memcmp(&tool->from, &tool->pose, sizeof tool->pose) == 0) {
        return SS_TOOL_KEPT;
    }
    /* What jumps lets go: springs stretched at once across the jump are no grasp. */
    if (ss_tool_motion_bound(tool->shape, &tool->pose, &tool->from) > 0.25 * tool->radius) {
        tool->grasp.count = 0;
        forget_friction(tool);
        return SS_TOOL_LOST;
    }
    return SS_TOOL_MOVED;
}

void ss_tool_at(const ss_tool *tool, double path, ss_tool_pose *out)
{
    if (path > 0.0 && path < 1.0) {
        ss_tool_pose_blend(&tool->from, &tool->to, path, out);
    } else {
        *out = path > 0.0 ? tool->to : tool->from;
    }
}

void ss_tools_begin_mean(ss_tools *tools)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &tools->tool[k];
        ss_set3(tool->impulse, 0.0, 0.0, 0.0);
        ss_set3(tool->friction_impulse, 0.0, 0.0, 0.0);
        tool->span = 0.0;
    }
}

void ss_tools_add_mean(ss_tools *tools, double span)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &tools->tool[k];
        if (tool->is_present && span > 0.0) {
            ss_madd3(tool->impulse, tool->impulse, span, tool->force);
            ss_madd3(tool->friction_impulse, tool->friction_impulse, span, tool->friction);
            tool->span += span;
        }
    }
}

bool ss_tools_is_any(const ss_tools *tools)
{
    bool is_any = false;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        is_any = is_any || tools->tool[k].is_present;
    }
    return is_any;
}

double ss_tools_parts(const ss_tools *tools)
{
    double parts = 1.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &tools->tool[k];
        const double way =
            tool->is_present ? ss_tool_motion_bound(tool->shape, &tool->from, &tool->to) : 0.0;
        parts = way > 0.0 ? fmax(parts, ceil(4.0 * way / tool->radius - 1e-9)) : parts;
    }
    return parts;
}

double ss_tools_work(const ss_tools *tools)
{
    double work = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &tools->tool[k];
        if (tool->is_present) {
            double way[3];
            ss_sub3(way, tool->to.position, tool->from.position);
            work -= ss_dot3(tool->force, way) + ss_dot3(tool->torque, tool->rotation);
        }
    }
    return work;
}

void ss_tools_fade(ss_tools *tools, double h)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_grasp_fade(&tools->tool[k].grasp, h);
    }
}

double ss_tools_accept_fade(ss_tools *tools)
{
    double lost = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        lost += ss_grasp_accept_fade(&tools->tool[k].grasp);
    }
    return lost;
}

double ss_tools_keep_friction(ss_tools *tools)
{
    const double lost = ss_tools_friction_loss(tools);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &tools->tool[k];
        if (tool->is_present && tool->has_friction) {
            ss_contact_query_keep_friction(tool->query);
            tool->rub.lost = 0.0;
        }
    }
    return lost;
}

double ss_tools_friction_loss(const ss_tools *tools)
{
    double lost = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        lost += tools->tool[k].is_present ? tools->tool[k].rub.lost : 0.0;
    }
    return lost;
}

/* ---- penalty and grasp ---- */

void ss_tool_rub(ss_tool *tool, const double penalty[3], const double beside[3], ss_real *force)
{
    const double square = ss_dot3(penalty, penalty);
    /* A grasp holds the tissue along the surface by itself. */
    if (tool->grasp.count > 0) {
        forget_friction(tool);
        return;
    }
    const double more = square > 0.0 ? ss_dot3(beside, penalty) / square : 0.0;
    ss_set3(tool->friction, 0.0, 0.0, 0.0);
    ss_set3(tool->friction_torque, 0.0, 0.0, 0.0);
    tool->rub = ss_contact_query_friction(tool->query, &tool->pose,
                                          fmin(MOST_PRESSED, fmax(0.0, 1.0 + more)), force,
                                          tool->friction, tool->friction_torque);
    ss_add3(tool->force, tool->force, tool->friction);
    ss_add3(tool->torque, tool->torque, tool->friction_torque);
}

void ss_tools_press(const ss_tools *tools, ss_tool *tool, const ss_real *u, ss_real *force,
                    ss_real *grasp_force)
{
    ss_set3(tool->force, 0.0, 0.0, 0.0);
    ss_set3(tool->torque, 0.0, 0.0, 0.0);
    tool->penalty =
        ss_contact_query_penalty(tool->query, u, &tool->pose, force, tool->force, tool->torque);
    if (tool->has_friction) {
        const double all[3] = {tool->force[0], tool->force[1], tool->force[2]};
        ss_tool_rub(tool, all, (const double[3]){0.0, 0.0, 0.0}, force);
    }
    ss_grasp_add_forces(&tool->grasp, tools->rest, u, &tool->pose, grasp_force, tool->force,
                        tool->torque);
}

double ss_tool_energy(const ss_tool *tool)
{
    return tool->penalty + tool->rub.stored +
           (tool->grasp.count > 0 ? tool->grasp.fade * tool->grasp.unfaded_energy : 0.0);
}

double ss_tools_energy(const ss_tools *tools)
{
    double energy = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &tools->tool[k];
        energy += tool->is_present ? tool->penalty + tool->rub.stored : 0.0;
        energy += tool->grasp.count > 0 ? tool->grasp.fade * tool->grasp.unfaded_energy : 0.0;
    }
    return energy;
}

static void add_grasp_diagonal(const ss_tool *tool, double *diagonal)
{
    for (int32_t i = 0; i < tool->grasp.count; ++i) {
        diagonal[tool->grasp.node[i]] += tool->grasp.fade * tool->grasp.stiffness[i];
    }
}

void ss_tool_add_diagonal(const ss_tool *tool, double *diagonal)
{
    ss_contact_query_diagonal(tool->query, diagonal);
    add_grasp_diagonal(tool, diagonal);
}

void ss_tool_add_tangent_diagonal(const ss_tool *tool, double *diagonal)
{
    ss_contact_query_tangent_diagonal(tool->query, diagonal);
    add_grasp_diagonal(tool, diagonal);
}

void ss_tool_add_change(const ss_tool *tool, const ss_real *x, ss_real *out)
{
    static const double still[3] = {0.0, 0.0, 0.0};
    double unused[3] = {0.0, 0.0, 0.0};
    if (tool->penalty > 0.0) {
        ss_contact_query_tangent(tool->query, x, still, out, unused);
    }
    for (int32_t i = 0; i < tool->grasp.count; ++i) {
        const ptrdiff_t at = 4 * (ptrdiff_t)tool->grasp.node[i];
        const ss_real stiffness = (ss_real)(tool->grasp.fade * tool->grasp.stiffness[i]);
        for (int a = 0; a < 3; ++a) {
            out[at + a] -= stiffness * x[at + a];
        }
    }
}

double ss_tool_push(const ss_tool *tool, const double normal[3], ss_real *push)
{
    double on_tool[3] = {0.0, 0.0, 0.0};
    ss_contact_query_tangent(tool->query, NULL, normal, push, on_tool);
    double stiffness = -ss_dot3(on_tool, normal);
    for (int32_t i = 0; i < tool->grasp.count; ++i) {
        const double k = tool->grasp.fade * tool->grasp.stiffness[i];
        for (int a = 0; a < 3; ++a) {
            push[4 * (ptrdiff_t)tool->grasp.node[i] + a] += (ss_real)(k * normal[a]);
        }
        stiffness += k;
    }
    return stiffness;
}

void ss_tool_set_felt(ss_tool *tool, double felt, double k_cc)
{
    tool->felt = felt;
    /* Of a contact that hardly presses there is none to tell: what is felt errs high. */
    if (k_cc > 2.0 * felt) {
        tool->compliance = 1.0 / felt - 1.0 / k_cc;
    }
}

uint64_t ss_tool_hash_felt(const ss_tool *tool, uint64_t hash)
{
    hash = ss_hash_bytes(hash, &tool->felt, sizeof tool->felt);
    return tool->felt > 0.0 ? ss_hash_bytes(hash, &tool->compliance, sizeof tool->compliance)
                            : hash;
}

/* ---- felt contact ---- */

ss_tool *ss_tools_find(ss_tools *tools, int32_t probe, ss_contact_set *out)
{
    memset(out, 0, sizeof *out);
    const bool is_there = probe >= 0 && probe < SOFTSIM_MAX_PROBES && tools->tool[probe].is_present;
    return is_there ? &tools->tool[probe] : NULL;
}

/* The mean in place of the force at the end; what touched within the step only, too. */
static void set_mean(const ss_tool *tool, ss_contact_set *set)
{
    const double size = ss_norm3(set->force);
    double mean[3];
    ss_sub3(mean, tool->impulse, tool->friction_impulse);
    ss_scale3(mean, mean, 1.0 / tool->span);
    for (int32_t k = 0; k < set->count; ++k) {
        ss_contact *contact = &set->contact[k];
        const double along = size > 0.0 ? contact->force * ss_dot3(mean, set->force) / (size * size)
                                        : ss_dot3(mean, contact->normal) / set->count;
        contact->force = fmax(0.0, along);
        contact->gap = contact->force > 0.0 ? 0.0 : contact->gap;
    }
    ss_copy3(set->force, mean);
    ss_scale3(set->friction, tool->friction_impulse, 1.0 / tool->span);
}

/* What a touch will be felt with until a result answers: the contact as deep as that gets, in
 * series with the body. F = pi kc R p^2 of a round tool; a flat one is as stiff at once. */
static double touch_stiffness(const ss_tool *tool, const double normal[3])
{
    double way[3];
    ss_sub3(way, tool->to.position, tool->from.position);
    const double depth = fmax(LEAST_TOUCH * tool->radius, TOUCH_WAY * fabs(ss_dot3(way, normal)));
    const double rise = SS_PI * tool->stiffness * tool->radius;
    const double own = 2.0 * depth / (1.0 + sqrt(1.0 + 4.0 * tool->compliance * rise * depth));
    const bool is_round = ss_shape_curvature_radius(tool->shape) > 0.0;
    return 1.0 / (tool->compliance + 1.0 / (is_round ? 2.0 * rise * own : working_stiffness(tool)));
}

/* A grasp is told along the direction in which it was taken, which turns with the tool. Contacts
 * come and go under what it holds, and turn: along their normals the estimate of its stiffness,
 * kept from step to step, began anew each time, two to three times too high, and the coupling went
 * after it. So it did along the force that draws it, in bodies whose estimate takes long. */
static void set_along(ss_tool *tool, const ss_contact_set *set, double out[3])
{
    if (set->is_held && ss_norm3(tool->along) > 0.0) {
        ss_rotate(out, tool->pose.orientation, tool->along);
        return;
    }
    ss_contact_set_direction(set, out);
    ss_rotate_back(tool->along, tool->pose.orientation, out);
}

bool ss_tool_fill_contacts(ss_tool *tool, const ss_real *u, double near, ss_contact_set *out,
                           double out_along[3])
{
    ss_contact_query_contacts(tool->query, u, &tool->pose, near, out);
    out->is_held = tool->grasp.count > 0;
    out->is_torn = out->is_held && tool->grasp.is_torn;
    ss_sub3(out->force, tool->force, tool->friction);
    ss_copy3(out->torque, tool->torque);
    ss_copy3(out->friction, tool->friction);
    ss_copy3(out->friction_torque, tool->friction_torque);
    if (tool->span > 0.0 && !out->is_held) {
        set_mean(tool, out);
    }
    if (out->count > 0 && ss_tool_is_touching(tool)) {
        set_along(tool, out, out_along);
        return true;
    }
    if (!out->is_held) {
        ss_set3(tool->along, 0.0, 0.0, 0.0);
    }
    for (int32_t k = 0; k < out->count; ++k) {
        out->contact[k].stiffness = touch_stiffness(tool, out->contact[k].normal);
        out->contact[k].tangential = out->contact[k].stiffness;
    }
    return false;
}
