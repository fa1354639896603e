/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Life of a mesh, and its simplest measures. Area of a triangle (a, b, c): the vector
 * A = (b - a) x (c - a) / 2, a third of it to each corner: the areas of the nodes sum to the
 * area of the surface exactly. (Voronoi areas, which a paper may use for curvature, go negative on
 * obtuse triangles and were rejected.)
 *
 * A quad with the corner vectors A_k = (p_k+1 - p_k) x (p_k-1 - p_k) / 2 is A_1 and A_3 when cut
 * along 0-2, A_0 and A_2 along 1-3. The mean of the two cuts gives corner k
 *   (A_0 + A_1 + A_2 + A_3 - A_k+2) / 6,
 * with areas for vectors the same way: A/4 on a rectangle, and no node is favoured for the
 * diagonals that end in it (thirds of one cut alone give the nodes of a grid 4A/3 and 2A/3 in
 * turn). A dart has one cut inside it, and that one counts.
 */
#include "mesh/mesh.h"

#include "mesh/topology.h"
#include "rt/each.h"
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

static softsim_status fail_create(ss_mesh **mesh, int32_t node_count, softsim_error *error)
{
    ss_mesh_destroy(mesh);
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a mesh of %d nodes",
                      node_count);
    return SOFTSIM_ERROR_MEMORY;
}

/* A mesh of nodes alone; NULL when out of memory. */
static ss_mesh *create_nodes(int32_t node_count, const double (*position)[3])
{
    ss_mesh *mesh = ss_memory_get(1, sizeof *mesh);
    if (mesh != NULL) {
        mesh->node_count = node_count;
        mesh->position = copy_of(position, node_count, sizeof *position);
    }
    if (mesh != NULL && mesh->position == NULL) {
        ss_mesh_destroy(&mesh);
    }
    return mesh;
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
    ss_mesh *mesh = create_nodes(node_count, position);
    if (mesh == NULL) {
        return fail_create(&mesh, node_count, error);
    }
    mesh->tetrahedron_count = tetrahedron_count;
    mesh->tetrahedron = copy_of(tetrahedron, tetrahedron_count, sizeof *tetrahedron);
    if (mesh->tetrahedron == NULL) {
        return fail_create(&mesh, node_count, error);
    }
    if (triangle_count > 0) {
        mesh->triangle_count = triangle_count;
        mesh->triangle = copy_of(triangle, triangle_count, sizeof *triangle);
    } else if (!ss_mesh_extract_surface(mesh)) {
        return fail_create(&mesh, node_count, error);
    }
    if (mesh->triangle == NULL || !ss_mesh_find_closed(mesh)) {
        return fail_create(&mesh, node_count, error);
    }
    *out_mesh = mesh;
    return SOFTSIM_OK;
}

static bool take_tens(ss_mesh *mesh, int32_t count, const int32_t (*tetrahedron)[10])
{
    mesh->tetrahedron_count = count;
    mesh->tetrahedron = ss_memory_get((size_t)count, sizeof *mesh->tetrahedron);
    mesh->middle = ss_memory_get((size_t)count, sizeof *mesh->middle);
    for (int32_t e = 0; mesh->tetrahedron && mesh->middle && e < count; ++e) {
        memcpy(mesh->tetrahedron[e], tetrahedron[e], sizeof *mesh->tetrahedron);
        memcpy(mesh->middle[e], tetrahedron[e] + 4, sizeof *mesh->middle);
    }
    return mesh->tetrahedron != NULL && mesh->middle != NULL;
}

softsim_status ss_mesh_create_second_order(int32_t node_count, const double (*position)[3],
                                           int32_t tetrahedron_count,
                                           const int32_t (*tetrahedron)[10], ss_mesh **out_mesh,
                                           softsim_error *error)
{
    *out_mesh = NULL;
    if (node_count < 1 || node_count > MAX_COUNT || tetrahedron_count < 1 ||
        tetrahedron_count > MAX_COUNT) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "a mesh of %d nodes and %d tetrahedra: give 1 to %d of both", node_count,
                          tetrahedron_count, MAX_COUNT);
        return SOFTSIM_ERROR_MESH;
    }
    ss_mesh *mesh = create_nodes(node_count, position);
    if (mesh == NULL || !take_tens(mesh, tetrahedron_count, tetrahedron) ||
        !ss_mesh_extract_surface(mesh) || !ss_mesh_find_closed(mesh)) {
        return fail_create(&mesh, node_count, error);
    }
    *out_mesh = mesh;
    return SOFTSIM_OK;
}

softsim_status ss_mesh_create_quads(int32_t node_count, const double (*position)[3],
                                    int32_t quad_count, const int32_t (*quad)[4],
                                    ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    if (node_count < 1 || node_count > MAX_COUNT || quad_count < 1 || quad_count > MAX_COUNT / 2) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "a mesh of %d nodes and %d quads: give 1 to %d nodes and 1 to %d quads",
                          node_count, quad_count, MAX_COUNT, MAX_COUNT / 2);
        return SOFTSIM_ERROR_MESH;
    }
    ss_mesh *mesh = create_nodes(node_count, position);
    if (mesh == NULL) {
        return fail_create(&mesh, node_count, error);
    }
    mesh->quad_count = quad_count;
    mesh->triangle_count = 2 * quad_count;
    mesh->quad = copy_of(quad, quad_count, sizeof *quad);
    mesh->tetrahedron = ss_memory_get(0, sizeof *mesh->tetrahedron);
    mesh->triangle = ss_memory_get((size_t)mesh->triangle_count, sizeof *mesh->triangle);
    if (mesh->quad == NULL || mesh->tetrahedron == NULL || mesh->triangle == NULL ||
        !ss_mesh_arrange_quads(mesh) || !ss_mesh_find_closed(mesh)) {
        return fail_create(&mesh, node_count, error);
    }
    *out_mesh = mesh;
    return SOFTSIM_OK;
}

void ss_mesh_destroy(ss_mesh **mesh)
{
    if (mesh == NULL || *mesh == NULL) {
        return;
    }
    for (int32_t g = 0; g < (*mesh)->group_count; ++g) {
        ss_memory_free((*mesh)->group[g].node);
    }
    SS_EACH(ss_memory_free, (*mesh)->group, (*mesh)->position, (*mesh)->triangle, (*mesh)->quad,
            (*mesh)->file_node, (*mesh)->file_element, (*mesh)->tetrahedron, (*mesh)->middle,
            *mesh);
    *mesh = NULL;
}

/* R = Rz Ry Rx. */
static void rotation(const double rotate_deg[3], double out[3][3])
{
    const double degree = SS_PI / 180.0;
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

/* What an element gives its corners; their count, 0 for an element that cannot be measured. */
static int share(const ss_mesh *mesh, const int32_t *node, double out_area[4],
                 double out_vector[4][3])
{
    const int corners = mesh->quad_count > 0 ? 4 : 3;
    if (!ss_mesh_has_good_nodes(mesh, node, corners)) {
        return 0;
    }
    if (corners == 4) {
        ss_mesh_share_quad(mesh, node, out_area, out_vector);
        return corners;
    }
    double third[3];
    ss_normal3(third, mesh->position[node[0]], mesh->position[node[1]], mesh->position[node[2]]);
    ss_scale3(third, third, 1.0 / 6.0);
    for (int k = 0; k < 3; ++k) {
        out_area[k] = ss_norm3(third);
        ss_copy3(out_vector[k], third);
    }
    return corners;
}

/* Either output may be NULL. */
static void sum_shares(const ss_mesh *mesh, double *out_area, double (*out_vector)[3])
{
    const int32_t count = mesh->quad_count > 0 ? mesh->quad_count : mesh->triangle_count;
    for (int32_t e = 0; e < count; ++e) {
        const int32_t *node = mesh->quad_count > 0 ? mesh->quad[e] : mesh->triangle[e];
        double area[4], vector[4][3];
        const int corners = share(mesh, node, area, vector);
        for (int k = 0; k < corners; ++k) {
            if (out_area != NULL) {
                out_area[node[k]] += area[k];
            }
            if (out_vector != NULL) {
                ss_add3(out_vector[node[k]], out_vector[node[k]], vector[k]);
            }
        }
    }
}

void ss_mesh_node_areas(const ss_mesh *mesh, double *out_area)
{
    memset(out_area, 0, (size_t)mesh->node_count * sizeof *out_area);
    sum_shares(mesh, out_area, NULL);
}

void ss_mesh_node_area_vectors(const ss_mesh *mesh, double (*out_vector)[3])
{
    memset(out_vector, 0, (size_t)mesh->node_count * sizeof *out_vector);
    sum_shares(mesh, NULL, out_vector);
}

double ss_mesh_diagonal(const ss_mesh *mesh)
{
    double lowest[3], highest[3], diagonal[3];
    ss_bounds3(mesh->node_count, (const double(*)[3])mesh->position, lowest, highest);
    ss_sub3(diagonal, highest, lowest);
    return ss_norm3(diagonal);
}

double ss_mesh_radius(const ss_mesh *mesh, double out_middle[3])
{
    double most = 0.0;
    ss_set3(out_middle, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        ss_madd3(out_middle, out_middle, 1.0 / mesh->node_count, mesh->position[i]);
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double r[3];
        ss_sub3(r, mesh->position[i], out_middle);
        most = fmax(most, ss_norm3(r));
    }
    return most;
}

int32_t ss_mesh_node_normal(const ss_mesh *mesh, int32_t node, double out_normal[3])
{
    int32_t count = 0;
    double first[3] = {0.0, 0.0, 0.0};
    ss_set3(out_normal, 0.0, 0.0, 0.0);
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        if (c[0] == node || c[1] == node || c[2] == node) {
            double n[3];
            ss_normal3(n, mesh->position[c[0]], mesh->position[c[1]], mesh->position[c[2]]);
            ss_add3(out_normal, out_normal, n);
            if (count++ == 0) {
                ss_copy3(first, n);
            }
        }
    }
    if (!(ss_norm3(out_normal) > 1e-9 * ss_norm3(first))) { /* where parts of a body touch */
        ss_copy3(out_normal, first);
    }
    return ss_normalize3(out_normal) > 0.0 ? count : 0;
}

double ss_mesh_mean_side(const double (*position)[3], const int32_t (*triangle)[3], int32_t count)
{
    double sum = 0.0;
    for (int32_t t = 0; t < count; ++t) {
        for (int k = 0; k < 3; ++k) {
            double way[3];
            ss_sub3(way, position[triangle[t][(k + 1) % 3]], position[triangle[t][k]]);
            sum += ss_norm3(way);
        }
    }
    return sum / (3.0 * count);
}
