/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Threads, and the real-time rule.
 *
 * In the simulation and haptic loops: no allocation or free, no lock or condition, no file,
 * socket, LCM or print, no unbounded loop, no page fault (memory locked and touched), no
 * denormals (mode set at thread start), no first-use initialisation, no call of a function that
 * is not marked RT-safe. Exchange only through mailbox.h and ring.h. Late is recorded, never
 * caught up by running twice. The exceptions: ss_clock_sleep_until; ss_wake_signal (an eventfd
 * write) by which the haptic loop wakes the net thread, and a simulation that sleeps; and
 * ss_wake_wait, in which a loop waits that has nothing to do.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef enum ss_realtime { SS_REALTIME_AUTO, SS_REALTIME_FIFO, SS_REALTIME_OFF } ss_realtime;

typedef struct ss_thread ss_thread;

/* Starts `body(argument)` with flush-to-zero set. `fifo_priority` 0 means the ordinary scheduler.
 * With SS_REALTIME_AUTO a refused SCHED_FIFO falls back to the ordinary scheduler and sets
 * *out_fifo_refused; with SS_REALTIME_FIFO it is SOFTSIM_ERROR_SYSTEM. Thread: set-up only. */
softsim_status ss_thread_start(const char *name, int fifo_priority, ss_realtime realtime,
                               void *(*body)(void *), void *argument, ss_thread **out_thread,
                               bool *out_fifo_refused);
/* Joins and frees; nulls; accepts NULL. Thread: set-up only. */
void ss_thread_join(ss_thread **thread);

/* Locks all memory of the process; false where not allowed. Thread: set-up only. */
bool ss_thread_lock_memory(void);
/* Flush-to-zero and denormals-are-zero for the calling thread; every thread that runs a kernel
 * calls it (headless runs too, so that results agree). Returns what was set before, for a thread
 * that is not ours to be given back as it was. RT-safe. */
uint64_t ss_thread_flush_denormals(void);
void ss_thread_restore_denormals(uint64_t before);

/* An eventfd: signal from any thread (one write, RT loops' named exception), wait by poll(fd). */
int ss_wake_open(void); /* -1 on failure */
void ss_wake_signal(int fd);
void ss_wake_drain(int fd);
/* Until it is signalled, or the monotonic clock reads `deadline_ns`; drains it. */
void ss_wake_wait(int fd, int64_t deadline_ns);
