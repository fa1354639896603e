/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/plain.h"

#include <stdarg.h>
#include <stdint.h>
#include <string.h>

enum { LINE_SIZE = 8192 }; /* bytes; what is beyond is cut off */

/* The second byte of three or four has limits: a longer form than is needed, half of a pair of
 * UTF-16, and what is beyond U+10FFFF. */
static bool is_second(unsigned char first, unsigned char second)
{
    const unsigned char least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
    const unsigned char most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
    return second >= least && second <= most;
}

size_t ss_plain_length(const char *s, size_t size)
{
    const unsigned char *byte = (const unsigned char *)s;
    const unsigned char c = byte[0];
    if (c < 0x80) {
        return (c >= 0x20 && c != 0x7f) || c == '\t' || c == '\n' || c == '\r' ? 1 : 0;
    }
    const size_t length = c >= 0xc2 && c < 0xe0   ? 2
                          : c >= 0xe0 && c < 0xf0 ? 3
                          : c >= 0xf0 && c < 0xf5 ? 4
                                                  : 0;
    for (size_t i = 1; i < length; i++) {
        if (i >= size || (i == 1 ? !is_second(c, byte[i]) : (byte[i] & 0xc0) != 0x80)) {
            return 0;
        }
    }
    return length;
}

bool ss_plain_is_shown(const char *s, size_t length)
{
    const unsigned char *byte = (const unsigned char *)s;
    switch (length) {
    case 0:
        return false;
    case 1:
        return byte[0] >= 0x20;
    case 2:
        return !(byte[0] == 0xc2 && byte[1] < 0xa0);
    default:
        return !(byte[0] == 0xe2 && byte[1] == 0x80 && byte[2] >= 0xa8 && byte[2] <= 0xae) &&
               !(byte[0] == 0xe2 && byte[1] == 0x81 && byte[2] >= 0xa6 && byte[2] <= 0xa9);
    }
}

void ss_plain_clean(char *text)
{
    const size_t size = strlen(text);
    for (size_t i = 0; i < size;) {
        const size_t length = ss_plain_length(text + i, size - i);
        if (ss_plain_is_shown(text + i, length)) {
            i += length;
        } else {
            text[i] = text[i] == '\t' ? ' ' : '?'; /* what follows of it is broken then */
            i += 1;
        }
    }
}

void ss_plain_print(FILE *out, const char *format, ...)
{
    char text[LINE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const size_t own = strlen(format);
    const bool has_end = own > 0 && format[own - 1] == '\n';
    const size_t length = strlen(text);
    if (has_end && length > 0 && text[length - 1] == '\n') {
        text[length - 1] = '\0';
    }
    ss_plain_clean(text);
    fprintf(out, "%s%s", text, has_end ? "\n" : "");
}

/* The code point of the `length` bytes at s, which are good UTF-8. */
static uint32_t code_point(const unsigned char *s, size_t length)
{
    uint32_t code = length == 1 ? s[0] : s[0] & (0x7fU >> length);
    for (size_t i = 1; i < length; ++i) {
        code = code << 6 | (s[i] & 0x3fU);
    }
    return code;
}

void ss_plain_json(FILE *out, const char *text)
{
    const size_t size = strlen(text);
    fputc('"', out);
    for (size_t i = 0; i < size;) {
        const unsigned char *at = (const unsigned char *)text + i;
        const size_t length = ss_plain_length(text + i, size - i);
        const uint32_t code = length > 0 ? code_point(at, length) : at[0];
        i += length > 0 ? length : 1;
        if (code == '"' || code == '\\') {
            fprintf(out, "\\%c", (int)code);
        } else if (code >= 0x20 && code < 0x7f) {
            fputc((int)code, out);
        } else if (code < 0x10000) {
            fprintf(out, "\\u%04x", code);
        } else {
            fprintf(out, "\\u%04x\\u%04x", 0xd7c0 + (code >> 10), 0xdc00 + (code & 0x3ff));
        }
    }
    fputc('"', out);
}

void ss_plain_reason(const char *before, const char *text, char *out, size_t size)
{
    const char *colon = strstr(text, ": ");
    text = colon != NULL && colon < text + strcspn(text, "\n") ? colon + 2 : text;
    (void)snprintf(out, size, "%s%.*s", before, (int)strcspn(text, "\n"), text);
}
