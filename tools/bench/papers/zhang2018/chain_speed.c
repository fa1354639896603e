/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhang2018/chain_speed.h"
/*
 * Poke: 15 elements of the surface nearest the highest point go down by 0.85 mean links in 200
 * steps, at the stable step and alpha .02. Full: the body's highest half of a percent of elements
 * is pulled up by a quarter of the body with alpha 0 until everything is stretched.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "models/model.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/order.h"
#include "rt/vec.h"

enum { PATCH = 15, POKE_STEPS = 200, FRAME = 8, FULL_SETTLE = 600, FULL_STEPS = 201 };

typedef struct bench {
    const ss_mesh *mesh;
    const ss_model_class *class;
    ss_model *model;
    ss_param_value *param;
    uint8_t *fixed;
    int32_t *node;
    double (*way)[3];
    int32_t node_count;
    ss_prescribed set;
    double stable, time;
} bench;

static double *sort_values;

static int by_height(const void *a, const void *b)
{
    const double x = sort_values[*(const int32_t *)a], y = sort_values[*(const int32_t *)b];
    return (x < y) - (x > y);
}

static void give(bench *b, const char *name, double value)
{
    for (int32_t k = 0; k < b->class->row_count; ++k) {
        if (strcmp(b->class->row[k].name, name) == 0) {
            b->param[k] = (ss_param_value){.number = value, .is_given = true};
        }
    }
}

/* Nodes in order of `value`, largest first; the caller frees. */
static int32_t *order_nodes(const ss_mesh *mesh, double *value)
{
    int32_t *order = malloc((size_t)mesh->node_count * sizeof *order);
    for (int32_t i = 0; order && i < mesh->node_count; ++i) {
        order[i] = i;
    }
    if (order) {
        sort_values = value;
        qsort(order, (size_t)mesh->node_count, sizeof *order, by_height);
    }
    return order;
}

/* Chooses the nodes that are driven and those that are fixed: the lowest hundredth of the height.
 */
static bool choose_nodes(bench *b, bool is_full)
{
    const ss_mesh *mesh = b->mesh;
    double *value = malloc((size_t)mesh->node_count * sizeof *value);
    double low = (double)INFINITY, high = -(double)INFINITY, middle[2] = {0.0, 0.0};
    for (int32_t i = 0; value && i < mesh->node_count; ++i) {
        low = fmin(low, mesh->position[i][2]);
        high = fmax(high, mesh->position[i][2]);
        middle[0] += mesh->position[i][0] / mesh->node_count;
        middle[1] += mesh->position[i][1] / mesh->node_count;
    }
    for (int32_t i = 0; value && i < mesh->node_count; ++i) {
        const double *p = mesh->position[i];
        b->fixed[i] = p[2] < low + 0.01 * (high - low) ? 7 : 0;
        /* near the axis through the middle, and high */
        value[i] = is_full ? p[2] : p[2] - hypot(p[0] - middle[0], p[1] - middle[1]);
    }
    int32_t *order = value ? order_nodes(mesh, value) : NULL;
    b->node_count = is_full ? PATCH + mesh->node_count / 200 : PATCH;
    const double way = is_full ? 0.25 * (high - low) : 0.0;
    b->node = calloc((size_t)b->node_count, sizeof *b->node);
    b->way = calloc((size_t)b->node_count, sizeof *b->way);
    const bool is_good = order && b->node && b->way;
    for (int32_t k = 0; is_good && k < b->node_count; ++k) {
        b->node[k] = order[k];
        b->way[k][2] = way;
    }
    free(order);
    free(value);
    return is_good;
}

static void finish(bench *b)
{
    if (b->model) {
        b->class->destroy(b->model);
    }
    SS_EACH(free, b->param, b->fixed, b->node, b->way);
}

static bool start(bench *b, const ss_mesh *mesh, bool is_full, softsim_error *error)
{
    *b = (bench){.mesh = mesh, .class = ss_model_find("cnn-chainmail")};
    if (!b->class) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "cnn-chainmail is not built in");
        return false;
    }
    b->param = calloc((size_t)b->class->row_count, sizeof *b->param);
    b->fixed = calloc((size_t)mesh->node_count, 1);
    if (!b->param || !b->fixed || !choose_nodes(b, is_full)) {
        return false;
    }
    for (int32_t k = 0; k < b->class->row_count; ++k) {
        b->param[k].number = b->class->row[k].fallback;
    }
    give(b, "alpha", is_full ? 0.0 : 0.02);
    give(b, "capacitance_s", 1.0);
    give(b, "coarse_cells", 0.0);
    give(b, "tet_guard", 0.0);
    give(b, "unloading", 2.0); /* keep */
    b->set = (ss_prescribed){.node = b->node,
                             .node_count = b->node_count,
                             .displacement = b->way,
                             .axis = {true, true, true}};
    const ss_model_plan plan = {.mesh = mesh,
                                .fixed = b->fixed,
                                .param = b->param,
                                .prescribed = &b->set,
                                .prescribed_count = 1,
                                .step = 1e-3,
                                .max_substeps = 64,
                                .threads = 1};
    if (ss_model_create(b->class, &plan, &b->model, error) != SOFTSIM_OK) {
        return false;
    }
    ss_model_info info;
    b->class->info(b->model, &info);
    b->stable = 0.999 * info.stable_step;
    return true;
}

/* One step of `count` sub-steps; returns its microseconds. */
static double step(bench *b, int count)
{
    const int64_t before = ss_clock_thread_cpu_ns();
    b->class->step(b->model, b->time, count * b->stable, NULL);
    b->time += count * b->stable;
    return 1e-3 * (double)(ss_clock_thread_cpu_ns() - before);
}

static bool measure_full(const ss_mesh *mesh, ss_chain_speed *out, softsim_error *error)
{
    bench b;
    double took[FULL_STEPS];
    const bool is_good = start(&b, mesh, true, error);
    for (int k = 0; is_good && k < FULL_SETTLE; ++k) {
        (void)step(&b, 1);
    }
    for (int k = 0; is_good && k < FULL_STEPS; ++k) {
        took[k] = step(&b, 1);
    }
    if (is_good) {
        qsort(took, FULL_STEPS, sizeof *took, ss_compare_doubles);
        out->full_us = took[FULL_STEPS / 2];
    }
    finish(&b);
    return is_good;
}

/* Down by 0.85 links in 200 sub-steps; in steps of `count` sub-steps. */
static bool measure_poke(const ss_mesh *mesh, double link, int count, ss_chain_speed *out,
                         softsim_error *error)
{
    bench b;
    const bool is_good = start(&b, mesh, false, error);
    const int steps = POKE_STEPS / count;
    double sum = 0.0, most = 0.0, visits = 0.0;
    for (int k = 1; is_good && k <= steps; ++k) {
        for (int32_t i = 0; i < b.node_count; ++i) {
            b.way[i][2] = -0.85 * link * fmin(1.0, (double)k / steps);
        }
        const double took = step(&b, count);
        ss_model_info info;
        b.class->info(b.model, &info);
        sum += took;
        most = fmax(most, took);
        visits += info.active_nodes;
    }
    if (is_good && count > 1) {
        out->frame_us = sum / steps;
        out->frame_max_us = most;
    } else if (is_good) {
        out->poke_us = sum / steps;
        out->visits = visits / steps;
    }
    finish(&b);
    return is_good;
}

static bool measure(const ss_mesh *mesh, double link, bool has_full, ss_chain_speed *out,
                    softsim_error *error)
{
    out->nodes = mesh->node_count;
    out->elements = ss_mesh_element_count(mesh);
    return measure_poke(mesh, link, 1, out, error) && measure_poke(mesh, link, FRAME, out, error) &&
           (!has_full || measure_full(mesh, out, error));
}

/* n^3 nodes 10 mm apart, six tetrahedra a cube. */
static ss_mesh *make_block(int32_t n, softsim_error *error)
{
    static const int32_t path[6][2] = {{0, 1}, {1, 0}, {0, 2}, {2, 0}, {1, 2}, {2, 1}};
    const int32_t stride[3] = {1, n, n * n};
    const size_t nodes = (size_t)n * (size_t)n * (size_t)n,
                 cubes = (size_t)(n - 1) * (size_t)(n - 1) * (size_t)(n - 1);
    double(*position)[3] = malloc(nodes * sizeof *position);
    int32_t(*tet)[4] = malloc(6 * cubes * sizeof *tet);
    int32_t count = 0;
    ss_mesh *mesh = NULL;
    for (int32_t i = 0; position && tet && i < (int32_t)nodes; ++i) {
        const int32_t at[3] = {i % n, i / n % n, i / (n * n)};
        ss_set3(position[i], 0.01 * at[0], 0.01 * at[1], 0.01 * at[2]);
        for (int p = 0; p < 6 && at[0] + 1 < n && at[1] + 1 < n && at[2] + 1 < n; ++p) {
            const int32_t one = i + stride[path[p][0]], two = one + stride[path[p][1]];
            const bool is_even = (path[p][1] - path[p][0] + 3) % 3 == 1;
            tet[count][0] = i;
            tet[count][1] = is_even ? one : two;
            tet[count][2] = is_even ? two : one;
            tet[count++][3] = i + 1 + n + n * n;
        }
    }
    if (position && tet) {
        (void)ss_mesh_create((int32_t)nodes, (const double(*)[3])position, 0, NULL, count,
                             (const int32_t(*)[4])tet, &mesh, error);
    }
    free(position);
    free(tet);
    if (mesh && !ss_mesh_renumber(mesh)) {
        ss_mesh_destroy(&mesh);
    }
    return mesh;
}

/* Cube root of the volume of an element's share, about a link: of the liver alone. */
static double mean_link(const ss_mesh *mesh)
{
    ss_mesh_report report;
    return ss_mesh_check(mesh, &report) == SOFTSIM_OK ? report.edge_mean : 0.01;
}

int32_t ss_chain_speed_measure(const ss_mesh *liver, bool is_quick,
                               ss_chain_speed out[SS_CHAIN_SPEED_ROWS], softsim_error *error)
{
    static const int32_t side[] = {17, 27, 46, 79};
    int32_t count = 0;
    memset(out, 0, SS_CHAIN_SPEED_ROWS * sizeof *out);
    if (liver) {
        snprintf(out[count].body, sizeof out[count].body, "liver");
        if (!measure(liver, mean_link(liver), true, &out[count++], error)) {
            return -1;
        }
    }
    for (int k = 0; k < (is_quick ? 2 : 4); ++k) {
        ss_mesh *block = make_block(side[k], error);
        snprintf(out[count].body, sizeof out[count].body, "block %d^3", side[k]);
        const bool is_good = block && measure(block, 0.01, k == 0, &out[count++], error);
        ss_mesh_destroy(&block);
        if (!is_good) {
            return -1;
        }
    }
    return count;
}
