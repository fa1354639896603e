/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The energy that nobody had of what a hand is given in a part of a contact: against the
 * definition, all parts of a track one by one; and what the watch makes of it.
 */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "common/hand_fixture.h"
#include "rt/vec.h"
#include "world/supply.h"
#include "world/watch.h"

/* ---- against the definition ---- */

enum { TICKS = 200, RESULTS = TICKS + 4 };

typedef struct track {
    int32_t every; /* ticks a result */
    double given[TICKS], others[TICKS], coupling[TICKS], stored[RESULTS];
} track;

static int32_t max_of(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

/* S of the tick, of the results before, in use, and the two after. Result k comes before tick
 * k every; there is none before the first. */
static double stored_at(const track *t, int32_t tick)
{
    const int32_t used = tick / t->every;
    double most = 0.0;
    for (int32_t k = max_of(0, used - 1); k <= used + 2; ++k) {
        most = fmax(most, t->stored[k]);
    }
    return most;
}

/* Energy E_j - E_i of all parts, less what was there at their beginning. */
static double made_by_definition(const track *t, int32_t first, int32_t last)
{
    double most = 0.0;
    for (int32_t i = first - 1; i < last; ++i) { /* i = first - 1: before the first touch */
        const double had = stored_at(t, i) + (i < first ? 0.0 : t->coupling[i]);
        double energy = 0.0;
        for (int32_t j = i + 1; j < last; ++j) {
            energy += t->given[j] - t->others[j];
            most = fmax(most, energy - had);
        }
    }
    return most;
}

/* The contact lasts from tick `first` to before `last`. */
static double made_by_supply(const track *t, int32_t first, int32_t last)
{
    ss_supply supply = {.is_known = false};
    double made = 0.0;
    /* Before the track the tissue was at rest. */
    for (int k = 0; k < 4; ++k) {
        (void)ss_supply_take(&supply, 0.0, true);
    }
    (void)ss_supply_clear(&supply);
    for (int32_t k = 0; k < TICKS; ++k) {
        if (k % t->every == 0) {
            made = fmax(made, ss_supply_take(&supply, t->stored[k / t->every], true));
        }
        if (k >= first && k < last) {
            const double given[SS_SUPPLY_DEVICES] = {0.0, t->given[k], 0.0};
            ss_supply_tick(&supply, given, t->others[k], t->coupling[k]);
        } else if (k < first) {
            (void)ss_supply_clear(&supply);
        }
    }
    return made;
}

TEST(it_is_the_worst_of_all_parts)
{
    static track t;
    int32_t found = 0;
    for (int run = 0; run < 400; ++run) {
        t.every = 1 << run % 5;
        for (int32_t k = 0; k < TICKS; ++k) {
            t.given[k] = 0.01 * noise();
            t.others[k] = fmax(0.0, 0.01 * noise() - 0.008);
            t.coupling[k] = 0.01 * (1.0 + noise());
        }
        for (int32_t k = 0; k < RESULTS; ++k) {
            t.stored[k] = 0.03 * (1.0 + noise());
        }
        const int32_t first = 20 + run % 13, last = TICKS - 3 * t.every;
        const double expected = made_by_definition(&t, first, last);
        const double made = made_by_supply(&t, first, last);
        if (!(fabs(made - expected) < 1e-12)) {
            fail_msg("run %d, %d ticks a result: %.9g, by definition %.9g", run, (int)t.every, made,
                     expected);
        }
        found += expected > 0.0;
    }
    assert_true(found > 100 && found < 400);
}

/* One result every `every` ticks; the first three settle nothing. */
TEST(what_is_not_known_yet_is_not_judged)
{
    const double given[SS_SUPPLY_DEVICES] = {1.0, 1.0, 1.0};
    for (int is_told = 0; is_told < 2; ++is_told) {
        ss_supply supply = {.is_known = false};
        double made = 0.0;
        for (int k = 0; k < 10; ++k) {
            made = fmax(made, ss_supply_take(&supply, 0.0, is_told != 0));
            ss_supply_tick(&supply, given, 0.0, 0.0);
            assert_true(k > 2 || made == 0.0);
        }
        assert_true(is_told ? made > 1.0 : made == 0.0);
        assert_true(is_told ? ss_supply_clear(&supply) > 1.0 : ss_supply_clear(&supply) == 0.0);
    }
}

/* ---- in the watch ---- */

typedef enum planted {
    SOUND,      /* tissue that gives back what it has stored */
    SWALLOWED,  /* it keeps a tenth of the work and gives half back */
    BY_LOAD,    /* the same, but a load works on it meanwhile */
    BY_OTHER,   /* or another hand */
    LET_IN,     /* or the entry */
    UNTOLD,     /* or nobody knows what is stored */
    IN_COUPLING /* or all was in the spring of the coupling */
} planted;

/* A press with 1000 N/m by 10 mm in a second and back, `scale` times as much; what the watch tells
 * at its worst. With a clock the client names its forces, and the observer's sums count. */
static ss_hand_verdict press(planted what, double scale, bool is_lockstep)
{
    ss_hand_watch watch = {.has_pose = false};
    ss_hand_verdict worst = {SOFTSIM_VERDICT_GOOD, ""};
    double device = 0.0, others = 0.0, load = 0.0, before = 0.0, last_force = 0.0;
    for (int k = 1; k <= 2200; ++k) {
        const double x = 0.01 * fmax(0.0, 1.0 - fabs(k - 1050.0) / 1000.0);
        const bool is_out = k > 1050;
        const double share = what == SOUND ? 1.0 : 0.5;
        const double force = scale * 1000.0 * x * (is_out ? share : 1.0);
        const double kept = what == SOUND ? 1.0 : 0.1;
        const softsim_pose pose = at_depth(x, is_lockstep ? -1 : k);
        softsim_force sent = push_up(force);
        ss_copy3(sent.proxy, what == IN_COUPLING ? (double[3]){0.0} : pose.position);
        const double given = last_force * (before - x);
        const double more = is_out ? fmax(0.0, given) : 0.0;
        device += given;
        others += what == BY_OTHER ? more : 0.0;
        load += what == BY_LOAD ? more : 0.0;
        const ss_simulation_result result = {.has_stored = what != UNTOLD,
                                             .stored = kept * scale * 500.0 * x * x,
                                             .load_work = load};
        const ss_hand_tick now = {.max_force_n = INFINITY,
                                  .tick = k,
                                  .period = 1e-3,
                                  .pose = &pose,
                                  .sent = &sent,
                                  .result = &result,
                                  .contact_j = -device,
                                  .device_j = device,
                                  .others_j = others,
                                  .let_in_j = what == LET_IN ? more : 0.0,
                                  .is_lockstep = is_lockstep};
        ss_hand_watch_tick(&watch, &now);
        worst = ss_hand_verdict_worse(worst, ss_hand_watch_verdict(&watch, k));
        before = x;
        last_force = force;
    }
    return worst;
}

/* Of 50 mJ put in 5 are stored and 25 given back: 20 mJ that nobody had, although the hand is left
 * with a loss. */
TEST(what_tissue_swallowed_excuses_nothing)
{
    for (int is_lockstep = 0; is_lockstep < 2; ++is_lockstep) {
        assert_int_equal(press(SOUND, 1.0, is_lockstep).verdict, SOFTSIM_VERDICT_GOOD);
        assert_int_equal(press(SWALLOWED, 0.45, is_lockstep).verdict, SOFTSIM_VERDICT_GOOD);
        const ss_hand_verdict made = press(SWALLOWED, 1.0, is_lockstep);
        assert_int_equal(made.verdict, SOFTSIM_VERDICT_GUARDED);
        assert_non_null(strstr(made.reason, "neither it nor the tissue had"));
        assert_int_equal(press(SWALLOWED, 4.5, is_lockstep).verdict, SOFTSIM_VERDICT_GUARDED);
        assert_int_equal(press(SWALLOWED, 5.5, is_lockstep).verdict, SOFTSIM_VERDICT_DEGRADED);
        for (int what = BY_LOAD; what <= IN_COUPLING; ++what) {
            const ss_hand_verdict told = press((planted)what, 1.0, is_lockstep);
            if (told.verdict != SOFTSIM_VERDICT_GOOD) {
                fail_msg("%d: %s", what, told.reason);
            }
        }
    }
}

/* The next contact begins with nothing that the last one left. */
TEST(each_contact_begins_anew)
{
    ss_supply supply = {.is_known = false};
    const double given[SS_SUPPLY_DEVICES] = {0.02, 0.02, 0.02},
                 put_in[SS_SUPPLY_DEVICES] = {-0.02, -0.02, -0.02};
    for (int k = 0; k < 8; ++k) {
        assert_true(ss_supply_take(&supply, 0.02, true) <= 0.0);
        ss_supply_tick(&supply, put_in, 0.0, 0.0);
    }
    assert_true(ss_supply_clear(&supply) <= 0.0);
    for (int k = 0; k < 4; ++k) { /* of 80 mJ, 20 are stored */
        assert_true(ss_supply_take(&supply, 0.02, true) < 0.05);
        ss_supply_tick(&supply, given, 0.0, 0.0);
    }
    assert_true(fabs(ss_supply_clear(&supply) - 0.06) < 1e-12);
    assert_true(ss_supply_clear(&supply) <= 0.0); /* told once */
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
