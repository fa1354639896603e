/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Energy that no work explains, watched from outside the models: one rule for all of them.
 *
 * Tissue. A model's own energy balance books whatever force met a tool on its way as the tool's
 * work. But no hand does more than haptic.max_force_n allows: beyond that the proxy slips. With S
 * the kinetic and elastic energy, W the work of loads, gravity and supports, d the furthest way of
 * any point of a tool in a step and L the limit, what
 *
 *   U <- max(0, U e^(-dt/0.1 s) + dS - dW - L sum d)
 *
 * adds up is energy that no tool work explains. Beyond L R + |W|/10 (R the tools' bounding radius)
 * the verdict is guarded, beyond ten times that degraded; beyond a hundred times it is a fault: the
 * model is stepped no more, forces ramp to zero, `reset` recovers. Scenes without a tool are not
 * watched: there a model's own energy balance has all work.
 *
 * Hand. E = sum F.(x_j+1 - x_j) + T.theta_j since a contact's first force, F and T the answer to
 * pose j or to pose j - 1, whichever gives more: tissue hands out no more than it got. The same is
 * added up over contacts that follow one another within 20 ms: they chatter. It holds where a pose
 * has one answer, in lockstep and headless; with a clock between them what counts is the haptic
 * loop's observer, for clients that name the force in effect. More than 10 mJ is a guarded verdict
 * until a second after it, more than 100 mJ a degraded one. What was let in with a tool that was
 * found inside the tissue is taken off, for as long as energy is added up that it may be part of:
 * until 20 ms after the last force, and with a clock until the client has named that one. Where
 * that alone is handed back, guarded for that reason.
 *
 * Over a whole contact, energy absorbed early can hide energy created later. So each part
 * of a contact is judged too, by the same two limits, where the model tells what it has stored:
 * supply.h. What an entry, loads and the hands of other tools put in explains what this hand gets.
 * Rejected: a verdict on the power of a tick (a release after a slow press is quick).
 *
 * Lag. After a jump, or above the velocity limit, the proxy lags the hand, and catches up with the
 * time constant of the coupling, its damping over its stiffness. Where that is longer than
 * SS_LONGEST_TRAIL_S and the tool has been 3 mm behind for 20 ms while nothing was felt, degraded:
 * a blow is then felt late or not at all. Refusing such a scene was rejected: both values may be
 * set while it runs, and a hand that never jumps is served well.
 *
 * Shaking. Energies are of no use where a device does not say which force it exerts: behind 10 ms
 * of a bus, which it does not tell, a light hand was swung at 16 Hz with 8 N, and got 33 J. So the
 * ways that the force has gone are added up, and fade:
 *
 *   S <- S e^(-dt/0.5 s) + |F - F_last|
 *
 * Beyond 25 times the force limit, as of a force that turns round at the limit 8 times a second, or
 * comes and goes 25 times, the verdict is guarded: no hand does that by itself.
 *
 * Nothing here changes a force or a state, but for the fault. All of it is RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "contact/contact.h"
#include "models/model.h"
#include "softsim/types.h"
#include "world/supply.h"

/* Thread: simulation. Start from zero, with `limit` and `size` set. */
typedef struct ss_energy_watch {
    double limit; /* N; 0: not watched */
    double size;  /* m, R */
    double stored, load_work, pool;
    bool has_stored;
    softsim_verdict verdict;
} ss_energy_watch;

/* After a step that took the tools ways of `way` metres in all. */
void ss_energy_watch_step(ss_energy_watch *watch, const ss_model_info *info, double way, double dt);
/* What it has to add to the model's verdict. */
void ss_energy_watch_judge(const ss_energy_watch *watch, ss_model_info *info);
/* A parameter was set: what that does to the energy in the next step is nobody's work. */
void ss_energy_watch_skip(ss_energy_watch *watch);
/* The model is at rest again. */
void ss_energy_watch_reset(ss_energy_watch *watch);

/* Of SS_SUPPLY_DEVICES the first two, by the delay of an answer; the last names the force that it
 * exerts, or tells it. */
enum { SS_HAND_WATCH_DELAYS = 2, SS_HAND_WATCH_NAMED = SS_HAND_WATCH_DELAYS };
/* s, damping over stiffness: at 0.04 s no touch is late, at 0.12 s by 0.07 s. */
static const double SS_LONGEST_TRAIL_S = 0.05;

/* What a watch adds to the verdict of all; SOFTSIM_VERDICT_GOOD and "": nothing. */
typedef struct ss_hand_verdict {
    softsim_verdict verdict;
    const char *reason; /* static */
} ss_hand_verdict;

/* One probe. Thread: haptic. Start from zero. */
typedef struct ss_hand_watch {
    bool has_pose;
    uint32_t sender_epoch;
    double position[3], orientation[4];
    double force[SS_HAND_WATCH_DELAYS][3], torque[SS_HAND_WATCH_DELAYS][3]; /* newest first */
    double energy[SS_HAND_WATCH_DELAYS]; /* J, since the contact's first force */
    double spell[SS_HAND_WATCH_DELAYS];  /* J, since the first after 20 ms without */
    double let_in;                       /* J, over the spell, or as long as contact_j is not 0 */
    int64_t touched;                     /* tick of the last force */
    int64_t trailing;                    /* ticks on end that the tool is behind, unfelt */
    double last_force[3], shaking;       /* N; S, N */
    ss_supply supply;
    double device_j, others_j, load_work; /* as of the last tick, and result */
    ss_hand_verdict last_verdict;
    int64_t until; /* tick: it holds before it */
} ss_hand_watch;

typedef struct ss_hand_tick {
    int64_t tick;
    double period;                      /* s */
    const softsim_pose *pose;           /* the newest, NULL: none came */
    uint32_t sender_epoch;              /* of that pose */
    const softsim_force *sent;          /* the answer of this tick */
    const ss_simulation_result *result; /* that came in this tick, or NULL */
    double contact_j;                   /* of the present contact, of the haptic loop's observer */
    double device_j; /* given to the device in all contacts so far, by the same */
    double others_j; /* put in so far by the hands of other probes */
    double let_in_j; /* by the haptic loop, in this tick */
    double trail_s;  /* damping over stiffness of the coupling */
    double max_force_n;
    bool is_lockstep;
} ss_hand_tick;

void ss_hand_watch_tick(ss_hand_watch *watch, const ss_hand_tick *now);
/* What holds at this tick. */
ss_hand_verdict ss_hand_watch_verdict(const ss_hand_watch *watch, int64_t tick);
/* The worse of two; of equal ones the first. */
ss_hand_verdict ss_hand_verdict_worse(ss_hand_verdict a, ss_hand_verdict b);
