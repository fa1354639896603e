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
 * none it shares one more budget with all who have no place. Who keeps the places busy is many
 * senders, and then takes nothing from a newcomer either; more senders than that can.
 *
 * Rejected: the place of whoever has most left, with what is left there: a sender who asks for
 * little would lose it to those who ask for much. No clock in here: the caller gives the time.
 * Thread: one.
 */
#include <stdint.h>

#include "rt/budget.h"

enum { SS_SENDERS = 8 };

typedef struct ss_sender {
    uint64_t source; /* address and port */
    ss_budget budget;
} ss_sender;

typedef struct ss_senders {
    ss_budget shared; /* of all without a place; the parameters of each */
    int32_t count;
    ss_sender sender[SS_SENDERS];
} ss_senders;

/* Each may say `per_s` messages a second, and `burst` at once after a pause. */
ss_senders ss_senders_make(int32_t per_s, int32_t burst);
/* The sender's budget, or the shared one. */
ss_budget *ss_senders_find(ss_senders *senders, uint64_t source, int64_t now_ns);
