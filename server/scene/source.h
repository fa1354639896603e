/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What was written, kept with the scene so that it can be printed again. Used inside scene/ only.
 */
#include "scene/schema.h"

struct ss_scene_source {
    ss_scene_tree tree;
    ss_scene_row *model_row; /* the model's table as rows, `name` first */
    int32_t model_row_count;
    char folder[1024]; /* of the scene, "" or ending in / */
};
