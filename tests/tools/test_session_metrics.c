/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Planted signals give known metrics. */
#include "common/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/latency/session_metrics.h"
#include "rt/vec.h"

#define T 1e-3
enum { ROWS = 4000 };

static ss_felt_row row[ROWS];
static ss_felt felt;

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance)) {
        print_error("%.12g is not %.12g +- %g\n", value, expected, tolerance);
        fail();
    }
}

/* A spring of 500 N/m at z < 0 that answers `delay` rows late. */
static void plant(double (*depth)(double t), int delay)
{
    memset(row, 0, sizeof row);
    for (int i = 0; i < ROWS; ++i) {
        row[i].time_s = i * T;
        row[i].x[2] = -depth(i * T);
        row[i].f[2] = i >= delay ? fmax(0.0, 500.0 * depth((i - delay) * T)) : 0.0;
        row[i].age_us = 1000;
    }
}

static void judge(void)
{
    const ss_felt_options options = {.intended_contacts = 1, .age_limit_us = 2000.0};
    assert_int_equal(ss_felt_judge(row, ROWS, &options, &felt), SOFTSIM_OK);
}

static double still(double t)
{
    const double u = fmin(1.0, fmin(fmax(0.0, t - 0.5), fmax(0.0, 3.5 - t)) / 0.25);
    return 4e-3 * u * u * (3.0 - 2.0 * u);
}

static double poke(double t)
{
    return 4e-3 * sin(2.0 * SS_PI * t);
}

static double shaking(double t)
{
    return still(t) + (still(t) > 3.9e-3 ? 0.2e-3 * sin(2.0 * SS_PI * 40.0 * t) : 0.0);
}

static double tapping(double t)
{
    return 1e-3 * sin(16.0 * SS_PI * t);
}

TEST(quiet_press_is_good_in_all)
{
    plant(still, 0);
    judge();
    assert_int_equal(felt.contacts, 1);
    assert_int_equal(felt.net_energy_j.verdict, SS_FELT_GOOD);
    assert_near(felt.net_energy_j.value, 0.0, 0.2e-3);
    assert_int_equal(felt.chatter_m.verdict, SS_FELT_GOOD);
    assert_near(felt.chatter_m.value, 0.0, 20e-6);
    assert_int_equal(felt.buzz.verdict, SS_FELT_GOOD);
    assert_int_equal(felt.continuity.verdict, SS_FELT_GOOD);
    assert_near(felt.bounces.value, 1.0, 0.0);
    assert_int_equal(felt.bounces.verdict, SS_FELT_GOOD);
    assert_int_equal(felt.age_p99_us.verdict, SS_FELT_GOOD);
}

/* A contact is half a period of w = 2 pi: F = K a sin(w(t - tau)) against x over tau .. tau + 1/2
 * s, sums in closed form. */
TEST(delay_hands_out_the_closed_form)
{
    for (int delay = 2; delay <= 10; delay += 4) {
        plant(poke, delay);
        judge();
        assert_int_equal(felt.contacts, 4);
        const double w = 2.0 * SS_PI;
        const double gift = 500.0 * 16e-6 * 500.0 * sin(0.5 * w * T) * sin(w * (delay + 0.5) * T);
        assert_near(felt.net_energy_j.value, -gift, 0.01 * gift);
        assert_int_equal(felt.net_energy_j.verdict, gift > 1e-3 ? SS_FELT_BAD : SS_FELT_GOOD);
    }
}

/* 0.2 mm at 40 Hz; its force through two first-order stages at 30 Hz: (40/30)^2/(1 + (40/30)^2). */
TEST(chatter_and_buzz_are_found)
{
    plant(shaking, 0);
    judge();
    assert_near(felt.chatter_m.value, 0.2e-3, 0.03 * 0.2e-3);
    assert_near(felt.chatter_hz, 40.0, 1.0);
    assert_int_equal(felt.chatter_m.verdict, SS_FELT_BAD);
    const double rough = 1600.0 / (1600.0 + 900.0) * 0.1 / sqrt(2.0);
    assert_near(felt.buzz.value, rough / 2.0, 0.03 * rough / 2.0);
    assert_int_equal(felt.buzz.verdict, SS_FELT_FAIR);
}

TEST(steps_break_continuity)
{
    plant(still, 0);
    for (int i = 0; i < ROWS; ++i) {
        row[i].f[2] += row[i].f[2] > 1.0 && i / 16 % 2 == 0 ? 0.3 : 0.0;
    }
    judge();
    assert_near(felt.continuity.value, 0.3 / 2.3, 0.01);
    assert_int_equal(felt.continuity.verdict, SS_FELT_BAD);
}

TEST(bounces_are_counted)
{
    plant(tapping, 0);
    judge();
    assert_int_equal(felt.contacts, 32);
    assert_near(felt.bounces.value, 8.0, 1.0);
    assert_int_equal(felt.bounces.verdict, SS_FELT_BAD);
}

TEST(age_and_prediction_are_read)
{
    plant(still, 0);
    for (int i = 0; i < ROWS; ++i) {
        row[i].flags = i % 4 == 0 ? 0 : SOFTSIM_FORCE_PREDICTED;
        row[i].age_us = i % 50 == 0 ? 9000 : 1000;
    }
    judge();
    assert_near(felt.predicted_share, 0.75, 1e-12);
    assert_near(felt.age_p99_us.value, 9000.0, 0.0);
    assert_int_equal(felt.age_p99_us.verdict, SS_FELT_BAD);
}

TEST(free_motion_gets_no_verdict)
{
    plant(poke, 0);
    for (int i = 0; i < ROWS; ++i) {
        row[i].f[2] = 0.0;
    }
    judge();
    assert_int_equal(felt.contacts, 0);
    assert_int_equal(felt.net_energy_j.verdict, SS_FELT_NONE);
    assert_int_equal(felt.chatter_m.verdict, SS_FELT_NONE);
    assert_int_equal(felt.continuity.verdict, SS_FELT_NONE);
    assert_string_equal(ss_felt_verdict_name(felt.buzz.verdict), "-");
}

TEST(bad_logs_are_refused)
{
    const ss_felt_options options = {0};
    plant(still, 0);
    assert_int_equal(ss_felt_judge(row, 1, &options, &felt), SOFTSIM_ERROR_ARGUMENT);
    row[5].time_s = row[4].time_s;
    assert_int_equal(ss_felt_judge(row, ROWS, &options, &felt), SOFTSIM_ERROR_ARGUMENT);
    plant(still, 0);
    row[5].f[1] = NAN;
    assert_int_equal(ss_felt_judge(row, ROWS, &options, &felt), SOFTSIM_ERROR_ARGUMENT);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
