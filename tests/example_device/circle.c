/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A device that goes round in a circle across its x and y, once a second, and heeds no force. How a
 * device is added: clients/README.md.
 */
#include <math.h>
#include <stdlib.h>

#include "device.h"
#include "rt/vec.h"

static double chosen_radius_mm = 10.0;
static const ss_arg options[] = {
    {"--radius-mm", SS_ARG_NUMBER, &chosen_radius_mm, 0.1, 100.0, "MM", "circle: its radius (10)"},
};

typedef struct circle {
    double period_s, radius_m;
    int64_t tick;
    double force_n[3];
} circle;

static bool read_circle(void *state, ss_device_sample *out_sample)
{
    const circle *c = state;
    const double angle = 2.0 * SS_PI * (double)c->tick * c->period_s;
    *out_sample = (ss_device_sample){.orientation = {1.0, 0.0, 0.0, 0.0}};
    ss_set3(out_sample->position, c->radius_m * cos(angle), c->radius_m * sin(angle), 0.0);
    ss_copy3(out_sample->true_position, out_sample->position);
    ss_set3(out_sample->true_velocity, NAN, NAN, NAN); /* unknown: taken from the positions */
    return true;
}

static void exert(void *state, const double force_n[3])
{
    circle *c = state;
    ss_copy3(c->force_n, force_n); /* where a real device's motors are told */
    ++c->tick;
}

static softsim_status create(const ss_device_setup *setup, ss_device *out_device,
                             softsim_error *error)
{
    circle *c = calloc(1, sizeof *c);
    if (c == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory");
        return SOFTSIM_ERROR_MEMORY;
    }
    c->period_s = setup->period_s;
    c->radius_m = 1e-3 * chosen_radius_mm;
    *out_device = (ss_device){.state = c,
                              .period_s = setup->period_s,
                              .max_exerted_n = 3.0,
                              .read = read_circle,
                              .exert = exert,
                              .destroy = free};
    return SOFTSIM_OK;
}

extern const ss_device_class ss_device_circle;
const ss_device_class ss_device_circle = {.name = "circle",
                                          .help = "a circle",
                                          .option = options,
                                          .option_count = sizeof options / sizeof *options,
                                          .is_hand = true,
                                          .create = create};
