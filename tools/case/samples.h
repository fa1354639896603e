/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Every sample of a measurement, for exact percentiles. Memory is taken and touched beforehand, so
 * that a real-time loop may add; what does not fit is counted and left out.
 * Thread: one at a time; ss_samples_add is RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

typedef struct ss_samples {
    double *value;
    int64_t count, capacity, dropped;
    bool is_sorted;
} ss_samples;

/* False when out of memory. */
bool ss_samples_init(ss_samples *samples, int64_t capacity);
/* Accepts what was never initialised but zeroed. */
void ss_samples_fini(ss_samples *samples);
void ss_samples_add(ss_samples *samples, double value);
/* The smallest sample with a share of at least `quantile` (0..1) at or below it; NaN without
 * samples. Sorts in place. */
double ss_samples_quantile(ss_samples *samples, double quantile);
