/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* net/senders: who sends much takes nothing from another, how many ever they are. */
#include "common/test.h"

#include <stdbool.h>

#include "net/senders.h"

enum { PER_S = 100, BURST = 50, NEWCOMER = 1000 };
static const int64_t MS = 1000000, START = 5000000000;

static bool say(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    ss_budget *budget = ss_senders_find(senders, source, now_ns);
    const bool may = ss_budget_left(budget, now_ns) >= 1;
    ss_budget_spend(budget, may);
    return may;
}

/* `count` senders that never stop, each half as often again as it may, for two seconds. */
static int64_t keep_busy(ss_senders *senders, int count)
{
    int64_t now_ns = START;
    for (int i = 0; i < 3 * PER_S; ++i) {
        now_ns = START + i * 1000 * MS * 2 / (3 * PER_S);
        for (uint64_t s = 1; s <= (uint64_t)count; ++s) {
            say(senders, s, now_ns);
        }
    }
    return now_ns;
}

TEST(each_has_a_budget_of_its_own)
{
    ss_senders senders = ss_senders_make(PER_S, BURST);
    for (uint64_t s = 1; s <= SS_SENDERS; ++s) {
        for (int i = 0; i < BURST; ++i) {
            assert_true(say(&senders, s, START));
        }
        assert_false(say(&senders, s, START));
    }
    assert_true(say(&senders, 1, START + 10 * MS));
    assert_false(say(&senders, 1, START + 10 * MS));
}

TEST(a_newcomer_is_heard_where_all_places_are_busy)
{
    ss_senders senders = ss_senders_make(PER_S, BURST);
    const int64_t now_ns = keep_busy(&senders, SS_SENDERS);
    assert_false(say(&senders, 1, now_ns));
    for (int i = 0; i < BURST + SS_ENTRY; ++i) {
        assert_true(say(&senders, NEWCOMER, now_ns));
    }
    assert_false(say(&senders, NEWCOMER, now_ns));
}

TEST(a_newcomer_is_heard_beside_more_busy_senders_than_places)
{
    static const int counts[] = {SS_SENDERS + 1, SS_SENDERS + 4, 3 * SS_SENDERS,
                                 SS_SENDERS + SS_PAST_SENDERS};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        ss_senders senders = ss_senders_make(PER_S, BURST);
        int64_t now_ns = keep_busy(&senders, counts[k]);
        for (int i = 0; i < SS_ENTRY; ++i) {
            assert_true(say(&senders, NEWCOMER, now_ns));
        }
        /* And then as often as anybody. */
        for (int i = 0; i < 20; ++i) {
            now_ns += 1000 * MS / PER_S;
            for (uint64_t s = 1; s <= (uint64_t)counts[k]; ++s) {
                say(&senders, s, now_ns);
            }
            assert_true(say(&senders, NEWCOMER, now_ns));
        }
    }
}

TEST(all_without_a_place_share_one_budget)
{
    ss_senders senders = ss_senders_make(PER_S, BURST);
    const int64_t now_ns = keep_busy(&senders, SS_SENDERS);
    int heard = 0;
    for (uint64_t s = NEWCOMER; s < NEWCOMER + 1000; ++s) {
        heard += say(&senders, s, now_ns);
    }
    /* And one each in the places of those who are over theirs. */
    assert_int_equal(heard, BURST + SS_SENDERS);
}

/* Who says all he may and goes on under another number gets no more than the places allow. */
TEST(senders_of_many_numbers_are_bounded_together)
{
    ss_senders senders = ss_senders_make(PER_S, BURST);
    const int64_t start_ns = keep_busy(&senders, SS_SENDERS);
    const int seconds = 3;
    int64_t heard = 0;
    for (int i = 0; i < seconds * 100 * PER_S; ++i) {
        heard += say(&senders, NEWCOMER + (uint64_t)i / (SS_ENTRY + 1),
                     start_ns + i * 1000 * MS / (100 * PER_S));
    }
    assert_true(heard <= (int64_t)(SS_SENDERS + 1 + SS_ENTRY) * (BURST + seconds * PER_S));
}

TEST(a_place_is_taken_only_when_its_budget_is_full)
{
    ss_senders senders = ss_senders_make(PER_S, BURST);
    const int64_t now_ns = keep_busy(&senders, SS_SENDERS);
    const int64_t full_ns = now_ns + 1000 * MS * (BURST + 1) / PER_S;
    ss_budget *first = ss_senders_find(&senders, 1, now_ns);
    assert_ptr_equal(ss_senders_find(&senders, NEWCOMER, now_ns), &senders.shared);
    assert_ptr_equal(ss_senders_find(&senders, NEWCOMER, full_ns), first);
    assert_true(say(&senders, NEWCOMER, full_ns));
    /* Then it is the newcomer's: the one before is a newcomer itself. */
    assert_ptr_not_equal(ss_senders_find(&senders, 1, full_ns), first);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
