/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The body that Newtonian models share, under a law with closed forms: every node is held at its
 * place by a spring and a damper of its own. cmocka comes first. */
#include "common/element_fixture.h"
#include "models/common/body.h"
#include "models/model.h"
#include "rt/memory.h"

/* ---- a body ---- */

typedef struct anchors {
    ss_body *body;
    double stiffness, damping; /* N/m, N s/m, a node */
    double share;              /* of the law's stable step that it claims */
    bool is_broken;            /* forces that are not numbers */
    double own_mass_damping;
    ss_body_integrator integrator;
} anchors;

static inline void anchor_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                                ss_body_energy *out)
{
    const anchors *a = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(a->body);
    double square = 0.0, speed = 0.0;
    for (int32_t at = 0; at < 4 * nodes->count; ++at) {
        force[at] -= (ss_real)a->stiffness * u[at] + (ss_real)a->damping * v[at];
        square += (double)u[at] * (double)u[at];
        speed += (double)v[at] * (double)v[at];
    }
    if (a->is_broken) {
        force[1] = (ss_real)NAN;
    }
    out->elastic = 0.5 * a->stiffness * square;
    out->power = a->damping > 0.0 ? a->damping * speed : 0.0;
}

static inline void anchor_tangent(void *owner, const ss_real *x, ss_real *out)
{
    const anchors *a = owner;
    for (int32_t at = 0; at < 4 * ss_body_read_nodes(a->body)->count; ++at) {
        out[at] += (ss_real)a->stiffness * x[at];
    }
}

static inline void anchor_diagonal(void *owner, double *out)
{
    const anchors *a = owner;
    for (int32_t i = 0; i < ss_body_read_nodes(a->body)->count; ++i) {
        out[i] += a->stiffness;
    }
}

static inline double anchor_step(void *owner, const ss_body *body)
{
    const anchors *a = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(body);
    double rate2 = 0.0;
    for (int32_t i = 0; i < nodes->count; ++i) {
        rate2 = fmax(rate2, a->stiffness / nodes->mass[i]);
    }
    const double time = a->stiffness > 0.0 ? fmax(0.0, a->damping) / a->stiffness : 0.0;
    const double limit = ss_body_step_limit(a->integrator, rate2, time, a->own_mass_damping);
    return fmin(a->share * limit, 1e3);
}

typedef struct bench {
    setup s; /* mesh, fixed nodes, loads, tools; no model */
    anchors law;
    double mass_damping, share, density;
    bool is_even;      /* every node has the same mass */
    ss_body_skin skin; /* that tools touch; without a mesh they touch the body itself */
    ss_body *body;
    double time;
} bench;

/* A block of 60 mm and 64 nodes, free, without a tool; 1 N/m a node of 1 g. */
static inline void bench_init(bench *b)
{
    memset(b, 0, sizeof *b);
    setup_mesh(&b->s, make_block(3, 0.06));
    b->law = (anchors){.stiffness = 10.0, .share = 1.0};
    b->share = 0.5;
    b->density = 1000.0;
    b->is_even = true;
}

static inline softsim_status bench_create(bench *b)
{
    const size_t n = (size_t)b->s.mesh->node_count;
    double *density = calloc(n, sizeof *density), *mass = calloc(n, sizeof *mass);
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i) {
        density[i] = b->density;
    }
    ss_body_volume_masses(b->s.mesh, density, false, mass);
    for (size_t i = 0; i < n; ++i) {
        sum += mass[i];
    }
    assert_near(sum, b->density * 0.06 * 0.06 * 0.06, 1e-12 * b->density);
    for (size_t i = 0; b->is_even && i < n; ++i) {
        mass[i] = sum / (double)n;
    }
    b->law.own_mass_damping = b->mass_damping;
    const ss_body_plan plan = {.name = "anchors",
                               .plan = &b->s.plan,
                               .node_count = b->s.mesh->node_count,
                               .mass = mass,
                               .mass_damping = b->mass_damping,
                               .edge = ss_body_mean_edge(b->s.mesh),
                               .step_share = b->share,
                               .integrator = b->law.integrator,
                               .skin = b->skin,
                               .elastic = {.owner = &b->law,
                                           .force = anchor_force,
                                           .tangent = anchor_tangent,
                                           .diagonal = anchor_diagonal,
                                           .stable_step = anchor_step}};
    const softsim_status status = ss_body_create(&plan, &b->body, &b->s.error);
    free(density);
    free(mass);
    b->law.body = b->body;
    return status == SOFTSIM_OK ? ss_body_start(b->body) : status;
}

static inline void bench_make(bench *b)
{
    if (bench_create(b) != SOFTSIM_OK) {
        fail_msg("create: %s", b->s.error.text);
    }
}

static inline void bench_fini(bench *b)
{
    ss_body_destroy(&b->body);
    setup_fini(&b->s);
}

static inline void run(bench *b, int count, double dt, const ss_model_tool *tool)
{
    for (int k = 0; k < count; ++k) {
        ss_body_step(b->body, b->time, dt, tool);
        b->time += dt;
    }
}

static inline ss_model_info told(const bench *b)
{
    ss_model_info info;
    ss_body_info(b->body, &info);
    return info;
}

static inline double balance(const bench *b)
{
    const ss_model_info info = told(b);
    return info.elastic + info.kinetic - info.work + info.dissipated;
}

/* Every node displaced by x along axis 0. */
static inline void shift(bench *b, double x)
{
    ss_body_nodes *nodes = ss_body_get_nodes(b->body);
    for (int32_t i = 0; i < nodes->count; ++i) {
        nodes->u[4 * i] = (ss_real)x;
    }
    ss_body_renew(b->body);
}

static inline double at(const bench *b, int32_t node, int axis)
{
    return (double)ss_body_read_nodes(b->body)->u[4 * node + axis];
}

static const ss_body_integrator methods[] = {SS_BODY_SYMPLECTIC_EULER, SS_BODY_RK4};
