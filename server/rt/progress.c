/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/progress.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "rt/clock.h"
#include "rt/plain.h"
#include "rt/program.h"

static const int64_t terminal_ns = 1000000000, plain_ns = 10000000000, redraw_ns = 100000000;

/* Of the process, as its stderr is: a library that reads a file says what it is at without knowing
 * who asked. All of it under `lock`. */
static struct {
    pthread_mutex_t lock;
    pthread_cond_t changed; /* on the monotonic clock */
    bool has_begun, has_stage, is_ending, is_terminal;
    char program[32], stage[160];
    int descriptor;
    int64_t begun_ns, shown_ns;
    pthread_t thread;
} progress = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* stderr, opened once more where that is a pipe or a terminal, so that writing to it does not wait
 * and those who share it go on as they were. */
static int open_stderr(void)
{
    struct stat found;
    int own = -1;
    if (fstat(STDERR_FILENO, &found) == 0 && (S_ISFIFO(found.st_mode) || S_ISCHR(found.st_mode))) {
        own = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    }
    return own >= 0 ? own : fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO);
}

/* Under the lock, for which the work itself may wait: what finds no room is left out. */
static void put(const char *text)
{
    if (ss_program_can_tell()) {
        const ssize_t written = write(progress.descriptor, text, strlen(text));
        (void)written;
    }
}

/* Under the lock. */
static void show(void)
{
    char line[256];
    const int64_t now_ns = ss_clock_now_ns();
    const double s = 1e-9 * (double)(now_ns - progress.begun_ns);
    progress.shown_ns = now_ns;
    (void)snprintf(line, sizeof line,
                   progress.is_terminal ? "\r%s: %s, %.0f s \033[K" : "%s: %s, %.0f s\n",
                   progress.program, progress.stage, s);
    put(line);
}

static void *watch(void *unused)
{
    pthread_mutex_lock(&progress.lock);
    while (!progress.is_ending) {
        const int64_t period_ns = progress.is_terminal ? terminal_ns : plain_ns;
        const int64_t due_ns = progress.shown_ns + period_ns;
        const struct timespec due = {.tv_sec = (time_t)(due_ns / 1000000000),
                                     .tv_nsec = (long)(due_ns % 1000000000)};
        pthread_cond_timedwait(&progress.changed, &progress.lock, &due);
        if (!progress.is_ending && ss_clock_now_ns() - progress.shown_ns >= period_ns) {
            show();
        }
    }
    pthread_mutex_unlock(&progress.lock);
    return unused;
}

void ss_progress_begin(const char *program, const char *format, ...)
{
    ss_progress_end();
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(progress.stage, sizeof progress.stage, format, arguments);
    va_end(arguments);
    ss_plain_clean(progress.stage);
    snprintf(progress.program, sizeof progress.program, "%s", program);
    progress.is_terminal = isatty(STDERR_FILENO) == 1;
    progress.is_ending = progress.has_stage = false;
    progress.descriptor = open_stderr();
    progress.begun_ns = progress.shown_ns = ss_clock_now_ns();
    if (progress.is_terminal) {
        show();
    }
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_cond_init(&progress.changed, &clock);
    pthread_condattr_destroy(&clock);
    sigset_t all, before; /* signals are the main thread's */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    progress.has_begun = pthread_create(&progress.thread, NULL, watch, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!progress.has_begun) {
        close(progress.descriptor);
    }
}

static void name_stage(bool is_part, const char *format, va_list arguments)
{
    if (!progress.has_begun || (is_part && progress.has_stage)) {
        return;
    }
    pthread_mutex_lock(&progress.lock);
    progress.has_stage = !is_part;
    vsnprintf(progress.stage, sizeof progress.stage, format, arguments);
    ss_plain_clean(progress.stage);
    if (progress.is_terminal && ss_clock_now_ns() - progress.shown_ns >= redraw_ns) {
        show();
    }
    pthread_mutex_unlock(&progress.lock);
}

void ss_progress_stage(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    name_stage(false, format, arguments);
    va_end(arguments);
}

void ss_progress_part(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    name_stage(true, format, arguments);
    va_end(arguments);
}

void ss_progress_end(void)
{
    if (!progress.has_begun) {
        return;
    }
    pthread_mutex_lock(&progress.lock);
    progress.is_ending = true;
    pthread_cond_signal(&progress.changed);
    pthread_mutex_unlock(&progress.lock);
    pthread_join(progress.thread, NULL);
    pthread_cond_destroy(&progress.changed);
    if (progress.is_terminal) {
        put("\r\033[K");
    }
    close(progress.descriptor);
    progress.has_begun = false;
}
