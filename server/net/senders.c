/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/senders.h"

#include <math.h>

static const double MEMORY_S = 1.0;
static const int32_t NEWCOMERS_PART = 4; /* one in so many */
static const double LEFT_PART = 0.5; /* of what is left of the shared budget, that one may take */
/* Said ten minutes ago; less would end as a subnormal number, which is slow and never gets to 0. */
static const double FORGOTTEN = 1e-300;
/* What known ones do not use, newcomers may. Half of the other half is still more than one may say
 * (net.c). */
static const double LENT_PART = 0.5;

ss_senders ss_senders_make(int32_t one_per_s, int32_t all_per_s)
{
    const int32_t newcomers_per_s = all_per_s / NEWCOMERS_PART;
    return (ss_senders){
        .one = one_per_s * MEMORY_S,
        .known = (all_per_s - newcomers_per_s) * MEMORY_S,
        .newcomers = {.interval_ns = 1000000000 / newcomers_per_s, .burst = SS_SENDERS}};
}

static void forget(ss_senders *senders, int64_t now_ns)
{
    if (now_ns <= senders->now_ns) {
        return;
    }
    const double kept = exp(-1e-9 * (double)(now_ns - senders->now_ns) / MEMORY_S);
    for (int32_t i = 0; i < senders->count; ++i) {
        senders->said[i] = senders->said[i] > FORGOTTEN ? kept * senders->said[i] : 0.0;
    }
    senders->said_by_known =
        senders->said_by_known > FORGOTTEN ? kept * senders->said_by_known : 0.0;
    senders->now_ns = now_ns;
}

/* What a known one may have said and still speak. */
static double find_share(const ss_senders *senders)
{
    return fmin(senders->one, LEFT_PART * (senders->known - senders->said_by_known));
}

/* -1: not known. */
static int32_t find(const ss_senders *senders, uint64_t source)
{
    for (int32_t i = 0; i < senders->count; ++i) {
        if (senders->source[i] == source) {
            return i;
        }
    }
    return -1;
}

/* A free place, or that of who has said least; of several the one whose turn it is, so that those
 * who came last stay longest. */
static int32_t find_place(ss_senders *senders)
{
    if (senders->count < SS_SENDERS) {
        return senders->count++;
    }
    int32_t least = senders->turn;
    for (int32_t i = 1; i < SS_SENDERS; ++i) {
        const int32_t place = (senders->turn + i) % SS_SENDERS;
        least = senders->said[place] < senders->said[least] ? place : least;
    }
    senders->turn = (least + 1) % SS_SENDERS;
    return least;
}

ss_senders_answer ss_senders_hear(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    forget(senders, now_ns);
    const int32_t known = find(senders, source);
    if (known >= 0) {
        if (senders->said[known] >= find_share(senders)) {
            return SS_SENDERS_OVER;
        }
        ++senders->said[known];
        ++senders->said_by_known;
        return SS_SENDERS_HEARD;
    }
    if (ss_budget_left(&senders->newcomers, now_ns) >= 1) {
        ss_budget_spend(&senders->newcomers, 1);
    } else if (senders->said_by_known < LENT_PART * senders->known) {
        ++senders->said_by_known;
    } else {
        return SS_SENDERS_NEW;
    }
    const int32_t place = find_place(senders);
    senders->source[place] = source;
    senders->said[place] = 0.0;
    return SS_SENDERS_HEARD;
}

void ss_senders_pause(ss_senders *senders, uint64_t source, int64_t pause_ns)
{
    const int32_t known = find(senders, source);
    if (known >= 0) {
        senders->said[known] = senders->one * exp(1e-9 * (double)pause_ns / MEMORY_S);
    }
}
