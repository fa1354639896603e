/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: the text of a mesh file as its readers see it, taken by lines, words or
 * bytes, from memory or through a window that slides over an open file; and numbers, strictly.
 *
 * The file is never in memory whole: a reader goes over it twice instead (ss_text_seek), first to
 * count, then to fill arrays of the right size. A mapped file was rejected: its pages count as
 * memory, and a file cut short meanwhile kills the process. A span lives until the next call that
 * takes something.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

enum {
    SS_TEXT_WINDOW = 1 << 18, /* bytes; longer lines, words and tags are refused */
    SS_TEXT_MAX_FAULTS = 5,   /* of a file; then reading stops */
    SS_TEXT_MAX_NUMBER = 63   /* characters of a number */
};

typedef struct ss_text_span {
    const char *begin, *end;
} ss_text_span;

typedef struct ss_text {
    const char *name; /* what faults call it */
    softsim_error *error;
    softsim_status status; /* of the first fault */
    int32_t fault_count;
    int32_t line;     /* from 1, of what was taken last; 0 at the start */
    int32_t newlines; /* taken */
    bool has_failed;  /* a piece too long, a disk error: nothing more is taken */
    bool is_binary;   /* faults name the byte instead */
    char stop;        /* ends a word, beside blanks; '\n' for none other */
    const char *at, *end;
    int64_t end_offset; /* of `end` in the file */
    int64_t size;
    const char *memory; /* the whole, or NULL: then the file and its window */
    int fd;
    char *window;
    size_t window_size;
} ss_text;

/* A place to come back to. */
typedef struct ss_text_mark {
    int64_t offset;
    int32_t newlines;
} ss_text_mark;

/* Over `size` bytes in memory, which need no terminating zero. */
void ss_text_init(ss_text *text, const char *memory, size_t size, const char *name,
                  softsim_error *error);
/* Over an open regular file, through a window of so many bytes, 64 at least; release with
 * ss_text_fini. False when out of memory. */
bool ss_text_open(ss_text *text, int fd, int64_t size, size_t window, const char *name,
                  softsim_error *error);
void ss_text_fini(ss_text *text);

ss_text_mark ss_text_here(const ss_text *text);
void ss_text_seek(ss_text *text, ss_text_mark mark);
/* Bytes not yet taken. */
int64_t ss_text_left(const ss_text *text);

/* Adds "name:line: what" (or "name: byte n: what"); control characters become '?'. */
void ss_text_fault(ss_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* False, with the fault that `count` things cannot be in what is left. */
bool ss_text_fault_short(ss_text *text, int64_t count, const char *of, const char *what);
/* Without a place. */
void ss_text_fault_file(ss_text *text, softsim_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The same for "out of memory"; false. */
bool ss_text_out_of_memory(ss_text *text);

/* All of these return false at the end of the text, and where a piece is longer than the window,
 * which is a fault. */
/* The next line, without its end. */
bool ss_text_line(ss_text *text, ss_text_span *out);
/* The next line that is not blank, without surrounding blanks. */
bool ss_text_next_line(ss_text *text, ss_text_span *out);
/* The next word, over lines. */
bool ss_text_next_word(ss_text *text, ss_text_span *out);
/* All up to `stop`, which is taken too; false where it does not come. */
bool ss_text_until(ss_text *text, char stop, ss_text_span *out);
/* Goes on to `stop`, however far, and does not take it. */
bool ss_text_skip_to(ss_text *text, char stop);
/* `count` bytes, at most 64, of any kind; NULL at the end. */
const unsigned char *ss_text_bytes(ss_text *text, int count);
bool ss_text_skip_bytes(ss_text *text, int64_t count);

/* Of a line: takes its next word. */
bool ss_span_next_word(ss_text_span *line, ss_text_span *out);
bool ss_span_is_blank(ss_text_span line);
bool ss_span_is(ss_text_span word, const char *text);
/* Whatever the case of its letters. */
bool ss_span_is_any_case(ss_text_span word, const char *text);
/* Copies up to size - 1 bytes and ends them; false when it is longer, or holds a zero. */
bool ss_span_copy(ss_text_span word, char *out, size_t size);
/* A whole word as a decimal integer of at most 18 digits. */
bool ss_span_integer(ss_text_span word, int64_t *out);
/* A whole word as a decimal number; inf and nan are numbers here, for the caller to refuse. */
bool ss_span_number(ss_text_span word, double *out);
/* Of a line: its next word as a number; the first within 32 bits. */
bool ss_span_next_int32(ss_text_span *line, int64_t *out);
bool ss_span_next_int64(ss_text_span *line, int64_t *out);
bool ss_span_next_number(ss_text_span *line, double *out);
