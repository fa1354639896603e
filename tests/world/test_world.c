/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The world between the loops: what a command, a skipped tick or a refused pose does to it. No
 * thread and no LCM: the test calls the pieces in the order in which the loops would.
 */
#include "common/test.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/pose_fixture.h"
#include "rt/thread.h"
#include "rt/vec.h"
#include "softsim/softsim.h"
#include "world/world.h"
#include "world_fixture.h"

#define SCENES SOURCE_DIR "/server/scenes/"

static ss_world *create(const char *scene, bool is_lockstep)
{
    static softsim_error error;
    memset(&error, 0, sizeof error);
    const ss_world_options options = {.scene_path = scene,
                                      .threads = 1,
                                      .is_lockstep = is_lockstep,
                                      .import_program = BIN_DIR "/softsim-import"};
    ss_world *world = NULL;
    if (ss_world_create(&options, &world, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return world;
}

static softsim_pose pose_of(int64_t sender, int32_t seq, int32_t probe)
{
    return (softsim_pose){
        .sender = sender, .seq = seq, .probe = probe, .position = {0.2, 0.0, 0.0}, PLAIN_POSE};
}

/* Set-up arithmetic belongs to the result: the daemon and a headless run set it up in the same way.
 * First: the mode stays. */
TEST(a_world_is_set_up_without_denormals)
{
    ss_world *world = create(SCENES "cylinder.yaml", false);
#if defined(__SSE__)
    const volatile float least = FLT_MIN;
    const volatile float half = least * 0.5f;
    assert_true(half == 0.0f);
#endif
    ss_world_destroy(&world);
}

/* The answer goes to who asked: the channel's client, whatever number the pose claims. */
TEST(lockstep_answers_a_wrong_probe_on_its_own_channel)
{
    ss_world *world = create(SCENES "kidney.yaml", true);
    static const int32_t claimed[] = {1, 7, -5, 1000000, INT32_MIN};
    for (int32_t i = 0; i < 5; ++i) {
        const softsim_pose pose = pose_of(1, i + 1, claimed[i]);
        const int32_t channel = 0;
        softsim_force force[SOFTSIM_MAX_PROBES];
        assert_int_equal(ss_world_lockstep(world, &pose, &channel, 1, force),
                         SOFTSIM_REFUSED_WRONG_PROBE);
        for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            assert_int_equal(force[p].probe, p);
        }
        assert_int_equal(force[0].pose_seq, i + 1);
        assert_int_equal(force[0].sender, 1);
    }
    assert_int_equal(world->tick, 5);
    ss_world_destroy(&world);
}

/* A scene without tools has no haptic loop that would empty a ring of commands. */
TEST(commands_are_taken_without_a_haptic_loop)
{
    ss_world *world = create(SCENES "cylinder.yaml", false);
    assert_int_equal(world->used_probes, 0);
    for (int i = 0; i < 500; ++i) {
        ss_command_record record;
        char text[256];
        const char *name = i % 2 == 0 ? "pause" : "resume";
        assert_int_equal(ss_world_command(world, name, "", &record, text, sizeof text), 0);
        ss_world_step_begin(world);
        assert_int_equal(world->simulation_run.is_paused, i % 2 == 0);
    }
    ss_world_destroy(&world);
}

/* Whoever adds one means something that would not happen. */
TEST(an_argument_that_is_not_taken_is_refused)
{
    static const char *const names[] = {"reset",   "pause",  "resume",
                                        "refresh", "status", "shutdown"};
    ss_world *world = create(SCENES "cylinder.yaml", false);
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        ss_command_record record;
        char text[256], wanted[64];
        snprintf(wanted, sizeof wanted, "%s takes no argument, but 'now' came", names[i]);
        assert_int_equal(ss_world_command(world, names[i], "now", &record, text, sizeof text), 2);
        assert_non_null(strstr(text, wanted));
        ss_world_step_begin(world);
        assert_false(world->simulation_run.is_paused);
        assert_int_equal(ss_world_command(world, names[i], "", &record, text, sizeof text), 0);
        assert_int_equal(ss_world_command(world, "resume", "", &record, text, sizeof text), 0);
        ss_world_step_begin(world);
    }
    /* Nor is anything behind a value, which it would belong to. */
    ss_command_record record;
    char text[512];
    static const char *const trailing[] = {"haptic.max_force_n=1 now", "haptic.max_force_n=1,2",
                                           "haptic.max_force_n", "haptic.max_force_n="};
    for (size_t i = 0; i < sizeof trailing / sizeof *trailing; ++i) {
        assert_int_equal(ss_world_command(world, "set", trailing[i], &record, text, sizeof text),
                         2);
    }
    ss_world_destroy(&world);
}

static int32_t set(ss_world *world, const char *argument, char *out_text, int32_t size)
{
    ss_command_record record;
    return ss_world_command(world, "set", argument, &record, out_text, size);
}

/* What the hand may feel is decided where the scene is; a command may only lower it. */
TEST(no_command_raises_a_limit_above_the_scenes)
{
    ss_world *world = create(SCENES "kidney.yaml", false);
    char text[512], argument[128];
    const struct {
        const char *key;
        double scene;
    } cases[] = {{"haptic.max_force_n", world->scene->max_force_n},
                 {"haptic.max_slew_n_per_s", world->scene->max_slew_n_per_s},
                 {"haptic.coupling.stiffness_n_per_m", world->scene->coupling_stiffness_n_per_m},
                 {"haptic.coupling.damping_n_s_per_m", world->scene->coupling_damping_n_s_per_m}};
    for (int i = 0; i < 4; ++i) {
        const double value[] = {0.5 * cases[i].scene, cases[i].scene};
        for (int k = 0; k < 2; ++k) { /* and back up to it */
            snprintf(argument, sizeof argument, "%s=%.17g", cases[i].key, value[k]);
            assert_int_equal(set(world, argument, text, sizeof text), 0);
        }
        snprintf(argument, sizeof argument, "%s=%.17g", cases[i].key, 1.001 * cases[i].scene);
        assert_int_equal(set(world, argument, text, sizeof text), 1);
        assert_non_null(strstr(text, cases[i].key));
        assert_non_null(strstr(text, "above the scene's"));
    }
    ss_world_destroy(&world);
}

static softsim_refusal judge_step(ss_world *world, int32_t seq, double x)
{
    softsim_pose pose = pose_of(1, seq, 0);
    uint32_t epoch = 0;
    pose.position[0] = x;
    return ss_gate_judge(world->gate, &pose, 0, seq * (int64_t)1000000, &epoch);
}

/* Neither of the loops, nor the gate: whichever of the rings is full. */
TEST(a_command_that_finds_no_room_changes_nothing)
{
    for (int full = 0; full < 2; ++full) {
        ss_world *world = create(SCENES "kidney.yaml", false);
        char text[512];
        ss_command_record record;
        int32_t taken = 0;
        while (ss_world_command(world, "resume", "", &record, text, sizeof text) == 0) {
            assert_true(++taken < 10000);
            if (full == 0) {
                ss_world_step_begin(world); /* the simulation has room, the haptic loop has none */
            } else {
                while (ss_ring_pop(world->haptic_commands, &record)) {
                }
            }
        }
        const double narrow = 0.5 * world->scene->max_jump_m, wide = 1.5 * world->scene->max_jump_m;
        char argument[64];
        snprintf(argument, sizeof argument, "haptic.max_jump_m=%.17g", wide);
        assert_int_equal(set(world, argument, text, sizeof text), 1);
        assert_non_null(strstr(text, "busy"));
        assert_int_equal(judge_step(world, 1, 0.2), SOFTSIM_ACCEPTED);
        assert_int_equal(judge_step(world, 2, 0.2 + 1.2 * world->scene->max_jump_m),
                         SOFTSIM_REFUSED_JUMP);
        assert_int_equal(ss_world_command(world, "pause", "", &record, text, sizeof text), 1);
        ss_world_step_begin(world);
        assert_false(world->simulation_run.is_paused);
        /* With room again it is set. */
        while (ss_ring_pop(world->haptic_commands, &record)) {
        }
        snprintf(argument, sizeof argument, "haptic.max_jump_m=%.17g", narrow);
        assert_int_equal(set(world, argument, text, sizeof text), 0);
        assert_int_equal(judge_step(world, 3, 0.2 + 0.7 * world->scene->max_jump_m),
                         SOFTSIM_REFUSED_JUMP);
        ss_world_destroy(&world);
    }
}

static const ss_model_class *counted_class;
static int hash_count;

static uint64_t count_hash(const ss_model *model, uint64_t seed)
{
    ++hash_count;
    return counted_class->hash(model, seed);
}

static void run_ticks(ss_world *world, int32_t count)
{
    for (int32_t i = 0; i < count; ++i) {
        softsim_force force[SOFTSIM_MAX_PROBES];
        ss_world_lockstep(world, NULL, NULL, 0, force);
    }
}

/* Whoever asks for a status asks for the hash, which costs milliseconds on a large body. */
TEST(a_state_is_hashed_once)
{
    ss_world *asked = create(SCENES "kidney.yaml", true);
    ss_world *left_alone = create(SCENES "kidney.yaml", true);
    static ss_model_class counting;
    counting = *asked->model_class;
    counting.hash = count_hash;
    counted_class = asked->model_class;
    asked->model_class = &counting;
    hash_count = 0;
    const char *const command[][2] = {
        {"pause", ""}, {"resume", ""}, {"reset", ""}, {"set", "model.modulus_j=6"}};
    for (size_t c = 0; c < sizeof command / sizeof *command; ++c) {
        ss_world *both[] = {asked, left_alone};
        for (int w = 0; w < 2; ++w) {
            ss_command_record record;
            char text[512];
            const int32_t code =
                ss_world_command(both[w], command[c][0], command[c][1], &record, text, sizeof text);
            if (code != 0) {
                fail_msg("%s", text);
            }
        }
        for (int32_t step = 0; step < 5; ++step) {
            run_ticks(asked, asked->step_ticks);
            const uint64_t hash = ss_world_hash(asked);
            for (int again = 0; again < 3; ++again) {
                assert_true(ss_world_hash(asked) == hash);
            }
            run_ticks(left_alone, left_alone->step_ticks);
        }
        assert_true(ss_world_hash(asked) == ss_world_hash(left_alone));
    }
    /* Fifteen steps, and the body at rest before them; nothing under pause. */
    assert_int_equal(hash_count, 16);
    asked->model_class = counted_class;
    ss_world_destroy(&asked);
    ss_world_destroy(&left_alone);
}

/* The new stiffness is not felt at once, and the answer says so; limits too small to be meant are
 * refused. */
TEST(a_set_says_what_it_will_do)
{
    ss_world *world = create(SCENES "kidney.yaml", false);
    char text[512];
    assert_int_equal(set(world, "haptic.coupling.stiffness_n_per_m=400", text, sizeof text), 0);
    assert_non_null(strstr(text, "= 400 N/m (was 800); "));
    assert_non_null(strstr(text, "20 % a second"));
    static const char *const too_small[] = {"haptic.coupling.stiffness_n_per_m=1e-9",
                                            "haptic.max_force_n=1e-300",
                                            "haptic.max_slew_n_per_s=1e-9"};
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(set(world, too_small[i], text, sizeof text), 2);
        assert_non_null(strstr(text, "out of range; give a number from "));
    }
    ss_world_destroy(&world);
}

/* The model has it from the first step on, where it just touches, and it stays there until the
 * haptic loop says that it lets it in. */
TEST(a_tool_found_inside_stands_outside_until_it_is_entered)
{
    ss_world *world = create(SCENES "kidney.yaml", false);
    const ss_world_probe *probe = &world->probe[0];
    const double deep[3] = {0.0, 0.006, 0.012};
    double first[3] = {0.0, 0.0, 0.0};
    for (int32_t k = 0; k < 12; ++k) {
        ss_proxy_target *target = ss_mailbox_draft(probe->target);
        *target = (ss_proxy_target){.tick = k,
                                    .is_present = true,
                                    .entries = k < 8 ? 3 : 4,
                                    .orientation = {1.0, 0.0, 0.0, 0.0}};
        memcpy(target->proxy, deep, sizeof deep);
        ss_mailbox_post(probe->target);
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
        const ss_simulation_result *result = &probe->computed;
        double way[3];
        ss_sub3(way, result->proxy, deep);
        memcpy(first, k == 0 ? result->proxy : first, sizeof first);
        assert_true(probe->was_present);
        assert_int_equal(result->is_found_inside, k < 8);
        if (k < 8) {
            assert_memory_equal(result->proxy, first, sizeof first);
            assert_true(ss_dot3(way, result->outward) > 0.999 * ss_norm3(way));
            assert_true(way[2] > 0.005);
        } else {
            assert_true(result->proxy[2] < first[2]);
        }
    }
    ss_world_destroy(&world);
}

/* A full ring refuses a command for both loops: they count resets, each for itself. */
TEST(a_command_reaches_both_loops_or_none)
{
    enum { TRIES = 4000 };
    ss_world *world = create(SCENES "kidney.yaml", false);
    ss_command_record record;
    char text[256];
    int taken = 0;
    /* The simulation reads, the haptic loop sleeps; then the other way round. */
    for (int i = 0; i < TRIES; ++i) {
        taken += ss_world_command(world, "reset", "", &record, text, sizeof text) == 0;
        ss_world_step_begin(world);
    }
    assert_in_range(taken, 1, TRIES - 1);
    assert_int_equal(world->simulation_run.restart_count, taken);
    ss_world_haptic_tick(world, 1, 0, 0);
    assert_int_equal(world->haptic_run.restart_count, taken);
    for (int i = 0; i < TRIES; ++i) {
        taken += ss_world_command(world, "reset", "", &record, text, sizeof text) == 0;
        ss_world_haptic_tick(world, 2 + i, 0, 0);
    }
    ss_world_step_begin(world);
    assert_int_equal(world->simulation_run.restart_count, taken);
    assert_int_equal(world->haptic_run.restart_count, taken);
    ss_world_destroy(&world);
}

/* Skipping is when the figures matter: they come 4 times a second all the same. */
TEST(haptic_figures_come_though_ticks_are_skipped)
{
    ss_world *world = create(SCENES "kidney.yaml", false);
    int64_t posts = 0;
    double last = -1.0;
    for (int64_t tick = 1; tick < 2000; tick += 2) {
        bool is_new = false;
        const int64_t due = tick * 1000000;
        ss_world_haptic_tick(world, tick, due, due + 1000 * tick);
        const ss_haptic_stats *stats = ss_mailbox_take(world->haptic_stats, &is_new);
        assert_true(is_new);
        posts += stats->lateness_us[3] != last;
        last = stats->lateness_us[3];
    }
    assert_in_range(posts, 7, 9);
    ss_world_destroy(&world);
}

static bool are_denormals_kept(void)
{
    const volatile double least = DBL_MIN;
    const volatile double half = least * 0.5;
    return half > 0.0;
}

/* A program's own arithmetic goes on as it was; what the world computes does not depend on it. */
TEST(a_world_leaves_the_callers_arithmetic_alone)
{
    uint64_t hash[2];
    const uint64_t before = ss_thread_flush_denormals();
    for (int k = 0; k < 2; ++k) {
        ss_thread_restore_denormals(0);
        if (k == 1) {
            ss_thread_flush_denormals();
        }
        const bool are_kept = are_denormals_kept();
        softsim_world *world = open_scene(SCENES "cylinder.yaml", NULL, 0);
        assert_true(are_denormals_kept() == are_kept);
        softsim_force force[SOFTSIM_MAX_PROBES];
        for (int i = 0; i < 50; ++i) {
            softsim_tick(world, NULL, NULL, 0, force);
        }
        assert_true(are_denormals_kept() == are_kept);
        softsim_state seen;
        double reaction[3];
        softsim_read(world, &seen);
        softsim_read_reaction(world, -1, reaction);
        hash[k] = softsim_hash(world);
        assert_true(are_denormals_kept() == are_kept);
        softsim_destroy(&world);
    }
    ss_thread_restore_denormals(before);
    assert_true(hash[0] == hash[1]);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
