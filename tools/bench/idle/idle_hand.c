/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/idle/idle_hand.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/thread.h"
#include "rt/vec.h"
#include "softsim/client.h"

enum { WAYS = 6, LOOP_PRIORITY = 80 };
static const int64_t PERIOD_NS = 1000000, RATE_SETTLE_US = 1500000;
static const double CLEAR_M = 0.06;   /* beyond the body, when nothing is near */
static const double CIRCLE_M = 0.01;  /* radius, in the air */
static const double SPEED_M_S = 0.02; /* of the press */
static const double PRESS_N = 0.3;    /* where it stops */
static const double DEEPEST_M = 0.02; /* beyond the surface's outermost node */

struct ss_idle_hand {
    softsim_client *client;
    ss_thread *thread, *bare;
    atomic_bool is_ending;
    atomic_int way;
    atomic_int_least64_t bytes, round_bytes, bare_cpu_ns;
    atomic_int active_nodes;
    _Atomic double force, chosen_hz, yardstick, slowest_hz;
    atomic_int worst_verdict;
    atomic_int_least64_t rate_from_us; /* a rate is one of the last second */
    atomic_bool has_surface, is_still;
    /* the hand's thread */
    double outermost[WAYS][3], reach[WAYS]; /* of nodes that are not fixed, along each axis */
    bool has_way[WAYS];
    int32_t nodes_left;
    double place[3], outward[3], surface[3], radius;
    bool has_place;
    int32_t seq;
    int64_t asked_ns;
};

static void axis_of(int way, double out[3])
{
    static const int order[WAYS] = {2, 0, 0, 1, 1, 2}; /* from above first */
    ss_set3(out, 0.0, 0.0, 0.0);
    out[order[way]] = way == 0 || way == 1 || way == 3 ? 1.0 : -1.0;
}

/* ---- received ---- */

static bool ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static void count(void *context, const char *channel, const void *data, int32_t size)
{
    ss_idle_hand *hand = context;
    (void)data;
    const bool is_round = ends_with(channel, "_STATUS") || ends_with(channel, "_SCENE") ||
                          ends_with(channel, "_MESH_TOPOLOGY") || strstr(channel, "_PROBE_") ||
                          strstr(channel, "_FORCE_");
    atomic_fetch_add(&hand->bytes, size);
    atomic_fetch_add(&hand->round_bytes, is_round ? size : 0);
}

static void take_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    ss_idle_hand *hand = context;
    (void)receive_ns;
    atomic_store(&hand->force, ss_norm3(force->force));
}

static void take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    ss_idle_hand *hand = context;
    (void)receive_ns;
    atomic_store(&hand->active_nodes, status->active_nodes);
    atomic_store(&hand->chosen_hz, status->chosen_rate_hz);
    atomic_store(&hand->yardstick, status->yardstick);
    if (ss_clock_now_ns() / 1000 < atomic_load(&hand->rate_from_us)) {
        return;
    }
    atomic_store(&hand->slowest_hz,
                 fmin(atomic_load(&hand->slowest_hz), status->simulation_rate_hz));
    if (status->verdict > atomic_load(&hand->worst_verdict)) {
        atomic_store(&hand->worst_verdict, status->verdict);
    }
}

static void take_delta(void *context, const softsim_mesh_delta *delta)
{
    (void)context;
    (void)delta;
}

/* Once tool and surface are known: the first way from outside that no support blocks. */
static void find_place(ss_idle_hand *hand)
{
    for (int way = WAYS - 1; hand->nodes_left == 0 && hand->radius > 0.0 && way >= 0; --way) {
        if (hand->has_way[way]) {
            axis_of(way, hand->outward);
            ss_copy3(hand->surface, hand->outermost[way]);
            atomic_store(&hand->has_surface, true);
        }
    }
}

static void take_scene(void *context, const softsim_scene_report *scene)
{
    ss_idle_hand *hand = context;
    if (!atomic_load(&hand->has_surface)) {
        hand->radius = scene->size[0][0];
        find_place(hand);
    }
}

static void take_topology(void *context, const softsim_topology_chunk *chunk)
{
    ss_idle_hand *hand = context;
    if (atomic_load(&hand->has_surface)) {
        return;
    }
    hand->nodes_left = chunk->first_node == 0 ? chunk->node_count : hand->nodes_left;
    hand->nodes_left -= chunk->node_chunk;
    for (int32_t i = 0; i < chunk->node_chunk; ++i) {
        const float *rest = chunk->rest + 3 * (size_t)i;
        const double x[3] = {(double)rest[0], (double)rest[1], (double)rest[2]};
        for (int way = 0; way < WAYS; ++way) {
            double axis[3];
            axis_of(way, axis);
            const double reach = ss_dot3(x, axis);
            if (!hand->has_way[way] || reach > hand->reach[way]) {
                hand->reach[way] = reach;
                hand->has_way[way] = (chunk->node_flag[i] & 1) == 0;
                ss_copy3(hand->outermost[way], x);
            }
        }
    }
    find_place(hand);
}

/* ---- sent ---- */

/* Where the tool is to be at `now_ns`: in the air, or on its way in. */
static void aim(ss_idle_hand *hand, ss_idle_way way, int64_t now_ns, double out[3])
{
    const double clear = hand->radius + CLEAR_M;
    ss_madd3(out, hand->surface, clear, hand->outward);
    if (way == SS_IDLE_AIR) {
        const double turn = 2.0 * SS_PI * fmod(1e-9 * (double)now_ns, 1.0);
        const int a = fabs(hand->outward[0]) > 0.5 ? 1 : 0;
        const int b = fabs(hand->outward[2]) > 0.5 ? 1 : 2;
        out[a] += CIRCLE_M * cos(turn);
        out[b] += CIRCLE_M * sin(turn);
        atomic_store(&hand->is_still, false);
    } else if (atomic_load(&hand->is_still) || atomic_load(&hand->force) >= PRESS_N) {
        atomic_store(&hand->is_still, true);
        ss_copy3(out, hand->place);
    } else {
        ss_madd3(out, hand->surface, -DEEPEST_M, hand->outward);
    }
}

static void send_pose(ss_idle_hand *hand, ss_idle_way way, int64_t now_ns)
{
    double to[3], step[3];
    aim(hand, way, now_ns, to);
    if (!hand->has_place) {
        ss_copy3(hand->place, to);
        hand->has_place = true;
    }
    const double most = (way == SS_IDLE_PRESS ? SPEED_M_S : 0.2) * 1e-9 * (double)PERIOD_NS;
    ss_sub3(step, to, hand->place);
    (void)ss_clamp_norm3(step, most);
    ss_add3(hand->place, hand->place, step);
    softsim_pose pose = {.utime_us = now_ns / 1000,
                         .sender = softsim_client_sender(hand->client),
                         .seq = ++hand->seq,
                         .force_seq = -1,
                         .orientation = {1.0, 0.0, 0.0, 0.0}};
    for (int k = 0; k < 3; ++k) {
        pose.position[k] = hand->place[k];
        pose.velocity[k] = pose.applied_force[k] = (double)NAN;
    }
    (void)softsim_client_send_pose(hand->client, &pose, 0);
}

static void *run_hand(void *argument)
{
    ss_idle_hand *hand = argument;
    int64_t due_ns = ss_clock_now_ns();
    while (!atomic_load(&hand->is_ending)) {
        const ss_idle_way way = (ss_idle_way)atomic_load(&hand->way);
        const int64_t now_ns = ss_clock_now_ns();
        const int64_t period_ns = way == SS_IDLE_NONE ? 100 * PERIOD_NS : PERIOD_NS;
        due_ns = now_ns - due_ns > period_ns ? now_ns : due_ns + period_ns;
        if (softsim_client_wait(hand->client, due_ns) < 0) {
            break;
        }
        while (ss_clock_now_ns() < due_ns && softsim_client_wait(hand->client, due_ns) > 0) {
        }
        if (way != SS_IDLE_NONE && atomic_load(&hand->has_surface)) {
            send_pose(hand, way, ss_clock_now_ns());
        }
        if (way == SS_IDLE_NONE && hand->asked_ns == 0) {
            hand->asked_ns = now_ns;
            (void)softsim_client_send_command(hand->client, "refresh", "");
        }
    }
    return NULL;
}

static void *run_bare(void *argument)
{
    ss_idle_hand *hand = argument;
    const int64_t start_ns = ss_clock_now_ns();
    int64_t tick = 0;
    while (!atomic_load(&hand->is_ending)) {
        int64_t skipped = 0;
        (void)ss_clock_next_period(start_ns, PERIOD_NS, &tick, &skipped);
        atomic_store(&hand->bare_cpu_ns, ss_clock_thread_cpu_ns());
    }
    return NULL;
}

/* ---- for main ---- */

softsim_status ss_idle_hand_start(const char *lcm_url, const char *prefix, ss_idle_hand **out_hand,
                                  softsim_error *error)
{
    ss_idle_hand *hand = *out_hand = ss_memory_get(1, sizeof *hand);
    if (hand == NULL) {
        return ss_memory_fault(error);
    }
    hand->nodes_left = -1; /* not known */
    const softsim_client_config config = {.lcm_url = lcm_url,
                                          .prefix = prefix,
                                          .context = hand,
                                          .handle_force = take_force,
                                          .handle_status = take_status,
                                          .handle_scene = take_scene,
                                          .handle_topology = take_topology,
                                          .handle_delta = take_delta,
                                          .handle_raw = count};
    softsim_status status = softsim_client_open(&config, &hand->client, error);
    bool is_refused = false;
    if (status == SOFTSIM_OK) {
        status = ss_thread_start("hand", LOOP_PRIORITY - 20, SS_REALTIME_AUTO, run_hand, hand,
                                 &hand->thread, &is_refused);
    }
    if (status == SOFTSIM_OK) {
        status = ss_thread_start("bare", LOOP_PRIORITY, SS_REALTIME_AUTO, run_bare, hand,
                                 &hand->bare, &is_refused);
    }
    if (status != SOFTSIM_OK) {
        ss_idle_hand_stop(out_hand);
    }
    return status;
}

void ss_idle_hand_go(ss_idle_hand *hand, ss_idle_way way)
{
    atomic_store(&hand->slowest_hz, (double)INFINITY);
    atomic_store(&hand->worst_verdict, 0);
    atomic_store(&hand->rate_from_us, ss_clock_now_ns() / 1000 + RATE_SETTLE_US);
    atomic_store(&hand->way, (int)way);
}

ss_idle_counts ss_idle_hand_read(ss_idle_hand *hand)
{
    return (ss_idle_counts){.bytes = atomic_load(&hand->bytes),
                            .round_bytes = atomic_load(&hand->round_bytes),
                            .bare_cpu_ns = atomic_load(&hand->bare_cpu_ns),
                            .force = atomic_load(&hand->force),
                            .active_nodes = atomic_load(&hand->active_nodes),
                            .chosen_hz = atomic_load(&hand->chosen_hz),
                            .yardstick = atomic_load(&hand->yardstick),
                            .slowest_hz = atomic_load(&hand->slowest_hz),
                            .worst_verdict = atomic_load(&hand->worst_verdict),
                            .has_surface = atomic_load(&hand->has_surface),
                            .is_still = atomic_load(&hand->is_still)};
}

void ss_idle_hand_stop(ss_idle_hand **pointer)
{
    ss_idle_hand *hand = *pointer;
    if (hand == NULL) {
        return;
    }
    atomic_store(&hand->is_ending, true);
    ss_thread_join(&hand->thread);
    ss_thread_join(&hand->bare);
    softsim_client_close(&hand->client);
    ss_memory_free(hand);
    *pointer = NULL;
}
