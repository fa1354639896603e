/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The server's report, four times a second: what server_status_t carries. Each field is declared
 * here once, in the order of lcmtypes/server_status_t.lcm; the struct, the message, the JSON of
 * softsim-monitor and what it shows are made of this list.
 *
 *   SCALAR(type, name, line, text)   ARRAY(type, name, count, line, text)   TEXT(name, line)
 *
 * `line` is the line of the monitor's page that shows it ("": none), `text` the words, with a value
 * in place of each of: @d a whole number, @n the same, negative for none, @0 @1 @2 that many
 * decimals, @g three digits, @l seconds, infinite for any, @M millions. The line "probe" is one
 * for each probe; any other must be in lines[] of clients/monitor/show.c, else the field is not
 * shown (a test compares the two). Counters count from the server's start.
 */
#include <stdint.h>

#include "softsim/types.h"

/* The bit of fault_bits that is no fault: the server is paused, whatever the reason speaks of. */
#define SOFTSIM_STATUS_PAUSED (1 << 19)

/* clang-format off */
#define SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)                                            \
    SCALAR(int64_t, utime, "", "")                       /* us, the server's own clock */          \
    SCALAR(int32_t, seq, "", "")                                                                   \
    SCALAR(int32_t, verdict, "", "")                     /* a softsim_verdict */                   \
    SCALAR(int32_t, fault_bits, "", "")                                                            \
    SCALAR(int32_t, threads, "up", "@d threads")                                                   \
    SCALAR(int32_t, nodes, "body", "@d nodes")                                                     \
    SCALAR(int32_t, active_nodes, "body", "@d active")                                             \
    SCALAR(int32_t, elements, "body", "@d elements")                                               \
    SCALAR(int32_t, worst_element, "body", "worst element @n")                                     \
    SCALAR(int32_t, substeps, "simulation", "@d sub-steps")                                         \
    SCALAR(int32_t, probes, "up", "@d probes")           /* that have a tool */                    \
    SCALAR(int64_t, plan_hash, "", "")                                                             \
    SCALAR(int64_t, state_hash, "", "")                  /* in lockstep only */                    \
    SCALAR(int64_t, step, "simulation", "step @d")                                                 \
    SCALAR(int64_t, bytes_in_use, "up", "@M MB")                                                   \
    SCALAR(int64_t, poses_received, "poses", "@d received")                                        \
    SCALAR(int64_t, poses_superseded, "poses", "@d superseded")                                    \
    ARRAY(int64_t, poses_refused, SOFTSIM_REFUSED_COUNT, "", "") /* by softsim_refusal */          \
    SCALAR(int64_t, mesh_bytes_sent, "wire", "@M MB of mesh sent")                                 \
    SCALAR(int64_t, wire_dropped, "wire", "@d messages dropped")                                   \
    ARRAY(int64_t, probe_periods, SOFTSIM_MAX_PROBES, "probe", "periods @d")                       \
    ARRAY(int64_t, probe_forces, SOFTSIM_MAX_PROBES, "probe", "forces @d") /* sent in time */      \
    ARRAY(int64_t, probe_missed, SOFTSIM_MAX_PROBES, "probe", "missed @d")                         \
    SCALAR(double, uptime_s, "up", "@1 s")                                                         \
    SCALAR(double, simulation_rate_hz, "simulation", "@1 Hz") /* done, over the last second */     \
    /* that the plan chose; what a step took at start over what was counted, 0 not looked at */     \
    SCALAR(double, chosen_rate_hz, "simulation", "of @1 Hz")                                       \
    SCALAR(double, yardstick, "simulation", "cost ratio @2")                                        \
    SCALAR(double, stable_step_s, "simulation", "stable step @l")                                  \
    /* thread CPU time of a step; lateness of the haptic loop; both of the last 10 s */            \
    ARRAY(double, step_us, 3, "step time", "p50 @0  p99 @0  max @0 us")                            \
    ARRAY(double, lateness_us, 4, "lateness", "p50 @0  p99 @0  p99.9 @0  max @0 us")               \
    SCALAR(double, kinetic_j, "energy", "kinetic @g J")                                            \
    SCALAR(double, elastic_j, "energy", "elastic @g J")                                            \
    SCALAR(double, total_j, "energy", "total @g J")                                                \
    SCALAR(double, energy_to_device_j, "device", "given @g J")                                     \
    SCALAR(double, energy_from_device_j, "device", "taken @g J")                                   \
    /* least energy balance of a contact */                                                        \
    ARRAY(double, worst_contact_j, SOFTSIM_MAX_PROBES, "probe", "worst contact @g J")              \
    ARRAY(double, loop_delay_ms, 2, "loop delay", "p50 @2  p95 @2 ms")                             \
    ARRAY(double, stiffness_limit_n_per_m, SOFTSIM_MAX_PROBES, "probe", "stiffness limit @0 N/m")  \
    SCALAR(int64_t, stiffness_backoffs, "device", "@d stiffness back-offs")                        \
    TEXT(scene, "scene")                                                                           \
    TEXT(model, "model")                                                                           \
    TEXT(reason, "")                                     /* of the verdict */
/* clang-format on */

typedef struct softsim_server_status {
#define SOFTSIM_NUMBER(type, name, line, text)       type name;
#define SOFTSIM_ARRAY(type, name, count, line, text) type name[count];
#define SOFTSIM_TEXT(name, line)                     const char *name;
    SOFTSIM_SERVER_STATUS_LIST(SOFTSIM_NUMBER, SOFTSIM_ARRAY, SOFTSIM_TEXT)
#undef SOFTSIM_NUMBER
#undef SOFTSIM_ARRAY
#undef SOFTSIM_TEXT
} softsim_server_status;
