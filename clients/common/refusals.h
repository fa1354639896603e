/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which poses of a log its server did not take, since another sender held the probe.
 *
 * A server tells who is refused so by a force with the flag 32 that answers one of its poses, at
 * once and then ten times a second; who is taken gets a force for nearly every pose. So what the
 * log tells of a sender's pose is what its last force up to that pose's number says, or before the
 * first of them what that one says. Only changes are kept.
 *
 * A log is hostile: there is room for so many senders and changes, and is_full when they are more.
 * No file in here. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

enum { SS_REFUSALS_SENDERS = 64, SS_REFUSALS_CHANGES = 4096 };

typedef enum ss_refusals_answer {
    SS_REFUSALS_UNTOLD, /* no force of the log answers this sender on this probe */
    SS_REFUSALS_TAKEN,
    SS_REFUSALS_REFUSED
} ss_refusals_answer;

typedef struct ss_refusals {
    struct {
        int64_t sender;
        int32_t probe, first, last; /* its changes */
        int32_t newest_seq;         /* that a force answers */
        int32_t cursor;             /* the change that was used last */
    } sender[SS_REFUSALS_SENDERS];
    struct {
        int32_t seq, next; /* from this pose on; next: -1 none */
        bool is_refused;
    } change[SS_REFUSALS_CHANGES];
    int32_t sender_count, change_count;
    bool has_refused, is_full;
} ss_refusals;

/* The forces of the log, in order, all before the first question. */
void ss_refusals_note(ss_refusals *refusals, const softsim_force *force);
/* Of a pose that came on the channel of `probe`; quick for poses in order. */
ss_refusals_answer ss_refusals_of(ss_refusals *refusals, const softsim_pose *pose, int32_t probe);
