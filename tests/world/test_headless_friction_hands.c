/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Simulated hands that press, slide and tap on tissue with friction, in closed loop behind a bus
 * (tools/bench/felt/hand.h): they are handed no more than they may be without it. */
#include "common/test.h"

#include "bench/felt/hand.h"
#include "common/effort.h"
#include "press_fixture.h"

typedef struct row {
    ss_sim_script script;
    ss_sim_body body;
    ss_sim_grip grip;
    double rate_hz, delay_ms;
} row;

/* A surface of z = `height` under a ball of `radius`, m. */
static void play_all(const char *path, double x, double y, double height, double radius)
{
    static const row rows[] = {
        {SS_SCRIPT_SLIDE, SS_BODY_LIGHT, SS_GRIP_SOFT, 1000, 0},
        {SS_SCRIPT_SLIDE, SS_BODY_MEDIUM, SS_GRIP_SOFT, 60, 5},
        {SS_SCRIPT_SLIDE, SS_BODY_LIGHT, SS_GRIP_MEDIUM, 60, 10},
        {SS_SCRIPT_PRESS, SS_BODY_LIGHT, SS_GRIP_SOFT, 60, 10},
        {SS_SCRIPT_PRESS, SS_BODY_HEAVY, SS_GRIP_FIRM, 1000, 2},
        {SS_SCRIPT_TAP, SS_BODY_LIGHT, SS_GRIP_FIRM, 60, 0},
    };
    static const char *const set[] = {"contact.friction=0.3"};
    const ss_felt_place place = {.point = {x, y, height},
                                 .normal = {0.0, 0.0, 1.0},
                                 .along = {1.0, 0.0, 0.0},
                                 .orientation = {1.0, 0.0, 0.0, 0.0},
                                 .reach_m = radius,
                                 .depth_m = 0.003,
                                 .slide_m = 0.020,
                                 .radius_m = radius,
                                 .working_force_n = 2.0};
    softsim_error error = {.status = SOFTSIM_OK};
    for (size_t k = 0; k < FULL_IN_RELEASE(sizeof rows / sizeof *rows, 1); ++k) {
        const ss_hand_run run = {.script = rows[k].script,
                                 .body = rows[k].body,
                                 .grip = rows[k].grip,
                                 .seed = 1,
                                 .bus = {.delay_ms = rows[k].delay_ms},
                                 .seconds = 2.0,
                                 .rate_hz = rows[k].rate_hz,
                                 .scene = path,
                                 .place = &place,
                                 .set = set,
                                 .set_count = 1};
        ss_hand_outcome out;
        assert_int_equal(ss_hand_play(&run, &out, &error), SOFTSIM_OK);
        print_message("row %d: net %.3f of %.3f mJ, chatter %.4f mm, damped %lld, back-offs %lld\n",
                      (int)k, 1e3 * out.net_j, 1e3 * out.peak_j, 1e3 * out.felt.chatter_m.value,
                      (long long)out.damped_ticks, (long long)out.backoffs);
        assert_true(isfinite(out.least_limit_n_per_m)); /* it touched for long enough */
        assert_true(out.is_passive);
        assert_true(out.felt.chatter_m.value < 0.05e-3);
    }
}

TEST(hands_on_a_block_are_handed_no_more_than_without_friction)
{
    static const body b = {"corotational", NULL,     "  name: corotational\n" ELASTIC,
                           NULL,           ON_BLOCK, 0.0};
    write_block_mesh();
    play_all(write_block(&b), 0.0, 0.0, 0.020, 0.008);
}

TEST(hands_on_a_volume_of_the_kidney_are_handed_no_more_than_without_friction)
{
    SKIP_WHERE_REPEATED();
    play_all(SOURCE_DIR "/server/scenes/kidney-tissue.yaml", 0.0, 0.006, 0.0223, 0.005);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
