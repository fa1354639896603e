/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/corotational/corotational.h"
/*
 * Parameters to values of every element. All that is wrong is named in one go.
 */
#include <math.h>

#include "models/common/plan.h"

const ss_param_row ss_corot_rows[SS_COROT_ROW_COUNT] = {
    SS_PARAM(CHOICE, "material",
             "small strain in each element, turned with it; for other laws use the model fem",
             .choices = "linear"),
    SS_PARAM(FIELD, "youngs_modulus_pa",
             "stiffness, with poisson_ratio; or give lame_lambda_pa and lame_mu_pa",
             .takes_elements = true, SS_ABOVE(0, 1e13), .fallback = SS_ABSENT),
    SS_PARAM(FIELD, "poisson_ratio", "0.5 would be incompressible; linear tetrahedra lock near it",
             .takes_elements = true, SS_FROM(-0.99, 0.4999), .fallback = SS_ABSENT),
    SS_PARAM(FIELD, "lame_lambda_pa", "in place of youngs_modulus_pa and poisson_ratio",
             .takes_elements = true, SS_FROM(-1e13, 1e17), .fallback = SS_ABSENT),
    SS_PARAM(FIELD, "lame_mu_pa", "shear modulus", .takes_elements = true, SS_ABOVE(0, 1e13),
             .fallback = SS_ABSENT),
    SS_PARAM(FIELD, "density_kg_m3", "mass per volume", .takes_elements = true, SS_ABOVE(0, 1e9),
             .fallback = 1000.0),
    SS_PARAM(FIELD, "viscosity_phi_pa_s", "viscosity of dilatation", .takes_elements = true,
             SS_FROM(0, 1e12)),
    SS_PARAM(FIELD, "viscosity_psi_pa_s", "viscosity of shear", .takes_elements = true,
             SS_FROM(0, 1e12)),
    SS_PARAM(NUMBER, "stiffness_damping_s",
             "viscosity in proportion to stiffness, added to the two above", SS_FROM(0, 1e3)),
    SS_PARAM(NUMBER, "mass_damping_per_s",
             "damping in proportion to mass; the method itself damps fast motions",
             SS_FROM(0, 1e6)),
    SS_PARAM(NUMBER, "solver_tolerance",
             "residual of a step's equation that is left, as a share of what it began with",
             SS_FROM(1e-12, 0.1), .fallback = 3e-3),
    SS_PARAM(INTEGER, "newton_iterations", "at most, in a step; one is usual, two in contact",
             SS_FROM(1.0, 100.0), .fallback = 6.0),
    SS_PARAM(INTEGER, "solver_iterations", "of conjugate gradients, at most, in a step",
             SS_FROM(1.0, 10000.0), .fallback = 200.0),
};

/* Which pair of constants is given; false after a fault. */
static bool choose_pair(const ss_model_plan *plan, bool *out_is_lame, softsim_error *error)
{
    const ss_param_value *param = plan->param;
    const bool has_young = param[SS_COROT_YOUNGS_MODULUS].is_given;
    const bool has_poisson = param[SS_COROT_POISSON_RATIO].is_given;
    const bool has_lambda = param[SS_COROT_LAME_LAMBDA].is_given;
    const bool has_mu = param[SS_COROT_LAME_MU].is_given;
    *out_is_lame = has_lambda && has_mu;
    const bool is_young = has_young && has_poisson && !has_lambda && !has_mu;
    const bool is_lame = has_lambda && has_mu && !has_young && !has_poisson;
    if (!is_young && !is_lame) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "corotational: give youngs_modulus_pa and poisson_ratio, or "
                          "lame_lambda_pa and lame_mu_pa: one pair, all of it");
    }
    return is_young || is_lame;
}

static softsim_status fill(const ss_model_plan *plan, ss_corot_material *material,
                           softsim_error *error)
{
    bool is_lame;
    int32_t bad_count = 0, first_bad = -1;
    if (!choose_pair(plan, &is_lame, error)) {
        return SOFTSIM_ERROR_SCENE;
    }
    const int one = is_lame ? SS_COROT_LAME_LAMBDA : SS_COROT_YOUNGS_MODULUS;
    const int two = is_lame ? SS_COROT_LAME_MU : SS_COROT_POISSON_RATIO;
    for (int32_t t = 0; t < plan->mesh->tetrahedron_count; ++t) {
        double *lambda = &material->lambda[t], *mu = &material->mu[t];
        *lambda = ss_plan_element_value(plan, one, t);
        *mu = ss_plan_element_value(plan, two, t);
        if (!is_lame) {
            ss_tissue_lame(*lambda, *mu, lambda, mu);
        }
        material->density[t] = ss_plan_element_value(plan, SS_COROT_DENSITY, t);
        const bool is_good = *mu > 0.0 && 3.0 * *lambda + 2.0 * *mu > 0.0 && isfinite(*lambda);
        first_bad = is_good || bad_count > 0 ? first_bad : t;
        bad_count += !is_good;
        material->largest_poisson =
            fmax(material->largest_poisson, 0.5 * *lambda / (*lambda + *mu));
    }
    if (bad_count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "corotational: %d elements (first %d) have constants that no stable "
                          "material has: lame_mu_pa and 3 lame_lambda_pa + 2 lame_mu_pa must be "
                          "above 0",
                          bad_count, ss_mesh_file_element(plan->mesh, first_bad));
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
}

softsim_status ss_corot_material_create(const ss_model_plan *plan, ss_arena *arena,
                                        ss_corot_material *out_material, softsim_error *error)
{
    const size_t count = (size_t)plan->mesh->tetrahedron_count;
    static const int viscosity[] = {SS_COROT_VISCOSITY_PHI, SS_COROT_VISCOSITY_PSI,
                                    SS_COROT_STIFFNESS_DAMPING};
    *out_material = (ss_corot_material){.lambda = ss_arena_get(arena, count, sizeof(double)),
                                        .mu = ss_arena_get(arena, count, sizeof(double)),
                                        .density = ss_arena_get(arena, count, sizeof(double)),
                                        .mass_damping = plan->param[SS_COROT_MASS_DAMPING].number};
    softsim_status status = ss_arena_status(arena);
    status = status == SOFTSIM_OK ? fill(plan, out_material, error) : status;
    if (status == SOFTSIM_OK) {
        ss_plan_viscosity(plan, viscosity, out_material->lambda, out_material->mu, arena,
                          &out_material->phi, &out_material->psi, &out_material->viscous_time);
        status = ss_arena_status(arena);
    }
    return status;
}
