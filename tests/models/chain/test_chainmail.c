/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The traditional ChainMail: bands, order, relaxation, tools. */
#include "common/test.h"

#include "common/chain_fixture.h"
#include "common/note_fixture.h"

enum { PLANE = 21, MIDDLE = PLANE * PLANE / 2 };

static void setup_plane(setup *s, double alpha, bool is_radial, int32_t *node, double (*way)[3])
{
    setup_init(s, "chainmail", make_plane(PLANE));
    give(s, "alpha", alpha);
    give(s, "band", is_radial);
    for (int32_t i = 0; i < PLANE * PLANE; ++i) {
        const int32_t r = i / PLANE, c = i % PLANE;
        s->fixed[i] = r == 0 || c == 0 || r == PLANE - 1 || c == PLANE - 1 ? 7 : 0;
    }
    node[0] = MIDDLE;
    prescribe(s, 1, node, way, 2.0);
}

TEST(box_makes_the_pyramid)
{
    for (int order = 0; order < 2; ++order) {
        int32_t node[1];
        double way[1][3] = {{0.0, 0.0, 5.0}};
        setup s;
        setup_plane(&s, 0.02, false, node, way);
        give(&s, "order", order);
        create(&s);
        steps(&s, 200, 0.01);
        for (int c = 0; c <= 10; ++c) { /* shear of beta a link: a straight flank */
            assert_near(moved(&s, MIDDLE + c, 2), 5.0 - 0.5 * c, 1e-5);
        }
        assert_near(moved(&s, MIDDLE + PLANE + 3, 2), 3.0, 1e-5);
        setup_fini(&s);
    }
}

TEST(radial_keeps_every_moved_link_in_band)
{
    int32_t node[1];
    double way[1][3] = {{0.2, 0.0, 1.5}};
    setup s;
    setup_plane(&s, 0.02, true, node, way);
    create(&s);
    steps(&s, 1, 2.0);
    /* Along the row that leads away from the middle every node has but one sponsor. */
    for (int c = 0; c < 6; ++c) {
        double d[3];
        for (int k = 0; k < 3; ++k) {
            d[k] = (k == 0) + moved(&s, MIDDLE + c + 1, k) - moved(&s, MIDDLE + c, k);
        }
        assert_true(ss_norm3(d) <= 1.02 + 1e-5 && ss_norm3(d) >= 0.98 - 1e-5);
    }
    assert_true(moved(&s, MIDDLE + 1, 2) > 0.5);
    setup_fini(&s);
}

/* How far a turned plane's shape is from the turned shape. */
static double frame_error(bool is_radial)
{
    setup s[2];
    int32_t node[2][1];
    double way[2][1][3], worst = 0.0;
    for (int which = 0; which < 2; ++which) {
        ss_set3(way[which][0], 0.3, 0.1, 3.0);
        setup_plane(&s[which], 0.02, is_radial, node[which], way[which]);
        for (int32_t i = 0; which == 1 && i < PLANE * PLANE; ++i) {
            turn(s[which].mesh->position[i]);
        }
        if (which == 1) {
            turn(way[which][0]);
        }
        create(&s[which]);
        steps(&s[which], 20, 0.1);
    }
    for (int32_t i = 0; i < PLANE * PLANE; ++i) {
        double x[3] = {moved(&s[0], i, 0), moved(&s[0], i, 1), moved(&s[0], i, 2)};
        turn(x);
        for (int k = 0; k < 3; ++k) {
            worst = fmax(worst, fabs(moved(&s[1], i, k) - x[k]));
        }
    }
    setup_fini(&s[0]);
    setup_fini(&s[1]);
    return worst;
}

TEST(radial_turns_with_the_body_and_box_does_not)
{
    assert_below(frame_error(true), BY_TYPE(1e-3, 1e-9));
    assert_true(frame_error(false) > 0.1);
}

TEST(fixed_nodes_and_what_is_in_band_stay)
{
    int32_t node[1];
    double way[1][3] = {{0.0, 0.0, 0.4}};
    setup s;
    setup_plane(&s, 0.1, false, node, way); /* 0.4 is within beta */
    create(&s);
    steps(&s, 20, 0.1);
    for (int32_t i = 0; i < PLANE * PLANE; ++i) {
        assert_near(moved(&s, i, 2), i == MIDDLE ? 0.4 : 0.0, 1e-7);
    }
    way[0][2] = 40.0; /* far beyond what the rim allows */
    steps(&s, 20, 0.1);
    for (int32_t i = 0; i < PLANE * PLANE; ++i) {
        assert_true(s.fixed[i] == 0 || moved(&s, i, 2) == 0.0);
        assert_true(isfinite(moved(&s, i, 2)));
    }
    setup_fini(&s);
}

static double roughness(const setup *s)
{
    double sum = 0.0;
    for (int c = 3; c < 9; ++c) { /* away from the one point that is held */
        sum += fabs(moved(s, MIDDLE + c + 1, 2) - 2.0 * moved(s, MIDDLE + c, 2) +
                    moved(s, MIDDLE + c - 1, 2));
    }
    return sum;
}

TEST(relaxation_smooths_what_nobody_holds)
{
    double rough[2];
    for (int relaxed = 0; relaxed < 2; ++relaxed) {
        int32_t node[1];
        double way[1][3] = {{0.0, 0.0, 3.0}};
        setup s;
        setup_plane(&s, 0.02, true, node, way);
        give(&s, "relaxation_iterations", 20.0 * relaxed);
        create(&s);
        steps(&s, 20, 0.1);
        rough[relaxed] = roughness(&s);
        assert_near(moved(&s, MIDDLE, 2), 3.0, 1e-6);
        setup_fini(&s);
    }
    assert_below(rough[1], 0.8 * rough[0]);
}

/* In the model's own force there is nothing; the contact is a spring, working force over radius, to
 * where the surface was. */
TEST(tool_moves_what_it_touches_and_feels_a_spring)
{
    setup s;
    setup_init(&s, "chainmail", make_box(9, 9, 5, 0.01));
    add_sphere(&s, 0, 0.015);
    for (int32_t i = 0; i < 81; ++i) {
        s.fixed[i] = 7;
    }
    create(&s);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    tool[0].to = (ss_tool_pose){.position = {0.04, 0.04, 0.06}, .orientation = {1, 0, 0, 0}};
    for (int k = 0; k < 100; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] = 0.06 - 0.0001 * k; /* to 4.9 mm deep */
        s.class->step(s.model, 0.001 * k, 0.001, tool);
    }
    ss_contact_set set;
    s.class->contacts(s.model, 0, 0.005, &set);
    const double spring = 2.0 / 0.015;
    assert_true(set.count > 0 && set.force[2] == 0.0);
    assert_near(set.contact[0].stiffness, spring, 1e-9);
    assert_true(set.contact[0].force > 0.5 * spring * 0.0049);
    assert_below(set.contact[0].force, spring * 0.0049);
    print_message("dent of 4.9 mm: felt as %.2f mm\n", 1e3 * set.contact[0].force / spring);
    /* Out of the dent by 1 mm, and by more than it is deep, and into it again. */
    static const double out[4] = {0.001, 0.006, 0.0051, 0.0049};
    for (int k = 0; k < 4; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] = 0.0501 + out[k];
        s.class->step(s.model, 0.1, 0.001, tool);
        ss_contact_set after;
        s.class->contacts(s.model, 0, 0.005, &after);
        if (k == 0) {
            assert_near(set.contact[0].force - after.contact[0].force, spring * 0.001,
                        spring * 0.0003);
        } else {
            assert_true(after.contact[0].force < 1e-3);
        }
    }
    tool[0].from = tool[0].to;
    tool[0].to.position[2] = 0.0499;
    s.class->step(s.model, 0.1, 0.001, tool);
    assert_below(set.depth, 0.0008);
    assert_true(moved(&s, 4 * 81 + 40, 2) < -0.003);
    tool[0].is_grasping = true;
    s.class->step(s.model, 0.1, 0.001, tool);
    for (int k = 0; k < 100; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] += 0.0001;
        s.class->step(s.model, 0.1 + 0.001 * k, 0.001, tool);
    }
    assert_true(moved(&s, 4 * 81 + 40, 2) > 0.003);
    setup_fini(&s);
}

/* ---- felt contact of a tool that leaves ---- */

enum { SIDE = 9, HEIGHT = 5 };
static const double cell_m = 0.01, ball_m = 0.015;

/* A block held below with a ball over its middle; `groove` (m): its walls fall to x = 4 cells. */
static void setup_block(setup *s, double groove)
{
    setup_init(s, "chainmail", make_box(SIDE, SIDE, HEIGHT, cell_m));
    for (int32_t i = SIDE * SIDE * (HEIGHT - 1); i < s->mesh->node_count; ++i) {
        s->mesh->position[i][2] -= groove * fmax(0.0, 1.0 - abs(i % SIDE - SIDE / 2) / 2.0);
    }
    add_sphere(s, 0, ball_m);
    for (int32_t i = 0; i < SIDE * SIDE; ++i) {
        s->fixed[i] = 7;
    }
    create(s);
}

typedef struct told {
    double force[3]; /* N */
    double gap;      /* m; INFINITY: no contact */
} told;

/* A step of 1 ms of the ball's middle to (x, z). */
static told go(setup *s, ss_model_tool *tool, double x, double z)
{
    ss_contact_set set;
    told out = {.gap = (double)INFINITY};
    tool[0].is_present = true;
    tool[0].to = (ss_tool_pose){.position = {x, 4 * cell_m, z}, .orientation = {1, 0, 0, 0}};
    tool[0].from = s->time > 0.0 ? tool[0].from : tool[0].to;
    s->class->step(s->model, s->time, 0.001, tool);
    s->time += 0.001;
    tool[0].from = tool[0].to;
    s->class->contacts(s->model, 0, 0.005, &set);
    for (int32_t k = 0; k < set.count; ++k) {
        ss_madd3(out.force, out.force, set.contact[k].force, set.contact[k].normal);
        out.gap = fmin(out.gap, set.contact[k].gap);
    }
    return out;
}

/* Down to `deep` below the touch over x = 4 cells, at 0.1 mm a step. */
static told press_in(setup *s, ss_model_tool *tool, double deep)
{
    told last = {.gap = (double)INFINITY};
    for (int k = 0; 0.0001 * k < deep + 1e-9; ++k) {
        last = go(s, tool, 4 * cell_m, 4 * cell_m + ball_m - 0.0001 * k);
    }
    return last;
}

/* What the hand meets on its way out goes down with the way, past zero: the law between results
 * takes force and gap for one line. Also out of a dent deeper than the tool's contacts look. */
TEST(a_dent_is_left_without_a_step)
{
    static const double deep[] = {0.0049, 0.0140};
    const double spring = 2.0 / ball_m, way = 0.0001;
    for (int d = 0; d < 2; ++d) {
        setup s;
        setup_block(&s, 0.0);
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        double last = press_in(&s, tool, deep[d]).force[2] / spring;
        assert_true(last > 0.5 * deep[d]);
        for (int k = 1; last > -0.002; ++k) {
            const told now = go(&s, tool, 4 * cell_m, 4 * cell_m + ball_m - deep[d] + way * k);
            const double depth = now.force[2] / spring - now.gap;
            assert_true(k < 400 && depth < last + 1e-9);
            assert_below(last - depth, 3.0 * way);
            last = depth;
        }
        setup_fini(&s);
    }
}

/* Over a groove the nearest wall changes at once as the ball passes, the force does not. */
TEST(a_dent_between_two_walls_is_felt_without_a_step)
{
    const double spring = 2.0 / ball_m, way = 0.0001;
    setup s;
    setup_block(&s, 0.010);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    const double up = 4 * cell_m + ball_m - 0.0095;
    told last = press_in(&s, tool, 0.010);
    for (int k = 1; k <= 5; ++k) {
        last = go(&s, tool, 4 * cell_m, up - 0.0005 + way * k);
    }
    assert_true(last.force[2] > 0.0005 * spring);
    for (int k = 1; k <= 60; ++k) { /* aside, and over to the other wall */
        const double aside = k <= 20 ? way * k : way * (40 - k);
        const told now = go(&s, tool, 4 * cell_m + aside, up);
        double by[3];
        ss_sub3(by, now.force, last.force);
        assert_below(ss_norm3(by), 2.0 * spring * way);
        last = now;
    }
    setup_fini(&s);
}

/* Drawn up beyond where it was touched, it presses back from there. */
TEST(tissue_that_was_drawn_up_is_felt_where_it_is)
{
    const double top = 4 * cell_m + ball_m, way = 0.0001;
    setup s;
    setup_block(&s, 0.0);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    (void)press_in(&s, tool, 0.002);
    tool[0].is_grasping = true;
    for (int k = 0; k <= 30; ++k) {
        (void)go(&s, tool, 4 * cell_m, top - 0.002 + way * k);
    }
    tool[0].is_grasping = false;
    assert_true(moved(&s, 4 * SIDE * SIDE + 40, 2) > 0.0005);
    told last = {.gap = (double)INFINITY};
    for (int k = 0; k <= 5; ++k) {
        last = go(&s, tool, 4 * cell_m, top + 0.001 - way * k);
    }
    assert_true(last.force[2] > 2.0 / ball_m * 0.0003);
    setup_fini(&s);
}

/* A set that drives z alone leaves x and y to the links. */
TEST(axes_that_are_not_prescribed_are_free)
{
    int32_t node[2] = {0, 1};
    double way[2][3] = {{-1.0, 0.0, 0.0}, {(double)NAN, (double)NAN, 0.1}};
    setup s;
    setup_init(&s, "chainmail", make_triangle(0.8));
    give(&s, "alpha", 0.1);
    give(&s, "band", 1);
    prescribe(&s, 1, node, way, 1.0);
    prescribe(&s, 1, node + 1, way + 1, 0.0);
    create(&s);
    steps(&s, 30, 0.1);
    assert_near(moved(&s, 0, 0), -1.0, 1e-6);
    assert_near(moved(&s, 1, 2), 0.1, 1e-6);
    assert_true(moved(&s, 1, 0) < -0.85); /* pulled along: a link is at most 1.1 long */
    setup_fini(&s);
}

/* A tool that touches nothing takes hold of nothing, whatever another one touches. */
TEST(grasp_holds_what_its_own_tool_touches)
{
    setup s;
    setup_init(&s, "chainmail", make_box(9, 9, 5, 0.01));
    for (int k = 0; k < 2; ++k) {
        add_sphere(&s, k, 0.015);
    }
    for (int32_t i = 0; i < 81; ++i) {
        s.fixed[i] = 7;
    }
    create(&s);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    for (int k = 0; k < 2; ++k) {
        tool[k].is_present = true;
        tool[k].from = tool[k].to = (ss_tool_pose){.position = {0.04, 0.04, k == 0 ? 0.052 : 0.2},
                                                   .orientation = {1, 0, 0, 0}};
    }
    s.class->step(s.model, 0.0, 0.001, tool);
    const double pressed = moved(&s, 4 * 81 + 40, 2);
    assert_true(pressed < -0.001);
    tool[1].is_grasping = true;
    for (int k = 1; k < 20; ++k) {
        s.class->step(s.model, 0.001 * k, 0.001, tool);
        tool[1].from = tool[1].to;
        tool[1].to.position[2] += 0.0005;
    }
    ss_contact_set set;
    s.class->contacts(s.model, 1, 0.005, &set);
    assert_false(set.is_held);
    assert_below(moved(&s, 4 * 81 + 40, 2), 0.9 * pressed);
    setup_fini(&s);
}

TEST(too_few_parts_are_said)
{
    setup s;
    setup_init(&s, "chainmail", make_box(9, 9, 5, 0.01));
    add_sphere(&s, 0, 0.015);
    create(&s);
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
    tool[0].is_present = true;
    tool[0].to = (ss_tool_pose){.position = {0.04, 0.04, 1.0}, .orientation = {1, 0, 0, 0}};
    tool[0].from = tool[0].to;
    tool[0].to.position[2] = -1.0;
    s.class->step(s.model, 0.0, 0.001, tool);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GUARDED);
    tool[0].from = tool[0].to;
    s.class->step(s.model, 0.001, 0.001, tool);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    setup_fini(&s);
}

TEST(a_contact_stiffness_that_is_not_used_is_told)
{
    for (int given = 0; given < 2; ++given) {
        setup s;
        setup_init(&s, "chainmail", make_box(3, 3, 3, 0.01));
        add_sphere(&s, 0, 0.015);
        s.plan.contact_stiffness = given * 1e6;
        create(&s);
        assert_int_equal(note_count(s.class, s.model, SS_NOTE_WARNING, "contact.stiffness_n_per_m3",
                                    "give contact.working_force_n"),
                         given);
        setup_fini(&s);
    }
}

TEST(forces_are_refused_by_name)
{
    int32_t node[1] = {12};
    setup s;
    setup_init(&s, "chainmail", make_plane(5));
    s.plan.gravity[1] = 1.0;
    s.load[s.plan.load_count++] =
        (ss_load){.node = node, .node_count = 1, .force = {0, 0, 1}, .to = (double)INFINITY};
    assert_int_equal(setup_create(&s), SOFTSIM_ERROR_SCENE);
    assert_int_equal(s.error.fault_count, 2);
    assert_non_null(strstr(s.error.text, "chainmail: gravity_m_s2"));
    assert_non_null(strstr(s.error.text, "chainmail: loads"));
    setup_fini(&s);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
