/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Which planes, triangles and edges of a convex mesh can matter where.
 *
 * An octree over the mesh's box and a margin; each leaf lists, by number, the planes that are the
 * highest somewhere in it, and, unless it lies inside, the triangles that have one of these planes
 * and the edges that are the nearest. The tests are for a whole cell with centre c, half edges h
 * and half diagonal r, and keep too many rather than too few:
 *
 *   plane f   stays while  (v_f - v_g)(c) + sum_k h_k |n_f - n_g|_k >= -e  for each g that is the
 *             highest at c or at a corner: v_f - v_g is linear, and this is its most in the cell
 *   edge k    stays while  D_k(c) - r <= min_l D_l(c) + r: distances are 1-Lipschitz
 *
 * So what a leaf's lists give is what all planes, triangles and edges give, bit for bit, and
 * without a memory of where the last point was. A cell asks its parent's lists alone. Rejected: to
 * walk from face to face from the last answer: inside, the highest plane need not be reached over
 * edges (the two sides of a plate share none), and an answer between two equal ones would depend on
 * the way.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "contact/convex_cells.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum {
    MOST_CELLS = 4096, /* a cell that would need more stays whole: slower, the same answer */
    MOST_ENTRIES = 1 << 19,
    MOST_DEPTH = 5,
    SMALLEST = 1 << MOST_DEPTH, /* cells along an axis */
    FEW_PLANES = 6,             /* so few are not divided further */
    FEW_EDGES = 12
};

/* What is built; cells stand breadth first. */
typedef struct divider {
    ss_convex *convex;
    double slack; /* m, over rounding */
    double (*middle)[3];
    int8_t *depth;
    int32_t cell_count, entry_count;
    bool is_listed[UINT8_MAX + 1]; /* planes; clear between calls */
    double *distance;              /* of a cell's edges */
} divider;

static void corner_of(const double middle[3], const double half[3], int which, double out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = middle[k] + ((which >> k) & 1 ? half[k] : -half[k]);
    }
}

static int32_t highest_of(const ss_convex *convex, const uint16_t *plane, int32_t count,
                          const double x[3])
{
    int32_t top = plane[0];
    double most = -DBL_MAX;
    for (int32_t i = 0; i < count; ++i) {
        const double value = ss_convex_plane_value(convex, plane[i], x);
        if (value > most) {
            most = value;
            top = plane[i];
        }
    }
    return top;
}

/* Can plane f be above g somewhere in the cell? */
static bool can_be_above(const divider *d, int32_t f, int32_t g, const double middle[3],
                         const double half[3])
{
    const ss_convex *convex = d->convex;
    double most =
        ss_convex_plane_value(convex, f, middle) - ss_convex_plane_value(convex, g, middle);
    for (int k = 0; k < 3; ++k) {
        most += half[k] * fabs(convex->plane[f][k] - convex->plane[g][k]);
    }
    return most >= -convex->bulge - d->slack;
}

/* Appends those of `from` that can be the highest in the cell; whether one can be above 0 there. */
static bool add_planes(divider *d, const uint16_t *from, int32_t count, const double middle[3],
                       const double half[3])
{
    ss_convex *convex = d->convex;
    int32_t rival[9];
    rival[8] = highest_of(convex, from, count, middle);
    bool is_outside = false;
    for (int k = 0; k < 8; ++k) {
        double corner[3];
        corner_of(middle, half, k, corner);
        rival[k] = highest_of(convex, from, count, corner);
        is_outside = is_outside || ss_convex_plane_value(convex, rival[k], corner) > -d->slack;
    }
    for (int32_t i = 0; i < count; ++i) {
        bool is_kept = true;
        for (int k = 8; k >= 0 && is_kept; --k) {
            is_kept = can_be_above(d, from[i], rival[k], middle, half);
        }
        if (is_kept) {
            convex->list[d->entry_count++] = from[i];
        }
    }
    return is_outside;
}

/* Appends those of `from` whose plane is in list[plane] to list[end - 1], which is in order. */
static void add_triangles(divider *d, const uint16_t *from, int32_t count, int32_t plane,
                          int32_t end)
{
    ss_convex *convex = d->convex;
    for (int32_t i = plane; i < end; ++i) {
        d->is_listed[convex->list[i]] = true;
    }
    for (int32_t i = 0; i < count; ++i) {
        if (d->is_listed[convex->plane_of[from[i]]]) {
            convex->list[d->entry_count++] = from[i];
        }
    }
    for (int32_t i = plane; i < end; ++i) {
        d->is_listed[convex->list[i]] = false;
    }
}

static void add_edges(divider *d, const uint16_t *from, int32_t count, const double middle[3],
                      double radius)
{
    double least = DBL_MAX;
    for (int32_t i = 0; i < count; ++i) {
        double away[3];
        d->distance[i] = sqrt(ss_convex_edge_square(d->convex, from[i], middle, away));
        least = fmin(least, d->distance[i]);
    }
    for (int32_t i = 0; i < count; ++i) {
        if (d->distance[i] <= least + 2.0 * radius + d->slack) {
            d->convex->list[d->entry_count++] = from[i];
        }
    }
}

/* Eight cells in the place of one. */
static void split(divider *d, int32_t at)
{
    ss_convex *convex = d->convex;
    const ss_convex_cell parent = convex->cell[at];
    double half[3];
    ss_scale3(half, convex->half, ldexp(0.5, -d->depth[at]));
    convex->cell[at].child = d->cell_count;
    for (int k = 0; k < 8; ++k) {
        const int32_t i = d->cell_count++;
        ss_convex_cell *cell = &convex->cell[i];
        corner_of(d->middle[at], half, k, d->middle[i]);
        d->depth[i] = (int8_t)(d->depth[at] + 1);
        cell->plane = d->entry_count;
        const bool is_outside = add_planes(d, convex->list + parent.plane,
                                           parent.triangle - parent.plane, d->middle[i], half);
        cell->triangle = d->entry_count;
        if (is_outside) {
            add_triangles(d, convex->list + parent.triangle, parent.edge - parent.triangle,
                          cell->plane, cell->triangle);
        }
        cell->edge = d->entry_count;
        if (is_outside) {
            add_edges(d, convex->list + parent.edge, parent.end - parent.edge, d->middle[i],
                      ss_norm3(half));
        }
        cell->end = d->entry_count;
    }
}

static void divide(divider *d)
{
    ss_convex *convex = d->convex;
    const int32_t count[3] = {convex->plane_count, convex->triangle_count, convex->edge_count};
    for (int k = 0; k < 3; ++k) {
        for (int32_t i = 0; i < count[k]; ++i) {
            convex->list[d->entry_count++] = (uint16_t)i;
        }
    }
    d->cell_count = 1;
    convex->cell[0] =
        (ss_convex_cell){.triangle = count[0], .edge = count[0] + count[1], .end = d->entry_count};
    ss_copy3(d->middle[0], convex->middle);
    for (int32_t at = 0; at < d->cell_count; ++at) {
        const ss_convex_cell *cell = &convex->cell[at];
        const bool is_simple =
            cell->triangle - cell->plane <= FEW_PLANES && cell->end - cell->edge <= FEW_EDGES;
        if (!is_simple && d->depth[at] < MOST_DEPTH && d->cell_count + 8 <= MOST_CELLS &&
            d->entry_count + 8 * (cell->end - cell->plane) <= MOST_ENTRIES) {
            split(d, at);
        }
    }
}

/* Keeps the cells and the leaves' lists, in memory of their size. */
static bool shrink(divider *d)
{
    ss_convex *convex = d->convex;
    int32_t kept = 0;
    for (int32_t at = 0; at < d->cell_count; ++at) { /* lists stand in the order of cells */
        ss_convex_cell *cell = &convex->cell[at];
        if (cell->child == 0) {
            const int32_t count = cell->end - cell->plane;
            memmove(convex->list + kept, convex->list + cell->plane,
                    (size_t)count * sizeof *convex->list);
            cell->triangle += kept - cell->plane;
            cell->edge += kept - cell->plane;
            cell->plane = kept;
            kept += count;
            cell->end = kept;
        }
    }
    ss_convex_cell *cells = ss_memory_get((size_t)d->cell_count, sizeof *cells);
    uint16_t *list = ss_memory_get((size_t)kept, sizeof *list);
    if (cells != NULL && list != NULL) {
        memcpy(cells, convex->cell, (size_t)d->cell_count * sizeof *cells);
        memcpy(list, convex->list, (size_t)kept * sizeof *list);
    }
    SS_EACH(ss_memory_free, convex->cell, convex->list);
    convex->cell = cells;
    convex->list = list;
    return cells != NULL && list != NULL;
}

bool ss_convex_divide(ss_convex *convex)
{
    double diagonal[3];
    ss_sub3(diagonal, convex->high, convex->low);
    const double size = ss_norm3(diagonal);
    for (int k = 0; k < 3; ++k) {
        convex->middle[k] = 0.5 * (convex->low[k] + convex->high[k]);
        convex->half[k] = 0.5 * diagonal[k] + 0.15 * size;
        convex->per_cell[k] = SMALLEST / (2.0 * convex->half[k]);
    }
    divider d = {.convex = convex,
                 .slack = 1e-9 * (size + convex->bounding_radius),
                 .middle = ss_memory_get(MOST_CELLS, sizeof *d.middle),
                 .depth = ss_memory_get(MOST_CELLS, sizeof *d.depth),
                 .distance = ss_memory_get((size_t)convex->edge_count, sizeof *d.distance)};
    convex->cell = ss_memory_get(MOST_CELLS, sizeof *convex->cell);
    convex->list = ss_memory_get(MOST_ENTRIES, sizeof *convex->list);
    bool is_good = d.middle != NULL && d.depth != NULL && d.distance != NULL &&
                   convex->cell != NULL && convex->list != NULL;
    if (is_good) {
        divide(&d);
        is_good = shrink(&d);
    }
    SS_EACH(ss_memory_free, d.middle, d.depth, d.distance);
    return is_good;
}

const ss_convex_cell *ss_convex_find_cell(const ss_convex *convex, const double x[3])
{
    /* The smallest cells' number along each axis: its bits are the way down. */
    int32_t at[3];
    for (int k = 0; k < 3; ++k) {
        const double share = (x[k] - convex->middle[k]) * convex->per_cell[k] + SMALLEST / 2;
        if (!(share >= 0.0 && share < SMALLEST)) {
            return NULL;
        }
        at[k] = (int32_t)share;
    }
    const ss_convex_cell *cell = convex->cell;
    for (int level = MOST_DEPTH - 1; cell->child != 0; --level) {
        cell = &convex->cell[cell->child + ((at[0] >> level) & 1) + 2 * ((at[1] >> level) & 1) +
                             4 * ((at[2] >> level) & 1)];
    }
    return cell;
}
