/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/plan.h"
#include "world/field.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/each.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/progress.h"
#include "rt/thread.h"
#include "rt/vec.h"

/* From a scene to a world that is ready: everything is planned and allocated here, nothing later.
 */

enum {
    POSE_RING = 256,   /* a quarter of a second of poses at 1 kHz */
    FORCE_RING = 8192, /* one second of eight probes */
    /* What the net thread lets in between two steps at 1 Hz: 900 and a burst of them (net/net.c).
     * Were there less room, the commands of others would keep out those of one who rarely asks. */
    COMMAND_RING = 2048
};
static const double SLOWEST_STEP = 0.2; /* s: two of them, and a result is too old to be felt */

int32_t ss_world_scene_models(ss_scene_model out_models[SS_MAX_MODELS])
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    for (int32_t i = 0; i < count; ++i) {
        out_models[i] = (ss_scene_model){.name = table[i]->name,
                                         .row = table[i]->row,
                                         .row_count = table[i]->row_count,
                                         .needs_volume = table[i]->needs_volume,
                                         .takes_second_order = table[i]->takes_second_order};
    }
    return count;
}

static softsim_status plan_prescribed(ss_world *world)
{
    const ss_scene *scene = world->scene;
    world->prescribed = ss_memory_get((size_t)scene->prescribed_count, sizeof *world->prescribed);
    if (!world->prescribed) {
        return SOFTSIM_ERROR_MEMORY;
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

/* A model for the step that was chosen. */
static softsim_status make_model(ss_world *world, softsim_error *error)
{
    const ss_model_plan plan = ss_world_plan(world);
    softsim_error fault = {.status = SOFTSIM_OK};
    const softsim_status status = ss_model_create(world->model_class, &plan, &world->model, &fault);
    pass_on(world->scene->path, &fault, error);
    return status;
}

static softsim_status build_model(ss_world *world, const ss_world_options *options,
                                  softsim_error *error)
{
    const ss_scene *scene = world->scene;
    ss_world_rate_by_counts(world, options->step_s);
    ss_progress_part("setting up %s on %d nodes", world->model_class->name,
                     scene->mesh->node_count);
    softsim_status status = make_model(world, error);
    if (status == SOFTSIM_OK && options->yardstick != 0.0 && !(scene->simulation_rate_hz > 0.0)) {
        const int32_t counted = world->step_ticks;
        world->yardstick =
            options->yardstick > 0.0 ? options->yardstick : ss_world_measure_yardstick(world);
        ss_world_rate_by_yardstick(world);
        if (world->step_ticks != counted || world->planned_yardstick > 0.0) {
            world->model_class->destroy(world->model);
            world->model = NULL;
            status = make_model(world, error);
        }
    }
    if (status != SOFTSIM_OK || scene->sleep == SS_SCENE_SLEEP_OFF) {
        return status;
    }
    const ss_model_plan plan = ss_world_plan(world);
    world->sleep = ss_sleep_create(world->model_class, world->model, &plan);
    return world->sleep ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

ss_between_steps ss_world_between(ss_scene_between from)
{
    return from == SS_SCENE_HOLD     ? SS_BETWEEN_HOLD
           : from == SS_SCENE_LINEAR ? SS_BETWEEN_LINEAR
                                     : SS_BETWEEN_LOCAL;
}

ss_haptic_config ss_world_probe_config(const ss_world *world, int32_t p)
{
    ss_haptic_config config = world->haptic_config;
    config.tool_gyration = ss_shape_gyration(&world->scene->tool[p].shape);
    return config;
}

static bool has_friction(const ss_scene *scene)
{
    return scene->friction.number > 0.0 || scene->friction.per_node != NULL;
}

/* Does the model hold tools along the surface, where the scene wants that? */
static softsim_status check_friction(const ss_world *world, softsim_error *error)
{
    if (!has_friction(world->scene) || world->model_class->takes_friction) {
        return SOFTSIM_OK;
    }
    int32_t count = 0, size = 0;
    char others[256] = "";
    const ss_model_class *const *table = ss_model_table(&count);
    for (int32_t i = 0; i < count; ++i) {
        if (table[i]->takes_friction && size < (int32_t)sizeof others) {
            size += snprintf(others + size, sizeof others - (size_t)size, "%s%s",
                             size > 0 ? ", " : "", table[i]->name);
        }
    }
    softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                      "%s: contact.friction: %s cannot hold a tool along its surface; use a model "
                      "that can%s%s, or leave friction out",
                      world->scene->path, world->model_class->name, size > 0 ? ": " : "", others);
    return SOFTSIM_ERROR_SCENE;
}

/* Does what the model grasps pull the tool, where the scene has that torn? */
static softsim_status check_grasp(const ss_world *world, softsim_error *error)
{
    if (world->scene->grasp_max_force_n > 0.0 && world->model_class->grasps_without_force) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: contact.grasp_max_force_n: what %s grasps goes along without "
                          "force and is never torn; use another model, or leave it out",
                          world->scene->path, world->model_class->name);
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
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
    world->haptic_config =
        (ss_haptic_config){.period = world->period,
                           .between_steps = ss_world_between(scene->between_steps),
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
        const ss_haptic_config config = ss_world_probe_config(world, p);
        probe->is_used = true;
        world->used_probes |= (uint8_t)(1u << p);
        probe->haptic = ss_haptic_create(&config);
        probe->poses = ss_ring_create(sizeof(ss_pose_record), POSE_RING);
        probe->result = ss_mailbox_create(sizeof(ss_simulation_result));
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

int32_t ss_world_snapshot_interval(double mesh_rate_hz, double step_period)
{
    const double every = round(1.0 / (mesh_rate_hz * step_period));
    return every < 1.0 ? 1 : (int32_t)fmin(every, 1e6);
}

static softsim_status build_drawn(ss_world *world)
{
    const ss_scene *scene = world->scene;
    ss_model_shape shape = {.mesh = scene->mesh, .fixed = scene->fixed};
    if (world->model_class->shape) {
        world->model_class->shape(world->model, &shape);
    }
    return ss_drawn_init(&world->drawn, scene->mesh, scene->fixed, &shape) ? SOFTSIM_OK
                                                                           : SOFTSIM_ERROR_MEMORY;
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
    atomic_init(&world->field, (int)scene->field);
    const int64_t now = ss_clock_now_ns();
    ss_histogram_init(world->lateness, now);
    ss_histogram_init(world->step_time, now);
    if (scene->mesh_rate_hz > 0.0) {
        world->snapshot_every = ss_world_snapshot_interval(scene->mesh_rate_hz, world->step_period);
        const size_t floats = world->model_class->potential != NULL ? 4 : 3;
        world->surface = ss_mailbox_create(
            sizeof(ss_surface_snapshot) + floats * sizeof(float) * (size_t)world->drawn.node_count);
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
    if (has_friction(scene)) {
        const ss_param_value *friction = &scene->friction;
        hash = ss_hash_bytes(hash, &friction->number, sizeof friction->number);
        hash = ss_hash_bytes(hash, friction->per_node,
                             friction->per_node ? nodes * sizeof *friction->per_node : 0);
    }
    if (scene->grasp_max_force_n > 0.0) {
        hash = ss_hash_bytes(hash, &scene->grasp_max_force_n, sizeof scene->grasp_max_force_n);
    }
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
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
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
    status = plan_prescribed(world);
    if (status == SOFTSIM_OK &&
        !ss_field_is_possible(world->scene, world->model_class, world->scene->field)) {
        status = SOFTSIM_ERROR_SCENE;
        char possible[128];
        ss_field_list(world->scene, world->model_class, " or ", possible, sizeof possible);
        softsim_error_add(error, status, "%s: publish.field: %s has %s, and so no %s; use %s",
                          world->scene->path, world->model_class->name,
                          ss_field_lack(world->scene->field), ss_field_name(world->scene->field),
                          possible);
    }
    if (status == SOFTSIM_OK) {
        status = check_friction(world, error);
    }
    if (status == SOFTSIM_OK) {
        status = check_grasp(world, error);
    }
    if (status == SOFTSIM_OK) {
        status = build_model(world, options, error);
    }
    if (status == SOFTSIM_OK) {
        status = build_probes(world, options->is_lockstep, error);
    }
    if (status == SOFTSIM_OK) {
        status = build_drawn(world);
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

ss_publish_mesh ss_world_publish_mesh(const ss_world *world)
{
    const ss_drawn *drawn = &world->drawn;
    return (ss_publish_mesh){.node_count = drawn->node_count,
                             .triangle_count = drawn->triangle_count,
                             .rest = drawn->rest,
                             .triangle = drawn->triangle,
                             .file_node = drawn->file_node,
                             .fixed = drawn->fixed,
                             .diagonal = ss_mesh_diagonal(world->scene->mesh)};
}

void ss_world_destroy(ss_world **world_pointer)
{
    ss_world *world = *world_pointer;
    if (!world) {
        return;
    }
    ss_sleep_destroy(&world->sleep);
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
    ss_drawn_fini(&world->drawn);
    SS_EACH(ss_memory_free, world->lateness, world->step_time, world->set_value, world->prescribed,
            world->node_of_file, world->file_triangle);
    ss_scene_destroy(&world->scene);
    ss_memory_free(world);
    *world_pointer = NULL;
}
