/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What the plan settles and a command may settle again. */
#include "world/world.h"

/* The scene's word as the haptic loop has it. */
ss_between_steps ss_world_between(ss_scene_between from);
/* The haptic loop's settings for probe p, with its tool's radius of gyration. */
ss_haptic_config ss_world_probe_config(const ss_world *world, int32_t p);
/* Steps between two surface snapshots. Hz, s. */
int32_t ss_world_snapshot_interval(double mesh_rate_hz, double step_period);
