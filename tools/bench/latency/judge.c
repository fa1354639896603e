/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/latency/judge.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/args.h"
#include "rt/csv.h"

enum { MAX_ROWS = 20 * 1000 * 1000 }; /* more than five hours at 1 kHz */
enum { X, Y, Z, FX, FY, FZ, TIME, TICK, FLAGS, AGE, COLUMNS, REQUIRED = FZ + 1 };

static bool append(ss_judge_log *log, int64_t *capacity, const ss_felt_row *row)
{
    if (log->count == *capacity) {
        const int64_t larger = *capacity == 0 ? 4096 : 2 * *capacity;
        ss_felt_row *rows = larger <= 2 * (int64_t)MAX_ROWS
                                ? realloc(log->row, (size_t)larger * sizeof *rows)
                                : NULL;
        if (rows == NULL) {
            return false;
        }
        log->row = rows;
        *capacity = larger;
    }
    log->row[log->count++] = *row;
    return true;
}

/* What is no whole number of 32 bits is 0. */
static int32_t whole(double value)
{
    return fabs(value) <= INT32_MAX ? (int32_t)value : 0;
}

softsim_status ss_judge_load(const char *path, double rate_hz, ss_judge_log *log,
                             softsim_error *error)
{
    static const char *const name[COLUMNS] = {"x",  "y",      "z",    "fx",    "fy",
                                              "fz", "time_s", "tick", "flags", "model_age_us"};
    ss_csv csv;
    *log = (ss_judge_log){0};
    softsim_status status = ss_csv_open(&csv, path, name, COLUMNS, REQUIRED, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (csv.place[TIME] < 0 && csv.place[TICK] < 0) {
        status = SOFTSIM_ERROR_FORMAT;
        softsim_error_add(error, status, "%s:1: neither a column 'time_s' nor 'tick'", path);
    }
    log->has_age = csv.place[AGE] >= 0;
    int64_t capacity = 0;
    int got = 1;
    double value[COLUMNS];
    while (status == SOFTSIM_OK && (got = ss_csv_next(&csv, value, error)) > 0) {
        const ss_felt_row row = {.time_s =
                                     csv.place[TIME] >= 0 ? value[TIME] : value[TICK] / rate_hz,
                                 .x = {value[X], value[Y], value[Z]},
                                 .f = {value[FX], value[FY], value[FZ]},
                                 .flags = whole(value[FLAGS]),
                                 .age_us = whole(value[AGE])};
        if (!append(log, &capacity, &row)) {
            status = SOFTSIM_ERROR_MEMORY;
            softsim_error_add(error, status, "%s: too many rows", path);
        }
    }
    if (got < 0) {
        status = SOFTSIM_ERROR_FORMAT;
    }
    ss_csv_close(&csv);
    if (status != SOFTSIM_OK) {
        ss_judge_free(log);
    }
    return status;
}

void ss_judge_free(ss_judge_log *log)
{
    free(log->row);
    *log = (ss_judge_log){0};
}

static bool print_metric(const char *name, ss_felt_metric metric, double factor, const char *unit,
                         const char *more)
{
    char value[64] = "-";
    if (metric.verdict != SS_FELT_NONE) {
        snprintf(value, sizeof value, "%.4g%s%s", factor * metric.value, *unit != '\0' ? " " : "",
                 unit);
    }
    printf("%-12s %-14s %s%s\n", name, value, ss_felt_verdict_name(metric.verdict), more);
    return metric.verdict == SS_FELT_BAD;
}

/* True when any of them is bad. */
static bool print_felt(const ss_felt *felt, bool has_age)
{
    char chatter[48] = "";
    if (felt->chatter_m.verdict != SS_FELT_NONE) {
        snprintf(chatter, sizeof chatter, ", at %.0f Hz", felt->chatter_hz);
    }
    printf("%-12s %d\n", "contacts", felt->contacts);
    bool is_bad = print_metric("net energy", felt->net_energy_j, 1e3, "mJ", "");
    is_bad |= print_metric("chatter", felt->chatter_m, 1e3, "mm", chatter);
    is_bad |= print_metric("buzz", felt->buzz, 100.0, "%", "");
    is_bad |= print_metric("continuity", felt->continuity, 100.0, "%", "");
    is_bad |= print_metric("bounces", felt->bounces, 1.0, "a second", "");
    if (has_age) {
        printf("%-12s %.4g us, %.1f %% of forces predicted\n", "age p99", felt->age_p99_us.value,
               100.0 * felt->predicted_share);
    }
    return is_bad;
}

int ss_judge_run(const char *program, const char *path, double rate_hz, int32_t contacts)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_judge_log log;
    ss_felt felt;
    const ss_felt_options options = {.intended_contacts = contacts};
    softsim_status status = ss_judge_load(path, rate_hz, &log, &error);
    if (status == SOFTSIM_OK) {
        status = ss_felt_judge(log.row, log.count, &options, &felt);
        if (status != SOFTSIM_OK) {
            softsim_error_add(&error, status,
                              status == SOFTSIM_ERROR_ARGUMENT
                                  ? "%s: fewer than two rows, times that do not increase, or "
                                    "numbers that are not finite"
                                  : "%s: out of memory",
                              path);
        }
    }
    if (status != SOFTSIM_OK) {
        ss_args_print_error(program, &error);
        ss_judge_free(&log);
        return 2;
    }
    const bool is_bad = print_felt(&felt, log.has_age);
    ss_judge_free(&log);
    return is_bad ? 1 : 0;
}
