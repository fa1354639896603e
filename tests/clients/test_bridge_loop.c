/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The bridge's loop without a network: what it exerts, and whose limits it holds. */
#include "common/test.h"

#include <math.h>

#include "bridge.h"
#include "common/number_fixture.h"
#include "rt/vec.h"

/* A device that goes 5 mm into the tissue and out again at 0.3 m/s. */
typedef struct stroke {
    int tick;
    double most, least; /* N: of what was exerted */
} stroke;

static bool read_stroke(void *state, ss_device_sample *out_sample)
{
    const stroke *s = state;
    const double way = 0.3e-3 * s->tick, depth = way < 5e-3 ? way : 10e-3 - way;
    *out_sample = (ss_device_sample){.position = {0.0, 0.0, -depth},
                                     .orientation = {1.0, 0.0, 0.0, 0.0},
                                     .true_position = {0.0, 0.0, -depth},
                                     .true_velocity = {NAN, NAN, NAN}};
    return depth > -2e-3;
}

static void exert_stroke(void *state, const double force[3])
{
    stroke *s = state;
    ++s->tick;
    s->most = fmax(s->most, ss_norm3(force));
    s->least = fmin(s->least, force[2]);
}

/* 200 N/m: 1 N at 5 mm, and 6 N by damping. */
TEST(the_bridge_s_own_damping_stays_within_the_limit_and_does_not_pull)
{
    static ss_bridge bridge;
    stroke done = {0};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_frame frame;
    const ss_device device = {.state = &done,
                              .period_s = 1e-3,
                              .max_exerted_n = 10.0,
                              .read = read_stroke,
                              .exert = exert_stroke};
    const ss_bridge_config config = {.tick_count = 100, .damping_n_s_per_m = 20.0};
    ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 0.5, &error);
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    bridge.corrector.limits = (ss_corrector_limits){1.2, INFINITY};
    ss_bridge_run_linear(&bridge, 200.0, 0);
    ss_bridge_fini(&bridge);
    assert_near(done.most, 0.6, 1e-12); /* half of it at the device: the scale */
    assert_near(done.least, 0.0, 0.0);
}

/* The first force, one after a quarter of a second without any, and one numbered from 1 again may
 * be of another server. */
TEST(limits_are_forgotten_when_another_server_may_answer)
{
    static const struct {
        int32_t seq, ms;
        bool is_anew;
    } forces[] = {{5000, 1, true}, {5001, 2, false}, {4990, 3, false},     {5002, 4, false},
                  {1, 5, true},    {2, 6, false},    {INT32_MIN, 7, true}, {1, 8, false},
                  {2, 258, false}, {3, 509, true},   {4, 510, false}};
    static ss_bridge bridge;
    const ss_device device = {.period_s = 1e-3};
    const ss_bridge_config config = {.tick_count = 100};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_frame frame;
    ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 1.0, &error);
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    for (size_t i = 0; i < sizeof forces / sizeof *forces; ++i) {
        const softsim_force force = {.seq = forces[i].seq, .pose_seq = 1};
        bridge.wants_scene = false;
        bridge.corrector.limits.force_n = 8.0;
        ss_bridge_take_force(&bridge, &force, 1000000LL * forces[i].ms);
        assert_int_equal(bridge.wants_scene, forces[i].is_anew);
        assert_near(bridge.corrector.limits.force_n, forces[i].is_anew ? 0.0 : 8.0, 0.0);
    }
    ss_bridge_fini(&bridge);
}

/* Nor does it hold those that a stranger told whose place it has taken, however soon. */
TEST(limits_are_forgotten_when_another_server_has_been_taken)
{
    static ss_bridge bridge;
    const ss_device device = {.period_s = 1e-3};
    const ss_bridge_config config = {.tick_count = 100};
    const softsim_force first = {.seq = 5000, .pose_seq = 1}, next = {.seq = 5001, .pose_seq = 2};
    ss_speakers heard = {.has_force = true};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_frame frame;
    ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 1.0, &error);
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    ss_bridge_take_force(&bridge, &first, 1000000);
    ss_bridge_watch_servers(&bridge, &heard, 1000000);
    bridge.wants_scene = false;
    bridge.corrector.limits = (ss_corrector_limits){1000.0, 1e6};
    heard.second = 100;
    ss_bridge_watch_servers(&bridge, &heard, 100000000);
    assert_near(bridge.corrector.limits.force_n, 1000.0, 0.0);
    heard.changes = 1;
    ss_bridge_take_force(&bridge, &next, 102000000);
    ss_bridge_watch_servers(&bridge, &heard, 102000000);
    assert_near(bridge.corrector.limits.force_n, 0.0, 0.0);
    assert_near(bridge.corrector.limits.slew_n_per_s, 2000.0, 0.0);
    assert_true(bridge.wants_scene);
    ss_bridge_fini(&bridge);
}

/* 10 N at 5 mm; the first server's scene allows 8, one in its place 1000, and tells it. */
TEST(no_other_server_raises_the_most_that_is_exerted)
{
    static ss_bridge bridge;
    static const char *const told[] = {"haptic.max_force_n=3 0.1 8 N",
                                       "haptic.max_force_n=900 0 1000 N"};
    stroke done = {0};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_frame frame;
    const ss_device device = {.state = &done,
                              .period_s = 1e-3,
                              .max_exerted_n = 20.0,
                              .read = read_stroke,
                              .exert = exert_stroke};
    const ss_bridge_config config = {.tick_count = 100};
    ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 1.0, &error);
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    const softsim_force first = {.seq = 1, .pose_seq = 1};
    const softsim_scene_report stranger = {.parameter_count = 1,
                                           .parameter = {"haptic.max_force_n=1 0 1e-9 N"}};
    ss_speakers heard = {.has_force = true};
    ss_bridge_take_scene(&bridge, &stranger); /* whose forces never come */
    ss_bridge_take_force(&bridge, &first, 1000000);
    for (int i = 0; i < 2; ++i) {
        const softsim_scene_report scene = {.parameter_count = 1, .parameter = {told[i]}};
        ss_bridge_take_scene(&bridge, &scene);
        for (int64_t ms = 1; ms < 100; ++ms) {
            ss_bridge_watch_servers(&bridge, &heard, 1000000 * (100 * i + ms));
        }
    }
    ss_bridge_run_linear(&bridge, 2000.0, 0);
    ss_bridge_fini(&bridge);
    assert_near(done.most, 8.0, 1e-12);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
