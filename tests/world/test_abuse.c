/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Tools that no careful hand holds: a step slower than time takes them a share of their way, and
 * says where they stand; every model that hands out energy says so.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/stability/audit.h"
#include "bench/stability/stress_case.h"
#include "bench/stability/stress_scene.h"
#include "common/effort.h"
#include "common/folder_fixture.h"
#include "common/hand_fixture.h"
#include "pressed_fixture.h"
#include "rt/vec.h"

/* ---- worlds ---- */

static ss_world *make_planned(ss_stress_case_plan *plan)
{
    FILE *file = open_file("body.msh");
    ss_specimen_write(&plan->specimen, file);
    assert_int_equal(fclose(file), 0);
    file = open_file("scene.yaml");
    ss_stress_case_plan_write(plan, file);
    assert_int_equal(fclose(file), 0);
    return make_scene(in_folder("scene.yaml"), NULL, 0);
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
TEST(a_step_slower_than_time_does_not_fling_the_tool)
{
    static const char *const set[] = {"simulation.max_substeps=4"};
    ss_world *world = make_kidney(set, 1);
    double kinetic;
    const softsim_state last = shake(world, 900, 0.001, &kinetic);
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
        ss_haptic_predict(&probe->step_target, 1.0, world->step_period, goal);
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
 * the kidney and a stiff block of every model, with one sub-step. */
TEST(the_haptic_loop_is_told_where_a_slow_step_left_the_tool)
{
    SKIP_WHERE_REPEATED();
    static const char *const set[] = {"simulation.max_substeps=1"};
    static ss_stress_case_plan plan; /* large */
    int32_t slow_models = 0;
    ss_world *world = make_kidney(set, 1);
    assert_true(follow_slow_steps(world, 0.005, 0.003, pressed_z, free_z) > 20);
    destroy(world);
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        const ss_stress_case trial = {s, SS_STRESS_CASE_PROBE, 1e8, 0.1, 0};
        ss_stress_case_plan_make(&trial, &plan);
        plan.max_substeps = 1;
        const double *top = plan.specimen.rest[SS_STRESS_CASE_TOP_CENTRE];
        const double touch = top[2] + SS_STRESS_CASE_TOOL_RADIUS;
        world = make_planned(&plan);
        slow_models += follow_slow_steps(world, top[0], top[1], touch - 0.002, touch + 0.005) > 0;
        destroy(world);
    }
    assert_true(slow_models >= 4);
}

/* Under pause nothing moves, and nothing is flung when it goes on. */
TEST(a_paused_tool_stays_where_it_is)
{
    ss_world *world = make_kidney(NULL, 0);
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
    int32_t held = 0;
    ss_world_command(world, "pause", "", &record, text, (int32_t)sizeof text);
    for (; k <= 200; ++k) {
        tick(world, k, 0.005, 0.003, pressed_z + 1e-4 * (k - 150));
        if (probe->was_present) { /* until the force is ramped down */
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

/* A tracker that throws the tool about: the model's energy balance calls it work, but no hand does
 * it. */
TEST(energy_that_no_hand_has_stops_the_tissue)
{
    ss_world *world = make_kidney(NULL, 0);
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

/* A tracker that jitters, at three depths: what is shaken is told, where more than 10 mJ are handed
 * out (the deeper two) as degraded, and is at rest again when the tool is gone. No reset is needed.
 */
TEST(a_jittering_tracker_stops_nothing)
{
    (void)state;
    static const double lower[] = {0.0, 0.003, 0.005};
    const int32_t count = FULL_IN_RELEASE(3, 1);
    for (int32_t run = 0; run < count; ++run) {
        ss_world *world = make_kidney(NULL, 0);
        const double a = 0.0025;
        softsim_state now;
        int32_t k = 1;
        for (; k <= 700; ++k) {
            const double z = height(k) - lower[run];
            tick(world, k, 0.005 + a * noise(), 0.003 + a * noise(), z + a * noise());
        }
        for (; k <= 1900; ++k) { /* for a second is told what was */
            tick(world, k, 0.005, 0.003, free_z + 0.02);
        }
        softsim_read((softsim_world *)world, &now);
        assert_true(now.worst_verdict == SOFTSIM_VERDICT_DEGRADED ||
                    (run == 0 && now.worst_verdict == SOFTSIM_VERDICT_GUARDED));
        assert_int_equal(now.verdict, SOFTSIM_VERDICT_GOOD);
        const ss_real *u = world->model_class->displacement(world->model);
        for (int32_t i = 0; i < 4 * now.node_count; ++i) {
            assert_true(fabs((double)u[i]) < 1e-4);
        }
        destroy(world);
    }
}

/* A button that bounces while the hand shakes: grasped the tool stays where it is, let go it goes
 * along with the hand, and so each bounce could take it further away. */
TEST(a_bouncing_button_does_not_lose_the_tool)
{
    ss_world *world = make_scene(KIDNEY, NULL, 0);
    const int32_t ticks = FULL_IN_LONG_RUN(2000, FULL_IN_RELEASE(500, 200));
    double apart = 0.0, x[3] = {0.005, 0.003, free_z}, shake[3] = {0.0};
    bool is_pressed = false;
    for (int32_t k = 1; k <= ticks; ++k) {
        double between[3];
        for (int a = 0; a < 3 && k > 100 && k % 3 == 0; ++a) {
            shake[a] = 0.01 * noise();
        }
        ss_set3(x, 0.005 + shake[0], 0.003 + shake[1], height(k) + shake[2]);
        is_pressed = noise() > 0.6 ? !is_pressed : is_pressed; /* every 5 ms or so */
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_pose pose = at_depth(0.0, -1);
        const int32_t channel = 0;
        pose.sender = 1;
        pose.seq = k;
        pose.buttons = is_pressed ? SOFTSIM_BUTTON_GRASP : 0;
        ss_copy3(pose.position, x);
        ss_set3(pose.velocity, NAN, NAN, NAN);
        softsim_tick((softsim_world *)world, &pose, &channel, 1, force);
        ss_world_settle(world);
        ss_sub3(between, force[0].proxy, x);
        apart = fmax(apart, ss_norm3(between));
    }
    destroy(world);
    /* Beyond 5 cm it begins anew; and one throw of the hand, 20 mm along each axis. */
    if (!(apart < 0.085)) {
        fail_msg("the tool was %g m from the hand", apart);
    }
}

/* ---- every model ---- */

static ss_stress_case_result abuse(int32_t subject, ss_stress_case_kind kind, double value,
                                   int32_t variant)
{
    const ss_stress_case stress_case = {subject, kind, 1e4, value, variant};
    ss_stress_case_result result;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_stress_case_run(&stress_case, folder, &result, &error), SOFTSIM_OK);
    return result;
}

TEST(what_hands_out_energy_is_not_called_good)
{
    static const struct {
        ss_stress_case_kind kind;
        double value;
        int32_t variant;
    } runs[] = {{SS_STRESS_CASE_NOISE, 1e-3, 0},
                {SS_STRESS_CASE_IN_OUT, 500.0, 0},
                {SS_STRESS_CASE_THROUGH, 100.0, 2},
                {SS_STRESS_CASE_PAUSE, 2000.0, 0}};
    int32_t handed_out = 0;
    const int32_t count = FULL_IN_RELEASE(ss_stress_case_subject_count(), 1);
    for (int32_t s = 0; s < count; ++s) {
        for (size_t k = 0; k < sizeof runs / sizeof *runs; ++k) {
            const ss_stress_case_result r = abuse(s, runs[k].kind, runs[k].value, runs[k].variant);
            if (!r.is_agreed) {
                char found[192];
                ss_audit_text(r.found, found, (int32_t)sizeof found);
                fail_msg("%s, %s: found %s (%g J), the program said: %s",
                         ss_stress_case_subject_name(s), ss_stress_case_kind_name(runs[k].kind),
                         found, r.handed_out_j, r.acted);
            }
            assert_true(r.force_n <= limit_n * (1.0 + 1e-9));
            assert_true(r.kinetic_j < limit_n * body_m);
            handed_out += r.handed_out_j > 0.01;
        }
    }
    assert_true(handed_out > 0); /* else nothing was tried */
}

/* Parts of a contact hand out more than was stored, which the contact as a whole swallowed before:
 * a sphere that is drawn across at 3 m/s, a box that turns ten times a second. */
TEST(what_a_part_of_a_contact_makes_is_not_called_good)
{
    SKIP_WHERE_REPEATED();
    static const ss_stress_case_kind kind[] = {SS_STRESS_CASE_THROUGH, SS_STRESS_CASE_SPIN};
    int32_t made = 0;
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        for (int k = 0; k < 2; ++k) {
            const bool is_spin = kind[k] == SS_STRESS_CASE_SPIN;
            const ss_stress_case stress_case = {s, kind[k], 1e5, is_spin ? 10.0 : 3.0,
                                                is_spin ? 1 : 2};
            ss_stress_case_result r;
            softsim_error error = {.status = SOFTSIM_OK};
            assert_int_equal(ss_stress_case_run(&stress_case, folder, &r, &error), SOFTSIM_OK);
            if (!r.is_agreed) {
                fail_msg("%s, %s: %g J made, the program said: %s", ss_stress_case_subject_name(s),
                         ss_stress_case_kind_name(kind[k]), r.made_j, r.acted);
            }
            made +=
                r.made_j > 0.01 && r.handed_out_j < 0.01 && r.verdict == SOFTSIM_VERDICT_GUARDED;
        }
    }
    assert_true(made > 0); /* else the contact as a whole would have told */
}

/* No model hands out anything in a slow press, whatever is allowed to one that is shaken: at most
 * what steps of 0.2 mm leave. */
TEST(a_slow_press_hands_out_nothing)
{
    const int32_t count = FULL_IN_RELEASE(ss_stress_case_subject_count(), 1);
    for (int32_t s = 0; s < count; ++s) {
        const ss_stress_case_result r = abuse(s, SS_STRESS_CASE_CONTROL, 0.0, 1);
        const double most = 0.5e-3; /* J; 1 to 80 mJ are put in */
        if (!(r.is_agreed && r.handed_out_j < most && r.driven_j < most &&
              (ss_stress_case_is_plastic(s) || r.made_j < most))) {
            fail_msg("%s: %g J handed out, %g J made; the program said: %s",
                     ss_stress_case_subject_name(s), r.handed_out_j, r.made_j, r.acted);
        }
    }
}

/* A tool that turns a hundred times a second does not whirl through the tissue: it turns as fast as
 * a hand could, the shorter way. */
TEST(a_tool_turns_no_faster_than_a_hand)
{
    static ss_stress_case_plan plan; /* large */
    const ss_stress_case trial = {0, SS_STRESS_CASE_SPIN, 1e5, 100.0, 0};
    ss_stress_case_plan_make(&trial, &plan);
    ss_world *world = make_planned(&plan);
    double turned = 0.0;
    for (int32_t k = 1; k <= 400; ++k) {
        double before[4], turn[3];
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_pose pose = at_depth(0.0, -1);
        const int32_t channel = 0;
        pose.sender = 1;
        pose.seq = k;
        ss_set3(pose.velocity, NAN, NAN, NAN);
        ss_stress_case_plan_tool(&plan, 1e-3 * k, k, pose.position, pose.orientation);
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
    return run_all_tests(make_folder, remove_folder);
}
