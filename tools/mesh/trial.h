/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A press on a scene in a world of this process, poses in and forces out as a hand feels them: the
 * tool comes down at the place of a touch, is held at a depth until it rests, goes on as deep as
 * the bridge's simulated hand does, and leaves. What it tells is what a scene is judged by before
 * it is called good. A hold's depth is the way of the proxy since it first touched, which the
 * surface went and Hertz's force is for; its indentation the way of the tool since then, a little
 * more, which the bridge tells (clients/common/indentation.h); its force what the hand feels, as a
 * client that corrects for delays does.
 */
#include "contact/touch.h"
#include "world/world.h"

typedef struct trial_press {
    double origin[3];  /* m, of the tool when it just touches */
    double towards[3]; /* unit, out of the tissue */
    double depth;      /* m, at which the force is read */
    double deepest;    /* m, >= depth; the same: the press ends there */
    double limit;      /* N, of the force that a hand gets */
    double expected;   /* N, at the depth, about */
} trial_press;

typedef struct trial_hold {
    double depth, indentation, force; /* m, m, N: at rest */
    double reaction, aside;           /* N, the model's own: against the press, across it */
} trial_hold;

typedef struct trial_result {
    bool has_touched;
    double late;              /* m: the tool touched so much below where it was said to */
    trial_hold held, deepest; /* the last: zeroes of a press that ends at its depth */
    /* N: as the tool came to where it was held, at so many m/s. What inertia and viscosity add. */
    double moving_force, speed;
    bool is_limited; /* the deepest force is the limit's, not the tissue's */
    /* Guarded also where a tool at rest is drawn in or pushed aside, or the force that is held is
     * the limit's; degraded where it hardly touches. */
    softsim_verdict verdict;
    bool is_of_place; /* that alone is why it is not good: no other model would do better */
    char reason[160];
    double step_us, step_us_p99, period_us; /* thread CPU of a step here, and what it may take */
} trial_result;

void trial_run(softsim_world *world, const trial_press *press, trial_result *out);

/* Force (N) of a rigid ball on an elastic half-space (Hertz 1882): 4/3 E/(1 - nu^2) sqrt(R) d^1.5.
 */
double trial_hertz(double youngs_modulus, double poisson_ratio, double radius, double depth);
