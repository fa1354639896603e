/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A bounded reader of LCM's encoding: a type's hash, then its fields without gaps, big-endian; a
 * string is its length with the NUL, then its bytes. The generated decoders trust what a length
 * says. Once something was wrong, all that is read is 0. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef struct ss_reader {
    const uint8_t *at;
    int64_t left; /* bytes */
    bool has_failed;
} ss_reader;

static inline uint64_t ss_read(ss_reader *r, int bytes)
{
    if (r->has_failed || r->left < bytes) {
        r->has_failed = true;
        return 0;
    }
    uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) {
        value = value << 8 | r->at[i];
    }
    r->at += bytes;
    r->left -= bytes;
    return value;
}

static inline int64_t ss_read_int64(ss_reader *r)
{
    return (int64_t)ss_read(r, 8);
}

static inline int32_t ss_read_int32(ss_reader *r)
{
    return (int32_t)(uint32_t)ss_read(r, 4);
}

static inline float ss_read_float(ss_reader *r)
{
    const uint32_t bits = (uint32_t)ss_read(r, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline double ss_read_double(ss_reader *r)
{
    const uint64_t bits = ss_read(r, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
