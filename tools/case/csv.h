/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Reads columns of numbers, by name, from a CSV with a head line. Lines are bounded, every fault
 * has its line. Thread: one at a time.
 */
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

enum { SS_CSV_MAX_COLUMNS = 16 };

typedef struct ss_csv {
    FILE *file;
    const char *path;
    int64_t line;
    int32_t count;
    int32_t place[SS_CSV_MAX_COLUMNS]; /* of each wanted column in the file; -1: not there */
} ss_csv;

/* Opens `path` for the columns `name`, of which the first `required` must be there. */
softsim_status ss_csv_open(ss_csv *csv, const char *path, const char *const *name, int32_t count,
                           int32_t required, softsim_error *error);
/* Does nothing when not open. */
void ss_csv_close(ss_csv *csv);
/* 1: a row, NaN where a column is not there; 0: the end; -1: a fault, added to `error`. */
int ss_csv_next(ss_csv *csv, double *out_value, softsim_error *error);
