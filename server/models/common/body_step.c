/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * Time: sub-steps whose length is computed, guards that say what they did, and an energy balance.
 *
 * Symplectic Euler (the default of explicit models): v+ = v + h (f(u, v)/m - alpha w), u+ = u + h
 * v+. That is the leapfrog method with v half a sub-step behind u; with b the lag before and a that
 * after, w = (v + b f/m)/(1 + b alpha) is the velocity at u's own time and
 *
 *   v+ = (1 - a alpha) w + a f/m,
 *
 * which stays centred when h changes and stable for any alpha. Its own energy, the stored one plus
 * half m v.v+ = half m (w^2 - b^2 (dv/dt)^2), is exact in a linear body: forces outside the law
 * change it by the mean of their value at both ends times the way. The energy balance uses just
 * these: what is left over is spurious energy, down to rounding in a linear body, of third order in
 * h otherwise. Kinetic energy as it is told is half m w^2. RK4 and models that step by themselves
 * have no lag.
 *
 * The step: omega^2 <= (limit / law's stable step)^2 + contact's (body_contact.c), sub-steps take
 * `step_share` of limit / omega in equal parts, where the contact's part may have a share of its
 * own: h^2 (law's / step_share^2 + contact's / contact_share^2) <= limit^2, stable since no share
 * is above 1. A tool moves at most R/4 in a sub-step. Where the budget of sub-steps is not enough
 * the body is simulated slower than time passes, each sub-step still stable, and tools and
 * prescribed axes go the same share of their ways: the whole way in a part of the time would press
 * at a multiple of the speed that a hand has. A node moves at most a fifth of an edge in an
 * explicit sub-step: no element can be inverted by the motion of a single one, and forces stay
 * within what a number can hold. What acted is said in the verdict. The positions at the start of
 * an outer step are kept, and come back when a number is not finite.
 *
 * Gains are summed over about 0.1 s, minus losses. Above 1 % of the stored energy (or what no hand
 * could feel) they are removed from the velocities. Models with their own step dissipate by
 * construction: losses are booked, only gains are judged. Where such a step is softer than its law
 * the law's energy is only an upper bound; what is sure is then that kinetic energy is no more than
 * all there was before, and the work.
 */
#include <math.h>
#include <string.h>

#include "models/common/substeps.h"
#include "rt/vec.h"

/* s, at the end of a step: the hand is told the mean force over it, each sub-step by its mean at
 * both ends, as work is booked. A stiff contact swings two or three times in it. Of implicit
 * contact the force at the sub-step's end is the one that acted all through it. */
#define MEAN_TIME 1e-3
/* Edges that a node may go in an explicit sub-step. */
#define MAX_EDGES 0.2
/* Gains, added up (ss_plan_pool_gain): of the energy. */
#define MAX_SILENT_GAIN 0.01
/* As long as no more than this share of the energy was taken out again within a tenth of a second,
 * the motion is to be trusted: a body that was drawn by a grasp and springs back gains 1.4 %. */
#define MAX_SLIGHT_GAIN 0.1
/* Of the energy: what the shadow (see set_motion) may be. A mode at omega h has (omega h / 2)^2 of
 * its stored energy, 1/4 at half the stable step, all of it where the method becomes unstable. */
#define MAX_SHADOW 0.75
/* omega h at which the integrators become unstable: of an undamped motion. */
#define EULER_LIMIT 2.0
#define RK4_LIMIT   2.8284271247461903

/* ---- evaluation ---- */

/* Kinetic energy, and what the method's own energy has less, half m b^2 (dv/dt)^2. Where nodes are
 * slowed down, forces say nothing of the next velocity. */
static void set_motion(ss_body *body)
{
    const ss_body_nodes *nodes = &body->nodes;
    const double lag = body->is_slowed ? 0.0 : nodes->kick_lag;
    double rate;
    ss_body_motion(nodes, body->is_idle, lag, body->own.mass_damping, body->mass, nodes->v,
                   &body->twice_kinetic, &rate);
    body->kinetic = 0.5 * body->twice_kinetic + ss_body_prescribed_kinetic(body);
    body->shadow = 0.5 * lag * lag * rate;
}

static bool has_implicit_contact(const ss_body *body)
{
    return !isfinite(body->own.planned_step);
}

/* All forces at the present state with the tools at `path`; with the energies at the end of an
 * outer step. A model that steps by itself needs its law's forces only there and at supports that
 * move. */
static void evaluate(ss_body *body, double path, bool has_energies)
{
    ss_body_nodes *nodes = &body->nodes;
    const ss_body_elastic *law = &body->own.elastic;
    const bool has_law = has_energies || body->is_explicit || body->plan.prescribed_count > 0;
    if (body->has_visible_loads) {
        memcpy(nodes->force, body->load_force, ss_body_bytes(body));
    } else {
        memset(nodes->force, 0, ss_body_bytes(body));
    }
    ss_body_energy energy = {.is_wanted = has_energies};
    if (has_law) {
        law->force(law->owner, nodes->u, nodes->v, nodes->force, &energy);
    }
    ss_body_add_contact(body, nodes->u, path, nodes->force);
    body->dissipated += ss_tools_keep_friction(&body->tools);
    body->has_elastic = has_law;
    body->power = energy.power;
    if (has_energies) {
        body->elastic = energy.elastic + ss_tools_energy(&body->tools);
        body->elastic_is_upper_bound = energy.elastic_is_upper_bound;
        set_motion(body);
    }
    body->contact_rate2 = has_implicit_contact(body) ? 0.0 : ss_body_contact_rate2(body);
    body->is_ready = true;
}

static void set_bound(ss_body *body)
{
    const double limit =
        body->is_explicit && body->own.integrator == SS_BODY_RK4 ? RK4_LIMIT : EULER_LIMIT;
    const double law2 = 1.0 / (body->law_step * body->law_step);
    const double contact2 = body->contact_rate2 / (limit * limit);
    const double share = body->own.step_share;
    const double contact_share = body->own.contact_share > 0.0 ? body->own.contact_share : share;
    body->bound = 1.0 / sqrt(law2 + contact2);
    body->longest = 1.0 / sqrt(law2 / (share * share) + contact2 / (contact_share * contact_share));
}

static double energy_balance(const ss_body *body)
{
    return body->kinetic - body->shadow + body->elastic - body->work + body->dissipated;
}

/* ---- integrators ---- */

static void tell_slow(ss_body *body, const ss_body_speed *speed)
{
    body->dissipated += speed->loss;
    body->speed_limit_loss += speed->loss;
    if (speed->is_slowed) {
        body->is_slowed = true;
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "a node faster than a fifth of an edge a sub-step was slowed down");
    }
}

/* Dissipation of viscosity and mass damping at the end of an outer step, over `span` seconds. */
static void book_losses(ss_body *body, double span)
{
    const ss_body_nodes *nodes = &body->nodes;
    double twice_kinetic = body->twice_kinetic, rate;
    if (body->is_slowed && body->own.mass_damping > 0.0) {
        ss_body_motion(nodes, body->is_idle, nodes->kick_lag, body->own.mass_damping, body->mass,
                       nodes->v, &twice_kinetic, &rate);
    }
    body->dissipated += span * (body->power + body->own.mass_damping * twice_kinetic);
}

static bool symplectic_euler(ss_body *body, double h)
{
    ss_body_nodes *nodes = &body->nodes;
    const ss_body_kick kick = {
        .lag = nodes->kick_lag, .ahead = 0.5 * h, .damping = body->own.mass_damping};
    const double limit = MAX_EDGES * body->own.edge / h;
    const double span = kick.lag + kick.ahead - body->booked_lag;
    const ss_body_speed speed =
        ss_body_kick_drift(nodes, body->is_idle, &kick, h, limit, body->mass, nodes->v, nodes->u);
    body->dissipated += span * (body->power + kick.damping * speed.twice_kinetic);
    body->booked_lag = 0.0;
    nodes->kick_lag = kick.ahead;
    tell_slow(body, &speed);
    return isfinite(speed.square);
}

/* Classical Runge-Kutta; tools and loads at the stages' times. */
static bool runge_kutta(ss_body *body, double h, double path, double fraction)
{
    static const double place[4] = {0.0, 0.5, 0.5, 1.0};
    static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    ss_body_nodes *nodes = &body->nodes;
    const ss_body_elastic *law = &body->own.elastic;
    const int32_t n = nodes->padded_count;
    ss_real *us = body->stage[0], *vs = body->stage[1], *rate = body->stage[2];
    ss_real *end = body->stage[3], *sum = body->stage[4]; /* u at the end, and the rate of v */
    const size_t bytes = ss_body_bytes(body);
    memset(sum, 0, bytes);
    memcpy(us, nodes->u, bytes);
    memcpy(vs, nodes->v, bytes);
    for (int s = 0; s < 4; ++s) {
        ss_body_energy energy = {.power = body->power};
        if (s > 0) {
            /* u and v of the stage from the rates of the one before: v first. */
            ss_body_blend(n, nodes->u, place[s] * h, vs, us);
            ss_body_blend(n, nodes->v, place[s] * h, rate, vs);
            memcpy(nodes->force, body->load_force, bytes);
            law->force(law->owner, us, vs, nodes->force, &energy);
            ss_body_add_contact(body, us, path + place[s] * fraction, nodes->force);
        }
        ss_body_rates(n, body->own.mass_damping, nodes->mobility, nodes->force, vs, rate);
        ss_body_axpy(n, share[s], rate, sum);
        double square, unused;
        ss_body_motion(nodes, body->is_idle, 0.0, 0.0, body->mass, vs, &square, &unused);
        body->dissipated += h * share[s] * (energy.power + body->own.mass_damping * square);
        if (s == 0) {
            ss_body_blend(n, nodes->u, share[0] * h, vs, end);
        } else {
            ss_body_axpy(n, share[s] * h, vs, end);
        }
    }
    ss_body_axpy(n, h, sum, nodes->v);
    /* The same limit as with the other method, on the way and on the velocity. */
    ss_body_blend(n, end, -1.0, nodes->u, us);
    const double limit = MAX_EDGES * body->own.edge;
    const ss_body_kick none = {0.0, 0.0, 0.0};
    (void)ss_body_kick_drift(nodes, body->is_idle, &none, 1.0, limit, body->mass, us, nodes->u);
    const ss_body_speed speed =
        ss_body_kick_drift(nodes, body->is_idle, &none, 0.0, limit / h, body->mass, nodes->v, us);
    tell_slow(body, &speed);
    return isfinite(speed.square);
}

/* ---- guards ---- */

/* The energy balance goes back with the positions; the motion that is stopped is lost. */
static void restore_last_good(ss_body *body, const char *reason)
{
    body->work = body->step_start.work;
    body->elastic = body->step_start.elastic;
    body->dissipated =
        body->step_start.dissipated + body->step_start.kinetic - body->step_start.shadow;
    body->kinetic = body->shadow = 0.0;
    memcpy(body->nodes.u, body->old_u, ss_body_bytes(body));
    memset(body->nodes.v, 0, ss_body_bytes(body));
    body->nodes.kick_lag = body->booked_lag = 0.0;
    body->is_ready = false;
    ss_body_judge(body, SOFTSIM_VERDICT_FAULT, SS_MODEL_FAULT_NOT_FINITE, reason);
}

/* A displacement far beyond the body means nothing any more and would drown every digit. */
static void clamp_displacements(ss_body *body)
{
    const double limit = SS_MAX_DISPLACEMENT * body->diagonal;
    if (ss_body_largest(body->nodes.count, body->nodes.u) > limit * limit) {
        (void)ss_clamp_displacements(body->nodes.count, limit, body->nodes.u, body->nodes.v);
        body->is_ready = false;
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, SS_MODEL_FAULT_CLAMPED, SS_CLAMPED_REASON);
    }
}

/* Spurious energy over the last outer step, judged. `gain`: of the energy balance;
 * `kinetic_gain`: of kinetic energy beyond all that there was and the work. */
static void judge_gain(ss_body *body, double gain, double kinetic_gain, double dt)
{
    const double most = MAX_SILENT_GAIN * (body->elastic + body->kinetic) + body->small_energy;
    if (!body->is_explicit && (gain < 0.0 || body->elastic_is_upper_bound)) {
        body->dissipated -= gain; /* what such a method loses by its nature */
        gain = fmax(0.0, kinetic_gain);
    }
    /* The method's own energy cannot tell that a step is too long: its two halves then grow with
     * opposite signs. */
    const double unstable = body->shadow - MAX_SHADOW * (body->elastic + body->kinetic);
    gain += fmax(0.0, unstable);
    body->pool = ss_plan_pool_gain(body->pool, gain, most, dt);
    body->removed = ss_plan_pool_gain(body->removed, 0.0, 0.0, dt); /* without a gain: decays */
    if (body->is_explicit && body->pool < -0.999 * most) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "sub-steps were long enough to lose energy");
    }
    if (!(body->pool > most)) {
        return;
    }
    double moving = 0.0;
    for (int32_t i = 0; i < body->nodes.count; ++i) {
        for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 3; ++at) {
            const double v = (double)body->nodes.v[at];
            moving += body->nodes.mobility[at] > 0 ? 0.5 * body->nodes.mass[i] * v * v : 0.0;
        }
    }
    const double removed = fmin(body->pool, moving);
    body->removed += moving > 0.0 ? removed / fmax(moving, body->elastic + body->kinetic) : 0.0;
    const bool is_slight =
        body->pool < moving && !(unstable > 0.0) && body->removed < MAX_SLIGHT_GAIN;
    const ss_real factor = moving > 0.0 ? (ss_real)sqrt(1.0 - removed / moving) : 0;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)body->nodes.count; ++at) {
        body->nodes.v[at] *= body->nodes.mobility[at] > 0 ? factor : 1;
    }
    set_motion(body);
    body->pool = 0.0;
    ss_body_judge(body, is_slight ? SOFTSIM_VERDICT_GUARDED : SOFTSIM_VERDICT_DEGRADED,
                  SS_MODEL_FAULT_ENERGY, SS_GAIN_REASON);
}

/* The loss to the limit of speeds is booked as if the nodes had moved on, which is too much where
 * forces would have turned them back: a gain up to that loss is explained. More is spurious energy,
 * added up as everywhere. */
static void judge_slowed(ss_body *body, double gain, double dt)
{
    const double most = MAX_SILENT_GAIN * (body->elastic + body->kinetic) + body->small_energy;
    const double explained = fmin(fmax(gain, 0.0), fmax(body->speed_limit_loss, 0.0));
    body->dissipated -= explained;
    body->pool = ss_plan_pool_gain(body->pool, gain - explained, most, dt);
    if (body->pool > most) {
        body->pool = 0.0;
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, SS_MODEL_FAULT_ENERGY,
                      "nodes were slowed down, and there is more energy than work was done");
    }
}

/* ---- the outer step ---- */

/* Work of loads, gravity and supports. */
static void book_load(ss_body *body, double work)
{
    body->work += work;
    body->load_work += work;
}

static void place_prescribed(ss_body *body, double path, double fraction, double h, bool is_booked)
{
    for (int32_t k = 0; k < body->plan.prescribed_count; ++k) {
        const double work = ss_prescribed_set_place(&body->prescribed[k], path, fraction, h,
                                                    body->nodes.mass, body->nodes.u, body->nodes.v);
        book_load(body, is_booked ? work : 0.0);
    }
}

/* False when a number is not finite. */
static bool advance(ss_body *body, double h, double path, double fraction, double next)
{
    const ss_body_elastic *law = &body->own.elastic;
    if (law->advance) {
        place_prescribed(body, next, fraction, h, false);
        law->advance(law->owner, body, h, next);
        return isfinite(ss_body_square(body->nodes.padded_count, body->nodes.v) +
                        ss_body_square(body->nodes.padded_count, body->nodes.u));
    }
    return body->own.integrator == SS_BODY_RK4 ? runge_kutta(body, h, path, fraction)
                                               : symplectic_euler(body, h);
}

/* The tools go to `path`, the nodes still: their work is what that adds to the contact's energy,
 * exactly, however little of the way they touch on. */
static void move_tools(ss_body *body, double path)
{
    if (ss_body_has_contact(body)) {
        const double before = ss_tools_energy(&body->tools);
        ss_body_external(body, body->nodes.u, path);
        body->work += ss_tools_energy(&body->tools) + ss_tools_friction_loss(&body->tools) - before;
    }
}

/* Is there way left, and a sub-step for it? */
static bool has_step_left(const ss_substeps *p)
{
    return p->path < 1.0 && p->taken_count < p->most;
}

/* One sub-step; false when the body is at fault. Work is force times way, the forces' mean at both
 * ends; a model that takes contact implicitly has the tools at their end before the nodes move. */
static bool substep(ss_body *body, ss_substeps *p)
{
    const ss_body_elastic *law = &body->own.elastic;
    double h, fraction;
    ss_substeps_plan(p, body->longest, ss_substeps_needed(p, body->longest), &h, &fraction);
    if (!(h > 0.0)) {
        restore_last_good(body, "no step is stable: last good state restored, waiting for reset");
        return false;
    }
    const double next = ss_substeps_next(p, fraction);
    body->path = p->path;
    place_prescribed(body, p->path, fraction, h, true);
    book_load(body, 0.5 * h * ss_body_prescribed_power(body));
    const double averaged = fmin(h, fmax(0.0, MEAN_TIME - (p->left - h)));
    if (has_implicit_contact(body)) {
        move_tools(body, next);
    } else {
        body->work += 0.5 * fraction * ss_tools_work(&body->tools);
        ss_tools_add_mean(&body->tools, 0.5 * averaged);
    }
    const bool is_finite = advance(body, h, p->path, fraction, next);
    place_prescribed(body, next, fraction, h, false);
    ss_tools_fade(&body->tools, h);
    if (is_finite && law->after_substep) {
        law->after_substep(law->owner, body, h);
    }
    ++p->taken_count;
    p->left -= h;
    p->path = next;
    if (is_finite) {
        evaluate(body, next, !has_step_left(p));
        ss_tools_add_mean(&body->tools, (has_implicit_contact(body) ? 1.0 : 0.5) * averaged);
        body->dissipated += ss_tools_accept_fade(&body->tools);
        book_load(body, 0.5 * h * ss_body_prescribed_power(body));
        if (!has_implicit_contact(body)) {
            body->work += 0.5 * fraction * ss_tools_work(&body->tools);
        }
        set_bound(body);
    } else {
        restore_last_good(body, SS_KEPT_REASON);
    }
    return is_finite;
}

/* Forces and energies with what has changed since the last step; the change of energy is work. */
static void refresh_forces(ss_body *body, bool has_new_loads)
{
    if (!body->is_ready) {
        const double before = body->elastic + body->kinetic - body->shadow + body->dissipated;
        evaluate(body, 0.0, true);
        body->work += body->elastic + body->kinetic - body->shadow + body->dissipated - before;
    } else if (has_new_loads) {
        for (int32_t k = 0; k < body->loads.node_count; ++k) {
            const ptrdiff_t at = 4 * (ptrdiff_t)body->loads.node[k];
            for (ptrdiff_t a = at; a < at + 3; ++a) {
                body->nodes.force[a] += body->load_force[a] - body->old_load[a];
            }
        }
        book_load(body, ss_body_loads_lag_work(body));
    }
}

void ss_body_step(ss_body *body, double time, double dt,
                  const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    if (!ss_model_begin(&body->verdict, &body->reason, dt)) {
        return;
    }
    body->worst_element = -1;
    body->was_slowed = body->is_slowed;
    body->is_slowed = false;
    body->speed_limit_loss = 0.0;
    memcpy(body->old_u, body->nodes.u, ss_body_bytes(body));
    body->step_start = (ss_body_energy_balance){.kinetic = body->kinetic,
                                                .elastic = body->elastic,
                                                .shadow = body->shadow,
                                                .work = body->work,
                                                .dissipated = body->dissipated};
    ss_body_take_tools(body, tool);
    const bool has_new_loads = ss_body_loads_update(body, time + 0.5 * dt);
    for (int32_t k = 0; k < body->plan.prescribed_count; ++k) {
        ss_prescribed_set_aim(&body->prescribed[k], body->nodes.u, time + dt);
    }
    const double before = energy_balance(body);
    refresh_forces(body, has_new_loads);
    ss_body_take_grasps(body, tool);
    refresh_forces(body, false);
    body->law_step = body->own.elastic.stable_step(body->own.elastic.owner, body);
    set_bound(body);
    ss_substeps p = {
        .left = dt, .motion = ss_body_motion_steps(body), .most = body->plan.max_substeps};
    ss_tools_begin_mean(&body->tools);
    while (has_step_left(&p)) {
        if (!substep(body, &p)) {
            return;
        }
    }
    book_load(body, ss_body_loads_work(body));
    book_losses(body, body->nodes.kick_lag);
    body->booked_lag = body->nodes.kick_lag;
    if (!isfinite(energy_balance(body))) {
        restore_last_good(body, SS_KEPT_REASON);
        return;
    }
    const double gain = energy_balance(body) - before;
    if (body->is_slowed || body->was_slowed) {
        judge_slowed(body, gain, dt);
    } else {
        judge_gain(body, gain, gain - body->elastic, dt);
    }
    clamp_displacements(body);
    if (p.left > 1e-6 * dt) {
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, SS_MODEL_FAULT_BUDGET, SS_SLOW_REASON);
    }
    body->substeps = p.taken_count;
    body->travelled = p.path;
    ++body->step;
}
