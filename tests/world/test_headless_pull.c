/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A grasp that is drawn far beyond the force limit L, against the same way without a limit: where
 * that gives at least L, so does this; its direction turns by no more than a degree a tick beside
 * what the other's does, its steps are at most 2 % of L above the other's, and a closed way gives
 * the hand nothing. Slow, smooth hands, each beside, over and round the place where it took hold;
 * and a limit that changes meanwhile.
 */
#include "common/test.h"

#include "common/effort.h"
#include "loops_fixture.h"
#include "oracles/limit_judge.h"
#include "press_fixture.h"
#include "rt/vec.h"

#define FAST "simulation.rate_hz=1000"
#define SLOW "simulation.rate_hz=100"

static const body held[] = {
    {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, 0.006},
    {"kidney, deep", "kidney.yaml", NULL, NULL,
     AT(0.0488, -0.0123, 0.0181, -0.540, 0.076, -0.838, 0.0, 0.996, 0.090), 0.021},
    {"fem", NULL, "  name: fem\n" ELASTIC, NULL, ON_BLOCK, 0.004},
    {"corotational", NULL, "  name: corotational\n" ELASTIC, NULL, ON_BLOCK, 0.004},
    {"xpbd", NULL, "  name: xpbd\n" ELASTIC, NULL, ON_BLOCK, 0.004},
};
enum { HELD = sizeof held / sizeof *held };

static const double limits[] = {0.2, 1.0, 0.5, 2.0};
enum { LIMITS = sizeof limits / sizeof *limits };

/* ms: pressed in, grasped; on its way; stands; on its way back; let go, and out. */
enum { IN = 400, GRASPED = 560, AWAY = 1500, ROUND = 2500, STILL = 2900, BACK = 3900 };
enum { OUT = 4000, TICKS = 4400 };

/* m, from where it was pressed in: inward, along the surface, and across both. */
typedef struct way {
    const char *name;
    double out[3];   /* to there and back */
    double round;    /* radius of the circle along the surface that follows */
    double swing[3]; /* and to and fro meanwhile, over the place */
    double sweep;    /* along the surface to and fro from the press on, at up to 0.1 m/s */
} way;

static const way ways[] = {
    {.name = "aside", .out = {0.0, 0.018, 0.0}, .round = 0.006},
    {.name = "over", .out = {0.012, 0.006, 0.004}, .round = 0.010, .swing = {0.0, 0.004, 0.016}},
    {.name = "off", .out = {-0.012, -0.008, 0.0}, .round = 0.012, .swing = {0.002, 0.0, 0.004}},
    {.name = "swept", .sweep = 0.0145},
};
enum { WAYS = sizeof ways / sizeof *ways };

static double part(int n, int from, int to)
{
    return smooth((double)(n - from) / (to - from));
}

static softsim_pose pose_at(const body *b, const way *w, int n)
{
    const double away = part(n, GRASPED, AWAY) - part(n, STILL, BACK);
    const double angle = 6.283185307179586 * part(n, AWAY, ROUND);
    const double swing = sin(2.0 * 6.283185307179586 * part(n, AWAY, ROUND));
    const double sweep = (part(n, IN, GRASPED + 140) - part(n, STILL, BACK)) *
                         sin(6.283185307179586 * (n - 305) / 860.0);
    const double depth = -0.004 + (b->depth + 0.004) * (part(n, 0, IN) - part(n, OUT, TICKS)) +
                         away * w->out[0] + swing * w->swing[0];
    const double along =
        away * w->out[1] + w->round * (1.0 - cos(angle)) + swing * w->swing[1] + sweep * w->sweep;
    const double across = away * w->out[2] + w->round * sin(angle) + swing * w->swing[2];
    double third[3], x[3];
    ss_cross3(third, b->in, b->side);
    ss_madd3(x, b->touch, depth, b->in);
    ss_madd3(x, x, along, b->side);
    ss_madd3(x, x, across, third);
    softsim_pose pose = pose_of(n + 1, x);
    pose.buttons = n >= GRASPED && n < BACK ? SOFTSIM_BUTTON_GRASP : 0;
    return pose;
}

/* Of L: tissue that moves with an unlimited hand holds it back by what is viscous in it, too. */
#define BEYOND 1.05

typedef struct felt {
    double force[TICKS][3];
    double energy; /* J, that the hand got from touch to leaving */
} felt;

static void pull(const body *b, const way *w, double limit, const char *rate, felt *out)
{
    char force[64];
    (void)snprintf(force, sizeof force, "haptic.max_force_n=%g", limit);
    const char *const set[] = {force, rate};
    softsim_world *world = open_body(b, set, 2);
    softsim_pose last = {0};
    out->energy = 0.0;
    for (int n = 0; n < TICKS; ++n) {
        const softsim_pose pose = pose_at(b, w, n);
        ss_copy3(out->force[n], feel(world, &pose).force);
        if (n > 0) {
            double step[3], mean[3];
            ss_sub3(step, pose.position, last.position);
            ss_add3(mean, out->force[n], out->force[n - 1]);
            out->energy += 0.5 * ss_dot3(mean, step);
        }
        last = pose;
    }
    softsim_destroy(&world);
}

typedef struct verdict {
    int judged;         /* ticks at the limit */
    double least, most; /* |F| / L */
    double turn, step;  /* degrees, |dF| / L: above those without a limit */
    int turn_tick, step_tick;
} verdict;

static double step_of(const felt *f, int n)
{
    double change[3];
    ss_sub3(change, f->force[n], f->force[n - 1]);
    return ss_norm3(change);
}

static verdict judge(const felt *at, const felt *open, double limit)
{
    verdict v = {.least = 1.0};
    for (int n = GRASPED; n < BACK; ++n) {
        const double size = ss_norm3(at->force[n]) / limit;
        const double step = (step_of(at, n) - step_of(open, n)) / limit;
        v.most = fmax(v.most, size);
        if (step > v.step) {
            v.step = step;
            v.step_tick = n;
        }
        if (ss_norm3(open->force[n]) < BEYOND * limit) {
            continue;
        }
        ++v.judged;
        v.least = fmin(v.least, size);
        const double turn = limit_angle(at->force[n - 1], at->force[n]) -
                            limit_angle(open->force[n - 1], open->force[n]);
        if (turn > v.turn) {
            v.turn = turn;
            v.turn_tick = n;
        }
    }
    return v;
}

static bool pulls_well(const body *b, const way *w, const char *rate, int limit_count)
{
    static felt open, at;
    bool is_good = true;
    pull(b, w, 100.0, rate, &open);
    for (int k = 0; k < limit_count; ++k) {
        const double limit = limits[k];
        pull(b, w, limit, rate, &at);
        const verdict v = judge(&at, &open, limit);
        const bool is_kept = v.judged > 1000 && v.least >= 0.99 && v.most <= 1.0001 &&
                             v.turn <= 1.0 && v.step <= 0.02 && at.energy <= 1e-3;
        print_message("%s, %s, %s, %g N: %d ticks, |F|/L %.4f..%.7f, turn %.3f at %d, step %.4f at "
                      "%d, energy %.2f mJ (%.2f)%s\n",
                      b->name, w->name, strchr(rate, '=') + 1, limit, v.judged, v.least, v.most,
                      v.turn, v.turn_tick, v.step, v.step_tick, 1e3 * at.energy, 1e3 * open.energy,
                      is_kept ? "" : ": BAD");
        is_good = is_good && is_kept;
    }
    return is_good;
}

/* By default a few of them, each rate and two models among them. */
static bool is_wanted(int body_index, int way_index, int rate)
{
    static const int row[][3] = {{0, 1, 0}, {1, 3, 0}, {1, 3, 1}, {2, 1, 1}, {2, 0, 0}};
    bool is_row = is_long_run();
    for (size_t k = 0; k < sizeof row / sizeof *row; ++k) {
        is_row = is_row || (row[k][0] == body_index && row[k][1] == way_index && row[k][2] == rate);
    }
    return is_row;
}

TEST(a_grasp_drawn_beyond_the_limit_turns_as_the_hand_does)
{
    SKIP_WHERE_REPEATED();
    static const char *const rate[] = {FAST, SLOW};
    const int limit_count = FULL_IN_LONG_RUN(LIMITS, 2);
    bool is_good = true;
    for (int n = 0; n < HELD * WAYS * 2; ++n) {
        const int b = n / (WAYS * 2), w = n / 2 % WAYS;
        if (is_wanted(b, w, n % 2)) {
            is_good = pulls_well(&held[b], &ways[w], rate[n % 2], limit_count) && is_good;
        }
    }
    assert_true(is_good);
}

/* Drawn aside and held there while the limit goes down, and up again: the force reaches it by the
 * slew, keeps to it, and turns by no more than a degree a tick. */
TEST(a_limit_changed_in_a_grasp_is_kept_as_the_force_turns)
{
    SKIP_WHERE_REPEATED();
    enum { LOWERED = 1300, RAISED = 2000, END = 2600, RISEN = 300 };
    const body *b = &held[0];
    const way *w = &ways[0];
    const char *const set[] = {"haptic.max_force_n=4", FAST};
    softsim_world *world = open_body(b, set, 2);
    double last[3] = {0.0, 0.0, 0.0}, turn = 0.0;
    for (int n = 0; n < END; ++n) {
        if (n == LOWERED || n == RAISED) {
            set_limit(ss_world_of(world), n == LOWERED ? 0.3 : 1.0);
        }
        const softsim_pose pose = pose_at(b, w, n);
        const softsim_force force = feel(world, &pose);
        const double size = ss_norm3(force.force);
        if (n >= LOWERED) {
            turn = fmax(turn, limit_angle(last, force.force));
            assert_true(fabs(size - ss_norm3(last)) <= 2.0 + 1e-9);
        }
        if (n >= LOWERED + 2 && n < RAISED) {
            assert_true(size >= 0.99 * 0.3 && size <= 1.0001 * 0.3);
        }
        if (n >= RAISED + RISEN) {
            assert_true(size >= 0.99 && size <= 1.0001);
        }
        ss_copy3(last, force.force);
    }
    softsim_destroy(&world);
    print_message("turns by %.3f degrees a tick at most\n", turn);
    assert_true(turn <= 1.0);
}

int main(void)
{
    return run_all_tests(make_folder_with_block, remove_folder);
}
