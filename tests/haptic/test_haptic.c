/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The parts of the haptic tick against analytic answers; the balance and the force limit are
 * test_haptic_limit.c, watchdog, ramps and the hash test_haptic_ramps.c, the closed loop
 * test_haptic_loop.c. */
#include "common/test.h"

#include "haptic_fixture.h"

/* ---- stiffness ---- */

TEST(largest_eigenvalue_bounds_every_direction)
{
    random_state = 2;
    for (int n = 0; n < 1000; ++n) {
        double m[3][3] = {{0}};
        for (int i = 0; i < 4; ++i) {
            double v[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) {
                    m[r][c] += 1000.0 * v[r] * v[c];
                }
            }
        }
        /* Power iteration. */
        double v[3] = {0.6, 0.5, 0.4};
        double size = 0.0;
        for (int i = 0; i < 3000; ++i) {
            const double w[3] = {ss_dot3(m[0], v), ss_dot3(m[1], v), ss_dot3(m[2], v)};
            size = ss_norm3(w);
            ss_scale3(v, w, 1.0 / size);
        }
        assert_near(ss_max_eigenvalue3(m), size, 1e-6 * size);
    }
    double diagonal[3][3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
    assert_near(ss_max_eigenvalue3(diagonal), 2.0, 1e-15);
}

/* ---- law ---- */

TEST(felt_stiffness_is_the_softer_of_tissue_and_limit)
{
    assert_near(ss_coupling_spring(800.0, 300.0), 20000.0, 1e-9);
    const double spring = ss_coupling_spring(800.0, 3000.0);
    assert_near(spring * 3000.0 / (spring + 3000.0), 800.0, 1e-9);
    assert_near(ss_coupling_spring(800.0, 0.0), 800.0, 1e-9);
}

TEST(touch_and_leaving_are_continuous)
{
    rig r;
    rig_begin(&r);
    rig_tick(&r, 1e-3);
    rig_result(&r, 1000.0, -1e-3, 1);
    rig_tick(&r, 1e-3);
    double last = 0.0;
    for (int i = 1; i <= 4000; ++i) {
        const double z = 1e-3 * cos(2.0 * SS_PI * i / 2000.0);
        rig_result(&r, 1000.0, -r.out.target.proxy[2], 1);
        r.is_new = i == 1;
        const double f = rig_tick(&r, z);
        /* One micrometre changes the force by k dx, no more. */
        assert_true(fabs(f - last) <= 1150.0 * 3.2e-6);
        assert_true(f >= 0.0 && (f > 0.0) == ((r.out.force.flags & SOFTSIM_FORCE_CONTACT) != 0));
        last = f;
    }
    rig_end(&r);
}

/* Between results the local contact model is stiffer than the tissue by 15 %, and exact when
 * results are slow. */
TEST(law_errs_high)
{
    for (int is_slow = 0; is_slow < 2; ++is_slow) {
        rig r;
        const double before = rig_begin_pressed(&r, 300.0, 2e-3);
        if (is_slow) {
            rig_result(&r, 300.0, 2e-3, 1);
            r.result.period = 0.08;
            for (int i = 0; i < 200; ++i) {
                rig_tick(&r, -2e-3);
            }
        }
        const double rest = rig_tick(&r, -2e-3);
        assert_near(rest, before, 3e-3);
        const double f = rig_tick(&r, -3e-3);
        const double k = is_slow ? 300.0 : 1.15 * 300.0;
        const double spring = ss_coupling_spring(r.out.stiffness_limit, 345.0);
        assert_near(f - rest, 1e-3 * k * spring / (k + spring), 2e-3 * 1e-3 * k);
        /* Over more than one result the tissue's own is felt, and told. */
        assert_near(r.out.force.stiffness, 300.0 * spring / (300.0 + spring), 1.0);
        rig_end(&r);
    }
}

/* A result that disagrees by 0.5 N is not felt as a step: it comes in with tau = 3 h, the hand
 * being at rest. */
TEST(updates_are_continuous_and_decay)
{
    rig r;
    const double before = rig_begin_pressed(&r, 300.0, 4e-3);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.period = 0.016;
    r.result.set.contact[0].force += 0.5;
    double f = rig_tick(&r, -4e-3);
    assert_near(f, before, 1e-9);
    const double spring = ss_coupling_spring(r.out.stiffness_limit, 1.15 * 300.0);
    const double share = spring / (spring + 1.15 * 300.0);
    for (int i = 1; i <= 400; ++i) {
        f = rig_tick(&r, -4e-3);
        assert_near(f - before, share * 0.5 * (1.0 - exp(-i * T / 0.048)), 5e-3);
    }
    assert_near(f - before, share * 0.5, 1e-3);
    /* A normal that turns, and a contact that vanishes, do not jump either. */
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.contact[0].force += 0.5;
    ss_set3(r.result.set.contact[0].normal, sin(0.2), 0.0, cos(0.2));
    const double last[3] = {r.out.force.force[0], r.out.force.force[1], r.out.force.force[2]};
    rig_tick(&r, -4e-3);
    double change[3];
    ss_sub3(change, r.out.force.force, last);
    assert_true(ss_norm3(change) < 0.02);
    for (int i = 0; i < 60; ++i) {
        rig_tick(&r, -4e-3);
    }
    assert_near(r.out.force.force[0], tan(0.2) * r.out.force.force[2], 1e-6);
    ss_copy3(change, r.out.force.force);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.count = 0;
    rig_tick(&r, -4e-3);
    ss_sub3(change, change, r.out.force.force);
    assert_true(ss_norm3(change) < 0.02);
    for (int i = 0; i < 60; ++i) {
        rig_tick(&r, -4e-3);
    }
    assert_true(ss_norm3(r.out.force.force) < 1e-6);
    rig_end(&r);
}

/* A touch at `depth` that the tissue also pushes aside and turns; a result a tick. Returns the
 * largest step of the force. */
static double push_aside(rig *r, double depth, int ticks)
{
    double most = 0.0;
    for (int i = 0; i < ticks; ++i) {
        rig_result(r, 300.0, depth, 1);
        ss_contact_set *set = &r->result.set;
        if (depth > 0.0) {
            set->other_force[0] = 0.6;
            set->other_torque[1] = 0.02;
            ss_add3(set->force, set->force, set->other_force);
        }
        const double before[3] = {r->out.force.force[0], r->out.force.force[1],
                                  r->out.force.force[2]};
        (void)rig_tick(r, -depth);
        double change[3];
        ss_sub3(change, r->out.force.force, before);
        most = fmax(most, ss_norm3(change));
        assert_true(r->out.force.force[2] >= 0.0);
    }
    return most;
}

/* It comes without a step, carries the proxy with it, ends with the contact, and has its share of
 * the limit. */
TEST(what_pushes_beside_the_contacts_is_felt)
{
    ss_haptic_config config = default_config();
    config.tool_gyration = 0.005;
    rig r;
    rig_start(&r, &config);
    const double pressed = rig_press(&r, 300.0, 4e-3);
    assert_true(push_aside(&r, 4e-3, 100) <= 0.6 * (1.0 - exp(-0.25)) + 1e-9);
    const double spring = pressed / (r.out.target.proxy[2] + 4e-3);
    const double share = pressed / (300.0 * 4e-3); /* the proxy is a little less deep */
    assert_true(share > 0.9);
    assert_near(r.out.force.force[0], 0.6 * share, 1e-6);
    assert_near(r.out.force.force[2], pressed, 1e-6);
    assert_near(r.out.force.torque[1], 0.02 * share, 1e-6);
    assert_near(r.out.target.proxy[0], 0.6 * share / spring, 1e-7);
    config.max_force = 0.5;
    ss_haptic_configure(r.haptic, &config);
    (void)push_aside(&r, 4e-3, 400);
    assert_near(ss_norm3(r.out.force.force), 0.5, 1e-6);
    assert_near(r.out.force.force[0], 0.5 * 0.6 / hypot(0.6, 300.0 * 4e-3), 0.01);
    config.max_force = 8.0;
    ss_haptic_configure(r.haptic, &config);
    (void)push_aside(&r, 4e-3, 400);
    assert_near(r.out.force.force[0], 0.6 * share, 1e-6);
    (void)push_aside(&r, -1e-3, 60);
    assert_near(ss_norm3(r.out.force.force), 0.0, 0.0);
    rig_end(&r);
}

/* A tool that lies on tissue with force and torque as they are, told as one contact, as two, as two
 * that lie and share otherwise. */
static void lie(rig *r, double k, double depth, int as)
{
    static const struct {
        int count;
        double arm[2], share[2];
    } row[] = {
        {2, {0.012, -0.008}, {0.6, 0.4}}, {1, {0.004}, {1.0}}, {2, {0.010, 0.0}, {0.4, 0.6}}};
    rig_result(r, k, depth, 1);
    ss_contact_set *set = &r->result.set;
    const ss_contact whole = set->contact[0];
    set->count = row[as].count;
    set->torque[1] = -0.004 * whole.force;
    for (int i = 0; i < row[as].count; ++i) {
        set->contact[i] = whole;
        set->contact[i].point[0] = row[as].arm[i];
        set->contact[i].force *= row[as].share[i];
        set->contact[i].stiffness *= row[as].share[i];
        set->contact[i].station = i;
    }
    (void)rig_tick(r, -depth);
}

/* In contact, with a tool that has a torque. */
static void rig_press_turning(rig *r, double k, double depth)
{
    ss_haptic_config config = default_config();
    config.tool_gyration = 0.005;
    rig_start(r, &config);
    rig_press(r, k, depth);
}

TEST(a_torque_does_not_jump_as_contacts_come_and_go)
{
    const double k = 300.0, depth = 4e-3;
    rig r;
    rig_press_turning(&r, k, depth);
    for (int n = 0; n < 200; ++n) {
        lie(&r, k, depth, 0);
    }
    const double torque = r.out.force.torque[1];
    assert_near(torque, -0.004 * r.out.force.force[2], 1e-9);
    for (int n = 0; n < 300; ++n) {
        lie(&r, k, depth, n / 7 % 3);
        assert_near(r.out.force.torque[1], torque, 0.01 * fabs(torque));
    }
    rig_end(&r);
}

/* A tool on tissue with its parts 1 and 2; of part 0, told before them, `share` of the force. */
static void lie_on_three(rig *r, double k, double depth, double share)
{
    static const double arm[3] = {0.0, 0.008, -0.012};
    const double part[3] = {share, 0.6 * (1.0 - share), 0.4 * (1.0 - share)};
    rig_result(r, k, depth, 1);
    ss_contact_set *set = &r->result.set;
    const ss_contact whole = set->contact[0];
    set->count = 0;
    for (int i = share > 0.0 ? 0 : 1; i < 3; ++i) {
        ss_contact *c = &set->contact[set->count++];
        *c = whole;
        c->point[0] = arm[i];
        c->force *= part[i];
        c->stiffness *= part[i];
        c->station = i;
        set->torque[1] -= arm[i] * c->force;
    }
    (void)rig_tick(r, -depth);
}

/* 1 % of the force a tick goes over to it. */
TEST(a_part_of_the_tool_that_begins_to_touch_takes_no_other_ones_force)
{
    const double k = 300.0, depth = 4e-3;
    ss_haptic_config config = default_config();
    config.tool_gyration = 0.005;
    rig r;
    rig_start(&r, &config);
    rig_press(&r, k, depth);
    for (int n = 0; n < 200; ++n) {
        lie_on_three(&r, k, depth, 0.0);
    }
    const double force = r.out.force.force[2];
    double torque = r.out.force.torque[1];
    assert_near(torque, 0.0, 1e-9);
    for (int n = 0; n < 60; ++n) {
        const double share = 0.01 * (n < 30 ? n : 60 - n);
        lie_on_three(&r, k, depth, share);
        assert_near(r.out.force.force[2], force, 1e-3 * force);
        assert_near(r.out.force.torque[1], torque, 1e-3 * 0.01 * force);
        torque = r.out.force.torque[1];
    }
    rig_end(&r);
}

/* Between two results a tool that turns into the tissue is felt to: each contact's stiffness at its
 * arm, of the force and of the torque. */
TEST(a_turn_is_felt_between_results)
{
    const double k = 300.0, depth = 4e-3, arm = 0.02, angle = 0.01;
    rig r;
    rig_press_turning(&r, k, depth);
    for (int n = 0; n < 200; ++n) {
        rig_result(&r, k, depth, 1);
        r.result.set.contact[0].point[0] = arm;
        r.result.set.torque[1] = -arm * r.result.set.contact[0].force;
        (void)rig_tick(&r, -depth);
    }
    const double force = r.out.force.force[2], torque = r.out.force.torque[1];
    assert_near(torque, -arm * force, 1e-9);
    r.pose.orientation[0] = cos(0.5 * angle);
    r.pose.orientation[2] = sin(0.5 * angle);
    const double proxy = r.out.target.proxy[2];
    (void)rig_tick(&r, -depth);
    /* About y the end at +x goes down: the law's stiffness, that errs high, less what the proxy
     * rises. */
    const double in = angle * arm - (r.out.target.proxy[2] - proxy);
    assert_true(in > 0.0);
    assert_near(r.out.force.force[2] - force, 1.15 * k * in, 0.02 * k * in);
    assert_near(r.out.force.torque[1], -arm * r.out.force.force[2], 1e-6);
    rig_end(&r);
}

/* Soft tissue that yields in 5 ms under a contact of 20 kN/m, which is told to the haptic loop or
 * not: the most that a reaction changes in a tick under a hand that stands still, of the force. */
static double swing_of(double told)
{
    const double contact = 2e4, tissue = 1000.0, drag = 100.0;
    ss_haptic_config config = default_config();
    config.stiffness = 500.0;
    config.damping = 2.0;
    rig r;
    rig_start(&r, &config);
    double surface = 0.0, reaction = 0.0, most = 0.0;
    for (int i = 0; i < 3000; ++i) {
        const double depth = fmin(8e-3, 2e-5 * i) - 1e-3;
        if (i > 0) {
            const double p = r.out.target.proxy[2], last = reaction;
            /* c s' = -k s - F: the step is exact for a tool that stands still. */
            const double rest = contact * p / (contact + tissue);
            const double to = surface >= p ? rest : 0.0;
            const double rate = (tissue + (surface >= p ? contact : 0.0)) / drag;
            surface = fmax(to + (surface - to) * exp(-rate * T), p);
            reaction = contact * (surface - p);
            rig_result(&r, tissue * contact / (tissue + contact), reaction > 0.0 ? 0.0 : p, 0);
            r.result.proxy[2] = p;
            r.result.set.step_stiffness = told;
            r.result.set.contact[0].gap = reaction > 0.0 ? 0.0 : fmax(0.0, p - surface);
            r.result.set.contact[0].force = r.result.set.force[2] = reaction;
            most = i > 2500 ? fmax(most, fabs(reaction - last)) : 0.0;
        }
        (void)rig_tick(&r, -depth);
    }
    const double force = r.out.force.force[2];
    rig_end(&r);
    assert_true(force > 1.0);
    return most / force;
}

TEST(a_stiff_contact_on_soft_tissue_does_not_swing)
{
    const double still = swing_of(2e4), swinging = swing_of(0.0);
    print_message("a contact of 20 kN/m on 1 kN/m: %.2g of the force a tick, %.2g untold\n", still,
                  swinging);
    assert_true(still <= 1e-3);
    assert_true(swinging > 0.1);
}

/* The tissue answers after the hand has come to rest: what is held back at the first result is let
 * in, however often results come. */
TEST(a_touch_that_is_found_at_rest_is_let_in)
{
    for (int every = 1; every <= 16; every *= 4) {
        rig r;
        rig_begin(&r);
        r.pose.velocity[0] =
            (double)NAN; /* not told, as a hand that came at that speed was at rest */
        double f = 0.0;
        for (int i = 0; i < 4; ++i) {
            rig_result(&r, 300.0, -1e-3, 1);
            r.result.set.count = 0;
            f = rig_tick(&r, i < 2 ? 1e-3 : -4e-3);
            assert_near(f, 0.0, 0.0);
        }
        for (int i = 0; i < 160; ++i) {
            if (i % every == 0) {
                rig_result(&r, 300.0, -r.out.target.proxy[2], 1);
                r.result.period = every * T;
            }
            const double before = f;
            f = rig_tick(&r, -4e-3);
            assert_true(f >= before - 1e-3 && f - before < 0.3 * 1.2);
        }
        const double spring = ss_coupling_spring(r.out.stiffness_limit, 1.15 * 300.0);
        assert_near(f, 4e-3 * 300.0 * spring / (300.0 + spring), 0.01);
        rig_end(&r);
    }
}

TEST(curved_patch_bends_height_and_normal)
{
    rig r;
    rig_begin_pressed(&r, 300.0, 2e-3);
    for (int i = 0; i < 100; ++i) {
        rig_result(&r, 300.0, 2e-3, 1);
        r.result.set.contact[0].curvature[0][0] = 20.0;
        rig_tick(&r, -2e-3);
    }
    const double flat = r.out.force.force[2];
    r.pose.position[0] = 2e-3;
    rig_tick(&r, -2e-3);
    /* 40 um higher, slope 0.04. */
    const double rise = 0.5 * 20.0 * 4e-6;
    assert_near(ss_norm3(r.out.force.force) - flat, rise * 1.15 * 300.0, 2e-3);
    assert_near(r.out.force.normal[0], -0.04 / sqrt(1.0 + 0.0016), 1e-9);
    rig_end(&r);
}

/* ---- grasp ---- */

TEST(grasp_starts_without_jump_and_holds_all_ways)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.contact[0].tangential = 200.0;
    rig_tick(&r, -4e-3);
    r.pose.buttons = SOFTSIM_BUTTON_GRASP;
    assert_near(rig_tick(&r, -4e-3), f, 1e-4);
    assert_true(r.out.force.flags & SOFTSIM_FORCE_GRASPING);
    assert_true(r.out.target.is_grasping);
    assert_int_equal(r.out.target.grasp_edges, 1);
    /* The model holds too: its reaction at the grasp is the same. */
    rig_result(&r, 300.0, 4e-3, 0);
    r.result.set.contact[0].tangential = 200.0;
    r.result.set.is_held = true;
    assert_near(rig_tick(&r, -4e-3), f, 1e-3);
    for (int i = 0; i < 30; ++i) {
        rig_tick(&r, -4e-3);
    }
    /* Sideways it pulls back by k_t, and outwards it pulls in. */
    r.pose.position[0] = 1e-3;
    rig_tick(&r, -4e-3);
    const double spring = ss_coupling_spring(r.out.stiffness_limit, 345.0);
    assert_near(r.out.force.force[0], -1e-3 * 200.0 * spring / (200.0 + spring), 1e-2);
    rig_tick(&r, 2e-3);
    assert_true(r.out.force.force[2] < -0.3);
    /* The button ends it when the model holds no more: then the pull fades in 10 ms. */
    const double pull = r.out.force.force[2];
    r.pose.buttons = 0;
    for (int i = 0; i < 20; ++i) {
        assert_near(rig_tick(&r, 2e-3), pull, 0.05);
        assert_true(r.out.force.flags & SOFTSIM_FORCE_GRASPING);
        assert_false(r.out.target.is_grasping);
    }
    rig_result(&r, 300.0, -2e-3, 0);
    assert_near(rig_tick(&r, 2e-3), pull, 0.05);
    assert_false(r.out.force.flags & SOFTSIM_FORCE_GRASPING);
    for (int i = 1; i <= 10; ++i) {
        rig_tick(&r, 2e-3);
    }
    assert_near(r.out.force.force[2], pull * exp(-1.0), 0.05);
    rig_end(&r);
}

TEST(grasp_ends_when_the_model_does_not_hold)
{
    rig r;
    rig_begin_pressed(&r, 300.0, 4e-3);
    r.pose.buttons = SOFTSIM_BUTTON_GRASP;
    rig_tick(&r, -4e-3);
    assert_true(r.out.force.flags & SOFTSIM_FORCE_GRASPING);
    rig_result(&r, 300.0, 4e-3, 0);
    rig_tick(&r, -4e-3);
    assert_false(r.out.force.flags & SOFTSIM_FORCE_GRASPING);
    rig_end(&r);
}

/* ---- guards ---- */

TEST(non_finite_input_repeats_the_force)
{
    rig r;
    const double f = rig_begin_pressed(&r, 300.0, 4e-3);
    const int32_t seq = r.out.force.seq;
    r.pose.position[0] = NAN;
    assert_near(rig_tick(&r, -3e-3), f, 0.0);
    assert_int_equal(r.out.force.seq, seq + 1);
    assert_int_equal(r.out.bad_inputs, 1);
    r.pose.position[0] = 0.0;
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.contact[0].stiffness = INFINITY;
    assert_near(rig_tick(&r, -3e-3), f, 0.0);
    assert_int_equal(r.out.bad_inputs, 2);
    /* Finite nonsense is refused; the local contact model stays. */
    rig_tick(&r, -4e-3);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.contact[0].normal[2] = 2.0;
    assert_near(rig_tick(&r, -4e-3), f, 1e-6);
    assert_int_equal(r.out.bad_inputs, 3);
    rig_result(&r, 300.0, 4e-3, 1);
    r.result.set.count = 9;
    assert_near(rig_tick(&r, -4e-3), f, 1e-6);
    assert_int_equal(r.out.bad_inputs, 4);
    /* For ever bad is a device gone. */
    r.pose.orientation[2] = INFINITY;
    for (int i = 0; i < 120; ++i) {
        rig_tick(&r, -4e-3);
        assert_true(ss_is_finite(r.out.force.force, 3));
    }
    assert_near(r.out.force.force[2], 0.0, 0.0);
    assert_true(r.out.force.flags & SOFTSIM_FORCE_STALE);
    rig_end(&r);
}

TEST(absurd_numbers_stay_finite)
{
    random_state = 3;
    const ss_haptic_config config = default_config();
    rig r;
    rig_start(&r, &config);
    for (int i = 0; i < 20000; ++i) {
        rig_result(&r, pow(10.0, uniform(-300, 300)), uniform(-1, 1), 1);
        ss_contact *c = &r.result.set.contact[0];
        c->force = pow(10.0, uniform(-300, 300));
        c->viscosity = uniform(-1e9, 1e9);
        r.result.set.other_force[0] = pow(10.0, uniform(-300, 300));
        r.result.set.step_stiffness = pow(10.0, uniform(-300, 300));
        c->curvature[0][1] = pow(10.0, uniform(-300, 300));
        r.result.period = pow(10.0, uniform(-9, 3));
        r.result.set.is_held = i % 7 == 0;
        r.pose.buttons = i % 5 == 0;
        r.pose.position[0] = i % 100 == 0 ? pow(10.0, uniform(-300, 300)) : 0.0;
        rig_tick(&r, uniform(-0.1, 0.1));
        assert_true(ss_is_finite(r.out.force.force, 3));
        assert_true(ss_norm3(r.out.force.force) <= config.max_force * (1.0 + 1e-12));
    }
    rig_end(&r);
}

/* The force on a tool that goes in at .3 m/s, each tick; of every five poses one comes `late` ticks
 * after it was taken, one half of that; by a clock that tells steps of `step_us`. */
static void press_late(int64_t late, int64_t step_us, double out_force[100])
{
    static const int64_t share[5] = {2, 1, 0, 0, 0};
    ss_haptic_config config = default_config();
    config.is_lockstep = false;
    rig r;
    rig_start(&r, &config);
    int64_t taken = 0;
    for (int64_t n = 1; n <= 300; ++n) {
        softsim_pose come[8];
        int32_t count = 0;
        for (int64_t k = taken + 1; k <= n; ++k) {
            if (k + (late * share[k % 5] + 1) / 2 <= n) { /* the newest wins, as at the gate */
                r.pose.seq = (int32_t)k;
                r.pose.utime_us = 1000 * k / step_us * step_us;
                ss_set3(r.pose.velocity, NAN, NAN, NAN);
                r.pose.position[2] = 1e-3 - 0.3e-3 * (double)(k > 150 ? k - 150 : 0);
                come[count++] = r.pose;
                taken = k;
            }
        }
        if (n > 1) {
            rig_result(&r, 100.0, fmax(0.0, -r.pose.position[2]), 1);
        }
        r.tick = n;
        const ss_haptic_input input = {.tick = n,
                                       .pose = come,
                                       .pose_count = count,
                                       .sender_epoch = 1,
                                       .result = r.has_result ? &r.result : NULL,
                                       .is_result_new = r.has_result};
        ss_haptic_tick(r.haptic, &input, &r.out);
        if (n > 200) {
            out_force[n - 201] = r.out.force.force[2];
        }
    }
    rig_end(&r);
}

/* A bus that brings a pose a tick or two late, or two at once, is not felt. */
TEST(a_pose_that_comes_late_is_of_its_time)
{
    double steady[100], late[100], most = 0.0;
    press_late(0, 1, steady);
    press_late(2, 1, late);
    for (int n = 0; n < 100; ++n) {
        most = fmax(most, fabs(late[n] - steady[n]));
    }
    print_message("%.3g N of %.3g\n", most, steady[99]);
    assert_true(steady[99] > 1.0 && most < 0.01);
}

/* The clock of a device may tell steps of a few ms: its poses are not late. */
TEST(a_coarse_clock_makes_no_pose_late)
{
    double steady[100], coarse[100], most = 0.0;
    press_late(0, 1, steady);
    for (int64_t step_us = 2000; step_us <= 16000; step_us *= 2) {
        press_late(0, step_us, coarse);
        for (int n = 0; n < 100; ++n) {
            most = fmax(most, fabs(coarse[n] - steady[n]));
        }
    }
    print_message("%.3g N of %.3g\n", most, steady[99]);
    assert_true(most < 0.01);
}

TEST(nothing_is_sent_before_the_first_pose)
{
    rig r;
    rig_begin(&r);
    r.has_pose = false;
    rig_tick(&r, 0.0);
    assert_false(r.out.has_force);
    assert_false(r.out.target.is_present);
    r.has_pose = true;
    rig_tick(&r, -1e-3);
    assert_true(r.out.has_force);
    assert_int_equal(r.out.force.seq, 1);
    assert_near(ss_norm3(r.out.force.force), 0.0, 0.0);
    for (int i = 2; i < 10; ++i) {
        rig_tick(&r, -1e-3 * i);
        assert_int_equal(r.out.force.seq, i);
        assert_near(r.out.force.proxy[2], -1e-3 * i, 1e-6);
    }
    rig_end(&r);
}

TEST(prediction_is_bounded)
{
    ss_proxy_target target = {.proxy = {1, 2, 3}, .velocity = {0.1, 0, 0}};
    double p[3];
    ss_haptic_predict(&target, 1.0, 1e-3, p);
    assert_near(p[0], 1.0 + 0.1 * 1.5e-3, 1e-15);
    ss_haptic_predict(&target, 1.0, 1.0 / 30.0, p);
    assert_near(p[0], 1.0 + 0.1 * 0.025, 1e-15);
    target.velocity[0] = 1.0;
    ss_haptic_predict(&target, 1.0, 1.0 / 30.0, p);
    assert_near(p[0], 1.003, 1e-15);
}

/* A hand that pokes at 4.5 Hz, 3.5 mm either way of the middle, stops and turns: predicted by its
 * velocity alone, the tool of a 60 Hz simulation goes sqrt(1 + (w t)^2) - 1 of that further than
 * the hand ever does, t = 25 ms. */
TEST(tool_turns_with_the_hand)
{
    const double size = 3.5e-3, w = 2.0 * SS_PI * 4.5, ahead = 0.025;
    const double straight = size * (sqrt(1.0 + w * ahead * w * ahead) - 1.0);
    const ss_haptic_config config = default_config();
    rig r;
    double furthest = 0.0;
    rig_start(&r, &config);
    r.pose.velocity[0] = (double)NAN;
    for (int i = 0; i < 1000; ++i) {
        double p[3];
        rig_tick(&r, size * sin(w * i * T));
        ss_haptic_predict(&r.out.target, 1.0, 1.0 / 60.0, p);
        furthest = fmax(furthest, i < 300 ? 0.0 : fabs(p[2]));
    }
    assert_true(straight > 0.75e-3);
    assert_true(furthest > size); /* the way back is not taken before it is begun */
    assert_true(furthest - size < 2.0 / 3.0 * straight);
    rig_end(&r);
}

/* And so does its turn: a tool that turns at w is by w (lag + 1/2) h further when the step ends. */
TEST(a_turn_goes_on_through_a_step)
{
    const double w = 2.0, axis[3] = {0.0, 0.6, 0.8};
    double ahead[4], turn[3];
    ss_haptic_config config = default_config();
    config.tool_gyration = 0.005;
    rig r;
    rig_start(&r, &config);
    for (int i = 0; i <= 200; ++i) {
        const double angle = w * i * T;
        r.pose.orientation[0] = cos(0.5 * angle);
        ss_scale3(r.pose.orientation + 1, axis, sin(0.5 * angle));
        rig_tick(&r, 1e-2);
    }
    ss_haptic_predict_turn(&r.out.target, 1.0, 0.01, ahead);
    ss_turn_between(r.pose.orientation, ahead, turn);
    for (int a = 0; a < 3; ++a) {
        assert_near(turn[a], w * 0.015 * axis[a], 1e-9);
    }
    ss_haptic_predict_turn(&r.out.target, 1.0, 0.0, ahead);
    assert_memory_equal(ahead, r.pose.orientation, sizeof ahead);
    rig_end(&r);
}

/* A coupling that is softer than the tissue lets the proxy go a part of the hand's way, and that
 * much of it is predicted: 1 m/s of the hand's is 200 / (200 + 1.15 1000) of it. */
TEST(a_proxy_that_the_tissue_holds_back_is_predicted_so)
{
    const double k = 1000.0, step = 1e-5;
    ss_haptic_config config = default_config();
    config.stiffness = 1.15 * k * 200.0 / (200.0 + 1.15 * k); /* in series: a spring of 200 N/m */
    rig r;
    rig_start(&r, &config);
    rig_press(&r, k, 2e-3);
    r.pose.velocity[2] = -1e3 * step;
    for (int i = 1; i <= 20; ++i) {
        rig_result(&r, k, -r.out.target.proxy[2], 1);
        rig_tick(&r, -2e-3 - i * step);
    }
    assert_near(r.out.target.velocity[2], r.pose.velocity[2] * 200.0 / (200.0 + 1.15 * k),
                0.02 * fabs(r.pose.velocity[2]));
    rig_end(&r);
}

/* A hand comes at 2 m/s to tissue of which one result told, 12 mm away: the tool of a 60 Hz
 * simulation goes to where that answers with the limit and no further, whenever the step begins. */
TEST(no_tool_is_predicted_beyond_the_limit)
{
    const double k = 1000.0, limit = 1.0, way = 2e-3;
    ss_haptic_config config = default_config();
    config.max_force = limit;
    rig r;
    double deepest = 0.0;
    rig_start(&r, &config);
    rig_tick(&r, 6.0 * way);
    rig_result(&r, k, -6.0 * way, 1);
    r.pose.velocity[2] = -way / T;
    for (int i = 5; i >= -8; --i) {
        double p[3];
        rig_tick(&r, i * way);
        ss_haptic_predict(&r.out.target, 1.0, 1.0 / 60.0, p);
        deepest = fmax(deepest, -p[2]);
    }
    assert_near(ss_norm3(r.out.force.force), limit, 1e-6);
    assert_true(deepest <= limit / k);
    assert_true(deepest >= 0.75 * limit / k); /* what is near errs high */
    rig_end(&r);
}

/* The coupling follows the tissue, not how old its results are: a press is held with one force. */
TEST(slow_results_leave_the_coupling_as_it_is)
{
    ss_haptic_config config = default_config();
    config.stiffness = 300.0;
    double proxy[2];
    for (int slow = 0; slow < 2; ++slow) {
        rig r;
        rig_start(&r, &config);
        rig_press(&r, 1000.0, 2e-3);
        for (int i = 0; i < 2000; ++i) {
            if (i % 40 == 0) {
                rig_result(&r, 1000.0, -r.out.target.proxy[2], slow ? 40 : 1);
                r.result.period = slow ? 0.040 : T;
            }
            rig_tick(&r, -2e-3);
        }
        proxy[slow] = r.out.target.proxy[2];
        rig_end(&r);
    }
    assert_near(proxy[1], proxy[0], 1e-3 * fabs(proxy[0]));
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
