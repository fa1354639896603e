/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A server's status for programs. */
#include <stdio.h>

#include "softsim/status.h"

/* One object, without a line end: every field of the message by its name; null for what is not
 * finite. Texts are a stranger's (rt/plain.h). */
void ss_status_json(FILE *out, const softsim_server_status *status);
