/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Poses and forces of a hand along z, and its noise: shared by the tests of what watches and of
 * what judges a hand. */
#include <math.h>
#include <stdint.h>

#include "rt/random.h"
#include "softsim/types.h"

/* -1 .. 1, the same in every run. */
static inline double noise(void)
{
    static uint64_t state;
    return ss_random_signed(&state);
}

static inline softsim_pose at_depth(double depth, int32_t force_seq)
{
    return (softsim_pose){.force_seq = force_seq,
                          .position = {0.0, 0.0, -depth},
                          .orientation = {1.0, 0.0, 0.0, 0.0},
                          .applied_force = {NAN, NAN, NAN}};
}

static inline softsim_force push_up(double force)
{
    return (softsim_force){.force = {0.0, 0.0, force}};
}
