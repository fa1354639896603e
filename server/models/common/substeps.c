/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/substeps.h"

#include <math.h>

double ss_substeps_needed(const ss_substeps *steps, double stable)
{
    return ceil(steps->left / stable - 1e-9);
}

void ss_substeps_plan(const ss_substeps *steps, double stable, double needed, double *out_h,
                      double *out_fraction)
{
    const double by_time = ss_substeps_needed(steps, stable);
    const double by_way = ceil((1.0 - steps->path) * steps->motion - 1e-9);
    const double available = fmax(1.0, (double)(steps->most - steps->taken_count));
    const double parts = fmin(fmax(fmax(by_time, by_way), 1.0), available);
    const double h = fmin(steps->left / parts, stable);
    const double way = 1.0 - steps->path;
    *out_h = h;
    *out_fraction = needed > available ? way * (h / steps->left) : way / parts;
}

double ss_substeps_next(const ss_substeps *steps, double fraction)
{
    return 1.0 - steps->path - fraction < 1e-12 ? 1.0 : steps->path + fraction;
}

bool ss_clamp_displacements(int32_t node_count, double limit, ss_real *u, ss_real *v)
{
    bool is_any = false;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)node_count; at += 4) {
        const double x = (double)u[at], y = (double)u[at + 1], z = (double)u[at + 2];
        const double length = sqrt(x * x + y * y + z * z);
        for (ptrdiff_t a = at; length > limit && a < at + 3; ++a) {
            u[a] = (ss_real)((double)u[a] * (limit / length));
            v[a] = 0;
            is_any = true;
        }
    }
    return is_any;
}
