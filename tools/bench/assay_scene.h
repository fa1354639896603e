/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The scene of a run of the stability report, as text, and what the run must know of it: who
 * drives the body, when it is let go. Private to assay*.c. Thread: any.
 */
#include <stdbool.h>
#include <stdio.h>

#include "assay.h"
#include "specimen.h"

typedef enum ss_assay_drive { SS_ASSAY_LOADS, SS_ASSAY_TOOL, SS_ASSAY_PLACES } ss_assay_drive;

/* One load of the scene: for the work that the audit adds up. */
typedef struct ss_assay_load {
    int32_t first, count; /* nodes first .. first + count - 1 share the force */
    double force[3];      /* N */
} ss_assay_load;
enum { SS_ASSAY_MAX_LOADS = SS_SPECIMEN_NODES, SS_ASSAY_MAX_WAY = 10 };

typedef struct ss_assay_plan {
    const ss_assay *trial;
    ss_assay_drive drive;
    double tau_s;
    double step_s;    /* 0: the haptic loop's 1 ms */
    double ramp_s;    /* of loads and places */
    double release_s; /* INFINITY: never */
    double end_s;
    double reach_m; /* explained displacement */
    int32_t max_substeps;
    double max_jump_m; /* of a probe */
    ss_specimen specimen;
    ss_assay_load load[SS_ASSAY_MAX_LOADS];
    int32_t load_count;
    /* Of a tool's centre: places at times; two at one time are a jump. */
    double way_s[SS_ASSAY_MAX_WAY], way[SS_ASSAY_MAX_WAY][3];
    int32_t way_count;
    char more[32768]; /* of the scene, after everything else */
} ss_assay_plan;

#define SS_ASSAY_TOOL_RADIUS 0.015 /* m */

/* All but the step, where it is a share of a limit that only a run tells: step_s is 0 then, and
 * until it is set the scene steps by 1 ms. */
void ss_assay_plan_make(const ss_assay *trial, ss_assay_plan *out);
/* Where the tool's centre is. */
void ss_assay_plan_tool(const ss_assay_plan *plan, double time_s, double out_position[3]);
/* The scene, with its mesh body.msh beside it. */
void ss_assay_plan_write(const ss_assay_plan *plan, FILE *file);

/* The lines of the model: name, material. assay_subject.c */
void ss_assay_subject_write(const ss_assay *trial, FILE *file);
