/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the hand feels: one haptic tick per period and probe.
 *
 * In: the poses that arrived since the last tick, the newest local contact model. Out: one force,
 * and the proxy that the simulation shall step to. Method: a massless proxy in balance each tick
 * between a spring-damper coupling, which yields only as much as the stiffness limit needs, and
 * the local contact model (reaction + tangent stiffness x 1.15 + bounded viscosity on a curved
 * patch). Watchdog, entry, limits, the energy observer on the device's side with its damping and
 * back-off, and the stiffness limit from the measured loop delay belong to the tick. No clock is
 * read: time is the tick number, so that lockstep and real time run the same code. All memory is
 * allocated by ss_haptic_create; ss_haptic_tick is RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "contact/contact.h"
#include "softsim/types.h"

/* The force goes after so many ticks without a good pose, at any rate, in lockstep too. */
enum { SS_WATCHDOG_TICKS = 50 };

typedef enum ss_between_steps {
    SS_BETWEEN_HOLD,
    SS_BETWEEN_LINEAR,
    SS_BETWEEN_LOCAL
} ss_between_steps;

typedef struct ss_haptic_config {
    double period; /* s, T */
    ss_between_steps between_steps;
    double max_force;     /* N */
    double max_slew;      /* N/s */
    double stiffness;     /* N/m, the stiffest the hand may feel */
    double damping;       /* N s/m, B_c */
    double tool_gyration; /* m, l of the rotational coupling; 0: no torque */
    double thickness;     /* m, of the body: no point of it is further inside */
    bool is_lockstep;     /* velocities and delays from ticks, not from the device's clock */
} ss_haptic_config;

typedef struct ss_haptic_input {
    int64_t tick;             /* number of this haptic period, from 1 */
    const softsim_pose *pose; /* accepted poses since the last tick, oldest first */
    int32_t pose_count;
    uint32_t sender_epoch;              /* grows when the probe's holder changes or returns */
    const ss_simulation_result *result; /* newest result, NULL before the first */
    bool is_result_new;                 /* it arrived since the last tick */
    bool is_paused;
    uint32_t restart_count; /* resets and resumes so far: after each, enter again */
    bool is_stopping;       /* ramp to zero and stay */
} ss_haptic_input;

typedef struct ss_haptic_output {
    bool has_force;      /* false before the probe's first accepted pose */
    softsim_force force; /* utime_us left 0 for the sender */
    ss_proxy_target target;
    double worst_contact_j; /* least energy balance of a contact since start */
    double contact_j;       /* of the contact that is; 0 without one */
    double let_in_j; /* that fading-in pressed into the tissue in the hand's stead, this tick */
    double energy_to_device_j, energy_from_device_j;
    double stiffness_limit;     /* N/m */
    int64_t stiffness_backoffs; /* that contacts which handed out energy took from it, so far */
    int64_t damped_ticks;       /* in which the force was damped for the same reason, so far */
    double loop_delay_ms[2];    /* p50, p95 over 1 s; 5 until known */
    int64_t bad_inputs;         /* ticks or results refused: not finite, normal not a unit one */
} ss_haptic_output;

typedef struct ss_haptic ss_haptic;

/* Thread: set-up only. */
ss_haptic *ss_haptic_create(const ss_haptic_config *config);
void ss_haptic_destroy(ss_haptic **haptic);
/* Thread: haptic; RT-safe. Live values (limits, coupling) may be replaced between ticks. */
void ss_haptic_configure(ss_haptic *haptic, const ss_haptic_config *config);
void ss_haptic_tick(ss_haptic *haptic, const ss_haptic_input *input, ss_haptic_output *output);

/* The proxy predicted half a period past the results' lag: p + v min((lag + 1/2) h, 25 ms), at
 * most 3 mm from p, and no deeper than the force limit goes. Thread: simulation; RT-safe. */
void ss_haptic_predict(const ss_proxy_target *target, double lag_periods, double period,
                       double out_position[3]);
/* And how it will be turned then. */
void ss_haptic_predict_turn(const ss_proxy_target *target, double lag_periods, double period,
                            double out_orientation[4]);

/* FNV-1a 64 of the whole state, for the lockstep hash. RT-safe. */
uint64_t ss_haptic_hash(const ss_haptic *haptic, uint64_t seed);
