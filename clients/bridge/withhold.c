/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "withhold.h"

#include <math.h>

static const int64_t wait_ns = 40000000, wait_after_other_ns = 2000000000;
static const double withhold_s = 0.02, begin_s = 0.01, return_s = 0.5;

void ss_withholding_begin(ss_withholding *withholding)
{
    *withholding = (ss_withholding){.share = 1.0, .take_up_s = begin_s};
}

/* Notes since when who answers is alone. Is that long enough? */
static bool wait_alone(ss_withholding *w, const ss_speakers *heard, int64_t now_ns)
{
    if (heard->second != w->before.second) {
        w->was_second = true;
        w->alone_since_ns = now_ns;
        w->take_up_s = return_s;
    }
    if (!heard->has_force) {
        return false;
    }
    w->alone_since_ns = w->alone_since_ns == 0 ? now_ns : w->alone_since_ns;
    const bool was_other = w->was_second || heard->changes > 0;
    return now_ns - w->alone_since_ns >= (was_other ? wait_after_other_ns : wait_ns);
}

void ss_withholding_step(ss_withholding *w, const ss_speakers *heard, bool is_felt, int64_t now_ns,
                         double period_s)
{
    if (heard->changes != w->before.changes) {
        w->is_trusted = w->was_second = false;
        w->before.second = heard->second; /* its own, while it was the second */
        w->alone_since_ns = 0;
        w->take_up_s = return_s;
        w->share = is_felt ? w->share : 1.0; /* what is on its way from the one before fades */
    }
    w->is_trusted = w->is_trusted || wait_alone(w, heard, now_ns);
    w->take_up_s = heard->are_two ? return_s : w->take_up_s;
    w->before = *heard;
    const bool is_kept = heard->are_two || !w->is_trusted;
    const double change = is_kept ? period_s / withhold_s : -period_s / w->take_up_s;
    w->share = fmin(1.0, fmax(0.0, w->share + change));
}

bool ss_withholding_is_waiting(const ss_withholding *w)
{
    return w->was_second && !w->is_trusted && !w->before.are_two;
}
