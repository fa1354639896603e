/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The files of a command line. Inputs are regular files: a pipe, which would keep the program
 * waiting for its other end, a device or a folder is refused by one function, and nothing is
 * opened for reading in another way.
 *
 * Before the first is opened for writing: no output may be an input, which would be lost, nor
 * another output, which would be written over. Files that are there are
 * compared by device and inode, so that neither links nor other spellings of a path hide one;
 * those that are not, by their folder and name. Devices, pipes and folders are left alone: they
 * are not replaced. Thread: set-up only.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

/* Opens a regular file for reading; its size where `out_size` is not NULL. -1: not opened, and
 * *out_why says why, for a message that begins with the path. */
int ss_files_open(const char *path, int64_t *out_size, const char **out_why);
/* The same as a stream; NULL: not opened. */
FILE *ss_files_open_stream(const char *path, int64_t *out_size, const char **out_why);
/* Can `count` more files be opened? */
bool ss_files_have_room(int32_t count);
/* What an errno says, and what to do about it where that is known. */
const char *ss_files_reason(int number);

/* Behind the name of a recording until it is complete: no input may be that either. */
#define SS_FILES_PART ".part"

typedef struct ss_named_file {
    const char *name; /* what the user knows it by: "--csv", "the scene" */
    const char *path; /* NULL: not given */
} ss_named_file;

/* Do both names stand for one file, be it there already or not? */
bool ss_files_are_one(const char *a, const char *b);

/* Adds a fault for the first output that is an input or another output; true without one. */
bool ss_files_check(const ss_named_file *input, int32_t input_count, const ss_named_file *output,
                    int32_t output_count, softsim_error *error);
