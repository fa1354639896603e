/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What a grasp leaves between hand and proxy, at any rate of the haptic loop. */
#include "common/test.h"

#include "haptic_fixture.h"

/* Models fade a grasp out in 20 ms of their time: until then the proxy stays where the grasp left
 * it, at 10 kHz as at 1 kHz; afterwards it comes over the hand. */
TEST(the_proxy_stays_until_models_have_faded_the_grasp)
{
    static const double aside[3] = {0.0, 0.002, 0.0}, none[3] = {0.0, 0.0, 0.0};
    static const double periods[] = {1e-4, 2e-4, 1e-3, 2e-3};
    for (size_t k = 0; k < sizeof periods / sizeof *periods; ++k) {
        const double period = periods[k];
        const ss_balance balance = {.spring = 1000.0, .limit = 8.0};
        const ss_rest rest = {.stiffness_fraction = 1.0};
        ss_slip slip = {.limit = 8.0, .stiffness_fraction = 1.0};
        ss_slip_keep_aside(&slip, aside, period);
        for (int n = 0; n < (int)lround(0.020 / period); ++n) {
            ss_slip_take(&slip, &balance, &rest, none, 1000.0, period);
            assert_near(slip.aside[1], aside[1], 0.0);
        }
        for (int n = 0; n < (int)lround(0.020 / period); ++n) {
            ss_slip_take(&slip, &balance, &rest, none, 1000.0, period);
        }
        assert_true(slip.aside[1] < 0.99 * aside[1]);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
