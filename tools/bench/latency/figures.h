/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * From what a session recorded to the figures of the latency report. Nothing here reads a clock.
 *
 * Lateness: the server publishes percentiles of its last 10 s only, so the run is cut into
 * disjoint windows of 10 s that end with a status; p50, p99 and p99.9 are the medians over these
 * windows, the maximum that of all of them; the bare loop is cut into the same windows.
 * Counters: last status within the run less the first.
 * Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/latency/session.h"
#include "case/samples.h"

typedef struct ss_figure {
    double p50, p99, p999, max; /* microseconds; NaN: not known */
    int64_t count;
} ss_figure;

typedef struct ss_figures {
    ss_figure haptic, bare_loop, pose_to_force, bare_echo, step;
    int32_t window_count;
    int64_t windows_begin_ns, windows_end_ns;
    ss_samples answer_us; /* pose to force */
    int64_t periods[SOFTSIM_MAX_PROBES], forces[SOFTSIM_MAX_PROBES], missed[SOFTSIM_MAX_PROBES];
    int64_t bare_periods, bare_missed;
    int64_t received, superseded, refused;
    int64_t statuses, statuses_lost;
    int64_t wrong_sums; /* statuses in which forces + missed is not periods, for some probe */
    int32_t worst_verdict;
    char reason[96]; /* of the worst verdict */
} ss_figures;

/* Fills all but pose_to_force. False when no two statuses came within the run. */
bool ss_figures_compute(const ss_session *session, ss_figures *out_figures);
/* Reads the first answer to every pose sent within the run from the replay's CSV. */
softsim_status ss_figures_read_answers(const ss_session *session, ss_figures *figures,
                                       softsim_error *error);
void ss_figures_fini(ss_figures *figures);

ss_figure ss_figure_of(ss_samples *samples);
/* missed <= 2 x the bare loop's + 0.1 % of the periods, where the bare loop's are scaled to as
 * many periods. */
bool ss_figures_is_missed_good(int64_t periods, int64_t missed, int64_t bare_periods,
                               int64_t bare_missed);
