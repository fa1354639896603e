/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Results of a command that takes a while: SIGINT, SIGTERM and SIGHUP (unless it is ignored) take
 * their temporary files along, and end the program as they would have. They wait while a file is
 * opened, renamed or removed, so that at no moment one is left. Of more than LEFTOVER_MAX at once
 * the last stay. Thread: main. */
#include "output.h"

enum { LEFTOVER_MAX = 2 };
/* As ss_output_open and its kin. */
softsim_status leftover_open(ss_output *output, const char *path, softsim_error *error);
softsim_status leftover_commit(ss_output *output, softsim_error *error);
void leftover_abandon(ss_output *output);
