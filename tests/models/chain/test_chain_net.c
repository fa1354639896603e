/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The network of chain links: what it is made of, its pull, its energy, its steps. */
#include "common/test.h"

#include "common/chain_fixture.h"

/* The band's bounds as any reader of equation (5) would write them, in double. */
static double excess(const setup *s, int32_t e, const ss_real *u, double d[3])
{
    const ss_chain_net *net = s->model->net;
    const int32_t a = net->link[e][0], b = net->link[e][1];
    const ss_chain_group *group = &net->group[net->position[e] / SS_CHAIN_LANES];
    const double slack = (double)group->slack[net->position[e] % SS_CHAIN_LANES];
    double rest[3];
    ss_sub3(rest, s->mesh->position[b], s->mesh->position[a]);
    for (int k = 0; k < 3; ++k) {
        d[k] = rest[k] + (double)u[4 * (ptrdiff_t)b + k] - (double)u[4 * (ptrdiff_t)a + k];
    }
    const double now = ss_norm3(d), length = ss_norm3(rest);
    return fmax(now - length - slack, 0.0) - fmax(fmax(length - slack, 0.0) - now, 0.0);
}

/* W, and with `pull` dP, node by node over its links (Jacobi). */
static double reference(const setup *s, const ss_real *u, double (*pull)[3])
{
    const ss_chain_net *net = s->model->net;
    double energy = 0.0;
    for (int32_t e = 0; e < net->link_count; ++e) {
        double d[3];
        const double ex = excess(s, e, u, d);
        const double scale = 0.5 * ex / fmax(ss_norm3(d), 1e-300);
        energy += 0.25 * ex * ex;
        for (int k = 0; pull && k < 3; ++k) {
            pull[net->link[e][0]][k] += scale * d[k];
            pull[net->link[e][1]][k] -= scale * d[k];
        }
    }
    return energy;
}

static void shake(setup *s, double size)
{
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            s->model->u[4 * (ptrdiff_t)i + k] =
                (s->fixed[i] & (1 << k)) != 0 ? 0 : (ss_real)(size * random_unit());
        }
    }
}

/* ---- links ---- */

static ss_model *create_network(setup *s, ss_mesh *mesh, double alpha)
{
    setup_network(s, mesh, alpha);
    create(s);
    return s->model;
}

TEST(links_are_counted_once)
{
    setup s;
    create_network(&s, make_box(2, 2, 2, 1.0), 0.02);
    /* A cube of six tetrahedra: 12 edges, 6 face diagonals, one through the middle. */
    assert_int_equal(s.model->net->link_count, 19);
    assert_int_equal(s.model->net->duplicates, 36 - 19);
    setup_fini(&s);
    create_network(&s, make_plane(4), 0.02);
    assert_int_equal(s.model->net->link_count, 24); /* sides alone: no diagonals of quads */
    int32_t seen = 0;
    for (int32_t i = 0; i < 16; ++i) {
        for (int32_t p = s.model->net->first[i]; p < s.model->net->first[i + 1]; ++p) {
            const int32_t other = ss_chain_other(s.model->net, s.model->net->at[p], i);
            assert_true(abs(other - i) == 1 || abs(other - i) == 4);
            ++seen;
        }
    }
    assert_int_equal(seen, 48);
    setup_fini(&s);
}

TEST(alpha_is_taken_link_by_link)
{
    ss_param_link link[3] = {{{0, 1}, 0.5}, {{2, 0}, 0.0}, {{1, 2}, 0.0}};
    setup s;
    setup_network(&s, make_triangle(1.0), 0.0);
    s.param[row_of(&s, "alpha")] =
        (ss_param_value){.per_link = link, .link_count = 3, .is_given = true};
    create(&s);
    s.model->u[4] = (ss_real)0.4; /* within the slack of 0-1, and out of those of the others */
    double length[2] = {hypot(0.5, 1.0), hypot(0.9, 1.0)};
    const double ex = length[1] - length[0];
    assert_near(s.model->kernels->measure(s.model->net, 1, s.model->u), 0.25 * ex * ex, 1e-6);
    setup_fini(&s);
    setup_network(&s, make_triangle(1.0), 0.0); /* one missing, one twice */
    link[2].node[0] = 0;
    s.param[row_of(&s, "alpha")] =
        (ss_param_value){.per_link = link, .link_count = 3, .is_given = true};
    expect_refusal(&s, SOFTSIM_ERROR_SCENE, "1 name one again (of node 0), 1 links have no row");
}

/* ---- pull ---- */

TEST(pull_is_that_of_the_plain_sum_over_links)
{
    setup s;
    ss_model *m = create_network(&s, make_box(5, 4, 3, 0.1), 0.05);
    double(*expected)[3] = calloc((size_t)m->node_count, sizeof *expected);
    for (double size = 1e-3; size < 2.0; size *= 6.0) {
        shake(&s, size);
        memset(expected, 0, (size_t)m->node_count * sizeof *expected);
        const double energy = reference(&s, m->u, expected);
        for (int path = 0; ss_chain_kernels_path(path); ++path) {
            const ss_chain_kernels *kernels = ss_chain_kernels_path(path);
            memset(m->pull, 0, 4 * (size_t)m->padded * sizeof *m->pull);
            const double found = kernels->pull(m->net, 1, m->u, m->pull);
            assert_near(found, energy, BY_TYPE(1e-5, 1e-13) * energy + BY_TYPE(1e-12, 0.0));
            assert_near(kernels->measure(m->net, 1, m->u), found, 1e-6 * energy);
            for (int32_t i = 0; i < m->node_count; ++i) {
                for (int k = 0; k < 3; ++k) {
                    assert_near((double)m->pull[4 * (ptrdiff_t)i + k], expected[i][k],
                                BY_TYPE(1e-6, 1e-14) * (0.1 + size));
                }
            }
        }
    }
    free(expected);
    setup_fini(&s);
}

/* A cube of `cells` a side whose links pull, its nodes shaken by `size`. */
static ss_model *create_pulling(setup *s, int cells, double size)
{
    ss_model *m = create_network(s, make_box(cells, cells, cells, 1.0), 0.02);
    shake(s, size);
    (void)m->kernels->pull(m->net, 1, m->u, m->pull);
    return m;
}

TEST(pull_has_no_force_and_no_torque_of_its_own)
{
    setup s;
    ss_model *m = create_pulling(&s, 4, 0.8);
    double force[3] = {0.0}, torque[3] = {0.0};
    for (int32_t i = 0; i < m->node_count; ++i) {
        double p[3], f[3], t[3];
        for (int k = 0; k < 3; ++k) {
            p[k] = s.mesh->position[i][k] + (double)m->u[4 * (ptrdiff_t)i + k];
            f[k] = (double)m->pull[4 * (ptrdiff_t)i + k];
        }
        ss_add3(force, force, f);
        ss_cross3(t, p, f);
        ss_add3(torque, torque, t);
    }
    assert_below(ss_norm3(force), BY_TYPE(3e-6, 1e-14));
    assert_below(ss_norm3(torque), BY_TYPE(2e-5, 1e-13));
    setup_fini(&s);
}

TEST(pull_is_the_slope_of_the_energy)
{
    setup s;
    ss_model *m = create_pulling(&s, 3, 0.6);
    const double step = BY_TYPE(1.0 / 256.0, 1e-5);
    for (int32_t i = 0; i < m->node_count; i += 2) {
        for (int k = 0; k < 3; ++k) {
            ss_real *u = &m->u[4 * (ptrdiff_t)i + k];
            const ss_real at = *u;
            *u = at + (ss_real)step;
            const double more = m->kernels->measure(m->net, 1, m->u);
            *u = at - (ss_real)step;
            const double less = m->kernels->measure(m->net, 1, m->u);
            *u = at;
            assert_near((double)m->pull[4 * (ptrdiff_t)i + k], (less - more) / (2.0 * step),
                        BY_TYPE(3e-3, 1e-9));
        }
    }
    setup_fini(&s);
}

TEST(coincident_ends_part_along_their_rest_direction)
{
    setup s;
    ss_model *m = create_network(&s, make_triangle(1000.0), 0.02);
    m->u[4] = -1; /* node 1 onto node 0 */
    const double energy = m->kernels->pull(m->net, 1, m->u, m->pull);
    assert_near(energy, 0.25 * 0.98 * 0.98, 1e-6);
    assert_near((double)m->pull[0], -0.49, 1e-6);
    assert_near((double)m->pull[4], 0.49, 1e-6);
    assert_near((double)m->pull[1], 0.0, 1e-9);
    setup_fini(&s);
}

TEST(a_wide_band_ends_at_length_zero)
{
    setup s;
    setup_network(&s, make_triangle(1000.0), 1.5); /* lmin would be -0.5 */
    create(&s);
    s.model->u[4] = (ss_real)-0.9;
    assert_near(s.model->kernels->measure(s.model->net, 1, s.model->u), 0.0, 0.0);
    steps(&s, 10, 0.5);
    assert_near(moved(&s, 1, 0), -0.9, 1e-6); /* slack: stays */
    setup_fini(&s);
}

/* ---- steps ---- */

TEST(two_ends_approach_their_band_at_the_known_rate)
{
    for (int fixed = 0; fixed < 2; ++fixed) {
        setup s;
        setup_network(&s, make_triangle(1000.0), 0.02);
        s.fixed[0] = fixed ? 7 : 0;
        s.fixed[2] = 7;
        create(&s);
        s.model->u[4] = 1; /* length 2, ex 0.98 */
        s.model->is_all_awake = true;
        const double dt = 0.05, rate = fixed ? 1.0 - 0.5 * dt : 1.0 - dt;
        for (int n = 1; n < 100; ++n) {
            steps(&s, 1, dt);
            const double ex = 1.0 + moved(&s, 1, 0) - moved(&s, 0, 0) - 1.02;
            assert_near(ex, 0.98 * pow(rate, n), BY_TYPE(2e-6, 1e-12));
        }
        setup_fini(&s);
    }
}

/* One Euler step of `h` of the links alone; returns W before it. */
static double euler(setup *s, double h)
{
    ss_model *m = s->model;
    ss_chain_motion motion = {.h = (ss_real)h, .mobility = m->mobility, .pull = m->pull, .u = m->u};
    const double energy = m->kernels->pull(m->net, 1, m->u, m->pull);
    m->kernels->move(m->padded, &motion);
    return energy;
}

TEST(energy_never_rises_at_the_proven_step)
{
    random_state = 7;
    for (int which = 0; which < 3; ++which) {
        setup s;
        setup_network(&s,
                      which == 0   ? make_box(4, 4, 4, 1.0)
                      : which == 1 ? make_plane(9)
                                   : make_star(60),
                      0.02);
        s.fixed[1] = s.fixed[3] = 7;
        create(&s);
        const double h = 0.999 / 0.9 * ss_chain_stable_step(s.model);
        for (int n = 0; n < 340; ++n) {
            shake(&s, pow(10.0, -3.0 + 6.0 * (0.5 + 0.5 * random_unit())));
            double before = euler(&s, h);
            for (int k = 0; k < 4; ++k) {
                const double after = euler(&s, h);
                if (!(after <= before * (1.0 + BY_TYPE(1e-5, 1e-12)) + BY_TYPE(1e-13, 1e-28))) {
                    fail_msg("state %d of mesh %d, step %d: %.9g after %.9g", n, which, k, after,
                             before);
                }
                before = after;
            }
        }
        setup_fini(&s);
    }
}

TEST(energy_rises_beyond_the_bound_on_a_star)
{
    setup s;
    setup_network(&s, make_star(300), 0.0);
    for (int32_t i = 1; i <= 300; ++i) {
        s.fixed[i] = 7;
    }
    create(&s);
    const double h = 1.1 / 0.9 * ss_chain_stable_step(s.model);
    /* Links so long that their rest length counts for nothing: every direction is stiff. */
    for (int32_t i = 1; i <= 300; ++i) {
        for (int k = 0; k < 2; ++k) {
            s.model->u[4 * (ptrdiff_t)i + k] = (ss_real)(300.0 * s.mesh->position[i][k]);
        }
    }
    s.model->u[0] = 30;
    bool has_risen = false;
    double before = euler(&s, h);
    for (int n = 0; n < 60; ++n) {
        const double after = euler(&s, h);
        has_risen = has_risen || after > before;
        before = after;
    }
    assert_true(has_risen);
    setup_fini(&s);
}

/* ---- frames ---- */

TEST(results_turn_and_move_with_the_body)
{
    for (int saturated = 0; saturated < 2; ++saturated) {
        setup s[2];
        for (int which = 0; which < 2; ++which) {
            ss_mesh *mesh = make_box(4, 4, 3, 1.0);
            for (int32_t i = 0; which == 1 && i < mesh->node_count; ++i) {
                turn(mesh->position[i]);
                mesh->position[i][0] += BY_TYPE(8.0, 1e3); /* rest vectors are rounded */
            }
            setup_network(&s[which], mesh, 0.02);
            for (int32_t i = 0; i < 16; ++i) {
                s[which].fixed[i] = 7;
            }
            if (saturated) {
                give(&s[which], "saturation_sizes", 0.1);
            }
            create(&s[which]);
            random_state = 11;
            for (int32_t i = 16; i < mesh->node_count; ++i) {
                double x[3] = {random_unit(), random_unit(), random_unit()};
                if (which == 1) {
                    turn(x);
                }
                for (int k = 0; k < 3; ++k) {
                    s[which].model->u[4 * (ptrdiff_t)i + k] = (ss_real)x[k];
                }
            }
            s[which].model->is_all_awake = true;
            steps(&s[which], 40, 0.05);
        }
        for (int32_t i = 0; i < s[0].mesh->node_count; ++i) {
            double x[3] = {moved(&s[0], i, 0), moved(&s[0], i, 1), moved(&s[0], i, 2)};
            turn(x);
            for (int k = 0; k < 3; ++k) {
                assert_near(moved(&s[1], i, k), x[k], BY_TYPE(2e-4, 1e-11));
            }
        }
        setup_fini(&s[0]);
        setup_fini(&s[1]);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
