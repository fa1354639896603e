/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Meshes of second order: the nodes in the middle of sides are the file's, and so is the shape. */
#include "common/test.h"

#include "quadratic_fixture.h"
#include "rt/each.h"

static const block_size cube = {.cells = {4, 4, 4}, .size = {0.04, 0.04, 0.04}};
static const block_size small = {.cells = {2, 2, 2}, .size = {0.03, 0.02, 0.03}, .jitter = 0.2};

static ss_mesh *raised_copy(ss_mesh *first)
{
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_raise(first, &mesh, NULL), SOFTSIM_OK);
    ss_mesh_destroy(&first);
    return mesh;
}

/* ---- a ball ---- */

#define RADIUS 0.02

/* The cube about (RADIUS, RADIUS, RADIUS) becomes a ball: each x grows or shrinks towards the
 * middle so that the greatest of its coordinates becomes its length. */
static void make_round(ss_mesh *mesh)
{
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double *x = mesh->position[i], most = 0.0;
        for (int k = 0; k < 3; ++k) {
            x[k] -= RADIUS;
            most = fmax(most, fabs(x[k]));
        }
        const double length = ss_norm3(x);
        ss_scale3(x, x, length > 0.0 ? most / length : 1.0);
    }
}

static double mass_of(const open_body *b)
{
    double sum = 0.0;
    for (int32_t i = 0; i < b->raised.mesh.node_count; ++i) {
        sum += b->own.masses.mass[i];
    }
    return sum;
}

TEST(middles_on_the_true_shape_weigh_what_it_weighs)
{
    const double ball = 1000.0 * 4.0 / 3.0 * 3.14159265358979 * RADIUS * RADIUS * RADIUS;
    open_body flat, round;
    ss_mesh *first = make_block(&cube), *second = raised_copy(make_block(&cube));
    make_round(first);
    make_round(second);
    double volume = 0.0;
    for (int32_t e = 0; e < first->tetrahedron_count; ++e) {
        const int32_t *c = first->tetrahedron[e];
        double unused[4][3];
        volume += ss_tetrahedron_gradients(first->position[c[0]], first->position[c[1]],
                                           first->position[c[2]], first->position[c[3]], unused);
    }
    open_init(&flat, first, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0);
    open_init_with(&round, second, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0, true);
    assert_near(mass_of(&flat), 1000.0 * volume, 1e-9);
    assert_true(mass_of(&flat) < 0.95 * ball);
    assert_near(mass_of(&round), ball, 0.005 * ball);
    assert_true(round.raised.curved_edge_count > 0);
    assert_int_equal(round.raised.mesh.node_count, second->node_count);
    for (int32_t i = 0; i < second->node_count; ++i) {
        assert_int_equal(round.raised.mesh.file_node[i], i);
    }
    open_fini(&flat);
    open_fini(&round);
}

/* curved: no. */
TEST(straight_sides_leave_the_files_middles)
{
    open_body flat, straight;
    ss_mesh *first = make_block(&cube), *second = raised_copy(make_block(&cube));
    make_round(first);
    make_round(second);
    open_init(&flat, first, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0);
    open_init_with(&straight, second, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0, false);
    assert_near(mass_of(&straight), mass_of(&flat), 1e-9);
    assert_int_equal(straight.own.blocks.straight_count, straight.own.blocks.count);
    assert_int_equal(straight.raised.curved_edge_count, 0);
    open_fini(&flat);
    open_fini(&straight);
}

/* Bent until its least Jacobian is positive, but below a fifth of the mean: straight again. */
TEST(a_side_that_is_bent_too_far_is_straight)
{
    static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    static const int32_t ten[1][10] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}};
    double x[10][3], least = 0.0;
    memcpy(x, corner, sizeof corner);
    for (int s = 0; s < 6; ++s) {
        ss_add3(x[4 + s], corner[ends[s][0]], corner[ends[s][1]]);
        ss_scale3(x[4 + s], x[4 + s], 0.5);
    }
    x[9][1] = x[9][2] = 0.17; /* of 23 */
    for (int q = 0; q < 4; ++q) {
        double unused[4][3];
        const double volume = ss_tetrahedron_point((const double(*)[3])x, ten[0], q, unused);
        least = q == 0 ? volume : fmin(least, volume);
    }
    assert_true(least > 0.0);
    open_body b;
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create_second_order(10, (const double(*)[3])x, 1, ten, &mesh, NULL),
                     SOFTSIM_OK);
    assert_int_equal(ss_mesh_accept(mesh, "it", NULL), SOFTSIM_OK);
    open_init_with(&b, mesh, SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0, true);
    assert_int_equal(b.raised.straightened_edge_count, 1);
    assert_int_equal(b.raised.curved_edge_count, 0);
    assert_near(b.raised.mesh.position[9][1], 0.5, 0.0);
    open_fini(&b);
}

/* ---- a file of what raising makes ---- */

enum { STEPS = 150 };

/* Held below, pushed above, by the sets of nodes given. */
static void run(setup *s, const uint8_t *fixed, int32_t *node, int32_t count)
{
    give(s, "youngs_modulus_pa", 1e4);
    give(s, "poisson_ratio", 0.45);
    memcpy(s->fixed, fixed, (size_t)s->mesh->node_count);
    s->load[0] =
        (ss_load){.node = node, .node_count = count, .force = {0.05, 0.0, -0.3}, .to = 1.0};
    s->plan.load_count = 1;
    create(s);
    steps(s, STEPS, 1e-3);
}

/* The mesh that raising `b` made, node i called number[i]. */
static ss_mesh *as_file(const ss_quadratic_raised *raised, const int32_t *number)
{
    const int32_t nodes = raised->mesh.node_count, count = raised->mesh.tetrahedron_count;
    double(*x)[3] = calloc((size_t)nodes, sizeof *x);
    int32_t(*ten)[10] = calloc((size_t)count, sizeof *ten);
    ss_mesh *mesh = NULL;
    for (int32_t i = 0; i < nodes; ++i) {
        ss_copy3(x[number[i]], raised->mesh.position[i]);
    }
    for (int32_t k = 0; k < 10 * count; ++k) {
        ten[k / 10][k % 10] = number[raised->node[k / 10][k % 10]];
    }
    assert_int_equal(ss_mesh_create_second_order(nodes, (const double(*)[3])x, count,
                                                 (const int32_t(*)[10])ten, &mesh, NULL),
                     SOFTSIM_OK);
    free(x);
    free(ten);
    return mesh;
}

/* Numbered as raising does, to the last bit; backwards, but for rounding. */
TEST(moves_as_the_same_body_raised_from_its_corners)
{
    open_body b;
    setup first;
    open_init_with(&b, make_block(&small), SS_TISSUE_NEO_HOOKEAN, 0.45, 0.0, true);
    const int32_t nodes = b.raised.mesh.node_count, given = b.raised.given_count;
    int32_t *number = calloc((size_t)nodes, sizeof *number), top[27], count = 0;
    uint8_t *fixed = calloc((size_t)nodes, 1);
    for (int32_t i = 0; i < nodes; ++i) {
        fixed[i] = b.raised.mesh.position[i][2] < 1e-9 ? 7 : 0;
    }
    for (int32_t i = 0; i < given; ++i) {
        if (b.raised.mesh.position[i][2] > 0.03 - 1e-9) {
            top[count++] = i;
        }
    }
    setup_init(&first, "fem-quadratic", make_block(&small));
    /* The block's inner nodes are shaken at random: the same ones. */
    memcpy(first.mesh->position, b.raised.mesh.position, (size_t)given * sizeof(double[3]));
    run(&first, fixed, top, count);
    for (int turn = 0; turn < 2; ++turn) {
        setup s;
        int32_t list[125], listed = 0;
        uint8_t *held = calloc((size_t)nodes, 1);
        for (int32_t i = 0; i < nodes; ++i) {
            number[i] = turn == 0 ? i : nodes - 1 - i;
            held[number[i]] = fixed[i];
            /* A load on corners goes to the sides between them. */
            if (b.raised.mesh.position[i][2] > 0.03 - 1e-9) {
                list[listed++] = number[i];
            }
        }
        setup_init(&s, "fem-quadratic", as_file(&b.raised, number));
        run(&s, held, list, listed);
        const ss_real *u = first.class->displacement(first.model);
        const ss_real *v = s.class->displacement(s.model);
        double most = 0.0, off = 0.0;
        for (int32_t i = 0; i < 3 * nodes; ++i) {
            const double one = (double)u[4 * (ptrdiff_t)(i / 3) + i % 3];
            const double other = (double)v[4 * (ptrdiff_t)number[i / 3] + i % 3];
            most = fmax(most, fabs(one));
            off = fmax(off, fabs(one - other));
        }
        assert_true(most > 1e-3);
        assert_true(off <= (turn == 0 ? 0.0 : BY_TYPE(1e-4, 1e-10) * most));
        free(held);
        setup_fini(&s);
    }
    free(number);
    free(fixed);
    setup_fini(&first);
    open_fini(&b);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
