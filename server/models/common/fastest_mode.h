/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The fastest motion of an elastic body at rest: where a power iteration starts near its end.
 * Thread: set-up only. */
#include <stdint.h>

#include "rt/real.h"
#include "softsim/types.h"

/* out += K x, over quads. */
typedef void ss_stiffness_product(void *owner, const ss_real *x, ss_real *out);

/* Improves `mode`, quads of `node_count` nodes (padded), towards the eigenvector of the largest
 * eigenvalue of M^-1 K, `mobility` the diagonal of M^-1 with 0 on axes that cannot move: until the
 * residual is below `residual` of the quotient, or after `most` products. */
softsim_status ss_find_fastest_mode(int32_t node_count, const ss_real *mobility,
                                    ss_stiffness_product *product, void *owner, double residual,
                                    int32_t most, ss_real *mode);
