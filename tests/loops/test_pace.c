/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include "common/number_fixture.h"
#include "loops/pace.h"

enum { MS = 1000000 };

/* Steps of the clock's time, one after the other; the first ends at 1 s. */
typedef struct runner {
    ss_pace pace;
    int64_t now_ns;
} runner;

static runner begin(int64_t period_ns)
{
    runner r = {.now_ns = 1000 * (int64_t)MS};
    ss_pace_init(&r.pace, period_ns);
    ss_pace_note(&r.pace, r.now_ns);
    return r;
}

static void step(runner *r, int64_t took_ns)
{
    r->now_ns += took_ns;
    ss_pace_note(&r->pace, r->now_ns);
}

/* 853 of 1000 steps a second, and 212 of 250, were called good. */
TEST(what_falls_behind_is_slow_after_half_a_second)
{
    static const struct {
        int64_t period_ns;
        double share;
    } cases[] = {{MS, 0.853}, {4 * MS, 0.848}, {MS / 4, 0.5}, {10 * MS, 0.9}, {MS, 0.94}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        runner r = begin(cases[c].period_ns);
        const int64_t took_ns = (int64_t)((double)cases[c].period_ns / cases[c].share);
        while (r.now_ns < 1490 * (int64_t)MS) {
            step(&r, took_ns);
            assert_true(ss_pace_share(&r.pace) == 1.0); /* too early to say */
        }
        while (r.now_ns < 1560 * (int64_t)MS) {
            step(&r, took_ns);
        }
        assert_near(ss_pace_share(&r.pace), cases[c].share, 0.01);
        assert_true(ss_pace_share(&r.pace) < SS_PACE_LEAST);
    }
}

TEST(what_loses_every_seventh_period_is_slow)
{
    runner r = begin(MS);
    for (int k = 0; k < 1000; ++k) {
        step(&r, k % 6 == 0 ? 2 * MS : MS);
    }
    assert_near(ss_pace_share(&r.pace), 6.0 / 7.0, 0.01);
}

TEST(what_keeps_up_is_not_slow_whatever_one_step_took)
{
    static const int64_t hiccup_ms[] = {2, 25, 100, 400, 3000};
    for (size_t c = 0; c < sizeof hiccup_ms / sizeof *hiccup_ms; ++c) {
        runner r = begin(MS);
        for (int k = 0; k < 3000; ++k) {
            step(&r, k == 1000 ? hiccup_ms[c] * MS : MS + (k % 2 == 0 ? MS / 10 : -MS / 10));
            assert_true(ss_pace_share(&r.pace) >= SS_PACE_LEAST);
        }
    }
}

/* A body touched for the first time: some twenty steps of two periods each. */
TEST(a_first_touch_is_no_slowness)
{
    runner r = begin(MS);
    for (int k = 0; k < 2000; ++k) {
        step(&r, k >= 1000 && k < 1022 ? 2 * MS : MS);
        assert_true(ss_pace_share(&r.pace) >= SS_PACE_LEAST);
    }
}

TEST(steps_longer_than_the_window_are_slow)
{
    runner r = begin(100 * MS);
    for (int k = 0; k < 6; ++k) {
        step(&r, 1000 * MS);
    }
    assert_near(ss_pace_share(&r.pace), 0.1, 1e-9);
}

TEST(slowness_is_forgotten_within_a_second)
{
    runner r = begin(MS);
    for (int k = 0; k < 1000; ++k) {
        step(&r, 2 * MS);
    }
    assert_true(ss_pace_share(&r.pace) < 0.6);
    for (int k = 0; k < 600; ++k) {
        step(&r, MS);
    }
    assert_true(ss_pace_share(&r.pace) == 1.0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
