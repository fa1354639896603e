/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Errors of a displacement field and of a force against a reference, as fractions:
 *
 *   field  sqrt(sum_i w_i |u_i - r_i|^2 / sum_i w_i |r_i|^2)
 *   peak   max_i |u_i - r_i| / max_i |r_i|
 *   force  |F.d - F_ref| / |F_ref|
 *
 * Prescribed nodes count: a run that does not honour them shows it. NaN where a reference is zero
 * or a value is not finite. Thread: any.
 */
#include <stdint.h>

typedef struct ss_norms {
    double field, peak;
} ss_norms;

ss_norms ss_norms_compute(int32_t count, const double *weight, const double (*u)[3],
                          const double (*reference)[3]);
/* `force` along the unit vector `direction`, against a reference along it. */
double ss_norms_force(const double force[3], const double direction[3], double reference);
/* sqrt(sum w |a - b|^2 / sum w |b|^2); weight NULL, here and in ss_norms_compute: equal weights. */
double ss_norms_apart(int32_t count, const double *weight, const double (*a)[3],
                      const double (*b)[3]);
/* The factor c that leaves the least of c u - reference: <u, r>_w / <u, u>_w; NaN where u is 0. */
double ss_norms_amplitude(int32_t count, const double *weight, const double (*u)[3],
                          const double (*reference)[3]);
