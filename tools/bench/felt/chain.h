/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A server of one haptic tick against tissue that is known: what a scene's body never is.
 *
 * Tissue: a chain of six masses (30 g) under the tool, static force K d (1 + d/15 mm), viscosity 1
 * ms times stiffness, one Maxwell branch of 0.4 K and 0.1 s; flat at z = 0, or with waves of 10 mm
 * length and 0.5 mm height along x. Its simulation steps at a rate of its own to the predicted
 * proxy, and a result arrives one of its periods after the pose it answers.
 * Thread: main; memory is allocated by ss_chain_create alone.
 */
#include "haptic/haptic.h"

typedef struct ss_chain_config {
    double tissue_n_per_m; /* K */
    bool has_waves;
    double rate_hz; /* of the simulation, at most that of the haptic ticks */
    ss_haptic_config haptic;
} ss_chain_config;

typedef struct ss_chain ss_chain;

/* NULL when out of memory. */
ss_chain *ss_chain_create(const ss_chain_config *config);
/* Accepts NULL; nulls. */
void ss_chain_destroy(ss_chain **chain);
/* One haptic tick with the poses that came since the last. */
void ss_chain_tick(ss_chain *chain, const softsim_pose *pose, int32_t count,
                   ss_haptic_output *output);
