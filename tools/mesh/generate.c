/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh generate: organs and other bodies, as surfaces (shape.h, spread.h) or tetrahedra
 * (volume.h), and the two open grids (mesh.h: their places and numbers), as quads or as their
 * triangles with alternating diagonals. Node row * columns + column of a grid stays that through
 * OBJ and import.
 */
#include "command.h"
#include "mesh/mesh.h"
#include "round.h"
#include "rt/args.h"
#include "rt/vec.h"
#include "spread.h"
#include "volume.h"

#include <stdio.h>
#include <string.h>

typedef enum shape_kind {
    SHAPE_KIDNEY,
    SHAPE_LIVER,
    SHAPE_ELLIPSOID,
    SHAPE_VENTRICLE,
    SHAPE_ELLIPSOIDS,
    SHAPE_BLOCK,
    SHAPE_BEAM,
    SHAPE_CYLINDER,
    SHAPE_PLANE,
    SHAPE_COUNT
} shape_kind;

#define SHAPES "kidney|liver|ellipsoid|ventricle|ellipsoids|block|beam|cylinder|plane"

/* Lengths in mm; zero where the shape has none. Points of the surface, and of the volume. */
static const struct {
    const char *name;
    volume_kind volume;
    int32_t points, volume_points;
    double size[3], inner[3];
} shapes[SHAPE_COUNT] = {
    [SHAPE_KIDNEY] = {"kidney", VOLUME_KIDNEY, 1200, 3000, {0}, {0}},
    [SHAPE_LIVER] = {"liver", VOLUME_LIVER, 1200, 5762, {0}, {0}},
    [SHAPE_ELLIPSOID] = {"ellipsoid", VOLUME_ELLIPSOID, 1200, 3000, {100, 60, 60}, {0}},
    [SHAPE_VENTRICLE] = {"ventricle", VOLUME_VENTRICLE, 3000, 4000, {20, 20, 40}, {14, 14, 34}},
    [SHAPE_ELLIPSOIDS] = {"ellipsoids", VOLUME_ELLIPSOIDS, 3000, 4000, {100, 80, 80}, {60, 45, 45}},
    [SHAPE_BLOCK] = {"block", VOLUME_BLOCK, 1200, 2197, {100, 100, 100}, {0}},
    [SHAPE_BEAM] = {"beam", VOLUME_BEAM, 1200, 2299, {200, 40, 40}, {0}},
    [SHAPE_CYLINDER] = {"cylinder", VOLUME_CYLINDER, 0, 3000, {0}, {0}},
    [SHAPE_PLANE] = {"plane", VOLUME_BLOCK, 0, 0, {0}, {0}},
};

/* Zero or NULL: not given. */
typedef struct request {
    shape_kind shape;
    int64_t points, rows, columns, order;
    double size_mm[3], inner_mm[3], base_mm;
    double radius_m, length_m, width_m, height_m;
    const char *out;
    int32_t units;
    bool keeps_quads;
    bool has_tetrahedra;
} request;

/* ---- grids ---- */

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

/* ---- bodies ---- */

static volume_plan plan_volume(const request *q)
{
    volume_plan plan = {.kind = shapes[q->shape].volume,
                        .base = 1e-3 * q->base_mm,
                        .points = (int32_t)q->points,
                        .is_surface = !q->has_tetrahedra};
    ss_scale3(plan.size, q->size_mm, 1e-3);
    ss_scale3(plan.inner, q->inner_mm, 1e-3);
    if (q->shape == SHAPE_CYLINDER) {
        ss_set3(plan.size, 2.0 * q->radius_m, 2.0 * q->radius_m, q->length_m);
    }
    return plan;
}

/* The surface of a smooth body: points spread evenly, exactly as many as asked for. */
static softsim_status make_smooth(const request *q, ss_mesh **out, softsim_error *error)
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
    softsim_status status =
        ss_mesh_create(s.node_count, (const double(*)[3])s.position, s.triangle_count,
                       (const int32_t(*)[3])s.triangle, 0, NULL, out, error);
    spread_fini(&s);
    const volume_plan plan = plan_volume(q);
    if (status == SOFTSIM_OK && !volume_add_groups(&plan, *out)) {
        ss_mesh_destroy(out);
        status = SOFTSIM_ERROR_MEMORY;
        softsim_error_add(error, status, "out of memory for %lld points", (long long)q->points);
    }
    return status;
}

static softsim_status make_body(const request *q, ss_mesh **out, softsim_error *error)
{
    if (q->shape <= SHAPE_ELLIPSOID && !q->has_tetrahedra) {
        return make_smooth(q, out, error);
    }
    const volume_plan plan = plan_volume(q);
    softsim_status status = volume_create(&plan, out, error);
    if (status == SOFTSIM_OK && q->order == 2) {
        ss_mesh *first = *out;
        status = ss_mesh_raise(first, out, error);
        ss_mesh_destroy(&first);
        if (status == SOFTSIM_OK) {
            round_middles(&plan, *out);
        }
    }
    if (status != SOFTSIM_OK || q->has_tetrahedra || (*out)->tetrahedron_count == 0) {
        return status;
    }
    ss_mesh *volume = *out;
    *out = volume_take_surface(volume);
    ss_mesh_destroy(&volume);
    if (*out == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for %lld points",
                          (long long)q->points);
        return SOFTSIM_ERROR_MEMORY;
    }
    return SOFTSIM_OK;
}

/* ---- the command ---- */

static void need(bool is_given, bool is_used, const char *option, const char *shape,
                 softsim_error *error)
{
    if (is_given && !is_used) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s means nothing for a %s: leave it out",
                          option, shape);
    }
}

/* Three lengths in mm, or what stands for none given. */
static void take_size(const char *text, const char *option, const double standard[3], double out[3],
                      softsim_error *error)
{
    int end = 0;
    ss_copy3(out, standard);
    if (text == NULL) {
        return;
    }
    const bool is_read =
        sscanf(text, "%lf,%lf,%lf%n", &out[0], &out[1], &out[2], &end) == 3 && text[end] == '\0';
    const bool is_finite = isfinite(out[0]) && isfinite(out[1]) && isfinite(out[2]);
    const double least = is_read ? fmin(out[0], fmin(out[1], out[2])) : 0.0;
    const double greatest = is_read ? fmax(out[0], fmax(out[1], out[2])) : INFINITY;
    if (!(is_finite && least >= 1.0 && greatest <= 1e6 && greatest <= 10.0 * least)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: '%s' is not X,Y,Z: three lengths of 1 to 1e6, none more than 10 "
                          "times another",
                          option, text);
    }
}

static void check_shell(const request *q, softsim_error *error)
{
    for (int k = 0; k < 3; ++k) {
        if (q->inner_mm[k] >= 0.98 * q->size_mm[k]) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--inner-mm: %g is too close to --size-mm's %g: leave a wall of 1 %% "
                              "or more",
                              q->inner_mm[k], q->size_mm[k]);
            return;
        }
    }
    if (q->shape == SHAPE_VENTRICLE && fabs(q->base_mm) > 0.45 * q->inner_mm[2]) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--base-mm: %g is not within 0.45 of --inner-mm's Z, %g, from the centre",
                          q->base_mm, q->inner_mm[2]);
    }
}

/* Refuses options that the shape does not have. */
static void check_options(const request *q, bool has_size, bool has_inner, softsim_error *error)
{
    const char *name = shapes[q->shape].name;
    const bool is_cylinder = q->shape == SHAPE_CYLINDER;
    const bool is_plane = q->shape == SHAPE_PLANE;
    const bool is_grid = is_plane || (is_cylinder && !q->has_tetrahedra);
    need(q->has_tetrahedra, !is_plane, "--tetrahedra", name, error);
    need(q->order == 2, q->has_tetrahedra, "--order 2", "surface", error);
    need(q->points != 0, !is_grid, "--points", name, error);
    need(has_size, shapes[q->shape].size[0] > 0.0, "--size-mm", name, error);
    need(has_inner, shapes[q->shape].inner[0] > 0.0, "--inner-mm", name, error);
    need(!isnan(q->base_mm), q->shape == SHAPE_VENTRICLE, "--base-mm", name, error);
    if (is_cylinder && q->has_tetrahedra) {
        name = "cylinder of tetrahedra";
    }
    need(q->rows != 0, is_grid, "--rows", name, error);
    need(q->columns != 0, is_grid, "--columns", name, error);
    need(q->keeps_quads, is_grid, "--grid", name, error);
    need(q->radius_m != 0.0, is_cylinder, "--radius-m", name, error);
    need(q->length_m != 0.0, is_cylinder, "--length-m", name, error);
    need(q->width_m != 0.0, is_plane, "--width-m", name, error);
    need(q->height_m != 0.0, is_plane, "--height-m", name, error);
}

/* Checks what was given and puts defaults where nothing was. */
static void complete(request *q, const char *size, const char *inner, softsim_error *error)
{
    const bool is_cylinder = q->shape == SHAPE_CYLINDER;
    const bool is_metric = is_cylinder || q->shape == SHAPE_PLANE;
    check_options(q, size != NULL, inner != NULL, error);
    take_size(size, "--size-mm", shapes[q->shape].size, q->size_mm, error);
    take_size(inner, "--inner-mm", shapes[q->shape].inner, q->inner_mm, error);
    q->base_mm = isnan(q->base_mm) ? 5.0 : q->base_mm;
    if (error->fault_count == 0 && q->inner_mm[0] > 0.0) {
        check_shell(q, error);
    }
    if (q->points == 0) {
        q->points = q->has_tetrahedra ? shapes[q->shape].volume_points : shapes[q->shape].points;
    } else if (q->shape <= SHAPE_ELLIPSOID && !q->has_tetrahedra && q->points > SPREAD_MAX_POINTS) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--points: at most %d for the surface of a %s", SPREAD_MAX_POINTS,
                          shapes[q->shape].name);
    }
    q->rows = q->rows != 0 ? q->rows : is_cylinder ? 15 : 21;
    q->columns = q->columns != 0 ? q->columns : is_cylinder ? 24 : 21;
    q->radius_m = q->radius_m != 0.0 ? q->radius_m : 1.0;
    q->length_m = q->length_m != 0.0 ? q->length_m : 4.0;
    q->width_m = q->width_m != 0.0 ? q->width_m : 0.1;
    q->height_m = q->height_m != 0.0 ? q->height_m : 0.1;
    q->units = q->units >= 0 ? q->units : is_metric ? 3 : 0;
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

/* The command and the groups of nodes that its shapes have. */
static void describe(char *out, size_t size)
{
    int used = snprintf(out, size,
                        "Writes a body of well-shaped triangles, quads or tetrahedra. Groups, for "
                        "a scene's supports and loads:");
    for (int i = 0; i < SHAPE_COUNT; ++i) {
        char names[128];
        volume_name_groups(shapes[i].volume, names, sizeof names);
        if (i != SHAPE_PLANE && names[0] != '\0') {
            used += snprintf(out + used, size - (size_t)used, "\n  %-12s %s%s", shapes[i].name,
                             names, i == SHAPE_CYLINDER ? " (with --tetrahedra)" : "");
        }
    }
}

static ss_args_result parse(int argc, char **argv, request *q, softsim_error *error)
{
    const char *size = NULL;
    const char *inner = NULL;
    const char *shape = "";
    int32_t count = 0;
    *q = (request){.units = -1, .base_mm = NAN};
    const ss_arg rows[] = {
        SS_FLAG("--tetrahedra", &q->has_tetrahedra,
                "a volume, not its surface alone (not of a plane)"),
        {"--order", SS_ARG_INTEGER, &q->order, 1, 2, "N",
         "2: tetrahedra with a node in the middle of each edge, on the true shape where that is on "
         "a smooth surface (1)"},
        {"--points", SS_ARG_INTEGER, &q->points, VOLUME_MIN_POINTS, VOLUME_MAX_POINTS, "N",
         "exactly N on the surface of a kidney, liver, ellipsoid (1200); else about N; without "
         "mid-edge nodes"},
        SS_TEXT("--size-mm", &size, "X,Y,Z",
                "full lengths: ellipsoid (100,60,60), ventricle (20,20,40), ellipsoids "
                "(100,80,80), block "
                "(100,100,100), beam (200,40,40)"),
        SS_TEXT("--inner-mm", &inner, "X,Y,Z",
                "of the cavity: ventricle (14,14,34), ellipsoids (60,45,45)"),
        {"--base-mm", SS_ARG_NUMBER, &q->base_mm, -1e6, 1e6, "Z",
         "ventricle: height at which it is cut, above its centre (5)"},
        {"--rows", SS_ARG_INTEGER, &q->rows, 2, 1000, "N",
         "cylinder: rings (15); plane: points along y (21)"},
        {"--columns", SS_ARG_INTEGER, &q->columns, 2, 1000, "N",
         "cylinder: points of a ring (24); plane: points along x (21)"},
        {"--radius-m", SS_ARG_NUMBER, &q->radius_m, 1e-6, 1e3, "R", "cylinder (1)"},
        {"--length-m", SS_ARG_NUMBER, &q->length_m, 1e-6, 1e3, "L", "cylinder (4)"},
        {"--width-m", SS_ARG_NUMBER, &q->width_m, 1e-6, 1e3, "W", "plane: along x (0.1)"},
        {"--height-m", SS_ARG_NUMBER, &q->height_m, 1e-6, 1e3, "H", "plane: along y (0.1)"},
        SS_FLAG("--grid", &q->keeps_quads, "cylinder, plane: as quads, not as triangles"),
        SS_CHOICE("--units", &q->units, UNITS, "of the file (mm; cylinder, plane: m)"),
        SS_TEXT("--out", &q->out, "FILE",
                ".obj, .stl, .msh or .vtk (SHAPE.obj; with tetrahedra SHAPE.msh); .obj and .stl "
                "have no groups"),
    };
    char about[1024];
    describe(about, sizeof about);
    const ss_args_result result =
        ss_args_parse(argc, argv, SHAPES " [options]", about, rows,
                      (int32_t)(sizeof rows / sizeof rows[0]), &shape, 1, 1, &count, error);
    if (result == SS_ARGS_DONE || count < 1) {
        return result;
    }
    while (q->shape < SHAPE_COUNT && strcmp(shape, shapes[q->shape].name) != 0) {
        ++q->shape;
    }
    if (q->shape == SHAPE_COUNT) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "'%s' is not one of " SHAPES, shape);
    } else {
        complete(q, size, inner, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

int command_generate(int argc, char **argv)
{
    request q;
    softsim_error error = {0};
    const ss_args_result result = parse(argc, argv, &q, &error);
    if (result == SS_ARGS_DONE) {
        return 0;
    }
    char standard[64];
    (void)snprintf(standard, sizeof standard, "%s.%s",
                   result == SS_ARGS_RUN ? shapes[q.shape].name : "",
                   q.has_tetrahedra ? "msh" : "obj");
    const char *path = q.out != NULL ? q.out : standard;
    if (result == SS_ARGS_RUN && can_write_mesh(path, "--out", q.has_tetrahedra, &error)) {
        ss_mesh *mesh = NULL;
        const bool is_grid =
            q.shape == SHAPE_PLANE || (q.shape == SHAPE_CYLINDER && !q.has_tetrahedra);
        softsim_status status =
            is_grid ? make_grid(&q, &mesh, &error) : make_body(&q, &mesh, &error);
        if (status == SOFTSIM_OK && ss_mesh_accept(mesh, path, NULL) != SOFTSIM_OK) {
            status = SOFTSIM_ERROR_MESH;
            softsim_error_add(&error, status, "%s: too few points for this shape: give more", path);
        }
        if (status == SOFTSIM_OK) {
            ss_mesh_transform(mesh, 1.0 / metres_per_unit(q.units), (double[3]){0.0, 0.0, 0.0},
                              (double[3]){0.0, 0.0, 0.0});
            status = write_mesh(mesh, path, &error);
        }
        if (status == SOFTSIM_OK) {
            print_written(mesh, path, unit_name(q.units));
        }
        ss_mesh_destroy(&mesh);
        return ss_args_finish("softsim-mesh", status, &error);
    }
    return ss_args_finish("softsim-mesh", SOFTSIM_ERROR_ARGUMENT, &error);
}
