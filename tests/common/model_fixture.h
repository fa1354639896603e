/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes of triangles, and bodies of cnn-energy: shared by the tests of models/. cmocka comes
 * first. */
#include "models/cnn/cnn.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "setup_fixture.h"

/* ---- meshes ---- */

/* A mesh under construction; grows without limit checks, tests only. */
typedef struct draft {
    double (*position)[3];
    int32_t (*triangle)[3];
    int32_t nodes, triangles;
} draft;

static inline void draft_init(draft *d, int32_t nodes, int32_t triangles)
{
    *d = (draft){.position = calloc((size_t)nodes, sizeof *d->position),
                 .triangle = calloc((size_t)triangles, sizeof *d->triangle)};
}

static inline int32_t draft_node(draft *d, double x, double y, double z)
{
    ss_set3(d->position[d->nodes], x, y, z);
    return d->nodes++;
}

static inline void draft_triangle(draft *d, int32_t a, int32_t b, int32_t c)
{
    int32_t *t = d->triangle[d->triangles++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

/* The halves of quad a b c d, cut from a to c or from b to d. */
static inline void draft_quad(draft *mesh, int32_t a, int32_t b, int32_t c, int32_t d,
                              bool is_cut_at_a)
{
    if (is_cut_at_a) {
        draft_triangle(mesh, a, b, c);
        draft_triangle(mesh, a, c, d);
    } else {
        draft_triangle(mesh, a, b, d);
        draft_triangle(mesh, b, c, d);
    }
}

static inline ss_mesh *draft_finish(draft *d)
{
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(d->nodes, (const double(*)[3])d->position, d->triangles,
                         (const int32_t(*)[3])d->triangle, 0, NULL, &mesh, NULL);
    free(d->position);
    free(d->triangle);
    return mesh;
}

/* Centre (node 0) and six nodes around it at distance h, in the plane z = 0. */
static inline ss_mesh *make_fan(double h)
{
    draft d;
    draft_init(&d, 7, 6);
    draft_node(&d, 0.0, 0.0, 0.0);
    for (int k = 0; k < 6; ++k) {
        draft_node(&d, h * cos(k * SS_PI / 3.0), h * sin(k * SS_PI / 3.0), 0.0);
    }
    for (int k = 0; k < 6; ++k) {
        draft_triangle(&d, 0, 1 + k, 1 + (k + 1) % 6);
    }
    return draft_finish(&d);
}

/* Open cylinder about z: `rows` rings of `columns` nodes, alternating diagonals; node of ring i,
 * column j is i * columns + j; column 0 lies at +y. */
static inline ss_mesh *make_cylinder(int rows, int columns, double radius, double length)
{
    draft d;
    draft_init(&d, rows * columns, 2 * rows * columns);
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            const double angle = 2.0 * SS_PI * j / columns;
            draft_node(&d, radius * sin(angle), radius * cos(angle),
                       length * ((double)i / (rows - 1) - 0.5));
        }
    }
    for (int i = 0; i + 1 < rows; ++i) {
        for (int j = 0; j < columns; ++j) {
            const int32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
            const int32_t c = a + columns, e = b + columns;
            draft_quad(&d, a, b, e, c, (i + j) % 2 == 0);
        }
    }
    return draft_finish(&d);
}

/* Square plate in z = 0 of side `size`, `cells` x `cells`, centred, alternating diagonals, normal
 * up. Rows of equilateral triangles would be finer; this one has the rim that tests need. */
static inline ss_mesh *make_plate(int cells, double size)
{
    draft d;
    const int side = cells + 1;
    draft_init(&d, side * side, 2 * cells * cells);
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            draft_node(&d, size * ((double)j / cells - 0.5), size * ((double)i / cells - 0.5), 0.0);
        }
    }
    for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
            const int32_t a = i * side + j, b = a + 1, c = a + side, e = c + 1;
            draft_quad(&d, a, b, e, c, (i + j) % 2 == 0);
        }
    }
    return draft_finish(&d);
}

/* The node on the edge from corner a to b of a geodesic sphere, k of f parts along. */
static inline int32_t geodesic_node(draft *d, const double *a, const double *b, const double *c,
                                    int i, int j, int f)
{
    double x[3];
    for (int k = 0; k < 3; ++k) {
        x[k] = (a[k] * (f - i - j) + b[k] * i + c[k] * j) / f;
    }
    ss_normalize3(x);
    for (int32_t n = 0; n < d->nodes; ++n) {
        double e[3];
        ss_sub3(e, d->position[n], x);
        if (ss_norm3(e) < 1e-6) {
            return n;
        }
    }
    return draft_node(d, x[0], x[1], x[2]);
}

/* Geodesic sphere of 10 f^2 + 2 nodes, scaled to semi-axes. */
static inline ss_mesh *make_ellipsoid(int f, double ax, double ay, double az)
{
    static const int face[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const double t = 0.5 * (1.0 + sqrt(5.0));
    const double corner[12][3] = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0},
                                  {0, -1, t}, {0, 1, t}, {0, -1, -t}, {0, 1, -t},
                                  {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
    draft d;
    draft_init(&d, 10 * f * f + 2, 20 * f * f);
    for (int m = 0; m < 20; ++m) {
        const double *a = corner[face[m][0]], *b = corner[face[m][1]], *c = corner[face[m][2]];
        for (int i = 0; i < f; ++i) {
            for (int j = 0; i + j < f; ++j) {
                const int32_t p = geodesic_node(&d, a, b, c, i, j, f);
                const int32_t q = geodesic_node(&d, a, b, c, i + 1, j, f);
                const int32_t r = geodesic_node(&d, a, b, c, i, j + 1, f);
                draft_triangle(&d, p, q, r);
                if (i + j + 1 < f) {
                    draft_triangle(&d, q, geodesic_node(&d, a, b, c, i + 1, j + 1, f), r);
                }
            }
        }
    }
    for (int32_t n = 0; n < d.nodes; ++n) {
        d.position[n][0] *= ax;
        d.position[n][1] *= ay;
        d.position[n][2] *= az;
    }
    return draft_finish(&d);
}

/* Copies of a body side by side along x, `apart` metres from one another. Takes `one`. */
static inline ss_mesh *make_bodies(ss_mesh *one, int copies, double apart)
{
    draft d;
    draft_init(&d, copies * one->node_count, copies * one->triangle_count);
    for (int c = 0; c < copies; ++c) {
        const int32_t first = d.nodes;
        for (int32_t i = 0; i < one->node_count; ++i) {
            const double *x = one->position[i];
            draft_node(&d, x[0] + c * apart, x[1], x[2]);
        }
        for (int32_t t = 0; t < one->triangle_count; ++t) {
            const int32_t *n = one->triangle[t];
            draft_triangle(&d, first + n[0], first + n[1], first + n[2]);
        }
    }
    ss_mesh_destroy(&one);
    return draft_finish(&d);
}

/* ---- a model ---- */

static inline void give_field(setup *s, const char *name, double *per_node)
{
    s->param[row_of(s, name)] = (ss_param_value){.per_node = per_node, .is_given = true};
}

/* A constant force on one node from t = 0 on. */
static inline void push(setup *s, int32_t *node, double fx, double fy, double fz)
{
    s->load[s->plan.load_count++] =
        (ss_load){.node = node, .node_count = 1, .force = {fx, fy, fz}, .to = (double)INFINITY};
}

/* Mass, damping and rest stiffness of a node as given. */
static inline void per_node(setup *s, double mass, double damping, double rest_stiffness)
{
    give(s, "per_area", 0.0);
    give(s, "mass_kg", mass);
    give(s, "damping_n_s_per_m", damping);
    give(s, "rest_stiffness_n_per_m", rest_stiffness);
}

/* Soft skin of a centimetre: it resists strain, rests on what is below, and is damped. */
static inline void give_skin(setup *s)
{
    give(s, "modulus_j", 5.0);
    give(s, "area_density_kg_m2", 11.5);
    give(s, "damping_n_s_per_m3", 11.5 * 150.0);
    give(s, "rest_stiffness_n_per_m3", 5e4);
}

/* Holds the border of a plate of `cells` x `cells`. */
static inline void hold_rim(setup *s, int cells)
{
    for (int i = 0; i <= cells; ++i) {
        for (int j = 0; j <= cells; ++j) {
            const bool is_rim = i == 0 || j == 0 || i == cells || j == cells;
            s->fixed[i * (cells + 1) + j] = is_rim ? 7 : 0;
        }
    }
}

/* The state a test wants to start from. */
static inline void place(setup *s, int32_t node, double x, double y, double z)
{
    ss_real *u = s->model->u + 4 * (ptrdiff_t)node;
    u[0] = (ss_real)x;
    u[1] = (ss_real)y;
    u[2] = (ss_real)z;
    s->model->is_ready = false;
}

/* Random displacements of all free axes, up to `size`. */
static inline void crumple(setup *s, double size)
{
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        if ((s->fixed[i] & 7) != 7) {
            place(s, i, size * random_unit(), size * random_unit(), size * random_unit());
        }
    }
}

/* ---- bodies that several tests use ---- */

#define FAN_EDGE 0.3

static inline void setup_fan(setup *s, double modulus, double mass, double damping,
                             double stiffness)
{
    setup_init(s, "cnn-energy", make_fan(FAN_EDGE));
    for (int k = 1; k < 7; ++k) {
        s->fixed[k] = 7;
    }
    give(s, "modulus_n_per_m", modulus);
    give(s, "rho", 0.05);
    per_node(s, mass, damping, stiffness);
}

/* Bent ellipsoid-like body: held at its lower end, pushed at the top. */
static inline void setup_body(setup *s, int frequency)
{
    setup_init(s, "cnn-energy", make_ellipsoid(frequency, 1.0, 0.9, 0.8));
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        if (s->mesh->position[i][2] < -0.62) {
            s->fixed[i] = 7;
        }
    }
    give(s, "modulus_n_per_m", 60.0);
    per_node(s, 1.0, 2.0, 0.1);
    give(s, "rho", 0.05);
}

static inline int32_t top_node(const ss_mesh *mesh)
{
    int32_t best = 0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        best = mesh->position[i][2] > mesh->position[best][2] ? i : best;
    }
    return best;
}

enum { TOP = 7 * 24, LEFT = TOP + 6, RIGHT = TOP + 18 };

static inline void setup_cylinder(setup *s, double damping)
{
    setup_init(s, "cnn-energy", make_cylinder(15, 24, 1.0, 4.0));
    for (int j = 0; j < 24; ++j) {
        s->fixed[j] = s->fixed[14 * 24 + j] = 7;
    }
    give(s, "modulus_n_per_m", 60.0);
    give(s, "rho", 0.05);
    per_node(s, 1.0, damping, 0.1);
}

/* The potential at the present displacements, and the force on one axis of a node. */
static inline double potential(setup *s, int32_t node, int axis, double *out_force)
{
    s->model->is_ready = false;
    s->class->step(s->model, s->time, 1e-30, NULL);
    const ss_model *m = s->model;
    const ptrdiff_t at = 4 * (ptrdiff_t)node + axis;
    const ss_cnn_source *first = m->first;
    *out_force = (double)m->force[at] - (double)m->rest_stiffness[node] * (double)m->d[at] -
                 first->c1 * (double)first->r[at] +
                 first->c2 * (double)(m->is_held ? first->b : first->b_turned)[at];
    *out_force -= (double)m->load_force[at];
    if (m->enclosed_count == 1) {
        *out_force -= m->enclosed[0].pressure * (double)m->normal[at];
    }
    return info_of(s).elastic;
}
