/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
/*
 * fem: a volume of linear tetrahedra under Green strain with viscous stress, explicit in time.
 *
 * After the finite element part of the hybrid model's paper (its eqs. (1) to (6), put right in
 * models/tissue_law.c), which takes its discretisation from O'Brien and Hodgins (1999). The elastic
 * body is ss_fem, everything else ss_body. Mass is lumped, so that an explicit step solves nothing.
 * Where the nonlinearity comes from: Green strain under a linear law (stvk), quadratic in the
 * displacement; the other laws are nonlinear of themselves, and the guard stiffens what is squeezed
 * below 0.65 of its volume. Left out: cutting and tearing. Elements are the mesh's and stay.
 * Rejected as a default: RK4 (four times the cost, and it loses energy), an implicit step (the
 * model `corotational` is that).
 */
#include <math.h>

#include "models/common/plan.h"
#include "rt/memory.h"

struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    ss_fem *fem;
    ss_fem_material material;
};

static const ss_param_row rows[SS_FEM_ROW_COUNT] = {SS_FEM_ROWS};

/* ---- cost ---- */

/* Microseconds a sub-step of an element with its share of a node, elastic, viscous, cured, and of
 * an outer step by itself; measured on ellipsoids of 5k to 100k elements with one tool. */
#define COST_ELASTIC 0.0058
#define COST_VISCOUS 0.0022
#define COST_CURE    0.0042
#define COST_STEP    5.0
#define COST_TOOL    15.0

static double step_cost_us(const ss_model_plan *plan)
{
    ss_arena arena = {0};
    ss_fem_material material;
    double cost = COST_STEP;
    if (ss_fem_material_create(plan, "fem", &arena, &material, NULL) == SOFTSIM_OK) {
        const double element = COST_ELASTIC + (material.phi ? COST_VISCOUS : 0.0) +
                               (material.is_averaged ? COST_CURE : 0.0);
        const double sweeps =
            ss_fem_planned_sweeps(&material, ss_plan_cost_step(plan),
                                  ss_fem_node_rate(plan->mesh, &material), SS_FEM_STEP_SHARE);
        cost += sweeps * element * plan->mesh->tetrahedron_count;
    }
    ss_arena_free(&arena);
    return cost + COST_TOOL * ss_plan_tool_count(plan);
}

/* ---- life ---- */

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_fem_destroy(&model->fem);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

static softsim_status build_on(ss_model *model, const ss_model_plan *plan, double *mass,
                               softsim_error *error)
{
    softsim_status status =
        ss_fem_material_create(plan, "fem", &model->arena, &model->material, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_body_volume_masses(plan->mesh, model->material.density, true, mass);
    const ss_fem_setup setup = {.mesh = plan->mesh,
                                .material = &model->material,
                                .node_count = plan->mesh->node_count,
                                .mass = mass,
                                .fixed = plan->fixed};
    status = ss_fem_create(&setup, &model->fem);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const ss_body_plan body = ss_fem_plan_body(model->fem, plan, &model->material, mass);
    status = ss_body_create(&body, &model->body, error);
    if (status == SOFTSIM_OK) {
        model->fem->u = ss_body_read_nodes(model->body)->u;
        status = ss_body_start(model->body);
    }
    return status;
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    double *mass = ss_memory_get((size_t)plan->mesh->node_count, sizeof *mass);
    const softsim_status status = mass ? build_on(model, plan, mass, error) : SOFTSIM_ERROR_MEMORY;
    ss_memory_free(mass);
    return status;
}

/* ---- the class ---- */

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    ss_body_step(model->body, time, dt, tool);
    ss_fem_judge(model->fem, model->body);
    if (model->material.kind == SS_TISSUE_LINEAR) { /* which does not know */
        ss_body_judge_inverted(model->body, false);
    }
}

static void explain(const ss_model *model, const ss_notes *out)
{
    ss_fem_explain(model->fem, &model->material, out);
    ss_body_explain(model->body, out);
}

static const ss_hints_variant variants[] = {
    {.name = "fem stable-neo-hookean",
     .text = "  material: stable-neo-hookean\n",
     .knob = SS_HINTS_SOLID},
    {.name = "fem stvk-guarded", .text = "  material: stvk-guarded\n", .knob = SS_HINTS_SOLID},
};
/* Of stvk-guarded, uncured. */
static void sweep_work(bool is_viscous, double *out_bytes, double *out_flops)
{
    ss_fem_work(SS_TISSUE_STVK_GUARDED, is_viscous, out_bytes, out_flops);
}

static const ss_model_hints hints = {
    .colour = "#d55e00",
    .about = "solves the stated material; what is left is the mesh, which bends and squeezes too "
             "stiffly while it is coarse",
    .has_force = true,
    .material = SS_HINTS_ANY_LAW,
    .fitted = {SS_HINTS_MODULI, SS_HINTS_VISCOSITIES},
    .work = sweep_work,
    .variant = variants,
    .variant_count = sizeof variants / sizeof *variants};

SS_MODEL_CLASS(ss_model_fem, "fem",
               "a volume of tetrahedra with Green strain and viscous stress, explicit in time",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy, step, explain),
               SS_BODY_STATE(ss_body_model_info, SS_BODY_MOTION), .needs_volume = true);
