/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Bars of cubes cut into tetrahedra, some of them left to a particle layer, and a hybrid over them:
 * shared by the tests of the layer and of the model. cmocka comes first. */
#include "common/setup_fixture.h"
#include "models/hybrid/hybrid.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

/* nx x ny x nz cubes of edge h from `low`, of which those with is_core(i, j, k) are tetrahedra;
 * the surface is the whole bar's. Inner nodes are off by `jitter` edges at most, along x and y. */
typedef bool (*bar_core)(int i, int j, int k);

static inline ss_mesh *make_bar(const int n[3], double h, const double low[3], double jitter,
                                bar_core is_core)
{
    static const int cut[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                  {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    const int side[3] = {n[0] + 1, n[1] + 1, n[2] + 1};
    const int32_t nodes = side[0] * side[1] * side[2];
    const int32_t cubes = n[0] * n[1] * n[2];
    double(*x)[3] = calloc((size_t)nodes, sizeof *x);
    int32_t(*all)[4] = calloc((size_t)(6 * cubes), sizeof *all);
    int32_t(*core)[4] = calloc((size_t)(6 * cubes), sizeof *core);
    int32_t all_count = 0;
    int32_t core_count = 0;
    uint64_t seed = 7;
    for (int32_t i = 0; i < nodes; ++i) {
        const int at[3] = {i % side[0], i / side[0] % side[1], i / side[0] / side[1]};
        for (int k = 0; k < 3; ++k) {
            const double random = ss_random_unit(&seed) - 0.5;
            const bool is_inside = k < 2 && at[k] > 0 && at[k] < n[k];
            x[i][k] = low[k] + h * (at[k] + (is_inside ? jitter * random : 0.0));
        }
    }
    for (int c = 0; c < cubes; ++c) {
        const int at[3] = {c % n[0], c / n[0] % n[1], c / n[0] / n[1]};
        for (int t = 0; t < 6; ++t) {
            int32_t corner[4];
            for (int a = 0; a < 4; ++a) {
                const int v = cut[t][a];
                corner[a] = at[0] + (v & 1) +
                            side[0] * (at[1] + (v >> 1 & 1) + side[1] * (at[2] + (v >> 2 & 1)));
            }
            memcpy(all[all_count++], corner, sizeof corner);
            if (is_core(at[0], at[1], at[2])) {
                memcpy(core[core_count++], corner, sizeof corner);
            }
        }
    }
    ss_mesh *whole = NULL;
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(nodes, (const double(*)[3])x, 0, NULL, all_count,
                                    (const int32_t(*)[4])all, &whole, NULL),
                     SOFTSIM_OK);
    assert_int_equal(ss_mesh_create(nodes, (const double(*)[3])x, whole->triangle_count,
                                    (const int32_t(*)[3])whole->triangle, core_count,
                                    (const int32_t(*)[4])core, &mesh, NULL),
                     SOFTSIM_OK);
    ss_mesh_destroy(&whole);
    free(x);
    free(all);
    free(core);
    return mesh;
}

/* ---- a hybrid ---- */

/* Takes the mesh; lambda 5.5, mu 2.5, density 1, nothing fixed, all asleep unless set otherwise
 * before start_hybrid. */
static inline void setup_hybrid(setup *s, ss_mesh *mesh, double spacing)
{
    setup_init(s, "hybrid", mesh);
    give_row(s, SS_FEM_LAMBDA, 5.5);
    give_row(s, SS_FEM_MU, 2.5);
    give_row(s, SS_FEM_DENSITY, 1.0);
    give_row(s, SS_HYBRID_SPACING, spacing);
    s->plan.working_force = 0.1;
    s->plan.step = 0.01;
    s->plan.max_substeps = 1000;
}

/* Everything awake, always. */
static inline void wake_all(setup *s)
{
    give_row(s, SS_HYBRID_ACTIVATE, 1e6);
    give_row(s, SS_HYBRID_MAX_ACTIVE, 1e6);
}

static inline ss_hybrid *start_hybrid(setup *s)
{
    create(s);
    return (ss_hybrid *)s->model;
}

/* Rest position of node i of the body: of the mesh, or of the particle that is awake in it. */
static inline void rest_of(const ss_hybrid *hybrid, int32_t i, double out[3])
{
    if (i < hybrid->mesh->node_count) {
        ss_copy3(out, hybrid->mesh->position[i]);
        return;
    }
    for (int32_t p = 0; p < hybrid->layer->own_count; ++p) {
        if (hybrid->node_of[p] == i) {
            ss_copy3(out, hybrid->layer->rest[p]);
        }
    }
}

static inline bool has_mass(const ss_hybrid *hybrid, int32_t i)
{
    return ss_body_read_nodes(hybrid->body)->mass[i] > 0.0;
}

/* u := G X + shift at every node that has mass. */
static inline void set_affine(const ss_hybrid *hybrid, const double g[3][3], const double shift[3])
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    for (int32_t i = 0; i < nodes->count; ++i) {
        double x[3] = {0};
        if (has_mass(hybrid, i)) {
            rest_of(hybrid, i, x);
            for (int a = 0; a < 3; ++a) {
                nodes->u[4 * (ptrdiff_t)i + a] = (ss_real)(shift[a] + ss_dot3(g[a], x));
            }
        }
    }
}

/* Forces at the body's state into a fresh array; frees with free. */
static inline ss_real *forces_of(ss_hybrid *hybrid, double *out_energy)
{
    const ss_body_nodes *nodes = ss_body_read_nodes(hybrid->body);
    ss_real *force = aligned_alloc(64, (size_t)nodes->padded_count * 4 * sizeof *force);
    ss_body_energy energy = {.is_wanted = true};
    memset(force, 0, (size_t)nodes->padded_count * 4 * sizeof *force);
    ss_hybrid_force(hybrid, nodes->u, nodes->v, force, &energy);
    *out_energy = energy.elastic;
    return force;
}

#define BELOW(layer)                                                                               \
    static inline bool is_below_##layer(int i, int j, int k)                                       \
    {                                                                                              \
        (void)i;                                                                                   \
        (void)j;                                                                                   \
        return k < (layer);                                                                        \
    }
BELOW(1)
BELOW(2)
BELOW(4)

/* A block of 1 x 1 x 0.8, its upper half a layer, held below, under a ball of 0.25. */
static inline void init_block(setup *s, int32_t max_active)
{
    setup_hybrid(s, make_bar((const int[3]){5, 5, 4}, 0.2, (const double[3]){0}, 0.2, is_below_2),
                 0.08);
    give_row(s, SS_HYBRID_ACTIVATE, 0.2);
    give_row(s, SS_HYBRID_MAX_ACTIVE, max_active);
    give_row(s, SS_FEM_MASS_DAMPING, 5.0);
    for (int32_t i = 0; i < s->mesh->node_count; ++i) {
        s->fixed[i] = s->mesh->position[i][2] == 0.0 ? 7 : 0;
    }
    add_sphere(s, 0, 0.25);
    s->plan.working_force = 0.5;
}

static inline ss_hybrid *start_block(setup *s, int32_t max_active)
{
    init_block(s, max_active);
    return start_hybrid(s);
}

/* Moves tool 0 in `steps` to x and `depth` below where it touches the block. */
static inline void move(setup *s, ss_model_tool tool[SOFTSIM_MAX_PROBES], double x, double depth,
                        int steps)
{
    const double to[3] = {x, 0.5, 1.05 - depth};
    double from[3];
    ss_copy3(from, tool[0].to.position);
    for (int k = 1; k <= steps; ++k) {
        tool[0].from = tool[0].to;
        for (int a = 0; a < 3; ++a) {
            tool[0].to.position[a] = from[a] + (to[a] - from[a]) * k / steps;
        }
        s->class->step(s->model, 0.0, 0.02, tool);
    }
}

static inline void start_tool(ss_model_tool tool[SOFTSIM_MAX_PROBES], double x)
{
    memset(tool, 0, SOFTSIM_MAX_PROBES * sizeof *tool);
    tool[0].is_present = true;
    tool[0].to = (ss_tool_pose){.position = {x, 0.5, 1.06}, .orientation = {1, 0, 0, 0}};
    tool[0].from = tool[0].to;
}
