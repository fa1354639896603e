/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <string.h>

#include "rt/clock.h"
#include "world/plan.h"
#include "world/world.h"

/*
 * One haptic tick of every probe. Poses come in by a ring, the newest local contact model by a
 * mailbox; the proxy's target goes out by a mailbox, the force by a ring. Nothing here waits.
 */

enum { TICK_POSES = 64 /* more are left for the next tick */ };

static void run_haptic_command(ss_world *world, const ss_command_record *command)
{
    ss_haptic_config *config = &world->haptic_config;
    double *const number[] = {[SS_LIVE_MAX_FORCE] = &config->max_force,
                              [SS_LIVE_MAX_SLEW] = &config->max_slew,
                              [SS_LIVE_COUPLING_STIFFNESS] = &config->stiffness,
                              [SS_LIVE_COUPLING_DAMPING] = &config->damping};
    ss_loop_hear(&world->haptic_run, command->kind);
    if (command->kind != SS_COMMAND_SET) {
        return;
    }
    if ((size_t)command->key < sizeof number / sizeof number[0]) {
        *number[command->key] = command->value;
    } else if (command->key == SS_LIVE_BETWEEN_STEPS) {
        config->between_steps = ss_world_between((ss_scene_between)command->value);
    } else {
        return;
    }
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            const ss_haptic_config changed = ss_world_probe_config(world, p);
            ss_haptic_configure(world->probe[p].haptic, &changed);
        }
    }
}

/* One probe: drain its poses (all of them: the newest wins, none is lost to the energy sum and
 * the button edges), tick, post the proxy target, push the force. */
static void tick_probe(ss_world *world, int32_t p, int64_t tick, int64_t due_ns,
                       ss_haptic_stats *stats)
{
    ss_world_probe *probe = &world->probe[p];
    softsim_pose pose[TICK_POSES];
    ss_pose_record record;
    ss_haptic_input input = {.tick = tick, .pose = pose};
    while (input.pose_count < TICK_POSES && ss_ring_pop(probe->poses, &record)) {
        pose[input.pose_count++] = record.pose;
        input.sender_epoch = record.sender_epoch;
    }
    if (input.pose_count > 1) {
        world->superseded += input.pose_count - 1;
    }
    input.result = ss_mailbox_take(probe->result, &input.is_result_new);
    input.is_paused = world->haptic_run.is_paused;
    input.restart_count = world->haptic_run.restart_count;
    input.is_stopping = atomic_load_explicit(&world->is_stopping, memory_order_acquire);

    ss_haptic_output output;
    ss_haptic_tick(probe->haptic, &input, &output);
    *(ss_proxy_target *)ss_mailbox_draft(probe->target) = output.target;
    ss_mailbox_post(probe->target);
    world->is_answering |= output.has_force;
    world->has_target |= output.target.is_present;
    if (output.has_force) {
        const ss_force_record out = {.force = output.force, .tick = tick, .due_ns = due_ns};
        ss_ring_push(world->forces, &out);
    }
    const ss_hand_tick hand = {.tick = tick,
                               .period = world->period,
                               .pose = input.pose_count > 0 ? &pose[input.pose_count - 1] : NULL,
                               .superseded = input.pose_count - 1,
                               .sender_epoch = input.sender_epoch,
                               .sent = &output.force,
                               .result = input.is_result_new ? input.result : NULL,
                               .contact_j = output.contact_j,
                               .device_j = output.energy_to_device_j - output.energy_from_device_j,
                               .others_j = world->taken_j - probe->taken_j,
                               .let_in_j = output.let_in_j,
                               .trail_s = world->haptic_config.damping / output.stiffness_limit,
                               .max_force_n = world->haptic_config.max_force,
                               .is_lockstep = world->haptic_config.is_lockstep};
    ss_hand_watch_tick(&probe->hand, &hand);
    stats->hand = ss_hand_verdict_worse(stats->hand, ss_hand_watch_verdict(&probe->hand, tick));
    probe->taken_j = output.energy_from_device_j;
    stats->worst_contact_j[p] = output.worst_contact_j;
    stats->stiffness_limit[p] = output.stiffness_limit;
    stats->stiffness_backoffs += output.stiffness_backoffs;
    stats->energy_to_device_j += output.energy_to_device_j;
    stats->energy_from_device_j += output.energy_from_device_j;
    for (int i = 0; i < 2 && output.has_force; ++i) {
        stats->loop_delay_ms[i] = fmax(stats->loop_delay_ms[i], output.loop_delay_ms[i]);
    }
}

void ss_world_haptic_tick(ss_world *world, int64_t tick, int64_t due_ns, int64_t now_ns)
{
    ss_command_record command;
    while (ss_ring_pop(world->haptic_commands, &command)) {
        run_haptic_command(world, &command);
    }
    ss_haptic_stats stats = {0};
    world->has_target = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            tick_probe(world, p, tick, due_ns, &stats);
        }
    }
    world->taken_j = stats.energy_from_device_j;
    world->hand = stats.hand;
    world->worst_hand = ss_hand_verdict_worse(world->worst_hand, stats.hand);
    if (due_ns != 0) {
        ss_histogram_add(world->lateness, now_ns, 1e-3 * (double)(now_ns - due_ns));
    }
    if (due_ns != 0 && tick >= world->next_quantiles_tick) {
        static const double quantile[4] = {0.5, 0.99, 0.999, 1.0};
        world->next_quantiles_tick = tick + (int64_t)ceil(0.25 / world->period);
        for (int i = 0; i < 4; ++i) {
            world->lateness_us[i] = ss_histogram_quantile(world->lateness, quantile[i]);
        }
    }
    memcpy(stats.lateness_us, world->lateness_us, sizeof stats.lateness_us);
    stats.superseded = world->superseded;
    stats.late_periods = world->late_periods;
    *(ss_haptic_stats *)ss_mailbox_draft(world->haptic_stats) = stats;
    ss_mailbox_post(world->haptic_stats);
}
