/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The limits of the verdicts come from sessions with a simulated device and hand, good ones and
 * ones spoilt on purpose. Net energy alone finds every bad one; chatter is blind to a cycle that
 * leaves the tissue (bounces see it).
 *
 * The high passes are bilinear, for the mean interval of the rows, and run forward (content, not
 * phase, counts); the 3 Hz smoothing, y += (1 - e^(-2 pi f dt)) (x - y), runs forward and backward
 * so that it does not lag behind the motion that it is to judge.
 */
#include "bench/latency/session_metrics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "rt/order.h"
#include "rt/vec.h"

#define CONTACT_FORCE 0.02 /* N */
#define WINDOW_S      0.5
#define STILL_M       0.5e-3
#define SMOOTH_HZ     3.0
#define CHATTER_HZ    15.0
#define BUZZ_HZ       30.0
#define TWO_PI        (2.0 * SS_PI)
enum { SHORTEST_CONTACT = 20, MEDIAN = 11, MARGIN = MEDIAN / 2 };

typedef struct span {
    int64_t first, last; /* rows, inclusive */
} span;

typedef struct scratch {
    span *contact;
    int64_t contact_count;
    double (*smooth)[3]; /* x below 3 Hz */
    double (*high)[3];   /* x above 15 Hz */
    double (*rough)[3];  /* F above 30 Hz */
    double *sample;
} scratch;

static double alpha_of(const ss_felt_row *row, int64_t i, double hz)
{
    return 1.0 - exp(-TWO_PI * hz * (row[i].time_s - row[i - 1].time_s));
}

/* One second-order section: y = b0 x + b1 x1 + b2 x2 - a1 y1 - a2 y2. */
typedef struct section {
    double b0, b1, b2, a1, a2;
} section;

/* First-order high pass, bilinear. */
static section first_order(double hz, double dt)
{
    const double k = tan(0.5 * TWO_PI * hz * dt);
    return (section){.b0 = 1.0 / (1.0 + k), .b1 = -1.0 / (1.0 + k), .a1 = (k - 1.0) / (k + 1.0)};
}

/* Second-order high pass of quality q, bilinear. */
static section second_order(double hz, double q, double dt)
{
    const double k = tan(0.5 * TWO_PI * hz * dt);
    const double norm = 1.0 / (1.0 + k / q + k * k);
    return (section){.b0 = norm,
                     .b1 = -2.0 * norm,
                     .b2 = norm,
                     .a1 = 2.0 * (k * k - 1.0) * norm,
                     .a2 = (1.0 - k / q + k * k) * norm};
}

/* Runs two sections over positions or forces, starting at rest at the first row. */
static void high_pass(const ss_felt_row *row, int64_t count, bool is_force, const section stage[2],
                      double (*out)[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const double start = is_force ? row[0].f[axis] : row[0].x[axis];
        double x1[2] = {0}, x2[2] = {0}, y1[2] = {0}, y2[2] = {0};
        for (int64_t i = 0; i < count; ++i) {
            double x = (is_force ? row[i].f[axis] : row[i].x[axis]) - start;
            for (int k = 0; k < 2; ++k) {
                const section *s = &stage[k];
                const double y =
                    s->b0 * x + s->b1 * x1[k] + s->b2 * x2[k] - s->a1 * y1[k] - s->a2 * y2[k];
                x2[k] = x1[k];
                x1[k] = x;
                y2[k] = y1[k];
                y1[k] = y;
                x = y;
            }
            out[i][axis] = x;
        }
    }
}

/* x above 15 Hz by a Butterworth filter of fourth order (a hand trembles at 8 to 12 Hz: two
 * first-order stages let a quarter of that through), F above 30 Hz by two first-order stages. */
static void filter(const ss_felt_row *row, int64_t count, scratch *work)
{
    const double dt = (row[count - 1].time_s - row[0].time_s) / (double)(count - 1);
    const section chatter[2] = {second_order(CHATTER_HZ, 0.54119610, dt),
                                second_order(CHATTER_HZ, 1.30656296, dt)};
    const section buzz[2] = {first_order(BUZZ_HZ, dt), first_order(BUZZ_HZ, dt)};
    high_pass(row, count, false, chatter, work->high);
    high_pass(row, count, true, buzz, work->rough);
}

static void smooth(const ss_felt_row *row, int64_t count, double (*out)[3])
{
    ss_copy3(out[0], row[0].x);
    for (int64_t i = 1; i < count; ++i) {
        const double alpha = alpha_of(row, i, SMOOTH_HZ);
        for (int axis = 0; axis < 3; ++axis) {
            out[i][axis] = out[i - 1][axis] + alpha * (row[i].x[axis] - out[i - 1][axis]);
        }
    }
    for (int64_t i = count - 1; i > 0; --i) {
        const double alpha = alpha_of(row, i, SMOOTH_HZ);
        for (int axis = 0; axis < 3; ++axis) {
            out[i - 1][axis] = out[i][axis] + alpha * (out[i - 1][axis] - out[i][axis]);
        }
    }
}

static void find_contacts(const ss_felt_row *row, int64_t count, scratch *work)
{
    int64_t first = -1;
    for (int64_t i = 0; i <= count; ++i) {
        const bool is_in = i < count && ss_norm3(row[i].f) > CONTACT_FORCE;
        if (is_in && first < 0) {
            first = i;
        }
        if (!is_in && first >= 0) {
            if (i - first >= SHORTEST_CONTACT) {
                work->contact[work->contact_count++] = (span){first, i - 1};
            }
            first = -1;
        }
    }
}

static ss_felt_verdict judge(double value, double good, double bad)
{
    return value < good ? SS_FELT_GOOD : value > bad ? SS_FELT_BAD : SS_FELT_FAIR;
}

/* Good while no contact hands out more than 1 mJ or 5 % of what it had taken at its peak. */
static void judge_energy(const ss_felt_row *row, int64_t count, const scratch *work, ss_felt *out)
{
    double least = INFINITY;
    bool is_bad = false;
    for (int64_t c = 0; c < work->contact_count; ++c) {
        double energy = 0.0;
        double peak = 0.0;
        for (int64_t i = work->contact[c].first; i <= work->contact[c].last && i + 1 < count; ++i) {
            double move[3];
            ss_sub3(move, row[i + 1].x, row[i].x);
            energy -= ss_dot3(row[i].f, move);
            peak = fmax(peak, energy);
        }
        least = fmin(least, energy);
        is_bad = is_bad || energy < -fmax(1e-3, 0.05 * peak);
    }
    if (work->contact_count > 0) {
        out->net_energy_j.value = least;
        out->net_energy_j.verdict = is_bad ? SS_FELT_BAD : SS_FELT_GOOD;
    }
}

/* Root mean square of a filtered vector over rows first..last. */
static double rms(double (*value)[3], int64_t first, int64_t last)
{
    double sum = 0.0;
    for (int64_t i = first; i <= last; ++i) {
        sum += ss_dot3(value[i], value[i]);
    }
    return sqrt(sum / (double)(last - first + 1));
}

static bool is_still(const scratch *work, const double n[3], int64_t first, int64_t last)
{
    double low = INFINITY;
    double high = -INFINITY;
    for (int64_t i = first; i <= last; ++i) {
        const double x = ss_dot3(n, work->smooth[i]);
        low = fmin(low, x);
        high = fmax(high, x);
    }
    return high - low <= STILL_M;
}

/* One window, seen along its mean force: amplitude of x above 15 Hz, its frequency from the zero
 * crossings, and the rough part of the force. */
static void judge_window(const ss_felt_row *row, const scratch *work, int64_t first, int64_t last,
                         ss_felt *out)
{
    const double count = (double)(last - first + 1);
    double n[3] = {0};
    double mean = 0.0;
    for (int64_t i = first; i <= last; ++i) {
        ss_add3(n, n, row[i].f);
        mean += ss_norm3(row[i].f) / count;
    }
    ss_normalize3(n);
    if (!is_still(work, n, first, last)) {
        return;
    }
    double power = 0.0;
    double crossings = 0.0;
    double before = ss_dot3(n, work->high[first]);
    for (int64_t i = first; i <= last; ++i) {
        const double x = ss_dot3(n, work->high[i]);
        power += x * x / count;
        crossings += (x > 0.0) != (before > 0.0);
        before = x;
    }
    const double chatter = sqrt(2.0 * power);
    if (chatter >= out->chatter_m.value) {
        out->chatter_m.value = chatter;
        out->chatter_hz = 0.5 * crossings / (row[last].time_s - row[first].time_s);
    }
    out->chatter_m.verdict = judge(out->chatter_m.value, 0.05e-3, 0.1e-3);
    out->buzz.value = fmax(out->buzz.value, rms(work->rough, first, last) / mean);
    out->buzz.verdict = judge(out->buzz.value, 0.01, 0.03);
}

/* Windows half overlapped, wholly inside one contact. */
static void judge_windows(const ss_felt_row *row, const scratch *work, ss_felt *out)
{
    for (int64_t c = 0; c < work->contact_count; ++c) {
        const span contact = work->contact[c];
        int64_t last = contact.first;
        double start = row[contact.first].time_s;
        for (int64_t first = contact.first; first <= contact.last; ++first) {
            if (row[first].time_s < start) {
                continue;
            }
            while (last <= contact.last && row[last].time_s < row[first].time_s + WINDOW_S) {
                ++last;
            }
            if (last > contact.last) {
                break;
            }
            judge_window(row, work, first, last, out);
            start = row[first].time_s + 0.5 * WINDOW_S;
        }
    }
}

static double quantile(double *sample, int64_t count, double q)
{
    qsort(sample, (size_t)count, sizeof *sample, ss_compare_doubles);
    int64_t rank = (int64_t)ceil(q * (double)count) - 1;
    rank = rank < 0 ? 0 : rank;
    return sample[rank];
}

/* |dF - median of dF over 11 rows around it|, by axis. */
static double step_beyond_trend(const ss_felt_row *row, int64_t i)
{
    double beyond[3];
    for (int axis = 0; axis < 3; ++axis) {
        double change[MEDIAN];
        for (int k = 0; k < MEDIAN; ++k) {
            const ss_felt_row *at = &row[i + k - MEDIAN / 2];
            change[k] = at->f[axis] - (at - 1)->f[axis];
        }
        const double own = change[MEDIAN / 2];
        qsort(change, MEDIAN, sizeof *change, ss_compare_doubles);
        beyond[axis] = own - change[MEDIAN / 2];
    }
    return ss_norm3(beyond);
}

static void judge_continuity(const ss_felt_row *row, const scratch *work, ss_felt *out)
{
    int64_t steps = 0;
    for (int64_t c = 0; c < work->contact_count; ++c) {
        const span contact = work->contact[c];
        for (int64_t i = contact.first + MARGIN + 1; i + MARGIN <= contact.last; ++i) {
            work->sample[steps++] = step_beyond_trend(row, i);
        }
    }
    if (steps == 0) {
        return;
    }
    const double step = quantile(work->sample, steps, 0.99);
    int64_t forces = 0;
    for (int64_t c = 0; c < work->contact_count; ++c) {
        for (int64_t i = work->contact[c].first; i <= work->contact[c].last; ++i) {
            work->sample[forces++] = ss_norm3(row[i].f);
        }
    }
    out->continuity.value = step / quantile(work->sample, forces, 0.995);
    out->continuity.verdict = judge(out->continuity.value, 0.05, 0.08);
}

static void judge_bounces(const ss_felt_row *row, int64_t count, const scratch *work,
                          const ss_felt_options *options, ss_felt *out)
{
    int64_t ended = work->contact_count;
    if (ended > 0 && work->contact[ended - 1].last == count - 1) {
        --ended;
    }
    int64_t most = 0;
    int64_t oldest = 0;
    for (int64_t c = 0; c < ended; ++c) {
        const double end = row[work->contact[c].last].time_s;
        while (row[work->contact[oldest].last].time_s < end - 1.0) {
            ++oldest;
        }
        most = c - oldest + 1 > most ? c - oldest + 1 : most;
    }
    const double beyond = (double)(most - options->intended_contacts);
    out->bounces.value = (double)most;
    out->bounces.verdict = beyond <= 2.0 ? SS_FELT_GOOD : beyond > 4.0 ? SS_FELT_BAD : SS_FELT_FAIR;
}

static void judge_age(const ss_felt_row *row, int64_t count, const scratch *work,
                      const ss_felt_options *options, ss_felt *out)
{
    int64_t predicted = 0;
    for (int64_t i = 0; i < count; ++i) {
        work->sample[i] = (double)row[i].age_us;
        predicted += (row[i].flags & SOFTSIM_FORCE_PREDICTED) != 0;
    }
    out->predicted_share = (double)predicted / (double)count;
    out->age_p99_us.value = quantile(work->sample, count, 0.99);
    if (options->age_limit_us > 0.0) {
        out->age_p99_us.verdict =
            out->age_p99_us.value <= options->age_limit_us ? SS_FELT_GOOD : SS_FELT_BAD;
    }
}

static bool are_rows_good(const ss_felt_row *row, int64_t count)
{
    for (int64_t i = 0; i < count; ++i) {
        if (!isfinite(row[i].time_s) || !ss_is_finite(row[i].x, 3) || !ss_is_finite(row[i].f, 3) ||
            (i > 0 && row[i].time_s <= row[i - 1].time_s)) {
            return false;
        }
    }
    return count >= 2;
}

const char *ss_felt_verdict_name(ss_felt_verdict verdict)
{
    switch (verdict) {
    case SS_FELT_GOOD:
        return "good";
    case SS_FELT_FAIR:
        return "fair";
    case SS_FELT_BAD:
        return "bad";
    case SS_FELT_NONE:
        break;
    }
    return "-";
}

softsim_status ss_felt_judge(const ss_felt_row *row, int64_t count, const ss_felt_options *options,
                             ss_felt *out_felt)
{
    memset(out_felt, 0, sizeof *out_felt);
    if (!are_rows_good(row, count)) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    const size_t size = (size_t)count;
    scratch work = {.contact = calloc(size / SHORTEST_CONTACT + 1, sizeof *work.contact),
                    .smooth = calloc(size, sizeof *work.smooth),
                    .high = calloc(size, sizeof *work.high),
                    .rough = calloc(size, sizeof *work.rough),
                    .sample = calloc(size, sizeof *work.sample)};
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (work.contact != NULL && work.smooth != NULL && work.high != NULL && work.rough != NULL &&
        work.sample != NULL) {
        find_contacts(row, count, &work);
        smooth(row, count, work.smooth);
        filter(row, count, &work);
        out_felt->contacts = (int32_t)work.contact_count;
        judge_energy(row, count, &work, out_felt);
        judge_windows(row, &work, out_felt);
        judge_continuity(row, &work, out_felt);
        judge_bounces(row, count, &work, options, out_felt);
        judge_age(row, count, &work, options, out_felt);
        status = SOFTSIM_OK;
    }
    SS_EACH(free, work.contact, work.smooth, work.high, work.rough, work.sample);
    return status;
}
