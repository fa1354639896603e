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
 * Untold. The force may be slow and far below its limit, and still drive the hand: 0.7 N at 7 Hz
 * gave 23 mJ. What a device was given is known but for its lag D, of both ways and its own: the sum
 * of F(t - D).dx. So for a device that tells neither applied_force nor force_seq and does not
 * correct, with a clock, D = 4, 8, .. 24 ms are all looked at, over a contact, which 20 ms without
 * any force end:
 *
 *   U_D = sum F(t - D).dx + T(t - D).theta,   V_D <- V_D e^(-dt/1 s) + F'(t - D).dx'
 *
 * F' and x' are what is left above 6 Hz (second order). Guarded beyond U = 30 mJ within a contact's
 * first 0.5 s, or V = 8 mJ after them. No sum of what the server sees tells a device without any
 * delay whose hand shakes what it grasped from one that is driven: the motion is the same. So V is
 * what a hand seldom reaches, and the reason says "if". Measured on kidneys, the worst of each in
 * mJ (without delay: U; V; with 3 to 10 ms each way also what the hand was given in one contact):
 *
 *   without delay                U    V | late                        given    U    V
 *   presses, holds, free slides  7    6 | a grasp held still, 6.8 Hz     23    0    9
 *   pokes to .5 m/s             28    1 | held and trembling             27   38   21
 *   taps at 4 Hz, 8 mm           9    0 | a grasp swung by 25 mm        112  209  126
 *   the same, 16 mm             30    0 | the same on a coarse mesh     770  527  385
 *   a grasp shaken by 6 mm, 3 Hz 2    1 | a poke                         15   26    1
 *   the same, 4 Hz               4    6 | a tap                          13   26    0
 *   the same, 6 Hz              19   42 | a grasp that trembles          14   20    5
 *
 * Of 130 hands that are late and tell nothing 22 got more than 10 mJ: 10 with a good verdict
 * before, now the last three of the table. Of 131 without a delay 9 are told: they shake what they
 * grasped at 4 to 25 Hz by centimetres, tremble by 2 mm, or tap at 7 Hz and .5 m/s. Rejected: U
 * alone over whole contacts (it grows with every shake at 2 Hz), V alone (a tap is quick), and the
 * energy that went to the tissue for comparison (it is the same with and without a delay).
 *
 * A device that tells applied_force alone is known but for the poses that were lost: what they
 * would have told is taken as the mean of the force before and after (125 Hz, a sixth lost: 14.6
 * mJ, not 9.5; given 16.6).
 *
 * Silence. While poses stop, the force stays for 50 ticks and then goes in 20: a hand that leaves
 * meanwhile is given what belongs to where it was, and the first pose after it tells the last force
 * alone. (A kidney, taps, a hand of .8 kg: 43 mJ in a silence of 60 ms, of which the observer
 * had 4.) So with a clock, and 20 ms more between two poses than usual, or 40 ms, the hand is taken
 * to have gone all the way out with the strongest force of that time, told or sent, or all the way
 * in with the weakest (pressed by 13 mm meanwhile one had spent 5 mJ, by the last force 14):
 *
 *   E' = E - F.(x_after - x_before) - T.theta,   E the observer's sum as of the pose before
 *
 * For a client that corrects and tells its force, which falls with the way, F is the mean of what
 * it told before and after. E' below -10 mJ is guarded, and what the observer does not have of it
 * counts to the end of its contact. Where the watchdog let go of a force it is guarded whatever the
 * way: how far the hand went nobody knows. That is told when the same device is heard again; one
 * that never comes back has gone, or is another. Never degraded: it is a bound, and not what was
 * measured.
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
/* For forces of which nobody tells when they took effect: the lags looked at, and ticks kept. */
enum { SS_UNTOLD_LAGS = 6, SS_UNTOLD_TICKS = 64 };
/* s, damping over stiffness: at 0.04 s no touch is late, at 0.12 s by 0.07 s. */
static const double SS_LONGEST_TRAIL_S = 0.05;

/* What a watch adds to the verdict of all; SOFTSIM_VERDICT_GOOD and "": nothing. */
typedef struct ss_hand_verdict {
    softsim_verdict verdict;
    const char *reason; /* static */
} ss_hand_verdict;

/* What is left of a vector above 6 Hz. Start from zero, and `low` at the first value. */
typedef struct ss_high_pass {
    double band[3], low[3];
} ss_high_pass;

/* A device that does not tell which force it exerts. Start from zero. */
typedef struct ss_untold {
    double force[SS_UNTOLD_TICKS][3], torque[SS_UNTOLD_TICKS][3]; /* of the last ticks, a ring */
    double fast[SS_UNTOLD_TICKS][3];                              /* N, of `force` above 6 Hz */
    double energy[SS_UNTOLD_LAGS], shaken[SS_UNTOLD_LAGS];        /* J, U and V, one for each lag */
    double let_in;                                                /* J, in this contact */
    double fast_place[3], fast_way[3];                            /* m, above 6 Hz */
    ss_high_pass force_pass, place_pass;
    bool is_on;
    int64_t since, touched; /* tick of the first and of the last force */
    int64_t noted;          /* the last tick in the ring */
} ss_untold;

/* A device whose poses may stop. Start from zero. */
typedef struct ss_silence {
    bool has_pose;
    bool was_let_go;                /* the watchdog has acted since the last pose */
    int64_t sender, pose_tick;      /* of the last pose, and its tick */
    double usual;                   /* ticks from pose to pose, smoothed */
    double contact_j;               /* as of the last pose */
    double strongest[3], torque[3]; /* N, since, told or sent; N m, what was sent with it */
    double weakest[3];              /* N */
    double applied[3];              /* N, told with the last pose, where it was */
    double sent_n;                  /* N, the strongest sent since */
    double unseen_j;                /* J, in this contact, beyond what the observer counts */
} ss_silence;

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
    ss_untold untold;
    ss_silence silence;
    bool is_alone;             /* by the last pose: applied_force without force_seq */
    int32_t seq;               /* of the last pose */
    double applied[3], lost_j; /* N, of the last pose, where known; J, in this contact */
    bool is_told; /* by the last pose: which force is exerted, or that it is corrected */
    double device_j, others_j, load_work; /* as of the last tick, and result */
    ss_hand_verdict last_verdict;
    int64_t until; /* tick: it holds before it */
} ss_hand_watch;

typedef struct ss_hand_tick {
    int64_t tick;
    double period;                      /* s */
    const softsim_pose *pose;           /* the newest, NULL: none came */
    int32_t superseded;                 /* poses that came in this tick before it */
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
