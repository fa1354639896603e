/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Nodes that no element has, such as the points of a geometry or of parts that were not written:
 * other programs pass over them, but a model has no mass there. They are left out and counted, as
 * the vertices of an OBJ file are; the numbers of the others close up in the file's order. That
 * scenes skip them instead was rejected: every model, kernel and message would have to know.
 */
#include "mesh/topology.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

static void mark(int32_t *node, int64_t count, int32_t *number)
{
    for (int64_t i = 0; i < count; ++i) {
        number[node[i]] = 0;
    }
}

static void renumber(int32_t *node, int64_t count, int32_t *number)
{
    for (int64_t i = 0; i < count; ++i) {
        node[i] = number[node[i]];
    }
}

static void renumber_group(ss_mesh_group *group, const int32_t *number)
{
    int32_t count = 0;
    for (int32_t i = 0; i < group->node_count; ++i) {
        if (number[group->node[i]] >= 0) {
            group->node[count++] = number[group->node[i]];
        }
    }
    group->node_count = count;
}

/* Groups of which no node is left go, too. */
static void renumber_groups(ss_mesh *mesh, const int32_t *number)
{
    int32_t kept = 0;
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        renumber_group(&mesh->group[g], number);
        if (mesh->group[g].node_count > 0) {
            mesh->group[kept++] = mesh->group[g];
        } else {
            ss_memory_free(mesh->group[g].node);
        }
    }
    mesh->group_count = kept;
}

/* Calls `visit` with each array of node numbers. */
static void each_array(ss_mesh *mesh, void (*visit)(int32_t *node, int64_t count, int32_t *number),
                       int32_t *number)
{
    visit((int32_t *)mesh->triangle, 3 * (int64_t)mesh->triangle_count, number);
    visit((int32_t *)mesh->quad, 4 * (int64_t)mesh->quad_count, number);
    visit((int32_t *)mesh->tetrahedron, 4 * (int64_t)mesh->tetrahedron_count, number);
    if (mesh->middle != NULL) {
        visit((int32_t *)mesh->middle, 6 * (int64_t)mesh->tetrahedron_count, number);
    }
}

bool ss_mesh_drop_unused(ss_mesh *mesh)
{
    int32_t *number = ss_memory_get((size_t)mesh->node_count, sizeof *number);
    if (number == NULL) {
        return false;
    }
    memset(number, 0xff, (size_t)mesh->node_count * sizeof *number);
    each_array(mesh, mark, number);
    int32_t count = 0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (number[i] == 0) {
            ss_copy3(mesh->position[count], mesh->position[i]);
            number[i] = count++;
        }
    }
    if (count < mesh->node_count) {
        each_array(mesh, renumber, number);
        renumber_groups(mesh, number);
    }
    mesh->unused_node_count += mesh->node_count - count;
    mesh->node_count = count;
    ss_memory_free(number);
    return true;
}
