/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Guests: connections that are no browser's WebSocket. They have sent no request yet, or half of
 * one, or take a file.
 *
 *   a connection comes -> make_room, add -> note: it got on -> remove: it went, or is a browser now
 *
 * libwebsockets (4.1.6) has a fixed number of connections, and drops new ones when all are taken.
 * It gives a silent one ten seconds, so that a hundred silent ones would keep everybody out. Here a
 * new guest gets the place of the one that has been idle for longest; those who take a file are
 * sent away last, also on a slow link.
 *
 * The library also goes round without sleeping while something that was received stays unread. Then
 * ss_guests_pace sleeps in its place.
 *
 * Rejected: a limit for each address (behind a tunnel all browsers have the same one), shorter
 * timeouts (a slow link needs them, and a flood comes faster), to cut off whatever makes the
 * library spin (a client that half-closes after its request still reads the answer). Thread: main,
 * between or inside the library's turns.
 */
#include <stdbool.h>
#include <stdint.h>

struct lws;

enum { SS_GUESTS_CONNECTIONS = 128 }; /* that the library has room for, browsers among them */

typedef struct ss_guest {
    struct lws *wsi;
    int64_t seen_ns;  /* when it last got on */
    uint64_t taken;   /* bytes that it had taken at the last look, */
    int64_t taken_ns; /* and when it was first seen to have */
} ss_guest;

/* Zero at first; holds no memory. */
typedef struct ss_guests {
    ss_guest guest[SS_GUESTS_CONNECTIONS];
    int32_t count;
    int32_t turns;     /* of the library in which nothing was seen to get on */
    int64_t looked_ns; /* at whether anything did */
} ss_guests;

/* Before a new one comes: sends others away where there are too many. Closes connections, whose
 * ss_guests_remove runs within this call. */
void ss_guests_make_room(ss_guests *guests);
void ss_guests_add(ss_guests *guests, struct lws *wsi);
/* It is closed, or a browser's WebSocket from now on. Does nothing with one that is no guest. */
void ss_guests_remove(ss_guests *guests, const struct lws *wsi);
/* It has sent all of a request, or taken a piece of a file. */
void ss_guests_note(ss_guests *guests, const struct lws *wsi);
/* Something got on, of a guest or of a browser: the library's next turns are not slowed down. */
void ss_guests_note_progress(ss_guests *guests);
/* Before each turn of the library: sleeps up to 4 ms when many turns have brought nothing. */
void ss_guests_pace(ss_guests *guests);
