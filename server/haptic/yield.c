/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The coupling's spring K_c, which follows the tissue's stiffness k so that the hand feels at most
 * K_max (coupling.c).
 *
 * Tissue stiffens under a tool: k may grow tenfold within the first millimetre. A spring that comes
 * down slowly lets the hand feel k meanwhile (tissue promised at 400 N/m was felt with 1300). So it
 * softens at once, by any amount. Under a load F = K_c s that alone would take F (1 - K_new/K_old)
 * from the hand in one tick; the place where the spring is without force moves instead, by
 *   r += s (1 - K_old/K_new),
 * which keeps F, and comes back in 20 ms. Meanwhile dF/dx is that of the soft spring. Kept for good
 * it would hand out energy: what was loaded stiff would be given back soft, F^2/2 (1/K_new -
 * 1/K_old). At the force limit s = F/K_c: with what the proxy has slipped in it, r went 70 mm aside
 * in a tick as the force turned, and the force by 35 degrees.
 *
 * Stiffer it becomes slowly: a loaded spring that stiffens pushes the hand out. At once, like the
 * way down, it gave taps on viscous tissue 0.7 mJ that it now takes 1.4 mJ from.
 *
 * And only as far as that was paid for. Under a load F a change of the compliance C = 1/K_c takes
 * F^2/2 dC from the hand, or gives it as much, and k is another one at every place: deep in from
 * stiff tissue to soft, and further out back again, gave a hand beside a kidney's hilum 11 mJ every
 * turn. So each piece of C remembers the F^2 that it was taken under (its mean), and gives back no
 * more, but for half a millijoule that is paid back by what later gives back less. A piece that is
 * not paid for stays soft until the load is less, or the contact over. In and out the same way
 * gives back all; no closed path gives more than it took.
 *
 * In a grasp it softens as slowly: the tissue that is held changes its stiffness with every result,
 * and a spring that follows each drop at once and comes back slowly ends at the softest of them.
 * Elements that are drawn then swing against it (a box of ed0-tissue held still: 2 N from tick to
 * tick, where it was at rest).
 *
 * Rejected: integrating dF = K_c ds along the way. It feels the same, and drifts without bound when
 * k differs on the way in and out.
 */
#include "haptic/internal.h"

#include <string.h>

#include "rt/vec.h"

#define STIFFEN_RATE 5.0    /* 1/s: K_c in contact grows by e^(5 T) a tick at most */
#define REST_TIME    0.020  /* s */
#define NEGLIGIBLE   1e-9   /* m */
#define PIECE        0.05   /* of ln C */
#define CREDIT       0.5e-3 /* J */

void ss_yield_clear(ss_yield *yield)
{
    ss_set3(yield->rest, 0.0, 0.0, 0.0);
    ss_set3(yield->stretch, 0.0, 0.0, 0.0);
    yield->load = 0.0;
}

void ss_yield_take(ss_yield *yield, const double hand[3], const ss_rest *rest,
                   const double force[3], double limit)
{
    if (rest->stiffness_fraction < 1.0) {
        ss_scale3(yield->stretch, force, 1.0 / yield->spring);
    } else {
        ss_sub3(yield->stretch, rest->p, hand);
        ss_sub3(yield->stretch, yield->stretch, yield->rest);
    }
    yield->load = fmin(limit, yield->spring * ss_norm3(yield->stretch));
}

/* m/N: where a piece of the compliance begins. */
static double piece_start(int piece)
{
    return exp(PIECE * piece) / SS_MAX_COUPLING_STIFFNESS;
}

static int piece_of(double compliance)
{
    const double piece = log(compliance * SS_MAX_COUPLING_STIFFNESS) / PIECE;
    return (int)fmin(SS_YIELD_PIECES - 1, fmax(0.0, piece));
}

/* The spring goes to K_c `to`, softer; the pieces on the way remember the load. */
static void soften(ss_yield *yield, double to)
{
    double at = 1.0 / yield->spring;
    const double end = 1.0 / to, square = yield->load * yield->load;
    for (int piece = piece_of(at); at < end; ++piece) {
        const double start = fmin(at, piece_start(piece));
        const double next =
            piece == SS_YIELD_PIECES - 1 ? end : fmin(end, fmax(at, piece_start(piece + 1)));
        if (next > at) {
            const double sum = yield->paid[piece] * (at - start) + square * (next - at);
            yield->paid[piece] = sum / (next - start);
            at = next;
        }
    }
    yield->spring = to;
}

/* The spring goes to K_c `to`, stiffer, or as far as it is paid for. */
static void stiffen(ss_yield *yield, double to)
{
    double at = 1.0 / yield->spring;
    const double end = 1.0 / to, square = yield->load * yield->load;
    bool is_paid = true;
    for (int piece = piece_of(at); at > end && is_paid; --piece) {
        const double next = piece == 0 ? end : fmax(end, fmin(at, piece_start(piece)));
        const double lacking = 0.5 * (square - yield->paid[piece]);
        is_paid = lacking * (at - next) <= yield->credit;
        const double way = is_paid ? at - next : yield->credit / lacking;
        yield->credit = fmax(0.0, fmin(CREDIT, yield->credit - lacking * way));
        at -= way;
    }
    yield->spring = is_paid ? to : 1.0 / at;
}

void ss_yield_follow(ss_yield *yield, double wanted, bool is_in_contact, bool is_grasping,
                     double period)
{
    ss_scale3(yield->rest, yield->rest, exp(-period / REST_TIME));
    if (ss_norm3(yield->rest) < NEGLIGIBLE) {
        ss_set3(yield->rest, 0.0, 0.0, 0.0);
    }
    if (!is_in_contact) {
        yield->spring = wanted;
        if (yield->has_paid) {
            memset(yield->paid, 0, sizeof yield->paid);
        }
        yield->has_paid = false;
        yield->credit = CREDIT;
        return;
    }
    const double before = yield->spring;
    const double pace = exp(STIFFEN_RATE * period);
    const double next = fmin(before * pace, is_grasping ? fmax(before / pace, wanted) : wanted);
    if (next > before) {
        stiffen(yield, next);
    } else if (next < before) {
        soften(yield, next);
        yield->has_paid = true;
        ss_madd3(yield->rest, yield->rest, 1.0 - before / yield->spring, yield->stretch);
    }
}

/* Spring and tissue A in series: K_c A (K_c + A)^-1 = K_c - K_c^2 (K_c + A)^-1. As K_c k/(K_c + k),
 * k = n.A n, it would be too stiff where several contacts lean. */
double ss_yield_felt(const ss_yield *yield, double tissue[3][3], const double n[3])
{
    double both[3][3], yielded[3];
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            both[r][c] = tissue[r][c] + (r == c ? yield->spring : 0.0);
        }
    }
    ss_cholesky_solve3(both, n, yielded);
    return fmax(0.0, yield->spring * (1.0 - yield->spring * ss_dot3(n, yielded)));
}
