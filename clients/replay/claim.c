/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "claim.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "process.h"

static const double hold_us = 500000.0;     /* a server's, after a sender's last pose */
static const int64_t ask_ns = 100000000;    /* between two questions */
enum { PATIENCE = 5, MOST_QUESTIONS = 50 }; /* without an answer; in all */

int32_t ss_claim_held(const ss_claim *claim)
{
    return claim->held != 0 ? __builtin_ctz(claim->held) : -1;
}

bool ss_claim_take_answer(ss_claim *claim, const softsim_force *force)
{
    if (force->pose_seq != 0) {
        return false;
    }
    const uint32_t bit = 1u << force->probe;
    claim->answered |= bit;
    if ((force->flags & SOFTSIM_FORCE_OTHER_SENDER) != 0) {
        claim->held |= bit;
    } else {
        claim->held &= ~bit;
    }
    return true;
}

/* The probes that the log begins with, and where. */
static void find_first(ss_claim *claim, softsim_poses *poses, double speed)
{
    softsim_pose_event event;
    char note[256]; /* said already, when the log was looked through */
    softsim_poses_result next;
    softsim_poses_rewind(poses);
    while ((next = softsim_poses_next(poses, &event, note, sizeof note)) != SOFTSIM_POSES_END) {
        if (next == SOFTSIM_POSES_NOTE) {
            continue;
        }
        if ((double)event.time_us > hold_us * speed) {
            break;
        }
        if ((claim->wanted >> event.channel_probe & 1) == 0) {
            claim->wanted |= 1u << event.channel_probe;
            claim->first[event.channel_probe] = event.pose;
        }
    }
}

/* Also of a probe that was given: who falls silent loses it again. */
static void ask(const ss_claim *claim, softsim_client *client)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if ((claim->wanted >> p & 1) != 0) {
            softsim_pose pose = claim->first[p];
            softsim_poses_restamp(&pose, softsim_client_sender(client), 0);
            pose.utime_us = softsim_client_now_us();
            pose.buttons = 0; /* what is grasped, the log grasps */
            softsim_client_send_pose(client, &pose, p);
        }
    }
}

static bool is_given(const ss_claim *claim)
{
    return claim->answered == claim->wanted && claim->held == 0;
}

bool ss_claim_wait(ss_claim *claim, softsim_client *client, softsim_poses *poses, double speed)
{
    bool is_told = false;
    find_first(claim, poses, speed);
    for (int question = 1; question <= MOST_QUESTIONS; ++question) {
        const int64_t deadline_ns = softsim_client_now_ns() + ask_ns;
        ask(claim, client);
        while (!is_given(claim) && !ss_process_is_stopped() &&
               softsim_client_now_ns() < deadline_ns) {
            if (softsim_client_wait(client, deadline_ns) < 0) {
                return false;
            }
        }
        if (is_given(claim) || ss_process_is_stopped() ||
            (claim->held == 0 && question >= PATIENCE)) {
            break;
        }
        if (claim->held != 0 && !is_told) {
            is_told = true;
            fprintf(stderr,
                    "softsim-replay: another sender holds probe %" PRId32
                    "; waits until it has let go, 5 s at most\n",
                    ss_claim_held(claim));
        }
    }
    return true;
}
