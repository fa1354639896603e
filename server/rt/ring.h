/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Ring: every record in order from one writer thread to one reader thread, bounded, wait-free.
 * A full ring refuses the record and counts it. Indices on cache lines of their own.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ss_ring ss_ring;

/* Thread: set-up only. Capacity is rounded up to a power of two. NULL when out of memory. */
ss_ring *ss_ring_create(size_t record_size, uint32_t capacity);
void ss_ring_destroy(ss_ring **ring);

/* Writer thread; RT-safe. False (and counted) when full. */
bool ss_ring_push(ss_ring *ring, const void *record);
/* Writer thread; RT-safe. Would the next push be taken? */
bool ss_ring_has_room(ss_ring *ring);
/* Reader thread; RT-safe. False when empty. */
bool ss_ring_pop(ss_ring *ring, void *out_record);
/* Any thread; RT-safe. */
uint64_t ss_ring_refused(const ss_ring *ring);
