/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What softsim-import writes to stdout: this header, node_count times x y z (double, in the
 * file's unit), triangle_count times three node numbers from 0 (int32), in the machine's own byte
 * order, and nothing else. On failure: nothing there, one line on stderr, exit status 2.
 */
#include <stdint.h>

#define SS_IMPORT_MAGIC "softsim1"

typedef struct ss_import_header {
    char magic[8];
    int64_t node_count;
    int64_t triangle_count;
} ss_import_header;

/* Limits that softsim-import sets itself: bytes of address space, seconds of CPU time. */
enum { SS_IMPORT_MAX_BYTES = 1 << 30, SS_IMPORT_MAX_CPU_S = 5 };
