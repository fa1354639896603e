/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: the readers, one for each format. Our own go over a text that has
 * been opened, add their faults to the text's error (with the line, or the byte of a binary file)
 * and make a mesh in SI units. Tests and fuzzers call them with texts in memory.
 */
#include "mesh/mesh.h"
#include "mesh/text.h"

/* Gmsh MSH, ASCII: versions 1, 2.0 to 2.2 and 4.1. */
softsim_status ss_mesh_parse_msh(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);
/* TetGen's .node and .ele files. */
softsim_status ss_mesh_parse_tetgen(ss_text *nodes, ss_text *elements, double metres_per_unit,
                                    ss_mesh **out_mesh);
/* Legacy VTK, ASCII or binary. */
softsim_status ss_mesh_parse_vtk(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);
/* VTK's XML UnstructuredGrid, ASCII. */
softsim_status ss_mesh_parse_vtu(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);
/* OBJ, STL, PLY, GLB and glTF, through the helper program; `program` as for ss_mesh_load. */
softsim_status ss_mesh_import(const char *path, double metres_per_unit, const char *program,
                              ss_mesh **out_mesh, softsim_error *error);
