/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "refusals.h"

/* -1: none. */
static int32_t find_sender(const ss_refusals *r, int64_t sender, int32_t probe)
{
    for (int32_t i = 0; i < r->sender_count; ++i) {
        if (r->sender[i].sender == sender && r->sender[i].probe == probe) {
            return i;
        }
    }
    return -1;
}

static int32_t add_change(ss_refusals *r, int32_t seq, bool is_refused)
{
    r->change[r->change_count].seq = seq;
    r->change[r->change_count].next = -1;
    r->change[r->change_count].is_refused = is_refused;
    return r->change_count++;
}

void ss_refusals_note(ss_refusals *r, const softsim_force *force)
{
    const bool is_refused = (force->flags & SOFTSIM_FORCE_OTHER_SENDER) != 0;
    const int32_t i = find_sender(r, force->sender, force->probe);
    if (force->pose_seq == 0) {
        return; /* of a pose that is left out anyway */
    }
    r->has_refused = r->has_refused || is_refused;
    if (i >= 0 && force->pose_seq <= r->sender[i].newest_seq) {
        return; /* again, or overtaken */
    }
    if (i >= 0 && r->change[r->sender[i].last].is_refused == is_refused) {
        r->sender[i].newest_seq = force->pose_seq;
        return;
    }
    if (r->change_count == SS_REFUSALS_CHANGES ||
        (i < 0 && r->sender_count == SS_REFUSALS_SENDERS)) {
        r->is_full = true;
        return;
    }
    const int32_t k = add_change(r, force->pose_seq, is_refused);
    if (i >= 0) {
        r->change[r->sender[i].last].next = k;
        r->sender[i].last = k;
        r->sender[i].newest_seq = force->pose_seq;
    } else {
        r->sender[r->sender_count].sender = force->sender;
        r->sender[r->sender_count].probe = force->probe;
        r->sender[r->sender_count].first = r->sender[r->sender_count].last = k;
        r->sender[r->sender_count].cursor = k;
        r->sender[r->sender_count++].newest_seq = force->pose_seq;
    }
}

ss_refusals_answer ss_refusals_of(ss_refusals *r, const softsim_pose *pose, int32_t probe)
{
    const int32_t i = find_sender(r, pose->sender, probe);
    if (i < 0) {
        return SS_REFUSALS_UNTOLD;
    }
    int32_t k = r->sender[i].cursor;
    k = r->change[k].seq <= pose->seq ? k : r->sender[i].first;
    while (r->change[k].next >= 0 && r->change[r->change[k].next].seq <= pose->seq) {
        k = r->change[k].next;
    }
    r->sender[i].cursor = k;
    return r->change[k].is_refused ? SS_REFUSALS_REFUSED : SS_REFUSALS_TAKEN;
}
