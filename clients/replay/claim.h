/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The wait for the probes of a log, in real time: another sender that holds one keeps it until half
 * a second after its last pose, and what is sent there meanwhile is refused.
 *
 * Before the log begins, its first pose of each probe is sent with the number 0, ten times a second
 * (as often as a server tells who is refused), until the answer is no refusal: so the probe is this
 * client's. The log's own poses are numbered from 1; what answers 0 is none of its forces. A server
 * that does not answer is not waited for, and a probe that the log takes up later than such a hold
 * lasts is not asked for: who was there before has let go by then.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "softsim/client.h"
#include "softsim/log.h"

typedef struct ss_claim {
    softsim_pose first[SOFTSIM_MAX_PROBES]; /* of the log, by channel */
    uint32_t wanted, answered, held;        /* probes, a bit each; held: by another sender */
} ss_claim;

/* Waits until no other sender holds a probe that the log `poses`, played `speed` times as fast as
 * recorded, begins with; says so once. 5 s at most: ss_claim_held tells whether that was too short.
 * A signal ends it. False when LCM is broken. */
bool ss_claim_wait(ss_claim *claim, softsim_client *client, softsim_poses *poses, double speed);
/* Is it the answer to what was asked, and no force of the log? */
bool ss_claim_take_answer(ss_claim *claim, const softsim_force *force);
/* The first probe that another sender holds, as the last answers say; -1: none. */
int32_t ss_claim_held(const ss_claim *claim);
