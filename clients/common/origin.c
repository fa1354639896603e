/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "origin.h"

static const int64_t MEMORY_NS = 2000000000; /* of returns, and of two */
enum { RETURNS = 2 };                        /* one may be a packet that lost its way */

/* The first server, or one taken before it, spoke again after another. */
static void note_return(ss_origin *origin, int64_t now_ns)
{
    const bool is_recent = origin->return_ns != 0 && now_ns - origin->return_ns <= MEMORY_NS;
    origin->returns = is_recent ? origin->returns + (origin->returns < RETURNS) : 1;
    origin->return_ns = now_ns;
    if (origin->returns == RETURNS) {
        origin->two_ns = now_ns;
    }
}

bool ss_origin_take(ss_origin *origin, uint64_t source, int64_t now_ns)
{
    ss_origin_server *first = &origin->first, *second = &origin->second;
    const bool is_silent = first->heard_ns == 0 || now_ns - first->heard_ns > origin->silent_ns;
    const bool is_recent = second->heard_ns != 0 && now_ns - second->heard_ns <= MEMORY_NS;
    if (first->heard_ns != 0 && source == first->source) {
        if (is_recent && second->heard_ns > first->heard_ns) {
            note_return(origin, now_ns);
        }
        first->heard_ns = now_ns;
        return true;
    }
    const bool was_taken = is_recent && source == second->source && second->was_taken;
    const ss_origin_server other = {.source = source, .heard_ns = now_ns, .was_taken = was_taken};
    if (!is_silent) {
        *second = other;
        return false;
    }
    if (was_taken) {
        note_return(origin, now_ns);
    }
    origin->changes += first->heard_ns != 0;
    *second = *first;
    *first = other;
    first->was_taken = true;
    return true;
}

bool ss_origin_allows(const ss_origin *origin, uint64_t source)
{
    return origin->first.heard_ns == 0 || source == origin->first.source;
}

bool ss_origin_hears_two(const ss_origin *origin, int64_t now_ns)
{
    return origin->two_ns != 0 && now_ns - origin->two_ns <= MEMORY_NS;
}
