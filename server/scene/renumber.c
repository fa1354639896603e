/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A scene is read, checked and reported in the file's numbers; only then, once, it is renumbered.
 * Mapping each number as it is read was rejected: every reader and message would need both kinds.
 */
#include <stdlib.h>
#include <string.h>

#include "scene/source.h"

/* value[i] := value[from[i]] for `count` values of `size` bytes; NULL values or an absent list: as
 * it was. */
static bool reorder(void *value, const int32_t *from, int32_t count, size_t size)
{
    if (value == NULL || from == NULL) {
        return true;
    }
    char *copy = malloc((size_t)count * size);
    if (copy == NULL) {
        return false;
    }
    memcpy(copy, value, (size_t)count * size);
    for (int32_t i = 0; i < count; i++) {
        memcpy((char *)value + (size_t)i * size, copy + (size_t)from[i] * size, size);
    }
    free(copy);
    return true;
}

static void relabel(int32_t *node, int32_t count, const int32_t *new_number)
{
    for (int32_t i = 0; i < count; i++) {
        node[i] = new_number[node[i]];
    }
}

bool ss_scene_renumber(ss_scene *scene)
{
    ss_mesh *mesh = scene->mesh;
    if (!ss_mesh_renumber(mesh)) {
        return false;
    }
    const int32_t nodes = mesh->node_count;
    bool is_done =
        reorder(scene->fixed, mesh->file_node, nodes, sizeof *scene->fixed) &&
        reorder(scene->friction.per_node, mesh->file_node, nodes, sizeof *scene->friction.per_node);
    for (int32_t i = 0; i < scene->source->model_row_count - 1; i++) {
        ss_param_value *value = &scene->param[i];
        is_done = is_done &&
                  reorder(value->per_node, mesh->file_node, nodes, sizeof *value->per_node) &&
                  reorder(value->by_element, mesh->file_element, ss_mesh_element_count(mesh),
                          sizeof *value->by_element) &&
                  reorder(value->per_element, mesh->file_element, ss_mesh_element_count(mesh),
                          sizeof *value->per_element);
    }
    if (mesh->file_node == NULL || !is_done) {
        return is_done;
    }
    int32_t *new_number = malloc((size_t)nodes * sizeof *new_number);
    if (new_number == NULL) {
        return false;
    }
    for (int32_t i = 0; i < nodes; i++) {
        new_number[mesh->file_node[i]] = i;
    }
    for (int32_t i = 0; i < scene->source->model_row_count - 1; i++) {
        for (int32_t k = 0; k < scene->param[i].link_count; k++) {
            relabel(scene->param[i].per_link[k].node, 2, new_number);
        }
    }
    for (int32_t i = 0; i < scene->load_count; i++) {
        relabel(scene->load[i].node, scene->load[i].node_count, new_number);
    }
    for (int32_t i = 0; i < scene->prescribed_count; i++) {
        relabel(scene->prescribed[i].node, scene->prescribed[i].node_count, new_number);
    }
    free(new_number);
    return true;
}
