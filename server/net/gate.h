/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The receive checks: which poses may move a probe; without any LCM. Others reach it by net.h.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef struct ss_gate_config {
    uint8_t used_probes; /* bit n: probe n has a tool in the scene */
    double max_jump_m;
    double period_s;  /* the haptic period: the watchdog is 50 of them */
    bool is_lockstep; /* pose age is not judged; time is simulated */
} ss_gate_config;

typedef struct ss_gate ss_gate;

/* Thread: set-up only. */
ss_gate *ss_gate_create(const ss_gate_config *config);
void ss_gate_destroy(ss_gate **gate);
void ss_gate_set_max_jump(ss_gate *gate, double max_jump_m);
/* Judges a decoded pose that came in on channel `channel_probe` at `now_ns` (monotonic in real
 * time, simulated in lockstep). Counts it. SOFTSIM_ACCEPTED or the refusal.
 * *out_epoch grows when the probe changes hands or its holder returns after the watchdog
 * (50 haptic ticks without a good pose). Thread: net (or the only thread of a headless run). */
softsim_refusal ss_gate_judge(ss_gate *gate, const softsim_pose *pose, int32_t channel_probe,
                              int64_t now_ns, uint32_t *out_epoch);
/* True at most ten times a second per probe (in lockstep always: there every pose is answered): a
 * foreign sender may be told so (zero force, SOFTSIM_FORCE_OTHER_SENDER). Never who uses the
 * holder's number from another address: the answer would reach the holder. Thread: net. */
bool ss_gate_may_answer_other(ss_gate *gate, const softsim_pose *pose, int32_t channel_probe,
                              int64_t now_ns);
/* Scales an orientation that passes for a unit quaternion to length 1; leaves any other for
 * ss_gate_judge to refuse. Every pose passes here once before it is judged, whatever its source,
 * so that all runs of a log agree; decoding calls it. RT-safe. */
void ss_gate_normalize(softsim_pose *pose);
/* Counts what never became a pose. */
void ss_gate_refuse(ss_gate *gate, softsim_refusal reason);
/* Counts a command, of whatever is wrong with it: it is no pose, and none was received. */
void ss_gate_refuse_command(ss_gate *gate);

typedef struct ss_gate_counts {
    int64_t received;                       /* accepted poses and all refused */
    int64_t refused[SOFTSIM_REFUSED_COUNT]; /* other: commands too */
} ss_gate_counts;
/* Thread: any. */
void ss_gate_read(const ss_gate *gate, ss_gate_counts *out_counts);
