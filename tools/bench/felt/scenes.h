/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The scenes of a report: those asked for, or all bundled ones. Thread: main. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rt/args.h"
#include "softsim/types.h"

enum { SS_FELT_MAX_SCENES = 64, SS_FELT_PATH_SIZE = 4352, SS_FELT_NAME_SIZE = 128 };

typedef struct ss_felt_scenes {
    char path[SS_FELT_MAX_SCENES][SS_FELT_PATH_SIZE];
    int32_t count;
    bool is_bundled; /* no scene was asked for: those without a tool are left out */
} ss_felt_scenes;

/* A scene's name: its file without folder and ending, as files and gnuplot take it. */
void ss_felt_name(const char *path, char out[SS_FELT_NAME_SIZE]);
/* Faults: two scenes of one name, or none found. */
void ss_felt_list_scenes(const ss_arg_list *asked, ss_felt_scenes *out, softsim_error *error);
