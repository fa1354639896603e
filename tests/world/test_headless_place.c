/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A tool that is found inside the tissue gets a place in it: within the entry ramp it is felt as
 * one that was pressed there from outside, and nothing but tissue is felt on the way.
 */
#include "common/test.h"

#include "common/effort.h"
#include "loops_fixture.h"
#include "press_fixture.h"
#include "rt/vec.h"

static const double LIMIT = 30.0; /* N: never reached */

/* ---- moved while nothing was felt ---- */

enum { RAMP = 20, ENTRY = 500 };

/* How it comes that a tool is found inside. */
typedef enum cause { MOVED_UNDER_PAUSE, MOVED_BEFORE_RESET, CAUSES } cause;

typedef struct visit {
    const body *b;
    double depth, side; /* m */
    cause why;
    heard way;
} visit;

static void at(const body *b, double depth, double side, double out[3])
{
    for (int a = 0; a < 3; ++a) {
        out[a] = b->touch[a] + depth * b->in[a] + side * b->side[a];
    }
}

/* A tool that was pressed in from outside. */
typedef struct pressing {
    softsim_world *world;
    double hand[3], proxy[3]; /* as it was pressed in */
    int32_t seq;
} pressing;

/* Along the side outside of the tissue, in within 0.6 s, and held. */
static pressing press_from_outside(const visit *v)
{
    pressing out = {.world = make_world(v->b, LIMIT)};
    for (int n = 0; n < 1000; ++n) {
        at(v->b, (v->depth + 0.030) * smooth(n / 600.0) - 0.030, v->side, out.hand);
        const softsim_pose pose = pose_of(++out.seq, out.hand);
        const softsim_force force = feel(out.world, &pose);
        ss_copy3(out.proxy, force.proxy);
    }
    return out;
}

/* The force where its proxy is at `proxy`: the hand goes to where that is so. Not the force where
 * the hand is at the same place: the coupling's spring between hand and proxy remembers the way
 * that it came (haptic/yield.c), and held the same tissue with 1270 N/m on one way and 7550 on
 * another (kidney, 12 mm). */
static void force_with_proxy_at(pressing *p, const double proxy[3], double out_force[3])
{
    softsim_force force = {.seq = 0};
    double off[3] = {INFINITY, INFINITY, INFINITY};
    for (int n = 0; n < 1000; ++n) {
        const softsim_pose pose = pose_of(++p->seq, p->hand);
        force = feel(p->world, &pose);
        ss_sub3(off, proxy, force.proxy);
        ss_madd3(p->hand, p->hand, 0.01, off);
    }
    assert_true(ss_norm3(off) < 1e-5);
    ss_copy3(out_force, force.force);
}

typedef struct visited {
    bool is_placed; /* in the model, in the end */
    double force[3], proxy[3];
    double rise, most; /* N: in a tick; of all */
    char reason[160];  /* of the worst verdict */
} visited;

enum { HELD = 1000, MOVED = 1200, RESUMED = 1300 };

static visited come_inside(const visit *v)
{
    softsim_world *world = make_world(v->b, LIMIT);
    const ss_world_probe *probe = &ss_world_of(world)->probe[0];
    visited out = {.rise = 0.0};
    softsim_state state;
    double last = 0.0;
    int late = 0;
    for (int n = 0; n < RESUMED + RAMP + ENTRY + 300; ++n) {
        double x[3];
        at(v->b, (v->depth + 0.030) * smooth(n / 600.0) - 0.030,
           v->side * smooth((n - HELD - 50) / (double)(MOVED - HELD - 50)), x);
        softsim_pose pose = pose_of(n + 1, x);
        pose.utime_us = 1000 * (int64_t)n;
        const bool is_pause = v->why == MOVED_UNDER_PAUSE;
        const char *name = is_pause && n == HELD ? "pause"
                           : n == RESUMED        ? is_pause ? "resume" : "reset"
                                                 : NULL;
        softsim_force force;
        if (v->way == LOCKSTEP) {
            if (name) {
                command(ss_world_of(world), name);
            }
            force = feel(world, &pose);
        } else {
            force = turn(ss_world_of(world), v->way, &pose, name, &late);
        }
        const double size = ss_norm3(force.force);
        if (n > RESUMED) {
            out.rise = fmax(out.rise, size - last);
            out.most = fmax(out.most, size);
        }
        last = size;
        ss_copy3(out.force, force.force);
        ss_copy3(out.proxy, force.proxy);
    }
    softsim_read(world, &state);
    out.is_placed = probe->was_present;
    (void)snprintf(out.reason, sizeof out.reason, "%s", state.worst_reason);
    softsim_destroy(&world);
    return out;
}

/* Did the tool come to be felt as one that was pressed there? */
static bool is_felt(const visit *v, pressing *presser)
{
    const visited in = come_inside(v);
    double outside[3], off[3], apart[3];
    force_with_proxy_at(presser, in.proxy, outside);
    ss_sub3(apart, in.proxy, presser->proxy);
    ss_sub3(off, in.force, outside);
    const double size = ss_norm3(outside), share = ss_norm3(off) / size;
    const bool is_good = share < 0.02 && ss_norm3(apart) < 2.5e-3 && in.is_placed &&
                         in.rise < 0.05 * size && in.most < 1.1 * size &&
                         strstr(in.reason, "found inside") == NULL;
    print_message("%s %.0f mm deep, %.0f mm aside, %s, heard %d: %s, %.3f N (%.1f %% off %.3f N), "
                  "at most %.3f, %.4f up a tick, %s%s\n",
                  v->b->name, 1e3 * v->depth, 1e3 * v->side,
                  v->why == MOVED_UNDER_PAUSE ? "resumed" : "reset", (int)v->way,
                  in.is_placed ? "placed" : "not placed", ss_norm3(in.force), 1e2 * share, size,
                  in.most, in.rise, in.reason, is_good ? "" : ": BAD");
    return is_good;
}

/* A ventricle that is pressed by more than its wall is thick, too: out the way that it came. Each
 * body from one side, in a long run from all. */
TEST(a_tool_that_moved_is_felt_as_one_that_was_pressed)
{
    SKIP_WHERE_REPEATED();
    enum { VISITED = 3, SIDES = 5 };
    static const int body_of[VISITED] = {0, 2, 4};
    static const double depths[] = {0.012, 0.008},
                        sides[SIDES] = {0.0, 0.020, 0.005, 0.010, -0.010};
    const int depth_count = FULL_IN_LONG_RUN(2, 1);
    const int side_count = FULL_IN_LONG_RUN(SIDES, 1);
    const int way_count = FULL_IN_LONG_RUN(ORDERS, 1);
    bool is_good = true;
    for (int n = 0; n < VISITED * depth_count * side_count; ++n) {
        const int k = n % VISITED;
        visit v = {.b = &bodies[body_of[k]],
                   .depth = depths[n / VISITED % depth_count],
                   .side = sides[(n / VISITED / depth_count + k) % SIDES]};
        pressing outside = press_from_outside(&v);
        for (int why = 0; why < CAUSES; ++why) {
            if (k > 0 && FULL_IN_LONG_RUN(false, why != k % CAUSES)) {
                continue; /* one cause for what is dear */
            }
            for (int way = 0; way < way_count; ++way) {
                v.why = (cause)why;
                v.way = (heard)way;
                is_good = is_felt(&v, &outside) && is_good;
            }
        }
        softsim_destroy(&outside.world);
    }
    assert_true(is_good);
}

/* ---- silent for a while ---- */

/* Pressed in, silent for so long, and there again. `out_before` and `out_after`: N, along the press
 * against the hand. */
static void fall_silent(const body *b, double depth, double limit, int silence, double *out_before,
                        double *out_after)
{
    softsim_world *world = make_world(b, limit);
    int late = 0;
    for (int n = 0; n < HELD + silence + RAMP + ENTRY + 300; ++n) {
        double x[3];
        at(b, (depth + 0.030) * smooth(n / 600.0) - 0.030, 0.0, x);
        const softsim_pose pose = pose_of(n + 1, x);
        const bool is_silent = n >= HELD && n < HELD + silence;
        const softsim_force force =
            turn(ss_world_of(world), SIMULATION_FIRST, is_silent ? NULL : &pose, NULL, &late);
        *(n < HELD ? out_before : out_after) = -ss_dot3(force.force, b->in);
    }
    softsim_destroy(&world);
}

/* Nearer to the far side of what it was pressed through, it is not let out there. (The kidney, 20
 * mm deep, rests in two ways that differ by 6 %.) */
TEST(a_device_that_fell_silent_goes_out_the_way_it_came)
{
    SKIP_WHERE_REPEATED();
    static const int body_of[] = {2, 0, 6};
    static const double limits[] = {30.0, 1.0};
    for (int k = 0; k < FULL_IN_RELEASE(6, 2); ++k) {
        const body *b = &bodies[body_of[k / 2]];
        double before = 0.0, after = 0.0;
        fall_silent(b, b->depth, limits[k % 2], 60, &before, &after);
        print_message("%s, limit %g N: %.3f N, after a silence %.3f N\n", b->name, limits[k % 2],
                      before, after);
        assert_true(fabs(after - before) < 0.1 * before);
    }
}

/* Pressed on top of the kidney and out again, a reset; the same device, which has been felt outside
 * meanwhile, or another one then comes to stand inside near its bottom. The most force against the
 * way out of there, N. */
static double come_elsewhere(bool is_other)
{
    enum { RESET = 900, SILENT = 1200, BACK = 1800, END = 2700 };
    const body *b = &bodies[0];
    softsim_world *world = make_bundled_world(b, 3.0);
    double most = 0.0;
    int late = 0;
    for (int n = 0; n < END; ++n) {
        const bool is_there = n < RESET || (n < SILENT && !is_other) || n >= BACK;
        double x[3];
        at(b, n < BACK ? 0.016 * (smooth(n / 300.0) - smooth((n - 500) / 300.0)) - 0.004 : 0.0393,
           0.0, x);
        softsim_pose pose = pose_of(n + 1, x);
        pose.sender += n >= BACK && is_other;
        const softsim_force force =
            turn(ss_world_of(world), SIMULATION_FIRST, is_there ? &pose : NULL,
                 n == RESET ? "reset" : NULL, &late);
        most = fmax(most, n >= BACK ? -ss_dot3(force.force, b->in) : 0.0);
        assert_true(n < END - 1 || ss_norm3(force.force) > 0.5);
    }
    softsim_destroy(&world);
    return most;
}

TEST(the_way_in_is_no_other_device_s_nor_that_of_another_place)
{
    SKIP_WHERE_REPEATED();
    assert_true(come_elsewhere(false) < 0.02);
    assert_true(come_elsewhere(true) < 0.02);
}

/* ---- pressed through ---- */

typedef enum restart { BY_RESET, BY_RESUME, RESTARTS } restart;

/* A cone, tip first, is pressed through the surface of soft tissue at 0.1 m/s and stays there for
 * 0.3 s; then the world starts again. Returns the most force into the tissue, N, at a tick that is
 * told to be good, and how many of them press so by more than 0.02 N. */
static double stay_through(double depth, restart by, int *out_count)
{
    enum { UP = 40, STAY = 300, PAUSE = 100, AFTER = 800 };
    static const body cone = {
        "cone",
        "kidney-tissue.yaml",
        NULL,
        "contact.tools=[{probe: 0, shape: {cone: {radius_mm: 5, length_mm: 15}}}]",
        {0, 0.006, 0.0281},
        {0, 0, -1},
        {1, 0, 0},
        0.0};
    const int restarted = UP + (int)(1e4 * depth) + STAY;
    softsim_world *world = make_world(&cone, 2.0);
    double most = 0.0;
    *out_count = 0;
    for (int n = 0; n < restarted + PAUSE + AFTER; ++n) {
        double x[3];
        at(&cone, fmin(depth, 1e-4 * (n - UP)), 0.0, x);
        softsim_pose pose = pose_of(n + 1, x);
        pose.orientation[0] = 0.0;
        pose.orientation[1] = 1.0;
        if (n == restarted && by == BY_RESUME) {
            command(ss_world_of(world), "pause");
        } else if (n == restarted + PAUSE) {
            command(ss_world_of(world), by == BY_RESUME ? "resume" : "reset");
        }
        const softsim_force force = feel(world, &pose);
        softsim_state now;
        softsim_read(world, &now);
        const double inward = ss_dot3(force.force, cone.in);
        if (n > restarted + PAUSE && now.verdict == SOFTSIM_VERDICT_GOOD) {
            most = fmax(most, inward);
            *out_count += inward > 0.02;
        }
    }
    softsim_destroy(&world);
    return most;
}

/* What presses on it in there says nothing of where it came from. */
TEST(a_tool_that_went_through_is_not_drawn_in_after_a_restart)
{
    SKIP_WHERE_REPEATED();
    static const double depths[] = {0.017, 0.015, 0.020};
    bool is_good = true;
    for (int k = 0; k < FULL_IN_LONG_RUN(3, 1); ++k) {
        for (int by = 0; by < FULL_IN_RELEASE(RESTARTS, 1); ++by) {
            int count = 0;
            const double most = stay_through(depths[k], (restart)by, &count);
            print_message("%.0f mm deep, %s: %.3f N inward at most, %d ticks%s\n", 1e3 * depths[k],
                          by == BY_RESET ? "reset" : "resumed", most, count,
                          count > 0 ? ": BAD" : "");
            is_good = is_good && count == 0;
        }
    }
    assert_true(is_good);
}

/* ---- a touch just after ---- */

/* Down from `above` at `speed`, `wait` ticks after the first pose; forces from then on. */
enum { APPROACH = 120 };
static void approach(const body *b, double above, double speed, int wait,
                     double out_force[APPROACH])
{
    softsim_world *world = make_world(b, LIMIT);
    for (int n = 0; n < wait + APPROACH; ++n) {
        double x[3];
        at(b, fmin(0.006, 1e-3 * speed * (n > wait ? n - wait : 0) - above), 0.0, x);
        const softsim_pose pose = pose_of(n + 1, x);
        const softsim_force force = feel(world, &pose);
        if (n >= wait) {
            out_force[n - wait] = ss_norm3(force.force);
        }
    }
    softsim_destroy(&world);
}

/* It is outside that it comes from: a touch in the first 0.1 s is felt as one that comes later. */
TEST(a_touch_just_after_the_first_pose_is_felt)
{
    SKIP_WHERE_REPEATED();
    static const body touched[] = {
        {"kidney", "kidney.yaml", NULL, NULL, {0, 0.006, 0.0273}, {0, 0, -1}, {1, 0, 0}, 0.0},
        {"liver", "liver.yaml", NULL, NULL, {-0.035, 0, 0.050}, {0, 0, -1}, {1, 0, 0}, 0.0},
        {"hm1", "hm1-tissue.yaml", NULL, NULL, {0.0385, 0, -0.005}, {-1, 0, 0}, {0, 1, 0}, 0.0},
    };
    static const double heights[] = {0.006, 0.015}, speeds[] = {0.3, 0.6};
    bool is_good = true;
    for (int n = 0; n < 3 * FULL_IN_LONG_RUN(4, 1); ++n) { /* each height and speed of a body */
        const body *b = &touched[n % 3];
        const double above = heights[(n / 3 + n % 3) % 2], speed = speeds[(n + n / 3 + n / 6) % 2];
        double at_once[APPROACH], later[APPROACH], most = 0.0, off = 0.0;
        approach(b, above, speed, 0, at_once);
        approach(b, above, speed, 400, later);
        for (int k = 0; k < APPROACH; ++k) {
            most = fmax(most, later[k]);
            off = fmax(off, fabs(at_once[k] - later[k]));
        }
        /* The limit of stiffness follows the loop's delay within a second. */
        const bool is_one = off <= 0.05 * most;
        print_message("%s from %.0f mm at %.1f m/s: at most %.3f N, %.2f %% off%s\n", b->name,
                      1e3 * above, speed, most, 1e2 * off / most, is_one ? "" : ": BAD");
        is_good = is_good && is_one;
    }
    assert_true(is_good);
}

/* ---- out again ---- */

/* Where tool 0 just touches the body: over its outermost free node along x, from outside. */
static void find_touch(const ss_world *world, double out[3], double out_in[3])
{
    const ss_mesh *mesh = world->scene->mesh;
    int32_t best = -1;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (world->scene->fixed[i] == 0 &&
            (best < 0 || mesh->position[i][0] > mesh->position[best][0])) {
            best = i;
        }
    }
    assert_true(best >= 0);
    ss_copy3(out, mesh->position[best]);
    out[0] += ss_shape_inradius(&world->scene->tool[0].shape);
    ss_set3(out_in, -1.0, 0.0, 0.0);
}

enum { COUPLED = 8 }; /* ticks: three times the damper's over the spring */

typedef struct escape {
    double most, inward; /* N, of the force; and of its part into the tissue */
    int felt;            /* ticks after the hand was out, with a force */
    int late;            /* of them, a ramp's time after the coupling, too, was out */
} escape;

/* Found 6 mm deep, and pulled out at 2 m/s after `stay` ticks. */
static escape pull_out(const char *scene, int stay)
{
    char path[512];
    (void)snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s.yaml", scene);
    softsim_world *world = open_scene(path, NULL, 0);
    double touch[3], in[3];
    escape out = {.most = 0.0};
    find_touch(ss_world_of(world), touch, in);
    for (int n = 0; n < stay + 100; ++n) {
        const double depth = 0.006 - 0.002 * (n > stay ? n - stay : 0);
        double x[3];
        ss_madd3(x, touch, fmax(depth, -0.06), in);
        const softsim_pose pose = pose_of(n + 1, x);
        const softsim_force force = feel(world, &pose);
        const double size = ss_norm3(force.force);
        out.most = fmax(out.most, size);
        out.inward = fmax(out.inward, -ss_dot3(force.force, force.normal));
        out.felt += depth < 0.0 && size > 0.0;
        out.late += depth < -0.002 * (RAMP + COUPLED) && size > 0.0;
    }
    softsim_destroy(&world);
    return out;
}

/* A tool that is let in and pulled away is let go: nothing draws it back, and what is left of the
 * force is gone within a ramp. */
TEST(a_tool_that_is_pulled_out_is_let_go)
{
    SKIP_WHERE_REPEATED();
    static const char *const scenes[] = {"kidney",
                                         "ventricle",
                                         "liver",
                                         "liver-chainmail",
                                         "cylinder",
                                         "hm1-tissue",
                                         "ed0",
                                         "ed0-tissue",
                                         "hm2",
                                         "hm2-tissue",
                                         "cylinder-grid",
                                         "kidney-nodule",
                                         "kidney-anisotropic",
                                         "kidney-tissue",
                                         "liver-tissue",
                                         "hm1"};
    static const int stays[] = {250, 100, 450, 520};
    const int stay_count = FULL_IN_LONG_RUN(4, 1);
    bool is_good = true;
    double most = 0.0;
    for (int k = 0; k < FULL_IN_LONG_RUN(16, 15); ++k) { /* the last is large, and hardly felt */
        for (int n = k; n < k + stay_count; ++n) {
            const escape one = pull_out(scenes[k], stays[n % 4]);
            const bool is_one = one.inward <= 0.0 && one.late == 0;
            most = fmax(most, one.most);
            print_message("%s after %d ticks: at most %.3f N, %.3g N inward, %d ticks felt "
                          "outside, %d late%s\n",
                          scenes[k], stays[n % 4], one.most, one.inward, one.felt, one.late,
                          is_one ? "" : ": BAD");
            is_good = is_good && is_one;
        }
    }
    assert_true(most > 0.0);
    assert_true(is_good);
}

/* ---- in a cavity ---- */

/* A block of 80 mm with a hollow of 40 mm. */
static softsim_world *make_hollow(double radius_mm)
{
    static const int cells[3] = {8, 8, 8};
    static const double size[3] = {80.0, 80.0, 80.0};
    char text[512];
    (void)snprintf(text, sizeof text,
                   "softsim: 1\n"
                   "object:\n  mesh: block.msh\n  units: mm\n"
                   "  fixed: [{box_m: [[-1, -1, -1], [1, 1, 0.001]]}]\n"
                   "model:\n  name: mass-spring\n  youngs_modulus_pa: 10000\n"
                   "  density_kg_m3: 1060\n  mass_damping_per_s: 30\n"
                   "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: %g}}}]}\n",
                   radius_mm);
    write_hollow_mesh(cells, size, 4);
    return open_scene(write_text("hollow.yaml", text), NULL, 0);
}

/* A ball that stands still in the middle of the hollow. */
static softsim_force stand_in_a_hollow(double radius_mm, softsim_state *out_state)
{
    softsim_world *world = make_hollow(radius_mm);
    softsim_force force = {.seq = 0};
    for (int n = 0; n < 200; ++n) {
        const softsim_pose pose = pose_of(n + 1, (const double[3]){0.0, 0.0, 0.040});
        force = feel(world, &pose);
        assert_true(ss_norm3(force.force) <= 0.0);
    }
    softsim_read(world, out_state);
    softsim_destroy(&world);
    return force;
}

/* It is not in the tissue: nothing is pressed, nothing told. */
TEST(a_tool_in_a_cavity_is_free)
{
    softsim_state now;
    const softsim_force force = stand_in_a_hollow(8.0, &now);
    assert_int_equal(now.worst_verdict, SOFTSIM_VERDICT_GOOD);
    assert_true(now.elastic_j <= 0.0 && now.kinetic_j <= 0.0);
    assert_int_equal(force.flags & ~SOFTSIM_FORCE_PREDICTED, 0);
    assert_true(force.depth <= 0.0);
}

/* One that is larger than the cavity is nowhere outside: it is not felt, and told. */
TEST(a_tool_without_a_place_is_told)
{
    softsim_state now;
    const softsim_force force = stand_in_a_hollow(26.0, &now);
    assert_int_equal(force.contact_count, 1);
    assert_true(force.depth > 0.005);
    assert_int_equal(now.verdict, SOFTSIM_VERDICT_DEGRADED);
    assert_non_null(strstr(now.reason, "no free place"));
    assert_true(now.elastic_j <= 0.0 && now.kinetic_j <= 0.0);
}

/* Looks are dear, and one that found nothing is likely to again: eight in 2.5 s, at 0, 20, 60, 140,
 * 300, 620, 1260 and 2260 ms. A tool that comes out is in the world within 20 ms all the same. */
TEST(a_place_is_looked_for_ever_less_often)
{
    softsim_world *world = make_hollow(26.0);
    const ss_world_probe *probe = &ss_world_of(world)->probe[0];
    int looks = 0, n = 0, came = 0;
    int64_t last = 0;
    for (; n < 2500; ++n) {
        const softsim_pose pose = pose_of(n + 1, (const double[3]){0.0, 0.0, 0.040});
        (void)feel(world, &pose);
        looks += probe->next_search != last;
        last = probe->next_search;
        assert_false(probe->was_present);
    }
    assert_in_range(looks, 7, 8);
    /* At 1 m/s; it is out after 66 mm. */
    for (; !probe->was_present && came < 1000; ++n, ++came) {
        const softsim_pose pose = pose_of(n + 1, (const double[3]){0.0, 0.0, 0.040 + 1e-3 * came});
        (void)feel(world, &pose);
    }
    /* One more step stands at it, and its target is of the step before. */
    assert_true(came <= 66 + 20 + 2);
    softsim_destroy(&world);
}

/* ---- places that tissue has left ---- */

/* A ball of 8 mm that comes to stand 4 mm clear of a block whose top goes down by 12 mm in 0.2 s.
 */
static void come_where_tissue_was(bool has_touched, bool is_reset, double *out_off,
                                  int32_t *out_ramping)
{
    static const int cells[3] = {8, 8, 4};
    static const double size[3] = {60.0, 60.0, 30.0};
    static const double high = 0.060, low = 0.030 - 0.012 + 0.008;
    write_box_mesh(cells, size);
    softsim_world *world = open_scene(
        write_text("lowered.yaml",
                   "softsim: 1\n"
                   "object:\n  mesh: block.msh\n  units: mm\n"
                   "  fixed: [{box_m: [[-1, -1, -1], [1, 1, 0.0001]]}]\n"
                   "model:\n  name: mass-spring\n  youngs_modulus_pa: 10000\n"
                   "  density_kg_m3: 1060\n  mass_damping_per_s: 30\n"
                   "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]}\n"
                   "prescribed:\n"
                   "  - {box_m: [[-1, -1, 0.0299], [1, 1, 1]], displacement_m: [0, 0, -0.012], "
                   "ramp_s: 0.2}\n"),
        NULL, 0);
    softsim_force force[SOFTSIM_MAX_PROBES];
    double most = 0.0;
    int32_t seq = 0;
    for (int n = 0; n < 1400; ++n) {
        const double in = smooth(n < 1000 ? (n - 400) / 400.0 : (1400 - n) / 400.0);
        const double x[3] = {0.0, 0.0, has_touched ? high + (low - 0.003 - high) * in : high};
        const softsim_pose pose = pose_of(++seq, x);
        most = fmax(most, ss_norm3(feel(world, &pose).force));
    }
    assert_true((most > 0.0) == has_touched);
    if (is_reset) {
        command(ss_world_of(world), "reset");
    }
    for (int n = 0; n < (is_reset ? 600 : 1000); ++n) {
        softsim_tick(world, NULL, NULL, 0, force);
    }
    *out_off = 0.0;
    *out_ramping = 0;
    for (int n = 0; n < 600; ++n) {
        const double x[3] = {0.0, 0.0, low + 0.004};
        const softsim_pose pose = pose_of(++seq, x);
        const softsim_force now = feel(world, &pose);
        *out_off = fmax(*out_off, fabs(now.proxy[2] - x[2]));
        *out_ramping += (now.flags & SOFTSIM_FORCE_RAMPING) != 0;
    }
    softsim_destroy(&world);
}

/* Tissue that has gone elsewhere of itself does not spring back to where it rested. */
TEST(a_tool_stands_where_tissue_was)
{
    static const char *const before[] = {"not touched", "touched", "touched and reset"};
    for (int k = FULL_IN_RELEASE(0, 2); k < 3; ++k) {
        double off = 0.0;
        int32_t ramping = 0;
        come_where_tissue_was(k > 0, k == 2, &off, &ramping);
        print_message("%s before: proxy off by %.2f mm, %d ticks ramping\n", before[k], 1e3 * off,
                      (int)ramping);
        assert_true(off < 1e-4);
        assert_int_equal(ramping, 0);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
