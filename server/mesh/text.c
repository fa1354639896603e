/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A window over a file: [at, end) are the bytes read and not yet taken, `end_offset` is the place
 * of `end` in the file. When a piece runs into `end`, what is left moves to the window's start and
 * the rest of it is filled. In memory the window is the whole text and never moves.
 */
#include "mesh/text.h"

#include "rt/memory.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

static bool is_space(char c)
{
    return is_blank(c) || c == '\n';
}

/* ---- faults ---- */

static void add_fault(ss_text *text, softsim_status status, const char *place, const char *format,
                      va_list arguments)
{
    char what[1024];
    if (text->has_failed) {
        return; /* what is missed now was said */
    }
    (void)vsnprintf(what, sizeof what, format, arguments);
    ++text->fault_count;
    text->status = text->status == SOFTSIM_OK ? status : text->status;
    softsim_error_add(text->error, status, "%s:%s %s", text->name, place, what);
}

void ss_text_fault(ss_text *text, const char *format, ...)
{
    char place[48];
    if (text->is_binary) {
        (void)snprintf(place, sizeof place, " byte %lld:", (long long)ss_text_here(text).offset);
    } else {
        (void)snprintf(place, sizeof place, "%d:", text->line);
    }
    va_list arguments;
    va_start(arguments, format);
    add_fault(text, SOFTSIM_ERROR_FORMAT, place, format, arguments);
    va_end(arguments);
}

bool ss_text_fault_short(ss_text *text, int64_t count, const char *of, const char *what)
{
    ss_text_fault(text,
                  "%lld %s%s announced, but the rest of the file is too short for them: it is "
                  "damaged or cut off",
                  (long long)count, of, what);
    return false;
}

void ss_text_fault_file(ss_text *text, softsim_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_fault(text, status, "", format, arguments);
    va_end(arguments);
}

bool ss_text_out_of_memory(ss_text *text)
{
    ss_text_fault_file(text, SOFTSIM_ERROR_MEMORY, "out of memory");
    return false;
}

/* ---- the window ---- */

void ss_text_init(ss_text *text, const char *memory, size_t size, const char *name,
                  softsim_error *error)
{
    *text = (ss_text){.name = name,
                      .error = error,
                      .stop = '\n',
                      .at = memory,
                      .end = memory + size,
                      .end_offset = (int64_t)size,
                      .size = (int64_t)size,
                      .memory = memory,
                      .fd = -1};
}

bool ss_text_open(ss_text *text, int fd, int64_t size, size_t window, const char *name,
                  softsim_error *error)
{
    *text = (ss_text){
        .name = name, .error = error, .stop = '\n', .size = size, .fd = fd, .window_size = window};
    text->window = ss_memory_get(window, 1);
    text->at = text->window;
    text->end = text->window;
    return text->window != NULL ? true : ss_text_out_of_memory(text);
}

void ss_text_fini(ss_text *text)
{
    ss_memory_free(text->window);
    text->window = NULL;
}

/* Reads on; false at the end of the file, or when the window is full of one piece. A file that
 * shrank meanwhile ends there. */
static bool refill(ss_text *text)
{
    if (text->window == NULL || text->has_failed || text->end_offset >= text->size) {
        return false;
    }
    const size_t kept = (size_t)(text->end - text->at);
    if (kept == text->window_size) {
        ss_text_fault(text,
                      "more than %d bytes without an end of line: write the file in shorter "
                      "lines",
                      (int)text->window_size);
        text->has_failed = true;
        return false;
    }
    memmove(text->window, text->at, kept);
    text->at = text->window;
    text->end = text->window + kept;
    ssize_t count;
    do {
        count = pread(text->fd, text->window + kept, text->window_size - kept, text->end_offset);
    } while (count < 0 && errno == EINTR);
    if (count <= 0) {
        if (count < 0) {
            ss_text_fault_file(text, SOFTSIM_ERROR_FILE,
                               "cannot read it (%s): check the disk and its rights",
                               strerror(errno));
            text->has_failed = true;
        }
        text->size = text->end_offset;
        return false;
    }
    text->end += count;
    text->end_offset += count;
    return true;
}

ss_text_mark ss_text_here(const ss_text *text)
{
    return (ss_text_mark){.offset = text->end_offset - (text->end - text->at),
                          .newlines = text->newlines};
}

void ss_text_seek(ss_text *text, ss_text_mark mark)
{
    text->newlines = mark.newlines;
    text->line = mark.newlines + 1;
    if (text->memory != NULL) {
        text->at = text->memory + mark.offset;
        return;
    }
    text->at = text->window;
    text->end = text->window;
    text->end_offset = mark.offset;
}

int64_t ss_text_left(const ss_text *text)
{
    return text->size - ss_text_here(text).offset;
}

/* ---- pieces ---- */

/* Finds `stop` from `at` on, filling the window as needed; NULL when it does not come. */
static const char *find_stop(ss_text *text, char stop)
{
    size_t seen = 0;
    for (;;) {
        const size_t there = (size_t)(text->end - text->at);
        const char *found = there > seen ? memchr(text->at + seen, stop, there - seen) : NULL;
        if (found != NULL) {
            return found;
        }
        seen = there;
        if (!refill(text)) {
            return NULL;
        }
    }
}

bool ss_text_line(ss_text *text, ss_text_span *out)
{
    const char *newline = find_stop(text, '\n');
    if (newline == NULL && (text->at == text->end || text->has_failed)) {
        return false;
    }
    out->begin = text->at;
    out->end = newline != NULL ? newline : text->end;
    text->at = newline != NULL ? newline + 1 : text->end;
    text->line = ++text->newlines;
    return true;
}

bool ss_text_next_line(ss_text *text, ss_text_span *out)
{
    while (ss_text_line(text, out)) {
        while (out->begin < out->end && is_blank(*out->begin)) {
            ++out->begin;
        }
        while (out->end > out->begin && is_blank(out->end[-1])) {
            --out->end;
        }
        if (out->begin < out->end) {
            return true;
        }
    }
    return false;
}

bool ss_text_next_word(ss_text *text, ss_text_span *out)
{
    do {
        for (; text->at < text->end && is_space(*text->at); ++text->at) {
            text->newlines += *text->at == '\n';
        }
    } while (text->at == text->end && refill(text));
    text->line = text->newlines + 1;
    const char *c = text->at;
    for (;;) {
        while (c < text->end && !is_space(*c) && *c != text->stop) {
            ++c;
        }
        const ptrdiff_t length = c - text->at;
        if (c < text->end || !refill(text)) {
            break;
        }
        c = text->at + length;
    }
    out->begin = text->at;
    out->end = c;
    text->at = c;
    return out->begin < out->end && !text->has_failed;
}

static void count_lines(ss_text *text, const char *begin, const char *end)
{
    while (begin < end && (begin = memchr(begin, '\n', (size_t)(end - begin))) != NULL) {
        ++text->newlines;
        ++begin;
    }
    text->line = text->newlines + 1;
}

bool ss_text_until(ss_text *text, char stop, ss_text_span *out)
{
    const char *found = find_stop(text, stop);
    if (found == NULL) {
        return false;
    }
    out->begin = text->at;
    out->end = found;
    text->at = found + 1;
    count_lines(text, out->begin, text->at);
    return true;
}

bool ss_text_skip_to(ss_text *text, char stop)
{
    for (;;) {
        const size_t there = (size_t)(text->end - text->at);
        const char *found = there > 0 ? memchr(text->at, stop, there) : NULL;
        count_lines(text, text->at, found != NULL ? found : text->end);
        text->at = found != NULL ? found : text->end;
        if (found != NULL) {
            return true;
        }
        if (!refill(text)) {
            return false;
        }
    }
}

const unsigned char *ss_text_bytes(ss_text *text, int count)
{
    while (text->end - text->at < count) {
        if (!refill(text)) {
            return NULL;
        }
    }
    const unsigned char *bytes = (const unsigned char *)text->at;
    text->at += count;
    return bytes;
}

bool ss_text_skip_bytes(ss_text *text, int64_t count)
{
    if (count > ss_text_left(text)) {
        return false;
    }
    if (count <= text->end - text->at) {
        text->at += count;
    } else {
        ss_text_mark mark = ss_text_here(text);
        mark.offset += count;
        ss_text_seek(text, mark);
    }
    return true;
}

/* ---- words and numbers ---- */

bool ss_span_next_word(ss_text_span *line, ss_text_span *out)
{
    while (line->begin < line->end && is_space(*line->begin)) {
        ++line->begin;
    }
    out->begin = line->begin;
    while (line->begin < line->end && !is_space(*line->begin)) {
        ++line->begin;
    }
    out->end = line->begin;
    return out->begin < out->end;
}

bool ss_span_is_blank(ss_text_span line)
{
    ss_text_span word;
    return !ss_span_next_word(&line, &word);
}

bool ss_span_is(ss_text_span word, const char *text)
{
    const size_t length = strlen(text);
    return (size_t)(word.end - word.begin) == length && memcmp(word.begin, text, length) == 0;
}

bool ss_span_is_any_case(ss_text_span word, const char *text)
{
    const size_t length = strlen(text);
    return (size_t)(word.end - word.begin) == length && strncasecmp(word.begin, text, length) == 0;
}

bool ss_span_copy(ss_text_span word, char *out, size_t size)
{
    const size_t length = (size_t)(word.end - word.begin);
    out[0] = '\0';
    if (length >= size || (length > 0 && memchr(word.begin, '\0', length) != NULL)) {
        return false;
    }
    memcpy(out, word.begin, length);
    out[length] = '\0';
    return true;
}

bool ss_span_integer(ss_text_span word, int64_t *out)
{
    const bool is_signed = word.begin < word.end && (*word.begin == '-' || *word.begin == '+');
    const bool is_negative = is_signed && *word.begin == '-';
    word.begin += is_signed;
    if (word.begin == word.end || word.end - word.begin > 18) {
        return false;
    }
    int64_t value = 0;
    for (; word.begin < word.end; ++word.begin) {
        if (*word.begin < '0' || *word.begin > '9') {
            return false;
        }
        value = 10 * value + (*word.begin - '0');
    }
    *out = is_negative ? -value : value;
    return true;
}

bool ss_span_number(ss_text_span word, double *out)
{
    char buffer[SS_TEXT_MAX_NUMBER + 1];
    /* Hexadecimal numbers are strtod's own idea. */
    if (!ss_span_copy(word, buffer, sizeof buffer) || buffer[0] == '\0' ||
        strpbrk(buffer, "xXpP") != NULL) {
        return false;
    }
    char *stop = NULL;
    *out = strtod(buffer, &stop);
    return *stop == '\0';
}

bool ss_span_next_int64(ss_text_span *line, int64_t *out)
{
    ss_text_span word;
    return ss_span_next_word(line, &word) && ss_span_integer(word, out);
}

bool ss_span_next_int32(ss_text_span *line, int64_t *out)
{
    return ss_span_next_int64(line, out) && *out >= -INT32_MAX && *out <= INT32_MAX;
}

bool ss_span_next_number(ss_text_span *line, double *out)
{
    ss_text_span word;
    return ss_span_next_word(line, &word) && ss_span_number(word, out);
}
