/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How a session felt, from its log of poses and forces alone.
 *
 * In: rows of time, position, force, flags and model age, in time order, as the device had them: a
 * row's force is in effect from that row's sample on (a server's log must first be shifted by the
 * loop delay). Out: figures, each with a verdict.
 * Contact: |F| > 0.02 N for at least 20 rows.
 *
 *   net energy   least over contacts of sum -F_j . (x_{j+1} - x_j): negative, the hand was driven
 *   chatter      amplitude of x above 15 Hz while held still: windows of 0.5 s in contact in which
 *                x smoothed at 3 Hz stays within 0.5 mm, x along the window's mean force (a tool
 *                may slide at a steady depth); the worst window
 *   buzz         force above 30 Hz over the mean force, same windows
 *   continuity   99th percentile of |dF - running median of 11| over the 99.5th of |F|, five rows
 *                inside contacts
 *   bounces      most contacts ended within any second
 *
 * Thread: any. Memory: scratch of about 120 bytes a row during the call.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_felt_row {
    double time_s;
    double x[3]; /* m */
    double f[3]; /* N, on the hand */
    int32_t flags;
    int32_t age_us;
} ss_felt_row;

typedef struct ss_felt_options {
    int32_t intended_contacts; /* contacts a second that the task itself makes */
    double age_limit_us;       /* (lag + 1) simulation periods; 0: age gets no verdict */
} ss_felt_options;

typedef enum ss_felt_verdict {
    SS_FELT_NONE,
    SS_FELT_GOOD,
    SS_FELT_FAIR,
    SS_FELT_BAD
} ss_felt_verdict;

typedef struct ss_felt_metric {
    double value;
    ss_felt_verdict verdict; /* NONE: the log has nothing to judge it by */
} ss_felt_metric;

typedef struct ss_felt {
    int32_t contacts;
    ss_felt_metric net_energy_j;
    ss_felt_metric chatter_m;
    double chatter_hz;
    ss_felt_metric buzz;
    ss_felt_metric continuity;
    ss_felt_metric bounces;
    ss_felt_metric age_p99_us;
    double predicted_share;
} ss_felt;

/* Judges `count` rows. SOFTSIM_ERROR_ARGUMENT: fewer than two rows, times not increasing, numbers
 * not finite. Thread: any. */
softsim_status ss_felt_judge(const ss_felt_row *row, int64_t count, const ss_felt_options *options,
                             ss_felt *out_felt);
/* "good", "fair", "bad", "-". */
const char *ss_felt_verdict_name(ss_felt_verdict verdict);
