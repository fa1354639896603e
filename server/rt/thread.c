/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Threads by pthread, with the scheduling class given explicitly: inherited classes would make a
 * thread's priority depend on who started it. The stack is small and touched at start, so that
 * locking all memory costs little and no loop faults on its stack.
 */
#include "rt/thread.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <unistd.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "rt/clock.h"
#include "rt/memory.h"

enum {
    STACK_BYTES = 2 * 1024 * 1024, /* locked as a whole by mlockall */
    TOUCH_BYTES = 256 * 1024,      /* more than any loop uses */
    PAGE_BYTES = 4096,
    NAME_SIZE = 16 /* the kernel's limit, with the NUL */
};

struct ss_thread {
    pthread_t handle;
    void *(*body)(void *);
    void *argument;
    char name[NAME_SIZE];
};

#if defined(__SSE__)
#define FLUSH_BITS UINT64_C(0x8040) /* FTZ (bit 15) and DAZ (bit 6) */
#else
#define FLUSH_BITS (UINT64_C(1) << 24) /* FZ of FPCR: flushes inputs and results */
#endif

static uint64_t read_mode(void)
{
    uint64_t mode = 0;
#if defined(__SSE__)
    mode = _mm_getcsr();
#elif defined(__aarch64__)
    __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
#endif
    return mode;
}

static void write_mode(uint64_t mode)
{
#if defined(__SSE__)
    _mm_setcsr((uint32_t)mode);
#elif defined(__aarch64__)
    __asm__ volatile("msr fpcr, %0" : : "r"(mode));
#else
    (void)mode;
#endif
}

uint64_t ss_thread_flush_denormals(void)
{
    const uint64_t mode = read_mode();
    write_mode(mode | FLUSH_BITS);
    return mode & FLUSH_BITS;
}

void ss_thread_restore_denormals(uint64_t before)
{
    write_mode((read_mode() & ~FLUSH_BITS) | before);
}

/* Not inlined: the touched frame must be below the body's, and gone again before it runs. */
__attribute__((noinline)) static void touch_stack(void)
{
    volatile char frame[TOUCH_BYTES];
    for (int i = 0; i < TOUCH_BYTES; i += PAGE_BYTES) {
        frame[i] = 0;
    }
    (void)frame[0];
}

static void *run(void *argument)
{
    const ss_thread *thread = argument;
    pthread_setname_np(pthread_self(), thread->name);
    touch_stack();
    ss_thread_flush_denormals();
    void *result = thread->body(thread->argument);
    /* The loop is over and with it the real-time rule; who watches a thread by name can tell. */
    pthread_setname_np(pthread_self(), "ended");
    return result;
}

/* An errno value, 0 when started. */
static int create_thread(ss_thread *thread, int policy, int priority)
{
    pthread_attr_t attributes;
    int result = pthread_attr_init(&attributes);
    if (result != 0) {
        return result;
    }
    const struct sched_param param = {.sched_priority = priority};
    result = pthread_attr_setstacksize(&attributes, STACK_BYTES);
    if (result == 0) {
        result = pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
    }
    if (result == 0) {
        result = pthread_attr_setschedpolicy(&attributes, policy);
    }
    if (result == 0) {
        result = pthread_attr_setschedparam(&attributes, &param);
    }
    if (result == 0) {
        result = pthread_create(&thread->handle, &attributes, run, thread);
    }
    pthread_attr_destroy(&attributes);
    return result;
}

softsim_status ss_thread_start(const char *name, int fifo_priority, ss_realtime realtime,
                               void *(*body)(void *), void *argument, ss_thread **out_thread,
                               bool *out_fifo_refused)
{
    *out_thread = NULL;
    *out_fifo_refused = false;
    ss_thread *thread = ss_memory_get(1, sizeof *thread);
    if (thread == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    thread->body = body;
    thread->argument = argument;
    snprintf(thread->name, sizeof thread->name, "%s", name);

    int result = EPERM;
    const bool wants_fifo = fifo_priority > 0 && realtime != SS_REALTIME_OFF;
    if (wants_fifo) {
        result = create_thread(thread, SCHED_FIFO, fifo_priority);
        *out_fifo_refused = result != 0;
    }
    if (!wants_fifo || (result != 0 && realtime == SS_REALTIME_AUTO)) {
        result = create_thread(thread, SCHED_OTHER, 0);
    }
    if (result != 0) {
        ss_memory_free(thread);
        return SOFTSIM_ERROR_SYSTEM;
    }
    *out_thread = thread;
    return SOFTSIM_OK;
}

void ss_thread_join(ss_thread **thread)
{
    if (*thread == NULL) {
        return;
    }
    pthread_join((*thread)->handle, NULL);
    ss_memory_free(*thread);
    *thread = NULL;
}

bool ss_thread_lock_memory(void)
{
    return mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

int ss_wake_open(void)
{
    return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

void ss_wake_signal(int fd)
{
    /* The only failure is a full counter (2^64 - 2 signals): the waiter is awake then anyway. */
    const uint64_t one = 1;
    const ssize_t written = write(fd, &one, sizeof one);
    (void)written;
}

void ss_wake_drain(int fd)
{
    uint64_t count = 0; /* one read resets the counter; EAGAIN when there was no signal */
    const ssize_t taken = read(fd, &count, sizeof count);
    (void)taken;
}

void ss_wake_wait(int fd, int64_t deadline_ns)
{
    struct pollfd wait = {.fd = fd, .events = POLLIN};
    const int64_t left_ns = deadline_ns - ss_clock_now_ns();
    if (left_ns > 0) {
        const struct timespec timeout = {.tv_sec = left_ns / 1000000000,
                                         .tv_nsec = left_ns % 1000000000};
        (void)ppoll(&wait, 1, &timeout, NULL); /* a signal wakes it early, which does no harm */
    }
    ss_wake_drain(fd);
}
