/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The network of Zhong et al. (2006) once more, small and plain: double precision, dense algebra,
 * straight from the printed equations, sharing no code with the model cnn-energy. The report uses
 * it to check what the model makes of the equations, and to show what readings of the paper do
 * that the model declines.
 *
 * In: points, how they are joined (a grid of rows and columns, triangles, or tetrahedra), rho,
 * cells held at zero, source cells. Out: potential, fluxes, forces, static shapes. Made for bodies
 * of up to some 1500 points: a solve costs a third of the cube of the free cells. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "rt/arena.h"

typedef struct ss_zhong_net {
    ss_arena arena;
    int32_t node_count, edge_count;
    bool is_volume;        /* areas are volumes, and fluxes go through faces */
    double (*rest)[3];     /* m */
    int32_t (*edge)[2];    /* i < j */
    double *conductance;   /* c_ij of (14), (15) or (17), times S: symmetric */
    double *length;        /* L0_ij, m */
    double *ratio;         /* a_ij: 1, or what the direction makes of it */
    double *area;          /* S_i, m^2 */
    double *rho;           /* a node; 1 until set */
    uint8_t *is_held;      /* cells at v = 0, nodes that stay */
    uint8_t *is_source;    /* chi */
    double *potential;     /* ghat for I = 1 on the sources */
    double *flux;          /* q_ij = rho_ij |ghat_i - ghat_j| / L0_ij^2 */
    double flux_strain;    /* Qhat = sum q L0^2 */
    double most_current;   /* K/ghat of the contact's cell; 0: no bound */
    double current;        /* I of the last static shape */
    int32_t unknown_count; /* free nodes */
    int32_t *unknown;      /* node to its place among them, -1 */
} ss_zhong_net;

/* A tube of `rows` rings of `columns` points, node row * columns + column: (14), and with
 * `across` (rho around over rho along) (15). NULL when out of memory, as all of these. */
ss_zhong_net *ss_zhong_net_tube(int32_t rows, int32_t columns, const double (*position)[3],
                                double across);
/* Triangles: (17), on a rim one triangle. `axis` (unit) is the direction along which rho is taken
 * as it is and across which times `across`; NULL for isotropic material. */
ss_zhong_net *ss_zhong_net_triangles(int32_t node_count, const double (*position)[3],
                                     int32_t triangle_count, const int32_t (*triangle)[3],
                                     const double axis[3], double across);
/* Six triangles round node 0, which is the source; the others are held. NULL: out of memory. */
ss_zhong_net *ss_zhong_net_hexagon(double edge_m, int32_t out_triangle[6][3]);
/* Tetrahedra, the volume that the paper's conclusion asks for: (17) with the face that parts the
 * two cells in place of their common line, S the volume of a cell. */
ss_zhong_net *ss_zhong_net_tetrahedra(int32_t node_count, const double (*position)[3],
                                      int32_t tetrahedron_count, const int32_t (*tetrahedron)[4]);
void ss_zhong_net_destroy(ss_zhong_net **net);

/* The discrete Poisson equation (18) for a unit source, and the fluxes. False when out of memory.
 * Call after rho, is_held and is_source are set. */
bool ss_zhong_net_solve(ss_zhong_net *net);
/* rho_ij of (26): a_ij times the harmonic mean. */
double ss_zhong_net_rho(const ss_zhong_net *net, int32_t edge);
/* Sum over j of q_ij (x_i - x_j) for all nodes; three values a node. */
void ss_zhong_net_pull(const ss_zhong_net *net, const double (*x)[3], double (*out)[3]);
/* Q = 1/2 sum q (|P_ij|^2 - L0^2) at displacements u. */
double ss_zhong_net_strain(const ss_zhong_net *net, const double (*u)[3]);

/* The one static shape of the closure, I = E max(0, Q/Qhat), under `force` (three a node), by
 * bisection for I: for given I the shape is linear, and its strain falls with I. Not beyond
 * most_current. `stiffness` ks a node. Returns I, NaN when out of memory. */
double ss_zhong_net_static(ss_zhong_net *net, double modulus, const double *stiffness,
                           const double (*force)[3], double (*out_u)[3]);

/* The shape for a given current, (I L_q + ks) u = F - I L_q P0. False when out of memory or when
 * nothing holds a node. */
bool ss_zhong_net_shape(const ss_zhong_net *net, double current, const double *stiffness,
                        const double (*force)[3], double (*out_u)[3]);

/* Solves A x = b for `columns` right sides in place, A symmetric positive definite, n x n, of which
 * the lower triangle is used up. False when it is not positive definite. */
bool ss_zhong_cholesky(int32_t n, double *a, int32_t columns, double *b);
