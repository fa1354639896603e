/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Wrecks: surfaces and volumes that are made whole, then damaged as files are found damaged, and
 * written in the formats that they come in. cmocka and tool_fixture.h come first.
 */
#include <math.h>

#include "rt/vec.h"

enum { WRECK_NODES = 8192, WRECK_FACES = 8192, WRECK_TETRAHEDRA = 1024 };

typedef struct wreck {
    double x[WRECK_NODES][3];
    int32_t face[WRECK_FACES][4]; /* the last is -1 of a triangle */
    int32_t tetrahedron[WRECK_TETRAHEDRA][4];
    int32_t nodes, faces, tetrahedra;
} wreck;

static inline int32_t add_point(wreck *w, double x, double y, double z)
{
    assert_true(w->nodes < WRECK_NODES);
    ss_set3(w->x[w->nodes], x, y, z);
    return w->nodes++;
}

static inline void add_face(wreck *w, int32_t a, int32_t b, int32_t c, int32_t d)
{
    assert_true(w->faces < WRECK_FACES);
    const int32_t face[4] = {a, b, c, d};
    memcpy(w->face[w->faces++], face, sizeof face);
}

/* A box by its corners, outward; `is_quads`: of six quads. */
static inline void add_box(wreck *w, const double low[3], const double high[3], bool is_quads)
{
    static const int32_t side[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const int32_t at = w->nodes;
    for (int i = 0; i < 8; ++i) {
        add_point(w, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
    }
    for (int s = 0; s < 6; ++s) {
        const int32_t *n = side[s];
        if (is_quads) {
            add_face(w, at + n[0], at + n[1], at + n[2], at + n[3]);
        } else {
            add_face(w, at + n[0], at + n[1], at + n[2], -1);
            add_face(w, at + n[0], at + n[2], at + n[3], -1);
        }
    }
}

/* An octahedron about `middle`, its faces divided in four `levels` times, pushed out to a sphere:
 * 8 4^levels triangles, with nodes on the three great circles of the axes. */
static inline int32_t middle_of(wreck *w, int32_t from, int32_t a, int32_t b,
                                const double middle[3], double radius)
{
    double x[3], d[3];
    ss_add3(x, w->x[a], w->x[b]);
    ss_scale3(x, x, 0.5);
    ss_sub3(d, x, middle);
    (void)ss_normalize3(d);
    ss_madd3(x, middle, radius, d);
    for (int32_t i = from; i < w->nodes; ++i) {
        ss_sub3(d, w->x[i], x);
        if (ss_norm3(d) < 1e-9 * radius) {
            return i;
        }
    }
    return add_point(w, x[0], x[1], x[2]);
}

static inline void add_sphere(wreck *w, const double middle[3], double radius, int levels)
{
    static const int32_t eight[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                        {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const int32_t nodes = w->nodes, faces = w->faces;
    for (int i = 0; i < 6; ++i) {
        double x[3];
        ss_copy3(x, middle);
        x[i / 2] += i % 2 == 0 ? radius : -radius;
        add_point(w, x[0], x[1], x[2]);
    }
    for (int i = 0; i < 8; ++i) {
        add_face(w, nodes + eight[i][0], nodes + eight[i][1], nodes + eight[i][2], -1);
    }
    for (int level = 0; level < levels; ++level) {
        const int32_t count = w->faces;
        for (int32_t f = faces; f < count; ++f) {
            int32_t *n = w->face[f];
            const int32_t ab = middle_of(w, nodes, n[0], n[1], middle, radius);
            const int32_t bc = middle_of(w, nodes, n[1], n[2], middle, radius);
            const int32_t ca = middle_of(w, nodes, n[2], n[0], middle, radius);
            add_face(w, n[0], ab, ca, -1);
            add_face(w, ab, n[1], bc, -1);
            add_face(w, ca, bc, n[2], -1);
            n[0] = ab;
            n[1] = bc;
            n[2] = ca;
        }
    }
}

static inline void turn_face(wreck *w, int32_t f)
{
    const int32_t second = w->face[f][1];
    const int last = w->face[f][3] < 0 ? 2 : 3;
    w->face[f][1] = w->face[f][last];
    w->face[f][last] = second;
}

static inline void drop_face(wreck *w, int32_t f)
{
    memmove(w->face[f], w->face[f + 1], (size_t)(--w->faces - f) * sizeof w->face[0]);
}

/* Every node `from` becomes `to`. */
static inline void join_points(wreck *w, int32_t from, int32_t to)
{
    for (int32_t i = 0; i < 4 * w->faces; ++i) {
        if (w->face[i / 4][i % 4] == from) {
            w->face[i / 4][i % 4] = to;
        }
    }
}

static inline int32_t find_point(const wreck *w, double x, double y, double z, int32_t from)
{
    for (int32_t i = from; i < w->nodes; ++i) {
        if (fabs(w->x[i][0] - x) + fabs(w->x[i][1] - y) + fabs(w->x[i][2] - z) < 1e-9) {
            return i;
        }
    }
    return -1;
}

/* Every face its own nodes, each moved by up to `noise`. */
static inline void scatter(wreck *w, double noise, uint64_t *random)
{
    const int32_t before = w->nodes;
    for (int32_t f = 0; f < w->faces; ++f) {
        for (int k = 0; k < (w->face[f][3] < 0 ? 3 : 4); ++k) {
            const double *x = w->x[w->face[f][k]];
            double moved[3];
            for (int c = 0; c < 3; ++c) {
                moved[c] = x[c] + noise * (2.0 * ss_random_unit(random) - 1.0);
            }
            w->face[f][k] = add_point(w, moved[0], moved[1], moved[2]);
        }
    }
    memmove(w->x, w->x + before, (size_t)(w->nodes - before) * sizeof w->x[0]);
    w->nodes -= before;
    for (int32_t i = 0; i < 4 * w->faces; ++i) {
        int32_t *node = &w->face[i / 4][i % 4];
        *node -= *node >= 0 ? before : 0;
    }
}

/* ---- formats ---- */

static inline void write_obj_text(const wreck *w, FILE *file)
{
    for (int32_t i = 0; i < w->nodes; ++i) {
        (void)fprintf(file, "v %.17g %.17g %.17g\n", w->x[i][0], w->x[i][1], w->x[i][2]);
    }
    for (int32_t f = 0; f < w->faces; ++f) {
        (void)fputs("f", file);
        for (int k = 0; k < (w->face[f][3] < 0 ? 3 : 4); ++k) {
            (void)fprintf(file, " %d", w->face[f][k] + 1);
        }
        (void)fputc('\n', file);
    }
}

static inline void write_stl_text(const wreck *w, FILE *file)
{
    (void)fputs("solid wreck\n", file);
    for (int32_t f = 0; f < w->faces; ++f) {
        (void)fputs("facet normal 0 0 0\nouter loop\n", file);
        for (int k = 0; k < 3; ++k) {
            const double *x = w->x[w->face[f][k]];
            (void)fprintf(file, "vertex %.9g %.9g %.9g\n", x[0], x[1], x[2]);
        }
        (void)fputs("endloop\nendfacet\n", file);
    }
    (void)fputs("endsolid wreck\n", file);
}

static inline void write_stl_bytes(const wreck *w, FILE *file)
{
    const char head[80] = "wreck";
    const uint32_t count = (uint32_t)w->faces;
    (void)fwrite(head, 1, sizeof head, file);
    (void)fwrite(&count, sizeof count, 1, file);
    for (int32_t f = 0; f < w->faces; ++f) {
        float number[12] = {0};
        const uint16_t none = 0;
        for (int i = 0; i < 9; ++i) {
            number[3 + i] = (float)w->x[w->face[f][i / 3]][i % 3];
        }
        (void)fwrite(number, sizeof number, 1, file);
        (void)fwrite(&none, sizeof none, 1, file);
    }
}

/* A face a line, its number of corners first: as PLY, OFF and VTK have it. */
static inline void write_faces(const wreck *w, FILE *file)
{
    for (int32_t f = 0; f < w->faces; ++f) {
        const int corners = w->face[f][3] < 0 ? 3 : 4;
        (void)fprintf(file, "%d", corners);
        for (int k = 0; k < corners; ++k) {
            (void)fprintf(file, " %d", w->face[f][k]);
        }
        (void)fputc('\n', file);
    }
}

/* What PLY and OFF have in common. */
static inline void write_rows(const wreck *w, FILE *file)
{
    for (int32_t i = 0; i < w->nodes; ++i) {
        (void)fprintf(file, "%.9g %.9g %.9g\n", w->x[i][0], w->x[i][1], w->x[i][2]);
    }
    write_faces(w, file);
}

static inline void write_ply_text(const wreck *w, FILE *file)
{
    (void)fprintf(file,
                  "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
                  "property float z\nelement face %d\nproperty list uchar int vertex_indices\n"
                  "end_header\n",
                  w->nodes, w->faces);
    write_rows(w, file);
}

static inline void write_off_text(const wreck *w, FILE *file)
{
    (void)fprintf(file, "OFF\n%d %d 0\n", w->nodes, w->faces);
    write_rows(w, file);
}

static inline void write_msh_text(const wreck *w, FILE *file)
{
    (void)fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", w->nodes);
    for (int32_t i = 0; i < w->nodes; ++i) {
        (void)fprintf(file, "%d %.17g %.17g %.17g\n", i + 1, w->x[i][0], w->x[i][1], w->x[i][2]);
    }
    (void)fprintf(file, "$EndNodes\n$Elements\n%d\n", w->faces + w->tetrahedra);
    for (int32_t f = 0; f < w->faces; ++f) {
        const int32_t *n = w->face[f];
        (void)fprintf(file, "%d %d 2 0 1 %d %d %d", f + 1, n[3] < 0 ? 2 : 3, n[0] + 1, n[1] + 1,
                      n[2] + 1);
        if (n[3] >= 0) {
            (void)fprintf(file, " %d", n[3] + 1);
        }
        (void)fputc('\n', file);
    }
    for (int32_t e = 0; e < w->tetrahedra; ++e) {
        const int32_t *n = w->tetrahedron[e];
        (void)fprintf(file, "%d 4 2 0 1 %d %d %d %d\n", w->faces + e + 1, n[0] + 1, n[1] + 1,
                      n[2] + 1, n[3] + 1);
    }
    (void)fputs("$EndElements\n", file);
}

static inline void write_vtk_text(const wreck *w, FILE *file)
{
    int32_t numbers = 0;
    (void)fprintf(file,
                  "# vtk DataFile Version 3.0\nwreck\nASCII\nDATASET POLYDATA\n"
                  "POINTS %d double\n",
                  w->nodes);
    for (int32_t i = 0; i < w->nodes; ++i) {
        (void)fprintf(file, "%.17g %.17g %.17g\n", w->x[i][0], w->x[i][1], w->x[i][2]);
    }
    for (int32_t f = 0; f < w->faces; ++f) {
        numbers += w->face[f][3] < 0 ? 4 : 5;
    }
    (void)fprintf(file, "POLYGONS %d %d\n", w->faces, numbers);
    write_faces(w, file);
}
