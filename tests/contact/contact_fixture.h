/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What test_contact.c and test_contact_surface.c share: small meshes, one tool on one surface. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "contact/internal.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

#define assert_near(a, b, eps)                                                                     \
    do {                                                                                           \
        const double a_ = (a);                                                                     \
        const double b_ = (b);                                                                     \
        if (!(fabs(a_ - b_) <= (eps))) {                                                           \
            fail_msg("%s = %.17g, not %.17g (within %g)", #a, a_, b_, (double)(eps));              \
        }                                                                                          \
    } while (0)

enum { IS_DOUBLE = sizeof(ss_real) == 8, MAX_NODES = 2000, MAX_TRIANGLES = 4000 };

/* ---- meshes ---- */

static double positions[MAX_NODES][3];
static int32_t triangles[MAX_TRIANGLES][3];
static ss_mesh mesh;

static uint64_t seed_state;

static inline double random_unit(void)
{
    return ss_random_unit(&seed_state);
}

static inline void begin_mesh(void)
{
    mesh = (ss_mesh){.position = positions, .triangle = triangles};
}

static inline int32_t add_node(double x, double y, double z)
{
    ss_set3(positions[mesh.node_count], x, y, z);
    return mesh.node_count++;
}

static inline void add_triangle(int32_t a, int32_t b, int32_t c)
{
    const int32_t corner[3] = {a, b, c};
    memcpy(triangles[mesh.triangle_count++], corner, sizeof corner);
}

/* Equilateral triangles of edge h in z = 0, rows x columns nodes, about the origin. */
static inline void make_plane(int rows, int columns, double h)
{
    begin_mesh();
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            add_node(h * (i + 0.5 * (j % 2) - 0.5 * columns),
                     h * 0.5 * sqrt(3.0) * (j - 0.5 * rows), 0.0);
        }
    }
    for (int32_t j = 0; j + 1 < rows; ++j) {
        for (int32_t i = 0; i + 1 < columns; ++i) {
            const int32_t a = j * columns + i;
            const int32_t b = a + columns;
            if (j % 2 == 0) {
                add_triangle(a, a + 1, b);
                add_triangle(a + 1, b + 1, b);
            } else {
                add_triangle(a, b + 1, b);
                add_triangle(a, a + 1, b + 1);
            }
        }
    }
}

static inline int32_t middle_node(int32_t a, int32_t b, double radius)
{
    double m[3];
    ss_add3(m, positions[a], positions[b]);
    ss_normalize3(m);
    ss_scale3(m, m, radius);
    for (int32_t i = 0; i < mesh.node_count; ++i) {
        double r[3];
        ss_sub3(r, positions[i], m);
        if (ss_norm3(r) < 1e-9 * radius) {
            return i;
        }
    }
    return add_node(m[0], m[1], m[2]);
}

/* An octahedron split `levels` times, on a sphere: valences 4 and 6. */
static inline void make_sphere(int levels, double radius)
{
    static const int32_t face[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                       {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    begin_mesh();
    for (int k = 0; k < 6; ++k) {
        const double s = (k % 2 == 0 ? 1.0 : -1.0) * radius;
        add_node(k / 2 == 0 ? s : 0.0, k / 2 == 1 ? s : 0.0, k / 2 == 2 ? s : 0.0);
    }
    for (int f = 0; f < 8; ++f) {
        add_triangle(face[f][0], face[f][1], face[f][2]);
    }
    for (int level = 0; level < levels; ++level) {
        const int32_t count = mesh.triangle_count;
        for (int32_t t = 0; t < count; ++t) {
            int32_t v[3], m[3];
            memcpy(v, triangles[t], sizeof v);
            for (int k = 0; k < 3; ++k) {
                m[k] = middle_node(v[k], v[(k + 1) % 3], radius);
            }
            for (int k = 0; k < 3; ++k) {
                add_triangle(v[k], m[k], m[(k + 2) % 3]);
            }
            memcpy(triangles[t], m, sizeof m);
        }
    }
    mesh.is_closed = true;
}

/* ---- one tool on one surface ---- */

static ss_surface *surface;
static ss_contact_query *query;
static ss_real *u;     /* displacement */
static ss_real *force; /* on nodes */
static double tool_force[3], tool_torque[3];

static inline void open_query(const ss_shape *shape, int parts, double delta, double stiffness)
{
    softsim_error error = {0};
    const ss_contact_query_options options = {delta, stiffness};
    assert_int_equal(ss_surface_create(&mesh, 0.0, parts, &surface, &error), SOFTSIM_OK);
    assert_int_equal(ss_contact_query_create(surface, shape, &options, &query), SOFTSIM_OK);
    u = ss_memory_get((size_t)mesh.node_count, 4 * sizeof(ss_real));
    force = ss_memory_get((size_t)mesh.node_count, 4 * sizeof(ss_real));
}

static inline void close_query(void)
{
    const int64_t before = ss_memory_in_use();
    ss_contact_query_destroy(&query);
    ss_surface_destroy(&surface);
    ss_memory_free(u);
    ss_memory_free(force);
    assert_null(query);
    assert_null(surface);
    assert_true(ss_memory_in_use() < before);
}

static inline ss_tool_pose pose_at(double x, double y, double z)
{
    return (ss_tool_pose){{x, y, z}, {1.0, 0.0, 0.0, 0.0}};
}

static inline ss_tool_pose random_pose(double x, double y, double z)
{
    ss_tool_pose pose = pose_at(x, y, z);
    double length = 0.0;
    for (int k = 0; k < 4; ++k) {
        pose.orientation[k] = random_unit() - 0.5;
        length += pose.orientation[k] * pose.orientation[k];
    }
    for (int k = 0; k < 4; ++k) {
        pose.orientation[k] /= sqrt(length);
    }
    return pose;
}

static inline void shake_nodes(double size)
{
    for (int32_t i = 0; i < 4 * mesh.node_count; ++i) {
        u[i] = i % 4 == 3 ? 0 : (ss_real)(size * (random_unit() - 0.5));
    }
}

static inline int32_t broad_phase(const ss_tool_pose *from, const ss_tool_pose *to)
{
    ss_surface_refit(surface, u);
    return ss_contact_query_broad_phase(query, u, from, to);
}

static inline void clear_forces(void)
{
    memset(force, 0, 4 * sizeof(ss_real) * (size_t)mesh.node_count);
    memset(tool_force, 0, sizeof tool_force);
    memset(tool_torque, 0, sizeof tool_torque);
}

static inline double penalty(const ss_tool_pose *pose)
{
    clear_forces();
    return ss_contact_query_penalty(query, u, pose, force, tool_force, tool_torque);
}

static const ss_shape sphere_5mm = {.kind = SS_SHAPE_SPHERE, .radius = 0.005};

/* Every kind but convex, some 5 to 8 mm large. */
static const ss_shape shapes[] = {
    {.kind = SS_SHAPE_SPHERE, .radius = 0.006},
    {.kind = SS_SHAPE_CAPSULE, .radius = 0.005, .half_length = 0.006},
    {.kind = SS_SHAPE_BOX, .half_extent = {0.005, 0.006, 0.008}},
    {.kind = SS_SHAPE_CYLINDER, .radius = 0.005, .half_length = 0.007},
    {.kind = SS_SHAPE_CONE, .radius = 0.006, .half_length = 0.008},
};
enum { SHAPE_COUNT = sizeof shapes / sizeof shapes[0] };
