/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * CSV. Lines and cells: blanks around a cell do not count, nor lines that are blank or begin with a
 * `#`; a cell may stand in quotation marks, "" within them is one. And a reader of columns of
 * numbers, by the names in a head line, one row at a time, for files too long to be held. Lines are
 * bounded, every fault names file, line and column. Thread: set-up only, one at a time a reader.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

/* The byte order mark that spreadsheets write. */
#define SS_CSV_MARK "\xef\xbb\xbf"

/* Without the blanks and line ends around it; NULL: nothing but them, or a comment. */
char *ss_csv_trim(char *line);
/* Cuts a line into cells, in place; the first `room` of them go to `cell`. How many there are. */
int32_t ss_csv_split(char *line, char **cell, int32_t room);
/* The number of a cell, and nothing but it; NaN and infinities are numbers. */
bool ss_csv_number(const char *cell, double *out);

enum { SS_CSV_MAX_WANTED = 16, SS_CSV_MAX_COLUMNS = 64, SS_CSV_LINE_SIZE = 8192 };

typedef struct ss_csv {
    FILE *file;
    const char *path;
    int64_t line, head_line;
    bool is_strict; /* set by the caller: every row is finite numbers, as many as the head has */
    /* Set by the caller, of a writer that ends every row: a last line without its end is half a row
     * of one that was killed in a write. It is left out, and cut_line is its number, else 0. */
    bool is_recording;
    int64_t cut_line;
    bool is_ended; /* has the line that was read last its end? */
    int32_t column_count, wanted_count;
    int32_t place[SS_CSV_MAX_WANTED]; /* of each wanted column in the file; -1: not there */
    char head[SS_CSV_LINE_SIZE], text[SS_CSV_LINE_SIZE];
} ss_csv;

/* Opens `path` for the columns `name`, of which the first `required` must be there; its head line
 * stays in `head`. */
softsim_status ss_csv_open(ss_csv *csv, const char *path, const char *const *name, int32_t count,
                           int32_t required, softsim_error *error);
/* 1: a row, NaN where a column is not there; 0: the end; -1: a fault, added to `error`, after which
 * the next row may be read. */
int ss_csv_next(ss_csv *csv, double *out_value, softsim_error *error);
/* Does nothing when not open. */
void ss_csv_close(ss_csv *csv);
