/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh convert: from any format that is read to any that is written, told by the name of
 * OUT. The mesh goes as it is, good or bad, unless --repair mends it. The input is replaced only
 * when --overwrite says so, and then whole or not at all.
 */
#include "command.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "rt/progress.h"

#include <stdio.h>

typedef struct conversion {
    const char *path[2];
    int32_t units, to_units; /* -1: not given */
    int64_t order;           /* 0: as IN */
    bool is_mended, overwrites;
} conversion;

static ss_args_result parse(int argc, char **argv, void *what, softsim_error *error)
{
    conversion *c = what;
    *c = (conversion){.units = -1, .to_units = -1};
    const ss_arg rows[] = {
        SS_FLAG("--repair", &c->is_mended,
                "welds nodes on top of others, drops flat and double elements and loose nodes, "
                "turns what "
                "is inside out; tells what it did and what it left"),
        {"--order", SS_ARG_INTEGER, &c->order, 1, 2, "N",
         "of the tetrahedra: 2 adds nodes in the middle of sides, 1 leaves them out and closes up "
         "the numbers (as IN)"},
        SS_CHOICE("--units", &c->units, UNITS, "of IN"),
        SS_CHOICE("--to-units", &c->to_units, UNITS, "of OUT (as IN)"),
        SS_FLAG("--overwrite", &c->overwrites, "OUT may be IN"),
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "IN OUT [options]",
                      "Writes a mesh in the format that the name of OUT asks for.", rows,
                      (int32_t)(sizeof rows / sizeof rows[0]), c->path, 2, 2, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    if (c->to_units >= 0 && c->units < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--to-units: the unit of '%s' is not known: give --units too",
                          c->path[0]);
    }
    if (!c->overwrites && ss_files_are_one(c->path[0], c->path[1])) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "'%s' is the input: give another name, or --overwrite", c->path[1]);
    }
    (void)can_write_mesh(c->path[1], "OUT", false, error);
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

static void print_count(const char *path, int32_t count, const char *what)
{
    if (count > 0) {
        ss_plain_print(stdout, "%s: %s: %d\n", path, what, count);
    }
}

/* What a repair leaves as it is, because only people know what it should be. */
static bool print_left(const char *path, const ss_mesh *mesh)
{
    ss_mesh_report report;
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS + 1];
    ss_mesh_fault hole;
    if (ss_mesh_check(mesh, &report) != SOFTSIM_OK || !ss_mesh_find_holes(mesh, &hole)) {
        return false;
    }
    int32_t count = ss_mesh_list_findings(mesh, &report, found);
    if (hole.count > 0) {
        found[count++] = (ss_mesh_finding){.fault = &hole,
                                           .what = "holes",
                                           .where = "at node",
                                           .remedy = "close them if the body has a volume"};
    }
    for (int32_t i = 0; i < count; ++i) {
        char numbers[160];
        if (!found[i].is_minor) {
            ss_mesh_print_fault(&found[i], numbers, sizeof numbers);
            ss_plain_print(stdout, "%s: left as they are: %s: %s: %s\n", path, found[i].what,
                           numbers, found[i].remedy);
        }
    }
    return true;
}

static softsim_status mend(const char *path, ss_mesh **inout_mesh, softsim_error *error)
{
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    const softsim_status status = ss_mesh_repair(*inout_mesh, &mended, &done, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    print_count(path, (*inout_mesh)->joined_node_count, "vertices joined as the file was read");
    print_count(path, (*inout_mesh)->unused_node_count, "unused vertices left out");
    print_count(path, done.bad_elements, "elements of bad nodes dropped");
    print_count(path, done.welded_nodes, "nodes welded to others");
    print_count(path, done.flat_elements, "flat elements dropped");
    print_count(path, done.twin_elements, "double elements dropped");
    print_count(path, done.loose_nodes, "loose nodes dropped");
    print_count(path, done.turned_tetrahedra, "tetrahedra turned");
    print_count(path, done.turned_triangles, "triangles turned");
    ss_mesh_destroy(inout_mesh);
    *inout_mesh = mended;
    if (!print_left(path, mended)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    return SOFTSIM_OK;
}

/* Returns the exit status. */
static int convert(const void *what, softsim_error *error)
{
    const conversion *c = what;
    ss_mesh *mesh = NULL;
    int result = 2;
    ss_progress_begin("softsim-mesh", "reading %s", c->path[0]);
    softsim_status status = ss_mesh_load(c->path[0], 1.0, NULL, &mesh, error);
    ss_progress_end();
    if (status == SOFTSIM_OK && c->is_mended) {
        status = mend(c->path[0], &mesh, error);
    }
    status = status == SOFTSIM_OK ? change_order(c->order, &mesh, error) : status;
    if (status == SOFTSIM_OK && c->to_units >= 0) {
        static const double none[3] = {0.0, 0.0, 0.0};
        ss_mesh_transform(mesh, metres_per_unit(c->units) / metres_per_unit(c->to_units), none,
                          none);
    }
    if (status == SOFTSIM_OK) {
        result = write_mesh(mesh, c->path[1], error) == SOFTSIM_OK ? 0 : 1;
    }
    if (result == 0) {
        print_written(mesh, c->path[1], NULL);
    }
    ss_mesh_destroy(&mesh);
    return result;
}

int command_convert(int argc, char **argv)
{
    conversion c;
    return run_command(argc, argv, &c, parse, convert);
}
