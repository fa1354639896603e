/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Judges a press at haptic.max_force_n from outside, by poses and forces alone.
 *
 * Once the force has come to the limit L, it stays there for as long as the tool is deeper than it
 * was then and the same path without a limit gives at least L: |F| within .99 L .. 1.0001 L, its
 * direction turns by at most 1 degree a tick, its steps are at most 2 % of L above those of the
 * path without a limit. On the way out a body that has crept under L gives less a little deeper
 * (`late`), and says so: its own reaction, told a tick after the pose, is below L. From there on
 * only steps are judged, at most 2 % of L above the largest of the other path's way out. Everywhere
 * |F| stays below the limit, and the proxy near the hand.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "softsim/types.h"

typedef struct limit_tick {
    double depth; /* m, along the path from its beginning */
    double force[3];
    double slip;  /* m, from the pose to the proxy */
    double model; /* N, the tissue's own reaction */
} limit_tick;

typedef struct limit_verdict {
    int first;     /* tick at which the limit was reached; -1: never */
    int judged;    /* ticks deeper than that */
    int collapsed; /* of them with less than half the limit */
    int sideways;  /* of them more than 30 degrees off the direction at `first` */
    double late;   /* m deeper than there the force left the limit on the way out */
    double least;  /* |F| / L of them */
    double most;   /* |F| / L of all */
    double turn;   /* degrees a tick, largest */
    double step;   /* |dF| / L above that without a limit, largest */
    double leave;  /* the same after it left the limit */
    double slip;   /* m, largest */
    double model;  /* the tissue's reaction / L, largest */
} limit_verdict;

static inline double limit_norm(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static inline double limit_angle(const double a[3], const double b[3])
{
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
    return atan2(limit_norm(cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 57.29577951308232;
}

static inline double limit_step(const limit_tick *tick)
{
    const double change[3] = {tick[1].force[0] - tick[0].force[0],
                              tick[1].force[1] - tick[0].force[1],
                              tick[1].force[2] - tick[0].force[2]};
    return limit_norm(change);
}

/* `open`: the same path without a limit; from tick `turn` on the path leads out. */
static inline limit_verdict judge_limit(const limit_tick *tick, const limit_tick *open, int count,
                                        int turn, double limit)
{
    limit_verdict v = {.first = -1, .least = 1.0};
    double way_out = 0.0;
    for (int i = turn; i < count; ++i) {
        way_out = fmax(way_out, limit_step(open + i - 1));
    }
    bool is_left = false;
    for (int i = 0; i < count; ++i) {
        const double size = limit_norm(tick[i].force);
        v.most = fmax(v.most, size / limit);
        v.slip = fmax(v.slip, tick[i].slip);
        if (v.first < 0 && size >= 0.999 * limit) {
            v.first = i;
        }
        if (v.first < 0 || i == v.first || tick[i].depth <= tick[v.first].depth) {
            continue;
        }
        const double answer = tick[i + 1 < count ? i + 1 : i].model;
        if (!is_left && i >= turn && size < 0.99 * limit && answer < limit) {
            is_left = true;
            v.late = tick[i].depth - tick[v.first].depth;
        }
        const double allowed = is_left ? way_out : limit_step(open + i - 1);
        const double step = (limit_step(tick + i - 1) - allowed) / limit;
        *(is_left ? &v.leave : &v.step) = fmax(is_left ? v.leave : v.step, step);
        if (is_left || limit_norm(open[i].force) < limit) {
            continue;
        }
        ++v.judged;
        v.collapsed += size < 0.5 * limit;
        v.sideways += limit_angle(tick[i].force, tick[v.first].force) > 30.0;
        v.least = fmin(v.least, size / limit);
        v.model = fmax(v.model, tick[i].model / limit);
        v.turn = fmax(v.turn, limit_angle(tick[i - 1].force, tick[i].force));
    }
    return v;
}

static inline bool is_limit_kept(const limit_verdict *v)
{
    return v->least >= 0.99 && v->most <= 1.0001 && v->turn <= 1.0 && v->step <= 0.02 &&
           v->leave <= 0.02;
}
