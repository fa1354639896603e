/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The bodies of the hybrid model's paper and what is done to them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/child.h"
#include "bench/papers/hybrid/hybrid.h"
#include "case/samples.h"
#include "process.h"
#include "rt/clock.h"
#include "rt/vec.h"

static const double mesh_timeout_s = 60.0;

const ss_heart_row ss_heart_table[SS_HEART_ROWS] = {
    {"ED0", 5.5, 2.5, 9.0e-5, 7.0e-3},
    {"HM1", 5.0, 2.0, 9.0e-5, 7.0e-3},
    {"HM2", 0.04, 1.6e-3, 1.0e-4, 7.5e-3},
};

/* ---- meshes ---- */

enum { MAX_ARGUMENTS = 24 };

ss_mesh *ss_heart_generate(const ss_paper *paper, const char *const *argument, softsim_error *error)
{
    char program[sizeof paper->bin + 16];
    char path[sizeof paper->temporary + 16];
    const char *argv[MAX_ARGUMENTS + 8] = {program, "generate"};
    int count = 2;
    snprintf(program, sizeof program, "%s/softsim-mesh", paper->bin);
    snprintf(path, sizeof path, "%s/body.msh", paper->temporary);
    for (; argument[count - 2] != NULL && count < MAX_ARGUMENTS; ++count) {
        argv[count] = argument[count - 2];
    }
    argv[count++] = "--units";
    argv[count++] = "m";
    argv[count++] = "--out";
    argv[count++] = path;
    argv[count] = NULL;
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv};
    const int result = ss_child_run(&plan, mesh_timeout_s);
    ss_mesh *mesh = NULL;
    if (result != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "softsim-mesh generate %s: %s", argument[0],
                          ss_process_is_stopped() ? "stopped"
                          : result == 127         ? "it is not beside softsim-bench"
                                                  : "it failed");
        return NULL;
    }
    return ss_mesh_load(path, 1.0, NULL, &mesh, error) == SOFTSIM_OK ? mesh : NULL;
}

ss_mesh *ss_heart_ellipsoids(const ss_paper *paper, int32_t nodes, softsim_error *error)
{
    char count[16];
    snprintf(count, sizeof count, "%d", nodes);
    const char *const argv[] = {"ellipsoids",     "--tetrahedra", "--size-mm",
                                "2000,1600,1600", "--inner-mm",   "1200,900,900",
                                "--points",       count,          NULL};
    return ss_heart_generate(paper, argv, error);
}

ss_mesh *ss_heart_ventricle(const ss_paper *paper, softsim_error *error)
{
    const char *const argv[] = {"ventricle",  "--tetrahedra", "--size-mm", "1300,1300,2400",
                                "--inner-mm", "840,840,2000", "--base-mm", "500",
                                "--points",   "1391",         NULL};
    return ss_heart_generate(paper, argv, error);
}

/* Rings of triangles on the half ellipsoid of semi-axes a, a, c about z, from its tip at -c up to
 * z = top. */
static ss_mesh *make_wall(double a, double c, double top, double edge, softsim_error *error)
{
    enum { MOST = 40000 };
    double(*x)[3] = malloc(MOST * sizeof *x);
    int32_t(*triangle)[3] = malloc(2 * MOST * sizeof *triangle);
    const double last = acos(-top / c);
    const int rings = (int)ceil(last * 0.5 * (a + c) / edge);
    ss_mesh *mesh = NULL;
    int32_t nodes = 1;
    int32_t count = 0;
    int32_t before_first = 0;
    int32_t before = 1;
    if (x == NULL || triangle == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a wall");
        free(x);
        free(triangle);
        return NULL;
    }
    ss_set3(x[0], 0.0, 0.0, -c);
    for (int i = 1; i <= rings; ++i) {
        const double t = last * i / rings;
        const double radius = a * sin(t);
        const int32_t around = (int32_t)fmax(5.0, round(2.0 * SS_PI * radius / edge));
        const int32_t first = nodes;
        for (int32_t k = 0; k < around; ++k) {
            const double angle = 2.0 * SS_PI * (k + 0.5 * (i % 2)) / around;
            ss_set3(x[nodes++], radius * cos(angle), radius * sin(angle), -c * cos(t));
        }
        for (int32_t j = 0, k = 0; j < (before > 1 ? before : 0) || k < around;) {
            const int32_t b = before_first + j % before;
            const int32_t n = first + k % around;
            const bool is_below =
                before > 1 && (k >= around || (j < before && (j + 1) * around <= (k + 1) * before));
            const int32_t corner[3] = {
                b, is_below ? before_first + (j + 1) % before : first + (k + 1) % around, n};
            memcpy(triangle[count++], corner, sizeof corner);
            j += is_below;
            k += !is_below;
        }
        before_first = first;
        before = around;
    }
    (void)ss_mesh_create(nodes, (const double(*)[3])x, count, (const int32_t(*)[3])triangle, 0,
                         NULL, &mesh, error);
    free(x);
    free(triangle);
    return mesh;
}

/* Both are taken. */
static ss_mesh *add_skin(ss_mesh *core, ss_mesh *outer, softsim_error *error)
{
    ss_mesh *mesh = NULL;
    if (core != NULL && outer != NULL) {
        (void)ss_mesh_add_skin(core, outer, &mesh, error);
    }
    ss_mesh_destroy(&core);
    ss_mesh_destroy(&outer);
    return mesh;
}

ss_mesh *ss_heart_layered(const ss_paper *paper, softsim_error *error)
{
    const char *const argv[] = {"ventricle",  "--tetrahedra", "--size-mm", "1100,1100,2200",
                                "--inner-mm", "840,840,2000", "--base-mm", "500",
                                "--points",   "675",          NULL};
    return add_skin(ss_heart_generate(paper, argv, error), make_wall(0.65, 1.2, 0.5, 0.06, error),
                    error);
}

ss_mesh *ss_heart_layered_ellipsoids(const ss_paper *paper, softsim_error *error)
{
    const char *const core[] = {"ellipsoids",     "--tetrahedra", "--size-mm",
                                "1600,1250,1250", "--inner-mm",   "1200,900,900",
                                "--points",       "500",          NULL};
    const char *const outer[] = {"ellipsoid", "--points",       "1500",
                                 "--size-mm", "2000,1600,1600", NULL};
    ss_mesh *inside = ss_heart_generate(paper, core, error);
    return add_skin(inside, ss_heart_generate(paper, outer, error), error);
}

/* ---- models ---- */

void ss_heart_set(ss_heart_body *body, const char *name, double value)
{
    for (int32_t k = 0; k < body->model_class->row_count; ++k) {
        if (strcmp(body->model_class->row[k].name, name) == 0) {
            body->param[k].number = value;
            body->param[k].is_given = true;
        }
    }
}

void ss_heart_set_layer(ss_heart_body *body, double spacing, double activate, double max_active)
{
    ss_heart_set(body, "layer.spacing_m", spacing);
    ss_heart_set(body, "layer.activate_m", activate);
    ss_heart_set(body, "layer.max_active", max_active);
}

void ss_heart_init(ss_heart_body *body, ss_mesh *mesh, const char *model, const ss_heart_row *row,
                   const char *group)
{
    *body = (ss_heart_body){.mesh = mesh,
                            .model_name = model,
                            .model_class = ss_model_find(model),
                            .fixed = calloc((size_t)mesh->node_count, 1),
                            .step = row->step,
                            .reason = "good"};
    if (body->model_class == NULL || body->fixed == NULL || !ss_mesh_renumber(mesh)) {
        return;
    }
    for (int32_t k = 0; k < body->model_class->row_count; ++k) {
        body->param[k].number = body->model_class->row[k].fallback;
    }
    ss_heart_set(body, "lame_lambda_pa", row->lambda);
    ss_heart_set(body, "lame_mu_pa", row->mu);
    ss_heart_set(body, "viscosity_phi_pa_s", row->viscosity);
    ss_heart_set(body, "viscosity_psi_pa_s", row->viscosity);
    ss_heart_set(body, "density_kg_m3", 1.0);
    ss_heart_set(body, "mass_damping_per_s", 2.0);
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        for (int32_t k = 0;
             strcmp(mesh->group[g].name, group) == 0 && k < mesh->group[g].node_count; ++k) {
            body->fixed[mesh->group[g].node[k]] = 7;
        }
    }
    body->plan = (ss_model_plan){.mesh = mesh,
                                 .fixed = body->fixed,
                                 .param = body->param,
                                 .working_force = 0.03 * (row->lambda + 2.0 * row->mu),
                                 .max_force = 8.0,
                                 .step = row->step,
                                 .max_substeps = 200,
                                 .threads = 1};
    body->plan.tool[0].is_used = true;
    body->plan.tool[0].shape = (ss_shape){.kind = SS_SHAPE_SPHERE, .radius = 0.2};
}

softsim_status ss_heart_start(ss_heart_body *body, softsim_error *error)
{
    if (body->model_class == NULL || body->fixed == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "the model %s is not built in",
                          body->model_name);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return ss_model_create(body->model_class, &body->plan, &body->model, error);
}

void ss_heart_end(ss_heart_body *body)
{
    if (body->model != NULL) {
        body->model_class->destroy(body->model);
    }
    ss_mesh_destroy(&body->mesh);
    free(body->fixed);
    *body = (ss_heart_body){0};
}

static double step(ss_heart_body *body)
{
    ss_model_info info;
    const int64_t start_ns = ss_clock_thread_cpu_ns();
    body->model_class->step(body->model, body->time, body->step, body->tool);
    const double us = 1e-3 * (double)(ss_clock_thread_cpu_ns() - start_ns);
    body->time += body->step;
    body->model_class->info(body->model, &info);
    if (info.verdict > body->worst) {
        body->worst = info.verdict;
        snprintf(body->reason, sizeof body->reason, "%s", info.reason);
    }
    return us;
}

double ss_heart_move(ss_heart_body *body, const double to[3], int32_t steps)
{
    ss_samples times = {0};
    double from[3];
    (void)ss_samples_init(&times, steps); /* without memory the median is NaN */
    ss_model_tool *tool = &body->tool[0];
    if (!tool->is_present) {
        tool->is_present = true;
        tool->to = (ss_tool_pose){.orientation = {1, 0, 0, 0}};
        ss_copy3(tool->to.position, to);
    }
    ss_copy3(from, tool->to.position);
    for (int32_t k = 1; k <= steps; ++k) {
        tool->from = tool->to;
        for (int a = 0; a < 3; ++a) {
            tool->to.position[a] = from[a] + (to[a] - from[a]) * k / steps;
        }
        ss_samples_add(&times, step(body));
    }
    const double median = ss_samples_quantile(&times, 0.5);
    ss_samples_fini(&times);
    return median;
}

void ss_heart_idle(ss_heart_body *body, int32_t steps)
{
    body->tool[0].is_present = false;
    for (int32_t k = 0; k < steps; ++k) {
        (void)step(body);
    }
}

void ss_heart_force(ss_heart_body *body, double out_force[3])
{
    ss_contact_set set;
    body->model_class->contacts(body->model, 0, 0.01, &set);
    ss_copy3(out_force, set.force);
}

int32_t ss_heart_awake(const ss_heart_body *body)
{
    ss_model_info info;
    body->model_class->info(body->model, &info);
    return info.active_nodes;
}
