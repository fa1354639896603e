/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Temporary folders for the scenes and meshes of a run, called NAME-XXXXXX. They are made in
 * $TMPDIR where that is an absolute path and leaves room for the name in SS_SCRATCH_PATH, else in
 * /tmp. Rejected: a path of any length, which would be memory to free in every run that fails.
 * Thread: any.
 */
#include "softsim/types.h"

enum { SS_SCRATCH_PATH = 128 };

/* `name`: whose they are, at most 64 characters. On failure `out` is "". */
softsim_status ss_scratch_make(const char *name, char out[SS_SCRATCH_PATH], softsim_error *error);
/* Removes the folder with its files and, one level down, the folders of runs that were killed; a
 * link goes, what it leads to stays. Nothing for "". */
void ss_scratch_remove(const char *folder);
/* Removes all of that name, whoever made them. */
void ss_scratch_remove_all(const char *name);
