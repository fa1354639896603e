/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A server that answers with no force, since its body stands: the model is at fault, or its results
 * are half a second late (flag 64 of the forces; a status tells which, and why), or it is paused (a
 * status says so, and flag 8 is on all forces). Such forces are of no body, and look like those of
 * a tool in free space.
 *
 * Forces ramp for other reasons too: on entry, at a reset, for a silence, at the server's end. They
 * are of a pause only where a status tells one meanwhile; then all are that ramp in a row.
 * Thread: that of the client.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/client.h"

typedef struct ss_halt {
    int32_t fault_seq, pause_seq; /* the first pose that was answered so; 0: none */
    int64_t fault_forces, pause_forces;
    bool is_fault_told; /* a status has told the fault, */
    char reason[160];   /* and why */
    int32_t statuses, statuses_since_fault;
    bool is_paused; /* as the last one says */
    struct {
        int32_t seq;   /* the pose of the first that ramps in a row; 0: the last force does not */
        int64_t count; /* of them, that are not counted as a pause's */
    } ramping[SOFTSIM_MAX_PROBES];
} ss_halt;

/* Of a force for this sender. `is_new`: it answers a pose that none has answered; no other begins
 * anything, since a server may halt after the last. */
void ss_halt_take_force(ss_halt *halt, const softsim_force *force, bool is_new);
void ss_halt_take_status(ss_halt *halt, const softsim_server_status *status);
/* Are there forces of no body, as far as is known? */
bool ss_halt_is_seen(const ss_halt *halt);
/* Is it known whether flag 64 is of a fault, or of a late model? */
bool ss_halt_is_clear(const ss_halt *halt);
/* What the model is then, "at fault" or "late", and what helps. */
const char *ss_halt_name(const ss_halt *halt);
const char *ss_halt_cure(const ss_halt *halt);
/* Asks for a status where the last forces leave open what they are of; for a second at most.
 * Whatever else comes meanwhile goes to the client's callbacks. */
void ss_halt_ask(const ss_halt *halt, softsim_client *client);
/* What there was of either, a line each that begins with `before`; what ends it. */
void ss_halt_print(const ss_halt *halt, FILE *out, const char *before);
