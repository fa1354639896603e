/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/scaling/block.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "bench/core/child.h"
#include "bench/stability/stress_case.h"
#include "bench/stability/stress_scene.h"
#include "case/samples.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "softsim/softsim.h"
#include "world/world.h"

enum { PATH_SIZE = 4352, MOST_TICKS = 200, LEAST_TICKS = 3 };
static const double stiffness_pa = 1e4, size_m = 0.1, load_share = 0.02;
static const double enough_s = 3.0; /* CPU of ticks: fewer of them when they are long */
static const double mesh_timeout_s = 900.0;

/* Complete or not at all, since runs may want it at once. */
softsim_status ss_block_mesh(const char *folder, bool is_surface, int32_t points, char out_name[64],
                             softsim_error *error)
{
    char bin[4096], program[4128], path[PATH_SIZE], draft[PATH_SIZE], count[16];
    snprintf(out_name, 64, "block-%s%d.msh", is_surface ? "surface-" : "", points);
    snprintf(path, sizeof path, "%s/%s", folder, out_name);
    if (access(path, R_OK) == 0) {
        return SOFTSIM_OK;
    }
    snprintf(draft, sizeof draft, "%s/%ld-%s", folder, (long)getpid(), out_name);
    snprintf(count, sizeof count, "%d", points);
    if (!ss_child_own_folder(bin, sizeof bin)) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "cannot find this program's own folder");
        return SOFTSIM_ERROR_SYSTEM;
    }
    snprintf(program, sizeof program, "%s/softsim-mesh", bin);
    const char *const argv[] = {program, "generate", "block", "--points",
                                count,   "--out",    draft,   is_surface ? NULL : "--tetrahedra",
                                NULL};
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv};
    if (ss_child_run(&plan, mesh_timeout_s) != 0 || rename(draft, path) != 0) {
        unlink(draft);
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                          "softsim-mesh generate block --points %d did not work", points);
        return SOFTSIM_ERROR_SYSTEM;
    }
    return SOFTSIM_OK;
}

int32_t ss_block_top(const char *path)
{
    char line[256] = "";
    FILE *file = fopen(path, "re");
    int32_t best = -1;
    double least = (double)INFINITY;
    while (file != NULL && strcmp(line, "$Nodes\n") != 0 &&
           fgets(line, sizeof line, file) != NULL) {
    }
    const bool has_nodes = file != NULL && fgets(line, sizeof line, file) != NULL;
    for (int32_t i = 0; has_nodes && fgets(line, sizeof line, file) != NULL; ++i) {
        double x[3];
        if (sscanf(line, "%*d %lf %lf %lf", &x[0], &x[1], &x[2]) != 3) {
            break;
        }
        const double far = hypot(hypot(x[0], x[1]), x[2] - 500.0 * size_m); /* mm */
        best = far < least ? i : best;
        least = fmin(least, far);
    }
    if (file != NULL) {
        fclose(file);
    }
    return best;
}

FILE *ss_block_scene(const char *path, const char *mesh, softsim_error *error)
{
    FILE *file = fopen(path, "we");
    if (file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be written", path);
        return NULL;
    }
    fprintf(file, "softsim: 1\nobject:\n  mesh: %s\n  units: mm\n", mesh);
    fprintf(file, "  fixed: [{plane: {point_m: [0, 0, %.9g], normal: [0, 0, 1]}}]\n",
            -0.499 * size_m);
    return file;
}

/* `spacing` of its nodes, m; `node` is pushed. */
static softsim_status write_scene(const char *path, const char *mesh, int32_t subject,
                                  double spacing, int32_t node, softsim_error *error)
{
    FILE *file = ss_block_scene(path, mesh, error);
    const ss_stress_case stress_case = {
        .subject = subject, .kind = SS_STRESS_CASE_CONTROL, .stiffness_pa = stiffness_pa};
    if (file == NULL) {
        return SOFTSIM_ERROR_FILE;
    }
    ss_stress_case_subject_write(&stress_case, file);
    fputs("simulation: {rate_hz: 1000, sleep: off}\npublish: {mesh_rate_hz: 0}\n", file);
    if (ss_stress_case_is_plastic(subject)) {
        fprintf(file,
                "prescribed:\n  - {nodes: [%d], displacement_m: [0, 0, %.9g], from_s: 0, ramp_s: "
                "%.9g}\n",
                node, -spacing, 1e-3 * MOST_TICKS);
    } else {
        fprintf(file, "loads:\n  - {nodes: [%d], force_n: [0, 0, %.9g], from_s: 0, ramp_s: 0.02}\n",
                node, -load_share * stiffness_pa * spacing * spacing);
    }
    if (fclose(file) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be written", path);
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

/* ---- the run ---- */

static void refuse(const softsim_error *refusal, ss_block_run *out)
{
    ss_plain_reason("refused: ", refusal->text, out->verdict, sizeof out->verdict);
}

static void play(softsim_world *world, ss_block_run *out, ss_samples *tick_us)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_state state;
    double spent_s = 0.0, largest_j = 0.0;
    for (int k = 0; k < MOST_TICKS && (k < LEAST_TICKS || spent_s < enough_s); ++k) {
        const int64_t begin_ns = ss_clock_thread_cpu_ns();
        softsim_tick(world, NULL, NULL, 0, force);
        const double tick_ns = (double)(ss_clock_thread_cpu_ns() - begin_ns);
        ss_samples_add(tick_us, 1e-3 * tick_ns);
        spent_s += 1e-9 * tick_ns;
        softsim_read(world, &state);
        largest_j = fmax(largest_j, state.kinetic_j + state.elastic_j);
    }
    out->p50_us = ss_samples_quantile(tick_us, 0.5);
    out->p99_us = ss_samples_quantile(tick_us, 0.99);
    out->substeps = (double)state.all_substeps / fmax(1.0, (double)state.step);
    out->active_nodes = state.active_nodes;
    out->balance =
        largest_j > 0.0
            ? (state.kinetic_j + state.elastic_j + state.dissipated_j - state.work_j) / largest_j
            : (double)NAN;
    snprintf(out->verdict, sizeof out->verdict, "%s%s%s", softsim_verdict_name(state.worst_verdict),
             state.worst_reason[0] != '\0' ? ": " : "", state.worst_reason);
}

static void take_solver(void *sink, const ss_note *note)
{
    ss_block_run *out = sink;
    if (note->kind == SS_NOTE_USED && strcmp(note->where, "solver") == 0) {
        snprintf(out->solver, sizeof out->solver, "%s", note->text);
    }
}

static softsim_status run(const char *scene, ss_block_run *out, softsim_error *error)
{
    const softsim_config config = softsim_default_config();
    softsim_error refusal = {.status = SOFTSIM_OK};
    struct rusage usage;
    ss_samples tick_us;
    if (!ss_samples_init(&tick_us, MOST_TICKS)) {
        return ss_memory_fault(error);
    }
    const int64_t begin_ns = ss_clock_thread_cpu_ns();
    softsim_world *world = softsim_create(scene, &config, &refusal);
    out->create_s = 1e-9 * (double)(ss_clock_thread_cpu_ns() - begin_ns);
    if (world == NULL) {
        refuse(&refusal, out);
    } else {
        softsim_state state;
        softsim_read(world, &state);
        out->nodes = state.node_count;
        out->memory_mb = 1e-6 * (double)ss_memory_in_use();
        ss_world_explain(ss_world_of(world), &(const ss_notes){take_solver, out});
        play(world, out, &tick_us);
        softsim_destroy(&world);
    }
    if (getrusage(RUSAGE_SELF, &usage) == 0) {
        out->peak_mb = 1.024e-3 * (double)usage.ru_maxrss; /* KiB */
    }
    ss_samples_fini(&tick_us);
    return SOFTSIM_OK;
}

softsim_status ss_block_measure(const char *folder, int32_t subject, int32_t points,
                                ss_block_run *out, softsim_error *error)
{
    const bool is_surface = ss_stress_case_is_surface(subject);
    char mesh[64], path[PATH_SIZE];
    *out = (ss_block_run){.create_s = (double)NAN,
                          .memory_mb = (double)NAN,
                          .peak_mb = (double)NAN,
                          .p50_us = (double)NAN,
                          .p99_us = (double)NAN,
                          .substeps = (double)NAN,
                          .balance = (double)NAN};
    softsim_status status = ss_block_mesh(folder, is_surface, points, mesh, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    snprintf(path, sizeof path, "%s/%s", folder, mesh);
    const int32_t node = ss_block_top(path);
    const double spacing = is_surface ? size_m * sqrt(6.0 / points) : size_m / cbrt((double)points);
    snprintf(path, sizeof path, "%s/scene-%ld.yaml", folder, (long)getpid());
    status = write_scene(path, mesh, subject, spacing, node, error);
    if (status == SOFTSIM_OK) {
        status = run(path, out, error);
    }
    unlink(path);
    return status;
}
