/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: a surface of triangles while repair.c mends it. Nodes and triangles are
 * appended, and taken out in order; each knows the node or triangle of the file that it stems from,
 * by which what is done is told. One step each of stitch.c, sheets.c and holes.c; mend_surface.c
 * goes round them until nothing changes.
 *
 * Lengths, relative to the mean edge h: nodes of open edges are one within SS_MEND_REACH, shorter
 * edges are closed up, and nodes so near to an open edge lie on it. Sheets that touched are parted
 * by SS_MEND_GAP, more than that, so that nothing joins them again.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "mesh/topology.h"

#define SS_MEND_REACH 1e-3
#define SS_MEND_GAP   2e-3

typedef struct ss_mend {
    int32_t node_count, node_room, triangle_count, triangle_room;
    double (*position)[3];
    int32_t *node_origin; /* -1: of none */
    int32_t (*triangle)[3];
    int32_t *origin;    /* of a triangle; -1: of none */
    int32_t *root;      /* of the file's nodes, those that were welded joined (union-find) */
    double mean_edge;   /* as the round began */
    int32_t part_count; /* element of a file's face: 1, or 2 triangles of a quad */
    ss_mesh_repairs *done;
} ss_mend;

/* The mesh as the functions of mesh.h take it; borrows all arrays. */
ss_mesh ss_mend_view(const ss_mend *m);
/* Each returns false when out of memory. */
bool ss_mend_add_node(ss_mend *m, const double x[3], int32_t origin, int32_t *out_node);
bool ss_mend_add_triangle(ss_mend *m, int32_t a, int32_t b, int32_t c, int32_t origin);
/* Takes out the triangles whose first node is negative. */
void ss_mend_drop_triangles(ss_mend *m);
/* The file's numbers, for what is told. */
int32_t ss_mend_element(const ss_mend *m, int32_t triangle);
int32_t ss_mend_node(const ss_mend *m, int32_t node);

/* mend_surface.c: the surface of `mesh`, mended. */
softsim_status ss_mend_surface(const ss_mesh *mesh, ss_mesh **out_mesh, ss_mesh_repairs *done,
                               softsim_error *error);

/* stitch.c: welds nodes; closes up short edges; drops flat and double triangles; divides triangles
 * at nodes that lie on their open edges. */
bool ss_mend_stitch(ss_mend *m);
/* sheets.c: parts the surface at edges of more than two triangles and at pinched nodes; makes the
 * winding of each sheet one. */
bool ss_mend_part_sheets(ss_mend *m);
/* holes.c: fills small holes; drops parts that enclose no volume or are too small. */
bool ss_mend_fill_holes(ss_mend *m);
bool ss_mend_drop_small_parts(ss_mend *m);
