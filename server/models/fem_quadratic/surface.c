/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * The finer surface that the middles of edges follow (object.surface): each goes to the point of it
 * that is nearest to the straight middle. Corners stay where the mesh has them.
 *
 * Triangles are listed by the cells of a grid that their boxes touch; a cell is as large as two
 * mean edges, a quarter of the largest triangle's box and a sixty-fourth of the whole, so that no
 * mesh makes lists long. Rejected: the tree of contact/surface.c, which belongs to a tool's query.
 */
#include <math.h>
#include <string.h>

#include "contact/contact.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MOST_CELLS = 64 };
/* Of an edge's length: the surface is no farther from its middle, or it is another body's. */
#define REACH 0.5

typedef struct grid {
    const ss_mesh *surface;
    double low[3], size; /* m; of a cell */
    int32_t cells[3];
    int32_t *first, *triangle; /* cell c: triangle[first[c]] .. triangle[first[c + 1] - 1] */
} grid;

static void triangle_box(const ss_mesh *mesh, int32_t t, double low[3], double high[3])
{
    for (int i = 0; i < 3; ++i) {
        const double a = mesh->position[mesh->triangle[t][0]][i];
        const double b = mesh->position[mesh->triangle[t][1]][i];
        const double c = mesh->position[mesh->triangle[t][2]][i];
        low[i] = fmin(a, fmin(b, c));
        high[i] = fmax(a, fmax(b, c));
    }
}

/* The cells of a box, clamped to the grid. */
static void cells_of(const grid *g, const double low[3], const double high[3], int32_t from[3],
                     int32_t to[3])
{
    for (int i = 0; i < 3; ++i) {
        const double last = g->cells[i] - 1;
        from[i] = (int32_t)fmin(fmax(floor((low[i] - g->low[i]) / g->size), 0.0), last);
        to[i] = (int32_t)fmin(fmax(floor((high[i] - g->low[i]) / g->size), 0.0), last);
    }
}

static void measure(grid *g)
{
    double high[3] = {-INFINITY, -INFINITY, -INFINITY}, widest = 0.0, extent = 0.0;
    ss_set3(g->low, INFINITY, INFINITY, INFINITY);
    for (int32_t t = 0; t < g->surface->triangle_count; ++t) {
        double a[3], b[3];
        triangle_box(g->surface, t, a, b);
        for (int i = 0; i < 3; ++i) {
            g->low[i] = fmin(g->low[i], a[i]);
            high[i] = fmax(high[i], b[i]);
            widest = fmax(widest, b[i] - a[i]);
        }
    }
    for (int i = 0; i < 3; ++i) {
        extent = fmax(extent, high[i] - g->low[i]);
    }
    g->size = fmax(2.0 * ss_body_mean_side(g->surface), fmax(0.25 * widest, extent / MOST_CELLS));
    for (int i = 0; i < 3; ++i) {
        g->cells[i] = 1 + (int32_t)fmin((high[i] - g->low[i]) / g->size, MOST_CELLS);
    }
}

static bool grid_init(grid *g, const ss_mesh *surface)
{
    *g = (grid){.surface = surface};
    measure(g);
    const size_t count = (size_t)g->cells[0] * (size_t)g->cells[1] * (size_t)g->cells[2];
    g->first = ss_memory_get(count + 2, sizeof *g->first);
    for (int turn = 0; turn < 2 && g->first; ++turn) { /* count, then fill */
        for (int32_t t = 0; t < surface->triangle_count; ++t) {
            double low[3], high[3];
            int32_t a[3], b[3], at[3];
            triangle_box(surface, t, low, high);
            cells_of(g, low, high, a, b);
            for (at[2] = a[2]; at[2] <= b[2]; ++at[2]) {
                for (at[1] = a[1]; at[1] <= b[1]; ++at[1]) {
                    for (at[0] = a[0]; at[0] <= b[0]; ++at[0]) {
                        int32_t *c =
                            g->first + (at[2] * g->cells[1] + at[1]) * g->cells[0] + at[0] + 1;
                        if (turn == 0) {
                            ++c[1];
                        } else {
                            g->triangle[(*c)++] = t;
                        }
                    }
                }
            }
        }
        if (turn == 0) {
            for (size_t c = 0; c < count; ++c) {
                g->first[c + 2] += g->first[c + 1];
            }
            g->triangle = ss_memory_get((size_t)g->first[count + 1] + 1, sizeof *g->triangle);
            if (!g->triangle) {
                return false;
            }
        }
    }
    return g->first != NULL;
}

/* The point nearest to x, no farther than `reach`; false: none. */
static bool find_nearest(const grid *g, const double x[3], double reach, double out[3])
{
    double low[3], high[3], least = reach * reach;
    int32_t a[3], b[3], at[3];
    bool is_found = false;
    for (int i = 0; i < 3; ++i) {
        low[i] = x[i] - reach;
        high[i] = x[i] + reach;
    }
    cells_of(g, low, high, a, b);
    for (at[2] = a[2]; at[2] <= b[2]; ++at[2]) {
        for (at[1] = a[1]; at[1] <= b[1]; ++at[1]) {
            for (at[0] = a[0]; at[0] <= b[0]; ++at[0]) {
                const int32_t c = (at[2] * g->cells[1] + at[1]) * g->cells[0] + at[0];
                for (int32_t k = g->first[c]; k < g->first[c + 1]; ++k) {
                    const int32_t *n = g->surface->triangle[g->triangle[k]];
                    double point[3], way[3];
                    ss_contact_closest(x, g->surface->position[n[0]], g->surface->position[n[1]],
                                       g->surface->position[n[2]], point);
                    ss_sub3(way, point, x);
                    const double square = ss_dot3(way, way);
                    if (square < least) {
                        least = square;
                        is_found = true;
                        ss_copy3(out, point);
                    }
                }
            }
        }
    }
    return is_found;
}

bool ss_quadratic_follow(const ss_mesh *surface, int32_t count, const double *length,
                         double (*position)[3], int32_t *out_lost)
{
    grid g;
    const bool is_good = grid_init(&g, surface);
    *out_lost = 0;
    for (int32_t k = 0; is_good && k < count; ++k) {
        double point[3] = {0.0, 0.0, 0.0};
        if (find_nearest(&g, position[k], REACH * length[k], point)) {
            ss_copy3(position[k], point);
        } else {
            ++*out_lost;
        }
    }
    ss_memory_free(g.first);
    ss_memory_free(g.triangle);
    return is_good;
}
