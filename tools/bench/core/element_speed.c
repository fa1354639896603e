/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/element_speed.h"
/*
 * A lattice with nodes at the corners and middles of cubes; each face between two cubes is the
 * middle of four tetrahedra (its two middles and an edge): all elements are congruent, as good as
 * they come, and the step is that of a regular mesh. Elements are kept where all their nodes lie
 * within the ellipsoid. The time of a sub-step grows with the number of elements N and the
 * stable step falls with N^(1/3), so that real time ends at N r^(3/4), r the real-time factor at N.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "case/samples.h"
#include "mesh/mesh.h"
#include "models/model.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/random.h"
#include "rt/vec.h"

static const double half_axis[3] = {0.05, 0.035, 0.025};

/* ---- the lattice ---- */

typedef struct lattice {
    int cells[3];    /* around the ellipsoid */
    double edge;     /* m, of a cube */
    int32_t *number; /* of a site in the mesh, -1 without; corners first, then middles */
    double (*position)[3];
    int32_t (*tetrahedron)[4];
    int32_t node_count, tetrahedron_count;
} lattice;

static size_t site_count(const lattice *l)
{
    const size_t nx = (size_t)l->cells[0], ny = (size_t)l->cells[1], nz = (size_t)l->cells[2];
    return (nx + 1) * (ny + 1) * (nz + 1) + nx * ny * nz;
}

static void free_lattice(lattice *l)
{
    SS_EACH(free, l->number, l->position, l->tetrahedron);
    *l = (lattice){0};
}

/* Corner (i, j, k), or with `is_middle` the middle of the cube that begins there. */
static int32_t site(const lattice *l, const int at[3], bool is_middle)
{
    const int nx = l->cells[0] + !is_middle, ny = l->cells[1] + !is_middle;
    const int first = is_middle ? (l->cells[0] + 1) * (l->cells[1] + 1) * (l->cells[2] + 1) : 0;
    return first + (at[2] * ny + at[1]) * nx + at[0];
}

static bool place(const lattice *l, const int at[3], bool is_middle, double out[3])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        out[k] = l->edge * (at[k] + (is_middle ? 0.5 : 0.0) - 0.5 * l->cells[k]);
        sum += out[k] / half_axis[k] * (out[k] / half_axis[k]);
    }
    return sum <= 1.0;
}

/* The node's number in the mesh, new or not; -1 outside. */
static int32_t node_at(lattice *l, const int at[3], bool is_middle)
{
    double x[3];
    int32_t *number = &l->number[site(l, at, is_middle)];
    if (*number < 0 && place(l, at, is_middle, x)) {
        *number = l->node_count++;
        ss_copy3(l->position[*number], x);
    }
    return *number;
}

/* The four elements around the face between cube `at` and the one before it along `axis`. */
static void add_face(lattice *l, const int at[3], int axis)
{
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    static const int round[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    for (int k = 0; k < 4; ++k) {
        int before[3] = {at[0], at[1], at[2]}, from[3], to[3];
        double x[3];
        --before[axis];
        memcpy(from, at, sizeof from);
        memcpy(to, at, sizeof to);
        from[a] += round[k][0];
        from[b] += round[k][1];
        to[a] += round[k + 1][0];
        to[b] += round[k + 1][1];
        if (!place(l, before, true, x) || !place(l, at, true, x) || !place(l, from, false, x) ||
            !place(l, to, false, x)) {
            continue;
        }
        int32_t *t = l->tetrahedron[l->tetrahedron_count++];
        t[0] = node_at(l, before, true);
        t[1] = node_at(l, from, false);
        t[2] = node_at(l, to, false);
        t[3] = node_at(l, at, true);
    }
}

/* With cubes of `edge`; what was there before is dropped. */
static bool fill_lattice(lattice *l, double edge)
{
    size_t cubes = 1;
    free_lattice(l);
    l->edge = edge;
    for (int k = 0; k < 3; ++k) {
        l->cells[k] = 2 * (int)ceil(half_axis[k] / edge);
        cubes *= (size_t)l->cells[k];
    }
    l->number = malloc(site_count(l) * sizeof *l->number);
    l->position = malloc(site_count(l) * sizeof *l->position);
    l->tetrahedron = malloc(cubes * 12 * sizeof *l->tetrahedron);
    if (!l->number || !l->position || !l->tetrahedron) {
        return false;
    }
    memset(l->number, 0xff, site_count(l) * sizeof *l->number);
    int at[3];
    for (at[2] = 0; at[2] < l->cells[2]; ++at[2]) {
        for (at[1] = 0; at[1] < l->cells[1]; ++at[1]) {
            for (at[0] = 0; at[0] < l->cells[0]; ++at[0]) {
                for (int axis = 0; axis < 3; ++axis) {
                    if (at[axis] > 0) {
                        add_face(l, at, axis);
                    }
                }
            }
        }
    }
    return true;
}

/* About `elements` of them: the rim that is cut off is only known afterwards. */
static bool fit_lattice(lattice *l, int32_t elements)
{
    const double volume = 4.18879020478639 * half_axis[0] * half_axis[1] * half_axis[2];
    double edge = cbrt(12.0 * volume / elements);
    for (int turn = 0; turn < 3; ++turn) {
        if (!fill_lattice(l, edge)) {
            return false;
        }
        edge *= cbrt(fmax(l->tetrahedron_count, 12.0) / elements);
    }
    return true;
}

/* Nodes and elements in any order; the order of corners stays. False when out of memory. */
static bool shuffle(lattice *l)
{
    uint64_t seed = 1;
    const size_t n = (size_t)l->node_count;
    int32_t *number = malloc(n * sizeof *number);
    double(*position)[3] = malloc(n * sizeof *position);
    const bool is_good = number && position;
    for (int32_t i = 0; is_good && i < l->node_count; ++i) {
        const int32_t j = (int32_t)ss_random_below(&seed, (uint32_t)i + 1);
        number[i] = number[j];
        number[j] = i;
    }
    for (size_t i = 0; is_good && i < n; ++i) {
        memcpy(position[number[i]], l->position[i], sizeof *position);
    }
    for (int32_t e = 0; is_good && e < l->tetrahedron_count; ++e) {
        const uint32_t f = ss_random_below(&seed, (uint32_t)e + 1);
        int32_t kept[4];
        for (int a = 0; a < 4; ++a) {
            kept[a] = number[l->tetrahedron[e][a]];
        }
        memcpy(l->tetrahedron[e], l->tetrahedron[f], sizeof kept);
        memcpy(l->tetrahedron[f], kept, sizeof kept);
    }
    free(number);
    free(is_good ? l->position : position);
    l->position = is_good ? position : l->position;
    return is_good;
}

/* Corners that make the volume positive. */
static void orient(lattice *l)
{
    for (int32_t e = 0; e < l->tetrahedron_count; ++e) {
        int32_t *t = l->tetrahedron[e];
        double d[3][3], n[3];
        for (int a = 0; a < 3; ++a) {
            ss_sub3(d[a], l->position[t[a + 1]], l->position[t[0]]);
        }
        ss_cross3(n, d[0], d[1]);
        if (ss_dot3(n, d[2]) < 0.0) {
            const int32_t kept = t[2];
            t[2] = t[3];
            t[3] = kept;
        }
    }
}

static softsim_status make_mesh(const ss_element_speed_case *what, ss_mesh **out_mesh,
                                softsim_error *error)
{
    lattice l = {0};
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    *out_mesh = NULL;
    if (fit_lattice(&l, what->elements)) {
        orient(&l);
        if (!what->is_shuffled || shuffle(&l)) {
            status = ss_mesh_create(l.node_count, (const double(*)[3])l.position, 0, NULL,
                                    l.tetrahedron_count, (const int32_t(*)[4])l.tetrahedron,
                                    out_mesh, error);
        }
    }
    if (status == SOFTSIM_OK && !ss_mesh_renumber(*out_mesh)) {
        status = SOFTSIM_ERROR_MEMORY;
    }
    free_lattice(&l);
    return status;
}

/* ---- measuring ---- */

/* The lowest fifth, along the shortest axis. */
static uint8_t *make_fixed(const ss_mesh *mesh)
{
    uint8_t *fixed = calloc((size_t)mesh->node_count, 1);
    for (int32_t i = 0; fixed && i < mesh->node_count; ++i) {
        fixed[i] = mesh->position[i][2] < -0.6 * half_axis[2] ? 7 : 0;
    }
    return fixed;
}

/* Where the model has such a parameter. */
static void set(const ss_model_class *model, ss_param_value *param, const char *name, double number)
{
    const ss_param_row *row = ss_model_find_row(model, name);
    if (row) {
        param[row - model->row] = (ss_param_value){.number = number, .is_given = true};
    }
}

/* The model's parameters, to be freed; NULL: out of memory. */
static ss_param_value *make_parameters(const ss_element_speed_case *what,
                                       const ss_model_class *model_class)
{
    ss_param_value *param = calloc((size_t)model_class->row_count, sizeof *param);
    for (int k = 0; param != NULL && k < model_class->row_count; ++k) {
        param[k] = (ss_param_value){.number = model_class->row[k].fallback};
    }
    if (param != NULL) {
        set(model_class, param, "material", (double)what->law);
        set(model_class, param, "youngs_modulus_pa", 3000.0);
        set(model_class, param, "poisson_ratio", 0.45);
        set(model_class, param, "locking_cure", what->is_cured ? 2.0 : 1.0);
        set(model_class, param, "stiffness_damping_s", what->is_viscous ? 20e-6 : 0.0);
    }
    return param;
}

/* Rounds of outer steps of a millisecond or so; each sub-step counts its share. */
static void run(const ss_model_class *model_class, ss_model *model, int32_t elements,
                ss_samples *samples, int32_t rounds, ss_element_speed *out)
{
    ss_model_info info;
    model_class->info(model, &info);
    out->stable_step_s = info.stable_step;
    const double step_s = 10.0 * info.stable_step; /* 20 sub-steps of half of it */
    double time = 0.0;
    for (int32_t k = -1; k < rounds; ++k) { /* the first one warms up */
        const int64_t start_ns = ss_clock_thread_cpu_ns();
        model_class->step(model, time, step_s, NULL);
        const int64_t spent_ns = ss_clock_thread_cpu_ns() - start_ns;
        model_class->info(model, &info);
        time += step_s;
        if (k >= 0 && info.substeps > 0) {
            ss_samples_add(samples, (double)spent_ns / info.substeps / elements);
        }
    }
    snprintf(out->verdict, sizeof out->verdict, "%s",
             info.verdict == SOFTSIM_VERDICT_GOOD ? "good" : info.reason);
}

static void derive(const ss_element_speed_case *what, const ss_model_class *model_class,
                   const ss_yardstick *yardstick, ss_element_speed *out)
{
    double bytes, flops;
    const double count = out->elements;
    model_class->hints->work(what->is_viscous, &bytes, &flops);
    out->flops = flops;
    out->bytes = bytes;
    out->realtime = 0.5 * out->stable_step_s / (out->ns * 1e-9 * count);
    out->realtime_half = count * pow(out->realtime, 0.75);
    out->realtime_most = count * pow(1.8 * out->realtime, 0.75);
    out->flop_share = yardstick->fma_gflops > 0.0 ? flops / out->ns / yardstick->fma_gflops : NAN;
    out->flop_512_share =
        yardstick->fma_512_gflops > 0.0 ? flops / out->ns / yardstick->fma_512_gflops : NAN;
    out->bandwidth_share =
        yardstick->bandwidth_gb_s > 0.0 ? bytes / out->ns / yardstick->bandwidth_gb_s : NAN;
}

softsim_status ss_element_speed_measure(const ss_element_speed_case *what,
                                        const ss_yardstick *yardstick, ss_element_speed *out,
                                        softsim_error *error)
{
    const ss_model_class *model_class = ss_model_find(what->model);
    *out = (ss_element_speed){0};
    if (what->elements < 100 || what->rounds < 1 || !model_class || !model_class->hints->work) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "speed of %s: at least 100 elements and one round, and a build with it",
                          what->model);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_mesh *mesh = NULL;
    ss_param_value *param = make_parameters(what, model_class);
    ss_samples samples = {0};
    ss_model *model = NULL;
    softsim_status status = make_mesh(what, &mesh, error);
    uint8_t *fixed = status == SOFTSIM_OK ? make_fixed(mesh) : NULL;
    if (status == SOFTSIM_OK && (!fixed || !param || !ss_samples_init(&samples, what->rounds))) {
        status = SOFTSIM_ERROR_MEMORY;
    }
    if (status == SOFTSIM_OK) {
        const ss_model_plan plan = {.mesh = mesh,
                                    .fixed = fixed,
                                    .param = param,
                                    .gravity = {0.0, 0.0, -1.0},
                                    .working_force = 2.0,
                                    .max_force = 8.0,
                                    .step = 1e-3,
                                    .max_substeps = 64,
                                    .threads = 1};
        const int64_t start_ns = ss_clock_thread_cpu_ns();
        status = ss_model_create(model_class, &plan, &model, error);
        out->create_s = 1e-9 * (double)(ss_clock_thread_cpu_ns() - start_ns);
    }
    if (status == SOFTSIM_OK) {
        out->nodes = mesh->node_count;
        out->elements = mesh->tetrahedron_count;
        run(model_class, model, out->elements, &samples, what->rounds, out);
        out->ns = ss_samples_quantile(&samples, 0.5);
        out->least_ns = ss_samples_quantile(&samples, 0.0);
        derive(what, model_class, yardstick, out);
        model_class->destroy(model);
    }
    free(fixed);
    free(param);
    ss_samples_fini(&samples);
    ss_mesh_destroy(&mesh);
    return status;
}
