/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Whether a PLY file (Turk 1994) holds what its header promises. assimp fills what is missing with
 * faces that are there already, or reads beyond the end. A text that ends within its last number
 * passes: the number's first digits are one too.
 */

/* NULL when it does, or is no PLY that can be told; else what is missing. In a process that ends
 * soon. */
const char *ply_check(const char *path);
