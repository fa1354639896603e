/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * CLOCK_MONOTONIC throughout: it never steps, and clock_nanosleep can wait for an absolute time on
 * it, so that a periodic loop does not drift by the time its body takes.
 */
#include "rt/clock.h"

#include <errno.h>
#include <time.h>

enum { NS_PER_S = 1000000000 };

static int64_t read_ns(clockid_t clock)
{
    struct timespec now = {0, 0};
    clock_gettime(clock, &now); /* cannot fail for the two clocks used here */
    return (int64_t)now.tv_sec * NS_PER_S + now.tv_nsec;
}

int64_t ss_clock_now_ns(void)
{
    return read_ns(CLOCK_MONOTONIC);
}

int64_t ss_clock_thread_cpu_ns(void)
{
    return read_ns(CLOCK_THREAD_CPUTIME_ID);
}

void ss_clock_sleep_until(int64_t deadline_ns)
{
    const int64_t at = deadline_ns > 0 ? deadline_ns : 0;
    const struct timespec deadline = {.tv_sec = (time_t)(at / NS_PER_S),
                                      .tv_nsec = (long)(at % NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, NULL) == EINTR) {
    }
}

int64_t ss_clock_next_period(int64_t start_ns, int64_t period_ns, int64_t *tick,
                             int64_t *out_skipped)
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
