/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Ten-node tetrahedra against shape functions written out, and what must hold of them anywhere. */
#include "common/test.h"

#include "common/paths_fixture.h"
#include "oracles/quadratic_static.h"
#include "quadratic_fixture.h"
#include "rt/each.h"

static const block_size small = {.cells = {2, 2, 2}, .size = {0.03, 0.02, 0.03}, .jitter = 0.2};

/* ---- an element by the book, in double ---- */

static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/* Derivatives of the ten shape functions by the first three barycentric coordinates after l_0. */
static void book_derivatives(const double l[4], double out[10][3])
{
    const double dl[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int s = 0; s < 3; ++s) {
        for (int k = 0; k < 4; ++k) {
            out[k][s] = (4.0 * l[k] - 1.0) * dl[k][s];
        }
        for (int m = 0; m < 6; ++m) {
            const int a = ends[m][0], b = ends[m][1];
            out[4 + m][s] = 4.0 * (l[a] * dl[b][s] + l[b] * dl[a][s]);
        }
    }
}

/* Gradients at Gauss point q; returns what it stands for of the volume. */
static double book_gradients(const open_body *b, int32_t e, int q, double g[10][3])
{
    double l[4], d[10][3], jac[3][3] = {{0.0}}, inverse[3][3];
    for (int k = 0; k < 4; ++k) {
        l[k] = k == q ? (5.0 + 3.0 * sqrt(5.0)) / 20.0 : (5.0 - sqrt(5.0)) / 20.0;
    }
    book_derivatives(l, d);
    for (int n = 0; n < 10; ++n) {
        for (int k = 0; k < 9; ++k) {
            jac[k / 3][k % 3] += b->raised.mesh.position[b->raised.node[e][n]][k / 3] * d[n][k % 3];
        }
    }
    const double det = oracle_invert((const double(*)[3])jac, inverse);
    for (int n = 0; n < 10; ++n) {
        for (int j = 0; j < 3; ++j) {
            g[n][j] = 0.0;
            for (int s = 0; s < 3; ++s) {
                g[n][j] += d[n][s] * inverse[s][j];
            }
        }
    }
    return det / 24.0;
}

static void book_field(const open_body *b, int32_t e, const double g[10][3], const double *field,
                       double h[9])
{
    memset(h, 0, 9 * sizeof *h);
    for (int n = 0; n < 10; ++n) {
        for (int k = 0; k < 9; ++k) {
            h[k] += field[4 * (ptrdiff_t)b->raised.node[e][n] + k / 3] * g[n][k % 3];
        }
    }
}

/* What lambda resists. */
static double book_dilatation(ss_tissue_kind kind, const double h[9])
{
    const double t = h[0] + h[4] + h[8];
    double square = 0.0;
    for (int k = 0; k < 9; ++k) {
        square += h[k] * h[k];
    }
    return kind == SS_TISSUE_NEO_HOOKEAN || kind == SS_TISSUE_STABLE_NEO_HOOKEAN
               ? ss_tissue_volume_change(h)
           : kind == SS_TISSUE_LINEAR ? t
                                      : t + 0.5 * square;
}

static double book_energy(const open_body *b, const double *u)
{
    double sum = 0.0;
    for (int32_t e = 0; e < b->raised.mesh.tetrahedron_count; ++e) {
        const ss_tissue_law law = {
            .kind = b->material.kind, .lambda = b->material.lambda_own[e], .mu = b->material.mu[e]};
        const ss_tissue_law whole = {
            .kind = b->material.kind, .lambda = b->material.lambda[e], .mu = b->material.mu[e]};
        double volume = 0.0, mean = 0.0;
        for (int q = 0; q < 4; ++q) {
            double g[10][3], h[9];
            const double part = book_gradients(b, e, q, g);
            book_field(b, e, (const double(*)[3])g, u, h);
            volume += part;
            mean += part * book_dilatation(law.kind, h);
            sum += part * ss_tissue_energy(&law, h);
            /* Neo-Hookean's factor is held below 0.3: a line there, in place of J^(-2/3). */
            const double j = 1.0 + ss_tissue_volume_change(h);
            if (law.kind == SS_TISSUE_NEO_HOOKEAN && j < 0.3) {
                const double line =
                    pow(0.3, -2.0 / 3.0) - 2.0 / 3.0 * pow(0.3, -5.0 / 3.0) * (j - 0.3);
                double first = 3.0 + 2.0 * (h[0] + h[4] + h[8]);
                for (int k = 0; k < 9; ++k) {
                    first += h[k] * h[k];
                }
                assert_true(j > 0.2);
                sum += part * 0.5 * law.mu * first * (line - pow(j, -2.0 / 3.0));
            }
            /* The guard's modulus is that of the whole law. */
            const double short_of = SS_TISSUE_GUARD - 1.0 - ss_tissue_volume_change(h);
            if (law.kind == SS_TISSUE_STVK_GUARDED && short_of > 0.0) {
                sum += part * 0.5 * (whole.lambda - law.lambda) * short_of * short_of;
            }
        }
        sum += 0.5 * (b->material.lambda[e] - b->material.lambda_own[e]) * mean * mean / volume;
    }
    return sum;
}

static double book_power(const open_body *b, const double *u, const double *v)
{
    double sum = 0.0;
    for (int32_t e = 0; e < b->raised.mesh.tetrahedron_count; ++e) {
        const ss_tissue_law law = {
            .kind = b->material.kind, .phi = b->material.phi[e], .psi = b->material.psi[e]};
        for (int q = 0; q < 4; ++q) {
            double g[10][3], h[9], rate[9];
            const double part = book_gradients(b, e, q, g);
            book_field(b, e, (const double(*)[3])g, u, h);
            book_field(b, e, (const double(*)[3])g, v, rate);
            sum += part * ss_tissue_dissipation(&law, h, rate);
        }
    }
    return sum;
}

/* ---- fields ---- */

static double *doubles(int32_t nodes, const ss_real *a, double s, const ss_real *x)
{
    double *out = calloc(4 * (size_t)nodes, sizeof *out);
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes; ++k) {
        out[k] = (double)a[k] + s * (double)x[k];
    }
    return out;
}

static double dot(int32_t nodes, const ss_real *a, const ss_real *b)
{
    double sum = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes; ++k) {
        sum += (double)a[k] * (double)b[k];
    }
    return sum;
}

static double length(int32_t nodes, const ss_real *a)
{
    return sqrt(dot(nodes, a, a));
}

/* dW(u + s x)/ds, of fourth order. */
static double book_slope(const open_body *b, const ss_real *u, const ss_real *x, double s)
{
    static const double place[4] = {-2.0, -1.0, 1.0, 2.0};
    static const double weight[4] = {1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0};
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        double *at = doubles(b->raised.mesh.node_count, u, place[k] * s, x);
        sum += weight[k] * book_energy(b, at) / s;
        free(at);
    }
    return sum;
}

/* ---- claims ---- */

/* Every law and path, straight and curved, as it is and squeezed so that guard and floor act. */
TEST(forces_are_the_slopes_of_the_energy)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int turn = 0; turn < 4; ++turn) {
            open_body b;
            open_init(&b, make_block(&small), kind, 0.45, turn % 2 ? 4e-4 : 0.0);
            const int32_t n = b.raised.mesh.node_count;
            ss_real *u = random_quads(n, 3e-4), *x = random_quads(n, 1e-3);
            ss_real *v = random_quads(n, 1.0), *force = quads(n);
            for (int32_t i = 0; turn >= 2 && i < n; ++i) {
                u[4 * (ptrdiff_t)i] -= (ss_real)(0.6 * b.raised.mesh.position[i][0]);
            }
            double *exact = doubles(n, u, 0.0, u), *speed = doubles(n, v, 0.0, v);
            const double energy = book_energy(&b, exact), power = book_power(&b, exact, speed);
            const double slope = book_slope(&b, u, x, 1e-4);
            path_results results = {NULL, NULL};
            for (int path = 0; ss_quadratic_kernels_path(path); ++path) {
                ss_quadratic_pass pass = {.blocks = &b.own.blocks,
                                          .kind = b.material.kind,
                                          .u = u,
                                          .out = force,
                                          .wants_energy = true};
                memset(force, 0, 4 * (size_t)n * sizeof *force);
                ss_quadratic_kernels_path(path)->force(&pass);
                assert_near(pass.energy, energy, BY_TYPE(1e-5, 1e-12) * energy);
                assert_near(-dot(n, force, x), slope,
                            BY_TYPE(3e-5, 1e-8) * length(n, force) * length(n, x));
                pass.v = v;
                pass.power = 0.0;
                memset(force, 0, 4 * (size_t)n * sizeof *force);
                ss_quadratic_kernels_path(path)->force(&pass);
                assert_near(pass.power, power, BY_TYPE(1e-5, 1e-12) * power);
                path_results_take(&results, ss_quadratic_kernels_path(path)->name, n, force);
            }
            path_results_fini(&results);
            free(exact);
            free(speed);
            SS_EACH(ss_memory_free, u, x, v, force);
            open_fini(&b);
        }
    }
}

TEST(the_viscous_force_takes_the_power)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        open_body b;
        open_init(&b, make_block(&small), kind, 0.3, 3e-4);
        const int32_t n = b.raised.mesh.node_count;
        ss_real *u = random_quads(n, 3e-4), *v = random_quads(n, 1.0);
        ss_real *with = quads(n), *without = quads(n);
        ss_quadratic_pass pass = {
            .blocks = &b.own.blocks, .kind = b.material.kind, .u = u, .out = without};
        b.own.kernels->force(&pass);
        pass.v = v;
        pass.out = with;
        b.own.kernels->force(&pass);
        assert_near(dot(n, without, v) - dot(n, with, v), pass.power,
                    BY_TYPE(1e-4, 1e-10) * pass.power);
        SS_EACH(ss_memory_free, u, v, with, without);
        open_fini(&b);
    }
}

TEST(the_tangent_is_the_slope_of_the_forces)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int turn = 0; turn < 2; ++turn) {
            open_body b;
            open_init(&b, make_block(&small), kind, 0.45, turn ? 4e-4 : 0.0);
            const int32_t n = b.raised.mesh.node_count;
            ss_real *u = random_quads(n, 3e-4), *x = random_quads(n, 1.0);
            ss_real *y = random_quads(n, 1.0), *tangent = quads(n),
                    *force[2] = {quads(n), quads(n)};
            const double s = BY_TYPE(2e-5, 1e-7);
            ss_quadratic_pass pass = {
                .blocks = &b.own.blocks, .kind = b.material.kind, .u = u, .x = x, .out = tangent};
            b.own.kernels->tangent(&pass);
            const double forth = dot(n, tangent, y), size = length(n, tangent) * length(n, y);
            for (int k = 0; k < 2; ++k) {
                ss_real *moved_u = quads(n);
                for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)n; ++at) {
                    moved_u[at] = (ss_real)((double)u[at] + (k ? s : -s) * (double)x[at]);
                }
                pass.u = moved_u;
                pass.out = force[k];
                b.own.kernels->force(&pass);
                ss_memory_free(moved_u);
            }
            assert_near((dot(n, force[0], y) - dot(n, force[1], y)) / (2.0 * s), forth,
                        BY_TYPE(2e-3, 1e-6) * size);
            pass.u = u;
            pass.x = y;
            memset(tangent, 0, 4 * (size_t)n * sizeof *tangent);
            pass.out = tangent;
            b.own.kernels->tangent(&pass);
            assert_near(dot(n, tangent, x), forth, BY_TYPE(1e-5, 1e-12) * size);
            SS_EACH(ss_memory_free, u, x, y, tangent, force[0], force[1]);
            open_fini(&b);
        }
    }
}

/* An affine motion leaves inner nodes without force, and all of it adds up to nothing. */
TEST(passes_the_patch_test_straight_and_curved)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int turn = 0; turn < 2; ++turn) {
            open_body b;
            open_init(&b, make_block(&small), kind, 0.49, turn ? 4e-4 : 0.0);
            assert_int_equal(b.own.blocks.straight_count > 0, turn == 0);
            const int32_t n = b.raised.mesh.node_count;
            ss_real *u = quads(n), *force = quads(n);
            uint8_t *is_outer = calloc((size_t)n, 1);
            double largest = 0.0, inner = 0.0, sum[3] = {0.0}, size = 0.0;
            const double a[9] = {0.1, 0.05, -0.02, 0.0, -0.08, 0.06, 0.03, 0.02, 0.07};
            for (int32_t i = 0; i < n; ++i) {
                for (int k = 0; k < 3; ++k) {
                    u[4 * (ptrdiff_t)i + k] =
                        (ss_real)ss_dot3(a + 3 * k, b.raised.mesh.position[i]);
                }
            }
            for (int32_t t = 0; t < b.raised.mesh.triangle_count; ++t) {
                for (int k = 0; k < 3; ++k) {
                    is_outer[b.raised.mesh.triangle[t][k]] = 1;
                }
            }
            ss_quadratic_pass pass = {
                .blocks = &b.own.blocks, .kind = b.material.kind, .u = u, .out = force};
            b.own.kernels->force(&pass);
            for (int32_t i = 0; i < n; ++i) {
                for (int k = 0; k < 3; ++k) {
                    const double f = (double)force[4 * (ptrdiff_t)i + k];
                    largest = fmax(largest, fabs(f));
                    inner = is_outer[i] ? inner : fmax(inner, fabs(f));
                    sum[k] += f;
                    size += fabs(f);
                }
            }
            assert_true(inner <= BY_TYPE(2e-5, 1e-12) * largest);
            for (int k = 0; k < 3; ++k) {
                assert_near(sum[k], 0.0, BY_TYPE(1e-6, 1e-14) * size);
            }
            free(is_outer);
            SS_EACH(ss_memory_free, u, force);
            open_fini(&b);
        }
    }
}

/* The lumped mass is the body's, and no motion of it is faster than the fastest element. */
TEST(masses_add_up_and_elements_bound_the_rate)
{
    open_body b;
    open_init(&b, make_block(&small), SS_TISSUE_NEO_HOOKEAN, 0.49, 0.0);
    double sum = 0.0;
    for (int32_t i = 0; i < b.raised.mesh.node_count; ++i) {
        sum += b.own.masses.mass[i];
    }
    assert_near(sum, 1000.0 * 0.03 * 0.02 * 0.03, 1e-12);
    assert_true(b.own.stability.rest_rate2 <= b.own.masses.bound);
    assert_true(b.own.stability.rest_rate2 > 0.5 * b.own.masses.bound);
    ss_quadratic_masses scaled;
    assert_int_equal(
        ss_quadratic_masses_create(&b.raised, &b.material, 0.02, &b.own.blocks, &b.arena, &scaled),
        SOFTSIM_OK);
    double more = 0.0;
    for (int32_t i = 0; i < b.raised.mesh.node_count; ++i) {
        more += scaled.mass[i];
    }
    assert_near(more / sum - 1.0, scaled.added_share, 1e-9);
    assert_true(scaled.added_share <= 0.02 && scaled.added_share > 0.019);
    assert_true(scaled.bound < b.own.masses.bound && scaled.scaled_count > 0);
    open_fini(&b);
}

/* omega_max^2 at u, from below: power iteration from a random start. */
static double fastest_rate2(const open_body *b, const ss_real *u)
{
    const int32_t n = b->raised.mesh.node_count;
    ss_real *x = random_quads(n, 1.0), *y = quads(n);
    double rate2 = 0.0;
    for (int turn = 0; turn < 4000; ++turn) {
        ss_quadratic_pass pass = {
            .blocks = &b->own.blocks, .kind = b->material.kind, .u = u, .x = x, .out = y};
        double along = 0.0, square = 0.0;
        memset(y, 0, 4 * (size_t)n * sizeof *y);
        b->own.kernels->tangent(&pass);
        for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)n; ++k) {
            const double mass = b->own.masses.mass[k / 4];
            along += (double)x[k] * (double)y[k];
            square += mass * (double)x[k] * (double)x[k];
            y[k] = (ss_real)((double)y[k] / mass);
        }
        rate2 = along / square;
        const double size = length(n, y);
        for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)n; ++k) {
            x[k] = (ss_real)((double)y[k] / size);
        }
    }
    SS_EACH(ss_memory_free, x, y);
    return rate2;
}

/* A body that is fastest at one end, at rest, is squeezed at the other, as a tool would do it. */
TEST(the_step_is_stable_where_elements_are_squeezed_far_from_the_fastest)
{
    static const block_size bar = {.cells = {16, 2, 2}, .size = {0.16, 0.02, 0.02}, .jitter = 0.1};
    open_body b;
    ss_mesh *mesh = make_block(&bar);
    for (int32_t i = 0; i < mesh->node_count; ++i) { /* thinner towards x = 0 */
        mesh->position[i][0] *= mesh->position[i][0] < 0.0101 ? 0.8 : 1.0;
    }
    open_init(&b, mesh, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0);
    const int32_t n = b.raised.mesh.node_count;
    ss_real *u = quads(n), *force = quads(n);
    const double rest = fastest_rate2(&b, u);
    b.own.viscous_time = 0.0;
    for (int turn = 1; turn <= 40; ++turn) {
        for (int32_t i = 0; i < n; ++i) {
            const double *x = b.raised.mesh.position[i];
            u[4 * (ptrdiff_t)i + 1] =
                (ss_real)(x[0] > 0.145 ? -0.6 * fmin(1.0, turn / 20.0) * x[1] : 0.0);
        }
        ss_body_energy energy = {.is_wanted = false};
        ss_quadratic_force(&b.own, u, NULL, force, &energy);
        (void)ss_quadratic_stable_step(&b.own, NULL);
    }
    const double now = fastest_rate2(&b, u);
    const double step = SS_QUADRATIC_STEP_SHARE * ss_quadratic_stable_step(&b.own, NULL);
    assert_true(now > 2.0 * rest);
    assert_true(step < 2.0 / sqrt(now));
    assert_true(step > 0.5 * 2.0 / sqrt(now));
    SS_EACH(ss_memory_free, u, force);
    open_fini(&b);
}

/* Next to no viscosity takes next to nothing of the step. */
TEST(the_step_is_continuous_where_viscosity_ends)
{
    double step[2];
    for (int is_viscous = 0; is_viscous < 2; ++is_viscous) {
        setup s;
        random_state = 5;
        setup_init(&s, "fem-quadratic", make_block(&small));
        give(&s, "material", SS_TISSUE_NEO_HOOKEAN);
        give(&s, "youngs_modulus_pa", 1e4);
        give(&s, "poisson_ratio", 0.45);
        if (is_viscous) {
            give(&s, "viscosity_phi_pa_s", 1e-30);
        }
        memset(s.fixed, 7, (size_t)s.mesh->node_count / 2);
        create(&s);
        steps(&s, 40, 1e-3);
        step[is_viscous] = info_of(&s).stable_step;
        setup_fini(&s);
    }
    assert_near(step[1], step[0], 1e-9 * step[0]);
}

/* The mass that was added has no weight: supports carry the body's alone. */
TEST(supports_carry_the_weight_of_the_body)
{
    setup s;
    double reaction[3];
    setup_init(&s, "fem-quadratic", make_block(&small));
    give(&s, "youngs_modulus_pa", 1e4);
    give(&s, "poisson_ratio", 0.45);
    give(&s, "mass_damping_per_s", 100.0);
    give(&s, "mass_scaling_max", 0.1);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < 1e-9 ? 7 : 0;
    }
    s.plan.gravity[2] = -10.0;
    create(&s);
    steps(&s, 600, 1e-3);
    s.class->reaction(s.model, -1, reaction);
    assert_near(reaction[2], 10.0 * 1000.0 * 0.03 * 0.02 * 0.03, 2e-4 * 0.18);
    setup_fini(&s);
}

/* Stretched, let go and left to swing: energy is neither made nor lost. */
TEST(swings_without_gain_or_loss)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        setup s;
        setup_init(&s, "fem-quadratic", make_block(&small));
        give(&s, "youngs_modulus_pa", 1e4);
        give(&s, "poisson_ratio", 0.45);
        give(&s, "material", kind);
        int32_t top[9], count = 0;
        for (int32_t i = 0; i < 27; ++i) {
            s.fixed[i] = s.mesh->position[i][2] < 1e-9 ? 7 : 0;
            if (s.mesh->position[i][2] > 0.03 - 1e-9) {
                top[count++] = i;
            }
        }
        s.load[0] =
            (ss_load){.node = top, .node_count = count, .force = {0.0, 0.0, -0.2}, .to = 0.05};
        s.plan.load_count = 1;
        create(&s);
        steps(&s, 50, 1e-3);
        const double energy = info_of(&s).elastic + info_of(&s).kinetic;
        assert_true(energy > 0.0);
        steps(&s, 500, 1e-3);
        assert_near(info_of(&s).elastic + info_of(&s).kinetic, energy, 0.02 * energy);
        assert_true(fabs(energy_gain(&s)) < 0.02 * energy);
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        setup_fini(&s);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
