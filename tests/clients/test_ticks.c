/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What a replay takes from a lockstep server's statuses: they may say anything. */
#include "common/test.h"

#include <stdint.h>

#include "ticks.h"

static softsim_server_status make_status(int64_t received, int64_t malformed, int64_t other_type)
{
    softsim_server_status status = {.state_hash = 5, .poses_received = received};
    status.poses_refused[SOFTSIM_REFUSED_MALFORMED] = malformed;
    status.poses_refused[SOFTSIM_REFUSED_TYPE_HASH] = other_type;
    status.poses_refused[SOFTSIM_REFUSED_OTHER] = 7; /* ticks, or commands that are not received */
    return status;
}

TEST(poses_that_are_some_are_ticks)
{
    ss_ticks ticks = {.count = 0};
    const softsim_server_status status = make_status(1000, 20, 3);
    ss_ticks_take_status(&ticks, &status);
    assert_int_equal(ticks.statuses, 1);
    assert_int_equal(ticks.count, 977);
    assert_false(ticks.is_real_time);
}

TEST(counts_that_cannot_be_are_not_taken)
{
    static const int64_t bad[][3] = {{INT64_MIN, 0, 0},       {-1, 0, 0},        {5, INT64_MIN, 0},
                                     {5, 0, INT64_MIN},       {INT64_MAX, 0, 0}, {5, INT64_MAX, 2},
                                     {(1LL << 53) + 1, 0, 0}, {5, 0, INT64_MAX}, {5, -1, 0}};
    ss_ticks ticks = {.count = 0};
    const softsim_server_status good = make_status(9, 0, 0);
    ss_ticks_take_status(&ticks, &good);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        const softsim_server_status status = make_status(bad[i][0], bad[i][1], bad[i][2]);
        ss_ticks_take_status(&ticks, &status);
        assert_int_equal(ticks.statuses, 1);
        assert_int_equal(ticks.count, 9);
    }
}

TEST(a_server_in_real_time_counts_none)
{
    ss_ticks ticks = {.count = 0};
    softsim_server_status status = make_status(9, 0, 0);
    status.state_hash = 0;
    ss_ticks_take_status(&ticks, &status);
    assert_true(ticks.is_real_time);
    assert_int_equal(ticks.statuses, 0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
