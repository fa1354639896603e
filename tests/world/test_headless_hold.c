/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What a hand gets from tissue that it holds: out of closed ways nothing, and with the hand at rest
 * a force that stays. */
#include "common/test.h"

#include "common/effort.h"
#include "press_fixture.h"
#include "rt/vec.h"

#define CONE    "{cone: {radius_mm: 6, length_mm: 14}}"
#define BOX     "{box: {size_mm: [20, 12, 8]}}"
#define SPHERE  "{sphere: {radius_mm: 5}}"
#define CAPSULE "{capsule: {radius_mm: 3, length_mm: 10}}"

/* A place on the surface and the way in; `shape` reaches as far as `tip` (m) ahead of its centre.
 */
typedef struct grip {
    body body;
    double surface[3], in[3];
    const char *shape;
    double tip, depth;
    const char *rate;
} grip;

#define SIDE                                                                                       \
    {-0.0326, -0.0131, 0.0163},                                                                    \
    {                                                                                              \
        0.132, 0.364, -0.922                                                                       \
    }
#define LOWER                                                                                      \
    {-0.0303, 0.0158, -0.0111},                                                                    \
    {                                                                                              \
        0.492, -0.632, 0.599                                                                       \
    }
#define TOP                                                                                        \
    {0.0, 0.0, 0.020},                                                                             \
    {                                                                                              \
        0.0, 0.0, -1.0                                                                             \
    }
#define FAST "simulation.rate_hz=1000"
#define SLOW "simulation.rate_hz=100"
#define BLOCK(NAME)                                                                                \
    {                                                                                              \
        .name = NAME, .model = "  name: " NAME "\n" ELASTIC                                        \
    }
#define SPRINGS                                                                                    \
    {                                                                                              \
        .name = "mass-spring", .model = "  name: mass-spring\n  youngs_modulus_pa: 60000\n"        \
                                        "  density_kg_m3: 1060\n  mass_damping_per_s: 30\n"        \
    }

/* The first of them by default. */
static const grip grips[] = {
    {{.name = "kidney", .scene = "kidney.yaml"}, SIDE, CONE, 0.007, 0.003, FAST},
    {{.name = "kidney", .scene = "kidney.yaml"}, SIDE, CONE, 0.007, 0.003, SLOW},
    {{.name = "kidney", .scene = "kidney.yaml"}, SIDE, BOX, 0.004, 0.003, SLOW},
    {BLOCK("fem"), TOP, CONE, 0.007, 0.003, FAST},
    {BLOCK("xpbd"), TOP, CAPSULE, 0.008, 0.003, SLOW},
    {BLOCK("corotational"), TOP, SPHERE, 0.005, 0.003, SLOW},
    {SPRINGS, TOP, CONE, 0.007, 0.003, SLOW},
    {{.name = "liver", .scene = "liver-chainmail.yaml"},
     {-0.0989, 0.0086, 0.0041},
     {0.986, -0.145, -0.083},
     CONE,
     0.007,
     0.004,
     FAST},
    {{.name = "kidney", .scene = "kidney.yaml"}, LOWER, CONE, 0.007, 0.002, FAST},
    {{.name = "kidney", .scene = "kidney.yaml"}, SIDE, SPHERE, 0.005, 0.003, SLOW},
    {{.name = "kidney", .scene = "kidney.yaml"}, LOWER, CAPSULE, 0.008, 0.002, FAST},
    {BLOCK("fem"), TOP, BOX, 0.004, 0.003, SLOW},
    {BLOCK("xpbd"), TOP, CONE, 0.007, 0.003, FAST},
    {BLOCK("corotational"), TOP, CONE, 0.007, 0.003, FAST},
    {SPRINGS, TOP, BOX, 0.004, 0.003, FAST},
    {{.name = "hm1", .scene = "hm1-tissue.yaml"},
     {-0.0213, 0.0234, -0.0133},
     {0.648, -0.748, 0.142},
     CONE,
     0.007,
     0.004,
     FAST},
    {{.name = "kidney-tissue", .scene = "kidney-tissue.yaml"},
     {-0.0390, 0.0114, 0.0034},
     {0.873, -0.487, -0.017},
     CONE,
     0.007,
     0.004,
     FAST},
};
enum { FIRST = 8, GRIPS = sizeof grips / sizeof *grips };

static softsim_world *make_gripped(const grip *g)
{
    char shape[128];
    (void)snprintf(shape, sizeof shape, "contact.tools=[{probe: 0, shape: %s}]", g->shape);
    const char *const set[] = {shape, g->rate};
    return open_body(&g->body, set, 2);
}

/* ms: pressed in, grasped, drawn out, aside and back to where it was, lifted and turned, held. */
enum { IN = 400, GRASPED = 500, OUT = 1100, ASIDE = 1700, BACK = 2300, SHUT = 2380 };
enum { LIFT = 2400, LIFTED = 2900, SETTLED = 3200, TICKS = 4700 };

static double part(int n, int from, int to)
{
    return smooth((double)(n - from) / (to - from));
}

static softsim_pose pose_at(const grip *g, int n)
{
    static const double up[3] = {0.0, 0.0, 1.0}, plain[4] = {1.0, 0.0, 0.0, 0.0};
    const double away = fabs(g->in[0]) < 0.7 ? 1.0 : 0.0, other = 1.0 - away;
    const double beside[3] = {away, other, 0.0};
    double side[3], turn[3], upright[4], x[3];
    ss_cross3(side, beside, g->in);
    (void)ss_normalize3(side);
    const double lift =
        0.015 * (part(n, GRASPED, OUT) - part(n, ASIDE, BACK)) + 0.0155 * part(n, LIFT, LIFTED);
    const double aside = 0.010 * (part(n, OUT, ASIDE) - part(n, ASIDE, BACK));
    const double depth = -0.006 + (g->depth + 0.006) * part(n, 0, IN) - lift;
    ss_madd3(x, g->surface, depth - g->tip, g->in);
    ss_madd3(x, x, aside, side);
    softsim_pose pose = pose_of(n + 1, x);
    ss_cross3(turn, up, g->in); /* the tip, which is along z, goes ahead */
    const double sine = ss_normalize3(turn);
    ss_scale3(turn, turn, atan2(sine, g->in[2]));
    ss_turn(plain, turn, upright);
    ss_scale3(turn, side, 0.6 * part(n, LIFT, LIFTED));
    ss_turn(upright, turn, pose.orientation);
    pose.buttons = n >= GRASPED ? SOFTSIM_BUTTON_GRASP : 0;
    return pose;
}

typedef struct held {
    double gained, stored; /* J: what the hand got on the closed way, what there was at most */
    double force, swing;   /* N: at the end, and how far from that with the hand at rest */
    double risen;          /* J: of the elastic energy then */
} held;

static held hold(const grip *g)
{
    static double felt[TICKS][3];
    softsim_world *world = make_gripped(g);
    held all = {0};
    double least = INFINITY, energy = 0.0;
    softsim_pose last = {0};
    for (int n = 0; n < TICKS; ++n) {
        const softsim_pose pose = pose_at(g, n);
        ss_copy3(felt[n], feel(world, &pose).force);
        softsim_state state;
        softsim_read(world, &state);
        if (n > GRASPED && n < SHUT) {
            double way[3], mean[3];
            ss_sub3(way, pose.position, last.position);
            ss_add3(mean, felt[n], felt[n - 1]);
            energy += 0.5 * ss_dot3(mean, way);
            all.stored = fmax(all.stored, state.kinetic_j + state.elastic_j);
        }
        if (n >= SETTLED) {
            least = fmin(least, state.elastic_j);
            all.risen = fmax(all.risen, state.elastic_j - least);
        }
        last = pose;
    }
    softsim_destroy(&world);
    all.gained = energy;
    all.force = ss_norm3(felt[TICKS - 1]);
    for (int n = SETTLED; n < TICKS; ++n) {
        double from_end[3];
        ss_sub3(from_end, felt[n], felt[TICKS - 1]);
        all.swing = fmax(all.swing, ss_norm3(from_end));
    }
    return all;
}

TEST(tissue_that_is_held_hands_out_nothing_and_comes_to_rest)
{
    bool is_good = true;
    write_block_mesh();
    for (int k = 0; k < FULL_IN_LONG_RUN(GRIPS, FULL_IN_RELEASE(FIRST, 1)); ++k) {
        const grip *g = &grips[k];
        const held h = hold(g);
        const bool is_fine = h.gained <= 1e-4 + 0.05 * h.stored && h.swing <= 0.02 * h.force &&
                             h.risen <= 0.04 * h.stored && h.force > 0.1; /* as its square */
        print_message("%s, %s, %s: %.2f of %.2f mJ; at rest %.3f N within %.4f N, %.3f mJ more%s\n",
                      g->body.name, g->shape, g->rate, 1e3 * h.gained, 1e3 * h.stored, h.force,
                      h.swing, 1e3 * h.risen, is_fine ? "" : ": BAD");
        is_good = is_good && is_fine;
    }
    assert_true(is_good);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
