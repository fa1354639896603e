/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The header lists elements with their counts, and of each the properties: numbers of a type, or
 * lists of so many. The body is walked through by these, number by number; what they mean is
 * assimp's.
 */
#include "ply.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"

enum { MAX_LINE = 512, MAX_NAME = 32, MAX_ELEMENTS = 16, MAX_PROPERTIES = 64, MAX_TOKEN = 64 };

typedef struct property {
    int count_bytes, bytes; /* of a list's count, 0: it is none; of a number */
} property;

typedef struct element {
    char name[MAX_NAME];
    int64_t count;
    int properties;
    property property[MAX_PROPERTIES];
} element;

typedef struct ply {
    FILE *file;
    bool is_text, is_big_endian;
    int elements;
    element element[MAX_ELEMENTS];
} ply;

static char problem[200];

/* 0: no type. */
static int bytes_of(const char *type)
{
    static const struct {
        const char *name;
        int bytes;
    } types[] = {{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},
                 {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
                 {"int", 4},   {"uint", 4},    {"int32", 4},  {"uint32", 4},
                 {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        if (strcmp(types[i].name, type) == 0) {
            return types[i].bytes;
        }
    }
    return 0;
}

/* One line of the header; false when it is of no kind that can be told. */
static bool take_line(ply *p, const char *line)
{
    char type[MAX_NAME], counted[MAX_NAME];
    long long count = 0;
    element *last = p->elements > 0 ? &p->element[p->elements - 1] : NULL;
    if (sscanf(line, "format %31s", type) == 1) {
        p->is_text = strcmp(type, "ascii") == 0;
        p->is_big_endian = strcmp(type, "binary_big_endian") == 0;
        return p->is_text || p->is_big_endian || strcmp(type, "binary_little_endian") == 0;
    }
    if (strncmp(line, "element ", 8) == 0) {
        if (p->elements == MAX_ELEMENTS) {
            return false;
        }
        element *e = &p->element[p->elements++];
        *e = (element){.count = 0};
        const bool is_read = sscanf(line, "element %31s %lld", e->name, &count) == 2 && count >= 0;
        e->count = count;
        return is_read;
    }
    if (strncmp(line, "property ", 9) == 0) {
        if (last == NULL || last->properties == MAX_PROPERTIES) {
            return false;
        }
        property *q = &last->property[last->properties++];
        *q = (property){.count_bytes = 0};
        if (sscanf(line, "property list %31s %31s", counted, type) == 2) {
            q->count_bytes = bytes_of(counted);
            q->bytes = bytes_of(type);
            return q->count_bytes > 0 && q->count_bytes <= 4 && strncmp(counted, "float", 5) != 0 &&
                   q->bytes > 0;
        }
        q->bytes = sscanf(line, "property %31s", type) == 1 ? bytes_of(type) : 0;
        return q->bytes > 0;
    }
    return strncmp(line, "ply", 3) == 0 || strncmp(line, "comment", 7) == 0 ||
           strncmp(line, "obj_info", 8) == 0;
}

/* The file is then at its body. */
static bool read_header(ply *p)
{
    char line[MAX_LINE];
    bool is_first = true;
    while (fgets(line, sizeof line, p->file) != NULL) {
        if (strncmp(line, "end_header", 10) == 0) {
            return !is_first;
        }
        if ((is_first && strncmp(line, "ply", 3) != 0) || !take_line(p, line)) {
            return false;
        }
        is_first = false;
    }
    return false;
}

static bool take_token(FILE *file, char token[MAX_TOKEN])
{
    int c = getc(file);
    while (c != EOF && isspace(c)) {
        c = getc(file);
    }
    int length = 0;
    for (; c != EOF && !isspace(c); c = getc(file)) {
        token[length] = (char)c;
        length += length < MAX_TOKEN - 1;
    }
    token[length] = '\0';
    return length > 0;
}

/* A number of the body, which is a list's count where `out_count` is given. */
static bool take_number(const ply *p, int bytes, int64_t *out_count)
{
    char token[MAX_TOKEN];
    unsigned char raw[8] = {0};
    uint64_t value = 0;
    if (p->is_text) {
        const bool is_there = take_token(p->file, token);
        if (is_there && out_count != NULL) {
            *out_count = strtoll(token, NULL, 10);
        }
        return is_there;
    }
    if (fread(raw, 1, (size_t)bytes, p->file) != (size_t)bytes) {
        return false;
    }
    for (int k = 0; k < bytes; ++k) {
        value |= (uint64_t)raw[p->is_big_endian ? bytes - 1 - k : k] << 8 * k;
    }
    if (out_count != NULL) {
        *out_count = (int64_t)value;
    }
    return true;
}

static bool take_element(const ply *p, const element *e)
{
    for (int k = 0; k < e->properties; ++k) {
        const property *q = &e->property[k];
        int64_t count = 1;
        if (q->count_bytes > 0 && !take_number(p, q->count_bytes, &count)) {
            return false;
        }
        for (int64_t i = 0; i < count; ++i) {
            if (!take_number(p, q->bytes, NULL)) {
                return false;
            }
        }
    }
    return true;
}

const char *ply_check(const char *path)
{
    static ply p;
    int64_t size = 0;
    const char *why = NULL, *found = NULL;
    p = (ply){.file = ss_files_open_stream(path, &size, &why)};
    if (p.file == NULL) {
        return NULL; /* assimp says so */
    }
    const bool is_told = read_header(&p);
    for (int i = 0; is_told && i < p.elements && found == NULL; ++i) {
        const element *e = &p.element[i];
        int64_t there = 0;
        while (e->properties > 0 && there < e->count && take_element(&p, e)) {
            ++there;
        }
        if (e->properties > 0 && there < e->count) {
            (void)snprintf(problem, sizeof problem,
                           "it is cut off: its header says %lld of element %s, and %lld are whole: "
                           "copy it, or write it, once more",
                           (long long)e->count, e->name, (long long)there);
            found = problem;
        }
    }
    (void)fclose(p.file);
    return found;
}
