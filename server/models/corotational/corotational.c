/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/corotational/corotational.h"
#include "models/common/inverted.h"
/*
 * The model corotational: tetrahedra of linear elasticity that turn with the body (Mueller and
 * Gross, "Interactive virtual materials", 2004), stepped by implicit Euler: stable at any step and
 * stiffness, at the price of damping fast motions. For stiff scenes; what is soft and fast is
 * better served by fem. Masses, loads, tools and the energy balance are the body's (common/body.h).
 *
 * Where the nonlinearity comes from: the turning of each element, and contact; the strain that is
 * left is linear. Left out: cutting and tearing. Elements are the mesh's and stay.
 */
#include <math.h>
#include <string.h>

#include "mesh/tetrahedron.h"
#include "models/common/dispatch.h"
#include "models/common/plan.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/note.h"

SS_KERNEL_PATHS_512(ss_corot_kernels)

/* Microseconds a step, and a tetrahedron in it: ellipsoids of 3712 to 24,748 tetrahedra of 3 kPa at
 * 1 ms that swing under their weight; and how much more it is with a tool pressed deep into them.
 */
#define COST_STEP        2.0
#define COST_TETRAHEDRON 0.075
#define COST_TOOL        1.5
/* Above, linear tetrahedra are far too stiff: a bent beam of nu = 0.45 by a half. */
#define POISSON_WARNING 0.4

/* ---- set-up ---- */

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

static softsim_status allocate(ss_model *model)
{
    const size_t nodes = (size_t)model->scalar_count / 4;
    const size_t lanes = (size_t)model->blocks.count * SS_FEM_LANES;
    ss_arena *arena = &model->arena;
    ss_real **const quads[] = {
        &model->mass,     &model->elastic, &model->old_u,    &model->old_v,  &model->change,
        &model->velocity, &model->away,    &model->residual, &model->scaled, &model->search,
        &model->product,  &model->step,    &model->inverse,  &model->last,   &model->evaluated_u};
    for (size_t k = 0; k < sizeof quads / sizeof *quads; ++k) {
        *quads[k] = ss_arena_get(arena, 4 * nodes, sizeof(ss_real));
    }
    SS_ARENA_TAKE(arena, SS_ROOM(lanes * SS_FEM_SHAPES, model->turned),
                  SS_ROOM(lanes * SS_FEM_MODULI, model->system), SS_ROOM(nodes, model->stiff),
                  SS_ROOM(nodes, model->viscous), SS_ROOM(nodes, model->contact));
    return ss_arena_status(arena);
}

/* A third of the trace of the diagonal blocks: V (lambda + 4 mu) |grad N|^2 / 3. */
static void set_diagonals(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    const ss_corot_material *material = &model->material;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const int32_t *c = mesh->tetrahedron[t];
        double gradient[4][3];
        const double volume =
            ss_tetrahedron_gradients(mesh->position[c[0]], mesh->position[c[1]],
                                     mesh->position[c[2]], mesh->position[c[3]], gradient);
        for (int a = 0; a < 4; ++a) {
            const double third = volume * ss_dot3(gradient[a], gradient[a]) / 3.0;
            model->stiff[c[a]] += third * (material->lambda[t] + 4.0 * material->mu[t]);
            model->viscous[c[a]] +=
                material->phi ? third * (material->phi[t] + 4.0 * material->psi[t]) : 0.0;
        }
    }
    for (int32_t k = 0; k < 4 * model->node_count; ++k) {
        const ss_body_nodes *nodes = ss_body_read_nodes(model->body);
        model->mass[k] = nodes->mobility[k] > 0 ? (ss_real)nodes->mass[k / 4] : 0;
    }
}

static bool fill_blocks(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    const ss_corot_material *material = &model->material;
    const ss_fem_stuff stuff = {
        .node_count = mesh->node_count,
        .mesh = mesh,
        .moduli = {material->lambda, material->lambda, material->mu, material->phi, material->psi}};
    return ss_fem_blocks_create(&stuff, &model->arena, &model->blocks);
}

static void add_diagonal(void *owner, double *diagonal)
{
    const ss_model *model = owner;
    ss_fem_add_diagonal(model->node_count, model->stiff, diagonal);
}

static double stable_step(void *owner, const ss_body *body)
{
    (void)owner;
    (void)body;
    return (double)INFINITY;
}

static void forget(void *owner)
{
    ss_model *model = owner;
    model->is_evaluated = model->has_last = false;
    memset(model->last, 0, (size_t)model->scalar_count * sizeof *model->last);
    model->newton_count = model->product_count = model->evaluation_count = 0;
}

static uint64_t hash_last(const void *owner, uint64_t seed)
{
    const ss_model *model = owner;
    return ss_hash_bytes(seed, model->last, (size_t)model->scalar_count * sizeof *model->last);
}

static softsim_status create_body(ss_model *model, softsim_error *error)
{
    const ss_mesh *mesh = model->plan.mesh;
    double *mass = ss_memory_get((size_t)mesh->node_count, sizeof *mass);
    if (!mass) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_body_volume_masses(mesh, model->material.density, true, mass);
    const ss_body_plan plan = {.name = "corotational",
                               .plan = &model->plan,
                               .node_count = mesh->node_count,
                               .mass = mass,
                               .mass_damping = model->material.mass_damping,
                               .edge = model->edge,
                               .planned_step = (double)INFINITY,
                               .step_share = 1.0,
                               .elastic = {SS_BODY_ELASTIC(model, ss_corot_force, ss_corot_tangent,
                                                           add_diagonal, stable_step),
                                           .advance = ss_corot_advance, .reset = forget,
                                           .hash = hash_last,
                                           .viscous_time = model->material.viscous_time}};
    const softsim_status status = ss_body_create(&plan, &model->body, error);
    ss_memory_free(mass);
    return status;
}

static softsim_status build_on(ss_model *model, softsim_error *error)
{
    const ss_param_value *param = model->plan.param;
    softsim_status status =
        ss_corot_material_create(&model->plan, &model->arena, &model->material, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    model->has_viscosity = model->material.phi != NULL;
    model->edge = ss_body_mean_edge(model->plan.mesh);
    model->tolerance = param[SS_COROT_TOLERANCE].number;
    model->max_newton = (int32_t)param[SS_COROT_NEWTON_ITERATIONS].number;
    model->max_products = (int32_t)param[SS_COROT_SOLVER_ITERATIONS].number;
    status = create_body(model, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    model->scalar_count = 4 * ss_body_read_nodes(model->body)->padded_count;
    if (!fill_blocks(model) || allocate(model) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    set_diagonals(model);
    /* the tangent at rest, before anything has moved */
    ss_body_energy unused = {.is_wanted = true};
    ss_corot_force(model, model->old_u, model->old_v, model->residual, &unused);
    return ss_body_start(model->body);
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    model->plan = *plan;
    model->node_count = plan->mesh->node_count;
    model->kernels = ss_corot_kernels_get();
    const softsim_status status = build_on(model, error);
    model->plan.param = NULL;
    return status;
}

/* ---- the class ---- */

static double step_cost_us(const ss_model_plan *plan)
{
    const bool has_tool = ss_plan_tool_count(plan) > 0;
    return COST_STEP +
           COST_TETRAHEDRON * (has_tool ? COST_TOOL : 1.0) * plan->mesh->tetrahedron_count;
}

/* The last evaluation of the step is at its end. */
static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    ss_body_step(model->body, time, dt, tool);
    if (model->inverted_count > 0) {
        ss_body_judge(model->body, SOFTSIM_VERDICT_DEGRADED, 0, SS_INVERTED_REASON);
        ss_body_set_worst_element(model->body, model->first_inverted);
    }
}

static void explain(const ss_model *model, const ss_notes *out)
{
    const int64_t lanes = (int64_t)model->blocks.count * SS_FEM_LANES;
    const int64_t per_lane = (int64_t)sizeof(ss_real) * (2 * SS_FEM_SHAPES + 2 * SS_FEM_MODULI) +
                             4 * (int64_t)sizeof(int32_t);
    ss_note_used(out, "elements", "%d tetrahedra in blocks of 8 (%s), %lld bytes",
                 model->plan.mesh->tetrahedron_count, model->kernels->name,
                 (long long)(lanes * per_lane));
    ss_note_used(out, "step",
                 "implicit Euler, stable at any length; at most %d Newton iterations and %d "
                 "products, to %.3g of the residual",
                 model->max_newton, model->max_products, model->tolerance);
    ss_note_used(out, "solver", "conjugate gradients; no factor at any size");
    if (model->has_viscosity) {
        ss_note_used(out, "viscosity", "in the same products");
    } else {
        ss_note_left_out(out, "velocity pass", SS_PLAN_PUT_BACK_VISCOSITY, "no viscosity");
    }
    if (model->material.largest_poisson > POISSON_WARNING) {
        ss_note_warning(out, "model.poisson_ratio",
                        "Poisson's ratio up to %.4g: linear tetrahedra lock above %.2g and bend "
                        "too stiffly; refine the mesh, or use fem, which has a cure",
                        model->material.largest_poisson, POISSON_WARNING);
    }
    ss_body_explain(model->body, out);
}

static const ss_model_hints hints = {
    .colour = "#0072b2",
    .about = "linear elasticity that turns with the body: right while strains are small, whatever "
             "the rotations, and stable at any step",
    .has_force = true,
    .material = {"linear", "linear", "linear"},
    .fitted = {SS_HINTS_MODULI, {"viscosity_phi_pa_s", true, 0.0}}};

SS_MODEL_CLASS(ss_model_corotational, "corotational",
               "linear tetrahedra that turn with the body, stepped implicitly: for stiff scenes",
               SS_MODEL_PARTS(ss_model, &hints, ss_corot_rows, step_cost_us, build, destroy, step,
                              explain),
               SS_BODY_STATE(ss_body_model_info, SS_BODY_MOTION), .needs_volume = true);
