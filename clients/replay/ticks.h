/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Whose ticks a lockstep server's were. Each pose that it takes, or refuses for what it says, is a
 * tick of its world, whoever sent it: the forces are those of the log only when nobody else sent
 * one. The server's status counts them; it is asked for before the first pose and after the last.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/client.h"

typedef struct ss_ticks {
    int32_t statuses; /* of a lockstep server that were heard */
    int64_t count;    /* since the server's start, as the last one says */
} ss_ticks;

void ss_ticks_take_status(ss_ticks *ticks, const softsim_server_status *status);
/* Asks for statuses until one is here that was made after the call; for a second at most. A signal
 * ends it. False when LCM is broken. */
bool ss_ticks_ask(ss_ticks *ticks, softsim_client *client);
