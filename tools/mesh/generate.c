/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh generate: organs (shape.h, spread.h) and the two open grids (mesh.h: their places
 * and numbers), as quads or as their triangles with alternating diagonals. Node row * columns +
 * column of a grid stays that through OBJ and import.
 */
#include "command.h"
#include "mesh/mesh.h"
#include "rt/args.h"
#include "rt/vec.h"
#include "spread.h"

#include <stdio.h>
#include <string.h>

typedef enum shape_kind {
    SHAPE_KIDNEY,
    SHAPE_LIVER,
    SHAPE_ELLIPSOID,
    SHAPE_CYLINDER,
    SHAPE_PLANE,
    SHAPE_COUNT
} shape_kind;

static const char *const shape_names[SHAPE_COUNT] = {"kidney", "liver", "ellipsoid", "cylinder",
                                                     "plane"};

/* Zero or NULL: not given. */
typedef struct request {
    shape_kind shape;
    int64_t points, rows, columns;
    double size_mm[3], radius_m, length_m, width_m, height_m;
    const char *out;
    int32_t units;
    bool keeps_quads;
} request;

/* ---- grids -------------------------------------------------------------------------------------
 */

static softsim_status make_grid(const request *q, ss_mesh **out, softsim_error *error)
{
    const int32_t rows = (int32_t)q->rows;
    const int32_t columns = (int32_t)q->columns;
    ss_mesh *grid = NULL;
    softsim_status status =
        q->shape == SHAPE_CYLINDER
            ? ss_mesh_create_cylinder(rows, columns, q->radius_m, q->length_m, &grid, error)
            : ss_mesh_create_plane(rows, columns, q->width_m, q->height_m, &grid, error);
    if (status != SOFTSIM_OK || q->keeps_quads) {
        *out = grid;
        return status;
    }
    status =
        ss_mesh_create(grid->node_count, (const double(*)[3])grid->position, grid->triangle_count,
                       (const int32_t(*)[3])grid->triangle, 0, NULL, out, error);
    ss_mesh_destroy(&grid);
    return status;
}

/* ---- organs ------------------------------------------------------------------------------------
 */

static softsim_status make_organ(const request *q, ss_mesh **out, softsim_error *error)
{
    static const organ_kind kinds[] = {ORGAN_KIDNEY, ORGAN_LIVER, ORGAN_ELLIPSOID};
    const double half[3] = {0.5e-3 * q->size_mm[0], 0.5e-3 * q->size_mm[1], 0.5e-3 * q->size_mm[2]};
    organ o;
    spread s;
    organ_init(&o, kinds[q->shape], half);
    if (!spread_init(&s, &o, (int32_t)q->points)) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for %lld points",
                          (long long)q->points);
        return SOFTSIM_ERROR_MEMORY;
    }
    /* A millionth of the size is enough for a shape made up, and keeps the file short and free of
     * the last digits of the machine's own sine. */
    const double step = pow(10.0, ceil(log10(1e-6 * o.half[0])));
    for (int32_t i = 0; i < s.node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            s.position[i][k] = round(s.position[i][k] / step) * step;
        }
    }
    const softsim_status status =
        ss_mesh_create(s.node_count, (const double(*)[3])s.position, s.triangle_count,
                       (const int32_t(*)[3])s.triangle, 0, NULL, out, error);
    spread_fini(&s);
    return status;
}

/* ---- the command --------------------------------------------------------------------------------
 */

static void need(bool is_given, bool is_used, const char *option, const char *shape,
                 softsim_error *error)
{
    if (is_given && !is_used) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s means nothing for a %s: leave it out",
                          option, shape);
    }
}

static bool parse_size(const char *text, double out[3])
{
    int end = 0;
    if (sscanf(text, "%lf,%lf,%lf%n", &out[0], &out[1], &out[2], &end) != 3 || text[end] != '\0') {
        return false;
    }
    const double least = fmin(out[0], fmin(out[1], out[2]));
    const double greatest = fmax(out[0], fmax(out[1], out[2]));
    return least >= 1.0 && greatest <= 1e6 && greatest <= 10.0 * least;
}

/* Refuses options of other shapes and puts defaults where nothing was given. */
static void complete(request *q, const char *size, softsim_error *error)
{
    const char *name = shape_names[q->shape];
    const bool is_cylinder = q->shape == SHAPE_CYLINDER;
    const bool is_plane = q->shape == SHAPE_PLANE;
    const bool is_grid = is_cylinder || is_plane;
    need(q->points != 0, !is_grid, "--points", name, error);
    need(size != NULL, q->shape == SHAPE_ELLIPSOID, "--size-mm", name, error);
    need(q->rows != 0, is_grid, "--rows", name, error);
    need(q->columns != 0, is_grid, "--columns", name, error);
    need(q->radius_m != 0.0, is_cylinder, "--radius-m", name, error);
    need(q->length_m != 0.0, is_cylinder, "--length-m", name, error);
    need(q->width_m != 0.0, is_plane, "--width-m", name, error);
    need(q->height_m != 0.0, is_plane, "--height-m", name, error);
    need(q->keeps_quads, is_grid, "--grid", name, error);
    if (size != NULL && !parse_size(size, q->size_mm)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--size-mm: '%s' is not X,Y,Z: three lengths of 1 to 1e6, none more "
                          "than 10 times another",
                          size);
    } else if (size == NULL) {
        ss_set3(q->size_mm, 100.0, 60.0, 60.0);
    }
    q->points = q->points != 0 ? q->points : 1200;
    q->rows = q->rows != 0 ? q->rows : is_cylinder ? 15 : 21;
    q->columns = q->columns != 0 ? q->columns : is_cylinder ? 24 : 21;
    q->radius_m = q->radius_m != 0.0 ? q->radius_m : 1.0;
    q->length_m = q->length_m != 0.0 ? q->length_m : 4.0;
    q->width_m = q->width_m != 0.0 ? q->width_m : 0.1;
    q->height_m = q->height_m != 0.0 ? q->height_m : 0.1;
    q->units = q->units >= 0 ? q->units : is_grid ? 3 : 0;
    if (is_cylinder && q->columns < 3) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--columns: a cylinder has at least 3, not %lld", (long long)q->columns);
    }
    if (q->rows * q->columns > 1000000) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--rows times --columns: at most 1000000 points, not %lld",
                          (long long)(q->rows * q->columns));
    }
}

static ss_args_result parse(int argc, char **argv, request *q, softsim_error *error)
{
    const char *size = NULL;
    const char *shape = "";
    int32_t count = 0;
    *q = (request){.units = -1};
    const ss_arg rows[] = {
        {"--points", SS_ARG_INTEGER, &q->points, SPREAD_MIN_POINTS, SPREAD_MAX_POINTS, "N",
         "kidney, liver, ellipsoid: exactly N points (1200)"},
        {"--size-mm", SS_ARG_STRING, &size, 0, 0, "X,Y,Z", "ellipsoid: full lengths (100,60,60)"},
        {"--rows", SS_ARG_INTEGER, &q->rows, 2, 1000, "N",
         "cylinder: rings (15); plane: points along y (21)"},
        {"--columns", SS_ARG_INTEGER, &q->columns, 2, 1000, "N",
         "cylinder: points of a ring (24); plane: points along x (21)"},
        {"--radius-m", SS_ARG_NUMBER, &q->radius_m, 1e-6, 1e3, "R", "cylinder (1)"},
        {"--length-m", SS_ARG_NUMBER, &q->length_m, 1e-6, 1e3, "L", "cylinder (4)"},
        {"--width-m", SS_ARG_NUMBER, &q->width_m, 1e-6, 1e3, "W", "plane: along x (0.1)"},
        {"--height-m", SS_ARG_NUMBER, &q->height_m, 1e-6, 1e3, "H", "plane: along y (0.1)"},
        {"--grid", SS_ARG_FLAG, &q->keeps_quads, 0, 0, "",
         "cylinder, plane: as quads, not as triangles"},
        {"--units", SS_ARG_CHOICE, &q->units, 0, 0, UNITS,
         "of the file (organs: mm; cylinder, plane: m)"},
        {"--out", SS_ARG_STRING, &q->out, 0, 0, "FILE", ".obj or .msh (SHAPE.obj)"},
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "kidney|liver|ellipsoid|cylinder|plane [options]",
                      "Writes a surface of well-shaped triangles or quads.", rows,
                      (int32_t)(sizeof rows / sizeof rows[0]), &shape, 1, 1, &count, error);
    if (result == SS_ARGS_DONE || count < 1) {
        return result;
    }
    while (q->shape < SHAPE_COUNT && strcmp(shape, shape_names[q->shape]) != 0) {
        ++q->shape;
    }
    if (q->shape == SHAPE_COUNT) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "'%s' is none of kidney|liver|ellipsoid|cylinder|plane", shape);
    } else {
        complete(q, size, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text);
    return length >= strlen(end) && strcmp(text + length - strlen(end), end) == 0;
}

static softsim_status write_mesh(ss_mesh *mesh, const request *q, const char *path,
                                 softsim_error *error)
{
    static const double none[3] = {0.0, 0.0, 0.0};
    ss_mesh_transform(mesh, 1.0 / metres_per_unit(q->units), none, none);
    return ends_with(path, ".msh") ? ss_mesh_write_msh(mesh, path, error)
                                   : ss_mesh_write_obj(mesh, path, error);
}

static int fail(const char *program, const softsim_error *error, int status)
{
    ss_args_print_error(program, error);
    return status;
}

int command_generate(int argc, char **argv)
{
    request q;
    softsim_error error = {0};
    const ss_args_result result = parse(argc, argv, &q, &error);
    if (result != SS_ARGS_RUN) {
        return result == SS_ARGS_DONE ? 0 : fail("softsim-mesh", &error, 2);
    }
    char standard[64];
    (void)snprintf(standard, sizeof standard, "%s.obj", shape_names[q.shape]);
    const char *path = q.out != NULL ? q.out : standard;
    if (!ends_with(path, ".obj") && !ends_with(path, ".msh")) {
        softsim_error_add(&error, SOFTSIM_ERROR_ARGUMENT,
                          "--out: '%s' ends in neither .obj nor .msh", path);
        return fail("softsim-mesh", &error, 2);
    }

    ss_mesh *mesh = NULL;
    const bool is_grid = q.shape == SHAPE_CYLINDER || q.shape == SHAPE_PLANE;
    softsim_status status = is_grid ? make_grid(&q, &mesh, &error) : make_organ(&q, &mesh, &error);
    if (status == SOFTSIM_OK && ss_mesh_accept(mesh, path, NULL) != SOFTSIM_OK) {
        status = SOFTSIM_ERROR_MESH;
        softsim_error_add(&error, status, "%s: too few points for this shape: give more", path);
    }
    if (status == SOFTSIM_OK) {
        status = write_mesh(mesh, &q, path, &error);
    }
    if (status == SOFTSIM_OK) {
        const bool has_quads = mesh->quad_count > 0;
        (void)printf("%s: %d nodes, %d %s, in %s\n", path, mesh->node_count,
                     has_quads ? mesh->quad_count : mesh->triangle_count,
                     has_quads ? "quads" : "triangles", unit_name(q.units));
    }
    ss_mesh_destroy(&mesh);
    return status == SOFTSIM_OK ? 0 : fail("softsim-mesh", &error, 1);
}
