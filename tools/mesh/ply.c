/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The header lists elements with their counts, and of each the properties: numbers of a type, or
 * lists of so many. The body is walked through by these, in memory: of a text, an element is a
 * line, with at least its numbers; what more is there, assimp skips. What goes to assimp is packed
 * over what was read: elements that it knows, as it does not step over others; of a text, a line
 * for each, as it takes an empty line for an element, and goes on with the line before where the
 * last has no end. What the numbers mean is assimp's.
 */
#include "ply.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "beside.h"
#include "rt/files.h"

enum { MAX_LINE = 512, MAX_NAME = 32, MAX_ELEMENTS = 16, MAX_PROPERTIES = 256 };
#define BLANKS    " \t"
#define LINE_ENDS "\r\n\f" /* to assimp; so is a zero */

typedef struct property {
    int count_bytes, bytes; /* of a list's count, 0: it is none; of a number */
    int64_t most_count;     /* that its type holds: what is read beyond it was below zero */
} property;

typedef struct element {
    char name[MAX_NAME];
    int64_t count;
    int properties;
    property property[MAX_PROPERTIES];
} element;

typedef struct ply {
    FILE *file;
    int64_t line; /* of a text, so many are behind */
    char *at;     /* what is next in the body; a zero is behind it all */
    const char *end;
    char *out; /* where the next goes: at most at `at`, but for the last line's end */
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
            if (q->count_bytes <= 0 || q->count_bytes > 4 || strncmp(counted, "float", 5) == 0) {
                return false;
            }
            q->most_count = ((int64_t)1 << (8 * q->count_bytes - (counted[0] != 'u'))) - 1;
            return q->bytes > 0;
        }
        q->bytes = sscanf(line, "property %31s", type) == 1 ? bytes_of(type) : 0;
        return q->bytes > 0;
    }
    return strncmp(line, "comment", 7) == 0 || strncmp(line, "obj_info", 8) == 0;
}

/* Without the blanks around it; what is too long is left out, as of a comment. False at the file's
 * end. */
static bool read_line(ply *p, char out[MAX_LINE])
{
    int length = 0;
    int c = getc(p->file);
    for (; c != EOF && c != '\n' && c != '\r'; c = getc(p->file)) {
        out[length] = c == '\t' ? ' ' : (char)c;
        length += length < MAX_LINE - 1 && (length > 0 || out[0] != ' ');
    }
    while (length > 0 && out[length - 1] == ' ') {
        --length;
    }
    out[length] = '\0';
    const int next = c == '\r' ? getc(p->file) : EOF;
    if (next != EOF && next != '\n') {
        (void)ungetc(next, p->file);
    }
    ++p->line;
    return c != EOF;
}

typedef enum header { IS_NO_PLY, IS_UNKNOWN, IS_CUT, IS_TOLD } header;

/* The file is then at its body. */
static header read_header(ply *p)
{
    char line[MAX_LINE];
    bool is_told = true;
    if (!read_line(p, line) || strcasecmp(line, "ply") != 0) {
        return IS_NO_PLY;
    }
    while (read_line(p, line)) {
        if (strncmp(line, "end_header", 10) == 0) {
            return is_told ? IS_TOLD : IS_UNKNOWN;
        }
        if (is_told && line[0] != '\0' && !take_line(p, line)) {
            is_told = false;
            (void)snprintf(problem, sizeof problem,
                           ":%lld: '%.60s' is no line of a header that is known here: correct it, "
                           "or write the file as STL",
                           (long long)p->line, line);
        }
    }
    return IS_CUT;
}

/* A number of the body, which is a list's count where `out_count` is given. */
static bool take_number(ply *p, int bytes, int64_t *out_count)
{
    uint64_t value = 0;
    if (p->is_text) {
        p->at += strspn(p->at, BLANKS);
        const size_t length = strcspn(p->at, BLANKS LINE_ENDS);
        if (length > 0 && out_count != NULL) {
            *out_count = strtoll(p->at, NULL, 10);
        }
        p->at += length;
        return length > 0;
    }
    if (p->end - p->at < bytes) {
        return false;
    }
    for (int k = 0; k < bytes; ++k) {
        const int byte = p->is_big_endian ? bytes - 1 - k : k;
        value |= (uint64_t)(unsigned char)p->at[byte] << 8 * k;
    }
    p->at += bytes;
    if (out_count != NULL) {
        *out_count = (int64_t)value;
    }
    return true;
}

/* A face whose first list is empty has no corners, which assimp does not bear. */
static bool take_properties(ply *p, const element *e)
{
    int64_t least = strcmp(e->name, "face") == 0;
    for (int k = 0; k < e->properties; ++k) {
        const property *q = &e->property[k];
        int64_t count = 1;
        if (q->count_bytes > 0 && (!take_number(p, q->count_bytes, &count) || count < least ||
                                   (!p->is_text && count > q->most_count))) {
            return false;
        }
        least = q->count_bytes > 0 ? 0 : least;
        for (int64_t i = 0; i < count; ++i) {
            if (!take_number(p, q->bytes, NULL)) {
                return false;
            }
        }
    }
    return true;
}

/* To what is written next in a text; false at its end. */
static bool skip_blanks(ply *p)
{
    for (; p->at < p->end && (*p->at == '\0' || isspace((unsigned char)*p->at)); ++p->at) {
        p->line += *p->at == '\n';
    }
    return p->at < p->end;
}

static bool is_known(const element *e)
{
    static const char *const names[] = {"vertex", "face", "tristrips", "edge", "material"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (strcmp(e->name, names[i]) == 0) {
            return true;
        }
    }
    return false;
}

static bool take_element(ply *p, const element *e)
{
    if (p->is_text && !skip_blanks(p)) {
        return false;
    }
    const char *begin = p->at;
    if (!take_properties(p, e)) {
        return false;
    }
    p->at += p->is_text ? strcspn(p->at, LINE_ENDS) : 0;
    const size_t size = (size_t)(p->at - begin);
    if (p->is_text && p->at < p->end) {
        p->line += *p->at++ == '\n';
    }
    if (is_known(e)) {
        memmove(p->out, begin, size);
        p->out += size;
        if (p->is_text) {
            *p->out++ = '\n';
        }
    }
    return true;
}

/* Why the element behind the first `there` is not whole. */
static const char *blame(ply *p, const element *e, int64_t there)
{
    const int64_t line = p->line + 1;
    if (p->is_text && skip_blanks(p)) {
        (void)snprintf(problem, sizeof problem,
                       ":%lld: fewer numbers than its header says of element %s: correct the line "
                       "or the header",
                       (long long)line, e->name);
    } else {
        (void)snprintf(problem, sizeof problem,
                       "it is cut off: its header says %lld of element %s, and %lld are whole: "
                       "copy it, or write it, once more%s",
                       (long long)e->count, e->name, (long long)there,
                       p->is_text ? ", each on a line" : "");
    }
    return problem;
}

const char *ply_prepare(const char *path, char **out_text, size_t *out_size)
{
    static ply p;
    int64_t size = 0;
    const char *why = NULL;
    p = (ply){.file = ss_files_open_stream(path, &size, &why)};
    *out_text = NULL;
    const header found = p.file != NULL ? read_header(&p) : IS_NO_PLY;
    if (found != IS_TOLD) {
        /* assimp says of another what it is, and reads such a header without end. */
        return found == IS_NO_PLY ? NULL
               : found == IS_CUT  ? "it is cut off: its header has no line end_header: copy it, or "
                                    "write it, once more"
                                  : problem;
    }
    const long head = ftell(p.file);
    char *text = malloc((size_t)size + 2); /* a line's end and a zero more */
    if (text == NULL) {
        return beside_no_memory;
    }
    rewind(p.file);
    p.end = text + fread(text, 1, (size_t)size, p.file);
    (void)fclose(p.file);
    text[p.end - text] = '\0';
    p.at = p.out = text + head;
    for (int i = 0; i < p.elements; ++i) {
        const element *e = &p.element[i];
        for (int64_t there = 0; e->properties > 0 && there < e->count; ++there) {
            if (!take_element(&p, e)) {
                return blame(&p, e, there);
            }
        }
    }
    *out_text = text;
    *out_size = (size_t)(p.out - text);
    return NULL;
}
