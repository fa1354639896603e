/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Cells of more than four corners are split into tetrahedra that conform across common faces,
 * without further nodes (Dompierre, Labbe, Vallet, Camarero, How to subdivide pyramids, prisms and
 * hexahedra into tetrahedra, 1999): each quadrangle is cut along the diagonal that starts at its
 * lowest node, which both of its cells agree upon. Inside, the cell is a cone from its lowest node
 * over the triangles of those faces that do not have that node: the faces that have it are cut from
 * it, so all of them are sides of the cone.
 *
 *   hexahedron: 3 faces, 6 tetrahedra; prism: 1 and a triangle, 3; pyramid: 2
 *
 * The paper's fifth-tetrahedron case (no diagonal at the corner opposite the lowest) was rejected:
 * the number of tetrahedra is known from the kinds alone, as an array's size must be.
 *
 * Cells that are collapsed, with a node twice, are common: pieces with a node twice are left out,
 * and faces still conform. VTK's manual winds the prism's base the other way than its files mostly
 * do; a cell whose pieces are all negative is therefore turned. One with pieces of both signs is
 * folded, and no model could run it.
 */
#include "mesh/cells.h"

#include "rt/vec.h"

#include <string.h>

/* Corners counter-clockwise from outside; triangles have -1 at their end. */
static const int8_t hexahedron[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
static const int8_t prism[5][4] = {
    {0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
static const int8_t pyramid[5][4] = {
    {0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};

static const struct {
    const int8_t (*face)[4];
    int8_t faces, corners, pieces;
} cells[SS_MESH_KIND_COUNT] = {[SS_MESH_HEXAHEDRON] = {hexahedron, 6, 8, 6},
                               [SS_MESH_PRISM] = {prism, 5, 6, 3},
                               [SS_MESH_PYRAMID] = {pyramid, 5, 5, 2}};

/* Relative to the sum of the absolute volumes: below it a piece has neither sign. */
static const double flat = 1e-12;

int ss_mesh_cell_pieces(ss_mesh_kind kind)
{
    return cells[kind].pieces;
}

static bool is_repeated(const int32_t node[4])
{
    return node[0] == node[1] || node[0] == node[2] || node[0] == node[3] || node[1] == node[2] ||
           node[1] == node[3] || node[2] == node[3];
}

static int cut_cell(ss_mesh_kind kind, const int32_t *node, int32_t out[SS_CELL_PIECES][4])
{
    int count = 0;
    int32_t lowest = node[0];
    for (int k = 1; k < cells[kind].corners; ++k) {
        lowest = node[k] < lowest ? node[k] : lowest;
    }
    for (int f = 0; f < cells[kind].faces; ++f) {
        const int8_t *face = cells[kind].face[f];
        const int corners = face[3] < 0 ? 3 : 4;
        int first = 0;
        for (int k = 1; k < corners; ++k) {
            first = node[face[k]] < node[face[first]] ? k : first;
        }
        const int32_t start = node[face[first]];
        for (int k = 1; k + 1 < corners && start != lowest; ++k) {
            const int32_t piece[4] = {lowest, start, node[face[(first + k) % corners]],
                                      node[face[(first + k + 1) % corners]]};
            if (!is_repeated(piece)) {
                memcpy(out[count++], piece, sizeof piece);
            }
        }
    }
    return count;
}

int ss_mesh_split_cell(ss_mesh_kind kind, const double (*position)[3], const int32_t *node,
                       int32_t out[SS_CELL_PIECES][4])
{
    const int count = cut_cell(kind, node, out);
    double volume[SS_CELL_PIECES];
    double sum = 0.0;
    int negative = 0, positive = 0;
    for (int p = 0; p < count; ++p) {
        volume[p] = ss_six_volumes3(position[out[p][0]], position[out[p][1]], position[out[p][2]],
                                    position[out[p][3]]);
        sum += fabs(volume[p]);
    }
    for (int p = 0; p < count; ++p) {
        negative += volume[p] < -flat * sum;
        positive += volume[p] > flat * sum;
    }
    if (negative > 0 && positive > 0) {
        return -1;
    }
    for (int p = 0; p < count && negative > 0; ++p) {
        const int32_t swap = out[p][2];
        out[p][2] = out[p][3];
        out[p][3] = swap;
    }
    return count;
}
