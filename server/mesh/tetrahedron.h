/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The linear tetrahedron at rest: its volume and the gradients of its four shape functions.
 *
 * With edges D = [X1 - X0, X2 - X0, X3 - X0], V = det D / 6 and the rows of D^-1 are grad N1,
 * grad N2, grad N3; grad N0 is minus their sum. A field with nodal values u then has the gradient
 * H = sum_a u_a (grad N_a)^T. Double precision. Thread: any, RT-safe.
 */
#include "rt/vec.h"

/* Volume in m^3, below 0 for an inverted element; gradients in 1/m (not finite where V = 0). */
static inline double ss_tetrahedron_gradients(const double x0[3], const double x1[3],
                                              const double x2[3], const double x3[3],
                                              double out_gradient[4][3])
{
    double d1[3], d2[3], d3[3];
    ss_sub3(d1, x1, x0);
    ss_sub3(d2, x2, x0);
    ss_sub3(d3, x3, x0);
    ss_cross3(out_gradient[1], d2, d3);
    ss_cross3(out_gradient[2], d3, d1);
    ss_cross3(out_gradient[3], d1, d2);
    const double determinant = ss_dot3(d1, out_gradient[1]);
    for (int a = 1; a < 4; ++a) {
        ss_scale3(out_gradient[a], out_gradient[a], 1.0 / determinant);
    }
    for (int k = 0; k < 3; ++k) {
        out_gradient[0][k] = -(out_gradient[1][k] + out_gradient[2][k] + out_gradient[3][k]);
    }
    return determinant / 6.0;
}
