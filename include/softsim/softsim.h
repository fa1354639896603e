/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The headless world: the daemon's own scene, model, contact and haptic tick, without LCM and
 * without threads, as fast as possible. `softsim-run` is written on it.
 *
 * Time moves by ticks of one haptic period. Each tick takes at most one pose per probe, judged by
 * the same receive checks as in the daemon's lockstep, and gives one force per probe. Equal input
 * gives equal bits, for any number of threads.
 * Thread: a world belongs to one thread at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/config.h"
#include "softsim/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct softsim_world softsim_world;

/* Loads and plans the scene; every fault is in `error`. NULL on failure. */
softsim_world *softsim_create(const char *scene_path, const softsim_config *config,
                              softsim_error *error);
/* Frees; nulls; accepts NULL. */
void softsim_destroy(softsim_world **world);

/* One haptic tick with `count` poses (any order; channel[i] is the channel's probe number of
 * pose[i]). out_force[p] is the force of probe p after the tick; its flags tell refusals. Returns
 * the refusal of the last pose, or SOFTSIM_ACCEPTED. */
softsim_refusal softsim_tick(softsim_world *world, const softsim_pose *pose, const int32_t *channel,
                             int32_t count, softsim_force out_force[SOFTSIM_MAX_PROBES]);

/* What the world is doing, after the last tick. */
typedef struct softsim_state {
    int64_t tick;
    int64_t step;    /* simulation steps done */
    double time_s;   /* simulated */
    double period_s; /* of a tick */
    double simulation_period_s;
    int32_t substeps;     /* of the last step */
    int64_t all_substeps; /* of all steps */
    int32_t node_count;
    int32_t active_nodes;    /* that take a step of their own */
    uint8_t probes;          /* bit n: probe n has a tool */
    softsim_verdict verdict; /* of the last step */
    const char *reason;
    softsim_verdict worst_verdict; /* of all steps, whether they were read or not */
    const char *worst_reason;      /* of the first step with it; "" while good */
    double stable_step_s;
    double kinetic_j, elastic_j, dissipated_j, work_j;
    int64_t poses_received;
    int64_t poses_refused[SOFTSIM_REFUSED_COUNT];
    double step_us[3]; /* thread CPU time: p50, p99, max of the last 10 s */
} softsim_state;
void softsim_read(softsim_world *world, softsim_state *out_state);

/* Positions from rest (m), velocities (m/s) of all nodes in file order; arrays of node_count
 * triples; any may be NULL. */
void softsim_read_nodes(softsim_world *world, double (*out_position)[3],
                        double (*out_displacement)[3], double (*out_velocity)[3]);
/* The surface's triangles, of nodes in file order. */
int32_t softsim_triangle_count(const softsim_world *world);
const int32_t (*softsim_triangles(const softsim_world *world))[3];

/* The scene's prescribed entries, for reactions; entry -1 is the fixed nodes. */
int32_t softsim_prescribed_count(const softsim_world *world);
const char *softsim_prescribed_name(const softsim_world *world, int32_t entry);
void softsim_read_reaction(softsim_world *world, int32_t entry, double out_force[3]);

/* FNV-1a 64 over positions, velocities, model state and step number, little-endian, file order. */
uint64_t softsim_hash(softsim_world *world);

#ifdef __cplusplus
}
#endif
