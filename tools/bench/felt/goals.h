/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What a row of felt.csv has to reach. Thread: main. */
#include "bench/felt/play.h"

#define SS_FELT_REFERENCE_HZ 1000.0
/* Shares of the mean force. */
#define SS_FELT_GOOD_P99    0.07 /* just noticeable */
#define SS_FELT_GOOD_HELD   0.02 /* of a held press, against 1000 Hz */
#define SS_FELT_GOOD_STATIC 0.03 /* of a held press, against the static solution */
enum { SS_FELT_GOALS = 9 };

/* What one row was measured to be. */
typedef struct ss_felt_row {
    double rate_hz;
    int32_t delay_ms;
    ss_felt_errors e;
    double static_error, net_j;
    double hold_p99;    /* of the same run without the local contact model */
    double penetration; /* of a press, in the tool's radii at the working force */
} ss_felt_row;

typedef struct ss_felt_goal {
    const char *name, *text;
    bool has_path[SS_FELT_PATHS];
    double from_hz;
    bool any_delay;
    bool (*is_missed)(const ss_felt_row *r);
} ss_felt_goal;

extern const ss_felt_goal ss_felt_goals[SS_FELT_GOALS];
/* Does a row of this path, rate and delay have that goal? */
bool ss_felt_has_goal(const ss_felt_goal *g, ss_felt_path path, double rate_hz, int32_t delay_ms);
