/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a scene report says of a live parameter. Any thread.
 */
#include "softsim/view.h"

/* The value of `path` ("haptic.max_force_n") as the server has it now, in its unit; 0 where it
 * does not say, or says no finite number above zero. */
double ss_parameter_of(const softsim_scene_report *scene, const char *path);
/* The most that a command may set it to, likewise. */
double ss_parameter_most(const softsim_scene_report *scene, const char *path);
