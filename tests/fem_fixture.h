/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Blocks of tetrahedra, and bodies of them with their insides open: shared by the tests of fem.
 * cmocka comes first. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh.h"
#include "models/body.h"
#include "models/fem.h"
#include "models/model.h"
#include "models/tetrahedron.h"
#include "rt/memory.h"
#include "rt/vec.h"

#ifdef SOFTSIM_DOUBLE
#define BY_TYPE(single, twice) (twice)
#else
#define BY_TYPE(single, twice) (single)
#endif

#define assert_near(a, b, tolerance)                                                               \
    do {                                                                                           \
        const double near_a = (a), near_b = (b), near_t = (tolerance);                             \
        if (!(fabs(near_a - near_b) <= near_t)) {                                                  \
            fail_msg("%s = %.17g, expected %.17g within %.3g", #a, near_a, near_b, near_t);        \
        }                                                                                          \
    } while (0)

static uint64_t random_state = 1;

static inline double random_unit(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) / 9007199254740992.0 * 2.0 - 1.0;
}

/* ---- meshes ------------------------------------------------------------------------------- */

typedef struct block_size {
    int cells[3];
    double size[3]; /* m */
    double jitter;  /* of a cell, inner nodes; at 0.45 some elements are slivers */
    double offset;  /* m, of all coordinates */
} block_size;

static inline int32_t block_node(const block_size *b, int i, int j, int k)
{
    return (k * (b->cells[1] + 1) + j) * (b->cells[0] + 1) + i;
}

/* Cells of six tetrahedra around a diagonal, all volumes above 0. */
static inline ss_mesh *make_block(const block_size *b)
{
    static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int nx = b->cells[0], ny = b->cells[1], nz = b->cells[2];
    const int32_t nodes = (nx + 1) * (ny + 1) * (nz + 1), count = 6 * nx * ny * nz;
    double(*x)[3] = calloc((size_t)nodes, sizeof *x);
    int32_t(*t)[4] = calloc((size_t)count, sizeof *t), e = 0;
    for (int k = 0; k <= nz; ++k) {
        for (int j = 0; j <= ny; ++j) {
            for (int i = 0; i <= nx; ++i) {
                const int at[3] = {i, j, k};
                double *p = x[block_node(b, i, j, k)];
                const bool is_inner = i > 0 && j > 0 && k > 0 && i < nx && j < ny && k < nz;
                for (int a = 0; a < 3; ++a) {
                    const double jump = is_inner ? b->jitter * random_unit() : 0.0;
                    p[a] = b->offset + b->size[a] * (at[a] + jump) / b->cells[a];
                }
            }
        }
    }
    for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j) {
            for (int i = 0; i < nx; ++i) {
                for (int p = 0; p < 6; ++p, ++e) {
                    int at[3] = {i, j, k};
                    double g[4][3];
                    t[e][0] = block_node(b, i, j, k);
                    for (int s = 0; s < 3; ++s) {
                        ++at[order[p][s]];
                        t[e][s + 1] = block_node(b, at[0], at[1], at[2]);
                    }
                    if (ss_tetrahedron_gradients(x[t[e][0]], x[t[e][1]], x[t[e][2]], x[t[e][3]],
                                                 g) < 0.0) {
                        const int32_t swap = t[e][2];
                        t[e][2] = t[e][3];
                        t[e][3] = swap;
                    }
                }
            }
        }
    }
    ss_mesh *mesh = NULL;
    (void)ss_mesh_create(nodes, (const double(*)[3])x, 0, NULL, count, (const int32_t(*)[4])t,
                         &mesh, NULL);
    free(x);
    free(t);
    return mesh;
}

/* ---- a body ------------------------------------------------------------------------------- */

/* What a test says of a body before it is made. */
typedef struct setup {
    ss_mesh *mesh;
    uint8_t *fixed;
    ss_param_value param[SS_FEM_ROW_COUNT];
    ss_load load[4];
    ss_prescribed prescribed[2];
    ss_model_plan plan;
    const ss_model_class *class;
    softsim_error error;
    ss_model *model; /* by create */
    double time;
    /* by open_up: the same with its insides open */
    ss_fem_material material;
    double *mass;
    ss_fem *fem;
    ss_body *body;
    ss_body_nodes *nodes;
} setup;

static inline void give(setup *s, int row, double value)
{
    s->param[row] = (ss_param_value){.number = value, .is_given = true};
}

/* Takes `mesh`: E = 10 kPa, nu = 0.3, 1000 kg/m^3, all else at its default. */
static inline void setup_init(setup *s, ss_mesh *mesh)
{
    memset(s, 0, sizeof *s);
    s->mesh = mesh;
    s->class = ss_model_find("fem");
    s->fixed = calloc((size_t)mesh->node_count, 1);
    for (int k = 0; k < s->class->row_count; ++k) {
        s->param[k].number = s->class->row[k].fallback;
    }
    give(s, SS_FEM_YOUNGS_MODULUS, 1e4);
    give(s, SS_FEM_POISSON_RATIO, 0.3);
    s->plan = (ss_model_plan){.mesh = mesh,
                              .fixed = s->fixed,
                              .param = s->param,
                              .load = s->load,
                              .prescribed = s->prescribed,
                              .working_force = 2.0,
                              .max_force = 8.0,
                              .step = 1e-3,
                              .max_substeps = 64,
                              .threads = 1};
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

static inline void create(setup *s)
{
    if (s->class->create(&s->plan, &s->model, &s->error) != SOFTSIM_OK) {
        fail_msg("create: %s", s->error.text);
    }
}

/* Material and elastic body alone. */
static inline void open_elastic(setup *s)
{
    assert_int_equal(ss_fem_material_create(&s->plan, "fem", &s->material, &s->error), SOFTSIM_OK);
    s->mass = calloc((size_t)s->mesh->node_count, sizeof *s->mass);
    ss_body_volume_masses(s->mesh, s->material.density, true, s->mass);
    const ss_fem_setup own = {.mesh = s->mesh,
                              .material = &s->material,
                              .node_count = s->mesh->node_count,
                              .mass = s->mass,
                              .fixed = s->fixed};
    assert_int_equal(ss_fem_create(&own, &s->fem), SOFTSIM_OK);
}

/* As the model does it. */
static inline void open_up(setup *s)
{
    open_elastic(s);
    const ss_body_plan body = {.name = "fem",
                               .plan = &s->plan,
                               .node_count = s->mesh->node_count,
                               .mass = s->mass,
                               .mass_damping = s->material.mass_damping,
                               .edge = ss_body_mean_edge(s->mesh),
                               .planned_step = 0.5 * ss_fem_rest_step(s->fem),
                               .step_share = 0.5,
                               .integrator = s->material.integrator,
                               .elastic = {.owner = s->fem,
                                           .force = ss_fem_force,
                                           .tangent = ss_fem_tangent,
                                           .diagonal = ss_fem_diagonal,
                                           .viscous_time = s->material.viscous_time,
                                           .stable_step = ss_fem_stable_step,
                                           .reset = ss_fem_reset,
                                           .hash = ss_fem_hash}};
    if (ss_body_create(&body, &s->body, &s->error) != SOFTSIM_OK) {
        fail_msg("create: %s", s->error.text);
    }
    s->nodes = ss_body_get_nodes(s->body);
    s->fem->u = s->nodes->u;
    assert_int_equal(ss_body_start(s->body), SOFTSIM_OK);
}

static inline void setup_fini(setup *s)
{
    if (s->model) {
        s->class->destroy(s->model);
    }
    ss_body_destroy(&s->body);
    ss_fem_destroy(&s->fem);
    ss_fem_material_fini(&s->material);
    free(s->mass);
    free(s->fixed);
    ss_mesh_destroy(&s->mesh);
}

static inline void steps(setup *s, int count, double dt)
{
    for (int k = 0; k < count; ++k) {
        if (s->model) {
            s->class->step(s->model, s->time, dt, NULL);
        } else {
            ss_body_step(s->body, s->time, dt, NULL);
            ss_fem_judge(s->fem, s->body);
        }
        s->time += dt;
    }
}

static inline ss_model_info info_of(const setup *s)
{
    ss_model_info info;
    if (s->model) {
        s->class->info(s->model, &info);
    } else {
        ss_body_info(s->body, &info);
    }
    return info;
}

static inline double moved(const setup *s, int32_t node, int axis)
{
    const ss_real *u = s->model ? s->class->displacement(s->model) : s->nodes->u;
    return (double)u[4 * (ptrdiff_t)node + axis];
}

static inline double largest_displacement(const setup *s)
{
    double largest = 0.0;
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            largest = fmax(largest, fabs(moved(s, i, k)));
        }
    }
    return largest;
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

/* ---- fields --------------------------------------------------------------------------------- */

static inline ss_real *quads(int32_t node_count)
{
    return ss_memory_get(((size_t)node_count + 7) / 8 * 8 * 4, sizeof(ss_real));
}

static inline ss_real *random_quads(int32_t node_count, double size)
{
    ss_real *q = quads(node_count);
    for (int32_t i = 0; i < node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            q[4 * (ptrdiff_t)i + k] = (ss_real)(size * random_unit());
        }
    }
    return q;
}

static inline double largest_quad(int32_t node_count, const ss_real *q)
{
    double largest = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)node_count; ++k) {
        largest = fmax(largest, fabs((double)q[k]));
    }
    return largest;
}

static inline double dot_quads(int32_t node_count, const ss_real *a, const ss_real *b)
{
    double sum = 0.0;
    for (ptrdiff_t k = 0; k < 4 * (ptrdiff_t)node_count; ++k) {
        sum += (double)a[k] * (double)b[k];
    }
    return sum;
}
