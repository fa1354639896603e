/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/fem_elastic.h"
/*
 * The elastic body of tetrahedra: its parts put together, and what it says of itself.
 */
#include "models/common/dispatch.h"
#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/note.h"

SS_KERNEL_PATHS_512(ss_fem_kernels)

/* ---- life ---- */

void ss_fem_destroy(ss_fem **fem)
{
    if (!*fem) {
        return;
    }
    ss_arena_free(&(*fem)->arena);
    ss_memory_free(*fem);
    *fem = NULL;
}

softsim_status ss_fem_create(const ss_fem_setup *setup, ss_fem **out_fem)
{
    const ss_fem_material *material = setup->material;
    const int32_t padded = (setup->node_count + 7) / 8 * 8;
    const ss_fem_stuff stuff = {.node_count = setup->node_count,
                                .mesh = setup->mesh,
                                .moduli = ss_fem_moduli_of(material),
                                .volume_share = setup->volume_share};
    ss_fem *fem = ss_memory_get(1, sizeof *fem);
    ss_real *rest = ss_memory_get((size_t)padded * 4, sizeof *rest);
    *out_fem = fem;
    bool is_good = fem && rest;
    if (is_good) {
        fem->kernels = ss_fem_kernels_get();
        fem->kind = material->kind;
        fem->integrator = material->integrator;
        fem->viscous_time = material->viscous_time;
        fem->mass_damping = material->mass_damping;
        fem->diagonal = ss_arena_get(&fem->arena, (size_t)setup->node_count, sizeof *fem->diagonal);
        fem->u = rest;
        is_good = fem->diagonal && ss_fem_blocks_create(&stuff, &fem->arena, &fem->blocks) &&
                  (!material->is_averaged || ss_fem_average_create(fem, setup, padded)) &&
                  ss_fem_stability_create(fem, setup, padded);
        fem->u = NULL;
    }
    ss_memory_free(rest);
    if (!is_good) {
        ss_fem_destroy(out_fem);
        return SOFTSIM_ERROR_MEMORY;
    }
    return SOFTSIM_OK;
}

/* ---- report ---- */

void ss_fem_work(ss_tissue_kind kind, bool is_viscous, double *out_bytes, double *out_flops)
{
    /* Counted in fem_kernels.c. H 54, D 42, its square 13, S 14, P 63, forces 54; the guard's test
     * 18; rate 54, strain rate 66, S 14, power and sum 20. */
    *out_bytes =
        (double)((SS_FEM_SHAPES + SS_FEM_MODULI + (is_viscous ? 2 : 0)) * (int)sizeof(ss_real) +
                 4 * (int)sizeof(int32_t));
    *out_flops = 240.0 + (kind == SS_TISSUE_STVK_GUARDED ? 18.0 : 0.0) + (is_viscous ? 154.0 : 0.0);
}

void ss_fem_explain(const ss_fem *fem, const ss_fem_material *material, const ss_notes *out)
{
    const ss_fem_stability *s = &fem->stability;
    double bytes, flops, cured = 0.0;
    ss_fem_work(fem->kind, fem->blocks.viscosity != NULL, &bytes, &flops);
    for (int32_t e = 0; e < fem->blocks.element_count; ++e) {
        cured += material->lambda_own[e] < material->lambda[e];
    }
    ss_note_used(out, "tetrahedra",
                 "%d of %s in %d blocks of 8, %s kernels, %.0f bytes each a sweep",
                 fem->blocks.element_count, ss_tissue_name(fem->kind), fem->blocks.count,
                 fem->kernels->name, bytes);
    if (fem->average.modulus) {
        ss_note_used(out, "locking",
                     "dilatation resisted by nodes in %.0f elements; a second sweep", cured);
    } else {
        ss_note_left_out(out, "cure for locking, and its sweep", NULL, "%s",
                         "no element above Poisson's ratio 0.45, or switched off");
    }
    if (fem->blocks.viscosity) {
        ss_note_used(out, "viscosity", "at most %.4g s of the elastic stiffness",
                     fem->viscous_time);
    } else {
        ss_note_left_out(out, "velocity pass", SS_PLAN_PUT_BACK_VISCOSITY, "no viscosity");
    }
    ss_note_used(out, "stable step of the elastic body",
                 "%.4g s by power iteration, of which %.2g is taken; assembled bound %.4g s%s",
                 ss_fem_rest_step(fem), SS_FEM_STEP_SHARE, ss_fem_step_limit(fem, s->rest_bound),
                 s->rest_rate2 >= s->rest_bound ? " (is taken)" : "");
}

ss_body_plan ss_fem_plan_body(ss_fem *fem, const ss_model_plan *plan,
                              const ss_fem_material *material, const double *mass)
{
    return (ss_body_plan){.name = "fem",
                          .plan = plan,
                          .node_count = plan->mesh->node_count,
                          .mass = mass,
                          .mass_damping = material->mass_damping,
                          .edge = ss_body_mean_edge(plan->mesh),
                          .planned_step = SS_FEM_STEP_SHARE * ss_fem_rest_step(fem),
                          .step_share = SS_FEM_STEP_SHARE,
                          .integrator = material->integrator,
                          .elastic = {SS_BODY_ELASTIC(fem, ss_fem_force, ss_fem_tangent,
                                                      ss_fem_diagonal, ss_fem_stable_step),
                                      .viscous_time = material->viscous_time, .reset = ss_fem_reset,
                                      .hash = ss_fem_hash}};
}
