/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/samples.h"
#include "rt/order.h"

#include <math.h>
#include <stdlib.h>

bool ss_samples_init(ss_samples *samples, int64_t capacity)
{
    *samples = (ss_samples){.value = calloc((size_t)capacity, sizeof *samples->value)};
    if (samples->value == NULL) {
        return false;
    }
    samples->capacity = capacity;
    for (int64_t i = 0; i < capacity; ++i) {
        samples->value[i] = NAN; /* a write, so that no page is missing later */
    }
    return true;
}

void ss_samples_fini(ss_samples *samples)
{
    free(samples->value);
    *samples = (ss_samples){0};
}

void ss_samples_add(ss_samples *samples, double value)
{
    if (samples->count == samples->capacity) {
        ++samples->dropped;
        return;
    }
    samples->value[samples->count++] = value;
    samples->is_sorted = false;
}

double ss_samples_quantile(ss_samples *samples, double quantile)
{
    if (samples->count == 0) {
        return NAN;
    }
    if (!samples->is_sorted) {
        qsort(samples->value, (size_t)samples->count, sizeof *samples->value, ss_compare_doubles);
        samples->is_sorted = true;
    }
    /* The rank is rounded with a hair of slack: 0.99 x 100 is not quite 99 in binary. */
    const int64_t rank = (int64_t)ceil(quantile * (double)samples->count - 1e-9) - 1;
    const int64_t last = samples->count - 1;
    return samples->value[rank < 0 ? 0 : rank > last ? last : rank];
}
