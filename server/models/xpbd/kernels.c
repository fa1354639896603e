/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/xpbd/kernels.h"
#include "models/common/fem_element.h"
/*
 * The kernels, written once; compiled for the baseline processor as they stand, and twice more
 * for AVX2 (256-bit vectors, fused multiply-add) and for the registers of AVX-512VL.
 *
 * One constraint a tetrahedron, in the sense of extended position-based dynamics (Macklin, Mueller,
 * Chentanez 2016, eqs. (18) and (17), with multipliers that begin at 0 in every sub-step: Macklin
 * et al. 2019): its corners move by the implicit Euler step that the element would take alone,
 *
 *   M dx = h^2 (f - K dx),  f = -V P(F) grad N,  K = V (c G G^T (x) I + l g g^T),  g_a = C grad N_a
 *
 * with G the rows grad N_a, C = cof F. c G G^T is the stiffness of the deviatoric constraint, the
 * nine entries of F with compliance 1/(c V); l g g^T that of the hydrostatic one, J, with
 * compliance 1/(l V). With W the corners' inverse masses, S = G^T W G and T = (I + h^2 c V S)^-1,
 * both 3 x 3, the coupled system of both constraints is solved exactly:
 *
 *   dx_a = -h^2 w_a (V P' T + (b j - l y) / (1 + l z) Z) grad N_a,  Z = V C T,  j = J - 1,
 *   y = h^2 C S : V P' T,  z = h^2 C S : Z
 *
 * where the law's P = P' + b j C has its bulk modulus b apart: nothing then cancels near
 * incompressibility. So dx -> h^2 W f, the explicit step, where h is small, and -K^-1 f where the
 * tissue is stiff. f is the law's own force, arranged so that it is 0 at rest to the last bit
 * (common/fem_element.h): a body at rest stays at rest, at any stiffness. f sums to 0, hence
 * momentum stays. l is W's second derivative in J, with what neo-hookean's first term adds when
 * crushed; c = 2 mu is the law's own stiffness in shear (neo-hookean: times J^(-2/3)). The part of
 * the second derivative of W that comes with d2J/dF2 has both signs and is left out: adding |W_J|
 * |F| to c turns elements under pressure (c G G^T holds back rotations too) and blows up at nu =
 * 0.4999.
 *
 * Stable neo-Hookean constraints (Macklin, Mueller 2021) take |F| for the nine entries. Its
 * gradient at rest is parallel to that of J: nothing then holds back a stiff element in shear, and
 * the two constraints fight each other at rest unless they are solved together, where single
 * precision loses what is left. The nine entries cost a 3 x 3 inverse, a quarter of the sweep.
 * Rejected too: St. Venant-Kirchhoff strain as a constraint (six rows, and no cure when crushed).
 */

/* ---- small matrices ---- */

/* (I + s S)^-1, symmetric: xx yy zz yz xz xy. */
SS_INLINE symmetric damped_inverse(const ss_real *spread, ss_wide s)
{
    ss_wide a[6];
    symmetric t;
    for (int k = 0; k < 6; ++k) {
        a[k] = s * ss_wide_load(spread + SS_FEM_LANES * k);
    }
    for (int k = 0; k < 3; ++k) {
        a[k] = a[k] + all(1.0);
    }
    t.m[0] = ss_wide_fnma(a[3], a[3], a[1] * a[2]);
    t.m[1] = ss_wide_fnma(a[4], a[4], a[0] * a[2]);
    t.m[2] = ss_wide_fnma(a[5], a[5], a[0] * a[1]);
    t.m[3] = ss_wide_fnma(a[0], a[3], a[4] * a[5]);
    t.m[4] = ss_wide_fnma(a[1], a[4], a[3] * a[5]);
    t.m[5] = ss_wide_fnma(a[2], a[5], a[3] * a[4]);
    const ss_wide determinant = ss_wide_fma(a[4], t.m[4], ss_wide_fma(a[5], t.m[5], a[0] * t.m[0]));
    const ss_wide inverse = all(1.0) / determinant;
    for (int k = 0; k < 6; ++k) {
        t.m[k] = t.m[k] * inverse;
    }
    return t;
}

/* a B, B symmetric. */
SS_INLINE tensor times(const tensor *a, const symmetric *b)
{
    static const int column[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
    tensor out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int *c = column[j];
            out.m[i][j] = ss_wide_fma(a->m[i][2], b->m[c[2]],
                                      ss_wide_fma(a->m[i][1], b->m[c[1]], a->m[i][0] * b->m[c[0]]));
        }
    }
    return out;
}

SS_INLINE ss_wide contraction(const tensor *a, const tensor *b)
{
    ss_wide sum = all(0.0);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            sum = ss_wide_fma(a->m[i][j], b->m[i][j], sum);
        }
    }
    return sum;
}

/* ---- tetrahedra ---- */

/* c and l, and the bulk modulus b of the law's b (J - 1)^2 / 2, times V. */
typedef struct stiffness {
    ss_wide c, l, b;
} stiffness;

SS_INLINE stiffness stiffness_of(ss_tissue_kind kind, const element *e, const symmetric *green,
                                 const dilatation *v)
{
    const ss_wide mu = e->mu;
    stiffness k;
    if (kind == SS_TISSUE_NEO_HOOKEAN) {
        const factor f = isochoric_factor(false, v->j);
        const ss_wide square = all(3.0) + trace_of(green); /* |F|^2 */
        const ss_wide bend = ss_wide_most(f.bend - all(10.0 / 9.0), all(0.0));
        k.c = ss_wide_fma(mu + mu, f.g1, mu + mu);
        k.b = ss_wide_fma(all(2.0 / 3.0), mu, e->lambda);
        k.l = ss_wide_fma(all(0.5) * mu * bend, square, k.b);
    } else {
        k.c = mu + mu;
        k.l = k.b = ss_wide_fma(all(5.0 / 6.0), mu, e->lambda);
    }
    return k;
}

/* Gradient of u and of what has been added to it, kept apart: a small step is lost in their sum. */
SS_INLINE tensor moved_gradient(const element *e, const ss_real *u, const ss_real *step)
{
    ss_wide d[4][3], more[3];
    for (int a = 0; a < 4; ++a) {
        ss_wide_gather(u, e->at + SS_FEM_LANES * a, d[a]);
    }
    ss_wide first[3];
    ss_wide_gather(step, e->at, first);
    for (int a = 1; a < 4; ++a) {
        ss_wide_gather(step, e->at + SS_FEM_LANES * a, more);
        for (int i = 0; i < 3; ++i) {
            d[a][i] = (d[a][i] - d[0][i]) + (more[i] - first[i]);
        }
    }
    return gradient_of(e, (const ss_wide(*)[3])(d + 1));
}

/* The corners' way: -h^2 w_a R grad N_a added to the step. */
SS_INLINE void move_corners(const element *e, const ss_real *light, ss_wide step, const tensor *r,
                            ss_real *way)
{
    ss_wide f[4][3];
    corner_forces(e, r, f);
    for (int a = 0; a < 4; ++a) {
        const ss_wide w = step * ss_wide_load(light + SS_FEM_LANES * a);
        for (int i = 0; i < 3; ++i) {
            f[a][i] = w * f[a][i];
        }
        ss_wide_scatter_add(way, e->at + SS_FEM_LANES * a, f[a]);
    }
}

SS_INLINE void solve(const ss_xpbd_pass *pass, ss_tissue_kind kind, int32_t pack, int lane,
                     ss_wide *least)
{
    const ss_xpbd_packs *packs = pass->packs;
    const ptrdiff_t b = pack;
    const ss_real *spread = packs->spread + b * 6 * SS_FEM_LANES + lane;
    const ss_wide square = all(pass->h * pass->h);
    element e = {
        .at = packs->node + b * 4 * SS_FEM_LANES + lane,
        .shape = packs->shape + b * SS_FEM_SHAPES * SS_FEM_LANES + lane,
    };
    const ss_real *modulus = packs->modulus + b * SS_FEM_MODULI * SS_FEM_LANES + lane;
    e.lambda = ss_wide_load(modulus);
    e.mu = ss_wide_load(modulus + SS_FEM_LANES);
    e.pressure = all(0.0);
    e.h = moved_gradient(&e, pass->u, pass->step);
    const symmetric green = twice_green(&e.h);
    const dilatation v = dilatation_of(&e.h);
    const stiffness k = stiffness_of(kind, &e, &green, &v);
    ss_wide unused = all(0.0);
    e.lambda = all(kind == SS_TISSUE_NEO_HOOKEAN ? -2.0 / 3.0 : -5.0 / 6.0) * e.mu; /* P' */
    const tensor p = volume_stress(kind, &e, &green, NULL, false, &unused);
    const symmetric t = damped_inverse(spread, square * k.c);
    symmetric s;
    for (int n = 0; n < 6; ++n) {
        s.m[n] = ss_wide_load(spread + SS_FEM_LANES * n);
    }
    tensor r = times(&p, &t);
    const tensor z = times(&v.c, &t), cs = times(&v.c, &s);
    const ss_wide own = square * contraction(&cs, &r), unit = square * contraction(&cs, &z);
    const ss_wide push = ss_wide_fnma(k.l, own, k.b * v.j) / ss_wide_fma(k.l, unit, all(1.0));
    add_scaled(&r, push, &z);
    move_corners(&e, packs->light + b * 4 * SS_FEM_LANES + lane, all(0.0) - square, &r, pass->step);
    *least = ss_wide_most(all(0.0) - v.j, *least);
}

/* Back where they belong: axes that are held, of nodes that are free along others. */
static void hold(const ss_xpbd_pass *pass, int32_t pack)
{
    const int32_t *at = pass->packs->node + (ptrdiff_t)pack * 4 * SS_FEM_LANES;
    for (int k = 0; k < 4 * SS_FEM_LANES; ++k) {
        for (int32_t a = at[k]; a < at[k] + 3; ++a) {
            pass->step[a] = pass->mobility[a] > 0 ? pass->step[a] : 0;
        }
    }
}

SS_INLINE void sweep(ss_xpbd_pass *pass, ss_tissue_kind kind)
{
    ss_wide least = all(-1e30);
    for (int32_t pack = 0; pack < pass->packs->count; ++pack) {
        for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
            solve(pass, kind, pack, lane, &least);
        }
        if (pass->packs->is_partial[pack]) {
            hold(pass, pack);
        }
    }
    _Alignas(32) ss_real lanes[SS_WIDE_LANES];
    ss_wide_store(lanes, least);
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        pass->least = fmin(pass->least, 1.0 - (double)lanes[k]);
    }
}

static void constrain(ss_xpbd_pass *pass)
{
    if (pass->kind == SS_TISSUE_NEO_HOOKEAN) {
        sweep(pass, SS_TISSUE_NEO_HOOKEAN);
    } else {
        sweep(pass, SS_TISSUE_STABLE_NEO_HOOKEAN);
    }
}

/* ---- nodes ---- */

static void predict(int32_t padded_count, double h, double keep, const ss_real *mobility,
                    const ss_real *force, const ss_real *v, ss_real *step)
{
    const ss_wide push = all(h * h), drift = all(h * keep), zero = all(0.0);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)padded_count; at += SS_WIDE_LANES) {
        const ss_wide w = ss_wide_load(mobility + at);
        const ss_wide way =
            ss_wide_fma(push * w, ss_wide_load(force + at), drift * ss_wide_load(v + at));
        ss_wide_store(step + at, ss_wide_below(zero, w, way, zero));
    }
}

static void finish(int32_t padded_count, double h, const ss_real *mobility, const ss_real *step,
                   ss_real *u, ss_real *v)
{
    const ss_wide rate = all(1.0 / h), zero = all(0.0);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)padded_count; at += SS_WIDE_LANES) {
        const ss_wide w = ss_wide_load(mobility + at), way = ss_wide_load(step + at);
        ss_wide_store(v + at, ss_wide_below(zero, w, rate * way, ss_wide_load(v + at)));
        ss_wide_store(u + at, ss_wide_load(u + at) + way);
    }
}

SS_KERNEL_TABLE_512(ss_xpbd_kernels, .predict = predict, .constrain = constrain, .finish = finish);
