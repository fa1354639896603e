/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Fills a smooth level set with well-shaped tetrahedra: isosurface stuffing (Labelle and Shewchuk
 * 2007) on a body-centred cubic lattice. Surface nodes lie on the level set to rounding.
 */
#include "solid.h"

/* f(x) < 0 inside; continuous. */
typedef double (*stuff_level)(const void *body, const double x[3]);

enum { STUFF_MAX_CELLS = 4000000 };

/* `low` and `high` enclose the body; `edge` is the edge of the lattice's cubes, m. False when out
 * of memory, or for more than STUFF_MAX_CELLS cubes. */
bool stuff(stuff_level level, const void *body, const double low[3], const double high[3],
           double edge, solid *out);
