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
 * those that are not, by their folder and name. Outputs are files too: opening a named pipe would
 * wait for its reader, a device may do something. Written to as they are, and not replaced, are
 * /dev/null and what the shell has opened: /dev/stdout, /dev/fd/N. Thread: set-up only.
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

/* Writes to `descriptor`, which it closes with itself. *out_reason, which outlives it, becomes the
 * errno of the first write that fails: a stream alone remembers only that one has. NULL: out of
 * memory, in errno too. */
FILE *ss_files_write_stream(int descriptor, int *out_reason);

/* The open file that a name stands for; -1: none. Such a file may be a regular one, which a shell
 * has opened: another in its place would be one that nobody reads, and the name itself would go. */
int ss_files_descriptor(const char *path);
/* Is it written to as it is, rather than replaced? */
bool ss_files_is_in_place(const char *path);
/* Why it can be no output, for a message that begins with it; NULL: it can, as far as its kind
 * goes. */
const char *ss_files_why_no_output(const char *path);

/* Behind the name of a recording until it is complete: no input may be that either. */
#define SS_FILES_PART ".part"

typedef struct ss_named_file {
    const char *name; /* what the user knows it by: "--csv", "the scene" */
    const char *path; /* NULL: not given */
} ss_named_file;

/* Do both names stand for one file, be it there already or not? */
bool ss_files_are_one(const char *a, const char *b);

/* Adds a fault for the first output that is an input, another output, a pipe or a device; true
 * without one. A folder is for who opens it to judge: some outputs are folders. */
bool ss_files_check(const ss_named_file *input, int32_t input_count, const ss_named_file *output,
                    int32_t output_count, softsim_error *error);
