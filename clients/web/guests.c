/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "guests.h"

#include <libwebsockets.h>
#include <linux/tcp.h> /* of tcp_info netinet's has the beginning alone */
#include <netinet/in.h>
#include <sys/socket.h>
#include <time.h>

#include "softsim/client.h"

enum {
    GUESTS = 48,            /* at once */
    TAKING_NS = 2000000000, /* without a byte taken: no more */
    IDLE_TURNS = 256,       /* of the library, on end, in which nothing gets on: it goes round; */
    LOOK_TURNS = 16,        /* then these */
    LOOK_NS = 4000000       /* take so long at least */
};

static ss_guest *find_guest(ss_guests *guests, const struct lws *wsi)
{
    for (int32_t i = 0; i < guests->count; ++i) {
        if (guests->guest[i].wsi == wsi) {
            return &guests->guest[i];
        }
    }
    return NULL;
}

void ss_guests_add(ss_guests *guests, struct lws *wsi)
{
    if (guests->count < SS_GUESTS_CONNECTIONS) {
        guests->guest[guests->count++] = (ss_guest){.wsi = wsi, .seen_ns = softsim_client_now_ns()};
    }
}

void ss_guests_remove(ss_guests *guests, const struct lws *wsi)
{
    ss_guest *leaving = find_guest(guests, wsi);
    if (leaving != NULL) {
        *leaving = guests->guest[--guests->count];
    }
}

void ss_guests_note(ss_guests *guests, const struct lws *wsi)
{
    ss_guest *known = find_guest(guests, wsi);
    if (known != NULL) {
        known->seen_ns = softsim_client_now_ns();
    }
}

/* ---- who gives way ---- */

/* Is `a` to go before `b`? Who takes a file goes after all who do not, also after those who have
 * only just come. */
static bool goes_before(const ss_guest *a, const ss_guest *b, int64_t now_ns)
{
    const bool is_taking = now_ns - a->taken_ns < TAKING_NS;
    const bool is_other_taking = now_ns - b->taken_ns < TAKING_NS;
    return is_taking == is_other_taking ? a->seen_ns < b->seen_ns : is_other_taking;
}

static ss_guest *longest_idle(ss_guests *guests)
{
    const int64_t now_ns = softsim_client_now_ns();
    ss_guest *idle = &guests->guest[0];
    for (int32_t i = 1; i < guests->count; ++i) {
        idle = goes_before(&guests->guest[i], idle, now_ns) ? &guests->guest[i] : idle;
    }
    return idle;
}

/* Has it said something that was not looked at yet? */
static bool has_spoken(struct lws *wsi)
{
    char byte = 0;
    return recv(lws_get_socket_fd(wsi), &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

/* Who takes a file gets on, also on a link that is slower than the kernel's buffer. True where any
 * does. */
static bool note_takers(ss_guests *guests)
{
    bool is_any = false;
    for (int32_t i = 0; i < guests->count; ++i) {
        ss_guest *known = &guests->guest[i];
        struct tcp_info info = {.tcpi_bytes_acked = 0};
        socklen_t size = sizeof info;
        if (getsockopt(lws_get_socket_fd(known->wsi), IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
            info.tcpi_bytes_acked != known->taken) {
            known->taken = info.tcpi_bytes_acked;
            known->taken_ns = known->seen_ns = softsim_client_now_ns();
            is_any = true;
        }
    }
    return is_any;
}

/* The first time it is said goodbye to, and would have ten seconds to answer. One that is closing
 * already, as after a request that is none, stays at that: it goes at the library's next turn. */
static void send_away(ss_guests *guests, struct lws *wsi)
{
    for (int k = 0; k < 2 && find_guest(guests, wsi) != NULL; ++k) {
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_SYNC);
    }
    if (find_guest(guests, wsi) != NULL) {
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
        ss_guests_note(guests, wsi);
    }
}

/* At once: a library that has as many connections as it may (4.1.6) loses track of others. */
void ss_guests_make_room(ss_guests *guests)
{
    if (guests->count < GUESTS) {
        return;
    }
    (void)note_takers(guests);
    for (int32_t k = 0; k < guests->count && guests->count >= GUESTS; ++k) {
        struct lws *idle = longest_idle(guests)->wsi;
        if (has_spoken(idle)) {
            ss_guests_note(guests, idle);
        } else {
            send_away(guests, idle);
        }
    }
    if (guests->count >= GUESTS) { /* all have spoken */
        send_away(guests, longest_idle(guests)->wsi);
    }
}

/* ---- pacing ---- */

void ss_guests_note_progress(ss_guests *guests)
{
    guests->turns = 0;
}

/* The library (4.1.6) does not sleep while it waits for the end of a connection on which something
 * has come, or while requests that it has read wait behind a file that their asker does not take:
 * it would have the whole of a core for five seconds. After IDLE_TURNS in which nothing gets on it
 * has LOOK_TURNS in LOOK_NS. */
void ss_guests_pace(ss_guests *guests)
{
    if (++guests->turns < IDLE_TURNS) {
        return;
    }
    const int64_t left_ns = guests->looked_ns + LOOK_NS - softsim_client_now_ns();
    guests->turns = IDLE_TURNS - LOOK_TURNS;
    if (note_takers(guests)) {
        guests->turns = 0;
    } else if (left_ns > 0) {
        nanosleep(&(struct timespec){.tv_nsec = left_ns}, NULL);
    }
    guests->looked_ns = softsim_client_now_ns();
}
