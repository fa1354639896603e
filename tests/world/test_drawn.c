/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The surface that is published: of a model with nodes on sides in quarters of its faces, the
 * nodes that are in no file called so.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>

#include "common/folder_fixture.h"
#include "common/number_fixture.h"
#include "rt/vec.h"
#include "softsim/softsim.h"
#include "world/world.h"

/* Eight cubes of 10 mm in six tetrahedra each, a bit sheared: 27 nodes, 98 sides, 72 of them in the
 * 48 faces of the surface. */
enum { SIDE = 3, NODES = SIDE * SIDE * SIDE };

static ss_mesh *make_block(void)
{
    static const int corner[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                     {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    double x[NODES][3];
    int32_t tetrahedron[48][4], count = 0;
    for (int i = 0; i < NODES; ++i) {
        const int c[3] = {i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)};
        ss_set3(x[i], 0.01 * c[0] + 0.001 * c[1] * c[1], 0.01 * c[1], 0.01 * c[2]);
        for (int t = 0; t < 6 && c[0] < 2 && c[1] < 2 && c[2] < 2; ++t, ++count) {
            for (int k = 0; k < 4; ++k) {
                const int b = corner[t][k];
                tetrahedron[count][k] = i + (b & 1) + SIDE * (b >> 1 & 1) + SIDE * SIDE * (b >> 2);
            }
        }
    }
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(NODES, (const double(*)[3])x, 0, NULL, count,
                                    (const int32_t(*)[4])tetrahedron, &mesh, NULL),
                     SOFTSIM_OK);
    return mesh;
}

/* The block, of that order, bent where it is the second, held below and pushed above. */
static ss_world *create(int order, const char *model)
{
    char text[768];
    ss_mesh *mesh = make_block(), *second = NULL;
    if (order == 2) {
        assert_int_equal(ss_mesh_raise(mesh, &second, NULL), SOFTSIM_OK);
        for (int32_t i = NODES; i < second->node_count; ++i) {
            second->position[i][0] += 0.0005 * sin(300.0 * second->position[i][2]);
        }
    }
    assert_int_equal(ss_mesh_write_msh(order == 2 ? second : mesh, in_folder("block.msh"), NULL),
                     SOFTSIM_OK);
    ss_mesh_destroy(&mesh);
    ss_mesh_destroy(&second);
    (void)snprintf(
        text, sizeof text,
        "softsim: 1\nobject: {mesh: block.msh, units: m, fixed: [{box_m: [[-1, -1, -1], [1, 1, "
        "1e-6]]}]}\nmodel: {name: %s, youngs_modulus_pa: 5000, poisson_ratio: 0.4}\n"
        "publish: {mesh_rate_hz: 1000}\nloads: [{nodes: [26], force_n: [0.01, 0, -0.02]}]\n",
        model);
    const ss_world_options options = {
        .scene_path = write_text("block.yaml", text), .threads = 1, .is_lockstep = true};
    ss_world *world = NULL;
    softsim_error error = {0};
    if (ss_world_create(&options, &world, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return world;
}

/* Sides 01 12 20 of a face of four quarters: each has its own middle, nearer than all others. */
static void expect_quarters(const ss_drawn *d)
{
    assert_true(d->is_quartered);
    assert_int_equal(d->triangle_count, 4 * 48);
    for (int32_t t = 0; t < d->triangle_count; t += 4) {
        const int32_t(*four)[3] = d->triangle + t;
        for (int k = 0; k < 3; ++k) {
            double middle[3];
            ss_add3(middle, d->rest[four[k][0]], d->rest[four[(k + 1) % 3][0]]);
            ss_scale3(middle, middle, 0.5);
            assert_int_equal(four[k][1], four[3][k]);
            assert_int_equal(four[k][2], four[3][(k + 2) % 3]);
            assert_in_range(four[3][k], 0, d->node_count - 1);
            double off[3];
            ss_sub3(off, d->rest[four[3][k]], middle);
            assert_true(ss_norm3(off) < 0.002);
        }
    }
}

/* The nodes of the file move as they are told to users, and so does every other. */
static void expect_snapshot(ss_world *world)
{
    const ss_drawn *d = &world->drawn;
    for (int k = 0; k < 20; ++k) {
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
    }
    bool is_new = false;
    const ss_surface_snapshot *snapshot = ss_mailbox_take(world->surface, &is_new);
    const ss_real *u = world->model_class->displacement(world->model);
    assert_non_null(snapshot);
    double most = 0.0;
    for (int32_t i = 0; i < 3 * d->node_count; ++i) {
        const ptrdiff_t node = d->node ? d->node[i / 3] : i / 3;
        assert_near((double)snapshot->number[i], (double)u[4 * node + i % 3], 1e-9);
        most = fmax(most, fabs((double)snapshot->number[i]));
    }
    assert_true(most > 1e-5);
}

/* A pressed block that is reset in a pause is shown at rest, not as it was. */
TEST(a_reset_in_a_pause_is_shown)
{
    static const char *const commands[] = {"pause", "reset"};
    ss_world *world = create(1, "fem");
    expect_snapshot(world);
    world->snapshot_every = 5;
    do { /* between two snapshots */
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
    } while (world->steps % world->snapshot_every == 0);
    for (int k = 0; k < 2; ++k) {
        char text[256];
        ss_command_record record;
        assert_int_equal(ss_world_command(world, commands[k], "", &record, text, sizeof text), 0);
    }
    bool is_new = false;
    (void)ss_mailbox_take(world->surface, &is_new);
    for (int32_t k = 0; k < world->snapshot_every; ++k) {
        ss_world_step_begin(world);
        ss_world_step_compute(world);
        ss_world_step_post(world);
    }
    const ss_surface_snapshot *snapshot = ss_mailbox_take(world->surface, &is_new);
    assert_true(is_new);
    for (int32_t i = 0; i < 3 * world->drawn.node_count; ++i) {
        assert_true(snapshot->number[i] == 0.0F);
    }
    ss_world_destroy(&world);
}

TEST(sides_without_a_node_in_the_file_get_one_of_no_number)
{
    ss_world *world = create(1, "fem-quadratic");
    const ss_drawn *d = &world->drawn;
    const ss_mesh *mesh = world->scene->mesh;
    /* What lies inside and in no file is not published. */
    assert_int_equal(d->given_count, NODES);
    assert_int_equal(d->node_count, NODES + 72);
    expect_quarters(d);
    int32_t fixed = 0;
    for (int32_t i = 0; i < d->node_count; ++i) {
        assert_int_equal(d->file_node[i], i < NODES ? ss_mesh_file_node(mesh, i) : -1);
        assert_int_equal(d->fixed[i] != 0, d->rest[i][2] < 1e-9);
        fixed += d->fixed[i] != 0;
    }
    assert_int_equal(fixed, 9 + 16);
    expect_snapshot(world);
    ss_world_destroy(&world);
}

TEST(nodes_of_a_file_of_second_order_have_its_numbers)
{
    ss_world *world = create(2, "fem-quadratic");
    const ss_drawn *d = &world->drawn;
    const ss_mesh *mesh = world->scene->mesh;
    assert_int_equal(d->node_count, mesh->node_count);
    expect_quarters(d);
    assert_null(d->node);
    bool seen[NODES + 98] = {false};
    assert_int_equal(d->node_count, NODES + 98);
    for (int32_t i = 0; i < d->node_count; ++i) {
        const int32_t file = d->file_node ? d->file_node[i] : i;
        assert_in_range(file, 0, d->node_count - 1);
        assert_false(seen[file]);
        seen[file] = true;
    }
    expect_snapshot(world);
    ss_world_destroy(&world);
}

TEST(other_models_publish_their_own_triangles)
{
    ss_world *world = create(1, "fem");
    const ss_drawn *d = &world->drawn;
    assert_int_equal(d->node_count, NODES);
    assert_int_equal(d->triangle_count, 48);
    assert_false(d->is_quartered);
    assert_ptr_equal(d->triangle, world->scene->mesh->triangle);
    expect_snapshot(world);
    ss_world_destroy(&world);
}

/* Sides that the model straightens: what is read is where its nodes are. */
TEST(positions_are_those_of_the_model)
{
    ss_world *world = create(2, "fem-quadratic, curved: no");
    static double x[NODES + 98][3], u[NODES + 98][3];
    softsim_read_nodes((softsim_world *)world, x, u, NULL);
    const ss_mesh *mesh = world->scene->mesh;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
        for (int s = 0; s < 6; ++s) {
            const double *a = x[ss_mesh_file_node(mesh, mesh->tetrahedron[e][ends[s][0]])];
            const double *b = x[ss_mesh_file_node(mesh, mesh->tetrahedron[e][ends[s][1]])];
            const double *m = x[ss_mesh_file_node(mesh, mesh->middle[e][s])];
            for (int i = 0; i < 3; ++i) {
                assert_near(m[i], 0.5 * (a[i] + b[i]), 1e-15);
            }
        }
    }
    ss_world_destroy(&world);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
