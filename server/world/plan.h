/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the plan settles, and what of it a command may settle again. */
#include "contact/touch.h"
#include "world/world.h"

/* The scene's word as the haptic loop has it. */
ss_between_steps ss_world_between(ss_scene_between from);
/* The haptic loop's settings for probe p, with its tool's radius of gyration. */
ss_haptic_config ss_world_probe_config(const ss_world *world, int32_t p);
/* Steps between two surface snapshots. Hz, s. */
int32_t ss_world_snapshot_interval(double mesh_rate_hz, double step_period);
/* Where a hand first meets the body at rest with the first tool, and the side it comes from; false:
 * no tool, or no side has a place for it. Thread: set-up only. */
bool ss_world_find_touch(const ss_world *world, int32_t *out_probe, int *out_side, ss_touch *out);

/* ---- rate.c; thread: set-up only ---- */

/* The step by counts, of `step_s` where that is above 0; and what a step of it is to cost. */
void ss_world_rate_by_counts(ss_world *world, double step_s);
/* What a step of the model takes over what was counted, by thread CPU time in some milliseconds;
 * the model is then at rest again. */
double ss_world_measure_yardstick(ss_world *world);
/* The step by counts and world->yardstick. */
void ss_world_rate_by_yardstick(ss_world *world);
