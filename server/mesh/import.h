/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What softsim-import writes to stdout: this header, node_count times x y z (double, in the
 * file's unit), then the faces as node numbers from 0 (int32), three for each of triangle_count or
 * four for each of quad_count, in the machine's own byte order, and nothing else. Quads when all
 * the file's faces are quads, else triangles, of which cut_face_count faces of more corners were
 * made. On failure: nothing there, one line on stderr ("softsim-import: FILE: what is wrong", with
 * the line number behind FILE where there is one), exit status 2.
 */
#include <stdint.h>

#define SS_IMPORT_MAGIC "softsim3"
#define SS_IMPORT_NAME  "softsim-import: "

typedef struct ss_import_header {
    char magic[8];
    int64_t node_count;
    int64_t triangle_count, quad_count; /* one of them 0 */
    int64_t cut_face_count;             /* 0 beside quads */
    /* Vertices of an OBJ file that lie on another and were joined with it, and that no face has; 0
     * of other formats, which repeat their vertices. */
    int64_t joined_count, unused_count;
} ss_import_header;

/* Limits that softsim-import sets itself: bytes of address space, seconds of CPU time. */
enum { SS_IMPORT_MAX_BYTES = 1 << 30, SS_IMPORT_MAX_CPU_S = 5 };
