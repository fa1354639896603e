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
    bool is_without_law;    /* haptic.between_steps hold: forces are held from the last result */
    double slowness;        /* > 1: the last contact of a poke or tap alone, so much slower */
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
/* How deep the tool (not the hand) is in the tissue, in its radii, where it is pressed with the
 * scene's working force at 10 mm/s; NAN where `run` cannot be played or the tissue does not answer
 * with it within four times the depth of a press. */
double ss_felt_penetration(const char *scene, const ss_felt_place *place, const ss_felt_run *run);
/* How deep along the way of a press the tool first feels the tissue, m: the contact surface lies
 * within the mesh. NAN where `run` cannot be played or nothing is felt within the tool's radius. */
double ss_felt_touch_depth(const char *scene, const ss_felt_place *place, const ss_felt_run *run);
void ss_felt_trace_fini(ss_felt_trace *trace);

/* How far a force is from the reference's, over the milliseconds in which the reference touches, as
 * shares of the mean force there; NAN where nothing touches. It touches with more than 0.02 N, or
 * 1 % of its largest force where that is less: a body of a hundredth of a newton is a body. */
typedef struct ss_felt_errors {
    double p50, p95, p99, largest;
    double impulse, peak; /* of |F| over the whole path, signed */
    double held;          /* signed; NAN but for a press */
    double touch_ms;      /* of the reference's contacts, the one felt latest or earliest; signed */
    /* Of the milliseconds that are further off than `limit`: the shares in the first and in the
     * last `settle_ms` of a contact; NAN where there are none. */
    double at_touch, at_leaving;
    /* ms from touching to 90 % of the contact's peak, the shortest of the contacts */
    double rise_ms;
} ss_felt_errors;

typedef struct ss_felt_question {
    double limit;      /* share of the mean force */
    int32_t settle_ms; /* how long a contact is young, and old */
} ss_felt_question;

/* Fails when out of memory. */
bool ss_felt_compare(const ss_felt_trace *trace, const ss_felt_trace *reference,
                     const ss_felt_question *question, ss_felt_errors *out);

/* How much of the reference's last contact is not the force of `slow`, the same path with a
 * slowness: p95 over its milliseconds, as a share of its mean. NAN without a contact, or memory. */
double ss_felt_dynamic_share(const ss_felt_trace *slow, double slowness, const ss_felt_place *place,
                             ss_felt_path path, const ss_felt_trace *reference);
