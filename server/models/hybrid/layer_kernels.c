/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/layer_kernels.h"
/*
 * Forces of the particle layer. For a point i with neighbours j, u_ij = u_j - u_i:
 *
 *   B = sum_j u_ij (w X_ij)^T      H = F - I = B A^-1
 *   stress     f_i = sum_j V P A^-1 (w X_ij)
 *   residual   e_ij = u_ij - H X_ij,  f_i = sum_j kappa w e_ij,  kappa = beta mu V / sum w |X|^2
 *   together   f_ij = w [ M X_ij + kappa u_ij ],  M = V P A^-1 - kappa H
 *
 * with the energy kappa/2 sum w |e|^2 = kappa/2 (sum w |u_ij|^2 - H:B), whose two parts are summed
 * by axis on the way. The force is added to i and taken from j. Both are -dE/dx of V W(F) + kappa/2
 * sum w |e|^2, since sum w e X^T = 0 makes the change of H drop out of the second: momentum is kept
 * by pairs, and for affine motion the residual is nothing. So a pair needs w X and w alone, and M
 * is worked out once a point. The residual is needed: without it sub-lattices that the gradient
 * does not see drift apart.
 *
 * Cohesion, the Lennard-Jones term of the paper's eq. (8) with a rest distance for every pair and a
 * well of depth e: phi(s) = (s^-3 - 3/s)/2, s = r/r0. With q = s^2 - 1 = (2 X.u + |u|^2)/r0^2,
 * which is small where u is,
 *
 *   f_ij = 3 e/(2 r0^2) g/s x_ij,  g = s^-2 - s^-4 = q/(1 + q)^2
 *
 * of which each end gives the half, b w x_ij = b (w X_ij + w u_ij) with b = 3 e/(4 w r0^2) g/s: a
 * share more of w X and of w u in the sum above, so that a pair is walked through once. Eight
 * pairs are worked out at a time. Below s = 0.7 g goes on as a line, above root 2 it stays. As
 * printed, without rest distances and with the well at root 3, the layer bursts.
 *
 * Displacements and velocities of a particle lie side by side: where a pair is one register, the
 * velocity gradient comes with the other at no cost; without viscosity two neighbours lie there.
 * Rejected: eight particles in eight lanes with gathers and transposes, which takes as long per
 * pair and needs its own scatter; 1/s by a polynomial and Newton's method, which has more
 * operations than a root and a division take time.
 */
#include <math.h>
#include <stddef.h>

#include "models/common/wide.h"

/* State of particle p from its node, or from its tie. */
SS_INLINE void place_particle(const ss_layer_pass *pass, ptrdiff_t p, bool has_v)
{
    const ss_layer_near *near = pass->near;
    const ss_real *all_u = pass->u;
    const ss_real *all_v = pass->v;
    const ptrdiff_t node = near->node_of[p];
    ss_quad u;
    ss_quad v = ss_quad_all(0);
    if (node >= 0) {
        u = ss_quad_load(all_u + 4 * node);
        v = has_v ? ss_quad_load(all_v + 4 * node) : v;
    } else {
        const int32_t first = near->tie_first[p];
        const int32_t count = near->tie_first[p + 1] - first;
        const int32_t *tie_node = near->tie_node + first;
        const ss_real *tie = near->tie + first;
        u = ss_quad_load(near->offset + 4 * p);
        for (int32_t t = 0; t < count; ++t) {
            const ptrdiff_t n = 4 * (ptrdiff_t)tie_node[t];
            const ss_quad share = ss_quad_all(tie[t]);
            u = ss_quad_fma(share, ss_quad_load(all_u + n), u);
            v = has_v ? ss_quad_fma(share, ss_quad_load(all_v + n), v) : v;
        }
    }
    ss_quad_store(pass->state + 8 * p, u);
    ss_quad_store(pass->state + 8 * p + 4, v);
    ss_quad_store(pass->particle_force + 4 * p, ss_quad_all(0));
}

static void place(const ss_layer_pass *pass)
{
    if (pass->v != NULL) {
        for (int32_t k = 0; k < pass->near->count; ++k) {
            place_particle(pass, k, true);
        }
    } else {
        for (int32_t k = 0; k < pass->near->count; ++k) {
            place_particle(pass, k, false);
        }
    }
}

static void give(const ss_layer_pass *pass)
{
    const ss_layer_near *near = pass->near;
    ss_real *force = pass->force;
    for (ptrdiff_t k = 0; k < near->count; ++k) {
        const ptrdiff_t node = near->node_of[k];
        const ss_quad f = ss_quad_load(pass->particle_force + 4 * k);
        if (node >= 0) {
            ss_real *at = force + 4 * node;
            ss_quad_store(at, ss_quad_add(ss_quad_load(at), f));
            continue;
        }
        const int32_t first = near->tie_first[k];
        const int32_t count = near->tie_first[k + 1] - first;
        const int32_t *tie_node = near->tie_node + first;
        const ss_real *tie = near->tie + first;
        for (int32_t t = 0; t < count; ++t) {
            ss_real *at = force + 4 * (ptrdiff_t)tie_node[t];
            ss_quad_store(at, ss_quad_fma(ss_quad_all(tie[t]), f, ss_quad_load(at)));
        }
    }
}

static const int moment_at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

/* Columns of H and Hdot of point k, of displacements and velocities side by side. */
static inline void strain_both(const ss_layer_pass *pass, ptrdiff_t k)
{
    const ss_layer_near *near = pass->near;
    const ss_pair own = ss_pair_load(pass->state + 8 * k);
    ss_pair b[3] = {ss_pair_all(0), ss_pair_all(0), ss_pair_all(0)};
    ss_pair spread = ss_pair_all(0);
    for (ptrdiff_t t = near->pair_first[k]; t < near->pair_first[k + 1]; ++t) {
        const ss_real *row = near->pair + 4 * t;
        const ss_pair d =
            ss_pair_sub(ss_pair_load(pass->state + 8 * (ptrdiff_t)near->neighbour[t]), own);
        for (int c = 0; c < 3; ++c) {
            b[c] = ss_pair_fma(ss_pair_all(row[c]), d, b[c]);
        }
        spread = ss_pair_fma(ss_pair_mul(ss_pair_all(row[3]), d), d, spread);
    }
    const ss_real *a = near->moment + 8 * k;
    for (int c = 0; c < 3; ++c) {
        ss_pair h = ss_pair_mul(ss_pair_all(a[moment_at[0][c]]), b[0]);
        h = ss_pair_fma(ss_pair_all(a[moment_at[1][c]]), b[1], h);
        h = ss_pair_fma(ss_pair_all(a[moment_at[2][c]]), b[2], h);
        ss_pair_store(pass->gradient + 8 * (1 + 3 * k + c), h);
        spread = ss_pair_fnma(h, b[c], spread);
    }
    ss_pair_store(pass->spread + 8 * k, spread);
}

/* Of displacements alone, two neighbours at a time. */
static inline void strain_one(const ss_layer_pass *pass, ptrdiff_t k)
{
    const ss_layer_near *near = pass->near;
    const int32_t *neighbour = near->neighbour + near->pair_first[k];
    const ss_real *pair = near->pair + 4 * (ptrdiff_t)near->pair_first[k];
    const int32_t count = near->pair_first[k + 1] - near->pair_first[k];
    const ss_quad own = ss_quad_load(pass->state + 8 * k);
    const ss_pair twice = ss_pair_twice(own);
    ss_pair two[4] = {ss_pair_all(0), ss_pair_all(0), ss_pair_all(0), ss_pair_all(0)};
    for (int32_t t = 0; t + 1 < count; t += 2) {
        const ss_pair row = ss_pair_load_any(pair + 4 * t);
        const ss_pair d = ss_pair_sub(ss_pair_join(pass->state + 8 * (ptrdiff_t)neighbour[t],
                                                   pass->state + 8 * (ptrdiff_t)neighbour[t + 1]),
                                      twice);
        for (int c = 0; c < 3; ++c) {
            two[c] = ss_pair_fma(ss_pair_lane(row, c), d, two[c]);
        }
        two[3] = ss_pair_fma(ss_pair_mul(ss_pair_last(row), d), d, two[3]);
    }
    ss_quad b[4];
    for (int c = 0; c < 4; ++c) {
        b[c] = ss_pair_both(two[c]);
    }
    if (count % 2 != 0) {
        const ss_real *row = pair + 4 * (count - 1);
        const ss_quad d =
            ss_quad_sub(ss_quad_load(pass->state + 8 * (ptrdiff_t)neighbour[count - 1]), own);
        for (int c = 0; c < 3; ++c) {
            b[c] = ss_quad_fma(ss_quad_all(row[c]), d, b[c]);
        }
        b[3] = ss_quad_fma(ss_quad_mul(ss_quad_all(row[3]), d), d, b[3]);
    }
    const ss_real *a = near->moment + 8 * k;
    for (int c = 0; c < 3; ++c) {
        ss_quad h = ss_quad_mul(ss_quad_all(a[moment_at[0][c]]), b[0]);
        h = ss_quad_fma(ss_quad_all(a[moment_at[1][c]]), b[1], h);
        h = ss_quad_fma(ss_quad_all(a[moment_at[2][c]]), b[2], h);
        ss_quad_store(pass->gradient + 8 * (1 + 3 * k + c), h);
        b[3] = ss_quad_fnma(h, b[c], b[3]);
    }
    ss_quad_store(pass->spread + 8 * k, b[3]);
}

static void strain(const ss_layer_pass *pass)
{
    for (ptrdiff_t k = 0; k < pass->near->point_count; ++k) {
        if (pass->v != NULL) {
            strain_both(pass, k);
        } else {
            strain_one(pass, k);
        }
    }
}

/* ---- cohesion ---- */

/* g/s of eight pairs from their q. */
static inline ss_pair cohesion(ss_pair q)
{
    const ss_real core = (ss_real)SS_LAYER_CORE;
    const ss_real slope = (ss_real)(-2.0 / (SS_LAYER_CORE * SS_LAYER_CORE * SS_LAYER_CORE) +
                                    4.0 / (SS_LAYER_CORE * SS_LAYER_CORE * SS_LAYER_CORE *
                                           SS_LAYER_CORE * SS_LAYER_CORE));
    const ss_pair one = ss_pair_all(1);
    const ss_pair inner = ss_pair_least(ss_pair_most(q, ss_pair_all(core * core - 1)), one);
    const ss_pair fourth = ss_pair_mul(ss_pair_add(one, inner), ss_pair_add(one, inner));
    const ss_pair s = ss_pair_root(ss_pair_most(ss_pair_add(one, q), ss_pair_all((ss_real)1e-6)));
    const ss_pair below = ss_pair_least(ss_pair_sub(s, ss_pair_all(core)), ss_pair_all(0));
    const ss_pair bent = ss_pair_mul(ss_pair_mul(ss_pair_all(slope), below), fourth);
    return ss_pair_div(ss_pair_add(inner, bent), ss_pair_mul(fourth, s));
}

/* phi(s) - phi(1) = (s - 1)^2 (2 s + 1)/(2 s^3), which is exact near rest; beyond the ends along
 * the tangent, and below with its curvature. */
static inline ss_pair well(ss_pair q)
{
    const ss_real core = (ss_real)SS_LAYER_CORE;
    const ss_real tail = (ss_real)SS_LAYER_TAIL;
    const ss_real at = 1 / core;
    const ss_real bend = -3 * at * at * at + 6 * at * at * at * at * at;
    const ss_real slope = (ss_real)1.5 * (at * at - at * at * at * at);
    const ss_pair none = ss_pair_all(0);
    const ss_pair s = ss_pair_root(ss_pair_most(ss_pair_add(ss_pair_all(1), q), none));
    const ss_pair inner = ss_pair_least(ss_pair_most(s, ss_pair_all(core)), ss_pair_all(tail));
    const ss_pair from_rest = ss_pair_sub(inner, ss_pair_all(1));
    const ss_pair below = ss_pair_least(ss_pair_sub(s, ss_pair_all(core)), none);
    const ss_pair above = ss_pair_most(ss_pair_sub(s, ss_pair_all(tail)), none);
    ss_pair sum = ss_pair_mul(ss_pair_mul(from_rest, from_rest),
                              ss_pair_fma(ss_pair_all(2), inner, ss_pair_all(1)));
    sum = ss_pair_div(ss_pair_mul(ss_pair_all((ss_real)0.5), sum),
                      ss_pair_mul(ss_pair_mul(inner, inner), inner));
    sum = ss_pair_fma(ss_pair_all((ss_real)0.375), above, sum);
    return ss_pair_fma(ss_pair_fma(ss_pair_all(bend / 2), below, ss_pair_all(slope)), below, sum);
}

/* ---- forces of the points ---- */
/* A point's pairs go in eights. A register has the fourths of them, first and fifth, second and
 * sixth, and so on: turned round, one component of all eight, in their order.
 */

/* What the pairs of a point have in common. */
typedef struct point_of {
    _Alignas(32) ss_real m[12]; /* columns of M, quads */
    ss_quad own;
    ss_pair kappa, e;
} point_of;

SS_INLINE void point_at(const ss_layer_pass *pass, ptrdiff_t k, point_of *out)
{
    const ss_real *a = pass->near->moment + 8 * k;
    const ss_real *stress = pass->stress + 8 * (1 + 3 * k);
    const ss_real *gradient = pass->gradient + 8 * (1 + 3 * k);
    const ss_quad kappa = ss_quad_all(pass->coefficient[2 * k]);
    for (int c = 0; c < 3; ++c) {
        ss_quad m = ss_quad_fnma(kappa, ss_quad_load(gradient + 8 * c), ss_quad_all(0));
        for (int d = 0; d < 3; ++d) {
            m = ss_quad_fnma(ss_quad_all(a[moment_at[d][c]]), ss_quad_load(stress + 8 * d), m);
        }
        ss_quad_store(out->m + 4 * c, m);
    }
    out->own = ss_quad_load(pass->state + 8 * k);
    out->kappa = ss_pair_all(pass->coefficient[2 * k]);
    out->e = ss_pair_all((ss_real)0.75 * pass->coefficient[2 * k + 1]);
}

/* Where the pairs of a point are; locals, since stores to forces could be to anything. */
typedef struct pairs_of {
    const int32_t *neighbour;
    const ss_real *pair, *scale, *state;
    ss_real *force; /* of the particles */
} pairs_of;

SS_INLINE void take(ss_real *at, ss_quad f)
{
    ss_quad_store(at, ss_quad_sub(ss_quad_load(at), f));
}

/* Eight pairs, of which there are `left`: their force on the point, w (M X + kappa u) + b (w X +
 * w u), which the neighbours lose, and to *depth their wells. Pairs that are not there have no
 * w X, w and u, and come to nothing. */
SS_INLINE void push_eight(const pairs_of *of, const point_of *point, int32_t left, bool is_cohesive,
                          bool wants_energy, ss_pair *sum, ss_pair *depth)
{
    static const _Alignas(32) ss_real none[4] = {0};
    _Alignas(32) ss_real own[4];
    ss_pair row[4];
    ss_pair u[4];
    ss_pair f[4];
    ss_quad_store(own, point->own);
    for (int j = 0; j < 4; ++j) {
        const bool has_first = j < left;
        const bool has_second = j + 4 < left;
        row[j] = ss_pair_join(has_first ? of->pair + 4 * j : none,
                              has_second ? of->pair + 4 * (j + 4) : none);
        u[j] = ss_pair_join(has_first ? of->state + 8 * (ptrdiff_t)of->neighbour[j] : own,
                            has_second ? of->state + 8 * (ptrdiff_t)of->neighbour[j + 4] : own);
        u[j] = ss_pair_sub(u[j], ss_pair_twice(point->own));
    }
    ss_pair_transpose(&row[0], &row[1], &row[2], &row[3]);
    ss_pair_transpose(&u[0], &u[1], &u[2], &u[3]);
    ss_pair apart = ss_pair_mul(row[3], point->kappa);
    ss_pair along = ss_pair_all(0); /* b */
    if (is_cohesive) {
        const ss_pair scale = ss_pair_load_any(of->scale);
        ss_pair q = ss_pair_all(0);
        for (int c = 0; c < 3; ++c) {
            q = ss_pair_fma(u[c], ss_pair_fma(row[3], u[c], ss_pair_add(row[c], row[c])), q);
        }
        q = ss_pair_mul(q, scale);
        along = ss_pair_mul(ss_pair_mul(point->e, cohesion(q)), scale);
        apart = ss_pair_fma(row[3], along, apart);
        *depth = wants_energy ? ss_pair_add(*depth, well(q)) : *depth;
    }
    for (int c = 0; c < 3; ++c) {
        f[c] = ss_pair_mul(apart, u[c]);
        for (int d = 0; d < 3; ++d) {
            f[c] = ss_pair_fma(row[d], ss_pair_all(point->m[4 * d + c]), f[c]);
        }
        f[c] = is_cohesive ? ss_pair_fma(along, row[c], f[c]) : f[c];
    }
    f[3] = ss_pair_all(0);
    ss_pair_transpose(&f[0], &f[1], &f[2], &f[3]);
    *sum = ss_pair_add(*sum, ss_pair_add(ss_pair_add(f[0], f[1]), ss_pair_add(f[2], f[3])));
    for (int j = 0; j < 4; ++j) {
        if (j < left) {
            take(of->force + 4 * (ptrdiff_t)of->neighbour[j], ss_pair_first(f[j]));
        }
    }
    for (int j = 0; j < 4; ++j) {
        if (j + 4 < left) {
            take(of->force + 4 * (ptrdiff_t)of->neighbour[j + 4], ss_pair_second(f[j]));
        }
    }
}

/* The same of one or two pairs, which eights leave over in the middle of a lattice: side by side.
 */
SS_INLINE void push_two(const pairs_of *of, const point_of *point, int32_t left, bool is_cohesive,
                        bool wants_energy, ss_pair *sum, ss_pair *depth)
{
    static const _Alignas(32) ss_real none[4] = {0};
    static const _Alignas(32) ss_real once[8] = {1, 0, 0, 0, 1, 0, 0, 0};
    _Alignas(32) ss_real own[4];
    ss_quad_store(own, point->own);
    const ss_pair row = ss_pair_join(of->pair, left > 1 ? of->pair + 4 : none);
    const ss_pair there =
        ss_pair_join(of->state + 8 * (ptrdiff_t)of->neighbour[0],
                     left > 1 ? of->state + 8 * (ptrdiff_t)of->neighbour[1] : own);
    const ss_pair u = ss_pair_sub(there, ss_pair_twice(point->own));
    const ss_pair w = ss_pair_last(row);
    ss_pair apart = ss_pair_mul(w, point->kappa);
    ss_pair along = ss_pair_all(0);
    if (is_cohesive) {
        const ss_pair scale = ss_pair_each(of->scale);
        const ss_pair by_axis = ss_pair_mul(u, ss_pair_fma(w, u, ss_pair_add(row, row)));
        const ss_pair q =
            ss_pair_mul(ss_pair_add(ss_pair_add(ss_pair_lane(by_axis, 0), ss_pair_lane(by_axis, 1)),
                                    ss_pair_lane(by_axis, 2)),
                        scale);
        along = ss_pair_mul(ss_pair_mul(point->e, cohesion(q)), scale);
        apart = ss_pair_fma(w, along, apart);
        *depth = wants_energy ? ss_pair_fma(ss_pair_load(once), well(q), *depth) : *depth;
    }
    ss_pair f = ss_pair_mul(apart, u);
    for (int c = 0; c < 3; ++c) {
        f = ss_pair_fma(ss_pair_lane(row, c),
                        ss_pair_twice(ss_quad_load(point->m + (ptrdiff_t)4 * c)), f);
    }
    f = is_cohesive ? ss_pair_fma(along, ss_pair_xyz(row), f) : f;
    *sum = ss_pair_add(*sum, f);
    take(of->force + 4 * (ptrdiff_t)of->neighbour[0], ss_pair_first(f));
    if (left > 1) {
        take(of->force + 4 * (ptrdiff_t)of->neighbour[1], ss_pair_second(f));
    }
}

SS_INLINE double push_point(const ss_layer_pass *pass, ptrdiff_t k, bool is_cohesive,
                            bool wants_energy)
{
    const ss_layer_near *near = pass->near;
    const ptrdiff_t first = near->pair_first[k];
    pairs_of of = {.neighbour = near->neighbour + first,
                   .pair = near->pair + 4 * first,
                   .scale = near->pair_scale + first,
                   .state = pass->state,
                   .force = pass->particle_force};
    int32_t left = near->pair_first[k + 1] - near->pair_first[k];
    ss_pair sum = ss_pair_all(0);
    ss_pair depth = ss_pair_all(0);
    point_of point;
    point_at(pass, k, &point);
    for (; left >= 8; left -= 8) {
        push_eight(&of, &point, 8, is_cohesive, wants_energy, &sum, &depth);
        of.neighbour += 8;
        of.pair += 32;
        of.scale += 8;
    }
    if (left > 2) {
        push_eight(&of, &point, left, is_cohesive, wants_energy, &sum, &depth);
    } else if (left > 0) {
        push_two(&of, &point, left, is_cohesive, wants_energy, &sum, &depth);
    }
    ss_real *at = of.force + 4 * k;
    ss_quad_store(at, ss_quad_add(ss_quad_load(at), ss_pair_both(sum)));
    return 0.5 * (double)pass->coefficient[2 * k + 1] * ss_pair_sum(depth);
}

SS_INLINE double push_points(const ss_layer_pass *pass, bool is_cohesive, bool wants_energy)
{
    double energy = 0.0;
    for (int32_t k = 0; k < pass->near->point_count; ++k) {
        energy += push_point(pass, k, is_cohesive, wants_energy);
    }
    return energy;
}

static double push(const ss_layer_pass *pass, bool is_cohesive, bool wants_energy)
{
    return !is_cohesive   ? push_points(pass, false, false)
           : wants_energy ? push_points(pass, true, true)
                          : push_points(pass, true, false);
}

/* ---- cells ---- */

static void strain_cells(const ss_layer_cells *cells, const ss_real *u, const ss_real *v)
{
    for (int32_t k = 0; k < cells->count; ++k) {
        ss_quad h[3] = {ss_quad_all(0), ss_quad_all(0), ss_quad_all(0)};
        ss_quad rate[3] = {ss_quad_all(0), ss_quad_all(0), ss_quad_all(0)};
        for (ptrdiff_t t = cells->first[k]; t < cells->first[k + 1]; ++t) {
            const ss_real *row = cells->row + 4 * t;
            const ptrdiff_t at = 4 * (ptrdiff_t)cells->node[t];
            const ss_quad x = ss_quad_load(u + at);
            for (int c = 0; c < 3; ++c) {
                h[c] = ss_quad_fma(ss_quad_all(row[c]), x, h[c]);
            }
            if (v != NULL) {
                const ss_quad w = ss_quad_load(v + at);
                for (int c = 0; c < 3; ++c) {
                    rate[c] = ss_quad_fma(ss_quad_all(row[c]), w, rate[c]);
                }
            }
        }
        for (int c = 0; c < 3; ++c) {
            ss_real *out = cells->gradient + 8 * (ptrdiff_t)(1 + 3 * k + c);
            ss_quad_store(out, h[c]);
            ss_quad_store(out + 4, rate[c]);
        }
    }
}

static void push_cells(const ss_layer_cells *cells, ss_real *force)
{
    for (int32_t k = 0; k < cells->count; ++k) {
        const ss_real *stress = cells->stress + 8 * (ptrdiff_t)(1 + 3 * k);
        const ss_quad p[3] = {ss_quad_load(stress), ss_quad_load(stress + 8),
                              ss_quad_load(stress + 16)};
        for (ptrdiff_t t = cells->first[k]; t < cells->first[k + 1]; ++t) {
            const ss_real *row = cells->row + 4 * t;
            ss_real *at = force + 4 * (ptrdiff_t)cells->node[t];
            ss_quad f = ss_quad_load(at);
            for (int c = 0; c < 3; ++c) {
                f = ss_quad_fma(ss_quad_all(row[c]), p[c], f);
            }
            ss_quad_store(at, f);
        }
    }
}

SS_KERNEL_TABLE(ss_layer_kernels, .strain_cells = strain_cells, .push_cells = push_cells,
                .place = place, .strain = strain, .push = push, .give = give);
