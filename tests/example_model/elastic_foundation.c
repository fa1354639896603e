/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body.h"
/*
 * The elastic foundation (Winkler 1867): every node of the surface is a spring of its own,
 *
 *   m_i u'' + 60/s m_i u' = -k A_i u + loads + contact,   m_i = sigma A_i
 *
 * with A_i a third of the triangles around it. How a model is added: server/models/README.md.
 */
#include "models/common/plan.h"
#include "rt/memory.h"

enum { STIFFNESS, AREA_DENSITY, ROW_COUNT };

static const ss_param_row rows[ROW_COUNT] = {
    [STIFFNESS] = SS_PARAM(NUMBER, "stiffness_n_per_m3", "pressure by indentation, k",
                           SS_ABOVE(0, 1e12), .fallback = 1e6),
    [AREA_DENSITY] = SS_PARAM(NUMBER, "area_density_kg_m2", "mass by area, sigma", SS_ABOVE(0, 1e6),
                              .fallback = 10.0)};

struct ss_model {
    ss_body *body; /* first: ss_body_model_* read it */
    double rate2;  /* 1/s^2, k / sigma: node i hangs on rate2 m_i */
};

static void force(void *owner, const ss_real *u, const ss_real *v, ss_real *out,
                  ss_body_energy *energy)
{
    const ss_model *model = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(model->body);
    (void)v;
    for (int32_t i = 0; i < 4 * nodes->count; ++i) {
        const double pull = model->rate2 * nodes->mass[i / 4] * (double)u[i];
        out[i] -= (ss_real)pull;
        energy->elastic += 0.5 * pull * (double)u[i];
    }
}

static void tangent(void *owner, const ss_real *x, ss_real *out)
{
    const ss_model *model = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(model->body);
    for (int32_t i = 0; i < 4 * nodes->count; ++i) {
        out[i] += (ss_real)(model->rate2 * nodes->mass[i / 4] * (double)x[i]);
    }
}

static void diagonal(void *owner, double *out)
{
    const ss_model *model = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(model->body);
    for (int32_t i = 0; i < nodes->count; ++i) {
        out[i] += model->rate2 * nodes->mass[i];
    }
}

static double stable_step(void *owner, const ss_body *body)
{
    const ss_model *model = owner;
    return ss_body_step_limit(SS_BODY_SYMPLECTIC_EULER, model->rate2, 0.0,
                              ss_body_mass_damping(body));
}

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_memory_free(model);
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    const int32_t count = plan->mesh->node_count;
    const double sigma = plan->param[AREA_DENSITY].number;
    ss_arena scratch = {0};
    double *area = ss_arena_get(&scratch, (size_t)count, sizeof *area);
    double *mass = ss_arena_get(&scratch, (size_t)count, sizeof *mass);
    softsim_status status = ss_arena_status(&scratch);
    for (int32_t i = 0; status == SOFTSIM_OK && i < count; ++i) {
        area[i] = sigma;
    }
    if (status == SOFTSIM_OK) {
        ss_body_area_masses(plan->mesh, area, mass);
        model->rate2 = plan->param[STIFFNESS].number / sigma;
        const ss_body_plan body = {.name = "elastic-foundation",
                                   .plan = plan,
                                   .node_count = count,
                                   .mass = mass,
                                   .mass_damping = 60.0,
                                   .edge = ss_body_mean_edge(plan->mesh),
                                   .step_share = 0.5,
                                   .is_grounded = true,
                                   .elastic = {model, force, tangent, diagonal, stable_step}};
        status = ss_body_create(&body, &model->body, error);
        status = status == SOFTSIM_OK ? ss_body_start(model->body) : status;
    }
    ss_arena_free(&scratch);
    return status;
}

static double step_cost_us(const ss_model_plan *plan)
{
    return 2.0 + 0.02 * plan->mesh->node_count;
}

static void explain(const ss_model *model, const ss_notes *out)
{
    ss_note_used(out, "springs", "one a node, %.4g N/m by kg", model->rate2);
    ss_body_explain(model->body, out);
}

static const ss_model_hints hints = {
    .colour = "#444444",
    .about = "springs beside one another: the pressure under a tool, no dent around it",
    .on_surface = true,
    .has_force = true,
    .fitted = {{"stiffness_n_per_m3", false, 0.0}}};

SS_MODEL_CLASS(ss_model_elastic_foundation, "elastic-foundation",
               "a spring under every node: the pressure under a tool, no dent around it",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy,
                              ss_body_model_step, explain),
               SS_BODY_STATE(ss_body_model_info, SS_BODY_MOTION));
