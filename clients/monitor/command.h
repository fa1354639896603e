/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* One command to the server, and its reply. Thread: main. */
#include "softsim/client.h"

/* Sends `text` (NAME[ ARGUMENT]), waits for the reply and prints its text on stdout. Of `config`
 * only lcm_url and prefix are read. Returns an exit status: 0 done, 1 refused or no answer, 2
 * unknown or bad. */
int ss_command_run(const char *program, const softsim_client_config *config, const char *text);
