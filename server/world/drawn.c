/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/drawn.h"

#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

enum { NODE, FILE_NODE, FIXED, REST, TRIANGLE };

/* Numbers the surface's nodes that the scene's mesh has not, in the order of the model's numbers:
 * -1 where there is none. Returns how many there are in all. */
static int32_t number_nodes(const ss_mesh *of, int32_t given, int32_t *out_number)
{
    memset(out_number, 0xff, (size_t)of->node_count * sizeof *out_number);
    for (int32_t c = 0; c < 3 * of->triangle_count; ++c) {
        out_number[of->triangle[c / 3][c % 3]] = 0;
    }
    int32_t count = given;
    for (int32_t i = 0; i < of->node_count; ++i) {
        out_number[i] = i < given ? i : out_number[i] < 0 ? -1 : count++;
    }
    return count;
}

static void fill(ss_drawn *drawn, const ss_mesh *mesh, const ss_model_shape *shape,
                 const int32_t *number)
{
    int32_t *node = drawn->room[NODE], *file_node = drawn->room[FILE_NODE];
    int32_t(*triangle)[3] = drawn->room[TRIANGLE];
    double(*rest)[3] = drawn->room[REST];
    uint8_t *fixed = drawn->room[FIXED];
    for (int32_t i = 0; i < shape->mesh->node_count; ++i) {
        if (number[i] >= 0) {
            node[number[i]] = i;
            file_node[number[i]] = i < mesh->node_count ? ss_mesh_file_node(mesh, i) : -1;
            fixed[number[i]] = shape->fixed[i];
            ss_copy3(rest[number[i]], shape->mesh->position[i]);
        }
    }
    for (int32_t c = 0; c < 3 * drawn->triangle_count; ++c) {
        triangle[c / 3][c % 3] = number[shape->mesh->triangle[c / 3][c % 3]];
    }
    drawn->node = node;
    drawn->file_node = file_node;
    drawn->fixed = fixed;
    drawn->rest = (const double(*)[3])rest;
    drawn->triangle = (const int32_t(*)[3])triangle;
}

bool ss_drawn_init(ss_drawn *drawn, const ss_mesh *mesh, const uint8_t *fixed,
                   const ss_model_shape *shape)
{
    const ss_mesh *of = shape->mesh;
    *drawn = (ss_drawn){.node_count = mesh->node_count,
                        .given_count = mesh->node_count,
                        .triangle_count = of->triangle_count,
                        .rest = (const double(*)[3])of->position,
                        .triangle = (const int32_t(*)[3])of->triangle,
                        .file_node = mesh->file_node,
                        .fixed = fixed,
                        .is_quartered = of->middle != NULL};
    if (of->node_count == mesh->node_count) {
        return true;
    }
    int32_t *number = ss_memory_get((size_t)of->node_count, sizeof *number);
    if (number == NULL) {
        return false;
    }
    drawn->node_count = number_nodes(of, mesh->node_count, number);
    const size_t nodes = (size_t)drawn->node_count;
    drawn->room[NODE] = ss_memory_get(nodes, sizeof(int32_t));
    drawn->room[FILE_NODE] = ss_memory_get(nodes, sizeof(int32_t));
    drawn->room[FIXED] = ss_memory_get(nodes, 1);
    drawn->room[REST] = ss_memory_get(nodes, sizeof(double[3]));
    drawn->room[TRIANGLE] = ss_memory_get((size_t)of->triangle_count, sizeof(int32_t[3]));
    bool is_good = true;
    for (size_t k = 0; k < sizeof drawn->room / sizeof *drawn->room; ++k) {
        is_good = is_good && drawn->room[k] != NULL;
    }
    if (is_good) {
        fill(drawn, mesh, shape, number);
    }
    ss_memory_free(number);
    return is_good;
}

void ss_drawn_fini(ss_drawn *drawn)
{
    for (size_t k = 0; k < sizeof drawn->room / sizeof *drawn->room; ++k) {
        ss_memory_free(drawn->room[k]);
    }
    *drawn = (ss_drawn){0};
}

void ss_drawn_spread(const ss_drawn *drawn, float *value)
{
    for (int32_t t = 0; drawn->is_quartered && t < drawn->triangle_count; t += 4) {
        const int32_t(*four)[3] = drawn->triangle + t;
        for (int k = 0; k < 3; ++k) {
            value[four[3][k]] = 0.5F * (value[four[k][0]] + value[four[(k + 1) % 3][0]]);
        }
    }
}
