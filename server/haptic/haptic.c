/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One haptic tick, in order:
 *   poses     the newest pose x, the hand's filtered velocity v, the observer's sums
 *   admission whether the hand may feel anything: watchdog, entry, pause, fault, stop
 *   result    a new local model, taken so that the force does not step; grasp edges
 *   coupling  the spring that lets the hand feel at most K_max
 *   balance   proxy and contact forces, within the force limit; damping of what hands out energy
 *   limits    ramp, slew
 *   output    the message, the target for the simulation, the history for the observer
 * No clock is read: time is the tick's number and the device's own time stamps.
 */
#include "haptic/haptic.h"

#include <string.h>

#include "haptic/state.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { POSES_A_TICK = 64, BAD_TICKS = SS_WATCHDOG_TICKS, LEAD_TICKS = 3 };

#define STOP_TIME       0.005 /* s: of a proxy whose grasp is let go */
#define LEAST_STIFFNESS 1e-6  /* N/m: of a grasp without contacts */
#define STAYED_M        0.01 /* a device that returns nearer than that to where it was has stayed */
#define LEAD_MAX        2e-3 /* m: three ticks at .7 m/s */

/* ---- poses ---- */

/* Seconds since the last pose: the device's own clock, or ticks in lockstep. */
static double pose_interval(const ss_haptic *haptic, const softsim_pose *pose, int64_t tick)
{
    const double period = haptic->config.period;
    if (haptic->config.is_lockstep) {
        return period * (double)(tick > haptic->pose_tick ? tick - haptic->pose_tick : 1);
    }
    const double elapsed = ((double)pose->utime_us - (double)haptic->pose.utime_us) * 1e-6;
    return elapsed > 0.0 ? elapsed : period;
}

static void take_button(ss_haptic *haptic, const softsim_pose *pose, int64_t tick)
{
    const bool is_down = (pose->buttons & SOFTSIM_BUTTON_GRASP) != 0;
    haptic->is_button_ignored = haptic->is_button_ignored && is_down;
    const bool is_pressed = is_down && !haptic->is_button_ignored;
    if (is_pressed != haptic->is_pressed) {
        ++haptic->grasp_edges;
        haptic->press_tick = tick;
    }
    haptic->is_pressed = is_pressed;
}

/* What begins with the poses of a tick: a device, or a new stay of the same one, which may then be
 * anywhere. */
typedef struct beginning {
    bool is_new_holder, is_return;
} beginning;

static void take_pose(ss_haptic *haptic, const softsim_pose *pose, uint32_t epoch, int64_t tick,
                      beginning *inout_beginning)
{
    const bool is_new_epoch = haptic->has_pose && epoch != haptic->epoch;
    const bool is_new_holder = !haptic->has_pose || pose->sender != haptic->pose.sender;
    const bool is_return = is_new_epoch || tick - haptic->pose_tick >= SS_WATCHDOG_TICKS;
    const bool corrects = (pose->flags & SOFTSIM_POSE_CORRECTS) != 0;
    if (is_new_holder) {
        ss_observer_restart(&haptic->observer, &haptic->config, corrects);
        ss_passivity_restart(&haptic->passivity);
        ss_set3(haptic->last_force, 0.0, 0.0, 0.0);
        ss_set3(haptic->last_undamped, 0.0, 0.0, 0.0);
    } else if (is_return) {
        ss_observer_break(&haptic->observer);
    }
    if (is_new_holder || is_return) {
        double way[3];
        ss_sub3(way, pose->position, haptic->pose.position);
        haptic->has_stayed = !is_new_holder && ss_norm3(way) < STAYED_M;
        haptic->holders += is_new_holder;
        ss_motion_rest(&haptic->motion);
    } else {
        const double elapsed = pose_interval(haptic, pose, tick);
        ss_motion_take(&haptic->motion, &haptic->pose, pose, elapsed);
        if (!haptic->config.is_lockstep) {
            const double tick_us = 1e6 * haptic->config.period * (double)tick;
            ss_motion_time(&haptic->motion, 1e-6 * (tick_us - (double)pose->utime_us), elapsed);
        }
    }
    if (is_new_epoch && !is_new_holder && !haptic->is_returning) {
        haptic->is_returning = true;
        haptic->left_pose = haptic->pose;
    }
    ss_observer_pose(&haptic->observer, &haptic->config, pose, tick);
    take_button(haptic, pose, tick);
    haptic->has_pose = true;
    haptic->pose = *pose;
    haptic->pose_tick = tick;
    haptic->epoch = epoch;
    inout_beginning->is_new_holder |= is_new_holder;
    inout_beginning->is_return |= is_new_epoch;
}

static beginning take_poses(ss_haptic *haptic, const ss_haptic_input *input, bool is_bad)
{
    const int32_t first = input->pose_count > POSES_A_TICK ? input->pose_count - POSES_A_TICK : 0;
    beginning begins = {0};
    for (int32_t i = first; i < input->pose_count; ++i) {
        if (is_bad && !ss_haptic_is_pose_finite(&input->pose[i])) {
            continue;
        }
        take_pose(haptic, &input->pose[i], input->sender_epoch, input->tick, &begins);
    }
    return begins;
}

/* ---- admission, result, grasp ---- */

static void place_proxy(ss_haptic *haptic)
{
    ss_local_contact_clear(&haptic->local);
    ss_copy3(haptic->p, haptic->pose.position);
    ss_set3(haptic->pdot, 0.0, 0.0, 0.0);
    ss_slip_clear(&haptic->slip);
    haptic->slip.turning = 0.0;
    ss_yield_clear(&haptic->yield);
    /* A hand grasps by a press: a tool that is placed in tissue would be drawn through it by what
     * it took on its way in. */
    haptic->grasp_edges += haptic->is_pressed;
    haptic->is_button_ignored = haptic->is_button_ignored || haptic->is_pressed;
    haptic->is_pressed = false;
    haptic->is_returning = false;
    haptic->placed_restart_count = haptic->restart_count;
    haptic->is_placed_as_before = haptic->has_stayed;
    haptic->has_stayed = false;
    ++haptic->teleports;
}

static void step_admission(ss_haptic *haptic, const ss_haptic_input *input, beginning begins)
{
    const bool is_reset = input->restart_count != haptic->restart_count;
    haptic->restart_count = input->restart_count;
    const ss_admission_input admission_input = {
        .tick = input->tick,
        .period = haptic->config.period,
        .pose_tick = haptic->pose_tick,
        .is_paused = input->is_paused,
        /* The same device elsewhere: down with the force, then in again. */
        .is_reset = is_reset || begins.is_return || ss_slip_is_lost(&haptic->slip),
        .is_stopping = input->is_stopping,
        .is_new_holder = begins.is_new_holder,
        .is_fault = haptic->is_fault,
        .has_result = haptic->local.is_known,
        .result_tick = haptic->result_tick,
        .has_force = ss_norm3(haptic->last_force) > 0.0,
    };
    if (ss_admission_step(&haptic->admission, &admission_input)) {
        place_proxy(haptic);
    }
}

/* The pose and hand velocity that the coupling sees. */
static void used_pose(const ss_haptic *haptic, double x[3], double v[3])
{
    const softsim_pose *pose = ss_haptic_held_pose(haptic);
    ss_copy3(x, pose->position);
    ss_copy3(v, haptic->motion.v);
    if (pose != &haptic->pose) {
        ss_set3(v, 0.0, 0.0, 0.0);
    }
    ss_admission_pose(&haptic->admission, x, v);
}

/* Where the hand is by now, as far as LEAD_TICKS on. Two clocks of 1 kHz, or a late message, leave
 * a tick without a pose, and a hand taken as still while v says otherwise gave what is viscous a
 * step, and back: .5 N at .2 m/s in a grasp. And a pose that came later than others do is of so
 * long ago: behind a jitter of .5 ms the tool stood still in every fourth tick, and a touch of .3
 * m/s ended in the tick after it began. In 60 runs of 1.5 s of pokes, taps and slides on a kidney
 * (hands of 80 to 800 g, 0 to 10 ms, corrected) there were 5 steps of more than .5 N there and back
 * behind a jitter of .5 ms and 15 behind one of 1 ms; led by one tick 2 and 15, by two 1 and 6, by
 * three 0 and 3, by five 0 and 4. No farther than the last poses were apart, whatever velocity the
 * device tells. */
static void lead_pose(const ss_haptic *haptic, int64_t tick, const double x[3], const double v[3],
                      double out[3])
{
    const double period = haptic->config.period;
    const double old = haptic->motion.late + period * (double)(tick - haptic->pose_tick);
    const double ahead = fmin(old, LEAD_TICKS * period);
    double way[3];
    ss_scale3(way, v, ahead);
    ss_clamp_norm3(way, fmin(LEAD_MAX, haptic->motion.covered * ahead));
    ss_add3(out, x, way);
}

/* Where the patches of the local contact model are taken: at the pose used, moved as far as the
 * limit and a grasp that was let go have the proxy slip, and what acts beside the contacts. A hand
 * far beyond the limit would else bend the surface as it is at the hand: the tissue was pressed
 * with half of the limit. */
static void patch_pose(const ss_haptic *haptic, const double x[3], double out[3])
{
    const ss_slip *slip = &haptic->slip;
    ss_madd3(out, x, slip->is_from_grasp ? 0.0 : 1.0, slip->aside);
    if (slip->stiffness_fraction < 1.0) {
        ss_madd3(out, out, fmax(0.0, slip->length), slip->direction);
    }
    const ss_local_contact_other *other = &haptic->local.other;
    ss_madd3(out, out, other->share / haptic->yield.spring, other->force);
    if (haptic->local.friction.is_used) {
        ss_madd3(out, out, 1.0 / haptic->yield.spring, haptic->local.friction.force);
    }
}

/* Does the tool touch, where it was placed? */
static bool is_touching(const ss_simulation_result *result)
{
    double most = 0.0;
    for (int32_t i = 0; i < result->set.count; ++i) {
        const ss_contact *c = &result->set.contact[i];
        most = fmax(most, c->gap > 0.0 ? 0.0 : c->force);
    }
    return most > 0.0;
}

/* The proxy goes out to the surface at once, and is let in by fading, from no force on. */
static void enter_from_surface(ss_haptic *haptic, int64_t tick, const double point[3],
                               const double normal[3])
{
    double v[3];
    ss_admission_fade(&haptic->admission, tick, point, normal);
    haptic->local.viscosity_fraction = 0.0;
    used_pose(haptic, haptic->p, v);
    ss_local_contact_begin(&haptic->local, haptic->p, haptic->p, haptic->pdot);
    ++haptic->entries;
}

/* Takes hold; at the limit so that the force stays. It does where the proxy's step w leaves the
 * grasp's law, stiffness S and viscosity V, what it is: S w + V (w/T - pdot) = 0. */
static void begin_grasp(ss_haptic *haptic, const double x[3], const double v[3])
{
    const ss_local_contact_grasp *grasp = &haptic->local.grasp;
    const double period = haptic->config.period;
    double law[3][3], drag[3], step[3], stretch[3];
    ss_local_contact_hold(&haptic->local, haptic->p, haptic->pdot);
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            law[r][c] = grasp->stiffness[r][c] + grasp->viscosity[r][c] / period;
        }
        law[r][r] += LEAST_STIFFNESS;
        drag[r] = ss_dot3(grasp->viscosity[r], haptic->pdot);
    }
    ss_cholesky_solve3(law, drag, step);
    for (int i = 0; i < 3; ++i) {
        const double damper = haptic->config.damping * (v[i] - step[i] / period);
        const double pull = damper + haptic->local.residual[i];
        stretch[i] =
            haptic->p[i] + step[i] - x[i] - haptic->yield.rest[i] - pull / haptic->yield.spring;
    }
    ss_slip_hold(&haptic->slip, stretch, grasp->force);
}

/* A result for where the proxy is now: the local contact model, and entry if it is the first. What
 * is held moves with the tool: its surface is no place to be let in from. */
static void use_result(ss_haptic *haptic, const ss_simulation_result *result, int64_t tick)
{
    ss_local_contact *local = &haptic->local;
    const bool is_first = haptic->admission.phase == SS_PHASE_WAITING;
    double x[3], v[3], at[3], normal[3], point[3], depth = 0.0;
    used_pose(haptic, x, v);
    patch_pose(haptic, x, at);
    if (!is_first && haptic->is_pressed && result->set.is_held && !local->grasp.is_held) {
        begin_grasp(haptic, x, v);
    }
    ss_local_contact_take(local, result, &haptic->config, tick, haptic->yield.spring,
                          ss_haptic_held_pose(haptic)->orientation, at, haptic->p, haptic->pdot,
                          is_first || result->is_found_inside);
    const bool is_near =
        ss_local_contact_surface(local, haptic->pose.position, normal, point, &depth);
    if (result->is_found_inside) {
        enter_from_surface(haptic, tick, result->proxy, result->outward);
    } else if (is_first && is_touching(result)) {
        enter_from_surface(haptic, tick, point, normal);
    } else if (is_first) {
        ss_admission_enter(&haptic->admission);
    } else if (is_near && !local->grasp.is_held) {
        ss_admission_follow(&haptic->admission, local->result_period, point, normal);
    }
}

/* Takes a fresh result; returns true when there was a good one. */
static bool take_result(ss_haptic *haptic, const ss_haptic_input *input)
{
    const ss_simulation_result *result = input->result;
    if (!input->is_result_new || result == NULL) {
        return false;
    }
    haptic->is_fault = result->is_fault;
    if (result->is_fault) {
        return false;
    }
    if (!ss_haptic_is_result_sound(result, input->tick)) {
        ++haptic->bad_inputs;
        return false;
    }
    haptic->result_tick = result->tick;
    ss_copy3(haptic->model_force, result->set.force);
    ss_copy3(haptic->surface_point, result->set.point);
    ss_copy3(haptic->surface_normal, result->set.normal);
    ss_copy3(haptic->surface_proxy, result->proxy);
    haptic->surface_depth = result->set.depth;
    haptic->inside_depth = ss_contact_is_inside(&result->set) ? result->set.inside_depth : 0.0;
    const ss_phase phase = haptic->admission.phase;
    /* The model may have heard of a reset before we do, or after. */
    if (phase != SS_PHASE_SILENT && phase != SS_PHASE_RAMPING && !input->is_paused &&
        result->tick >= haptic->admission.placed &&
        result->restart_count == haptic->restart_count) {
        use_result(haptic, result, input->tick);
    }
    return true;
}

/* The grasp begins with the button in contact, stays as long as the model holds too (a result may
 * also begin it, in use_result), and ends with the first result of a model that does not. When the
 * button is let go, or a grasp is torn, models hold on a while, less and less: until then the hand
 * feels what they say, and the proxy stays where it is: moved to the hand it would drag the nodes
 * that the model still holds, with all that the coupling has stored. */
static void update_grasp(ss_haptic *haptic, const ss_haptic_input *input, bool is_fresh,
                         const double x[3], const double v[3])
{
    ss_local_contact *local = &haptic->local;
    const bool was_held = local->grasp.is_held;
    const bool is_answer = is_fresh && input->result->tick >= haptic->press_tick;
    const bool is_over = is_answer && !input->result->set.is_held;
    if (was_held && is_over) {
        double at[3];
        patch_pose(haptic, x, at);
        ss_local_contact_release(local, at, haptic->p, haptic->pdot, haptic->slip.limit);
    } else if (!was_held && haptic->is_pressed && input->tick == haptic->press_tick &&
               ss_local_contact_active_count(local) > 0) {
        begin_grasp(haptic, x, v);
    }
    const bool is_torn = is_fresh ? input->result->set.is_torn
                                  : local->grasp.is_ending && input->tick != haptic->press_tick;
    local->grasp.is_ending = local->grasp.is_held && (!haptic->is_pressed || is_torn);
    local->grasp.is_answered = local->grasp.is_ending && (local->grasp.is_answered || is_answer);
    haptic->slip.is_kept = local->grasp.is_ending || (was_held && is_over);
}

/* ---- coupling, balance, limits ---- */

static void update_spring(ss_haptic *haptic)
{
    const ss_haptic_config *config = &haptic->config;
    const bool is_in_contact = ss_local_contact_active_count(&haptic->local) > 0;
    double tissue[3][3];
    ss_local_contact_stiffness(&haptic->local, is_in_contact, tissue);
    double wanted = ss_coupling_spring(ss_passivity_limit(&haptic->passivity, &haptic->observer),
                                       ss_max_eigenvalue3(tissue));
    if (config->between_steps != SS_BETWEEN_LOCAL) {
        /* Without a law the tissue has no stiffness: nothing to share it with. */
        wanted = ss_coupling_spring(INFINITY, 0.0);
    }
    ss_yield_follow(&haptic->yield, wanted, is_in_contact, haptic->local.grasp.is_held,
                    config->period);
}

/* How far the force may go, N: over the ticks since the last one, of which the thread may have
 * missed some. */
static double slew_step(const ss_haptic *haptic, int64_t tick)
{
    const int64_t elapsed = tick - haptic->output.target.tick;
    const double ticks = elapsed < SS_RAMP_TICKS ? (double)elapsed : SS_RAMP_TICKS;
    return ticks * haptic->config.max_slew * haptic->config.period;
}

static void update_limit(ss_haptic *haptic, int64_t tick)
{
    ss_slip *slip = &haptic->slip;
    const bool is_lowered =
        ss_slip_follow(slip, &haptic->config, slew_step(haptic, tick), ss_norm3(haptic->last_force),
                       ss_haptic_felt_stiffness(haptic, slip->direction));
    if (is_lowered) {
        /* The proxy goes out as fast as that asks: what is viscous in the tissue holds it back. */
        haptic->local.viscosity_fraction = 1.0;
    }
}

/* The coupling's force-free point goes where the proxy comes to rest, soon: stopped at once, a tool
 * of .2 m/s lets go of the tissue's inertia, 1.5 N in a tick. */
static void keep_proxy(ss_haptic *haptic, const double x[3], const double v[3], double limit)
{
    const ss_haptic_config *config = &haptic->config;
    double pdot[3], p[3], load[3];
    ss_scale3(pdot, haptic->pdot, exp(-config->period / STOP_TIME));
    ss_madd3(p, haptic->p, config->period, pdot);
    ss_local_contact_end_grasp(&haptic->local, config->period, limit, p, pdot);
    ss_local_contact_force(&haptic->local, load);
    (void)ss_clamp_norm3(load, limit);
    ss_yield_clear(&haptic->yield);
    for (int i = 0; i < 3; ++i) {
        const double pull = config->damping * (v[i] - pdot[i]) + load[i];
        haptic->slip.aside[i] = p[i] - x[i] - pull / haptic->yield.spring;
    }
    haptic->slip.is_from_grasp = true;
}

/* What the coupling wants of the proxy, and what the local contact model answers. */
static void set_balance(ss_haptic *haptic, const double x[3], const double v[3],
                        ss_balance *balance)
{
    const ss_haptic_config *config = &haptic->config;
    const double damper = config->damping / config->period;
    const ss_slip *slip = &haptic->slip;
    *balance = (ss_balance){.spring = haptic->yield.spring + damper, .limit = slip->limit};
    double beside[3];
    ss_local_contact_follow_other(&haptic->local, config->period, slip->limit);
    ss_madd3(beside, haptic->local.residual, haptic->local.other.share, haptic->local.other.force);
    ss_copy3(balance->other, beside);
    if (slip->is_kept) {
        keep_proxy(haptic, x, v, slip->limit);
    }
    for (int i = 0; i < 3; ++i) {
        const double rest = x[i] + slip->aside[i] + haptic->yield.rest[i];
        const double pull = haptic->yield.spring * rest + config->damping * v[i] +
                            damper * haptic->p[i] + beside[i];
        balance->p_free[i] = pull / balance->spring;
    }
    if (slip->stiffness_fraction < 1.0) {
        ss_copy3(balance->axis, slip->direction);
    }
    double at[3];
    patch_pose(haptic, x, at);
    ss_local_contact_rows(&haptic->local, config->period, at, haptic->p, balance);
}

/* Damps what would hand energy to the hand. */
static void damp(ss_haptic *haptic, const double v[3], double force[3])
{
    ss_passivity_tick now = {.period = haptic->config.period,
                             .velocity = {v[0], v[1], v[2]},
                             .stiffness = haptic->output.force.stiffness,
                             .corrects = (haptic->pose.flags & SOFTSIM_POSE_CORRECTS) != 0,
                             .is_grasping = haptic->local.grasp.is_held};
    ss_motion_acceleration(&haptic->motion, now.acceleration);
    ss_passivity_damp(&haptic->passivity, &haptic->observer, &now, force);
}

/* Balances the proxy against the local contact model within the limit; writes the forces of the
 * local contact model, p and the whole force, `out_undamped` without what passivity.c does. Returns
 * true when limited. */
static bool balance_proxy(ss_haptic *haptic, int64_t tick, const double x[3], const double v[3],
                          double out_undamped[3], double out_force[3])
{
    const ss_haptic_config *config = &haptic->config;
    ss_local_contact *local = &haptic->local;
    ss_balance balance;
    ss_rest rest;
    set_balance(haptic, x, v, &balance);
    ss_coupling_balance(&balance, &rest);
    if (local->friction.is_used) {
        ss_friction_balance(local, haptic->p, haptic->yield.spring, config->period, &balance,
                            &rest);
    }
    for (int32_t i = 0; i < local->count; ++i) {
        local->contact[i].last_force = i < balance.count ? rest.force[i] : 0.0;
    }
    ss_copy3(local->grasp.last_force, rest.grasp);
    ss_local_contact_force(local, out_force);
    double along[3], hand[3];
    ss_add3(hand, x, haptic->slip.aside);
    ss_yield_take(&haptic->yield, hand, &rest, out_force, balance.limit);
    ss_sub3(along, out_force, balance.other);
    ss_slip_take(&haptic->slip, &balance, &rest, along, haptic->yield.spring, config->period);
    ss_local_contact_clip_residual(local, haptic->slip.direction, ss_norm3(along));
    ss_local_contact_felt(local, out_force);
    if (config->between_steps != SS_BETWEEN_LOCAL && !local->grasp.is_held) {
        ss_local_contact_extrapolate(local, config, tick, out_force);
    }
    double aimed[3];
    ss_copy3(aimed, out_force);
    const bool is_turning = ss_slip_turn(&haptic->slip, haptic->last_undamped,
                                         ss_norm3(v) * config->period, config->period, out_force);
    ss_copy3(out_undamped, out_force);
    damp(haptic, v, out_force);
    const bool is_cut = ss_clamp_norm3(out_force, haptic->slip.limit);
    double pose_to_proxy[3];
    ss_sub3(pose_to_proxy, rest.p, x);
    const double *pressing = is_turning ? aimed : out_force;
    const double pressed =
        local->friction.is_used ? ss_dot3(pressing, haptic->slip.direction) : ss_norm3(out_force);
    haptic->slip.length =
        ss_dot3(pose_to_proxy, haptic->slip.direction) - pressed / haptic->yield.spring;
    ss_sub3(haptic->pdot, rest.p, haptic->p);
    ss_scale3(haptic->pdot, haptic->pdot, 1.0 / config->period);
    ss_copy3(haptic->p, rest.p);
    return is_cut || is_turning || rest.stiffness_fraction < 1.0;
}

/* ---- output ---- */

/* What the observer must know of a force later on, and what the lockstep hash remembers of it. */
static void remember_force(ss_haptic *haptic, int64_t tick)
{
    const softsim_force *force = &haptic->output.force;
    const ss_past_force record = {.seq = force->seq,
                                  .tick = tick,
                                  .pose_tick = haptic->pose_tick,
                                  .pose_utime_us = haptic->pose.utime_us,
                                  .force = {force->force[0], force->force[1], force->force[2]},
                                  .torque = {force->torque[0], force->torque[1], force->torque[2]}};
    ss_observer_force(&haptic->observer, &record);
    ss_copy3(haptic->last_force, force->force);
    haptic->digest = ss_hash_bytes(haptic->digest, force->force, sizeof force->force);
}

/* The pose used came nearer to the hand: the fade pressed, not the hand. */
static void book_entry(ss_haptic *haptic, const double x[3], const double sent[3])
{
    double shift[3], change[3], mean[3];
    ss_sub3(shift, x, ss_haptic_held_pose(haptic)->position);
    ss_sub3(change, shift, haptic->shift);
    ss_add3(mean, haptic->last_force, sent);
    haptic->output.let_in_j = -0.5 * ss_dot3(mean, change);
    ss_passivity_let_in(&haptic->passivity, haptic->output.let_in_j);
    ss_copy3(haptic->shift, shift);
}

/* Non-finite input: the last force again, for as long as the watchdog would wait. */
static void repeat_force(ss_haptic *haptic, int64_t tick)
{
    if (haptic->has_pose) {
        haptic->output.force.seq = ss_haptic_next_seq(haptic->output.force.seq);
    }
    haptic->output.force.flags |= SOFTSIM_FORCE_PREDICTED;
    haptic->output.target.tick = tick;
    haptic->output.let_in_j = 0.0;
    if (haptic->has_pose) {
        remember_force(haptic, tick);
    }
    ss_haptic_write_sums(haptic);
}

/* The ramp's share of a force, and the slew limit from `last` on; true where that limits it. */
static bool ramp_and_limit_slew(const ss_haptic *haptic, int64_t tick, const double whole[3],
                                const double last[3], double *inout_ramp_from, double out_sent[3])
{
    const double gain = ss_haptic_gain(haptic);
    ss_scale3(out_sent, whole, gain);
    if (haptic->admission.phase == SS_PHASE_RAMPING) {
        /* The local contact model's offsets still change during the ramp; they must not raise the
         * ramped force. */
        ss_clamp_norm3(out_sent, gain * *inout_ramp_from);
    } else {
        *inout_ramp_from = ss_norm3(out_sent);
    }
    return ss_clamp_change3(out_sent, last, slew_step(haptic, tick));
}

/* What would have been sent of `whole`, a force without the damping. */
static void send_undamped(ss_haptic *haptic, int64_t tick, const double whole[3],
                          double out_sent[3])
{
    double within_limit[3];
    ss_copy3(within_limit, whole);
    ss_clamp_norm3(within_limit, haptic->slip.limit);
    (void)ramp_and_limit_slew(haptic, tick, within_limit, haptic->last_undamped,
                              &haptic->undamped_ramp_from, out_sent);
}

/* State that affects later forces but not the forces sent so far: the pose, and what the force
 * limit, an update, an ended grasp and an entry leave. */
static uint64_t hash_hidden(const ss_haptic *haptic, uint64_t hash)
{
    const double *const vector[] = {haptic->pose.position,
                                    haptic->pdot,
                                    haptic->motion.mean_v,
                                    haptic->slip.direction,
                                    haptic->slip.aside,
                                    haptic->yield.rest,
                                    haptic->yield.stretch,
                                    haptic->left_pose.position,
                                    haptic->admission.entry_point,
                                    haptic->admission.entry_normal};
    if (memcmp(haptic->last_undamped, haptic->last_force, sizeof haptic->last_undamped) != 0) {
        hash = ss_hash_bytes(hash, haptic->last_undamped, sizeof haptic->last_undamped);
        hash = ss_hash_bytes(hash, &haptic->undamped_ramp_from, sizeof haptic->undamped_ramp_from);
    }
    if (haptic->slip.turning > 0.0) {
        hash = ss_hash_bytes(hash, &haptic->slip.turning, sizeof haptic->slip.turning);
    }
    if (haptic->passivity.damping > 0.0) {
        hash = ss_hash_bytes(hash, &haptic->passivity.damping, sizeof haptic->passivity.damping);
    }
    const double number[] = {haptic->slip.stiffness_fraction, haptic->slip.length,
                             haptic->admission.held_back, haptic->ramp_from,
                             haptic->passivity.share};
    const uint8_t button = haptic->is_button_ignored ? 2 : haptic->is_pressed;
    const uint8_t stays = (haptic->has_stayed ? 2 : 0) | (haptic->is_placed_as_before ? 4 : 0);
    const uint8_t flag[] = {haptic->slip.is_kept, haptic->slip.is_from_grasp, button,
                            haptic->is_returning | stays};
    for (size_t i = 0; i < sizeof vector / sizeof *vector; ++i) {
        hash = ss_hash_bytes(hash, vector[i], 3 * sizeof *vector[i]);
    }
    hash = ss_hash_bytes(hash, number, sizeof number);
    hash = ss_hash_bytes(hash, flag, sizeof flag);
    hash = ss_hash_bytes(hash, &haptic->entries, sizeof haptic->entries);
    return ss_local_contact_hash(&haptic->local, hash);
}

/* ---- public ---- */

void ss_haptic_configure(ss_haptic *haptic, const ss_haptic_config *config)
{
    ss_haptic_config *own = &haptic->config;
    *own = *config;
    own->period = config->period > 1e-5 && config->period < 1.0 ? config->period : 1e-3;
    own->max_slew = config->max_slew >= 0.0 ? config->max_slew : 0.0;
    own->stiffness = config->stiffness >= 1.0 ? config->stiffness : 1.0;
    own->damping = config->damping >= 0.0 ? config->damping : 0.0;
}

ss_haptic *ss_haptic_create(const ss_haptic_config *config)
{
    ss_haptic *haptic = ss_memory_get(1, sizeof *haptic);
    if (haptic == NULL) {
        return NULL;
    }
    ss_haptic_configure(haptic, config);
    ss_observer_restart(&haptic->observer, &haptic->config, false);
    ss_passivity_init(&haptic->passivity);
    haptic->yield.spring = haptic->observer.limit;
    haptic->slip = (ss_slip){.limit = haptic->config.max_force, .stiffness_fraction = 1.0};
    return haptic;
}

void ss_haptic_destroy(ss_haptic **haptic)
{
    if (haptic != NULL) {
        ss_memory_free(*haptic);
        *haptic = NULL;
    }
}

uint64_t ss_haptic_hash(const ss_haptic *haptic, uint64_t seed)
{
    const ss_observer *observer = &haptic->observer;
    const double state[] = {haptic->p[0],         haptic->p[1],        haptic->p[2],
                            haptic->motion.v[0],  haptic->motion.v[1], haptic->motion.v[2],
                            haptic->yield.spring, observer->limit,     observer->worst,
                            observer->energy,     observer->delay_p95, haptic->slip.limit};
    const int64_t number[] = {haptic->output.force.seq,  (int64_t)haptic->admission.phase,
                              haptic->admission.ticks,   haptic->local.tick,
                              haptic->bad_inputs,        (int64_t)haptic->grasp_edges,
                              (int64_t)haptic->teleports};
    uint64_t hash = ss_hash_bytes(seed, &haptic->digest, sizeof haptic->digest);
    hash = ss_hash_bytes(hash, state, sizeof state);
    hash = ss_hash_bytes(hash, number, sizeof number);
    return haptic->has_pose ? hash_hidden(haptic, hash) : hash;
}

void ss_haptic_tick(ss_haptic *haptic, const ss_haptic_input *input, ss_haptic_output *output)
{
    const int64_t tick = input->tick;
    const bool is_bad = !ss_haptic_is_input_finite(input);
    haptic->bad_inputs += is_bad;
    haptic->bad_streak = is_bad ? haptic->bad_streak + 1 : 0;
    if (is_bad && haptic->bad_streak < BAD_TICKS) {
        repeat_force(haptic, tick);
        *output = haptic->output;
        return;
    }
    const beginning begins = take_poses(haptic, input, is_bad);
    if (haptic->has_pose) {
        const bool corrects = (haptic->pose.flags & SOFTSIM_POSE_CORRECTS) != 0;
        double x[3], v[3], at[3], whole[3], undamped_whole[3], sent[3], undamped_sent[3];
        ss_observer_tick(&haptic->observer, &haptic->config, corrects,
                         ss_local_contact_active_count(&haptic->local) > 0, tick);
        ss_passivity_step(&haptic->passivity, &haptic->observer, haptic->config.period,
                          ss_local_contact_active_count(&haptic->local) > 0);
        step_admission(haptic, input, begins);
        ss_local_contact_decay(
            &haptic->local, haptic->config.period,
            haptic->slip.stiffness_fraction < 1.0 ? 1.0 : ss_admission_left(&haptic->admission),
            ss_slip_time_left(&haptic->slip, haptic->motion.v),
            haptic->yield.spring + haptic->config.damping / haptic->config.period,
            haptic->motion.speed);
        ss_local_contact_turn(&haptic->local, ss_haptic_held_pose(haptic)->orientation);
        const bool is_fresh = take_result(haptic, input);
        used_pose(haptic, x, v);
        lead_pose(haptic, tick, x, v, at);
        update_grasp(haptic, input, is_fresh, at, v);
        update_spring(haptic);
        update_limit(haptic, tick);
        const bool is_limited = balance_proxy(haptic, tick, at, v, undamped_whole, whole);
        int32_t flags =
            ss_admission_flags(&haptic->admission) | (is_fresh ? 0 : SOFTSIM_FORCE_PREDICTED);
        const bool is_slow =
            ramp_and_limit_slew(haptic, tick, whole, haptic->last_force, &haptic->ramp_from, sent);
        flags |= is_limited || is_slow ? SOFTSIM_FORCE_LIMITED : 0;
        send_undamped(haptic, tick, undamped_whole, undamped_sent);
        if (ss_is_finite(sent, 3) && ss_is_finite(haptic->p, 3)) {
            ss_copy3(haptic->last_undamped, undamped_sent);
            ss_haptic_write_force(haptic, input, sent, undamped_whole, flags);
            ss_haptic_write_target(haptic, input, v);
            book_entry(haptic, x, sent);
            remember_force(haptic, tick);
        } else {
            /* The numbers overflowed: as a fault of the model, and the proxy begins again. */
            ++haptic->bad_inputs;
            haptic->is_fault = true;
            place_proxy(haptic);
            repeat_force(haptic, tick);
        }
    }
    ss_haptic_write_sums(haptic);
    *output = haptic->output;
}
