/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/latency/figures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/csv.h"

enum { MAX_WINDOWS = 1024, MAX_ANSWERS = 8 * 1000 * 1000 };
static const int64_t window_ns = SS_SESSION_WINDOW_S * 1000000000LL;

ss_figure ss_figure_of(ss_samples *samples)
{
    return (ss_figure){.p50 = ss_samples_quantile(samples, 0.5),
                       .p99 = ss_samples_quantile(samples, 0.99),
                       .p999 = ss_samples_quantile(samples, 0.999),
                       .max = ss_samples_quantile(samples, 1.0),
                       .count = samples->count};
}

bool ss_figures_is_missed_good(int64_t periods, int64_t missed, int64_t bare_periods,
                               int64_t bare_missed)
{
    const double bare_share = bare_periods > 0 ? (double)bare_missed / (double)bare_periods : 0.0;
    return (double)missed <= (2.0 * bare_share + 0.001) * (double)periods;
}

/* ---- windows ---- */

/* Statuses, newest first, that end disjoint windows within the run; the last one of the run when
 * the run is shorter than a window. */
static int32_t choose_windows(const ss_session *s, int32_t last,
                              const ss_session_status *out_end[MAX_WINDOWS])
{
    int32_t count = 0;
    int64_t before_ns = INT64_MAX;
    for (int32_t i = last; i >= 0 && count < MAX_WINDOWS; --i) {
        const ss_session_status *status = &s->status[i];
        if (status->receive_ns <= before_ns && status->receive_ns - window_ns >= s->begin_ns) {
            out_end[count++] = status;
            before_ns = status->receive_ns - window_ns;
        }
    }
    if (count == 0) {
        out_end[count++] = &s->status[last];
    }
    return count;
}

/* Median over windows of each percentile, and the largest maximum. */
static ss_figure combine(const ss_figure *window, int32_t count)
{
    double store[4][MAX_WINDOWS];
    ss_figure out = {.max = 0.0};
    for (int k = 0; k < 4; ++k) {
        ss_samples samples = {.value = store[k], .capacity = MAX_WINDOWS};
        for (int32_t i = 0; i < count; ++i) {
            const double value[4] = {window[i].p50, window[i].p99, window[i].p999, window[i].max};
            if (!isnan(value[k])) {
                ss_samples_add(&samples, value[k]);
            }
        }
        double *to[4] = {&out.p50, &out.p99, &out.p999, &out.max};
        *to[k] = ss_samples_quantile(&samples, k < 3 ? 0.5 : 1.0);
    }
    for (int32_t i = 0; i < count; ++i) {
        out.count += window[i].count;
    }
    return out;
}

static ss_figure bare_window(const ss_bare_result *bare, int64_t end_ns, ss_samples *scratch)
{
    scratch->count = 0;
    scratch->is_sorted = false;
    for (int64_t i = 0; i < bare->tick_count; ++i) {
        if (bare->tick[i].due_ns > end_ns - window_ns && bare->tick[i].due_ns <= end_ns) {
            ss_samples_add(scratch, bare->tick[i].late_us);
        }
    }
    return ss_figure_of(scratch);
}

static bool compute_lateness(const ss_session *s, int32_t last, ss_figures *out)
{
    static const ss_session_status *end[MAX_WINDOWS];
    static ss_figure haptic[MAX_WINDOWS], bare[MAX_WINDOWS];
    ss_samples scratch;
    if (!ss_samples_init(&scratch, s->bare.tick_count + 1)) {
        return false;
    }
    out->window_count = choose_windows(s, last, end);
    for (int32_t i = 0; i < out->window_count; ++i) {
        const double *late = end[i]->of.lateness_us;
        haptic[i] = (ss_figure){late[0], late[1], late[2], late[3], 0};
        bare[i] = bare_window(&s->bare, end[i]->receive_ns, &scratch);
    }
    out->windows_begin_ns = end[out->window_count - 1]->receive_ns - window_ns;
    out->windows_end_ns = end[0]->receive_ns;
    ss_samples_fini(&scratch);
    out->haptic = combine(haptic, out->window_count);
    out->bare_loop = combine(bare, out->window_count);
    return true;
}

/* ---- counters ---- */

static void check_statuses(const ss_session *s, ss_figures *out)
{
    for (int32_t i = 0; i < s->status_count; ++i) {
        const ss_session_status *status = &s->status[i];
        bool is_wrong = false;
        for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            is_wrong |= status->of.probe_forces[p] + status->of.probe_missed[p] !=
                        status->of.probe_periods[p];
        }
        out->wrong_sums += is_wrong;
        if (i > 0) {
            const int64_t gap = (int64_t)status->of.seq - s->status[i - 1].of.seq - 1;
            out->statuses_lost += gap > 0 ? gap : 0;
        }
        if (status->of.verdict > out->worst_verdict) {
            out->worst_verdict = status->of.verdict;
            snprintf(out->reason, sizeof out->reason, "%s", status->reason);
        }
    }
    out->statuses = s->status_count;
}

static void compute_counters(const ss_session_status *first, const ss_session_status *last,
                             ss_figures *out)
{
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        out->periods[p] = last->of.probe_periods[p] - first->of.probe_periods[p];
        out->forces[p] = last->of.probe_forces[p] - first->of.probe_forces[p];
        out->missed[p] = last->of.probe_missed[p] - first->of.probe_missed[p];
        out->haptic.count =
            out->periods[p] > out->haptic.count ? out->periods[p] : out->haptic.count;
    }
    out->received = last->of.poses_received - first->of.poses_received;
    out->superseded = last->of.poses_superseded - first->of.poses_superseded;
    out->refused = last->poses_refused - first->poses_refused;
    out->step = (ss_figure){.p50 = last->of.step_us[0],
                            .p99 = last->of.step_us[1],
                            .p999 = NAN,
                            .max = last->of.step_us[2],
                            .count = last->of.step - first->of.step};
}

bool ss_figures_compute(const ss_session *s, ss_figures *out)
{
    memset(out, 0, sizeof *out);
    check_statuses(s, out);
    int32_t first = -1;
    int32_t last = -1;
    for (int32_t i = 0; i < s->status_count; ++i) {
        const int64_t at_ns = s->status[i].receive_ns;
        if (at_ns >= s->begin_ns && at_ns <= s->end_ns) {
            first = first < 0 ? i : first;
            last = i;
        }
    }
    if (first == last || !compute_lateness(s, last, out)) {
        return false;
    }
    compute_counters(&s->status[first], &s->status[last], out);
    out->bare_periods = s->bare.periods;
    out->bare_missed = s->bare.missed;
    out->bare_echo = ss_figure_of(s->bare.echo_us);
    return true;
}

/* ---- answers ---- */

softsim_status ss_figures_read_answers(const ss_session *s, ss_figures *figures,
                                       softsim_error *error)
{
    enum { SEQ, UTIME, PROBE, LATENCY, COLUMNS };
    static const char *const name[COLUMNS] = {"pose_seq", "pose_utime", "probe", "latency_us"};
    ss_csv csv;
    softsim_status status = ss_csv_open(&csv, s->answers, name, COLUMNS, COLUMNS, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const double begin_us = 1e-3 * (double)s->begin_ns;
    const double end_us = 1e-3 * (double)s->end_ns;
    const double most = fmin(MAX_ANSWERS, 1e-3 * (end_us - begin_us) * 8.0 + 1000.0);
    if (!ss_samples_init(&figures->answer_us, (int64_t)most)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no memory for the answers");
        status = SOFTSIM_ERROR_MEMORY;
    }
    double answered[SOFTSIM_MAX_PROBES] = {0}; /* the newest pose, by probe */
    double row[COLUMNS];
    int got = 1;
    while (status == SOFTSIM_OK && (got = ss_csv_next(&csv, row, error)) > 0) {
        if (!(row[PROBE] >= 0.0 && row[PROBE] < SOFTSIM_MAX_PROBES)) {
            continue;
        }
        const bool is_first = row[SEQ] > answered[(int)row[PROBE]];
        if (is_first) {
            answered[(int)row[PROBE]] = row[SEQ];
        }
        if (is_first && row[UTIME] >= begin_us && row[UTIME] <= end_us) {
            ss_samples_add(&figures->answer_us, row[LATENCY]);
        }
    }
    ss_csv_close(&csv);
    figures->pose_to_force = ss_figure_of(&figures->answer_us);
    return got < 0 ? SOFTSIM_ERROR_FORMAT : status;
}

void ss_figures_fini(ss_figures *figures)
{
    ss_samples_fini(&figures->answer_us);
}
