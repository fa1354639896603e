/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How a world is created. Always start from softsim_default_config(): it sets every field and a
 * cookie that softsim_create checks, so that new fields never break a caller.
 */
#include <stdbool.h>
#include <stdint.h>

typedef struct softsim_config {
    uint32_t cookie;
    const char *const *set; /* PATH=VALUE overrides of scene values */
    int32_t set_count;
    int32_t threads;            /* for set-up and workers; results do not depend on it */
    double step_s;              /* outer step and tick; 0: the scene's own rates */
    bool has_budget;            /* simulation.max_substeps limits a step, as the clock makes it in
                                 * real time; without, a step takes what its bound demands */
    const char *import_program; /* NULL: the softsim-import installed with this library */
} softsim_config;

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* One thread, the scene's own rates, no overrides. What it points to is borrowed, and read only by
 * softsim_create. Thread: any. */
softsim_config softsim_default_config(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
