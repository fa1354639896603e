/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: faces of more than four corners.
 */
#include <stdint.h>

enum { SS_POLYGON_CORNERS = 1024 }; /* of a face at most; cutting it is of second order in them */

/* `count` - 2 triangles, wound as the face is; 3 to SS_POLYGON_CORNERS corners. */
void ss_mesh_cut_polygon(const double (*position)[3], const int32_t *node, int count,
                         int32_t (*out)[3]);
