/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A face of many corners as triangles, by clipping ears in the plane across its area vector
 * (Newell): the first corner that turns the right way and has no other corner in its triangle goes.
 * Only corners that turn the other way can lie in an ear, so that of a convex face none is tried.
 * Where none is an ear, since the face crosses itself or is flat, or when 8 n^2 corners have been
 * gone over, the next one goes anyway: the count is always n - 2, and the checks of the mesh tell
 * what came out. A fan from one corner was rejected: it folds faces that are not convex.
 */
#include "mesh/polygon.h"

#include "rt/vec.h"

#include <math.h>

typedef struct flat_point {
    double x, y;
} flat_point;

static double turn(const flat_point *a, const flat_point *b, const flat_point *c)
{
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

/* Into the plane across the area vector; corners then run counter-clockwise. */
static void flatten(const double (*position)[3], const int32_t *node, int count, flat_point *out)
{
    double area[3] = {0.0, 0.0, 0.0};
    double axis[3] = {0.0, 0.0, 0.0};
    double first[3], second[3];
    for (int k = 1; k + 1 < count; ++k) {
        double normal[3];
        ss_normal3(normal, position[node[0]], position[node[k]], position[node[k + 1]]);
        ss_add3(area, area, normal);
    }
    ss_normalize3(area);
    int least = 0;
    for (int k = 1; k < 3; ++k) {
        least = fabs(area[k]) < fabs(area[least]) ? k : least;
    }
    axis[least] = 1.0;
    ss_cross3(first, area, axis);
    ss_normalize3(first);
    ss_cross3(second, area, first);
    for (int k = 0; k < count; ++k) {
        double way[3];
        ss_sub3(way, position[node[k]], position[node[0]]);
        out[k] = (flat_point){ss_dot3(way, first), ss_dot3(way, second)};
    }
}

static bool is_ear(const flat_point *at, const bool *is_reflex, const int *left, int count, int k,
                   int64_t *inout_looks)
{
    const flat_point *a = &at[left[(k + count - 1) % count]];
    const flat_point *b = &at[left[k]];
    const flat_point *c = &at[left[(k + 1) % count]];
    if (!(turn(a, b, c) > 0.0)) {
        return false;
    }
    for (int i = 2; i + 1 < count; ++i) {
        const flat_point *p = &at[left[(k + i) % count]];
        --*inout_looks;
        if (!is_reflex[left[(k + i) % count]]) {
            continue;
        }
        if (turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0) {
            return false;
        }
    }
    return true;
}

void ss_mesh_cut_polygon(const double (*position)[3], const int32_t *node, int count,
                         int32_t (*out)[3])
{
    flat_point at[SS_POLYGON_CORNERS];
    int left[SS_POLYGON_CORNERS];
    flatten(position, node, count, at);
    bool is_reflex[SS_POLYGON_CORNERS];
    for (int k = 0; k < count; ++k) {
        left[k] = k;
        is_reflex[k] = !(turn(&at[(k + count - 1) % count], &at[k], &at[(k + 1) % count]) > 0.0);
    }
    int64_t looks = 8 * (int64_t)count * count;
    int k = 1;
    for (int size = count; size > 2; --size) {
        int tried = 0;
        while (tried < size && size > 3 && looks > 0 &&
               !is_ear(at, is_reflex, left, size, k % size, &looks)) {
            ++k;
            ++tried;
        }
        k %= size;
        int32_t *triangle = *out++;
        triangle[0] = node[left[(k + size - 1) % size]];
        triangle[1] = node[left[k]];
        triangle[2] = node[left[(k + 1) % size]];
        for (int i = k; i + 1 < size; ++i) {
            left[i] = left[i + 1];
        }
        k = k < size - 1 ? k + 1 : 1; /* not the same corner again: no fans */
    }
}
