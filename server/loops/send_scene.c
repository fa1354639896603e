/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/state.h"
/*
 * What the server says of its scene, every two seconds, on refresh and on set: the tools, and what
 * the command `set` reaches. Built anew each time, since a value may have been set since.
 */
#include <stdio.h>
#include <string.h>

#include "world/field.h"

enum { PARAMETER_SIZE = 256, MAX_HULL = 1000 /* vertices of all tools together */ };

static void describe_tool(const ss_shape *shape, softsim_scene_report *scene, int32_t probe)
{
    static const softsim_tool_form form_of[] = {
        [SS_SHAPE_SPHERE] = SOFTSIM_TOOL_SPHERE, [SS_SHAPE_CAPSULE] = SOFTSIM_TOOL_CAPSULE,
        [SS_SHAPE_BOX] = SOFTSIM_TOOL_BOX,       [SS_SHAPE_CYLINDER] = SOFTSIM_TOOL_CYLINDER,
        [SS_SHAPE_CONE] = SOFTSIM_TOOL_CONE,     [SS_SHAPE_CONVEX] = SOFTSIM_TOOL_CONVEX};
    scene->form[probe] = form_of[shape->kind];
    double *size = scene->size[probe];
    if (shape->kind == SS_SHAPE_BOX) {
        for (int d = 0; d < 3; ++d) {
            size[d] = 2.0 * shape->half_extent[d];
        }
    } else if (shape->kind != SS_SHAPE_CONVEX) {
        size[0] = shape->radius;
        size[1] = 2.0 * shape->half_length;
    }
}

void ss_loops_send_scene(ss_loops *loops)
{
    const ss_scene *given = loops->world->scene;
    char parameter[SOFTSIM_MAX_LIVE][PARAMETER_SIZE];
    float hull[MAX_HULL][3];
    const char *slash = strrchr(given->path, '/');
    softsim_scene_report scene = {
        .topology = loops->publisher != NULL ? ss_publisher_topology(loops->publisher) : 0,
        .hull = hull[0],
        .name = slash != NULL ? slash + 1 : given->path,
        .model = loops->world->model_class->name,
        .field = ss_field_name(
            (ss_scene_field)atomic_load_explicit(&loops->world->field, memory_order_acquire))};
    int32_t vertices = 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (given->tool[p].is_used) {
            describe_tool(&given->tool[p].shape, &scene, p);
            scene.hull_count[p] =
                ss_shape_hull(&given->tool[p].shape, MAX_HULL - vertices, hull + vertices);
            vertices += scene.hull_count[p];
        }
    }
    while (scene.parameter_count < SOFTSIM_MAX_LIVE &&
           ss_world_describe_live(loops->world, scene.parameter_count,
                                  parameter[scene.parameter_count], PARAMETER_SIZE)) {
        scene.parameter[scene.parameter_count] = parameter[scene.parameter_count];
        ++scene.parameter_count;
    }
    ss_net_send_scene(loops->net, &scene);
}
