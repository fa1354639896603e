/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Programs that a report starts. Every one is reaped, also on errors, and ends by itself should
 * the bench be killed. Thread: main, since a child's life hangs on the thread that started it.
 */
#include <stdbool.h>
#include <sys/types.h>

#include "softsim/types.h"

typedef struct ss_child_plan {
    const char *name;        /* in messages */
    const char *const *argv; /* NULL-ended; argv[0] with a slash, or searched in PATH */
    const char *folder;      /* to run in; NULL: the present one */
    const char *out_path;    /* stdout; NULL: nowhere, unless has_pipe */
    const char *err_path;    /* stderr; NULL: nowhere */
    bool has_pipe;           /* stdout is read by ss_child_wait_text */
} ss_child_plan;

typedef struct ss_child {
    const char *name;
    pid_t pid;
    bool is_running;
    int status; /* once it has ended: the exit status, or 128 + signal; 127: not found */
    int out_fd; /* -1: none */
} ss_child;

softsim_status ss_child_start(ss_child *child, const ss_child_plan *plan, softsim_error *error);
/* Reads its stdout until `text` has come; false when it ends, after `timeout_s`, or when the bench
 * is stopped. */
bool ss_child_wait_text(ss_child *child, const char *text, double timeout_s);
/* Reaps it if it has ended. */
bool ss_child_is_running(ss_child *child);
/* SIGTERM, then SIGKILL after `grace_s`; reaps. Returns the status; harmless when it has ended. */
int ss_child_stop(ss_child *child, double grace_s);
/* Runs to the end, at most `timeout_s` and not longer than the bench. Returns the status, -1 when
 * it could not be started. */
int ss_child_run(const ss_child_plan *plan, double timeout_s);
/* The folder that this program's executable is in, with no slash at the end. */
bool ss_child_own_folder(char *out, int size);
/* Looks for a folder of the source tree, or of what was installed: hands `take` place[0], then
 * every one of place[] (up to NULL) below each folder above this program, until it returns true. */
void ss_child_look_above(const char *const place[], bool (*take)(void *context, const char *folder),
                         void *context);
