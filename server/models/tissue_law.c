/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/tissue_law.h"
/*
 * With F = I + H, J = det F, C = cof F = J F^-T = dJ/dF, and the Green strain
 *
 *   E = (F^T F - I)/2 = (H + H^T + H^T H)/2
 *
 * stvk                 W = lambda/2 (tr E)^2 + mu E:E        P = F S, S = lambda tr(E) I + 2 mu E
 * stvk-guarded         the same; for J < J0   W += kappa/2 (J0 - J)^2   P -= kappa (J0 - J) C
 *                      kappa = lambda + 2 mu
 * neo-hookean          W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2,  I1 = tr F^T F,
 *                      K = lambda + 2/3 mu                   P = mu g F + (mu/2 g' I1 + K (J-1)) C
 *                      g = J^(-2/3); below J1 the parabola with g's value and slopes at J1
 * stable-neo-hookean   P = m (1 - 1/(I1 + 1)) F + l (J - alpha) C
 *                      m = 4/3 mu, l = lambda + 5/6 mu, alpha = 1 + 3/4 m/l
 * linear               W = lambda/2 (tr e)^2 + mu e:e        P = lambda tr(e) I + 2 mu e
 *                      e = (H + H^T)/2
 *
 * stvk is eqs. (1), (2) and (6) of the hybrid model's paper taken together: its strain lacks the
 * 1/2 and its force has one, which cancel; mending one alone doubles or halves the stiffness. The
 * guard makes the confined uniaxial P(s) strictly monotone; without it a crushed element turns
 * over and stays. Smith, de Goes, Kim: "Stable Neo-Hookean flesh simulation", 2018. The viscous
 * stress, eqs. (3) and (4) of the paper, is that of the strain's rate,
 *
 *   P_v = F (phi tr(Edot) I + 2 psi Edot),   Edot = sym(F^T Fdot),
 *
 * (linear: of edot, without F), and dissipates phi (tr Edot)^2 + 2 psi Edot:Edot.
 *
 * Every term is arranged so that it is small where H is small. With Q = C - I = tr(H) I - H^T +
 * cof H and j = J - 1, neo-hookean is mu g (H - Q) + (K j - mu g r) C, r = (2/3 tr E - j)/J, and
 * stable-neo-hookean 3/4 m (H - Q) + m tr(E)/(2 (I1 + 1)) F + l j C. Rejected: taking F, where
 * stresses of opposite sign cancel at rest.
 */
#include <math.h>
#include <string.h>

void ss_tissue_lame(double youngs_modulus, double poisson_ratio, double *out_lambda, double *out_mu)
{
    *out_lambda =
        youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    *out_mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
}

/* ---- matrices ---- */

static double trace(const double a[9])
{
    return a[0] + a[4] + a[8];
}

static double scalar_product(const double a[9], const double b[9])
{
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        sum += a[3 * i] * b[3 * i] + a[3 * i + 1] * b[3 * i + 1] + a[3 * i + 2] * b[3 * i + 2];
    }
    return sum;
}

/* out += s a */
static void add_scaled_matrix(double out[9], double s, const double a[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[3 * i + j] += s * a[3 * i + j];
        }
    }
}

/* out += s a b */
static void add_product(double out[9], double s, const double a[9], const double b[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[3 * i + j] +=
                s * (a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]);
        }
    }
}

/* sym(a^T b) + sym(b) */
static void symmetric_part(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double sum = b[3 * i + j] + b[3 * j + i];
            for (int k = 0; k < 3; ++k) {
                sum += a[3 * k + i] * b[3 * k + j] + a[3 * k + j] * b[3 * k + i];
            }
            out[3 * i + j] = 0.5 * sum;
        }
    }
}

static void small_strain(const double h[9], double out[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[3 * i + j] = 0.5 * (h[3 * i + j] + h[3 * j + i]);
        }
    }
}

/* E = (H + H^T + H^T H)/2 */
static void green_strain(const double h[9], double out[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double sum = h[3 * i + j] + h[3 * j + i];
            for (int k = 0; k < 3; ++k) {
                sum += h[3 * k + i] * h[3 * k + j];
            }
            out[3 * i + j] = 0.5 * sum;
        }
    }
}

/* out = l tr(e) I + 2 m e */
static void hooke_stress(double l, double m, const double e[9], double out[9])
{
    const double pressure = l * trace(e);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[3 * i + j] = 2.0 * m * e[3 * i + j] + (i == j ? pressure : 0.0);
        }
    }
}

/* out = the bilinear form of the cofactor: cof(a + b) = cof a + mixed(a, b) + cof b. */
static void mixed_cofactor(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[3 * i + j] = a[3 * i1 + j1] * b[3 * i2 + j2] + b[3 * i1 + j1] * a[3 * i2 + j2] -
                             a[3 * i1 + j2] * b[3 * i2 + j1] - b[3 * i1 + j2] * a[3 * i2 + j1];
        }
    }
}

/* What the laws of J need. */
typedef struct volume {
    double j;    /* J - 1 */
    double q[9]; /* C - I */
    double c[9]; /* cof F */
} volume;

static volume volume_of(const double h[9])
{
    volume v;
    double twice[9];
    const double t = trace(h);
    mixed_cofactor(h, h, twice); /* 2 cof H */
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            v.q[3 * i + j] = 0.5 * twice[3 * i + j] - h[3 * j + i] + (i == j ? t : 0.0);
            v.c[3 * i + j] = v.q[3 * i + j] + (i == j ? 1.0 : 0.0);
        }
    }
    /* det(I + H) - 1 = tr H + tr cof H + det H, det H = row 0 of H times row 0 of cof H */
    double det = 0.0;
    for (int k = 0; k < 3; ++k) {
        det += h[k] * 0.5 * twice[k];
    }
    v.j = t + 0.5 * trace(twice) + det;
    return v;
}

double ss_tissue_volume_change(const double h[9])
{
    return volume_of(h).j;
}

/* ---- laws ---- */

/* g(J) - 1 and its derivatives: J^(-2/3), or the parabola below the floor. */
static void isochoric_terms(double j, double *out_g1, double *out_slope, double *out_bend)
{
    const double floor_j = SS_TISSUE_FLOOR - 1.0;
    const double at = j > floor_j ? j : floor_j, ratio = 1.0 + at, below = j - at;
    const double g1 = expm1(-2.0 / 3.0 * log1p(at));
    const double slope = -2.0 / 3.0 * (1.0 + g1) / ratio, bend = -5.0 / 3.0 * slope / ratio;
    *out_g1 = g1 + below * (slope + 0.5 * below * bend);
    *out_slope = slope + below * bend;
    *out_bend = bend;
}

const char *ss_tissue_name(ss_tissue_kind kind)
{
    static const char *const name[SS_TISSUE_KIND_COUNT] = {"stvk-guarded", "stvk", "neo-hookean",
                                                           "stable-neo-hookean", "linear"};
    return name[kind];
}

/* Moduli of stable-neo-hookean. */
static void stable_moduli(const ss_tissue_law *law, double *out_m, double *out_l)
{
    *out_m = 4.0 / 3.0 * law->mu;
    *out_l = law->lambda + 5.0 / 6.0 * law->mu;
}

double ss_tissue_energy(const ss_tissue_law *law, const double h[9])
{
    double e[9];
    if (law->kind == SS_TISSUE_LINEAR) {
        small_strain(h, e);
    } else {
        green_strain(h, e);
    }
    const double t = trace(e), j = volume_of(h).j;
    if (law->kind == SS_TISSUE_NEO_HOOKEAN) {
        double g1, slope, bend;
        isochoric_terms(j, &g1, &slope, &bend);
        const double bulk = law->lambda + 2.0 / 3.0 * law->mu;
        return 0.5 * law->mu * (g1 * (3.0 + 2.0 * t) + 2.0 * t) + 0.5 * bulk * j * j;
    }
    if (law->kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        double m, l;
        stable_moduli(law, &m, &l);
        return m * t - 0.75 * m * j + 0.5 * l * j * j - 0.5 * m * log1p(0.5 * t);
    }
    const double short_of = SS_TISSUE_GUARD - 1.0 - j;
    const double guard = law->kind == SS_TISSUE_STVK_GUARDED && short_of > 0.0
                             ? 0.5 * (law->lambda + 2.0 * law->mu) * short_of * short_of
                             : 0.0;
    return 0.5 * law->lambda * t * t + law->mu * scalar_product(e, e) + guard;
}

void ss_tissue_stress(const ss_tissue_law *law, const double h[9], double out_p[9])
{
    double e[9];
    if (law->kind == SS_TISSUE_LINEAR) {
        small_strain(h, e);
        hooke_stress(law->lambda, law->mu, e, out_p);
        return;
    }
    green_strain(h, e);
    const volume v = volume_of(h);
    const double t = trace(e);
    memset(out_p, 0, 9 * sizeof(double));
    if (law->kind == SS_TISSUE_NEO_HOOKEAN) {
        double g1, slope, bend;
        isochoric_terms(v.j, &g1, &slope, &bend);
        const double g = law->mu * (1.0 + g1), bulk = law->lambda + 2.0 / 3.0 * law->mu;
        /* -g r above the floor, where g' = -2/3 g/J */
        const double rest = v.j >= SS_TISSUE_FLOOR - 1.0
                                ? -g * (2.0 / 3.0 * t - v.j) / (1.0 + v.j)
                                : g + 0.5 * law->mu * slope * (3.0 + 2.0 * t);
        add_scaled_matrix(out_p, g, h);
        add_scaled_matrix(out_p, -g, v.q);
        add_scaled_matrix(out_p, rest + bulk * v.j, v.c);
    } else if (law->kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        double m, l;
        stable_moduli(law, &m, &l);
        const double stretch = m * t / (2.0 * (4.0 + 2.0 * t));
        add_scaled_matrix(out_p, 0.75 * m + stretch, h);
        add_scaled_matrix(out_p, -0.75 * m, v.q);
        add_scaled_matrix(out_p, l * v.j, v.c);
        for (int i = 0; i < 3; ++i) {
            out_p[3 * i + i] += stretch;
        }
    } else {
        double s[9];
        hooke_stress(law->lambda, law->mu, e, s);
        add_scaled_matrix(out_p, 1.0, s);
        add_product(out_p, 1.0, h, s);
        const double short_of = SS_TISSUE_GUARD - 1.0 - v.j;
        if (law->kind == SS_TISSUE_STVK_GUARDED && short_of > 0.0) {
            add_scaled_matrix(out_p, -(law->lambda + 2.0 * law->mu) * short_of, v.c);
        }
    }
}

static void strain_rate(const ss_tissue_law *law, const double h[9], const double rate[9],
                        double out[9])
{
    if (law->kind == SS_TISSUE_LINEAR) {
        small_strain(rate, out);
    } else {
        symmetric_part(h, rate, out);
    }
}

void ss_tissue_viscous_stress(const ss_tissue_law *law, const double h[9], const double rate[9],
                              double out_p[9])
{
    double e[9], s[9];
    strain_rate(law, h, rate, e);
    hooke_stress(law->phi, law->psi, e, s);
    memcpy(out_p, s, sizeof s);
    if (law->kind != SS_TISSUE_LINEAR) {
        add_product(out_p, 1.0, h, s);
    }
}

double ss_tissue_dissipation(const ss_tissue_law *law, const double h[9], const double rate[9])
{
    double e[9];
    strain_rate(law, h, rate, e);
    return law->phi * trace(e) * trace(e) + 2.0 * law->psi * scalar_product(e, e);
}

/* ---- tangents ---- */

/* d(s a F) etc. of the laws of J: out = a dF + da F + b dC + db C. */
static void add_invariant_tangents(double out[9], const double h[9], const double dh[9],
                                   const volume *v, double a, double da, double b, double db)
{
    double dc[9];
    const double t = trace(dh);
    mixed_cofactor(h, dh, dc);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            dc[3 * i + j] += (i == j ? t : 0.0) - dh[3 * j + i];
        }
        out[3 * i + i] += da;
    }
    add_scaled_matrix(out, a, dh);
    add_scaled_matrix(out, da, h);
    add_scaled_matrix(out, b, dc);
    add_scaled_matrix(out, db, v->c);
}

static void add_stvk_tangent(const ss_tissue_law *law, const double h[9], const double dh[9],
                             double out[9])
{
    double e[9], s[9];
    symmetric_part(h, dh, e); /* dE */
    hooke_stress(law->lambda, law->mu, e, s);
    add_scaled_matrix(out, 1.0, s);
    add_product(out, 1.0, h, s); /* F dS */
    green_strain(h, e);
    hooke_stress(law->lambda, law->mu, e, s);
    add_product(out, 1.0, dh, s); /* dF S */
}

void ss_tissue_tangent(const ss_tissue_law *law, const double h[9], const double dh[9],
                       double out_dp[9])
{
    double e[9];
    if (law->kind == SS_TISSUE_LINEAR) {
        small_strain(dh, e);
        hooke_stress(law->lambda, law->mu, e, out_dp);
        return;
    }
    memset(out_dp, 0, 9 * sizeof(double));
    const volume v = volume_of(h);
    const double dj = scalar_product(v.c, dh);
    green_strain(h, e);
    const double invariant = 3.0 + 2.0 * trace(e);                        /* I1 */
    const double d_invariant = 2.0 * (trace(dh) + scalar_product(h, dh)); /* 2 F:dF */
    if (law->kind == SS_TISSUE_NEO_HOOKEAN) {
        double g1, slope, bend;
        isochoric_terms(v.j, &g1, &slope, &bend);
        const double mu = law->mu, bulk = law->lambda + 2.0 / 3.0 * mu;
        add_invariant_tangents(out_dp, h, dh, &v, mu * (1.0 + g1), mu * slope * dj,
                               0.5 * mu * slope * invariant + bulk * v.j,
                               0.5 * mu * (bend * dj * invariant + slope * d_invariant) +
                                   bulk * dj);
    } else if (law->kind == SS_TISSUE_STABLE_NEO_HOOKEAN) {
        double m, l;
        stable_moduli(law, &m, &l);
        const double inverse = 1.0 / (invariant + 1.0);
        add_invariant_tangents(out_dp, h, dh, &v, m * (1.0 - inverse),
                               m * inverse * inverse * d_invariant, l * v.j - 0.75 * m, l * dj);
    } else {
        add_stvk_tangent(law, h, dh, out_dp);
        const double short_of = SS_TISSUE_GUARD - 1.0 - v.j;
        if (law->kind == SS_TISSUE_STVK_GUARDED && short_of > 0.0) {
            const double kappa = law->lambda + 2.0 * law->mu;
            add_invariant_tangents(out_dp, h, dh, &v, 0.0, 0.0, -kappa * short_of, kappa * dj);
        }
    }
}
