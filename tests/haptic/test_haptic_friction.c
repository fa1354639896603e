/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What holds the proxy along the surface between two results, and in a loop with a tissue that has
 * Coulomb friction. */
#include "common/test.h"
#include "haptic_fixture.h"

#define MU 0.3
#define K  300.0 /* N/m, of the tissue, along and across */

/* ---- the law ---- */

/* One contact, whose normal force is what a test says. */
static void one_contact(ss_local_contact *local, double stiffness)
{
    ss_local_contact_clear(local);
    local->count = 1;
    ss_local_contact_point *c = &local->contact[0];
    c->direction[2] = c->normal[2] = 1.0;
    c->tangential = c->stiffness = stiffness;
    c->coefficient = MU;
    local->friction.is_used = true;
}

/* Forces of any size come and go while the hand goes anywhere: what the hand puts in is never less
 * than what the spring holds. */
TEST(random_walks_never_have_negative_dissipation)
{
    for (random_state = 1; random_state <= 20;) {
        const uint64_t seed = random_state;
        const double k_t = uniform(10.0, 5000.0), spring = uniform(100.0, 20000.0);
        ss_local_contact local;
        double hand[3] = {0.0, 0.0, 0.0}, p[3] = {0.0, 0.0, 0.0}, held = 0.0, lost = 0.0;
        one_contact(&local, k_t);
        for (int n = 0; n < 20000; ++n) {
            double before[3], way[3];
            for (int k = 0; k < 2; ++k) {
                hand[k] += uniform(-1e-4, 1e-4);
            }
            const double jump = uniform(0.0, 1.0);
            /* A contact that pushes as hard wherever the proxy is. */
            ss_balance balance = {.spring = spring, .limit = INFINITY, .count = 1};
            ss_rest rest;
            balance.row[0].normal[2] = 1.0;
            balance.row[0].free_force = jump < 0.1 ? 0.0 : 3.0 * jump;
            ss_copy3(balance.p_free, hand);
            (void)ss_coupling_balance(&balance, &rest);
            ss_friction_balance(&local, p, spring, T, &balance, &rest);
            ss_copy3(before, p);
            ss_copy3(p, rest.p);
            ss_sub3(way, p, before);
            const double *f = local.friction.force;
            assert_true(ss_norm3(f) <= MU * rest.force[0] * (1.0 + 1e-12));
            const double now = 0.5 * ss_dot3(f, f) / k_t;
            const double loss = -ss_dot3(f, way) - (now - held);
            /* J; what rounding leaves of a spring of some mJ */
            assert_true(loss >= -1e-18);
            lost += loss;
            held = now;
        }
        assert_true(lost > 100.0 * held);
        random_state = seed + 1;
    }
}

/* Of a hand that drags `way` m a tick at the limit L: of the friction `drawn` N draw the tip in,
 * and `left` N of what an update left lie along it. Returns what the friction comes to, N; it never
 * lets go. */
static double drag(double mu, double way, double limit, double drawn, double left)
{
    const double slope = 350.0, spring = 3500.0;
    ss_local_contact local;
    double p[3] = {0.0, 0.0, 0.0}, before = -INFINITY;
    one_contact(&local, 250.0);
    local.contact[0].coefficient = mu;
    local.friction.force[2] = -drawn;
    local.friction.share[1] = 1.0;
    for (int n = 0; n < 200; ++n) {
        ss_balance balance = {.spring = spring,
                              .limit = limit,
                              .axis = {0.0, 0.0, 1.0},
                              .other = {-left, 0.0, 0.0},
                              .p_free = {way * n - left / spring, 0.0, -0.010},
                              .count = 1};
        ss_rest rest;
        double whole[3];
        balance.row[0] = (ss_balance_row){{0.0, 0.0, 1.0}, slope * 0.010, slope};
        (void)ss_coupling_balance(&balance, &rest);
        ss_friction_balance(&local, p, spring, T, &balance, &rest);
        ss_copy3(p, rest.p);
        ss_set3(whole, -left, 0.0, rest.force[0]);
        ss_add3(whole, whole, local.friction.force);
        assert_near(ss_norm3(whole), limit, 1e-6);
        assert_true(-local.friction.force[0] <= mu * rest.force[0] * (1.0 + 1e-5));
        assert_true(-local.friction.force[0] >= before - 1e-5);
        before = -local.friction.force[0];
    }
    return before;
}

/* A tip lies in its dent far beyond the limit L. What would stick is more than that, whatever the
 * contact F gives up: it slides, with mu F or what L leaves room for,
 *   (mu F + left)^2 + (F - drawn)^2 = L^2,   at least F = drawn. */
TEST(at_the_limit_friction_that_cannot_stick_slides)
{
    static const double mus[] = {0.5, 1.0, 2.0, 4.0}, ways[] = {2e-5, 5e-5, 1e-4, 1e-3};
    const double limit = 0.58, drawn = 0.2, left = 0.25;
    const double c = left * left + drawn * drawn - limit * limit;
    for (int n = 0; n < 16; ++n) {
        const double mu = mus[n / 4], a = 1.0 + mu * mu, b = mu * left - drawn;
        const double root = (sqrt(b * b - a * c) - b) / a;
        const double expected = root > drawn ? mu * root : limit - left;
        const double came_to = drag(mu, ways[n % 4], limit, drawn, left);
        print_message("mu %g, %g mm a tick: %.6f of %.6f N\n", mu, 1e3 * ways[n % 4], came_to,
                      expected);
        assert_near(came_to, expected, 1e-5);
    }
}

/* What an update leaves of friction is within its limit beside contacts that have turned; the rest
 * decays as what they cannot carry, and the force is as it was. */
TEST(an_update_keeps_the_force_and_friction_within_its_limit)
{
    random_state = 3;
    for (int n = 0; n < 1000; ++n) {
        ss_local_contact local;
        ss_contact_set set = {0};
        double before[3], after[3], flat[3];
        const double p[3] = {0.0, 0.0, 0.0}, force = uniform(0.0, 1.0);
        one_contact(&local, uniform(10.0, 1000.0));
        ss_local_contact_point *c = &local.contact[0];
        ss_set3(c->direction, uniform(-1.0, 1.0), uniform(-1.0, 1.0), 1.0);
        ss_normalize3(c->direction);
        c->force = c->last_force = force;
        for (int k = 0; k < 3; ++k) {
            local.friction.force[k] = MU * force * uniform(-1.0, 1.0);
            local.residual[k] = uniform(-0.1, 0.1);
        }
        ss_add3(before, local.residual, local.friction.force);
        ss_friction_take(&local, &set, p);
        ss_add3(after, local.residual, local.friction.force);
        const double *f = local.friction.force;
        ss_madd3(flat, f, -ss_dot3(f, c->direction), c->direction);
        for (int k = 0; k < 3; ++k) {
            assert_near(after[k], before[k], 1e-15);
        }
        assert_true(ss_norm3(flat) <= MU * force * (1.0 + 1e-12));
    }
}

/* ---- a loop with tissue ---- */

/* Flat tissue with Coulomb friction, by an anchor of its own. */
typedef struct tissue {
    double anchor[2];
    bool was_touching;
    double tilt; /* rad, of the normal that it tells */
} tissue;

/* A result of the tissue for the last target, a period of `ticks` after it. */
static void answer(rig *r, tissue *t, int ticks)
{
    double predicted[3];
    ss_haptic_predict(&r->out.target, 1.0, ticks * T, predicted);
    const double depth = -predicted[2], normal = fmax(0.0, K * depth);
    rig_result(r, K, depth, ticks);
    ss_copy3(r->result.proxy, predicted);
    r->result.period = ticks * T;
    ss_contact *c = &r->result.set.contact[0];
    ss_copy3(c->point, predicted);
    c->coefficient = MU;
    c->tangential = K;
    double f[2], size;
    for (int k = 0; k < 2; ++k) {
        t->anchor[k] = t->was_touching ? t->anchor[k] : predicted[k];
        f[k] = K * (t->anchor[k] - predicted[k]);
    }
    size = hypot(f[0], f[1]);
    for (int k = 0; k < 2; ++k) {
        f[k] *= size > MU * normal ? MU * normal / size : 1.0;
        t->anchor[k] = predicted[k] + f[k] / K;
        c->friction[k] = r->result.set.friction[k] = f[k];
        r->result.set.force[k] = f[k];
    }
    t->was_touching = normal > 0.0;
    ss_set3(c->normal, sin(t->tilt), 0.0, cos(t->tilt));
}

/* A tick with the hand at x, y, z and a result every `ticks`; returns the force on it. */
static const double *step(rig *r, tissue *t, int ticks, double x, double y, double z)
{
    if (r->tick > 0 && r->tick % ticks == 0) {
        answer(r, t, ticks);
    }
    r->pose.position[0] = x;
    r->pose.position[1] = y;
    (void)rig_tick(r, z);
    return r->out.force.force;
}

/* Pressed 3 mm deep, from outside. */
static void begin_pressed(rig *r, tissue *t, int ticks)
{
    *t = (tissue){0};
    rig_begin(r);
    for (int n = 0; n <= 800; ++n) {
        (void)step(r, t, ticks, 0.0, 0.0, 1e-3 - 4e-3 * fmin(1.0, n / 400.0));
    }
}

static const int rates[] = {1, 4, 17};
enum { RATES = sizeof rates / sizeof *rates };

TEST(sticks_then_slides_at_the_limit_against_the_motion)
{
    for (int n = 0; n < RATES; ++n) {
        rig r;
        tissue t;
        begin_pressed(&r, &t, rates[n]);
        const double normal = r.out.force.force[2], cosine = cos(0.7), sine = sin(0.7);
        double last[3], largest = 0.0;
        ss_copy3(last, r.out.force.force);
        for (int i = 1; i <= 1000; ++i) {
            const double way = 1e-5 * i; /* 10 mm/s */
            const double *f = step(&r, &t, rates[n], way * cosine, way * sine, r.pose.position[2]);
            double change[3];
            ss_sub3(change, f, last);
            largest = fmax(largest, ss_norm3(change));
            ss_copy3(last, f);
            const double along = -(cosine * f[0] + sine * f[1]);
            assert_true(along <= MU * f[2] * 1.001 + 1e-9);
            if (K * way < 0.9 * MU * normal) {
                /* 5 % of a limit: what a prediction half a step ahead is off */
                assert_near(along, K * way, 0.05 * MU * normal);
            }
            if (K * way > 1.3 * MU * normal) {
                assert_near(along, MU * f[2], 0.02 * MU * f[2]);
                assert_near(atan2(-f[1], -f[0]), 0.7, 2.0 * 3.14159265 / 180.0);
            }
        }
        assert_true(largest <= 0.02 * normal);
        rig_end(&r);
    }
}

/* A minute at half the limit, with a count of the device to and fro. */
TEST(a_minute_of_stick_does_not_drift)
{
    for (int n = 0; n < RATES; ++n) {
        rig r;
        tissue t;
        begin_pressed(&r, &t, rates[n]);
        const double z = r.pose.position[2], x = 0.5 * MU * -z;
        for (int i = 1; i <= 200; ++i) {
            (void)step(&r, &t, rates[n], x * fmin(1.0, i / 100.0), 0.0, z);
        }
        double first[3], mean[3] = {0.0, 0.0, 0.0};
        ss_copy3(first, r.out.force.force);
        random_state = 5;
        for (int i = 0; i < 60000; ++i) {
            const double count = uniform(0.0, 1.0) < 0.5 ? 0.0 : 30e-6;
            const double *f = step(&r, &t, rates[n], x + count - 15e-6, 0.0, z);
            assert_true(fabs(f[0] - first[0]) < 0.1 * fabs(first[0]));
            if (i >= 59000) {
                ss_madd3(mean, mean, 1e-3, f);
            }
        }
        assert_near(mean[0] / first[0], 1.0, 0.01);
        rig_end(&r);
    }
}

/* Lifted while it sticks: the friction goes with the normal force, and is gone with the contact. */
TEST(friction_goes_with_the_normal_force)
{
    rig r;
    tissue t;
    begin_pressed(&r, &t, 1);
    double x = 0.0;
    for (int i = 1; i <= 100; ++i) {
        x = 8e-6 * i;
        (void)step(&r, &t, 1, x, 0.0, -0.003);
    }
    assert_true(fabs(r.out.force.force[0]) > 0.8 * MU * r.out.force.force[2]);
    for (int i = 1; i <= 400; ++i) {
        const double *f = step(&r, &t, 1, x, 0.0, -0.003 + 1e-5 * i);
        assert_true(hypot(f[0], f[1]) <= MU * fmax(0.0, f[2]) + 0.01 * MU);
    }
    assert_near(ss_norm3(r.out.force.force), 0.0, 1e-9);
    rig_end(&r);
}

/* A square of 20 mm, sliding: the hand pays mu F along each side; and the observer has counted that
 * to the joule. */
TEST(a_loop_costs_the_friction_and_the_observer_counts_it)
{
    static const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    for (int n = 0; n < RATES; ++n) {
        rig r;
        tissue t;
        begin_pressed(&r, &t, rates[n]);
        double paid = 0.0, before[3], last[3] = {0.0, 0.0, r.pose.position[2]}, normal = 0.0;
        const double z = r.pose.position[2];
        double counted = 0.0;
        for (int turn = 0; turn < 2; ++turn) { /* the first begins at rest */
            paid = normal = 0.0;
            counted = r.out.energy_from_device_j - r.out.energy_to_device_j;
            for (int i = 0; i < 8000; ++i) {
                const int side = i / 2000;
                const double share = (i % 2000 + 1) / 2000.0;
                double x[3] = {0.0, 0.0, z}, way[3];
                for (int k = 0; k < 2; ++k) {
                    x[k] =
                        0.020 * (corner[side][k] + share * (corner[side + 1][k] - corner[side][k]));
                }
                ss_copy3(before, r.out.force.force);
                r.pose.force_seq = r.out.force.seq;
                (void)step(&r, &t, rates[n], x[0], x[1], z);
                ss_sub3(way, x, last);
                paid -= ss_dot3(before, way);
                normal += before[2] / 8000.0;
                ss_copy3(last, x);
            }
            counted = r.out.energy_from_device_j - r.out.energy_to_device_j - counted;
        }
        /* At each corner the spring turns: a part of its stretch is the hand's again. */
        const double stretch = MU * normal / K;
        assert_near(paid, MU * normal * (0.080 - 4.0 * stretch * 0.5), 0.03 * MU * normal * 0.080);
        assert_near(counted, paid, 0.01 * paid);
        rig_end(&r);
    }
}

/* 10 mm deep, from outside, at a limit that is reached before. */
static void press_to_limit(rig *r, tissue *t, double limit)
{
    ss_haptic_config config = default_config();
    config.max_force = limit;
    *t = (tissue){0};
    rig_start(r, &config);
    for (int i = 0; i <= 800; ++i) {
        (void)step(r, t, 1, 0.0, 0.0, 1e-3 - 11e-3 * fmin(1.0, i / 400.0));
    }
}

/* 10 mm deep at a limit that is reached at 2.5 mm, a hand shakes sideways by 3 mm: friction takes
 * mu N on every way there and back, but for the stretch of its spring as the hand turns round. */
TEST(at_the_limit_friction_takes_energy_from_a_hand_that_shakes)
{
    const double limit = 0.7, size = 0.003;
    for (int hz = 10; hz <= 20; hz += 5) {
        rig r;
        tissue t;
        press_to_limit(&r, &t, limit);
        double before = 0.0, paid = 0.0, way = 0.0;
        for (int i = 1; i <= 4000; ++i) {
            const double x = size * sin(2.0 * SS_PI * hz * i * T), felt = r.out.force.force[0];
            r.pose.force_seq = r.out.force.seq;
            (void)step(&r, &t, 1, x, 0.0, -0.010);
            paid -= felt * (x - before);
            way += fabs(x - before);
            before = x;
        }
        const double all = MU * limit / sqrt(1.0 + MU * MU) * way;
        print_message("%d Hz: %.1f mJ of %.1f\n", hz, 1e3 * paid, 1e3 * all);
        assert_true(paid >= 0.5 * all && paid <= all);
        rig_end(&r);
    }
}

/* A hand that slides at the limit over tissue whose normal one result turns by 25 degrees along the
 * way and another back, as a coarse mesh does under a tip: the force turns by a degree a tick at
 * most. */
TEST(at_the_limit_an_update_that_turns_the_contact_is_not_felt)
{
    for (int n = 0; n < RATES; ++n) {
        rig r;
        tissue t;
        press_to_limit(&r, &t, 0.7);
        double most = 0.0, last[3] = {0.0, 0.0, 1.0};
        for (int i = 1; i <= 2000; ++i) {
            const double *f = step(&r, &t, rates[n], 3e-5 * i, 0.0, -0.010);
            double turn[3];
            ss_cross3(turn, last, f);
            most =
                fmax(most, i > 500 ? asin(ss_norm3(turn) / (ss_norm3(last) * ss_norm3(f))) : 0.0);
            ss_copy3(last, f);
            t.tilt = r.tick / rates[n] / 8 % 2 == 0 ? 0.44 : 0.0;
        }
        print_message("%d ticks a result: turns by %.3f degrees\n", rates[n], most * 57.29577951);
        assert_true(most > 0.0 && most * 57.29577951 <= 1.0);
        rig_end(&r);
    }
}

/* The same with hands that go anywhere: each has put in more than it got, and from its highest on
 * that never falls by 1 mJ. */
TEST(at_the_limit_friction_gives_no_energy_to_hands_that_go_anywhere)
{
    enum { WAVES = 3 };
    const double limit = 0.7;
    double most_given = 0.0;
    for (random_state = 1; random_state <= 40;) {
        const uint64_t seed = random_state;
        double size[2][WAVES], hz[2][WAVES], phase[2][WAVES];
        for (int k = 0; k < 2 * WAVES; ++k) {
            size[k % 2][k / 2] = uniform(0.0, 0.002);
            hz[k % 2][k / 2] = uniform(0.5, 20.0);
            phase[k % 2][k / 2] = uniform(0.0, 2.0 * SS_PI);
        }
        rig r;
        tissue t = {0};
        ss_haptic_config config = default_config();
        config.max_force = limit;
        rig_start(&r, &config);
        double before[2] = {0.0, 0.0}, paid = 0.0, highest = 0.0;
        for (int i = 0; i <= 4800; ++i) {
            const double fade = fmin(1.0, i / 400.0), grow = fmin(1.0, fmax(0.0, i - 800) / 400.0);
            double x[2] = {0.0, 0.0};
            for (int k = 0; k < 2 * WAVES; ++k) {
                const double turn = 2.0 * SS_PI * hz[k % 2][k / 2] * i * T + phase[k % 2][k / 2];
                x[k % 2] += grow * size[k % 2][k / 2] * sin(turn);
            }
            const double *last = r.out.force.force;
            paid -= i > 800 ? last[0] * (x[0] - before[0]) + last[1] * (x[1] - before[1]) : 0.0;
            highest = fmax(highest, paid);
            most_given = fmax(most_given, highest - paid);
            before[0] = x[0];
            before[1] = x[1];
            r.pose.force_seq = r.out.force.seq;
            (void)step(&r, &t, (int)(seed % 3) * 4 + 1, x[0], x[1], 1e-3 - 11e-3 * fade);
        }
        assert_true(paid > 0.0);
        rig_end(&r);
        random_state = seed + 1;
    }
    print_message("handed out %.3f mJ at most\n", 1e3 * most_given);
    assert_true(most_given <= 1e-3);
}

/* A hand that circles there: friction turns with it, and takes mu N of the way but for what it
 * lags. */
TEST(at_the_limit_friction_takes_energy_from_a_hand_that_circles)
{
    const double limit = 0.7, size = 0.003;
    for (int hz = 2; hz <= 14; hz += 4) {
        rig r;
        tissue t;
        press_to_limit(&r, &t, limit);
        double before[2] = {0.0, 0.0}, paid = 0.0, way = 0.0;
        for (int i = 1; i <= 4000; ++i) {
            const double turn = 2.0 * SS_PI * hz * i * T, grown = size * fmin(1.0, i / 500.0);
            const double x[2] = {grown * sin(turn), grown * (1.0 - cos(turn))};
            const double dx = x[0] - before[0], dy = x[1] - before[1];
            paid -= r.out.force.force[0] * dx + r.out.force.force[1] * dy;
            way += sqrt(dx * dx + dy * dy);
            before[0] = x[0];
            before[1] = x[1];
            r.pose.force_seq = r.out.force.seq;
            (void)step(&r, &t, 1, x[0], x[1], -0.010);
        }
        const double all = MU * limit / sqrt(1.0 + MU * MU) * way;
        print_message("circles at %d Hz: %.1f mJ of %.1f\n", hz, 1e3 * paid, 1e3 * all);
        assert_true(paid >= 0.5 * all && paid <= all);
        rig_end(&r);
    }
}

/* Without a coefficient told friction is nothing, whatever a result says. */
TEST(without_a_coefficient_there_is_none)
{
    rig r;
    rig_begin(&r);
    (void)rig_press(&r, K, 0.003);
    for (int i = 0; i < 100; ++i) {
        rig_result(&r, K, 0.003, 1);
        r.pose.position[0] = 1e-5 * i;
        (void)rig_tick(&r, -0.003);
        assert_near(r.out.force.force[0], 0.0, 0.0);
    }
    rig_end(&r);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
