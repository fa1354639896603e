/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside loops/ only: what the loops share, and each loop's body.
 *
 * Every loop runs on the absolute monotonic clock from one common start, so that tick n is due at
 * start + n T for all of them. A loop that wakes late by whole periods skips them, and the skipped
 * ones are missed periods: nothing is caught up by running twice.
 *
 * Settling a period (net thread only, so that forces + missed = periods in every status): the
 * haptic loop hands over one force a tick with the tick's number; a gap in the numbers is missed
 * periods; a force sent within one period of its due time is a force, a later one is a missed
 * period though it was sent.
 */
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "loops/loops.h"
#include "loops/pace.h"
#include "loops/prefix_owner.h"
#include "loops/stderr_report.h"
#include "rt/mailbox.h"

enum { SS_RATE_MARKS = 5 }; /* a quarter of a second apart */

/* Steps a second of the clock: over the last second, once there is one. */
typedef struct ss_rate_meter {
    int64_t time_ns[SS_RATE_MARKS], step[SS_RATE_MARKS];
    int64_t count; /* of marks ever made */
} ss_rate_meter;

typedef struct ss_loops {
    ss_world *world;
    const ss_options *options;
    int64_t start_ns;
    int64_t period_ns, step_period_ns;
    int wake_fd;           /* haptic -> net */
    int simulation_fd;     /* net, haptic -> a simulation that sleeps */
    int haptic_fd;         /* net -> a haptic loop that no probe has called yet */
    int publish_fd;        /* net, simulation -> publish, while nothing moves */
    int event_fd;          /* net -> main: it listens, or cannot */
    atomic_bool is_ending; /* loops return */
    atomic_bool is_over;   /* main shall end: shutdown, duration in lockstep, broken network */
    atomic_bool is_listening;
    atomic_bool is_resting; /* the simulation waits to be called; read, changed at once */
    atomic_int refreshes;   /* net -> publish */
    _Atomic double mesh_rate_hz, max_bytes_per_s; /* net -> publish */
    _Atomic double rate_hz;                       /* simulation -> net: achieved */
    ss_mailbox *judgement;                        /* net -> main: ss_judgement */
    ss_rate_meter meter;                          /* simulation thread; net in lockstep */
    ss_pace pace;                                 /* simulation thread */

    /* net thread */
    ss_net *net;
    bool takes_commands;
    bool is_answering;          /* a force was sent: the haptic loop keeps its own time */
    softsim_status open_status; /* main reads it from is_listening on */
    softsim_status net_status;  /* main reads it after the thread's end */
    softsim_error net_error;
    bool is_open; /* the prefix is ours: poses and commands are taken */
    ss_prefix_owner prefix_owner;
    int64_t last_tick[SOFTSIM_MAX_PROBES];
    int64_t periods[SOFTSIM_MAX_PROBES], forces[SOFTSIM_MAX_PROBES], missed[SOFTSIM_MAX_PROBES];
    int32_t last_flags[SOFTSIM_MAX_PROBES]; /* of the newest force */
    int64_t silent_ns[SOFTSIM_MAX_PROBES];  /* since when it has been stale */
    char slow_reason[128];
    double peak_force;
    int64_t status_ns; /* when the last one went out */
    bool is_status_asked, has_set;
    int64_t scene_ns;      /* when the scene went out; 0: at once */
    int64_t queue_refused; /* poses that found their ring full */
    ss_haptic_stats haptic_stats;
    ss_simulation_stats simulation_stats;

    /* main thread */
    ss_stderr_report stderr_report;

    /* publish thread; read by net */
    ss_publisher *publisher;
} ss_loops;

/* The bodies of the threads; the argument is the ss_loops. */
void *ss_loops_net(void *argument);
void *ss_loops_haptic(void *argument);
void *ss_loops_simulation(void *argument);
void *ss_loops_publish(void *argument);

/* Every loop that waits looks at what there is. Thread: net, main. */
void ss_loops_call(ss_loops *loops);
/* Main shall end. Thread: any. */
static inline void ss_loops_end(ss_loops *loops)
{
    atomic_store_explicit(&loops->is_over, true, memory_order_release);
}
/* Renews the rate, right behind a step so that slow steps are not counted by halves, and marks
 * every quarter of a second where the simulation is. Thread: that which steps; RT-safe. */
void ss_loops_measure_rate(ss_loops *loops);
/* Status and judgement of this moment. Thread: net. */
void ss_loops_send_status(ss_loops *loops);
/* Thread: net. */
void ss_loops_send_scene(ss_loops *loops);
