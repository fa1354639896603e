/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "softsim/softsim.h"
/* The public headless API: a softsim_world is an ss_world that moves in lockstep. */
#include <string.h>

#include "rt/thread.h"
#include "rt/vec.h"
#include "world/world.h"

enum { CONFIG_COOKIE = 0x50f751 };

softsim_config softsim_default_config(void)
{
    return (softsim_config){.cookie = CONFIG_COOKIE, .threads = 1};
}

ss_world *ss_world_of(softsim_world *world)
{
    return (ss_world *)world;
}

softsim_world *softsim_create(const char *scene_path, const softsim_config *config,
                              softsim_error *error)
{
    if (!config || config->cookie != CONFIG_COOKIE) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "the configuration was not made by softsim_default_config()");
        return NULL;
    }
    const ss_world_options options = {.scene_path = scene_path,
                                      .set = config->set,
                                      .set_count = config->set_count,
                                      .threads = config->threads,
                                      .step_s = config->step_s,
                                      .has_budget = config->has_budget,
                                      .is_lockstep = true,
                                      .import_program = config->import_program};
    ss_world *world = NULL;
    const uint64_t denormals = ss_thread_flush_denormals();
    ss_world_create(&options, &world, error);
    ss_thread_restore_denormals(denormals);
    return (softsim_world *)world;
}

void softsim_destroy(softsim_world **world)
{
    ss_world *inner = ss_world_of(*world);
    if (!inner) {
        return;
    }
    ss_lockstep_stop(inner);
    ss_world_destroy(&inner);
    *world = NULL;
}

softsim_refusal softsim_tick(softsim_world *world, const softsim_pose *pose, const int32_t *channel,
                             int32_t count, softsim_force out_force[SOFTSIM_MAX_PROBES])
{
    const uint64_t denormals = ss_thread_flush_denormals();
    /* As in the daemon, a pose is normalised once, where it comes in. */
    softsim_pose normal[SOFTSIM_MAX_PROBES];
    count = count < SOFTSIM_MAX_PROBES ? count : SOFTSIM_MAX_PROBES;
    for (int32_t i = 0; i < count; ++i) {
        normal[i] = pose[i];
        ss_gate_normalize(&normal[i]);
    }
    const softsim_refusal refusal =
        ss_world_lockstep(ss_world_of(world), normal, channel, count, out_force);
    ss_thread_restore_denormals(denormals);
    return refusal;
}

void softsim_read(softsim_world *public_world, softsim_state *out_state)
{
    const uint64_t denormals = ss_thread_flush_denormals();
    ss_world *world = ss_world_of(public_world);
    ss_world_settle(world);
    ss_model_info info;
    ss_gate_counts counts;
    ss_world_info(world, &info);
    ss_gate_read(world->gate, &counts);
    *out_state = (softsim_state){.tick = world->tick,
                                 .step = world->steps,
                                 .time_s = (double)world->tick * world->period,
                                 .period_s = world->period,
                                 .simulation_period_s = world->step_period,
                                 .substeps = info.substeps,
                                 .all_substeps = world->substeps,
                                 .node_count = world->scene->mesh->node_count,
                                 .active_nodes = info.active_nodes,
                                 .probes = world->used_probes,
                                 .verdict = info.verdict,
                                 .reason = info.reason,
                                 .worst_verdict = world->worst_verdict,
                                 .worst_reason = world->worst_reason ? world->worst_reason : "",
                                 .stable_step_s = info.stable_step,
                                 .kinetic_j = info.kinetic,
                                 .elastic_j = info.elastic,
                                 .dissipated_j = info.dissipated,
                                 .work_j = info.work,
                                 .poses_received = counts.received};
    if (world->hand.verdict > info.verdict) {
        out_state->verdict = world->hand.verdict;
        out_state->reason = world->hand.reason;
    }
    if (world->worst_hand.verdict > world->worst_verdict) {
        out_state->worst_verdict = world->worst_hand.verdict;
        out_state->worst_reason = world->worst_hand.reason;
    }
    memcpy(out_state->poses_refused, counts.refused, sizeof out_state->poses_refused);
    static const double quantile[3] = {0.5, 0.99, 1.0};
    for (int i = 0; i < 3; ++i) {
        out_state->step_us[i] = ss_histogram_quantile(world->step_time, quantile[i]);
    }
    ss_thread_restore_denormals(denormals);
}

void softsim_read_nodes(softsim_world *public_world, double (*out_position)[3],
                        double (*out_displacement)[3], double (*out_velocity)[3])
{
    ss_world *world = ss_world_of(public_world);
    ss_world_settle(world);
    const ss_mesh *mesh = world->scene->mesh;
    const double(*rest)[3] = world->drawn.rest; /* the model's: a bent side may be straight there */
    const ss_real *u = world->model_class->displacement(world->model);
    const ss_real *v = world->model_class->velocity(world->model);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const int32_t file = ss_mesh_file_node(mesh, i);
        for (int32_t axis = 0; axis < 3; ++axis) {
            if (out_position) {
                out_position[file][axis] = rest[i][axis] + (double)u[4 * i + axis];
            }
            if (out_displacement) {
                out_displacement[file][axis] = (double)u[4 * i + axis];
            }
            if (out_velocity) {
                out_velocity[file][axis] = (double)v[4 * i + axis];
            }
        }
    }
}

int32_t softsim_triangle_count(const softsim_world *world)
{
    return ((const ss_world *)world)->scene->mesh->triangle_count;
}

const int32_t (*softsim_triangles(const softsim_world *world))[3]
{
    const ss_world *inner = (const ss_world *)world;
    return (const int32_t(*)[3])(inner->file_triangle ? inner->file_triangle
                                                      : inner->scene->mesh->triangle);
}

/* The scene's entries: one with a displacement file may be several sets, one per pattern of axes.
 */
int32_t softsim_prescribed_count(const softsim_world *world)
{
    const ss_scene *scene = ((const ss_world *)world)->scene;
    return scene->prescribed_count > 0 ? scene->prescribed[scene->prescribed_count - 1].entry + 1
                                       : 0;
}

const char *softsim_prescribed_name(const softsim_world *world, int32_t entry)
{
    const ss_scene *scene = ((const ss_world *)world)->scene;
    for (int32_t set = 0; set < scene->prescribed_count; ++set) {
        if (scene->prescribed[set].entry == entry) {
            return scene->prescribed[set].name;
        }
    }
    return "fixed";
}

static void read_reaction(ss_world *world, int32_t entry, double out_force[3])
{
    if (entry < 0) {
        world->model_class->reaction(world->model, -1, out_force);
        return;
    }
    ss_set3(out_force, 0.0, 0.0, 0.0);
    for (int32_t set = 0; set < world->scene->prescribed_count; ++set) {
        if (world->scene->prescribed[set].entry == entry) {
            double force[3];
            world->model_class->reaction(world->model, set, force);
            ss_add3(out_force, out_force, force);
        }
    }
}

void softsim_read_reaction(softsim_world *public_world, int32_t entry, double out_force[3])
{
    ss_world *world = ss_world_of(public_world);
    const uint64_t denormals = ss_thread_flush_denormals();
    ss_world_settle(world);
    read_reaction(world, entry, out_force);
    ss_thread_restore_denormals(denormals);
}

uint64_t softsim_hash(softsim_world *world)
{
    const uint64_t denormals = ss_thread_flush_denormals();
    const uint64_t hash = ss_world_hash(ss_world_of(world));
    ss_thread_restore_denormals(denormals);
    return hash;
}
