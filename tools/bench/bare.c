/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Three threads. The loop has the priority of the server's haptic thread and counts its periods in
 * the same way: the absolute clock, whole periods that are over are skipped, and a wake-up more
 * than one period late is a missed period. The sender has a client's priority and sends a message
 * as long as an encoded pose every millisecond; the echoer has the server's net priority and sends
 * back one as long as a force. The first threads of LCM inherit these classes, so each end is
 * opened on its own thread.
 */
#include "bare.h"

#include <lcm/lcm.h>
#include <poll.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "rt/clock.h"
#include "rt/thread.h"
#include "wire.h"

enum { LOOP_PRIORITY = 80, ECHO_PRIORITY = 78, SEND_PRIORITY = 60, CHANNEL_SIZE = 64 };
static const int64_t look_ns = 100000000; /* between looks at the end */

typedef struct echo_end {
    lcm_t *lcm;
    lcm_subscription_t *subscription;
    atomic_int state; /* 0 opening, 1 open, -1 failed */
} echo_end;

struct ss_bare {
    /* parameters */
    const char *lcm_url;
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

/* ---- the loop ----------------------------------------------------------------------------------
 */

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

/* ---- the echo ----------------------------------------------------------------------------------
 */

static void handle_sent(const lcm_recv_buf_t *received, const char *channel, void *context)
{
    ss_bare *bare = context;
    uint8_t answer[SS_WIRE_FORCE_SIZE] = {0};
    (void)channel;
    if (received->data_size == SS_WIRE_POSE_SIZE) {
        memcpy(answer, received->data, sizeof(int64_t));
        lcm_publish(bare->echo_end.lcm, bare->back_channel, answer, sizeof answer);
    }
}

static void handle_back(const lcm_recv_buf_t *received, const char *channel, void *context)
{
    ss_bare *bare = context;
    int64_t sent_ns = 0;
    (void)channel;
    if (received->data_size == SS_WIRE_FORCE_SIZE) {
        memcpy(&sent_ns, received->data, sizeof sent_ns);
        ss_samples_add(&bare->echo_us, 1e-3 * (double)(ss_clock_now_ns() - sent_ns));
    }
}

static void open_end(ss_bare *bare, echo_end *end, const char *channel, lcm_msg_handler_t handler)
{
    end->lcm = lcm_create(bare->lcm_url);
    end->subscription = end->lcm != NULL ? lcm_subscribe(end->lcm, channel, handler, bare) : NULL;
    if (end->subscription != NULL) {
        lcm_subscription_set_queue_capacity(end->subscription, 4096);
    }
    atomic_store_explicit(&end->state, end->subscription != NULL ? 1 : -1, memory_order_release);
}

static void close_end(echo_end *end)
{
    if (end->subscription != NULL) {
        lcm_unsubscribe(end->lcm, end->subscription);
    }
    if (end->lcm != NULL) {
        lcm_destroy(end->lcm);
    }
}

/* Handles what comes until `deadline_ns`. */
static void handle_until(lcm_t *lcm, int64_t deadline_ns)
{
    for (;;) {
        const int64_t left_ns = deadline_ns - ss_clock_now_ns();
        if (left_ns <= 0) {
            return;
        }
        struct pollfd wait = {.fd = lcm_get_fileno(lcm), .events = POLLIN};
        const struct timespec timeout = {.tv_sec = left_ns / 1000000000,
                                         .tv_nsec = left_ns % 1000000000};
        if (ppoll(&wait, 1, &timeout, NULL) > 0 && lcm_handle(lcm) < 0) {
            return;
        }
    }
}

static void *echo_body(void *argument)
{
    ss_bare *bare = argument;
    open_end(bare, &bare->echo_end, bare->out_channel, handle_sent);
    while (bare->echo_end.subscription != NULL &&
           !atomic_load_explicit(&bare->is_sending_over, memory_order_acquire)) {
        handle_until(bare->echo_end.lcm, ss_clock_now_ns() + look_ns);
    }
    close_end(&bare->echo_end);
    return NULL;
}

static void *send_body(void *argument)
{
    ss_bare *bare = argument;
    uint8_t message[SS_WIRE_POSE_SIZE] = {0};
    open_end(bare, &bare->send_end, bare->back_channel, handle_back);
    int64_t due_ns = ss_clock_now_ns();
    while (bare->send_end.subscription != NULL &&
           !atomic_load_explicit(&bare->is_ending, memory_order_acquire)) {
        int64_t skipped = 0;
        due_ns = next_due(due_ns, &skipped);
        handle_until(bare->send_end.lcm, due_ns);
        if (atomic_load_explicit(&bare->echo_end.state, memory_order_acquire) != 1) {
            continue; /* nobody there yet */
        }
        const int64_t now_ns = ss_clock_now_ns();
        memcpy(message, &now_ns, sizeof now_ns);
        bare->echo_sent +=
            lcm_publish(bare->send_end.lcm, bare->out_channel, message, sizeof message) == 0;
    }
    if (bare->send_end.subscription != NULL) {
        handle_until(bare->send_end.lcm, ss_clock_now_ns() + look_ns); /* the last ones */
    }
    close_end(&bare->send_end);
    return NULL;
}

/* ---- main thread -------------------------------------------------------------------------------
 */

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
        ss_clock_sleep_until(ss_clock_now_ns() + 1000000); /* LCM itself gives up after 10 s */
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
    bare->is_fifo = true;
    snprintf(bare->out_channel, sizeof bare->out_channel, "%.48s_ECHO", prefix);
    snprintf(bare->back_channel, sizeof bare->back_channel, "%.48s_ECHO_BACK", prefix);
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
