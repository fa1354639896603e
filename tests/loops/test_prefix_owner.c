/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include <stdint.h>

#include "loops/prefix_owner.h"

/* The channel says which probe it is; what a pose names is the sender's affair. */
TEST(a_probe_out_of_range_is_nobodys)
{
    static const int32_t named[] = {-1, 8, 1000, INT32_MIN, INT32_MAX};
    struct {
        char before[256];
        ss_prefix_owner owner;
        char behind[256];
    } guarded = {.owner = {.start_us = 1}}, untouched = guarded;
    for (size_t i = 0; i < sizeof named / sizeof *named; ++i) {
        const softsim_pose pose = {.sender = 77, .probe = named[i]};
        ss_prefix_owner_note_pose(&guarded.owner, named[i], &pose, 5);
        ss_prefix_owner_note_early(&guarded.owner, named[i], &pose);
        assert_memory_equal(&guarded, &untouched, sizeof guarded);
    }
    const softsim_pose pose = {.sender = 77, .probe = INT32_MAX};
    ss_prefix_owner_note_pose(&guarded.owner, 3, &pose, 5);
    assert_int_equal(guarded.owner.hand[3].sender, 77);
}

/* ---- a younger server that hears an elder ---- */

enum { MS = 1000000, ALICE = 1001, BOB = 2002 };
static const int64_t READY = 100000 * (int64_t)MS; /* ns of the clock */

static void hold(ss_prefix_owner *owner, int64_t sender, int32_t force_seq, int from_ms, int to_ms)
{
    for (int at_ms = from_ms; at_ms <= to_ms; ++at_ms) {
        const softsim_pose pose = {.sender = sender,
                                   .force_seq = at_ms == from_ms ? force_seq : at_ms};
        ss_prefix_owner_note_pose(owner, 0, &pose, READY + at_ms * (int64_t)MS);
    }
}

/* At `at_ms` after it was ready, where a server that is ten seconds older has been heard four times
 * a second since `heard_ms`. */
static ss_prefix_verdict judge(const ss_prefix_owner *owner, int heard_ms, int at_ms,
                               bool is_takeover)
{
    ss_other_server other = {.first_ns = 0};
    for (int t = heard_ms; t <= at_ms; t += 250) {
        const ss_net_status status = {.utime_us = (READY + t * (int64_t)MS) / 1000,
                                      .uptime_s = 10.0 + 1e-3 * t};
        ss_other_server_hear(&other, &status, READY + t * (int64_t)MS);
    }
    return ss_prefix_owner_judge(owner, &other, is_takeover, READY + at_ms * (int64_t)MS);
}

TEST(without_a_client_the_younger_gives_way)
{
    const ss_prefix_owner owner = {.start_us = READY / 1000};
    assert_int_equal(judge(&owner, 1000, 1250, false), SS_PREFIX_STAY); /* not confirmed */
    assert_int_equal(judge(&owner, 1000, 1500, false), SS_PREFIX_GIVE_WAY);
    assert_int_equal(judge(&owner, 1000, 9999, false), SS_PREFIX_GIVE_WAY);
    assert_int_equal(judge(&owner, 1000, 10001, false), SS_PREFIX_STAY);
    assert_int_equal(judge(&owner, 1000, 1500, true), SS_PREFIX_TELL);
}

/* What another says of itself may be forged. */
TEST(with_a_client_that_came_to_it_the_younger_stays)
{
    ss_prefix_owner owner = {.start_us = READY / 1000};
    hold(&owner, ALICE, -1, 500, 3000);
    assert_int_equal(judge(&owner, 1000, 3000, false), SS_PREFIX_STAY);
    assert_int_equal(judge(&owner, 1000, 4000, false), SS_PREFIX_STAY);
    assert_int_equal(judge(&owner, 1000, 4001, false), SS_PREFIX_GIVE_WAY); /* it has left */
    assert_int_equal(judge(&owner, 1000, 3000, true), SS_PREFIX_TELL);
    hold(&owner, ALICE, 77, 4500, 5000); /* and is here again */
    assert_int_equal(judge(&owner, 1000, 5000, false), SS_PREFIX_STAY);
    hold(&owner, BOB, 0, 5001, 6000); /* after the other was heard */
    assert_int_equal(judge(&owner, 1000, 6000, false), SS_PREFIX_GIVE_WAY);
}

/* A replay or a mouse names no force: the elder's client was once taken for the younger's, and both
 * went on. */
TEST(with_a_client_of_the_elder_the_younger_gives_way)
{
    static const struct {
        int from_ms;
        int32_t force_seq;
        int64_t early;
    } cases[] = {
        {600, -1, 0},  /* between two statuses of the elder */
        {2000, -1, 0}, /* after them */
        {0, 900, 0},   /* a bridge, long before the elder was heard again */
        {0, -1, ALICE} /* who had been sending */
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        ss_prefix_owner owner = {.start_us = READY / 1000};
        if (cases[c].early != 0) {
            const softsim_pose pose = {.sender = cases[c].early, .force_seq = -1};
            ss_prefix_owner_note_early(&owner, 0, &pose);
        }
        hold(&owner, ALICE, cases[c].force_seq, cases[c].from_ms, 3000);
        assert_int_equal(judge(&owner, 1000, 3000, false), SS_PREFIX_GIVE_WAY);
    }
    /* Who had been sending was another. */
    ss_prefix_owner owner = {.start_us = READY / 1000};
    const softsim_pose pose = {.sender = BOB, .force_seq = -1};
    ss_prefix_owner_note_early(&owner, 0, &pose);
    hold(&owner, ALICE, -1, 0, 3000);
    assert_int_equal(judge(&owner, 1000, 3000, false), SS_PREFIX_STAY);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
