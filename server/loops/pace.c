/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/pace.h"

#include <math.h>

static const int64_t SLOT_NS = 50000000;
static const int64_t WINDOW_NS = 500000000;
enum { LEAST_STEPS = 4 };

void ss_pace_init(ss_pace *pace, int64_t period_ns)
{
    *pace = (ss_pace){.period_ns = period_ns};
}

void ss_pace_note(ss_pace *pace, int64_t now_ns)
{
    const int64_t last_ns = pace->last_ns;
    pace->last_ns = now_ns;
    if (last_ns == 0) {
        return;
    }
    int64_t newest = (pace->count - 1) % SS_PACE_SLOTS;
    if (pace->count == 0 || pace->slot[newest].end_ns - pace->slot[newest].start_ns >= SLOT_NS) {
        newest = pace->count++ % SS_PACE_SLOTS;
        pace->slot[newest].start_ns = last_ns;
        pace->slot[newest].steps = pace->slot[newest].longest_ns = 0;
    }
    const int64_t took_ns = now_ns - last_ns;
    pace->slot[newest].end_ns = now_ns;
    ++pace->slot[newest].steps;
    if (took_ns > pace->slot[newest].longest_ns) {
        pace->slot[newest].longest_ns = took_ns;
    }
}

double ss_pace_share(const ss_pace *pace)
{
    const int64_t kept = pace->count < SS_PACE_SLOTS ? pace->count : SS_PACE_SLOTS;
    int64_t time_ns = 0, steps = 0, longest_ns = 0;
    for (int64_t back = 1; back <= kept; ++back) {
        const int64_t k = (pace->count - back) % SS_PACE_SLOTS;
        time_ns += pace->slot[k].end_ns - pace->slot[k].start_ns;
        steps += pace->slot[k].steps;
        longest_ns = longest_ns > pace->slot[k].longest_ns ? longest_ns : pace->slot[k].longest_ns;
        if (time_ns >= WINDOW_NS && steps >= LEAST_STEPS) {
            const double simulated = (double)(steps - 1) * (double)pace->period_ns;
            return fmin(1.0, simulated / (double)(time_ns - longest_ns));
        }
    }
    return 1.0;
}
