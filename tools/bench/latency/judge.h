/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How a session felt, from a client's log: reads the CSV that softsim-bridge --csv writes, or any
 * with the columns x,y,z,fx,fy,fz and time_s or tick (and flags, model_age_us where they are
 * known), and prints every figure of session_metrics.h with its verdict. Thread: main.
 */
#include "bench/latency/session_metrics.h"
#include "softsim/types.h"

typedef struct ss_judge_log {
    ss_felt_row *row;
    int64_t count;
    bool has_age;
} ss_judge_log;

/* `rate_hz`: ticks a second, of a log that has only `tick`. */
softsim_status ss_judge_load(const char *path, double rate_hz, ss_judge_log *out_log,
                             softsim_error *error);
void ss_judge_free(ss_judge_log *log);
/* Prints to stdout; an exit status: 1 when any verdict is bad, 2 when the log cannot be judged. */
int ss_judge_run(const char *program, const char *path, double rate_hz, int32_t contacts);
