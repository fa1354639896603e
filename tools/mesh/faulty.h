/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What a repair leaves, as lines of text with a place to look, and as a VTK file to look at. */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"

typedef struct faulty {
    const ss_mesh *mesh;
    /* Of each triangle of the surface, and of each tetrahedron: what is wrong with it. */
    bool *is_crossing, *is_overlapping, *is_at_hole;
    ss_mesh_fault crossing, hole;
    bool is_crossing_complete;
    ss_mesh_report report;
    ss_mesh_finding row[SS_MESH_MAX_FINDINGS]; /* of what a scene refuses */
    int32_t row_count;
} faulty;

/* False when out of memory. */
bool faulty_find(faulty *f, const ss_mesh *mesh);
void faulty_fini(faulty *f);
/* "PATH: left as they are: WHAT: count (...), the first at x y z: REMEDY", one line for each. */
void faulty_print(const faulty *f, const char *path);
/* The triangles that cross others (1), those at open edges (2) and the tetrahedra that overlap (3),
 * with these numbers as the array "fault". */
softsim_status faulty_write(const faulty *f, const char *path, softsim_error *error);
