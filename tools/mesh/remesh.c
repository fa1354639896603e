/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh remesh: evens a surface out, so that its triangles have about one size and no
 * slivers; what they were and are, and how far the surface moved, is told.
 */
#include "command.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "rt/progress.h"

#include <math.h>
#include <stdio.h>

typedef struct request {
    const char *path[2];
    int32_t units;
    double edge_mm, edge, feature_deg;
} request;

static ss_args_result parse(int argc, char **argv, void *what, softsim_error *error)
{
    request *q = what;
    *q = (request){.units = -1, .edge_mm = NAN, .edge = NAN, .feature_deg = 40.0};
    const ss_arg rows[] = {
        {"--edge-mm", SS_ARG_NUMBER, &q->edge_mm, 1e-9, 1e9, "N",
         "the length of edges, mm (give --units too, else the file is taken as in mm)"},
        {"--edge", SS_ARG_NUMBER, &q->edge, 1e-12, 1e12, "N", "the same in the file's unit"},
        {"--feature-deg", SS_ARG_NUMBER, &q->feature_deg, 5.0, 180.0, "N",
         "edges whose triangles' normals differ by more than this stay (40)"},
        SS_CHOICE("--units", &q->units, UNITS, "of IN, and of OUT"),
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "IN OUT --edge-mm N [options]",
                      "Evens a surface out: triangles of about one size on the same surface.", rows,
                      (int32_t)(sizeof rows / sizeof rows[0]), q->path, 2, 2, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    if (isnan(q->edge) == isnan(q->edge_mm)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "give one of --edge-mm and --edge: the length of edges");
    } else if (!isnan(q->edge_mm)) {
        q->edge = 1e-3 * q->edge_mm / metres_per_unit(q->units >= 0 ? q->units : 0);
    }
    const ss_named_file in = {"the surface", q->path[0]}, out = {"OUT", q->path[1]};
    (void)(ss_files_check(&in, 1, &out, 1, error) &&
           can_write_mesh(q->path[1], "OUT", false, error));
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* Less of its volume is no longer the same body; and is worth a word. */
static const double LOST = 0.2, CHANGED = 0.08;
/* Of the area's power of 1.5: of parts wound against each other there is less, and says nothing. */
static const double FLAT = 1e-3;

/* How much of its volume a closed surface has lost or won. */
static double volume_change(const ss_mesh *mesh, const ss_mesh *even)
{
    ss_mesh_report before, after;
    if (!mesh->is_closed || !even->is_closed || ss_mesh_check(mesh, &before) != SOFTSIM_OK ||
        ss_mesh_check(even, &after) != SOFTSIM_OK ||
        !(fabs(before.volume) > FLAT * pow(before.area, 1.5))) {
        return 0.0;
    }
    return fabs(after.volume - before.volume) / fabs(before.volume);
}

static bool print_measures(const char *path, const ss_mesh *mesh)
{
    ss_mesh_report r;
    ss_mesh_quality quality;
    if (ss_mesh_check(mesh, &r) != SOFTSIM_OK) {
        return false;
    }
    ss_mesh_measure_quality(mesh, &quality);
    ss_plain_print(stdout,
                   "%s: %d triangles, edges %.4g least, %.4g mean, %.4g greatest, least angle %.3g "
                   "degrees, %lld slivers, volume %.6g\n",
                   path, mesh->triangle_count, r.edge_min, r.edge_mean, r.edge_max, r.angle_min,
                   (long long)quality.sliver.count, mesh->is_closed ? r.volume : 0.0);
    return true;
}

/* Returns the exit status. */
static int remesh(const void *what, softsim_error *error)
{
    const request *q = what;
    ss_mesh *mesh = NULL, *even = NULL;
    ss_mesh_remeshing done = {0};
    ss_progress_begin("softsim-mesh", "reading %s", q->path[0]);
    softsim_status status = ss_mesh_load(q->path[0], 1.0, NULL, &mesh, error);
    int result = 2;
    if (status == SOFTSIM_OK) {
        softsim_error why = {0};
        ss_progress_stage("remeshing %d triangles", mesh->triangle_count);
        status = ss_mesh_remesh(mesh, q->edge, q->feature_deg, &even, &done, &why);
        if (status != SOFTSIM_OK) {
            softsim_error_add(error, status, "%s: %s", q->path[0], why.text);
        }
    }
    ss_progress_end();
    const double change = status == SOFTSIM_OK ? volume_change(mesh, even) : 0.0;
    if (change > LOST) {
        status = SOFTSIM_ERROR_MESH;
        softsim_error_add(
            error, status,
            "%s: with edges of %.3g%s it would change its volume by %.0f %%: they are "
            "too long for what is thin of it: give a shorter %s, or other --units",
            q->path[0], isnan(q->edge_mm) ? q->edge : q->edge_mm, isnan(q->edge_mm) ? "" : " mm",
            100.0 * change, isnan(q->edge_mm) ? "--edge" : "--edge-mm");
    }
    if (status == SOFTSIM_OK) {
        status = write_mesh(even, q->path[1], error);
        result = status == SOFTSIM_OK ? 0 : status == SOFTSIM_ERROR_MESH ? 2 : 1;
    }
    if (result == 0 && print_measures(q->path[0], mesh) && print_measures(q->path[1], even)) {
        ss_plain_print(stdout, "%s: at most %.4g from the surface given, or it from this\n",
                       q->path[1], done.distance);
    }
    if (result == 0 && done.undone_rounds > 0) {
        ss_plain_print(stdout,
                       "%s: %d rounds undone and %d nodes left as they were, for the surface would "
                       "have come to cross itself: give a shorter edge\n",
                       q->path[1], done.undone_rounds, done.locked_nodes);
    }
    if (result == 0 && change > CHANGED) {
        ss_plain_print(
            stderr,
            "softsim-mesh: warning: %s: its volume has changed by %.0f %%: edges are long "
            "for what is thin of it; give a shorter %s\n",
            q->path[1], 100.0 * change, isnan(q->edge_mm) ? "--edge" : "--edge-mm");
    }
    if (result == 0 && !done.is_crossing_complete) {
        ss_plain_print(
            stdout,
            "warning: %s: too many triangles lie about each other to look at every pair: "
            "there may be some that cross\n",
            q->path[1]);
    }
    ss_mesh_destroy(&mesh);
    ss_mesh_destroy(&even);
    return result;
}

int command_remesh(int argc, char **argv)
{
    request q;
    return run_command(argc, argv, &q, parse, remesh);
}
