/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What net.c, publisher.c and the clients' connection share: opening LCM and checking names. Not
 * for the rest of server/. Tests need the LCM object because memq:// is private to it.
 */
#include <lcm/lcm.h>

#include "net/net.h"

enum {
    SS_WIRE_MAX_MESSAGE = 65000, /* bytes: one UDP packet, never a fragmented message */
    SS_WIRE_MAX_PREFIX = 40,     /* LCM allows 63 bytes a channel; ours append up to 14 */
    SS_WIRE_CHANNEL_SIZE = 64
};

/* Opens LCM after checking what it would abort or mumble about: the kind of url, the multicast
 * route, the receive buffer that the kernel allows. NULL with a line in `error` otherwise.
 * Thread: set-up only. */
lcm_t *ss_wire_open(const char *lcm_url, softsim_error *error);
/* False with a line in `error` when `prefix` cannot begin a channel name. Thread: set-up only. */
bool ss_wire_check_prefix(const char *prefix, softsim_error *error);

lcm_t *ss_net_lcm(ss_net *net);
lcm_t *ss_publisher_lcm(ss_publisher *publisher);
