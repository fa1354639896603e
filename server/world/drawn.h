/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The surface as it is published: the scene's nodes and triangles, or those of a model that has
 * more nodes. Of the latter only those of the surface are taken, behind the scene's own; they are
 * in no file, and their number there is -1. In: the model's shape (ss_model_shape). Memory: its
 * own, and the model's. Thread: create set-up only; a finished one may be read from any thread.
 */
#include "models/model.h"

typedef struct ss_drawn {
    int32_t node_count, given_count, triangle_count; /* given: of the scene's mesh */
    const double (*rest)[3];                         /* m */
    const int32_t (*triangle)[3];
    const int32_t *node;      /* the model's number of each; NULL: the same */
    const int32_t *file_node; /* NULL: the same */
    const uint8_t *fixed;
    bool is_quartered; /* as the triangles of a mesh of second order */
    void *room[5];     /* what of it is its own */
} ss_drawn;

/* `mesh`, `fixed`: the scene's. False when out of memory. */
bool ss_drawn_init(ss_drawn *drawn, const ss_mesh *mesh, const uint8_t *fixed,
                   const ss_model_shape *shape);
void ss_drawn_fini(ss_drawn *drawn);

/* Gives the mid-edge nodes the mean of the ends of theirs. */
void ss_drawn_spread(const ss_drawn *drawn, float *value);
