/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Life of a mesh, and its simplest measures. Area of a triangle (a, b, c): the vector
 * A = (b - a) x (c - a) / 2, a third of it to each corner: the areas of the nodes sum to the
 * area of the surface exactly. (Voronoi areas, which a paper may use for curvature, go negative on
 * obtuse triangles and were rejected.)
 */
#include "mesh/mesh.h"

#include "mesh/topology.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

/* More than this of anything is refused: element numbers times six must fit an int32. */
enum { MAX_COUNT = 100000000 };

static void *copy_of(const void *data, int32_t count, size_t size)
{
    void *copy = ss_memory_get((size_t)count, size);
    if (copy != NULL && count > 0) {
        memcpy(copy, data, (size_t)count * size);
    }
    return copy;
}

softsim_status ss_mesh_create(int32_t node_count, const double (*position)[3],
                              int32_t triangle_count, const int32_t (*triangle)[3],
                              int32_t tetrahedron_count, const int32_t (*tetrahedron)[4],
                              ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    if (node_count < 1 || node_count > MAX_COUNT || triangle_count < 0 ||
        triangle_count > MAX_COUNT || tetrahedron_count < 0 || tetrahedron_count > MAX_COUNT ||
        (triangle_count == 0 && tetrahedron_count == 0)) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "a mesh of %d nodes, %d triangles and %d tetrahedra: give 1 to %d nodes "
                          "and at least one element",
                          node_count, triangle_count, tetrahedron_count, MAX_COUNT);
        return SOFTSIM_ERROR_MESH;
    }
    ss_mesh *mesh = ss_memory_get(1, sizeof *mesh);
    if (mesh == NULL) {
        goto fail;
    }
    mesh->node_count = node_count;
    mesh->tetrahedron_count = tetrahedron_count;
    mesh->position = copy_of(position, node_count, sizeof *position);
    mesh->tetrahedron = copy_of(tetrahedron, tetrahedron_count, sizeof *tetrahedron);
    if (mesh->position == NULL || mesh->tetrahedron == NULL) {
        goto fail;
    }
    if (triangle_count > 0) {
        mesh->triangle_count = triangle_count;
        mesh->triangle = copy_of(triangle, triangle_count, sizeof *triangle);
    } else if (!ss_mesh_extract_surface(mesh)) {
        goto fail;
    }
    if (mesh->triangle == NULL || !ss_mesh_find_closed(mesh)) {
        goto fail;
    }
    *out_mesh = mesh;
    return SOFTSIM_OK;

fail:
    ss_mesh_destroy(&mesh);
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a mesh of %d nodes",
                      node_count);
    return SOFTSIM_ERROR_MEMORY;
}

void ss_mesh_destroy(ss_mesh **mesh)
{
    if (mesh == NULL || *mesh == NULL) {
        return;
    }
    for (int32_t g = 0; g < (*mesh)->group_count; ++g) {
        ss_memory_free((*mesh)->group[g].node);
    }
    ss_memory_free((*mesh)->group);
    ss_memory_free((*mesh)->position);
    ss_memory_free((*mesh)->triangle);
    ss_memory_free((*mesh)->tetrahedron);
    ss_memory_free(*mesh);
    *mesh = NULL;
}

/* R = Rz Ry Rx. */
static void rotation(const double rotate_deg[3], double out[3][3])
{
    const double degree = 3.14159265358979323846 / 180.0;
    const double cx = cos(rotate_deg[0] * degree);
    const double sx = sin(rotate_deg[0] * degree);
    const double cy = cos(rotate_deg[1] * degree);
    const double sy = sin(rotate_deg[1] * degree);
    const double cz = cos(rotate_deg[2] * degree);
    const double sz = sin(rotate_deg[2] * degree);
    ss_set3(out[0], cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx);
    ss_set3(out[1], sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx);
    ss_set3(out[2], -sy, cy * sx, cy * cx);
}

void ss_mesh_transform(ss_mesh *mesh, double scale, const double rotate_deg[3],
                       const double translate_m[3])
{
    double r[3][3];
    rotation(rotate_deg, r);
    const bool is_rotated = rotate_deg[0] != 0.0 || rotate_deg[1] != 0.0 || rotate_deg[2] != 0.0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double *x = mesh->position[i];
        double y[3];
        ss_scale3(y, x, scale);
        if (is_rotated) {
            ss_set3(x, ss_dot3(r[0], y), ss_dot3(r[1], y), ss_dot3(r[2], y));
            ss_copy3(y, x);
        }
        ss_add3(x, y, translate_m);
    }
}

/* A third of the area vector; false for a triangle that cannot be measured. */
static bool third_area(const ss_mesh *mesh, const int32_t *node, double out[3])
{
    if (!ss_mesh_has_good_nodes(mesh, node, 3)) {
        return false;
    }
    double ab[3];
    double ac[3];
    ss_sub3(ab, mesh->position[node[1]], mesh->position[node[0]]);
    ss_sub3(ac, mesh->position[node[2]], mesh->position[node[0]]);
    ss_cross3(out, ab, ac);
    ss_scale3(out, out, 1.0 / 6.0);
    return true;
}

void ss_mesh_node_areas(const ss_mesh *mesh, double *out_area)
{
    memset(out_area, 0, (size_t)mesh->node_count * sizeof *out_area);
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double third[3];
        if (third_area(mesh, mesh->triangle[t], third)) {
            const double area = ss_norm3(third);
            for (int k = 0; k < 3; ++k) {
                out_area[mesh->triangle[t][k]] += area;
            }
        }
    }
}

void ss_mesh_node_area_vectors(const ss_mesh *mesh, double (*out_vector)[3])
{
    memset(out_vector, 0, (size_t)mesh->node_count * sizeof *out_vector);
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double third[3];
        if (third_area(mesh, mesh->triangle[t], third)) {
            for (int k = 0; k < 3; ++k) {
                double *vector = out_vector[mesh->triangle[t][k]];
                ss_add3(vector, vector, third);
            }
        }
    }
}

double ss_mesh_diagonal(const ss_mesh *mesh)
{
    double lowest[3] = {0.0, 0.0, 0.0};
    double highest[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double x = mesh->position[i][k];
            lowest[k] = i == 0 ? x : fmin(lowest[k], x);
            highest[k] = i == 0 ? x : fmax(highest[k], x);
        }
    }
    double diagonal[3];
    ss_sub3(diagonal, highest, lowest);
    return ss_norm3(diagonal);
}
