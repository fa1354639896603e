/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * How the hand moves, and where its proxy will be when a slow step ends.
 *
 * Velocity v: what the device tells, else differences of positions behind one stage of
 * VELOCITY_CORNER. Acceleration: a = 2 pi f (v - mean v), mean v behind one stage of f =
 * ACCELERATION_CORNER. Both stages bring it late: at 5 Hz by VELOCITY_LATE.
 *
 * Prediction over t = (lag + 1/2) h, at most 25 ms:
 *   move = v t + b a t (t + VELOCITY_LATE) / 2,   |move| <= 3 mm
 * b 1 where the tool is slowed down, GAIN_SHARE where it quickens, and falling to 0 for ways longer
 * than PREDICT_BEND_MOST: those are blows, over before the step is.
 *
 * No deeper than where the local contact model answers with the force limit, for there the proxy
 * stays: a tool of 60 or 100 Hz that a hand at 1 to 3 m/s took to 0.5 or 1 N between two results
 * was sent up to 3 mm beyond, and gave the tissue half as much energy again.
 *
 * The tool's turn goes on at its speed, filtered as v. Without that a capsule that a hand tilts to
 * and fro on a kidney hands out 2 mJ a turn at 100 Hz.
 *
 * Late poses. The least time from a pose by the device's clock to the tick that takes it is what an
 * early one needs; a pose that took longer is of so long ago, as far as that clock can be trusted:
 * by 1 - e_c / e_a, where e_c is how far its poses are from their mean pace by the clock, and e_a
 * by the ticks that they come in. (A clock that tells steps of 4 to 16 ms has poses late that are
 * not, and a force that went there and back by 1.3 N.) A lost pose counts in neither.
 *
 * The constants were chosen by play (softsim-bench felt, test_haptic_loop), not derived. Without a,
 * pokes of 0.1 m/s are felt with two to eight times the difference at 120 Hz; slides on a liver
 * with 0.7 of it.
 */
#include "haptic/internal.h"
#include "rt/vec.h"

#define TWO_PI              6.283185307179586
#define VELOCITY_CORNER     50.0   /* Hz: one position count a millisecond is 30 mm/s */
#define SPEED_MAX           10.0   /* m/s: no hand is faster; bounds what a bad clock can do */
#define TURN_MAX            20.0   /* rad/s */
#define PREDICT_TURN_MAX    0.2    /* rad */
#define REST_TIME           0.1    /* s: a hand that stops is not at rest at once */
#define TIMING_SHARE        0.02   /* of a pose in the means of their timing */
#define FORGET_EARLY        0.02   /* s/s: so long is a pose early, after one that was */
#define LATE_MAX            0.05   /* s: later is another clock */
#define TINY_S              1e-6   /* of no device's clock */
#define PREDICT_TIME_MAX    0.025  /* s */
#define PREDICT_MOVE_MAX    0.003  /* m */
#define ACCELERATION_CORNER 20.0   /* Hz */
#define VELOCITY_LATE       0.003  /* s */
#define PREDICT_BEND_FROM   0.002  /* s: over a step of a haptic period velocity says it all */
#define PREDICT_BEND_MOST   0.0016 /* m: such a way counts half */
#define GAIN_SHARE          0.5    /* a tool that leaves soft tissue too early meets it again */

void ss_motion_rest(ss_motion *motion)
{
    ss_set3(motion->v, 0.0, 0.0, 0.0);
    ss_set3(motion->mean_v, 0.0, 0.0, 0.0);
    ss_set3(motion->turn, 0.0, 0.0, 0.0);
    motion->speed = motion->covered = 0.0;
    motion->is_timed = false;
    motion->late = 0.0;
}

void ss_motion_take(ss_motion *motion, const softsim_pose *last, const softsim_pose *pose,
                    double elapsed)
{
    const double lag = 1.0 - exp(-TWO_PI * VELOCITY_CORNER * elapsed);
    double way[3], turn[3];
    ss_sub3(way, pose->position, last->position);
    motion->covered = ss_norm3(way) / elapsed;
    ss_turn_between(last->orientation, pose->orientation, turn);
    for (int i = 0; i < 3; ++i) {
        motion->turn[i] += lag * (turn[i] / elapsed - motion->turn[i]);
    }
    ss_clamp_norm3(motion->turn, TURN_MAX);
    if (ss_is_finite(pose->velocity, 3)) {
        ss_copy3(motion->v, pose->velocity);
    } else {
        for (int i = 0; i < 3; ++i) {
            motion->v[i] += lag * (way[i] / elapsed - motion->v[i]);
        }
    }
    ss_clamp_norm3(motion->v, SPEED_MAX);
    motion->speed = fmax(ss_norm3(motion->v), motion->speed * exp(-elapsed / REST_TIME));
    const double alpha = 1.0 - exp(-TWO_PI * ACCELERATION_CORNER * elapsed);
    for (int i = 0; i < 3; ++i) {
        motion->mean_v[i] += alpha * (motion->v[i] - motion->mean_v[i]);
    }
}

void ss_motion_time(ss_motion *motion, int32_t count, double arrival, double elapsed, double offset)
{
    if (!motion->is_timed || fabs(offset - motion->usual) > LATE_MAX) {
        motion->is_timed = true;
        motion->pace = elapsed / count;
        motion->clock_error = motion->arrival_error = motion->late = 0.0;
        motion->usual = offset;
        return;
    }
    motion->pace += TIMING_SHARE * (elapsed / count - motion->pace);
    const double due = count * motion->pace;
    motion->clock_error += TIMING_SHARE * (fabs(elapsed - due) - motion->clock_error);
    motion->arrival_error += TIMING_SHARE * (fabs(arrival - due) - motion->arrival_error);
    motion->usual = fmin(offset, motion->usual + FORGET_EARLY * arrival);
    const double trust =
        1.0 - motion->clock_error / fmax(motion->arrival_error, motion->clock_error + TINY_S);
    motion->late = trust * (offset - motion->usual);
}

void ss_motion_acceleration(const ss_motion *motion, double out[3])
{
    ss_sub3(out, motion->v, motion->mean_v);
    ss_scale3(out, out, TWO_PI * ACCELERATION_CORNER);
}

void ss_haptic_predict(const ss_proxy_target *target, double lag_periods, double period,
                       double out_position[3])
{
    const double ahead = fmin((lag_periods + 0.5) * period, PREDICT_TIME_MAX);
    double move[3], bend[3];
    ss_scale3(move, target->velocity, ahead);
    ss_scale3(bend, target->acceleration, 0.5 * ahead * (ahead + VELOCITY_LATE));
    if (ss_dot3(bend, move) > 0.0) {
        ss_scale3(bend, bend, GAIN_SHARE);
    }
    if (ahead < PREDICT_BEND_FROM) {
        ss_set3(bend, 0.0, 0.0, 0.0);
    }
    const double square = ss_dot3(bend, bend) / (PREDICT_BEND_MOST * PREDICT_BEND_MOST);
    ss_madd3(move, move, 1.0 / (1.0 + square * square), bend);
    ss_clamp_norm3(move, PREDICT_MOVE_MAX);
    const double beyond = -ss_dot3(move, target->outward) - target->room;
    ss_madd3(move, move, fmax(0.0, beyond), target->outward);
    ss_add3(out_position, target->proxy, move);
}

void ss_haptic_predict_turn(const ss_proxy_target *target, double lag_periods, double period,
                            double out_orientation[4])
{
    const double ahead = fmin((lag_periods + 0.5) * period, PREDICT_TIME_MAX);
    double turn[3];
    ss_scale3(turn, target->turn, ahead);
    ss_clamp_norm3(turn, PREDICT_TURN_MAX);
    ss_turn(target->orientation, turn, out_orientation);
}
