/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What stderr tells while the server runs: told by the main thread, so that a reader who stalls
 * holds up no force; and only while a pipe has room for it, so that the end is not held up either:
 * the main thread waits for the signals. Thread: main.
 */
#include "net/net.h"

/* What the newest status says. */
typedef struct ss_judgement {
    softsim_verdict verdict;
    char reason[160];
    char other[256]; /* scene of another server on this prefix; empty: none */
} ss_judgement;

typedef struct ss_stderr_report {
    /* parameters */
    const char *prefix;
    const ss_gate *gate;
    /* state */
    int64_t next_log_ns, logged_refusals;
    int64_t next_verdict_log_ns;
    softsim_verdict logged_verdict; /* good again once it is better than degraded */
    bool is_other_server_logged;
} ss_stderr_report;

/* Warns of what is new, as soon as there is room; `judgement` is NULL before the first status. */
void ss_stderr_report_update(ss_stderr_report *report, const ss_judgement *judgement,
                             int64_t now_ns);
