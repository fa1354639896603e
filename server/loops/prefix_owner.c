/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "loops/prefix_owner.h"

#include "rt/clock.h"

static const int64_t LISTEN_NS = 300000000;   /* statuses come every 250 ms, asked or not */
static const int64_t CONFIRM_NS = 1300000000; /* from its first status until it is here to stay */
static const int64_t ASK_NS = 100000000;
static const int64_t SILENT_NS = 600000000; /* after its shutdown: two statuses missed */
static const int64_t TAKEOVER_NS = 3000000000;
static const int64_t TELL_NS = 1000000000; /* between two commands to shut down */
static const int64_t HELD_NS = 1000000000; /* a client that has been silent for longer has left */
static const int64_t AHEAD_NS = 500000000; /* of the other's first status: two of them */
static const double YOUNG_S = 10.0;

/* Handles what comes until `until_ns`, asking for statuses as it goes. False when LCM is broken. */
static bool listen_until(ss_net *net, int64_t until_ns, int64_t *next_ask_ns)
{
    const int64_t now_ns = ss_clock_now_ns();
    if (now_ns >= *next_ask_ns) {
        *next_ask_ns = now_ns + ASK_NS;
        ss_net_send_command(net, "status");
    }
    const int64_t end_ns = until_ns < *next_ask_ns ? until_ns : *next_ask_ns;
    const int64_t wait_ms = (end_ns - now_ns) / 1000000 + 1;
    return ss_net_wait(net, -1, wait_ms > 0 ? (int)wait_ms : 0);
}

/* Is there another server? False when LCM is broken. */
static bool find_other_server(ss_net *net, bool *out_is_alive)
{
    const ss_other_server *other = ss_net_other_server(net);
    const int64_t start_ns = ss_clock_now_ns();
    const int64_t latest_ns = start_ns + LISTEN_NS + CONFIRM_NS; /* whoever speaks how often */
    int64_t next_ask_ns = start_ns;
    for (;;) {
        const int64_t now_ns = ss_clock_now_ns();
        const int64_t confirmed_ns = other->first_ns + CONFIRM_NS;
        const int64_t until_ns = other->last_ns == 0        ? start_ns + LISTEN_NS
                                 : confirmed_ns < latest_ns ? confirmed_ns
                                                            : latest_ns;
        *out_is_alive = ss_other_server_is_alive(other, now_ns);
        if (*out_is_alive || now_ns >= until_ns) {
            return true;
        }
        if (!listen_until(net, until_ns, &next_ask_ns)) {
            return false;
        }
    }
}

/* Tells the other server to shut down until it is silent, or for some time. */
static bool take_over(ss_net *net)
{
    const ss_other_server *other = ss_net_other_server(net);
    const int64_t start_ns = ss_clock_now_ns();
    int64_t next_ask_ns = start_ns, next_tell_ns = start_ns;
    for (;;) {
        const int64_t now_ns = ss_clock_now_ns();
        const int64_t silent_from_ns = other->last_ns > start_ns ? other->last_ns : start_ns;
        if (now_ns - silent_from_ns > SILENT_NS) {
            ss_net_forget_other_server(net);
            return true;
        }
        if (now_ns - start_ns > TAKEOVER_NS) {
            return true;
        }
        if (now_ns >= next_tell_ns) {
            next_tell_ns = now_ns + TELL_NS;
            ss_net_send_command(net, "shutdown");
        }
        if (!listen_until(net, now_ns + ASK_NS, &next_ask_ns)) {
            return false;
        }
    }
}

softsim_status ss_prefix_owner_claim(ss_net *net, const ss_options *options, softsim_error *error)
{
    bool is_taken = false;
    bool is_good = find_other_server(net, &is_taken);
    if (is_good && is_taken && options->takeover) {
        is_good = take_over(net);
    } else if (is_good && is_taken) {
        const ss_net_status *first = &ss_net_other_server(net)->status;
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "another server answers on prefix %s: %.400s, up %.1f s; stop it, give "
                          "this one another --prefix, or replace it with --takeover",
                          options->prefix, first->scene, first->uptime_s);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM stopped working; check the network and start again");
        return SOFTSIM_ERROR_NETWORK;
    }
    return SOFTSIM_OK;
}

void ss_prefix_owner_note_early(ss_prefix_owner *owner, int32_t probe, const softsim_pose *pose)
{
    if (probe < 0 || probe >= SOFTSIM_MAX_PROBES) {
        return;
    }
    owner->hand[probe].has_early = true;
    owner->hand[probe].early_sender = pose->sender;
}

void ss_prefix_owner_note_pose(ss_prefix_owner *owner, int32_t probe, const softsim_pose *pose,
                               int64_t now_ns)
{
    if (probe < 0 || probe >= SOFTSIM_MAX_PROBES) {
        return;
    }
    ss_prefix_hand *hand = &owner->hand[probe];
    if (hand->seen_ns == 0 || hand->sender != pose->sender) {
        hand->sender = pose->sender;
        hand->first_ns = now_ns;
        hand->is_from_other =
            pose->force_seq > 0 || (hand->has_early && hand->early_sender == pose->sender);
    }
    hand->seen_ns = now_ns;
}

/* Is there a client that no other server has served? */
static bool is_held(const ss_prefix_owner *owner, const ss_other_server *other, int64_t now_ns)
{
    bool is_any = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const ss_prefix_hand *hand = &owner->hand[p];
        is_any = is_any || (hand->seen_ns != 0 && now_ns - hand->seen_ns <= HELD_NS &&
                            !hand->is_from_other && other->first_ns - hand->first_ns >= AHEAD_NS);
    }
    return is_any;
}

ss_prefix_verdict ss_prefix_owner_judge(const ss_prefix_owner *owner, const ss_other_server *other,
                                        bool is_takeover, int64_t now_ns)
{
    const double uptime_s = 1e-6 * (double)(now_ns / 1000 - owner->start_us);
    if (uptime_s > YOUNG_S || !ss_other_server_is_alive(other, now_ns) ||
        !ss_other_server_is_senior(other, uptime_s, owner->start_us)) {
        return SS_PREFIX_STAY;
    }
    return is_takeover                     ? SS_PREFIX_TELL
           : is_held(owner, other, now_ns) ? SS_PREFIX_STAY /* stderr_report.c warns */
                                           : SS_PREFIX_GIVE_WAY;
}

bool ss_prefix_owner_hold(ss_prefix_owner *owner, ss_net *net, const ss_options *options,
                          softsim_error *error)
{
    const ss_other_server *other = ss_net_other_server(net);
    const int64_t now_ns = ss_clock_now_ns();
    switch (ss_prefix_owner_judge(owner, other, options->takeover, now_ns)) {
    case SS_PREFIX_TELL:
        if (now_ns >= owner->next_shutdown_ns) {
            owner->next_shutdown_ns = now_ns + TELL_NS;
            ss_net_send_command(net, "shutdown");
        }
        return true;
    case SS_PREFIX_GIVE_WAY:
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "gives way to the server that was first on prefix %s: %.400s, up %.1f s; "
                          "stop it, give this one another --prefix, or replace it with --takeover",
                          options->prefix, other->status.scene, other->status.uptime_s);
        return false;
    default:
        return true;
    }
}
