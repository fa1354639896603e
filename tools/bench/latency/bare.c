/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Three threads. The loop has the priority of the server's haptic thread and counts its periods in
 * the same way: the absolute clock, whole periods that are over are skipped, and a wake-up more
 * than one period late is a missed period. The sender has a client's priority and sends a message
 * as long as an encoded pose every millisecond; the echoer has the server's net priority and sends
 * back one as long as a force. Both send by LCM and receive as our programs do (net/receiver.h), so
 * that what the chain adds is judged against its own transport, and no fragment crashes it.
 */
#include "bench/latency/bare.h"

#include <lcm/lcm.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "net/codec.h"
#include "net/receiver.h"
#include "net/wire.h"
#include "rt/clock.h"
#include "rt/thread.h"

enum { LOOP_PRIORITY = 80, ECHO_PRIORITY = 78, SEND_PRIORITY = 60, CHANNEL_SIZE = 64 };
static const char out_suffix[] = "_ECHO", back_suffix[] = "_ECHO_BACK";
static const int64_t look_ns = 100000000; /* between looks at the end */

typedef struct echo_end {
    lcm_t *lcm;
    ss_receiver *receiver;
    atomic_int state; /* 0 opening, 1 open, -1 failed */
} echo_end;

struct ss_bare {
    /* parameters */
    const char *lcm_url, *prefix;
    char out_channel[CHANNEL_SIZE], back_channel[CHANNEL_SIZE];
    int64_t tick_capacity;
    /* state */
    ss_thread *loop, *sender, *echoer;
    atomic_bool is_ending, is_sending_over;
    bool is_fifo;
    echo_end send_end, echo_end;
    /* loop thread */
    ss_bare_tick *tick;
    int64_t tick_count, periods, missed;
    /* send thread */
    ss_samples echo_us;
    int64_t echo_sent;
};

/* ---- the loop ---- */

/* The next period that is not over; counts the ones that are. */
static int64_t next_due(int64_t due_ns, int64_t *out_skipped)
{
    const int64_t now_ns = ss_clock_now_ns();
    due_ns += SS_BARE_PERIOD_NS;
    *out_skipped = now_ns - due_ns >= SS_BARE_PERIOD_NS ? (now_ns - due_ns) / SS_BARE_PERIOD_NS : 0;
    return due_ns + *out_skipped * SS_BARE_PERIOD_NS;
}

static void *loop_body(void *argument)
{
    ss_bare *bare = argument;
    int64_t due_ns = ss_clock_now_ns();
    while (!atomic_load_explicit(&bare->is_ending, memory_order_acquire) &&
           bare->tick_count < bare->tick_capacity) {
        int64_t skipped = 0;
        due_ns = next_due(due_ns, &skipped);
        ss_clock_sleep_until(due_ns);
        const int64_t late_ns = ss_clock_now_ns() - due_ns;
        bare->tick[bare->tick_count++] = (ss_bare_tick){due_ns, 1e-3 * (double)late_ns};
        bare->periods += skipped + 1;
        bare->missed += skipped + (late_ns > SS_BARE_PERIOD_NS);
    }
    return NULL;
}

/* ---- the echo ---- */

static void handle_sent(void *context, const ss_packet *packet)
{
    ss_bare *bare = context;
    uint8_t answer[SS_WIRE_FORCE_SIZE] = {0};
    if (packet->size == SS_WIRE_POSE_SIZE) {
        memcpy(answer, packet->data, sizeof(int64_t));
        lcm_publish(bare->echo_end.lcm, bare->back_channel, answer, sizeof answer);
    }
}

static void handle_back(void *context, const ss_packet *packet)
{
    ss_bare *bare = context;
    int64_t sent_ns = 0;
    if (packet->size == SS_WIRE_FORCE_SIZE) {
        memcpy(&sent_ns, packet->data, sizeof sent_ns);
        ss_samples_add(&bare->echo_us, 1e-3 * (double)(ss_clock_now_ns() - sent_ns));
    }
}

static void open_end(ss_bare *bare, echo_end *end, const char *suffix,
                     void (*receive)(void *context, const ss_packet *packet))
{
    const ss_lane lane = {.suffix = {suffix},
                          .max_size = 2 * SS_WIRE_FORCE_SIZE,
                          .buffer = 212992, /* as the server's */
                          .per_ms = 100,
                          .burst = 4096,
                          .receive = receive};
    softsim_error error = {.status = SOFTSIM_OK};
    end->lcm = ss_wire_open(bare->lcm_url, &error);
    const ss_receiver_config config = {.lcm_url = bare->lcm_url,
                                       .lcm = end->lcm,
                                       .prefix = bare->prefix,
                                       .lane = &lane,
                                       .lane_count = 1,
                                       .context = bare};
    const bool is_open =
        end->lcm != NULL && ss_receiver_open(&config, &end->receiver, &error) == SOFTSIM_OK;
    atomic_store_explicit(&end->state, is_open ? 1 : -1, memory_order_release);
}

static void close_end(echo_end *end)
{
    ss_receiver_close(&end->receiver);
    if (end->lcm != NULL) {
        lcm_destroy(end->lcm);
    }
}

/* Handles what comes until `deadline_ns`. */
static void handle_until(ss_receiver *receiver, int64_t deadline_ns)
{
    while (ss_clock_now_ns() < deadline_ns && ss_receiver_wait(receiver, -1, deadline_ns) >= 0) {
    }
}

static void *echo_body(void *argument)
{
    ss_bare *bare = argument;
    open_end(bare, &bare->echo_end, out_suffix, handle_sent);
    while (bare->echo_end.receiver != NULL &&
           !atomic_load_explicit(&bare->is_sending_over, memory_order_acquire)) {
        handle_until(bare->echo_end.receiver, ss_clock_now_ns() + look_ns);
    }
    close_end(&bare->echo_end);
    return NULL;
}

static void *send_body(void *argument)
{
    ss_bare *bare = argument;
    uint8_t message[SS_WIRE_POSE_SIZE] = {0};
    open_end(bare, &bare->send_end, back_suffix, handle_back);
    int64_t due_ns = ss_clock_now_ns();
    while (bare->send_end.receiver != NULL &&
           !atomic_load_explicit(&bare->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        due_ns = next_due(due_ns, &skipped);
        handle_until(bare->send_end.receiver, due_ns);
        if (atomic_load_explicit(&bare->echo_end.state, memory_order_acquire) != 1) {
            continue; /* nobody there yet */
        }
        const int64_t now_ns = ss_clock_now_ns();
        memcpy(message, &now_ns, sizeof now_ns);
        bare->echo_sent +=
            lcm_publish(bare->send_end.lcm, bare->out_channel, message, sizeof message) == 0;
    }
    if (bare->send_end.receiver != NULL) {
        handle_until(bare->send_end.receiver, ss_clock_now_ns() + look_ns); /* the last ones */
    }
    close_end(&bare->send_end);
    return NULL;
}

/* ---- main thread ---- */

static void end_threads(ss_bare *bare)
{
    atomic_store_explicit(&bare->is_ending, true, memory_order_release);
    ss_thread_join(&bare->loop);
    ss_thread_join(&bare->sender);
    atomic_store_explicit(&bare->is_sending_over, true, memory_order_release);
    ss_thread_join(&bare->echoer);
}

static softsim_status start_thread(ss_bare *bare, const char *name, int priority,
                                   void *(*body)(void *), ss_thread **out_thread)
{
    bool is_refused = false;
    const softsim_status status =
        ss_thread_start(name, priority, SS_REALTIME_AUTO, body, bare, out_thread, &is_refused);
    bare->is_fifo = bare->is_fifo && !is_refused;
    return status;
}

static bool wait_for_ends(ss_bare *bare)
{
    for (;;) {
        const int sender = atomic_load_explicit(&bare->send_end.state, memory_order_acquire);
        const int echoer = atomic_load_explicit(&bare->echo_end.state, memory_order_acquire);
        if (sender < 0 || echoer < 0) {
            return false;
        }
        if (sender > 0 && echoer > 0) {
            return true;
        }
        ss_clock_sleep_until(ss_clock_now_ns() + 1000000); /* opening gives up after 10 s */
    }
}

softsim_status ss_bare_start(const char *lcm_url, const char *prefix, double seconds,
                             ss_bare **out_bare, softsim_error *error)
{
    ss_bare *bare = *out_bare = calloc(1, sizeof *bare);
    const int64_t capacity = (int64_t)(1e3 * (seconds + 30.0));
    if (bare != NULL) {
        bare->tick = calloc((size_t)capacity, sizeof *bare->tick);
    }
    if (bare == NULL || bare->tick == NULL || !ss_samples_init(&bare->echo_us, capacity)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no memory for %.0f s of samples", seconds);
        return SOFTSIM_ERROR_MEMORY;
    }
    memset(bare->tick, 0xff, (size_t)capacity * sizeof *bare->tick); /* touched: no page faults */
    bare->tick_capacity = capacity;
    bare->lcm_url = lcm_url;
    bare->prefix = prefix;
    bare->is_fifo = true;
    snprintf(bare->out_channel, sizeof bare->out_channel, "%.40s%s", prefix, out_suffix);
    snprintf(bare->back_channel, sizeof bare->back_channel, "%.40s%s", prefix, back_suffix);
    softsim_status status =
        start_thread(bare, "bare-echo", ECHO_PRIORITY, echo_body, &bare->echoer);
    if (status == SOFTSIM_OK) {
        status = start_thread(bare, "bare-send", SEND_PRIORITY, send_body, &bare->sender);
    }
    if (status == SOFTSIM_OK && !wait_for_ends(bare)) {
        status = SOFTSIM_ERROR_NETWORK;
    }
    if (status == SOFTSIM_OK) {
        status = start_thread(bare, "bare-loop", LOOP_PRIORITY, loop_body, &bare->loop);
    }
    if (status != SOFTSIM_OK) {
        softsim_error_add(error, status, "the bare echo or loop: %s", softsim_status_text(status));
    }
    return status;
}

void ss_bare_stop(ss_bare *bare, ss_bare_result *out_result)
{
    end_threads(bare);
    *out_result = (ss_bare_result){.tick = bare->tick,
                                   .tick_count = bare->tick_count,
                                   .periods = bare->periods,
                                   .missed = bare->missed,
                                   .echo_us = &bare->echo_us,
                                   .echo_sent = bare->echo_sent,
                                   .is_fifo = bare->is_fifo};
}

void ss_bare_free(ss_bare **bare_pointer)
{
    ss_bare *bare = *bare_pointer;
    if (bare == NULL) {
        return;
    }
    end_threads(bare);
    ss_samples_fini(&bare->echo_us);
    free(bare->tick);
    free(bare);
    *bare_pointer = NULL;
}
