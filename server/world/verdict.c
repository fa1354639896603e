/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/world.h"
/* What the world adds to a model's own verdict. */
#include <math.h>

#include "rt/vec.h"

static const double SINK_SHARE = 0.3;    /* of a tool's least half-width */
static const double THROUGH_SHARE = 0.9; /* of the same: the far side's samples turn the force */

void ss_world_plan_watch(ss_world *world)
{
    const ss_scene *scene = world->scene;
    double size = 0.0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (scene->tool[p].is_used) {
            size = fmax(size, ss_shape_bounding_radius(&scene->tool[p].shape));
        }
    }
    if (size > 0.0) {
        world->energy = (ss_energy_watch){.limit = scene->max_force_n, .size = size};
    }
}

void ss_world_judge_sinking(const ss_world *world, ss_model_info *info)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const ss_world_probe *probe = &world->probe[p];
        const ss_contact_set *set = &probe->computed.set;
        const double depth = probe->is_used ? set->depth : 0.0;
        const double size = ss_shape_inradius(&world->scene->tool[p].shape);
        if (info->verdict < SOFTSIM_VERDICT_FAULT && probe->steps_unplaced > 0 &&
            probe->next_search > 0) {
            info->verdict = SOFTSIM_VERDICT_DEGRADED;
            info->reason = "a tool is inside the tissue, no free place was found for it, and its "
                           "force is zero: take it out";
        } else if (probe->is_used && ss_contact_is_inside(set) &&
                   info->verdict < SOFTSIM_VERDICT_FAULT) {
            info->verdict = SOFTSIM_VERDICT_DEGRADED;
            info->reason =
                "a tool is inside the tissue, through the surface that held it off: take "
                "it out; then press slower, refine the mesh there, lower "
                "haptic.max_force_n, or raise simulation.rate_hz";
        } else if (depth > THROUGH_SHARE * size && info->verdict < SOFTSIM_VERDICT_DEGRADED) {
            info->verdict = SOFTSIM_VERDICT_DEGRADED;
            info->reason =
                "a tool has almost broken through the tissue's surface: refine the mesh there, use "
                "a larger tool, or press less";
        } else if (depth > SINK_SHARE * size && info->verdict == SOFTSIM_VERDICT_GOOD) {
            info->verdict = SOFTSIM_VERDICT_GUARDED;
            info->reason =
                "a tool sinks into the tissue: refine the mesh there, use a larger tool, "
                "raise contact.working_force_n, or lower the model's stiffness";
        }
    }
}

void ss_world_info(const ss_world *world, ss_model_info *out_info)
{
    const ss_mesh *mesh = world->scene->mesh;
    world->model_class->info(world->model, out_info);
    if (world->sleep && ss_sleep_is_asleep(world->sleep)) {
        out_info->active_nodes = out_info->substeps = 0;
    }
    /* The limiting tetrahedron, or node of a model that has nodes only: in the file's numbers. */
    if (out_info->worst_element >= 0) {
        out_info->worst_element = world->model_class->needs_volume
                                      ? ss_mesh_file_element(mesh, out_info->worst_element)
                                      : ss_mesh_file_node(mesh, out_info->worst_element);
    }
    ss_energy_watch_judge(&world->energy, out_info);
    ss_world_judge_sinking(world, out_info);
}
