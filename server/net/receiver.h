/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Receives LCM messages: for the server, its clients and the latency report. Whatever comes in is
 * handed over as it is, bounded but not judged, with the address that it came from.
 */
#include <lcm/lcm.h>
#include <stdbool.h>
#include <stdint.h>

#include "net/filter.h"
#include "softsim/types.h"

enum { SS_RECEIVER_MAX_LANES = 8 };

/* One message, valid during the call. */
typedef struct ss_packet {
    const char *channel;
    const uint8_t *data;
    int32_t size;
    int32_t name;    /* which of the lane's names it is */
    int32_t digit;   /* what stands for its '#', else -1 */
    uint64_t source; /* IPv4 address and port of the sender; 0 in memq:// */
} ss_packet;

/* What shares a queue in the kernel and a budget, so that a flood here starves no other lane. */
typedef struct ss_lane {
    const char
        *suffix[SS_FILTER_MAX_NAMES]; /* channels behind the prefix: "_PROBE_#"; up to NULL */
    ss_filter_part part;              /* what its messages have, where two lanes share a channel */
    int32_t max_size;      /* bytes, as many as any good message has; a longer one is dropped */
    int32_t buffer;        /* bytes in the kernel, where the url does not say */
    int32_t per_ms, burst; /* units of work a millisecond, and at once after a pause: a message
                              costs one and its share of a wake-up, see receiver.c */
    /* Messages of one sender in about a second, fewer where many speak (senders.h); who sends more
     * is muted. 0: as many as it likes. */
    int32_t sender_per_s;
    const uint64_t *followed; /* the sender that is never muted, whoever it is by then; or NULL */
    void (*receive)(void *context, const ss_packet *packet);
} ss_lane;

typedef struct ss_receiver_config {
    const char *lcm_url; /* as ss_wire_open takes it */
    lcm_t *lcm;          /* what that opened: sends the self test; memq:// receives by it */
    const char *prefix;  /* checked by ss_wire_check_prefix */
    const ss_lane *lane;
    int32_t lane_count;
    void *context; /* handed to `receive` */
} ss_receiver_config;

typedef struct ss_receiver ss_receiver;

/* Joins the group and proves by a message to itself that one comes through. The error says what to
 * do. Thread: set-up only. */
softsim_status ss_receiver_open(const ss_receiver_config *config, ss_receiver **out_receiver,
                                softsim_error *error);
/* Accepts NULL; nulls. */
void ss_receiver_close(ss_receiver **receiver);
/* Waits until `deadline_ns` of the monotonic clock for a message or a signal on `wake_fd` (-1:
 * none), and hands over what is there, as far as the budget goes. A signal there is drained and
 * lets one more batch be read; a second one ends the call and stays. Returns how many messages
 * were handed over, -1 when the socket or the wait is broken. Thread: one, always the same. */
int32_t ss_receiver_wait(ss_receiver *receiver, int wake_fd, int64_t deadline_ns);

/* A datagram as a message of `lane`: false when it is not one, or of no such channel. Touches
 * nothing beyond `size`. For ss_receiver_wait and its tests. RT-safe. */
bool ss_receiver_parse(const ss_lane *lane, const char *prefix, const uint8_t *datagram,
                       int32_t size, ss_packet *out_packet);
