/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A text is walked through by its words, as assimp does. `solid` opens a body at the start of a
 * line alone: it may be a word of a name or of a remark. `endsolid` closes it, or `end solid`, as
 * `end facet` does a triangle. Behind `endsolid` assimp skips what is left of the line, and reads
 * on only where `solid` is the next word; after `end solid` it reads on always. A zero ends the
 * text.
 */
#include "stl.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "rt/files.h"

enum { COUNT_AT = 80, HEAD_BYTES = 84, TRIANGLE_BYTES = 50, MAX_WORD = 16 };
#define AGAIN "copy it, or write it, once more"

static char problem[200];

static int64_t count_promised(const unsigned char head[HEAD_BYTES])
{
    const unsigned char *c = head + COUNT_AT;
    return c[0] | c[1] << 8 | c[2] << 16 | (int64_t)c[3] << 24;
}

static const char *check_binary(const unsigned char head[HEAD_BYTES], int64_t size)
{
    const int64_t promised = count_promised(head);
    const int64_t there = (size - HEAD_BYTES) / TRIANGLE_BYTES;
    if (there >= promised) {
        return NULL;
    }
    (void)snprintf(problem, sizeof problem,
                   "it is cut off: its header says %lld triangles, and %lld are there: " AGAIN,
                   (long long)promised, (long long)there);
    return problem;
}

typedef enum place {
    BODY,
    NAME,    /* the next word of the line is a body's name */
    HEAD,    /* behind it in its line: more of the name, or a triangle */
    TAIL,    /* behind `endsolid` in its line */
    BETWEEN, /* behind that line */
    OVER     /* what assimp does not read */
} place;

typedef struct text {
    char word[MAX_WORD], before[MAX_WORD]; /* `before`: the word before it */
    size_t length;
    place place;
    bool is_first, is_closed;              /* the word is its line's first; no body is open */
    int64_t line, end_line;                /* end_line: of the last endsolid */
    int64_t begun, corners, ended, unread; /* of triangles; `unread`: those that assimp skips */
} text;

static bool is_word(const char *word, const char *expected)
{
    return strcasecmp(word, expected) == 0;
}

static bool begins_triangle(const text *t)
{
    return is_word(t->word, "normal") && is_word(t->before, "facet");
}

static bool ends_triangle(const text *t)
{
    return is_word(t->word, "endfacet") || (is_word(t->word, "facet") && is_word(t->before, "end"));
}

/* A word of a body, or behind its name's first. */
static void take_inner(text *t)
{
    const bool is_solid = is_word(t->word, "solid");
    if (is_solid && t->is_first) {
        t->place = NAME;
        t->is_closed = false;
    } else if (is_solid && is_word(t->before, "end")) {
        t->is_closed = true;
    } else if (is_word(t->word, "endsolid")) {
        t->place = TAIL;
        t->is_closed = true;
        t->end_line = t->line;
    } else if (begins_triangle(t)) {
        t->place = BODY;
        t->is_closed = false;
        ++t->begun;
    } else if (ends_triangle(t)) {
        ++t->ended;
    } else if (t->place == BODY && is_word(t->word, "vertex")) {
        ++t->corners;
    }
}

static void take_word(text *t)
{
    if (t->length == 0) {
        return;
    }
    t->word[t->length < MAX_WORD ? t->length : MAX_WORD - 1] = '\0';
    t->length = 0;
    if (t->place == BETWEEN) {
        t->place = t->is_first && is_word(t->word, "solid") ? BODY : OVER;
    }
    if (t->place == NAME) {
        t->place = HEAD;
        t->word[0] = '\0'; /* it is no word of the format */
    } else if (t->place == TAIL) {
        t->unread += ends_triangle(t); /* their beginnings may be words of the name */
    } else if (t->place == OVER) {
        t->unread += begins_triangle(t);
    } else {
        take_inner(t);
    }
    memcpy(t->before, t->word, sizeof t->before);
    t->is_first = false;
}

static void take_character(text *t, int c)
{
    const bool is_line_end = c == '\n' || c == '\r';
    if (c != '\0' && c != ' ' && c != '\t' && !is_line_end) {
        t->word[t->length < MAX_WORD ? t->length : MAX_WORD - 1] = (char)c;
        ++t->length;
        return;
    }
    take_word(t);
    t->line += c == '\n';
    t->is_first = t->is_first || is_line_end;
    if (c == '\0') {
        t->place = OVER;
    } else if (is_line_end && (t->place == NAME || t->place == HEAD)) {
        t->place = BODY;
    } else if (is_line_end && t->place == TAIL) {
        t->place = BETWEEN;
    }
}

static const char *blame(const text *t)
{
    const bool is_within = t->begun > t->ended;
    if (is_within || !t->is_closed) {
        (void)snprintf(problem, sizeof problem,
                       ":%lld: it is cut off: %s after %lld whole triangles: " AGAIN "%s",
                       (long long)t->line, is_within ? "it ends within a triangle" : "no endsolid",
                       (long long)t->ended, is_within ? "" : ", or add endsolid if all is there");
    } else if (t->unread > 0) {
        (void)snprintf(problem, sizeof problem,
                       ":%lld: what is behind this endsolid is not read, and %lld triangles are "
                       "there: let the next line begin with solid",
                       (long long)t->end_line, (long long)t->unread);
    } else if (t->begun != t->ended || t->corners != 3 * t->ended) {
        (void)snprintf(
            problem, sizeof problem,
            "its %lld facet normal, %lld vertex and %lld endfacet do not make triangles: "
            "write it once more, or as OBJ",
            (long long)t->begun, (long long)t->corners, (long long)t->ended);
    } else {
        return NULL;
    }
    return problem;
}

static const char *check_text(FILE *file)
{
    text t = {.line = 1, .is_first = true};
    for (int c = getc(file); c != EOF; c = getc(file)) {
        take_character(&t, c);
    }
    take_word(&t);
    return blame(&t);
}

/* A text begins with "solid"; so may the head of a binary file, whose count has a zero in it, or
 * fits the file's size. */
const char *stl_check(const char *path)
{
    int64_t size = 0;
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, &size, &why);
    if (file == NULL) {
        return NULL; /* assimp says so */
    }
    unsigned char head[HEAD_BYTES + 1] = {0};
    const size_t count = fread(head, 1, HEAD_BYTES, file);
    const bool is_binary =
        count == HEAD_BYTES && (memchr(head, '\0', count) != NULL ||
                                size == HEAD_BYTES + TRIANGLE_BYTES * count_promised(head));
    const char *found = NULL, *first = (const char *)head;
    first += strncmp(first, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    if (is_binary) {
        found = check_binary(head, size);
    } else if (strncasecmp(first + strspn(first, " \t\r\n"), "solid", 5) == 0) {
        (void)fseek(file, first - (const char *)head, SEEK_SET);
        found = check_text(file);
    }
    (void)fclose(file);
    return found;
}
