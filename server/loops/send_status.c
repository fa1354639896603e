/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/*
 * What the server says of itself, four times a second and when asked: the status on the wire, and
 * the judgement that the main thread tells on stderr.
 */
#include <stdio.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/memory.h"

enum { FAULT_WIRE_CLAMPED = 1 << 16, FAULT_WIRE_CAPPED = 1 << 17, FAULT_SLOW = 1 << 18 };
static const int64_t SILENCE_NS = 5000000000; /* a status says so for as long */

/* Takes what the loops last reported. */
static void take_stats(ss_loops *loops)
{
    const ss_haptic_stats *haptic = ss_mailbox_take(loops->world->haptic_stats, NULL);
    const ss_simulation_stats *simulation = ss_mailbox_take(loops->world->simulation_stats, NULL);
    if (haptic) {
        loops->haptic_stats = *haptic;
    }
    if (simulation) {
        loops->simulation_stats = *simulation;
    }
}

/* Why the force of a probe is not what its pose asks for; NULL when nothing is wrong. A probe that
 * was put away is no news after a while. */
static const char *probe_reason(const ss_loops *loops)
{
    static const char *const silent[SOFTSIM_MAX_PROBES] = {
        "probe 0 went silent: its force is ramped to zero",
        "probe 1 went silent: its force is ramped to zero",
        "probe 2 went silent: its force is ramped to zero",
        "probe 3 went silent: its force is ramped to zero",
        "probe 4 went silent: its force is ramped to zero",
        "probe 5 went silent: its force is ramped to zero",
        "probe 6 went silent: its force is ramped to zero",
        "probe 7 went silent: its force is ramped to zero"};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if ((loops->last_flags[p] & SOFTSIM_FORCE_STALE) != 0 &&
            ss_clock_now_ns() - loops->silent_ns[p] < SILENCE_NS) {
            return silent[p];
        }
    }
    return NULL;
}

/* The model's verdict, or what else is wrong when the model is well. */
static void judge(ss_loops *loops, softsim_server_status *status)
{
    const ss_model_info *info = &loops->simulation_stats.info;
    status->verdict = (int32_t)info->verdict;
    status->reason = info->reason ? info->reason : "";
    status->fault_bits = (int32_t)info->fault_bits;
    const ss_hand_verdict *hand = &loops->haptic_stats.hand;
    if ((int32_t)hand->verdict > status->verdict) {
        status->verdict = (int32_t)hand->verdict;
        status->reason = hand->reason;
    }
    if (loops->publisher && ss_publisher_is_clamping(loops->publisher)) {
        status->fault_bits |= FAULT_WIRE_CLAMPED;
        status->reason =
            *status->reason ? status->reason : "displacements beyond the wire's range are clamped";
    }
    if (loops->publisher && ss_publisher_is_capped(loops->publisher)) {
        status->fault_bits |= FAULT_WIRE_CAPPED;
        status->reason =
            *status->reason ? status->reason : "publish.max_bytes_per_s delays the mesh";
    }
    const double pace = 1.0 - loops->simulation_stats.lag;
    if (pace < SS_PACE_LEAST) {
        status->fault_bits |= FAULT_SLOW;
        if (status->verdict < SOFTSIM_VERDICT_DEGRADED) {
            status->verdict = SOFTSIM_VERDICT_DEGRADED;
            snprintf(loops->slow_reason, sizeof loops->slow_reason,
                     "simulated %.0f %% of real time: lower simulation.rate_hz, choose a coarser "
                     "mesh, or leave the machine less to do",
                     100.0 * pace);
            status->reason = loops->slow_reason;
        }
    }
    if (loops->simulation_stats.is_paused) {
        status->fault_bits |= SOFTSIM_STATUS_PAUSED;
        status->reason =
            *status->reason ? status->reason : "paused: forces are zero until the command resume";
    }
    const char *reason = probe_reason(loops);
    if (reason && !*status->reason) {
        status->reason = reason;
    }
}

/* All but the verdict. */
static softsim_server_status describe(const ss_loops *loops)
{
    ss_world *world = loops->world;
    const ss_scene *scene = world->scene;
    const ss_simulation_stats *simulation = &loops->simulation_stats;
    const ss_haptic_stats *haptic = &loops->haptic_stats;
    const ss_model_info *info = &simulation->info;
    ss_gate_counts counts;
    ss_gate_read(world->gate, &counts);
    const int64_t utime_us = ss_clock_now_ns() / 1000;
    softsim_server_status status = {
        .utime = utime_us,
        .threads = world->threads,
        .nodes = scene->mesh->node_count,
        .active_nodes = info->active_nodes,
        .elements = ss_mesh_element_count(scene->mesh),
        .worst_element = info->worst_element,
        .substeps = info->substeps,
        .probes = __builtin_popcount(world->used_probes),
        .plan_hash = (int64_t)world->plan_hash,
        .step = info->step,
        .bytes_in_use = ss_memory_in_use(),
        .poses_received = counts.received,
        .poses_superseded = haptic->superseded + loops->queue_refused,
        .mesh_bytes_sent = loops->publisher ? ss_publisher_bytes(loops->publisher) : 0,
        .wire_dropped = ss_net_dropped(loops->net),
        .uptime_s = 1e-6 * (double)(utime_us - loops->prefix_owner.start_us),
        .simulation_rate_hz = atomic_load_explicit(&loops->rate_hz, memory_order_relaxed),
        .chosen_rate_hz = 1.0 / world->step_period,
        .yardstick = world->yardstick,
        .stable_step_s = info->stable_step,
        .kinetic_j = info->kinetic,
        .elastic_j = info->elastic,
        .total_j = info->kinetic + info->elastic,
        .energy_to_device_j = haptic->energy_to_device_j,
        .energy_from_device_j = haptic->energy_from_device_j,
        .stiffness_backoffs = haptic->stiffness_backoffs,
        .scene = scene->path,
        .model = world->model_class->name};
    if (loops->options->lockstep) {
        /* Of one state: the step computed last, whose result may still be held back. */
        status.step = world->steps;
        status.state_hash = (int64_t)ss_world_hash(world);
    }
    memcpy(status.poses_refused, counts.refused, sizeof status.poses_refused);
    memcpy(status.probe_periods, loops->periods, sizeof status.probe_periods);
    memcpy(status.probe_forces, loops->forces, sizeof status.probe_forces);
    memcpy(status.probe_missed, loops->missed, sizeof status.probe_missed);
    memcpy(status.step_us, simulation->step_us, sizeof status.step_us);
    memcpy(status.lateness_us, haptic->lateness_us, sizeof status.lateness_us);
    memcpy(status.worst_contact_j, haptic->worst_contact_j, sizeof status.worst_contact_j);
    memcpy(status.loop_delay_ms, haptic->loop_delay_ms, sizeof status.loop_delay_ms);
    memcpy(status.stiffness_limit_n_per_m, haptic->stiffness_limit,
           sizeof status.stiffness_limit_n_per_m);
    return status;
}

/* For stderr, by the main thread. */
static void post_judgement(ss_loops *loops, const softsim_server_status *status)
{
    ss_judgement *judgement = ss_mailbox_draft(loops->judgement);
    judgement->verdict = (softsim_verdict)status->verdict;
    snprintf(judgement->reason, sizeof judgement->reason, "%s", status->reason);
    const ss_other_server *other = ss_net_other_server(loops->net);
    const bool has_other_server = ss_other_server_is_alive(other, ss_clock_now_ns());
    snprintf(judgement->other, sizeof judgement->other, "%.200s",
             has_other_server ? other->status.scene : "");
    ss_mailbox_post(loops->judgement);
}

void ss_loops_send_status(ss_loops *loops)
{
    if (loops->options->lockstep) {
        ss_world_settle(loops->world);
        ss_loops_measure_rate(loops);
    }
    take_stats(loops);
    softsim_server_status status = describe(loops);
    judge(loops, &status);
    ss_net_send_status(loops->net, &status);
    post_judgement(loops, &status);
}
