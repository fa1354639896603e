/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/senders.h"

#include <stddef.h>

ss_senders ss_senders_make(int32_t per_s, int32_t burst)
{
    return (ss_senders){.shared = {.interval_ns = 1000000000 / per_s, .burst = burst}};
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
    if (place == NULL) {
        return &senders->shared;
    }
    senders->count += place == &senders->sender[senders->count];
    *place = (ss_sender){
        .source = source,
        .budget = {.interval_ns = senders->shared.interval_ns, .burst = senders->shared.burst}};
    return &place->budget;
}
