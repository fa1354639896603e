/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Lines of --explain and of reports in words, one at a time. Thread: set-up only. */

/* A line with its end. */
enum { SS_LINE_SIZE = 1024 };

/* Where they go: what a model's explain is called with. */
typedef struct ss_printer {
    void (*line)(void *sink, const char *text);
    void *sink;
} ss_printer;

/* One line of SS_LINE_SIZE; what is beyond is cut off. */
void __attribute__((format(printf, 2, 3))) ss_say(const ss_printer *out, const char *format, ...);
