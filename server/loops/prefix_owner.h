/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One server a prefix. Two would answer every pose twice, each with the force of its own body.
 *
 *   before ready   listens for 0.3 s, having asked for a status, which a server sends at once; who
 *                  is heard for 0.3 s and more is there to stay. Then this one refuses to start;
 *                  with --takeover it tells the other to shut down, waits until it is silent, or
 *                  3 s, and starts whatever the other does
 *   while running  where both started unheard (at once, or one was stopped), the younger gives way
 *                  (other_server.c) in its first ten seconds; with --takeover it asks for a
 *                  shutdown instead, once a second
 *
 * A status can be forged. So beyond ten seconds a server only warns: clients let go while they hear
 * two (clients/common). And it only warns as long as a client holds a probe that came to this one.
 * None such is who sent poses before this one was ready, who names a force in effect (`force_seq`)
 * with its first pose, or who came less than half a second before the other was first heard, or
 * later: statuses come four times a second, and the other may have served it. Then the younger
 * gives way as it does without a client. Rejected: that the other must answer the client's poses
 * too (as easily forged as a status). Thread: net.
 */
#include <stdbool.h>
#include <stdint.h>

#include "net/net.h"
#include "options.h"

/* Before the first pose and command are taken. SOFTSIM_OK, or SOFTSIM_ERROR_ARGUMENT with a line
 * that names the other server, or SOFTSIM_ERROR_NETWORK. */
softsim_status ss_prefix_owner_claim(ss_net *net, const ss_options *options, softsim_error *error);

/* Who holds a probe, or did last. */
typedef struct ss_prefix_hand {
    int64_t sender;
    int64_t first_ns, seen_ns; /* when a pose of its was first and last accepted; 0: never */
    bool is_from_other;        /* it sent before this server was ready, or named a force at once */
    bool has_early;            /* somebody sent poses before: the last one, */
    int64_t early_sender;
} ss_prefix_hand;

/* The prefix as held by a server that is ready since `start_us` of its clock. */
typedef struct ss_prefix_owner {
    int64_t start_us;
    int64_t next_shutdown_ns; /* --takeover: when the other may be told again */
    ss_prefix_hand hand[SOFTSIM_MAX_PROBES];
} ss_prefix_owner;
/* Of two servers: stay; tell the other to shut down; give way. */
typedef enum ss_prefix_verdict {
    SS_PREFIX_STAY,
    SS_PREFIX_TELL,
    SS_PREFIX_GIVE_WAY
} ss_prefix_verdict;

/* Takes a pose on the channel of `probe` before this server is ready; what the pose itself names is
 * not looked at, here and below. */
void ss_prefix_owner_note_early(ss_prefix_owner *owner, int32_t probe, const softsim_pose *pose);
/* Takes an accepted pose. */
void ss_prefix_owner_note_pose(ss_prefix_owner *owner, int32_t probe, const softsim_pose *pose,
                               int64_t now_ns);
ss_prefix_verdict ss_prefix_owner_judge(const ss_prefix_owner *owner, const ss_other_server *other,
                                        bool is_takeover, int64_t now_ns);
/* Does as judged. False when this server must give way, with a line in `error`. */
bool ss_prefix_owner_hold(ss_prefix_owner *owner, ss_net *net, const ss_options *options,
                          softsim_error *error);
