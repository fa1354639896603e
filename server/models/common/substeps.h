/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * An outer step in sub-steps, and what is said where it could not be done as it was meant.
 *
 * Sub-steps are equal parts of what is left, as many as time and the tools' way ask for. Where the
 * budget does not allow that, each is the longest stable one, and tools and prescribed nodes go the
 * same share of their ways as of the time: the body is simulated slower than time passes. RT-safe.
 */
#include "models/model.h"

/* Diagonals of the body: a displacement beyond means nothing any more and would drown every digit.
 */
#define SS_MAX_DISPLACEMENT 100.0
#define SS_CLAMPED_REASON   "displacement beyond a hundred times the body was cut off"
#define SS_SLOW_REASON      "needs more sub-steps than max_substeps: slower than real time"
#define SS_GAIN_REASON      "spurious energy was removed from the motion"
#define SS_KEPT_REASON      "not finite: last good state restored, waiting for reset"

/* Where an outer step stands. */
typedef struct ss_substeps {
    double left, path;         /* s still to simulate; 0..1 of the tools' way */
    int32_t motion;            /* parts that the tools' way asks for */
    int32_t taken_count, most; /* sub-steps tried, and those that are allowed */
} ss_substeps;

/* Sub-steps of at most `stable` s that what is left takes. */
double ss_substeps_needed(const ss_substeps *steps, double stable);
/* Length (s) and way of the next sub-step of at most `stable` s; `needed`: sub-steps that what is
 * left takes at the least, which are too many where the body is to be slower than time. */
void ss_substeps_plan(const ss_substeps *steps, double stable, double needed, double *out_h,
                      double *out_fraction);
/* Where the tools are after it. */
double ss_substeps_next(const ss_substeps *steps, double fraction);

/* Cuts displacements off at `limit` m and stops what moves there; was there any? */
bool ss_clamp_displacements(int32_t node_count, double limit, ss_real *u, ss_real *v);
