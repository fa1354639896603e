/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/corotational/kernels.h"
/*
 * The kernels, written once. This file is compiled for the baseline processor as it stands, and
 * again for AVX2 (256-bit vectors, fused multiply-add) and for the registers of AVX-512VL.
 *
 * Element with displacement gradient H, F = I + H, and the rotation R nearest to F:
 *
 *   e = sym(R^T F) - I    W = V (lambda/2 (tr e)^2 + mu e:e)    s = lambda tr(e) I + 2 mu e
 *   f_a = -V R s grad N_a
 *
 * which is Mueller and Gross's warped stiffness (2004) written by its stress, and, since R
 * maximises tr(R^T F), the exact gradient of W: the force is conservative. The tangent leaves the
 * turning of R out: with turned gradients g_a = R grad N_a,
 *
 *   K_ab = V (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a.g_b) I)
 *
 * a linear element's at the turned rest shape, never indefinite.
 *
 * The rotation. Newton steps on tr(R^T F), w = (tr(S) I - S)^-1 axl(R^T F), S = sym(R^T F), from
 * the guess q = (1 + tr F, axl F), which a pure rotation meets: one or two steps for small strains.
 * Where they end with tr(S) I - S positive definite R is the one maximum. Elsewhere (large strain,
 * half turns, inside out) tr(R^T F) = q^T N q with the symmetric traceless 4x4 matrix N of Horn
 * (1987): the quaternion is the eigenvector of N's largest eigenvalue, also where F is turned
 * inside out (then S has one negative stretch, the smallest: the element is pushed back the
 * shortest way). With |F| = 1 the eigenvalues are the roots of
 *
 *   x^4 - 2 x^2 - 8 det(F) x + 1 - 4 |cof F|^2
 *
 * (Theobald 2005; c_0 from the singular values), Newton's method from sqrt 3, which no eigenvalue
 * exceeds, falls to the largest, and the adjugate of N - x I is a multiple of q q^T; the Newton
 * steps then finish it. R - I, not R, is multiplied with H, so that small strains keep their
 * digits. No rotation is kept from step to step: what an element feels depends on where its nodes
 * are alone. Rejected: warm-started quaternions (Mueller et al. 2016), state that must be saved,
 * hashed and reset, for a start hardly better than the guess; the polar factor by Higham's
 * iteration, which mirrors instead of turning where F is inside out.
 */
#include <stdbool.h>

#include "models/common/fem_element.h"

enum {
    RUN = 32,       /* blocks, or chunks of scalars, summed in ss_real before double */
    MAX_ROOTS = 24, /* Newton steps for the eigenvalue; halves the distance at a double root */
    POWERS = 24,
    MAX_QUICK = 4, /* Newton steps for the rotation from the guess, */
    MAX_SURE = 8   /* and from the eigenvector */
};
#define ROOT_TOLERANCE 1e-4 /* the Newton steps on the rotation do the rest */
#define LEAST_SLOPE    2e-3 /* of the polynomial, a few hundred times rounding */
#define MAX_TURN       0.5  /* of one of them */
#define DEFINITE       1e-3 /* least of tr(S) I - S that counts as positive definite */
/* |w|^2: below the first R is good, below the second after the step. */
#ifdef SOFTSIM_DOUBLE
#define GOOD_SQUARE 1e-20
#define LAST_SQUARE 1e-10
#else
#define GOOD_SQUARE 1e-11
#define LAST_SQUARE 1e-5
#endif

typedef struct quaternion {
    ss_wide m[4];
} quaternion;

/* ---- the rotation ---- */

/* The largest root of x^4 - 2 x^2 - 8 d x + c, with three real ones below it; at a double root only
 * to the square root of rounding. */
SS_INLINE ss_wide largest_root(ss_wide d, ss_wide c)
{
    const ss_wide d8 = all(8.0) * d, none = all(0.0);
    ss_wide x = all(1.7320509);
    for (int k = 0; k < MAX_ROOTS; ++k) {
        const ss_wide square = x * x;
        const ss_wide value = ss_wide_fnma(d8, x, ss_wide_fma(square, square - all(2.0), c));
        const ss_wide slope = ss_wide_fma(all(4.0) * x, square - all(1.0), none - d8);
        /* above the root both are positive; beside a double root they are rounding, and the end */
        const ss_wide least = all(LEAST_SLOPE);
        const ss_wide step = ss_wide_below(slope, least, none,
                                           ss_wide_most(value, none) / ss_wide_most(slope, least));
        x = x - step;
        if (!ss_wide_any_below(all(ROOT_TOLERANCE), step)) {
            break;
        }
    }
    return x;
}

/* A column of the adjugate replaces q where its own diagonal is larger. */
SS_INLINE void take_larger(ss_wide size, const ss_wide column[4], ss_wide *best, quaternion *q)
{
    for (int k = 0; k < 4; ++k) {
        q->m[k] = ss_wide_below(*best, size, column[k], q->m[k]);
    }
    *best = ss_wide_most(*best, size);
}

SS_INLINE void normalise(quaternion *q)
{
    ss_wide square = q->m[0] * q->m[0];
    for (int k = 1; k < 4; ++k) {
        square = ss_wide_fma(q->m[k], q->m[k], square);
    }
    const ss_wide inverse = all(1.0) / ss_wide_root(ss_wide_most(square, all(1e-30)));
    for (int k = 0; k < 4; ++k) {
        q->m[k] = q->m[k] * inverse;
    }
}

/* The eigenvector of N = Horn's matrix of f for its eigenvalue x, from the adjugate of N - x I. */
SS_INLINE quaternion eigenvector(const tensor *f, ss_wide x)
{
    const ss_wide xx = f->m[0][0], yy = f->m[1][1], zz = f->m[2][2];
    const ss_wide a00 = (xx + yy + zz) - x, a11 = (xx - yy - zz) - x;
    const ss_wide a22 = (yy - xx - zz) - x, a33 = (zz - xx - yy) - x;
    const ss_wide a01 = f->m[2][1] - f->m[1][2], a02 = f->m[0][2] - f->m[2][0];
    const ss_wide a03 = f->m[1][0] - f->m[0][1], a12 = f->m[0][1] + f->m[1][0];
    const ss_wide a13 = f->m[2][0] + f->m[0][2], a23 = f->m[1][2] + f->m[2][1];
    /* minors of rows 0, 1 and of rows 2, 3 */
    const ss_wide s0 = ss_wide_fnma(a01, a01, a00 * a11), s1 = ss_wide_fnma(a01, a02, a00 * a12);
    const ss_wide s2 = ss_wide_fnma(a01, a03, a00 * a13), s3 = ss_wide_fnma(a11, a02, a01 * a12);
    const ss_wide s4 = ss_wide_fnma(a11, a03, a01 * a13), s5 = ss_wide_fnma(a12, a03, a02 * a13);
    const ss_wide c5 = ss_wide_fnma(a23, a23, a22 * a33), c4 = ss_wide_fnma(a13, a23, a12 * a33);
    const ss_wide c3 = ss_wide_fnma(a13, a22, a12 * a23), c2 = ss_wide_fnma(a03, a23, a02 * a33);
    const ss_wide c1 = ss_wide_fnma(a03, a22, a02 * a23);
    const ss_wide b00 = ss_wide_fma(a13, c3, ss_wide_fnma(a12, c4, a11 * c5));
    const ss_wide b01 = ss_wide_fnma(a03, c3, ss_wide_fnma(a01, c5, a02 * c4));
    const ss_wide b02 = ss_wide_fma(a33, s3, ss_wide_fnma(a23, s4, a13 * s5));
    const ss_wide b03 = ss_wide_fnma(a23, s3, ss_wide_fnma(a12, s5, a22 * s4));
    const ss_wide b11 = ss_wide_fma(a03, c1, ss_wide_fnma(a02, c2, a00 * c5));
    const ss_wide b12 = ss_wide_fnma(a33, s1, ss_wide_fnma(a03, s5, a23 * s2));
    const ss_wide b13 = ss_wide_fma(a23, s1, ss_wide_fnma(a22, s2, a02 * s5));
    const ss_wide b22 = ss_wide_fma(a33, s0, ss_wide_fnma(a13, s2, a03 * s4));
    const ss_wide b23 = ss_wide_fnma(a23, s0, ss_wide_fnma(a02, s4, a12 * s2));
    const ss_wide b33 = ss_wide_fma(a22, s0, ss_wide_fnma(a12, s1, a02 * s3));
    /* the other three eigenvalues of N - x I are negative: so is the adjugate's diagonal */
    const ss_wide none = all(0.0);
    ss_wide best = none - b00;
    quaternion q = {{b00, b01, b02, b03}};
    const ss_wide column[3][4] = {{b01, b11, b12, b13}, {b02, b12, b22, b23}, {b03, b13, b23, b33}};
    take_larger(none - b11, column[0], &best, &q);
    take_larger(none - b22, column[1], &best, &q);
    take_larger(none - b33, column[2], &best, &q);
    const ss_wide few = all(1e-4);
    if (ss_wide_any_below(best, few)) {
        /* A multiple eigenvalue: little of the adjugate is left beside rounding, and any of its
         * vectors will do. Powers of N + sqrt 3 I, which is positive, take away the others. */
        const ss_wide shift = x + all(1.7320509);
        ss_wide p[4] = {all(1.0), all(0.6), all(0.5), all(0.4)};
        for (int k = 0; k < POWERS; ++k) {
            const ss_wide w = p[0], u = p[1], v = p[2], z = p[3];
            p[0] = shift * w + (a00 * w + a01 * u + a02 * v + a03 * z);
            p[1] = shift * u + (a01 * w + a11 * u + a12 * v + a13 * z);
            p[2] = shift * v + (a02 * w + a12 * u + a22 * v + a23 * z);
            p[3] = shift * z + (a03 * w + a13 * u + a23 * v + a33 * z);
        }
        for (int k = 0; k < 4; ++k) {
            q.m[k] = ss_wide_below(best, few, p[k], q.m[k]);
        }
    }
    normalise(&q);
    return q;
}

/* The quaternion of the rotation nearest to I + h. */
SS_INLINE quaternion nearest_rotation(const tensor *h)
{
    tensor f = *h;
    for (int i = 0; i < 3; ++i) {
        f.m[i][i] = f.m[i][i] + all(1.0);
    }
    ss_wide square = f.m[0][0] * f.m[0][0];
    for (int k = 1; k < 9; ++k) {
        square = ss_wide_fma(f.m[k / 3][k % 3], f.m[k / 3][k % 3], square);
    }
    const ss_wide inverse = all(1.0) / ss_wide_root(ss_wide_most(square, all(1e-20)));
    for (int k = 0; k < 9; ++k) {
        f.m[k / 3][k % 3] = f.m[k / 3][k % 3] * inverse;
    }
    ss_wide cofactors = all(0.0), det = all(0.0);
    for (int k = 0; k < 9; ++k) {
        const ss_wide c = minor_of(&f, k / 3, k % 3);
        cofactors = ss_wide_fma(c, c, cofactors);
        det = k < 3 ? ss_wide_fma(f.m[0][k], c, det) : det;
    }
    const ss_wide x = largest_root(det, ss_wide_fnma(all(4.0), cofactors, all(1.0)));
    return eigenvector(&f, x);
}

/* Exact where I + h is a rotation. */
SS_INLINE quaternion guess_rotation(const tensor *h)
{
    quaternion q = {{((h->m[0][0] + h->m[1][1]) + h->m[2][2]) + all(4.0), h->m[2][1] - h->m[1][2],
                     h->m[0][2] - h->m[2][0], h->m[1][0] - h->m[0][1]}};
    normalise(&q);
    return q;
}

/* R - I */
SS_INLINE tensor turn_of(const quaternion *q)
{
    const ss_wide w = q->m[0] + q->m[0], x = q->m[1] + q->m[1];
    const ss_wide y = q->m[2] + q->m[2], z = q->m[3] + q->m[3];
    const ss_wide xx = x * q->m[1], yy = y * q->m[2], zz = z * q->m[3];
    const ss_wide xy = x * q->m[2], xz = x * q->m[3], yz = y * q->m[3];
    const ss_wide wx = w * q->m[1], wy = w * q->m[2], wz = w * q->m[3];
    const ss_wide none = all(0.0);
    return (tensor){{{none - (yy + zz), xy - wz, xz + wy},
                     {xy + wz, none - (xx + zz), yz - wx},
                     {xz - wy, yz + wx, none - (xx + yy)}}};
}

/* e = sym(R^T (I + h)) - I; axis = axl(R^T (I + h)). `turn` is R - I. */
SS_INLINE symmetric strain_of(const tensor *h, const tensor *turn, const quaternion *q,
                              ss_wide axis[3])
{
    tensor g; /* R^T h */
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            g.m[i][j] = column_product(turn, i, h, j, h->m[i][j]);
        }
    }
    const ss_wide half = all(0.5), w4 = all(4.0) * q->m[0];
    symmetric e;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        e.m[k] = g.m[k][k] + turn->m[k][k];
        e.m[3 + k] = half * ((g.m[i][j] + g.m[j][i]) + (turn->m[i][j] + turn->m[j][i]));
        axis[k] = ss_wide_fnma(w4, q->m[k + 1], g.m[j][i] - g.m[i][j]);
    }
    return e;
}

/* One step on tr(R^T F): q := q (1, w/2), normalised; returns |w|^2, or 1 where no maximum is near.
 */
SS_INLINE ss_wide polish(const symmetric *e, const ss_wide axis[3], quaternion *q)
{
    /* G = tr(S) I - S, S = I + e */
    const ss_wide base = all(2.0);
    const ss_wide xx = (base + e->m[1]) + e->m[2], yy = (base + e->m[0]) + e->m[2];
    const ss_wide zz = (base + e->m[0]) + e->m[1];
    const ss_wide yz = all(0.0) - e->m[3], xz = all(0.0) - e->m[4], xy = all(0.0) - e->m[5];
    const ss_wide cxx = ss_wide_fnma(yz, yz, yy * zz), cxy = ss_wide_fnma(xy, zz, xz * yz);
    const ss_wide cxz = ss_wide_fnma(xz, yy, xy * yz), cyy = ss_wide_fnma(xz, xz, xx * zz);
    const ss_wide cyz = ss_wide_fnma(xx, yz, xy * xz), czz = ss_wide_fnma(xy, xy, xx * yy);
    const ss_wide det = ss_wide_fma(xz, cxz, ss_wide_fma(xy, cxy, xx * cxx));
    /* the least of Sylvester's minors: below DEFINITE no maximum is near, or it is no point, and a
     * step along the gradient is all that is safe */
    const ss_wide none = all(0.0), definite = all(DEFINITE);
    const ss_wide minor = none - ss_wide_most(none - xx, ss_wide_most(none - czz, none - det));
    const ss_wide inverse = all(1.0) / ss_wide_most(det, definite);
    const ss_wide plain = all(1.0) / ss_wide_most(xx + yy + zz, all(0.1));
    const ss_wide newton[3] = {
        inverse * ss_wide_fma(cxz, axis[2], ss_wide_fma(cxy, axis[1], cxx * axis[0])),
        inverse * ss_wide_fma(cyz, axis[2], ss_wide_fma(cyy, axis[1], cxy * axis[0])),
        inverse * ss_wide_fma(czz, axis[2], ss_wide_fma(cyz, axis[1], cxz * axis[0]))};
    ss_wide w[3];
    for (int k = 0; k < 3; ++k) {
        w[k] = ss_wide_below(minor, definite, plain * axis[k], newton[k]);
    }
    const ss_wide square = ss_wide_fma(w[2], w[2], ss_wide_fma(w[1], w[1], w[0] * w[0]));
    const ss_wide limit = all(MAX_TURN * MAX_TURN);
    const ss_wide half = all(0.5) * ss_wide_root(limit / ss_wide_most(square, limit));
    const ss_wide x = half * w[0], y = half * w[1], z = half * w[2];
    const quaternion p = *q;
    q->m[0] = ss_wide_fnma(p.m[1], x, ss_wide_fnma(p.m[2], y, ss_wide_fnma(p.m[3], z, p.m[0])));
    q->m[1] = ss_wide_fma(p.m[0], x, ss_wide_fma(p.m[2], z, ss_wide_fnma(p.m[3], y, p.m[1])));
    q->m[2] = ss_wide_fma(p.m[0], y, ss_wide_fma(p.m[3], x, ss_wide_fnma(p.m[1], z, p.m[2])));
    q->m[3] = ss_wide_fma(p.m[0], z, ss_wide_fma(p.m[1], y, ss_wide_fnma(p.m[2], x, p.m[3])));
    normalise(q);
    return ss_wide_below(minor, definite, all(1.0), square);
}

/* What belongs to a rotation of an element. */
typedef struct turned_element {
    quaternion q;
    tensor turn; /* R - I */
    symmetric e;
} turned_element;

/* Newton steps from t->q; false where one lane has not come to a maximum. */
SS_INLINE bool fit_rotation(const tensor *h, int max_steps, turned_element *t)
{
    ss_wide axis[3];
    t->turn = turn_of(&t->q);
    t->e = strain_of(h, &t->turn, &t->q, axis);
    for (int k = 0; k < max_steps; ++k) {
        quaternion better = t->q;
        const ss_wide square = polish(&t->e, axis, &better);
        if (!ss_wide_any_below(all(GOOD_SQUARE), square)) {
            return true;
        }
        t->q = better;
        t->turn = turn_of(&t->q);
        t->e = strain_of(h, &t->turn, &t->q, axis);
        if (!ss_wide_any_below(all(LAST_SQUARE), square)) {
            return true;
        }
    }
    return false;
}

/* det(I + e) */
SS_INLINE ss_wide volume_ratio(const symmetric *e)
{
    const ss_wide x = e->m[0] + all(1.0), y = e->m[1] + all(1.0), z = e->m[2] + all(1.0);
    const ss_wide first = ss_wide_fnma(e->m[3], e->m[3], y * z);
    const ss_wide second = ss_wide_fnma(e->m[5], z, e->m[4] * e->m[3]);
    const ss_wide third = ss_wide_fnma(e->m[4], y, e->m[5] * e->m[3]);
    return ss_wide_fma(e->m[4], third, ss_wide_fma(e->m[5], second, x * first));
}

/* ---- elements ---- */

/* Gradients at `shape` turned by I + turn. */
SS_INLINE void turn_gradients(const tensor *turn, const ss_real *shape, ss_real *turned)
{
    for (int a = 0; a < 3; ++a) {
        const ss_wide x = ss_wide_load(shape + SS_FEM_LANES * (3 * a));
        const ss_wide y = ss_wide_load(shape + SS_FEM_LANES * (3 * a + 1));
        const ss_wide z = ss_wide_load(shape + SS_FEM_LANES * (3 * a + 2));
        const ss_wide old[3] = {x, y, z};
        for (int i = 0; i < 3; ++i) {
            ss_wide sum = ss_wide_fma(turn->m[i][0], x, old[i]);
            sum = ss_wide_fma(turn->m[i][1], y, sum);
            ss_wide_store(turned + SS_FEM_LANES * (3 * a + i), ss_wide_fma(turn->m[i][2], z, sum));
        }
    }
}

/* The first element of the lanes whose determinant is below 0, and their number. */
static void note_inverted(ss_corot_pass *pass, const int32_t *number, const ss_real *det)
{
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        if (det[k] < 0 && number[k] >= 0) {
            const bool is_first = pass->inverted_count++ == 0 || number[k] < pass->first_inverted;
            pass->first_inverted = is_first ? number[k] : pass->first_inverted;
        }
    }
}

/* SS_WIDE_LANES elements; returns twice their energy. `number`: theirs in the mesh. */
SS_INLINE ss_wide evaluate_some(ss_corot_pass *pass, const element *some, const int32_t *number,
                                ss_real *turned)
{
    turned_element t;
    t.q = guess_rotation(&some->h);
    if (!fit_rotation(&some->h, MAX_QUICK, &t)) {
        t.q = nearest_rotation(&some->h);
        (void)fit_rotation(&some->h, MAX_SURE, &t);
    }
    const ss_wide ratio = volume_ratio(&t.e);
    if (ss_wide_any_below(ratio, all(0.0))) {
        _Alignas(64) ss_real lane[SS_WIDE_LANES];
        ss_wide_store(lane, ratio);
        note_inverted(pass, number, lane);
    }
    /* -s = -lambda tr(e) I - 2 mu e, for the force is -V R s grad N */
    const ss_wide minus = all(-2.0);
    const symmetric s = hooke(minus * some->lambda, minus * some->mu, &t.e, all(0.0));
    tensor p = full(&s);
    add_symmetric(&p, &t.turn, &s);
    spread(some, &p, pass->force);
    turn_gradients(&t.turn, some->shape, turned);
    return all(0.0) - contract(&s, &t.e);
}

static void evaluate(ss_corot_pass *pass)
{
    const ss_fem_blocks *blocks = pass->blocks;
    double twice = 0.0;
    pass->inverted_count = 0;
    pass->first_inverted = -1;
    for (int32_t first = 0; first < blocks->count; first += RUN) {
        const int32_t end = first + RUN < blocks->count ? first + RUN : blocks->count;
        ss_wide sum = all(0.0);
        for (int32_t b = first; b < end; ++b) {
            for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
                const ptrdiff_t at = (ptrdiff_t)b * SS_FEM_LANES;
                const ss_real *modulus = blocks->modulus + SS_FEM_MODULI * at + lane;
                element some = {.at = blocks->node + 4 * at + lane,
                                .shape = blocks->shape + SS_FEM_SHAPES * at + lane,
                                .lambda = ss_wide_load(modulus),
                                .mu = ss_wide_load(modulus + SS_FEM_LANES)};
                some.h = gradient(&some, pass->u);
                sum = sum + evaluate_some(pass, &some, blocks->element + at + lane,
                                          pass->turned + SS_FEM_SHAPES * at + lane);
            }
        }
        twice += ss_wide_sum(sum);
    }
    pass->energy = 0.5 * twice;
}

static void multiply(const ss_fem_blocks *blocks, const ss_real *turned, const ss_real *modulus,
                     double scale, const ss_real *x, ss_real *out)
{
    const ss_wide share = all(scale);
    for (int32_t b = 0; b < blocks->count; ++b) {
        for (int lane = 0; lane < SS_FEM_LANES; lane += SS_WIDE_LANES) {
            const ptrdiff_t at = (ptrdiff_t)b * SS_FEM_LANES;
            const ss_real *m = modulus + SS_FEM_MODULI * at + lane;
            const element some = {.at = blocks->node + 4 * at + lane,
                                  .shape = turned + SS_FEM_SHAPES * at + lane};
            const tensor h = gradient(&some, x);
            const symmetric d = twice_small(&h);
            const symmetric s = hooke(share * ss_wide_load(m),
                                      share * ss_wide_load(m + SS_FEM_LANES), &d, all(0.0));
            const tensor p = full(&s);
            spread(&some, &p, out);
        }
    }
}

/* ---- vectors ---- */

static double dot(int32_t count, const ss_real *x, const ss_real *y)
{
    double total = 0.0;
    for (int32_t first = 0; first < count; first += RUN * SS_FEM_LANES) {
        const int32_t end = first + RUN * SS_FEM_LANES < count ? first + RUN * SS_FEM_LANES : count;
        ss_wide sum = all(0.0);
        for (int32_t k = first; k < end; k += SS_WIDE_LANES) {
            sum = ss_wide_fma(ss_wide_load(x + k), ss_wide_load(y + k), sum);
        }
        total += ss_wide_sum(sum);
    }
    return total;
}

static void scale(int32_t count, double s, const ss_real *a, const ss_real *x, ss_real *out)
{
    const ss_wide share = all(s);
    for (int32_t k = 0; k < count; k += SS_WIDE_LANES) {
        ss_wide_store(out + k, share * (ss_wide_load(a + k) * ss_wide_load(x + k)));
    }
}

static void turn(int32_t count, double s, const ss_real *z, ss_real *p)
{
    const ss_wide share = all(s);
    for (int32_t k = 0; k < count; k += SS_WIDE_LANES) {
        ss_wide_store(p + k, ss_wide_fma(share, ss_wide_load(p + k), ss_wide_load(z + k)));
    }
}

static double descend(int32_t count, double s, const ss_real *p, const ss_real *q,
                      const ss_real *inverse, ss_real *x, ss_real *r, ss_real *z)
{
    const ss_wide share = all(s);
    double total = 0.0;
    for (int32_t first = 0; first < count; first += RUN * SS_FEM_LANES) {
        const int32_t end = first + RUN * SS_FEM_LANES < count ? first + RUN * SS_FEM_LANES : count;
        ss_wide sum = all(0.0);
        for (int32_t k = first; k < end; k += SS_WIDE_LANES) {
            const ss_wide left = ss_wide_fnma(share, ss_wide_load(q + k), ss_wide_load(r + k));
            const ss_wide next = ss_wide_load(inverse + k) * left;
            ss_wide_store(x + k, ss_wide_fma(share, ss_wide_load(p + k), ss_wide_load(x + k)));
            ss_wide_store(r + k, left);
            ss_wide_store(z + k, next);
            sum = ss_wide_fma(left, next, sum);
        }
        total += ss_wide_sum(sum);
    }
    return total;
}

/* ---- the table ---- */

SS_KERNEL_TABLE_512(ss_corot_kernels, .evaluate = evaluate, .multiply = multiply, .dot = dot,
                    .scale = scale, .turn = turn, .descend = descend);
