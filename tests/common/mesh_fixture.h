/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes by hand: shared by the tests of meshes. cmocka comes first. */
#include "mesh/mesh.h"
#include "number_fixture.h"

#define COUNT(array) ((int32_t)(sizeof(array) / sizeof((array)[0])))

static inline ss_mesh *make_mesh(int32_t nodes, const double (*x)[3], int32_t triangles,
                                 const int32_t (*triangle)[3], int32_t tetrahedra,
                                 const int32_t (*tetrahedron)[4])
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_create(nodes, x, triangles, triangle, tetrahedra, tetrahedron, &mesh, &error) !=
        SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}

/* The nodes of `expected` are the first of `found`. */
static inline void assert_nodes_near(const ss_mesh *found, const ss_mesh *expected, double by)
{
    for (int32_t i = 0; i < expected->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            assert_near(found->position[i][k], expected->position[i][k], by);
        }
    }
}
