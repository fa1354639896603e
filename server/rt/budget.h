/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A token bucket: how much of what comes from outside is handled, so that no flood takes a
 * real-time thread's core. One token every `interval_ns`, at most `burst` of them saved up. A
 * single time says it all: the tokens there are, now - spent_ns over interval_ns.
 */
#include <stdint.h>

typedef struct ss_budget {
    int64_t interval_ns, burst; /* parameters */
    int64_t spent_ns;           /* state: up to here the tokens are spent; starts full with 0 */
} ss_budget;

/* Tokens that there are at `now_ns`. RT-safe. */
static inline int64_t ss_budget_left(ss_budget *budget, int64_t now_ns)
{
    const int64_t oldest_ns = now_ns - budget->burst * budget->interval_ns;
    if (budget->spent_ns < oldest_ns) {
        budget->spent_ns = oldest_ns;
    }
    return (now_ns - budget->spent_ns) / budget->interval_ns;
}

/* Takes `count` tokens that ss_budget_left said there are. RT-safe. */
static inline void ss_budget_spend(ss_budget *budget, int64_t count)
{
    budget->spent_ns += count * budget->interval_ns;
}

/* When there will be `count` tokens. RT-safe. */
static inline int64_t ss_budget_when(const ss_budget *budget, int64_t count)
{
    return budget->spent_ns + count * budget->interval_ns;
}
