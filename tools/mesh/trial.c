/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "trial.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/vec.h"

/* N: a tool at rest that pushes less is drawn in. */
static const double DRAWN_IN = -1e-3;
static const double ASIDE = 0.4;    /* of the force: the surface slopes by 22 degrees */
static const double HARDLY = 0.2;   /* of the depth: less indentation is no press */
static const double NOTHING = 0.01; /* of what is expected */
static const double LIMITED = 0.95; /* of the limit: the tissue's own force may be more */
/* s: of the parts of a press; a hold lasts until it is at rest. */
static const double COMES = 0.2, DEEPENS = 0.2, LEAVES = 0.2, GONE = 0.3;
/* A hold is at rest when the force of a window is, but for so much, that of the window before: soft
 * tissue in a damped network takes seconds. */
static const double WINDOW = 0.2, LONGEST_HOLD = 12.0, MOVES = 0.0005;

double trial_hertz(double youngs_modulus, double poisson_ratio, double radius, double depth)
{
    return 4.0 / 3.0 * youngs_modulus / (1.0 - poisson_ratio * poisson_ratio) * sqrt(radius) *
           pow(fmax(depth, 0.0), 1.5);
}

/* Where the server itself says no worse: what it says is the model's. */
static void lower_verdict(trial_result *out, softsim_verdict verdict, bool is_of_place,
                          const char *reason)
{
    if (out->verdict < verdict) {
        out->is_of_place = is_of_place && out->verdict == SOFTSIM_VERDICT_GOOD;
        out->verdict = verdict;
        (void)snprintf(out->reason, sizeof out->reason, "%s", reason);
    }
}

/* What the server's own verdict cannot know: what the press was to be. */
static void judge(const trial_press *press, trial_result *out)
{
    out->is_limited = out->deepest.force > LIMITED * press->limit;
    if (!out->has_touched) {
        lower_verdict(out, SOFTSIM_VERDICT_DEGRADED, false,
                      "the tool did not touch: come from another side with --from, or give "
                      "another --tool-mm or --units");
    } else if (out->held.force > LIMITED * press->limit) {
        lower_verdict(out, SOFTSIM_VERDICT_GUARDED, false,
                      "the force limit is felt there, not the tissue: haptic.max_force_n is low "
                      "so that the tool does not sink in; a larger --tool-mm, or a finer mesh");
    } else if (out->held.indentation < HARDLY * press->depth) {
        lower_verdict(out, SOFTSIM_VERDICT_DEGRADED, true,
                      "the tool hardly touched: what is felt lies deeper than the mesh, or it "
                      "slipped off; shorter edges, or another side with --from");
    } else if (fabs(out->held.force) < NOTHING * press->expected) {
        lower_verdict(
            out, SOFTSIM_VERDICT_GUARDED, true,
            "what is pressed gives way as a whole, or lies in the tool's way loosely: hold "
            "it with --fixed");
    } else if (fmin(out->held.reaction, out->deepest.reaction) < DRAWN_IN) {
        lower_verdict(out, SOFTSIM_VERDICT_GUARDED, true,
                      "the force at rest draws the tool in: it slips over an edge or through a "
                      "hole; close holes, or come from another side");
    } else if (out->held.aside > ASIDE * out->held.reaction ||
               out->deepest.aside > ASIDE * out->deepest.reaction) {
        lower_verdict(out, SOFTSIM_VERDICT_GUARDED, true,
                      "the surface slopes there and pushes the tool aside: a hand slides off and "
                      "feels another force; come from another side with --from");
    }
}

/* ---- the press ---- */

typedef struct trial {
    softsim_world *world;
    const trial_press *press;
    trial_result *out;
    double period, touched; /* s; m along the press, where the proxy first touched */
    int32_t tick;
} trial;

/* One tick, with the tool `height` above the touch (below 0 in the tissue); zeroes before touch. */
static trial_hold tick(trial *t, double height)
{
    const int32_t probe = 0;
    const double *towards = t->press->towards;
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_pose pose = {.utime_us = (int64_t)(1e6 * t->tick * t->period),
                         .sender = 1,
                         .seq = t->tick + 1,
                         .force_seq = -1,
                         .flags = SOFTSIM_POSE_CORRECTS, /* as the bridge; without delay */
                         .orientation = {1.0, 0.0, 0.0, 0.0},
                         .velocity = {NAN, NAN, NAN},
                         .applied_force = {NAN, NAN, NAN}};
    ss_madd3(pose.position, t->press->origin, height, towards);
    softsim_tick(t->world, &pose, &probe, 1, force);
    ++t->tick;
    const double proxy = ss_dot3(force[0].proxy, towards);
    if (!t->out->has_touched && (force[0].flags & SOFTSIM_FORCE_CONTACT) != 0) {
        t->out->has_touched = true;
        t->touched = proxy;
        t->out->late = ss_dot3(t->press->origin, towards) - proxy;
    }
    if (!t->out->has_touched) {
        return (trial_hold){0};
    }
    const double reaction = ss_dot3(force[0].model_force, towards);
    double across[3];
    ss_madd3(across, force[0].model_force, -reaction, towards);
    return (trial_hold){t->touched - proxy, t->touched - ss_dot3(pose.position, towards),
                        ss_dot3(force[0].force, towards), reaction, ss_norm3(across)};
}

/* From one height to another; the last tick. */
static trial_hold move(trial *t, double from, double to, double seconds)
{
    const int32_t ticks = (int32_t)ceil(seconds / t->period);
    trial_hold now = {0};
    for (int32_t k = 0; k < ticks; ++k) {
        now = tick(t, from + (to - from) * k / ticks);
    }
    return now;
}

/* The means of the window in which it came to rest. */
static trial_hold hold(trial *t, double height)
{
    const int32_t ticks = (int32_t)ceil(WINDOW / t->period);
    const int32_t windows = (int32_t)ceil(LONGEST_HOLD / WINDOW);
    trial_hold mean = {0};
    for (int32_t w = 0; w < windows; ++w) {
        const double before = mean.force;
        mean = (trial_hold){0};
        for (int32_t k = 0; k < ticks; ++k) {
            const trial_hold now = tick(t, height);
            mean.depth += now.depth / ticks;
            mean.indentation += now.indentation / ticks;
            mean.force += now.force / ticks;
            mean.reaction += now.reaction / ticks;
            mean.aside += now.aside / ticks;
        }
        if (w > 0 && fabs(mean.force - before) <= MOVES * fabs(mean.force)) {
            break;
        }
    }
    return mean;
}

void trial_run(softsim_world *world, const trial_press *press, trial_result *out)
{
    softsim_state state;
    softsim_read(world, &state);
    *out = (trial_result){0};
    trial t = {.world = world, .press = press, .out = out, .period = state.period_s};
    const double above = press->depth; /* where it begins and ends */
    out->speed = (above + press->depth) / COMES;
    out->moving_force = move(&t, above, -press->depth, COMES).force;
    out->held = hold(&t, -press->depth);
    if (press->deepest > press->depth) {
        (void)move(&t, -press->depth, -press->deepest, DEEPENS);
        out->deepest = hold(&t, -press->deepest);
        (void)move(&t, -press->deepest, above, LEAVES);
        (void)move(&t, above, above, GONE);
    }
    softsim_read(world, &state);
    out->verdict = state.worst_verdict;
    (void)snprintf(out->reason, sizeof out->reason, "%s", state.worst_reason);
    judge(press, out);
    out->step_us = state.step_us[0];
    out->step_us_p99 = state.step_us[1];
    out->period_us = 1e6 * state.simulation_period_s;
}
