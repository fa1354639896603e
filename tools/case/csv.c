/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/csv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"

enum { LINE_SIZE = 8192 };

/* 1: a line without its end; 0: the end of the file; -1: too long a line, or unreadable. */
static int read_line(ss_csv *csv, char line[LINE_SIZE], softsim_error *error)
{
    if (fgets(line, LINE_SIZE, csv->file) == NULL) {
        if (ferror(csv->file) != 0) {
            softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be read", csv->path);
            return -1;
        }
        return 0;
    }
    ++csv->line;
    const size_t length = strcspn(line, "\r\n");
    if (length == LINE_SIZE - 1) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%lld: longer than %d characters",
                          csv->path, (long long)csv->line, LINE_SIZE - 2);
        return -1;
    }
    line[length] = '\0';
    return 1;
}

softsim_status ss_csv_open(ss_csv *csv, const char *path, const char *const *name, int32_t count,
                           int32_t required, softsim_error *error)
{
    char line[LINE_SIZE];
    const char *why = NULL;
    *csv = (ss_csv){.file = ss_files_open_stream(path, NULL, &why), .path = path, .count = count};
    if (csv->file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, why);
        return SOFTSIM_ERROR_FILE;
    }
    for (int32_t i = 0; i < count; ++i) {
        csv->place[i] = -1;
    }
    const int got = read_line(csv, line, error);
    int32_t place = 0;
    for (char *at = line; got > 0 && at != NULL; ++place) {
        char *field = strsep(&at, ",");
        for (int32_t i = 0; i < count; ++i) {
            if (strcmp(field, name[i]) == 0) {
                csv->place[i] = place;
            }
        }
    }
    softsim_status status = got < 0 ? SOFTSIM_ERROR_FORMAT : SOFTSIM_OK;
    for (int32_t i = 0; got >= 0 && i < required; ++i) {
        if (csv->place[i] < 0) {
            status = SOFTSIM_ERROR_FORMAT;
            softsim_error_add(error, status, "%s:1: no column '%s' in the head line", path,
                              name[i]);
        }
    }
    if (status != SOFTSIM_OK) {
        ss_csv_close(csv);
    }
    return status;
}

void ss_csv_close(ss_csv *csv)
{
    if (csv->file != NULL) {
        fclose(csv->file);
    }
    csv->file = NULL;
}

int ss_csv_next(ss_csv *csv, double *out_value, softsim_error *error)
{
    char line[LINE_SIZE];
    int got = 0;
    do {
        got = read_line(csv, line, error);
    } while (got > 0 && line[0] == '\0');
    if (got <= 0) {
        return got;
    }
    bool is_found[SS_CSV_MAX_COLUMNS] = {false};
    int32_t place = 0;
    for (int32_t i = 0; i < csv->count; ++i) {
        out_value[i] = NAN;
    }
    for (char *at = line; at != NULL; ++place) {
        char *field = strsep(&at, ",");
        for (int32_t i = 0; i < csv->count; ++i) {
            if (csv->place[i] == place) {
                char *end = NULL;
                out_value[i] = strtod(field, &end);
                is_found[i] = end != field && *end == '\0';
            }
        }
    }
    for (int32_t i = 0; i < csv->count; ++i) {
        if (csv->place[i] >= 0 && !is_found[i]) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%lld: no number in column %d",
                              csv->path, (long long)csv->line, csv->place[i] + 1);
            return -1;
        }
    }
    return 1;
}
