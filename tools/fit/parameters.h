/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which numbers of a scene's model are fitted, from where, and within which bounds.
 *
 * A parameter is a path into the scene, `model.NAME` or one entry of a region list,
 * `model.NAME.K.value`. It is fitted by factors, so it must start above 0: from the scene's value.
 * Bounds are the model's own, and a factor of 10,000 on either side of the start.
 * Thread: set-up only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

enum { SS_FIT_MAX_PARAMETERS = 8, SS_FIT_PATH_SIZE = 128 };

typedef struct ss_fit_parameter {
    char path[SS_FIT_PATH_SIZE];
    double start, min, max; /* in the parameter's unit */
} ss_fit_parameter;

/* Those asked for, or, with none, the model's material parameters that the scene gives above 0;
 * those that only time shows (damping, viscosity) where there is a curve over time. Returns their
 * number, 0 with every fault in `error`. */
int32_t ss_fit_choose(const char *scene_path, const char *const *set, int32_t set_count,
                      const char *const *wanted, int32_t wanted_count, bool has_time,
                      ss_fit_parameter out[SS_FIT_MAX_PARAMETERS], softsim_error *error);
