/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How fast a model of tetrahedra is: thread-CPU time of an element and sub-step with everything
 * that a sub-step does, and what of the machine's arithmetic and bandwidth that is, by the flops
 * and bytes that the model states (`work` of its hints).
 *
 * The body is the ellipsoid of semi-axes 50, 35 and 25 mm, E 3 kPa, nu 0.45, 1000 kg/m^3, its
 * lowest fifth fixed, in a body-centred lattice of tetrahedra; it moves under gravity that is
 * switched on. It goes through the numbering that a world gives a mesh, from a good or a shuffled
 * order. Thread: one at a time.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/core/yardstick.h"
#include "models/tissue_law.h"
#include "softsim/types.h"

typedef struct ss_element_speed_case {
    const char *model;  /* one whose hints state its work */
    ss_tissue_kind law; /* the one that it states it for */
    int32_t elements;   /* about so many */
    bool is_viscous;    /* phi and psi of 20 us of the elastic moduli: the paper's damping */
    bool is_cured;      /* nodal pressure, of a model that has it */
    bool is_shuffled;   /* nodes and elements in random order before numbering */
    int32_t rounds;     /* of ten stable steps each; their median counts */
} ss_element_speed_case;

typedef struct ss_element_speed {
    int32_t nodes, elements;
    double ns;              /* an element and sub-step, integration included: median */
    double least_ns;        /* of the best round, as the yardstick is the best of its passes */
    double flops, bytes;    /* of that, as the model states them */
    double stable_step_s;   /* dt* */
    double realtime;        /* simulated over thread-CPU time at half the stable step */
    double realtime_half;   /* elements that would be simulated in real time at 0.5 dt* */
    double realtime_most;   /* and at 0.9 dt* */
    double flop_share;      /* of the yardstick's rate of multiply-adds */
    double flop_512_share;  /* of that in AVX-512; NaN where there is none */
    double bandwidth_share; /* of its bandwidth */
    double create_s;
    char verdict[128];
} ss_element_speed;

/* SOFTSIM_ERROR_ARGUMENT for less than 100 elements, no rounds, or a model that states no work. */
softsim_status ss_element_speed_measure(const ss_element_speed_case *what,
                                        const ss_yardstick *yardstick, ss_element_speed *out,
                                        softsim_error *error);
