/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Prepares an OBJ text for assimp so that vertices keep their number and their double precision.
 *
 * assimp reads positions as floats, renumbers vertices and stumbles over a comment behind a
 * vertex. So: positions are read here; each vertex goes to assimp with its number in place of a
 * colour, which comes back with the triangles; comments and materials are left out. Faces, groups
 * and the rest are assimp's business.
 */
#include <stddef.h>
#include <stdint.h>

typedef struct obj_text {
    char *text; /* for assimp */
    size_t size;
    double (*position)[3];
    int64_t count;
} obj_text;

/* NULL when good, else what is wrong, ":LINE: ..." where a line is to blame, or beside_no_memory.
 * In a process that ends soon: nothing is freed. */
const char *obj_prepare(const char *path, obj_text *out);

/* The vertex number behind a colour. */
int64_t obj_number(float red, float green, float blue);
