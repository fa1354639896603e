/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The reports of softsim-bench: each is one folder and one row of the table that CMakeLists.txt
 * makes of the folders. Thread: main.
 */
typedef struct ss_report_class {
    const char *name, *about;
    /* Returns the program's exit status; argv[0] is "softsim-bench NAME". */
    int (*run)(int argc, char **argv);
} ss_report_class;

#define SS_REPORT_ROW(object) extern const ss_report_class object;
#include "report_rows.h"
#undef SS_REPORT_ROW
