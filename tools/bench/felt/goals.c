/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/goals.h"

#include <math.h>

/* Shares of the mean force, ms and radii of the tool; the texts below say them in words. */
#define POKE     0.1
#define IMPULSE  0.05
#define PEAK     0.1
#define TOUCH_MS 1.0
#define DEPTH    0.1
#define SAME     1e-3 /* two errors that differ by less are equal */

static bool misses_held(const ss_felt_row *r)
{
    return fabs(r->e.held) > SS_FELT_GOOD_HELD;
}

static bool misses_static(const ss_felt_row *r)
{
    return fabs(r->static_error) > SS_FELT_GOOD_STATIC;
}

static bool misses_noticeable(const ss_felt_row *r)
{
    return r->e.p99 > SS_FELT_GOOD_P99;
}

static bool misses_poke(const ss_felt_row *r)
{
    return r->e.p99 > POKE;
}

static bool misses_fast_poke(const ss_felt_row *r)
{
    return r->e.p95 > POKE;
}

static bool misses_tap(const ss_felt_row *r)
{
    return fabs(r->e.impulse) > IMPULSE || fabs(r->e.peak) > PEAK || fabs(r->e.touch_ms) > TOUCH_MS;
}

static bool misses_hold(const ss_felt_row *r)
{
    return r->e.p99 > r->hold_p99 + SAME;
}

static bool misses_depth(const ss_felt_row *r)
{
    return r->penetration > DEPTH;
}

#define PATHS(p, q, r, t, s)                                                                       \
    {                                                                                              \
        [SS_FELT_PRESS] = p, [SS_FELT_POKE_1] = q, [SS_FELT_POKE_3] = r, [SS_FELT_TAP] = t,        \
        [SS_FELT_SLIDE] = s                                                                        \
    }
const ss_felt_goal ss_felt_goals[SS_FELT_GOALS] = {
    {"held", "a press is held within 2 % of the force at 1000 Hz", PATHS(1, 0, 0, 0, 0), 0.0, false,
     misses_held},
    {"static", "and within 3 % of the static solution", PATHS(1, 0, 0, 0, 0), 0.0, false,
     misses_static},
    {"press", "p99 of a press up to 7 %, from 58 Hz on", PATHS(1, 0, 0, 0, 0), 58.0, false,
     misses_noticeable},
    {"slide", "p99 of a slide up to 7 %, from 58 Hz on", PATHS(0, 0, 0, 0, 1), 58.0, false,
     misses_noticeable},
    {"poke", "p99 of a poke of 0.1 m/s up to 10 %, from 58 Hz on", PATHS(0, 1, 0, 0, 0), 58.0,
     false, misses_poke},
    {"fast poke", "p95 of a poke of 0.3 m/s up to 10 %, from 300 Hz on", PATHS(0, 0, 1, 0, 0),
     300.0, false, misses_fast_poke},
    {"tap", "impulse of taps within 5 %, peak 10 %, each touch 1 ms, from 300 Hz on",
     PATHS(0, 0, 0, 1, 0), 300.0, false, misses_tap},
    {"no-worse-than-hold", "nowhere further off than forces held from the last result",
     PATHS(1, 1, 1, 1, 1), 0.0, true, misses_hold},
    {"depth", "the tool less than 0.1 of its radius deep at the working force",
     PATHS(1, 0, 0, 0, 0), 0.0, false, misses_depth},
};

bool ss_felt_has_goal(const ss_felt_goal *g, ss_felt_path path, double rate_hz, int32_t delay_ms)
{
    return g->has_path[path] && rate_hz >= g->from_hz && rate_hz < SS_FELT_REFERENCE_HZ &&
           (g->any_delay || delay_ms == 0);
}
