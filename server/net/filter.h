/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which datagrams the kernel lets into a socket of ours: a classic BPF program. Thread: not a
 * real-time loop's.
 */
#include <stdbool.h>
#include <stdint.h>

enum { SS_FILTER_MAX_NAMES = 4, SS_FILTER_MAX_PART = 16, SS_FILTER_MAX_MUTED = 192 };

/* What a message of one lane has at a place and that of another has not. */
typedef struct ss_filter_part {
    uint32_t at; /* byte of the message, behind the NUL of its channel */
    const void *bytes;
    uint32_t size;    /* at most SS_FILTER_MAX_PART; 0: whatever is there passes */
    bool is_unwanted; /* all pass but what has it */
} ss_filter_part;

typedef struct ss_filter {
    bool is_local; /* only what never left this host */
    /* IPv4 address << 16 | port, ascending: nothing of theirs. At most SS_FILTER_MAX_MUTED. */
    uint64_t muted[SS_FILTER_MAX_MUTED];
    int32_t muted_count;
    /* Channels; '#' stands for one digit 0 to 7. At most SS_FILTER_MAX_NAMES, each shorter than 64
     * bytes. */
    const char *const *names;
    int32_t name_count;
    ss_filter_part part;
    uint32_t longest; /* bytes of a message, behind its channel's NUL; longer ones are dropped */
} ss_filter;

/* Attaches the filter to a UDP socket, in place of the one that it has. Where it is not bound yet,
 * nothing can be there that has not passed it. False when the kernel refuses, with errno. */
bool ss_filter_attach(const ss_filter *filter, int fd);
