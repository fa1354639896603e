/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The parameters of a model that there is not, of every kind: for tests and fuzzing of scenes. */
#include <math.h>

#include "scene/scene.h"

enum { MODULUS, RHO, CELLS, PER_AREA, SOLVER, SATURATION, DAMPING, GRAIN };

static const ss_param_row jelly_row[] = {
    SS_PARAM(NUMBER, "modulus_j", "strength of the network", SS_ABOVE(0, 1e6), .is_required = true,
             .fallback = SS_ABSENT),
    SS_PARAM(FIELD, "rho", "conductance", SS_ABOVE(0, 10), .takes_links = true, .fallback = 1),
    SS_PARAM(INTEGER, "cells", "how many", SS_FROM(1, 100), .fallback = 7),
    SS_PARAM(BOOL, "per_area", "times the area", SS_FROM(0, 1), .fallback = 1),
    SS_PARAM(CHOICE, "solver", "how", .range.max = 1, .choices = "equilibrium|relaxation"),
    SS_PARAM(NUMBER, "saturation", "K", SS_FROM(0, INFINITY), .fallback = SS_ABSENT),
    SS_PARAM(NUMBER, "damping_n_s_per_m3", "gamma", SS_FROM(0, INFINITY), .is_live = true,
             .fallback = 1725),
    SS_PARAM(DIRECTION, "grain", "of the fibres"),
};
