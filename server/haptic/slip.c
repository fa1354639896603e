/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What the force limit, and a grasp that was let go, leave between the hand and the proxy.
 *
 * The coupling is without force where the proxy is at x + aside. At the limit the proxy slips out
 * along the local contact model's force (coupling.c); what of that slip lies across the force when
 * the force turns goes into `aside`, so that the proxy stays, and fades: in the end the force
 * points from the hand to the proxy. In a grasp the spring is soft all ways and the force points
 * there by itself: `aside` is then what the contacts left, and only fades, also where nothing is
 * limited. It begins as what keeps the force's direction: at the limit, with d from the hand to
 * where the proxy goes next, without what the damper and what decays pull,
 *   aside = d - (d.u) u,   u along the force that the grasp begins with.
 * A grasp let go leaves all of it there: until the model holds no more, some 20 ms of its time, the
 * proxy stays. `aside` belongs to the hand's point, not to where the coupling and its damper
 * together would have the proxy: that depends on the spring, which is another one in and out of
 * contact.
 *
 * A limit that is lowered under a press sends the proxy out by millimetres in a tick or two. The
 * tissue follows in some 30 results and swings meanwhile, and with it the direction of its force f:
 * by up to 35 degrees a tick, there and back (a kidney, 3 to .5 N). What is felt keeps the size and
 * turns in the plane of both from its own last direction u towards f by at most a, T the period,
 *   F = |f| (u cos a + t sin a),   t = f - (f.u) u, normalised,
 *   a = TURN_RATE T + |dx| / TURN_WAY,
 * for TURNING_TIME from each lowering on: 0.24 s to the very opposite, and then the
 * tissue comes to rest. dx is the hand's way in the tick: F - f, of an angle b, gives a hand that
 * moves at most |f| b |dx|, and with that share of the way b is gone within millimetres. With
 * TURN_RATE alone a hand that swung a grasp to its other side, or turned round against friction,
 * got up to 31 mJ where it pays 8 without any turning. The proxy, what the tissue is pressed with,
 * and the torque stay those of the balance. A force that ends, or begins, has no direction to keep.
 *
 * Rejected: the limit of the balance eased down in 10 to 100 ms instead: still 6 degrees a tick
 * with a sphere, 14 with a cylinder.
 */
#include "haptic/internal.h"
#include "rt/vec.h"

/* s: in which a proxy beside the hand comes over it. */
#define ASIDE_TIME 0.1
/* m: so far beside, it does not come over: the force goes down, and the tool begins again where the
 * hand is. A button that is pressed again before the proxy has come over adds to what is left: one
 * that bounced every 3 ms on a hand that shook took the tool 0.6 m away. */
#define LOST 0.05
/* How a limit that is raised lets the slip go: at most as fast as a hand presses, in time with what
 * is left of it, and not without end. */
#define RISE_SPEED       0.1   /* m/s */
#define RISE_TIME        0.1   /* s */
#define RISE_SPEED_MIN   0.005 /* m/s */
#define NEGLIGIBLE       1e-9  /* m */
#define NEGLIGIBLE_FORCE 1e-9  /* N */
/* How a lowered limit turns the force: by that at most, and for the hand's way; so long. */
#define TURN_RATE    13.0  /* rad/s: 0.745 degrees in 1 ms */
#define TURN_WAY     0.002 /* m a rad */
#define TURNING_TIME 0.3   /* s */

void ss_slip_clear(ss_slip *slip)
{
    ss_set3(slip->aside, 0.0, 0.0, 0.0);
    slip->is_kept = false;
    slip->is_from_grasp = false;
}

/* A limit that is raised under a hand gives it what the lower one spared it: 2 to 4 mJ from 0.3 to
 * 1 or 2 N. Lowering is limited by the slew alone. If raising were limited only by the coupling's
 * stiffness, a kidney pressed at 0.3 m/s gave 14 % more than its resting force. */
bool ss_slip_follow(ss_slip *slip, const ss_haptic_config *config, double step, double size,
                    double stiffness)
{
    const double wanted = config->max_force;
    if (wanted < slip->limit) {
        slip->limit = fmax(wanted, fmin(slip->limit, size) - step);
        slip->turning = size > slip->limit ? TURNING_TIME : slip->turning;
        return true;
    }
    if (slip->stiffness_fraction < 1.0) {
        const double speed = fmin(RISE_SPEED, fmax(RISE_SPEED_MIN, slip->length / RISE_TIME));
        slip->limit = fmin(wanted, slip->limit + fmin(step, speed * stiffness * config->period));
    } else {
        slip->limit = wanted;
    }
    return false;
}

/* Unit, across unit `u`: in the plane of u and `to`, or any where they have none. */
static void across(const double u[3], const double to[3], double out[3])
{
    ss_madd3(out, to, -ss_dot3(to, u), u);
    if (!(ss_norm3(out) > 1e-9 * ss_norm3(to))) {
        int least = fabs(u[1]) < fabs(u[0]) ? 1 : 0;
        least = fabs(u[2]) < fabs(u[least]) ? 2 : least;
        ss_scale3(out, u, -u[least]);
        out[least] += 1.0;
    }
    (void)ss_normalize3(out);
}

bool ss_slip_turn(ss_slip *slip, const double last[3], double way, double period, double force[3])
{
    const double size = ss_norm3(force), last_size = ss_norm3(last);
    if (!(slip->turning > 0.0) || !(fmin(size, last_size) > NEGLIGIBLE_FORCE)) {
        slip->turning = 0.0;
        return false;
    }
    const double most = TURN_RATE * period + way / TURN_WAY;
    double u[3], aside[3];
    slip->turning -= period;
    ss_scale3(u, last, 1.0 / last_size);
    if (most >= SS_PI || ss_dot3(u, force) >= size * cos(most)) {
        return false;
    }
    across(u, force, aside);
    ss_scale3(force, u, size * cos(most));
    ss_madd3(force, force, size * sin(most), aside);
    return true;
}

void ss_slip_hold(ss_slip *slip, const double stretch[3], const double force[3])
{
    const double square = ss_dot3(force, force);
    if (slip->stiffness_fraction < 1.0 && square > NEGLIGIBLE_FORCE * NEGLIGIBLE_FORCE) {
        ss_madd3(slip->aside, stretch, -ss_dot3(stretch, force) / square, force);
    }
}

double ss_slip_time_left(const ss_slip *slip, const double v[3])
{
    const double speed = ss_dot3(v, slip->direction);
    return slip->stiffness_fraction < 1.0 && speed > 0.0 ? fmax(0.0, slip->length) / speed
                                                         : INFINITY;
}

bool ss_slip_is_lost(const ss_slip *slip)
{
    return slip->is_from_grasp && ss_norm3(slip->aside) > LOST;
}

void ss_slip_take(ss_slip *slip, const ss_balance *balance, const ss_rest *rest,
                  const double force[3], double spring, double period)
{
    const bool is_limited = rest->stiffness_fraction < 1.0;
    /* A force at rounding level has no direction. */
    const double size = ss_norm3(force);
    const bool has_force = size > NEGLIGIBLE_FORCE;
    ss_scale3(slip->direction, force, has_force ? 1.0 / size : 0.0);
    slip->stiffness_fraction = rest->stiffness_fraction;
    if (slip->is_kept) {
        return;
    }
    slip->is_from_grasp = slip->is_from_grasp && !(is_limited && has_force);
    const bool is_beside = ss_norm3(slip->aside) > 0.0;
    if (!slip->is_from_grasp && !balance->is_held && has_force && (is_limited || is_beside)) {
        double d[3];
        ss_sub3(d, rest->p, balance->p_free);
        ss_madd3(d, slip->aside, balance->spring / spring, d);
        ss_madd3(slip->aside, d, -ss_dot3(d, slip->direction), slip->direction);
    }
    ss_scale3(slip->aside, slip->aside, exp(-period / ASIDE_TIME));
    if (ss_norm3(slip->aside) < NEGLIGIBLE) {
        ss_slip_clear(slip);
    }
}
