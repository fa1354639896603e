/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A simulated haptic device in a simulated hand: the test bench of the whole loop, since none of
 * the devices at hand is one that exerts force.
 *
 * Device and hand move as one mass M = m_dev + m_hand with damping b = b_dev + b_hand, equal in
 * all axes, drawn by the grip's spring k_h and damper b_h towards where the hand wants to be,
 * x_h(t) = script + tremor. In one period T the force F is fixed and 20 steps of
 * delta = T/20 (50 us at 1 kHz) are taken at t_j = n T + j delta, j = 1..20:
 *
 *   v_h = (x_h(t_j) - x_h(t_{j-1})) / delta
 *   v'  = (M v + delta (F + k_h (x_h - x) + b_h v_h)) / (M + delta b)    per axis
 *   v   = v' max(0, 1 - delta f_c / (M |v'|))                            Coulomb friction
 *   x  += delta v                                                        start x = x_h(0), v = 0
 *
 * Damping implicit, springs explicit: stable by far at these stiffnesses, and the same to rounding
 * error for every compiler. The device measures x in counts of 30 um.
 *
 * Tremor per axis: A sum_i w_i sin(2 pi f_i t + phi_i), phases from SplitMix64(seed), axis by
 * axis, frequency by frequency. Scripts are in the contact frame, z out of the tissue.
 * Rejected: an external physics engine (nothing here needs one), and three different axes (no
 * result depended on it).
 */
#include <math.h>
#include <stdlib.h>

#include "devices/sim.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

enum { STEPS = 20, TREMORS = 3 };
static const double count_m = 30e-6;  /* one count of the position sensor */
static const double tremor_m = 50e-6; /* A */
static const double two_pi = 2.0 * SS_PI;
static const double max_exerted_n = 20.0; /* of the simulated motors */

/* Mass kg, damping N s/m, Coulomb friction N. */
static const double bodies[][3] = {{0.05, 0.05, 0.0}, {0.1, 0.3, 0.03}, {0.3, 2.0, 0.1}};
/* Mass kg, stiffness N/m, damping N s/m. */
static const double grips[][3] = {{0.1, 100.0, 2.0}, {0.2, 300.0, 5.0}, {0.5, 800.0, 20.0}};

static const double tremor_hz[TREMORS] = {8.3, 9.7, 11.9};
static const double tremor_weight[TREMORS] = {0.5, 0.35, 0.15};

typedef struct sim {
    ss_sim_config config;
    double mass, damping, friction, hand_stiffness, hand_damping;
    double phase[3][TREMORS];
    int64_t tick;
    double position[3], velocity[3];
} sim;

/* u^3 (10 - 15 u + 6 u^2), from 0 to 1 with velocity and acceleration 0 at both ends. */
static double smooth(double u)
{
    u = fmin(fmax(u, 0.0), 1.0);
    return u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
}

/* Where the script wants the hand, metres in the contact frame. */
static void script_target(ss_sim_script script, double t, double out[3])
{
    const double approach_mm = 4.0 - 12.0 * smooth((t - 0.1) / 0.4);
    double x_mm = 0.0;
    double z_mm = 0.0;
    switch (script) {
    case SS_SCRIPT_PRESS:
        x_mm = 20.0 * smooth((t - 0.6) / 0.6);
        z_mm = approach_mm + 12.0 * smooth((t - 1.4) / 0.4);
        break;
    case SS_SCRIPT_POKE:
        z_mm = 4.0 - 6.0 * (1.0 - cos(2.0 * two_pi * t));
        break;
    case SS_SCRIPT_TAP:
        z_mm = 12.0 * cos(4.0 * two_pi * t);
        break;
    case SS_SCRIPT_SLIDE:
        x_mm = 25.0 * sin(2.0 * t);
        z_mm = approach_mm;
        break;
    case SS_SCRIPT_GRASP:
        z_mm = approach_mm + 18.0 * smooth((t - 0.8) / 0.6);
        break;
    }
    ss_set3(out, 1e-3 * x_mm, 0.0, 1e-3 * z_mm);
}

/* x_h(t) */
static void hand_target(const sim *s, double t, double out[3])
{
    script_target(s->config.script, t, out);
    for (int axis = 0; axis < 3; ++axis) {
        double sum = 0.0;
        for (int i = 0; i < TREMORS; ++i) {
            sum += tremor_weight[i] * sin(two_pi * tremor_hz[i] * t + s->phase[axis][i]);
        }
        out[axis] += tremor_m * sum;
    }
}

static bool sim_read(void *state, ss_device_sample *out_sample)
{
    const sim *s = state;
    const double t = (double)s->tick * s->config.period_s;
    *out_sample = (ss_device_sample){.orientation = {1.0, 0.0, 0.0, 0.0}};
    for (int axis = 0; axis < 3; ++axis) {
        out_sample->position[axis] = count_m * floor(s->position[axis] / count_m + 0.5);
    }
    ss_copy3(out_sample->true_position, s->position);
    ss_copy3(out_sample->true_velocity, s->velocity);
    if (s->config.script == SS_SCRIPT_GRASP && t >= 0.6 && t < 1.8) {
        out_sample->buttons = SOFTSIM_BUTTON_GRASP;
    }
    return true;
}

static void sim_exert(void *state, const double force_n[3])
{
    sim *s = state;
    const double delta = s->config.period_s / STEPS;
    const double start = (double)s->tick * s->config.period_s;
    double before[3];
    hand_target(s, start, before);
    for (int j = 1; j <= STEPS; ++j) {
        double target[3];
        hand_target(s, start + j * delta, target);
        for (int axis = 0; axis < 3; ++axis) {
            const double target_velocity = (target[axis] - before[axis]) / delta;
            const double pull = force_n[axis] +
                                s->hand_stiffness * (target[axis] - s->position[axis]) +
                                s->hand_damping * target_velocity;
            s->velocity[axis] =
                (s->mass * s->velocity[axis] + delta * pull) / (s->mass + delta * s->damping);
        }
        const double speed = ss_norm3(s->velocity);
        const double brake = delta * s->friction / s->mass;
        const double kept = speed > brake ? 1.0 - brake / speed : 0.0;
        ss_scale3(s->velocity, s->velocity, kept);
        ss_madd3(s->position, s->position, delta, s->velocity);
        ss_copy3(before, target);
    }
    ++s->tick;
}

softsim_status ss_sim_create(const ss_sim_config *config, ss_device *out_device,
                             softsim_error *error)
{
    sim *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return ss_memory_fault(error);
    }
    s->config = *config;
    const double *body = bodies[config->body];
    const double *grip = grips[config->grip];
    s->mass = body[0] + grip[0];
    s->damping = body[1] + grip[2];
    s->friction = body[2];
    s->hand_stiffness = grip[1];
    s->hand_damping = grip[2];
    uint64_t random = config->seed;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < TREMORS; ++i) {
            s->phase[axis][i] = two_pi * ss_random_unit(&random);
        }
    }
    hand_target(s, 0.0, s->position);
    *out_device = (ss_device){.state = s,
                              .period_s = config->period_s,
                              .max_exerted_n = max_exerted_n,
                              .read = sim_read,
                              .exert = sim_exert,
                              .destroy = free};
    return SOFTSIM_OK;
}

/* ---- on the command line ---- */

static int32_t chosen_body = SS_BODY_MEDIUM, chosen_grip = SS_GRIP_MEDIUM, chosen_script;
static const ss_arg options[] = {
    SS_CHOICE("--body", &chosen_body, "light|medium|heavy", "sim: the device (medium)"),
    SS_CHOICE("--grip", &chosen_grip, "soft|medium|firm", "sim: the hand (medium)"),
    SS_CHOICE("--script", &chosen_script, "press|poke|tap|slide|grasp",
              "sim: what the hand does, z out of the tissue (press)"),
};

static softsim_status create(const ss_device_setup *setup, ss_device *out_device,
                             softsim_error *error)
{
    const ss_sim_config config = {.body = (ss_sim_body)chosen_body,
                                  .grip = (ss_sim_grip)chosen_grip,
                                  .script = (ss_sim_script)chosen_script,
                                  .seed = setup->seed,
                                  .period_s = setup->period_s};
    return ss_sim_create(&config, out_device, error);
}

extern const ss_device_class ss_device_sim;
const ss_device_class ss_device_sim = {.name = "sim",
                                       .help = "simulated device and hand",
                                       .option = options,
                                       .option_count = sizeof options / sizeof *options,
                                       .is_hand = true,
                                       .create = create};
