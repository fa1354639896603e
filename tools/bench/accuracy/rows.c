/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Rows of accuracy.csv, and what is computed from them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accuracy/accuracy.h"
#include "output.h"
#include "rt/each.h"
#include "rt/memory.h"

const char ss_accuracy_head[] =
    "case,material,model,mesh,nodes,elements,level,error_l2,error_max,error_force,us_per_step_p50,"
    "us_per_step_p99,dt_s,realtime_factor,time_to_1pct_ms,calibrated,verdict";
static const char own_head[] = ",value,force_n";

/* ---- writing ---- */

void ss_accuracy_put(FILE *file, double value)
{
    if (isfinite(value)) {
        fprintf(file, ",%.6g", value);
    } else {
        fputc(',', file);
    }
}

void ss_accuracy_line(FILE *file, const ss_accuracy_row *row, bool is_whole)
{
    const double value[] = {row->error_l2, row->error_max, row->error_force, row->p50_us,
                            row->p99_us,   row->dt_s,      row->realtime,    row->to_1pct_ms};
    ss_csv_text(file, row->case_name);
    fputc(',', file);
    ss_csv_text(file, row->material);
    fprintf(file, ",%s,", row->model);
    ss_csv_text(file, row->mesh);
    fprintf(file, ",%d,%d,", row->nodes, row->elements);
    ss_csv_text(file, row->level);
    for (size_t k = 0; k < sizeof value / sizeof *value; ++k) {
        ss_accuracy_put(file, value[k]);
    }
    fprintf(file, ",%s,", row->calibrated);
    ss_csv_text(file, row->verdict);
    if (is_whole) {
        ss_accuracy_put(file, row->value);
        ss_accuracy_put(file, row->force);
    }
    fputc('\n', file);
}

softsim_status ss_accuracy_rows_write(const ss_accuracy_rows *rows, const char *folder,
                                      softsim_error *error)
{
    ss_output output;
    const softsim_status status =
        ss_report_csv_open(&output, folder, "accuracy", ss_accuracy_head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < rows->count; ++i) {
        if (rows->row[i].source == 0) {
            ss_accuracy_line(output.file, &rows->row[i], false);
        }
    }
    return ss_output_commit(&output, error);
}

/* ---- reading ---- */

/* Cells may be empty: NaN. */
static double number(const ss_table *table, int32_t row, int32_t column, softsim_error *error)
{
    return column < 0 || *ss_table_cell(table, row, column) == '\0'
               ? (double)NAN
               : ss_table_number(table, row, column, error);
}

static void text(const ss_table *table, int32_t row, int32_t column, char *out, size_t size,
                 softsim_error *error)
{
    const char *cell = ss_table_cell(table, row, column);
    if (snprintf(out, size, "%s", cell) >= (int)size) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%d: column '%s': '%.40s...' is too long; give at most %zu characters",
                          table->path, table->line[row], table->head[column], cell, size - 1);
    }
}

/* A count; 0 of an empty cell. */
static int32_t whole(const ss_table *table, int32_t row, int32_t column, softsim_error *error)
{
    const double value = number(table, row, column, error);
    if (!isnan(value) && !(value >= 0.0 && value < 2e9 && floor(value) == value)) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%d: column '%s': '%.40s' is no count; give a whole number from 0",
                          table->path, table->line[row], table->head[column],
                          ss_table_cell(table, row, column));
        return 0;
    }
    return isnan(value) ? 0 : (int32_t)value;
}

enum {
    CASE,
    MATERIAL,
    MODEL,
    MESH,
    NODES,
    ELEMENTS,
    LEVEL,
    ERROR_L2,
    ERROR_MAX,
    ERROR_FORCE,
    P50,
    P99,
    DT,
    REALTIME,
    TO_1PCT,
    CALIBRATED,
    VERDICT,
    COLUMNS
};

static void take_row(const ss_table *t, int32_t i, const int32_t column[COLUMNS], int32_t value,
                     int32_t force, ss_accuracy_row *row, softsim_error *error)
{
    text(t, i, column[CASE], row->case_name, sizeof row->case_name, error);
    text(t, i, column[MATERIAL], row->material, sizeof row->material, error);
    text(t, i, column[MODEL], row->model, sizeof row->model, error);
    text(t, i, column[MESH], row->mesh, sizeof row->mesh, error);
    text(t, i, column[LEVEL], row->level, sizeof row->level, error);
    text(t, i, column[CALIBRATED], row->calibrated, sizeof row->calibrated, error);
    text(t, i, column[VERDICT], row->verdict, sizeof row->verdict, error);
    row->nodes = whole(t, i, column[NODES], error);
    row->elements = whole(t, i, column[ELEMENTS], error);
    row->error_l2 = number(t, i, column[ERROR_L2], error);
    row->error_max = number(t, i, column[ERROR_MAX], error);
    row->error_force = number(t, i, column[ERROR_FORCE], error);
    row->p50_us = number(t, i, column[P50], error);
    row->p99_us = number(t, i, column[P99], error);
    row->dt_s = number(t, i, column[DT], error);
    row->realtime = number(t, i, column[REALTIME], error);
    if (isnan(row->realtime)) {
        row->realtime = row->dt_s / (1e-6 * row->p50_us);
    }
    row->to_1pct_ms = number(t, i, column[TO_1PCT], error);
    row->value = number(t, i, value, error);
    row->force = number(t, i, force, error);
}

static softsim_status take_table(ss_accuracy_rows *rows, const ss_table *table, int32_t source,
                                 softsim_error *error)
{
    int32_t column[COLUMNS];
    char head[sizeof ss_accuracy_head + 512];
    int32_t count = 0;
    const int32_t faults = error->fault_count;
    snprintf(head, sizeof head, "%s", ss_accuracy_head);
    for (char *at = head, *name = NULL; (name = strsep(&at, ",")) != NULL;) {
        column[count++] = ss_table_find(table, name, error);
    }
    if (error->fault_count > faults) {
        return error->status;
    }
    const size_t total = (size_t)rows->count + (size_t)table->row_count;
    ss_accuracy_row *row = realloc(rows->row, (total + 1) * sizeof *row);
    if (row == NULL) {
        return ss_memory_fault(error);
    }
    rows->row = row;
    for (int32_t i = 0; i < table->row_count; ++i) {
        row[rows->count] = (ss_accuracy_row){.source = source, .line = table->line[i]};
        if (table->cell_count[i] < table->column_count) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                              "%s:%d: %d cells, the head line has %d; write a comma for each that "
                              "is empty",
                              table->path, table->line[i], table->cell_count[i],
                              table->column_count);
            continue;
        }
        take_row(table, i, column, ss_table_find(table, "value", NULL),
                 ss_table_find(table, "force_n", NULL), &row[rows->count++], error);
    }
    return error->fault_count > faults ? error->status : SOFTSIM_OK;
}

softsim_status ss_accuracy_rows_add(ss_accuracy_rows *rows, char *jobs, softsim_error *error)
{
    char *whole_text = NULL;
    const int length = asprintf(&whole_text, "%s%s\n%s", ss_accuracy_head, own_head, jobs);
    ss_table table = {.path = NULL};
    free(jobs);
    softsim_status status =
        ss_table_parse("results", length > 0 ? whole_text : NULL, &table, error);
    if (status == SOFTSIM_OK) {
        status = take_table(rows, &table, 0, error);
    }
    ss_table_fini(&table);
    return status;
}

softsim_status ss_accuracy_rows_compare(ss_accuracy_rows *rows, const char *path,
                                        softsim_error *error)
{
    ss_table table = {.path = NULL};
    if (rows->source_count + 1 >= SS_ACCURACY_MAX_SOURCES) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--compare: at most %d files",
                          SS_ACCURACY_MAX_SOURCES - 1);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    softsim_status status = ss_table_load(path, &table, error);
    if (status == SOFTSIM_OK) {
        rows->source[++rows->source_count] = path;
        status = take_table(rows, &table, rows->source_count, error);
    }
    ss_table_fini(&table);
    return status;
}

void ss_accuracy_rows_fini(ss_accuracy_rows *rows)
{
    free(rows->row);
    *rows = (ss_accuracy_rows){.row = NULL};
}

/* ---- means, choice, front ---- */

static bool is_same(const ss_accuracy_row *a, const ss_accuracy_row *b)
{
    return a->source == b->source && strcmp(a->model, b->model) == 0 &&
           strcmp(a->mesh, b->mesh) == 0;
}

static void add_row(ss_accuracy_mean *mean, const ss_accuracy_row *row, double share)
{
    mean->error_l2 += share * row->error_l2;
    mean->error_force += share * row->error_force;
    mean->p50_us += share * row->p50_us;
    mean->realtime += share * row->realtime;
    mean->to_1pct_ms += share * row->to_1pct_ms;
    mean->is_calibrated |= strcmp(row->calibrated, "yes") == 0;
}

static bool is_of(const ss_accuracy_row *row, const char *case_name, const char *material)
{
    return strcmp(row->case_name, case_name) == 0 && strcmp(row->material, material) == 0;
}

/* The mean that row `first` begins. */
static void take_mean(const ss_accuracy_rows *rows, int32_t first, ss_accuracy_mean *out)
{
    const ss_accuracy_row *row = &rows->row[first];
    const ss_model_class *model = ss_accuracy_model_find(row->model);
    int32_t levels = 0;
    *out = (ss_accuracy_mean){.first = row,
                              .verdict = row->verdict,
                              .is_other =
                                  row->source == 0 && model != NULL && model->hints->note != NULL};
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t k = first; k < rows->count; ++k) {
            const ss_accuracy_row *at = &rows->row[k];
            if (!is_of(at, row->case_name, row->material) || !is_same(row, at)) {
                continue;
            }
            if (pass == 0) {
                ++levels;
            } else {
                add_row(out, at, 1.0 / levels);
                out->verdict = strcmp(out->verdict, "good") == 0 ? at->verdict : out->verdict;
            }
        }
    }
}

softsim_status ss_accuracy_means_find(const ss_accuracy_rows *rows, const char *case_name,
                                      const char *material, ss_accuracy_means *out,
                                      softsim_error *error)
{
    const size_t room = (size_t)rows->count + 1; /* as many as there are rows, at most */
    *out = (ss_accuracy_means){.mean = calloc(room, sizeof *out->mean),
                               .time = calloc(room, sizeof *out->time),
                               .error = calloc(room, sizeof *out->error),
                               .is_front = calloc(room, sizeof *out->is_front)};
    if (!out->mean || !out->time || !out->error || !out->is_front) {
        return ss_memory_fault(error);
    }
    for (int32_t i = 0; i < rows->count; ++i) {
        bool is_new = is_of(&rows->row[i], case_name, material);
        for (int32_t k = 0; k < out->count && is_new; ++k) {
            is_new = !is_same(out->mean[k].first, &rows->row[i]);
        }
        if (is_new) {
            take_mean(rows, i, &out->mean[out->count++]);
        }
    }
    return SOFTSIM_OK;
}

void ss_accuracy_means_fini(ss_accuracy_means *means)
{
    SS_EACH(free, means->mean, means->time, means->error, means->is_front);
    *means = (ss_accuracy_means){.mean = NULL};
}

const ss_accuracy_mean *ss_accuracy_choose(const ss_accuracy_mean *mean, int32_t count,
                                           double budget_us)
{
    const ss_accuracy_mean *best = NULL;
    for (int32_t k = 0; k < count; ++k) {
        if (mean[k].p50_us <= budget_us && !isnan(mean[k].error_l2) && !mean[k].is_other &&
            (best == NULL || mean[k].error_l2 < best->error_l2)) {
            best = &mean[k];
        }
    }
    return best;
}

void ss_accuracy_pareto(int32_t count, const double *time, const double *error, bool *out_front)
{
    for (int32_t i = 0; i < count; ++i) {
        out_front[i] = !isnan(time[i]) && !isnan(error[i]);
        for (int32_t k = 0; k < count && out_front[i]; ++k) {
            const bool is_as_good = time[k] <= time[i] && error[k] <= error[i];
            const bool is_better = time[k] < time[i] || error[k] < error[i];
            out_front[i] = !(is_as_good && (is_better || k < i));
        }
    }
}
