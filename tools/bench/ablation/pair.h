/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A scene as it is, and the same with one omission of its plan put back: what that costs, and
 * whether the results are the same. Both worlds are made in one process and take turns, so that a
 * machine that drifts drifts for both: 1.35 s of ticks at rest, then 0.5 s in which the first tool
 * goes in and out of the tissue, where the scene has one. Both are stepped at the rate of the scene
 * as it is: a plan that finds a rate by costs may find another with more in it, and forces of two
 * rates tell nothing of what was put back. Thread: main.
 */
#include <stdbool.h>

#include "rt/args.h"
#include "world/omission.h"

/* Each [0] as planned, [1] with it put back. */
typedef struct ss_ablation_figures {
    double rest_us[2], press_us[2]; /* thread CPU a tick, median of turns */
    double bytes[2];                /* held by the world */
    double create_ms[2];            /* thread CPU, the least of a few times */
    /* The least that a turn, or a creation, took over the one beside it: above 1, all took more. */
    double rest_least, press_least, create_least;
    double message_bytes[2]; /* of surface and forces, a second of simulated time */
    /* Both are stepped at [0]; [1] is what the plan takes with it put back, where costs choose. */
    double rate_hz[2];
    bool is_same_state;              /* the state hash at the end */
    double force_apart, field_apart; /* shares of the largest force and displacement */
} ss_ablation_figures;

/* Shares up to which forces and displacements count as the same. */
#define SS_ABLATION_APART 1e-3
/* Are the results the same, by the hash or by that share? */
bool ss_ablation_agrees(const ss_ablation_figures *figures);

softsim_status ss_ablation_measure(const char *scene, const ss_omission *omission,
                                   ss_ablation_figures *out, softsim_error *error);
