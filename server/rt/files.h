/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The files of a command line, before the first is opened for writing: no output may be an input,
 * which would be lost, nor another output, which would be written over. Files that are there are
 * compared by device and inode, so that neither links nor other spellings of a path hide one;
 * those that are not, by their folder and name. Devices, pipes and folders are left alone: they
 * are not replaced. Thread: set-up only.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_named_file {
    const char *name; /* what the user knows it by: "--csv", "the scene" */
    const char *path; /* NULL: not given */
} ss_named_file;

/* Do both names stand for one file, be it there already or not? */
bool ss_files_are_one(const char *a, const char *b);

/* Adds a fault for the first output that is an input or another output; true without one. */
bool ss_files_check(const ss_named_file *input, int32_t input_count, const ss_named_file *output,
                    int32_t output_count, softsim_error *error);
