/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh tetrahedralize: a closed surface in, its tetrahedra out, by tetgen. Surface nodes
 * keep their numbers and groups. tetgen leaves slivers that its own optimisation cannot reach:
 * inner nodes are then moved by solid_smooth.
 */
#include "command.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/progress.h"
#include "rt/vec.h"
#include "solid.h"
#include "tetgen.h"

#include <stdlib.h>
#include <string.h>

typedef struct request {
    const char *path[2];
    int32_t units;
    double edge, edge_mm, timeout_s;
    int64_t order;
} request;

static ss_args_result parse(int argc, char **argv, void *what, softsim_error *error)
{
    request *q = what;
    *q = (request){.units = -1, .timeout_s = 300.0};
    const ss_arg rows[] = {
        {"--edge", SS_ARG_NUMBER, &q->edge, 1e-12, 1e12, "X",
         "about the length of inner edges, in the file's own unit"},
        {"--edge-mm", SS_ARG_NUMBER, &q->edge_mm, 1e-9, 1e12, "X", "the same in millimetres"},
        SS_CHOICE("--units", &q->units, UNITS, "of IN and OUT, for --edge-mm (mm)"),
        {"--order", SS_ARG_INTEGER, &q->order, 1, 2, "N",
         "2: with a node in the straight middle of each edge (1)"},
        {"--timeout-s", SS_ARG_NUMBER, &q->timeout_s, 0.1, 1e6, "S",
         "tetgen is stopped after that (300)"},
    };
    int32_t count = 0;
    const ss_args_result result =
        ss_args_parse(argc, argv, "IN OUT.msh --edge X|--edge-mm X [options]",
                      "Fills a closed surface with tetrahedra; runs the program tetgen.", rows,
                      (int32_t)(sizeof rows / sizeof rows[0]), q->path, 2, 2, &count, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    if ((q->edge > 0.0) == (q->edge_mm > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "give one of --edge and --edge-mm: the length of inner edges");
    } else if (q->edge_mm > 0.0) {
        q->edge = 1e-3 * q->edge_mm / metres_per_unit(q->units >= 0 ? q->units : 0);
    }
    const ss_named_file in = {"the surface", q->path[0]}, out = {"OUT", q->path[1]};
    (void)(ss_files_check(&in, 1, &out, 1, error) &&
           can_write_mesh(q->path[1], "OUT", true, error));
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

static softsim_status refuse(const request *q, const char *why, softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s: %s", q->path[0], why);
    return SOFTSIM_ERROR_MESH;
}

/* What tetgen would stumble over is named before it does. */
static softsim_status check_surface(const request *q, const ss_mesh *mesh, softsim_error *error)
{
    ss_mesh_report report;
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
    ss_mesh_fault crossing;
    bool is_complete = true;
    if (ss_mesh_check(mesh, &report) != SOFTSIM_OK ||
        !ss_mesh_find_crossings(mesh, &crossing, &is_complete)) {
        return refuse(q, "out of memory", error);
    }
    if (mesh->tetrahedron_count > 0) {
        return refuse(q, "it has tetrahedra already: give a surface", error);
    }
    softsim_status status = SOFTSIM_OK;
    const int32_t count = ss_mesh_list_findings(mesh, &report, found);
    for (int32_t i = 0; i < count; ++i) {
        char numbers[160];
        ss_mesh_print_fault(&found[i], numbers, sizeof numbers);
        softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s: %s: %s: %s", q->path[0], found[i].what,
                          numbers, found[i].remedy);
        status = SOFTSIM_ERROR_MESH;
    }
    if (crossing.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "%s: triangles that cross others: %lld (the first is %d): move them "
                          "apart in the program that made it (a boolean union, or a remesh by "
                          "voxels, does that); softsim-mesh scene takes the surface as it is",
                          q->path[0], (long long)crossing.count, crossing.first[0]);
        status = SOFTSIM_ERROR_MESH;
    }
    if (report.is_inside_out) {
        status = refuse(
            q, "the surface is wound inside out: softsim-mesh convert --repair turns it", error);
    }
    return status;
}

/* Smooths, turns what is turned, and takes over the surface's groups. */
static softsim_status finish(const ss_mesh *surface, double edge, ss_mesh **inout_mesh,
                             softsim_error *error)
{
    ss_mesh *mesh = *inout_mesh;
    solid s = {0};
    bool is_good = true;
    for (int32_t i = 0; i < mesh->node_count && is_good; ++i) {
        int32_t node;
        is_good = solid_add_node(&s, mesh->position[i], &node);
    }
    for (int32_t e = 0; e < mesh->tetrahedron_count && is_good; ++e) {
        const int32_t *n = mesh->tetrahedron[e];
        is_good = solid_add_tetrahedron(&s, n[0], n[1], n[2], n[3]);
    }
    is_good = is_good && solid_smooth(&s, edge, 24, NULL, NULL);
    ss_mesh_destroy(inout_mesh);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (is_good) {
        status = ss_mesh_create(s.node_count, (const double(*)[3])s.position, 0, NULL,
                                s.tetrahedron_count, (const int32_t(*)[4])s.tetrahedron, inout_mesh,
                                error);
    }
    solid_fini(&s);
    if (status == SOFTSIM_OK && !carry_groups(surface, NULL, *inout_mesh)) {
        ss_mesh_destroy(inout_mesh);
        status = SOFTSIM_ERROR_MEMORY;
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory for the tetrahedra");
    }
    return status;
}

/* A regular tetrahedron of edge X has the volume X^3 / (6 sqrt 2). tetgen splits what is larger
 * than its bound, so that the mean lies near half of it: twice the volume gives edges of about X.
 */
static double volume_bound(double edge)
{
    return 2.0 * edge * edge * edge / (6.0 * 1.41421356237);
}

/* Returns the exit status. */
static int tetrahedralize(const void *what, softsim_error *error)
{
    const request *q = what;
    ss_mesh *surface = NULL;
    ss_mesh *volume = NULL;
    ss_progress_begin("softsim-mesh", "reading %s", q->path[0]);
    softsim_status status = ss_mesh_load(q->path[0], 1.0, NULL, &surface, error);
    status = status == SOFTSIM_OK ? check_surface(q, surface, error) : status;
    int result = status == SOFTSIM_OK ? 1 : 2;
    ss_progress_stage("tetgen fills %s", q->path[0]);
    status = status == SOFTSIM_OK
                 ? tetgen_fill(surface, volume_bound(q->edge), q->timeout_s, &volume, error)
                 : status;
    status = status == SOFTSIM_OK ? finish(surface, q->edge, &volume, error) : status;
    status = status == SOFTSIM_OK ? change_order(q->order, &volume, error) : status;
    status = status == SOFTSIM_OK ? write_mesh(volume, q->path[1], error) : status;
    ss_progress_end();
    if (status == SOFTSIM_OK) {
        print_written(volume, q->path[1], NULL);
        result = 0;
    }
    ss_mesh_destroy(&surface);
    ss_mesh_destroy(&volume);
    return result;
}

int command_tetrahedralize(int argc, char **argv)
{
    request q;
    return run_command(argc, argv, &q, parse, tetrahedralize);
}
