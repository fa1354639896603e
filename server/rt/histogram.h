/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Percentiles of the last 10 s of a loop's times, without allocation or sorting: counts in
 * logarithmic buckets (2 % wide), in ten slots of one second each. Written by one thread, which
 * also computes the percentiles and passes them on by mailbox. RT-safe throughout.
 */
#include <stdint.h>

enum { SS_HISTOGRAM_BUCKETS = 1024, SS_HISTOGRAM_SLOTS = 10 };

typedef struct ss_histogram {
    int64_t slot_start_ns;
    int32_t slot;
    uint32_t count[SS_HISTOGRAM_SLOTS][SS_HISTOGRAM_BUCKETS];
    /* Of all slots, so that a percentile can be asked for in each step. */
    int64_t sum[SS_HISTOGRAM_BUCKETS], total;
    double max_us[SS_HISTOGRAM_SLOTS];
} ss_histogram;

void ss_histogram_init(ss_histogram *histogram, int64_t now_ns);
void ss_histogram_add(ss_histogram *histogram, int64_t now_ns, double value_us);
/* `quantile` in 0..1; 1 gives the exact maximum; 0 samples give 0. */
double ss_histogram_quantile(const ss_histogram *histogram, double quantile);
