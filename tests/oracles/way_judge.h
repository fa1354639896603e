/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Judges any way of a hand at haptic.max_force_n from outside, by poses and forces, beside the same
 * way without a limit ("open").
 *
 * The limit L is reached in the tick whose |F| is .999 L. From there on, while the hand is deeper
 * than it was then and the open way has at least L, the force stays: .99 L <= |F| <= 1.0001 L, it
 * turns by at most 1 degree a tick and steps by at most 2 % of L, both beyond what the open way has
 * within WINDOW ticks. Tissue may give way under the limit (it creeps, or the hand slides to a
 * softer place): where its own reaction is below L the force may leave the limit, but not by a
 * step; until it is there again nothing but steps is judged. A hand that moves at v may step by
 * k |v| T, k the stiffness that it was told to feel last. After a limit that was changed the force
 * has CHANGE ticks to follow.
 */
#include "limit_judge.h"

enum { WAY_WINDOW = 5, WAY_CHANGE = 400 };

typedef struct way_tick {
    double x[3];    /* m, of the hand */
    double turn[3]; /* rad, since the tick before */
    double depth;   /* m */
    double limit;   /* N, as it was set */
    double force[3], torque[3];
    double slip;      /* m, from the hand to the proxy */
    double model;     /* N, the tissue's own reaction */
    double stiffness; /* N/m, told; 0 where none was */
} way_tick;

typedef struct way_verdict {
    int judged;
    double least, most;             /* |F| / L */
    double turn;                    /* degrees a tick, beyond the open way */
    double step;                    /* |dF| / L, the same */
    double energy;                  /* J, the most that a contact has handed out */
    double slip;                    /* m */
    int at_least, at_turn, at_step; /* ticks */
} way_verdict;

static inline double way_step(const way_tick *tick)
{
    double change = 0.0;
    for (int a = 0; a < 3; ++a) {
        change = hypot(change, tick[0].force[a] - tick[-1].force[a]);
    }
    return change;
}

static inline double way_speed(const way_tick *tick)
{
    double way = 0.0;
    for (int a = 0; a < 3; ++a) {
        way = hypot(way, tick[0].x[a] - tick[-1].x[a]);
    }
    return way;
}

/* What the hand was given in the tick before `tick`, J. */
static inline double way_energy(const way_tick *tick)
{
    double given = 0.0;
    for (int a = 0; a < 3; ++a) {
        given += tick[-1].force[a] * (tick[0].x[a] - tick[-1].x[a]);
        given += tick[-1].torque[a] * tick[0].turn[a];
    }
    return given;
}

/* The largest turn and step of the open way about tick i. */
static inline void way_open(const way_tick *open, int i, int count, double *turn, double *step)
{
    *turn = *step = 0.0;
    for (int k = i - WAY_WINDOW; k <= i + WAY_WINDOW; ++k) {
        if (k > 0 && k < count) {
            *turn = fmax(*turn, limit_angle(open[k - 1].force, open[k].force));
            *step = fmax(*step, way_step(open + k));
        }
    }
}

static inline way_verdict judge_way(const way_tick *tick, const way_tick *open, int count)
{
    way_verdict v = {.least = 1.0};
    double stiffness = 0.0, energy = 0.0, entry = 0.0, before = tick[0].limit;
    bool is_at_limit = false, has_been = false;
    int changed = -WAY_CHANGE;
    for (int i = 1; i < count; ++i) {
        const double size = limit_norm(tick[i].force);
        stiffness = fmax(tick[i].stiffness, open[i].stiffness) > 0.0
                        ? fmax(tick[i].stiffness, open[i].stiffness)
                        : stiffness;
        energy = limit_norm(tick[i - 1].force) > 0.0 ? energy + way_energy(tick + i) : 0.0;
        v.energy = fmax(v.energy, energy);
        v.slip = fmax(v.slip, tick[i].slip);
        if (fabs(tick[i].limit - tick[i - 1].limit) > 0.0) {
            changed = i;
            before = fmin(size, tick[i - 1].limit);
        }
        const bool is_changing = i < changed + WAY_CHANGE;
        const double limit = tick[i].limit;
        const double bound = is_changing ? fmax(before, limit) : limit;
        v.most = fmax(v.most, size / bound);
        if (is_changing) {
            is_at_limit = has_been = false;
            continue;
        }
        if (!is_at_limit && size >= 0.999 * limit) {
            entry = has_been ? entry : tick[i].depth;
            is_at_limit = has_been = true;
            continue;
        }
        double turn, step;
        way_open(open, i, count, &turn, &step);
        const bool is_beyond =
            tick[i].depth > entry && limit_norm(open[i].force) >= limit && has_been;
        has_been = has_been && size > 0.0;
        if (!is_beyond) {
            is_at_limit = false;
            continue;
        }
        const double moved = stiffness * way_speed(tick + i);
        const double stepped = (way_step(tick + i) - fmax(step, moved)) / limit;
        if (stepped > v.step) {
            v.step = stepped;
            v.at_step = i;
        }
        if (size < 0.99 * limit && tick[i + 1 < count ? i + 1 : i].model < limit) {
            is_at_limit = false;
        }
        if (!is_at_limit) {
            continue;
        }
        ++v.judged;
        if (size / limit < v.least) {
            v.least = size / limit;
            v.at_least = i;
        }
        const double turned = limit_angle(tick[i - 1].force, tick[i].force) - turn;
        if (turned > v.turn) {
            v.turn = turned;
            v.at_turn = i;
        }
    }
    return v;
}

/* What is wrong with it: letters; "" nothing. */
static inline const char *way_faults(const way_verdict *v, double energy, double slip)
{
    static char text[16];
    (void)snprintf(text, sizeof text, "%s%s%s%s%s%s", v->least >= 0.99 ? "" : "<",
                   v->most <= 1.0001 ? "" : ">", v->turn <= 1.0 ? "" : "T",
                   v->step <= 0.02 ? "" : "S", v->energy <= energy ? "" : "E",
                   v->slip <= slip ? "" : "P");
    return text;
}
