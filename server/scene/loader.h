/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A scene while it is read from its checked tree. Used inside scene/ only. */
#include "scene/region.h"
#include "scene/scene.h"

typedef struct ss_scene_loader {
    ss_scene_report *report;
    ss_scene *scene;
    const ss_scene_model *model; /* NULL: not known */
    ss_scene_node *root;
    ss_scene_space space;
    softsim_error *mesh_error; /* faults of mesh files, shown after those of the scene */
    const char *import_program;
    int64_t set_nodes;
} ss_scene_loader;

void ss_scene_fault_memory(ss_scene_loader *l);
/* Of a usable list; 0 of anything else. */
int32_t ss_scene_entry_count(const ss_scene_node *list);
/* Of an entry with `axes`: bits 1, 2, 4 for x, y, z; all of them without. */
uint8_t ss_scene_axes_of(const ss_scene_node *item);
/* Both with a mesh. */
void ss_scene_take_loads(ss_scene_loader *l);
void ss_scene_take_prescribed(ss_scene_loader *l);
