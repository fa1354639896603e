/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a mesh asks of each model built in: its stable step and its memory, for a stated material,
 * without tools, loads or anything fixed.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

enum { COST_MAX_MODELS = 16 };

typedef struct model_cost {
    const char *name;
    bool is_known;
    double stable_step_s;
    int64_t bytes;
    char reason[256]; /* why it is not known */
} model_cost;

/* The material in words. */
extern const char cost_material[];

/* `mesh` in metres, and acceptable (ss_mesh_accept). Returns how many models there are. */
int32_t cost_measure(const ss_mesh *mesh, model_cost out[COST_MAX_MODELS]);
