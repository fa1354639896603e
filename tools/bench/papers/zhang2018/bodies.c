/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/core/child.h"
#include "bench/core/surface_picture.h"
#include "bench/papers/zhang2018/zhang2018.h"
#include "process.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

enum { LIVER_POINTS = 5762, LIVER_PATCH = 15 };
static const double mesh_timeout_s = 120.0;

/* ---- the plane ---- */

softsim_status ss_zhang_plane_init(ss_zhang_plane *plane, softsim_error *error)
{
    const double size = SS_PLANE_SIDE - 1;
    for (int32_t i = 0; i < SS_PLANE_NODES; ++i) {
        const int32_t row = i / SS_PLANE_SIDE, column = i % SS_PLANE_SIDE;
        const bool is_rim = row % (SS_PLANE_SIDE - 1) == 0 || column % (SS_PLANE_SIDE - 1) == 0;
        plane->fixed[i] = is_rim ? 7 : 0;
    }
    plane->pushed[0] = SS_PLANE_MIDDLE;
    return ss_mesh_create_plane(SS_PLANE_SIDE, SS_PLANE_SIDE, size, size, &plane->mesh, error);
}

void ss_zhang_plane_fini(ss_zhang_plane *plane)
{
    ss_mesh_destroy(&plane->mesh);
}

ss_zhang_setup ss_zhang_plane_setup(ss_zhang_plane *plane, const char *model, double depth,
                                    double step_s)
{
    return (ss_zhang_setup){.model = model,
                            .mesh = plane->mesh,
                            .fixed = plane->fixed,
                            .pushed = plane->pushed,
                            .pushed_count = 1,
                            .direction = {0.0, 0.0, -1.0},
                            .depth = depth,
                            .step_s = step_s};
}

softsim_status ss_zhang_plane_reference(const ss_zhang_plane *plane, ss_zhang_rule rule,
                                        const double *stiffness_of, ss_zhang_reference *out,
                                        softsim_error *error)
{
    ss_zhang_reference_plan plan =
        ss_zhang_reference_on(plane->mesh, plane->fixed, plane->pushed, 1);
    ss_set3(plan.direction, 0.0, 0.0, -1.0);
    plan.alpha = 0.02;
    plan.stiffness = plan.capacitance = 1.0;
    plan.stiffness_of = stiffness_of;
    plan.rule = rule;
    return ss_zhang_reference_init(out, &plan) ? SOFTSIM_OK : ss_memory_fault(error);
}

/* ---- solids ---- */

static softsim_status generate(const ss_paper *paper, const char *shape, int32_t points,
                               const char *mesh, softsim_error *error)
{
    char program[sizeof paper->bin + 16], count[16];
    snprintf(program, sizeof program, "%s/softsim-mesh", paper->bin);
    snprintf(count, sizeof count, "%d", points);
    const char *const argv[] = {program, "generate", shape, "--tetrahedra", "--points", count,
                                "--out", mesh,       NULL};
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv};
    if (ss_child_run(&plan, mesh_timeout_s) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                          "softsim-mesh generate %s --tetrahedra --points %d: %s", shape, points,
                          ss_process_is_stopped() ? "stopped" : "it failed");
        return SOFTSIM_ERROR_SYSTEM;
    }
    return SOFTSIM_OK;
}

/* Mean over tetrahedra of their six edges: edges inside count as often as elements have them. */
static double mean_edge(const ss_mesh *mesh)
{
    double sum = 0.0;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        for (int a = 0; a < 3; ++a) {
            for (int b = a + 1; b < 4; ++b) {
                double way[3];
                ss_sub3(way, mesh->position[mesh->tetrahedron[t][b]],
                        mesh->position[mesh->tetrahedron[t][a]]);
                sum += ss_norm3(way);
            }
        }
    }
    return sum / (6.0 * mesh->tetrahedron_count);
}

softsim_status ss_zhang_solid_make(const ss_paper *paper, const char *shape, int32_t points,
                                   ss_zhang_solid *out, softsim_error *error)
{
    char path[sizeof paper->temporary + 64];
    *out = (ss_zhang_solid){.mesh = NULL};
    snprintf(path, sizeof path, "%s/%s-%d.msh", paper->temporary, shape, points);
    /* Made once: other sections ask for the same body. */
    softsim_status status =
        access(path, R_OK) == 0 ? SOFTSIM_OK : generate(paper, shape, points, path, error);
    if (status == SOFTSIM_OK) {
        status = ss_mesh_load(path, 1e-3, NULL, &out->mesh, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    const size_t n = (size_t)out->mesh->node_count;
    out->fixed = calloc(n, sizeof *out->fixed);
    out->volume = calloc(n, sizeof *out->volume);
    if (!ss_mesh_renumber(out->mesh) || out->fixed == NULL || out->volume == NULL) {
        ss_zhang_solid_fini(out);
        return ss_memory_fault(error);
    }
    ss_zhang_volumes(out->mesh, out->volume);
    out->mean_length = mean_edge(out->mesh);
    return SOFTSIM_OK;
}

void ss_zhang_solid_fini(ss_zhang_solid *solid)
{
    ss_mesh_destroy(&solid->mesh);
    SS_EACH(free, solid->fixed, solid->volume, solid->pushed);
    *solid = (ss_zhang_solid){.mesh = NULL};
}

/* The free surface node that is nearest to the ray's line among those in its direction. */
static int32_t find_top(const ss_zhang_solid *solid, const double *area, const double from[3],
                        const double along[3])
{
    int32_t top = -1;
    double least = (double)INFINITY;
    for (int32_t i = 0; i < solid->mesh->node_count; ++i) {
        double way[3];
        ss_sub3(way, solid->mesh->position[i], from);
        const double ahead = ss_dot3(way, along);
        ss_madd3(way, way, -ahead, along);
        const double aside = ss_norm3(way);
        if (area[i] > 0.0 && solid->fixed[i] == 0 && ahead > 0.0 && aside < least) {
            least = aside;
            top = i;
        }
    }
    return top;
}

softsim_status ss_zhang_solid_patch(ss_zhang_solid *solid, const double from[3],
                                    const double towards[3], int32_t count, softsim_error *error)
{
    const ss_mesh *mesh = solid->mesh;
    ss_keyed *order = calloc((size_t)mesh->node_count, sizeof *order);
    double *area = calloc((size_t)mesh->node_count, sizeof *area);
    free(solid->pushed);
    solid->pushed_count = 0;
    solid->pushed = calloc((size_t)count, sizeof *solid->pushed);
    ss_scale3(solid->direction, towards, -1.0 / ss_norm3(towards));
    if (order != NULL && area != NULL && solid->pushed != NULL) {
        double along[3];
        int32_t free_count = 0;
        ss_mesh_node_areas(mesh, area);
        ss_scale3(along, solid->direction, -1.0);
        const int32_t top = find_top(solid, area, from, along);
        for (int32_t i = 0; i < mesh->node_count && top >= 0; ++i) {
            if (area[i] > 0.0 && solid->fixed[i] == 0) {
                double way[3];
                ss_sub3(way, mesh->position[i], mesh->position[top]);
                order[free_count++] = (ss_keyed){.key = ss_norm3(way), .index = i};
            }
        }
        qsort(order, (size_t)free_count, sizeof *order, ss_compare_keyed);
        solid->pushed_count = count < free_count ? count : free_count;
        for (int32_t k = 0; k < solid->pushed_count; ++k) {
            solid->pushed[k] = order[k].index;
        }
    }
    free(order);
    free(area);
    return solid->pushed_count > 0 ? SOFTSIM_OK : ss_memory_fault(error);
}

softsim_status ss_zhang_liver_make(const ss_paper *paper, ss_zhang_solid *out, softsim_error *error)
{
    const double up[3] = {0.0, 0.0, 1.0}, under_lobe[3] = {0.05, -0.02, 0.0};
    softsim_status status = ss_zhang_solid_make(paper, "liver", LIVER_POINTS, out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t g = 0; g < out->mesh->group_count; ++g) {
        const ss_mesh_group *group = &out->mesh->group[g];
        for (int32_t k = 0; strcmp(group->name, "fixed") == 0 && k < group->node_count; ++k) {
            out->fixed[group->node[k]] = 7;
        }
    }
    status = ss_zhang_solid_patch(out, under_lobe, up, LIVER_PATCH, error);
    if (status != SOFTSIM_OK) {
        ss_zhang_solid_fini(out);
    }
    return status;
}

softsim_status ss_zhang_solid_reference(const ss_zhang_solid *solid, double alpha,
                                        ss_zhang_rule rule, ss_zhang_reference *out,
                                        softsim_error *error)
{
    ss_zhang_reference_plan plan =
        ss_zhang_reference_on(solid->mesh, solid->fixed, solid->pushed, solid->pushed_count);
    plan.alpha = alpha;
    plan.stiffness = 100.0;
    plan.capacitance = 1.0;
    plan.rule = rule;
    ss_copy3(plan.direction, solid->direction);
    return ss_zhang_reference_init(out, &plan) ? SOFTSIM_OK : ss_memory_fault(error);
}

ss_zhang_setup ss_zhang_solid_setup(const ss_zhang_solid *solid, const char *model, double depth)
{
    ss_zhang_setup setup = {.model = model,
                            .mesh = solid->mesh,
                            .fixed = solid->fixed,
                            .pushed = solid->pushed,
                            .pushed_count = solid->pushed_count,
                            .depth = depth};
    ss_copy3(setup.direction, solid->direction);
    return setup;
}

softsim_status ss_zhang_solid_draw(ss_paper *paper, const ss_zhang_solid *solid,
                                   const double (*u)[3], const char *name, const char *caption,
                                   softsim_error *error)
{
    static const ss_surface_picture_view views[2] = {
        {{-0.3, -1.0, 0.35}, {0.0, 0.0, 1.0}, "from the front"},
        {{0.9, -0.4, 0.6}, {0.0, 0.0, 1.0}, "from the right"}};
    const ss_mesh *mesh = solid->mesh;
    int32_t(*face)[4] = ss_surface_faces(mesh->triangle_count, (const int32_t(*)[3])mesh->triangle);
    if (face == NULL) {
        return ss_memory_fault(error);
    }
    ss_surface_picture shape = {.node_count = mesh->node_count,
                                .face_count = mesh->triangle_count,
                                .rest = (const double(*)[3])mesh->position,
                                .u = u,
                                .face = (const int32_t(*)[4])face,
                                .pushed = solid->pushed[0]};
    ss_copy3(shape.push, solid->direction);
    const softsim_status status =
        ss_surface_picture_draw(paper, name, caption, &shape, views, 2, error);
    free(face);
    return status;
}
