/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Numbers near each other, by precision, and random ones. cmocka comes first. */
#include <math.h>
#include <stdint.h>

#include "rt/random.h"

/* By what ss_real is: float or double. */
#ifdef SOFTSIM_DOUBLE
#define BY_TYPE(single, twice) (twice)
#else
#define BY_TYPE(single, twice) (single)
#endif

#define assert_near(a, b, tolerance)                                                               \
    do {                                                                                           \
        const double near_a = (a), near_b = (b), near_t = (tolerance);                             \
        if (!(fabs(near_a - near_b) <= near_t)) {                                                  \
            fail_msg("%s = %.17g, expected %.17g within %.3g", #a, near_a, near_b, near_t);        \
        }                                                                                          \
    } while (0)

/* The same numbers wherever a test sets it. */
static uint64_t random_state = 1;

/* From -1 to 1. */
static inline double random_unit(void)
{
    return ss_random_signed(&random_state);
}
