/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The watch over energy that no work explains: a verdict, in tissue and in the hand, that holds on
 * and says whether it was shaken or let in.
 */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "common/effort.h"
#include "common/hand_fixture.h"
#include "pressed_fixture.h"
#include "rt/vec.h"
#include "world/watch.h"

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

TEST(energy_beyond_a_hands_limit_is_a_verdict)
{
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

/* ---- the watch over a hand ---- */

static bool is_telling(const ss_hand_watch *watch, int64_t tick)
{
    return ss_hand_watch_verdict(watch, tick).verdict > SOFTSIM_VERDICT_GOOD;
}

/* In and out by 8 mm in one step of a spring of 500 N/m: 32 mJ a contact. */
TEST(a_hand_that_is_driven_is_told_for_a_second)
{
    for (int is_lockstep = 0; is_lockstep < 2; ++is_lockstep) {
        ss_hand_watch watch = {.has_pose = false};
        int64_t k = 1;
        for (; k <= 10; ++k) {
            const double x = k % 2 == 0 ? 0.008 : 0.0;
            const softsim_pose pose = at_depth(x, -1);
            const softsim_force force = push_up(500.0 * x);
            const ss_hand_tick now = {.max_force_n = INFINITY,
                                      .tick = k,
                                      .period = 1e-3,
                                      .pose = &pose,
                                      .sent = &force,
                                      .is_lockstep = is_lockstep != 0};
            ss_hand_watch_tick(&watch, &now);
        }
        assert_int_equal(is_telling(&watch, k), is_lockstep);
        const softsim_force no_force = {.seq = 0};
        const ss_hand_tick nothing = {.max_force_n = INFINITY,
                                      .tick = k,
                                      .period = 1e-3,
                                      .sent = &no_force,
                                      .is_lockstep = is_lockstep != 0};
        ss_hand_watch_tick(&watch, &nothing);
        assert_int_equal(is_telling(&watch, k + 900), is_lockstep);
        assert_false(is_telling(&watch, k + 1000));
    }
    /* With a clock the observer counts, where the client names forces. */
    for (int is_named = 0; is_named < 2; ++is_named) {
        ss_hand_watch watch = {.has_pose = false};
        const softsim_pose pose = at_depth(0.0, is_named ? 5 : -1);
        const softsim_force force = push_up(0.0);
        ss_hand_tick now = {.max_force_n = INFINITY,
                            .tick = 7,
                            .period = 1e-3,
                            .pose = &pose,
                            .sent = &force,
                            .contact_j = -0.009};
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
TEST(the_verdict_follows_the_energy_of_a_contact)
{
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
    ss_hand_tick now = {
        .max_force_n = INFINITY, .tick = 7, .period = 1e-3, .pose = &pose, .sent = &force};
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
TEST(what_was_let_in_counts_for_as_long_as_what_it_became)
{
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
            const ss_hand_tick now = {.max_force_n = INFINITY,
                                      .tick = k,
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
TEST(a_tool_that_was_let_in_is_told_apart_from_one_that_shakes)
{
    SKIP_WHERE_REPEATED();
    for (int is_shaking = 0; is_shaking < 2; ++is_shaking) {
        ss_world *world = make_kidney(NULL, 0);
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
            tick(world, k, 0.005, 0.003, z);
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
TEST(a_calm_release_of_what_was_let_in_is_not_called_shaking)
{
    SKIP_WHERE_REPEATED();
    static const char *const stiffer[] = {
        "model.pretension_j=4", "model.rest_stiffness_n_per_m3=2e5",
        "haptic.coupling.damping_n_s_per_m=8", "haptic.max_force_n=20"};
    for (int is_stiff = 0; is_stiff < 2; ++is_stiff) {
        ss_world *world = make_kidney(stiffer, is_stiff ? 4 : 0);
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
TEST(nobody_went_from_one_device_to_the_next)
{
    for (int64_t next = FULL_IN_RELEASE(1, 2); next <= 2; ++next) {
        ss_world *world = make_kidney(NULL, 0);
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

/* Into the kidney at 25 m/s, still for 30 ms, and out again. */
static double slam(ss_world *world, bool *out_is_told)
{
    double peak = 0.0;
    *out_is_told = false;
    for (int32_t k = 1; k <= 400; ++k) {
        const double way = k <= 100 ? 0.0 : k <= 130 ? k - 100 : fmax(0.0, 134 - k);
        const softsim_force force =
            tick(world, k, 0.005, 0.003, fmax(pressed_z, free_z + 0.05 - 0.025 * way));
        peak = fmax(peak, ss_norm3(force.force));
        *out_is_told = *out_is_told || is_said(world, "late behind the hand");
    }
    return peak;
}

/* A coupling whose damping holds the tool back over its stiffness for a second: the blow was not
 * felt, and all was called good. */
static const char *const held_back[] = {"haptic.coupling.damping_n_s_per_m=1000"};

TEST(a_blow_that_is_not_felt_is_told)
{
    bool is_told;
    ss_world *world = make_kidney(held_back, 1);
    assert_true(slam(world, &is_told) < 0.1);
    assert_true(is_told);
    assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_DEGRADED);
    destroy(world);
}

/* A blow that is felt is not told, nor is a hand that moves as hands do. */
TEST(only_a_blow_that_is_not_felt_is_told)
{
    SKIP_WHERE_REPEATED();
    bool is_told;
    ss_world *world = make_kidney(NULL, 0);
    assert_true(slam(world, &is_told) > 0.5);
    assert_false(is_told);
    destroy(world);
    world = make_kidney(held_back, 1);
    for (int32_t k = 1; k <= 400; ++k) {
        tick(world, k, 0.005, 0.003, height(k < 200 ? k : 400 - k));
    }
    assert_int_equal(world->worst_hand.verdict, SOFTSIM_VERDICT_GOOD);
    destroy(world);
}

/* A force of the limit that turns round n times a second for a second, as a circle does. */
static softsim_verdict verdict_of_turns(double n)
{
    ss_hand_watch watch = {.until = 0};
    ss_hand_verdict told = {SOFTSIM_VERDICT_GOOD, ""};
    for (int k = 1; k <= 1000; ++k) {
        const double turn = 2.0 * SS_PI * n * 1e-3 * k;
        const softsim_force force = {.force = {8.0 * cos(turn), 8.0 * sin(turn), 0.0}};
        const ss_hand_tick now = {.tick = k, .period = 1e-3, .sent = &force, .max_force_n = 8.0};
        ss_hand_watch_tick(&watch, &now);
        told = ss_hand_verdict_worse(told, ss_hand_watch_verdict(&watch, k));
    }
    return told.verdict;
}

/* Where the energy of a contact is not known the force itself tells: 6 turns a second a hand may
 * make, 12 none does. */
TEST(a_force_that_shakes_is_told)
{
    assert_int_equal(verdict_of_turns(6.0), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_of_turns(12.0), SOFTSIM_VERDICT_GUARDED);
}

/* ---- a device that tells nothing ---- */

typedef enum teller { NOTHING, FORCE_SEQ, APPLIED_FORCE, CORRECTS, LOCKSTEP, TELLERS } teller;

/* A spring of 400 N/m is pressed 8 mm deep for a second, and then `size` m to and fro `hz` times a
 * second; or left at each turn, where it touches at 8 mm. Nothing is late here. */
static softsim_verdict verdict_of_shakes(teller told, double hz, double size, double touch)
{
    ss_hand_watch watch = {.until = 0};
    ss_hand_verdict worst = {SOFTSIM_VERDICT_GOOD, ""};
    for (int k = 1; k <= 5000; ++k) {
        const double shake = size * sin(2.0 * SS_PI * hz * 1e-3 * fmax(0.0, k - 1000));
        const double depth = 0.008 * fmin(1.0, 1e-3 * k) + shake;
        const softsim_force force = push_up(400.0 * fmax(0.0, depth - touch));
        softsim_pose pose = at_depth(depth, told == FORCE_SEQ ? k - 1 : -1);
        pose.seq = k;
        pose.flags = told == CORRECTS ? SOFTSIM_POSE_CORRECTS : 0;
        if (told == APPLIED_FORCE) {
            ss_copy3(pose.applied_force, force.force);
        }
        const ss_hand_tick now = {.max_force_n = 8.0,
                                  .tick = k,
                                  .period = 1e-3,
                                  .pose = &pose,
                                  .sent = &force,
                                  .is_lockstep = told == LOCKSTEP};
        ss_hand_watch_tick(&watch, &now);
        worst = ss_hand_verdict_worse(worst, ss_hand_watch_verdict(&watch, k));
    }
    assert_true(worst.verdict == SOFTSIM_VERDICT_GOOD || strstr(worst.reason, "force_seq"));
    return worst.verdict;
}

/* 0.8 N to and fro is a tenth of what shakes a force: who says what he exerts, corrects it or has
 * no delay is known by other means. */
TEST(a_device_that_tells_nothing_is_told_where_late_forces_would_drive_it)
{
    assert_int_equal(verdict_of_shakes(NOTHING, 8.0, 0.002, 0.0), SOFTSIM_VERDICT_GUARDED);
    for (teller k = FORCE_SEQ; k < TELLERS; ++k) {
        assert_int_equal(verdict_of_shakes(k, 8.0, 0.002, 0.0), SOFTSIM_VERDICT_GOOD);
    }
}

/* For 4 s each, without a delay: as a hand moves what it holds, trembles, taps and taps hard. */
TEST(a_device_that_tells_nothing_may_move_as_hands_do)
{
    assert_int_equal(verdict_of_shakes(NOTHING, 2.0, 0.008, 0.0), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_of_shakes(NOTHING, 3.0, 0.006, 0.0), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_of_shakes(NOTHING, 10.0, 0.0003, 0.0), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_of_shakes(NOTHING, 4.0, 0.005, 0.008), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_of_shakes(NOTHING, 4.0, 0.016, 0.008), SOFTSIM_VERDICT_GUARDED);
}

/* J: what has to be counted, for 9 mJ and a pose lost in each of 40 moves there, at `there` N, and
 * back, at `back` N. */
static softsim_verdict verdict_with_lost(int lost, int32_t superseded, double there, double back)
{
    ss_hand_watch watch = {.until = 0};
    int32_t seq = 0;
    for (int k = 1; k <= 80; ++k) {
        const double force = k % 2 == 0 ? there : back;
        const softsim_force answer = push_up(force);
        softsim_pose pose = at_depth(k % 2 == 0 ? 0.002 : 0.001, -1);
        pose.seq = seq += 1 + lost + superseded;
        ss_copy3(pose.applied_force, answer.force);
        const ss_hand_tick now = {.max_force_n = 8.0,
                                  .tick = k,
                                  .period = 1e-3,
                                  .pose = &pose,
                                  .superseded = superseded,
                                  .sent = &answer,
                                  .contact_j = -0.009};
        ss_hand_watch_tick(&watch, &now);
    }
    return ss_hand_watch_verdict(&watch, 80).verdict;
}

/* A force that is told alone is known where poses come. */
TEST(what_a_lost_pose_would_have_told_is_counted)
{
    assert_int_equal(verdict_with_lost(0, 0, 2.0, 1.8), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_with_lost(0, 1, 2.0, 1.8), SOFTSIM_VERDICT_GOOD);
    assert_int_equal(verdict_with_lost(1, 0, 2.0, 1.8), SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(verdict_with_lost(1, 1, 2.0, 1.8), SOFTSIM_VERDICT_GUARDED);
    assert_int_equal(verdict_with_lost(1, 0, 2.0, 2.0), SOFTSIM_VERDICT_GOOD);
}

/* ---- a device whose poses stop ---- */

typedef struct silence {
    int ticks;              /* to the next pose */
    double newtons, metres; /* of the force meanwhile; out, by that pose */
    int period;             /* ticks from pose to pose before */
    int superseded;         /* poses that come with the next one */
    int64_t sender;         /* of that pose; 1 before */
    double let_in_j;
    bool is_lockstep, corrects;
    const char *word; /* of the reason, "": the verdict is good */
} silence;

/* Pressed for half a second, and then silence; the contact has taken 4 mJ before. */
static void assert_silence(const silence *c)
{
    ss_hand_watch watch = {.until = 0};
    const softsim_force sent = push_up(c->newtons);
    ss_hand_tick now = {.max_force_n = 8.0,
                        .period = 1e-3,
                        .sent = &sent,
                        .contact_j = 0.004,
                        .is_lockstep = c->is_lockstep};
    const int last = 500 * c->period;
    for (int k = 1; k <= last + c->ticks; ++k) {
        const bool is_back = k == last + c->ticks;
        softsim_pose pose = at_depth(is_back ? 0.0 : c->metres, k);
        pose.sender = is_back ? c->sender : 1;
        if (c->corrects) {
            pose.flags = SOFTSIM_POSE_CORRECTS;
            ss_set3(pose.applied_force, 0.0, 0.0, is_back ? 0.0 : c->newtons);
        }
        now.tick = k;
        now.pose = is_back || (k <= last && k % c->period == 0) ? &pose : NULL;
        now.superseded = is_back ? c->superseded : 0;
        now.sender_epoch = is_back && c->ticks >= 50 ? 2 : 1;
        now.let_in_j = is_back ? c->let_in_j : 0.0;
        now.contact_j = is_back ? 0.0 : now.contact_j;
        ss_hand_watch_tick(&watch, &now);
        assert_true(is_back || !is_telling(&watch, k));
    }
    const ss_hand_verdict told = ss_hand_watch_verdict(&watch, now.tick);
    assert_int_equal(told.verdict,
                     c->word[0] != '\0' ? SOFTSIM_VERDICT_GUARDED : SOFTSIM_VERDICT_GOOD);
    assert_non_null(strstr(told.reason, c->word));
}

/* The observer has the force of the last pose alone, which is none where the hand has left. */
TEST(a_hand_that_leaves_while_poses_stop_is_told)
{
    static const silence rows[] = {
        {45, 3.0, 0.015, 1, 0, 1, 0.0, false, false, "stopped for 20 ms"},
        {22, 3.0, 0.015, 1, 0, 1, 0.0, false, false, "stopped for 20 ms"},
        {15, 3.0, 0.015, 1, 0, 1, 0.0, false, false, ""},
        {45, 3.0, 0.004, 1, 0, 1, 0.0, false, false, ""},  /* 8 mJ */
        {45, 3.0, 0.015, 1, 0, 1, 0.05, false, false, ""}, /* let in before */
        {45, 3.0, 0.015, 1, 44, 1, 0.0, false, false, ""}, /* all come at once */
        {45, 3.0, 0.015, 1, 0, 2, 0.0, false, false, ""},
        {45, 0.0, 0.015, 1, 0, 1, 0.0, false, false, ""},
        {20, 3.0, 0.015, 10, 0, 1, 0.0, false, false, ""}, /* 100 Hz, one of them lost */
        {45, 3.0, 0.015, 10, 0, 1, 0.0, false, false, "stopped for 20 ms"},
        {45, 3.0, 0.008, 1, 0, 1, 0.0, false, false, "stopped for 20 ms"},
        {45, 3.0, 0.008, 1, 0, 1, 0.0, false, true, ""}, /* half as much */
        {45, 3.0, 0.015, 1, 0, 1, 0.0, false, true, "stopped for 20 ms"}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        assert_silence(&rows[k]);
    }
}

/* The loop skips ticks that it slept through: the poses of that time are there when it wakes. */
TEST(a_server_that_slept_does_not_blame_the_device)
{
    ss_hand_watch watch = {.until = 0};
    const softsim_force sent = push_up(3.0);
    ss_hand_tick now = {.max_force_n = 8.0, .period = 1e-3, .sent = &sent, .contact_j = 0.004};
    for (int k = 1; k <= 560; k += k == 500 ? 60 : 1) {
        softsim_pose pose = at_depth(0.005, k);
        pose.sender = 1;
        now.tick = k;
        now.pose = &pose;
        now.sender_epoch = 1;
        now.superseded = k == 560 ? 59 : 0;
        ss_hand_watch_tick(&watch, &now);
    }
    assert_int_equal(ss_hand_watch_verdict(&watch, now.tick).verdict, SOFTSIM_VERDICT_GOOD);
}

/* How far a hand had gone before the watchdog let go nobody knows; of one that has not come back,
 * or is another, nothing is said. In lockstep time waits. */
TEST(a_force_that_the_watchdog_let_go_is_told)
{
    static const silence rows[] = {
        {51, 0.5, 0.0, 1, 0, 1, 0.0, false, false, "stopped for 50 ticks"},
        {700, 3.0, 0.1, 1, 0, 1, 0.0, false, false, "stopped for 50 ticks"},
        {700, 3.0, 0.1, 1, 0, 2, 0.0, false, false, ""},
        {700, 0.0, 0.1, 1, 0, 1, 0.0, false, false, ""},
        {700, 3.0, 0.1, 1, 0, 1, 0.0, true, false, ""}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        assert_silence(&rows[k]);
    }
}

/* 8 mJ in a silence that the observer did not see, and 5 mJ after it that it did. */
TEST(what_a_silence_gave_counts_to_the_end_of_the_contact)
{
    for (int is_same_contact = 0; is_same_contact < 2; ++is_same_contact) {
        ss_hand_watch watch = {.until = 0};
        const softsim_force sent = push_up(2.0);
        ss_hand_tick now = {.max_force_n = 8.0, .period = 1e-3, .sent = &sent};
        for (int k = 1; k <= 200; ++k) {
            const softsim_pose pose = at_depth(k < 100 ? 0.004 : 0.0, k);
            now.tick = k;
            now.pose = k < 60 || k >= 100 ? &pose : NULL;
            now.contact_j = k < 100                        ? 1e-6
                            : k < 120                      ? -1e-6
                            : k == 120 && !is_same_contact ? 0.0
                                                           : -0.005;
            ss_hand_watch_tick(&watch, &now);
            assert_true(k >= 120 || !is_telling(&watch, k));
        }
        assert_int_equal(is_telling(&watch, 200), is_same_contact);
    }
}

/* In by 10 mm in a silence, from a touch of 0.1 N, and out again by the 1.5 N that have come
 * meanwhile: the observer took them for what was spent on the way in. */
TEST(what_a_hand_spent_while_poses_stopped_is_not_taken_for_granted)
{
    for (int is_silent = 0; is_silent < 2; ++is_silent) {
        ss_hand_watch watch = {.until = 0};
        ss_hand_tick now = {.max_force_n = 8.0, .period = 1e-3};
        for (int k = 1; k <= 200; ++k) {
            const double depth =
                0.01 * fmin(fmax(0.0, (k - 100) / 40.0), fmax(0.0, (200 - k) / 60.0));
            const softsim_force sent = push_up(k < 101 ? 0.1 : 1.5);
            const softsim_pose pose = at_depth(depth, k);
            now.tick = k;
            now.pose = !is_silent || k <= 100 || k > 140 ? &pose : NULL;
            now.sent = &sent;
            now.contact_j = now.pose ? 1e-6 + 1.5 * depth : now.contact_j;
            ss_hand_watch_tick(&watch, &now);
            assert_true(k > 160 || !is_telling(&watch, k));
        }
        assert_int_equal(is_telling(&watch, 200), is_silent);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
