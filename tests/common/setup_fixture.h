/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A model as a test makes, steps and reads it: shared by all tests of models, whose own fixtures
 * add meshes and materials. cmocka comes first. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh.h"
#include "models/model.h"
#include "number_fixture.h"
#include "rt/hash.h"

enum { MAX_ROWS = 40 };

/* What a test says of a model before it is created, and the model. */
typedef struct setup {
    ss_mesh *mesh;
    uint8_t *fixed;
    ss_param_value param[MAX_ROWS];
    ss_load load[4];
    ss_prescribed prescribed[4];
    ss_model_plan plan;
    const ss_model_class *class;
    softsim_error error;
    ss_model *model; /* by create */
    double time;
} setup;

/* ---- before ---- */

static inline int row_of(const setup *s, const char *name)
{
    for (int k = 0; k < s->class->row_count; ++k) {
        if (strcmp(s->class->row[k].name, name) == 0) {
            return k;
        }
    }
    abort();
}

/* One prescribed set more: `way`, all axes of each node, reached within `ramp` seconds. */
static inline void prescribe(setup *s, int32_t count, int32_t *node, double (*way)[3], double ramp)
{
    s->prescribed[s->plan.prescribed_count++] = (ss_prescribed){.node = node,
                                                                .node_count = count,
                                                                .displacement = way,
                                                                .axis = {true, true, true},
                                                                .ramp = ramp};
}

static inline void give_row(setup *s, int row, double value)
{
    s->param[row] = (ss_param_value){.number = value, .is_given = true};
}

static inline void give(setup *s, const char *name, double value)
{
    give_row(s, row_of(s, name), value);
}

/* Takes `mesh`; nothing fixed, and no class: for what is not a model in the table. */
static inline void setup_mesh(setup *s, ss_mesh *mesh)
{
    memset(s, 0, sizeof *s);
    s->mesh = mesh;
    s->fixed = calloc((size_t)mesh->node_count, 1);
    s->plan = (ss_model_plan){.mesh = mesh,
                              .fixed = s->fixed,
                              .param = s->param,
                              .load = s->load,
                              .prescribed = s->prescribed,
                              .working_force = 2.0,
                              .max_force = 8.0,
                              .step = 1e-3,
                              .max_substeps = 64,
                              .threads = 2};
}

/* Takes `mesh`; all parameters at their defaults. */
static inline void setup_init(setup *s, const char *model, ss_mesh *mesh)
{
    setup_mesh(s, mesh);
    s->class = ss_model_find(model);
    assert_non_null(s->class);
    assert_true(s->class->row_count <= MAX_ROWS);
    for (int k = 0; k < s->class->row_count; ++k) {
        s->param[k].number = s->class->row[k].fallback;
    }
}

static inline void add_sphere(setup *s, int probe, double radius)
{
    s->plan.tool[probe].is_used = true;
    s->plan.tool[probe].shape = (ss_shape){.kind = SS_SHAPE_SPHERE, .radius = radius};
}

static inline softsim_status setup_create(setup *s)
{
    return ss_model_create(s->class, &s->plan, &s->model, &s->error);
}

static inline void create(setup *s)
{
    if (setup_create(s) != SOFTSIM_OK) {
        fail_msg("create: %s", s->error.text);
    }
}

static inline void setup_fini(setup *s)
{
    if (s->model) {
        s->class->destroy(s->model);
    }
    free(s->fixed);
    ss_mesh_destroy(&s->mesh);
}

/* No model of it: so, and with these words. */
static inline void expect_refusal(setup *s, softsim_status status, const char *words)
{
    assert_int_equal(setup_create(s), status);
    assert_non_null(strstr(s->error.text, words));
    setup_fini(s);
}

/* ---- in time ---- */

static inline void steps_with(setup *s, int count, double dt, const ss_model_tool *tool)
{
    for (int k = 0; k < count; ++k) {
        s->class->step(s->model, s->time, dt, tool);
        s->time += dt;
    }
}

static inline void steps(setup *s, int count, double dt)
{
    steps_with(s, count, dt, NULL);
}

static inline ss_model_info info_of(const setup *s)
{
    ss_model_info info;
    s->class->info(s->model, &info);
    return info;
}

/* What is stored and gone less what was brought in: 0 where the books are right. */
static inline double energy_gain(const setup *s)
{
    const ss_model_info info = info_of(s);
    return info.elastic + info.kinetic - info.work + info.dissipated;
}

static inline double moved(const setup *s, int32_t node, int axis)
{
    return (double)s->class->displacement(s->model)[4 * (ptrdiff_t)node + axis];
}

/* Of its state and its displacements. */
static inline uint64_t hash_of(const setup *s)
{
    return ss_hash_bytes(s->class->hash(s->model, SS_HASH_START), s->class->displacement(s->model),
                         4 * (size_t)s->mesh->node_count * sizeof(ss_real));
}

/* Of nodes' x, y and z; what is no number stays. */
static inline double largest_quad(int32_t node_count, const ss_real *q)
{
    double largest = 0.0;
    for (ptrdiff_t i = 0; i < node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double size = fabs((double)q[4 * i + k]);
            largest = isnan(largest) || size <= largest ? largest : size;
        }
    }
    return largest;
}

/* Along an axis. */
static inline double largest_displacement(const setup *s)
{
    return largest_quad(s->mesh->node_count, s->class->displacement(s->model));
}
