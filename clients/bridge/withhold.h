/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The share of the force that is kept from the hand, because it is not sure whose force it is.
 *
 * LCM has no authentication: whoever answers a bridge's first pose before the server does is taken
 * for it, until the server's own answers show that there are two, some periods later. A stranger
 * could exert what the device can, whatever limit the server holds, and be gone. So nothing is felt
 * until 40 ms after the first force no other has answered, in which a server that is there does so
 * forty times; then the force comes in 10 ms. A start loses nothing by it: a hand outside feels
 * nothing yet, and one inside is let in by the server in half a second. With one force of a second
 * server before that it takes 2 s without another: who holds the probe against the bridge makes the
 * server answer seldom. So it does for who is taken in the place of a server that fell silent,
 * which may have been stopped for a moment: 40 ms gave the hand .2 J of whoever lurked.
 *
 * While two are known to answer the force goes to zero in 20 ms, and comes back in 500 ms when one
 * is left: no hand shall feel now one body, now the other.
 *
 * Rejected: the source of the scene and the statuses that were heard before the first pose (they
 * can be forged as well, and a bridge with an offset of its own has heard none).
 * No clock in here: the caller gives the time. Thread: the bridge's loop.
 */
#include <stdbool.h>
#include <stdint.h>

/* What a client has heard so far. */
typedef struct ss_speakers {
    bool has_force;  /* that answers a pose of ours */
    bool are_two;    /* servers, now */
    int64_t second;  /* forces that answer us, of others than the one that is listened to */
    int32_t changes; /* times that another took its place */
} ss_speakers;

/* Zero: all of the force is felt. */
typedef struct ss_withholding {
    double share;           /* of the force that is kept back, 0 to 1 */
    double take_up_s;       /* from 1 to 0 */
    bool is_trusted;        /* who answers was alone long enough */
    bool was_second;        /* another answered before that: it takes 2 s */
    int64_t alone_since_ns; /* 0: no force yet */
    ss_speakers before;     /* as of the step before */
} ss_withholding;

/* Before the first pose. */
void ss_withholding_begin(ss_withholding *withholding);
/* One period; `is_felt` when a force was exerted in the one before. */
void ss_withholding_step(ss_withholding *withholding, const ss_speakers *heard, bool is_felt,
                         int64_t now_ns, double period_s);
/* Is all kept back since another answered too, though two are not known to now? */
bool ss_withholding_is_waiting(const ss_withholding *withholding);
