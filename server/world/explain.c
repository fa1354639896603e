/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The plan of a world in words, for --explain: one line per fact. */
#include <math.h>

#include "rt/memory.h"
#include "rt/printer.h"
#include "world/world.h"

/* What of the estimated cost of a step is there because of the tools. */
static double contact_cost_us(const ss_world *world)
{
    ss_model_plan plan = ss_world_plan(world);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        plan.tool[p].is_used = false;
    }
    return fmax(world->step_cost_us - world->model_class->step_cost_us(&plan), 0.0);
}

void ss_world_explain(const ss_world *world, void (*line)(void *sink, const char *text), void *sink)
{
    static const char *const shapes[] = {"sphere", "capsule", "box", "cylinder", "cone", "convex"};
    const ss_printer out = {line, sink};
    const ss_scene *scene = world->scene;
    bool needs_convex = false;
    ss_say(&out, "scene: %s", scene->path);
    ss_say(&out, "mesh: %d nodes, %d surface triangles, %d tetrahedra%s", scene->mesh->node_count,
           scene->mesh->triangle_count, scene->mesh->tetrahedron_count,
           scene->mesh->is_closed ? ", closed" : ", open");
    if (scene->mesh->quad_count > 0) {
        ss_say(&out, "grid: %d quads, whose halves are the triangles", scene->mesh->quad_count);
    }
    if (scene->mesh->cut_face_count > 0) {
        ss_say(&out,
               "mesh: %d faces of more than three corners were cut into triangles, since not all "
               "faces are quads",
               scene->mesh->cut_face_count);
    }
    ss_say(&out, "numbers: %s",
           scene->mesh->file_node ? "by place in memory, the file's in all that is read or written"
                                  : "the file's, whose neighbours are near in memory");
    ss_say(&out, "model: %s", world->model_class->name);
    world->model_class->explain(world->model, line, sink);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (scene->tool[p].is_used) {
            const ss_shape *shape = &scene->tool[p].shape;
            ss_say(&out, "probe %d: %s, bounding radius %.4g mm", p, shapes[shape->kind],
                   1e3 * ss_shape_bounding_radius(shape));
            needs_convex |= shape->kind == SS_SHAPE_CONVEX;
        }
    }
    ss_say(&out, "simulation: every %d haptic period%s, %.6g Hz (%s; estimated %.3g us a step)",
           world->step_ticks, world->step_ticks == 1 ? "" : "s", 1.0 / world->step_period,
           scene->simulation_rate_hz > 0.0 ? "as given" : "chosen from counted work",
           world->step_cost_us);
    if (world->used_probes) {
        ss_say(&out,
               "cost of contact: %.3g us of that estimate; a tool on a mesh that is fine for its "
               "size takes more, which step_us of a run shows",
               contact_cost_us(world));
    }
    ss_say(&out, "haptic: %.6g Hz, at most %.4g N, felt stiffness at most %.4g N/m",
           1.0 / world->period, scene->max_force_n, scene->coupling_stiffness_n_per_m);
    ss_say(&out, "threads: net%s%s", world->used_probes ? ", simulation, haptic" : ", simulation",
           world->surface ? ", publish" : "");
    if (!world->used_probes) {
        ss_say(&out, "left out: haptic thread, contact surface (no tools)");
    }
    if (!world->surface) {
        ss_say(&out, "left out: mesh publisher, its thread and its snapshots (mesh_rate_hz 0)");
    } else {
        ss_say(&out, "publish: %.4g Hz, at most %.4g bytes/s", scene->mesh_rate_hz,
               scene->max_bytes_per_s);
    }
    if (!needs_convex) {
        ss_say(&out, "left out: convex narrow phase (no convex-mesh tool)");
    }
    if (scene->load_count == 0 && scene->prescribed_count == 0) {
        ss_say(&out, "left out: loads and prescribed displacements (none)");
    } else {
        ss_say(&out, "loads: %d, prescribed sets: %d", scene->load_count, scene->prescribed_count);
    }
    ss_say(&out, "memory: %lld bytes", (long long)ss_memory_in_use());
}
