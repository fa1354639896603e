/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the tests of scenes share: two small models, a cube of eight nodes, a folder with data
 * files, a small scene of which single lines are replaced.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "common/number_fixture.h"
#include "jelly.h"
#include "scene/scene.h"

/* ---- a model, a mesh, a folder ---- */

static const ss_param_row block_row[] = {
    SS_PARAM(NUMBER, "density_kg_m3", "mass", SS_ABOVE(0, 1e5), .fallback = 1000),
};
static const ss_scene_model model[] = {
    {.name = "jelly", .row = jelly_row, .row_count = sizeof jelly_row / sizeof *jelly_row},
    {.name = "block", .row = block_row, .row_count = 1, .needs_volume = true},
    {.name = "bubble", .row = block_row, .row_count = 1, .takes_second_order = true},
};
enum { MODEL_COUNT = sizeof model / sizeof *model };

/* A cube of edge `edge` with its corner at the origin; node k has the bits of k as x y z. The
 * group `top` holds nodes 4..7. */
static void print_cube(FILE *stream, double edge)
{
    static const int triangle[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                        {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                        {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    fprintf(stream, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
                    "$PhysicalNames\n2\n2 1 \"top\"\n2 2 \"rest\"\n$EndPhysicalNames\n"
                    "$Nodes\n8\n");
    for (int k = 0; k < 8; k++) {
        fprintf(stream, "%d %.17g %.17g %.17g\n", k + 1, edge * (k & 1), edge * (k >> 1 & 1),
                edge * (k >> 2 & 1));
    }
    fprintf(stream, "$EndNodes\n$Elements\n12\n");
    for (int t = 0; t < 12; t++) {
        const int group = t == 2 || t == 3 ? 1 : 2;
        fprintf(stream, "%d 2 2 %d 1 %d %d %d\n", t + 1, group, triangle[t][0] + 1,
                triangle[t][1] + 1, triangle[t][2] + 1);
    }
    fprintf(stream, "$EndElements\n");
}

/* The folder, with all that scenes here name. */
static int make_files(void **state)
{
    if (make_folder(state) != 0) {
        return -1;
    }
    FILE *stream = open_file("cube.msh"); /* 20 mm, in mm */
    print_cube(stream, 20);
    fclose(stream);
    stream = open_file("cube_m.msh"); /* the same, in m */
    print_cube(stream, 0.02);
    fclose(stream);
    write_text("ten.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 20 0 0\n"
                          "3 0 20 0\n4 0 0 20\n5 10 0 0\n6 10 10 0\n7 0 10 0\n8 0 0 10\n9 0 10 10\n"
                          "10 10 0 10\n$EndNodes\n$Elements\n1\n1 11 0 1 2 3 4 5 6 7 8 9 10\n"
                          "$EndElements\n");
    write_text("seven.txt", "# the far corner\n7\n");
    write_text("none.txt", "# nothing\n");
    write_text("bad_nodes.txt", "1\ntwo\n8\n1\n");
    write_text("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    write_text("rho.csv", "node,value\n0,1\n1,2\n2,3\n3,4\r\n4,5\n5,6\n6,7\n7,8\n");
    write_text("short.csv", "node,value\n0,1\n1,2\n");
    write_text("header.csv", "element,value\n0,1\n");
    write_text("range.csv", "node,value\n0,1\n1,11\n2,nan\n");
    write_text("lift.csv", "node,ux,uy,uz\n4,0,0,0.001\n5,0,0,0.002\n6,,,0.003\n");
    write_text("points.csv",
               "x,y,z\n0,0,0\n10, 0, 0\n0,20,0\n# the last row\n10,20,0\n0,40,0\n10,40,0\n");
    write_text("points_bad.csv", "x,y,z\n0,0,0\n10,0\n0,nan,0\n0,0,0,0\n");
    write_text("grain_short.csv", "element,x,y,z\n0,1,0,0\n11,0,0,1\n");
    write_text("grain_bad.csv", "element,x,y,z\n0,0,-0,0\n12,1,0,0\n1,1,inf,0\n");
    write_text("grain_twice.csv", "element,x,y,z\n1.5,1,0,0\n2,1,0\n3,1,0,0\n3,1,0,0\n");
    write_text("lift_bad.csv", "node,ux,uy,uz\n4,0,0\n5,x,0,1\n");
    return 0;
}

static softsim_error error; /* of the last load */

/* Loads `text` as if it stood in the folder as s.yaml. */
static ss_scene *load_with(const char *text, const char *const *overrides, int count)
{
    ss_scene *scene = NULL;
    error = (softsim_error){0};
    const softsim_status status =
        ss_scene_load_text(in_folder("s.yaml"), text, strlen(text), overrides, count, model,
                           MODEL_COUNT, NULL, &scene, &error);
    assert_int_equal(status == SOFTSIM_OK, scene != NULL);
    assert_int_equal(status == SOFTSIM_OK, error.fault_count == 0);
    assert_int_equal(status, error.status);
    return scene;
}

static const char small[] = "softsim: 1\n"                                             /* 1 */
                            "object:\n"                                                /* 2 */
                            "  mesh: cube.msh\n"                                       /* 3 */
                            "  units: mm\n"                                            /* 4 */
                            "  fixed: [{box_m: [[-1, -1, -1], [1, 1, 0]]}]\n"          /* 5 */
                            "model:\n"                                                 /* 6 */
                            "  name: jelly\n"                                          /* 7 */
                            "  modulus_j: 5\n"                                         /* 8 */
                            "contact:\n"                                               /* 9 */
                            "  tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]\n" /* 10 */
                            "haptic:\n"                                                /* 11 */
                            "  max_force_n: 3\n"                                       /* 12 */
                            "loads:\n"                                                 /* 13 */
                            "  - {nodes: [7], force_n: [0, 0, 1]}\n";                  /* 14 */

/* `small` with line `line` (from 1) replaced. Static memory. */
static const char *replace_line(int line, const char *with)
{
    static char text[4096];
    size_t used = 0;
    const char *at = small;
    for (int i = 1; *at != '\0'; i++) {
        const char *end = strchr(at, '\n') + 1;
        used += (size_t)snprintf(text + used, sizeof text - used, "%.*s%s",
                                 i == line ? (int)strlen(with) : (int)(end - at),
                                 i == line ? with : at, i == line ? "\n" : "");
        at = end;
    }
    return text;
}

static inline ss_scene *load_good(const char *text, const char *const *overrides, int count)
{
    ss_scene *scene = load_with(text, overrides, count);
    if (scene == NULL) {
        fail_msg("refused:\n%s\n%s", text, error.text);
    }
    return scene;
}

static const char full[] =
    "softsim: 1\n"
    "object:\n"
    "  mesh: cube.msh\n"
    "  units: mm\n"
    "  transform: {scale: 2, rotate_deg: [0, 0, 90], translate_m: [0.1, 0, 0]}\n"
    "  fixed:\n"
    "    - {box_m: [[-1, -1, -1], [1, 1, 0]]}\n"
    "    - {nodes: seven.txt, axes: xz}\n"
    "model:\n"
    "  name: jelly\n"
    "  modulus_j: 5\n"
    "  rho: [{where: {group: top}, value: 2}, {value: 0.5}]\n"
    "  per_area: false\n"
    "  solver: relaxation\n"
    "contact:\n"
    "  tools:\n"
    "    - {probe: 0, shape: {sphere: {radius_mm: 5}}}\n"
    "    - {probe: 3, shape: {capsule: {radius_mm: 2, length_mm: 30}}}\n"
    "    - {probe: 4, shape: {box: {size_mm: [2, 4, 6]}}}\n"
    "    - {probe: 5, shape: {cylinder: {radius_mm: 3, length_mm: 8}}}\n"
    "    - {probe: 6, shape: {cone: {radius_mm: 4, length_mm: 10}}}\n"
    "  working_force_n: 1.5\n"
    "  grasp_max_force_n: 2.5\n"
    "simulation: {rate_hz: 250, max_substeps: 16}\n"
    "gravity_m_s2: [0, 0, -9.81]\n"
    "haptic: {between_steps: hold, rate_hz: 2000, max_force_n: 4, max_slew_n_per_s: 900,\n"
    "  max_jump_m: 0.1, coupling: {stiffness_n_per_m: 500, damping_n_s_per_m: 1}}\n"
    "publish: {mesh_rate_hz: 0, max_bytes_per_s: 1e6}\n"
    "loads:\n"
    "  - {nodes: [4, 5], force_n: [0.1, -0.8, 0.05], from_s: 1, to_s: 10, ramp_s: 2}\n"
    "  - {group: top, pressure_pa: 1000}\n"
    "prescribed:\n"
    "  - {nodes: [5], displacement_m: [0, 0, 0.001], ramp_s: 0.5, axes: z}\n";

#define GRID(grid) "softsim: 1\nobject:\n" grid "model: {name: jelly, modulus_j: 1}\n"

/* Writes a direction for each of `count` elements, the last first. */
static inline void write_directions(const char *name, int count)
{
    FILE *stream = open_file(name);
    fprintf(stream, "element,x,y,z\n");
    for (int e = count - 1; e >= 0; e--) {
        fprintf(stream, "%d,%d,0,2\n", e, e);
    }
    fclose(stream);
}
