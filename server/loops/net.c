/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/*
 * The net loop: poses and commands in, forces and statuses out. In lockstep it alone moves the
 * world: each pose by one tick.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/thread.h"
#include "rt/vec.h"

static const int64_t STATUS_PERIOD_NS = 250000000;
/* Requests are answered together, so that nobody makes the server speak as often as one who floods:
 * who hears it may then tell the two apart (client.c, net.c). */
static const int64_t ASKED_PERIOD_NS = 50000000;
static const int64_t SCENE_PERIOD_NS = 2000000000;

/* ---- poses and commands in ---- */

static void answer(ss_loops *loops, softsim_force *force)
{
    force->utime_us = ss_clock_now_ns() / 1000;
    ss_net_send_force(loops->net, force);
}

/* Notes what the newest force of a probe says, and since when its probe is silent. */
static void note_flags(ss_loops *loops, int32_t p, int32_t flags)
{
    if ((flags & ~loops->last_flags[p] & SOFTSIM_FORCE_STALE) != 0) {
        loops->silent_ns[p] = ss_clock_now_ns();
    }
    loops->last_flags[p] = flags;
}

/* Lockstep: the pose moves the world by one tick and is answered. */
static void answer_lockstep(ss_loops *loops, const softsim_pose *pose, int32_t channel)
{
    ss_world *world = loops->world;
    ss_world_probe *probe = &world->probe[channel];
    if (probe->has_answer && probe->answered_seq == pose->seq &&
        probe->answered_sender == pose->sender && probe->answered_source == pose->source) {
        answer(loops, &probe->answer);
        return;
    }
    if (atomic_load_explicit(&loops->is_over, memory_order_relaxed)) {
        return; /* the end has its tick, however long the loops take to see it */
    }
    softsim_force force[SOFTSIM_MAX_PROBES];
    const softsim_refusal refusal = ss_world_lockstep(world, pose, &channel, 1, force);
    if ((force[channel].flags & SOFTSIM_FORCE_OTHER_SENDER) == 0) {
        ++loops->forces[channel];
        ++loops->periods[channel];
        note_flags(loops, channel, force[channel].flags);
    }
    if (refusal == SOFTSIM_ACCEPTED) {
        ss_prefix_owner_note_pose(&loops->prefix_owner, channel, pose, ss_clock_now_ns());
    }
    loops->peak_force = fmax(loops->peak_force, ss_norm3(force[channel].force));
    /* Who uses the holder's number from another address gets none: the holder would take it. */
    if ((force[channel].flags & SOFTSIM_FORCE_OTHER_SENDER) == 0 ||
        ss_gate_may_answer_other(world->gate, pose, channel, 0)) {
        probe->answer = force[channel];
        probe->answered_seq = pose->seq;
        probe->answered_sender = pose->sender;
        probe->answered_source = pose->source;
        probe->has_answer = true;
        answer(loops, &probe->answer);
    }
    /* The tick nearest to the duration is the last, as in softsim-run. */
    const double duration = loops->options->duration_s;
    if (duration > 0.0 && ((double)world->tick + 0.5) * world->period > duration) {
        ss_loops_end(loops);
    }
}

static void handle_pose(void *context, const softsim_pose *pose, int32_t channel,
                        int64_t receive_ns)
{
    ss_loops *loops = context;
    ss_world *world = loops->world;
    if (!loops->is_open) {
        ss_prefix_owner_note_early(&loops->prefix_owner, channel, pose);
        return;
    }
    if (loops->options->lockstep) {
        answer_lockstep(loops, pose, channel);
        return;
    }
    ss_pose_record record = {.pose = *pose};
    const softsim_refusal refusal =
        ss_gate_judge(world->gate, pose, channel, receive_ns, &record.sender_epoch);
    if (refusal == SOFTSIM_ACCEPTED) {
        ss_prefix_owner_note_pose(&loops->prefix_owner, channel, pose, receive_ns);
        loops->queue_refused += !ss_ring_push(world->probe[channel].poses, &record);
        if (!loops->is_answering) {
            ss_wake_signal(loops->haptic_fd);
        }
    } else if (refusal == SOFTSIM_REFUSED_OTHER_SENDER &&
               ss_gate_may_answer_other(world->gate, pose, channel, receive_ns)) {
        softsim_force force = {.sender = pose->sender,
                               .probe = channel,
                               .pose_seq = pose->seq,
                               .pose_utime_us = pose->utime_us,
                               .flags = SOFTSIM_FORCE_OTHER_SENDER};
        answer(loops, &force);
    }
}

static void handle_refusal(void *context, softsim_refusal reason, int32_t channel)
{
    ss_loops *loops = context;
    if (loops->is_open && channel < 0) {
        ss_gate_refuse_command(loops->world->gate);
    } else if (loops->is_open) {
        ss_gate_refuse(loops->world->gate, reason);
    }
}

static int32_t handle_command(void *context, const char *name, const char *argument, char *out_text,
                              int32_t text_size)
{
    ss_loops *loops = context;
    if (!loops->is_open) {
        return -1;
    }
    if (!loops->takes_commands && strcmp(name, "refresh") != 0 && strcmp(name, "status") != 0) {
        snprintf(out_text, (size_t)text_size,
                 loops->options->no_commands
                     ? "refused: the server was started with --no-commands"
                     : "refused: a server with an LCM URL of its user's own takes commands only "
                       "when started with --allow-commands");
        return 1;
    }
    ss_command_record record;
    const int32_t code =
        ss_world_command(loops->world, name, argument, &record, out_text, text_size);
    if (code != 0) {
        return code;
    }
    switch (record.kind) {
    case SS_COMMAND_REFRESH:
        atomic_fetch_add_explicit(&loops->refreshes, 1, memory_order_release);
        loops->scene_ns = 0;
        break;
    case SS_COMMAND_STATUS:
        loops->is_status_asked = true;
        break;
    case SS_COMMAND_SHUTDOWN:
        ss_loops_end(loops);
        break;
    case SS_COMMAND_SET:
        loops->has_set = true;
        if (record.key == SS_LIVE_MAX_BYTES) {
            atomic_store_explicit(&loops->max_bytes_per_s, record.value, memory_order_release);
        } else if (record.key == SS_LIVE_FIELD) {
            atomic_store_explicit(&loops->world->field, (int)record.value, memory_order_release);
        } else if (record.key == SS_LIVE_MESH_RATE) {
            atomic_store_explicit(&loops->mesh_rate_hz, record.value, memory_order_release);
        }
        break;
    default:
        break;
    }
    ss_loops_call(loops);
    return 0;
}

/* ---- forces out ---- */

static void settle_forces(ss_loops *loops)
{
    ss_force_record record;
    while (ss_ring_pop(loops->world->forces, &record)) {
        const int32_t p = record.force.probe;
        loops->is_answering = true;
        const int64_t first = loops->last_tick[p] ? loops->last_tick[p] : record.tick - 1;
        const int64_t settled = record.tick - first;
        record.force.utime_us = ss_clock_now_ns() / 1000;
        const bool is_sent = ss_net_send_force(loops->net, &record.force);
        const bool in_time = is_sent && ss_clock_now_ns() - record.due_ns <= loops->period_ns;
        loops->periods[p] += settled;
        loops->forces[p] += in_time;
        loops->missed[p] += settled - in_time;
        loops->last_tick[p] = record.tick;
        note_flags(loops, p, record.force.flags);
        loops->peak_force = fmax(loops->peak_force, ss_norm3(record.force.force));
    }
}

/* ---- the loop ---- */

/* How long until the next one. What was set is told at once: clients hold the force limit, too. */
static int64_t send_due_status(ss_loops *loops)
{
    if (loops->has_set && ss_clock_now_ns() - loops->scene_ns >= ASKED_PERIOD_NS) {
        loops->has_set = false;
        ss_loops_send_scene(loops);
        loops->scene_ns = ss_clock_now_ns();
    }
    const int64_t period_ns = loops->is_status_asked ? ASKED_PERIOD_NS : STATUS_PERIOD_NS;
    const int64_t left_ns = loops->status_ns + period_ns - ss_clock_now_ns();
    if (left_ns > 0) {
        return left_ns;
    }
    loops->is_status_asked = false;
    ss_loops_send_status(loops);
    loops->status_ns = ss_clock_now_ns();
    if (loops->scene_ns == 0 || loops->status_ns - loops->scene_ns >= SCENE_PERIOD_NS) {
        ss_loops_send_scene(loops);
        loops->scene_ns = loops->status_ns;
    }
    return STATUS_PERIOD_NS;
}

/* Until the end: statuses at their time, messages as they come, forces as they are due. */
static void take_turns(ss_loops *loops)
{
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        const int64_t wait_ns = send_due_status(loops);
        if (!ss_net_wait(loops->net, loops->wake_fd, (int)(wait_ns / 1000000) + 1)) {
            loops->net_status = SOFTSIM_ERROR_NETWORK;
            softsim_error_add(&loops->net_error, SOFTSIM_ERROR_NETWORK,
                              "LCM stopped working; check the network and start again");
            ss_loops_end(loops);
            break;
        }
        if (loops->net_status == SOFTSIM_OK &&
            !ss_prefix_owner_hold(&loops->prefix_owner, loops->net, loops->options,
                                  &loops->net_error)) {
            loops->net_status = SOFTSIM_ERROR_NETWORK;
            ss_loops_end(loops);
        }
        if (!loops->options->lockstep) {
            settle_forces(loops);
        }
    }
}

void *ss_loops_net(void *argument)
{
    ss_loops *loops = argument;
    const ss_net_config config = {.lcm_url = loops->options->lcm_url,
                                  .prefix = loops->options->prefix,
                                  .is_lockstep = loops->options->lockstep};
    const ss_net_calls calls = {.context = loops,
                                .handle_pose = handle_pose,
                                .handle_refusal = handle_refusal,
                                .handle_command = handle_command};
    loops->open_status = ss_net_open(&config, &calls, &loops->net, &loops->net_error);
    if (loops->open_status != SOFTSIM_OK && loops->net_error.fault_count == 0) {
        softsim_error_add(&loops->net_error, loops->open_status, "cannot open LCM: %s",
                          softsim_status_text(loops->open_status));
    }
    if (loops->open_status == SOFTSIM_OK) {
        loops->open_status = ss_prefix_owner_claim(loops->net, loops->options, &loops->net_error);
    }
    loops->is_open = loops->open_status == SOFTSIM_OK;
    loops->prefix_owner.start_us = ss_clock_now_ns() / 1000;
    atomic_store_explicit(&loops->is_listening, true, memory_order_release);
    ss_wake_signal(loops->event_fd);
    if (!loops->is_open) {
        ss_net_close(&loops->net);
        return NULL;
    }
    take_turns(loops);
    settle_forces(loops);
    ss_loops_send_status(loops);
    ss_net_close(&loops->net);
    return NULL;
}
