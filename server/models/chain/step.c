/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * Time: an outer step in equal sub-steps of explicit Euler, each in the paper's order: what is
 * prescribed moves first (prescribed cells, tools), forces are sampled, then all other cells
 * answer. Where the budget of sub-steps is not enough for the time, what is prescribed moves by the
 * share of its way that the time is simulated.
 *
 * Which links are looked at (the front): a group of links is left out while all its links are slack
 * and none of its nodes has moved since it was last looked at; it would add exactly 0. Groups and
 * nodes are gone through in increasing order either way, so the state with a front is that of the
 * full step to the last bit, and a poke costs what it moves, whatever the size of the body. Where
 * more than a third of the groups is awake the plain loops are quicker, and the front is looked for
 * again after a while. The coarse level and saturation touch every node: no front with them.
 *
 * Energy: E = 2 k W + contact, at the moment after the prescribed motion. Work is counted by what
 * does it: exactly for prescribed cells, loads and tools (the change of E, or I.du, while only they
 * move); what a change of alpha and the tetrahedron guard change of W is work too. Dissipation is
 * not counted by itself: sum of C |du|^2/h is up to ten times the loss at the largest stable step,
 * and a better rule would cost a second look at all links. It is what work leaves, and the energy
 * balance is therefore blind to energy that is lost; but it never falls. Euler at a stable step
 * only loses (material.c), so energy that comes from nowhere, all at once or creeping in, stays in
 * the energy balance as stored + dissipated - work > 0, and beyond rounding the verdict says so.
 *
 * Unloading ("chain links restored to their initial lengths"): alpha falls with the depth of the
 * deepest-pressed contact, alpha d/d_max (ramp), or to 0 as soon as one goes back (literal, which
 * can create energy in slow loops), and is 0 once nothing touches. It comes back within ten C.
 */
#include <math.h>
#include <string.h>

#include "models/common/substeps.h"
#include "rt/vec.h"

/* Groups awake beyond which plain loops are quicker, and sub-steps until the front is sought. */
#define FRONT_SHARE 0.33
enum { FRONT_AGE = 16 };
/* In C: the time in which alpha comes back. */
#define RETURN_TIME 10.0
/* Less than this share of the deepest counts as going back. */
#define FALLING_SHARE 0.999
/* Energy from nowhere over all stored, before it is said: rounding, and the kinks of links. */
#define MAX_SILENT_GAIN 0.02

/* Everything that is published is at rest from now on, but the energies of before. */
static void fault(ss_model *model)
{
    const size_t bytes = 4 * (size_t)model->padded * sizeof *model->u;
    memset(model->u, 0, bytes);
    memset(model->pull, 0, bytes);
    for (int32_t k = 0; k < model->plan.prescribed_count; ++k) {
        ss_set3(model->prescribed[k].reaction, 0.0, 0.0, 0.0);
    }
    ss_set3(model->fixed_reaction, 0.0, 0.0, 0.0);
    if (model->tools.surface) {
        ss_chain_tools_reset(model);
    }
    model->fault_bits |= SS_MODEL_FAULT_NOT_FINITE;
    ss_chain_tell(model, SOFTSIM_VERDICT_FAULT, "not finite: back at rest, waiting for reset");
}

/* ---- alpha ---- */

/* The share of alpha that one drive leaves. */
static double share_of(const ss_model *model, ss_chain_drive *drive)
{
    if (drive->depth >= drive->most) {
        drive->most = drive->depth;
        drive->is_falling = false;
    } else if (drive->depth < FALLING_SHARE * drive->most) {
        drive->is_falling = true;
    }
    if (model->unloading == SS_CHAIN_LITERAL) {
        return drive->is_falling ? 0.0 : 1.0;
    }
    return drive->most > 0.0 ? drive->depth / drive->most : 1.0;
}

/* The share of alpha that acts from now on; 1 before anything has touched. */
static double wanted_ratio(ss_model *model)
{
    double wish = -1.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_chain_tool *tool = &model->tool[k];
        if (tool->base->is_present && tool->is_touching) {
            wish = fmax(wish, share_of(model, &tool->drive));
        } else {
            tool->drive = (ss_chain_drive){0};
        }
    }
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        if (model->prescribed[s].drive.depth > 0.0 || model->prescribed[s].drive.most > 0.0) {
            wish = fmax(wish, share_of(model, &model->prescribed[s].drive));
        }
    }
    wish = model->has_current ? 1.0 : wish;
    model->has_touched = model->has_touched || wish >= 0.0;
    return wish >= 0.0 ? wish : model->has_touched ? 0.0 : 1.0;
}

/* Sets the ratio; true when it changed. What that does to W is work. */
static bool follow_unloading(ss_model *model, double h)
{
    if (model->unloading == SS_CHAIN_KEEP || !model->has_alpha) {
        return false;
    }
    const double wish = wanted_ratio(model);
    const double next = fmin(wish, model->ratio + h / (RETURN_TIME * model->capacitance));
    if ((ss_real)next == (ss_real)model->ratio) {
        return false;
    }
    const double before = model->kernels->measure(model->net, (ss_real)model->ratio, model->output);
    model->ratio = next;
    const double after = model->kernels->measure(model->net, (ss_real)next, model->output);
    model->work += 2.0 * model->k * (after - before);
    return true;
}

/* ---- saturation ---- */

/* Q = sat(u) */
static void saturate(ss_model *model)
{
    const double limit = model->saturation;
    int32_t count = 0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        const ss_real *u = model->u + 4 * (ptrdiff_t)i;
        ss_real *q = model->output + 4 * (ptrdiff_t)i;
        const double x[3] = {(double)u[0], (double)u[1], (double)u[2]};
        const double length = ss_norm3(x), share = length > limit ? limit / length : 1.0;
        count += share < 1.0;
        for (int k = 0; k < 3; ++k) {
            q[k] = share < 1.0 ? (ss_real)(share * x[k]) : u[k];
        }
    }
    model->is_saturated = count > 0;
    if (model->is_saturated) {
        ss_chain_tell(model, SOFTSIM_VERDICT_GUARDED, "cells are saturated");
    }
}

/* (Q - u)/R into pull, R = 1. */
static void draw_back(ss_model *model)
{
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        model->pull[at] += model->output[at] - model->u[at];
    }
}

/* ---- a sub-step ---- */

static void wake_all(ss_model *model)
{
    ss_chain_front *front = &model->front;
    for (int32_t g = 0; g < model->net->group_count; ++g) {
        ss_chain_set_add(&front->awake, g);
    }
}

static void swap_sets(ss_chain_set *a, ss_chain_set *b)
{
    const ss_chain_set t = *a;
    *a = *b;
    *b = t;
}

static void clear_set(ss_chain_set *set)
{
    memset(set->bit, 0, (size_t)set->word_count * sizeof *set->bit);
    memset(set->word, 0, (size_t)set->top_count * sizeof *set->word);
}

/* The front is not known any more. */
static void lose_front(ss_model *model)
{
    if (!model->is_all_awake) {
        clear_set(&model->front.awake);
        clear_set(&model->front.next);
        clear_set(&model->front.stay);
        model->is_all_awake = true;
    }
}

/* Which loops this sub-step takes: false for those of the front. */
static bool choose_full(ss_model *model, int32_t index, bool is_changed)
{
    if (ss_chain_is_aggregated(model) && index % model->stride != 0) {
        clear_set(&model->front.awake);
        clear_set(&model->front.next);
        ss_chain_wake_own(model);
        return false; /* the far field rests */
    }
    if (model->coarse || isfinite(model->saturation)) {
        return true;
    }
    if (is_changed) {
        lose_front(model);
        model->age = 0;
        return true;
    }
    if (model->is_all_awake && ++model->age >= FRONT_AGE) {
        wake_all(model);
        model->is_all_awake = false;
        model->age = 0;
    }
    return model->is_all_awake;
}

/* W of the leak, m^2: its pull -u/R_rest is the gradient of -|u|^2/(2 R_rest). */
static double leak_energy(const ss_model *model)
{
    double sum = 0.0;
    for (ptrdiff_t at = 0; model->leak > 0.0 && at < 4 * (ptrdiff_t)model->node_count; ++at) {
        sum += (double)model->u[at] * (double)model->u[at];
    }
    return 0.5 * model->leak * sum;
}

/* What the network and its leak store now, and what that says of the sub-steps before. */
static void balance(ss_model *model)
{
    double elastic = 2.0 * model->k * (model->network + leak_energy(model));
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        elastic += model->tools.tool[k].is_present ? ss_tool_energy(&model->tools.tool[k]) : 0.0;
    }
    const double lost = model->work + model->gained - elastic - model->dissipated;
    if (lost >= 0.0) {
        model->dissipated += lost;
    } else if (-lost > MAX_SILENT_GAIN * elastic + model->small) {
        model->gained -= lost;
        model->fault_bits |= SS_MODEL_FAULT_ENERGY;
        ss_chain_tell(model, SOFTSIM_VERDICT_DEGRADED,
                      "spurious energy: work is less than what is stored and dissipated");
    }
    model->elastic = elastic;
    model->booked = model->work;
}

static bool is_finite_now(const ss_model *model)
{
    double sum = model->network;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        sum += model->tools.tool[k].is_present ? model->tools.tool[k].penalty : 0.0;
    }
    return isfinite(sum);
}

/* A displacement far beyond the body means nothing any more and would drown every digit. False for
 * one that is no number. */
static bool clamp_displacements(ss_model *model)
{
    const double limit = SS_MAX_DISPLACEMENT * model->diagonal;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        const double u = (double)model->u[at];
        if (isnan(u)) {
            return false;
        }
        model->u[at] = fabs(u) > limit ? (ss_real)copysign(limit, u) : model->u[at];
    }
    lose_front(model);
    model->fault_bits |= SS_MODEL_FAULT_CLAMPED;
    ss_chain_tell(model, SOFTSIM_VERDICT_DEGRADED, SS_CLAMPED_REASON);
    return true;
}

/* -u/R_rest into pull. */
static void leak(ss_model *model)
{
    const ss_real share = (ss_real)model->leak;
    for (ptrdiff_t at = 0; share > 0 && at < 4 * (ptrdiff_t)model->node_count; ++at) {
        model->pull[at] -= share * model->u[at];
    }
}

/* The cells answer to pull; those of a coarse level for `far` seconds. False when one has become
 * no number. */
static bool answer(ss_model *model, double h, double far, bool is_full, bool is_first)
{
    ss_chain_motion motion = {.h = (ss_real)h,
                              .mobility = model->mobility,
                              .leak = (ss_real)model->leak,
                              .pull = model->pull,
                              .u = model->u};
    const double left = ss_chain_loads_work(model, -1.0);
    model->work += left;
    if (model->coarse && is_full) {
        leak(model);
        motion.leak = 0;
        ss_chain_coarse_move(model, far, is_first);
    }
    if (is_full) {
        clear_set(&model->front.moving);
        model->kernels->move(model->padded, &motion);
        model->active_nodes = model->node_count;
    } else {
        ss_chain_front *front = &model->front;
        const int64_t before = front->nodes;
        model->kernels->move_front(model->net, front, &motion);
        model->active_nodes = (int32_t)(front->nodes - before);
        swap_sets(&front->awake, &front->next);
        swap_sets(&front->moving, &front->stay);
    }
    const double reached = ss_chain_loads_work(model, 1.0);
    model->work += reached;
    model->load_work += left + reached;
    return motion.largest <= SS_MAX_DISPLACEMENT * model->diagonal || clamp_displacements(model);
}

/* On to sub-step `index` of `count`, `h` seconds long, on `share` of the tools' way; false when the
 * model is at fault. */
static bool take_substep(ss_model *model, int32_t index, int32_t count, double h, double share)
{
    ss_chain_front *front = &model->front;
    const double path = share * (index + 1) / count;
    ss_chain_prescribed_place(model, path);
    ss_chain_tools_touch(model, index == 0, path);
    if (isfinite(model->saturation)) {
        saturate(model);
    }
    const bool is_full = choose_full(model, index, follow_unloading(model, h));
    const ss_real ratio = (ss_real)model->ratio;
    if (is_full) {
        model->network = model->kernels->pull(model->net, ratio, model->output, model->pull);
    } else {
        const int64_t looked_at = front->groups;
        model->network =
            model->kernels->pull_front(model->net, ratio, model->output, model->pull, front);
        if (!model->coarse &&
            (double)(front->groups - looked_at) > FRONT_SHARE * model->net->group_count) {
            model->is_crowded = true;
        }
    }
    model->first_network = index == 0 ? model->network : model->first_network;
    if (!is_finite_now(model)) {
        fault(model);
        return false;
    }
    if (is_full || !ss_chain_is_aggregated(model)) { /* else W is of a part alone */
        balance(model);
    }
    if (model->is_saturated) {
        draw_back(model);
    }
    ss_chain_loads_apply(model);
    ss_chain_tools_apply(model, h);
    if (index + 1 == count) {
        ss_chain_sample_reactions(model, is_full);
    }
    const int32_t left = count - index;
    const double far = h * (model->stride < left ? model->stride : left);
    if (!answer(model, h, far, is_full, index == 0)) {
        fault(model);
        return false;
    }
    if (model->is_crowded) {
        model->is_crowded = false;
        lose_front(model);
        model->age = 0;
    }
    return true;
}

/* W at the present displacements. */
static double network_now(ss_model *model)
{
    if (isfinite(model->saturation)) {
        saturate(model);
    }
    return model->kernels->pull(model->net, (ss_real)model->ratio, model->output, model->pull);
}

/* Puts tetrahedra back. Where no cell was moved nothing pays for a rise of W: the step is then
 * shortened until there is none. With tools the next sub-step tells; W of a part alone tells
 * nothing. */
static void keep_volumes(ss_model *model)
{
    enum { HALVINGS = 8, PASSES = 10 };
    bool is_held = true, is_alone = !ss_chain_is_aggregated(model);
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        is_held = is_held && !model->prescribed[s].is_moving;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        is_alone = is_alone && !model->tools.tool[k].is_present;
    }
    ss_chain_guard_step(model);
    if (model->guarded == 0 || !is_alone) {
        return;
    }
    for (int k = 1; !is_held && model->guarded > 0 && k < PASSES; ++k) {
        ss_chain_guard_step(model); /* neighbours undo one another's work */
    }
    model->network = network_now(model);
    for (int k = 0; is_held && k <= HALVINGS && model->network > model->first_network; ++k) {
        ss_chain_guard_withdraw(model, k < HALVINGS ? 0.5 : 1.0);
        model->network = network_now(model);
    }
    balance(model);
}

/* Where the guard had nothing to put back, no tetrahedron is inside out. */
static void judge_inverted(ss_model *model)
{
    if (model->guard && model->guarded == 0) {
        ss_inverted_pass(&model->inverted);
        return;
    }
    const int32_t t = ss_inverted_look(&model->inverted, model->u);
    if (t >= 0) {
        model->worst_element = model->plan.mesh->tetrahedron[t][0];
    }
    if (model->worst_element >= 0) {
        ss_chain_tell(model, SOFTSIM_VERDICT_DEGRADED, SS_INVERTED_REASON);
    }
}

/* ---- the outer step ---- */

/* Sub-steps that prescribed cells ask for: a quarter of a link each. */
static double prescribed_substeps(ss_model *model)
{
    double way = 0.0;
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        const ss_chain_prescribed *prescribed = &model->prescribed[s];
        for (int32_t i = 0; prescribed->is_moving && i < prescribed->set.plan->node_count; ++i) {
            double d[3];
            ss_sub3(d, prescribed->set.to[i], prescribed->set.from[i]);
            way = fmax(way, ss_norm3(d));
        }
    }
    const double steps = ceil(4.0 * way / model->net->mean_length - 1e-9);
    if (steps > model->plan.max_substeps) {
        ss_chain_tell(model, SOFTSIM_VERDICT_GUARDED,
                      "a prescribed set moved further in a step than its sub-steps can follow");
    }
    return steps;
}

void ss_chain_step(ss_model *model, double time, double dt,
                   const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    if (!ss_model_begin(&model->verdict, &model->reason, dt)) {
        return;
    }
    model->worst_element = -1;
    ss_chain_tools_take(model, tool);
    ss_chain_loads_update(model, time + 0.5 * dt);
    ss_chain_prescribed_update(model, time + dt);
    const double stable = ss_chain_stable_step(model), most = model->plan.max_substeps;
    const double by_time = fmax(1.0, ceil(dt / stable - 1e-9));
    const double by_way = fmax(ss_chain_tools_substeps(model), prescribed_substeps(model));
    const int32_t count = (int32_t)fmin(fmax(by_time, by_way), most);
    const double h = fmin(dt / count, stable);
    const double share = by_time > most ? count * h / dt : 1.0;
    if (by_time > most) {
        model->fault_bits |= SS_MODEL_FAULT_BUDGET;
        ss_chain_tell(model, SOFTSIM_VERDICT_DEGRADED, SS_SLOW_REASON);
    }
    if (ss_chain_is_aggregated(model)) {
        ss_chain_refine(model);
        model->stride = (int32_t)fmin(fmax(1.0, floor(ss_chain_aggregated_step(model) / h)), count);
    }
    if (model->guard) {
        ss_chain_guard_begin(model);
    }
    for (int32_t k = 0; k < count; ++k) {
        if (!take_substep(model, k, count, h, share)) {
            return;
        }
    }
    if (model->guard) {
        keep_volumes(model);
    }
    judge_inverted(model);
    ss_chain_tools_sample(model);
    model->substeps = count;
    model->travelled = share;
    ++model->step;
}
