/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/child.h"
#include "bench/papers/paper.h"
#include "mesh/mesh.h"
#include "process.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/plain.h"

enum { PATH_SIZE = 256 };
static const double mesh_timeout_s = 120.0;

static void file_name(const ss_paper *paper, const char *name, char out[PATH_SIZE])
{
    snprintf(out, PATH_SIZE, "%s/%s", paper->temporary, name);
}

/* ---- worlds ---- */

static softsim_status write_scene(const ss_paper *paper, const ss_trial_plan *plan,
                                  char path[PATH_SIZE], softsim_error *error)
{
    ss_output output;
    file_name(paper, "scene.yaml", path);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(output.file, "softsim: 1\nobject:\n%s", plan->body->object);
    if (plan->fixed != NULL) {
        fprintf(output.file, "  fixed: %s\n", plan->fixed);
    }
    fprintf(output.file, "model:\n%s%ssimulation: {sleep: off}\npublish: {mesh_rate_hz: 0}\n",
            plan->model, plan->rest != NULL ? plan->rest : "");
    return ss_output_commit(&output, error);
}

softsim_status ss_trial_begin(const ss_paper *paper, const ss_trial_plan *plan, ss_trial *out_trial,
                              softsim_error *error)
{
    char path[PATH_SIZE];
    softsim_error refusal = {.status = SOFTSIM_OK};
    softsim_config config = softsim_default_config();
    *out_trial = (ss_trial){.step_s = plan->step_s};
    const softsim_status status = write_scene(paper, plan, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    config.step_s = plan->step_s;
    out_trial->world = softsim_create(path, &config, &refusal);
    if (out_trial->world == NULL) {
        ss_plain_reason("", refusal.text, out_trial->reason, 256);
        return SOFTSIM_OK;
    }
    softsim_state state;
    softsim_read(out_trial->world, &state);
    out_trial->step_s = state.period_s;
    out_trial->node_count = state.node_count;
    const size_t n = (size_t)state.node_count;
    out_trial->position = calloc(n, sizeof *out_trial->position);
    out_trial->u = calloc(n, sizeof *out_trial->u);
    out_trial->v = calloc(n, sizeof *out_trial->v);
    if (out_trial->position == NULL || out_trial->u == NULL || out_trial->v == NULL) {
        ss_trial_end(out_trial);
        return ss_memory_fault(error);
    }
    softsim_read_nodes(out_trial->world, out_trial->position, out_trial->u, out_trial->v);
    return SOFTSIM_OK;
}

void ss_trial_end(ss_trial *trial)
{
    softsim_destroy(&trial->world);
    SS_EACH(free, trial->position, trial->u, trial->v);
    trial->position = trial->u = trial->v = NULL;
}

softsim_status ss_trial_run(ss_trial *trial, int32_t ticks, softsim_error *error)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    for (int32_t k = 0; k < ticks; ++k) {
        softsim_tick(trial->world, NULL, &channel, 0, force);
    }
    if (ss_process_is_stopped()) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                          "stopped before the end; nothing is reported");
        return SOFTSIM_ERROR_SYSTEM;
    }
    trial->time_s += ticks * trial->step_s;
    softsim_read_nodes(trial->world, trial->position, trial->u, trial->v);
    return SOFTSIM_OK;
}

/* ---- bodies ---- */

softsim_status ss_trial_look(const ss_paper *paper, const char *object, ss_trial_body *out_body,
                             char out_reason[256], softsim_error *error)
{
    ss_trial trial;
    *out_body = (ss_trial_body){.node_count = 0};
    snprintf(out_body->object, sizeof out_body->object, "%s", object);
    const ss_trial_plan plan = {
        .body = out_body,
        .model = "  name: cnn-energy\n  modulus_n_per_m: 1\n  per_area: false\n  mass_kg: 1\n"
                 "  damping_n_s_per_m: 1\n  rest_stiffness_n_per_m: 1\n"};
    softsim_status status = ss_trial_begin(paper, &plan, &trial, error);
    snprintf(out_reason, 256, "%s", trial.reason);
    if (status != SOFTSIM_OK || trial.world == NULL) {
        return status;
    }
    out_body->node_count = trial.node_count;
    out_body->triangle_count = softsim_triangle_count(trial.world);
    const size_t size = (size_t)out_body->triangle_count * sizeof *out_body->triangle;
    out_body->triangle = malloc(size);
    if (out_body->triangle == NULL) {
        ss_trial_end(&trial);
        return ss_memory_fault(error);
    }
    memcpy(out_body->triangle, softsim_triangles(trial.world), size);
    out_body->rest = trial.position;
    trial.position = NULL;
    ss_trial_end(&trial);
    return SOFTSIM_OK;
}

void ss_trial_body_fini(ss_trial_body *body)
{
    free(body->rest);
    free(body->triangle);
    *body = (ss_trial_body){.node_count = 0};
}

softsim_status ss_trial_write_field(const ss_paper *paper, const char *name, int32_t count,
                                    const double *value, softsim_error *error)
{
    char path[PATH_SIZE];
    ss_output output;
    file_name(paper, name, path);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("node,value\n", output.file);
    for (int32_t i = 0; i < count; ++i) {
        fprintf(output.file, "%d,%.17g\n", i, value[i]);
    }
    return ss_output_commit(&output, error);
}

softsim_status ss_trial_write_mesh(const ss_paper *paper, const char *name, int32_t node_count,
                                   const double (*position)[3], int32_t triangle_count,
                                   const int32_t (*triangle)[3], softsim_error *error)
{
    char path[PATH_SIZE];
    ss_mesh *mesh = NULL;
    file_name(paper, name, path);
    softsim_status status =
        ss_mesh_create(node_count, position, triangle_count, triangle, 0, NULL, &mesh, error);
    if (status == SOFTSIM_OK) {
        status = ss_mesh_write_msh(mesh, path, error);
    }
    ss_mesh_destroy(&mesh);
    return status;
}

static softsim_status generate(const ss_paper *paper, const char *name, const char *shape,
                               int32_t points, const char *size_mm, bool is_solid,
                               softsim_error *error)
{
    char program[sizeof paper->bin + 16], count[16], mesh[PATH_SIZE];
    snprintf(program, sizeof program, "%s/softsim-mesh", paper->bin);
    snprintf(count, sizeof count, "%d", points);
    file_name(paper, name, mesh);
    const char *argv[] = {program, "generate", shape, "--points", count, "--out",
                          mesh,    NULL,       NULL,  NULL,       NULL};
    int used = 7;
    if (is_solid) {
        argv[used++] = "--tetrahedra";
    }
    if (size_mm != NULL) {
        argv[used++] = "--size-mm";
        argv[used++] = size_mm;
    }
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv};
    const int result = ss_child_run(&plan, mesh_timeout_s);
    if (result != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "softsim-mesh generate %s --points %d: %s",
                          shape, points,
                          ss_process_is_stopped() ? "stopped"
                          : result == 127         ? "it is not beside softsim-bench"
                                                  : "it failed");
        return SOFTSIM_ERROR_SYSTEM;
    }
    return SOFTSIM_OK;
}

softsim_status ss_trial_generate(const ss_paper *paper, const char *name, const char *shape,
                                 int32_t points, const char *size_mm, softsim_error *error)
{
    return generate(paper, name, shape, points, size_mm, false, error);
}

softsim_status ss_trial_generate_solid(const ss_paper *paper, const char *name, const char *shape,
                                       int32_t points, const char *size_mm, softsim_error *error)
{
    return generate(paper, name, shape, points, size_mm, true, error);
}
