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
 * in a grasp against v itself.
 *
 * Behind a delay damping is late too, and drives the hand. There, without a grasp or a client that
 * corrects, the force is bounded by what the hand has paid for it: one sent now acts for the delay
 * tau while the hand may come out at v, and a spring of K_max that holds it gives F^2/(2 K_max), so
 *   0.3 F |v| tau + F^2/(2 K_max) <= E' + 0.2 mJ,
 * and on the way out no more than was sent last: a bound that a message lets go for a tick may be
 * held by the bus for twenty. (0.3: with 0.5 taps behind 10 ms keep half as much of their force,
 * with 0.15 late messages hand out 3.3 mJ.) A hand that rests is lent what is lacking within half a
 * second: it may be another tool that presses, or an entry.
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
#define NEAR_DELAY       0.0031  /* s */
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
#define GUESSED_DELAY    0.0051 /* s: less, before the delay is known, is a guess */
#define LEND_TIME        0.5    /* s */
#define REST_SPEED       0.02   /* m/s */

void ss_passivity_init(ss_passivity *passivity)
{
    *passivity = (ss_passivity){.share = 1.0, .bound = INFINITY};
}

void ss_passivity_restart(ss_passivity *passivity)
{
    passivity->share = 1.0;
    passivity->forgiven = 0.0;
}

void ss_passivity_step(ss_passivity *passivity, const ss_observer *observer, double period,
                       bool is_in_contact)
{
    if (passivity->contact != observer->contacts) {
        passivity->contact = observer->contacts;
        passivity->forgiven = passivity->lent = 0.0;
    }
    ++passivity->since;
    const bool is_due = (double)passivity->since * period >= BACKOFF_TIME;
    if (observer->is_in_contact && observer->is_told && is_due &&
        observer->energy - passivity->forgiven < BACKOFF_ENERGY) {
        passivity->share *= BACKOFF_SHARE;
        passivity->forgiven = observer->energy;
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

/* Bounds `force` of `size` where the loop is long; `energy` is E'. */
static bool bound(ss_passivity *passivity, const ss_observer *observer,
                  const ss_passivity_tick *now, double energy, double size, double force[3])
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
    const bool is_action = most < size - ACTION_MIN;
    passivity->bound = fmin(most, size);
    ss_scale3(force, force, passivity->bound / size);
    passivity->actions += is_action;
    return is_action;
}

bool ss_passivity_damp(ss_passivity *passivity, const ss_observer *observer,
                       const ss_passivity_tick *now, double force[3])
{
    const double size = ss_norm3(force);
    const double foreseen = ss_observer_foresee(observer, now);
    const double energy = foreseen - passivity->forgiven - ALLOWED_ENERGY;
    const bool is_far = observer->delay_p95 > (observer->is_known ? NEAR_DELAY : GUESSED_DELAY);
    if (observer->is_told && is_far && !now->corrects && !now->is_grasping && size > 0.0) {
        return bound(passivity, observer, now, foreseen, size, force);
    }
    passivity->bound = INFINITY;
    if (!observer->is_told || !(energy < 0.0) || !(size > 0.0)) {
        return false;
    }
    const double most = observer->delay_p95 <= NEAR_DELAY ? DAMPING_NEAR : DAMPING_FAR;
    double n[3], way[3];
    ss_scale3(n, force, 1.0 / size);
    ss_scale3(way, n, ss_dot3(n, now->velocity));
    if (now->is_grasping) {
        ss_copy3(way, now->velocity);
    }
    const double square = fmax(ss_dot3(way, way), SPEED_SQUARE_MIN);
    const double alpha = fmin(most, -energy / (now->period * square));
    double change[3];
    ss_scale3(change, way, -alpha);
    if (!now->is_grasping && ss_dot3(change, n) < -size) {
        ss_scale3(change, n, -size);
    }
    ss_add3(force, force, change);
    const bool is_action = ss_norm3(change) > ACTION_MIN;
    passivity->actions += is_action;
    return is_action;
}
