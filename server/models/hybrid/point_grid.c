/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/point_grid.h"

#include <math.h>

#include "rt/vec.h"

static int32_t cell_of(const ss_point_grid *grid, const double x[3], int k)
{
    const double at = floor((x[k] - grid->low[k]) / grid->cell);
    return (int32_t)fmin(fmax(at, 0.0), grid->cells[k] - 1);
}

static int32_t place(const ss_point_grid *grid, int32_t i, int32_t j, int32_t k)
{
    return (k * grid->cells[1] + j) * grid->cells[0] + i;
}

static int32_t place_of(const ss_point_grid *grid, const double x[3])
{
    return place(grid, cell_of(grid, x, 0), cell_of(grid, x, 1), cell_of(grid, x, 2));
}

bool ss_point_grid_init(ss_point_grid *grid, int32_t count, const double (*point)[3], double cell,
                        ss_arena *arena)
{
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    *grid = (ss_point_grid){.point = point, .count = count, .cell = cell};
    ss_set3(grid->low, INFINITY, INFINITY, INFINITY);
    for (int32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            grid->low[k] = fmin(grid->low[k], point[i][k]);
            high[k] = fmax(high[k], point[i][k]);
        }
    }
    if (!(grid->cell > 0.0 && isfinite(grid->cell))) { /* points that say nothing of a size */
        grid->cell = 1.0;
    }
    /* Far finer than any count of points needs; the least numbers do not grow by a quarter. */
    for (int k = 0; k < 3 && count > 0; ++k) {
        grid->cell = fmax(grid->cell, 1e-12 * (high[k] - grid->low[k]));
    }
    /* No more cells than eight a point, whatever the reach. */
    double cells = INFINITY;
    while (count > 0 && cells > 8.0 * count) {
        cells = 1.0;
        for (int k = 0; k < 3; ++k) {
            cells *= floor((high[k] - grid->low[k]) / grid->cell) + 1.0;
        }
        grid->cell *= cells > 8.0 * count ? 1.25 : 1.0;
    }
    for (int k = 0; k < 3; ++k) {
        grid->cells[k] = count > 0 ? (int32_t)floor((high[k] - grid->low[k]) / grid->cell) + 1 : 1;
    }
    const int32_t total = grid->cells[0] * grid->cells[1] * grid->cells[2];
    grid->first = ss_arena_get(arena, (size_t)total + 2, sizeof *grid->first);
    grid->member = ss_arena_get(arena, (size_t)count, sizeof *grid->member);
    if (grid->first == NULL || grid->member == NULL) {
        return false;
    }
    for (int32_t i = 0; i < count; ++i) {
        ++grid->first[place_of(grid, point[i]) + 2];
    }
    for (int32_t c = 0; c < total; ++c) {
        grid->first[c + 2] += grid->first[c + 1];
    }
    for (int32_t i = 0; i < count; ++i) {
        grid->member[grid->first[place_of(grid, point[i]) + 1]++] = i;
    }
    return true;
}

typedef struct search {
    double x[3];
    int32_t most, count;
    double limit; /* m^2: nothing further is wanted */
    int32_t *point;
    double *square;
} search;

static void offer(search *s, int32_t point, double square)
{
    if (square > s->limit) {
        return;
    }
    int32_t at = s->count < s->most ? s->count++ : s->most;
    while (at > 0 && (s->square[at - 1] > square ||
                      (!(s->square[at - 1] < square) && s->point[at - 1] > point))) {
        if (at < s->most) {
            s->point[at] = s->point[at - 1];
            s->square[at] = s->square[at - 1];
        }
        --at;
    }
    if (at < s->most) {
        s->point[at] = point;
        s->square[at] = square;
    }
    if (s->count == s->most) {
        s->limit = fmin(s->limit, s->square[s->most - 1]);
    }
}

static void look_into(const ss_point_grid *grid, search *s, int32_t i, int32_t j, int32_t k)
{
    const int32_t c = place(grid, i, j, k);
    for (int32_t m = grid->first[c]; m < grid->first[c + 1]; ++m) {
        double d[3];
        ss_sub3(d, grid->point[grid->member[m]], s->x);
        offer(s, grid->member[m], ss_dot3(d, d));
    }
}

static bool is_in(const ss_point_grid *grid, const int32_t at[3])
{
    return at[0] >= 0 && at[1] >= 0 && at[2] >= 0 && at[0] < grid->cells[0] &&
           at[1] < grid->cells[1] && at[2] < grid->cells[2];
}

int32_t ss_point_grid_nearest(const ss_point_grid *grid, const double x[3], int32_t most,
                              double reach, int32_t *out_point, double *out_square)
{
    search s = {.most = most, .limit = reach * reach, .point = out_point, .square = out_square};
    ss_copy3(s.x, x);
    int32_t home[3];
    int32_t last = 0;
    for (int k = 0; k < 3; ++k) {
        home[k] = cell_of(grid, x, k);
        last = last > grid->cells[k] ? last : grid->cells[k];
    }
    /* Shell by shell of cells around x's own, or the one nearest to an x outside: all of shell n is
     * at least n - 1 cells away. */
    for (int32_t shell = 0; shell <= last; ++shell) {
        const double near = fmax(0.0, (shell - 1) * grid->cell);
        if (near * near > s.limit) {
            break;
        }
        for (int32_t k = -shell; k <= shell; ++k) {
            for (int32_t j = -shell; j <= shell; ++j) {
                const bool is_face = k == -shell || k == shell || j == -shell || j == shell;
                for (int32_t i = -shell; i <= shell; i += is_face || shell == 0 ? 1 : 2 * shell) {
                    const int32_t at[3] = {home[0] + i, home[1] + j, home[2] + k};
                    if (is_in(grid, at)) {
                        look_into(grid, &s, at[0], at[1], at[2]);
                    }
                }
            }
        }
    }
    return s.count;
}
