/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "obj.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "beside.h"
#include "rt/files.h"

/* A vertex line for assimp: three numbers of nine digits and three of at most four. Of a word in an
 * error: MAX_SHOWN. */
enum { MAX_LINE = 80, MAX_SHOWN = 20, NUMBER_BITS = 12, NUMBER_MASK = (1 << NUMBER_BITS) - 1 };

static char problem[160];

static const char *blame(int64_t line, const char *what)
{
    (void)snprintf(problem, sizeof problem, ":%lld: %s", (long long)line, what);
    return problem;
}

/* With a zero behind it. NULL with what is wrong. */
static char *read_file(const char *path, size_t *out_size, const char **out_problem)
{
    int64_t size = 0;
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, &size, &why);
    if (file == NULL) {
        (void)snprintf(problem, sizeof problem, "cannot read it (%s)", why);
        *out_problem = problem;
        return NULL;
    }
    char *text = malloc((size_t)size + 1);
    *out_size = text != NULL ? fread(text, 1, (size_t)size, file) : 0;
    *out_problem = beside_no_memory;
    (void)fclose(file);
    if (text != NULL) {
        text[*out_size] = '\0';
    }
    return text;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Reads all numbers of begin..end, of any length, and keeps the first `room`. At `end` is a line's
 * end, a comment or the text's zero. NULL, or the word that is no number. */
static const char *read_numbers(const char *begin, const char *end, int room, double *out,
                                int *out_count)
{
    *out_count = 0;
    for (const char *at = begin; at < end; ++at) {
        if (is_blank(*at)) {
            continue;
        }
        char *stop = NULL;
        const double value = strtod(at, &stop);
        if (stop == at || stop > end || (stop < end && !is_blank(*stop))) {
            return at;
        }
        if (*out_count < room) {
            out[*out_count] = value;
        }
        ++*out_count;
        at = stop;
    }
    return NULL;
}

/* x y z, x y z w (homogeneous), or x y z and a colour; `start` is the line's. */
static const char *read_position(const char *start, const char *begin, const char *end,
                                 int64_t line, double out[3])
{
    double value[7] = {0.0};
    char what[120];
    int count = 0;
    const char *bad = read_numbers(begin, end, 7, value, &count);
    if (bad != NULL) {
        int length = 0;
        while (bad + length < end && !is_blank(bad[length]) && length < MAX_SHOWN) {
            ++length;
        }
        (void)snprintf(what, sizeof what, "column %lld: '%.*s' is not a number: correct it",
                       (long long)(bad - start) + 1, length, bad);
        return blame(line, what);
    }
    if (count < 3 || count == 5 || count > 7) {
        (void)snprintf(what, sizeof what,
                       "a vertex has three numbers, x y z, then a weight or a colour; this has %d: "
                       "correct it",
                       count);
        return blame(line, what);
    }
    for (int k = 0; k < 3; ++k) {
        out[k] = count == 4 ? value[k] / value[3] : value[k];
        if (!(fabs(out[k]) < 1e30)) {
            return blame(line, "the position of this vertex is not finite: correct it");
        }
    }
    return NULL;
}

static bool starts_with(const char *begin, const char *end, const char *word)
{
    const size_t length = strlen(word);
    return (size_t)(end - begin) > length && memcmp(begin, word, length) == 0 &&
           is_blank(begin[length]);
}

static int64_t count_vertices(const char *text, const char *end)
{
    int64_t count = 0;
    for (const char *at = text; at < end; ++at) {
        count += (at == text || at[-1] == '\n' || is_blank(at[-1])) && starts_with(at, end, "v");
    }
    return count;
}

/* assimp crashes on one of less; a line that goes on in the next may have its corners there. */
static bool has_three_corners(const char *begin, const char *end)
{
    int words = 0;
    for (const char *at = begin; at < end; ++at) {
        words += !is_blank(*at) && is_blank(at[-1]);
    }
    return words >= 3 || memchr(begin, '\\', (size_t)(end - begin)) != NULL;
}

/* One line, without its comment, from start to end. */
static const char *rewrite_line(obj_text *out, const char *start, const char *end, int64_t line)
{
    const char *begin = start;
    while (begin < end && is_blank(*begin)) {
        ++begin;
    }
    if (starts_with(begin, end, "v")) {
        const int64_t number = out->count;
        double *x = out->position[number];
        const char *fault = read_position(start, begin + 1, end, line, x);
        if (fault != NULL) {
            return fault;
        }
        const int length =
            snprintf(out->text + out->size, MAX_LINE, "v %.9g %.9g %.9g %d %d %d\n", x[0], x[1],
                     x[2], (int)(number & NUMBER_MASK), (int)(number >> NUMBER_BITS & NUMBER_MASK),
                     (int)(number >> 2 * NUMBER_BITS));
        out->size += (size_t)length;
        ++out->count;
    } else if (starts_with(begin, end, "f") && !has_three_corners(begin + 1, end)) {
        return blame(line, "a face needs three corners or more: correct it, or copy the file once "
                           "more where it is cut off");
    } else if (!starts_with(begin, end, "mtllib") && !starts_with(begin, end, "usemtl")) {
        memcpy(out->text + out->size, begin, (size_t)(end - begin));
        out->size += (size_t)(end - begin);
        out->text[out->size++] = '\n';
    }
    return NULL;
}

const char *obj_prepare(const char *path, obj_text *out)
{
    size_t size = 0;
    const char *unread = NULL;
    char *text = read_file(path, &size, &unread);
    if (text == NULL) {
        return unread;
    }
    const char *end = text + size;
    const int64_t count = count_vertices(text, end);
    *out = (obj_text){0};
    out->text = malloc(size + 2 + MAX_LINE * ((size_t)count + 1));
    out->position = malloc(((size_t)count + 1) * sizeof *out->position);
    if (out->text == NULL || out->position == NULL) {
        return beside_no_memory;
    }
    int64_t line = 0;
    const bool has_mark = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0;
    for (const char *at = text + (has_mark ? 3 : 0); at < end;) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        const char *next = newline != NULL ? newline : end;
        const char *comment = memchr(at, '#', (size_t)(next - at));
        const char *fault = rewrite_line(out, at, comment != NULL ? comment : next, ++line);
        if (fault != NULL) {
            return fault;
        }
        at = next + 1;
    }
    free(text);
    return out->count > 0 ? NULL : "no vertices in it: give an OBJ file with v and f lines";
}

int64_t obj_number(float red, float green, float blue)
{
    /* Colours that are not ours: no vertex. */
    const float part[3] = {red, green, blue};
    for (int k = 0; k < 3; ++k) {
        if (!(part[k] >= 0.0F && part[k] <= (float)NUMBER_MASK)) {
            return -1;
        }
    }
    return (int64_t)red | (int64_t)green << NUMBER_BITS | (int64_t)blue << 2 * NUMBER_BITS;
}
