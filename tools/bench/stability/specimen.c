/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/specimen.h"

#include <math.h>

#include "rt/vec.h"

/* 0: a cube, 1: a ball. */
static const double roundness = 0.5;

static int32_t node_at(int i, int j, int k)
{
    return i + SS_SPECIMEN_SIDE * (j + SS_SPECIMEN_SIDE * k);
}

/* A cube's points move towards the ball that touches its sides. */
static void place(int i, int j, int k, double out[3])
{
    const double cell = 2.0 / SS_SPECIMEN_CELLS;
    double p[3] = {cell * i - 1.0, cell * j - 1.0, cell * k - 1.0};
    const double length = ss_norm3(p);
    const double side = fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2])));
    const double share = length > 0.0 ? 1.0 - roundness + roundness * side / length : 1.0;
    ss_scale3(out, p, 0.5 * SS_SPECIMEN_SIZE * share);
}

static double volume(const double a[3], const double b[3], const double c[3], const double d[3])
{
    double x[3], y[3], z[3], n[3];
    ss_sub3(x, b, a);
    ss_sub3(y, c, a);
    ss_sub3(z, d, a);
    ss_cross3(n, x, y);
    return ss_dot3(n, z) / 6.0;
}

/* Six tetrahedra a cell: one for each order in which a path along its edges takes the axes. */
static void fill_cell(ss_specimen *s, int i, int j, int k, int32_t *count)
{
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int t = 0; t < 6; ++t) {
        int at[3] = {i, j, k};
        int32_t *node = s->tetrahedron[(*count)++];
        node[0] = node_at(i, j, k);
        for (int step = 0; step < 3; ++step) {
            ++at[order[t][step]];
            node[step + 1] = node_at(at[0], at[1], at[2]);
        }
        if (volume(s->rest[node[0]], s->rest[node[1]], s->rest[node[2]], s->rest[node[3]]) < 0.0) {
            const int32_t swap = node[2];
            node[2] = node[3];
            node[3] = swap;
        }
    }
}

/* Moves `node` towards the middle of the side opposite to it in one of its tetrahedra, or in one of
 * its triangles of the top, until `flatness` of the way is left: no element of its star turns over,
 * since the star is convex. */
static void flatten(ss_specimen *s, int32_t node, double flatness, bool is_top)
{
    for (int32_t t = 0; t < SS_SPECIMEN_TETRAHEDRA; ++t) {
        const int32_t *corner = s->tetrahedron[t];
        double middle[3] = {0.0, 0.0, 0.0};
        int others = 0;
        bool has_node = false;
        for (int c = 0; c < 4; ++c) {
            has_node |= corner[c] == node;
            if (corner[c] != node && (!is_top || corner[c] >= SS_SPECIMEN_TOP)) {
                ss_add3(middle, middle, s->rest[corner[c]]);
                ++others;
            }
        }
        if (has_node && others == (is_top ? 2 : 3)) {
            double way[3];
            ss_scale3(middle, middle, 1.0 / others);
            ss_sub3(way, s->rest[node], middle);
            ss_madd3(s->rest[node], middle, flatness, way);
            return;
        }
    }
}

void ss_specimen_make(double flatness, ss_specimen *out)
{
    int32_t count = 0;
    for (int k = 0; k < SS_SPECIMEN_SIDE; ++k) {
        for (int j = 0; j < SS_SPECIMEN_SIDE; ++j) {
            for (int i = 0; i < SS_SPECIMEN_SIDE; ++i) {
                place(i, j, k, out->rest[node_at(i, j, k)]);
            }
        }
    }
    for (int k = 0; k < SS_SPECIMEN_CELLS; ++k) {
        for (int j = 0; j < SS_SPECIMEN_CELLS; ++j) {
            for (int i = 0; i < SS_SPECIMEN_CELLS; ++i) {
                fill_cell(out, i, j, k, &count);
            }
        }
    }
    if (flatness < 1.0) {
        const int half = SS_SPECIMEN_CELLS / 2;
        flatten(out, node_at(half, half, half), flatness, false);
        flatten(out, node_at(half + 1, half, SS_SPECIMEN_CELLS), flatness, true);
    }
}

bool ss_specimen_is_surface(int32_t node)
{
    const int32_t last = SS_SPECIMEN_CELLS;
    const int32_t i = node % SS_SPECIMEN_SIDE, j = node / SS_SPECIMEN_SIDE % SS_SPECIMEN_SIDE;
    const int32_t k = node / SS_SPECIMEN_LAYER;
    return i == 0 || i == last || j == 0 || j == last || k == 0 || k == last;
}

void ss_specimen_write(const ss_specimen *s, FILE *file)
{
    fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", SS_SPECIMEN_NODES);
    for (int32_t i = 0; i < SS_SPECIMEN_NODES; ++i) {
        fprintf(file, "%d %.17g %.17g %.17g\n", i + 1, s->rest[i][0], s->rest[i][1], s->rest[i][2]);
    }
    fprintf(file, "$EndNodes\n$Elements\n%d\n", SS_SPECIMEN_TETRAHEDRA);
    for (int32_t t = 0; t < SS_SPECIMEN_TETRAHEDRA; ++t) {
        const int32_t *node = s->tetrahedron[t];
        fprintf(file, "%d 4 2 1 1 %d %d %d %d\n", t + 1, node[0] + 1, node[1] + 1, node[2] + 1,
                node[3] + 1);
    }
    fputs("$EndElements\n", file);
}

int32_t ss_specimen_inverted(const ss_specimen *s, const double (*u)[3])
{
    int32_t count = 0;
    for (int32_t t = 0; t < SS_SPECIMEN_TETRAHEDRA; ++t) {
        double p[4][3];
        for (int c = 0; c < 4; ++c) {
            const int32_t node = s->tetrahedron[t][c];
            ss_add3(p[c], s->rest[node], u[node]);
        }
        count += !(volume(p[0], p[1], p[2], p[3]) > 0.0);
    }
    return count;
}
