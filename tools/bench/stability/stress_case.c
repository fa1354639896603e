/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_case.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/stability/audit.h"
#include "bench/stability/hand.h"
#include "bench/stability/stress_scene.h"
#include "case/scratch.h"
#include "rt/clock.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "softsim/softsim.h"
#include "world/world.h"

enum { PATH_SIZE = 512, MIN_TICKS = 40 };
static const double haptic_tick_s = 1e-3;
/* Of the time that is waited: what rounding of ticks may take away. */
static const double rested_tau = 5.9;
static const double heavy = 1.5; /* a mass ratio beyond it is slower than tau */
/* Of E L^3: energies below are rounding. */
static const double floor_share = 1e-7;
static const double most_handed_out_j = 0.01, most_driven_j = 0.1;
/* Of the size: what single precision tells apart. */
static const double still_share = 1e-7;

const char *ss_stress_case_kind_name(ss_stress_case_kind kind)
{
    static const char *const name[SS_STRESS_CASE_KINDS] = {
        "control",       "step",     "single-step", "stiffness", "poisson",   "mass-ratio",
        "sliver",        "teleport", "force",       "tangled",   "flattened", "probe",
        "contradiction", "noise",    "in-out",      "through",   "spin",      "pause"};
    return name[kind];
}

const char *ss_stress_case_value_name(ss_stress_case_kind kind)
{
    static const char *const name[SS_STRESS_CASE_KINDS] = {
        "drive",
        "step over the computed limit",
        "step over the computed limit",
        "Young's modulus, Pa",
        "Poisson's ratio",
        "mass ratio",
        "height of an element, of its regular one",
        "body sizes in one step",
        "force on one node, N",
        "disorder, of E h^2 or h",
        "force, of E L^2, or height, of L",
        "speed, m/s",
        "case",
        "noise of the position, m",
        "in and out, Hz",
        "speed, m/s",
        "turns a second",
        "commands a second"};
    return name[kind];
}

const char *ss_stress_case_outcome_name(ss_stress_case_outcome outcome)
{
    static const char *const name[SS_STRESS_CASE_OUTCOMES] = {"stable", "guarded", "refused",
                                                              "diverged"};
    return name[outcome];
}

/* ---- files ---- */

typedef struct stress_case_folder {
    char path[PATH_SIZE - 32];
} stress_case_folder;

static void name_file(const stress_case_folder *folder, const char *name, char out[PATH_SIZE])
{
    snprintf(out, PATH_SIZE, "%s/%s", folder->path, name);
}

static softsim_status write_files(const stress_case_folder *folder, const ss_stress_case_plan *plan,
                                  softsim_error *error)
{
    char path[PATH_SIZE];
    name_file(folder, "body.msh", path);
    FILE *file = fopen(path, "we");
    if (file != NULL) {
        ss_specimen_write(&plan->specimen, file);
    }
    bool is_good = file != NULL && fclose(file) == 0;
    name_file(folder, "scene.yaml", path);
    file = is_good ? fopen(path, "we") : NULL;
    if (file != NULL) {
        ss_stress_case_plan_write(plan, file);
    }
    is_good = file != NULL && fclose(file) == 0;
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, strerror(errno));
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

/* The first line of a refusal without the folder and the place in the scene. */
static void keep_reason(const stress_case_folder *folder, const char *text, char *out, size_t size)
{
    const size_t length = strlen(folder->path);
    char reason[SOFTSIM_ERROR_TEXT_SIZE];
    size_t used = 0;
    ss_plain_reason("", text, reason, sizeof reason);
    for (const char *at = reason; *at != '\0' && used + 1 < size;) {
        const bool is_folder = strncmp(at, folder->path, length) == 0 && at[length] == '/';
        if (is_folder) {
            at += length + 1;
        } else {
            out[used++] = *at++;
        }
    }
    out[used] = '\0';
}

/* ---- a run ---- */

typedef struct runner {
    const ss_stress_case *trial;
    ss_stress_case_plan plan;
    stress_case_folder folder;
    softsim_world *world;
    ss_stress_case_result *out;
    ss_audit audit;
    ss_hand_sample *felt; /* SS_STRESS_CASE_MAX_TICKS */
    int32_t felt_count;
    ss_hand_account hand;
    double size_m;    /* the least extent of the body at rest, with what a model grows around it */
    int32_t commands; /* given so far */
    double period_s;
    int64_t steps;
    double first_stored, last_stored, released_s;
    int64_t all_substeps;
    int32_t nodes; /* the specimen's, and those that a model grows around it */
    double (*u)[3], (*v)[3], (*old)[3];
} runner;

/* What must be stable is not refused; but chains have no forces, and refuse them. */
static bool may_be_refused(const runner *r)
{
    return r->trial->kind != SS_STRESS_CASE_CONTROL ||
           (r->plan.drive == SS_STRESS_CASE_LOADS && ss_stress_case_is_plastic(r->trial->subject));
}

/* Creates the world; NULL world: refused, and the result says why. */
static softsim_status begin(runner *r, softsim_error *error)
{
    char path[PATH_SIZE];
    softsim_error refusal = {.status = SOFTSIM_OK};
    softsim_config config = softsim_default_config();
    const softsim_status status = write_files(&r->folder, &r->plan, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    config.step_s = r->plan.step_s;
    config.has_budget = true; /* judged as in real time */
    name_file(&r->folder, "scene.yaml", path);
    r->world = softsim_create(path, &config, &refusal);
    if (r->world == NULL && refusal.status == SOFTSIM_ERROR_MEMORY) {
        return ss_memory_fault(error);
    }
    if (r->world == NULL) {
        r->out->outcome = SS_STRESS_CASE_REFUSED;
        r->out->is_agreed = may_be_refused(r);
        keep_reason(&r->folder, refusal.text, r->out->acted, sizeof r->out->acted);
    }
    return SOFTSIM_OK;
}

/* The computed limit of the step, from a world of its own; models without one get the time in
 * which sound crosses an element. */
static softsim_status ask_limit(runner *r, softsim_error *error)
{
    const softsim_status status = begin(r, error);
    if (status == SOFTSIM_OK && r->world != NULL) {
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_state state;
        softsim_tick(r->world, NULL, NULL, 0, force);
        softsim_read(r->world, &state);
        softsim_destroy(&r->world);
        const double sound_s =
            SS_SPECIMEN_SIZE / SS_SPECIMEN_CELLS * sqrt(1000.0 / r->trial->stiffness_pa);
        r->out->limit_s = isfinite(state.stable_step_s) && state.stable_step_s > 0.0
                              ? state.stable_step_s
                              : sound_s;
        r->plan.step_s = r->trial->value * r->out->limit_s;
    }
    return status;
}

/* F.du of all loads in the step that ended at `time_s`: a load is taken at its middle. */
static double applied_work(const runner *r, double time_s)
{
    const ss_stress_case_plan *plan = &r->plan;
    const double middle_s = time_s - 0.5 * r->period_s;
    const double factor = middle_s >= plan->release_s ? 0.0
                          : plan->ramp_s > 0.0        ? fmin(1.0, middle_s / plan->ramp_s)
                                                      : 1.0;
    double work = 0.0;
    for (int32_t k = 0; k < plan->load_count; ++k) {
        const ss_stress_case_load *load = &plan->load[k];
        for (int32_t i = load->first; i < load->first + load->count; ++i) {
            double moved[3];
            ss_sub3(moved, r->u[i], r->old[i]);
            work += factor / load->count * ss_dot3(load->force, moved);
        }
    }
    return work;
}

static void look(runner *r, const double force[3])
{
    softsim_state state;
    softsim_read(r->world, &state);
    memcpy(r->old, r->u, (size_t)r->nodes * sizeof *r->u);
    softsim_read_nodes(r->world, NULL, r->u, r->v);
    const double time_s = (double)state.step * state.simulation_period_s;
    ss_audit_sample sample = {.count = r->nodes,
                              .displacement = (const double(*)[3])r->u,
                              .velocity = (const double(*)[3])r->v,
                              .kinetic = state.kinetic_j,
                              .elastic = state.elastic_j,
                              .dissipated = state.dissipated_j,
                              .work = state.work_j,
                              .is_released = time_s - 0.5 * r->period_s > r->plan.release_s};
    ss_copy3(sample.force, force);
    sample.applied = state.step > r->steps ? applied_work(r, time_s) : 0.0;
    ss_audit_look(&r->audit, &sample);
    r->out->kinetic_j = fmax(r->out->kinetic_j, state.kinetic_j);
    r->last_stored = state.kinetic_j + state.elastic_j;
    r->first_stored = r->steps == 0 ? r->last_stored : r->first_stored;
    r->steps = state.step;
    r->released_s = fmax(0.0, time_s - r->plan.release_s);
}

static double least_extent(const double (*x)[3], int32_t count)
{
    double least = (double)INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (int32_t i = 0; i < count; ++i) {
            low = fmin(low, x[i][axis]);
            high = fmax(high, x[i][axis]);
        }
        least = fmin(least, high - low);
    }
    return least;
}

/* Room for all nodes and ticks. */
static softsim_status allocate(runner *r, softsim_error *error)
{
    softsim_state state;
    softsim_read(r->world, &state);
    r->nodes = state.node_count;
    const size_t count = (size_t)r->nodes;
    r->u = calloc(count, sizeof *r->u);
    r->v = calloc(count, sizeof *r->v);
    r->old = calloc(count, sizeof *r->old);
    r->felt = calloc(SS_STRESS_CASE_MAX_TICKS, sizeof *r->felt);
    if (r->nodes < SS_SPECIMEN_NODES || r->u == NULL || r->v == NULL || r->old == NULL ||
        r->felt == NULL) {
        return ss_memory_fault(error);
    }
    softsim_read_nodes(r->world, r->old, NULL, NULL);
    r->size_m = least_extent((const double(*)[3])r->old, r->nodes);
    return SOFTSIM_OK;
}

/* Pause and resume in turn, as often as the plan has it before this tick. */
static void command(runner *r, double time_s)
{
    for (int32_t n = ss_stress_case_commands(&r->plan, time_s, r->period_s); n > 0; --n) {
        ss_command_record record;
        char text[128];
        ss_world_command(ss_world_of(r->world), r->commands++ % 2 == 0 ? "pause" : "resume", "",
                         &record, text, (int32_t)sizeof text);
    }
}

static void play(runner *r)
{
    softsim_force force[SOFTSIM_MAX_PROBES] = {{0}};
    const int32_t channel[1] = {0};
    const bool has_tool = r->plan.drive == SS_STRESS_CASE_TOOL;
    softsim_pose pose = {.sender = 1, .force_seq = -1, .orientation = {1.0, 0.0, 0.0, 0.0}};
    ss_set3(pose.velocity, (double)NAN, (double)NAN, (double)NAN);
    ss_set3(pose.applied_force, (double)NAN, (double)NAN, (double)NAN);
    const double still[3] = {0.0, 0.0, 0.0};
    bool is_apart = false;
    look(r, still);
    for (int32_t k = 1; k <= r->out->ticks; ++k) {
        pose.seq = k;
        pose.utime_us = (int64_t)(1e6 * k * r->period_s);
        ss_stress_case_plan_tool(&r->plan, k * r->period_s, k, pose.position, pose.orientation);
        command(r, k * r->period_s);
        const softsim_refusal refusal =
            softsim_tick(r->world, &pose, channel, has_tool ? 1 : 0, force);
        look(r, has_tool ? force[0].force : still);
        if (has_tool && refusal != SOFTSIM_ACCEPTED) {
            is_apart = true;
        } else if (has_tool) {
            ss_hand_sample *sample = &r->felt[r->felt_count++];
            ss_hand_read(&pose, &force[0], sample);
            sample->stored_j = r->last_stored;
            sample->is_apart = is_apart;
            is_apart = false;
            pose.force_seq = force[0].seq;
        }
    }
}

/* What the hand got that no tissue gives. */
static uint32_t judge_hand(runner *r, const softsim_state *state)
{
    ss_hand_account *hand = &r->hand;
    /* A result is a period late, and looks up to two ahead. */
    const double periods = state->simulation_period_s / r->period_s;
    const ss_hand_plan plan = {.period_s = r->period_s,
                               .lag = 1 + (int32_t)ceil(2.0 * periods),
                               .has_stored = !ss_stress_case_is_plastic(r->trial->subject)};
    ss_hand_judge(&plan, r->felt, r->felt_count, hand);
    const double most_j = fmax(hand->handed_out_j, hand->made_j);
    return (most_j > most_handed_out_j ? SS_AUDIT_HANDED_OUT : 0u) |
           (hand->driven_j > most_driven_j ? SS_AUDIT_DRIVEN : 0u) |
           (hand->peak_force_n > SS_STRESS_CASE_MAX_FORCE * (1.0 + 1e-9) ? SS_AUDIT_FORCE : 0u) |
           (hand->deepest_m > r->size_m * (1.0 + 1e-6) ? SS_AUDIT_DEPTH : 0u);
}

/* What the world says about itself, and what the audit found. */
static void judge(runner *r)
{
    ss_stress_case_result *out = r->out;
    softsim_state state;
    softsim_read(r->world, &state);
    const ss_stress_case *trial = r->trial;
    const double tau_s =
        r->plan.drive == SS_STRESS_CASE_TOOL ? fmax(r->plan.tau_s, 0.01) : r->plan.tau_s;
    /* What swings about one node, or is much heavier, is slower than tau. */
    const bool is_slow = trial->kind == SS_STRESS_CASE_CONTRADICTION ||
                         (trial->kind == SS_STRESS_CASE_MASS && trial->value > heavy);
    const bool is_rested = r->released_s >= rested_tau * tau_s && !is_slow &&
                           !ss_stress_case_is_plastic(trial->subject) &&
                           state.worst_verdict < SOFTSIM_VERDICT_DEGRADED;
    out->found = ss_audit_end(&r->audit, is_rested) | judge_hand(r, &state);
    out->verdict = state.worst_verdict;
    snprintf(out->acted, sizeof out->acted, "%s", state.worst_reason);
    for (int k = 0; k < SOFTSIM_REFUSED_COUNT; ++k) {
        const size_t used = strlen(out->acted);
        if (state.poses_refused[k] > 0) {
            snprintf(out->acted + used, sizeof out->acted - used, "%spose refused: %s",
                     used > 0 ? "; " : "", softsim_refusal_name(k));
        }
    }
    const bool is_apart = (out->found & (SS_AUDIT_NOT_FINITE | SS_AUDIT_FAR | SS_AUDIT_GROWS)) != 0;
    out->outcome = is_apart || out->verdict == SOFTSIM_VERDICT_FAULT ? SS_STRESS_CASE_DIVERGED
                   : out->acted[0] != '\0'                           ? SS_STRESS_CASE_GUARDED
                                                                     : SS_STRESS_CASE_STABLE;
    out->is_agreed = ss_audit_agrees(out->found, out->verdict) &&
                     (trial->kind != SS_STRESS_CASE_CONTROL ||
                      (out->found == 0 && out->verdict <= SOFTSIM_VERDICT_GUARDED));
    out->substeps = (double)state.all_substeps / fmax(1.0, (double)state.step);
    out->stored_j = r->audit.largest_stored;
    out->end_j = r->last_stored - r->first_stored;
    out->balance = ss_audit_balance_error(&r->audit);
    out->work_error = ss_audit_work_error(&r->audit);
    out->displacement_m = r->audit.largest;
    out->handed_out_j = r->hand.handed_out_j;
    out->made_j = r->hand.made_j;
    out->driven_j = r->hand.driven_j;
    out->force_n = r->hand.peak_force_n;
    out->depth_m = r->hand.deepest_m;
    out->recovery = ss_audit_recovery_error(&r->audit);
    out->inverted = ss_specimen_inverted(&r->plan.specimen, (const double(*)[3])r->u);
}

static softsim_status run(runner *r, softsim_error *error)
{
    ss_stress_case_result *out = r->out;
    const ss_stress_case_kind kind = r->trial->kind;
    softsim_status status = SOFTSIM_OK;
    if (kind == SS_STRESS_CASE_STEP || kind == SS_STRESS_CASE_SUBSTEP) {
        status = ask_limit(r, error);
    }
    if (status == SOFTSIM_OK && out->outcome != SS_STRESS_CASE_REFUSED) {
        status = begin(r, error);
    }
    if (status != SOFTSIM_OK || r->world == NULL) {
        return status;
    }
    r->period_s = r->plan.step_s > 0.0 ? r->plan.step_s : haptic_tick_s;
    out->step_s = r->period_s;
    out->ticks =
        (int32_t)fmin(fmax(ceil(r->plan.end_s / r->period_s), MIN_TICKS), SS_STRESS_CASE_MAX_TICKS);
    const double size3 = SS_SPECIMEN_SIZE * SS_SPECIMEN_SIZE * SS_SPECIMEN_SIZE;
    const ss_audit_plan plan = {.reach = r->plan.reach_m,
                                .floor = floor_share * r->trial->stiffness_pa * size3,
                                .still = still_share * SS_SPECIMEN_SIZE,
                                .has_work = r->plan.drive == SS_STRESS_CASE_LOADS &&
                                            !ss_stress_case_has_own_work(r->trial->subject)};
    ss_audit_begin(&r->audit, &plan);
    status = allocate(r, error);
    if (status == SOFTSIM_OK) {
        play(r);
        judge(r);
    }
    softsim_destroy(&r->world);
    return status;
}

softsim_status ss_stress_case_run(const ss_stress_case *trial, const char *parent,
                                  ss_stress_case_result *out, softsim_error *error)
{
    runner *r = calloc(1, sizeof *r);
    *out = (ss_stress_case_result){.limit_s = (double)NAN,
                                   .step_s = (double)NAN,
                                   .substeps = (double)NAN,
                                   .stored_j = (double)NAN,
                                   .end_j = (double)NAN,
                                   .balance = (double)NAN,
                                   .work_error = (double)NAN,
                                   .displacement_m = (double)NAN,
                                   .recovery = (double)NAN,
                                   .kinetic_j = (double)NAN,
                                   .handed_out_j = (double)NAN,
                                   .made_j = (double)NAN,
                                   .driven_j = (double)NAN,
                                   .force_n = (double)NAN,
                                   .depth_m = (double)NAN,
                                   .is_agreed = true};
    if (r == NULL) {
        return ss_memory_fault(error);
    }
    const int64_t begin_ns = ss_clock_thread_cpu_ns();
    r->trial = trial;
    r->out = out;
    ss_stress_case_plan_make(trial, &r->plan);
    snprintf(r->folder.path, sizeof r->folder.path, "%s/trial-XXXXXX", parent);
    softsim_status status = SOFTSIM_ERROR_FILE;
    if (mkdtemp(r->folder.path) == NULL) {
        softsim_error_add(error, status, "cannot make a folder in %s: %s", parent, strerror(errno));
    } else {
        status = run(r, error);
        ss_scratch_remove(r->folder.path);
    }
    out->cpu_ms = 1e-6 * (double)(ss_clock_thread_cpu_ns() - begin_ns);
    SS_EACH(free, r->u, r->v, r->old, r->felt, r);
    return status;
}
