/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "scene/loader.h"

void ss_scene_fault_memory(ss_scene_loader *l)
{
    ss_scene_report_add(l->report, SOFTSIM_ERROR_MEMORY, (ss_scene_place){-1, 0, 0},
                        "out of memory");
}

int32_t ss_scene_entry_count(const ss_scene_node *list)
{
    return list != NULL && list->kind == SS_SCENE_LIST && list->count <= SS_SCENE_MAX_ENTRIES
               ? list->count
               : 0;
}

uint8_t ss_scene_axes_of(const ss_scene_node *item)
{
    const ss_scene_node *axes = ss_scene_node_find(item, "axes");
    uint8_t bits = 0;
    for (const char *c = axes != NULL ? axes->text : "xyz"; *c != '\0'; c++) {
        bits |= (uint8_t)(1u << (*c - 'x'));
    }
    return bits;
}
