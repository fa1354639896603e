/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/printer.h"

#include <stdarg.h>
#include <stdio.h>

#include "rt/plain.h"

void ss_say(const ss_printer *out, const char *format, ...)
{
    char text[SS_LINE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ss_plain_clean(text);
    out->line(out->sink, text);
}
