/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhang2018/run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "models/model.h"
#include "process.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { CHECK_EVERY = 256 }; /* steps between looks at whether the program is to stop */

/* ---- a model ---- */

/* Index of `word` in "a|b|c"; -1. */
static int32_t choice(const char *choices, const char *word)
{
    int32_t index = 0;
    for (const char *at = choices; at != NULL; at = strchr(at, '|'), ++index) {
        at += *at == '|';
        if (strncmp(at, word, strlen(word)) == 0 && strchr("|", at[strlen(word)]) != NULL) {
            return index;
        }
    }
    return -1;
}

/* "name=value" into the row's value; false when the model has no such row. */
static bool give(ss_zhang_run *run, const char *assignment)
{
    const char *equals = strchr(assignment, '=');
    const size_t length = (size_t)(equals - assignment);
    for (int32_t i = 0; i < run->class->row_count; ++i) {
        const ss_param_row *row = &run->class->row[i];
        if (strlen(row->name) == length && strncmp(row->name, assignment, length) == 0) {
            run->param[i].number = row->kind == SS_PARAM_CHOICE ? choice(row->choices, equals + 1)
                                                                : strtod(equals + 1, NULL);
            run->param[i].is_given = true;
            return run->param[i].number >= 0.0;
        }
    }
    snprintf(run->reason, sizeof run->reason, "%s has no parameter '%.*s'", run->class->name,
             (int)length, assignment);
    return false;
}

static bool make_set(ss_zhang_run *run)
{
    const ss_zhang_setup *setup = run->setup;
    run->set = calloc(1, sizeof *run->set);
    double(*way)[3] = calloc((size_t)setup->pushed_count, sizeof *way);
    if (run->set == NULL || way == NULL) {
        free(way);
        return false;
    }
    for (int32_t i = 0; i < setup->pushed_count; ++i) {
        ss_scale3(way[i], setup->direction, setup->depth);
    }
    *run->set = (ss_prescribed){.node = setup->pushed,
                                .node_count = setup->pushed_count,
                                .displacement = way,
                                .axis = {true, true, true},
                                .ramp = 1.0};
    return true;
}

/* Made for the step it is given, or, C being given, made again for the step it calls stable. */
static void create(ss_zhang_run *run, double step_s)
{
    softsim_error fault = {.status = SOFTSIM_OK};
    const ss_model_plan plan = {.mesh = run->setup->mesh,
                                .fixed = run->setup->fixed,
                                .param = run->param,
                                .prescribed = run->set,
                                .prescribed_count = 1,
                                .working_force = 2.0,
                                .max_force = 8.0,
                                .step = step_s,
                                .max_substeps = 1000,
                                .threads = 1};
    if (ss_model_create(run->class, &plan, &run->model, &fault) != SOFTSIM_OK) {
        snprintf(run->reason, sizeof run->reason, "%.*s", (int)strcspn(fault.text, "\n"),
                 fault.text);
        run->model = NULL;
    }
}

bool ss_zhang_has(const char *model)
{
    return ss_model_find(model) != NULL;
}

softsim_status ss_zhang_begin(const ss_zhang_setup *setup, ss_zhang_run *out_run,
                              softsim_error *error)
{
    *out_run = (ss_zhang_run){.setup = setup, .class = ss_model_find(setup->model)};
    ss_zhang_run *run = out_run;
    if (run->class == NULL) {
        snprintf(run->reason, sizeof run->reason, "the model %s is not built into this program",
                 setup->model);
        return SOFTSIM_OK;
    }
    run->param = calloc((size_t)run->class->row_count, sizeof *run->param);
    if (run->param == NULL || !make_set(run)) {
        ss_zhang_end(run);
        return ss_memory_fault(error);
    }
    for (int32_t i = 0; i < run->class->row_count; ++i) {
        run->param[i].number = run->class->row[i].fallback;
    }
    for (int32_t k = 0; k < SS_ZHANG_MAX_PARAM && setup->param[k] != NULL; ++k) {
        if (!give(run, setup->param[k])) {
            return SOFTSIM_OK;
        }
    }
    for (int32_t i = 0; i < run->class->row_count; ++i) {
        if (setup->stiffness_of != NULL &&
            strcmp(run->class->row[i].name, "link_stiffness_n_per_m") == 0) {
            run->param[i].per_node = setup->stiffness_of;
        }
    }
    run->step_s = setup->step_s > 0.0 ? setup->step_s : 1e-3;
    create(run, run->step_s);
    if (run->model != NULL && !(setup->step_s > 0.0)) {
        ss_model_info info;
        run->class->info(run->model, &info);
        run->class->destroy(run->model);
        run->step_s = info.stable_step;
        create(run, run->step_s);
    }
    return SOFTSIM_OK;
}

void ss_zhang_end(ss_zhang_run *run)
{
    if (run->model != NULL) {
        run->class->destroy(run->model);
    }
    free(run->param);
    if (run->set != NULL) {
        free(run->set->displacement);
    }
    free(run->set);
    *run = (ss_zhang_run){.model = NULL};
}

/* ---- steps ---- */

void ss_zhang_step(ss_zhang_run *run, double depth)
{
    const bool is_held = depth == run->depth;
    const double before = is_held ? ss_zhang_energy(run) : 0.0;
    const ss_model_tool none[SOFTSIM_MAX_PROBES] = {{.is_present = false}};
    const double share = depth / run->setup->depth;
    run->class->step(run->model, share - run->step_s, run->step_s, none);
    ss_model_info info;
    run->class->info(run->model, &info);
    run->substeps = info.substeps;
    run->depth = depth;
    if (is_held) {
        run->peak_energy_rise = fmax(run->peak_energy_rise, info.elastic - before);
    }
}

static bool is_stopped(softsim_error *error)
{
    if (ss_process_is_stopped()) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                          "stopped before the end; nothing is reported");
        return true;
    }
    return false;
}

softsim_status ss_zhang_go(ss_zhang_run *run, double depth, double speed, softsim_error *error)
{
    const double from = run->depth, way = fabs(depth - from);
    const int32_t steps = (int32_t)ceil(way / (speed * run->step_s) - 1e-9);
    for (int32_t k = 1; k <= steps; ++k) {
        const double gone = fmin(k * speed * run->step_s, way);
        ss_zhang_step(run, k == steps ? depth : from + (depth > from ? gone : -gone));
        if (k % CHECK_EVERY == 0 && is_stopped(error)) {
            return SOFTSIM_ERROR_SYSTEM;
        }
    }
    return SOFTSIM_OK;
}

softsim_status ss_zhang_hold(ss_zhang_run *run, double time_s, softsim_error *error)
{
    const int32_t steps = (int32_t)ceil(time_s / run->step_s - 1e-9);
    for (int32_t k = 1; k <= steps; ++k) {
        ss_zhang_step(run, run->depth);
        if (k % CHECK_EVERY == 0 && is_stopped(error)) {
            return SOFTSIM_ERROR_SYSTEM;
        }
    }
    return SOFTSIM_OK;
}

double ss_zhang_force(const ss_zhang_run *run)
{
    double force[3];
    run->class->reaction(run->model, 0, force);
    return ss_dot3(force, run->setup->direction);
}

double ss_zhang_energy(const ss_zhang_run *run)
{
    ss_model_info info;
    run->class->info(run->model, &info);
    return info.elastic;
}

void ss_zhang_read(const ss_zhang_run *run, double (*out_u)[3])
{
    const ss_real *u = run->class->displacement(run->model);
    for (int32_t i = 0; i < run->setup->mesh->node_count; ++i) {
        ss_set3(out_u[i], (double)u[4 * i], (double)u[4 * i + 1], (double)u[4 * i + 2]);
    }
}

/* ---- measures ---- */

double ss_zhang_distance(int32_t count, const double (*u)[3], const double (*v)[3], const double *w)
{
    double apart = 0.0, all = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        double d[3];
        ss_sub3(d, u[i], v[i]);
        apart += (w != NULL ? w[i] : 1.0) * ss_dot3(d, d);
        all += (w != NULL ? w[i] : 1.0) * ss_dot3(v[i], v[i]);
    }
    return sqrt(apart / all);
}

/* Six times the volume of tetrahedron t, displaced by u (NULL: at rest). */
static double six_volumes(const ss_mesh *mesh, int32_t t, const double (*u)[3])
{
    double edge[3][3], normal[3];
    const int32_t *c = mesh->tetrahedron[t];
    for (int k = 0; k < 3; ++k) {
        ss_sub3(edge[k], mesh->position[c[k + 1]], mesh->position[c[0]]);
        for (int a = 0; a < 3 && u != NULL; ++a) {
            edge[k][a] += u[c[k + 1]][a] - u[c[0]][a];
        }
    }
    ss_cross3(normal, edge[0], edge[1]);
    return ss_dot3(normal, edge[2]);
}

void ss_zhang_volumes(const ss_mesh *mesh, double *out_volume)
{
    memset(out_volume, 0, (size_t)mesh->node_count * sizeof *out_volume);
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        for (int k = 0; k < 4; ++k) {
            out_volume[mesh->tetrahedron[t][k]] += fabs(six_volumes(mesh, t, NULL)) / 24.0;
        }
    }
}

int32_t ss_zhang_inverted(const ss_mesh *mesh, const double (*u)[3])
{
    int32_t count = 0;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        count += six_volumes(mesh, t, u) * six_volumes(mesh, t, NULL) <= 0.0;
    }
    return count;
}

double ss_zhang_roughness(const ss_mesh *mesh, const uint8_t *fixed, const double (*u)[3])
{
    double(*sum)[4] = calloc((size_t)mesh->node_count, sizeof *sum);
    if (sum == NULL) {
        return (double)NAN;
    }
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < 4; ++b) {
                double *to = sum[mesh->tetrahedron[t][a]];
                ss_add3(to, to, u[mesh->tetrahedron[t][b]]);
                to[3] += 1.0;
            }
        }
    }
    double square = 0.0;
    int32_t count = 0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (fixed[i] == 0 && sum[i][3] > 0.0) {
            double d[3];
            ss_madd3(d, u[i], -1.0 / sum[i][3], sum[i]);
            square += ss_dot3(d, d);
            ++count;
        }
    }
    free(sum);
    return count > 0 ? sqrt(square / count) : 0.0;
}
