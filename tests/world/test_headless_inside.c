/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Contact keeps a tool out of the tissue, whichever of the two moves. Where it is too soft for
 * that, a tool gets in through the surface, which holds it off no longer: whoever looks at the
 * verdict, the depth or the flags is told so for as long as it is in. */
#include "common/test.h"

#include <stdlib.h>

#include "common/effort.h"
#include "press_fixture.h"
#include "rt/vec.h"

#define SOFT "  youngs_modulus_pa: 10000\n  density_kg_m3: 1060\n  mass_damping_per_s: 30\n"

#define RADIUS 0.008
static const double size_mm[3] = {80.0, 80.0, 40.0};

/* A press of a tool of 8 mm radius straight down on a block of size_mm. */
typedef struct press {
    const char *name, *model;
    double held;         /* m: the block up to there */
    double speed, depth; /* m/s, m */
} press;

#define HYBRID                                                                                     \
    "  name: hybrid\n" SOFT                                                                        \
    "  poisson_ratio: 0.45\n  layer: {spacing_m: 0.006, thickness_m: -0.010}\n"
#define MASS_SPRING "  name: mass-spring\n" SOFT

static const press presses[] = {
    {"hybrid, slowly", HYBRID, 0.015, 0.04, 0.022},
    {"mass-spring, fast", MASS_SPRING, 0.0005, 3.0, 0.018},
};
enum { PRESSES = sizeof presses / sizeof *presses };

/* N/m^3: a fortieth of what those contacts choose for themselves. */
#define TOO_SOFT "  stiffness_n_per_m3: 1.0e+6\n"

/* The block with a ball of 8 mm; `rest` continues the contact's lines. */
static softsim_world *make_block(const char *fixed, const char *model, const char *contact,
                                 const char *rest)
{
    char text[1024];
    (void)snprintf(text, sizeof text,
                   "softsim: 1\n"
                   "object:\n  mesh: block.msh\n  units: mm\n%s"
                   "model:\n%s"
                   "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]\n%s%s",
                   fixed, model, contact, rest);
    return open_scene(write_text("scene.yaml", text), NULL, 0);
}

static softsim_world *make_press(const press *one, const char *contact)
{
    char fixed[80];
    (void)snprintf(fixed, sizeof fixed, "  fixed: [{box_m: [[-1, -1, -1], [1, 1, %g]]}]\n",
                   one->held);
    return make_block(fixed, one->model, contact, "haptic: {max_force_n: 5}\n");
}

/* How often the deformed surface, its nodes at `x`, winds about a point: 1 inside, 0 outside. Solid
 * angles (van Oosterom and Strackee 1983). */
static double winding(softsim_world *world, double (*x)[3], const double p[3])
{
    const int32_t(*triangle)[3] = softsim_triangles(world);
    double sum = 0.0;
    for (int32_t t = 0; t < softsim_triangle_count(world); ++t) {
        double r[3][3], l[3];
        for (int k = 0; k < 3; ++k) {
            for (int a = 0; a < 3; ++a) {
                r[k][a] = x[triangle[t][k]][a] - p[a];
            }
            l[k] = sqrt(r[k][0] * r[k][0] + r[k][1] * r[k][1] + r[k][2] * r[k][2]);
        }
        double dot[3];
        for (int k = 0; k < 3; ++k) {
            const double *b = r[(k + 1) % 3], *c = r[(k + 2) % 3];
            dot[k] = b[0] * c[0] + b[1] * c[1] + b[2] * c[2];
        }
        const double volume = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) +
                              r[0][1] * (r[1][2] * r[2][0] - r[1][0] * r[2][2]) +
                              r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
        sum += atan2(volume, l[0] * l[1] * l[2] + dot[0] * l[0] + dot[1] * l[1] + dot[2] * l[2]);
    }
    return sum / (2.0 * SS_PI);
}

/* In how many of `p` and its six neighbours at contact's doubt (its smooth surface lies under the
 * mesh) the mesh winds about; 0 or 7 where there is no doubt. */
static int count_inside(softsim_world *world, const double p[3])
{
    softsim_state s;
    softsim_read(world, &s);
    double(*node)[3] = calloc((size_t)s.node_count, sizeof *node);
    assert_non_null(node);
    softsim_read_nodes(world, node, NULL, NULL);
    int count = 0;
    for (int k = 0; k < 7; ++k) {
        double x[3] = {p[0], p[1], p[2]};
        if (k > 0) {
            x[(k - 1) / 2] += k % 2 ? 0.003 : -0.003;
        }
        count += winding(world, node, x) > 0.5;
    }
    free(node);
    return count;
}

/* By a reason that is right whether or not something in there, such as the far side's surface,
 * presses on the tool. */
static bool is_told(softsim_world *world, const softsim_force *force)
{
    softsim_state now;
    softsim_read(world, &now);
    return now.verdict == SOFTSIM_VERDICT_DEGRADED &&
           strstr(now.reason, "inside the tissue, through the surface") != NULL &&
           (force->flags & SOFTSIM_FORCE_CONTACT) != 0 && force->depth > RADIUS &&
           force->depth <= 1e-3 * size_mm[2];
}

/* What comes of a press. A look is at every fifth tick; a result is a step old, so that only what
 * has been so for 20 ms counts. */
typedef struct outcome {
    int inside, inside_at_rest; /* looks; at rest: the last 100 of 300 ms at full depth */
    int wrong;                  /* looks at which the world tells something else */
    double least_at_rest;       /* N, upwards */
    double largest_drop;        /* N in a tick, on the way in */
    bool is_out;                /* at the end */
} outcome;

/* In from 40 mm above, held for 0.3 s, and back. */
static outcome run_press(const press *one, const char *contact)
{
    static const int cells[3] = {7, 7, 4};
    outcome out = {.least_at_rest = (double)INFINITY};
    write_box_mesh(cells, size_mm);
    softsim_world *world = make_press(one, contact);
    const int way = (int)ceil(1e3 * (one->depth + 0.04) / one->speed);
    int inside = 0, outside = 0;
    double before = 0.0;
    for (int n = 0; n < 2 * way + 600; ++n) {
        const int moved = n < way ? n : n < way + 300 ? way : 2 * way + 300 - n;
        const double x[3] = {0.003, 0.002,
                             0.088 - fmin(1e-3 * one->speed * moved, one->depth + 0.04)};
        const softsim_pose pose = pose_of(n + 1, x);
        const softsim_force force = feel(world, &pose);
        const bool is_at_rest = n >= way + 200 && n < way + 300;
        out.least_at_rest =
            is_at_rest ? fmin(out.least_at_rest, force.force[2]) : out.least_at_rest;
        out.largest_drop =
            n < way ? fmax(out.largest_drop, before - force.force[2]) : out.largest_drop;
        before = force.force[2];
        if (n % 5 == 0) {
            const int count = count_inside(world, force.proxy);
            inside = count == 7 ? inside + 1 : 0;
            outside = count == 0 ? outside + 1 : 0;
            out.inside += inside > 4;
            out.inside_at_rest += inside > 4 && is_at_rest;
            out.wrong +=
                (inside > 4 && !is_told(world, &force)) || (outside > 4 && is_told(world, &force));
        }
    }
    out.is_out = outside > 4;
    softsim_destroy(&world);
    print_message("%s: inside in %d looks, told wrongly in %d; at least %.3g N at rest, drops of "
                  "%.3g N at most\n",
                  one->name, out.inside, out.wrong, out.least_at_rest, out.largest_drop);
    return out;
}

TEST(a_tool_inside_the_tissue_is_told)
{
    for (int k = 0; k < PRESSES; ++k) {
        const outcome out = run_press(&presses[k], TOO_SOFT);
        assert_int_equal(out.inside_at_rest, 20);
        assert_int_equal(out.wrong, 0);
        assert_true(out.is_out);
    }
}

/* The block pushes back for as long as the tool is pressed into it. */
TEST(a_tool_stays_outside)
{
    for (int k = FULL_IN_RELEASE(0, PRESSES - 1); k < PRESSES; ++k) {
        const outcome out = run_press(&presses[k], "");
        assert_int_equal(out.inside, 0);
        assert_int_equal(out.wrong, 0);
        assert_true(out.least_at_rest > 0.3);
        assert_true(out.is_out);
    }
}

/* ---- tissue that comes to the tool ---- */

/* A free block of 40 x 40 x 20 mm that falls upwards, or that its driven lower part lifts. */
typedef struct fall {
    const char *name, *model, *drive;
} fall;

#define GRAVITY "gravity_m_s2: [0, 0, 2]\n"
#define DRIVEN                                                                                     \
    "prescribed: [{box_m: [[-1, -1, -1], [1, 1, 0.0134]], displacement_m: [0, 0, 0.027], "         \
    "ramp_s: 0.25}]\n"
#define LIGHT                                                                                      \
    "  youngs_modulus_pa: 10000\n  poisson_ratio: 0.3\n  density_kg_m3: 1060\n"                    \
    "  mass_damping_per_s: 3\n"

static const fall falls[] = {
    {"fem", "  name: fem\n" LIGHT, GRAVITY},
    {"corotational", "  name: corotational\n" LIGHT, GRAVITY},
    {"xpbd", "  name: xpbd\n" LIGHT, GRAVITY},
    {"mass-spring",
     "  name: mass-spring\n  youngs_modulus_pa: 10000\n  density_kg_m3: 1060\n"
     "  mass_damping_per_s: 3\n",
     GRAVITY},
    {"hybrid", "  name: hybrid\n" LIGHT "  layer: {spacing_m: 0.005, thickness_m: -0.006}\n",
     GRAVITY},
    {"cnn-energy",
     "  name: cnn-energy\n  modulus_j: 5\n  area_density_kg_m2: 11.5\n"
     "  damping_n_s_per_m3: 35\n  rest_stiffness_n_per_m3: 100\n",
     GRAVITY},
    {"cnn-chainmail", "  name: cnn-chainmail\n", DRIVEN},
    {"chainmail", "  name: chainmail\n", DRIVEN},
};

typedef struct meeting {
    double impulse; /* N s, upwards */
    int inside;     /* ticks that the tool's middle had been in the tissue for 20 ms */
    int unsaid;     /* of them, told something else */
} meeting;

/* The tool's middle stays 30 mm above the block, but for a sway of `sway` (m) to and fro. */
static meeting meet(const fall *one, const char *contact, double sway)
{
    static const int cells[3] = {6, 6, 3};
    static const double size[3] = {40.0, 40.0, 20.0};
    meeting out = {0};
    write_box_mesh(cells, size);
    softsim_world *world = make_block("", one->model, contact, one->drive);
    int inside = 0;
    for (int n = 0; n < 300; ++n) {
        const double x[3] = {0.001 + sway * sin(0.05 * n), 0.002, 0.05};
        const softsim_pose pose = pose_of(n + 1, x);
        const softsim_force force = feel(world, &pose);
        out.impulse += 1e-3 * force.force[2];
        inside = count_inside(world, force.proxy) == 7 ? inside + 1 : 0;
        out.inside += inside > 20;
        out.unsaid += inside > 20 && !is_told(world, &force);
    }
    softsim_destroy(&world);
    return out;
}

/* As much as by a tool that sways further than the path_slack, and so searches again. */
TEST(tissue_that_comes_to_a_still_tool_is_felt)
{
    for (size_t k = 0; k < sizeof falls / sizeof *falls;
         k += FULL_IN_RELEASE(1, sizeof falls / sizeof *falls)) {
        const meeting moving = meet(&falls[k], "", 0.0025), still = meet(&falls[k], "", 0.0);
        print_message("%s: %.3g N s on a moving tool, %.3g N s on a still one\n", falls[k].name,
                      moving.impulse, still.impulse);
        assert_true(moving.impulse > 0.002);
        assert_true(fabs(still.impulse - moving.impulse) < 0.2 * moving.impulse);
        assert_int_equal(moving.unsaid + still.unsaid, 0);
    }
}

TEST(a_still_tool_that_tissue_swallows_is_told)
{
    const meeting still = meet(&falls[0], "  stiffness_n_per_m3: 1.0e+5\n", 0.0);
    print_message("inside for %d ticks, told wrongly in %d\n", still.inside, still.unsaid);
    assert_true(still.inside > 0);
    assert_int_equal(still.unsaid, 0);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
