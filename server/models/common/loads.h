/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The loads of a plan: which nodes they push, how much of each acts, and their forces.
 *
 * Loads are taken once an outer step and held through it; a pressure follows the surface as it lies
 * then. Gravity is the model's own: it knows the masses.
 * Memory: the arena's. Thread: create set-up only; the rest by the simulation thread, RT-safe.
 */
#include "models/model.h"
#include "rt/arena.h"

typedef struct ss_acting_load {
    const ss_load *plan;
    int32_t triangle_count; /* pressure */
    int32_t *triangle;
    double factor; /* now acting */
} ss_acting_load;

typedef struct ss_loads {
    const ss_mesh *mesh; /* borrowed */
    int32_t count;
    ss_acting_load *load;
    int32_t node_count;
    int32_t *node; /* that any of them may push, increasing */
} ss_loads;

/* Faults are said in `error` under the model's `name`. `is_everywhere`: all nodes are listed. */
softsim_status ss_loads_create(ss_loads *loads, const ss_model_plan *plan, const char *name,
                               bool is_everywhere, ss_arena *arena, softsim_error *error);
/* None acts. */
void ss_loads_reset(ss_loads *loads);
/* How much of each acts at `time`; true where their forces are other than before. */
bool ss_loads_update(ss_loads *loads, double time);
bool ss_loads_is_any_acting(const ss_loads *loads);
/* Clears `force` at the listed nodes. */
void ss_loads_clear(const ss_loads *loads, ss_real *force);
/* Adds all that act at displacements u to `force`, whose unit is `unit` N. */
void ss_loads_add(const ss_loads *loads, const ss_real *u, double unit, ss_real *force);
