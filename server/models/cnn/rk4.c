/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * The largest step of classical Runge-Kutta for x'' + d x' + w^2 x = 0, from its region of
 * stability, |1 + z + z^2/2 + z^3/6 + z^4/24| <= 1.
 */
#include <math.h>

/* Least |z| on that region's boundary, for arguments of z in 32 equal intervals from the imaginary
 * to the negative real axis. */
enum { ARCS = 32 };
static const double rk4_radius[ARCS] = {
    2.8284, 2.9087, 2.9499, 2.9431, 2.9040, 2.8482, 2.7840, 2.7217, 2.6707, 2.6360, 2.6185,
    2.6156, 2.6164, 2.6270, 2.6471, 2.6738, 2.7044, 2.7361, 2.7667, 2.7943, 2.8175, 2.8353,
    2.8472, 2.8530, 2.8482, 2.8393, 2.8279, 2.8155, 2.8036, 2.7939, 2.7875, 2.7853};
/* cos of the angle from the negative real axis at the ends of the intervals: sin(k pi / 64). */
static const double arc_cosine[ARCS + 1] = {
    0.0,         0.049067674, 0.098017140, 0.146730474, 0.195090322, 0.242980180, 0.290284677,
    0.336889853, 0.382683432, 0.427555093, 0.471396737, 0.514102744, 0.555570233, 0.595699304,
    0.634393284, 0.671558955, 0.707106781, 0.740951125, 0.773010453, 0.803207531, 0.831469612,
    0.857728610, 0.881921264, 0.903989293, 0.923879533, 0.941544065, 0.956940336, 0.970031253,
    0.980785280, 0.989176510, 0.995184727, 0.998795456, 1.0};

double ss_cnn_rk4_limit(double d_min, double d_max, double omega2)
{
    const double omega = sqrt(fmax(omega2, 0.0));
    double limit = d_max > 0.0 ? rk4_radius[ARCS - 1] / d_max : (double)INFINITY;
    for (int k = 0; k < ARCS && omega > 0.0; ++k) {
        if (2.0 * omega * arc_cosine[k + 1] < d_min) {
            continue; /* every mode is more damped than that */
        }
        const double highest =
            k > 0 ? fmin(omega, d_max / (2.0 * arc_cosine[k])) : omega; /* mode at these angles */
        limit = highest > 0.0 ? fmin(limit, rk4_radius[k] / highest) : limit;
    }
    return limit;
}
