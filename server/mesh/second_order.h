/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: tetrahedra of second order. Sides are numbered 01 02 03 12 13 23; every
 * format has an order of its own for the nodes in their middle, which are the last six of ten.
 */
#include "mesh/mesh.h"

extern const int8_t ss_mesh_edge_ends[6][2];

/* The edges in the order of a format. Gmsh's manual, "Node ordering", Tetrahedron10; VTK's
 * vtkQuadraticTetra; tetgen -o2, whose manual is silent: as version 1.5.0 writes straight ones. */
extern const int8_t ss_mesh_edges_of_gmsh[6];
extern const int8_t ss_mesh_edges_of_vtk[6];
extern const int8_t ss_mesh_edges_of_tetgen[6];

/* The edge of tetrahedron e between nodes a and b, which it has. */
int ss_mesh_find_edge(const ss_mesh *mesh, int32_t e, int32_t a, int32_t b);
