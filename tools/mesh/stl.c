/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "stl.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "rt/files.h"

enum { HEAD_BYTES = 80, COUNT_BYTES = 4, TRIANGLE_BYTES = 50, START_BYTES = 512, MAX_WORD = 16 };
#define AGAIN "copy it, or write it, once more"

static char problem[200];

static const char *check_binary(const unsigned char *start, size_t count, int64_t size)
{
    const int64_t head = HEAD_BYTES + COUNT_BYTES;
    if (count < HEAD_BYTES + COUNT_BYTES) {
        return NULL; /* of no kind that can be told */
    }
    const unsigned char *c = start + HEAD_BYTES;
    const int64_t promised = c[0] | c[1] << 8 | c[2] << 16 | (int64_t)c[3] << 24;
    const int64_t there = (size - head) / TRIANGLE_BYTES;
    if (there >= promised) {
        return NULL;
    }
    (void)snprintf(problem, sizeof problem,
                   "it is cut off: its header says %lld triangles, and %lld are there: " AGAIN,
                   (long long)promised, (long long)there);
    return problem;
}

typedef struct text {
    char word[MAX_WORD];
    size_t length;
    int64_t line, begun, ended;
    bool is_after_facet, is_closed, is_name; /* the rest of the line is a body's name */
} text;

static void take_word(text *t)
{
    if (t->length == 0 || t->is_name) {
        t->length = 0;
        return;
    }
    t->word[t->length < MAX_WORD ? t->length : MAX_WORD - 1] = '\0';
    const bool ends = strcasecmp(t->word, "endsolid") == 0;
    t->is_name = ends || strcasecmp(t->word, "solid") == 0;
    t->is_closed = ends || (t->is_closed && !t->is_name);
    t->begun += t->is_after_facet && strcasecmp(t->word, "normal") == 0;
    t->ended += strcasecmp(t->word, "endfacet") == 0;
    t->is_after_facet = strcasecmp(t->word, "facet") == 0;
    t->length = 0;
}

static const char *check_text(FILE *file)
{
    text t = {.line = 1};
    for (int c = getc(file); c != EOF; c = getc(file)) {
        if (isspace(c)) {
            take_word(&t);
            t.line += c == '\n';
            t.is_name = t.is_name && c != '\n' && c != '\r';
        } else {
            t.word[t.length < MAX_WORD ? t.length : MAX_WORD - 1] = (char)c;
            ++t.length;
        }
    }
    take_word(&t);
    if (t.is_closed && t.begun == t.ended) {
        return NULL;
    }
    const bool is_within = t.begun > t.ended;
    (void)snprintf(problem, sizeof problem,
                   ":%lld: it is cut off: %s after %lld whole triangles: " AGAIN "%s",
                   (long long)t.line, is_within ? "it ends within a triangle" : "no endsolid",
                   (long long)t.ended, is_within ? "" : ", or add endsolid if all is there");
    return problem;
}

/* A text begins with "solid"; so may the head of a binary file, whose count has a zero in it. */
const char *stl_check(const char *path)
{
    int64_t size = 0;
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, &size, &why);
    if (file == NULL) {
        return NULL; /* assimp says so */
    }
    unsigned char start[START_BYTES + 1] = {0};
    const size_t count = fread(start, 1, START_BYTES, file);
    const char *found = NULL, *first = (const char *)start;
    first += strncmp(first, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    if (memchr(start, '\0', count) != NULL) {
        found = check_binary(start, count, size);
    } else if (strncasecmp(first + strspn(first, " \t\r\n"), "solid", 5) == 0) {
        (void)fseek(file, first - (const char *)start, SEEK_SET);
        found = check_text(file);
    }
    (void)fclose(file);
    return found;
}
