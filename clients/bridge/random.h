/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* SplitMix64 (Steele, Lea, Flood 2014): one word of state, the same numbers everywhere. */
#include <stdint.h>

static inline uint64_t ss_random_next(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* Uniform in [0, 1), from the top 53 bits. */
static inline double ss_random_unit(uint64_t *state)
{
    return (double)(ss_random_next(state) >> 11) * 0x1p-53;
}
