/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The server's status as text. Strings of the message are shown without control characters. */
#include <stdio.h>

#include "softsim_server_status_t.h"

/* One line of JSON: every field of the message by its name; null for what is not finite. */
void ss_show_json(FILE *out, const softsim_server_status_t *status);
/* One line with the figures that tell health. */
void ss_show_line(FILE *out, const softsim_server_status_t *status);
/* A screenful. */
void ss_show_page(FILE *out, const softsim_server_status_t *status);
/* The text with a dot for every control character: a message must not drive the terminal. */
void ss_show_text(FILE *out, const char *text);
