/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How fast cnn-chainmail steps: every link at work, a poke, a haptic frame of eight sub-steps; on
 * the liver and on blocks of equal edge length from 5,000 to 500,000 elements, where a poke should
 * cost the same. Times are medians or means of thread CPU time, counts are the model's own.
 * Without the coarse level, which touches every element. Thread: one, not real-time.
 */
#include <stdbool.h>

#include "mesh/mesh.h"

typedef struct ss_chain_speed {
    char body[24]; /* "liver", "block 17^3" */
    int32_t nodes, elements;
    double full_us;  /* a step with every link out of its band; 0 where not measured */
    double poke_us;  /* a step, mean over the first 200 of a poke of 15 nodes */
    double visits;   /* elements moved a step, mean over the same */
    double frame_us; /* a step of eight sub-steps, mean over the same poke */
    double frame_max_us;
} ss_chain_speed;

enum { SS_CHAIN_SPEED_ROWS = 5 };

/* Fills a row for `liver` (may be NULL) and one for each block; `is_quick` leaves out those above
 * 20,000 elements. Returns the number of rows, -1 when something failed (said in `error`). */
int32_t ss_chain_speed_measure(const ss_mesh *liver, bool is_quick,
                               ss_chain_speed out[SS_CHAIN_SPEED_ROWS], softsim_error *error);
