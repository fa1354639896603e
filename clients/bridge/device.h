/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the bridge asks of a device: where it is now, and to exert a force for one period. All in
 * the device's own frame, metres and newtons; frame.h places it in the world. A backend is one file
 * in devices/, or in a folder of your own, which defines an ss_device_class, and one row in its
 * CMakeLists.txt, ss_device(); nothing else names it.
 * Thread: the bridge's loop; a class's functions are called before it.
 */
#include <stdbool.h>
#include <stdint.h>

#include "rt/args.h"
#include "softsim/types.h"

typedef struct ss_device_sample {
    double position[3];    /* as the device measures it */
    double orientation[4]; /* w x y z, unit */
    int32_t buttons;
    double true_position[3]; /* where it really is; a device that does not know repeats position */
    double true_velocity[3]; /* NaN where the device does not know */
} ss_device_sample;

typedef struct ss_device {
    void *state;
    double period_s;
    double max_exerted_n; /* what the device can exert */
    /* Reads the present sample; false when the device has nothing more to give. */
    bool (*read)(void *state, ss_device_sample *out_sample);
    /* Exerts `force_n` for one period. */
    void (*exert)(void *state, const double force_n[3]);
    void (*destroy)(void *state);
} ss_device;

/* What every device is told. */
typedef struct ss_device_setup {
    double period_s;
    uint64_t seed; /* of what is random in it */
} ss_device_setup;

/* One kind of device. */
typedef struct ss_device_class {
    const char *name;     /* for --device */
    const char *help;     /* what it is, in a few words */
    const ss_arg *option; /* its own, into its own variables; for --help they begin with its name */
    int32_t option_count; /* 0: `option` may be NULL */
    const char *const *input; /* a file that an option names and it reads; NULL: none */
    bool ends;                /* of itself, as a recording does */
    bool is_hand; /* with a hand of its own: it moves as forces push it, about the contact */
    /* Adds what is wrong with its options, given or missing; `is_chosen`: it is the one that runs.
     * NULL: nothing can be. */
    void (*check)(bool is_chosen, softsim_error *error);
    /* Opens it: fills the device, or adds why not. What it allocates, it allocates here. */
    softsim_status (*create)(const ss_device_setup *setup, ss_device *out_device,
                             softsim_error *error);
} ss_device_class;

/* The kinds built in. Thread: any. */
const ss_device_class *const *ss_device_table(int32_t *out_count);
