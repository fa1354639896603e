/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The parts of one haptic tick, shared by the files of this folder and by its tests.
 *
 * admission.c     the admission gate: ramps (watchdog, pause, fault, stop), entry into tissue
 * local_contact.c the local contact model as a law affine in the proxy, offsets, grasp
 * local_decay.c   how what an update changed decays
 * local_torque.c  the torque of a tool with extent, and its turn
 * friction.c      what holds the proxy along the surface
 * coupling.c      the yielding spring between hand and proxy, the balance, the force limit
 * yield.c         the spring's stiffness, which follows the tissue's
 * slip.c          what the force limit and a grasp let go leave between hand and proxy
 * motion.c        the hand's velocity, acceleration and turn
 * observer.c      energy per contact, loop delay, stiffness limit
 * passivity.c     damping and less stiffness where a contact hands out energy
 * haptic.c        the tick
 * guards.c        poses and results that a tick refuses
 * state.h         a probe's state, of haptic.c and output.c
 * output.c        what it tells
 *
 * Symbols: x pose used, p proxy, p- proxy of the tick before, v hand velocity, T period,
 * n normal out of the tissue, F force on the hand. SI units, world frame. All functions RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "haptic/haptic.h"

enum {
    SS_FORCE_HISTORY = 4096, /* past forces; 4 s at 1 kHz, beyond any live loop delay */
    SS_DELAY_SAMPLES = 4096, /* delay samples of the last second */
    SS_DELAY_BUCKETS = 1024, /* of 50 us: delays up to 51 ms are told apart */
    /* Over the active set, for one stiffness of the spring: 3 x 10^6 random sets of 1 to 8 took at
     * most 10. At the bound the last pass counts: no force is negative, and the spring answers the
     * law but for contacts that begin or end between the last two passes. */
    SS_BALANCE_PASSES = 12,
    /* Of a softened spring, along the force and then all ways, each with passes of its own: at most
     * 12 (1 + 2 x 24) in all; the same sets took at most 53. At the bound the force is
     * cut to the limit where it is above. */
    SS_LIMIT_TRIES = 24,
    /* Ticks at any rate, in lockstep too, where a tick is a pose. */
    SS_RAMP_TICKS = 20,   /* to zero force */
    SS_ENTRY_TICKS = 500, /* the depth fades in */
};

/* ---- guards.c ---- */

bool ss_haptic_is_input_finite(const ss_haptic_input *input);
bool ss_haptic_is_pose_finite(const softsim_pose *pose);
/* Finite and plausible. */
bool ss_haptic_is_result_sound(const ss_simulation_result *result, int64_t tick);

/* ---- motion.c ---- */

typedef struct ss_motion {
    double v[3];      /* m/s, of the hand */
    double mean_v[3]; /* v, smoothed: what v is ahead of it is acceleration */
    double turn[3];   /* rad/s, of the tool */
    double speed;     /* m/s, as fast as it was, fading */
    double covered;   /* m/s, of the last two poses */
    /* When poses come, beside the device's clock: of the last fifty or so. */
    bool is_timed;
    double pace;          /* s, between two poses by that clock */
    double clock_error;   /* s, of it: how far from the pace */
    double arrival_error; /* s, the same of the ticks that they come in */
    double usual;         /* s: how long after the device's time a pose comes when it comes early */
    double late;          /* s: how much later the last one came */
} ss_motion;

void ss_motion_rest(ss_motion *motion);
/* A pose `elapsed` s after the `last`. */
void ss_motion_take(ss_motion *motion, const softsim_pose *last, const softsim_pose *pose,
                    double elapsed);
/* The pose, `count` after the last, came `arrival` s after it; by the device's clock it is
 * `elapsed` s younger, and came `offset` s after its time. */
void ss_motion_time(ss_motion *motion, int32_t count, double arrival, double elapsed,
                    double offset);
void ss_motion_acceleration(const ss_motion *motion, double out[3]);

/* ---- local_contact.c ---- */

/* One contact of the local contact model: parameters as received, state, and what this tick made of
 * them. */
typedef struct ss_local_contact_point {
    double normal[3], point[3];
    double force;           /* N at p_k; -k gap where near */
    double model_stiffness; /* N/m, k_n clamped */
    double stiffness;       /* N/m, k: k_n erring high */
    double tangential;      /* N/m, k_t */
    double viscosity;       /* N s/m, B bounded */
    double curvature[3][3]; /* 1/m */
    double rate;            /* N/s, for linear extrapolation */
    double offset;          /* N, o */
    double drift;           /* N, of the offset, what decays: it, or its mean of some ms */
    double direction[3];    /* n', the normal bent by the curvature */
    double last_force;      /* N, F(p) >= 0 of the last tick */
    double coefficient;     /* mu */
    int32_t station;        /* part of the tool that touches */
} ss_local_contact_point;

/* A grasp: F(p) = force - stiffness (p - position) - viscosity (pdot - velocity) + offset, all
 * directions. */
typedef struct ss_local_contact_grasp {
    bool is_held;
    bool is_ending;   /* the button is up, or it is torn; the model still holds, */
    bool is_answered; /* and has told a force since */
    double force[3], position[3], velocity[3];
    double stiffness[3][3], viscosity[3][3];
    double tangent[3][3]; /* N/m, the model's: `stiffness` errs high */
    double offset[3];     /* N, o */
    double drift[3];      /* N, the offset's mean of some ms */
    double last_force[3]; /* N, F(p) of the last tick */
    double torque[3];     /* N m, of `force`, about the tool's origin */
} ss_local_contact_grasp;

/* What pushes the tool beside its contacts: of the last result, and as far as it acts by now. */
typedef struct ss_local_contact_other {
    double model_force[3], model_torque[3]; /* N, N m */
    double force[3];
    double share; /* of these, that the hand feels */
} ss_local_contact_other;

/* What was felt when a grasp ended, and its share of what is felt, decaying. */
typedef struct ss_local_contact_released {
    double force[3], torque[3]; /* N, N m */
    double share;
} ss_local_contact_released;

/* What the contacts exert along the surface together (friction.c); 0 where mu is. */
typedef struct ss_local_friction {
    bool is_used; /* there is any, or something left of it */
    bool is_sliding;
    double force[3];           /* N, on the hand at the last proxy */
    double offset[3];          /* N, of that: what updates left */
    double held;               /* share of the hand's way along the surface that the proxy does
                                  not go, smoothed */
    double told[3], torque[3]; /* N, N m about the tool's origin: of the last result */
    /* Of the contacts' force, what the model exerts along their surface and against their mean
     * normal: of the last result, and as it comes down to that. */
    double share_told[2], share[2];
    double arm[3];    /* m, from the tool's origin to the middle of the contacts, then */
    double turned[3]; /* m: the way of that by the turn, in the last tick */
} ss_local_friction;

#define SS_OFFSET_TIME_MIN 0.004 /* s, the least in which an offset decays */

typedef struct ss_local_contact {
    bool is_known; /* a result was taken since the proxy was placed */
    int32_t count;
    ss_local_contact_point contact[SS_MAX_CONTACTS];
    ss_local_contact_grasp grasp;
    ss_local_contact_other other;
    ss_local_friction friction;
    bool is_held_back;      /* entering, or at the limit */
    int64_t tick;           /* of the result */
    double result_period;   /* s, h */
    double step_stiffness;  /* N/m, of the last result */
    double swift;           /* N/m, all contacts' of the last result */
    double viscous;         /* N s/m, the same of the law's B */
    double offset_time;     /* s, of this tick */
    double min_offset_time; /* s, the least of the offsets' decay; left by the limit or an entry */
    /* Share of the viscosities that counts. None for a proxy that is about to jump or has: one that
     * rests at the limit joins a hand that comes out in one tick; one found inside goes out to the
     * surface, and the next result's velocity is that way in a period. What they would say comes
     * with the results, and goes through the offsets. */
    double viscosity_fraction;
    double proxy[3];    /* p_k */
    double velocity[3]; /* v_k */
    double depth;       /* m, penetration that the model has not yet yielded to */
    bool has_torque;    /* a tool with extent */
    double orientation[4];
    double turn[3];     /* rad, rotation vector from there to the tool as it is held now */
    double residual[3]; /* N, decaying: what an update changed beyond the contacts' offsets */
    double residual_torque[3]; /* N m, decaying: what it changed of the torque */
    int32_t free_ticks;        /* since a contact was active, SS_RAMP_TICKS at most */
    double outward[3];         /* unit, of the force of the last one that was; 0: none yet */
    ss_local_contact_released released;
} ss_local_contact;

/* One row of the balance: F(p) = max(0, free_force - slope n.(p - p_free)). */
typedef struct ss_balance_row {
    double normal[3];
    double free_force; /* N, at p_free; may be negative */
    double slope;      /* N/m, k' = k + B/T */
} ss_balance_row;

/* What the proxy is balanced against in one tick. */
typedef struct ss_balance {
    double spring;    /* N/m, K_c + B_c/T */
    double p_free[3]; /* proxy without contact */
    int32_t count;
    ss_balance_row row[SS_MAX_CONTACTS];
    bool is_held;
    double grasp_force[3]; /* N, of the grasp at p_free */
    double grasp_slope[3][3];
    /* N, R: on the hand whatever the proxy does: what decays, and what acts beside the contacts.
     * Their shares of p_free are in it. */
    double other[3];
    double limit; /* N, L > 0: of the force on the hand */
    /* Along which the spring softens, unit: the local contact model's force of the tick before; 0:
     * of this one. */
    double axis[3];
} ss_balance;

/* Where the proxy rests. */
typedef struct ss_rest {
    double p[3];
    double force[SS_MAX_CONTACTS]; /* N, F_i(p) */
    double grasp[3];               /* N */
    double stiffness_fraction;     /* of the spring that is left: 1 below the limit */
    bool is_along_axis;            /* the spring softened along it alone, if at all */
} ss_rest;

void ss_local_contact_clear(ss_local_contact *local);
/* Lets offsets decay by one period; slower, and the viscosities fade, where the proxy is not where
 * the hand would have it: `held_back` 1 at the limit, 1 to 0 while entering, and for `time_left`
 * (s). `spring` (N/m): the coupling's, damper included; `speed` (m/s): the hand's, fading. */
void ss_local_contact_decay(ss_local_contact *local, double period, double held_back,
                            double time_left, double spring, double speed);
/* Takes a new result so that the force at the last proxy does not change. `pdot` is the proxy's
 * velocity of the last tick, `x` the pose used. With `is_fresh` nothing is kept of the old law. */
void ss_local_contact_take(ss_local_contact *local, const ss_simulation_result *result,
                           const ss_haptic_config *config, int64_t tick, double spring,
                           const double orientation[4], const double x[3], const double p[3],
                           const double pdot[3], bool is_fresh);
/* The contacts begin without force: offsets hold back what would appear at once. */
void ss_local_contact_begin(ss_local_contact *local, const double x[3], const double p[3],
                            const double pdot[3]);
/* Starts or ends a grasp without changing the force, of which the hand felt at most `limit` (N). */
void ss_local_contact_hold(ss_local_contact *local, const double p[3], const double pdot[3]);
void ss_local_contact_release(ss_local_contact *local, const double x[3], const double p[3],
                              const double pdot[3], double limit);
/* The force of a grasp that is being let go, whose proxy goes to `p` whatever it is. */
void ss_local_contact_end_grasp(ss_local_contact *local, double period, double limit,
                                const double p[3], const double pdot[3]);
/* Moves what acts beside the contacts on by a period, with the limit L (N) of the whole force. */
void ss_local_contact_follow_other(ss_local_contact *local, double period, double limit);
/* Writes the rows of the balance for the pose used `x`, the last proxy `p` and p_free. */
void ss_local_contact_rows(ss_local_contact *local, double period, const double x[3],
                           const double p[3], ss_balance *balance);
/* Where the local contact model puts the tissue's surface: *out_depth > 0 when `x` is inside the
 * plane of vanishing force, with its normal and a point of it. False when no contact is known. */
bool ss_local_contact_surface(const ss_local_contact *local, const double x[3],
                              double out_normal[3], double out_point[3], double *out_depth);
/* How far the proxy, at `p`, may go against unit `out_outward` until the contacts exert `limit`;
 * infinite where none is known, and in a grasp. */
double ss_local_contact_room(const ss_local_contact *local, const double p[3], double limit,
                             double out_outward[3]);
/* Static stiffness tensor of the contacts (all, or those with force) and of a grasp. */
void ss_local_contact_stiffness(const ss_local_contact *local, bool only_active, double out[3][3]);
/* n.(A n) of those with force. */
double ss_local_contact_stiffness_along(const ss_local_contact *local, const double n[3]);
/* Of what has force, over a span of `seconds`: the law's within a result, the model's own over
 * many.
 */
void ss_local_contact_tangent(const ss_local_contact *local, double seconds, double out[3][3]);
/* After a tick's forces were set: `direction` of their force, 0 without any, and its `size`, N.
 * What updates left takes off no more than that: it draws no tool in. Without a contact it only
 * pushes out, along the last one, nor does it draw aside. */
void ss_local_contact_clip_residual(ss_local_contact *local, const double direction[3],
                                    double size);
/* The sum of the last tick's forces; and what is felt of it beside what a grasp let go left. */
void ss_local_contact_force(const ss_local_contact *local, double out[3]);
void ss_local_contact_felt(const ss_local_contact *local, double out[3]);
/* What `hold` and `linear` hand out in its place. */
void ss_local_contact_extrapolate(const ss_local_contact *local, const ss_haptic_config *config,
                                  int64_t tick, double out[3]);
int32_t ss_local_contact_active_count(const ss_local_contact *local);
/* What results and ticks have left in it. */
uint64_t ss_local_contact_hash(const ss_local_contact *local, uint64_t hash);

/* ---- local_torque.c ---- */

/* The tool is held at `orientation` from now on. */
void ss_local_contact_turn(ss_local_contact *local, const double orientation[4]);
/* Torque of the last tick's forces about the tool's origin, and what is felt of it. */
void ss_local_contact_torque(const ss_local_contact *local, double out[3]);
void ss_local_contact_felt_torque(const ss_local_contact *local, double out[3]);
/* What an update or a grasp changed of the torque, which was `before`, decays. */
void ss_local_contact_keep_torque(ss_local_contact *local, const double before[3]);

/* ---- friction.c ---- */

/* Offsets decay to `kept` of what they were. */
void ss_friction_decay(ss_local_friction *friction, double kept);
/* A new result's, with the proxy at `p`, so that the force stays. After the contacts. */
void ss_friction_take(ss_local_contact *local, const ss_contact_set *set, const double p[3]);
/* The balance with friction, from the proxy `p` of the last tick on, for a coupling of `spring`;
 * `rest` is where it rests without. Its force is then in the balance's `other`. */
void ss_friction_balance(ss_local_contact *local, const double p[3], double spring, double period,
                         ss_balance *balance, ss_rest *rest);
/* Adds its torque about the tool's origin. */
void ss_friction_torque(const ss_local_contact *local, double out[3]);

/* ---- coupling.c ---- */

/* Solves the balance: s spring (p - p_free) = sum F_i(p) n_i + grasp, s the stiffness fraction,
 * < 1 where the force on the hand comes to the limit. Returns the passes used. Where a law without
 * stiffness or the decaying forces alone exceed the limit, the force stays above it. */
int ss_coupling_balance(const ss_balance *balance, ss_rest *out_rest);
/* Largest eigenvalue of a symmetric matrix. */
double ss_max_eigenvalue3(double matrix[3][3]);
/* The spring K_c that lets the hand feel at most `limit` against tissue of stiffness k (0:
 * unknown). */
double ss_coupling_spring(double limit, double k);
/* x of A x = b, A symmetric positive definite. */
void ss_cholesky_solve3(double a[3][3], const double b[3], double out[3]);

/* Stiffest coupling, N/m: stiffer gains nothing that a hand feels and costs digits. */
#define SS_MAX_COUPLING_STIFFNESS 20000.0

/* ---- yield.c ---- */

enum { SS_YIELD_PIECES = 200 }; /* of the spring's compliance, from 1/20000 to 1 m/N, 5 % each */

typedef struct ss_yield {
    double spring;     /* N/m, K_c */
    double rest[3];    /* m, r: where it is without force, from the hand's point (slip.c) */
    double stretch[3]; /* m, s: from there to the proxy */
    double load;       /* N, on the spring, within the limit */
    /* Of this contact: the mean F^2 (N^2) that each piece of the compliance was taken under, and
     * what may be given back beyond it, J. */
    double paid[SS_YIELD_PIECES], credit;
    bool has_paid;
} ss_yield;

/* The spring is without force at the hand; its stiffness stays. */
void ss_yield_clear(ss_yield *yield);
/* Moves K_c towards `wanted`, in contact without a step of the force. */
void ss_yield_follow(ss_yield *yield, double wanted, bool is_in_contact, bool is_grasping,
                     double period);
/* dF/dx along unit `n` that the hand feels of tissue with this tensor. */
double ss_yield_felt(const ss_yield *yield, double tissue[3][3], const double n[3]);
/* What a balance within `limit` (N) left, the hand's point being at `hand`. At the limit the spring
 * is held by `force`, that on the hand: the rest of the way to the proxy is slip. */
void ss_yield_take(ss_yield *yield, const double hand[3], const ss_rest *rest,
                   const double force[3], double limit);

/* ---- slip.c ---- */

typedef struct ss_slip {
    double limit;              /* N, of the force; follows config.max_force */
    double stiffness_fraction; /* of the coupling that is left: 1 below the limit */
    double length;       /* m, out of the tissue, beyond what the force stretches the coupling */
    double direction[3]; /* of the local contact model's force, unit or 0 */
    double aside[3];     /* m, from the hand to where the coupling is without force: it fades */
    double turning;      /* s, left of the time in which a lowered limit turns it slowly */
    bool is_kept;        /* not yet: a grasp is being let go */
    bool is_from_grasp;  /* left by a grasp: the whole of it, until the force is at the limit */
} ss_slip;

/* Nothing is left; the limit stays. */
void ss_slip_clear(ss_slip *slip);
/* Moves the limit towards config->max_force, by at most `step` (N) a tick, from a force of `size`;
 * up so that tissue of `stiffness` (N/m, as felt) can follow. True while it goes down. */
bool ss_slip_follow(ss_slip *slip, const ss_haptic_config *config, double step, double size,
                    double stiffness);
/* After a limit was lowered to below the force, `force` (N, about to be felt) keeps its size and
 * turns from `last`, that of the tick before, by 13 rad/s at most, and more where the hand moved:
 * `way`, m, in this tick. True where that held it back. */
bool ss_slip_turn(ss_slip *slip, const double last[3], double way, double period, double force[3]);
/* A grasp takes hold: at the limit `aside` becomes what lies across the grasp's `force` of
 * `stretch`, from the hand to the proxy (m, without what pulls at the proxy beside spring and
 * grasp), so that the force keeps its direction. */
void ss_slip_hold(ss_slip *slip, const double stretch[3], const double force[3]);
/* s: until a hand with velocity v comes out of the limit; INFINITY where it does not, or is not
 * there. */
double ss_slip_time_left(const ss_slip *slip, const double v[3]);
/* Has a grasp that was let go left the proxy too far from the hand to come back? */
bool ss_slip_is_lost(const ss_slip *slip);
/* What a balance with a coupling of `spring` leaves; `force` is the local contact model's. */
void ss_slip_take(ss_slip *slip, const ss_balance *balance, const ss_rest *rest,
                  const double force[3], double spring, double period);

/* ---- observer.c ---- */

typedef struct ss_past_force {
    int32_t seq;
    int64_t tick, pose_tick, pose_utime_us;
    double force[3], torque[3]; /* N, N m */
} ss_past_force;

typedef struct ss_observer {
    /* state: energy */
    bool has_sample, is_in_contact;
    bool is_told; /* the device says which force was in effect */
    double x[3], orientation[4];
    int32_t force_seq;
    double energy, worst, to_device, from_device; /* J */
    int64_t contacts;                             /* so far */
    /* state: delay */
    bool is_known;
    bool is_settled;             /* the limit has been what the delay allows */
    double delay_p50, delay_p95; /* s */
    double limit;                /* N/m, K_max */
    int32_t sample_head, sample_count;
    int64_t last_tick;
    int32_t last_seq;
    uint32_t bucket_count[SS_DELAY_BUCKETS];
    uint16_t sample_bucket[SS_DELAY_SAMPLES];
    int64_t sample_tick[SS_DELAY_SAMPLES];
    ss_past_force history[SS_FORCE_HISTORY];
} ss_observer;

/* A new holder: delays and the running contact are forgotten, sums and the worst contact stay. */
void ss_observer_restart(ss_observer *observer, const ss_haptic_config *config, bool corrects);
/* The stream of poses was interrupted: the running contact ends. */
void ss_observer_break(ss_observer *observer);
/* An accepted pose, received in `tick`. */
void ss_observer_pose(ss_observer *observer, const ss_haptic_config *config,
                      const softsim_pose *pose, int64_t tick);
/* A force that was handed out. */
void ss_observer_force(ss_observer *observer, const ss_past_force *record);
/* Once a tick: the delay's quantiles and the stiffness limit. */
void ss_observer_tick(ss_observer *observer, const ss_haptic_config *config, bool corrects,
                      bool is_in_contact, int64_t tick);
/* What a tick knows of the hand, beside the observer. */
typedef struct ss_passivity_tick {
    double period;      /* s */
    double velocity[3]; /* m/s, of the hand */
    double acceleration[3];
    double stiffness; /* N/m, felt; 0: none */
    bool corrects, is_grasping;
} ss_passivity_tick;

/* The energy of the contact, J, when all that was sent has reached a hand that goes on as it does.
 */
double ss_observer_foresee(const ss_observer *observer, const ss_passivity_tick *now);
/* The rule K_max(tau). */
double ss_observer_rule(const ss_haptic_config *config, double delay, bool corrects);

/* ---- passivity.c ---- */

typedef struct ss_passivity {
    double share;       /* of the limit that back-offs have left */
    double forgiven;    /* J: the contact's energy at its last back-off */
    int64_t contact;    /* that it belongs to */
    int64_t since;      /* ticks, the last back-off */
    int64_t backoffs;   /* so far */
    int64_t actions;    /* ticks so far that were damped or bounded */
    double lent;        /* J: to the contact, by time */
    double let_in;      /* J: that an entry put into the contact in the hand's stead */
    double damping;     /* N s/m: of the last tick, on its way back to 0 */
    double bound;       /* N: that the last force was, or would be, held to; INFINITY: none */
    double bound_share; /* 0 .. 1, of the bound that holds: by how long the loop is, */
    double soft_share;  /* and how far the damper has gone to the long loop's */
} ss_passivity;

void ss_passivity_init(ss_passivity *passivity);
/* Another device: what the last one told, or did, is not held against it. */
void ss_passivity_restart(ss_passivity *passivity);
/* Once a tick: backs off, and comes back. */
void ss_passivity_step(ss_passivity *passivity, const ss_observer *observer, double period,
                       bool is_in_contact);
/* K_max that is left. */
double ss_passivity_limit(const ss_passivity *passivity, const ss_observer *observer);
/* An entry moved the pose used nearer to the hand, against the force. */
void ss_passivity_let_in(ss_passivity *passivity, double energy);
/* Damps or bounds `force` where the contact is about to hand out energy; true when it did. */
bool ss_passivity_damp(ss_passivity *passivity, const ss_observer *observer,
                       const ss_passivity_tick *now, double force[3]);

/* ---- admission.c ---- */

typedef enum ss_phase {
    SS_PHASE_SILENT,   /* no device: the tool is out of the world */
    SS_PHASE_WAITING,  /* placed again: no result for this place yet, no force */
    SS_PHASE_ENTERING, /* found in tissue: the depth fades in */
    SS_PHASE_IN,
    SS_PHASE_RAMPING /* down to zero, then silent or waiting */
} ss_phase;

typedef struct ss_admission {
    ss_phase phase;
    bool is_stopped;    /* for good */
    bool is_model_late; /* or at fault */
    bool is_stale;
    bool is_paused;
    int64_t ticks;         /* of the phase so far; none that the thread slept through */
    int64_t placed;        /* tick at which the proxy was placed: older results do not count */
    double entry_point[3]; /* of the surface, smoothed */
    double entry_normal[3];
    double held_back; /* share of the depth that a ramp found not yet let in */
} ss_admission;

/* What the admission is told in a tick. */
typedef struct ss_admission_input {
    int64_t tick;
    double period;
    int64_t pose_tick; /* of the newest pose: stale SS_WATCHDOG_TICKS later */
    bool is_paused, is_reset, is_stopping;
    bool is_new_holder; /* the first pose of a sender */
    bool is_fault;      /* the model says so */
    bool has_result;    /* a result since the proxy was placed */
    int64_t result_tick;
    bool has_force; /* something to ramp down from */
} ss_admission_input;

/* Moves the phase; true when the local contact model is void and the proxy goes to the pose. */
bool ss_admission_step(ss_admission *admission, const ss_admission_input *input);
/* Share of the depth that entering has not let in yet. */
double ss_admission_left(const ss_admission *admission);
/* The first result for this place: enters. */
void ss_admission_enter(ss_admission *admission);
/* The tool was found inside: enters by fading, from the surface at `point` in this tick on. */
void ss_admission_fade(ss_admission *admission, int64_t tick, const double point[3],
                       const double normal[3]);
/* Follows the surface while entering. */
void ss_admission_follow(ss_admission *admission, double period, const double point[3],
                         const double normal[3]);
/* The pose and hand velocity to use: faded towards the surface while entering, and as far as that
 * had come while ramping. */
void ss_admission_pose(const ss_admission *admission, double x[3], double v[3]);
/* 1 .. 0 while ramping, 0 when silent or waiting. */
double ss_admission_gain(const ss_admission *admission);
/* SOFTSIM_FORCE_RAMPING, _STALE and _MODEL_FAULT. */
int32_t ss_admission_flags(const ss_admission *admission);
