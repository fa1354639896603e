/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A reference case instead of a curve: the scene's model on the case's own body, brought to rest at
 * every load level, and what its fields and forces miss of the reference.
 *
 * The body and its loads are the case's, the model with all its parameters the scene's; a scene of
 * a surface takes the case's surface meshes. Needs a material of the case and one of its meshes, by
 * default the first of each. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "case/case.h"
#include "case/run.h"
#include "case/scratch.h"
#include "parameters.h"
#include "press.h"
#include "softsim/types.h"

typedef struct ss_fit_levels {
    ss_case c;
    ss_case_body body;
    int32_t material;
    const char *mesh;                               /* its name */
    int32_t level[SS_CASE_MAX_LEVELS], level_count; /* of the material */
    double force_rms;                               /* N, of the reference; 0: none is known */
    double load_s;                                  /* about how long a level is loaded */
    double step_s;                                  /* of the scene */
    char folder[SS_SCRATCH_PATH];                   /* temporary */
    char *model;                                    /* the scene's lines under `model:` */
    double *residual;                               /* of the last measurement */
    int32_t residual_count;
    double field_misfit, force_misfit; /* of the last measurement: root mean squares over levels of
                                          relative errors; NaN: no forces */
} ss_fit_levels;

/* `material`, `mesh` NULL: the case's first. */
softsim_status ss_fit_levels_open(const char *folder, const char *material, const char *mesh,
                                  const ss_press_scene *scene, double load_s, ss_fit_levels *out,
                                  softsim_error *error);
/* Runs every level with the parameters at `value`; the residuals' squares sum to the mean square of
 * the relative errors, of both fields and forces. */
softsim_status ss_fit_levels_measure(ss_fit_levels *levels, int32_t count,
                                     const ss_fit_parameter *parameter, const double *value,
                                     softsim_error *error);
void ss_fit_levels_close(ss_fit_levels *levels);
