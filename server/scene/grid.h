/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * `object.grid`: a structured surface of quads, made here or placed by a table of nodes. Used
 * inside scene/ only. Thread: set-up only.
 *
 *   grid: {cylinder: {rows: 15, columns: 24, radius_m: 1, length_m: 4}}      about z, open ends
 *   grid: {plane: {rows: 21, columns: 21, width_m: 0.1, height_m: 0.1}}      in z = 0, facing +z
 *   grid: {file: nodes.csv, rows: 15, columns: 24, closed: columns}          x,y,z in object.units
 *
 * Rows and columns count nodes; node r columns + c, element r m + c with m columns of quads; u runs
 * from row to row (of the cylinder along its axis), w from column to column. `closed: columns`
 * makes rings of the rows: a last quad runs from a row's last column to its first; `closed: rows`
 * joins the last row to the first. Outside is where, looking from, columns run to the
 * right and rows up. The transform and regions act as on a mesh file.
 */
#include "scene/region.h"

/* From a checked node; `metres`: of object.units, 0 when that is not given. Faults go to the
 * space's report or to `mesh_error`; the space needs no mesh. */
bool ss_scene_make_grid(ss_scene_space *space, ss_scene_node *grid, double metres,
                        ss_mesh **out_mesh, softsim_error *mesh_error);
