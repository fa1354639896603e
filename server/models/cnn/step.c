/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * Time: m P'' + gamma P' + g + ks (P - P*) = F by classical Runge-Kutta, with a step that is
 * computed, not guessed.
 *
 * Any mode is x'' + d x' + w^2 x = 0 with d within the bounds of gamma/m and w^2 at most
 *
 *   omega^2 = max_i (ks_i + 2 sum_k c1_k D_k,i + kc sum_q A_q B_qi + k_i) / m_i
 *           + sum_k a E^ sum_i |r_i|^2 / m_i + (B/V0) sum_i |N_i|^2 / m_i
 *
 * (D_k,i the row sum of kap of source k). The bound is the largest step that keeps all of them
 * inside RK4's region of stability; sub-steps take 0.7 of it, a tool moves at most R/4 in one,
 * and the bound is looked at again after each: a step that turns out too large is taken back, and
 * that is said where it held more energy than a hand feels (small_energy): the bound also shrinks
 * with every tool that comes near a body at rest.
 * Where the budget of sub-steps is not enough the body is simulated slower than time passes, each
 * sub-step still stable, and tools and prescribed nodes go the same share of their ways: flagged,
 * never silent. Rejected: the whole way in a part of the time, which presses at a multiple of the
 * speed that a hand has, and feeds itself: what is pressed harder is stiffer, and simulated slower
 * still. The bound does not know how forces through the weights change within a sub-step; at
 * strains far beyond use that can feed energy in, which is then taken out of the motion again, and
 * flagged. Rejected: an implicit step (the contact set and kap change within it), scaling masses.
 *
 * Weights, kap and the forces through the weights are taken at the end of a sub-step, where they
 * also give the energies at that moment, and hold through the next one. Work and dissipation are
 * summed with the stages' weights, so that kinetic + elastic - work + dissipated is the energy
 * balance. What tissue gains that springs back under a source is taken out again (spring.c). A
 * network in its own time takes its steps after each accepted sub-step; the energy that its new
 * flux densities bring or take is its work, and stands in the energy balance as such.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "models/common/substeps.h"
#include "rt/vec.h"

/* Of the stable step. */
#define STEP_SHARE   0.7
#define FROZEN_SHARE 0.25 /* of 1/rate: the least that the rule of frozen forces asks for */
/* Sub-steps taken back in one outer step, each half the one before, then a sixteenth: beyond, the
 * state itself is at fault (a number that is not finite). */
enum { MAX_REJECTED = 40 };
/* Of what is left, a share (beyond what a hand could feel) that is taken out of the motion again,
 * and said: closed loops at sensible speeds stay a hundred times below in all. A loss is only
 * said. */
#define MAX_SILENT_GAIN 0.01
/* Up to this share, where the motion has as much, all of it can be taken out, and the motion is
 * still to be trusted: what a step near the limit makes of a load that sets in. A sub-step that
 * makes more was too long: a tool that meets tissue within it, at 1 m/s, made 6 to 25 % of what was
 * there so far, hardly any of it motion yet. */
#define MAX_SLIGHT_GAIN 0.1

/* ---- the stable step ---- */

/* Adds to model->stiff and returns the strain term of one source. */
static double add_source_stiffness(ss_model *model, const ss_cnn_source *source)
{
    const ss_cnn_kernels *kernels = model->kernels;
    if (source->c1 > 0.0) {
        kernels->add_rows(model->part, 2.0 * source->c1, source->b, model->stiff);
    }
    return source->strain_modulus > 0.0
               ? source->strain_modulus *
                     kernels->weighted_square(model->part, source->r, model->mobility)
               : 0.0;
}

/* The longest step over which forces through the weights may stay frozen: a force that is held
 * while its stiffness k acts gains energy at the rate k h / (4 m), which damping must take up,
 * h <= 2 (gamma/m) / (k/m); a little is allowed where there is no damping. */
static double frozen_limit(const ss_model *model)
{
    double limit = (double)INFINITY;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_tool *tool = &model->tool[k];
        if (tool->base->is_present && tool->source.is_on && tool->mu_largest > 0.0) {
            const double rate2 = 2.0 * tool->mu_largest /
                                 (tool->base->delta * tool->base->delta * model->smallest_sigma);
            limit = fmin(limit,
                         fmax(2.0 * model->damping_rate_min / rate2, FROZEN_SHARE / sqrt(rate2)));
        }
    }
    return limit;
}

void ss_cnn_set_bound(ss_model *model)
{
    double omega2 = model->bulk_rate;
    for (int32_t s = 0; s < model->part->count; ++s) {
        const ss_cnn_span *span = &model->part->span[s];
        const int32_t end = span->node_end < model->node_count ? span->node_end : model->node_count;
        memcpy(model->stiff + span->node, model->material.rest_stiffness + span->node,
               (size_t)(end - span->node) * sizeof *model->stiff);
    }
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_source *source = ss_cnn_source_on(model, k);
        omega2 += source ? add_source_stiffness(model, source) : 0.0;
        omega2 += source && source->strain_modulus > 0.0
                      ? source->strain_modulus * ss_cnn_active_set_stiffness(model, k)
                      : 0.0;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        if (!tool->base->is_present) {
            continue;
        }
        omega2 += tool->is_fading ? ss_cnn_source_fading_stiffness(model, tool) : 0.0;
        ss_tool_add_diagonal(tool->base, model->stiff);
    }
    omega2 += fmax(model->kernels->largest(model->part, model->stiff, model->mobility_max),
                   model->set ? model->set->rate2 : 0.0);
    model->bound = fmin(ss_cnn_rk4_limit(model->damping_rate_min, model->damping_rate_max, omega2),
                        frozen_limit(model));
}

/* ---- forces ---- */

static void add_contact(ss_model *model, ss_cnn_tool *tool, const ss_real *u, double path)
{
    ss_tool_at(tool->base, path, &tool->base->pose);
    ss_copy3(tool->base->force, tool->frozen_force);
    ss_copy3(tool->base->torque, tool->frozen_torque);
    tool->base->penalty =
        ss_contact_query_penalty(tool->base->query, u, &tool->base->pose, model->force,
                                 tool->base->force, tool->base->torque);
    if (tool->base->has_friction) {
        double penalty[3];
        ss_sub3(penalty, tool->base->force, tool->frozen_force);
        ss_tool_rub(tool->base, penalty, tool->frozen_force, model->force);
    }
    if (tool->is_fading) {
        ss_cnn_source_add_fading(model, tool);
    }
    ss_grasp_add_forces(&tool->base->grasp, (const double(*)[3])model->plan.mesh->position, u,
                        &tool->base->pose, model->force, tool->base->force, tool->base->torque);
}

/* Takes the last contact and grasp forces out of model->force. */
static void clear_contact(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_tool *tool = &model->tool[k];
        const int32_t *node;
        const int32_t count =
            tool->base->is_present ? ss_contact_query_candidate_nodes(tool->base->query, &node) : 0;
        for (int32_t i = 0; i < count; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)node[i];
            memcpy(model->force + at, model->base + at, 4 * sizeof *model->force);
        }
        for (int32_t i = 0; tool->base->is_present && i < tool->base->grasp.count; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)tool->base->grasp.node[i];
            memcpy(model->force + at, model->base + at, 4 * sizeof *model->force);
        }
        for (int32_t i = 0; tool->base->is_present && tool->is_fading && i < tool->count; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)tool->node[i];
            memcpy(model->force + at, model->base + at, 4 * sizeof *model->force);
        }
    }
}

/* Quads of the nodes that a step works on. */
static void copy_quads(const ss_cnn_part *part, const ss_real *from, ss_real *to)
{
    for (int32_t s = 0; s < part->count; ++s) {
        const ptrdiff_t at = 4 * (ptrdiff_t)part->span[s].node;
        const ptrdiff_t end = 4 * (ptrdiff_t)part->span[s].node_end;
        memcpy(to + at, from + at, (size_t)(end - at) * sizeof *to);
    }
}

/* Sources beyond the first go into model->force as a whole; the first is left to the stage. */
static void evaluate_sources(ss_model *model)
{
    const ss_cnn_kernels *kernels = model->kernels;
    model->first = NULL;
    bool is_clean = model->enclosed_count > 1; /* their pressures come on top */
    if (is_clean) {
        copy_quads(model->part, model->base, model->force);
        model->has_loads_only = false;
    }
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_source *source = ss_cnn_source_on(model, k);
        if (source) {
            ss_cnn_source_evaluate(model, source, model->d);
        }
    }
    if (model->saturation) {
        ss_cnn_saturate(model);
    }
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_source *source = ss_cnn_source_on(model, k);
        if (!source) {
            continue;
        }
        if (!model->first) {
            model->first = source;
            continue;
        }
        if (!is_clean) {
            copy_quads(model->part, model->base, model->force);
            is_clean = true;
            model->has_loads_only = false;
        }
        const ss_real *b = model->is_held ? source->b : source->b_turned;
        kernels->axpy(model->part, -source->c1, source->r, model->force);
        if (source->c2 != 0.0) {
            kernels->axpy(model->part, source->c2, b, model->force);
        }
    }
}

/* All forces at displacements `u` with the tools at `path`; model->force must hold no contact, and
 * the change of one enclosed volume belongs to u. */
static void evaluate(ss_model *model, ss_real *u, double path)
{
    model->d = ss_cnn_fit(model, u);
    const double far_change = ss_cnn_active_set_evaluate(model, u);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        if (tool->base->is_present && tool->is_fading) {
            ss_tool_pose pose;
            ss_tool_at(tool->base, path, &pose);
            ss_cnn_source_fade(model, tool, u, &pose);
        }
    }
    evaluate_sources(model);
    ss_cnn_enclosed_evaluate(model, u, far_change);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (model->tools.tool[k].is_present) {
            add_contact(model, &model->tool[k], u, path);
        }
    }
}

/* ---- between sub-steps ---- */

/* Finds what the tools may reach between two places on their paths. */
static int32_t update_broad_phase(ss_model *model, double path, double next)
{
    int32_t count = 0;
    bool is_refitted = false;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        if (!tool->base->is_present) {
            continue;
        }
        if (!is_refitted) {
            ss_surface_refit(model->tools.surface, model->u);
            is_refitted = true;
        }
        ss_tool_pose from, to;
        ss_tool_at(tool->base, path, &from);
        ss_tool_at(tool->base, next, &to);
        count += ss_contact_query_broad_phase(tool->base->query, model->u, &from, &to);
    }
    return count;
}

static void set_totals(ss_model *model)
{
    model->kernels->total(model->part, model->u, model->v, model->rest_stiffness, model->mass,
                          &model->totals);
    model->has_totals = true;
}

static void set_energies(ss_model *model)
{
    if (!model->has_totals) {
        set_totals(model);
    }
    ss_cnn_active_set_add_totals(model, &model->totals);
    model->kinetic = 0.5 * model->totals.kinetic;
    double elastic = 0.5 * model->totals.rest;
    if (!model->is_held) {
        ss_cnn_totals fitted;
        model->kernels->total(model->part, model->d, model->v, model->rest_stiffness, model->mass,
                              &fitted);
        elastic = 0.5 * fitted.rest;
    }
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_source *source = ss_cnn_source_on(model, k);
        elastic += source ? ss_cnn_source_energy(model, source) : 0.0;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        elastic += tool->is_present ? ss_tool_energy(tool) : 0.0;
    }
    model->elastic = elastic + ss_cnn_enclosed_energy(model);
}

/* Everything at the present state with the tools at `path`: weights, forces, energies, bound. */
static void prepare(ss_model *model, double path)
{
    const bool has_tool = ss_tools_is_any(&model->tools);
    model->has_strain = false;
    model->d = ss_cnn_fit(model, model->u);
    ss_cnn_source_relax(model);
    if (has_tool || !model->has_loads_only) {
        copy_quads(model->part, model->load_force, model->base);
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        if (tool->base->is_present) {
            ss_tool_at(tool->base, path, &tool->base->pose);
            ss_cnn_source_weigh(model, tool, &tool->base->pose);
        }
    }
    if (has_tool || !model->has_loads_only) {
        copy_quads(model->part, model->base, model->force);
        model->has_loads_only = !has_tool;
    }
    const ss_real *normal = ss_cnn_enclosed_normal(model);
    if (normal && (!model->has_totals || model->plan.prescribed_count > 0)) {
        model->enclosed[0].change = model->kernels->dot(model->part, normal, model->u);
    }
    evaluate(model, model->u, path);
    set_energies(model);
    ss_cnn_set_bound(model);
    model->is_ready = true;
    model->has_totals = false;
}

/* ---- one sub-step ---- */

/* After the first stage: what the tools reach on the way, and no contact left in the forces. */
static void ready_contact(ss_model *model, double path, double next)
{
    clear_contact(model);
    update_broad_phase(model, path, next);
}

static void swap(ss_real **a, ss_real **b)
{
    ss_real *t = *a;
    *a = *b;
    *b = t;
}

static void swap_states(ss_model *model)
{
    ss_cnn_active_set_swap(model);
    swap(&model->u, &model->old_u);
    swap(&model->v, &model->old_v);
    swap(&model->u_low, &model->old_low);
}

/* Classical Runge-Kutta over `h` seconds; the state before is kept in old_*. */
static void runge_kutta(ss_model *model, double h, double path, double fraction)
{
    static const double place[4] = {0.0, 0.5, 0.5, 1.0};
    static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    ss_cnn_stage stage = {.part = model->part,
                          .h = h,
                          .force = model->force,
                          .normal = ss_cnn_enclosed_normal(model),
                          .rest_stiffness = model->rest_stiffness,
                          .damping = model->damping,
                          .mass = model->mass,
                          .mobility = model->mobility,
                          .u0 = model->u,
                          .v0 = model->v,
                          .low0 = model->u_low,
                          .us = model->us,
                          .vs = {model->vs[0], model->vs[1], model->vs[2]},
                          .u = model->old_u,
                          .v = model->old_v,
                          .low = model->old_low};
    for (int s = 0; s < 4; ++s) {
        if (s > 0) {
            clear_contact(model);
            evaluate(model, model->us, path + place[s] * fraction);
        }
        const ss_cnn_source *first = model->first;
        stage.index = s;
        stage.d = model->d;
        stage.r = first ? first->r : NULL;
        stage.b = first ? (model->is_held ? first->b : first->b_turned) : NULL;
        stage.c1 = first ? first->c1 : 0.0;
        stage.c2 = first ? first->c2 : 0.0;
        stage.pressure = stage.normal ? model->enclosed[0].pressure : 0.0;
        model->work += ss_tools_work(&model->tools) * fraction * share[s];
        if (model->plan.prescribed_count > 0) {
            const ss_real *v = s > 0 ? model->vs[s - 1] : model->v;
            const double work = ss_cnn_prescribed_work(model, stage.d, v, h, share[s]);
            model->work += work;
            model->load_work += work;
        }
        model->dissipated += h * share[s] * model->kernels->stage(&stage);
        model->dissipated += h * share[s] * ss_cnn_active_set_stage(model, s, h);
        if (stage.normal) {
            model->enclosed[0].change = stage.volume;
        }
        if (s == 0) {
            ready_contact(model, path, path + fraction);
        }
    }
    model->totals = stage.totals;
    model->has_totals = true;
    swap_states(model);
}

static bool is_finite_state(const ss_model *model)
{
    return isfinite(model->totals.kinetic) && isfinite(model->totals.rest) &&
           isfinite(model->totals.largest);
}

/* Can a gain be taken out of the motion, with the motion still to be trusted? */
static bool is_slight(const ss_model *model, double gain)
{
    return gain < model->kinetic && gain <= MAX_SLIGHT_GAIN * (model->elastic + model->kinetic);
}

/* Energy that came from nowhere in an accepted sub-step goes out of the motion again: strains far
 * beyond the body's size, which forces frozen over a sub-step cannot follow, then never feed on
 * themselves. */
static void take_gain(ss_model *model, double gain)
{
    const bool can_be_trusted = is_slight(model, gain);
    const double left = model->kinetic > gain ? 1.0 - gain / model->kinetic : 0.0;
    const ss_real factor = (ss_real)sqrt(left);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        model->v[at] *= factor;
    }
    ss_cnn_active_set_damp(model, sqrt(left));
    model->kinetic *= left;
    model->fault_bits |= SS_MODEL_FAULT_ENERGY;
    if (!can_be_trusted || model->verdict < SOFTSIM_VERDICT_GUARDED) {
        model->verdict = can_be_trusted ? SOFTSIM_VERDICT_GUARDED : SOFTSIM_VERDICT_DEGRADED;
        model->reason = SS_GAIN_REASON;
    }
}

static double most_silent(const ss_model *model)
{
    return MAX_SILENT_GAIN * (model->elastic + model->kinetic) + model->small_energy;
}

static void damp_gain(ss_model *model, double gain)
{
    if (gain > most_silent(model)) {
        take_gain(model, gain);
    }
}

/* Gains too small for one sub-step add up; `gain` of an outer step, after what its sub-steps took
 * out. */
static void damp_pool(ss_model *model, double gain, double dt)
{
    const double most = most_silent(model);
    model->pool = ss_plan_pool_gain(model->pool, gain, most, dt);
    if (model->pool > most) {
        take_gain(model, model->pool);
        model->pool = 0.0;
    }
}

/* Energy that vanished in an accepted sub-step: Runge-Kutta damps motion near its stable step, and
 * forces frozen over a sub-step miss what a quick tool does in it. */
static void tell_loss(ss_model *model, double loss)
{
    if (loss > most_silent(model) && model->verdict == SOFTSIM_VERDICT_GOOD) {
        model->verdict = SOFTSIM_VERDICT_GUARDED;
        model->reason = "a sub-step was long enough to lose energy";
    }
}

/* A displacement far beyond the body means nothing any more and would drown every digit. */
static void clamp_displacements(ss_model *model)
{
    const double limit = SS_MAX_DISPLACEMENT * model->diagonal;
    if (model->totals.largest > limit * limit &&
        ss_clamp_displacements(model->node_count, limit, model->u, model->v)) {
        model->is_ready = false;
        model->fault_bits |= SS_MODEL_FAULT_CLAMPED;
        model->verdict = SOFTSIM_VERDICT_DEGRADED;
        model->reason = SS_CLAMPED_REASON;
    }
}

/* ---- the outer step ---- */

static double energy_balance(const ss_model *model)
{
    return model->kinetic + model->elastic - model->work + model->dissipated;
}

/* Taking over where the tools go; what changed with a jump is prepared again. */
static void take_tools(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *own = &model->tool[k];
        const bool was_present = own->base->is_present;
        const ss_tool_news news = ss_tool_take(own->base, tool ? &tool[k] : NULL);
        model->is_ready = model->is_ready && news == SS_TOOL_KEPT;
        if (news == SS_TOOL_LOST || !was_present || !own->base->is_present) {
            ss_cnn_source_end_contact(own);
            own->source.is_placed = true;
        }
        if (!own->base->is_present) {
            own->source.is_on = false;
            own->count = 0;
        }
    }
}

/* Loads that changed since the last step replace their old selves in base and force. */
static void take_loads(ss_model *model, double time)
{
    const ss_cnn_part *part = model->part;
    if (model->loads.node_count == 0 && model->source_count == 0) {
        return;
    }
    if (ss_cnn_loads_update(model, time)) {
        model->kernels->axpy(part, -1.0, model->load_force, model->force);
        model->kernels->axpy(part, -1.0, model->load_force, model->base);
        ss_cnn_loads_build(model);
        model->has_loads_only = false; /* but for rounding */
        model->kernels->axpy(part, 1.0, model->load_force, model->force);
        model->kernels->axpy(part, 1.0, model->load_force, model->base);
    }
}

/* Everything again with the tools at `path`, after what a grasp holds changed; returns what that
 * took from the energy. */
static double prepare_grasp(ss_model *model, double path)
{
    const double before = energy_balance(model);
    model->has_totals = false;
    prepare(model, path);
    return before - energy_balance(model);
}

/* The button's press stores where the touched nodes are in the tool's frame. */
static void take_grasp(ss_model *model, ss_cnn_tool *tool)
{
    ss_grasp *grasp = &tool->base->grasp;
    if (grasp->count > 0) { /* still letting go: what is left of it is lost at once */
        grasp->count = 0;
        ss_cnn_source_book(model, &tool->source, prepare_grasp(model, 0.0));
    }
    ss_grasp_take(grasp, tool->count, tool->node, tool->weight,
                  SS_GRASP_STIFFNESS_RATIO * tool->base->stiffness,
                  (const double(*)[3])model->plan.mesh->position, model->u, &tool->base->pose);
    if (grasp->count > 0) {
        ss_grasp_stretch(grasp, ss_cnn_source_weight_forces(model, tool), &tool->base->pose);
        model->work -= prepare_grasp(model, 0.0);
    }
}

/* Grasps that were let go fade by `h` seconds' worth, tissue and tools at rest: what their springs
 * and the weights of their cells take from the energy is then booked whole. */
static void fade_grasps(ss_model *model, double path, double h)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_grasp *grasp = &model->tools.tool[k].grasp;
        if (grasp->count == 0 || grasp->is_pressed) {
            continue;
        }
        ss_grasp_fade(grasp, h);
        const double springs = ss_grasp_accept_fade(grasp);
        const double lost = prepare_grasp(model, path);
        model->dissipated += springs;
        ss_cnn_source_book(model, &model->tool[k].source, lost - springs);
    }
}

/* Sub-steps that the tools' motion asks for: at most R/4 each, if anything is in the way. */
static int32_t motion_steps(ss_model *model)
{
    const double steps = ss_tools_parts(&model->tools);
    if (steps > 1.0 && update_broad_phase(model, 0.0, 1.0) == 0) {
        return 1;
    }
    return (int32_t)fmin(steps, (double)model->plan.max_substeps);
}

static void fault(ss_model *model)
{
    model->fault_bits |= SS_MODEL_FAULT_NOT_FINITE;
    model->verdict = SOFTSIM_VERDICT_FAULT;
    model->reason = SS_KEPT_REASON;
    model->is_ready = false;
}

/* Where the outer step stands. */
typedef struct progress {
    ss_substeps steps;
    double cap; /* s: after a sub-step was taken back */
    int32_t accepted, rejected;
    bool is_telling; /* what was taken back could have been felt */
} progress;

/* Sub-steps for what is left where each may be twice as long as the one before, up to `stable`. */
static double least_substeps(const progress *p, double stable)
{
    const double left = p->steps.left;
    const double growing = p->cap < left ? 1.0 + ilogb(left / p->cap) : 0.0;
    return growing + ss_substeps_needed(&p->steps, stable);
}

/* What a sub-step that is taken back must put back beside u and v; the rest is derived. */
typedef struct booked {
    double work, dissipated, load_work;
} booked;

static void take_back(ss_model *model, progress *p, const booked *before, double h)
{
    ++p->rejected;
    p->cap = (p->rejected < MAX_REJECTED / 2 ? 0.5 : 0.0625) * h;
    swap_states(model);
    ss_cnn_source_restore(model);
    update_broad_phase(model, p->steps.path, p->steps.path);
    model->has_totals = false;
    model->work = before->work;
    model->dissipated = before->dissipated;
    model->load_work = before->load_work;
    prepare(model, p->steps.path); /* books what it changes by itself */
}

/* The network goes on in its own time; what its changed flux densities bring or take is work. */
static void relax_network(ss_model *model, double path)
{
    const double before = energy_balance(model);
    if (!ss_cnn_relax_advance(model->relax)) {
        return;
    }
    prepare(model, path);
    model->work += energy_balance(model) - before;
}

/* The active set follows the load; the energy that a change of it costs is booked as lost. */
static void move_active_set(ss_model *model, double path)
{
    if (ss_cnn_active_set_look(model)) {
        const double before = energy_balance(model);
        model->has_totals = model->has_loads_only = false;
        prepare(model, path);
        model->dissipated += before - energy_balance(model);
    }
}

/* One attempt; false when the model is at fault. */
static bool try_substep(ss_model *model, progress *p)
{
    double h, fraction;
    const double stable = STEP_SHARE * model->bound;
    ss_substeps_plan(&p->steps, fmin(stable, p->cap), least_substeps(p, stable), &h, &fraction);
    const double balance = energy_balance(model);
    ss_cnn_prescribed_place(model, p->steps.path, fraction, h);
    const booked before = {model->work, model->dissipated, model->load_work};
    ss_cnn_source_keep(model);
    runge_kutta(model, h, p->steps.path, fraction);
    ++p->steps.taken_count;
    bool is_good = is_finite_state(model);
    double loads = 0.0, gain = 0.0;
    const double next = ss_substeps_next(&p->steps, fraction);
    if (is_good) {
        ss_cnn_prescribed_place(model, next, 0.0, 0.0);
        loads = ss_cnn_loads_work(model);
        prepare(model, next);
        model->dissipated += ss_tools_friction_loss(&model->tools);
        gain = energy_balance(model) - loads - balance;
        /* A gain that no hand feels is rounding, as under a tool that stands beside the body. */
        const double energy = model->elastic + model->kinetic;
        is_good = model->bound >= h &&
                  (p->rejected >= MAX_REJECTED / 4 || fabs(energy) <= model->small_energy ||
                   !(gain > most_silent(model)) || is_slight(model, gain));
    }
    if (!is_good) {
        p->is_telling |= !(fabs(model->elastic + model->kinetic) <= model->small_energy);
        take_back(model, p, &before, h);
        if (p->rejected >= MAX_REJECTED) {
            fault(model);
        }
        return p->rejected < MAX_REJECTED;
    }
    (void)ss_tools_keep_friction(&model->tools);
    damp_gain(model, gain);
    model->work += loads;
    model->load_work += loads;
    fade_grasps(model, next, h);
    ss_cnn_spring_settle(model, h);
    tell_loss(model, balance - energy_balance(model));
    if (model->relax) {
        relax_network(model, next);
    }
    move_active_set(model, next);
    p->steps.left -= h;
    p->steps.path = next;
    p->cap = 2.0 * fmin(p->cap, (double)FLT_MAX);
    ++p->accepted;
    return true;
}

/* The network does not compute element volumes. Inactive nodes keep their last positions: far from
 * the active set, where no element inverts. */
static void judge_inverted(ss_model *model)
{
    const bool is_volume = model->material.element == SS_CNN_TETRAHEDRON;
    const int32_t t = is_volume ? ss_inverted_look(&model->inverted, model->u) : -1;
    if (t >= 0) {
        model->worst = model->plan.mesh->tetrahedron[t][0];
    }
    if (t >= 0 && model->verdict < SOFTSIM_VERDICT_DEGRADED) {
        model->verdict = SOFTSIM_VERDICT_DEGRADED;
        model->reason = SS_INVERTED_REASON;
    }
}

void ss_cnn_step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    if (!ss_model_begin(&model->verdict, &model->reason, dt)) {
        return;
    }
    model->damped = 0.0;
    model->worst = -1;
    take_tools(model, tool);
    take_loads(model, time + 0.5 * dt);
    ss_cnn_prescribed_update(model, time + dt);
    if (!model->is_ready) {
        const double before = model->elastic - model->work + model->dissipated;
        update_broad_phase(model, 0.0, 0.0);
        model->has_totals = false;
        prepare(model, 0.0);
        model->work = model->elastic + model->dissipated - before;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (model->tools.tool[k].is_present) {
            ss_grasp *grasp = &model->tools.tool[k].grasp;
            const bool is_holding =
                ss_grasp_follow_button(grasp, tool[k].is_grasping, model->tools.tool[k].force);
            if (is_holding && !grasp->is_pressed) {
                take_grasp(model, &model->tool[k]);
            }
            grasp->is_pressed = is_holding;
        }
    }
    const double balance = energy_balance(model);
    progress p = {
        .steps = {.left = dt, .motion = motion_steps(model), .most = model->plan.max_substeps},
        .cap = (double)INFINITY};
    while (p.steps.path < 1.0 && (p.steps.taken_count < p.steps.most || p.accepted == 0)) {
        if (!try_substep(model, &p)) {
            return;
        }
        clamp_displacements(model);
    }
    if (!isfinite(model->elastic + model->kinetic)) {
        fault(model);
        return;
    }
    damp_pool(model, energy_balance(model) - balance, dt);
    if (model->verdict == SOFTSIM_VERDICT_GOOD && p.is_telling) {
        model->verdict = SOFTSIM_VERDICT_GUARDED;
        model->reason = "a sub-step was taken back and halved";
    }
    if (model->verdict == SOFTSIM_VERDICT_GOOD && model->damped > most_silent(model)) {
        model->verdict = SOFTSIM_VERDICT_GUARDED;
        model->reason =
            "a tool met tissue that was strained already: its springing back was damped";
    }
    if (p.steps.left > 1e-6 * dt) {
        model->fault_bits |= SS_MODEL_FAULT_BUDGET;
        model->verdict = SOFTSIM_VERDICT_DEGRADED;
        model->reason = SS_SLOW_REASON;
    }
    judge_inverted(model);
    model->substeps = p.accepted;
    model->travelled = p.steps.path;
    ++model->step;
}
