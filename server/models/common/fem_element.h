/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * SS_WIDE_LANES tetrahedra at once: gradients of nodal fields, strains, stresses of the laws and
 * the forces from them. Included by kernels alone, which compile it once per SIMD path; symbols
 * and order of tissue_law.c. RT-safe throughout.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "models/common/fem_kernels.h"
#include "models/common/wide.h"

typedef struct tensor {
    ss_wide m[3][3];
} tensor;

/* Symmetric: xx yy zz yz xz xy. */
typedef struct symmetric {
    ss_wide m[6];
} symmetric;

/* SS_WIDE_LANES elements of a block. */
typedef struct element {
    const int32_t *at; /* corner a: at + 8 a */
    const ss_real *shape;
    ss_wide volume, lambda, mu, pressure; /* times V */
    ss_wide kappa, phi, psi;              /* times V; phi and psi where there is viscosity */
    tensor h;
    bool is_held; /* neo-hookean's factor, see floor_of */
} element;

/* Sums over blocks. */
typedef struct sums {
    ss_wide energy, power, strain;
} sums;

SS_INLINE ss_wide all(double s)
{
    return ss_wide_all((ss_real)s);
}

/* ---- matrices ---- */

/* Gradient of a field whose values at corners 1 to 3 are `d`, less that at corner 0. */
SS_INLINE tensor gradient_of(const element *e, const ss_wide d[3][3])
{
    tensor h;
    for (int j = 0; j < 3; ++j) {
        const ss_wide g0 = ss_wide_load(e->shape + SS_FEM_LANES * j);
        const ss_wide g1 = ss_wide_load(e->shape + SS_FEM_LANES * (3 + j));
        const ss_wide g2 = ss_wide_load(e->shape + SS_FEM_LANES * (6 + j));
        for (int i = 0; i < 3; ++i) {
            h.m[i][j] = ss_wide_fma(d[2][i], g2, ss_wide_fma(d[1][i], g1, d[0][i] * g0));
        }
    }
    return h;
}

/* Gradient of a nodal field. */
SS_INLINE tensor gradient(const element *e, const ss_real *field)
{
    ss_wide u0[3], d[3][3];
    ss_wide_gather(field, e->at, u0);
    for (int a = 0; a < 3; ++a) {
        ss_wide_gather(field, e->at + SS_FEM_LANES * (a + 1), d[a]);
        for (int i = 0; i < 3; ++i) {
            d[a][i] = d[a][i] - u0[i];
        }
    }
    return gradient_of(e, (const ss_wide(*)[3])d);
}

/* P grad N of the four corners. */
SS_INLINE void corner_forces(const element *e, const tensor *p, ss_wide f[4][3])
{
    for (int a = 0; a < 3; ++a) {
        const ss_wide g0 = ss_wide_load(e->shape + SS_FEM_LANES * (3 * a));
        const ss_wide g1 = ss_wide_load(e->shape + SS_FEM_LANES * (3 * a + 1));
        const ss_wide g2 = ss_wide_load(e->shape + SS_FEM_LANES * (3 * a + 2));
        for (int i = 0; i < 3; ++i) {
            f[a + 1][i] = ss_wide_fma(p->m[i][2], g2, ss_wide_fma(p->m[i][1], g1, p->m[i][0] * g0));
        }
    }
    for (int i = 0; i < 3; ++i) {
        f[0][i] = all(0.0) - ((f[1][i] + f[2][i]) + f[3][i]);
    }
}

/* out += P grad N. */
SS_INLINE void spread(const element *e, const tensor *p, ss_real *out)
{
    ss_wide f[4][3];
    corner_forces(e, p, f);
    for (int a = 0; a < 4; ++a) {
        ss_wide_scatter_add(out, e->at + SS_FEM_LANES * a, f[a]);
    }
}

SS_INLINE ss_wide column_product(const tensor *a, int i, const tensor *b, int j, ss_wide add)
{
    add = ss_wide_fma(a->m[0][i], b->m[0][j], add);
    add = ss_wide_fma(a->m[1][i], b->m[1][j], add);
    return ss_wide_fma(a->m[2][i], b->m[2][j], add);
}

/* D = H + H^T + H^T H */
SS_INLINE symmetric twice_green(const tensor *h)
{
    symmetric d;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        d.m[k] = column_product(h, k, h, k, h->m[k][k] + h->m[k][k]);
        d.m[3 + k] = column_product(h, i, h, j, h->m[i][j] + h->m[j][i]);
    }
    return d;
}

/* H + H^T */
SS_INLINE symmetric twice_small(const tensor *h)
{
    symmetric d;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        d.m[k] = h->m[k][k] + h->m[k][k];
        d.m[3 + k] = h->m[i][j] + h->m[j][i];
    }
    return d;
}

/* 2 sym(F^T X), X the rate or change of H: X + X^T + H^T X + X^T H */
SS_INLINE symmetric twice_mixed(const tensor *h, const tensor *x)
{
    symmetric d = twice_small(x);
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const ss_wide along = column_product(h, k, x, k, all(0.0));
        d.m[k] = d.m[k] + (along + along);
        d.m[3 + k] = column_product(h, i, x, j, column_product(h, j, x, i, d.m[3 + k]));
    }
    return d;
}

SS_INLINE ss_wide trace_of(const symmetric *a)
{
    return (a->m[0] + a->m[1]) + a->m[2];
}

SS_INLINE ss_wide contract(const symmetric *a, const symmetric *b)
{
    ss_wide sum = a->m[3] * b->m[3];
    sum = ss_wide_fma(a->m[4], b->m[4], sum);
    sum = ss_wide_fma(a->m[5], b->m[5], sum);
    sum = sum + sum;
    sum = ss_wide_fma(a->m[0], b->m[0], sum);
    sum = ss_wide_fma(a->m[1], b->m[1], sum);
    return ss_wide_fma(a->m[2], b->m[2], sum);
}

/* S = l/2 tr(D) I + m D + p I */
SS_INLINE symmetric hooke(ss_wide l, ss_wide m, const symmetric *d, ss_wide p)
{
    const ss_wide mean = ss_wide_fma(all(0.5) * l, trace_of(d), p);
    symmetric s;
    for (int k = 0; k < 3; ++k) {
        s.m[k] = ss_wide_fma(m, d->m[k], mean);
        s.m[3 + k] = m * d->m[3 + k];
    }
    return s;
}

/* p += A s */
SS_INLINE void add_symmetric(tensor *p, const tensor *a, const symmetric *s)
{
    static const int at[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            ss_wide sum = p->m[i][j];
            for (int k = 0; k < 3; ++k) {
                sum = ss_wide_fma(a->m[i][k], s->m[at[k][j]], sum);
            }
            p->m[i][j] = sum;
        }
    }
}

SS_INLINE tensor full(const symmetric *s)
{
    static const int at[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
    tensor p;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            p.m[i][j] = s->m[at[i][j]];
        }
    }
    return p;
}

SS_INLINE void add_scaled(tensor *p, ss_wide s, const tensor *a)
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            p->m[i][j] = ss_wide_fma(s, a->m[i][j], p->m[i][j]);
        }
    }
}

SS_INLINE void add_diagonal(tensor *p, ss_wide s)
{
    for (int i = 0; i < 3; ++i) {
        p->m[i][i] = p->m[i][i] + s;
    }
}

SS_INLINE ss_wide product(const tensor *a, const tensor *b)
{
    ss_wide sum = a->m[0][0] * b->m[0][0];
    for (int k = 1; k < 9; ++k) {
        sum = ss_wide_fma(a->m[k / 3][k % 3], b->m[k / 3][k % 3], sum);
    }
    return sum;
}

SS_INLINE tensor zero_tensor(void)
{
    tensor p;
    for (int k = 0; k < 9; ++k) {
        p.m[k / 3][k % 3] = all(0.0);
    }
    return p;
}

SS_INLINE ss_wide minor_of(const tensor *a, int i, int j)
{
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    return ss_wide_fnma(a->m[i1][j2], a->m[i2][j1], a->m[i1][j1] * a->m[i2][j2]);
}

/* J - 1, Q = C - I and C. */
typedef struct dilatation {
    ss_wide j;
    tensor q, c;
} dilatation;

SS_INLINE dilatation dilatation_of(const tensor *h)
{
    dilatation v;
    const ss_wide t = (h->m[0][0] + h->m[1][1]) + h->m[2][2];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            v.q.m[i][j] = minor_of(h, i, j);
        }
    }
    ss_wide det = h->m[0][0] * v.q.m[0][0]; /* det H */
    det = ss_wide_fma(h->m[0][1], v.q.m[0][1], det);
    det = ss_wide_fma(h->m[0][2], v.q.m[0][2], det);
    v.j = t + (((v.q.m[0][0] + v.q.m[1][1]) + v.q.m[2][2]) + det);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            v.q.m[i][j] = v.q.m[i][j] - h->m[j][i];
        }
    }
    add_diagonal(&v.q, t);
    v.c = v.q;
    add_diagonal(&v.c, all(1.0));
    return v;
}

/* The change of C along X. */
SS_INLINE tensor cogrownchange(const tensor *h, const tensor *x)
{
    const ss_wide t = (x->m[0][0] + x->m[1][1]) + x->m[2][2];
    tensor c;
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            ss_wide sum = all(0.0) - x->m[j][i];
            sum = ss_wide_fma(h->m[i1][j1], x->m[i2][j2], sum);
            sum = ss_wide_fma(x->m[i1][j1], h->m[i2][j2], sum);
            sum = ss_wide_fnma(h->m[i1][j2], x->m[i2][j1], sum);
            c.m[i][j] = ss_wide_fnma(x->m[i1][j2], h->m[i2][j1], sum);
        }
    }
    add_diagonal(&c, t);
    return c;
}

/* J less the guard, without care for digits. */
SS_INLINE ss_wide above_guard(const tensor *h)
{
    tensor f = *h;
    add_diagonal(&f, all(1.0));
    ss_wide j = f.m[0][0] * minor_of(&f, 0, 0);
    j = ss_wide_fma(f.m[0][1], minor_of(&f, 0, 1), j);
    j = ss_wide_fma(f.m[0][2], minor_of(&f, 0, 2), j);
    return j - all(SS_TISSUE_GUARD);
}

/* ---- neo-hookean's factor ---- */

/* a^(-1/3) for normal a > 0 from its exponent, good to 4 %. */
SS_INLINE ss_wide cube_root_guess(ss_wide a)
{
    _Alignas(32) ss_real lane[SS_WIDE_LANES];
    ss_wide_store(lane, a);
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
#ifdef SOFTSIM_DOUBLE
        uint64_t bits;
        memcpy(&bits, &lane[k], sizeof bits);
        bits = UINT64_C(0x553ef0ff289dd796) - bits / 3;
#else
        uint32_t bits;
        memcpy(&bits, &lane[k], sizeof bits);
        bits = UINT32_C(0x548c39cb) - bits / 3;
#endif
        memcpy(&lane[k], &bits, sizeof bits);
    }
    return ss_wide_load(lane);
}

/* By Newton's method. */
SS_INLINE ss_wide inverse_cube_root(ss_wide a)
{
    ss_wide y = cube_root_guess(a);
    for (int k = 0; k < (sizeof(ss_real) == 8 ? 4 : 3); ++k) {
        y = y * ss_wide_fnma(a * y, y * y, all(4.0)) * all(1.0 / 3.0);
    }
    return y;
}

/* g - 1, g' and g'' of g(J) = J^(-2/3), a parabola below the floor. */
typedef struct factor {
    ss_wide g1, slope, bend;
} factor;

/* Where J^(-2/3) ends: SS_TISSUE_FLOOR, and the parabola of tissue_law.c below it; or where it is
 * held SS_FEM_HELD_FLOOR, and a straight line, which does not throw a tangled body apart. */
SS_INLINE double floor_of(bool is_held)
{
    return is_held ? SS_FEM_HELD_FLOOR : SS_TISSUE_FLOOR;
}

/* From y = ratio^(-1/3), ratio 1 + j or the floor if that is more. */
SS_INLINE factor isochoric_factor_of(bool is_held, ss_wide j, ss_wide y)
{
    const ss_wide at = ss_wide_most(j, all(floor_of(is_held) - 1.0)), ratio = all(1.0) + at;
    const ss_wide below = j - at, inverse = all(1.0) / ratio;
    /* y^3 = 1/J gives y - 1 without cancellation. */
    const ss_wide y1 = all(0.0) - at * inverse / (all(1.0) + y + y * y);
    factor f;
    f.g1 = y1 * (y + all(1.0));
    f.slope = all(-2.0 / 3.0) * (y * y) * inverse;
    f.bend = all(-5.0 / 3.0) * f.slope * inverse;
    if (is_held) {
        f.bend = ss_wide_below(below, all(0.0), all(0.0), f.bend);
    }
    f.g1 = f.g1 + below * ss_wide_fma(all(0.5) * below, f.bend, f.slope);
    f.slope = ss_wide_fma(below, f.bend, f.slope);
    return f;
}

SS_INLINE factor isochoric_factor(bool is_held, ss_wide j)
{
    const ss_wide at = ss_wide_most(j, all(floor_of(is_held) - 1.0));
    return isochoric_factor_of(is_held, j, inverse_cube_root(all(1.0) + at));
}

SS_INLINE ss_wide log_one_plus(ss_wide a)
{
    _Alignas(32) ss_real lane[SS_WIDE_LANES];
    ss_wide_store(lane, a);
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        lane[k] = (ss_real)log1p((double)lane[k]);
    }
    return ss_wide_load(lane);
}

/* ---- stress ---- */

/* Of the laws of J: energy V W into *energy if wanted; d = 2E; `known` is neo-hookean's factor
 * where that has been computed before, else NULL. */
SS_INLINE tensor volume_stress(ss_tissue_kind kind, const element *e, const symmetric *d,
                               const factor *known, bool wants_energy, ss_wide *energy)
{
    const dilatation v = dilatation_of(&e->h);
    const ss_wide t = all(0.5) * trace_of(d), mu = e->mu;
    tensor p = zero_tensor();
    if (kind == SS_TISSUE_NEO_HOOKEAN) {
        const factor f = known != NULL ? *known : isochoric_factor(e->is_held, v.j);
        const ss_wide g = mu + mu * f.g1, bulk = ss_wide_fma(all(2.0 / 3.0), mu, e->lambda);
        const ss_wide invariant = ss_wide_fma(all(2.0), t, all(3.0));
        const double lowest = floor_of(e->is_held);
        const ss_wide ratio = ss_wide_most(all(1.0) + v.j, all(lowest));
        const ss_wide above = all(0.0) - g * (all(2.0 / 3.0) * t - v.j) / ratio;
        const ss_wide beneath = ss_wide_fma(all(0.5) * mu, f.slope * invariant, g);
        const ss_wide rest = ss_wide_below(v.j, all(lowest - 1.0), beneath, above);
        add_scaled(&p, g, &e->h);
        add_scaled(&p, all(0.0) - g, &v.q);
        add_scaled(&p, ss_wide_fma(bulk, v.j, rest) + e->pressure, &v.c);
        if (wants_energy) {
            *energy =
                *energy + all(0.5) * (mu * ss_wide_fma(f.g1, invariant, t + t) + bulk * v.j * v.j);
        }
    } else {
        const ss_wide m = all(4.0 / 3.0) * mu, l = ss_wide_fma(all(5.0 / 6.0), mu, e->lambda);
        const ss_wide stretch = m * t / ss_wide_fma(all(4.0), t, all(8.0));
        add_scaled(&p, mu + stretch, &e->h);
        add_scaled(&p, all(0.0) - mu, &v.q);
        add_scaled(&p, ss_wide_fma(l, v.j, e->pressure), &v.c);
        add_diagonal(&p, stretch);
        if (wants_energy) {
            *energy = *energy + m * (t - all(0.5) * log_one_plus(all(0.5) * t)) +
                      v.j * (all(0.5) * l * v.j - mu);
        }
    }
    return p;
}

/* The guard of elements that need it: P -= kappa (J0 - J) C. */
SS_INLINE void add_guard(const element *e, tensor *p, bool wants_energy, ss_wide *energy)
{
    const ss_wide above = above_guard(&e->h);
    if (ss_wide_any_below(above, all(0.0))) {
        const dilatation v = dilatation_of(&e->h);
        const ss_wide short_of = ss_wide_most(all(SS_TISSUE_GUARD - 1.0) - v.j, all(0.0));
        add_scaled(p, all(0.0) - e->kappa * short_of, &v.c);
        if (wants_energy) {
            *energy = *energy + all(0.5) * e->kappa * short_of * short_of;
        }
    }
}

/* V (P + P_v); the viscous part with `rate`, NULL without; `known` as above. */
SS_INLINE tensor stress(ss_tissue_kind kind, const element *e, const tensor *rate,
                        const factor *known, bool wants_energy, sums *sum)
{
    const bool is_linear = kind == SS_TISSUE_LINEAR, is_viscous = rate != NULL;
    const bool is_volume = kind == SS_TISSUE_NEO_HOOKEAN || kind == SS_TISSUE_STABLE_NEO_HOOKEAN;
    const symmetric d = is_linear ? twice_small(&e->h) : twice_green(&e->h);
    symmetric s = {{all(0.0), all(0.0), all(0.0), all(0.0), all(0.0), all(0.0)}};
    if (!is_volume) {
        s = hooke(e->lambda, e->mu, &d, e->pressure);
        if (wants_energy) {
            const ss_wide t = trace_of(&d);
            sum->energy =
                sum->energy + all(0.125) * e->lambda * t * t + all(0.25) * e->mu * contract(&d, &d);
        }
    }
    sum->strain = ss_wide_most(contract(&d, &d), sum->strain);
    if (is_viscous) {
        const symmetric r = is_linear ? twice_small(rate) : twice_mixed(&e->h, rate);
        const symmetric sv = hooke(e->phi, e->psi, &r, all(0.0));
        sum->power = ss_wide_fma(all(0.5), contract(&sv, &r), sum->power);
        for (int k = 0; k < 6; ++k) {
            s.m[k] = s.m[k] + sv.m[k];
        }
    }
    tensor p = is_volume ? volume_stress(kind, e, &d, known, wants_energy, &sum->energy) : full(&s);
    if (is_volume && is_viscous) {
        const tensor sv = full(&s);
        add_scaled(&p, all(1.0), &sv);
    }
    if (!is_linear && (is_viscous || !is_volume)) {
        add_symmetric(&p, &e->h, &s);
    }
    if (kind == SS_TISSUE_STVK_GUARDED) {
        add_guard(e, &p, wants_energy, &sum->energy);
    }
    return p;
}

/* ---- tangents ---- */

/* a dF + da F + b dC + db C */
SS_INLINE void add_volume_tangent(tensor *p, const element *e, const tensor *x, const dilatation *v,
                                  ss_wide a, ss_wide da, ss_wide b, ss_wide db)
{
    const tensor dc = cogrownchange(&e->h, x);
    add_scaled(p, a, x);
    add_scaled(p, da, &e->h);
    add_diagonal(p, da);
    add_scaled(p, b, &dc);
    add_scaled(p, db, &v->c);
}

SS_INLINE tensor volume_tangent(ss_tissue_kind kind, const element *e, const tensor *x,
                                ss_wide change)
{
    const dilatation v = dilatation_of(&e->h);
    const symmetric d = twice_green(&e->h), dd = twice_mixed(&e->h, x);
    const ss_wide dj = product(&v.c, x), mu = e->mu;
    const ss_wide invariant = all(3.0) + trace_of(&d), d_invariant = trace_of(&dd);
    tensor p = zero_tensor();
    if (kind == SS_TISSUE_NEO_HOOKEAN) {
        const factor f = isochoric_factor(e->is_held, v.j);
        const ss_wide bulk = ss_wide_fma(all(2.0 / 3.0), mu, e->lambda), half = all(0.5) * mu;
        const ss_wide b = ss_wide_fma(half * f.slope, invariant, bulk * v.j) + e->pressure;
        const ss_wide db = half * (f.bend * dj * invariant + f.slope * d_invariant) + bulk * dj;
        add_volume_tangent(&p, e, x, &v, mu + mu * f.g1, mu * f.slope * dj, b, db + change);
    } else {
        const ss_wide m = all(4.0 / 3.0) * mu, l = ss_wide_fma(all(5.0 / 6.0), mu, e->lambda);
        const ss_wide inverse = all(1.0) / (invariant + all(1.0));
        add_volume_tangent(&p, e, x, &v, m - m * inverse, m * inverse * inverse * d_invariant,
                           ss_wide_fma(l, v.j, e->pressure) - mu, ss_wide_fma(l, dj, change));
    }
    return p;
}

/* The change of V P along x, that of the pressure `change` (J); viscosity left out. */
SS_INLINE tensor stress_change(ss_tissue_kind kind, const element *e, const tensor *x,
                               ss_wide change)
{
    const bool is_linear = kind == SS_TISSUE_LINEAR;
    tensor p;
    if (kind == SS_TISSUE_NEO_HOOKEAN || kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        p = volume_tangent(kind, e, x, change);
    } else {
        const symmetric dd = is_linear ? twice_small(x) : twice_mixed(&e->h, x);
        const symmetric ds = hooke(e->lambda, e->mu, &dd, change);
        p = full(&ds);
        if (!is_linear) {
            const symmetric d = twice_green(&e->h);
            const symmetric s = hooke(e->lambda, e->mu, &d, e->pressure);
            add_symmetric(&p, &e->h, &ds);
            add_symmetric(&p, x, &s);
        }
    }
    if (kind == SS_TISSUE_STVK_GUARDED && ss_wide_any_below(above_guard(&e->h), all(0.0))) {
        const dilatation v = dilatation_of(&e->h);
        const ss_wide short_of = all(SS_TISSUE_GUARD - 1.0) - v.j;
        const ss_wide kappa = ss_wide_below(all(0.0), short_of, e->kappa, all(0.0));
        add_volume_tangent(&p, e, x, &v, all(0.0), all(0.0), all(0.0) - kappa * short_of,
                           kappa * product(&v.c, x));
    }
    return p;
}

/* ---- dilatation ---- */

SS_INLINE ss_wide trace_of_tensor(const tensor *h)
{
    return (h->m[0][0] + h->m[1][1]) + h->m[2][2];
}

/* The dilatation that lambda resists: J - 1, tr E or tr e. */
SS_INLINE ss_wide resisted(ss_tissue_kind kind, const tensor *h)
{
    const ss_wide t = trace_of_tensor(h);
    if (kind == SS_TISSUE_NEO_HOOKEAN || kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        const dilatation v = dilatation_of(h);
        return v.j;
    }
    if (kind == SS_TISSUE_LINEAR) {
        return t;
    }
    return ss_wide_fma(all(0.5), product(h, h), t);
}

/* Its change along x. */
SS_INLINE ss_wide resisted_change(ss_tissue_kind kind, const tensor *h, const tensor *x)
{
    if (kind == SS_TISSUE_NEO_HOOKEAN || kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        const dilatation v = dilatation_of(h);
        return product(&v.c, x);
    }
    const ss_wide t = trace_of_tensor(x);
    if (kind == SS_TISSUE_LINEAR) {
        return t;
    }
    return t + product(h, x);
}

SS_INLINE double largest_lane(ss_wide a)
{
    _Alignas(32) ss_real lane[SS_WIDE_LANES];
    ss_wide_store(lane, a);
    double largest = 0.0;
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        largest = (double)lane[k] > largest ? (double)lane[k] : largest;
    }
    return largest;
}

/* of(kind, ...) with the law known to the compiler: a kernel for each. */
#define BY_LAW(kind, of, ...)                                                                      \
    switch (kind) {                                                                                \
        LAW_CASE(SS_TISSUE_STVK_GUARDED, of, __VA_ARGS__)                                          \
        LAW_CASE(SS_TISSUE_STVK, of, __VA_ARGS__)                                                  \
        LAW_CASE(SS_TISSUE_NEO_HOOKEAN, of, __VA_ARGS__)                                           \
        LAW_CASE(SS_TISSUE_STABLE_NEO_HOOKEAN, of, __VA_ARGS__)                                    \
        LAW_CASE(SS_TISSUE_LINEAR, of, __VA_ARGS__)                                                \
    case SS_TISSUE_KIND_COUNT:                                                                     \
        break;                                                                                     \
    }
#define LAW_CASE(law, of, ...)                                                                     \
    case law:                                                                                      \
        of(law, __VA_ARGS__);                                                                      \
        break;
