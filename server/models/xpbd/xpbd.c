/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
#include "models/xpbd/kernels.h"
/*
 * xpbd: extended position-based dynamics of neo-Hookean tetrahedra in small steps.
 *
 * A step is cut in sub-steps, each of one sweep over the constraints (Macklin et al., "Small steps
 * in physics simulation", 2019):
 *
 *   d = h (v / (1 + alpha h) + h W f_external),  one sweep of constraints on u + d that changes d,
 *   v+ = d / h,  u+ = u + d
 *
 * with d kept apart from u: v as a difference of positions has no digits left in small steps.
 * kernels.c derives the constraint of a tetrahedron. The sweep is Gauss-Seidel over packs of
 * eight elements that share no node, in the same order every time: taking it backwards in turn
 * makes what one sweep leaves over alternate, which v takes for motion, and it blows up. So it is
 * stable at any step and stiffness. What it solves is implicit Euler but for what one sweep leaves
 * over: a body that the sub-step is too long for is softer than its law (some 3 % where h is the
 * stable step of an explicit method, and as h^2) and damped. That is said, in the verdict; with
 * enough sub-steps the body is that of the law. The laws are
 * those whose energy is one of |F| and J: stable-neo-hookean and neo-hookean.
 *
 * Tools act by the penalty of the shared body, at the start of a sub-step, and the contact's
 * stiffness goes by the sub-step, which is short: tools, energies and the stiffness that a hand
 * feels are then the same as in every other model. Rejected: tools as position constraints, whose
 * force is known only up to the compliance that one sweep adds, and jumps as samples come and go.
 * Prescribed axes are where they belong, exactly, before the sweep. Forces, energy and tangent that
 * are told (reactions, status, stiffness) are the law's at the end of a step.
 *
 * Where the nonlinearity comes from: the law, which is one of finite strain, and contact. Left out:
 * cutting and tearing. Elements are the mesh's and stay.
 */
#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/note.h"

/* The rows of elasticity and density, then these. */
enum { ROW_MASS_DAMPING = SS_FEM_DENSITY + 1, ROW_SUBSTEP, ROW_COUNT };

/* Constraints of |F| and J are these laws and no others, numbered from the first. */
enum { FIRST_LAW = SS_TISSUE_NEO_HOOKEAN, LAST_LAW = SS_TISSUE_STABLE_NEO_HOOKEAN };
_Static_assert(LAST_LAW == FIRST_LAW + 1, "both laws, and nothing between them");

static const ss_param_row rows[ROW_COUNT] = {
    SS_FEM_SOLID_ROWS("neo-hookean|stable-neo-hookean", LAST_LAW - FIRST_LAW, LAST_LAW - FIRST_LAW),
    [ROW_MASS_DAMPING] =
        SS_PARAM(NUMBER, "mass_damping_per_s",
                 "damping per mass: it damps all modes, and free flight", SS_FROM(0, 1e9)),
    [ROW_SUBSTEP] = SS_PARAM(NUMBER, "substep_s",
                             "longest sub-step, a sweep each: shorter ones are stiffer, less "
                             "damped and nearer to the law",
                             SS_ABOVE(0, 1.0), .fallback = 1e-4)};

/* The body asks for this share of a step that it takes for the limit; that is twice the sub-step,
 * so that a contact's stiffness leaves margin. */
#define STEP_SHARE 0.5
/* Of the stable step of an explicit method: sub-steps up to it are softer than the law by less
 * than what the energy balance looks at. */
#define EXACT_SHARE 0.3
/* Microseconds a sub-step of an element, of a step by itself and with a tool. */
#define COST_ELEMENT 0.02
#define COST_STEP    10.0
#define COST_TOOL    30.0

struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    ss_fem *fem; /* forces, energy and tangent of the law */
    ss_fem_material material;
    const ss_xpbd_kernels *kernels;
    ss_xpbd_packs packs;
    ss_real *way;   /* of the nodes in a sub-step, m */
    double substep; /* s, as planned */
    double least;   /* J of the most squeezed element in the step */
    double longest; /* s, of the sub-steps in the step */
};

/* ---- steps ---- */

static double stable_step(void *owner, const ss_body *body)
{
    const ss_model *model = owner;
    (void)body;
    return model->substep / STEP_SHARE;
}

static void advance(void *owner, ss_body *body, double h, double path_end)
{
    ss_model *model = owner;
    ss_body_nodes *nodes = ss_body_get_nodes(body);
    const int32_t n = nodes->padded_count;
    (void)path_end;
    ss_body_external(body, nodes->u, ss_body_path_start(body));
    model->kernels->predict(n, h, 1.0 / (1.0 + ss_body_mass_damping(body) * h), nodes->mobility,
                            nodes->force, nodes->v, model->way);
    ss_xpbd_pass pass = {.packs = &model->packs,
                         .kind = model->material.kind,
                         .h = h,
                         .u = nodes->u,
                         .mobility = nodes->mobility,
                         .step = model->way,
                         .least = model->least};
    model->kernels->constrain(&pass);
    model->least = pass.least;
    model->longest = fmax(model->longest, h);
    model->kernels->finish(n, h, nodes->mobility, model->way, nodes->u, nodes->v);
}

static void force(void *owner, const ss_real *u, const ss_real *v, ss_real *out_force,
                  ss_body_energy *out)
{
    const ss_model *model = owner;
    ss_fem_force(model->fem, u, v, out_force, out);
    out->elastic_is_upper_bound = model->longest > EXACT_SHARE * ss_fem_rest_step(model->fem);
}

static void tangent(void *owner, const ss_real *x, ss_real *out)
{
    ss_fem_tangent(((ss_model *)owner)->fem, x, out);
}

static void diagonal(void *owner, double *out)
{
    ss_fem_diagonal(((ss_model *)owner)->fem, out);
}

static void reset_state(void *owner)
{
    ss_model *model = owner;
    model->least = 1.0;
    ss_fem_reset(model->fem);
}

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    model->least = 1.0;
    model->longest = 0.0;
    ss_body_step(model->body, time, dt, tool);
    if (model->least < 0.0) {
        ss_body_judge(model->body, SOFTSIM_VERDICT_GUARDED, 0,
                      "an element was inside out and is being turned back");
    }
    ss_body_judge_inverted(model->body, false);
    if (model->longest > ss_fem_rest_step(model->fem)) {
        ss_body_judge(model->body, SOFTSIM_VERDICT_GUARDED, 0,
                      "softer than its law: shorter sub-steps would be nearer");
    }
}

/* ---- life ---- */

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_fem_destroy(&model->fem);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

/* What ss_fem reads beyond the rows of this model: nothing but elasticity. */
static softsim_status read_material(ss_model *model, const ss_model_plan *plan,
                                    softsim_error *error)
{
    ss_param_value value[SS_FEM_ROW_COUNT] = {{0}};
    ss_model_plan own = *plan;
    memcpy(value, plan->param, (SS_FEM_DENSITY + 1) * sizeof *value);
    value[SS_FEM_MATERIAL].number += FIRST_LAW;
    value[SS_FEM_LOCKING_CURE].number = 1.0; /* none */
    own.param = value;
    return ss_fem_material_create(&own, "xpbd", &model->arena, &model->material, error);
}

static softsim_status create_body(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    const ss_mesh *mesh = plan->mesh;
    double *mass = ss_memory_get((size_t)mesh->node_count, sizeof *mass);
    if (!mass) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_body_volume_masses(mesh, model->material.density, true, mass);
    const ss_fem_setup setup = {.mesh = mesh,
                                .material = &model->material,
                                .node_count = mesh->node_count,
                                .mass = mass,
                                .fixed = plan->fixed};
    softsim_status status = ss_fem_create(&setup, &model->fem);
    const ss_body_plan body = {
        .name = "xpbd",
        .plan = plan,
        .node_count = mesh->node_count,
        .mass = mass,
        .mass_damping = plan->param[ROW_MASS_DAMPING].number,
        .edge = ss_body_mean_edge(mesh),
        .step_share = STEP_SHARE,
        .elastic = {SS_BODY_ELASTIC(model, force, tangent, diagonal, stable_step),
                    .advance = advance, .reset = reset_state}};
    if (status == SOFTSIM_OK) {
        status = ss_body_create(&body, &model->body, error);
    }
    ss_memory_free(mass);
    return status;
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    const ss_mesh *mesh = plan->mesh;
    softsim_status status = read_material(model, plan, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    model->kernels = ss_xpbd_kernels_get();
    /* Stable at any length: the budget makes them longer, not the body slower. */
    model->substep = fmax(plan->param[ROW_SUBSTEP].number, plan->step / plan->max_substeps);
    status = create_body(model, plan, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const ss_body_nodes *nodes = ss_body_read_nodes(model->body);
    model->way = ss_arena_get(&model->arena, (size_t)nodes->padded_count * 4, sizeof *model->way);
    if (!model->way ||
        !ss_xpbd_packs_create(mesh->tetrahedron_count, (const int32_t(*)[4])mesh->tetrahedron,
                              (const double(*)[3])mesh->position, model->material.lambda,
                              model->material.mu, nodes->mobility, &model->arena, &model->packs)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    return ss_body_start(model->body);
}

/* ---- the class ---- */

static double step_cost_us(const ss_model_plan *plan)
{
    const double substeps =
        fmin(ceil(ss_plan_cost_step(plan) / plan->param[ROW_SUBSTEP].number - 1e-9),
             (double)plan->max_substeps);
    return COST_STEP + COST_ELEMENT * substeps * plan->mesh->tetrahedron_count +
           COST_TOOL * ss_plan_tool_count(plan);
}

static void info(const ss_model *model, ss_model_info *out)
{
    ss_body_info(model->body, out);
    out->stable_step = ss_fem_rest_step(model->fem); /* it has none; up to here it is the law's */
}

static void explain(const ss_model *model, const ss_notes *out)
{
    const double lanes = 8.0 * model->packs.count;
    ss_note_used(
        out, "constraints",
        "%d tetrahedra of %s in %d packs of 8 without common nodes (%.3g %% of the lanes), %s "
        "kernels",
        model->packs.element_count, ss_tissue_name(model->material.kind), model->packs.count,
        100.0 * model->packs.element_count / lanes, model->kernels->name);
    const double limit = ss_fem_rest_step(model->fem);
    ss_note_used(out, "sub-steps", "at most %.4g s, one sweep each; explicit ones: %.4g s",
                 model->substep, limit);
    if (model->substep > limit) {
        ss_note_warning(out, "model.substep_s",
                        "the body is softer than its law; substep_s: %.3g would be enough, with a "
                        "step that max_substeps allows",
                        limit);
    }
    ss_body_explain(model->body, out);
}

static const ss_hints_variant variant = {
    .name = "xpbd", .text = "  material: stable-neo-hookean\n", .knob = SS_HINTS_SOLID};
static const ss_model_hints hints = {
    .colour = "#009e73",
    .about = "a stable neo-Hookean material by position corrections: close to it once a step has "
             "enough of them, softer or stiffer by as much as it lacks",
    .has_force = true,
    .material = {"stable-neo-hookean", "stable-neo-hookean", "neo-hookean"},
    .fitted = {SS_HINTS_MODULI, {"mass_damping_per_s", true, 0.0}},
    .variant = &variant,
    .variant_count = 1};

SS_MODEL_CLASS(ss_model_xpbd, "xpbd",
               "neo-Hookean tetrahedra by extended position-based dynamics in small steps",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy, step, explain),
               SS_BODY_STATE(info, SS_BODY_MOTION), .needs_volume = true);
