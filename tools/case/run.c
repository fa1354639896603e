/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "case/norms.h"
#include "case/scratch.h"
#include "output.h"
#include "process.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"

enum { PATH_SIZE = 512, MAX_LOOKS = 4096, MAX_SUBSTEPS = 2000, CALM_LOOKS = 8 };
static const double ramp_phase = 3.14159265358979; /* omega t at the ramp's end */
static const double look_phase = 0.25;
static const double settled_left = 3e-4;
static const double longest_phase = 400.0;
static const double far_share = 10.0;  /* of the body's diagonal: further is diverged */
static const double pilot_share = 0.1; /* of the level */
static const double pilot_phase = 14.0;
static const double slowest_omega = 1.0; /* 1/s: what is slower is not waited for */
static const double least_phase = 3.0;   /* omega t after the ramp before anything is settled */

/* ---- files and scene ---- */

static softsim_status write_nodes(const char *folder, const char *name, int32_t count,
                                  const int32_t *node, softsim_error *error)
{
    char path[PATH_SIZE];
    ss_output output;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < count; ++i) {
        fprintf(output.file, "%d\n", node[i]);
    }
    return ss_output_commit(&output, error);
}

softsim_status ss_static_prepare(const ss_case_body *body, const char *folder, softsim_error *error)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/body.msh", folder);
    softsim_status status = ss_mesh_write_msh(body->mesh, path, error);
    if (status == SOFTSIM_OK && body->fixed_count > 0) {
        status = write_nodes(folder, "fixed.txt", body->fixed_count, body->fixed, error);
    }
    if (status == SOFTSIM_OK && body->pressed_count > 0) {
        status = write_nodes(folder, "pressed.txt", body->pressed_count, body->pressed, error);
    }
    return status;
}

static softsim_status write_push(const ss_static_plan *plan, double level, softsim_error *error)
{
    const ss_case_body *b = plan->body;
    char path[PATH_SIZE];
    ss_output output;
    snprintf(path, sizeof path, "%s/push.csv", plan->folder);
    const softsim_status status = ss_output_open(&output, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("node,ux,uy,uz\n", output.file);
    for (int32_t i = 0; i < b->pushed_count; ++i) {
        const double depth = level * b->profile[i];
        fprintf(output.file, "%d,%.17g,%.17g,%.17g\n", b->pushed[i], depth * plan->c->direction[0],
                depth * plan->c->direction[1], depth * plan->c->direction[2]);
    }
    return ss_output_commit(&output, error);
}

static softsim_status write_scene(const ss_static_plan *plan, double level, const double gravity[3],
                                  double ramp_s, softsim_error *error)
{
    const ss_case_body *b = plan->body;
    char path[PATH_SIZE];
    ss_output output;
    softsim_status status = b->pushed_count > 0 ? write_push(plan, level, error) : SOFTSIM_OK;
    snprintf(path, sizeof path, "%s/scene.yaml", plan->folder);
    if (status == SOFTSIM_OK) {
        status = ss_output_open(&output, path, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = output.file;
    fputs("softsim: 1\nobject:\n  mesh: body.msh\n  units: m\n", file);
    if (b->fixed_count > 0) {
        fputs("  fixed: [{nodes: fixed.txt}]\n", file);
    }
    fprintf(file,
            "model:\n%ssimulation: {max_substeps: %d, sleep: off}\npublish: {mesh_rate_hz: 0}\n"
            "gravity_m_s2: [%.17g, %.17g, %.17g]\n",
            plan->model, MAX_SUBSTEPS, gravity[0], gravity[1], gravity[2]);
    if (b->pushed_count > 0) {
        fprintf(file, "prescribed: [{displacement_file: push.csv, ramp_s: %.9g}]\n", ramp_s);
    }
    if (b->pressed_count > 0) {
        fprintf(file, "loads: [{nodes: pressed.txt, pressure_pa: %.17g, ramp_s: %.9g}]\n", level,
                ramp_s);
    }
    return ss_output_commit(&output, error);
}

/* The first fault without the temporary file's name and place. */
static void keep_reason(const softsim_error *refusal, char out[320])
{
    ss_plain_reason("refused: ", refusal->text, out, 320);
}

/* A world may have nodes of its own behind the body's (a layer's); those of the body must be where
 * they were written. Closes it when they are not. */
static softsim_status check_nodes(const ss_static_plan *plan, softsim_world **world,
                                  int32_t *out_count, char out_verdict[320], softsim_error *error)
{
    const ss_mesh *mesh = plan->body->mesh;
    const double near = 1e-5 * ss_mesh_diagonal(mesh);
    softsim_state state;
    softsim_read(*world, &state);
    double(*position)[3] = calloc((size_t)state.node_count + 1, sizeof *position);
    if (position == NULL) {
        softsim_destroy(world);
        return ss_memory_fault(error);
    }
    softsim_read_nodes(*world, position, NULL, NULL);
    bool is_same = state.node_count >= mesh->node_count;
    for (int32_t i = 0; i < mesh->node_count && is_same; ++i) {
        double d[3];
        ss_sub3(d, position[i], mesh->position[i]);
        is_same = ss_norm3(d) <= near;
    }
    free(position);
    *out_count = state.node_count;
    if (!is_same) {
        snprintf(out_verdict, 320, "refused: the world's nodes are not those of the mesh");
        softsim_destroy(world);
    }
    return SOFTSIM_OK;
}

/* NULL when refused, with the reason. *out_count: the world's nodes, the body's first. */
static softsim_status open_world(const ss_static_plan *plan, double level, const double gravity[3],
                                 double ramp_s, softsim_world **out_world, int32_t *out_count,
                                 char out_verdict[320], softsim_error *error)
{
    char path[PATH_SIZE];
    softsim_error refusal = {.status = SOFTSIM_OK};
    softsim_config config = softsim_default_config();
    *out_world = NULL;
    const softsim_status status = write_scene(plan, level, gravity, ramp_s, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    snprintf(path, sizeof path, "%s/scene.yaml", plan->folder);
    config.step_s = plan->step_s;
    *out_world = softsim_create(path, &config, &refusal);
    if (*out_world == NULL) {
        keep_reason(&refusal, out_verdict);
        return SOFTSIM_OK;
    }
    return check_nodes(plan, out_world, out_count, out_verdict, error);
}

static softsim_status stopped(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "stopped before the end");
    return SOFTSIM_ERROR_SYSTEM;
}

static double tick(softsim_world *world)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    const int64_t start = ss_clock_thread_cpu_ns();
    softsim_tick(world, NULL, &channel, 0, force);
    return 1e-3 * (double)(ss_clock_thread_cpu_ns() - start);
}

/* ---- settling ---- */

/* Fields kept to tell afterwards when the last one was near. */
typedef struct look {
    float (*u)[3];
    double cpu_ms;
} look;

typedef struct settling {
    const ss_static_plan *plan;
    softsim_world *world;
    ss_samples step_us;
    double (*u)[3], (*before)[3];
    look look[MAX_LOOKS];
    int32_t look_count, look_every, seen;
    double cpu_ms, change, left;
    int32_t calm;
} settling;

static bool keep_look(settling *s)
{
    const int32_t n = s->plan->body->mesh->node_count;
    if (s->seen++ % s->look_every != 0) {
        return true;
    }
    /* Full: every second one goes, and from here on every second one is kept. */
    const int32_t room = n > 0 ? (int32_t)fmax(32.0, fmin(MAX_LOOKS, 8e6 / n)) : MAX_LOOKS;
    if (s->look_count >= room) {
        for (int32_t k = 0; k < s->look_count; ++k) {
            if (k % 2 == 1) {
                free(s->look[k].u);
            } else {
                s->look[k / 2] = s->look[k];
            }
        }
        s->look_count = (s->look_count + 1) / 2;
        s->look_every *= 2;
    }
    look *at = &s->look[s->look_count];
    at->u = malloc((size_t)n * sizeof *at->u);
    at->cpu_ms = s->cpu_ms;
    if (at->u == NULL) {
        return false;
    }
    ++s->look_count;
    for (int32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            at->u[i][k] = (float)s->u[i][k];
        }
    }
    return true;
}

/* CPU time after which no kept field is further than 1 % from the last; NaN when the very last is
 * the first. Between two looks the logarithm of the distance is taken as linear. */
static double time_to_1pct(const settling *s)
{
    const int32_t n = s->plan->body->mesh->node_count;
    double(*u)[3] = calloc((size_t)n, sizeof *u);
    double after_ms = s->cpu_ms, after = 1e-6, out = (double)NAN;
    for (int32_t k = s->look_count - 1; k >= 0 && u != NULL; --k) {
        for (int32_t i = 0; i < n; ++i) {
            for (int c = 0; c < 3; ++c) {
                u[i][c] = (double)s->look[k].u[i][c];
            }
        }
        const double apart = fmax(ss_norms_apart(n, s->plan->body->weight, (const double(*)[3])u,
                                                 (const double(*)[3])s->u),
                                  1e-9);
        if (apart > 0.01) {
            const double part = after < 0.01 ? log(apart / 0.01) / log(apart / after) : 1.0;
            out = s->look[k].cpu_ms + part * (after_ms - s->look[k].cpu_ms);
            break;
        }
        after = apart;
        after_ms = s->look[k].cpu_ms;
    }
    free(u);
    return out;
}

/* Is the field finite and where a body can be? */
static bool is_sane(const settling *s)
{
    const int32_t n = s->plan->body->mesh->node_count;
    const double far = far_share * ss_mesh_diagonal(s->plan->body->mesh);
    for (int32_t i = 0; i < n; ++i) {
        if (!(ss_norm3(s->u[i]) <= far)) {
            return false;
        }
    }
    return true;
}

/* Judges the newest field against the one before. */
static void look_at(settling *s, bool may_settle)
{
    const int32_t n = s->plan->body->mesh->node_count;
    const double change = ss_norms_apart(n, s->plan->body->weight, (const double(*)[3])s->before,
                                         (const double(*)[3])s->u);
    const double ratio = s->change > 0.0 ? fmin(change / s->change, 0.98) : 0.98;
    s->left = isnan(change) ? (double)INFINITY : fmax(change, change * ratio / (1.0 - ratio));
    s->change = change;
    s->calm = may_settle && s->left < settled_left ? s->calm + 1 : 0;
}

static softsim_status run_to_rest(settling *s, softsim_state *state, bool *out_is_sane,
                                  softsim_error *error)
{
    const ss_static_plan *plan = s->plan;
    const int32_t look_ticks = (int32_t)fmax(1.0, round(look_phase / (plan->omega * plan->step_s)));
    const int32_t n = plan->body->mesh->node_count;
    const double calm_from = (ramp_phase + least_phase) / plan->omega;
    double time = 0.0;
    *out_is_sane = true;
    while (s->calm < CALM_LOOKS && time * plan->omega < longest_phase &&
           s->cpu_ms < 1e3 * plan->longest_cpu_s && *out_is_sane) {
        for (int32_t k = 0; k < look_ticks; ++k) {
            const double us = tick(s->world);
            ss_samples_add(&s->step_us, us);
            s->cpu_ms += 1e-3 * us;
        }
        time += look_ticks * plan->step_s;
        if (ss_process_is_stopped()) {
            return stopped(error);
        }
        memcpy(s->before, s->u, (size_t)n * sizeof *s->u);
        softsim_read_nodes(s->world, NULL, s->u, NULL);
        softsim_read(s->world, state);
        look_at(s, time > calm_from);
        *out_is_sane = is_sane(s) && state->verdict != SOFTSIM_VERDICT_FAULT;
        if (!keep_look(s)) {
            return ss_memory_fault(error);
        }
    }
    return SOFTSIM_OK;
}

static void judge(const settling *s, const softsim_state *state, bool is_settled,
                  ss_static_run *out)
{
    char *text = out->verdict;
    const size_t size = sizeof out->verdict;
    snprintf(text, size, "%s%s%.200s",
             out->is_good ? softsim_verdict_name(state->worst_verdict) : "diverged",
             *state->worst_reason != '\0' ? ": " : "", state->worst_reason);
    if (!out->is_good && *state->worst_reason == '\0') {
        snprintf(text, size, "diverged: a node is further than %g body sizes from its place",
                 far_share);
    }
    if (out->is_good && !is_settled) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "; not settled, about %.2g of the field is missing",
                 s->left);
    }
}

static softsim_status settle(settling *s, ss_static_run *out, softsim_error *error)
{
    softsim_state state;
    bool is_good = true;
    softsim_read(s->world, &state);
    softsim_status status = run_to_rest(s, &state, &is_good, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    out->is_good = is_good;
    out->left = s->left;
    out->ended = state.verdict;
    out->worst = state.worst_verdict;
    out->dt_s = s->plan->step_s;
    out->p50_us = ss_samples_quantile(&s->step_us, 0.5);
    out->p99_us = ss_samples_quantile(&s->step_us, 0.99);
    out->to_1pct_ms = is_good ? time_to_1pct(s) : (double)NAN;
    judge(s, &state, s->calm >= CALM_LOOKS, out);
    for (int32_t k = 0; k < softsim_prescribed_count(s->world) && is_good; ++k) {
        double force[3];
        softsim_read_reaction(s->world, k, force);
        ss_add3(out->force, out->force, force);
    }
    return SOFTSIM_OK;
}

/* What a run that was not refused needs. */
static softsim_status begin_settling(settling *s, int32_t nodes, softsim_error *error)
{
    const double longest = longest_phase / (s->plan->omega * s->plan->step_s) + 1000.0;
    s->look_every = 1;
    s->u = calloc((size_t)nodes, sizeof *s->u);
    s->before = calloc((size_t)nodes, sizeof *s->before);
    return s->u != NULL && s->before != NULL &&
                   ss_samples_init(&s->step_us, (int64_t)fmin(longest, 4e6))
               ? SOFTSIM_OK
               : ss_memory_fault(error);
}

softsim_status ss_static_execute(const ss_static_plan *plan, ss_static_run *out,
                                 softsim_error *error)
{
    double gravity[3];
    int32_t nodes = 0;
    *out = (ss_static_run){.to_1pct_ms = (double)NAN};
    ss_scale3(gravity, plan->c->gravity, plan->level);
    settling *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return ss_memory_fault(error);
    }
    s->plan = plan;
    softsim_status status = open_world(plan, plan->level, gravity, ramp_phase / plan->omega,
                                       &s->world, &nodes, out->verdict, error);
    out->is_refused = status == SOFTSIM_OK && s->world == NULL;
    if (status == SOFTSIM_OK && s->world != NULL) {
        status = begin_settling(s, nodes, error);
        status = status == SOFTSIM_OK ? settle(s, out, error) : status;
    }
    out->u = s->u;
    softsim_destroy(&s->world);
    for (int32_t k = 0; k < s->look_count; ++k) {
        free(s->look[k].u);
    }
    ss_samples_fini(&s->step_us);
    free(s->before);
    free(s);
    return status;
}

void ss_static_run_fini(ss_static_run *run)
{
    free(run->u);
    run->u = NULL;
}

/* ---- the pilot ---- */

/* Sums over looks, the time in units of looks: of u (= the integral s of u at the end), of s, of k
 * s by node; of |u|^2 and |s|^2, weighted. */
typedef struct pilot {
    double (*u)[3], (*integral)[3], (*sum)[3], (*moment)[3];
    uint8_t *is_driven;
    double place2, integral2;
    int32_t looks;
} pilot;

/* Phase from look to look: with m the mean of u, sqrt(<|u - m|^2> / <|s - m k - c|^2>), c the mean
 * of s - m k. */
static double pilot_rate(const pilot *p, const ss_case_body *body)
{
    const double n = p->looks, k1 = 0.5 * (n + 1.0), k2 = (n + 1.0) * (2.0 * n + 1.0) / 6.0;
    double place2 = p->place2 / n, integral2 = p->integral2 / n;
    for (int32_t i = 0; i < body->mesh->node_count; ++i) {
        double mean[3], middle[3], moment[3];
        ss_scale3(mean, p->integral[i], 1.0 / n);
        ss_scale3(middle, p->sum[i], 1.0 / n);
        ss_madd3(middle, middle, -k1, mean);
        ss_scale3(moment, p->moment[i], 1.0 / n);
        place2 -= body->weight[i] * ss_dot3(mean, mean);
        integral2 -= body->weight[i] * (2.0 * ss_dot3(mean, moment) - k2 * ss_dot3(mean, mean) +
                                        ss_dot3(middle, middle));
    }
    return place2 > 1e-9 * p->place2 / n && integral2 > 0.0 ? sqrt(place2 / integral2)
                                                            : (double)NAN;
}

static void pilot_look(pilot *p, softsim_world *world, const ss_case_body *body)
{
    ++p->looks;
    softsim_read_nodes(world, NULL, p->u, NULL);
    for (int32_t i = 0; i < body->mesh->node_count; ++i) {
        if (p->is_driven[i] == 0) {
            ss_add3(p->integral[i], p->integral[i], p->u[i]);
            ss_add3(p->sum[i], p->sum[i], p->integral[i]);
            ss_madd3(p->moment[i], p->moment[i], p->looks, p->integral[i]);
            p->place2 += body->weight[i] * ss_dot3(p->u[i], p->u[i]);
            p->integral2 += body->weight[i] * ss_dot3(p->integral[i], p->integral[i]);
        }
    }
}

static softsim_status fly(const ss_static_plan *plan, pilot *p, softsim_world *world,
                          double *out_omega, softsim_error *error)
{
    double cpu_ms = 0.0, time = 0.0, omega = (double)NAN;
    while (!(omega * time >= pilot_phase) && time * slowest_omega < pilot_phase &&
           cpu_ms < 1e3 * plan->longest_cpu_s) {
        cpu_ms += 1e-3 * tick(world);
        time += plan->step_s;
        if (ss_process_is_stopped()) {
            return stopped(error);
        }
        pilot_look(p, world, plan->body);
        omega = p->looks % 8 == 0 ? pilot_rate(p, plan->body) / plan->step_s : omega;
    }
    *out_omega = omega;
    return SOFTSIM_OK;
}

static softsim_status begin_pilot(pilot *p, const ss_case_body *body, int32_t nodes,
                                  softsim_error *error)
{
    const size_t n = (size_t)nodes;
    p->u = calloc(n, sizeof *p->u);
    p->integral = calloc(n, sizeof *p->integral);
    p->sum = calloc(n, sizeof *p->sum);
    p->moment = calloc(n, sizeof *p->moment);
    p->is_driven = calloc(n, 1);
    if (!p->u || !p->integral || !p->sum || !p->moment || !p->is_driven) {
        return ss_memory_fault(error);
    }
    for (int32_t i = 0; i < body->pushed_count; ++i) {
        p->is_driven[body->pushed[i]] = 1;
    }
    return SOFTSIM_OK;
}

softsim_status ss_static_measure(const ss_static_plan *plan, double *out_omega,
                                 softsim_error *error)
{
    double gravity[3];
    char verdict[320];
    int32_t nodes = 0;
    softsim_world *world = NULL;
    pilot p = {.u = NULL};
    *out_omega = (double)NAN;
    ss_scale3(gravity, plan->c->gravity, pilot_share * plan->level);
    softsim_status status = open_world(plan, pilot_share * plan->level, gravity, plan->step_s,
                                       &world, &nodes, verdict, error);
    if (status == SOFTSIM_OK && world != NULL) {
        status = begin_pilot(&p, plan->body, nodes, error);
        status = status == SOFTSIM_OK ? fly(plan, &p, world, out_omega, error) : status;
    }
    softsim_destroy(&world);
    SS_EACH(free, p.u, p.integral, p.sum, p.moment, p.is_driven);
    return status;
}

/* ---- free swing ---- */

softsim_status ss_static_swing(const ss_static_plan *plan, const double gravity[3], int32_t node,
                               int32_t count, double (*out_u)[3], int32_t *out_count,
                               char out_verdict[320], softsim_error *error)
{
    softsim_world *world = NULL;
    softsim_state state;
    double(*u)[3] = NULL;
    int32_t nodes = 0;
    *out_count = 0;
    softsim_status status =
        open_world(plan, plan->level, gravity, 0.0, &world, &nodes, out_verdict, error);
    if (status == SOFTSIM_OK && world != NULL) {
        u = calloc((size_t)nodes, sizeof *u);
        status = u != NULL ? SOFTSIM_OK : ss_memory_fault(error);
    }
    while (status == SOFTSIM_OK && world != NULL && *out_count < count) {
        tick(world);
        softsim_read_nodes(world, NULL, u, NULL);
        ss_copy3(out_u[(*out_count)++], u[node]);
        status = ss_process_is_stopped() ? stopped(error) : SOFTSIM_OK;
    }
    if (status == SOFTSIM_OK && world != NULL) {
        softsim_read(world, &state);
        snprintf(out_verdict, 320, "%s%s%.200s", softsim_verdict_name(state.worst_verdict),
                 *state.worst_reason != '\0' ? ": " : "", state.worst_reason);
    }
    softsim_destroy(&world);
    free(u);
    return status;
}
