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
