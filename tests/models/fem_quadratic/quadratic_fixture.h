/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Bodies of ten-node tetrahedra with their insides open. cmocka comes first. */
#include "common/block_fixture.h"
#include "common/quads_fixture.h"
#include "common/setup_fixture.h"
#include "models/fem_quadratic/quadratic.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { TEST_SPLIT = SS_FEM_LOCKING_CURE };

typedef struct open_body {
    setup s;
    ss_arena arena;
    ss_fem_material material;
    ss_quadratic_raised raised;
    ss_quadratic own;
} open_body;

/* Takes `mesh`; `bend` (m): every side's node moves by a wave of that height along x, a quadratic
 * field in the body whose offsets are parallel. */
static inline void open_init_with(open_body *b, ss_mesh *mesh, int kind, double ratio, double bend,
                                  bool is_curved)
{
    memset(b, 0, sizeof *b);
    setup_init(&b->s, "fem-quadratic", mesh);
    give(&b->s, "youngs_modulus_pa", 1e4);
    give(&b->s, "poisson_ratio", ratio);
    give(&b->s, "viscosity_phi_pa_s", 3.0);
    give(&b->s, "viscosity_psi_pa_s", 5.0);
    give(&b->s, "material", kind);
    assert_int_equal(ss_fem_material_read(&b->s.plan, "test", &b->arena, &b->material, NULL),
                     SOFTSIM_OK);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        b->material.lambda_own[e] = fmin(b->material.lambda[e], b->material.mu[e] / 3.0);
    }
    assert_int_equal(ss_quadratic_raise(&b->s.plan, is_curved, &b->arena, &b->raised, NULL),
                     SOFTSIM_OK);
    for (int32_t i = b->raised.given_count; i < b->raised.mesh.node_count; ++i) {
        b->raised.mesh.position[i][0] += bend * random_unit();
    }
    assert_int_equal(ss_quadratic_create(&b->raised, &b->material, 0.0, &b->arena, &b->own),
                     SOFTSIM_OK);
}

static inline void open_init(open_body *b, ss_mesh *mesh, int kind, double ratio, double bend)
{
    open_init_with(b, mesh, kind, ratio, bend, false);
}

static inline void open_fini(open_body *b)
{
    ss_arena_free(&b->arena);
    setup_fini(&b->s);
}
