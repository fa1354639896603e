/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Is a point inside the tissue? The penalty cannot tell: once the surface has passed over a tool's
 * middle it pushes the tool on in, and lets go.
 *
 * A ray from the point counts the facets of the smooth surface that it leaves through, less those
 * that it enters through: the winding number of a closed surface. Whether it meets a facet is asked
 * edge by edge (Sunday's crossing rule in the plane across the ray), so that an edge says the same
 * to both of its facets, corners and degenerate facets included. Two triangles know the points on
 * their common side from different rows, though, and rounding opens a crack of 1e-9 m there: a
 * second ray must agree, and both are aslant, since meshes and tools like to lie along axes.
 * Cost: the leaves of the tree that a ray meets, some 2 us: a middle that was outside, and that
 * neither it nor the surface can have carried in since, is not asked for. Rejected: the nearest
 * point's side (ss_contact_locate), which looks at all triangles.
 */
#include <math.h>

#include "contact/internal.h"
#include "rt/vec.h"

/* origin + h (slope[0], slope[1], side), h > 0. */
typedef struct beam {
    ss_wide origin; /* relative to the surface's centre */
    double slope[2], side;
} beam;

static const double slopes[2][2] = {{0.0917, 0.0531}, {-0.0673, 0.1129}};

/* Does the ray miss the box from `low` to `high`, relative to its origin? */
static bool is_missed(const beam *ray, const ss_wide *low, const ss_wide *high, double width)
{
    const double down = (double)(*low)[2] - width, up = (double)(*high)[2] + width;
    const double from = fmax(0.0, ray->side > 0.0 ? down : -up);
    const double to = ray->side > 0.0 ? up : -down;
    if (to < from) {
        return true;
    }
    for (int k = 0; k < 2; ++k) {
        const double a = ray->slope[k] * from, b = ray->slope[k] * to;
        if (fmax(a, b) < (double)(*low)[k] - width || fmin(a, b) > (double)(*high)[k] + width) {
            return true;
        }
    }
    return false;
}

/* A point in the plane across the ray, and its height along it. */
typedef struct seen {
    double x, y, h;
} seen;

static double turn(const seen *a, const seen *b)
{
    return a->x * b->y - a->y * b->x;
}

/* +1 or -1 when the edge passes the ray on its right, upwards or downwards. */
static int32_t pass(const seen *a, const seen *b, double turned)
{
    if (a->y <= 0.0 && b->y > 0.0) {
        return turned > 0.0;
    }
    return a->y > 0.0 && b->y <= 0.0 && turned < 0.0 ? -1 : 0;
}

static int32_t cross_facet(const seen *a, const seen *b, const seen *c)
{
    const double ab = turn(a, b), bc = turn(b, c), ca = turn(c, a);
    const int32_t wound = pass(a, b, ab) + pass(b, c, bc) + pass(c, a, ca);
    return wound != 0 && wound * (bc * a->h + ca * b->h + ab * c->h) > 0.0 ? wound : 0;
}

static int32_t cross_triangle(const ss_surface *surface, const ss_real *u, const beam *ray,
                              int32_t t)
{
    const ss_grid *grid = &surface->grid;
    const int point_count = grid->facet_count == 1 ? 3 : SS_GRID_POINTS;
    ss_wide point[SS_GRID_ROW];
    ss_surface_points(surface, t, u, &ray->origin, point);
    ss_wide low = point[0], high = point[0];
    for (int p = 1; p < point_count; ++p) {
        ss_wide_lower(&low, &point[p]);
        ss_wide_raise(&high, &point[p]);
    }
    if (is_missed(ray, &low, &high, 0.0)) {
        return 0;
    }
    seen at[SS_GRID_POINTS];
    for (int p = 0; p < point_count; ++p) {
        const double h = ray->side * (double)point[p][2];
        at[p] = (seen){.x = (double)point[p][0] - ray->slope[0] * h,
                       .y = (double)point[p][1] - ray->slope[1] * h,
                       .h = h};
    }
    int32_t sum = 0;
    for (int32_t f = 0; f < grid->facet_count; ++f) {
        const uint8_t *p = grid->facet[f];
        sum += cross_facet(&at[p[0]], &at[p[1]], &at[p[2]]);
    }
    return sum;
}

static int32_t cross_surface(const ss_surface *surface, const ss_real *u, const beam *ray,
                             double width)
{
    int32_t stack[SS_TREE_STACK];
    int depth = 0;
    int32_t sum = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const int32_t at = stack[--depth];
        const ss_wide low = surface->box[at].low - ray->origin;
        const ss_wide high = surface->box[at].high - ray->origin;
        if (is_missed(ray, &low, &high, width)) {
            continue;
        }
        const int32_t leaf = at - (surface->leaf_count - 1);
        if (leaf < 0) {
            stack[depth++] = 2 * at + 2;
            stack[depth++] = 2 * at + 1;
            continue;
        }
        const int32_t end = ss_leaf_first_triangle(surface, leaf + 1);
        for (int32_t t = ss_leaf_first_triangle(surface, leaf); t < end; ++t) {
            sum += cross_triangle(surface, u, ray, t);
        }
    }
    /* Seen from the other side all turns are the other way round. */
    return ray->side > 0.0 ? sum : -sum;
}

/* Is the point further than a mean edge from the whole surface's box? */
static bool is_far(const ss_surface *surface, const ss_wide *x)
{
    const double width = surface->moved + surface->mean_edge;
    bool is_out = false;
    for (int k = 0; k < 3; ++k) {
        is_out = is_out || (double)(*x)[k] > (double)surface->box[0].high[k] + width ||
                 (double)(*x)[k] < (double)surface->box[0].low[k] - width;
    }
    return is_out;
}

/* No point of the surface is nearer to the tool's middle. A point of a facet is within twice the
 * facet's reach of a sample, no sample is more than `deepest` inside the tool, and depths change by
 * no more than the way. */
static double clear_of(const ss_contact_query *query, double deepest)
{
    const bool is_whole = query->dropped_from == query->candidate_count;
    return is_whole ? query->centre_depth - deepest - 2.0 * (double)query->max_facet_radius : 0.0;
}

/* A middle that was outside is so until it and the surface have moved by what was between them,
 * straight from how they were then. Half of that, for a step may have moved the tissue since. */
static bool is_still_outside(const ss_contact_query *query, const double middle[3])
{
    const ss_outside *last = &query->outside;
    const ss_surface *surface = query->surface;
    if (!last->is_known || surface->fit > last->fit + 1) {
        return false;
    }
    double way[3];
    ss_sub3(way, middle, last->middle);
    const double refitted = surface->fit > last->fit ? surface->fit_moved : 0.0;
    return ss_norm3(way) + last->moved + refitted + surface->moved < 0.5 * last->clear;
}

static bool is_wound_about(const ss_contact_query *query, const ss_real *u, const ss_wide *at)
{
    const double width = query->surface->moved + query->margin;
    for (int k = 0; k < 2; ++k) {
        const beam ray = {
            .origin = *at, .slope = {slopes[k][0], slopes[k][1]}, .side = k == 0 ? 1.0 : -1.0};
        if (cross_surface(query->surface, u, &ray, width) <= 0) {
            return false;
        }
    }
    return true;
}

bool ss_contact_query_is_inside(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                                double deepest)
{
    const ss_surface *surface = query->surface;
    double middle[3];
    ss_wide at = {0};
    ss_rotate(middle, pose->orientation, query->centre);
    ss_add3(middle, middle, pose->position);
    for (int k = 0; k < 3; ++k) {
        at[k] = (ss_real)(middle[k] - surface->centre[k]);
    }
    if (!surface->is_closed || surface->fit == 0) {
        return false;
    }
    const bool is_outside =
        is_far(surface, &at) || is_still_outside(query, middle) || !is_wound_about(query, u, &at);
    query->outside = (ss_outside){.is_known = is_outside,
                                  .clear = clear_of(query, deepest),
                                  .fit = surface->fit,
                                  .moved = surface->moved};
    ss_copy3(query->outside.middle, middle);
    return !is_outside;
}
