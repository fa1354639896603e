/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "curve.h"

#include <math.h>
#include <stdlib.h>

#include "rt/csv.h"

enum { DEPTH, TIME, FORCE, COLUMNS };
enum { LARGEST_N = 1000000 }; /* forces beyond are a unit error, and their squares may overflow */

/* Opens the file and says which of its columns are the points. */
static softsim_status open_columns(const char *path, ss_csv *csv, bool *out_is_time,
                                   softsim_error *error)
{
    static const char *const name[COLUMNS] = {"depth_m", "time_s", "force_n"};
    softsim_status status = ss_csv_open(csv, path, name, COLUMNS, 0, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const bool has_depth = csv->place[DEPTH] >= 0, has_time = csv->place[TIME] >= 0;
    *out_is_time = has_time;
    if (has_depth == has_time || csv->place[FORCE] < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:1: give the columns depth_m,force_n (pressing) or time_s,force_n "
                          "(holding)",
                          path);
        ss_csv_close(csv);
        return SOFTSIM_ERROR_FORMAT;
    }
    return SOFTSIM_OK;
}

/* One row more; false after a fault. */
static bool take_row(ss_curve *curve, const ss_csv *csv, double at, double force,
                     softsim_error *error)
{
    const char *column = curve->is_time ? "time_s" : "depth_m";
    const long long line = csv->line;
    if (!isfinite(at) || !isfinite(force)) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: not a finite number; remove the row", curve->path, line);
    } else if (fabs(force) > LARGEST_N) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: force_n %g is beyond %d N; give it in newtons", curve->path,
                          line, force, LARGEST_N);
    } else if (at < 0.0) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: %s %g is below 0; count it from the first touch%s", curve->path,
                          line, column, at, curve->is_time ? ", or the end of the press" : "");
    } else if (curve->count > 0 && at <= curve->at[curve->count - 1]) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: %s %g does not follow %g; sort the rows, one for each %s",
                          curve->path, line, column, at, curve->at[curve->count - 1], column);
    } else if (curve->count == SS_CURVE_MAX_POINTS) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:%lld: more than %d rows; leave out all but a few hundred",
                          curve->path, line, SS_CURVE_MAX_POINTS);
    } else {
        curve->at[curve->count] = at;
        curve->force[curve->count++] = force;
        return true;
    }
    return false;
}

softsim_status ss_curve_read(const char *path, ss_curve *out, softsim_error *error)
{
    ss_csv csv;
    *out = (ss_curve){.path = path};
    softsim_status status = open_columns(path, &csv, &out->is_time, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    out->at = calloc(SS_CURVE_MAX_POINTS, sizeof *out->at);
    out->force = calloc(SS_CURVE_MAX_POINTS, sizeof *out->force);
    int got = out->at && out->force ? 1 : -1;
    if (got < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
    }
    double value[COLUMNS], sum = 0.0;
    while (got > 0 && (got = ss_csv_next(&csv, value, error)) > 0) {
        got = take_row(out, &csv, value[out->is_time ? TIME : DEPTH], value[FORCE], error) ? 1 : -1;
    }
    ss_csv_close(&csv);
    for (int32_t k = 0; k < out->count; ++k) {
        sum += out->force[k] * out->force[k];
    }
    out->rms = out->count > 0 ? sqrt(sum / out->count) : 0.0;
    if (got == 0 && out->count < 2) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s: %s; a curve needs two points at least, and more to tell one "
                          "parameter from another",
                          path, out->count == 0 ? "no points" : "one point only");
        got = -1;
    } else if (got == 0 && !(out->rms > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s: every force is 0; there is nothing to fit to", path);
        got = -1;
    }
    if (got < 0) {
        ss_curve_fini(out);
        return SOFTSIM_ERROR_FORMAT;
    }
    return SOFTSIM_OK;
}

void ss_curve_fini(ss_curve *curve)
{
    free(curve->at);
    free(curve->force);
    *curve = (ss_curve){.path = curve->path};
}
