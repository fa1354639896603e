/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A budget for each who sends, so that one who floods takes nothing from the others. Senders are
 * told by the address and port that their packets come from: the number in a message is whatever
 * its writer likes.
 *
 * The table is short, which bounds what all together may ask for. A newcomer gets a free place, or
 * that of one whose budget is full again, so that forgetting it changes nothing; where there is
 * none it shares one more budget with all who have no place. Where that is spent too, somebody says
 * more than he may, and the newcomer gets the place of the one who is furthest over his budget,
 * with a few messages to begin with. Who lost his place so is no newcomer for a second, or those
 * who flood would take places from each other; and places change hands no more often than a sender
 * may speak, so that new numbers gain a flood nothing. So it takes more than SS_SENDERS +
 * SS_PAST_SENDERS who flood, or one of ever new numbers, to keep a newcomer out.
 *
 * Rejected: the place of whoever has most left, with what is left there: a sender who asks for
 * little would lose it to those who ask for much. No clock in here: the caller gives the time.
 * Thread: one.
 */
#include <stdint.h>

#include "rt/budget.h"

enum {
    SS_SENDERS = 8,
    SS_PAST_SENDERS = 32, /* who lost their places and are remembered */
    SS_ENTRY = 4          /* messages that the place of another begins with */
};

typedef struct ss_sender {
    uint64_t source; /* address and port */
    ss_budget budget;
} ss_sender;

typedef struct ss_past_sender {
    uint64_t source;
    int64_t until_ns; /* it is no newcomer */
} ss_past_sender;

typedef struct ss_senders {
    ss_budget shared;  /* of all without a place; the parameters of each */
    ss_budget entries; /* places that newcomers may take from others */
    int32_t count;
    ss_sender sender[SS_SENDERS];
    ss_past_sender past[SS_PAST_SENDERS];
} ss_senders;

/* Each may say `per_s` messages a second, and `burst` at once after a pause. */
ss_senders ss_senders_make(int32_t per_s, int32_t burst);
/* The sender's budget, or the shared one. */
ss_budget *ss_senders_find(ss_senders *senders, uint64_t source, int64_t now_ns);
