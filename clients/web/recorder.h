/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Recordings: LCM logs of all that is heard, written by a thread of their own, since a disk may
 * take seconds to flush and poses are due every few milliseconds.
 *
 *   hub thread -> ring of bytes -> recorder's thread -> files
 *
 * The ring is bounded: what finds no room in it while the disk is slow is left out and counted. One
 * recording and all of a run together are bounded too; who asks for more is refused, and nothing
 * that was recorded is removed to make room. What could not be finished stays where the fault says
 * that it is, since nobody could fetch it.
 * Rejected: a queue under a lock (the hub's thread would wait for whoever holds it), an unbounded
 * queue (a disk that stands still fills the memory).
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

typedef struct ss_recorder ss_recorder;

typedef struct ss_recorder_config {
    const char *folder;              /* must exist, and outlive the recorder */
    bool is_temporary;               /* finished recordings are removed at the end */
    int64_t most_bytes, most_in_all; /* of one recording, of all together */
    int32_t most_files;
    uint32_t ring_bytes; /* a power of two */
} ss_recorder_config;

/* Thread: main. */
softsim_status ss_recorder_open(const ss_recorder_config *config, ss_recorder **out_recorder,
                                softsim_error *error);
/* Ends a recording, waits until it is on the disk, frees; accepts NULL; nulls. Adds to `error` each
 * recording of the run that could not be finished, with what is left of it. Thread: main, after
 * the last ss_recorder_take. */
void ss_recorder_close(ss_recorder **recorder, softsim_error *error);

/* Starts or ends a recording, soon. Thread: any. */
void ss_recorder_want(ss_recorder *recorder, bool is_wanted);
/* Adds a message to the recording, where one is under way. Never waits, locks or allocates.
 * Thread: one. */
void ss_recorder_take(ss_recorder *recorder, int64_t utime_us, const char *channel,
                      const void *data, int32_t size);
/* Another server answers than before, or beside it: a recording under way says so at its end.
 * Thread: that of ss_recorder_take. */
void ss_recorder_mark_servers(ss_recorder *recorder);
/* From 1; grows whenever ss_recorder_tell has something new. Thread: any; never waits. */
uint64_t ss_recorder_version(const ss_recorder *recorder);
/* JSON: is a recording under way, what went wrong, the finished files, how many messages of the
 * last recording were lost, whether the files go at the end. Thread: any. */
void ss_recorder_tell(ss_recorder *recorder, FILE *out);
/* The path of a finished recording of that name, which must be one of this run; NULL for every
 * other name; valid until the end. Thread: any. */
const char *ss_recorder_path(ss_recorder *recorder, const char *name);
