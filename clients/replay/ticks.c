/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "ticks.h"

#include "process.h"

static const int64_t ask_ns = 100000000; /* between two questions; statuses come twice as quick */
static const int64_t most_poses = INT64_C(1) << 53;
enum { MOST_QUESTIONS = 10, MOST_OF_ONE_HEARD = 50 };

void ss_ticks_take_force(ss_ticks *ticks, const softsim_force *force)
{
    ticks->answered_us = force->utime_us;
}

static bool is_count(int64_t number)
{
    return number >= 0 && number <= most_poses;
}

void ss_ticks_take_status(ss_ticks *ticks, const softsim_server_status *status)
{
    const int64_t received = status->poses_received,
                  malformed = status->poses_refused[SOFTSIM_REFUSED_MALFORMED],
                  other_type = status->poses_refused[SOFTSIM_REFUSED_TYPE_HASH];
    ++ticks->heard;
    ticks->is_real_time = status->state_hash == 0;
    if (ticks->is_real_time || !is_count(received) || !is_count(malformed) ||
        !is_count(other_type)) {
        return;
    }
    ++ticks->statuses;
    ticks->told_us = status->utime;
    ticks->count = received - malformed - other_type;
}

/* Before the first answer `wanted` statuses are: the first may have been on its way. */
static bool is_new(const ss_ticks *ticks, int32_t wanted)
{
    return ticks->answered_us == 0 ? ticks->statuses >= wanted
                                   : ticks->statuses > 0 && ticks->told_us > ticks->answered_us;
}

bool ss_ticks_ask(ss_ticks *ticks, softsim_client *client)
{
    bool is_connected = softsim_client_wait(client, softsim_client_now_ns()) >= 0;
    const int32_t wanted = ticks->statuses + 2;
    ticks->is_counted = false;
    ticks->is_real_time = false;
    for (int question = 0; is_connected && !ticks->is_counted && !ticks->is_real_time &&
                           question < (ticks->statuses > 0 ? MOST_OF_ONE_HEARD : MOST_QUESTIONS) &&
                           !ss_process_is_stopped();
         ++question) {
        const int32_t heard = ticks->heard;
        const int64_t deadline_ns = softsim_client_now_ns() + ask_ns;
        (void)softsim_client_send_command(client, "status", "");
        while (is_connected && ticks->heard == heard && !ss_process_is_stopped() &&
               softsim_client_now_ns() < deadline_ns) {
            is_connected = softsim_client_wait(client, deadline_ns) >= 0;
        }
        ticks->is_counted = is_new(ticks, wanted);
    }
    return is_connected;
}
