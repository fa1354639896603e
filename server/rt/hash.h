/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Hashes: of bytes for state and identity (FNV-1a, 64 bits: Fowler, Noll, Vo; RFC 9923), and a
 * step for tables in memory, which mixes 64 bits at once. Thread: any.
 */
#include <stddef.h>
#include <stdint.h>

#define SS_HASH_START UINT64_C(0xcbf29ce484222325)

/* `hash` continued by `size` bytes: h = (h ^ byte) 0x100000001b3. */
static inline uint64_t ss_hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *byte = (const unsigned char *)bytes;
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    }
    return hash;
}

/* `hash` continued by a word, for tables: all bits of it reach the low ones. */
static inline uint64_t ss_hash_word(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * UINT64_C(0x9e3779b97f4a7c15); /* 2^64 over the golden ratio */
    return hash ^ hash >> 29;
}
