/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Where a hand that comes from one side meets a body.
 *
 * The tool comes down along -a (a: unit, towards the hand) on a line through a node p of the
 * surface. Its end is a figure turned about that line: at the distance r from it, up to the
 * radius R, its lowest point is `below` + sqrt(R^2 - r^2) (a round end) or `below` (a flat one)
 * below the origin. So it touches where its origin is at the height
 *
 *   h = max over the surface within R of the line of (x . a + flat [+ sqrt(R^2 - r^2)]),
 *
 * found on samples of the triangles at most R/8 apart (a sphere is then at most R/500 too low).
 *
 * Of the nodes the least of
 *
 *   |way from the middle, across a| / (the largest) + (1 - n . a) + max(0, 1 - d / 4R)
 *     + 8 max(0, cos 15 degrees - n . a)
 *
 * is taken, d being the distance to the nearest fixed node: central, level, and away from what is
 * held; on a slope or an edge, whose normal is between its sides', a tool slides off. Left out are
 * nodes that are held, steep ones (n . a < 1/2), and those that the tool does not come near, since
 * something else is in its way. Every k-th node is looked at where there are many. Rejected: the
 * highest point of the body, which is a rim as often as not.
 */
#include "contact/touch.h"

#include <math.h>
#include <stdlib.h>

#include "contact/shape.h"
#include "rt/vec.h"

enum { MAX_PLACES = 192, MAX_SAMPLES = 48 /* along a side */ };
static const double LEVEL = 0.5;    /* n . a of a place, at least */
static const double GENTLE = 0.966; /* n . a of 15 degrees: what is steeper costs */
static const double STEEP_COST = 8.0;
static const double CLEAR_RADII = 4.0;  /* from what is fixed */
static const double FINE_RADII = 0.125; /* between samples */
static const double OFF_RADII = 0.5;    /* above the place where the tool is held up elsewhere */

const ss_touch_side ss_touch_sides[SS_TOUCH_SIDES] = {
    {"+z", {0, 0, 1}, "x,y,z"},   {"-z", {0, 0, -1}, "x,-y,-z"}, {"+x", {1, 0, 0}, "z,x,y"},
    {"-x", {-1, 0, 0}, "-z,y,x"}, {"+y", {0, 1, 0}, "y,z,x"},    {"-y", {0, -1, 0}, "x,-z,y"}};

ss_touch_end ss_touch_end_of(const ss_shape *shape)
{
    const double *e = shape->half_extent;
    double low, high;
    switch (shape->kind) {
    case SS_SHAPE_SPHERE:
        return (ss_touch_end){shape->radius, 0.0, true};
    case SS_SHAPE_CAPSULE:
        return (ss_touch_end){shape->radius, shape->half_length, true};
    case SS_SHAPE_CYLINDER:
    case SS_SHAPE_CONE:
        return (ss_touch_end){shape->radius, shape->half_length, false};
    case SS_SHAPE_BOX:
        return (ss_touch_end){hypot(e[0], e[1]), e[2], false};
    case SS_SHAPE_CONVEX:
        break;
    }
    ss_shape_span(shape, &low, &high);
    return (ss_touch_end){ss_shape_bounding_radius(shape), -low, false};
}

/* How far x is from the line through p along a. */
static double across(const double x[3], const double p[3], const double a[3])
{
    double way[3];
    ss_sub3(way, x, p);
    ss_madd3(way, way, -ss_dot3(way, a), a);
    return ss_norm3(way);
}

/* How far below its origin the tool's end is, `r` from its axis. */
static double end_below(const ss_touch_end *end, double r)
{
    return end->below + (end->is_round ? sqrt(fmax(0.0, end->radius * end->radius - r * r)) : 0.0);
}

/* The height of the origin over which triangle t would hold the tool up; -INFINITY: it is not in
 * the way. */
static double height_over(const ss_touch_body *body, int32_t t, const double p[3],
                          const double a[3], const ss_touch_end *end)
{
    const double *x[3];
    double longest = 0.0, middle[3] = {0.0, 0.0, 0.0}, height = -INFINITY, side[3];
    for (int k = 0; k < 3; ++k) {
        x[k] = body->position[body->triangle[t][k]];
        ss_madd3(middle, middle, 1.0 / 3.0, x[k]);
    }
    for (int k = 0; k < 3; ++k) {
        ss_sub3(side, x[(k + 1) % 3], x[k]);
        longest = fmax(longest, ss_norm3(side));
    }
    if (!(across(middle, p, a) <= end->radius + longest)) {
        return height;
    }
    const int n = 1 + (int)fmin(MAX_SAMPLES, longest / (FINE_RADII * end->radius));
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n - i; ++j) {
            double at[3];
            ss_scale3(at, x[0], (double)i / n);
            ss_madd3(at, at, (double)j / n, x[1]);
            ss_madd3(at, at, (double)(n - i - j) / n, x[2]);
            const double r = across(at, p, a);
            if (r <= end->radius) {
                height = fmax(height, ss_dot3(at, a) + end_below(end, r));
            }
        }
    }
    return height;
}

static double touch_height(const ss_touch_body *body, const double p[3], const double a[3],
                           const ss_touch_end *end)
{
    double height = -INFINITY;
    for (int32_t t = 0; t < body->triangle_count; ++t) {
        height = fmax(height, height_over(body, t, p, a, end));
    }
    return height;
}

/* Least distance to a fixed node; INFINITY: nothing is. */
static double fixed_distance(const ss_touch_body *body, const double p[3])
{
    double least = INFINITY, way[3];
    for (int32_t i = 0; i < body->node_count; ++i) {
        if (body->fixed[i] != 0) {
            ss_sub3(way, body->position[i], p);
            least = fmin(least, ss_dot3(way, way));
        }
    }
    return sqrt(least);
}

/* Area vectors of the surface at its nodes, and how many may be pressed from `a`: level, free. */
static int32_t find_level(const ss_touch_body *body, const double a[3], double (*vector)[3])
{
    for (int32_t t = 0; t < body->triangle_count; ++t) {
        const int32_t *c = body->triangle[t];
        double normal[3];
        ss_normal3(normal, body->position[c[0]], body->position[c[1]], body->position[c[2]]);
        for (int k = 0; k < 3; ++k) {
            ss_add3(vector[c[k]], vector[c[k]], normal);
        }
    }
    int32_t count = 0;
    for (int32_t i = 0; i < body->node_count; ++i) {
        const double area = ss_normalize3(vector[i]);
        if (!(area > 0.0) || body->fixed[i] != 0 || ss_dot3(vector[i], a) < LEVEL) {
            ss_set3(vector[i], 0.0, 0.0, 0.0);
        } else {
            ++count;
        }
    }
    return count;
}

/* The middle of the box around the surface's nodes, and the longest way from it across `a`. */
static double find_middle(const ss_touch_body *body, const double a[3], double out_middle[3])
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double widest = 0.0;
    for (int32_t t = 0; t < 3 * body->triangle_count; ++t) {
        const double *x = body->position[body->triangle[t / 3][t % 3]];
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], x[k]);
            high[k] = fmax(high[k], x[k]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        out_middle[k] = 0.5 * (low[k] + high[k]);
    }
    for (int32_t t = 0; t < 3 * body->triangle_count; ++t) {
        widest = fmax(widest, across(body->position[body->triangle[t / 3][t % 3]], out_middle, a));
    }
    return widest;
}

bool ss_touch_find(const ss_touch_body *body, const double a[3], const ss_touch_end *end,
                   ss_touch *out)
{
    double middle[3], best = INFINITY;
    double(*vector)[3] = calloc((size_t)body->node_count + 1, sizeof *vector);
    if (vector == NULL) {
        return false;
    }
    const int32_t places = find_level(body, a, vector);
    const double widest = find_middle(body, a, middle);
    int32_t number = 0;
    for (int32_t i = 0; i < body->node_count; ++i) {
        if (!(ss_norm3(vector[i]) > 0.0) || number++ % (1 + places / MAX_PLACES) != 0) {
            continue;
        }
        const double *p = body->position[i];
        const double level = ss_dot3(vector[i], a);
        double cost =
            across(p, middle, a) / widest + 1.0 - level + STEEP_COST * fmax(0.0, GENTLE - level);
        if (cost >= best) {
            continue;
        }
        cost += fmax(0.0, 1.0 - fixed_distance(body, p) / (CLEAR_RADII * end->radius));
        if (cost >= best) {
            continue;
        }
        const double height = touch_height(body, p, a, end);
        if (height - ss_dot3(p, a) - end_below(end, 0.0) <= OFF_RADII * end->radius) {
            best = cost;
            ss_copy3(out->point, p);
            ss_copy3(out->normal, vector[i]);
            ss_madd3(out->origin, p, height - ss_dot3(p, a), a);
        }
    }
    free(vector);
    return isfinite(best);
}

double ss_touch_distance(const ss_touch_body *body, const double x[3], double out_nearest[3])
{
    double least = INFINITY;
    for (int32_t t = 0; t < body->triangle_count; ++t) {
        const int32_t *c = body->triangle[t];
        double on[3], way[3];
        ss_contact_closest(x, body->position[c[0]], body->position[c[1]], body->position[c[2]], on);
        ss_sub3(way, on, x);
        const double distance = ss_dot3(way, way);
        if (distance < least) {
            least = distance;
            ss_copy3(out_nearest, on);
        }
    }
    return sqrt(least);
}
