/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops.h"

#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "claim.h"
#include "pace.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/program.h"
#include "rt/thread.h"
#include "rt/vec.h"
#include "tell.h"

/*
 * Every loop runs on the absolute monotonic clock from one common start, so that tick n is due at
 * start + n T for all of them. A loop that wakes late by whole periods skips them, and the skipped
 * ones are missed periods: nothing is caught up by running twice.
 *
 * Settling a period (net thread only, so that forces + missed = periods in every status): the
 * haptic loop hands over one force a tick with the tick's number; a gap in the numbers is missed
 * periods; a force sent within one period of its due time is a force, a later one is a missed
 * period though it was sent.
 */

enum {
    HAPTIC_PRIORITY = 80,
    NET_PRIORITY = 78,
    SIMULATION_PRIORITY = 70,
    FAULT_WIRE_CLAMPED = 1 << 16,
    FAULT_WIRE_CAPPED = 1 << 17,
    FAULT_SLOW = 1 << 18,
    STOP_TICKS = 25, /* the force ramps to zero in 20 */
    RATE_MARKS = 5   /* a quarter of a second apart */
};
static const int64_t STATUS_PERIOD_NS = 250000000;
static const int64_t RATE_PERIOD_NS = 250000000;
static const int64_t SILENCE_NS = 5000000000; /* a status says so for as long */

/* Steps a second of the clock: over the last second, once there is one. */
typedef struct rate_meter {
    int64_t time_ns[RATE_MARKS], step[RATE_MARKS];
    int64_t count; /* of marks ever made */
} rate_meter;

typedef struct ss_loops {
    ss_world *world;
    const ss_options *options;
    int64_t start_ns;
    int64_t period_ns, step_period_ns;
    int wake_fd;           /* haptic -> net */
    int event_fd;          /* net -> main: it listens, or cannot */
    atomic_bool is_ending; /* loops return */
    atomic_bool is_over;   /* main shall end: shutdown, duration in lockstep, broken network */
    atomic_bool is_listening;
    atomic_int refreshes;                         /* net -> publish */
    _Atomic double mesh_rate_hz, max_bytes_per_s; /* net -> publish */
    _Atomic double rate_hz;                       /* simulation -> net: achieved */
    ss_mailbox *opinion;                          /* net -> main: ss_opinion */
    rate_meter meter;                             /* simulation thread; net in lockstep */
    ss_pace pace;                                 /* simulation thread */

    /* net thread */
    ss_net *net;
    bool takes_commands;
    softsim_status open_status; /* main reads it from is_listening on */
    softsim_status net_status;  /* main reads it after the thread's end */
    softsim_error net_error;
    bool is_open; /* the prefix is ours: poses and commands are taken */
    ss_claim claim;
    int64_t last_tick[SOFTSIM_MAX_PROBES];
    int64_t periods[SOFTSIM_MAX_PROBES], forces[SOFTSIM_MAX_PROBES], missed[SOFTSIM_MAX_PROBES];
    int32_t last_flags[SOFTSIM_MAX_PROBES]; /* of the newest force */
    int64_t silent_ns[SOFTSIM_MAX_PROBES];  /* since when it has been stale */
    char slow_reason[128];
    double peak_force;
    int64_t next_status_ns;
    int64_t queue_refused; /* poses that found their ring full */
    ss_haptic_stats haptic_stats;
    ss_simulation_stats simulation_stats;

    /* main thread */
    ss_teller teller;

    /* publish thread; read by net */
    ss_publisher *publisher;
} ss_loops;

/* ---- net thread: poses in
 * ------------------------------------------------------------------------ */

static void answer(ss_loops *loops, softsim_force *force)
{
    force->utime_us = ss_clock_now_ns() / 1000;
    ss_net_send_force(loops->net, force);
}

static void end(ss_loops *loops)
{
    atomic_store_explicit(&loops->is_over, true, memory_order_release);
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
    ss_world_lockstep(world, pose, &channel, 1, force);
    if ((force[channel].flags & SOFTSIM_FORCE_OTHER_SENDER) == 0) {
        ++loops->forces[channel];
        ++loops->periods[channel];
        note_flags(loops, channel, force[channel].flags);
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
        end(loops);
    }
}

static void handle_pose(void *context, const softsim_pose *pose, int32_t channel,
                        int64_t receive_ns)
{
    ss_loops *loops = context;
    ss_world *world = loops->world;
    if (!loops->is_open) {
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
        loops->queue_refused += !ss_ring_push(world->probe[channel].poses, &record);
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
    (void)channel;
    if (loops->is_open) {
        ss_gate_refuse(loops->world->gate, reason);
    }
}

static void send_status(ss_loops *loops);

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
        break;
    case SS_COMMAND_STATUS:
        send_status(loops);
        break;
    case SS_COMMAND_SHUTDOWN:
        end(loops);
        break;
    case SS_COMMAND_SET:
        if (record.key == SS_LIVE_MAX_BYTES) {
            atomic_store_explicit(&loops->max_bytes_per_s, record.value, memory_order_release);
        } else if (record.key == SS_LIVE_MESH_RATE) {
            atomic_store_explicit(&loops->mesh_rate_hz, record.value, memory_order_release);
        }
        break;
    default:
        break;
    }
    return 0;
}

/* ---- net thread: forces and status out
 * ------------------------------------------------------------- */

static void settle_forces(ss_loops *loops)
{
    ss_force_record record;
    while (ss_ring_pop(loops->world->forces, &record)) {
        const int32_t p = record.force.probe;
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

/* Renews the rate, right behind a step so that slow steps are not counted by halves, and marks
 * every quarter of a second where the simulation is. */
static void measure_rate(ss_loops *loops)
{
    rate_meter *meter = &loops->meter;
    const int64_t now_ns = ss_clock_now_ns();
    const int64_t oldest = meter->count < RATE_MARKS ? 0 : meter->count % RATE_MARKS;
    const int64_t newest = (meter->count + RATE_MARKS - 1) % RATE_MARKS;
    if (meter->count > 0 && now_ns > meter->time_ns[oldest]) {
        const double steps = (double)(loops->world->steps - meter->step[oldest]);
        const double time_s = 1e-9 * (double)(now_ns - meter->time_ns[oldest]);
        atomic_store_explicit(&loops->rate_hz, steps / time_s, memory_order_relaxed);
    }
    if (meter->count == 0 || now_ns - meter->time_ns[newest] >= RATE_PERIOD_NS) {
        const int64_t slot = meter->count++ % RATE_MARKS;
        meter->time_ns[slot] = now_ns;
        meter->step[slot] = loops->world->steps;
    }
}

/* The model's verdict, or what else is wrong when the model is well. */
static void judge(ss_loops *loops, ss_report *report)
{
    const ss_model_info *info = &loops->simulation_stats.info;
    report->verdict = info->verdict;
    report->reason = info->reason ? info->reason : "";
    report->fault_bits = (int32_t)info->fault_bits;
    const ss_hand_verdict *hand = &loops->haptic_stats.hand;
    if (hand->verdict > report->verdict) {
        report->verdict = hand->verdict;
        report->reason = hand->reason;
    }
    if (loops->publisher && ss_publisher_is_clamping(loops->publisher)) {
        report->fault_bits |= FAULT_WIRE_CLAMPED;
        report->reason =
            *report->reason ? report->reason : "displacements beyond the wire's range are clamped";
    }
    if (loops->publisher && ss_publisher_is_capped(loops->publisher)) {
        report->fault_bits |= FAULT_WIRE_CAPPED;
        report->reason =
            *report->reason ? report->reason : "publish.max_bytes_per_s delays the mesh";
    }
    const double pace = 1.0 - loops->simulation_stats.lag;
    if (pace < SS_PACE_LEAST) {
        report->fault_bits |= FAULT_SLOW;
        if (report->verdict < SOFTSIM_VERDICT_DEGRADED) {
            report->verdict = SOFTSIM_VERDICT_DEGRADED;
            snprintf(loops->slow_reason, sizeof loops->slow_reason,
                     "simulated %.0f %% of real time: lower simulation.rate_hz, choose a coarser "
                     "mesh, or leave the machine less to do",
                     100.0 * pace);
            report->reason = loops->slow_reason;
        }
    }
    if (loops->simulation_stats.is_paused && !*report->reason) {
        report->reason = "paused: forces are zero until the command resume";
    }
    const char *reason = probe_reason(loops);
    if (reason && !*report->reason) {
        report->reason = reason;
    }
}

static void send_status(ss_loops *loops)
{
    ss_world *world = loops->world;
    const ss_scene *scene = world->scene;
    if (loops->options->lockstep) {
        ss_world_settle(world);
        measure_rate(loops);
    }
    take_stats(loops);
    const ss_simulation_stats *simulation = &loops->simulation_stats;
    const ss_haptic_stats *haptic = &loops->haptic_stats;
    const ss_model_info *info = &simulation->info;
    ss_gate_counts counts;
    ss_gate_read(world->gate, &counts);
    const int64_t utime_us = ss_clock_now_ns() / 1000;
    ss_report report = {
        .utime_us = utime_us,
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
        .uptime_s = 1e-6 * (double)(utime_us - loops->claim.start_us),
        .simulation_rate_hz = atomic_load_explicit(&loops->rate_hz, memory_order_relaxed),
        .stable_step_s = info->stable_step,
        .kinetic_j = info->kinetic,
        .elastic_j = info->elastic,
        .total_j = info->kinetic + info->elastic,
        .energy_to_device_j = haptic->energy_to_device_j,
        .energy_from_device_j = haptic->energy_from_device_j,
        .scene = scene->path,
        .model = world->model_class->name};
    if (loops->options->lockstep) {
        /* Of one state: the step computed last, whose result may still be held back. */
        report.step = world->steps;
        report.state_hash = (int64_t)ss_world_hash(world);
    }
    memcpy(report.poses_refused, counts.refused, sizeof report.poses_refused);
    memcpy(report.probe_periods, loops->periods, sizeof report.probe_periods);
    memcpy(report.probe_forces, loops->forces, sizeof report.probe_forces);
    memcpy(report.probe_missed, loops->missed, sizeof report.probe_missed);
    memcpy(report.step_us, simulation->step_us, sizeof report.step_us);
    memcpy(report.lateness_us, haptic->lateness_us, sizeof report.lateness_us);
    memcpy(report.worst_contact_j, haptic->worst_contact_j, sizeof report.worst_contact_j);
    memcpy(report.loop_delay_ms, haptic->loop_delay_ms, sizeof report.loop_delay_ms);
    memcpy(report.stiffness_limit_n_per_m, haptic->stiffness_limit,
           sizeof report.stiffness_limit_n_per_m);
    judge(loops, &report);
    ss_net_send_status(loops->net, &report);
    ss_opinion *opinion = ss_mailbox_draft(loops->opinion);
    opinion->verdict = report.verdict;
    snprintf(opinion->reason, sizeof opinion->reason, "%s", report.reason);
    const ss_rival *rival = ss_net_rival(loops->net);
    const bool has_rival = ss_rival_is_alive(rival, ss_clock_now_ns());
    snprintf(opinion->rival, sizeof opinion->rival, "%.200s", has_rival ? rival->status.scene : "");
    ss_mailbox_post(loops->opinion);
}

/* ---- net thread
 * --------------------------------------------------------------------------------------- */

/* Until the end: statuses at their time, messages as they come, forces as they are due. */
static void take_turns(ss_loops *loops)
{
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        const int64_t now = ss_clock_now_ns();
        if (now >= loops->next_status_ns) {
            loops->next_status_ns = now + STATUS_PERIOD_NS;
            send_status(loops);
        }
        const int64_t wait_ms = (loops->next_status_ns - now) / 1000000 + 1;
        if (!ss_net_wait(loops->net, loops->wake_fd, (int)wait_ms)) {
            loops->net_status = SOFTSIM_ERROR_NETWORK;
            softsim_error_add(&loops->net_error, SOFTSIM_ERROR_NETWORK,
                              "LCM stopped working; check the network and start again");
            end(loops);
            break;
        }
        if (loops->net_status == SOFTSIM_OK &&
            !ss_claim_hold(&loops->claim, loops->net, loops->options, &loops->net_error)) {
            loops->net_status = SOFTSIM_ERROR_NETWORK;
            end(loops);
        }
        if (!loops->options->lockstep) {
            settle_forces(loops);
        }
    }
}

static void *net_body(void *argument)
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
        loops->open_status = ss_claim_prefix(loops->net, loops->options, &loops->net_error);
    }
    loops->is_open = loops->open_status == SOFTSIM_OK;
    loops->claim.start_us = ss_clock_now_ns() / 1000;
    atomic_store_explicit(&loops->is_listening, true, memory_order_release);
    ss_wake_signal(loops->event_fd);
    if (!loops->is_open) {
        ss_net_close(&loops->net);
        return NULL;
    }
    take_turns(loops);
    settle_forces(loops);
    send_status(loops);
    ss_net_close(&loops->net);
    return NULL;
}

/* ---- the other loops
 * ------------------------------------------------------------------------------------ */

/* Sleeps until period `*tick` + 1 is due; skips the periods that are already over. Returns the
 * due time and counts the skipped ones. */
static int64_t next_period(int64_t start_ns, int64_t period_ns, int64_t *tick, int64_t *out_skipped)
{
    ++*tick;
    int64_t due = start_ns + *tick * period_ns;
    const int64_t now = ss_clock_now_ns();
    *out_skipped = 0;
    if (now - due >= period_ns) {
        *out_skipped = (now - due) / period_ns;
        *tick += *out_skipped;
        due += *out_skipped * period_ns;
    }
    ss_clock_sleep_until(due);
    return due;
}

static void *haptic_body(void *argument)
{
    ss_loops *loops = argument;
    ss_world *world = loops->world;
    int64_t tick = 0;
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        const int64_t due = next_period(loops->start_ns, loops->period_ns, &tick, &skipped);
        world->late_periods += skipped;
        ss_world_haptic_tick(world, tick, due, ss_clock_now_ns());
        ss_wake_signal(loops->wake_fd);
    }
    return NULL;
}

static void *simulation_body(void *argument)
{
    ss_loops *loops = argument;
    ss_world *world = loops->world;
    int64_t step = 0;
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        next_period(loops->start_ns, loops->step_period_ns, &step, &skipped);
        world->lag = 1.0 - ss_pace_share(&loops->pace);
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
        ss_pace_note(&loops->pace, ss_clock_now_ns());
        measure_rate(loops);
    }
    return NULL;
}

static void *publish_body(void *argument)
{
    ss_loops *loops = argument;
    int refreshes = 0;
    int64_t due = loops->start_ns;
    double max_bytes = atomic_load_explicit(&loops->max_bytes_per_s, memory_order_acquire);
    while (!atomic_load_explicit(&loops->is_ending, memory_order_acquire)) {
        /* At 5 Hz at least, whatever the rate of new states: topology, sweep and commands. */
        const double rate = atomic_load_explicit(&loops->mesh_rate_hz, memory_order_acquire);
        const int64_t period = (int64_t)(1e9 / fmax(rate, 5.0));
        const int64_t now = ss_clock_now_ns();
        due = now - due > period ? now : due + period;
        ss_clock_sleep_until(due);
        const double new_max = atomic_load_explicit(&loops->max_bytes_per_s, memory_order_acquire);
        if (new_max != max_bytes) {
            max_bytes = new_max;
            ss_publisher_set_max_bytes(loops->publisher, max_bytes);
        }
        const int asked = atomic_load_explicit(&loops->refreshes, memory_order_acquire);
        if (asked != refreshes) {
            refreshes = asked;
            ss_publisher_refresh(loops->publisher);
        }
        bool is_new = false;
        const ss_surface_snapshot *snapshot = ss_mailbox_take(loops->world->surface, &is_new);
        ss_publisher_send(loops->publisher, ss_clock_now_ns(), snapshot ? snapshot->step : 0,
                          snapshot && is_new ? snapshot->displacement : NULL);
    }
    return NULL;
}

/* ---- main thread
 * ------------------------------------------------------------------------------------------ */

typedef struct ss_loop_threads {
    ss_thread *net, *simulation, *haptic, *publish;
    bool is_fifo_refused;
} ss_loop_threads;

static softsim_status start_loop(ss_loops *loops, const char *name, int priority,
                                 void *(*body)(void *), ss_thread **out_thread,
                                 ss_loop_threads *threads, softsim_error *error)
{
    bool is_refused = false;
    /* Lockstep computes as long as it takes: ahead of everything else only where asked to. */
    const ss_realtime wanted = loops->options->realtime;
    const ss_realtime realtime =
        loops->options->lockstep && wanted == SS_REALTIME_AUTO ? SS_REALTIME_OFF : wanted;
    const softsim_status status =
        ss_thread_start(name, priority, realtime, body, loops, out_thread, &is_refused);
    threads->is_fifo_refused |= is_refused;
    if (status != SOFTSIM_OK) {
        softsim_error_add(error, status,
                          "cannot start the %s thread: %s; --realtime auto falls back to the "
                          "ordinary scheduler",
                          name, softsim_status_text(status));
    }
    return status;
}

/* The net thread opens LCM itself: it alone uses it. */
static softsim_status start_net(ss_loops *loops, ss_loop_threads *threads, softsim_error *error)
{
    const softsim_status status =
        start_loop(loops, "net", NET_PRIORITY, net_body, &threads->net, threads, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    while (!atomic_load_explicit(&loops->is_listening, memory_order_acquire)) {
        struct pollfd wait = {.fd = loops->event_fd, .events = POLLIN};
        poll(&wait, 1, 100);
        ss_wake_drain(loops->event_fd);
    }
    if (loops->open_status != SOFTSIM_OK) {
        *error = loops->net_error;
    }
    return loops->open_status;
}

static softsim_status open_publisher(ss_loops *loops, softsim_error *error)
{
    const ss_scene *scene = loops->world->scene;
    const ss_mesh *mesh = scene->mesh;
    const ss_publisher_config config = {.lcm_url = loops->options->lcm_url,
                                        .prefix = loops->options->prefix,
                                        .max_bytes_per_s = scene->max_bytes_per_s};
    const ss_publish_mesh surface = {.node_count = mesh->node_count,
                                     .triangle_count = mesh->triangle_count,
                                     .rest = (const double(*)[3])mesh->position,
                                     .triangle = (const int32_t(*)[3])mesh->triangle,
                                     .file_node = mesh->file_node,
                                     .fixed = scene->fixed,
                                     .diagonal = ss_mesh_diagonal(mesh)};
    return ss_publisher_open(&config, &surface, &loops->publisher, error);
}

static softsim_status start_all(ss_loops *loops, ss_loop_threads *threads, softsim_error *error)
{
    const bool is_lockstep = loops->options->lockstep;
    softsim_status status = SOFTSIM_OK;
    if (loops->world->surface) {
        status = open_publisher(loops, error);
    }
    if (status == SOFTSIM_OK) {
        status = start_net(loops, threads, error);
    }
    loops->start_ns = ss_clock_now_ns() + loops->period_ns;
    if (status == SOFTSIM_OK && !is_lockstep) {
        status = start_loop(loops, "simulation", SIMULATION_PRIORITY, simulation_body,
                            &threads->simulation, threads, error);
    }
    if (status == SOFTSIM_OK && !is_lockstep && loops->world->used_probes) {
        status = start_loop(loops, "haptic", HAPTIC_PRIORITY, haptic_body, &threads->haptic,
                            threads, error);
    }
    if (status == SOFTSIM_OK && loops->world->surface) {
        status = start_loop(loops, "publish", 0, publish_body, &threads->publish, threads, error);
    }
    return status;
}

/* Waits for a signal to stop, the duration, or the end from within. */
static void wait_for_end(ss_loops *loops)
{
    const double duration = loops->options->lockstep ? 0.0 : loops->options->duration_s;
    const int64_t deadline =
        duration > 0.0 ? ss_clock_now_ns() + (int64_t)(duration * 1e9) : INT64_MAX;
    sigset_t signals;
    ss_program_stop_signals(&signals);
    while (!atomic_load_explicit(&loops->is_over, memory_order_acquire)) {
        const int64_t now = ss_clock_now_ns();
        const int64_t left = deadline - now;
        if (left <= 0) {
            return;
        }
        const ss_opinion *opinion = ss_mailbox_take(loops->opinion, NULL);
        if (loops->options->log_level >= SS_LOG_WARNING) {
            ss_tell(&loops->teller, opinion, now);
        }
        const int64_t wait = left < 50000000 ? left : 50000000;
        const struct timespec timeout = {.tv_nsec = (long)wait};
        if (sigtimedwait(&signals, NULL, &timeout) > 0) {
            return;
        }
    }
}

static void print_summary(const ss_loops *loops)
{
    int64_t periods = 0, forces = 0, missed = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        periods += loops->periods[p];
        forces += loops->forces[p];
        missed += loops->missed[p];
    }
    const double *late = loops->haptic_stats.lateness_us;
    const double *step = loops->simulation_stats.step_us;
    fprintf(stderr,
            "softsimd: %lld haptic periods: %lld forces, %lld missed; peak force %.3f N\n"
            "softsimd: haptic lateness us p50 %.0f p99 %.0f p99.9 %.0f max %.0f; step us p50 %.0f "
            "p99 %.0f max %.0f; %lld steps of %.6g ms\n",
            (long long)periods, (long long)forces, (long long)missed, loops->peak_force, late[0],
            late[1], late[2], late[3], step[0], step[1], step[2],
            (long long)loops->simulation_stats.info.step, 1e3 * loops->world->step_period);
}

softsim_status ss_loops_run(ss_world *world, const ss_options *options, softsim_error *error)
{
    ss_loops *loops = ss_memory_get(1, sizeof *loops);
    if (!loops) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no memory for the loops");
        return SOFTSIM_ERROR_MEMORY;
    }
    loops->world = world;
    loops->options = options;
    loops->takes_commands =
        !options->no_commands && (options->allow_commands || !ss_net_is_own_url(options->lcm_url));
    loops->period_ns = (int64_t)llround(world->period * 1e9);
    loops->step_period_ns = loops->period_ns * world->step_ticks;
    ss_pace_init(&loops->pace, loops->step_period_ns);
    loops->wake_fd = ss_wake_open();
    loops->event_fd = ss_wake_open();
    loops->opinion = ss_mailbox_create(sizeof(ss_opinion));
    loops->teller = (ss_teller){.prefix = options->prefix, .gate = world->gate};
    atomic_store(&loops->mesh_rate_hz, world->scene->mesh_rate_hz);
    atomic_store(&loops->max_bytes_per_s, world->scene->max_bytes_per_s);

    if (options->realtime != SS_REALTIME_OFF && !options->lockstep && !ss_thread_lock_memory() &&
        options->log_level >= SS_LOG_WARNING) {
        fprintf(stderr, "softsimd: warning: memory is not locked, so a page fault may delay a "
                        "force; raise `ulimit -l` or run as root\n");
    }
    ss_loop_threads threads = {0};
    softsim_status status = SOFTSIM_ERROR_SYSTEM;
    if (!loops->opinion) {
        status = SOFTSIM_ERROR_MEMORY;
        softsim_error_add(error, status, "no memory for the loops");
    } else if (loops->wake_fd < 0 || loops->event_fd < 0) {
        softsim_error_add(error, status, "cannot open an eventfd: %s; raise `ulimit -n`",
                          softsim_status_text(status));
    } else {
        status = start_all(loops, &threads, error);
    }
    if (status == SOFTSIM_OK) {
        if (threads.is_fifo_refused && options->log_level >= SS_LOG_WARNING) {
            fprintf(stderr, "softsimd: warning: SCHED_FIFO is not allowed, so forces may be late; "
                            "run as root or raise `ulimit -r`\n");
        }
        puts("softsimd: ready");
        fflush(stdout);
        wait_for_end(loops);
        end(loops); /* in lockstep no pose that still waits is answered */
        if (!options->lockstep) {
            /* Let the haptic loop ramp the forces to zero. */
            atomic_store_explicit(&world->is_stopping, true, memory_order_release);
            ss_clock_sleep_until(ss_clock_now_ns() + STOP_TICKS * loops->period_ns);
        }
    }
    atomic_store_explicit(&loops->is_ending, true, memory_order_release);
    ss_thread_join(&threads.haptic);
    ss_thread_join(&threads.simulation);
    ss_wake_signal(loops->wake_fd);
    ss_thread_join(&threads.net);
    ss_thread_join(&threads.publish);
    ss_publisher_close(&loops->publisher);
    if (status == SOFTSIM_OK) {
        status = loops->net_status;
        if (status != SOFTSIM_OK) {
            *error = loops->net_error;
        }
        if (options->log_level >= SS_LOG_INFO && ss_program_can_tell()) {
            print_summary(loops);
        }
    }
    if (loops->wake_fd >= 0) {
        close(loops->wake_fd);
    }
    if (loops->event_fd >= 0) {
        close(loops->event_fd);
    }
    ss_mailbox_destroy(&loops->opinion);
    ss_memory_free(loops);
    return status;
}
