/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The simulation rate that a scene leaves open: by counts, and in real time by a yardstick. */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/number_fixture.h"
#include "common/pose_fixture.h"
#include "rt/clock.h"
#include "world/plan.h"
#include "world/world.h"

#define SCENES SOURCE_DIR "/server/scenes/"

static ss_world *create(const char *scene, bool is_lockstep, double yardstick, const char *set)
{
    static softsim_error error;
    memset(&error, 0, sizeof error);
    const ss_world_options options = {.scene_path = scene,
                                      .set = &set,
                                      .set_count = set != NULL ? 1 : 0,
                                      .threads = 1,
                                      .is_lockstep = is_lockstep,
                                      .yardstick = yardstick,
                                      .has_budget = !is_lockstep,
                                      .import_program = BIN_DIR "/softsim-import"};
    ss_world *world = NULL;
    if (ss_world_create(&options, &world, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return world;
}

static double share_of(const ss_world *world)
{
    return world->yardstick * world->step_cost_us / (1e6 * world->step_period);
}

/* The least step of at most half the core; where longer ones stop to help, the first of those. */
TEST(the_rate_follows_the_yardstick)
{
    static const char *const scenes[] = {SCENES "kidney.yaml", SCENES "liver-chainmail.yaml",
                                         SCENES "ventricle.yaml", SCENES "kidney-tissue.yaml"};
    static const double yardsticks[] = {0.01, 1.0, 4.0, 16.0, 64.0};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; ++s) {
        ss_world *world = create(scenes[s], false, 0.01, NULL);
        assert_near(world->yardstick, 0.01, 0.0);
        assert_int_equal(world->step_ticks, 1);
        int32_t last = 1;
        for (size_t k = 0; k < sizeof yardsticks / sizeof *yardsticks; ++k) {
            world->planned_yardstick = 0.0;
            ss_world_rate_by_counts(world, 0.0);
            world->yardstick = yardsticks[k];
            ss_world_rate_by_yardstick(world);
            print_message("%s: %g: every %d, %.3g of a core\n", scenes[s] + strlen(SCENES),
                          yardsticks[k], world->step_ticks, share_of(world));
            assert_true(world->step_ticks >= last || share_of(world) > 0.7);
            last = world->step_ticks;
            if (share_of(world) > 0.7) { /* nor would a step twice as long do */
                const double share = share_of(world);
                world->step_period *= 2.0;
                const ss_model_plan plan = ss_world_plan(world);
                world->step_cost_us = world->model_class->step_cost_us(&plan);
                assert_true(share_of(world) > 0.8 * share);
            }
        }
        ss_world_destroy(&world);
    }
    ss_world *slow = create(SCENES "kidney.yaml", false, 16.0, NULL);
    assert_true(slow->step_ticks > 1 && share_of(slow) <= 0.5);
    ss_world_destroy(&slow);
}

TEST(a_given_rate_and_lockstep_know_no_yardstick)
{
    ss_world *given = create(SCENES "kidney.yaml", false, 64.0, "simulation.rate_hz=500");
    assert_int_equal(given->step_ticks, 2);
    assert_near(given->yardstick, 0.0, 0.0);
    ss_world_destroy(&given);
    ss_world *counted = create(SCENES "kidney.yaml", true, 0.0, NULL);
    assert_int_equal(counted->step_ticks, 1);
    assert_near(counted->yardstick, 0.0, 0.0);
    ss_world_destroy(&counted);
}

static uint64_t press(ss_world *world)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    for (int32_t i = 0; i < 120; ++i) {
        const softsim_pose pose = {
            .sender = 1, .seq = i + 1, .position = {0.0, 0.0, 0.04 - 2e-4 * i}, PLAIN_POSE};
        const int32_t channel = 0;
        (void)ss_world_lockstep(world, &pose, &channel, 1, force);
    }
    ss_world_settle(world);
    return ss_world_hash(world);
}

/* What was timed is as it was built: the same run has the same hash. */
TEST(a_model_that_was_timed_is_at_rest_again)
{
#define ELASTIC ", youngs_modulus_pa: 5e+3, poisson_ratio: 0.45, density_kg_m3: 1060"
    static const struct {
        const char *scene, *set;
    } rows[] = {{"kidney.yaml", NULL},
                {"liver-chainmail.yaml", NULL},
                {"ventricle.yaml", NULL},
                {"kidney-tissue.yaml", NULL},
                {"hm1-tissue.yaml", NULL},
                {"hm2-tissue.yaml", NULL},
                {"ventricle.yaml", "model={name: xpbd" ELASTIC "}"},
                {"ventricle.yaml", "model={name: corotational" ELASTIC "}"},
                {"ventricle.yaml", "model={name: mass-spring, youngs_modulus_pa: 5e+3}"},
                {"liver-chainmail.yaml", "model={name: chainmail, alpha: 0.05, beta: 0.05}"}};
    for (size_t s = 0; s < sizeof rows / sizeof *rows; ++s) {
        char path[512];
        (void)snprintf(path, sizeof path, SCENES "%s", rows[s].scene);
        ss_world *timed = create(path, true, 0.0, rows[s].set);
        ss_world *fresh = create(path, true, 0.0, rows[s].set);
        const double yardstick = ss_world_measure_yardstick(timed);
        print_message("%s, %s: %.2f\n", rows[s].scene, timed->model_class->name, yardstick);
        assert_true(isfinite(yardstick) && yardstick > 0.0);
        assert_true(ss_world_hash(timed) == ss_world_hash(fresh));
        assert_true(press(timed) == press(fresh));
        ss_lockstep_stop(timed);
        ss_lockstep_stop(fresh);
        ss_world_destroy(&timed);
        ss_world_destroy(&fresh);
    }
}

/* A step of a body that is far too large, in time of this thread. */
static int slow_steps;
static void step_slowly(ss_model *model, double time, double step, const ss_model_tool *tool)
{
    (void)model;
    (void)time;
    (void)step;
    (void)tool;
    ++slow_steps;
    for (const int64_t end_ns = ss_clock_thread_cpu_ns() + 300000000;
         ss_clock_thread_cpu_ns() < end_ns;) {
    }
}

TEST(a_body_that_is_far_too_large_is_timed_by_few_steps)
{
    ss_world *world = create(SCENES "kidney.yaml", true, 0.0, NULL);
    const ss_model_class *own = world->model_class;
    ss_model_class slow = *own;
    slow.step = step_slowly;
    world->model_class = &slow;
    const double yardstick = ss_world_measure_yardstick(world);
    world->model_class = own;
    assert_in_range(slow_steps, 1, 2);
    assert_near(yardstick, 4.0, 0.0); /* the most that is believed */
    ss_world_destroy(&world);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
