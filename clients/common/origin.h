/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which server a message comes from. Two servers on one prefix answer every pose, each with the
 * force of a body of its own; mixed, they shake the hand. Servers are told by the address and port
 * that their packets come from, one pair a running server.
 *
 * The first that is heard is taken until it is silent; what another says is withheld. A server that
 * is started again is silent first and never speaks from its old port again: that the first, or
 * one that was taken before, speaks after another did, twice in two seconds, means that there are
 * two. Then nothing that either says is to be felt.
 *
 * Rejected: telling two servers by the numbers and times of their forces (a message that is lost,
 * late or repeated looks like another server's, and two that start together have the same numbers).
 * No clock in here: the caller gives the time. Thread: one.
 */
#include <stdbool.h>
#include <stdint.h>

/* What was last heard of one server. */
typedef struct ss_origin_server {
    uint64_t source;  /* address and port */
    int64_t heard_ns; /* 0: never */
    bool was_taken;   /* its messages were handed on */
} ss_origin_server;

/* Of one kind of message. Zero but for the parameter. */
typedef struct ss_origin {
    int64_t silent_ns; /* parameter: so long without the first server, and another is taken */
    ss_origin_server first, second;
    int32_t changes; /* times that another was taken in the place of the first */
    int32_t returns;
    int64_t return_ns; /* the last one; 0: none */
    int64_t two_ns;    /* when two were last known to speak; 0: never */
} ss_origin;

/* Is a message from `source` the first server's, to be handed on? */
bool ss_origin_take(ss_origin *origin, uint64_t source, int64_t now_ns);
/* Is it the first server, silent or not, or was none heard yet? Says nothing of who speaks. */
bool ss_origin_allows(const ss_origin *origin, uint64_t source);
/* Do two servers speak? */
bool ss_origin_hears_two(const ss_origin *origin, int64_t now_ns);
