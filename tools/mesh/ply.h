/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Prepares a PLY file (Turk 1994) for assimp, and finds whether it holds what its header promises.
 * assimp fills what is missing with faces that are there already, or reads beyond the end; elements
 * other than vertices, faces, strips, edges and materials it takes for these, and empty lines too.
 * Both are left out. A text that ends within its last number passes: the number's first digits are
 * one too.
 */
#include <stddef.h>

/* NULL when it does, else what is missing, ":LINE: ..." where a line is to blame, or
 * beside_no_memory. *out_text: for assimp; NULL: no PLY that can be told, it reads the file itself.
 * In a process that ends soon: nothing is freed. */
const char *ply_prepare(const char *path, char **out_text, size_t *out_size);
