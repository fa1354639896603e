/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh info and check: what a file holds as a scene will read it, and whether it can be
 * simulated. `check` exits with 0 good, 1 usable with warnings, 2 unusable. Nothing here needs to
 * know a unit; the stable step of the models takes the file's lengths as millimetres then.
 */
#include "command.h"
#include "findings.h"
#include "rt/args.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/progress.h"

#include <stdio.h>
#include <sys/resource.h>

static const double no_move[3] = {0.0, 0.0, 0.0};

typedef struct inspection {
    const char *path;
    int32_t units; /* -1: not given */
    bool lists_nodes, is_json;
    ss_mesh *mesh;
    softsim_error error;
    double loading_s;
    int64_t bytes_at_most;
} inspection;

/* The most memory this process has held so far, bytes. */
static int64_t resident_at_most(void)
{
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? 1024 * (int64_t)usage.ru_maxrss : 0;
}

/* Reads arguments and the file. Returns -1 to go on, or the exit status. */
static int begin(int argc, char **argv, const char *about, bool can_list, inspection *in)
{
    *in = (inspection){.units = -1};
    const ss_arg rows[] = {
        SS_CHOICE("--units", &in->units, UNITS,
                  "of the file: lengths are given in metres then, else as they are"),
        SS_FLAG("--json", &in->is_json, "prints one JSON object, for programs"),
        SS_FLAG("--nodes", &in->lists_nodes, "lists every node: number, x, y, z"),
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "FILE [options]", about, rows, can_list ? 3 : 2, &in->path, 1, 1,
                      NULL, &in->error);
    int exit_code = 0;
    if (!ss_args_may_run("softsim-mesh", result, &in->error, &exit_code)) {
        return exit_code;
    }
    const double unit = in->units >= 0 ? metres_per_unit(in->units) : 1.0;
    const int64_t bytes_before = resident_at_most();
    const int64_t begun = ss_clock_now_ns();
    ss_progress_begin("softsim-mesh", "reading %s", in->path);
    const softsim_status status = ss_mesh_load(in->path, unit, NULL, &in->mesh, &in->error);
    ss_progress_end();
    if (status != SOFTSIM_OK) {
        ss_args_print_error("softsim-mesh", &in->error);
        if (in->is_json) {
            findings_print_json_error(in->path, &in->error);
        }
        return 2;
    }
    in->loading_s = 1e-9 * (double)(ss_clock_now_ns() - begun);
    in->bytes_at_most = resident_at_most() - bytes_before;
    return -1;
}

static int end(inspection *in, int status)
{
    ss_mesh_destroy(&in->mesh);
    return status;
}

static int fail_memory(inspection *in)
{
    ss_plain_print(stderr, "softsim-mesh: %s: out of memory\n", in->path);
    return end(in, 2);
}

int command_info(int argc, char **argv)
{
    inspection in;
    const int status = begin(
        argc, argv, "Prints what is in a mesh file, numbered as a scene numbers it.", true, &in);
    if (status >= 0) {
        return status;
    }
    if (in.lists_nodes) {
        (void)printf("node,x,y,z\n");
        for (int32_t i = 0; i < in.mesh->node_count; ++i) {
            const double *x = in.mesh->position[i];
            (void)printf("%d,%.9g,%.9g,%.9g\n", i, x[0], x[1], x[2]);
        }
        return end(&in, 0);
    }
    const int64_t bytes_kept = ss_memory_in_use();
    findings f;
    ss_progress_begin("softsim-mesh", "measuring %s", in.path);
    const bool is_measured = findings_measure(&f, in.path, in.mesh, in.units >= 0, false);
    ss_progress_end();
    if (!is_measured) {
        return fail_memory(&in);
    }
    f.loading_s = in.loading_s;
    f.bytes_kept = bytes_kept;
    f.bytes_at_most = in.bytes_at_most;
    if (in.is_json) {
        findings_print_json(&f);
    } else {
        findings_print(&f);
    }
    return end(&in, 0);
}

/* The models' figures, where a scene would take the mesh. Positions become metres. */
static void measure_costs(inspection *in, findings *f)
{
    if (in->units < 0) {
        ss_mesh_transform(in->mesh, 1e-3, no_move, no_move);
    }
    if (ss_mesh_accept(in->mesh, in->path, NULL) == SOFTSIM_OK) {
        f->cost_count = cost_measure(in->mesh, f->cost);
    }
}

int command_check(int argc, char **argv)
{
    inspection in;
    const int status = begin(argc, argv,
                             "Tells whether a mesh can be simulated: exit status 0 good, 1 usable "
                             "with warnings, 2 unusable.",
                             false, &in);
    if (status >= 0) {
        return status;
    }
    findings f;
    ss_progress_begin("softsim-mesh", "checking %s", in.path);
    const bool is_measured = findings_measure(&f, in.path, in.mesh, in.units >= 0, true);
    if (is_measured) {
        measure_costs(&in, &f);
    }
    ss_progress_end();
    if (!is_measured) {
        return fail_memory(&in);
    }
    if (in.is_json) {
        findings_print_json(&f);
    } else {
        findings_print(&f);
    }
    return end(&in, f.status);
}
