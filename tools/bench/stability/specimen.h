/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The body of the stability report: a rounded cube of 100 mm in SS_SPECIMEN_CELLS^3 cells of six
 * tetrahedra (Kuhn), 125 nodes, numbered layer by layer from below; small enough for thousands of
 * runs, with inner nodes, edges and a curved top. One element of the inside and one of the top may
 * be flattened to a share of its height.
 * Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum {
    SS_SPECIMEN_CELLS = 4,
    SS_SPECIMEN_SIDE = SS_SPECIMEN_CELLS + 1,
    SS_SPECIMEN_LAYER = SS_SPECIMEN_SIDE * SS_SPECIMEN_SIDE,
    SS_SPECIMEN_NODES = SS_SPECIMEN_LAYER * SS_SPECIMEN_SIDE,
    SS_SPECIMEN_TETRAHEDRA = 6 * SS_SPECIMEN_CELLS * SS_SPECIMEN_CELLS * SS_SPECIMEN_CELLS,
    SS_SPECIMEN_TOP = SS_SPECIMEN_NODES - SS_SPECIMEN_LAYER /* the first node of the top */
};
#define SS_SPECIMEN_SIZE 0.1 /* m */

typedef struct ss_specimen {
    double rest[SS_SPECIMEN_NODES][3]; /* m */
    int32_t tetrahedron[SS_SPECIMEN_TETRAHEDRA][4];
} ss_specimen;

/* `flatness` 1: as it is; below: what is left of two elements' heights. */
void ss_specimen_make(double flatness, ss_specimen *out);
bool ss_specimen_is_surface(int32_t node);
/* As Gmsh 2.2 ASCII, in metres, numbers of the body. */
void ss_specimen_write(const ss_specimen *specimen, FILE *file);
/* Tetrahedra that are turned inside out at displacements `u`. */
int32_t ss_specimen_inverted(const ss_specimen *specimen, const double (*u)[3]);
