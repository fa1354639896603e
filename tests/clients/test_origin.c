/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include "origin.h"

enum { MS = 1000000, FIRST = 7, SECOND = 11 };
static const int64_t start_ns = 50000000000;

static int64_t at_ms(int64_t ms)
{
    return start_ns + ms * MS;
}

TEST(of_two_servers_the_first_is_taken_and_both_are_told)
{
    ss_origin origin = {.silent_ns = 100 * MS};
    int told_after = -1;
    for (int k = 0; k < 1000; ++k) {
        assert_true(ss_origin_take(&origin, FIRST, at_ms(k)));
        assert_false(ss_origin_take(&origin, SECOND, at_ms(k) + 1000));
        if (told_after < 0 && ss_origin_hears_two(&origin, at_ms(k))) {
            told_after = k;
        }
    }
    assert_in_range(told_after, 0, 2); /* ms */
    /* The second is left: it is taken, and after a while there are no longer two. */
    int taken = 0;
    for (int k = 1000; k < 4000; ++k) {
        taken += ss_origin_take(&origin, SECOND, at_ms(k));
        assert_true(k > 2900 || ss_origin_hears_two(&origin, at_ms(k)));
    }
    assert_in_range(taken, 2890, 2910);
    assert_false(ss_origin_hears_two(&origin, at_ms(4000)));
}

/* Messages of an overloaded machine come in bursts, of each server in turn. */
TEST(two_servers_in_bursts_are_told)
{
    static const int bursts_ms[] = {1, 5, 30, 99, 150, 400};
    for (size_t c = 0; c < sizeof bursts_ms / sizeof *bursts_ms; ++c) {
        ss_origin origin = {.silent_ns = 100 * MS};
        for (int k = 0; k < 3000; ++k) {
            (void)ss_origin_take(&origin, k / bursts_ms[c] % 2 == 0 ? FIRST : SECOND, at_ms(k));
        }
        assert_true(ss_origin_hears_two(&origin, at_ms(3000)));
    }
}

/* Even one that is killed and started again time after time. */
TEST(a_restart_is_one_server_and_taken_up_at_once)
{
    ss_origin origin = {.silent_ns = 100 * MS};
    for (int k = 0; k < 6; ++k) {
        for (int i = 0; i < 700; ++i) {
            assert_true(ss_origin_take(&origin, (uint64_t)(FIRST + k), at_ms(1000 * k + i)));
            assert_false(ss_origin_hears_two(&origin, at_ms(1000 * k + i)));
            assert_int_equal(origin.changes, k);
        }
    }
}

TEST(one_stray_message_is_no_second_server)
{
    ss_origin origin = {.silent_ns = 100 * MS};
    for (int k = 0; k < 30000; ++k) {
        assert_true(ss_origin_take(&origin, FIRST, at_ms(k)));
        if (k % 3000 == 1500) {
            assert_false(ss_origin_take(&origin, SECOND, at_ms(k)));
        }
        assert_false(ss_origin_hears_two(&origin, at_ms(k)));
    }
}

TEST(statuses_four_times_a_second_tell_two_servers)
{
    ss_origin origin = {.silent_ns = 1000 * MS};
    for (int k = 0; k < 8; ++k) {
        assert_int_equal(ss_origin_take(&origin, k % 2 == 0 ? FIRST : SECOND, at_ms(125 * k)),
                         k % 2 == 0);
    }
    assert_true(ss_origin_hears_two(&origin, at_ms(1000)));
}

/* What says nothing of who speaks is taken from the first server alone, though it is silent, and
 * from any where none was. */
TEST(others_are_allowed_where_none_was_heard)
{
    ss_origin origin = {.silent_ns = 100 * MS};
    assert_true(ss_origin_allows(&origin, SECOND));
    assert_true(ss_origin_take(&origin, FIRST, at_ms(0)));
    assert_true(ss_origin_allows(&origin, FIRST));
    assert_false(ss_origin_allows(&origin, SECOND));
    assert_true(ss_origin_take(&origin, SECOND, at_ms(200)));
    assert_true(ss_origin_allows(&origin, SECOND));
    assert_false(ss_origin_hears_two(&origin, at_ms(200)));
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
