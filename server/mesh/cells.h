/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: hexahedra, prisms and pyramids as tetrahedra (cells.c).
 */
#include "mesh/mesh.h"

enum { SS_CELL_PIECES = 6 }; /* tetrahedra of a cell at most */

/* Tetrahedra that a cell of this kind gives, fewer where it has a node twice; 0 of other kinds. */
int ss_mesh_cell_pieces(ss_mesh_kind kind);
/* Splits a cell whose nodes are in the order of Gmsh and VTK; returns how many tetrahedra, 0 where
 * it has no volume, or -1 where it is folded: some of them have a negative volume beside others. A
 * cell whose nodes run the other way round is turned. */
int ss_mesh_split_cell(ss_mesh_kind kind, const double (*position)[3], const int32_t *node,
                       int32_t out[SS_CELL_PIECES][4]);
