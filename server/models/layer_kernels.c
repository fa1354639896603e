/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/layer_kernels.h"
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
 * of which each end gives the half. Below s = 0.7 g goes on as a line, above root 2 it stays. As
 * printed, without rest distances and with the well at root 3, the layer bursts.
 *
 * Displacements and velocities of a particle lie side by side: where a pair is one register, the
 * velocity gradient comes with the other at no cost. Rejected: eight particles in eight lanes with
 * gathers and transposes, which takes as long per pair and needs its own scatter.
 */
#include <math.h>
#include <stddef.h>

#include "models/wide.h"

static void place(const ss_layer_pass *pass)
{
    const ss_layer *layer = pass->layer;
    const ss_quad none = ss_quad_all(0);
    for (int32_t k = 0; k < pass->near_count; ++k) {
        const ptrdiff_t p = pass->near[k];
        const ptrdiff_t node = pass->node_of[p];
        ss_quad u = none;
        ss_quad v = none;
        if (node >= 0) {
            u = ss_quad_load(pass->u + 4 * node);
            v = pass->v != NULL ? ss_quad_load(pass->v + 4 * node) : none;
        } else {
            u = ss_quad_load(pass->offset + 4 * p);
            for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
                const ptrdiff_t n = 4 * (ptrdiff_t)layer->tie_node[t];
                const ss_quad share = ss_quad_all(layer->tie[t]);
                u = ss_quad_fma(share, ss_quad_load(pass->u + n), u);
                if (pass->v != NULL) {
                    v = ss_quad_fma(share, ss_quad_load(pass->v + n), v);
                }
            }
        }
        ss_quad_store(pass->state + 8 * p, u);
        ss_quad_store(pass->state + 8 * p + 4, v);
        ss_quad_store(pass->particle_force + 4 * p, none);
    }
}

static void give(const ss_layer_pass *pass)
{
    const ss_layer *layer = pass->layer;
    for (int32_t k = 0; k < pass->near_count; ++k) {
        const ptrdiff_t p = pass->near[k];
        const ptrdiff_t node = pass->node_of[p];
        const ss_quad f = ss_quad_load(pass->particle_force + 4 * p);
        if (node >= 0) {
            ss_real *at = pass->force + 4 * node;
            ss_quad_store(at, ss_quad_add(ss_quad_load(at), f));
            continue;
        }
        for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
            ss_real *at = pass->force + 4 * (ptrdiff_t)layer->tie_node[t];
            ss_quad_store(at, ss_quad_fma(ss_quad_all(layer->tie[t]), f, ss_quad_load(at)));
        }
    }
}

static void strain(const ss_layer_pass *pass)
{
    const ss_layer *layer = pass->layer;
    for (int32_t k = 0; k < pass->point_count; ++k) {
        const ptrdiff_t p = pass->point[k];
        const ss_pair own = ss_pair_load(pass->state + 8 * p);
        ss_pair b[3] = {ss_pair_all(0), ss_pair_all(0), ss_pair_all(0)};
        ss_pair spread = ss_pair_all(0);
        for (ptrdiff_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
            const ss_real *row = layer->pair + 4 * t;
            const ss_pair d =
                ss_pair_sub(ss_pair_load(pass->state + 8 * (ptrdiff_t)layer->neighbour[t]), own);
            for (int c = 0; c < 3; ++c) {
                b[c] = ss_pair_fma(ss_pair_all(row[c]), d, b[c]);
            }
            spread = ss_pair_fma(ss_pair_mul(ss_pair_all(row[3]), d), d, spread);
        }
        static const int moment[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
        const ss_real *a = layer->moment + 8 * p;
        for (int c = 0; c < 3; ++c) {
            ss_pair h = ss_pair_mul(ss_pair_all(a[moment[0][c]]), b[0]);
            h = ss_pair_fma(ss_pair_all(a[moment[1][c]]), b[1], h);
            h = ss_pair_fma(ss_pair_all(a[moment[2][c]]), b[2], h);
            ss_pair_store(pass->gradient + 8 * (ptrdiff_t)(1 + 3 * k + c), h);
            spread = ss_pair_fnma(h, b[c], spread);
        }
        ss_pair_store(pass->spread + 8 * (ptrdiff_t)k, spread);
    }
}

static void push(const ss_layer_pass *pass)
{
    const ss_layer *layer = pass->layer;
    for (int32_t k = 0; k < pass->point_count; ++k) {
        const ptrdiff_t p = pass->point[k];
        const ss_real *a = layer->moment + 8 * p;
        const ss_real *stress = pass->stress + 8 * (ptrdiff_t)(1 + 3 * k);
        const ss_real *gradient = pass->gradient + 8 * (ptrdiff_t)(1 + 3 * k);
        const ss_quad kappa = ss_quad_all(pass->coefficient[2 * k]);
        const ss_quad own = ss_quad_load(pass->state + 8 * p);
        static const int moment[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
        ss_quad m[3];
        for (int c = 0; c < 3; ++c) {
            m[c] = ss_quad_fnma(kappa, ss_quad_load(gradient + 8 * c), ss_quad_all(0));
            for (int d = 0; d < 3; ++d) {
                m[c] =
                    ss_quad_fnma(ss_quad_all(a[moment[d][c]]), ss_quad_load(stress + 8 * d), m[c]);
            }
        }
        ss_quad sum = ss_quad_all(0);
        for (ptrdiff_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
            const ptrdiff_t q = layer->neighbour[t];
            const ss_real *row = layer->pair + 4 * t;
            const ss_quad d = ss_quad_sub(ss_quad_load(pass->state + 8 * q), own);
            ss_quad f = ss_quad_mul(ss_quad_mul(kappa, ss_quad_all(row[3])), d);
            for (int c = 0; c < 3; ++c) {
                f = ss_quad_fma(ss_quad_all(row[c]), m[c], f);
            }
            ss_real *at = pass->particle_force + 4 * q;
            ss_quad_store(at, ss_quad_sub(ss_quad_load(at), f));
            sum = ss_quad_add(sum, f);
        }
        ss_real *at = pass->particle_force + 4 * p;
        ss_quad_store(at, ss_quad_add(ss_quad_load(at), sum));
    }
}

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

/* x is at most, or at least, the number. */
static inline ss_quad no_more(ss_quad x, ss_real most)
{
    const ss_quad none = ss_quad_all(0);
    return ss_quad_sub(none, ss_quad_most(ss_quad_sub(none, x), ss_quad_all(-most)));
}

/* g/s of four pairs from their q. */
static inline ss_quad cohesion(ss_quad q)
{
    const ss_real core = (ss_real)SS_LAYER_CORE;
    const ss_real slope = (ss_real)(-2.0 / (SS_LAYER_CORE * SS_LAYER_CORE * SS_LAYER_CORE) +
                                    4.0 / (SS_LAYER_CORE * SS_LAYER_CORE * SS_LAYER_CORE *
                                           SS_LAYER_CORE * SS_LAYER_CORE));
    const ss_quad one = ss_quad_all(1);
    const ss_quad inner = no_more(ss_quad_most(q, ss_quad_all(core * core - 1)), 1);
    const ss_quad square = ss_quad_add(one, inner);
    const ss_quad s = ss_quad_root(ss_quad_most(ss_quad_add(one, q), ss_quad_all((ss_real)1e-6)));
    const ss_quad below = no_more(ss_quad_sub(s, ss_quad_all(core)), 0);
    const ss_quad g =
        ss_quad_fma(ss_quad_all(slope), below, ss_quad_div(inner, ss_quad_mul(square, square)));
    return ss_quad_div(g, s);
}

/* phi(s) - phi(1) = (s - 1)^2 (2 s + 1)/(2 s^3), which is exact near rest; beyond the ends along
 * the tangent, and below with its curvature. */
static inline ss_quad well(ss_quad q)
{
    const ss_real core = (ss_real)SS_LAYER_CORE;
    const ss_real tail = (ss_real)SS_LAYER_TAIL;
    const ss_real at = 1 / core;
    const ss_real bend = -3 * at * at * at + 6 * at * at * at * at * at;
    const ss_real slope = (ss_real)1.5 * (at * at - at * at * at * at);
    const ss_quad none = ss_quad_all(0);
    const ss_quad s = ss_quad_root(ss_quad_most(ss_quad_add(ss_quad_all(1), q), none));
    const ss_quad inner = no_more(ss_quad_most(s, ss_quad_all(core)), tail);
    const ss_quad from_rest = ss_quad_sub(inner, ss_quad_all(1));
    const ss_quad below = no_more(ss_quad_sub(s, ss_quad_all(core)), 0);
    const ss_quad above = ss_quad_most(ss_quad_sub(s, ss_quad_all(tail)), none);
    ss_quad sum = ss_quad_mul(ss_quad_mul(from_rest, from_rest),
                              ss_quad_fma(ss_quad_all(2), inner, ss_quad_all(1)));
    sum = ss_quad_div(ss_quad_mul(ss_quad_all((ss_real)0.5), sum),
                      ss_quad_mul(ss_quad_mul(inner, inner), inner));
    sum = ss_quad_fma(ss_quad_all((ss_real)0.375), above, sum);
    return ss_quad_fma(ss_quad_fma(ss_quad_all(bend / 2), below, ss_quad_all(slope)), below, sum);
}

static double cohere(const ss_layer_pass *pass, bool wants_energy)
{
    const ss_layer *layer = pass->layer;
    double energy = 0.0;
    for (int32_t k = 0; k < pass->point_count; ++k) {
        const ptrdiff_t p = pass->point[k];
        const ptrdiff_t end = layer->pair_first[p + 1];
        const ss_quad own = ss_quad_load(pass->state + 8 * p);
        const ss_quad e = ss_quad_all((ss_real)0.75 * pass->coefficient[2 * k + 1]);
        ss_quad sum = ss_quad_all(0);
        ss_quad depth = ss_quad_all(0);
        for (ptrdiff_t t = layer->pair_first[p]; t < end; t += 4) {
            /* Four pairs, the last one again where there are fewer: it is then left out. */
            ss_quad u[4];
            ss_quad row[4];
            _Alignas(32) ss_real factor[4];
            for (int l = 0; l < 4; ++l) {
                const ptrdiff_t at = t + l < end ? t + l : end - 1;
                row[l] = ss_quad_load(layer->pair + 4 * at);
                u[l] = ss_quad_sub(ss_quad_load(pass->state + 8 * (ptrdiff_t)layer->neighbour[at]),
                                   own);
            }
            ss_quad_transpose(&row[0], &row[1], &row[2], &row[3]);
            ss_quad_transpose(&u[0], &u[1], &u[2], &u[3]);
            ss_quad rest2 = ss_quad_all(0);
            ss_quad q = ss_quad_all(0);
            for (int c = 0; c < 3; ++c) {
                row[c] = ss_quad_div(row[c], row[3]);
                rest2 = ss_quad_fma(row[c], row[c], rest2);
                q = ss_quad_fma(u[c], ss_quad_add(u[c], ss_quad_add(row[c], row[c])), q);
                u[c] = ss_quad_add(u[c], row[c]);
            }
            q = ss_quad_div(q, rest2);
            ss_quad_store(factor, ss_quad_div(ss_quad_mul(e, cohesion(q)), rest2));
            if (wants_energy) {
                _Alignas(32) ss_real share[4];
                for (int l = 0; l < 4; ++l) {
                    share[l] = t + l < end ? 1 : 0;
                }
                depth = ss_quad_fma(ss_quad_load(share), well(q), depth);
            }
            u[3] = ss_quad_all(0);
            ss_quad_transpose(&u[0], &u[1], &u[2], &u[3]);
            for (int l = 0; l < 4 && t + l < end; ++l) {
                ss_real *at = pass->particle_force + 4 * (ptrdiff_t)layer->neighbour[t + l];
                const ss_quad f = ss_quad_mul(ss_quad_all(factor[l]), u[l]);
                ss_quad_store(at, ss_quad_sub(ss_quad_load(at), f));
                sum = ss_quad_add(sum, f);
            }
        }
        ss_real *at = pass->particle_force + 4 * p;
        ss_quad_store(at, ss_quad_add(ss_quad_load(at), sum));
        energy += 0.5 * (double)pass->coefficient[2 * k + 1] * ss_quad_sum(depth);
    }
    return energy;
}

#ifdef SS_WIDE_AVX2
#define PATH      ss_layer_kernels_avx2
#define PATH_NAME "avx2+fma"
#else
#define PATH ss_layer_kernels_baseline
#ifdef SS_WIDE_SSE2
#define PATH_NAME "sse2"
#else
#define PATH_NAME "plain C"
#endif
#endif

extern const ss_layer_kernels PATH;
const ss_layer_kernels PATH = {.name = PATH_NAME,
                               .strain_cells = strain_cells,
                               .push_cells = push_cells,
                               .place = place,
                               .strain = strain,
                               .push = push,
                               .cohere = cohere,
                               .give = give};
