/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/note.h"

#include <stdarg.h>
#include <stdio.h>

#include "rt/plain.h"
#include "rt/printer.h"

static void __attribute__((format(printf, 5, 0)))
hand_over(const ss_notes *to, ss_note_kind kind, const char *where, const char *put_back,
          const char *format, va_list arguments)
{
    char text[SS_LINE_SIZE];
    vsnprintf(text, sizeof text, format, arguments);
    ss_plain_clean(text);
    const ss_note note = {kind, where, text, put_back};
    to->take(to->sink, &note);
}

void ss_note_used(const ss_notes *to, const char *where, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    hand_over(to, SS_NOTE_USED, where, NULL, format, arguments);
    va_end(arguments);
}

void ss_note_left_out(const ss_notes *to, const char *where, const char *put_back,
                      const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    hand_over(to, SS_NOTE_LEFT_OUT, where, put_back, format, arguments);
    va_end(arguments);
}

void ss_note_warning(const ss_notes *to, const char *where, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    hand_over(to, SS_NOTE_WARNING, where, NULL, format, arguments);
    va_end(arguments);
}

void ss_note_print(const ss_note *note, char *out, size_t size)
{
    static const char *const form[] = {[SS_NOTE_USED] = "%s: %s",
                                       [SS_NOTE_LEFT_OUT] = "left out: %s (%s)",
                                       [SS_NOTE_WARNING] = "warning: %s: %s"};
    (void)snprintf(out, size, form[note->kind], note->where, note->text);
}
