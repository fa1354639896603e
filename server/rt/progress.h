/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a long piece of work is at, on stderr, with the time it has taken: on a terminal one line
 * that is rewritten, elsewhere a plain line every ten seconds, so that short work says nothing
 * in a script. A thread of its own writes it, because the longest waits are inside one call (a file
 * of gigabytes, one press of a large body) that cannot report; counting its share there was
 * rejected. A reader who stalls holds up nothing: a line without room is left out. A library names
 * what it does by ss_progress_part, which does nothing unless the program has begun, nor once the
 * program has named a stage itself: its own words stand.
 * Thread: set-up only; ended before a loop starts or a process without exec is forked.
 */

/* From here on until ss_progress_end; ends one that has begun already. The first stage is
 * `format`, one line without its end; further stages follow `program`, as in
 * "softsim-mesh: reading heart.msh, 12 s". */
void __attribute__((format(printf, 2, 3)))
ss_progress_begin(const char *program, const char *format, ...);
/* Names what is being done now: the program, and a library for it. */
void __attribute__((format(printf, 1, 2))) ss_progress_stage(const char *format, ...);
void __attribute__((format(printf, 1, 2))) ss_progress_part(const char *format, ...);
/* Wipes the line of a terminal. Does nothing when none has begun. */
void ss_progress_end(void);
