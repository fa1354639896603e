/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Pose paths: `time_s,probe,x,y,z,qw,qx,qy,qz,buttons`, read whole and checked row by row, rows
 * kept per probe in the order of time. What softsim-bridge --csv writes is one too: it sent the
 * position qx,qy,qz; the columns that it has besides are known by name, and where an older file
 * lacks them it is of one probe at 1 kHz, not turned, no button pressed. Between rows: position
 * linear; orientation by spherical interpolation along the shorter arc, q(u) = (sin((1-u) a) q0 +
 * sin(u a) q1) / sin a with cos a = |q0 . q1|; buttons of the row before.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/csv.h"
#include "rt/vec.h"
#include "softsim/log.h"

enum {
    COLUMNS = 10,
    MAX_ROWS = 4 * 1000 * 1000, /* 320 MB; more than an hour at 1 kHz */
    MAX_FAULTS = 20             /* then reading stops: the file is something else */
};
static const char csv_header[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons";
static const char bridge_header[] = "tick,x,y,z,vx,vy,vz,qx,qy,qz,fx,fy,fz,energy_in_j";
static const double bridge_period_s = 1e-3; /* of its files without the column time_s */
static const double max_time_s = 1e6;       /* times beyond are a unit error */
static const double max_position_m = 1e3;   /* as are positions */

typedef struct path_row {
    double time_s, position[3], orientation[4];
    int32_t buttons;
} path_row;

typedef struct path_track {
    path_row *row;
    int32_t count, capacity;
} path_track;

struct softsim_path {
    path_track track[SOFTSIM_MAX_PROBES];
    int32_t row_count;
    int64_t cut_line;
};

/* The columns that are read, and which of them is what in a path and in what a bridge writes. */
enum { WANTED = 15, TICK = 10 };
static const char *const wanted[WANTED] = {"time_s", "probe", "x",  "y",  "z",
                                           "qw",     "qx",    "qy", "qz", "buttons",
                                           "tick",   "ow",    "ox", "oy", "oz"};
static const int of_path[COLUMNS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
static const int of_bridge[COLUMNS] = {0, 1, 6, 7, 8, 11, 12, 13, 14, 9};

#define CSV_FAULT(csv, error, format, ...)                                                         \
    softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%lld: " format, (csv)->path,                \
                      (long long)(csv)->line, __VA_ARGS__)

static bool check_row(const softsim_path *path, const double value[COLUMNS], const ss_csv *csv,
                      softsim_error *error)
{
    const double probe = value[1];
    if (probe < 0.0 || probe >= SOFTSIM_MAX_PROBES || floor(probe) != probe) {
        CSV_FAULT(csv, error, "probe %g is not one of 0..%d", probe, SOFTSIM_MAX_PROBES - 1);
        return false;
    }
    if (value[0] < 0.0 || value[0] > max_time_s) {
        CSV_FAULT(csv, error, "time_s %g is not within 0..%g", value[0], max_time_s);
        return false;
    }
    const path_track *track = &path->track[(int)probe];
    if (track->count > 0 && value[0] <= track->row[track->count - 1].time_s) {
        CSV_FAULT(csv, error, "time_s %.9g does not grow: probe %g was at %.9g before", value[0],
                  probe, track->row[track->count - 1].time_s);
        return false;
    }
    for (int i = 2; i < 5; ++i) {
        if (fabs(value[i]) > max_position_m) {
            CSV_FAULT(csv, error, "position %g m is beyond %g m; positions are in metres", value[i],
                      max_position_m);
            return false;
        }
    }
    const double *q = value + 5;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabs(length - 1.0) <= 1e-3)) {
        CSV_FAULT(csv, error, "quaternion of length %.6g; give a unit one, w first", length);
        return false;
    }
    if (value[9] < 0.0 || value[9] > 65535.0 || floor(value[9]) != value[9]) {
        CSV_FAULT(csv, error, "buttons %g is not a whole number in 0..65535", value[9]);
        return false;
    }
    return true;
}

static bool append_row(softsim_path *path, const double value[COLUMNS], const ss_csv *csv,
                       softsim_error *error)
{
    path_track *track = &path->track[(int)value[1]];
    if (path->row_count == MAX_ROWS) {
        CSV_FAULT(csv, error, "more than %d rows; split the file", MAX_ROWS);
        return false;
    }
    if (track->count == track->capacity) {
        const int32_t capacity = track->capacity > 0 ? 2 * track->capacity : 1024;
        path_row *grown = realloc(track->row, (size_t)capacity * sizeof *grown);
        if (grown == NULL) {
            softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", csv->path);
            return false;
        }
        track->row = grown;
        track->capacity = capacity;
    }
    path_row *row = &track->row[track->count++];
    row->time_s = value[0];
    ss_copy3(row->position, value + 2);
    const double *q = value + 5;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; ++i) {
        row->orientation[i] = q[i] / length;
    }
    row->buttons = (int32_t)value[9];
    ++path->row_count;
    return true;
}

static void read_rows(softsim_path *path, ss_csv *csv, softsim_error *error)
{
    const size_t length = sizeof bridge_header - 1;
    const bool is_bridge = strncmp(csv->head, bridge_header, length) == 0 &&
                           (csv->head[length] == '\0' || csv->head[length] == ',');
    const int *place = is_bridge ? of_bridge : of_path;
    if (!is_bridge && strcmp(csv->head, csv_header) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                          "%s:1: not a pose path: the first line must be %s, or that of "
                          "softsim-bridge",
                          csv->path, csv_header);
        return;
    }
    const int32_t faults_before = error->fault_count;
    double row[WANTED], value[COLUMNS];
    csv->is_strict = true;
    csv->is_recording = is_bridge;
    for (int got = 1; got != 0;) {
        got = ss_csv_next(csv, row, error);
        for (int i = 0; got > 0 && i < COLUMNS; ++i) {
            value[i] = csv->place[place[i]] >= 0 ? row[place[i]] : i == 5 ? 1.0 : 0.0;
        }
        if (got > 0 && csv->place[place[0]] < 0) {
            value[0] = bridge_period_s * row[TICK];
        }
        if (got > 0 && check_row(path, value, csv, error) && !append_row(path, value, csv, error)) {
            return;
        }
        if (error->fault_count - faults_before >= MAX_FAULTS) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: %d faults; the rest was not read",
                              csv->path, MAX_FAULTS);
            return;
        }
    }
    path->cut_line = csv->cut_line;
    if (path->row_count == 0 && error->fault_count == faults_before) {
        softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: no poses", csv->path);
    }
}

softsim_status softsim_path_load(const char *path, softsim_path **out_path, softsim_error *error)
{
    *out_path = NULL;
    const int32_t faults_before = error->fault_count;
    ss_csv csv;
    const softsim_status status = ss_csv_open(&csv, path, wanted, WANTED, 0, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    softsim_path *loaded = calloc(1, sizeof *loaded);
    if (loaded == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
    } else {
        read_rows(loaded, &csv, error);
    }
    ss_csv_close(&csv);
    if (error->fault_count > faults_before) {
        softsim_path_free(&loaded);
        return error->status;
    }
    *out_path = loaded;
    return SOFTSIM_OK;
}

void softsim_path_free(softsim_path **path)
{
    if (*path != NULL) {
        for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            free((*path)->track[p].row);
        }
        free(*path);
        *path = NULL;
    }
}

bool softsim_path_note(const softsim_path *path, char *note, size_t note_size)
{
    if (path->cut_line > 0) {
        snprintf(note, note_size, "line %lld is half a row, left out: its writer was killed",
                 (long long)path->cut_line);
    }
    return path->cut_line > 0;
}

uint8_t softsim_path_probes(const softsim_path *path)
{
    uint8_t probes = 0;
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (path->track[p].count > 0) {
            probes = (uint8_t)(probes | 1u << p);
        }
    }
    return probes;
}

void softsim_path_range(const softsim_path *path, int32_t probe, double *out_begin_s,
                        double *out_end_s)
{
    *out_begin_s = INFINITY;
    *out_end_s = 0.0;
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const path_track *track = &path->track[p];
        if (track->count > 0 && (probe < 0 || p == probe)) {
            *out_begin_s = fmin(*out_begin_s, track->row[0].time_s);
            *out_end_s = fmax(*out_end_s, track->row[track->count - 1].time_s);
        }
    }
}

static void interpolate_orientation(double out[4], const double a[4], const double b[4], double u)
{
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    cosine = fmin(fabs(cosine), 1.0);
    double wa = 1.0 - u;
    double wb = u;
    if (cosine < 1.0 - 1e-10) {
        const double angle = acos(cosine);
        wa = sin((1.0 - u) * angle) / sin(angle);
        wb = sin(u * angle) / sin(angle);
    }
    double square = 0.0;
    for (int i = 0; i < 4; ++i) {
        out[i] = wa * a[i] + sign * wb * b[i];
        square += out[i] * out[i];
    }
    for (int i = 0; i < 4; ++i) {
        out[i] /= sqrt(square);
    }
}

bool softsim_path_sample(const softsim_path *path, int32_t probe, double time_s,
                         softsim_pose *out_pose)
{
    if (probe < 0 || probe >= SOFTSIM_MAX_PROBES || path->track[probe].count == 0) {
        return false;
    }
    const path_track *track = &path->track[probe];
    if (!(time_s >= track->row[0].time_s) || !(time_s <= track->row[track->count - 1].time_s)) {
        return false;
    }
    /* The last row at or before the time, by bisection. */
    int32_t low = 0;
    int32_t high = track->count;
    while (high - low > 1) {
        const int32_t middle = low + (high - low) / 2;
        if (track->row[middle].time_s <= time_s) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const path_row *a = &track->row[low];
    const path_row *b = low + 1 < track->count ? a + 1 : a;
    const double u = b > a ? (time_s - a->time_s) / (b->time_s - a->time_s) : 0.0;
    *out_pose = (softsim_pose){.probe = probe, .buttons = a->buttons, .force_seq = -1};
    for (int i = 0; i < 3; ++i) {
        out_pose->position[i] = a->position[i] + u * (b->position[i] - a->position[i]);
    }
    interpolate_orientation(out_pose->orientation, a->orientation, b->orientation, u);
    ss_set3(out_pose->velocity, NAN, NAN, NAN);
    ss_set3(out_pose->applied_force, NAN, NAN, NAN);
    return true;
}
