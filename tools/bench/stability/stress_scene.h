/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The scene of a run of the stability report, as text, and what the run must know of it: who
 * drives the body, when it is let go. Private to stress case*.c, the page and tests. Thread: any.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "bench/stability/specimen.h"
#include "bench/stability/stress_case.h"

typedef enum ss_stress_case_drive {
    SS_STRESS_CASE_LOADS,
    SS_STRESS_CASE_TOOL,
    SS_STRESS_CASE_PLACES
} ss_stress_case_drive;

/* One load of the scene: for the work that the audit adds up. */
typedef struct ss_stress_case_load {
    int32_t first, count; /* nodes first .. first + count - 1 share the force */
    double force[3];      /* N */
} ss_stress_case_load;
enum { SS_STRESS_CASE_MAX_LOADS = SS_SPECIMEN_NODES, SS_STRESS_CASE_MAX_WAY = 10 };

typedef struct ss_stress_case_plan {
    const ss_stress_case *trial;
    ss_stress_case_drive drive;
    double tau_s;
    double step_s;    /* 0: the haptic loop's 1 ms */
    double ramp_s;    /* of loads and places */
    double release_s; /* INFINITY: never */
    double end_s;
    double reach_m; /* explained displacement */
    int32_t max_substeps;
    double max_jump_m; /* of a probe */
    ss_specimen specimen;
    ss_stress_case_load load[SS_STRESS_CASE_MAX_LOADS];
    int32_t load_count;
    /* Of a tool's centre: places at times; two at one time are a jump. */
    double way_s[SS_STRESS_CASE_MAX_WAY], way[SS_STRESS_CASE_MAX_WAY][3];
    int32_t way_count;
    double abused_s[2]; /* from, to */
    char more[32768];   /* of the scene, after everything else */
} ss_stress_case_plan;

#define SS_STRESS_CASE_TOOL_RADIUS 0.015 /* m */
#define SS_STRESS_CASE_MAX_FORCE   8.0   /* N, haptic.max_force_n of scenes with a tool */
enum { SS_STRESS_CASE_TOP_CENTRE = SS_SPECIMEN_TOP + SS_SPECIMEN_LAYER / 2 };

/* All but the step, where it is a share of a limit that only a run tells: step_s is 0 then, and
 * until it is set the scene steps by 1 ms. */
void ss_stress_case_plan_make(const ss_stress_case *trial, ss_stress_case_plan *out);
/* Where the tool is at a tick. */
void ss_stress_case_plan_tool(const ss_stress_case_plan *plan, double time_s, int32_t tick,
                              double out_position[3], double out_orientation[4]);
/* The scene, with its mesh body.msh beside it. */
void ss_stress_case_plan_write(const ss_stress_case_plan *plan, FILE *file);

/* tool_path.c: the tool's centre goes on to (x, 0, z), in so many seconds; and where it is on its
 * way. */
void ss_stress_case_plan_go(ss_stress_case_plan *plan, double seconds, double x, double z);
void ss_stress_case_plan_at(const ss_stress_case_plan *plan, double time_s, double out_position[3]);

/* abuse.c: the way of an abused tool, what is added to it at a tick, and the commands that
 * come before that tick. */
bool ss_stress_case_is_abuse(ss_stress_case_kind kind);
void ss_stress_case_abuse_plan(ss_stress_case_plan *plan);
void ss_stress_case_abuse(const ss_stress_case_plan *plan, double time_s, int32_t tick,
                          double position[3], double orientation[4]);
int32_t ss_stress_case_commands(const ss_stress_case_plan *plan, double time_s, double period_s);

/* The lines of the model: name, material. subject.c */
void ss_stress_case_subject_write(const ss_stress_case *trial, FILE *file);
