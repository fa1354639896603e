/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Preloaded into softsimd by the real-time test: counts what the real-time rule forbids, on the
 * threads named `simulation` and `haptic`, and writes the counts to $RT_GUARD_REPORT at exit.
 * Allowed by name: clock_nanosleep, and writes of eight bytes (the eventfd that wakes the net
 * thread). Exit handlers run on the main thread, so the report is complete when the loops ended.
 */
#include <dlfcn.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

enum { CALLS = 24 };
static const char *const names[CALLS] = {
    "malloc", "calloc",  "realloc",    "free",      "posix_memalign", "aligned_alloc",
    "mmap",   "munmap",  "mutex_lock", "cond_wait", "cond_signal",    "rwlock",
    "write",  "send",    "sendto",     "sendmsg",   "open",           "fopen",
    "printf", "fprintf", "puts",       "fwrite",    "vfprintf",       "cond_broadcast"};
static atomic_long counts[CALLS];
static atomic_long seen_threads; /* bit 0 simulation, bit 1 haptic */

void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void __libc_free(void *);
void *__libc_memalign(size_t, size_t);

/* The thread's name is asked at each call: it is set after the thread's first calls. */
static int is_realtime_thread(void)
{
    char name[16] = "";
    prctl(PR_GET_NAME, name, 0, 0, 0);
    if (strcmp(name, "simulation") == 0) {
        atomic_fetch_or(&seen_threads, 1);
        return 1;
    }
    if (strcmp(name, "haptic") == 0) {
        atomic_fetch_or(&seen_threads, 2);
        return 1;
    }
    return 0;
}

static void count(int call)
{
    if (is_realtime_thread()) {
        atomic_fetch_add(&counts[call], 1);
    }
}

void *malloc(size_t size)
{
    count(0);
    return __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    count(1);
    return __libc_calloc(n, size);
}

void *realloc(void *memory, size_t size)
{
    count(2);
    return __libc_realloc(memory, size);
}

void free(void *memory)
{
    count(3);
    __libc_free(memory);
}

int posix_memalign(void **out, size_t alignment, size_t size)
{
    count(4);
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : 12;
}

void *aligned_alloc(size_t alignment, size_t size)
{
    count(5);
    return __libc_memalign(alignment, size);
}

#define NEXT(type, name) ((type)dlsym(RTLD_NEXT, name))
/* A function of the library, counted and handed on. */
#define COUNTED(number, result, name, parameters, arguments)                                       \
    result name parameters                                                                         \
    {                                                                                              \
        static result(*next) parameters;                                                           \
        count(number);                                                                             \
        next = next ? next : NEXT(result(*) parameters, #name);                                    \
        return next arguments;                                                                     \
    }
COUNTED(6, void *, mmap, (void *at, size_t size, int protection, int flags, int fd, off_t offset),
        (at, size, protection, flags, fd, offset))
COUNTED(7, int, munmap, (void *at, size_t size), (at, size))
COUNTED(8, int, pthread_mutex_lock, (pthread_mutex_t * mutex), (mutex))
COUNTED(9, int, pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t *mutex),
        (condition, mutex))
COUNTED(10, int, pthread_cond_signal, (pthread_cond_t * condition), (condition))
COUNTED(23, int, pthread_cond_broadcast, (pthread_cond_t * condition), (condition))

ssize_t write(int fd, const void *data, size_t size)
{
    static ssize_t (*next)(int, const void *, size_t);
    if (size != 8) {
        count(12);
    }
    next = next ? next : NEXT(ssize_t(*)(int, const void *, size_t), "write");
    return next(fd, data, size);
}

/* Allowed; every loop calls it, so it shows that the guard saw the thread. */
int clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *left)
{
    static int (*next)(clockid_t, int, const struct timespec *, struct timespec *);
    is_realtime_thread();
    next = next ? next
                : NEXT(int (*)(clockid_t, int, const struct timespec *, struct timespec *),
                       "clock_nanosleep");
    return next(clock, flags, until, left);
}

COUNTED(13, ssize_t, send, (int fd, const void *data, size_t size, int flags),
        (fd, data, size, flags))
COUNTED(15, ssize_t, sendmsg, (int fd, const struct msghdr *message, int flags),
        (fd, message, flags))
COUNTED(17, FILE *, fopen, (const char *path, const char *mode), (path, mode))
COUNTED(22, int, vfprintf, (FILE * file, const char *format, va_list arguments),
        (file, format, arguments))

static int print(int which, FILE *file, const char *format, va_list arguments)
{
    count(which);
    return vfprintf(file, format, arguments);
}

int fprintf(FILE *file, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int written = print(19, file, format, arguments);
    va_end(arguments);
    return written;
}

int printf(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int written = print(18, stdout, format, arguments);
    va_end(arguments);
    return written;
}

/* With RT_GUARD_PROBE set, the guard itself does one forbidden thing on a thread named `haptic`:
 * the proof that it can see. */
static void *offend(void *argument)
{
    (void)argument;
    prctl(PR_SET_NAME, "haptic", 0, 0, 0);
    free(malloc(32));
    return NULL;
}

__attribute__((constructor)) static void probe(void)
{
    pthread_t thread;
    if (getenv("RT_GUARD_PROBE") && pthread_create(&thread, NULL, offend, NULL) == 0) {
        pthread_join(thread, NULL);
    }
}

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("RT_GUARD_REPORT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) {
        return;
    }
    long total = 0;
    for (int i = 0; i < CALLS; ++i) {
        const long number = atomic_load(&counts[i]);
        total += number;
        if (number > 0) {
            fprintf(file, "%s %ld\n", names[i], number);
        }
    }
    fprintf(file, "threads %ld\ntotal %ld\n", atomic_load(&seen_threads), total);
    fclose(file);
}
