/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The block of the scaling report: a cube of 100 mm held below, for every model and material of
 * the stability report at 10 kPa, with one node of the top pushed by 0.02 E h^2, h the mean
 * spacing of nodes, or moved by h in the course of the run where a model keeps its shape and knows
 * no force; a surface where the model lives on one. One run is a process of its own, so
 * that its peak memory is its own. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "softsim/types.h"

typedef struct ss_block_run {
    int32_t nodes, active_nodes;
    double create_s;       /* CPU: reading the mesh, factors, all of it */
    double memory_mb;      /* that the model and the world hold */
    double peak_mb;        /* of the process, set-up included */
    double p50_us, p99_us; /* thread CPU of a tick of 1 ms */
    double substeps;       /* mean */
    double balance;        /* as ss_body_run */
    char solver[160]; /* of the model's linear equations, by its own account; "": it has none */
    char verdict[192];
} ss_block_run;

/* `subject` of stability/stress_case.h, about `points` nodes; files go to `folder` and meshes stay
 * there for the next run. A scene that is refused is a result. */
softsim_status ss_block_measure(const char *folder, int32_t subject, int32_t points,
                                ss_block_run *out, softsim_error *error);

/* Makes the block's mesh, unless it is there already; `out_name` is in `folder`. In mm. */
softsim_status ss_block_mesh(const char *folder, bool is_surface, int32_t points, char out_name[64],
                             softsim_error *error);
/* Opens a scene with the mesh, fixed at its bottom; the rest is the caller's to write. NULL: a
 * fault. */
FILE *ss_block_scene(const char *path, const char *mesh, softsim_error *error);
/* The node nearest to the middle of the top, by the file's numbers from 0; -1: none. */
int32_t ss_block_top(const char *path);
