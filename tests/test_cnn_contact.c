/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * cnn-energy under tools: closed forms on the hexagon fan, forces as the gradient of one potential
 * of nodes and tool, slides and closed loops on a plate, second tools, grasp, and the stiffness
 * that the hand is told.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "model_fixture.h"
#include "rt/thread.h"

static void add_sphere(setup *s, int probe, double radius)
{
    s->plan.tool[probe].is_used = true;
    s->plan.tool[probe].shape = (ss_shape){.kind = SS_SHAPE_SPHERE, .radius = radius};
}

/* The tool goes to (x, y, z) in the next step; the first time it is put there. */
static void go(ss_model_tool *tool, double x, double y, double z)
{
    tool->from = tool->to;
    tool->to = (ss_tool_pose){.position = {x, y, z}, .orientation = {1.0, 0.0, 0.0, 0.0}};
    if (!tool->is_present) {
        tool->from = tool->to;
        tool->is_present = true;
    }
}

static void step(setup *s, double dt, ss_model_tool *tool)
{
    s->class->step(s->model, s->time, dt, tool);
    s->time += dt;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        tool[k].from = tool[k].to;
    }
}

static void settle(setup *s, double dt, ss_model_tool *tool, int count)
{
    for (int k = 0; k < count; ++k) {
        step(s, dt, tool);
    }
}

/* ---- the hexagon fan ---------------------------------------------------------------------- */

static void setup_touched_fan(setup *s)
{
    setup_init(s, "cnn-energy", make_fan(0.3));
    for (int k = 1; k < 7; ++k) {
        s->fixed[k] = 7;
    }
    give(s, "modulus_n_per_m", 7.0);
    give(s, "area_density_kg_m2", 10.0);
    give(s, "damping_n_s_per_m3", 5.0);
    give(s, "rest_stiffness_n_per_m3", 2.0);
    add_sphere(s, 0, 0.25);
    s->plan.contact_reach = 0.2;
    s->plan.contact_stiffness = 400.0;
    s->plan.contact_parts = SS_SURFACE_CENTROIDS;
}

static void the_fan_under_a_sphere_has_its_closed_form(void **state)
{
    (void)state;
    static const struct {
        double height, weight, amplitude, psi, force, penalty;
    } row[3] = {
        {0.25, 0.0245357960952869, 0.452960704719945, 0.00136975317107311, 0.0323966410069502, 0.0},
        {0.17, 0.0615903130631309, 1.0, 0.003024, 0.0, 0.0},
        {0.11, 0.0950585950533870, 1.0, 0.003024, 1.27794961556580, 0.0203713525955681}};
    for (int k = 0; k < 3; ++k) {
        setup s;
        setup_touched_fan(&s);
        create(&s);
        s.model->u[2] = (ss_real)-0.12;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        go(tool, 0.0, 0.0, row[k].height);
        step(&s, 1e-15, tool);
        const ss_cnn_tool *own = &s.model->tool[0];
        assert_near(own->full_weight, 0.05235987755982988, 1e-15);
        assert_near(own->weight_sum, row[k].weight, BY_TYPE(1e-7, 1e-13));
        assert_near(own->source.amplitude, row[k].amplitude, BY_TYPE(1e-6, 1e-12));
        assert_near(own->source.eps, 0.08, BY_TYPE(1e-7, 1e-13));
        assert_near(own->source.modulus, 0.945, 1e-6);
        assert_near(ss_cnn_source_energy(s.model, &own->source), row[k].psi, BY_TYPE(1e-8, 1e-14));
        assert_near(own->force[2], row[k].force, BY_TYPE(2e-6, 1e-11));
        assert_near(own->penalty, row[k].penalty, BY_TYPE(1e-7, 1e-13));
        setup_fini(&s);
    }
}

/* ---- one potential of nodes and tool ------------------------------------------------------ */

/* The potential with the tool where it is. */
static double tool_potential(setup *s, ss_model_tool *tool)
{
    s->model->is_ready = false;
    s->class->step(s->model, 0.0, 1e-30, tool);
    return info_of(s).elastic;
}

static double node_force(const setup *s, int32_t node, int axis)
{
    const ss_model *m = s->model;
    const ptrdiff_t at = 4 * (ptrdiff_t)node + axis;
    return (double)m->force[at] - (double)m->rest_stiffness[node] * (double)m->d[at] -
           m->first->c1 * (double)m->first->r[at] + m->first->c2 * (double)m->first->b[at];
}

/* A closed body, deformed at random, with a sphere near its top. */
static void setup_deformed(setup *s, ss_model_tool *tool, double height, double saturation,
                           const char *choice)
{
    setup_init(s, "cnn-energy", make_ellipsoid(4, 0.05, 0.04, 0.03));
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][2] < -0.024 ? 7 : 0;
    }
    give(s, "modulus_j", 5.0);
    give(s, "pretension_j", 0.05);
    if (saturation > 0.0) {
        give(s, "saturation", saturation);
    }
    give(s, "area_density_kg_m2", 11.5);
    give(s, "damping_n_s_per_m3", 1725.0);
    give(s, "rest_stiffness_n_per_m3", 5e4);
    if (choice) {
        give(s, choice, 1.0);
    }
    add_sphere(s, 0, 0.012);
    s->plan.contact_stiffness = 2e6;
    create(s);
    random_state = 42;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        for (int k = 0; s->fixed[i] == 0 && k < 3; ++k) {
            s->model->u[4 * i + k] =
                (ss_real)(0.08 * s->mesh->position[i][k] + 6e-4 * random_unit());
        }
    }
    go(tool, 0.003, -0.002, height);
}

static void check_gradient(double height, double saturation, double wanted_amplitude,
                           const char *choice)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_deformed(&s, tool, height, saturation, choice);
    tool_potential(&s, tool);
    if (s.model->relax) { /* as far as one touch has brought it, and no further */
        tool_potential(&s, tool);
        s.model->relax->steps = 0;
        tool_potential(&s, tool);
    }
    const ss_cnn_tool *own = &s.model->tool[0];
    assert_true(own->source.eps > 0.0);
    assert_true(wanted_amplitude == 1.0
                    ? own->source.amplitude == 1.0
                    : own->source.amplitude > 0.0 && own->source.amplitude < 1.0);
    assert_true(saturation == 0.0 || own->source.eps > own->source.eps_limit);
    const double h = BY_TYPE(2e-5, 1e-7);
    double scale = 0.0;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; s.fixed[i] == 0 && k < 3; ++k) {
            scale = fmax(scale, fabs(node_force(&s, i, k)));
        }
    }
    for (int32_t n = 0; n < own->count; n += 3) { /* nodes under the tool: all terms act there */
        tool_potential(&s, tool);
        const int32_t node = own->node[n];
        for (int k = 0; k < 3; ++k) {
            tool_potential(&s, tool);
            const double force = node_force(&s, node, k);
            const ptrdiff_t at = 4 * (ptrdiff_t)node + k;
            const ss_real before = s.model->u[at];
            s.model->u[at] = (ss_real)((double)before + h);
            const double up = (double)s.model->u[at], high = tool_potential(&s, tool);
            s.model->u[at] = (ss_real)((double)before - h);
            const double down = (double)s.model->u[at], low = tool_potential(&s, tool);
            s.model->u[at] = before;
            assert_near(-(high - low) / (up - down), force, BY_TYPE(0.03, 3e-6) * scale);
        }
    }
    double force[3];
    tool_potential(&s, tool);
    ss_copy3(force, own->force);
    for (int k = 0; k < 3; ++k) { /* the tool's force is the same potential's */
        const double before = tool[0].to.position[k];
        double energy[2];
        for (int side = 0; side < 2; ++side) {
            tool[0].to.position[k] = before + (side == 0 ? h : -h);
            tool[0].from = tool[0].to;
            energy[side] = tool_potential(&s, tool);
        }
        tool[0].to.position[k] = before;
        tool[0].from = tool[0].to;
        assert_near(-(energy[0] - energy[1]) / (2.0 * h), force[k], BY_TYPE(0.03, 3e-6) * scale);
    }
    setup_fini(&s);
}

static void all_forces_are_the_gradient_of_one_potential(void **state)
{
    (void)state;
    /* Footprint, the contact cell, and a network that is still on its way. */
    static const char *const choice[3] = {NULL, "source", "solver"};
    for (int k = 0; k < 3; ++k) {
        check_gradient(0.0415, 0.0, 1.0, choice[k]);  /* pressed in */
        check_gradient(0.0475, 0.0, 0.5, choice[k]);  /* near: the push of the amplitude */
        check_gradient(0.0415, 1e-6, 1.0, choice[k]); /* saturated */
    }
}

static void forces_balance_and_move_with_body_and_tool(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_deformed(&s, tool, 0.0415, 0.0, NULL);
    tool_potential(&s, tool);
    double sum[3], reaction[3];
    ss_copy3(sum, s.model->tool[0].force);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (s.fixed[i] == 0) { /* what the node feels beside its spring */
                sum[k] +=
                    node_force(&s, i, k) + (double)s.model->rest_stiffness[i] * moved(&s, i, k);
            }
        }
    }
    s.class->reaction(s.model, -1, reaction);
    for (int k = 0; k < 3; ++k) {
        assert_near(sum[k] - reaction[k], 0.0, BY_TYPE(2e-5, 1e-11));
    }
    setup_fini(&s);
}

/* ---- slides and loops on a plate ---------------------------------------------------------- */

#define PLATE_EDGE 0.0045

static void setup_plate(setup *s, int tools, double radius, double pretension)
{
    setup_init(s, "cnn-energy", make_plate(24, 0.1));
    for (int i = 0; i < 25; ++i) {
        for (int j = 0; j < 25; ++j) {
            s->fixed[i * 25 + j] = i == 0 || j == 0 || i == 24 || j == 24 ? 7 : 0;
        }
    }
    give(s, "modulus_j", 5.0);
    give(s, "pretension_j", pretension);
    give(s, "area_density_kg_m2", 11.5);
    give(s, "damping_n_s_per_m3", 11.5 * 150.0);
    give(s, "rest_stiffness_n_per_m3", 5e4);
    for (int k = 0; k < tools; ++k) {
        add_sphere(s, k, radius);
    }
    s->plan.contact_stiffness = 5e7;
}

static void press(setup *s, ss_model_tool *tool, int probes, double x, double radius, double depth)
{
    for (int n = 0; n <= 60; ++n) {
        for (int k = 0; k < probes; ++k) {
            go(&tool[k], x, 0.0007, radius + 1e-3 - (depth + 1e-3) * n / 60.0);
        }
        settle(s, 1e-3, tool, 2);
    }
    settle(s, 1e-3, tool, 200);
}

typedef struct slide {
    double mean, jump, ledger, end_ledger, residual;
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
        const double down = 0.5 - 0.5 * cos(PI * fmin(1.0, time / press_time));
        const double along = fmin(1.0, fmax(0.0, (time - press_time) / slide_time));
        const double up =
            0.5 -
            0.5 * cos(PI * fmin(1.0, fmax(0.0, (time - press_time - slide_time) / press_time)));
        go(tool, x0 + (speed > 0.0 ? 0.03 : -0.03) * along, 0.0007,
           high + (low - high) * (down - up));
        step(&s, dt, tool);
        largest = fmax(largest, info_of(&s).elastic);
        if (n % every == 0) {
            const double *force = s.model->tool[0].force;
            double change[3];
            ss_sub3(change, force, last);
            if (time > press_time + 0.05 && along < 0.97) {
                out.jump = fmax(out.jump, ss_norm3(change));
                out.mean += ss_norm3(force);
                ++samples;
            }
            ss_copy3(last, force);
        }
        if (along >= 1.0 && out.ledger == 0.0) {
            out.ledger = ledger(&s);
        }
    }
    assert_true((info_of(&s).fault_bits) == 0);
    out.mean /= samples;
    out.jump /= out.mean;
    out.ledger /= largest;
    out.end_ledger = ledger(&s) / largest;
    out.residual = largest_displacement(&s);
    setup_fini(&s);
    return out;
}

static void a_sliding_tool_feels_no_jumps(void **state)
{
    (void)state;
    const slide s = run_slide(5e-4, -0.015, 0.05, false);
    assert_true(s.mean > 0.08 && s.mean < 0.14);
    assert_true(s.jump < 0.005);
    assert_true(s.residual < 1e-8);
}

static void closed_loops_gain_nothing_in_either_direction(void **state)
{
    (void)state;
    /* From the soft rim's side to the stiff middle and back: without the forces through the
     * weights this gains and loses a third of the stored energy. */
    for (int way = -1; way <= 1; way += 2) {
        const double x0 = way > 0 ? -0.03 : 0.0;
        const slide coarse = run_slide(1e-3, x0, 0.05 * way, false);
        const slide fine = run_slide(5e-4, x0, 0.05 * way, false);
        assert_near(coarse.end_ledger, 0.0, 3e-3);
        assert_near(fine.end_ledger, 0.0, 1.5e-3);
        assert_near(fine.end_ledger / coarse.end_ledger, 0.5, 0.1); /* first order in the step */
    }
}

/* ---- the contact cell alone --------------------------------------------------------------- */

static void one_cell_carries_the_whole_source_of_a_load(void **state)
{
    (void)state;
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
    assert_near(ledger(&many) / info_of(&many).work, 0.0, 1e-5);
    setup_fini(&many);
    setup_fini(&one);
}

static void the_contact_cell_follows_until_pressed_and_stays_until_let_go(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, PLATE_EDGE, 0.1);
    give(&s, "source", 1.0);
    create(&s);
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
        step(&s, 1e-3, tool);
    }
    assert_int_equal(own->cell.node, 12 * 25 + 15);
    const double before = ledger(&s);
    for (int n = 1; n <= 100; ++n) {
        go(tool, 3.0 * h, 0.0, PLATE_EDGE + 0.002 - 5e-5 * n);
        step(&s, 1e-3, tool);
    }
    const double pressed = info_of(&s).elastic;
    assert_true(own->cell.has_pressed && own->source.eps > 0.0);
    for (int n = 1; n <= 100; ++n) { /* it stays where the touch began */
        go(tool, 3.0 * h - 2.0 * h * n / 100.0, 0.0, PLATE_EDGE - 0.003);
        step(&s, 1e-3, tool);
    }
    assert_int_equal(own->cell.node, 12 * 25 + 15);
    assert_near(ledger(&s) - before, 0.0, 1e-4 * pressed); /* no weights move, nothing is frozen */
    for (int n = 1; n <= 100; ++n) {
        go(tool, h, 0.0, PLATE_EDGE - 0.003 + 2e-4 * n);
        step(&s, 1e-3, tool);
    }
    settle(&s, 1e-3, tool, 200);
    assert_int_equal(own->cell.node, -1);
    assert_true(info_of(&s).fault_bits == 0);
    assert_near(ledger(&s) - before, 0.0, 5e-4 * pressed);
    go(tool, h, 0.0, PLATE_EDGE - 0.001); /* a jump to another place is a new touch */
    step(&s, 1e-3, tool);
    assert_int_equal(own->cell.node, 12 * 25 + 13);
    setup_fini(&s);
}

/* A sub-step that is taken back has pressed nothing: the tool goes on to the next cell. */
static void a_press_that_is_taken_back_holds_no_cell(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, PLATE_EDGE, 0.1);
    give(&s, "source", 1.0);
    create(&s);
    const ss_cnn_contact_cell *cell = &s.model->tool[0].cell;
    const double h = 0.1 / 24.0;
    go(tool, 0.82 * h, 0.0, PLATE_EDGE + 0.0005); /* the next cell weighs most from 0.9 h on */
    settle(&s, 1e-3, tool, 2);
    assert_int_equal(cell->node, 12 * 25 + 12);
    assert_false(cell->has_pressed);
    const double dt = 12.0 * info_of(&s).stable_step;
    s.model->bound = 100.0 * dt; /* a first attempt far too long, down to the pressed end */
    go(tool, h, 0.0, PLATE_EDGE - 0.00015);
    step(&s, dt, tool);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GUARDED);
    assert_true(cell->has_pressed);
    assert_int_equal(cell->node, 12 * 25 + 13);
    setup_fini(&s);
}

/* The same run twice gives the same bits, the second time after a reset in the midst of a grasp. */
static void a_reset_forgets_every_touch(void **state)
{
    (void)state;
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
                step(&s, 1e-3, tool);
                s.class->contacts(s.model, 0, 0.001, &set);
                s.class->contacts(s.model, 1, 0.001, &set);
            }
            assert_true(set.count > 0 && s.model->tool[0].grasp.count > 0);
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

static void a_cell_that_is_chosen_anew_beside_a_dent_is_booked(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 2, PLATE_EDGE, 0.1);
    give(&s, "source", 1.0);
    create(&s);
    press(&s, tool, 1, 0.0, PLATE_EDGE, 0.006);
    const double before = ledger(&s);
    int32_t changes = 0, last = -1;
    double most = 0.0;
    for (int n = 0; n <= 200; ++n) { /* the second tool flies over the slope and touches nothing */
        go(&tool[1], 0.03 - 0.018 * n / 200.0, 0.0, PLATE_EDGE + 0.0015);
        step(&s, 1e-3, tool);
        const int32_t node = s.model->tool[1].cell.node;
        changes += last >= 0 && node >= 0 && node != last;
        last = node;
        most = fmax(most, ss_cnn_source_energy(s.model, &s.model->tool[1].source));
        assert_true(s.model->tool[1].penalty == 0.0);
    }
    assert_true(changes >= 2);
    assert_true(most > 0.03 * info_of(&s).elastic);
    assert_near(ledger(&s) - before, 0.0, 1e-4 * info_of(&s).elastic);
    setup_fini(&s);
}

static void a_slide_with_one_cell_is_smooth_and_gains_nothing(void **state)
{
    (void)state;
    const slide s = run_slide(5e-4, -0.015, 0.05, true);
    assert_true(s.mean < 0.5 * run_slide(5e-4, -0.015, 0.05, false).mean); /* left behind */
    assert_true(s.jump < 0.05);
    assert_near(s.end_ledger, 0.0, 1e-4);
    assert_true(s.residual < 1e-8);
}

static void two_starts_lead_to_one_answer(void **state)
{
    (void)state;
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
        step(&b, 1e-3, other);
    }
    settle(&b, 1e-3, other, 600);
    for (int k = 0; k < 3; ++k) {
        assert_near(a.model->tool[0].force[k], b.model->tool[0].force[k],
                    BY_TYPE(3e-5, 1e-9) * ss_norm3(a.model->tool[0].force));
    }
    setup_fini(&a);
    setup_fini(&b);
}

static void second_tools_add_their_own_potential(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 2, PLATE_EDGE, 0.0);
    create(&s);
    press(&s, tool, 1, 0.0, PLATE_EDGE, 0.006);
    const double alone = s.model->tool[0].force[2];
    for (int n = 0; n <= 40; ++n) { /* a light touch far away */
        go(&tool[1], 0.038, 0.0, PLATE_EDGE + 0.001 - 0.0012 * n / 40.0);
        settle(&s, 1e-3, tool, 4);
    }
    settle(&s, 1e-3, tool, 200);
    assert_true(s.model->tool[1].force[2] > 0.0);
    assert_near(s.model->tool[0].force[2] / alone, 1.0, 0.01);
    setup_fini(&s);

    memset(tool, 0, sizeof tool);
    setup_plate(&s, 2, PLATE_EDGE, 0.0);
    create(&s);
    press(&s, tool, 2, 0.0, PLATE_EDGE, 0.006); /* both in the same place */
    const double both = s.model->tool[0].force[2] + s.model->tool[1].force[2];
    assert_near(both / alone, 1.08, 0.015);
    setup_fini(&s);
}

/* A tool that comes to tissue which another one has strained touches it like any other: it is not
 * held off by what is stored there already. */
static void strained_tissue_holds_no_tool_off(void **state)
{
    (void)state;
    const double radius = 2.0 * PLATE_EDGE;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 2, radius, 1.0);
    create(&s);
    press(&s, tool, 1, -0.008, radius, 0.008);
    const ss_cnn_tool *second = &s.model->tool[1];
    for (int n = 0; n <= 200; ++n) {
        go(&tool[1], 0.01, 0.0, radius + 0.003 - 0.011 * n / 200.0);
        settle(&s, 1e-3, tool, 2);
        assert_true(second->source.reference >= 0.0);
    }
    settle(&s, 1e-3, tool, 300);
    assert_true(second->source.amplitude == 1.0);
    assert_true(second->penalty > 0.0);
    assert_true(s.model->tool[0].source.amplitude == 1.0);
    setup_fini(&s);
}

static void a_grasp_starts_without_a_jump_and_lets_go_without_a_gain(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    const double radius = 0.008;
    setup_plate(&s, 1, radius, 0.0);
    s.plan.step = 5e-4;
    create(&s);
    press(&s, tool, 1, 0.0, radius, 0.004);
    double before[3], change[3];
    ss_copy3(before, s.model->tool[0].force);
    tool[0].is_grasping = true;
    step(&s, 5e-4, tool);
    ss_sub3(change, s.model->tool[0].force, before);
    assert_true(ss_norm3(change) < 1e-3 * ss_norm3(before));
    ss_contact_set set;
    s.class->contacts(s.model, 0, 0.005, &set);
    assert_true(set.is_held);
    for (int n = 1; n <= 400; ++n) { /* lift by 8 mm: now it pulls */
        go(tool, 0.0, 0.0007, radius - 0.004 + 0.008 * n / 400.0);
        step(&s, 5e-4, tool);
    }
    settle(&s, 5e-4, tool, 400);
    assert_true(s.model->tool[0].force[2] < -0.01);
    const double stored = info_of(&s).elastic;
    tool[0].is_grasping = false;
    double last[3];
    ss_copy3(last, s.model->tool[0].force);
    const double pulled = ss_norm3(last);
    for (int n = 0; n < 800; ++n) {
        step(&s, 5e-4, tool);
        ss_sub3(change, s.model->tool[0].force, last);
        assert_true(ss_norm3(change) < 0.1 * pulled);
        ss_copy3(last, s.model->tool[0].force);
    }
    assert_near(ledger(&s), 0.0, 5e-3 * stored);
    go(tool, 0.0, 0.0, 0.05);
    settle(&s, 5e-4, tool, 1200);
    assert_near(largest_displacement(&s), 0.0, 1e-8);
    setup_fini(&s);
}

static void a_grasp_that_is_taken_again_loses_nothing_unsaid(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    const double radius = 0.008;
    setup_plate(&s, 1, radius, 0.0);
    s.plan.step = 5e-4;
    create(&s);
    press(&s, tool, 1, 0.0, radius, 0.004);
    tool[0].is_grasping = true;
    for (int n = 1; n <= 400; ++n) {
        go(tool, 0.0, 0.0, radius - 0.004 + 0.008 * n / 400.0);
        step(&s, 5e-4, tool);
    }
    const double stored = info_of(&s).elastic;
    for (int n = 0; n < 240; ++n) { /* let go for 2 ms of the 20 that it takes, and taken again */
        tool[0].is_grasping = n % 24 >= 4;
        go(tool, 0.0, 0.0, radius + 0.004 + 0.01 * n / 240.0);
        step(&s, 5e-4, tool);
        assert_true(s.model->tool[0].grasp.share > 0.5);
    }
    assert_near(ledger(&s), 0.0, 5e-3 * stored);
    setup_fini(&s);
}

/* ---- what the hand is told ---------------------------------------------------------------- */

static double force_along(const setup *s, const double normal[3])
{
    return ss_dot3(s->model->tool[0].force, normal);
}

static void the_stiffness_told_is_the_tangent_and_errs_high(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; ++kind) {
        const double radius = kind < 2 ? PLATE_EDGE : 3.0 * PLATE_EDGE;
        setup s;
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        setup_plate(&s, 1, radius, kind % 2 == 0 ? 0.0 : 0.5);
        create(&s);
        press(&s, tool, 1, 0.001, radius, 0.003);
        ss_contact_set set = {0};
        for (int n = 0; n < 60; ++n) {
            step(&s, 1e-3, tool);
            s.class->contacts(s.model, 0, 0.005, &set);
        }
        assert_int_equal(set.count, 1);
        const ss_contact *contact = &set.contact[0];
        const double *n = contact->normal, *at = tool[0].to.position, move = 2e-5;
        double force[2], home[3];
        ss_copy3(home, at);
        for (int side = 0; side < 2; ++side) {
            const double way = side == 0 ? -move : move;
            go(tool, home[0] + way * n[0], home[1] + way * n[1], home[2] + way * n[2]);
            settle(&s, 1e-3, tool, 250);
            force[side] = force_along(&s, n);
        }
        const double measured = (force[0] - force[1]) / (2.0 * move);
        assert_true(contact->stiffness > 0.99 * measured);
        assert_true(contact->stiffness < 1.06 * measured);
        assert_true(contact->viscosity > 0.0 && contact->viscosity <= 0.01 * contact->stiffness);
        setup_fini(&s);
    }
}

static void contacts_tell_of_nearness_before_they_touch(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, PLATE_EDGE, 0.2);
    create(&s);
    ss_contact_set set;
    s.class->contacts(s.model, 0, 0.005, &set); /* no tool yet */
    assert_int_equal(set.count, 0);
    go(tool, 0.0, 0.0007, PLATE_EDGE + 0.02);
    step(&s, 1e-3, tool);
    s.class->contacts(s.model, 0, 0.005, &set);
    assert_int_equal(set.count, 0);
    go(tool, 0.0, 0.0007, PLATE_EDGE + 0.003);
    settle(&s, 1e-3, tool, 2);
    s.class->contacts(s.model, 0, 0.005, &set);
    assert_int_equal(set.count, 1);
    assert_near(set.contact[0].gap, 0.003, 2e-4);
    assert_true(set.contact[0].force == 0.0 && set.contact[0].stiffness > 0.0);
    assert_near(set.contact[0].normal[2], 1.0, 1e-3);
    const double rest = set.contact[0].stiffness;
    /* The first touching result: no viscosity; what rest promised is of the right size. */
    go(tool, 0.0, 0.0007, PLATE_EDGE - 0.001);
    step(&s, 1e-3, tool);
    s.class->contacts(s.model, 0, 0.005, &set);
    assert_true(set.contact[0].force > 0.0 && set.contact[0].viscosity == 0.0);
    settle(&s, 1e-3, tool, 300);
    for (int n = 0; n < 40; ++n) {
        s.class->contacts(s.model, 0, 0.005, &set);
    }
    assert_true(rest > 0.3 * set.contact[0].stiffness && rest < 3.0 * set.contact[0].stiffness);
    assert_near(set.contact[0].force, ss_dot3(s.model->tool[0].force, set.contact[0].normal), 1e-9);
    setup_fini(&s);
}

static void a_fast_tool_is_sub_stepped_and_does_not_tunnel(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, PLATE_EDGE, 0.2);
    create(&s);
    go(tool, 0.0, 0.0007, PLATE_EDGE + 0.004);
    step(&s, 1e-3, tool);
    go(tool, 0.0, 0.0007, PLATE_EDGE - 0.003); /* 7 mm in 1 ms */
    step(&s, 1e-3, tool);
    assert_true(info_of(&s).substeps >= 6);
    assert_true(s.model->tool[0].force[2] > 0.0);
    settle(&s, 1e-3, tool, 200);
    assert_true(s.model->tool[0].force[2] > 0.05);
    assert_true(info_of(&s).fault_bits == 0);
    setup_fini(&s);
}

static void a_tool_that_leaves_or_jumps_keeps_the_ledger(void **state)
{
    (void)state;
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    setup_plate(&s, 1, PLATE_EDGE, 0.2);
    create(&s);
    press(&s, tool, 1, 0.0, PLATE_EDGE, 0.003);
    const double stored = info_of(&s).elastic;
    tool[0].to.position[0] = tool[0].from.position[0] = 0.01; /* a jump, no sweep */
    step(&s, 1e-3, tool);
    settle(&s, 1e-3, tool, 100);
    assert_near(ledger(&s), 0.0, 2e-2 * stored);
    tool[0].is_present = false;
    settle(&s, 1e-3, tool, 500);
    assert_near(ledger(&s), 0.0, 2e-2 * stored);
    assert_near(largest_displacement(&s), 0.0, 1e-6);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    setup_fini(&s);
}

/* Any shape, thrown about and turned, jumping into the body and grasping it at random. */
static void throw_about(uint64_t seed, ss_shape_kind kind)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    random_state = seed;
    setup_init(&s, "cnn-energy", make_ellipsoid(4, 0.05, 0.04, 0.03));
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < -0.024 ? 7 : 0;
    }
    give(&s, "modulus_j", 5.0);
    give(&s, "pretension_j", 0.2);
    give(&s, "enclosed_bulk_pa", 500.0);
    give(&s, "area_density_kg_m2", 11.5);
    give(&s, "damping_n_s_per_m3", 1725.0);
    give(&s, "rest_stiffness_n_per_m3", 5e4);
    s.plan.max_substeps = 8;
    s.plan.tool[0].is_used = true;
    s.plan.tool[0].shape = (ss_shape){
        .kind = kind, .radius = 0.006, .half_length = 0.01, .half_extent = {0.006, 0.005, 0.009}};
    create(&s);
    tool[0].is_present = true;
    for (int n = 0; n < 90; ++n) {
        ss_tool_pose *to = &tool[0].to;
        double length = 0.0;
        for (int k = 0; k < 3; ++k) {
            to->position[k] += 1e-3 * random_unit();
            to->orientation[k + 1] = 0.2 * random_unit();
            length += to->orientation[k + 1] * to->orientation[k + 1];
        }
        to->orientation[0] = sqrt(1.0 - length);
        if (n % 30 == 0) {
            ss_set3(to->position, 0.02 * random_unit(), 0.02 * random_unit(), 0.028);
            tool[0].from = *to;
        }
        tool[0].is_grasping = n / 10 % 2 == 1;
        step(&s, 1e-3, tool);
        ss_contact_set set;
        s.class->contacts(s.model, 0, 0.005, &set);
        assert_true(info_of(&s).verdict != SOFTSIM_VERDICT_FAULT);
        assert_true(isfinite(largest_displacement(&s)));
        for (int32_t k = 0; k < set.count; ++k) {
            assert_true(isfinite(set.contact[k].force) && set.contact[k].stiffness > 0.0);
            assert_true(isfinite(set.contact[k].stiffness) && set.contact[k].viscosity >= 0.0);
        }
    }
    tool[0].is_present = false;
    settle(&s, 1e-3, tool, 600);
    assert_near(largest_displacement(&s), 0.0, 1e-6);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    setup_fini(&s);
}

static void tools_thrown_about_leave_the_body_whole(void **state)
{
    (void)state;
    throw_about(11, SS_SHAPE_SPHERE);
    throw_about(12, SS_SHAPE_CAPSULE);
    throw_about(13, SS_SHAPE_BOX);
    throw_about(14, SS_SHAPE_CYLINDER);
    throw_about(15, SS_SHAPE_CONE);
}

/* ---- columns ------------------------------------------------------------------------------ */

static void compact_columns_are_the_same_columns(void **state)
{
    (void)state;
    setup s;
    setup_init(&s, "cnn-energy", make_plate(49, 0.2)); /* 2304 cells that can carry a source */
    for (int i = 0; i < 50; ++i) {
        for (int j = 0; j < 50; ++j) {
            s.fixed[i * 50 + j] = i == 0 || j == 0 || i == 49 || j == 49 ? 7 : 0;
        }
    }
    give(&s, "modulus_j", 5.0);
    give(&s, "area_density_kg_m2", 11.5);
    give(&s, "damping_n_s_per_m3", 1725.0);
    give(&s, "rest_stiffness_n_per_m3", 5e4);
    add_sphere(&s, 0, 0.005);
    create(&s);
    ss_cnn_network *network = s.model->network;
    assert_true(network->is_compact);
    double *exact = calloc((size_t)network->edges.padded_count, sizeof *exact);
    random_state = 9;
    for (int trial = 0; trial < 12; ++trial) {
        const int32_t cell = (int32_t)(24.5 * 50.0 + 24.5 + trial * 47) % 2500;
        if (!network->is_source[cell]) {
            continue;
        }
        const double one = 1.0;
        const ss_real *column;
        ss_cnn_network_columns(network, 1, &cell, &column);
        assert_int_equal(ss_cnn_network_superpose(network, 1, &cell, &one, exact), SOFTSIM_OK);
        double largest = 0.0, sum = 0.0;
        for (int32_t e = 0; e < network->edges.count; ++e) {
            largest = fmax(largest, exact[e]);
            sum += exact[e] * network->edge_square[e];
        }
        assert_near(sum, 1.0, 1e-12); /* sum kap L0^2 = 1 */
        for (int32_t e = 0; e < network->edges.count; ++e) {
            assert_near((double)column[e], exact[e], BY_TYPE(1e-6, 1e-13) * largest);
        }
    }
    free(exact);
    /* And they carry a tool. */
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    press(&s, tool, 1, 0.0, 0.005, 0.003);
    assert_true(s.model->tool[0].force[2] > 0.01 && info_of(&s).fault_bits == 0);
    setup_fini(&s);
}

static void too_many_columns_are_refused_by_name(void **state)
{
    (void)state;
    if (sizeof(ss_real) != sizeof(double)) {
        return; /* half the nodes suffice in double precision */
    }
    setup s;
    setup_init(&s, "cnn-energy", make_plate(80, 0.2));
    give(&s, "modulus_j", 5.0);
    give(&s, "area_density_kg_m2", 11.5);
    give(&s, "damping_n_s_per_m3", 1725.0);
    give(&s, "rest_stiffness_n_per_m3", 5e4);
    add_sphere(&s, 0, 0.005);
    assert_int_equal(setup_create(&s), SOFTSIM_ERROR_UNSUPPORTED);
    assert_non_null(strstr(s.error.text, "256 MB"));
    setup_fini(&s);
}

int main(void)
{
    ss_thread_flush_denormals();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_fan_under_a_sphere_has_its_closed_form),
        cmocka_unit_test(all_forces_are_the_gradient_of_one_potential),
        cmocka_unit_test(forces_balance_and_move_with_body_and_tool),
        cmocka_unit_test(a_sliding_tool_feels_no_jumps),
        cmocka_unit_test(closed_loops_gain_nothing_in_either_direction),
        cmocka_unit_test(one_cell_carries_the_whole_source_of_a_load),
        cmocka_unit_test(the_contact_cell_follows_until_pressed_and_stays_until_let_go),
        cmocka_unit_test(a_press_that_is_taken_back_holds_no_cell),
        cmocka_unit_test(a_reset_forgets_every_touch),
        cmocka_unit_test(a_cell_that_is_chosen_anew_beside_a_dent_is_booked),
        cmocka_unit_test(a_slide_with_one_cell_is_smooth_and_gains_nothing),
        cmocka_unit_test(two_starts_lead_to_one_answer),
        cmocka_unit_test(second_tools_add_their_own_potential),
        cmocka_unit_test(strained_tissue_holds_no_tool_off),
        cmocka_unit_test(a_grasp_starts_without_a_jump_and_lets_go_without_a_gain),
        cmocka_unit_test(a_grasp_that_is_taken_again_loses_nothing_unsaid),
        cmocka_unit_test(the_stiffness_told_is_the_tangent_and_errs_high),
        cmocka_unit_test(contacts_tell_of_nearness_before_they_touch),
        cmocka_unit_test(a_fast_tool_is_sub_stepped_and_does_not_tunnel),
        cmocka_unit_test(a_tool_that_leaves_or_jumps_keeps_the_ledger),
        cmocka_unit_test(tools_thrown_about_leave_the_body_whole),
        cmocka_unit_test(compact_columns_are_the_same_columns),
        cmocka_unit_test(too_many_columns_are_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
