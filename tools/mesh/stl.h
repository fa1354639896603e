/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Is an STL file whole? assimp says of one that is cut off that its kind cannot be told, or reads
 * what is there as a body with holes. A binary one says at its start how many triangles it has; a
 * text one ends each triangle with `endfacet` and a body with `endsolid`. And would assimp read all
 * of a text?
 */

/* NULL when it is and would, or is no STL at all, else what is wrong, ":LINE: ..." of a text. */
const char *stl_check(const char *path);
