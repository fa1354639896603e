/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The share of the force that a bridge keeps from the hand. */
#include "common/test.h"

#include "common/number_fixture.h"
#include "withhold.h"

static ss_withholding held;
static ss_speakers heard;
static int now_ms;

static int begin(void **state)
{
    (void)state;
    ss_withholding_begin(&held);
    heard = (ss_speakers){.has_force = false};
    now_ms = 1;
    return 0;
}

/* `count` periods of 1 ms in which nothing else is heard. */
static void pass(int count)
{
    for (int i = 0; i < count; ++i) {
        ss_withholding_step(&held, &heard, true, 1000000LL * now_ms++, 1e-3);
    }
}

TEST_WITH(a_force_comes_whole_within_fifty_periods_of_one_server, begin, NULL)
{
    pass(500);
    assert_near(held.share, 1.0, 0.0); /* nobody has answered */
    heard.has_force = true;
    pass(40);
    assert_near(held.share, 1.0, 0.0);
    assert_false(ss_withholding_is_waiting(&held)); /* for another: as every start */
    pass(5);
    assert_near(held.share, 0.5, 1e-9);
    pass(6);
    assert_near(held.share, 0.0, 1e-9);
    pass(1000);
    assert_near(held.share, 0.0, 0.0);
}

TEST_WITH(with_a_second_s_message_it_takes_two_seconds_without_another, begin, NULL)
{
    heard.has_force = true;
    pass(20);
    for (int i = 0; i < 30; ++i) { /* as seldom as a server answers who does not hold the probe */
        ++heard.second;
        pass(100);
        assert_near(held.share, 1.0, 0.0);
        assert_true(ss_withholding_is_waiting(&held));
    }
    pass(1900);
    assert_near(held.share, 1.0, 0.0);
    pass(251);
    assert_near(held.share, 0.5, 1e-2); /* in half a second: the hand may be anywhere by now */
    pass(251);
    assert_near(held.share, 0.0, 1e-9);
    assert_false(ss_withholding_is_waiting(&held));
}

TEST_WITH(a_message_before_the_first_force_is_a_second_s_too, begin, NULL)
{
    ++heard.second;
    pass(1);
    heard.has_force = true;
    pass(1000);
    assert_near(held.share, 1.0, 0.0);
}

TEST_WITH(while_two_answer_the_force_goes_and_comes_slowly, begin, NULL)
{
    heard.has_force = true;
    pass(100);
    ++heard.second; /* alone takes nothing from the hand */
    pass(1);
    assert_near(held.share, 0.0, 0.0);
    heard.are_two = true;
    pass(10);
    assert_near(held.share, 0.5, 1e-9);
    pass(10);
    assert_near(held.share, 1.0, 1e-9);
    heard.are_two = false;
    pass(250);
    assert_near(held.share, 0.5, 1e-9);
}

TEST_WITH(another_in_its_place_is_alone_for_two_seconds_first, begin, NULL)
{
    heard.has_force = true;
    pass(100);
    ++heard.changes;
    heard.second += 100; /* what it said before it was taken */
    ss_withholding_step(&held, &heard, false, 1000000LL * now_ms++, 1e-3);
    assert_near(held.share, 1.0, 0.0);
    pass(1999);
    assert_near(held.share, 1.0, 0.0);
    assert_false(ss_withholding_is_waiting(&held));
    pass(501);
    assert_near(held.share, 0.0, 1e-9);
    ++heard.changes; /* the force of the one before is still on its way to the hand */
    pass(10);
    assert_near(held.share, 0.5, 1e-9);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
