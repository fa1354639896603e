/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* What the commands share: units, groups, and files written in the format that their name asks for.
 */
#include "command.h"

#include "rt/args.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

int end_command(int exit_code, const softsim_error *error)
{
    if (exit_code != 0) {
        ss_args_print_error("softsim-mesh", error);
    }
    return exit_code;
}

int run_command(int argc, char **argv, void *what,
                ss_args_result (*parse)(int argc, char **argv, void *what, softsim_error *error),
                int (*work)(const void *what, softsim_error *error))
{
    softsim_error error = {0};
    const ss_args_result result = parse(argc, argv, what, &error);
    int exit_code = 0;
    if (ss_args_may_run("softsim-mesh", result, &error, &exit_code)) {
        exit_code = end_command(work(what, &error), &error);
    }
    return exit_code;
}

double metres_per_unit(int index)
{
    static const double metres[] = {1e-3, 1e-2, 1e-1, 1.0};
    return metres[index];
}

const char *unit_name(int index)
{
    static const char *const names[] = {"mm", "cm", "dm", "m"};
    return names[index];
}

bool is_usable_size(const ss_mesh_report *report, bool is_metric)
{
    double diagonal[3];
    ss_sub3(diagonal, report->box_max, report->box_min);
    const double size = ss_norm3(diagonal);
    bool is_usable = is_metric && ss_mesh_is_size_usable(size);
    for (int unit = 0; unit < UNIT_COUNT && !is_metric; ++unit) {
        is_usable = is_usable || ss_mesh_is_size_usable(size * metres_per_unit(unit));
    }
    return is_usable;
}

static const struct {
    const char *end;
    bool has_tetrahedra;
    softsim_status (*write)(const ss_mesh *mesh, const char *path, softsim_error *error);
} formats[] = {
    {".obj", false, ss_mesh_write_obj},
    {".msh", true, ss_mesh_write_msh},
    {".vtk", true, ss_mesh_write_vtk},
    {".stl", false, ss_mesh_write_stl},
};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

/* -1 when the name ends in none. */
static int find_format(const char *path)
{
    const size_t length = strlen(path);
    for (int i = 0; i < FORMAT_COUNT; ++i) {
        const size_t end = strlen(formats[i].end);
        if (length > end && strcasecmp(path + length - end, formats[i].end) == 0) {
            return i;
        }
    }
    return -1;
}

bool can_write_mesh(const char *path, const char *option, bool has_tetrahedra, softsim_error *error)
{
    const int format = find_format(path);
    const char *why = ss_files_why_no_output(path);
    if (why != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: '%s' is %s; give another name",
                          option, path, why);
        return false;
    }
    if (format < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: '%s' ends in none of .obj, .msh, .vtk, .stl", option, path);
        return false;
    }
    if (has_tetrahedra && !formats[format].has_tetrahedra) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: '%s' would hold no tetrahedra: name a .msh or .vtk file", option,
                          path);
        return false;
    }
    return true;
}

bool is_rounded_by(const char *path)
{
    return formats[find_format(path)].write == ss_mesh_write_stl;
}

softsim_status write_mesh(const ss_mesh *mesh, const char *path, softsim_error *error)
{
    return formats[find_format(path)].write(mesh, path, error);
}

void print_written(const ss_mesh *mesh, const char *path, const char *unit)
{
    const char *in = unit != NULL ? ", in " : "";
    unit = unit != NULL ? unit : "";
    ss_plain_print(stdout, "%s: %d nodes, ", path, mesh->node_count);
    if (mesh->tetrahedron_count > 0 && formats[find_format(path)].has_tetrahedra) {
        ss_mesh_quality quality;
        ss_mesh_measure_quality(mesh, &quality);
        (void)printf("%d tetrahedra %sof dihedral angles from %.1f to %.1f degrees%s%s\n",
                     mesh->tetrahedron_count, mesh->middle != NULL ? "of second order " : "",
                     quality.dihedral_min, quality.dihedral_max, in, unit);
    } else if (mesh->tetrahedron_count > 0) {
        (void)printf("of which the surface: %d triangles%s%s\n", mesh->triangle_count, in, unit);
    } else if (mesh->quad_count > 0) {
        (void)printf("%d quads%s%s\n", mesh->quad_count, in, unit);
    } else {
        (void)printf("%d triangles%s%s\n", mesh->triangle_count, in, unit);
    }
}

bool carry_groups(const ss_mesh *from, const int32_t *number, ss_mesh *to)
{
    to->group = ss_memory_get((size_t)from->group_count, sizeof *to->group);
    for (int32_t g = 0; g < from->group_count && to->group != NULL; ++g) {
        const ss_mesh_group *source = &from->group[g];
        ss_mesh_group *group = &to->group[g];
        group->node = ss_memory_get((size_t)source->node_count, sizeof *group->node);
        if (group->node == NULL) {
            return false;
        }
        memcpy(group->name, source->name, sizeof group->name);
        ++to->group_count;
        for (int32_t i = 0; i < source->node_count; ++i) {
            const int32_t node = number != NULL ? number[source->node[i]] - 1 : source->node[i];
            if (node >= 0) {
                group->node[group->node_count++] = node;
            }
        }
    }
    return to->group != NULL;
}

softsim_status change_order(int64_t order, ss_mesh **inout_mesh, softsim_error *error)
{
    ss_mesh *mesh = *inout_mesh, *changed = NULL;
    if (order == 0 || order == (mesh->middle != NULL ? 2 : 1)) {
        return SOFTSIM_OK;
    }
    const softsim_status status =
        (order == 2 ? ss_mesh_raise : ss_mesh_lower)(mesh, &changed, error);
    if (status == SOFTSIM_OK) {
        ss_mesh_destroy(inout_mesh);
        *inout_mesh = changed;
    }
    return status;
}
