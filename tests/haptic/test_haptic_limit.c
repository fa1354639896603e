/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The balance of the proxy and the force limit, against oracles and on hand-made tissue of one to
 * eight contacts; on bodies of every model test_headless_limit.c. */
#include "common/test.h"

#include "common/effort.h"
#include "haptic_fixture.h"
#include "oracles/limit_judge.h"

/* ---- balance ---- */

static void random_balance(ss_balance *b)
{
    memset(b, 0, sizeof *b);
    b->limit = INFINITY;
    b->spring = exp(uniform(log(50.0), log(22000.0)));
    b->count = 1 + (int32_t)uniform(0.0, 7.999);
    for (int i = 0; i < 3; ++i) {
        b->p_free[i] = uniform(-0.05, 0.05);
    }
    for (int32_t i = 0; i < b->count; ++i) {
        ss_balance_row *row = &b->row[i];
        do {
            row->normal[0] = uniform(-1, 1);
            row->normal[1] = uniform(-1, 1);
            row->normal[2] = uniform(-0.3, 1);
        } while (ss_norm3(row->normal) < 0.1);
        ss_normalize3(row->normal);
        row->slope = exp(uniform(0.0, log(1e5)));
        row->free_force = uniform(-2.0, 5.0);
    }
}

/* Every subset of contacts: the one whose solution has exactly its own forces positive. */
static bool brute_force(const ss_balance *b, double out_d[3])
{
    for (uint32_t set = 0; set < 1U << b->count; ++set) {
        double a[3][3] = {{b->spring, 0, 0}, {0, b->spring, 0}, {0, 0, b->spring}};
        double rhs[3] = {0};
        for (int32_t i = 0; i < b->count; ++i) {
            const ss_balance_row *row = &b->row[i];
            for (int r = 0; set & (1U << i) && r < 3; ++r) {
                rhs[r] += row->free_force * row->normal[r];
                for (int c = 0; c < 3; ++c) {
                    a[r][c] += row->slope * row->normal[r] * row->normal[c];
                }
            }
        }
        /* Cramer's rule */
        double u[3], v[3], w[3];
        ss_cross3(u, a[1], a[2]);
        ss_cross3(v, a[2], a[0]);
        ss_cross3(w, a[0], a[1]);
        const double det = ss_dot3(a[0], u);
        for (int r = 0; r < 3; ++r) {
            out_d[r] = (rhs[0] * u[r] + rhs[1] * v[r] + rhs[2] * w[r]) / det;
        }
        bool is_consistent = true;
        for (int32_t i = 0; i < b->count; ++i) {
            const double f =
                b->row[i].free_force - b->row[i].slope * ss_dot3(b->row[i].normal, out_d);
            is_consistent = is_consistent && (f > 0.0) == ((set & (1U << i)) != 0);
        }
        if (is_consistent) {
            return true;
        }
    }
    return false;
}

TEST(balance_matches_brute_force)
{
    random_state = 1;
    int most_passes = 0;
    double worst = 0.0;
    for (int n = 0; n < 100000; ++n) {
        ss_balance b;
        double d[3];
        ss_rest rest;
        random_balance(&b);
        const int passes = ss_coupling_balance(&b, &rest);
        most_passes = passes > most_passes ? passes : most_passes;
        double left[3];
        ss_sub3(d, rest.p, b.p_free);
        ss_scale3(left, d, b.spring);
        double largest = 1.0;
        for (int32_t i = 0; i < b.count; ++i) {
            assert_true(rest.force[i] >= 0.0);
            largest = fmax(largest, rest.force[i]);
            ss_madd3(left, left, -rest.force[i], b.row[i].normal);
        }
        worst = fmax(worst, ss_norm3(left) / largest);
        if (n % 10 == 0) {
            double expected[3];
            assert_true(brute_force(&b, expected));
            for (int i = 0; i < 3; ++i) {
                assert_near(d[i], expected[i], 1e-12);
            }
        }
    }
    assert_true(most_passes > 2);
    print_message("balance: at most %d passes, residual %.1e\n", most_passes, worst);
    assert_true(most_passes <= SS_BALANCE_PASSES);
    assert_true(worst <= 1e-12);
}

/* Sums the rows and the grasp, as the local contact model exerts them at `d` from p_free. */
static void law_at(const ss_balance *b, const double d[3], double out[3])
{
    ss_set3(out, 0.0, 0.0, 0.0);
    for (int32_t i = 0; i < b->count; ++i) {
        const ss_balance_row *row = &b->row[i];
        const double f = row->free_force - row->slope * ss_dot3(row->normal, d);
        ss_madd3(out, out, fmax(0.0, f), row->normal);
    }
    for (int r = 0; b->is_held && r < 3; ++r) {
        out[r] += b->grasp_force[r] - ss_dot3(b->grasp_slope[r], d);
    }
}

static void random_grasp(ss_balance *b)
{
    const double k = exp(uniform(log(50.0), log(5000.0)));
    const double k_t = uniform(0.1, 1.0) * k;
    b->is_held = true;
    b->count = 0;
    for (int r = 0; r < 3; ++r) {
        b->grasp_force[r] = uniform(-5.0, 5.0);
        for (int c = 0; c < 3; ++c) {
            b->grasp_slope[r][c] = r == c ? (r == 2 ? k : k_t) : 0.0;
        }
    }
}

/* The conditions of the limited balance, with the softened spring written out: the spring answers
 * the local contact model, and the force is the limit where the stiff balance would exceed it. */
TEST(limited_balance_meets_its_conditions)
{
    random_state = 3;
    int most_passes = 0, limited = 0, too_far = 0;
    double worst = 0.0, worst_size = 0.0;
    for (int n = 0; n < 100000; ++n) {
        ss_balance b;
        ss_rest open, rest;
        double d[3], local[3], total_force[3], axis[3], spring[3];
        random_balance(&b);
        if (n % 5 == 0) {
            random_grasp(&b);
        }
        for (int r = 0; n % 3 == 0 && r < 3; ++r) {
            b.other[r] = uniform(-0.2, 0.2);
        }
        ss_coupling_balance(&b, &open);
        ss_sub3(d, open.p, b.p_free);
        law_at(&b, d, axis);
        ss_add3(total_force, axis, b.other);
        const double size = ss_norm3(total_force);
        b.limit = uniform(0.4, 8.0);
        (void)ss_normalize3(axis);
        const int passes = ss_coupling_balance(&b, &rest);
        most_passes = passes > most_passes ? passes : most_passes;
        ss_sub3(d, rest.p, b.p_free);
        law_at(&b, d, local);
        ss_add3(total_force, local, b.other);
        if (size <= b.limit) {
            assert_true(rest.stiffness_fraction == 1.0);
            continue;
        }
        ++limited;
        /* Nearly opposed planes, metres apart, are slipped out of too slowly: then it is cut. */
        const double limit_error = fabs(ss_norm3(total_force) / b.limit - 1.0);
        assert_true(rest.stiffness_fraction > 0.0 &&
                    (rest.stiffness_fraction < 1.0 || limit_error > 1e-8));
        too_far += limit_error > 1e-8;
        worst_size = fmax(worst_size, limit_error > 1e-8 ? 0.0 : limit_error);
        /* Soft along the axis; where that cannot do, all ways. */
        const double along = ss_dot3(axis, d);
        ss_scale3(spring, d, b.spring);
        ss_madd3(spring, spring, (rest.stiffness_fraction - 1.0) * b.spring * along, axis);
        double isotropic[3];
        ss_scale3(isotropic, d, rest.stiffness_fraction * b.spring);
        ss_sub3(spring, spring, local);
        ss_sub3(isotropic, isotropic, local);
        worst = fmax(worst, fmin(ss_norm3(spring), ss_norm3(isotropic)) / fmax(1.0, size));
    }
    print_message("limited: %d, at most %d passes, residual %.1e, |F|/L - 1 %.1e\n", limited,
                  most_passes, worst, worst_size);
    assert_true(limited > 10000);
    assert_true(worst <= 1e-9);
    assert_true(too_far <= 5 && most_passes <= 60);
}

/* For one contact in closed form: d = (a - L)/k', the spring's share L/(K d). */
TEST(one_contact_slips_by_closed_form)
{
    ss_balance b = {.spring = 2000.0, .count = 1, .limit = 1.0};
    ss_rest rest;
    b.row[0] = (ss_balance_row){.normal = {0.0, 0.6, 0.8}, .free_force = 9.0, .slope = 400.0};
    assert_true(ss_coupling_balance(&b, &rest) <= 5);
    assert_near(rest.force[0], 1.0, 1e-9);
    assert_near(rest.p[1], 0.6 * 8.0 / 400.0, 1e-11);
    assert_near(rest.p[2], 0.8 * 8.0 / 400.0, 1e-11);
    assert_near(rest.stiffness_fraction, 1.0 / (2000.0 * 0.02), 1e-9);
}

/* In a grasp the coupling is soft all ways, whatever the force was: it points to the proxy. */
TEST(a_grasp_at_the_limit_pulls_to_the_proxy)
{
    for (int n = 0; n < 200; ++n) {
        ss_balance b = {.spring = 2000.0, .limit = 0.2, .axis = {0.6, 0.0, 0.8}};
        ss_rest rest;
        double turn[3];
        random_grasp(&b);
        ss_coupling_balance(&b, &rest);
        if (rest.stiffness_fraction < 1.0) {
            assert_near(ss_norm3(rest.grasp), b.limit, 1e-8);
            ss_cross3(turn, rest.grasp, rest.p);
            assert_near(ss_norm3(turn), 0.0, 1e-9 * ss_norm3(rest.p));
            assert_true(ss_dot3(rest.grasp, rest.p) > 0.0);
        }
    }
}

/* What cannot be slipped out of leaves the proxy where the stiff spring holds it: F/K from the
 * hand. */
TEST(a_law_without_stiffness_keeps_the_proxy_near)
{
    ss_balance b = {.spring = 2000.0, .is_held = true, .limit = 1.0};
    ss_rest rest;
    ss_set3(b.grasp_force, 0.0, 0.0, 5.0);
    ss_coupling_balance(&b, &rest);
    assert_near(rest.p[0], 0.0, 0.0);
    assert_near(rest.p[1], 0.0, 0.0);
    assert_near(rest.p[2], 5.0 / 2000.0, 1e-15);
    assert_near(rest.stiffness_fraction, 1.0, 0.0);
    b.is_held = false;
    ss_set3(b.other, 0.0, 3.0, 0.0);
    ss_coupling_balance(&b, &rest);
    assert_near(ss_norm3(rest.p), 0.0, 0.0);
}

/* ---- a slow press into hand-made tissue ---- */

enum { PRESS = 1500, OUT = 1100 };

/* `count` planes about the axis z, tilted by 35 degrees (one: a ball of 30 mm that bends), each
 * with its share of `k`. The result answers for the proxy that the tick asked for. */
static void make_result(rig *r, int count, double k, double period)
{
    const double *p = r->out.target.proxy;
    r->result = (ss_simulation_result){.tick = r->tick,
                                       .step = r->result.step + 1,
                                       .period = period,
                                       .orientation = {1, 0, 0, 0},
                                       .proxy = {p[0], p[1], p[2]}};
    ss_contact_set *set = &r->result.set;
    set->count = count;
    set->normal[2] = 1.0;
    for (int i = 0; i < count; ++i) {
        ss_contact *c = &set->contact[i];
        c->station = i;
        const double angle = 2.0 * SS_PI * i / count, tilt = 35.0 / 180.0 * SS_PI;
        double depth;
        if (count == 1) {
            const double centre[3] = {0.0, 0.0, -0.03};
            ss_sub3(c->normal, p, centre);
            depth = 0.03 - ss_normalize3(c->normal);
            for (int a = 0; a < 3; ++a) {
                for (int b = 0; b < 3; ++b) {
                    c->curvature[a][b] =
                        ((a == b ? -1.0 : 0.0) + c->normal[a] * c->normal[b]) / 0.03;
                }
            }
        } else {
            ss_set3(c->normal, sin(tilt) * cos(angle), sin(tilt) * sin(angle), cos(tilt));
            depth = -ss_dot3(c->normal, p);
        }
        c->stiffness = k / count;
        c->tangential = 0.5 * k / count;
        c->force = fmax(0.0, c->stiffness * depth);
        c->gap = fmax(0.0, -depth);
        ss_madd3(c->point, p, -0.005, c->normal);
        c->point[0] += 0.02 * cos(angle);
        ss_madd3(set->force, set->force, c->force, c->normal);
        set->depth = 0.0;
        set->is_held = r->pose.buttons != 0;
    }
    r->has_result = true;
    r->is_new = true;
}

typedef struct press_plan {
    int count;
    double k, limit;
    int period; /* ticks from result to result */
    ss_between_steps between_steps;
    double gyration;
    bool is_grasping; /* from tick 300 on */
} press_plan;

static void press(const press_plan *plan, limit_tick out[PRESS])
{
    ss_haptic_config config = default_config();
    config.max_force = plan->limit;
    config.damping = 2.0;
    config.stiffness = 800.0;
    config.between_steps = plan->between_steps;
    config.tool_gyration = plan->gyration;
    rig r;
    rig_start(&r, &config);
    for (int n = 0; n < PRESS; ++n) {
        const double t = n * T;
        const double u = fmin(1.0, t / 0.7), w = fmin(1.0, fmax(0.0, t - 1.1) / 0.4);
        const double share = u * u * (3.0 - 2.0 * u) - w * w * (3.0 - 2.0 * w);
        const double depth = -1e-3 + 15e-3 * share;
        r.pose.position[0] = 5e-3 * fmin(1.0, fmax(0.0, t - 0.7) / 0.4);
        r.pose.buttons = plan->is_grasping && n >= 300 ? SOFTSIM_BUTTON_GRASP : 0;
        if (n > 0 && n % plan->period == 0) {
            make_result(&r, plan->count, plan->k, plan->period * T);
        }
        rig_tick(&r, -depth);
        double way[3];
        ss_sub3(way, r.out.force.proxy, r.pose.position);
        out[n] = (limit_tick){.depth = depth, .slip = ss_norm3(way)};
        ss_copy3(out[n].force, r.out.force.force);
        out[n].model = ss_norm3(r.result.set.force);
        const double size = ss_norm3(r.out.force.force);
        if (size >= (1.0 - 1e-6) * plan->limit) {
            assert_true(r.out.force.flags & SOFTSIM_FORCE_LIMITED);
            assert_near(r.out.force.stiffness, 0.0, 0.0);
        }
        if (plan->gyration > 0.0) {
            /* Arms of 20 mm at most, and forces that sum to the limit. */
            assert_true(ss_norm3(r.out.force.torque) <= 0.03 * size * 2.0);
        }
    }
    rig_end(&r);
}

TEST(a_press_stays_at_the_limit)
{
    static limit_tick tick[PRESS], open[PRESS];
    static const double limit[4] = {0.5, 1.0, 2.0, 8.0};
    static const double k[2] = {300.0, 2000.0};
    static const int period[3] = {1, 4, 16};
    limit_verdict worst = {.least = 1.0};
    const int count = FULL_IN_RELEASE(8 * 4 * 2 * 3, 8);
    for (int n = 0; n < count; ++n) {
        press_plan plan = {.count = n / 4 % 8 + 1,
                           .k = k[n / 32 % 2],
                           .period = period[n / 64],
                           .between_steps = SS_BETWEEN_LOCAL,
                           .limit = 1000.0,
                           .gyration = n / 4 % 2 == 1 ? 0.01 : 0.0};
        if (n % 4 == 0) {
            press(&plan, open);
        }
        plan.limit = limit[n % 4];
        press(&plan, tick);
        const limit_verdict v = judge_limit(tick, open, PRESS, OUT, plan.limit);
        if (v.first < 0) {
            continue;
        }
        if (!is_limit_kept(&v) || v.late > 1e-3) {
            fail_msg("%d contacts, %g N/m, %g N, a result in %d ticks: %d judged, |F| %.4f..%.6f, "
                     "turn %.3f deg, step %.4f, leave %.4f, late %.2g m",
                     plan.count, plan.k, plan.limit, plan.period, v.judged, v.least, v.most, v.turn,
                     v.step, v.leave, v.late);
        }
        worst.judged += v.judged;
        worst.least = fmin(worst.least, v.least);
        worst.most = fmax(worst.most, v.most);
        worst.turn = fmax(worst.turn, v.turn);
        worst.step = fmax(worst.step, v.step);
        worst.slip = fmax(worst.slip, v.slip);
        worst.model = fmax(worst.model, v.model);
    }
    print_message(
        "%d ticks: |F|/L %.4f..%.9f, turn %.3f deg, step %.4f, slip %.4f m, reaction %.2f\n",
        worst.judged, worst.least, worst.most, worst.turn, worst.step, worst.slip, worst.model);
    assert_true(worst.judged > FULL_IN_RELEASE(50000, 2000));
}

/* No tick of a press is above its limit; how many from `first` on are above `share` of it. */
static int ticks_at_limit(const limit_tick tick[PRESS], int first, double limit, double share)
{
    int count = 0;
    for (int n = first; n < PRESS; ++n) {
        const double size = ss_norm3(tick[n].force);
        assert_true(size <= 1.0001 * limit);
        count += size > share * limit;
    }
    return count;
}

/* A grasp at its limit is a constant pull along the way it is drawn. */
TEST(a_grasp_stays_at_the_limit)
{
    static limit_tick tick[PRESS];
    for (int count = 1; count <= 8; count += 3) {
        const press_plan plan = {.count = count,
                                 .k = 1000.0,
                                 .period = 4,
                                 .between_steps = SS_BETWEEN_LOCAL,
                                 .limit = 2.0,
                                 .is_grasping = true};
        press(&plan, tick);
        assert_true(ticks_at_limit(tick, 310, plan.limit, 0.99) > 500);
        for (int n = 310; n < PRESS; ++n) {
            assert_true(limit_step(&tick[n - 1]) < 0.15);
            assert_true(tick[n].slip < 0.03);
        }
    }
}

/* The tissue reacts with 110 N in the tick in which a grasp is let go, or in the one before, for a
 * while: what is left over of that is no more than what the hand felt, and never points into the
 * tissue that pushes out. */
TEST(a_grasp_let_go_never_reverses_the_force)
{
    enum { RELEASE = 100 };
    for (int begin = RELEASE - 1; begin <= RELEASE; ++begin) {
        for (int end = RELEASE + 1; end <= RELEASE + 4; ++end) {
            ss_haptic_config config = default_config();
            config.damping = 2.0;
            config.stiffness = 800.0;
            rig r;
            rig_start(&r, &config);
            (void)rig_press(&r, 1000.0, 4e-3);
            for (int n = 0; n < 4 * RELEASE; ++n) {
                rig_result(&r, 1000.0, -r.out.target.proxy[2], 1);
                r.result.set.is_held = n < RELEASE;
                if (n >= begin && n < end) {
                    r.result.set.contact[0].force = r.result.set.force[2] = 110.0;
                }
                r.pose.buttons = n < RELEASE ? SOFTSIM_BUTTON_GRASP : 0;
                const double f = rig_tick(&r, -4e-3);
                assert_true(f >= -1e-9 && f <= config.max_force * 1.0001);
            }
            assert_near(r.out.force.force[2], 2.9, 0.1); /* as before */
            rig_end(&r);
        }
    }
}

/* Tissue that another tool moves: from result to result its surface is another one, or two, and
 * the hand moves as it likes. A single contact pushes, whatever is left of the others. */
TEST(a_contact_never_draws_the_hand_in)
{
    random_state = 7;
    int touched = 0;
    for (int run = 0; run < 40; ++run) {
        ss_haptic_config config = default_config();
        config.damping = 2.0;
        config.stiffness = 800.0;
        config.max_slew = 1e6; /* else the force of the surface before lags behind */
        rig r;
        rig_start(&r, &config);
        const int period = 1 + (int)uniform(0.0, 7.999);
        for (int n = 0; n < 400; ++n) {
            if (n > 0 && n % period == 0) {
                rig_result(&r, exp(uniform(log(100.0), log(3000.0))), uniform(0.0, 5e-3), 1);
                ss_contact_set *set = &r.result.set;
                set->count = n < 20 ? 0 : 1 + (int)uniform(0.0, 1.999); /* from outside */
                set->contact[1] = set->contact[0];
                for (int i = 0; i < set->count; ++i) {
                    ss_contact *c = &set->contact[i];
                    ss_set3(c->normal, uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(0.1, 1.0));
                    ss_normalize3(c->normal);
                }
            }
            const double x[3] = {uniform(-2e-3, 2e-3), uniform(-2e-3, 2e-3), 0.0};
            ss_copy3(r.pose.position, x);
            (void)rig_tick(&r, uniform(-4e-3, 6e-3));
            /* What decays may be limited too, where nothing touches. */
            const bool is_at_limit = (r.out.force.flags & SOFTSIM_FORCE_LIMITED) != 0 &&
                                     ss_norm3(r.out.force.force) > 0.99 * config.max_force;
            const bool is_touching = r.out.force.stiffness > 0.0 || is_at_limit;
            if (r.result.set.count == 1 && is_touching) {
                ++touched;
                assert_true(ss_dot3(r.out.force.force, r.out.force.normal) >= -1e-9);
            }
        }
        rig_end(&r);
    }
    assert_true(touched > 1000);
}

/* With the coupling of a device that is not stiff. */
static void rig_start_soft(rig *r, double max_force)
{
    ss_haptic_config config = default_config();
    config.max_force = max_force;
    config.damping = 2.0;
    config.stiffness = 800.0;
    rig_start(r, &config);
}

/* A hand that goes on to 25 mm below the top of a ball of 30 mm whose normal trembles from result
 * to result, as that of a coarse mesh does: the ball is pressed with the limit. */
TEST(a_hand_far_beyond_the_limit_presses_with_the_limit)
{
    for (int period = 1; period <= 16; period *= 4) {
        rig r;
        rig_start_soft(&r, 1.0);
        for (int n = 0; n < 2000; ++n) {
            if (n > 0 && n % period == 0) {
                make_result(&r, 1, 1000.0, period * T);
                ss_contact *c = &r.result.set.contact[0];
                c->normal[1] += n / period % 2 == 0 ? 0.05 : -0.05;
                ss_normalize3(c->normal);
            }
            const double share = fmin(1.0, n / 600.0);
            r.pose.position[0] = 5e-3 * share;
            (void)rig_tick(&r, 1e-3 - 26e-3 * share);
            if (n > 1500) {
                assert_near(ss_norm3(r.out.force.force), 1.0, 1e-4);
                assert_near(ss_norm3(r.result.set.force), 1.0, 0.05);
            }
        }
        rig_end(&r);
    }
}

/* A ball of 25 mm and 300 N/m pressed far beyond the limit, with a result every `period`: one turns
 * its contact by 20 degrees, as where a box gets a third corner in, and says `stiffness`. Degrees a
 * tick that the force turns, at its size, and m a tick that the proxy goes. */
static void turn_contact(double stiffness, int period, double *out_turn, double *out_way)
{
    rig r;
    rig_start_soft(&r, 0.5);
    double last[3] = {0.0, 0.0, 1.0}, last_proxy[3] = {0.0, 0.0, 0.0};
    *out_turn = *out_way = 0.0;
    for (int n = 0; n < 1000; ++n) {
        if (n > 0 && n % period == 0) {
            const double depth = -r.out.target.proxy[2], tilt = n > 700 ? 0.35 : 0.0;
            rig_result(&r, n > 700 ? stiffness : 300.0, depth, period);
            ss_contact *c = &r.result.set.contact[0];
            r.result.period = period * T;
            c->force = r.result.set.force[2] = fmax(0.0, 300.0 * depth);
            ss_set3(c->normal, sin(tilt), 0.0, cos(tilt));
            for (int a = 0; a < 3; ++a) {
                for (int b = 0; b < 3; ++b) {
                    c->curvature[a][b] =
                        ((a == b ? -1.0 : 0.0) + c->normal[a] * c->normal[b]) / 0.025;
                }
            }
        }
        (void)rig_tick(&r, 1e-3 - 11e-3 * fmin(1.0, n / 400.0));
        if (n > 600) {
            double turn[3], way[3];
            ss_cross3(turn, last, r.out.force.force);
            ss_sub3(way, r.out.force.proxy, last_proxy);
            *out_turn =
                fmax(*out_turn, asin(ss_norm3(turn) / (ss_norm3(last) * 0.5)) * 57.29577951);
            *out_way = fmax(*out_way, ss_norm3(way));
            assert_near(ss_norm3(r.out.force.force), 0.5, 5e-5);
        }
        ss_copy3(last, r.out.force.force);
        ss_copy3(last_proxy, r.out.force.proxy);
    }
    rig_end(&r);
}

/* The force turns there by no more than a degree a tick. The coupling that softens as the contact
 * stiffens does so under the force, not under what the proxy has slipped: else its force-free place
 * moves by ten times that. */
TEST(at_the_limit_a_contact_that_turns_turns_the_force_slowly)
{
    static const double stiffness[] = {300.0, 900.0, 3000.0};
    for (int period = 1; period <= 10; period += 9) {
        for (size_t k = 0; k < sizeof stiffness / sizeof *stiffness; ++k) {
            double turn, way;
            turn_contact(stiffness[k], period, &turn, &way);
            print_message("%g N/m at %d Hz: turns by %.3f degrees a tick, the proxy goes %.3f mm\n",
                          stiffness[k], 1000 / period, turn, 1e3 * way);
            assert_true(turn > 0.05 && turn <= 1.0);
            /* What of 8 mm of slip lies aside fades by a hundredth a tick. */
            assert_true(way <= 0.01 * 8e-3 * sin(0.35) * 1.5);
        }
    }
}

/* A membrane that answers a move at once with 45 kN/m, and with 300 N/m in the end, as it says: a
 * hand far beyond the limit does not have it swing. */
TEST(a_membrane_at_the_limit_does_not_swing)
{
    const double limit = 8.0;
    rig r;
    rig_start_soft(&r, limit);
    const double at_once = 45000.0, in_the_end = 300.0, relaxing = 0.5;
    double yielded = 0.0, least = INFINITY, most = 0.0;
    for (int n = 0; n < 2000; ++n) {
        const double depth = -r.out.target.proxy[2];
        if (n > 0) {
            const double force = fmax(0.0, at_once * (depth - yielded));
            yielded += relaxing * (depth * (1.0 - in_the_end / at_once) - yielded);
            rig_result(&r, in_the_end, depth, 1);
            r.result.set.contact[0].force = r.result.set.force[2] = force;
            least = n > 1500 ? fmin(least, force) : least;
            most = n > 1500 ? fmax(most, force) : most;
        }
        (void)rig_tick(&r, 1e-3 - 61e-3 * fmin(1.0, n / 600.0));
    }
    print_message("membrane: %.2f to %.2f N at %g N\n", least, most, limit);
    assert_true(least > 0.95 * limit && most < 1.05 * limit);
    rig_end(&r);
}

/* One tick of a hand at `z` on tissue of 800 N/m that says it has 2000, its surface at `top`. */
static double press_stiff_law(rig *r, double top, double z)
{
    if (r->tick > 0) {
        const double depth = -r->out.target.proxy[2];
        rig_result(r, 2000.0, depth, 1);
        const double force = fmax(0.0, 800.0 * (top + depth));
        r->result.set.contact[0].force = r->result.set.force[2] = force;
        r->result.set.contact[0].gap = fmax(0.0, -top - depth);
    }
    return rig_tick(r, z);
}

/* Tissue that comes up after the tool at 2 mm/s lets the law, which is too stiff, hold back a part
 * of the reaction as long as the force is limited. A hand that comes out at 50 mm/s feels the limit
 * for as long as one without a limit feels more. */
TEST(the_force_leaves_the_limit_where_the_tissue_does)
{
    const double limit = 0.6;
    rig r[2];
    for (int k = 0; k < 2; ++k) {
        ss_haptic_config config = default_config();
        config.max_force = k == 0 ? limit : 100.0;
        config.damping = 2.0;
        config.stiffness = 400.0;
        rig_start(&r[k], &config);
        ss_set3(r[k].pose.velocity, NAN, NAN, NAN);
    }
    double least = 1.0;
    int judged = 0;
    for (int n = 0; n < 1300; ++n) {
        const double top = 2e-6 * fmax(0.0, n - 400.0);
        const double z = 1e-3 - 11e-3 * fmin(1.0, n / 400.0) + 5e-5 * fmax(0.0, n - 1000.0);
        const double limited = press_stiff_law(&r[0], top, z);
        const double open = press_stiff_law(&r[1], top, z);
        if (n > 1000 && open >= limit) {
            least = fmin(least, limited / limit);
            ++judged;
        }
    }
    print_message("%d ticks on the way out, at least %.4f of the limit\n", judged, least);
    assert_true(judged > 100 && least >= 0.99);
    rig_end(&r[0]);
    rig_end(&r[1]);
}

/* hold and linear cut the force, and their proxy stays where the tissue answers with the limit. */
TEST(hold_and_linear_keep_the_limit_and_the_proxy)
{
    static limit_tick tick[PRESS];
    for (int mode = SS_BETWEEN_HOLD; mode <= SS_BETWEEN_LINEAR; ++mode) {
        const press_plan plan = {.count = 3,
                                 .k = 1000.0,
                                 .period = 16,
                                 .between_steps = (ss_between_steps)mode,
                                 .limit = 2.0};
        press(&plan, tick);
        assert_true(ticks_at_limit(tick, 0, plan.limit, 0.95) > 600);
        for (int n = 0; n < PRESS; ++n) {
            assert_true(tick[n].model <= 1.5 * plan.limit);
            assert_true(tick[n].slip < 0.016);
        }
    }
}

/* ---- a limit that changes ---- */

/* Lowered and raised while pressed: the force goes down there as the slew allows and up within .3
 * s, and no further; the proxy goes with it, without a swing. */
TEST(a_changed_limit_is_reached_by_the_slew)
{
    static const double slew[2] = {2000.0, 100.0};
    for (int s = 0; s < 2; ++s) {
        ss_haptic_config config = default_config();
        config.damping = 2.0;
        config.max_slew = slew[s];
        rig r;
        rig_start(&r, &config);
        for (int n = 0; n < 600; ++n) {
            make_result(&r, 3, 1000.0, T);
            r.is_new = n > 0;
            rig_tick(&r, 1e-3 - 13e-3 * fmin(1.0, n / 500.0));
        }
        static const double limit[4] = {5.0, 1.0, 6.0, 0.5};
        for (int k = 0; k < 4; ++k) {
            const double before = r.out.force.force[2], from = r.out.force.proxy[2];
            const double step = slew[s] * T;
            double last = before, height = from;
            config.max_force = limit[k];
            ss_haptic_configure(r.haptic, &config);
            const bool is_raised = limit[k] > before;
            const int needed = is_raised ? 300 : (int)ceil(fabs(limit[k] - before) / step);
            for (int n = 1; n <= needed + 100; ++n) {
                make_result(&r, 3, 1000.0, T);
                rig_tick(&r, -12e-3);
                const double f = ss_norm3(r.out.force.force);
                assert_true(fabs(f - last) <= step * (1.0 + 1e-9));
                assert_true((f - last) * (limit[k] - before) >= -1e-6);
                if (n >= needed) {
                    assert_near(f, limit[k], 1e-4 * limit[k]);
                }
                /* Towards where the new limit is, and not past it. */
                assert_true((r.out.force.proxy[2] - height) * (before - limit[k]) >= -1e-6);
                last = f;
                height = r.out.force.proxy[2];
            }
            assert_true(fabs(height - from) > 0.5e-3);
        }
        rig_end(&r);
    }
}

TEST(force_is_limited_and_the_proxy_slips)
{
    ss_haptic_config config = default_config();
    config.max_force = 3.0;
    config.damping = 2.0;
    rig r;
    rig_start(&r, &config);
    rig_press(&r, 1000.0, 2e-3);
    assert_near(r.out.force.force[2], 2.0, 0.2);
    double f = 0.0;
    for (int i = 1; i <= 300; ++i) {
        const double z = -2e-3 - 8e-3 * fmin(1.0, i / 100.0);
        rig_result(&r, 1000.0, -r.out.target.proxy[2], 1);
        r.pose.velocity[2] = i <= 100 ? -0.08 : 0.0;
        f = rig_tick(&r, z);
        assert_true(f <= 3.0 + 1e-12);
        if (i > 50 && i <= 100) {
            /* The hand goes on, the model is not told to: only the share left of the spring. */
            assert_true(fabs(r.out.target.velocity[2]) < 0.03);
        }
    }
    assert_near(f, 3.0, 1e-9);
    assert_true(r.out.force.flags & SOFTSIM_FORCE_LIMITED);
    assert_near(r.out.force.stiffness, 0.0, 0.0);
    /* The tissue is pushed no further than the limit: 3 mm of 1 kN/m. */
    assert_near(r.out.target.proxy[2], -3e-3, 0.05e-3);
    rig_end(&r);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
