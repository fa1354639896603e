/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>

#include "rt/vec.h"
#include "world/world.h"

/* the most that simulation.max_substeps takes; beyond, a verdict */
enum { UNTIMED_SUBSTEPS = 100000 };
static const double FULL_STEP_S = 0.004; /* of simulation.max_substeps */

/* Sub-steps that simulation.max_substeps allows a step: it is named for one of up to 4 ms, and a
 * longer one has as much more time. */
static int32_t substep_budget(const ss_world *world)
{
    const double share = fmax(1.0, world->step_period / FULL_STEP_S);
    return (int32_t)fmin(share * world->scene->max_substeps, UNTIMED_SUBSTEPS);
}

ss_model_plan ss_world_plan(const ss_world *world)
{
    const ss_scene *scene = world->scene;
    const int32_t budget = substep_budget(world);
    ss_model_plan plan = {.mesh = scene->mesh,
                          .surface = scene->surface,
                          .fixed = scene->fixed,
                          .param = scene->param,
                          .load = scene->load,
                          .load_count = scene->load_count,
                          .prescribed = world->prescribed,
                          .prescribed_count = scene->prescribed_count,
                          .working_force = scene->working_force_n,
                          .contact_stiffness = scene->contact_stiffness_n_per_m3,
                          .friction = scene->friction.number,
                          .friction_by_node = scene->friction.per_node,
                          .grasp_max_force = scene->grasp_max_force_n,
                          .max_force = scene->max_force_n,
                          .step = world->step_period,
                          .yardstick = world->planned_yardstick,
                          .max_substeps = world->has_budget ? budget : UNTIMED_SUBSTEPS,
                          .substep_budget = budget,
                          .threads = world->threads};
    ss_copy3(plan.gravity, scene->gravity);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        plan.tool[p].is_used = scene->tool[p].is_used;
        plan.tool[p].shape = scene->tool[p].shape;
    }
    return plan;
}
