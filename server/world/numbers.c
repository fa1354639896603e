/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/memory.h"
#include "world/world.h"

/* The way back to the file's numbers, for what a user sees. The triangles of a surface come in the
 * file's order too; those of a volume, which no file has, in ours. */
softsim_status ss_world_plan_numbers(ss_world *world)
{
    const ss_mesh *mesh = world->scene->mesh;
    if (mesh->file_node) {
        world->node_of_file = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t));
        if (!world->node_of_file) {
            return SOFTSIM_ERROR_MEMORY;
        }
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            world->node_of_file[mesh->file_node[i]] = i;
        }
    }
    if (mesh->file_node || mesh->file_element) {
        world->file_triangle =
            ss_memory_get((size_t)mesh->triangle_count, sizeof *world->file_triangle);
        if (!world->file_triangle) {
            return SOFTSIM_ERROR_MEMORY;
        }
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            const int32_t place = mesh->tetrahedron_count > 0 ? t
                                  : mesh->quad_count > 0
                                      ? 2 * ss_mesh_file_element(mesh, t / 2) + t % 2
                                      : ss_mesh_file_element(mesh, t);
            for (int k = 0; k < 3; ++k) {
                world->file_triangle[place][k] = ss_mesh_file_node(mesh, mesh->triangle[t][k]);
            }
        }
    }
    return SOFTSIM_OK;
}
