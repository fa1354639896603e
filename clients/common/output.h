/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A file that appears complete or not at all: written beside its place under a temporary name,
 * then synced and renamed. A device or pipe (/dev/stdout) is written to as it is. Thread: one at a
 * time.
 */
#include <stdio.h>

#include "softsim/types.h"

typedef struct ss_output {
    FILE *file; /* NULL: not open */
    char *path;
    char *temporary; /* NULL: written in place */
} ss_output;

/* Leaves `output` closed on failure. */
softsim_status ss_output_open(ss_output *output, const char *path, softsim_error *error);
/* Flushes, syncs, renames; on any failure, also of an earlier write, removes the temporary file.
 * Does nothing when not open. */
softsim_status ss_output_commit(ss_output *output, softsim_error *error);
/* Removes the temporary file. Does nothing when not open. */
void ss_output_abandon(ss_output *output);
