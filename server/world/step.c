/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <string.h>

#include "rt/clock.h"
#include "rt/vec.h"
#include "world/plan.h"
#include "world/world.h"

/*
 * One step of the simulation: takes the proxies' targets, sweeps the tools to where the proxies
 * are predicted, steps the model, reads what each tool touches, posts it.
 *
 * One lag for all: the proxy is predicted (1 + 1/2) h ahead. A step that is late is a degraded
 * period, counted, not a longer prediction.
 */

static const double LAG_PERIODS = 1.0;
/* Contacts are published before touching from here on, and from as far as a hand that sets off may
 * come by the time of the next result, beyond where its speed brings it. Without that, at 60 and
 * 100 Hz, a hand that set off at 2 m/s was in the tissue before the haptic loop knew of any, and
 * the next step swept the tool there: 270 mJ at a limit of 0.5 N. */
static const double NEAR_M = 0.005;
static const double HAND_ACCELERATION = 100.0; /* m/s^2 */
static const double MAX_TOOL_SPEED = 3.0;      /* m/s */
static const double MAX_TOOL_TURN = 50.0;      /* rad/s */
static const double PLACE_SHARE = 0.1;         /* of the tool: deeper, and it is let in by fading */
static const double PLACE_CHECK_PERIOD = 0.02; /* s: how often a tool without a place is checked */
/* A search visits all triangles up to 66 times (0.1 ms each at 14,000), up to 19 times in a step.
 * After a failure the wait doubles, up to this, s. */
static const double MAX_SEARCH_WAIT = 1.0;

/* s of simulation after a tool's last touch: until then what it pressed may spring back. Let go at
 * once, organs and blocks of every model are within a tenth of the tool of where they come to rest
 * after 0.16 s at most (a ventricle pressed by 16 mm). */
static const double DEFORMED_TIME = 1.0;

/* What a step has of its tools. */
typedef struct ss_world_tools {
    ss_model_tool tool[SOFTSIM_MAX_PROBES];
    double velocity[SOFTSIM_MAX_PROBES][3]; /* m/s */
    double near[SOFTSIM_MAX_PROBES];        /* m */
} ss_world_tools;

static void run_simulation_command(ss_world *world, const ss_command_record *command)
{
    ss_loop_hear(&world->simulation_run, command->kind);
    if (world->sleep) {
        ss_sleep_wake(world->sleep);
    }
    if (command->kind == SS_COMMAND_RESET) {
        world->is_hashed = false;
        world->deformed_until = world->steps;
        world->model_class->reset(world->model);
        ss_energy_watch_reset(&world->energy);
    } else if (command->kind == SS_COMMAND_SET && command->key == SS_LIVE_MODEL_ROW) {
        world->is_hashed = false;
        world->model_class->set(world->model, command->row, command->value);
        ss_energy_watch_skip(&world->energy);
    } else if (command->kind == SS_COMMAND_SET && command->key == SS_LIVE_MESH_RATE) {
        world->snapshot_every = ss_world_snapshot_interval(command->value, world->step_period);
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
        probe->step_target = target ? *target : (ss_proxy_target){0};
    }
    ss_command_record command;
    while (ss_ring_pop(world->simulation_commands, &command)) {
        run_simulation_command(world, &command);
    }
}

/* A tool that has just come and stands inside the tissue is put where it just touches: its result
 * says so, the haptic loop moves the proxy out there and lets it in by fading. After a reset or
 * resume it goes out the way it was pressed in: in thin tissue the nearest way may lead through.
 * False where there is no place for it. */
static bool find_free_pose(ss_world *world, int32_t p, ss_tool_pose *inout_pose)
{
    ss_world_probe *probe = &world->probe[p];
    const ss_proxy_target *target = &probe->step_target;
    const ss_shape *shape = &world->scene->tool[p].shape;
    const ss_contact_tissue tissue = {.mesh = world->scene->mesh,
                                      .u = world->model_class->displacement(world->model),
                                      .is_deformed = world->steps < world->deformed_until};
    const double spare = PLACE_SHARE * ss_shape_bounding_radius(shape);
    const int64_t every = (int64_t)ceil(PLACE_CHECK_PERIOD / world->step_period);
    const int64_t most = (int64_t)ceil(MAX_SEARCH_WAIT / world->step_period);
    double way[3], point[3], normal[3];
    if (probe->steps_unplaced == 0 || probe->last_teleports != target->teleports) {
        probe->steps_unplaced = probe->next_search = 0;
        probe->search.is_begun = false;
    }
    if (probe->steps_unplaced % every != 0 && !probe->search.is_begun) {
        return false;
    }
    /* One that was drawn out meanwhile is seen by a single pass. */
    probe->depth = ss_contact_locate(tissue.mesh, tissue.u, shape, inout_pose, point, normal);
    if (probe->depth <= spare) {
        probe->search.is_begun = false;
    } else if (probe->steps_unplaced < probe->next_search && !probe->search.is_begun) {
        return false;
    }
    const bool is_as_before = target->has_stayed && probe->is_pressed_in;
    const bool is_restart = target->restart_count != probe->inward_restart_count;
    if (target->holders != probe->inward_holders || (!is_restart && !is_as_before)) {
        ss_set3(probe->inward, 0.0, 0.0, 0.0); /* another device, or the same from elsewhere */
    }
    const ss_contact_exit_result result =
        ss_contact_leave(&tissue, shape, inout_pose, spare, probe->inward, &probe->search, way);
    if (result == SS_EXIT_UNFINISHED) {
        return false;
    }
    probe->search.is_begun = false;
    if (result == SS_EXIT_NONE) {
        const int64_t twice = 2 * probe->steps_unplaced + every;
        probe->next_search =
            twice < probe->steps_unplaced + most ? twice : probe->steps_unplaced + most;
        return false;
    }
    probe->inward_restart_count = target->restart_count; /* that start has been made */
    *inout_pose = probe->search.from;
    ss_add3(inout_pose->position, inout_pose->position, way);
    probe->is_found_inside = ss_normalize3(way) > 0.0;
    probe->found_entries = target->entries;
    ss_copy3(probe->outward, way);
    return true;
}

/* No hand moves or turns a tool faster: one that jumps in one period catches up at hand speed. */
static void limit_tool_speed(const ss_tool_pose *last, double period, ss_tool_pose *inout_to)
{
    double way[3], turn[3];
    ss_sub3(way, inout_to->position, last->position);
    ss_turn_between(last->orientation, inout_to->orientation, turn);
    const double length = ss_norm3(way), max_move = MAX_TOOL_SPEED * period;
    const double angle = ss_norm3(turn), max_turn = MAX_TOOL_TURN * period;
    if (length > max_move) {
        ss_madd3(inout_to->position, last->position, max_move / length, way);
    }
    if (angle > max_turn) {
        ss_tool_pose turned;
        ss_tool_pose_blend(last, inout_to, max_turn / angle, &turned);
        memcpy(inout_to->orientation, turned.orientation, sizeof turned.orientation);
    }
}

/* What is near is told from so far away, m. */
static double near_distance(const ss_world *world, const double velocity[3])
{
    const double span = (LAG_PERIODS + 1.0) * world->step_period;
    return fmax(NEAR_M, 0.5 * HAND_ACCELERATION * span * span) + ss_norm3(velocity) * span;
}

/* Where tool p goes during this step: swept from the last predicted proxy to the new one, or
 * placed there when it has just come. After a reset or resume it is out of the model until the
 * haptic loop, which ramps its force down first, has placed it again: a body at rest is never
 * struck by a tool that stood deep in what it was, nor by one that moved under pause. */
static ss_model_tool plan_tool(ss_world *world, int32_t p, double velocity[3])
{
    ss_world_probe *probe = &world->probe[p];
    const ss_proxy_target *target = &probe->step_target;
    ss_model_tool tool = {.is_present = target->is_present, .is_grasping = target->is_grasping};
    const bool is_same = probe->was_present && probe->last_teleports == target->teleports;
    ss_set3(velocity, 0.0, 0.0, 0.0);
    probe->was_present = false;
    probe->is_found_inside =
        is_same && probe->is_found_inside && probe->found_entries == target->entries;
    if (!target->is_present || target->restart_count != world->simulation_run.restart_count ||
        (world->simulation_run.is_paused && !is_same)) {
        probe->steps_unplaced = 0;
        return (ss_model_tool){.is_present = false};
    }
    ss_haptic_predict(target, LAG_PERIODS, world->step_period, tool.to.position);
    ss_haptic_predict_turn(target, LAG_PERIODS, world->step_period, tool.to.orientation);
    if (probe->is_found_inside) {
        tool.to = probe->last;
    } else if (is_same) {
        limit_tool_speed(&probe->last, world->step_period, &tool.to);
    } else if (!find_free_pose(world, p, &tool.to)) {
        probe->last_teleports = target->teleports;
        ++probe->steps_unplaced;
        return (ss_model_tool){.is_present = false};
    }
    tool.from = is_same ? probe->last : tool.to;
    ss_sub3(velocity, tool.to.position, tool.from.position);
    ss_scale3(velocity, velocity, 1.0 / world->step_period);
    probe->steps_unplaced = 0;
    probe->was_present = true;
    probe->last_teleports = target->teleports;
    return tool;
}

/* A step that was slower than time, or none under pause, took the tool a share of its way: it
 * stands there, the next step goes on from there, and the haptic loop is told of that place. */
static void correct_for_travel(ss_world *world, ss_world_probe *probe, double travelled,
                               ss_model_tool *tool, double velocity[3])
{
    if (travelled < 1.0) {
        ss_model_reached(tool, travelled, &probe->last);
        tool->to = probe->last;
        ss_sub3(velocity, tool->to.position, tool->from.position);
        ss_scale3(velocity, velocity, 1.0 / world->step_period);
    }
    probe->last = tool->to;
}

/* Tissue that holds a tool off stays deformed for a while, and the tool pressed in against its
 * normal. What presses on a tool that went through says nothing of where it came from. */
static void note_touch(ss_world *world, ss_world_probe *probe)
{
    const ss_contact_set *set = &probe->computed.set;
    probe->is_pressed_in = set->count > 0 && ss_norm3(set->force) > 0.0;
    if (probe->is_pressed_in) {
        world->deformed_until = world->steps + (int64_t)ceil(DEFORMED_TIME / world->step_period);
    }
    if (probe->is_pressed_in && !ss_contact_is_inside(set)) {
        ss_scale3(probe->inward, set->normal, -1.0);
        probe->inward_restart_count = probe->step_target.restart_count;
        probe->inward_holders = probe->step_target.holders;
    }
}

/* What tool p touches; a model that slept through the step goes on to tell what it told. */
static void read_contacts(ss_world *world, int32_t p, const ss_model_tool *tool,
                          const double velocity[3], const ss_model_info *info, bool is_asleep)
{
    ss_world_probe *probe = &world->probe[p];
    ss_simulation_result *out = &probe->computed;
    const ss_contact_set last = out->set;
    *out = (ss_simulation_result){.tick = probe->step_target.tick,
                                  .step = world->steps,
                                  .period = world->step_period,
                                  .pose_seq = probe->step_target.pose_seq,
                                  .restart_count = world->simulation_run.restart_count,
                                  .is_fault = info->verdict == SOFTSIM_VERDICT_FAULT,
                                  .stored = info->kinetic + info->elastic,
                                  .load_work = info->load_work};
    out->has_stored = !world->model_class->has_no_energy && !out->is_fault;
    ss_copy3(out->proxy, probe->step_target.proxy);
    memcpy(out->orientation, probe->step_target.orientation, sizeof out->orientation);
    if (!tool->is_present) {
        out->set.inside_depth = probe->steps_unplaced > 0 ? fmax(0.0, probe->depth) : 0.0;
        return;
    }
    ss_copy3(out->proxy, tool->to.position);
    memcpy(out->orientation, tool->to.orientation, sizeof out->orientation);
    ss_copy3(out->velocity, velocity);
    out->is_found_inside = probe->is_found_inside;
    ss_copy3(out->outward, probe->outward);
    if (is_asleep) {
        out->set = last;
    } else {
        world->model_class->contacts(world->model, p, near_distance(world, velocity), &out->set);
    }
    note_touch(world, probe);
}

/* Where all tools go, and from how far away what is near is told. */
static void plan_tools(ss_world *world, ss_world_tools *out)
{
    *out = (ss_world_tools){0};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            out->tool[p] = plan_tool(world, p, out->velocity[p]);
            out->near[p] = near_distance(world, out->velocity[p]);
        }
    }
}

/* How tools and energies stand after a step that went that share of the way; returns how far the
 * tools went, m. Of a model that sleeps those that touch stand, the others go on. */
static double settle_tools(ss_world *world, ss_world_tools *tools, double travelled, bool is_asleep)
{
    double motion = 0.0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_model_tool *tool = &tools->tool[p];
        if (tool->is_present) {
            if (is_asleep && !ss_sleep_is_tool_free(world->sleep, p)) {
                tool->to = tool->from;
                ss_set3(tools->velocity[p], 0.0, 0.0, 0.0);
            }
            correct_for_travel(world, &world->probe[p], travelled, tool, tools->velocity[p]);
            motion += ss_tool_motion_bound(&world->scene->tool[p].shape, &tool->from, &tool->to);
        }
    }
    return motion;
}

static void watch_sleep(ss_world *world, const ss_world_tools *tools, const ss_model_info *info)
{
    const ss_contact_set *set[SOFTSIM_MAX_PROBES];
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        set[p] = &world->probe[p].computed.set;
    }
    ss_sleep_watch(world->sleep, (double)(world->steps - 1) * world->step_period, tools->tool,
                   tools->near, info, set);
}

void ss_world_step_compute(ss_world *world)
{
    const bool is_still =
        world->simulation_run.is_paused || world->energy.verdict == SOFTSIM_VERDICT_FAULT;
    const double time = (double)world->steps * world->step_period;
    ss_world_tools tools;
    plan_tools(world, &tools);
    const bool is_asleep =
        world->sleep && !is_still && ss_sleep_goes_on(world->sleep, time, tools.tool, tools.near);
    const bool is_stepped = !is_still && !is_asleep;
    const int64_t cpu_start = is_asleep ? 0 : ss_clock_thread_cpu_ns();
    ss_model_info info;
    if (is_stepped) {
        world->model_class->step(world->model, time, world->step_period, tools.tool);
    }
    world->steps += is_still ? 0 : 1;
    world->is_hashed = world->is_hashed && is_still;
    world->has_new_surface = world->has_new_surface || !is_asleep;
    world->model_class->info(world->model, &info);
    world->substeps += is_stepped ? info.substeps : 0;
    const double travelled = is_still ? 0.0 : is_asleep ? 1.0 : info.travelled;
    const double motion = settle_tools(world, &tools, travelled, is_asleep);
    if (!is_still) {
        ss_energy_watch_step(&world->energy, &info, motion, world->step_period);
    }
    ss_energy_watch_judge(&world->energy, &info);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (world->probe[p].is_used) {
            read_contacts(world, p, &tools.tool[p], tools.velocity[p], &info, is_asleep);
        }
    }
    if (is_stepped && world->sleep) {
        watch_sleep(world, &tools, &info);
    }
    ss_world_judge_sinking(world, &info);
    if (info.verdict > world->worst_verdict) {
        world->worst_verdict = info.verdict;
        world->worst_reason = info.reason;
    }
    if (!is_asleep) {
        ss_histogram_add(world->step_time, ss_clock_now_ns(),
                         1e-3 * (double)(ss_clock_thread_cpu_ns() - cpu_start));
    }
}

int64_t ss_world_idle_steps(const ss_world *world)
{
    if (!world->sleep || !ss_sleep_is_asleep(world->sleep) || ss_sleep_has_tool(world->sleep) ||
        ss_world_has_tool(world)) {
        return 0;
    }
    const double left = ss_sleep_until(world->sleep) - (double)world->steps * world->step_period;
    return isfinite(left) ? (int64_t)fmax(0.0, left / world->step_period - 1.0) : INT32_MAX;
}

void ss_world_skip_steps(ss_world *world, int64_t count)
{
    world->steps += count;
    world->is_hashed = false;
    ss_sleep_skip(world->sleep, count);
}

bool ss_world_has_tool(const ss_world *world)
{
    bool is_any = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const ss_world_probe *probe = &world->probe[p];
        const ss_proxy_target *target =
            probe->is_used ? ss_mailbox_take(probe->target, NULL) : NULL;
        is_any = is_any || (target && target->is_present);
    }
    return is_any;
}

static void post_surface(ss_world *world)
{
    ss_surface_snapshot *snapshot = ss_mailbox_draft(world->surface);
    const ss_real *u = world->model_class->displacement(world->model);
    const ss_drawn *drawn = &world->drawn;
    const int32_t node_count = drawn->node_count;
    snapshot->step = world->steps;
    for (int32_t i = 0; i < node_count; ++i) {
        const ptrdiff_t node = drawn->node ? drawn->node[i] : i;
        for (int32_t axis = 0; axis < 3; ++axis) {
            snapshot->number[3 * i + axis] = (float)u[4 * node + axis];
        }
    }
    const ss_model_potential *potential = world->model_class->potential;
    snapshot->has_source = potential != NULL && world->shown_field == SS_SCENE_FIELD_POTENTIAL;
    if (snapshot->has_source) {
        potential->tell(world->model, snapshot->number + 3 * (size_t)node_count);
    }
    ss_mailbox_post(world->surface);
}

void ss_world_step_post(ss_world *world)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_world_probe *probe = &world->probe[p];
        if (probe->is_used) {
            *(ss_simulation_result *)ss_mailbox_draft(probe->result) = probe->computed;
            ss_mailbox_post(probe->result);
        }
    }
    const int field = atomic_load_explicit(&world->field, memory_order_relaxed);
    if (world->surface && ++world->periods % world->snapshot_every == 0 &&
        (world->has_new_surface || field != world->shown_field)) {
        world->has_new_surface = false;
        world->shown_field = field;
        post_surface(world);
    }
    ss_simulation_stats *stats = ss_mailbox_draft(world->simulation_stats);
    ss_world_info(world, &stats->info);
    stats->is_paused = world->simulation_run.is_paused;
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
