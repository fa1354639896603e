/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Blocks of tetrahedra: shared by the tests of finite elements. cmocka comes first. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "mesh/mesh.h"
#include "mesh/tetrahedron.h"
#include "number_fixture.h"

typedef struct block_size {
    int cells[3];
    double size[3]; /* m */
    double jitter;  /* of a cell, inner nodes; at 0.45 some elements are slivers */
    double offset;  /* m, of all coordinates */
} block_size;

static inline int32_t block_node(const block_size *b, int i, int j, int k)
{
    return (k * (b->cells[1] + 1) + j) * (b->cells[0] + 1) + i;
}

/* A mesh of them, which are freed. */
static inline ss_mesh *take_tetrahedra(int32_t nodes, double (*x)[3], int32_t count,
                                       int32_t (*tetrahedron)[4])
{
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(nodes, (const double(*)[3])x, 0, NULL, count,
                                    (const int32_t(*)[4])tetrahedron, &mesh, NULL),
                     SOFTSIM_OK);
    free(x);
    free(tetrahedron);
    return mesh;
}

/* Cells of six tetrahedra around a diagonal, all volumes above 0. */
static inline ss_mesh *make_block(const block_size *b)
{
    static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int nx = b->cells[0], ny = b->cells[1], nz = b->cells[2];
    const int32_t nodes = (nx + 1) * (ny + 1) * (nz + 1), count = 6 * nx * ny * nz;
    double(*x)[3] = calloc((size_t)nodes, sizeof *x);
    int32_t(*t)[4] = calloc((size_t)count, sizeof *t), e = 0;
    for (int k = 0; k <= nz; ++k) {
        for (int j = 0; j <= ny; ++j) {
            for (int i = 0; i <= nx; ++i) {
                const int at[3] = {i, j, k};
                double *p = x[block_node(b, i, j, k)];
                const bool is_inner = i > 0 && j > 0 && k > 0 && i < nx && j < ny && k < nz;
                for (int a = 0; a < 3; ++a) {
                    const double jump = is_inner ? b->jitter * random_unit() : 0.0;
                    p[a] = b->offset + b->size[a] * (at[a] + jump) / b->cells[a];
                }
            }
        }
    }
    for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j) {
            for (int i = 0; i < nx; ++i) {
                for (int p = 0; p < 6; ++p, ++e) {
                    int at[3] = {i, j, k};
                    double g[4][3];
                    t[e][0] = block_node(b, i, j, k);
                    for (int s = 0; s < 3; ++s) {
                        ++at[order[p][s]];
                        t[e][s + 1] = block_node(b, at[0], at[1], at[2]);
                    }
                    if (ss_tetrahedron_gradients(x[t[e][0]], x[t[e][1]], x[t[e][2]], x[t[e][3]],
                                                 g) < 0.0) {
                        const int32_t swap = t[e][2];
                        t[e][2] = t[e][3];
                        t[e][3] = swap;
                    }
                }
            }
        }
    }
    return take_tetrahedra(nodes, x, count, t);
}
