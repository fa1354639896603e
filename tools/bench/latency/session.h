/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One session of the whole chain, as a user would start it, to be measured: softsimd on a scene,
 * softsim-replay on probe 0, softsim-bridge with its simulated hand on probe 1, softsim-monitor,
 * and in this process the bare loop and the bare echo and a subscriber to the server's status. The
 * programs are those beside this one; channels have a prefix of their own.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/latency/bare.h"
#include "softsim/status.h"
#include "softsim/types.h"

enum { SS_SESSION_WINDOW_S = 10 }; /* what the percentiles of a status cover */

typedef struct ss_session_options {
    const char *scene, *poses;
    const char *lcm_url; /* NULL: LCM's own default */
    const char *bridge;  /* further arguments of the bridge, by spaces */
    const char *folder;  /* for the programs' logs and the replay's answers */
    int64_t repeat;      /* times that the poses are played: long enough */
    double seconds;      /* measured */
} ss_session_options;

/* What a status says, of interest here. */
typedef struct ss_session_status {
    int64_t receive_ns;
    softsim_server_status of; /* its texts are gone but for `reason` */
    int64_t poses_refused;    /* for whatever reason */
    char reason[96];
} ss_session_status;

typedef struct ss_session {
    /* measured */
    int64_t begin_ns, end_ns;
    ss_session_status *status; /* every one received, also before and after */
    int32_t status_count, status_capacity;
    ss_bare_result bare;
    char answers[4096]; /* path of the replay's CSV, of a recording that was stopped */
    /* state */
    ss_bare *bare_state;
} ss_session;

/* Runs it all and stops it all again. SOFTSIM_ERROR_SYSTEM when a program failed: the error names
 * it and the last line of its log. */
softsim_status ss_session_run(const ss_session_options *options, ss_session *out_session,
                              softsim_error *error);
/* Frees; removes the answers. */
void ss_session_fini(ss_session *session);

/* Splits `text` at spaces into at most `capacity` words, in place. Returns their number, -1 when
 * there are more. */
int32_t ss_session_split(char *text, const char **out_word, int32_t capacity);
/* The value of the line NAME="..." or NAME='...' or NAME=... of a shell file, NAME ending in
 * _SECOND; false when there is none. */
bool ss_session_read_bridge(const char *path, char *out, int32_t size);
