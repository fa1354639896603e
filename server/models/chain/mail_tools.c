/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/mail.h"
/*
 * Tools on chainmail. A tool moves
 * the cells it touches out of itself, by f_i/D_i with a contact of stiffness 1 (contact.c has the
 * symbols): the mean depth of their surface samples, in two passes where one is deeper than 0.3 of
 * the tool's inradius. Grasped ones go along with it.
 *
 * The hand feels a spring alone, k = working force / tool radius, between the tool and the surface
 * as it was when the tool came to touch it:
 *   F = k (e - gap)+,   e = sum_i w_i n.(u_i^0 - u_i) / sum_i w_i,
 * u^0 the displacements then, w_i the source weights of the cells about the tool (contact.h), n the
 * way that their slopes push it, gap how far the tool has gone out of the dent. It is 0 at the
 * touch, also of a dent that was left, grows as the tool presses and falls as it goes out, whether
 * the cells follow or stay. Beyond that the touch goes on and a gap of gap - e is told, until that
 * is a quarter of the tool's radius: what is felt is some periods late and has to go on to 0. Where
 * no cell is in reach of the weights any more e stays, so that a deep dent is left lower.
 * Rejected: what the law between results makes of a result without force, its stiffness times the
 * way of one period (with a result each tick that is no force at all); as soon as e < gap, the gap
 * to the bottom of the dent (to the law between results a pull of k e: what was felt ended in a
 * tick, 0.125 N of 0.7 N over a pinch); n of the nearest facet where nothing touches (over a groove
 * or a pinch it jumps from wall to wall, and e with it).
 */
#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/vec.h"

/* Passes in which a tool moves cells out of itself: a cell's samples lie at different depths. */
enum { PUSH_PASSES = 3 };
/* N/m over working force and tool radius: what the hand meets between results. */
#define FELT_SHARE 1.0
/* A tool so far out of the surface as it was has left: in radii, as far as one goes in a sub-step,
 * or what a hand of 0.3 m/s goes in the three steps by which it is felt late, m/s. */
#define LEAVING_SHARE 0.25
#define LEAVING_SPEED 0.9

/* ---- set-up ---- */

static softsim_status create_tool(ss_model *model, int index)
{
    const ss_model_plan *plan = &model->plan;
    const ss_shape *shape = &plan->tool[index].shape;
    const double radius = ss_shape_curvature_radius(shape);
    const double working = plan->working_force > 0.0 ? plan->working_force : 1.0;
    ss_tool *tool = &model->tools.tool[index];
    tool->radius = radius > 0.0 ? radius : ss_shape_inradius(shape);
    tool->delta = ss_surface_mean_edge(model->tools.surface);
    tool->stiffness = 1.0;
    tool->rest_felt = FELT_SHARE * working / tool->radius;
    model->tool[index].before =
        ss_arena_get(&model->arena, 4 * (size_t)model->node_count, sizeof(ss_real));
    return ss_tools_open(&model->tools, plan, index, &model->arena);
}

softsim_status ss_mail_tools_create(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    softsim_status status = ss_tools_create(&model->tools, plan->mesh, plan, error);
    for (int k = 0; status == SOFTSIM_OK && k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].base = &model->tools.tool[k];
        if (plan->tool[k].is_used) {
            status = create_tool(model, k);
        }
    }
    return status;
}

/* ---- in a step ---- */

static uint8_t bit_of(const ss_model *model, const ss_mail_tool *tool)
{
    _Static_assert(SOFTSIM_MAX_PROBES <= 8, "a bit for each tool");
    return (uint8_t)(1u << (tool - model->tool));
}

/* One pass: cells whose samples are inside the tool go out by f_i/D_i. */
static int32_t push_out(ss_model *model, const ss_mail_tool *tool)
{
    const ss_tool *base = tool->base;
    double force[3] = {0.0}, torque[3] = {0.0};
    const int32_t *node;
    int32_t pushed = 0;
    (void)ss_contact_query_penalty(base->query, model->u, &base->pose, model->push, force, torque);
    ss_contact_query_diagonal(base->query, model->weight);
    const int32_t count = ss_contact_query_candidate_nodes(base->query, &node);
    for (int32_t k = 0; k < count; ++k) {
        const int32_t i = node[k];
        ss_real *f = model->push + 4 * (ptrdiff_t)i;
        if (model->weight[i] > 0.0 && model->bound[i] != 7) {
            double u[3];
            for (int a = 0; a < 3; ++a) {
                u[a] = (double)model->u[4 * (ptrdiff_t)i + a] + (double)f[a] / model->weight[i];
            }
            ss_mail_move_to(model, i, u);
            model->held[i] |= bit_of(model, tool);
            ss_mail_sponsor(model, i);
            ++pushed;
        }
        memset(f, 0, 4 * sizeof *f);
        model->weight[i] = 0.0;
    }
    return pushed;
}

static void carry(ss_model *model, const ss_mail_tool *tool)
{
    const ss_grasp *grasp = &tool->base->grasp;
    const ss_tool_pose *pose = &tool->base->pose;
    for (int32_t k = 0; k < grasp->count; ++k) {
        const int32_t i = grasp->node[k];
        double x[3];
        ss_rotate(x, pose->orientation, grasp->offset[k]);
        for (int a = 0; a < 3; ++a) {
            x[a] += pose->position[a] - model->tools.rest[i][a];
        }
        ss_mail_move_to(model, i, x);
        model->held[i] |= bit_of(model, tool);
        ss_mail_sponsor(model, i);
    }
}

void ss_mail_tools_move(ss_model *model, double path)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *base = &model->tools.tool[k];
        if (!base->is_present) {
            continue;
        }
        const ss_tool_pose start = base->pose;
        ss_tool_pose_blend(&base->from, &base->to, path, &base->pose);
        carry(model, &model->tool[k]);
        for (int pass = 0; pass < PUSH_PASSES; ++pass) {
            ss_contact_query_broad_phase(base->query, model->u, &start, &base->pose);
            if (push_out(model, &model->tool[k]) == 0) {
                break;
            }
            model->tool[k].is_touching = true;
        }
    }
}

void ss_mail_tools_grasp(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *base = &model->tools.tool[k];
        ss_grasp *grasp = &base->grasp;
        if (!base->is_present) {
            continue;
        }
        if (tool[k].is_grasping && !grasp->is_pressed) {
            int32_t *node = model->queue, count = 0; /* between propagations it is empty */
            for (int32_t i = 0; i < model->node_count; ++i) {
                if ((model->held[i] & bit_of(model, &model->tool[k])) != 0) {
                    node[count++] = i;
                }
            }
            ss_grasp_take(grasp, count, node, model->weight, 0.0, model->tools.rest, model->u,
                          &base->pose);
        }
        grasp->count = tool[k].is_grasping ? grasp->count : 0;
        grasp->is_pressed = tool[k].is_grasping;
    }
}

/* n and e, which stay where no cell is in reach: high over a deep dent. `nearest`: the contact's
 * normal, for cells that push equally from all sides. */
static void measure_depth(const ss_model *model, ss_mail_tool *tool, const double nearest[3])
{
    const ss_tool *base = tool->base;
    const int32_t *node;
    const double *weight;
    double total = 0.0, sum = 0.0, push[3] = {0.0}, turn[3] = {0.0};
    const int32_t count =
        ss_contact_query_weigh(base->query, model->u, NULL, &base->pose, &node, &weight, &total);
    if (!(total > 0.0)) {
        if (!(ss_norm3(tool->normal) > 0.0)) {
            ss_copy3(tool->normal, nearest);
        }
        return;
    }
    ss_contact_query_weight_forces(base->query, NULL, NULL, push, turn);
    const double size = ss_normalize3(push);
    ss_cross3(tool->arm, push, turn);
    ss_scale3(tool->arm, tool->arm, size > 0.0 ? 1.0 / size : 0.0);
    ss_copy3(tool->normal, size > 0.0 ? push : nearest);
    for (int32_t k = 0; k < count; ++k) {
        for (int a = 0; a < 3; ++a) {
            const ptrdiff_t at = 4 * (ptrdiff_t)node[k] + a;
            sum += weight[k] * tool->normal[a] * ((double)tool->before[at] - (double)model->u[at]);
        }
    }
    tool->e = sum / total;
}

/* No gap of a tool that touches is longer, m. */
static double longest_gap(const ss_mail_tool *tool)
{
    return tool->base->radius + fmax(0.0, tool->e);
}

/* After the step: how far below the surface as it was the tool holds the cells about it. */
static void measure_dent(ss_model *model, ss_mail_tool *tool)
{
    const ss_tool *base = tool->base;
    ss_contact_set set;
    ss_contact_query_contacts(base->query, model->u, &base->pose, longest_gap(tool), &set);
    measure_depth(model, tool, set.normal);
    const double gap = set.count > 0 ? set.contact[0].gap : (double)INFINITY, out = gap - tool->e;
    /* One that touches what has come to lie above the surface as it was begins anew. */
    const double left = fmax(LEAVING_SHARE * base->radius, LEAVING_SPEED * model->plan.step);
    tool->is_touching = out < (gap > 0.0 ? left : 0.0);
    tool->dent = tool->is_touching ? -out : 0.0;
}

void ss_mail_tools_measure(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *base = &model->tools.tool[k];
        double force[3] = {0.0}, torque[3] = {0.0};
        if (base->is_present) { /* for contacts() */
            ss_contact_query_broad_phase(base->query, model->u, &base->pose, &base->pose);
            (void)ss_contact_query_penalty(base->query, model->u, &base->pose, NULL, force, torque);
            if (model->tool[k].is_touching) {
                measure_dent(model, &model->tool[k]);
            }
        }
    }
}

void ss_mail_tool_clear(ss_mail_tool *tool)
{
    tool->is_touching = false;
    tool->e = tool->dent = 0.0;
    ss_set3(tool->normal, 0.0, 0.0, 0.0);
    ss_set3(tool->arm, 0.0, 0.0, 0.0);
}

int32_t ss_mail_tools_take(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_mail_tool *own = &model->tool[k];
        ss_tool *base = &model->tools.tool[k];
        base->is_present = base->is_used && tool && tool[k].is_present;
        if (base->is_present) { /* what is grasped goes along, however far */
            base->pose = base->from = tool[k].from;
            base->to = tool[k].to;
            if (!own->is_touching) {
                ss_mail_tool_clear(own);
                memcpy(own->before, model->u, 4 * (size_t)model->node_count * sizeof *model->u);
            }
        } else {
            base->grasp.count = 0;
            base->grasp.is_pressed = false;
            ss_mail_tool_clear(own);
        }
    }
    const double parts = ss_tools_parts(&model->tools);
    if (parts > model->plan.max_substeps) {
        model->verdict = SOFTSIM_VERDICT_GUARDED;
        model->reason = "a tool moved further in a step than its sub-steps can follow";
    }
    return (int32_t)fmin(parts, model->plan.max_substeps);
}

void ss_mail_refit(ss_model *model, int64_t step)
{
    if (ss_tools_is_any(&model->tools) && model->fitted_step != step) {
        ss_surface_refit(model->tools.surface, model->u);
        model->fitted_step = step;
    }
}

/* S on the tangent plane of n: (1 - n n^T) S (1 - n n^T). */
static void flatten(const double n[3], double inout_curvature[3][3])
{
    double across[3];
    for (int r = 0; r < 3; ++r) {
        ss_madd3(inout_curvature[r], inout_curvature[r], -ss_dot3(inout_curvature[r], n), n);
    }
    for (int c = 0; c < 3; ++c) {
        across[c] = n[0] * inout_curvature[0][c] + n[1] * inout_curvature[1][c] +
                    n[2] * inout_curvature[2][c];
    }
    for (int r = 0; r < 3; ++r) {
        ss_madd3(inout_curvature[r], inout_curvature[r], -n[r], across);
    }
}

/* A contact as the dent is measured: along n, and where nothing touches, or at one point only, on
 * the line that the tool is pushed along. */
static void turn_contact(const ss_mail_tool *tool, ss_contact *contact)
{
    const double *origin = tool->base->pose.position;
    const bool is_ball = tool->base->shape->kind == SS_SHAPE_SPHERE;
    if (is_ball || contact->gap > 0.0) {
        double way[3];
        ss_sub3(way, contact->point, origin);
        ss_madd3(contact->point, origin, ss_dot3(way, tool->normal), tool->normal);
        ss_madd3(contact->point, contact->point, is_ball ? 0.0 : 1.0, tool->arm);
    }
    ss_copy3(contact->normal, tool->normal);
    flatten(tool->normal, contact->curvature);
    contact->gap = fmax(0.0, -tool->dent);
}

void ss_mail_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out)
{
    const ss_tool *tool = ss_tools_find(&model->tools, probe, out);
    if (!tool) {
        return;
    }
    const ss_mail_tool *own = &model->tool[probe];
    const double range = own->is_touching ? fmax(near, longest_gap(own)) : near;
    ss_contact_query_contacts(tool->query, model->u, &tool->pose, range, out);
    out->is_held = tool->grasp.is_pressed && tool->grasp.count > 0;
    ss_set3(out->force, 0.0, 0.0, 0.0);
    ss_set3(out->torque, 0.0, 0.0, 0.0);
    double sum = 0.0;
    for (int32_t k = 0; k < out->count; ++k) {
        sum += out->contact[k].force;
    }
    for (int32_t k = 0; k < out->count; ++k) {
        ss_contact *contact = &out->contact[k];
        /* Of what touches by its part of the samples' forces: one that begins has none. */
        const double share = sum > 0.0 ? contact->force / sum : 1.0 / out->count;
        contact->stiffness = contact->tangential = share * tool->rest_felt;
        contact->force = contact->stiffness * fmax(0.0, own->dent);
        if (own->is_touching) {
            turn_contact(own, contact);
        }
    }
}
