/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What every program does at its start and at its end.
 *
 * A program that is started with a closed descriptor 0, 1 or 2 would get that number for the next
 * file or socket that it opens, and print into it: all three are opened on /dev/null first, for
 * reading alone, so that printing to a closed stdout is a failure.
 * Writing beyond `ulimit -f` is an error like a full disk, not a signal that ends the program.
 *
 * Capabilities: a daemon reads scenes and meshes of others and takes packets from a network, so it
 * keeps no right of root's that it does not use. Scheduling and locked memory are allowed by two
 * resource limits where those can be raised; then nothing is kept. Where they cannot
 * (no CAP_SYS_RESOURCE, as in most containers), CAP_SYS_NICE and CAP_IPC_LOCK are kept: after
 * mlockall(MCL_FUTURE) every later allocation needs the latter. Dropping both once the threads run
 * was rejected for that reason. Thread: main, before any other thread.
 */
#include <signal.h>
#include <stdbool.h>

/* The first call of every main. */
void ss_program_begin(void);

/* The last: `status`, or 1 in place of 0 when what was printed to stdout did not get there, which
 * is said on stderr. */
int ss_program_finish(const char *program, int status);

/* Has stderr room: a file always, a pipe for a page of text, a terminal for some of it? Not where
 * nobody reads, which would hold up the writer without end. Thread: any. */
bool ss_program_can_tell(void);

/* The signals that ask a program to end: SIGINT, SIGTERM, and SIGHUP unless it is ignored, as
 * nohup has it. */
void ss_program_stop_signals(sigset_t *out_signals);

/* Set-up takes, zeroes and frees much, and page faults of 4 KB were a third of it. Between the two
 * what is freed stays for what is asked for next, and the first 64 MB of the heap have large pages
 * where the system gives them, as blocks of 2 MB and more have (memory.c). From the end on no pages
 * are joined any more. Thread: main, the only one that allocates. */
void ss_program_begin_setup(void);
void ss_program_end_setup(void);

/* Drops the capabilities that a daemon does not need; once before the scene is read
 * (`reads_files`: files of other users can still be read), once after. */
void ss_program_drop_capabilities(bool reads_files);
