/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy in the course of a touch, on a plate: slides and closed loops, the contact cell alone,
 * second tools, grasps.
 */
#include "common/test.h"

#include "common/effort.h"
#include "rt/thread.h"
#include "touch_fixture.h"

/* ---- slides and loops on a plate ---- */

typedef struct slide {
    double mean, jump, balance, end_balance, residual;
} slide;

/* Press 6 mm, slide 30 mm from `x0` along x, lift off; over the largest stored energy. */
static slide run_slide(double dt, double x0, double speed, bool is_one_cell)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    const double high = PLATE_EDGE + 0.002, low = PLATE_EDGE - 0.006;
    const double press_time = 0.2, slide_time = 0.03 / fabs(speed);
    slide out = {0};
    setup_plate(&s, 1, PLATE_EDGE, 0.0);
    give(&s, "source", is_one_cell ? 1.0 : 0.0);
    s.plan.step = dt;
    create(&s);
    double largest = 0.0, last[3] = {0.0, 0.0, 0.0};
    int samples = 0;
    const int every = (int)(1e-3 / dt + 0.5);
    const int count = (int)((2.0 * press_time + slide_time + 0.3) / dt + 0.5);
    for (int n = 1; n <= count; ++n) {
        const double time = n * dt;
        const double down = 0.5 - 0.5 * cos(SS_PI * fmin(1.0, time / press_time));
        const double along = fmin(1.0, fmax(0.0, (time - press_time) / slide_time));
        const double up =
            0.5 -
            0.5 * cos(SS_PI * fmin(1.0, fmax(0.0, (time - press_time - slide_time) / press_time)));
        go(tool, x0 + (speed > 0.0 ? 0.03 : -0.03) * along, 0.0007,
           high + (low - high) * (down - up));
        step_tools(&s, dt, tool);
        largest = fmax(largest, info_of(&s).elastic);
        if (n % every == 0) {
            const double *force = s.model->tools.tool[0].force;
            double change[3];
            ss_sub3(change, force, last);
            if (time > press_time + 0.05 && along < 0.97) {
                out.jump = fmax(out.jump, ss_norm3(change));
                out.mean += ss_norm3(force);
                ++samples;
            }
            ss_copy3(last, force);
        }
        if (along >= 1.0 && out.balance == 0.0) {
            out.balance = energy_gain(&s);
        }
    }
    assert_true((info_of(&s).fault_bits) == 0);
    out.mean /= samples;
    out.jump /= out.mean;
    out.balance /= largest;
    out.end_balance = energy_gain(&s) / largest;
    out.residual = largest_displacement(&s);
    setup_fini(&s);
    return out;
}

TEST(a_sliding_tool_feels_no_jumps)
{
    const slide s = run_slide(5e-4, -0.015, 0.05, false);
    assert_true(s.mean > 0.08 && s.mean < 0.14);
    assert_true(s.jump < 0.005);
    assert_true(s.residual < 1e-8);
}

TEST(closed_loops_gain_nothing_in_either_direction)
{
    SKIP_WHERE_REPEATED();
    /* From the soft rim's side to the stiff middle and back: without the forces through the
     * weights this gains and loses a third of the stored energy. */
    for (int way = -1; way <= 1; way += 2) {
        const double x0 = way > 0 ? -0.03 : 0.0;
        const slide coarse = run_slide(1e-3, x0, 0.05 * way, false);
        const slide fine = run_slide(5e-4, x0, 0.05 * way, false);
        assert_near(coarse.end_balance, 0.0, 3e-3);
        assert_near(fine.end_balance, 0.0, 1.5e-3);
        assert_near(fine.end_balance / coarse.end_balance, 0.5, 0.1); /* first order in the step */
    }
}

/* ---- the contact cell alone ---- */

/* A plate under tension and `tools` spheres, each of which acts at its contact cell alone. */
static void setup_one_cell(setup *s, int tools)
{
    setup_plate(s, tools, PLATE_EDGE, 0.1);
    give(s, "source", 1.0);
    create(s);
}

TEST(one_cell_carries_the_whole_source_of_a_load)
{
    /* Seven nodes pushed: the force is on all of them, the source on the one in their middle. */
    int32_t pushed[7] = {12 * 25 + 12, 12 * 25 + 13, 12 * 25 + 11, 13 * 25 + 12,
                         11 * 25 + 12, 13 * 25 + 13, 11 * 25 + 11};
    setup many, one;
    setup_plate(&many, 0, PLATE_EDGE, 0.0);
    setup_plate(&one, 0, PLATE_EDGE, 0.0);
    give(&many, "source", 1.0);
    push(&many, pushed, 0.0, 0.0, -0.7);
    many.load[0].node_count = 7;
    push(&one, pushed, 0.0, 0.0, -0.1);
    many.load[0].ramp = 0.1;
    create(&many);
    create(&one);
    const ss_cnn_source *source = many.model->source;
    assert_int_equal(many.model->source_count, 1);
    assert_int_equal(source->cell_count, 1);
    assert_int_equal(source->cell[0], pushed[0]);
    for (int32_t e = 0; e < many.model->network->edges.count; ++e) {
        assert_true(source->kap_edge[e] == one.model->source[0].kap_edge[e]);
    }
    steps(&many, 200, 1e-3);
    for (int k = 0; k < 7; ++k) {
        assert_near((double)many.model->load_force[4 * (ptrdiff_t)pushed[k] + 2], -0.1, 1e-7);
    }
    assert_true(source->eps > 0.0 && moved(&many, pushed[0], 2) < 0.0);
    assert_near(energy_gain(&many) / info_of(&many).work, 0.0, 1e-5);
    setup_fini(&many);
    setup_fini(&one);
}

TEST(the_contact_cell_follows_until_pressed_and_stays_until_let_go)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_one_cell(&s, 1);
    const ss_cnn_tool *own = &s.model->tool[0];
    const double h = 0.1 / 24.0;
    go(tool, 0.0, 0.0, PLATE_EDGE + 0.01); /* too far */
    settle(&s, 1e-3, tool, 2);
    assert_int_equal(own->cell.node, -1);
    go(tool, 0.0, 0.0, PLATE_EDGE + 0.002); /* near */
    settle(&s, 1e-3, tool, 2);
    assert_int_equal(own->cell.node, 12 * 25 + 12);
    for (int n = 1; n <= 100; ++n) { /* and on to the third node from the middle */
        go(tool, 3.0 * h * n / 100.0, 0.0, PLATE_EDGE + 0.002);
        step_tools(&s, 1e-3, tool);
    }
    assert_int_equal(own->cell.node, 12 * 25 + 15);
    const double before = energy_gain(&s);
    for (int n = 1; n <= 100; ++n) {
        go(tool, 3.0 * h, 0.0, PLATE_EDGE + 0.002 - 5e-5 * n);
        step_tools(&s, 1e-3, tool);
    }
    const double pressed = info_of(&s).elastic;
    assert_true(own->cell.has_pressed && own->source.eps > 0.0);
    for (int n = 1; n <= 100; ++n) { /* it stays where the touch began */
        go(tool, 3.0 * h - 2.0 * h * n / 100.0, 0.0, PLATE_EDGE - 0.003);
        step_tools(&s, 1e-3, tool);
    }
    assert_int_equal(own->cell.node, 12 * 25 + 15);
    assert_near(energy_gain(&s) - before, 0.0,
                1e-4 * pressed); /* no weights move, nothing is frozen */
    for (int n = 1; n <= 100; ++n) {
        go(tool, h, 0.0, PLATE_EDGE - 0.003 + 2e-4 * n);
        step_tools(&s, 1e-3, tool);
    }
    settle(&s, 1e-3, tool, 200);
    assert_int_equal(own->cell.node, -1);
    assert_true(info_of(&s).fault_bits == 0);
    assert_near(energy_gain(&s) - before, 0.0, 5e-4 * pressed);
    go(tool, h, 0.0, PLATE_EDGE - 0.001); /* a jump to another place is a new touch */
    step_tools(&s, 1e-3, tool);
    assert_int_equal(own->cell.node, 12 * 25 + 13);
    setup_fini(&s);
}

/* A sub-step that is taken back has pressed nothing: the tool goes on to the next cell. */
TEST(a_press_that_is_taken_back_holds_no_cell)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_one_cell(&s, 1);
    const ss_cnn_contact_cell *cell = &s.model->tool[0].cell;
    const double h = 0.1 / 24.0;
    go(tool, 0.82 * h, 0.0, PLATE_EDGE + 0.0005); /* the next cell weighs most from 0.9 h on */
    settle(&s, 1e-3, tool, 2);
    assert_int_equal(cell->node, 12 * 25 + 12);
    assert_false(cell->has_pressed);
    const double dt = 12.0 * info_of(&s).stable_step;
    s.model->bound = 100.0 * dt; /* a first attempt far too long, down to the pressed end */
    go(tool, h, 0.0, PLATE_EDGE - 0.00015);
    step_tools(&s, dt, tool);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GUARDED);
    assert_true(cell->has_pressed);
    assert_int_equal(cell->node, 12 * 25 + 13);
    setup_fini(&s);
}

/* A first attempt far too long is taken back with the tool above the plate, where nothing is
 * stored, and with the tool pressed in: only that is told. */
TEST(what_is_taken_back_is_told_where_it_could_be_felt)
{
    for (int is_pressed = 0; is_pressed < 2; ++is_pressed) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        setup_one_cell(&s, 1);
        const double low = is_pressed ? -0.003 : 0.0004;
        for (int n = 1; n <= 100; ++n) {
            go(tool, 0.0, 0.0, PLATE_EDGE + 0.0005 + (low - 0.0005) * n / 100.0);
            step_tools(&s, 1e-3, tool);
            assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        }
        const double dt = 12.0 * info_of(&s).stable_step;
        s.model->bound = 100.0 * dt;
        step_tools(&s, dt, tool);
        assert_true(info_of(&s).substeps > 1); /* else the whole of dt was taken */
        assert_int_equal(info_of(&s).verdict,
                         is_pressed ? SOFTSIM_VERDICT_GUARDED : SOFTSIM_VERDICT_GOOD);
        setup_fini(&s);
    }
}

/* The same run twice gives the same bits, the second time after a reset in the midst of a grasp. */
TEST(a_reset_forgets_every_touch)
{
    SKIP_WHERE_REPEATED();
    for (int mode = 0; mode < 4; ++mode) {
        setup s;
        uint64_t hash[2];
        setup_plate(&s, 2, PLATE_EDGE, 0.1);
        give(&s, "source", mode % 2);
        give(&s, "solver", mode / 2);
        create(&s);
        for (int run = 0; run < 2; ++run) {
            ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
            ss_contact_set set;
            for (int n = 0; n < 60; ++n) {
                go(&tool[0], 0.01 + 1e-5 * n, 0.0, PLATE_EDGE + 0.001 - 1e-4 * n);
                go(&tool[1], -0.02, 1e-4 * n, PLATE_EDGE - 0.001);
                tool[0].is_grasping = n > 30;
                step_tools(&s, 1e-3, tool);
                s.class->contacts(s.model, 0, 0.001, &set);
                s.class->contacts(s.model, 1, 0.001, &set);
            }
            assert_true(set.count > 0 && s.model->tools.tool[0].grasp.count > 0);
            hash[run] = s.class->hash(s.model, 1);
            const ss_real *u = s.class->displacement(s.model);
            for (int32_t i = 0; i < 4 * s.mesh->node_count; ++i) {
                hash[run] = hash[run] * 31u + (uint64_t)(int64_t)(1e12 * (double)u[i]);
            }
            s.class->reset(s.model);
            s.time = 0.0;
            assert_true(largest_displacement(&s) == 0.0 && s.model->tool[0].cell.node == -1);
        }
        assert_true(hash[0] == hash[1]);
        setup_fini(&s);
    }
}

TEST(a_cell_that_is_chosen_anew_beside_a_dent_is_booked)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_one_cell(&s, 2);
    press(&s, tool, 1, 0.0, PLATE_EDGE, 0.006);
    const double before = energy_gain(&s);
    int32_t changes = 0, last = -1;
    double most = 0.0;
    for (int n = 0; n <= 200; ++n) { /* the second tool flies over the slope and touches nothing */
        go(&tool[1], 0.03 - 0.018 * n / 200.0, 0.0, PLATE_EDGE + 0.001);
        step_tools(&s, 1e-3, tool);
        const int32_t node = s.model->tool[1].cell.node;
        changes += last >= 0 && node >= 0 && node != last;
        last = node;
        most = fmax(most, ss_cnn_source_energy(s.model, &s.model->tool[1].source));
        assert_true(s.model->tools.tool[1].penalty == 0.0);
    }
    assert_true(changes >= 2);
    assert_true(most > 0.03 * info_of(&s).elastic);
    assert_near(energy_gain(&s) - before, 0.0, 1e-4 * info_of(&s).elastic);
    setup_fini(&s);
}

TEST(a_slide_with_one_cell_is_smooth_and_gains_nothing)
{
    SKIP_WHERE_REPEATED();
    const slide s = run_slide(5e-4, -0.015, 0.05, true);
    assert_true(s.mean < 0.5 * run_slide(5e-4, -0.015, 0.05, false).mean); /* left behind */
    assert_true(s.jump < 0.05);
    assert_near(s.end_balance, 0.0, 1e-4);
    assert_true(s.residual < 1e-8);
}

TEST(two_starts_lead_to_one_answer)
{
    setup a, b;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}}, other[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&a, 1, PLATE_EDGE, 0.2);
    setup_plate(&b, 1, PLATE_EDGE, 0.2);
    create(&a);
    create(&b);
    press(&a, tool, 1, 0.002, PLATE_EDGE, 0.004);
    settle(&a, 1e-3, tool, 300);
    press(&b, other, 1, -0.01, PLATE_EDGE, 0.004); /* presses elsewhere, then slides there */
    for (int n = 1; n <= 200; ++n) {
        go(other, -0.01 + 0.012 * n / 200.0, 0.0007, PLATE_EDGE - 0.004);
        step_tools(&b, 1e-3, other);
    }
    settle(&b, 1e-3, other, 600);
    for (int k = 0; k < 3; ++k) {
        assert_near(a.model->tools.tool[0].force[k], b.model->tools.tool[0].force[k],
                    BY_TYPE(3e-5, 1e-9) * ss_norm3(a.model->tools.tool[0].force));
    }
    setup_fini(&a);
    setup_fini(&b);
}

TEST(second_tools_add_their_own_potential)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    create_pressed(&s, 2, PLATE_EDGE, 0.0, tool, 0.0, 0.006);
    const double alone = s.model->tools.tool[0].force[2];
    for (int n = 0; n <= 40; ++n) { /* a light touch far away */
        go(&tool[1], 0.038, 0.0, PLATE_EDGE + 0.001 - 0.0012 * n / 40.0);
        settle(&s, 1e-3, tool, 4);
    }
    settle(&s, 1e-3, tool, 200);
    assert_true(s.model->tools.tool[1].force[2] > 0.0);
    assert_near(s.model->tools.tool[0].force[2] / alone, 1.0, 0.01);
    setup_fini(&s);

    memset(tool, 0, sizeof tool);
    create_plate(&s, 2, PLATE_EDGE, 0.0);
    press(&s, tool, 2, 0.0, PLATE_EDGE, 0.006); /* both in the same place */
    const double both = s.model->tools.tool[0].force[2] + s.model->tools.tool[1].force[2];
    assert_near(both / alone, 1.08, 0.015);
    setup_fini(&s);
}

/* A tool that comes to tissue which another one has strained touches it like any other: it is not
 * held off by what is stored there already. */
TEST(strained_tissue_holds_no_tool_off)
{
    SKIP_WHERE_REPEATED();
    const double radius = 2.0 * PLATE_EDGE;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    create_plate(&s, 2, radius, 1.0);
    press(&s, tool, 1, -0.008, radius, 0.008);
    const ss_cnn_tool *second = &s.model->tool[1];
    for (int n = 0; n <= 200; ++n) {
        go(&tool[1], 0.01, 0.0, radius + 0.003 - 0.011 * n / 200.0);
        settle(&s, 1e-3, tool, 2);
        assert_true(second->source.reference >= 0.0);
    }
    settle(&s, 1e-3, tool, 300);
    assert_true(second->source.amplitude == 1.0);
    assert_true(second->base->penalty > 0.0);
    assert_true(s.model->tool[0].source.amplitude == 1.0);
    setup_fini(&s);
}

/* Nor does one that is put there at once, as after a pause: what is stored is no work of its own.
 */
TEST(a_tool_put_on_strained_tissue_does_no_work)
{
    const double radius = 2.0 * PLATE_EDGE;
    for (int is_one_cell = 0; is_one_cell < 2; ++is_one_cell) {
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        setup_plate(&s, 2, radius, 1.0);
        give(&s, "source", is_one_cell);
        create(&s);
        press(&s, tool, 1, -0.008, radius, 0.008);
        const ss_cnn_tool *second = &s.model->tool[1];
        double most = 0.0;
        for (int n = 0; n <= 7; ++n) {
            tool[1].is_present = false;
            step_tools(&s, 1e-3, tool);
            const double before = info_of(&s).work, stored = info_of(&s).elastic;
            go(&tool[1], 0.01, 0.0, radius - 0.0005 * n);
            step_tools(&s, 1e-3, tool);
            const double work = info_of(&s).work - before;
            assert_true(fabs(work) <= 0.01 * stored); /* what is let go of in the step */
            assert_true(second->base->penalty <= 0.0);
            most = fmax(most, second->source.amplitude);
        }
        assert_true(most > 0.5);
        setup_fini(&s);
    }
}

/* What the tools did in the last step, by the mean of their forces at its ends. */
static double tools_work(const setup *s, int count, double (*last)[3])
{
    double work = 0.0;
    for (int k = 0; k < count; ++k) {
        const ss_tool *tool = &s->model->tools.tool[k];
        double way[3], mean[3];
        ss_sub3(way, tool->to.position, tool->from.position);
        ss_add3(mean, tool->force, last[k]);
        work -= 0.5 * ss_dot3(mean, way);
        ss_copy3(last[k], tool->force);
    }
    return work;
}

/* Two tools take turns with one spot, and one always comes to what the other has strained: tissue
 * never has more, nor has lost more, than they put in. */
static void take_turns(bool is_one_cell)
{
    const double radius = 2.0 * PLATE_EDGE, dt = 2e-4;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 2, radius, 1.0);
    give(&s, "source", is_one_cell ? 1.0 : 0.0);
    s.plan.step = dt;
    create(&s);
    double last[2][3] = {{0.0}}, work = 0.0, most = 0.0, over = 0.0;
    for (int n = 0; n < 4000; ++n) {
        for (int k = 0; k < 2; ++k) {
            const double deepest = 0.01 * fmin(1.0, n / 500.0);
            const double depth = -0.002 + deepest * sin(0.5 * SS_PI * n / 500.0 + 0.5 * SS_PI * k);
            go(&tool[k], k == 0 ? -0.006 : 0.006, 0.0, radius - fmax(depth, -0.002));
        }
        step_tools(&s, dt, tool);
        work += tools_work(&s, 2, last);
        const ss_model_info info = info_of(&s);
        most = fmax(most, info.kinetic + info.elastic);
        over = fmax(over, info.kinetic + info.elastic + info.dissipated - work);
    }
    if (!(over < 0.05 * most)) {
        fail_msg("%g J more than the tools gave, of at most %g J that were stored", over, most);
    }
    setup_fini(&s);
}

TEST(strained_tissue_gains_nothing_from_a_touch)
{
    (void)state;
    for (int is_one_cell = FULL_IN_RELEASE(0, 1); is_one_cell < 2; ++is_one_cell) {
        take_turns(is_one_cell != 0);
    }
}

#define GRIP_RADIUS 0.008

/* A sphere pressed in by 4 mm, ready to grasp. */
static void setup_grip(setup *s, ss_model_tool *tool)
{
    setup_plate(s, 1, GRIP_RADIUS, 0.0);
    s->plan.step = 5e-4;
    create(s);
    press(s, tool, 1, 0.0, GRIP_RADIUS, 0.004);
}

/* Lifts it by 8 mm, at y. */
static void lift(setup *s, ss_model_tool *tool, double y)
{
    for (int n = 1; n <= 400; ++n) {
        go(tool, 0.0, y, GRIP_RADIUS - 0.004 + 0.008 * n / 400.0);
        step_tools(s, 5e-4, tool);
    }
}

TEST(a_grasp_starts_without_a_jump_and_lets_go_without_a_gain)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_grip(&s, tool);
    double before[3], change[3];
    ss_copy3(before, s.model->tools.tool[0].force);
    tool[0].is_grasping = true;
    step_tools(&s, 5e-4, tool);
    ss_sub3(change, s.model->tools.tool[0].force, before);
    assert_true(ss_norm3(change) < 1e-3 * ss_norm3(before));
    ss_contact_set set;
    s.class->contacts(s.model, 0, 0.005, &set);
    assert_true(set.is_held);
    const double weight = s.model->tool[0].weight_sum;
    lift(&s, tool, 0.0007); /* now it pulls */
    settle(&s, 5e-4, tool, 400);
    assert_near(s.model->tool[0].weight_sum, weight,
                1e-12 * weight); /* of the cells that it holds */
    assert_true(s.model->tools.tool[0].force[2] < -0.01);
    const double stored = info_of(&s).elastic;
    tool[0].is_grasping = false;
    double last[3];
    ss_copy3(last, s.model->tools.tool[0].force);
    const double pulled = ss_norm3(last);
    for (int n = 0; n < 800; ++n) {
        step_tools(&s, 5e-4, tool);
        ss_sub3(change, s.model->tools.tool[0].force, last);
        assert_true(ss_norm3(change) < 0.1 * pulled);
        ss_copy3(last, s.model->tools.tool[0].force);
    }
    assert_near(energy_gain(&s), 0.0, 5e-3 * stored);
    go(tool, 0.0, 0.0, 0.05);
    settle(&s, 5e-4, tool, 1200);
    assert_near(largest_displacement(&s), 0.0, 1e-8);
    setup_fini(&s);
}

/* Far from a tool that tissue under tension has left, all its weights go with the grasp, and the
 * amplitude in the last few sub-steps. */
TEST(a_grasp_that_lets_go_far_out_loses_nothing_unsaid)
{
    static const double dt = 1e-3;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, GRIP_RADIUS, 0.5);
    create(&s);
    press(&s, tool, 1, 0.0, GRIP_RADIUS, 0.004);
    tool[0].is_grasping = true;
    for (int n = 1; n <= 400; ++n) {
        go(tool, 0.0, 0.0007, GRIP_RADIUS - 0.004 + 0.016 * n / 400.0);
        step_tools(&s, dt, tool);
    }
    settle(&s, dt, tool, 200);
    const double stored = info_of(&s).elastic, gained = energy_gain(&s);
    tool[0].is_grasping = false;
    settle(&s, dt, tool, 400);
    assert_near(info_of(&s).elastic, 0.0, 1e-6 * stored);
    assert_near(energy_gain(&s), gained, 5e-3 * stored);
    setup_fini(&s);
}

TEST(a_grasp_that_is_taken_again_loses_nothing_unsaid)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_grip(&s, tool);
    tool[0].is_grasping = true;
    lift(&s, tool, 0.0);
    const double stored = info_of(&s).elastic;
    for (int n = 0; n < 240; ++n) { /* let go for 2 ms of the 20 that it takes, and taken again */
        tool[0].is_grasping = n % 24 >= 4;
        go(tool, 0.0, 0.0, GRIP_RADIUS + 0.004 + 0.01 * n / 240.0);
        step_tools(&s, 5e-4, tool);
        assert_true(s.model->tools.tool[0].grasp.fade > 0.5);
    }
    assert_near(energy_gain(&s), 0.0, 5e-3 * stored);
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
