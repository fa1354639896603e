/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the files of the model corotational share: its parameters, its state and its parts. Private
 * to them; everyone else uses the row in the table of models. kernels.c derives the forces,
 * solve.c the step.
 *
 * Memory: all of it is allocated while the model is created. Thread: set-up functions as marked,
 * everything else by the simulation thread and RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "models/common/body.h"
#include "models/corotational/kernels.h"

/* Rows of the parameter table, in its order. */
enum {
    SS_COROT_MATERIAL,
    SS_COROT_YOUNGS_MODULUS,
    SS_COROT_POISSON_RATIO,
    SS_COROT_LAME_LAMBDA,
    SS_COROT_LAME_MU,
    SS_COROT_DENSITY,
    SS_COROT_VISCOSITY_PHI,
    SS_COROT_VISCOSITY_PSI,
    SS_COROT_STIFFNESS_DAMPING,
    SS_COROT_MASS_DAMPING,
    SS_COROT_TOLERANCE,
    SS_COROT_NEWTON_ITERATIONS,
    SS_COROT_SOLVER_ITERATIONS,
    SS_COROT_ROW_COUNT
};
extern const ss_param_row ss_corot_rows[SS_COROT_ROW_COUNT];

/* What the elements are made of, one value each, SI. */
typedef struct ss_corot_material {
    double *lambda, *mu; /* Pa */
    double *phi, *psi;   /* Pa s; NULL: no viscosity */
    double *density;     /* kg/m^3 */
    double mass_damping; /* 1/s */
    double viscous_time; /* s, the largest viscosity over stiffness */
    double largest_poisson;
} ss_corot_material;

struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    ss_model_plan plan;
    const ss_corot_kernels *kernels;
    ss_fem_blocks blocks;
    ss_corot_material material;
    bool has_viscosity;
    double edge;      /* m */
    double tolerance; /* of a step's residual */
    int32_t max_newton, max_products;
    int32_t node_count, scalar_count; /* 4 x padded nodes */
    /* per node, for the step's system */
    double *stiff, *viscous; /* N/m, N s/m: mean diagonals of K and of the damping, at rest */
    ss_real *mass;           /* quads; 0 on axes that do not move */
    /* moduli of K + D/h, laid out as the blocks' */
    ss_real *system;
    double system_step; /* h that they are for */
    /* state: h times the change of velocity in the last step, quads, where there was one */
    bool has_last;
    ss_real *last;
    /* the last evaluation of all elements: derived from evaluated_u alone */
    bool is_evaluated;
    ss_real *evaluated_u, *turned, *elastic; /* elastic: forces, quads */
    double energy;                           /* J */
    int32_t inverted_count, first_inverted;
    /* scratch of a step, quads: where it began; the change of velocity sought, and the velocity */
    ss_real *old_u, *old_v, *change, *velocity;
    ss_real *away; /* from evaluated_u */
    ss_real *residual, *scaled, *search, *product, *step, *inverse;
    double *contact; /* N/m a node */
    /* of the last step, for tests and reports */
    int32_t newton_count, product_count, evaluation_count;
    double left; /* residual over what was enough */
};

/* ---- material.c ---- */

/* Values of every element, and everything refused about them. Thread: set-up only. */
softsim_status ss_corot_material_create(const ss_model_plan *plan, ss_arena *arena,
                                        ss_corot_material *out_material, softsim_error *error);

/* ---- solve.c: what the body asks of the law; `owner` is the model ---- */

void ss_corot_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                    ss_body_energy *out);
void ss_corot_tangent(void *owner, const ss_real *x, ss_real *out);
void ss_corot_advance(void *owner, ss_body *body, double h, double path_end);
