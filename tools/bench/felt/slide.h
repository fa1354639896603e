/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * softsim-bench felt --slide: is sliding smooth, and the same forward and back? A tool follows a
 * way over the body (way.h) in three directions, forward and back at each speed, and with stops,
 * where the tissue comes to rest. What forward and back have apart at rest is memory of the method;
 * what they have apart only on the way is the tissue's damping. Thread: main.
 */
#include "bench/felt/play.h"
#include "bench/felt/way.h"

typedef struct ss_slide_trace {
    int32_t count;             /* milliseconds */
    double *way_m;             /* of the tool */
    double (*force)[3];        /* N, on the device */
    ss_way_pass forward, back; /* of it, at even speed */
} ss_slide_trace;

enum { SS_SLIDE_STOPS = 5 };
typedef struct ss_slide_stops {
    double way_m[SS_SLIDE_STOPS];
    double forward[SS_SLIDE_STOPS][3], back[SS_SLIDE_STOPS][3]; /* N, at rest */
} ss_slide_stops;

softsim_status ss_slide_play(const char *scene, const ss_felt_place *place, const ss_way *way,
                             const ss_felt_run *run, double speed_m_s, ss_slide_trace *out,
                             softsim_error *error);
void ss_slide_trace_fini(ss_slide_trace *trace);
softsim_status ss_slide_stop(const char *scene, const ss_felt_place *place, const ss_way *way,
                             const ss_felt_run *run, ss_slide_stops *out, softsim_error *error);

/* As ss_report_class.run; one of the arguments is --slide. */
int ss_felt_slide(int argc, char **argv);
