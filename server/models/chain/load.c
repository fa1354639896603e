/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * What acts on the chain without a tool: forces and pressures as current sources, I = f/(2 k);
 * prescribed displacements as cells that are moved at the start of each sub-step, before the others
 * answer (fixed-state cells: the paper's Dirichlet condition, and its contact point). Reactions are
 * sampled there too, F = -(2 k dP + f): what the links pull after the cells were moved; sampled
 * after the answer they would miss the part that decays within a sub-step.
 *
 * The work of a prescribed cell is the change of W while the others stand still, from its own
 * links.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* ---- set-up ---- */

static void create_prescribed(ss_model *model, int32_t which)
{
    const ss_prescribed *set = &model->plan.prescribed[which];
    ss_prescribed_set_init(&model->prescribed[which].set, set, &model->arena);
    for (int32_t i = 0; i < set->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (ss_plan_is_prescribed(set, i, k)) {
                model->free[4 * (ptrdiff_t)set->node[i] + k] = 0;
                model->is_bound[set->node[i]] = 1;
            }
        }
    }
}

static softsim_status set_fixed(ss_model *model)
{
    model->fixed = ss_arena_get(&model->arena, (size_t)model->node_count, sizeof *model->fixed);
    if (!model->fixed) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        const uint8_t axes = model->plan.fixed[i] & 7;
        for (int k = 0; k < 3; ++k) {
            model->free[4 * (ptrdiff_t)i + k] = (axes & (1 << k)) == 0;
        }
        model->is_bound[i] = axes != 0;
        if (axes != 0) {
            model->fixed[model->fixed_count++] = i;
        }
    }
    return SOFTSIM_OK;
}

softsim_status ss_chain_loads_create(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    ss_arena *arena = &model->arena;
    softsim_status status =
        ss_loads_create(&model->loads, plan, "cnn-chainmail", false, arena, error);
    model->prescribed =
        ss_arena_get(arena, (size_t)plan->prescribed_count, sizeof *model->prescribed);
    status = status == SOFTSIM_OK ? set_fixed(model) : status;
    for (int32_t k = 0; model->prescribed && k < plan->prescribed_count; ++k) {
        create_prescribed(model, k);
    }
    return status == SOFTSIM_OK ? ss_arena_status(arena) : status;
}

/* ---- loads ---- */

void ss_chain_loads_update(ss_model *model, double time)
{
    const bool is_changed = ss_loads_update(&model->loads, time);
    model->has_current = ss_loads_is_any_acting(&model->loads);
    if (is_changed) {
        ss_loads_clear(&model->loads, model->current);
        ss_loads_add(&model->loads, model->u, 2.0 * model->k, model->current);
    }
}

void ss_chain_loads_apply(ss_model *model)
{
    for (int32_t k = 0; model->has_current && k < model->loads.node_count; ++k) {
        const ptrdiff_t at = 4 * (ptrdiff_t)model->loads.node[k];
        for (int a = 0; a < 3; ++a) {
            model->pull[at + a] += model->current[at + a];
        }
        ss_chain_set_add(&model->front.moving, model->loads.node[k]);
    }
}

double ss_chain_loads_work(const ss_model *model, double sign)
{
    double work = 0.0;
    for (int32_t k = 0; model->has_current && k < model->loads.node_count; ++k) {
        const ptrdiff_t at = 4 * (ptrdiff_t)model->loads.node[k];
        for (int a = 0; a < 3; ++a) {
            work += (double)model->current[at + a] * (double)model->u[at + a];
        }
    }
    return sign * 2.0 * model->k * work;
}

/* ---- prescribed cells ---- */

void ss_chain_prescribed_update(ss_model *model, double time)
{
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        ss_chain_prescribed *prescribed = &model->prescribed[s];
        const ss_prescribed *set = prescribed->set.plan;
        double middle[3] = {0.0, 0.0, 0.0};
        prescribed->is_moving = false;
        ss_prescribed_set_aim(&prescribed->set, model->u, time);
        for (int32_t i = 0; i < set->node_count; ++i) {
            double *from = prescribed->set.from[i], *to = prescribed->set.to[i];
            for (int k = 0; k < 3; ++k) {
                if (ss_plan_is_prescribed(set, i, k)) {
                    to[k] = (double)(ss_real)to[k];
                    prescribed->is_moving = prescribed->is_moving || from[k] != to[k];
                    middle[k] += to[k] / set->node_count;
                }
            }
        }
        prescribed->drive.depth = ss_norm3(middle);
    }
}

/* A node's output, Q of step.c. */
static void output_at(const ss_model *model, int32_t at, double out[3])
{
    const ss_real *u = model->u + at;
    ss_set3(out, (double)u[0], (double)u[1], (double)u[2]);
    const double length = isfinite(model->saturation) ? ss_norm3(out) : 0.0;
    if (length > model->saturation) {
        ss_scale3(out, out, model->saturation / length);
    }
}

/* sum w/4 ex^2 of the links of one node, those to nodes in the mask half. */
static double energy_at(const ss_model *model, int32_t node, const uint8_t *is_inside)
{
    const ss_chain_net *net = model->net;
    double energy = 0.0;
    for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
        const ss_chain_group *group = &net->group[net->at[p] / SS_CHAIN_LANES];
        const int lane = net->at[p] % SS_CHAIN_LANES;
        double a[3], b[3];
        output_at(model, group->a[lane], a);
        output_at(model, group->b[lane], b);
        const double d[3] = {(double)group->x[lane] + (b[0] - a[0]),
                             (double)group->y[lane] + (b[1] - a[1]),
                             (double)group->z[lane] + (b[2] - a[2])};
        const double length = ss_norm3(d), rest = (double)group->rest[lane];
        const double slack = model->ratio * (double)group->slack[lane];
        const double ex =
            fmax(length - rest - slack, 0.0) - fmax(fmax(rest - slack, 0.0) - length, 0.0);
        const double share = is_inside[ss_chain_other(net, net->at[p], node)] ? 0.25 : 0.5;
        energy += share * (double)group->half[lane] * ex * ex;
    }
    return energy;
}

double ss_chain_energy_around(ss_model *model, int32_t count, const int32_t *node)
{
    double energy = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        model->is_placed[node[i]] = 1;
    }
    for (int32_t i = 0; i < count; ++i) {
        energy += energy_at(model, node[i], model->is_placed);
    }
    for (int32_t i = 0; i < count; ++i) {
        model->is_placed[node[i]] = 0;
    }
    return 2.0 * model->k * energy;
}

void ss_chain_prescribed_place(ss_model *model, double path)
{
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        ss_chain_prescribed *prescribed = &model->prescribed[s];
        const ss_prescribed *set = prescribed->set.plan;
        if (!prescribed->is_moving) {
            continue;
        }
        const double before = ss_chain_energy_around(model, set->node_count, set->node);
        for (int32_t i = 0; i < set->node_count; ++i) {
            const double *from = prescribed->set.from[i], *to = prescribed->set.to[i];
            for (int k = 0; k < 3; ++k) {
                if (ss_plan_is_prescribed(set, i, k)) {
                    const double at = path < 1.0 ? from[k] + path * (to[k] - from[k]) : to[k];
                    model->u[4 * (ptrdiff_t)set->node[i] + k] = (ss_real)at;
                }
            }
            ss_chain_wake(model, set->node[i]);
        }
        const double work = ss_chain_energy_around(model, set->node_count, set->node) - before;
        model->work += work;
        model->load_work += work;
    }
}

/* -(2 k dP + f) on the axes that `axes` has bits for. */
static void add_support(const ss_model *model, int32_t node, uint8_t axes, double out[3])
{
    for (int k = 0; k < 3; ++k) {
        if ((axes & (1 << k)) != 0) {
            out[k] -= 2.0 * model->k * (double)model->pull[4 * (ptrdiff_t)node + k];
        }
    }
}

static void add_fixed(ss_model *model, int32_t node)
{
    add_support(model, node, model->plan.fixed[node], model->fixed_reaction);
}

void ss_chain_sample_reactions(ss_model *model, bool is_full)
{
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        ss_chain_prescribed *prescribed = &model->prescribed[s];
        const ss_prescribed *set = prescribed->set.plan;
        ss_set3(prescribed->reaction, 0.0, 0.0, 0.0);
        for (int32_t i = 0; i < set->node_count; ++i) {
            add_support(model, set->node[i], ss_plan_driven_axes(set, i), prescribed->reaction);
        }
    }
    ss_set3(model->fixed_reaction, 0.0, 0.0, 0.0);
    for (int32_t k = 0; is_full && k < model->fixed_count; ++k) {
        add_fixed(model, model->fixed[k]);
    }
    /* Nothing pulls at nodes that are not in the front. */
    const ss_chain_set *moving = &model->front.moving;
    for (int32_t i = is_full ? -1 : ss_chain_set_next(moving, 0); i >= 0;
         i = ss_chain_set_next(moving, i + 1)) {
        if (i < model->node_count) {
            add_fixed(model, i);
        }
    }
}
