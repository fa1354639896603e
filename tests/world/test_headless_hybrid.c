/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The headless world on the bundled hybrid ventricle: what the hand feels between steps. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "softsim/softsim.h"

/* Peak force, N, of the scene's tool that goes 17 mm inward at 100 mm/s and stays there a while. */
static double peak_of_press(const char *between_steps)
{
    const char *const set[] = {between_steps};
    softsim_config config = softsim_default_config();
    softsim_error error;
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    double peak = 0.0;
    config.set = set;
    config.set_count = 1;
    config.import_program = BIN_DIR "/softsim-import";
    memset(&error, 0, sizeof error);
    softsim_world *world =
        softsim_create(SOURCE_DIR "/server/scenes/hm1-tissue.yaml", &config, &error);
    if (world == NULL) {
        fail_msg("%s", error.text);
    }
    for (int32_t k = 0; k < 230; ++k) {
        softsim_pose pose = {.seq = k + 1,
                             .sender = 7,
                             .force_seq = -1,
                             .position = {0.045 - 1e-4 * fmin(k, 170), 0.0, -0.005},
                             .orientation = {1.0, 0.0, 0.0, 0.0}};
        for (int a = 0; a < 3; ++a) {
            pose.velocity[a] = pose.applied_force[a] = (double)NAN;
        }
        softsim_tick(world, &pose, &channel, 1, force);
        peak = fmax(peak, sqrt(force[0].force[0] * force[0].force[0] +
                               force[0].force[1] * force[0].force[1] +
                               force[0].force[2] * force[0].force[2]));
    }
    softsim_destroy(&world);
    return peak;
}

/* The local contact model goes by the stiffness that the body is estimated to have, which errs
 * high; not so far that a fast press feels like another body. */
static void a_fast_press_is_felt_as_the_model_answers(void **state)
{
    (void)state;
    const double held = peak_of_press("haptic.between_steps=hold");
    const double local = peak_of_press("haptic.between_steps=local");
    print_message("peak force: held %.3f N, local contact model %.3f N\n", held, local);
    assert_true(held > 0.3);
    assert_true(local > 0.95 * held && local < 1.5 * held);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fast_press_is_felt_as_the_model_answers),
    };
    return cmocka_run_group_tests_name("softsim.headless_hybrid", tests, NULL, NULL);
}
