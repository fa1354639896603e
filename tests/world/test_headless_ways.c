/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Random ways of a hand at the force limit: presses beyond it, slides, twists and tilts, out and in
 * again, the limit changed meanwhile, with and without friction, on the bundled scenes; judged
 * beside the same way without a limit (way_judge.h). `all` runs 128, `all M N` those from M to N
 * - 1.
 */
#include "common/test.h"

#include "common/effort.h"
#include "loops_fixture.h"
#include "oracles/way_judge.h"
#include "press_fixture.h"
#include "rt/random.h"
#include "rt/vec.h"
#include "world/world.h"

enum { TICKS = 3000, KNOTS = 24 };

/* ---- bodies and tools ---- */

typedef struct place {
    const char *scene;
    double touch[3], in[3], side[3]; /* m, of the surface; unit */
    double depth;                    /* m, of a press */
    bool has_friction;
    double limit; /* N, well within that press */
} place;

static const place places[] = {
    {"kidney.yaml", AT(0, 0.006, 0.0223, 0, 0, -1, 1, 0, 0), 0.014, true, 0.7},
    {"liver.yaml", AT(-0.035, 0, 0.042, 0, 0, -1, 1, 0, 0), 0.014, true, 0.3},
    {"kidney-tissue.yaml", AT(0, 0.006, 0.0223, 0, 0, -1, 1, 0, 0), 0.008, true, 0.5},
    {"ventricle.yaml", AT(0.032, 0, -0.01, -1, 0, 0, 0, 1, 0), 0.012, true, 0.5},
    {"liver-chainmail.yaml", AT(-0.035, 0, 0.042, 0, 0, -1, 1, 0, 0), 0.014, false, 0.5},
    {"hm1-tissue.yaml", AT(0.0315, 0, -0.005, -1, 0, 0, 0, 1, 0), 0.010, true, 0.5},
    {"liver-tissue.yaml", AT(-0.035, 0, 0.042, 0, 0, -1, 1, 0, 0), 0.010, true, 0.4},
    {"kidney-nodule.yaml", AT(0, 0.006, 0.0223, 0, 0, -1, 1, 0, 0), 0.010, true, 0.5},
};
enum { PLACES = sizeof places / sizeof *places };

typedef struct tool {
    const char *shape;
    double reach; /* m, along z */
} tool;

static const tool tools[] = {
    {"sphere: {radius_mm: 6}", 0.006},
    {"cone: {radius_mm: 6, length_mm: 14}", 0.007},
    {"capsule: {radius_mm: 4, length_mm: 12}", 0.010},
    {"box: {size_mm: [20, 12, 8]}", 0.004},
};
enum { TOOLS = sizeof tools / sizeof *tools };

/* ---- a way ---- */

typedef struct knot {
    int tick;
    double depth, side, up;      /* m */
    double twist, tilt, sideway; /* rad: about the tool's axis, and about the two across it */
    double limit;                /* N, from here on */
} knot;

typedef struct way {
    const place *place;
    const tool *tool;
    double friction;
    double rate_hz;
    bool is_changing; /* the limit */
    knot knot[KNOTS];
} way;

static way make_way(int number)
{
    uint64_t random = 1000 + (uint64_t)number;
    way w = {.place = &places[number % PLACES], .tool = &tools[number / PLACES % TOOLS]};
    static const double frictions[] = {0.0, 0.3, 0.0, 0.6};
    static const double rates[] = {1000.0, 1000.0, 300.0, 100.0};
    w.friction = w.place->has_friction ? frictions[number / (PLACES * TOOLS) % 4] : 0.0;
    w.rate_hz = rates[ss_random_below(&random, 4)];
    w.is_changing = ss_random_below(&random, 3) == 0;
    const double limit = w.place->limit * (0.6 + 0.8 * ss_random_unit(&random));
    w.knot[0] = (knot){.depth = -0.004, .limit = limit};
    for (int k = 1; k < KNOTS; ++k) {
        const knot *before = &w.knot[k - 1];
        knot *now = &w.knot[k];
        const uint32_t kind = ss_random_below(&random, 5);
        *now = *before;
        now->tick = before->tick + 150 + (int)ss_random_below(&random, 350);
        if (k == 1 || kind == 0) {
            now->depth = w.place->depth * (0.5 + 0.5 * ss_random_unit(&random));
        } else if (kind == 1) {
            now->side = 0.006 * ss_random_signed(&random);
            now->up = 0.006 * ss_random_signed(&random);
        } else if (kind == 2) {
            now->twist = 0.5 * ss_random_signed(&random);
            now->tilt = 0.4 * ss_random_signed(&random);
            now->sideway = 0.4 * ss_random_signed(&random);
        } else if (kind == 3) {
            now->depth = before->depth > 0.0 ? -0.004 : 0.8 * w.place->depth;
        } else if (w.is_changing) {
            now->limit = limit * (0.5 + 1.5 * ss_random_unit(&random));
        }
    }
    return w;
}

/* In tick n. The limit is first one out of reach: no command raises it above the scene's. */
static softsim_pose pose_on(const way *w, int n, double *out_depth, double *out_limit)
{
    static const double up[3] = {0.0, 0.0, 1.0}, plain[4] = {1.0, 0.0, 0.0, 0.0};
    int k = 0;
    while (k + 2 < KNOTS && w->knot[k + 1].tick <= n) {
        ++k;
    }
    const knot *a = &w->knot[k], *b = &w->knot[k + 1];
    const double u = smooth((double)(n - a->tick) / (b->tick - a->tick));
    const double *in = w->place->in, *side = w->place->side;
    double third[3], x[3], turn[3], upright[4], tilted[4], axis[3];
    ss_cross3(third, in, side);
    *out_depth = a->depth + u * (b->depth - a->depth);
    *out_limit = a->limit;
    ss_madd3(x, w->place->touch, *out_depth - w->tool->reach, in);
    ss_madd3(x, x, a->side + u * (b->side - a->side), side);
    ss_madd3(x, x, a->up + u * (b->up - a->up), third);
    softsim_pose pose = pose_of(n + 1, x);
    ss_cross3(axis, up, in);
    const double sine = ss_normalize3(axis);
    ss_scale3(turn, sine > 0.0 ? axis : side, atan2(sine, in[2]));
    ss_turn(plain, turn, upright);
    ss_scale3(turn, side, a->tilt + u * (b->tilt - a->tilt));
    ss_madd3(turn, turn, a->sideway + u * (b->sideway - a->sideway), third);
    ss_turn(upright, turn, tilted);
    ss_scale3(turn, in, a->twist + u * (b->twist - a->twist));
    ss_turn(tilted, turn, pose.orientation);
    return pose;
}

static softsim_world *make(const way *w)
{
    char path[512], shape[128], rate[64], friction[64];
    (void)snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s", w->place->scene);
    (void)snprintf(shape, sizeof shape, "contact.tools=[{probe: 0, shape: {%s}}]", w->tool->shape);
    (void)snprintf(rate, sizeof rate, "simulation.rate_hz=%g", w->rate_hz);
    (void)snprintf(friction, sizeof friction, "contact.friction=%g", w->friction);
    const char *set[5] = {shape, rate, "haptic.max_force_n=100"};
    int32_t count = 3;
    if (w->friction > 0.0) {
        set[count++] = friction;
    }
    if (strcmp(w->place->scene, "kidney.yaml") == 0) {
        set[count++] = "object.mesh=" SMALL_MESH;
    }
    return open_scene(path, set, count);
}

static void go(const way *w, bool is_open, way_tick out[TICKS])
{
    softsim_world *world = make(w);
    softsim_pose last = {0};
    softsim_force force = {.seq = -1};
    for (int n = 0; n < TICKS; ++n) {
        way_tick *tick = &out[n];
        softsim_pose pose = pose_on(w, n, &tick->depth, &tick->limit);
        if (!is_open && (n == 0 || fabs(tick->limit - tick[-1].limit) > 0.0)) {
            set_limit(ss_world_of(world), tick->limit);
        }
        pose.force_seq = force.seq;
        force = feel(world, &pose);
        double slip[3];
        ss_sub3(slip, force.proxy, pose.position);
        ss_set3(tick->turn, 0.0, 0.0, 0.0);
        if (n > 0) {
            ss_turn_between(last.orientation, pose.orientation, tick->turn);
        }
        ss_copy3(tick->x, pose.position);
        ss_copy3(tick->force, force.force);
        ss_copy3(tick->torque, force.torque);
        tick->slip = ss_norm3(slip);
        tick->model = ss_norm3(force.model_force);
        tick->stiffness = force.stiffness;
        last = pose;
    }
    softsim_destroy(&world);
}

/* J: what a contact may hand out: 1 mJ, and more where the limit is raised under the hand. */
#define ENERGY         1e-3
#define ENERGY_CHANGED 5e-3
/* m: the proxy from the hand, beyond the depth of the press. */
#define SLIP 0.010

static bool is_good_way(int number)
{
    static way_tick tick[TICKS], open[TICKS];
    const way w = make_way(number);
    go(&w, false, tick);
    go(&w, true, open);
    const way_verdict v = judge_way(tick, open, TICKS);
    const char *faults =
        way_faults(&v, w.is_changing ? ENERGY_CHANGED : ENERGY, w.place->depth + SLIP);
    print_message("%d %s %.4s mu %g %g Hz L %.3f%s: %d judged, |F|/L %.4f (%d)..%.6f, turn %.2f "
                  "(%d), step %.4f (%d), %.2f mJ, %.1f mm%s%s\n",
                  number, w.place->scene, w.tool->shape, w.friction, w.rate_hz, w.knot[0].limit,
                  w.is_changing ? " changed" : "", v.judged, v.least, v.at_least, v.most, v.turn,
                  v.at_turn, v.step, v.at_step, 1e3 * v.energy, 1e3 * v.slip,
                  *faults ? ": BAD " : "", faults);
    return *faults == '\0';
}

/* One of a sphere without friction, a capsule and cones with it: what is light. */
static const int short_form[] = {0, 48, 104, 168};
enum { SHORT = sizeof short_form / sizeof *short_form };
static int first, count;

TEST(random_ways_keep_to_the_limit)
{
    int bad = 0;
    for (int k = 0; k < count; ++k) {
        bad += !is_good_way(first < 0 ? short_form[k] : first + k);
    }
    print_message("%d ways, %d bad\n", count, bad);
    assert_int_equal(bad, 0);
}

int main(int argc, char **argv)
{
    const bool is_all = argc > 1 && strcmp(argv[1], "all") == 0;
    first = !is_all ? -1 : argc > 2 ? atoi(argv[2]) : 0;
    count = !is_all ? FULL_IN_RELEASE(SHORT, 1) : argc > 3 ? atoi(argv[3]) - first : 128;
    return run_all_tests(NULL, NULL);
}
