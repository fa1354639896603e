/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Temporary files of a command that takes a while: a signal that ends the program takes them along.
 * Thread: main. */

enum { LEFTOVER_MAX = 2 };
/* From here on SIGINT, SIGTERM and SIGHUP (unless it is ignored) remove `path`, which must live on
 * until it is forgotten, and end the program as they would have. Of more than LEFTOVER_MAX at once
 * the last stay. */
void leftover_watch(const char *path);
void leftover_forget(const char *path);
