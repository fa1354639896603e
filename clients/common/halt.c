/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "halt.h"

#include <inttypes.h>

#include "process.h"
#include "rt/plain.h"

static const int64_t ask_ns = 100000000; /* between two questions */
/* One of the two may have been on its way when the first flag came. */
enum { CLEAR_STATUSES = 2, MOST_QUESTIONS = 10 };

static void note_pause(ss_halt *halt, int32_t probe)
{
    if (halt->pause_seq == 0) {
        halt->pause_seq = halt->ramping[probe].seq;
    }
    halt->pause_forces += halt->ramping[probe].count;
    halt->ramping[probe].count = 0;
}

void ss_halt_take_force(ss_halt *halt, const softsim_force *force, bool is_new)
{
    const int32_t others =
        SOFTSIM_FORCE_MODEL_FAULT | SOFTSIM_FORCE_STALE | SOFTSIM_FORCE_OTHER_SENDER;
    const bool is_ramping =
        (force->flags & SOFTSIM_FORCE_RAMPING) != 0 && (force->flags & others) == 0;
    if ((force->flags & SOFTSIM_FORCE_MODEL_FAULT) != 0 && (is_new || halt->fault_seq != 0)) {
        halt->fault_seq = halt->fault_seq != 0 ? halt->fault_seq : force->pose_seq;
        ++halt->fault_forces;
    }
    const int32_t p = force->probe;
    if (!is_ramping) {
        halt->ramping[p].seq = 0;
        halt->ramping[p].count = 0;
    } else if (is_new || halt->ramping[p].seq != 0) {
        halt->ramping[p].seq = halt->ramping[p].seq != 0 ? halt->ramping[p].seq : force->pose_seq;
        ++halt->ramping[p].count;
        if (halt->is_paused) {
            note_pause(halt, p);
        }
    }
}

void ss_halt_take_status(ss_halt *halt, const softsim_server_status *status)
{
    ++halt->statuses;
    halt->is_paused = (status->fault_bits & SOFTSIM_STATUS_PAUSED) != 0;
    for (int32_t p = 0; halt->is_paused && p < SOFTSIM_MAX_PROBES; ++p) {
        if (halt->ramping[p].seq != 0) {
            note_pause(halt, p);
        }
    }
    if (halt->fault_seq == 0) {
        return;
    }
    ++halt->statuses_since_fault;
    if (status->verdict == SOFTSIM_VERDICT_FAULT && !halt->is_fault_told) {
        halt->is_fault_told = true;
        snprintf(halt->reason, sizeof halt->reason, "%s", status->reason);
    }
}

bool ss_halt_is_seen(const ss_halt *halt)
{
    return halt->fault_seq != 0 || halt->pause_seq != 0;
}

bool ss_halt_is_clear(const ss_halt *halt)
{
    return halt->is_fault_told || halt->statuses_since_fault >= CLEAR_STATUSES;
}

/* No status has told a fault, though it could have. */
static bool is_late(const ss_halt *halt)
{
    return !halt->is_fault_told && halt->statuses_since_fault >= CLEAR_STATUSES;
}

const char *ss_halt_name(const ss_halt *halt)
{
    return is_late(halt) ? "late" : "at fault";
}

const char *ss_halt_cure(const ss_halt *halt)
{
    return is_late(halt) ? "leave the machine less to do, or take a coarser mesh"
                         : "`softsim-monitor --command reset`";
}

/* Might the last forces, or flag 64, be of what no status has told? */
static bool is_open(const ss_halt *halt)
{
    bool is_ramping = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        is_ramping = is_ramping || halt->ramping[p].count > 0;
    }
    return is_ramping || (halt->fault_seq != 0 && !ss_halt_is_clear(halt));
}

void ss_halt_ask(const ss_halt *halt, softsim_client *client)
{
    const int32_t enough = halt->statuses + CLEAR_STATUSES;
    for (int question = 0; question < MOST_QUESTIONS && is_open(halt) && halt->statuses < enough;
         ++question) {
        const int32_t heard = halt->statuses;
        const int64_t deadline_ns = softsim_client_now_ns() + ask_ns;
        (void)softsim_client_send_command(client, "status", "");
        while (halt->statuses == heard && softsim_client_now_ns() < deadline_ns) {
            if (softsim_client_wait(client, deadline_ns) < 0) {
                return;
            }
        }
    }
}

void ss_halt_print(const ss_halt *halt, FILE *out, const char *before)
{
    if (halt->fault_seq != 0) {
        const bool has_reason = halt->reason[0] != '\0';
        ss_plain_print(out,
                       "%sthe server's model is %s from pose %" PRId32 " on%s%s%s; %" PRId64
                       " forces are of it: %s\n",
                       before, ss_halt_name(halt), halt->fault_seq, has_reason ? " (" : "",
                       halt->reason, has_reason ? ")" : "", halt->fault_forces, ss_halt_cure(halt));
    }
    if (halt->pause_seq != 0) {
        ss_plain_print(out,
                       "%sthe server is paused from pose %" PRId32 " on; %" PRId64
                       " forces are of it: `softsim-monitor --command resume`\n",
                       before, halt->pause_seq, halt->pause_forces);
    }
}
