/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which points are near: points sorted into the cells of a cubic grid, as few cells as points.
 * Memory is the arena's, the points are borrowed. Thread: set-up only; nearest: any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "rt/arena.h"

typedef struct ss_point_grid {
    const double (*point)[3];
    int32_t count;
    double low[3], cell; /* m */
    int32_t cells[3];
    int32_t *first; /* cells + 1 */
    int32_t *member;
} ss_point_grid;

/* `cell` (m): about the reach of the questions to come. False when out of memory. */
bool ss_point_grid_init(ss_point_grid *grid, int32_t count, const double (*point)[3], double cell,
                        ss_arena *arena);
/* The at most `most` points nearest to x, none further than `reach` (m, may be INFINITY), by
 * distance and then by number: out_square (m^2) has room for `most` too. Returns their number. */
int32_t ss_point_grid_nearest(const ss_point_grid *grid, const double x[3], int32_t most,
                              double reach, int32_t *out_point, double *out_square);
