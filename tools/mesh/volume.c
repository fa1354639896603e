/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * All shapes are functions of one length h, the edge of their elements; the h that gives the
 * points asked for is found by iteration, h <- h (n(h) / n)^0.4, for n goes about as h^-2.5.
 *
 * Level sets: the lattice of edge h that has at most 2.5 times the nodes wanted, and of them at
 * most 0.65 times the nodes wanted on the surface. Inner nodes then go, deepest first, until the
 * number is right: the surface, where things are touched and seen, gets the resolution. A mesh
 * even throughout was rejected as the default: a liver of 5762 points has 28,000 tetrahedra then,
 * and surface triangles of 7.5 mm where 5.4 mm can be had.
 *
 * Boxes: cubes cut in five about a regular tetrahedron, in two kinds that alternate like a
 * chessboard; dihedral angles of 54.7, 70.5 and 90 degrees.
 */
#include "volume.h"

#include "command.h"
#include "prism.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "shape.h"
#include "stuffing.h"

#include <stdio.h>
#include <string.h>

enum { MAX_LEVEL_POINTS = 300000, ITERATIONS = 24, ROUNDS = 6 };

typedef struct maker {
    const volume_plan *plan;
    organ organ;         /* of level sets */
    rings rings;         /* of cylinder and shells */
    double s[RINGS_MAX]; /* share of the way along the meridian, a ring */
    int32_t cells[3];    /* of boxes */
    solid solid;
} maker;

static bool is_level_set(volume_kind kind)
{
    return kind == VOLUME_KIDNEY || kind == VOLUME_LIVER || kind == VOLUME_ELLIPSOID;
}

static bool is_box(volume_kind kind)
{
    return kind == VOLUME_BLOCK || kind == VOLUME_BEAM;
}

static double clamp(double value, double low, double high)
{
    return fmin(fmax(value, low), high);
}

/* ---- level sets ---- */

static double level_of(const void *body, const double x[3])
{
    return organ_value(body, x);
}

static void project(const void *body, double x[3])
{
    organ_project(body, x, 2);
}

static bool stuff_organ(maker *m, double h)
{
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = m->organ.centre[k] - 1.3 * m->organ.half[k];
        high[k] = m->organ.centre[k] + 1.3 * m->organ.half[k];
    }
    solid_fini(&m->solid);
    return stuff(level_of, &m->organ, low, high, h, &m->solid);
}

/* Points that a mesh from the lattice of edge h is good for. */
static double count_organ(maker *m, double h)
{
    if (!stuff_organ(m, h)) {
        return INFINITY;
    }
    const double all = m->solid.node_count;
    return fmax(all / 2.5, fmin(all, m->solid.surface_count / 0.65));
}

static bool make_organ(maker *m, double h)
{
    bool is_good = stuff_organ(m, h);
    const int32_t points = m->plan->points;
    int32_t before = INT32_MAX;
    /* Smoothing makes room for more to go. */
    for (int round = 0;
         round < ROUNDS && is_good && m->solid.node_count > points && m->solid.node_count < before;
         ++round) {
        before = m->solid.node_count;
        double *depth = ss_memory_get((size_t)before, sizeof *depth);
        is_good = depth != NULL;
        for (int32_t i = 0; i < before && is_good; ++i) {
            depth[i] = level_of(&m->organ, m->solid.position[i]);
        }
        is_good = is_good && solid_coarsen(&m->solid, depth, points, 4.0 * h) &&
                  solid_smooth(&m->solid, h, 8, project, &m->organ);
        ss_memory_free(depth);
    }
    return is_good && solid_smooth(&m->solid, h, 24, project, &m->organ);
}

/* ---- rings ---- */

/* Semi-axes of layer t of a shell, 0 inside to 1 outside. */
static void shell_axes(const volume_plan *plan, double t, double out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = 0.5 * ((1.0 - t) * plan->inner[k] + t * plan->size[k]);
    }
}

/* The shell's pole axis: z of a ventricle, whose apex is below; x of concentric ellipsoids. */
static int pole_axis(const volume_plan *plan)
{
    return plan->kind == VOLUME_VENTRICLE ? 2 : 0;
}

/* The polar angle at which layer t ends. */
static double last_angle(const volume_plan *plan, const double axes[3])
{
    return plan->kind == VOLUME_VENTRICLE ? acos(-plan->base / axes[2]) : SS_PI;
}

/* Equal ways along the meridian of the middle layer: m->s; returns the meridian's length. */
static double divide_meridian(maker *m, const double axes[3], double radius)
{
    enum { STEPS = 8192 };
    static double way[STEPS + 1];
    const double length = axes[pole_axis(m->plan)];
    const double end = last_angle(m->plan, axes);
    for (int i = 0; i < STEPS; ++i) {
        const double u = end * (i + 0.5) / STEPS;
        way[i + 1] = way[i] + hypot(radius * cos(u), length * sin(u)) * end / STEPS;
    }
    int at = 0;
    for (int32_t k = 0; k < m->rings.ring_count; ++k) {
        const double wanted = way[STEPS] * k / (m->rings.ring_count - 1);
        while (at < STEPS - 1 && way[at + 1] < wanted) {
            ++at;
        }
        m->s[k] = clamp((at + (wanted - way[at]) / (way[at + 1] - way[at])) / STEPS, 0.0, 1.0);
    }
    return way[STEPS];
}

static int32_t count_steps(double length, double step, int32_t least, int32_t most)
{
    return (int32_t)clamp(round(length / step), least, most);
}

static int32_t ring_size(double radius, double h)
{
    return count_steps(2.0 * SS_PI * radius, h, 5, 1000000);
}

static const double row = 0.86602540378443865; /* height of an equilateral triangle */

static void plan_cylinder(maker *m, double h)
{
    const double radius = 0.5 * m->plan->size[0];
    const int32_t n = count_steps(radius, row * h, 1, RINGS_MAX - 1);
    m->rings.ring_count = n + 1;
    m->rings.layer_count = 1 + count_steps(m->plan->size[2], h, 1, 1000000);
    m->rings.size[0] = 1;
    for (int32_t k = 1; k <= n; ++k) {
        m->s[k] = (double)k / n;
        m->rings.size[k] = ring_size(radius * m->s[k], h);
    }
}

static void plan_shell(maker *m, double h)
{
    double axes[3];
    shell_axes(m->plan, 0.5, axes);
    const int pole = pole_axis(m->plan);
    const double radius = 0.5 * (axes[(pole + 1) % 3] + axes[(pole + 2) % 3]);
    const double thickness = 0.5 * (m->plan->size[(pole + 1) % 3] - m->plan->inner[(pole + 1) % 3]);
    m->rings.ring_count = 2;
    const double length = divide_meridian(m, axes, radius);
    m->rings.ring_count = 1 + count_steps(length, row * h, 2, RINGS_MAX - 1);
    m->rings.layer_count = 1 + count_steps(thickness, h, 1, 1000000);
    (void)divide_meridian(m, axes, radius);
    const int32_t last = m->rings.ring_count - 1;
    m->rings.size[0] = 1;
    for (int32_t k = 1; k <= last; ++k) {
        m->rings.size[k] = ring_size(radius * sin(last_angle(m->plan, axes) * m->s[k]), h);
    }
    if (m->plan->kind == VOLUME_ELLIPSOIDS) {
        m->rings.size[last] = 1;
    }
}

static void place_cylinder(const void *body, int32_t ring, int32_t layer, double angle,
                           double out[3])
{
    const maker *m = body;
    const double radius = ring == 0 ? 0.0 : 0.5 * m->plan->size[0] * m->s[ring];
    ss_set3(out, radius * cos(angle), radius * sin(angle),
            m->plan->size[2] * ((double)layer / (m->rings.layer_count - 1) - 0.5));
}

static void place_shell(const void *body, int32_t ring, int32_t layer, double angle, double out[3])
{
    const maker *m = body;
    const int pole = pole_axis(m->plan);
    double axes[3];
    shell_axes(m->plan, (double)layer / (m->rings.layer_count - 1), axes);
    const double u = last_angle(m->plan, axes) * m->s[ring];
    const bool is_pole = m->rings.size[ring] == 1;
    const double across = is_pole ? 0.0 : sin(u);
    out[pole] = -axes[pole] * cos(u);
    out[(pole + 1) % 3] = axes[(pole + 1) % 3] * across * cos(angle);
    out[(pole + 2) % 3] = axes[(pole + 2) % 3] * across * sin(angle);
    if (m->plan->kind == VOLUME_VENTRICLE && ring == m->rings.ring_count - 1) {
        out[2] = m->plan->base;
    }
}

/* ---- boxes ---- */

/* A cube's corners by bits x, y, z; the last of the five is the regular one. Odd cubes are
 * mirrored. */
static const int8_t five[5][4] = {
    {0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};

static void place_in_box(const maker *m, int32_t i, int32_t j, int32_t k, double out[3])
{
    const int32_t at[3] = {i, j, k};
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = m->plan->size[axis] * ((double)at[axis] / m->cells[axis] - 0.5);
    }
}

static bool make_box(maker *m)
{
    const int32_t *n = m->cells;
    bool is_good = true;
    int32_t node = 0;
    for (int32_t i = 0; i <= n[0]; ++i) {
        for (int32_t j = 0; j <= n[1]; ++j) {
            for (int32_t k = 0; k <= n[2] && is_good; ++k) {
                double x[3];
                place_in_box(m, i, j, k, x);
                is_good = solid_add_node(&m->solid, x, &node);
            }
        }
    }
    const int32_t stride[3] = {(n[1] + 1) * (n[2] + 1), n[2] + 1, 1};
    for (int32_t c = 0; c < n[0] * n[1] * n[2] && is_good; ++c) {
        const int32_t i = c / (n[1] * n[2]);
        const int32_t j = c / n[2] % n[1];
        const int32_t k = c % n[2];
        const int mirror = (i + j + k) % 2;
        for (int t = 0; t < 5 && is_good; ++t) {
            int32_t corner[4];
            for (int v = 0; v < 4; ++v) {
                const int bits = five[t][v] ^ mirror;
                corner[v] = (i + (bits & 1)) * stride[0] + (j + (bits >> 1 & 1)) * stride[1] + k +
                            (bits >> 2);
            }
            is_good = solid_add_tetrahedron(&m->solid, corner[0], corner[1], corner[2], corner[3]);
        }
    }
    return is_good;
}

/* The surface of a box alone, with the nodes and triangles that the whole box's would have, in
 * their order: a box whose surface has a million nodes has seventy million within. */

/* Along the last axis, the next cube or node that is outside in a row of `count`; all of them are
 * where the row itself is. */
static int32_t next_outside(int32_t at, int32_t count, bool is_row_outside)
{
    return is_row_outside || at + 1 >= count ? at + 1 : count - 1;
}

static bool is_end(int32_t at, int32_t last)
{
    return at == 0 || at == last;
}

/* The number of node (i, j, k) of the surface: slabs of i, whole at both ends and rims between. */
static int32_t box_number(const int32_t n[3], int32_t i, int32_t j, int32_t k)
{
    const int32_t strip = n[2] + 1, slab = (n[1] + 1) * strip, rim = 2 * (strip + n[1] - 1);
    if (is_end(i, n[0])) {
        return (i > 0 ? slab + (n[0] - 1) * rim : 0) + j * strip + k;
    }
    const int32_t before = slab + (i - 1) * rim;
    return is_end(j, n[1]) ? before + (j > 0 ? strip + 2 * (n[1] - 1) : 0) + k
                           : before + strip + 2 * (j - 1) + (k > 0);
}

/* The cube from 0 to 1: its triangles are those of all cubes, by corners. */
static ss_mesh *make_cube(int mirror)
{
    solid cube = {.node_count = 0};
    ss_mesh *mesh = NULL;
    bool is_good = true;
    int32_t node = 0;
    for (int bits = 0; bits < 8 && is_good; ++bits) {
        const double x[3] = {bits & 1, bits >> 1 & 1, bits >> 2};
        is_good = solid_add_node(&cube, x, &node);
    }
    for (int t = 0; t < 5 && is_good; ++t) {
        is_good = solid_add_tetrahedron(&cube, five[t][0] ^ mirror, five[t][1] ^ mirror,
                                        five[t][2] ^ mirror, five[t][3] ^ mirror);
    }
    if (is_good) {
        ss_mesh_create(cube.node_count, (const double(*)[3])cube.position, 0, NULL,
                       cube.tetrahedron_count, (const int32_t(*)[4])cube.tetrahedron, &mesh, NULL);
    }
    solid_fini(&cube);
    return mesh;
}

/* Does the triangle of the cube at `at` lie on a side of the box? */
static bool is_on_side(const int32_t n[3], const int32_t at[3], const int32_t corner[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        const int bit = corner[0] >> axis & 1;
        if ((corner[1] >> axis & 1) == bit && (corner[2] >> axis & 1) == bit &&
            at[axis] == (bit != 0 ? n[axis] - 1 : 0)) {
            return true;
        }
    }
    return false;
}

/* Adds those of a cube; returns how many triangles there are then. */
static int32_t add_sides(const int32_t n[3], const int32_t at[3], const ss_mesh *cube,
                         int32_t count, int32_t (*triangle)[3])
{
    for (int32_t t = 0; t < cube->triangle_count; ++t) {
        const int32_t *corner = cube->triangle[t];
        if (is_on_side(n, at, corner)) {
            for (int v = 0; v < 3; ++v) {
                triangle[count][v] =
                    box_number(n, at[0] + (corner[v] & 1), at[1] + (corner[v] >> 1 & 1),
                               at[2] + (corner[v] >> 2));
            }
            ++count;
        }
    }
    return count;
}

static softsim_status create_box_surface(const maker *m, ss_mesh **out, softsim_error *error)
{
    const int32_t *n = m->cells;
    const int32_t nodes = box_number(n, n[0], n[1], n[2]) + 1;
    const int32_t triangles = 4 * (n[0] * n[1] + n[1] * n[2] + n[2] * n[0]);
    ss_mesh *cube[2] = {make_cube(0), make_cube(1)};
    double(*x)[3] = ss_memory_get((size_t)nodes, sizeof *x);
    int32_t(*triangle)[3] = ss_memory_get((size_t)triangles, sizeof *triangle);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (x != NULL && triangle != NULL && cube[0] != NULL && cube[1] != NULL) {
        int32_t count = 0, node = 0;
        for (int32_t i = 0; i <= n[0]; ++i) {
            for (int32_t j = 0; j <= n[1]; ++j) {
                const bool is_outside = is_end(i, n[0]) || is_end(j, n[1]);
                for (int32_t k = 0; k <= n[2]; k = next_outside(k, n[2] + 1, is_outside)) {
                    place_in_box(m, i, j, k, x[node++]);
                }
            }
        }
        for (int32_t i = 0; i < n[0]; ++i) {
            for (int32_t j = 0; j < n[1]; ++j) {
                const bool is_outside = is_end(i, n[0] - 1) || is_end(j, n[1] - 1);
                for (int32_t k = 0; k < n[2]; k = next_outside(k, n[2], is_outside)) {
                    const int32_t at[3] = {i, j, k};
                    count = add_sides(n, at, cube[(i + j + k) % 2], count, triangle);
                }
            }
        }
        status = ss_mesh_create(node, (const double(*)[3])x, count, (const int32_t(*)[3])triangle,
                                0, NULL, out, error);
    } else {
        softsim_error_add(error, status, "out of memory for %d points", m->plan->points);
    }
    ss_mesh_destroy(&cube[0]);
    ss_mesh_destroy(&cube[1]);
    ss_memory_free(x);
    ss_memory_free(triangle);
    return status;
}

/* ---- groups ---- */

typedef bool (*group_test)(const maker *m, const double x[3], int32_t node);

static bool add_group(const maker *m, ss_mesh *mesh, const char *name, group_test is_in)
{
    ss_mesh_group *groups = ss_memory_get((size_t)mesh->group_count + 1, sizeof *groups);
    int32_t *node = ss_memory_get((size_t)mesh->node_count, sizeof *node);
    if (groups == NULL || node == NULL) {
        ss_memory_free(groups);
        ss_memory_free(node);
        return false;
    }
    if (mesh->group_count > 0) {
        memcpy(groups, mesh->group, (size_t)mesh->group_count * sizeof *groups);
    }
    ss_memory_free(mesh->group);
    mesh->group = groups;
    ss_mesh_group *group = &groups[mesh->group_count++];
    (void)snprintf(group->name, sizeof group->name, "%s", name);
    group->node = node;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (is_in(m, mesh->position[i], i)) {
            node[group->node_count++] = i;
        }
    }
    return true;
}

static bool is_within(const double x[3], double cx, double cy, double cz, double radius)
{
    const double centre[3] = {cx, cy, cz};
    double d[3];
    ss_sub3(d, x, centre);
    return ss_norm3(d) <= radius;
}

static bool is_held(const maker *m, const double x[3], int32_t node)
{
    (void)node;
    return m->plan->kind == VOLUME_KIDNEY ? is_within(x, 0.0, -0.017, 0.0, 0.015)
                                          : is_within(x, -0.04, 0.06, 0.005, 0.03);
}

static int32_t ring_of_node(const maker *m, int32_t node)
{
    int32_t left = node % (int32_t)rings_node_count(&m->rings);
    int32_t ring = 0;
    while (left >= m->rings.size[ring]) {
        left -= m->rings.size[ring++];
    }
    return ring;
}

static bool is_in_first_layer(const maker *m, const double x[3], int32_t node)
{
    (void)x;
    return node < rings_node_count(&m->rings);
}

static bool is_in_last_layer(const maker *m, const double x[3], int32_t node)
{
    (void)x;
    return node >= rings_node_count(&m->rings) * (m->rings.layer_count - 1);
}

static bool is_in_last_ring(const maker *m, const double x[3], int32_t node)
{
    (void)x;
    return ring_of_node(m, node) == m->rings.ring_count - 1;
}

/* Sides of boxes lie exactly at half the size. */
#define SIDE(name, axis, sign)                                                                     \
    static bool name(const maker *m, const double x[3], int32_t node)                              \
    {                                                                                              \
        (void)node;                                                                                \
        return x[axis] == (sign)*0.5 * m->plan->size[axis];                                        \
    }
SIDE(is_left, 0, -1.0)
SIDE(is_right, 0, 1.0)
SIDE(is_front, 1, -1.0)
SIDE(is_back, 1, 1.0)
SIDE(is_bottom, 2, -1.0)
SIDE(is_top, 2, 1.0)

static const struct {
    volume_kind kind;
    const char *name;
    group_test is_in;
} group_rows[] = {
    {VOLUME_KIDNEY, "fixed", is_held},
    {VOLUME_LIVER, "fixed", is_held},
    {VOLUME_CYLINDER, "bottom", is_in_first_layer},
    {VOLUME_CYLINDER, "top", is_in_last_layer},
    {VOLUME_CYLINDER, "side", is_in_last_ring},
    {VOLUME_VENTRICLE, "endo", is_in_first_layer},
    {VOLUME_VENTRICLE, "epi", is_in_last_layer},
    {VOLUME_VENTRICLE, "base", is_in_last_ring},
    {VOLUME_ELLIPSOIDS, "inner", is_in_first_layer},
    {VOLUME_ELLIPSOIDS, "outer", is_in_last_layer},
    {VOLUME_BLOCK, "left", is_left},
    {VOLUME_BLOCK, "right", is_right},
    {VOLUME_BLOCK, "front", is_front},
    {VOLUME_BLOCK, "back", is_back},
    {VOLUME_BLOCK, "bottom", is_bottom},
    {VOLUME_BLOCK, "top", is_top},
    {VOLUME_BEAM, "fixed", is_left},
    {VOLUME_BEAM, "free", is_right},
};
enum { GROUP_ROWS = sizeof group_rows / sizeof group_rows[0] };

static bool add_groups(const maker *m, ss_mesh *mesh)
{
    bool is_good = true;
    for (int i = 0; i < GROUP_ROWS && is_good; ++i) {
        is_good = group_rows[i].kind != m->plan->kind ||
                  add_group(m, mesh, group_rows[i].name, group_rows[i].is_in);
    }
    return is_good;
}

void volume_name_groups(volume_kind kind, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (int i = 0; i < GROUP_ROWS; ++i) {
        if (group_rows[i].kind == kind && used < size) {
            used += (size_t)snprintf(out + used, size - used, "%s%s", used > 0 ? ", " : "",
                                     group_rows[i].name);
        }
    }
}

bool volume_add_groups(const volume_plan *plan, ss_mesh *mesh)
{
    const maker m = {.plan = plan};
    return add_groups(&m, mesh);
}

/* ---- all shapes ---- */

/* Sets everything that hangs on h; returns how many nodes there will be. */
static double plan_nodes(maker *m, double h)
{
    if (is_level_set(m->plan->kind)) {
        return count_organ(m, h);
    }
    if (is_box(m->plan->kind)) {
        double all = 1.0;
        double inner = 1.0;
        for (int k = 0; k < 3; ++k) {
            m->cells[k] = count_steps(m->plan->size[k], h, 1, 1000000);
            all *= m->cells[k] + 1.0;
            inner *= m->cells[k] - 1.0;
        }
        return m->plan->is_surface ? all - inner : all;
    }
    if (m->plan->kind == VOLUME_CYLINDER) {
        plan_cylinder(m, h);
    } else {
        plan_shell(m, h);
    }
    const double layer = (double)rings_node_count(&m->rings);
    const int32_t rim = m->rings.size[m->rings.ring_count - 1];
    return m->plan->is_surface ? 2.0 * layer + (rim > 1 ? (m->rings.layer_count - 2.0) * rim : 0.0)
                               : layer * m->rings.layer_count;
}

static double find_edge(maker *m)
{
    const double wanted = m->plan->points;
    const double *size = m->plan->size;
    double h = is_level_set(m->plan->kind)
                   ? m->organ.half[0] / cbrt(wanted)
                   : cbrt(size[0]) * cbrt(size[1]) * cbrt(size[2]) / cbrt(wanted);
    double best = h;
    double least = INFINITY;
    for (int i = 0; i < ITERATIONS && least > 0.004; ++i) {
        const double ratio = plan_nodes(m, h) / wanted;
        if (fabs(log(ratio)) < least) {
            least = fabs(log(ratio));
            best = h;
        }
        /* The step of h shrinks with each iteration: node counts are discontinuous in h, and a
         * fixed step could oscillate. */
        h *= pow(clamp(ratio, 0.1, 10.0), 0.4 / (1.0 + 0.1 * i));
    }
    return best;
}

static bool make(maker *m)
{
    const double h = find_edge(m);
    if (is_level_set(m->plan->kind)) {
        return make_organ(m, h);
    }
    (void)plan_nodes(m, h);
    if (is_box(m->plan->kind)) {
        return make_box(m);
    }
    return rings_fill(&m->rings, m->plan->kind == VOLUME_CYLINDER ? place_cylinder : place_shell, m,
                      &m->solid);
}

softsim_status volume_create(const volume_plan *plan, ss_mesh **out, softsim_error *error)
{
    static const organ_kind organs[] = {[VOLUME_KIDNEY] = ORGAN_KIDNEY,
                                        [VOLUME_LIVER] = ORGAN_LIVER,
                                        [VOLUME_ELLIPSOID] = ORGAN_ELLIPSOID};
    *out = NULL;
    if (is_level_set(plan->kind) && plan->points > MAX_LEVEL_POINTS) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--points: at most %d for the tetrahedra of a kidney, liver or ellipsoid",
                          MAX_LEVEL_POINTS);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    maker *m = ss_memory_get(1, sizeof *m);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (m != NULL) {
        m->plan = plan;
        if (is_level_set(plan->kind)) {
            const double half[3] = {0.5 * plan->size[0], 0.5 * plan->size[1], 0.5 * plan->size[2]};
            organ_init(&m->organ, organs[plan->kind], half);
        }
        if (is_box(plan->kind) && plan->is_surface) {
            (void)plan_nodes(m, find_edge(m));
            status = create_box_surface(m, out, error);
        } else if (make(m)) {
            status = ss_mesh_create(m->solid.node_count, (const double(*)[3])m->solid.position, 0,
                                    NULL, m->solid.tetrahedron_count,
                                    (const int32_t(*)[4])m->solid.tetrahedron, out, error);
        } else {
            softsim_error_add(error, status, "out of memory for %d points", plan->points);
        }
        if (status == SOFTSIM_OK && !add_groups(m, *out)) {
            ss_mesh_destroy(out);
            status = SOFTSIM_ERROR_MEMORY;
            softsim_error_add(error, status, "out of memory for %d points", plan->points);
        }
        solid_fini(&m->solid);
    }
    ss_memory_free(m);
    return status;
}

/* ---- the surface alone ---- */

ss_mesh *volume_take_surface(const ss_mesh *volume)
{
    int32_t *number = ss_memory_get((size_t)volume->node_count, sizeof *number); /* from 1 */
    double(*x)[3] = ss_memory_get((size_t)volume->node_count, sizeof *x);
    int32_t(*triangle)[3] = ss_memory_get((size_t)volume->triangle_count, sizeof *triangle);
    ss_mesh *surface = NULL;
    if (number != NULL && x != NULL && triangle != NULL) {
        for (int32_t i = 0; i < 3 * volume->triangle_count; ++i) {
            number[volume->triangle[i / 3][i % 3]] = 1;
        }
        int32_t count = 0;
        for (int32_t i = 0; i < volume->node_count; ++i) {
            if (number[i] != 0) {
                ss_copy3(x[count], volume->position[i]);
                number[i] = ++count;
            }
        }
        for (int32_t i = 0; i < 3 * volume->triangle_count; ++i) {
            triangle[i / 3][i % 3] = number[volume->triangle[i / 3][i % 3]] - 1;
        }
        if (ss_mesh_create(count, (const double(*)[3])x, volume->triangle_count,
                           (const int32_t(*)[3])triangle, 0, NULL, &surface, NULL) == SOFTSIM_OK &&
            !carry_groups(volume, number, surface)) {
            ss_mesh_destroy(&surface);
        }
    }
    SS_EACH(ss_memory_free, number, x, triangle);
    return surface;
}
