/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "scene/grid.h"

#include <stdlib.h>

typedef struct count {
    int32_t rows, columns;
    ss_mesh_closed closed;
} count;

static const ss_scene_row *closed_row(void)
{
    const ss_scene_row *object = ss_scene_find_row(ss_scene_root, "object");
    const ss_scene_row *grid = ss_scene_find_row(object->child, "grid");
    return ss_scene_find_row(grid->child, "closed");
}

/* Rows and columns of a form; false with a fault when no grid has so many, or so few. */
static bool take_count(ss_scene_space *space, const ss_scene_node *form, count *out)
{
    const double rows = ss_scene_get_number(form, "rows", 0);
    const double columns = ss_scene_get_number(form, "columns", 0);
    const ss_scene_node *closed = ss_scene_node_find(form, "closed");
    const int32_t ring = closed != NULL ? ss_scene_choice(closed_row()->choices, closed->text) : 0;
    *out = (count){.closed = (ss_mesh_closed)ring};
    if (rows * columns > SS_MESH_MAX_GRID || (out->closed == SS_MESH_CLOSED_ROWS && rows < 3) ||
        (out->closed == SS_MESH_CLOSED_COLUMNS && columns < 3)) {
        ss_scene_key_fault(space->report, ss_scene_node_find(form, "rows"),
                           "a grid of %.0f rows and %.0f columns; give at most %d nodes in all, "
                           "and at least 3 of what is closed",
                           rows, columns, SS_MESH_MAX_GRID);
        return false;
    }
    out->rows = (int32_t)rows;
    out->columns = (int32_t)columns;
    return true;
}

static softsim_status read_table(ss_scene_space *space, ss_scene_node *file, double metres,
                                 const count *n, ss_mesh **out_mesh, softsim_error *mesh_error)
{
    if (!(metres > 0)) {
        ss_scene_key_fault(space->report, file,
                           "object.units is missing; give the unit of the "
                           "lengths in the file");
        return SOFTSIM_ERROR_SCENE;
    }
    const int32_t node_count = n->rows * n->columns;
    double(*position)[3] = calloc((size_t)node_count, sizeof *position);
    softsim_status status = SOFTSIM_ERROR_SCENE;
    if (position == NULL) {
        ss_scene_key_fault(space->report, file, "out of memory");
    } else if (ss_scene_read_points(space, file, metres, node_count, position)) {
        status = ss_mesh_create_grid(n->rows, n->columns, n->closed, (const double(*)[3])position,
                                     out_mesh, mesh_error);
    }
    free(position);
    return status;
}

bool ss_scene_make_grid(ss_scene_space *space, ss_scene_node *grid, double metres,
                        ss_mesh **out_mesh, softsim_error *mesh_error)
{
    ss_scene_node *file = ss_scene_node_find(grid, "file");
    const ss_scene_node *cylinder = ss_scene_node_find(grid, "cylinder");
    const ss_scene_node *plane = ss_scene_node_find(grid, "plane");
    const ss_scene_node *form = file != NULL ? grid : cylinder != NULL ? cylinder : plane;
    count n;
    if (!take_count(space, form, &n)) {
        return false;
    }
    softsim_status status;
    if (file != NULL) {
        status = read_table(space, file, metres, &n, out_mesh, mesh_error);
    } else if (cylinder != NULL) {
        status =
            ss_mesh_create_cylinder(n.rows, n.columns, ss_scene_get_number(form, "radius_m", 0),
                                    ss_scene_get_number(form, "length_m", 0), out_mesh, mesh_error);
    } else {
        status =
            ss_mesh_create_plane(n.rows, n.columns, ss_scene_get_number(form, "width_m", 0),
                                 ss_scene_get_number(form, "height_m", 0), out_mesh, mesh_error);
    }
    return status == SOFTSIM_OK;
}
