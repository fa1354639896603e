/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Names and texts of statuses, verdicts and refusals, and the list of faults that a set-up function
 * hands back. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "rt/plain.h"
#include "softsim/types.h"

/* Room kept free for the last line, which says how many faults are not shown. */
enum { MORE_SIZE = 48 };
#define MORE_FORMAT "(and %d more faults)"

/* What each of a list is called. */
#define LOOK_UP(function, type, LIST, CASE, otherwise)                                             \
    const char *function(type value)                                                               \
    {                                                                                              \
        switch (value) {                                                                           \
            LIST(CASE)                                                                             \
        }                                                                                          \
        return otherwise;                                                                          \
    }
#define STATUS_NAME(name, value, text)                                                             \
    case SOFTSIM_##name:                                                                           \
        return #name;
#define STATUS_TEXT(name, value, text)                                                             \
    case SOFTSIM_##name:                                                                           \
        return text;
#define VERDICT_NAME(name, value, text)                                                            \
    case SOFTSIM_VERDICT_##name:                                                                   \
        return text;
LOOK_UP(softsim_status_name, softsim_status, SOFTSIM_STATUS_LIST, STATUS_NAME, "UNKNOWN")
LOOK_UP(softsim_status_text, softsim_status, SOFTSIM_STATUS_LIST, STATUS_TEXT, "unknown status")
LOOK_UP(softsim_verdict_name, softsim_verdict, SOFTSIM_VERDICT_LIST, VERDICT_NAME, "unknown")

const char *softsim_refusal_name(softsim_refusal refusal)
{
    static const char *const names[SOFTSIM_REFUSED_COUNT] = {
#define X(name, value, text) [SOFTSIM_REFUSED_##name] = (text),
        SOFTSIM_REFUSAL_LIST(X)
#undef X
    };
    return refusal >= 0 && refusal < SOFTSIM_REFUSED_COUNT ? names[refusal] : "unknown";
}

/* The number in the last line when that line is the "more" line, else 0; *out_start is where the
 * line (with the \n before it) begins. */
static int faults_not_shown(const char *text, size_t *out_start)
{
    const char *last = strrchr(text, '\n');
    int count = 0;
    int end = 0;
    if (last == NULL || sscanf(last + 1, MORE_FORMAT "%n", &count, &end) != 1 ||
        last[1 + end] != '\0' || end == 0 || count < 1) {
        return 0;
    }
    *out_start = (size_t)(last - text);
    return count;
}

static void clean_lines(char *text)
{
    for (char *line = text; line != NULL;) {
        char *end = strchr(line, '\n');
        if (end != NULL) {
            *end = '\0';
        }
        ss_plain_clean(line);
        if (end != NULL) {
            *end++ = '\n';
        }
        line = end;
    }
}

void softsim_error_append(softsim_error *error, softsim_status status, const char *text)
{
    if (error == NULL) {
        return;
    }
    if (error->status == SOFTSIM_OK) {
        error->status = status;
    }
    error->fault_count += 1;

    size_t used = strnlen(error->text, sizeof error->text - 1);
    size_t more_start = used;
    const int hidden = faults_not_shown(error->text, &more_start);
    if (hidden == 0) {
        /* Try to append; the first fault is cut where it is too long, later ones are hidden. */
        char *line = error->text + used + (used > 0);
        const size_t space = sizeof error->text - MORE_SIZE;
        const size_t room = space > used + 1 ? space - used - 1 : 0;
        const int length = room > 0 ? snprintf(line, room, "%s", text) : -1;
        if (used == 0 || (length >= 0 && (size_t)length < room)) {
            clean_lines(line);
            if (used > 0) {
                error->text[used] = '\n';
            }
            return;
        }
    }
    snprintf(error->text + more_start, sizeof error->text - more_start, "\n" MORE_FORMAT,
             hidden + 1);
}

/* Line ends that are filled in are a stranger's. */
void softsim_error_add(softsim_error *error, softsim_status status, const char *format, ...)
{
    char text[SOFTSIM_ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ss_plain_clean(text);
    softsim_error_append(error, status, text);
}
