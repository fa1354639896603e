/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The linear tetrahedron at rest: its volume and the gradients of its four shape functions.
 *
 * With edges D = [X1 - X0, X2 - X0, X3 - X0], V = det D / 6 and the rows of D^-1 are grad N1,
 * grad N2, grad N3; grad N0 is minus their sum. A field with nodal values u then has the gradient
 * H = sum_a u_a (grad N_a)^T. Double precision. Thread: any, RT-safe.
 *
 * And that of ten nodes, with corners 0 to 3, then one in the middle of each edge 01 02 03 12 13
 * 23, which need not be straight: its map at the four Gauss points of degree 2.
 */
#include <stdint.h>

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

enum { SS_TETRAHEDRON_NODES = 10, SS_TETRAHEDRON_POINTS = 4 };
/* Barycentric coordinates of Gauss point q: of corner q, and of the others. */
#define SS_TETRAHEDRON_NEAR 0.58541019662496852
#define SS_TETRAHEDRON_FAR  0.13819660112501050

/* Between corners k and j, or at k where they are one: the node's place among the ten. */
static inline int ss_tetrahedron_place(int k, int j)
{
    static const int8_t place[4][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}};
    return place[k][j];
}

/* Gradients of the barycentric coordinates at Gauss point q, 1/m, and the volume that it stands
 * for, m^3, below 0 where the element is inside out. */
static inline double ss_tetrahedron_point(const double (*position)[3],
                                          const int32_t node[SS_TETRAHEDRON_NODES], int q,
                                          double out_gradient[4][3])
{
    double c[4][3];
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 3; ++i) {
            c[k][i] = 0.0;
            for (int j = 0; j < 4; ++j) {
                const double l = j == q ? SS_TETRAHEDRON_NEAR : SS_TETRAHEDRON_FAR;
                const double weight = j == k ? 4.0 * l - 1.0 : 4.0 * l;
                c[k][i] += weight * position[node[ss_tetrahedron_place(k, j)]][i];
            }
        }
    }
    /* The map's columns c_s - c_0 are the edges of a tetrahedron with the gradients wanted. */
    return 0.25 * ss_tetrahedron_gradients(c[0], c[1], c[2], c[3], out_gradient);
}
