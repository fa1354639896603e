/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * bench/stability/hand: what a hand got is judged from poses and forces alone. The judge finds the
 * energy of closed forms and of planted defects, and agrees with the program's own watch.
 */
#include "common/test.h"

#include <math.h>

#include "bench/stability/hand.h"
#include "common/hand_fixture.h"
#include "rt/vec.h"
#include "world/watch.h"

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
TEST(a_sampled_spring_hands_out_what_its_steps_leave)
{
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
TEST(torque_works_and_what_chatters_is_one_contact)
{
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

TEST(what_makes_energy_is_found)
{
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
TEST(what_was_let_in_does_not_drive)
{
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
TEST(the_watch_and_the_judge_agree_on_random_tracks)
{
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
            const ss_hand_tick now = {.max_force_n = INFINITY,
                                      .tick = k,
                                      .period = 1e-3,
                                      .pose = &pose,
                                      .sent = &answer,
                                      .is_lockstep = true};
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

int main(void)
{
    return run_all_tests(NULL, NULL);
}
