/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the bridge asks of a device: where it is now, and to exert a force for one period. All in
 * the device's own frame, metres and newtons; frame.h places it in the world. A backend fills one
 * ss_device; the bridge's loop knows nothing else of it.
 * Thread: the bridge's loop.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_device_sample {
    double position[3];    /* as the device measures it */
    double orientation[4]; /* w x y z, unit */
    int32_t buttons;
    double true_position[3]; /* where it really is; a device that does not know repeats position */
    double true_velocity[3]; /* NaN where the device does not know */
} ss_device_sample;

typedef struct ss_device {
    void *state;
    double period_s;
    double max_force_n; /* what the device can exert */
    /* Reads the present sample; false when the device has nothing more to give. */
    bool (*read)(void *state, ss_device_sample *out_sample);
    /* Exerts `force_n` for one period. */
    void (*exert)(void *state, const double force_n[3]);
    void (*destroy)(void *state);
} ss_device;

/* ---- sim: a simulated device in a simulated hand (sim.c) ---- */

typedef enum ss_sim_body { SS_BODY_LIGHT, SS_BODY_MEDIUM, SS_BODY_HEAVY } ss_sim_body;
typedef enum ss_sim_grip { SS_GRIP_SOFT, SS_GRIP_MEDIUM, SS_GRIP_FIRM } ss_sim_grip;
typedef enum ss_sim_script {
    SS_SCRIPT_PRESS,
    SS_SCRIPT_POKE,
    SS_SCRIPT_TAP,
    SS_SCRIPT_SLIDE,
    SS_SCRIPT_GRASP
} ss_sim_script;
#define SS_SIM_BODIES  "light|medium|heavy"
#define SS_SIM_GRIPS   "soft|medium|firm"
#define SS_SIM_SCRIPTS "press|poke|tap|slide|grasp"

typedef struct ss_sim_config {
    ss_sim_body body;
    ss_sim_grip grip;
    ss_sim_script script;
    uint64_t seed; /* of the tremor */
    double period_s;
} ss_sim_config;

softsim_status ss_sim_create(const ss_sim_config *config, ss_device *out_device,
                             softsim_error *error);

/* ---- script: a pose path file (script.c) ---- */

softsim_status ss_script_create(const char *csv_path, double period_s, ss_device *out_device,
                                softsim_error *error);
