/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The monotonic clock, the thread's CPU clock, and absolute sleeping. */
#include <stdint.h>

/* Thread: any; RT-safe. */
int64_t ss_clock_now_ns(void);
int64_t ss_clock_thread_cpu_ns(void);

/* Sleeps until the monotonic clock reads `deadline_ns`; restarts after signals. Thread: any; the
 * one system call that a periodic loop makes. */
void ss_clock_sleep_until(int64_t deadline_ns);

/* Sleeps until period `*tick` + 1, counted from `start_ns`, is due; skips the periods that are
 * already over. Returns the due time and counts the skipped ones. Thread: as above. */
int64_t ss_clock_next_period(int64_t start_ns, int64_t period_ns, int64_t *tick,
                             int64_t *out_skipped);
