/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh info and check: what a file holds as a scene will read it, and whether it can be
 * simulated. `check` exits with 0 good, 1 usable with warnings, 2 unusable.
 */
#include "command.h"
#include "mesh/mesh.h"
#include "rt/args.h"

#include <stdio.h>

typedef struct inspection {
    const char *path;
    int32_t units;
    bool lists_nodes;
    ss_mesh *mesh;
    ss_mesh_report report;
    softsim_error error;
} inspection;

/* Reads arguments and the file. Returns -1 to go on, or the exit status. */
static int begin(int argc, char **argv, const char *about, bool can_list, inspection *in)
{
    *in = (inspection){.units = -1};
    const ss_arg rows[] = {
        {"--units", SS_ARG_CHOICE, &in->units, 0, 0, UNITS, "of the file (mm)"},
        {"--nodes", SS_ARG_FLAG, &in->lists_nodes, 0, 0, "",
         "lists every node: number, x, y, z in metres"},
    };
    int32_t count = 0;
    const ss_args_result result =
        ss_args_parse(argc, argv, "FILE [options]", about, rows, can_list ? 2 : 1, &in->path, 1, 1,
                      &count, &in->error);
    if (result == SS_ARGS_DONE) {
        return 0;
    }
    in->units = in->units >= 0 ? in->units : 0;
    if (result == SS_ARGS_BAD || ss_mesh_load(in->path, metres_per_unit(in->units), NULL, &in->mesh,
                                              &in->error) != SOFTSIM_OK) {
        ss_args_print_error("softsim-mesh", &in->error);
        return 2;
    }
    if (ss_mesh_check(in->mesh, &in->report) != SOFTSIM_OK) {
        (void)fprintf(stderr, "softsim-mesh: %s: out of memory\n", in->path);
        ss_mesh_destroy(&in->mesh);
        return 2;
    }
    return -1;
}

static void print_summary(const inspection *in)
{
    const ss_mesh *m = in->mesh;
    const ss_mesh_report *r = &in->report;
    (void)printf("nodes       %d\ntriangles   %d\ntetrahedra  %d\nparts       %d\n", m->node_count,
                 m->triangle_count, m->tetrahedron_count, r->component_count);
    if (m->quad_count > 0) {
        (void)printf("quads       %d (the triangles are their halves)\n", m->quad_count);
        (void)printf("directions  %lld sides where u of one quad meets w of the other\n",
                     (long long)r->mixed_direction.count);
    }
    if (m->cut_face_count > 0) {
        (void)printf("cut_faces   %d of more than three corners, since not all are quads\n",
                     m->cut_face_count);
    }
    (void)printf("surface     %s\n", m->is_closed ? "closed" : "open");
    (void)printf("box_mm      %g %g %g to %g %g %g\n", 1e3 * r->box_min[0], 1e3 * r->box_min[1],
                 1e3 * r->box_min[2], 1e3 * r->box_max[0], 1e3 * r->box_max[1],
                 1e3 * r->box_max[2]);
    (void)printf("area_mm2    %g\n", 1e6 * r->area);
    if (m->is_closed) {
        (void)printf("volume_mm3  %g\n", 1e9 * r->volume);
    }
    (void)printf("edge_mm     %g least, %g mean, %g greatest\n", 1e3 * r->edge_min,
                 1e3 * r->edge_mean, 1e3 * r->edge_max);
    (void)printf("angle_deg   %.3g least\n", r->angle_min);
    for (int32_t g = 0; g < m->group_count; ++g) {
        (void)printf("group       %s: %d nodes\n", m->group[g].name, m->group[g].node_count);
    }
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
    } else {
        print_summary(&in);
    }
    ss_mesh_destroy(&in.mesh);
    return 0;
}

/* Smallest angle of a triangle or quad below which results get coarse, degrees. */
static const double poor_angle = 10.0;

static int print_warnings(const inspection *in)
{
    const ss_mesh_report *r = &in->report;
    int count = 0;
    if (r->open_edge.count > 0) {
        ++count;
        (void)printf("warning: %s: open edges: %lld (the first at node %d): the body has no "
                     "volume; close the holes if it should\n",
                     in->path, (long long)r->open_edge.count, r->open_edge.first[0]);
    }
    if (r->component_count > 1) {
        ++count;
        (void)printf("warning: %s: separate parts: %d: forces do not pass between them\n", in->path,
                     r->component_count);
    }
    if (r->angle_min < poor_angle) {
        ++count;
        (void)printf("warning: %s: the smallest angle of a %s is %.2g degrees: remesh for "
                     "%g or more\n",
                     in->path, in->mesh->quad_count > 0 ? "quad" : "triangle", r->angle_min,
                     poor_angle);
    }
    return count;
}

int command_check(int argc, char **argv)
{
    inspection in;
    int status = begin(argc, argv,
                       "Tells whether a mesh can be simulated: exit status 0 good, 1 usable with "
                       "warnings, 2 unusable.",
                       false, &in);
    if (status >= 0) {
        return status;
    }
    if (ss_mesh_accept(in.mesh, in.path, &in.error) != SOFTSIM_OK) {
        ss_args_print_error("softsim-mesh", &in.error);
        (void)print_warnings(&in);
        status = 2;
    } else {
        status = print_warnings(&in) > 0 ? 1 : 0;
        (void)printf("%s: %s\n", in.path, status == 0 ? "good" : "usable with warnings");
    }
    ss_mesh_destroy(&in.mesh);
    return status;
}
