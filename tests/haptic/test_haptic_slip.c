/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What a grasp leaves between hand and proxy, at any rate of the haptic loop. */
#include "common/test.h"

#include "haptic_fixture.h"

/* A model lets go in a while: as long as it holds, the proxy goes with the hand and no further,
 * and the hand feels what the model says; then the proxy comes over the hand, and what was felt
 * fades into what the tissue exerts. So it is where the model lets go by itself, the button down.
 */
TEST(the_proxy_stays_until_the_model_holds_no_more)
{
    static const int holds[] = {1, 5, 20, 100};
    static const double k = 300.0, depth = 4e-3, pull[3] = {-2.0, 0.0, 0.5};
    enum { HOLDS = sizeof holds / sizeof *holds };
    for (int i = 0; i < 2 * HOLDS; ++i) {
        const bool is_torn = i >= HOLDS;
        const int hold = holds[i % HOLDS];
        enum { GRASPED = 400, AFTER = 800 };
        ss_haptic_config config = default_config();
        config.damping = 2.0;
        config.stiffness = 800.0;
        rig r;
        rig_start(&r, &config);
        (void)rig_press(&r, k, depth);
        double still[3], held = 0.0;
        for (int n = 0; n < GRASPED + hold + AFTER; ++n) {
            const int since = n - GRASPED;
            const bool is_held = since < hold;
            rig_result(&r, k, -r.out.target.proxy[2], 1);
            ss_copy3(r.result.proxy, r.out.target.proxy);
            if (is_held) {
                r.result.set.is_held = true;
                r.result.set.is_torn = is_torn && since >= 0;
                const double left = since < 0 ? 1.0 : 1.0 - (double)since / hold;
                ss_scale3(r.result.set.force, pull, left);
            }
            r.pose.buttons = since < 0 || is_torn ? SOFTSIM_BUTTON_GRASP : 0;
            rig_tick(&r, -depth);
            const double size = ss_norm3(r.out.force.force);
            if (since < 0) {
                ss_copy3(still, r.out.target.proxy);
                held = size;
                continue;
            }
            assert_true(size <= held * 1.0001);
            assert_int_equal((r.out.force.flags & SOFTSIM_FORCE_GRASPING) != 0, is_held);
            for (int a = 0; is_held && a < 3; ++a) {
                assert_near(r.out.target.proxy[a], still[a], 1e-9);
            }
        }
        assert_near(held, ss_norm3(pull), 0.01);
        assert_near(r.out.target.proxy[0], 0.0, 1e-4);
        assert_near(r.out.force.force[0], 0.0, 1e-2);
        assert_near(r.out.force.force[2], k * depth, 0.03);
        rig_end(&r);
    }
}

/* A grasp that begins at the limit has the hand's point where the force keeps its direction; below
 * the limit, or without a force, it stays where it is. */
TEST(a_grasp_begins_along_the_force)
{
    const double stretch[3] = {0.003, 0.001, 0.004}, force[3] = {0.0, 0.0, 0.5}, none[3] = {0};
    ss_slip slip = {.limit = 0.5, .stiffness_fraction = 0.2, .aside = {0.01, 0.02, 0.03}};
    ss_slip_hold(&slip, stretch, none);
    assert_near(slip.aside[2], 0.03, 0.0);
    ss_slip_hold(&slip, stretch, force);
    assert_near(slip.aside[0], 0.003, 1e-15);
    assert_near(slip.aside[1], 0.001, 1e-15);
    assert_near(slip.aside[2], 0.0, 1e-15);
    slip.stiffness_fraction = 1.0;
    ss_slip_hold(&slip, force, stretch);
    assert_near(slip.aside[0], 0.003, 1e-15);
}

/* What is felt after a lowered limit keeps its size and turns by less than a degree a tick, the
 * short way, into the opposite too; it catches up without a jump, and is left alone from then on.
 * A force that ended has no direction to keep. */
TEST(a_lowered_limit_turns_the_force_at_its_size)
{
    static const double degree = 0.017453292519943295;
    static const double aims[][3] = {{0, 0, -0.5}, {0.5, 0, 0}, {-0.3, 0.0, 0.4}, {0, -0.01, 0.5}};
    ss_haptic_config config = default_config();
    config.max_force = 0.5;
    for (size_t k = 0; k < sizeof aims / sizeof *aims; ++k) {
        ss_slip slip = {.limit = 3.0, .stiffness_fraction = 1.0};
        double last[3] = {0.0, 0.0, 0.5}, apart = INFINITY;
        assert_true(ss_slip_follow(&slip, &config, 2.0, 3.0, 0.0));
        const double size = ss_norm3(aims[k]);
        int held_back = 0;
        for (int n = 0; n < 400; ++n) {
            double force[3], turn[3];
            ss_copy3(force, aims[k]);
            held_back += ss_slip_turn(&slip, last, 0.0, T, force);
            assert_near(ss_norm3(force), size, 1e-12);
            ss_cross3(turn, last, force);
            assert_true(atan2(ss_norm3(turn), ss_dot3(last, force)) <= degree);
            ss_sub3(turn, aims[k], force);
            assert_true(ss_norm3(turn) <= apart);
            apart = ss_norm3(turn);
            ss_copy3(last, force);
        }
        const double way = acos(fmax(-1.0, aims[k][2] / size)) / degree;
        assert_true(held_back >= floor(way) && held_back <= way / 0.7);
        assert_near(apart, 0.0, 1e-12);
        double other[3] = {0.1, 0.2, 0.3};
        assert_false(ss_slip_turn(&slip, last, 0.0, T, other));
        assert_near(other[0], 0.1, 0.0);
        slip.limit = 3.0;
        assert_true(ss_slip_follow(&slip, &config, 2.0, 3.0, 0.0));
        double none[3] = {0.0, 0.0, 0.0};
        assert_false(ss_slip_turn(&slip, last, 0.0, T, none));
        assert_false(ss_slip_turn(&slip, last, 0.0, T, other));
    }
}

/* The hand's way adds a radian in two millimetres; so far at once, nothing is held back. */
TEST(what_a_limit_turns_is_gone_within_millimetres_of_way)
{
    ss_haptic_config config = default_config();
    config.max_force = 0.5;
    ss_slip slip = {.limit = 3.0, .stiffness_fraction = 1.0};
    const double last[3] = {0.0, 0.0, 0.5};
    double slow[3] = {0.5, 0.0, 0.0}, fast[3] = {0.5, 0.0, 0.0};
    assert_true(ss_slip_follow(&slip, &config, 2.0, 3.0, 0.0));
    assert_true(ss_slip_turn(&slip, last, 0.001, T, slow));
    assert_near(atan2(slow[0], slow[2]), 0.5 + 13.0 * T, 1e-12);
    assert_false(ss_slip_turn(&slip, last, 0.007, T, fast));
    assert_near(fast[0], 0.5, 0.0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
