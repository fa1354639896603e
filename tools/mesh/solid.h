/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Tetrahedra of generated bodies: what stuffing.h, prism.h and the grids of volume.c make, and
 * what smooths them. Every tetrahedron has a positive volume. Memory belongs to the solid.
 */
#include <stdbool.h>
#include <stdint.h>

typedef struct solid {
    int32_t node_count, tetrahedron_count;
    int32_t node_room, tetrahedron_room;
    int32_t surface_count; /* nodes on the level set, of stuffing.h */
    double (*position)[3];
    int32_t (*tetrahedron)[4];
} solid;

void solid_fini(solid *s);
/* Each returns false when out of memory, and then leaves what is there as it is. */
bool solid_add_node(solid *s, const double x[3], int32_t *out_node);
/* Turns it where its volume would be negative. */
bool solid_add_tetrahedron(solid *s, int32_t a, int32_t b, int32_t c, int32_t d);

/* How bad a tetrahedron is: the greatest |cos| of its six dihedral angles, so the lower, the
 * further are they from 0 and 180 degrees; or, where that is worse, 1 - 0.18 (its least height) /
 * height, which tells an element too small for its neighbours (height 0: not judged). 2 when it is
 * inverted or flat. */
double solid_badness(const double a[3], const double b[3], const double c[3], const double d[3],
                     double height);

/* Moves nodes so that the worst tetrahedron around each gets better, surface nodes along the
 * surface: `project` takes a point back to it; NULL: surface nodes stay. `edge`: about the length
 * of an edge, m. */
bool solid_smooth(solid *s, double edge, int sweeps, void (*project)(const void *body, double x[3]),
                  const void *body);

/* Takes inner nodes away, those of the lowest `depth` first, until `node_count` are left or no more
 * can go: the inside gets coarser than the surface. No edge grows longer than `longest`, m. */
bool solid_coarsen(solid *s, const double *depth, int32_t node_count, double longest);
