/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The headless world: the daemon's own scene, model, contact and haptic tick, without LCM and
 * without threads, as fast as possible. `softsim-run` is written on it.
 *
 * Time moves by ticks of one haptic period. Each tick takes at most one pose per probe, judged by
 * the same receive checks as in the daemon's lockstep, and gives one force per probe. Equal input
 * gives equal bits, for any number of threads. What computes does so without denormals, whatever
 * the calling thread's mode, and leaves that mode as it was.
 * Thread: a world belongs to one thread at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/config.h"
#include "softsim/types.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct softsim_world softsim_world;

/* Loads and plans the scene, in seconds where a body is large; the meshes that the scene names are
 * sought beside it. `config`: of softsim_default_config(). NULL on failure: every fault is then a
 * line of `error`, which is never NULL and starts as {.status = SOFTSIM_OK}; ERROR_ARGUMENT,
 * ERROR_SCENE, ERROR_FILE, ERROR_FORMAT, ERROR_MESH, ERROR_MEMORY or ERROR_SYSTEM. What is
 * warned of, and does not stop it, softsimd --check tells.
 * Thread: any; several worlds may be made side by side. */
softsim_world *softsim_create(const char *scene_path, const softsim_config *config,
                              softsim_error *error);
/* Frees; nulls `*world`, which may be NULL. Thread: the one that used the world last. */
void softsim_destroy(softsim_world **world);

/* One haptic tick of softsim_state.period_s with `count` poses, 0 to SOFTSIM_MAX_PROBES (`pose` and
 * `channel` may be NULL with 0): metres, world frame, at most one a probe, in any order;
 * channel[i] is the number of the probe that pose[i] is for and equals pose[i].probe. `seq` grows
 * from pose to pose of a sender, who keeps the probe until 0.5 s pass without one.
 * out_force[p], for each of the SOFTSIM_MAX_PROBES: the force of probe p after the tick, newtons in
 * the world frame, zero where there is no tool; its flags tell refusals. Returns the refusal of the
 * last pose, or SOFTSIM_ACCEPTED.
 * Thread: the world's. */
softsim_refusal softsim_tick(softsim_world *world, const softsim_pose *pose, const int32_t *channel,
                             int32_t count, softsim_force out_force[SOFTSIM_MAX_PROBES]);

/* What the world is doing, after the last tick. Texts live as long as the world, and may change
 * with the next tick. */
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
/* Thread: the world's. */
void softsim_read(softsim_world *world, softsim_state *out_state);

/* Positions (m, world frame), displacements from rest (m) and velocities (m/s) of all nodes, in the
 * order of the mesh file; arrays of softsim_state.node_count triples; any may be NULL.
 * Thread: the world's. */
void softsim_read_nodes(softsim_world *world, double (*out_position)[3],
                        double (*out_displacement)[3], double (*out_velocity)[3]);
/* The surface's triangles, three nodes each, counted from 0 in the order of the mesh file,
 * counter-clockwise seen from outside; valid until the world is destroyed. Thread: the world's. */
int32_t softsim_triangle_count(const softsim_world *world);
const int32_t (*softsim_triangles(const softsim_world *world))[3];

/* The scene's entries under `prescribed`, 0 to the count less one, and what the support exerts on
 * the body at each (N, world frame, after the last step); entry -1 is the fixed nodes. A name is
 * valid until the world is destroyed. Thread: the world's. */
int32_t softsim_prescribed_count(const softsim_world *world);
const char *softsim_prescribed_name(const softsim_world *world, int32_t entry);
void softsim_read_reaction(softsim_world *world, int32_t entry, double out_force[3]);

/* FNV-1a 64 over positions, velocities, model state and step number, little-endian, file order:
 * equal for any number of threads of one build. Thread: the world's. */
uint64_t softsim_hash(softsim_world *world);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
