/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Rectangular grids and tetrahedra for the tests of models/. model_fixture.h comes first. */
#include "model_fixture.h"
#include "rt/memory.h"

/* ---- grids ---- */

/* rows x columns points, point (i, j) at i * columns + j; u runs along i, w along j, which closes
 * upon itself where `is_ring`. Triangles are the halves of the quads, diagonals alternating. */
static inline ss_mesh *make_grid(int rows, int columns, bool is_ring, const double (*position)[3])
{
    draft d;
    const int across = is_ring ? columns : columns - 1, count = (rows - 1) * across;
    draft_init(&d, rows * columns, 2 * count);
    int32_t(*quad)[4] = ss_memory_get((size_t)count, sizeof *quad);
    for (int n = 0; n < rows * columns; ++n) {
        draft_node(&d, position[n][0], position[n][1], position[n][2]);
    }
    for (int q = 0; q < count; ++q) {
        const int i = q / across, j = q % across, next = (j + 1) % columns;
        const int32_t c[4] = {i * columns + j, (i + 1) * columns + j, (i + 1) * columns + next,
                              i * columns + next};
        memcpy(quad[q], c, sizeof c);
        draft_quad(&d, c[0], c[1], c[2], c[3], (i + j) % 2 == 0);
    }
    ss_mesh *mesh = draft_finish(&d);
    mesh->quad = quad;
    mesh->quad_count = count;
    return mesh;
}

/* The cylinder of make_cylinder as a grid: u along the axis, w around. */
static inline ss_mesh *make_grid_cylinder(int rows, int columns, double radius, double length)
{
    double(*position)[3] = calloc((size_t)rows * (size_t)columns, sizeof *position);
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            const double angle = 2.0 * SS_PI * j / columns;
            ss_set3(position[i * columns + j], radius * sin(angle), radius * cos(angle),
                    length * ((double)i / (rows - 1) - 0.5));
        }
    }
    ss_mesh *mesh = make_grid(rows, columns, true, (const double(*)[3])position);
    free(position);
    return mesh;
}

/* Plane tensor grid in z = 0: rows at x[i], columns at y[j]. */
static inline ss_mesh *make_tensor_grid(int rows, int columns, const double *x, const double *y)
{
    double(*position)[3] = calloc((size_t)rows * (size_t)columns, sizeof *position);
    for (int n = 0; n < rows * columns; ++n) {
        ss_set3(position[n], x[n / columns], y[n % columns], 0.0);
    }
    ss_mesh *mesh = make_grid(rows, columns, false, (const double(*)[3])position);
    free(position);
    return mesh;
}

static inline void free_mesh(ss_mesh *mesh)
{
    ss_memory_free(mesh->quad);
    mesh->quad = NULL;
    ss_mesh_destroy(&mesh);
}

/* ---- tetrahedra ---- */

static const double regular_tetrahedron[4][3] = {
    {.01, .01, .01}, {.01, -.01, -.01}, {-.01, .01, -.01}, {-.01, -.01, .01}};

static inline ss_mesh *make_tetrahedra(int32_t nodes, const double (*position)[3], int32_t count,
                                       const int32_t (*tetrahedron)[4])
{
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(nodes, position, 0, NULL, count, tetrahedron, &mesh, NULL);
    return mesh;
}

/* Centre (node 0) and the twelve corners of an icosahedron at distance h: twenty tetrahedra. */
static inline ss_mesh *make_ball_fan(double h)
{
    ss_mesh *shell = make_ellipsoid(1, h, h, h);
    double position[13][3] = {{0.0}};
    int32_t tetrahedron[20][4];
    for (int32_t i = 0; i < 12; ++i) {
        ss_copy3(position[i + 1], shell->position[i]);
    }
    for (int32_t t = 0; t < 20; ++t) {
        const int32_t *c = shell->triangle[t];
        const int32_t nodes[4] = {0, c[0] + 1, c[1] + 1, c[2] + 1};
        memcpy(tetrahedron[t], nodes, sizeof nodes);
    }
    ss_mesh_destroy(&shell);
    return make_tetrahedra(13, (const double(*)[3])position, 20, (const int32_t(*)[4])tetrahedron);
}

/* Block of cells x cells x cells cubes of edge `size` / cells, centred, each six tetrahedra about
 * its diagonal (Kuhn 1960); node (i, j, k) at (i * (cells + 1) + j) * (cells + 1) + k. */
static inline ss_mesh *make_block(int cells, double size)
{
    static const int path[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int side = cells + 1, step[3] = {side * side, side, 1};
    double(*position)[3] = calloc((size_t)(side * side * side), sizeof *position);
    int32_t(*tetrahedron)[4] = calloc((size_t)(6 * cells * cells * cells), sizeof *tetrahedron);
    for (int n = 0; n < side * side * side; ++n) {
        for (int k = 0; k < 3; ++k) {
            position[n][k] = size * ((double)(n / step[k] % side) / cells - 0.5);
        }
    }
    int32_t count = 0;
    for (int cube = 0; cube < cells * cells * cells; ++cube) {
        const int at[3] = {cube / (cells * cells), cube / cells % cells, cube % cells};
        const int32_t first = at[0] * step[0] + at[1] * step[1] + at[2] * step[2];
        for (int m = 0; m < 6; ++m, ++count) {
            int32_t *c = tetrahedron[count];
            c[0] = first;
            for (int k = 0; k < 3; ++k) {
                c[k + 1] = c[k] + step[path[m][k]];
            }
            if (m == 1 || m == 2 || m == 5) { /* odd permutations are inside out */
                const int32_t swap = c[2];
                c[2] = c[3];
                c[3] = swap;
            }
        }
    }
    ss_mesh *mesh = make_tetrahedra(side * side * side, (const double(*)[3])position, count,
                                    (const int32_t(*)[4])tetrahedron);
    free(position);
    free(tetrahedron);
    return mesh;
}

/* ---- setups ---- */

static inline void give_direction(setup *s, double x, double y, double z)
{
    s->param[row_of(s, "material_direction")] =
        (ss_param_value){.direction = {x, y, z}, .is_given = true};
}

/* The published cylinder of 360 points as a grid or as triangles; node TOP is pushed. */
static inline void setup_either_cylinder(setup *s, bool is_grid, double damping)
{
    setup_cylinder(s, damping);
    if (is_grid) {
        ss_mesh_destroy(&s->mesh);
        s->mesh = make_grid_cylinder(15, 24, 1.0, 4.0);
        s->plan.mesh = s->mesh;
    }
}

/* Crumples the body by `size` and compares forces with differences of the potential. */
static inline void check_network_gradient(setup *s, double size)
{
    crumple(s, size);
    const double h = BY_TYPE(3e-3, 1e-5) * size / 0.1;
    double scale = 0.0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        double f;
        potential(s, i, i % 3, &f);
        scale = fmax(scale, fabs(f));
    }
    for (int trial = 0; trial < 40; ++trial) {
        const int32_t node = (int32_t)(fabs(random_unit()) * (s->mesh->node_count - 1));
        const int axis = trial % 3;
        if ((s->fixed[node] & 7) == 7) {
            continue;
        }
        double force, unused;
        potential(s, node, axis, &force);
        ss_real *u = s->model->u + 4 * (ptrdiff_t)node + axis;
        const ss_real before = *u;
        *u = (ss_real)((double)before + h);
        const double up = (double)*u, high = potential(s, node, axis, &unused);
        u = s->model->u + 4 * (ptrdiff_t)node + axis;
        *u = (ss_real)((double)before - h);
        const double down = (double)*u, low = potential(s, node, axis, &unused);
        u = s->model->u + 4 * (ptrdiff_t)node + axis;
        *u = before;
        assert_near(-(high - low) / (up - down), force, BY_TYPE(5e-3, 1e-7) * scale);
    }
}
