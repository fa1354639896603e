/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * What acts on a body without a tool, and what its supports answer.
 *
 * Loads are taken at the middle of an outer step and held through it; pressure follows the
 * deformed surface, once a step. Their work is force times way, exact. Prescribed axes move at
 * constant velocity through a step; their mobility is 0, and their support pushes with minus the
 * force that everything else has on them, as the supports of fixed axes do.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* ---- set-up ---- */

static void take_prescribed_mobility(ss_body *body, const ss_prescribed *set)
{
    for (int32_t i = 0; i < set->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (ss_plan_is_prescribed(set, i, k)) {
                body->axes[set->node[i]] = (uint8_t)(body->axes[set->node[i]] | 1 << k);
                body->nodes.mobility[4 * (ptrdiff_t)set->node[i] + k] = 0;
            }
        }
    }
}

softsim_status ss_body_loads_create(ss_body *body, softsim_error *error)
{
    const ss_model_plan *plan = &body->plan;
    const softsim_status status =
        ss_loads_create(&body->loads, plan, body->own.name, false, &body->arena, error);
    body->prescribed =
        ss_arena_get(&body->arena, (size_t)plan->prescribed_count, sizeof *body->prescribed);
    for (int32_t k = 0; body->prescribed && k < plan->prescribed_count; ++k) {
        ss_prescribed_set_init(&body->prescribed[k], &plan->prescribed[k], &body->arena);
        take_prescribed_mobility(body, &plan->prescribed[k]);
    }
    return status == SOFTSIM_OK ? ss_arena_status(&body->arena) : status;
}

/* ---- forces ---- */

static void add_gravity(ss_body *body, int32_t node)
{
    const double *unweighed = body->own.unweighed;
    const double mass = body->nodes.mass[node] - (unweighed ? unweighed[node] : 0.0);
    for (int k = 0; k < 3; ++k) {
        body->load_force[4 * (ptrdiff_t)node + k] += (ss_real)(mass * body->plan.gravity[k]);
    }
}

/* Everything on the loaded nodes again; gravity on the others does not change. */
static void build_loads(ss_body *body)
{
    ss_loads_clear(&body->loads, body->load_force);
    for (int32_t k = 0; k < body->loads.node_count; ++k) {
        add_gravity(body, body->loads.node[k]);
    }
    ss_loads_add(&body->loads, body->nodes.u, 1.0, body->load_force);
}

bool ss_body_loads_update(ss_body *body, double time)
{
    const bool is_changed = ss_loads_update(&body->loads, time);
    if (is_changed) {
        for (int32_t k = 0; k < body->loads.node_count; ++k) {
            const ptrdiff_t at = 4 * (ptrdiff_t)body->loads.node[k];
            memcpy(body->old_load + at, body->load_force + at, 4 * sizeof(ss_real));
        }
        build_loads(body);
        body->has_visible_loads = true;
    }
    return is_changed;
}

void ss_body_loads_reset(ss_body *body)
{
    memset(body->load_force, 0, ss_body_bytes(body));
    ss_loads_reset(&body->loads);
    for (int32_t i = 0; i < body->nodes.count; ++i) {
        add_gravity(body, i);
    }
    memcpy(body->old_load, body->load_force, ss_body_bytes(body));
    body->has_visible_loads = body->has_gravity;
}

void ss_body_set_idle(ss_body *body, int32_t node)
{
    const int32_t first = node / SS_BODY_BLOCK * SS_BODY_BLOCK;
    bool is_idle = true;
    for (int32_t i = first; i < first + SS_BODY_BLOCK && i < body->nodes.count; ++i) {
        is_idle = is_idle && body->nodes.mass[i] == 0.0;
    }
    body->is_idle[node / SS_BODY_BLOCK] = is_idle;
}

void ss_body_set_mass(ss_body *body, int32_t node, double mass)
{
    ss_real *mobility = body->nodes.mobility + 4 * (ptrdiff_t)node;
    const double change = mass - body->nodes.mass[node];
    for (int k = 0; k < 3; ++k) {
        const bool is_free = (body->axes[node] & (1 << k)) == 0;
        mobility[k] = is_free && mass > 0.0 ? (ss_real)(1.0 / mass) : 0;
        body->load_force[4 * (ptrdiff_t)node + k] += (ss_real)(change * body->plan.gravity[k]);
    }
    body->nodes.mass[node] = mass;
    body->mass[node] = (ss_real)mass;
    if (mass == 0.0 || body->is_idle[node / SS_BODY_BLOCK]) {
        ss_body_set_idle(body, node);
    }
}

/* ---- work ---- */

static double work_at(const ss_body *body, int32_t node)
{
    double work = 0.0;
    const ptrdiff_t at = 4 * (ptrdiff_t)node;
    for (int k = 0; k < 3; ++k) {
        work += (double)body->load_force[at + k] *
                ((double)body->nodes.u[at + k] - (double)body->old_u[at + k]);
    }
    return work;
}

double ss_body_loads_work(const ss_body *body)
{
    double work = 0.0;
    for (int32_t i = 0; body->has_gravity && i < body->nodes.count; ++i) {
        work += work_at(body, i);
    }
    for (int32_t k = 0; !body->has_gravity && k < body->loads.node_count; ++k) {
        work += work_at(body, body->loads.node[k]);
    }
    return work;
}

double ss_body_loads_lag_work(const ss_body *body)
{
    const double lag = body->nodes.kick_lag;
    double power = 0.0;
    for (int32_t k = 0; lag > 0.0 && k < body->loads.node_count; ++k) {
        const ptrdiff_t at = 4 * (ptrdiff_t)body->loads.node[k];
        for (ptrdiff_t a = at; a < at + 3; ++a) {
            const double change = (double)body->load_force[a] - (double)body->old_load[a];
            power += body->nodes.mobility[a] > 0 ? change * (double)body->nodes.v[a] : 0.0;
        }
    }
    return power * lag / (1.0 + lag * body->own.mass_damping);
}

/* ---- supports ---- */

double ss_body_prescribed_kinetic(const ss_body *body)
{
    double sum = 0.0;
    for (int32_t p = 0; p < body->plan.prescribed_count; ++p) {
        const ss_prescribed *set = body->prescribed[p].plan;
        for (int32_t i = 0; i < set->node_count; ++i) {
            for (int k = 0; k < 3; ++k) {
                const double v = (double)body->nodes.v[4 * (ptrdiff_t)set->node[i] + k];
                sum += ss_plan_is_prescribed(set, i, k)
                           ? 0.5 * body->nodes.mass[set->node[i]] * v * v
                           : 0.0;
            }
        }
    }
    return sum;
}

double ss_body_prescribed_power(const ss_body *body)
{
    double power = 0.0;
    for (int32_t p = 0; p < body->plan.prescribed_count; ++p) {
        const ss_prescribed *set = body->prescribed[p].plan;
        for (int32_t i = 0; i < set->node_count; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)set->node[i];
            for (int k = 0; k < 3; ++k) {
                power -= ss_plan_is_prescribed(set, i, k)
                             ? (double)body->nodes.force[at + k] * (double)body->nodes.v[at + k]
                             : 0.0;
            }
        }
    }
    return power;
}

void ss_body_reaction(const ss_body *body, int32_t set, double out_force[3])
{
    ss_set3(out_force, 0.0, 0.0, 0.0);
    if (!body->is_ready || !body->has_elastic || set < -1 || set >= body->plan.prescribed_count) {
        return;
    }
    if (set >= 0) {
        const ss_prescribed *prescribed = body->prescribed[set].plan;
        for (int32_t i = 0; i < prescribed->node_count; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)prescribed->node[i];
            for (int k = 0; k < 3; ++k) {
                out_force[k] -= ss_plan_is_prescribed(prescribed, i, k)
                                    ? (double)body->nodes.force[at + k]
                                    : 0.0;
            }
        }
        return;
    }
    for (int32_t i = 0; i < body->mesh_count; ++i) {
        for (int k = 0; (body->plan.fixed[i] & 7) != 0 && k < 3; ++k) {
            out_force[k] -= (body->plan.fixed[i] & (1 << k)) != 0
                                ? (double)body->nodes.force[4 * (ptrdiff_t)i + k]
                                : 0.0;
        }
    }
}
