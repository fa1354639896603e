/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/hand.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/felt/chain.h"
#include "correct.h"
#include "rt/memory.h"
#include "rt/vec.h"
#include "softsim/softsim.h"

enum { RATE_HZ = 1000, SENDER = 1, BURST = 64, SLOPE_TICKS = 5, MAX_SET = 72 };
static const int64_t period_ns = 1000000;
static const int64_t server_phase_ns = 300000; /* its ticks after the device's */
static const double slope_m = 0.3e-3, touch_n = 0.02, max_force_n = 8.0, max_slew_n_per_s = 2000.0;

/* What a contact may hand out: of press, poke and slide, and of a fast tap, where the bus is slow
 * too. */
static const double least_j = 1e-3, share_of_peak = 0.05, tap_j = 3e-3, slow_tap_j = 8e-3,
                    slow_ms = 5.0;

double ss_hand_allowance(const ss_hand_run *run, double peak_j)
{
    if (run->script == SS_SCRIPT_TAP) {
        return run->bus.delay_ms > slow_ms ? slow_tap_j : tap_j;
    }
    return fmax(least_j, share_of_peak * peak_j);
}

/* ---- the server ---- */

typedef struct server {
    const ss_hand_run *run;
    ss_chain *chain;
    softsim_world *world;
    double axis[3][3]; /* of the contact frame, in the world */
    double origin[3];  /* of the tool at first touch */
    double orientation[4];
    double limit; /* N/m, of the chain's haptic tick */
    double delay_p95_ms;
    int64_t damped_ticks, backoffs;
} server;

static void to_world(const server *s, const double device[3], double out[3])
{
    ss_copy3(out, s->origin);
    for (int k = 0; k < 3; ++k) {
        ss_madd3(out, out, device[k], s->axis[k]);
    }
}

static void to_device(const server *s, const double world[3], double out[3])
{
    ss_set3(out, ss_dot3(world, s->axis[0]), ss_dot3(world, s->axis[1]),
            ss_dot3(world, s->axis[2]));
}

static softsim_status open_scene(server *s, softsim_error *error)
{
    const ss_hand_run *run = s->run;
    const char *set[MAX_SET];
    char rate[64];
    int32_t count = 0;
    for (; count < run->set_count && count < MAX_SET - 2; ++count) {
        set[count] = run->set[count];
    }
    snprintf(rate, sizeof rate, "simulation.rate_hz=%.9g", run->rate_hz);
    set[count++] = rate;
    set[count++] = "publish.mesh_rate_hz=0";
    softsim_config config = softsim_default_config();
    config.set = set;
    config.set_count = count;
    s->world = softsim_create(run->scene, &config, error);
    ss_copy3(s->axis[0], run->place->along);
    ss_copy3(s->axis[2], run->place->normal);
    ss_cross3(s->axis[1], s->axis[2], s->axis[0]);
    ss_madd3(s->origin, run->place->point, run->place->reach_m, run->place->normal);
    memcpy(s->orientation, run->place->orientation, sizeof s->orientation);
    return s->world != NULL ? SOFTSIM_OK : error->status;
}

static softsim_status open_chain(server *s, softsim_error *error)
{
    const ss_hand_run *run = s->run;
    const ss_chain_config config = {.tissue_n_per_m = run->tissue_n_per_m,
                                    .has_waves = run->script == SS_SCRIPT_SLIDE,
                                    .rate_hz = run->rate_hz,
                                    .haptic = {.period = 1.0 / RATE_HZ,
                                               .between_steps = SS_BETWEEN_LOCAL,
                                               .max_force = max_force_n,
                                               .max_slew = max_slew_n_per_s,
                                               .stiffness = run->stiffness_n_per_m,
                                               .damping = run->damping_n_s_per_m,
                                               .thickness = 1.0}};
    s->chain = ss_chain_create(&config);
    s->axis[0][0] = s->axis[1][1] = s->axis[2][2] = s->orientation[0] = 1.0;
    if (s->chain == NULL) {
        return ss_memory_fault(error);
    }
    return SOFTSIM_OK;
}

/* A tick with the poses that came; false before the first force. */
static bool serve(server *s, const softsim_pose *pose, int32_t count, softsim_force *out)
{
    if (s->chain != NULL) {
        ss_haptic_output output;
        ss_chain_tick(s->chain, pose, count, &output);
        *out = output.force;
        s->limit = output.stiffness_limit;
        s->delay_p95_ms = output.loop_delay_ms[1];
        s->damped_ticks = output.damped_ticks;
        s->backoffs = output.stiffness_backoffs;
        return output.has_force;
    }
    softsim_force all[SOFTSIM_MAX_PROBES];
    const int32_t probe = s->run->place->probe;
    /* Of a burst the world is told the newest. */
    softsim_tick(s->world, count > 0 ? &pose[count - 1] : NULL, &probe, count > 0, all);
    *out = all[probe];
    return out->seq > 0;
}

/* ---- the loop ---- */

typedef struct loop {
    server server;
    ss_device device;
    ss_corrector corrector;
    ss_bus *poses, *forces;
    ss_device_sample sample;
    double (*sent)[3];   /* true position of each pose, world */
    double (*answer)[3]; /* the force of each server tick, and the position it answers */
    double (*answered)[3];
    double *limit;
    ss_felt_row *row;
    double applied[3];
    int32_t flags, age_us;
} loop;

/* The device's side of a period, as the bridge does it. */
static void play_device(loop *l, int32_t n)
{
    const int64_t now_ns = n * period_ns;
    const bool corrects = l->server.run->is_correcting;
    softsim_force force;
    while (ss_bus_receive(l->forces, now_ns, &force)) {
        ss_corrector_take_force(&l->corrector, &force, now_ns);
        l->flags = force.flags;
        l->age_us = force.model_age_us;
    }
    l->device.read(l->device.state, &l->sample);
    softsim_pose pose = {.utime_us = now_ns / 1000,
                         .sender = SENDER,
                         .seq = n + 1,
                         .buttons = l->sample.buttons,
                         .flags = corrects ? SOFTSIM_POSE_CORRECTS : 0,
                         .velocity = {NAN, NAN, NAN}};
    pose.probe = l->server.world != NULL ? l->server.run->place->probe : 0;
    to_world(&l->server, l->sample.position, pose.position);
    to_world(&l->server, l->sample.true_position, l->sent[n]);
    memcpy(pose.orientation, l->server.orientation, sizeof pose.orientation);
    ss_copy3(pose.applied_force, l->applied);
    ss_corrector_note_pose(&l->corrector, pose.seq, now_ns, pose.position);
    pose.force_seq = ss_corrector_force_seq(&l->corrector, now_ns);
    double world[3], exerted[3];
    ss_corrector_force(&l->corrector, now_ns, pose.position, world);
    ss_copy3(l->applied, world);
    to_device(&l->server, world, exerted);
    l->device.exert(l->device.state, exerted);
    ss_bus_send(l->poses, now_ns, &pose);
    l->row[n] =
        (ss_felt_row){.time_s = (double)n / RATE_HZ, .flags = l->flags, .age_us = l->age_us};
    ss_copy3(l->row[n].x, l->sent[n]);
    ss_copy3(l->row[n].f, world);
}

static void play_server(loop *l, int32_t n)
{
    const int64_t now_ns = n * period_ns + server_phase_ns;
    softsim_pose pose[BURST];
    softsim_force force;
    int32_t count = 0;
    while (count < BURST && ss_bus_receive(l->poses, now_ns, &pose[count])) {
        ++count;
    }
    if (serve(&l->server, pose, count, &force)) {
        ss_copy3(l->answer[n], force.force);
        ss_copy3(l->answered[n], l->sent[force.pose_seq - 1]);
        l->limit[n] = l->server.limit;
        ss_bus_send(l->forces, now_ns, &force);
    }
}

/* ---- figures ---- */

/* Least balance of a contact against what it may be. */
static void judge_energy(const loop *l, int32_t ticks, ss_hand_outcome *out)
{
    double energy = 0.0, peak = 0.0;
    bool was_touching = false;
    out->is_passive = true;
    for (int32_t n = 0; n + 1 < ticks; ++n) {
        const bool is_touching = ss_norm3(l->row[n].f) > touch_n;
        double move[3];
        energy = was_touching ? energy : 0.0;
        peak = was_touching ? peak : 0.0;
        was_touching = is_touching;
        if (is_touching) {
            ss_sub3(move, l->row[n + 1].x, l->row[n].x);
            energy -= ss_dot3(l->row[n].f, move);
            peak = fmax(peak, energy);
            if (energy < out->net_j) {
                out->net_j = energy;
                out->peak_j = peak;
            }
            out->is_passive = out->is_passive && energy >= -ss_hand_allowance(l->server.run, peak);
        }
    }
}

/* Steepest change of the server's force over five of its ticks, by the limit then. */
static void judge_slope(const loop *l, int32_t ticks, ss_hand_outcome *out)
{
    int32_t touched = 0;
    out->least_limit_n_per_m = INFINITY;
    for (int32_t n = 0; n < ticks; ++n) {
        touched = ss_norm3(l->answer[n]) > 0.0 ? touched + 1 : 0;
        if (touched > SLOPE_TICKS) {
            double moved[3], change[3];
            ss_sub3(moved, l->answered[n], l->answered[n - SLOPE_TICKS]);
            ss_sub3(change, l->answer[n], l->answer[n - SLOPE_TICKS]);
            const double way = ss_norm3(moved);
            if (way > slope_m) {
                out->steepness =
                    fmax(out->steepness, -ss_dot3(change, moved) / (way * way * l->limit[n]));
            }
            out->least_limit_n_per_m = fmin(out->least_limit_n_per_m, l->limit[n]);
        }
    }
}

static softsim_status open_loop(loop *l, int32_t ticks, softsim_error *error)
{
    const ss_hand_run *run = l->server.run;
    const ss_sim_config sim = {.body = run->body,
                               .grip = run->grip,
                               .script = run->script,
                               .seed = run->seed,
                               .period_s = 1.0 / RATE_HZ};
    ss_bus_config there = run->bus, back = run->bus;
    there.seed = run->seed ^ 0x706F7365u;
    back.seed = run->seed ^ 0x666F7263u;
    l->poses = ss_bus_create(&there, sizeof(softsim_pose));
    l->forces = ss_bus_create(&back, sizeof(softsim_force));
    const size_t size = (size_t)ticks;
    l->sent = calloc(size, sizeof *l->sent);
    l->answer = calloc(size, sizeof *l->answer);
    l->answered = calloc(size, sizeof *l->answered);
    l->limit = calloc(size, sizeof *l->limit);
    l->row = calloc(size, sizeof *l->row);
    if (!l->poses || !l->forces || !l->sent || !l->answer || !l->answered || !l->limit || !l->row) {
        return ss_memory_fault(error);
    }
    ss_corrector_init(&l->corrector, run->is_correcting, ss_corrector_unlimited);
    const softsim_status status = ss_sim_create(&sim, &l->device, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    return run->scene != NULL ? open_scene(&l->server, error) : open_chain(&l->server, error);
}

static void close_loop(loop *l)
{
    if (l->device.destroy != NULL) {
        l->device.destroy(l->device.state);
    }
    if (l->poses != NULL) {
        ss_bus_destroy(&l->poses);
    }
    if (l->forces != NULL) {
        ss_bus_destroy(&l->forces);
    }
    ss_chain_destroy(&l->server.chain);
    softsim_destroy(&l->server.world);
    free(l->sent);
    free(l->answer);
    free(l->answered);
    free(l->limit);
    free(l->row);
    free(l);
}

softsim_status ss_hand_play(const ss_hand_run *run, ss_hand_outcome *out, softsim_error *error)
{
    const int32_t ticks = (int32_t)ceil(run->seconds * RATE_HZ);
    *out = (ss_hand_outcome){0};
    loop *l = calloc(1, sizeof *l);
    if (l == NULL) {
        return ss_memory_fault(error);
    }
    l->server.run = run;
    softsim_status status = open_loop(l, ticks, error);
    if (status == SOFTSIM_OK) {
        for (int32_t n = 0; n < ticks; ++n) {
            play_device(l, n);
            play_server(l, n);
        }
        judge_energy(l, ticks, out);
        judge_slope(l, ticks, out);
        out->delay_p95_ms = l->server.delay_p95_ms;
        out->damped_ticks = l->server.damped_ticks;
        out->backoffs = l->server.backoffs;
        const ss_felt_options options = {.intended_contacts = run->script == SS_SCRIPT_TAP ? 4 : 2};
        status = ss_felt_judge(l->row, ticks, &options, &out->felt);
    }
    close_loop(l);
    return status;
}
