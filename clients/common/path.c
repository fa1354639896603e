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
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"
#include "rt/vec.h"
#include "softsim/log.h"

enum {
    COLUMNS = 10,
    MAX_FILE_COLUMNS = 64,
    LINE_SIZE = 2048,
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
};

/* Where a row comes from, for messages. */
typedef struct csv_place {
    const char *path;
    int64_t line;
    softsim_error *error;
} csv_place;

#define CSV_FAULT(place, format, ...)                                                              \
    softsim_error_add((place)->error, SOFTSIM_ERROR_FORMAT, "%s:%lld: " format, (place)->path,     \
                      (long long)(place)->line, __VA_ARGS__)

/* Where a file has the columns of a path. */
typedef struct csv_layout {
    int32_t count;          /* of its columns */
    int32_t place[COLUMNS]; /* in the order of csv_header; -1: not there */
    bool has_ticks;         /* its first column counts periods */
} csv_layout;

/* The place of `name` in a head line; -1: not there. */
static int32_t find_column(const char *line, const char *name)
{
    int32_t place = 0;
    for (const char *at = line; *at != '\0'; ++place) {
        const size_t length = strcspn(at, ",");
        if (strlen(name) == length && memcmp(at, name, length) == 0) {
            return place;
        }
        at += length + (at[length] == ',');
    }
    return -1;
}

static bool read_layout(const char *line, csv_layout *out)
{
    static const char *const own[COLUMNS] = {"time_s", "probe", "x",  "y",  "z",
                                             "qw",     "qx",    "qy", "qz", "buttons"};
    static const char *const bridges[COLUMNS] = {"time_s", "probe", "qx", "qy", "qz",
                                                 "ow",     "ox",    "oy", "oz", "buttons"};
    const size_t length = sizeof bridge_header - 1;
    out->has_ticks =
        strncmp(line, bridge_header, length) == 0 && (line[length] == '\0' || line[length] == ',');
    out->count = 1;
    for (const char *at = line; (at = strchr(at, ',')) != NULL; ++at) {
        ++out->count;
    }
    for (int i = 0; i < COLUMNS; ++i) {
        out->place[i] = find_column(line, out->has_ticks ? bridges[i] : own[i]);
    }
    return (out->has_ticks && out->count <= MAX_FILE_COLUMNS) || strcmp(line, csv_header) == 0;
}

static bool split_numbers(char *text, const csv_layout *layout, double value[COLUMNS],
                          const csv_place *place)
{
    double all[MAX_FILE_COLUMNS];
    int count = 0;
    for (char *at = text; at != NULL; ++count) {
        char *comma = strchr(at, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        char *end = NULL;
        const double number = strtod(at, &end);
        if (end == at || end[strspn(end, " \t")] != '\0' || !isfinite(number)) {
            CSV_FAULT(place, "column %d: '%.40s' is not a finite number", count + 1, at);
            return false;
        }
        if (count < layout->count) {
            all[count] = number;
        }
        at = comma != NULL ? comma + 1 : NULL;
    }
    if (count != layout->count) {
        CSV_FAULT(place, "%d columns, not the %d of the first line", count, layout->count);
        return false;
    }
    for (int i = 0; i < COLUMNS; ++i) {
        value[i] = layout->place[i] >= 0 ? all[layout->place[i]] : i == 5 ? 1.0 : 0.0;
    }
    if (layout->has_ticks && layout->place[0] < 0) {
        value[0] = bridge_period_s * all[0];
    }
    return true;
}

static bool check_row(const softsim_path *path, const double value[COLUMNS], const csv_place *place)
{
    const double probe = value[1];
    if (probe < 0.0 || probe >= SOFTSIM_MAX_PROBES || floor(probe) != probe) {
        CSV_FAULT(place, "probe %g is none of 0..%d", probe, SOFTSIM_MAX_PROBES - 1);
        return false;
    }
    if (value[0] < 0.0 || value[0] > max_time_s) {
        CSV_FAULT(place, "time_s %g is not within 0..%g", value[0], max_time_s);
        return false;
    }
    const path_track *track = &path->track[(int)probe];
    if (track->count > 0 && value[0] <= track->row[track->count - 1].time_s) {
        CSV_FAULT(place, "time_s %.9g does not grow: probe %g was at %.9g before", value[0], probe,
                  track->row[track->count - 1].time_s);
        return false;
    }
    for (int i = 2; i < 5; ++i) {
        if (fabs(value[i]) > max_position_m) {
            CSV_FAULT(place, "position %g m is beyond %g m; positions are in metres", value[i],
                      max_position_m);
            return false;
        }
    }
    const double *q = value + 5;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabs(length - 1.0) <= 1e-3)) {
        CSV_FAULT(place, "quaternion of length %.6g; give a unit one, w first", length);
        return false;
    }
    if (value[9] < 0.0 || value[9] > 65535.0 || floor(value[9]) != value[9]) {
        CSV_FAULT(place, "buttons %g is not a whole number in 0..65535", value[9]);
        return false;
    }
    return true;
}

static bool append_row(softsim_path *path, const double value[COLUMNS], const csv_place *place)
{
    path_track *track = &path->track[(int)value[1]];
    if (path->row_count == MAX_ROWS) {
        CSV_FAULT(place, "more than %d rows; split the file", MAX_ROWS);
        return false;
    }
    if (track->count == track->capacity) {
        const int32_t capacity = track->capacity > 0 ? 2 * track->capacity : 1024;
        path_row *grown = realloc(track->row, (size_t)capacity * sizeof *grown);
        if (grown == NULL) {
            softsim_error_add(place->error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", place->path);
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

/* One line without its end into `line`; false at the end of the file. */
static bool next_line(FILE *file, char line[LINE_SIZE], csv_place *place)
{
    if (fgets(line, LINE_SIZE, file) == NULL) {
        return false;
    }
    ++place->line;
    const size_t length = strlen(line);
    if (length == LINE_SIZE - 1 && line[length - 1] != '\n') {
        CSV_FAULT(place, "longer than %d characters", LINE_SIZE - 2);
        return false;
    }
    line[strcspn(line, "\r\n")] = '\0';
    return true;
}

static void read_rows(softsim_path *path, FILE *file, csv_place *place)
{
    char line[LINE_SIZE];
    csv_layout layout;
    if (!next_line(file, line, place) || !read_layout(line, &layout)) {
        place->line = 1;
        CSV_FAULT(place, "not a pose path: the first line must be %s, or that of softsim-bridge",
                  csv_header);
        return;
    }
    const int32_t faults_before = place->error->fault_count;
    while (next_line(file, line, place)) {
        double value[COLUMNS];
        if (line[0] == '\0') {
            continue;
        }
        if (split_numbers(line, &layout, value, place) && check_row(path, value, place) &&
            !append_row(path, value, place)) {
            return;
        }
        if (place->error->fault_count - faults_before >= MAX_FAULTS) {
            softsim_error_add(place->error, SOFTSIM_ERROR_FORMAT,
                              "%s: %d faults; the rest was not read", place->path, MAX_FAULTS);
            return;
        }
    }
    if (ferror(file)) {
        softsim_error_add(place->error, SOFTSIM_ERROR_FILE, "%s: %s", place->path, strerror(errno));
    } else if (path->row_count == 0 && place->error->fault_count == faults_before) {
        softsim_error_add(place->error, SOFTSIM_ERROR_FORMAT, "%s: no poses", place->path);
    }
}

softsim_status softsim_path_load(const char *path, softsim_path **out_path, softsim_error *error)
{
    *out_path = NULL;
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, NULL, &why);
    if (file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, why);
        return SOFTSIM_ERROR_FILE;
    }
    const int32_t faults_before = error->fault_count;
    softsim_path *loaded = calloc(1, sizeof *loaded);
    csv_place place = {path, 0, error};
    if (loaded == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
    } else {
        read_rows(loaded, file, &place);
    }
    fclose(file);
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
