/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/* Starting, waiting and ending: the main thread. */
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

#include "rt/clock.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/program.h"
#include "rt/thread.h"

enum {
    HAPTIC_PRIORITY = 80,
    NET_PRIORITY = 78,
    SIMULATION_PRIORITY = 70,
    STOP_TICKS = 25 /* the force ramps to zero in 20 */
};

typedef struct ss_loop_threads {
    ss_thread *net, *simulation, *haptic, *publish;
    bool is_fifo_refused;
} ss_loop_threads;

static softsim_status start_loop(ss_loops *loops, const char *name, int priority,
                                 void *(*body)(void *), ss_thread **out_thread,
                                 ss_loop_threads *threads, softsim_error *error)
{
    bool is_refused = false;
    /* Lockstep computes as long as it takes: ahead of everything else only where asked to. */
    const ss_realtime wanted = loops->options->realtime;
    const ss_realtime realtime =
        loops->options->lockstep && wanted == SS_REALTIME_AUTO ? SS_REALTIME_OFF : wanted;
    const softsim_status status =
        ss_thread_start(name, priority, realtime, body, loops, out_thread, &is_refused);
    threads->is_fifo_refused |= is_refused;
    if (status != SOFTSIM_OK) {
        softsim_error_add(error, status,
                          "cannot start the %s thread: %s; --realtime auto falls back to the "
                          "ordinary scheduler",
                          name, softsim_status_text(status));
    }
    return status;
}

/* The net thread opens LCM itself: it alone uses it. */
static softsim_status start_net(ss_loops *loops, ss_loop_threads *threads, softsim_error *error)
{
    const softsim_status status =
        start_loop(loops, "net", NET_PRIORITY, ss_loops_net, &threads->net, threads, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    while (!atomic_load_explicit(&loops->is_listening, memory_order_acquire)) {
        struct pollfd wait = {.fd = loops->event_fd, .events = POLLIN};
        poll(&wait, 1, 100);
        ss_wake_drain(loops->event_fd);
    }
    if (loops->open_status != SOFTSIM_OK) {
        *error = loops->net_error;
    }
    return loops->open_status;
}

static softsim_status open_publisher(ss_loops *loops, softsim_error *error)
{
    const ss_scene *scene = loops->world->scene;
    const ss_publisher_config config = {.lcm_url = loops->options->lcm_url,
                                        .prefix = loops->options->prefix,
                                        .max_bytes_per_s = scene->max_bytes_per_s};
    const ss_publish_mesh surface = ss_world_publish_mesh(loops->world);
    return ss_publisher_open(&config, &surface, &loops->publisher, error);
}

static softsim_status start_all(ss_loops *loops, ss_loop_threads *threads, softsim_error *error)
{
    const bool is_lockstep = loops->options->lockstep;
    softsim_status status = SOFTSIM_OK;
    if (loops->world->surface) {
        status = open_publisher(loops, error);
    }
    if (status == SOFTSIM_OK) {
        status = start_net(loops, threads, error);
    }
    loops->start_ns = ss_clock_now_ns() + loops->period_ns;
    if (status == SOFTSIM_OK && !is_lockstep) {
        status = start_loop(loops, "simulation", SIMULATION_PRIORITY, ss_loops_simulation,
                            &threads->simulation, threads, error);
    }
    if (status == SOFTSIM_OK && !is_lockstep && loops->world->used_probes) {
        status = start_loop(loops, "haptic", HAPTIC_PRIORITY, ss_loops_haptic, &threads->haptic,
                            threads, error);
    }
    if (status == SOFTSIM_OK && loops->world->surface) {
        status =
            start_loop(loops, "publish", 0, ss_loops_publish, &threads->publish, threads, error);
    }
    return status;
}

/* Waits for a signal to stop, the duration, or the end from within. */
static void wait_for_end(ss_loops *loops)
{
    const double duration = loops->options->lockstep ? 0.0 : loops->options->duration_s;
    const int64_t deadline =
        duration > 0.0 ? ss_clock_now_ns() + (int64_t)(duration * 1e9) : INT64_MAX;
    sigset_t signals;
    ss_program_stop_signals(&signals);
    while (!atomic_load_explicit(&loops->is_over, memory_order_acquire)) {
        const int64_t now = ss_clock_now_ns();
        const int64_t left = deadline - now;
        if (left <= 0) {
            return;
        }
        const ss_judgement *judgement = ss_mailbox_take(loops->judgement, NULL);
        if (loops->options->log_level >= SS_LOG_WARNING) {
            ss_stderr_report_update(&loops->stderr_report, judgement, now);
        }
        const int64_t wait = left < 50000000 ? left : 50000000;
        const struct timespec timeout = {.tv_nsec = (long)wait};
        if (sigtimedwait(&signals, NULL, &timeout) > 0) {
            return;
        }
    }
}

static void print_summary(const ss_loops *loops)
{
    int64_t periods = 0, forces = 0, missed = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        periods += loops->periods[p];
        forces += loops->forces[p];
        missed += loops->missed[p];
    }
    const double *late = loops->haptic_stats.lateness_us;
    const double *step = loops->simulation_stats.step_us;
    fprintf(stderr,
            "softsimd: %lld haptic periods: %lld forces, %lld missed; peak force %.3f N\n"
            "softsimd: haptic lateness us p50 %.0f p99 %.0f p99.9 %.0f max %.0f; step us p50 %.0f "
            "p99 %.0f max %.0f; %lld steps of %.6g ms\n",
            (long long)periods, (long long)forces, (long long)missed, loops->peak_force, late[0],
            late[1], late[2], late[3], step[0], step[1], step[2],
            (long long)loops->simulation_stats.info.step, 1e3 * loops->world->step_period);
}

static void destroy(ss_loops **loops)
{
    if (*loops == NULL) {
        return;
    }
    const int fd[] = {(*loops)->wake_fd, (*loops)->event_fd, (*loops)->simulation_fd,
                      (*loops)->haptic_fd, (*loops)->publish_fd};
    for (size_t i = 0; i < sizeof fd / sizeof *fd; ++i) {
        if (fd[i] >= 0) {
            close(fd[i]);
        }
    }
    ss_mailbox_destroy(&(*loops)->judgement);
    ss_memory_free(*loops);
    *loops = NULL;
}

void ss_loops_call(ss_loops *loops)
{
    ss_wake_signal(loops->simulation_fd);
    ss_wake_signal(loops->haptic_fd);
    ss_wake_signal(loops->publish_fd);
}

/* All that the threads share; NULL after a failure. */
static softsim_status create(ss_world *world, const ss_options *options, ss_loops **out_loops,
                             softsim_error *error)
{
    ss_loops *loops = *out_loops = ss_memory_get(1, sizeof *loops);
    if (loops == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no memory for the loops");
        return SOFTSIM_ERROR_MEMORY;
    }
    loops->world = world;
    loops->options = options;
    loops->takes_commands =
        !options->no_commands && (options->allow_commands || !ss_net_is_own_url(options->lcm_url));
    loops->period_ns = (int64_t)llround(world->period * 1e9);
    loops->step_period_ns = loops->period_ns * world->step_ticks;
    ss_pace_init(&loops->pace, loops->step_period_ns);
    loops->wake_fd = ss_wake_open();
    loops->event_fd = ss_wake_open();
    loops->simulation_fd = ss_wake_open();
    loops->haptic_fd = ss_wake_open();
    loops->publish_fd = ss_wake_open();
    const int wake_errno = errno; /* of the last that could not be opened */
    loops->judgement = ss_mailbox_create(sizeof(ss_judgement));
    loops->stderr_report = (ss_stderr_report){.prefix = options->prefix, .gate = world->gate};
    atomic_store(&loops->mesh_rate_hz, world->scene->mesh_rate_hz);
    atomic_store(&loops->max_bytes_per_s, world->scene->max_bytes_per_s);
    softsim_status status = SOFTSIM_OK;
    if (loops->judgement == NULL) {
        status = SOFTSIM_ERROR_MEMORY;
        softsim_error_add(error, status, "no memory for the loops");
    } else if (loops->wake_fd < 0 || loops->event_fd < 0 || loops->simulation_fd < 0 ||
               loops->haptic_fd < 0 || loops->publish_fd < 0) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status, "cannot open an eventfd: %s", ss_files_reason(wake_errno));
    }
    if (status != SOFTSIM_OK) {
        destroy(out_loops);
    }
    return status;
}

static void lock_memory(const ss_options *options)
{
    if (options->realtime != SS_REALTIME_OFF && !options->lockstep && !ss_thread_lock_memory() &&
        options->log_level >= SS_LOG_WARNING) {
        fprintf(stderr, "softsimd: warning: memory is not locked, so a page fault may delay a "
                        "force; raise `ulimit -l` or run as root\n");
    }
}

/* From ready until the forces have been ramped to zero. */
static void serve(ss_loops *loops, const ss_loop_threads *threads)
{
    if (threads->is_fifo_refused && loops->options->log_level >= SS_LOG_WARNING) {
        fprintf(stderr, "softsimd: warning: SCHED_FIFO is not allowed, so forces may be late; "
                        "run as root or raise `ulimit -r`\n");
    }
    if (loops->world->yardstick > 0.0 && loops->options->log_level >= SS_LOG_INFO) {
        fprintf(stderr, "softsimd: simulation at %.6g Hz; a step takes %.2f of the counted cost\n",
                1.0 / loops->world->step_period, loops->world->yardstick);
    }
    if (!loops->takes_commands && !loops->options->no_commands &&
        loops->options->log_level >= SS_LOG_INFO) {
        fprintf(stderr, "softsimd: takes no commands but refresh and status, as the LCM URL is one "
                        "of your own; --allow-commands takes them\n");
    }
    puts("softsimd: ready");
    fflush(stdout);
    wait_for_end(loops);
    ss_loops_end(loops); /* in lockstep no pose that still waits is answered */
    if (!loops->options->lockstep) {
        /* Let the haptic loop ramp the forces to zero. */
        atomic_store_explicit(&loops->world->is_stopping, true, memory_order_release);
        ss_clock_sleep_until(ss_clock_now_ns() + STOP_TICKS * loops->period_ns);
    }
}

static void end_all(ss_loops *loops, ss_loop_threads *threads)
{
    atomic_store_explicit(&loops->is_ending, true, memory_order_release);
    ss_loops_call(loops);
    ss_thread_join(&threads->haptic);
    ss_thread_join(&threads->simulation);
    ss_wake_signal(loops->wake_fd);
    ss_thread_join(&threads->net);
    ss_thread_join(&threads->publish);
    ss_publisher_close(&loops->publisher);
}

softsim_status ss_loops_run(ss_world *world, const ss_options *options, softsim_error *error)
{
    ss_loops *loops = NULL;
    ss_loop_threads threads = {0};
    softsim_status status = create(world, options, &loops, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    lock_memory(options);
    status = start_all(loops, &threads, error);
    if (status == SOFTSIM_OK) {
        serve(loops, &threads);
    }
    end_all(loops, &threads);
    if (status == SOFTSIM_OK) {
        status = loops->net_status;
        if (status != SOFTSIM_OK) {
            *error = loops->net_error;
        }
        if (options->log_level >= SS_LOG_INFO && ss_program_can_tell()) {
            print_summary(loops);
        }
    }
    destroy(&loops);
    return status;
}
