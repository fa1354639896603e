/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * xpbd: rest, patch test, static solutions of the law with many sub-steps, stiffness without limit,
 * crushed bodies, momentum, tools, packs, paths, refusals.
 */
#include "common/test.h"

#include "common/effort.h"
#include "common/element_fixture.h"
#include "common/paths_fixture.h"
#include "models/common/body.h"
#include "models/tissue_law.h"
#include "models/xpbd/kernels.h"
#include "rt/hash.h"

#define MODULUS 5000.0

static void setup_soft(setup *s, int cells, ss_tissue_kind kind, double ratio)
{
    setup_init(s, "xpbd", make_block(cells, 0.06));
    give(s, "material", kind - SS_TISSUE_NEO_HOOKEAN);
    give(s, "youngs_modulus_pa", MODULUS);
    give(s, "poisson_ratio", ratio);
}

static void hold_left(setup *s)
{
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][0] < -0.0299 ? 7 : 0;
    }
}

static const ss_tissue_kind kinds[] = {SS_TISSUE_NEO_HOOKEAN, SS_TISSUE_STABLE_NEO_HOOKEAN};

/* ---- statics ---- */

TEST(a_body_at_rest_stays_at_rest_to_the_last_bit)
{
    const double modulus[] = {1.0, 5e3, 1e9}, ratio[] = {0.0, 0.3, 0.4999};
    for (int m = 0; m < 3; ++m) {
        for (int n = 0; n < 2; ++n) {
            setup s;
            setup_soft(&s, 2, kinds[n], ratio[m]);
            give(&s, "youngs_modulus_pa", modulus[m]);
            create(&s);
            steps(&s, 50, 1e-3);
            assert_near(largest_displacement(&s), 0.0, 0.0);
            assert_near(info_of(&s).elastic, 0.0, 0.0);
            setup_fini(&s);
        }
    }
}

/* The whole surface prescribed to an affine place: how far the inside is from it, and the energy.
 */
static double affine_error(ss_tissue_kind kind, int substeps, double *out_energy)
{
    static const double h[9] = {0.1, 0.05, -0.02, 0.0, -0.06, 0.08, 0.03, 0.0, 0.04};
    setup s;
    setup_soft(&s, 4, kind, 0.45);
    int32_t node[125];
    double way[125][3], worst = 0.0;
    int32_t count = 0;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        const double *p = s.mesh->position[i];
        if (fmax(fmax(fabs(p[0]), fabs(p[1])), fabs(p[2])) > 0.0299) {
            for (int k = 0; k < 3; ++k) {
                way[count][k] = ss_dot3(h + 3 * k, p);
            }
            node[count++] = i;
        }
    }
    prescribe(&s, count, node, way, 0.05);
    give(&s, "mass_damping_per_s", 100.0);
    give(&s, "substep_s", 1e-3 / substeps);
    create(&s);
    steps(&s, 250, 1e-3);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double x = ss_dot3(h + 3 * k, s.mesh->position[i]);
            worst = fmax(worst, fabs(moved(&s, i, k) - x));
        }
    }
    ss_tissue_law law = {.kind = kind};
    ss_tissue_lame(MODULUS, 0.45, &law.lambda, &law.mu);
    *out_energy = info_of(&s).elastic / (ss_tissue_energy(&law, h) * 0.06 * 0.06 * 0.06);
    double force[3];
    s.class->reaction(s.model, 0, force);
    assert_near(ss_norm3(force), 0.0, 0.02); /* of newtons on each side */
    setup_fini(&s);
    return worst;
}

TEST(inside_an_affine_surface_all_is_affine)
{
    SKIP_WHERE_REPEATED();
    for (int n = 0; n < 2; ++n) {
        double energy;
        const double coarse = affine_error(kinds[n], 4, &energy);
        const double fine = affine_error(kinds[n], 12, &energy);
        assert_true(coarse < 1e-5);
        assert_true(fine < 0.15 * coarse); /* as h^2 */
        assert_near(energy, 1.0, 1e-4);
    }
}

/* Deflection of a block that hangs from its side, at rest. */
static double hanging(const char *name, ss_tissue_kind kind, double ratio, int substeps)
{
    setup s;
    setup_init(&s, name, make_block(3, 0.06));
    give(&s, "material", strcmp(name, "xpbd") == 0 ? kind - SS_TISSUE_NEO_HOOKEAN : kind);
    give(&s, "youngs_modulus_pa", MODULUS);
    give(&s, "poisson_ratio", ratio);
    give(&s, "mass_damping_per_s", 40.0);
    if (substeps > 0) {
        give(&s, "substep_s", 1e-3 / substeps);
    } else {
        give(&s, "locking_cure", 1.0); /* none */
    }
    s.plan.gravity[2] = -9.81;
    hold_left(&s);
    create(&s);
    steps(&s, 600, 1e-3);
    double force[3];
    s.class->reaction(s.model, -1, force);
    const double share = substeps == 1 ? 0.1 : 0.01; /* of the weight */
    assert_near(force[2], 0.216 * 9.81, share * 0.216 * 9.81);
    assert_near(force[0], 0.0, share * 0.216 * 9.81);
    assert_int_equal(info_of(&s).fault_bits, 0);
    const double out = moved(&s, s.mesh->node_count - 1, 2);
    setup_fini(&s);
    return out;
}

TEST(many_substeps_lead_to_the_static_solution_of_the_law)
{
    SKIP_WHERE_REPEATED();
    if (!ss_model_find("fem")) {
        skip();
    }
    const double ratio[] = {0.3, 0.49};
    for (int m = 0; m < 2; ++m) {
        for (int n = 0; n < 2; ++n) {
            const double exact = hanging("fem", kinds[n], ratio[m], 0);
            const double coarse = hanging("xpbd", kinds[n], ratio[m], 1);
            const double fine = hanging("xpbd", kinds[n], ratio[m], 8);
            assert_near(coarse, exact, 0.05 * fabs(exact));
            assert_near(fine, exact, 1e-3 * fabs(exact));
            assert_true(fabs(fine - exact) < 0.2 * fabs(coarse - exact));
        }
    }
}

/* ---- guards ---- */

TEST(no_stiffness_is_too_much_for_a_step)
{
    const double modulus[] = {4e5, 1e7, 1e9}, ratio[] = {0.3, 0.4999};
    for (int m = 0; m < 3; ++m) {
        for (int n = 0; n < 2; ++n) {
            setup s;
            setup_soft(&s, 3, kinds[n], ratio[m % 2]);
            give(&s, "youngs_modulus_pa", modulus[m]);
            give(&s, "substep_s", 1e-3);
            s.plan.gravity[2] = -9.81;
            hold_left(&s);
            create(&s);
            steps(&s, 300, 1e-3);
            assert_true(largest_displacement(&s) < 2e-3);
            assert_true(info_of(&s).kinetic < 1e-4);
            assert_int_equal(info_of(&s).fault_bits, 0);
            /* Too long a sub-step for it: softer than its law, and told. */
            assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GUARDED);
            assert_non_null(strstr(info_of(&s).reason, "softer"));
            setup_fini(&s);
        }
    }
}

TEST(a_crushed_body_gets_its_shape_back)
{
    for (int n = 0; n < 2; ++n) {
        setup s;
        int32_t node[2] = {62, 42};
        setup_soft(&s, 3, kinds[n], 0.45);
        hold_left(&s);
        give(&s, "mass_damping_per_s", 20.0);
        s.load[0] =
            (ss_load){.node = node, .node_count = 2, .force = {-20.0, 4.0, 7.0}, .to = 0.02};
        s.plan.load_count = 1;
        create(&s);
        bool was_inverted = false;
        for (int k = 0; k < 20; ++k) {
            steps(&s, 1, 1e-3);
            was_inverted = was_inverted || strstr(info_of(&s).reason, "inside out");
            assert_true(isfinite(info_of(&s).elastic));
        }
        assert_true(was_inverted);
        assert_true(largest_displacement(&s) > 0.02);
        steps(&s, 700, 1e-3);
        assert_true(largest_displacement(&s) < 1e-4);
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        setup_fini(&s);
    }
}

TEST(the_budget_makes_substeps_longer_and_the_body_no_slower)
{
    setup s;
    setup_soft(&s, 2, SS_TISSUE_STABLE_NEO_HOOKEAN, 0.3);
    give(&s, "substep_s", 1e-5);
    s.plan.max_substeps = 7;
    s.plan.gravity[0] = 1.0;
    create(&s);
    steps(&s, 100, 1e-3);
    assert_int_equal(info_of(&s).substeps, 7);
    assert_int_equal(info_of(&s).fault_bits, 0);
    assert_near(moved(&s, 0, 0), 0.005, 1e-5);
    setup_fini(&s);
}

/* ---- motion ---- */

TEST(half_the_substep_is_estimated_at_twice_the_cost)
{
    double cost[3];
    for (int k = 0; k < 3; ++k) {
        setup s;
        setup_soft(&s, 12, kinds[0], 0.45);
        give(&s, "substep_s", k == 0 ? 1e-4 : k == 1 ? 5e-5 : 2.5e-5);
        cost[k] = s.class->step_cost_us(&s.plan);
        setup_fini(&s);
    }
    assert_true(cost[1] > 1.5 * cost[0]);
    assert_near(cost[2] - cost[1], 2.0 * (cost[1] - cost[0]), 1e-9); /* but for a step's own */
}

TEST(a_thrown_body_keeps_its_momentum)
{
    setup s;
    int32_t node[1] = {0};
    setup_soft(&s, 2, SS_TISSUE_STABLE_NEO_HOOKEAN, 0.45);
    s.load[0] = (ss_load){.node = node, .node_count = 1, .force = {0.5, 0.8, -0.3}, .to = 0.01};
    s.plan.load_count = 1;
    create(&s);
    steps(&s, 500, 1e-3);
    const double volume = 0.06 * 0.06 * 0.06;
    double momentum[3] = {0.0}, density[27], mass[27];
    for (int i = 0; i < 27; ++i) {
        density[i] = 1000.0;
    }
    ss_body_volume_masses(s.mesh, density, false, mass);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            momentum[k] += mass[i] * (double)s.class->velocity(s.model)[4 * i + k];
        }
    }
    assert_near(momentum[0], 0.005, BY_TYPE(2e-6, 1e-14));
    assert_near(momentum[1], 0.008, BY_TYPE(2e-6, 1e-14));
    assert_near(momentum[2], -0.003, BY_TYPE(2e-6, 1e-14));
    const ss_model_info info = info_of(&s);
    assert_true(info.kinetic + info.elastic < info.work);
    assert_true(info.kinetic > 0.5 * ss_dot3(momentum, momentum) / (1000.0 * volume));
    setup_fini(&s);
}

TEST(axes_that_are_held_do_not_move)
{
    setup s;
    setup_soft(&s, 3, SS_TISSUE_NEO_HOOKEAN, 0.3);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < -0.0299 ? 4 : 0;
    }
    s.fixed[0] = 7;
    s.fixed[4] = 6;
    s.plan.gravity[2] = -9.81;
    give(&s, "mass_damping_per_s", 20.0);
    create(&s);
    steps(&s, 500, 1e-3);
    double widest = 0.0;
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        if (s.fixed[i] & 4) {
            assert_near(moved(&s, i, 2), 0.0, 0.0);
            widest = fmax(widest, fabs(moved(&s, i, 0)));
        }
    }
    assert_true(widest > 1e-4); /* it spreads over the floor */
    double force[3];
    s.class->reaction(s.model, -1, force);
    assert_near(force[2], 0.216 * 9.81, 2e-3 * 0.216 * 9.81);
    setup_fini(&s);
}

TEST(a_tool_is_carried_by_the_support)
{
    setup s;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_contact_set set = {0};
    setup_soft(&s, 4, SS_TISSUE_STABLE_NEO_HOOKEAN, 0.45);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        s.fixed[i] = s.mesh->position[i][2] < -0.0299 ? 7 : 0;
    }
    add_sphere(&s, 0, 0.012);
    give(&s, "mass_damping_per_s", 50.0);
    create(&s);
    tool[0].is_present = true;
    tool[0].from.orientation[0] = tool[0].to.orientation[0] = 1.0;
    for (int k = 0; k < 400; ++k) {
        tool[0].from = tool[0].to;
        tool[0].to.position[2] = 0.043 - 5e-3 * fmin(1.0, k / 100.0);
        if (k == 0) {
            tool[0].from = tool[0].to;
        }
        s.class->step(s.model, s.time, 1e-3, tool);
        s.time += 1e-3;
        s.class->contacts(s.model, 0, 0.01, &set);
    }
    double force[3];
    s.class->reaction(s.model, -1, force);
    assert_true(set.force[2] > 0.05);
    assert_near(force[2], set.force[2], 2e-3 * set.force[2]);
    assert_true(set.contact[0].stiffness > 0.0);
    assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
    assert_near(energy_gain(&s), 0.0, 0.02 * info_of(&s).work);
    setup_fini(&s);
}

TEST(the_same_run_gives_the_same_bits)
{
    uint64_t hash[2];
    setup s;
    setup_soft(&s, 3, SS_TISSUE_NEO_HOOKEAN, 0.45);
    hold_left(&s);
    s.plan.gravity[1] = -9.81;
    create(&s);
    for (int k = 0; k < 2; ++k) {
        s.time = 0.0;
        steps(&s, 40, 1e-3);
        hash[k] = hash_of(&s);
        s.class->reset(s.model);
        assert_near(largest_displacement(&s), 0.0, 0.0);
    }
    assert_true(hash[0] == hash[1]);
    setup_fini(&s);
}

/* ---- packs and paths ---- */

typedef struct loose {
    ss_mesh *mesh;
    double *lambda, *mu;
    ss_real *mobility, *u, *step;
    ss_arena arena;
    ss_xpbd_packs packs;
} loose;

static void loose_init(loose *l, int cells)
{
    *l = (loose){.mesh = make_block(cells, 0.06)};
    const size_t n = ((size_t)l->mesh->node_count + 7) / 8 * 8;
    const size_t e = (size_t)l->mesh->tetrahedron_count;
    l->lambda = calloc(e, sizeof *l->lambda);
    l->mu = calloc(e, sizeof *l->mu);
    SS_ARENA_TAKE(&l->arena, SS_ROOM(4 * n, l->mobility), SS_ROOM(4 * n, l->u),
                  SS_ROOM(4 * n, l->step));
    for (size_t k = 0; k < e; ++k) {
        l->lambda[k] = 2e4;
        l->mu[k] = 2e3;
    }
    for (size_t k = 0; k < 4 * (size_t)l->mesh->node_count; ++k) {
        l->mobility[k] = k % 4 == 3 || k % 37 == 5 ? 0 : 200;
    }
    assert_true(ss_xpbd_packs_create(l->mesh->tetrahedron_count,
                                     (const int32_t(*)[4])l->mesh->tetrahedron,
                                     (const double(*)[3])l->mesh->position, l->lambda, l->mu,
                                     l->mobility, &l->arena, &l->packs));
}

static void loose_fini(loose *l)
{
    ss_arena_free(&l->arena);
    free(l->lambda);
    free(l->mu);
    ss_mesh_destroy(&l->mesh);
}

TEST(packs_hold_every_element_once_and_no_node_twice)
{
    loose l;
    loose_init(&l, 5);
    int32_t found = 0;
    for (int32_t b = 0; b < l.packs.count; ++b) {
        const int32_t *node = l.packs.node + b * 32;
        for (int lane = 0; lane < 8; ++lane) {
            const bool is_spare = l.packs.modulus[b * 16 + 8 + lane] == 0;
            found += !is_spare;
            for (int other = 0; other < lane; ++other) {
                for (int k = 0; k < 16; ++k) {
                    assert_true(is_spare || l.packs.modulus[b * 16 + 8 + other] == 0 ||
                                node[8 * (k / 4) + lane] != node[8 * (k % 4) + other]);
                }
            }
        }
    }
    assert_int_equal(found, l.mesh->tetrahedron_count);
    assert_true(8 * l.packs.count < 1.15 * found);
    loose_fini(&l);
}

TEST(all_paths_agree)
{
    loose l;
    loose_init(&l, 3);
    const size_t n = 4 * (size_t)l.mesh->node_count;
    ss_real *first = ss_memory_get(n, sizeof *first);
    for (int m = 0; m < 2; ++m) {
        path_results results = {NULL, NULL};
        for (int path = 0; ss_xpbd_kernels_path(path); ++path) {
            random_state = 5;
            for (size_t k = 0; k < n; ++k) {
                l.u[k] = k % 4 == 3 ? 0 : (ss_real)(8e-3 * random_unit());
                l.step[k] = l.mobility[k] > 0 ? (ss_real)(1e-4 * random_unit()) : 0;
            }
            ss_xpbd_pass pass = {.packs = &l.packs,
                                 .kind = kinds[m],
                                 .h = 1e-3,
                                 .u = l.u,
                                 .mobility = l.mobility,
                                 .step = l.step,
                                 .least = 1.0};
            ss_xpbd_kernels_path(path)->constrain(&pass);
            assert_true(pass.least < 1.0);
            for (size_t k = 0; k < n; ++k) {
                assert_true(l.mobility[k] > 0 || l.step[k] == 0);
                first[k] = path == 0 ? l.step[k] : first[k];
                assert_near((double)l.step[k], (double)first[k], BY_TYPE(2e-6, 1e-13));
            }
            path_results_take(&results, ss_xpbd_kernels_path(path)->name, l.mesh->node_count,
                              l.step);
        }
        path_results_fini(&results);
    }
    ss_memory_free(first);
    loose_fini(&l);
}

TEST(one_element_takes_its_implicit_step)
{
    /* One free tetrahedron: momentum stays, and in the limit of small h the way is h^2 f / m. */
    const int32_t corner[1][4] = {{0, 1, 3, 2}};
    const double lambda = 2e4, mu = 2e3;
    _Alignas(64) ss_real mobility[32] = {0}, u[32] = {0}, step[32] = {0};
    ss_arena arena = {0};
    ss_xpbd_packs packs;
    for (int k = 0; k < 16; ++k) {
        mobility[k] = k % 4 == 3 ? 0 : (ss_real)(100 * (1 + k / 4));
    }
    assert_true(ss_xpbd_packs_create(1, corner, regular_tetrahedron, &lambda, &mu, mobility, &arena,
                                     &packs));
    for (int m = 0; m < 2; ++m) {
        u[0] = (ss_real)2e-3;
        u[5] = (ss_real)-1e-3;
        memset(step, 0, sizeof step);
        ss_xpbd_pass pass = {.packs = &packs,
                             .kind = kinds[m],
                             .h = 1e-6,
                             .u = u,
                             .mobility = mobility,
                             .step = step,
                             .least = 1.0};
        ss_xpbd_kernels_get()->constrain(&pass);
        /* f = -V P grad N, from the law in double. */
        ss_tissue_law law = {.kind = kinds[m], .lambda = lambda, .mu = mu};
        const double volume = 8e-6 / 3.0;
        double h[9] = {0.0}, p[9], gradient[4][3], sum[3] = {0.0};
        for (int a = 0; a < 4; ++a) {
            ss_scale3(gradient[a], regular_tetrahedron[a], 2500.0);
            for (int i = 0; i < 3; ++i) {
                for (int j = 0; j < 3; ++j) {
                    h[3 * i + j] += (double)u[4 * a + i] * gradient[a][j];
                }
            }
        }
        ss_tissue_stress(&law, h, p);
        for (int a = 0; a < 4; ++a) {
            for (int i = 0; i < 3; ++i) {
                const double f = -volume * ss_dot3(p + 3 * i, gradient[a]);
                const double way = 1e-12 * (double)mobility[4 * a + i] * f;
                assert_near((double)step[4 * a + i], way, 1e-4 * 1e-12 * 400.0 * 0.1);
                sum[i] += (double)step[4 * a + i] / (double)mobility[4 * a + i];
            }
        }
        /* Stiff against the step: the same momentum, and the element at rest at once. */
        memset(step, 0, sizeof step);
        pass.h = 10.0;
        for (int sweep = 0; sweep < 20; ++sweep) {
            ss_xpbd_kernels_get()->constrain(&pass);
        }
        ss_set3(sum, 0.0, 0.0, 0.0);
        memset(h, 0, sizeof h);
        for (int a = 0; a < 4; ++a) {
            for (int i = 0; i < 3; ++i) {
                sum[i] += (double)step[4 * a + i] / (double)mobility[4 * a + i];
                for (int j = 0; j < 3; ++j) {
                    h[3 * i + j] +=
                        ((double)u[4 * a + i] + (double)step[4 * a + i]) * gradient[a][j];
                }
            }
        }
        assert_near(ss_norm3(sum), 0.0, 1e-9);
        assert_near(ss_tissue_energy(&law, h), 0.0, 1e-4 * mu);
    }
    ss_arena_free(&arena);
}

/* ---- refusals ---- */

TEST(the_cost_of_a_step_is_that_of_its_sub_steps)
{
    setup s;
    double cost[3];
    for (int k = 0; k < 3; ++k) {
        setup_soft(&s, 4, kinds[0], 0.3);
        s.plan.max_substeps = 64;
        give(&s, "substep_s", k == 0 ? 1e-3 : k == 1 ? 1e-4 : 1e-9);
        cost[k] = s.class->step_cost_us(&s.plan);
        setup_fini(&s);
    }
    /* One sub-step of a millisecond, ten, and no more than the budget. */
    assert_near((cost[2] - cost[0]) / (cost[1] - cost[0]), 63.0 / 9.0, 1e-9);
}

/* The constraints of |F| and J are two laws: a scene is offered these, and no other. */
TEST(every_law_that_is_offered_is_taken)
{
    const ss_param_row *row = &ss_model_find("xpbd")->row[0];
    assert_string_equal(row->name, "material");
    assert_string_equal(row->choices, "neo-hookean|stable-neo-hookean");
    for (int k = 0; k <= (int)row->range.max; ++k) {
        setup s;
        setup_soft(&s, 1, kinds[k], 0.3);
        assert_int_equal(setup_create(&s), SOFTSIM_OK);
        setup_fini(&s);
    }
    assert_near(row->fallback, 1.0, 0.0); /* stable-neo-hookean */
}

TEST(wrong_scenes_are_refused)
{
    setup s;
    setup_soft(&s, 1, kinds[0], 0.3);
    give(&s, "youngs_modulus_pa", -1.0); /* refused also where nobody wants to know why */
    assert_int_equal(ss_model_create(s.class, &s.plan, &s.model, NULL), SOFTSIM_ERROR_SCENE);
    setup_fini(&s);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
