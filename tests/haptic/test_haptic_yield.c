/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What the hand feels of stiff tissue, as the difference of the force over the difference of the
 * way: no stiffer than the limit, and as the wire says. */
#include "common/test.h"

#include "haptic_fixture.h"

enum { WINDOW = 5, TICKS = 1200, DOWN_TICKS = 400 };
#define LIMIT 400.0 /* N/m */

/* Tissue without mass: layers that the tool meets one after the other, `apart` each, every one a
 * contact of its own with a spring that hardens in its first 0.2 mm from `soft` to `hard`. */
typedef struct layers {
    int count;
    double apart, soft, hard, tilt;
} layers;

static double layer_force(const layers *tissue, double depth)
{
    const double bend = 0.2e-3;
    return depth < bend ? tissue->soft * depth
                        : tissue->soft * bend + tissue->hard * (depth - bend);
}

static void layers_result(rig *r, const layers *tissue)
{
    const double *p = r->out.force.proxy;
    rig_result(r, tissue->soft, -p[2], 1);
    ss_copy3(r->result.proxy, p);
    ss_contact_set *set = &r->result.set;
    set->count = tissue->count;
    for (int i = 0; i < tissue->count; ++i) {
        const double side = (i % 2 == 0 ? 1.0 : -1.0) * tissue->tilt;
        const double own = -p[0] * sin(side) - (p[2] + i * tissue->apart) * cos(side);
        ss_contact *c = &set->contact[i];
        *c = (ss_contact){.stiffness = own < 0.2e-3 ? tissue->soft : tissue->hard,
                          .force = own > 0.0 ? layer_force(tissue, own) : 0.0,
                          .gap = fmax(0.0, -own)};
        ss_set3(c->normal, sin(side), 0.0, cos(side));
        c->point[0] = 0.01 * i;
        c->station = i;
    }
}

/* Pressed 8 mm deep in .4 s, held, and out again. */
static double path_z(int n)
{
    const double down = fmin(1.0, n / (double)DOWN_TICKS);
    const double up = fmax(0.0, (n - 800.0) / DOWN_TICKS);
    return 1e-3 - 9e-3 * (down - up);
}

TEST(limit_holds_from_the_first_tick)
{
    static const layers tissue[] = {{1, 0.0, 100.0, 6000.0, 0.0},
                                    {1, 0.0, 4000.0, 4000.0, 0.0},
                                    {2, 1e-3, 300.0, 300.0, 0.0},
                                    {4, 0.5e-3, 100.0, 900.0, 0.6}};
    ss_haptic_config config = default_config();
    config.stiffness = LIMIT;
    config.max_force = 100.0;
    for (size_t k = 0; k < sizeof tissue / sizeof *tissue; ++k) {
        static double force[TICKS];
        rig r;
        rig_start(&r, &config);
        double worst = 0.0, held = 0.0;
        for (int n = 0; n < TICKS; ++n) {
            const double z = path_z(n);
            if (n > 0) {
                layers_result(&r, &tissue[k]);
            }
            force[n] = rig_tick(&r, z);
            const double way = n >= WINDOW ? path_z(n - WINDOW) - z : 0.0;
            if (fabs(way) > 1e-6 && force[n] > 0.0 && force[n - WINDOW] > 0.0) {
                worst = fmax(worst, (force[n] - force[n - WINDOW]) / way);
            }
            /* No step either: one of the window's worth at most, to both sides. */
            assert_true(n == 0 || fabs(force[n] - force[n - 1]) <= 1.05 * LIMIT * 30e-6 + 0.02);
            held = n == 790 ? force[n] : held;
        }
        print_message("%d layers, %g to %g N/m: felt at most %.0f N/m, held %.3f N\n",
                      tissue[k].count, tissue[k].soft, tissue[k].hard, worst, held);
        assert_true(worst <= 1.05 * LIMIT);
        /* It is the limit that is felt, not less. */
        assert_true(held > (k == 0 || k == 3 ? 0.7 : 0.9) * LIMIT * 7e-3);
        rig_end(&r);
    }
}

/* Held at depth `z`, and `moved` from there along the normal that is told: the force, and what is
 * told of its stiffness. */
static void held_force(const layers *tissue, double limit, double z, const double moved[3],
                       double *out_stiffness, double out_force[3], double out_normal[3])
{
    ss_haptic_config config = default_config();
    config.stiffness = limit;
    config.max_force = 100.0;
    rig r;
    rig_start(&r, &config);
    for (int n = 0; n < 700; ++n) {
        if (n > 0) {
            layers_result(&r, tissue);
        }
        const double share = n < 450 ? 0.0 : 1.0;
        const double down = fmin(1.0, n / 200.0);
        ss_set3(r.pose.position, share * moved[0], share * moved[1], 0.0);
        (void)rig_tick(&r, 1e-3 - (1e-3 - z) * down + share * moved[2]);
    }
    *out_stiffness = r.out.force.stiffness;
    ss_copy3(out_force, r.out.force.force);
    ss_copy3(out_normal, r.out.force.normal);
    rig_end(&r);
}

/* What the wire says, against the difference of two forces 20 um apart: within 5 %. */
TEST(wire_says_what_is_felt)
{
    static const layers tissue[] = {{1, 0.0, 100.0, 6000.0, 0.0},   {1, 0.0, 250.0, 250.0, 0.0},
                                    {1, 0.0, 4000.0, 4000.0, 0.0},  {2, 1e-3, 300.0, 300.0, 0.0},
                                    {2, 0.1e-3, 900.0, 900.0, 0.6}, {4, 0.5e-3, 100.0, 900.0, 0.6}};
    static const double limit[] = {400.0, 660.0};
    const double step = 20e-6, still[3] = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < sizeof tissue / sizeof *tissue; ++k) {
        for (int m = 0; m < 2; ++m) {
            double told, again, from[3], to[3], normal[3], other[3], moved[3], change[3];
            held_force(&tissue[k], limit[m], -5e-3, still, &told, from, normal);
            ss_scale3(moved, normal, -step);
            held_force(&tissue[k], limit[m], -5e-3, moved, &again, to, other);
            ss_sub3(change, to, from);
            const double felt = ss_dot3(change, normal) / step;
            print_message("%d layers, %g to %g N/m, limit %g: told %.1f, felt %.1f N/m\n",
                          tissue[k].count, tissue[k].soft, tissue[k].hard, limit[m], told, felt);
            assert_true(fabs(told / felt - 1.0) < 0.05);
        }
    }
}

/* A stiffness that differs from tick to tick takes the spring of a touch down at once, that of a
 * grasp no further than the slow pace does both ways. */
TEST(a_grasp_softens_as_slowly_as_it_stiffens)
{
    for (int is_grasping = 0; is_grasping <= 1; ++is_grasping) {
        ss_yield yield = {.spring = 1000.0};
        for (int i = 0; i < 40; ++i) {
            ss_yield_follow(&yield, i % 2 == 0 ? 200.0 : 1000.0, true, is_grasping, T);
        }
        assert_true(is_grasping ? yield.spring > 990.0 : yield.spring < 210.0);
        for (int i = 0; i < 1000; ++i) {
            ss_yield_follow(&yield, 200.0, true, is_grasping, T);
        }
        assert_near(yield.spring, 200.0, 1e-9);
    }
}

/* Both ends of the spring go on closed paths: what it hands out there, J. The stretch swings
 * between `least` and `most`, K_c between 300 and 600 N/m, `phase` turns behind. */
static double turn_energy(ss_yield *yield, double least, double most, double phase,
                          double *out_most)
{
    static const double hand[3] = {0.0, 0.0, 0.0};
    const int ticks = 2000;
    double energy = 0.0, before = NAN;
    *out_most = 0.0;
    for (int i = 0; i <= ticks; ++i) {
        const double turn = (double)i / ticks;
        const double way = 0.5 * (least + most) - 0.5 * (most - least) * cos(6.283185307 * turn);
        const double softness = 0.5 + 0.5 * cos(6.283185307 * (turn - phase));
        const ss_rest rest = {.p = {0.0, 0.0, way}, .stiffness_fraction = 1.0};
        const double force = yield->spring * (way - yield->rest[2]);
        *out_most = fmax(*out_most, 0.5 * force * force / yield->spring);
        if (i > 0) {
            const double last =
                0.5 * (least + most) - 0.5 * (most - least) * cos(6.283185307 * (i - 1.0) / ticks);
            energy -= 0.5 * (force + before) * (way - last);
        }
        const double load[3] = {0.0, 0.0, force};
        ss_yield_take(yield, hand, &rest, load, 100.0);
        ss_yield_follow(yield, 300.0 * pow(2.0, 1.0 - softness), true, false, T);
        before = yield->spring * (way - yield->rest[2]);
    }
    return energy;
}

/* A spring that follows the tissue's stiffness makes nothing on any closed path, turn by turn; and
 * where it goes the same way back it takes next to nothing either. */
TEST(no_closed_path_gives_energy)
{
    for (int k = 0; k < 8; ++k) {
        ss_yield yield = {.spring = 300.0};
        const ss_yield start = yield;
        double sum = 0.0, worst = -INFINITY, stored = 0.0;
        ss_yield_follow(&yield, start.spring, false, false, T); /* before the touch */
        for (int n = 0; n < 6; ++n) {
            const double energy = turn_energy(&yield, 4e-3, 16e-3, k / 8.0, &stored);
            /* The first begins unloaded. */
            sum += n > 0 ? energy : 0.0;
            worst = fmax(worst, n > 0 ? energy : worst);
        }
        print_message("%d/8 turn behind: %.2f mJ in five turns, %.2f in one at most, of %.1f\n", k,
                      1e3 * sum, 1e3 * worst, 1e3 * stored);
        assert_true(worst < 0.05 * stored && sum < 1e-3);
    }
    ss_yield yield = {.spring = 600.0};
    double sum = 0.0, stored = 0.0;
    ss_yield_follow(&yield, 600.0, false, false, T);
    for (int n = 0; n < 4; ++n) {
        sum = turn_energy(&yield, 4e-3, 16e-3, 0.5, &stored);
    }
    print_message("to and fro: %.2f mJ of %.1f\n", 1e3 * sum, 1e3 * stored);
    assert_true(fabs(sum) < 0.05 * stored);
    assert_true(yield.spring > 580.0); /* it has come back */
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
