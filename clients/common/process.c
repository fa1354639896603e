/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "process.h"

#include <sched.h>
#include <signal.h>
#include <stdio.h>

#include "rt/program.h"

/* Below the server's threads, above everything ordinary. */
static const int client_priority = 60;

static volatile sig_atomic_t is_stopped;

static void note_stop(int signal_number)
{
    (void)signal_number;
    is_stopped = 1;
}

void ss_process_catch_stop(void)
{
    struct sigaction action = {.sa_handler = note_stop}; /* no SA_RESTART: waits end */
    sigset_t stops;
    ss_program_stop_signals(&stops);
    sigemptyset(&action.sa_mask);
    for (int number = 1; number < SIGRTMIN; ++number) {
        if (sigismember(&stops, number) == 1) {
            sigaction(number, &action, NULL);
        }
    }
}

bool ss_process_is_stopped(void)
{
    return is_stopped != 0;
}

bool ss_process_raise_priority(void)
{
    const struct sched_param parameter = {.sched_priority = client_priority};
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0;
}

void ss_process_init_lock(pthread_mutex_t *lock)
{
    pthread_mutexattr_t inherits;
    pthread_mutexattr_init(&inherits);
    pthread_mutexattr_setprotocol(&inherits, PTHREAD_PRIO_INHERIT);
    pthread_mutex_init(lock, &inherits);
    pthread_mutexattr_destroy(&inherits);
}

bool ss_process_tell_two(const char *program, const char *consequence, bool are_two)
{
    static bool is_heard, is_told;
    is_heard = is_heard || are_two;
    if (is_heard && !is_told && ss_program_can_tell()) {
        fprintf(stderr,
                "%s: two servers answer on this prefix: %s; stop one of them, or give it another "
                "--prefix\n",
                program, consequence);
        is_told = true;
    }
    return is_heard;
}
