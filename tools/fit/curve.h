/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A measured curve: force against depth while pressing, or against time while holding.
 *
 * In: a CSV with the columns `depth_m,force_n` or `time_s,force_n`, a stranger's input. Out: its
 * points, checked: finite, increasing from 0 or more, two at least, forces of 1e6 N at most, not
 * all without force. Thread: set-up only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

enum { SS_CURVE_MAX_POINTS = 10000 }; /* a longer record tells a model no more: thin it out */

typedef struct ss_curve {
    const char *path;
    bool is_time; /* `time_s`: relaxation; else depth */
    int32_t count;
    double *at, *force; /* m or s; N */
    double rms;         /* N, of the force */
} ss_curve;

/* All faults are added to `error`; the curve is then empty. */
softsim_status ss_curve_read(const char *path, ss_curve *out, softsim_error *error);
void ss_curve_fini(ss_curve *curve);
