/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * How what an update must not be felt of decays: the offsets of the contacts and of a grasp, what
 * they cannot carry, and what a grasp let go left (local_contact.c). An offset moves the proxy as
 * it goes, and the next result answers that: how fast it goes is the gain of the loop of proxy and
 * simulation, and the constants here are what keeps that loop still.
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/vec.h"

#define RELEASED_FORCE_TIME 0.010 /* s */
/* s, tau = h/4 within SS_OFFSET_TIME_MIN and this. With 2 ms as the least, results at 300 to 1000
 * Hz let the inertia of a stiff contact into the hand a few ticks late, and fast taps hand out 0.8
 * to 2.5 mJ; with 4 ms at most 0.4 mJ. Static forces do not depend on it. */
#define OFFSET_TIME_MAX 0.008
/* Of a hand that has come to rest nothing but the simulation's own answers moves the proxy: it
 * takes this many of its periods, and half as many at STILL_SPEED (m/s). A pointed tool lies in its
 * dent, and what holds it sideways is stiffer than the contacts tell: at 60 Hz, with 4 ms, an
 * octahedron on chain mail goes to and fro by 0.5 N of 0.6 for ever; with 1.5 periods and more by
 * 0.02 or not at all. */
#define STILL_PERIODS 3.0
#define STILL_SPEED   0.005
/* An offset that decays moves the proxy against the coupling and the law, S together, and the next
 * result answers with up to the contact's own stiffness k_c: a loop of gain T k_c / (tau S). tau is
 * such that it is at most this, but no longer than 20 ms. On a liver's thin edge, of 200 N/m with a
 * contact of 10 kN/m, a gain of .7 let reactions swing between 3 and 8 N a tick, which pumped 30 to
 * 80 mJ into the tissue under a hand at rest; .5 left a third of the presses rough, .33 none. */
#define STEP_GAIN             (1.0 / 3.0)
#define OFFSET_TIME_STIFF_MAX 0.020
/* s, tau while the force is at its limit. The proxy then goes where the tissue answers with the
 * limit, and the offsets' decay is the gain of that loop: with 4 ms it swings where the touched
 * tissue is heavy (a ventricle of soft tissue at 0.5 N: reactions of 0 to 14 times the limit), with
 * 30 ms in a lattice of springs, from 60 ms on in none of the models. The same while entering,
 * where tissue springs back against the tool: undelayed that steps a held ventricle by 6 % a tick.
 */
#define HELD_BACK_OFFSET_TIME 0.060
/* Of a hand that comes out of the limit it is no more than this share of what that takes, and no
 * less than this (s). Tissue that follows the tool at v against a law that is too stiff by k leaves
 * an offset k v tau below its reaction: with 60 ms a box came out of a chain mail's limit while
 * that gave 1.2 of it. With all of the time that is left, down to 4 ms, a soft ventricle's force
 * steps by 2.5 % there, with 15 ms that of a lattice of springs by 1 %. */
#define LEAVING_SHARE       (1.0 / 3.0)
#define LEAVING_OFFSET_TIME 0.020
/* s: of the mean of an offset by which it decays at the limit and in a grasp. A membrane answers a
 * move within a tick with over a hundred times the stiffness that it is told to have at rest: a
 * liver (cnn-energy) held at 8 N reacted with 4 to 25 N, in turns of three ticks. Tissue that is
 * held rings with the tool, hardly damped (10 kPa at 250 Hz, where it reacts with 13 kN/m, five
 * times the grasp's own springs): a proxy that follows an offset's every tick drives it, and 14 of
 * 44 grasps held still swung by up to 2 N a tick. With 10 ms a limit that is raised is overshot by
 * 5 %. Rejected in a grasp: a decay in 20 ms without the mean (as still, but a hand that moves
 * feels the error of the stiffness that much longer). */
#define DRIFT_TIME 0.004
/* 1/s: the same of contacts that no grasp and no limit holds. Let f be the swing of a reaction, S_w
 * the swift stiffness, S what the proxy moves against: an offset that decays in tau moves the proxy
 * by f / (S omega tau), a result late, and at most frequencies above 150 Hz that pushes the swing:
 * it grows by up to S_w / (2 S tau) a second, less half the tissue's mass damping, whatever its
 * frequency. By the mean it is a sixth of that at 250 Hz. A share of the mean from the first rate
 * on, all of it from the second: tissue of 10 kPa and 30 /s between a tool and a wall, where K_c
 * is 1.4 kN/m, had 150 /s; 10 mm deep a still hand was shaken by 1.6 to 3.4 N. Where a model tells
 * no swift stiffness it is at most the contact's own: a box that lies flat on a liver shook a still
 * hand by 8 %. Rejected: tau = 8 ms without the mean (one place of 12 swings on). A stiff coupling,
 * 20 kN/m, has 20 /s at most on such tissue and feels each update in 4 ms as before. */
#define SWING_RATE_LEAST 30.0
#define SWING_RATE_FULL  90.0
/* 1/s: the same in a grasp, where the tissue goes with the tool whichever way, and its mass is on
 * the springs that hold it: such a rate is less than what its damping takes. Grasps of 10 and 50 g
 * on springs of 3 to 40 kN/m, drawn 4 mm aside and held still: 34 of 144 were shaken, 23 of them at
 * the slew; with 100 1/s 8, with 50 3, with 25 none; 30 ms is as good as 60. */
#define GRASP_RATE            25.0
#define GRASP_OFFSET_TIME_MAX 0.030 /* s */
/* s: in which it comes back to what it was, so that no offset ends at once. At 0.5 N, in 3 ms a
 * kidney's viscosity is a step; in 20 ms the force on the way out of a liver is 0.18 N off its
 * reaction, in 5 ms 0.05 N. */
#define HELD_BACK_RECOVERY_TIME 0.005
/* s, of the torque that an update changes. Of a capsule tilted on a kidney each millisecond gives
 * the hand half a millijoule a turn. */
#define TORQUE_TIME     0.002
#define NEGLIGIBLE      1e-6  /* N: a decayed offset ends here */
#define NEGLIGIBLE_TIME 1e-6  /* s: and here what slowed it */
#define TORQUE_ARM      0.005 /* m: NEGLIGIBLE at it is the least torque */

/* N/m: what the proxy moves against, S. */
static double stiffness_against(const ss_local_contact *local, double spring)
{
    double against = spring;
    for (int32_t i = 0; i < local->count; ++i) {
        against += local->contact[i].stiffness;
    }
    return against;
}

static void set_offset_time(ss_local_contact *local, double period, double against, double speed)
{
    const double still = 1.0 / (1.0 + speed * speed / (STILL_SPEED * STILL_SPEED));
    const double usual =
        fmax(fmin(OFFSET_TIME_MAX, fmax(SS_OFFSET_TIME_MIN, 0.25 * local->result_period)),
             still * STILL_PERIODS * local->result_period);
    const double least = period * local->step_stiffness / (STEP_GAIN * against);
    local->offset_time = fmax(usual, fmin(least, OFFSET_TIME_STIFF_MAX));
    if (local->grasp.is_held) {
        const double stiffness = fmax(local->swift, local->step_stiffness);
        const double quiet = stiffness / (GRASP_RATE * (against + local->viscous / period));
        local->offset_time = fmax(local->offset_time, fmin(quiet, GRASP_OFFSET_TIME_MAX));
    }
}

/* Of an offset's mean in what decays: 0 the offset itself, 1 its mean. */
static double mean_share(const ss_local_contact *local, double against)
{
    const double stiffness = fmax(local->swift, local->step_stiffness);
    const double rate = stiffness / (against * local->offset_time);
    const double share = (rate - SWING_RATE_LEAST) / (SWING_RATE_FULL - SWING_RATE_LEAST);
    return fmin(1.0, fmax(0.0, share));
}

static void decay3(double v[3], double factor, double least)
{
    ss_scale3(v, v, factor);
    if (ss_norm3(v) < least) {
        ss_set3(v, 0.0, 0.0, 0.0);
    }
}

/* Without a contact the residual is gone within a ramp: it smooths the change of a force that is no
 * more. */
static void fade_residual_when_free(ss_local_contact *local)
{
    if (ss_local_contact_active_count(local) > 0) {
        local->free_ticks = 0;
    } else if (local->free_ticks < SS_RAMP_TICKS) {
        const double left = SS_RAMP_TICKS - local->free_ticks;
        ss_scale3(local->residual, local->residual, (left - 1.0) / left);
        ss_scale3(local->residual_torque, local->residual_torque, (left - 1.0) / left);
        ++local->free_ticks;
    }
}

static void fade_released(ss_local_contact *local, double period)
{
    ss_local_contact_released *released = &local->released;
    released->share *= exp(-period / RELEASED_FORCE_TIME);
    if (released->share * ss_norm3(released->force) < NEGLIGIBLE) {
        memset(released, 0, sizeof *released);
    }
}

void ss_local_contact_decay(ss_local_contact *local, double period, double held_back,
                            double time_left, double spring, double speed)
{
    const double against = stiffness_against(local, spring);
    set_offset_time(local, period, against, speed);
    const double usual = local->offset_time;
    const double leaving = fmax(LEAVING_OFFSET_TIME, LEAVING_SHARE * time_left);
    local->min_offset_time = fmax(fmin(held_back * HELD_BACK_OFFSET_TIME, leaving),
                                  local->min_offset_time * exp(-period / HELD_BACK_RECOVERY_TIME));
    local->min_offset_time =
        local->min_offset_time > NEGLIGIBLE_TIME ? local->min_offset_time : 0.0;
    local->is_held_back = held_back > 0.0;
    const double still = 1.0 - local->viscosity_fraction;
    const double reaction = held_back > still ? HELD_BACK_OFFSET_TIME : HELD_BACK_RECOVERY_TIME;
    local->viscosity_fraction = 1.0 - held_back - (still - held_back) * exp(-period / reaction);
    const double kept = exp(-period / fmax(usual, local->min_offset_time));
    const double drift = 1.0 - exp(-period / DRIFT_TIME);
    const double share = held_back < 1.0 ? mean_share(local, against) : 1.0;
    for (int32_t i = 0; i < local->count; ++i) {
        ss_local_contact_point *c = &local->contact[i];
        /* `last_force` follows: it is what the local contact model says now at the last proxy,
         * and what an update must keep. Kept with the old offset, results at every tick would never
         * be let in. */
        c->drift += (drift + (1.0 - share) * (1.0 - drift)) * (c->offset - c->drift);
        const double lost = (1.0 - kept) * c->drift;
        c->last_force = c->last_force > 0.0 ? fmax(0.0, c->last_force - lost) : 0.0;
        c->offset -= lost;
        c->drift -= lost;
    }
    if (local->grasp.is_held && !local->grasp.is_ending) {
        ss_local_contact_grasp *grasp = &local->grasp;
        double ahead[3], lost[3];
        ss_sub3(ahead, grasp->offset, grasp->drift);
        ss_madd3(grasp->drift, grasp->drift, drift, ahead);
        ss_scale3(lost, grasp->drift, 1.0 - kept);
        ss_sub3(grasp->offset, grasp->offset, lost);
        ss_sub3(grasp->drift, grasp->drift, lost);
        ss_sub3(grasp->last_force, grasp->last_force, lost);
    }
    if (local->friction.is_used) {
        ss_friction_decay(&local->friction, kept);
    }
    /* At the limit the force turns as slowly as its contacts' sizes change, while one is there. */
    const bool is_touching = ss_local_contact_active_count(local) > 0;
    decay3(local->residual, is_touching ? kept : exp(-period / usual), NEGLIGIBLE);
    decay3(local->residual_torque, exp(-period / fmax(TORQUE_TIME, 0.25 * local->result_period)),
           NEGLIGIBLE * TORQUE_ARM);
    fade_residual_when_free(local);
    fade_released(local, period);
}
