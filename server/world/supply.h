/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Energy given to the hand beyond the energy available, in any part of a contact: stored in tissue
 * and coupling, or put in by others.
 *
 * E_n is what the hand was given up to tick n of the contact, less what others than this hand and
 * the tissue put in meanwhile. U_n = S_n + F_n |p_n - x_n| is what may be given from then on: what
 * the tissue has stored, and what the coupling from pose x to proxy p holds at most (a spring half
 * of it, one that yields to the force limit all). From tick i to tick j a loop that makes nothing
 * gives no more than it had at i:
 *
 *   made = max (E_j - E_i - U_i), i <= j        = max (E_j - floor_j),
 *   floor_j = min (E_i + U_i), i <= j
 *
 * so the floor stands for all beginnings. It is a store that the hand fills and empties, and that
 * never holds more than the tissue and the coupling do: what the tissue swallowed excuses nothing.
 *
 * S comes late. What the hand does at tick n is in the tissue one step or two later, and a result
 * is told when its step is over; the force of tick n may still be that of the result before, for
 * offsets decay over milliseconds. S_n is therefore the largest of four results: the one before,
 * the one in use, and the two after. That is one number for all ticks of a result, which are kept
 * as a span and settled when the second result after has come:
 *
 *   low = min (E_i + F_i |p_i - x_i|),  top = max E_j,
 *   rise = max (E_j - E_i - F_i |p_i - x_i|), i <= j, all in the span
 *   made = max (rise - S, top - floor);  floor <- min (floor, low + S)
 *
 * Two spans are open at any time: a tick costs a few comparisons whatever the rates are.
 * Rejected: a delay line of ticks, as long as the slowest simulation is late (400 ticks a probe)
 * and searched at each; the work of tools in the model's energy balance, in which the forces are
 * the model's and not those that the hand felt.
 *
 * One probe. Thread: haptic; RT-safe. Start from zero.
 */
#include <stdbool.h>

/* What E is added up for: a device that acts on an answer at once, one that acts an answer later,
 * and one that has told what it did. */
enum { SS_SUPPLY_DEVICES = 3 };

/* The ticks of one result. */
typedef struct ss_supply_span {
    bool is_known; /* `stored` is */
    double stored; /* J, S as far as results have come */
    double low[SS_SUPPLY_DEVICES], top[SS_SUPPLY_DEVICES], rise[SS_SUPPLY_DEVICES]; /* J */
} ss_supply_span;

typedef struct ss_supply {
    bool is_known; /* `stored` is */
    double stored; /* J, of the newest result */
    bool has_floor;
    double energy[SS_SUPPLY_DEVICES], floor[SS_SUPPLY_DEVICES]; /* J, E */
    ss_supply_span span[2];                                     /* newest first */
} ss_supply;

/* No contact: what comes next begins with nothing. Returns what was made in spans that no further
 * result will settle, J. */
double ss_supply_clear(ss_supply *supply);
/* A result has come; `is_known`: its model told what is stored. Returns what was made in the span
 * that it settles, J. */
double ss_supply_take(ss_supply *supply, double stored, bool is_known);
/* A tick of a contact: what the devices were given in it, what others put in, and what the coupling
 * holds at its end, J. */
void ss_supply_tick(ss_supply *supply, const double given[SS_SUPPLY_DEVICES], double others,
                    double coupling);
