/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "ticks.h"

#include "process.h"

static const int64_t ask_ns = 100000000; /* between two questions; statuses come twice as quick */
enum { MOST_QUESTIONS = 10 };

void ss_ticks_take_status(ss_ticks *ticks, const softsim_server_status *status)
{
    if (status->state_hash == 0) {
        return; /* of a server in real time */
    }
    ++ticks->statuses;
    ticks->count = status->poses_received - status->poses_refused[SOFTSIM_REFUSED_MALFORMED] -
                   status->poses_refused[SOFTSIM_REFUSED_TYPE_HASH];
}

bool ss_ticks_ask(ss_ticks *ticks, softsim_client *client)
{
    const int32_t wanted = ticks->statuses + 2; /* the first may have been on its way */
    for (int question = 0; question < MOST_QUESTIONS; ++question) {
        const int32_t heard = ticks->statuses;
        const int64_t deadline_ns = softsim_client_now_ns() + ask_ns;
        (void)softsim_client_send_command(client, "status", "");
        while (ticks->statuses == heard && !ss_process_is_stopped() &&
               softsim_client_now_ns() < deadline_ns) {
            if (softsim_client_wait(client, deadline_ns) < 0) {
                return false;
            }
        }
        if (ticks->statuses >= wanted || ss_process_is_stopped()) {
            break;
        }
    }
    return true;
}
