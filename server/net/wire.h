/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What net.c, publisher.c and the clients' connection share: opening LCM and checking names. Not
 * for the rest of server/. Tests need the LCM object because memq:// is private to it.
 */
#include <lcm/lcm.h>
#include <netinet/in.h>

#include "net/net.h"

enum {
    SS_WIRE_MAX_MESSAGE = 65000, /* bytes: one UDP packet, never a fragmented message */
    SS_WIRE_MAX_PREFIX = 40,     /* LCM allows 63 bytes a channel; ours append up to 14 */
    SS_WIRE_CHANNEL_SIZE = 64
};

/* What an LCM url says. */
typedef struct ss_wire_url {
    bool is_memq;
    struct sockaddr_in group;
    int ttl;    /* 0: this host only */
    int buffer; /* bytes, of recv_buf_size; 0: not given */
} ss_wire_url;
/* NULL or "": LCM_DEFAULT_URL, else local multicast. False with a line in `error` when the url is
 * not one that is served, in every part of it. Thread: set-up only. */
bool ss_wire_read_url(const char *lcm_url, ss_wire_url *out_url, softsim_error *error);
/* Opens LCM after checking what it would abort or mumble about: the url and the multicast route.
 * NULL with a line in `error` otherwise. Thread: set-up only. */
lcm_t *ss_wire_open(const char *lcm_url, softsim_error *error);
/* False with a line in `error` when `prefix` cannot begin a channel name. Thread: set-up only. */
bool ss_wire_check_prefix(const char *prefix, softsim_error *error);

/* A number that nobody else has, never 0: LCM itself names no source. Thread: set-up only. */
int64_t ss_wire_draw_sender(void);

lcm_t *ss_net_lcm(ss_net *net);
lcm_t *ss_publisher_lcm(ss_publisher *publisher);
