/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Fair shares of one budget for all who send, so that one who floods, or many who each say little,
 * take nothing from the others. Senders are told by the address and port that their packets come
 * from: the number in a message is whatever its writer likes.
 *
 * What a sender has said counts less and less, 1/e of it after a second: the count is what it said
 * in about the last second. Who is known may speak while it has said less than half of what is left
 * of the budget that all known ones share. So `n` who never stop have 1 / (n + 2) of it each and
 * leave two such shares over: who asks for less is never refused, and may say two thirds of a share
 * at once (A. Choudhury, E. Hahne, Dynamic queue length thresholds for shared-memory packet
 * switches, IEEE/ACM Trans. Networking 6(2), 1998).
 *
 * The first message of somebody new comes out of another budget, which known ones cannot spend, or
 * out of the half of theirs that they leave.
 * It is known then, in the place of who has said least; the first message does not count. So
 * SS_SENDERS who flood, however slowly, keep no newcomer out. Ever new addresses do, as far as
 * their share of all newcomers goes, since nothing tells an honest one from them; but newcomers
 * only: they take the places of each other, and who has spoken twice keeps its own.
 *
 * Rejected: a budget of its own for each of a few, and one for the rest: two dozen who each said
 * less than their own spent that of the rest. No clock in here: the caller gives the time. Memory
 * is bounded. Thread: one.
 */
#include <stdint.h>

#include "rt/budget.h"

enum { SS_SENDERS = 256 };

typedef enum ss_senders_answer {
    SS_SENDERS_HEARD,
    SS_SENDERS_OVER, /* a known one, over its share */
    SS_SENDERS_NEW   /* a newcomer among too many of them */
} ss_senders_answer;

typedef struct ss_senders {
    double one, known;    /* parameters: messages in about a second, of one and of all known */
    ss_budget newcomers;  /* first messages */
    double said_by_known; /* and by newcomers at their expense */
    int64_t now_ns;       /* what was said counts as of then */
    int32_t count, turn;
    uint64_t source[SS_SENDERS]; /* address and port */
    double said[SS_SENDERS];     /* but for the first message */
} ss_senders;

/* All together may say about `all_per_s` messages a second, and one of them `one_per_s`; a quarter
 * is for newcomers. */
ss_senders ss_senders_make(int32_t one_per_s, int32_t all_per_s);
/* Counts a message of the sender where it may say it. */
ss_senders_answer ss_senders_hear(ss_senders *senders, uint64_t source, int64_t now_ns);
/* A known sender that is not listened to for `pause_ns` has then said all that one may: those who
 * pause leave the others larger shares, which they would take all at once when they are back. */
void ss_senders_pause(ss_senders *senders, uint64_t source, int64_t pause_ns);
