/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A report: a folder with CSVs, gnuplot scripts, SVGs and one static HTML page that holds the
 * pictures in itself. All text is escaped; files appear complete or not at all. Without gnuplot
 * the page says so in the picture's place, stderr says it before the work and after it, and
 * everything else is as ever.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "bench/core/yardstick.h"
#include "output.h"
#include "softsim/types.h"

enum { SS_PAGE_MAX_CELLS = 18 };

typedef struct ss_page {
    const char *folder;
    ss_output output;
    int32_t missing_pictures; /* for want of gnuplot */
} ss_page;

/* What every report does first: a stop is caught from here on, `folder` is made, and a scratch
 * folder where `scratch` is given (SS_SCRATCH_PATH). */
softsim_status ss_report_begin(const char *folder, char *scratch, softsim_error *error);

/* Makes `folder` and its parents where they are missing. Each report begins with it, so the first
 * call says on stderr when there is no gnuplot to draw with. */
softsim_status ss_report_make_folder(const char *folder, softsim_error *error);

/* Opens `folder`/`name`.html. */
softsim_status ss_page_open(ss_page *page, const char *folder, const char *name, const char *title,
                            softsim_error *error);
void ss_page_heading(ss_page *page, const char *text);
/* A paragraph, printf form, at most 2000 characters. */
void ss_page_text(ss_page *page, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Lines set as they are. */
void ss_page_code(ss_page *page, const char *text);
/* A link to `file` in the page's folder. */
void ss_page_link(ss_page *page, const char *file);
/* The first row of a table is its head. Rows have `count` <= SS_PAGE_MAX_CELLS cells; what looks
 * like a number is set flush right. */
void ss_page_table_begin(ss_page *page, int32_t count, const char *const *cell);
void ss_page_table_row(ss_page *page, int32_t count, const char *const *cell);
void ss_page_table_end(ss_page *page);
void ss_page_yardstick(ss_page *page, const ss_yardstick *yardstick);
/* A row of a table in the making, printf form a cell. */
typedef struct ss_row {
    int32_t count;
    char text[SS_PAGE_MAX_CELLS][512];
    const char *cell[SS_PAGE_MAX_CELLS];
} ss_row;
/* Adds a cell; beyond the last one does nothing. */
void ss_row_add(ss_row *row, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Adds a number with four digits, empty for NaN. */
void ss_row_add_number(ss_row *row, double value);

/* Opens `folder`/`name`.gp with the terminal set to `folder`/`name`.svg; the caller writes the
 * rest of the gnuplot script, run in the folder. */
softsim_status ss_plot_open(ss_output *script, const char *folder, const char *name,
                            softsim_error *error);
/* The legend below the axes and their titles, which gnuplot's own place for it overlaps. */
void ss_plot_key_below(FILE *script, int32_t rows);
/* The same of another size than 800 x 480. */
softsim_status ss_plot_open_sized(ss_output *script, const char *folder, const char *name,
                                  int32_t width, int32_t height, softsim_error *error);
/* The same with a picture of `width` x `height` dots, `name`.png: for thousands of faces, where SVG
 * would be ten times as large. */
softsim_status ss_plot_open_dots(ss_output *script, const char *folder, const char *name,
                                 int32_t width, int32_t height, softsim_error *error);
/* Commits the script, runs it, puts the picture into the page. A missing gnuplot is no error. */
softsim_status ss_page_plot(ss_page *page, ss_output *script, const char *name, const char *caption,
                            softsim_error *error);

/* Says on stderr how many pictures are missing for want of gnuplot. */
softsim_status ss_page_close(ss_page *page, softsim_error *error);
/* Removes what there is of the page; does nothing when not open. */
void ss_page_abandon(ss_page *page);

/* Opens `folder`/`name`.csv with a head line, given without its end. */
softsim_status ss_report_csv_open(ss_output *csv, const char *folder, const char *name,
                                  const char *head, softsim_error *error);
/* All of `folder`/`name`.csv: the head line, and the rows 0 to count - 1 that put_row writes, each
 * with its end. */
softsim_status ss_report_csv_write(const char *folder, const char *name, const char *head,
                                   int32_t count,
                                   void (*put_row)(FILE *file, const void *context, int32_t row),
                                   const void *context, softsim_error *error);
/* One field of a CSV: quoted where it holds a comma, a quote or a line end. */
void ss_csv_text(FILE *file, const char *text);
