/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh convert: from any format that is read to any that is written, told by the name of
 * OUT. The mesh goes as it is, good or bad, unless --repair mends it: then what is done is told,
 * and what is left, and what a scene would still refuse is not written (exit status 2). The input
 * is replaced only when --overwrite says so, and then whole or not at all.
 */
#include "command.h"
#include "faulty.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "rt/progress.h"

#include <stdio.h>

typedef struct conversion {
    const char *path[2], *vtk;
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
                "mends what can be mended and tells of each change and of what is left: welds "
                "nodes, drops flat and double elements and loose nodes, closes seams and small "
                "holes, parts surfaces where more than two triangles meet, turns what is inside "
                "out; writes nothing that a scene would refuse (exit status 2)"),
        SS_TEXT("--vtk", &c->vtk, "FILE",
                "with --repair: the elements that are still faulty, to be looked at"),
        {"--order", SS_ARG_INTEGER, &c->order, 1, 2, "N",
         "of the tetrahedra: 2 adds mid-edge nodes, 1 leaves them out and closes up "
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
    const char *why = c->vtk != NULL ? ss_files_why_no_output(c->vtk) : NULL;
    if (why != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--vtk: '%s' is %s; give another name",
                          c->vtk, why);
    }
    if (c->vtk != NULL && (!c->is_mended || ss_files_are_one(c->vtk, c->path[0]) ||
                           ss_files_are_one(c->vtk, c->path[1]))) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--vtk: it goes with --repair, and is another file than IN and OUT");
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* From the unit of IN to that of OUT. */
static double scale_of(const conversion *c)
{
    return c->to_units >= 0 ? metres_per_unit(c->units) / metres_per_unit(c->to_units) : 1.0;
}

static void print_repairs(const char *path, const ss_mesh *mesh, const ss_mesh_repairs *done)
{
    const struct {
        int32_t count;
        const char *what;
    } read[] = {{mesh->joined_node_count, "vertices joined as the file was read"},
                {mesh->unused_node_count, "unused vertices left out"}};
    for (size_t i = 0; i < sizeof read / sizeof *read; ++i) {
        if (read[i].count > 0) {
            ss_plain_print(stdout, "%s: %s: %d\n", path, read[i].what, read[i].count);
        }
    }
    ss_mesh_finding rows[SS_MESH_MAX_FINDINGS];
    const int32_t count = ss_mesh_list_repairs(done, mesh->tetrahedron_count > 0, rows);
    for (int32_t i = 0; i < count; ++i) {
        char numbers[160];
        ss_mesh_print_fault(&rows[i], numbers, sizeof numbers);
        ss_plain_print(stdout, "%s: %s: %s\n", path, rows[i].what, numbers);
    }
}

/* Tells what is left as it is, because only people know what it should be. */
static softsim_status judge(const conversion *c, const ss_mesh *mesh, softsim_error *error)
{
    faulty f;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (faulty_find(&f, mesh)) {
        faulty_print(&f, c->path[0]);
        status = c->vtk != NULL ? faulty_write(&f, c->vtk, error) : SOFTSIM_OK;
    } else {
        softsim_error_add(error, status, "%s: out of memory", c->path[0]);
    }
    if (status == SOFTSIM_OK && !is_usable_size(&f.report, false)) {
        status = SOFTSIM_ERROR_MESH;
        softsim_error_add(error, status,
                          "%s: in no unit from mm to m has it a size that a scene takes (1e-7 to "
                          "1e5 m across): scale it",
                          c->path[0]);
    }
    if (status == SOFTSIM_OK && (f.row_count > 0 || f.report.is_inside_out)) {
        status = SOFTSIM_ERROR_MESH;
        softsim_error_add(error, status,
                          "%s: a scene refuses what is left, so nothing is written: mend that in "
                          "the program that made it%s",
                          c->path[0], c->vtk != NULL ? "" : "; --vtk FILE shows where it is");
    }
    faulty_fini(&f);
    return status;
}

/* Of the triangles: a repair that leaves less is told. */
static const double LEAST_KEPT = 0.5;

static softsim_status mend(const conversion *c, ss_mesh **inout_mesh, softsim_error *error)
{
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    softsim_error why = {0};
    const int32_t triangle_count = (*inout_mesh)->triangle_count;
    const softsim_status status = ss_mesh_repair(*inout_mesh, &mended, &done, &why);
    print_repairs(c->path[0], *inout_mesh, &done);
    if (status != SOFTSIM_OK) {
        softsim_error_add(error, status, "%s: it cannot be mended: %s", c->path[0], why.text);
        /* To look at, as it was read. */
        if (c->vtk != NULL && status == SOFTSIM_ERROR_MESH) {
            (void)judge(c, *inout_mesh, NULL);
        }
        return status;
    }
    ss_mesh_destroy(inout_mesh);
    *inout_mesh = mended;
    if (mended->triangle_count < LEAST_KEPT * triangle_count) {
        ss_plain_print(stderr,
                       "softsim-mesh: warning: %s: %d of %d triangles are left: see above what "
                       "became of the others\n",
                       c->path[0], mended->triangle_count, triangle_count);
    }
    const double scale = scale_of(c);
    for (int32_t i = 0; i < mended->node_count && is_rounded_by(c->path[1]); ++i) {
        for (int k = 0; k < 3; ++k) {
            mended->position[i][k] = (double)(float)(scale * mended->position[i][k]) / scale;
        }
    }
    return judge(c, mended, error);
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
        status = mend(c, &mesh, error);
    }
    status = status == SOFTSIM_OK ? change_order(c->order, &mesh, error) : status;
    if (status == SOFTSIM_OK && c->to_units >= 0) {
        static const double none[3] = {0.0, 0.0, 0.0};
        ss_mesh_transform(mesh, scale_of(c), none, none);
    }
    if (status == SOFTSIM_OK) {
        status = write_mesh(mesh, c->path[1], error);
        result = status == SOFTSIM_OK ? 0 : status == SOFTSIM_ERROR_MESH ? 2 : 1;
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
