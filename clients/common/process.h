/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the client programs ask of the system, and say in the same words. */
#include <pthread.h>
#include <stdbool.h>

/* From here on SIGINT, SIGTERM and SIGHUP ask the program to end by itself. Thread: main, at start.
 */
void ss_process_catch_stop(void);
/* Has the program been asked to end? Thread: any; RT-safe. */
bool ss_process_is_stopped(void);

/* Moves the calling thread to SCHED_FIFO; false where that is not allowed. */
bool ss_process_raise_priority(void);
/* Whom such a thread waits for at this lock goes on at its priority. */
void ss_process_init_lock(pthread_mutex_t *lock);

/* Tells stderr, once and when it has room, that two servers answer. Returns whether they ever did.
 */
bool ss_process_tell_two(const char *program, const char *consequence, bool are_two);
