/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A hand that holds still in the tissue while the world is reset, paused and resumed, at any pace
 * and in any order in which the two loops may hear of it, on bodies of every model: it never feels
 * more than it did before, no tick takes or gives more than a ramp's, a twentieth, and the model is
 * never struck.
 */
#include "common/test.h"

#include <math.h>
#include <string.h>

#include "common/effort.h"
#include "loops_fixture.h"
#include "oracles/limit_judge.h"
#include "press_fixture.h"

enum { HELD_TICK = 1000 };
static const double LIMIT = 8.0; /* N */

/* Unless all are asked for, by an argument: fewer commands. */
static bool is_all;

/* ---- judging ---- */

typedef struct judge {
    double held;       /* N, when the first command came */
    double held_model; /* N, most before it */
    double last[3], ramp_from;
    double most, model, end; /* N, after it */
    double rise, fall;       /* N a tick; fall beyond the ramp's twentieth of where it began */
} judge;

static void judge_tick(judge *j, const softsim_force *force, bool is_before)
{
    double change[3];
    const double size = limit_norm(force->force), before = limit_norm(j->last);
    for (int a = 0; a < 3; ++a) {
        change[a] = force->force[a] - j->last[a];
    }
    const double model = limit_norm(force->model_force);
    if (is_before) {
        j->held = size;
        j->held_model = fmax(j->held_model, model);
    } else {
        j->most = fmax(j->most, size);
        j->model = fmax(j->model, model);
        j->rise = fmax(j->rise, size - before);
        if (size < before) {
            j->fall = fmax(j->fall, limit_norm(change) - j->ramp_from / 20.0);
        }
    }
    j->ramp_from = size > before || size == 0.0 ? size : fmax(j->ramp_from, size);
    j->end = size;
    memcpy(j->last, force->force, sizeof j->last);
}

/* A body of each model, and how deep it is pressed so that it rests: the springs swing from tick
 * to tick at 4 mm, commands or none, and a chain's tetrahedra turn inside out at 8 mm. */
static const struct {
    int body;
    double depth; /* m */
    bool is_dear;
} models[] = {{0, 0.008, false}, {2, 0.008, true},   {4, 0.008, false},   {6, 0.008, true},
              {8, 0.008, true},  {10, 0.006, false}, {11, 0.0025, false}, {13, 0.004, false}};
enum { MODELS = sizeof models / sizeof *models };

/* A command every `gap` ticks, `count` of them, then .7 s of rest. */
static bool storm(int model, heard way, const char *const name[2], int gap, int count)
{
    static const char *const order_name[ORDERS] = {"lockstep", "simulation first", "haptic first"};
    const body *b = &bodies[models[model].body];
    const double depth = models[model].depth;
    const bool is_pause = strcmp(name[0], "pause") == 0;
    /* Chains keep a dent: a tool that is let in again feels nothing in it. */
    const bool keeps_dent = is_pause && strcmp(b->name, "chainmail") == 0;
    /* The hybrid's particles, which wake again under a tool that is let in again, push up to half
     * as much more before they come to rest where they were. */
    const double most = is_pause && strcmp(b->name, "hm1") == 0 ? 1.6 : 1.1;
    /* A body at rest is not struck at all; one that was held deep springs back against the tool. */
    const double struck = is_pause ? 3.0 : 1.1;
    softsim_world *world = make_world(b, LIMIT);
    softsim_state state;
    judge j = {0};
    int late = 0;
    const int last = HELD_TICK + gap * count;
    for (int n = 0; n < last + 700; ++n) {
        double x[3];
        for (int a = 0; a < 3; ++a) {
            x[a] = b->touch[a] + ((depth + 0.004) * smooth(n / 600.0) - 0.004) * b->in[a];
        }
        softsim_pose pose = pose_of(n + 1, x);
        pose.utime_us = 1000 * (int64_t)n;
        const int k = n >= HELD_TICK && (n - HELD_TICK) % gap == 0 ? (n - HELD_TICK) / gap : -1;
        const bool is_due = k >= 0 && k < count;
        softsim_force force;
        if (way == LOCKSTEP) {
            if (is_due) {
                command(ss_world_of(world), name[k % 2]);
            }
            force = feel(world, &pose);
        } else {
            force = turn(ss_world_of(world), way, &pose, is_due ? name[k % 2] : NULL, &late);
        }
        judge_tick(&j, &force, n < HELD_TICK);
    }
    softsim_read(world, &state);
    softsim_destroy(&world);
    const bool is_good = j.most <= most * j.held && j.rise <= 0.05 * j.held &&
                         j.fall <= 0.05 * j.held &&
                         j.model <= struck * fmax(j.held, j.held_model) &&
                         (keeps_dent || fabs(j.end - j.held) <= 0.1 * j.held) &&
                         state.worst_verdict <= SOFTSIM_VERDICT_GUARDED;
    print_message("%s, %s, %s every %d: held %.3f N (model %.2f), then at most %.3f, up %.4f a "
                  "tick, down %.4f beyond the ramp, model %.2f, in the end %.3f; %s%s\n",
                  b->name, order_name[way], name[0], gap, j.held, j.held_model, j.most, j.rise,
                  j.fall, j.model, j.end, state.worst_reason, is_good ? "" : ": BAD");
    return is_good;
}

TEST(resets_are_entered_anew)
{
    static const char *const reset[2] = {"reset", "reset"};
    static const int gaps[] = {120, 250, 310, 400, 1, 10, 22};
    enum { GAPS = sizeof gaps / sizeof *gaps };
    bool is_good = true;
    write_block_mesh();
    for (int m = FULL_IN_RELEASE(0, MODELS - 1); m < MODELS; ++m) {
        /* What is dear has a pause and no reset. */
        if (models[m].is_dear && FULL_IN_LONG_RUN(false, !is_all)) {
            continue;
        }
        for (int g = 0; g < GAPS; ++g) {
            for (int way = 0; way < ORDERS; ++way) {
                if (is_all || (g % 4 == m % 4 && g < 4 && way == m % ORDERS)) {
                    is_good = storm(m, (heard)way, reset, gaps[g], is_all ? 30 : 4) && is_good;
                }
            }
        }
    }
    assert_true(is_good);
}

/* The model that has pauses of gap `g`: each gap once, the long ones on what costs little. */
static int pause_row(int g)
{
    static const int light[] = {0, 5, 6, 7};
    return g < MODELS ? g : light[g - MODELS];
}

TEST(pauses_and_resumes_ramp_and_enter)
{
    static const char *const pause[2] = {"pause", "resume"};
    static const int gaps[] = {1, 2, 3, 5, 10, 19, 20, 21, 30, 50, 150, 300};
    enum { GAPS = sizeof gaps / sizeof *gaps };
    bool is_good = true;
    write_block_mesh();
    for (int m = FULL_IN_RELEASE(0, MODELS - 1); m < MODELS; ++m) {
        for (int g = 0; g < GAPS; ++g) {
            const int count = is_all || gaps[g] < 50 ? 20 : FULL_IN_LONG_RUN(20, 6);
            for (int way = 0; way < ORDERS; ++way) {
                /* With 19 a tool is put back every 38 ms, into a dent that still springs back. */
                if (is_all || (pause_row(g) == m && way == g % ORDERS) ||
                    (m == 0 && gaps[g] == 19 && way == LOCKSTEP)) {
                    is_good = storm(m, (heard)way, pause, gaps[g], count) && is_good;
                }
            }
        }
    }
    assert_true(is_good);
}

/* The button goes down while the tool is let in again, 8 mm deep, `after` ticks from a reset: what
 * the force changes by in a tick, of what is held in the end. */
static double grasp_step(const char *scene, const double touch[3], double rate_hz, int after)
{
    enum { UP_TICK = 2000, TICKS = 2500 };
    char path[512], rate[64];
    (void)snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s", scene);
    (void)snprintf(rate, sizeof rate, "simulation.rate_hz=%g", rate_hz);
    const char *const set[] = {rate, "contact.tools=[{probe: 0, shape: {sphere: {radius_mm: 5}}}]",
                               kidney_mesh()};
    const bool is_kidney = strcmp(scene, "kidney.yaml") == 0;
    softsim_world *world = open_scene(path, set, is_kidney ? 3 : 2);
    const int down = HELD_TICK + after;
    double last[3] = {0.0, 0.0, 0.0}, step = 0.0;
    for (int n = 0; n < TICKS; ++n) {
        const double x[3] = {touch[0], touch[1],
                             touch[2] + 0.005 - 0.012 * smooth((n - 100) / 600.0) + 0.004};
        softsim_pose pose = pose_of(n + 1, x);
        pose.buttons = n >= down && n < UP_TICK ? SOFTSIM_BUTTON_GRASP : 0;
        if (n == HELD_TICK) {
            command(ss_world_of(world), "reset");
        }
        const softsim_force force = feel(world, &pose);
        double change[3];
        for (int a = 0; a < 3; ++a) {
            change[a] = force.force[a] - last[a];
        }
        step = n >= down && n < UP_TICK ? fmax(step, limit_norm(change)) : step;
        memcpy(last, force.force, sizeof last);
    }
    softsim_destroy(&world);
    return step / limit_norm(last);
}

/* What is held moves with the tool, and is no place to let it in from. */
TEST(a_grasp_begun_while_a_tool_is_let_in_is_no_kick)
{
    static const struct {
        const char *scene;
        double touch[3], rate_hz;
        int after;
    } cases[] = {{"kidney.yaml", {0.0, 0.006, 0.0223}, 60.0, 250},
                 {"liver.yaml", {-0.035, 0.0, 0.042}, 1000.0, 100}};
    bool is_good = true;
    for (int k = 0; k < 2; ++k) {
        const double step =
            grasp_step(cases[k].scene, cases[k].touch, cases[k].rate_hz, cases[k].after);
        print_message("%s, %g Hz, grasped %d ticks after a reset: steps by %.4f of the force\n",
                      cases[k].scene, cases[k].rate_hz, cases[k].after, step);
        is_good = step <= 0.01 && is_good;
    }
    assert_true(is_good);
}

int main(int argc, char **argv)
{
    is_all = argc > 1 && strcmp(argv[1], "all") == 0;
    return run_all_tests(make_folder, remove_folder);
}
