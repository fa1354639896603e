/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Structured grids of quads; mesh.h says how nodes and elements are numbered.
 */
#include "mesh/mesh.h"
#include "rt/memory.h"
#include "rt/vec.h"

softsim_status ss_mesh_create_grid(int32_t rows, int32_t columns, ss_mesh_closed closed,
                                   const double (*position)[3], ss_mesh **out_mesh,
                                   softsim_error *error)
{
    const bool is_row_ring = closed == SS_MESH_CLOSED_ROWS;
    const bool is_column_ring = closed == SS_MESH_CLOSED_COLUMNS;
    *out_mesh = NULL;
    if (rows < (is_row_ring ? 3 : 2) || columns < (is_column_ring ? 3 : 2) ||
        (int64_t)rows * columns > SS_MESH_MAX_GRID) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "a grid of %d rows and %d columns: give 2 or more of each, 3 where they "
                          "close a ring, and at most %d points",
                          rows, columns, SS_MESH_MAX_GRID);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    const int32_t quad_rows = rows - (is_row_ring ? 0 : 1);
    const int32_t quad_columns = columns - (is_column_ring ? 0 : 1);
    int32_t(*quad)[4] = ss_memory_get((size_t)quad_rows * (size_t)quad_columns, sizeof *quad);
    if (quad == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a grid of %d points",
                          rows * columns);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t r = 0; r < quad_rows; ++r) {
        for (int32_t c = 0; c < quad_columns; ++c) {
            const int32_t above = (r + 1) % rows * columns;
            const int32_t right = (c + 1) % columns;
            int32_t *node = quad[r * quad_columns + c];
            node[0] = r * columns + right;
            node[1] = above + right;
            node[2] = above + c;
            node[3] = r * columns + c;
        }
    }
    const softsim_status status =
        ss_mesh_create_quads(rows * columns, position, quad_rows * quad_columns,
                             (const int32_t(*)[4])quad, out_mesh, error);
    ss_memory_free(quad);
    return status;
}

/* Where number i of n lies on a length about 0. */
static double along(double length, int32_t i, int32_t n)
{
    return length * i / (n - 1) - 0.5 * length;
}

typedef struct form {
    int32_t rows, columns;
    bool is_ring;
    double size[2]; /* radius and length, or width and height */
} form;

static softsim_status create_form(const form *f, ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    const bool has_room =
        f->rows > 0 && f->columns > 0 && (int64_t)f->rows * f->columns <= SS_MESH_MAX_GRID;
    double(*x)[3] = ss_memory_get(has_room ? (size_t)f->rows * (size_t)f->columns : 0, sizeof *x);
    if (x == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for a grid");
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t r = 0; has_room && r < f->rows; ++r) {
        for (int32_t c = 0; c < f->columns; ++c) {
            double *out = x[r * f->columns + c];
            const double phi = 2.0 * SS_PI * c / f->columns;
            if (f->is_ring) {
                ss_set3(out, f->size[0] * cos(phi), f->size[0] * sin(phi),
                        along(f->size[1], r, f->rows));
            } else {
                ss_set3(out, along(f->size[0], c, f->columns), along(f->size[1], r, f->rows), 0.0);
            }
        }
    }
    const softsim_status status = ss_mesh_create_grid(
        f->rows, f->columns, f->is_ring ? SS_MESH_CLOSED_COLUMNS : SS_MESH_CLOSED_NONE,
        (const double(*)[3])x, out_mesh, error);
    ss_memory_free(x);
    return status;
}

softsim_status ss_mesh_create_cylinder(int32_t rows, int32_t columns, double radius, double length,
                                       ss_mesh **out_mesh, softsim_error *error)
{
    const form f = {rows, columns, true, {radius, length}};
    return create_form(&f, out_mesh, error);
}

softsim_status ss_mesh_create_plane(int32_t rows, int32_t columns, double width, double height,
                                    ss_mesh **out_mesh, softsim_error *error)
{
    const form f = {rows, columns, false, {width, height}};
    return create_form(&f, out_mesh, error);
}
