/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A simulated bus, one direction: what is sent arrives late, or not at all, but always in order:
 *
 *   arrival = max(previous arrival, sent + delay - jitter ln u)      u uniform in (0, 1]
 *
 * with an outlier of 5 to 20 ms more with probability `outlier`, and loss with probability `loss`.
 * Equal seeds give equal buses. Bounded: a full bus loses what is sent.
 * Thread: one; no allocation after creation.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ss_bus_config {
    double delay_ms, jitter_ms; /* jitter: mean of its exponential part */
    double loss, outlier;       /* probabilities */
    uint64_t seed;
} ss_bus_config;

typedef struct ss_bus ss_bus;

/* NULL when out of memory. */
ss_bus *ss_bus_create(const ss_bus_config *config, size_t record_size);
/* Accepts NULL; nulls. */
void ss_bus_destroy(ss_bus **bus);
/* False when the record is lost. */
bool ss_bus_send(ss_bus *bus, int64_t now_ns, const void *record);
/* When the next record arrives; INT64_MAX when none is under way. */
int64_t ss_bus_due(const ss_bus *bus);
/* Takes the oldest record that has arrived by `now_ns`; false when there is none. */
bool ss_bus_receive(ss_bus *bus, int64_t now_ns, void *out_record);
