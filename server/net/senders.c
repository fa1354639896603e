/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/senders.h"

#include <stddef.h>

ss_budget *ss_senders_find(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    ss_sender *place = senders->count < SS_SENDERS ? &senders->sender[senders->count] : NULL;
    for (int32_t i = 0; i < senders->count; ++i) {
        ss_sender *sender = &senders->sender[i];
        if (sender->source == source) {
            return &sender->budget;
        }
        if (place == NULL && ss_budget_left(&sender->budget, now_ns) >= senders->burst) {
            place = sender;
        }
    }
    if (place == NULL) {
        return NULL;
    }
    senders->count += place == &senders->sender[senders->count];
    *place = (ss_sender){.source = source,
                         .budget = {.interval_ns = senders->interval_ns, .burst = senders->burst}};
    return &place->budget;
}
