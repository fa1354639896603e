/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A budget for each who sends, so that one who floods takes nothing from the others. Senders are
 * told by the address and port that their packets come from: the number in a message is whatever
 * its writer likes.
 *
 * The table is short, which bounds what all together may ask for. A newcomer gets the place of one
 * whose budget is full again, so that forgetting it changes nothing; where there is none it gets
 * nothing. No clock in here: the caller gives the time. Thread: one.
 */
#include <stdint.h>

#include "rt/budget.h"

enum { SS_SENDERS = 8 };

typedef struct ss_sender {
    uint64_t source; /* address and port */
    ss_budget budget;
} ss_sender;

typedef struct ss_senders {
    int64_t interval_ns, burst; /* parameters, of each budget */
    int32_t count;
    ss_sender sender[SS_SENDERS];
} ss_senders;

/* The sender's budget, or NULL: as many others are busy as there are places. */
ss_budget *ss_senders_find(ss_senders *senders, uint64_t source, int64_t now_ns);
