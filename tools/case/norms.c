/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/norms.h"

#include <math.h>
#include <stddef.h>

#include "rt/vec.h"

static double square(const double a[3])
{
    return ss_dot3(a, a);
}

ss_norms ss_norms_compute(int32_t count, const double *weight, const double (*u)[3],
                          const double (*reference)[3])
{
    double peak = 0.0, peak_error = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        double d[3];
        ss_sub3(d, u[i], reference[i]);
        if (!isfinite(square(d))) {
            return (ss_norms){(double)NAN, (double)NAN};
        }
        peak = fmax(peak, square(reference[i]));
        peak_error = fmax(peak_error, square(d));
    }
    return (ss_norms){.field = ss_norms_apart(count, weight, u, reference),
                      .peak = peak > 0.0 ? sqrt(peak_error / peak) : (double)NAN};
}

double ss_norms_apart(int32_t count, const double *weight, const double (*a)[3],
                      const double (*b)[3])
{
    double error = 0.0, size = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        const double w = weight != NULL ? weight[i] : 1.0;
        double d[3];
        ss_sub3(d, a[i], b[i]);
        error += w * square(d);
        size += w * square(b[i]);
    }
    return size > 0.0 && isfinite(error) ? sqrt(error / size) : (double)NAN;
}

double ss_norms_force(const double force[3], const double direction[3], double reference)
{
    const double along = ss_dot3(force, direction);
    return isfinite(along) && reference != 0.0 ? fabs(along - reference) / fabs(reference)
                                               : (double)NAN;
}

double ss_norms_amplitude(int32_t count, const double *weight, const double (*u)[3],
                          const double (*reference)[3])
{
    double product = 0.0, size = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        product += weight[i] * ss_dot3(u[i], reference[i]);
        size += weight[i] * square(u[i]);
    }
    return size > 0.0 ? product / size : (double)NAN;
}
