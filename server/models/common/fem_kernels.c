/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_element.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * again for AVX2 (256-bit vectors, fused multiply-add) and for the registers of AVX-512VL.
 *
 * Element e with corners 0..3, from displacements relative to corner 0:
 *
 *   H = sum_a (u_a - u_0) (grad N_a)^T,  D = 2E = H + H^T + H^T H,  f_a = -V P grad N_a,
 *   f_0 = -(f_1 + f_2 + f_3)
 *
 * so that rigid translation is free of rounding and forces add up to 0. Moduli carry the volume.
 * The laws stand in tissue_law.c; `stress` has them in the same order. A modulus lambda may be
 * split: the element's own part is in the blocks, the rest comes as a pressure of the nodes
 * (fem_average.c), of which an element takes the mean of its four.
 *
 * Where the time goes: about 145 operations of eight lanes an element block and as many loads,
 * shuffles and stores to bring 32 nodes in and 32 forces out. Forces are added node by node, since
 * one node may stand twice in a block; fem_blocks.c deals the elements so that it seldom does, for
 * a store that is loaded again at once stalls. Rejected: colouring (the colours of a tetrahedral
 * mesh scatter the nodes over memory), a force an element gathered by nodes (four times the bytes).
 */

/* Blocks summed in ss_real before a sum goes over to double. */
enum { RUN = 32 };

/* ---- sweeps ---- */

/* The mean of the corners' pressures. */
SS_INLINE ss_wide corner_mean(const element *e, const ss_real *pressure)
{
    _Alignas(32) ss_real lane[SS_WIDE_LANES];
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        const int32_t *at = e->at + k;
        lane[k] = (pressure[at[0]] + pressure[at[SS_FEM_LANES]]) +
                  (pressure[at[2 * SS_FEM_LANES]] + pressure[at[3 * SS_FEM_LANES]]);
    }
    return all(0.25) * ss_wide_load(lane);
}

SS_INLINE element element_at(const ss_fem_pass *pass, int32_t block, int lane)
{
    const ss_fem_blocks *blocks = pass->blocks;
    const ptrdiff_t b = block;
    element e = {.at = blocks->node + b * 4 * SS_FEM_LANES + lane,
                 .shape = blocks->shape + b * SS_FEM_SHAPES * SS_FEM_LANES + lane};
    const ss_real *modulus = blocks->modulus + b * SS_FEM_MODULI * SS_FEM_LANES + lane;
    e.lambda = ss_wide_load(modulus);
    e.mu = ss_wide_load(modulus + SS_FEM_LANES);
    e.kappa = ss_wide_load(blocks->kappa + b * SS_FEM_LANES + lane);
    e.pressure = all(0.0);
    e.h = gradient(&e, pass->u);
    e.volume = ss_wide_load(blocks->volume + b * SS_FEM_LANES + lane);
    if (pass->pressure) {
        e.pressure = e.volume * corner_mean(&e, pass->pressure);
    }
    return e;
}

SS_INLINE void force_of(ss_tissue_kind kind, bool is_viscous, ss_fem_pass *pass)
{
    const int32_t count = pass->blocks->count;
    ss_wide strain = all(0.0);
    for (int32_t first = 0; first < count; first += RUN) {
        const int32_t end = first + RUN < count ? first + RUN : count;
        sums sum = {all(0.0), all(0.0), strain};
        for (int32_t b = first; b < end; ++b) {
            for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
                element e = element_at(pass, b, lane);
                tensor rate;
                if (is_viscous) {
                    const ss_real *viscosity =
                        pass->blocks->viscosity + (ptrdiff_t)b * 2 * SS_FEM_LANES + lane;
                    e.phi = ss_wide_load(viscosity);
                    e.psi = ss_wide_load(viscosity + SS_FEM_LANES);
                    rate = gradient(&e, pass->v);
                }
                tensor p =
                    stress(kind, &e, is_viscous ? &rate : NULL, NULL, pass->wants_energy, &sum);
                for (int k = 0; k < 9; ++k) {
                    p.m[k / 3][k % 3] = all(0.0) - p.m[k / 3][k % 3];
                }
                spread(&e, &p, pass->out);
            }
        }
        pass->energy += ss_wide_sum(sum.energy);
        pass->power += ss_wide_sum(sum.power);
        strain = sum.strain;
    }
    const double largest = largest_lane(strain);
    pass->strain = largest > pass->strain ? largest : pass->strain;
}

static void force(ss_fem_pass *pass)
{
    const bool is_viscous = pass->v && pass->blocks->viscosity;
    if (is_viscous) {
        BY_LAW(pass->kind, force_of, true, pass)
    } else {
        BY_LAW(pass->kind, force_of, false, pass)
    }
}

/* ---- tangents ---- */

SS_INLINE void tangent_of(ss_tissue_kind kind, ss_fem_pass *pass)
{
    for (int32_t i = 0; i < pass->blocks->count * (SS_FEM_LANES / SS_WIDE_LANES); ++i) {
        const element e = element_at(pass, i / (SS_FEM_LANES / SS_WIDE_LANES),
                                     i % (SS_FEM_LANES / SS_WIDE_LANES) * SS_WIDE_LANES);
        const tensor x = gradient(&e, pass->x);
        ss_wide change = all(0.0);
        if (pass->change) {
            change = e.volume * corner_mean(&e, pass->change);
        }
        const tensor p = stress_change(kind, &e, &x, change);
        spread(&e, &p, pass->out);
    }
}

static void tangent(ss_fem_pass *pass){BY_LAW(pass->kind, tangent_of, pass)}

/* ---- dilatation ---- */

SS_INLINE void dilate_of(ss_tissue_kind kind, ss_fem_pass *pass)
{
    for (int32_t b = 0; b < pass->blocks->count; ++b) {
        for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
            const element e = element_at(pass, b, lane);
            ss_wide q;
            if (pass->x) {
                const tensor x = gradient(&e, pass->x);
                q = resisted_change(kind, &e.h, &x);
            } else {
                q = resisted(kind, &e.h);
            }
            _Alignas(32) ss_real share[SS_WIDE_LANES];
            ss_wide_store(
                share, q * ss_wide_load(pass->blocks->volume + SS_FEM_LANES * (ptrdiff_t)b + lane));
            for (int k = 0; k < SS_WIDE_LANES; ++k) {
                for (int a = 0; a < 4; ++a) {
                    pass->out[e.at[SS_FEM_LANES * a + k]] += share[k];
                }
            }
        }
    }
}

static void dilate(ss_fem_pass *pass)
{
    BY_LAW(pass->kind, dilate_of, pass)
}

/* ---- growth ---- */

/*
 * For nodal motions x of an element, dE(x) = sym(F^T dF) is the small strain of y_a = F^T x_a, so
 * that the first term of
 *
 *   V (dE : C : dE + S : dF^T dF) <= omega0^2 sum m |y|^2 + s V |dF|^2
 *
 * grows by at most |F|_2^2; and V (lambda + 2 mu) |dF|^2 <= omega0^2 sum m |x|^2, as motions
 * along one gradient show. So omega^2 <= omega0^2 (|F|_2^2 + s/(lambda + 2 mu)), s the largest
 * eigenvalue of S, and for the guard + |C|^2 + 2 (J0 - J) |F| with the same argument. Eigenvalues
 * of E are at most tr E/3 + sqrt(2/3) |dev E|.
 */
static void growth(const ss_fem_pass *pass, ss_real *out_growth, ss_real *out_ratio)
{
    for (int32_t b = 0; b < pass->blocks->count; ++b) {
        for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
            const element e = element_at(pass, b, lane);
            const symmetric d = twice_green(&e.h);
            const ss_wide t = trace_of(&d), third = all(1.0 / 3.0) * t;
            const ss_wide dev = ss_wide_most(ss_wide_fnma(third, t, contract(&d, &d)), all(0.0));
            const ss_wide most = ss_wide_fma(all(sqrt(2.0 / 3.0)), ss_wide_root(dev), third);
            /* kappa carries V and is the modulus lambda + 2 mu: no element of ours has 0 but spare
             * lanes. */
            const ss_wide kappa = ss_wide_below(all(0.0), e.kappa, e.kappa, all(1.0));
            const ss_wide s = ss_wide_fma(all(0.5) * e.lambda, t, e.mu * most) + e.pressure;
            ss_wide grown =
                all(1.0) + ss_wide_most(most, all(0.0)) + ss_wide_most(s, all(0.0)) / kappa;
            const ss_wide above = above_guard(&e.h);
            const ss_wide short_of = ss_wide_most(all(0.0) - above, all(0.0));
            if (pass->kind == SS_TISSUE_STVK_GUARDED) {
                const ss_wide square = all(3.0) + t; /* |F|^2 >= 3 |C|^(2/3) */
                const ss_wide guard =
                    all(1.0 / 3.0) * square * square + all(2.0) * short_of * ss_wide_root(square);
                grown = grown + ss_wide_below(all(0.0), short_of, guard, all(0.0));
            }
            ss_wide_store(out_growth + SS_FEM_LANES * (ptrdiff_t)b + lane, grown);
            ss_wide_store(out_ratio + SS_FEM_LANES * (ptrdiff_t)b + lane,
                          above + all(SS_TISSUE_GUARD));
        }
    }
}

/* ---- the table ---- */

SS_KERNEL_TABLE_512(ss_fem_kernels, .force = force, .tangent = tangent, .dilate = dilate,
                    .growth = growth);
