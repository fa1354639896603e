/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* models/turned: every tetrahedron is looked at in time, what is inside out is said for as long as
 * it lasts, and every model that can leave one so says it. */
#include "common/test.h"

#include "common/chain_fixture.h"
#include "models/common/inverted.h"
#include "models/tissue_law.h"

static bool has_corner(const ss_mesh *mesh, int32_t t, int32_t node)
{
    const int32_t *c = mesh->tetrahedron[t];
    return c[0] == node || c[1] == node || c[2] == node || c[3] == node;
}

/* Through the block and out on its other side, so that its tetrahedra are mirrored; 0: back. */
static void take_through(const ss_mesh *mesh, int32_t node, double way, ss_real *u)
{
    for (int k = 0; k < 3; ++k) {
        u[4 * node + k] = (ss_real)(mesh->position[node][k] < 0.035 ? way : -way);
    }
}

TEST(a_tetrahedron_is_found_within_its_round)
{
    static const double period[3] = {1e-3, 1e-2, 1.0};
    ss_mesh *mesh = make_box(8, 8, 8, 0.01);
    ss_real *u = ss_memory_get(4 * (size_t)mesh->node_count, sizeof *u);
    for (int p = 0; p < 3; ++p) {
        ss_inverted inverted;
        ss_inverted_init(&inverted, mesh, period[p]);
        const int most = (int)fmax(1.0, 0.1 / period[p]);
        for (int32_t node = 0; node < mesh->node_count; node += 73) {
            for (int k = 0; k < 7; ++k) { /* from anywhere in its round */
                assert_int_equal(ss_inverted_look(&inverted, u), -1);
            }
            const uint64_t before = ss_inverted_hash(&inverted, 1);
            take_through(mesh, node, 0.1, u);
            int looks = 1;
            while (ss_inverted_look(&inverted, u) < 0 && looks <= most) {
                ++looks;
            }
            assert_true(looks <= most);
            assert_true(has_corner(mesh, inverted.found, node));
            assert_true(ss_inverted_hash(&inverted, 1) != before);
            for (int k = 0; k < 3 * most; ++k) { /* without a gap */
                assert_true(has_corner(mesh, ss_inverted_look(&inverted, u), node));
            }
            take_through(mesh, node, 0.0, u);
            for (looks = 1; ss_inverted_look(&inverted, u) >= 0 && looks <= most; ++looks) {
            }
            assert_true(looks <= most);
        }
    }
    ss_memory_free(u);
    ss_mesh_destroy(&mesh);
    mesh = make_plane(4);
    ss_inverted none;
    ss_inverted_init(&none, mesh, 1e-3);
    assert_int_equal(ss_inverted_look(&none, NULL), -1);
    ss_mesh_destroy(&mesh);
}

/* One tetrahedron comes back, another stays: it is said without a gap. */
TEST(one_after_the_other_is_said_without_a_gap)
{
    ss_mesh *mesh = make_box(8, 8, 8, 0.01);
    ss_real *u = ss_memory_get(4 * (size_t)mesh->node_count, sizeof *u);
    const int32_t last = mesh->node_count - 1;
    ss_inverted inverted;
    ss_inverted_init(&inverted, mesh, 1e-3);
    take_through(mesh, 0, 0.1, u);
    take_through(mesh, last, 0.1, u);
    while (ss_inverted_look(&inverted, u) < 0) {
    }
    const int32_t gone = has_corner(mesh, inverted.found, 0) ? 0 : last;
    take_through(mesh, gone, 0.0, u);
    for (int k = 0; k < 400; ++k) {
        assert_true(ss_inverted_look(&inverted, u) >= 0);
    }
    assert_true(has_corner(mesh, inverted.found, gone == 0 ? last : 0));
    ss_memory_free(u);
    ss_mesh_destroy(&mesh);
}

/* What was inside out leaves no trace in the order of the looks, which the hash leaves out. */
TEST(steps_alone_say_which_is_next)
{
    ss_mesh *mesh = make_box(4, 4, 4, 0.01);
    ss_real *u = ss_memory_get(4 * (size_t)mesh->node_count, sizeof *u);
    ss_inverted looked, passed;
    ss_inverted_init(&looked, mesh, 1e-3);
    ss_inverted_init(&passed, mesh, 1e-3);
    for (int k = 0; k < 50; ++k) {
        take_through(mesh, 0, k % 10 == 9 ? 0.1 : 0.0, u);
        (void)ss_inverted_look(&looked, u);
        if (k % 10 == 9) {
            (void)ss_inverted_look(&passed, u);
        } else {
            ss_inverted_pass(&passed);
            assert_int_equal(passed.found, -1);
        }
        assert_int_equal(passed.at, looked.at);
    }
    ss_memory_free(u);
    ss_mesh_destroy(&mesh);
}

/* ---- models ---- */

typedef struct kind {
    const char *model;
    struct {
        const char *row;
        double value;
    } given[6];
} kind;

static const kind kinds[] = {
    {.model = "chainmail"},
    {.model = "cnn-chainmail", .given = {{"tet_guard", 0.0}}},
    {.model = "mass-spring", .given = {{"youngs_modulus_pa", 1e4}}},
    {.model = "cnn-energy",
     .given = {{"domain", 1.0},
               {"modulus_pa", 3000.0},
               {"density_kg_m3", 1060.0},
               {"damping_n_s_per_m4", 1.6e5},
               {"rest_stiffness_n_per_m4", 4e6}}},
    {.model = "corotational",
     .given = {{"youngs_modulus_pa", 1e4}, {"poisson_ratio", 0.3}, {"density_kg_m3", 1000.0}}},
    {.model = "xpbd",
     .given = {{"youngs_modulus_pa", 1e4}, {"poisson_ratio", 0.3}, {"density_kg_m3", 1000.0}}},
    {.model = "fem",
     .given = {{"youngs_modulus_pa", 1e4},
               {"poisson_ratio", 0.3},
               {"density_kg_m3", 1000.0},
               {"mass_damping_per_s", 30.0},
               {"material", SS_TISSUE_LINEAR}}},
};

/* A corner of a block is taken through the node across its cell, and back. */
TEST(every_model_says_it_while_it_lasts)
{
    for (size_t m = 0; m < sizeof kinds / sizeof *kinds; ++m) {
        int32_t node[1] = {0};
        double way[1][3] = {{0.03, 0.03, 0.03}};
        setup s;
        setup_init(&s, kinds[m].model, make_box(3, 3, 3, 0.02));
        for (int k = 0; k < 6 && kinds[m].given[k].row; ++k) {
            give(&s, kinds[m].given[k].row, kinds[m].given[k].value);
        }
        for (int32_t i = 1; i < s.mesh->node_count; ++i) {
            s.fixed[i] = 7;
        }
        prescribe(&s, 1, node, way, 0.1);
        create(&s);
        steps(&s, 5, 1e-3);
        assert_int_equal(info_of(&s).worst_element, -1);
        steps(&s, 250, 1e-3);
        for (int k = 0; k < 10; ++k) {
            steps(&s, 1, 1e-3);
            const ss_model_info info = info_of(&s);
            assert_int_equal(info.verdict, SOFTSIM_VERDICT_DEGRADED);
            assert_non_null(strstr(info.reason, "inside out"));
            assert_true(info.worst_element >= 0);
            if (s.class->needs_volume) {
                assert_true(has_corner(s.mesh, info.worst_element, 0));
            } else {
                assert_true(info.worst_element < s.mesh->node_count);
            }
        }
        s.class->reset(s.model);
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        assert_int_equal(info_of(&s).worst_element, -1);
        way[0][0] = way[0][1] = way[0][2] = 0.0;
        steps(&s, 120, 1e-3);
        assert_int_equal(info_of(&s).verdict, SOFTSIM_VERDICT_GOOD);
        setup_fini(&s);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
