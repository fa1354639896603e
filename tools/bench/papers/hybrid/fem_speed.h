/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How fast the model `fem` is: thread-CPU time of an element and sub-step with everything that a
 * sub-step does, and what of the machine's arithmetic and bandwidth that is.
 *
 * The body is the ellipsoid of semi-axes 50, 35 and 25 mm, E 3 kPa, nu 0.45, 1000 kg/m^3, its
 * lowest fifth fixed, in a body-centred lattice of tetrahedra; it moves under gravity that is
 * switched on. It goes through the numbering that a world gives a mesh, from a good or a shuffled
 * order. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/core/yardstick.h"
#include "softsim/types.h"

typedef struct ss_fem_speed_case {
    int32_t elements; /* about so many */
    bool is_viscous;  /* phi and psi of 20 us of the elastic moduli: the paper's damping */
    bool is_cured;    /* nodal pressure */
    bool is_shuffled; /* nodes and elements in random order before numbering */
    int32_t rounds;   /* of 20 sub-steps or more each; their median counts */
} ss_fem_speed_case;

typedef struct ss_fem_speed {
    int32_t nodes, elements;
    double ns;              /* an element and sub-step, integration included: median */
    double stable_step_s;   /* dt* */
    double realtime;        /* simulated over thread-CPU time at half the stable step */
    double realtime_half;   /* elements that would be simulated in real time at 0.5 dt* */
    double realtime_most;   /* and at 0.9 dt* */
    double flop_share;      /* of the yardstick's rate of multiply-adds */
    double bandwidth_share; /* of its bandwidth */
    double create_s;
    char verdict[128];
} ss_fem_speed;

/* SOFTSIM_ERROR_ARGUMENT for less than 100 elements or no rounds. */
softsim_status ss_fem_speed_measure(const ss_fem_speed_case *what, const ss_yardstick *yardstick,
                                    ss_fem_speed *out, softsim_error *error);
