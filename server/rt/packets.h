/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Keeps fragmented LCM messages from LCM. */
#include <stdbool.h>
#include <stdint.h>

enum { SS_PACKETS_MAX_FD = 1024 };

/* The descriptors that were open before LCM opened its socket. */
typedef struct ss_packets_mark {
    bool is_open[SS_PACKETS_MAX_FD];
} ss_packets_mark;

/* Call right before the first subscription of an lcm_t, which is when LCM opens its socket.
 * Thread: set-up only, while no other thread opens descriptors. */
void ss_packets_remember(ss_packets_mark *out_mark);
/* Call right after it: every UDP socket bound since takes whole LCM messages only. Returns how many
 * sockets that were (memq:// has none), or -1 when the kernel refuses. Thread: set-up only. */
int ss_packets_refuse_fragments(const ss_packets_mark *mark);
