/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_scene.h"
/*
 * What no careful hand does with a tool in contact, and some tracker or script will: noise, in and
 * out at half the rate of the loop, through the body at any speed, across it, a spin, commands
 * between all poses. The tool goes down to a usual press, is abused for `abuse_s`, and goes up
 * again; what passes through has no press. All of it is a function of time, without a state.
 */
#include <math.h>

#include "rt/random.h"
#include "rt/vec.h"

static const double press_m = 0.005; /* depth of the usual press */
static const double approach_speed = 0.2;
static const double free_m = 0.03; /* above the body */
static const double abuse_s = 0.3;
static const double lift_m = 0.002; /* out of contact, of in and out */
static const double swipe_m = 0.16; /* from side to side */
static const double poke_hz = 5.0;  /* while it is paused and resumed */
static const double poke_m = 0.004;
#define TWO_PI (2.0 * SS_PI)

bool ss_stress_case_is_abuse(ss_stress_case_kind kind)
{
    return kind >= SS_STRESS_CASE_NOISE && kind <= SS_STRESS_CASE_PAUSE;
}

void ss_stress_case_abuse_plan(ss_stress_case_plan *plan)
{
    const ss_stress_case *trial = plan->trial;
    const double top =
        plan->specimen.rest[SS_STRESS_CASE_TOP_CENTRE][2] + SS_STRESS_CASE_TOOL_RADIUS;
    if (trial->kind == SS_STRESS_CASE_THROUGH && trial->variant < 2) {
        const double down = -top - free_m, way_s = (top + free_m - down) / trial->value;
        ss_stress_case_plan_go(plan, 0.0, 0.0, top + free_m);
        ss_stress_case_plan_go(plan, 0.05, 0.0, top + free_m);
        ss_stress_case_plan_go(plan, way_s, 0.0, down);
        ss_stress_case_plan_go(plan, 0.05, 0.0, down);
        ss_stress_case_plan_go(plan, way_s, 0.0, top + free_m);
        return;
    }
    const double way_s = (press_m + free_m) / approach_speed;
    ss_stress_case_plan_go(plan, 0.0, 0.0, top + free_m);
    ss_stress_case_plan_go(plan, way_s, 0.0, top - press_m);
    ss_stress_case_plan_go(plan, abuse_s, 0.0, top - press_m);
    ss_stress_case_plan_go(plan, way_s, 0.0, top + free_m);
    plan->abused_s[0] = way_s;
    plan->abused_s[1] = way_s + abuse_s;
}

void ss_stress_case_abuse(const ss_stress_case_plan *plan, double time_s, int32_t tick,
                          double position[3], double orientation[4])
{
    const ss_stress_case *trial = plan->trial;
    const double since_s = time_s - plan->abused_s[0];
    if (!(time_s > plan->abused_s[0] && time_s < plan->abused_s[1])) {
        return;
    }
    switch (trial->kind) {
    case SS_STRESS_CASE_NOISE:
        for (int axis = 0; axis < 3; ++axis) {
            position[axis] +=
                trial->value * ss_random_signed_at(3 * (uint64_t)tick + (uint64_t)axis);
        }
        break;
    case SS_STRESS_CASE_IN_OUT:
        position[2] += 0.5 * (press_m + lift_m) * (1.0 - cos(TWO_PI * trial->value * since_s));
        break;
    case SS_STRESS_CASE_THROUGH: /* across */
        position[0] +=
            swipe_m / TWO_PI * 2.0 * asin(sin(TWO_PI * 0.5 * trial->value / swipe_m * since_s));
        break;
    case SS_STRESS_CASE_SPIN: {
        const double half = 0.5 * TWO_PI * trial->value * since_s;
        orientation[0] = cos(half);
        orientation[trial->variant == 0 ? 3 : 2] = sin(half);
        break;
    }
    default: /* SS_STRESS_CASE_PAUSE */
        position[2] += 0.5 * poke_m * (1.0 - cos(TWO_PI * poke_hz * since_s));
        break;
    }
}

int32_t ss_stress_case_commands(const ss_stress_case_plan *plan, double time_s, double period_s)
{
    const double rate = plan->trial->value * period_s;
    return plan->trial->kind == SS_STRESS_CASE_PAUSE && time_s > plan->abused_s[0] &&
                   time_s < plan->abused_s[1]
               ? (int32_t)(floor(rate * round(time_s / period_s)) -
                           floor(rate * (round(time_s / period_s) - 1.0)))
               : 0;
}
