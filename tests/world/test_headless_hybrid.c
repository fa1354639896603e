/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The headless world on the bundled hybrid ventricle: what the hand feels between steps. */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "common/effort.h"
#include "world_fixture.h"

static softsim_world *make_ventricle(const char *between_steps)
{
    const char *const set[] = {between_steps};
    return open_scene(SOURCE_DIR "/server/scenes/hm1-tissue.yaml", set, 1);
}

/* One tick with the tool at x, y; the force's magnitude, N. */
static double press_at(softsim_world *world, int32_t seq, double x, double y, double *out_stiffness)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    softsim_pose pose = {.seq = seq,
                         .sender = 7,
                         .force_seq = -1,
                         .position = {x, y, -0.005},
                         .orientation = {1.0, 0.0, 0.0, 0.0}};
    for (int a = 0; a < 3; ++a) {
        pose.velocity[a] = pose.applied_force[a] = (double)NAN;
    }
    softsim_tick(world, &pose, &channel, 1, force);
    *out_stiffness = force[0].stiffness;
    return sqrt(force[0].force[0] * force[0].force[0] + force[0].force[1] * force[0].force[1] +
                force[0].force[2] * force[0].force[2]);
}

/* Peak force, N, of the scene's tool that goes 17 mm inward at 100 mm/s and stays there a while. */
static double peak_of_press(const char *between_steps)
{
    softsim_world *world = make_ventricle(between_steps);
    double peak = 0.0, stiffness;
    for (int32_t k = 0; k < 230; ++k) {
        peak = fmax(peak, press_at(world, k + 1, 0.045 - 1e-4 * fmin(k, 170), 0.0, &stiffness));
    }
    softsim_destroy(&world);
    return peak;
}

/* The local contact model goes by the stiffness that the body is estimated to have, which errs
 * high; not so far that a fast press feels like another body. */
TEST(a_fast_press_is_felt_as_the_model_answers)
{
    SKIP_WHERE_REPEATED();
    const double held = peak_of_press("haptic.between_steps=hold");
    const double local = peak_of_press("haptic.between_steps=local");
    print_message("peak force: held %.3f N, local contact model %.3f N\n", held, local);
    assert_true(held > 0.3);
    assert_true(local > 0.95 * held && local < 1.5 * held);
}

/* Pressed 16 mm, slid 10 mm aside, let out by 1 mm every .6 s, with a rest after each: what is told
 * to be felt is what the force falls by, or more, but not several times it. */
TEST(a_deep_press_is_felt_as_stiff_as_it_is)
{
    SKIP_WHERE_REPEATED();
    softsim_world *world = make_ventricle("haptic.max_force_n=100");
    double least = INFINITY, most = 0.0, before = 0.0;
    for (int32_t k = 0; k < 3600; ++k) {
        const double in = fmin(k, 500) / 500.0, aside = fmin(fmax(k - 500, 0), 500) / 500.0;
        const double out = k < 1800 ? 0.0 : k / 600 - 3 + fmin(k % 600, 200) / 200.0;
        double stiffness;
        const double force =
            press_at(world, k + 1, 0.0425 - 0.020 * in + 1e-3 * out, 0.010 * aside, &stiffness);
        if (k % 600 == 599 && k > 1200) {
            const double slope = (before - force) / 1e-3;
            least = k > 1800 ? fmin(least, stiffness / slope) : least;
            most = k > 1800 ? fmax(most, stiffness / slope) : most;
            before = force;
        }
    }
    softsim_destroy(&world);
    print_message("felt stiffness: %.2f to %.2f of the force's slope\n", least, most);
    assert_true(least > 0.97 && most < 2.5);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
