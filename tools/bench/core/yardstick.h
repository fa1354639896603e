/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The machine's own yardstick, measured in the same run as a report, so that ratios hold where
 * absolute times drift: the rate of fused multiply-adds of one core, in vectors of 256 and of 512
 * bits, and the memory's bandwidth. Thread: any; takes about half a second and 96 MB.
 */
#include <stdint.h>

typedef struct ss_yardstick {
    char processor[96];
    char system[96];
    int32_t cores;
    double load;           /* of the last minute; after a run it is the run's own too */
    double fma_gflops;     /* one core, float, 2 operations an FMA; thread CPU time */
    double fma_512_gflops; /* the same in AVX-512; 0 where there is none */
    double bandwidth_gb_s; /* triad a = b + s c, one core, 24 bytes an element; thread CPU time */
} ss_yardstick;

/* What could not be measured is 0 or empty. */
void ss_yardstick_measure(ss_yardstick *out);
