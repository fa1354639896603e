/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The headless world on the bundled kidney, all of it, which has work for more threads than one. */
#include "common/test.h"
#include "kidney_fixture.h"

static uint64_t hash_after_press(int32_t threads, const char *rate)
{
    const char *const set[] = {"object.mesh=" KIDNEY_MESH, rate};
    softsim_world *world = make_world(threads, set, 2);
    softsim_force last;
    double peak;
    press_and_release(world, FULL_IN_RELEASE(300, 30), 0.006, &last, &peak);
    const uint64_t hash = softsim_hash(world);
    softsim_destroy(&world);
    return hash;
}

TEST(bits_do_not_depend_on_threads)
{
    static const char *const rates[] = {"simulation.rate_hz=1000", "simulation.rate_hz=100"};
    for (int i = FULL_IN_RELEASE(0, 1); i < 2; ++i) {
        const uint64_t one = hash_after_press(1, rates[i]);
        if (FULL_IN_RELEASE(true, false)) {
            assert_true(one == hash_after_press(1, rates[i]));
            assert_true(one == hash_after_press(2, rates[i]));
        }
        assert_true(one == hash_after_press(4, rates[i]));
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
