/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Inside server/mesh only: the triangles at an edge, sorted by their angle about it. */
#include "mesh/topology.h"

/* A triangle about an edge. */
typedef struct ss_leaf {
    double angle;      /* 0 to 2 pi, from the first triangle on */
    double height;     /* of the third node above the edge */
    int32_t side;      /* 3 t + corner */
    bool is_ascending; /* runs from the edge's lower node to the higher one */
} ss_leaf;

/* The edge, from its lower node, and the plane across it. */
typedef struct ss_leaf_axis {
    double from[3], along[3], first[3], second[3]; /* unit vectors but for `from` */
    double length;
} ss_leaf_axis;

/* Of the tuples `begin` on, which are one edge's: `out` has room for `count`. */
void ss_mesh_sort_leaves(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin,
                         int32_t count, ss_leaf_axis *out_axis, ss_leaf *out);
