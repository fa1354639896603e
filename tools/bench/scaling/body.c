/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/scaling/body.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/child.h"
#include "bench/core/static_cnn.h"
#include "case/norms.h"
#include "mesh/mesh.h"
#include "output.h"
#include "process.h"
#include "rt/clock.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "softsim/log.h"
#include "softsim/softsim.h"

/* m, s: the ellipsoid's half axes along x and z, the sphere, the path. */
static const double half_x = 0.050, half_z = 0.030;
static const double radius = 0.005, depth = 0.006, clearance = 0.003;
static const double slide_m = 0.030, speed = 0.050, speed_ramp_s = 0.05;
static const double wait_s = 0.2, move_s = 0.3, rest_s = 0.5;
static const double settle_s = 0.5; /* under the sphere that has stopped */
static const double load_s = 1.0, load_ramp_s = 0.2, load_n = 0.2;
static const double short_load_s = 0.2, short_ramp_s = 0.02;
/* The local poke: m of the loaded patch, N, s; a surface larger than this has the same edges. */
static const double patch_radius = 0.010, poke_n = 0.1, pull_n = 0.5, poke_s = 0.6;
static const double poke_pretension_j = 0.05;
/* The material; the level below which the body is held, m before scaling. */
static const double modulus_j = 5.0, pretension_j = 0.5, enclosed_bulk_pa = 2000.0;
static const double rest_stiffness = 5e4, held_below = -0.022;
enum { POKE_POINTS = 1192, LONG_POINTS = 10000 };
enum { PATH_SIZE = 256, LOOK_TICKS = 10, MAX_TICKS = 10000 };
static const double tick_s = 1e-3;
static const double mesh_timeout_s = 600.0;

static const char object_text[] = "softsim: 1\n"
                                  "object:\n"
                                  "  mesh: body.msh\n"
                                  "  units: mm\n"
                                  "  transform: {scale: %.9g}\n"
                                  "  fixed: [{box_m: [[-9, -9, -9], [9, 9, %.9g]]}]\n"
                                  "model:\n"
                                  "  name: cnn-energy\n"
                                  "  modulus_j: %.9g\n"
                                  "  pretension_j: %.9g\n"
                                  "  enclosed_bulk_pa: %.9g\n"
                                  "  rest_stiffness_n_per_m3: %.9g\n";
static const char model_text[] = "  area_density_kg_m2: 11.5\n"
                                 "  damping_n_s_per_m3: 1725\n"
                                 "simulation: {rate_hz: 1000, sleep: off}\n"
                                 "publish: {mesh_rate_hz: 0}\n";

/* ---- files ---- */

static void file_name(const ss_body *body, const char *name, char out[PATH_SIZE])
{
    snprintf(out, PATH_SIZE, "%s/%s", body->folder, name);
}

/* What of a scene differs: the body's size and tension, is all of it active, what is done to it. */
typedef struct deed {
    const char *name, *action;
    double scale, pretension_j;
    bool is_whole;
    double force_n, reach; /* down, on the nodes within `reach` (m) of the top, or it alone */
    double ramp_s;
} deed;

static bool is_loaded(const ss_body *body, const deed *what, int32_t node)
{
    double way[3];
    ss_sub3(way, body->rest[node], body->rest[body->top_node]);
    return node == body->top_node || what->scale * ss_norm3(way) < what->reach;
}

static void write_load(FILE *file, const ss_body *body, const deed *what)
{
    fprintf(file, "loads:\n  - {nodes: [%d", body->top_node);
    for (int32_t i = 0; i < body->node_count; ++i) {
        if (i != body->top_node && is_loaded(body, what, i)) {
            fprintf(file, ", %d", i);
        }
    }
    fprintf(file, "], force_n: [0, 0, %g], from_s: 0, ramp_s: %g}\n", -what->force_n, what->ramp_s);
}

static softsim_status write_scene(const ss_body *body, const deed *what, softsim_error *error)
{
    char path[PATH_SIZE];
    ss_output output;
    file_name(body, what->name, path);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(output.file, object_text, what->scale, held_below * what->scale, modulus_j,
            what->pretension_j, enclosed_bulk_pa, rest_stiffness);
    fprintf(output.file, "%s%s%s", what->is_whole ? "  window_tolerance: 0\n" : "", model_text,
            what->action != NULL ? what->action : "");
    if (what->force_n != 0.0) {
        write_load(output.file, body, what);
    }
    return ss_output_commit(&output, error);
}

/* 0 to 1 with no jump of speed. */
static double smooth(double s)
{
    const double t = s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
    return t * t * (3.0 - 2.0 * t);
}

/* Parameter t at which the slide begins: half of it before the top. */
static double first_angle(void)
{
    double angle = 0.0;
    const double step_m = slide_m / 10000.0;
    for (int i = 0; i < 5000; ++i) {
        angle -= step_m / hypot(half_x * cos(angle), half_z * sin(angle));
    }
    return angle;
}

/* Centre of the sphere whose lowest point is `gap` above the surface. */
static void centre_at(double angle, double gap, double out[3])
{
    const double nx = sin(angle) / half_x;
    const double nz = cos(angle) / half_z;
    const double offset = (radius + gap) / hypot(nx, nz);
    ss_set3(out, half_x * sin(angle) + offset * nx, 0.0, half_z * cos(angle) + offset * nz);
}

static softsim_status write_path(ss_body *body, softsim_error *error)
{
    char path[PATH_SIZE];
    ss_output output;
    file_name(body, "path.csv", path);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n", output.file);
    const double press_s = wait_s;
    const double slide_s = press_s + move_s + wait_s;
    const double slid_s = slide_s + slide_m / speed + speed_ramp_s;
    const double leave_s = slid_s + settle_s;
    const double end_s = leave_s + move_s + rest_s;
    body->slide_begin_s = slide_s + speed_ramp_s;
    body->slide_end_s = slid_s - speed_ramp_s;
    body->leave_s = leave_s;
    double angle = first_angle();
    for (int64_t k = 0; (double)k * tick_s < end_s; ++k) {
        const double time_s = (double)k * tick_s;
        const double down =
            smooth((time_s - press_s) / move_s) - smooth((time_s - leave_s) / move_s);
        double centre[3];
        centre_at(angle, clearance - (clearance + depth) * down, centre);
        fprintf(output.file, "%.9g,0,%.12g,%.12g,%.12g,1,0,0,0,0\n", time_s, centre[0], centre[1],
                centre[2]);
        const double along = smooth((time_s - slide_s) / speed_ramp_s) -
                             smooth((time_s - slid_s + speed_ramp_s) / speed_ramp_s);
        angle += along * speed * tick_s / hypot(half_x * cos(angle), half_z * sin(angle));
    }
    return ss_output_commit(&output, error);
}

softsim_status ss_body_open(ss_body *body, softsim_error *error)
{
    *body = (ss_body){.top_node = -1};
    softsim_status status = ss_scratch_make("softsim-bench", body->folder, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (!ss_child_own_folder(body->bin, sizeof body->bin)) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "cannot find this program's own folder");
        return SOFTSIM_ERROR_SYSTEM;
    }
    status = write_path(body, error);
    if (status == SOFTSIM_OK) {
        static const deed slide = {
            .name = "slide.yaml",
            .action = "contact:\n"
                      "  tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]\n"
                      "  working_force_n: 2\n"
                      "haptic: {between_steps: local, rate_hz: 1000, max_force_n: 8}\n",
            .scale = 1.0,
            .pretension_j = pretension_j};
        status = write_scene(body, &slide, error);
    }
    return status;
}

void ss_body_close(ss_body *body)
{
    ss_scratch_remove(body->folder);
    free(body->rest);
    free(body->triangle);
    body->rest = NULL;
    body->triangle = NULL;
    body->folder[0] = '\0';
}

softsim_status ss_body_make(ss_body *body, int32_t points, softsim_error *error)
{
    char program[sizeof body->bin + 16], count[16], mesh[PATH_SIZE], log[PATH_SIZE];
    body->points = points;
    body->top_node = -1;
    snprintf(program, sizeof program, "%s/softsim-mesh", body->bin);
    snprintf(count, sizeof count, "%d", points);
    file_name(body, "body.msh", mesh);
    file_name(body, "mesh.log", log);
    const char *const argv[] = {program,     "generate",  "ellipsoid", "--points", count,
                                "--size-mm", "100,60,60", "--out",     mesh,       NULL};
    const ss_child_plan plan = {.name = "softsim-mesh", .argv = argv, .err_path = log};
    const int result = ss_child_run(&plan, mesh_timeout_s);
    if (result == 0) {
        return SOFTSIM_OK;
    }
    char line[256] = "";
    FILE *file = fopen(log, "re");
    if (file != NULL && fgets(line, sizeof line, file) == NULL) {
        line[0] = '\0';
    }
    if (file != NULL) {
        fclose(file);
    }
    line[strcspn(line, "\n")] = '\0';
    softsim_error_add(error, SOFTSIM_ERROR_SYSTEM,
                      "softsim-mesh generate ellipsoid --points %d: %s", points,
                      ss_process_is_stopped() ? "stopped"
                      : result == 127         ? "it is not beside softsim-bench"
                                              : line);
    return SOFTSIM_ERROR_SYSTEM;
}

/* ---- runs ---- */

typedef struct runner {
    softsim_world *world;
    ss_body_run *out;
    double largest_j; /* stored */
    double force_sum, jump_n;
    int64_t force_count;
    double last_force[3];
    bool has_force;
    bool was_measured;
    int64_t measured; /* ticks */
    double substeps;  /* of the measured ticks */
} runner;

static void keep_first_line(char *out, size_t size, const char *text)
{
    snprintf(out, size, "%.*s", (int)strcspn(text, "\n"), text);
}

/* The energy now; called now and then, since reading sorts out percentiles. */
static void look(runner *r)
{
    softsim_state state;
    softsim_read(r->world, &state);
    r->largest_j = fmax(r->largest_j, state.elastic_j + state.kinetic_j);
}

/* Creates the world; a refused scene is a result. */
static softsim_status begin(runner *r, const ss_body *body, const char *scene, ss_body_run *out,
                            softsim_error *error)
{
    char path[PATH_SIZE];
    softsim_error refusal = {.status = SOFTSIM_OK};
    const softsim_config config = softsim_default_config();
    file_name(body, scene, path);
    *r = (runner){.out = out};
    *out = (ss_body_run){
        .jump = NAN, .mean_force = NAN, .balance = NAN, .step_us = NAN, .direct_error = NAN};
    if (!ss_samples_init(&out->tick_us, MAX_TICKS)) {
        return ss_memory_fault(error);
    }
    r->world = softsim_create(path, &config, &refusal);
    if (r->world == NULL) {
        out->is_refused = true;
        /* Without the temporary file's name. */
        ss_plain_reason("", refusal.text, out->reason, sizeof out->reason);
        return SOFTSIM_OK;
    }
    softsim_state state;
    softsim_read(r->world, &state);
    out->nodes = state.node_count;
    return SOFTSIM_OK;
}

static void finish(runner *r)
{
    if (r->world == NULL) {
        return;
    }
    softsim_state state;
    look(r);
    softsim_read(r->world, &state);
    r->out->worst = state.worst_verdict; /* of all steps, looked at or not */
    keep_first_line(r->out->reason, sizeof r->out->reason, state.worst_reason);
    r->out->step_us = state.step_us[0];
    r->out->active_nodes = state.active_nodes;
    r->substeps += r->was_measured ? (double)state.all_substeps : 0.0;
    r->out->substeps = r->substeps / (double)r->measured;
    if (r->largest_j > 0.0) {
        r->out->balance =
            (state.elastic_j + state.kinetic_j + state.dissipated_j - state.work_j) / r->largest_j;
    }
    if (r->force_count > 0) {
        r->out->mean_force = r->force_sum / (double)r->force_count;
        r->out->jump = r->jump_n / r->out->mean_force;
    }
    softsim_destroy(&r->world);
}

/* One tick; its thread CPU time is kept while `is_measured`. */
static void tick(runner *r, const softsim_pose *pose, int32_t count, bool is_measured,
                 softsim_force out_force[SOFTSIM_MAX_PROBES])
{
    const int32_t channel = 0;
    if (is_measured != r->was_measured) {
        softsim_state state;
        softsim_read(r->world, &state);
        r->substeps += (double)(is_measured ? -state.all_substeps : state.all_substeps);
        r->was_measured = is_measured;
    }
    const int64_t start_ns = ss_clock_thread_cpu_ns();
    softsim_tick(r->world, pose, &channel, count, out_force);
    const int64_t end_ns = ss_clock_thread_cpu_ns();
    if (is_measured) {
        ss_samples_add(&r->out->tick_us, 1e-3 * (double)(end_ns - start_ns));
        ++r->measured;
    }
}

static void take_slide_force(runner *r, const double force[3])
{
    if (r->has_force) {
        double change[3];
        ss_sub3(change, force, r->last_force);
        r->jump_n = fmax(r->jump_n, ss_norm3(change));
    }
    ss_copy3(r->last_force, force);
    r->has_force = true;
    r->force_sum += ss_norm3(force);
    ++r->force_count;
}

/* The body at rest: its node that is highest, and its triangles. */
static softsim_status read_rest(ss_body *body, softsim_world *world, int32_t nodes,
                                softsim_error *error)
{
    const size_t triangles = (size_t)softsim_triangle_count(world);
    free(body->rest);
    free(body->triangle);
    body->rest = calloc((size_t)nodes, sizeof *body->rest);
    body->triangle = calloc(triangles, sizeof *body->triangle);
    if (body->rest == NULL || body->triangle == NULL) {
        return ss_memory_fault(error);
    }
    softsim_read_nodes(world, body->rest, NULL, NULL);
    memcpy(body->triangle, softsim_triangles(world), triangles * sizeof *body->triangle);
    body->triangle_count = (int32_t)triangles;
    body->node_count = nodes;
    body->top_node = 0;
    for (int32_t i = 1; i < nodes; ++i) {
        body->top_node = body->rest[i][2] > body->rest[body->top_node][2] ? i : body->top_node;
    }
    return SOFTSIM_OK;
}

static softsim_status stopped(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "stopped before the end; nothing is reported");
    return SOFTSIM_ERROR_SYSTEM;
}

/* Where every node is now. */
static softsim_status keep_displacement(const runner *r, softsim_error *error)
{
    ss_body_run *out = r->out;
    out->displacement = calloc((size_t)out->nodes, sizeof *out->displacement);
    if (out->displacement == NULL) {
        return ss_memory_fault(error);
    }
    softsim_read_nodes(r->world, NULL, out->displacement, NULL);
    return SOFTSIM_OK;
}

/* The whole path; where the body and the sphere are just before it leaves is kept. */
static softsim_status play_path(runner *r, const ss_body *body, const softsim_path *path,
                                double out_sphere[3], softsim_error *error)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_pose pose;
    double time_s = 0.0;
    double end_s = 0.0;
    softsim_path_range(path, 0, &time_s, &end_s);
    for (int32_t k = 1; k < MAX_TICKS && softsim_path_sample(path, 0, time_s, &pose); ++k) {
        const bool is_sliding = time_s >= body->slide_begin_s && time_s <= body->slide_end_s;
        softsim_poses_restamp(&pose, 1, k);
        pose.utime_us = (int64_t)k * 1000;
        tick(r, &pose, 1, is_sliding, force);
        if (is_sliding) {
            take_slide_force(r, force[0].force);
        }
        if (k % LOOK_TICKS == 0) {
            look(r);
        }
        if (ss_process_is_stopped()) {
            return stopped(error);
        }
        time_s = (double)k * tick_s;
        if (r->out->displacement == NULL && time_s >= body->leave_s) {
            const softsim_status status = keep_displacement(r, error);
            if (status != SOFTSIM_OK) {
                return status;
            }
            ss_copy3(out_sphere, force[0].proxy);
        }
    }
    return SOFTSIM_OK;
}

/* ---- against a direct solve ---- */

/* What a direct solve is told of a deed, a value a node. */
typedef struct twin {
    double (*rest)[3], (*force)[3], (*u)[3];
    double *weight;
    uint8_t *is_held, *is_given;
} twin;

static void fini_twin(twin *t)
{
    void *const parts[] = {t->rest, t->force, t->u, t->weight, t->is_held, t->is_given};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        free(parts[k]);
    }
}

static softsim_status init_twin(twin *t, const ss_body *body, double scale, const ss_body_run *run,
                                softsim_error *error)
{
    const size_t n = (size_t)body->node_count;
    *t = (twin){.rest = calloc(n, sizeof *t->rest),
                .force = calloc(n, sizeof *t->force),
                .u = calloc(n, sizeof *t->u),
                .weight = calloc(n, sizeof *t->weight),
                .is_held = calloc(n, 1),
                .is_given = calloc(n, 1)};
    if (!t->rest || !t->force || !t->u || !t->weight || !t->is_held || !t->is_given) {
        return ss_memory_fault(error);
    }
    memcpy(t->u, run->displacement, n * sizeof *t->u);
    for (size_t i = 0; i < n; ++i) {
        ss_scale3(t->rest[i], body->rest[i], scale);
        t->is_held[i] = body->rest[i][2] <= held_below;
    }
    return SOFTSIM_OK;
}

/* Weights to a sum of 1, the direct solution, and how far the run is from it, or why there is none:
 * one that fails is a result too. */
static void compare(twin *t, const ss_body *body, double tension_j, ss_body_run *run)
{
    softsim_error failure = {.status = SOFTSIM_OK};
    double sum = 0.0;
    for (int32_t i = 0; i < body->node_count; ++i) {
        sum += t->weight[i];
    }
    for (int32_t i = 0; i < body->node_count; ++i) {
        t->weight[i] /= sum;
    }
    const ss_static_cnn_problem problem = {.node_count = body->node_count,
                                           .triangle_count = body->triangle_count,
                                           .rest = (const double(*)[3])t->rest,
                                           .triangle = (const int32_t(*)[3])body->triangle,
                                           .modulus = modulus_j,
                                           .pretension = tension_j,
                                           .bulk = enclosed_bulk_pa,
                                           .rest_stiffness = rest_stiffness,
                                           .is_held = t->is_held,
                                           .is_given = t->is_given,
                                           .weight = t->weight,
                                           .force = (const double(*)[3])t->force};
    if (ss_static_cnn_solve(&problem, t->u, &failure) != SOFTSIM_OK) {
        keep_first_line(run->direct_reason, sizeof run->direct_reason, failure.text);
        return;
    }
    run->direct_error =
        ss_norms_compute(body->node_count, NULL, (const double(*)[3])run->displacement,
                         (const double(*)[3])t->u)
            .peak;
}

/* The nodes of `what`, the force shared by them, each a cell of the source. */
static softsim_status compare_load(const ss_body *body, const deed *what, ss_body_run *run,
                                   softsim_error *error)
{
    twin t = {.rest = NULL};
    const softsim_status status = init_twin(&t, body, what->scale, run, error);
    if (status == SOFTSIM_OK) {
        int32_t count = 0;
        for (int32_t i = 0; i < body->node_count; ++i) {
            t.weight[i] = is_loaded(body, what, i) ? 1.0 : 0.0;
            count += is_loaded(body, what, i);
        }
        for (int32_t i = 0; i < body->node_count; ++i) {
            t.force[i][2] = -what->force_n * t.weight[i] / count;
        }
        compare(&t, body, what->pretension_j, run);
    }
    fini_twin(&t);
    return status;
}

/* Weights of the cells under the sphere, as server/contact/contact.h has them: four samples a
 * triangle, A/4 (1 - d/delta)+^2 each; they are touched, and so may be their neighbours, on which
 * the smooth surface under the sphere leans. */
static void weigh_sphere(const ss_body *body, const double sphere[3], double reach, twin *t)
{
    static const double row[4][3] = {{2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0},
                                     {1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0},
                                     {1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0},
                                     {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}};
    for (int32_t f = 0; f < body->triangle_count; ++f) {
        const int32_t *c = body->triangle[f];
        double u[3], v[3], n[3];
        ss_sub3(u, t->rest[c[1]], t->rest[c[0]]);
        ss_sub3(v, t->rest[c[2]], t->rest[c[0]]);
        ss_cross3(n, u, v);
        for (int s = 0; s < 4; ++s) {
            double way[3];
            ss_scale3(way, sphere, -1.0);
            for (int k = 0; k < 3; ++k) {
                ss_madd3(way, way, row[s][k], t->rest[c[k]]);
                ss_madd3(way, way, row[s][k], t->u[c[k]]);
            }
            const double g = fmax(0.0, 1.0 - (ss_norm3(way) - radius) / reach);
            for (int k = 0; k < 3; ++k) {
                const double w = t->is_held[c[k]] ? 0.0 : 0.125 * ss_norm3(n) * g * g * row[s][k];
                t->weight[c[k]] += w;
            }
        }
    }
    for (int32_t f = 0; f < body->triangle_count; ++f) {
        const int32_t *c = body->triangle[f];
        const double w = t->weight[c[0]] + t->weight[c[1]] + t->weight[c[2]];
        for (int k = 0; k < 3; ++k) {
            t->is_given[c[k]] = t->is_given[c[k]] || w > 0.0;
        }
    }
}

/* What the sphere touches stays where the run has it; the direct solve finds all the rest. */
static softsim_status compare_slide(const ss_body *body, const double sphere[3], ss_body_run *run,
                                    softsim_error *error)
{
    twin t = {.rest = NULL};
    const softsim_status status = init_twin(&t, body, 1.0, run, error);
    if (status == SOFTSIM_OK) {
        weigh_sphere(
            body, sphere,
            fmax(ss_mesh_mean_side((const double(*)[3])body->rest,
                                   (const int32_t(*)[3])body->triangle, body->triangle_count),
                 0.5 * radius),
            &t);
        compare(&t, body, pretension_j, run);
    }
    fini_twin(&t);
    return status;
}

softsim_status ss_body_slide(ss_body *body, ss_body_run *out, softsim_error *error)
{
    runner r;
    char path_name[PATH_SIZE];
    double sphere[3] = {0.0, 0.0, 0.0};
    softsim_path *path = NULL;
    softsim_status status = begin(&r, body, "slide.yaml", out, error);
    if (status != SOFTSIM_OK || r.world == NULL) {
        return status;
    }
    file_name(body, "path.csv", path_name);
    status = read_rest(body, r.world, out->nodes, error);
    if (status == SOFTSIM_OK) {
        status = softsim_path_load(path_name, &path, error);
    }
    if (status == SOFTSIM_OK) {
        status = play_path(&r, body, path, sphere, error);
    }
    softsim_path_free(&path);
    finish(&r);
    return status == SOFTSIM_OK ? compare_slide(body, sphere, out, error) : status;
}

/* From the body with nothing done to it. */
static softsim_status read_rest_alone(ss_body *body, ss_body_run *out, softsim_error *error)
{
    const deed alone = {
        .name = "load.yaml", .scale = 1.0, .pretension_j = pretension_j, .is_whole = true};
    runner r = {.world = NULL};
    softsim_status status = write_scene(body, &alone, error);
    if (status == SOFTSIM_OK) {
        status = begin(&r, body, alone.name, out, error);
    }
    if (status == SOFTSIM_OK && r.world != NULL) {
        status = read_rest(body, r.world, out->nodes, error);
        softsim_destroy(&r.world);
        ss_body_run_fini(out);
    }
    return status;
}

/* `duration_s` under the load of `what`, measured once it is full. */
static softsim_status run_load(const ss_body *body, const deed *what, double duration_s,
                               ss_body_run *out, softsim_error *error)
{
    runner r;
    softsim_force force[SOFTSIM_MAX_PROBES];
    softsim_status status = write_scene(body, what, error);
    if (status == SOFTSIM_OK) {
        status = begin(&r, body, what->name, out, error);
    }
    if (status != SOFTSIM_OK || r.world == NULL) {
        return status;
    }
    for (int32_t k = 1; (double)k * tick_s < duration_s; ++k) {
        tick(&r, NULL, 0, (double)k * tick_s > what->ramp_s, force);
        if (k % LOOK_TICKS == 0) {
            look(&r);
        }
        if (ss_process_is_stopped()) {
            status = stopped(error);
            break;
        }
    }
    if (status == SOFTSIM_OK) {
        status = keep_displacement(&r, error);
    }
    finish(&r);
    return status == SOFTSIM_OK ? compare_load(body, what, out, error) : status;
}

softsim_status ss_body_load(ss_body *body, ss_body_run *out, softsim_error *error)
{
    if (body->top_node < 0) {
        const softsim_status status = read_rest_alone(body, out, error); /* no slide */
        if (status != SOFTSIM_OK || out->is_refused) {
            return status;
        }
    }
    /* A fine mesh dents deep under one node and takes many sub-steps: no more steps than it needs
     * to come to rest. */
    const bool is_long = body->points > LONG_POINTS;
    const deed what = {.name = "load.yaml",
                       .scale = 1.0,
                       .pretension_j = pretension_j,
                       .is_whole = true,
                       .force_n = load_n,
                       .ramp_s = is_long ? short_ramp_s : load_ramp_s};
    return run_load(body, &what, is_long ? short_load_s : load_s, out, error);
}

static softsim_status load_patch(const ss_body *body, bool is_whole, double down_n,
                                 ss_body_run *out, softsim_error *error)
{
    const deed what = {.name = "load.yaml",
                       .scale = fmax(1.0, sqrt((double)body->points / POKE_POINTS)),
                       .pretension_j = poke_pretension_j,
                       .is_whole = is_whole,
                       .force_n = down_n,
                       .reach = patch_radius,
                       .ramp_s = load_ramp_s};
    return run_load(body, &what, poke_s, out, error);
}

softsim_status ss_body_poke(const ss_body *body, bool is_whole, ss_body_run *out,
                            softsim_error *error)
{
    return load_patch(body, is_whole, poke_n, out, error);
}

softsim_status ss_body_pull(const ss_body *body, ss_body_run *out, softsim_error *error)
{
    return load_patch(body, true, -pull_n, out, error);
}

double ss_body_apart(const ss_body_run *a, const ss_body_run *b)
{
    return a->displacement == NULL || b->displacement == NULL
               ? (double)NAN
               : ss_norms_compute(a->nodes, NULL, (const double(*)[3])a->displacement,
                                  (const double(*)[3])b->displacement)
                     .peak;
}

void ss_body_run_fini(ss_body_run *run)
{
    ss_samples_fini(&run->tick_us);
    free(run->displacement);
    run->displacement = NULL;
}
