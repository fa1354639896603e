/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* net/senders: who sends much, or many who each send little, take nothing from another. */
#include "common/test.h"

#include <stdbool.h>

#include "net/senders.h"

enum { ONE_PER_S = 100, ALL_PER_S = 900, NEWCOMERS_PER_S = ALL_PER_S / 4, NEWCOMER = 100000 };
static const int64_t MS = 1000000, START = 5000000000;

static bool say(ss_senders *senders, uint64_t source, int64_t now_ns)
{
    return ss_senders_hear(senders, source, now_ns) == SS_SENDERS_HEARD;
}

/* Senders 1 to `count` say `per_s` together for three seconds, in turn. Returns when; what was
 * heard of the last second. */
static int64_t keep_busy(ss_senders *senders, int count, int per_s, int *out_heard)
{
    int64_t now_ns = START;
    *out_heard = 0;
    for (int64_t i = 0; i < 3 * per_s; ++i) {
        now_ns = START + i * 1000 * MS / per_s;
        *out_heard += say(senders, 1 + (uint64_t)(i % count), now_ns) && i >= 2 * per_s;
    }
    return now_ns;
}

TEST(one_alone_may_say_what_one_may)
{
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    for (int i = 0; i < 1 + ONE_PER_S; ++i) {
        assert_true(say(&senders, 1, START));
    }
    assert_int_equal(ss_senders_hear(&senders, 1, START), SS_SENDERS_OVER);
    /* And goes on as fast as that is forgotten. */
    int heard = 0;
    for (int i = 0; i < 3000; ++i) {
        heard += say(&senders, 1, START + i * MS);
    }
    assert_in_range(heard, 3 * ONE_PER_S - 3, 3 * ONE_PER_S + 3);
}

/* Each says less than one may, all together what two dozen may, or twenty times as much. */
static const int counts[] = {1, 8, 24, 32, 40, 64, 128, SS_SENDERS - 1};
static const int rates[] = {400, 1200, 5000, 20000};

TEST(a_newcomer_is_heard_beside_any_number_of_others)
{
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        for (size_t r = 0; r < sizeof rates / sizeof *rates; ++r) {
            int heard = 0;
            ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
            const int64_t now_ns = keep_busy(&senders, counts[k], rates[r], &heard);
            for (uint64_t n = 0; n < 6; ++n) {
                if (!say(&senders, NEWCOMER + n, now_ns)) {
                    fail_msg("newcomer %d beside %d at %d a second", (int)n, counts[k], rates[r]);
                }
            }
        }
    }
}

/* A second message of it is heard too, and then as many as of the others, who never stop. */
TEST(a_newcomer_then_has_the_share_of_all)
{
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        int ignored = 0, heard = 0;
        ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
        int64_t now_ns = keep_busy(&senders, counts[k], 20000, &ignored);
        assert_true(say(&senders, NEWCOMER, now_ns));
        assert_true(say(&senders, NEWCOMER, now_ns + MS));
        for (int i = 0; i < 5 * 20000; ++i) {
            now_ns += MS / 20;
            say(&senders, 1 + (uint64_t)(i % counts[k]), now_ns);
            heard += say(&senders, NEWCOMER, now_ns);
        }
        const int fair = (ALL_PER_S - NEWCOMERS_PER_S) / (counts[k] + 3);
        const int share = fair < ONE_PER_S ? fair : ONE_PER_S;
        assert_in_range(heard, 5 * share - share / 2 - 5, 6 * share + 6);
    }
}

/* Who asks for less than those who never stop get is never refused. */
TEST(a_slow_one_is_always_heard)
{
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        int ignored = 0;
        ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
        int64_t now_ns = keep_busy(&senders, counts[k], 20000, &ignored);
        for (int i = 0; i < 5 * 20000; ++i) {
            now_ns += MS / 20;
            say(&senders, 1 + (uint64_t)(i % counts[k]), now_ns);
            if (i % 20000 == 0) {
                assert_true(say(&senders, NEWCOMER, now_ns));
            }
        }
    }
}

/* Eight others leave two shares over, so that forty commands one after the other are not too many.
 */
TEST(two_thirds_of_a_share_may_be_said_at_once)
{
    int ignored = 0;
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    const int64_t now_ns = keep_busy(&senders, 8, 1200, &ignored);
    const int share = (ALL_PER_S - NEWCOMERS_PER_S) / (8 + 2);
    for (int i = 0; i < 2 * share / 3; ++i) {
        assert_true(say(&senders, NEWCOMER, now_ns));
    }
}

TEST(all_together_are_bounded)
{
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        for (size_t r = 0; r < sizeof rates / sizeof *rates; ++r) {
            int heard = 0;
            ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
            keep_busy(&senders, counts[k], rates[r], &heard);
            assert_in_range(heard, 1, ALL_PER_S - NEWCOMERS_PER_S + 1);
        }
    }
}

/* Who goes on under another number with each message is a newcomer among newcomers: those who are
 * known lose nothing, whether they speak now and then or as often as they may. */
TEST(ever_new_numbers_take_nothing_from_known_ones)
{
    enum { RARE = 1, OFTEN, SECONDS = 20 };
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    uint64_t number = NEWCOMER;
    int64_t heard = 0;
    for (uint64_t known = RARE; known <= OFTEN; ++known) {
        assert_true(say(&senders, known, START));
        assert_true(say(&senders, known, START));
    }
    for (int i = 0; i < SECONDS * 10000; ++i) {
        const int64_t now_ns = START + i * 1000 * MS / 10000;
        const ss_senders_answer answer = ss_senders_hear(&senders, number++, now_ns);
        assert_int_not_equal(answer, SS_SENDERS_OVER);
        heard += answer == SS_SENDERS_HEARD;
        if (i % 50000 == 0) {
            assert_true(say(&senders, RARE, now_ns));
        }
        if (i % 110 == 0) {
            assert_true(say(&senders, OFTEN, now_ns));
        }
    }
    /* Their own, and what the known ones leave of half of theirs. */
    const int32_t half = (ALL_PER_S - NEWCOMERS_PER_S) / 2;
    assert_in_range(heard, SECONDS * (NEWCOMERS_PER_S + half - ONE_PER_S),
                    SS_SENDERS + SECONDS * (NEWCOMERS_PER_S + half));
}

/* With two messages of each it does take places, and still no more than the bound. */
TEST(many_numbers_are_bounded_together)
{
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    const int seconds = 5;
    int64_t heard = 0;
    for (int i = 0; i < seconds * 20000; ++i) {
        heard += say(&senders, NEWCOMER + (uint64_t)i / 2, START + i * 1000 * MS / 20000);
    }
    assert_true(heard <= SS_SENDERS + (int64_t)(seconds + 1) * ALL_PER_S);
}

TEST(who_paused_has_said_all_it_may)
{
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    say(&senders, 1, START);
    ss_senders_pause(&senders, 1, 1000 * MS);
    assert_false(say(&senders, 1, START + 999 * MS));
    assert_true(say(&senders, 1, START + 1001 * MS));
    assert_false(say(&senders, 1, START + 1001 * MS));
    assert_true(say(&senders, 1, START + 1012 * MS)); /* one in a hundredth of a second */
}

/* A tiny number would be multiplied for ever. */
TEST(what_was_said_is_forgotten_at_last)
{
    ss_senders senders = ss_senders_make(ONE_PER_S, ALL_PER_S);
    say(&senders, 1, START);
    say(&senders, 1, START);
    for (int i = 1; i < 800 * 100; ++i) {
        ss_senders_hear(&senders, 2, START + i * 10 * MS);
    }
    assert_true(senders.said[0] == 0.0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
