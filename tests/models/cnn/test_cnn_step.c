/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy in time: the step bound, sub-steps, budget and faults, and what acts without a tool:
 * pressure, gravity, an enclosed volume.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/model_fixture.h"
#include "rt/thread.h"

/* ---- time and guards ---- */

/* |largest eigenvalue| of one RK4 step of x'' + d x' + w^2 x = 0. */
static double amplification(double d, double w, double dt)
{
    double column[2][2];
    for (int k = 0; k < 2; ++k) {
        double x = k == 0, v = k == 1, w1[4], a1[4];
        const double x0 = x, v0 = v;
        for (int s = 0; s < 4; ++s) {
            w1[s] = v;
            a1[s] = -d * v - w * w * x;
            const double h = s < 2 ? 0.5 * dt : dt;
            x = x0 + h * w1[s];
            v = v0 + h * a1[s];
        }
        column[k][0] = x0 + dt / 6.0 * (w1[0] + 2.0 * w1[1] + 2.0 * w1[2] + w1[3]);
        column[k][1] = v0 + dt / 6.0 * (a1[0] + 2.0 * a1[1] + 2.0 * a1[2] + a1[3]);
    }
    const double trace = column[0][0] + column[1][1];
    const double det = column[0][0] * column[1][1] - column[1][0] * column[0][1];
    const double root = 0.25 * trace * trace - det;
    return root < 0.0 ? sqrt(det) : 0.5 * fabs(trace) + sqrt(root);
}

TEST(the_rk4_limit_is_the_edge_of_stability)
{
    for (int k = 0; k <= 60; ++k) {
        const double w = 10.0, d = w * pow(10.0, -2.0 + 0.06 * k);
        const double limit = ss_cnn_rk4_limit(d, d, w * w);
        /* Softer and differently damped modes too; one of them is at the edge. */
        const double wide = ss_cnn_rk4_limit(0.3 * d, d, w * w);
        double worst = 0.0;
        for (int m = 0; m <= 40; ++m) {
            const double share = m / 40.0;
            worst = fmax(worst, amplification(d, share * w, 1.1 * limit));
            assert_true(amplification(d, share * w, 0.999 * limit) <= 1.0 + 1e-9);
            assert_true(amplification(0.3 * d, share * w, 0.999 * wide) <= 1.0 + 1e-9);
            assert_true(amplification(d, share * w, 0.999 * wide) <= 1.0 + 1e-9);
            assert_true(amplification(0.6 * d, share * w, 0.999 * wide) <= 1.0 + 1e-9);
        }
        assert_true(worst > 1.0);
    }
}

TEST(the_step_bound_covers_the_stiffest_mode)
{
    /* Power iteration on the dynamics themselves: x := force(u + x) - force(u), over the mass. */
    setup s;
    setup_body(&s, 3);
    int32_t top = top_node(s.mesh);
    push(&s, &top, 0.0, 0.0, 0.9);
    per_node(&s, 1.0, 0.0, 0.1);
    create(&s);
    steps(&s, 40, 0.05);
    const int32_t n = s.mesh->node_count;
    ss_real *u = calloc((size_t)n * 4, sizeof *u);
    double(*x)[3] = calloc((size_t)n, sizeof *x), (*f)[3] = calloc((size_t)n, sizeof *f);
    memcpy(u, s.class->displacement(s.model), (size_t)n * 4 * sizeof *u);
    random_state = 3;
    double rate = 0.0;
    for (int32_t i = 0; i < n; ++i) {
        ss_set3(x[i], random_unit(), random_unit(), random_unit());
    }
    const double bound = info_of(&s).stable_step, step = BY_TYPE(1e-2, 1e-5);
    for (int round = 0; round < 120; ++round) {
        double norm = 0.0;
        for (int side = 0; side < 2; ++side) {
            for (int32_t i = 0; i < n; ++i) {
                const double h = (s.fixed[i] & 7) == 7 ? 0.0 : (side == 0 ? step : -step);
                place(&s, i, (double)u[4 * i] + h * x[i][0], (double)u[4 * i + 1] + h * x[i][1],
                      (double)u[4 * i + 2] + h * x[i][2]);
            }
            for (int32_t i = 0; i < n; ++i) {
                for (int k = 0; k < 3; ++k) {
                    double force = 0.0;
                    if (i == 0 && k == 0) {
                        potential(&s, i, k, &force);
                    } else {
                        const ss_model *m = s.model;
                        const ptrdiff_t at = 4 * (ptrdiff_t)i + k;
                        force = (double)m->force[at] - 0.1 * (double)m->d[at] -
                                m->first->c1 * (double)m->first->r[at];
                    }
                    const double share = force / (2.0 * step);
                    f[i][k] = side == 0 ? share : f[i][k] - share;
                }
            }
        }
        for (int32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) {
                f[i][k] = (s.fixed[i] & 7) == 7 ? 0.0 : f[i][k];
                norm += f[i][k] * f[i][k];
            }
        }
        rate = sqrt(norm); /* |x| is 1: the eigenvalue's magnitude */
        for (int32_t i = 0; i < n; ++i) {
            ss_scale3(x[i], f[i], -1.0 / rate);
        }
    }
    const double true_limit = ss_cnn_rk4_limit(0.0, 0.0, rate);
    assert_true(bound <= true_limit * 1.001);
    assert_true(bound >= 0.6 * true_limit);
    free(u);
    free(x);
    free(f);
    setup_fini(&s);
}

TEST(huge_forces_are_sub_stepped_and_stay_finite)
{
    static const double force[3] = {1.0, 1e4, 1e6};
    for (int k = 0; k < 3; ++k) {
        setup s;
        int32_t top = TOP;
        setup_cylinder(&s, 1.0);
        s.plan.max_substeps = 256;
        push(&s, &top, 0.0, -force[k], 0.0);
        create(&s);
        steps(&s, FULL_IN_RELEASE(4000, 400), 0.05);
        const ss_model_info info = info_of(&s);
        assert_true(isfinite(largest_displacement(&s)));
        assert_true(info.fault_bits == 0 && info.verdict <= SOFTSIM_VERDICT_GUARDED);
        assert_true(k == 0 ? info.substeps == 1 : info.substeps > 1);
        /* Steps near the limit may lose energy, but never gain it. */
        assert_true(energy_gain(&s) <= 1e-5 * info.work && energy_gain(&s) >= -0.2 * info.work);
        setup_fini(&s);
    }
}

TEST(beyond_the_budget_time_slows_down_and_it_is_said)
{
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 1.0);
    s.plan.max_substeps = 2;
    push(&s, &top, 0.0, -1e6, 0.0);
    create(&s);
    bool was_degraded = false;
    for (int k = 0; k < 400; ++k) {
        steps(&s, 1, 0.5);
        const ss_model_info info = info_of(&s);
        assert_true(isfinite(largest_displacement(&s)) && info.verdict != SOFTSIM_VERDICT_FAULT);
        if (info.verdict == SOFTSIM_VERDICT_DEGRADED) {
            was_degraded = true;
            assert_true((info.fault_bits & SS_MODEL_FAULT_BUDGET) != 0);
            assert_true(strlen(info.reason) > 0);
            assert_true(info.worst_element >= 0);
        }
    }
    assert_true(was_degraded);
    setup_fini(&s);
}

TEST(a_state_that_is_not_finite_is_a_fault_until_reset)
{
    setup s;
    int32_t top = TOP;
    setup_cylinder(&s, 1.0);
    push(&s, &top, 0.0, -0.25, 0.0);
    create(&s);
    steps(&s, 10, 0.1);
    s.model->v[4 * 100 + 1] = (ss_real)NAN;
    steps(&s, 1, 0.1);
    ss_model_info info = info_of(&s);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_FAULT);
    assert_true((info.fault_bits & SS_MODEL_FAULT_NOT_FINITE) != 0);
    assert_true(isfinite(largest_displacement(&s)));
    const double held = moved(&s, TOP, 1);
    steps(&s, 5, 0.1); /* frozen */
    assert_true(moved(&s, TOP, 1) == held);
    s.class->reset(s.model);
    s.time = 0.0;
    info = info_of(&s);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_GOOD);
    assert_true(largest_displacement(&s) == 0.0);
    steps(&s, 10, 0.1);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    assert_true(moved(&s, TOP, 1) < 0.0);
    setup_fini(&s);
}

TEST(the_audit_error_falls_with_the_fourth_power_of_the_step)
{
    double error[2];
    for (int k = 0; k < 2; ++k) {
        setup s;
        int32_t centre = 0;
        setup_fan(&s, 7.0, 1.0, 0.1, 0.3);
        push(&s, &centre, 0.0, 0.0, 0.05);
        create(&s);
        const double dt = k == 0 ? 0.6 : 0.3;
        steps(&s, (int)(12.0 / dt + 0.5), dt);
        assert_int_equal(info_of(&s).substeps, 1);
        error[k] = fabs(energy_gain(&s));
        setup_fini(&s);
    }
    assert_true(error[0] / error[1] > 10.0);
    assert_true(error[0] > 1e-8);
}

/* ---- pressure, gravity, volume ---- */

TEST(pressure_follows_the_surface_and_sums_to_nothing_on_a_closed_body)
{
    setup s;
    setup_body(&s, 4);
    int32_t all[1000];
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        all[i] = i;
    }
    s.load[0] = (ss_load){.node = all,
                          .node_count = s.mesh->node_count,
                          .pressure = 0.05,
                          .is_pressure = true,
                          .to = (double)INFINITY};
    s.plan.load_count = 1;
    create(&s);
    steps(&s, 3000, 0.1);
    assert_true(moved(&s, top_node(s.mesh), 2) < -0.005); /* inward */
    double reaction[3], springs[3] = {0.0, 0.0, 0.0};
    s.class->reaction(s.model, -1, reaction);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            springs[k] -= 0.1 * moved(&s, i, k);
        }
    }
    for (int k = 0; k < 3; ++k) { /* supports and springs are in balance */
        assert_near(reaction[k] + springs[k], 0.0, BY_TYPE(1e-4, 1e-7));
    }
    setup_fini(&s);
}

TEST(gravity_hangs_each_node_on_its_spring)
{
    setup s;
    setup_body(&s, 3);
    s.plan.gravity[2] = -0.02;
    create(&s);
    steps(&s, 6000, 0.1);
    assert_near(moved(&s, top_node(s.mesh), 2), -0.02 / 0.1, BY_TYPE(1e-6, 1e-10));
    assert_near(energy_gain(&s), 0.0, BY_TYPE(1e-4, 1e-5) * info_of(&s).work);
    double reaction[3];
    s.class->reaction(s.model, -1, reaction);
    int held = 0;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        held += s.fixed[i] == 7;
    }
    assert_near(reaction[2], 0.02 * held, 1e-6); /* the others hang on their springs */
    setup_fini(&s);
}

static double enclosed_volume(const setup *s)
{
    double volume = 0.0;
    for (int32_t t = 0; t < s->mesh->triangle_count; ++t) {
        double p[3][3], c[3];
        for (int a = 0; a < 3; ++a) {
            const int32_t node = s->mesh->triangle[t][a];
            for (int k = 0; k < 3; ++k) {
                p[a][k] = s->mesh->position[node][k] + moved(s, node, k);
            }
        }
        ss_cross3(c, p[1], p[2]);
        volume += ss_dot3(p[0], c) / 6.0;
    }
    return volume;
}

TEST(what_is_enclosed_keeps_most_of_its_volume)
{
    double lost[2];
    for (int k = 0; k < 2; ++k) {
        setup s;
        setup_body(&s, 4);
        int32_t patch[200], count = 0;
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            if (s.mesh->position[i][2] > 0.6) {
                patch[count++] = i;
            }
        }
        s.load[0] = (ss_load){
            .node = patch, .node_count = count, .force = {0, 0, -1.0}, .to = (double)INFINITY};
        s.plan.load_count = 1;
        give(&s, "pretension_j", 1.0);
        if (k == 1) {
            give(&s, "enclosed_bulk_pa", 20.0);
        }
        create(&s);
        const double before = enclosed_volume(&s);
        steps(&s, 3000, 0.1);
        lost[k] = 1.0 - enclosed_volume(&s) / before;
        setup_fini(&s);
    }
    assert_true(lost[0] > 0.005);
    assert_true(fabs(lost[1]) < 0.4 * lost[0]);
}

/* Each body encloses a volume of its own: what presses one does not inflate the other. */
TEST(bodies_of_one_mesh_enclose_a_volume_each)
{
    static setup s[2];
    for (int k = 0; k < 2; ++k) {
        setup_init(&s[k], "cnn-energy", make_bodies(make_ellipsoid(4, 1.0, 0.9, 0.8), k + 1, 3.0));
        for (int32_t i = 0; i < s[k].mesh->node_count; ++i) {
            s[k].fixed[i] = s[k].mesh->position[i][2] < -0.5 ? 7 : 0;
        }
        per_node(&s[k], 1.0, 1.0, 1.0);
        give(&s[k], "modulus_j", 5.0);
        give(&s[k], "pretension_j", 1.0);
        give(&s[k], "enclosed_bulk_pa", 20.0);
        static int32_t patch[2][200];
        int32_t count = 0;
        for (int32_t i = 0; i < s[k].mesh->node_count; ++i) {
            if (s[k].mesh->position[i][2] > 0.6 && s[k].mesh->position[i][0] < 1.5) {
                patch[k][count++] = i;
            }
        }
        s[k].load[0] = (ss_load){
            .node = patch[k], .node_count = count, .force = {0, 0, -1.0}, .to = (double)INFINITY};
        s[k].plan.load_count = 1;
        create(&s[k]);
        steps(&s[k], 300, 0.1);
    }
    const int32_t half = s[0].mesh->node_count;
    double largest = 0.0, other = 0.0, differs = 0.0;
    for (int32_t i = 0; i < half; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const double alone = moved(&s[0], i, axis);
            largest = fmax(largest, fabs(alone));
            differs = fmax(differs, fabs(moved(&s[1], i, axis) - alone));
            other = fmax(other, fabs(moved(&s[1], half + i, axis)));
        }
    }
    print_message("moved %.3g, beside another %.3g otherwise; the other moved %.3g\n", largest,
                  differs, other);
    assert_true(largest > 0.01);
    assert_true(differs < 1e-5 * largest);
    assert_true(other == 0.0);
    assert_true(fabs(energy_gain(&s[1])) < 1e-3 * info_of(&s[1]).work);
    for (int k = 0; k < 2; ++k) {
        setup_fini(&s[k]);
    }
}

/* A ball in a ball, the inner one inside out, and a third beside them. */
TEST(a_cavity_belongs_to_the_body_around_it)
{
    setup s;
    ss_mesh *ball[3] = {make_ellipsoid(4, 1.0, 1.0, 1.0), make_ellipsoid(3, 0.5, 0.5, 0.5),
                        make_ellipsoid(2, 0.4, 0.4, 0.4)};
    draft d;
    draft_init(&d, 2000, 4000);
    for (int k = 0; k < 3; ++k) {
        const int32_t first = d.nodes;
        for (int32_t i = 0; i < ball[k]->node_count; ++i) {
            const double *x = ball[k]->position[i];
            draft_node(&d, x[0] + (k == 2 ? 2.0 : 0.0), x[1], x[2]);
        }
        for (int32_t t = 0; t < ball[k]->triangle_count; ++t) {
            const int32_t *n = ball[k]->triangle[t];
            draft_triangle(&d, first + n[0], first + n[k == 1 ? 2 : 1], first + n[k == 1 ? 1 : 2]);
        }
    }
    setup_init(&s, "cnn-energy", draft_finish(&d));
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < -0.2 ? 7 : 0;
    }
    per_node(&s, 1.0, 1.0, 1.0);
    give(&s, "modulus_j", 5.0);
    give(&s, "enclosed_bulk_pa", 20.0);
    create(&s);
    assert_int_equal(s.model->enclosed_count, 2);
    double volume[3];
    for (int k = 0; k < 3; ++k) {
        ss_mesh_report report;
        assert_int_equal(ss_mesh_check(ball[k], &report), SOFTSIM_OK);
        volume[k] = report.volume;
        ss_mesh_destroy(&ball[k]);
    }
    assert_near(s.model->enclosed[0].volume, volume[0] - volume[1], 1e-12);
    assert_near(s.model->enclosed[1].volume, volume[2], 1e-12);
    setup_fini(&s);
}

/* Runge-Kutta near its stable step: at omega h = 1.9 a cycle loses a third of its energy. */
TEST(a_step_that_loses_energy_says_so)
{
    for (int kind = 0; kind < 2; ++kind) {
        const double dt = kind == 0 ? 0.1 : 1.9;
        setup s;
        setup_fan(&s, 7.0, 1.0, 0.0, 1.0);
        create(&s);
        place(&s, 0, 0.0, 0.0, 0.2);
        steps(&s, 1, dt);
        const double lost = 0.02 - info_of(&s).elastic - info_of(&s).kinetic;
        assert_true(kind == 0 ? fabs(lost) < 2e-7 : lost > 0.004);
        assert_int_equal(info_of(&s).verdict,
                         kind == 0 ? SOFTSIM_VERDICT_GOOD : SOFTSIM_VERDICT_GUARDED);
        assert_true(kind == 0 || strstr(info_of(&s).reason, "lose energy"));
        setup_fini(&s);
    }
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
