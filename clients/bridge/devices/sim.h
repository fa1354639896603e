/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The simulated device, for tests that need no command line. */
#include "device.h"

typedef enum ss_sim_body { SS_BODY_LIGHT, SS_BODY_MEDIUM, SS_BODY_HEAVY } ss_sim_body;
typedef enum ss_sim_grip { SS_GRIP_SOFT, SS_GRIP_MEDIUM, SS_GRIP_FIRM } ss_sim_grip;
typedef enum ss_sim_script {
    SS_SCRIPT_PRESS,
    SS_SCRIPT_POKE,
    SS_SCRIPT_TAP,
    SS_SCRIPT_SLIDE,
    SS_SCRIPT_GRASP
} ss_sim_script;

typedef struct ss_sim_config {
    ss_sim_body body;
    ss_sim_grip grip;
    ss_sim_script script;
    uint64_t seed; /* of the tremor */
    double period_s;
} ss_sim_config;

softsim_status ss_sim_create(const ss_sim_config *config, ss_device *out_device,
                             softsim_error *error);
