/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes and networks: shared by the tests of chains. cmocka comes first. */
#include "models/chain/chain.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "setup_fixture.h"

#define assert_below(a, b)                                                                         \
    do {                                                                                           \
        const double below_a = (a), below_b = (b);                                                 \
        if (!(below_a < below_b)) {                                                                \
            fail_msg("%s = %.17g, expected below %.17g", #a, below_a, below_b);                    \
        }                                                                                          \
    } while (0)

/* ---- meshes ---- */

/* Cubes of edge h, six tetrahedra each; node (i, j, k) is (k ny + j) nx + i, from the origin. */
static inline ss_mesh *make_box(int nx, int ny, int nz, double h)
{
    static const int path[6][2] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
    const int stride[3] = {1, nx, nx * ny};
    double(*position)[3] = calloc((size_t)(nx * ny * nz), sizeof *position);
    int32_t(*tet)[4] = calloc((size_t)(6 * nx * ny * nz), sizeof *tet);
    int32_t count = 0;
    for (int n = 0; n < nx * ny * nz; ++n) {
        const int at[3] = {n % nx, n / nx % ny, n / (nx * ny)};
        for (int a = 0; a < 3; ++a) {
            position[n][a] = h * at[a];
        }
        for (int p = 0; p < 6 && at[0] + 1 < nx && at[1] + 1 < ny && at[2] + 1 < nz; ++p) {
            const int a = path[p][0], b = path[p][1];
            const bool is_even = (b - a + 3) % 3 == 1;
            const int32_t last = n + stride[0] + stride[1] + stride[2];
            const int32_t first = n + stride[a], second = n + stride[a] + stride[b];
            tet[count][0] = n;
            tet[count][1] = is_even ? first : second;
            tet[count][2] = is_even ? second : first;
            tet[count++][3] = last;
        }
    }
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(nx * ny * nz, (const double(*)[3])position, 0, NULL, count,
                         (const int32_t(*)[4])tet, &mesh, NULL);
    free(position);
    free(tet);
    return mesh;
}

/* `points` on a circle around node 0, and triangles between them: a star of `points` links and a
 * rim of as many. */
static inline ss_mesh *make_star(int points)
{
    double(*position)[3] = calloc((size_t)points + 1, sizeof *position);
    int32_t(*triangle)[3] = calloc((size_t)points, sizeof *triangle);
    for (int k = 0; k < points; ++k) {
        const double angle = 2.0 * SS_PI * k / points;
        ss_set3(position[k + 1], cos(angle), sin(angle), 0.0);
        triangle[k][1] = k + 1;
        triangle[k][2] = (k + 1) % points + 1;
    }
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(points + 1, (const double(*)[3])position, points,
                         (const int32_t(*)[3])triangle, 0, NULL, &mesh, NULL);
    free(position);
    free(triangle);
    return mesh;
}

/* A grid of quads, n by n nodes a metre apart, in z = 0 about the origin. */
static inline ss_mesh *make_plane(int n)
{
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create_plane(n, n, n - 1.0, n - 1.0, &mesh, NULL);
    return mesh;
}

/* One triangle of sides 1, nodes (0, 0, 0), (1, 0, 0) and one far enough to be another matter. */
static inline ss_mesh *make_triangle(double far)
{
    const double position[3][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, far, 0}};
    const int32_t triangle[1][3] = {{0, 1, 2}};
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(3, position, 1, triangle, 0, NULL, &mesh, NULL);
    return mesh;
}

/* ---- a network ---- */

/* C = 1 s, k = 1 N/m, no coarse level and no guard: the network alone. */
static inline void setup_network(setup *s, ss_mesh *mesh, double alpha)
{
    setup_init(s, "cnn-chainmail", mesh);
    give(s, "alpha", alpha);
    give(s, "link_stiffness_n_per_m", 1.0);
    give(s, "capacitance_s", 1.0);
    give(s, "coarse_cells", 0.0);
    give(s, "tet_guard", 0.0);
}

/* Into another frame. */
static inline void turn(double x[3])
{
    static const double r[3][3] = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0.0}, {0.48, 0.64, 0.6}};
    const double from[3] = {x[0], x[1], x[2]};
    for (int k = 0; k < 3; ++k) {
        x[k] = ss_dot3(r[k], from);
    }
}
