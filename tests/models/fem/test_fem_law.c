/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The laws of tissue against closed forms, and against themselves: stress is the slope of energy,
 * the tangent that of stress. */
#include "common/test.h"

#include <string.h>

#include "common/number_fixture.h"
#include "mesh/tetrahedron.h"
#include "models/tissue_law.h"

static const char *const names[SS_TISSUE_KIND_COUNT] = {"stvk-guarded", "stvk", "neo-hookean",
                                                        "stable-neo-hookean", "linear"};

static void random_matrix(double size, double out[9])
{
    for (int k = 0; k < 9; ++k) {
        out[k] = size * random_unit();
    }
}

static void near_to(double a, double b, double tolerance, const char *what, int kind)
{
    if (!(fabs(a - b) <= tolerance)) {
        fail_msg("%s, %s: %.17g, expected %.17g within %.3g", names[kind], what, a, b, tolerance);
    }
}

static ss_tissue_law law_of(int kind)
{
    return (ss_tissue_law){
        .kind = (ss_tissue_kind)kind, .lambda = 5.5, .mu = 2.5, .phi = 0.3, .psi = 0.7};
}

static double contract(const double a[9], const double b[9])
{
    double sum = 0.0;
    for (int k = 0; k < 9; ++k) {
        sum += a[k] * b[k];
    }
    return sum;
}

static void along(const double h[9], double s, const double x[9], double out[9])
{
    for (int k = 0; k < 9; ++k) {
        out[k] = h[k] + s * x[k];
    }
}

/* States: moderate, squashed below the guard, inverted beyond neo-hookean's floor. */
static void random_gradient(int which, double h[9])
{
    random_matrix(which == 0 ? 0.3 : 0.1, h);
    if (which == 1) {
        h[8] -= 0.6;
    } else if (which == 2) {
        h[0] -= 1.7;
    }
}

TEST(stress_is_the_slope_of_energy)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        const ss_tissue_law law = law_of(kind);
        for (int trial = 0; trial < 60; ++trial) {
            double h[9], x[9], p[9], low[9], high[9];
            const double step = 1e-5;
            random_gradient(trial % 3, h);
            random_matrix(1.0, x);
            ss_tissue_stress(&law, h, p);
            along(h, -step, x, low);
            along(h, step, x, high);
            const double slope =
                (ss_tissue_energy(&law, high) - ss_tissue_energy(&law, low)) / (2.0 * step);
            near_to(contract(p, x), slope, 2e-8 * (1.0 + fabs(slope)), "P : X", kind);
        }
    }
}

TEST(tangent_is_the_slope_of_stress)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        const ss_tissue_law law = law_of(kind);
        for (int trial = 0; trial < 60; ++trial) {
            double h[9], x[9], y[9], dp[9], low[9], high[9], p[2][9];
            const double step = 1e-5;
            random_gradient(trial % 3, h);
            random_matrix(1.0, x);
            random_matrix(1.0, y);
            ss_tissue_tangent(&law, h, x, dp);
            along(h, -step, x, low);
            along(h, step, x, high);
            ss_tissue_stress(&law, low, p[0]);
            ss_tissue_stress(&law, high, p[1]);
            for (int k = 0; k < 9; ++k) {
                const double slope = (p[1][k] - p[0][k]) / (2.0 * step);
                near_to(dp[k], slope, 1e-6 * (1.0 + fabs(slope)), "dP", kind);
            }
            const double yx = contract(y, dp);
            ss_tissue_tangent(&law, h, y, dp);
            near_to(contract(x, dp), yx, 1e-10 * (1.0 + fabs(yx)), "symmetry of the tangent", kind);
        }
    }
}

TEST(uniaxial_stress_is_that_of_the_closed_forms)
{
    static const double stretch[3] = {0.8, 1.2, 1.5};
    static const double confined[3] = {-1.512, 2.772, 9.84375};
    static const double free_sides[3] = {-0.9675, 1.77375, 6.298828125};
    const ss_tissue_law law = law_of(SS_TISSUE_STVK);
    for (int k = 0; k < 3; ++k) {
        double h[9] = {stretch[k] - 1.0}, p[9];
        ss_tissue_stress(&law, h, p);
        near_to(p[0], confined[k], 1e-12, "confined", SS_TISSUE_STVK);
        /* free sides: E22 = E33 = -nu E11 */
        const double nu = 5.5 / 16.0, e = 0.5 * (stretch[k] * stretch[k] - 1.0);
        h[4] = h[8] = sqrt(1.0 - 2.0 * nu * e) - 1.0;
        ss_tissue_stress(&law, h, p);
        near_to(p[0], free_sides[k], 1e-12, "free", SS_TISSUE_STVK);
        near_to(p[4], 0.0, 1e-12, "side", SS_TISSUE_STVK);
    }
    /* nh, uniform dilatation by s: P = K (s^3 - 1) s^2 */
    const ss_tissue_law nh = law_of(SS_TISSUE_NEO_HOOKEAN);
    double h[9] = {0.3, 0, 0, 0, 0.3, 0, 0, 0, 0.3}, p[9];
    ss_tissue_stress(&nh, h, p);
    near_to(p[4], (5.5 + 5.0 / 3.0) * (1.3 * 1.3 * 1.3 - 1.0) * 1.69, 1e-12, "dilatation",
            SS_TISSUE_NEO_HOOKEAN);
    /* snh, as published: P = m (1 - 1/(I + 1)) F + l (J - alpha) C */
    const ss_tissue_law snh = law_of(SS_TISSUE_STABLE_NEO_HOOKEAN);
    const double m = 4.0 / 3.0 * 2.5, l = 5.5 + 5.0 / 6.0 * 2.5, alpha = 1.0 + 0.75 * m / l;
    const double squashed[9] = {-0.5};
    ss_tissue_stress(&snh, squashed, p);
    near_to(p[0], m * (1.0 - 1.0 / 3.25) * 0.5 + l * (0.5 - alpha), 1e-12, "squashed",
            SS_TISSUE_STABLE_NEO_HOOKEAN);
}

TEST(guard_makes_confined_compression_monotone)
{
    const ss_tissue_law guarded = law_of(SS_TISSUE_STVK_GUARDED), plain = law_of(SS_TISSUE_STVK);
    double last = -1e30, last_plain = -1e30, p[9];
    int turns = 0;
    for (int k = 0; k <= 3000; ++k) {
        const double h[9] = {-2.0 + 0.001 * k};
        ss_tissue_stress(&guarded, h, p);
        assert_true(p[0] > last);
        last = p[0];
        ss_tissue_stress(&plain, h, p);
        turns += p[0] <= last_plain;
        last_plain = p[0];
    }
    assert_true(turns > 0); /* what the guard is for */
}

TEST(all_laws_agree_at_rest)
{
    const ss_tissue_law linear = law_of(SS_TISSUE_LINEAR);
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        const ss_tissue_law law = law_of(kind);
        const double zero[9] = {0.0};
        double x[9], p[9], expected[9];
        ss_tissue_stress(&law, zero, p);
        random_matrix(1.0, x);
        assert_true(contract(p, p) == 0.0);
        assert_true(ss_tissue_energy(&law, zero) == 0.0);
        ss_tissue_tangent(&law, zero, x, p);
        ss_tissue_tangent(&linear, zero, x, expected);
        for (int k = 0; k < 9; ++k) {
            near_to(p[k], expected[k], 1e-12, "tangent at rest", kind);
        }
    }
}

/* P(Q F) = Q P(F), and no viscous stress from turning. */
TEST(turning_the_body_turns_the_stress)
{
    const double c = cos(0.7), s = sin(0.7);
    const double q[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
    const double spin[9] = {-s, -c, 0, c, -s, 0, 0, 0, 0};
    for (int kind = 0; kind < SS_TISSUE_LINEAR; ++kind) {
        const ss_tissue_law law = law_of(kind);
        double h[9], turned[9], rate[9], p[9], pq[9];
        random_matrix(0.2, h);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                turned[3 * i + j] = rate[3 * i + j] = 0.0;
                for (int k = 0; k < 3; ++k) {
                    turned[3 * i + j] += q[3 * i + k] * (h[3 * k + j] + (k == j));
                    rate[3 * i + j] += spin[3 * i + k] * (h[3 * k + j] + (k == j));
                }
                turned[3 * i + j] -= i == j;
            }
        }
        ss_tissue_stress(&law, h, p);
        ss_tissue_stress(&law, turned, pq);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                near_to(pq[3 * i + j],
                        q[3 * i] * p[j] + q[3 * i + 1] * p[3 + j] + q[3 * i + 2] * p[6 + j], 1e-12,
                        "turned", kind);
            }
        }
        assert_true(ss_tissue_dissipation(&law, turned, rate) < 1e-25);
    }
}

TEST(viscous_power_is_stress_times_rate)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        const ss_tissue_law law = law_of(kind);
        double h[9], rate[9], p[9];
        random_matrix(0.4, h);
        random_matrix(1.0, rate);
        ss_tissue_viscous_stress(&law, h, rate, p);
        const double power = ss_tissue_dissipation(&law, h, rate);
        near_to(contract(p, rate), power, 1e-12, "power", kind);
        assert_true(power > 0.0);
        /* confined: P = (phi + 2 psi) s^2 sdot */
        const double s = kind == SS_TISSUE_LINEAR ? 1.0 : 1.3;
        const double stretched[9] = {0.3}, along_x[9] = {0.5};
        ss_tissue_viscous_stress(&law, stretched, along_x, p);
        near_to(p[0], (0.3 + 1.4) * s * s * 0.5, 1e-12, "confined rate", kind);
    }
}

TEST(lame_constants_are_those_of_the_books)
{
    double lambda, mu;
    ss_tissue_lame(3000.0, 0.45, &lambda, &mu);
    assert_true(fabs(mu - 1034.4827586206898) < 1e-9);
    assert_true(fabs(lambda - 9310.344827586209) < 1e-8);
}

TEST(gradients_are_exact_for_affine_fields)
{
    const double x[4][3] = {{0.1, 0.2, -0.1}, {1.1, 0.1, 0}, {0.2, 1.3, 0.1}, {0, 0.1, 0.9}};
    double g[4][3], h[9] = {0.0}, a[9];
    random_matrix(1.0, a);
    const double volume = ss_tetrahedron_gradients(x[0], x[1], x[2], x[3], g);
    for (int n = 0; n < 4; ++n) {
        for (int i = 0; i < 3; ++i) {
            const double u = ss_dot3(a + 3 * i, x[n]) + 0.3;
            for (int j = 0; j < 3; ++j) {
                h[3 * i + j] += u * g[n][j];
            }
        }
    }
    for (int k = 0; k < 9; ++k) {
        assert_true(fabs(h[k] - a[k]) < 1e-14);
    }
    assert_true(volume > 0.0);
    assert_true(fabs(ss_tetrahedron_gradients(x[1], x[0], x[2], x[3], g) + volume) < 1e-15);
    const double unit[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    assert_true(fabs(ss_tetrahedron_gradients(unit[0], unit[1], unit[2], unit[3], g) - 1.0 / 6.0) <
                1e-16);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
