/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The coarse level above a chain: still a descent of the same energy, far quicker into the depth.
 */
#include "common/test.h"

#include "common/chain_fixture.h"
#include "common/effort.h"

enum { SIDE = 11, NODES = SIDE * SIDE * SIDE, PATCH = 9 };

/* A block of links 1 m long on its lower face, a patch of its upper one prescribed by `way`. */
static void setup_block(setup *s, double alpha, int32_t cells, int32_t *node, double (*way)[3])
{
    setup_network(s, make_box(SIDE, SIDE, SIDE, 1.0), alpha);
    give(s, "coarse_cells", cells);
    give(s, "unloading", SS_CHAIN_KEEP);
    for (int32_t i = 0; i < SIDE * SIDE; ++i) {
        s->fixed[i] = 7;
    }
    for (int k = 0; k < PATCH; ++k) {
        node[k] = (SIDE - 1) * SIDE * SIDE + (SIDE / 2 - 1 + k / 3) * SIDE + SIDE / 2 - 1 + k % 3;
        ss_set3(way[k], 0.0, 0.0, -0.3); /* deeper, it buckles */
    }
    prescribe(s, PATCH, node, way, 0.0);
}

TEST(hats_sum_to_one)
{
    enum { CELLS = 20 };
    setup s;
    setup_network(&s, make_box(9, 9, 9, 0.01), 0.02);
    give(&s, "coarse_cells", CELLS);
    create(&s);
    const ss_chain_hats *hats = ss_chain_coarse_hats(s.model->coarse);
    _Alignas(64) ss_real cell[4 * CELLS], back[4 * CELLS];
    ss_real *mask = ss_memory_get(4 * (size_t)s.model->padded, sizeof *mask);
    for (int c = 0; c < CELLS; ++c) {
        for (int k = 0; k < 4; ++k) {
            cell[4 * c + k] = (ss_real)(k - 1);
        }
    }
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)s.mesh->node_count; ++at) {
        mask[at] = at % 4 < 3;
    }
    for (int path = 0; ss_chain_kernels_path(path); ++path) {
        const ss_chain_kernels *kernels = ss_chain_kernels_path(path);
        double sum = 0.0;
        memset(s.model->u, 0, 4 * (size_t)s.model->padded * sizeof *s.model->u);
        kernels->spread(hats, mask, cell, 1, s.model->u);
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            for (int k = 0; k < 3; ++k) {
                assert_near(moved(&s, i, k), k - 1.0, BY_TYPE(1e-5, 1e-12));
            }
        }
        /* and the other way: Phi' of a pull of 1 on every element adds up to their number */
        kernels->gather(hats, mask, back);
        for (int c = 0; c < CELLS; ++c) {
            sum += (double)back[4 * c];
        }
        assert_near(sum, s.mesh->node_count, BY_TYPE(1e-2, 1e-9));
    }
    ss_memory_free(mask);
    setup_fini(&s);
}

TEST(energy_never_rises_with_two_levels)
{
    random_state = 5;
    for (int held = 0; held < 2; ++held) {
        int32_t node[PATCH];
        double way[PATCH][3];
        setup s;
        setup_block(&s, 0.02, 64, node, way);
        if (!held) {
            s.plan.prescribed_count = 0;
        }
        create(&s);
        const double h = 0.999 * ss_chain_stable_step(s.model);
        for (int n = 0; n < 60; ++n) {
            const double size = pow(10.0, -3.0 + 5.0 * (0.5 + 0.5 * random_unit()));
            for (int32_t i = SIDE * SIDE; i < NODES; ++i) {
                for (int k = 0; k < 3; ++k) {
                    s.model->u[4 * (ptrdiff_t)i + k] =
                        s.model->free[4 * (ptrdiff_t)i + k] * (ss_real)(size * random_unit());
                }
            }
            steps(&s, 1, h);
            for (int k = 0; k < 5; ++k) {
                const double before = s.model->network;
                steps(&s, 1, h);
                if (!(s.model->network <= before * (1.0 + BY_TYPE(1e-5, 1e-12)))) {
                    fail_msg("state %d, step %d: %.9g after %.9g", n, k, s.model->network, before);
                }
            }
        }
        setup_fini(&s);
    }
}

/* Downward motion under the patch half way into the block after `count` steps; its force. */
static double depth_after(int32_t cells, int count, double *out_force)
{
    int32_t node[PATCH];
    double way[PATCH][3], force[3];
    setup s;
    setup_block(&s, 0.0, cells, node, way);
    create(&s);
    steps(&s, count, 0.999 * ss_chain_stable_step(s.model));
    const double depth = -moved(&s, NODES / 2, 2);
    s.class->reaction(s.model, 0, force);
    *out_force = -force[2];
    setup_fini(&s);
    return depth;
}

TEST(poke_reaches_into_the_depth_at_once)
{
    SKIP_WHERE_REPEATED();
    double force[4];
    const double settled = depth_after(64, 3000, &force[0]);
    const double coarse = depth_after(64, 10, &force[1]);
    const double fine = depth_after(0, 10, &force[2]);
    const double fine_settled = depth_after(0, 12000, &force[3]);
    assert_true(coarse > 0.6 * settled);
    assert_below(fine, 0.1 * settled);
    /* The equilibrium is the fine network's own. */
    assert_near(fine_settled, settled, 0.01 * settled);
    assert_near(force[3], force[0], 0.01 * force[0]);
}

/* A sphere that slides: cells under it leave the coarse level and come back. */
static void slide(setup *s, ss_model_tool tool[SOFTSIM_MAX_PROBES], int count)
{
    for (int k = 0; k < count; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] = fmax(tool[0].to.position[2] - 0.02, SIDE - 1 + 1.5 - 0.8);
        tool[0].to.position[0] += 0.02;
        s->class->step(s->model, s->time, 1e-3, tool);
        s->time += 1e-3;
    }
}

TEST(reset_gives_the_same_bits_again)
{
    SKIP_WHERE_REPEATED();
    setup s;
    setup_init(&s, "cnn-chainmail", make_box(SIDE, SIDE, SIDE, 1.0));
    add_sphere(&s, 0, 1.5);
    for (int32_t i = 0; i < SIDE * SIDE; ++i) {
        s.fixed[i] = 7;
    }
    create(&s);
    ss_real *first = calloc(4 * NODES, sizeof *first);
    for (int round = 0; round < 2; ++round) {
        ss_model_tool tool[SOFTSIM_MAX_PROBES] = {{0}};
        tool[0].is_present = true;
        tool[0].to = (ss_tool_pose){.position = {3.0, 5.0, SIDE - 1 + 1.6},
                                    .orientation = {1.0, 0.0, 0.0, 0.0}};
        slide(&s, tool, 200);
        assert_true(fabs(moved(&s, NODES - 1 - SIDE * (SIDE / 2) - 4, 2)) > 0.0);
        if (round == 0) {
            memcpy(first, s.model->u, 4 * NODES * sizeof *first);
            s.class->reset(s.model);
            s.time = 0.0;
        } else {
            assert_memory_equal(first, s.model->u, 4 * NODES * sizeof *first);
        }
    }
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    free(first);
    setup_fini(&s);
}

TEST(aggregated_cells_stay_near_the_full_model)
{
    double *full = calloc(4 * NODES, sizeof *full), force[2][3];
    for (int which = 0; which < 2; ++which) {
        int32_t node[PATCH];
        double way[PATCH][3], away = 0.0, square = 0.0, last = 0.0;
        setup s;
        setup_block(&s, 0.0, 0, node, way);
        if (which == 1) { /* 16 elements a cell, one each near the patch */
            give(&s, "cells", NODES / 16);
        }
        s.prescribed[0].ramp = 2.0;
        create(&s);
        for (int n = 0; n < 30; ++n) {
            steps(&s, 1, 1.0);
            assert_true(n < 4 || s.model->elastic <= last * 1.0001);
            last = s.model->elastic;
        }
        assert_true(s.model->stride > (which == 1));
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        s.class->reaction(s.model, 0, force[which]);
        for (ptrdiff_t at = 0; at < 4 * NODES; ++at) {
            const double u = (double)s.model->u[at];
            away += which == 1 ? (u - full[at]) * (u - full[at]) : 0.0;
            square += u * u;
            full[at] = which == 0 ? u : full[at];
        }
        assert_below(away, 0.15 * 0.15 * square);
        setup_fini(&s);
    }
    assert_near(force[1][2], force[0][2], 0.1 * fabs(force[0][2]));
    free(full);
}

TEST(volumes_have_it_and_surfaces_have_not)
{
    setup s;
    setup_init(&s, "cnn-chainmail", make_box(SIDE, SIDE, SIDE, 1.0));
    create(&s);
    assert_int_equal(ss_chain_coarse_cells(s.model->coarse), 64);
    setup_fini(&s);
    setup_init(&s, "cnn-chainmail", make_plane(30));
    create(&s);
    assert_null(s.model->coarse);
    setup_fini(&s);
}

/* Whether the step or C is what is chosen, and with the front or without. */
TEST(saturation_never_reached_changes_nothing)
{
    for (int kind = 0; kind < 3; ++kind) {
        int32_t node[PATCH];
        double way[PATCH][3];
        setup s[2];
        for (int which = 0; which < 2; ++which) {
            setup_block(&s[which], 0.02, kind == 0 ? 64 : 0, node, way);
            s[which].param[row_of(&s[which], "capacitance_s")].is_given = kind == 2;
            if (which == 1) {
                give(&s[which], "saturation_sizes", 1e6);
            }
            create(&s[which]);
            steps(&s[which], 60, kind == 2 ? 0.3 : 1e-3);
        }
        assert_int_equal(info_of(&s[0]).substeps, info_of(&s[1]).substeps);
        for (int32_t i = 0; i < NODES; ++i) {
            for (int k = 0; k < 3; ++k) {
                assert_near(moved(&s[1], i, k), moved(&s[0], i, k), 0.0);
            }
        }
        assert_int_equal(info_of(&s[1]).verdict, SOFTSIM_VERDICT_GOOD);
        setup_fini(&s[0]);
        setup_fini(&s[1]);
    }
}

/* How far the node has moved after `count` steps, and before the last. */
static double settle(setup *s, int count, int32_t node, double *out_before)
{
    create(s);
    const double h = 0.999 * ss_chain_stable_step(s->model);
    steps(s, count - 1, h);
    *out_before = moved(s, node, 2);
    steps(s, 1, h);
    return moved(s, node, 2);
}

/* Beyond its saturation a cell is drawn back by 1/R alone, however far the coarse level reaches. */
TEST(saturated_cells_are_calm_with_two_levels)
{
    double middle[2];
    for (int which = 0; which < 2; ++which) {
        int32_t node[PATCH];
        double way[PATCH][3], before = 0.0;
        setup s;
        setup_block(&s, 0.0, which ? 64 : 0, node, way);
        s.plan.prescribed_count = 0;
        s.load[s.plan.load_count++] = (ss_load){
            .node = node, .node_count = PATCH, .force = {0.0, 0.0, 60.0}, .to = (double)INFINITY};
        give(&s, "saturation_sizes", 0.02);
        middle[which] = settle(&s, 4000, node[4], &before);
        assert_near(middle[which], before, 1e-4 * before); /* settled */
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GUARDED);
        setup_fini(&s);
    }
    assert_near(middle[1], middle[0], 1e-3 * middle[0]);
}

/* Leak and a load: the coarse level, and aggregated cells, change the way to the equilibrium alone.
 */
TEST(leak_balances_a_load_on_every_level)
{
    SKIP_WHERE_REPEATED();
    double middle[3];
    for (int which = 0; which < 3; ++which) {
        int32_t node[PATCH];
        double way[PATCH][3], before = 0.0;
        setup s;
        setup_block(&s, 0.0, which == 1 ? 64 : 0, node, way);
        s.plan.prescribed_count = 0;
        s.load[s.plan.load_count++] = (ss_load){
            .node = node, .node_count = PATCH, .force = {0.0, 0.0, 2.0}, .to = (double)INFINITY};
        give(&s, "leak_resistance", 10.0);
        if (which == 2) {
            give(&s, "cells", 200.0);
        }
        middle[which] = settle(&s, 3000, node[4], &before);
        assert_near(middle[which], before, 1e-5 * before);
        setup_fini(&s);
    }
    assert_near(middle[1], middle[0], 1e-3 * middle[0]);
    assert_near(middle[2], middle[0], 0.25 * middle[0]); /* seven elements a cell */
}

/* Every element above the fixed ones is prescribed: there is no cell left that may move. */
TEST(a_body_without_a_free_cell_follows_its_set)
{
    for (int aggregated = 0; aggregated < 2; ++aggregated) {
        static int32_t node[NODES];
        static double way[NODES][3];
        setup s;
        setup_network(&s, make_box(SIDE, SIDE, SIDE, 1.0), 0.02);
        s.param[row_of(&s, "coarse_cells")].is_given = false;
        s.param[row_of(&s, "capacitance_s")].is_given = false;
        if (aggregated) {
            give(&s, "cells", 32.0);
        }
        for (int32_t i = 0; i < NODES; ++i) {
            s.fixed[i] = i < SIDE * SIDE ? 7 : 0;
            node[i] = i + SIDE * SIDE;
            ss_set3(way[i], 0.05, 0.0, 0.2);
        }
        prescribe(&s, NODES - SIDE * SIDE, node, way, 0.01);
        create(&s);
        steps(&s, 40, 1e-3);
        assert_near(moved(&s, NODES - 1, 2), 0.2, 1e-6);
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        setup_fini(&s);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
