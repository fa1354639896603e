/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a plan leaves out, and the values of a scene that put it back. Each is said once, by whoever
 * leaves it out (ss_note_left_out); here are those of a world, by name. A value puts a part back so
 * that it does its work and changes nothing: a viscosity that rounds away, a limit never reached.
 * Rejected: a switch of its own for every part, which is a second way into each model.
 * Thread: set-up only.
 */
#include "world/world.h"

enum { SS_OMISSION_VALUES = 4, SS_OMISSION_TEXT = 128, SS_MAX_OMISSIONS = 32 };

typedef struct ss_omission {
    char name[SS_OMISSION_TEXT], reason[SS_OMISSION_TEXT];
    char value[SS_OMISSION_VALUES][SS_OMISSION_TEXT]; /* PATH=VALUE, to be set together */
    int32_t value_count;                              /* 0: no values put it back */
} ss_omission;

/* Those of the plan, in its order; returns their number. */
int32_t ss_world_omissions(const ss_world *world, ss_omission out[SS_MAX_OMISSIONS]);
/* Those of a scene by its path, whose world is made for that alone. */
softsim_status ss_omissions_of_scene(const char *scene, const softsim_config *config,
                                     ss_omission out[SS_MAX_OMISSIONS], int32_t *out_count,
                                     softsim_error *error);

/* The one called `name`, the argument of --force-include, of those that can be put back. NULL, and
 * a fault that lists them, where it is none of these. */
const ss_omission *ss_omission_find(const ss_omission *omission, int32_t count, const char *name,
                                    softsim_error *error);
