/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A body at rest sleeps, and nobody can feel it: each run is made twice, with simulation.sleep auto
 * and off, by the same poses, and the forces are equal within a thousandth of the largest. Whether
 * it slept is told by the sub-steps that were made.
 */
#include "common/test.h"

#include "common/effort.h"
#include "sleep_fixture.h"

/* Pressed, held, pressed further, slid, let go, left alone, passed by, and pressed again. */
TEST_WITH(pokes_and_slides_feel_the_same, make_folder_with_block, remove_folder)
{
    static const char *const in_short_run[] = {"kidney", "ventricle", "corotational", "chainmail"};
    for (int i = 0; i < BODIES; ++i) {
        const body *b = &bodies[i];
        bool is_run = FULL_IN_LONG_RUN(true, false);
        for (int k = FULL_IN_RELEASE(0, 3); k < 4; ++k) {
            is_run = is_run || strcmp(in_short_run[k], b->name) == 0;
        }
        if (!is_run) {
            continue;
        }
        const double d = 0.3 * b->depth;
        const part parts[] = {{10, FAR_OUT, 0, 0, 0, false},
                              {400, d, 0, 0, 0, false},
                              {FULL_IN_LONG_RUN(6000, 2000), d, 0, 0, 0, false},
                              {400, 1.2 * d, 0, 0, 0, false},
                              {400, 1.2 * d, 0.004, 0, 0, false},
                              {400, FAR_OUT, 0, 0, 0, false},
                              {FULL_IN_LONG_RUN(60000, 2500), FAR_OUT, 0, 0, 0, true},
                              {400, FAR_OUT, 0.02, 0, 0, false},
                              {400, d, 0, 0, 0, false}};
        pair p = open_pair(b, NULL, 0);
        play(&p, b, parts, sizeof parts / sizeof *parts);
        close_pair(&p, b->name);
    }
}

/* Grasped, or pressed on what rubs, at rest, and turned slowly about its own axis, a milliradian at
 * a time: what that twists is felt at once, and nothing is thrown at the hand by the twitch after.
 */
static void turn_at_rest(const body *b, const char *const *more, int count, int buttons)
{
    const double d = 0.3 * b->depth;
    const int still = FULL_IN_LONG_RUN(6000, 3000);
    const part parts[] = {
        {10, FAR_OUT, 0, 0, 0, false},        {400, d, 0, 0, 0, false},
        {still, d, 0, 0, buttons, false},     {1000, d, 0, 0.001, buttons, false},
        {1000, d, 0, 0.1, buttons, false},    {100, d, 0.0005, 0.1, buttons, false},
        {400, d, 0.0005, 0.1, buttons, false}};
    pair p = open_pair(b, more, count);
    play(&p, b, parts, sizeof parts / sizeof *parts);
    close_pair(&p, b->name);
}

TEST_WITH(a_sphere_that_turns_is_felt_where_it_is_held, make_folder_with_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    const char *const rubs[] = {"contact.friction=0.5"};
    const char *const none[] = {NULL};
    for (int i = 0; i < BODIES; ++i) {
        const body *b = &bodies[i];
        const bool is_fem = strcmp(b->name, "ventricle") == 0;
        if (is_fem || strcmp(b->name, "kidney") == 0 || FULL_IN_LONG_RUN(true, false)) {
            turn_at_rest(b, none, 0, SOFTSIM_BUTTON_GRASP);
        }
        if (is_fem) {
            turn_at_rest(b, rubs, 1, 0);
        }
    }
}

/* With one thread and with three, whose worker steps while ticks run. */
TEST_WITH(the_hash_is_the_same_for_any_number_of_threads, make_folder_with_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    uint64_t hash[2] = {0, 0};
    for (int k = 0; k < 2; ++k) {
        softsim_config config = softsim_default_config();
        config.threads = k == 0 ? 1 : 3;
        const body *b = &bodies[0];
        char path[512];
        (void)snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s", b->scene);
        softsim_world *world = make_world_with(path, config);
        for (int n = 1; n <= 4000; ++n) {
            double x[3];
            const double in = n < 2200 ? FAR_OUT : FAR_OUT + 0.055 * smooth((n - 2200) / 400.0);
            ss_madd3(x, b->touch, in, b->in);
            const softsim_pose pose = pose_of(n, x);
            (void)feel(world, &pose);
        }
        softsim_state end;
        softsim_read(world, &end);
        assert_true(end.all_substeps < 4000 * 4 - 800); /* it slept */
        hash[k] = softsim_hash(world);
        softsim_destroy(&world);
    }
    assert_true(hash[0] == hash[1]);
}

/* A guard that acts in each step, and no more in one than in the next, is at rest too, and goes on
 * to be told. */
TEST_WITH(what_a_guard_holds_sleeps_and_says_so, make_folder_with_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const body block = {"block", NULL, "  name: fem\n" ELASTIC, NULL, ON_BLOCK, 0.010};
    const double d = block.depth;
    const part press[] = {
        {10, FAR_OUT, 0, 0, 0, false}, {400, d, 0, 0, 0, false}, {2500, d, 0, 0, 0, true}};
    const part after[] = {
        {10, d, 0, 0, 0, false}, {400, 1.1 * d, 0, 0, 0, false}, {400, FAR_OUT, 0, 0, 0, false}};
    pair p = open_pair(&block, NULL, 0);
    softsim_state held;
    play(&p, &block, press, 3);
    softsim_read(p.slept, &held);
    assert_int_equal(held.verdict, SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(held.active_nodes, 0);
    play(&p, &block, after, 3);
    close_pair(&p, block.name);
}

/* One that acts while a tool goes by in the air passes, and is not told on by a body asleep. */
TEST_WITH(a_guard_that_passes_is_not_slept_over, make_folder_with_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const char *const coarse[] = {
        "simulation.rate_hz=250", "simulation.max_substeps=4",
        "contact.tools=[{probe: 0, shape: {sphere: {radius_mm: 4}}}]"};
    static const body block = {"block", NULL, "  name: chainmail\n", NULL, ON_BLOCK, 0.010};
    softsim_config config = softsim_default_config();
    config.has_budget = true; /* as in real time */
    config.set = coarse;
    config.set_count = 3;
    softsim_world *world = make_world_with(write_block(&block), config);
    softsim_state waved, late;
    for (int n = 1; n <= 9000; ++n) {
        double x[3];
        const double wave = n < 6000 ? sin(2.0 * SS_PI * 2.0 * 1e-3 * n) : 0.0;
        ss_madd3(x, block.touch, -0.4, block.in);
        ss_madd3(x, x, 0.2 * wave, block.side);
        const softsim_pose pose = pose_of(n, x);
        (void)feel(world, &pose);
        if (n == 5000) {
            softsim_read(world, &waved);
        }
    }
    softsim_read(world, &late);
    assert_int_equal(waved.verdict, SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(late.verdict, SOFTSIM_VERDICT_GOOD);
    assert_int_equal(late.active_nodes, 0);
    softsim_destroy(&world);
}

/* Under a tool that stands still: where samples only just touch, deep in where light nodes tremble
 * in the last digits, and where the force does. */
TEST_WITH(tissue_sleeps_under_a_tool_at_rest, make_folder_with_block, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const body rests[] = {
        {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, 0.00275},
        {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, 0.0055},
        {"kidney-tissue", "kidney-tissue.yaml", NULL, NULL,
         AT(0.010609, 0.004, 0.027527, 0, 0, -1, 1, 0, 0), 0.018},
        {"block", NULL, "  name: corotational\n" ELASTIC, NULL, ON_BLOCK, 0.001}};
    for (size_t i = 0; i < sizeof rests / sizeof *rests; ++i) {
        const body *b = &rests[i];
        softsim_world *world = open_body(b, NULL, 0);
        softsim_state end;
        for (int n = 1; n <= 400 + 3000; ++n) {
            double x[3];
            ss_madd3(x, b->touch, FAR_OUT + (b->depth - FAR_OUT) * smooth(n / 400.0), b->in);
            const softsim_pose pose = pose_of(n, x);
            (void)feel(world, &pose);
        }
        softsim_read(world, &end);
        if (end.active_nodes != 0) {
            fail_msg("%s stays awake, pressed by %.3g mm", b->name, 1e3 * b->depth);
        }
        softsim_destroy(&world);
    }
}

/* It is told, and sleeps only where it may. */
TEST_WITH(a_sleeping_body_says_so, make_folder_with_block, remove_folder)
{
    static const body block = {"block", NULL, "  name: fem\n" ELASTIC, NULL, ON_BLOCK, 0.010};
    const char *const off[] = {"simulation.sleep=off"};
    for (int k = 0; k < 2; ++k) {
        softsim_world *world = open_body(&block, off, k);
        softsim_state early, late;
        for (int n = 0; n < 900; ++n) {
            (void)softsim_tick(world, NULL, NULL, 0, (softsim_force[SOFTSIM_MAX_PROBES]){{0}});
        }
        softsim_read(world, &early);
        assert_true(early.active_nodes == early.node_count);
        for (int n = 0; n < 600; ++n) {
            (void)softsim_tick(world, NULL, NULL, 0, (softsim_force[SOFTSIM_MAX_PROBES]){{0}});
        }
        softsim_read(world, &late);
        assert_int_equal(late.active_nodes, k == 0 ? 0 : late.node_count);
        assert_int_equal(late.step - early.step, 600 * early.period_s / early.simulation_period_s);
        softsim_destroy(&world);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
