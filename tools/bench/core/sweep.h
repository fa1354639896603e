/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A sweep: a list of independent runs, each of which leaves a short text (rows of a CSV). Runs go
 * side by side on one machine (`jobs`) and over many (under mpirun, with a folder that all of them
 * see); what comes out does not depend on how.
 *
 * Every run is a process of its own, forked from the caller: a crash, a time-out or an error loses
 * that run, which is then a result with its reason, and nothing else. What a run has left is
 * appended at once, with its length and a check sum, to `folder`/`name`.RANK.part; a sweep that was
 * killed goes on from there when the same command is given again, and a torn last record is run
 * again. Parts of another list, or of another build of the program, are refused by name.
 *
 * Many machines: Open MPI sets OMPI_COMM_WORLD_RANK and _SIZE in every process that it starts.
 * Rank r of n does the runs i with i mod n = r, into its own part; rank 0 waits for the others,
 * reads all parts and hands the results back in the order of the list. Nothing
 * is sent, hence nothing of MPI is linked; the rejected alternative, messages, needs the library at
 * build and at run time, and its ranks cannot fork safely.
 * Thread: main, while no other thread of the program runs.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

enum { SS_SWEEP_MAX_TEXT = 1 << 20, SS_SWEEP_MAX_JOBS = 256, SS_SWEEP_NAME_SIZE = 256 };

typedef struct ss_sweep {
    const char *folder; /* there already: ss_report_make_folder */
    const char *name;   /* of the part files: one word, the report's */
    int32_t count;      /* runs */
    int32_t jobs;       /* processes at a time on this machine, 1..SS_SWEEP_MAX_JOBS */
    double timeout_s;   /* of one run; then it is killed */
    const void *context;
    /* What identifies run `index` among all runs of all sweeps: every value that it depends on. */
    void (*label)(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE]);
    /* Does run `index`, in a process of its own: writes at most SS_SWEEP_MAX_TEXT - 1 bytes of text
     * to `out`. Another status than SOFTSIM_OK loses the run with the first line of `error`. */
    softsim_status (*run)(const void *context, int32_t index, FILE *out, softsim_error *error);
} ss_sweep;

typedef struct ss_sweep_run {
    bool is_lost;
    char *text; /* what the run wrote, or why it is lost: one line, "crashed: ..." */
} ss_sweep_run;

typedef struct ss_sweep_result {
    /* False for ranks other than 0: their runs are done, and there is nothing to report. */
    bool is_complete;
    int32_t count;
    ss_sweep_run *run; /* in the order of the list */
    int32_t resumed;   /* of them found done */
    int32_t lost;
} ss_sweep_result;

/* By the rank that has all of a complete sweep: its files, and what is printed. */
typedef softsim_status (*ss_sweep_report)(void *context, const ss_sweep_result *result,
                                          softsim_error *error);
/* Executes, reports, and forgets the parts once the report stands. */
softsim_status ss_sweep_and_report(const ss_sweep *sweep, ss_sweep_report report, void *context,
                                   int32_t *out_lost, softsim_error *error);

/* Does what has not been done yet. On a terminal it shows how far it is and the time left. Fails
 * when it is stopped, when a part cannot be read or written or belongs to another sweep, and when
 * another rank falls silent. ss_sweep_result_fini afterwards, also on failure. */
softsim_status ss_sweep_execute(const ss_sweep *sweep, ss_sweep_result *out_result,
                                softsim_error *error);
/* Removes the parts: once what they hold is written elsewhere. Does nothing unless complete. */
void ss_sweep_forget(const ss_sweep *sweep, const ss_sweep_result *result);
void ss_sweep_result_fini(ss_sweep_result *result);
