/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/hand.h"

#include <math.h>
#include <string.h>

#include "rt/vec.h"

static const double release_s = 0.02; /* no hand taps as fast */

/* The devices. */
enum { AT_ONCE, ONE_LATER, EVENLY, DEVICES };

void ss_hand_read(const softsim_pose *pose, const softsim_force *answer, ss_hand_sample *out)
{
    double slip[3];
    ss_sub3(slip, answer->proxy, pose->position);
    *out = (ss_hand_sample){.depth_m = answer->depth,
                            .slip_m = ss_norm3(slip),
                            .is_let_in = (answer->flags & SOFTSIM_FORCE_RAMPING) != 0};
    ss_copy3(out->position, pose->position);
    memcpy(out->orientation, pose->orientation, sizeof out->orientation);
    ss_copy3(out->force, answer->force);
    ss_copy3(out->torque, answer->torque);
}

static bool is_touched(const ss_hand_sample *s)
{
    return ss_norm3(s->force) + ss_norm3(s->torque) > 0.0;
}

/* What the answer to `of` gives a hand that goes from sample `at` to the one after. */
static double given(const ss_hand_sample *of, const ss_hand_sample *at)
{
    double way[3], turn[3];
    ss_sub3(way, at[1].position, at[0].position);
    ss_turn_between(at[0].orientation, at[1].orientation, turn);
    return ss_dot3(of->force, way) + ss_dot3(of->torque, turn);
}

/* What may be given back from sample i on. */
static double stored_at(const ss_hand_plan *plan, const ss_hand_sample *sample, int32_t count,
                        int32_t i)
{
    double most = 0.0;
    for (int32_t k = i - plan->lag; k <= i + plan->lag; ++k) {
        most = k >= 0 && k < count ? fmax(most, sample[k].stored_j) : most;
    }
    return most + ss_norm3(sample[i].force) * sample[i].slip_m;
}

/* The contact that goes on from sample `first` to `last`. */
static void judge_contact(const ss_hand_plan *plan, const ss_hand_sample *sample, int32_t count,
                          int32_t first, int32_t last, ss_hand_account *out)
{
    double energy[DEVICES] = {0.0}, start[DEVICES];
    double handed_out = 0.0, let_in = 0.0;
    for (int d = 0; d < DEVICES; ++d) {
        start[d] = -(double)INFINITY;
    }
    for (int32_t i = first; i < last; ++i) {
        const ss_hand_sample *at = &sample[i];
        const double stored = stored_at(plan, sample, count, i);
        const double step[DEVICES] = {[AT_ONCE] = given(at, at),
                                      [ONE_LATER] = i > first ? given(at - 1, at) : 0.0,
                                      [EVENLY] = 0.5 * (given(at, at) + given(at + 1, at))};
        let_in = at->is_let_in ? fmax(let_in, stored) : let_in;
        for (int d = 0; d < DEVICES; ++d) {
            start[d] = at->is_let_in ? -(double)INFINITY : fmax(start[d], -energy[d] - stored);
            energy[d] += step[d];
            handed_out = d != EVENLY ? fmax(handed_out, energy[d]) : handed_out;
            out->put_in_j = fmax(out->put_in_j, -energy[d]);
            out->made_j = plan->has_stored ? fmax(out->made_j, energy[d] + start[d]) : 0.0;
        }
    }
    ++out->contacts;
    out->handed_out_j = fmax(out->handed_out_j, handed_out);
    out->driven_j = fmax(out->driven_j, handed_out - let_in);
}

void ss_hand_judge(const ss_hand_plan *plan, const ss_hand_sample *sample, int32_t count,
                   ss_hand_account *out)
{
    /* The answer to a last touch may still act an answer later. */
    const int32_t release = (int32_t)fmax(2.0, ceil(release_s / plan->period_s));
    *out = (ss_hand_account){.contacts = 0};
    for (int32_t i = 0; i < count; ++i) {
        out->peak_force_n = fmax(out->peak_force_n, ss_norm3(sample[i].force));
        out->deepest_m = fmax(out->deepest_m, sample[i].depth_m);
    }
    for (int32_t i = 0; i < count; ++i) {
        if (!is_touched(&sample[i])) {
            continue;
        }
        const int32_t first = i > 0 && !sample[i].is_apart ? i - 1 : i;
        int32_t last = i, quiet = 0;
        while (last + 1 < count && !sample[last + 1].is_apart && quiet < release) {
            ++last;
            quiet = is_touched(&sample[last]) ? 0 : quiet + 1;
        }
        judge_contact(plan, sample, count, first, last, out);
        i = last;
    }
}
