/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * SplitMix64 (Steele, Lea, Flood 2014): one word of state, the same numbers everywhere. Any seed
 * does, 0 too. Thread: one at a time for a state.
 */
#include <stdint.h>

#define SS_RANDOM_STEP UINT64_C(0x9e3779b97f4a7c15) /* 2^64 over the golden ratio, odd */

static inline uint64_t ss_random_next(uint64_t *state)
{
    uint64_t z = *state += SS_RANDOM_STEP;
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

/* Uniform in [0, 1), from the top 53 bits. */
static inline double ss_random_unit(uint64_t *state)
{
    return (double)(ss_random_next(state) >> 11) * 0x1p-53;
}

/* Uniform in [-1, 1). */
static inline double ss_random_signed(uint64_t *state)
{
    return (double)(ss_random_next(state) >> 11) * 0x1p-52 - 1.0;
}

/* Uniform in [-1, 1), by a linear congruence: what power iterations start from. */
static inline double ss_random_start(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0 * 2.0 - 1.0;
}

/* The number at `index` of the stream with seed 0, for what is not drawn in order: [-1, 1). */
static inline double ss_random_signed_at(uint64_t index)
{
    uint64_t state = index * SS_RANDOM_STEP;
    return ss_random_signed(&state);
}

/* Whole, in [0, below); the remainder favours no number by more than below / 2^64. */
static inline uint32_t ss_random_below(uint64_t *state, uint32_t below)
{
    return (uint32_t)(ss_random_next(state) % below);
}
