/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/progress.h"
#include "rt/thread.h"
#include "rt/vec.h"

/*
 * The design comment is in world.h. What is decided here:
 *
 * - The simulation rate. `auto` takes the least m in 1, 2, 4, 5, 8, 10, 16, 20, ... for which the
 *   model's estimated cost of a step (from counts and a built-in cost, never from a clock) is at
 *   most half of m T, so that equal scenes run at equal rates on every machine. A given rate is
 *   rounded to a whole number of ticks, since in lockstep a result is due after exactly m of them.
 * - One lag for all: the proxy is predicted (1 + 1/2) h ahead. A step that is late is a
 *   degraded period, counted, not a longer prediction.
 */

enum {
    POSE_RING = 256,   /* a quarter of a second of poses at 1 kHz */
    FORCE_RING = 8192, /* one second of eight probes */
    COMMAND_RING = 64,
    TICK_POSES = 64,          /* more are left for the next tick */
    UNTIMED_SUBSTEPS = 100000 /* the most that simulation.max_substeps takes; beyond, a verdict */
};
static const double LAG_PERIODS = 1.0;
static const double NEAR_M = 0.005; /* contacts are published before touching from here on */
static const double COST_SHARE = 0.5;
static const double MAX_TOOL_SPEED = 3.0; /* m/s */
static const double MAX_TOOL_TURN = 50.0; /* rad/s */
static const double SLOWEST_STEP = 0.2;   /* s: two of them, and a result is too old to be felt */
static const double PLACE_SHARE = 0.1;    /* of the tool: deeper, and it is let in by fading */
static const double PLACE_STIFFNESS = 100.0; /* N/m: of soft tissue, until the model says */

/* ---- set-up ---- */

int32_t ss_world_scene_models(const ss_scene_model **out_models)
{
    static ss_scene_model models[SS_MAX_MODELS];
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    for (int32_t i = 0; i < count; ++i) {
        models[i] = (ss_scene_model){.name = table[i]->name,
                                     .row = table[i]->row,
                                     .row_count = table[i]->row_count,
                                     .needs_volume = table[i]->needs_volume};
    }
    *out_models = models;
    return count;
}

static int32_t choose_step_ticks(const ss_scene *scene, double period, double cost_us)
{
    static const int32_t steps[] = {1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 100};
    if (scene->simulation_rate_hz > 0.0) {
        const double ticks = round(1.0 / (scene->simulation_rate_hz * period));
        return ticks < 1.0 ? 1 : (int32_t)ticks;
    }
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
        if (cost_us <= COST_SHARE * steps[i] * period * 1e6) {
            return steps[i];
        }
    }
    return steps[sizeof steps / sizeof *steps - 1];
}

static softsim_status plan_loads(ss_world *world)
{
    const ss_scene *scene = world->scene;
    world->load = ss_memory_get((size_t)scene->load_count, sizeof *world->load);
    world->prescribed = ss_memory_get((size_t)scene->prescribed_count, sizeof *world->prescribed);
    if (!world->load || !world->prescribed) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < scene->load_count; ++i) {
        const ss_scene_force *from = &scene->load[i];
        ss_load *to = &world->load[i];
        *to = (ss_load){.node = from->node,
                        .node_count = from->node_count,
                        .pressure = from->pressure,
                        .is_pressure = from->is_pressure,
                        .from = from->from,
                        .to = from->to,
                        .ramp = from->ramp};
        ss_copy3(to->force, from->force);
    }
    for (int32_t i = 0; i < scene->prescribed_count; ++i) {
        const ss_scene_prescribed *from = &scene->prescribed[i];
        ss_prescribed *to = &world->prescribed[i];
        *to = (ss_prescribed){.node = from->node,
                              .node_count = from->node_count,
                              .displacement = from->displacement,
                              .from = from->from,
                              .ramp = from->ramp};
        memcpy(to->axis, from->axis, sizeof to->axis);
    }
    return SOFTSIM_OK;
}

/* A model knows its parameters, not the scene that gave them: its faults, one a line, are passed on
 * with the place. */
static void pass_on(const char *path, const softsim_error *fault, softsim_error *error)
{
    for (const char *at = fault->text; *at != '\0';) {
        const int length = (int)strcspn(at, "\n");
        softsim_error_add(error, fault->status, "%s: model: %.*s", path, length, at);
        at += length + (at[length] == '\n');
    }
}

ss_model_plan ss_world_plan(const ss_world *world)
{
    const ss_scene *scene = world->scene;
    ss_model_plan plan = {.mesh = scene->mesh,
                          .fixed = scene->fixed,
                          .param = scene->param,
                          .load = world->load,
                          .load_count = scene->load_count,
                          .prescribed = world->prescribed,
                          .prescribed_count = scene->prescribed_count,
                          .working_force = scene->working_force_n,
                          .contact_stiffness = scene->contact_stiffness_n_per_m3,
                          .max_force = scene->max_force_n,
                          .max_substeps =
                              world->has_budget ? scene->max_substeps : UNTIMED_SUBSTEPS,
                          .threads = world->threads};
    ss_copy3(plan.gravity, scene->gravity);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        plan.tool[p].is_used = scene->tool[p].is_used;
        plan.tool[p].shape = scene->tool[p].shape;
    }
    return plan;
}

static softsim_status build_model(ss_world *world, double step_s, softsim_error *error)
{
    const ss_scene *scene = world->scene;
    ss_model_plan plan = ss_world_plan(world);
    world->step_cost_us = world->model_class->step_cost_us(&plan);
    world->period = step_s > 0.0 ? step_s : 1.0 / scene->haptic_rate_hz;
    world->step_ticks =
        step_s > 0.0 ? 1 : choose_step_ticks(scene, world->period, world->step_cost_us);
    world->step_period = world->step_ticks * world->period;
    plan.step = world->step_period;
    softsim_error fault = {.status = SOFTSIM_OK};
    ss_progress_part("setting up %s on %d nodes", world->model_class->name,
                     scene->mesh->node_count);
    const softsim_status status = world->model_class->create(&plan, &world->model, &fault);
    pass_on(scene->path, &fault, error);
    return status;
}

static ss_between_steps between(ss_scene_between from)
{
    return from == SS_SCENE_HOLD     ? SS_BETWEEN_HOLD
           : from == SS_SCENE_LINEAR ? SS_BETWEEN_LINEAR
                                     : SS_BETWEEN_LOCAL;
}

static ss_haptic_config probe_config(const ss_world *world, int32_t p)
{
    ss_haptic_config config = world->haptic_config;
    config.tool_gyration = ss_shape_gyration(&world->scene->tool[p].shape);
    return config;
}

static bool has_tools(const ss_scene *scene)
{
    bool is_any = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        is_any |= scene->tool[p].is_used;
    }
    return is_any;
}

/* The least extent of a body along an axis, of a sheet the largest. */
static double body_thickness(const ss_mesh *mesh)
{
    double least = INFINITY, largest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = INFINITY, high = -INFINITY;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            low = fmin(low, mesh->position[i][axis]);
            high = fmax(high, mesh->position[i][axis]);
        }
        least = fmin(least, high - low);
        largest = fmax(largest, high - low);
    }
    return mesh->is_closed || mesh->tetrahedron_count > 0 ? least : largest;
}

static softsim_status build_probes(ss_world *world, bool is_lockstep, softsim_error *error)
{
    const ss_scene *scene = world->scene;
    if (world->step_period > SLOWEST_STEP && has_tools(scene)) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "%s: a simulation step every %.3g s is too slow to be felt: results older "
            "than half a second ramp the force to zero; raise simulation.rate_hz to "
            "%.3g or more, or use a smaller mesh",
            scene->path, world->step_period, 1.0 / SLOWEST_STEP);
        return SOFTSIM_ERROR_SCENE;
    }
    world->haptic_config = (ss_haptic_config){.period = world->period,
                                              .between_steps = between(scene->between_steps),
                                              .max_force = scene->max_force_n,
                                              .max_slew = scene->max_slew_n_per_s,
                                              .stiffness = scene->coupling_stiffness_n_per_m,
                                              .damping = scene->coupling_damping_n_s_per_m,
                                              .thickness = body_thickness(scene->mesh),
                                              .is_lockstep = is_lockstep};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (!scene->tool[p].is_used) {
            continue;
        }
        ss_world_probe *probe = &world->probe[p];
        const ss_haptic_config config = probe_config(world, p);
        probe->is_used = true;
        world->used_probes |= (uint8_t)(1u << p);
        probe->haptic = ss_haptic_create(&config);
        probe->poses = ss_ring_create(sizeof(ss_pose_record), POSE_RING);
        probe->result = ss_mailbox_create(sizeof(ss_local_model));
        probe->target = ss_mailbox_create(sizeof(ss_proxy_target));
        if (!probe->haptic || !probe->poses || !probe->result || !probe->target) {
            return SOFTSIM_ERROR_MEMORY;
        }
    }
    const ss_gate_config gate = {.used_probes = world->used_probes,
                                 .max_jump_m = scene->max_jump_m,
                                 .period_s = world->period,
                                 .is_lockstep = is_lockstep};
    world->gate = ss_gate_create(&gate);
    return world->gate ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* Steps between surface snapshots. */
static int32_t snapshot_interval(double mesh_rate_hz, double step_period)
{
    const double every = round(1.0 / (mesh_rate_hz * step_period));
    return every < 1.0 ? 1 : (int32_t)fmin(every, 1e6);
}

static softsim_status build_exchange(ss_world *world)
{
    const ss_scene *scene = world->scene;
    world->haptic_commands = ss_ring_create(sizeof(ss_command_record), COMMAND_RING);
    world->simulation_commands = ss_ring_create(sizeof(ss_command_record), COMMAND_RING);
    world->forces = ss_ring_create(sizeof(ss_force_record), FORCE_RING);
    world->haptic_stats = ss_mailbox_create(sizeof(ss_haptic_stats));
    world->simulation_stats = ss_mailbox_create(sizeof(ss_simulation_stats));
    world->lateness = ss_memory_get(1, sizeof *world->lateness);
    world->step_time = ss_memory_get(1, sizeof *world->step_time);
    world->set_value =
        ss_memory_get((size_t)SS_LIVE_MODEL_ROW + (size_t)world->model_class->row_count,
                      sizeof *world->set_value);
    if (!world->haptic_commands || !world->simulation_commands || !world->forces ||
        !world->haptic_stats || !world->simulation_stats || !world->lateness || !world->step_time ||
        !world->set_value) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const int64_t now = ss_clock_now_ns();
    ss_histogram_init(world->lateness, now);
    ss_histogram_init(world->step_time, now);
    if (scene->mesh_rate_hz > 0.0) {
        world->snapshot_every = snapshot_interval(scene->mesh_rate_hz, world->step_period);
        world->surface = ss_mailbox_create(sizeof(ss_surface_snapshot) +
                                           3 * sizeof(float) * (size_t)scene->mesh->node_count);
        if (!world->surface) {
            return SOFTSIM_ERROR_MEMORY;
        }
    }
    return SOFTSIM_OK;
}

/* What the plan is made of, whatever folder the scene lies in. */
static uint64_t hash_plan(const ss_world *world)
{
    const ss_scene *scene = world->scene;
    const ss_mesh *mesh = scene->mesh;
    const size_t nodes = (size_t)mesh->node_count;
    uint64_t hash = SS_HASH_START;
    hash = ss_hash_bytes(hash, mesh->position, nodes * sizeof *mesh->position);
    hash =
        ss_hash_bytes(hash, mesh->triangle, (size_t)mesh->triangle_count * sizeof *mesh->triangle);
    hash = ss_hash_bytes(hash, mesh->quad, (size_t)mesh->quad_count * sizeof *mesh->quad);
    hash = ss_hash_bytes(hash, scene->fixed, nodes);
    hash = ss_hash_bytes(hash, world->model_class->name, strlen(world->model_class->name));
    for (int32_t i = 0; i < world->model_class->row_count; ++i) {
        const ss_param_value *value = &scene->param[i];
        hash = ss_hash_bytes(hash, &value->number, sizeof value->number);
        if (value->per_node) {
            hash = ss_hash_bytes(hash, value->per_node, nodes * sizeof *value->per_node);
        }
        if (value->by_element) {
            hash = ss_hash_bytes(hash, value->by_element,
                                 (size_t)ss_mesh_element_count(mesh) * sizeof *value->by_element);
        }
        if (value->link_count > 0) {
            hash = ss_hash_bytes(hash, value->per_link,
                                 (size_t)value->link_count * sizeof *value->per_link);
        }
        hash = ss_hash_bytes(hash, value->direction, sizeof value->direction);
        if (value->per_element) {
            hash = ss_hash_bytes(hash, value->per_element,
                                 (size_t)ss_mesh_element_count(mesh) * sizeof *value->per_element);
        }
    }
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const ss_shape *shape = &scene->tool[p].shape;
        if (scene->tool[p].is_used) {
            const double size[6] = {(double)shape->kind,   shape->radius,
                                    shape->half_length,    shape->half_extent[0],
                                    shape->half_extent[1], shape->half_extent[2]};
            hash = ss_hash_bytes(hash, size, sizeof size);
        }
    }
    const double rates[4] = {world->period, world->step_period, scene->working_force_n,
                             scene->contact_stiffness_n_per_m3};
    return ss_hash_bytes(hash, rates, sizeof rates);
}

softsim_status ss_world_create(const ss_world_options *options, ss_world **out_world,
                               softsim_error *error)
{
    *out_world = NULL;
    /* Set-up arithmetic is part of the result: the same here as in the loops and headless runs. */
    ss_thread_flush_denormals();
    ss_world *world = ss_memory_get(1, sizeof *world);
    if (!world) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no memory for the world");
        return SOFTSIM_ERROR_MEMORY;
    }
    world->threads = options->threads > 0 ? options->threads : 1;
    world->has_budget = options->has_budget;
    const ss_scene_model *models = NULL;
    const int32_t model_count = ss_world_scene_models(&models);
    softsim_status status =
        ss_scene_load(options->scene_path, options->set, options->set_count, models, model_count,
                      options->import_program, &world->scene, error);
    if (status == SOFTSIM_OK && !ss_scene_renumber(world->scene)) {
        status = SOFTSIM_ERROR_MEMORY;
    }
    if (status == SOFTSIM_OK) {
        status = ss_world_plan_numbers(world);
    }
    if (status != SOFTSIM_OK) {
        goto fail;
    }
    int32_t class_count = 0;
    world->model_class = ss_model_table(&class_count)[world->scene->model_index];
    status = plan_loads(world);
    if (status == SOFTSIM_OK) {
        status = build_model(world, options->step_s, error);
    }
    if (status == SOFTSIM_OK) {
        status = build_probes(world, options->is_lockstep, error);
    }
    if (status == SOFTSIM_OK) {
        status = build_exchange(world);
    }
    if (status != SOFTSIM_OK) {
        goto fail;
    }
    ss_world_plan_watch(world);
    world->plan_hash = hash_plan(world);
    *out_world = world;
    return SOFTSIM_OK;
fail:
    if (error && error->fault_count == 0) {
        softsim_error_add(error, status, "%s: %s", options->scene_path,
                          softsim_status_text(status));
    }
    ss_world_destroy(&world);
    return status;
}

void ss_world_destroy(ss_world **world_pointer)
{
    ss_world *world = *world_pointer;
    if (!world) {
        return;
    }
    if (world->model) {
        world->model_class->destroy(world->model);
    }
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_world_probe *probe = &world->probe[p];
        ss_haptic_destroy(&probe->haptic);
        ss_ring_destroy(&probe->poses);
        ss_mailbox_destroy(&probe->result);
        ss_mailbox_destroy(&probe->target);
    }
    ss_gate_destroy(&world->gate);
    ss_ring_destroy(&world->forces);
    ss_ring_destroy(&world->haptic_commands);
    ss_ring_destroy(&world->simulation_commands);
    ss_mailbox_destroy(&world->haptic_stats);
    ss_mailbox_destroy(&world->simulation_stats);
    ss_mailbox_destroy(&world->surface);
    ss_memory_free(world->lateness);
    ss_memory_free(world->step_time);
    ss_memory_free(world->set_value);
    ss_memory_free(world->load);
    ss_memory_free(world->prescribed);
    ss_memory_free(world->node_of_file);
    ss_memory_free(world->file_triangle);
    ss_scene_destroy(&world->scene);
    ss_memory_free(world);
    *world_pointer = NULL;
}

/* ---- haptic thread ---- */

static void run_haptic_command(ss_world *world, const ss_command_record *command)
{
    ss_haptic_config *config = &world->haptic_config;
    switch (command->kind) {
    case SS_COMMAND_PAUSE:
        world->haptic_paused = true;
        break;
    case SS_COMMAND_RESUME:
        world->haptic_paused = false;
        ++world->haptic_starts;
        break;
    case SS_COMMAND_RESET:
        ++world->haptic_starts;
        break;
    case SS_COMMAND_SET:
        switch (command->key) {
        case SS_LIVE_MAX_FORCE:
            config->max_force = command->value;
            break;
        case SS_LIVE_MAX_SLEW:
            config->max_slew = command->value;
            break;
        case SS_LIVE_COUPLING_STIFFNESS:
            config->stiffness = command->value;
            break;
        case SS_LIVE_COUPLING_DAMPING:
            config->damping = command->value;
            break;
        case SS_LIVE_BETWEEN_STEPS:
            config->between_steps = between((ss_scene_between)command->value);
            break;
        default:
            return;
        }
        for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
            if (world->probe[p].is_used) {
                const ss_haptic_config changed = probe_config(world, p);
                ss_haptic_configure(world->probe[p].haptic, &changed);
            }
        }
        break;
    default:
        break;
    }
}

/* One probe: drain its poses (all of them: the newest wins, none is lost to the energy sum and
 * the button edges), tick, post the proxy target, push the force. */
static void tick_probe(ss_world *world, int32_t p, int64_t tick, int64_t due_ns,
                       ss_haptic_stats *stats)
{
    ss_world_probe *probe = &world->probe[p];
    softsim_pose pose[TICK_POSES];
    ss_pose_record record;
    ss_haptic_input input = {.tick = tick, .pose = pose};
    while (input.pose_count < TICK_POSES && ss_ring_pop(probe->poses, &record)) {
        pose[input.pose_count++] = record.pose;
        input.sender_epoch = record.sender_epoch;
    }
    if (input.pose_count > 1) {
        world->superseded += input.pose_count - 1;
    }
    input.result = ss_mailbox_take(probe->result, &input.is_result_new);
    input.is_paused = world->haptic_paused;
    input.starts = world->haptic_starts;
    input.is_stopping = atomic_load_explicit(&world->is_stopping, memory_order_acquire);

    ss_haptic_output output;
    ss_haptic_tick(probe->haptic, &input, &output);
    *(ss_proxy_target *)ss_mailbox_draft(probe->target) = output.target;
    ss_mailbox_post(probe->target);
    if (output.has_force) {
        const ss_force_record out = {.force = output.force, .tick = tick, .due_ns = due_ns};
        ss_ring_push(world->forces, &out);
    }
    const ss_hand_tick hand = {.tick = tick,
                               .period = world->period,
                               .pose = input.pose_count > 0 ? &pose[input.pose_count - 1] : NULL,
                               .sender_epoch = input.sender_epoch,
                               .sent = &output.force,
                               .contact_j = output.contact_j,
                               .let_in_j = output.let_in_j,
                               .is_lockstep = world->haptic_config.is_lockstep};
    ss_hand_watch_tick(&probe->hand, &hand);
    stats->hand = ss_hand_verdict_worse(stats->hand, ss_hand_watch_verdict(&probe->hand, tick));
    stats->worst_contact_j[p] = output.worst_contact_j;
    stats->stiffness_limit[p] = output.stiffness_limit;
    stats->energy_to_device_j += output.energy_to_device_j;
    stats->energy_from_device_j += output.energy_from_device_j;
    for (int i = 0; i < 2 && output.has_force; ++i) {
        stats->loop_delay_ms[i] = fmax(stats->loop_delay_ms[i], output.loop_delay_ms[i]);
    }
}

void ss_world_haptic_tick(ss_world *world, int64_t tick, int64_t due_ns, int64_t now_ns)
{
    ss_command_record command;
    while (ss_ring_pop(world->haptic_commands, &command)) {
        run_haptic_command(world, &command);
    }
    ss_haptic_stats stats = {0};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            tick_probe(world, p, tick, due_ns, &stats);
        }
    }
    world->hand = stats.hand;
    world->worst_hand = ss_hand_verdict_worse(world->worst_hand, stats.hand);
    if (due_ns != 0) {
        ss_histogram_add(world->lateness, now_ns, 1e-3 * (double)(now_ns - due_ns));
    }
    if (due_ns != 0 && tick >= world->next_quantiles_tick) {
        static const double quantile[4] = {0.5, 0.99, 0.999, 1.0};
        world->next_quantiles_tick = tick + (int64_t)ceil(0.25 / world->period);
        for (int i = 0; i < 4; ++i) {
            world->lateness_us[i] = ss_histogram_quantile(world->lateness, quantile[i]);
        }
    }
    memcpy(stats.lateness_us, world->lateness_us, sizeof stats.lateness_us);
    stats.superseded = world->superseded;
    stats.late_periods = world->late_periods;
    *(ss_haptic_stats *)ss_mailbox_draft(world->haptic_stats) = stats;
    ss_mailbox_post(world->haptic_stats);
}

/* ---- simulation thread ---- */

static void run_simulation_command(ss_world *world, const ss_command_record *command)
{
    switch (command->kind) {
    case SS_COMMAND_PAUSE:
        world->simulation_paused = true;
        break;
    case SS_COMMAND_RESUME:
        world->simulation_paused = false;
        ++world->simulation_starts;
        break;
    case SS_COMMAND_RESET:
        world->is_hashed = false;
        ++world->simulation_starts;
        world->model_class->reset(world->model);
        ss_energy_watch_reset(&world->energy);
        break;
    case SS_COMMAND_SET:
        if (command->key == SS_LIVE_MODEL_ROW) {
            world->is_hashed = false;
            world->model_class->set(world->model, command->row, command->value);
            ss_energy_watch_skip(&world->energy);
        } else if (command->key == SS_LIVE_MESH_RATE) {
            world->snapshot_every = snapshot_interval(command->value, world->step_period);
        }
        break;
    default:
        break;
    }
}

void ss_world_step_begin(ss_world *world)
{
    /* Targets first: one from after a command is then never stepped to from before it, since
     * ss_world_command hands a command to this loop before it hands it to the haptic one. */
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_world_probe *probe = &world->probe[p];
        const ss_proxy_target *target =
            probe->is_used ? ss_mailbox_take(probe->target, NULL) : NULL;
        probe->stepped_to = target ? *target : (ss_proxy_target){0};
    }
    ss_command_record command;
    while (ss_ring_pop(world->simulation_commands, &command)) {
        run_simulation_command(world, &command);
    }
}

/* A tool that has just come and stands inside the tissue is not given to the model yet: its
 * result says where the surface is, with no force, and the haptic loop moves the proxy out there
 * and lets it in by fading. True when the tool may be placed. */
static bool may_place(ss_world *world, ss_world_probe *probe, int32_t p, const ss_tool_pose *pose)
{
    const ss_shape *shape = &world->scene->tool[p].shape;
    ss_contact_set *set = &probe->computed.set;
    double point[3], normal[3];
    const double depth =
        ss_contact_locate(world->scene->mesh, world->model_class->displacement(world->model), shape,
                          pose, point, normal);
    if (depth <= PLACE_SHARE * ss_shape_bounding_radius(shape)) {
        return true;
    }
    *set = (ss_contact_set){.count = 1};
    ss_contact *contact = &set->contact[0];
    contact->stiffness = contact->tangential = PLACE_STIFFNESS;
    ss_copy3(contact->point, point);
    ss_copy3(contact->normal, normal);
    ss_copy3(set->point, point);
    ss_copy3(set->normal, normal);
    ss_madd3(probe->computed.proxy, pose->position, depth,
             normal); /* where the tool just touches */
    return false;
}

/* No hand moves or turns a tool faster: what jumps in a period is caught up with, not flung. */
static void follow(const ss_tool_pose *last, double period, ss_tool_pose *inout_to)
{
    double way[3], turn[3];
    ss_sub3(way, inout_to->position, last->position);
    ss_turn_between(last->orientation, inout_to->orientation, turn);
    const double length = ss_norm3(way), reach = MAX_TOOL_SPEED * period;
    const double angle = ss_norm3(turn), most = MAX_TOOL_TURN * period;
    if (length > reach) {
        ss_madd3(inout_to->position, last->position, reach / length, way);
    }
    if (angle > most) {
        ss_tool_pose turned;
        ss_tool_pose_blend(last, inout_to, most / angle, &turned);
        memcpy(inout_to->orientation, turned.orientation, sizeof turned.orientation);
    }
}

/* Where tool p goes during this step: swept from the last predicted proxy to the new one, or
 * placed there when it has just come. After a reset or resume it is out of the model until the
 * haptic loop, which ramps its force down first, has placed it anew: a body at rest is never
 * struck by a tool that stood deep in what it was, nor by one that moved under pause. */
static ss_model_tool plan_tool(ss_world *world, int32_t p, double velocity[3])
{
    ss_world_probe *probe = &world->probe[p];
    const ss_proxy_target *target = &probe->stepped_to;
    probe->is_waiting = false;
    ss_model_tool tool = {.is_present = target->is_present, .is_grasping = target->is_grasping};
    ss_set3(velocity, 0.0, 0.0, 0.0);
    if (!target->is_present || target->starts != world->simulation_starts) {
        probe->was_present = tool.is_present = false;
        probe->waited = 0;
        return tool;
    }
    ss_haptic_predict(target, LAG_PERIODS, world->step_period, tool.to.position);
    memcpy(tool.to.orientation, target->orientation, sizeof tool.to.orientation);
    const bool is_swept = probe->was_present && probe->last_teleports == target->teleports;
    if (is_swept) {
        follow(&probe->last, world->step_period, &tool.to);
    }
    tool.from = is_swept ? probe->last : tool.to;
    if (!is_swept && !may_place(world, probe, p, &tool.to)) {
        probe->is_waiting = true;
        ++probe->waited;
        probe->was_present = false;
        tool.is_present = false;
        return tool;
    }
    if (is_swept) {
        ss_sub3(velocity, tool.to.position, tool.from.position);
        ss_scale3(velocity, velocity, 1.0 / world->step_period);
    }
    probe->waited = 0;
    probe->was_present = true;
    probe->last_teleports = target->teleports;
    return tool;
}

/* A step that was slower than time, or none under pause, took the tool a share of its way: it
 * stands there, the next step goes on from there, and the haptic loop is told of that place. */
static void reach(ss_world *world, ss_world_probe *probe, double travelled, ss_model_tool *tool,
                  double velocity[3])
{
    if (travelled < 1.0) {
        ss_model_reached(tool, travelled, &probe->last);
        tool->to = probe->last;
        ss_sub3(velocity, tool->to.position, tool->from.position);
        ss_scale3(velocity, velocity, 1.0 / world->step_period);
    }
    probe->last = tool->to;
}

static void read_contacts(ss_world *world, int32_t p, const ss_model_tool *tool,
                          const double velocity[3], bool is_fault)
{
    ss_world_probe *probe = &world->probe[p];
    ss_local_model *out = &probe->computed;
    out->tick = probe->stepped_to.tick;
    out->step = world->steps;
    out->period = world->step_period;
    out->pose_seq = probe->stepped_to.pose_seq;
    out->starts = world->simulation_starts;
    out->is_fault = is_fault;
    memcpy(out->orientation, probe->stepped_to.orientation, sizeof out->orientation);
    ss_set3(out->velocity, 0.0, 0.0, 0.0);
    if (probe->is_waiting) {
        return; /* may_place() filled in the rest */
    }
    out->set = (ss_contact_set){0};
    if (!tool->is_present) {
        return;
    }
    ss_copy3(out->proxy, tool->to.position);
    memcpy(out->orientation, tool->to.orientation, sizeof out->orientation);
    ss_copy3(out->velocity, velocity);
    const double near = NEAR_M + ss_norm3(velocity) * (LAG_PERIODS + 1.0) * world->step_period;
    world->model_class->contacts(world->model, p, near, &out->set);
}

void ss_world_step_compute(ss_world *world)
{
    const int64_t cpu_start = ss_clock_thread_cpu_ns();
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    double velocity[SOFTSIM_MAX_PROBES][3] = {{0}};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            tool[p] = plan_tool(world, p, velocity[p]);
        }
    }
    ss_model_info info;
    const bool is_still =
        world->simulation_paused || world->energy.verdict == SOFTSIM_VERDICT_FAULT;
    if (!is_still) {
        world->model_class->step(world->model, (double)world->steps * world->step_period,
                                 world->step_period, tool);
        ++world->steps;
        world->is_hashed = false;
    }
    world->model_class->info(world->model, &info);
    world->substeps += is_still ? 0 : info.substeps;
    const double travelled = is_still ? 0.0 : info.travelled;
    double way = 0.0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (tool[p].is_present) {
            reach(world, &world->probe[p], travelled, &tool[p], velocity[p]);
            way += ss_tool_motion_bound(&world->scene->tool[p].shape, &tool[p].from, &tool[p].to);
        }
    }
    if (!is_still) {
        ss_energy_watch_step(&world->energy, &info, way, world->step_period);
    }
    ss_energy_watch_judge(&world->energy, &info);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            read_contacts(world, p, &tool[p], velocity[p], info.verdict == SOFTSIM_VERDICT_FAULT);
        }
    }
    ss_world_judge_sinking(world, &info);
    if (info.verdict > world->worst_verdict) {
        world->worst_verdict = info.verdict;
        world->worst_reason = info.reason;
    }
    const int64_t now = ss_clock_now_ns();
    ss_histogram_add(world->step_time, now, 1e-3 * (double)(ss_clock_thread_cpu_ns() - cpu_start));
}

static void post_surface(ss_world *world)
{
    ss_surface_snapshot *snapshot = ss_mailbox_draft(world->surface);
    const ss_real *u = world->model_class->displacement(world->model);
    const int32_t node_count = world->scene->mesh->node_count;
    snapshot->step = world->steps;
    for (int32_t i = 0; i < node_count; ++i) {
        for (int32_t axis = 0; axis < 3; ++axis) {
            snapshot->displacement[3 * i + axis] = (float)u[4 * i + axis];
        }
    }
    ss_mailbox_post(world->surface);
}

void ss_world_step_post(ss_world *world)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_world_probe *probe = &world->probe[p];
        if (probe->is_used) {
            *(ss_local_model *)ss_mailbox_draft(probe->result) = probe->computed;
            ss_mailbox_post(probe->result);
        }
    }
    if (world->surface && world->steps % world->snapshot_every == 0) {
        post_surface(world);
    }
    ss_simulation_stats *stats = ss_mailbox_draft(world->simulation_stats);
    ss_world_info(world, &stats->info);
    stats->is_paused = world->simulation_paused;
    stats->info.step = world->steps;
    const int64_t quarter = (int64_t)ceil(0.25 / world->step_period);
    if (world->steps % quarter == 0) {
        static const double quantile[3] = {0.5, 0.99, 1.0};
        for (int i = 0; i < 3; ++i) {
            world->step_quantiles[i] = ss_histogram_quantile(world->step_time, quantile[i]);
        }
    }
    memcpy(stats->step_us, world->step_quantiles, sizeof stats->step_us);
    stats->lag = world->lag;
    ss_mailbox_post(world->simulation_stats);
}

/* ---- commands ---- */

/* What the hand feels may be lowered by a command, not raised: the name of such a key, and the
 * scene's value. NULL of the others. */
static const char *felt_limit(const ss_scene *scene, ss_scene_live_key key, double *out_most)
{
    switch (key) {
    case SS_LIVE_MAX_FORCE:
        *out_most = scene->max_force_n;
        return "haptic.max_force_n";
    case SS_LIVE_MAX_SLEW:
        *out_most = scene->max_slew_n_per_s;
        return "haptic.max_slew_n_per_s";
    case SS_LIVE_COUPLING_STIFFNESS:
        *out_most = scene->coupling_stiffness_n_per_m;
        return "haptic.coupling.stiffness_n_per_m";
    case SS_LIVE_COUPLING_DAMPING:
        *out_most = scene->coupling_damping_n_s_per_m;
        return "haptic.coupling.damping_n_s_per_m";
    default:
        return NULL;
    }
}

static int32_t parse_set(ss_world *world, const char *argument, ss_command_record *record,
                         char *out_text, int32_t text_size)
{
    const ss_scene_model *models = NULL;
    ss_world_scene_models(&models);
    softsim_error error = {0};
    if (ss_scene_parse_live(argument, &models[world->scene->model_index], &record->key,
                            &record->row, &record->value, &error) != SOFTSIM_OK) {
        snprintf(out_text, (size_t)text_size, "%.*s", (int)text_size - 1, error.text);
        return 2;
    }
    if (record->key == SS_LIVE_MESH_RATE && (!world->surface || record->value <= 0.0)) {
        snprintf(out_text, (size_t)text_size,
                 "publish.mesh_rate_hz: starting or ending the mesh publisher needs a restart");
        return 1;
    }
    double most = INFINITY;
    const char *name = felt_limit(world->scene, record->key, &most);
    if (record->value > most) {
        snprintf(out_text, (size_t)text_size,
                 "refused: no command raises %s above the scene's %g, for what the hand feels is "
                 "decided where the scene is; start the server with another --set",
                 name, most);
        return 1;
    }
    return 0;
}

/* Says what is set now and was before, and remembers it. */
static void tell_set(ss_world *world, const char *argument, const ss_command_record *record,
                     char *out_text, int32_t text_size)
{
    const ss_scene_model *models = NULL;
    ss_world_scene_models(&models);
    const int32_t slot =
        record->key == SS_LIVE_MODEL_ROW ? SS_LIVE_MODEL_ROW + record->row : (int32_t)record->key;
    ss_set_value *set = &world->set_value[slot];
    ss_scene_tell_live(world->scene, &models[world->scene->model_index], argument, record->value,
                       set->is_set ? &set->value : NULL, out_text, (size_t)text_size);
    *set = (ss_set_value){.is_set = true, .value = record->value};
    if (record->key == SS_LIVE_COUPLING_STIFFNESS) {
        const size_t length = strlen(out_text);
        snprintf(out_text + length, (size_t)text_size - length,
                 "; the hand's limit moves there by 20 %% a second, as far as the loop's delay "
                 "allows: stiffness_limit_n_per_m of the status");
    }
}

int32_t ss_world_command(ss_world *world, const char *name, const char *argument,
                         ss_command_record *out_record, char *out_text, int32_t text_size)
{
    static const char *const names[] = {"reset", "pause",  "resume",  "refresh",
                                        "set",   "status", "shutdown"};
    static const char *const did[] = {
        "reset: the body is at rest, without a force, and a fault is forgotten",
        "paused: the body stands still and forces are zero until the command resume",
        "running again",
        "the whole mesh is being sent again",
        "",
        "a status is on its way",
        "shutting down"};
    const int32_t name_count = (int32_t)(sizeof names / sizeof *names);
    int32_t kind = 0;
    while (kind < name_count && strcmp(names[kind], name) != 0) {
        ++kind;
    }
    if (kind == name_count) {
        snprintf(out_text, (size_t)text_size,
                 "unknown command '%.40s'; use reset pause resume refresh set status shutdown",
                 name);
        return 2;
    }
    if (kind != SS_COMMAND_SET && argument[0] != '\0') {
        snprintf(out_text, (size_t)text_size,
                 "%s takes no argument, but '%.40s' came; leave it out", name, argument);
        return 2;
    }
    *out_record = (ss_command_record){.kind = (ss_command_kind)kind};
    snprintf(out_text, (size_t)text_size, "%s", did[kind]);
    if (kind == SS_COMMAND_SET) {
        const int32_t code = parse_set(world, argument, out_record, out_text, text_size);
        if (code != 0) {
            return code;
        }
    }
    if (kind == SS_COMMAND_REFRESH || kind == SS_COMMAND_STATUS || kind == SS_COMMAND_SHUTDOWN) {
        return 0;
    }
    /* All who are concerned take it, or none. The loops count resets, each for itself. Without
     * tools there is no haptic loop. */
    const bool is_felt = world->used_probes != 0;
    if (!ss_ring_has_room(world->simulation_commands) ||
        (is_felt && !ss_ring_has_room(world->haptic_commands))) {
        snprintf(out_text, (size_t)text_size, "busy: too many commands at once; send it again");
        return 1;
    }
    ss_ring_push(world->simulation_commands, out_record);
    if (is_felt) {
        ss_ring_push(world->haptic_commands, out_record);
    }
    if (kind == SS_COMMAND_SET) {
        if (out_record->key == SS_LIVE_MAX_JUMP) {
            ss_gate_set_max_jump(world->gate, out_record->value);
        }
        tell_set(world, argument, out_record, out_text, text_size);
    }
    return 0;
}
