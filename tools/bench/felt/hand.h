/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The closed loop: the bridge's simulated device in its simulated hand (devices/sim.h), a bus each
 * way (bus.h), the bridge's correction of forces (correct.h), and a server without a clock: either
 * a scene's world, or a haptic tick against a chain of masses of known stiffness (chain.h).
 *
 * What counts is what the device did: its true position, and the force that it exerted from each
 * sample to the next. Thread: main.
 */
#include "bench/felt/path.h"
#include "bench/latency/session_metrics.h"
#include "bus.h"
#include "devices/sim.h"

typedef struct ss_hand_run {
    ss_sim_body body;
    ss_sim_grip grip;
    ss_sim_script script;
    uint64_t seed; /* of tremor and bus */
    ss_bus_config bus;
    bool is_correcting;
    double seconds;
    double rate_hz; /* of the simulation */
    /* The server: a scene, or, without one, a chain. */
    const char *scene;
    const ss_felt_place *place;
    const char *const *set;
    int32_t set_count;
    double tissue_n_per_m;                       /* of the chain */
    double stiffness_n_per_m, damping_n_s_per_m; /* of its coupling */
} ss_hand_run;

typedef struct ss_hand_outcome {
    ss_felt felt;
    /* The worst contact: what it took from the hand at last, and at its peak. */
    double net_j, peak_j;
    bool is_passive; /* no contact handed out more than its allowance */
    /* Of the chain: steepest felt change of force with position over 5 ms in contact, by the
     * stiffness limit at that time; without motion of 0.3 mm in 5 ms, 0. */
    double steepness;
    double least_limit_n_per_m;
    double delay_p95_ms;
    int64_t damped_ticks, backoffs;
} ss_hand_outcome;

/* What a contact may hand out, J: of a tap over a bus of 10 ms, of one over less, of another. */
double ss_hand_allowance(const ss_hand_run *run, double peak_j);
softsim_status ss_hand_play(const ss_hand_run *run, ss_hand_outcome *out, softsim_error *error);
