/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * HTTP and WebSocket for browsers, by libwebsockets, in the main thread.
 *
 *   GET /, /app.js, /app.css, /favicon.svg   the page, built into the program
 *   GET /recordings/NAME                     a recording of this run
 *   GET /ws                                  the WebSocket (hub.h says what it carries)
 *
 * A browser sends lines of text, at most 512 bytes each and 400 a second; who sends more, or what
 * is none of these, is disconnected:
 *   command NAME[ ARGUMENT]               any but shutdown, which is refused
 *   aim PROBE X Y Z QW QX QY QZ GRASP     m, unit quaternion, 0 or 1
 *   drop
 *   record 0 | record 1
 *
 * Any page of the web may ask a browser to connect here, so an origin that is not ours is refused
 * (403), and on loopback a Host that does not name this machine too, since a name of an attacker's
 * may be made to resolve to it. The address that is listened to is a name of this machine, and a
 * page of ours comes by http: nothing is encrypted here. With a token, everything but the token's
 * own address (/?token=T, /ws?token=T) is refused; beyond loopback there has to be one. At most 32
 * browsers: the one that has said nothing for longest gives way to the next, and is told so (the
 * WebSocket closes with 4000); one that does not answer a ping in 20 s is gone. Of other
 * connections 48: a new one has the place of the one that has not got on for longest, so that
 * silent ones keep nobody out.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "hub.h"

typedef struct ss_serve ss_serve;

typedef struct ss_serve_config {
    const char *host;  /* an IPv4 address of this machine */
    int32_t port;      /* 0: a free one */
    const char *token; /* NULL: none */
} ss_serve_config;

/* Listens. The hub may be opened later: until ss_serve_attach nobody is served. */
softsim_status ss_serve_open(const ss_serve_config *config, ss_serve **out_serve,
                             softsim_error *error);
void ss_serve_close(ss_serve **serve);
void ss_serve_attach(ss_serve *serve, ss_hub *hub);
/* That it listens on. */
int32_t ss_serve_port(const ss_serve *serve);
/* Serves until something has been done, or a wake-up. False when the library has failed. */
bool ss_serve_run(ss_serve *serve);
/* Ends a wait in ss_serve_run, and sends browsers what is new. Thread: any; the context is the
 * ss_serve. */
void ss_serve_wake(void *context);

/* One file of the page. */
typedef struct ss_page_file {
    const char *path, *type;
    const unsigned char *begin, *end;
} ss_page_file;
/* NULL: there is no such file. Thread: any. */
const ss_page_file *ss_page_find(const char *path);
