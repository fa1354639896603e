/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/supply.h"

#include <math.h>

/* fmax and fmin are calls: with them a tick of the watch in contact took 95 ns, with these 60. */
static inline double more_of(double a, double b)
{
    return a > b ? a : b;
}

static inline double less_of(double a, double b)
{
    return a < b ? a : b;
}

static double settle(ss_supply *supply, const ss_supply_span *span)
{
    double made = 0.0;
    if (!span->is_known) {
        return made;
    }
    for (int d = 0; d < SS_SUPPLY_DEVICES; ++d) {
        const double floor = span->low[d] + span->stored;
        made = more_of(made, span->rise[d] - span->stored);
        if (supply->has_floor) {
            made = more_of(made, span->top[d] - supply->floor[d]);
        }
        supply->floor[d] = supply->has_floor ? less_of(supply->floor[d], floor) : floor;
    }
    supply->has_floor = true;
    return made;
}

/* A span that begins with the next tick. */
static ss_supply_span begin(double stored, bool is_known)
{
    ss_supply_span span = {.is_known = is_known, .stored = stored};
    for (int d = 0; d < SS_SUPPLY_DEVICES; ++d) {
        span.low[d] = (double)INFINITY;
        span.top[d] = -(double)INFINITY;
    }
    return span;
}

double ss_supply_clear(ss_supply *supply)
{
    double made = settle(supply, &supply->span[1]);
    made = more_of(made, settle(supply, &supply->span[0]));
    /* The span begins before the first touch, with nothing given and nothing in the coupling. */
    *supply = (ss_supply){
        .is_known = supply->is_known,
        .stored = supply->stored,
        .span = {{.is_known = supply->span[0].is_known, .stored = supply->span[0].stored}}};
    return made;
}

double ss_supply_take(ss_supply *supply, double stored, bool is_known)
{
    for (int k = 0; k < 2; ++k) {
        ss_supply_span *span = &supply->span[k];
        span->stored = fmax(span->stored, stored); /* which may be no number */
        span->is_known = span->is_known && is_known;
    }
    const double made = settle(supply, &supply->span[1]);
    supply->span[1] = supply->span[0];
    supply->span[0] = begin(fmax(supply->stored, stored), supply->is_known && is_known);
    supply->stored = stored;
    supply->is_known = is_known;
    return made;
}

void ss_supply_tick(ss_supply *supply, const double given[SS_SUPPLY_DEVICES], double others,
                    double coupling)
{
    ss_supply_span *span = &supply->span[0];
    for (int d = 0; d < SS_SUPPLY_DEVICES; ++d) {
        supply->energy[d] += given[d] - others;
        const double energy = supply->energy[d];
        span->rise[d] = more_of(span->rise[d], energy - span->low[d]);
        span->low[d] = less_of(span->low[d], energy + coupling);
        span->top[d] = more_of(span->top[d], energy);
    }
}
