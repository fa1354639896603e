/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One run made twice, with simulation.sleep auto and off, by the same poses and commands: the
 * forces are equal within a thousandth of the largest. Whether it slept is told by the sub-steps
 * that were made. cmocka comes first.
 */
#include "loops_fixture.h"
#include "press_fixture.h"
#include "rt/vec.h"

#define MOST_DIFFERENCE 1e-3  /* of the largest force */
#define FAR_OUT         -0.05 /* m: nothing is near */

/* What a hand does, part by part: its way in (m), along (m) and turn (rad), reached smoothly in
 * 0.4 s, and its button. */
typedef struct part {
    int ticks;
    double in, along, turn;
    int buttons;
    bool sleeps; /* is at least a tenth of it slept through? */
} part;

typedef struct pair {
    softsim_world *slept, *awake;
    double largest, difference;               /* N */
    double largest_torque, torque_difference; /* N m */
    int32_t seq;
} pair;

static inline pair open_pair(const body *b, const char *const *more, int count)
{
    softsim_world *world[2];
    for (int k = 0; k < 2; ++k) {
        const char *set[8] = {k == 0 ? "simulation.sleep=auto" : "simulation.sleep=off"};
        int n = 1;
        if (b->set != NULL) {
            set[n++] = b->set;
        }
        for (int i = 0; i < count; ++i) {
            set[n++] = more[i];
        }
        world[k] = open_body(b, set, n);
    }
    return (pair){.slept = world[0], .awake = world[1]};
}

/* Says what was felt, and sees that it was the same. */
static inline void close_pair(pair *p, const char *name)
{
    print_message("%s: %.3g N at most, %.2g of it apart\n", name, p->largest,
                  p->difference / p->largest);
    assert_true(p->largest > 0.0);
    assert_true(p->difference <= MOST_DIFFERENCE * p->largest);
    /* Of a tool of 8 mm, a torque below that is no more than the force's own difference. */
    assert_true(p->torque_difference <=
                MOST_DIFFERENCE * fmax(p->largest_torque, 0.008 * p->largest));
    softsim_destroy(&p->slept);
    softsim_destroy(&p->awake);
}

static inline int64_t substeps(softsim_world *world)
{
    softsim_state state;
    softsim_read(world, &state);
    return state.all_substeps;
}

static inline void tick(pair *p, const softsim_pose *pose)
{
    const softsim_force a = feel(p->slept, pose), b = feel(p->awake, pose);
    double apart[3], turned[3];
    ss_sub3(apart, a.force, b.force);
    ss_sub3(turned, a.torque, b.torque);
    p->largest = fmax(p->largest, ss_norm3(b.force));
    p->difference = fmax(p->difference, ss_norm3(apart));
    p->largest_torque = fmax(p->largest_torque, ss_norm3(b.torque));
    p->torque_difference = fmax(p->torque_difference, ss_norm3(turned));
}

static inline void set_both(pair *p, const char *argument)
{
    set_live(ss_world_of(p->slept), argument);
    set_live(ss_world_of(p->awake), argument);
}

static inline void play(pair *p, const body *b, const part *parts, int count)
{
    part last = parts[0];
    for (int k = 0; k < count; ++k) {
        const part *now = &parts[k];
        const int64_t before = substeps(p->slept), before_awake = substeps(p->awake);
        for (int n = 1; n <= now->ticks; ++n) {
            const double s = smooth((double)n / fmin(now->ticks, 400.0));
            const double turn = last.turn + s * (now->turn - last.turn);
            double x[3];
            ss_madd3(x, b->touch, last.in + s * (now->in - last.in), b->in);
            ss_madd3(x, x, last.along + s * (now->along - last.along), b->side);
            softsim_pose pose = pose_of(++p->seq, x);
            pose.orientation[0] = cos(0.5 * turn);
            pose.orientation[3] = sin(0.5 * turn);
            pose.buttons = now->buttons;
            tick(p, &pose);
        }
        const int64_t made = substeps(p->slept) - before;
        const int64_t asked = substeps(p->awake) - before_awake;
        if (now->sleeps && !((double)made <= 0.9 * (double)asked)) {
            fail_msg("%s, part %d: %lld sub-steps of %lld were made", b->name, k, (long long)made,
                     (long long)asked);
        }
        last = *now;
    }
}
