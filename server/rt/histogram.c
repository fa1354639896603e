/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Bucket 0 holds values up to LEAST; bucket b > 0 holds (LEAST r^(b-1), LEAST r^b], r = 1.02, and
 * answers with its geometric middle, so that a quantile is off by at most 1 %. 1024 buckets reach
 * from 0.01 us to 6.3 s; longer times fall into the last bucket and only the maximum tells them
 * apart. Slots are dropped as a whole: the window is 9 to 10 s long.
 */
#include "rt/histogram.h"

#include <math.h>
#include <string.h>

static const double LEAST_US = 0.01;
static const double LOG_RATIO = 0.019802627296179712; /* ln 1.02 */
static const int64_t SLOT_NS = 1000000000;

static int32_t bucket_of(double value_us)
{
    if (!(value_us > LEAST_US)) {
        return 0;
    }
    const double index = ceil(log(value_us / LEAST_US) / LOG_RATIO);
    return index < SS_HISTOGRAM_BUCKETS - 1 ? (int32_t)index : SS_HISTOGRAM_BUCKETS - 1;
}

static void clear_slot(ss_histogram *histogram, int32_t slot)
{
    for (int32_t b = 0; b < SS_HISTOGRAM_BUCKETS; ++b) {
        histogram->sum[b] -= histogram->count[slot][b];
        histogram->total -= histogram->count[slot][b];
        histogram->count[slot][b] = 0;
    }
    histogram->max_us[slot] = 0.0;
}

void ss_histogram_init(ss_histogram *histogram, int64_t now_ns)
{
    memset(histogram, 0, sizeof *histogram);
    histogram->slot_start_ns = now_ns;
}

void ss_histogram_add(ss_histogram *histogram, int64_t now_ns, double value_us)
{
    int64_t passed = (now_ns - histogram->slot_start_ns) / SLOT_NS;
    if (passed > 0) {
        histogram->slot_start_ns += passed * SLOT_NS;
        passed = passed < SS_HISTOGRAM_SLOTS ? passed : SS_HISTOGRAM_SLOTS;
        for (int64_t i = 0; i < passed; ++i) {
            histogram->slot = (histogram->slot + 1) % SS_HISTOGRAM_SLOTS;
            clear_slot(histogram, histogram->slot);
        }
    }
    const int32_t bucket = bucket_of(value_us);
    histogram->count[histogram->slot][bucket] += 1;
    histogram->sum[bucket] += 1;
    histogram->total += 1;
    if (value_us > histogram->max_us[histogram->slot]) {
        histogram->max_us[histogram->slot] = value_us;
    }
}

double ss_histogram_quantile(const ss_histogram *histogram, double quantile)
{
    double max_us = 0.0;
    for (int32_t s = 0; s < SS_HISTOGRAM_SLOTS; ++s) {
        max_us = fmax(max_us, histogram->max_us[s]);
    }
    const int64_t rank = (int64_t)ceil(quantile * (double)histogram->total);
    if (histogram->total == 0 || rank >= histogram->total) {
        return max_us;
    }
    /* The bucket that holds the sample of that rank. */
    int64_t passed = histogram->sum[0];
    int32_t bucket = 0;
    while (bucket < SS_HISTOGRAM_BUCKETS - 1 && passed < rank) {
        passed += histogram->sum[++bucket];
    }
    const double middle = LEAST_US * exp(LOG_RATIO * ((double)bucket - 0.5));
    return fmin(bucket == 0 ? LEAST_US : middle, max_us);
}
