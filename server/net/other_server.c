/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Two servers on one prefix answer every pose twice, each with the force of a body of its own: only
 * one may stay, and both must find the same one, though each knows the other by its statuses alone.
 *
 * The elder stays. A status says how long its server has been up; a delay d on the way makes the
 * other look younger by d, so that who looks older by more than a margin m is older. Within the
 * margin the instants of both starts decide, utime - uptime on the clocks of either: the same two
 * numbers on both sides, hence the same answer, and on one host the true order.
 *     A sees B older by D - d > m        -> B sees A younger by D + d: only A gives way
 *     |D - d| <= m, the starts say B     -> B sees the same starts, or A younger by more than m
 * When the starts contradict the uptimes (two hosts, long delays) nobody gives way until a status
 * comes sooner.
 *
 * Rejected: the lower sender number (a server that has been felt for an hour would go), locks in
 * the file system (another host, another user), a token on the wire (one more message type).
 */
#include <math.h>

#include "net/net.h"

static const int64_t LASTING_NS = 300000000; /* longer than the period of statuses */
static const int64_t GONE_NS = 1000000000;   /* four statuses missed */
static const int64_t SAME_START_US = 1000;   /* statuses of one server agree to rounding */
static const double MARGIN_S = 1.0;          /* more than a status takes */

/* us of the sender's clock; a hostile utime may wrap. */
static int64_t start_of(const ss_net_status *status)
{
    return (int64_t)((uint64_t)status->utime_us - (uint64_t)llround(1e6 * status->uptime_s));
}

void ss_other_server_hear(ss_other_server *other, const ss_net_status *status, int64_t now_ns)
{
    const int64_t apart_us =
        (int64_t)((uint64_t)start_of(status) - (uint64_t)start_of(&other->status));
    const bool is_heard = other->last_ns != 0 && now_ns - other->last_ns <= GONE_NS;
    if (!is_heard) {
        other->first_ns = now_ns;
    } else if (apart_us > SAME_START_US || apart_us < -SAME_START_US) {
        return; /* one after the other */
    }
    other->last_ns = now_ns;
    other->status = *status;
}

bool ss_other_server_is_alive(const ss_other_server *other, int64_t now_ns)
{
    return other->last_ns - other->first_ns >= LASTING_NS && now_ns - other->last_ns <= GONE_NS;
}

bool ss_other_server_is_senior(const ss_other_server *other, double uptime_s, int64_t start_us)
{
    const double older_s = other->status.uptime_s - uptime_s;
    return older_s > MARGIN_S || (older_s >= -MARGIN_S && start_of(&other->status) < start_us);
}
