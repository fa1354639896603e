/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
/*
 * Material of every element from the scene's rows, and what of it is refused, all in one go.
 *
 * A field has a value for each element, or at nodes: an element then takes the mean of its four, so
 * that a boundary between two tissues is as sharp as the mesh. The rows say E and nu or lambda and
 * mu; both must be positive as moduli: mu > 0 and K = lambda + 2/3 mu > 0.
 */
#include <math.h>

#include "mesh/tetrahedron.h"
#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Above this Poisson's ratio the cure for locking is on by itself. A second sweep makes a sub-step
 * 1.75 times as long, and the stable step is 1.2 to 1.7 times as long with it: at 0.45 a body takes
 * up to 1.4 times as long for two thirds of the error, from 0.49 on as long for a half to a sixth.
 */
#define CURED_RATIO 0.4501
/* Of mu: the part of lambda that an element keeps with the cure. Less of it lets pressures of
 * neighbouring nodes alternate, more of it locks. */
#define OWN_SHARE 0.5

static bool is_given(const ss_model_plan *plan, int row)
{
    return plan->param[row].is_given;
}

/* Which pair of moduli is given? Neither, both or halves of them are faults. */
static bool check_pair(const ss_model_plan *plan, const char *name, bool *out_is_young,
                       softsim_error *error)
{
    const int young = is_given(plan, SS_FEM_YOUNGS_MODULUS) + is_given(plan, SS_FEM_POISSON_RATIO);
    const int lame = is_given(plan, SS_FEM_LAMBDA) + is_given(plan, SS_FEM_MU);
    *out_is_young = young == 2;
    if ((young == 2 && lame == 0) || (young == 0 && lame == 2)) {
        return true;
    }
    softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                      "%s: give youngs_modulus_pa and poisson_ratio, or lame_lambda_pa and "
                      "lame_mu_pa%s",
                      name, young + lame == 0 ? "" : ": these two together and no other");
    return false;
}

/* False after a fault. */
static bool fill_moduli(const ss_model_plan *plan, const char *name, ss_fem_material *material,
                        softsim_error *error)
{
    bool is_young = false;
    ss_number_list bad = {0};
    if (!check_pair(plan, name, &is_young, error)) {
        return false;
    }
    for (int32_t e = 0; e < plan->mesh->tetrahedron_count; ++e) {
        double lambda = ss_plan_element_value(plan, SS_FEM_LAMBDA, e),
               mu = ss_plan_element_value(plan, SS_FEM_MU, e);
        if (is_young) {
            ss_tissue_lame(ss_plan_element_value(plan, SS_FEM_YOUNGS_MODULUS, e),
                           ss_plan_element_value(plan, SS_FEM_POISSON_RATIO, e), &lambda, &mu);
        }
        material->lambda[e] = lambda;
        material->mu[e] = mu;
        const double bulk = lambda + 2.0 / 3.0 * mu;
        if (!(mu > 0.0) || !(bulk > 0.0) || !isfinite(lambda) || !isfinite(mu)) {
            ss_number_list_add(&bad, ss_mesh_file_element(plan->mesh, e));
        }
    }
    if (bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: the moduli of %d elements (first %s) are not those of a stable "
                          "solid: lame_mu_pa and lame_lambda_pa + 2/3 lame_mu_pa must be above 0",
                          name, bad.count, bad.text);
    }
    return bad.count == 0;
}

/* The share of lambda that elements keep to themselves. */
static void fill_own(const ss_model_plan *plan, ss_fem_material *material)
{
    const double choice = plan->param[SS_FEM_LOCKING_CURE].number;
    for (int32_t e = 0; e < plan->mesh->tetrahedron_count; ++e) {
        const double lambda = material->lambda[e], mu = material->mu[e];
        const double ratio = lambda / (2.0 * (lambda + mu));
        const bool is_cured = choice == 2.0 || (choice == 0.0 && ratio > CURED_RATIO);
        material->lambda_own[e] = is_cured ? fmin(lambda, OWN_SHARE * mu) : lambda;
        material->is_averaged = material->is_averaged || material->lambda_own[e] < lambda;
    }
}

softsim_status ss_fem_material_read(const ss_model_plan *plan, const char *name, ss_arena *arena,
                                    ss_fem_material *out_material, softsim_error *error)
{
    const size_t n = (size_t)plan->mesh->tetrahedron_count;
    static const int viscosity[] = {SS_FEM_PHI, SS_FEM_PSI, SS_FEM_STIFFNESS_DAMPING};
    ss_fem_material material = {.kind = (ss_tissue_kind)plan->param[SS_FEM_MATERIAL].number,
                                .lambda = ss_arena_get(arena, n, sizeof(double)),
                                .mu = ss_arena_get(arena, n, sizeof(double)),
                                .lambda_own = ss_arena_get(arena, n, sizeof(double)),
                                .density = ss_arena_get(arena, n, sizeof(double)),
                                .mass_damping = plan->param[SS_FEM_MASS_DAMPING].number,
                                .integrator = plan->param[SS_FEM_INTEGRATOR].number != 0.0
                                                  ? SS_BODY_RK4
                                                  : SS_BODY_SYMPLECTIC_EULER};
    *out_material = material;
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const bool is_good = fill_moduli(plan, name, &material, error);
    for (size_t e = 0; e < n; ++e) {
        material.density[e] = ss_plan_element_value(plan, SS_FEM_DENSITY, (int32_t)e);
        material.lambda_own[e] = material.lambda[e];
    }
    ss_plan_viscosity(plan, viscosity, material.lambda, material.mu, arena, &material.phi,
                      &material.psi, &material.viscous_time);
    *out_material = material;
    if (ss_arena_status(arena) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_SCENE;
}

softsim_status ss_fem_material_create(const ss_model_plan *plan, const char *name, ss_arena *arena,
                                      ss_fem_material *out_material, softsim_error *error)
{
    const softsim_status status = ss_fem_material_read(plan, name, arena, out_material, error);
    if (status == SOFTSIM_OK) {
        fill_own(plan, out_material);
    }
    return status;
}

double ss_fem_node_rate(const ss_mesh *mesh, const ss_fem_material *material)
{
    double(*node)[2] = ss_memory_get((size_t)mesh->node_count, sizeof *node); /* K_ii, m_i */
    double largest = 0.0;
    for (int32_t e = 0; node && e < mesh->tetrahedron_count; ++e) {
        const int32_t *c = mesh->tetrahedron[e];
        const double(*x)[3] = (const double(*)[3])mesh->position;
        double gradient[4][3];
        const double volume =
            ss_tetrahedron_gradients(x[c[0]], x[c[1]], x[c[2]], x[c[3]], gradient);
        for (int a = 0; a < 4; ++a) {
            node[c[a]][0] += volume * (material->lambda[e] + 2.0 * material->mu[e]) *
                             ss_dot3(gradient[a], gradient[a]);
            node[c[a]][1] += 0.25 * volume * material->density[e];
        }
    }
    for (int32_t i = 0; node && i < mesh->node_count; ++i) {
        largest = node[i][1] > 0.0 ? fmax(largest, node[i][0] / node[i][1]) : largest;
    }
    ss_memory_free(node);
    return sqrt(largest);
}

double ss_fem_planned_sweeps(const ss_fem_material *material, double step, double rate,
                             double share)
{
    const double stable = ss_body_step_limit(material->integrator, rate * rate,
                                             material->viscous_time, material->mass_damping);
    return (material->integrator == SS_BODY_RK4 ? 4.0 : 1.0) * fmax(1.0, step / (share * stable));
}
