/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Bodies of tetrahedra with their insides open: shared by the tests of fem. cmocka comes first. */
#include "common/block_fixture.h"
#include "common/quads_fixture.h"
#include "common/setup_fixture.h"
#include "mesh/tetrahedron.h"
#include "models/common/body.h"
#include "models/common/fem_elastic.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- a body ---- */

/* The model with its insides open, by open_elastic and open_up. */
struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    ss_fem *fem;
    ss_fem_material material;
    double *mass;
    ss_body_nodes *nodes;
};

/* Takes `mesh`: E = 10 kPa, nu = 0.3, 1000 kg/m^3, all else at its default. */
static inline void setup_fem(setup *s, ss_mesh *mesh)
{
    setup_init(s, "fem", mesh);
    give_row(s, SS_FEM_YOUNGS_MODULUS, 1e4);
    give_row(s, SS_FEM_POISSON_RATIO, 0.3);
}

static inline void setup_block(setup *s, const int cells[3], const double size[3], double jitter)
{
    block_size block = {.jitter = jitter};
    memcpy(block.cells, cells, sizeof block.cells);
    memcpy(block.size, size, sizeof block.size);
    setup_fem(s, make_block(&block));
}

/* Fixes the nodes with a coordinate at its least. */
static inline void fix_low(setup *s, int axis)
{
    double low = s->mesh->position[0][axis];
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        low = fmin(low, s->mesh->position[i][axis]);
    }
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][axis] < low + 1e-9 ? 7 : s->fixed[i];
    }
}

static inline void open_destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_fem_destroy(&model->fem);
    ss_arena_free(&model->arena);
    free(model->mass);
    free(model);
}

static inline void open_step(ss_model *model, double time, double dt, const ss_model_tool *tool)
{
    ss_body_step(model->body, time, dt, tool);
    ss_fem_judge(model->fem, model->body);
}

/* Material and elastic body alone. */
static inline void open_elastic(setup *s)
{
    static const ss_model_class open_class = {.name = "fem",
                                              .destroy = open_destroy,
                                              .step = open_step,
                                              .info = ss_body_model_info,
                                              .displacement = ss_body_model_displacement};
    ss_model *model = calloc(1, sizeof *model);
    s->class = &open_class;
    s->model = model;
    assert_int_equal(
        ss_fem_material_create(&s->plan, "fem", &model->arena, &model->material, &s->error),
        SOFTSIM_OK);
    model->mass = calloc((size_t)s->mesh->node_count, sizeof *model->mass);
    ss_body_volume_masses(s->mesh, model->material.density, true, model->mass);
    const ss_fem_setup own = {.mesh = s->mesh,
                              .material = &model->material,
                              .node_count = s->mesh->node_count,
                              .mass = model->mass,
                              .fixed = s->fixed};
    assert_int_equal(ss_fem_create(&own, &model->fem), SOFTSIM_OK);
}

/* As the model does it. */
static inline void open_up(setup *s)
{
    open_elastic(s);
    ss_model *model = s->model;
    const ss_body_plan body = ss_fem_plan_body(model->fem, &s->plan, &model->material, model->mass);
    if (ss_body_create(&body, &model->body, &s->error) != SOFTSIM_OK) {
        fail_msg("create: %s", s->error.text);
    }
    model->nodes = ss_body_get_nodes(model->body);
    model->fem->u = model->nodes->u;
    assert_int_equal(ss_body_start(model->body), SOFTSIM_OK);
}

/* Elements whose volume is below `share` of that at rest. */
static inline int32_t squeezed(const setup *s, double share)
{
    int32_t count = 0;
    for (int32_t e = 0; e < s->mesh->tetrahedron_count; ++e) {
        const int32_t *c = s->mesh->tetrahedron[e];
        double x[2][4][3], g[4][3];
        for (int a = 0; a < 4; ++a) {
            for (int k = 0; k < 3; ++k) {
                x[0][a][k] = s->mesh->position[c[a]][k];
                x[1][a][k] = x[0][a][k] + moved(s, c[a], k);
            }
        }
        const double rest = ss_tetrahedron_gradients(x[0][0], x[0][1], x[0][2], x[0][3], g);
        count += ss_tetrahedron_gradients(x[1][0], x[1][1], x[1][2], x[1][3], g) < share * rest;
    }
    return count;
}

/* ---- fields ---- */

static inline double dot_quads(int32_t node_count, const ss_real *a, const ss_real *b)
{
    double sum = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)node_count; ++k) {
        sum += (double)a[k] * (double)b[k];
    }
    return sum;
}
