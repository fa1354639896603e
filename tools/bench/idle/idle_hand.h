/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A client of the server under test, on a thread of its own: it counts what goes over the wire,
 * finds a free place of the surface from the topology, and moves probe 0 there, a pose a
 * millisecond. It also runs the bare loop: a thread that wakes every millisecond and does nothing.
 * Thread: start and stop by main; the rest by any.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

typedef enum ss_idle_way {
    SS_IDLE_NONE, /* no pose */
    SS_IDLE_AIR,  /* circles of 20 mm in the air, once a second */
    SS_IDLE_PRESS /* goes in until the force is 0.3 N, and stays */
} ss_idle_way;

/* So far. */
typedef struct ss_idle_counts {
    int64_t bytes, round_bytes; /* on the wire; of them statuses, scenes, topology, poses, forces */
    int64_t bare_cpu_ns;
    double force; /* N, the last */
    int32_t active_nodes;
    double chosen_hz, yardstick; /* of the server's plan */
    double slowest_hz;           /* that it reached since the way was chosen; INFINITY not known */
    int32_t worst_verdict;       /* since then */
    bool has_surface, is_still;
} ss_idle_counts;

typedef struct ss_idle_hand ss_idle_hand;

softsim_status ss_idle_hand_start(const char *lcm_url, const char *prefix, ss_idle_hand **out_hand,
                                  softsim_error *error);
void ss_idle_hand_go(ss_idle_hand *hand, ss_idle_way way);
ss_idle_counts ss_idle_hand_read(ss_idle_hand *hand);
void ss_idle_hand_stop(ss_idle_hand **hand);
