/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/kernels.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * again for AVX2 (256-bit vectors, fused multiply-add) and for the registers of AVX-512VL.
 *
 * Barycentric coordinates l_k; the gradient of a quadratic field is linear in them:
 *
 *   c_k = (4 l_k - 1) u_k + 4 sum_{j != k} l_j u_kj,   du/dl_s = c_s - c_0,   s = 1, 2, 3
 *   H = sum_s (c_s - c_0) (grad l_s)^T
 *
 * At Gauss point q (l_q = a, the others b) all but one term of each c_k is the same for the four
 * points: c_k = base_k + 4 (a - b) w_kq, where w_kq is the node of edge kq and w_kk corner k, and
 * base_k = (4 b - 1) u_k + 4 b sum_{j != k} u_kj. Displacements are relative to corner 0, so that
 * translation is free of rounding, and its force is minus the sum of the others: momentum is kept.
 * Forces are the exact transpose of these lines.
 *
 * The dilatation that lambda - lambda_own resists is the element's mean, which needs all four
 * points: a first loop has gradients and dilatations, a second one stresses.
 *
 * Flops an element of stable neo-Hookean, straight, elastic (a fused multiply-add counts 2),
 * see ss_quadratic_work.
 */
#include "models/common/fem_element.h"

/* gcc 12 makes wrong code of loops unrolled within unrolled ones (energies off by a seventh; clang
 * does not): of one lane at -O1 and above, so plain C is left as it stands; of more at -O1 and -O2,
 * so kernels are compiled at -O3 whatever the build says (CMakeLists.txt). */
#define PRAGMA(text) _Pragma(#text)
#if SS_WIDE_LANES > 1
#define UNROLL(count) PRAGMA(GCC unroll count)
#else
#define UNROLL(count)
#endif

/* Blocks summed in ss_real before a sum goes over to double. */
enum { RUN = 32 };
/* The four-point Gauss rule of degree 2. */
#define NEAR 0.58541019662496852
#define FAR  0.13819660112501050
#define STEP (4.0 * (NEAR - FAR))
enum { NODES = SS_QUADRATIC_NODES, POINTS = SS_QUADRATIC_POINTS, LANES = SS_FEM_LANES };
enum { CURVED = SS_FEM_SHAPES + 1 }; /* values of a curved element's point */

/* The node of edge k-j, or corner k. */
static const int edge[4][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}};

/* SS_WIDE_LANES elements of a block. */
typedef struct cell {
    const int32_t *at;
    const ss_real *shape; /* of the first point; all points' where straight */
    ss_wide lambda, mu, shared, kappa, phi, psi; /* times V */
} cell;

/* A nodal field within a cell. */
typedef struct nodal {
    ss_wide node[NODES][3]; /* less corner 0 */
    ss_wide base[3][3];     /* base_s - base_0 */
} nodal;

SS_INLINE cell cell_at(const ss_quadratic_blocks *blocks, bool is_curved, bool is_viscous,
                       int32_t block, int lane)
{
    const ptrdiff_t b = block, first = is_curved ? blocks->straight_count : 0;
    const ss_real *modulus = blocks->modulus + b * SS_QUADRATIC_MODULI * LANES + lane;
    cell c = {.at = blocks->node + b * NODES * LANES + lane,
              .shape = is_curved ? blocks->curved + (b - first) * POINTS * CURVED * LANES + lane
                                 : blocks->shape + b * SS_FEM_SHAPES * LANES + lane,
              .lambda = ss_wide_load(modulus),
              .mu = ss_wide_load(modulus + LANES),
              .shared = ss_wide_load(modulus + 2 * LANES),
              .kappa = ss_wide_load(blocks->kappa + b * LANES + lane)};
    if (is_viscous) {
        const ss_real *viscosity = blocks->viscosity + b * 2 * LANES + lane;
        c.phi = ss_wide_load(viscosity);
        c.psi = ss_wide_load(viscosity + LANES);
    }
    return c;
}

/* From the nodes' values. */
SS_INLINE void set_base(nodal *out)
{
    ss_wide base[4][3];
    UNROLL(10)
    for (int n = NODES - 1; n >= 0; --n) { /* corner 0 last, which becomes 0 */
        for (int i = 0; i < 3; ++i) {
            out->node[n][i] = out->node[n][i] - out->node[0][i];
        }
    }
    UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        const int *s = edge[k];
        for (int i = 0; i < 3; ++i) {
            const ss_wide sum = (out->node[s[(k + 1) % 4]][i] + out->node[s[(k + 2) % 4]][i]) +
                                out->node[s[(k + 3) % 4]][i];
            base[k][i] = all(4.0 * FAR) * sum;
            if (k > 0) {
                base[k][i] = ss_wide_fma(all(4.0 * FAR - 1.0), out->node[k][i], base[k][i]);
            }
        }
    }
    UNROLL(3)
    for (int s = 0; s < 3; ++s) {
        for (int i = 0; i < 3; ++i) {
            out->base[s][i] = base[s + 1][i] - base[0][i];
        }
    }
}

SS_INLINE void load(const cell *c, const ss_real *field, nodal *out)
{
    UNROLL(10)
    for (int n = 0; n < NODES; ++n) {
        ss_wide_gather(field, c->at + LANES * n, out->node[n]);
    }
    set_base(out);
}

/* The element of common/fem_element.h that Gauss point q is: its volume V_q in all that carries
 * one, no gradient and no pressure yet. */
SS_INLINE element point_at(const cell *c, bool is_curved, int q, ss_wide *out_share)
{
    const ss_real *shape = is_curved ? c->shape + (ptrdiff_t)q * CURVED * LANES : c->shape;
    const ss_wide share = is_curved ? ss_wide_load(shape + SS_FEM_SHAPES * LANES) : all(0.25);
    *out_share = share;
    return (element){.at = c->at,
                     .shape = shape,
                     .lambda = share * c->lambda,
                     .mu = share * c->mu,
                     .kappa = share * c->kappa,
                     .pressure = all(0.0),
                     .is_held = true};
}

SS_INLINE tensor point_gradient(const element *e, const nodal *field, int q)
{
    ss_wide d[3][3]; /* at -O3 unrolled without being asked, with the same code */
    for (int s = 0; s < 3; ++s) {
        for (int i = 0; i < 3; ++i) {
            const ss_wide change = field->node[edge[s + 1][q]][i] - field->node[edge[0][q]][i];
            d[s][i] = ss_wide_fma(all(STEP), change, field->base[s][i]);
        }
    }
    return gradient_of(e, (const ss_wide(*)[3])d);
}

/* What the columns c_k of all points give the nodes. */
typedef struct columns {
    ss_wide sum[4][3];
    ss_wide node[NODES][3];
} columns;

SS_INLINE void clear(columns *f)
{
    UNROLL(10)
    for (int n = 0; n < NODES; ++n) {
        for (int i = 0; i < 3; ++i) {
            f->node[n][i] = all(0.0);
        }
    }
    UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 3; ++i) {
            f->sum[k][i] = all(0.0);
        }
    }
}

SS_INLINE void add_point(const element *e, const tensor *p, int q, columns *f)
{
    ss_wide column[4][3];
    corner_forces(e, p, column);
    UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 3; ++i) {
            f->sum[k][i] = f->sum[k][i] + column[k][i];
            f->node[edge[k][q]][i] = ss_wide_fma(all(STEP), column[k][i], f->node[edge[k][q]][i]);
        }
    }
}

/* What node n > 0 gets of them. */
SS_INLINE ss_wide force_at(const columns *f, int n, int i)
{
    ss_wide x = f->node[n][i];
    if (n < 4) {
        x = ss_wide_fma(all(4.0 * FAR - 1.0), f->sum[n][i], x);
    }
    UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        for (int j = k + 1; j < 4; ++j) {
            if (edge[k][j] == n) {
                x = ss_wide_fma(all(4.0 * FAR), f->sum[k][i] + f->sum[j][i], x);
            }
        }
    }
    return x;
}

/* out += sign times the forces. */
SS_INLINE void spread_columns(const cell *c, columns *f, double sign, ss_real *out)
{
    ss_wide total[3] = {all(0.0), all(0.0), all(0.0)};
    UNROLL(10)
    for (int n = NODES - 1; n > 0; --n) {
        ss_wide force[3];
        for (int i = 0; i < 3; ++i) {
            force[i] = all(sign) * force_at(f, n, i);
            total[i] = total[i] + force[i];
        }
        ss_wide_scatter_add(out, c->at + LANES * n, force);
    }
    for (int i = 0; i < 3; ++i) {
        total[i] = all(0.0) - total[i];
    }
    ss_wide_scatter_add(out, c->at, total);
}

/* Gradients of all points and their dilatations; returns the mean of these. */
SS_INLINE ss_wide gradients(ss_tissue_kind kind, bool is_curved, const cell *c, const nodal *u,
                            tensor h[POINTS], ss_wide theta[POINTS])
{
    ss_wide mean = all(0.0);
    UNROLL(4)
    for (int q = 0; q < POINTS; ++q) {
        ss_wide share;
        const element e = point_at(c, is_curved, q, &share);
        h[q] = point_gradient(&e, u, q);
        theta[q] = resisted(kind, &h[q]);
        mean = ss_wide_fma(share, theta[q], mean);
    }
    return mean;
}

/* Neo-hookean's factors of the four points side by side: each is a chain of operations that wait
 * for one another (38 ns an element one after the other). The guess is good to 4 %; a step of third
 * order, y := y (1 + r/3 + 2/9 r^2) with r = 1 - a y^3, leaves 2e-5, the second rounding. */
SS_INLINE void isochoric_factors(const ss_wide j[POINTS], factor out[POINTS])
{
    ss_wide ratio[POINTS], y[POINTS];
    UNROLL(4)
    for (int q = 0; q < POINTS; ++q) {
        ratio[q] = all(1.0) + ss_wide_most(j[q], all(SS_FEM_HELD_FLOOR - 1.0));
        y[q] = cube_root_guess(ratio[q]);
    }
    UNROLL(3)
    for (int k = 0; k < (sizeof(ss_real) == 8 ? 3 : 2); ++k) {
        UNROLL(4)
        for (int q = 0; q < POINTS; ++q) {
            const ss_wide r = ss_wide_fnma(ratio[q] * y[q], y[q] * y[q], all(1.0));
            y[q] = ss_wide_fma(y[q] * r, ss_wide_fma(all(2.0 / 9.0), r, all(1.0 / 3.0)), y[q]);
        }
    }
    UNROLL(4)
    for (int q = 0; q < POINTS; ++q) {
        out[q] = isochoric_factor_of(true, j[q], y[q]);
    }
}

SS_INLINE void force_block(ss_tissue_kind kind, bool is_curved, bool is_viscous,
                           const ss_quadratic_pass *pass, int32_t block, int lane, sums *sum)
{
    const cell c = cell_at(pass->blocks, is_curved, is_viscous, block, lane);
    nodal u, v;
    tensor h[POINTS];
    columns f;
    load(&c, pass->u, &u);
    if (is_viscous) {
        load(&c, pass->v, &v);
    }
    ss_wide theta[POINTS];
    factor known[POINTS];
    const ss_wide mean = gradients(kind, is_curved, &c, &u, h, theta);
    const ss_wide pressure = c.shared * mean;
    if (kind == SS_TISSUE_NEO_HOOKEAN) {
        isochoric_factors(theta, known);
    }
    clear(&f);
    const ss_wide before = sum->strain;
    sum->strain = all(0.0);
    UNROLL(4)
    for (int q = 0; q < POINTS; ++q) {
        ss_wide share;
        tensor rate;
        element e = point_at(&c, is_curved, q, &share);
        e.h = h[q];
        e.pressure = share * pressure;
        if (is_viscous) {
            e.phi = share * c.phi;
            e.psi = share * c.psi;
            rate = point_gradient(&e, &v, q);
        }
        const tensor p =
            stress(kind, &e, is_viscous ? &rate : NULL,
                   kind == SS_TISSUE_NEO_HOOKEAN ? &known[q] : NULL, pass->wants_energy, sum);
        add_point(&e, &p, q, &f);
    }
    if (pass->strains != NULL) {
        ss_wide_store(pass->strains + (ptrdiff_t)block * LANES + lane, sum->strain);
    }
    sum->strain = ss_wide_most(before, sum->strain);
    if (pass->wants_energy) {
        sum->energy = ss_wide_fma(all(0.5) * pressure, mean, sum->energy);
    }
    spread_columns(&c, &f, -1.0, pass->out);
}

SS_INLINE void force_run(ss_tissue_kind kind, bool is_curved, bool is_viscous,
                         ss_quadratic_pass *pass, int32_t from, int32_t to)
{
    for (int32_t first = from; first < to; first += RUN) {
        const int32_t end = first + RUN < to ? first + RUN : to;
        sums sum = {all(0.0), all(0.0), all(0.0)};
        for (int32_t b = first; b < end; ++b) {
            for (int lane = 0; lane < LANES; lane += SS_WIDE_LANES) {
                force_block(kind, is_curved, is_viscous, pass, b, lane, &sum);
            }
        }
        const double strain = largest_lane(sum.strain);
        pass->energy += ss_wide_sum(sum.energy);
        pass->power += ss_wide_sum(sum.power);
        pass->strain = strain > pass->strain ? strain : pass->strain;
    }
}

/* One of each, so that a law's code stands where it is run. */
#define FORCE_OF(name, kind)                                                                       \
    static void name(ss_quadratic_pass *pass)                                                      \
    {                                                                                              \
        const int32_t straight = pass->blocks->straight_count, count = pass->blocks->count;        \
        if (pass->v && pass->blocks->viscosity) {                                                  \
            force_run(kind, false, true, pass, 0, straight);                                       \
            force_run(kind, true, true, pass, straight, count);                                    \
        } else {                                                                                   \
            force_run(kind, false, false, pass, 0, straight);                                      \
            force_run(kind, true, false, pass, straight, count);                                   \
        }                                                                                          \
    }
FORCE_OF(force_stvk_guarded, SS_TISSUE_STVK_GUARDED)
FORCE_OF(force_stvk, SS_TISSUE_STVK)
FORCE_OF(force_neo_hookean, SS_TISSUE_NEO_HOOKEAN)
FORCE_OF(force_stable_neo_hookean, SS_TISSUE_STABLE_NEO_HOOKEAN)
FORCE_OF(force_linear, SS_TISSUE_LINEAR)

static void force(ss_quadratic_pass *pass)
{
    static void (*const of[SS_TISSUE_KIND_COUNT])(ss_quadratic_pass *) = {
        [SS_TISSUE_STVK_GUARDED] = force_stvk_guarded,
        [SS_TISSUE_STVK] = force_stvk,
        [SS_TISSUE_NEO_HOOKEAN] = force_neo_hookean,
        [SS_TISSUE_STABLE_NEO_HOOKEAN] = force_stable_neo_hookean,
        [SS_TISSUE_LINEAR] = force_linear};
    of[pass->kind](pass);
}

/* ---- tangents ---- */

/* The columns of K x at u. */
SS_INLINE void tangent_columns(ss_tissue_kind kind, bool is_curved, const cell *c, const nodal *u,
                               const nodal *x, columns *f)
{
    tensor h[POINTS], dh[POINTS];
    ss_wide theta[POINTS], change = all(0.0);
    const ss_wide pressure = c->shared * gradients(kind, is_curved, c, u, h, theta);
    for (int q = 0; q < POINTS; ++q) {
        ss_wide share;
        const element e = point_at(c, is_curved, q, &share);
        dh[q] = point_gradient(&e, x, q);
        change = ss_wide_fma(share, resisted_change(kind, &h[q], &dh[q]), change);
    }
    change = c->shared * change;
    clear(f);
    for (int q = 0; q < POINTS; ++q) {
        ss_wide share;
        element e = point_at(c, is_curved, q, &share);
        e.h = h[q];
        e.pressure = share * pressure;
        const tensor p = stress_change(kind, &e, &dh[q], share * change);
        add_point(&e, &p, q, f);
    }
}

/* One of each, shared by tangents and rates, so that a law's code stands once. */
typedef void columns_of(const cell *c, const nodal *u, const nodal *x, columns *f);
#define COLUMNS_OF(name, kind)                                                                     \
    static void name##_straight(const cell *c, const nodal *u, const nodal *x, columns *f)         \
    {                                                                                              \
        tangent_columns(kind, false, c, u, x, f);                                                  \
    }                                                                                              \
    static void name##_curved(const cell *c, const nodal *u, const nodal *x, columns *f)           \
    {                                                                                              \
        tangent_columns(kind, true, c, u, x, f);                                                   \
    }
COLUMNS_OF(stvk_guarded, SS_TISSUE_STVK_GUARDED)
COLUMNS_OF(stvk, SS_TISSUE_STVK)
COLUMNS_OF(neo_hookean, SS_TISSUE_NEO_HOOKEAN)
COLUMNS_OF(stable_neo_hookean, SS_TISSUE_STABLE_NEO_HOOKEAN)
COLUMNS_OF(linear, SS_TISSUE_LINEAR)

static columns_of *const tangent_of[SS_TISSUE_KIND_COUNT][2] = {
    [SS_TISSUE_STVK_GUARDED] = {stvk_guarded_straight, stvk_guarded_curved},
    [SS_TISSUE_STVK] = {stvk_straight, stvk_curved},
    [SS_TISSUE_NEO_HOOKEAN] = {neo_hookean_straight, neo_hookean_curved},
    [SS_TISSUE_STABLE_NEO_HOOKEAN] = {stable_neo_hookean_straight, stable_neo_hookean_curved},
    [SS_TISSUE_LINEAR] = {linear_straight, linear_curved}};

static void tangent(ss_quadratic_pass *pass)
{
    const ss_quadratic_blocks *blocks = pass->blocks;
    for (int32_t b = 0; b < blocks->count; ++b) {
        const bool is_curved = b >= blocks->straight_count;
        for (int lane = 0; lane < LANES; lane += SS_WIDE_LANES) {
            const cell c = cell_at(blocks, is_curved, false, b, lane);
            nodal u, x;
            columns f;
            load(&c, pass->u, &u);
            load(&c, pass->x, &x);
            tangent_of[pass->kind][is_curved](&c, &u, &x, &f);
            spread_columns(&c, &f, 1.0, pass->out);
        }
    }
}

/* ---- the rates of elements ---- */

/* Of an eigenvalue, for the part that its residual does not know. */
#define MARGIN 0.01
/* Beyond it a product is no motion any more. */
#define LARGEST 1e30

static void rate_block(const ss_quadratic_pass *pass, int32_t block, int lane)
{
    const bool is_curved = block >= pass->blocks->straight_count;
    const cell c = cell_at(pass->blocks, is_curved, false, block, lane);
    const ptrdiff_t first = (ptrdiff_t)block * LANES + lane;
    const ss_real *light = pass->blocks->light + (ptrdiff_t)block * NODES * LANES + lane;
    ss_real *mode = pass->mode + (ptrdiff_t)block * NODES * 3 * LANES + lane;
    nodal u, x;
    columns f;
    ss_wide y[NODES][3], quotient = all(0.0), square = all(0.0);
    load(&c, pass->u, &u);
    for (int n = 0; n < NODES; ++n) {
        for (int i = 0; i < 3; ++i) {
            x.node[n][i] = ss_wide_load(mode + (3 * n + i) * LANES);
        }
    }
    set_base(&x);
    tangent_of[pass->kind][is_curved](&c, &u, &x, &f);
    for (int i = 0; i < 3; ++i) {
        y[0][i] = all(0.0);
        for (int n = NODES - 1; n > 0; --n) {
            y[n][i] = force_at(&f, n, i);
            y[0][i] = y[0][i] - y[n][i];
        }
        for (int n = 0; n < NODES; ++n) {
            const ss_wide force = y[n][i];
            y[n][i] = ss_wide_load(light + LANES * n) * force;
            quotient = ss_wide_fma(ss_wide_load(mode + (3 * n + i) * LANES), force, quotient);
            square = ss_wide_fma(y[n][i], force, square);
        }
    }
    const ss_wide size = ss_wide_most(quotient, all(0.0) - quotient);
    const ss_wide left = ss_wide_most(ss_wide_fnma(quotient, quotient, square), all(0.0));
    const ss_wide rate = size + ss_wide_most(ss_wide_root(left), all(MARGIN) * size);
    const ss_wide norm = all(1.0) / ss_wide_root(ss_wide_most(square, all(1.0 / LARGEST)));
    ss_wide_store(pass->rate + first, ss_wide_below(square, all(LARGEST), rate, all(1.0)));
    for (int n = 0; n < NODES; ++n) {
        for (int i = 0; i < 3; ++i) {
            ss_real *at = mode + (3 * n + i) * LANES;
            ss_wide_store(at,
                          ss_wide_below(square, all(LARGEST), norm * y[n][i], ss_wide_load(at)));
        }
    }
}

static void rate(const ss_quadratic_pass *pass)
{
    for (int32_t k = 0; k < pass->block_count; ++k) {
        for (int lane = 0; lane < LANES; lane += SS_WIDE_LANES) {
            rate_block(pass, pass->block[k], lane);
        }
    }
}

/* ---- volume ---- */

static void ratio(const ss_quadratic_pass *pass, ss_real *out_ratio)
{
    for (int32_t k = 0; k < pass->block_count; ++k) {
        const int32_t b = pass->block[k];
        const bool is_curved = b >= pass->blocks->straight_count;
        for (int lane = 0; lane < LANES; lane += SS_WIDE_LANES) {
            const cell c = cell_at(pass->blocks, is_curved, false, b, lane);
            nodal u;
            ss_wide least = all(2.0);
            load(&c, pass->u, &u);
            for (int q = 0; q < POINTS; ++q) {
                ss_wide share;
                const element e = point_at(&c, is_curved, q, &share);
                const tensor h = point_gradient(&e, &u, q);
                const ss_wide j = above_guard(&h) + all(SS_TISSUE_GUARD);
                least = ss_wide_below(j, least, j, least);
            }
            ss_wide_store(out_ratio + (ptrdiff_t)b * LANES + lane, least);
        }
    }
}

/* ---- the table ---- */

SS_KERNEL_TABLE_512(ss_quadratic_kernels, .force = force, .tangent = tangent, .rate = rate,
                    .ratio = ratio);
