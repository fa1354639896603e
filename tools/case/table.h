/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Text files that may be gzipped, and tables in them: a CSV with a head line, whole in memory, its
 * cells as text. No row has more cells than the head, those it
 * lacks are empty; quotes around a cell are taken off. (For
 * long CSVs of plain numbers that need not be kept, csv.h reads row by row.) Thread: any.
 */
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

/* The whole file, unpacked where it is gzipped, with a NUL behind it; to be freed. NULL with a
 * fault: unreadable, damaged, more than 1 GB, a NUL inside. */
char *ss_table_read_file(const char *path, size_t *out_size, softsim_error *error);

typedef struct ss_table {
    char *path, *text;
    char **cell; /* row by row; the head is not among them */
    char **head;
    int32_t *line;       /* of the file, from 1, that each row stands on */
    int32_t *cell_count; /* of each row, as it is written */
    int32_t column_count, row_count;
} ss_table;

/* ss_table_fini afterwards, also on failure. */
softsim_status ss_table_load(const char *path, ss_table *out, softsim_error *error);
/* From `text`, which becomes the table's (NULL: out of memory); `path` is what faults call it. */
softsim_status ss_table_parse(const char *path, char *text, ss_table *out, softsim_error *error);
void ss_table_fini(ss_table *table);
/* Number of the column called `name`; -1 with a fault, or without one where `error` is NULL. */
int32_t ss_table_find(const ss_table *table, const char *name, softsim_error *error);
const char *ss_table_cell(const ss_table *table, int32_t row, int32_t column);
/* A finite number; anything else is a fault, by its line and column, with NaN. */
double ss_table_number(const ss_table *table, int32_t row, int32_t column, softsim_error *error);
