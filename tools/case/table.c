/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/table.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "rt/csv.h"
#include "rt/each.h"
#include "rt/files.h"

static const size_t MAX_BYTES = (size_t)1 << 30;
static const size_t FIRST_BYTES = (size_t)1 << 16;

static void no_memory(softsim_error *error, const char *path)
{
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
}

/* zlib reads what is not gzipped as it is. */
char *ss_table_read_file(const char *path, size_t *out_size, softsim_error *error)
{
    const char *why = NULL;
    const int descriptor = ss_files_open(path, NULL, &why);
    if (descriptor < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, why);
        return NULL;
    }
    gzFile file = gzdopen(descriptor, "rb");
    if (file == NULL) {
        close(descriptor);
        no_memory(error, path);
        return NULL;
    }
    size_t size = 0, room = FIRST_BYTES;
    char *text = malloc(room);
    int got = 0;
    while (text != NULL && (got = gzread(file, text + size, (unsigned)(room - size - 1))) > 0) {
        size += (size_t)got;
        if (size + 1 == room) {
            char *more = room < MAX_BYTES ? realloc(text, 2 * room) : NULL;
            if (more == NULL) {
                free(text);
            }
            text = more;
            room *= 2;
        }
    }
    int fault = Z_OK;
    why = gzerror(file, &fault);
    if (text == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: more than fits", path);
    } else if (got < 0 || (fault != Z_OK && fault != Z_STREAM_END)) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be read: %s", path,
                          fault == Z_ERRNO ? strerror(errno) : why);
        free(text);
        text = NULL;
    } else if (memchr(text, '\0', size) != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: is not a text", path);
        free(text);
        text = NULL;
    } else {
        text[size] = '\0';
        *out_size = size;
    }
    gzclose(file);
    return text;
}

/* ---- tables ---- */

/* The line at *cursor without its end; *cursor goes behind it, or becomes NULL. */
static char *cut_text(char **cursor)
{
    char *line = *cursor;
    char *end = line + strcspn(line, "\n");
    *cursor = *end == '\n' && end[1] != '\0' ? end + 1 : NULL;
    *end = '\0';
    if (end > line && end[-1] == '\r') {
        end[-1] = '\0';
    }
    return line;
}

static int32_t count_of(const char *text, char c)
{
    int32_t count = 0;
    for (; *text != '\0'; ++text) {
        count += *text == c;
    }
    return count;
}

static softsim_status cut_rows(ss_table *table, char *cursor, softsim_error *error)
{
    const size_t columns = (size_t)table->column_count;
    const int32_t lines = cursor != NULL ? count_of(cursor, '\n') + 1 : 0;
    table->cell = calloc((size_t)lines * columns + 1, sizeof *table->cell);
    table->line = calloc((size_t)lines + 1, sizeof *table->line);
    table->cell_count = calloc((size_t)lines + 1, sizeof *table->cell_count);
    if (table->cell == NULL || table->line == NULL || table->cell_count == NULL) {
        no_memory(error, table->path);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t number = 2; cursor != NULL; ++number) {
        char *line = cut_text(&cursor);
        if (*line == '\0') {
            continue;
        }
        char **row = &table->cell[(size_t)table->row_count * columns];
        char *const empty = line + strlen(line);
        const int32_t count = ss_csv_split(line, row, table->column_count);
        if (count > table->column_count) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%d: %d cells, the head line has %d",
                              table->path, number, count, table->column_count);
            return SOFTSIM_ERROR_FORMAT;
        }
        for (int32_t k = count; k < table->column_count; ++k) {
            row[k] = empty;
        }
        table->cell_count[table->row_count] = count;
        table->line[table->row_count++] = number;
    }
    return SOFTSIM_OK;
}

softsim_status ss_table_parse(const char *path, char *text, ss_table *out, softsim_error *error)
{
    *out = (ss_table){.path = strdup(path), .text = text};
    if (out->path == NULL || text == NULL) {
        no_memory(error, path);
        return SOFTSIM_ERROR_MEMORY;
    }
    char *cursor = text;
    char *head = cut_text(&cursor);
    const int32_t most = count_of(head, ',') + 1;
    out->head = calloc((size_t)most, sizeof *out->head);
    if (out->head == NULL) {
        no_memory(error, path);
        return SOFTSIM_ERROR_MEMORY;
    }
    out->column_count = ss_csv_split(head, out->head, most);
    return cut_rows(out, cursor, error);
}

softsim_status ss_table_load(const char *path, ss_table *out, softsim_error *error)
{
    size_t size = 0;
    *out = (ss_table){.path = NULL};
    char *text = ss_table_read_file(path, &size, error);
    return text != NULL ? ss_table_parse(path, text, out, error) : SOFTSIM_ERROR_FILE;
}

void ss_table_fini(ss_table *table)
{
    SS_EACH(free, table->path, table->text, table->cell, table->line, table->cell_count,
            table->head);
    *table = (ss_table){.path = NULL};
}

int32_t ss_table_find(const ss_table *table, const char *name, softsim_error *error)
{
    for (int32_t i = 0; i < table->column_count; ++i) {
        if (strcmp(table->head[i], name) == 0) {
            return i;
        }
    }
    if (error != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:1: no column '%s' in the head line",
                          table->path, name);
    }
    return -1;
}

const char *ss_table_cell(const ss_table *table, int32_t row, int32_t column)
{
    return table->cell[(size_t)row * (size_t)table->column_count + (size_t)column];
}

double ss_table_number(const ss_table *table, int32_t row, int32_t column, softsim_error *error)
{
    const char *text = ss_table_cell(table, row, column);
    double value = 0.0;
    if (!ss_csv_number(text, &value) || !isfinite(value)) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%d: column '%s': '%.40s' is no number; give a finite one",
                          table->path, table->line[row], table->head[column], text);
        return (double)NAN;
    }
    return value;
}
