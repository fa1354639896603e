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
static const double LIMITED = 0.95; /* of the limit: the tissue's own force may be more */
/* s: of the parts of a press. */
static const double COMES = 0.2, SETTLES = 0.3, DEEPENS = 0.2, STAYS = 0.1, LEAVES = 0.2;
static const double READ = 0.05; /* s at the end of a hold in which force and depth are read */
static const double CLEAR_SHARE = 1.0; /* of the depth: where it begins and ends, above */

/* How far above the touch the tool is aimed to be at time t; negative: in the tissue. */
static double height_at(const trial_press *press, double t)
{
    const double above = CLEAR_SHARE * press->depth;
    double u = t / COMES;
    if (u < 1.0) {
        return above - u * (above + press->depth);
    }
    t -= COMES + SETTLES;
    u = fmin(fmax(t / DEEPENS, 0.0), 1.0);
    const double down = press->depth + u * (press->deepest - press->depth);
    u = fmin(fmax((t - DEEPENS - STAYS) / LEAVES, 0.0), 1.0);
    return -down + u * (down + above);
}

double trial_hertz(double youngs_modulus, double poisson_ratio, double radius, double depth)
{
    return 4.0 / 3.0 * youngs_modulus / (1.0 - poisson_ratio * poisson_ratio) * sqrt(radius) *
           pow(fmax(depth, 0.0), 1.5);
}

typedef struct reading {
    double end; /* s */
    trial_hold sum;
    int32_t count;
} reading;

static void take_reading(reading *r, double t, const trial_hold *now)
{
    if (t >= r->end - READ && t < r->end) {
        r->sum.depth += now->depth;
        r->sum.indentation += now->indentation;
        r->sum.force += now->force;
        r->sum.reaction += now->reaction;
        r->sum.aside += now->aside;
        ++r->count;
    }
}

static trial_hold mean_of(const reading *r)
{
    const double n = r->count > 0 ? r->count : 1.0;
    return (trial_hold){r->sum.depth / n, r->sum.indentation / n, r->sum.force / n,
                        r->sum.reaction / n, r->sum.aside / n};
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

void trial_run(softsim_world *world, const trial_press *press, trial_result *out)
{
    softsim_state state;
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_read(world, &state);
    const double held = COMES + SETTLES;
    const double end =
        press->deepest > press->depth ? held + DEEPENS + STAYS + LEAVES + SETTLES : held;
    const int32_t ticks = (int32_t)ceil(end / state.period_s), probe = 0;
    double touched = 0.0;
    reading first = {.end = held}, second = {.end = held + DEEPENS + STAYS};
    *out = (trial_result){0};
    for (int32_t k = 0; k < ticks; ++k) {
        const double t = k * state.period_s;
        softsim_pose pose = {.utime_us = (int64_t)(1e6 * t),
                             .sender = 1,
                             .seq = k + 1,
                             .force_seq = -1,
                             .flags = SOFTSIM_POSE_CORRECTS, /* as the bridge; without delay */
                             .orientation = {1.0, 0.0, 0.0, 0.0},
                             .velocity = {NAN, NAN, NAN},
                             .applied_force = {NAN, NAN, NAN}};
        ss_madd3(pose.position, press->origin, height_at(press, t), press->towards);
        softsim_tick(world, &pose, &probe, 1, force);
        const double proxy = ss_dot3(force[0].proxy, press->towards);
        if (!out->has_touched && (force[0].flags & SOFTSIM_FORCE_CONTACT) != 0) {
            out->has_touched = true;
            touched = proxy;
            out->late = ss_dot3(press->origin, press->towards) - proxy;
        }
        if (out->has_touched) {
            const double *f = force[0].model_force;
            const double felt = ss_dot3(force[0].force, press->towards);
            const double reaction = ss_dot3(f, press->towards);
            double across[3];
            ss_madd3(across, f, -reaction, press->towards);
            const trial_hold now = {touched - proxy,
                                    touched - ss_dot3(pose.position, press->towards), felt,
                                    reaction, ss_norm3(across)};
            out->moving_force = t < COMES ? felt : out->moving_force;
            take_reading(&first, t, &now);
            take_reading(&second, t, &now);
        }
    }
    softsim_read(world, &state);
    out->speed = (height_at(press, 0.0) + press->depth) / COMES;
    out->held = mean_of(&first);
    out->deepest = mean_of(&second);
    out->verdict = state.worst_verdict;
    (void)snprintf(out->reason, sizeof out->reason, "%s", state.worst_reason);
    judge(press, out);
    out->step_us = state.step_us[0];
    out->step_us_p99 = state.step_us[1];
    out->period_us = 1e6 * state.simulation_period_s;
}
