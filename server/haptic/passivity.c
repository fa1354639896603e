/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What is done when a contact hands energy to the hand (observer.c measures it where the device
 * is): damping, and when that is not enough, less stiffness. A good contact knows neither: it takes
 * more than it gives at all times.
 *
 * The observer's E is late: it knows what the device did before the pose that came last, under
 * forces sent long before. Those sent since are on their way, and the hand that moves at v will
 * get
 *   E' = E - sum F_k . (-v) T     over what was sent and not yet answered,
 * so E' < 0 is known a loop's delay earlier than E < 0. For a client that corrects, a force sent
 * counts as it will be at v t from here: F_k - S v t.
 *
 * Damping (Hannaford and Ryu 2002): while E' < 0,
 *   F += alpha v_in,  alpha = min(alpha_max, -E' / (T v_in^2)),  v_in = -n.v,  F >= 0,
 * in a grasp against v itself. What alpha was goes over 20 ms, and does not with E' < 0: one tick's
 * damping pays for the next tick, which without it gave the whole force back to a hand that left,
 * 0 and 2 N in turns.
 *
 * A grasp that is not corrected has no bound (below), and a damper that is late by tau drives a
 * hand and device of mass m that are light: from alpha tau / m = pi / 2 on it swings. There alpha
 * tau is at most 25 g. (With 5 N s/m, 40 g behind 10 ms each way swung up to the force limit, and
 * got 21 J.)
 *
 * Behind a delay damping is late too, and drives the hand. There, without a grasp or a client that
 * corrects, the force is bounded by what the hand has paid for it: one sent now acts for the delay
 * tau while the hand may come out at v, and a spring of K_max that holds it gives F^2/(2 K_max), so
 *   0.3 F |v| tau + F^2/(2 K_max) <= E' + 0.2 mJ,
 * and on the way out no more than was sent last: a bound that a message lets go for a tick may be
 * held by the bus for twenty. (0.3: with 0.5 taps behind 10 ms keep half as much of their force,
 * with 0.15 late messages hand out 3.3 mJ.) A hand that rests is lent what is lacking within half a
 * second: it may be another tool that presses. What an entry pressed in for the hand (admission.c)
 * is known to the joule, and counts as paid, here and below.
 *
 * Which of the two acts is a share, that grows from 0 to 1 between a loop of 3.1 and one of 5.1 ms,
 * and does not step in a contact: messages' delays differ from second to second, and a bound or a
 * damper that came with the 95th percentile let go of 2 N in a tick, from a hand at rest.
 *
 * Back-off: E < -1 mJ in spite of it: K_max times 0.8, at most every 20 ms; the debt is forgiven,
 * or one tap would soften all that come after it. It comes back by 10 % a second without contact.
 *
 * A device that tells neither the force in effect nor what it exerted is left alone: E is a guess
 * then, and a log that is played again is no device.
 *
 * Rejected: a cap on E, or what the tissue has stored taken off it: false alarms on tissue that
 * hardens, and buzz.
 */
#include "haptic/internal.h"
#include "rt/vec.h"

#define DAMPING_NEAR     10.0    /* N s/m, alpha_max */
#define DAMPING_FAR      5.0     /* N s/m, the same behind a longer delay */
#define GIVE_BACK_TIME   0.020   /* s: damping goes */
#define LIGHTEST_HAND    0.025   /* kg, of hand and device: in a grasp without correction */
#define NEAR_DELAY       0.0031  /* s: no bound up to here, */
#define FAR_DELAY        0.0051  /* and nothing but the bound from here */
#define GUESSED_DELAY    0.0051  /* s: less, before the delay is known, is a guess */
#define SHARE_UP_TIME    0.050   /* s: in contact, from no bound to all of it, */
#define SHARE_DOWN_TIME  0.250   /* and back */
#define ALLOWED_ENERGY   -0.4e-3 /* J: what rounding, tremor and a short delay hand out */
#define SPEED_SQUARE_MIN 1e-5    /* m^2/s^2 */
#define BACKOFF_ENERGY   -1e-3   /* J */
#define BACKOFF_SHARE    0.8
#define BACKOFF_TIME     0.020  /* s */
#define RETURN_RATE      0.1    /* 1/s */
#define LIMIT_FLOOR      50.0   /* N/m: no back-off goes below */
#define ACTION_MIN       1e-3   /* N: less is not counted */
#define BOUND_ENERGY     0.2e-3 /* J */
#define BOUND_SHARE      0.3    /* of the delay */
#define LEND_TIME        0.5    /* s */
#define REST_SPEED       0.02   /* m/s */

void ss_passivity_init(ss_passivity *passivity)
{
    *passivity = (ss_passivity){.share = 1.0, .bound = INFINITY};
}

void ss_passivity_restart(ss_passivity *passivity)
{
    passivity->share = 1.0;
    passivity->forgiven = passivity->damping = 0.0;
}

void ss_passivity_step(ss_passivity *passivity, const ss_observer *observer, double period,
                       bool is_in_contact)
{
    if (passivity->contact != observer->contacts) {
        passivity->contact = observer->contacts;
        passivity->forgiven = passivity->lent = passivity->let_in = 0.0;
    }
    ++passivity->since;
    const bool is_due = (double)passivity->since * period >= BACKOFF_TIME;
    const double energy = observer->energy + passivity->let_in;
    if (observer->is_in_contact && observer->is_told && is_due &&
        energy - passivity->forgiven < BACKOFF_ENERGY) {
        passivity->share *= BACKOFF_SHARE;
        passivity->forgiven = energy;
        passivity->since = 0;
        ++passivity->backoffs;
    } else if (!is_in_contact) {
        passivity->share = fmin(1.0, passivity->share * (1.0 + RETURN_RATE * period));
    }
    /* Where the floor holds there is nothing to come back from. */
    passivity->share = fmax(passivity->share, fmin(1.0, LIMIT_FLOOR / observer->limit));
}

double ss_passivity_limit(const ss_passivity *passivity, const ss_observer *observer)
{
    return observer->limit * passivity->share;
}

void ss_passivity_let_in(ss_passivity *passivity, double energy)
{
    passivity->let_in += energy;
}

/* 0 .. 1: how long the loop is, where `near` (s) is short. */
static double farness(const ss_observer *observer, double near)
{
    const double beyond = (observer->delay_p95 - near) / (FAR_DELAY - NEAR_DELAY);
    return fmin(1.0, fmax(0.0, beyond));
}

/* Moves what depends on the delay to what it asks for: at once where there is no force. */
static void follow_delay(ss_passivity *passivity, const ss_observer *observer,
                         const ss_passivity_tick *now, double size)
{
    const double up = size > 0.0 ? now->period / SHARE_UP_TIME : 1.0;
    const double down = size > 0.0 ? now->period / SHARE_DOWN_TIME : 1.0;
    const bool is_bounded = observer->is_told && !now->corrects && !now->is_grasping;
    const double bounded =
        is_bounded ? farness(observer, observer->is_known ? NEAR_DELAY : GUESSED_DELAY) : 0.0;
    const double share = passivity->bound_share, soft = passivity->soft_share;
    passivity->bound_share = fmin(share + up, fmax(share - down, bounded));
    passivity->soft_share = fmin(soft + up, fmax(soft - down, farness(observer, NEAR_DELAY)));
}

/* The size that a force of `size` is bounded to where the loop is long; `energy` is E'. */
static double bound(ss_passivity *passivity, const ss_observer *observer,
                    const ss_passivity_tick *now, double energy, const double force[3], double size)
{
    const double stiffness = ss_passivity_limit(passivity, observer);
    const double speed = ss_norm3(now->velocity);
    const double way = BOUND_SHARE * speed * observer->delay_p95;
    const double paid = energy + BOUND_ENERGY + passivity->lent;
    const double lacking = size * (way + 0.5 * size / stiffness) - paid;
    if (speed < REST_SPEED) {
        passivity->lent += fmax(0.0, lacking) * now->period / LEND_TIME;
    }
    const double slope = stiffness * way;
    double most = sqrt(slope * slope + 2.0 * stiffness * fmax(0.0, paid)) - slope;
    if (ss_dot3(force, now->velocity) > REST_SPEED * size) {
        most = fmin(most, passivity->bound);
    }
    passivity->bound = fmin(most, size);
    return passivity->bound;
}

/* What a damper of at most `most` adds to `force` of `size` > 0; `energy` < 0: beyond the allowed.
 */
static void dampen(ss_passivity *passivity, double most, const ss_passivity_tick *now,
                   double energy, const double force[3], double size, double out_change[3])
{
    double n[3], way[3];
    ss_scale3(n, force, 1.0 / size);
    ss_scale3(way, n, ss_dot3(n, now->velocity));
    if (now->is_grasping) {
        ss_copy3(way, now->velocity);
    }
    const double square = fmax(ss_dot3(way, way), SPEED_SQUARE_MIN);
    const double wanted = fmin(most, fmax(0.0, -energy) / (now->period * square));
    double alpha = fmax(wanted, passivity->damping);
    if (!now->is_grasping && alpha * ss_dot3(way, n) > size) {
        alpha = size / ss_dot3(way, n);
    }
    passivity->damping = alpha;
    ss_scale3(out_change, way, -alpha);
}

bool ss_passivity_damp(ss_passivity *passivity, const ss_observer *observer,
                       const ss_passivity_tick *now, double force[3])
{
    const double size = ss_norm3(force);
    follow_delay(passivity, observer, now, size);
    passivity->damping *= exp(-now->period / GIVE_BACK_TIME);
    if (!observer->is_told || !(size > 0.0)) {
        passivity->bound = INFINITY;
        return false;
    }
    const double share = passivity->bound_share;
    const double foreseen = ss_observer_foresee(observer, now) + passivity->let_in;
    const double energy = foreseen - passivity->forgiven - ALLOWED_ENERGY;
    double most = DAMPING_NEAR + passivity->soft_share * (DAMPING_FAR - DAMPING_NEAR);
    if (now->is_grasping && !now->corrects) {
        most = fmin(most, LIGHTEST_HAND / observer->delay_p95);
    }
    double change[3];
    dampen(passivity, most, now, energy, force, size, change);
    ss_scale3(change, change, 1.0 - share);
    const double bounded = bound(passivity, observer, now, foreseen, force, size);
    ss_madd3(change, change, share * (bounded / size - 1.0), force);
    ss_add3(force, force, change);
    const bool is_action = ss_norm3(change) > ACTION_MIN;
    passivity->actions += is_action;
    return is_action;
}
