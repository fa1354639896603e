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
    int32_t heard;       /* statuses */
    int32_t statuses;    /* of a lockstep server, with counts that can be */
    bool is_real_time;   /* the last was of a server in real time, which counts none */
    bool is_counted;     /* `count` is of after the last question */
    int64_t count;       /* since the server's start, as the last one says */
    int64_t told_us;     /* when it was made, */
    int64_t answered_us; /* and when the server last answered a pose, by its clock; 0: never */
} ss_ticks;

void ss_ticks_take_force(ss_ticks *ticks, const softsim_force *force);
void ss_ticks_take_status(ss_ticks *ticks, const softsim_server_status *status);
/* Asks for statuses until one is here that was made after the last answer, or, before the first,
 * after the call: is_counted then. For a second at most, five where one has come before; not of a
 * server in real time. A signal ends it. False when LCM is broken. */
bool ss_ticks_ask(ss_ticks *ticks, softsim_client *client);
