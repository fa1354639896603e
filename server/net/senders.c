/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/senders.h"

#include <stdbool.h>
#include <stddef.h>

static const int64_t PAST_NS = 1000000000;

ss_senders ss_senders_make(int32_t per_s, int32_t burst)
{
    const int64_t interval_ns = 1000000000 / per_s;
    return (ss_senders){.shared = {.interval_ns = interval_ns, .burst = burst},
                        .entries = {.interval_ns = interval_ns, .burst = SS_SENDERS}};
}

static bool is_newcomer(const ss_senders *senders, uint64_t source, int64_t now_ns)
{
    for (int32_t i = 0; i < SS_PAST_SENDERS; ++i) {
        if (senders->past[i].source == source && senders->past[i].until_ns > now_ns) {
            return false;
        }
    }
    return true;
}

/* In the place of who is nearest to being forgotten. */
static void remember(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    ss_past_sender *place = senders->past;
    for (int32_t i = 1; i < SS_PAST_SENDERS; ++i) {
        place = senders->past[i].until_ns < place->until_ns ? &senders->past[i] : place;
    }
    *place = (ss_past_sender){.source = source, .until_ns = now_ns + PAST_NS};
}

/* The one who is furthest over his budget; NULL: nobody is. */
static ss_sender *find_worst(ss_senders *senders, int64_t now_ns)
{
    ss_sender *worst = NULL;
    for (int32_t i = 0; i < senders->count; ++i) {
        ss_sender *sender = &senders->sender[i];
        if (ss_budget_left(&sender->budget, now_ns) < 1 &&
            (worst == NULL || sender->budget.spent_ns > worst->budget.spent_ns)) {
            worst = sender;
        }
    }
    return worst;
}

static ss_budget *take_place(ss_senders *senders, ss_sender *place, uint64_t source,
                             int64_t spent_ns)
{
    const ss_budget *shared = &senders->shared;
    *place = (ss_sender){.source = source,
                         .budget = {.interval_ns = shared->interval_ns,
                                    .burst = shared->burst,
                                    .spent_ns = spent_ns}};
    return &place->budget;
}

ss_budget *ss_senders_find(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    ss_sender *place = senders->count < SS_SENDERS ? &senders->sender[senders->count] : NULL;
    for (int32_t i = 0; i < senders->count; ++i) {
        ss_sender *sender = &senders->sender[i];
        if (sender->source == source) {
            return &sender->budget;
        }
        if (place == NULL && ss_budget_left(&sender->budget, now_ns) >= sender->budget.burst) {
            place = sender;
        }
    }
    if (place != NULL) {
        senders->count += place == &senders->sender[senders->count];
        return take_place(senders, place, source, 0);
    }
    ss_sender *worst = find_worst(senders, now_ns);
    if (worst == NULL || ss_budget_left(&senders->shared, now_ns) >= 1 ||
        ss_budget_left(&senders->entries, now_ns) < 1 || !is_newcomer(senders, source, now_ns)) {
        return &senders->shared;
    }
    ss_budget_spend(&senders->entries, 1);
    remember(senders, worst->source, now_ns);
    return take_place(senders, worst, source, now_ns - SS_ENTRY * senders->shared.interval_ns);
}
