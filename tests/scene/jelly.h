/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The parameters of a model that there is not, of every kind: for tests and fuzzing of scenes. */
#include <math.h>

#include "scene/scene.h"

enum { MODULUS, RHO, CELLS, PER_AREA, SOLVER, SATURATION, DAMPING, GRAIN };

static const ss_param_row jelly_row[] = {
    {.name = "modulus_j",
     .kind = SS_PARAM_NUMBER,
     .range = {.min = 0, .max = 1e6, .exclusive_min = true},
     .is_required = true,
     .fallback = NAN,
     .help = "strength of the network"},
    {.name = "rho",
     .kind = SS_PARAM_FIELD,
     .range = {.min = 0, .max = 10, .exclusive_min = true},
     .takes_links = true,
     .fallback = 1,
     .help = "conductance"},
    {.name = "cells",
     .kind = SS_PARAM_INTEGER,
     .range = {.min = 1, .max = 100},
     .fallback = 7,
     .help = "how many"},
    {.name = "per_area",
     .kind = SS_PARAM_BOOL,
     .range = {.max = 1},
     .fallback = 1,
     .help = "times the area"},
    {.name = "solver",
     .kind = SS_PARAM_CHOICE,
     .range = {.max = 1},
     .choices = "equilibrium|relaxation",
     .help = "how"},
    {.name = "saturation",
     .kind = SS_PARAM_NUMBER,
     .range = {.min = 0, .max = INFINITY},
     .fallback = NAN,
     .help = "K"},
    {.name = "damping_n_s_per_m3",
     .kind = SS_PARAM_NUMBER,
     .range = {.min = 0, .max = INFINITY},
     .is_live = true,
     .fallback = 1725,
     .help = "gamma"},
    {.name = "grain", .kind = SS_PARAM_DIRECTION, .help = "of the fibres"},
};
