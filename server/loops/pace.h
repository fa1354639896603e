/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Does the simulation keep up with the clock? Judged by simulated against clock time, n h over t,
 * for the last half second and at least four steps. The longest step is left out, with its time: a
 * single hiccup (a page read from disk, a busy moment of the machine) is no slowness, whatever it
 * took; steps that are all too long are, however few.
 *
 *   share = (n - 1) h / (t - longest), at most 1
 *
 * Rejected: late steps less punctual ones, counted since the start of a bad time (853 of 1000
 * steps a second passed for good, and a first touch of 21 slow steps for slowness).
 * No clock in here: the caller gives the times. Thread: one; RT-safe.
 */
#include <stdint.h>

enum { SS_PACE_SLOTS = 16 };

typedef struct ss_pace {
    int64_t period_ns; /* of a step, h */
    int64_t last_ns;   /* end of the last step; 0: none yet */
    int64_t count;     /* slots ever begun */
    /* Steps by the time of their ends, some 50 ms a slot: the newest may still be growing. */
    struct {
        int64_t start_ns, end_ns, steps, longest_ns;
    } slot[SS_PACE_SLOTS];
} ss_pace;

/* Zero but for the period. */
void ss_pace_init(ss_pace *pace, int64_t period_ns);
/* A step ended at `now_ns`. */
void ss_pace_note(ss_pace *pace, int64_t now_ns);
/* Simulated over clock time, 0 to 1; 1 too while half a second is not over. */
double ss_pace_share(const ss_pace *pace);
/* Below it the simulation is slower than real time. */
#define SS_PACE_LEAST 0.95
