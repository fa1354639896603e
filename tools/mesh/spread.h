/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Exactly n points spread evenly over an organ, and the triangles between them: closed, wound
 * counter-clockwise from outside, near-equilateral, numbered along a space-filling curve so that
 * neighbours are near in memory. The same result every time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "shape.h"

enum { SPREAD_MIN_POINTS = 64, SPREAD_MAX_POINTS = 200000 };

typedef struct spread {
    int32_t node_count, triangle_count; /* 2 n - 4 triangles */
    double (*position)[3];
    int32_t (*triangle)[3];
} spread;

/* False when out of memory. */
bool spread_init(spread *s, const organ *o, int32_t point_count);
void spread_fini(spread *s);
