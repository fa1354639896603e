/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The computed step of cnn-energy against the limit that its own dynamics show, and what slivers
 * and huge forces do. The limit is measured, not derived: a perturbation of a settled state is
 * carried by classical Runge-Kutta with forces asked of the model, and the step is halved between
 * one that lets it grow and one that does not.
 */
#include "common/test.h"

#include <stdio.h>

#include "common/effort.h"
#include "common/model_fixture.h"

/* ---- the measured limit ---- */

typedef struct dynamics {
    setup s;
    double *u0, *a0; /* the settled state and its acceleration, 3 a node */
    double *u, *v, *ut, *ku[4], *kv[4];
    double damping_rate;
} dynamics;

static double *get_vector(const dynamics *d)
{
    double *x = calloc((size_t)d->s.mesh->node_count * 3, sizeof *x);
    assert_non_null(x);
    return x;
}

/* Accelerations without damping at u0 + u. */
static void accelerate(dynamics *d, const double *u, double *out)
{
    setup *s = &d->s;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        place(s, i, d->u0[3 * i] + u[3 * i], d->u0[3 * i + 1] + u[3 * i + 1],
              d->u0[3 * i + 2] + u[3 * i + 2]);
    }
    s->model->is_ready = false;
    s->class->step(s->model, s->time, 1e-30, NULL);
    const ss_model *m = s->model;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i + k;
            const double force =
                (double)m->force[at] - (double)m->rest_stiffness[i] * (double)m->d[at] -
                m->first->c1 * (double)m->first->r[at] + m->first->c2 * (double)m->first->b[at];
            out[3 * i + k] = (double)m->mobility[at] * force;
        }
    }
}

static void slope(dynamics *d, const double *u, const double *v, double *out)
{
    accelerate(d, u, out);
    for (int32_t i = 0; i < 3 * d->s.mesh->node_count; ++i) {
        out[i] += -d->a0[i] - d->damping_rate * v[i];
    }
}

static double size_of(const dynamics *d)
{
    double square = 0.0;
    for (int32_t i = 0; i < 3 * d->s.mesh->node_count; ++i) {
        square += d->u[i] * d->u[i];
    }
    return sqrt(square);
}

/* Growth a step of the perturbation after it has turned to the worst mode. */
static double growth(dynamics *d, double h, double amplitude)
{
    enum { STEPS = 90, COUNTED = 45 };
    const int32_t n = 3 * d->s.mesh->node_count;
    random_state = 5;
    for (int32_t i = 0; i < n; ++i) {
        d->u[i] = (d->s.fixed[i / 3] & 7) == 7 ? 0.0 : amplitude * random_unit();
        d->v[i] = 0.0;
    }
    double sum = 0.0;
    for (int k = 0; k < STEPS; ++k) {
        for (int stage = 0; stage < 4; ++stage) {
            const double part = stage == 0 ? 0.0 : stage < 3 ? 0.5 * h : h;
            for (int32_t i = 0; i < n; ++i) {
                d->ut[i] = d->u[i] + (stage > 0 ? part * d->ku[stage - 1][i] : 0.0);
                d->ku[stage][i] = d->v[i] + (stage > 0 ? part * d->kv[stage - 1][i] : 0.0);
            }
            slope(d, d->ut, d->ku[stage], d->kv[stage]);
        }
        const double before = size_of(d);
        for (int32_t i = 0; i < n; ++i) {
            d->u[i] +=
                h / 6.0 * (d->ku[0][i] + 2.0 * d->ku[1][i] + 2.0 * d->ku[2][i] + d->ku[3][i]);
            d->v[i] +=
                h / 6.0 * (d->kv[0][i] + 2.0 * d->kv[1][i] + 2.0 * d->kv[2][i] + d->kv[3][i]);
        }
        const double after = size_of(d);
        if (!(after > 0.0)) {
            return 0.0;
        }
        sum += k >= STEPS - COUNTED ? log(after / before) : 0.0;
        for (int32_t i = 0; i < n; ++i) { /* stays a perturbation */
            d->u[i] *= amplitude / after;
            d->v[i] *= amplitude / after;
        }
    }
    return exp(sum / COUNTED);
}

/* The largest stable step over the computed one. */
static double measured_over_computed(dynamics *d, double *out_bound)
{
    setup *s = &d->s;
    const int32_t n = s->mesh->node_count;
    double **const vector[] = {&d->u0,    &d->a0,    &d->u,     &d->v,     &d->ut,
                               &d->ku[0], &d->ku[1], &d->ku[2], &d->ku[3], &d->kv[0],
                               &d->kv[1], &d->kv[2], &d->kv[3]};
    for (size_t k = 0; k < sizeof vector / sizeof *vector; ++k) {
        *vector[k] = get_vector(d);
    }
    const ss_real *u = s->class->displacement(s->model);
    for (int32_t i = 0; i < 3 * n; ++i) {
        d->u0[i] = (double)u[4 * (i / 3) + i % 3];
    }
    const double bound = *out_bound = info_of(s).stable_step;
    accelerate(d, d->u, d->a0);
    double low = 0.5, high = 4.0;
    const double amplitude = BY_TYPE(1e-2, 1e-5);
    while (high / low > 1.02) {
        const double middle = sqrt(low * high);
        *(growth(d, middle * bound, amplitude) > 1.0 + BY_TYPE(2e-3, 1e-5) ? &high : &low) = middle;
    }
    for (size_t k = 0; k < sizeof vector / sizeof *vector; ++k) {
        free(*vector[k]);
    }
    return low;
}

TEST(the_computed_step_is_never_beyond_the_measured_limit)
{
    SKIP_WHERE_REPEATED();
    static const struct {
        double force, modulus, mass, damping, stiffness;
    } body[] = {
        {0.25, 60.0, 1.0, 1.0, 0.1}, {1.0, 60.0, 1.0, 1.0, 0.1},   {4.0, 60.0, 1.0, 1.0, 0.1},
        {20.0, 60.0, 1.0, 1.0, 0.1}, {100.0, 60.0, 1.0, 1.0, 0.1}, {1.0, 60.0, 1.0, 10.0, 0.1},
        {1.0, 60.0, 1.0, 50.0, 0.1}, {1.0, 600.0, 1.0, 1.0, 0.1},  {1.0, 6000.0, 1.0, 1.0, 0.1},
        {1.0, 60.0, 1e-2, 0.1, 0.1}, {1.0, 60.0, 1e-4, 1e-3, 0.1}};
    fprintf(stderr, "     F      E      m  gamma  computed s  measured / computed\n");
    for (size_t k = 0; k < sizeof body / sizeof *body; ++k) {
        dynamics d = {.damping_rate = body[k].damping / body[k].mass};
        setup *s = &d.s;
        setup_cylinder(s, 1.0);
        int32_t node = TOP;
        push(s, &node, 0.0, -body[k].force, 0.0);
        give(s, "modulus_n_per_m", body[k].modulus);
        per_node(s, body[k].mass, body[k].damping, body[k].stiffness);
        create(s);
        const double time = sqrt(body[k].mass / body[k].stiffness);
        steps(s, 60, 0.25 * time);
        double bound;
        const double ratio = measured_over_computed(&d, &bound);
        fprintf(stderr, "%6g %6g %6g %6g  %10.4g  %.2f\n", body[k].force, body[k].modulus,
                body[k].mass, body[k].damping, bound, ratio);
        assert_true(ratio >= 0.99);
        assert_true(ratio < 2.0);
        setup_fini(s);
    }
}

/* ---- slivers and huge forces ---- */

/* A cylinder with one node moved to `gap` edges from its neighbour along the ring. */
static ss_mesh *make_sliver(double gap)
{
    ss_mesh *mesh = make_cylinder(15, 24, 1.0, 4.0);
    const int32_t a = 7 * 24 + 3, b = 7 * 24 + 4;
    for (int k = 0; k < 3; ++k) {
        mesh->position[a][k] =
            mesh->position[b][k] + gap * (mesh->position[a][k] - mesh->position[b][k]);
    }
    return mesh;
}

TEST(slivers_are_stepped_safely_or_refused)
{
    fprintf(stderr, "   gap  outcome\n");
    for (int power = 0; power <= 6; ++power) {
        const double gap = pow(10.0, -power);
        setup s;
        setup_cylinder(&s, 1.0);
        ss_mesh_destroy(&s.mesh);
        s.mesh = make_sliver(gap);
        s.plan.mesh = s.mesh;
        int32_t node = 7 * 24 + 4; /* at the sliver */
        push(&s, &node, 0.0, -1.0, 0.0);
        s.plan.max_substeps = 64;
        const softsim_status status = setup_create(&s);
        if (status != SOFTSIM_OK) {
            fprintf(stderr, "%6g  refused: %s\n", gap, s.error.text);
            assert_true(gap < 2e-3);
            assert_non_null(strstr(s.error.text, "weld"));
        } else {
            steps(&s, 200, 0.05);
            const ss_model_info info = info_of(&s);
            fprintf(stderr, "%6g  stable step %.3g s, %d sub-steps, verdict %d %s\n", gap,
                    info.stable_step, info.substeps, (int)info.verdict, info.reason);
            assert_true(isfinite(largest_displacement(&s)) && largest_displacement(&s) < 10.0);
            assert_true(info.substeps == 1 || info.stable_step < 0.05 / 0.7);
            assert_true(isfinite(info.elastic + info.kinetic));
        }
        setup_fini(&s);
    }
}

TEST(forces_to_a_million_end_finite_and_every_guard_is_told)
{
    fprintf(stderr, "     F  largest u  sub-steps  verdict\n");
    for (int power = 0; power <= 6; ++power) {
        setup s;
        setup_cylinder(&s, 1.0);
        int32_t node = TOP;
        push(&s, &node, 0.0, -pow(10.0, power), 0.0);
        s.plan.max_substeps = 64;
        create(&s);
        int32_t most = 0;
        softsim_verdict worst = SOFTSIM_VERDICT_GOOD;
        char reason[128] = "";
        for (int k = 0; k < 600; ++k) {
            steps(&s, 1, 0.05);
            const ss_model_info info = info_of(&s);
            assert_true(isfinite(info.elastic + info.kinetic + largest_displacement(&s)));
            /* Whatever acted is told, and nothing is told that did not act. */
            assert_true((info.verdict == SOFTSIM_VERDICT_GOOD) == (info.reason[0] == '\0'));
            assert_true(info.verdict < SOFTSIM_VERDICT_FAULT);
            most = info.substeps > most ? info.substeps : most;
            if (info.verdict > worst) {
                worst = info.verdict;
                snprintf(reason, sizeof reason, "%s", info.reason);
            }
        }
        fprintf(stderr, "%6.0e  %9.4g  %9d  %d %s\n", pow(10.0, power), largest_displacement(&s),
                most, (int)worst, reason);
        setup_fini(&s);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
