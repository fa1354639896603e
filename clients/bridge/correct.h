/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The force in effect, corrected for the time it took, and damped where it drives the hand.
 *
 * A force F answers a pose x_a that is old by the trip there and back. Along the tissue's normal n
 * the felt stiffness S says how it changes with position, so at the present position x
 *
 *   F_device = n c + t (h min(1, c / n.F) + max(0, |F_t| - h - S max(0, t.(x - x_a)))),
 *   c = max(0, n.F - S n.(x - x_a)),   F_t = F - n (n.F) = |F_t| t,   h = min(|F_t|, n.F)
 *
 * which leaves a fifth of the energy that the delay would hand to the hand, and holds 6 to 8 times
 * the stiffness. Of what lies across, h goes with what it lies on (kept whole it turned the force
 * by 146 degrees in a tick as a tap left); the rest no friction holds: a grasp that was let go
 * fades, with a normal force of nearly nothing (all of it went with that: 1.6 N, 0 and 1.5 in three
 * ticks). A grasp holds the tool all ways and may pull: while the force says so,
 *
 *   F_device = F - S (x - x_a)
 *
 * and what that differs by from the law above when it ends goes in 20 ms (a hand that let go as it
 * left at .37 m/s behind 10 ms had 1.4 N and 3.4 in the next tick).
 *
 * No correction where S = 0, n.F <= 0 without a grasp, |x - x_a| > 15 mm, the pose is older than
 * 50 ms, or any of it makes no sense: there the linear law no longer speaks of the present. (With 5
 * mm a tap of 0.3 m/s was left uncorrected behind a bus of 10 ms, where it hands out most.)
 *
 * The line through one answer is not the tissue: it is held off by 20 ms of motion, and what it
 * gives back on the way out the hand has not paid on the way in (a fast tap over 10 ms: 20 mJ, with
 * late messages 80). Only here is known at once what the hand was given: E = sum -F . dx of the
 * contact under way. A hand that goes on at v along the force will be given, within 5 ms, or
 * a longer period of the device's,
 *
 *   W = w (F - S w / 2),   w = min(v 5 ms, F / S)
 *
 * (a spring that was paid for gives back no more than it took, and loses nothing here). Where W is
 * more than E + 0.1 mJ, the force is
 *
 *   F max((E + 0.1 mJ) / W, 1 - alpha v / F, 0),   alpha = min(60 N s/m, 0.1 kg 2 pi f)
 *
 * and never more than F: a hand that presses feels what it felt. (With one period for 5 ms, 3 N on
 * a hand that left at .6 m/s were gone in a tick.) v is filtered at f = 20 Hz and 2 Hz for each
 * mm/s of it (Casiez, Roussel and Vogel, 1 euro filter, CHI 2012): a count of 30 um of a hand at
 * rest is 4 mm/s, a tap is known after 3 ms. (At 100 Hz it was 14, and in a debt each count took
 * half of the force for a tick.) It is late by 1 / 2 pi f, and alpha as much smaller: with 60 N s/m
 * at any speed a hand and device of 60 g that came to rest in debt were swung by 1 N on and on.
 *
 * What is taken off is given back in 20 ms: else the next tick of a tap that left had all of it
 * again, and the one after it nothing. A hand that turns and presses has it back within 0.03 mm, or
 * it would pay less for the way in than it got for the way out, and never be out of debt. Debts are
 * forgotten within 0.4 s, so that tissue which moves of itself, or at another tool, still pushes a
 * hand, slowly.
 *
 * While the server lets a tool in (its force is flagged so, and comes), it counts what it presses
 * in for the hand and damps by itself, and here nothing is counted; what the contact has stored
 * when that ends, F^2 / 2 S, is the hand's. At the force limit S is 0, and the contact has stored F
 * times a slip that is not told: 5 mm of it are the hand's until S is. So it is where forces come
 * again. (Counted as a debt, each count of the device on the way out took the whole force for a
 * tick: after a gap of 50 ms it buzzed between nothing and all.)
 *
 * The force stays within the limits that the server holds: corrected, its size is at most L, or
 * that of the answer where this is more (a limit is being lowered); corrected or not, it moves by
 * at most the slew before it fades and what is damped is taken off. While L is not known it is at
 * most the answer's. (Without it, 4.9 N of a limit of 1 in taps behind a bus of 10 ms.)
 *
 * When no force has come for 50 ms (the server is gone) the last one fades to zero in 20 ms, and
 * where they come again comes back in 50 ms.
 * World frame, SI. Thread: the bridge's loop; no allocation after creation.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/types.h"

/* Poses remembered: a force is corrected only when it answers one of them. */
enum { SS_CORRECT_HISTORY = 1024 };

/* What the server holds its forces within. */
typedef struct ss_corrector_limits {
    double force_n; /* 0: not known */
    double slew_n_per_s;
} ss_corrector_limits;

/* For forces of no server. */
extern const ss_corrector_limits ss_corrector_unlimited;

typedef struct ss_corrector {
    bool is_enabled;
    ss_corrector_limits limits;
    bool has_force;
    softsim_force force; /* in effect */
    int64_t received_ns;
    /* state: the contact's energy */
    bool has_exerted, is_touching, was_grasping;
    double left[3];     /* N, of the grasp that ended */
    bool is_let_in;     /* the force is ramping, */
    bool is_owed;       /* or was, and what the contact stored meanwhile is not counted yet */
    double taken;       /* share of the force, by damping */
    double present;     /* share: 1 while forces come, and after a silence in the end */
    double undamped[3]; /* the last force, before its share and what is damped */
    int64_t exerted_ns;
    double exerted[3], exerted_at[3];
    double velocity[3]; /* m/s, */
    double cutoff_hz;   /* filtered so */
    double energy_j;    /* that it has taken from the hand */
    struct {
        int32_t seq; /* 0: empty */
        int64_t time_ns;
        double position[3];
    } history[SS_CORRECT_HISTORY];
} ss_corrector;

void ss_corrector_init(ss_corrector *corrector, bool is_enabled, ss_corrector_limits limits);
/* Remembers a pose that is about to be sent. `seq` from 1. */
void ss_corrector_note_pose(ss_corrector *corrector, int32_t seq, int64_t time_ns,
                            const double position[3]);
/* Puts a force into effect: the newest that came wins. */
void ss_corrector_take_force(ss_corrector *corrector, const softsim_force *force,
                             int64_t receive_ns);
/* What to exert at `position` from now on. Zero before the first force. */
void ss_corrector_force(ss_corrector *corrector, int64_t now_ns, const double position[3],
                        double out_force[3]);
/* `share` of the force returned last was not exerted: the hand gave nothing for it; where that is
 * all of it, the next begins at zero, whatever this one was. */
void ss_corrector_withhold(ss_corrector *corrector, double share);
/* seq of the force in effect, -1 when there is none (yet, or any more). */
int32_t ss_corrector_force_seq(const ss_corrector *corrector, int64_t now_ns);
