/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "obj.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"

/* A vertex line for assimp: three numbers of nine digits and three of at most four. */
enum { MAX_LINE = 80, MAX_NUMBER = 63, NUMBER_BITS = 12, NUMBER_MASK = (1 << NUMBER_BITS) - 1 };

static char problem[160];
const char obj_no_memory[] = "out of memory";

static const char *blame(int64_t line, const char *what)
{
    (void)snprintf(problem, sizeof problem, ":%lld: %s", (long long)line, what);
    return problem;
}

/* NULL with what is wrong. */
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
    *out_problem = obj_no_memory;
    (void)fclose(file);
    return text;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Takes up to `max` numbers off begin..end; returns how many, or -1 for anything else there. */
static int read_numbers(const char *begin, const char *end, int max, double *out)
{
    int count = 0;
    for (const char *at = begin; at < end;) {
        char word[MAX_NUMBER + 1];
        size_t length = 0;
        while (at < end && is_blank(*at)) {
            ++at;
        }
        while (at < end && !is_blank(*at) && length < MAX_NUMBER) {
            word[length++] = *at++;
        }
        if (length == 0) {
            break;
        }
        word[length] = '\0';
        char *stop = NULL;
        const double value = strtod(word, &stop);
        if (stop != word + length || count == max) {
            return -1;
        }
        out[count++] = value;
    }
    return count;
}

/* x y z, x y z w (homogeneous), or x y z and a colour. */
static const char *read_position(const char *begin, const char *end, int64_t line, double out[3])
{
    double value[7] = {0.0};
    const int count = read_numbers(begin, end, 7, value);
    if (count < 3 || count == 5) {
        return blame(line, "a vertex needs three numbers, x y z: correct it");
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

/* One line, without its comment, from begin to end. */
static const char *rewrite_line(obj_text *out, const char *begin, const char *end, int64_t line)
{
    while (begin < end && is_blank(*begin)) {
        ++begin;
    }
    if (starts_with(begin, end, "v")) {
        const int64_t number = out->count;
        double *x = out->position[number];
        const char *fault = read_position(begin + 1, end, line, x);
        if (fault != NULL) {
            return fault;
        }
        const int length =
            snprintf(out->text + out->size, MAX_LINE, "v %.9g %.9g %.9g %d %d %d\n", x[0], x[1],
                     x[2], (int)(number & NUMBER_MASK), (int)(number >> NUMBER_BITS & NUMBER_MASK),
                     (int)(number >> 2 * NUMBER_BITS));
        out->size += (size_t)length;
        ++out->count;
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
        return obj_no_memory;
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
