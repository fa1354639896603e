/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/csv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"

static const char blanks[] = " \t\r\n";

/* ---- lines and cells ---- */

static char *cut_blanks(char *text)
{
    text += strspn(text, blanks);
    size_t length = strlen(text);
    while (length > 0 && strchr(blanks, text[length - 1]) != NULL) {
        --length;
    }
    text[length] = '\0';
    return text;
}

char *ss_csv_trim(char *line)
{
    char *text = cut_blanks(line);
    return *text != '\0' && *text != '#' ? text : NULL;
}

/* The cell at *cursor, ended by a NUL; *cursor goes to the next, or becomes NULL at the line's
 * end. */
static char *cut_cell(char **cursor)
{
    char *start = *cursor + strspn(*cursor, blanks), *end = start;
    const bool is_quoted = *start == '"';
    if (is_quoted) {
        char *from = start + 1;
        for (; *from != '\0' && (*from != '"' || from[1] == '"'); ++from) {
            from += *from == '"';
            *end++ = *from;
        }
        from += strcspn(from, ",");
        *cursor = *from == ',' ? from + 1 : NULL;
        *end = '\0';
        return start;
    }
    end += strcspn(start, ",");
    *cursor = *end == ',' ? end + 1 : NULL;
    *end = '\0';
    return cut_blanks(start);
}

int32_t ss_csv_split(char *line, char **cell, int32_t room)
{
    int32_t count = 0;
    for (char *cursor = line; cursor != NULL; ++count) {
        char *text = cut_cell(&cursor);
        if (count < room) {
            cell[count] = text;
        }
    }
    return count;
}

bool ss_csv_number(const char *cell, double *out)
{
    char *end = NULL;
    *out = strtod(cell, &end);
    return end != cell && *end == '\0';
}

/* ---- columns of numbers ---- */

/* As fgets, with the length: a NUL among the bytes hides no more than itself. */
static size_t take_line(FILE *file, char text[SS_CSV_LINE_SIZE])
{
    size_t length = 0;
    int byte = 0;
    while (length < SS_CSV_LINE_SIZE - 1 && byte != '\n' && (byte = getc(file)) != EOF) {
        text[length++] = (char)byte;
    }
    text[length] = '\0';
    return length;
}

/* 1: a line; 0: the end of the file; -1: no line of text, or unreadable, and the end then. */
static int read_line(ss_csv *csv, char **out_text, softsim_error *error)
{
    *out_text = NULL;
    while (csv->file != NULL && *out_text == NULL) {
        const size_t length = take_line(csv->file, csv->text);
        if (length == 0) {
            const bool is_end = ferror(csv->file) == 0;
            if (!is_end) {
                softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be read", csv->path);
            }
            ss_csv_close(csv);
            return is_end ? 0 : -1;
        }
        ++csv->line;
        if (length == SS_CSV_LINE_SIZE - 1) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%lld: longer than %d characters",
                              csv->path, (long long)csv->line, SS_CSV_LINE_SIZE - 2);
            ss_csv_close(csv);
            return -1;
        }
        if (strlen(csv->text) != length) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                              "%s:%lld: a NUL at character %d: not a text; save it as UTF-8",
                              csv->path, (long long)csv->line, (int)strlen(csv->text) + 1);
            ss_csv_close(csv);
            return -1;
        }
        const size_t mark = strlen(SS_CSV_MARK);
        const bool is_marked = csv->line == 1 && strncmp(csv->text, SS_CSV_MARK, mark) == 0;
        csv->is_ended = csv->text[length - 1] == '\n';
        *out_text = ss_csv_trim(csv->text + (is_marked ? mark : 0));
    }
    return *out_text != NULL ? 1 : 0;
}

/* The place of each column in the head line. */
static softsim_status find_columns(ss_csv *csv, const char *const *name, int32_t required,
                                   softsim_error *error)
{
    char *cell[SS_CSV_MAX_COLUMNS];
    strcpy(csv->text, csv->head);
    csv->column_count = ss_csv_split(csv->text, cell, SS_CSV_MAX_COLUMNS);
    if (csv->column_count > SS_CSV_MAX_COLUMNS) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%lld: more than %d columns", csv->path,
                          (long long)csv->head_line, SS_CSV_MAX_COLUMNS);
        return SOFTSIM_ERROR_FORMAT;
    }
    softsim_status status = SOFTSIM_OK;
    for (int32_t i = 0; i < csv->wanted_count; ++i) {
        csv->place[i] = -1;
        for (int32_t k = 0; k < csv->column_count; ++k) {
            csv->place[i] = strcmp(cell[k], name[i]) == 0 ? k : csv->place[i];
        }
        if (i < required && csv->place[i] < 0) {
            status = SOFTSIM_ERROR_FORMAT;
            softsim_error_add(error, status, "%s:%lld: no column '%s' in the head line", csv->path,
                              (long long)csv->head_line, name[i]);
        }
    }
    return status;
}

softsim_status ss_csv_open(ss_csv *csv, const char *path, const char *const *name, int32_t count,
                           int32_t required, softsim_error *error)
{
    char *text = NULL;
    const char *why = NULL;
    *csv = (ss_csv){.path = path, .wanted_count = count};
    csv->file = ss_files_open_stream(path, NULL, &why);
    if (csv->file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, why);
        return SOFTSIM_ERROR_FILE;
    }
    if (read_line(csv, &text, error) < 0) {
        return SOFTSIM_ERROR_FORMAT;
    }
    csv->head_line = csv->line > 0 ? csv->line : 1;
    strcpy(csv->head, text != NULL ? text : "");
    const softsim_status status = find_columns(csv, name, required, error);
    if (status != SOFTSIM_OK) {
        ss_csv_close(csv);
    }
    return status;
}

/* The cells of a row that count; false after a fault. */
static bool take_cells(ss_csv *csv, char **cell, int32_t count, double *number,
                       softsim_error *error)
{
    for (int32_t k = 0; k < csv->column_count; ++k) {
        const bool is_number = k < count && ss_csv_number(cell[k], &number[k]);
        bool is_wanted = csv->is_strict && k < count;
        for (int32_t i = 0; i < csv->wanted_count; ++i) {
            is_wanted = is_wanted || csv->place[i] == k;
        }
        if (is_wanted && (!is_number || (csv->is_strict && !isfinite(number[k])))) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                              "%s:%lld: column %d: '%.40s' is not a %s", csv->path,
                              (long long)csv->line, k + 1, k < count ? cell[k] : "",
                              csv->is_strict ? "finite number" : "number");
            return false;
        }
    }
    return true;
}

int ss_csv_next(ss_csv *csv, double *out_value, softsim_error *error)
{
    char *text = NULL, *cell[SS_CSV_MAX_COLUMNS];
    double number[SS_CSV_MAX_COLUMNS];
    const int got = read_line(csv, &text, error);
    if (got <= 0) {
        return got;
    }
    if (csv->is_recording && !csv->is_ended) {
        csv->cut_line = csv->line;
        return 0;
    }
    const int32_t count = ss_csv_split(text, cell, SS_CSV_MAX_COLUMNS);
    if (csv->is_strict && count != csv->column_count) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: %d columns, not the %d of the first line", csv->path,
                          (long long)csv->line, count, csv->column_count);
        return -1;
    }
    if (!take_cells(csv, cell, count, number, error)) {
        return -1;
    }
    for (int32_t i = 0; i < csv->wanted_count; ++i) {
        out_value[i] = csv->place[i] >= 0 ? number[csv->place[i]] : (double)NAN;
    }
    return 1;
}

void ss_csv_close(ss_csv *csv)
{
    if (csv->file != NULL) {
        fclose(csv->file);
    }
    csv->file = NULL;
}
