/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Tools on the body that Newtonian models share, under a law with closed forms: what a touch gives
 * and takes, the stiffness that is felt, grasps, a surface that rides on the nodes, and the same
 * bits from the same touch.
 */
#include "common/test.h"

#include "body_fixture.h"
#include "rt/hash.h"

static const ss_shape ball = {.kind = SS_SHAPE_SPHERE, .radius = 0.015};

/* ---- tools ---- */

static void tool_at(ss_model_tool *tool, double from, double to, double x)
{
    *tool = (ss_model_tool){.is_present = true};
    ss_set3(tool->from.position, x, 0.0, from);
    ss_set3(tool->to.position, x, 0.0, to);
    tool->from.orientation[0] = tool->to.orientation[0] = 1.0;
}

static void bench_with_ball(bench *b)
{
    bench_init(b);
    b->law.stiffness = 40.0;
    b->mass_damping = 30.0;
    b->s.plan.tool[0] = (ss_tool_plan){.is_used = true, .shape = ball};
}

/* Presses the ball from above by `depth` in `steps` steps from where it just touches. */
static void press(bench *b, ss_model_tool tool[SOFTSIM_MAX_PROBES], double depth, int steps)
{
    const double top = 0.03 + ball.radius;
    for (int k = 0; k < steps; ++k) {
        tool_at(tool, top - depth * k / steps, top - depth * (k + 1) / steps, 0.0);
        run(b, 1, 1e-3, tool);
    }
}

static void hold(bench *b, ss_model_tool tool[SOFTSIM_MAX_PROBES], int steps)
{
    tool[0].from = tool[0].to;
    run(b, steps, 1e-3, tool);
}

static ss_contact_set felt(bench *b)
{
    ss_contact_set set;
    ss_body_contacts(b->body, 0, 0.01, &set);
    return set;
}

/* A bench whose ball has been pressed in by 4 mm. */
static void bench_pressed(bench *b, ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    bench_with_ball(b);
    bench_make(b);
    press(b, tool, 4e-3, 100);
}

TEST(a_tool_gets_back_what_it_gives)
{
    for (int m = 0; m < 2; ++m) {
        bench b;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
        bench_with_ball(&b);
        b.law.integrator = methods[m];
        bench_make(&b);
        press(&b, tool, 5e-3, 100);
        hold(&b, tool, 600);
        const ss_contact_set set = felt(&b);
        double sum[3] = {0.0};
        for (int32_t i = 0; i < 64; ++i) {
            for (int k = 0; k < 3; ++k) {
                sum[k] += 40.0 * at(&b, i, k);
            }
        }
        /* At rest the springs carry all of it. */
        assert_true(set.force[2] > 0.1);
        assert_near(set.force[2], -sum[2], 1e-4 * set.force[2]);
        assert_near(set.contact[0].force, set.force[2], 1e-5 * set.force[2]);
        const ss_model_info info = told(&b);
        assert_near(balance(&b), 0.0, 0.005 * info.work);
        assert_int_equal(info.fault_bits, 0);
        /* Let go: everything comes back, and what was given is gone into damping. */
        press(&b, tool, -5e-3, 50);
        memset(tool, 0, sizeof tool);
        run(&b, 800, 1e-3, tool);
        assert_near(told(&b).elastic + told(&b).kinetic, 0.0, 1e-9);
        assert_near(balance(&b), 0.0, 0.01 * told(&b).dissipated + 1e-9);
        bench_fini(&b);
    }
}

TEST(the_felt_stiffness_errs_high_but_little)
{
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_contact_set set;
    bench_pressed(&b, tool);
    for (int k = 0; k < 600; ++k) {
        hold(&b, tool, 1);
        set = felt(&b);
    }
    const double z = tool[0].to.position[2];
    tool_at(tool, z, z - 1e-5, 0.0);
    run(&b, 1, 1e-3, tool);
    hold(&b, tool, 600);
    const ss_contact_set more = felt(&b);
    const double slope = (more.force[2] - set.force[2]) / 1e-5;
    assert_true(set.contact[0].stiffness > 0.97 * slope);
    assert_true(set.contact[0].stiffness < 1.1 * slope);
    assert_true(set.contact[0].viscosity > 0.0);
    bench_fini(&b);
}

/* The force on a ball pressed in by `depth` and held, its contact softer than the body. */
static double force_at_rest(double contact_stiffness, double depth)
{
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    bench_with_ball(&b);
    b.s.plan.contact_stiffness = contact_stiffness;
    bench_make(&b);
    press(&b, tool, depth, 100);
    hold(&b, tool, 600);
    const ss_contact_set set = felt(&b);
    bench_fini(&b);
    return set.force[2];
}

/* What a tool near the tissue is told is the stiffness of a touch as deep as it would go, half
 * of its way in a step: that of a tenth of its radius was up to 15 times too much. */
TEST(a_touch_to_come_is_as_stiff_as_it_will_be_deep)
{
    static const double way[] = {1e-3, 2e-3};
    const double contact_stiffness = 1e5;
    for (size_t k = 0; k < sizeof way / sizeof *way; ++k) {
        bench b;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
        const double top = 0.03 + ball.radius + 1e-3, depth = 0.5 * way[k];
        const double secant = force_at_rest(contact_stiffness, depth) / depth;
        bench_with_ball(&b);
        b.s.plan.contact_stiffness = contact_stiffness;
        bench_make(&b);
        tool_at(tool, top + way[k], top, 0.0);
        run(&b, 1, 1e-3, tool);
        const ss_contact_set near = felt(&b);
        assert_int_equal(near.count, 1);
        assert_true(near.contact[0].gap > 0.0);
        print_message("%g mm: %g N/m, told %g\n", 1e3 * depth, secant, near.contact[0].stiffness);
        /* A contact as the square of its depth has twice its secant. */
        assert_true(near.contact[0].stiffness > secant);
        assert_true(near.contact[0].stiffness < 2.5 * secant);
        bench_fini(&b);
    }
}

TEST(a_grasp_pulls_and_lets_go)
{
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    bench_pressed(&b, tool);
    tool[0].is_grasping = true;
    hold(&b, tool, 1);
    for (int k = 0; k < 100; ++k) {
        const double z = tool[0].to.position[2];
        tool_at(tool, z, z + 1e-4, 0.0);
        tool[0].is_grasping = true;
        run(&b, 1, 1e-3, tool);
    }
    hold(&b, tool, 300);
    ss_contact_set set = felt(&b);
    assert_true(set.is_held);
    assert_true(set.force[2] < -0.05);
    const double before = balance(&b);
    tool[0].is_grasping = false;
    hold(&b, tool, 100);
    set = felt(&b);
    assert_false(set.is_held);
    assert_near(set.force[2], 0.0, 1e-6);
    assert_near(balance(&b), before, 0.02 * told(&b).work);
    bench_fini(&b);
}

TEST(a_fast_tool_is_swept_and_does_not_tunnel)
{
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    bench_with_ball(&b);
    bench_make(&b);
    tool_at(tool, 0.08, 0.035, 0.0);
    run(&b, 1, 1e-3, tool);
    assert_true(told(&b).substeps >= 12);
    assert_true(felt(&b).force[2] > 0.0);
    bench_fini(&b);
}

/* ---- a surface that rides on the nodes ---- */

static void lay_half(void *owner, const ss_real *u, ss_real *skin_u)
{
    const anchors *a = owner;
    memcpy(skin_u, u, (size_t)ss_body_read_nodes(a->body)->count * 4 * sizeof *u);
}

static void carry_same(void *owner, int32_t count, const int32_t *node, const ss_real *skin_force,
                       ss_real *force)
{
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 4; ++k) {
            force[4 * node[i] + k] += skin_force[4 * node[i] + k];
        }
    }
}

static void carry_same_diagonal(void *owner, int32_t count, const int32_t *node, const double *skin,
                                double *diagonal)
{
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        diagonal[node[i]] += skin[node[i]];
    }
}

static double carry_same_rate2(void *owner, int32_t count, const int32_t *node, const double *skin,
                               const ss_real *mobility)
{
    double largest = 0.0;
    (void)owner;
    for (int32_t i = 0; i < count; ++i) {
        largest = fmax(largest, skin[node[i]] * (double)mobility[4 * node[i]]);
    }
    return largest;
}

TEST(a_skin_of_the_nodes_themselves_changes_nothing)
{
    ss_contact_set set[2];
    double stable[2];
    for (int kind = 0; kind < 2; ++kind) {
        bench b;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
        bench_with_ball(&b);
        b.s.plan.contact_stiffness = 2e6;
        if (kind == 1) {
            b.skin = (ss_body_skin){.mesh = b.s.mesh,
                                    .sigma = 1.0,
                                    .lay = lay_half,
                                    .carry = carry_same,
                                    .carry_diagonal = carry_same_diagonal,
                                    .rate2 = carry_same_rate2};
        }
        bench_make(&b);
        press(&b, tool, 4e-3, 50);
        tool[0].is_grasping = true;
        hold(&b, tool, 20);
        set[kind] = felt(&b);
        stable[kind] = told(&b).stable_step;
        bench_fini(&b);
    }
    assert_near(set[1].force[2], set[0].force[2], 1e-5 * set[0].force[2]);
    assert_near(set[1].contact[0].stiffness, set[0].contact[0].stiffness,
                1e-3 * set[0].contact[0].stiffness);
    assert_near(stable[1], stable[0], 1e-5 * stable[0]);
}

/* ---- identity ---- */

static uint64_t whole_hash(bench *b)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(b->body);
    uint64_t hash = ss_body_hash(b->body, SS_HASH_START);
    hash = ss_hash_bytes(hash, nodes->u, (size_t)nodes->count * 4 * sizeof(ss_real));
    return hash;
}

TEST(the_same_run_gives_the_same_bits_also_after_a_reset)
{
    bench b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    uint64_t hash[2];
    bench_with_ball(&b);
    b.s.plan.gravity[0] = 1.0;
    bench_make(&b);
    for (int k = 0; k < 2; ++k) {
        b.time = 0.0;
        press(&b, tool, 6e-3, 60);
        (void)felt(&b);
        tool[0].is_grasping = true;
        hold(&b, tool, 30);
        (void)felt(&b);
        hash[k] = whole_hash(&b);
        ss_body_reset(b.body);
    }
    assert_true(hash[0] == hash[1]);
    bench_fini(&b);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
