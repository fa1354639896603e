/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Faults with their place, the source line and a caret.
 *
 * libfyaml can print such messages itself (fy_node_report), but only for nodes of its own
 * documents and straight to a stream; writing them here gives syntax errors, schema faults,
 * overrides and data files one form, and lets a line of a megabyte be shown as a window.
 */
#include "scene/report.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/plain.h"

enum {
    MESSAGE_SIZE = 640, /* bytes of one message; longer ones are cut */
    WINDOW_BEFORE = 60, /* bytes of the source line shown before the caret at most */
    WINDOW_SIZE = 100   /* bytes of the source line shown at most */
};

/* Copies what may be shown, the rest as `?` (tabs as a blank); returns the columns written. */
static size_t clean(const char *from, size_t size, char *out, size_t out_size)
{
    size_t used = 0;
    size_t columns = 0;
    for (size_t i = 0; i < size && used + 5 < out_size; columns++) {
        const size_t length = ss_plain_length(from + i, size - i);
        if (!ss_plain_is_shown(from + i, length)) {
            out[used++] = from[i] == '\t' ? ' ' : '?';
            i += 1;
            continue;
        }
        memcpy(out + used, from + i, length);
        used += length;
        i += length;
    }
    out[used] = '\0';
    return columns;
}

static bool is_continuation(char c)
{
    return ((unsigned char)c & 0xc0) == 0x80;
}

/* The line and the caret line under bytes [offset, offset + length) of the scene. */
static void show_source(const ss_scene_report *report, size_t start, size_t end, size_t offset,
                        size_t length, char *out, size_t out_size)
{
    size_t from = offset > start + WINDOW_BEFORE ? offset - WINDOW_BEFORE : start;
    size_t to = end > from + WINDOW_SIZE ? from + WINDOW_SIZE : end;
    while (from < offset && is_continuation(report->source[from])) {
        from++;
    }
    while (to > offset && to < end && is_continuation(report->source[to])) {
        to--;
    }
    char line[WINDOW_SIZE + 8];
    char scratch[WINDOW_SIZE + 8];
    clean(report->source + from, to - from, line, sizeof line);
    const size_t before = clean(report->source + from, offset - from, scratch, sizeof scratch);
    const size_t last = offset + length < to ? offset + length : to;
    size_t marked =
        last > offset ? clean(report->source + offset, last - offset, scratch, sizeof scratch) : 1;
    char caret[2 * WINDOW_SIZE + 16];
    if (marked < 1) {
        marked = 1;
    }
    memset(caret, ' ', before);
    caret[before] = '^';
    memset(caret + before + 1, '~', marked - 1);
    caret[before + marked] = '\0';
    snprintf(out, out_size, "\n%s\n%s", line, caret);
}

static void drop(ss_scene_report *report)
{
    report->dropped += report->dropped < SS_SCENE_MAX_DROPPED;
}

static void push(ss_scene_report *report, softsim_status status, uint64_t order, const char *text)
{
    if (ss_scene_report_is_full(report)) {
        drop(report);
        return;
    }
    char *copy = strdup(text);
    if (copy == NULL) {
        drop(report);
        return;
    }
    report->fault[report->count++] =
        (ss_scene_fault){.status = status, .order = order, .text = copy};
}

/* Overrides come after the file, in their own order. */
static uint64_t order_of(ss_scene_place place)
{
    return place.override >= 0 ? (uint64_t)UINT32_MAX + 1 + (uint64_t)place.override : place.offset;
}

void ss_scene_report_add(ss_scene_report *report, softsim_status status, ss_scene_place place,
                         const char *format, ...)
{
    if (ss_scene_report_is_full(report)) {
        drop(report);
        return;
    }
    char message[MESSAGE_SIZE];
    char text[MESSAGE_SIZE];
    char path[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    clean(message, strlen(message), text, sizeof text);

    char whole[2 * MESSAGE_SIZE + 2 * WINDOW_SIZE];
    if (place.override >= 0) {
        const char *option = report->overrides[place.override];
        clean(option, strnlen(option, sizeof path), path, sizeof path);
        snprintf(whole, sizeof whole, "--set %s: error: %s", path, text);
        push(report, status, order_of(place), whole);
        return;
    }
    clean(report->path, strnlen(report->path, 1024), path, sizeof path);
    size_t offset = place.offset < report->size ? place.offset : report->size;
    size_t start = offset;
    while (start > 0 && report->source[start - 1] != '\n') {
        start--;
    }
    size_t end = offset;
    while (end < report->size && report->source[end] != '\n' && report->source[end] != '\r') {
        end++;
    }
    size_t column = 1;
    for (size_t i = start; i < offset; i++) {
        column += !is_continuation(report->source[i]);
    }
    char source[4 * WINDOW_SIZE];
    show_source(report, start, end, offset, place.length, source, sizeof source);
    snprintf(whole, sizeof whole, "%s:%lld:%zu: error: %s%s", path,
             (long long)ss_scene_report_line(report, (uint32_t)offset), column, text,
             report->size > 0 ? source : "");
    push(report, status, order_of(place), whole);
}

void ss_scene_report_file(ss_scene_report *report, ss_scene_place place, const char *path,
                          int64_t line, const char *format, ...)
{
    char message[MESSAGE_SIZE];
    char text[MESSAGE_SIZE];
    char name[256];
    char whole[2 * MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    clean(message, strlen(message), text, sizeof text);
    clean(path, strnlen(path, 1024), name, sizeof name);
    if (line > 0) {
        snprintf(whole, sizeof whole, "%s:%lld: error: %s", name, (long long)line, text);
    } else {
        snprintf(whole, sizeof whole, "%s: error: %s", name, text);
    }
    push(report, SOFTSIM_ERROR_SCENE, order_of(place), whole);
}

int64_t ss_scene_report_line(const ss_scene_report *report, uint32_t offset)
{
    int64_t line = 1;
    for (size_t i = 0; i < offset && i < report->size; i++) {
        line += report->source[i] == '\n';
    }
    return line;
}

bool ss_scene_report_is_full(const ss_scene_report *report)
{
    return report->count == SS_SCENE_MAX_FAULTS;
}

int32_t ss_scene_report_total(const ss_scene_report *report)
{
    return report->count + report->dropped;
}

void ss_scene_report_flush(ss_scene_report *report, softsim_error *error)
{
    /* Insertion sort: stable, and there are at most SS_SCENE_MAX_FAULTS. */
    for (int32_t i = 1; i < report->count; i++) {
        const ss_scene_fault moving = report->fault[i];
        int32_t j = i;
        for (; j > 0 && report->fault[j - 1].order > moving.order; j--) {
            report->fault[j] = report->fault[j - 1];
        }
        report->fault[j] = moving;
    }
    for (int32_t i = 0; i < report->count; i++) {
        softsim_error_append(error, report->fault[i].status, report->fault[i].text);
        free(report->fault[i].text);
    }
    for (int32_t i = 0; i < report->dropped; i++) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "a further fault of the scene");
    }
    report->count = 0;
    report->dropped = 0;
}
