/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Process tests: real programs over real LCM, in a private network namespace of their own with
 * multicast on lo, so that tests run side by side and never reach a real network. Every child is
 * reaped; every wait is for something (a line, a message, an exit) and ends when that can no longer
 * come. How long it takes is the machine's affair: a limit stands against hanging alone.
 */
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

/* s, against hanging alone: no claim rests on it, whatever a busy machine does meanwhile. */
#define HANG_S 900.0

typedef struct process {
    pid_t pid;
    int out_fd, err_fd; /* its stdout and stderr */
    char out[65536], err[65536];
    int out_size, err_size;
    int status; /* exit code, or 128 + signal, once finished */
    bool is_running;
} process;

/* Enters a private network namespace; false where the system forbids it, which is told. Call once,
 * before any thread. */
bool process_isolate(void);
/* run_all_tests in there; else the status that ctest takes for skipped. */
#define process_run_tests(setup, teardown) (process_isolate() ? run_all_tests(setup, teardown) : 77)

/* Starts BIN_DIR/argv[0] (argv ends with NULL). `environment`: NULL or extra NAME=VALUE,
 * NULL-ended. */
void process_start(process *p, const char *const *argv, const char *const *environment);
/* Reads its output until `text` appears on stdout or stderr; false when it ends. */
bool process_wait_for(process *p, const char *text);
/* Waits for the exit; one that hangs is killed and its status is -1. Returns the status. */
int process_finish(process *p);
/* Has it ended by itself, or never been started? It is reaped by process_finish. */
bool process_has_ended(const process *p);
void process_signal(process *p, int signal);
/* SIGKILL, where it still runs, and its end. */
void process_kill(process *p);
/* Monotonic clock. */
double process_now_s(void);
/* Runs to the end: status; output in p. */
int process_run(process *p, const char *const *argv);
