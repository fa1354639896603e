/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Tools that no careful hand holds: a step slower than time takes them a share of their way, and
 * says where they stand; energy that no work explains is a verdict, in tissue and in the hand; and
 * what a hand got is judged here from poses and forces alone.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/stability/audit.h"
#include "bench/stability/hand.h"
#include "bench/stability/stress_case.h"
#include "bench/stability/stress_scene.h"
#include "common/effort.h"
#include "common/folder_fixture.h"
#include "rt/vec.h"
#include "world/watch.h"
#include "world/world.h"

#define KIDNEY SOURCE_DIR "/server/scenes/kidney.yaml"
/* Of a 5 mm sphere over (5, 3) mm: where it is 5 mm deep, and above the surface. */
static const double pressed_z = 0.0175, free_z = 0.035;
static const double deep_z = 0.005;
static const double limit_n = 8.0, body_m = 0.11, tool_m = 0.006; /* kidney.yaml, kidney.obj */

/* ---- worlds ---- */

static ss_world *make_scene(const char *scene, const char *const *set, int32_t set_count)
{
    static softsim_error error;
    softsim_config config = softsim_default_config();
    memset(&error, 0, sizeof error);
    config.has_budget = true; /* as in real time */
    config.set = set;
    config.set_count = set_count;
    config.import_program = BIN_DIR "/softsim-import";
    softsim_world *world = softsim_create(scene, &config, &error);
    if (world == NULL) {
        fail_msg("%s", error.text);
    }
    return (ss_world *)world;
}

static void destroy(ss_world *world)
{
    softsim_world *outer = (softsim_world *)world;
    softsim_destroy(&outer);
}

/* -1 .. 1, the same in every run. */
static double noise(void)
{
    static uint64_t state;
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) * 0x1p-52 - 1.0;
}

static softsim_force tick_of(ss_world *world, int64_t sender, int32_t seq, double x, double y,
                             double z)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    softsim_pose pose = {.sender = sender,
                         .seq = seq,
                         .force_seq = -1,
                         .position = {x, y, z},
                         .orientation = {1.0, 0.0, 0.0, 0.0},
                         .velocity = {NAN, NAN, NAN},
                         .applied_force = {NAN, NAN, NAN}};
    softsim_tick((softsim_world *)world, &pose, &channel, 1, force);
    ss_world_settle(world);
    return force[0];
}

static softsim_force tick(ss_world *world, int32_t seq, double x, double y, double z)
{
    return tick_of(world, 1, seq, x, y, z);
}

/* Down to the press in 0.1 s. */
static double height(int32_t k)
{
    return fmax(pressed_z, free_z - k * (free_z - pressed_z) / 100.0);
}

static softsim_state shake(ss_world *world, int32_t ticks, double amplitude, double *out_kinetic)
{
    softsim_state state;
    *out_kinetic = 0.0;
    for (int32_t k = 1; k <= ticks; ++k) {
        const double a = k > 100 ? amplitude : 0.0;
        tick(world, k, 0.005 + a * noise(), 0.003 + a * noise(), height(k) + a * noise());
        softsim_read((softsim_world *)world, &state);
        *out_kinetic = fmax(*out_kinetic, state.kinetic_j);
    }
    return state;
}

/* Before, the whole way was travelled in the part of the time for which there were sub-steps. No
 * hand that is limited to L does more than L times the body's length in one push. */
static void a_step_slower_than_time_does_not_fling_the_tool(void **state)
{
    (void)state;
    static const char *const set[] = {"simulation.max_substeps=8"};
    ss_world *world = make_scene(KIDNEY, set, 1);
    double kinetic;
    const softsim_state last = shake(world, FULL_IN_RELEASE(900, 250), 0.001, &kinetic);
    destroy(world);
    if (!(kinetic < limit_n * body_m)) {
        fail_msg("kinetic energy of %g J", kinetic);
    }
    assert_int_equal(last.worst_verdict, SOFTSIM_VERDICT_DEGRADED);
}

/* Presses by 5 mm; every slow step must have gone its share of what was left, and have said so.
 * Returns how many were slow. */
static int32_t follow_slow_steps(ss_world *world, double x, double y, double down, double up)
{
    const ss_world_probe *probe = &world->probe[0];
    int32_t slow = 0;
    for (int32_t k = 1; k <= 300; ++k) {
        const ss_tool_pose before = probe->last;
        const bool was_present = probe->was_present;
        const uint32_t teleports = probe->last_teleports;
        double goal[3], way[3], gone[3], left[3];
        ss_model_info info;
        tick(world, k, x, y, fmax(down, up - k * (up - down) / 100.0));
        world->model_class->info(world->model, &info);
        if (!was_present || probe->last_teleports != teleports || !(info.travelled < 1.0)) {
            continue;
        }
        assert_true(info.travelled > 0.0);
        assert_memory_equal(probe->last.position, probe->computed.proxy, sizeof goal);
        ss_haptic_predict(&probe->stepped_to, 1.0, world->step_period, goal);
        ss_sub3(way, goal, before.position);
        const double reach = 3.0 * world->step_period; /* no hand is faster than 3 m/s */
        ss_scale3(way, way, info.travelled * fmin(1.0, reach / ss_norm3(way)));
        ss_sub3(gone, probe->computed.proxy, before.position);
        ss_sub3(left, gone, way);
        assert_true(ss_norm3(left) < 1e-12);
        ++slow;
    }
    return slow;
}

/* The share is travelled, the rest in the next steps, and the haptic loop is told of that place:
 * the kidney with few sub-steps, and a stiff block of every model with one. */
static void the_haptic_loop_is_told_where_a_slow_step_left_the_tool(void **state)
{
    (void)state;
    SKIP_WHERE_REPEATED();
    static const char *const set[] = {"simulation.max_substeps=3"};
    static ss_assay_plan plan; /* large */
    int32_t slow_models = 0;
    ss_world *world = make_scene(KIDNEY, set, 1);
    assert_true(follow_slow_steps(world, 0.005, 0.003, pressed_z, free_z) > 20);
    destroy(world);
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        const ss_assay trial = {s, SS_ASSAY_PROBE, 1e8, 0.1, 0};
        ss_assay_plan_make(&trial, &plan);
        plan.max_substeps = 1;
        FILE *file = open_file("body.msh");
        ss_specimen_write(&plan.specimen, file);
        assert_int_equal(fclose(file), 0);
        file = open_file("scene.yaml");
        ss_assay_plan_write(&plan, file);
        assert_int_equal(fclose(file), 0);
        const double *top = plan.specimen.rest[SS_ASSAY_TOP_CENTRE];
        const double touch = top[2] + SS_ASSAY_TOOL_RADIUS;
        world = make_scene(in_folder("scene.yaml"), NULL, 0);
        slow_models += follow_slow_steps(world, top[0], top[1], touch - 0.002, touch + 0.005) > 0;
        destroy(world);
    }
    assert_true(slow_models >= 4);
}

/* Under pause nothing moves, and nothing is flung when it goes on. */
static void a_paused_tool_stays_where_it_is(void **state)
{
    (void)state;
    ss_world *world = make_scene(KIDNEY, NULL, 0);
    const ss_world_probe *probe = &world->probe[0];
    ss_command_record record;
    char text[128];
    int32_t k = 1;
    for (; k <= 150; ++k) {
        tick(world, k, 0.005, 0.003, height(k));
    }
    softsim_state pressed;
    softsim_read((softsim_world *)world, &pressed);
    const ss_tool_pose before = probe->last;
    const uint32_t teleports = probe->last_teleports;
    int32_t held = 0;
    ss_world_command(world, "pause", "", &record, text, (int32_t)sizeof text);
    for (; k <= 200; ++k) {
        tick(world, k, 0.005, 0.003, pressed_z + 1e-4 * (k - 150));
        if (probe->last_teleports == teleports) { /* until the force is ramped down */
            double left[3];
            ss_sub3(left, probe->computed.proxy, before.position);
            assert_true(ss_norm3(left) < 1e-12);
            ++held;
        }
    }
    assert_true(held > 5);
    ss_world_command(world, "resume", "", &record, text, (int32_t)sizeof text);
    double kinetic = 0.0;
    for (; k <= 300; ++k) {
        softsim_state now;
        tick(world, k, 0.005, 0.003, pressed_z + 0.005);
        softsim_read((softsim_world *)world, &now);
        kinetic = fmax(kinetic, now.kinetic_j);
    }
    assert_true(kinetic < pressed.elastic_j); /* what springs back, and no more */
    destroy(world);
}

/* A tracker that throws the tool about: the model's ledger calls it work, but no hand does it. */
static void energy_that_no_hand_has_stops_the_tissue(void **state)
{
    (void)state;
    ss_world *world = make_scene(KIDNEY, NULL, 0);
    ss_command_record record;
    char text[128];
    double kinetic;
    ss_model_info info;
    (void)shake(world, 100, 0.0, &kinetic);
    assert_int_equal(world->energy.verdict, SOFTSIM_VERDICT_GOOD);
    const ss_model_info burst = {.kinetic = 150.0 * world->energy.limit * world->energy.size};
    ss_energy_watch_step(&world->energy, &burst, 0.0, world->step_period);
    const int64_t steps = world->steps;
    softsim_force force = {.seq = 0};
    for (int32_t k = 101; k <= 160; ++k) {
        force = tick(world, k, 0.005, 0.003, pressed_z);
    }
    ss_world_info(world, &info);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_FAULT);
    assert_int_equal(world->steps, steps);
    assert_true((force.flags & SOFTSIM_FORCE_MODEL_FAULT) != 0);
    assert_true(ss_norm3(force.force) == 0.0);
    assert_int_equal(ss_world_command(world, "reset", "", &record, text, (int32_t)sizeof text), 0);
    tick(world, 161, 0.005, 0.003, free_z);
    ss_world_info(world, &info);
    assert_int_equal(info.verdict, SOFTSIM_VERDICT_GOOD);
    assert_true(world->steps > steps);
    destroy(world);
}

/* ---- the watch ---- */

static softsim_verdict verdict_after(double stored, double way)
{
    ss_energy_watch watch = {.limit = limit_n, .size = tool_m};
    ss_model_info info = {.reason = ""};
    ss_energy_watch_step(&watch, &info, 0.0, 1e-3);
    info.elastic = stored;
    ss_energy_watch_step(&watch, &info, way, 1e-3);
    ss_energy_watch_judge(&watch, &info);
    assert_true((info.reason[0] == '\0') == (info.verdict == SOFTSIM_VERDICT_GOOD));
    return info.verdict;
}

static void energy_beyond_a_hands_limit_is_a_verdict(void **state)
{
    (void)state;
    const double unit = limit_n * tool_m;
    assert_int_equal(verdict_after(0.99 * unit, 0.0), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_after(1.01 * unit, 0.0), SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(verdict_after(10.1 * unit, 0.0), SOFTSIM_VERDICT_DEGRADED);
    assert_int_equal(verdict_after(101.0 * unit, 0.0), SOFTSIM_VERDICT_FAULT);
    ss_energy_watch loaded = {.limit = limit_n, .size = tool_m};
    ss_model_info push = {.reason = ""};
    ss_energy_watch_step(&loaded, &push, 0.0, 1e-3);
    push.elastic = push.load_work = 1e3 * unit; /* what a load did is explained */
    ss_energy_watch_step(&loaded, &push, 0.0, 1e-3);
    assert_int_equal(loaded.verdict, SOFTSIM_VERDICT_GOOD);
    push.elastic *= 1e3; /* a modulus was set */
    ss_energy_watch_skip(&loaded);
    ss_energy_watch_step(&loaded, &push, 0.0, 1e-3);
    assert_int_equal(loaded.verdict, SOFTSIM_VERDICT_GOOD);
    /* A way pays for it, force times length. */
    assert_int_equal(verdict_after(1.5 * unit, 0.6 * tool_m), SOFTSIM_VERDICT_GOOD);
    /* Little by little counts too; what is long ago does not, nor does what was there before. */
    for (int is_slow = 0; is_slow < 2; ++is_slow) {
        ss_energy_watch watch = {.limit = limit_n, .size = tool_m};
        ss_model_info info = {.kinetic = 5.0, .reason = ""};
        for (int k = 0; k < 50; ++k) {
            ss_energy_watch_step(&watch, &info, 0.0, is_slow ? 0.05 : 1e-3);
            info.kinetic += 0.05 * unit;
        }
        assert_int_equal(watch.verdict, is_slow ? SOFTSIM_VERDICT_GOOD : SOFTSIM_VERDICT_GUARDED);
    }
}

static softsim_pose at_depth(double depth, int32_t force_seq)
{
    return (softsim_pose){.force_seq = force_seq,
                          .position = {0.0, 0.0, -depth},
                          .orientation = {1.0, 0.0, 0.0, 0.0},
                          .applied_force = {NAN, NAN, NAN}};
}

static softsim_force push_up(double force)
{
    return (softsim_force){.force = {0.0, 0.0, force}};
}

/* ---- the judge ---- */

enum { TRACK = 4096 };
static const ss_hand_plan plan_1khz = {.period_s = 1e-3, .lag = 2, .has_stored = true};

typedef struct track {
    ss_hand_sample sample[TRACK];
    int32_t count;
} track;

/* A pose at `x` deep, pushed up with `force`; `stored` by the tissue. */
static void feel_at(track *to, double x, double force, double stored)
{
    const softsim_pose pose = at_depth(x, -1);
    softsim_force answer = push_up(force);
    ss_copy3(answer.proxy, pose.position); /* nothing in the coupling */
    ss_hand_read(&pose, &answer, &to->sample[to->count]);
    to->sample[to->count++].stored_j = stored;
}

static ss_hand_account judge_track(const track *of)
{
    ss_hand_account account;
    ss_hand_judge(&plan_1khz, of->sample, of->count, &account);
    return account;
}

/* A lossless spring K that is sampled hands out K D d in a press to D and back in n steps of d to
 * what holds its force at once, all of K D^2 where one step is the whole way; 3 (1 - 1/n) times as
 * much to what holds it an answer later; nothing to what goes evenly. */
static void a_sampled_spring_hands_out_what_its_steps_leave(void **state)
{
    (void)state;
    static track t;
    const double stiffness = 500.0, depth = 0.008;
    for (int32_t steps = 1; steps <= 64; steps *= 4) {
        t.count = 0;
        for (int32_t k = 0; k <= 2 * steps; ++k) {
            const double x = depth * (k <= steps ? k : 2 * steps - k) / steps;
            feel_at(&t, x, stiffness * x, 0.5 * stiffness * x * x);
        }
        const ss_hand_account account = judge_track(&t);
        const double expected = stiffness * depth * depth / steps * fmax(1.0, 3.0 - 3.0 / steps);
        assert_true(fabs(account.handed_out_j - expected) < 1e-12);
        assert_true(account.made_j < expected + 1e-12);
        assert_true(fabs(account.peak_force_n - stiffness * depth) < 1e-12);
        assert_true(fabs(account.deepest_m) < 1e-12 && account.contacts == 1);
    }
}

/* A torque works on the shorter way round; contacts that follow within 20 ms are one. */
static void torque_works_and_what_chatters_is_one_contact(void **state)
{
    (void)state;
    static track t;
    const double torque = 0.2, angle = 0.1;
    t.count = 0;
    for (int32_t k = 0; k < 20; ++k) {
        softsim_pose pose = at_depth(0.0, -1);
        pose.orientation[0] = (k % 2 == 0 ? 1.0 : -1.0) * cos(0.5 * k * angle);
        pose.orientation[3] = (k % 2 == 0 ? 1.0 : -1.0) * sin(0.5 * k * angle);
        const softsim_force force = {.torque = {0.0, 0.0, torque}};
        ss_hand_read(&pose, &force, &t.sample[t.count++]);
    }
    assert_true(fabs(judge_track(&t).handed_out_j - torque * 19.0 * angle) < 1e-12);
    /* In by 2 mm against nothing, out against 3 N, a hundred times with a pause. */
    for (int32_t pause = 2; pause <= 40; pause += 38) {
        t.count = 0;
        for (int32_t k = 0; k < 50; ++k) {
            feel_at(&t, 0.002, 3.0, 0.0);
            for (int32_t n = 0; n < pause; ++n) {
                feel_at(&t, 0.0, 0.0, 0.0);
            }
        }
        const ss_hand_account account = judge_track(&t);
        assert_int_equal(account.contacts, pause > 20 ? 50 : 1);
        assert_true(fabs(account.handed_out_j - 0.006 * (pause > 20 ? 1 : 50)) < 1e-9);
    }
    /* A refused pose parts them too. */
    t.count = 0;
    for (int32_t k = 0; k < 50; ++k) {
        feel_at(&t, 0.002, 3.0, 0.0);
        t.sample[t.count - 1].is_apart = true;
        feel_at(&t, 0.0, 0.0, 0.0);
    }
    assert_true(fabs(judge_track(&t).handed_out_j - 0.006) < 1e-9);
}

/* What makes energy, and where it must be found. */
typedef enum planted { SOUND, DOUBLED, SWALLOWED, LATE, PLANTED } planted;

/* A press by 10 mm in a second and back: 500 N/m, twice that on the way out (DOUBLED); tissue that
 * keeps a tenth of the work, and hands back half of it all the same (SWALLOWED); a spring that
 * answers 20 ms late (LATE): force too small by K v tau on the way in, too large on the way out, 2
 * mJ. */
static void make_press(planted what, track *out)
{
    const double stiffness = 500.0, depth = 0.01;
    out->count = 0;
    for (int32_t k = -20; k <= 2040; ++k) {
        const double u = fmax(0.0, 1.0 - fabs(k - 1000.0) / 1000.0);
        const double late = fmax(0.0, 1.0 - fabs(k - 20.0 - 1000.0) / 1000.0);
        const double x = depth * u, work = 0.5 * stiffness * x * x;
        const bool is_out = k > 1000;
        double force = stiffness * (what == LATE ? depth * late : x);
        force *= what == DOUBLED && is_out ? 2.0 : what == SWALLOWED && is_out ? 0.5 : 1.0;
        feel_at(out, x, force, what == SWALLOWED ? 0.1 * work : work);
    }
}

static void what_makes_energy_is_found(void **state)
{
    (void)state;
    static track t;
    const double work = 0.5 * 500.0 * 0.01 * 0.01; /* 25 mJ */
    static const struct {
        double handed_out, made; /* of that work, at least and at most 4 % more */
    } expected[PLANTED] = {{0.0, 0.0}, {1.0, 1.0}, {0.0, 0.4}, {0.079, 0.079}};
    for (int what = 0; what < PLANTED; ++what) {
        make_press((planted)what, &t);
        const ss_hand_account account = judge_track(&t);
        const double handed_out = account.handed_out_j / work, made = account.made_j / work;
        if (!(handed_out >= expected[what].handed_out - 1e-9 &&
              handed_out < expected[what].handed_out + 0.04 && made >= expected[what].made - 0.01 &&
              made < expected[what].made + 0.04)) {
            fail_msg("defect %d: handed out %g, made %g of the work", what, handed_out, made);
        }
    }
}

/* What was stored while a tool was let in is the hand's to get, and no more. */
static void what_was_let_in_does_not_drive(void **state)
{
    (void)state;
    static track t;
    for (int is_let_in = 0; is_let_in < 2; ++is_let_in) {
        t.count = 0;
        for (int32_t k = 0; k < 1500; ++k) { /* 40 mm deep, 6 N; then out */
            const double share = fmin(1.0, k / 500.0), out = fmax(0.0, (k - 500.0) / 1000.0);
            feel_at(&t, 0.04 * (1.0 - out), 6.0 * share * (1.0 - out),
                    0.12 * share * (1.0 - out) * (1.0 - out));
            t.sample[t.count - 1].is_let_in = is_let_in && k < 500;
        }
        const ss_hand_account account = judge_track(&t);
        assert_true(account.handed_out_j > 0.11);
        assert_true(is_let_in ? account.driven_j < 1e-3 : account.driven_j > 0.11);
        assert_true(is_let_in ? account.made_j < 1e-3 : account.made_j > 0.11);
    }
}

/* The watch, tick by tick, and the judge, from the whole track, are two programs: on random tracks
 * the watch tells of nothing that the judge does not find, and misses nothing that a device which
 * holds its forces is handed. */
static void the_watch_and_the_judge_agree_on_random_tracks(void **state)
{
    (void)state;
    static track t;
    int32_t told_runs = 0, quiet_runs = 0;
    for (int run = 0; run < 300; ++run) {
        ss_hand_watch watch = {.has_pose = false};
        const double size = pow(10.0, -3.0 + 1.2 * noise()), often = 0.5 + 0.5 * noise();
        double x = 0.0;
        bool is_told = false, is_touching = false;
        t.count = 0;
        for (int32_t k = 1; k <= 400; ++k) {
            x += size * noise();
            is_touching = fabs(noise()) < 0.1 ? noise() < often : is_touching;
            const double push = is_touching ? 2.0 + 2.0 * noise() : 0.0;
            const softsim_pose pose = at_depth(x, -1);
            const softsim_force answer = push_up(push);
            const ss_hand_tick now = {
                .tick = k, .period = 1e-3, .pose = &pose, .sent = &answer, .is_lockstep = true};
            ss_hand_watch_tick(&watch, &now);
            is_told = is_told || ss_hand_watch_verdict(&watch, k).verdict > SOFTSIM_VERDICT_GOOD;
            feel_at(&t, x, push, 0.0);
        }
        const ss_hand_account account = judge_track(&t);
        const double most = 0.01; /* J */
        assert_true(!is_told || fmax(account.handed_out_j, account.made_j) > most);
        assert_true(is_told || account.handed_out_j <= most);
        told_runs += is_told;
        quiet_runs += !is_told;
    }
    assert_true(told_runs > 50 && quiet_runs > 50);
}

/* ---- the watch over a hand ---- */

static bool is_telling(const ss_hand_watch *watch, int64_t tick)
{
    return ss_hand_watch_verdict(watch, tick).verdict > SOFTSIM_VERDICT_GOOD;
}

/* In and out by 8 mm in one step of a spring of 500 N/m: 32 mJ a contact. */
static void a_hand_that_is_driven_is_told_for_a_second(void **state)
{
    (void)state;
    for (int is_lockstep = 0; is_lockstep < 2; ++is_lockstep) {
        ss_hand_watch watch = {.has_pose = false};
        int64_t k = 1;
        for (; k <= 10; ++k) {
            const double x = k % 2 == 0 ? 0.008 : 0.0;
            const softsim_pose pose = at_depth(x, -1);
            const softsim_force force = push_up(500.0 * x);
            const ss_hand_tick now = {.tick = k,
                                      .period = 1e-3,
                                      .pose = &pose,
                                      .sent = &force,
                                      .is_lockstep = is_lockstep != 0};
            ss_hand_watch_tick(&watch, &now);
        }
        assert_int_equal(is_telling(&watch, k), is_lockstep);
        const softsim_force no_force = {.seq = 0};
        const ss_hand_tick nothing = {
            .tick = k, .period = 1e-3, .sent = &no_force, .is_lockstep = is_lockstep != 0};
        ss_hand_watch_tick(&watch, &nothing);
        assert_int_equal(is_telling(&watch, k + 900), is_lockstep);
        assert_false(is_telling(&watch, k + 1000));
    }
    /* With a clock the observer counts, where the client names forces. */
    for (int is_named = 0; is_named < 2; ++is_named) {
        ss_hand_watch watch = {.has_pose = false};
        const softsim_pose pose = at_depth(0.0, is_named ? 5 : -1);
        const softsim_force force = push_up(0.0);
        ss_hand_tick now = {
            .tick = 7, .period = 1e-3, .pose = &pose, .sent = &force, .contact_j = -0.009};
        ss_hand_watch_tick(&watch, &now);
        assert_false(is_telling(&watch, 8));
        now.contact_j = -0.011;
        ss_hand_watch_tick(&watch, &now);
        assert_int_equal(is_telling(&watch, 8), is_named);
        now.tick = 2000; /* a contact that hands out nothing */
        now.contact_j = 0.0;
        ss_hand_watch_tick(&watch, &now);
        assert_false(is_telling(&watch, 2001));
        now.tick = 3000; /* another, less bad than the worst so far */
        now.contact_j = -0.0105;
        ss_hand_watch_tick(&watch, &now);
        assert_int_equal(is_telling(&watch, 3001), is_named);
    }
}

/* By how much decides what is said: beyond 10 mJ guarded, beyond 100 mJ degraded; what the entry
 * let in is taken off, and said as such. The worse holds on. */
static void the_verdict_follows_the_energy_of_a_contact(void **state)
{
    (void)state;
    static const struct {
        double contact_j, let_in_j;
        softsim_verdict verdict;
        const char *word;
    } rows[] = {{-0.009, 0.0, SOFTSIM_VERDICT_GOOD, ""},
                {-0.011, 0.0, SOFTSIM_VERDICT_GUARDED, "shakes"},
                {-0.099, 0.0, SOFTSIM_VERDICT_GUARDED, "shakes"},
                {-0.101, 0.0, SOFTSIM_VERDICT_DEGRADED, "shakes"},
                {-0.101, -0.5, SOFTSIM_VERDICT_DEGRADED, "shakes"},
                {-0.101, 0.05, SOFTSIM_VERDICT_GUARDED, "shakes"},
                {-0.101, 0.095, SOFTSIM_VERDICT_GUARDED, "found inside"},
                {-0.5, 0.495, SOFTSIM_VERDICT_GUARDED, "found inside"},
                {-0.009, 0.5, SOFTSIM_VERDICT_GOOD, ""}};
    const softsim_pose pose = at_depth(0.0, 5);
    const softsim_force force = push_up(1.0);
    ss_hand_tick now = {.tick = 7, .period = 1e-3, .pose = &pose, .sent = &force};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        ss_hand_watch watch = {.has_pose = false};
        now.contact_j = rows[k].contact_j;
        now.let_in_j = rows[k].let_in_j;
        ss_hand_watch_tick(&watch, &now);
        const ss_hand_verdict told = ss_hand_watch_verdict(&watch, 8);
        assert_int_equal(told.verdict, rows[k].verdict);
        assert_non_null(strstr(told.reason, rows[k].word));
    }
    ss_hand_watch watch = {.has_pose = false};
    now.let_in_j = 0.0;
    now.contact_j = -0.2;
    ss_hand_watch_tick(&watch, &now);
    now.tick = 500;
    now.contact_j = -0.02;
    ss_hand_watch_tick(&watch, &now);
    assert_int_equal(ss_hand_watch_verdict(&watch, 501).verdict, SOFTSIM_VERDICT_DEGRADED);
    now.tick = 2000;
    ss_hand_watch_tick(&watch, &now);
    assert_int_equal(ss_hand_watch_verdict(&watch, 2001).verdict, SOFTSIM_VERDICT_GUARDED);
}

/* A spring of 1000 N/m is let in by 16 mm under a still hand, 128 mJ, and let go of within 0.1 s;
 * 5 ms later a touch of 1 mJ. With a clock the client names its forces 5 ms late. */
static void what_was_let_in_counts_for_as_long_as_what_it_became(void **state)
{
    (void)state;
    for (int is_lockstep = 0; is_lockstep < 2; ++is_lockstep) {
        ss_hand_watch watch = {.has_pose = false};
        double given[400] = {0.0}, before = 0.0, sent = 0.0;
        for (int k = 1; k < 400; ++k) {
            const double depth = k <= 200 ? 0.016 * fmin(1.0, (200 - k) / 100.0) : 0.0;
            const double let_in = 0.016 * fmin(1.0, k / 100.0);
            const double force = k == 206 ? 1.0 : 1000.0 * fmin(depth, let_in);
            const softsim_pose pose = at_depth(k <= 206 ? depth : -0.001, 5);
            const softsim_force answer = push_up(force);
            given[k] = given[k - 1] * (given[k - 1] < 0.0 && force + sent == 0.0 ? 0.0 : 1.0) -
                       sent * (pose.position[2] - before);
            const ss_hand_tick now = {.tick = k,
                                      .period = 1e-3,
                                      .pose = &pose,
                                      .sent = &answer,
                                      .contact_j = is_lockstep || k <= 5 ? 0.0 : given[k - 5],
                                      .let_in_j = k <= 100 ? 0.16e-3 * 0.5 * (force + sent) : 0.0,
                                      .is_lockstep = is_lockstep != 0};
            ss_hand_watch_tick(&watch, &now);
            const ss_hand_verdict told = ss_hand_watch_verdict(&watch, k + 1);
            before = pose.position[2];
            sent = force;
            assert_null(strstr(told.reason, "shakes"));
            assert_true(told.verdict <= SOFTSIM_VERDICT_GUARDED);
            assert_true(k < 150 || told.verdict == SOFTSIM_VERDICT_GUARDED);
        }
        assert_true(watch.let_in == 0.0);
    }
}

/* A tool that stands deep in the kidney from the start is let in, and draws out slowly: what it is
 * handed nobody put in, and nobody shook. A shake that hands out more than was let in is told as
 * such. */
static void a_tool_that_was_let_in_is_told_apart_from_one_that_shakes(void **state)
{
    (void)state;
    for (int is_shaking = 0; is_shaking < 2; ++is_shaking) {
        ss_world *world = make_scene(KIDNEY, NULL, 0);
        softsim_state s;
        int32_t k = 1;
        for (; k <= 800; ++k) {
            tick(world, k, 0.005, 0.003, deep_z);
        }
        softsim_read((softsim_world *)world, &s);
        assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_GOOD);
        for (; k <= 1800; ++k) {
            const double z = is_shaking ? deep_z + 0.01 * (k % 2)
                                        : deep_z + (free_z - deep_z) * (k - 800) / 1000.0;
            softsim_force f = tick(world, k, 0.005, 0.003, z);
            ss_hand_watch *w = &world->probe[0].hand;
            if (is_shaking && (k < 830 || k % 50 == 0))
                fprintf(stderr, "%d F %g e %g %g s %g %g let %g %.20s\n", k, f.force[2],
                        w->energy[0], w->energy[1], w->spell[0], w->spell[1], w->let_in,
                        world->hand.reason);
        }
        if (is_shaking) {
            assert_true(world->hand.verdict > SOFTSIM_VERDICT_GOOD);
            assert_non_null(strstr(world->hand.reason, "shakes"));
        } else {
            assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_GUARDED);
            assert_non_null(strstr(world->worst_hand.reason, "found inside the tissue"));
        }
        destroy(world);
    }
}

static bool is_said(const ss_world *world, const char *words)
{
    return world->hand.verdict > SOFTSIM_VERDICT_GOOD && strstr(world->hand.reason, words) != NULL;
}

/* Still, then out at 30 mm/s until a second after the last force: it is the entry's energy to the
 * end. A softer tissue lets in less than what is degraded, a stiffer one more. */
static void a_calm_release_of_what_was_let_in_is_not_called_shaking(void **state)
{
    (void)state;
    static const char *const stiffer[] = {
        "model.pretension_j=4", "model.rest_stiffness_n_per_m3=2e5",
        "haptic.coupling.damping_n_s_per_m=8", "haptic.max_force_n=20"};
    for (int is_stiff = 0; is_stiff < 2; ++is_stiff) {
        ss_world *world = make_scene(KIDNEY, stiffer, is_stiff ? 4 : 0);
        int32_t touched = 0, told = 0;
        double handed_out = 0.0, before = deep_z;
        softsim_force force = {.seq = 0};
        for (int32_t k = 1; k <= touched + 1000; ++k) {
            const double z = deep_z + 0.03 * 1e-3 * fmax(0.0, k - 800);
            handed_out += force.force[2] * (z - before);
            before = z;
            force = tick(world, k, 0.005, 0.003, z);
            touched = ss_norm3(force.force) > 0.0 || k < 800 ? k : touched;
            told += is_said(world, "found inside the tissue");
            assert_false(is_said(world, "shakes"));
        }
        assert_true(handed_out > (is_stiff ? 0.12 : 0.01));
        assert_true(told >= 1000);
        assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_GUARDED);
        destroy(world);
    }
}

/* Between the place that one device left, or one that fell silent, and where the next pose is,
 * nobody went: the force of then does no work on that way. */
static void nobody_went_from_one_device_to_the_next(void **state)
{
    (void)state;
    for (int64_t next = 1; next <= 2; ++next) {
        ss_world *world = make_scene(KIDNEY, NULL, 0);
        softsim_force force = {.seq = 0};
        int32_t k = 1;
        for (; k <= 300; ++k) {
            force = tick(world, k, 0.005, 0.003, height(k));
        }
        assert_true(force.force[2] * 0.1 > 0.1); /* ten times what is told */
        softsim_force silent[SOFTSIM_MAX_PROBES];
        for (int n = 0; n < 600; ++n) {
            softsim_tick((softsim_world *)world, NULL, NULL, 0, silent);
        }
        for (; k <= 310; ++k) {
            tick_of(world, next, k, 0.005, 0.003, pressed_z + 0.1);
        }
        assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_GOOD);
        destroy(world);
    }
}

/* ---- every model ---- */

static ss_assay_result abuse(int32_t subject, ss_assay_kind kind, double value, int32_t variant)
{
    const ss_assay assay = {subject, kind, 1e4, value, variant};
    ss_assay_result result;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_assay_run(&assay, folder, &result, &error), SOFTSIM_OK);
    return result;
}

static void what_hands_out_energy_is_not_called_good(void **state)
{
    (void)state;
    static const struct {
        ss_assay_kind kind;
        double value;
        int32_t variant;
    } runs[] = {{SS_ASSAY_NOISE, 1e-3, 0},
                {SS_ASSAY_IN_OUT, 500.0, 0},
                {SS_ASSAY_THROUGH, 100.0, 2},
                {SS_ASSAY_PAUSE, 2000.0, 0}};
    int32_t handed_out = 0;
    const int32_t count = FULL_IN_RELEASE(ss_assay_subject_count(), 1);
    for (int32_t s = 0; s < count; ++s) {
        for (size_t k = 0; k < sizeof runs / sizeof *runs; ++k) {
            const ss_assay_result r = abuse(s, runs[k].kind, runs[k].value, runs[k].variant);
            if (!r.is_agreed) {
                char found[192];
                ss_audit_text(r.found, found, (int32_t)sizeof found);
                fail_msg("%s, %s: found %s (%g J), the program said: %s", ss_assay_subject_name(s),
                         ss_assay_kind_name(runs[k].kind), found, r.handed_out_j, r.acted);
            }
            assert_true(r.force_n <= limit_n * (1.0 + 1e-9));
            assert_true(r.kinetic_j < limit_n * body_m);
            handed_out += r.handed_out_j > 0.01;
        }
    }
    assert_true(handed_out > 0); /* else nothing was tried */
}

/* No model hands out anything in a slow press, whatever is allowed to one that is shaken: at most
 * what steps of 0.2 mm leave. */
static void a_slow_press_hands_out_nothing(void **state)
{
    (void)state;
    for (int32_t s = 0; s < ss_assay_subject_count(); ++s) {
        const ss_assay_result r = abuse(s, SS_ASSAY_CONTROL, 0.0, 1);
        const double most = 0.5e-3; /* J; 1 to 80 mJ are put in */
        if (!(r.is_agreed && r.handed_out_j < most && r.driven_j < most &&
              (ss_assay_is_plastic(s) || r.made_j < most))) {
            fail_msg("%s: %g J handed out, %g J made; the program said: %s",
                     ss_assay_subject_name(s), r.handed_out_j, r.made_j, r.acted);
        }
    }
}

/* A tool that turns a hundred times a second does not whirl through the tissue: it turns as fast as
 * a hand could, the shorter way. */
static void a_tool_turns_no_faster_than_a_hand(void **state)
{
    (void)state;
    static ss_assay_plan plan; /* large */
    const ss_assay trial = {0, SS_ASSAY_SPIN, 1e5, 100.0, 0};
    ss_assay_plan_make(&trial, &plan);
    FILE *file = open_file("body.msh");
    ss_specimen_write(&plan.specimen, file);
    assert_int_equal(fclose(file), 0);
    file = open_file("scene.yaml");
    ss_assay_plan_write(&plan, file);
    assert_int_equal(fclose(file), 0);
    ss_world *world = make_scene(in_folder("scene.yaml"), NULL, 0);
    double turned = 0.0;
    for (int32_t k = 1; k <= 400; ++k) {
        double before[4], turn[3];
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_pose pose = at_depth(0.0, -1);
        const int32_t channel = 0;
        pose.sender = 1;
        pose.seq = k;
        ss_set3(pose.velocity, NAN, NAN, NAN);
        ss_assay_plan_tool(&plan, 1e-3 * k, k, pose.position, pose.orientation);
        memcpy(before, world->probe[0].last.orientation, sizeof before);
        softsim_tick((softsim_world *)world, &pose, &channel, 1, force);
        ss_world_settle(world);
        if (k > 10) {
            ss_turn_between(before, world->probe[0].last.orientation, turn);
            assert_true(ss_norm3(turn) < 50.0 * world->step_period * (1.0 + 1e-3));
            turned += ss_norm3(turn);
        }
    }
    assert_true(turned > 2.0);
    destroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_slower_than_time_does_not_fling_the_tool),
        cmocka_unit_test(the_haptic_loop_is_told_where_a_slow_step_left_the_tool),
        cmocka_unit_test(a_paused_tool_stays_where_it_is),
        cmocka_unit_test(energy_that_no_hand_has_stops_the_tissue),
        cmocka_unit_test(energy_beyond_a_hands_limit_is_a_verdict),
        cmocka_unit_test(a_sampled_spring_hands_out_what_its_steps_leave),
        cmocka_unit_test(torque_works_and_what_chatters_is_one_contact),
        cmocka_unit_test(what_makes_energy_is_found),
        cmocka_unit_test(what_was_let_in_does_not_drive),
        cmocka_unit_test(the_watch_and_the_judge_agree_on_random_tracks),
        cmocka_unit_test(a_hand_that_is_driven_is_told_for_a_second),
        cmocka_unit_test(the_verdict_follows_the_energy_of_a_contact),
        cmocka_unit_test(what_was_let_in_counts_for_as_long_as_what_it_became),
        cmocka_unit_test(a_tool_that_was_let_in_is_told_apart_from_one_that_shakes),
        cmocka_unit_test(a_calm_release_of_what_was_let_in_is_not_called_shaking),
        cmocka_unit_test(nobody_went_from_one_device_to_the_next),
        cmocka_unit_test(what_hands_out_energy_is_not_called_good),
        cmocka_unit_test(a_slow_press_hands_out_nothing),
        cmocka_unit_test(a_tool_turns_no_faster_than_a_hand),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
