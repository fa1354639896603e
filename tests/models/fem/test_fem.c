/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Forces of tetrahedra against the laws, and what must hold of them on any mesh. */
#include "common/test.h"

#include "common/paths_fixture.h"
#include "fem_fixture.h"

static const block_size small = {.cells = {3, 2, 3}, .size = {0.03, 0.02, 0.03}, .jitter = 0.2};

static void block_setup(setup *s, const block_size *size, int kind, double ratio)
{
    setup_fem(s, make_block(size));
    give_row(s, SS_FEM_MATERIAL, kind);
    give_row(s, SS_FEM_POISSON_RATIO, ratio);
}

/* ---- kernels against the laws ---- */

/* H of element e. */
static void element_gradient(const setup *s, int32_t e, const ss_real *field, double h[9],
                             double g[4][3], double *volume)
{
    const int32_t *c = s->mesh->tetrahedron[e];
    const double(*x)[3] = (const double(*)[3])s->mesh->position;
    *volume = ss_tetrahedron_gradients(x[c[0]], x[c[1]], x[c[2]], x[c[3]], g);
    memset(h, 0, 9 * sizeof *h);
    for (int a = 0; a < 4; ++a) {
        for (int k = 0; k < 9; ++k) {
            h[k] += (double)field[4 * (ptrdiff_t)c[a] + k / 3] * g[a][k % 3];
        }
    }
}

static void add_forces(const setup *s, int32_t e, const double p[9], const double g[4][3],
                       double factor, double *out)
{
    for (int a = 0; a < 4; ++a) {
        for (int i = 0; i < 3; ++i) {
            out[4 * (ptrdiff_t)s->mesh->tetrahedron[e][a] + i] += factor * ss_dot3(p + 3 * i, g[a]);
        }
    }
}

typedef struct expectation {
    double *force, *tangent;
    double energy, power;
} expectation;

/* All of it in double, element by element. */
static expectation expect(const setup *s, const ss_real *u, const ss_real *v, const ss_real *x)
{
    const size_t n = (size_t)s->mesh->node_count * 4;
    expectation out = {.force = calloc(n, sizeof(double)), .tangent = calloc(n, sizeof(double))};
    for (int32_t e = 0; e < s->mesh->tetrahedron_count; ++e) {
        const ss_tissue_law law = {.kind = s->model->material.kind,
                                   .lambda = s->model->material.lambda[e],
                                   .mu = s->model->material.mu[e],
                                   .phi = s->model->material.phi[e],
                                   .psi = s->model->material.psi[e]};
        double h[9], rate[9], dh[9], p[9], pv[9], g[4][3], volume;
        element_gradient(s, e, u, h, g, &volume);
        element_gradient(s, e, v, rate, g, &volume);
        element_gradient(s, e, x, dh, g, &volume);
        ss_tissue_stress(&law, h, p);
        ss_tissue_viscous_stress(&law, h, rate, pv);
        add_forces(s, e, p, (const double(*)[3])g, -volume, out.force);
        add_forces(s, e, pv, (const double(*)[3])g, -volume, out.force);
        ss_tissue_tangent(&law, h, dh, p);
        add_forces(s, e, p, (const double(*)[3])g, volume, out.tangent);
        out.energy += volume * ss_tissue_energy(&law, h);
        out.power += volume * ss_tissue_dissipation(&law, h, rate);
    }
    return out;
}

static void near_field(const ss_real *field, const double *expected, int32_t nodes,
                       double tolerance, const char *what)
{
    double largest = 0.0, error = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes; ++k) {
        largest = fmax(largest, fabs(expected[k]));
        error = fmax(error, fabs((double)field[k] - expected[k]));
    }
    if (!(error <= tolerance * largest)) {
        fail_msg("%s: off by %.3g of %.3g", what, error, largest);
    }
}

/* Random, and squeezed so that the guard and the floor act. */
TEST(kernels_compute_the_laws)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int squeeze = 0; squeeze < 2; ++squeeze) {
            setup s;
            block_setup(&s, &small, kind, 0.3);
            give_row(&s, SS_FEM_PHI, 3.0);
            give_row(&s, SS_FEM_PSI, 5.0);
            open_elastic(&s);
            const int32_t n = s.mesh->node_count;
            ss_real *u = random_quads(n, 1e-3), *v = random_quads(n, 1.0);
            ss_real *x = random_quads(n, 1.0), *force = quads(n), *tangent = quads(n);
            for (int32_t i = 0; squeeze && i < n; ++i) {
                u[4 * (ptrdiff_t)i] -= (ss_real)(1.1 * s.mesh->position[i][0]);
                u[4 * (ptrdiff_t)i + 1] += (ss_real)(0.2 * s.mesh->position[i][1]);
            }
            expectation want = expect(&s, u, v, x);
            path_results results = {NULL, NULL};
            for (int path = 0; ss_fem_kernels_path(path); ++path) {
                const ss_fem_kernels *kernels = ss_fem_kernels_path(path);
                ss_fem_pass pass = {.blocks = &s.model->fem->blocks,
                                    .kind = s.model->material.kind,
                                    .u = u,
                                    .v = v,
                                    .x = x,
                                    .out = force,
                                    .wants_energy = true};
                memset(force, 0, (size_t)n * 4 * sizeof *force);
                memset(tangent, 0, (size_t)n * 4 * sizeof *tangent);
                kernels->force(&pass);
                near_field(force, want.force, n, BY_TYPE(3e-5, 1e-12), "force");
                assert_near(pass.energy, want.energy, BY_TYPE(1e-5, 1e-12) * want.energy);
                assert_near(pass.power, want.power, BY_TYPE(1e-5, 1e-12) * want.power);
                pass.out = tangent;
                kernels->tangent(&pass);
                near_field(tangent, want.tangent, n, BY_TYPE(1e-4, 1e-11), "tangent");
                path_results_take(&results, kernels->name, n, force);
            }
            path_results_fini(&results);
            free(want.force);
            free(want.tangent);
            ss_real *const owned[] = {u, v, x, force, tangent};
            for (int k = 0; k < 5; ++k) {
                ss_memory_free(owned[k]);
            }
            setup_fini(&s);
        }
    }
}

static double energy_at(setup *s, const ss_real *u, ss_real *force)
{
    ss_body_energy energy = {.is_wanted = true};
    memset(force, 0, (size_t)s->mesh->node_count * 4 * sizeof *force);
    ss_fem_force(s->model->fem, u, u, force, &energy);
    return energy.elastic;
}

/* With the cure too: force is minus the slope of the energy, and the tangent the slope of force. */
TEST(forces_and_tangents_are_slopes)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int cure = 1; cure <= 2; ++cure) {
            setup s;
            block_setup(&s, &small, kind, 0.48);
            give_row(&s, SS_FEM_LOCKING_CURE, cure);
            open_elastic(&s);
            const int32_t n = s.mesh->node_count;
            const double step = BY_TYPE(2e-2, 1e-4);
            ss_real *u = random_quads(n, 1e-3), *x = random_quads(n, 1e-3);
            ss_real *force = quads(n), *low = quads(n), *high = quads(n), *at = quads(n);
            double energy[2];
            for (int side = 0; side < 2; ++side) {
                for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)n; ++k) {
                    at[k] = u[k] + (ss_real)(side == 0 ? -step : step) * x[k];
                }
                energy[side] = energy_at(&s, at, side == 0 ? low : high);
            }
            const double stored = energy_at(&s, u, force);
            const double slope = (energy[1] - energy[0]) / (2.0 * step);
            assert_near(-dot_quads(n, force, x), slope,
                        BY_TYPE(2e-3, 1e-7) * (stored + fabs(slope)));
            memset(at, 0, (size_t)n * 4 * sizeof *at);
            ss_fem_tangent(s.model->fem, x, at);
            double *expected = calloc((size_t)n * 4, sizeof *expected);
            for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)n; ++k) {
                expected[k] = ((double)low[k] - (double)high[k]) / (2.0 * step);
            }
            near_field(at, expected, n, BY_TYPE(3e-3, 1e-6), "tangent");
            free(expected);
            ss_real *const owned[] = {u, x, force, low, high, at};
            for (int k = 0; k < 6; ++k) {
                ss_memory_free(owned[k]);
            }
            setup_fini(&s);
        }
    }
}

/* ---- patch, rigid motion, offset ---- */

TEST(affine_motion_leaves_no_force_inside)
{
    for (int kind = 0; kind < SS_TISSUE_KIND_COUNT; ++kind) {
        for (int cure = 1; cure <= 2; ++cure) {
            setup s;
            const block_size size = {.cells = {4, 4, 4}, .size = {0.04, 0.04, 0.04}, .jitter = 0.2};
            block_setup(&s, &size, kind, 0.45);
            give_row(&s, SS_FEM_LOCKING_CURE, cure);
            open_elastic(&s);
            const int32_t n = s.mesh->node_count;
            ss_real *u = quads(n), *force = quads(n);
            double a[9];
            for (int k = 0; k < 9; ++k) {
                a[k] = 0.15 * random_unit();
            }
            for (int32_t i = 0; i < n; ++i) {
                for (int k = 0; k < 3; ++k) {
                    u[4 * (ptrdiff_t)i + k] = (ss_real)ss_dot3(a + 3 * k, s.mesh->position[i]);
                }
            }
            (void)energy_at(&s, u, force);
            const double largest = largest_quad(n, force);
            for (int k = 1; k < 4; ++k) {
                for (int j = 1; j < 4; ++j) {
                    for (int i = 1; i < 4; ++i) {
                        const ss_real *f = force + 4 * (ptrdiff_t)block_node(&size, i, j, k);
                        for (int c = 0; c < 3; ++c) {
                            assert_near(f[c], 0.0, BY_TYPE(2e-5, 1e-13) * largest);
                        }
                    }
                }
            }
            ss_memory_free(u);
            ss_memory_free(force);
            setup_fini(&s);
        }
    }
}

/* Largest force of a body that is turned by `angle`, over that at 1 % strain. */
static double turned_force(int kind, double offset, double angle)
{
    setup s;
    block_size size = small;
    size.offset = offset;
    block_setup(&s, &size, kind, 0.3);
    open_elastic(&s);
    const int32_t n = s.mesh->node_count;
    ss_real *u = quads(n), *force = quads(n);
    double largest[2];
    for (int part = 0; part < 2; ++part) {
        for (int32_t i = 0; i < n; ++i) {
            double d[3];
            for (int k = 0; k < 3; ++k) {
                d[k] = s.mesh->position[i][k] - offset;
            }
            ss_real *at = u + 4 * (ptrdiff_t)i;
            at[0] = (ss_real)(part ? 0.01 * d[0]
                                   : (cos(angle) - 1.0) * d[0] - sin(angle) * d[1] + 0.01);
            at[1] = (ss_real)(part ? 0.0 : sin(angle) * d[0] + (cos(angle) - 1.0) * d[1]);
        }
        (void)energy_at(&s, u, force);
        largest[part] = largest_quad(n, force);
    }
    ss_memory_free(u);
    ss_memory_free(force);
    setup_fini(&s);
    return largest[0] / largest[1];
}

TEST(rigid_motion_needs_no_force)
{
    for (int kind = 0; kind < SS_TISSUE_LINEAR; ++kind) {
        assert_true(turned_force(kind, 0.0, 0.8) < BY_TYPE(4e-4, 1e-11));
        /* no worse in a world a kilometre away */
        assert_true(turned_force(kind, 1000.0, 0.8) < BY_TYPE(4e-4, 1e-9));
    }
}

/* A tip load's answer, with the block anywhere, turned about, its numbers shuffled. */
static double tip_answer(double offset, bool is_turned, bool is_shuffled)
{
    setup s;
    const block_size size = {
        .cells = {6, 2, 2}, .size = {0.06, 0.02, 0.02}, .jitter = 0.0, .offset = 0.0};
    setup_fem(&s, make_block(&size));
    give_row(&s, SS_FEM_MASS_DAMPING, 40.0);
    int32_t tip = block_node(&size, 6, 1, 1);
    fix_low(&s, 0);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        double *x = s.mesh->position[i];
        if (is_turned) { /* x y z -> z x y */
            ss_set3(x, x[2], x[0], x[1]);
        }
        for (int k = 0; k < 3; ++k) {
            x[k] += offset;
        }
    }
    if (is_shuffled) {
        assert_true(ss_mesh_renumber(s.mesh));
        uint8_t *fixed = calloc((size_t)s.mesh->node_count, 1);
        int32_t now = tip;
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            fixed[i] = s.fixed[ss_mesh_file_node(s.mesh, i)];
            now = ss_mesh_file_node(s.mesh, i) == tip ? i : now;
        }
        tip = now;
        free(s.fixed);
        s.fixed = fixed;
        s.plan.fixed = fixed;
    }
    s.load[0] = (ss_load){.node = &tip, .node_count = 1, .to = (double)INFINITY};
    s.load[0].force[is_turned ? 0 : 2] = -0.02;
    s.plan.load_count = 1;
    create(&s);
    steps(&s, 300, 1e-3);
    const double answer = moved(&s, tip, is_turned ? 0 : 2);
    setup_fini(&s);
    return answer;
}

TEST(place_axes_and_numbers_change_nothing)
{
    const double answer = tip_answer(0.0, false, false);
    assert_true(answer < -1e-3);
    assert_near(tip_answer(1000.0, false, false), answer, BY_TYPE(1e-3, 1e-6) * fabs(answer));
    assert_near(tip_answer(0.0, true, false), answer, BY_TYPE(1e-3, 1e-10) * fabs(answer));
    assert_near(tip_answer(0.0, false, true), answer, BY_TYPE(1e-3, 1e-10) * fabs(answer));
}

/* ---- conservation ---- */

/* Over some steps: that of one step trembles with where in its oscillations the body is. */
static double mean_energy(setup *s, int count)
{
    double sum = 0.0;
    for (int k = 0; k < count; ++k) {
        steps(s, 1, 5e-4);
        sum += info_of(s).kinetic + info_of(s).elastic;
    }
    return sum / count;
}

/* Free in space, random velocities, 3 % strain or so. */
TEST(momentum_and_energy_last)
{
    setup s;
    block_setup(&s, &small, SS_TISSUE_STVK_GUARDED, 0.3);
    open_up(&s);
    const int32_t n = s.mesh->node_count;
    for (int32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            s.model->nodes->v[4 * (ptrdiff_t)i + k] = (ss_real)(0.05 * random_unit());
        }
    }
    ss_body_renew(s.model->body);
    double before[6] = {0.0}, after[6] = {0.0}, start = 0.0, end = 0.0;
    for (int turn = 0; turn < 2; ++turn) {
        double *sum = turn == 0 ? before : after;
        for (int32_t i = 0; i < n; ++i) {
            double x[3], v[3], moment[3];
            for (int k = 0; k < 3; ++k) {
                x[k] = s.mesh->position[i][k] + moved(&s, i, k);
                v[k] = (double)s.model->nodes->v[4 * (ptrdiff_t)i + k] * s.model->mass[i];
                sum[k] += v[k];
            }
            ss_cross3(moment, x, v);
            ss_add3(sum + 3, sum + 3, moment);
        }
        if (turn == 0) {
            start = mean_energy(&s, 100);
            steps(&s, 2800, 5e-4);
            end = mean_energy(&s, 100);
        }
    }
    const ss_model_info info = info_of(&s);
    const double mass = 0.03 * 0.02 * 0.03 * 1000.0;
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_GOOD);
    assert_near(end, start, 0.01 * start);
    for (int k = 0; k < 3; ++k) {
        assert_near(after[k], before[k], BY_TYPE(1e-5, 1e-12) * mass * 0.05);
        assert_near(after[3 + k], before[3 + k], BY_TYPE(1e-2, 1e-3) * mass * 0.05 * 0.03);
    }
    setup_fini(&s);
}

/* ---- loads and materials ---- */

/* A bar of two moduli in a row: the same stress, strains as one to three. */
TEST(elements_have_their_own_material)
{
    setup s;
    setup_block(&s, (const int[3]){2, 1, 1}, (const double[3]){0.02, 0.01, 0.01}, 0.0);
    const int32_t n = s.mesh->node_count;
    double *young = calloc((size_t)n, sizeof *young);
    int32_t pulled[4], count = 0;
    fix_low(&s, 0);
    for (int32_t i = 0; i < n; ++i) {
        const double x = s.mesh->position[i][0];
        s.fixed[i] = x < 1e-9 ? 7 : 6; /* confined */
        young[i] = 1e4 * (1.0 + x / 0.01);
        if (x > 0.02 - 1e-9) {
            pulled[count++] = i;
        }
    }
    s.param[SS_FEM_YOUNGS_MODULUS] = (ss_param_value){.per_node = young, .is_given = true};
    give_row(&s, SS_FEM_POISSON_RATIO, 0.0);
    give_row(&s, SS_FEM_MASS_DAMPING, 60.0);
    give_row(&s, SS_FEM_MATERIAL, SS_TISSUE_LINEAR);
    s.load[0] = (ss_load){
        .node = pulled, .node_count = 4, .force = {0.01, 0.0, 0.0}, .to = (double)INFINITY};
    s.plan.load_count = 1;
    create(&s);
    steps(&s, 400, 1e-3);
    /* Elements of the first cell have mean moduli of 1.25 to 1.75 times 1e4, of the second of 2.25
     * to 2.75; each slice in parallel carries 100 Pa. */
    double first = 0.0, second = 0.0;
    for (int k = 0; k < 4; ++k) {
        first += 0.25 * moved(&s, pulled[k] - 1, 0) / 0.01;
        second += 0.25 * moved(&s, pulled[k], 0) / 0.01;
    }
    second -= first;
    assert_true(first > 100.0 / 1.75e4 && first < 100.0 / 1.25e4);
    assert_true(second > 100.0 / 2.75e4 && second < 100.0 / 2.25e4);
    double support[3];
    s.class->reaction(s.model, -1, support);
    assert_near(support[0], -0.01, 1e-5);
    free(young);
    setup_fini(&s);
}

/* Shear of a wide slab at given viscosity: the top moves at mu/psi's own time. */
TEST(viscosity_creeps_in_its_own_time)
{
    setup s;
    setup_block(&s, (const int[3]){1, 1, 2}, (const double[3]){0.01, 0.01, 0.02}, 0.0);
    give_row(&s, SS_FEM_POISSON_RATIO, 0.0);
    give_row(&s, SS_FEM_DENSITY, 50.0);
    give_row(&s, SS_FEM_STIFFNESS_DAMPING, 0.02);
    give_row(&s, SS_FEM_MATERIAL, SS_TISSUE_LINEAR);
    int32_t top[4], count = 0;
    fix_low(&s, 2);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < 1e-9 ? 7 : 6; /* x alone */
        if (s.mesh->position[i][2] > 0.02 - 1e-9) {
            top[count++] = i;
        }
    }
    /* a prescribed pull would hide it: a force */
    s.load[0] =
        (ss_load){.node = top, .node_count = 4, .force = {1e-3, 0.0, 0.0}, .to = (double)INFINITY};
    s.plan.load_count = 1;
    s.plan.max_substeps = 400;
    create(&s);
    steps(&s, 20, 1e-3);
    const double settled = 1e-3 / 1e-4 / 5e3 * 0.02; /* stress over mu, times height */
    double mean = 0.0;
    for (int k = 0; k < 4; ++k) {
        mean += 0.25 * moved(&s, top[k], 0);
    }
    assert_near(mean, settled * (1.0 - exp(-1.0)), 0.02 * settled);
    const ss_model_info info = info_of(&s);
    assert_near(info.elastic + info.kinetic + info.dissipated, info.work, 0.02 * info.work);
    setup_fini(&s);
}

/* ---- refusals ---- */

static void refuses(void (*spoil)(setup *s), const char *message)
{
    setup s;
    block_setup(&s, &small, SS_TISSUE_STVK, 0.3);
    spoil(&s);
    assert_int_not_equal(setup_create(&s), SOFTSIM_OK);
    if (!strstr(s.error.text, message)) {
        fail_msg("'%s' does not say '%s'", s.error.text, message);
    }
    setup_fini(&s);
}

static void without_ratio(setup *s)
{
    s->param[SS_FEM_POISSON_RATIO] = (ss_param_value){.number = (double)NAN};
}

static void with_both(setup *s)
{
    give_row(s, SS_FEM_LAMBDA, 1e3);
    give_row(s, SS_FEM_MU, 1e3);
}

static void with_unstable_moduli(setup *s)
{
    s->param[SS_FEM_POISSON_RATIO] = (ss_param_value){.number = (double)NAN};
    s->param[SS_FEM_YOUNGS_MODULUS] = (ss_param_value){.number = (double)NAN};
    give_row(s, SS_FEM_LAMBDA, -1e3);
    give_row(s, SS_FEM_MU, 1e3);
}

TEST(says_what_is_wrong_with_a_material)
{
    refuses(without_ratio, "give youngs_modulus_pa and poisson_ratio, or lame_lambda_pa");
    refuses(with_both, "these two together and no other");
    refuses(with_unstable_moduli, "moduli of 108 elements (first 0, 1, ");
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
