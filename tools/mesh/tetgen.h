/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The program tetgen (Debian's package of that name; AGPL, so it is run and never linked): a
 * closed surface in, tetrahedra out, through files in a folder of their own that is removed again.
 */
#include "mesh/mesh.h"

/* `surface` is closed, manifold and wound outwards; cavities stay hollow. Its nodes keep their
 * numbers and places, inner ones follow. `volume`: of the largest tetrahedron allowed, in the
 * surface's own unit. */
softsim_status tetgen_fill(const ss_mesh *surface, double volume, double timeout_s, ss_mesh **out,
                           softsim_error *error);
