/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A path played to a scene without a clock, and the force that the device would exert, a thousand
 * times a second.
 *
 * Delay: of the bus, one way. The server has a pose `delay` late, the device has the force another
 * `delay` later, tells in each pose which force is in effect, and corrects it as the bridge does
 * (correct.h). The pose itself goes its way whatever the force: what is judged is the force.
 * Thread: main.
 */
#include "bench/felt/path.h"
#include "softsim/softsim.h"

typedef struct ss_felt_run {
    double rate_hz;         /* of the simulation; beyond the haptic rate: both run at it */
    int32_t delay_ms;       /* one way */
    bool is_held;           /* a press goes on for 3 s: towards the static solution */
    const char *const *set; /* overrides of the scene */
    int32_t set_count;
    const char *import_program; /* as of softsim_config */
} ss_felt_run;

typedef struct ss_felt_trace {
    int32_t count;      /* milliseconds */
    double (*force)[3]; /* N, on the device */
    double net_j;       /* least energy balance of a contact: negative, the hand was driven */
    double held_n;      /* of a press: mean over the last 100 ms before it goes back; else NAN */
    softsim_verdict verdict;
    char reason[128];
} ss_felt_trace;

/* The scene as such a run has it; NULL: `error` says why. */
softsim_world *ss_felt_world(const char *scene, const ss_felt_run *run, softsim_error *error);
softsim_status ss_felt_play(const char *scene, const ss_felt_place *place, ss_felt_path path,
                            const ss_felt_run *run, ss_felt_trace *out, softsim_error *error);
void ss_felt_trace_fini(ss_felt_trace *trace);

/* How far a force is from the reference's, over the milliseconds in which the reference touches
 * (more than 0.02 N), as shares of the mean force there; NAN where nothing touches. */
typedef struct ss_felt_errors {
    double p50, p99, largest;
    double impulse, peak; /* of |F| over the whole path, signed */
    double held;          /* signed; NAN but for a press */
} ss_felt_errors;
/* Fails when out of memory. */
bool ss_felt_compare(const ss_felt_trace *trace, const ss_felt_trace *reference,
                     ss_felt_errors *out);
