/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <pthread.h>
#include <string.h>

#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/thread.h"
#include "rt/vec.h"
#include "world/world.h"

/*
 * The world moved by poses alone: the daemon's lockstep and the headless API. One thread calls
 * everything; time is the tick number. The step begun at tick n is computed at once, or by a
 * worker while the ticks of its period run, and its results are posted at tick n + m: the bits do
 * not depend on which.
 */

/* With two threads or more, the step is computed by a worker while the ticks of its period run.
 * Outside the real-time rule: a lockstep world waits, on a condition, for what it needs. */
typedef struct ss_step_worker {
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool is_busy, is_stopping;
    ss_world *world;
} ss_step_worker;

static void *worker_body(void *argument)
{
    ss_step_worker *worker = argument;
    ss_thread_flush_denormals();
    pthread_mutex_lock(&worker->mutex);
    while (!worker->is_stopping) {
        if (worker->is_busy) {
            pthread_mutex_unlock(&worker->mutex);
            ss_world_step_compute(worker->world);
            pthread_mutex_lock(&worker->mutex);
            worker->is_busy = false;
            pthread_cond_broadcast(&worker->changed);
        } else {
            pthread_cond_wait(&worker->changed, &worker->mutex);
        }
    }
    pthread_mutex_unlock(&worker->mutex);
    return NULL;
}

static void start_worker(ss_world *world)
{
    ss_step_worker *worker = ss_memory_get(1, sizeof *worker);
    if (!worker) {
        return;
    }
    worker->world = world;
    pthread_mutex_init(&worker->mutex, NULL);
    pthread_cond_init(&worker->changed, NULL);
    if (pthread_create(&worker->thread, NULL, worker_body, worker) != 0) {
        pthread_mutex_destroy(&worker->mutex);
        pthread_cond_destroy(&worker->changed);
        ss_memory_free(worker);
        return;
    }
    world->worker = worker;
}

void ss_lockstep_stop(ss_world *world)
{
    ss_step_worker *worker = world->worker;
    if (!worker) {
        return;
    }
    pthread_mutex_lock(&worker->mutex);
    worker->is_stopping = true;
    pthread_cond_broadcast(&worker->changed);
    pthread_mutex_unlock(&worker->mutex);
    pthread_join(worker->thread, NULL);
    pthread_mutex_destroy(&worker->mutex);
    pthread_cond_destroy(&worker->changed);
    ss_memory_free(worker);
    world->worker = NULL;
}

void ss_world_settle(ss_world *world)
{
    ss_step_worker *worker = world->worker;
    if (!worker) {
        return;
    }
    pthread_mutex_lock(&worker->mutex);
    while (worker->is_busy) {
        pthread_cond_wait(&worker->changed, &worker->mutex);
    }
    pthread_mutex_unlock(&worker->mutex);
}

static void begin_lockstep_step(ss_world *world)
{
    ss_world_step_begin(world);
    world->is_step_pending = true;
    if (!world->worker) {
        ss_world_step_compute(world);
        return;
    }
    pthread_mutex_lock(&world->worker->mutex);
    world->worker->is_busy = true;
    pthread_cond_broadcast(&world->worker->changed);
    pthread_mutex_unlock(&world->worker->mutex);
}

/* A refused pose is answered too: a zero force for a foreign sender or a probe without a tool,
 * else the probe's force of this tick, under the refused pose's own number. */
static void answer_refused(softsim_force *force, const softsim_pose *pose, softsim_refusal refusal)
{
    if (refusal == SOFTSIM_REFUSED_OTHER_SENDER || refusal == SOFTSIM_REFUSED_WRONG_PROBE) {
        /* The channel's probe, not the one that the pose claims: who asked listens there. */
        *force = (softsim_force){.seq = force->seq, .probe = force->probe};
        if (refusal == SOFTSIM_REFUSED_OTHER_SENDER) {
            force->flags = SOFTSIM_FORCE_OTHER_SENDER;
        }
    }
    force->sender = pose->sender;
    force->pose_seq = pose->seq;
    force->pose_utime_us = pose->utime_us;
}

softsim_refusal ss_world_lockstep(ss_world *world, const softsim_pose *pose, const int32_t *channel,
                                  int32_t count, softsim_force out_force[SOFTSIM_MAX_PROBES])
{
    if (world->threads > 1 && !world->worker) {
        start_worker(world);
    }
    const int64_t tick = ++world->tick;
    const int64_t now_ns = (int64_t)llround((double)tick * world->period * 1e9);
    softsim_refusal refusals[SOFTSIM_MAX_PROBES];
    const softsim_pose *judged[SOFTSIM_MAX_PROBES] = {NULL};
    softsim_refusal last = SOFTSIM_ACCEPTED;
    for (int32_t i = 0; i < count; ++i) {
        uint32_t epoch = 0;
        last = ss_gate_judge(world->gate, &pose[i], channel[i], now_ns, &epoch);
        if (channel[i] < 0 || channel[i] >= SOFTSIM_MAX_PROBES) {
            continue;
        }
        judged[channel[i]] = &pose[i];
        refusals[channel[i]] = last;
        if (last == SOFTSIM_ACCEPTED) {
            const ss_pose_record record = {.pose = pose[i], .sender_epoch = epoch};
            ss_ring_push(world->probe[channel[i]].poses, &record);
        }
    }
    if ((tick - 1) % world->step_ticks == 0 && world->is_step_pending) {
        ss_world_settle(world);
        ss_world_step_post(world);
        world->is_step_pending = false;
    }
    ss_world_haptic_tick(world, tick, 0, now_ns);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        out_force[p] = (softsim_force){.probe = p, .pose_seq = -1};
    }
    ss_force_record record;
    while (ss_ring_pop(world->forces, &record)) {
        out_force[record.force.probe] = record.force;
    }
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (judged[p] && refusals[p] != SOFTSIM_ACCEPTED) {
            answer_refused(&out_force[p], judged[p], refusals[p]);
        }
    }
    if ((tick - 1) % world->step_ticks == 0) {
        begin_lockstep_step(world);
    }
    return last;
}

uint64_t ss_world_hash(ss_world *world)
{
    ss_world_settle(world);
    if (world->is_hashed) {
        return world->hash;
    }
    const ss_mesh *mesh = world->scene->mesh;
    const ss_real *u = world->model_class->displacement(world->model);
    const ss_real *v = world->model_class->velocity(world->model);
    uint64_t hash = SS_HASH_START;
    for (int32_t file = 0; file < mesh->node_count; ++file) {
        const int32_t i = world->node_of_file ? world->node_of_file[file] : file;
        double state[6];
        for (int32_t axis = 0; axis < 3; ++axis) {
            state[axis] = mesh->position[i][axis] + (double)u[4 * i + axis];
            state[3 + axis] = (double)v[4 * i + axis];
        }
        hash = ss_hash_bytes(hash, state, sizeof state);
    }
    hash = world->model_class->hash(world->model, hash);
    world->hash = ss_hash_bytes(hash, &world->steps, sizeof world->steps);
    world->is_hashed = true;
    return world->hash;
}
