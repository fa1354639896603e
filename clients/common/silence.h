/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Why nothing answers: a client that got no force asks the server's status, since a server that
 * refuses every pose looks like none at all. Thread: main, after the client's own connection is
 * closed.
 */
#include <stdint.h>

#include "softsim/client.h"

/* Listens for a status, a second at most, and prints one line on stderr: `what` ("no force came")
 * and the likely reason. Of `config` only lcm_url and prefix are read. `probe` -1: several. */
void ss_silence_explain(const char *program, const softsim_client_config *config, int32_t probe,
                        const char *what);
