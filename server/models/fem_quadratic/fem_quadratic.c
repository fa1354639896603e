/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * fem-quadratic: a volume of ten-node tetrahedra with split volume energy, explicit in time.
 *
 * Displacements are quadratic in each element: u = sum_a N_a u_a, corners N_k = l_k (2 l_k - 1),
 * edges N_kj = 4 l_k l_j. A linear tetrahedron has one constant strain, which bends and squeezes
 * too stiffly while the mesh is coarse; this one has strains that vary linearly, for ten nodes and
 * a longer step at the same error.
 *
 *   W = sum_q V_q w(lambda_own; H_q) + V (lambda - lambda_own)/2 mean(theta)^2
 *
 * over the four Gauss points q of degree 2, V_q = V/4 in straight elements, w any law of
 * models/tissue_law.h, theta the dilatation that its lambda resists (J - 1; tr E of stvk; tr e of
 * linear) and mean(theta) = sum_q V_q theta_q / V. lambda_own + 2/3 mu = kappa mu, at most all:
 * `volume_split` is kappa. All of lambda at four points locks near nu = 0.5, none of it there
 * leaves motions without energy; one constant dilatation an element is the mixed form of Simo,
 * Taylor and Pister (1985), where it takes the whole of the volume's energy. They leave open how it
 * is split; here it is by moduli. Rejected: the dilatation at the centroid in place of the mean,
 * which is the same for small strain but does not balance a constant pressure in a curved element.
 *
 * Below J = 0.3 the factor J^(-2/3) of neo-hookean goes on as a straight line: with the law's own
 * parabola a tangled body is thrown apart.
 *
 * The rest: explicit total Lagrangian dynamics (Miller et al. 2007), masses in mass.c, forces in
 * kernels.c, the mid-edge nodes in raise.c, the stable step in stability.c; everything else, tools
 * and loads and supports, is ss_body on the raised mesh.
 */
#include <math.h>

#include "models/common/plan.h"

#include "rt/memory.h"

struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    ss_quadratic quadratic;
    ss_quadratic_raised raised;
    ss_quadratic_skin skin;
    ss_fem_material material;
};

enum {
    VOLUME_SPLIT = SS_FEM_LOCKING_CURE, /* in its place */
    MASS_SCALING,
    CURVED,
    ROW_COUNT
};

static const ss_param_row rows[ROW_COUNT] = {
    SS_FEM_SOLID_ROWS(SS_TISSUE_CHOICES, SS_TISSUE_KIND_COUNT - 1, SS_TISSUE_STVK_GUARDED),
    SS_FEM_DAMPING_ROWS,
    [VOLUME_SPLIT] = SS_PARAM(NUMBER, "volume_split",
                              "bulk modulus over mu that each Gauss point resists by itself; the "
                              "element's mean dilatation meets the rest",
                              SS_FROM(0.1, 10.0), .fallback = 1.0),
    [MASS_SCALING] = SS_PARAM(NUMBER, "mass_scaling_max",
                              "share of the whole mass that may be added to the elements with the "
                              "shortest step",
                              SS_FROM(0.0, 0.2), .fallback = 0.025),
    [CURVED] = SS_PARAM(CHOICE, "curved",
                        "auto: edges go through the mid-edge nodes of a mesh of second order, "
                        "else those of the surface follow object.surface, or its own "
                        "normals where it is smooth; no: all are straight",
                        .range.max = 1.0, .choices = "auto|no"),
};

/* ---- cost ---- */

/* Microseconds a sub-step of an element, elastic and viscous, with its nodes, and of an outer step
 * by itself. */
#define COST_ELASTIC 0.04
#define COST_VISCOUS 0.025
#define COST_STEP    5.0
#define COST_TOOL    15.0
/* omega_max over that of linear elements, with mass added: 1.5 to 2.3 on slab, ellipsoid,
 * ventricle, organs and a regular block. */
#define SIDES_RATE 2.0

static double step_cost_us(const ss_model_plan *plan)
{
    ss_arena arena = {0};
    ss_fem_material material;
    double cost = COST_STEP;
    if (ss_fem_material_read(plan, "fem-quadratic", &arena, &material, NULL) == SOFTSIM_OK) {
        const double element = COST_ELASTIC + (material.phi ? COST_VISCOUS : 0.0);
        const double rate = SIDES_RATE * ss_fem_node_rate(plan->mesh, &material);
        cost += ss_fem_planned_sweeps(&material, ss_plan_cost_step(plan), rate,
                                      SS_QUADRATIC_STEP_SHARE) *
                element * plan->mesh->tetrahedron_count;
    }
    ss_arena_free(&arena);
    return cost + COST_TOOL * ss_plan_tool_count(plan);
}

/* ---- life ---- */

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

/* What each point resists of lambda by itself. */
static void split(const ss_model_plan *plan, ss_fem_material *material)
{
    const double kappa = plan->param[VOLUME_SPLIT].number;
    for (int32_t e = 0; e < plan->mesh->tetrahedron_count; ++e) {
        material->lambda_own[e] = fmin(material->lambda[e], (kappa - 2.0 / 3.0) * material->mu[e]);
    }
}

/* A part of the skin is one sample where the smallest tool is much larger than that, else sixteen:
 * with fewer the force of a sliding ball changes by more than 0.5 % in 1 ms. */
#define COARSE_PARTS 0.25

/* How far beyond a tool skin follows every sub-step, in edges: the search reaches 1.5 times the
 * larger of an edge and half a radius beyond the tool, to triangles that lean on their neighbours'
 * corners. */
#define SKIN_EDGES 8.0

static softsim_status add_skin(ss_model *model)
{
    ss_model_plan *plan = &model->raised.plan;
    ss_quadratic_skin *skin = &model->skin;
    const softsim_status status =
        ss_quadratic_skin_create(&model->raised, model->quadratic.masses.mass, &model->arena, skin);
    if (plan->contact_parts == 0) {
        const bool is_fine = skin->edge < COARSE_PARTS * ss_plan_smallest_tool(plan);
        plan->contact_parts = is_fine ? SS_SURFACE_CENTROIDS : 1;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            skin->reach[k] = 2.0 * ss_shape_bounding_radius(&plan->tool[k].shape) +
                             2.0 * plan->contact_reach + SKIN_EDGES * skin->edge;
        }
    }
    model->quadratic.skin = skin;
    return status;
}

/* Of the stable step at rest: what the contact's stiffness is chosen for. With longer ones it is
 * softer, and a ball that slides over coarse faces feels more of them. */
#define CONTACT_STEP_SHARE 0.75

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    ss_quadratic_raised *raised = &model->raised;
    softsim_status status =
        ss_fem_material_read(plan, "fem-quadratic", &model->arena, &model->material, error);
    if (status == SOFTSIM_OK && plan->surface &&
        (plan->mesh->middle || plan->param[CURVED].number != 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "fem-quadratic: object.surface %s",
                          plan->mesh->middle
                              ? "is for a mesh of first order, and this one has mid-edge nodes of "
                                "its own: leave one of the two out"
                              : "is followed by curved edges: leave it out, or curved: no");
        status = SOFTSIM_ERROR_SCENE;
    }
    if (status == SOFTSIM_OK) {
        split(plan, &model->material);
        status = ss_quadratic_raise(plan, plan->param[CURVED].number == 0.0, &model->arena, raised,
                                    error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_quadratic_create(raised, &model->material, plan->param[MASS_SCALING].number,
                                     &model->arena, &model->quadratic);
    }
    if (status == SOFTSIM_OK && ss_plan_tool_count(plan) > 0) {
        status = add_skin(model);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    const ss_body_plan body = {
        .name = "fem-quadratic",
        .plan = &raised->plan,
        .node_count = raised->mesh.node_count,
        .mass = model->quadratic.masses.mass,
        .unweighed = model->quadratic.masses.added,
        .mass_damping = model->material.mass_damping,
        .edge = 0.5 * ss_body_mean_edge(plan->mesh), /* between neighbouring nodes */
        .planned_step = CONTACT_STEP_SHARE * ss_quadratic_rest_step(&model->quadratic),
        .step_share = SS_QUADRATIC_STEP_SHARE,
        .integrator = model->material.integrator,
        .skin = {.mesh = model->quadratic.skin ? &model->skin.mesh : NULL,
                 .sigma = model->skin.sigma,
                 .lay = ss_quadratic_skin_lay,
                 .carry = ss_quadratic_skin_carry,
                 .carry_diagonal = ss_quadratic_skin_carry_diagonal,
                 .rate2 = ss_quadratic_skin_rate2},
        .elastic = {SS_BODY_ELASTIC(&model->quadratic, ss_quadratic_force, ss_quadratic_tangent,
                                    ss_quadratic_diagonal, ss_quadratic_stable_step),
                    .viscous_time = model->material.viscous_time, .reset = ss_quadratic_reset,
                    .hash = ss_quadratic_hash}};
    status = ss_body_create(&body, &model->body, error);
    if (status == SOFTSIM_OK) {
        model->quadratic.u = ss_body_read_nodes(model->body)->u;
        status = ss_body_start(model->body);
    }
    return status;
}

/* ---- the class ---- */

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    if (model->quadratic.skin && tool) {
        ss_quadratic_skin_list(&model->skin, ss_body_read_nodes(model->body)->u, tool);
    }
    ss_body_step(model->body, time, dt, tool);
    ss_quadratic_judge(&model->quadratic, model->body);
}

/* Counted in kernels.c, of stable neo-Hookean in a straight element: gathers 27 differences, bases
 * 60; a point's gradient 36 + 45, dilatation 26, stress 190, forces 45 + 36; the end 90. */
static void sweep_work(bool is_viscous, double *out_bytes, double *out_flops)
{
    const int values = SS_FEM_SHAPES + SS_QUADRATIC_MODULI + (is_viscous ? 2 : 0);
    *out_bytes = (double)(values * (int)sizeof(ss_real) + SS_QUADRATIC_NODES * 4);
    *out_flops = 1690.0 + (is_viscous ? 700.0 : 0.0);
}

static void explain(const ss_model *model, const ss_notes *out)
{
    const ss_quadratic *own = &model->quadratic;
    const ss_quadratic_masses *masses = &model->quadratic.masses;
    double bytes, flops;
    sweep_work(own->blocks.viscosity != NULL, &bytes, &flops);
    ss_note_used(out, "ten-node tetrahedra",
                 "%d of %s on %d nodes, of which %d are in the file, %s kernels, %.0f bytes each a "
                 "sweep where straight",
                 own->blocks.element_count, ss_tissue_name(own->kind), own->blocks.node_count,
                 model->raised.given_count, own->kernels->name, bytes);
    if (model->raised.curved_edge_count > 0) {
        ss_note_used(out, "curved edges", "%d %s, %d more would bend an element too far",
                     model->raised.curved_edge_count,
                     model->raised.is_second_order ? "go through the file's nodes"
                     : model->raised.plan.surface  ? "follow object.surface"
                                                   : "follow the surface's normals",
                     model->raised.straightened_edge_count);
    } else {
        ss_note_left_out(out, "curved edges", NULL, "%s",
                         "none of the surface is smooth, or curved: no");
    }
    ss_note_used(
        out, "mass scaling",
        "%.2g %% of the mass added to %d elements: no step is certain to be stable without "
        "it beyond %.4g s, with it %.4g s",
        100.0 * masses->added_share, masses->scaled_count, 2.0 / sqrt(masses->plain_bound),
        2.0 / sqrt(masses->bound));
    if (own->blocks.viscosity) {
        ss_note_used(out, "viscosity", "at most %.4g s of the elastic stiffness",
                     own->viscous_time);
    } else {
        ss_note_left_out(out, "velocity pass", SS_PLAN_PUT_BACK_VISCOSITY, "no viscosity");
    }
    ss_note_used(out, "stable step of the elastic body",
                 "%.4g s by power iteration, of which %.2g is taken", ss_quadratic_rest_step(own),
                 SS_QUADRATIC_STEP_SHARE);
    ss_body_explain(model->body, out);
}

static void tell_shape(const ss_model *model, ss_model_shape *out)
{
    *out = (ss_model_shape){.mesh = &model->raised.mesh, .fixed = model->raised.plan.fixed};
}

static const ss_hints_variant variants[] = {
    {.name = "fem-quadratic stable-neo-hookean",
     .text = "  material: stable-neo-hookean\n",
     .books_own_work = true,
     .knob = SS_HINTS_SOLID},
    {.name = "fem-quadratic neo-hookean",
     .text = "  material: neo-hookean\n",
     .books_own_work = true,
     .knob = SS_HINTS_SOLID},
};
static const ss_model_hints hints = {
    .colour = "#009e73",
    .about = "solves the stated material on tetrahedra with a node on every edge: the lowest error "
             "at a time budget",
    .has_force = true,
    .material = SS_HINTS_ANY_LAW,
    .fitted = {SS_HINTS_MODULI, SS_HINTS_VISCOSITIES},
    .work = sweep_work,
    .variant = variants,
    .variant_count = sizeof variants / sizeof *variants};

SS_MODEL_CLASS(ss_model_fem_quadratic, "fem-quadratic",
               "a volume of ten-node tetrahedra with split volume energy, explicit in time",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy, step, explain),
               SS_BODY_STATE(ss_body_model_info, SS_BODY_MOTION), .needs_volume = true,
               .takes_second_order = true, .shape = tell_shape);
