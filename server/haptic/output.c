/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What a tick tells: the force on the hand with all that belongs to it, where the simulation's tool
 * is to go, and the sums of the status.
 */
#include "haptic/state.h"

#include <string.h>

#include "rt/vec.h"

double ss_haptic_felt_stiffness(const ss_haptic *haptic, const double normal[3])
{
    const double k = ss_local_contact_stiffness_along(&haptic->local, normal);
    return k > 0.0 ? haptic->yield.spring * k / (haptic->yield.spring + k) : 0.0;
}

double ss_haptic_gain(const ss_haptic *haptic)
{
    const bool is_new = haptic->admission.phase == SS_PHASE_RAMPING && !(haptic->ramp_from > 0.0);
    return is_new ? 0.0 : ss_admission_gain(&haptic->admission);
}

int32_t ss_haptic_next_seq(int32_t seq)
{
    return seq < INT32_MAX ? seq + 1 : 1;
}

static int32_t age_us(const ss_haptic *haptic, int64_t tick)
{
    const double age = (double)(tick - haptic->result_tick) * haptic->config.period * 1e6;
    return haptic->result_tick == 0 ? 0 : (int32_t)fmin(age, INT32_MAX);
}

/* Normal, point and depth of the tissue's surface as of the last result, at the newest pose; of a
 * tool inside the tissue, the depth as of that result. As a plane it has no end: a tool that
 * has come out on the far side while its proxy is held on this one is no deeper than the body is
 * thick. */
static void write_surface(const ss_haptic *haptic, bool is_in_contact, bool is_inside,
                          softsim_force *force)
{
    const ss_local_contact *local = &haptic->local;
    int32_t strongest = 0;
    for (int32_t i = 1; i < local->count; ++i) {
        strongest =
            local->contact[i].last_force > local->contact[strongest].last_force ? i : strongest;
    }
    ss_copy3(force->normal,
             local->count > 0 ? local->contact[strongest].direction : haptic->surface_normal);
    double move[3];
    ss_sub3(move, haptic->p, haptic->surface_proxy);
    ss_madd3(move, move, -ss_dot3(move, force->normal), force->normal);
    ss_add3(force->point, haptic->surface_point, move);
    force->depth = 0.0;
    if (is_in_contact) {
        double inward[3];
        ss_sub3(inward, haptic->surface_proxy, ss_haptic_held_pose(haptic)->position);
        const double depth = haptic->surface_depth + ss_dot3(haptic->surface_normal, inward);
        force->depth = fmin(fmax(0.0, depth), haptic->config.thickness);
    }
    if (is_inside) {
        force->depth = fmin(haptic->inside_depth, haptic->config.thickness);
    }
}

/* N/m: that a client corrects with. Along the surface's normal; what is held without touching it
 * has none, and is told along the force that draws it. */
static double felt_by_client(const ss_haptic *haptic, const softsim_force *force)
{
    double tissue[3][3], along[3];
    ss_copy3(along, ss_norm3(force->normal) > 0.0 ? force->normal : force->force);
    if (!(ss_normalize3(along) > 0.0)) {
        return 0.0;
    }
    /* Over the span in which it does. */
    ss_local_contact_tangent(&haptic->local, haptic->observer.delay_p50, tissue);
    return ss_yield_felt(&haptic->yield, tissue, along);
}

void ss_haptic_write_force(ss_haptic *haptic, const ss_haptic_input *input, const double sent[3],
                           const double undamped[3], int32_t flags)
{
    softsim_force *force = &haptic->output.force;
    const double size = ss_norm3(undamped);
    const int32_t active = ss_local_contact_active_count(&haptic->local);
    const bool is_in_contact = active > 0 && ss_haptic_gain(haptic) > 0.0;
    force->seq = ss_haptic_next_seq(force->seq);
    force->sender = haptic->pose.sender;
    force->probe = haptic->pose.probe;
    force->pose_seq = haptic->pose.seq;
    force->pose_utime_us = haptic->pose.utime_us;
    force->model_age_us = age_us(haptic, input->tick);
    const bool is_inside = haptic->inside_depth > 0.0 && ss_haptic_gain(haptic) > 0.0;
    /* A decaying force still counts as contact; so does a tool inside the tissue. */
    const bool is_felt = is_in_contact || is_inside || ss_norm3(sent) > 0.0;
    force->contact_count = is_in_contact ? active : is_felt ? 1 : 0;
    force->flags = flags | (is_felt ? SOFTSIM_FORCE_CONTACT : 0) |
                   (haptic->local.grasp.is_held ? SOFTSIM_FORCE_GRASPING : 0);
    ss_copy3(force->force, sent);
    ss_set3(force->torque, 0.0, 0.0, 0.0);
    if (haptic->config.tool_gyration > 0.0 && size > 0.0 && is_felt) {
        ss_local_contact_felt_torque(&haptic->local, force->torque);
        /* While the slew holds back a force that falls, its torque may be gone. */
        ss_scale3(force->torque, force->torque, fmin(1.0, ss_norm3(haptic->last_undamped) / size));
    }
    ss_copy3(force->model_force, haptic->model_force);
    ss_copy3(force->proxy, haptic->p);
    write_surface(haptic, is_in_contact, is_inside, force);
    const int32_t hidden = SOFTSIM_FORCE_LIMITED | SOFTSIM_FORCE_RAMPING;
    force->stiffness = is_in_contact && (flags & hidden) == 0 ? felt_by_client(haptic, force) : 0.0;
}

/* Of a motion the share `led` along `out`, and across it what friction does not hold. */
static void lead(const double motion[3], const double out[3], double led, double held,
                 double out_led[3])
{
    const double along = ss_dot3(motion, out);
    ss_madd3(out_led, motion, (led - 1.0) * along, out);
    if (held > 0.0) {
        double across[3];
        ss_madd3(across, motion, -along, out);
        ss_madd3(out_led, out_led, -held, across);
    }
}

void ss_haptic_write_target(ss_haptic *haptic, const ss_haptic_input *input, const double v[3])
{
    ss_proxy_target *target = &haptic->output.target;
    target->tick = input->tick;
    target->pose_seq = haptic->pose.seq;
    target->is_present = haptic->admission.phase != SS_PHASE_SILENT;
    target->is_grasping = haptic->is_pressed && target->is_present;
    target->grasp_edges = haptic->grasp_edges;
    target->teleports = haptic->teleports;
    target->entries = haptic->entries;
    target->restart_count = haptic->placed_restart_count;
    target->has_stayed = haptic->is_placed_as_before;
    target->holders = haptic->holders;
    ss_copy3(target->proxy, haptic->p);
    memcpy(target->orientation, ss_haptic_held_pose(haptic)->orientation,
           sizeof target->orientation);
    /* Where the coupling yields to the limit the hand sinks in without the proxy. */
    const double *out = haptic->slip.direction;
    const double fraction = haptic->slip.stiffness_fraction;
    const double taken = ss_haptic_felt_stiffness(haptic, out) / haptic->yield.spring;
    const double led = fraction * (1.0 - taken);
    double held = haptic->local.friction.held;
    if (haptic->local.grasp.is_held && fraction < 1.0) {
        /* And sideways too: the softened spring against the tissue, over the whole one. */
        held = 1.0 - fraction / (taken + led);
    }
    lead(v, out, led, held, target->velocity);
    target->room =
        ss_local_contact_room(&haptic->local, haptic->p, haptic->slip.limit, target->outward);
    if (haptic->config.tool_gyration > 0.0 && ss_haptic_held_pose(haptic) == &haptic->pose) {
        ss_copy3(target->turn, haptic->motion.turn);
    } else {
        ss_set3(target->turn, 0.0, 0.0, 0.0);
    }
    ss_motion_acceleration(&haptic->motion, target->acceleration);
    lead(target->acceleration, out, led, held, target->acceleration);
    if (haptic->slip.is_kept) {
        ss_copy3(target->velocity, haptic->pdot);
        ss_set3(target->acceleration, 0.0, 0.0, 0.0);
    }
}

void ss_haptic_write_sums(ss_haptic *haptic)
{
    const ss_observer *observer = &haptic->observer;
    ss_haptic_output *output = &haptic->output;
    output->has_force = haptic->has_pose;
    output->worst_contact_j = observer->worst;
    output->contact_j = observer->is_in_contact ? observer->energy : 0.0;
    output->energy_to_device_j = observer->to_device;
    output->energy_from_device_j = observer->from_device;
    output->stiffness_limit = ss_passivity_limit(&haptic->passivity, observer);
    output->stiffness_backoffs = haptic->passivity.backoffs;
    output->damped_ticks = haptic->passivity.actions;
    output->loop_delay_ms[0] = 1e3 * observer->delay_p50;
    output->loop_delay_ms[1] = 1e3 * observer->delay_p95;
    output->bad_inputs = haptic->bad_inputs;
}
