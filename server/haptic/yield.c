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
 * 1/K_old).
 *
 * Stiffer it becomes slowly: a loaded spring that stiffens pushes the hand out. At once, like the
 * way down, it gave taps on viscous tissue 0.7 mJ that it now takes 1.4 mJ from.
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
#include "rt/vec.h"

#define STIFFEN_RATE 5.0   /* 1/s: K_c in contact grows by e^(5 T) a tick at most */
#define REST_TIME    0.020 /* s */
#define NEGLIGIBLE   1e-9  /* m */

void ss_yield_clear(ss_yield *yield)
{
    ss_set3(yield->rest, 0.0, 0.0, 0.0);
    ss_set3(yield->stretch, 0.0, 0.0, 0.0);
}

void ss_yield_take(ss_yield *yield, const double hand[3], const double proxy[3])
{
    ss_sub3(yield->stretch, proxy, hand);
    ss_sub3(yield->stretch, yield->stretch, yield->rest);
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
        return;
    }
    const double before = yield->spring;
    const double pace = exp(STIFFEN_RATE * period);
    yield->spring = fmin(before * pace, is_grasping ? fmax(before / pace, wanted) : wanted);
    if (yield->spring < before) {
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
