/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Set-up memory: zeroed, 64-byte aligned, counted. Everything a loop touches comes from here
 * before the loops start; ss_memory_in_use() is the status message's bytes_in_use.
 * Thread: set-up only (allocation and release); ss_memory_in_use any thread, RT-safe.
 */
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

/* NULL when out of memory or when count * size overflows; a zero count gives a valid pointer. */
void *ss_memory_get(size_t count, size_t size);
/* Room for one entry more than `count` of an array of *inout_room, twice as much where it is full;
 * NULL when out of memory, and the array stays. */
void *ss_memory_grow(void *memory, int32_t count, int32_t *inout_room, size_t size);
/* Accepts NULL. */
void ss_memory_free(void *memory);
int64_t ss_memory_in_use(void);
/* Asks for large pages where `block` has 2 MB and more: a fault for each page of 4 KB is a third of
 * the start-up of a fine mesh. A refusal does not matter. */
void ss_memory_ask_large_pages(char *block, size_t bytes);
/* Says in `error` that there is no memory left, and returns that status. */
softsim_status ss_memory_fault(softsim_error *error);
