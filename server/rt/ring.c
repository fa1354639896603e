/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Lamport's single-producer single-consumer queue (1983) with free-running 32-bit indices: head
 * counts pushes, tail counts pops, head - tail is the fill, and both wrap by unsigned arithmetic.
 * Each side keeps its last sight of the other's index, so that the line of the other side is read
 * only when the ring looks full or empty.
 */
#include "rt/ring.h"

#include <stdalign.h>
#include <stdatomic.h>
#include <string.h>

#include "rt/each.h"
#include "rt/memory.h"

enum { LINE = 64 };

struct ss_ring {
    char *records;
    size_t record_size;
    uint32_t mask;                            /* capacity - 1 */
    alignas(LINE) atomic_uint_least32_t head; /* writer's */
    uint32_t seen_tail;
    atomic_uint_least64_t refused;
    alignas(LINE) atomic_uint_least32_t tail; /* reader's */
    uint32_t seen_head;
};

ss_ring *ss_ring_create(size_t record_size, uint32_t capacity)
{
    if (capacity == 0 || capacity > (UINT32_MAX >> 1) + 1u) {
        return NULL;
    }
    uint32_t rounded = 1;
    while (rounded < capacity) {
        rounded <<= 1;
    }
    ss_ring *ring = ss_memory_get(1, sizeof *ring);
    if (ring == NULL) {
        return NULL;
    }
    ring->record_size = record_size;
    ring->mask = rounded - 1;
    ring->records = ss_memory_get(rounded, record_size);
    if (ring->records == NULL) {
        ss_memory_free(ring);
        return NULL;
    }
    atomic_init(&ring->head, 0);
    atomic_init(&ring->tail, 0);
    atomic_init(&ring->refused, 0);
    return ring;
}

void ss_ring_destroy(ss_ring **ring)
{
    if (*ring != NULL) {
        SS_EACH(ss_memory_free, (*ring)->records, *ring);
        *ring = NULL;
    }
}

bool ss_ring_has_room(ss_ring *ring)
{
    /* Relaxed: only this thread writes head. */
    const uint32_t head = atomic_load_explicit(&ring->head, memory_order_relaxed);
    if (head - ring->seen_tail > ring->mask) {
        /* Acquire: the reader has copied the records that it gave back (pairs with the release of
         * tail in pop). */
        ring->seen_tail = atomic_load_explicit(&ring->tail, memory_order_acquire);
    }
    return head - ring->seen_tail <= ring->mask;
}

bool ss_ring_push(ss_ring *ring, const void *record)
{
    if (!ss_ring_has_room(ring)) {
        /* Relaxed: a statistic. */
        atomic_fetch_add_explicit(&ring->refused, 1, memory_order_relaxed);
        return false;
    }
    /* Relaxed: only this thread writes head. */
    const uint32_t head = atomic_load_explicit(&ring->head, memory_order_relaxed);
    memcpy(ring->records + (head & ring->mask) * ring->record_size, record, ring->record_size);
    /* Release: the record is visible before the count (pairs with the acquire of head in pop). */
    atomic_store_explicit(&ring->head, head + 1, memory_order_release);
    return true;
}

bool ss_ring_pop(ss_ring *ring, void *out_record)
{
    /* Relaxed: only this thread writes tail. */
    const uint32_t tail = atomic_load_explicit(&ring->tail, memory_order_relaxed);
    if (tail == ring->seen_head) {
        /* Acquire: sees the record behind the count (pairs with the release of head in push). */
        ring->seen_head = atomic_load_explicit(&ring->head, memory_order_acquire);
        if (tail == ring->seen_head) {
            return false;
        }
    }
    memcpy(out_record, ring->records + (tail & ring->mask) * ring->record_size, ring->record_size);
    /* Release: our copy is made before the slot is given back (pairs with the acquire of tail in
     * push). */
    atomic_store_explicit(&ring->tail, tail + 1, memory_order_release);
    return true;
}

uint64_t ss_ring_refused(const ss_ring *ring)
{
    return atomic_load_explicit(&ring->refused, memory_order_relaxed);
}
