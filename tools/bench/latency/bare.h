/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the machine can do without softsim, measured while softsim runs: a 1 kHz loop that does
 * nothing, and a message sent over LCM and sent back. What the server is late beyond these is its
 * own; the rest is the machine's.
 * Thread: start and stop by main; the loops have threads of their own.
 */
#include <stdbool.h>
#include <stdint.h>

#include "case/samples.h"
#include "softsim/types.h"

enum { SS_BARE_PERIOD_NS = 1000000 };

typedef struct ss_bare_tick {
    int64_t due_ns;
    double late_us;
} ss_bare_tick;

typedef struct ss_bare ss_bare;

/* What was measured; valid until ss_bare_free. */
typedef struct ss_bare_result {
    const ss_bare_tick *tick;
    int64_t tick_count;
    int64_t periods, missed; /* missed: woken more than a period late, or not at all */
    ss_samples *echo_us;     /* round trips */
    int64_t echo_sent;
    bool is_fifo; /* SCHED_FIFO was allowed */
} ss_bare_result;

/* Room for `seconds`, and both LCM ends on `prefix`_ECHO and `prefix`_ECHO_BACK, open; starts. */
softsim_status ss_bare_start(const char *lcm_url, const char *prefix, double seconds,
                             ss_bare **out_bare, softsim_error *error);
/* Ends the threads and fills `out_result`. */
void ss_bare_stop(ss_bare *bare, ss_bare_result *out_result);
/* Stops where needed; accepts NULL; nulls. */
void ss_bare_free(ss_bare **bare);
