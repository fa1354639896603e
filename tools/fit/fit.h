/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Curves, a scene and parameters to the parameters that repeat the curves.
 *
 * Each evaluation is a world of its own, with the parameters as overrides, and one press for each
 * curve; or one run for each level of a reference case. A curve counts as one, however many points
 * it has, in shares of its own rms force.
 * Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "curve.h"
#include "levels.h"
#include "parameters.h"
#include "press.h"
#include "solve.h"

enum { SS_FIT_MAX_CURVES = 8 };

typedef struct ss_fit {
    ss_press_scene scene;
    ss_curve curve[SS_FIT_MAX_CURVES];
    ss_press press[SS_FIT_MAX_CURVES];
    int32_t curve_count;
    ss_fit_levels *levels; /* borrowed: instead of curves; NULL */
    ss_fit_parameter parameter[SS_FIT_MAX_PARAMETERS];
    int32_t parameter_count;
    int32_t max_evaluations;
    /* After each evaluation, with the misfit in shares of the rms force; may be NULL. */
    void (*progress)(int32_t evaluations, double misfit);

    double value[SS_FIT_MAX_PARAMETERS]; /* the answer */
    double *force[SS_FIT_MAX_CURVES];    /* N, the model's at the curve's points, with the answer */
    double sunk[SS_FIT_MAX_CURVES];      /* m, the tool in the tissue, likewise */
    ss_press_run run;                    /* the worst of the last runs */
    ss_solve solve;
} ss_fit;

/* Curves and presses, or levels, and parameters are filled in; fills in the rest. */
softsim_status ss_fit_run(ss_fit *fit, softsim_error *error);
/* What was found, one line a fact. */
void ss_fit_tell(const ss_fit *fit, void (*line)(void *sink, const char *text), void *sink);
/* Frees curves, presses and forces. */
void ss_fit_fini(ss_fit *fit);
