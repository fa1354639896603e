/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Files that are written. What the shell has opened (/dev/stdout) and /dev/null are written to as
 * they are, other pipes and devices refused (rt/files.h); of the rest there are two kinds:
 *
 * A result appears complete or not at all: written beside its place under a temporary name, then
 * synced and renamed.
 *
 * A recording is worth something while it is cut off too. It is written to NAME.part, flushed at
 * least once a second and between rows only, so that after a kill the file ends with a whole row,
 * but for a kill within a write, which the kernel may cut at any page: who reads it leaves half a
 * row out and says so. At its end it is synced and renamed to NAME. One that ends before its time,
 * by a signal too, keeps the name NAME.part, which is said. On a full disk it is cut back to the
 * last whole row that found room, kept under the name NAME.part, and the fault names it. Writing to
 * NAME itself was rejected: a file of that name is then no longer a complete one. A NAME.part that
 * a killed program left is renamed to NAME.1.part (or the next free number), since the same command
 * is often started again before anyone has looked; one that is being written is refused.
 *
 * Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

typedef struct ss_output {
    FILE *file; /* NULL: not open */
    char *path;
    char *temporary; /* NULL: written in place */
    int descriptor;  /* of `file` */
    int reason;      /* errno of the write that failed; 0: none has. Not to be moved while open */
    bool is_reserved;

    /* of a recording */
    bool is_recording;
    bool is_new;         /* takes the place of no other file */
    char *kept;          /* what NAME.part was renamed to; NULL: there was none */
    char *buffer;        /* of `file`; given, because glibc ignores a size without one */
    int64_t whole_bytes; /* up to the end of the last flush */
    int32_t *row_end;    /* of the rows since, from there on */
    int32_t row_count;
    int64_t flushed_ns;
} ss_output;

/* A result. Leaves `output` closed on failure. */
softsim_status ss_output_open(ss_output *output, const char *path, softsim_error *error);
/* Right after the opening of a result that comes of long work: takes room for about `bytes`, so
 * that a full disk is told before the work and not after it; what is not needed is given back at
 * the commit. Nothing for what is written in place. Leaves `output` closed on failure. */
softsim_status ss_output_reserve(ss_output *output, int64_t bytes, softsim_error *error);
/* A recording, the same way. */
softsim_status ss_output_record(ss_output *output, const char *path, softsim_error *error);
/* The same under a name that no user gave: what is there stays, also when it came while this was
 * recorded, which the commit then tells. SOFTSIM_OK and not open: the name, or its NAME.part, is
 * taken. */
softsim_status ss_output_record_new(ss_output *output, const char *path, softsim_error *error);
/* After each row of a recording: flushes when a second has passed or much has gathered. False once
 * a write has failed: nothing more can be recorded. True when not open. */
bool ss_output_pace(ss_output *output);
/* Says on stderr that `part`, which was left, is called `kept` now; nothing when that is NULL.
 * Right after the opening: it is so whatever comes of the program. */
void ss_output_tell_kept(const char *kept, const char *part, const char *program);
/* Says on stderr where the recording is until its end; nothing when not open or in place. */
void ss_output_tell(const ss_output *output, const char *program);
/* Flushes, syncs, renames. On any failure, also of an earlier write, a result is removed and a
 * recording kept and named. Does nothing when not open. */
softsim_status ss_output_commit(ss_output *output, softsim_error *error);
/* A recording that ends before its time: keeps NAME.part and names it as a fault. Does nothing when
 * not open. */
void ss_output_keep(ss_output *output, softsim_error *error);
/* Removes the temporary file. Does nothing when not open. */
void ss_output_abandon(ss_output *output);
