/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A volume of tetrahedra as an elastic body: material, forces, cure for locking, stable step. What
 * `fem` is made of, and any model that has a core of tetrahedra.
 *
 * In: the scene's plan and the rows of SS_FEM_ROWS at the start of the model's table. Out: the
 * functions that ss_body_elastic asks for. fem_material.c reads parameters, fem_average.c cures
 * locking, fem_force.c has forces, fem_stability.c derives the stable step, fem_elastic.c puts all
 * together, fem_kernels.h has the hot loops.
 * Memory: by ss_fem_create. Thread: create, destroy and explain set-up only; the rest by the
 * simulation thread, RT-safe and deterministic.
 */
#include "models/common/body.h"
#include "models/common/fem_kernels.h"
#include "models/model.h"

/* ---- material ---- */

enum {
    SS_FEM_MATERIAL,
    SS_FEM_YOUNGS_MODULUS,
    SS_FEM_POISSON_RATIO,
    SS_FEM_LAMBDA,
    SS_FEM_MU,
    SS_FEM_DENSITY,
    SS_FEM_PHI,
    SS_FEM_PSI,
    SS_FEM_STIFFNESS_DAMPING,
    SS_FEM_MASS_DAMPING,
    SS_FEM_INTEGRATOR,
    SS_FEM_LOCKING_CURE,
    SS_FEM_ROW_COUNT
};

/* Elasticity and density: the first rows of every table of parameters of tetrahedra; `laws` are the
 * choices, the last of them number `last`. */
#define SS_FEM_SOLID_ROWS(laws, last, usual)                                                       \
    [SS_FEM_MATERIAL] =                                                                            \
        SS_PARAM(CHOICE, "material", "law of the tissue: all agree at small strain",               \
                 .range.max = (last), .choices = (laws), .fallback = (usual)),                     \
    [SS_FEM_YOUNGS_MODULUS] =                                                                      \
        SS_PARAM(FIELD, "youngs_modulus_pa",                                                       \
                 "E; with poisson_ratio, or give lame_lambda_pa and lame_mu_pa; an element takes " \
                 "the mean of its nodes",                                                          \
                 .takes_elements = true, SS_ABOVE(0, 1e15), .fallback = SS_ABSENT),                \
    [SS_FEM_POISSON_RATIO] =                                                                       \
        SS_PARAM(FIELD, "poisson_ratio", "nu; soft tissue is near 0.5", .takes_elements = true,    \
                 SS_ABOVE(-1.0, 0.49999), .fallback = SS_ABSENT),                                  \
    [SS_FEM_LAMBDA] =                                                                              \
        SS_PARAM(FIELD, "lame_lambda_pa", "Lame's first constant, in place of E and nu",           \
                 .takes_elements = true, SS_FROM(-1e15, 1e15), .fallback = SS_ABSENT),             \
    [SS_FEM_MU] = SS_PARAM(FIELD, "lame_mu_pa", "shear modulus, in place of E and nu",             \
                           .takes_elements = true, SS_ABOVE(0, 1e15), .fallback = SS_ABSENT),      \
    [SS_FEM_DENSITY] = SS_PARAM(FIELD, "density_kg_m3", "mass per volume", .takes_elements = true, \
                                SS_ABOVE(0, 1e9), .fallback = 1000.0)

/* Damping and time step: the rows that follow where a step is explicit. */
#define SS_FEM_DAMPING_ROWS                                                                        \
    [SS_FEM_PHI] = SS_PARAM(FIELD, "viscosity_phi_pa_s", "viscosity of dilatation",                \
                            .takes_elements = true, SS_FROM(0, 1e12)),                             \
    [SS_FEM_PSI] = SS_PARAM(FIELD, "viscosity_psi_pa_s", "viscosity of shear",                     \
                            .takes_elements = true, SS_FROM(0, 1e12)),                             \
    [SS_FEM_STIFFNESS_DAMPING] = SS_PARAM(                                                         \
        NUMBER, "stiffness_damping_s",                                                             \
        "adds this time times lambda and mu to the viscosities: it damps stiff modes most",        \
        SS_FROM(0, 1e6)),                                                                          \
    [SS_FEM_MASS_DAMPING] =                                                                        \
        SS_PARAM(NUMBER, "mass_damping_per_s",                                                     \
                 "damping per mass: it damps all modes, and free flight", SS_FROM(0, 1e9)),        \
    [SS_FEM_INTEGRATOR] =                                                                          \
        SS_PARAM(CHOICE, "integrator", "rk4 costs four times as much and loses energy",            \
                 .range.max = 1.0, .choices = "symplectic-euler|rk4")

/* The row after them where forces are ss_fem's. */
#define SS_FEM_CURE_ROW                                                                            \
    [SS_FEM_LOCKING_CURE] = SS_PARAM(CHOICE, "locking_cure",                                       \
                                     "shares the resistance to dilatation among the elements of "  \
                                     "a node; auto: where Poisson's ratio is above 0.45",          \
                                     .range.max = 2.0, .choices = "auto|none|nodal-pressure")

/* The first rows of a table with all of them. */
#define SS_FEM_ROWS                                                                                \
    SS_FEM_SOLID_ROWS(SS_TISSUE_CHOICES, SS_TISSUE_KIND_COUNT - 1, SS_TISSUE_STVK_GUARDED),        \
        SS_FEM_DAMPING_ROWS, SS_FEM_CURE_ROW

/* What the body is made of; one value an element. */
typedef struct ss_fem_material {
    ss_tissue_kind kind;
    double *lambda, *mu; /* Pa */
    double *lambda_own;  /* Pa: what the element resists by itself */
    double *density;     /* kg/m^3 */
    double *phi, *psi;   /* Pa s; NULL without viscosity */
    double viscous_time; /* s: the viscous stiffness is at most that times the elastic */
    double mass_damping; /* 1/s */
    bool is_averaged;    /* lambda_own differs from lambda somewhere */
    ss_body_integrator integrator;
} ss_fem_material;

static inline ss_fem_moduli ss_fem_moduli_of(const ss_fem_material *material)
{
    return (ss_fem_moduli){material->lambda_own, material->lambda, material->mu, material->phi,
                           material->psi};
}

/* `name` begins every fault. SOFTSIM_ERROR_SCENE when there are any. */
softsim_status ss_fem_material_create(const ss_model_plan *plan, const char *name, ss_arena *arena,
                                      ss_fem_material *out_material, softsim_error *error);
/* The same of a table with the solid's and the damping's rows alone: every element resists all of
 * lambda by itself. */
softsim_status ss_fem_material_read(const ss_model_plan *plan, const char *name, ss_arena *arena,
                                    ss_fem_material *out_material, softsim_error *error);

/* The root of the largest K_ii / m_i of a node, 1/s, with K_ii = sum V (lambda + 2 mu) |grad N_i|^2
 * over its elements at rest: from 5 % below to 6 % above omega_max on the meshes of the reference
 * problems, organs, and regular blocks, and cheap. (The worst element's speed of sound over its
 * height is up to twice as much.) 0 when out of memory. */
double ss_fem_node_rate(const ss_mesh *mesh, const ss_fem_material *material);
/* Sweeps over the elements in a step of `step` s, for the planned cost, where
 * omega_max is about `rate`: the part `share` is taken of the stable step with all damping. */
double ss_fem_planned_sweeps(const ss_fem_material *material, double step, double rate,
                             double share);

/* Fraction of the stable step that sub-steps take; fem_stability.c counts on it. */
#define SS_FEM_STEP_SHARE 0.5

/* ---- the elastic body ---- */

/* Dilatation resisted by nodes: fem_average.c. */
typedef struct ss_fem_average {
    ss_real *modulus;           /* a node: lambda / volume of its elements, Pa/m^3; NULL: none */
    ss_real *pressure, *change; /* quads, the first lane counts: Pa */
} ss_fem_average;

/* The stable step: fem_stability.c. */
typedef struct ss_fem_stability {
    ss_real *bound;          /* [block][8]: omega^2 of the element with its share of mass, 1/s^2 */
    double rest_bound;       /* the largest of them */
    double rest_rate2;       /* omega_max^2 at rest, from above, 1/s^2 */
    ss_real *mobility;       /* quads, 1/kg */
    ss_real *mode, *product; /* quads: the stiffest motion, and K times it */
    ss_real *rest_mode;
    ss_real *growth, *ratio;     /* [block][8]: scratch; J */
    double rate2;                /* of the state at the last look, from above */
    double strain_at_power_step; /* then */
    double strain;               /* largest |2E| since stable_step was called last */
    int32_t age;                 /* calls since the last power step */
    int32_t squeezed, inverted;  /* elements below the law's floor of J, and inside out */
    int32_t worst; /* the element that limits the step, or the one most squeezed; -1 */
} ss_fem_stability;

typedef struct ss_fem {
    ss_arena arena;
    const ss_fem_kernels *kernels;
    ss_tissue_kind kind;
    ss_fem_blocks blocks;
    ss_fem_average average;
    ss_fem_stability stability;
    ss_body_integrator integrator;
    double viscous_time; /* s */
    double mass_damping; /* 1/s */
    double *diagonal;    /* N/m, mean of K's diagonal block of a node, at rest */
    const ss_real *u;    /* of the last force */
} ss_fem;

typedef struct ss_fem_setup {
    const ss_mesh *mesh;
    const ss_fem_material *material;
    const double *volume_share; /* of each element's volume that stores energy; NULL: all */
    int32_t node_count;         /* the mesh's, and the model's own after them */
    const double *mass;         /* kg, node_count */
    const uint8_t *fixed;       /* of the mesh's nodes */
} ss_fem_setup;

softsim_status ss_fem_create(const ss_fem_setup *setup, ss_fem **out_fem);
void ss_fem_destroy(ss_fem **fem);

/* The plan of a body whose law is the whole of `fem`; `mass` as in ss_body_plan. Thread: set-up
 * only. */
ss_body_plan ss_fem_plan_body(ss_fem *fem, const ss_model_plan *plan,
                              const ss_fem_material *material, const double *mass);

/* What ss_body_elastic asks for; `owner` is the ss_fem. */
void ss_fem_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                  ss_body_energy *out);
void ss_fem_tangent(void *owner, const ss_real *x, ss_real *out);
void ss_fem_diagonal(void *owner, double *diagonal);
double ss_fem_stable_step(void *owner, const ss_body *body);
void ss_fem_reset(void *owner);
uint64_t ss_fem_hash(const void *owner, uint64_t seed);

/* dt* at rest: the largest stable step of the integrator, from below, s. */
double ss_fem_rest_step(const ss_fem *fem);
/* dt* for the largest rate `rate2` = omega^2 (1/s^2), s: ss_body_step_limit with all damping. */
double ss_fem_step_limit(const ss_fem *fem, double rate2);
/* Says so to the body where elements are squeezed or turned inside out; after stable_step. */
void ss_fem_judge(const ss_fem *fem, ss_body *body);
/* The same for any body of such elements; `squeezed_text` where those of neo-hookean are. */
void ss_fem_judge_elements(ss_body *body, ss_tissue_kind kind, int32_t inverted, int32_t squeezed,
                           int32_t worst, const char *squeezed_text);
/* What a force sweep streams and computes for an element of stvk or stvk-guarded, without a cure:
 * bytes, and flops (a fused multiply-add counts 2). */
void ss_fem_work(ss_tissue_kind kind, bool is_viscous, double *out_bytes, double *out_flops);
/* Lines about law, path, cure, step. Thread: set-up only. */
void ss_fem_explain(const ss_fem *fem, const ss_fem_material *material, const ss_notes *out);

/* ---- parts, for the files of this module ---- */

bool ss_fem_average_create(ss_fem *fem, const ss_fem_setup *setup, int32_t padded);
/* R of every node, N/m: the stiffness of the averaged part is at most that diagonal. */
bool ss_fem_average_bound(const ss_fem_average *average, const ss_fem_setup *setup,
                          double *out_stiffness);
/* Pressures of the nodes at `u`; returns their energy if wanted, J. */
double ss_fem_average_update(ss_fem *fem, const ss_real *u, bool wants_energy);
/* Their change along x at the last u. */
void ss_fem_average_change(ss_fem *fem, const ss_real *x);

bool ss_fem_stability_create(ss_fem *fem, const ss_fem_setup *setup, int32_t padded);
