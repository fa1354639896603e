/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Each block is [64-byte header: its size][the caller's bytes]. The header keeps the count exact
 * without a table; 64 bytes keep the caller's part on a cache line. The caller's part ends where
 * the allocation ends, unpadded, so that AddressSanitizer sees an overrun of one byte.
 */
#include "rt/memory.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { ALIGNMENT = 64, PAGE = 4096 };
static const size_t large_page = (size_t)2 << 20; /* bytes */

/* Of the process, as its memory is: who frees a block need not know who asked for it. A statistic:
 * nothing is ordered by it, hence relaxed everywhere. */
static atomic_int_least64_t bytes_in_use;

void ss_memory_ask_large_pages(char *block, size_t bytes)
{
    if (bytes >= large_page) {
        char *begin = block + (PAGE - (uintptr_t)block % PAGE) % PAGE;
        const size_t size = (size_t)(block + bytes - begin);
        (void)madvise(begin, size - size % PAGE, MADV_HUGEPAGE);
    }
}

void *ss_memory_get(size_t count, size_t size)
{
    if (size != 0 && count > ((size_t)PTRDIFF_MAX - ALIGNMENT) / size) {
        return NULL;
    }
    const size_t bytes = count * size;
    void *block = NULL;
    if (posix_memalign(&block, ALIGNMENT, ALIGNMENT + bytes) != 0) {
        return NULL;
    }
    ss_memory_ask_large_pages(block, ALIGNMENT + bytes);
    /* Zeroing also touches every page, so that no loop faults on it later. */
    memset(block, 0, ALIGNMENT + bytes);
    memcpy(block, &bytes, sizeof bytes);
    atomic_fetch_add_explicit(&bytes_in_use, (int64_t)bytes, memory_order_relaxed);
    return (char *)block + ALIGNMENT;
}

void ss_memory_free(void *memory)
{
    if (memory == NULL) {
        return;
    }
    char *block = (char *)memory - ALIGNMENT;
    size_t bytes = 0;
    memcpy(&bytes, block, sizeof bytes);
    atomic_fetch_sub_explicit(&bytes_in_use, (int64_t)bytes, memory_order_relaxed);
    free(block);
}

void *ss_memory_grow(void *memory, int32_t count, int32_t *inout_room, size_t size)
{
    if (count < *inout_room) {
        return memory;
    }
    const int32_t room = *inout_room == 0 ? 4096 : 2 * *inout_room;
    void *larger = ss_memory_get((size_t)room, size);
    if (larger != NULL) {
        if (count > 0) {
            memcpy(larger, memory, (size_t)count * size);
        }
        ss_memory_free(memory);
        *inout_room = room;
    }
    return larger;
}

int64_t ss_memory_in_use(void)
{
    return atomic_load_explicit(&bytes_in_use, memory_order_relaxed);
}

softsim_status ss_memory_fault(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
    return SOFTSIM_ERROR_MEMORY;
}
