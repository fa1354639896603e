/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Text of strangers, from the wire, a file or a file's name, before it is shown: a terminal obeys
 * control characters, a reader of a log believes its lines. What may not be shown is a `?` for
 * each byte: C0 and DEL, C1 as a byte or as U+0080..U+009F, what is no UTF-8, the separators U+2028
 * and U+2029 and what turns text around (U+202A..U+202E, U+2066..U+2069). A tab is a blank.
 * softsim_error_add and ss_say do this to all they are given. RT-safe but for printing.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* Length of the UTF-8 character at s, 0 where there is none that a text may hold: broken ones, and
 * control characters of one byte other than tab and line ends. */
size_t ss_plain_length(const char *s, size_t size);
/* May the character of `length` bytes at s be shown? Line ends may not. */
bool ss_plain_is_shown(const char *s, size_t length);
/* In place, line ends too. */
void ss_plain_clean(char *text);
/* As fprintf, one line at a time: its own line end stays, others that were filled in do not. */
void ss_plain_print(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* As a string of JSON, with its quotes, in ASCII; what is no UTF-8 is read as Latin-1. */
void ss_plain_json(FILE *out, const char *text);
/* `before`, then the first line of `text`, an error's, without the file and place before its first
 * ": ": for those who made that file for a moment. */
void ss_plain_reason(const char *before, const char *text, char *out, size_t size);
