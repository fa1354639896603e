/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "press.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "process.h"
#include "rt/vec.h"
#include "world/world.h"

enum {
    MAX_STEPS = 10000000, /* of one run */
    MAX_APPROACH = 2000,  /* steps to the first touch */
    MAX_SETS = 160
};
static const double CLEARANCE = 0.3; /* of the tool's inradius, before the approach */
static const double APPROACH = 0.05; /* of it, at a step */
static const double TOUCHING = 1e-3; /* of it: this near counts */
static const double THICKNESS = 0.9; /* of the body behind the point may be pressed through */
static const double PATCH_EDGES = 2.0;
static const double CENTRAL = 1.01; /* metres from the middle against metres from supports */

/* ---- the world ---- */

static ss_world *open_world(const ss_press_scene *scene, const char *patch, softsim_error *error)
{
    const char *set[MAX_SETS];
    int32_t count = 0;
    set[count++] = "simulation.sleep=off"; /* what is measured is where a press ends */
    for (int32_t i = 0; i < scene->set_count && count < MAX_SETS - 1; ++i) {
        set[count++] = scene->set[i];
    }
    if (patch) {
        set[count++] = patch;
    }
    const ss_world_options options = {
        .scene_path = scene->path, .set = set, .set_count = count, .is_lockstep = true};
    ss_world *world = NULL;
    ss_world_create(&options, &world, error);
    return world;
}

/* ---- place of the press ---- */

/* The middle of the box around the nodes. */
static void find_middle(const ss_mesh *mesh, double out[3])
{
    for (int k = 0; k < 3; ++k) {
        double low = INFINITY, high = -INFINITY;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            low = fmin(low, mesh->position[i][k]);
            high = fmax(high, mesh->position[i][k]);
        }
        out[k] = 0.5 * (low + high);
    }
}

/* How good a place node i is to press on: far from what is fixed (without anything fixed: high),
 * near the middle rather than out at a rim, flat rather than on an edge. */
static double merit_of(const ss_world *world, int32_t i, const double middle[3], double flatness)
{
    const ss_mesh *mesh = world->scene->mesh;
    double nearest = INFINITY, way[3];
    for (int32_t j = 0; j < mesh->node_count; ++j) {
        if (world->scene->fixed[j] != 0) {
            ss_sub3(way, mesh->position[i], mesh->position[j]);
            nearest = fmin(nearest, ss_dot3(way, way));
        }
    }
    ss_sub3(way, mesh->position[i], middle);
    const double far = isfinite(nearest) ? sqrt(nearest) : way[2];
    return flatness * far - CENTRAL * ss_norm3(way);
}

/* The free surface node nearest to `at`, or the best place there is. -1: none. */
static int32_t choose_node(const ss_world *world, const double *area, const double (*vector)[3],
                           const double *at)
{
    const ss_mesh *mesh = world->scene->mesh;
    int32_t chosen = -1;
    double best = -INFINITY, middle[3], way[3];
    find_middle(mesh, middle);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (!(area[i] > 0.0) || world->scene->fixed[i] != 0) {
            continue;
        }
        double merit = 0.0;
        if (at) {
            ss_sub3(way, mesh->position[i], at);
            merit = -ss_dot3(way, way);
        } else {
            merit = merit_of(world, i, middle, ss_norm3(vector[i]) / area[i]);
        }
        if (merit > best) {
            best = merit;
            chosen = i;
        }
    }
    return chosen;
}

/* Where the ray from `from` along `way` (unit) first meets the surface beyond `least`; INFINITY:
 * nowhere. */
static double cast(const ss_mesh *mesh, const double from[3], const double way[3], double least)
{
    double nearest = INFINITY;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double e1[3], e2[3], p[3], s[3], q[3];
        ss_sub3(e1, mesh->position[c[1]], mesh->position[c[0]]);
        ss_sub3(e2, mesh->position[c[2]], mesh->position[c[0]]);
        ss_cross3(p, way, e2);
        const double determinant = ss_dot3(e1, p);
        ss_sub3(s, from, mesh->position[c[0]]);
        ss_cross3(q, s, e1);
        const double u = ss_dot3(s, p) / determinant, v = ss_dot3(way, q) / determinant;
        const double distance = ss_dot3(e2, q) / determinant;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > least && distance < nearest) {
            nearest = distance;
        }
    }
    return nearest;
}

/* Tool vectors' z to `way`. */
static void turn_z(const double way[3], double out[4])
{
    if (way[2] < -1.0 + 1e-12) {
        out[0] = out[2] = out[3] = 0.0;
        out[1] = 1.0;
        return;
    }
    const double scale = 1.0 / sqrt(2.0 * (1.0 + way[2]));
    out[0] = (1.0 + way[2]) * scale;
    out[1] = -way[1] * scale;
    out[2] = way[0] * scale;
    out[3] = 0.0;
}

/* ---- distance from the curve ---- */

/* A place that is given must be on the surface, and free there: a unit mistaken, or a place of
 * another body, would otherwise press somewhere and fit to it. A mean edge of freedom. */
static softsim_status check_place(const ss_world *world, const double at[3], int32_t node,
                                  softsim_error *error)
{
    const ss_mesh *mesh = world->scene->mesh;
    const double edge =
        ss_mesh_mean_side((const double(*)[3])mesh->position, (const int32_t(*)[3])mesh->triangle,
                          mesh->triangle_count);
    double off = INFINITY, reach = edge, way[3];
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const double *corner[3];
        for (int k = 0; k < 3; ++k) {
            corner[k] = mesh->position[mesh->triangle[t][k]];
        }
        ss_contact_closest(at, corner[0], corner[1], corner[2], way);
        ss_sub3(way, way, at);
        const double distance = ss_norm3(way);
        if (distance < off) {
            off = distance;
            reach = edge;
            for (int k = 0; k < 3; ++k) { /* a large triangle's corners are far from its middle */
                ss_sub3(way, corner[(k + 1) % 3], corner[k]);
                reach = fmax(reach, ss_norm3(way));
            }
        }
    }
    ss_sub3(way, mesh->position[node], at);
    if (off > edge) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--at: %.6g,%.6g,%.6g is %.4g m off the surface, more than a mean edge "
                          "(%.4g m); give a place on it, in metres and where the scene puts the "
                          "body: the nearest free node is at %.6g,%.6g,%.6g",
                          at[0], at[1], at[2], off, edge, mesh->position[node][0],
                          mesh->position[node][1], mesh->position[node][2]);
    } else if (ss_norm3(way) > off + reach) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--at: at %.6g,%.6g,%.6g the surface is fixed; the nearest free node is "
                          "%.4g m away, at %.6g,%.6g,%.6g",
                          at[0], at[1], at[2], ss_norm3(way), mesh->position[node][0],
                          mesh->position[node][1], mesh->position[node][2]);
    } else {
        return SOFTSIM_OK;
    }
    return SOFTSIM_ERROR_ARGUMENT;
}

/* ---- tool ---- */

static void place_tool(const ss_press *press, double depth, ss_tool_pose *out)
{
    ss_madd3(out->position, press->point, press->touch - depth, press->normal);
    memcpy(out->orientation, press->orientation, sizeof out->orientation);
}

/* Least distance of nodes and triangle centres from the placed tool. */
static double sampled_distance(const ss_mesh *mesh, const ss_shape *shape, const ss_tool_pose *pose)
{
    double least = INFINITY, normal[3];
    for (int32_t i = 0; i < mesh->node_count + mesh->triangle_count; ++i) {
        double x[3] = {0.0, 0.0, 0.0}, local[3];
        if (i < mesh->node_count) {
            ss_copy3(x, mesh->position[i]);
        } else {
            for (int k = 0; k < 3; ++k) {
                ss_madd3(x, x, 1.0 / 3.0, mesh->position[mesh->triangle[i - mesh->node_count][k]]);
            }
        }
        ss_sub3(x, x, pose->position);
        ss_rotate_back(local, pose->orientation, x);
        least = fmin(least, ss_shape_distance(shape, local, normal));
    }
    return least;
}

/* Brings the tool from outside to where the model first sees it touch. */
static bool approach(ss_world *world, ss_press *press)
{
    const ss_shape *shape = &world->scene->tool[press->probe].shape;
    const double size = ss_shape_inradius(shape);
    const double clearance = CLEARANCE * size;
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    ss_model_tool *mine = &tool[press->probe];
    ss_contact_set set;
    press->touch = ss_shape_bounding_radius(shape) + clearance;
    for (int k = 0; k < MAX_APPROACH; ++k) {
        place_tool(press, 0.0, &mine->to);
        const double distance = sampled_distance(world->scene->mesh, shape, &mine->to);
        if (distance >= clearance) {
            break;
        }
        press->touch += clearance - distance + 1e-6 * size;
    }
    mine->is_present = true;
    for (int k = 0; k < MAX_APPROACH; ++k) {
        place_tool(press, 0.0, &mine->to);
        mine->from = mine->to;
        world->model_class->step(world->model, k * world->step_period, world->step_period, tool);
        world->model_class->contacts(world->model, press->probe, clearance, &set);
        const double gap = -set.depth;
        if (set.count > 0 && gap <= TOUCHING * size) {
            press->touch -= gap;
            return true;
        }
        press->touch -= fmin(set.count > 0 ? fmax(gap, 0.0) : APPROACH * size, APPROACH * size);
        if (press->touch < -2.0 * ss_shape_bounding_radius(shape)) {
            break;
        }
    }
    return false;
}

/* ---- patch ---- */

/* The free surface nodes near the point as a prescribed set, in the file's numbers. */
static bool plan_patch(const ss_world *world, const double *area, ss_press *press)
{
    const ss_mesh *mesh = world->scene->mesh;
    const double reach = press->contact * (1.0 + 1e-9);
    size_t size = 0;
    FILE *stream = open_memstream(&press->patch, &size);
    if (!stream) {
        return false;
    }
    fputs("prescribed=[{nodes: [", stream);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        double way[3];
        ss_sub3(way, mesh->position[i], press->point);
        if (area[i] > 0.0 && world->scene->fixed[i] == 0 && ss_norm3(way) <= reach) {
            fprintf(stream, "%s%d", press->patch_count > 0 ? ", " : "", ss_mesh_file_node(mesh, i));
            ++press->patch_count;
        }
    }
    fprintf(stream, "], displacement_m: [%.17g, %.17g, %.17g], ramp_s: %.17g}]",
            -press->depth * press->normal[0], -press->depth * press->normal[1],
            -press->depth * press->normal[2], press->press_s);
    return fclose(stream) == 0;
}

/* ---- plan ---- */

static softsim_status refuse(softsim_error *error, const ss_press_scene *scene, const char *what)
{
    softsim_error_add(error, SOFTSIM_ERROR_SCENE, "%s: %s", scene->path, what);
    return SOFTSIM_ERROR_SCENE;
}

static softsim_status check_depth(const ss_world *world, ss_press *press, softsim_error *error)
{
    const ss_mesh *mesh = world->scene->mesh;
    double inward[3];
    ss_scale3(inward, press->normal, -1.0);
    const double diagonal = ss_mesh_diagonal(mesh);
    const double behind = cast(mesh, press->point, inward, 1e-6 * diagonal);
    press->limit = isfinite(behind) ? THICKNESS * behind : 0.5 * diagonal;
    if (press->depth > press->limit) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: a depth of %.4g m cannot be reached: the body is %.4g m %s at the "
                          "place of the press, %.4g %.4g %.4g; check the curve's unit, or choose "
                          "the place with --at",
                          world->scene->path, press->depth, isfinite(behind) ? behind : diagonal,
                          isfinite(behind) ? "thick" : "large", press->point[0], press->point[1],
                          press->point[2]);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return SOFTSIM_OK;
}

static softsim_status plan_in(ss_world *world, const ss_press_scene *scene, const double *at,
                              const double *area, const double (*vector)[3], ss_press *out,
                              softsim_error *error)
{
    const int32_t node = choose_node(world, area, vector, at);
    if (node < 0) {
        return refuse(error, scene, "every surface node is fixed; there is nothing to press on");
    }
    if (at && check_place(world, at, node, error) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    double inward[3];
    ss_copy3(out->point, world->scene->mesh->position[node]);
    ss_copy3(out->normal, vector[node]);
    if (!(ss_normalize3(out->normal) > 0.0)) {
        return refuse(error, scene,
                      "the surface has no normal where it is pressed; choose the "
                      "place with --at");
    }
    ss_scale3(inward, out->normal, -1.0);
    turn_z(inward, out->orientation);
    for (int32_t p = SOFTSIM_MAX_PROBES - 1; p >= 0; --p) {
        out->probe = world->scene->tool[p].is_used ? p : out->probe;
    }
    const ss_mesh *mesh = world->scene->mesh;
    out->edge = ss_mesh_mean_side((const double(*)[3])mesh->position,
                                  (const int32_t(*)[3])mesh->triangle, mesh->triangle_count);
    out->is_stiff = world->model_class->needs_volume && !world->model_class->takes_second_order;
    out->contact = PATCH_EDGES * out->edge;
    if (out->probe >= 0) {
        out->tool_radius = ss_shape_inradius(&world->scene->tool[out->probe].shape);
        out->contact = fmin(sqrt(out->tool_radius * out->depth), out->tool_radius);
    }
    const softsim_status status = check_depth(world, out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (out->probe < 0) {
        if (world->scene->prescribed_count > 0) {
            return refuse(error, scene,
                          "it has no tool, and softsim-fit presses a patch of its "
                          "own: remove `prescribed`, or add the tool");
        }
        return plan_patch(world, area, out) ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    }
    return approach(world, out) ? SOFTSIM_OK
                                : refuse(error, scene,
                                         "the tool does not come to touch the "
                                         "surface; choose the place with --at");
}

softsim_status ss_press_plan(const ss_press_scene *scene, const double *at, double depth,
                             double press_s, ss_press *out, softsim_error *error)
{
    *out = (ss_press){.probe = -1, .depth = depth, .press_s = press_s};
    ss_world *world = open_world(scene, NULL, error);
    if (!world) {
        return SOFTSIM_ERROR_SCENE;
    }
    const size_t nodes = (size_t)world->scene->mesh->node_count;
    double *area = calloc(nodes, sizeof *area);
    double(*vector)[3] = calloc(nodes, sizeof *vector);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (area && vector) {
        ss_mesh_node_areas(world->scene->mesh, area);
        ss_mesh_node_area_vectors(world->scene->mesh, vector);
        status = plan_in(world, scene, at, area, (const double(*)[3])vector, out, error);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "%s: out of memory", scene->path);
    }
    free(area);
    free(vector);
    ss_lockstep_stop(world);
    ss_world_destroy(&world);
    if (status != SOFTSIM_OK) {
        ss_press_fini(out);
    }
    return status;
}

void ss_press_fini(ss_press *press)
{
    free(press->patch);
    press->patch = NULL;
}

/* ---- a run ---- */

/* The force along the normal, after a step. */
static double read_force(const ss_world *world, const ss_press *press, ss_press_run *out_run)
{
    double force[3];
    if (press->probe < 0) {
        /* Of the support on the body, which pushes it in. */
        world->model_class->reaction(world->model, 0, force);
        return -ss_dot3(force, press->normal);
    }
    ss_contact_set set;
    world->model_class->contacts(world->model, press->probe, 0.0, &set);
    out_run->sunk = fmax(out_run->sunk, set.count > 0 ? set.depth : 0.0);
    return ss_dot3(set.force, press->normal);
}

static softsim_status run(ss_world *world, const ss_press *press, const ss_curve *curve,
                          double *out_force, ss_press_run *out_run, softsim_error *error)
{
    const double h = world->step_period;
    const double end = press->press_s + (curve->is_time ? curve->at[curve->count - 1] : 0.0);
    if (!(end / h < MAX_STEPS)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: %.4g s are more than %d steps of %.4g s; leave out the end of the "
                          "curve",
                          curve->path, end, MAX_STEPS, h);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_model_tool tool[SOFTSIM_MAX_PROBES] = {0};
    const double lead = curve->is_time ? press->press_s : 0.0;
    double last_at = -lead, last_force = 0.0;
    int32_t next = 0;
    ss_tool_pose reached;
    place_tool(press, 0.0, &reached);
    for (int32_t k = 0; next < curve->count; ++k) {
        if (ss_process_is_stopped()) {
            softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "stopped before the end");
            return SOFTSIM_ERROR_SYSTEM;
        }
        const double share = fmin((k + 1) * h / press->press_s, 1.0);
        if (press->probe >= 0) {
            ss_model_tool *mine = &tool[press->probe];
            mine->is_present = true;
            mine->from = reached;
            place_tool(press, share * press->depth, &mine->to);
        }
        world->model_class->step(world->model, k * h, h, tool);
        ss_model_info info;
        world->model_class->info(world->model, &info);
        if (press->probe >= 0) {
            ss_model_reached(&tool[press->probe], info.travelled, &reached);
        }
        if (info.verdict > out_run->verdict) {
            out_run->verdict = info.verdict;
            out_run->reason = info.reason;
        }
        const double force = read_force(world, press, out_run);
        if (info.verdict == SOFTSIM_VERDICT_FAULT || !isfinite(force)) {
            softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                              "%s: the model fails %.4g m into the press: %s", world->scene->path,
                              share * press->depth, info.reason);
            return SOFTSIM_ERROR_SCENE;
        }
        /* Between the states, linearly; the last one also for what rounding leaves behind. */
        const bool is_last = (k + 1) * h >= end * (1.0 - 1e-12);
        const double at = curve->is_time ? (k + 1) * h - lead : share * press->depth;
        for (; next < curve->count && (curve->at[next] <= at || is_last); ++next) {
            const double s = fmin((curve->at[next] - last_at) / (at - last_at), 1.0);
            out_force[next] = last_force + s * (force - last_force);
        }
        last_at = at;
        last_force = force;
    }
    return SOFTSIM_OK;
}

softsim_status ss_press_measure(const ss_press *press, const ss_press_scene *scene,
                                const ss_curve *curve, double *out_force, ss_press_run *out_run,
                                softsim_error *error)
{
    *out_run = (ss_press_run){.reason = ""};
    ss_world *world = open_world(scene, press->patch, error);
    if (!world) {
        return SOFTSIM_ERROR_SCENE;
    }
    const softsim_status status = run(world, press, curve, out_force, out_run, error);
    ss_lockstep_stop(world);
    ss_world_destroy(&world);
    return status;
}
