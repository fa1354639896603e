/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "faulty.h"

#include "command.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/plain.h"

#include <stdio.h>

enum { FAULT_CROSSING = 1, FAULT_HOLE, FAULT_OVERLAP };

/* ---- faults left ---- */

static void count_marks(const bool *mark, int32_t count, ss_mesh_fault *out)
{
    for (int32_t i = 0; i < count; ++i) {
        if (mark[i]) {
            ss_mesh_add_fault(out, i);
        }
    }
}

bool faulty_find(faulty *f, const ss_mesh *mesh)
{
    *f = (faulty){.mesh = mesh, .is_crossing_complete = true};
    f->is_crossing = ss_memory_get((size_t)mesh->triangle_count, sizeof *f->is_crossing);
    f->is_at_hole = ss_memory_get((size_t)mesh->triangle_count, sizeof *f->is_at_hole);
    f->is_overlapping = ss_memory_get((size_t)mesh->tetrahedron_count, sizeof *f->is_overlapping);
    if (f->is_crossing == NULL || f->is_at_hole == NULL || f->is_overlapping == NULL ||
        !ss_mesh_mark_crossings(mesh, f->is_crossing, &f->is_crossing_complete) ||
        !ss_mesh_mark_open(mesh, f->is_at_hole) || !ss_mesh_find_holes(mesh, &f->hole) ||
        ss_mesh_check(mesh, &f->report) != SOFTSIM_OK ||
        !ss_mesh_mark_overlaps(mesh, f->report.edge_mean, f->is_overlapping)) {
        return false;
    }
    const int32_t count = ss_mesh_list_findings(mesh, &f->report, f->row);
    for (int32_t i = 0; i < count; ++i) {
        if (!f->row[i].is_harmless) {
            f->row[f->row_count++] = f->row[i];
        }
    }
    count_marks(f->is_crossing, mesh->triangle_count, &f->crossing);
    return true;
}

void faulty_fini(faulty *f)
{
    SS_EACH(ss_memory_free, f->is_crossing, f->is_at_hole, f->is_overlapping);
    *f = (faulty){0};
}

/* ---- text ---- */

/* A node of the element or edge that a finding names first; -1: it names none. */
static int32_t first_node(const ss_mesh *mesh, const ss_mesh_finding *finding)
{
    const int32_t number = finding->fault->first[0];
    const char kind = finding->where[0] == 't' ? finding->where[1] : finding->where[0];
    if (kind == 'e' && number < mesh->tetrahedron_count) {
        return mesh->tetrahedron[number][0];
    }
    if (kind == 'r' && number < mesh->triangle_count) {
        return mesh->triangle[number][0];
    }
    if (kind == 'q' && number < mesh->quad_count) {
        return mesh->quad[number][0];
    }
    return (kind == 'n' || kind == 'a') && number < mesh->node_count ? number : -1;
}

static void print_row(const faulty *f, const char *path, const ss_mesh_finding *finding)
{
    char numbers[160], place[96] = "";
    ss_mesh_print_fault(finding, numbers, sizeof numbers);
    const int32_t node = first_node(f->mesh, finding);
    if (node >= 0) {
        const double *x = f->mesh->position[node];
        (void)snprintf(place, sizeof place, ", the first at %.6g %.6g %.6g", x[0], x[1], x[2]);
    }
    ss_plain_print(stdout, "%s: left as they are: %s: %s%s: %s\n", path, finding->what, numbers,
                   place, finding->remedy);
}

void faulty_print(const faulty *f, const char *path)
{
    for (int32_t i = 0; i < f->row_count; ++i) {
        print_row(f, path, &f->row[i]);
    }
    const ss_mesh_finding own[] = {
        {.fault = &f->hole,
         .what = "holes",
         .where = "at node",
         .remedy = "too large, or with no way to close them: close them if the body has a volume"},
        {.fault = &f->crossing,
         .what = "triangles that cross others",
         .where = "triangle",
         .remedy = "move them apart in the program that made it (a boolean union, or a remesh by "
                   "voxels), and repair that"},
    };
    for (size_t i = 0; i < sizeof own / sizeof *own; ++i) {
        if (own[i].fault->count > 0) {
            print_row(f, path, &own[i]);
        }
    }
}

/* ---- a file to look at ---- */

softsim_status faulty_write(const faulty *f, const char *path, softsim_error *error)
{
    const ss_mesh *mesh = f->mesh;
    const int32_t triangles = mesh->triangle_count, tetrahedra = mesh->tetrahedron_count;
    const int64_t most = (int64_t)triangles + tetrahedra;
    ss_mesh_cell *cell = ss_memory_get((size_t)most, sizeof *cell);
    if (cell == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    int32_t count = 0;
    for (int32_t t = 0; t < triangles; ++t) {
        if (f->is_crossing[t] || f->is_at_hole[t]) {
            cell[count++] =
                (ss_mesh_cell){.node = mesh->triangle[t],
                               .corners = 3,
                               .value = f->is_crossing[t] ? FAULT_CROSSING : FAULT_HOLE};
        }
    }
    for (int32_t e = 0; e < tetrahedra; ++e) {
        if (f->is_overlapping[e]) {
            cell[count++] =
                (ss_mesh_cell){.node = mesh->tetrahedron[e], .corners = 4, .value = FAULT_OVERLAP};
        }
    }
    const softsim_status status =
        count > 0 ? ss_mesh_write_cells(mesh, cell, count, "fault", path, error) : SOFTSIM_OK;
    if (status == SOFTSIM_OK && count > 0) {
        ss_plain_print(stdout,
                       "%s: %d faulty elements; \"fault\" is %d: crosses another, %d: at an open "
                       "edge, %d: overlaps another\n",
                       path, count, FAULT_CROSSING, FAULT_HOLE, FAULT_OVERLAP);
    } else if (status == SOFTSIM_OK) {
        ss_plain_print(stdout, "%s: not written: nothing faulty is left\n", path);
    }
    ss_memory_free(cell);
    return status;
}
