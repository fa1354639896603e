/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include "hybrid_fixture.h"
#include "rt/each.h"
#include "rt/random.h"

static const double origin[3] = {0.0, 0.0, 0.0};

/* A block whose upper half is the layer. */
static ss_mesh *make_block(const double low[3])
{
    const int n[3] = {5, 5, 4};
    return make_bar(n, 0.2, low, 0.3, is_below_2);
}

static const double gradient[3][3] = {
    {0.02, -0.03, 0.01}, {0.015, 0.04, -0.02}, {0.0, 0.03, -0.01}};

/* ---- rows ---- */

TEST(rows_reproduce_places)
{
    ss_mesh *mesh = make_block(origin);
    ss_layer *layer = NULL;
    const ss_layer_plan plan = {.mesh = mesh, .spacing = 0.07};
    assert_int_equal(ss_layer_create(&plan, &layer, NULL), SOFTSIM_OK);
    assert_true(layer->own_count > 500 && layer->count > layer->own_count);
    assert_near(layer->layer_volume, 0.4, 1e-9);
    const double tolerance = BY_TYPE(2e-6, 1e-12);
    double volume = 0.0;
    for (int32_t p = 0; p < layer->count; ++p) {
        double sum = 0.0;
        double x[3] = {0};
        for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
            sum += (double)layer->tie[t];
            ss_madd3(x, x, (double)layer->tie[t], mesh->position[layer->tie_node[t]]);
        }
        ss_sub3(x, x, layer->rest[p]);
        assert_near(sum, 1.0, tolerance);
        assert_near(ss_norm3(x), 0.0, tolerance);
        volume += p < layer->own_count ? layer->volume[p] : 0.0;
        assert_true((p < layer->own_count) == (layer->rest[p][2] > 0.4));
    }
    assert_near(volume, 0.4, 1e-9);
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        double x[3] = {0};
        double y[3] = {0};
        for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
            ss_madd3(x, x, (double)layer->skin[k], layer->rest[layer->skin_particle[k]]);
        }
        for (int32_t k = layer->skin_tie_first[s]; k < layer->skin_tie_first[s + 1]; ++k) {
            ss_madd3(y, y, (double)layer->skin_tie[k], mesh->position[layer->skin_tie_node[k]]);
        }
        ss_sub3(x, x, mesh->position[layer->skin_node[s]]);
        ss_sub3(y, y, mesh->position[layer->skin_node[s]]);
        assert_near(ss_norm3(x), 0.0, tolerance);
        assert_near(ss_norm3(y), 0.0, tolerance);
    }
    ss_layer_destroy(&layer);
    ss_mesh_destroy(&mesh);
}

/* Numbered by place, nodes of tetrahedra come first: no pass over the core goes past the skin. */
TEST(skin_is_numbered_last)
{
    ss_mesh *mesh = make_block(origin);
    assert_true(ss_mesh_renumber(mesh));
    int32_t last = 0;
    uint8_t *is_core = calloc((size_t)mesh->node_count, 1);
    int32_t count = 0;
    for (int32_t c = 0; c < 4 * mesh->tetrahedron_count; ++c) {
        const int32_t i = mesh->tetrahedron[c / 4][c % 4];
        last = i > last ? i : last;
        count += !is_core[i];
        is_core[i] = 1;
    }
    free(is_core);
    assert_true(count < mesh->node_count);
    assert_int_equal(last, count - 1);
    ss_mesh_destroy(&mesh);
}

/* Pairs are mutual and hold w X with X from one to the other; the most of a particle. */
static int32_t check_pairs(const ss_layer *layer)
{
    int32_t most = 0;
    for (int32_t p = 0; p < layer->count; ++p) {
        for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
            const int32_t q = layer->neighbour[t];
            const ss_real *row = layer->pair + 4 * (ptrdiff_t)t;
            bool is_mutual = false;
            for (int32_t m = layer->pair_first[q]; m < layer->pair_first[q + 1]; ++m) {
                is_mutual = is_mutual || layer->neighbour[m] == p;
            }
            assert_true(is_mutual);
            for (int a = 0; a < 3; ++a) {
                assert_near((double)(row[a] / row[3]), layer->rest[q][a] - layer->rest[p][a],
                            BY_TYPE(1e-6, 1e-13));
            }
        }
        const int32_t pairs = layer->pair_first[p + 1] - layer->pair_first[p];
        most = pairs > most ? pairs : most;
    }
    return most;
}

TEST(neighbours_are_mutual)
{
    ss_mesh *mesh = make_block(origin);
    ss_layer *layer = NULL;
    const ss_layer_plan plan = {.mesh = mesh, .spacing = 0.1};
    assert_int_equal(ss_layer_create(&plan, &layer, NULL), SOFTSIM_OK);
    /* Two shells: 6 at a spacing, 12 at root 2. */
    assert_int_equal(check_pairs(layer), 18);
    ss_layer_destroy(&layer);
    ss_mesh_destroy(&mesh);
}

/* Also where spacings differ so much that lists of the nearest end early: what is not mutual leaves
 * points behind when all sleeps. */
TEST(far_spacings_have_mutual_neighbours)
{
    setup s;
    setup_hybrid(&s, make_block(origin), 0.16);
    double *spacing = calloc((size_t)s.mesh->node_count, sizeof *spacing);
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        spacing[i] = s.mesh->position[i][0] < 0.5 ? 0.04 : 0.16;
    }
    s.param[SS_HYBRID_SPACING].per_node = spacing;
    give_row(&s, SS_HYBRID_MAX_ACTIVE, 400);
    ss_hybrid *hybrid = start_hybrid(&s);
    const ss_layer *layer = hybrid->layer;
    assert_true(check_pairs(layer) < SS_LAYER_MAX_PAIRS);
    for (int32_t p = 0; p < layer->own_count; ++p) {
        assert_true(layer->moment[8 * (ptrdiff_t)p + 6] > 0);
    }
    for (int32_t skin = 0; skin < layer->skin_count; skin += 5) {
        ss_hybrid_wake_around(hybrid, skin);
        ss_hybrid_reset_layer(hybrid);
        assert_int_equal(hybrid->point_count, 0);
    }
    free(spacing);
    setup_fini(&s);
}

/* A finer region has particles of half the spacing, the same volume, and exact gradients. */
TEST(spacing_may_differ)
{
    ss_mesh *mesh = make_block(origin);
    setup s;
    setup_hybrid(&s, mesh, 0.1);
    double *spacing = calloc((size_t)mesh->node_count, sizeof *spacing);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        spacing[i] = mesh->position[i][0] < 0.5 ? 0.05 : 0.1;
    }
    s.param[SS_HYBRID_SPACING].per_node = spacing;
    wake_all(&s);
    ss_hybrid *hybrid = start_hybrid(&s);
    const ss_layer *layer = hybrid->layer;
    double volume = 0.0;
    int32_t fine = 0;
    for (int32_t p = 0; p < layer->own_count; ++p) {
        volume += layer->volume[p];
        fine += layer->spacing[p] < 0.06;
        assert_true(layer->rest[p][0] > 0.3 || layer->spacing[p] < 0.06);
        assert_true(layer->rest[p][0] < 0.7 || layer->spacing[p] > 0.06);
    }
    assert_near(volume, 0.4, 1e-9);
    assert_true(fine > layer->own_count / 2);
    set_affine(hybrid, gradient, origin);
    double energy;
    free(forces_of(hybrid, &energy));
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        for (int a = 0; a < 9; ++a) {
            assert_near((double)hybrid->gradient[8 * (1 + 3 * k + a % 3) + a / 3],
                        gradient[a / 3][a % 3], BY_TYPE(5e-6, 1e-12));
        }
    }
    free(spacing);
    setup_fini(&s);
}

/* ---- one volume ---- */

/* Whatever is awake, an affine map has the energy of the whole volume, and every gradient is its
 * own: ghosts, cells and particles. */
TEST(affine_maps_are_exact)
{
    for (int awake = 0; awake < 3; ++awake) {
        setup s;
        setup_hybrid(&s, make_block(origin), 0.07);
        give_row(&s, SS_HYBRID_COHESION, 0.0); /* which is no function of the strain alone */
        give_row(&s, SS_HYBRID_MAX_ACTIVE, 60);
        if (awake == 2) {
            wake_all(&s);
        }
        ss_hybrid *hybrid = start_hybrid(&s);
        if (awake == 1) {
            ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 2);
            assert_int_equal(hybrid->awake_count, 60);
        }
        assert_true(awake != 2 || hybrid->awake_count == hybrid->layer->own_count);
        set_affine(hybrid, gradient, origin);
        const ss_tissue_law law = {.kind = SS_TISSUE_STVK_GUARDED, .lambda = 5.5, .mu = 2.5};
        double energy, flat[9];
        memcpy(flat, gradient, sizeof flat);
        free(forces_of(hybrid, &energy));
        const double exact = 0.8 * ss_tissue_energy(&law, flat);
        assert_near(energy / exact, 1.0, BY_TYPE(1e-4, 1e-9));
        /* What the step's bound follows: |2E|, the same everywhere. */
        double square = 0.0;
        for (int a = 0; a < 9; ++a) {
            const double *g[2] = {gradient[a / 3], gradient[a % 3]};
            double twice = g[0][a % 3] + g[1][a / 3];
            for (int k = 0; k < 3; ++k) {
                twice += gradient[k][a / 3] * gradient[k][a % 3];
            }
            square += twice * twice;
        }
        assert_near(hybrid->strain / sqrt(square), 1.0, BY_TYPE(1e-4, 1e-9));
        for (int32_t k = 0; k < hybrid->point_count; ++k) {
            for (int a = 0; a < 9; ++a) {
                assert_near((double)hybrid->gradient[8 * (1 + 3 * k + a % 3) + a / 3],
                            gradient[a / 3][a % 3], BY_TYPE(5e-6, 1e-12));
            }
        }
        for (int32_t k = 0; k < hybrid->cells.count; ++k) {
            for (int a = 0; a < 9; ++a) {
                assert_near((double)hybrid->cells.gradient[8 * (1 + 3 * k + a % 3) + a / 3],
                            gradient[a / 3][a % 3], BY_TYPE(5e-6, 1e-12));
            }
        }
        setup_fini(&s);
    }
}

/* All awake are all awake, also where each ghost of a thin core is blended in. */
TEST(all_of_a_layer_wake)
{
    setup s;
    setup_hybrid(&s, make_bar((const int[3]){10, 10, 3}, 0.1, origin, 0.0, is_below_1), 0.1);
    wake_all(&s);
    const ss_hybrid *hybrid = start_hybrid(&s);
    assert_int_equal(hybrid->awake_count, hybrid->layer->own_count);
    assert_int_equal(hybrid->point_count, hybrid->layer->count);
    setup_fini(&s);
}

/* The least reach that a scene can give wakes nobody, and is no end of work to set up. */
TEST(least_reach_is_none)
{
    setup s;
    setup_hybrid(&s, make_block(origin), 0.1);
    give_row(&s, SS_HYBRID_ACTIVATE, 4.9e-324);
    assert_int_equal(start_hybrid(&s)->awake_count, 0);
    setup_fini(&s);
}

static void shake(const ss_hybrid *hybrid, double size)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    uint64_t seed = 3;
    for (int32_t i = 0; i < nodes->count; ++i) {
        for (int a = 0; a < 3; ++a) {
            const double random = ss_random_unit(&seed) - 0.5;
            nodes->u[4 * (ptrdiff_t)i + a] = has_mass(hybrid, i) ? (ss_real)(size * random) : 0;
        }
    }
}

/* Force = -dE/dx of every term, with cohesion, residual and an awake region among sleepers. */
TEST(force_is_the_slope_of_energy)
{
    setup s;
    setup_hybrid(&s, make_block(origin), 0.1);
    give_row(&s, SS_HYBRID_MAX_ACTIVE, 40);
    give_row(&s, SS_HYBRID_COHESION, 0.2);
    ss_hybrid *hybrid = start_hybrid(&s);
    ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 3);
    shake(hybrid, 0.02);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    double energy;
    ss_real *force = forces_of(hybrid, &energy);
    const double h = BY_TYPE(1e-3, 1e-5);
    const double scale = largest_quad(nodes->count, force);
    for (int32_t i = 0; i < nodes->count; i += 7) {
        if (!has_mass(hybrid, i)) {
            continue;
        }
        ss_real *u = nodes->u + 4 * (ptrdiff_t)i + i % 3;
        const ss_real kept = *u;
        double high, low;
        *u = kept + (ss_real)h;
        free(forces_of(hybrid, &high));
        *u = kept - (ss_real)h;
        free(forces_of(hybrid, &low));
        *u = kept;
        assert_near((double)force[4 * (ptrdiff_t)i + i % 3] / scale,
                    -(high - low) / (2.0 * h) / scale, BY_TYPE(5e-3, 1e-6));
    }
    free(force);
    setup_fini(&s);
}

/* A block of which forty particles may be awake, woken around a node of the skin. */
static ss_hybrid *start_woken(setup *s, const double low[3])
{
    setup_hybrid(s, make_block(low), 0.1);
    give_row(s, SS_HYBRID_MAX_ACTIVE, 40);
    ss_hybrid *hybrid = start_hybrid(s);
    ss_hybrid_wake_around(hybrid, hybrid->layer->skin_count / 3);
    return hybrid;
}

/* The tangent is the force's change; the cohesion's is taken at rest, so the state is near it. */
TEST(tangent_is_the_change_of_force)
{
    setup s;
    ss_hybrid *hybrid = start_woken(&s, origin);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    const size_t size = (size_t)nodes->padded_count * 4 * sizeof(ss_real);
    double energy;
    shake(hybrid, BY_TYPE(1e-4, 1e-6));
    ss_real *force = forces_of(hybrid, &energy);
    ss_real *x = aligned_alloc(64, size);
    ss_real *product = aligned_alloc(64, size);
    memcpy(x, nodes->u, size);
    memset(product, 0, size);
    memset(nodes->u, 0, size);
    free(forces_of(hybrid, &energy));
    ss_hybrid_tangent(hybrid, x, product);
    const double scale = largest_quad(nodes->count, force);
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes->count; ++k) {
        assert_near((double)product[k] / scale, -(double)force[k] / scale, BY_TYPE(4e-3, 2e-4));
    }
    SS_EACH(free, force, x, product);
    setup_fini(&s);
}

/* Largest force of a rotation over that of a stretch by 1 %, the block's corner at `low`. */
static double rotation_noise(const double low[3])
{
    setup s;
    ss_hybrid *hybrid = start_woken(&s, low);
    const double turn[3][3] = {
        {cos(0.3) - 1.0, -sin(0.3), 0.0}, {sin(0.3), cos(0.3) - 1.0, 0.0}, {0.0, 0.0, 0.0}};
    const double stretch[3][3] = {{0.01, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    double largest[2];
    for (int k = 0; k < 2; ++k) {
        double back[3], energy;
        for (int a = 0; a < 3; ++a) {
            back[a] = -ss_dot3(k == 0 ? stretch[a] : turn[a], low);
        }
        set_affine(hybrid, k == 0 ? stretch : turn, back);
        ss_real *force = forces_of(hybrid, &energy);
        largest[k] = largest_quad(ss_body_read_nodes(hybrid->body)->count, force);
        free(force);
    }
    setup_fini(&s);
    return largest[1] / largest[0];
}

TEST(rigid_motion_is_free)
{
    const double far[3] = {1000.0, -500.0, 200.0}; /* where a double has 1e-13 for a millimetre */
    assert_near(rotation_noise(origin), 0.0, BY_TYPE(1e-3, 1e-11));
    assert_near(rotation_noise(far), 0.0, BY_TYPE(1e-2, 1e-9));
}

/* Inner forces of a free body sum to nothing, and so do their torques. */
TEST(inner_forces_balance)
{
    setup s;
    ss_hybrid *hybrid = start_woken(&s, origin);
    shake(hybrid, 0.03);
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    double energy;
    double sum[3] = {0};
    double torque[3] = {0};
    double size = 0.0;
    ss_real *force = forces_of(hybrid, &energy);
    for (int32_t i = 0; i < nodes->count; ++i) {
        if (has_mass(hybrid, i)) {
            double x[3] = {0};
            double turn[3];
            const double f[3] = {(double)force[4 * (ptrdiff_t)i],
                                 (double)force[4 * (ptrdiff_t)i + 1],
                                 (double)force[4 * (ptrdiff_t)i + 2]};
            rest_of(hybrid, i, x);
            for (int a = 0; a < 3; ++a) {
                x[a] += (double)nodes->u[4 * (ptrdiff_t)i + a];
            }
            ss_cross3(turn, x, f);
            ss_add3(sum, sum, f);
            ss_add3(torque, torque, turn);
            size += ss_norm3(f);
        }
    }
    assert_near(ss_norm3(sum) / size, 0.0, BY_TYPE(1e-6, 1e-14));
    assert_near(ss_norm3(torque) / size, 0.0, BY_TYPE(1e-6, 1e-14));
    free(force);
    setup_fini(&s);
}

/* Both paths of the kernels agree, and each with itself. */
TEST(paths_agree)
{
    setup s;
    ss_hybrid *hybrid = start_woken(&s, origin);
    shake(hybrid, 0.03);
    double energy[2];
    ss_real *force[2];
    hybrid->kernels = ss_layer_kernels_path(0);
    force[0] = forces_of(hybrid, &energy[0]);
    for (int32_t path = 1; ss_layer_kernels_path(path) != NULL; ++path) {
        hybrid->kernels = ss_layer_kernels_path(path);
        force[1] = forces_of(hybrid, &energy[1]);
        const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
        const double scale = largest_quad(nodes->count, force[0]);
        for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)nodes->count; ++k) {
            assert_near((double)force[1][k] / scale, (double)force[0][k] / scale,
                        BY_TYPE(1e-5, 1e-13));
        }
        assert_near(energy[1] / energy[0], 1.0, BY_TYPE(1e-5, 1e-13));
        free(force[1]);
    }
    free(force[0]);
    setup_fini(&s);
}

/* ---- the pair curve ---- */

TEST(pair_potential_is_as_derived)
{
    double slope;
    assert_near(ss_layer_pair_potential(1.0, &slope), -1.0, 1e-15);
    assert_near(slope, 0.0, 1e-15);
    const double h = 1e-5;
    double unused;
    const double at[] = {0.3, 0.65, 0.8, 1.0, 1.2, 1.4, 1.6, 3.0};
    double steepest = 0.0;
    double where = 0.0;
    for (size_t k = 0; k < sizeof at / sizeof *at; ++k) {
        const double high = ss_layer_pair_potential(at[k] + h, &unused);
        const double low = ss_layer_pair_potential(at[k] - h, &unused);
        (void)ss_layer_pair_potential(at[k], &slope);
        assert_near(slope, (high - low) / (2.0 * h), 1e-6 * fmax(1.0, fabs(slope)));
    }
    /* Stiffness 3 at rest, strongest pull at root 2. */
    (void)ss_layer_pair_potential(1.0 + h, &slope);
    assert_near(slope / h, 3.0, 1e-3);
    for (double s = 1.0; s < 1.41; s += 0.001) {
        (void)ss_layer_pair_potential(s, &slope);
        if (slope > steepest) {
            steepest = slope;
            where = s;
        }
    }
    assert_near(where, SS_LAYER_TAIL, 0.01);
}

/* ---- refusals ---- */

static bool is_everywhere(int i, int j, int k)
{
    (void)i;
    (void)j;
    (void)k;
    return true;
}

static void refuse(setup *s, const char *word)
{
    if (setup_create(s) == SOFTSIM_OK) {
        fail_msg("nothing refused where '%s' is at fault", word);
    }
    if (strstr(s->error.text, word) == NULL || s->error.fault_count != 1) {
        fail_msg("%d faults, not one that says '%s': %s", s->error.fault_count, word,
                 s->error.text);
    }
    assert_null(s->model);
    setup_fini(s);
}

TEST(wrong_layers_are_refused)
{
    const int n[3] = {2, 2, 2};
    setup s;
    setup_hybrid(&s, make_bar(n, 0.2, origin, 0.0, is_everywhere), 0.1);
    refuse(&s, "layer");
    setup_hybrid(&s, make_block(origin), 1.0);
    refuse(&s, "layer.spacing_m");
    setup_hybrid(&s, make_block(origin), 1e-4);
    refuse(&s, "coarser");
    setup_hybrid(&s, make_block(origin), 0.006);
    refuse(&s, "particles, more than");
    setup_hybrid(&s, make_block(origin), 0.1);
    give_row(&s, SS_HYBRID_ACTIVATE, 0.2);
    give_row(&s, SS_HYBRID_DEACTIVATE, 0.1);
    refuse(&s, "layer.deactivate_m");
    setup_hybrid(&s, make_block(origin), 0.1);
    give_row(&s, SS_HYBRID_ACTIVATE, 1e6);
    give_row(&s, SS_HYBRID_MAX_ACTIVE, 50);
    refuse(&s, "layer.max_active");
    /* Nodes of the outer surface ride on the particles: a set of nothing else would do nothing. */
    setup_hybrid(&s, make_block(origin), 0.1);
    int32_t top[1] = {-1};
    for (int32_t i = 0; i < s.mesh->node_count; ++i) {
        top[0] = top[0] < 0 || s.mesh->position[i][2] > s.mesh->position[top[0]][2] ? i : top[0];
    }
    double down[1][3] = {{0.0, 0.0, -0.01}};
    const ss_prescribed set = {
        .node = top, .node_count = 1, .displacement = down, .axis = {true, true, true}};
    s.fixed[top[0]] = 0;
    s.plan.prescribed = &set;
    s.plan.prescribed_count = 1;
    refuse(&s, "drives nothing");
    /* Nor would a support of nothing else hold the core. */
    setup_hybrid(&s, make_block(origin), 0.1);
    s.fixed[top[0]] = 7;
    refuse(&s, "the core would fall");
    /* Nor would a load. */
    for (int is_pressure = 0; is_pressure < 2; ++is_pressure) {
        setup_hybrid(&s, make_block(origin), 0.1);
        int32_t *lid = calloc((size_t)s.mesh->node_count, sizeof *lid);
        ss_load load = {.node = lid,
                        .force = {0.0, 0.0, -0.1},
                        .is_pressure = is_pressure == 1,
                        .pressure = 0.5,
                        .to = (double)INFINITY};
        for (int32_t i = 0; i < s.mesh->node_count; ++i) {
            if (s.mesh->position[i][2] > 0.79) {
                lid[load.node_count++] = i;
            }
        }
        s.plan.load = &load;
        s.plan.load_count = 1;
        refuse(&s, "ride on");
        free(lid);
    }
    setup_hybrid(&s, make_block(origin), 0.1);
    give_row(&s, SS_FEM_LOCKING_CURE, 2.0);
    refuse(&s, "locking_cure");
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
