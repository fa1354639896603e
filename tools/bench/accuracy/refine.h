/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The same body on a finer mesh: every edge gets a node in its middle and every tetrahedron becomes
 * eight (four at its corners; the octahedron between them is cut along the shortest of its three
 * diagonals, which keeps the shapes from getting worse, Bey 1995). Nodes of the coarse mesh keep
 * their numbers and come first. A node in the middle of an edge belongs to a set when both ends do,
 * with the mean of their values. Surfaces stay the coarse mesh's facets: the body is the same.
 * Thread: any.
 */
#include "case/case.h"

/* The body without a reference; weights are the lumped volumes. ss_case_body_fini afterwards. */
softsim_status ss_refine(const ss_case_body *coarse, ss_case_body *out, softsim_error *error);
/* A quarter of the volumes of the tetrahedra around each node, m^3. */
void ss_refine_volumes(const ss_mesh *mesh, double *out_volume);
